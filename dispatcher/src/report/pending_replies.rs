//! Replies that wait for the tick, and whether a record was handled.
//!
//! In: what was admitted, what the tick refused. Out: the replies of a lane in order.
use super::answer::{Answer, Refuser, Sent};
use super::path_many;
use super::replies::{Reading, took_reply, values_reply};
use crate::refuse::Refused;
use crate::tick_queue::Until;
use heapless::Deque;
use protocol::command::opcode;
use protocol::reason::Reason;
use protocol::record::ReplyWriter;
use zerocopy::IntoBytes;

servo::state! {
    /// A reply that waits for its entry's execution.
    #[derive(Debug, Clone, Copy)]
    pub struct Awaiting {
        /// Which command.
        pub opcode: u16 = 0,
        /// The client's tag.
        pub tag: u16 = 0,
        /// The entry that it waits for; none if everything before it was executed.
        pub seq: Option<u32> = None,
        /// The entry is not pushed yet (PT data whose commit is still gathering).
        pub open: bool = false,
        /// The entry is the command's own.
        pub own: bool = false,
        /// The entry will never be executed.
        pub discarded: bool = false,
        /// The program goes on if the tick refuses the entry.
        pub may_fail: bool = false,
        /// What to answer.
        pub answer: Answer = Answer::Done,
    }
    /// Waits for nothing.
    pub const BLANK;
}

impl Awaiting {
    /// Whether it is data, whose entry the tick refused: then the answer reports that.
    fn loses(&mut self, refuser: Refuser) -> bool {
        let data = matches!(self.answer, Answer::Taken { .. } | Answer::Entered { .. } | Answer::Lost { .. });
        match refuser {
            Refuser::Axis(axis, status) if data => {
                self.answer = Answer::Lost { axis, status };
                true
            }
            _ => false,
        }
    }
}

/// The replies of a lane that wait, and what they are answered with. Who adds to them checks the
/// room before.
#[derive(Debug)]
pub struct PendingReplies<const REPLIES: usize, const VALUES: usize> {
    /// The replies.
    pub items: Deque<Awaiting, REPLIES>,
    /// What the tick refused among them.
    pub refused: Deque<TickRefusal, 8>,
    /// The values of the Calculate and laser commands among them.
    values: Deque<f64, VALUES>,
}

impl<const REPLIES: usize, const VALUES: usize> PendingReplies<REPLIES, VALUES> {
    /// None.
    pub const fn new() -> Self {
        PendingReplies { items: Deque::new(), refused: Deque::new(), values: Deque::new() }
    }
    /// Whether another reply with so many values fits.
    pub fn has_room(&self, values: usize) -> bool {
        !self.items.is_full() && VALUES - self.values.len() >= values
    }
    /// Appends a reply.
    pub fn push(&mut self, item: Awaiting) {
        let fits = self.items.push_back(item).is_ok();
        debug_assert!(fits, "more replies than wait");
    }
    /// Keeps the values of a reply.
    pub fn keep(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values {
            let fits = self.values.push_back(value).is_ok();
            debug_assert!(fits, "more values than wait");
        }
    }
    /// The values that are kept, oldest first.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied()
    }
    /// The tick refused an entry. True if replies wait for it and all of them may fail.
    pub fn refuse(&mut self, refusal: TickRefusal) -> bool {
        let (mut data, mut asked, mut may_fail) = (false, false, true);
        for item in self.items.iter_mut().filter(|item| item.own && item.seq == Some(refusal.0)) {
            data |= item.loses(refusal.1);
            (asked, may_fail) = (true, may_fail && item.may_fail);
        }
        if !data {
            self.note(refusal);
        }
        asked && may_fail
    }
    /// The next reply that is a refusal reports this. More than wait are not kept.
    pub fn note(&mut self, refusal: TickRefusal) {
        self.refused.push_back(refusal).ok();
    }
    /// How far the executed state may go on before the first reply is written.
    pub fn until(&self) -> Until {
        match self.items.front() {
            // All that is in flight comes before data whose commit is not pushed yet.
            None | Some(Awaiting { open: true, .. }) => Until::Everything,
            Some(item) => item.seq.map_or(Until::Nothing, Until::Entry),
        }
    }
    /// The values that are kept for the command in hand, which are the last ones.
    pub fn newest(&self, count: usize) -> impl Iterator<Item = f64> {
        self.values.iter().skip(self.values.len().saturating_sub(count)).copied()
    }
    /// The command in hand has been answered.
    pub fn forget_newest(&mut self, count: usize) {
        for _ in 0..count {
            self.values.pop_back();
        }
    }
    /// The first reply has been written.
    pub fn pop(&mut self) {
        for _ in 0..self.items.pop_front().map_or(0, |item| item.answer.waiting()) {
            self.values.pop_front();
        }
    }
    /// Nobody waits for them any more.
    pub fn abandon(&mut self) {
        self.items.clear();
        self.values.clear();
    }
}

