//! Speeds that can be reached over one motion when corners at both ends use part of the
//! acceleration.
//!
//! In: bounds of a motion, the square of the speed at one end. Out: the highest square at the
//! other. Owns nothing. Fails: never.
//!
//! Let x and y be the squares of the speeds at start and end, and a = (y − x)/2l. Each bound at
//! each end is a straight line in the plane of x and y; all of them enclose a region around 0
//! (decision 9). At standstill a corner uses nothing, so a stop that was possible before the corner
//! was known stays possible: x with y = 0 is allowed outside the region.
use core::f64::consts::FRAC_PI_6;
use heapless::Vec;
use libm::{cos, fabs, sin, sqrt};
use servo::path::FixedRamp;

/// The acceleration of a coordinate that a corner uses, between the middles of the motions on both
/// sides. It is at most `fixed` + `bend`·v² + `grow`·a, with the speed v in the corner and the
/// acceleration a away from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    /// |Δ| over the mean length: `bend`, where nothing is fixed.
    turn: f64,
    fixed: f64,
    grow: f64,
    /// The sign of its change of velocity: −1, 0, 1.
    sign: f64,
    /// Either sign.
    either: bool,
}

/// A bound: on a coordinate of a line, or on the sum on an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bound {
    /// The share of v².
    across: f64,
    /// The share of the acceleration, with its sign on a line.
    along: f64,
    /// Of either sign, as directions change.
    round: bool,
    corners: [Corner; 2],
    limit: f64,
}

/// Plans stay below the limits by this share: directions are kept as f32.
const LIMIT_MARGIN_SHARE: f64 = 1.0 / 16384.0;
/// Times that differ by this share are one.
const SAME_TIME_SHARE: f64 = 1e-9;
/// Entries get this share more acceleration than the plan needs, for the rounding of their speeds.
const ACC_RESERVE_SHARE: f64 = 1.0 / 1048576.0;
/// A coefficient below this share of the other is a rounding error.
const ROUNDING_SHARE: f64 = 1e-9;

/// Two coordinates across an arc and three sides of a circle, or four coordinates.
pub(super) const BOUNDS_MAX: usize = 5;
/// The acceleration, two lines for each side at each end, one for the others.
const LINES_MAX: usize = 18;
/// Each step brings the highest speed to another corner of the region.
const CORNERS_MAX: usize = 16;

/// y ≤ offset − slope·x, or y ≥ slope·x − offset.
#[derive(Debug, Clone, Copy)]
struct Constraint {
    slope: f64,
    offset: f64,
    lower: bool,
    /// Of the corner at the end.
    end: bool,
}

/// How a motion is driven: its highest speed, its acceleration, its time in ms.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChosenMotion {
    pub vel: f64,
    pub acc: f64,
    pub ms: f64,
    pub ramp: FixedRamp,
}

/// A speed at an end of a motion. Its root takes longer than all else that is done with it.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndSpeed {
    square: f64,
    pub speed: f64,
}

impl EndSpeed {
    /// Of the square of a speed.
    pub(super) fn of(square: f64) -> EndSpeed {
        EndSpeed { square, speed: sqrt(square) }
    }
}

/// A motion between two junctions.
#[derive(Debug)]
pub(super) struct Span {
    length: f64,
    /// The highest x by itself: without and with the corner at the end.
    tops: [f64; 2],
    lines: Vec<Constraint, LINES_MAX>,
}

/// The part of a limit that plans use.
fn planned(limit: f64) -> f64 {
    limit * (1.0 - LIMIT_MARGIN_SHARE)
}

/// The greatest acceleration with which a motion keeps this mean one from its end to its middle. At
/// `vel` it goes on at that, so the mean is at most 1/(l/2v² + 1/2a), from standstill; if it does
/// not reach `vel` before the middle, it is a.
fn with_mean(mean: f64, length: f64, vel: f64) -> f64 {
    let (reach, square) = (mean * length, vel * vel);
    if reach <= square {
        mean
    } else if reach < 2.0 * square {
        mean * square / (2.0 * square - reach)
    } else {
        f64::INFINITY
    }
}

impl Corner {
    /// None.
    pub(super) const NONE: Corner = Corner { turn: 0.0, fixed: 0.0, grow: 0.0, sign: 0.0, either: false };

