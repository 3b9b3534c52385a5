//! Outputs that go back to their other level after a time (SetDoBitReverse).
//!
//! In: an output, and how long it keeps a level. Out: the change back, at its instant. Owns: those
//! that wait. Fails: one more than [`TIMED_OUTPUTS`] is refused.
use super::general_outputs::{OutputChange, OutputEdges};
use crate::units::{DoGroup, Ns};

/// Outputs that may wait at a time.
pub const TIMED_OUTPUTS: usize = 16;

/// One that waits.
#[derive(Debug, Clone, Copy)]
struct TimedOutput {
    due: Ns,
    group: DoGroup,
    bit: u8,
    /// The level that it goes back to.
    high: bool,
}

/// All of them, in no order.
#[derive(Debug)]
pub(crate) struct TimedOutputs {
    list: [TimedOutput; TIMED_OUTPUTS],
    count: usize,
}

impl TimedOutputs {
    pub(crate) const NONE: TimedOutputs = {
        let none = TimedOutput { due: Ns(0), group: DoGroup::General, bit: 0, high: false };
        TimedOutputs { list: [none; TIMED_OUTPUTS], count: 0 }
    };

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether one more may wait. One that waits already gets another time.
    pub(crate) fn takes(&self, group: DoGroup, bit: u8) -> bool {
        self.count < TIMED_OUTPUTS || self.waiting().any(|one| one.group == group && one.bit == bit)
    }

    fn waiting(&self) -> impl Iterator<Item = &TimedOutput> {
        self.list.iter().take(self.count)
    }

    /// An output goes to the level `high` at `due`.
    pub(crate) fn add(&mut self, group: DoGroup, bit: u8, high: bool, due: Ns) {
        self.forget(group, 1u64 << (bit & 63));
        if let Some(slot) = self.list.get_mut(self.count) {
            (*slot, self.count) = (TimedOutput { due, group, bit, high }, self.count.wrapping_add(1));
        }
    }

    /// Outputs of a group that are set otherwise wait no more.
    pub(crate) fn forget(&mut self, group: DoGroup, mask: u64) {
        self.keep(|one| one.group != group || mask >> (one.bit & 63) & 1 == 0);
    }

    /// Those of the interval of `period` that begins at `next` become changes of its outputs.
    #[inline(never)]
    pub(crate) fn take_due(&mut self, next: Ns, period: Ns, edges: &mut OutputEdges) {
        self.keep(|one| {
            let at = one.due.0.saturating_sub(next.0);
            if at >= period.0 || !edges.has_room() {
                return true;
            }
            let (mask, group) = (1u64 << (one.bit & 63), one.group);
            edges.add(at as u32, OutputChange::Digital { group, mask, value: if one.high { mask } else { 0 } });
            false
        });
    }

    fn keep(&mut self, mut stays: impl FnMut(&TimedOutput) -> bool) {
        let mut kept = 0usize;
        for index in 0..self.count.min(TIMED_OUTPUTS) {
            let Some(&one) = self.list.get(index) else { break };
            if stays(&one)
                && let Some(slot) = self.list.get_mut(kept)
            {
                (*slot, kept) = (one, kept.wrapping_add(1));
            }
        }
        self.count = kept;
    }
}
