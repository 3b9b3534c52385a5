//! Entities to pieces.
//!
//! In: an entity, and the map of the blocks that it is in. Out: where it starts, and its pieces, in
//! mm. Fails with what is not supported, and with values that are no curve.
use super::Entity;
use crate::fault::Fault;
use crate::shape::{Piece, Point, add, minus, scaled, size};
use std::f64::consts::TAU;

/// What an entity is.
pub enum Found {
    Shape(Point, Vec<Piece>),
    Point,
    /// The end of another one, or what is not drawn.
    Nothing,
}

/// An affine map: [a, b, c, d, e, f] takes x, y to a·x + c·y + e, b·x + d·y + f.
#[derive(Debug, Clone, Copy)]
pub struct Map([f64; 6]);

impl Map {
    pub fn scale(by: f64) -> Map {
        Map([by, 0.0, 0.0, by, 0.0, 0.0])
    }

    fn vector(&self, [x, y]: Point) -> Point {
        let Map([a, b, c, d, ..]) = self;
        [a * x + c * y, b * x + d * y]
    }

    fn point(&self, point: Point) -> Point {
        add(self.vector(point), [self.0[4], self.0[5]])
    }

    /// This after `first`.
    fn after(&self, first: &Map) -> Map {
        let Map([a, b, c, d, e, f]) = *first;
        let ([a, b], [c, d], [e, f]) = (self.vector([a, b]), self.vector([c, d]), self.point([e, f]));
        Map([a, b, c, d, e, f])
    }

    fn piece(&self, start: Point, piece: &Piece) -> Piece {
        match *piece {
            Piece::Line(end) => Piece::Line(self.point(end)),
            Piece::Cubic(a, b, end) => Piece::Cubic(self.point(a), self.point(b), self.point(end)),
            Piece::Ellipse(centre, u, v, sweep, end) => {
                Piece::Ellipse(self.point(centre), self.vector(u), self.vector(v), sweep, self.point(end))
            }
            Piece::Arc(centre, sweep, end) => {
                let Map([a, b, c, d, ..]) = self;
                let (one, other) = (a.hypot(*b), c.hypot(*d));
                if let Some(flat) = flat(start, sweep, end, FLAT_RADIUS_MM / one.max(other)) {
                    return self.piece(start, &flat);
                }
                let straight = (a * c + b * d).abs() <= 1e-9 * one * other;
                if straight && (one - other).abs() <= 1e-9 * one {
                    let sweep = if a * d - b * c < 0.0 { -sweep } else { sweep };
                    return Piece::Arc(self.point(centre), sweep, self.point(end));
                }
                let u = minus(start, centre);
                let v = scaled([-u[1], u[0]], sweep.signum());
                Piece::Ellipse(self.point(centre), self.vector(u), self.vector(v), sweep.abs(), self.point(end))
            }
        }
    }
}

/// Arcs of a greater radius are cubic curves: their centres are too far away to compute with.
const FLAT_RADIUS_MM: f64 = 1e5;
/// Up to this angle a cubic curve is within 2·10⁻¹¹ radii of the arc: 0.0006 mm at the longest
/// chord of the plane in which something is computed, 2,800 m.
const FLAT_ANGLE_RAD: f64 = 0.1;

/// The cubic curve of a flat arc whose radius is above `radius`. The bulge alone, not the centre,
/// says where its control points are: a third of the chord along the tangents.
fn flat(start: Point, sweep: f64, end: Point, radius: f64) -> Option<Piece> {
    let chord = minus(end, start);
    if sweep.abs() > FLAT_ANGLE_RAD || size(chord) <= 2.0 * radius * (sweep.abs() / 2.0).sin() {
        return None;
    }
    let bulge = (sweep / 4.0).tan();
    let along = scaled(chord, (1.0 - bulge * bulge) / 3.0);
    let aside = scaled([chord[1], -chord[0]], 2.0 * bulge / 3.0);
    Some(Piece::Cubic(add(start, add(along, aside)), add(minus(end, along), aside), end))
}