    /// A change of direction, over the mean length of the motions on both sides, at the end of a
    /// motion of this length. `fastest`, if given, is the highest product of the speeds at its
    /// ends: it is the closer bound on a long motion. `either`: the turn may go to either side.
    pub(super) fn new((turn, either): (f64, bool), length: f64, fastest: Option<f64>, limit: f64) -> Corner {
        let sign = if turn > 0.0 { 1.0 } else { -1.0 };
        let turn = fabs(turn);
        match fastest.map(|squares| turn * squares) {
            _ if turn == 0.0 => Corner::NONE,
            Some(fixed) if fixed < limit / 2.0 => {
                Corner { turn, fixed: fixed.max(f64::MIN_POSITIVE), grow: 0.0, sign, either }
            }
            _ => Corner { turn, fixed: 0.0, grow: turn * length / 4.0, sign, either },
        }
    }

    fn bend(&self) -> f64 {
        if self.fixed > 0.0 { 0.0 } else { self.turn }
    }

    /// The signs that its change of velocity may have.
    fn signs(&self) -> impl Iterator<Item = f64> {
        let one = (self.sign != 0.0).then_some(self.sign);
        one.into_iter().chain(one.filter(|_| self.either).map(|sign| -sign))
    }
}

impl Bound {
    /// A bound on a coordinate of a line: its part of the direction, its corners.
    pub(super) fn straight(along: f64, corners: [Corner; 2], limit: f64) -> Bound {
        Bound { across: 0.0, along, round: false, corners, limit: planned(limit) }
    }

    /// The polygon within a circle of accelerations: along an arc, and v²/R across it.
    pub(super) fn circle(radius: f64, corners: [Corner; 2], limit: f64) -> [Bound; 3] {
        [0.5, 1.5, 2.5].map(|side| {
            let across = cos(side * FRAC_PI_6) / radius;
            let limit = planned(limit) * cos(FRAC_PI_6 / 2.0);
            Bound { across, along: sin(side * FRAC_PI_6), round: true, corners, limit }
        })
    }

    /// The greatest acceleration in either direction over a motion of this length and highest
    /// speed, with these speeds at both ends. At standstill a corner uses nothing.
    fn most(&self, ends: &[EndSpeed; 2], length: f64, vel: f64) -> f64 {
        self.corners.iter().zip(ends).fold(f64::INFINITY, |a, (corner, &EndSpeed { square, speed })| {
            let corner = if square > 0.0 { corner } else { &Corner::NONE };
            let left = self.limit - corner.fixed - (self.across + corner.bend()) * square;
            let (along, steep) = (fabs(self.along), fabs(self.along) + corner.grow);
            if steep <= 0.0 {
                return a;
            }
            let whole = left / steep;
            if whole >= a || corner.fixed == 0.0 || self.round || along <= 0.0 {
                return a.min(whole);
            }
            // The speed from the corner to the middle is at most `vel`.
            let mean = (self.limit - corner.turn * speed * vel) / along;
            a.min(whole.max(with_mean(mean, length, vel)))
        })
    }
}

impl Span {
    /// A motion of this length, with an acceleration of its own.
    pub(super) fn new(length: f64, acc: f64) -> Span {
        let mut span = Span { length, tops: [f64::INFINITY; 2], lines: Vec::new() };
        let change = 2.0 * length * planned(acc);
        span.push(Constraint { slope: -1.0, offset: change, lower: false, end: false });
        span.push(Constraint { slope: 1.0, offset: change, lower: true, end: false });
        span
    }

    /// It keeps this bound.
    pub(super) fn keep(&mut self, bound: &Bound) {
        let unit = 1.0 / (2.0 * self.length);
        let [start, end] = &bound.corners;
        if bound.round {
            for along in [bound.along, -bound.along] {
                self.corner(bound, start, false, (along + along.signum() * start.grow) * unit);
                self.corner(bound, end, true, (along + along.signum() * end.grow) * unit);
            }
            return;
        }
        for sign in start.signs() {
            self.corner(bound, start, false, (sign * bound.along + start.grow) * unit);
        }
        for sign in end.signs() {
            self.corner(bound, end, true, (sign * bound.along - end.grow) * unit);
        }
    }

    fn push(&mut self, line: Constraint) {
        self.lines.push(line).ok();
    }

    /// The lines of a bound at one end, of which the acceleration uses `steep`·(y − x).
    fn corner(&mut self, bound: &Bound, corner: &Corner, end: bool, steep: f64) {
        let square = bound.across + corner.bend();
        let limit = bound.limit - corner.fixed;
        let (x, y) = if end { (-steep, square + steep) } else { (square - steep, steep) };
        if fabs(y) > ROUNDING_SHARE * fabs(x) {
            let part = 1.0 / fabs(y);
            let lower = y < 0.0;
            let slope = x * part;
            self.push(Constraint { slope, offset: limit * part, lower, end });
        } else if x > 0.0 {
            let top = limit / x;
            self.tops[1] = self.tops[1].min(top);
            if !end {
                self.tops[0] = self.tops[0].min(top);
            }
        }
    }

