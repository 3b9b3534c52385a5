//! The store of segments between admission and the tick.
//!
//! In: admitted segments from the thread, by slot. Out: the same, to the tick. Owns: the memory of
//! one axis. Fails: never; a slot counts modulo [`SEGMENTS`].
use super::segment::Segment;
use ring::Store;

/// Where a run reads its segments.
pub trait Segments {
    /// The segment in a slot; a slot that was never written holds the segment of zeros.
    fn segment(&self, slot: u32) -> Segment;
}

/// PT segments of an axis.
pub const SEGMENTS: usize = 2048;

/// PT segments of one axis. The thread writes a slot only while the tick does not read it; the
/// commit that follows makes it visible.
pub struct SegmentStore(Store<3, SEGMENTS>);

impl SegmentStore {
    /// All slots hold the segment of zeros.
    pub const fn new() -> SegmentStore {
        SegmentStore(Store::new())
    }

    /// Fills a slot.
    #[inline]
    pub fn write(&self, slot: u32, segment: Segment) {
        self.0.write(slot, segment.words());
    }

    /// Fills a slot with words of another mode.
    pub(crate) fn write_words(&self, slot: u32, words: [u32; 3]) {
        self.0.write(slot, words);
    }

    /// The words of a slot.
    #[inline(always)]
    pub(crate) fn words(&self, slot: u32) -> [u32; 3] {
        self.0.read(slot)
    }
}

impl Segments for SegmentStore {
    #[inline]
    fn segment(&self, slot: u32) -> Segment {
        Segment::from_words(self.0.read(slot))
    }
}
