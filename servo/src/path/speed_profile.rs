//! The speed profile of one motion, or of the remainder of it.
//!
//! In: the speed at which it begins, its length, its limits. Out: at most three phases of constant
//! acceleration, and the speed at its end. Cannot fail: a limit that cannot be kept gives way, as
//! SPEC 5 says: a motion ends at the nearest speed that it can reach, and one entered above its
//! speed brakes to it.
//!
//! All in squares of speeds: over a length s the square changes by 2·a·s, so that every question is
//! one sum.
use crate::math::float::Float;
use crate::segment::piece::{Motion, Piece, Recip};
use crate::units::{Exact, FineNs, Ns};

/// The limits of a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct MotionLimits {
    /// Speed, pulse/ms.
    pub(super) vel: Float,
    /// Acceleration, pulse/ms².
    pub(super) acc: Float,
    /// Speed at the end, at most `vel`.
    pub(super) end: Float,
    /// Least time at constant speed, ms.
    pub(super) even: Float,
    /// The number of its [`SpeedRule`].
    pub(super) ruled: Float,
}

/// What a motion has to do beside its limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SpeedRule {
    /// Nothing.
    Free,
    /// A Stop is in force, with the deceleration `ruled`.
    Stop,
    /// The plan needs its acceleration all along, up to the speed `ruled`.
    RampUp,
    /// The same, down to it.
    RampDown,
}

/// An interval of constant acceleration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Phase {
    /// Its duration.
    pub(super) time: FineNs,
    /// Its length.
    pub(super) length: Exact,
    /// Speed at its beginning, pulse/ms.
    vel: Float,
    /// Acceleration, pulse/ms².
    acc: Float,
}

/// The speed along a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedPlan {
    phases: [Phase; 3],
    count: usize,
    /// Speed at its end.
    pub(super) exit: Float,
    /// It comes to standstill before the motion ends.
    pub(super) halts: bool,
}

/// A motion that stops within 2⁻¹⁶ pulse counts as stopped: v² < 2·a·2⁻¹⁶. Planners of corner
/// speeds round, too.
const STANDSTILL_LOG2: i32 = -15;
/// A square that is less than the planned one by this part is the planned one.
const SAME_SQUARE_LOG2: i32 = -14;
const STILL: Phase = Phase { time: 0, length: Exact(0), vel: Float::ZERO, acc: Float::ZERO };

/// Whether a ≥ b.
fn reaches(a: Float, b: Float) -> bool {
    !a.sub(b).is_negative()
}

fn larger(a: Float, b: Float) -> Float {
    if a.is_less(b) { b } else { a }
}

/// A time in ms, held below 2⁹⁴ units. To 2⁻²⁰ ns: so a whole number stays whole, in spite of the
/// last bits of reals.
pub(super) fn in_ms(ms: Float) -> FineNs {
    let coarse = ms.mul(Float::FINE_NS_PER_MS).to_fixed(-12).unsigned_abs();
    coarse.min(1 << 82) << 12
}

/// A time as a number of ms.
pub(super) fn ms(time: FineNs) -> Float {
    Float::from_fixed(time, 0).mul(Float::MS_PER_FINE_NS)
}

/// The length covered in `t` ms from a speed at an acceleration.
fn distance(vel: Float, acc: Float, t: Float) -> Exact {
    t.mul(vel.add(acc.mul(t).scale(-1))).to_exact()
}

impl SpeedPlan {
    pub(super) const NONE: SpeedPlan = SpeedPlan { phases: [STILL; 3], count: 0, exit: Float::ZERO, halts: false };

    /// Makes a part of it. Returns whether that was the last.
    #[inline(never)]
    pub(super) fn advance(&mut self, speed_draft: &mut SpeedPlanDraft) -> bool {
        speed_draft.todo = match speed_draft.todo {
            PlannerStep::Bound => {
                let SpeedPlanDraft { v, length, means, rule, .. } = &*speed_draft;
                (self.count, self.exit, self.halts) = (0, *v, false);
                if length.is_zero() || length.is_negative() {
                    PlannerStep::Nothing
                } else if *rule == SpeedRule::Stop {
                    self.brake(*v, *length, means, means.ruled);
                    PlannerStep::Nothing
                } else if *rule != SpeedRule::Free && self.keep_share(*v, *length, means, *rule) {
                    PlannerStep::Nothing
                } else {
                    self.bound(speed_draft)
                }
            }
            PlannerStep::Peak => {
                speed_draft.aim();
                if speed_draft.is_uneven() {
                    PlannerStep::Even
                } else {
                    self.ramp(speed_draft.v, speed_draft.peak, speed_draft.means.acc, speed_draft.inverse);
                    PlannerStep::Remainder
                }
            }
            PlannerStep::Even => {
                speed_draft.even();
                self.ramp(speed_draft.v, speed_draft.peak, speed_draft.means.acc, speed_draft.inverse);
                PlannerStep::Remainder
            }
            PlannerStep::Remainder => {
                let SpeedPlanDraft { cruise, peak, .. } = *speed_draft;
                if !cruise.is_zero() && !cruise.is_negative() {
                    self.push(cruise.div(peak), peak, Float::ZERO);
                }
                self.ramp(peak, speed_draft.means.end, speed_draft.means.acc, speed_draft.inverse);
                PlannerStep::Nothing
            }
            PlannerStep::Nothing => PlannerStep::Nothing,
        };
        matches!(speed_draft.todo, PlannerStep::Nothing)
    }

