//! The immediate lane: how a record of lane 0 is handled.
//!
//! In: a record, the view. Out: entries of the lane, a reply or the promise of one. Owns nothing.
//! Fails: by refusals. A record that finds no room now is tried again.
use super::CommandHandler;
use crate::admit::context::{DueInstant, Effect};
use crate::admit::joined::{Advance, PathManyEnd, PathManyProgress};
use crate::admit::staged::STAGED_MAX;
use crate::program::Program;
use crate::refuse::Refused;
use crate::report::answer::{Answer, TAKEN_MAX_VALUES};
use crate::report::event_log::{EventKind, ShutOff};
use crate::report::path_many;
use crate::report::pending_replies::RecordOutcome;
use crate::report::replies::values_reply;
use crate::shadow::ShadowChange;
use protocol::command::{CommandKind, LaneRule, SetHSIOOpt, class, opcode};
use protocol::reason::Reason;
use protocol::record::{ReplyWriter, RequestRecord};
use servo::tick_command::TickCommand;
use servo::view::View;
use zerocopy::FromBytes;

/// Whether the record is accepted while a program is active.
fn passes(lanes: LaneRule, body: &[u8]) -> bool {
    match lanes {
        // SetHSIOOpt is the only one.
        LaneRule::ExclusiveUnlessZero => SetHSIOOpt::read_from_bytes(body).is_ok_and(|r| r.value.get() == 0),
        lanes => lanes.beside_program(),
    }
}

