//! The script clock: when a program's entries are due (SPEC 7).
//!
//! In: the delays of entries, the ticks. Out: whether an entry acts in this tick. Owns: the clock
//! and the count of entries that came late. A late entry acts at once and shifts nothing after it.
//! Work that a tick postponed, because its instant needs more than a tick carries out
//! ([`workload`](super::workload)), is not late.
use crate::units::Ns;

state! {
    /// The program lane's clock; in the order of the view.
    #[derive(Debug, Clone, Copy)]
    #[repr(C)]
    pub(crate) struct ScriptClock {
        /// Controller time at which the clock was zero.
        pub(crate) zero: Ns = Ns(0),
        /// Instant of the last entry executed, on the script clock.
        pub(crate) clock: Ns = Ns(0),
        /// Worst lateness.
        pub(crate) worst_late: Ns = Ns(0),
        /// Entries executed late.
        pub(crate) late: u32 = 0,
        /// Number of the first of them, 0 if there is none.
        pub(crate) first_late: u32 = 0,
        /// Number of the last entry executed when the first tick of the program took too long, 0 if
        /// none has.
        pub(crate) overran: u32 = 0,
        /// A laser command that changes light was late.
        pub(crate) late_light: bool = false,
        /// Whether the lane runs; else it is held.
        pub(crate) runs: bool = false,
        spread: PostponedWork = PostponedWork::None,
    }
    pub(crate) const HELD;
}

/// The instant whose work goes on in another tick than its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PostponedWork {
    /// None.
    None,
    /// That of the entry that comes next.
    Next,
    /// That of the entry executed last.
    Clock,
}

impl ScriptClock {
    /// The clock is zero at the tick in force.
    pub(crate) fn begin(&mut self, now: Ns) {
        *self = ScriptClock { runs: true, zero: now, ..ScriptClock::HELD };
    }

    /// The instant of an entry `delay` after the last one, on the script clock.
    pub(crate) fn instant(&self, delay: Ns) -> Ns {
        Ns(self.clock.0.saturating_add(delay.0))
    }

    /// Whether an entry of that instant acts in the computation of the tick at `next`: the first
    /// tick strictly after the instant.
    pub(crate) fn is_due(&self, instant: Ns, next: Ns) -> bool {
        self.zero.0.saturating_add(instant.0) < next.0
    }

    /// `controller` time on the script clock.
    pub(crate) fn of(&self, controller: Ns) -> Ns {
        Ns(controller.0.saturating_sub(self.zero.0))
    }

    /// The work of an entry of that instant goes on in the tick that comes next, and is not late.
    pub(crate) fn put_off(&mut self, instant: Ns, now: Ns) {
        if !self.was_put_off(instant) {
            let in_time = now.0 <= self.zero.0.saturating_add(instant.0);
            self.spread = if in_time { PostponedWork::Next } else { PostponedWork::None };
        }
    }

    /// Whether work of that instant was postponed before.
    pub(crate) fn was_put_off(&self, instant: Ns) -> bool {
        match self.spread {
            PostponedWork::None => false,
            PostponedWork::Next => true,
            PostponedWork::Clock => self.clock == instant,
        }
    }

    /// An entry of that instant is executed in the tick after `now`. It is late if its instant is
    /// before the tick in force, unless its work was postponed.
    pub(crate) fn execute(&mut self, instant: Ns, now: Ns, seq: u32, lights: bool) {
        let put_off = self.was_put_off(instant);
        self.spread = if put_off { PostponedWork::Clock } else { PostponedWork::None };
        self.clock = instant;
        let late = now.0.saturating_sub(self.zero.0.saturating_add(instant.0));
        if late > 0 && !put_off {
            if self.late == 0 {
                self.first_late = seq;
            }
            self.late = self.late.saturating_add(1);
            self.worst_late = Ns(self.worst_late.0.max(late));
            self.late_light |= lights;
        }
    }

    /// A tick took too long; `done` is the last entry executed.
    pub(crate) fn overrun(&mut self, done: u32) {
        if self.runs && self.overran == 0 {
            self.overran = done;
        }
    }
}
