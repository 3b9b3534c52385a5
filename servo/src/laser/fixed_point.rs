//! Doubles by their bits, and products of fixed point.
//!
//! In: the bits of a user's double; whole numbers. Out: fixed point, or a real; products. Owns
//! nothing. Fails: with the rule that a double breaks; a value too large for a power is held at the
//! limit.
use super::power::Refused;
use crate::math::float::Float;
use crate::math::wide::{umul, umulhi};

/// A double as a whole number of 2^-frac, to the nearest; |x| ≤ 2^most.
pub(super) fn fixed(bits: u64, frac: i32, most: u32) -> Result<i64, Refused> {
    let value = float(bits)?;
    if value.width() > most as i32 + 1 {
        return Err(Refused::BeyondRange);
    }
    let fixed = value.to_fixed(frac);
    if fixed.unsigned_abs() > 1u128 << (most as i32 + frac) as u32 {
        Err(Refused::BeyondRange)
    } else {
        Ok(fixed as i64)
    }
}

/// A double as a real; subnormals are 0.
pub(super) fn float(bits: u64) -> Result<Float, Refused> {
    let exponent = (bits >> 52 & 0x7ff) as i32;
    match exponent {
        0x7ff => Err(Refused::NotFinite),
        0 => Ok(Float::ZERO),
        _ => Ok(Float::new(bits >> 63 == 1, 1 << 52 | bits & ((1 << 52) - 1), exponent - 1075)),
    }
}

/// The largest part of a power, 2⁻⁴⁴: four of them are a number.
pub(super) const POWER_PART_MAX_RAW: i64 = 1 << 61;

/// a·b.
#[inline(always)]
pub(super) fn product(a: i64, b: i64) -> i128 {
    a as i128 * b as i128
}

/// a·b of a factor without a sign.
#[inline(always)]
pub(super) fn scaled(a: i64, b: u64) -> i128 {
    let (high, low) = umul(a as u64, b);
    ((high.wrapping_sub((a >> 63) as u64 & b) as u128) << 64 | low as u128) as i128
}

/// x·2^-shift to the nearest, of results that fit into 63 bits; shift from 1 to 127.
#[inline(always)]
pub(super) fn nearest(x: i128, shift: u32) -> i64 {
    let shift = shift.wrapping_sub(1);
    let [low, high] = [x as u64, (x >> 64) as u64];
    let sign = (x >> 127) as u32;
    let (x0, x1, x2, x3) = (low as u32, (low >> 32) as u32, high as u32, (high >> 32) as u32);
    let (a, b, c) = match shift >> 5 {
        0 => (x0, x1, x2),
        1 => (x1, x2, x3),
        2 => (x2, x3, sign),
        _ => (x3, sign, sign),
    };
    let by = shift & 31;
    let join = |low: u32, high: u32| low >> by | (high << 1) << (31 - by);
    let twice = ((join(b, c) as u64) << 32 | join(a, b) as u64) as i64;
    (twice >> 1).wrapping_add(twice & 1)
}

/// A shift prepared for many numbers that need no limit: as [`part`] and [`held`] otherwise.
#[derive(Debug, Clone, Copy)]
pub(super) struct PreparedShift {
    by: u32,
    /// The last words of the numbers are below it; 0 for a shift that is not between one word and
    /// two.
    room: u32,
}

impl PreparedShift {
    /// By any shift.
    pub(super) const fn of(shift: u32) -> PreparedShift {
        let room = if shift >= 36 && shift <= 64 { 1 << (shift - 35) } else { 0 };
        PreparedShift { by: shift.wrapping_sub(1) & 31, room }
    }

    /// Of a number with a sign.
    #[inline(always)]
    pub(super) fn signed(self, x: i128) -> Option<i64> {
        let fits = ((x >> 96) as u32).wrapping_add(self.room) < self.room << 1;
        fits.then_some(self.words([(x >> 32) as u32, (x >> 64) as u32, (x >> 96) as u32]))
    }

    /// Of the product with a factor of 64 bits, both without a sign.
    #[inline(always)]
    pub(super) fn product(self, x: u64, factor: u64) -> Option<i64> {
        // The upper half of the product has one bit more than requested.
        let up = 31 - self.by;
        let [low, high] = [x as u32, (x >> 32) as u32];
        let x = ((high << up << 1 | low >> self.by) as u64) << 32 | (low << up << 1) as u64;
        (high < self.room).then_some(halved(umulhi(x, factor) as i64))
    }

    #[inline(always)]
    fn words(self, [b, c, d]: [u32; 3]) -> i64 {
        // One bit more than requested, then half of (it + 1).
        let join = |low: u32, high: u32| low >> self.by | (high << 1) << (31 - self.by);
        halved(((join(c, d) as u64) << 32 | join(b, c) as u64) as i64)
    }
}

/// Half of a number, to the nearest.
#[inline(always)]
fn halved(twice: i64) -> i64 {
    (twice >> 1).wrapping_add(twice & 1)
}

/// x·2^-shift to the nearest, held in ±[`POWER_PART_MAX_RAW`]; shift from 1 to 127.
#[inline(always)]
pub(super) fn part(x: i128, shift: u32) -> i64 {
    let sign = (x >> 127) as u32;
    let [low, high] = [x as u64, (x >> 64) as u64];
    shifted(high, low, sign, shift)
}

/// The same of a number without a sign; shift from 1 to 128.
#[inline(always)]
pub(super) fn unsigned_part(high: u64, low: u64, shift: u32) -> i64 {
    shifted(high, low, 0, shift)
}

/// x·2^-shift to the nearest, held in ±[`POWER_PART_MAX_RAW`]; the number is sign-extended without
/// end.
#[inline(always)]
fn shifted(high: u64, low: u64, sign: u32, shift: u32) -> i64 {
    // One bit more than requested, then half of (it + 1).
    let shift = shift.wrapping_sub(1);
    let [b, c, d] = [(low >> 32) as u32, high as u32, (high >> 32) as u32];
    // Most numbers of the tick lose between one word and two.
    if shift >> 5 == 1 { cut([b, c, d, sign], sign, shift) } else { cut_words(high, low, sign, shift) }
}

#[inline(never)]
fn cut_words(high: u64, low: u64, sign: u32, shift: u32) -> i64 {
    let [a, b, c, d] = [low as u32, (low >> 32) as u32, high as u32, (high >> 32) as u32];
    let words = match shift >> 5 {
        0 => [a, b, c, d],
        1 => [b, c, d, sign],
        2 => [c, d, sign, sign],
        _ => [d, sign, sign, sign],
    };
    cut(words, sign, shift)
}

/// Without the last bits of the shift, and halved.
#[inline(always)]
fn cut([a, b, c, d]: [u32; 4], sign: u32, shift: u32) -> i64 {
    let by = shift & 31;
    let join = |low: u32, high: u32| low >> by | (high << 1) << (31 - by);
    let (low, high, over) = (join(a, b), join(b, c), (join(c, d) ^ sign) | (join(d, sign) ^ sign));
    // Within ±2^62 the upper bits are all the sign.
    if over | (high ^ sign) >> 30 != 0 {
        return if sign == 0 { POWER_PART_MAX_RAW } else { -POWER_PART_MAX_RAW };
    }
    let twice = ((high as u64) << 32 | low as u64) as i64;
    (twice >> 1).wrapping_add(twice & 1)
}
