//! How a program ends: replies of executed entries, and the rest after a failure, a Stop, link loss
//! or ProgramClear.
//!
//! In: what the view shows as executed, what the tick refused. Out: replies in order, a
//! ProgramDrop, after a failure an Abort.
//! What was dropped leaves no trace: the admitted state is set back to the executed one. A FIFO
//! whose slots were already overwritten is emptied: it holds neither its old data nor the new.
use super::pending_commits::PendingCommits;
use super::{Poll, Program, ProgramDrop, ProgramState};
use crate::admit::admission::Admission;
use crate::admit::joined::PathManyProgress;
use crate::refuse::Refused;
use crate::report::answer::{Answer, Refuser, Sent};
use crate::report::path_many;
use crate::report::pending_replies::{Awaiting, TickRefusal};
use crate::report::replies::Reading;
use crate::shadow::{PROGRAM_FLAG, ShadowChange, executed, is_in_flight};
use crate::tick_queue::Until;
use protocol::reason::{Cure, Reason, Refusal};
use protocol::record::ReplyWriter;
use servo::tick_command::TickCommand;

impl Program<'_> {
    /// A Stop in the immediate lane, or link loss: a running program ends, and its rest is answered
    /// `rest`. The ProgramDrop is pushed before the Stop, so that no entry starts the axes again.
    pub fn stop<const AXES: usize>(&mut self, admission: &mut Admission<AXES>, rest: Reason) {
        if self.state == ProgramState::Running {
            self.cut(ProgramState::Stopped);
            self.ending.reason = rest;
            self.push_drop(admission);
        }
    }

    /// Abort: a program that is held or runs ends, and its rest is discarded. The ProgramDrop is
    /// pushed before the Abort.
    pub fn abort<const AXES: usize>(&mut self, admission: &mut Admission<AXES>) {
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
        (self.joined, self.joined_done) = (PathManyProgress::default(), 0);
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
    pub(super) fn passes_over<const AXES: usize>(&mut self, poll: &mut Poll<AXES>, refused: &Refused) -> bool {
        let view = poll.view;
        if !self.records.front().is_some_and(|(head, _)| head.may_fail) {
            return false;
        }
        if refused.full_fifo().is_some_and(|full| poll.admission.drains(view, full)) {
            return false;
        }
        let known = match refused.reason.cure() {
            Cure::None => true,
            Cure::Motion if refused.is_final() => true,
            // Data for a look-ahead waits for what was given before it, and then it is taken.
            _ if refused.reason == Reason::CrdFifoInUse => self.is_past(poll.admission, view),
            Cure::State if !matches!(refused.reason, Reason::CrdEmpty | Reason::LaserMapInUse) => self.is_reached(view),
            // Of these only an end makes the record right ([`ShadowChange::may_free`]), or that
            // what it is refused for does not begin.
            Cure::Motion | Cure::State => {
                let settled = self.is_settled(view, refused.reason) && !poll.admission.admitted.may_not_start(view);
                self.is_reached(view) || settled
            }
        };
        // Calls before it in a PathMany are answered with it.
        let waits = self.joined.has_begun() && !self.replies.items.is_empty();
        known && !waits && self.refuse_record(poll, &refused.wire)
    }

    /// Answers the record in hand with a refusal, and is done with it. False if there is no room.
    /// Of a PathMany the reply says which calls were executed.
    pub(super) fn refuse_record<const AXES: usize>(&mut self, poll: &mut Poll<AXES>, refusal: &Refusal) -> bool {
        let Some((head, _)) = self.records.front() else { return false };
        let of = (head.opcode, head.tag);
        let written = if self.joined_done > 0 {
            let refusal = Refusal { item: self.joined_done.into(), ..*refusal };
            let taken = self.joined.taken(&poll.admission.reading(poll.view), self.joined_done);
            path_many::refused(of, (&refusal, taken), &mut self.replies.newest(self.joined.values()), poll.out)
        } else {
            poll.out.refused(head.opcode, head.tag, refusal)
        };
        if written.is_err() {
            return false;
        }
        self.replies.forget_newest(self.joined.values());
        self.joined_done = 0;
        self.pop_record();
        true
    }

    /// The record in hand is dealt with.
    pub(super) fn pop_record(&mut self) {
        self.records.pop();
        self.joined = PathManyProgress::default();
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
    pub(super) fn push_drop<const AXES: usize>(&mut self, admission: &mut Admission<AXES>) {
        // A program that has failed switches on and moves nothing any more: nobody is asked first.
        let fails = self.state == ProgramState::Failed;
        if self.ending.drop != ProgramDrop::Due || admission.lane.room() < 1 + usize::from(fails) {
            return;
        }
        admission.push(TickCommand::ProgramDrop, ShadowChange::None);
        self.ending.drop = ProgramDrop::Pushed(admission.lane.last);
        if fails {
            admission.push(TickCommand::Abort, ShadowChange::Aborted);
        }
    }

    /// The tick has dropped the rest.
    pub(super) fn finish_drop<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) {
        self.lane.retire(poll.view, &mut poll.admission.executed, Until::Everything);
        self.lane.forget();
        poll.admission.forget_paths(poll.view);
        poll.admission.admitted = poll.admission.executed;
        poll.admission.lane.replay(&mut poll.admission.admitted);
        if !poll.admission.empty_invalid() {
            return;
        }
        self.ending.drop = ProgramDrop::None;
        for item in &mut self.replies.items {
            // What the immediate lane carried is executed.
            let dropped = |seq: u32| seq & PROGRAM_FLAG != 0 && !executed(poll.view, seq);
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
    pub(super) fn answer<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) -> bool {
        let view = poll.view;
        let mut progress = false;
        while let Some(&item) = self.replies.items.front() {
            if item.open || !item.discarded && is_in_flight(view, item.seq) {
                break;
            }
            let refusal = self
                .replies
                .refused
                .front()
                .copied()
                .filter(|&(seq, ..)| if seq == 0 { item.discarded } else { item.own && item.seq == Some(seq) });
            if self.is_lagging {
                self.lane.retire(view, &mut poll.admission.executed, self.replies.until());
            }
            let reading = poll.admission.reading(view);
            let written = match refusal {
                Some((0, ..)) => poll.out.refused(item.opcode, item.tag, &Refused::new(Reason::Late).wire),
                Some((_, refuser)) => {
                    poll.out.refused(item.opcode, item.tag, &reading.explain(item.opcode, refuser).wire)
                }
                None if matches!(item.answer, Answer::Part(_)) => Ok(()),
                None if item.discarded => self.discarded(&item, &reading, poll.out),
                None => reading.answer(&item, self.replies.values(), poll.out),
            };
            if written.is_err() {
                break;
            }
            match item.answer {
                Answer::Part(count) if !item.discarded => self.joined_done = self.joined_done.wrapping_add(count),
                Answer::Joined { .. } => self.joined_done = 0,
                _ => {}
            }
            if refusal.is_some() {
                self.replies.refused.pop_front();
            } else if matches!(item.answer, Answer::Part(_)) {
                // It is counted with the rest of its record.
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

    /// Answers an entry that was dropped. Of a PathMany the calls may be executed that came before
    /// the last part.
    fn discarded<const AXES: usize>(&self, item: &Awaiting, reading: &Reading<AXES>, out: &mut ReplyWriter) -> Sent {
        let refusal = Refused::new(self.ending.reason).item(self.joined_done.into()).wire;
        match item.answer {
            Answer::Joined { crd, fifo, lasts_ms, values, .. } if self.joined_done > 0 => {
                let taken = reading.path_taken((crd, fifo), self.joined_done, lasts_ms);
                let mut kept = self.replies.values().take(values.into());
                path_many::refused((item.opcode, item.tag), (&refusal, taken), &mut kept, out)
            }
            _ => out.refused(item.opcode, item.tag, &Refused::new(self.ending.reason).wire),
        }
    }

    /// Answers the records that wait: they are not executed.
    pub(super) fn discard<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) -> bool {
        if !self.replies.items.is_empty() {
            return false;
        }
        let mut progress = false;
        while self.records.front().is_some() {
            // A strict program that was late with an empty ring reports it at its next record.
            let late = self.replies.refused.front().is_some_and(|&(seq, ..)| seq == 0);
            let reason = if late { Reason::Late } else { self.ending.reason };
            if !self.refuse_record(poll, &Refused::new(reason).wire) {
                return progress;
            }
            if late {
                self.replies.refused.pop_front();
            }
            progress = true;
        }
        if self.ending.clears {
            self.ending.clears = false;
            self.overflowed = false;
            self.state = ProgramState::Empty;
            self.replies.refused.clear();
            progress = true;
        }
        self.admission_waits = true;
        progress
    }
}
