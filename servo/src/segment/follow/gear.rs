//! Gear: a slave goes along with its master's displacement in a ratio, both ways and without end.
//!
//! In: a ratio of whole numbers and the length of its slope, checked here. Out: the piece that
//! holds a progress (`evaluator/geared.rs`). Owns: [`Gear`], the law of a run. Fails: a ratio that
//! no axis could follow is [`GearRefused`].
//!
//! The slave is at s₀ + S/M·(m − m₀) with the given whole numbers M and S. A piece covers a
//! multiple of M and S, so that it is long; the next one begins at the next multiple, so nothing
//! accumulates. On the slope the ratio changes evenly from the one before, r₀, to S/M over L pulses
//! of the master in either direction: at a distance x from its start the slave has moved by r₀·x +
//! (S/M − r₀)·x²/(2·L). Once the master has been L away the slope is over, and the ratio stays.
//!
//! Error: 2⁻²¹ pulse in a piece of the gear, 2⁻¹⁶ on a slope. What stays: 2⁻⁴⁸ pulse of every new
//! ratio, 2⁻²³ of one that comes on a slope. Held by `tests/gear_exact.rs`.
use super::curve::cubic;
use super::ratio::{quotient, start_displacement};
use crate::segment::piece::{Motion, Piece};
use crate::units::{Exact, Ns, Pos};
use core::num::NonZeroU32;

/// Pulses of master and slave in a piece, unless those given are more.
const PIECE_PULSES: u32 = 1 << 31;
/// The largest |ratio|.
const RATIO_MAX_INTEGER: u64 = 1 << 24;
/// The largest displacement of the slave at the full ratio over the slope, pulses.
const SLOPE_MAX_PULSES: u128 = Pos::TRAVEL_PULSES as u128;

/// A ratio that has passed its checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GearRatio {
    /// Displacements of master and slave that belong together, pulses: a multiple of those given.
    master: NonZeroU32,
    slave: i64,
    /// Displacement of the master over which the ratio is reached, pulses; 0 is at once.
    slope: u32,
    /// 2⁻⁸⁰.
    ratio: i128,
}

/// What is wrong with a ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GearRefused {
    /// The master's part of it is 0.
    Master,
    /// It is above 2²⁴.
    TooSteep,
    /// The slope is below 0, or 1.
    Slope,
    /// On the slope the slave would leave its travel of 2⁴⁰ pulses.
    TooFar,
}

impl GearRatio {
    /// The largest |ratio|.
    pub const MAX: u64 = RATIO_MAX_INTEGER;

    /// The ratio `slave`/`master`, reached over `slope` pulses of the master. For the thread only.
    pub fn of(master: i32, slave: i32, slope: i32) -> Result<GearRatio, GearRefused> {
        if master == 0 {
            return Err(GearRefused::Master);
        }
        let (part, steps) = (master.unsigned_abs(), slave.unsigned_abs());
        if steps as u64 > RATIO_MAX_INTEGER * part as u64 {
            return Err(GearRefused::TooSteep);
        }
        if slope < 0 || slope == 1 {
            return Err(GearRefused::Slope);
        }
        if steps as u128 * slope as u128 > SLOPE_MAX_PULSES * part as u128 {
            return Err(GearRefused::TooFar);
        }
        let times = multiple(part.max(steps));
        let slave = if master < 0 { -(slave as i64) } else { slave as i64 };
        let ratio = quotient(slave as i128, part as u128);
        let master = NonZeroU32::new(part << times).ok_or(GearRefused::Master)?;
        Ok(GearRatio { master, slave: slave << times, slope: slope as u32, ratio })
    }

    /// The same over a progress that is the master's position with its sign changed.
    fn directed(self, down: bool) -> GearRatio {
        if down {
            GearRatio { slave: self.slave.wrapping_neg(), ratio: self.ratio.wrapping_neg(), ..self }
        } else {
            self
        }
    }
}

/// How often a number can be doubled below [`PIECE_PULSES`].
fn multiple(part: u32) -> u32 {
    PIECE_PULSES.leading_zeros().abs_diff(part.leading_zeros()).saturating_sub(1)
}

/// The law of a slave in gear. The run keeps the positions of master and slave from which it
/// counts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gear {
    ratio: GearRatio,
    slope: Option<Slope>,
}

/// Displacements on the way to a ratio, 2⁻⁶⁴ pulse.
#[derive(Debug, Clone, Copy)]
struct Slope {
    /// Over all of it at the ratio before.
    before: i128,
    /// What the change of the ratio adds.
    change: i128,
}

