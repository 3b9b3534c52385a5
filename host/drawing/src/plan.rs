//! Shapes to motions.
//!
//! In: shapes in mm of the page, the machine. Out: strokes for the writer: in the dark to each
//! shape, lit along it, at last home; notes, as of shapes that have no pulse. Fails with the shape
//! that leaves the travel, by how much.
use crate::order::order;
use crate::shape::{Piece, Point, Run, Shape, add};
use crate::{Options, layers};
use machine::{Layer, LightMode, Machine};
use strokes::exact::{ONE, Scale, of_f64};
use strokes::{Light, Stroke, Writer};

/// Farther than this nothing is computed, mm.
const COORDINATE_MAX_MM: f64 = 1e6;
/// What rounding in a file may move a point outside the travel, mm. It is moved back.
const SLACK_MM: f64 = 0.001;

pub fn plan(
    mut shapes: Vec<Shape>,
    machine: &Machine,
    options: Options,
    writer: &mut Writer<'_>,
) -> Result<Vec<String>, String> {
    for shape in &mut shapes {
        shift(shape, options.at);
        let finite = |point: Point| point.iter().all(|x| (-COORDINATE_MAX_MM..=COORDINATE_MAX_MM).contains(x));
        let all = |piece: &Piece| match *piece {
            Piece::Line(end) => finite(end),
            Piece::Arc(centre, _, end) => finite(centre) && finite(end),
            Piece::Ellipse(centre, u, v, _, end) => [centre, u, v, end].into_iter().all(finite),
            Piece::Cubic(a, b, end) => [a, b, end].into_iter().all(finite),
        };
        if !finite(shape.start) || !shape.pieces.iter().all(all) {
            return Err(format!("{} goes farther than {COORDINATE_MAX_MM} mm", shape.place));
        }
    }
    let mut plan = Plan::new(machine, writer);
    let (layers, idle) = layers::sort(shapes, machine)?;
    let mut notes: Vec<String> = idle.into_iter().collect();
    let (layers, empty) = with_pulses(layers, machine);
    if empty > 0 {
        notes.push(format!("what is shorter than a pulse is not marked ({empty})"));
    }
    if layers.is_empty() {
        return Err(format!("there is nothing to mark: what is shorter than a pulse is not marked ({empty})"));
    }
    for (layer, shapes) in layers {
        plan.writer.check_speed(layer.speed).map_err(|why| format!("layer \"{}\": {why}", layer.name))?;
        plan.writer.choose(layer.laser);
        let mut at = plan.at;
        let shapes = order(shapes, &mut at);
        let light = match layer.light {
            _ if layer.power == 0.0 => Light::Dark,
            LightMode::Follow => Light::Follow(layer.power),
            LightMode::Constant => Light::Constant(layer.power),
        };
        for _ in 0..layer.passes {
            for shape in &shapes {
                plan.shape(shape, machine.path.arc_tolerance, light, layer.speed);
                // What the writer notes of a motion is of this shape.
                let new = plan.writer.notes().into_iter().skip(plan.noted).map(|(_, note)| note);
                let new: Vec<String> =
                    new.map(|note| format!("layer \"{}\", {}: {note}", layer.name, shape.place)).collect();
                plan.noted += new.len();
                notes.extend(new);
            }
        }
    }
    plan.home();
    plan.outside().map(|()| notes)
}

