//! Lines and arcs over their length.

/// A position in X, Y, Z, A, pulses.
pub type Position = [f64; 4];

/// A plane of arcs; its first and second axis, as a right hand has them around the third.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// X, Y; seen from Z.
    XY,
    /// Y, Z; seen from X.
    YZ,
    /// Z, X; seen from Y.
    ZX,
}

impl Plane {
    /// Coordinates of its first and second axis.
    pub fn axes(self) -> (usize, usize) {
        match self {
            Plane::XY => (0, 1),
            Plane::YZ => (1, 2),
            Plane::ZX => (2, 0),
        }
    }
}

/// The geometry of one motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Geometry {
    /// Straight on.
    Line {
        /// Where it begins.
        from: Position,
        /// Where it ends.
        to: Position,
    },
    /// An arc of a circle.
    Arc {
        /// The first position; coordinates outside the plane stay.
        from: Position,
        /// In which plane.
        plane: Plane,
        /// Centre in the plane.
        centre: (f64, f64),
        /// Its radius.
        radius: f64,
        /// Signed sweep, radians; positive is counterclockwise.
        sweep: f64,
    },
}

impl Geometry {
    /// A line.
    pub fn line(from: Position, to: Position) -> Geometry {
        Geometry::Line { from, to }
    }

    /// ArcXYR: a radius > 0 means the arc up to 180°, < 0 the longer one. None where it cannot
    /// reach.
    pub fn arc_by_radius(from: Position, plane: Plane, to: (f64, f64), radius: f64, ccw: bool) -> Option<Geometry> {
        let (first, second) = plane.axes();
        let chord = (to.0 - from[first], to.1 - from[second]);
        let half = chord.0.hypot(chord.1) / 2.0;
        let r = radius.abs();
        // A radius that is no number is too small as well.
        if half == 0.0 || half.partial_cmp(&r).is_none_or(std::cmp::Ordering::is_gt) {
            return None;
        }
        // From the middle of the chord to the centre; (r − half)(r + half) loses nothing to
        // rounding.
        let height = ((r - half) * (r + half)).sqrt();
        let short = 2.0 * half.atan2(height);
        let sweep = if radius > 0.0 { short } else { std::f64::consts::TAU - short };
        // Counterclockwise along the short arc, the centre is to the left of the chord.
        let side = if ccw == (radius > 0.0) { height } else { -height };
        let unit = (chord.0 / (2.0 * half), chord.1 / (2.0 * half));
        let middle = (from[first] + chord.0 / 2.0, from[second] + chord.1 / 2.0);
        let centre = (middle.0 - unit.1 * side, middle.1 + unit.0 * side);
        Some(Geometry::Arc { from, plane, centre, radius: r, sweep: if ccw { sweep } else { -sweep } })
    }

    /// ArcXYC: the centre is an offset from the start; an end equal to the start is a full circle.
    /// A centre that is not equally far from both ends is moved along the chord until it is (docs:
    /// by no more than 2 pulses).
    pub fn arc_by_centre(
        from: Position,
        plane: Plane,
        to: (f64, f64),
        offset: (f64, f64),
        ccw: bool,
    ) -> Option<Geometry> {
        let (first, second) = plane.axes();
        let chord = (to.0 - from[first], to.1 - from[second]);
        let square = chord.0 * chord.0 + chord.1 * chord.1;
        let mut to_centre = offset;
        let mut sweep = std::f64::consts::TAU;
        if square > 0.0 {
            let moved = 0.5 - (offset.0 * chord.0 + offset.1 * chord.1) / square;
            to_centre = (offset.0 + moved * chord.0, offset.1 + moved * chord.1);
            // The height of the centre over the chord, to its left.
            let height = (chord.0 * to_centre.1 - chord.1 * to_centre.0) / square.sqrt();
            let half = 2.0 * (square.sqrt() / 2.0).atan2(height);
            // `half` is the counterclockwise sweep, between 0 and 2π.
            sweep = if ccw { half } else { std::f64::consts::TAU - half };
        }
        let radius = to_centre.0.hypot(to_centre.1);
        if radius == 0.0 {
            return None;
        }
        let centre = (from[first] + to_centre.0, from[second] + to_centre.1);
        Some(Geometry::Arc { from, plane, centre, radius, sweep: if ccw { sweep } else { -sweep } })
    }

