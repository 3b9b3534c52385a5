//! Data that a handler touches.
//!
//! In: reads and writes of the core, exceptions as they begin. Out: how many runs of the handler
//! touched each word, and how often. Owns the counts. What the core itself stacks is not among
//! them. Fails never.
use std::collections::BTreeMap;

/// A word that the handler has touched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Word {
    /// Runs in which it did.
    pub runs: u64,
    /// Reads of all of them.
    pub reads: u64,
    /// Writes.
    pub writes: u64,
    last: u64,
}

/// The words that a handler touches, by address.
#[derive(Debug, Default)]
pub struct Accesses {
    /// The exception.
    pub exception: usize,
    /// Runs that have begun.
    pub runs: u64,
    /// By the address of a word.
    pub words: BTreeMap<u32, Word>,
}

impl Accesses {
    /// Of an exception, from its next run on.
    pub fn of(exception: usize) -> Accesses {
        Accesses { exception, ..Accesses::default() }
    }

    /// An exception begins.
    pub(crate) fn note(&mut self, exception: usize, begins: bool) {
        self.runs += u64::from(begins && exception == self.exception);
    }

    /// While an exception runs, so many bytes are read or written.
    pub(crate) fn touch(&mut self, running: usize, address: u32, size: u32, is_write: bool) {
        if running != self.exception || self.runs == 0 {
            return;
        }
        for at in (address & !3..address + size).step_by(4) {
            let word = self.words.entry(at).or_default();
            if word.last != self.runs {
                (word.last, word.runs) = (self.runs, word.runs + 1);
            }
            *(if is_write { &mut word.writes } else { &mut word.reads }) += 1;
        }
    }
}
