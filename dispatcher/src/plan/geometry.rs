//! The geometry of a path call in doubles: a line, an arc, a full circle.
//!
//! In: the start of the motion, the user's numbers. Out: a [`Geometry`]: the data of servo's entry,
//! length, directions at both ends, radius.
//! Fails: with the number that does not fit, [`Refused`].
//!
//! An arc is given by both ends and its sweep. Ends are whole pulses, so a centre may not be
//! equally far from both. It is then moved along the chord until it is. This moves the path nowhere
//! by more than [`OFF_CENTRE_MAX_PULSES`].
use libm::{atan2, fabs, fma, hypot, sqrt};
use servo::path::{DIMENSIONS, MotionSpeeds, PathEntry, Plane, Sweep};
use servo::units::Pos;

/// Largest distance of a path from the arc of the user's centre or radius, pulses.
pub const OFF_CENTRE_MAX_PULSES: f64 = 2.0;
/// Radii and coordinates are below this, pulses.
pub const RADIUS_MAX_PULSES: f64 = 2_147_483_648.0;
/// The lowest radius of an arc by its centre, pulses.
pub const RADIUS_MIN_PULSES: f64 = 1.0 / 512.0;

/// A position, pulses: X, Y, Z, A.
pub type Position = [f64; 4];

/// Pulses.
pub fn pulses(pos: Pos) -> f64 {
    pos.0 as f64 / (1u64 << Pos::FRAC_BITS) as f64
}

/// Coordinates in pulses.
pub fn position_of(position: &[Pos; DIMENSIONS]) -> Position {
    position.map(pulses)
}

/// What does not fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refused {
    /// NaN or infinite.
    NotFinite,
    /// The target is the start.
    NoLength,
    /// The radius is less than half the distance to the target, which is this.
    RadiusTooSmall {
        /// The least radius that reaches the target.
        least: f64,
    },
    /// The centre is not equally far from start and target; the path would have to leave the arc by
    /// so much.
    CentreOff {
        /// Pulses.
        by: f64,
    },
    /// The centre is on the start, or nearer than 2⁻¹⁰ pulse.
    CentreOnStart,
    /// A radius of 2³¹ pulses or more.
    RadiusTooLarge,
}

/// The data of servo's entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    Planar([i32; 2]),
    Line([i32; 4]),
    Arc { plane: Plane, to: [i32; 2], sweep: Sweep },
    Circle { plane: Plane, centre: [i64; 2], ccw: bool },
}

/// A motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    pub(crate) form: Form,
    /// Pulses.
    pub length: f64,
    /// Directions at the start and at the end, unit vectors.
    pub tangents: [Position; 2],
    /// Of an arc: its radius, and the coordinates of its plane.
    pub round: Option<(f64, [usize; 2])>,
    /// Of an arc: counterclockwise.
    ccw: bool,
    /// Its end.
    pub end: Position,
}

/// A motion, if there is one.
type Checked = Result<Geometry, Refused>;

fn length(parts: &Position) -> f64 {
    sqrt(parts.iter().fold(0.0, |sum, x| sum + x * x))
}

impl Geometry {
    /// LnXY: a line in X and Y.
    pub fn planar(from: &Position, to: [i32; 2]) -> Checked {
        let mut end = *from;
        (end[0], end[1]) = (to[0] as f64, to[1] as f64);
        Geometry::straight(from, end, Form::Planar(to))
    }

    /// LnXYZ and LnXYZA: a line in all coordinates.
    pub fn line(from: &Position, to: [i32; 4]) -> Checked {
        Geometry::straight(from, to.map(|x| x as f64), Form::Line(to))
    }

    fn straight(from: &Position, end: Position, form: Form) -> Checked {
        let mut displacement = end;
        displacement.iter_mut().zip(from).for_each(|(x, from)| *x -= from);
        let length = length(&displacement);
        if length == 0.0 {
            return Err(Refused::NoLength);
        }
        let unit = displacement.map(|x| x / length);
        Ok(Geometry { form, length, tangents: [unit; 2], round: None, ccw: false, end })
    }

