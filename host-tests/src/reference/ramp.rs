//! Trap, Jog and the smooth Stop: functions of time that begin at a velocity.
use super::curve::Curve;
use super::number::{Fix, root};
use super::rational::Rational;

fn zero() -> Rational {
    Rational::zero()
}

struct Plan {
    curve: Curve,
    v: Rational,
}

impl Plan {
    fn from(v: Fix) -> Plan {
        Plan { curve: Curve::default(), v: v.rational() }
    }

    /// From the present velocity to `v` with an acceleration of this magnitude.
    fn to(&mut self, v: &Rational, acc: &Rational) {
        let change = v - &self.v;
        let length = change.abs() / acc;
        let acc = if change.is_negative() { -acc } else { acc.clone() };
        self.curve.cubic(&length, &self.v, &acc, &zero());
        self.v = v.clone();
    }
}

/// Brakes to rest.
pub fn stop(v: Fix, dec: f64) -> Curve {
    let mut plan = Plan::from(v);
    plan.to(&zero(), &super::number::exact(dec));
    plan.curve
}

/// Goes on at `vel` for ever: faster with `acc`, slower with `dec`, through rest where it turns.
pub fn jog(v: Fix, vel: f64, acc: &Rational, dec: &Rational) -> Curve {
    let mut plan = Plan::from(v);
    let vel = super::number::exact(vel);
    if (&plan.v * &vel).is_negative() {
        plan.to(&zero(), dec);
    }
    let slower = vel.abs() < plan.v.abs();
    plan.to(&vel, if slower { dec } else { acc });
    plan.curve.cruise = Fix::of(&vel);
    plan.curve.steepest = plan.curve.steepest.max(plan.curve.cruise.abs());
    plan.curve
}

/// Goes by `way` and rests there; without a velocity it brakes.
pub fn trap(v: Fix, displacement: Fix, vel: &Rational, acc: &Rational, dec: &Rational) -> Curve {
    let mut plan = Plan::from(v);
    if vel.is_zero() {
        plan.to(&zero(), dec);
        return plan.curve;
    }
    let two = Rational::from_integer(2.into());
    loop {
        let left = (displacement - plan.curve.end()).rational();
        let up = if left.is_zero() { plan.v.is_positive() } else { left.is_positive() };
        let sign = Rational::from_integer(if up { 1 } else { -1 }.into());
        let speed = &plan.v * &sign;
        let room = &left * &sign;
        if room.is_zero() && speed.is_zero() {
            break;
        }
        // It goes the other way, or cannot stop in time: rest first.
        if speed.is_negative() || &speed * &speed / (&two * dec) > room {
            plan.to(&zero(), dec);
            continue;
        }
        let peak = if speed > *vel {
            plan.to(&(vel * &sign), dec);
            vel.clone()
        } else {
            let square = (&two * acc * dec * &room + dec * &speed * &speed) / (acc + dec);
            let peak = root(&square).rational().min(vel.clone());
            plan.to(&(&peak * &sign), acc);
            peak
        };
        let left = ((displacement - plan.curve.end()).rational() * &sign) - &peak * &peak / (&two * dec);
        // Rounding of the root leaves less than nothing at times.
        if left.is_positive() && peak.is_positive() {
            plan.curve.cubic(&(left / &peak), &(&peak * &sign), &zero(), &zero());
        }
        plan.to(&zero(), dec);
        break;
    }
    plan.curve.ends_at(displacement);
    plan.curve
}

/// What rounding makes of the end of [`trap`], ms, where it begins as it brakes for its target.
///
/// Position and velocity have 2⁻²² each, so that it may come short or pass the target by `apart`.
/// Then it goes the remainder from standstill or nearly so, for at most √(2·apart·(1/acc + 1/dec)).
pub fn blur(v: Fix, displacement: Fix, acc: f64, dec: f64) -> Fix {
    let [v, displacement] = [v, displacement].map(Fix::to_f64);
    let apart = 2f64.powi(-22) * (1.0 + v.abs() / dec);
    if v == 0.0 || (displacement * v.signum() - v * v / (2.0 * dec)).abs() > apart {
        return Fix::ZERO;
    }
    Fix::of_f64((2.0 * apart * (1.0 / acc + 1.0 / dec)).sqrt())
}
