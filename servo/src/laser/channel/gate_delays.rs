//! The on delay and the off delay of the gate.
//!
//! In: commands of the light owner, [`Delays`]. Out: edges of the gate, at their instants, in its
//! queue (`edge_queue.rs`). Owns nothing. Fails: an on command that the queue has no slots for
//! makes the channel dark.
use super::Channel;
use crate::laser::edge_queue::Full;
use crate::laser::safety::Cause;
use crate::units::Ns;

/// Delays of the gate, µs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Delays {
    /// From an off command to its edge.
    pub off: u16,
    /// From an on command to its edge.
    pub on: u16,
}

impl Channel {
    /// A gate command.
    pub(super) fn switch(&mut self, at: Ns, on: bool) {
        let us = match (self.delayed, on) {
            (false, _) => 0,
            (true, true) => self.delays.on,
            (true, false) => self.delays.off,
        };
        let done = self.gate.command(later(at, us), on);
        self.hold(done);
    }

    /// A refused on command makes the channel dark: a mark would be missing.
    pub(super) fn hold(&mut self, done: Result<(), Full>) {
        if done.is_err() {
            self.trip(Cause::Edges);
        }
    }
}

/// An instant `us` µs later.
#[inline]
pub(super) fn later(at: Ns, us: u16) -> Ns {
    Ns(at.0.wrapping_add((us as u32).wrapping_mul(1000) as u64))
}
