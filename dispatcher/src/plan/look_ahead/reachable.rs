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
use heapless::Vec;
use libm::{fabs, sqrt};
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
/// This share of the acceleration along an arc is left at the speeds of its ends. Else it might
/// have none, and a path that a Stop or another override has slowed there would not speed up again.
const ARC_RESERVE_SHARE: f64 = 1.0 / 16.0;
/// The highest square of a speed on an arc, as a share of radius · limit: along it the reserve of
/// the limit is left.
pub(super) const ARC_SQUARE_SHARE: f64 = 0.998044963916957;
/// Three sides of a polygon within the circle of accelerations, from there to where all of it is
/// along the arc: the shares across it and along it.
const ARC_SIDES: [[f64; 2]; 3] = [
    [0.9511314484386592, 0.30878628174026473],
    [0.6846531968814578, 0.7288689868556625],
    [0.24873687789009757, 0.9685710947460112],
];
/// How far from 0 a side is, as a share of the limit.
const ARC_SIDE_SHARE: f64 = 0.9685710947460112;
/// Entries get this share more acceleration than the plan needs, for the rounding of their speeds.
const ACC_RESERVE_SHARE: f64 = 1.0 / 1048576.0;
/// A coefficient below this share of the other is a rounding error.
const ROUNDING_SHARE: f64 = 1e-9;

/// Two coordinates across an arc and three sides of a circle, or four coordinates.
pub(super) const BOUNDS_MAX: usize = 5;
/// Two lines for each side at each end, one for the others.
const LINES_MAX: usize = 16;
/// Each step brings the highest speed to another corner of the region.
const CORNERS_MAX: usize = 16;

/// y ≤ offset − slope·x above, y ≥ slope·x − offset below.
#[derive(Debug, Clone, Copy)]
struct Line {
    slope: f64,
    offset: f64,
    /// Of the corner at the end.
    end: bool,
}

/// The rule of the steps of a plan over one motion, for ends whose squares lie in `from..=to`: what
/// it gives is the step, to a few last bits. Several plans go over a motion, and most of them come
/// with an end of the same rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    rule: Rule,
    from: f32,
    to: f32,
}

#[derive(Debug, Clone, Copy)]
enum Rule {
    /// The end counts for nothing.
    Fixed(StepBack),
    /// (end + offset)/slope, on a line that bounds the end from below.
    Line { slope: f64, offset: f64 },
}

/// A step near the end of a line is not taken along it, for its rounding.
const NEAR_SHARE: f64 = 1e-6;

impl Steps {
    /// None.
    pub(super) const NONE: Steps =
        Steps { rule: Rule::Fixed(StepBack { start_square: 0.0, saturated: false }), from: 0.0, to: 0.0 };

    /// The step from this end, if the rule holds there. None holds at 0, so `NONE` serves nothing.
    #[inline]
    pub(super) fn back(&self, most: f64) -> Option<StepBack> {
        (most > 0.0 && most >= self.from.into() && most <= self.to.into()).then(|| match self.rule {
            Rule::Fixed(step) => step,
            Rule::Line { slope, offset } => StepBack { start_square: (most + offset) / slope, saturated: false },
        })
    }
}

/// The highest square at the start of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StepBack {
    pub start_square: f64,
    /// A higher one at the end would not raise it.
    pub saturated: bool,
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
    /// The share of y − x that is the acceleration.
    unit: f64,
    acc: f64,
    /// The highest x by itself: without and with the corner at the end.
    start_tops: [f64; 2],
    /// The highest y by itself.
    end_top: f64,
    /// The lines of its own acceleration, above and below.
    own: [Line; 2],
    /// The lines that bound y from above, and from below.
    above: Vec<Line, LINES_MAX>,
    below: Vec<Line, LINES_MAX>,
}

/// A positive number, or 0, as the nearest f32 that is not greater.
pub(crate) fn rounded_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { f32::from_bits(near.to_bits() - 1) } else { near }
}

