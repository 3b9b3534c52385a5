//! The judge's state of a channel and of a coordinate system.
//!
//! In: the results of the rules. Out: the state for the next rule, and a channel's gate commands
//! when it is shut off at once.
use super::super::Ns;
use super::super::gate::{Gate, Level};
use super::Verdict;

/// Who lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owner {
    Call,
    Crd(usize),
    /// A call or one of these: it is open.
    Open(u8),
}

/// The commanded state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Commanded {
    Off,
    On(Owner),
    Doubt,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Maybe {
    No,
    Doubt,
    Yes,
}

/// Light that a lost link took: it returns when the fault is cleared and then each of these has
/// continued.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lost {
    pub(super) crds: u8,
    /// With which FIFOs they go on.
    pub(super) fifos: [usize; 2],
    pub(super) owner: Option<Owner>,
    pub(super) cleared: bool,
    pub(super) doubt: bool,
}

impl Lost {
    /// Another loss, which stops these.
    pub(super) fn waits_for(&mut self, crds: u8, fifos: [usize; 2]) {
        for crd in members(crds & !self.crds) {
            self.fifos[crd] = fifos[crd];
        }
        self.crds |= crds;
        self.cleared = false;
    }
}

#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub(super) map: u8,
    pub(super) connector: bool,
    pub(super) commanded: Commanded,
    /// FIFOs whose Stop keeps the light dark, of each coordinate system.
    pub(super) kept: [Option<usize>; 2],
    /// Whether the kept light returns is open.
    pub(super) kept_doubt: bool,
    /// An immediate off, and no on command since.
    pub(super) veto: Maybe,
    pub(super) follow: Option<usize>,
    /// Which path the power follows, if any, is open.
    pub(super) follow_open: bool,
    /// When a Stop ended the follow under which light waited, and nothing was commanded since.
    pub(super) withdrawn: Option<Ns>,
    /// The map before, and until when a cause may have met it.
    pub(super) old_map: (u8, Ns),
    pub(super) fault: Maybe,
    pub(super) fault_since: Ns,
    /// Until when a clear that was made late may still act.
    pub(super) clears_until: Ns,
    pub(super) lost: Option<Lost>,
    /// Nothing is output at all until the next laser command.
    pub(super) quiet: bool,
    /// Since when nothing at all may be output.
    pub(super) safe_since: Option<Ns>,
    pub(super) level: Level,
    /// Of the gate, on and off.
    pub(super) delays: (Ns, Ns),
    pub(super) verdict: Verdict,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Crd {
    pub(super) runs: bool,
    pub(super) fifo: usize,
    /// A Stop that it has not finished.
    pub(super) stopping: bool,
    /// FIFOs that CrdStart continues.
    pub(super) resumable: [bool; 2],
    /// Its on entries do nothing until it is at standstill.
    pub(super) dead: Maybe,
    /// It ran when an abort came: on commands are refused until it is at standstill.
    pub(super) aborted: Maybe,
}

pub(super) fn set(crd: usize) -> u8 {
    1 << crd
}

pub(super) fn members(crds: u8) -> impl Iterator<Item = usize> {
    (0..2).filter(move |crd| crds & set(*crd) != 0)
}

impl Channel {
    /// Switched off: no light returns.
    pub(super) fn off(&mut self) {
        self.commanded = Commanded::Off;
        (self.kept, self.kept_doubt, self.lost) = ([None; 2], false, None);
        self.withdrawn = None;
    }

    /// A laser command came.
    pub(super) fn mark_changed(&mut self) {
        self.quiet = false;
        self.withdrawn = None;
    }

    /// Dark at once, for good.
    pub(super) fn cut(&mut self, (lo, hi): (Ns, Ns)) {
        self.off();
        self.level = Level::Off;
        self.verdict.gates.push(Gate { lo, hi, level: Level::Off, cut: true, delays: self.delays });
    }

    /// Perhaps dark at once, and a fault.
    pub(super) fn perhaps_cut(&mut self, (lo, _): (Ns, Ns)) {
        self.verdict.gates.push(Gate { lo, hi: Ns::MAX / 4, level: Level::Off, cut: true, delays: self.delays });
        if self.fault == Maybe::No {
            (self.fault, self.fault_since) = (Maybe::Doubt, lo);
        }
        if !self.quiet && self.commanded != Commanded::Off {
            self.off();
            self.commanded = Commanded::Doubt;
        }
    }

    /// What hangs on these coordinate systems is open.
    pub(super) fn doubt(&mut self, crds: u8) {
        let kept = members(crds).any(|crd| self.kept[crd].is_some());
        let lost = self.lost.is_some_and(|lost| lost.crds & crds != 0);
        let follows = self.follow.is_some_and(|crd| crds & set(crd) != 0);
        // After an abort nothing can be on before the next laser command.
        if !self.quiet && (self.map & crds != 0 || follows || kept || lost) {
            self.off();
            self.commanded = Commanded::Doubt;
        }
    }
}
