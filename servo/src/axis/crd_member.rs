//! An axis that a coordinate system uses: mapped to it, geared to a motion of its path, or moved by
//! an entry.
//!
//! In: a position each tick from the coordinate system, which steps before the axes. Out: as of any
//! axis. Owns: nothing; its own profile is idle while it is driven. Cannot fail: the coordinate
//! system asks before it drives an axis to a position.
use super::{AxisState, MotionState, exact};
use crate::math::wide::umulhi;
use crate::path::TrajectorySample;
use crate::segment::follow::{MasterPathKind, PositionTrack};
use crate::segment::profile::{Generator, MotionData};
use crate::segment::ramp::Trapezoid;
use crate::status;
use crate::tick_command::MotionMode;
use crate::units::{Crd, Exact, FineNs, Ns, Pos};
use crate::view::{DrivenBy, StopReason};

impl AxisState {
    /// It belongs to a coordinate system from now on, at standstill.
    pub(crate) fn map(&mut self, crd: Crd) {
        self.set_mode(MotionMode::Crd);
        (self.crd, self.causes.fresh) = (Some(crd), 0);
        self.mark_changed();
    }

    /// It belongs to none any more.
    pub(crate) fn unmap(&mut self) {
        self.set_mode(MotionMode::Trap);
        self.mark_changed();
    }

    /// Whether it is mapped to this coordinate system.
    pub(crate) fn is_mapped(&self, crd: Crd) -> bool {
        self.published.mode == MotionMode::Crd && self.crd == Some(crd)
    }

    /// The coordinate system that drives it.
    pub(crate) fn driver(&self) -> Option<Crd> {
        self.crd.filter(|_| self.state == MotionState::Driven)
    }

    /// A coordinate system drives it from now on; a geared axis counts from `base`.
    pub(crate) fn engage(&mut self, drive: DrivenBy, base: Exact) {
        (self.state, self.crd, self.exact) = (MotionState::Driven, Some(drive.crd()), base);
        self.publish_straight();
        self.published.drive = Some(drive);
        self.mark_changed();
    }

    /// Its own motion is over if that ends at the tick computed or before.
    pub(crate) fn arrive(&mut self, next: Ns, source: &impl MotionData) {
        if self.state.is_own() && !self.moving(next, source).1 {
            self.step(next, source);
        }
    }

    /// Whether it must not be geared to a motion: it must be at standstill, and of no coordinate
    /// system.
    pub(crate) fn refuses_gear(&self) -> bool {
        self.is_no_gear() || self.runs()
    }

    /// The same, but for a motion of its own, which may be over when the gear begins.
    pub(crate) fn is_no_gear(&self) -> bool {
        self.refuses_start() || self.published.mode == MotionMode::Crd
    }

    /// Its position at the tick computed.
    #[inline(always)]
    pub(crate) fn drive(&mut self, to: Pos) {
        self.published.pos = to;
        self.published.version = self.published.version.wrapping_add(1);
    }

    /// Publishes its displacement within the tick, in positions of the machine, for its slaves. It
    /// has been driven to the tick's end.
    #[inline(never)]
    pub(crate) fn publish_displacement(
        &mut self,
        (now, period): (Ns, Ns),
        from: Pos,
        trajectory: &TrajectorySample,
        (index, origin): (usize, Pos),
    ) {
        let shift = origin.0.wrapping_sub(self.zero.0);
        let whole = period.0 << 32;
        let mut track = PositionTrack::begin(from);
        let mut last = 0;
        for (at, position) in trajectory.knots() {
            last = (at.saturating_sub((now.0 as FineNs) << 32) as u64).min(whole);
            let position = position.get(index).copied().unwrap_or_default();
            track.push(last, Pos(position.0.wrapping_add(shift)));
        }
        if let Some((share, position)) = trajectory.turn(index) {
            let after = last.wrapping_add(umulhi(whole.wrapping_sub(last), share));
            track.push(after, Pos(position.0.wrapping_add(shift)));
        }
        track.push(whole, self.set_point());
        self.track = track;
    }

