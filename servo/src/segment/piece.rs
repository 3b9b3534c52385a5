//! One piece of motion: a cubic in its normalised parameter, and the position in it.
//!
//! In: an instant. Out: planned position, and what a reader needs to derive velocity and
//! acceleration. Each tick computes the parameter τ = (now − begin)/length afresh from the time;
//! nothing accumulates inside a piece. Between pieces, knots are [`Exact`].
//!
//! Nearly all are *fast-path pieces*: shorter than 2.14 s and longer than 1 µs, coefficients below
//! 2²¹ pulses. What their evaluation needs is computed with the piece (`fast`), so that a tick
//! multiplies 64-bit coefficients by a time of 32 bits: error 2⁻²³ for rounding to a [`Pos`] and
//! less than 2⁻²⁸ for the rest. Others take exact products: 2⁻²³ for the start, 2⁻²³ for rounding,
//! 6.1 units of the coefficients' last bit (`proofs/wide.gappa`; `tests/pt_exact.rs`,
//! `tests/ramp_exact.rs`, the dispatcher's `tables_exact.rs`).
mod fast;

pub use crate::math::float::Scaled;
pub use crate::math::wide::Recip;
use crate::math::wide::{mulhi_su, narrow};
use crate::units::{Exact, Ns, Pos};
use fast::FastPiece;

/// The position in a piece: enough to derive velocity and acceleration. Default is at standstill.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Motion {
    /// Parameter τ in 2⁻⁶³, without what `t` adds.
    pub tau: u64,
    /// Coefficients of τ in 2^-`frac` pulse, of τ² in half of that, of τ³ in a quarter; |c| < 2⁶¹,
    /// 2⁶², 2⁶².
    pub c: [i64; 3],
    /// 1/length of the piece in ns.
    pub recip: Recip,
    /// Fraction bits of the first coefficient.
    pub frac: i32,
    /// ns since τ was `tau`. The tick publishes it for a fast-path piece, so that only readers take
    /// the product.
    pub t: u32,
}

/// 10⁶ ns in a ms, as a fraction of 2²⁰.
const NS_PER_MS_Q44: u64 = 1_000_000 << 44;

impl Motion {
    /// At standstill.
    pub const STANDSTILL: Motion = Motion { tau: 0, c: [0; 3], frac: 0, recip: Recip { m: 0, shift: 0 }, t: 0 };

    /// Parameter τ in 2⁻⁶³.
    #[inline]
    pub fn parameter(&self) -> u64 {
        self.tau.wrapping_add(self.recip.ratio(self.t as u64) >> 1)
    }

    /// Planned velocity in pulse/ms, error ≤ 2⁻⁵⁶ of the piece's peak.
    pub fn velocity(&self) -> Scaled {
        let ([c1, c2, c3], frac) = self.normalised();
        // c1 + c2·τ + 3/4·c3·τ²
        let tau = self.parameter() << 1;
        let slope = mulhi_su(c2.wrapping_add(mulhi_su(3 * (c3 >> 2), tau)), tau);
        self.per_ms(c1.wrapping_add(slope), frac)
    }

    /// Planned acceleration in pulse/ms², error ≤ 2⁻⁵⁶ of the piece's peak.
    pub fn acceleration(&self) -> Scaled {
        let ([_, c2, c3], frac) = self.normalised();
        // c2 + 3/2·c3·τ
        let bend = c2.wrapping_add(mulhi_su(3 * (c3 >> 1), self.parameter() << 1));
        let once = self.per_ms(bend, frac);
        self.per_ms(once.m, once.e)
    }

    /// Coefficients shifted so that the largest is just below 2⁶⁰, and their fraction bits.
    fn normalised(&self) -> ([i64; 3], i16) {
        let bits = self.c.iter().fold(1, |bits, c| bits | c.unsigned_abs());
        let up = bits.leading_zeros() as i32 - 4;
        (self.c.map(|c| if up < 0 { c >> -up } else { c << up }), (self.frac + up) as i16)
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
        let m = mulhi_su(mulhi_su(m, mantissa), NS_PER_MS_Q44);
        Scaled { m, e: e + room + 43 - self.recip.shift as i16 }
    }
}