    /// Makes its first phase. Returns whether that was all.
    pub(super) fn begin(&mut self, speed_draft: &mut SpeedPlanDraft) -> bool {
        loop {
            if self.advance(speed_draft) {
                return true;
            }
            if self.count != 0 {
                return false;
            }
        }
    }

    /// Phase `index`.
    #[inline]
    pub(super) fn phase(&self, index: usize) -> Option<&Phase> {
        self.phases.get(index).filter(|_| index < self.count)
    }

    fn push(&mut self, span: Float, vel: Float, acc: Float) {
        let time = in_ms(span);
        if let Some(phase) = self.phases.get_mut(self.count)
            && time != 0
        {
            *phase = Phase { time, length: distance(vel, acc, span), vel, acc };
            self.count = self.count.wrapping_add(1);
        }
    }

    /// A change of speed at a rate whose reciprocal is `inverse`.
    fn ramp(&mut self, from: Float, to: Float, acc: Float, inverse: Float) {
        let change = to.sub(from);
        let acc = if change.is_negative() { acc.negate() } else { acc };
        self.push(change.abs().mul(inverse), from, acc);
    }

    /// Whether the end speed can be reached at all.
    fn bound(&mut self, speed_draft: &mut SpeedPlanDraft) -> PlannerStep {
        let MotionLimits { acc, end, .. } = speed_draft.means;
        let inverse = acc.recip();
        let (from, to) = (speed_draft.v.mul(speed_draft.v), end.mul(end));
        let change = acc.mul(speed_draft.length).scale(1);
        let (low, high) = (from.sub(change), from.add(change));
        (speed_draft.inverse, speed_draft.from, speed_draft.to, speed_draft.change) = (inverse, from, to, change);
        self.exit = end;
        if !reaches(low, to) && !reaches(to, high) {
            return PlannerStep::Peak;
        }
        // Even this end cannot be reached, or just.
        self.exit = if !reaches(low, to) {
            high.sqrt()
        } else if to.is_zero() && low.is_less(acc.scale(STANDSTILL_LOG2)) {
            Float::ZERO
        } else {
            low.sqrt()
        };
        self.ramp(speed_draft.v, self.exit, acc, inverse);
        PlannerStep::Nothing
    }

    /// A fixed ramp that is slower than planned, or that an override makes slower. False if all is
    /// as planned.
    ///
    /// Let u be the present square of the speed as a part of the planned one, and ±A the planned
    /// acceleration. With u·(±A) the corners take the part u of the limits. The remainder is free:
    /// the acceleration may differ from that by (1 − u)·A. One phase is as near to the override as
    /// that allows at its beginning. On a ramp down u grows unless it falls by u·A.
    #[inline(never)]
    fn keep_share(&mut self, v: Float, length: Float, means: &MotionLimits, rule: SpeedRule) -> bool {
        let MotionLimits { vel, acc, end, ruled: planned, .. } = *means;
        let (from, to, change) = (v.mul(v), planned.mul(planned), acc.mul(length).scale(1));
        let rises = rule == SpeedRule::RampUp;
        let square = if rises { to.sub(change) } else { to.add(change) };
        let lower = !square.is_negative() && from.is_less(square.sub(square.scale(SAME_SQUARE_LOG2)));
        if !lower && !vel.is_less(v) && !end.is_less(planned) {
            return false;
        }
        if !rises && from.scale(2).is_less(square) {
            self.regain(v, length, means, square);
            return true;
        }
        let share = if lower { from.div(square) } else { Float::ONE };
        let (low, high) = (from.sub(change), share.mul(change));
        let (low, high) = if rises { (low.add(high.scale(1)), from.add(change)) } else { (low, from.sub(high)) };
        let [low, high] = [low, high].map(|square| if square.is_negative() { Float::ZERO } else { square });
        let aim = end.mul(end);
        let square = if high.is_less(aim) { high } else { larger(aim, low) };
        self.exit = square.sqrt();
        let twice = length.scale(1);
        self.push(twice.div(v.add(self.exit)), v, square.sub(from).div(twice));
        true
    }

