//! Refusals: the result of a check that fails.
//!
//! A [`Refused`] is built where the check is. It names the reason, the parameter, the axis and the
//! limits. It is the payload of the reply as it is.
use protocol::reason::{Reason, Refusal};
use servo::status::{FAULTS, LIMIT_POSITIVE};
use servo::units::{Axis, Crd};

/// The owner of a FIFO.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FifoOf {
    /// An axis.
    Axis(Axis),
    /// A coordinate system.
    Crd(Crd),
}

/// What of the FIFOs a refusal is about. One type, since every refusal carries it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FifoState {
    /// Nothing, or what the tick may still change.
    Open,
    /// A FIFO that has no room: it may have room later.
    Full(FifoOf, u8),
    /// Data that was admitted before, and the tick takes none of that away meanwhile.
    Stands,
}

/// A refusal for the client.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refused {
    /// What is wrong.
    pub reason: Reason,
    data: FifoState,
    /// The rest of the reply's payload.
    pub wire: Refusal,
}

impl Refused {
    /// A number that lies outside `low..=high`.
    pub fn range(field: u8, got: f64, low: f64, high: f64) -> Self {
        Refused::new(Reason::OutOfRange).field(field).got(got).limits(low, high)
    }

    /// A refusal that names only its reason.
    pub fn new(reason: Reason) -> Self {
        Refused { reason, data: FifoState::Open, wire: Refusal::new(reason) }
    }
    /// The same with another, more precise reason.
    pub fn reason(mut self, reason: Reason) -> Self {
        self.reason = reason;
        self.wire.reason = (reason as u16).into();
        self
    }
    /// Names the FIFO that has no room.
    pub fn full(mut self, of: FifoOf, fifo: u8) -> Self {
        self.data = FifoState::Full(of, fifo);
        self
    }
    /// States whether the tick leaves the data before it as it is: then no FIFO gets room either.
    pub fn stands(mut self, stands: bool) -> Self {
        if stands {
            self.data = FifoState::Stands;
        }
        self
    }
    /// The FIFO that has no room, where that is the reason.
    pub fn full_fifo(&self) -> Option<(FifoOf, u8)> {
        match self.data {
            FifoState::Full(of, fifo) => Some((of, fifo)),
            FifoState::Open | FifoState::Stands => None,
        }
    }
    /// Whether only data that stays as it is keeps it from being taken.
    pub fn is_final(&self) -> bool {
        self.data == FifoState::Stands
    }
    /// Names the parameter by its index in the request.
    pub fn field(mut self, field: u8) -> Self {
        self.wire.field = field;
        self
    }
    /// Names the item.
    pub fn item(mut self, item: usize) -> Self {
        self.wire.item = u16::try_from(item).unwrap_or(u16::MAX).into();
        self
    }
    /// Names the axis by the number the user knows.
    pub fn axis(mut self, number: i16) -> Self {
        self.wire.axis = number.into();
        self
    }
    /// Reports the value that was given.
    pub fn got(mut self, got: f64) -> Self {
        self.wire.got = got.into();
        self
    }
    /// Reports the values that are allowed.
    pub fn limits(mut self, low: f64, high: f64) -> Self {
        self.wire.low = low.into();
        self.wire.high = high.into();
        self
    }
}

/// Why an axis with these latched causes must not start.
pub fn latched(causes: u32) -> Reason {
    match causes {
        causes if causes & FAULTS != 0 => Reason::AxisFault,
        causes if causes & LIMIT_POSITIVE != 0 => Reason::PositiveLatched,
        _ => Reason::NegativeLatched,
    }
}

/// What an admission returns.
pub type Admitted<T> = Result<T, Refused>;

/// `got` if it lies in `low..=high`.
pub fn within<T: Copy + PartialOrd + Into<f64>>(field: u8, got: T, low: T, high: T) -> Admitted<T> {
    if got >= low && got <= high { Ok(got) } else { Err(Refused::range(field, got.into(), low.into(), high.into())) }
}

/// `got` if it is one of the choices `low..=high`.
pub fn choice<T: Copy + PartialOrd + Into<f64>>(field: u8, got: T, low: T, high: T) -> Admitted<T> {
    if got >= low && got <= high {
        Ok(got)
    } else {
        Err(Refused::new(Reason::Selector).field(field).got(got.into()).limits(low.into(), high.into()))
    }
}

/// `got` if it is a finite number in `low..=high`.
pub fn real(field: u8, got: f64, low: f64, high: f64) -> Admitted<f64> {
    within(field, finite(field, got)?, low, high)
}

/// `got` if it is a finite number.
pub fn finite(field: u8, got: f64) -> Admitted<f64> {
    if got.is_finite() { Ok(got) } else { Err(Refused::new(Reason::NotFinite).field(field).got(got)) }
}

/// A word if it has no other bits than these.
pub fn bits_of(field: u8, word: u64, all: u64) -> Admitted<u64> {
    if word & !all == 0 { Ok(word) } else { Err(Refused::range(field, word as f64, 0.0, all as f64)) }
}
