//! Motions of a path: entered, planned, made ahead.
//!
//! In: the entry of a motion, its start and speed there, what follows it. Out: the motion in force
//! with its plan. Owns nothing beyond the [`Path`]. Cannot fail. A motion that was made ahead is
//! the same as one made on its boundary: the same functions of the same numbers.
use super::{ActiveGear, After, EFFECTS, FifoEnds, Path, PathSettings, PathStage, Preparation, Prepared, end_of};
use crate::math::float::Float;
use crate::path::PathPos;
use crate::path::entry::{EntryContent, FixedRamp, MotionSpeeds, PathEntry};
use crate::path::geometry::GearMotion;
use crate::path::speed_profile::{MotionLimits, Phase, SpeedPlan, SpeedRule};
use crate::path::store::PathEntries;
use crate::units::{Exact, FineNs};

/// The speeds of a motion.
fn along_of(item: &EntryContent) -> Option<MotionSpeeds> {
    match *item {
        EntryContent::Line { along, .. } | EntryContent::Arc { along, .. } | EntryContent::Circle { along, .. } => {
            Some(along)
        }
        _ => None,
    }
}

/// The motion that comes next with its counter, else what comes instead. A path passes only so many
/// entries in one tick.
#[inline(always)]
fn find_motion(
    fifo: u8,
    mut counter: u32,
    feed: FifoEnds,
    source: &impl PathEntries,
) -> Result<(u32, PathEntry), After> {
    let (end, mut effects) = (end_of(feed, fifo), 0u32);
    while effects <= EFFECTS {
        if counter == end {
            return Err(After::Nothing);
        }
        let entry = source.entry(fifo, counter);
        if entry.is_motion() {
            return Ok((counter, entry));
        }
        if entry.is_wait() {
            break;
        }
        counter = counter.wrapping_add(1);
        effects = effects.wrapping_add(entry.load());
    }
    Err(After::Halt)
}

impl Path {
    /// Enters a motion that begins, or began, at `from`.
    pub(super) fn enter(&mut self, from: PathPos, counter: u32, item: &EntryContent) {
        if let Some(along) = along_of(item) {
            let exact = self.exact(self.fifo);
            let made = self.motions.now_mut();
            (made.counter, made.along) = (counter, along);
            let mut draft = made.shape.begin(from, item, exact);
            while !made.shape.advance(&mut draft) {}
            let cursor = self.cursor(self.fifo);
            (cursor.inside, cursor.from) = (true, from);
            self.set_gears();
        }
    }

    /// FIFO 1 comes back to where it interrupted FIFO 0, which need not be a whole pulse.
    fn exact(&self, fifo: u8) -> Option<PathPos> {
        let [first, _] = &self.cursors;
        (fifo != 0 && first.kept).then_some(first.position)
    }

    /// The motion in force is over, and the one after it comes into force: it begins, or began, at
    /// `from`.
    #[inline(always)]
    pub(super) fn swap(&mut self, from: PathPos, distance: Exact) {
        self.motions.next_mut().state = Preparation::Nothing;
        self.motions.turn();
        (self.motion_position.distance, self.motion_position.sampled) = (distance, distance.round());
        let cursor = self.cursor(self.fifo);
        (cursor.inside, cursor.from) = (true, from);
    }

    /// Whether a part of the motion of this entry was made ahead.
    pub(super) fn is_known(&self, counter: u32) -> bool {
        self.motions.next().state != Preparation::Nothing && self.motions.next().counter == counter
    }

    /// The motion ahead will be entered otherwise than it was planned for.
    #[inline(always)]
    pub(super) fn unplan(&mut self) {
        let ahead = self.motions.next_mut();
        if ahead.state > Preparation::Shaped {
            ahead.state = Preparation::Shaped;
        }
    }

    /// Sets the ratios of the axes geared to the motion in force.
    fn set_gears(&mut self) {
        if self.cursor(self.fifo).geared == 0 {
            return;
        }
        let inverse = self.motions.now().shape.length.recip();
        let cursor = self.cursor(self.fifo);
        for gear in cursor.gears.iter_mut().take(cursor.geared) {
            let ActiveGear { pulses, along, .. } = gear;
            *along = GearMotion::over(*pulses, inverse);
        }
    }

