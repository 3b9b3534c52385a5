//! The command handler of a session: records of lane 0, and their replies.
//!
//! In: records of lane 0, the view. Out: entries of the immediate lane, replies in order. Owns: the
//! [`Admission`] that both lanes use, the replies that wait.
//!
//! A command is answered when the tick has executed it, so that the client's next read shows it. A
//! read or a refusal waits until everything before it has been executed, and is decided on that
//! state.
mod immediate;

use crate::admit::admission::Admission;
use crate::admit::joined::PathManyProgress;
use crate::admit::kind;
use crate::program::Program;
use crate::refuse::Refused;
use crate::report::answer::Answer;
use crate::report::event_log::{EventKind, ShutOff};
use crate::report::path_many::MESSAGES_KEPT;
use crate::report::pending_replies::{Awaiting, PendingReplies, RecordOutcome, TickRefusal};
use crate::shadow::{AxisShadow, CAPACITY, RefreshedNumbers, ShadowChange, Watch, is_in_flight};
use protocol::command;
use protocol::path_many::HELD_AT_ONCE;
use protocol::record::{ReplyWriter, RequestRecord};
use servo::Fifos;
use servo::tick::IMMEDIATE_ENTRIES;
use servo::tick_command::TickCommand;
use servo::units::Crd;
use servo::view::{AxisView, View};

/// Most values of laser commands whose replies wait.
const LASER_VALUES: usize = 64;
const _: () = assert!((HELD_AT_ONCE + 1) * MESSAGES_KEPT <= LASER_VALUES, "a PathMany reports as much as is promised");

servo::state! {
    /// The command handler.
    pub struct CommandHandler<'a, const AXES: usize> {
        /// Admits commands.
        pub admission: Admission<'a, AXES> = admission,
        renewed: RefreshedNumbers = RefreshedNumbers::default(),
        replies: PendingReplies<IMMEDIATE_ENTRIES, LASER_VALUES> = PendingReplies::new(),
        /// The next item of the LoadConfig in hand.
        config: Option<u16> = None,
        /// The PathMany in hand.
        joined: PathManyProgress = PathManyProgress::default(),
        /// The executed state waits for replies that show what was before.
        is_lagging: bool = false,
    }
    /// A command handler at power-on.
    pub fn new(admission: Admission<'a, AXES>);
}

