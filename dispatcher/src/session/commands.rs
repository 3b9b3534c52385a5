//! The desk: the immediate lane, and what both lanes share.
//!
//! In: records of lane 0, the view. Out: entries of the immediate lane, replies in order. Owns: both
//! sets of books, the profile, link-loss settings, the trace's way out.
//!
//! A command is answered when the tick has executed it, so that the client's next read sees it. A read
//! or a refusal waits until everything before it has been executed, and is then decided on that state.
mod immediate;
mod paths;

use super::lane::{Deque, Lane, Staged};
use super::pending_replies::{Awaiting, Refuser, Step, TickRefusal};
use super::server::{Board, IMMEDIATE};
use crate::admit::context::{Answer, Configuration, Context, Due, Effect, Watch};
use crate::admit::data::{self, FifoOf};
use crate::admit::pvt_table::{Loading, TableKind, table_kind};
use crate::admit::refuse::{Admitted, Refused};
use crate::admit::{admit, config_item, crd, many, one, power_on, tables};
use crate::plan::path_queue::PathQueue;
use crate::program::Program;
use crate::report::event_log::{Kind, Log, ShutOff};
use crate::report::replies::{Reading, pulses, took_reply, values_reply};
use crate::report::trace::TraceOut;
use crate::shadow::{AxisShadow, CAPACITY, Change, Renewed, Shadows, executed};
use protocol::command::{LoadConfig, opcode};
use protocol::reason::Reason;
use protocol::record::{Full, ReplyWriter, RequestRecord};
use ring::Producer;
use servo::laser::CHANNELS;
use servo::op::{Entry, Mode, Op};
use servo::path::PathStores;
use servo::segment::pt::SegmentStore;
use servo::segment::pvt::TableStores;
use servo::status::{LIMIT_NEGATIVE, LIMIT_POSITIVE, RUNNING, SERVO_ON};
use servo::units::{Axis, AxisMask, Crd, CrdMask};
use servo::view::{AxisView, View};

/// The desk.
pub struct CommandHandler<'a, const AXES: usize> {
    /// Constants of the board.
    pub board: Board,
    /// What the client chose.
    pub configuration: Configuration,
    /// PT segments.
    pub stores: &'a [SegmentStore; AXES],
    /// FIFOs of coordinate systems.
    pub entries: PathStores<'a>,
    /// What leads to them.
    pub queues: &'a mut [[PathQueue; 2]],
    /// When a path that runs wants to be looked at, controller time in ns; the end of time where none does.
    pub feed_due: u64,
    /// PVT tables.
    pub tables: TableStores<'a>,
    /// The one that is being sent.
    pub loading: Loading,
    /// That of a laser channel.
    pub laser_loading: tables::Loading,
    /// Books after everything executed.
    pub executed: Shadows<AXES>,
    /// Books after everything admitted.
    pub admitted: Shadows<AXES>,
    renewed: Renewed,
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
    /// The trace.
    pub trace: TraceOut<AXES>,
    /// What happened by itself.
    pub log: Log,
}

/// Numbers that laser commands took and whose replies wait.
const TAKEN: usize = 64;

impl<'a, const AXES: usize> CommandHandler<'a, AXES> {
    /// A desk at power-on.
    pub fn new(
        board: Board,
        stores: &'a [SegmentStore; AXES],
        paths: (PathStores<'a>, &'a mut [[PathQueue; 2]]),
        tables: TableStores<'a>,
        ring: Producer<'a, Entry, IMMEDIATE>,
    ) -> Self {
        let mut handler = CommandHandler {
            configuration: Configuration::new(board.profile, 0),
            board,
            stores,
            entries: paths.0,
            queues: paths.1,
            feed_due: u64::MAX,
            tables,
            loading: Loading::new(),
            laser_loading: tables::Loading::new(),
            executed: Shadows::new(),
            admitted: Shadows::new(),
            renewed: Renewed::default(),
            staged: Staged::new(),
            lane: Lane::new(ring, 0),
            awaiting: Deque::new(Awaiting::BLANK),
            refused: Deque::new((0, Refuser::Nobody)),
            taken: Deque::new(0.0),
            config: None,
            trace: TraceOut::new(),
            log: Log::new(),
        };
        // The tick does not know families.
        for channel in 0..CHANNELS as u8 {
            for (change, entered) in power_on(handler.configuration.family) {
                let op = Op::Laser { channel, change };
                handler.lane.push(op, Change::Laser { channel, change: entered }, 0, &mut handler.admitted);
            }
        }
        handler
    }

