//! Exact lengths: whole multiples of 10⁻¹⁵ mm.
//!
//! In: decimal numbers of a program. Out: positions in pulses, rounded once. A number keeps 15
//! decimals; of an inch 14 are exact. What lies exactly between two pulses goes away from zero.
use machine::{Axis, STEP_DECIMALS};

/// One mm, or the number 1.
pub const ONE: i128 = 1_000_000_000_000_000;
/// Decimals that are kept.
pub const DECIMALS: u32 = 15;
/// Digits before the point, at most.
pub const MAX_WHOLE_DIGITS: usize = 9;

/// A quotient, rounded to the nearest; halves away from zero.
pub fn rounded(number: i128, by: i128) -> i128 {
    let half = by / 2;
    if number < 0 { -((-number + half) / by) } else { (number + half) / by }
}

/// The same by a number that may be below 0.
fn rounded_any(number: i128, by: i128) -> i128 {
    if by < 0 { rounded(-number, -by) } else { rounded(number, by) }
}

/// Inches as mm.
pub fn inches(number: i128) -> i128 {
    rounded(number * 254, 10)
}

/// A finite number as the decimal that is printed for it.
pub fn of_f64(number: f64) -> i128 {
    let text = format!("{}", number.abs());
    let (whole, decimals) = text.split_once('.').unwrap_or((&text, ""));
    let digits = decimals.bytes().chain(std::iter::repeat(b'0')).take(DECIMALS as usize);
    let value = whole.bytes().chain(digits).fold(0i128, |value, digit| value * 10 + i128::from(digit - b'0'));
    if number < 0.0 { -value } else { value }
}

/// As a floating-point number, mm.
pub fn to_f64(value: i128) -> f64 {
    value as f64 / ONE as f64
}

/// What an axis counts at machine positions.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// 10⁹ times the pulses a mm; below 0 where the axis is reversed.
    steps: i128,
    /// Pulses a mm, with sign.
    pub per_mm: f64,
}

impl Scale {
    pub fn of(axis: &Axis) -> Scale {
        let steps = of_f64(axis.steps_per_mm) / 10i128.pow(DECIMALS - STEP_DECIMALS);
        let sign = if axis.reversed { -1 } else { 1 };
        Scale { steps: steps * sign, per_mm: axis.steps_per_mm * sign as f64 }
    }

    /// Where a pulse is, in mm.
    pub fn mm(&self, pulses: f64) -> i128 {
        let whole = pulses.round();
        let exact = rounded_any(whole as i128 * 10i128.pow(DECIMALS + STEP_DECIMALS), self.steps);
        exact + ((pulses - whole) / self.per_mm * ONE as f64) as i128
    }

    /// The pulse nearest to a position.
    pub fn pulses(&self, mm: i128) -> i64 {
        // A travel is within 10⁵ mm and 2·10⁹ pulses: 10²⁰ · 10¹⁴ fits.
        rounded(mm * self.steps, 10i128.pow(DECIMALS + STEP_DECIMALS)) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_go_away_from_zero() {
        assert_eq!([(5, 10), (4, 10), (-5, 10), (-4, 10), (15, 10)].map(|(a, b)| rounded(a, b)), [1, 0, -1, 0, 2]);
    }

    #[test]
    fn a_pulse_has_a_position_and_the_position_that_pulse() {
        for steps in [100_000_000_000, -126_666_666_667, 1_000_000, 99_999_999_999_999] {
            let scale = Scale { steps, per_mm: steps as f64 / 1e9 };
            for pulse in [0i64, 1, -1, 7, 123_456, -1_999_999_999] {
                if (pulse as f64 / scale.per_mm).abs() < 1e5 {
                    assert_eq!(scale.pulses(scale.mm(pulse as f64)), pulse, "{steps}");
                }
            }
            assert_eq!(to_f64(scale.mm(0.25)), to_f64((0.25 / scale.per_mm * 1e15) as i128));
        }
    }

    #[test]
    fn decimals_and_inches_are_exact() {
        assert_eq!(of_f64(-0.1), -ONE / 10);
        assert_eq!(of_f64(80.123_456_789), 80_123_456_789 * ONE / 1_000_000_000);
        assert_eq!(inches(ONE / 1000), 254 * ONE / 10_000);
    }
}
