//! The data that PT, PVT and Follow run from: FIFOs, streams, tables, passes.
//!
//! In: what the thread committed and selected. Out: the [`AllowedData`] of a run, and what the view
//! publishes of it.
use super::{AxisState, FIFO_SEGMENTS, IN_FORCE, Jog, RING_MASK, Ramps, pt_state};
use crate::segment::follow;
use crate::segment::piece::Scaled;
use crate::segment::profile::{Generator, MotionData};
use crate::segment::pt::{AllowedData, PtRun, SlotRange};
use crate::segment::pvt::{PvtRun, PvtTables};
use crate::segment::ramp::Moving;
use crate::tick_command::MotionMode;
use crate::units::Ns;
use crate::view::AxisView;

/// What is committed and selected.
#[derive(Debug, Clone, Copy)]
pub(super) struct CommittedData {
    /// Segments committed to the FIFOs (dynamic: the first is the ring's).
    ends: [u32; 2],
    /// Passes to run, 0 for ever.
    passes: u32,
    /// The same of a PVT table.
    table_passes: u32,
    /// FIFO that runs.
    fifo: u8,
    /// PVT table of the next start.
    table: u8,
}

impl CommittedData {
    pub(super) const NONE: CommittedData =
        CommittedData { ends: [0; 2], passes: 1, table_passes: 1, fifo: 0, table: 0 };
}

impl AxisState {
    /// Whether PT must not start.
    pub(crate) fn refuses_pt(&self, fifo1: bool) -> bool {
        let fifo = if self.published.mode == MotionMode::PtStatic { fifo1 as u8 } else { 0 };
        self.refuses_start() || self.runs() || !self.is_pt() || self.end(fifo) == 0
    }

    fn is_pt(&self) -> bool {
        matches!(self.published.mode, MotionMode::PtStatic | MotionMode::PtDynamic)
    }

    fn end(&self, fifo: u8) -> u32 {
        let [first, second] = self.data.ends;
        if fifo == 0 { first } else { second }
    }

    pub(super) fn feed(&self) -> AllowedData {
        let passes = if self.published.mode == MotionMode::Pvt { self.data.table_passes } else { self.data.passes };
        AllowedData { end: self.end(self.data.fifo), passes }
    }

    /// Which slots the segments of a FIFO lie in, and how many passes of them there are.
    fn slots(&self, fifo: u8) -> SlotRange {
        if self.published.mode == MotionMode::PtStatic {
            SlotRange::Static { base: if fifo == 1 { FIFO_SEGMENTS } else { 0 } }
        } else {
            SlotRange::Dynamic { mask: RING_MASK, first: 0 }
        }
    }

    /// PT begins; its time is 0 at `next`.
    pub(crate) fn start_pt(&mut self, next: Ns, fifo1: bool) {
        let fifo = if self.published.mode == MotionMode::PtStatic { fifo1 as u8 } else { 0 };
        self.published.pt_state = pt_state::RUNNING;
        self.published.passes = 0;
        if self.data.fifo == fifo && self.begin_prepared(next) {
            return;
        }
        self.data.fifo = fifo;
        self.begin(next, Generator::Pt(PtRun::begin(next, self.exact, self.slots(fifo))));
    }

    /// Whether PVT must not start.
    pub(crate) fn refuses_pvt(&self, tables: &impl PvtTables) -> bool {
        self.refuses_start()
            || self.runs()
            || self.published.mode != MotionMode::Pvt
            || tables.is_empty(self.data.table)
    }

    /// PVT begins; its time is 0 at `next`.
    pub(crate) fn start_pvt(&mut self, next: Ns, tables: &impl PvtTables) {
        let published = &mut self.published;
        (published.passes, published.table, published.pending) = (0, self.data.table, None);
        (published.table_zero, published.table_until) = (next, IN_FORCE);
        let current = matches!(self.profile.prepared(), Some(Generator::Pvt(run)) if run.is_current(tables));
        if current && self.begin_prepared(next) {
            return;
        }
        self.begin(next, Generator::Pvt(PvtRun::begin(next, self.exact, self.data.table, tables)));
    }

    /// The same at once, even if more tick commands for the axis may follow.
    pub(crate) fn prepare_start_now(&mut self, source: &(impl MotionData + follow::FollowEntries)) -> bool {
        self.unprepared = 1;
        self.prepare_start(source)
    }

    /// Whether a start needs no more planning: it is prepared.
    pub(crate) fn starts_at_once(&self) -> bool {
        !self.runs() && !self.is_unprepared()
    }