    /// ArcXYC and its planes: centre from the start; a target equal to the start is a full circle.
    pub fn arc_centre(from: &Position, plane: Plane, to: [i32; 2], centre: [f64; 2], ccw: bool) -> Checked {
        let [x, y] = centre;
        if !x.is_finite() || !y.is_finite() {
            return Err(Refused::NotFinite);
        }
        let radius = hypot(x, y);
        if radius >= RADIUS_MAX_PULSES {
            return Err(Refused::RadiusTooLarge);
        }
        if radius < RADIUS_MIN_PULSES {
            return Err(Refused::CentreOnStart);
        }
        let chord = ArcChord::new(from, plane, to);
        let ([a, b], c) = (chord.parts, chord.length);
        if c == 0.0 {
            let unit = 1073741824.0;
            let form = Form::Circle { plane, centre: [libm::rint(x * unit) as i64, libm::rint(y * unit) as i64], ccw };
            let length = core::f64::consts::TAU * radius;
            return Ok(chord.round(form, centre, radius, length, ccw));
        }
        // Position of the centre relative to the middle of the chord: along the chord, and to its
        // left.
        let (mx, my) = (x - a / 2.0, y - b / 2.0);
        let (along, left) = ((mx * a + my * b) / c, (my * a - mx * b) / c);
        let left = if ccw { left } else { -left };
        let long = left < 0.0;
        // The centre moves along the chord, and the radius changes: across the path, by so much at
        // most.
        let moved = hypot(c / 2.0, left);
        let lean = if long { 1.0 } else { c / 2.0 / moved };
        let by = fabs(along) * lean + fabs(moved - (radius + hypot(x - a, y - b)) / 2.0);
        if by > OFF_CENTRE_MAX_PULSES {
            return Err(Refused::CentreOff { by });
        }
        chord.arc(fabs(left), long, ccw)
    }

    /// ArcXYR and its planes: a radius above 0 selects the arc of up to half a turn, below 0 the
    /// longer one.
    pub fn arc_radius(from: &Position, plane: Plane, to: [i32; 2], radius: f64, ccw: bool) -> Checked {
        if !radius.is_finite() {
            return Err(Refused::NotFinite);
        }
        if fabs(radius) >= RADIUS_MAX_PULSES {
            return Err(Refused::RadiusTooLarge);
        }
        let chord = ArcChord::new(from, plane, to);
        let half = chord.length / 2.0;
        if half == 0.0 {
            return Err(Refused::NoLength);
        }
        // A radius of 0 is refused, however near the target is.
        if half - fabs(radius) > OFF_CENTRE_MAX_PULSES / 2.0 || radius == 0.0 {
            return Err(Refused::RadiusTooSmall { least: half });
        }
        // r² − (a² + b²)/4 with the errors of the squares, so that a near semicircle keeps its
        // digits.
        let [a, b] = chord.parts.map(|x| x / 2.0);
        let (rr, aa, bb) = (radius * radius, a * a, b * b);
        let errors = fma(radius, radius, -rr) - fma(a, a, -aa) - fma(b, b, -bb);
        let big = if aa > bb { (rr - aa) - bb } else { (rr - bb) - aa };
        let h = sqrt((big + errors).max(0.0));
        chord.arc(h, radius < 0.0, ccw)
    }

    /// The greatest share of the speed that a coordinate has anywhere along it, from 0 to 1.
    pub fn share(&self, coordinate: usize) -> f64 {
        let part =
            |at: usize| self.tangents.get(at).and_then(|tangent| tangent.get(coordinate)).map_or(0.0, |x| fabs(*x));
        let Some((radius, [i, j])) = self.round else { return part(0) };
        if coordinate != i && coordinate != j {
            return 0.0;
        }
        if let Form::Circle { .. } = self.form {
            return 1.0;
        }
        // Half turns from where the direction is all in the coordinate: at the start, and over the
        // sweep.
        let [first, second] = [i, j].map(|coordinate| self.tangents[0].get(coordinate).copied().unwrap_or(0.0));
        let (x, y) = if coordinate == i { (first, second) } else { (second, -first) };
        let from = atan2(y, x) / core::f64::consts::PI;
        let turns = self.length / radius / core::f64::consts::PI;
        let (low, high) = if self.ccw { (from, from + turns) } else { (from - turns, from) };
        if libm::ceil(low) <= high { 1.0 } else { part(0).max(part(1)) }
    }

    /// Coordinates that it takes to a target, a bit each. A full circle has its begin as target.
    pub fn sets(&self) -> u8 {
        match self.form {
            Form::Planar(_) => 0b11,
            Form::Line(_) => 0b1111,
            Form::Arc { plane, .. } | Form::Circle { plane, .. } => {
                plane.coordinates().iter().fold(0, |mask, index| mask | 1 << index)
            }
        }
    }
    /// The plane of an arc.
    pub(crate) fn plane(&self) -> Option<Plane> {
        match self.form {
            Form::Planar(_) | Form::Line(_) => None,
            Form::Arc { plane, .. } | Form::Circle { plane, .. } => Some(plane),
        }
    }

