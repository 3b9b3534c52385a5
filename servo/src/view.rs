//! What the tick publishes: the view of one tick, events, trace samples.
mod axis_motion;
mod crd;
mod speeds;

pub use crate::laser::LaserView;
pub use crate::segment::follow::Lead;
pub use crate::status::StopReason;
use axis_motion::share;
pub use crd::{CrdView, DrivenBy};
pub(crate) use speeds::AxisSpeeds;

use crate::capacity::{GeneralInputs, GeneralOutputs};
use crate::laser::{Action, CHANNELS, Power};
use crate::port::AxisInputs;
use crate::segment::follow::{PackedWait, compose, straight};
use crate::segment::piece::{Motion, Scaled};
use crate::tick_command::{Lane, MotionMode};
use crate::units::{Axis, Crd, Ns, Pos};

state! {
    /// One axis in one tick.
    ///
    /// The fields that change in every tick of a running axis come first and lie together.
    #[derive(Debug, Clone, Copy, Default)]
    #[repr(C)]
    pub struct AxisView {
        /// Counts changes of anything here and of the axis's input levels; a reader skips what did
        /// not change.
        pub version: u32 = 0,
        /// Counts ticks in which the motion of a running axis changed other than by its parameter.
        pub piece_version: u32 = 0,
        /// Planned position in force at the view's time.
        pub pos: Pos = Pos(0),
        /// Encoder position in pulses, sampled in the tick that computed this.
        pub encoder: i64 = 0,
        /// Encoder position one tick earlier, for the velocity.
        pub encoder_before: i64 = 0,
        /// The piece in force and the position in it: the reader derives velocity and acceleration.
        /// While it follows (`lead`) the piece is over the master's progress, see [`View::motion`].
        pub motion: Motion = Motion::STANDSTILL,
        /// PT: end time (ms from the start of pass or stream) of what was committed, minus now;
        /// rounded down. Brought up to date every eighth tick.
        pub dry_ms: u32 = 0,
        /// PT: segments of FIFO 0 (in dynamic mode, of the ring) that have run and whose slots are
        /// free.
        pub released: u32 = 0,
        /// PT, PVT, Follow: passes completed.
        pub passes: u32 = 0,
        /// PVT: instant at which the time of the table in force was 0 (in later passes: would have
        /// been).
        pub table_zero: Ns = Ns(0),
        /// Follow: the displacement of its master in the tick, in units of Pos.
        pub master_displacement: i64 = 0,
        /// Counts ticks, among those of `piece_version`, in which a field from `dry_ms` to
        /// `master_displacement` may have changed.
        pub progress_version: u32 = 0,
        /// Counts changes of the fields after it.
        pub state_version: u32 = 0,
        /// Status word of `GetSts` (SPEC 4).
        pub status: u32 = 0,
        /// Those latched bits of `status` that refuse a start until ClearStatus: alarm, following
        /// error, and limits hit since. A limit that is still active after ClearStatus stays in
        /// `status` but not here.
        pub blocked: u32 = 0,
        /// The reason of the last stop.
        pub stop: StopReason = StopReason::None,
        /// Profile mode.
        pub mode: MotionMode = MotionMode::Trap,
        /// Follow: the axis whose motion makes that of this axis; none while it does not move
        /// whatever the master does.
        pub lead: Option<Lead> = None,
        /// The coordinate system whose motion makes that of this axis; none while none drives it.
        pub drive: Option<DrivenBy> = None,
        /// PT: times a dynamic stream ended, for whatever reason (ran out, underrun, Stop, fault).
        /// Its data is cleared then, counts and times begin at 0, and segments pushed for an
        /// earlier epoch are void.
        pub epoch: u32 = 0,
        /// PT state as `GetPtState` reports it: 0 never ran, 1 running, 2 ended, 3 underrun, 4
        /// stopped.
        pub pt_state: u8 = 0,
        /// PVT: table in force; at standstill the one that ran last, or was selected since.
        pub table: u8 = 0,
        /// PVT: table that takes over at the end of the pass.
        pub pending: Option<u8> = None,
        /// PVT: until when that table was in force; `u64::MAX` while it is.
        pub table_until: Ns = Ns(0),
        /// Follow: the FIFO that runs, or ran last.
        pub fifo: u8 = 0,
        /// Follow: the other FIFO takes over at the end of the pass.
        pub switching: bool = false,
        /// Follow: what it waits for, after the tick that computed this.
        pub waits: PackedWait = PackedWait::NONE,
        /// Follow: times a switch has emptied each FIFO. `passes` are those of the FIFO that runs;
        /// they go down when the master goes back (direction 0).
        pub cleared: [u32; 2] = [0; 2],
        /// Captured encoder position, if `captured`.
        pub captured: Option<i64> = None,
    }
    /// An axis at power-on.
    pub const POWER_ON;
}

