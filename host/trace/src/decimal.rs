//! Fixed point to decimal text by exact integers, the same on every machine.
//!
//! In: a position in 2⁻²² pulse, a velocity, power or frequency m·2^-e, a time in ns. Out: a number
//! with six decimals, rounded half away from zero; zero has no sign. It cannot fail.
use servo::segment::piece::Scaled;
use servo::units::Pos;

const MILLION: u128 = 1_000_000;

/// Six decimals of a count of millionths.
fn millionths(negative: bool, value: u128) -> String {
    let sign = if negative && value != 0 { "-" } else { "" };
    format!("{sign}{}.{:06}", value / MILLION, value % MILLION)
}

/// A position in pulses.
pub fn position(pos: Pos) -> String {
    let scaled = u128::from(pos.0.unsigned_abs()) * MILLION;
    millionths(pos.0 < 0, (scaled + (1 << (Pos::FRAC_BITS - 1))) >> Pos::FRAC_BITS)
}

/// A velocity in pulse/ms, a power in its unit, a frequency in kHz.
pub fn scaled(v: Scaled) -> String {
    // |m| · 10⁶ is below 2⁸⁴: from e = 85 on everything rounds to zero, and a velocity that the
    // controller can hold (2³² pulse/ms) never needs more than 44 bits of left shift.
    let scaled = u128::from(v.m.unsigned_abs()) * MILLION;
    let rounded = match v.e {
        ..=0 => scaled << u32::from(v.e.unsigned_abs()).min(44),
        1..=84 => (scaled + (1 << (v.e - 1))) >> v.e,
        85.. => 0,
    };
    millionths(v.m < 0, rounded)
}

/// A time in ms.
pub fn milliseconds(ns: u64) -> String {
    millionths(false, u128::from(ns))
}

/// A position as a number for drawing.
pub fn position_f64(pos: Pos) -> f64 {
    pos.0 as f64 / f64::from(1u32 << Pos::FRAC_BITS)
}

/// The same as a number for drawing.
pub fn scaled_f64(v: Scaled) -> f64 {
    v.m as f64 * f64::from(-i32::from(v.e)).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_by_hand() {
        let one = 1i64 << 22;
        for (pos, text) in [
            (0, "0.000000"),
            (one, "1.000000"),
            (-one, "-1.000000"),
            (one / 2, "0.500000"),
            (1, "0.000000"), // 2⁻²² = 0.000000238
            (-1, "0.000000"),
            (2, "0.000000"), // 0.000000477
            (3, "0.000001"), // 0.000000715
            (-3, "-0.000001"),
            (4096 * one + one / 3, "4096.333333"),
            (i64::MIN, "-2199023255552.000000"),
        ] {
            assert_eq!(position(Pos(pos)), text, "{pos}");
        }
    }

    #[test]
    fn velocities_by_hand() {
        for (m, e, text) in [
            (0, 0, "0.000000"),
            (2, 0, "2.000000"),
            (1, -32, "4294967296.000000"),
            (-1, 1, "-0.500000"),
            (1, 20, "0.000001"), // 0.00000095
            (1, 21, "0.000000"), // 0.00000048
            (-1, 21, "0.000000"),
            (1 << 62, 61, "2.000000"),
            (i64::MAX, 63, "1.000000"),
            (i64::MIN, 63, "-1.000000"),
            (i64::MAX, 200, "0.000000"),
            (i64::MAX, 84, "0.000000"), // 4.8e-7
        ] {
            assert_eq!(scaled(Scaled { m, e }), text, "{m} * 2^-{e}");
        }
    }

    #[test]
    fn times_have_six_decimals() {
        assert_eq!(milliseconds(0), "0.000000");
        assert_eq!(milliseconds(250_000), "0.250000");
        assert_eq!(milliseconds(3_072_050_001), "3072.050001");
    }
}
