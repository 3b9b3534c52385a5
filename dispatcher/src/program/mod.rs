//! The program queue (SPEC 7): timed commands on the controller's own script clock.
//!
//! In: records of lane 1, the view. Out: entries of the program lane, replies in order. Owns: the
//! waiting records, the script's accumulated delay, the replies that wait for execution.
//!
//! Records are admitted in order, ahead of the script clock as far as the ring has room. A record
//! that is refused now may be right later, so it waits. It is refused when its instant has been
//! reached and the state still forbids it. Then the rest is dropped from the ring and answered
//! `Discarded` or `LinkLost`, and the admitted state is set back to the executed one. The same
//! follows a late entry of a strict program, a Stop, link loss or ProgramClear.
//! After a record that may fail the program goes on: its refusal is answered and nothing else
//! happens. The script clock keeps its value.
//!
//! Flow: a record takes its body and 7 bytes of the queue. One that does not fit is answered
//! `QueueFull` at once. So is every later one until the client has asked for ProgramStatus. The
//! client then goes back and sends them again, and no order is lost. So lane 0 never waits for lane
//! 1.
mod end;
mod intake;
pub(crate) mod record_queue;
mod waits;

use crate::admit::admission::Admission;
use crate::admit::context::Due;
use crate::admit::one;
use crate::capacity::{AWAITING, VALUES};
use crate::lane::Lane;
use crate::refuse::{Admitted, Refused};
use crate::report::pending_replies::{PendingReplies, Step};
use crate::shadow::{Change, PROGRAM_FLAG, Shadows, executed, renew};
use protocol::command::{ProgramClear, ProgramReply, ProgramStart, ProgramStatus, opcode};
use protocol::reason::Reason;
use protocol::record::{Full, Lane as RecordLane, ReplyWriter, RequestRecord};
use protocol::values::{program, told};
use record_queue::{QUEUE_BYTES, RECORD_BYTES, Records};
use ring::Producer;
use servo::laser::{CHANNELS, Cause, Ignored};
use servo::op::{Entry, Op};
use servo::tick::PROGRAM;
use servo::view::View;
use waits::Pauses;
use zerocopy::IntoBytes;

/// State of the program; the numbers are those of `ProgramReply`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// No program.
    Empty = program::EMPTY as isize,
    /// Entries gather; the clock is stopped.
    Held = program::HELD as isize,
    /// The clock runs.
    Running = program::RUNNING as isize,
    /// An entry failed; the rest is discarded until ProgramClear.
    Failed = program::FAILED as isize,
    /// Stop or link loss ended it; the rest is discarded until ProgramClear.
    Stopped = program::STOPPED as isize,
}

/// The program queue.
pub struct Program<'a> {
    lane: Lane<'a, PROGRAM>,
    records: Records,
    replies: PendingReplies<AWAITING, VALUES>,
    /// The executed state waits for the first of them.
    is_behind: bool,
    state: State,
    /// Script time since the last entry pushed, ns.
    delay: u64,
    /// The earliest script clock of the last entry pushed, ns. The time that a WaitStop takes is
    /// added once it is over.
    instant: u64,
    /// WaitStops in flight.
    pauses: Pauses,
    /// Axes with data in FIFO 0, FIFO 1 that the tick does not know of yet.
    open: [u64; 2],
    /// Coordinate systems, the same.
    open_paths: [u8; 2],
    /// The ProgramRun of this program.
    run: Option<u32>,
    /// The ProgramEnd of this program, once admitted.
    end: Option<u32>,
    /// The rest is to be dropped: not pushed yet, or pushed with this number.
    drop_due: bool,
    dropping: Option<u32>,
    /// The reason with which the rest is answered.
    rest: Reason,
    /// ProgramClear or a new session: empty when all is answered.
    clearing: bool,
    strict: bool,
    /// A record did not fit: nothing more is taken until the client has asked for ProgramStatus.
    overflowed: bool,
    /// Nothing more can be admitted before the tick or the client acts.
    settled: bool,
    /// The record in hand waits for the machine and must not miss the tick.
    urgent: bool,
    config: Option<u16>,
    /// The script clock in the last view in which the program ran, ns.
    clock: u64,
    accepted: u32,
    done: u32,
    /// Ticks that took too long: in the last view, and before the program.
    overruns: [u32; 2],
    /// Tags of two records: of the first late entry, and of the last one executed when a tick took
    /// too long.
    late_tag: u16,
    overran_tag: u16,
    /// The entry and the tag of the record that was answered last: an overrun is reported a tick
    /// later.
    answered: (u32, u16),
    /// Laser channels that are lit or are to be, a bit each, and how many on commands of each were
    /// ignored.
    lit: u8,
    ignored: [u8; CHANNELS],
    /// Which of the tags are valid, and which light was shut off; the bits are those of
    /// `ProgramReply`.
    told: u8,
}

