//! How a program ends: replies of executed entries, and the rest after a failure, a Stop, link loss
//! or ProgramClear.
//!
//! In: what the view shows as executed, what the tick refused. Out: replies in order, a
//! ProgramDrop, after a failure an Abort.
//! What was dropped leaves no trace: the admitted state is set back to the executed one. A FIFO
//! whose slots were already overwritten is emptied: it holds neither its old data nor the new.
use super::pending_commits::PendingCommits;
use super::{Program, ProgramDrop, ProgramState};
use crate::admit::admission::Admission;
use crate::refuse::Refused;
use crate::report::answer::Answer;
use crate::report::answer::Refuser;
use crate::report::pending_replies::TickRefusal;
use crate::shadow::{PROGRAM_FLAG, ShadowChange, executed};
use crate::tick_queue::Until;
use protocol::reason::{Cure, Reason};
use protocol::record::ReplyWriter;
use servo::tick_command::TickCommand;
use servo::view::View;

impl Program<'_> {
    /// A Stop in the immediate lane, or link loss: a running program ends, and its rest is answered
    /// `rest`. The ProgramDrop is pushed before the Stop, so that no entry starts the axes again.
    pub fn stop<const AXES: usize>(&mut self, admission: &mut Admission<'_, AXES>, rest: Reason) {
        if self.state == ProgramState::Running {
            self.cut(ProgramState::Stopped);
            self.ending.reason = rest;
            self.push_drop(admission);
        }
    }

    /// Abort: a program that is held or runs ends, and its rest is discarded. The ProgramDrop is
    /// pushed before the Abort.
    pub fn abort<const AXES: usize>(&mut self, admission: &mut Admission<'_, AXES>) {
        if self.is_active() {
            self.cut(ProgramState::Stopped);
            self.push_drop(admission);
        }
    }

    /// A new session: entries and replies of the one before are void. Motion goes on.
    pub fn abandon(&mut self) {
        if self.state != ProgramState::Empty {
            self.cut(ProgramState::Stopped);
            self.ending.clears = true;
        }
        self.records.clear();
        self.replies.abandon();
        self.config = None;
        self.overflowed = false;
    }

    /// The tick refused a start or data. The program has failed there, unless the entry may fail.
    /// One entry may carry the data of many records.
    pub fn tick_refused(&mut self, refusal: TickRefusal) {
        let may_fail = self.replies.refuse(refusal);
        if self.is_active() && !may_fail {
            self.cut(ProgramState::Failed);
        }
    }

    /// Whether the record in hand was refused and may fail: then it is answered, and the program
    /// goes on at the same instant. What can never be right is refused at once. The rest is decided
    /// by the state at its instant, in the last view before the tick on which it would act. So what
    /// follows is not late.
    pub(super) fn passes_over<const AXES: usize>(
        &mut self,
        admission: &Admission<'_, AXES>,
        view: &View<AXES>,
        refused: &Refused,
        out: &mut ReplyWriter,
    ) -> bool {
        let Some((head, _)) = self.records.front().filter(|(head, _)| head.may_fail) else { return false };
        if refused.full_fifo().is_some_and(|full| admission.drains(view, full)) {
            return false;
        }
        let known = match refused.reason.cure() {
            Cure::None => true,
            Cure::Motion if refused.is_final() => true,
            // Data for a look-ahead waits for what was given before it, and then it is taken.
            _ if refused.reason == Reason::CrdFifoInUse => self.is_past(view),
            // Of these only the end makes the record right ([`ShadowChange::may_free`]).
            Cure::Motion => self.is_reached(view) || self.is_settled(view, refused.reason),
            Cure::State => self.is_reached(view),
        };
        if !known || out.refused(head.opcode, head.tag, &refused.wire).is_err() {
            return false;
        }
        self.records.pop();
        true
    }

    /// Nothing more of it is executed.
    pub(super) fn cut(&mut self, state: ProgramState) {
        if self.is_active() {
            self.ending.drop = ProgramDrop::Due;
            self.ending.reason = Reason::Discarded;
        }
        self.state = state;
    }

    /// Makes the tick drop what is in the ring, as soon as the lane has room; after a failure it
    /// aborts, too.
    pub(super) fn push_drop<const AXES: usize>(&mut self, admission: &mut Admission<'_, AXES>) {
        // A program that has failed switches on and moves nothing any more: nobody is asked first.
        let fails = self.state == ProgramState::Failed;
        if self.ending.drop != ProgramDrop::Due || admission.lane.room() < 1 + usize::from(fails) {
            return;
        }
        admission.lane.push(TickCommand::ProgramDrop, ShadowChange::None, 0, &mut admission.admitted);
        self.ending.drop = ProgramDrop::Pushed(admission.lane.last());
        if fails {
            admission.lane.push(TickCommand::Abort, ShadowChange::Aborted, 0, &mut admission.admitted);
        }
    }

    /// The tick has dropped the rest.
    pub(super) fn finish_drop<const AXES: usize>(&mut self, admission: &mut Admission<'_, AXES>, view: &View<AXES>) {
        self.lane.retire(view, &mut admission.executed, Until::Everything);
        self.lane.forget();
        admission.forget_paths(view);
        admission.admitted = admission.executed;
        admission.lane.replay(&mut admission.admitted);
        if !admission.empty_invalid() {
            return;
        }
        self.ending.drop = ProgramDrop::None;
        for item in &mut self.replies.items {
            // What the immediate lane carried is executed.
            let dropped = |seq: u32| seq & PROGRAM_FLAG != 0 && !executed(view, seq);
            item.discarded |= item.open || item.seq.is_some_and(dropped);
            item.open = false;
        }
        self.script.forget();
        self.pending_commits = PendingCommits::default();
        (self.run.start, self.run.end, self.config) = (None, None, None);
    }

    /// A strict program was late: what follows is not executed. The next entry reports why.
    pub(super) fn late(&mut self) {
        self.cut(ProgramState::Failed);
        self.replies.note((0, Refuser::Nobody));
    }

    /// Answers what was executed or dropped, in order.
    pub(super) fn answer<const AXES: usize>(
        &mut self,
        admission: &mut Admission<'_, AXES>,
        view: &View<AXES>,
        out: &mut ReplyWriter,
    ) -> bool {
        let mut progress = false;
        while let Some(&item) = self.replies.items.front() {
            if item.open || !item.discarded && item.seq.is_some_and(|seq| !executed(view, seq)) {
                break;
            }
            let refusal = self
                .replies
                .refused
                .front()
                .copied()
                .filter(|&(seq, ..)| if seq == 0 { item.discarded } else { item.own && item.seq == Some(seq) });
            if self.is_lagging {
                self.lane.retire(view, &mut admission.executed, self.replies.until());
            }
            let reading = admission.reading(view);
            let written = match refusal {
                Some((0, ..)) => out.refused(item.opcode, item.tag, &Refused::new(Reason::Late).wire),
                Some((_, refuser)) => out.refused(item.opcode, item.tag, &reading.explain(refuser).wire),
                None if item.discarded => out.refused(item.opcode, item.tag, &Refused::new(self.ending.reason).wire),
                None => reading.answer(&item, self.replies.values(), out),
            };
            if written.is_err() {
                break;
            }
            if refusal.is_some() {
                self.replies.refused.pop_front();
            } else if !item.discarded && !matches!(item.answer, Answer::Lost { .. }) {
                self.reported.executed = self.reported.executed.wrapping_add(1);
            }
            if let Some(seq) = item.seq.filter(|_| item.own) {
                self.reported.answered = (seq, item.tag);
            }
            self.replies.pop();
            progress = true;
        }
        progress
    }

    /// Answers the records that wait: they are not executed.
    pub(super) fn discard(&mut self, out: &mut ReplyWriter) -> bool {
        if !self.replies.items.is_empty() {
            return false;
        }
        let mut progress = false;
        while let Some((head, _)) = self.records.front() {
            // A strict program that was late with an empty ring reports it at its next record.
            let late = self.replies.refused.front().is_some_and(|&(seq, ..)| seq == 0);
            let reason = if late { Reason::Late } else { self.ending.reason };
            if out.refused(head.opcode, head.tag, &Refused::new(reason).wire).is_err() {
                return progress;
            }
            if late {
                self.replies.refused.pop_front();
            }
            self.records.pop();
            progress = true;
        }
        if self.ending.clears {
            self.ending.clears = false;
            self.overflowed = false;
            self.state = ProgramState::Empty;
            self.replies.refused.clear();
            progress = true;
        }
        self.settled = true;
        progress
    }
}
