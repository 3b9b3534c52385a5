//! PT data, and motions that are functions of time.
use super::curve::Curve;
use super::number::{Fix, exact};
use super::rational::Rational;

/// A segment as PtData gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    pub pos: f64,
    pub time_ms: i64,
    pub kind: i16,
}

/// A chain of segments, and where its last one ends.
#[derive(Debug, Clone)]
pub struct Chain {
    pub curve: Curve,
    pub ends: Vec<Fix>,
    pos: Rational,
    time_ms: i64,
    velocity: Rational,
}

impl Default for Chain {
    fn default() -> Chain {
        let zero = Rational::zero;
        Chain { curve: Curve::default(), ends: Vec::new(), pos: zero(), time_ms: 0, velocity: zero() }
    }
}

impl Chain {
    pub fn of(segments: &[Segment]) -> Chain {
        let mut chain = Chain::default();
        for segment in segments {
            chain.add(segment);
        }
        chain
    }

    pub fn ends_at_speed(&self) -> bool {
        self.velocity != Rational::zero()
    }

    pub fn add(&mut self, segment: &Segment) {
        let length = Rational::from_integer((segment.time_ms - self.time_ms).into());
        let pos = exact(segment.pos);
        let mean = (&pos - &self.pos) / &length;
        let twice = &mean + &mean;
        let (begin, end) = match segment.kind {
            0 => (self.velocity.clone(), &twice - &self.velocity),
            1 => (mean.clone(), mean),
            _ => (twice, Rational::zero()),
        };
        let acc = (&end - &begin) / &length;
        self.curve.cubic(&length, &begin, &acc, &Rational::zero());
        self.curve.ends_at(Fix::of(&pos));
        self.ends.push(self.curve.length());
        (self.pos, self.time_ms, self.velocity) = (pos, segment.time_ms, end);
    }
}

/// A motion that began at a tick.
#[derive(Debug, Clone)]
pub struct Timed {
    pub curve: Curve,
    pub start: Fix,
    origin: Fix,
    began: Fix,
    /// Progress of the last step.
    at: Fix,
    pub passes: i64,
    /// Its end follows from divisions, and is known to this, ms. None: it is given.
    rounded: Option<Fix>,
    /// PVT: what takes over at the end of the pass.
    pub pending: Option<Curve>,
    /// Whether it has come to an end is within rounding.
    pub open: bool,
    /// It has come to its end.
    over: bool,
}

/// 2⁻⁵⁴ ms.
const ROUNDING_MS: Fix = Fix(1 << 10);
/// 2⁻¹⁸ ms: what rounding of a controller's own numbers may decide, of which velocities have 2⁻²²
/// pulse/ms.
const DOUBT_MS: Fix = Fix(1 << 46);

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Went {
    On,
    Ended,
}

impl Timed {
    pub fn new(curve: Curve, start: Fix, origin: Fix) -> Timed {
        Timed {
            curve,
            start,
            origin,
            began: Fix::ZERO,
            at: Fix::ZERO,
            passes: 0,
            pending: None,
            rounded: None,
            open: false,
            over: false,
        }
    }

    /// A ramp: its end is known to a controller's rounding, and `more` where that decides more.
    pub fn rounded(self, more: Fix) -> Timed {
        Timed { rounded: Some(DOUBT_MS + more), ..self }
    }

    /// The same after a delay, ms.
    pub fn after(self, delay: Fix) -> Timed {
        Timed { began: delay, ..self }
    }

    fn progress(&self, at: Fix) -> Fix {
        at - self.start
    }

    /// Its place in the pass, ms.
    pub fn position(&self, at: Fix) -> Fix {
        self.progress(at) - self.began
    }

    /// Instants in ms and positions from the tick before to `to`, through everything at which it
    /// may turn. `loops` of 0 or less: for ever.
    pub fn step(&mut self, from: Fix, to: Fix, loops: i64, out: &mut Vec<(Fix, Fix)>) -> Went {
        let (mut a, mut b) = (self.progress(from).max(Fix::ZERO), self.progress(to));
        self.at = b;
        self.open = false;
        loop {
            let length = self.curve.length();
            let end = self.began + length;
            let apart = (end - b).abs();
            if apart < ROUNDING_MS {
                b = end;
            }
            self.open |= match self.rounded {
                // Also where it falls exactly on the tick: 1/acc is rounded.
                Some(rounded) => apart < rounded,
                None => apart < DOUBT_MS && apart >= ROUNDING_MS,
            };
            if b < end || self.curve.cruise != Fix::ZERO {
                self.points(a, b, out);
                return Went::On;
            }
            self.points(a, end, out);
            self.origin += self.curve.end();
            self.began = end;
            self.passes += 1;
            a = end;
            if let Some(curve) = self.pending.take() {
                (self.curve, self.passes) = (curve, 0);
                continue;
            }
            if loops > 0 && self.passes >= loops {
                self.over = true;
                return Went::Ended;
            }
        }
    }

    fn points(&self, a: Fix, b: Fix, out: &mut Vec<(Fix, Fix)>) {
        let first = out.len();
        let position = b - self.began;
        self.curve.between(a - self.began, position, out);
        out.push((position, self.curve.at(position)));
        let start = self.start + self.began;
        for (when, point) in &mut out[first..] {
            *when += start;
            *point += self.origin;
        }
    }

    /// Where it is, or was within the tick, at an instant in ms. None: another curve was in force.
    pub fn at(&self, ms: Fix) -> Option<Fix> {
        let position = ms - self.start - self.began;
        if position >= Fix::ZERO || self.passes == 0 {
            return Some(self.origin + if self.over { Fix::ZERO } else { self.curve.at(position) });
        }
        let earlier = position + self.curve.length();
        (earlier >= Fix::ZERO).then(|| self.origin - self.curve.end() + self.curve.at(earlier))
    }

    pub fn velocity(&self, at: Fix) -> Fix {
        self.curve.slope(self.position(at), true)
    }

    /// Whether another part of the curve begins at an instant, or within rounding of it.
    pub fn is_at_knot(&self, at: Fix) -> bool {
        self.curve.has_knot_near(self.position(at), DOUBT_MS)
    }
}