/// The map of what is in a block that is inserted.
pub fn insert(entity: &Entity<'_>, base: Point, outer: &Map) -> Result<Map, Fault> {
    for (code, what) in [(70, "columns"), (71, "rows")] {
        if entity.whole(code)?.unwrap_or(1) > 1 {
            return Err(Fault::at(entity.line, format!("an INSERT with {what} is not supported: explode it")));
        }
    }
    let place = [entity.needs(10)?, entity.needs(20)?];
    let (x, y) = (entity.real(41)?.unwrap_or(1.0), entity.real(42)?.unwrap_or(1.0));
    let (sin, cos) = entity.real(50)?.unwrap_or(0.0).to_radians().sin_cos();
    let turned = Map([x * cos, x * sin, -y * sin, y * cos, place[0], place[1]]);
    let moved = Map([1.0, 0.0, 0.0, 1.0, -base[0], -base[1]]);
    Ok(outer.after(&side(entity)?).after(&turned).after(&moved))
}

/// The plane that an entity is in: seen from above, or from below.
fn side(entity: &Entity<'_>) -> Result<Map, Fault> {
    let normal = [210, 220, 230].map(|code| entity.real(code));
    let [x, y, z] = [normal[0].clone()?, normal[1].clone()?, normal[2].clone()?];
    let (x, y, z) = (x.unwrap_or(0.0), y.unwrap_or(0.0), z.unwrap_or(1.0));
    if x.hypot(y) > 1e-6 {
        return Err(Fault::at(entity.line, format!("the {} is not in the plane of X and Y", entity.kind)));
    }
    Ok(if z < 0.0 { Map([-1.0, 0.0, 0.0, 1.0, 0.0, 0.0]) } else { Map::scale(1.0) })
}

/// Whether its points lie at several heights, which the plane of a drawing does not have.
pub fn is_sloped(entity: &Entity<'_>) -> Result<bool, Fault> {
    let mut heights = Vec::new();
    let at = |entity: &Entity<'_>, code: i32| entity.real(code).map(|z| z.unwrap_or(0.0));
    match entity.kind {
        "LINE" => heights.extend([at(entity, 30)?, at(entity, 31)?]),
        "POLYLINE" => {
            for vertex in &entity.vertices {
                heights.push(at(vertex, 30)?);
            }
        }
        "SPLINE" => {
            for group in entity.groups.iter().filter(|group| group.code == 30) {
                heights.push(group.real()?);
            }
        }
        _ => {}
    }
    Ok(heights.windows(2).any(|pair| pair[0] != pair[1]))
}

pub fn shape(entity: &Entity<'_>, map: &Map) -> Result<Found, Fault> {
    let (start, pieces, own) = match entity.kind {
        "LINE" => {
            let (start, end) = ([entity.needs(10)?, entity.needs(20)?], [entity.needs(11)?, entity.needs(21)?]);
            (start, vec![Piece::Line(end)], Map::scale(1.0))
        }
        "CIRCLE" | "ARC" => {
            let (start, pieces) = round(entity)?;
            (start, pieces, side(entity)?)
        }
        "ELLIPSE" => {
            let (start, pieces) = ellipse(entity)?;
            (start, pieces, Map::scale(1.0))
        }
        "LWPOLYLINE" | "POLYLINE" => {
            let (start, pieces) = polyline(entity)?;
            (start, pieces, side(entity)?)
        }
        "SPLINE" => {
            let (start, pieces) = spline(entity)?;
            (start, pieces, Map::scale(1.0))
        }
        "POINT" => return Ok(Found::Point),
        "SEQEND" | "" | "ATTDEF" | "VIEWPORT" => return Ok(Found::Nothing),
        other => {
            let shown: String = other.chars().take(40).collect();
            return Err(Fault::at(
                entity.line,
                format!("{shown} is not supported: make lines, arcs or polylines of it, or remove it"),
            ));
        }
    };
    let whole = map.after(&own);
    let mut at = start;
    let mut mapped = Vec::with_capacity(pieces.len());
    for piece in &pieces {
        if *piece != Piece::Line(at) {
            mapped.push(whole.piece(at, piece));
        }
        at = piece.end();
    }
    Ok(Found::Shape(whole.point(start), mapped))
}