    /// At standstill, makes the first piece of what a start would begin now: of the FIFO committed
    /// last, the table selected, the Jog or Trap that is set, or the first FIFO of Follow with
    /// data. Returns whether it took any time.
    #[inline(never)]
    pub(crate) fn prepare_start(&mut self, source: &(impl MotionData + follow::FollowEntries)) -> bool {
        self.unprepared = self.unprepared.saturating_sub(1);
        if self.unprepared != 0 {
            return false;
        }
        let feed = self.feed();
        let (at, slots, set) =
            (self.exact, self.slots(self.data.fifo), !self.ramps.trap.acc.is_zero() && !self.ramps.trap.dec.is_zero());
        let AxisState { profile, published, data: CommittedData { table, .. }, ramps: Ramps { jog, trap, .. }, .. } =
            self;
        let from = Moving { pos: at, velocity: Scaled::default() };
        match published.mode {
            MotionMode::PtStatic | MotionMode::PtDynamic if feed.end != 0 => {
                profile.prepare_start(feed, source, |generator| {
                    *generator = Generator::Pt(PtRun::begin(Ns(0), at, slots))
                });
            }
            MotionMode::Pvt if !source.is_empty(*table) => {
                profile.prepare_start(feed, source, |generator| {
                    *generator = Generator::Pvt(PvtRun::begin(Ns(0), at, *table, source));
                });
            }
            MotionMode::Trap if set => {
                profile.prepare_start(feed, source, |generator| {
                    generator.begin_ramp(|run| run.begin_trap(Ns(0), from, trap))
                });
            }
            MotionMode::Jog if !jog.acc.is_zero() => {
                let Jog { acc, dec, smooth } = *jog;
                profile.prepare_start(feed, source, |generator| {
                    generator.begin_ramp(|run| run.begin_jog(Ns(0), from, trap.speed, acc, dec, smooth));
                });
            }
            MotionMode::Follow | MotionMode::FollowEx => self.follow_prepared(source),
            _ => return false,
        }
        true
    }

    /// The table of the next start, or the one that takes over when the present pass ends.
    pub(crate) fn select(&mut self, table: u8) {
        self.data.table = table;
        if !self.runs() {
            self.published.table = table;
            (self.published.table_zero, self.published.table_until) = (Ns(0), Ns(0));
        } else if self.profile.select(table) {
            self.published.pending = (table != self.published.table).then_some(table);
        }
    }

    pub(crate) fn set_table_passes(&mut self, passes: u32) {
        self.data.table_passes = passes;
        self.profile.invalidate_prepared();
    }

    /// No table is in force from `next` on.
    pub(super) fn leave_table(&mut self, next: Ns) {
        if self.published.table_until == IN_FORCE {
            (self.published.table_until, self.published.pending) = (next, None);
        }
    }

    /// PT is over; a dynamic stream is cleared with it.
    pub(super) fn end_stream(&mut self, state: u8) {
        if self.published.pt_state != pt_state::RUNNING {
            return;
        }
        self.published.pt_state = state;
        if self.published.mode == MotionMode::PtDynamic {
            self.published.epoch = self.published.epoch.wrapping_add(1);
            self.published.released = 0;
            self.data.ends = [0; 2];
        }
    }

    /// Finds how long the data of a stream or a pass lasts; every eighth tick is enough.
    #[inline(never)]
    pub(crate) fn look_ahead(&mut self, next: Ns, source: &impl MotionData, published: &mut AxisView) {
        if let Generator::Pt(run) = self.profile.generator() {
            self.published.dry_ms = run.dry_ms(next, self.feed(), source, self.profile.is_ahead());
            self.turned();
            published.copy_changed(&self.published);
        }
    }

    pub(super) fn clear_data(&mut self) {
        self.follow.clear_all();
        self.follow.gear = None;
        self.data.ends = [0; 2];
        self.published.released = 0;
    }

    /// What was committed to a FIFO counts from now on. False if its stream has ended meanwhile.
    pub(crate) fn commit(&mut self, fifo: u8, end: u32, epoch: u32) -> bool {
        if self.published.mode == MotionMode::PtDynamic && epoch != self.published.epoch {
            return false;
        }
        let [first, second] = &mut self.data.ends;
        *(if fifo == 0 { first } else { second }) = end;
        if !self.runs() {
            self.data.fifo = if self.published.mode == MotionMode::PtStatic { fifo } else { 0 };
        }
        self.profile.invalidate_prepared();
        true
    }

    /// Empties a FIFO that is not running.
    pub(crate) fn clear_fifo(&mut self, fifo: u8) {
        if self.published.mode == MotionMode::PtDynamic {
            if !self.runs() {
                self.clear_data();
            }
        } else if !self.runs() || self.data.fifo != fifo {
            let [first, second] = &mut self.data.ends;
            *(if fifo == 0 { first } else { second }) = 0;
        }
    }

    /// Which of the master's motion counts, at standstill; another one clears the data.
    pub(crate) fn set_direction(&mut self, direction: follow::Direction) {
        if !self.runs() && self.follow.direction != direction {
            self.follow.direction = direction;
            self.follow.clear_all();
        }
    }

    /// The ratio of the next start in gear.
    pub(crate) fn set_gear(&mut self, ratio: follow::GearRatio) {
        if self.published.mode == MotionMode::Gear {
            self.follow.gear = Some(ratio);
        }
    }

    /// What was committed to a FIFO of Follow counts from now on. False if a switch has emptied it
    /// meanwhile.
    pub(crate) fn commit_entries(
        &mut self,
        fifo: u8,
        end: u32,
        cleared: u32,
        tail: follow::FifoTail,
        source: &impl follow::FollowEntries,
    ) -> bool {
        let [first, second] = self.published.cleared;
        let counts = cleared == if fifo == 0 { first } else { second };
        if counts {
            self.follow.commit(fifo, end, tail, source);
            self.invalidate_run();
        }
        counts
    }

    /// Empties a FIFO of Follow that is not running.
    pub(crate) fn clear_entries(&mut self, fifo: u8) {
        if !self.runs() || self.published.fifo != fifo {
            self.follow.clear(fifo);
        }
    }

    pub(crate) fn set_passes(&mut self, passes: u32) {
        self.data.passes = passes;
        self.profile.invalidate_prepared();
    }
}
