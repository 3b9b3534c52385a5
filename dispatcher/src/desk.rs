//! The desk: the immediate lane, and what both lanes share.
//!
//! In: records of lane 0, the view. Out: entries of the immediate lane, replies in order. Owns: both
//! sets of books, the profile, link-loss settings, the trace's way out.
//!
//! A command is answered when the tick has executed it, so that the client's next read sees it. A read
//! or a refusal waits until everything before it has been executed, and is then decided on that state.
use crate::admit::pvt_table::{Loading, Road, road};
use crate::admit::{admit, config_item, data, is_read, many, power_on};
use crate::awaiting::{Awaiting, Step, TickRefusal};
use crate::books::{Books, Change, PROGRAM_FLAG, executed};
use crate::case::{Answer, Case, Effect, Site};
use crate::lane::{Deque, Lane, STAGED, Staged};
use crate::program::Program;
use crate::read::{Reading, took_reply, values_reply};
use crate::refuse::{Admitted, Refused};
use crate::server::{Board, IMMEDIATE};
use crate::trace_out::TraceOut;
use protocol::command::{LoadConfig, SetHSIOOpt, opcode};
use protocol::reason::Reason;
use protocol::record::{Full, ReplyWriter, RequestRecord};
use ring::Producer;
use servo::laser::CHANNELS;
use servo::op::{Entry, Mode, Op};
use servo::pt::SegmentStore;
use servo::pvt::TableStores;
use servo::status::{RUNNING, SERVO_ON};
use servo::units::{Axis, AxisMask};
use servo::view::View;
use zerocopy::FromBytes;

/// Whether the record is a SetHSIOOpt that switches a laser off, which is as urgent as a Stop.
fn switches_off(record: &RequestRecord) -> bool {
    record.opcode == opcode::SetHSIOOpt
        && SetHSIOOpt::read_from_bytes(record.body).is_ok_and(|request| request.value.get() == 0)
}

/// The desk.
pub struct Desk<'a, const AXES: usize> {
    /// Constants of the board.
    pub board: Board,
    /// What the client chose.
    pub site: Site,
    /// PT segments.
    pub stores: &'a [SegmentStore; AXES],
    /// PVT tables.
    pub tables: TableStores<'a>,
    /// The one that is being sent.
    pub loading: Loading,
    /// Books after everything executed.
    pub now: Books<AXES>,
    /// Books after everything admitted.
    pub ahead: Books<AXES>,
    /// Operations of the command in hand.
    pub staged: Staged,
    /// The immediate lane.
    pub lane: Lane<'a, IMMEDIATE>,
    awaiting: Deque<Awaiting, IMMEDIATE>,
    refused: Deque<TickRefusal, 8>,
    /// What the laser commands among them took, in order.
    taken: Deque<f64, TAKEN>,
    /// Item of the LoadConfig in hand that is pushed next.
    config: Option<u16>,
    /// Link-loss time in ms, 0 is off; whether all axes stop.
    pub link_loss: (u32, bool),
    /// The trace.
    pub trace: TraceOut<AXES>,
}

/// Numbers that laser commands took and whose replies wait.
const TAKEN: usize = 64;
/// Most of one command.
pub const TAKEN_MAX: usize = 3;

/// Power-on link-loss time (SPEC 9).
const LINK_LOSS_MS: u32 = 500;

impl<'a, const AXES: usize> Desk<'a, AXES> {
    /// A desk at power-on.
    pub fn new(
        board: Board,
        stores: &'a [SegmentStore; AXES],
        tables: TableStores<'a>,
        ring: Producer<'a, Entry, IMMEDIATE>,
    ) -> Self {
        let mut desk = Desk {
            site: Site::new(board.profile, 0),
            board,
            stores,
            tables,
            loading: Loading::new(),
            now: Books::new(),
            ahead: Books::new(),
            staged: Staged::new(),
            lane: Lane::new(ring, 0),
            awaiting: Deque::new(Awaiting::BLANK),
            refused: Deque::new((0, Axis::default(), 0)),
            taken: Deque::new(0.0),
            config: None,
            link_loss: (LINK_LOSS_MS, false),
            trace: TraceOut::new(),
        };
        // The tick does not know families.
        for channel in 0..CHANNELS as u8 {
            for (change, entered) in power_on(desk.site.family) {
                let op = Op::Laser { channel, change };
                desk.lane.push(op, Change::Laser { channel, change: entered }, 0, &mut desk.ahead);
            }
        }
        desk
    }