    /// Pulses from end to end.
    pub fn length(&self) -> f64 {
        match *self {
            Geometry::Line { from, to } => {
                (0..4).map(|axis| (to[axis] - from[axis]) * (to[axis] - from[axis])).sum::<f64>().sqrt()
            }
            Geometry::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// Where it is after so many pulses.
    pub fn at(&self, distance: f64) -> Position {
        match *self {
            Geometry::Line { from, to } => {
                let part = distance / self.length();
                std::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * part)
            }
            Geometry::Arc { from, plane, centre, radius, sweep } => {
                let (first, second) = plane.axes();
                let turn = sweep * (distance / self.length());
                let (sin, cos) = turn.sin_cos();
                let arm = (from[first] - centre.0, from[second] - centre.1);
                let mut position = from;
                // The arm as the start has it, so that the start is hit; `radius` is its length.
                debug_assert!((arm.0.hypot(arm.1) - radius).abs() < 1e-6 * radius + 1e-9);
                position[first] = centre.0 + arm.0 * cos - arm.1 * sin;
                position[second] = centre.1 + arm.0 * sin + arm.1 * cos;
                position
            }
        }
    }

    /// Its direction after so many pulses, of length 1.
    pub fn direction(&self, distance: f64) -> Position {
        match *self {
            Geometry::Line { from, to } => {
                let length = self.length();
                std::array::from_fn(|axis| (to[axis] - from[axis]) / length)
            }
            Geometry::Arc { plane, centre, radius, sweep, .. } => {
                let ((first, second), position) = (plane.axes(), self.at(distance));
                // At a right angle to the arm, to its left if it turns counterclockwise.
                let turn = sweep.signum() / radius;
                let mut direction = [0.0; 4];
                direction[first] = (centre.1 - position[second]) * turn;
                direction[second] = (position[first] - centre.0) * turn;
                direction
            }
        }
    }

    /// Where it ends.
    pub fn end(&self) -> Position {
        match *self {
            Geometry::Line { to, .. } => to,
            Geometry::Arc { .. } => self.at(self.length()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Position, b: Position) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }

    /// Quarter circles and their rests, worked out by hand.
    #[test]
    fn arcs_go_the_right_way_round() {
        let (quarter, three) = (50.0 * std::f64::consts::PI, 150.0 * std::f64::consts::PI);
        let from = [0.0, 0.0, 7.0, 3.0];
        let h = 100.0 * 0.5f64.sqrt();
        // From (0, 0) to (100, 100): counterclockwise about (0, 100), clockwise about (100, 0).
        for (radius, ccw, length, middle) in [
            (100.0, true, quarter, [h, 100.0 - h]),
            (100.0, false, quarter, [100.0 - h, h]),
            (-100.0, true, three, [100.0 + h, -h]),
            (-100.0, false, three, [-h, 100.0 + h]),
        ] {
            let arc = Geometry::arc_by_radius(from, Plane::XY, (100.0, 100.0), radius, ccw).unwrap();
            assert!((arc.length() - length).abs() < 1e-9);
            near(arc.end(), [100.0, 100.0, 7.0, 3.0]);
            near(arc.at(length / 2.0), [middle[0], middle[1], 7.0, 3.0]);
            let Geometry::Arc { centre, .. } = arc else { panic!() };
            let again = Geometry::arc_by_centre(from, Plane::XY, (100.0, 100.0), centre, ccw).unwrap();
            assert!((again.length() - length).abs() < 1e-9);
            near(again.at(length / 2.0), arc.at(length / 2.0));
        }
        // A full circle in Z and X, counterclockwise seen from Y: Z turns to X.
        let circle = Geometry::arc_by_centre(from, Plane::ZX, (7.0, 0.0), (-10.0, 0.0), true).unwrap();
        near(circle.at(circle.length() / 4.0), [10.0, 0.0, -3.0, 3.0]);
        near(circle.end(), from);
        assert!(Geometry::arc_by_radius(from, Plane::XY, (100.0, 0.0), 49.9, true).is_none());
        // A centre 0.5 too far along the chord is moved back.
        let moved = Geometry::arc_by_centre(from, Plane::XY, (100.0, 0.0), (50.5, 20.0), true).unwrap();
        let Geometry::Arc { centre, .. } = moved else { panic!() };
        assert_eq!(centre, (50.0, 20.0));
    }
}
