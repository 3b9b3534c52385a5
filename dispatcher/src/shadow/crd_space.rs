//! Free entries of the FIFOs of a coordinate system (CrdSpace).
use super::crd::CrdShadow;
use servo::view::CrdView;

/// Entries of a FIFO, with those that wait in its look-ahead.
pub const CAPACITY: u32 = servo::path::ENTRIES as u32;

impl CrdShadow {
    /// Entries of a FIFO that are over, as far as the view shows of its present filling.
    fn released(&self, sampled: &CrdView, fifo: u8) -> u32 {
        let index = usize::from(fifo & 1);
        if sampled.cleared[index] == self.path(fifo).cleared { sampled.released[index] } else { 0 }
    }
    /// Free entries of a FIFO.
    pub fn space(&self, sampled: &CrdView, fifo: u8) -> u32 {
        let used = self.path(fifo).data.given.wrapping_sub(self.released(sampled, fifo));
        CAPACITY.saturating_sub(used)
    }
    /// Free entries when the next entry acts, for a coordinate system at standstill.
    pub fn space_ahead(&self, sampled: &CrdView, fifo: u8) -> u32 {
        let data = &self.path(fifo).data;
        self.space(sampled, fifo).max(CAPACITY.saturating_sub(data.given.wrapping_sub(data.over)))
    }
}
