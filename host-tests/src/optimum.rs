//! The least time for a polyline under limits, computed offline: reachable sets backwards, then
//! greedily forwards over all of it (time-optimal path parameterisation). It shares only the
//! meaning of the limits with the look-ahead. Between the middles of two motions the mean
//! acceleration of a coordinate is within its limit. A corner changes its velocity by no more than
//! that limit gives in the corner time.

/// A position, pulses.
pub type Point = [f64; 2];

/// Limits of a path in a plane: pulse/ms, pulse/ms², ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Along the path.
    pub speed: f64,
    /// Along the path.
    pub acc: f64,
    /// Of each coordinate.
    pub axis_speed: [f64; 2],
    /// Of each coordinate.
    pub axis_acc: [f64; 2],
    /// Time that a corner takes as a change of velocity.
    pub corner: f64,
}

/// How a turn and a change of the speed share the acceleration of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// Their amounts are added, whatever their directions.
    Adds,
    /// They are added with their signs, on each side of a corner by itself: so the mean keeps the
    /// limit. What a motion does by itself keeps it too.
    Signed,
    /// The same, but a corner counts with the motion after it only: quicker, and no plan that
    /// keeps the limits.
    AfterOnly,
}

/// `a` times the acceleration and `z` times the square of the speed are at most `most`.
#[derive(Debug, Clone, Copy)]
struct Constraint {
    a: f64,
    z: f64,
    most: f64,
}

impl Constraint {
    fn holds(&self, a: f64, z: f64) -> bool {
        self.a * a + self.z * z <= self.most + 1e-9 * (1.0 + self.most.abs())
    }
}

/// The greatest square of the speed that some acceleration allows.
fn greatest(constraints: &[Constraint]) -> f64 {
    let mut best = 0.0f64;
    for (index, one) in constraints.iter().enumerate() {
        for other in &constraints[index + 1..] {
            let det = one.a * other.z - one.z * other.a;
            if det.abs() < 1e-15 {
                continue;
            }
            let a = (one.most * other.z - one.z * other.most) / det;
            let z = (one.a * other.most - one.most * other.a) / det;
            if z > best && constraints.iter().all(|constraint| constraint.holds(a, z)) {
                best = z;
            }
        }
    }
    best
}

