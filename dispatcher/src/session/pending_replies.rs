//! Replies that wait for the tick, and what became of a record.
use crate::admit::context::Answer;
use protocol::record::Full;
use servo::units::{Axis, Crd};

/// A reply that waits for its entry's execution.
#[derive(Debug, Clone, Copy)]
pub struct Awaiting {
    /// Which command.
    pub opcode: u16,
    /// The client's tag.
    pub tag: u16,
    /// The entry it waits for; none if everything before it was executed.
    pub seq: Option<u32>,
    /// The entry is not pushed yet (PT data whose commit is still gathering).
    pub open: bool,
    /// The entry is the command's own.
    pub own: bool,
    /// The entry will never be executed.
    pub discarded: bool,
    /// The program goes on if the tick refuses the entry.
    pub may_fail: bool,
    /// What to answer.
    pub answer: Answer,
}

impl Awaiting {
    /// Fills unused places.
    pub const BLANK: Awaiting = Awaiting {
        opcode: 0,
        tag: 0,
        seq: None,
        open: false,
        own: false,
        discarded: false,
        may_fail: false,
        answer: Answer::Done,
    };
}

impl Awaiting {
    /// Whether it is data that waits for this entry, which the tick refused: then the answer says so.
    pub fn loses(&mut self, (seq, refuser): TickRefusal) -> bool {
        let data = matches!(self.answer, Answer::Taken { .. } | Answer::Entered { .. } | Answer::Lost { .. });
        match refuser {
            Refuser::Axis(axis, status) if data && self.own && self.seq == Some(seq) => {
                self.answer = Answer::Lost { axis, status };
                true
            }
            _ => false,
        }
    }
}

/// A start, data, or an on command of a laser, that the tick refused.
pub type TickRefusal = (u32, Refuser);

/// Because of whom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refuser {
    /// Nobody: the entry was late and the program is strict.
    Nobody,
    /// An axis with this status.
    Axis(Axis, u32),
    /// A coordinate system.
    Crd(Crd),
    /// A laser channel that a fault keeps dark.
    Laser(u8),
}

/// What became of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// It was dealt with.
    Taken,
    /// Not now: try again when the tick or the link has moved on. Nothing has changed.
    Wait,
}

impl Step {
    /// A reply that did not fit is tried again.
    pub fn of(written: Result<(), Full>) -> Step {
        if written.is_ok() { Step::Taken } else { Step::Wait }
    }
}
