//! Wide integer arithmetic: products, reciprocals and quotients without a division instruction.
//!
//! In: machine integers. Out: exact floors, or errors as stated. Nothing fails, nothing panics.
//! The compiler's products of 128 bits become UMULL and UMAAL; the reciprocals follow Möller &
//! Granlund, "Improved division by invariant integers" (2011). Held by `tests/wide_exact.rs`
//! against big integers.

/// Full product of two 64-bit numbers: high and low half.
#[inline(always)]
pub const fn umul(a: u64, b: u64) -> (u64, u64) {
    let product = a as u128 * b as u128;
    ((product >> 64) as u64, product as u64)
}

/// A double from 0 to below 2⁴¹, by its bits: 52 bits of fraction, and a field above them. Field 1
/// is 2⁻¹²..2⁻¹¹, whose last bit is 2⁻⁶⁴; below, multiples of 2⁻⁶⁴, field 0.
#[inline(always)]
pub(crate) const fn packed(bits: u64) -> u64 {
    let exponent = bits >> 52;
    if exponent >= 1011 {
        bits - (1010 << 52)
    } else if exponent >= 958 {
        let twice = (1 << 52 | bits & ((1 << 52) - 1)) >> (1010 - exponent);
        (twice >> 1) + (twice & 1)
    } else {
        0
    }
}

/// High half of the product of two 64-bit numbers.
#[inline(always)]
pub const fn umulhi(a: u64, b: u64) -> u64 {
    umul(a, b).0
}

/// High half of signed × unsigned: floor(a·b / 2⁶⁴).
#[inline(always)]
pub const fn mulhi_su(a: i64, b: u64) -> i64 {
    umulhi(a as u64, b).wrapping_sub((a >> 63) as u64 & b) as i64
}

/// High half of signed × signed, at most 2 units too small or 1 too large, where one factor is
/// within ±2⁶²: three products.
#[inline(always)]
pub const fn mulhi_near(a: i64, b: i64) -> i64 {
    let (a0, a1) = ((a as u32 >> 1) as i64, a >> 32);
    let (b0, b1) = ((b as u32 >> 1) as i64, b >> 32);
    let cross = (a1 * b0).wrapping_add(b1 * a0);
    (a1 * b1).wrapping_add(cross >> 31)
}

/// floor((2¹⁹ − 3·2⁸) / d9) for d9 = 256…511: eleven bits of 1/d to begin with.
const SEED: [u16; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = (((1 << 19) - 3 * (1 << 8)) / (256 + i)) as u16;
        i += 1;
    }
    table
};

/// The first two steps of the reciprocal of a normalised 64-bit number: about 34 bits of 2⁹⁷/d.
#[inline(always)]
fn recip_begin(d: u64) -> u64 {
    let v0 = SEED[(d >> 55) as usize & 0xff] as u64;
    let d40 = (d >> 24) + 1;
    let v1 = (v0 << 11).wrapping_sub((v0 * v0).wrapping_mul(d40) >> 40).wrapping_sub(1);
    let gap = (1u64 << 60).wrapping_sub(v1.wrapping_mul(d40));
    (v1 << 13).wrapping_add(v1.wrapping_mul(gap) >> 47)
}

/// As [`recip64`], or one less: enough where a reciprocal only must not be above the true one.
#[inline(always)]
pub fn recip64_below(d: u64) -> u64 {
    let v2 = recip_begin(d);
    let d63 = (d >> 1) + (d & 1);
    let e = ((v2 >> 1) & 0u64.wrapping_sub(d & 1)).wrapping_sub(v2.wrapping_mul(d63));
    (v2 << 31).wrapping_add(umulhi(v2, e) >> 1)
}

/// floor((2¹²⁸ − 1) / d) − 2⁶⁴ for a `d` with its top bit set.
#[inline]
pub fn recip64(d: u64) -> u64 {
    let v3 = recip64_below(d);
    // floor((v3 + 2^64 + 1)·d / 2^64), modulo 2^64
    let (high, low) = umul(v3, d);
    let carry = low.overflowing_add(d).1 as u64;
    v3.wrapping_sub(high.wrapping_add(carry)).wrapping_sub(d)
}

/// floor((2⁶⁴ − 1) / d) − 2³² for a `d` with its top bit set.
#[inline(always)]
pub fn recip32(d: u32) -> u32 {
    let guess = (recip_begin((d as u64) << 32) >> 1) as u32;
    // The guess is at most one off; v is right when 2^64 - 1 - (2^32 + v)·d lies in 0..d.
    let product = (guess as u64) * d as u64 + ((d as u64) << 32);
    let remainder = u64::MAX.wrapping_sub(product);
    if remainder >> 63 == 1 {
        guess.wrapping_sub(1)
    } else if remainder >= d as u64 {
        guess.wrapping_add(1)
    } else {
        guess
    }
}

/// 1/n as (2⁶⁴ + m)·2^(shift − 128): 65 significant bits, rounded down.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Recip {
    /// Mantissa below its leading one.
    pub m: u64,
    /// Leading zeros of n: n·2^shift has its top bit set.
    pub shift: u32,
}

impl Recip {
    /// 1/n; for n = 0 the reciprocal of 1.
    #[inline]
    pub fn of(n: u64) -> Recip {
        let n = if n == 0 { 1 } else { n };
        let shift = n.leading_zeros();
        Recip { m: recip64(n << shift), shift }
    }

