//! WaitStops in flight: what is known of the instants after them.
//!
//! In: the entries that are pushed, the view. Out: the script clock of the last one, and whether
//! that is its instant.
//! A WaitStop takes a time that only the tick knows. It is known once the view shows its end, which
//! is before its execution. No more WaitStops are in flight than are kept here.
use crate::shadow::{ShadowChange, executed, renew};
use heapless::Deque;
use servo::status::RUNNING;
use servo::tick_command::TickCommand;
use servo::units::AxisMask;
use servo::view::{AxisView, CrdView, View};

/// WaitStops that are kept.
const WAITS_KEPT: usize = 3;

#[derive(Debug, Clone, Copy)]
struct PendingWaitStop {
    seq: u32,
    /// The first entry of a later instant; 0 is none: numbers of this lane have a flag.
    later: u32,
    /// Script clock at which it begins, ns, if those before it take no time.
    instant: u64,
}

/// See the module text.
#[derive(Debug, Default)]
pub(super) struct Pauses {
    /// Those whose end is not known yet.
    kept: Deque<PendingWaitStop, WAITS_KEPT>,
    /// The last one pushed.
    pub last: Option<u32>,
}

impl Pauses {
    /// Whether one is in flight: then the instants of the program are later than stated.
    pub fn wait(&self) -> bool {
        !self.kept.is_empty()
    }

    /// Whether another one has to wait for one of these.
    pub fn is_full(&self) -> bool {
        self.kept.is_full()
    }

    /// An entry has been pushed at this script clock.
    pub fn push(&mut self, command: &TickCommand, seq: u32, instant: u64) {
        for pause in &mut self.kept {
            if pause.later == 0 && instant != pause.instant {
                pause.later = seq;
            }
        }
        if let TickCommand::WaitStandstill { .. } = command {
            self.last = Some(seq);
            // No more than fit are in flight.
            self.kept.push_back(PendingWaitStop { seq, later: 0, instant }).ok();
        }
    }

    /// The script clock of the last entry pushed, as far as the view shows it; it was `instant`
    /// before the view. `changes` are those of the entries that were not executed then.
    pub fn resolve<'c, const AXES: usize, I: Iterator<Item = &'c (u32, ShadowChange)>>(
        &mut self,
        view: &View<AXES>,
        mut instant: u64,
        changes: impl Fn() -> I,
    ) -> u64 {
        while let Some(&pause) = self.kept.front() {
            let end = if is_over(view, &pause, changes()) {
                // Else it would have been executed on the tick before.
                pause.instant.max(view.now.0.saturating_sub(view.script_zero.0))
            } else if !executed(view, pause.seq) {
                break;
            } else if self.kept.iter().nth(1).is_some_and(|next| executed(view, next.seq)) {
                pause.instant
            } else if pause.later == 0 || !executed(view, pause.later) {
                // The clock that the view shows is that of its end.
                view.script.0
            } else {
                break;
            };
            let took = end.saturating_sub(pause.instant);
            instant = instant.saturating_add(took);
            self.kept.pop_front();
            for pause in &mut self.kept {
                pause.instant = pause.instant.saturating_add(took);
            }
        }
        if changes().next().is_none() {
            self.kept.clear();
        }
        instant.max(view.script.0)
    }

    /// Renews the numbers of what was executed.
    pub fn renew<const AXES: usize>(&mut self, view: &View<AXES>) {
        for pause in &mut self.kept {
            renew(view, &mut pause.seq);
            if pause.later != 0 {
                renew(view, &mut pause.later);
            }
        }
        self.last.iter_mut().for_each(|seq| renew(view, seq));
    }
}

/// Whether it ends on the tick after the view.
fn is_over<'c, const AXES: usize>(
    view: &View<AXES>,
    pause: &PendingWaitStop,
    changes: impl Iterator<Item = &'c (u32, ShadowChange)>,
) -> bool {
    if view.script_zero.0.saturating_add(pause.instant) >= view.now.0.saturating_add(view.period.0) {
        return false;
    }
    let mut begin = AxisMask(0);
    for (seq, change) in changes {
        match *change {
            ShadowChange::Standstill { axes, crds } if *seq == pause.seq => {
                let axis = |(index, axis): (usize, &AxisView)| {
                    axes.0.checked_shr(index as u32).unwrap_or(0) & 1 == 1 && axis.status & RUNNING != 0
                };
                let crd = |(index, crd): (usize, &CrdView)| crds.0 >> (index & 7) & 1 == 1 && crd.runs;
                let begins = begin.0 & axes.0 != 0;
                return !begins && !view.axes.iter().enumerate().any(axis) && !view.crds.iter().enumerate().any(crd);
            }
            // What another axis begins is none of its time.
            ShadowChange::Started { axes, .. } | ShadowChange::PvtStarted { axes } => begin.0 |= axes.0,
            ShadowChange::CrdStarted { .. } => return false,
            _ => {}
        }
    }
    false
}
