//! A shape: what is marked without lifting, in mm of the machine.
//!
//! In: pieces from a file. Out: the same turned round, begun elsewhere, as lines and arcs. Curves
//! and ellipses become lines by a bound of their distance, so no point is farther from them than
//! the tolerance. Fails never.
use std::f64::consts::TAU;
use strokes::arc::Arc;

pub type Point = [f64; 2];

/// From one point to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Piece {
    Line(Point),
    /// Of a circle: centre, angle (above 0 counterclockwise), end.
    Arc(Point, f64, Point),
    /// Of an ellipse: centre c, u, v, angle t, end. The points are c + u cos t + v sin t, from t =
    /// 0 on.
    Ellipse(Point, Point, Point, f64, Point),
    /// A cubic Bézier curve: two control points, end.
    Cubic(Point, Point, Point),
}

impl Piece {
    pub fn end(&self) -> Point {
        match *self {
            Piece::Line(end) | Piece::Arc(_, _, end) | Piece::Ellipse(.., end) | Piece::Cubic(_, _, end) => end,
        }
    }

    /// The same from its end to its start.
    fn turned(&self, start: Point) -> Piece {
        match *self {
            Piece::Line(_) => Piece::Line(start),
            Piece::Arc(centre, sweep, _) => Piece::Arc(centre, -sweep, start),
            Piece::Ellipse(centre, u, v, sweep, _) => {
                let (sin, cos) = sweep.sin_cos();
                let (u, v) = (add(scaled(u, cos), scaled(v, sin)), add(scaled(u, sin), scaled(v, -cos)));
                Piece::Ellipse(centre, u, v, sweep, start)
            }
            Piece::Cubic(a, b, _) => Piece::Cubic(b, a, start),
        }
    }
}

/// What a stroke looks like in the file.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Paint {
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// AutoCAD's number of a colour, of a DXF.
    pub index: Option<i16>,
    /// Layer of a DXF.
    pub layer: Option<String>,
}

/// A name of a layer without its case, which AutoCAD's names do not have.
pub fn caseless(name: &str) -> impl Iterator<Item = char> + '_ {
    name.chars().flat_map(char::to_lowercase)
}

impl Paint {
    /// Whether a stroke of `other` looks like one of this.
    pub fn is_like(&self, other: &Paint) -> bool {
        let named = |paint: &Paint| paint.layer.as_deref().map(|name| caseless(name).collect::<String>());
        self.colour == other.colour
            && self.index == other.index
            && (self.layer == other.layer || named(self) == named(other))
    }
}

/// See the module text.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    pub start: Point,
    pub pieces: Vec<Piece>,
    pub paint: Paint,
    /// Where it is in the file: `line 12`, or an id.
    pub place: String,
}

/// A part of a shape as it is run.
#[derive(Debug, Clone, Copy)]
pub enum Run {
    Line(Point),
    Arc(Arc, Point),
}

pub fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

pub fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub fn scaled(a: Point, by: f64) -> Point {
    [a[0] * by, a[1] * by]
}

pub fn size(a: Point) -> f64 {
    a[0].hypot(a[1])
}

impl Shape {
    pub fn end(&self) -> Point {
        self.pieces.last().map_or(self.start, Piece::end)
    }

    pub fn is_closed(&self) -> bool {
        !self.pieces.is_empty() && self.end() == self.start
    }

    /// Points between pieces, the start first, the end last.
    pub fn joints(&self) -> impl Iterator<Item = Point> + '_ {
        std::iter::once(self.start).chain(self.pieces.iter().map(Piece::end))
    }

    /// From its end to its start.
    pub fn turn(&mut self) {
        let starts: Vec<Point> = self.joints().collect();
        self.start = self.end();
        self.pieces = self.pieces.iter().zip(starts).rev().map(|(piece, start)| piece.turned(start)).collect();
    }

    /// A closed shape from this joint on.
    pub fn begin_at(&mut self, joint: usize) {
        if joint > 0 && joint < self.pieces.len() {
            self.start = self.pieces[joint - 1].end();
            self.pieces.rotate_left(joint);
        }
    }

    /// As lines and arcs, each at most `tolerance` beside the shape. Arcs of one circle become one.
    pub fn runs(&self, tolerance: f64) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::with_capacity(self.pieces.len());
        let mut at = self.start;
        let mut circle: Option<Circle> = None;
        for piece in &self.pieces {
            if let Piece::Arc(centre, sweep, end) = *piece {
                let arc = Arc { centre: minus(centre, at), end: minus(end, at), sweep };
                let joined = circle.as_ref().and_then(|circle| circle.with(at, &arc, tolerance * 0.25));
                if joined.is_none() {
                    runs.extend(circle.take().map(Circle::run));
                }
                circle = Some(joined.unwrap_or_else(|| Circle::of(at, &arc)));
            } else {
                runs.extend(circle.take().map(Circle::run));
                let points = &mut |point| runs.push(Run::Line(point));
                match *piece {
                    Piece::Line(end) => points(end),
                    Piece::Cubic(a, b, end) => cubic([at, a, b, end], tolerance, 0, points),
                    Piece::Ellipse(centre, u, v, sweep, end) => {
                        let parts = parts(size(u).hypot(size(v)), sweep, tolerance);
                        for number in 1..parts {
                            let (sin, cos) = (sweep * f64::from(number) / f64::from(parts)).sin_cos();
                            points(add(centre, add(scaled(u, cos), scaled(v, sin))));
                        }
                        points(end);
                    }
                    Piece::Arc(..) => {}
                }
            }
            at = piece.end();
        }
        runs.extend(circle.map(Circle::run));
        runs
    }
}