/// The speed at each point of the polyline, and the time, ms.
pub fn plan(points: &[Point], limits: &Limits, turns: Turn) -> (Vec<f64>, f64) {
    let displacement = |from: &Point, to: &Point| {
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        let length = x.hypot(y);
        (length, [x / length, y / length])
    };
    let motions: Vec<_> = points.windows(2).map(|pair| displacement(&pair[0], &pair[1])).collect();
    let count = motions.len();
    let along = |direction: [f64; 2]| {
        let own = (0..2).map(|axis| limits.axis_speed[axis] / direction[axis].abs());
        own.fold(limits.speed, f64::min).powi(2)
    };
    // What holds at the begin of motion i, for its acceleration and the square of the speed there.
    let at = |index: usize| {
        let (length, direction) = motions[index];
        let (before, previous) = motions[index.saturating_sub(1)];
        let mut constraints = vec![
            Constraint { a: 1.0, z: 0.0, most: limits.acc },
            Constraint { a: -1.0, z: 0.0, most: limits.acc },
            Constraint { a: 0.0, z: -1.0, most: 0.0 },
            Constraint { a: -2.0 * length, z: -1.0, most: 0.0 },
            Constraint { a: 0.0, z: 1.0, most: along(direction).min(along(previous)) },
        ];
        for axis in 0..2 {
            let turn = direction[axis] - previous[axis];
            let (mean, bend) = ((direction[axis] + previous[axis]) / 2.0, 2.0 * turn / (length + before));
            let most = limits.axis_acc[axis];
            // The corner at the end of the motion, where the square of the speed is z + 2·length·a.
            let (after, next) = motions.get(index + 1).copied().unwrap_or((length, direction));
            let bend_end = 2.0 * (next[axis] - direction[axis]) / (length + after);
            for sign in [1.0, -1.0] {
                let own = sign * direction[axis];
                match turns {
                    Turn::Adds => {
                        constraints.push(Constraint { a: sign * mean, z: bend, most });
                        constraints.push(Constraint { a: sign * mean, z: -bend, most });
                    }
                    Turn::AfterOnly => constraints.push(Constraint { a: sign * mean, z: sign * bend, most }),
                    Turn::Signed => {
                        // From a corner to the middle of the motion the square of the speed changes
                        // by length·a; its product with the mean speed there by a quarter of that.
                        let quarter = length / 4.0;
                        let start = Constraint { a: own + sign * bend * quarter, z: sign * bend, most };
                        let end = Constraint {
                            a: own + sign * bend_end * (2.0 * length - quarter),
                            z: sign * bend_end,
                            most,
                        };
                        constraints.extend([start, end, Constraint { a: own, z: 0.0, most }]);
                    }
                }
            }
            if turn != 0.0 {
                constraints.push(Constraint { a: 0.0, z: 1.0, most: (most * limits.corner / turn).powi(2) });
            }
        }
        constraints
    };
    // The greatest squares from which the end can be reached.
    let mut reach = vec![0.0; count + 1];
    for index in (0..count).rev() {
        let mut constraints = at(index);
        constraints.push(Constraint { a: 2.0 * motions[index].0, z: 1.0, most: reach[index + 1] });
        reach[index] = greatest(&constraints);
    }
    let mut squares = vec![0.0; count + 1];
    for index in 0..count {
        let (z, length) = (squares[index], motions[index].0);
        let room = at(index).into_iter().filter(|constraint| constraint.a > 1e-12);
        let most = room.map(|constraint| (constraint.most - constraint.z * z) / constraint.a).fold(f64::MAX, f64::min);
        squares[index + 1] = (z + 2.0 * length * most).clamp(0.0, reach[index + 1]);
    }
    let speeds: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
    let ms = motions.iter().zip(speeds.windows(2)).map(|(motion, speeds)| 2.0 * motion.0 / (speeds[0] + speeds[1]));
    let ms = ms.sum();
    (speeds, ms)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Limits = Limits { speed: 10.0, acc: 2.0, axis_speed: [1e9; 2], axis_acc: [1e9; 2], corner: 1e9 };

    fn near(found: f64, expected: f64, part: f64) {
        assert!((found - expected).abs() < part * expected, "{found} for {expected}");
    }

    /// Closed forms.
    #[test]
    fn lines_and_circles() {
        let line: Vec<Point> = (0..=500).map(|x| [f64::from(x), 0.0]).collect();
        // 5 ms up, 45 ms, 5 ms down.
        near(plan(&line, &FREE, Turn::Adds).1, 55.0, 1e-3);
        // The axis allows less: 8 pulse/ms with 1 pulse/ms²: 8 ms up over 32, 436/8, 8 ms down.
        let slow = Limits { axis_speed: [8.0; 2], axis_acc: [1.0; 2], ..FREE };
        near(plan(&line, &slow, Turn::Adds).1, 16.0 + 54.5, 1e-3);
        // Ten times round a circle of 1000 pulses: v² = 1000 where an axis turns by itself, less
        // nowhere else.
        let circle: Vec<Point> = (0..=12_000)
            .map(|step| {
                let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / 1200.0).sin_cos();
                [1000.0 * cos, 1000.0 * sin]
            })
            .collect();
        let round = Limits { speed: 1e3, acc: 1.0, axis_acc: [1.0; 2], ..FREE };
        for turns in [Turn::Adds, Turn::Signed, Turn::AfterOnly] {
            near(plan(&circle, &round, turns).1, 20_000.0 * std::f64::consts::PI / 1000f64.sqrt(), 0.02);
        }
        // A right angle: v·1 ≤ 2·0.5 in the corner, from which 5 ms and 0.5 ms less a ramp each.
        let corner = Limits { axis_acc: [2.0; 2], corner: 0.5, ..FREE };
        let mut angle = line.clone();
        angle.extend((1..=500).map(|y| [500.0, f64::from(y)]));
        let (speeds, ms) = plan(&angle, &corner, Turn::Adds);
        near(speeds[500], 1.0, 1e-6);
        near(ms, 2.0 * (5.0 + 4.5 + (500.0 - 25.0 - 24.75) / 10.0), 2e-3);
    }

    /// A zigzag that winds: its plans keep the acceleration between the middles of the ways, but
    /// for the one that looks at one side of the corners.
    #[test]
    fn signed_plans_keep_the_limits_between_middles() {
        let points: Vec<Point> = (0..3000)
            .map(|step| {
                let (sin, cos) = (f64::from(step) * 0.05).sin_cos();
                let out = 2000.0 + f64::from(step) * 0.3 + f64::from(step * 7 % 5);
                [(out * cos).round(), (out * sin).round()]
            })
            .collect();
        let limits = Limits { speed: 300.0, acc: 4.0, axis_speed: [250.0, 200.0], axis_acc: [3.0, 2.0], corner: 5.0 };
        let hardest = |turns| {
            let (speeds, _) = plan(&points, &limits, turns);
            let middle = |k: usize| ((speeds[k].powi(2) + speeds[k + 1].powi(2)) / 2.0).sqrt();
            let displacement = |k: usize| [0, 1].map(|axis: usize| points[k + 1][axis] - points[k][axis]);
            let mut worst = 0.0f64;
            for k in 0..speeds.len() - 2 {
                let [from, to] = [displacement(k), displacement(k + 1)];
                let [one, two] = [from[0].hypot(from[1]), to[0].hypot(to[1])];
                let ms = one / (middle(k) + speeds[k + 1]) + two / (middle(k + 1) + speeds[k + 1]);
                for axis in 0..2 {
                    let change = to[axis] / two * middle(k + 1) - from[axis] / one * middle(k);
                    worst = worst.max(change.abs() / ms / limits.axis_acc[axis]);
                }
            }
            worst
        };
        assert!(hardest(Turn::Signed) <= 1.0001, "{}", hardest(Turn::Signed));
        assert!(hardest(Turn::AfterOnly) > 1.2, "{}", hardest(Turn::AfterOnly));
    }
}
