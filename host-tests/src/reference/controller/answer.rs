//! Codes: the state or the parameter refuses a call.
use super::{Reply, Value};

pub(super) type Answer = Result<Reply, i16>;
pub(super) const DONE: Answer = Ok(Reply::Done(Value::None));

/// The state allows it, or 1.
pub(super) fn check(good: bool) -> Result<(), i16> {
    if good { Ok(()) } else { Err(1) }
}

/// The parameter is in its range, or 7.
pub(super) fn range(good: bool) -> Result<(), i16> {
    if good { Ok(()) } else { Err(7) }
}

/// Both; where neither holds the contract does not say which code comes first.
pub(super) fn either(state: bool, parameter: bool) -> Result<(), i16> {
    match (state, parameter) {
        (true, true) => Ok(()),
        (false, true) => Err(1),
        (true, false) => Err(7),
        (false, false) => Err(EITHER),
    }
}

/// 1 or 7.
pub(super) const EITHER: i16 = i16::MIN;
