//! One entry of a FIFO: checked, packed into 24 bytes, and what is read from it.
//!
//! In: the bits of the user's doubles, types, the entries before. Out: an [`FollowEntry`], which
//! only these checks can make, and the [`FollowChain`] after it. Fails: with the rule that the
//! datum breaks, [`Refused`].
//!
//! Besides the two end positions, a segment holds the slave's displacement at its start ratio,
//! r₀·M, as the chain of ratios gives it. So the tick can enter any segment from either side. The
//! chain does not know the ratio with which a FIFO goes on after another, or after a SwitchNow.
//! That runs on with changing sign until an EVEN or STOP: an entry says how far back this is.
use super::compact::{Compact, HIGH_BITS, NoNumber};
use super::ratio::{RATIO_BITS, quotient, start_displacement};
use super::{Direction, Method};
use crate::units::{DoGroup, Pos};

/// Entries of a FIFO at most (memory 1).
pub const ENTRIES: u32 = 512;
/// Entries of a FIFO that are no segments, at most.
pub const STOPS: usize = 16;
/// The largest |ratio|: 2⁴⁴.
const RATIO_MAX_RAW: i128 = 1 << (44 + super::ratio::RATIO_BITS);
/// The largest displacement at a segment's start ratio: that from 0 to the edge of travel.
const START_DISPLACEMENT_MAX_EXACT: i128 = (Pos::TRAVEL_PULSES as i128) << 64;
/// The shortest segment: 2⁻²⁰ pulse of the master.
const SEGMENT_MIN_EXACT: i128 = 1 << (64 - 20);
/// The distance to the head of a chain is stored up to this; there the search goes on from the
/// entry reached.
pub(super) const CHAIN_MAX_ENTRIES: u32 = 31;

/// An admitted entry, 24 bytes. Words 0, 1: end of the master, compact, with distance to the head
/// of its chain (bits 26–30) and parity in it. Words 2, 3: end of the slave, compact, its sign (bit
/// 26), percent, low (27–31). Words 4, 5: r₀·M as mantissa (53 bits), exponent (6), sign; type
/// (bits 28–29), percent, high (30–31). A part of an asymmetric S has the type of STOP and a
/// percent above 100. An entry that is no segment has type 3, its kind in percent, a number in word
/// 4 and the rest in word 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FollowEntry([u32; 6]);

/// Why a datum is refused: the parameter, and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// The master's position is NaN or infinite.
    MasterNotFinite,
    /// The slave's position is NaN or infinite.
    SlaveNotFinite,
    /// |master position| above 2³¹ pulses.
    MasterBeyondRange,
    /// |slave position| above 2⁴⁰ pulses.
    SlaveBeyondTravel,
    /// The master's position does not go on in the direction of the FIFO's first one by 2⁻²⁰ pulse
    /// or more.
    NotAdvancing,
    /// A negative master position where only positive ones are allowed.
    Negative,
    /// The segment type is none of 0…3.
    Kind,
    /// Percent is not in 0…100.
    Percent,
    /// A ratio at an end of the segment is above 2⁴⁴.
    TooSteep,
    /// At its start ratio the segment would be longer than 2⁴⁰ pulses.
    TooFar,
    /// The FIFO holds [`STOPS`] entries that are no segments.
    StopsFull,
    /// The FIFO holds [`ENTRIES`] entries.
    Full,
}

/// The input that a wait reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Input {
    /// Positive limit switch of an axis.
    LimitPositive = 0,
    /// Negative limit switch of an axis.
    LimitNegative = 1,
    /// Drive alarm of an axis.
    Alarm = 2,
    /// Home switch of an axis.
    Home = 3,
    /// Arrival signal of an axis.
    Arrive = 4,
    /// General input.
    General = 5,
}

impl Input {
    /// From its number, of which the low three bits count.
    pub const fn of_bits(bits: u8) -> Input {
        match bits & 7 {
            0 => Input::LimitPositive,
            1 => Input::LimitNegative,
            2 => Input::Alarm,
            3 => Input::Home,
            4 => Input::Arrive,
            _ => Input::General,
        }
    }
}

