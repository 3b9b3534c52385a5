//! Failures of calls: a return code of SPEC 3 and a reason that a person can read.
use protocol::reason::Refusal;
use std::time::Duration;

/// The link failed in transfer: bytes could not be sent.
pub const LINK_SEND: i16 = -1;
/// The link failed in transfer: bytes could not be received.
pub const LINK_RECEIVE: i16 = -2;
/// The other end closed the link.
pub const LINK_CLOSED: i16 = -3;
/// The controller started anew: the session is over.
pub const SESSION_LOST: i16 = -4;
/// The controller sent what no version of this protocol allows.
pub const LINK_PROTOCOL: i16 = -5;
/// The controller could not be opened, or is open already.
pub const CANNOT_OPEN: i16 = -6;
/// The controller does not answer.
pub const NO_ANSWER: i16 = -7;
/// Client and firmware do not match.
pub const MISMATCH: i16 = 3;

/// Whether the link or the session is over.
pub fn is_dead(error: &Error) -> bool {
    (LINK_PROTOCOL..=LINK_SEND).contains(&error.code)
}

/// Why a call failed. `code` is the return value of SPEC 3, the `Display` text is the reason.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct Error {
    /// Return value of SPEC 3: 1, 3, 7, 8 from the controller, −1…−7 from the link.
    pub code: i16,
    /// What happened, naming command, parameter and limit, or port and cause.
    pub reason: String,
    /// What the controller said, if it was the controller that refused.
    pub refusal: Option<Refusal>,
}

/// Result of a call.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A failure that did not come from the controller.
    pub fn new(code: i16, reason: impl Into<String>) -> Self {
        Error { code, reason: reason.into(), refusal: None }
    }

    /// The link `name` could not be opened.
    pub fn cannot_open(name: &str, cause: impl std::fmt::Display) -> Self {
        Error::new(CANNOT_OPEN, format!("cannot open {name}: {cause}"))
    }

    /// Nothing came from `name` for `waited`.
    pub fn no_answer(name: &str, waited: Duration, doing: &str) -> Self {
        Error::new(NO_ANSWER, format!("{name} does not answer ({doing}; waited {} ms)", waited.as_millis()))
    }
}
