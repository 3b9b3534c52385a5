//! What speeds can be reached over one motion, when corners at both ends take their share of the acceleration.
//!
//! In: bounds of a motion, the square of the speed at one end. Out: the highest square at the other. Nothing fails.
//!
//! With x and y the squares of the speeds at start and end and a = (y − x)/2l, each bound says
//! start·x + along·|a| ≤ limit at the start and end·y + along·|a| ≤ limit at the end: straight lines in the plane of
//! x and y. Where a corner is passed, `along` holds some of it as well; at rest it does not, so that a stop is always
//! possible that was possible before the corner was known.
use core::f64::consts::FRAC_PI_6;
use libm::{cos, sin, sqrt};

/// A bound; see the module text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bound {
    pub(super) start: f64,
    pub(super) end: f64,
    /// At the start, at the end, and at an end that is at rest.
    pub(super) along: [f64; 3],
    pub(super) limit: f64,
}

/// Plans use so much less than the limits: while the speed changes, the time between the middles of two motions is
/// not quite their length over the speed between them.
const MARGIN: f64 = 1.0 / 128.0;
/// Entries get so much more acceleration than the plan needs: what the rounding of their speeds takes.
const SPARE: f64 = 1.0 / 1048576.0;

/// Four coordinates, the motion's own acceleration, three sides of a circle.
const BOUNDS: usize = 8;

/// A motion between two junctions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    length: f64,
    bounds: [Bound; BOUNDS],
    count: usize,
}

/// What plans use of a limit.
pub(super) fn planned(limit: f64) -> f64 {
    limit * (1.0 - MARGIN)
}

/// The polygon within a circle of accelerations: along an arc, and v²/R across it.
pub(super) fn circle(radius: f64, limit: f64) -> [Bound; 3] {
    [0.5, 1.5, 2.5].map(|side| {
        let across = cos(side * FRAC_PI_6) / radius;
        let limit = limit * cos(FRAC_PI_6 / 2.0);
        Bound { start: across, end: across, along: [sin(side * FRAC_PI_6); 3], limit }
    })
}

impl Span {
    /// Of this length, with an acceleration of its own.
    pub(super) fn new(length: f64, acc: f64) -> Span {
        let first = Bound { start: 0.0, end: 0.0, along: [1.0; 3], limit: planned(acc) };
        Span { length, bounds: [first; BOUNDS], count: 1 }
    }

    /// One more bound.
    pub(super) fn add(&mut self, bound: Bound) {
        if let Some(place) = self.bounds.get_mut(self.count) {
            *place = Bound { limit: planned(bound.limit), ..bound };
            self.count += 1;
        }
    }

    fn bounds(&self) -> &[Bound] {
        self.bounds.get(..self.count).unwrap_or(&self.bounds)
    }

    /// What a difference of the squares takes of a bound: at the start, at the end.
    fn steep(&self, b: &Bound, x: f64, y: f64) -> [f64; 2] {
        let [start, end, rest] = b.along.map(|along| along / (2.0 * self.length));
        [if x > 0.0 { start } else { rest }, if y > 0.0 { end } else { rest }]
    }

    /// The highest x from which y can be met.
    fn before(&self, y: f64) -> f64 {
        self.bounds().iter().fold(f64::INFINITY, |x, b| {
            let [g, h] = self.steep(b, 1.0, y);
            x.min((b.limit + g * y) / (b.start + g)).min(y + (b.limit - b.end * y) / h)
        })
    }

    /// The highest x, at most `cap`, from which some y from 0 to `most` can be met.
    pub(super) fn back(&self, most: f64, cap: f64) -> f64 {
        let x = self.before(0.0).max(self.before(most));
        if x >= cap {
            return cap;
        }
        // A sharp corner at the end may leave more for braking if it is taken slower: `before` rises, then falls.
        if most > 0.0 && self.before(most * (1.0 - 1e-9)) > x {
            let (mut low, mut high) = (0.0, most);
            for _ in 0..60 {
                let third = (high - low) / 3.0;
                if self.before(low + third) < self.before(high - third) {
                    low += third;
                } else {
                    high -= third;
                }
            }
            return x.max(self.before((low + high) / 2.0)).min(cap);
        }
        x
    }

