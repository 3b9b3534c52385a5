//! Words in slots, written by the thread, read by the tick.
//!
//! In: `WORDS` words for each slot. Out: the same words. Owns: the memory.
//! A slot may be written only while the reader does not read it. Numbers agree on this: one travels
//! through a [`crate::Ring`] (the slot is filled), one through a [`crate::Latest`] (the slot is
//! free again). Their Release and Acquire make the words visible, so the words themselves are
//! relaxed.
//! Fails: never; if the agreement were broken a read could give a mixture, not undefined behaviour.
use crate::sync::{AtomicU32, Ordering};

/// `SLOTS` (a power of two) slots of `WORDS` words, all zero at first.
pub struct Store<const WORDS: usize, const SLOTS: usize> {
    words: [[AtomicU32; WORDS]; SLOTS],
}

impl<const WORDS: usize, const SLOTS: usize> Store<WORDS, SLOTS> {
    const MASK: u32 = {
        assert!(SLOTS.is_power_of_two() && SLOTS <= 1 << 31, "a store's size is a power of two");
        (SLOTS - 1) as u32
    };

    /// All words zero.
    #[cfg(not(all(test, loom)))]
    pub const fn new() -> Self {
        Store { words: [const { [const { AtomicU32::new(0) }; WORDS] }; SLOTS] }
    }

    /// All words zero, with loom's parts.
    #[cfg(all(test, loom))]
    pub fn new() -> Self {
        Store { words: core::array::from_fn(|_| core::array::from_fn(|_| AtomicU32::new(0))) }
    }

    /// Fills slot `slot` modulo `SLOTS`.
    pub fn write(&self, slot: u32, words: [u32; WORDS]) {
        for (to, from) in self.words[(slot & Self::MASK) as usize].iter().zip(words) {
            // Relaxed: made visible by the commit that follows through a ring.
            to.store(from, Ordering::Relaxed);
        }
    }

    /// One word of slot `slot` modulo `SLOTS`; 0 for an index beyond it.
    pub fn word(&self, slot: u32, index: usize) -> u32 {
        // Relaxed: as in `read`.
        self.words[(slot & Self::MASK) as usize].get(index).map_or(0, |word| word.load(Ordering::Relaxed))
    }

    /// The words of slot `slot` modulo `SLOTS`.
    pub fn read(&self, slot: u32) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        for (to, from) in words.iter_mut().zip(&self.words[(slot & Self::MASK) as usize]) {
            // Relaxed: the commit that made this slot readable was taken from a ring before.
            *to = from.load(Ordering::Relaxed);
        }
        words
    }
}

impl<const WORDS: usize, const SLOTS: usize> Default for Store<WORDS, SLOTS> {
    fn default() -> Self {
        Self::new()
    }
}
