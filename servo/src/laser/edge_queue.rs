//! Pending edges, in a queue: those of the gate, and those of the light after the first-pulse
//! killer.
//!
//! In: commands that take effect at a later instant. Out: edges, in order. Owns a queue of
//! [`GATE_EDGES`] instants; levels alternate, so that an instant is enough. Fails: an on command
//! that finds fewer than two slots is refused, [`Full`]; its off always has one, so an off command
//! is never lost.
//!
//! The cancel rule of SPEC 6: a command cancels every pending edge at or after its own effect.
use super::NEVER;
use crate::units::Ns;

pub(super) use crate::capacity::GATE_EDGES;

/// No slots left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Full;

/// A level, and its pending edges in the order of time.
#[derive(Debug, Clone)]
#[repr(C)]
pub(super) struct EdgeQueue {
    /// After the edges taken so far.
    pub(super) level: bool,
    /// The next edge, or [`NEVER`].
    pub(super) next: Ns,
    first: usize,
    len: usize,
    at: [Ns; GATE_EDGES],
}

impl EdgeQueue {
    /// Off, nothing pending.
    pub(super) const OFF: EdgeQueue =
        EdgeQueue { level: false, next: NEVER, first: 0, len: 0, at: [Ns(0); GATE_EDGES] };

    /// Whether it is on, or will be.
    #[inline]
    pub(super) fn may_be_on(&self) -> bool {
        self.level || self.len > 0
    }

    /// Off at once, nothing pending.
    pub(super) fn clear(&mut self) {
        (self.level, self.len, self.next) = (false, 0, NEVER);
    }

    /// A command that takes effect at `at`.
    pub(super) fn command(&mut self, at: Ns, on: bool) -> Result<(), Full> {
        while self.len > 0 && self.slot(self.len.wrapping_sub(1)).is_some_and(|last| *last >= at) {
            self.len = self.len.wrapping_sub(1);
        }
        // The level that the last pending edge leads to.
        let last = self.level ^ (self.len & 1 == 1);
        let fits = last == on || !on || self.len < GATE_EDGES - 1;
        if last != on && fits {
            let len = self.len;
            if let Some(slot) = self.slot(len) {
                *slot = at;
                self.len = len.wrapping_add(1);
            }
        }
        self.look();
        if fits { Ok(()) } else { Err(Full) }
    }

    /// Takes the next edge, which is due; returns the new level.
    #[inline]
    pub(super) fn take(&mut self) -> bool {
        self.first = self.first.wrapping_add(1) % GATE_EDGES;
        self.len = self.len.saturating_sub(1);
        self.look();
        self.level = !self.level;
        self.level
    }

    #[inline]
    fn look(&mut self) {
        let pending = self.len > 0;
        self.next = self.slot(0).map_or(NEVER, |next| if pending { *next } else { NEVER });
    }

    #[inline]
    fn slot(&mut self, index: usize) -> Option<&mut Ns> {
        self.at.get_mut(self.first.wrapping_add(index) % GATE_EDGES)
    }
}

const _: () = assert!(GATE_EDGES.is_power_of_two(), "the remainder is a mask");
