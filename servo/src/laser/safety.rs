//! The state machine through which every laser output passes last (SPEC 9).
//!
//! In: causes, as the tick finds them; requests to clear. Out: [`Safety::guard`] lets a plan pass,
//! or replaces it by the safe state. Owns the latch. Fails: towards the dark.
//!
//! | state | cause appears | clear, no cause present | clear, a cause present |
//! | --- | --- | --- | --- |
//! | live: plans pass | dark, for this cause | live | live until it is seen, then dark |
//! | dark: everything rests | dark, for the first cause | live | dark |
//! | dark, but no plan has rested yet | dark, for the first cause | dark | dark |
//! | dark from within a plan on | dark at once | dark | dark |
//!
//! A Reset clears in every state, once no cause is present. An abort replaces one plan by the safe
//! state, in any state, and latches nothing.
//!
//! A cause within the interval that is being planned (an underrun) lets two plans pass: that one,
//! which goes dark by itself, and the empty one that is handed over before that instant. A clear
//! that acts on the same tick in which a cause appears cannot have meant it, and does not hide it.
use super::actions::LaserPlan;

/// Why a channel is dark until it is cleared. The numbers are those that `GetLaserFault` reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Cause {
    /// It is not.
    #[default]
    None = 0,
    /// The interlock or emergency-stop input.
    Interlock = 1,
    /// The host link was lost while light was on or might have come.
    LinkLost = 2,
    /// A servo tick began late.
    Overrun = 3,
    /// A panic, a fault or the watchdog ended the run before.
    Restart = 4,
    /// More gate edges than the channel can keep or place.
    Edges = 5,
    /// The drive alarm of an axis of a mapped coordinate system.
    Alarm = 6,
    /// The servo of an axis of a mapped coordinate system was switched off.
    ServoOff = 7,
    /// An axis of a mapped coordinate system hit a limit.
    Limit = 8,
    /// A mapped coordinate system ran out of entries at speed.
    Underrun = 9,
    /// Another fault of a mapped coordinate system: following error, edge of travel.
    Fault = 10,
}

/// The latch of a channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Safety {
    /// [`Cause::None`] while it is live.
    dark: Cause,
    /// A plan was replaced by the safe state since it is dark.
    was_safe: bool,
    interlock: bool,
    link_lost: bool,
    alarm: bool,
    /// Grace: plans that still pass although it is dark. They are the one in which it goes dark by
    /// itself, and the empty one that is handed over before that instant. [`SAFE_NEXT`]: the next
    /// plan is replaced by the safe state, whatever is latched.
    grace: u8,
}

/// For an abort: instead of plans of grace.
const SAFE_NEXT: u8 = u8::MAX;

impl Safety {
    pub(super) const LIVE: Safety =
        Safety { dark: Cause::None, was_safe: false, interlock: false, link_lost: false, alarm: false, grace: 0 };

    /// Why it is dark.
    #[inline]
    pub(super) fn cause(&self) -> Cause {
        self.dark
    }

    /// Whether plans are replaced by the safe state.
    #[inline]
    pub(super) fn is_dark(&self) -> bool {
        self.dark != Cause::None
    }

    /// Whether a cause is present that does not pass by itself.
    #[inline]
    pub(super) fn lasts(&self) -> bool {
        self.interlock || self.link_lost || self.alarm
    }

    /// The interlock's level now. Returns whether that changes anything.
    #[inline]
    pub(super) fn interlock(&mut self, active: bool) -> bool {
        let changes = self.interlock != active;
        self.interlock = active;
        changes
    }

    /// The link's state now.
    pub(super) fn link(&mut self, lost: bool) {
        self.link_lost = lost;
    }

    /// Whether a mapped coordinate system has an alarm now; true if it had none before.
    pub(super) fn alarm(&mut self, active: bool) -> bool {
        let begins = active && !self.alarm;
        self.alarm = active;
        begins
    }

    /// A cause has appeared. The first one is kept.
    pub(super) fn trip(&mut self, cause: Cause) {
        if !self.is_dark() {
            (self.dark, self.was_safe) = (cause, false);
        }
        if !self.is_safe() {
            self.grace = 0;
        }
    }

    /// A cause appears at an instant of the interval that is being planned. Returns whether its
    /// plan goes dark there by itself. It does not if it is dark from its beginning.
    pub(super) fn trip_within(&mut self, cause: Cause) -> bool {
        if self.is_dark() {
            return false;
        }
        let within = !self.is_safe();
        self.trip(cause);
        if within {
            self.grace = 2;
        }
        within
    }

    /// Reset: live again, if no cause is present. The next plan is replaced by the safe state, as
    /// perhaps none was.
    pub(super) fn reset(&mut self) {
        if self.is_dark() {
            self.force_safe_state();
        }
        if !self.lasts() {
            self.dark = Cause::None;
        }
    }

    /// The next plan is the safe state at the call, whatever it holds.
    pub(super) fn force_safe_state(&mut self) {
        self.grace = SAFE_NEXT;
    }

    /// Whether the next plan is.
    #[inline(always)]
    pub(super) fn is_safe(&self) -> bool {
        self.grace == SAFE_NEXT
    }

    /// Whether the plan that was made last went dark by itself.
    pub(super) fn in_grace(&self) -> bool {
        self.grace != 0 && !self.is_safe()
    }

    /// Live again, if no cause is present and the outputs were in the safe state.
    pub(super) fn clear(&mut self) {
        if self.was_safe && !self.lasts() {
            self.dark = Cause::None;
        }
    }

    /// The last check of a plan.
    #[inline(always)]
    pub(super) fn guard(&mut self, plan: &mut LaserPlan) {
        if self.grace | self.dark as u8 != 0 {
            self.shut_off(plan);
        }
    }

    /// The same while it is dark.
    #[inline(never)]
    fn shut_off(&mut self, plan: &mut LaserPlan) {
        if self.in_grace() {
            self.grace = self.grace.wrapping_sub(1);
        } else if self.is_dark() || self.is_safe() {
            (self.was_safe, self.grace) = (true, 0);
            plan.clear();
            plan.safe_state = true;
        }
    }
}
