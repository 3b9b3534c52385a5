//! A board as the thread knows it: its constants, how long its ticks take, what ended its last run.
use servo::port::WiredInputs;
use servo::units::{AxisMask, StepLimit};

/// Constants of a board, which its integrator states.
#[derive(Debug, Clone)]
pub struct BoardConstants {
    /// Name, of which 16 bytes are shown.
    pub name: &'static str,
    /// Number of the profile it shows at power-on (see [`crate::PROFILES`]); the build must hold
    /// it.
    pub profile: u8,
    /// Tick periods it can run, in µs.
    pub tick_us: core::ops::RangeInclusive<u32>,
    /// Analog outputs (at most 8).
    pub analog_outputs: u8,
    /// Analog inputs (at most 8).
    pub analog_inputs: u8,
    /// Rows that a plan of its inputs may have. 0 for a board with wired inputs, which no call may
    /// set.
    pub planned_inputs: u16,
    /// General inputs that it has.
    pub general_inputs: u8,
    /// General outputs that it has.
    pub general_outputs: u8,
    /// Axes whose encoder's index is captured.
    pub indexes: AxisMask,
    /// Axes whose inputs it has.
    pub wired: &'static WiredInputs,
    /// The limit of its step outputs. An axis that would be faster is refused.
    pub step_limit: StepLimit,
    /// What ended the run before this one, if the board remembers it.
    pub fault: Option<Fault>,
    /// Asks the board whether its ticks have found that it contradicts its build
    /// ([`FaultKind::Board`]).
    pub contradiction: fn() -> Option<&'static str>,
    /// Asks the board how long its ticks take, if it measures them.
    pub tick_time: Option<fn() -> TickTime>,
    /// Asks the board how much of its stack it has used, if it measures that. It takes the time of
    /// a look at each word that was not used.
    pub stack: Option<fn() -> Stack>,
}

/// A stack, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stack {
    /// All of it.
    pub size: u32,
    /// What was never used since the start.
    pub unused: u32,
}

/// How long servo ticks take, from the timer's event to the end of the handler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TickTime {
    /// Running median.
    pub median_ns: u32,
    /// The longest since the start.
    pub worst_ns: u32,
    /// The longest since the board was asked before.
    pub recent_ns: u32,
    /// How many took less than [`TICK_BUCKET_NS`], less than twice that and so on; the last counts
    /// all that were longer. The counts wrap.
    pub histogram: [u32; TICK_BUCKETS],
}

/// Counts of [`TickTime::histogram`].
pub const TICK_BUCKETS: usize = 32;
/// Width of each but the last, a power of two.
pub const TICK_BUCKET_NS: u32 = 2048;

/// What ended a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// Of which kind it was.
    pub kind: FaultKind,
    /// Text for a person. A reply carries [`FAULT_TEXT_MAX`] bytes of it.
    pub text: &'static str,
}

/// Kinds of [`Fault`]; the numbers are those of `FaultReply`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// The code panicked.
    Panic = 1,
    /// The core refused an access or an instruction.
    Core = 2,
    /// An interrupt came that nobody claims.
    Interrupt = 3,
    /// The watchdog: the servo tick or the link task hung.
    Watchdog = 4,
    /// The board's self-test, at its start or in a tick, contradicts its build: there is no light.
    Board = 5,
}

/// Bytes of a fault's text that a reply carries.
pub const FAULT_TEXT_MAX: usize = 160;
