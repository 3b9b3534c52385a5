//! One piece of motion: a cubic in its normalised parameter, and the place in it.
//!
//! In: an instant. Out: planned position, and as much as a reader needs to derive velocity and
//! acceleration. The parameter τ = (now − begin)/length is computed afresh from the time each
//! tick, nothing is accumulated inside a piece; between pieces, knots are [`Exact`].
//!
//! Nearly all pieces are *near*: shorter than 4.29 s, coefficients below 2²⁸ pulses. What their
//! evaluation needs is shifted to its place when the piece is made, so that a tick multiplies and adds
//! without a variable shift: error 2⁻²³ for rounding to a [`Pos`] and less than 2⁻²⁹ for the rest. Others
//! take exact products: 2⁻²³ for the start, 2⁻²³ for rounding, 4 units of the coefficients' last bit
//! (`tests/pt_exact.rs`, `tests/ramp_exact.rs`, the dispatcher's `tables_exact.rs`).
use crate::units::{Exact, Ns, Pos};
pub use crate::wide::Recip;
use crate::wide::{mulhi_su, narrow};

/// The place in a piece: enough to derive velocity and acceleration. Default is at rest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Motion {
    /// Parameter τ in 2⁻⁶³.
    pub tau: u64,
    /// Coefficients of τ in 2^-`frac` pulse, of τ² in half of that, of τ³ in a quarter; |c| < 2⁶¹, 2⁶², 2⁶².
    pub c: [i64; 3],
    /// 1/length of the piece in ns.
    pub recip: Recip,
    /// Fraction bits of the first coefficient.
    pub frac: i32,
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
    pub const REST: Motion = Motion { tau: 0, c: [0; 3], frac: 0, recip: Recip { m: 0, shift: 0 } };

    /// Planned velocity in pulse/ms, error ≤ 2⁻⁵⁶ of the piece's peak.
    pub fn velocity(&self) -> Scaled {
        let ([c1, c2, c3], frac) = self.near_the_top();
        // c1 + c2·τ + 3/4·c3·τ²
        let tau = self.tau << 1;
        let slope = mulhi_su(c2.wrapping_add(mulhi_su(3 * (c3 >> 2), tau)), tau);
        self.per_ms(c1.wrapping_add(slope), frac)
    }

    /// Planned acceleration in pulse/ms², error ≤ 2⁻⁵⁶ of the piece's peak.
    pub fn acceleration(&self) -> Scaled {
        let ([_, c2, c3], frac) = self.near_the_top();
        // c2 + 3/2·c3·τ
        let bend = c2.wrapping_add(mulhi_su(3 * (c3 >> 1), self.tau << 1));
        let once = self.per_ms(bend, frac);
        self.per_ms(once.m, once.e)
    }

    /// Coefficients shifted so that the largest is just below 2⁶⁰, and their fraction bits.
    fn near_the_top(&self) -> ([i64; 3], i16) {
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
        let m = mulhi_su(mulhi_su(m, mantissa), MS);
        Scaled { m, e: e + room + 43 - self.recip.shift as i16 }
    }
}

/// A cubic over a stretch of time. Default is rest at 0 for no time.
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
    /// The span, if the piece is near and the rest is at hand; else 0, and the exact products are needed.
    near: u32,
    /// 2⁹⁵/length: t times it is τ in 2⁻⁹⁵.
    rate: [u32; 3],
    /// What takes the value of the cubic to units of [`Pos`]: a power of two in 2⁻⁶⁴.
    scale: [u32; 2],
    /// The start less the bias of the cubic's value, and the fraction below it with a half, in 2⁻³².
    base: i64,
    fraction: u32,
}

impl Default for Piece {
    fn default() -> Piece {
        Piece::rest(Ns(0), 0, Pos(0))
    }
}

/// Near pieces are so much shorter than 2³² ns that the tick behind their end does not look like one inside.
const NEAR: u64 = (1 << 32) - (1 << 21);

/// Added to what is multiplied, so that no factor is negative.
const BIAS: u64 = 1 << 62;

impl Piece {
    /// The largest parameter.
    pub const END: u64 = u64::MAX >> 1;

    /// At rest for `span` from `begin` on.
    pub const fn rest(begin: Ns, span: u64, start: Pos) -> Piece {
        Piece { begin, span, motion: Motion::REST, start, near: 0, rate: [0; 3], scale: [0; 2], base: 0, fraction: 0 }
    }

    /// A cubic from `start` at τ = 0.
    #[inline(always)]
    pub fn cubic(begin: Ns, span: u64, start: Exact, motion: Motion) -> Piece {
        // The cubic's value is in 2^-(frac − 1).
        let shift = motion.frac.wrapping_sub(1 + Pos::FRAC_BITS as i32) as u32;
        let Recip { m, shift: zeros } = motion.recip;
        let near = span < NEAR && zeros >= 32 && (10..=59).contains(&shift);
        let half = start.0.wrapping_add(1 << (CUT - 1));
        let rounded = (half >> CUT) as i64;
        let (m0, m1) = ((m >> 1) as u32, (m >> 33) as u32 | 1 << 31);
        let s = zeros & 31;
        // A piece of less than a ns has no instant but its first.
        let rate = if zeros < 64 { [m0 << s, m1 << s | m0 >> 1 >> (31 - s), m1 >> 1 >> (31 - s)] } else { [0; 3] };
        let power = 1u32 << (shift.wrapping_neg() & 31);
        Piece {
            begin,
            span,
            motion,
            start: Pos(rounded),
            near: if near { span as u32 } else { 0 },
            rate,
            scale: if shift > 32 { [power, 0] } else { [0, power] },
            base: rounded.wrapping_sub(BIAS.wrapping_shr(shift) as i64),
            fraction: (half >> (CUT - 32)) as u32,
        }
    }

