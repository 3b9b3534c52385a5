//! The range of a laser's quantities, above all its power, and what happens to a value outside
//! (SPEC 2). The GUS family refuses it with return code 7; the LSR family takes the nearest bound
//! and reports it. NaN and infinities are refused in both.
use crate::refuse::{Admitted, Refused, finite};
use protocol::reason::Reason;

/// The lowest frequency, kHz: 1 Hz.
const RATE_MIN_KHZ: f64 = 0.001;

/// Values that are refused in both families.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ForbiddenValues {
    /// None but NaN and infinities.
    Nothing,
    /// Below 1 Hz.
    Slow,
    /// Above 0 and below 1 Hz.
    SlowPulses,
}

/// The values that a quantity may have.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    low: f64,
    high: f64,
    never: ForbiddenValues,
}

impl Range {
    /// Both bounds belong to the range.
    pub const fn new(low: f64, high: f64) -> Self {
        Range { low, high, never: ForbiddenValues::Nothing }
    }

    /// A carrier or a standby frequency, kHz: at least 1 Hz.
    pub const fn frequency(high: f64) -> Self {
        Range { low: RATE_MIN_KHZ, high, never: ForbiddenValues::Slow }
    }

    /// A rate of pulses, kHz: 0, or at least 1 Hz.
    pub const fn rate(high: f64) -> Self {
        Range { low: 0.0, high, never: ForbiddenValues::SlowPulses }
    }

    /// Whether a value is refused in both families.
    fn refuses(&self, value: f64) -> bool {
        match self.never {
            ForbiddenValues::Nothing => false,
            ForbiddenValues::Slow => value < RATE_MIN_KHZ,
            ForbiddenValues::SlowPulses => value > 0.0 && value < RATE_MIN_KHZ,
        }
    }

    /// `value` limited to the range.
    pub fn nearest(&self, value: f64) -> f64 {
        value.max(self.low).min(self.high)
    }
}

/// Takes the quantities of one command and notes which of them had to be limited.
#[derive(Debug)]
pub struct RangeLimiter {
    limits: bool,
    /// Bit k: field k of the reply was outside its range (`held` of the protocol's replies).
    pub limited: u8,
}

impl RangeLimiter {
    /// `holds`: the family takes the nearest bound.
    pub fn new(limits: bool) -> Self {
        RangeLimiter { limits, limited: 0 }
    }

    /// `got` of parameter `field`, which is field `index` of the reply.
    pub fn take(&mut self, field: u8, index: u8, got: f64, range: Range) -> Admitted<f64> {
        let nearest = range.nearest(finite(field, got)?);
        if nearest == got && !range.refuses(got) {
            return Ok(got);
        }
        if self.limits && !range.refuses(got) {
            self.limited |= 1 << index;
            return Ok(nearest);
        }
        let slow = range.never == ForbiddenValues::SlowPulses && range.refuses(got);
        let (reason, low) = if slow { (Reason::SlowPulses, RATE_MIN_KHZ) } else { (Reason::OutOfRange, range.low) };
        Err(Refused::new(reason).field(field).got(got).limits(low, range.high))
    }

    /// The maximum of LaserPowerMode: a negative one is refused in both families.
    pub fn maximum(&mut self, field: u8, index: u8, got: f64, range: Range) -> Admitted<f64> {
        if got < 0.0 {
            return Err(Refused::range(field, got, range.low, range.high));
        }
        self.take(field, index, got, range)
    }

    /// The minimum of LaserPowerMode: one outside its range, on either side, is taken as the
    /// range's minimum (LSR, command 11).
    pub fn minimum(&mut self, field: u8, index: u8, got: f64, range: Range) -> Admitted<f64> {
        let taken = self.take(field, index, got, range)?;
        Ok(if taken == got { taken } else { range.low })
    }

    /// The same for whole numbers of at most 16 bits.
    pub fn whole(&mut self, field: u8, index: u8, got: u32, low: u16, high: u16) -> Admitted<u16> {
        // A value in the range of 16 bits is one.
        self.take(field, index, got.into(), Range::new(low.into(), high.into())).map(|taken| taken as u16)
    }
}