    /// Enters the motion that was made ahead, which begins or began at `from`, and makes the
    /// remainder of it.
    pub(super) fn enter_prepared(&mut self, from: PathPos, distance: Exact, feed: FifoEnds, source: &impl PathEntries) {
        while self.motions.next().state < Preparation::Shaped {
            self.shape_ahead();
        }
        let Prepared { state, open_end, .. } = *self.motions.next();
        // Entries that came since may follow it.
        let planned = state > Preparation::Shaped && open_end.is_none_or(|sampled| sampled == end_of(feed, self.fifo));
        if planned {
            while self.motions.next().state < Preparation::Ready {
                self.plan_ahead();
            }
        }
        self.swap(from, distance);
        self.set_gears();
        if self.motions.now().shape.length.is_zero() {
            return;
        }
        if planned { self.follow(open_end) } else { self.plan_remainder(feed, source) }
    }

    /// Makes a part of what follows: the piece after the one in force, or a part of the motion
    /// after the one in force.
    #[inline(never)]
    pub fn prepare(&mut self, feed: FifoEnds, source: &impl PathEntries) {
        if self.pieces.follows.is_none() {
            if self.planning.unfinished {
                self.finish();
                return;
            }
            if self.piece_ahead() {
                self.decide_fast_path();
                return;
            }
        }
        if self.stopping || self.motions.now().plan.halts {
            return;
        }
        if self.motions.next().state == Preparation::Nothing {
            let (fifo, from) = (self.fifo, self.motions.now().shape.end);
            let next = self.cursor_of(fifo).next;
            self.begin_ahead(fifo, next, &from, feed, source);
        } else {
            self.make_ahead(self.fifo, self.motions.now().plan.exit, Exact(0), feed, source);
        }
    }

    /// Makes a part of the motion ahead: it is entered at `speed`, at the path length `distance`.
    pub(super) fn make_ahead(
        &mut self,
        fifo: u8,
        speed: Float,
        distance: Exact,
        feed: FifoEnds,
        source: &impl PathEntries,
    ) {
        match self.motions.next().state {
            Preparation::Begun => self.shape_ahead(),
            Preparation::Shaped if self.motions.next().shape.length.is_zero() => {
                let ahead = self.motions.next_mut();
                (ahead.plan, ahead.state) = (SpeedPlan::NONE, Preparation::Ready);
            }
            Preparation::Shaped => {
                let Prepared { counter, along, shape, .. } = self.motions.next();
                let after = self.what_follows(fifo, counter.wrapping_add(1), feed, source);
                let (means, left) = (self.means(*along, after), shape.length.sub(Float::from_exact(distance)));
                self.planning.speed_draft.begin(speed, left, means);
                let open = (after == After::Nothing).then_some(end_of(feed, fifo));
                let ahead = self.motions.next_mut();
                (ahead.open_end, ahead.state) = (open, Preparation::Sketched);
                self.plan_ahead();
            }
            Preparation::Sketched => self.plan_ahead(),
            Preparation::Nothing | Preparation::Ready => {}
        }
    }

    /// The piece after the one in force, of the same motion or of the next, if that is known by
    /// now.
    #[inline(always)]
    fn piece_ahead(&mut self) -> bool {
        let (over, motion, ahead) = (self.motion_position.over, self.motions.now(), self.motions.next());
        let to = self.pieces.pair.next_mut();
        let Some(Phase { length, .. }) = motion.plan.phase(self.motion_position.phase) else { return false };
        if let Some(phase) = motion.plan.phase(self.motion_position.phase.wrapping_add(1)) {
            to.make(phase, over, Exact(self.motion_position.distance.0.wrapping_add(length.0)));
        } else if ahead.state == Preparation::Ready
            && !motion.plan.halts
            && let Some(phase) = ahead.plan.phase(0)
        {
            to.make(phase, over, Exact(0));
        } else {
            return false;
        }
        self.pieces.follows = Some(over);
        true
    }

    /// A phase begins: its piece is the one that was made ahead, if that fits.
    #[inline(always)]
    pub(super) fn take_piece(&mut self) {
        let known = self.pieces.follows == Some(self.motion_position.began);
        if known {
            self.pieces.pair.turn();
            self.publish_whole = true;
        }
        (self.pieces.made, self.pieces.follows) = (known, None);
    }

    /// Begins the motion that comes next, from this entry and this position on, if it comes without
    /// a wait.
    pub(super) fn begin_ahead(
        &mut self,
        fifo: u8,
        counter: u32,
        from: &PathPos,
        feed: FifoEnds,
        source: &impl PathEntries,
    ) {
        if self.cursor_of(fifo).again {
            // It may pass entries before that without carrying them out.
            return;
        }
        if let Ok((counter, entry)) = find_motion(fifo, counter, feed, source) {
            self.draft_ahead(counter, &entry, from, self.exact(fifo));
        }
    }

