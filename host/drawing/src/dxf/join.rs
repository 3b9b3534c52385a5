//! Shapes whose ends meet become one: CAD programs write outlines as single lines and arcs.
//!
//! In: shapes. Out: fewer, longer ones, in the order of their first parts. Two open ends of the
//! same paint that are within a thousandth of a mm, and no third one there, are joined. Fails
//! never.
use crate::shape::{Piece, Point, Shape};
use std::collections::HashMap;

/// Ends in the same cell of this size meet, mm.
const CELL_MM: f64 = 1e-3;

type Cell = (i64, i64);

fn cell([x, y]: Point) -> Cell {
    ((x / CELL_MM).round() as i64, (y / CELL_MM).round() as i64)
}

pub fn join(shapes: Vec<Shape>) -> Vec<Shape> {
    // Open ends by place: shape, and whether it is its end.
    let mut ends: HashMap<Cell, Vec<(usize, bool)>> = HashMap::new();
    for (number, shape) in shapes.iter().enumerate() {
        if cell(shape.start) != cell(shape.end()) {
            ends.entry(cell(shape.start)).or_default().push((number, false));
            ends.entry(cell(shape.end())).or_default().push((number, true));
        }
    }
    let other = |shapes: &[Option<Shape>], here: Point, number: usize, paint: &crate::shape::Paint| {
        let [a, b] = ends.get(&cell(here))?[..] else { return None };
        let (next, at_end) = if a.0 == number { b } else { a };
        let fits = shapes.get(next)?.as_ref().is_some_and(|shape| shape.paint.is_like(paint));
        (next != number && fits).then_some((next, at_end))
    };
    let mut shapes: Vec<Option<Shape>> = shapes.into_iter().map(Some).collect();
    let mut joined = Vec::new();
    for number in 0..shapes.len() {
        let Some(mut whole) = shapes[number].take() else { continue };
        // On from its end, then, turned, from its start.
        let mut tip = [number, number];
        for side in [0, 1] {
            while let Some((next, at_end)) = other(&shapes, whole.end(), tip[side], &whole.paint) {
                let Some(mut part) = shapes[next].take() else { break };
                if at_end {
                    part.turn();
                }
                set_end(&mut whole, part.start);
                whole.pieces.append(&mut part.pieces);
                tip[side] = next;
            }
            if side == 0 {
                whole.turn();
            }
        }
        whole.turn();
        if cell(whole.end()) == cell(whole.start) {
            let start = whole.start;
            set_end(&mut whole, start);
        }
        joined.push(whole);
    }
    joined
}

fn set_end(shape: &mut Shape, to: Point) {
    match shape.pieces.last_mut() {
        Some(Piece::Line(end) | Piece::Arc(_, _, end) | Piece::Ellipse(.., end) | Piece::Cubic(_, _, end)) => *end = to,
        None => {}
    }
}
