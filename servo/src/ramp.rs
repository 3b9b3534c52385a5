//! Jog, Trap and Stop as sequences of pieces.
//!
//! In: a position and velocity at an instant, targets, admitted [`Speed`]s and [`Accel`]s.
//! Out: a [`Step`] a tick. A command is planned once into at most four legs (ramps and cruises),
//! closed forms of the time since it began, so nothing depends on the tick; knots between legs
//! are [`Exact`] and a leg's last piece ends on its knot, so a Trap ends on its target.
//!
//! A ramp of duration L with edges E: the acceleration rises for E, holds at Δv/(L − E), falls for
//! E; it covers (v0 + v1)/2·L whatever E is. Jog's `smooth` is E = L·smooth/2 with L = Δv/acc (the
//! Percent shape); Trap's smooth time w is the moving average of that length: L = Δv/acc + w, E the
//! lesser of w and Δv/acc, and the acceleration stays within acc.
use crate::piece::{Motion, Piece, Scaled};
use crate::profile::{State, Step};
use crate::real::Real;
use crate::units::{Exact, Ns};
use crate::wide::{Recip, recip64, umulhi};

/// A velocity in pulse/ms.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Speed(pub Scaled);

/// An acceleration in pulse/ms² with its reciprocal, so that the tick never divides.
/// Default (0) is "not set".
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Accel {
    /// The magnitude.
    pub value: Scaled,
    /// 1/magnitude.
    pub recip: Scaled,
}

/// Why a speed or an acceleration is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// NaN or infinite.
    NotFinite,
    /// Magnitude above 2³² (pulse/ms, pulse/ms²).
    BeyondFullScale,
    /// An acceleration of 0 or less.
    NotPositive,
}

/// A double as a block float, by its bits; subnormals are 0.
fn decode(bits: u64) -> Result<Scaled, Refused> {
    let exponent = (bits >> 52 & 0x7ff) as i16;
    let fraction = bits & ((1 << 52) - 1);
    if exponent == 0x7ff {
        return Err(Refused::NotFinite);
    }
    if exponent > 1055 || exponent == 1055 && fraction != 0 {
        return Err(Refused::BeyondFullScale);
    }
    if exponent == 0 {
        return Ok(Scaled::default());
    }
    let m = (1 << 52 | fraction) as i64;
    Ok(Scaled { m: if bits >> 63 == 1 { -m } else { m }, e: 1075 - exponent })
}

impl Speed {
    /// From the bits of a double in pulse/ms, |v| ≤ 2³².
    pub fn admit(bits: u64) -> Result<Speed, Refused> {
        decode(bits).map(Speed)
    }
}

impl Accel {
    /// From the bits of a double in pulse/ms², 0 < a ≤ 2³².
    pub fn admit(bits: u64) -> Result<Accel, Refused> {
        let value = decode(bits)?;
        if value.m <= 0 {
            return Err(Refused::NotPositive);
        }
        // 1/(M·2^-64) with the top bit of M set is (2^64 + v)·2^-64; 63 bits of it are kept.
        let shift = value.m.leading_zeros();
        let v = recip64((value.m as u64) << shift);
        let recip = Scaled { m: (1 << 62 | v >> 2) as i64, e: 126 - shift as i16 - value.e };
        Ok(Accel { value, recip })
    }

    /// Whether it was never set.
    pub fn is_zero(self) -> bool {
        self.value.m == 0
    }

    fn inverse(self) -> Real {
        Real::from_scaled(self.recip)
    }
}

/// Where an axis is when a ramp begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Moving {
    /// Position.
    pub pos: Exact,
    /// Velocity, pulse/ms.
    pub velocity: Scaled,
}

/// Parameters of a Trap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trapezoid {
    /// Target, pulses.
    pub target: i32,
    /// Cruising speed; its magnitude counts.
    pub speed: Speed,
    /// Acceleration, not 0.
    pub acc: Accel,
    /// Deceleration, not 0.
    pub dec: Accel,
    /// Velocity at which a start from rest begins, at most `speed`. Left out where the axis could
    /// not stop from it within the distance.
    pub vel_start: Speed,
    /// Length of the moving average over each velocity ramp.
    pub smooth: Ns,
}

/// Time in 2⁻³² ns.
type Fine = u128;

/// A ramp or a cruise.
#[derive(Debug, Clone, Copy, Default)]
struct Leg {
    v0: Real,
    v1: Real,
    /// Duration, ms.
    len: Real,
    /// Rise and fall of the acceleration, ms each.
    edge: Real,
    /// Exactly this far.
    way: Exact,
}