    /// Admits a command on the *ahead* books; its operations are staged. For `decided` see [`Case`].
    pub fn admit(&mut self, view: &View<AXES>, decided: bool, number: u16, body: &[u8]) -> Admitted<(Answer, Effect)> {
        self.staged.clear();
        let mut case = Case {
            view,
            books: &self.ahead,
            site: &self.site,
            board: &self.board,
            decided,
            staged: &mut self.staged,
            effect: Effect::None,
        };
        if road(number) == Some(Road::Table) {
            if let Some(table) = self.loading.table(&case, self.tables, number, body)? {
                case.stage_with(Op::Mark, Change::TableFilled { table });
                self.now.spoil(table);
            }
            return Ok((Answer::Done, Effect::None));
        }
        let answer = admit(&mut case, number, body)?;
        Ok((answer, case.effect))
    }

    /// Admits data of a FIFO, writes it to the store and enters it into the *ahead* books; its commit is still to come.
    pub fn admit_data(
        &mut self,
        view: &View<AXES>,
        decided: bool,
        number: u16,
        body: &[u8],
    ) -> Admitted<data::Written> {
        let case = Case {
            view,
            books: &self.ahead,
            site: &self.site,
            board: &self.board,
            decided,
            staged: &mut self.staged,
            effect: Effect::None,
        };
        let (written, end) = data::data(&case, self.stores, number, body)?;
        if self.ahead.overwrites(view, written.axis, written.fifo) {
            let (now, ahead) = (self.now.axis(written.axis), self.ahead.axis(written.axis));
            let all = now.mode != ahead.mode || ahead.is_dynamic();
            self.now.spoil_fifos(written.axis, if all { 3 } else { 1 << (written.fifo & 1) });
        }
        data::enter(&mut self.ahead, &written, end);
        Ok(written)
    }

    /// Answers a Calculate command of `lane` by way of `sent`, which says whether it had room.
    pub fn calculate(
        &mut self,
        view: &View<AXES>,
        lane: usize,
        number: u16,
        body: &[u8],
        sent: impl FnOnce(&[f64]) -> bool,
    ) -> Admitted<bool> {
        let case = Case {
            view,
            books: &self.ahead,
            site: &self.site,
            board: &self.board,
            decided: false,
            staged: &mut self.staged,
            effect: Effect::None,
        };
        self.loading.calculate(&case, lane, number, body, sent)
    }

    /// Stages one item of a LoadConfig that was admitted; false behind the last.
    pub fn stage_config(&mut self, view: &View<AXES>, body: &[u8], item: u16) -> bool {
        self.staged.clear();
        let Ok((request, items)) = many::<LoadConfig>(body, |r| r.count.get()) else { return false };
        let Some(item) = items.get(usize::from(item)) else { return false };
        let mut case = Case {
            view,
            books: &self.ahead,
            site: &self.site,
            board: &self.board,
            decided: false,
            staged: &mut self.staged,
            effect: Effect::None,
        };
        // It was checked when the command was admitted.
        config_item(&mut case, request.core.get(), item).is_ok()
    }

    /// Does what a command does beside its operations; `seq` is its last entry.
    pub fn apply(&mut self, effect: Effect, seq: u32) {
        match effect {
            Effect::None | Effect::Config | Effect::Took(_) => {}
            Effect::Choose(site) => self.site = site,
            Effect::LinkLoss { ms, stop_all } => self.link_loss = (ms, stop_all),
            Effect::Trace { every, columns, over_link } => self.trace.announce(every, columns, over_link, seq),
        }
    }

    /// Empties what a program that was dropped has overwritten. False if the lane has no room for it now.
    pub fn empty_spoiled(&mut self) -> bool {
        while let Some((op, change)) = self.ahead.unspoil() {
            if !self.lane.push(op, change, 0, &mut self.ahead) {
                return false;
            }
        }
        true
    }

    /// Follows the tick: what it has executed, where axes came to rest, streams that ended.
    pub fn follow(&mut self, view: &View<AXES>) {
        self.lane.retire(view, &mut self.now);
        for ((now, ahead), seen) in self.now.axes.iter_mut().zip(&mut self.ahead.axes).zip(&view.axes) {
            now.follow(view, seen);
            ahead.follow(view, seen);
        }
    }

    /// The tick refused a start of the immediate lane.
    pub fn tick_refused(&mut self, refusal: TickRefusal) {
        self.refused.push(refusal);
    }

