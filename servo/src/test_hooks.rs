//! Hooks for tests and probes, in no board's image (feature `test-hooks`): a long life in one step,
//! and calls of the parts of a tick by themselves.
//!
//! A long life. In: how many entries, how much time. Out: every count of the tick as it would be
//! then. Counts wrap; their comparisons are right across that, or a test that begins just before it
//! fails.
use crate::laser::{self, LaserView, Power, PowerBounds, PowerMode};
use crate::math::float::Float;
use crate::output::cycle_ring::CycleRing;
use crate::path::{Curvature, DIMENSIONS, Effects, FifoEnds, Path, PathEntries, PathPos, PathReport};
use crate::segment::follow::{FollowChain, MasterPath, PositionTrack};
use crate::segment::piece::Motion;
use crate::segment::pvt::{Header, PvtRun};
use crate::segment::ramp::Accel;
use crate::tick::Tick;
use crate::tick_command::{Lane, TickCommand};
use crate::units::{AxisMask, CrdMask, Ns, Pos};
use crate::view::{AxisView, CrdView};

/// Entry numbers of a lane have 31 bits; the bit above says which lane.
const NUMBER: u32 = u32::MAX >> 1;

fn later(seq: u32, entries: u32, lane: Lane) -> u32 {
    let flag = if lane == Lane::Program { !NUMBER } else { 0 };
    flag | seq.wrapping_add(entries) & NUMBER
}

impl<const AXES: usize> Tick<AXES> {
    /// As if each lane had executed so many entries more, every other count had risen by as many,
    /// and `time` had passed. Nothing may run or be in flight; the thread's side must advance
    /// alike.
    pub fn advance_counters(&mut self, entries: u32, time: Ns) {
        self.now = Ns(self.now.0.wrapping_add(time.0));
        self.done_immediate = later(self.done_immediate, entries, Lane::Immediate);
        self.done_program = later(self.done_program, entries, Lane::Program);
        self.ticks = self.ticks.wrapping_add(entries);
        let add = |count: &mut u32| *count = count.wrapping_add(entries);
        for axis in &mut self.axes {
            let AxisView {
                version,
                piece_version,
                progress_version,
                state_version,
                epoch,
                cleared: [first, second],
                ..
            } = &mut axis.published;
            [version, piece_version, progress_version, state_version, epoch, first, second].into_iter().for_each(add);
        }
        for crd in &mut self.crds.states {
            let CrdView { version, state_version, cleared: [first, second], .. } = &mut crd.published;
            [version, state_version, first, second].into_iter().for_each(add);
        }
        add(&mut self.crds.version);
        for channel in &mut self.lasers.channels {
            let LaserView { version, settings_version, state_version, .. } = &mut channel.published;
            [version, settings_version, state_version].into_iter().for_each(add);
        }
    }

    /// As if each FIFO of a path had got and executed so many entries and motions more since it was
    /// cleared. Each laser is as if it had been on for so many units of its on-time more. Nothing
    /// may be in a FIFO; the thread's side must advance alike.
    pub fn advance_fifo_counters(&mut self, by: u32) {
        let add = |count: &mut u32| *count = count.wrapping_add(by);
        for crd in &mut self.crds.states {
            let CrdView { ends, released, done, .. } = &mut crd.published;
            [ends, released, done].into_iter().flatten().for_each(add);
            crd.path.discard_prepared();
            for cursor in &mut crd.path.cursors {
                [&mut cursor.next, &mut cursor.done, &mut cursor.left_at].into_iter().for_each(add);
            }
            crd.mark_changed();
        }
        self.crds.version = self.crds.version.wrapping_add(1);
        self.lasers.channels.iter_mut().for_each(|channel| add(&mut channel.on_time.units));
    }
}

