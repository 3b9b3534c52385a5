//! The limits of an axis: soft limits, limit switches, the edge of travel. What they do to a
//! position or a motion.
//!
//! In: limits in [`Inputs`], active switches, the position in force and the one that a motion is
//! about to reach. Out: whether the axis may go there; where it is held, and why. Owns the
//! [`TravelBounds`] in which no limit is near. Cannot fail: a motion that meets a limit stops
//! there.
//!
//! The soft limits of a path are those of its axes: `tick/crd/path_soft_limits.rs`.
use super::inputs::Inputs;
use super::{AxisState, NEGATIVE_EDGE};
use crate::status;
use crate::units::{Ns, Pos};
use crate::view::StopReason;

impl Inputs {
    /// The limits that the planned position is beyond, as status bits.
    #[inline]
    pub(crate) fn beyond(&self, pos: Pos) -> u32 {
        let mut causes = 0;
        if self.soft_positive.is_some_and(|limit| pos > Pos::pulses(limit)) {
            causes |= status::LIMIT_POSITIVE;
        }
        if self.soft_negative.is_some_and(|limit| pos < Pos::pulses(limit)) {
            causes |= status::LIMIT_NEGATIVE;
        }
        causes
    }
}

/// The range in which no limit is in the way.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(super) struct TravelBounds {
    lower: Pos,
    upper: Pos,
    /// Well between them: the first high word of such positions, and how many there are.
    inside: (i32, u32),
}

impl TravelBounds {
    pub(super) const TRAVEL: TravelBounds = TravelBounds::new(NEGATIVE_EDGE, Pos::TRAVEL);

    const fn new(lower: Pos, upper: Pos) -> TravelBounds {
        let from = (lower.0 >> 32).saturating_add(1);
        let count = (upper.0 >> 32).saturating_sub(from);
        TravelBounds { lower, upper, inside: (from as i32, if count < 0 { 0 } else { count as u32 }) }
    }

    /// Whether they hold a position.
    #[inline(always)]
    pub(super) fn hold(&self, pos: Pos) -> bool {
        pos >= self.lower && pos <= self.upper
    }

    /// Whether they hold all positions near it, too.
    #[inline(always)]
    pub(super) fn is_well_inside(&self, pos: Pos) -> bool {
        let (from, count) = self.inside;
        (((pos.0 >> 32) as i32).wrapping_sub(from) as u32) < count
    }
}

impl AxisState {
    /// Sets the range in which the planned position may move without further checks. An active
    /// switch forbids one direction only, so then all positions need the check.
    pub(crate) fn set_bounds(&mut self) {
        let Inputs { soft_positive, soft_negative, .. } = &self.inputs;
        let mut upper = soft_positive.map_or(Pos::TRAVEL, Pos::pulses);
        let mut lower = soft_negative.map_or(NEGATIVE_EDGE, Pos::pulses);
        if self.causes.switches & status::LIMIT_POSITIVE != 0 {
            upper = Pos(i64::MIN);
        }
        if self.causes.switches & status::LIMIT_NEGATIVE != 0 {
            lower = Pos(i64::MAX);
        }
        self.bounds = TravelBounds::new(lower, upper);
    }

    /// The limit that lies between two positions: where it holds the axis, and the stop reason.
    pub(super) fn barrier(&self, from: Pos, to: Pos) -> Option<(Pos, StopReason)> {
        let inputs = &self.inputs;
        if to > from {
            if self.causes.switches & status::LIMIT_POSITIVE != 0 {
                return Some((from, StopReason::LimitPositive));
            }
            if let Some(soft) = inputs.soft_positive.map(Pos::pulses)
                && to > soft
            {
                return Some((from.max(soft), StopReason::SoftPositive));
            }
            if to > Pos::TRAVEL {
                return Some((Pos::TRAVEL, StopReason::Travel));
            }
        } else if to < from {
            if self.causes.switches & status::LIMIT_NEGATIVE != 0 {
                return Some((from, StopReason::LimitNegative));
            }
            if let Some(soft) = inputs.soft_negative.map(Pos::pulses)
                && to < soft
            {
                return Some((from.min(soft), StopReason::SoftNegative));
            }
            if to < NEGATIVE_EDGE {
                return Some((NEGATIVE_EDGE, StopReason::Travel));
            }
        }
        None
    }

    /// Whether a limit lies between the position in force and `to`: then the axis has stopped
    /// there.
    #[inline(never)]
    pub(super) fn stopped_at_barrier(&mut self, next: Ns, to: Pos) -> Option<StopReason> {
        let (at, reason) = self.barrier(self.published.pos, to)?;
        self.published.pos = at;
        Some(self.stopped_by(next, reason))
    }

    /// A limit that stops a motion blocks further ones.
    pub(super) fn latch_limit(&mut self, reason: StopReason) {
        let limit = match reason {
            StopReason::LimitPositive | StopReason::SoftPositive => status::LIMIT_POSITIVE,
            StopReason::LimitNegative | StopReason::SoftNegative => status::LIMIT_NEGATIVE,
            _ => 0,
        };
        self.causes.latched |= limit;
        self.block(self.published.blocked | limit);
    }

    /// Whether it may be driven to `to` without further checks.
    #[inline(always)]
    pub(crate) fn is_free(&self, to: Pos) -> bool {
        self.causes.present & status::FAULTS == 0 && (self.bounds.is_well_inside(to) || self.is_between(to))
    }

    /// Whether it may be driven to `to` and to all positions near it, until a limit or fault
    /// changes.
    pub(crate) fn is_clear(&self, to: Pos) -> bool {
        self.bounds.is_well_inside(to) && self.causes.present & status::FAULTS == 0
    }

    /// The same for a position near the ends of the range.
    #[cold]
    #[inline(never)]
    fn is_between(&self, to: Pos) -> bool {
        self.bounds.hold(to)
    }

    /// Whether no limit lies between the position in force and `to`.
    #[inline(always)]
    pub(crate) fn admits(&self, to: Pos) -> bool {
        self.bounds.hold(to) || self.barrier(self.published.pos, to).is_none()
    }

    /// Latches the limit that lies there.
    pub(crate) fn latch_barrier(&mut self, to: Pos) -> Option<StopReason> {
        let (_, reason) = self.barrier(self.published.pos, to)?;
        self.latch_limit(reason);
        Some(reason)
    }
}
