//! One lane into the tick: the ring's end, the numbering, and a log of what is in flight.
//!
//! In: staged operations with their changes. Out: entries in the ring; changes for the executed
//! state once the view shows that their entries were executed.
//! Fails: what does not fit is for the caller to try again later ([`Lane::room`]).
use crate::shadow::{Change, Shadows, executed, seq_after, seq_from};
use heapless::Deque;
use ring::Producer;
use servo::op::{Entry, Op};
use servo::units::Ns;
use servo::view::View;

/// One lane of at most `N` entries in flight.
pub struct Lane<'a, const N: usize> {
    ring: Producer<'a, Entry, N>,
    last: u32,
    log: Deque<(u32, Change), N>,
}

impl<'a, const N: usize> Lane<'a, N> {
    /// A lane whose numbers carry `flag`.
    pub fn new(ring: Producer<'a, Entry, N>, flag: u32) -> Self {
        Lane { ring, last: flag, log: Deque::new() }
    }
    /// Entries that can be pushed now.
    pub fn room(&self) -> usize {
        self.ring.free().min(N - self.log.len())
    }
    /// Advances the numbers by `entries`, for tests of counters; nothing is in flight.
    pub fn age(&mut self, entries: u32) {
        if self.log.is_empty() {
            self.last = seq_from(self.last, entries);
        }
    }
    /// Number of the last entry pushed.
    pub fn last(&self) -> u32 {
        self.last
    }
    /// Whether entries were pushed that the view does not show as executed.
    pub fn in_flight(&self) -> bool {
        !self.log.is_empty()
    }
    /// The changes in flight with the numbers of their entries, the oldest first.
    pub fn changes(&self) -> impl Iterator<Item = &(u32, Change)> {
        self.log.iter()
    }
    /// Whether one of them may end what keeps a command from being taken now.
    pub fn may_free(&self) -> bool {
        self.log.iter().any(|(_, change)| change.may_free())
    }
    /// Pushes one operation; false if there is no room.
    pub fn push<const AXES: usize>(&mut self, op: Op, change: Change, delay: u64, ahead: &mut Shadows<AXES>) -> bool {
        if self.room() == 0 {
            return false;
        }
        let seq = seq_after(self.last);
        if self.ring.push(Entry { seq, delay: Ns(delay), op }).is_err() || self.log.push_back((seq, change)).is_err() {
            return false;
        }
        self.last = seq;
        ahead.enter(&change, seq);
        true
    }
    /// Enters into `now` what the tick has executed.
    pub fn retire<const AXES: usize>(&mut self, view: &View<AXES>, now: &mut Shadows<AXES>) {
        while let Some(&(seq, change)) = self.log.front() {
            if !executed(view, seq) {
                break;
            }
            now.enter(&change, seq);
            self.log.pop_front();
        }
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
