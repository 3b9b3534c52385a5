//! Edges that are still to come: the gate's, and those of the light behind the FPK.
//!
//! In: commands that take effect at an instant to come. Out: edges, in order. Owns a queue of
//! [`EDGES`] instants; levels alternate, so that an instant says all. Fails: an on command that finds fewer
//! than two places is refused, [`Full`]; its off always has one, so an off command is never lost.
//!
//! The cancel rule of SPEC 6: a command cancels every pending edge at or after its own effect.
use crate::units::Ns;

/// Edges that may be pending: 128 marks inside the longest delay (65 ms).
pub(super) const EDGES: usize = 256;

/// The places are used up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Full;

/// A level, and its pending edges in the order of time.
#[derive(Debug, Clone)]
pub(super) struct Edges {
    level: bool,
    first: usize,
    len: usize,
    at: [Ns; EDGES],
}

impl Edges {
    /// Off, nothing pending.
    pub(super) const OFF: Edges = Edges { level: false, first: 0, len: 0, at: [Ns(0); EDGES] };

    /// The level after the edges taken so far.
    #[inline]
    pub(super) fn level(&self) -> bool {
        self.level
    }

    /// Whether it is on, or will be.
    #[inline]
    pub(super) fn may_be_on(&self) -> bool {
        self.level || self.len > 0
    }

    /// Off at once, nothing pending.
    pub(super) fn clear(&mut self) {
        (self.level, self.len) = (false, 0);
    }

    /// A command that takes effect at `at`.
    pub(super) fn command(&mut self, at: Ns, on: bool) -> Result<(), Full> {
        while self.len > 0 && self.place(self.len.wrapping_sub(1)).is_some_and(|last| *last >= at) {
            self.len = self.len.wrapping_sub(1);
        }
        // The level that the last pending edge leads to.
        let last = self.level ^ (self.len & 1 == 1);
        if last == on {
            return Ok(());
        }
        if on && self.len >= EDGES - 1 {
            return Err(Full);
        }
        let len = self.len;
        if let Some(place) = self.place(len) {
            *place = at;
            self.len = len.wrapping_add(1);
        }
        Ok(())
    }

    /// The next edge, if it comes before `end`.
    #[inline]
    pub(super) fn before(&self, end: Ns) -> Option<Ns> {
        let next = self.at.get(self.first % EDGES).copied()?;
        (self.len > 0 && next < end).then_some(next)
    }

    /// Takes the next edge if it is due at `now`; tells the new level.
    #[inline]
    pub(super) fn take(&mut self, now: Ns) -> Option<bool> {
        self.before(Ns(now.0.wrapping_add(1)))?;
        self.first = self.first.wrapping_add(1) % EDGES;
        self.len = self.len.wrapping_sub(1);
        self.level = !self.level;
        Some(self.level)
    }

    fn place(&mut self, index: usize) -> Option<&mut Ns> {
        self.at.get_mut(self.first.wrapping_add(index) % EDGES)
    }
}

const _: () = assert!(EDGES.is_power_of_two(), "the remainder is a mask");