    #[inline(never)]
    fn draft_ahead(&mut self, counter: u32, entry: &PathEntry, from: &PathPos, exact: Option<PathPos>) {
        let item = entry.item();
        let Some(along) = along_of(&item) else { return };
        let ahead = self.motions.next_mut();
        (ahead.counter, ahead.along, ahead.state) = (counter, along, Preparation::Begun);
        self.planning.draft = ahead.shape.begin(*from, &item, exact);
        if !matches!(item, EntryContent::Circle { .. }) {
            self.shape_ahead();
        }
    }

    /// Makes a part of the geometry of the motion that comes next.
    fn shape_ahead(&mut self) {
        let ahead = self.motions.next_mut();
        if ahead.shape.advance(&mut self.planning.draft) {
            ahead.state = Preparation::Shaped;
        }
    }

    /// Makes a part of its plan.
    fn plan_ahead(&mut self) {
        let ahead = self.motions.next_mut();
        if ahead.plan.advance(&mut self.planning.speed_draft) {
            ahead.state = Preparation::Ready;
        }
    }

    /// The limits for the plan of a motion.
    #[inline]
    fn means(&self, along: MotionSpeeds, after: After) -> (MotionLimits, SpeedRule) {
        let PathSettings { even, stop, rate } = self.rules;
        let vel = along.vel().mul(rate);
        let end = match after {
            After::Motion => along.end(),
            After::Halt | After::Nothing => Float::ZERO,
        };
        let end = if vel.is_less(end) { vel } else { end };
        let (rule, ruled) = match along.ramp() {
            _ if self.stopping => (SpeedRule::Stop, stop),
            FixedRamp::Up if after == After::Motion => (SpeedRule::RampUp, along.end()),
            FixedRamp::Down if after == After::Motion => (SpeedRule::RampDown, along.end()),
            _ => (SpeedRule::Free, Float::ZERO),
        };
        (MotionLimits { vel, acc: along.acc(), end, even, ruled }, rule)
    }

    /// Plans the remainder of the motion in force from `time`, `distance` and `speed`.
    pub(super) fn plan_remainder(&mut self, feed: FifoEnds, source: &impl PathEntries) {
        let after = self.what_follows(self.fifo, self.cursor_of(self.fifo).next, feed, source);
        let Prepared { along, shape, .. } = self.motions.now();
        let left = shape.length.sub(Float::from_exact(self.motion_position.distance));
        // A plan in progress of the motion after it is dropped: that motion will be entered
        // otherwise.
        let means = self.means(*along, after);
        self.planning.speed_draft.begin(self.speed, left, means);
        // The phases after its first one are made in the tick that comes next, if that one lasts so
        // long.
        self.planning.unfinished = !self.motions.now_mut().plan.begin(&mut self.planning.speed_draft);
        self.pieces.follows = None;
        self.follow((after == After::Nothing).then_some(end_of(feed, self.fifo)));
    }

    /// Makes the remainder of the plan of the motion in force.
    #[inline(never)]
    pub(super) fn finish(&mut self) {
        while !self.motions.now_mut().plan.advance(&mut self.planning.speed_draft) {}
        self.planning.unfinished = false;
    }

    /// Follows the plan of the motion in force, which begins now. The next motion will be entered
    /// at another speed.
    #[inline(always)]
    pub(super) fn follow(&mut self, open: Option<u32>) {
        (self.open_end, self.motion_position.phase, self.motion_position.began, self.stage) =
            (open, 0, self.time, PathStage::Move);
        self.take_piece();
        self.set_over();
        self.unplan();
    }

    /// What follows a motion, from this entry on.
    fn what_follows(&self, fifo: u8, counter: u32, feed: FifoEnds, source: &impl PathEntries) -> After {
        find_motion(fifo, counter, feed, source).err().unwrap_or(After::Motion)
    }

    /// Entries have come while nothing followed the motion in force.
    #[inline(never)]
    pub(super) fn extend(&mut self, now: FineNs, feed: FifoEnds, source: &impl PathEntries) {
        if self.what_follows(self.fifo, self.cursor_of(self.fifo).next, feed, source) == After::Motion {
            self.catch_up(now);
            self.plan_remainder(feed, source);
        } else {
            self.open_end = Some(end_of(feed, self.fifo));
        }
    }

    /// Time, path length and speed are those of `now`, which lies in the phase in force or at its
    /// end.
    pub(super) fn catch_up(&mut self, now: FineNs) {
        let Some(phase) = self.motions.now().plan.phase(self.motion_position.phase).copied() else { return };
        let since = now.saturating_sub(self.motion_position.began).min(phase.time);
        self.motion_position.distance = Exact(self.motion_position.distance.0.wrapping_add(phase.distance(since).0));
        (self.speed, self.time) = (phase.speed(since), self.motion_position.began.wrapping_add(since));
        self.motion_position.began = self.time;
    }
}