/// A stretch of constant jerk within a leg.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    begin: Fine,
    len: Fine,
    /// Of its pieces already loaded, the end.
    done: Fine,
    /// At `begin`: velocity, acceleration; jerk.
    v: Real,
    a: Real,
    j: Real,
    /// |velocity| < 2^width throughout the leg.
    width: i32,
}

/// A ramp motion that runs.
#[derive(Debug, Clone, Copy)]
pub struct RampRun {
    piece: Piece,
    legs: [Leg; LEGS],
    count: u8,
    /// The last leg never ends.
    endless: bool,
    /// Next leg to load, and next stretch of the present leg.
    leg: u8,
    part: u8,
    /// Where and when the next piece begins.
    pos: Exact,
    /// Where and when the present leg began, or the next one begins.
    leg_pos: Exact,
    leg_begin: Fine,
    stretch: Stretch,
}

const LEGS: usize = 4;
/// Pieces a tick may step over: four legs of three stretches, each in one piece where it is so short.
const PIECES_PER_TICK: u32 = 16;

fn fine(ms: Real) -> Fine {
    ms.mul(Real::MS).to_fixed(0).unsigned_abs().min(1 << 96)
}

fn ms(time: Fine) -> Real {
    Real::from_fixed(time, 0).mul(Real::FINE)
}

/// Collects legs.
struct Plan {
    run: RampRun,
}

impl Plan {
    fn new(now: Ns, pos: Exact) -> Plan {
        Plan {
            run: RampRun {
                piece: Piece { begin: now, span: 0, start: pos.round(), motion: Motion::default() },
                legs: [Leg::default(); LEGS],
                count: 0,
                endless: false,
                leg: 0,
                part: 0,
                pos,
                leg_pos: pos,
                leg_begin: (now.0 as Fine) << 32,
                stretch: Stretch::default(),
            },
        }
    }

    fn push(&mut self, leg: Leg) {
        if let Some(place) = self.run.legs.get_mut(self.run.count as usize) {
            *place = leg;
            self.run.count += 1;
        }
    }

    /// A ramp whose way follows from its speeds and duration.
    fn ramp(&mut self, v0: Real, v1: Real, len: Real, edge: Real) -> Exact {
        let way = v0.add(v1).mul(len).scale(-1).to_exact();
        self.push(Leg { v0, v1, len, edge, way });
        way
    }
}

/// How a velocity ramp takes its time.
#[derive(Clone, Copy)]
enum Shape {
    /// Edges take this part (2⁻¹⁶) of the ramp, half each.
    Percent(u16),
    /// Moving average of this length, ms.
    Average(Real),
}

impl Shape {
    /// Duration and edge of a ramp over |Δv| at 1/rate.
    fn times(self, dv: Real, inverse: Real) -> (Real, Real) {
        let plain = dv.abs().mul(inverse);
        match self {
            Shape::Percent(part) => (plain, plain.mul(Real::new(false, part as u64, -17))),
            Shape::Average(_) if plain.is_zero() => (Real::ZERO, Real::ZERO),
            Shape::Average(w) => (plain.add(w), plain.min(w)),
        }
    }

    /// Way of a ramp between two speeds of one sign.
    fn way(self, v0: Real, v1: Real, inverse: Real) -> Real {
        v0.add(v1).mul(self.times(v1.sub(v0), inverse).0).scale(-1)
    }
}

impl RampRun {
    /// Velocity goes to `target` with `acc` when speeding up and `dec` (or `acc`, if `dec` is 0)
    /// when slowing down, through 0 first where the sign changes, and stays there for ever.
    /// A target of 0 ends the motion. `smooth` in 2⁻¹⁶.
    pub fn jog(now: Ns, from: Moving, target: Speed, acc: Accel, dec: Accel, smooth: u16) -> RampRun {
        let mut plan = Plan::new(now, from.pos);
        let shape = Shape::Percent(smooth);
        let (acc, dec) = (acc.inverse(), if dec.is_zero() { acc } else { dec }.inverse());
        let (mut v, target) = (Real::from_scaled(from.velocity), Real::from_scaled(target.0));
        if !v.is_zero() && (target.is_zero() || v.is_negative() != target.is_negative()) {
            let (len, edge) = shape.times(v, dec);
            plan.ramp(v, Real::ZERO, len, edge);
            v = Real::ZERO;
        }
        let dv = target.sub(v);
        if !dv.is_zero() {
            let (len, edge) = shape.times(dv, if v.abs().below(target.abs()) { acc } else { dec });
            plan.ramp(v, target, len, edge);
        }
        if !target.is_zero() {
            plan.push(Leg { v0: target, v1: target, ..Leg::default() });
            plan.run.endless = true;
        }
        plan.run
    }

