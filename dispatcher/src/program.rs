//! The program queue (SPEC 7): timed commands on the controller's own script clock.
//!
//! In: records of lane 1, the view. Out: entries of the program lane, replies in order. Owns: the
//! waiting records, the script's accumulated delay, the replies that wait for execution.
//!
//! Records are admitted in order, ahead of the script clock as far as the ring has room. A record that
//! is refused now may be right later, so it waits; it is refused when its instant has been reached
//! and the state still forbids it. Then, and after a late entry of a strict program, a Stop, link
//! loss or ProgramClear, the rest is dropped from the ring and answered `Discarded`, and the books go
//! back to what was executed.
//!
//! Flow: a record takes its body and 7 bytes of the queue. One that does not fit is answered
//! `QueueFull` at once, and so is every later one until the client has asked for ProgramStatus: the
//! client goes back and sends them again, and no order is lost. So lane 0 never waits behind lane 1.
use crate::admit::pt;
use crate::books::{Change, PROGRAM_FLAG, executed};
use crate::bytes::{QUEUE_BYTES, RECORD_BYTES, Records};
use crate::case::{Answer, Case, Effect};
use crate::desk::{Awaiting, Desk, Step, TickRefusal};
use crate::lane::{Deque, Lane, STAGED, Staged};
use crate::refuse::{Admitted, Refused};
use crate::server::PROGRAM;
use protocol::command::{ProgramReply, ProgramStart, Request, Sleep, WaitStop, opcode};
use protocol::reason::Reason;
use protocol::record::{Full, ReplyWriter, RequestRecord};
use ring::Producer;
use servo::op::{Entry, Op};
use servo::units::{Axis, AxisMask};
use servo::view::View;
use zerocopy::{FromBytes, IntoBytes};

/// Replies that wait for the execution of their entries.
const AWAITING: usize = 512;
/// Records admitted in one go, so that the work of a poll is bounded.
const RECORDS_PER_POLL: u32 = 256;

/// Where the program is; the numbers are those of `ProgramReply`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// No program.
    Empty = 0,
    /// Entries gather; the clock stands.
    Held = 1,
    /// The clock runs.
    Running = 2,
    /// An entry failed; the rest is discarded until ProgramClear.
    Failed = 3,
    /// Stop or link loss ended it; the rest is discarded until ProgramClear.
    Stopped = 4,
}

/// The program queue.
pub struct Program<'a> {
    lane: Lane<'a, PROGRAM>,
    records: Records,
    awaiting: Deque<Awaiting, AWAITING>,
    refused: Deque<TickRefusal, 8>,
    state: State,
    /// Script time since the last entry pushed, ns.
    delay: u64,
    /// Axes with data in FIFO 0, FIFO 1 that the tick does not know of yet.
    open: [u64; 2],
    /// The ProgramRun of this program.
    run: Option<u32>,
    /// The ProgramEnd of this program, once admitted.
    end: Option<u32>,
    /// The rest is to be dropped: not pushed yet, or pushed with this number.
    drop_due: bool,
    dropping: Option<u32>,
    /// ProgramClear or a new session: empty when all is answered.
    clearing: bool,
    strict: bool,
    /// A record did not fit: nothing more is taken until the client has looked.
    overflowed: bool,
    /// Nothing more can be admitted before the tick or the client does something.
    settled: bool,
    /// The record in hand waits for the machine and must not miss the tick.
    urgent: bool,
    config: Option<u16>,
    /// The script clock when the program was last seen to run, ns.
    clock: u64,
    accepted: u32,
    done: u32,
}

impl<'a> Program<'a> {
    /// An empty queue.
    pub fn new(ring: Producer<'a, Entry, PROGRAM>) -> Self {
        Program {
            lane: Lane::new(ring, PROGRAM_FLAG),
            records: Records::new(),
            awaiting: Deque::new(Awaiting::BLANK),
            refused: Deque::new((0, Axis::default(), 0)),
            state: State::Empty,
            delay: 0,
            open: [0; 2],
            run: None,
            end: None,
            drop_due: false,
            dropping: None,
            clearing: false,
            strict: false,
            overflowed: false,
            settled: true,
            urgent: false,
            config: None,
            clock: 0,
            accepted: 0,
            done: 0,
        }
    }