impl AxisView {
    /// As at power-on, except for counters, and for the stop reason.
    pub(crate) fn reset(&mut self) {
        let AxisView { version, piece_version, progress_version, state_version, stop, epoch, cleared, .. } = *self;
        *self = AxisView {
            version,
            piece_version,
            progress_version,
            state_version,
            stop,
            epoch,
            cleared,
            ..AxisView::POWER_ON
        };
    }

    /// The axis is in another piece.
    #[inline(always)]
    pub(crate) fn enter(&mut self, motion: &Motion) {
        self.piece_version = self.piece_version.wrapping_add(1);
        self.motion = *motion;
    }

    /// The axis is at another position, `t` ns from where its motion began.
    #[inline(always)]
    pub(crate) fn go_to(&mut self, pos: Pos, t: u32) {
        (self.version, self.pos, self.motion.t) = (self.version.wrapping_add(1), pos, t);
    }

    /// Copies the motion of `now`, whose time is `t`, as far as it has changed. Returns whether
    /// nothing else has.
    #[inline(always)]
    pub(crate) fn follow_piece(&mut self, now: &AxisView, t: u32) -> bool {
        if self.piece_version != now.piece_version {
            if self.state_version != now.state_version {
                return false;
            }
            (self.piece_version, self.motion) = (now.piece_version, now.motion);
            if self.progress_version != now.progress_version {
                self.follow_counts(now);
            }
        }
        self.motion.t = t;
        true
    }

    /// Becomes a copy of `now`; only what its counters mark as changed is copied.
    #[inline(always)]
    pub(crate) fn copy_changed(&mut self, now: &AxisView) {
        if self.state_version != now.state_version {
            self.follow_changes(now);
        }
        self.publish_position(now);
        self.follow_turn(now);
    }

    /// The same for what changes in every tick of a running axis.
    #[inline(always)]
    pub(crate) fn publish_position(&mut self, now: &AxisView) {
        (self.version, self.pos) = (now.version, now.pos);
        (self.encoder, self.encoder_before) = (now.encoder, now.encoder_before);
    }

    /// The same for what `piece_version` counts.
    #[inline(always)]
    pub(crate) fn follow_turn(&mut self, now: &AxisView) {
        (self.piece_version, self.motion) = (now.piece_version, now.motion);
        self.follow_counts(now);
    }

    /// The same for what `progress_version` counts.
    #[inline(always)]
    pub(crate) fn follow_counts(&mut self, now: &AxisView) {
        self.progress_version = now.progress_version;
        (self.dry_ms, self.released, self.passes) = (now.dry_ms, now.released, now.passes);
        (self.table_zero, self.master_displacement) = (now.table_zero, now.master_displacement);
    }

    /// Field by field, at a third of the cost of a call of memcpy.
    #[inline(never)]
    fn follow_changes(&mut self, now: &AxisView) {
        let AxisView { state_version, status, blocked, stop, mode, epoch, pt_state, captured, .. } = *now;
        (self.table, self.pending, self.table_until) = (now.table, now.pending, now.table_until);
        (self.lead, self.drive, self.waits) = (now.lead, now.drive, now.waits);
        (self.fifo, self.switching, self.cleared) = (now.fifo, now.switching, now.cleared);
        (self.state_version, self.status, self.blocked, self.epoch) = (state_version, status, blocked, epoch);
        (self.stop, self.mode, self.pt_state, self.captured) = (stop, mode, pt_state, captured);
    }
}