    /// Linear deceleration to exactly 0.
    pub fn stop(now: Ns, from: Moving, dec: Accel) -> RampRun {
        let mut plan = Plan::new(now, from.pos);
        let v = Real::from_scaled(from.velocity);
        if !v.is_zero() {
            plan.ramp(v, Real::ZERO, v.abs().mul(dec.inverse()), Real::ZERO);
        }
        plan.run
    }

    /// A trapezoid to the target, planned from the present velocity: back, if it is overshot.
    pub fn trap(now: Ns, from: Moving, to: &Trapezoid) -> RampRun {
        let mut plan = Plan::new(now, from.pos);
        let target = Exact((to.target as i128) << 64);
        let wait = ms((to.smooth.0 as Fine) << 32);
        let shape = Shape::Average(wait);
        let (acc, dec) = (to.acc.inverse(), to.dec.inverse());
        let speed = Real::from_scaled(to.speed.0).abs();
        let mut v = Real::from_scaled(from.velocity);
        let mut way = target.0.wrapping_sub(from.pos.0);
        if !v.is_zero() {
            let stop = shape.way(v, Real::ZERO, dec);
            let ahead = Real::from_exact(Exact(way));
            if ahead.is_zero() || ahead.is_negative() != v.is_negative() || ahead.abs().below(stop.abs()) {
                let (len, edge) = shape.times(v, dec);
                way = way.wrapping_sub(plan.ramp(v, Real::ZERO, len, edge).0);
                v = Real::ZERO;
            }
        }
        if way == 0 || speed.is_zero() {
            return plan.run;
        }
        // From here on along the way: all speeds are magnitudes.
        let back = way < 0;
        let signed = |x: Real| if back { x.negate() } else { x };
        let length = Real::from_exact(Exact(way)).abs();
        let mut u = v.abs();
        if u.is_zero() {
            let jump = Real::from_scaled(to.vel_start.0).abs().min(speed);
            if !length.below(shape.way(jump, Real::ZERO, dec)) {
                u = jump;
            }
        }
        let rate = if u.below(speed) { acc } else { dec };
        let peak = if !length.below(shape.way(u, speed, rate).add(shape.way(speed, Real::ZERO, dec))) {
            speed
        } else if u.below(speed) {
            // Where the smoothing of a further ramp does not fit, the speed is held.
            u.max(top_speed(u, length, acc, dec, wait))
        } else {
            u
        };
        let (len, edge) = shape.times(peak.sub(u), rate);
        if !len.is_zero() {
            way = way.wrapping_sub(plan.ramp(signed(u), signed(peak), len, edge).0);
        }
        let (len, edge) = shape.times(peak, dec);
        let braking = signed(peak).mul(len).scale(-1).to_exact();
        let cruise = Exact(way.wrapping_sub(braking.0));
        let mut last = way;
        // What is left between the ramps; in a triangle a rounding of it, which the last ramp takes.
        if (cruise.0 < 0) == back && cruise.0.unsigned_abs() >> 32 != 0 {
            let len = Real::from_exact(cruise).abs().div(peak);
            plan.push(Leg { v0: signed(peak), v1: signed(peak), len, edge: Real::ZERO, way: cruise });
            last = braking.0;
        }
        plan.push(Leg { v0: signed(peak), v1: Real::ZERO, len, edge, way: Exact(last) });
        plan.run
    }

    /// The motion at `now`, which must not go back between calls.
    #[inline]
    pub fn step(&mut self, now: Ns) -> Step {
        if self.piece.elapsed(now) >= self.piece.span
            && let state @ State::Ended { at } = self.turn(now)
        {
            return Step { pos: at.round(), motion: Motion::REST, state };
        }
        let (pos, tau) = self.piece.at(self.piece.held(now));
        Step { pos, motion: self.piece.motion(tau), state: State::Running }
    }

    /// The piece in force, as far as the last step or turn saw.
    #[inline(always)]
    pub fn piece(&self) -> &Piece {
        &self.piece
    }

    /// The piece is over at `now`: on to the one that holds it, or to the end.
    pub fn turn(&mut self, now: Ns) -> State {
        if self.go_on(now) { State::Running } else { State::Ended { at: self.pos } }
    }

    /// On to the piece that holds `now`; false at the end.
    #[inline(never)]
    fn go_on(&mut self, now: Ns) -> bool {
        for _ in 0..PIECES_PER_TICK {
            if !self.advance() {
                return false;
            }
            if self.piece.elapsed(now) < self.piece.span {
                break;
            }
        }
        true
    }

    /// Loads the next piece; false at the end.
    fn advance(&mut self) -> bool {
        while self.stretch.done >= self.stretch.len {
            if !self.next_stretch() {
                return false;
            }
        }
        self.load_piece();
        true
    }