/// A start, data, or an on command of a laser, that the tick refused.
pub type TickRefusal = (u32, Refuser);

/// Whether a record was handled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordOutcome {
    /// It was handled.
    Taken,
    /// Not now: try again after the next tick or frame. Nothing has changed.
    Wait,
}

impl RecordOutcome {
    /// A reply that did not fit is tried again.
    pub fn of(written: Sent) -> RecordOutcome {
        if written.is_ok() { RecordOutcome::Taken } else { RecordOutcome::Wait }
    }
}

impl<const AXES: usize> Reading<'_, AXES> {
    /// Writes the reply to an executed command; `taken` are the values that wait in its lane,
    /// oldest first.
    pub fn answer(&self, item: &Awaiting, taken: impl Iterator<Item = f64>, out: &mut ReplyWriter) -> Sent {
        let mut say = |reply: &[&[u8]]| out.push_raw(item.opcode, item.tag, 0, reply);
        match item.answer {
            Answer::Done => say(&[]),
            Answer::Read(query) => self.reply(item.tag, &query, out),
            Answer::Space(space) => say(&[&space.to_le_bytes()]),
            Answer::Long(value) => say(&[&value.to_le_bytes()]),
            Answer::Number(value) => say(&[&value.to_le_bytes()]),
            Answer::Path { crd, fifo, count, lasts_ms } => {
                say(&[self.path_taken((crd, fifo), count, lasts_ms).as_bytes()])
            }
            Answer::Joined { crd, fifo, count, lasts_ms, values } => {
                let reply = self.path_taken((crd, fifo), count, lasts_ms);
                path_many::done((item.opcode, item.tag), reply, &mut taken.take(values.into()), out)
            }
            Answer::Part(_) => Ok(()),
            // FollowDataPercent2Ex alone replies with the share of the first half.
            Answer::Entered { axis, fifo, percent1 } if item.opcode == opcode::FollowDataPercent2Ex => {
                say(&[self.entered(axis, fifo).as_bytes(), &percent1.to_le_bytes()])
            }
            Answer::Entered { axis, fifo, .. } => say(&[self.entered(axis, fifo).as_bytes()]),
            Answer::Taken { axis, fifo, count } => say(&[self.taken(axis, fifo, count).as_bytes()]),
            Answer::Lost { axis, status } => {
                let lost = match item.opcode {
                    // An immediate switch is no data, but is answered like it.
                    opcode::FollowSwitchNowEx => self.explain(item.opcode, Refuser::Axis(axis, status)),
                    _ => {
                        let stop = self.view.axes.get(axis.index()).map_or(0, |sampled| sampled.stop as u16);
                        let lost = Refused::new(Reason::StreamEnded).axis(self.configuration.number_of(axis));
                        lost.got(status.into()).limits(0.0, stop.into())
                    }
                };
                out.refused(item.opcode, item.tag, &lost.wire)
            }
            Answer::Values(count) => values_reply(item.opcode, item.tag, taken.take(count.into()), out),
            Answer::Took { count, limited } => took_reply(item.opcode, item.tag, taken, (count, limited), out),
        }
    }
}