impl<const AXES: usize> CommandHandler<'_, AXES> {
    /// Deals with a record of lane 0.
    pub fn immediate(
        &mut self,
        program: &mut Program,
        view: &View<AXES>,
        record: &RequestRecord,
        out: &mut ReplyWriter,
    ) -> RecordOutcome {
        // What a PathMany in hand reports makes room once it is over.
        let values = if self.joined.has_begun() { 0 } else { TAKEN_MAX_VALUES };
        if self.admission.lane.room() < STAGED_MAX.max(AXES) || !self.replies.has_room(values) {
            return RecordOutcome::Wait;
        }
        if self.config.is_some() {
            return self.go_on_with_config(view, record);
        }
        let class = class(record.opcode);
        if class.is_some_and(|class| class.lanes == LaneRule::Program) {
            return self.refuse(record, Refused::new(Reason::NotInProgram), out);
        }
        let kind = class.map(|class| class.kind);
        if kind == Some(CommandKind::Program) {
            if !self.is_quiet() {
                return RecordOutcome::Wait;
            }
            return match program.control(&mut self.admission, record) {
                Ok(RecordOutcome::Taken) => self.await_last(record, Answer::Done, false),
                Ok(RecordOutcome::Wait) => RecordOutcome::Wait,
                Err(refused) => self.refuse(record, refused, out),
            };
        }
        if program.is_active() && !class.is_some_and(|class| passes(class.lanes, record.body)) {
            return self.refuse(record, Refused::new(Reason::ProgramRuns), out);
        }
        let due = DueInstant::at_once(self.is_quiet());
        if record.opcode == opcode::PathMany {
            return self.join(view, due, record, out);
        }
        if let Some(written) = self.admission.publish(view, due, record.opcode, record.body) {
            return match written {
                Ok(written) => {
                    self.replies.keep(written.waiting());
                    self.await_last(record, written.answer, true)
                }
                Err(refused) => self.refuse(record, refused, out),
            };
        }
        if kind == Some(CommandKind::Calculate) {
            if !self.is_quiet() {
                return RecordOutcome::Wait;
            }
            let reply = |values: &[f64]| values_reply(record.opcode, record.tag, values.iter().copied(), out).is_ok();
            return match self.admission.calculate(view, 0, record.opcode, record.body, reply) {
                Ok(true) => RecordOutcome::Taken,
                Ok(false) => RecordOutcome::Wait,
                Err(refused) => self.refuse(record, refused, out),
            };
        }
        match self.admission.admit(view, due, record.opcode, record.body) {
            Err(refused) => self.refuse(record, refused, out),
            Ok((Answer::Read(query), Effect::None)) => {
                if !self.is_quiet() {
                    return RecordOutcome::Wait;
                }
                RecordOutcome::of(self.admission.reading(view).reply(record.tag, &query, out))
            }
            Ok((_, Effect::Choose(configuration)))
                if program.is_active()
                    && (configuration.number, configuration.family)
                        != (self.admission.configuration.number, self.admission.configuration.family) =>
            {
                self.refuse(record, Refused::new(Reason::ProgramRuns), out)
            }
            Ok((answer, effect)) => {
                // The end of a laser's follow stops nothing.
                let stops =
                    |(command, _): &(TickCommand, ShadowChange)| !matches!(command, TickCommand::FollowEnd { .. });
                if record.opcode == opcode::Stop && self.admission.staged.commands().iter().any(stops) {
                    program.stop(&mut self.admission, Reason::Discarded);
                }
                if record.opcode == opcode::Abort {
                    program.abort(&mut self.admission);
                    self.admission.log.put(view.now, EventKind::ShutOff, 0, ShutOff::Abort as u16);
                }
                self.admission.push_staged();
                if let (Effect::Took(values), Answer::Took { count, .. }) = (effect, answer) {
                    self.replies.keep(values.into_iter().take(count.into()));
                }
                self.admission.apply(effect, self.admission.lane.last);
                if let Effect::Config = effect {
                    self.config = Some(0);
                    return self.go_on_with_config(view, record);
                }
                let own = !self.admission.staged.commands().is_empty();
                self.await_last(record, answer, own)
            }
        }
    }

    /// Takes calls of a PathMany. The first that is refused once all before it are executed ends
    /// it: the reply says how many were taken.
    fn join(
        &mut self,
        view: &View<AXES>,
        due: DueInstant,
        record: &RequestRecord,
        out: &mut ReplyWriter,
    ) -> RecordOutcome {
        let (joined, replies) = (&mut self.joined, &mut self.replies);
        let advance = match self.admission.admit_joined(view, due, record.body, joined, replies) {
            Ok(advance) => advance,
            Err(refused) => return self.refuse(record, refused, out),
        };
        let Advance { written, count, end } = advance;
        let is_new = written.is_some();
        if let Some(written) = written {
            self.admission.commit_now(written.of, written.fifo);
        }
        let refused = match end {
            PathManyEnd::Done(answer) => {
                self.joined = PathManyProgress::default();
                return self.await_last(record, answer, is_new);
            }
            PathManyEnd::NoRoom => Refused::new(Reason::RingFull),
            PathManyEnd::Refused(refused) => refused,
        };
        if is_new {
            self.await_last(record, Answer::Part(count), true);
        }
        if !self.is_quiet() {
            return RecordOutcome::Wait;
        }
        let refused = self.joined.refuse(refused);
        let taken = self.joined.taken(&self.admission.reading(view), refused.wire.item.get());
        let written = match self.joined.has_begun() {
            true => {
                let mut kept = self.replies.newest(self.joined.values());
                path_many::refused((record.opcode, record.tag), (&refused.wire, taken), &mut kept, out)
            }
            false => out.refused(record.opcode, record.tag, &refused.wire),
        };
        if written.is_ok() {
            self.replies.forget_newest(self.joined.values());
            self.joined = PathManyProgress::default();
        }
        RecordOutcome::of(written)
    }

    fn go_on_with_config(&mut self, view: &View<AXES>, record: &RequestRecord) -> RecordOutcome {
        while let Some(item) = self.config {
            if self.admission.lane.room() < STAGED_MAX {
                return RecordOutcome::Wait;
            }
            if !self.admission.stage_config(view, record.body, item) {
                self.config = None;
                break;
            }
            self.admission.push_staged();
            self.config = Some(item.saturating_add(1));
        }
        self.await_last(record, Answer::Done, true)
    }
}
