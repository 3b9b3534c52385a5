//! Parts of circles and ellipses in cubic curves.
//!
//! In: a cubic curve. Out: the arc whose form it has. Programs that write SVG, and readers of it,
//! write an arc of the angle t as a cubic curve whose control points are 4/3·tan(t/4) radii along
//! the tangents. Any affine image of it is the same for an ellipse. Such a curve differs from the
//! arc by 0.027 % of the radius at most. Fails never: others are no arcs.
use crate::shape::{Piece, Point, add, minus, scaled, size};

/// Angles of arcs that are found, radians: shorter ones are lines as well, longer ones nobody
/// writes as one curve.
const ANGLE_MIN_RAD: f64 = 0.08;
const ANGLE_MAX_RAD: f64 = 1.6;

/// The arc that a curve stands for; `noise` is what its points may be off, mm.
pub fn arc(p: [Point; 4], noise: f64) -> Option<Piece> {
    let length = size(minus(p[3], p[0]));
    if length < 50.0 * noise {
        return None;
    }
    let slack = 8.0 * noise + 1e-6 * length;
    circle(p, slack).or_else(|| ellipse(p, slack))
}

/// The arc of a circle: its tangents have the same angle with the chord.
fn circle(p: [Point; 4], slack: f64) -> Option<Piece> {
    let chord = minus(p[3], p[0]);
    let turned = |a: Point, b: Point| (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
    let half = f64::midpoint(turned(minus(p[1], p[0]), chord), turned(chord, minus(p[3], p[2])));
    if !(ANGLE_MIN_RAD..=ANGLE_MAX_RAD).contains(&(2.0 * half.abs())) {
        return None;
    }
    let (sin, cos) = half.sin_cos();
    let radius = size(chord) / (2.0 * sin.abs());
    let arm = 4.0 / 3.0 * (half.abs() / 2.0).tan() * radius / size(chord);
    let (u, v) = (scaled(chord, arm), scaled([-chord[1], chord[0]], arm));
    let first = add(p[0], add(scaled(u, cos), scaled(v, -sin)));
    let second = minus(p[3], add(scaled(u, cos), scaled(v, sin)));
    if size(minus(first, p[1])) > slack || size(minus(second, p[2])) > slack {
        return None;
    }
    let middle = scaled(add(p[0], p[3]), 0.5);
    let centre = add(middle, scaled([-chord[1], chord[0]], cos / (2.0 * sin)));
    Some(Piece::Arc(centre, 2.0 * half, p[3]))
}

/// The arc of an ellipse: the inner side is parallel to the chord, and the ratio of both tells the
/// angle, 1 - 4/3·tan(t/4)/tan(t/2).
fn ellipse(p: [Point; 4], slack: f64) -> Option<Piece> {
    let (chord, inner) = (minus(p[3], p[0]), minus(p[2], p[1]));
    let length = size(chord);
    let angle = angle((inner[0] * chord[0] + inner[1] * chord[1]) / (length * length))?;
    let arm = 4.0 / 3.0 * (angle / 4.0).tan();
    let (sin, cos) = angle.sin_cos();
    let v = scaled(minus(p[1], p[0]), 1.0 / arm);
    let u = scaled(minus(add(p[0], scaled(v, sin)), p[3]), 1.0 / (1.0 - cos));
    // Where the second control point then is.
    let second = add(p[3], add(scaled(u, arm * sin), scaled(v, -arm * cos)));
    let centre = minus(p[0], u);
    (size(minus(second, p[2])) <= slack).then_some(Piece::Ellipse(centre, u, v, angle, p[3]))
}

/// The angle of this ratio, if an arc may have it. The ratio grows with the angle, from 1/3 at 0:
/// bisection.
fn angle(ratio: f64) -> Option<f64> {
    let of = |t: f64| 1.0 - 4.0 / 3.0 * (t / 4.0).tan() / (t / 2.0).tan();
    let (mut low, mut high) = (ANGLE_MIN_RAD, ANGLE_MAX_RAD);
    if !(of(low)..=of(high)).contains(&ratio) {
        return None;
    }
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if of(middle) < ratio { low = middle } else { high = middle }
    }
    Some(f64::midpoint(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(centre: Point, u: Point, v: Point, from: f64, by: f64) -> [Point; 4] {
        let arm = 4.0 / 3.0 * (by / 4.0).tan();
        let at = |t: f64| add(centre, add(scaled(u, t.cos()), scaled(v, t.sin())));
        let along = |t: f64| add(scaled(u, -t.sin() * arm), scaled(v, t.cos() * arm));
        let (a, b) = (at(from), at(from + by));
        [a, add(a, along(from)), minus(b, along(from + by)), b]
    }

    #[test]
    fn written_arcs_are_found() {
        let noise = 1e-5;
        for (u, v) in [([50.0, 0.0], [0.0, 50.0]), ([0.0, 3.0], [3.0, 0.0]), ([30.0, 5.0], [-4.0, 12.0])] {
            for by in [0.1, 0.7, 1.0, std::f64::consts::FRAC_PI_2, -0.1, -1.2] {
                // Rounded, as in a file.
                let p = written([10.0, -7.0], u, v, 0.6, by).map(|p| p.map(|x| (x as f32).into()));
                let (middle, is_circle) = match arc(p, noise) {
                    Some(Piece::Arc(centre, sweep, end)) => {
                        let arc = strokes::arc::Arc { centre: minus(centre, p[0]), end: minus(end, p[0]), sweep };
                        (add(p[0], arc.at(0.5)), true)
                    }
                    Some(Piece::Ellipse(centre, a, b, sweep, _)) => {
                        let (sin, cos) = (sweep / 2.0).sin_cos();
                        (add(centre, add(scaled(a, cos), scaled(b, sin))), false)
                    }
                    other => panic!("{u:?} {by}: {other:?}"),
                };
                let (sin, cos) = (0.6 + by / 2.0).sin_cos();
                let known = add([10.0, -7.0], add(scaled(u, cos), scaled(v, sin)));
                assert!(size(minus(middle, known)) < 2e-5, "{by}: {middle:?}, not {known:?}");
                assert_eq!(is_circle, u[0].abs() != 30.0, "{u:?} {by}");
            }
        }
    }

    #[test]
    fn other_curves_are_none() {
        for p in [
            [[0.0, 0.0], [1.0, 2.0], [3.0, 2.1], [4.0, 0.0]],
            [[0.0, 0.0], [10.0, 20.0], [20.0, 20.0], [40.0, 0.0]],
            [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]],
            [[0.0, 0.0], [30.0, 1.0], [-10.0, 1.0], [20.0, 0.0]],
            [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        ] {
            assert_eq!(arc(p, 1e-6), None, "{p:?}");
        }
    }
}
