//! How the motion of an axis is replaced by another one, or ends: Update, Stop, BufMove, a halt.
//!
//! In: what the call or the path asks for, and the position and velocity in force. Out: the motion
//! from now on, and how well its end is known. Owns nothing. Fails: nothing does.
use super::{Aim, Axis, Mode, Motion, Rates, Why, whole};
use crate::reference::number::{Fix, exact};
use crate::reference::pt::{Timed, Went};
use crate::reference::ramp;

impl Axis {
    /// What an Update carries: the settings of its instant.
    pub fn aim(&self) -> Aim {
        let rates = if self.mode == Mode::Jog { self.jog } else { self.trap };
        Aim { rates, target: self.target, speed: self.speed }
    }

    /// Trap or Jog, from the velocity that it has.
    pub fn update(&mut self, now_ns: i64, aim: Aim) {
        let Aim { rates: Rates { acc, dec }, target, speed } = aim;
        let dec = if dec == 0.0 { acc } else { dec };
        self.braking = None;
        let mut blur = Fix::ZERO;
        let curve = if self.mode == Mode::Jog {
            ramp::jog(self.v, speed, &exact(acc), &exact(dec))
        } else {
            let displacement = Fix::whole(target.into()) + self.zero - self.x;
            blur = ramp::blur(self.v, displacement, acc, dec);
            ramp::trap(self.v, displacement, &exact(speed.abs()), &exact(acc), &exact(dec))
        };
        self.slack += std::mem::take(&mut self.late);
        self.slack += std::mem::take(&mut self.late_velocity) * curve.length();
        self.slack += self.brake_rounding(now_ns) * curve.length();
        // A way of 2⁻¹⁸ ms at most is one that rounding makes.
        self.doubt |= curve.length() < Fix(1 << 46) && curve.cruise == Fix::ZERO;
        self.began |= !self.runs();
        if self.ended {
            // Whether it has stopped between its end and this is not said.
            self.why = None;
        }
        self.ending = Why::End;
        self.replans += i128::from(self.runs());
        let ramp = Motion::Ramp(Timed::new(curve, Fix::ms(now_ns), self.x).rounded(blur));
        self.past = self.motion.replace(ramp);
    }

    /// How well its velocity is known where a Trap brakes for its target: when it began to follows
    /// from a position of 2⁻²².
    fn brake_rounding(&self, now_ns: i64) -> Fix {
        let v = self.v.to_f64();
        let acc = self.acceleration(Fix::ms(now_ns)).map_or(0.0, Fix::to_f64);
        if self.mode != Mode::Trap || acc * v >= 0.0 || !matches!(self.motion, Some(Motion::Ramp(_))) {
            return Fix::ZERO;
        }
        Fix::of_f64(2f64.powi(-21) * acc.abs() / v.abs())
    }

    pub fn smooth_stop(&mut self, now_ns: i64, dec: f64) {
        self.leave();
        // A slave without speed is at standstill on the next tick.
        if self.v == Fix::ZERO && !matches!(self.motion, Some(Motion::Slave(_))) {
            self.past = self.motion.take();
            self.why = Some(self.ending);
            return;
        }
        self.braking = Some(dec);
        self.replans += 1;
        self.slack += std::mem::take(&mut self.late);
        let curve = ramp::stop(self.v, dec);
        self.slack += std::mem::take(&mut self.late_velocity) * curve.length();
        if matches!(self.motion, Some(Motion::Slave(_))) {
            self.slack += curve.length() * self.velocity_rounding;
        }
        let ramp = Motion::Ramp(Timed::new(curve, Fix::ms(now_ns), self.x).rounded(Fix::ZERO));
        self.past = self.motion.replace(ramp);
    }

    /// BufMove: from an instant of the tick that began at `from` on; when it ends.
    pub fn travel(&mut self, from: Fix, at: Fix, to: i32, [vel, acc]: [f64; 2]) -> Fix {
        let (begin, mut x) = self.head.last().copied().unwrap_or((from, self.x));
        let (mut v, mut before) = (Fix::ZERO, Fix::ZERO);
        if let Some(Motion::Ramp(timed)) = &mut self.motion {
            let mut knots = Vec::new();
            before = timed.curve.curvature(timed.position(at)).unwrap_or(Fix::ZERO).abs();
            if timed.step(begin, at, 1, &mut knots) == Went::On {
                v = timed.velocity(at);
            }
            x = knots.last().map_or(x, |last| last.1);
            self.head.append(&mut knots);
        }
        self.head.push((at, x));
        if let Some(Motion::Ramp(timed)) = &self.motion {
            self.head_most = self.head_most.max(timed.curve.steepest);
        }
        let displacement = Fix::whole(to.into()) + self.zero - x;
        // It stands where the move ends, but for rounding of this number.
        let displacement = if displacement.abs() < Fix(1 << 20) { Fix::ZERO } else { displacement };
        let blur = ramp::blur(v, displacement, acc, acc);
        let acc = exact(acc);
        let curve = ramp::trap(v, displacement, &exact(vel), &acc, &acc);
        // It may begin up to 5 ns later (SPEC 11).
        (self.late, self.braking) = (self.late + curve.steepest * Fix::ms(5), None);
        self.ending = Why::End;
        self.late_velocity = Fix::of(&acc) * Fix::ms(5);
        let length = curve.length();
        // Up to then it keeps the acceleration that it had.
        self.slack += before * Fix::ms(5) * length;
        self.brief |= length == Fix::ZERO;
        self.motion = Some(Motion::Ramp(Timed::new(curve, at, x).rounded(blur)));
        let speed = (displacement.abs() * Fix::of(&acc)).to_f64().sqrt();
        // A place within pulses, as a Stop leaves it, is known to 2⁻¹⁸ pulse.
        let is_whole = (x - whole(x)).abs() < Fix(1 << 20);
        let apart = if is_whole { 0.0 } else { self.slack.to_f64() + 2f64.powi(-18) };
        self.end_is_doubtful = apart > 1e-6 * speed;
        at + length
    }

    /// At standstill at the position of the last tick.
    pub fn halt(&mut self, why: Why) {
        self.leave();
        self.halted = self.runs();
        if self.halted {
            self.why = Some(why);
        }
        self.doubt |= self.halted;
        self.motion = None;
        self.slack += std::mem::take(&mut self.late);
        self.braking = None;
        self.v = Fix::ZERO;
    }

    /// A motion ends otherwise than by itself: what is left of a stream is cleared.
    fn leave(&mut self) {
        if matches!(self.motion, Some(Motion::Stream(..))) {
            self.pt.fifos[0].clear();
            self.pt.ran = 0;
        }
    }

    /// The same before it has ended: what is given from now on belongs to the next stream.
    pub fn end_stream(&mut self) {
        self.leave();
        if let Some(Motion::Stream(timed, _)) = &self.motion {
            self.motion = Some(Motion::Pt(timed.clone()));
        }
    }
}