/// A cubic over an interval of time. Default is standstill at 0 for no time.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Piece {
    /// The first whole ns at which it is in force.
    pub begin: Ns,
    /// Whole ns from `begin` to the first at which the next piece is in force.
    pub span: u64,
    /// Its cubic; here `tau` is the parameter at `begin` (0 where pieces begin on a whole ns).
    pub motion: Motion,
    /// Position at τ = 0, rounded once.
    pub start: Pos,
    fast: FastPiece,
}

impl Default for Piece {
    fn default() -> Piece {
        Piece::standstill(Ns(0), 0, Pos(0))
    }
}

impl Piece {
    /// The largest parameter.
    pub const TAU_END: u64 = u64::MAX >> 1;

    /// At standstill for `span` from `begin` on.
    pub const fn standstill(begin: Ns, span: u64, start: Pos) -> Piece {
        Piece { begin, span, motion: Motion::STANDSTILL, start, fast: FastPiece::NONE }
    }

    /// A cubic from `start` at τ = 0.
    #[inline(always)]
    pub fn cubic(begin: Ns, span: u64, start: Exact, motion: Motion) -> Piece {
        // The low bits as a number with a sign: what was rounded up has a negative remainder.
        let start_remainder = (start.0 as u64 >> (CUT_BITS - REMAINDER_BITS)) as i32;
        let mut fast = FastPiece::of(span, start, &motion);
        fast.start_remainder = start_remainder;
        Piece { begin, span, motion, start: start.round(), fast }
    }

    /// A piece of constant acceleration over whole ns: displacement `a`·τ + `b`·τ².
    #[inline(always)]
    pub fn quadratic(begin: Ns, span: u64, recip: Recip, start: Exact, a: i128, b: i128) -> Piece {
        let bits = magnitude_bits(a) | magnitude_bits(b);
        let width = 128 - bits.leading_zeros() as i32;
        // Largest coefficient just below 2^61; more than 82 fraction bits are of no use.
        let k = (width - 61).clamp(-18, 64);
        let c = [narrow(a, k), narrow(b, k - 1), 0];
        Piece::cubic(begin, span, start, Motion { tau: 0, c, recip, frac: 64 - k, t: 0 })
    }

    /// Time since `begin`; while it is below `span` the piece is in force.
    #[inline(always)]
    pub fn elapsed(&self, now: Ns) -> u64 {
        now.0.wrapping_sub(self.begin.0)
    }

    /// The same, limited to before the end of the piece.
    #[inline(always)]
    pub fn elapsed_within(&self, now: Ns) -> u64 {
        self.elapsed(now).min(self.span.saturating_sub(1))
    }

    /// Position and τ at `t` < `span` after `begin`.
    #[inline(always)]
    pub fn at(&self, t: u64) -> (Pos, u64) {
        if self.is_fast() { self.at_fast(t as u32) } else { self.at_wide(t) }
    }

    /// Position at `t` < `span` after `begin`, and the motion there for readers.
    #[inline(always)]
    pub fn sample(&self, t: u64) -> (Pos, Motion) {
        if self.is_fast() {
            let t = t as u32;
            return (self.fast.at(t), Motion { t, ..self.motion });
        }
        let (pos, tau) = self.at_wide(t);
        (pos, self.motion(tau))
    }

    /// Whether it is a fast-path piece.
    #[inline(always)]
    pub(crate) fn is_fast(&self) -> bool {
        self.fast.span != 0
    }

    /// Time since `begin` of a fast-path piece, if it holds `now`. For callers that ask in every
    /// tick from its begin on: the tick after its end is not taken for one inside, as these pieces
    /// are much shorter than 2³² ns.
    #[inline(always)]
    pub(crate) fn fast_time(&self, now: Ns) -> Option<u32> {
        self.fast_time_of(now.0 as u32)
    }