    /// Servo's entry for it with these speeds.
    pub fn entry(&self, along: MotionSpeeds) -> Option<PathEntry> {
        match self.form {
            Form::Planar(to) => Some(PathEntry::planar(to, along)),
            Form::Line(to) => Some(PathEntry::line(to, along)),
            Form::Arc { plane, to, sweep } => Some(PathEntry::arc(plane, to, sweep, along)),
            Form::Circle { plane, centre, ccw } => PathEntry::circle(plane, centre, ccw, along).ok(),
        }
    }
}

/// The straight line under an arc.
struct ArcChord<'p> {
    from: &'p Position,
    plane: Plane,
    to: [i32; 2],
    parts: [f64; 2],
    length: f64,
}

impl<'p> ArcChord<'p> {
    fn new(from: &'p Position, plane: Plane, to: [i32; 2]) -> Self {
        let [i, j] = plane.coordinates();
        let parts = [to[0] as f64 - from[i], to[1] as f64 - from[j]];
        ArcChord { from, plane, to, parts, length: hypot(parts[0], parts[1]) }
    }

    /// An arc whose centre lies `h` off the middle of its chord.
    fn arc(&self, h: f64, long: bool, ccw: bool) -> Checked {
        let ArcChord { plane, to, parts: [a, b], length: c, .. } = *self;
        let radius = hypot(c / 2.0, h);
        let turns = (atan2(c / 2.0, h) / core::f64::consts::PI).min(0.5);
        if radius >= RADIUS_MAX_PULSES {
            return Err(Refused::RadiusTooLarge);
        }
        let Ok(sweep) = Sweep::admit(turns.to_bits(), long, ccw) else { return Err(Refused::RadiusTooLarge) };
        let left = if ccw != long { h } else { -h };
        let centre = [a / 2.0 - b / c * left, b / 2.0 + a / c * left];
        let length = core::f64::consts::TAU * radius * if long { 1.0 - turns } else { turns };
        Ok(self.round(Form::Arc { plane, to, sweep }, centre, radius, length, ccw))
    }

