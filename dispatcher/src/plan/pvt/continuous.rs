//! Continuous: one segment split into acceleration, cruise and deceleration (SPEC 5, GXN 4.2).
//!
//! In: displacement, the velocities at both ends, the limits. Out: the durations of the three parts
//! and the peak, to 100 bits, so that the duration of a pass keeps its 64 fraction bits.
//! Fails: no displacement, a velocity above the limit, a distance too short.
use super::double_double::DoubleDouble;
use crate::refuse::{Admitted, Refused};
use protocol::reason::Reason;

/// The user's data from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PointData {
    /// Velocity at its point, pulse/ms, signed.
    pub vel: f64,
    /// Percentage of the ramps.
    pub percent: f64,
    /// Magnitude limits: pulse/ms and pulse/ms².
    pub vel_max: f64,
    /// Acceleration.
    pub acc: f64,
    /// Deceleration.
    pub dec: f64,
}

/// A segment in three parts; a part that does not exist has duration 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Split {
    /// Durations of acceleration, cruise and deceleration, ms.
    pub times: [DoubleDouble; 3],
    /// Displacement of the acceleration, signed.
    pub rise: f64,
    /// Displacement of the deceleration, signed.
    pub fall: f64,
    /// Velocity between the ramps, signed.
    pub peak: f64,
}

/// A part below this share of the whole is left out. The doubles 0.01 and 0.02 are not the decimal
/// numbers; the difference must make neither a ramp nor a refusal.
const PART_MIN_SHARE: f64 = 1.0 / (1u64 << 46) as f64;

/// Splits the displacement `length` (not 0) from `phase`'s point to one with velocity `end`. A
/// refusal names the field of the item by its index in the request's arrays.
pub fn split(phase: &PointData, length: DoubleDouble, end: f64) -> Admitted<Split> {
    if length.high == 0.0 {
        return Err(Refused::new(Reason::NoDisplacement));
    }
    let sign = if length.high < 0.0 { -1.0 } else { 1.0 };
    let l = length.times(sign);
    let (u0, u1) = (sign * phase.vel, sign * end);
    for (vel, u) in [(phase.vel, u0), (end, u1)] {
        if u > phase.vel_max {
            return Err(Refused::new(Reason::AboveVelMax).got(vel).limits(-phase.vel_max, phase.vel_max));
        }
    }
    let square = |x: f64| DoubleDouble::from(x).times(x);
    let (a, d, top) = (phase.acc, phase.dec, DoubleDouble::from(phase.vel_max));
    let both = DoubleDouble::from(a).plus(d);
    let (q0, q1) = (square(u0), square(u1));
    // peak² − u0² = a·up/(a + d), peak² − u1² = d·down/(a + d)
    let up = l.times(2.0 * d).plus(q1.minus(q0));
    let down = l.times(2.0 * a).plus(q0.minus(q1));
    let slack = |acc: f64| PART_MIN_SHARE * (2.0 * acc * l.high + q0.high + q1.high);
    let zero = DoubleDouble::default();
    let part = |times: [DoubleDouble; 3], rise: DoubleDouble, fall: DoubleDouble, peak: f64| {
        Ok(Split { times, rise: sign * rise.high, fall: sign * fall.high, peak: sign * peak })
    };
    let unreachable = |acc: f64| {
        // The distance that the change of velocity needs.
        let needed = q0.minus(q1).high.abs() / (2.0 * acc);
        Err(Refused::new(Reason::VelocityUnreachable).got(length.high).limits(needed, f64::INFINITY))
    };
    if u0 > 0.0 && up.high < -slack(d) {
        return unreachable(d);
    }
    if u1 > 0.0 && down.high < -slack(a) {
        return unreachable(a);
    }
    if u0 > 0.0 && up.high <= slack(d) {
        return part([zero, zero, l.times(2.0).over(DoubleDouble::from(u0).plus(u1))], zero, l, u0);
    }
    if u1 > 0.0 && down.high <= slack(a) {
        return part([l.times(2.0).over(DoubleDouble::from(u0).plus(u1)), zero, zero], l, zero, u1);
    }
    let distance = |from: f64, peak: DoubleDouble, acc: f64| peak.minus(from).times(peak.plus(from)).over(2.0 * acc);
    let peak2 = l.times(2.0 * a).times(d).plus(q0.times(d)).plus(q1.times(a)).over(both);
    let over = peak2.minus(square(phase.vel_max));
    if over.high > PART_MIN_SHARE * peak2.high {
        let (rise, fall) = (distance(u0, top, a), distance(u1, top, d));
        let cruise = l.minus(rise).minus(fall).over(top);
        return part([top.minus(u0).over(a), cruise, top.minus(u1).over(d)], rise, fall, phase.vel_max);
    }
    let peak = peak2.sqrt();
    // Differences of nearly equal speeds come from the distance, not from the root.
    let time = |from: f64, gap: DoubleDouble, acc: f64| {
        if from > 0.0 { gap.over(both.times(peak.plus(from))) } else { peak.minus(from).over(acc) }
    };
    let (rise, fall) = (distance(u0, peak, a), distance(u1, peak, d));
    part([time(u0, up, a), zero, time(u1, down, d)], rise, fall, peak.high)
}

impl Split {
    /// Duration of the whole.
    pub fn duration(&self) -> DoubleDouble {
        let [acc, cruise, dec] = self.times;
        acc.plus(cruise).plus(dec)
    }

    /// Whether part `index` is long enough to be a part.
    pub fn has(&self, index: usize) -> bool {
        self.times.get(index).is_some_and(|time| time.high > PART_MIN_SHARE * self.duration().high)
    }
}