/// The path at one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Coordinates.
    pub position: PathPos,
    /// Direction of motion, a unit vector in 2⁻³⁰: times the path's velocity it is that of each
    /// coordinate. Zeros where it does not move.
    pub heading: [i32; DIMENSIONS],
    /// The path length along the motion in force as a piece: its velocity is the path's.
    pub motion: Motion,
    /// How the direction turns.
    pub bend: Curvature,
    /// Whether it runs; it also does while it waits.
    pub runs: bool,
    /// FIFO in force.
    pub fifo: u8,
    /// Motions of it completed since it was cleared.
    pub done: u32,
}

impl Path {
    /// The path at `next`; then all boundaries before `next + period`.
    pub fn step(
        &mut self,
        next: Ns,
        period: Ns,
        feed: FifoEnds,
        source: &impl PathEntries,
        sink: &mut impl Effects,
    ) -> Step {
        let (heading, bend, motion) = ([0; DIMENSIONS], Curvature::STRAIGHT, Motion::STANDSTILL);
        let mut step = Step { position: [Pos(0); DIMENSIONS], heading, bend, motion, runs: false, fifo: 0, done: 0 };
        let Step { position, heading, bend, motion, .. } = &mut step;
        self.publish_whole = true;
        let mut report = PathReport { position, heading, bend, motion, piece_version: &mut 0 };
        let reported = self.advance(next, period, feed, source, sink, &mut report, true);
        Step { runs: reported.runs, fifo: reported.fifo, done: reported.done, ..step }
    }

    /// The same, if nothing else is to be done at `next`: it is within a phase, no data has come
    /// where the FIFO had ended, and it has neither geared axes nor slaves. The caller checks
    /// whether the path may be there, and then calls [`Path::pass`].
    pub fn fast_step(&mut self, next: Ns, feed: FifoEnds, report: &mut PathReport) -> Option<Pos> {
        if !self.may_step_fast(feed) {
            return None;
        }
        let t = self.spot(next)?;
        self.publish_fresh(report);
        Some(self.publish_at(t, report))
    }
}

impl<const SLOTS: usize, const WORDS: usize> CycleRing<SLOTS, WORDS> {
    /// The half-word that is queued next.
    pub fn next_word(&self) -> usize {
        self.slot().wrapping_mul(WORDS)
    }
}

impl<'a> MasterPath<'a> {
    /// A straight line from a tick to the next.
    pub fn line(now: Ns, period: Ns, from: Pos, to: Pos) -> MasterPath<'a> {
        let mut track = PositionTrack::begin(from);
        track.push(period.0 << 32, to);
        MasterPath::of(now, &track, 0)
    }
}

impl FollowChain {
    /// Entries of the FIFO that are no segments.
    pub fn stops(&self) -> u32 {
        self.stops as u32
    }
}

impl PvtRun {
    /// Time of the table at `now`, which runs from 0 to the first point's time and then from point
    /// to point, in whole ns; at most the last point's time.
    pub fn time(&self, now: Ns, ahead: bool) -> Ns {
        let track = self.state_in_force(ahead);
        let Header { delay, duration, .. } = *self.header_of(track);
        let since = ((now.0 as u128) << 64).wrapping_sub(track.began.wrapping_sub(delay));
        Ns((since.min(delay.wrapping_add(duration)) >> 64) as u64)
    }
}

impl Accel {
    /// Its reciprocal, ms²/pulse, to 2⁻⁶⁰ of itself.
    pub fn reciprocal(self) -> Float {
        self.rate().inverse
    }
}

impl PowerBounds {
    /// Checked bounds of a velocity follow: the maximum is above the minimum (LSR,
    /// BufLaserFollowRatio).
    pub fn admit_follow(mode: PowerMode, max: Power, min: Power) -> Result<PowerBounds, laser::Refused> {
        if max == min { Err(laser::Refused::MaxNotAboveMin) } else { PowerBounds::admit(mode, max, min) }
    }
}

impl TickCommand {
    /// A Stop of axes alone.
    pub const fn stop(axes: AxisMask, abrupt: AxisMask) -> TickCommand {
        TickCommand::Stop { axes, abrupt, crds: CrdMask(0), crds_abrupt: CrdMask(0) }
    }
}
