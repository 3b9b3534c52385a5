//! What the tick tells: the view of one tick, events, trace samples.
use crate::op::Mode;
use crate::piece::Motion;
use crate::units::{Axis, Ns, Pos};

/// One axis in one tick.
#[derive(Debug, Clone, Copy, Default)]
pub struct AxisView {
    /// Planned position in force at the view's time.
    pub pos: Pos,
    /// Encoder position in pulses, sampled in the tick that computed this.
    pub encoder: i64,
    /// Encoder position one tick earlier, for the velocity.
    pub encoder_before: i64,
    /// Status word of `GetSts` (SPEC 4).
    pub status: u32,
    /// Why the axis stopped last.
    pub stop: StopReason,
    /// Profile mode.
    pub mode: Mode,
    /// The piece being run and the place in it: velocity and acceleration are derived by the reader.
    pub motion: Motion,
    /// PT: segments of FIFO 0 (in dynamic mode, of the ring) that have run and whose places are free.
    pub released: u32,
    /// PT: passes completed.
    pub passes: u32,
    /// PT: times the stream was ended and cleared; segments pushed for an earlier epoch are void.
    pub epoch: u32,
    /// PT state as `GetPtState` tells it: 0 never ran, 1 running, 2 ended, 3 underrun, 4 stopped.
    pub pt_state: u8,
    /// PT: end time (ms from the start of pass or stream) of what was committed, minus now; rounded down.
    pub dry_ms: u32,
    /// Captured encoder position, if `captured`.
    pub captured: Option<i64>,
}

/// Why an axis came to rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u16)]
pub enum StopReason {
    /// It never moved.
    #[default]
    None = 0,
    /// The motion ended as told.
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
}

/// Everything of one tick, for the thread. `AXES` is the capacity of the build.
#[derive(Debug, Clone, Copy)]
pub struct View<const AXES: usize> {
    /// The instant this view is of.
    pub now: Ns,
    /// Ticks since power-on.
    pub tick: u32,
    /// Tick period.
    pub period: Ns,
    /// Last entry of the immediate lane that was executed.
    pub done_immediate: u32,
    /// Last entry of the program lane that was executed.
    pub done_program: u32,
    /// Script clock: the instant of the last program entry executed, from the program's start.
    pub script: Ns,
    /// Controller time at which the script clock was zero: the tick in force when the program began.
    pub script_zero: Ns,
    /// Program entries executed late, and the worst lateness.
    pub late: u32,
    /// Worst lateness.
    pub worst_late: Ns,
    /// Trace samples lost because nobody took them.
    pub trace_lost: u32,
    /// Ticks that began before the one before had ended.
    pub overruns: u32,
    /// General inputs, general outputs, enable and clear outputs.
    pub general_inputs: u32,
    /// General outputs.
    pub general_outputs: u32,
    /// Servo-enable outputs.
    pub enable: u64,
    /// Alarm-clear outputs.
    pub clear: u64,
    /// Raw per-axis input levels.
    pub inputs: [crate::port::AxisInputs; AXES],
    /// Analog inputs.
    pub analog: [i16; 8],
    /// The axes.
    pub axes: [AxisView; AXES],
}

/// One traced axis in one traced tick.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Row number since the trace began, 0 the state before the first call acts.
    pub row: u32,
    /// Which axis.
    pub axis: Axis,
    /// Planned position.
    pub pos: Pos,
    /// Place in its piece.
    pub motion: Motion,
}

/// News that must not be missed, from the tick to the thread.
#[derive(Debug, Clone, Copy)]
pub enum Event {
    /// An axis came to rest for this reason.
    Stopped { axis: Axis, reason: StopReason, now: Ns },
    /// A program entry could not be carried out because of this axis's state.
    Refused { seq: u32, axis: Axis, status: u32 },
}
