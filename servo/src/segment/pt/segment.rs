//! One PT datum: checked, packed into 12 bytes, and what is read from it.
//!
//! In: the bits of the user's double, time and kind, the segments before. Out: a [`Segment`], which
//! only [`Segment::admit`] can make. Fails: with the rule that the datum breaks, [`Refused`].
use crate::math::wide::{Divisor, packed};
use crate::units::{Exact, Pos, StepLimit};

/// What the velocity does inside a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum SegmentKind {
    /// From the end velocity of the segment before, linearly, to 2P/T minus it.
    Normal = 0,
    /// P/T throughout.
    Even = 1,
    /// From 2P/T, linearly, to 0.
    Stop = 2,
}

/// An admitted segment, 12 bytes. Word 0: mantissa, low. Word 1: mantissa, high 20 bits,
/// 7 bits of exponent, sign, kind in bits 28–29. Word 2: end time in ms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment([u32; 3]);

/// Why a PT datum is refused: the parameter, and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// The position is NaN or infinite.
    NotFinite,
    /// |position| above 2⁴⁰ pulses, or the velocities swing further than that inside the segment.
    BeyondTravel,
    /// The time (ms) is not above that of the segment before (0 for the first).
    NotIncreasing {
        /// End time of the segment before.
        before: i32,
    },
    /// A velocity at an end of the segment is above the step limit.
    TooFast {
        /// The velocity in 2⁻²⁰ pulse/ms.
        speed: i64,
    },
    /// The segment type is none of 0, 1, 2.
    Kind,
}

/// What admission needs to know of the segments before: end position, time and velocity.
/// Default is the beginning of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Chain {
    /// End position in 2⁻²⁰ pulse.
    pos: i64,
    /// End time in ms.
    time: i32,
    /// End velocity in 2⁻²⁰ pulse/ms: a check needs no more, the tick has its own.
    velocity: i64,
    /// Duration of the segment in ms, and its reciprocal: a stream's is constant.
    duration: u32,
    inverse: u32,
    /// What rounding may have added to the velocity, in its units: a chain of NORMAL segments
    /// passes it on.
    slack: u32,
}

impl Chain {
    /// End time of what was admitted, in ms.
    pub fn time_ms(&self) -> i32 {
        self.time
    }
}

const CHAIN_BITS: u32 = 20;
/// The bits of the largest |position| as a double: a power of two has an exponent alone.
const TRAVEL_DOUBLE_BITS: u64 = (1023 + Pos::TRAVEL_PULSES.ilog2() as u64) << 52;
/// What rounding adds to 2P/T at most: less than two units of P, and one of the quotient.
const ROUNDING_UNITS: u32 = 3;
/// v0·T beyond 2⁴³ pulses swings out of ±2⁴⁰ even if the segment comes back: the excursion is
/// A²/4(A + |P|) > 2⁴⁰·⁶⁷ for A = 2⁴³ and the largest |P|.
const START_DISPLACEMENT_MAX_PULSES: u64 = 1 << 43;

impl Segment {
    /// The words as stored.
    pub(super) fn words(self) -> [u32; 3] {
        self.0
    }

    /// From stored words; all bit patterns are valid.
    #[inline(always)]
    pub(super) fn from_words(words: [u32; 3]) -> Segment {
        Segment(words)
    }

