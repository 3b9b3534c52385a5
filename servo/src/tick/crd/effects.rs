//! The effects of a path on the rest of the machine.
//!
//! In: what [`Path::advance`](crate::path::Path::advance) reports. Out: outputs and lasers with
//! exact instants, motions of other axes, the state of the path after them. Owns nothing. Fails: a
//! move that an axis must not make is reported, and the path must stop.
use super::AxisMap;
use crate::axis::AxisState;
use crate::laser::{Lasers, PathRun};
use crate::output::general_outputs::{OutputChange, OutputEdges};
use crate::path::{ENDLESS_WAIT_FINE_NS, Effects, EntryEffect, PathPos, PathStop};
use crate::segment::piece::Scaled;
use crate::segment::ramp::{Accel, Speed, Trapezoid};
use crate::tables::TableStores;
use crate::tick::{MotionSource, SegmentStore};
use crate::units::{Axis, AxisMask, Crd, FineNs, Ns, Pos};
use crate::view::DrivenBy;

state! {
    /// What a path acts on in one tick.
    pub(crate) struct PathEffects<'a> {
        pub(crate) crd: Crd = crd,
        /// The FIFO that the path runs.
        pub(crate) fifo: u8 = fifo,
        /// The tick computed.
        pub(crate) next: Ns = next,
        /// The most that an axis may move in a tick, in [`Pos`].
        pub(crate) step_limit: u64 = step_limit,
        pub(crate) frame: &'a AxisMap = frame,
        pub(crate) origin: &'a PathPos = origin,
        pub(crate) axes: &'a mut [AxisState] = axes,
        pub(crate) edges: &'a mut OutputEdges = edges,
        pub(crate) lasers: &'a mut Lasers = lasers,
        pub(crate) segments: &'a [SegmentStore] = segments,
        pub(crate) tables: TableStores<'a> = tables,
        /// Axes that got their position along a motion in this tick.
        pub(crate) reported: AxisMask = AxisMask(0),
        /// All geared axes.
        pub(crate) geared: AxisMask = geared,
        /// A fault stops the path: its light does not come back.
        pub(crate) fault: bool = false,
        /// The path came to standstill.
        pub(crate) path_stop: Option<PathStop> = None,
        /// An axis that cannot do what an entry wants.
        pub(crate) unable: Option<Axis> = None,
        /// An axis that the path waits for, and until when.
        pub(crate) awaited: Option<(Axis, Ns)> = awaited,
        /// The first position that an axis must not go to.
        pub(crate) obstacle: Option<(Axis, Pos)> = None,
    }
    /// For a step of a path in the tick that `next` computes: `frame` and its origins, what entries
    /// act on, the data of the axes, axes that are geared or awaited.
    #[inline(always)]
    pub(crate) fn new(
        (crd, fifo): (Crd, u8),
        (next, step_limit): (Ns, u64),
        (frame, origin): (&'a AxisMap, &'a PathPos),
        (axes, edges, lasers): (&'a mut [AxisState], &'a mut OutputEdges, &'a mut Lasers),
        (segments, tables): (&'a [SegmentStore], TableStores<'a>),
        (geared, awaited): (AxisMask, Option<(Axis, Ns)>),
    );
}

impl PathEffects<'_> {
    fn run(&self) -> PathRun {
        PathRun { crd: self.crd, fifo: self.fifo }
    }

    /// ns of an instant, which is not before the tick computed.
    fn ns(&self, at: FineNs) -> Ns {
        Ns(((at >> 32) as u64).max(self.next.0))
    }

    fn edge(&mut self, at: FineNs, change: OutputChange) {
        let after = self.ns(at).0.wrapping_sub(self.next.0);
        self.edges.add(after as u32, change);
    }

    fn travel(&mut self, at: FineNs, axis: Axis, to: &Trapezoid) -> Option<FineNs> {
        let segments = self.segments.get(axis.index())?;
        let state = self.axes.get_mut(axis.index())?;
        let source = MotionSource { segments, tables: self.tables };
        // The first whole ns of it.
        let begin = Ns((at.wrapping_add(0xffff_ffff) >> 32) as u64);
        let geared = self.geared.has(axis);
        if geared && !self.reported.has(axis) {
            state.show_base();
        }
        let until = state.travel((self.next, begin), to, geared, &source)?;
        self.geared.0 &= !axis.mask().0;
        Some(until.saturating_sub(at))
    }

    /// An axis that is geared or may be: what moved it before is over by the tick computed.
    fn gear_of(&mut self, axis: Axis) -> Option<&mut AxisState> {
        let segments = self.segments.get(axis.index())?;
        let state = self.axes.get_mut(axis.index())?;
        if !self.geared.has(axis) {
            state.arrive(self.next, &MotionSource { segments, tables: self.tables });
        }
        Some(state)
    }

    /// An axis is geared from now on, if it may.
    fn engage(&mut self, axis: Axis, drive: DrivenBy) -> Option<&mut AxisState> {
        let geared = self.geared.has(axis);
        let state = self.gear_of(axis)?;
        if !geared {
            if state.refuses_gear() {
                self.unable = self.unable.or(Some(axis));
                return None;
            }
            let base = state.base();
            state.engage(drive, base);
        }
        self.geared.0 |= axis.mask().0;
        self.reported.0 |= axis.mask().0;
        self.axes.get_mut(axis.index())
    }

    fn send(&mut self, at: FineNs, axis: Axis, target: i32, (speed, acc): (Speed, Accel), modal: bool) -> FineNs {
        let vel_start = Speed::default();
        let to = Trapezoid { target, speed, acc, dec: acc, vel_start, smooth: Ns(0) };
        let Some(time) = self.travel(at, axis, &to) else {
            self.unable = self.unable.or(Some(axis));
            // It stops the path, which has not got the move yet.
            return ENDLESS_WAIT_FINE_NS;
        };
        if modal {
            self.awaited = Some((axis, Ns((at.wrapping_add(time) >> 32) as u64)));
            time
        } else {
            0
        }
    }
}

