//! PathMany: calls of one FIFO of a coordinate system, joined in one command.
//!
//! In: the command, and how far it has come. Out: its calls admitted one after the other, as single
//! ones are; one commit publishes all of them. Owns: nothing; each lane keeps its
//! [`PathManyProgress`]. Fails: before anything is taken, if a call does not belong to the FIFO.
//! Else with the refusal of the first call that is refused, by its number; what came before it
//! stays taken.
use super::admission::{Admission, context};
use super::context::{Context, DueInstant, Effect};
use super::written::Written;
use super::{crd, length};
use crate::refuse::{Admitted, FifoOf, Refused};
use crate::report::answer::Answer;
use crate::report::path_many::{MESSAGES_KEPT, kept};
use crate::report::pending_replies::PendingReplies;
use crate::report::replies::Reading;
use protocol::command::{CrdTaken, PathMany};
use protocol::path_many::{FIXED_BYTES, after, call_at, calls, is_short, target};
use protocol::reason::Reason;
use servo::units::Crd;
use servo::view::View;
use zerocopy::FromBytes;

/// How far a PathMany in hand has come.
#[derive(Debug, Clone, Copy, Default)]
pub struct PathManyProgress {
    /// Calls that were taken.
    calls: u16,
    /// Where the next one begins, bytes.
    at: u16,
    /// Values that the lane keeps for its reply.
    values: u8,
    /// How long the motions of the FIFO last, ms.
    lasts_ms: u32,
    /// The FIFO, once a call was taken.
    of: Option<(Crd, u8)>,
}

/// What has become of it now.
pub struct Advance {
    /// What was written to the FIFO, for a commit.
    pub written: Option<Written>,
    /// How many calls that were.
    pub count: u16,
    /// Whether it is over.
    pub end: PathManyEnd,
}

/// Whether a PathMany is over.
pub enum PathManyEnd {
    /// All calls were taken; the answer.
    Done(Answer),
    /// The lane has no room for what the next call may report.
    NoRoom,
    /// The next call is refused now.
    Refused(Refused),
}

impl PathManyProgress {
    /// Whether a call was taken.
    pub fn has_begun(&self) -> bool {
        self.calls > 0
    }

    /// A refusal of the next call, by its number.
    pub fn refuse(&self, refused: Refused) -> Refused {
        refused.item(self.calls.into())
    }

    /// Values that the lane keeps for its reply.
    pub fn values(&self) -> usize {
        self.values.into()
    }

    /// The reply to so many of its calls.
    pub fn taken<const AXES: usize>(&self, reading: &Reading<AXES>, count: u16) -> CrdTaken {
        self.of.map_or(CrdTaken::default(), |of| reading.path_taken(of, count, self.lasts_ms))
    }

    /// Keeps what the call in hand did not take as it was given.
    fn keep<const R: usize, const V: usize>(&mut self, written: &Written, replies: &mut PendingReplies<R, V>) {
        let Answer::Took { count, limited: limited @ 1.. } = written.answer else { return };
        let values = written.took.get(..usize::from(count)).unwrap_or(&[]);
        let before = self.values;
        for value in kept(self.calls, limited, values) {
            replies.keep([value]);
            self.values += 1;
        }
        debug_assert!(usize::from(self.values - before) <= MESSAGES_KEPT);
    }
}

impl<const AXES: usize> Admission<'_, AXES> {
    /// Admits the calls of a PathMany from where it stopped, as far as they are taken.
    pub fn admit_joined<const R: usize, const V: usize>(
        &mut self,
        view: &View<AXES>,
        due: DueInstant,
        body: &[u8],
        joined: &mut PathManyProgress,
        replies: &mut PendingReplies<R, V>,
    ) -> Admitted<Advance> {
        let (head, bytes) = PathMany::read_from_prefix(body).map_err(|_| length(body.len(), FIXED_BYTES))?;
        if !joined.has_begun() {
            check(&head, bytes)?;
        }
        let mut advance = Advance { written: None, count: 0, end: PathManyEnd::NoRoom };
        while let Some(call) = call_at(bytes, joined.at.into()) {
            if !replies.has_room(MESSAGES_KEPT) {
                return Ok(advance);
            }
            let due = DueInstant { follows: advance.count > 0, ..due };
            let written = match self.admit_data(view, due, call.0, call.1) {
                Ok(written) => written,
                Err(refused) => return Ok(Advance { end: PathManyEnd::Refused(refused), ..advance }),
            };
            joined.keep(&written, replies);
            joined.at = after(joined.at.into(), call) as u16;
            joined.calls += 1;
            advance.count += 1;
            if let Answer::Path { lasts_ms, .. } = written.answer {
                joined.lasts_ms = lasts_ms;
            }
            if let FifoOf::Crd(crd) = written.of {
                joined.of = Some((crd, written.fifo));
            }
            advance.written = Some(written);
        }
        let PathManyProgress { calls: count, values, lasts_ms, .. } = *joined;
        let (crd, fifo) = match joined.of {
            Some(of) => of,
            None => {
                let context = context!(self, view, due, self.staged);
                (context.crd(head.core.get(), head.crd.get())?, crd::fifo(2, head.fifo.get())?)
            }
        };
        advance.end = PathManyEnd::Done(Answer::Joined { crd, fifo, count, lasts_ms, values });
        Ok(advance)
    }
}

/// Whether there are as many calls as the command says, and all of them are for its FIFO.
fn check(head: &PathMany, bytes: &[u8]) -> Admitted<()> {
    let wanted = protocol::path_many::length(bytes, head.count.get());
    if wanted != Some(bytes.len()) {
        return Err(length(FIXED_BYTES + bytes.len(), FIXED_BYTES + wanted.unwrap_or(0)));
    }
    let own = [head.core.get(), head.crd.get(), head.fifo.get()];
    for (index, call) in calls(bytes).enumerate() {
        if !target(call).is_some_and(|of| of == own || is_short(call)) {
            let refused = Refused::new(Reason::NotOfPath).item(index).axis(own[1]);
            return Err(refused.got(call.0.into()).limits(own[2].into(), 0.0));
        }
    }
    Ok(())
}