    /// Checks one datum against those before it and packs it. `pos_bits` are the bits of the double
    /// (pulses from the start of pass or stream). What is known to be faster than `limit` is
    /// refused: by 2⁻²⁰ pulse/ms, in a chain of NORMAL segments by [`ROUNDING_UNITS`] units more a
    /// segment.
    pub fn admit(
        pos_bits: u64,
        time_ms: i32,
        kind: i16,
        before: &Chain,
        limit: StepLimit,
    ) -> Result<(Segment, Chain), Refused> {
        let unsigned = pos_bits & (u64::MAX >> 1);
        let exponent = (unsigned >> 52) as u32;
        let fraction = pos_bits & ((1 << 52) - 1);
        let sign = (pos_bits >> 63) as u32;
        // The bits of doubles of one sign are in the order of the doubles; those that are not
        // finite come after all others.
        if unsigned > TRAVEL_DOUBLE_BITS {
            return Err(if exponent == 0x7ff { Refused::NotFinite } else { Refused::BeyondTravel });
        }
        let kind = match kind {
            0 => SegmentKind::Normal,
            1 => SegmentKind::Even,
            2 => SegmentKind::Stop,
            _ => return Err(Refused::Kind),
        };
        if time_ms <= before.time {
            return Err(Refused::NotIncreasing { before: before.time });
        }
        let packed = packed(unsigned);
        // |pos| in 2^-20: mantissa 2^(e-1075), to be scaled by 2^20. At most 2^60; below exponent
        // 1003 it is 0.
        let mantissa = 1 << 52 | fraction;
        let magnitude = if exponent >= 1003 { (mantissa << 8) >> (1063 - exponent) } else { 0 };
        let pos = if sign == 1 { -(magnitude as i64) } else { magnitude as i64 };
        let duration = (time_ms - before.time) as u32;
        let divisor =
            if duration == before.duration { Divisor::again(duration, before.inverse) } else { Divisor::new(duration) };
        let length = pos - before.pos;
        let twice = divisor.quotient64(length.unsigned_abs() << 1) as i64;
        let twice = if length < 0 { -twice } else { twice };
        // Velocity at the end, and the faster one of those that were not checked with the segment
        // before.
        let (end, speed, (spare, slack)) = match kind {
            SegmentKind::Normal => {
                let (end, slack) = (twice - before.velocity, before.slack.saturating_add(ROUNDING_UNITS));
                (end, end, (slack, slack))
            }
            SegmentKind::Even => (twice >> 1, twice >> 1, (0, ROUNDING_UNITS)),
            SegmentKind::Stop => (0, twice, (0, 0)),
        };
        if speed.unsigned_abs() > (limit.pulses_per_ms() << CHAIN_BITS) + spare as u64 {
            return Err(Refused::TooFast { speed });
        }
        if kind == SegmentKind::Normal
            && (before.velocity.unsigned_abs() >> CHAIN_BITS) * duration as u64 > START_DISPLACEMENT_MAX_PULSES
        {
            return Err(Refused::BeyondTravel);
        }
        let word1 = (packed >> 32) as u32 & 0x07ff_ffff | sign << 27 | (kind as u32) << 28;
        let chain = Chain { pos, time: time_ms, velocity: end, duration, inverse: divisor.inverse(), slack };
        Ok((Segment([packed as u32, word1, time_ms as u32]), chain))
    }

    /// End time in ms from the start of pass or stream.
    #[inline(always)]
    pub fn time_ms(self) -> u32 {
        self.0[2] & 0x7fff_ffff
    }

    /// What the velocity does.
    #[inline(always)]
    pub fn kind(self) -> SegmentKind {
        match self.0[1] >> 28 & 3 {
            1 => SegmentKind::Even,
            2 => SegmentKind::Stop,
            _ => SegmentKind::Normal,
        }
    }

    /// End position, the user's double.
    #[inline(always)]
    pub fn position(self) -> Exact {
        let field = self.0[1] >> 20 & 0x7f;
        let normal = field.min(1);
        let mantissa = ((self.0[1] & 0xf_ffff | normal << 20) as u64) << 32 | self.0[0] as u64;
        let shift = (field - normal) & 63; // 0..=52
        let high = mantissa >> 1 >> (63 - shift);
        let magnitude = ((high as u128) << 64 | (mantissa << shift) as u128) as i128;
        Exact(if self.0[1] >> 27 & 1 == 1 { -magnitude } else { magnitude })
    }
}
