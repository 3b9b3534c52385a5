//! The asymmetric S-curve of FollowDataPercent2Ex: a segment whose ratio changes from one given
//! value to another. In a first part of it the slope of the ratio rises, in a last part it falls.
//!
//! With the segment's length as 1, the slope of the ratio rises from 0 over the share x, holds, and
//! falls to 0 over q − x, where q is the sum of both (percent/100). With Δ the change of the ratio,
//! the slope holds at Δ/(1 − q/2). The mean of the ratio, which is slave displacement by master
//! displacement, is
//!
//! begin + Δ·(1/2 − x/2 + q(2x − q)/6)/(1 − q/2).
//!
//! It is linear in x, so the displacement decides x. Equal shares give the curve of
//! FollowDataPercentEx.

/// Mean of the ratio.
pub fn mean(begin: f64, end: f64, q: f64, x: f64) -> f64 {
    begin + (end - begin) * ((0.5 - x / 2.0 + q * (2.0 * x - q) / 6.0) / (1.0 - q / 2.0))
}

/// The share x that gives this mean, or the lowest and the highest possible mean. If the ratio does
/// not change there is only one mean, and any x is right: the half of q.
pub fn share(begin: f64, end: f64, q: f64, wanted: f64) -> Result<f64, (f64, f64)> {
    let (one, other) = (mean(begin, end, q, 0.0), mean(begin, end, q, q));
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    // A value outside by rounding alone counts as the bound.
    let rounding = 8.0 * f64::EPSILON * (begin.abs() + end.abs());
    if !(wanted >= low - rounding && wanted <= high + rounding) {
        return Err((low, high));
    }
    if one == other {
        return Ok(q / 2.0);
    }
    let x = q * ((one - wanted) / (one - other));
    // Not `clamp`, which panics if a bound is NaN.
    Ok(x.max(0.0).min(q))
}

/// Start and end of the constant part, as parts of the segment. For each also the mean of the ratio
/// from the start of the segment to there.
pub fn corners(begin: f64, end: f64, q: f64, x: f64) -> [(f64, f64); 2] {
    let slope = (end - begin) / (1.0 - q / 2.0);
    let (first, last) = (x, 1.0 - (q - x));
    // Slave displacement: from the start over the rising slope; from the end backwards over the
    // falling one.
    let to_first = begin * first + slope * first * first / 6.0;
    let constant = (last - first) * (begin + slope * first / 2.0) + slope * (last - first) * (last - first) / 2.0;
    [(first, to_first), (last, to_first + constant)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by summing the slope twice, in many steps.
    fn summed(begin: f64, end: f64, q: f64, x: f64, upto: f64) -> f64 {
        let steps = 200_000;
        let constant = (end - begin) / (1.0 - q / 2.0);
        let (mut ratio, mut slave) = (begin, 0.0);
        let h = upto / f64::from(steps);
        for step in 0..steps {
            let u = (f64::from(step) + 0.5) * h;
            let y = q - x;
            let slope = if u < x {
                constant * u / x
            } else if u > 1.0 - y {
                constant * (1.0 - u) / y
            } else {
                constant
            };
            slave += (ratio + slope * h / 2.0) * h;
            ratio += slope * h;
        }
        slave
    }

    #[test]
    fn the_mean_is_what_summing_gives() {
        for (begin, end, q, x) in [
            (0.0, 1.0, 1.0, 0.5),
            (0.25, -2.0, 0.6, 0.1),
            (1.0, 3.0, 0.4, 0.4),
            (3.0, 1.0, 1.0, 1.0),
            (0.0, 2.0, 0.0, 0.0),
        ] {
            let (wanted, got) = (summed(begin, end, q, x, 1.0), mean(begin, end, q, x));
            assert!((wanted - got).abs() < 1e-8, "{begin} {end} {q} {x}: {wanted} {got}");
            for (at, slave) in corners(begin, end, q, x) {
                let wanted = summed(begin, end, q, x, at);
                assert!((wanted - slave).abs() < 1e-8, "{begin} {end} {q} {x} at {at}: {wanted} {slave}");
            }
        }
        // By hand: equal shares are symmetric, so the mean is that of the ends; pure S from one end
        // only: 1/3, 2/3.
        assert_eq!(mean(0.0, 1.0, 0.8, 0.4), 0.5);
        assert!((mean(0.0, 1.0, 1.0, 0.0) - 2.0 / 3.0).abs() < 1e-15);
        assert!((mean(0.0, 1.0, 1.0, 1.0) - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn the_share_is_the_one_that_gives_the_mean() {
        for (begin, end, q) in [(0.0, 1.0, 1.0), (2.0, -1.0, 0.5), (0.1, 0.7, 0.01)] {
            for part in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let x = q * part;
                let found = share(begin, end, q, mean(begin, end, q, x)).unwrap();
                assert!((found - x).abs() < 1e-12, "{begin} {end} {q} {x}: {found}");
            }
        }
        assert_eq!(share(1.0, 1.0, 0.6, 1.0), Ok(0.3));
        let (low, high) = share(0.0, 1.0, 1.0, 0.7).unwrap_err();
        assert!((low - 1.0 / 3.0).abs() < 1e-15 && (high - 2.0 / 3.0).abs() < 1e-15);
        assert!(share(0.0, 1.0, 0.0, 0.5).is_ok() && share(0.0, 1.0, 0.0, 0.51).is_err());
        assert!(share(0.0, 1.0, 0.5, f64::NAN).is_err());
    }
}
