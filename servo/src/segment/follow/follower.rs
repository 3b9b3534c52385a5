//! A slave and its master's position in every tick.
//!
//! In: the master in the tick computed. Out: the slave's position, and its own motion within the
//! tick for its slaves. Owns: the [`FollowRun`], the filter, the master's position one tick ago. It
//! cannot fail.
//!
//! A master's position is that of the machine, which no SetPrfPos or ZeroPos of the master changes.
//! An encoder has the sample of the tick in force at the end of the tick, and that of the tick
//! before at its beginning. The filter is a lag of first order with a time constant of 2²² ns (4.19
//! ms), started at the master's position. Its output is exact for a master that moves evenly
//! between ticks, so the lag does not depend on the tick period.
use super::evaluator::{FollowContext, FollowRun, FollowState};
use super::master_path::{MasterPath, PositionTrack, Section, TimedPosition, is_plain};
use super::{FollowEntries, Input, Master};
use crate::math::wide::umulhi;
use crate::segment::piece::Piece;
use crate::status::StopReason;
use crate::units::{Ns, Pos};

/// A master in one tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MasterSample<'a> {
    /// The tick in force, and from it to the one computed.
    pub(crate) now: Ns,
    pub(crate) period: Ns,
    /// Its position then, in counts of the machine.
    pub(crate) to: Pos,
    /// The machine's position at which its user position is 0.
    pub(crate) named: i64,
    pub(crate) path: MasterPathKind<'a>,
}

/// The path to it within the tick.
#[derive(Debug, Clone, Copy)]
pub(crate) enum MasterPathKind<'a> {
    /// Straight.
    Straight,
    /// Straight, through a filter.
    Filtered,
    /// Along a piece, and the one before it if that was in force at `now`; what is added to their
    /// positions.
    Pieces { before: Option<&'a Piece>, piece: &'a Piece, shift: i64 },
    /// From position to position; what is added to them.
    Track { along: &'a PositionTrack, shift: i64 },
}

state! {
    /// A slave that runs.
    #[derive(Debug, Clone, Copy)]
    pub struct Follower {
        pub(crate) run: FollowRun = run,
        pub(crate) master: Master = master,
        /// A smooth stop is due at the end of the tick.
        pub(crate) braking: Option<StopReason> = None,
        /// The piece of the master that has no turning point, as was found.
        plain: Option<Ns> = None,
        /// Its position at the tick in force; none before the first step.
        last: Option<Pos> = None,
        /// The master's filter.
        filter: Filter = Filter::default(),
        /// The displacement of the master in this tick, units of Pos.
        pub(crate) displacement: i64 = 0,
        /// Its own positions in this tick, if it has slaves.
        pub(crate) track: PositionTrack = PositionTrack::begin(Pos(0)),
    }
    #[inline(always)]
    pub(crate) fn new(run: FollowRun, master: Master);
}

impl Follower {
    /// Whether it moves with its master.
    #[inline(always)]
    pub(crate) fn is_moving(&self) -> bool {
        self.last.is_some_and(|last| self.run.is_moving(last))
    }

    /// Its position with a master at `to`, and the parameter in its piece, if the master moved
    /// there straight and all is inside one piece. `has_slaves`: it is a master itself. `from` is
    /// its position at the tick in force.
    #[inline(always)]
    pub(crate) fn fast_step(&mut self, to: Pos, period: Ns, has_slaves: bool, from: Pos) -> Option<(Pos, u64)> {
        if has_slaves && !self.run.is_fast_and_straight(to) {
            return None;
        }
        let position = self.run.fast_step(to)?;
        if has_slaves {
            self.track = PositionTrack::begin(from);
            self.track.push(period.0 << 32, position.0);
        }
        self.displacement = to.0.wrapping_sub(self.last.unwrap_or(to).0);
        self.last = Some(to);
        Some(position)
    }

    /// Whether a piece of the master has no turning point, as was found before.
    #[inline(always)]
    pub(crate) fn knows(&self, piece: &Piece) -> bool {
        self.plain == Some(piece.begin)
    }

    /// The full step of the tick; `from` is the slave's position at the tick in force.
    #[inline(never)]
    pub(crate) fn step(
        &mut self,
        master_sample: &MasterSample,
        has_slaves: bool,
        from: Pos,
        context: &mut FollowContext<impl FollowEntries, impl Fn(Input, u8) -> bool>,
    ) -> FollowState {
        let state = self.go_along(master_sample, has_slaves, from, context);
        if let FollowState::Ended { at } | FollowState::TimedOut { at } = state {
            self.track.arrive(master_sample.period.0 << 32, at.round());
        }
        state
    }