impl Gear {
    /// It begins at the ratio `before` (2⁻⁸⁰, over the progress).
    pub(super) fn begin(ratio: GearRatio, down: bool, before: i128) -> Gear {
        let ratio = ratio.directed(down);
        let length = (ratio.slope as u128) << 64;
        let slope = (length != 0).then(|| {
            let before = start_displacement(before, length);
            Slope { before, change: start_displacement(ratio.ratio, length).wrapping_sub(before) >> 1 }
        });
        Gear { ratio, slope }
    }

    /// Displacements of master and slave that belong together, 2⁻⁶⁴ pulse.
    pub(super) fn lengths(&self) -> (i128, i128) {
        ((self.ratio.master.get() as i128) << 64, (self.ratio.slave as i128) << 64)
    }

    /// The ratio, 2⁻⁸⁰, and the slave's displacement at `x` ≥ 0 after the slope; none on it.
    pub(super) fn engaged(&self, x: i128) -> Option<(i128, i128)> {
        let ratio = self.ratio.ratio;
        self.slope.is_none().then(|| (ratio, start_displacement(ratio, x.unsigned_abs())))
    }

    /// On the slope, with the master at a displacement of `x` from its start: the piece there, or
    /// the displacements of master and slave with which it is over.
    pub(super) fn on_slope(&mut self, x: i128, began: i128, origin: i128) -> Option<Result<Piece, (i128, i128)>> {
        let Slope { before, change } = self.slope?;
        let length = (self.ratio.slope as i128) << 64;
        let end = before.wrapping_add(change);
        if x.unsigned_abs() >= length.unsigned_abs() {
            self.slope = None;
            return Some(Err(if x < 0 { (length.wrapping_neg(), end.wrapping_neg()) } else { (length, end) }));
        }
        Some(Ok(if x >= 0 {
            cubic(began, length, origin, [before, change, 0])
        } else {
            // With the distance from the start L·(1 − τ).
            let coefficients = [end.wrapping_add(change), change.wrapping_neg(), 0];
            let start = origin.wrapping_sub(end);
            let piece = cubic(began.wrapping_sub(length), length, start, coefficients);
            // A master at L has left the slope: the piece begins a unit later.
            let Piece { begin, span, motion, .. } = piece;
            let tau = motion.tau.wrapping_add(motion.recip.ratio(1) >> 1);
            Piece::cubic(Ns(begin.0.wrapping_add(1)), span.wrapping_sub(1), Exact(start), Motion { tau, ..motion })
        }))
    }

    /// The piece that begins at these positions.
    pub(super) fn piece(&self, began: i128, origin: i128) -> Piece {
        let (length, displacement) = self.lengths();
        cubic(began, length, origin, [displacement, 0, 0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_is_refused_with_what_is_wrong() {
        use GearRefused::*;
        for (given, wrong) in [
            ((0, 1, 0), Master),
            ((1, (1 << 24) + 1, 0), TooSteep),
            ((-1, -(1 << 24) - 1, 0), TooSteep),
            ((1, i32::MIN, 0), TooSteep),
            ((2, 1, -1), Slope),
            ((2, 1, 1), Slope),
            ((1, 1 << 24, 1 << 17), TooFar),
        ] {
            assert_eq!(GearRatio::of(given.0, given.1, given.2), Err(wrong), "{given:?}");
        }
        for (master, slave, slope) in
            [(i32::MIN, i32::MIN, i32::MAX), (1, 1 << 24, 1 << 16), (1, 0, 2), (i32::MAX, i32::MAX, 0)]
        {
            assert!(GearRatio::of(master, slave, slope).is_ok(), "{master} {slave} {slope}");
        }
    }

    /// A piece is as long as it can be, and no longer: neither number overflows.
    #[test]
    fn pieces_are_long() {
        for (master, slave) in [(1, 1), (3, -2), (i32::MIN, 1), (1, 1 << 24), (i32::MAX, i32::MIN), (7, 0)] {
            let ratio = GearRatio::of(master, slave, 0).unwrap();
            let longest = u64::from(ratio.master.get()).max(ratio.slave.unsigned_abs());
            assert!((1 << 30..=1 << 31).contains(&longest), "{master} {slave}: {longest}");
            let quotient = |a: i128, b: i128| a * master as i128 == b * slave as i128;
            assert!(quotient(ratio.slave as i128, ratio.master.get() as i128), "{master} {slave}");
        }
    }
}
