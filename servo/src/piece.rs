//! One piece of motion: a cubic in its normalised parameter, and the place in it.
//!
//! In: an instant. Out: planned position, and as much as a reader needs to derive velocity and
//! acceleration. The parameter τ = (now − begin)/length is computed afresh from the time each
//! tick, nothing is accumulated inside a piece; between pieces, knots are [`Exact`].
//! Position error: 2⁻²³ for the start, ≤ 2⁻²² for the rest, plus 3 units of the coefficients'
//! block exponent (`tests/pt_exact.rs`, `tests/ramp_exact.rs`).
use crate::units::{Exact, Ns, Pos};
pub use crate::wide::Recip;
use crate::wide::{mulhi_su, narrow};

/// The place in a piece: enough to derive velocity and acceleration. Default is at rest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Motion {
    /// Coefficients of τ, τ², τ³ in 2^-`frac` pulse.
    pub c: [i64; 3],
    /// Fraction bits of `c`.
    pub frac: u32,
    /// Parameter τ in 2⁻⁶⁴.
    pub tau: u64,
    /// 1/length of the piece in ns.
    pub recip: Recip,
}

/// A real number m·2^-e.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Scaled {
    /// Mantissa.
    pub m: i64,
    /// Negative exponent.
    pub e: i16,
}

/// 10⁶ ns in a ms, as a fraction of 2²⁰.
const MS: u64 = 1_000_000 << 44;

impl Motion {
    /// At rest.
    pub const REST: Motion = Motion { c: [0; 3], frac: 0, tau: 0, recip: Recip { m: 0, shift: 0 } };

    /// Planned velocity in pulse/ms, error ≤ 2⁻⁵⁶ of the piece's peak.
    pub fn velocity(&self) -> Scaled {
        let [c1, c2, c3] = self.c;
        // Eighths leave room for the factors 2 and 3.
        let slope = mulhi_su(c2 >> 2, self.tau).wrapping_add(mulhi_su(mulhi_su(3 * (c3 >> 3), self.tau), self.tau));
        self.per_ms((c1 >> 3).wrapping_add(slope), self.frac as i16 - 3)
    }

    /// Planned acceleration in pulse/ms², error ≤ 2⁻⁵⁶ of the piece's peak.
    pub fn acceleration(&self) -> Scaled {
        let [_, c2, c3] = self.c;
        let bend = (c2 >> 2).wrapping_add(mulhi_su(3 * (c3 >> 2), self.tau));
        let once = self.per_ms(bend, self.frac as i16 - 3);
        self.per_ms(once.m, once.e)
    }

    /// m·2^-e per length of the piece, as a number per ms.
    fn per_ms(&self, m: i64, e: i16) -> Scaled {
        // Keep all bits: 2 guard bits stay for the sign and the product.
        let room = (m.unsigned_abs().leading_zeros() as i16 - 2).max(0);
        if m == 0 {
            return Scaled { m: 0, e: 0 };
        }
        let m = m << room;
        let mantissa = 1 << 63 | self.recip.m >> 1;
        let m = mulhi_su(mulhi_su(m, mantissa), MS);
        Scaled { m, e: e + room + 43 - self.recip.shift as i16 }
    }
}

/// A cubic over a stretch of time. Default is rest at 0 for no time.
#[derive(Debug, Clone, Copy, Default)]
pub struct Piece {
    /// The first whole ns at which it is in force.
    pub begin: Ns,
    /// Whole ns from `begin` to the first at which the next piece is in force.
    pub span: u64,
    /// Position at τ = 0, rounded once.
    pub start: Pos,
    /// Its cubic; here `tau` is the parameter at `begin` (0 where pieces begin on a whole ns).
    pub motion: Motion,
}

impl Piece {
    /// At rest from `begin` on.
    pub const fn rest(begin: Ns, start: Pos) -> Piece {
        Piece { begin, span: u64::MAX, start, motion: Motion::REST }
    }

    /// A piece of constant velocity slope over whole ns: displacement `a`·τ + `b`·τ².
    #[inline(always)]
    pub fn quadratic(begin: Ns, span: u64, start: Exact, a: i128, b: i128) -> Piece {
        Piece::quadratic_at(begin, span, Recip::of(span), start, a, b)
    }

    /// The same with 1/`span` at hand.
    #[inline(always)]
    pub fn quadratic_at(begin: Ns, span: u64, recip: Recip, start: Exact, a: i128, b: i128) -> Piece {
        let bits = magnitude_bits(a) | magnitude_bits(b);
        let width = 128 - bits.leading_zeros() as i32;
        // Largest coefficient just below 2^62; more than 84 fraction bits are of no use.
        let k = (width - 62).clamp(-20, 64);
        Piece {
            begin,
            span,
            start: start.round(),
            motion: Motion { c: [narrow(a, k), narrow(b, k), 0], frac: (64 - k) as u32, tau: 0, recip },
        }
    }

    /// Time since `begin`; while it is below `span` the piece is in force.
    #[inline(always)]
    pub fn elapsed(&self, now: Ns) -> u64 {
        now.0.wrapping_sub(self.begin.0)
    }

    /// The same, held before the end of the piece.
    #[inline(always)]
    pub fn held(&self, now: Ns) -> u64 {
        self.elapsed(now).min(self.span.saturating_sub(1))
    }

    /// Position and τ at `t` < `span` after `begin`.
    #[inline(always)]
    pub fn at(&self, t: u64) -> (Pos, u64) {
        let motion = &self.motion;
        // Neither part is above its true value, so the sum stays below 1.
        let tau = motion.recip.ratio(t).wrapping_add(motion.tau);
        let [c1, c2, c3] = motion.c;
        let mut s = c2;
        if c3 != 0 {
            s = s.wrapping_add(mulhi_su(c3, tau));
        }
        s = mulhi_su(c1.wrapping_add(mulhi_su(s, tau)), tau);
        (Pos(self.start.0.wrapping_add(to_pos(s, motion.frac))), tau)
    }

    /// The place at parameter `tau`, for readers.
    #[inline(always)]
    pub fn motion(&self, tau: u64) -> Motion {
        Motion { tau, ..self.motion }
    }
}

/// Bits that hold the magnitude of x (ones' complement for negatives: one unit less, same width).
#[inline(always)]
fn magnitude_bits(x: i128) -> u128 {
    (x ^ (x >> 127)) as u128
}

/// s·2^-frac in units of Pos, to nearest.
#[inline(always)]
pub(crate) fn to_pos(s: i64, frac: u32) -> i64 {
    let k = frac as i32 - Pos::FRAC_BITS as i32;
    if k > 0 {
        let twice = s >> ((k - 1) as u32 & 63);
        (twice >> 1) + (twice & 1)
    } else {
        s.wrapping_shl((-k) as u32)
    }
}

impl Exact {
    /// To the nearest position.
    #[inline(always)]
    pub fn round(self) -> Pos {
        const CUT: u32 = 64 - Pos::FRAC_BITS;
        Pos((self.0.wrapping_add(1 << (CUT - 1)) >> CUT) as i64)
    }
}

impl From<Pos> for Exact {
    fn from(pos: Pos) -> Exact {
        Exact((pos.0 as i128) << (64 - Pos::FRAC_BITS))
    }
}
