//! Dashed strokes: the dashes of a path.
//!
//! In: the elements of a path, and `stroke-dasharray` with its offset, in units of the path. Out:
//! the elements of its dashes. They are found before the transform of the path, as SVG says. Fails
//! never: [`DashPattern::count_max`] says how many dashes there may be, before they are made.
use kurbo::{Affine, BezPath, PathEl, Point, Shape};
use usvg::tiny_skia_path::{Path, PathSegment};

/// Most dashes of a drawing.
pub const MAX_DASHES: f64 = 100_000.0;

/// A dash of length 0 is not exactly that where it is cut out, px.
const DOT_PX: f64 = 1e-5;

/// See the module text.
pub struct DashPattern {
    /// Dash, gap, dash, gap, in scaled units.
    lengths: Vec<f64>,
    offset: f64,
    scale: f64,
}

/// A path in 64 bits.
pub fn elements(path: &Path) -> Vec<PathEl> {
    let point = |p: usvg::tiny_skia_path::Point| Point::new(p.x.into(), p.y.into());
    let element = |segment| match segment {
        PathSegment::MoveTo(to) => PathEl::MoveTo(point(to)),
        PathSegment::LineTo(to) => PathEl::LineTo(point(to)),
        PathSegment::QuadTo(a, to) => PathEl::QuadTo(point(a), point(to)),
        PathSegment::CubicTo(a, b, to) => PathEl::CurveTo(point(a), point(b), point(to)),
        PathSegment::Close => PathEl::ClosePath,
    };
    path.segments().map(element).collect()
}

impl DashPattern {
    /// `scale` is how much larger the page shows the path: lengths along curves are found as
    /// exactly as the page needs them.
    pub fn new(lengths: &[f32], offset: f32, scale: f64) -> DashPattern {
        let scale = if scale.is_normal() { scale } else { 1.0 };
        let lengths = lengths.iter().map(|length| f64::from(*length) * scale).collect();
        DashPattern { lengths, offset: f64::from(offset) * scale, scale }
    }

    /// So many dashes a path has at most.
    pub fn count_max(&self, elements: &[PathEl]) -> f64 {
        let parts = elements.iter().filter(|element| matches!(element, PathEl::MoveTo(_))).count() as f64;
        let length = length_max(elements);
        let period: f64 = self.lengths.iter().sum();
        let dashes = (self.lengths.len() as f64 / 2.0).max(1.0);
        (length * self.scale / period + parts) * dashes
    }

    /// The dashes of a path.
    pub fn cut(&self, elements: &[PathEl]) -> Vec<PathEl> {
        let (larger, smaller) = (Affine::scale(self.scale), Affine::scale(1.0 / self.scale));
        let first = self.first_dash();
        let mut found = Vec::new();
        for part in elements.chunk_by(|_, next| !matches!(next, PathEl::MoveTo(_))) {
            let part: Vec<PathEl> = part.iter().map(|element| larger * *element).collect();
            let outline = BezPath::from_vec(part.clone());
            // `kurbo::dash` would cut across a closed shape that its first dash goes around.
            let length = outline.perimeter(DOT_PX);
            if length > DOT_PX && first >= length {
                found.extend(part);
                continue;
            }
            let dashes: Vec<PathEl> = kurbo::dash(part.into_iter(), self.offset, &self.lengths).collect();
            let each = dashes.chunk_by(|_, next| !matches!(next, PathEl::MoveTo(_)));
            found.extend(each.filter(|dash| length_max(dash) > DOT_PX).flatten());
        }
        found.into_iter().map(|element| smaller * element).collect()
    }

    /// The length of the dash in which each part of a path begins, from there on; 0 in a gap.
    fn first_dash(&self) -> f64 {
        // An odd number of lengths is a dash and a gap in turns.
        let both = [&self.lengths[..], &self.lengths].concat();
        let mut passed = self.offset.rem_euclid(both.iter().sum());
        for (place, length) in both.iter().enumerate() {
            if passed < *length {
                return if place % 2 == 0 { length - passed } else { 0.0 };
            }
            passed -= length;
        }
        0.0
    }
}

/// A path is no longer than this: no curve is longer than the lines through its control points.
fn length_max(elements: &[PathEl]) -> f64 {
    let (mut at, mut start, mut length) = (Point::ZERO, Point::ZERO, 0.0);
    for element in elements {
        let points: &[Point] = match element {
            PathEl::MoveTo(to) => {
                (at, start) = (*to, *to);
                continue;
            }
            PathEl::LineTo(to) => &[*to],
            PathEl::QuadTo(a, to) => &[*a, *to],
            PathEl::CurveTo(a, b, to) => &[*a, *b, *to],
            PathEl::ClosePath => &[start],
        };
        for point in points {
            length += at.distance(*point);
            at = *point;
        }
    }
    length
}
