//! The speed that a Trap can reach over its distance.
//!
//! In: the remaining distance, the speed at its beginning, the parameters. Out: whether to brake
//! first, and the peak speed. All are magnitudes along the distance; nothing here depends on
//! instants.
use super::rate::{Accel, Acceleration, Speed};
use crate::math::float::Float;
use crate::units::Ns;

state! {
    /// Parameters of a Trap.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Trapezoid {
        /// Target, pulses.
        pub target: i32 = 0,
        /// Cruising speed; its magnitude counts.
        pub speed: Speed = Speed::NONE,
        /// Acceleration, not 0.
        pub acc: Accel = Accel::NONE,
        /// Deceleration, not 0.
        pub dec: Accel = Accel::NONE,
        /// Velocity at which a start from rest begins, at most `speed`. Not used where the axis
        /// could not stop from it within the distance.
        pub vel_start: Speed = Speed::NONE,
        /// Length of the moving average over each velocity ramp.
        pub smooth: Ns = Ns(0),
    }
    /// At power-on.
    pub(crate) const POWER_ON;
}

/// Rates and smoothing of a Trap. The time of a ramp is Δv/rate + `wait`.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrapRates {
    pub(super) acc: Acceleration,
    pub(super) dec: Acceleration,
    /// Length of the moving average, ms.
    pub(super) wait: Float,
}

impl TrapRates {
    /// Twice the distance of a stop from `u`.
    pub(super) fn stop(&self, u: Float) -> Float {
        u.mul(u.mul(self.dec.inverse).add(self.wait))
    }

    /// Twice the distance of a ramp from `u` to `peak` and a stop from there.
    fn up_and_down(&self, u: Float, peak: Float, rate: &Acceleration) -> Float {
        if u.is_zero() {
            // Both begin or end at standstill: one product less.
            let slope = rate.inverse.add(self.dec.inverse);
            return peak.mul(peak.mul(slope).add(self.wait.scale(1)));
        }
        let change = peak.sub(u).abs();
        let stop = self.stop(peak);
        if change.is_zero() {
            return stop;
        }
        u.add(peak).mul(change.mul(rate.inverse).add(self.wait)).add(stop)
    }

    /// The peak speed of a motion over `length` that begins at `u` and has the cruising speed
    /// `speed`; and whether it speeds up to it.
    pub(super) fn peak(&self, u: Float, speed: Float, length: Float) -> (Float, bool) {
        let faster = u.is_less(speed);
        let rate = if faster { &self.acc } else { &self.dec };
        if !length.scale(1).is_less(self.up_and_down(u, speed, rate)) {
            return (speed, faster);
        }
        // Where the smoothing of a further ramp does not fit, the speed is held.
        let top = if faster { self.top(u, length) } else { u };
        (if top.is_less(u) { u } else { top }, faster)
    }

    /// The peak of a triangle from speed `u` over `length`: root of
    /// K·p² + w·p + (u·w/2 − u²/2a − length) = 0 with K = (1/a + 1/d)/2.
    fn top(&self, u: Float, length: Float) -> Float {
        let k = self.acc.inverse.add(self.dec.inverse).scale(-1);
        let mut rest = length;
        if !u.is_zero() {
            rest = rest.add(u.mul(u.mul(self.acc.inverse).sub(self.wait)).scale(-1));
        }
        let square = k.mul(rest);
        if self.wait.is_zero() {
            // rest/sqrt(K·rest)
            return rest.mul(square.rsqrt());
        }
        let root = self.wait.mul(self.wait).add(square.scale(2)).sqrt();
        // The form without cancellation: 2·rest / (w + root).
        rest.scale(1).div(self.wait.add(root))
    }
}
