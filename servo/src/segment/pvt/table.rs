//! What a PVT table is in memory: points of 16 bytes and a header, packed and unpacked.
//!
//! In: integers that the dispatcher scaled. Out: words for the stores, and back. Owns nothing.
//! Fails: [`Point::admit`] and [`Header::admit`] take only what fits; all stored words can be read.
//!
//! A point holds 44 bits of time, 44 of position and 40 of velocity, each in a unit that is a power
//! of two and belongs to the table. With peak speed V and duration T, half a unit of time moves a
//! point by V·T·2⁻⁴⁴. Half a unit of position is at most V·T·2⁻⁴³. Half a unit of velocity at both
//! ends moves the middle of a segment by V·T·2⁻⁴¹. Together that is 0.69 of what SPEC 11 allows.
//! Why these widths: decision 6.
use crate::math::wide::umulhi;
use crate::units::Exact;

/// Points of a table.
pub const TABLE_POINTS: usize = 1024;
/// Words of a point.
pub const POINT_WORDS: usize = 4;
/// Words of a header; the last one counts how often it was written.
pub const HEADER_WORDS: usize = 17;
/// The word that counts how often a header was written.
pub(crate) const VERSION: usize = HEADER_WORDS - 1;
/// Bits of a point's time.
pub const TIME_BITS: u32 = 44;
/// Bits of a point's position with its sign.
pub const POS_BITS: u32 = 44;
/// Bits of a point's velocity with its sign.
pub const VEL_BITS: u32 = 40;
/// The shortest pass, 1 µs: a tick may hold many passes, but their number has a bound.
pub const SHORTEST_PASS_NS: u64 = 1000;
/// A pass or a delay is shorter than this: more than two years.
pub const LONGEST_NS: u64 = 1 << 56;

/// One knot, in the table's units: time and position from the first point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Point {
    /// Time, [`TIME_BITS`] bits; that of the last point must not be before the duration.
    pub time: u64,
    /// Position, [`POS_BITS`] bits.
    pub pos: i64,
    /// Velocity, [`VEL_BITS`] bits.
    pub vel: i64,
}

impl Point {
    /// Packs a point: word 0 time, word 2 position, word 3 velocity, low halves; word 1 has the
    /// rest: time in bits 0–11, velocity in 12–19, position in 20–31. `None` if something does not
    /// fit.
    pub fn admit(self) -> Option<[u32; POINT_WORDS]> {
        let fits = |x: i64, bits: u32| x >> (bits - 1) == 0 || x >> (bits - 1) == -1;
        if self.time >> TIME_BITS != 0 || !fits(self.pos, POS_BITS) || !fits(self.vel, VEL_BITS) {
            return None;
        }
        let high = (self.time >> 32) as u32 | ((self.vel >> 32) as u32 & 0xff) << 12 | ((self.pos >> 32) as u32) << 20;
        Some([self.time as u32, high, self.pos as u32, self.vel as u32])
    }

    /// Unpacks a point.
    #[inline(always)]
    pub fn from_words(words: [u32; POINT_WORDS]) -> Point {
        let [time, high, pos, vel] = words;
        let vel_high = (high << 12) as i32 >> 24;
        Point {
            time: time_of([time, high]),
            pos: ((high as i32 >> 20) as i64) << 32 | pos as i64,
            vel: (vel_high as i64) << 32 | vel as i64,
        }
    }
}

/// Time of a point from its first two words.
#[inline(always)]
pub fn time_of(words: [u32; 2]) -> u64 {
    ((words[1] & 0xfff) as u64) << 32 | words[0] as u64
}

/// What holds for a table as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Header {
    /// Points in use, 2…1024; 0 is an empty table.
    pub points: u16,
    /// Unit of time is 2^-`time_bits` ns, −13…32.
    pub time_bits: i8,
    /// Unit of position is 2^-`pos_bits` pulse, 1…62.
    pub pos_bits: i8,
    /// Unit of velocity is 2^-`vel_bits` pulse/ms, 6…62.
    pub vel_bits: i8,
    /// Lengths of segments are shifted up by this many bits before they are multiplied, 0…63. The
    /// longest one must keep its top bit, and all displacements and velocity × length must stay
    /// below 2⁵⁹ in units of 2^-[`Header::frac`].
    pub lift: u8,
    /// Time of the first point, in 2⁻⁶⁴ ns.
    pub delay: u128,
    /// Duration of a pass in 2⁻⁶⁴ ns.
    pub duration: u128,
    /// Displacement of a pass.
    pub displacement: Exact,
    /// floor(2⁶⁴ / duration in ns), so that the tick can count passes without dividing.
    pub rate: u64,
}

