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
use crate::units::Crd;

/// Who lit, and for whom light is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Whose {
    /// The path whose entry gave the on command in force; none of an immediate command, or of no light.
    lit: Option<Crd>,
    kept: Option<Crd>,
}

impl Whose {
    /// Nobody's.
    pub(super) const NOBODY: Whose = Whose { lit: None, kept: None };

    /// An on or off command of a path, or an immediate one.
    pub(super) fn command(&mut self, on: bool, by: Option<Crd>) {
        *self = Whose { lit: by.filter(|_| on), kept: None };
    }

    /// An on command of a path that finds the channel dark: it counts if the path may go on after a Stop of it.
    pub(super) fn command_unseen(&mut self, on: bool, by: Crd) {
        self.kept = Some(by).filter(|_| on);
    }

    /// A follow ended or another one took its place: light that is kept stays dark.
    ///
    /// Not where an entry of that very path did so (`by`): it runs, and what keeps its light dark is no rest.
    pub(super) fn forget(&mut self, by: Option<Crd>) {
        self.kept = self.kept.filter(|kept| by == Some(*kept));
    }

    /// A path comes to rest; `goes_on`: by a Stop. Whether its light goes off.
    pub(super) fn rest(&mut self, crd: Crd, goes_on: bool) -> bool {
        let its = self.lit == Some(crd);
        if its {
            self.lit = None;
        }
        if its || self.kept == Some(crd) {
            self.kept = Some(crd).filter(|_| goes_on);
        }
        its
    }

    /// Whether light waits for this path.
    pub(super) fn keeps(&self, crd: Crd) -> bool {
        self.kept == Some(crd)
    }

    /// A path begins to run; `goes_on`: after a Stop, where it stopped. Whether its light comes back.
    pub(super) fn start(&mut self, crd: Crd, goes_on: bool) -> bool {
        let its = self.kept == Some(crd);
        if its {
            self.kept = None;
            self.lit = Some(crd).filter(|_| goes_on);
        }
        its && goes_on
    }

    /// The light is out by something that its path may go on after: it waits for that.
    pub(super) fn interrupt(&mut self) {
        if let Some(crd) = self.lit.take() {
            self.kept = Some(crd);
        }
    }
}
