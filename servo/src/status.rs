//! The status word of `GetSts` (SPEC 4).

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
/// At rest, and the encoder inside the band for the band's time.
pub const IN_POSITION: u32 = 1 << 11;

/// Both limits.
pub const LIMITS: u32 = LIMIT_POSITIVE | LIMIT_NEGATIVE;
/// Faults that forbid every motion while their cause lasts.
pub const FAULTS: u32 = ALARM | FOLLOWING_ERROR;
/// Bits that stay set until ClearStatus.
pub const LATCHED: u32 = FAULTS | LIMITS | STOP_SMOOTH | STOP_ABRUPT;
