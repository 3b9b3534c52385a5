//! The plan of a channel for one tick: actions at exact instants, which timers carry out.
//!
//! In: the channel's decisions, in the order of time. Out: at most [`PLAN_ACTIONS`] actions whose
//! instants lie inside the interval. Owns nothing else. Fails: [`LaserPlan::has_room`] says
//! beforehand whether it is full.
//!
//! A machine carries out the actions in their order. Those of one instant follow each other there,
//! and come before a period that would begin at it.

/// Actions that a plan holds.
pub const PLAN_ACTIONS: usize = 64;

/// A number of counts of the machine's timer, whole + part/of. A timer reaches it as a mean: it
/// counts once more in `part` of `of` periods ([`super::dither::Pattern`]).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    /// Whole counts.
    pub whole: u64,
    /// Numerator of the remainder, below `of`.
    pub part: u32,
    /// Denominator; 0 stands for 2³².
    pub of: u32,
}

impl Count {
    /// Of the remainder; 1 to 2³².
    #[inline]
    const fn denominator(&self) -> u64 {
        if self.of == 0 { 1 << 32 } else { self.of as u64 }
    }
}

/// A train of pulses: a pulse at the beginning of each period.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Train {
    /// From the beginning of a pulse to that of the next; 0 is no pulses at all.
    pub period: Count,
    /// Width of a pulse; 0 is a period without a pulse, the period or more an unbroken level
    /// ([`Train::is_full`]).
    pub width: Count,
}

impl Train {
    /// No pulses.
    pub const NONE: Train =
        Train { period: Count { whole: 0, part: 0, of: 0 }, width: Count { whole: 0, part: 0, of: 0 } };

    /// Whether there are no pulses, and no periods either.
    #[inline]
    pub const fn is_none(&self) -> bool {
        self.period.whole == 0
    }

    /// Whether there are no pulses.
    #[inline]
    pub const fn is_silent(&self) -> bool {
        self.is_none() || self.width.whole == 0 && self.width.part == 0
    }

    /// Whether it is an unbroken level: no pulse of it ends by itself.
    #[inline]
    pub const fn is_level(&self) -> bool {
        !self.is_none() && self.is_full()
    }

    /// Whether the width reaches the period: an unbroken level. Each pulse is then as long as its
    /// period, wherever the odd counts of the two would lie.
    #[inline]
    pub const fn is_full(&self) -> bool {
        let Train { period, width } = self;
        if width.whole != period.whole {
            return width.whole > period.whole;
        }
        // part·of of the other: below 2³²·2³².
        (width.part as u64).wrapping_mul(period.denominator()) >= (period.part as u64).wrapping_mul(width.denominator())
    }
}

/// Light goes on with pulses at another rate (frequency mode), in phase: the remainder of the
/// period in progress changes in proportion to the period. So the next pulse comes when the
/// integral of the rate since the last one reaches 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PulseRate {
    /// From pulse to pulse, in 2⁻³² counts (its `of` is 0). A whole of 0 is a pause: the remainder
    /// is kept until the next rate.
    pub period: Count,
    /// Width of a pulse, counts.
    pub width: u32,
    /// The period before, or the one before the pause, times scale·2^-shift is this one. 0: there
    /// was none, and the first pulse begins at the action's instant.
    pub scale: u64,
    /// See `scale`; 8 to 119.
    pub shift: u32,
}

impl PulseRate {
    /// No pulses until the next rate.
    pub const PAUSE: PulseRate = PulseRate { period: Train::NONE.period, width: 0, scale: 0, shift: 64 };

    /// Whether it is a pause.
    #[inline]
    pub const fn is_pause(&self) -> bool {
        self.period.whole == 0
    }

    /// The pulses as a train.
    #[inline]
    pub const fn train(&self) -> Train {
        Train { period: self.period, width: Count { whole: self.width as u64, part: 0, of: 1 } }
    }

    /// The remainder of the period in progress at this rate, if `whole` + `part`·2⁻³² counts
    /// remained at the one before. Rounded up, so that a whole count is not missed by one.
    #[inline(never)]
    pub fn left(&self, whole: u64, part: u32) -> (u64, u32) {
        if self.scale == 0 {
            return (0, 0);
        }
        let up = whole.leading_zeros().min(32);
        let fixed = whole.wrapping_shl(up) | (part as u64) >> 32u32.wrapping_sub(up);
        let product = fixed as u128 * self.scale as u128;
        // It is in 2^-down counts; 2^-32 are asked for.
        let down = up.wrapping_add(self.shift);
        if down < 32 {
            // More than 2^40 counts, stretched by more than 2^32.
            return (u64::MAX >> 1, 0);
        }
        let counts = product.wrapping_shr(down.wrapping_sub(32)).wrapping_add(1);
        (((counts >> 32).min((u64::MAX >> 1) as u128)) as u64, counts as u32)
    }
}

