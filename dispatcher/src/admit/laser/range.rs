//! What a physical quantity of a laser may be, and what becomes of one that lies outside (SPEC 2): the GUS
//! family refuses it, the LSR family takes the nearest bound and tells so. NaN and infinities are refused
//! in both.
use crate::refuse::{Admitted, Refused};
use protocol::reason::Reason;

/// Frequencies below this are none: half of the tick's unit, kHz.
const LEAST_KHZ: f64 = 1.0 / (1u64 << 45) as f64;

/// The values that a quantity may have.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    low: f64,
    high: f64,
    /// `low` itself is outside; what lies there or below is taken as this.
    above: Option<f64>,
}

impl Range {
    /// Both bounds belong to it.
    pub const fn new(low: f64, high: f64) -> Self {
        Range { low, high, above: None }
    }

    /// Frequencies above 0; `least` is the lowest that LSR takes one of 0 for.
    pub const fn frequency(least: f64, high: f64) -> Self {
        Range { low: 0.0, high, above: Some(least) }
    }

    /// `value` held in it.
    pub fn nearest(&self, value: f64) -> f64 {
        match self.above {
            Some(least) if value < LEAST_KHZ => least,
            _ => value.max(self.low).min(self.high),
        }
    }
}

/// Takes the quantities of one command and notes which of them had to be held.
#[derive(Debug)]
pub struct Taking {
    holds: bool,
    /// Bit k: field k of the reply was outside its range (`held` of the protocol's replies).
    pub held: u8,
}

impl Taking {
    /// `holds`: the family takes the nearest bound.
    pub fn new(holds: bool) -> Self {
        Taking { holds, held: 0 }
    }

    /// `got` of parameter `field`, which is field `place` of the reply.
    pub fn take(&mut self, field: u8, place: u8, got: f64, range: Range) -> Admitted<f64> {
        if !got.is_finite() {
            return Err(Refused::new(Reason::NotFinite).field(field).got(got));
        }
        let nearest = range.nearest(got);
        if nearest == got {
            return Ok(got);
        }
        if self.holds {
            self.held |= 1 << place;
            return Ok(nearest);
        }
        let reason = if range.above.is_some() { Reason::AboveLow } else { Reason::OutOfRange };
        Err(Refused::new(reason).field(field).got(got).limits(range.low, range.high))
    }

    /// The same for whole numbers of at most 16 bits.
    pub fn whole(&mut self, field: u8, place: u8, got: u32, low: u16, high: u16) -> Admitted<u16> {
        // A value in the range of 16 bits is one.
        self.take(field, place, got.into(), Range::new(low.into(), high.into())).map(|taken| taken as u16)
    }
}