/// The motion of an axis in time: its own, or derived from that of its master, and of the masters
/// before it.
pub(crate) fn motion<'v>(
    of: impl Fn(Axis) -> Option<&'v AxisView>,
    crd: impl Fn(Crd) -> Option<&'v CrdView>,
    axis: &'v AxisView,
    period: Ns,
) -> Motion {
    let mut chain = [None; Axis::MAX];
    let (mut view, mut leader) = (axis, Motion::STANDSTILL);
    for slot in &mut chain {
        let Some(lead) = view.lead else {
            leader = match view.drive {
                Some(drive) => crd(drive.crd()).map_or(Motion::STANDSTILL, |crd| share(drive, crd)),
                None => view.motion,
            };
            break;
        };
        *slot = Some((view.motion, lead));
        match lead.axis.map(&of) {
            Some(Some(master)) => view = master,
            Some(None) => break,
            None => {
                leader = straight(view.master_displacement, period.0);
                break;
            }
        }
    }
    chain.iter().flatten().rev().fold(leader, |leader, (motion, lead)| compose(*motion, *lead, leader))
}

state! {
    /// Everything of one tick, for the thread. `AXES` is the capacity of the build.
    #[derive(Debug, Clone, Copy)]
    #[repr(C)]
    pub struct View<const AXES: usize> {
        /// The instant this view is of.
        pub now: Ns = Ns(0),
        /// Tick period.
        pub period: Ns = Ns(0),
        /// Controller time at which the script clock was zero: the tick in force when the program
        /// began.
        pub script_zero: Ns = Ns(0),
        /// Script clock: the instant of the last program entry executed, from the program's start.
        pub script: Ns = Ns(0),
        /// Worst lateness of a program entry.
        pub worst_late: Ns = Ns(0),
        /// Program entries executed late.
        pub late: u32 = 0,
        /// Number of the first of them, 0 if there is none.
        pub first_late: u32 = 0,
        /// Number of the last entry executed when the first tick of the program took too long, 0 if
        /// none has.
        pub overran: u32 = 0,
        /// A laser command that changes light, or the outputs without light, was late.
        pub late_light: bool = false,
        /// Whether the program lane runs; else it is held.
        pub program_runs: bool = false,
        /// An abort is in progress: on commands of lasers are refused until everything has come to
        /// standstill.
        pub aborts: bool = false,
        /// Servo-enable outputs.
        pub enable: u64 = 0,
        /// Alarm-clear outputs.
        pub clear: u64 = 0,
        /// General outputs.
        pub general_outputs: GeneralOutputs = 0,
        /// Ticks since power-on.
        pub tick: u32 = 0,
        /// Last entry of the immediate lane that was executed.
        pub done_immediate: u32 = 0,
        /// Last entry of the program lane that was executed.
        pub done_program: u32 = 0,
        /// Events lost because the ring was full.
        pub events_lost: u32 = 0,
        /// Ticks that began before the one before had ended.
        pub overruns: u32 = 0,
        /// Trace samples lost because the ring was full.
        pub trace_lost: u32 = 0,
        /// General inputs.
        pub general_inputs: GeneralInputs = 0,
        /// Analog inputs.
        pub analog: [i16; 8] = [0; 8],
        /// The clock of the machine's laser timers, MHz; 0 before the first tick.
        pub timer_mhz: u16 = 0,
        /// Counts changes of any of the coordinate systems.
        pub crds_version: u32 = 0,
        /// The coordinate systems.
        pub crds: [CrdView; Crd::MAX] = [CrdView::POWER_ON; Crd::MAX],
        /// The laser channels.
        pub lasers: [LaserView; CHANNELS] = [LaserView::BEFORE; CHANNELS],
        /// Raw per-axis input levels.
        pub inputs: [AxisInputs; AXES] = [AxisInputs { limit_positive: false, limit_negative: false, alarm: false, home: false, arrive: false };
            AXES],
        /// The axes.
        pub axes: [AxisView; AXES] = [AxisView::POWER_ON; AXES],
    }
    /// A controller at power-on; all bytes are zero.
    pub const POWER_ON;
}

impl<const AXES: usize> View<AXES> {
    /// Planned velocity of one of the axes, pulse/ms, as a trace has it.
    pub fn velocity(&self, axis: &AxisView) -> Scaled {
        if axis.lead.is_none() && axis.drive.is_none() {
            return axis.motion.velocity();
        }
        let (axes, crd) = (|axis: Axis| self.axes.get(axis.index()), |crd: Crd| self.crds.get(crd.index()));
        let mut speeds = AxisSpeeds::<0>::NONE;
        speeds.motion(None, axis, axes, crd, self.period).velocity()
    }