    /// Admits a command on the *ahead* books; its operations are staged.
    pub fn admit(&mut self, view: &View<AXES>, due: Due, number: u16, body: &[u8]) -> Admitted<(Answer, Effect)> {
        self.staged.clear();
        let mut context = Context {
            view,
            shadows: &self.admitted,
            configuration: &self.configuration,
            board: &self.board,
            executed: &self.executed,
            due,
            crds: self.entries.count(),
            staged: &mut self.staged,
            effect: Effect::None,
        };
        if number == opcode::CrdStart {
            let request = one(body)?;
            let answer = crd::start(&mut context, self.queues, self.entries, &request)?;
            return Ok((answer, Effect::None));
        }
        if table_kind(number) == Some(TableKind::Table) {
            let filled = self.loading.table(&context, &self.executed, self.tables, number, body);
            if let Ok(Some(table)) = filled {
                context.stage_with(Op::Mark, Change::TableFilled { table });
                self.executed.invalidate(table);
            }
            if let Some(table) = self.loading.emptied() {
                self.executed.invalidate(table);
                self.admitted.invalidate(table);
            }
            return filled.map(|_| (Answer::Done, Effect::None));
        }
        if tables::is_table(number) {
            let (answer, filled) = self.laser_loading.chunk(&mut context, self.tables.lasers, number, body)?;
            let effect = context.effect;
            if let Some((channel, table)) = filled {
                self.executed.invalidate_follow_table(channel, table);
            }
            return Ok((answer, effect));
        }
        let answer = admit(&mut context, number, body)?;
        Ok((answer, context.effect))
    }

    /// Admits data of a FIFO, writes it to the store and enters it into the *ahead* books; its commit is still to come.
    pub fn admit_data(&mut self, view: &View<AXES>, due: Due, number: u16, body: &[u8]) -> Admitted<data::Written> {
        let context = Context {
            view,
            shadows: &self.admitted,
            configuration: &self.configuration,
            board: &self.board,
            executed: &self.executed,
            due,
            crds: self.entries.count(),
            staged: &mut self.staged,
            effect: Effect::None,
        };
        let stores = data::Stores { segments: self.stores, entries: self.entries, queues: &mut *self.queues };
        let (written, end) = data::data(&context, stores, number, body)?;
        if let FifoOf::Axis(axis) = written.of
            && self.admitted.overwrites(view, axis, written.fifo)
        {
            let (now, ahead) = (self.executed.axis(axis), self.admitted.axis(axis));
            let all = now.mode != ahead.mode || ahead.is_dynamic();
            self.executed.invalidate_fifos(axis, if all { 3 } else { 1 << (written.fifo & 1) });
        }
        data::enter(&mut self.admitted, &written, end);
        if let (FifoOf::Crd(crd), Some((channel, table))) = (written.of, written.named) {
            // Also where the program is dropped before its commit: it says too much then, until the FIFO is empty.
            for shadows in [&mut self.executed, &mut self.admitted] {
                shadows.name_follow_table(channel, table, crd, written.fifo);
            }
        }
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
        let context = Context {
            view,
            shadows: &self.admitted,
            configuration: &self.configuration,
            board: &self.board,
            executed: &self.executed,
            due: Due::UNKNOWN,
            crds: self.entries.count(),
            staged: &mut self.staged,
            effect: Effect::None,
        };
        self.loading.calculate(&context, self.tables.points, lane, number, body, sent)
    }

    /// Stages one item of a LoadConfig that was admitted; false behind the last.
    pub fn stage_config(&mut self, view: &View<AXES>, body: &[u8], item: u16) -> bool {
        self.staged.clear();
        let Ok((request, items)) = many::<LoadConfig>(body, |r| r.count.get()) else { return false };
        let Some(item) = items.get(usize::from(item)) else { return false };
        let mut context = Context {
            view,
            shadows: &self.admitted,
            configuration: &self.configuration,
            board: &self.board,
            executed: &self.executed,
            due: Due::UNKNOWN,
            crds: self.entries.count(),
            staged: &mut self.staged,
            effect: Effect::None,
        };
        // It was checked when the command was admitted.
        config_item(&mut context, request.core.get(), item).is_ok()
    }

    /// Does what a command does beside its operations; `seq` is its last entry.
    pub fn apply(&mut self, effect: Effect, seq: u32) {
        match effect {
            Effect::None | Effect::Config | Effect::Took(_) => {}
            Effect::Choose(configuration) => self.configuration = configuration,
            Effect::Trace { every, columns, over_link } => self.trace.announce(every, columns, over_link, seq),
        }
    }

    /// Empties what a program that was dropped has overwritten. False if the lane has no room for it now.
    pub fn empty_invalid(&mut self) -> bool {
        while let Some((op, change)) = self.admitted.revalidate() {
            if !self.lane.push(op, change, 0, &mut self.admitted) {
                return false;
            }
        }
        true
    }