    /// A fixed ramp down with u below ¼; `square` is the planned one where it begins. Up with A/2,
    /// as long as u is at most ¼, then down with u = ¼.
    fn regain(&mut self, v: Float, length: Float, means: &MotionLimits, square: Float) {
        const THIRD: Float = Float::new(false, 0xaaaa_aaaa_aaaa_aaab, -65);
        let MotionLimits { vel, acc, ruled: planned, .. } = *means;
        let (from, limit, inverse) = (v.mul(v), vel.mul(vel), acc.recip());
        let (reach, low) = (acc.mul(length), planned.mul(planned).scale(-2));
        let hardest = from.sub(reach.scale(1));
        if vel.is_less(v) && reaches(hardest, limit) {
            self.exit = hardest.sqrt();
            return self.ramp(v, self.exit, acc, inverse);
        }
        let all = from.add(reach);
        let (top, exit) = if low.is_less(all) { (from.add(square.scale(-1)).mul(THIRD), low) } else { (all, all) };
        let top = if limit.is_less(top) { limit } else { top };
        let exit = if top.is_less(exit) { top } else { exit };
        let (peak, up) = (top.sqrt(), !top.is_less(from));
        self.exit = exit.sqrt();
        let distance = top.sub(from).mul(inverse);
        let ramps = if up { distance } else { distance.negate().scale(-1) }.add(top.sub(exit).mul(inverse).scale(1));
        let cruise = length.sub(ramps);
        if up {
            self.ramp(v, peak, acc.scale(-1), inverse.scale(1))
        } else {
            self.ramp(v, peak, acc, inverse)
        }
        if !cruise.is_zero() && !cruise.is_negative() {
            self.push(cruise.div(peak), peak, Float::ZERO);
        }
        self.ramp(peak, self.exit, acc.scale(-2), inverse.scale(2));
    }

    /// To standstill, or as near to it as the motion is long, and never faster than without the
    /// Stop: a motion above its speed brakes to that at least as hard as it does.
    fn brake(&mut self, mut v: Float, mut length: Float, means: &MotionLimits, dec: Float) {
        let MotionLimits { vel, acc, end, .. } = *means;
        if v.is_zero() {
            self.halts = true;
            return;
        }
        let (mut from, to) = (v.mul(v), end.mul(end));
        let after = |from: Float, length: Float, rate: Float| from.sub(rate.mul(length).scale(1));
        let mut gentle = dec;
        if vel.is_less(v) && dec.is_less(acc) {
            let (inverse, limit) = (acc.recip(), vel.mul(vel));
            if reaches(after(from, length, acc), limit) {
                gentle = acc;
            } else {
                self.ramp(v, vel, acc, inverse);
                length = length.sub(from.sub(limit).mul(inverse).scale(-1));
                (v, from) = (vel, limit);
            }
        }
        let left = after(from, length, gentle);
        let (rate, left) = if reaches(to, left) || !gentle.is_less(acc) {
            (gentle, left)
        } else {
            let hard = after(from, length, acc);
            if !reaches(hard, to) {
                // Gently until the motion's own braking begins.
                let distance = to.sub(hard).div(acc.sub(gentle)).scale(-1);
                let square = from.sub(gentle.mul(distance).scale(1));
                let turn = if square.is_negative() { Float::ZERO } else { square.sqrt() };
                self.ramp(v, turn, gentle, gentle.recip());
                self.ramp(turn, end, acc, acc.recip());
                self.exit = end;
                return;
            }
            (acc, hard)
        };
        self.halts = left.is_zero() || left.is_negative();
        // A motion that would end at standstill without the Stop does so with it, whatever is
        // rounded.
        let still = to.is_zero() && left.is_less(rate.scale(STANDSTILL_LOG2));
        self.exit = if self.halts || still { Float::ZERO } else { left.sqrt() };
        self.ramp(v, self.exit, rate, rate.recip());
    }
}

/// The next step of the planner.
#[derive(Debug, Clone, Copy)]
enum PlannerStep {
    /// Which end speeds are within reach.
    Bound,
    /// The peak, and the ramp to it.
    Peak,
    /// A lower one, and the ramp to it.
    Even,
    /// The phases after that.
    Remainder,
    Nothing,
}