/// An event at an instant. PWM, switch and DAC are three outputs: an action changes only its own.
///
/// A train keeps its phase while it goes on. *At its period's end* means: the period in progress
/// runs out first, with its pulse as it is. If the new period is shorter, it runs out where the new
/// one, begun with it, would, but neither before the action's instant nor before its pulse has
/// ended. If no period is in progress, it means at once. A train that begins begins its pattern
/// ([`super::Pattern`]); one that goes on continues it.
// A word for the tag: the data after it is copied in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Action {
    /// The switch output becomes active or inactive.
    Switch(bool),
    /// Light begins: the present train of the PWM ends, and this one begins here with a pulse at
    /// full width.
    Light(Train),
    /// Light, or standby, goes on with this train at its period's end.
    Change(Train),
    /// Light goes on with pulses at this rate. The pulse in progress ends at least a count before
    /// the next one.
    Rate(PulseRate),
    /// Light ends: the pulse in progress ends here; unless `cut`, it is finished if it ends within
    /// [`FINISH_NS`]. At its end, the standby train begins with a pulse at full width.
    Dark {
        /// From then on; [`Train::NONE`] is the safe state.
        standby: Train,
        /// The pulse in progress is cut here in any case.
        cut: bool,
    },
    /// The DAC output, −32768…32767 is −10…10 V. A plan names it only while the laser drives the
    /// DAC, and once more, with 0, when it ceases to.
    Volts(i16),
}

/// A last pulse is finished if it ends within this time of the light's end (SPEC 6).
pub const FINISH_NS: u32 = 100_000;

/// The actions of one tick.
#[derive(Debug, Clone)]
pub struct LaserPlan {
    /// Everything of the channel goes to its safe state *now*, at the call, in the tick in force:
    /// PWM and switch inactive; a DAC whose last [`Action::Volts`] was not 0 goes to 0 V. The
    /// remainder of an earlier plan is void, and there are no actions.
    pub safe_state: bool,
    /// The length of the interval, ns: the actions lie in it.
    pub lasts: u32,
    len: usize,
    /// Offset from the interval's beginning in ns, and what happens there.
    actions: [(u32, Action); PLAN_ACTIONS],
}

impl LaserPlan {
    /// Nothing happens.
    pub const EMPTY: LaserPlan =
        LaserPlan { safe_state: false, lasts: 0, len: 0, actions: [(0, Action::Switch(false)); PLAN_ACTIONS] };

    /// The actions, in the order of time: ns from the interval's beginning, and what happens there.
    #[inline]
    pub fn actions(&self) -> &[(u32, Action)] {
        self.actions.get(..self.len).unwrap_or_default()
    }

    /// Nothing happens.
    #[inline]
    pub(super) fn clear(&mut self) {
        (self.safe_state, self.len) = (false, 0);
    }

    /// Whether there is room for `more` actions.
    #[inline]
    pub(super) fn has_room(&self, more: usize) -> bool {
        self.len.wrapping_add(more) <= PLAN_ACTIONS
    }

    /// The first action of a plan: at its beginning, light goes on with this train.
    #[inline(always)]
    pub(super) fn begin_with(&mut self, train: &Train) {
        let [(at, action), ..] = &mut self.actions;
        match action {
            // Left by the plan of another tick: nearly always this.
            Action::Change(before) => *before = *train,
            _ => *action = Action::Change(*train),
        }
        (*at, self.len) = (0, 1);
    }

    /// One more action, not before the last one, from outside the tick: for tests of machines.
    #[cfg(feature = "plans-by-hand")]
    pub fn add(&mut self, at: u32, action: Action) {
        self.push(at, action);
    }

    /// One more action, not before the last one. If there is no room it is dropped: see
    /// [`LaserPlan::has_room`].
    #[inline(always)]
    pub(super) fn push(&mut self, at: u32, action: Action) {
        if let Some(slot) = self.actions.get_mut(self.len) {
            *slot = (at, action);
            self.len = self.len.wrapping_add(1);
        }
    }
}
