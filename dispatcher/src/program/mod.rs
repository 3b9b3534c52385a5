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
mod pending_commits;
pub(crate) mod record_queue;
mod reported;
mod script;
mod waits;

use crate::admit::admission::Admission;
use crate::admit::context::DueInstant;
use crate::admit::joined::PathManyProgress;
use crate::admit::one;
use crate::capacity::{AWAITING_REPLIES, AWAITING_VALUES};
use crate::refuse::{Admitted, FifoOf, Refused};
use crate::report::answer::Sent;
use crate::report::pending_replies::{PendingReplies, RecordOutcome};
use crate::shadow::{PROGRAM_FLAG, ShadowChange, Shadows, executed, renew};
use crate::tick_queue::TickQueue;
use pending_commits::PendingCommits;
use protocol::command::{ProgramClear, ProgramReply, ProgramStart, ProgramStatus, opcode};
use protocol::reason::Reason;
use protocol::record::{Lane, ReplyWriter, RequestRecord};
use protocol::values::program;
use record_queue::{QUEUE_BYTES, RECORD_BYTES, RecordHead, Records};
use reported::Reported;
use ring::Producer;
use script::ScriptShadow;
use servo::tick::PROGRAM_ENTRIES;
use servo::tick_command::{LaneEntry, TickCommand};
use servo::view::View;
use zerocopy::IntoBytes;

/// Data of a stream that comes after its instant acts so long after the view, if its FIFO is half
/// full still: writing a group of lines takes less.
const STREAM_LEAD_NS: u64 = 4_000_000;

/// What the program works on while the server polls.
pub struct Poll<'p, 'a, 'o, const AXES: usize> {
    /// Admission, which serves both lanes.
    pub admission: &'p mut Admission<'a, AXES>,
    /// The newest view.
    pub view: &'p View<AXES>,
    /// Takes the replies.
    pub out: &'p mut ReplyWriter<'o>,
}

/// State of the program; the numbers are those of `ProgramReply`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProgramState {
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

/// Entries of the lane that bound the run of this program.
#[derive(Debug, Default)]
struct Run {
    /// The ProgramRun.
    start: Option<u32>,
    /// The ProgramEnd, once admitted.
    end: Option<u32>,
}

/// Whether the tick has to drop what is in the ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ProgramDrop {
    None,
    /// It has, and does not know yet.
    Due,
    /// The tick command is pushed, with this number.
    Pushed(u32),
}

/// How a program is cut, answered and forgotten.
#[derive(Debug)]
struct Ending {
    /// It ends with its first late entry.
    strict: bool,
    drop: ProgramDrop,
    /// The reason with which the rest is answered.
    reason: Reason,
    /// ProgramClear or a new session: empty when all is answered.
    clears: bool,
}

servo::state! {
    /// The program queue.
    pub struct Program<'a> {
        pub(crate) lane: TickQueue<'a, PROGRAM_ENTRIES> = TickQueue::new(ring, PROGRAM_FLAG),
        records: Records = Records::new(),
        replies: PendingReplies<AWAITING_REPLIES, AWAITING_VALUES> = PendingReplies::new(),
        state: ProgramState = ProgramState::Empty,
        run: Run = Run::default(),
        script: ScriptShadow = ScriptShadow::default(),
        pending_commits: PendingCommits = PendingCommits::default(),
        ending: Ending = Ending { strict: false, drop: ProgramDrop::None, reason: Reason::Discarded, clears: false },
        reported: Reported = Reported::default(),
        /// The item of LoadConfig in hand.
        config: Option<u16> = None,
        /// The PathMany in hand.
        joined: PathManyProgress = PathManyProgress::default(),
        /// Calls of the first PathMany that has no reply yet, executed.
        joined_done: u16 = 0,
        /// The executed state waits for the first of the replies.
        is_lagging: bool = false,
        /// A record did not fit: nothing more is taken until the client has asked for
        /// ProgramStatus.
        overflowed: bool = false,
        /// Nothing more can be admitted before the tick or the client acts.
        admission_waits: bool = true,
        /// The record in hand waits for the machine and must not miss the tick: it may become right
        /// with any. One that waits for slots in a FIFO ahead of its time is not urgent.
        pub(crate) urgent: bool = false,
        /// The data in hand waits for room in this FIFO, whose motion runs.
        waits_for: Option<(FifoOf, u8)> = None,
    }
    /// An empty queue.
    pub fn new(ring: Producer<'a, LaneEntry, PROGRAM_ENTRIES>);
}