    /// The motion of one of the axes in time, of which its acceleration is read.
    pub fn motion(&self, axis: &AxisView) -> Motion {
        motion(|axis| self.axes.get(axis.index()), |crd| self.crds.get(crd.index()), axis, self.period)
    }
}

/// One traced axis, coordinate system or laser channel in one traced tick. Those of a row come in
/// this order.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Row number since the trace began, 0 the state before the first call acts.
    pub row: u32,
    /// Of what.
    pub of: Traced,
}

/// The contents of a sample.
#[derive(Debug, Clone, Copy)]
pub enum Traced {
    /// An axis.
    Axis {
        /// Which one.
        axis: Axis,
        /// Planned position.
        pos: Pos,
        /// The motion in its piece; for an axis that is led, a motion with its velocity.
        motion: Motion,
    },
    /// The planned position at which the machine's set-point of an axis is 0 changes by so much. It
    /// comes before the first row that it holds for; at row 0 it is what it was since power-on.
    Zero {
        /// Which one.
        axis: Axis,
        /// By how much.
        by: Pos,
    },
    /// A coordinate system.
    Crd {
        /// Which one.
        crd: Crd,
        /// The path length along the motion in force, whose velocity is its speed.
        motion: Motion,
    },
    /// A laser channel: switch output, and power and frequency as [`LaserView`] has them.
    Laser {
        /// Which one, from 0.
        channel: u8,
        /// Power mode, whose unit `power` has.
        mode: crate::laser::PowerMode,
        /// The switch output.
        gate: bool,
        /// Power being output, in the mode's unit.
        power: Power,
        /// Carrier or pulse rate being output, kHz.
        khz: Power,
    },
    /// An action of a channel in the interval that begins with the tick `row` (ticks since row 0,
    /// also where rows are fewer). It comes before the row of that tick. Those of row 0 bring
    /// outputs from the safe state to what they carry there.
    Action {
        /// Which channel, from 0.
        channel: u8,
        /// ns from the beginning of the interval.
        at: u32,
        /// What.
        action: Action,
    },
    /// A channel goes to the safe state at once: at the tick before `row`. Actions of `row` come
    /// after it.
    SafeState {
        /// Which channel, from 0.
        channel: u8,
    },
    /// From the tick `row` (ticks since row 0) on, the ticks have another period. It comes after
    /// the row of that tick.
    Period {
        /// ns.
        ns: u32,
    },
    /// The general outputs have these levels from here on: like an action, before the row of the
    /// tick `row`.
    Outputs {
        /// ns from the beginning of the interval.
        at: u32,
        /// Bit 0 is the first.
        levels: GeneralOutputs,
    },
    /// An analog output is set, likewise.
    Analog {
        /// ns from the beginning of the interval.
        at: u32,
        /// Which one, from 0.
        channel: u8,
        /// −32768…32767 is −10…10 V.
        value: i16,
    },
}

/// Events that must not be lost, from the tick to the thread.
#[allow(missing_docs, reason = "each variant's text names its fields")]
#[derive(Debug, Clone, Copy)]
pub enum Event {
    /// An axis came to standstill for this reason.
    Stopped { axis: Axis, reason: StopReason, now: Ns },
    /// A start, an Update or a commit did nothing because of this axis's state.
    Refused { lane: Lane, seq: u32, axis: Axis, status: u32 },
    /// A coordinate system came to standstill for this reason; its axes report no event.
    CrdStopped { crd: Crd, reason: StopReason, now: Ns },
    /// A CrdStart did nothing because of this coordinate system's state: it runs, has nothing to
    /// do, is not where it was interrupted, or one of its axes is no longer its own.
    CrdRefused { lane: Lane, seq: u32, crd: Crd },
    /// An on command lit nothing because a fault keeps this laser channel dark, or a clear cleared
    /// nothing because the cause of that is still there.
    LaserRefused { lane: Lane, seq: u32, channel: u8 },
    /// An output was not set for a time, because as many as can already wait.
    OutputRefused { lane: Lane, seq: u32 },
}
