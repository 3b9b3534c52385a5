//! A queue in place with a fixed capacity.

/// A queue of at most `N` values in place.
#[derive(Debug)]
pub struct Deque<T, const N: usize> {
    slots: [T; N],
    first: usize,
    len: usize,
}

impl<T: Copy, const N: usize> Deque<T, N> {
    /// An empty queue; `blank` fills the unused slots.
    pub fn new(blank: T) -> Self {
        Deque { slots: [blank; N], first: 0, len: 0 }
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
        self.slots[(self.first + self.len) % N] = value;
        self.len += 1;
        true
    }
    /// The oldest value.
    pub fn front(&self) -> Option<&T> {
        if self.len == 0 { None } else { self.slots.get(self.first) }
    }
    /// Takes the oldest value.
    pub fn pop(&mut self) -> Option<T> {
        let value = *self.front()?;
        self.first = (self.first + 1) % N;
        self.len -= 1;
        Some(value)
    }
    /// Changes values in place, from the newest to the oldest, as long as `change` returns true.
    pub fn amend_back(&mut self, mut change: impl FnMut(&mut T) -> bool) {
        for back in (0..self.len).rev() {
            if !change(&mut self.slots[(self.first + back) % N]) {
                break;
            }
        }
    }
    /// The values, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        (0..self.len).filter_map(|back| self.slots.get((self.first + back) % N))
    }
    /// Drops everything.
    pub fn clear(&mut self) {
        self.len = 0;
    }
}