impl<'a> Program<'a> {
    /// The counts and the clock of a new program.
    fn begin(&mut self) {
        self.waits_for = None;
        self.reported.begin();
        self.script.begin();
    }

    /// Whether all that was admitted has been executed.
    pub fn is_quiet(&self) -> bool {
        !self.lane.in_flight() && !self.has_pending_commits()
    }

    /// Whether its clock runs in the tick that `view` shows.
    fn runs<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        self.state == ProgramState::Running && self.run.start.is_some_and(|run| executed(view, run))
    }

    /// Whether the instant of the record in hand is over, and all that was before it in either
    /// lane: what a look-ahead gives to its path goes through the immediate one.
    fn is_past<const AXES: usize>(&self, admission: &Admission<AXES>, view: &View<AXES>) -> bool {
        let instant = self.script.instant_after(view);
        let quiet = !self.lane.in_flight() && !admission.lane.in_flight() && self.replies.items.is_empty();
        self.runs(view) && quiet && view.now.0 > instant
    }

    /// Whether the view is the last one before the tick on which the record in hand would act, and
    /// shows everything admitted before it.
    fn is_reached<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        let instant = self.script.instant_after(view);
        self.runs(view) && self.is_quiet() && instant < view.now.0.saturating_add(view.period.0)
    }

    /// Whether the view is the last one before the tick on which the record in hand would act, and
    /// nothing in flight before it may end what keeps it from being taken.
    fn is_settled<const AXES: usize>(&self, view: &View<AXES>, reason: Reason) -> bool {
        !self.lane.may_free(reason) && self.until(view) < view.period.0
    }

    /// From the view to the instant of the record in hand, ns; `u64::MAX` where that is not known.
    /// After ProgramStart the clock begins on the tick after the view.
    fn until<const AXES: usize>(&self, view: &View<AXES>) -> u64 {
        let begun = self.state == ProgramState::Running && self.run.start.is_some();
        if !begun || self.script.pauses.wait() {
            return u64::MAX;
        }
        let zero = if self.runs(view) { view.script_zero.0 } else { view.now.0 };
        self.script.instant_from(zero).saturating_sub(view.now.0)
    }

    /// Whether the record in hand acts soon, and nothing before it is in flight.
    fn is_soon<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        let instant = self.script.instant_from(view.script_zero.0);
        self.runs(view) && self.is_quiet() && instant <= view.now.0.saturating_add(intake::COMMIT_LEAD_NS)
    }

    /// What is known of the instant of the record in hand.
    fn due<const AXES: usize>(&self, view: &View<AXES>) -> DueInstant {
        let decided = self.is_reached(view);
        let script_ns = self.script.instant();
        let until_ns = if decided { 0 } else { self.until(view) };
        let first = self.state == ProgramState::Held && script_ns < view.period.0 && !self.script.pauses.wait();
        let wait = self.script.pauses.last;
        DueInstant { soon: self.is_soon(view), until_ns, first, script_ns, wait, ..DueInstant::at_once(decided) }
    }

    /// Data has been written to a FIFO. The clock waits for a stream: for data that has waited for
    /// room, and for data that follows other data, or a start, of its instant and comes after that.
    fn stream<const AXES: usize>(&mut self, admission: &Admission<AXES>, view: &View<AXES>, fifo: (FifoOf, u8)) {
        let has_waited = self.waits_for.take().is_some();
        let follows = || self.script.delay == 0 && admission.drains(view, fifo);
        let is_past = self.script.instant_from(view.script_zero.0) < view.now.0;
        if self.runs(view) && !self.script.pauses.wait() && is_past && (has_waited || follows()) {
            let is_in_time = admission.free_quarters(view, fifo) < 2;
            let lead_ns = if is_in_time { STREAM_LEAD_NS } else { 2 * view.period.0 };
            self.script.catch_up(view, lead_ns);
        }
    }

    /// Whether it is held or runs.
    pub fn is_active(&self) -> bool {
        matches!(self.state, ProgramState::Held | ProgramState::Running)
    }

    fn is_dropping(&self) -> bool {
        self.ending.drop != ProgramDrop::None
    }

    /// Takes a record of lane 1 into the queue; data that need not wait is admitted at once.
    pub fn offer<const AXES: usize>(&mut self, poll: &mut Poll<AXES>, record: &RequestRecord) -> RecordOutcome {
        let may_fail = record.lane == Lane::ProgramMayFail;
        let head = RecordHead { opcode: record.opcode, tag: record.tag, may_fail };
        let view = poll.view;
        if self.takes_at_once::<AXES>(record.opcode, record.body) {
            // If it is refused it waits in the queue, and is refused from there.
            if let Ok(written) = poll.admission.admit_data(view, self.due(view), record.opcode, record.body) {
                self.reported.accepted = self.reported.accepted.wrapping_add(1);
                self.stream(poll.admission, view, (written.of, written.fifo));
                self.replies.keep(written.waiting());
                self.commit_data(poll.admission, head, &written);
                return RecordOutcome::Taken;
            }
        }
        if self.overflowed || record.body.len() + RECORD_BYTES > self.records.space() {
            let full = Refused::new(Reason::QueueFull).got(self.records.space() as f64).limits(0.0, QUEUE_BYTES as f64);
            let step = RecordOutcome::of(poll.out.refused(record.opcode, record.tag, &full.wire));
            self.overflowed |= step == RecordOutcome::Taken;
            return step;
        }
        if self.state == ProgramState::Empty {
            self.state = ProgramState::Held;
            self.begin();
        }
        self.records.push(head, record.body);
        self.reported.accepted = self.reported.accepted.wrapping_add(1);
        self.admission_waits = false;
        RecordOutcome::Taken
    }

    /// ProgramStart, ProgramClear, ProgramStatus.
    pub fn control<const AXES: usize>(
        &mut self,
        admission: &mut Admission<AXES>,
        record: &RequestRecord,
    ) -> Admitted<RecordOutcome> {
        match record.opcode {
            opcode::ProgramStart => {
                let start: ProgramStart = one(record.body)?;
                if self.is_dropping() || !self.admission_waits {
                    return Ok(RecordOutcome::Wait);
                }
                if !matches!(self.state, ProgramState::Empty | ProgramState::Held) {
                    return Err(Refused::new(Reason::ProgramOnlyHeld));
                }
                if admission.lane.room() == 0 {
                    return Ok(RecordOutcome::Wait);
                }
                if self.state == ProgramState::Empty {
                    self.begin();
                }
                // All of the instant 0 is in the ring before the clock runs.
                self.flush(admission);
                admission.push(TickCommand::ProgramRun, ShadowChange::None);
                self.run.start = Some(admission.lane.last);
                self.script.clock = 0;
                (self.reported.overruns[1], self.reported.answered) = (self.reported.overruns[0], (0, 0));
                self.ending.strict = start.strict != 0;
                self.state = ProgramState::Running;
                Ok(RecordOutcome::Taken)
            }
            opcode::ProgramClear => {
                one::<ProgramClear>(record.body)?;
                if self.state == ProgramState::Empty && !self.ending.clears {
                    return Ok(RecordOutcome::Taken);
                }
                if !self.ending.clears {
                    self.cut(ProgramState::Stopped);
                    self.ending.clears = true;
                }
                // `advance` empties it; the reply reports that it is done.
                Ok(RecordOutcome::Wait)
            }
            _ => {
                one::<ProgramStatus>(record.body)?;
                // The client has asked: it knows what was taken.
                self.overflowed = false;
                Ok(RecordOutcome::Taken)
            }
        }
    }

    /// The reply to a program command.
    pub fn status<const AXES: usize>(&self, view: &View<AXES>, opcode: u16, tag: u16, out: &mut ReplyWriter) -> Sent {
        let clock = match self.state {
            ProgramState::Empty | ProgramState::Held => view.script.0,
            ProgramState::Running | ProgramState::Failed | ProgramState::Stopped => self.script.clock,
        };
        let reply = ProgramReply {
            accepted: self.reported.accepted.into(),
            executed: self.reported.executed.into(),
            space_bytes: (self.records.space() as u32).into(),
            late: view.late.into(),
            worst_late_us: u32::try_from(view.worst_late.0.div_ceil(1000)).unwrap_or(u32::MAX).into(),
            state: self.state as u8,
            clock_ns: clock.into(),
            overruns: view.overruns.wrapping_sub(self.reported.overruns[1]).into(),
            late_tag: self.reported.late_tag.into(),
            overran_tag: self.reported.overran_tag.into(),
            reported: self.reported.bits,
        };
        out.push_raw(opcode, tag, 0, &[reply.as_bytes()])
    }

    /// Enters into `now` what the tick has executed, and no reply waits for. Returns whether that
    /// is everything.
    pub fn retire<const AXES: usize>(&mut self, view: &View<AXES>, now: &mut Shadows<AXES>) -> bool {
        self.is_lagging = !self.lane.retire(view, now, self.replies.until());
        self.reported.overruns[0] = view.overruns;
        if self.runs(view) && (view.late != 0 || self.reported.overruns[0] != self.reported.overruns[1]) {
            let waiting = self.replies.items.iter().filter(|item| item.own);
            self.reported.note(view, waiting.filter_map(|item| Some((item.seq?, item.tag))));
        }
        self.reported.note_light(view, self.runs(view));
        !self.is_lagging
    }

    /// Renews the numbers of what was executed.
    pub fn renew<const AXES: usize>(&mut self, view: &View<AXES>) {
        [&mut self.run.start, &mut self.run.end].into_iter().flatten().for_each(|seq| renew(view, seq));
        if let ProgramDrop::Pushed(seq) = &mut self.ending.drop {
            renew(view, seq);
        }
        self.script.pauses.renew(view);
    }

    /// Does all that is possible now. True if something was done.
    pub fn advance<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) -> bool {
        let view = poll.view;
        self.urgent = false;
        if self.runs(view) {
            self.script.see(view, || self.lane.changes(view));
        }
        let mut progress = false;
        self.push_drop(poll.admission);
        if matches!(self.ending.drop, ProgramDrop::Pushed(seq) if executed(view, seq)) {
            self.finish_drop(poll);
            progress = true;
        }
        progress |= self.answer(poll);
        if self.is_dropping() {
            return progress;
        }
        if self.run.end.is_some_and(|seq| executed(view, seq)) {
            // Complete: what comes now belongs to a later program.
            (self.run.end, self.run.start) = (None, None);
            self.script.begin();
            self.state = if self.records.is_empty() { ProgramState::Empty } else { ProgramState::Held };
            progress = true;
        }
        match self.state {
            ProgramState::Running if self.ending.strict && view.late > 0 && self.runs(view) => {
                self.late();
                self.push_drop(poll.admission);
                true
            }
            ProgramState::Held | ProgramState::Running => self.take_records(poll) || progress,
            ProgramState::Failed | ProgramState::Stopped => self.discard(poll) || progress,
            ProgramState::Empty => progress,
        }
    }
}
