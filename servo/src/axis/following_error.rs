//! The following error of an axis: |planned position − encoder position|.
//!
//! In: the planned position in force, the encoder's reading, the limit that `SetPosErr` set. Out:
//! the status bit of a following error beyond its limit. Owns nothing: the limit is in [`Inputs`].
//! Cannot fail. What the bit does to the axis: `input_scan.rs` latches it, `motion.rs` stops a
//! motion for it.
use super::inputs::{Inputs, reading};
use crate::status;
use crate::units::Pos;

/// |planned − encoder|, in units of [`Pos`].
pub(super) fn error(pos: Pos, encoder: i64) -> u64 {
    pos.0.abs_diff(reading(encoder).0)
}

impl Inputs {
    /// The following error's status bit, if it is beyond its limit.
    #[inline]
    pub(crate) fn following_error(&self, pos: Pos, encoder: i64) -> u32 {
        match self.error_limit {
            Some(limit) if error(pos, encoder) > (limit as u64) << Pos::FRAC_BITS => status::FOLLOWING_ERROR,
            _ => 0,
        }
    }
}
