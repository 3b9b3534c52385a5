//! A channel's reference, and what becomes of it at the pins (RM0433 38.3.10 to 38.3.17, tables 329
//! and 330).
//!
//! In: the counter, mode and enable bits, the main output enable. Out: the levels of output and
//! complementary output; `None` where the timer does not drive the pin.

/// An output-compare channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Channel {
    /// CCR as written.
    pub preload: u32,
    /// CCR in force.
    pub compare: u32,
    /// CCxE, CCxP, CCxNE, CCxNP.
    pub enables: u32,
    /// It has met the counter in this cycle.
    pub matched: bool,
    /// OCxREF.
    pub reference: bool,
    /// CCMR's byte for this channel, and the fourth bit of its mode above it.
    bits: u32,
}

impl Channel {
    /// Its part of CCMR; the mode's fourth bit lies 16 above its byte.
    pub fn mode_bits(&self) -> u32 {
        self.bits
    }

    /// Sets that.
    pub fn set_mode(&mut self, bits: u32) {
        self.bits = bits & 0x1_00ff;
    }

    /// It is an input and on.
    pub fn captures(&self) -> bool {
        self.bits & 3 != 0 && self.enables & 1 != 0
    }

    /// CCxS: it is an input.
    pub fn is_input(&self) -> bool {
        self.bits & 3 != 0
    }

    /// Its own input: CCxS 01, no prescaler; filters are not modelled; the edges by CCxP and CCxNP
    /// (RM0433 39.4.11).
    pub fn captures_own(&self) -> bool {
        self.bits & 0xf == 1
    }

    /// Whether this change of its input is captured.
    pub fn takes(&self, before: bool, level: bool) -> bool {
        let edge = match (self.enables >> 1 & 1, self.enables >> 3 & 1) {
            (0, _) => level,
            (1, 0) => !level,
            _ => true,
        };
        self.captures() && before != level && edge
    }

    /// Every rising edge of its own input: CCxS 01, no prescaler; CCxP and CCxNP 0.
    pub fn captures_rising(&self) -> bool {
        self.bits & 0xf == 1 && self.enables & 0xe == 0
    }

    /// OCxPE.
    pub fn is_preloaded(&self) -> bool {
        self.bits & 1 << 3 != 0
    }

    fn mode(&self) -> u32 {
        self.bits >> 4 & 7 | self.bits >> 13 & 8
    }

    /// What follows from the counter alone.
    pub fn look(&mut self, count: u32) {
        match self.mode() {
            4 => self.reference = false,
            5 => self.reference = true,
            6 | 12 => self.reference = count < self.compare,
            7 | 13 => self.reference = count >= self.compare,
            _ => {}
        }
    }

    /// OCxREFC: in the combined PWM modes with the reference of the other channel of the pair.
    pub fn combined(&self, other: bool) -> bool {
        match self.mode() {
            12 => self.reference || other,
            13 => self.reference && other,
            _ => self.reference,
        }
    }

    /// Whether its mode is one that is modelled.
    pub fn is_modelled(&self) -> bool {
        matches!(self.mode(), 0..=7 | 12 | 13)
    }

    /// The counter has met it.
    pub fn meet(&mut self) {
        match self.mode() {
            1 => self.reference = true,
            2 => self.reference = false,
            3 => self.reference = !self.reference,
            _ => {}
        }
    }
}

/// BDTR and the break input.
#[derive(Debug, Clone, Copy, Default)]
pub struct Break {
    /// The register.
    pub bdtr: u32,
    /// The input pin's level.
    pub input: bool,
    /// The clock's guard breaks (RM0433 38.3.16): no switch of the timer's keeps it out.
    pub clock_lost: bool,
    /// So does the supply, or the core (RM0433 12.3.6).
    pub of_chip: bool,
}

impl Break {
    /// Main output enable.
    pub const MOE: u32 = 1 << 15;

    /// Whether the input acts (BKP, and BKINP of AF1): by its level, so that its flag cannot be
    /// cleared meanwhile (RM0433 38.4.5).
    pub fn is_broken(&self, af1: u32, is_odd: bool) -> bool {
        let connected = af1 & 1 != 0;
        let high = self.input != ((af1 & 1 << 9 != 0) != is_odd);
        self.is_on() && connected && high == (self.bdtr & 1 << 13 != 0)
    }

    /// Whether the chip breaks.
    pub fn is_broken_by_chip(&self) -> bool {
        self.is_on() && (self.clock_lost || self.of_chip)
    }

    fn is_on(&self) -> bool {
        self.bdtr & 1 << 12 != 0
    }

    /// Levels of output and complementary output for CCER's bits of a channel. `idle` holds OISx
    /// and OISxN.
    pub fn levels(&self, enables: u32, reference: bool, advanced: bool, idle: u32, settles: bool) -> [Option<bool>; 2] {
        let bit = |n: u32| enables & 1 << n != 0;
        let (on, low, on_n, low_n) = (bit(0), bit(1), bit(2), bit(3));
        if !advanced {
            return [on.then_some(reference != low), None];
        }
        let off_state = |register: u32| self.bdtr & 1 << register != 0;
        if self.bdtr & Break::MOE == 0 {
            // OSSI: driven at the idle state, if anything of the channel is on.
            if !off_state(10) || !(on || on_n) {
                return [None, None];
            }
            if settles {
                return [Some(low), Some(low_n)];
            }
            return [Some(idle & 1 != 0), Some(idle & 2 != 0)];
        }
        match (on, on_n) {
            (false, false) => [None, None],
            // OSSR: the one that is off is driven inactive.
            (true, false) => [Some(reference != low), off_state(11).then_some(low_n)],
            (false, true) => [off_state(11).then_some(low), Some(reference != low_n)],
            (true, true) => [Some(reference != low), Some(reference == low_n)],
        }
    }
}