/// The ratio within a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FollowEntryKind {
    /// From the end ratio of the segment before to 2P/M minus it.
    Normal,
    /// P/M throughout.
    Even,
    /// From 2P/M to 0.
    Stop,
    /// One of an asymmetric S.
    Part(SCurvePart),
}

/// A part of an asymmetric S (FollowDataPercent2Ex): its displacement and the ratio at its start
/// decide it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SCurvePart {
    /// The slope of the ratio grows from 0.
    Rise,
    /// It holds.
    Constant,
    /// It falls to 0.
    Fall,
}

/// What an entry that is no segment does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum QueueEntry {
    Output {
        group: DoGroup,
        bit: u8,
        high: bool,
    },
    /// Cycles of 250 µs.
    Delay {
        cycles: u32,
    },
    /// Time-out in ms, 0 for none.
    Wait {
        input: Input,
        index: u8,
        high: bool,
        timeout_ms: u32,
    },
    Switch(Method),
}

/// What admission needs of the entries before in the same FIFO. Default is an empty FIFO.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FollowChain {
    /// Ends of master (its magnitude) and slave, 2⁻⁶⁴ pulse.
    master: i128,
    slave: i128,
    /// Words of them.
    ends: [u32; 4],
    /// Segments, and entries that are not.
    segments: u16,
    pub(crate) stops: u16,
    /// Entries back to the head of the chain of ratios, and whether the number of segments is odd.
    back: u16,
    odd: bool,
    tail: FifoTail,
}

/// What the tick needs of a FIFO besides its entries; part of the commit of its last entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FifoTail {
    /// End ratio of the last segment, 2⁻⁸⁰.
    pub(super) ratio: i128,
    /// The master's positions are negative: progress downwards.
    pub(super) down: bool,
    /// 1 + index of the first segment, if that is CONTINUE.
    pub(super) continues: u16,
    /// 1 + index of the last entry that is no segment; 0 if there is none.
    pub(super) last_stop: u16,
}

impl FollowChain {
    /// Entries of the FIFO.
    pub fn entries(&self) -> u32 {
        self.segments as u32 + self.stops as u32
    }

    /// What a commit of these entries carries.
    pub fn tail(&self) -> FifoTail {
        self.tail
    }
}

/// Mantissa and exponent of r₀·M: 54 significant bits, exponent field e is 2^(e − 22) ≤ x < 2^(e −
/// 21); below that, multiples of 2⁻⁷⁴, field 0.
fn pack_displacement(x: i128) -> [u32; 2] {
    let magnitude = x.unsigned_abs();
    // Of 2^-64: bit 42 is 2^-22.
    let width = 128 - magnitude.leading_zeros();
    let (mut field, mantissa) = if width <= 43 {
        (0, (magnitude << 10) as u64)
    } else {
        let field = width - 43;
        let shift = width as i32 - 54;
        let kept = if shift > 0 { (magnitude >> (shift - 1)).wrapping_add(1) >> 1 } else { magnitude << -shift };
        (field, kept as u64)
    };
    let mut mantissa = mantissa;
    if mantissa >> 54 != 0 {
        (field, mantissa) = (field + 1, mantissa >> 1);
    }
    if field == 0 && mantissa >> 53 != 0 {
        field = 1;
    }
    let high = (mantissa >> 32) as u32 & 0x1f_ffff | field << 21 | ((x < 0) as u32) << 27;
    [mantissa as u32, high]
}

/// An entry, and the chain with it.
type Chained = Result<(FollowEntry, FollowChain), Refused>;

impl FollowEntry {
    /// The words as stored: those of two slots.
    pub(super) fn words(self) -> [[u32; 3]; 2] {
        let [a, b, c, d, e, f] = self.0;
        [[a, b, c], [d, e, f]]
    }

    /// From stored words; all bit patterns are valid.
    #[inline(always)]
    pub(super) fn from_words([[a, b, c], [d, e, f]]: [[u32; 3]; 2]) -> FollowEntry {
        FollowEntry([a, b, c, d, e, f])
    }