state! {
    /// A plan in progress, made some hundred instructions at a time.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct SpeedPlanDraft {
        todo: PlannerStep = PlannerStep::Nothing,
        rule: SpeedRule = SpeedRule::Free,
        v: Float = Float::ZERO,
        length: Float = Float::ZERO,
        means: MotionLimits = MotionLimits { vel: Float::ZERO, acc: Float::ZERO, end: Float::ZERO, even: Float::ZERO, ruled: Float::ZERO },
        /// Squares of the speeds at both ends, and how much the motion may change them.
        from: Float = Float::ZERO,
        to: Float = Float::ZERO,
        change: Float = Float::ZERO,
        /// 1/acceleration.
        inverse: Float = Float::ZERO,
        peak: Float = Float::ZERO,
        /// The length that the ramps leave for the peak speed; none in a triangle.
        cruise: Float = Float::ZERO,
    }
    pub(super) const NONE;
}

impl SpeedPlanDraft {
    /// Of a motion over `length` from speed `v`.
    #[inline]
    pub(super) fn begin(&mut self, v: Float, length: Float, (means, rule): (MotionLimits, SpeedRule)) {
        (self.todo, self.v, self.length, self.means, self.rule) = (PlannerStep::Bound, v, length, means, rule);
    }

    /// The peak speed, and the remaining length at it.
    fn aim(&mut self) {
        let SpeedPlanDraft { v, length, from, to, change, .. } = *self;
        let vel = self.means.vel;
        let halved = self.inverse.scale(-1);
        (self.peak, self.cruise) = (vel, Float::ZERO);
        if vel.is_less(v) {
            self.cruise = length.sub(from.sub(to).mul(halved));
            return;
        }
        let square = from.add(to).add(change).scale(-1);
        let limit = vel.mul(vel);
        if limit.is_less(square) {
            self.cruise = length.sub(limit.scale(1).sub(from).sub(to).mul(halved));
        } else {
            self.peak = square.sqrt();
        }
    }

    /// Whether the time at the peak is shorter than it has to be.
    fn is_uneven(&self) -> bool {
        let MotionLimits { vel, even, .. } = self.means;
        !even.is_zero() && !vel.is_less(self.v) && self.cruise.is_less(self.peak.mul(even))
    }

    /// A lower peak, for that: peak²/acc + even·peak = length of both ramps and of the cruise.
    fn even(&mut self) {
        let SpeedPlanDraft { v, length, from, to, inverse, .. } = *self;
        let MotionLimits { end, even, .. } = self.means;
        let halved = inverse.scale(-1);
        let distance = length.add(from.add(to).mul(halved));
        let root = even.mul(even).add(distance.mul(inverse).scale(2)).sqrt();
        let peak = larger(larger(distance.scale(1).div(even.add(root)), v), end);
        self.peak = peak;
        self.cruise = length.sub(peak.mul(peak).scale(1).sub(from).sub(to).mul(halved));
    }
}

impl Phase {
    /// Speed `time` after its beginning.
    pub(super) fn speed(&self, time: FineNs) -> Float {
        let speed = self.vel.add(self.acc.mul(ms(time)));
        if speed.is_negative() { Float::ZERO } else { speed }
    }

    /// The length covered `time` after its beginning.
    pub(super) fn distance(&self, time: FineNs) -> Exact {
        distance(self.vel, self.acc, ms(time))
    }

    /// As a piece that begins at `begin` and `from`, parameterised over a power of two of ns;
    /// written in place.
    #[inline(never)]
    pub(super) fn piece(&self, begin: FineNs, from: Exact, to: &mut Piece) {
        let first = begin.wrapping_add(0xffff_ffff) >> 32;
        let last = begin.wrapping_add(self.time).wrapping_add(0xffff_ffff) >> 32;
        let late = (first << 32).wrapping_sub(begin) as u64;
        // The phase lasts less than 2^reach ns.
        let reach = (64 - ((self.time >> 32) as u64).leading_zeros() as i32 + 1).clamp(1, 62);
        let unit = Float::MS_PER_FINE_NS.scale(32 + reach);
        let (a, b) = (self.vel.mul(unit), self.acc.mul(unit).mul(unit).scale(-1));
        let frac = (60 - a.width().max(b.width())).clamp(0, 82);
        let tau = if reach <= 32 { late << (32 - reach) as u32 } else { late >> (reach - 32) as u32 };
        let motion = Motion {
            tau: tau >> 1,
            c: [a.to_i64(frac), b.to_i64(frac + 1), 0],
            recip: Recip { m: 0, shift: (64 - reach) as u32 },
            frac,
            t: 0,
        };
        *to = Piece::cubic(Ns(first as u64), last.wrapping_sub(first) as u64, from, motion);
    }
}
