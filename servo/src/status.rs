//! The status word of `GetSts` (SPEC 4), the states of `GetPtState`, and why an axis came to
//! standstill.

/// Drive alarm; latches.
pub const ALARM: u32 = 1 << 1;
/// Following error beyond its limit; latches.
pub const FOLLOWING_ERROR: u32 = 1 << 4;
/// Positive limit: the switch, or the planned position at or beyond the software limit; latches.
pub const LIMIT_POSITIVE: u32 = 1 << 5;
/// Negative limit, likewise; latches.
pub const LIMIT_NEGATIVE: u32 = 1 << 6;
/// Smooth stop by I/O; latches. No input of the present boards asks for it.
pub const STOP_SMOOTH: u32 = 1 << 7;
/// Abrupt stop by I/O; latches. No input of the present boards asks for it.
pub const STOP_ABRUPT: u32 = 1 << 8;
/// Servo on.
pub const SERVO_ON: u32 = 1 << 9;
/// The profile runs.
pub const RUNNING: u32 = 1 << 10;
/// At standstill, and the encoder inside the band for the band's time.
pub const IN_POSITION: u32 = 1 << 11;

/// Both limits.
pub const LIMITS: u32 = LIMIT_POSITIVE | LIMIT_NEGATIVE;
/// Faults that forbid every motion while their cause lasts.
pub const FAULTS: u32 = ALARM | FOLLOWING_ERROR;

/// `GetPtState` (see [`crate::view::AxisView::pt_state`]).
pub mod pt_state {
    /// It runs.
    pub const RUNNING: u8 = 1;
    /// It has ended.
    pub const ENDED: u8 = 2;
    /// It ran dry at speed.
    pub const UNDERRUN: u8 = 3;
    /// A Stop or a fault has ended it.
    pub const STOPPED: u8 = 4;
}

/// Why an axis came to standstill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u16)]
pub enum StopReason {
    /// It never moved.
    #[default]
    None = 0,
    /// The motion ended as planned.
    Completed = 1,
    /// Stop command, smooth.
    StopSmooth = 2,
    /// Stop command, abrupt.
    StopAbrupt = 3,
    /// Positive limit switch.
    LimitPositive = 4,
    /// Negative limit switch.
    LimitNegative = 5,
    /// Software limit, positive.
    SoftPositive = 6,
    /// Software limit, negative.
    SoftNegative = 7,
    /// Drive alarm.
    Alarm = 8,
    /// Following error beyond its limit.
    FollowingError = 9,
    /// The stream ran dry at speed.
    Underrun = 10,
    /// ±2⁴⁰ pulses reached.
    Travel = 11,
    /// Servo switched off.
    ServoOff = 12,
    /// Host link lost.
    LinkLoss = 13,
    /// Reset.
    Reset = 14,
    /// FollowEx: an input did not come in time.
    WaitTimeout = 15,
    /// Follow: the step limit, 2³² pulse/ms, would have been exceeded.
    StepLimit = 16,
    /// Of a coordinate system: another axis could not be geared (BufGear) or moved (BufMove).
    OtherAxis = 17,
    /// Abort.
    Abort = 18,
    /// The interlock or emergency-stop input.
    Interlock = 19,
}

impl StopReason {
    /// Whether it is a command to brake smoothly.
    pub(crate) const fn is_brake(self) -> bool {
        use StopReason::{Abort, Interlock, LinkLoss, StopSmooth};
        matches!(self, StopSmooth | LinkLoss | Abort | Interlock)
    }
}