    /// The reply to an executed command; `taken` are the numbers of its lane that wait, oldest first.
    pub fn reply(
        &self,
        view: &View<AXES>,
        program: &Program<'_>,
        item: &Awaiting,
        taken: impl Iterator<Item = f64>,
        out: &mut ReplyWriter,
    ) -> Result<(), Full> {
        let reading = Reading { view, now: &self.now, site: &self.site, board: &self.board };
        match &item.answer {
            Answer::Done => out.push_raw(item.opcode, item.tag, 0, &[]),
            Answer::Read(query) => reading.reply(item.tag, query, out),
            Answer::Space(space) => reading.space(item.opcode, item.tag, *space, out),
            Answer::Number(value) => reading.number(item.opcode, item.tag, *value, out),
            Answer::Entered { axis, fifo, percent1 } => {
                reading.entered(item.opcode, item.tag, *axis, *fifo, *percent1, out)
            }
            Answer::Taken { axis, fifo, count } => reading.taken(item.opcode, item.tag, *axis, *fifo, *count, out),
            Answer::Values(count) => values_reply(item.opcode, item.tag, taken.take((*count).into()), out),
            Answer::Took { held, .. } => took_reply(item.opcode, item.tag, taken, *held, out),
            Answer::Program => program.status(view, item.opcode, item.tag, out),
        }
    }

    /// What to tell of a start that the tick refused.
    pub fn explain(&self, axis: Axis, status: u32) -> Refused {
        let reason = if status & SERVO_ON == 0 { Reason::ServoOff } else { Reason::AxisFault };
        Refused::new(reason).axis(self.site.number_of(axis)).got(status.into())
    }

    /// Answers what was executed. True if anything was answered.
    pub fn answer(&mut self, view: &View<AXES>, program: &Program<'_>, out: &mut ReplyWriter) -> bool {
        let mut progress = false;
        while let Some(&item) = self.awaiting.front() {
            if item.seq.is_some_and(|seq| !executed(view, seq)) {
                break;
            }
            let refusal = self.refused.front().copied().filter(|&(seq, ..)| item.own && Some(seq) == item.seq);
            let written = match refusal {
                Some((_, axis, status)) => out.refused(item.opcode, item.tag, &self.explain(axis, status).wire),
                None => self.reply(view, program, &item, self.taken.iter().copied(), out),
            };
            if written.is_err() {
                break;
            }
            if refusal.is_some() {
                self.refused.pop();
            }
            for _ in 0..item.answer.waiting() {
                self.taken.pop();
            }
            self.awaiting.pop();
            progress = true;
        }
        if self.awaiting.is_empty() {
            self.refused.clear();
        }
        progress
    }

    /// A new session: nobody waits for these replies any more.
    pub fn abandon(&mut self) {
        self.awaiting.clear();
        self.taken.clear();
        self.loading.abandon();
        self.config = None;
        self.trace.abandon();
    }

    fn is_quiet(&self) -> bool {
        self.awaiting.is_empty() && !self.lane.in_flight()
    }

    fn refuse(&self, record: &RequestRecord, refused: Refused, out: &mut ReplyWriter) -> Step {
        if !self.is_quiet() {
            return Step::Wait;
        }
        Step::of(out.refused(record.opcode, record.tag, &refused.wire))
    }

    fn await_last(&mut self, record: &RequestRecord, answer: Answer, own: bool) -> Step {
        let seq = self.lane.in_flight().then(|| self.lane.last());
        self.awaiting.push(Awaiting { opcode: record.opcode, tag: record.tag, seq, own, answer, ..Awaiting::BLANK });
        Step::Taken
    }