    /// Follows the tick: what it has executed of both lanes, where axes came to rest, streams that ended.
    pub fn follow(&mut self, program: &mut Program<'_>, view: &View<AXES>) {
        self.lane.retire(view, &mut self.executed);
        // What the view shows of it would else look as if the tick had done it by itself.
        program.retire(view, &mut self.executed);
        // Data that gathers for what has ended goes to the tick as it is, which refuses it at its instant.
        let ended = |(shadow, sampled): (&AxisShadow, &AxisView)| {
            shadow.epoch != sampled.epoch || shadow.is_follow() && shadow.follow.cleared != sampled.cleared
        };
        if program.gathers() && self.admitted.axes.iter().zip(&view.axes).any(ended) {
            program.flush(self);
        }
        for ((now, ahead), sampled) in self.executed.axes.iter_mut().zip(&mut self.admitted.axes).zip(&view.axes) {
            now.follow(view, sampled);
            ahead.follow(view, sampled);
        }
        for ((now, ahead), sampled) in self.executed.crds.iter_mut().zip(&mut self.admitted.crds).zip(&view.crds) {
            now.follow(view, sampled);
            ahead.follow(view, sampled);
        }
        if self.executed.naming() | self.admitted.naming() != 0 {
            self.forget_follow_tables(view);
        }
        if self.renewed.is_due(view) {
            self.executed.renew(view);
            self.admitted.renew(view);
            program.renew(view);
        }
    }

    /// FIFOs that hold nothing by either set of books name no follow table.
    fn forget_follow_tables(&mut self, view: &View<AXES>) {
        for (crd, sampled) in Crd::all().zip(&view.crds) {
            for fifo in 0..2 {
                if [&self.executed, &self.admitted]
                    .iter()
                    .all(|shadows| shadows.crd(crd).space(sampled, fifo) == CAPACITY)
                {
                    self.executed.forget_follow_tables(crd, fifo);
                    self.admitted.forget_follow_tables(crd, fifo);
                }
            }
        }
    }

    /// The tick refused a start or data of the immediate lane.
    pub fn tick_refused(&mut self, refusal: TickRefusal) {
        let mut data = false;
        self.awaiting.amend_back(|item| {
            data |= item.loses(refusal);
            true
        });
        if !data {
            self.refused.push(refusal);
        }
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
        let reading = self.reading(view);
        match &item.answer {
            Answer::Done => out.push_raw(item.opcode, item.tag, 0, &[]),
            Answer::Read(query) => reading.reply(item.tag, query, out),
            Answer::Long(value) => reading.long(item.opcode, item.tag, *value, out),
            Answer::Path { crd, fifo, count, lasts_ms } => {
                reading.path_taken(item.opcode, item.tag, (*crd, *fifo), (*count, *lasts_ms), out)
            }
            Answer::Space(space) => reading.space(item.opcode, item.tag, *space, out),
            Answer::Number(value) => reading.number(item.opcode, item.tag, *value, out),
            Answer::Entered { axis, fifo, percent1 } => {
                reading.entered(item.opcode, item.tag, *axis, *fifo, *percent1, out)
            }
            Answer::Taken { axis, fifo, count } => reading.taken(item.opcode, item.tag, *axis, *fifo, *count, out),
            Answer::Lost { axis, status } => {
                let lost = match item.opcode {
                    // At once it is no data, but answered like it.
                    opcode::FollowSwitchNowEx => self.explain(view, Refuser::Axis(*axis, *status)),
                    _ => {
                        let stop = view.axes.get(axis.index()).map_or(0, |sampled| sampled.stop as u16);
                        let lost = Refused::new(Reason::StreamEnded).axis(self.configuration.number_of(*axis));
                        lost.got((*status).into()).limits(0.0, stop.into())
                    }
                };
                out.refused(item.opcode, item.tag, &lost.wire)
            }
            Answer::Values(count) => values_reply(item.opcode, item.tag, taken.take((*count).into()), out),
            Answer::Took { held, .. } => took_reply(item.opcode, item.tag, taken, *held, out),
            Answer::Program => program.status(view, item.opcode, item.tag, out),
        }
    }