    #[inline(always)]
    fn go_along(
        &mut self,
        master_sample: &MasterSample,
        has_slaves: bool,
        from: Pos,
        context: &mut FollowContext<impl FollowEntries, impl Fn(Input, u8) -> bool>,
    ) -> FollowState {
        let MasterSample { now, period, .. } = *master_sample;
        let to = if let MasterPathKind::Filtered = master_sample.path {
            self.filter.step(master_sample.to, period)
        } else {
            master_sample.to
        };
        let last = self.last.unwrap_or(to);
        (self.displacement, self.last) = (to.0.wrapping_sub(last.0), Some(to));
        let track = if has_slaves {
            self.track = PositionTrack::begin(from);
            Some(&mut self.track)
        } else {
            None
        };
        let (along, shift) = match master_sample.path {
            MasterPathKind::Straight | MasterPathKind::Filtered => (None, 0),
            MasterPathKind::Pieces { before, piece, shift } => {
                if self.plain != Some(piece.begin) {
                    self.plain = is_plain(piece, now).then_some(piece.begin);
                }
                if before.is_some() || self.plain.is_none() {
                    let displacement = MasterPath::along(now, period, before, piece, last, to, shift);
                    return self.run.step(&displacement, master_sample.named, context, track);
                }
                (Some(piece), shift)
            }
            MasterPathKind::Track { along, shift } => {
                return self.run.step(&MasterPath::of(now, along, shift), master_sample.named, context, track);
            }
        };
        // All the path is one section.
        let to = TimedPosition { after: period.0 << 32, pos: to };
        let from = TimedPosition { after: 0, pos: last };
        let section = Section { now, from, line: from, to, piece: along, shift };
        self.run
            .open(now, &section, to, context)
            .or_else(|| self.run.go(&section, context, track))
            .or_else(|| self.run.close(now, to, master_sample.named, context))
            .unwrap_or(FollowState::Running)
    }
}

/// A lag of first order: τ = 2²² ns.
#[derive(Debug, Clone, Copy, Default)]
struct Filter {
    /// The master's position one tick ago; none before the first step.
    from: Option<Pos>,
    /// The lag of the filtered position, 2⁻⁴⁴ pulse.
    lag: i128,
    /// The period for which `share` was computed.
    period: Ns,
    /// [`share`] of the period.
    share: u64,
}

impl Filter {
    /// The filtered position when the master has come to `to` evenly.
    ///
    /// With u = period/τ the lag changes from l to l·exp(−u) + d·(1 − exp(−u))/u for a displacement
    /// d. That is l + (d − l·u)·share, as exp(−u) = 1 − u·share.
    fn step(&mut self, to: Pos, period: Ns) -> Pos {
        if period != self.period {
            (self.period, self.share) = (period, share(period.0 << 42));
        }
        let displacement = to.0.wrapping_sub(self.from.unwrap_or(to).0);
        self.from = Some(to);
        // Rounded down in every tick, the lag decays to a few hundred 2⁻⁴⁴ pulse below 0 at most:
        // the position arrives.
        let gap =
            ((displacement as i128) << 22).wrapping_add(self.lag.wrapping_neg().wrapping_mul(period.0 as i128) >> 22);
        let part = (gap >> 64).wrapping_mul(self.share as i128).wrapping_add(umulhi(gap as u64, self.share) as i128);
        self.lag = self.lag.wrapping_add(part);
        Pos(to.0.wrapping_add((self.lag.wrapping_neg() >> 22) as i64))
    }
}

/// (1 − exp(−u))/u for u in 2⁻⁶⁴, below a quarter: 1 − u/2·(1 − u/3·(1 − u/4·…)). The terms after
/// u¹³/14! are less than 2⁻⁶⁸. The longest period is less than a quarter of 2²² ns.
pub(crate) fn share(u: u64) -> u64 {
    /// 1/14 to 1/2, 2⁻⁶⁴.
    const RECIPROCALS_Q64: [u64; 13] = {
        let mut parts = [0; 13];
        let mut i = 0;
        while i < 13 {
            parts[i] = u64::MAX / (14 - i as u64);
            i += 1;
        }
        parts
    };
    RECIPROCALS_Q64.iter().fold(u64::MAX, |rest, &part| !umulhi(umulhi(u, rest), part))
}

#[cfg(test)]
mod tests {
    use super::share;
    use num_bigint::BigInt;
    use num_rational::BigRational;

    /// Alternating sums on both sides of (1 − exp(−u))/u, exact, enclose it.
    #[test]
    fn the_share_of_a_period_is_right_to_the_last_bits() {
        for ns in [10_000, 50_000, 250_000, 333_333, 999_999, 1_000_000] {
            let u = BigRational::new(BigInt::from(ns), BigInt::from(1 << 22));
            let (mut term, mut sum) = (BigRational::from_integer(1.into()), BigRational::from_integer(0.into()));
            let mut bounds = [sum.clone(), sum.clone()];
            for k in 0..30 {
                sum += &term;
                term *= -&u / BigInt::from(k + 2);
                bounds[k % 2] = sum.clone();
            }
            let [above, below] =
                bounds.map(|sum| (sum * BigRational::from_integer(BigInt::from(1) << 64)).floor().to_integer());
            assert_eq!(above, below);
            let off = BigInt::from(share(ns << 42)) - below;
            assert!(BigInt::from(-2) <= off && off <= BigInt::from(2), "{off} off at {ns} ns");
        }
    }
}