    /// A piece of constant velocity slope over whole ns: displacement `a`·τ + `b`·τ².
    #[inline(always)]
    pub fn quadratic(begin: Ns, span: u64, recip: Recip, start: Exact, a: i128, b: i128) -> Piece {
        let bits = magnitude_bits(a) | magnitude_bits(b);
        let width = 128 - bits.leading_zeros() as i32;
        // Largest coefficient just below 2^61; more than 82 fraction bits are of no use.
        let k = (width - 61).clamp(-18, 64);
        let c = [narrow(a, k), narrow(b, k - 1), 0];
        Piece::cubic(begin, span, start, Motion { tau: 0, c, recip, frac: 64 - k })
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
        if self.near == 0 { self.at_wide(t) } else { self.at_near(t as u32) }
    }

    /// Whether it is near.
    #[inline(always)]
    pub(crate) fn is_near(&self) -> bool {
        self.near != 0
    }

    /// Time since `begin`, of a near piece that holds `now`; for one who asks in every tick from its begin on.
    #[inline(always)]
    pub(crate) fn near_time(&self, now: Ns) -> Option<u32> {
        let t = (now.0 as u32).wrapping_sub(self.begin.0 as u32);
        (t < self.near).then_some(t)
    }

    /// 32 × 32 bit products alone; no factor has a sign, and no sum of products a carry.
    #[inline(always)]
    pub(crate) fn at_near(&self, t: u32) -> (Pos, u64) {
        let [r0, r1, r2] = self.rate;
        let p1 = product(t, r1).wrapping_add(product(t, r0) >> 32);
        let p2 = t.wrapping_mul(r2).wrapping_add((p1 >> 32) as u32);
        let tau = self.motion.tau.wrapping_add((p2 as u64) << 32 | p1 as u32 as u64);
        // (u + BIAS)·τ/2 = u·τ/2 + τ·2⁶¹: it is taken off again as the next bias is added.
        let bias = BIAS.wrapping_sub(tau >> 2);
        let [c1, c2, c3] = self.motion.c;
        let u = (c3 as u64).wrapping_add(BIAS);
        let u = times(u, tau, bias.wrapping_add(c2 as u64));
        let u = times(u, tau, bias.wrapping_add(c1 as u64));
        let s = times(u, tau, bias);
        let [low, high] = self.scale;
        let (s0, s1) = (s as u32, (s >> 32) as u32);
        // One of the two is 0.
        let cross = product(s0, high).wrapping_add(product(s1, low)).wrapping_add(self.fraction as u64);
        let pos = (self.base as u64).wrapping_add(product(s1, high)).wrapping_add(cross >> 32);
        (Pos(pos as i64), tau)
    }

    #[inline(never)]
    fn at_wide(&self, t: u64) -> (Pos, u64) {
        // Neither part is above its true value, so the sum stays below 1.
        let tau = (self.motion.recip.ratio(t) >> 1).wrapping_add(self.motion.tau);
        (self.pos_at(tau), tau)
    }

    /// Position at the parameter `tau`, by exact products.
    pub fn pos_at(&self, tau: u64) -> Pos {
        let ([c1, c2, c3], tau) = (self.motion.c, tau << 1);
        let u = c2.wrapping_add(mulhi_su(c3, tau) >> 1);
        let s = mulhi_su(c1.wrapping_add(mulhi_su(u, tau) >> 1), tau);
        Pos(self.start.0.wrapping_add(to_pos(s, self.motion.frac)))
    }

    /// The place at parameter `tau`, for readers.
    #[inline(always)]
    pub fn motion(&self, tau: u64) -> Motion {
        Motion { tau, ..self.motion }
    }
}

#[inline(always)]
fn product(a: u32, b: u32) -> u64 {
    a as u64 * b as u64
}

/// u·τ/2⁶⁴ + `plus` for both factors below 2⁶³; less than 2 below the true value.
#[inline(always)]
fn times(u: u64, tau: u64, plus: u64) -> u64 {
    let (u0, u1) = (u as u32, (u >> 32) as u32);
    let (t0, t1) = (tau as u32, (tau >> 32) as u32);
    let cross = product(u0, t1).wrapping_add(product(u1, t0));
    plus.wrapping_add(product(u1, t1)).wrapping_add(cross >> 32)
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
const CUT: u32 = 64 - Pos::FRAC_BITS;

impl Exact {
    /// To the nearest position.
    #[inline(always)]
    pub fn round(self) -> Pos {
        Pos((self.0.wrapping_add(1 << (CUT - 1)) >> CUT) as i64)
    }
}

impl From<Pos> for Exact {
    fn from(pos: Pos) -> Exact {
        Exact((pos.0 as i128) << (64 - Pos::FRAC_BITS))
    }
}