    /// Whether its clock runs in the tick that `view` shows.
    fn runs<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        self.state == State::Running && self.run.is_some_and(|run| executed(view, run))
    }

    /// Whether it is held or runs.
    pub fn is_active(&self) -> bool {
        matches!(self.state, State::Held | State::Running)
    }

    /// Whether the record in hand may become right with any tick. One that waits for places in a FIFO
    /// ahead of its time is in no hurry.
    pub fn is_urgent(&self) -> bool {
        self.urgent
    }

    fn is_dropping(&self) -> bool {
        self.drop_due || self.dropping.is_some()
    }

    /// Takes a record of lane 1 into the queue.
    pub fn offer(&mut self, record: &RequestRecord, out: &mut ReplyWriter) -> Step {
        if self.overflowed || record.body.len() + RECORD_BYTES > self.records.space() {
            let full = Refused::new(Reason::QueueFull)
                .got(self.records.space() as f64)
                .limits(0.0, QUEUE_BYTES as f64);
            let step = Step::of(out.refused(record.opcode, record.tag, &full.wire));
            self.overflowed |= step == Step::Taken;
            return step;
        }
        if self.state == State::Empty {
            self.state = State::Held;
            (self.accepted, self.done, self.delay) = (0, 0, 0);
        }
        self.records.push(record.opcode, record.tag, record.body);
        self.accepted = self.accepted.wrapping_add(1);
        self.settled = false;
        Step::Taken
    }

    /// ProgramStart, ProgramClear, ProgramStatus. `None`: not now.
    pub fn control<const AXES: usize>(
        &mut self,
        desk: &mut Desk<'_, AXES>,
        record: &RequestRecord,
    ) -> Admitted<Option<Answer>> {
        match record.opcode {
            opcode::ProgramStart => {
                let start = ProgramStart::read_from_bytes(record.body).map_err(|_| length::<ProgramStart>(record.body))?;
                if self.is_dropping() || !self.settled {
                    return Ok(None);
                }
                if !matches!(self.state, State::Empty | State::Held) {
                    return Err(Refused::new(Reason::ProgramOnlyHeld));
                }
                if !desk.lane.push(Op::ProgramRun, Change::None, 0, &mut desk.ahead) {
                    return Ok(None);
                }
                if self.state == State::Empty {
                    (self.accepted, self.done, self.delay) = (0, 0, 0);
                }
                self.run = Some(desk.lane.last());
                self.clock = 0;
                self.strict = start.strict != 0;
                self.state = State::Running;
                Ok(Some(Answer::Program))
            }
            opcode::ProgramClear => {
                if !record.body.is_empty() {
                    return Err(length::<protocol::command::ProgramClear>(record.body));
                }
                if self.state == State::Empty && !self.clearing {
                    return Ok(Some(Answer::Program));
                }
                if !self.clearing {
                    self.cut(State::Stopped);
                    self.clearing = true;
                }
                // `advance` empties it; the reply tells that it is done.
                Ok(None)
            }
            _ => {
                if !record.body.is_empty() {
                    return Err(length::<protocol::command::ProgramStatus>(record.body));
                }
                // The client has looked: it knows what was taken.
                self.overflowed = false;
                Ok(Some(Answer::Program))
            }
        }
    }

    /// The reply to a program command.
    pub fn status<const AXES: usize>(&self, view: &View<AXES>, opcode: u16, tag: u16, out: &mut ReplyWriter) -> Result<(), Full> {
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
        };
        out.push_raw(opcode, tag, 0, &[reply.as_bytes()])
    }

    /// Stop in the immediate lane, or link loss: a running program ends. The ProgramDrop goes out before
    /// the Stop does, so that no entry starts the axes again.
    pub fn stop<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>) {
        if self.state == State::Running {
            self.cut(State::Stopped);
            self.push_drop(desk);
        }
    }

    /// A new session: entries and replies of the one before are void. Motion that runs goes on.
    pub fn abandon(&mut self) {
        if self.state != State::Empty {
            self.cut(State::Stopped);
            self.clearing = true;
        }
        self.records.clear();
        self.awaiting.clear();
        self.config = None;
        self.overflowed = false;
    }

    /// The tick refused a start: the program has failed there.
    pub fn tick_refused(&mut self, refusal: TickRefusal) {
        self.refused.push(refusal);
        if self.is_active() {
            self.cut(State::Failed);
        }
    }

    fn cut(&mut self, state: State) {
        if self.is_active() {
            self.drop_due = true;
        }
        self.state = state;
    }

    fn push_drop<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>) {
        if self.drop_due && desk.lane.push(Op::ProgramDrop, Change::None, 0, &mut desk.ahead) {
            self.drop_due = false;
            self.dropping = Some(desk.lane.last());
        }
    }

    /// The tick has dropped the rest.
    fn finish_drop<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, view: &View<AXES>) {
        self.dropping = None;
        self.lane.forget();
        desk.ahead = desk.now;
        desk.lane.replay(&mut desk.ahead);
        self.awaiting.amend_back(|item| {
            item.discarded |= item.open || item.seq.is_some_and(|seq| !executed(view, seq));
            item.open = false;
            true
        });
        (self.delay, self.open, self.run, self.end, self.config) = (0, [0; 2], None, None, None);
    }

    /// Everything the queue can do now. True if something was done.
    pub fn advance<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, view: &View<AXES>, out: &mut ReplyWriter) -> bool {
        self.lane.retire(view, &mut desk.now);
        self.urgent = false;
        if self.runs(view) {
            self.clock = view.now.0.saturating_sub(view.script_zero.0);
        }
        let mut progress = false;
        if self.drop_due {
            self.push_drop(desk);
        }
        if self.dropping.is_some_and(|seq| executed(view, seq)) {
            self.finish_drop(desk, view);
            progress = true;
        }
        progress |= self.answer(desk, view, out);
        if self.is_dropping() {
            return progress;
        }
        if self.end.is_some_and(|seq| executed(view, seq)) {
            // Complete: what comes now belongs to a later program.
            (self.end, self.run, self.delay) = (None, None, 0);
            self.state = if self.records.is_empty() { State::Empty } else { State::Held };
            progress = true;
        }
        match self.state {
            State::Running if self.strict && view.late > 0 && self.runs(view) => {
                self.late();
                self.push_drop(desk);
                true
            }
            State::Held | State::Running => self.take_records(desk, view, out) || progress,
            State::Failed | State::Stopped => self.discard(out) || progress,
            State::Empty => progress,
        }
    }

    /// A strict program was late: what follows is not executed. The next entry says why.
    fn late(&mut self) {
        self.cut(State::Failed);
        self.refused.push((0, Axis::default(), 0));
    }

    /// Answers what was executed or dropped, in order.
    fn answer<const AXES: usize>(&mut self, desk: &Desk<'_, AXES>, view: &View<AXES>, out: &mut ReplyWriter) -> bool {
        let mut progress = false;
        while let Some(&item) = self.awaiting.front() {
            if item.open || !item.discarded && item.seq.is_some_and(|seq| !executed(view, seq)) {
                break;
            }
            let refusal = self.refused.front().copied().filter(|&(seq, ..)| {
                if seq == 0 { item.discarded } else { item.own && item.seq == Some(seq) }
            });
            let written = match refusal {
                Some((0, ..)) => out.refused(item.opcode, item.tag, &Refused::new(Reason::Late).wire),
                Some((_, axis, status)) => out.refused(item.opcode, item.tag, &desk.explain(axis, status).wire),
                None if item.discarded => out.refused(item.opcode, item.tag, &Refused::new(Reason::Discarded).wire),
                None => desk.reply(view, self, &item, out),
            };
            if written.is_err() {
                break;
            }
            if refusal.is_some() {
                self.refused.pop();
            } else if !item.discarded {
                self.done = self.done.wrapping_add(1);
            }
            self.awaiting.pop();
            progress = true;
        }
        progress
    }

    /// Answers the records that wait: they are not executed.
    fn discard(&mut self, out: &mut ReplyWriter) -> bool {
        if !self.awaiting.is_empty() {
            return false;
        }
        let mut progress = false;
        while let Some((head, _)) = self.records.front() {
            // A strict program that was late with nothing in the ring says so at its next record.
            let late = self.refused.front().is_some_and(|&(seq, ..)| seq == 0);
            let reason = if late { Reason::Late } else { Reason::Discarded };
            if out.refused(head.opcode, head.tag, &Refused::new(reason).wire).is_err() {
                return progress;
            }
            if late {
                self.refused.pop();
            }
            self.records.pop();
            progress = true;
        }
        if self.clearing {
            self.clearing = false;
            self.overflowed = false;
            self.state = State::Empty;
            self.refused.clear();
            progress = true;
        }
        self.settled = true;
        progress
    }

    /// Admits records until one has to wait. True if at least one was dealt with.
    fn take_records<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, view: &View<AXES>, out: &mut ReplyWriter) -> bool {
        let mut progress = false;
        for _ in 0..RECORDS_PER_POLL {
            // Room for the command and, before it, the commits of all axes.
            let room = self.lane.room() >= STAGED + 2 * AXES && !self.awaiting.is_full();
            if self.end.is_some() || !room || self.records.front().is_none() {
                self.flush(desk);
                self.settled = true;
                return progress;
            }
            match self.take_record(desk, view) {
                Ok(Step::Taken) => {
                    self.records.pop();
                    progress = true;
                }
                Ok(Step::Wait) => {
                    self.flush(desk);
                    self.settled = true;
                    return progress;
                }
                Err(refused) => {
                    self.flush(desk);
                    self.settled = true;
                    return self.refuse(desk, view, &refused, out) || progress;
                }
            }
        }
        progress
    }

    /// The record in hand is refused: for good, if its instant has been reached.
    fn refuse<const AXES: usize>(
        &mut self,
        desk: &mut Desk<'_, AXES>,
        view: &View<AXES>,
        refused: &Refused,
        out: &mut ReplyWriter,
    ) -> bool {
        let runs = self.runs(view);
        self.urgent = runs && (refused.reason != Reason::FifoFull || !self.lane.in_flight());
        let instant = view.script_zero.0.saturating_add(view.script.0).saturating_add(self.delay);
        if !runs || self.lane.in_flight() || !self.awaiting.is_empty() || view.now.0 <= instant {
            return false;
        }
        let Some((head, _)) = self.records.front() else { return false };
        if out.refused(head.opcode, head.tag, &refused.wire).is_err() {
            return false;
        }
        self.records.pop();
        self.cut(State::Failed);
        self.push_drop(desk);
        true
    }

    /// Admits the record in hand and pushes what it becomes.
    fn take_record<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, view: &View<AXES>) -> Admitted<Step> {
        let Some((head, body)) = self.records.front() else { return Ok(Step::Wait) };
        let (answer, effect, own) = match head.opcode {
            opcode::ProgramStart | opcode::ProgramClear | opcode::ProgramStatus | opcode::SetTick | opcode::Choose => {
                return Err(Refused::new(Reason::NotForProgram));
            }
            opcode::Sleep => {
                let sleep = Sleep::read_from_bytes(body).map_err(|_| length::<Sleep>(body))?;
                if sleep.ns.get() > 0 {
                    self.flush(desk);
                }
                self.delay = self.delay.saturating_add(sleep.ns.get());
                self.attach(head.opcode, head.tag, Answer::Done);
                return Ok(Step::Taken);
            }
            opcode::PtData | opcode::PtDataMany => {
                let written = desk.admit_data(view, head.opcode, body)?;
                return Ok(self.take_data(desk, head.opcode, head.tag, &written));
            }
            opcode::WaitStop => {
                let wait = WaitStop::read_from_bytes(body).map_err(|_| length::<WaitStop>(body))?;
                wait_stop(desk, view, &wait)?;
                (Answer::Done, Effect::None, true)
            }
            opcode::ProgramEnd => {
                if !body.is_empty() {
                    return Err(length::<protocol::command::ProgramEnd>(body));
                }
                desk.staged.clear();
                desk.staged.add(Op::ProgramEnd, Change::None);
                (Answer::Done, Effect::None, true)
            }
            _ if self.config.is_some() => (Answer::Done, Effect::Config, true),
            other => {
                let (answer, effect) = desk.admit(view, other, body)?;
                (answer, effect, true)
            }
        };
        if let Effect::Config = effect {
            return Ok(self.take_config(desk, view));
        }
        if desk.staged.ops().is_empty() {
            if let Answer::Read(_) = answer {
                self.flush(desk);
                // A read at the instant of the entry before needs no entry of its own.
                if self.delay > 0 || !self.lane.in_flight() {
                    self.push(desk, Op::Mark, Change::None);
                }
            }
            desk.apply(effect, self.lane.last());
            self.attach(head.opcode, head.tag, answer);
            return Ok(Step::Taken);
        }
        self.flush(desk);
        let count = desk.staged.ops().len();
        for index in 0..count {
            if let Some(&(op, change)) = desk.staged.ops().get(index) {
                self.push(desk, op, change);
            }
        }
        desk.apply(effect, self.lane.last());
        if head.opcode == opcode::ProgramEnd {
            self.end = Some(self.lane.last());
        }
        self.awaiting.push(Awaiting {
            opcode: head.opcode,
            tag: head.tag,
            seq: Some(self.lane.last()),
            own,
            answer,
            ..Awaiting::BLANK
        });
        Ok(Step::Taken)
    }

    /// Pushes one entry; the caller has seen that there is room.
    fn push<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, op: Op, change: Change) {
        if self.lane.push(op, change, self.delay, &mut desk.ahead) {
            self.delay = 0;
        }
    }

    /// Answers together with the entry before, or at once if that was executed.
    fn attach(&mut self, opcode: u16, tag: u16, answer: Answer) {
        let open = self.open != [0; 2];
        let seq = self.lane.in_flight().then(|| self.lane.last());
        self.awaiting.push(Awaiting { opcode, tag, seq, open, answer, ..Awaiting::BLANK });
    }

    /// PT data is in the store; one commit will show all that belongs to this instant.
    fn take_data<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, opcode: u16, tag: u16, written: &pt::Written) -> Step {
        pt::enter(&mut desk.ahead, written);
        self.open[usize::from(written.fifo) & 1] |= written.axis.mask().0;
        let answer = Answer::Taken { axis: written.axis, fifo: written.fifo, count: written.count };
        self.awaiting.push(Awaiting { opcode, tag, open: true, own: true, answer, ..Awaiting::BLANK });
        Step::Taken
    }

    /// Pushes the commits of the data that gathered.
    fn flush<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>) {
        if self.open == [0; 2] || self.lane.room() < 2 * AXES {
            return;
        }
        for fifo in 0..2u8 {
            let axes = AxisMask(self.open[usize::from(fifo)]);
            for axis in (0..AXES).filter_map(Axis::new).filter(|&axis| axes.has(axis)) {
                let book = desk.ahead.axis(axis);
                let (epoch, data) = (book.epoch, book.fifos[usize::from(fifo)]);
                let op = Op::PtCommit { axis, fifo, end: data.end, epoch };
                self.push(desk, op, Change::Data { axis, fifo, epoch, book: data });
            }
        }
        self.open = [0; 2];
        let last = self.lane.last();
        self.awaiting.amend_back(|item| {
            let open = item.open;
            if open {
                (item.open, item.seq) = (false, Some(last));
            }
            open
        });
    }

    /// LoadConfig, item by item.
    fn take_config<const AXES: usize>(&mut self, desk: &mut Desk<'_, AXES>, view: &View<AXES>) -> Step {
        self.flush(desk);
        let mut item = self.config.unwrap_or(0);
        loop {
            self.config = Some(item);
            if self.lane.room() < STAGED {
                return Step::Wait;
            }
            let Some((head, body)) = self.records.front() else { return Step::Wait };
            if !desk.stage_config(view, body, item) {
                self.config = None;
                self.attach(head.opcode, head.tag, Answer::Done);
                return Step::Taken;
            }
            for index in 0..desk.staged.ops().len() {
                if let Some(&(op, change)) = desk.staged.ops().get(index) {
                    self.push(desk, op, change);
                }
            }
            item = item.saturating_add(1);
        }
    }
}

/// Stages a WaitStop. No crd can run in this build's commands, so their bits wait for nothing.
fn wait_stop<const AXES: usize>(desk: &mut Desk<'_, AXES>, view: &View<AXES>, wait: &WaitStop) -> Admitted<()> {
    desk.staged.clear();
    let mut staged = Staged::new();
    let case = Case {
        view,
        books: &desk.ahead,
        site: &desk.site,
        board: &desk.board,
        staged: &mut staged,
        effect: Effect::None,
    };
    let axes = case.mask(wait.core.get(), wait.axes.get(), 1)?;
    let crds = u32::from(desk.site.profile.crds_per_core);
    let (given, all) = (wait.crds.get().cast_unsigned(), (1u32 << crds) - 1);
    if given & !all != 0 {
        return Err(Refused::new(Reason::OutOfRange).field(2).got(given.into()).limits(0.0, all.into()));
    }
    if axes.0 != 0 {
        desk.staged.add(Op::WaitRest { axes }, Change::Rest { axes });
    }
    Ok(())
}

fn length<R: Request>(body: &[u8]) -> Refused {
    let wanted = size_of::<R>() as f64;
    Refused::new(Reason::Length).got(body.len() as f64).limits(wanted, wanted)
}
