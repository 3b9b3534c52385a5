//! A ramp motion that runs.
//!
//! In: the axis's motion at the start, targets and rates; instants. Out: pieces. Owns: the phase in
//! force, its intervals of constant jerk. A phase is computed when it is entered
//! (`evaluator/phases.rs`).
mod phases;

use super::rate::{Accel, Acceleration, Speed};
use super::trapezoid::{TrapRates, Trapezoid};
use crate::math::float::Float;
use crate::segment::generator_state::GeneratorState;
use crate::segment::piece::{Piece, Scaled};
use crate::units::{Exact, FineNs, Ns};
use phases::ms;

/// The motion of an axis when a ramp begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Moving {
    /// Position.
    pub pos: Exact,
    /// Velocity, pulse/ms.
    pub velocity: Scaled,
}

/// What follows the present phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// A ramp to 0.
    Halt,
    /// A Trap at standstill or in motion decides how fast it can go.
    Aim,
    /// A ramp to the peak.
    Ramp,
    /// A cruise at the peak: of a Jog for ever, of a Trap until it must brake.
    Cruise,
    /// A Trap's ramp to 0, which ends on the target.
    Brake,
    /// Nothing: the motion has ended.
    Over,
}

/// Which motion it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RampKind {
    Jog,
    Trap,
    Stop,
}

/// The shape of a velocity ramp over time.
#[derive(Debug, Clone, Copy)]
enum RampShape {
    /// Acceleration in steps.
    Plain,
    /// An edge takes `half` of the ramp; the acceleration between them is `gain` = 1/(1 − half) of
    /// the rate.
    Percent { half: Float, gain: Float },
    /// Moving average of this 1/length, 1/ms.
    Average { inverse: Float },
}

/// An interval of constant jerk within a phase.
#[derive(Debug, Clone, Copy)]
struct JerkPhase {
    begin: FineNs,
    len: FineNs,
    /// Of its pieces already loaded, the end.
    done: FineNs,
    /// At `begin`: velocity, acceleration; a sixth of the jerk.
    v: Float,
    a: Float,
    j: Float,
    /// Pieces are parameterised over 2^reach ms.
    reach: i32,
}

state! {
    /// What the second and third interval of a ramp with edges need; they begin and end at the
    /// knots.
    #[derive(Debug, Clone, Copy)]
    struct Edged {
        /// Intervals to come.
        left: u8 = 0,
        /// Velocity at the end, acceleration between the edges, a sixth of the jerk in the first.
        v1: Float = Float::ZERO,
        top: Float = Float::ZERO,
        sixth: Float = Float::ZERO,
        /// Velocity gained in an edge, and the displacement by it.
        gained: Float = Float::ZERO,
        distance: Float = Float::ZERO,
        /// An edge, ms.
        edge: Float = Float::ZERO,
        /// |velocity| < 2^width.
        width: i32 = 0,
        /// Where the ramp began.
        from: Exact = Exact(0),
    }
        const NONE;
}

state! {
    /// A ramp motion that runs.
    #[derive(Debug, Clone, Copy)]
    pub struct RampRun {
        kind: RampKind = RampKind::Stop,
        next: Next = Next::Over,
        /// Position, instant and velocity at which the next phase begins.
        knot: Exact = Exact(0),
        time: FineNs = 0,
        v: Float = Float::ZERO,
        /// Velocity after the next ramp; of a Trap that has not aimed yet, the magnitude of the
        /// speed.
        peak: Float = Float::ZERO,
        /// Whether that ramp takes `acc`.
        faster: bool = false,
        /// Speed that a Trap from rest begins with.
        jump: Float = Float::ZERO,
        target: i32 = 0,
        means: TrapRates = TrapRates { acc: Acceleration::NONE, dec: Acceleration::NONE, wait: Float::ZERO },
        shape: RampShape = RampShape::Plain,
        /// Where the next piece begins.
        pos: Exact = Exact(0),
        jerk_phase: JerkPhase = STILL,
        edged: Edged = Edged::NONE,
    }
    /// It has ended. A motion is begun in place, so that nothing large is moved about.
    pub const IDLE;
}

/// Pieces a tick may step over: four phases of three intervals, each in one piece where it is so
/// short.
const PIECES_PER_TICK: u32 = 16;
const STILL: JerkPhase =
    JerkPhase { begin: 0, len: 0, done: 0, v: Float::ZERO, a: Float::ZERO, j: Float::ZERO, reach: 0 };
impl RampRun {
    /// The motion before is over; another one begins.
    fn restart(&mut self, kind: RampKind, now: Ns, from: Moving, shape: RampShape) {
        (self.kind, self.shape) = (kind, shape);
        (self.knot, self.pos, self.time) = (from.pos, from.pos, (now.0 as FineNs) << 32);
        (self.jerk_phase.len, self.jerk_phase.done, self.edged.left) = (0, 0, 0);
        self.v = Float::from_scaled(from.velocity);
    }

