//! The memory of all tables: PVT points and headers, those of laser channels, written by the
//! thread, read by the tick.
//!
//! In: words of a table that no axis runs. Out: the same words. Owns nothing: the memory is the
//! board's. Who may write when is agreed as for [`ring::Store`]: before the tick command that first
//! names the table. Cannot fail: what does not exist reads as zeros and takes nothing.
use crate::segment::pvt::{HEADER_WORDS, HeaderStore, POINT_WORDS, PointStore, PvtTables, TABLES, VERSION};

/// Points and headers of all tables; see the module text.
#[derive(Clone, Copy)]
pub struct TableStores<'a> {
    /// Points, one store for each table.
    pub points: &'a [PointStore; TABLES],
    /// Headers, one slot for each table.
    pub headers: &'a HeaderStore,
    /// Those of laser channels.
    pub lasers: &'a crate::laser::PowerTables,
    /// Counts of the edges of inputs, which the tick writes too.
    pub edges: &'a crate::edge_counts::EdgeCounts,
}

impl TableStores<'_> {
    /// Writes point `index` of a table.
    pub fn write_point(&self, table: u8, index: u32, words: [u32; POINT_WORDS]) {
        if let Some(points) = self.points.get(table as usize) {
            points.write(index, words);
        }
    }

    /// Writes the header of a table, after its points: a reader of the old ones finds another
    /// version.
    pub fn write_header(&self, table: u8, mut words: [u32; HEADER_WORDS]) {
        if (table as usize) < TABLES {
            if let Some(version) = words.get_mut(VERSION) {
                *version = self.version(table).wrapping_add(1);
            }
            self.headers.write(table as u32, words);
        }
    }
}

impl PvtTables for TableStores<'_> {
    #[inline]
    fn point(&self, table: u8, index: u32) -> [u32; POINT_WORDS] {
        self.points.get(table as usize).map_or([0; POINT_WORDS], |points| points.read(index))
    }

    #[inline]
    fn header(&self, table: u8) -> [u32; HEADER_WORDS] {
        if (table as usize) < TABLES { self.headers.read(table as u32) } else { [0; HEADER_WORDS] }
    }

    #[inline]
    fn version(&self, table: u8) -> u32 {
        if (table as usize) < TABLES { self.headers.word(table as u32, VERSION) } else { 0 }
    }

    #[inline]
    fn is_empty(&self, table: u8) -> bool {
        (table as usize) >= TABLES || self.headers.word(table as u32, 0) as u16 == 0
    }
}
