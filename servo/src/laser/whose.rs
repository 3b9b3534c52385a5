//! Whose light it is, and the light that rest keeps dark (SPEC 6, "Rest").
//!
//! In: on and off commands and who gave them, starts and rests of paths. Out: gate commands that follow from them.
//! Owns: who gave the last on command, and whose light waits for its path to go on. Cannot fail.
//!
//! | state | on by x | off | path k rests by Stop | rests otherwise | k goes on | k begins anew | a follow ends |
//! | --- | --- | --- | --- | --- | --- | --- | --- |
//! | off | x's | off | – | – | – | – | – |
//! | x's | x's | off | k's: off, kept for k | k's: off | – | – | – |
//! | kept for k | x's | forgotten | – | k: forgotten | on, k's | forgotten | forgotten |
//!
//! Light is kept for a FIFO: one that FIFO 1 interrupted comes back with FIFO 0, whatever way FIFO 1 goes in the dark.
use crate::units::Crd;

/// A path that runs one of its FIFOs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) crd: Crd,
    pub(crate) fifo: u8,
}

/// Who lit, and for whom light is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Whose {
    /// The path whose entry gave the on command in force; none of an immediate command, or of no light.
    lit: Option<Run>,
    kept: Option<Run>,
}

impl Whose {
    /// Nobody's.
    pub(super) const NOBODY: Whose = Whose { lit: None, kept: None };

    /// An on or off command of a path, or an immediate one.
    pub(super) fn command(&mut self, on: bool, by: Option<Run>) {
        *self = Whose { lit: by.filter(|_| on), kept: None };
    }

    /// An on command of a path that finds the channel dark: it counts if the path may go on after a Stop of it.
    pub(super) fn command_unseen(&mut self, on: bool, by: Run) {
        self.kept = Some(by).filter(|_| on);
    }

    /// A follow ended or another one took its place: light that is kept stays dark.
    ///
    /// Not where an entry of that very path did so (`by`): it runs, and what keeps its light dark is no rest.
    pub(super) fn forget(&mut self, by: Option<Run>) {
        self.kept = self.kept.filter(|kept| by == Some(*kept));
    }

    /// A path comes to rest; `goes_on`: by a Stop. Whether its light goes off.
    pub(super) fn rest(&mut self, run: Run, goes_on: bool) -> bool {
        let its = self.lit.is_some_and(|lit| lit.crd == run.crd);
        if its {
            self.lit = None;
        }
        if its || self.kept == Some(run) {
            self.kept = Some(run).filter(|_| goes_on);
        }
        its
    }

    /// Whether light waits for this path.
    pub(super) fn keeps(&self, run: Run) -> bool {
        self.kept == Some(run)
    }

    /// A path begins to run; `goes_on`: after a Stop, where it stopped. Whether its light comes back.
    pub(super) fn start(&mut self, run: Run, goes_on: bool) -> bool {
        let its = self.kept == Some(run);
        if its {
            self.kept = None;
            self.lit = Some(run).filter(|_| goes_on);
        }
        its && goes_on
    }

    /// The light is out by something that its path may go on after: it waits for that.
    pub(super) fn interrupt(&mut self) {
        if let Some(run) = self.lit.take() {
            self.kept = Some(run);
        }
    }
}