    /// Checks a segment against the entries before and packs it. Positions are the bits of doubles,
    /// pulses from the start of the FIFO; `kind` is NORMAL 0, EVEN 1, STOP 2, CONTINUE 3; `percent`
    /// as in PVT Percent.
    pub fn segment(
        master_bits: u64,
        slave_bits: u64,
        kind: i16,
        percent: i16,
        direction: Direction,
        before: &FollowChain,
    ) -> Chained {
        if !(0..=3).contains(&kind) {
            return Err(Refused::Kind);
        }
        if !(0..=100).contains(&percent) {
            return Err(Refused::Percent);
        }
        let normal = kind == 0 || kind == 3;
        let type_bits = if normal { NORMAL } else { kind as u32 };
        let rule = |p: i128, m: u128| match kind {
            1 => {
                let mean = quotient(p, m);
                (mean, mean, p)
            }
            2 => (quotient(p << 1, m), 0, p << 1),
            _ => {
                let r0 = before.tail.ratio;
                (r0, quotient(p << 1, m) - r0, start_displacement(r0, m))
            }
        };
        let (entry, mut chain) =
            FollowEntry::between([master_bits, slave_bits], percent as u32, type_bits, direction, before, rule)?;
        if before.segments == 0 && kind == 3 {
            chain.tail.continues = before.entries() as u16 + 1;
        }
        Ok((entry, chain))
    }

    /// A part of an asymmetric S: the first with the ratio at its start, as the bits of a double,
    /// later ones without. A switch to the next segment leaves all of them.
    pub fn part(
        master_bits: u64,
        slave_bits: u64,
        part: SCurvePart,
        begin: Option<u64>,
        direction: Direction,
        before: &FollowChain,
    ) -> Chained {
        let r0 = match begin {
            None => before.tail.ratio,
            Some(bits) => {
                let ratio = Compact::pack(bits, 41).map_err(|_| Refused::TooSteep)?.magnitude() << (RATIO_BITS - 64);
                if bits >> 63 == 1 { -ratio } else { ratio }
            }
        };
        let code = PARTS + part as u32 + if begin.is_none() { GOES_ON } else { 0 };
        // P/M is r₀ + Δ/3, r₀ + Δ/2, r₀ + 2Δ/3.
        let rule = |p: i128, m: u128| {
            let end = match part {
                SCurvePart::Rise => quotient(p * 3, m) - (r0 << 1),
                SCurvePart::Constant => quotient(p << 1, m) - r0,
                SCurvePart::Fall => (quotient(p * 3, m) - r0) >> 1,
            };
            (r0, end, start_displacement(r0, m))
        };
        FollowEntry::between([master_bits, slave_bits], code, STOP, direction, before, rule)
    }

    /// A segment after `before`. From a displacement of the slave and one of the master, `rule`
    /// gives the ratios at both ends, and the displacement at the first.
    fn between(
        [master_bits, slave_bits]: [u64; 2],
        percent: u32,
        type_bits: u32,
        direction: Direction,
        before: &FollowChain,
        rule: impl FnOnce(i128, u128) -> (i128, i128, i128),
    ) -> Chained {
        let master = Compact::pack(master_bits, 31).map_err(|class| match class {
            NoNumber::NotFinite => Refused::MasterNotFinite,
            NoNumber::TooLarge => Refused::MasterBeyondRange,
        })?;
        let slave = Compact::pack(slave_bits, 40).map_err(|class| match class {
            NoNumber::NotFinite => Refused::SlaveNotFinite,
            NoNumber::TooLarge => Refused::SlaveBeyondTravel,
        })?;
        let first = before.segments == 0;
        let down = master_bits >> 63 == 1;
        if down && direction == Direction::Up {
            return Err(Refused::Negative);
        }
        let m1 = master.magnitude();
        let s1 = if slave_bits >> 63 == 1 { -slave.magnitude() } else { slave.magnitude() };
        let (m, p) = (m1 - before.master, s1 - before.slave);
        if m < SEGMENT_MIN_EXACT || !first && down != before.tail.down {
            return Err(Refused::NotAdvancing);
        }
        if before.entries() >= ENTRIES {
            return Err(Refused::Full);
        }
        // Beyond it, a quotient would not fit.
        if p.unsigned_abs() >> 44 >= m.unsigned_abs() {
            return Err(Refused::TooSteep);
        }
        let (begin, end, at_start) = rule(p, m.unsigned_abs());
        if begin.abs() > RATIO_MAX_RAW || end.abs() > RATIO_MAX_RAW {
            return Err(Refused::TooSteep);
        }
        if at_start.abs() > START_DISPLACEMENT_MAX_EXACT {
            return Err(Refused::TooFar);
        }
        let mut chain = *before;
        chain.back = if first || type_bits != NORMAL { 0 } else { before.back };
        let [low, high] = pack_displacement(at_start);
        chain.ends = [master.low, master.high, slave.low, slave.high | ((slave_bits >> 63) as u32) << HIGH_BITS];
        let entry = chain.pack(percent, low, high | type_bits << 28);
        chain.back += 1;
        chain.odd = !before.odd;
        (chain.master, chain.slave) = (m1, s1);
        chain.tail.ratio = end;
        chain.tail.down = down;
        chain.segments += 1;
        Ok((entry, chain))
    }