    /// What to tell of a start that the tick refused.
    pub fn explain(&self, view: &View<AXES>, refuser: Refuser) -> Refused {
        let (axis, status) = match refuser {
            Refuser::Axis(axis, status) => (axis, status),
            Refuser::Crd(crd) => return self.explain_crd(view, crd),
            Refuser::Laser(channel) => {
                let fault = view.lasers.get(usize::from(channel)).map_or(0, |laser| laser.fault as u8);
                return Refused::new(Reason::LaserFault).got(channel.into()).limits(0.0, fault.into());
            }
            Refuser::Nobody => return Refused::new(Reason::Late),
        };
        let blocked = view.axes.get(axis.index()).is_some_and(|sampled| sampled.blocked != 0);
        let limit = self.limit_ahead(view, axis, status);
        let (reason, got) = match limit.filter(|_| !blocked) {
            _ if status & SERVO_ON == 0 => (Reason::ServoOff, status.into()),
            Some(limit) => limit,
            None if blocked => (Reason::AxisFault, status.into()),
            None if status & RUNNING != 0 => (Reason::Moving, status.into()),
            None => (Reason::StateChanged, status.into()),
        };
        Refused::new(reason).axis(self.configuration.number_of(axis)).got(got)
    }

    /// The limit at which an axis in Jog or Trap stands, if its target lies beyond: nothing is latched then.
    fn limit_ahead(&self, view: &View<AXES>, axis: Axis, status: u32) -> Option<(Reason, f64)> {
        let (shadow, at) = (self.executed.axis(axis), pulses(view.axes.get(axis.index())?.pos));
        let direction = match shadow.mode {
            Mode::Jog => shadow.vel,
            Mode::Trap => f64::from(shadow.pos) - at,
            _ => 0.0,
        };
        let (soft, beyond, switch) = match direction {
            direction if direction > 0.0 => {
                (shadow.soft.0, shadow.soft.0 != i32::MAX && at >= shadow.soft.0.into(), LIMIT_POSITIVE)
            }
            direction if direction < 0.0 => {
                (shadow.soft.1, shadow.soft.1 != i32::MIN && at <= shadow.soft.1.into(), LIMIT_NEGATIVE)
            }
            _ => return None,
        };
        if beyond {
            Some((Reason::AtSoftLimit, soft.into()))
        } else {
            (status & switch != 0).then_some((Reason::AtLimitSwitch, 0.0))
        }
    }

    /// A coordinate system that could not start.
    fn explain_crd(&self, view: &View<AXES>, crd: Crd) -> Refused {
        let (sampled, shadow) = (&view.crds[crd.index().min(Crd::MAX - 1)], self.executed.crd(crd));
        let number = self.configuration.crd_number(crd);
        let index = usize::from(shadow.fifo & 1);
        let empty = sampled.ends[index] == sampled.released[index];
        let left = |axis: &Axis| view.axes.get(axis.index()).is_some_and(|axis| axis.mode != Mode::Crd);
        let reason = match sampled.frame {
            None => Reason::CrdNotSet,
            Some(_) if sampled.runs => Reason::CrdRuns,
            Some(frame) => match frame.mask().axes().find(left) {
                Some(axis) => {
                    let refused = Refused::new(Reason::AxisLeftCrd).axis(self.configuration.number_of(axis));
                    return refused.got(number.into());
                }
                None if empty => Reason::CrdEmpty,
                None => Reason::CrdElsewhere,
            },
        };
        Refused::new(reason).axis(number).got(shadow.fifo.into())
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
                Some((_, refuser)) => out.refused(item.opcode, item.tag, &self.explain(view, refuser).wire),
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
        self.laser_loading.abandon();
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

    /// Tells the tick that the link is lost or there again; false if the lane has no room for it now.
    pub fn tell_link(&mut self, lost: bool) -> bool {
        // Where it is lost, all paths brake.
        let crds = CrdMask(if lost { u8::MAX } else { 0 });
        self.lane.push(Op::Link { lost }, Change::Stopped { axes: AxisMask(0), crds }, 0, &mut self.admitted)
    }

    /// A new session begins dark, and with the supervision of power-on; false if the lane has no room for it now.
    pub fn begin_session(&mut self, view: &View<AXES>) -> bool {
        if self.lane.room() < SESSION_ENTRIES {
            return false;
        }
        let watch = Watch::DEFAULT;
        self.lane.push(Op::Supervision(watch.supervision()), Change::Watch(watch), 0, &mut self.admitted);
        self.lane.push(Op::NewSession, Change::None, 0, &mut self.admitted);
        if view.lasers.iter().any(|laser| laser.commanded || laser.light || laser.owners.0 != 0) {
            self.log.put(view.now, Kind::ShutOff, 0, ShutOff::NewSession as u16);
        }
        true
    }

    /// What reads look at.
    fn reading<'d>(&'d self, view: &'d View<AXES>) -> Reading<'d, AXES> {
        let CommandHandler { executed, configuration, board, log, .. } = self;
        Reading { view, executed, configuration, board, log, tables: self.tables.lasers }
    }
}

/// Entries of the immediate lane that begin a session.
const SESSION_ENTRIES: usize = 2;