    /// The lines that bound y at x from above and from below, with `most` and 0.
    fn window(&self, x: f64, most: f64) -> [(f64, Constraint); 2] {
        let line = |offset, lower| Constraint { slope: 0.0, offset, lower, end: false };
        let (mut above, mut below) = ((most, line(most, false)), (0.0, line(0.0, true)));
        for line in &self.lines {
            if line.lower {
                let y = line.slope * x - line.offset;
                if y > below.0 {
                    below = (y, *line);
                }
            } else {
                let y = line.offset - line.slope * x;
                if y < above.0 {
                    above = (y, *line);
                }
            }
        }
        [above, below]
    }

    /// The highest x, at most `cap`, from which some y from 0 to `most` can be reached; true if a
    /// higher `most` would not raise it.
    pub(super) fn back(&self, most: f64, cap: f64) -> (f64, bool) {
        let [free, top] = self.tops;
        let (mut x, mut settled) = (cap.min(top), true);
        for _ in 0..CORNERS_MAX {
            let [(high, above), (low, below)] = self.window(x, most);
            if low <= high {
                break;
            }
            // The region is convex and contains 0: the lower line rises faster than the upper one.
            let next = (above.offset + below.offset) / (above.slope + below.slope);
            settled = above.slope != 0.0;
            // If rounding keeps it from falling, it has arrived.
            if next.is_nan() || next >= x {
                break;
            }
            x = next;
        }
        // A stop at the end uses nothing of the corner there.
        let stops = self.lines.iter().filter(|line| !line.end);
        if x < cap && stops.clone().all(|line| line.slope * x <= line.offset) {
            let ends = stops.filter(|line| line.slope > 0.0).map(|line| line.offset / line.slope);
            let remainder = ends.fold(cap.min(free), f64::min);
            if remainder > x {
                return (remainder, remainder >= cap);
            }
        }
        (x.max(0.0), settled)
    }

    /// The highest y, at most `most`, that can be reached from x.
    pub(super) fn on(&self, x: f64, most: f64) -> f64 {
        let [(high, _), (low, _)] = self.window(x, most);
        // A planned x is in the region, but for rounding; any other relies on a stop.
        let slack = 1e-6 * x;
        if high < low - slack || x > self.tops[1] + slack { 0.0 } else { high.max(0.0) }
    }

    /// The lowest y that can be reached from x.
    pub(super) fn least(&self, x: f64) -> f64 {
        let [_, (low, _)] = self.window(x, f64::INFINITY);
        low
    }

    /// Speed and acceleration for a motion with these speeds at its ends, and its time in ms. On an
    /// arc both share one limit: of the pairs tried, the one with the least time.
    pub(super) fn choose(&self, bounds: &[Bound], ends: &[EndSpeed; 2], vel: f64, acc: f64) -> ChosenMotion {
        let [x, y] = ends.map(|end| end.square);
        let most = bounds.iter().fold(planned(acc), |a, bound| a.min(bound.most(ends, self.length, vel)));
        let least = fabs(y - x) / (2.0 * self.length);
        let ramp = match most * (1.0 + LIMIT_MARGIN_SHARE) < least {
            true if x < y => FixedRamp::Up,
            true => FixedRamp::Down,
            false => FixedRamp::None,
        };
        let most = most.max(least) * (1.0 + ACC_RESERVE_SHARE);
        if !bounds.iter().any(|bound| bound.round) {
            return ChosenMotion { vel, acc: most, ms: self.time(ends, vel, most), ramp };
        }
        let mut best = ChosenMotion { vel, acc: most, ms: f64::INFINITY, ramp: FixedRamp::None };
        for part in 0..=8 {
            let acc = least + (most - least) * part as f64 / 8.0;
            let square = bounds.iter().filter(|bound| bound.round).fold(vel * vel, |v, bound| {
                bound.corners.iter().fold(v, |v, corner| {
                    let left = bound.limit - corner.fixed - (bound.along + corner.grow) * acc;
                    v.min(left / (bound.across + corner.bend()))
                })
            });
            let top = sqrt(square.max(x).max(y));
            let time = self.time(ends, top, acc);
            // At one time the greater acceleration: after a Stop the motion begins with it.
            if time <= best.ms * (1.0 + SAME_TIME_SHARE) {
                best = ChosenMotion { vel: top, acc, ms: time, ..best };
            }
        }
        best
    }