/// Arcs of one circle that follow each other.
struct Circle {
    centre: Point,
    sweep: f64,
    /// The start, and of each arc its middle and its end.
    points: Vec<Point>,
}

impl Circle {
    fn of(start: Point, arc: &Arc) -> Circle {
        let points = vec![start, add(start, arc.at(0.5)), add(start, arc.end)];
        Circle { centre: add(start, arc.centre), sweep: arc.sweep, points }
    }

    /// With another arc, if all of their points are within `near` of one circle, not more than once
    /// round it.
    fn with(&self, at: Point, arc: &Arc, near: f64) -> Option<Circle> {
        let sweep = self.sweep + arc.sweep;
        if (self.sweep > 0.0) != (arc.sweep > 0.0) || sweep.abs() > TAU + 1e-3 {
            return None;
        }
        let mut points = self.points.clone();
        points.extend([add(at, arc.at(0.5)), add(at, arc.end)]);
        // Through three points that are as far from each other as they can be.
        let third = |part: f64| points[(part * (points.len() - 1) as f64).round() as usize];
        let last = if sweep.abs() > 5.0 { 2.0 / 3.0 } else { 1.0 };
        let centre = centre(points[0], third(last / 2.0), third(last))?;
        let radius = size(minus(points[0], centre));
        let fits = points.iter().all(|point| (size(minus(*point, centre)) - radius).abs() <= near);
        fits.then_some(Circle { centre, sweep, points })
    }

    fn run(self) -> Run {
        let (start, end) = (self.points[0], self.points[self.points.len() - 1]);
        let sweep = if end == start { TAU.copysign(self.sweep) } else { self.sweep };
        Run::Arc(Arc { centre: minus(self.centre, start), end: minus(end, start), sweep }, end)
    }
}

/// The centre of the circle through three points.
fn centre(a: Point, b: Point, c: Point) -> Option<Point> {
    let (b, c) = (minus(b, a), minus(c, a));
    let twice = 2.0 * (b[0] * c[1] - b[1] * c[0]);
    let (bb, cc) = (b[0] * b[0] + b[1] * b[1], c[0] * c[0] + c[1] * c[1]);
    let centre = [(c[1] * bb - b[1] * cc) / twice, (b[0] * cc - c[0] * bb) / twice];
    centre.iter().all(|x| x.is_finite()).then(|| add(a, centre))
}

/// Parts of an angle such that chords of a circle of this radius are within `tolerance`.
fn parts(radius: f64, sweep: f64, tolerance: f64) -> u32 {
    let step = 2.0 * (1.0 - (tolerance / radius).min(0.5)).acos();
    (sweep.abs() / step).ceil().clamp(1.0, 1e6) as u32
}

/// Lines along a cubic curve. A curve whose second differences are at most d is within d·6/(8n²) of
/// n chords of equal parts of its parameter. One that needs more than a few is halved, since its
/// halves may differ.
fn cubic(p: [Point; 4], tolerance: f64, depth: u32, put: &mut impl FnMut(Point)) {
    let bend = |k: usize| size(add(minus(p[k], scaled(p[k + 1], 2.0)), p[k + 2]));
    let count = (0.75 * bend(0).max(bend(1)) / tolerance).sqrt().ceil();
    if count > 4.0 && depth < 24 {
        let half = |a: Point, b: Point| scaled(add(a, b), 0.5);
        let (a, b, c) = (half(p[0], p[1]), half(p[1], p[2]), half(p[2], p[3]));
        let (d, e) = (half(a, b), half(b, c));
        let middle = half(d, e);
        cubic([p[0], a, d, middle], tolerance, depth + 1, put);
        cubic([middle, e, c, p[3]], tolerance, depth + 1, put);
        return;
    }
    let count = count.clamp(1.0, 64.0) as u32;
    for number in 1..count {
        put(on_cubic(&p, f64::from(number) / f64::from(count)));
    }
    put(p[3]);
}