    /// Deals with a record of lane 0.
    pub fn immediate(
        &mut self,
        program: &mut Program<'_>,
        view: &View<AXES>,
        record: &RequestRecord,
        out: &mut ReplyWriter,
    ) -> Step {
        if self.lane.room() < STAGED.max(AXES) || self.awaiting.is_full() || self.taken.room() < TAKEN_MAX {
            return Step::Wait;
        }
        if self.config.is_some() {
            return self.go_on_with_config(view, record);
        }
        match record.opcode {
            opcode::Sleep | opcode::WaitStop | opcode::ProgramEnd => {
                return self.refuse(record, Refused::new(Reason::NotInProgram), out);
            }
            opcode::ProgramStart | opcode::ProgramClear | opcode::ProgramStatus => {
                if !self.is_quiet() {
                    return Step::Wait;
                }
                return match program.control(self, record) {
                    Ok(Some(answer)) => self.await_last(record, answer, false),
                    Ok(None) => Step::Wait,
                    Err(refused) => self.refuse(record, refused, out),
                };
            }
            _ => {}
        }
        let beside = matches!(
            record.opcode,
            opcode::Stop
                | opcode::ClrSts
                | opcode::Trace
                | opcode::SetLinkLoss
                | opcode::Choose
                | opcode::LaserOff
                | opcode::ClrLaserFault
        ) || switches_off(record);
        if program.is_active() && !beside && !is_read(record.opcode) {
            return self.refuse(record, Refused::new(Reason::ProgramRuns), out);
        }
        if data::is_data(record.opcode, record.body) {
            return match self.admit_data(view, self.is_quiet(), record.opcode, record.body) {
                Ok(written) => self.take_data(record, &written),
                Err(refused) => self.refuse(record, refused, out),
            };
        }
        if road(record.opcode) == Some(Road::Calculate) {
            if !self.is_quiet() {
                return Step::Wait;
            }
            let reply = |values: &[f64]| values_reply(record.opcode, record.tag, values.iter().copied(), out).is_ok();
            return match self.calculate(view, 0, record.opcode, record.body, reply) {
                Ok(sent) => {
                    if sent {
                        Step::Taken
                    } else {
                        Step::Wait
                    }
                }
                Err(refused) => self.refuse(record, refused, out),
            };
        }
        match self.admit(view, self.is_quiet(), record.opcode, record.body) {
            Err(refused) => self.refuse(record, refused, out),
            Ok((Answer::Read(query), Effect::None)) => {
                if !self.is_quiet() {
                    return Step::Wait;
                }
                let reading = Reading { view, now: &self.now, site: &self.site, board: &self.board };
                Step::of(reading.reply(record.tag, &query, out))
            }
            Ok((_, Effect::Choose(site)))
                if program.is_active() && (site.number, site.family) != (self.site.number, self.site.family) =>
            {
                self.refuse(record, Refused::new(Reason::ProgramRuns), out)
            }
            Ok((answer, effect)) => {
                if record.opcode == opcode::Stop && !self.staged.ops().is_empty() {
                    program.stop(self);
                }
                self.push_staged();
                if let (Effect::Took(values), Answer::Took { count, .. }) = (effect, answer) {
                    for value in values.into_iter().take(count.into()) {
                        self.taken.push(value);
                    }
                }
                self.apply(effect, self.lane.last());
                if let Effect::Config = effect {
                    self.config = Some(0);
                    return self.go_on_with_config(view, record);
                }
                let own = !self.staged.ops().is_empty();
                self.await_last(record, answer, own)
            }
        }
    }

    /// Pushes what is staged; the caller has seen that there is room.
    fn push_staged(&mut self) {
        for &(op, change) in self.staged.ops() {
            self.lane.push(op, change, 0, &mut self.ahead);
        }
    }

    fn take_data(&mut self, record: &RequestRecord, written: &data::Written) -> Step {
        let (op, change) = data::commit(&self.ahead, written.axis, written.fifo);
        self.lane.push(op, change, 0, &mut self.ahead);
        self.await_last(record, written.answer, true)
    }

    fn go_on_with_config(&mut self, view: &View<AXES>, record: &RequestRecord) -> Step {
        while let Some(item) = self.config {
            if self.lane.room() < STAGED {
                return Step::Wait;
            }
            if !self.stage_config(view, record.body, item) {
                self.config = None;
                break;
            }
            self.push_staged();
            self.config = Some(item.saturating_add(1));
        }
        self.await_last(record, Answer::Done, true)
    }

    /// Tells the tick that the link is lost or there again; false if the lane has no room for it now.
    pub fn tell_link(&mut self, lost: bool) -> bool {
        self.lane.push(Op::Link { lost }, Change::None, 0, &mut self.ahead)
    }

    /// Link loss: Jog axes, or all, stop smoothly. The caller has seen that the lane has room.
    pub fn stop_for_link_loss(&mut self, view: &View<AXES>) {
        let all = self.link_loss.1;
        let mut axes = AxisMask(0);
        for (index, (book, seen)) in self.ahead.axes.iter().zip(&view.axes).enumerate() {
            let Some(axis) = Axis::new(index) else { break };
            let jogs = self.now.axis(axis).mode == Mode::Jog || book.mode == Mode::Jog;
            let runs = seen.status & RUNNING != 0 || book.started.is_some_and(|seq| seq & PROGRAM_FLAG == 0);
            if runs && (all || jogs) {
                axes.0 |= axis.mask().0;
            }
        }
        if axes.0 != 0 {
            self.lane.push(Op::Stop { axes, abrupt: AxisMask(0) }, Change::None, 0, &mut self.ahead);
        }
    }
}
