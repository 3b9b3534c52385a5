//! What the inputs of an axis mean: which are active, and which forbid a motion.
//!
//! In: raw levels and an encoder count a tick. Out: the causes of status bits, the encoder's
//! reading, captures. Owns: enables, active levels, limits, the in-position band. It cannot fail.
use crate::tick_command::{Guarded, Guards};
use crate::units::{Ns, Pos};

/// Encoder readings are held within this: all of the travel, and still a [`Pos`].
const READABLE_PULSES: i64 = Pos::TRAVEL_PULSES;

/// An encoder reading as a position.
pub(crate) fn reading(pulses: i64) -> Pos {
    Pos(pulses.clamp(-READABLE_PULSES, READABLE_PULSES) << Pos::FRAC_BITS)
}

state! {
    /// The input side of one axis.
    #[derive(Debug, Clone, Copy)]
    pub(crate) struct Inputs {
        /// Inputs that are switched off, one bit each as in `AxisInputs::bits`.
        off: u8 = 0,
        /// Inputs that are active at the low level, likewise.
        low: u8 = 0,
        /// Encoder reading minus the machine's count.
        shift: i64 = 0,
        /// Soft limits.
        pub(crate) soft_positive: Option<i32> = None,
        pub(crate) soft_negative: Option<i32> = None,
        /// Following-error limit in pulses.
        pub(crate) error_limit: Option<u32> = None,
        /// In-position band in pulses.
        pub(super) band: u32 = 0,
        /// How long the encoder has to be inside.
        pub(super) band_time: Ns = Ns(0),
        /// Since when it has been inside: `None` while it is not.
        pub(super) inside: Option<Ns> = None,
        /// Capture mode that is armed; 0 is none, 1 home, 2 index.
        capture: u8 = 0,
        /// Home was active one tick ago.
        home: bool = false,
    }
    /// Power-on: everything on and active high, no limits of position or error, band 0.
    pub(crate) const POWER_ON;
}

impl Inputs {
    /// Switches some inputs on or off, and makes some active low or active high.
    pub(crate) fn guard(&mut self, on: Guards, low: Guards) {
        self.off = !on.applied(!self.off);
        self.low = low.applied(self.low);
    }

    /// From now on the machine's count `count` reads as `pulses`.
    pub(crate) fn set_encoder(&mut self, count: i64, pulses: i64) {
        self.shift = pulses.wrapping_sub(count);
    }

    /// The encoder's reading for the machine's count.
    pub(crate) fn encoder(&self, count: i64) -> i64 {
        count.wrapping_add(self.shift)
    }

    /// The machine's count for the encoder's reading.
    pub(crate) fn count(&self, encoder: i64) -> i64 {
        encoder.wrapping_sub(self.shift)
    }

    /// The machine's count at which the encoder reads 0, as a position.
    pub(crate) fn named(&self) -> i64 {
        reading(self.shift.wrapping_neg()).0
    }

    pub(crate) fn arm(&mut self, mode: u8) {
        self.capture = mode;
    }

    /// From level bits: limit switches and the alarm that are on and active, as status bits.
    #[inline]
    pub(crate) fn switches(&self, levels: u8) -> u32 {
        let active = ((levels ^ self.low) & !self.off) as u32;
        // Bits 0 and 1 are the limit switches, status bits 5 and 6; bit 2 the alarm, status bit 1.
        (active & 3) << 5 | (active & 4) >> 1
    }

    /// The capture that this tick's rising edge of home makes.
    #[inline]
    pub(crate) fn captured(&mut self, levels: u8, encoder: i64) -> Option<i64> {
        let home = (levels ^ self.low) & Guarded::Home.bit() != 0;
        let edge = home && !self.home;
        self.home = home;
        if edge && self.capture == 1 {
            self.capture = 0;
            return Some(encoder);
        }
        None
    }

    /// Whether it waits for an index edge.
    pub(crate) fn awaits_index(&self) -> bool {
        self.capture == 2
    }

    /// The capture that an index edge at the machine's count makes.
    pub(crate) fn index(&mut self, count: i64) -> i64 {
        self.capture = 0;
        self.encoder(count)
    }
}