/// A point of a cubic curve.
pub fn on_cubic(p: &[Point; 4], t: f64) -> Point {
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    p.iter().zip(weights).fold([0.0; 2], |sum, (point, weight)| add(sum, scaled(*point, weight)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(start: Point, pieces: Vec<Piece>) -> Shape {
        let paint = Paint { colour: [0; 3], index: None, layer: None };
        Shape { start, pieces, paint, place: String::new() }
    }

    fn lines(shape: &Shape, tolerance: f64) -> Vec<Point> {
        let of = |run: &Run| match run {
            Run::Line(end) | Run::Arc(_, end) => *end,
        };
        std::iter::once(shape.start).chain(shape.runs(tolerance).iter().map(of)).collect()
    }

    fn off(point: Point, [from, to]: [Point; 2]) -> f64 {
        let (way, on) = (minus(to, from), minus(point, from));
        let part = ((way[0] * on[0] + way[1] * on[1]) / (size(way) * size(way))).clamp(0.0, 1.0);
        size(minus(on, scaled(way, part)))
    }

    #[test]
    fn curves_are_within_the_tolerance_and_not_much_nearer() {
        let p = [[0.0, 0.0], [90.0, 10.0], [-40.0, 60.0], [30.0, 35.0]];
        let (u, v) = ([30.0, 5.0], [-4.0, 12.0]);
        let ellipse = |t: f64| add([1.0, 2.0], add(scaled(u, t.cos()), scaled(v, t.sin())));
        for tolerance in [0.5, 0.01, 0.0005] {
            let curves: [(Shape, &dyn Fn(f64) -> Point); 2] = [
                (shape(p[0], vec![Piece::Cubic(p[1], p[2], p[3])]), &|t| on_cubic(&p, t)),
                (shape(ellipse(0.0), vec![Piece::Ellipse([1.0, 2.0], u, v, 5.0, ellipse(5.0))]), &|t| ellipse(5.0 * t)),
            ];
            for (shape, at) in curves {
                let lines = lines(&shape, tolerance);
                let worst = (0..=20_000).map(|k| at(f64::from(k) / 20_000.0));
                let worst = worst.map(|point| lines.windows(2).map(|w| off(point, [w[0], w[1]])).fold(1e9, f64::min));
                let worst = worst.fold(0.0, f64::max);
                assert!(worst <= tolerance && worst > tolerance * 0.2, "{tolerance}: {worst}, {} lines", lines.len());
            }
        }
    }

    #[test]
    fn a_turned_shape_has_the_same_points() {
        let (u, v) = ([30.0, 5.0], [-4.0, 12.0]);
        let end = add(scaled(u, 2f64.cos()), scaled(v, 2f64.sin()));
        let shape = shape(
            u,
            vec![
                Piece::Ellipse([0.0; 2], u, v, 2.0, end),
                Piece::Line([1.0, 1.0]),
                Piece::Cubic([5.0, 0.0], [6.0, 9.0], [7.0, 1.0]),
                Piece::Arc([7.0, 0.0], std::f64::consts::PI, [7.0, -1.0]),
            ],
        );
        let mut turned = shape.clone();
        turned.turn();
        assert_eq!((turned.start, turned.end()), (shape.end(), shape.start));
        let (mut there, back) = (lines(&shape, 0.01), lines(&turned, 0.01));
        there.reverse();
        assert_eq!(there.len(), back.len());
        assert!(there.iter().zip(&back).all(|(a, b)| size(minus(*a, *b)) < 1e-12));
        turned.turn();
        assert!(lines(&turned, 0.01).iter().zip(lines(&shape, 0.01)).all(|(a, b)| size(minus(*a, b)) < 1e-12));
    }

    #[test]
    fn four_quarters_are_a_circle_wherever_it_begins() {
        let joints = [[6.0, 2.0], [1.0, 7.0], [-4.0, 2.0], [1.0, -3.0]];
        let quarter = |end: Point| Piece::Arc([1.0, 2.0], std::f64::consts::FRAC_PI_2, end);
        let pieces = [1, 2, 3, 0].map(|k| quarter(joints[k])).to_vec();
        for begin in 0..4 {
            let mut circle = shape(joints[0], pieces.clone());
            circle.begin_at(begin);
            assert!(circle.is_closed());
            match circle.runs(0.001)[..] {
                [Run::Arc(arc, end)] => {
                    assert!(end == joints[begin] && arc.sweep == TAU && (size(arc.centre) - 5.0).abs() < 1e-12);
                }
                ref other => panic!("{other:?}"),
            }
        }
    }
}