fn round(entity: &Entity<'_>) -> Result<(Point, Vec<Piece>), Fault> {
    let (centre, radius) = ([entity.needs(10)?, entity.needs(20)?], entity.needs(40)?);
    if radius <= 0.0 {
        return Err(Fault::at(entity.line, format!("the radius of a {} is {radius}; it is above 0", entity.kind)));
    }
    let at = |angle: f64| add(centre, [radius * angle.cos(), radius * angle.sin()]);
    if entity.kind == "CIRCLE" {
        // In quarters, so that it may begin at each of them.
        let joints = [[radius, 0.0], [0.0, radius], [-radius, 0.0], [0.0, -radius]].map(|joint| add(centre, joint));
        let quarters = [1, 2, 3, 0].map(|joint: usize| Piece::Arc(centre, TAU / 4.0, joints[joint]));
        return Ok((joints[0], quarters.to_vec()));
    }
    let (from, to) = (entity.needs(50)?.to_radians(), entity.needs(51)?.to_radians());
    let sweep = (to - from).rem_euclid(TAU);
    let sweep = if sweep < 1e-12 { TAU } else { sweep };
    // Parts below half a turn have one side only.
    let middle = from + sweep / 2.0;
    let end = if sweep == TAU { at(from) } else { at(to) };
    Ok((at(from), vec![Piece::Arc(centre, sweep / 2.0, at(middle)), Piece::Arc(centre, sweep / 2.0, end)]))
}

fn ellipse(entity: &Entity<'_>) -> Result<(Point, Vec<Piece>), Fault> {
    let (centre, major) = ([entity.needs(10)?, entity.needs(20)?], [entity.needs(11)?, entity.needs(21)?]);
    let ratio = entity.needs(40)?;
    if size(major) == 0.0 || !(1e-6..=1.0 + 1e-9).contains(&ratio.abs()) {
        return Err(Fault::at(entity.line, "the axes of an ELLIPSE are no ellipse"));
    }
    let flip = if entity.real(230)?.unwrap_or(1.0) < 0.0 { -1.0 } else { 1.0 };
    let minor = scaled([-major[1], major[0]], ratio * flip);
    let (from, to) = (entity.real(41)?.unwrap_or(0.0), entity.real(42)?.unwrap_or(TAU));
    let sweep = (to - from).rem_euclid(TAU);
    let sweep = if sweep < 1e-9 || TAU - sweep < 1e-9 { TAU } else { sweep };
    let (sin, cos) = from.sin_cos();
    let u = add(scaled(major, cos), scaled(minor, sin));
    let v = add(scaled(major, -sin), scaled(minor, cos));
    let start = add(centre, u);
    let (sin, cos) = sweep.sin_cos();
    let end = if sweep == TAU { start } else { add(centre, add(scaled(u, cos), scaled(v, sin))) };
    Ok((start, vec![Piece::Ellipse(centre, u, v, sweep, end)]))
}

fn polyline(entity: &Entity<'_>) -> Result<(Point, Vec<Piece>), Fault> {
    let flags = entity.whole(70)?.unwrap_or(0);
    // Corner, and the bulge of what goes from it.
    let mut corners: Vec<(Point, f64)> = Vec::new();
    if entity.kind == "POLYLINE" {
        if flags & (8 | 16 | 64) != 0 {
            return Err(Fault::at(entity.line, "a POLYLINE in space, or a mesh, is not supported"));
        }
        for vertex in &entity.vertices {
            // Bit 16: the frame of a spline, which is not drawn.
            if vertex.whole(70)?.unwrap_or(0) & 16 == 0 {
                corners.push(([vertex.needs(10)?, vertex.needs(20)?], vertex.real(42)?.unwrap_or(0.0)));
            }
        }
    } else {
        for group in &entity.groups {
            match (group.code, corners.last_mut()) {
                (10, _) => corners.push(([group.real()?, 0.0], 0.0)),
                (20, Some((point, _))) => point[1] = group.real()?,
                (42, Some((_, bulge))) => *bulge = group.real()?,
                _ => {}
            }
        }
    }
    let Some(&(start, _)) = corners.first() else { return Ok(([0.0; 2], Vec::new())) };
    if flags & 1 == 1 {
        corners.push((start, 0.0));
    }
    let pieces = corners.windows(2).filter_map(|pair| {
        let ((from, bulge), (to, _)) = (pair[0], pair[1]);
        let chord = minus(to, from);
        if bulge == 0.0 || size(chord) == 0.0 {
            return (from != to).then_some(Piece::Line(to));
        }
        // The bulge is the tangent of a quarter of the angle.
        let high = (1.0 - bulge * bulge) / (4.0 * bulge);
        let centre = add(scaled(add(from, to), 0.5), scaled([-chord[1], chord[0]], high));
        Some(Piece::Arc(centre, 4.0 * bulge.atan(), to))
    });
    Ok((start, pieces.collect()))
}