impl<const AXES: usize> CommandHandler<'_, AXES> {
    /// Follows the tick: executed entries of both lanes, axes that came to standstill, streams that
    /// ended.
    pub fn update_from(&mut self, program: &mut Program, view: &View<AXES>) {
        let mine = self.admission.lane.retire(view, &mut self.admission.executed, self.replies.until());
        let its = program.retire(view, &mut self.admission.executed);
        self.is_lagging = !(mine && its);
        // Gathered data of a stream that has ended goes to the tick, which refuses it at its
        // instant.
        let ended = |(shadow, sampled): (&AxisShadow, &AxisView)| {
            shadow.epoch != sampled.epoch || shadow.is_follow() && shadow.follow.cleared != sampled.cleared
        };
        if program.has_pending_commits() && self.admission.admitted.axes.iter().zip(&view.axes).any(ended) {
            program.flush(&mut self.admission);
        }
        self.admission.admitted.update_from(view);
        // Where changes are not entered yet, they would look as if the tick had made them by
        // itself.
        if self.is_lagging {
            return;
        }
        self.admission.executed.update_from(view);
        let quiet = program.is_quiet() && !self.admission.lane.in_flight();
        let [naming, ahead] = [self.admission.executed.naming(), self.admission.admitted.naming()];
        if quiet && naming | ahead != 0 {
            self.forget_follow_tables(view);
        }
        if naming & !ahead != 0 {
            self.forget_emptied(naming & !ahead);
        }
        if self.renewed.is_due(view) {
            self.admission.executed.renew(view);
            self.admission.admitted.renew(view);
            program.renew(view);
        }
    }

    /// FIFOs that are empty by both copies of the shadow state name no follow table. In flight
    /// there may be an entry that names one, a start, and what takes the entry away.
    fn forget_follow_tables(&mut self, view: &View<AXES>) {
        for (crd, sampled) in Crd::all().zip(&view.crds) {
            for fifo in 0..2 {
                let shadows = [&mut self.admission.executed, &mut self.admission.admitted];
                if shadows.iter().all(|shadows| shadows.crd(crd).space(sampled, fifo) == CAPACITY) {
                    shadows.into_iter().for_each(|shadows| shadows.forget_follow_tables(crd, fifo));
                }
            }
        }
    }

    /// These FIFOs hold no entry that names a follow table any more, once what emptied them last is
    /// executed.
    fn forget_emptied(&mut self, fifos: Fifos) {
        let Admission { admitted, executed, .. } = &mut self.admission;
        for crd in Crd::all() {
            for fifo in (0..2).filter(|fifo| fifos >> (2 * crd.index() as u8 + fifo) & 1 == 1) {
                if admitted.crd(crd).path(fifo).emptied.is_none() {
                    executed.forget_follow_tables(crd, fifo);
                }
            }
        }
    }

    /// The tick refused a start or data of the immediate lane.
    pub fn tick_refused(&mut self, refusal: TickRefusal) {
        self.replies.refuse(refusal);
    }

    /// Goes on where replies that waited kept the executed state back.
    pub fn catch_up(&mut self, program: &mut Program, view: &View<AXES>) {
        if self.is_lagging {
            self.update_from(program, view);
        }
    }

    /// Answers what was executed. True if anything was answered.
    pub fn answer(&mut self, view: &View<AXES>, program: &Program, out: &mut ReplyWriter) -> bool {
        let mut progress = false;
        while let Some(&item) = self.replies.items.front() {
            if is_in_flight(view, item.seq) {
                break;
            }
            if self.is_lagging {
                self.admission.lane.retire(view, &mut self.admission.executed, self.replies.until());
            }
            let refusal = self.replies.refused.front().copied().filter(|&(seq, ..)| item.own && Some(seq) == item.seq);
            let reading = self.admission.reading(view);
            let written = match refusal {
                Some((_, refuser)) => out.refused(item.opcode, item.tag, &reading.explain(item.opcode, refuser).wire),
                None if kind(item.opcode) == Some(command::CommandKind::Program) => {
                    program.status(view, item.opcode, item.tag, out)
                }
                None => reading.answer(&item, self.replies.values(), out),
            };
            if written.is_err() {
                break;
            }
            if refusal.is_some() {
                self.replies.refused.pop_front();
            }
            self.replies.pop();
            progress = true;
        }
        if self.replies.items.is_empty() {
            self.replies.refused.clear();
        }
        progress
    }

    /// A new session: nobody waits for these replies any more.
    pub fn abandon(&mut self) {
        self.replies.abandon();
        self.admission.loading.abandon();
        self.admission.laser_loading.abandon();
        self.config = None;
        self.joined = PathManyProgress::default();
        self.admission.trace.abandon();
    }

    fn is_quiet(&self) -> bool {
        self.replies.items.is_empty() && !self.admission.lane.in_flight()
    }

    fn refuse(&self, record: &RequestRecord, refused: Refused, out: &mut ReplyWriter) -> RecordOutcome {
        if !self.is_quiet() {
            return RecordOutcome::Wait;
        }
        RecordOutcome::of(out.refused(record.opcode, record.tag, &refused.wire))
    }

    fn await_last(&mut self, record: &RequestRecord, answer: Answer, own: bool) -> RecordOutcome {
        let seq = self.admission.lane.in_flight().then_some(self.admission.lane.last);
        self.replies.push(Awaiting { opcode: record.opcode, tag: record.tag, seq, own, answer, ..Awaiting::BLANK });
        RecordOutcome::Taken
    }

    /// A new session begins with light off and the supervision of power-on. False if the lane has
    /// no room now.
    pub fn begin_session(&mut self, view: &View<AXES>) -> bool {
        if self.admission.lane.room() < SESSION_ENTRIES {
            return false;
        }
        let watch = Watch::DEFAULT;
        self.admission.push(TickCommand::Supervision(watch.supervision()), ShadowChange::Watch(watch));
        self.admission.push(TickCommand::NewSession, ShadowChange::None);
        if view.lasers.iter().any(|laser| laser.commanded || laser.light || laser.owners.0 != 0) {
            self.admission.log.put(view.now, EventKind::ShutOff, 0, ShutOff::NewSession as u16);
        }
        true
    }
}

/// Entries of the immediate lane that begin a session.
const SESSION_ENTRIES: usize = 2;