    /// The next stretch of constant jerk; its length may be 0.
    fn next_stretch(&mut self) -> bool {
        if self.leg > 0 && self.part == 3 {
            self.part = 0;
        }
        if self.part == 0 {
            // The leg that has ended, if any, ends on its knot.
            self.pos = self.leg_pos;
            if self.leg >= self.count {
                return false;
            }
        }
        let endless = self.endless && self.leg + 1 == self.count;
        let Some(leg) = self.legs.get(self.leg as usize) else { return false };
        let (total, edge) = (fine(leg.len), fine(leg.edge));
        let flat = leg.len.sub(leg.edge);
        let top = leg.v1.sub(leg.v0).div(flat);
        let jerk = if leg.edge.is_zero() { Real::ZERO } else { top.div(leg.edge) };
        let gained = top.mul(leg.edge).scale(-1);
        let leg_begin = self.leg_begin;
        let width = leg.v0.width().max(leg.v1.width());
        let stretch =
            |begin: Fine, len: Fine, v, a, j| Stretch { begin: leg_begin + begin, len, done: 0, v, a, j, width };
        let whole = leg.edge.is_zero();
        self.stretch = match self.part {
            _ if endless => stretch(0, Fine::MAX >> 8, leg.v0, Real::ZERO, Real::ZERO),
            _ if whole => stretch(0, total, leg.v0, top, Real::ZERO),
            0 => stretch(0, edge, leg.v0, Real::ZERO, jerk),
            1 => stretch(edge, total.saturating_sub(edge << 1), leg.v0.add(gained), top, Real::ZERO),
            _ => stretch(total - edge.min(total), edge, leg.v1.sub(gained), top, jerk.negate()),
        };
        self.part = if whole { 3 } else { self.part + 1 };
        if self.part == 3 {
            self.leg += 1;
            self.leg_begin = self.leg_begin.wrapping_add(total);
            self.leg_pos = Exact(self.leg_pos.0.wrapping_add(leg.way.0));
        }
        true
    }

    /// The next piece of the stretch: all of it, or as many ms (a power of two) as keep the way
    /// below 2³⁷ pulses.
    fn load_piece(&mut self) {
        let s = &mut self.stretch;
        let left = s.len - s.done;
        let t = ms(s.done);
        let k = (36 - s.width).clamp(-10, 30);
        let chunk = fine(Real::ONE.scale(k));
        let (len, h) = if left > chunk { (chunk, Real::ONE.scale(k)) } else { (left, ms(left)) };
        let a = s.a.add(s.j.mul(t));
        let v = s.v.add(s.a.add(a).mul(t).scale(-1));
        let c1 = v.mul(h);
        let c2 = a.mul(h).mul(h).scale(-1);
        let c3 = s.j.mul(h).mul(h).mul(h).mul(Real::SIXTH);
        let width = c1.width().max(c2.width()).max(c3.width());
        let frac = (60 - width).clamp(0, 84);
        let begin = s.begin + s.done;
        let first = (begin + 0xffff_ffff) >> 32;
        let last = (begin + len + 0xffff_ffff) >> 32;
        // 1/len from its upper 64 bits, as if in whole ns.
        let bits = 128 - len.leading_zeros() as i32;
        let mantissa =
            if bits > 64 { ((len >> (bits - 64)) as u64).saturating_add(1) } else { (len as u64) << (64 - bits) };
        let recip = Recip { m: recip64(mantissa), shift: (96 - bits) as u32 };
        // τ at `first`, less than 1 ns behind `begin`: its 2^-32 ns in units of `mantissa`.
        let offset = ((first << 32) - begin) as u64;
        let offset = if recip.shift > 32 { offset << (recip.shift - 32) } else { offset >> (32 - recip.shift) };
        self.piece = Piece {
            begin: Ns(first as u64),
            span: (last - first) as u64,
            start: self.pos.round(),
            motion: Motion {
                c: [c1, c2, c3].map(|c| c.to_fixed(frac) as i64),
                frac: frac as u32,
                tau: offset.saturating_add(umulhi(offset, recip.m)),
                recip,
            },
        };
        self.pos = Exact(self.pos.0.wrapping_add(c1.add(c2).add(c3).to_exact().0));
        s.done += len;
    }
}

/// The peak of a triangle from speed `u` over `length`: root of
/// K·p² + w·p + (u·w/2 − u²/2a − length) = 0 with K = (1/a + 1/d)/2.
fn top_speed(u: Real, length: Real, acc: Real, dec: Real, wait: Real) -> Real {
    let k = acc.add(dec).scale(-1);
    let rest = length.add(u.mul(u).mul(acc).scale(-1)).sub(u.mul(wait).scale(-1));
    let root = wait.mul(wait).add(k.mul(rest).scale(2)).sqrt();
    // The form without cancellation: 2·rest / (w + root).
    rest.scale(1).div(wait.add(root))
}
