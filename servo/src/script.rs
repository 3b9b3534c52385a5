//! The script clock: when a program's entries are due (SPEC 7).
//!
//! In: the delays of entries, the ticks. Out: whether an entry acts in this tick. Owns: the clock and
//! the count of entries that came late. A late entry acts at once and shifts nothing behind it.
use crate::units::Ns;

/// The program lane's clock; in the order of the view.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct Script {
    /// Controller time at which the clock was zero.
    pub(crate) zero: Ns,
    /// Instant of the last entry executed, on the script clock.
    pub(crate) clock: Ns,
    /// Worst lateness.
    pub(crate) worst_late: Ns,
    /// Entries executed late.
    pub(crate) late: u32,
    /// Whether the lane runs; else it is held.
    pub(crate) runs: bool,
}

impl Script {
    pub(crate) const HELD: Script = Script { runs: false, zero: Ns(0), clock: Ns(0), late: 0, worst_late: Ns(0) };

    /// The clock is zero at the tick in force.
    pub(crate) fn begin(&mut self, now: Ns) {
        *self = Script { runs: true, zero: now, ..Script::HELD };
    }

    /// The instant of an entry `delay` behind the last one, on the script clock.
    pub(crate) fn instant(&self, delay: Ns) -> Ns {
        Ns(self.clock.0.saturating_add(delay.0))
    }

    /// Whether an entry of that instant acts in the computation of the tick at `next`: the first tick
    /// strictly after the instant.
    pub(crate) fn is_due(&self, instant: Ns, next: Ns) -> bool {
        self.zero.0.saturating_add(instant.0) < next.0
    }

    /// `controller` time on the script clock.
    pub(crate) fn of(&self, controller: Ns) -> Ns {
        Ns(controller.0.saturating_sub(self.zero.0))
    }

    /// An entry of that instant is executed in the tick after `now`. It is late if an earlier tick
    /// came after its instant, that is, if its instant is before the tick in force.
    pub(crate) fn execute(&mut self, instant: Ns, now: Ns) {
        self.clock = instant;
        let late = now.0.saturating_sub(self.zero.0.saturating_add(instant.0));
        if late > 0 {
            self.late = self.late.saturating_add(1);
            self.worst_late = Ns(self.worst_late.0.max(late));
        }
    }
}