    /// The velocity goes to `target` and stays there for ever. It takes `acc` when it speeds up and
    /// `dec` (or `acc`, if `dec` is 0) when it slows down; where the sign changes it goes through 0
    /// first. A target of 0 ends the motion. `smooth` in 2⁻¹⁶.
    pub fn begin_jog(&mut self, now: Ns, from: Moving, target: Speed, acc: Accel, dec: Accel, smooth: u16) {
        let shape = if smooth == 0 {
            RampShape::Plain
        } else {
            let gain = Float::new(false, (1 << 17) - smooth as u64, -17).recip();
            RampShape::Percent { half: Float::new(false, smooth as u64, -17), gain }
        };
        self.restart(RampKind::Jog, now, from, shape);
        self.means.acc = acc.rate();
        self.means.dec = if dec.is_zero() { self.means.acc } else { dec.rate() };
        self.peak = target.real();
        let turns = self.peak.is_zero() || self.v.is_negative() != self.peak.is_negative();
        self.next = if turns && !self.v.is_zero() { Next::Halt } else { Next::Ramp };
        self.faster = self.next == Next::Halt || self.v.abs().is_less(self.peak.abs());
    }

    /// Linear deceleration to exactly 0.
    pub fn begin_stop(&mut self, now: Ns, from: Moving, dec: Accel) {
        self.restart(RampKind::Stop, now, from, RampShape::Plain);
        self.means.dec = dec.rate();
        self.next = if self.v.is_zero() { Next::Over } else { Next::Halt };
    }

    /// A trapezoid to the target, planned from the present velocity; it comes back after an
    /// overshoot.
    pub fn begin_trap(&mut self, now: Ns, from: Moving, to: &Trapezoid) {
        self.restart(RampKind::Trap, now, from, RampShape::Plain);
        self.means.wait = Float::ZERO;
        if to.smooth.0 != 0 {
            self.means.wait = ms((to.smooth.0 as FineNs) << 32);
            self.shape = RampShape::Average { inverse: self.means.wait.recip() };
        }
        (self.means.acc, self.means.dec) = (to.acc.rate(), to.dec.rate());
        (self.target, self.peak, self.jump) = (to.target, to.speed.real().abs(), to.vel_start.real().abs());
        self.next = Next::Aim;
        if !self.v.is_zero() {
            let ahead = Float::from_exact(Exact(self.distance()));
            let past = ahead.is_zero() || ahead.is_negative() != self.v.is_negative() || self.peak.is_zero();
            if past || ahead.abs().scale(1).is_less(self.means.stop(self.v.abs())) {
                self.next = Next::Halt;
            }
        }
    }

    /// A motion prepared for time 0 begins at `now`.
    pub(crate) fn shift(&mut self, now: Ns) {
        let by = (now.0 as FineNs) << 32;
        self.time = self.time.wrapping_add(by);
        self.jerk_phase.begin = self.jerk_phase.begin.wrapping_add(by);
    }

    /// When the next phase begins: of a motion of which nothing was made, the motion.
    pub(crate) fn begins(&self) -> Ns {
        Ns((self.time >> 32) as u64)
    }

    /// When the motion will have ended, 2⁻³² ns; a Jog never does.
    pub fn end(&self) -> FineNs {
        let mut run = *self;
        for _ in 0..PIECES_PER_TICK {
            if !run.next_phase() {
                break;
            }
        }
        run.time
    }

    /// Makes the piece that holds `now`, which is not before the end of the last one made; or the
    /// end.
    #[inline(never)]
    pub fn advance(&mut self, now: Ns, piece: &mut Piece) -> GeneratorState {
        for _ in 0..PIECES_PER_TICK {
            while self.jerk_phase.done >= self.jerk_phase.len {
                if self.edged.left > 0 {
                    self.next_jerk_phase();
                } else if !self.next_phase() {
                    return GeneratorState::Ended { at: self.pos };
                }
            }
            self.load_piece(piece);
            if piece.elapsed(now) < piece.span {
                break;
            }
        }
        GeneratorState::Running
    }

    /// Enters the next phase, if it has any length; false at the end. A motion that has ended is on
    /// its knot.
    fn next_phase(&mut self) -> bool {
        self.pos = self.knot;
        match self.next {
            Next::Halt => {
                self.next = match self.kind {
                    RampKind::Jog => Next::Ramp,
                    RampKind::Trap => Next::Aim,
                    RampKind::Stop => Next::Over,
                };
                self.ramp(Float::ZERO, self.means.dec, None);
            }
            Next::Aim => self.aim(),
            Next::Ramp => {
                self.next = Next::Cruise;
                let rate = if self.faster { self.means.acc } else { self.means.dec };
                self.ramp(self.peak, rate, None);
            }
            Next::Cruise => self.cruise(),
            Next::Brake => {
                self.next = Next::Over;
                self.ramp(Float::ZERO, self.means.dec, Some(Exact(self.distance())));
            }
            Next::Over => return false,
        }
        true
    }

    /// Of a Trap, how far the target is.
    fn distance(&self) -> i128 {
        ((self.target as i128) << 64).wrapping_sub(self.knot.0)
    }
}
