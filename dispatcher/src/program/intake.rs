//! How records become entries: admission ahead of the script clock.
//!
//! In: the records that wait, the view. Out: entries of the program lane, replies that wait for
//! them.
//! Records are admitted in order until one has to wait: for room, for slots in a FIFO, or because
//! it may become right at its instant.
//!
//! Data of a FIFO is in the axis's store at once; a commit makes it visible to the tick. Commits of
//! one instant are gathered over records and axes, one for each FIFO. They are pushed before
//! anything else that follows, when the script clock advances, or when their instant is near. So
//! data before a start takes no room in the lane however it arrives. A stream that is short of data
//! still gets each record in time.
use super::record_queue::RecordHead;
use super::{Poll, Program, ProgramState};
use crate::admit::admission::Admission;
use crate::admit::context::{DueInstant, Effect};
use crate::admit::data::is_data;
use crate::admit::joined::{Advance, PathManyEnd};
use crate::admit::staged::STAGED_MAX_BUT_RESET;
use crate::admit::written::Written;
use crate::admit::{kind, one};
use crate::refuse::{Admitted, Refused};
use crate::report::answer::{Answer, MAX_POINTS, TAKEN_MAX_VALUES};
use crate::report::pending_replies::{Awaiting, RecordOutcome};
use crate::shadow::{ShadowChange, seq_after, seq_from};
use protocol::command::{CommandKind, ProgramEnd, Sleep, WaitStop, class, opcode};
use protocol::reason::Reason;
use servo::tick_command::TickCommand;
use servo::units::Ns;
use servo::view::View;

/// Records admitted in one call, so that the work of a poll is bounded.
const RECORDS_PER_POLL: u32 = 256;
/// Commits are pushed this long before their instant. That is longer than the thread is ever away,
/// and short enough that single commits do not fill the ring meanwhile.
pub(super) const COMMIT_LEAD_NS: u64 = 10_000_000;