    /// Sets an output when it is reached. Bits count from 0; those of axes over all cores.
    pub fn output(group: DoGroup, bit: u8, high: bool, before: &FollowChain) -> Chained {
        FollowEntry::stop(OUTPUT, 0, group as u32 | (bit as u32) << 4 | (high as u32) << 12, before)
    }

    /// Holds the slave for this many cycles of 250 µs.
    pub fn delay(cycles: u32, before: &FollowChain) -> Chained {
        FollowEntry::stop(DELAY, cycles, 0, before)
    }

    /// Holds the slave until an input has this level. `index` is an axis over all cores or a
    /// general input, from 0; a wait of `timeout_ms` ends the motion, 0 waits for ever.
    pub fn wait_input(input: Input, index: u8, high: bool, timeout_ms: u32, before: &FollowChain) -> Chained {
        FollowEntry::stop(WAIT, timeout_ms, input as u32 | (index as u32) << 4 | (high as u32) << 12, before)
    }

    /// Switches when it is reached.
    pub fn switch(method: Method, before: &FollowChain) -> Chained {
        FollowEntry::stop(SWITCH, 0, (method == Method::Table) as u32, before)
    }

    fn stop(code: u32, number: u32, rest: u32, before: &FollowChain) -> Chained {
        if before.entries() >= ENTRIES {
            return Err(Refused::Full);
        }
        if before.stops as usize >= STOPS {
            return Err(Refused::StopsFull);
        }
        let mut chain = *before;
        let entry = chain.pack(code, number, rest | (before.tail.last_stop as u32) << LINK_SHIFT | NO_SEGMENT << 28);
        chain.back += (before.segments > 0) as u16;
        chain.tail.last_stop = before.entries() as u16 + 1;
        chain.stops += 1;
        Ok((entry, chain))
    }

    /// The end of the entry: master's progress, and slave, in 2⁻⁶⁴ pulse from the start of the
    /// FIFO.
    #[inline(always)]
    pub(super) fn ends(self) -> (i128, i128) {
        let slave = self.slave().magnitude();
        (self.master().magnitude(), if self.0[3] >> HIGH_BITS & 1 == 1 { -slave } else { slave })
    }

    #[inline(always)]
    fn slave(self) -> Compact {
        Compact { low: self.0[2], high: self.0[3] }
    }

    #[inline(always)]
    fn master(self) -> Compact {
        Compact { low: self.0[0], high: self.0[1] }
    }

    /// The end of the master's progress.
    #[inline(always)]
    pub(super) fn ends_master(self) -> i128 {
        self.master().magnitude()
    }

    /// Whether it is a segment whose start ratio is that of its chain.
    #[inline(always)]
    pub(super) fn is_normal(self) -> bool {
        self.0[5] >> 28 & 3 == NORMAL
    }

    /// The kind of a segment; none for an entry that is no segment.
    #[inline(always)]
    pub(super) fn kind(self) -> Option<FollowEntryKind> {
        match self.0[5] >> 28 & 3 {
            NORMAL => Some(FollowEntryKind::Normal),
            EVEN => Some(FollowEntryKind::Even),
            STOP => Some(match self.percent().checked_sub(PARTS) {
                None => FollowEntryKind::Stop,
                Some(0 | GOES_ON) => FollowEntryKind::Part(SCurvePart::Rise),
                Some(1 | 4) => FollowEntryKind::Part(SCurvePart::Constant),
                Some(_) => FollowEntryKind::Part(SCurvePart::Fall),
            }),
            _ => None,
        }
    }

