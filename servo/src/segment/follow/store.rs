//! The store of entries between admission and the tick: the axis's PT arena, two slots for an
//! entry, one FIFO after the other. An axis is in one mode at a time, and changing it clears the
//! data.
use super::entry::FollowEntry;
use crate::segment::pt::{SEGMENTS, SegmentStore};

/// Where a run reads its entries.
pub trait FollowEntries {
    /// The entry in a slot of a FIFO; one that was never written holds an entry of zeros.
    fn entry(&self, fifo: u8, index: u32) -> FollowEntry;
}

/// The first of an entry's two slots.
#[inline(always)]
fn slot(fifo: u8, index: u32) -> u32 {
    const FIFO_SEGMENTS: u32 = SEGMENTS as u32 / 2;
    (fifo as u32 & 1) * FIFO_SEGMENTS + ((index * 2) & (FIFO_SEGMENTS - 1))
}

impl SegmentStore {
    /// Fills a slot of a FIFO (0, 1) with an entry of Follow. Its commit makes it visible.
    pub fn write_entry(&self, fifo: u8, index: u32, entry: FollowEntry) {
        let [low, high] = entry.words();
        let slot = slot(fifo, index);
        self.write_words(slot, low);
        self.write_words(slot | 1, high);
    }
}

impl FollowEntries for SegmentStore {
    #[inline]
    fn entry(&self, fifo: u8, index: u32) -> FollowEntry {
        let slot = slot(fifo, index);
        FollowEntry::from_words([self.words(slot), self.words(slot | 1)])
    }
}