    /// The same of the low word of an instant.
    #[inline(always)]
    pub(crate) fn fast_time_of(&self, now: u32) -> Option<u32> {
        let t = now.wrapping_sub(self.begin.0 as u32);
        (t < self.fast.span).then_some(t)
    }

    /// Position and τ of a fast-path piece.
    #[inline(always)]
    pub(crate) fn at_fast(&self, t: u32) -> (Pos, u64) {
        (self.fast.at(t), self.motion.tau.wrapping_add(self.fast.tau_from_begin(t)))
    }

    /// Position of a fast-path piece without acceleration.
    #[inline(always)]
    pub(crate) fn pos_even(&self, t: u32) -> Pos {
        self.fast.at_even(t)
    }

    /// Position of a fast-path piece.
    #[inline(always)]
    pub(crate) fn pos_fast(&self, t: u32) -> Pos {
        self.fast.at(t)
    }

    /// Position and τ of any other.
    #[inline(never)]
    pub(crate) fn at_wide(&self, t: u64) -> (Pos, u64) {
        // Neither part is above its true value, so the sum stays below 1.
        let tau = (self.motion.recip.ratio(t) >> 1).wrapping_add(self.motion.tau);
        (self.pos_at(tau), tau)
    }

    /// Position at the parameter `tau`, by exact products.
    pub fn pos_at(&self, tau: u64) -> Pos {
        Pos(self.start.0.wrapping_add(to_pos(self.displacement(tau), self.motion.frac)))
    }

    /// Position at the parameter `tau`, to 2⁻⁵⁴ pulse and 2⁻⁵⁸ of the piece's displacement.
    pub fn exact_at(&self, tau: u64) -> Exact {
        let remainder = (self.fast.start_remainder as i128) << (CUT_BITS - REMAINDER_BITS);
        let (s, up) = (self.displacement(tau) as i128, 64 - self.motion.frac);
        let s = if up >= 0 { s << (up as u32 & 127) } else { s >> (up.unsigned_abs() & 127) };
        Exact(Exact::from(self.start).0.wrapping_add(remainder).wrapping_add(s))
    }

    /// Displacement since τ = 0, 2^-frac pulse.
    #[inline(always)]
    fn displacement(&self, tau: u64) -> i64 {
        let ([c1, c2, c3], tau) = (self.motion.c, tau << 1);
        let u = c2.wrapping_add(mulhi_su(c3, tau) >> 1);
        mulhi_su(c1.wrapping_add(mulhi_su(u, tau) >> 1), tau)
    }

    /// Whether its whole way ends at `pos`, to 2⁻¹⁶ pulse.
    pub fn ends_at(&self, pos: Pos) -> bool {
        self.pos_at(Piece::TAU_END).0.abs_diff(pos.0) < 1 << (Pos::FRAC_BITS - 16)
    }

    /// The motion at parameter `tau`, for readers.
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
fn to_pos(s: i64, frac: i32) -> i64 {
    let k = frac - Pos::FRAC_BITS as i32;
    if k > 0 {
        let twice = s >> ((k - 1) as u32 & 63);
        (twice >> 1) + (twice & 1)
    } else {
        s.wrapping_shl((-k) as u32)
    }
}

/// Bits of an [`Exact`] below a [`Pos`].
const CUT_BITS: u32 = 64 - Pos::FRAC_BITS;
/// Those of them that a piece keeps.
const REMAINDER_BITS: u32 = 32;

impl Exact {
    /// To the nearest position.
    #[inline(always)]
    pub fn round(self) -> Pos {
        Pos((self.0.wrapping_add(1 << (CUT_BITS - 1)) >> CUT_BITS) as i64)
    }
}

impl From<Pos> for Exact {
    fn from(pos: Pos) -> Exact {
        Exact((pos.0 as i128) << (64 - Pos::FRAC_BITS))
    }
}
