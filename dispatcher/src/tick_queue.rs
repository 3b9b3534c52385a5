//! One queue into the tick (a lane): the ring's end, the numbering, and a log of what is in flight.
//!
//! In: staged tick commands with their changes. Out: entries in the ring; changes for the executed
//! state once the view shows that their entries were executed.
//! Fails: what does not fit is for the caller to try again later ([`TickQueue::room`]).
use crate::shadow::{ShadowChange, Shadows, executed, is_up_to, seq_after};
use heapless::Deque;
use protocol::reason::Reason;
use ring::Producer;
use servo::tick_command::{LaneEntry, TickCommand};
use servo::units::Ns;
use servo::view::View;

/// How far the executed state may follow the tick. A reply that waits is written from the state
/// that its command met: what comes after it is not entered before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Until {
    /// No reply waits.
    Everything,
    /// The first reply that waits comes after this entry.
    Entry(u32),
    /// It comes before all entries in flight.
    Nothing,
}

impl Until {
    fn allows(self, seq: u32) -> bool {
        match self {
            Until::Everything => true,
            Until::Entry(last) => is_up_to(seq, last),
            Until::Nothing => false,
        }
    }
}

/// One lane of at most `N` entries in flight.
pub struct TickQueue<'a, const N: usize> {
    ring: Producer<'a, LaneEntry, N>,
    /// Number of the last entry pushed.
    pub last: u32,
    log: Deque<(u32, ShadowChange), N>,
}

impl<'a, const N: usize> TickQueue<'a, N> {
    /// A lane whose numbers carry `flag`.
    pub fn new(ring: Producer<'a, LaneEntry, N>, flag: u32) -> Self {
        TickQueue { ring, last: flag, log: Deque::new() }
    }
    /// Entries that can be pushed now.
    pub fn room(&self) -> usize {
        self.ring.free().min(N - self.log.len())
    }
    /// Whether entries were pushed that the view does not show as executed.
    pub fn in_flight(&self) -> bool {
        !self.log.is_empty()
    }
    /// The changes in flight with the numbers of their entries, the oldest first.
    pub fn changes<const AXES: usize>(&self, view: &View<AXES>) -> impl Iterator<Item = &(u32, ShadowChange)> {
        self.log.iter().filter(|(seq, _)| !executed(view, *seq))
    }
    /// Whether one of them may end the state for which a command is refused now.
    pub fn may_free(&self, reason: Reason) -> bool {
        self.log.iter().any(|(_, change)| change.may_free(reason))
    }
    /// Pushes one tick command; false if there is no room.
    pub fn push<const AXES: usize>(
        &mut self,
        command: TickCommand,
        change: ShadowChange,
        delay: u64,
        ahead: &mut Shadows<AXES>,
    ) -> bool {
        if self.room() == 0 {
            return false;
        }
        let seq = seq_after(self.last);
        if self.ring.push(LaneEntry { seq, delay: Ns(delay), command }).is_err()
            || self.log.push_back((seq, change)).is_err()
        {
            return false;
        }
        self.last = seq;
        ahead.enter(&change, seq);
        ahead.forget_emptied(&change);
        true
    }
    /// Enters into `now` what the tick has executed, up to what `until` allows. Returns whether
    /// that is everything.
    pub fn retire<const AXES: usize>(&mut self, view: &View<AXES>, now: &mut Shadows<AXES>, until: Until) -> bool {
        while let Some(&(seq, change)) = self.log.front() {
            if !executed(view, seq) {
                break;
            }
            if !until.allows(seq) {
                return false;
            }
            now.enter(&change, seq);
            self.log.pop_front();
        }
        true
    }
    /// Enters what is still in flight into an admitted state that was set back.
    pub fn replay<const AXES: usize>(&self, ahead: &mut Shadows<AXES>) {
        for (seq, change) in self.log.iter() {
            ahead.enter(change, *seq);
        }
    }
    /// Forgets what is in flight, after the tick has dropped it.
    pub fn forget(&mut self) {
        self.log.clear();
    }
}
