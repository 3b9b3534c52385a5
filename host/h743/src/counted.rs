//! Instructions of a handler.
//!
//! In: exceptions as they begin and end. Out: how many instructions each run took. Owns the counts.
//! Fails never.

/// The instructions of each run of a handler, from its vector to its return; those of handlers that
/// come in between are among them.
#[derive(Debug, Default)]
pub struct Counted {
    /// The exception.
    pub exception: usize,
    began: Option<u64>,
    /// Of each run, in order.
    pub runs: Vec<u64>,
}

impl Counted {
    /// Of an exception, from its next run on.
    pub fn of(exception: usize) -> Counted {
        Counted { exception, ..Counted::default() }
    }

    /// An exception begins, or ends, after so many instructions.
    pub(crate) fn note(&mut self, exception: usize, begins: bool, instructions: u64) {
        if exception != self.exception {
        } else if begins {
            self.began = Some(instructions);
        } else {
            self.runs.extend(self.began.take().map(|began| instructions - began));
        }
    }
}
