//! One axis in the tick: its motion, its limits and faults, what it publishes.
//!
//! In: inputs sampled at the tick in force, tick commands, the instant of the next tick. Out: the
//! planned position there, the status word, events. Owns: everything of the axis but its PT
//! segments. Fails: never; a motion that must not go on stops, with a reason.
//!
//! | file | what it is |
//! | --- | --- |
//! | `motion` | starts, stops, the step of a tick |
//! | `fast_path` | the short step of nearly every tick |
//! | `data` | FIFOs, streams, tables, passes |
//! | `slave` | an axis that follows another one |
//! | `crd_member` | an axis that a coordinate system drives |
//! | `inputs`, `input_scan` | what inputs mean; their scan in each tick |
//! | `following_error`, `in_position`, `soft_limits` | what they say |
//! | `user_position` | positions as the user names them |
mod crd_member;
mod data;
mod fast_path;
mod following_error;
mod in_position;
mod input_scan;
pub(crate) mod inputs;
mod motion;
mod slave;
mod soft_limits;
mod user_position;

use data::CommittedData;
pub(crate) use fast_path::FastStep;
use input_scan::Causes;
use soft_limits::TravelBounds;

use crate::laser::Positions;
use crate::port::AxisInputs;
use crate::segment::follow as following;
use crate::segment::profile::Profile;
use crate::segment::pt::SEGMENTS;
use crate::segment::ramp::{Accel, Trapezoid};
use crate::status::{self, pt_state};
use crate::tick_command::MotionMode;
use crate::units::{Crd, Exact, Ns, Pos};
use crate::view::{AxisView, StopReason};
use inputs::Inputs;

/// Scans until an axis that was changed prepares its next start: commands that belong together have
/// come by then.
const UNPREPARED_SCANS: u8 = 2;
/// Segments of one static FIFO.
const FIFO_SEGMENTS: u32 = SEGMENTS as u32 / 2;
/// Slots of the dynamic ring, less one.
const RING_MASK: u32 = 2 * FIFO_SEGMENTS - 1;
/// The negative edge of travel.
const NEGATIVE_EDGE: Pos = Pos(-Pos::TRAVEL.0);

/// Jog parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jog {
    pub(crate) acc: Accel,
    pub(crate) dec: Accel,
    pub(crate) smooth: u16,
}

/// What the scan of a tick's inputs has to do for an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum InputScan {
    /// Everything, even if the inputs stay.
    None,
    /// It runs: compare the levels, and take the encoder.
    Runs,
    /// The same, and only its motion is to be published.
    Steady,
    /// The same, for an axis that a coordinate system drives.
    Carried,
    /// At standstill, compare only: nothing changes until an input, the encoder or a tick command
    /// does.
    AtRest,
}

/// Whether it moves, and by what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
enum MotionState {
    Standstill,
    /// A coordinate system drives it.
    Driven,
    /// By its own profile.
    Runs,
    /// The same; a ramp begins at the tick computed, whose position `exact` is.
    RampBegins,
}

impl MotionState {
    /// Whether it moves by its own profile.
    #[inline(always)]
    fn is_own(self) -> bool {
        self >= MotionState::Runs
    }
}

state! {
    /// What the next ramps are made of.
    #[derive(Debug, Clone, Copy)]
    pub(crate) struct Ramps {
        pub(crate) stop_dec: Accel = Accel::ONE,
        pub(crate) jog: Jog = Jog { acc: Accel::NONE, dec: Accel::NONE, smooth: 0 },
        /// Trap; its target and its speed (Jog's too) are those of SetPos and SetVel.
        pub(crate) trap: Trapezoid = Trapezoid::POWER_ON,
    }
    const POWER_ON;
}

state! {
    /// The state of one axis. What every tick reads comes first.
    #[derive(Debug, Clone, Copy)]
    #[repr(C)]
    pub(crate) struct AxisState {
        /// What the thread reads. It is also the state itself, where both are the same.
        pub(crate) published: AxisView = AxisView::POWER_ON,
        scan: InputScan = InputScan::None,
        /// The status word may have changed.
        pub(crate) changed: bool = true,
        state: MotionState = MotionState::Standstill,
        /// Ticks until its next start is prepared; 0 if it is, or if there is nothing to prepare.
        unprepared: u8 = 0,
        /// Input levels, sampled, as bits.
        levels: u8 = 0,
        /// Those of them that have changed, until they are counted.
        pub(crate) flips: u8 = 0,
        pub(crate) servo_on: bool = false,
        in_position: bool = false,
        /// The levels themselves.
        pub(crate) raw: AxisInputs = AxisInputs { limit_positive: false, limit_negative: false, alarm: false, home: false, arrive: false },
        causes: Causes = Causes::NONE,
        /// Planned position at which the machine's own count is 0, so that setting a position makes
        /// no step.
        zero: Pos = Pos(0),
        bounds: TravelBounds = TravelBounds::TRAVEL,
        pub(crate) inputs: Inputs = Inputs::POWER_ON,
        /// Its motion; at standstill, a constant piece.
        profile: Profile = Profile::STANDSTILL,
        /// The stop reason that the running motion will have at its end.
        ending: StopReason = StopReason::None,
        /// The tick since which it has been at standstill.
        pub(crate) standstill_since: Ns = Ns(0),
        /// Exact position while at standstill, and where a ramp begins.
        exact: Exact = Exact(0),
        pub(crate) ramps: Ramps = Ramps::POWER_ON,
        data: CommittedData = CommittedData::NONE,
        pub(crate) follow: following::Setup = following::Setup::POWER_ON,
        /// The coordinate system that it is mapped to, or that drives it.
        pub(crate) crd: Option<Crd> = None,
        /// Its displacement within the tick while that drives it, if it has slaves.
        track: following::PositionTrack = following::PositionTrack::NONE,
    }
    pub(crate) const POWER_ON;
}