    fn round(&self, form: Form, centre: [f64; 2], radius: f64, length: f64, ccw: bool) -> Geometry {
        let (chord, [i, j]) = (self.parts, self.plane.coordinates());
        // At a right angle to the radius.
        let tangent = |x: f64, y: f64| {
            let (x, y) = if ccw { (-y, x) } else { (y, -x) };
            let mut tangent = [0.0; 4];
            (tangent[i], tangent[j]) = (x / radius, y / radius);
            tangent
        };
        let [x, y] = centre;
        let tangents = [tangent(-x, -y), tangent(chord[0] - x, chord[1] - y)];
        let mut end = *self.from;
        end[i] += chord[0];
        end[j] += chord[1];
        Geometry { form, length, tangents, round: Some((radius, [i, j])), ccw, end }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    const O: Position = [0.0; 4];

    fn is_near(a: f64, b: f64) -> bool {
        fabs(a - b) <= 1e-12 * (1.0 + fabs(b))
    }

    /// Quarter, three quarters, half and full circles, both ways, by radius and by centre.
    #[test]
    fn arcs_by_radius_and_by_centre_are_the_same() {
        let from = [1000.0, 0.0, 5.0, 6.0];
        for (to, centre, radius, ccw, turns) in [
            ([0, 1000], [-1000.0, 0.0], 1000.0, true, 0.25),
            ([0, 1000], [-1000.0, 0.0], -1000.0, false, 0.75),
            ([0, -1000], [-1000.0, 0.0], 1000.0, false, 0.25),
            ([0, -1000], [-1000.0, 0.0], -1000.0, true, 0.75),
            ([-1000, 0], [-1000.0, 0.0], 1000.0, true, 0.5),
            ([-1000, 0], [-1000.0, 0.0], 1000.0, false, 0.5),
            ([1000, 1000], [0.0, 500.0], 500.0, true, 0.5),
        ] {
            let a = Geometry::arc_centre(&from, Plane::Xy, to, centre, ccw).unwrap();
            let b = Geometry::arc_radius(&from, Plane::Xy, to, radius, ccw).unwrap();
            let expected = core::f64::consts::TAU * fabs(radius) * turns;
            assert!(
                is_near(a.length, expected) && is_near(b.length, expected),
                "{to:?} {ccw}: {} {}",
                a.length,
                b.length
            );
            assert_eq!(a.end, [to[0] as f64, to[1] as f64, 5.0, 6.0]);
            // The tangent at the start is at a right angle to the radius.
            let side = if ccw { 1.0 } else { -1.0 };
            for geometry in [a, b] {
                let [t, _] = geometry.tangents;
                let r = fabs(radius);
                assert!(is_near(t[0], centre[1] / r * side) && is_near(t[1], -centre[0] / r * side), "{to:?} {t:?}");
                assert!(is_near(length(&geometry.tangents[1]), 1.0));
            }
        }
        let circle = Geometry::arc_centre(&from, Plane::Xy, [1000, 0], [3.0, 4.0], false).unwrap();
        assert!(is_near(circle.length, 5.0 * core::f64::consts::TAU) && circle.end == from);
    }

    /// A semicircle's radius in whole numbers leaves the tangent, and so the length, all its
    /// digits.
    #[test]
    fn near_semicircles_keep_their_digits() {
        let radius = 1_000_000.000_000_1;
        let arc = Geometry::arc_radius(&O, Plane::Xy, [2_000_000, 0], radius, true).unwrap();
        // θ = π − 2·asin(h/r), h² = r² − 10¹² = 2·10⁶·(r − 10⁶) + (r − 10⁶)²
        let gap = radius - 1e6;
        let h = sqrt(2e6 * gap + gap * gap);
        let expected = radius * (core::f64::consts::PI - 2.0 * libm::asin(h / radius));
        assert!(fabs(arc.length - expected) < 1e-9, "{} {expected}", arc.length);
    }

    /// Ends rounded to pulses: the centre is moved, the path stays near the intended arc.
    #[test]
    fn a_centre_that_is_a_little_off_is_moved() {
        let arc = Geometry::arc_centre(&O, Plane::Xy, [1415, 586], [0.0, 2000.0], true).unwrap();
        let (radius, _) = arc.round.unwrap();
        assert!(fabs(radius - 2000.0) < 2.0, "{radius}");
        assert!(matches!(
            Geometry::arc_centre(&O, Plane::Xy, [1425, 586], [0.0, 2000.0], true),
            Err(Refused::CentreOff { by }) if by > 2.0
        ));
        // Nearly a full circle: the centre would move far.
        assert!(matches!(
            Geometry::arc_centre(&O, Plane::Xy, [0, -1], [0.0, 2000.0], true),
            Err(Refused::CentreOff { by }) if by > 100.0
        ));
        assert!(Geometry::arc_centre(&O, Plane::Xy, [-1, 0], [0.0, 2000.0], true).is_ok());
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let centre = |to, c| Geometry::arc_centre(&O, Plane::Xy, to, c, true).map(|_| ());
        let radius = |to, r| Geometry::arc_radius(&O, Plane::Xy, to, r, true).map(|_| ());
        assert_eq!(centre([1, 1], [f64::NAN, 0.0]), Err(Refused::NotFinite));
        assert_eq!(centre([0, 0], [0.0, 0.001]), Err(Refused::CentreOnStart));
        assert_eq!(centre([0, 0], [3e9, 0.0]), Err(Refused::RadiusTooLarge));
        assert_eq!(radius([0, 0], 5.0), Err(Refused::NoLength));
        assert_eq!(radius([10, 0], f64::INFINITY), Err(Refused::NotFinite));
        assert_eq!(radius([10, 0], 3.9), Err(Refused::RadiusTooSmall { least: 5.0 }));
        assert_eq!(radius([10, 0], -3.9), Err(Refused::RadiusTooSmall { least: 5.0 }));
        assert_eq!(radius([10, 0], 4.5), Ok(()), "a semicircle, but for the rounding of its ends");
        assert_eq!(radius([10, 0], 0.0), Err(Refused::RadiusTooSmall { least: 5.0 }));
        assert_eq!(radius([1, 0], -0.0), Err(Refused::RadiusTooSmall { least: 0.5 }));
        assert_eq!(Geometry::planar(&O, [0, 0]).map(|_| ()), Err(Refused::NoLength));
        assert_eq!(Geometry::line(&[1.0, 2.0, 3.0, 4.0], [1, 2, 3, 4]).map(|_| ()), Err(Refused::NoLength));
        assert!(Geometry::line(&O, [0, 0, 0, i32::MIN]).is_ok());
    }
}