    /// Whether it is a part of the segment that the entry before belongs to.
    #[inline(always)]
    pub(super) fn goes_on(self) -> bool {
        self.0[5] >> 28 & 3 == STOP && self.percent() >= PARTS + GOES_ON
    }

    /// Percentage of a segment, 0…100; above, a part of an asymmetric S.
    #[inline(always)]
    pub(super) fn percent(self) -> u32 {
        self.0[3] >> 27 | self.0[5] >> 30 << 5
    }

    /// Displacement of the slave over the segment at its start ratio, 2⁻⁶⁴ pulse, within 2⁻⁵⁵ of
    /// itself.
    #[inline(always)]
    pub(super) fn at_start(self) -> i128 {
        let field = self.0[5] >> 21 & 0x3f;
        let normal = field.min(1);
        let mantissa = ((self.0[5] & 0x1f_ffff | normal << 21) as u64) << 32 | self.0[4] as u64;
        // Field 11 is 2^-11..2^-10, whose last bit is 2^-64.
        let magnitude = if field >= 11 {
            let shift = field - 11; // 0..=52
            let high = mantissa >> 1 >> (63 - shift);
            ((high as u128) << 64 | (mantissa << shift) as u128) as i128
        } else {
            (mantissa >> (11 - field.max(1))) as i128
        };
        if self.0[5] >> 27 & 1 == 1 { -magnitude } else { magnitude }
    }

    /// Entries back to the head of its chain of ratios, or [`CHAIN_MAX_ENTRIES`].
    #[inline(always)]
    pub(super) fn back(self) -> u32 {
        self.0[1] >> HIGH_BITS & CHAIN_MAX_ENTRIES
    }

    /// Whether the number of segments before it is odd.
    #[inline(always)]
    pub(super) fn odd(self) -> bool {
        self.0[1] >> 31 == 1
    }

    /// What an entry that is no segment does.
    pub(super) fn action(self) -> QueueEntry {
        let (number, rest) = (self.0[4], self.0[5]);
        let (selector, index, high) = (rest & 15, (rest >> 4) as u8, rest >> 12 & 1 == 1);
        match self.percent() {
            OUTPUT => QueueEntry::Output { group: DoGroup::of(selector), bit: index, high },
            DELAY => QueueEntry::Delay { cycles: number },
            WAIT => {
                let input = Input::of_bits(selector as u8);
                QueueEntry::Wait { input, index, high, timeout_ms: number }
            }
            _ => QueueEntry::Switch(if selector == 1 { Method::Table } else { Method::Segment }),
        }
    }

    /// 1 + index of the entry before it that is no segment either; 0 if there is none.
    pub(super) fn stop_before(self) -> u32 {
        self.0[5] >> LINK_SHIFT & 0x3ff
    }
}

/// Types of segments.
const NORMAL: u32 = 0;
const EVEN: u32 = 1;
const STOP: u32 = 2;
/// Instead of a STOP's percentage: the first code of parts of an asymmetric S, in the order of
/// [`SCurvePart`], and what is added for one that continues the part before.
const PARTS: u32 = 101;
const GOES_ON: u32 = 3;
/// Kinds of entries that are no segments, instead of the percentage.
const OUTPUT: u32 = 1;
const DELAY: u32 = 2;
const WAIT: u32 = 3;
const SWITCH: u32 = 4;
/// The type of all of them.
const NO_SEGMENT: u32 = 3;
/// The bits of word 5 that link to the one before.
const LINK_SHIFT: u32 = 16;

impl FollowChain {
    /// The next entry: it ends where [`FollowChain::ends`] says.
    fn pack(&self, code: u32, low: u32, high: u32) -> FollowEntry {
        let [a, b, c, d] = self.ends;
        let back = (self.back as u32).min(CHAIN_MAX_ENTRIES);
        FollowEntry([
            a,
            b | back << HIGH_BITS | (self.odd as u32) << 31,
            c,
            d | (code & 31) << 27,
            low,
            high | code >> 5 << 30,
        ])
    }
}