/// A positive number as the nearest f32 that is not less.
fn rounded_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { f32::from_bits(near.to_bits() + 1) } else { near }
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
    #[inline]
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

    #[inline]
    fn bend(&self) -> f64 {
        if self.fixed > 0.0 { 0.0 } else { self.turn }
    }
}

impl Bound {
    /// A bound on a coordinate of a line: its part of the direction, its corners.
    #[inline]
    pub(super) fn straight(along: f64, corners: [Corner; 2], limit: f64) -> Bound {
        Bound { across: 0.0, along, round: false, corners, limit: planned(limit) }
    }

    /// The sides of an arc.
    pub(super) fn circle(radius: f64, corners: [Corner; 2], limit: f64) -> [Bound; 3] {
        let limit = planned(limit) * ARC_SIDE_SHARE;
        ARC_SIDES.map(|[across, along]| Bound { across: across / radius, along, round: true, corners, limit })
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
    #[inline]
    pub(super) fn new(length: f64, acc: f64) -> Span {
        let change = 2.0 * length * planned(acc);
        let own = [-1.0, 1.0].map(|slope| Line { slope, offset: change, end: false });
        let (above, below) = (Vec::new(), Vec::new());
        let unit = 1.0 / (2.0 * length);
        Span { length, unit, acc, start_tops: [f64::INFINITY; 2], end_top: f64::INFINITY, own, above, below }
    }

    /// It keeps this bound.
    #[inline]
    pub(super) fn add(&mut self, bound: &Bound) {
        for (corner, end) in bound.corners.iter().zip([false, true]) {
            if bound.round {
                self.reserve(bound, corner, end);
                for along in [bound.along, -bound.along] {
                    self.corner(bound, corner, end, along + along.signum() * corner.grow);
                }
            } else if corner.sign != 0.0 {
                let (along, grow) = (corner.sign * bound.along, if end { -corner.grow } else { corner.grow });
                self.corner(bound, corner, end, along + grow);
                if corner.either {
                    self.corner(bound, corner, end, grow - along);
                }
            }
        }
    }

    /// At one end of an arc, the speed that leaves the reserve.
    #[inline]
    fn reserve(&mut self, bound: &Bound, corner: &Corner, end: bool) {
        let whole = ((bound.along + corner.grow) * self.acc).min(bound.limit);
        let left = bound.limit - corner.fixed - whole * ARC_RESERVE_SHARE;
        let top = left / (bound.across + corner.bend());
        if end {
            self.end_top = self.end_top.min(top);
        } else {
            self.start_tops = self.start_tops.map(|x| x.min(top));
        }
    }

    /// The lines of a bound at one end, of which the acceleration counts `steep` times.
    #[inline]
    fn corner(&mut self, bound: &Bound, corner: &Corner, end: bool, steep: f64) {
        let steep = steep * self.unit;
        let square = bound.across + corner.bend();
        let limit = bound.limit - corner.fixed;
        let (x, y) = if end { (-steep, square + steep) } else { (square - steep, steep) };
        if fabs(y) > ROUNDING_SHARE * fabs(x) {
            let part = 1.0 / fabs(y);
            let line = Line { slope: x * part, offset: limit * part, end };
            if y < 0.0 {
                self.below.push(line).ok()
            } else {
                self.above.push(line).ok()
            };
        } else if x > 0.0 {
            let top = limit / x;
            self.start_tops[1] = self.start_tops[1].min(top);
            if !end {
                self.start_tops[0] = self.start_tops[0].min(top);
            }
        }
    }

    /// The lines that bound y at x from above and from below, with `most` and 0.
    #[inline]
    fn window(&self, x: f64, most: f64) -> [(f64, Line); 2] {
        let level = |offset| Line { slope: 0.0, offset, end: false };
        let (mut above, mut below) = ((most, level(most)), (0.0, level(0.0)));
        let mut lower = |line: &Line| {
            let y = line.offset - line.slope * x;
            if y < above.0 {
                above = (y, *line);
            }
        };
        lower(&self.own[0]);
        self.above.iter().for_each(lower);
        let mut raise = |line: &Line| {
            let y = line.slope * x - line.offset;
            if y > below.0 {
                below = (y, *line);
            }
        };
        raise(&self.own[1]);
        self.below.iter().for_each(raise);
        [above, below]
    }

    /// The highest x, at most `cap`, from which some y from 0 to `most` can be reached, and what
    /// that tells of other `most`.
    pub(super) fn start_square(&self, most: f64, cap: f64) -> (StepBack, Steps) {
        let found = self.start_square_from(most.min(self.end_top), cap);
        if most <= self.end_top {
            return found;
        }
        let step = StepBack { saturated: true, ..found.0 };
        (step, Steps { rule: Rule::Fixed(step), from: rounded_up(self.end_top), to: f32::INFINITY })
    }

    #[inline]
    fn start_square_from(&self, most: f64, cap: f64) -> (StepBack, Steps) {
        let [free, top] = self.start_tops;
        let (mut x, mut saturated, mut edge) = (cap.min(top), true, None);
        // Mostly its own acceleration bounds it.
        let [_, own] = self.own;
        if most + own.offset < x {
            (x, saturated, edge) = (most + own.offset, false, Some(own));
        }
        for _ in 0..CORNERS_MAX {
            let [(high, above), (low, below)] = self.window(x, most);
            if low <= high {
                break;
            }
            // The region is convex and contains 0: the lower line rises faster than the upper one.
            let next = (above.offset + below.offset) / (above.slope + below.slope);
            saturated = above.slope != 0.0;
            // If rounding keeps it from falling, it has arrived.
            if next.is_nan() || next >= x {
                edge = None;
                break;
            }
            (x, edge) = (next, (!saturated).then_some(below));
        }
        // A stop at the end uses nothing of the corner there.
        let mut stop = cap.min(free).min(own.offset);
        let mut holds = x <= own.offset;
        for line in self.above.iter().chain(&self.below).filter(|line| !line.end) {
            holds &= line.slope * x <= line.offset;
            if line.slope > 0.0 {
                stop = stop.min(line.offset / line.slope);
            }
        }
        let (step, [from, to]) = if x < cap && stop > x && holds {
            edge = None;
            (StepBack { start_square: stop, saturated: stop >= cap }, [0.0, most])
        } else {
            (StepBack { start_square: x.max(0.0), saturated }, [most, if saturated { f64::INFINITY } else { most }])
        };
        let steps = match edge {
            Some(edge) => self.along(&edge, [stop, cap.min(top)], most),
            None => Steps { rule: Rule::Fixed(step), from: rounded_up(from), to: rounded_down(to) },
        };
        (step, steps)
    }

    /// The steps whose x lies on this lower line, between these x, as that from `most` does.
    fn along(&self, edge: &Line, [least, top]: [f64; 2], most: f64) -> Steps {
        let Line { slope, offset, .. } = *edge;
        let part = 1.0 / slope;
        let (mut from, mut to) = ((slope * least - offset).max(0.0), (slope * top - offset).min(self.end_top));
        // The other lines hold where `steep`·y ≤ `left`.
        let mut holds = |line: &Line, steep: f64| {
            let (steep, left) = (line.slope * part + steep, line.offset - line.slope * part * offset);
            if steep > 4.0 * f64::EPSILON {
                to = to.min(left / steep);
            } else if steep < -4.0 * f64::EPSILON {
                from = from.max(left / steep);
            }
        };
        for (own, lines, steep) in [(&self.own[0], &self.above, 1.0), (&self.own[1], &self.below, -1.0)] {
            holds(own, steep);
            lines.iter().for_each(|line| holds(line, steep));
        }
        let (from, to) = (from * (1.0 + NEAR_SHARE), to * (1.0 - NEAR_SHARE));
        Steps { rule: Rule::Line { slope, offset }, from: rounded_up(from.min(most)), to: rounded_down(to.max(most)) }
    }

    /// The highest y, at most `most`, that can be reached from x.
    pub(super) fn end_square(&self, x: f64, most: f64) -> f64 {
        let [(high, _), (low, _)] = self.window(x, most.min(self.end_top));
        // A planned x is in the region, but for rounding; any other relies on a stop.
        let slack = 1e-6 * x;
        if high < low - slack || x > self.start_tops[1] + slack { 0.0 } else { high.max(0.0) }
    }

    /// The lowest y that can be reached from x.
    pub(super) fn least_end_square(&self, x: f64) -> f64 {
        let [_, (low, _)] = self.window(x, f64::INFINITY);
        low
    }

    /// Speed and acceleration for a motion with these speeds at its ends, and its time in ms. On an
    /// arc both share one limit: of the pairs tried, the one with the least time.
    pub(super) fn choose(&self, bounds: &[Bound], ends: &[EndSpeed; 2], vel: f64) -> ChosenMotion {
        let [x, y] = ends.map(|end| end.square);
        let most = bounds.iter().fold(planned(self.acc), |a, bound| a.min(bound.most(ends, self.length, vel)));
        let least = fabs(y - x) / (2.0 * self.length);
        let ramp = match most * (1.0 + LIMIT_MARGIN_SHARE) < least {
            true if x < y => FixedRamp::Up,
            true => FixedRamp::Down,
            false => FixedRamp::None,
        };
        // A line without any has that of the margin, for going on after a Stop.
        let most = most.max(least).max(self.acc * LIMIT_MARGIN_SHARE) * (1.0 + ACC_RESERVE_SHARE);
        if !bounds.iter().any(|bound| bound.round) {
            return ChosenMotion { vel, acc: most, ms: self.time(ends, vel, most), ramp };
        }
        let mut best = ChosenMotion { vel, acc: most, ms: f64::INFINITY, ramp: FixedRamp::None };
        let least = least.max(most.min(self.acc * ARC_RESERVE_SHARE));
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
        let (mut stops, mut limited, mut lowered, mut along) = (0, 0, 0, [0; 2]);
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
            bounds.iter().for_each(|bound| span.add(bound));
            let (most, cap) = (chance() * 400.0, chance() * 400.0);
            let (StepBack { start_square, saturated }, steps) = span.start_square(most, cap);
            let found = || format!("{sides:?} {length} {acc} to {most}, {cap}: {start_square} {saturated}");
            // There is an end for the highest start; trials find none for a higher one.
            let keeps = |x: f64, y: f64, slack: f64| {
                accelerates(length, x, y) <= acc * (1.0 + slack)
                    && sides.iter().all(|side| taken(side, length, [x, y], true) <= 1.0 + slack)
            };
            let ends = |x: f64| (0..=200).any(|part| keeps(x, most * f64::from(part) / 200.0, -2e-4));
            assert!((0.0..=cap).contains(&start_square), "{}", found());
            assert!(keeps(start_square, span.end_square(start_square, most), 1e-5), "{}", found());
            if start_square < cap {
                lowered += 1;
                assert!(!ends(start_square * 1.001), "{}", found());
            }
            if saturated {
                assert!(
                    span.start_square(most * 2.0, cap).0.start_square <= start_square * (1.0 + 1e-12),
                    "{}",
                    found()
                );
            }
            // What a kept rule gives is the step, but for the last bits.
            for _ in 0..8 {
                let most = most * 2.0 * chance();
                if let Some(kept) = steps.back(most) {
                    let (step, _) = span.start_square(most, cap);
                    let same = (kept.start_square - step.start_square).abs() <= 4.0 * f64::EPSILON * step.start_square;
                    assert!(same && kept.saturated == step.saturated, "{kept:?} {step:?} {steps:?} {}", found());
                    along[usize::from(step.saturated)] += 1;
                }
            }
            let x = start_square * chance().sqrt();
            let y = span.end_square(x, most);
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
        assert!(along.iter().all(|steps| *steps > 30_000), "{along:?}");
    }
}
