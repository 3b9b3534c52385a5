//! What the motion of an axis is read from.
//!
//! In: slots of FIFOs, points of tables. Out: their contents. Owns nothing. Cannot fail.
use crate::segment::follow::{self, FollowEntries};
use crate::segment::pt::{Segment, SegmentStore, Segments};
use crate::segment::pvt::{HEADER_WORDS, POINT_WORDS, PvtTables};
use crate::tables::TableStores;

/// Its own segments, and all tables.
pub(crate) struct MotionSource<'a> {
    pub(crate) segments: &'a SegmentStore,
    pub(crate) tables: TableStores<'a>,
}

impl Segments for MotionSource<'_> {
    #[inline]
    fn segment(&self, slot: u32) -> Segment {
        self.segments.segment(slot)
    }
}

impl PvtTables for MotionSource<'_> {
    #[inline]
    fn point(&self, table: u8, index: u32) -> [u32; POINT_WORDS] {
        self.tables.point(table, index)
    }
    #[inline]
    fn header(&self, table: u8) -> [u32; HEADER_WORDS] {
        self.tables.header(table)
    }
    #[inline]
    fn version(&self, table: u8) -> u32 {
        self.tables.version(table)
    }
    #[inline]
    fn is_empty(&self, table: u8) -> bool {
        self.tables.is_empty(table)
    }
}

impl FollowEntries for MotionSource<'_> {
    #[inline]
    fn entry(&self, fifo: u8, index: u32) -> follow::FollowEntry {
        self.segments.entry(fifo, index)
    }
}