impl Program<'_> {
    /// Admits records until one has to wait. True if at least one was dealt with.
    pub(super) fn take_records<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) -> bool {
        let view = poll.view;
        let mut progress = false;
        for _ in 0..RECORDS_PER_POLL {
            if self.run.end.is_some() || !self.has_room() || self.records.front().is_none() {
                self.pause_admission(poll);
                return progress;
            }
            // One place at a time would take a commit each.
            let waits = |full| poll.admission.drains(view, full) && poll.admission.free_quarters(view, full) == 0;
            if self.waits_for.is_some_and(waits) {
                self.pause_admission(poll);
                return progress;
            }
            match self.take_record(poll) {
                Ok(RecordOutcome::Taken) => {
                    self.pop_record();
                    progress = true;
                }
                Ok(RecordOutcome::Wait) => {
                    self.pause_admission(poll);
                    return progress;
                }
                Err(refused) if self.passes_over(poll, &refused) => progress = true,
                Err(refused) => {
                    self.pause_admission(poll);
                    return self.refuse(poll, &refused) || progress;
                }
            }
        }
        progress
    }

    /// Whether a command other than Reset has room after the pending commits. Data adds at most
    /// one commit.
    fn has_room(&self) -> bool {
        self.lane.room() >= STAGED_MAX_BUT_RESET + self.pending_commits.count()
            && self.replies.has_room(TAKEN_MAX_VALUES)
    }

    /// Whether a record from the wire may be admitted directly: it is data, and no record waits.
    pub(super) fn takes_at_once<const AXES: usize>(&self, number: u16, body: &[u8]) -> bool {
        is_data(number, body)
            && self.is_active()
            && !self.is_dropping()
            && !self.overflowed
            && self.run.end.is_none()
            && self.records.is_empty()
            && self.has_room()
    }

    /// Nothing more can be admitted now.
    fn pause_admission<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) {
        self.admission_waits = true;
        if self.flush_due(poll.view).is_some_and(|due| due.0 <= poll.view.now.0) {
            self.flush(poll.admission);
        }
    }

    /// Whether there is data that the tick does not know of yet.
    pub fn has_pending_commits(&self) -> bool {
        !self.pending_commits.is_empty()
    }

    /// When the pending commits have to be in the ring, controller time; none while the program is
    /// held.
    pub fn flush_due<const AXES: usize>(&self, view: &View<AXES>) -> Option<Ns> {
        if !self.has_pending_commits() || self.state != ProgramState::Running {
            return None;
        }
        // Before the first tick of the run its zero is not known: the present tick stands for it.
        let zero = if self.runs(view) { view.script_zero.0 } else { view.now.0 };
        Some(Ns(self.script.instant_from(zero).saturating_sub(COMMIT_LEAD_NS)))
    }

    /// The record in hand is refused: for good, if its instant has been reached.
    fn refuse<const AXES: usize>(&mut self, poll: &mut Poll<AXES>, refused: &Refused) -> bool {
        let full = matches!(refused.reason, Reason::FifoFull | Reason::CrdFull);
        self.urgent = self.runs(poll.view) && (!full || self.is_quiet());
        if !self.is_past(poll.admission, poll.view) {
            return false;
        }
        self.waits_for = refused.full_fifo().filter(|full| poll.admission.drains(poll.view, *full));
        if self.waits_for.is_some() {
            return false;
        }
        if !self.refuse_record(poll, &refused.wire) {
            return false;
        }
        self.cut(ProgramState::Failed);
        self.push_drop(poll.admission);
        true
    }

    /// Admits the record in hand and pushes what it becomes.
    fn take_record<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) -> Admitted<RecordOutcome> {
        let view = poll.view;
        let due = self.due(view);
        let Some((head, body)) = self.records.front() else { return Ok(RecordOutcome::Wait) };
        let due = DueInstant { may_fail: head.may_fail, ..due };
        let (answer, effect) = match head.opcode {
            number if class(number).is_some_and(|class| !class.lanes.in_program()) => {
                return Err(Refused::new(Reason::NotForProgram));
            }
            opcode::Sleep => {
                let sleep: Sleep = one(body)?;
                if sleep.ns.get() > 0 {
                    self.flush(poll.admission);
                }
                self.script.delay = self.script.delay.saturating_add(sleep.ns.get());
                self.attach(head.opcode, head.tag, Answer::Done);
                return Ok(RecordOutcome::Taken);
            }
            number if is_data(number, body) => {
                let written = poll.admission.admit_data(view, due, number, body)?;
                self.stream(poll.admission, view, (written.of, written.fifo));
                self.replies.keep(written.waiting());
                self.commit_data(poll.admission, head, &written);
                return Ok(RecordOutcome::Taken);
            }
            opcode::PathMany => {
                let advance = poll.admission.admit_joined(view, due, body, &mut self.joined, &mut self.replies)?;
                return self.take_joined(poll.admission, view, head, advance);
            }
            number if kind(number) == Some(CommandKind::Calculate) => {
                if !self.replies.has_room(MAX_POINTS) {
                    return Ok(RecordOutcome::Wait);
                }
                let mut count = 0;
                poll.admission.calculate(view, 1, number, body, |values| {
                    count = values.len() as u8;
                    self.replies.keep(values.iter().copied());
                    true
                })?;
                self.attach(number, head.tag, Answer::Values(count));
                return Ok(RecordOutcome::Taken);
            }
            opcode::WaitStop => {
                let wait: WaitStop = one(body)?;
                if self.script.pauses.is_full() || !poll.admission.wait_stop(view, due, &wait)? {
                    self.urgent = self.runs(view);
                    return Ok(RecordOutcome::Wait);
                }
                (Answer::Done, Effect::None)
            }
            opcode::ProgramEnd => {
                one::<ProgramEnd>(body)?;
                poll.admission.staged.clear();
                poll.admission.staged.add(TickCommand::ProgramEnd, ShadowChange::None);
                (Answer::Done, Effect::None)
            }
            _ if self.config.is_some() => (Answer::Done, Effect::Config),
            other => poll.admission.admit(view, due, other, body)?,
        };
        if let Effect::Config = effect {
            return Ok(self.take_config(poll));
        }
        // Only a Reset may be too much here; its admission can be repeated.
        if self.lane.room() < self.pending_commits.count() + poll.admission.staged.commands().len() {
            return Ok(RecordOutcome::Wait);
        }
        if poll.admission.staged.commands().is_empty() {
            if let Answer::Read(_) = answer {
                self.flush(poll.admission);
                // A read at the instant of the entry before needs no entry of its own.
                if self.script.delay > 0 || !self.lane.in_flight() {
                    self.push(poll.admission, TickCommand::Mark, ShadowChange::None);
                }
            }
            poll.admission.apply(effect, self.lane.last);
            self.attach(head.opcode, head.tag, answer);
            return Ok(RecordOutcome::Taken);
        }
        self.flush(poll.admission);
        if let (Effect::Took(values), Answer::Took { count, .. }) = (effect, answer) {
            self.replies.keep(values.into_iter().take(count.into()));
        }
        self.push_staged(poll.admission);
        poll.admission.apply(effect, self.lane.last);
        if head.opcode == opcode::ProgramEnd {
            self.run.end = Some(self.lane.last);
        }
        let (RecordHead { opcode, tag, may_fail }, seq) = (head, Some(self.lane.last));
        self.replies.push(Awaiting { opcode, tag, seq, own: true, answer, may_fail, ..Awaiting::BLANK });
        Ok(RecordOutcome::Taken)
    }

    /// Pushes one entry; the caller has checked that there is room.
    fn push<const AXES: usize>(&mut self, admission: &mut Admission<AXES>, command: TickCommand, change: ShadowChange) {
        if self.lane.push(command, change, self.script.delay, &mut admission.admitted) {
            self.script.push(&command, self.lane.last);
        }
    }

    /// Pushes what is staged; the caller has checked that there is room.
    fn push_staged<const AXES: usize>(&mut self, admission: &mut Admission<AXES>) {
        for index in 0..admission.staged.commands().len() {
            if let Some(&(command, change)) = admission.staged.commands().get(index) {
                self.push(admission, command, change);
            }
        }
    }

    /// Answers together with the entry before, or at once if that was executed.
    fn attach(&mut self, opcode: u16, tag: u16, answer: Answer) {
        let open = self.has_pending_commits();
        let seq = self.lane.in_flight().then_some(self.lane.last);
        self.replies.push(Awaiting { opcode, tag, seq, open, answer, ..Awaiting::BLANK });
    }

    pub(super) fn commit_data<const AXES: usize>(
        &mut self,
        admission: &mut Admission<AXES>,
        head: RecordHead,
        written: &Written,
    ) {
        let Written { of, fifo, answer, at_once, .. } = *written;
        if at_once {
            admission.commit_now(of, fifo);
        } else {
            self.pending_commits.add(of, fifo);
        }
        let RecordHead { opcode, tag, may_fail } = head;
        let (seq, open) = (at_once.then_some(admission.lane.last), !at_once);
        self.replies.push(Awaiting { opcode, tag, seq, open, own: true, may_fail, answer, ..Awaiting::BLANK });
    }

    /// Calls of a PathMany are in the store: the same for them. It is answered as a whole, and is
    /// not over before all its calls are taken.
    fn take_joined<const AXES: usize>(
        &mut self,
        admission: &mut Admission<AXES>,
        view: &View<AXES>,
        head: RecordHead,
        advance: Advance,
    ) -> Admitted<RecordOutcome> {
        let Advance { written, count, end } = advance;
        let answer = if let PathManyEnd::Done(answer) = end { answer } else { Answer::Part(count) };
        match written {
            Some(written) => {
                self.stream(admission, view, (written.of, written.fifo));
                // The values of its calls are kept already.
                self.commit_data(admission, head, &Written { answer, ..written });
            }
            None if matches!(end, PathManyEnd::Done(_)) => self.attach(head.opcode, head.tag, answer),
            None => {}
        }
        match end {
            PathManyEnd::Done(_) => Ok(RecordOutcome::Taken),
            PathManyEnd::NoRoom => Ok(RecordOutcome::Wait),
            PathManyEnd::Refused(refused) => Err(self.joined.refuse(refused)),
        }
    }

    /// Pushes the pending commits. There is room for them: no record is admitted without it, and
    /// data itself takes none.
    pub fn flush<const AXES: usize>(&mut self, admission: &mut Admission<AXES>) {
        if !self.has_pending_commits() || self.lane.room() < self.pending_commits.count() {
            return;
        }
        let (first, pending) = (seq_after(self.lane.last), core::mem::take(&mut self.pending_commits));
        for (of, fifo) in pending.fifos() {
            let (command, change) = admission.commit(of, fifo);
            self.push(admission, command, change);
        }
        for item in self.replies.items.iter_mut().rev().take_while(|item| item.open) {
            // Data of an axis waits for its own commit: the tick may refuse that.
            let before = match item.answer {
                Answer::Taken { axis, fifo, .. } | Answer::Entered { axis, fifo, .. } if item.own => {
                    pending.before(axis, fifo)
                }
                _ => pending.count() as u32 - 1,
            };
            (item.open, item.seq) = (false, Some(seq_from(first, before)));
        }
    }

    /// LoadConfig, item by item.
    fn take_config<const AXES: usize>(&mut self, poll: &mut Poll<AXES>) -> RecordOutcome {
        self.flush(poll.admission);
        let mut item = self.config.unwrap_or(0);
        loop {
            self.config = Some(item);
            let Some((head, body)) = self.records.front() else { return RecordOutcome::Wait };
            if !poll.admission.stage_config(poll.view, body, item) {
                self.config = None;
                self.attach(head.opcode, head.tag, Answer::Done);
                return RecordOutcome::Taken;
            }
            if self.lane.room() < poll.admission.staged.commands().len() {
                return RecordOutcome::Wait;
            }
            self.push_staged(poll.admission);
            item = item.saturating_add(1);
        }
    }
}