impl Effects for PathEffects<'_> {
    fn change(&mut self, at: FineNs, change: &EntryEffect) -> FineNs {
        match *change {
            EntryEffect::Output { group, mask, value } => self.edge(at, OutputChange::Digital { group, mask, value }),
            // Admitted before the output was a laser's: only the laser drives it now, and shuts it
            // off.
            EntryEffect::Analog { channel, .. } if self.lasers.drives(channel) => {}
            EntryEffect::Analog { channel, value } => self.edge(at, OutputChange::Analog { channel, value }),
            EntryEffect::Move { axis, target, speed, acc, modal } => {
                return self.send(at, axis, target, (speed, acc), modal);
            }
            EntryEffect::Laser { channel, code, words } => {
                self.lasers.buffered(self.run(), channel, self.ns(at), code, &words);
            }
        }
        0
    }

    fn has_room(&self) -> bool {
        self.edges.has_room() && self.lasers.has_room()
    }

    fn standstill(&mut self, at: FineNs, path_stop: PathStop) {
        self.path_stop = Some(path_stop);
        self.lasers.crd_is_at_standstill(
            self.run(),
            self.ns(at),
            if self.fault { PathStop::Obstructed } else { path_stop },
        );
    }

    fn gear(&mut self, axis: Axis, by: Pos, ratio: Scaled) {
        let drive = DrivenBy::Gear { crd: self.crd, ratio };
        if let Some(state) = self.engage(axis, drive) {
            state.engage_gear(drive, by);
        }
    }

    fn geared(&mut self, at: FineNs, axis: Axis, pulses: i32) {
        let drive = DrivenBy::Gear { crd: self.crd, ratio: Scaled::default() };
        let stood = self.geared.has(axis) && !self.reported.has(axis);
        let ended = at <= (self.next.0 as FineNs) << 32;
        if let Some(state) = self.engage(axis, drive) {
            if stood {
                state.show_base();
            }
            state.end_geared_motion(pulses);
            if ended {
                state.show_base();
            }
        }
    }

    fn accepts_gear(&mut self, axis: Axis, can: bool) -> bool {
        let geared = self.geared.has(axis);
        let goes = can && self.axes.get(axis.index()).is_some_and(|state| geared || !state.is_no_gear());
        if !goes {
            self.unable = self.unable.or(Some(axis));
        }
        goes
    }

    fn surplus(&mut self, axis: Axis) {
        self.unable = self.unable.or(Some(axis));
    }

    fn admits(&mut self, position: &PathPos) -> bool {
        for ((axis, at), origin) in self.frame.axes.iter().zip(position).zip(self.origin) {
            let Some(axis) = axis else { continue };
            let to = Pos(at.0.wrapping_add(origin.0));
            if self.axes.get(axis.index()).is_some_and(|state| !state.admits(to)) {
                self.obstacle = self.obstacle.or(Some((*axis, to)));
                return false;
            }
        }
        true
    }

    fn admits_gear(&mut self, axis: Axis, by: Pos) -> bool {
        let limit = self.step_limit;
        // One that must not be geared is reported where it is to go along.
        let Some(state) = self.gear_of(axis).filter(|state| state.driver().is_some() || !state.runs()) else {
            return true;
        };
        let to = Pos(state.base().round().0.saturating_add(by.0));
        // Its speed was checked for the length that the motion was given with.
        let is_slow = to.0.abs_diff(state.set_point().0) <= limit;
        let admits = state.admits(to);
        if !admits {
            self.obstacle = self.obstacle.or(Some((axis, to)));
        }
        admits && is_slow
    }
}