    /// t/n in 2⁻⁶⁴ for t < n, never above the true value and less than 2⁻⁶³ below it.
    #[inline(always)]
    pub fn ratio(self, t: u64) -> u64 {
        let t = t.wrapping_shl(self.shift);
        t.wrapping_add(umulhi(t, self.m))
    }
}

/// A divisor of up to 31 bits, prepared for dividing without a division instruction.
#[derive(Debug, Clone, Copy)]
pub struct Divisor {
    d: u32,
    v: u32,
    shift: u32,
}

impl Divisor {
    /// Divisor `n`, 0 < n < 2³¹ (anything else is taken as 1).
    #[inline(always)]
    pub fn new(n: u32) -> Divisor {
        let n = if n == 0 || n >> 31 == 1 { 1 } else { n };
        let shift = n.leading_zeros();
        let d = n << shift;
        Divisor { d, v: recip32(d), shift }
    }

    /// The same from its reciprocal, as [`Divisor::inverse`] returned it.
    #[inline(always)]
    pub fn again(n: u32, inverse: u32) -> Divisor {
        let n = if n == 0 || n >> 31 == 1 { 1 } else { n };
        let shift = n.leading_zeros();
        Divisor { d: n << shift, v: inverse, shift }
    }

    /// What [`Divisor::again`] needs.
    #[inline(always)]
    pub fn inverse(&self) -> u32 {
        self.v
    }

    /// (high·2³² + low) / d for high < d: quotient digit and remainder, exact.
    #[inline(always)]
    fn digit(&self, high: u32, low: u32) -> (u32, u32) {
        let q = (self.v as u64) * high as u64 + ((high as u64) << 32 | low as u64);
        let mut q1 = ((q >> 32) as u32).wrapping_add(1);
        let mut r = low.wrapping_sub(q1.wrapping_mul(self.d));
        if r > q as u32 {
            q1 = q1.wrapping_sub(1);
            r = r.wrapping_add(self.d);
        }
        if r >= self.d {
            q1 = q1.wrapping_add(1);
            r -= self.d;
        }
        (q1, r)
    }

    /// ⌊x / n⌋ for x < n·2³².
    #[inline(always)]
    pub fn floor(&self, x: u64) -> u32 {
        let x = x.wrapping_shl(self.shift);
        self.digit((x >> 32) as u32, x as u32).0
    }

    /// x / n to the nearest whole number, and whether it came out even (no remainder).
    #[inline(always)]
    pub fn quotient(&self, x: u128) -> (u128, bool) {
        let s = self.shift; // 1..=31
        let (x0, x1, x2, x3) = (x as u32, (x >> 32) as u32, (x >> 64) as u32, (x >> 96) as u32);
        let t = 32 - s;
        let r = x3 >> t;
        let (q3, r) = self.digit(r, x3 << s | x2 >> t);
        let (q2, r) = self.digit(r, x2 << s | x1 >> t);
        let (q1, r) = self.digit(r, x1 << s | x0 >> t);
        let (q0, r) = self.digit(r, x0 << s);
        let q = (q3 as u128) << 96 | (q2 as u128) << 64 | (q1 as u128) << 32 | q0 as u128;
        (q.wrapping_add((r > self.d >> 1) as u128), r == 0)
    }

    /// floor(x / n).
    #[inline(always)]
    pub fn quotient64(&self, x: u64) -> u64 {
        let s = self.shift;
        let (x0, x1) = (x as u32, (x >> 32) as u32);
        let t = 32 - s;
        let (q1, r) = self.digit(x1 >> t, x1 << s | x0 >> t);
        let (q0, _) = self.digit(r, x0 << s);
        (q1 as u64) << 32 | q0 as u64
    }
}

/// x·n / 2¹⁶ rounded down, of a magnitude; the top is cut at 2¹²⁸.
#[inline(always)]
pub fn scale16(x: u128, n: u32) -> u128 {
    let n = n as u64;
    let p0 = (x as u32 as u64) * n;
    let p1 = ((x >> 32) as u32 as u64) * n + (p0 >> 32);
    let p2 = ((x >> 64) as u32 as u64) * n + (p1 >> 32);
    let p3 = ((x >> 96) as u32 as u64) * n + (p2 >> 32);
    let low = (p1 as u32 as u64) << 32 | p0 as u32 as u64;
    let high = p3 << 32 | p2 as u32 as u64;
    let top = p3 >> 32;
    ((high >> 16 | top << 48) as u128) << 64 | (low >> 16 | high << 48) as u128
}

/// x·2^-k rounded to nearest, as an i64: for results that fit. k from −63 to 127.
#[inline(always)]
pub fn narrow(x: i128, k: i32) -> i64 {
    let (high, low) = ((x >> 64) as i64, x as u64);
    if k <= 0 {
        return (low << ((-k) as u32 & 63)) as i64;
    }
    // Halfway rounding: one bit more than requested, then half of (it + 1).
    let s = (k - 1) as u32;
    let twice = if s >= 64 { high >> (s & 63) } else { (low >> s | (high as u64) << 1 << (63 - s)) as i64 };
    (twice >> 1).wrapping_add(twice & 1)
}