/// [`AxisView::table_until`] while a table is in force.
const IN_FORCE: Ns = Ns(u64::MAX);

impl AxisState {
    /// The machine's encoder count, sampled.
    #[inline(always)]
    fn count(&self) -> i64 {
        self.inputs.count(self.published.encoder)
    }

    /// Whether it moves, by itself or driven by a coordinate system.
    #[inline(always)]
    pub(crate) fn runs(&self) -> bool {
        self.state != MotionState::Standstill
    }

    /// Something is about to differ from the last view.
    #[inline]
    pub(crate) fn mark_changed(&mut self) {
        self.changed();
        (self.scan, self.changed, self.unprepared) = (InputScan::None, true, UNPREPARED_SCANS);
        self.profile.discard_prepared();
    }

    /// Whether its next start is still to be prepared.
    #[inline(always)]
    pub(crate) fn is_unprepared(&self) -> bool {
        self.unprepared != 0
    }

    #[inline(always)]
    fn changed(&mut self) {
        self.published.state_version = self.published.state_version.wrapping_add(1);
        self.published.version = self.published.version.wrapping_add(1);
    }

    /// It is in another piece; what is published of its data may differ, too.
    #[inline(always)]
    fn turned(&mut self) {
        self.published.piece_version = self.published.piece_version.wrapping_add(1);
        self.published.progress_version = self.published.progress_version.wrapping_add(1);
    }

    /// Brings the status word up to the tick just computed.
    #[inline(never)]
    pub(crate) fn update_status(&mut self) {
        self.changed = false;
        let status = self.status();
        if status != self.published.status {
            self.published.status = status;
            self.changed();
            if self.scan == InputScan::AtRest {
                self.scan = InputScan::None;
            }
        }
        if self.scan == InputScan::Runs {
            self.scan = if self.state == MotionState::Driven { InputScan::Carried } else { InputScan::Steady };
        }
    }

    /// The status word in the present state.
    #[inline]
    pub(crate) fn status(&self) -> u32 {
        let mut word = self.causes.latched;
        if self.servo_on {
            word |= status::SERVO_ON;
        }
        if self.runs() {
            word |= status::RUNNING;
        } else if self.in_position {
            word |= status::IN_POSITION;
        }
        word
    }

    /// The mode, at standstill; another one clears the PT data.
    pub(crate) fn set_mode(&mut self, mode: MotionMode) {
        if self.runs() || self.published.mode == mode {
            return;
        }
        (self.published.mode, self.crd) = (mode, None);
        self.profile.discard_prepared();
        self.published.pt_state = 0;
        (self.published.passes, self.published.fifo) = (0, 0);
        self.clear_data();
    }

    /// Arms a capture; what was captured before is forgotten.
    pub(crate) fn arm(&mut self, mode: u8) {
        self.published.captured = None;
        self.inputs.arm(mode);
    }

    /// The index edge that it waited for came at this count of the machine.
    pub(crate) fn take_index(&mut self, count: i64) {
        self.published.captured = Some(self.inputs.index(count));
        self.mark_changed();
    }

    /// Power-on state, at standstill. The machine does not move; its position is 0 from now on.
    pub(crate) fn reset(&mut self) {
        let (zero, count) = (Pos(self.set_point().0.wrapping_neg()), self.count());
        self.profile.rename(Pos(0));
        // In place, field by field: a whole state is too large to be moved about eight times in a
        // tick. The pattern names the fields that stay.
        let AxisState {
            published,
            scan,
            changed,
            state,
            unprepared: _,
            levels: _,
            flips: _,
            servo_on,
            in_position,
            raw: _,
            causes,
            zero: named,
            bounds,
            inputs,
            profile: _,
            ending,
            standstill_since: _,
            exact,
            ramps,
            data,
            follow,
            crd,
            track: _,
        } = self;
        published.reset();
        let on = AxisState::POWER_ON;
        (*scan, *changed, *state) = (on.scan, on.changed, on.state);
        (*servo_on, *in_position, *causes) = (on.servo_on, on.in_position, on.causes);
        (*named, *bounds, *inputs) = (zero, on.bounds, on.inputs);
        (*ending, *exact, *ramps) = (on.ending, on.exact, on.ramps);
        (*data, *crd) = (on.data, on.crd);
        follow.reset();
        self.inputs.set_encoder(count, 0);
    }
}

impl Positions for AxisState {
    #[inline(always)]
    fn planned(&self) -> Pos {
        self.published.pos
    }

    #[inline(always)]
    fn encoder(&self) -> i64 {
        self.published.encoder
    }
}

fn exact(pos: Pos) -> Exact {
    Exact((pos.0 as i128) << (64 - Pos::FRAC_BITS))
}