fn spline(entity: &Entity<'_>) -> Result<(Point, Vec<Piece>), Fault> {
    let fault = |text: String| Fault::at(entity.line, format!("a SPLINE {text}"));
    let degree = entity.whole(71)?.unwrap_or(3);
    let (mut knots, mut weights) = (Vec::new(), Vec::new());
    let mut controls: Vec<Point> = Vec::new();
    for group in &entity.groups {
        match (group.code, controls.last_mut()) {
            (40, _) => knots.push(group.real()?),
            (41, _) => weights.push(group.real()?),
            (10, _) => controls.push([group.real()?, 0.0]),
            (20, Some(point)) => point[1] = group.real()?,
            _ => {}
        }
    }
    if !(1..=3).contains(&degree) {
        return Err(fault(format!("has the degree {degree}; 1 to 3 are supported")));
    }
    if weights.iter().any(|weight| (weight - weights[0]).abs() > 1e-9) {
        return Err(fault("with weights is not supported: make a polyline of it".to_owned()));
    }
    let p = degree as usize;
    if controls.is_empty() && entity.groups.iter().any(|group| group.code == 11) {
        let what = "has fit points only, which is not supported: explode it, or save it with control points";
        return Err(fault(what.to_owned()));
    }
    if controls.len() <= p {
        return Err(fault("has too few control points".to_owned()));
    }
    if knots.len() != controls.len() + p + 1 || knots.windows(2).any(|pair| pair[0] > pair[1]) {
        return Err(fault(format!(
            "has {} knots for {} control points; they are {}, and never fall",
            knots.len(),
            controls.len(),
            controls.len() + p + 1
        )));
    }
    // The control points of the Bézier curve of a span are its polar form at the ends of the span.
    let polar = |span: usize, at: &[f64]| {
        let mut points: Vec<Point> = controls[span - p..=span].to_vec();
        for (round, u) in at.iter().enumerate() {
            for k in (round + 1..=p).rev() {
                let (low, high) = (knots[span - p + k], knots[span + k - round]);
                let part = (u - low) / (high - low);
                points[k] = add(scaled(points[k - 1], 1.0 - part), scaled(points[k], part));
            }
        }
        points[p]
    };
    let (mut start, mut pieces) = (None, Vec::new());
    for span in p..controls.len() {
        let (low, high) = (knots[span], knots[span + 1]);
        if low >= high {
            continue;
        }
        let points: Vec<Point> = (0..=p)
            .map(|k| polar(span, &(0..p).map(|place| if place < p - k { low } else { high }).collect::<Vec<f64>>()))
            .collect();
        start.get_or_insert(points[0]);
        pieces.push(match points[..] {
            [_, end] => Piece::Line(end),
            [a, b, end] => {
                let third = |from: Point| add(from, scaled(minus(b, from), 2.0 / 3.0));
                Piece::Cubic(third(a), third(end), end)
            }
            [_, a, b, end] => Piece::Cubic(a, b, end),
            _ => return Err(fault("has no degree".to_owned())),
        });
    }
    // The ends of a closed spline meet but for rounding.
    match (start, pieces.last_mut()) {
        (Some(start), Some(Piece::Line(end) | Piece::Cubic(_, _, end)))
            if size(minus(*end, start)) <= 1e-9 * (1.0 + size(start)) =>
        {
            *end = start;
        }
        _ => {}
    }
    Ok((start.unwrap_or_default(), pieces))
}