    /// Time of a trapezoid.
    fn time(&self, ends: &[EndSpeed; 2], vel: f64, acc: f64) -> f64 {
        let [x, y] = ends.map(|end| end.square);
        let peak = sqrt(((x + y) / 2.0 + acc * self.length).min(vel * vel));
        if acc <= 0.0 || peak <= 0.0 {
            return if peak > 0.0 { self.length / peak } else { f64::INFINITY };
        }
        let cruise = self.length - (2.0 * peak * peak - x - y) / (2.0 * acc);
        (2.0 * peak - ends[0].speed - ends[1].speed) / acc + cruise.max(0.0) / peak
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_xoshiro::SplitMix64;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::format;

    /// A coordinate of a line: its part of the direction, the turns at both ends over the mean
    /// lengths, its limit.
    #[derive(Debug, Clone, Copy)]
    struct Side {
        along: f64,
        turns: [f64; 2],
        limit: f64,
    }

    /// The largest part of the limit that a motion of constant acceleration from x to y uses at
    /// each end, by decision 9. It is the acceleration, and the turn by the speed in the corner and
    /// the mean speed from there to the middle. With `straight` a mean replaces that product, as in
    /// plans.
    fn taken(side: &Side, length: f64, [x, y]: [f64; 2], straight: bool) -> f64 {
        let a = (y - x) / (2.0 * length);
        let middle = (x + y) / 2.0;
        let ends = [x, y].into_iter().zip(side.turns).filter(|(square, _)| *square > 0.0);
        let taken = ends.map(|(square, turn)| {
            let product = if straight { (square + middle) / 2.0 } else { (square * middle).sqrt() };
            turn.abs() * (square + product) / 2.0 + side.along * turn.signum() * a
        });
        taken.fold(0.0, f64::max) / side.limit
    }

    fn accelerates(length: f64, x: f64, y: f64) -> f64 {
        (y - x).abs() / (2.0 * length)
    }

    /// From a speed that can be kept, a step reaches one that keeps all limits and is as high as
    /// straight bounds allow. The highest start is the highest that has an end.
    #[test]
    fn steps_keep_their_limits_and_go_as_high_as_they_can() {
        let mut numbers = SplitMix64::seed_from_u64(3);
        let mut chance = || (numbers.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let (mut stops, mut limited, mut lowered) = (0, 0, 0);
        for _ in 0..100_000 {
            let length = 10.0 + 200.0 * chance();
            let acc = 0.5 + chance();
            let sides = [0, 1].map(|_| Side {
                along: 2.0 * chance() - 1.0,
                turns: [0, 1].map(|_| (2.0 * chance() - 1.0).powi(3) * 2.0 / length),
                limit: 0.5 + chance(),
            });
            let acc = sides.iter().fold(acc, |acc, side| acc.min(side.limit / side.along.abs()));
            let bounds = sides.map(|side| {
                let corners = side.turns.map(|turn| Corner::new((turn, false), length, None, side.limit));
                Bound::straight(side.along, corners, side.limit)
            });
            let mut span = Span::new(length, acc);
            bounds.iter().for_each(|bound| span.keep(bound));
            let (most, cap) = (chance() * 400.0, chance() * 400.0);
            let (high, settled) = span.back(most, cap);
            let found = || format!("{sides:?} {length} {acc} to {most}, {cap}: {high} {settled}");
            // There is an end for the highest start; trials find none for a higher one.
            let keeps = |x: f64, y: f64, slack: f64| {
                accelerates(length, x, y) <= acc * (1.0 + slack)
                    && sides.iter().all(|side| taken(side, length, [x, y], true) <= 1.0 + slack)
            };
            let ends = |x: f64| (0..=200).any(|part| keeps(x, most * f64::from(part) / 200.0, -2e-4));
            assert!((0.0..=cap).contains(&high), "{}", found());
            assert!(keeps(high, span.on(high, most), 1e-5), "{}", found());
            if high < cap {
                lowered += 1;
                assert!(!ends(high * 1.001), "{}", found());
            }
            if settled {
                assert!(span.back(most * 2.0, cap).0 <= high * (1.0 + 1e-12), "{}", found());
            }
            let x = high * chance().sqrt();
            let y = span.on(x, most);
            assert!((0.0..=most).contains(&y));
            for side in &sides {
                let [exact, planned] = [false, true].map(|straight| taken(side, length, [x, y], straight));
                assert!(exact <= 1.0 && exact <= planned + 1e-12, "{exact} {planned} {x} {y} {}", found());
            }
            assert!(accelerates(length, x, y) <= acc, "{x} {y} {}", found());
            if y == 0.0 {
                stops += 1;
            } else if y < most * 0.999 {
                limited += 1;
                assert!(!keeps(x, y * 1.001, -2e-4), "{x} {y} {}", found());
            }
        }
        assert!(stops > 100 && limited > 10_000 && lowered > 10_000, "{stops} {limited} {lowered}");
    }
}
