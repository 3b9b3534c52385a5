//! The script clock of what is admitted.
//!
//! In: the entries that are pushed, Sleeps, views of the running program. Out: the instant of the
//! record in hand. Owns: the accumulated delay, the WaitStops in flight.
use super::waits::Pauses;
use crate::shadow::ShadowChange;
use servo::tick_command::TickCommand;
use servo::view::View;

/// See the module text.
#[derive(Debug, Default)]
pub(super) struct ScriptShadow {
    /// Script time since the last entry pushed, ns.
    pub delay: u64,
    /// The earliest script clock of the last entry pushed, ns. The time that a WaitStop takes is
    /// added once it is over.
    pushed: u64,
    /// WaitStops in flight.
    pub pauses: Pauses,
    /// The script clock in the last view in which the program ran, ns.
    pub clock: u64,
}

impl ScriptShadow {
    /// A program begins, or what it had pushed is over: its next entry is the first of its clock.
    pub fn begin(&mut self) {
        (self.delay, self.pushed) = (0, 0);
    }

    /// The same; nothing is in flight.
    pub fn forget(&mut self) {
        self.begin();
        self.pauses = Pauses::default();
    }

    /// The script clock of the record in hand, ns, if the WaitStops in flight take no time.
    pub fn instant(&self) -> u64 {
        self.pushed.saturating_add(self.delay)
    }

    /// The same in the controller's time, if the script clock was zero at `zero`.
    pub fn instant_from(&self, zero: u64) -> u64 {
        zero.saturating_add(self.pushed).saturating_add(self.delay)
    }

    /// The record's instant after what the view shows as executed, controller time.
    pub fn instant_after<const AXES: usize>(&self, view: &View<AXES>) -> u64 {
        view.script_zero.0.saturating_add(view.script.0).saturating_add(self.delay)
    }

    /// The record in hand comes after its instant: it acts so long after the view, and the clock
    /// goes on from there.
    pub fn catch_up<const AXES: usize>(&mut self, view: &View<AXES>, lead_ns: u64) {
        let clock = view.now.0.saturating_sub(view.script_zero.0).saturating_add(lead_ns);
        self.delay = self.delay.max(clock.saturating_sub(self.pushed));
    }

    /// An entry has been pushed with the delay.
    pub fn push(&mut self, command: &TickCommand, seq: u32) {
        self.pushed = self.instant();
        self.pauses.push(command, seq, self.pushed);
        self.delay = 0;
    }

    /// A view of the running program. `changes` are those of the entries that it does not show as
    /// executed.
    pub fn see<'c, const AXES: usize, I: Iterator<Item = &'c (u32, ShadowChange)>>(
        &mut self,
        view: &View<AXES>,
        changes: impl Fn() -> I,
    ) {
        self.clock = view.now.0.saturating_sub(view.script_zero.0);
        self.pushed = self.pauses.resolve(view, self.pushed, changes);
    }
}
