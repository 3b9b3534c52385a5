//! User positions: what the user names the planned position and the encoder's count.
//!
//! In: values for the planned position and for the encoder. Out: the machine's set-point, which no
//! such value changes.
use super::{AxisState, exact};
use crate::units::Pos;

impl AxisState {
    /// The machine's set-point for the planned position.
    #[inline]
    pub(crate) fn set_point(&self) -> Pos {
        Pos(self.published.pos.0.wrapping_sub(self.zero.0))
    }

    /// The planned position where the machine's set-point is 0.
    pub(crate) fn zero(&self) -> Pos {
        self.zero
    }

    /// At standstill, the planned position gets the name `at`; the machine does not move.
    pub(crate) fn rename(&mut self, at: Pos) {
        if !self.runs() {
            self.zero = Pos(self.zero.0.wrapping_add(at.0.wrapping_sub(self.published.pos.0)));
            self.published.pos = at;
            self.exact = exact(at);
            self.profile.rename(at);
        }
    }

    /// Planned position and encoder both read 0.
    pub(crate) fn zero_position(&mut self) {
        if !self.runs() {
            self.rename(Pos(0));
            self.set_encoder(0);
        }
    }

    /// The encoder reads `pulses` at its present count.
    pub(crate) fn set_encoder(&mut self, pulses: i64) {
        self.inputs.set_encoder(self.count(), pulses);
        self.published.encoder_before =
            self.published.encoder_before.wrapping_add(pulses.wrapping_sub(self.published.encoder));
        self.published.encoder = pulses;
    }
}
