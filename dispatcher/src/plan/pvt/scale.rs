//! From the user's doubles to the units of a table, by integers alone.
//!
//! In: knots in ms, pulse and pulse/ms from the first point. Out: a header and points. Fails: if no
//! scale holds the table.
use super::scratch::{Scratch, TablePoint};
use crate::refuse::{Admitted, Refused};
use protocol::reason::Reason;
use servo::segment::pvt::{Header, POINT_WORDS, POS_BITS, Point, TIME_BITS, VEL_BITS};
use servo::units::Exact;

/// x·n·2^bits to the nearest whole number, saturating at ±2¹²⁶; NaN is 0. n below 2²⁰.
fn fixed(x: f64, n: u32, bits: i32) -> i128 {
    let raw = x.to_bits();
    let exponent = (raw >> 52 & 0x7ff) as i32;
    let fraction = raw & ((1 << 52) - 1);
    if exponent == 0x7ff {
        return 0;
    }
    let mantissa = if exponent == 0 { fraction } else { 1 << 52 | fraction };
    let wide = mantissa as u128 * n as u128; // below 2^73
    let shift = exponent.max(1) - 1075 + bits;
    let magnitude = match shift {
        54.. if wide != 0 => 1 << 126,
        0.. => wide << (shift & 63),
        -127..=-1 => {
            let twice = wide >> (-shift - 1);
            (twice >> 1) + (twice & 1)
        }
        _ => 0,
    } as i128;
    if x < 0.0 { -magnitude } else { magnitude }
}

/// A time in ms as 2⁻⁶⁴ ns.
pub fn instant(ms: f64) -> i128 {
    fixed(ms, 1_000_000, 64)
}

/// A position in pulses as 2⁻⁶⁴ pulse.
pub fn exact(pulses: f64) -> i128 {
    fixed(pulses, 1, 64)
}

/// The most fraction bits, not above `most`, with which |x|·n stays below 2^width.
fn bits_for(x: f64, n: u32, width: u32, most: i32) -> i32 {
    let mut bits = most;
    let used = 128 - fixed(x, n, 48).unsigned_abs().leading_zeros() as i32; // |x|·n < 2^(used − 48)
    bits = bits.min(width as i32 + 48 - used);
    if fixed(x, n, bits).unsigned_abs() >> width != 0 { bits - 1 } else { bits }
}

/// The points of a table that is complete in the scratch memory.
#[derive(Debug, Clone, Copy)]
pub struct Sealed {
    header: Header,
}

/// Values of the whole table that do not come from the knots.
#[derive(Debug, Clone, Copy)]
pub struct Totals {
    /// Time of the first point in 2⁻⁶⁴ ns.
    pub delay: i128,
    /// Duration in 2⁻⁶⁴ ns.
    pub duration: i128,
    /// Displacement in 2⁻⁶⁴ pulse.
    pub displacement: i128,
}

impl Sealed {
    /// Chooses the scales.
    pub fn of(scratch: &Scratch<'_>, totals: Totals) -> Admitted<Sealed> {
        let (mut pos, mut vel) = (0f64, 0f64);
        for knot in scratch.knots() {
            pos = pos.max(knot.pos.abs());
            vel = vel.max(knot.vel.abs());
        }
        let refuse = || Refused::new(Reason::TableRange).got(vel);
        let duration = u128::try_from(totals.duration).unwrap_or(0).max(1);
        let mut header = Header {
            points: scratch.used() as u16,
            time_bits: time_bits(duration),
            pos_bits: bits_for(pos, 1, POS_BITS - 1, 62) as i8,
            vel_bits: bits_for(vel, 1, VEL_BITS - 1, 62) as i8,
            lift: 0,
            delay: u128::try_from(totals.delay).unwrap_or(u128::MAX),
            duration,
            displacement: Exact(totals.displacement),
            rate: (u128::MAX / duration).min(u64::MAX as u128) as u64,
        };
        let (mut longest, mut furthest) = (0, 0);
        let sealed = Sealed { header };
        for index in 1..sealed.points() {
            if let (Some(a), Some(b)) = (sealed.scaled(scratch, index - 1), sealed.scaled(scratch, index)) {
                longest = longest.max(b.time.saturating_sub(a.time));
                furthest = furthest.max((b.pos - a.pos).unsigned_abs());
            }
        }
        // The longest segment keeps its top bit, as far as displacements stay below 2^59. More than
        // 84 fraction bits are of no use; beyond that the velocity needs no bits either.
        header.lift = longest.leading_zeros().min(63) as u8;
        let room = 59 - (64 - furthest.leading_zeros() as i32) + header.pos_bits as i32;
        let excess = (header.frac() - room.min(84)).max(0);
        let less = excess.min(header.lift as i32);
        header.lift -= less as u8;
        header.vel_bits -= (excess - less) as i8;
        // Only the product of the fastest speed and the longest segment can be too large here.
        match header.admit() {
            Some(_) => Ok(Sealed { header }),
            None => Err(refuse()),
        }
    }

    /// The header, for the store; it has been admitted.
    pub fn header(&self) -> Header {
        self.header
    }

    /// Points in use.
    pub fn points(&self) -> u32 {
        self.header.points as u32
    }

    /// Point `index` as stored.
    pub fn point(&self, scratch: &Scratch<'_>, index: u32) -> Option<[u32; POINT_WORDS]> {
        self.scaled(scratch, index)?.admit()
    }

    fn scaled(&self, scratch: &Scratch<'_>, index: u32) -> Option<Point> {
        let header = &self.header;
        let TablePoint { time, pos, vel } = scratch.knot(index as usize)?;
        let time = if index + 1 == self.points() {
            end_time(header.duration, header.time_bits)
        } else {
            fixed(time, 1_000_000, header.time_bits as i32) as u64
        };
        let pos = fixed(pos, 1, header.pos_bits as i32) as i64;
        Some(Point { time, pos, vel: fixed(vel, 1, header.vel_bits as i32) as i64 })
    }
}

/// A duration in 2^-bits ns, rounded up: the tick divides by it and must stay below 1.
fn end_time(duration: u128, bits: i8) -> u64 {
    let shift = (64 - bits as i32) as u32 & 127;
    ((duration >> shift) + (duration << (128 - shift) != 0) as u128) as u64
}

/// The most fraction bits of ns, not above 32, with which a duration fits.
fn time_bits(duration: u128) -> i8 {
    let used = 64 - duration.leading_zeros() as i32; // duration < 2^used ns
    let bits = (TIME_BITS as i32 - used).min(32) as i8;
    if end_time(duration, bits) >> TIME_BITS != 0 { bits - 1 } else { bits }
}
