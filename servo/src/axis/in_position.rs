//! The in-position band: an axis at standstill is in position once its encoder has been inside the
//! band for a time.
//!
//! In: the planned position, the encoder's reading, the instant of the tick. Out: in position or
//! not, and whether only time is missing. Owns nothing: band, time and the instant of entry are in
//! [`Inputs`]. Cannot fail.
use super::following_error::error;
use super::inputs::Inputs;
use crate::units::{Ns, Pos};

impl Inputs {
    /// Band in pulses, and for how long.
    pub(crate) fn set_band(&mut self, band: u32, time: Ns) {
        (self.band, self.band_time, self.inside) = (band, time, None);
    }

    /// Whether the encoder has been inside the band for the band's time at `now`, with the axis at
    /// rest; and whether only time is missing.
    pub(crate) fn in_position(&mut self, now: Ns, pos: Pos, encoder: i64) -> (bool, bool) {
        if error(pos, encoder) > (self.band as u64) << Pos::FRAC_BITS {
            self.inside = None;
            return (false, false);
        }
        let since = *self.inside.get_or_insert(now);
        let done = now.0.wrapping_sub(since.0) >= self.band_time.0;
        (done, !done)
    }

    /// The axis moves: the band's time begins anew.
    #[inline]
    pub(crate) fn leave_position(&mut self) {
        self.inside = None;
    }
}