    /// The same where it moves straight from tick to tick.
    pub(crate) fn publish_straight(&mut self) {
        self.track.clear();
    }

    /// Its motion within the tick as its slaves see it, while it is driven.
    pub(super) fn driven_path(&self) -> MasterPathKind<'_> {
        if self.is_linear_between_ticks() {
            MasterPathKind::Straight
        } else {
            MasterPathKind::Track { along: &self.track, shift: 0 }
        }
    }

    /// Whether it moves straight from tick to tick.
    #[inline(always)]
    pub(super) fn is_linear_between_ticks(&self) -> bool {
        self.track.is_straight()
    }

    /// Its position before the gearing began.
    pub(crate) fn base(&self) -> Exact {
        self.exact
    }

    /// Its gear from now on, and its displacement `by` so far.
    pub(crate) fn engage_gear(&mut self, drive: DrivenBy, by: Pos) {
        if self.published.drive != Some(drive) {
            self.published.drive = Some(drive);
            self.mark_changed();
        }
        self.drive(Pos(self.exact.round().0.wrapping_add(by.0)));
    }

    /// A motion that it was geared to has ended.
    pub(crate) fn end_geared_motion(&mut self, pulses: i32) {
        self.exact = Exact(self.exact.0.wrapping_add((pulses as i128) << 64));
    }

    /// It is no longer driven: it comes to standstill at `at`.
    pub(crate) fn release(&mut self, next: Ns, at: Exact, reason: StopReason) {
        if self.state == MotionState::Driven {
            self.published.drive = None;
            if self.published.mode != MotionMode::Crd {
                self.crd = None;
            }
            self.come_to_standstill(next, at, reason);
            // What it was in before it was driven does not lead here.
            self.profile.forget();
        }
    }

    /// At the tick computed it stands where the motions that it was geared to have left it.
    pub(crate) fn show_base(&mut self) {
        self.published.pos = self.exact.round();
    }

    /// The motion that it was geared to has ended: it moves on its own from there. At the tick
    /// computed it may still be on its way.
    fn leave_gear(&mut self, next: Ns) {
        (self.state, self.crd, self.published.drive) = (MotionState::Standstill, None, None);
        self.profile.stand_still(next, self.published.pos);
        self.profile.forget();
    }

    /// It is no longer driven: it comes to standstill where it is.
    pub(crate) fn release_here(&mut self, next: Ns, reason: StopReason) {
        self.release(next, exact(self.published.pos), reason);
    }

    /// The fault for which it must not be driven on.
    #[inline(always)]
    pub(crate) fn fault(&self) -> Option<StopReason> {
        match self.causes.present & status::FAULTS {
            0 => None,
            causes if causes & status::ALARM != 0 => Some(StopReason::Alarm),
            _ => Some(StopReason::FollowingError),
        }
    }

    /// Begins a move to a target at `at`, an instant of the interval that begins with the tick
    /// computed at `next`. `geared`: it was geared to a motion that has ended. Returns when the
    /// move ends; None if the axis must not move.
    pub(crate) fn travel(
        &mut self,
        (next, at): (Ns, Ns),
        to: &Trapezoid,
        geared: bool,
        source: &impl MotionData,
    ) -> Option<FineNs> {
        if self.published.mode != MotionMode::Trap
            || self.state == MotionState::Driven && !geared
            || self.refuses_start()
        {
            return None;
        }
        if geared {
            self.leave_gear(next);
        } else if self.state.is_own() {
            // The piece that holds `next` takes effect before another one is made after it: also
            // that of a ramp which begins there, and which the first step only shows.
            if self.state == MotionState::RampBegins {
                self.step(next, source);
            }
            self.step(next, source);
        }
        let (from, _) = self.moving(at, source);
        self.profile.hold_until_next(next, self.published.pos);
        self.profile.begin_ramp(at, |run| run.begin_trap(at, from, to));
        let until = match self.profile.generator() {
            Generator::Ramp(run) => run.end(),
            _ => 0,
        };
        self.set_off(StopReason::Completed);
        Some(until)
    }
}