impl<'a> Program<'a> {
    /// An empty queue.
    pub fn new(ring: Producer<'a, Entry, PROGRAM>) -> Self {
        Program {
            lane: Lane::new(ring, PROGRAM_FLAG),
            records: Records::new(),
            replies: PendingReplies::new(),
            is_behind: false,
            state: State::Empty,
            delay: 0,
            instant: 0,
            pauses: Pauses::default(),
            open: [0; 2],
            open_paths: [0; 2],
            run: None,
            end: None,
            drop_due: false,
            dropping: None,
            rest: Reason::Discarded,
            clearing: false,
            strict: false,
            overflowed: false,
            settled: true,
            urgent: false,
            config: None,
            clock: 0,
            accepted: 0,
            done: 0,
            overruns: [0; 2],
            late_tag: 0,
            overran_tag: 0,
            answered: (0, 0),
            lit: 0,
            ignored: [0; CHANNELS],
            told: 0,
        }
    }

    /// The counts and the clock of a new program.
    fn begin(&mut self) {
        (self.accepted, self.done, self.delay, self.instant, self.told) = (0, 0, 0, 0, 0);
        self.overruns[1] = self.overruns[0];
    }

    /// Whether its clock runs in the tick that `view` shows.
    fn runs<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        self.state == State::Running && self.run.is_some_and(|run| executed(view, run))
    }

    /// Whether the instant of the record in hand is over, and all that was before it.
    fn is_past<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        let instant = view.script_zero.0.saturating_add(view.script.0).saturating_add(self.delay);
        self.runs(view) && !self.lane.in_flight() && self.replies.items.is_empty() && view.now.0 > instant
    }

    /// Whether the view is the last one before the tick on which the record in hand would act, and
    /// shows everything admitted before it.
    fn is_reached<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        let instant = view.script_zero.0.saturating_add(view.script.0).saturating_add(self.delay);
        let quiet = !self.lane.in_flight() && !self.gathers();
        self.runs(view) && quiet && instant < view.now.0.saturating_add(view.period.0)
    }

    /// Whether the view is the last one before the tick on which the record in hand would act, and
    /// nothing in flight before it may end what keeps it from being taken.
    fn is_settled<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        !self.lane.may_free() && self.until(view) < view.period.0
    }

    /// From the view to the instant of the record in hand, ns; `u64::MAX` where that is not known.
    /// After ProgramStart the clock begins on the tick after the view.
    fn until<const AXES: usize>(&self, view: &View<AXES>) -> u64 {
        let begun = self.state == State::Running && self.run.is_some();
        if !begun || self.pauses.wait() {
            return u64::MAX;
        }
        let zero = if self.runs(view) { view.script_zero.0 } else { view.now.0 };
        zero.saturating_add(self.instant).saturating_add(self.delay).saturating_sub(view.now.0)
    }

    /// Whether the record in hand acts soon, and nothing before it is in flight.
    fn is_soon<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        let instant = view.script_zero.0.saturating_add(self.instant).saturating_add(self.delay);
        let quiet = !self.lane.in_flight() && !self.gathers();
        self.runs(view) && quiet && instant <= view.now.0.saturating_add(intake::COMMIT_LEAD_NS)
    }

    /// What is known of the instant of the record in hand.
    fn due<const AXES: usize>(&self, view: &View<AXES>) -> Due {
        let decided = self.is_reached(view);
        let script_ns = self.instant.saturating_add(self.delay);
        let until_ns = if decided { 0 } else { self.until(view) };
        let first = self.state == State::Held && script_ns < view.period.0 && !self.pauses.wait();
        Due { decided, soon: self.is_soon(view), until_ns, first, script_ns, wait: self.pauses.last }
    }

    /// Whether it is held or runs.
    pub fn is_active(&self) -> bool {
        matches!(self.state, State::Held | State::Running)
    }

    /// Whether the record in hand may become right with any tick. One that waits for slots in a
    /// FIFO ahead of its time is not urgent.
    pub fn is_urgent(&self) -> bool {
        self.urgent
    }

    fn is_dropping(&self) -> bool {
        self.drop_due || self.dropping.is_some()
    }

    /// Takes a record of lane 1 into the queue; data that need not wait is admitted at once.
    pub fn offer<const AXES: usize>(
        &mut self,
        admission: &mut Admission<'_, AXES>,
        view: &View<AXES>,
        record: &RequestRecord,
        out: &mut ReplyWriter,
    ) -> Step {
        if self.takes_at_once::<AXES>(record.opcode, record.body) {
            // If it is refused it waits in the queue, and is refused from there.
            if let Ok(written) = admission.admit_data(view, self.due(view), record.opcode, record.body) {
                self.accepted = self.accepted.wrapping_add(1);
                let may_fail = record.lane == RecordLane::ProgramMayFail;
                self.take_data(admission, (record.opcode, record.tag, may_fail), &written);
                return Step::Taken;
            }
        }
        if self.overflowed || record.body.len() + RECORD_BYTES > self.records.space() {
            let full = Refused::new(Reason::QueueFull).got(self.records.space() as f64).limits(0.0, QUEUE_BYTES as f64);
            let step = Step::of(out.refused(record.opcode, record.tag, &full.wire));
            self.overflowed |= step == Step::Taken;
            return step;
        }
        if self.state == State::Empty {
            self.state = State::Held;
            self.begin();
        }
        self.records.push(record.opcode, record.tag, record.lane == RecordLane::ProgramMayFail, record.body);
        self.accepted = self.accepted.wrapping_add(1);
        self.settled = false;
        Step::Taken
    }

    /// ProgramStart, ProgramClear, ProgramStatus.
    pub fn control<const AXES: usize>(
        &mut self,
        admission: &mut Admission<'_, AXES>,
        record: &RequestRecord,
    ) -> Admitted<Step> {
        match record.opcode {
            opcode::ProgramStart => {
                let start: ProgramStart = one(record.body)?;
                if self.is_dropping() || !self.settled {
                    return Ok(Step::Wait);
                }
                if !matches!(self.state, State::Empty | State::Held) {
                    return Err(Refused::new(Reason::ProgramOnlyHeld));
                }
                if admission.lane.room() == 0 {
                    return Ok(Step::Wait);
                }
                if self.state == State::Empty {
                    self.begin();
                }
                // All of the instant 0 is in the ring before the clock runs.
                self.flush(admission);
                admission.lane.push(Op::ProgramRun, Change::None, 0, &mut admission.admitted);
                self.run = Some(admission.lane.last());
                self.clock = 0;
                (self.overruns[1], self.answered) = (self.overruns[0], (0, 0));
                self.strict = start.strict != 0;
                self.state = State::Running;
                Ok(Step::Taken)
            }
            opcode::ProgramClear => {
                one::<ProgramClear>(record.body)?;
                if self.state == State::Empty && !self.clearing {
                    return Ok(Step::Taken);
                }
                if !self.clearing {
                    self.cut(State::Stopped);
                    self.clearing = true;
                }
                // `advance` empties it; the reply reports that it is done.
                Ok(Step::Wait)
            }
            _ => {
                one::<ProgramStatus>(record.body)?;
                // The client has asked: it knows what was taken.
                self.overflowed = false;
                Ok(Step::Taken)
            }
        }
    }

    /// The reply to a program command.
    pub fn status<const AXES: usize>(
        &self,
        view: &View<AXES>,
        opcode: u16,
        tag: u16,
        out: &mut ReplyWriter,
    ) -> Result<(), Full> {
        let clock = match self.state {
            State::Empty | State::Held => view.script.0,
            State::Running | State::Failed | State::Stopped => self.clock,
        };
        let reply = ProgramReply {
            accepted: self.accepted.into(),
            executed: self.done.into(),
            space_bytes: (self.records.space() as u32).into(),
            late: view.late.into(),
            worst_late_us: u32::try_from(view.worst_late.0.div_ceil(1000)).unwrap_or(u32::MAX).into(),
            state: self.state as u8,
            clock_ns: clock.into(),
            overruns: view.overruns.wrapping_sub(self.overruns[1]).into(),
            late_tag: self.late_tag.into(),
            overran_tag: self.overran_tag.into(),
            told: self.told,
        };
        out.push_raw(opcode, tag, 0, &[reply.as_bytes()])
    }

    /// Enters into `now` what the tick has executed, and no reply waits for. Returns whether that
    /// is everything.
    pub fn retire<const AXES: usize>(&mut self, view: &View<AXES>, now: &mut Shadows<AXES>) -> bool {
        self.is_behind = !self.lane.retire(view, now, self.replies.until());
        self.overruns[0] = view.overruns;
        if self.runs(view) && (view.late != 0 || self.overruns[0] != self.overruns[1]) {
            self.note(view);
        }
        self.note_light(view);
        !self.is_behind
    }

    /// Notes light that a fault shut off, or kept from coming, while the program runs.
    fn note_light<const AXES: usize>(&mut self, view: &View<AXES>) {
        let runs = self.runs(view);
        for ((channel, laser), before) in (0..).zip(&view.lasers).zip(&mut self.ignored) {
            let bit = 1 << channel;
            let kept = *before != laser.ignored_count && laser.ignored == Ignored::Fault;
            if runs && laser.fault != Cause::None && (kept || self.lit & bit != 0) {
                self.told |= told::DARK << channel;
            }
            let lit = laser.fault == Cause::None && (laser.commanded || laser.light);
            self.lit = self.lit & !bit | if lit { bit } else { 0 };
            *before = laser.ignored_count;
        }
    }

    /// Notes what was late or took too long, while the replies of these entries wait.
    fn note<const AXES: usize>(&mut self, view: &View<AXES>) {
        // The record of an entry is the first one whose last entry is that one or a later one.
        let tag = |seq: u32| {
            let reaches =
                |last: u32| last & PROGRAM_FLAG != 0 && last.wrapping_sub(seq) & !PROGRAM_FLAG < PROGRAM_FLAG >> 1;
            let waiting = || self.replies.items.iter().find(|item| item.own && item.seq.is_some_and(reaches));
            let (last, tag) = self.answered;
            if reaches(last) { Some(tag) } else { waiting().map(|item| item.tag) }
        };
        let (late, overran) = (tag(view.first_late), tag(view.overran));
        if let Some(tag) = late.filter(|_| view.first_late != 0 && self.told & told::LATE == 0) {
            (self.late_tag, self.told) = (tag, self.told | told::LATE);
        }
        if let Some(tag) = overran.filter(|_| view.overran != 0 && self.told & told::OVERRAN == 0) {
            (self.overran_tag, self.told) = (tag, self.told | told::OVERRAN);
        }
        if view.late_light {
            self.told |= told::LATE_LIGHT;
        }
        if self.overruns[0] != self.overruns[1] {
            for (channel, laser) in view.lasers.iter().enumerate().take(4) {
                self.told |= if laser.fault == Cause::Overrun { told::DARK << channel } else { 0 };
            }
        }
    }

    /// Renews the numbers of what was executed.
    pub fn renew<const AXES: usize>(&mut self, view: &View<AXES>) {
        [&mut self.run, &mut self.end, &mut self.dropping].into_iter().flatten().for_each(|seq| renew(view, seq));
        self.pauses.renew(view);
    }

    /// Advances the numbers of the lane, for tests of counters.
    pub fn age(&mut self, entries: u32) {
        self.lane.age(entries);
    }

    /// Does all that is possible now. True if something was done.
    pub fn advance<const AXES: usize>(
        &mut self,
        admission: &mut Admission<'_, AXES>,
        view: &View<AXES>,
        out: &mut ReplyWriter,
    ) -> bool {
        self.urgent = false;
        if self.runs(view) {
            self.clock = view.now.0.saturating_sub(view.script_zero.0);
            self.instant = self.pauses.resolve(view, self.instant, || self.lane.changes(view));
        }
        let mut progress = false;
        if self.drop_due {
            self.push_drop(admission);
        }
        if self.dropping.is_some_and(|seq| executed(view, seq)) {
            self.finish_drop(admission, view);
            progress = true;
        }
        progress |= self.answer(admission, view, out);
        if self.is_dropping() {
            return progress;
        }
        if self.end.is_some_and(|seq| executed(view, seq)) {
            // Complete: what comes now belongs to a later program.
            (self.end, self.run, self.delay, self.instant) = (None, None, 0, 0);
            self.state = if self.records.is_empty() { State::Empty } else { State::Held };
            progress = true;
        }
        match self.state {
            State::Running if self.strict && view.late > 0 && self.runs(view) => {
                self.late();
                self.push_drop(admission);
                true
            }
            State::Held | State::Running => self.take_records(admission, view, out) || progress,
            State::Failed | State::Stopped => self.discard(out) || progress,
            State::Empty => progress,
        }
    }
}
