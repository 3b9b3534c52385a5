//! The order of shapes: what lies within a closed shape before it, the next one near the last.
//!
//! In: the shapes of a layer, and where the machine is. Out: the same, turned and begun so that the
//! way between them is short. From shape to shape the nearest one is taken that surrounds nothing
//! undone. Fails never. Work grows with n·log n; where many ten thousand shapes lie in one another,
//! the search for what surrounds what ends, and all run by size, small ones first.
use crate::shape::{Piece, Point, Shape, add, minus, on_cubic, size};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A closed shape may begin at this many of its joints.
const MAX_STARTS: usize = 64;
/// Points of the outline that tell what is inside.
const OUTLINE_POINTS: usize = 2048;
/// Comparisons of two shapes, for each of them, and for all.
const SHAPE_COMPARISONS: usize = 400;
const ALL_COMPARISONS: usize = 60_000_000;

/// Where a shape may begin: its number, and the joint (of an open one 0 or its end).
type Begin = GeomWithData<Point, (usize, usize)>;

/// Puts shapes in order; the place of the machine afterwards.
pub fn order(shapes: Vec<Shape>, at: &mut Point) -> Vec<Shape> {
    let around = around(&shapes);
    // How many shapes lie directly within each.
    let mut within = vec![0usize; shapes.len()];
    for outer in around.iter().flatten() {
        within[*outer] += 1;
    }
    let begins: Vec<Vec<Begin>> = shapes.iter().enumerate().map(|(number, shape)| begins(number, shape)).collect();
    let ready = (0..shapes.len()).filter(|number| within[*number] == 0).flat_map(|number| begins[number].clone());
    let mut tree = RTree::bulk_load(ready.collect());
    let mut shapes: Vec<Option<Shape>> = shapes.into_iter().map(Some).collect();
    let mut done = Vec::with_capacity(shapes.len());
    while let Some(begin) = tree.nearest_neighbor(*at).copied() {
        let (number, joint) = begin.data;
        for begin in &begins[number] {
            tree.remove(begin);
        }
        if let Some(mut shape) = shapes[number].take() {
            match (shape.is_closed(), joint) {
                (true, joint) => shape.begin_at(joint),
                (false, 0) => {}
                (false, _) => shape.turn(),
            }
            *at = shape.end();
            done.push(shape);
        }
        if let Some(outer) = around[number] {
            within[outer] -= 1;
            if within[outer] == 0 {
                begins[outer].iter().for_each(|begin| tree.insert(*begin));
            }
        }
    }
    done
}

fn begins(number: usize, shape: &Shape) -> Vec<Begin> {
    if !shape.is_closed() {
        let ends = [(shape.start, 0), (shape.end(), 1)];
        return ends.into_iter().map(|(point, joint)| Begin::new(point, (number, joint))).collect();
    }
    let mut joints: Vec<(usize, Point)> = shape.joints().take(shape.pieces.len()).enumerate().collect();
    if joints.iter().any(|(joint, _)| !is_on_arc(shape, *joint)) {
        joints.retain(|(joint, _)| !is_on_arc(shape, *joint));
    }
    let every = joints.len().div_ceil(MAX_STARTS);
    joints.into_iter().step_by(every.max(1)).map(|(joint, point)| Begin::new(point, (number, joint))).collect()
}

/// Whether a joint of a closed shape lies between two parts of one arc.
fn is_on_arc(shape: &Shape, joint: usize) -> bool {
    let before = shape.pieces[(joint + shape.pieces.len() - 1) % shape.pieces.len()];
    match (before, shape.pieces[joint]) {
        (Piece::Arc(a, before, joint), Piece::Arc(b, after, _)) => {
            (before > 0.0) == (after > 0.0) && size(minus(a, b)) < 0.01 * size(minus(a, joint))
        }
        _ => false,
    }
}

/// The smallest closed shape around each, if there is one.
fn around(shapes: &[Shape]) -> Vec<Option<usize>> {
    let outlines: Vec<Vec<Point>> = shapes.iter().map(outline).collect();
    let boxes: Vec<AABB<Point>> = outlines.iter().map(|outline| AABB::from_points(outline.iter())).collect();
    let area = |number: usize| {
        let (low, high) = (boxes[number].lower(), boxes[number].upper());
        (high[0] - low[0]) * (high[1] - low[1])
    };
    let closed = (0..shapes.len()).filter(|number| shapes[*number].is_closed());
    let rectangles = closed.map(|number| GeomWithData::new(Rectangle::from_aabb(boxes[number]), number));
    let tree = RTree::bulk_load(rectangles.collect());
    // Numbers by size: what surrounds is larger.
    let mut by_size: Vec<usize> = (0..shapes.len()).collect();
    by_size.sort_by(|a, b| area(*a).total_cmp(&area(*b)).then(a.cmp(b)));
    let mut rank = vec![0; shapes.len()];
    by_size.iter().enumerate().for_each(|(place, number)| rank[*number] = place);
    let mut effort = shapes.len() * SHAPE_COMPARISONS + ALL_COMPARISONS;
    let mut found = vec![None; shapes.len()];
    for number in 0..shapes.len() {
        let point = outlines[number][0];
        let candidates = tree.locate_all_at_point(point).map(|candidate| Reverse(rank[candidate.data]));
        let mut candidates: BinaryHeap<Reverse<usize>> = candidates.take(effort + 1).collect();
        effort = effort.saturating_sub(candidates.len());
        while let Some(Reverse(place)) = candidates.pop() {
            let outline = &outlines[by_size[place]];
            effort = effort.saturating_sub(outline.len().div_ceil(16));
            if place > rank[number] && contains(outline, point) {
                found[number] = Some(by_size[place]);
                break;
            }
        }
        if effort == 0 {
            // Small ones first is never wrong: each waits for the next smaller one.
            by_size.windows(2).for_each(|pair| found[pair[0]] = Some(pair[1]));
            break;
        }
    }
    found
}

/// Points of a shape, on its curves too.
fn outline(shape: &Shape) -> Vec<Point> {
    let mut points = vec![shape.start];
    let mut at = shape.start;
    for piece in &shape.pieces {
        match *piece {
            Piece::Arc(centre, sweep, end) => {
                let arc = strokes::arc::Arc { centre: minus(centre, at), end: minus(end, at), sweep };
                points.extend([0.25, 0.5, 0.75].map(|part| add(at, arc.at(part))));
            }
            Piece::Ellipse(centre, u, v, sweep, _) => points.extend([0.25, 0.5, 0.75].map(|part: f64| {
                let (sin, cos) = (sweep * part).sin_cos();
                [0, 1].map(|axis| centre[axis] + u[axis] * cos + v[axis] * sin)
            })),
            Piece::Cubic(a, b, end) => {
                points.extend([0.25, 0.5, 0.75].map(|part| on_cubic(&[at, a, b, end], part)));
            }
            Piece::Line(_) => {}
        }
        at = piece.end();
        points.push(at);
    }
    let every = points.len().div_ceil(OUTLINE_POINTS);
    points.into_iter().step_by(every).collect()
}

/// Whether a point is within a polygon.
fn contains(polygon: &[Point], [x, y]: Point) -> bool {
    let mut inside = false;
    let mut before = polygon[polygon.len() - 1];
    for &point in polygon {
        if (point[1] > y) != (before[1] > y) {
            let cross = before[0] + (y - before[1]) / (point[1] - before[1]) * (point[0] - before[0]);
            inside ^= x < cross;
        }
        before = point;
    }
    inside
}