impl Header {
    /// Checks and packs a header.
    pub fn admit(self) -> Option<[u32; HEADER_WORDS]> {
        let in_range = (2..=TABLE_POINTS as u16).contains(&self.points)
            && (-13..=32).contains(&self.time_bits)
            && (1..=62).contains(&self.pos_bits)
            && (6..=62).contains(&self.vel_bits)
            && self.lift <= 63
            && (0..=84).contains(&self.frac())
            && (SHORTEST_PASS_NS as u128) << 64 <= self.duration
            && self.duration < (LONGEST_NS as u128) << 64
            && self.delay < (LONGEST_NS as u128) << 64;
        if !in_range {
            return None;
        }
        let mut words = [0; HEADER_WORDS];
        words[0] = self.points as u32 | (self.lift as u32) << 16;
        words[1] = self.time_bits as u8 as u32 | (self.pos_bits as u32) << 8 | (self.vel_bits as u32) << 16;
        let wide = [self.delay, self.duration, self.displacement.0 as u128, self.rate as u128];
        for (i, word) in words.iter_mut().skip(2).enumerate() {
            *word = wide.get(i / 4).map_or(0, |x| (x >> (i % 4 * 32)) as u32);
        }
        Some(words)
    }

    /// Unpacks a header.
    #[inline(always)]
    pub fn from_words(w: [u32; HEADER_WORDS]) -> Header {
        let wide = |i: [u32; 4]| (i[3] as u128) << 96 | (i[2] as u128) << 64 | (i[1] as u128) << 32 | i[0] as u128;
        Header {
            points: w[0] as u16,
            time_bits: w[1] as i8,
            pos_bits: (w[1] >> 8) as i8,
            vel_bits: (w[1] >> 16) as i8,
            lift: (w[0] >> 16) as u8,
            delay: wide([w[2], w[3], w[4], w[5]]),
            duration: wide([w[6], w[7], w[8], w[9]]),
            displacement: Exact(wide([w[10], w[11], w[12], w[13]]) as i128),
            rate: (w[15] as u64) << 32 | w[14] as u64,
        }
    }

    /// Fraction bits of the coefficients of every piece of this table.
    #[inline(always)]
    pub fn frac(&self) -> i32 {
        self.lift as i32 + self.vel_bits as i32 + self.time_bits as i32 - 25
    }

    /// A time of the table in 2⁻⁶⁴ ns.
    #[inline(always)]
    pub fn span(&self, time: u64) -> u128 {
        // 32 fraction bits and more are in the constant part of the shift.
        let s = (32 - self.time_bits as i32) as u32 & 63; // 0..=45
        let (high, low) = (time >> 1 >> (63 - s), time << s);
        ((high << 32 | low >> 32) as u128) << 64 | (low << 32) as u128
    }

    /// 2⁻⁶⁴ ns in units of time, rounded down.
    #[inline(always)]
    pub fn units(&self, span: u128) -> u64 {
        let s = (32 - self.time_bits as i32) as u32 & 63; // 0..=45
        let (high, low) = ((span >> 64) as u64, span as u64);
        (high << 32 | low >> 32) >> s | (high >> 32) << 1 << (63 - s)
    }

    /// Whole passes in `span`.
    #[inline(never)]
    pub fn passes_in(&self, span: u128) -> u32 {
        let mut n = umulhi((span >> 64) as u64, self.rate).min(u32::MAX as u64 - 4) as u32;
        // The rate and the time were cut off: the count is at most two short.
        for _ in 0..3 {
            let next = self.duration.wrapping_mul(n as u128 + 1);
            if next > span {
                break;
            }
            n += 1;
        }
        n
    }
}
