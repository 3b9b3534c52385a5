//! One endpoint of the USB core: its control register and its FIFO.
//!
//! In: writes of its registers. Out: their content. Owns the endpoint's state and FIFO. Cannot
//! fail.
use super::{CNAK, EPDIS, EPDISD, EPENA, KEPT, NAKSTS, SD0PID, SNAK};
use std::collections::VecDeque;

#[derive(Debug, Clone, Default)]
pub(super) struct Endpoint {
    pub(super) control: u32,
    pub(super) enabled: bool,
    pub(super) nak: bool,
    /// The next packet is DATA1.
    pub(super) odd: bool,
    pub(super) size: u32,
    pub(super) flags: u32,
    pub(super) fifo: VecDeque<u32>,
    /// DIEPTXF.
    pub(super) place: u32,
}

impl Endpoint {
    pub(super) fn read(&self) -> u32 {
        let bit = |on: bool, bit: u32| if on { bit } else { 0 };
        self.control | bit(self.odd, 1 << 16) | bit(self.nak, NAKSTS) | bit(self.enabled, EPENA)
    }

    pub(super) fn write(&mut self, value: u32) {
        self.control = value & KEPT;
        if value & CNAK != 0 {
            self.nak = false;
        }
        if value & SNAK != 0 {
            self.nak = true;
        }
        if value & SD0PID != 0 {
            self.odd = false;
        }
        // Both can be set only.
        self.enabled |= value & EPENA != 0;
        if value & EPDIS != 0 && self.enabled {
            self.enabled = false;
            self.flags |= EPDISD;
        }
    }

    pub(super) fn room(&self) -> u32 {
        (self.place >> 16).saturating_sub(self.fifo.len() as u32)
    }
}
