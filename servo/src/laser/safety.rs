//! The state machine through which every laser output passes last (SPEC 9).

/// Why a channel is dark until it is cleared. The numbers are those that `GetLaserFault` tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Cause {
    /// It is not.
    #[default]
    None = 0,
    /// The interlock or emergency-stop input.
    Interlock = 1,
    /// The host link was lost while light was on or a program ran.
    LinkLost = 2,
    /// A servo tick began late.
    Overrun = 3,
    /// A panic, a fault or the watchdog ended the run before.
    Restart = 4,
    /// More gate edges than the channel can hold or place.
    Edges = 5,
}
