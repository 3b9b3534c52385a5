//! Numbers of entries: which lane, which comes first, and what was executed.
//!
//! In: numbers, the view. Out: the same. Owns: what was executed when numbers were renewed last.
//! Cannot fail: numbers wrap, and old ones are renewed long before they would look new.
use servo::view::View;

/// Set in the numbers of the program lane, so that a number shows its lane.
pub const PROGRAM_FLAG: u32 = 1 << 31;

/// The number after `seq` in its lane.
pub const fn seq_after(seq: u32) -> u32 {
    seq_from(seq, 1)
}

/// The number `entries` after `seq` in its lane.
pub const fn seq_from(seq: u32, entries: u32) -> u32 {
    seq & PROGRAM_FLAG | seq.wrapping_add(entries) & !PROGRAM_FLAG
}

/// Entries from `first` to `last`, which are of one lane.
pub const fn entries_from(first: u32, last: u32) -> u32 {
    last.wrapping_sub(first) & !PROGRAM_FLAG
}

/// Whether `seq` comes before `last` in its lane, or is it. Numbers have 31 bits; shifted up, their
/// difference has a sign.
pub const fn is_up_to(seq: u32, last: u32) -> bool {
    (last.wrapping_sub(seq) << 1).cast_signed() >= 0
}

/// Whether the tick that `view` shows has executed entry `seq`.
pub fn executed<const AXES: usize>(view: &View<AXES>, seq: u32) -> bool {
    let done = if seq & PROGRAM_FLAG == 0 { view.done_immediate } else { view.done_program };
    // A lane that has executed nothing yet shows 0, which has no flag.
    done & PROGRAM_FLAG == seq & PROGRAM_FLAG && is_up_to(seq, done)
}

/// Whether there is such an entry, and the tick has not executed it.
pub fn is_in_flight<const AXES: usize>(view: &View<AXES>, seq: Option<u32>) -> bool {
    seq.is_some_and(|seq| !executed(view, seq))
}

/// Entries after which numbers are renewed. Numbers are compared over half their range: one
/// executed 2³⁰ entries ago would look as if it were still to come.
const RENEWED_AFTER_ENTRIES: u32 = 1 << 24;

/// What each lane had executed when numbers were renewed last.
#[derive(Debug, Clone, Copy, Default)]
pub struct RefreshedNumbers([u32; 2]);

impl RefreshedNumbers {
    /// Whether it is time to renew them.
    pub fn is_due<const AXES: usize>(&mut self, view: &View<AXES>) -> bool {
        let done = [view.done_immediate, view.done_program];
        let far = |(now, before): (u32, u32)| entries_from(before, now) >= RENEWED_AFTER_ENTRIES;
        let due = done.into_iter().zip(self.0).any(far);
        if due {
            self.0 = done;
        }
        due
    }
}

/// An executed entry takes the number of its lane's last executed one: so it stays executed.
pub fn renew<const AXES: usize>(view: &View<AXES>, seq: &mut u32) {
    if executed(view, *seq) {
        *seq = if *seq & PROGRAM_FLAG == 0 { view.done_immediate } else { view.done_program };
    }
}
