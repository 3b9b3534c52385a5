//! One lane into the tick: the ring's end, the numbering, and a log of what is in flight.
//!
//! In: staged operations with their changes. Out: entries in the ring; changes for the *now* books
//! once the view says that their entries were executed. Bounded by the ring: what does not fit is
//! for the caller to try again later ([`Lane::room`]).
use crate::shadow::{Change, Shadows, executed, seq_after, seq_from};
use ring::Producer;
use servo::op::{Entry, Op};
use servo::units::Ns;
use servo::view::View;

/// A queue of at most `N` values in place.
#[derive(Debug)]
pub struct Deque<T, const N: usize> {
    places: [T; N],
    first: usize,
    len: usize,
}

impl<T: Copy, const N: usize> Deque<T, N> {
    /// An empty queue; `blank` fills the unused places.
    pub fn new(blank: T) -> Self {
        Deque { places: [blank; N], first: 0, len: 0 }
    }
    /// Values in the queue.
    pub fn len(&self) -> usize {
        self.len
    }
    /// Values that still fit.
    pub fn room(&self) -> usize {
        N - self.len
    }
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
    /// Whether no more fit.
    pub fn is_full(&self) -> bool {
        self.len >= N
    }
    /// Appends a value; false if it does not fit.
    pub fn push(&mut self, value: T) -> bool {
        if self.is_full() {
            return false;
        }
        self.places[(self.first + self.len) % N] = value;
        self.len += 1;
        true
    }
    /// The oldest value.
    pub fn front(&self) -> Option<&T> {
        if self.len == 0 { None } else { self.places.get(self.first) }
    }
    /// Takes the oldest value.
    pub fn pop(&mut self) -> Option<T> {
        let value = *self.front()?;
        self.first = (self.first + 1) % N;
        self.len -= 1;
        Some(value)
    }
    /// From the newest to the oldest, to be changed in place, as long as `change` says true.
    pub fn amend_back(&mut self, mut change: impl FnMut(&mut T) -> bool) {
        for back in (0..self.len).rev() {
            if !change(&mut self.places[(self.first + back) % N]) {
                break;
            }
        }
    }
    /// Whether any value satisfies `test`.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        (0..self.len).filter_map(|back| self.places.get((self.first + back) % N))
    }
    /// Drops everything.
    pub fn clear(&mut self) {
        self.len = 0;
    }
}

/// Most operations that one command, or one item of LoadConfig, becomes: Reset with both lasers.
pub const STAGED: usize = 12;
/// The same of every command but Reset: LmtSns over 8 axes and SetDac of 8 outputs are the largest.
pub const FEW: usize = 8;

/// Operations of one admitted command, not yet pushed: a command that is refused half-way has
/// changed nothing.
#[derive(Debug)]
pub struct Staged {
    ops: [(Op, Change); STAGED],
    len: usize,
}

impl Staged {
    /// Nothing staged.
    pub fn new() -> Self {
        Staged { ops: [(Op::Mark, Change::None); STAGED], len: 0 }
    }
    /// Forgets what is staged.
    pub fn clear(&mut self) {
        self.len = 0;
    }
    /// Adds an operation.
    pub fn add(&mut self, op: Op, change: Change) {
        debug_assert!(self.len < STAGED, "a command of more than {STAGED} operations");
        if let Some(place) = self.ops.get_mut(self.len) {
            *place = (op, change);
            self.len += 1;
        }
    }
    /// What is staged, in order.
    pub fn ops(&self) -> &[(Op, Change)] {
        self.ops.get(..self.len).unwrap_or(&[])
    }
}

/// One lane of at most `N` entries in flight.
pub struct Lane<'a, const N: usize> {
    ring: Producer<'a, Entry, N>,
    last: u32,
    log: Deque<(u32, Change), N>,
}

impl<'a, const N: usize> Lane<'a, N> {
    /// A lane whose numbers carry `flag`.
    pub fn new(ring: Producer<'a, Entry, N>, flag: u32) -> Self {
        Lane { ring, last: flag, log: Deque::new((0, Change::None)) }
    }
    /// Entries that can be pushed now.
    pub fn room(&self) -> usize {
        self.ring.free().min(N - self.log.len())
    }
    /// As if so many entries more had gone through; nothing is in flight.
    pub fn age(&mut self, entries: u32) {
        if self.log.is_empty() {
            self.last = seq_from(self.last, entries);
        }
    }
    /// Number of the last entry pushed.
    pub fn last(&self) -> u32 {
        self.last
    }
    /// Whether entries were pushed that the tick has not been seen to execute.
    pub fn in_flight(&self) -> bool {
        !self.log.is_empty()
    }
    /// What they change, and their numbers, the oldest first.
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
        if self.ring.push(Entry { seq, delay: Ns(delay), op }).is_err() {
            return false;
        }
        self.last = seq;
        self.log.push((seq, change));
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
            self.log.pop();
        }
    }
    /// Enters what is still in flight into books that were set back.
    pub fn replay<const AXES: usize>(&self, ahead: &mut Shadows<AXES>) {
        for (seq, change) in self.log.iter() {
            ahead.enter(change, *seq);
        }
    }
    /// Forgets what is in flight: the tick has dropped it.
    pub fn forget(&mut self) {
        self.log.clear();
    }
}
