//! The first-pulse killer: a pulse of the switch output before the energy begins.
//!
//! In: edges of the gate that are due, [`Fpk`]. Out: the end of the pulse on the switch output; the
//! edges of the light, shifted by `begin` and `end`. Owns nothing: pulse and tail of the mark in
//! progress are in [`Channel`]. Fails: light that its queue has no slots for makes the channel
//! dark.
//!
//! While the killer is enabled the switch output shows its pulse, not the gate
//! (`Channel::update_outputs`).
use super::Channel;
use super::gate_delays::later;
use crate::laser::NEVER;
use crate::units::Ns;
use core::num::NonZeroU16;

/// First-pulse killer, µs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fpk {
    /// Length of the pulse on the switch output (time1).
    pub pulse: NonZeroU16,
    /// From the gate-on edge to the light (time2).
    pub begin: u16,
    /// From the gate-off edge to the light's end (laserOffDelay).
    pub end: u16,
}

impl Channel {
    /// Takes the edges that are due.
    pub(super) fn take(&mut self, now: Ns) {
        while self.gate.next <= now {
            self.edge(now);
        }
        if self.pulse <= now {
            self.pulse = NEVER;
        }
        while self.light.next <= now {
            self.light.take();
        }
    }

    /// The gate edge that is due.
    pub(super) fn edge(&mut self, now: Ns) {
        let done = if self.gate.take() {
            let (begin, end) = self.fpk.map_or((0, 0), |fpk| (fpk.begin, fpk.end));
            self.tail = end;
            if let Some(fpk) = self.fpk {
                self.pulse = later(now, fpk.pulse.get());
            }
            self.light.command(later(now, begin), true)
        } else {
            self.light.command(later(now, self.tail), false)
        };
        self.hold(done);
    }
}