    /// The highest y, at most `most`, that can be met from x.
    pub(super) fn on(&self, x: f64, most: f64) -> f64 {
        let mut y = self.bounds().iter().fold(most, |y, b| {
            let [g, h] = self.steep(b, x, 1.0);
            y.min(x + (b.limit - b.start * x) / g).min((b.limit + h * x) / (b.end + h))
        });
        if y < x {
            // It slows down: a sharp corner at the end is another kind of bound, and it must be able to brake so hard.
            let mut least = 0.0f64;
            for b in self.bounds() {
                let [g, h] = self.steep(b, x, 1.0);
                if b.end > h {
                    y = y.min((b.limit - h * x) / (b.end - h));
                } else if b.end < h {
                    least = least.max((h * x - b.limit) / (h - b.end));
                }
                least = least.max(x - (b.limit - b.start * x) / g);
            }
            if y < least - 1e-6 * x {
                return 0.0;
            }
        }
        y.max(0.0)
    }

    /// Speed and acceleration for a motion from x to y, and its time in ms. On an arc, where both share one limit,
    /// the pair of those tried that takes the least time.
    pub(super) fn choose(&self, x: f64, y: f64, vel: f64, round: bool) -> (f64, f64, f64) {
        let most = self.bounds().iter().fold(f64::INFINITY, |a, b| {
            let [g, h] = self.steep(b, x, y).map(|steep| steep * 2.0 * self.length);
            a.min((b.limit - b.start * x) / g).min((b.limit - b.end * y) / h)
        });
        let least = (y - x).abs() / (2.0 * self.length);
        let most = most.max(least) * (1.0 + SPARE);
        if !round {
            return (vel, most, self.time(x, y, vel, most));
        }
        let mut best = (vel, most, f64::INFINITY);
        for part in 0..=8 {
            let acc = least + (most - least) * part as f64 / 8.0;
            let square = self.bounds().iter().fold(vel * vel, |v, b| {
                if b.start > 0.0 && b.start == b.end { v.min((b.limit - b.along[0] * acc) / b.start) } else { v }
            });
            let top = sqrt(square.max(x).max(y));
            let time = self.time(x, y, top, acc);
            if time < best.2 {
                best = (top, acc, time);
            }
        }
        best
    }

    /// Time of a trapezoid.
    fn time(&self, x: f64, y: f64, vel: f64, acc: f64) -> f64 {
        let peak = sqrt(((x + y) / 2.0 + acc * self.length).min(vel * vel));
        if acc <= 0.0 || peak <= 0.0 {
            return if peak > 0.0 { self.length / peak } else { f64::INFINITY };
        }
        let cruise = self.length - (2.0 * peak * peak - x - y) / (2.0 * acc);
        (2.0 * peak - sqrt(x) - sqrt(y)) / acc + cruise.max(0.0) / peak
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chance(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 * (1.0 / 9007199254740992.0)
    }

    /// Whether a motion from x to y keeps all bounds, but for `slack` of them.
    fn keeps(span: &Span, x: f64, y: f64, slack: f64) -> bool {
        span.bounds().iter().all(|b| {
            let [start, end, rest] = b.along;
            let along = [if x > 0.0 { start } else { rest }, if y > 0.0 { end } else { rest }];
            let a = (y - x).abs() / (2.0 * span.length);
            let limit = b.limit * (1.0 + slack);
            b.start * x + along[0] * a <= limit && b.end * y + along[1] * a <= limit
        })
    }

    /// From what can be kept, a step goes to what keeps all bounds, and not lower than it must.
    #[test]
    fn steps_keep_their_bounds_and_go_as_high_as_they_can() {
        let mut state = 3;
        let (mut stops, mut limited) = (0, 0);
        for _ in 0..100_000 {
            let length = 10.0 + 200.0 * chance(&mut state);
            let mut span = Span::new(length, 0.5 + chance(&mut state));
            for _ in 0..2 {
                let share = chance(&mut state);
                let [start, end] = [0, 1].map(|_| chance(&mut state).powi(3) * 2.0 / length);
                let along = [start, end, 0.0].map(|bend| share + bend * length / 2.0);
                span.add(Bound { start, end, along, limit: 0.5 + chance(&mut state) });
            }
            let ends = span.bounds().iter().fold((f64::INFINITY, f64::INFINITY), |(s, e), b| {
                (
                    if b.start > 0.0 { s.min(b.limit / b.start) } else { s },
                    if b.end > 0.0 { e.min(b.limit / b.end) } else { e },
                )
            });
            let most = (chance(&mut state) * 400.0).min(ends.1);
            let x = span.back(most, ends.0) * chance(&mut state).sqrt();
            let y = span.on(x, most);
            assert!((0.0..=most).contains(&y));
            assert!(keeps(&span, x, y, 1e-4), "{span:?} {x} {y} {most}");
            if y == 0.0 {
                stops += 1;
            } else if y < most * 0.999 {
                limited += 1;
                assert!(!keeps(&span, x, y * 1.001, -1e-4), "{span:?} {x} {y} {most}");
            }
        }
        assert!(stops > 100 && limited > 10_000, "{stops} {limited}");
    }
}
