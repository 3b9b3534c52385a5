//! The start of a slave: at once, or where the master crosses the position of PASS.
//!
//! In: intervals of the master's motion, the start event of the axis, the wait in force. Out: the
//! progress at which the motion begins, with the exact instant of the crossing between two ticks.
//! Owns nothing. Cannot fail.
use super::{FollowContext, FollowRun, FollowState, NextPiece, TickEndAction, Wait};
use crate::segment::follow::curve::EXACT_TO_POS_BITS;
use crate::segment::follow::entry::Input;
use crate::segment::follow::master_path::{Section, TimedPosition};
use crate::segment::follow::{FollowEntries, StartEvent};
use crate::units::{FineNs, Ns, Pos};

impl FollowRun {
    /// The tick ends with the master at `to`: a motion starts, SwitchNow acts.
    pub(in crate::segment::follow) fn close<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        now: Ns,
        to: TimedPosition,
        named: i64,
        context: &mut FollowContext<S, L>,
    ) -> Option<FollowState> {
        let mut still = Section::still(now, to);
        if self.wait == Wait::Start {
            match context.setup.event {
                StartEvent::Start => {
                    self.start(to.pos);
                    if let NextPiece::Prepared(prepared) = self.next {
                        self.next = NextPiece::Data;
                        self.enter_prepared(&prepared);
                    } else if let Some(end) = self.catch_up(&mut still, context) {
                        return Some(end);
                    }
                }
                StartEvent::Pass { up, pos } => {
                    self.wait = Wait::Pass { up, at: Pos(Pos::pulses(pos).0.wrapping_add(named)) };
                }
            }
        }
        let goes_on = match self.now.take() {
            None => false,
            Some(TickEndAction::Switch(method)) => self.switch_here(method, to.pos, context),
            Some(TickEndAction::Ratio) => {
                if let Some(ratio) = context.setup.gear {
                    self.gear_to(ratio);
                }
                self.wait == Wait::No
            }
        };
        if goes_on { self.catch_up(&mut still, context) } else { None }
    }

    /// The master moves along a section.
    pub(super) fn advance<S: FollowEntries, L: Fn(Input, u8) -> bool>(
        &mut self,
        section: &Section,
        context: &mut FollowContext<S, L>,
    ) -> Option<FollowState> {
        let mut section = *section;
        match self.wait {
            Wait::Pass { up, at } => {
                let (from, to) = (section.from.pos, section.to.pos);
                let crosses = if up { from < at && to >= at } else { from > at && to <= at };
                if !crosses {
                    return None;
                }
                self.start(at);
                section.from = TimedPosition { after: section.when(at.into()), pos: at };
            }
            Wait::Until(until) => {
                let after = until.saturating_sub(context.base);
                if after > section.to.after as FineNs {
                    return None;
                }
                let exact = section.begin_at(after as u64);
                self.resume(section.from.pos, exact, context);
            }
            Wait::Input { .. } | Wait::Start => return None,
            Wait::No => {}
        }
        self.reach(section.to.pos);
        self.catch_up(&mut section, context)
    }

    /// The motion begins with the master at `pos`.
    fn start(&mut self, pos: Pos) {
        self.wait = Wait::No;
        self.progress = self.directed(pos);
        self.furthest = self.progress;
        self.began = (self.progress as i128) << EXACT_TO_POS_BITS;
        self.remainder = 0;
    }
}
