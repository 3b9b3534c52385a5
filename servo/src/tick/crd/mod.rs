//! Coordinate systems in the tick: axes that a [`Path`] drives.
//!
//! In: a [`AxisMap`] each, entries in two FIFOs, tick commands, the axes in their present state.
//! Out: set-points of the axes; the effects of entries, with exact instants; what the thread reads
//! ([`CrdView`]). Owns the paths. Fails: never; a path that must not go on stops, with a reason.
//!
//! | file | what it is |
//! | --- | --- |
//! | `commands` | what tick commands do: set, clear, start, stop |
//! | `drive` | a tick of those that run, before that of the axes |
//! | `effects` | what entries do to the rest of the machine |
//! | `path_soft_limits` | whether limits of axes are in the way of a path |
//! | `set_override` | `SetOverride`: the factor on its speeds |
//!
//! Which axes, and their zero: `path/axis_map.rs`. The motion of one axis, for readers:
//! `view/axis_motion.rs`.
mod commands;
mod drive;
mod effects;
mod path_soft_limits;
mod set_override;

pub(crate) use commands::Halt;
use path_soft_limits::Clearance;

use crate::laser::EncoderSpeed;
use crate::path::axis_map::{AxisIndices, AxisMap};
use crate::path::{FifoEnds, Path, PathStores};
use crate::units::{Axis, AxisMask, Crd, CrdMask, Ns, Pos};
use crate::view::{CrdView, StopReason};

/// A changed coordinate system waits for this many scans before its start is prepared: commands
/// that belong together have come by then.
const PREPARE_AFTER_SCANS: u8 = 2;

state! {
    /// One coordinate system. What every tick reads comes first.
    #[derive(Debug, Clone, Copy)]
    #[repr(C)]
    pub(crate) struct CrdState {
        /// What the thread reads. It is also the state itself, where both are the same.
        pub(crate) published: CrdView = CrdView::POWER_ON,
        /// Axes geared to the motion in force.
        geared: AxisMask = AxisMask(0),
        /// The axes of its frame.
        axis_indices: AxisIndices = AxisIndices::NONE,
        /// The axis that a modal move waits for, and until when.
        awaited: Option<(Axis, Ns)> = None,
        /// Of the motion in force, and of the one after it.
        clearance: [Clearance; 2] = [Clearance::Unknown; 2],
        pub(crate) path: Path = Path::IDLE,
        /// At standstill: the FIFO that will probably be started, and the scans before its start is
        /// prepared.
        likely: u8 = 0,
        scans: u8 = 0,
        /// The stop reason, if it is stopped.
        ending: StopReason = StopReason::None,
        /// The tick since which it has been at standstill.
        pub(crate) standstill_since: Ns = Ns(0),
        /// What stopped it: an axis, and a position where it must not go.
        obstacle: Option<(Axis, Pos)> = None,
        /// The speed of its encoders.
        encoders: EncoderSpeed = EncoderSpeed::POWER_ON,
    }
    pub(crate) const POWER_ON;
}

impl CrdState {
    fn feed(&self) -> FifoEnds {
        FifoEnds { ends: self.published.ends }
    }

    /// Something other than the position on the path differs from the last view.
    pub(crate) fn mark_changed(&mut self) {
        self.published.state_version = self.published.state_version.wrapping_add(1);
        self.published.version = self.published.version.wrapping_add(1);
    }
}

state! {
    /// All coordinate systems of a controller.
    #[derive(Debug)]
    pub(crate) struct Crds {
        pub(crate) states: [CrdState; Crd::MAX] = [CrdState::POWER_ON; Crd::MAX],
        /// Those that run.
        pub(crate) running: CrdMask = CrdMask(0),
        /// Those whose next start may be prepared, once they are at standstill.
        pub(crate) unprepared: CrdMask = CrdMask(0),
        /// Those with an alarm of one of their axes.
        alarms: CrdMask = CrdMask(0),
        /// Counts changes of the views of all of them.
        pub(crate) version: u32 = 0,
        /// Those that have had their turn in preparing a start.
        turn: u8 = 0,
    }
    pub(crate) const POWER_ON;
}

impl Crds {
    /// Those of the mask that have been set up.
    pub(crate) fn known(&self, of: CrdMask) -> CrdMask {
        let known = of.crds().filter(|crd| self.get(*crd).is_some_and(|state| state.published.frame.is_some()));
        CrdMask(known.fold(0, |mask, crd| mask | crd.mask().0))
    }

    pub(crate) fn get(&self, crd: Crd) -> Option<&CrdState> {
        self.states.get(crd.index())
    }

    fn get_mut(&mut self, crd: Crd) -> Option<&mut CrdState> {
        self.version = self.version.wrapping_add(1);
        self.unprepared.0 |= crd.mask().0;
        let state = self.states.get_mut(crd.index())?;
        state.scans = PREPARE_AFTER_SCANS;
        Some(state)
    }

    /// One of those at standstill prepares a part of its next start: the next in turn, lowest
    /// first.
    #[inline(never)]
    pub(crate) fn prepare_start(&mut self, steps: u32, paths: PathStores) {
        let resting = CrdMask(self.unprepared.0 & !self.running.0);
        let after = CrdMask(resting.0 & !self.turn);
        let Some(crd) = (if after.0 == 0 { resting } else { after }).crds().next() else { return };
        // Those up to it have had their turn.
        let own = crd.mask().0;
        self.turn = own | own.wrapping_sub(1);
        let more = match (self.states.get_mut(crd.index()), paths.get(crd.index())) {
            (Some(state), _) if state.scans > 0 => {
                state.scans = state.scans.wrapping_sub(1);
                true
            }
            (Some(state), Some(source)) => {
                let (fifo, feed) = (state.likely, state.feed());
                (0..steps).all(|_| state.path.prepare_start(fifo, feed, source))
            }
            _ => false,
        };
        if !more {
            self.unprepared.0 &= !own;
        }
    }

    /// A view of them catches up.
    #[inline(never)]
    pub(crate) fn publish(&self, published: &mut [CrdView]) {
        for (to, state) in published.iter_mut().zip(&self.states) {
            to.copy_changed(&state.published);
        }
    }
}