/// The shapes of each layer that have a pulse, and how many have none.
fn with_pulses<'m>(layers: Vec<(&'m Layer, Vec<Shape>)>, machine: &Machine) -> (Vec<(&'m Layer, Vec<Shape>)>, usize) {
    let scales = ['X', 'Y'].map(|letter| machine.axis(letter).map(Scale::of));
    let pulses = |point: Point| [0, 1].map(|axis| scales[axis].as_ref().map(|scale| scale.pulses(of_mm(point[axis]))));
    let mut empty = 0;
    let mut found = Vec::with_capacity(layers.len());
    for (layer, mut shapes) in layers {
        let all = shapes.len();
        shapes.retain(|shape| !is_empty(shape, machine.path.arc_tolerance, &pulses));
        empty += all - shapes.len();
        if !shapes.is_empty() {
            found.push((layer, shapes));
        }
    }
    (found, empty)
}

/// Whether all points of a shape are the same pulse.
fn is_empty<P: PartialEq>(shape: &Shape, tolerance: f64, pulses: &dyn Fn(Point) -> P) -> bool {
    let start = pulses(shape.start);
    let same = |point: Point| pulses(point) == start;
    if !shape.joints().all(same) {
        return false;
    }
    let mut at = shape.start;
    shape.runs(tolerance).into_iter().all(|run| {
        let (Run::Line(end) | Run::Arc(_, end)) = run;
        let from = std::mem::replace(&mut at, end);
        let Run::Arc(arc, _) = run else { return same(end) };
        let [(left, right), (low, high)] = arc.extent();
        same(end) && same(add(from, [left, low])) && same(add(from, [right, high]))
    })
}

fn shift(shape: &mut Shape, by: Point) {
    let moved = |point: &mut Point| *point = add(*point, by);
    moved(&mut shape.start);
    for piece in &mut shape.pieces {
        match piece {
            Piece::Line(end) => moved(end),
            Piece::Arc(centre, _, end) | Piece::Ellipse(centre, _, _, _, end) => {
                moved(centre);
                moved(end);
            }
            Piece::Cubic(a, b, end) => {
                moved(a);
                moved(b);
                moved(end);
            }
        }
    }
}

struct Plan<'a, 'b> {
    writer: &'a mut Writer<'b>,
    home: [i128; 3],
    /// Where the machine is, exactly, and about.
    exact: [i128; 3],
    at: Point,
    travel: [(f64, f64); 2],
    motions: usize,
    /// Notes of the writer that are taken.
    noted: usize,
    /// Shapes that leave the travel: how many, and the first with its reason.
    outside: (usize, Option<String>),
    /// What all shapes cover.
    covered: [(f64, f64); 2],
}

impl<'a, 'b> Plan<'a, 'b> {
    fn new(machine: &Machine, writer: &'a mut Writer<'b>) -> Plan<'a, 'b> {
        let home = machine::LETTERS.map(|letter| machine.axis(letter).map_or(0.0, |axis| axis.home));
        let travel = ['X', 'Y'].map(|letter| machine.axis(letter).map_or((0.0, 0.0), |axis| axis.travel));
        let exact = home.map(of_f64);
        let (at, covered) = ([home[0], home[1]], [(f64::INFINITY, f64::NEG_INFINITY); 2]);
        Plan { writer, home: exact, exact, at, travel, motions: 0, noted: 0, outside: (0, None), covered }
    }

    /// A point within the travel, if it was but for rounding.
    fn back(&self, point: Point) -> Point {
        let mut point = point;
        for (x, (least, most)) in point.iter_mut().zip(self.travel) {
            if *x < least && *x >= least - SLACK_MM {
                *x = least;
            } else if *x > most && *x <= most + SLACK_MM {
                *x = most;
            }
        }
        point
    }

    /// Covers a range. By how much it leaves the travel: axis, how far it goes.
    fn leaves(&mut self, range: [(f64, f64); 2]) -> Option<(usize, f64)> {
        for ((least, most), (low, high)) in self.covered.iter_mut().zip(range) {
            (*least, *most) = (least.min(low), most.max(high));
        }
        (0..2).find_map(|axis| {
            let ((low, high), (least, most)) = (range[axis], self.travel[axis]);
            if high > most + SLACK_MM { Some((axis, high)) } else { (low < least - SLACK_MM).then_some((axis, low)) }
        })
    }

    fn shape(&mut self, shape: &Shape, tolerance: f64, light: Light, speed: f64) {
        let mut outside = self.leaves([0, 1].map(|axis| (shape.start[axis], shape.start[axis])));
        let start = self.back(shape.start);
        if start != self.at {
            self.go(start, strokes::Shape::Line, Light::Dark, None);
        }
        let mut at = shape.start;
        for run in shape.runs(tolerance) {
            let (end, form) = match run {
                Run::Line(end) => (end, strokes::Shape::Line),
                Run::Arc(arc, end) => {
                    let extent = arc.extent();
                    let range = [0, 1].map(|axis| (at[axis] + extent[axis].0, at[axis] + extent[axis].1));
                    let leaves = self.leaves(range);
                    outside = outside.or(leaves);
                    let touches = [0, 1]
                        .into_iter()
                        .any(|axis| range[axis].0 < self.travel[axis].0 || range[axis].1 > self.travel[axis].1);
                    if touches && self.leaves(range).is_none() {
                        // By rounding only: lines can be moved back.
                        let parts = arc.parts(tolerance);
                        for number in 1..parts {
                            let point = self.back(add(at, arc.at(f64::from(number) / f64::from(parts))));
                            self.go(point, strokes::Shape::Line, light, Some(speed));
                        }
                        (end, strokes::Shape::Line)
                    } else {
                        (end, strokes::Shape::Arc { axes: [0, 1, 2], arc })
                    }
                }
            };
            let leaves = self.leaves([0, 1].map(|axis| (end[axis], end[axis])));
            outside = outside.or(leaves);
            self.go(self.back(end), form, light, Some(speed));
            at = end;
        }
        if let Some((axis, far)) = outside {
            self.outside.0 += 1;
            let (letter, (least, most)) = (['X', 'Y'][axis], self.travel[axis]);
            self.outside.1.get_or_insert_with(|| {
                format!(
                    "{} goes to {letter} {far:.3} mm in the machine; the travel is {least} to {most} mm, --at moves a drawing",
                    shape.place
                )
            });
        }
    }

    fn go(&mut self, to: Point, shape: strokes::Shape, light: Light, speed: Option<f64>) {
        self.motions += 1;
        let exact = [of_mm(to[0]), of_mm(to[1]), self.exact[2]];
        self.writer.stroke(&Stroke { line: self.motions, from: self.exact, to: exact, shape, speed, light });
        (self.exact, self.at) = (exact, to);
    }

    fn home(&mut self) {
        if self.exact != self.home {
            self.motions += 1;
            let (from, to) = (self.exact, self.home);
            let shape = strokes::Shape::Line;
            self.writer.stroke(&Stroke { line: self.motions, from, to, shape, speed: None, light: Light::Dark });
        }
    }

    fn outside(self) -> Result<(), String> {
        let (count, Some(first)) = self.outside else { return Ok(()) };
        let all = if count > 1 { format!("; {count} shapes leave the travel") } else { String::new() };
        let [(left, right), (bottom, top)] = self.covered;
        Err(format!("{first}{all}; the drawing covers X {left:.3} to {right:.3}, Y {bottom:.3} to {top:.3} mm"))
    }
}

/// A number of mm in whole 10⁻¹⁵ mm.
fn of_mm(mm: f64) -> i128 {
    let whole = mm.trunc();
    whole as i128 * ONE + ((mm - whole) * ONE as f64) as i128
}
