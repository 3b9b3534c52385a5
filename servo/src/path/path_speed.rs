//! The speed along a path, as a laser's power follows it.
//!
//! In: the motion of a path, a displacement, or counts of encoders, with their interval. Out: a
//! [`PathSpeed`]. Owns nothing. Cannot fail: a speed out of range saturates.
use crate::math::float::Float;
use crate::math::wide::{mulhi_su, umulhi};
use crate::segment::piece::{Motion, Piece, Recip};
use crate::units::{Exact, Ns};

/// |path velocity| in 2⁻³⁰ pulse/ms; the largest is 2³⁴.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct PathSpeed(pub(crate) u64);

impl PathSpeed {
    /// Fraction bits.
    pub const FRAC_BITS: u32 = 30;
    /// Fraction bits of counts a tick, as [`PathSpeed::measured`] takes them.
    pub const COUNT_BITS: u32 = 28;
    /// At standstill.
    pub const STANDSTILL: PathSpeed = PathSpeed(0);

    /// In units of 2⁻³⁰ pulse/ms.
    pub const fn raw(self) -> u64 {
        self.0
    }

    /// The speed in the middle of the interval of `period` from the present position in the motion
    /// on. The motion has constant acceleration over a power of two of ns; it is taken to go on
    /// that long, but not backwards.
    pub fn ahead(motion: &Motion, period: Ns) -> PathSpeed {
        let Motion { tau, t, c: [speed, change, _], recip: Recip { shift, .. }, frac, .. } = *motion;
        // The piece lasts 2^(64 - shift) ns; tau and half a period are in 2^-63 of it.
        let mut speed = speed;
        if change != 0 {
            let half = period.0 >> 1;
            let share = if half.leading_zeros() >= shift { half.wrapping_shl(shift) >> 1 } else { Piece::TAU_END };
            // If the motion has its time, the piece lasts 2^32 ns at most.
            let gone = (t.wrapping_shl(shift) as u64) << 31;
            let tau = tau.wrapping_add(gone).wrapping_add(share).min(Piece::TAU_END);
            speed = speed.wrapping_add(mulhi_su(change, tau << 1));
        }
        let speed = speed.max(0) as u64;
        // In 2^-frac pulse per piece; 10^6 ns are a ms.
        let per_ms = umulhi(speed, 1_000_000 << 44);
        let down = frac.wrapping_add(64 - 20 - PathSpeed::FRAC_BITS as i32).wrapping_sub(shift as i32);
        match down {
            1..=63 => PathSpeed((per_ms >> (down - 1)).wrapping_add(1) >> 1),
            -18..=0 => PathSpeed(per_ms << -down as u32),
            _ => PathSpeed::STANDSTILL,
        }
    }

    /// The same at any instant and period, if the motion has no acceleration.
    pub(crate) fn even(motion: &Motion) -> Option<PathSpeed> {
        let [_, change, _] = motion.c;
        (change == 0).then(|| PathSpeed::ahead(motion, Ns(0)))
    }

    /// Of a displacement in `period`.
    pub(crate) fn mean(displacement: Exact, period: Ns) -> PathSpeed {
        PathSpeed::per_ms(Float::from_exact(displacement), period)
    }

    fn per_ms(displacement: Float, period: Ns) -> PathSpeed {
        let speed = displacement.mul(Float::new(false, 1_000_000, 0)).div(Float::new(false, period.0, 0));
        PathSpeed(speed.to_fixed(PathSpeed::FRAC_BITS as i32).clamp(0, u64::MAX as i128) as u64)
    }

    /// Of encoders with these counts in an interval of `period`, 2⁻²⁸ pulse: the norm of their
    /// velocities.
    pub fn measured(counts: [i64; 4], period: Ns) -> PathSpeed {
        let sum = counts.iter().fold(0u128, |sum, by| {
            let by = by.unsigned_abs().min(1 << 60) as u128;
            sum.wrapping_add(by * by)
        });
        PathSpeed::per_ms(Float::from_fixed(sum, 2 * PathSpeed::COUNT_BITS as i32).sqrt(), period)
    }
}
