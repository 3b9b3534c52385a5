//! Motions of a stroke: a line, an arc of the controller, or lines along an arc.
//!
//! In: a stroke, in mm. Out: its calls, in the writer's text. Owns nothing. Fails: no stroke does;
//! where the controller has no arc as near as the machine's tolerance, lines replace it.
use super::{Light, Power, Shape, Stroke, UnreachedSpeed, Writer, norm};
use crate::arc::Arc;
use crate::exact::{ONE, to_f64};
use crate::number::Number;
use machine::LETTERS;

/// An arc of a larger radius becomes lines; the controller takes one less than twice as large.
const RADIUS_MAX_PULSES: f64 = (1 << 30) as f64;

impl Writer<'_> {
    /// Moves.
    pub fn stroke(&mut self, stroke: &Stroke) {
        self.cover(stroke);
        self.show(stroke);
        let mut to = self.at;
        for (place, scale) in self.scales.iter().enumerate() {
            to[place] = scale.pulses(stroke.to[place]);
        }
        match stroke.shape {
            Shape::Line => {
                let way = [0, 1, 2].map(|axis| to_f64(stroke.to[axis] - stroke.from[axis]));
                self.straight(stroke, way, to);
            }
            Shape::Arc { axes, arc } => {
                let flat = axes[2] >= self.scales.len() || to[axes[2]] == self.at[axes[2]];
                if !(flat && self.round(stroke, axes, &arc, to)) {
                    self.curve(stroke, axes, &arc, to);
                }
            }
        }
    }

    /// A line to `to`, which goes `way` mm.
    fn straight(&mut self, stroke: &Stroke, way: [f64; 3], to: [i64; 3]) {
        let length = norm(way);
        if to == self.at || length == 0.0 {
            return;
        }
        let (mut rate, mut acceleration) = (f64::INFINITY, f64::INFINITY);
        let (mut steps, mut same) = (0.0, true);
        // The displacement that is run, in pulses and in mm.
        let (mut pulses, mut run) = ([0.0; 3], [0.0; 3]);
        for (place, (axis, scale)) in self.machine.axes.iter().zip(&self.scales).enumerate() {
            let part = way[place].abs() / length;
            if part > 0.0 {
                rate = rate.min(axis.max_rate / part);
                acceleration = acceleration.min(axis.acceleration / part);
                same &= steps == 0.0 || steps == scale.per_mm.abs();
                steps = scale.per_mm.abs();
            }
            pulses[place] = (to[place] - self.at[place]) as f64;
            run[place] = pulses[place] / scale.per_mm;
        }
        let per_mm = if same { steps } else { norm(pulses) / norm(run) };
        self.light(self.power(stroke, per_mm));
        let speed = self.speed(stroke, rate);
        let (vel, acc) = (speed / 60_000.0 * per_mm, acceleration / 1e6 * per_mm);
        let ([x, y, z], line) = (to, stroke.line);
        if let Some(time) = &mut self.time {
            time.line(to, vel, acc);
        }
        let (vel, acc) = (Number(vel), Number(acc));
        match self.scales.len() {
            2 => self.put(format_args!("GT_LnXY(1, {x}, {y}, {vel}, {acc}); // {line}\n")),
            _ => self.put(format_args!("GT_LnXYZ(1, {x}, {y}, {z}, {vel}, {acc}); // {line}\n")),
        }
        self.at = to;
        self.entered();
    }

    /// mm/min of a stroke, where the machine reaches so much.
    fn speed(&mut self, stroke: &Stroke, rate: f64) -> f64 {
        if let (Some(speed), Light::Follow(_)) = (stroke.speed, stroke.light) {
            let asked = speed * self.feed;
            // Rates of directions are rounded.
            if asked > rate * 1.000_001 {
                self.unreached_speed.get_or_insert(UnreachedSpeed { line: stroke.line, asked, reached: rate });
            }
        }
        stroke.speed.map_or(rate * self.rapid, |speed| (speed * self.feed).min(rate))
    }

    /// What the laser does on a stroke that has so many pulses a mm.
    fn power(&self, stroke: &Stroke, per_mm: f64) -> Option<Power> {
        match (stroke.light, stroke.speed) {
            (Light::Dark, _) | (Light::Follow(_), None) => None,
            (Light::Constant(power), _) => Some(Power::Constant(power)),
            (Light::Follow(most), Some(speed)) => {
                let full = self.machine.lasers.get(self.laser).map_or(most, |laser| laser.power.1);
                // Faster than F, the power of a mm stays.
                let (ratio, most) = (most / (speed / 60_000.0 * per_mm), (most * self.feed).min(full));
                Some(Power::Follow { ratio, most })
            }
        }
    }

    /// An arc of the controller; false where it has none that is as near as that.
    fn round(&mut self, stroke: &Stroke, axes: [usize; 3], arc: &Arc, to: [i64; 3]) -> bool {
        let [a, b, _] = axes;
        let (first, second) = (self.scales[a].per_mm, self.scales[b].per_mm);
        if first.abs() != second.abs() {
            return false;
        }
        let chord = [(to[a] - self.at[a]) as f64, (to[b] - self.at[b]) as f64];
        // From the pulse where the path is.
        let off = |axis: usize| to_f64(stroke.from[axis]) * self.scales[axis].per_mm - self.at[axis] as f64;
        let centre = [arc.centre[0] * first + off(a), arc.centre[1] * second + off(b)];
        let centre = if chord == [0.0, 0.0] {
            if arc.sweep.abs() < std::f64::consts::PI {
                return true;
            }
            centre
        } else {
            // The centre of an arc is as far from its end as from its start.
            let size = chord[0].hypot(chord[1]);
            let along = (centre[0] * chord[0] + centre[1] * chord[1]) / size - size / 2.0;
            if along.abs() > 1.0 {
                return false;
            }
            [centre[0] - along * chord[0] / size, centre[1] - along * chord[1] / size]
        };
        if !(1.0..RADIUS_MAX_PULSES).contains(&centre[0].hypot(centre[1])) {
            return false;
        }
        let (axis_a, axis_b) = (&self.machine.axes[a], &self.machine.axes[b]);
        let rate = axis_a.max_rate.min(axis_b.max_rate);
        let acceleration = axis_a.acceleration.min(axis_b.acceleration);
        let per_mm = first.abs();
        self.light(self.power(stroke, per_mm));
        let speed = self.speed(stroke, rate);
        let (vel, acc) = (speed / 60_000.0 * per_mm, acceleration / 1e6 * per_mm);
        let ccw = u8::from((arc.sweep > 0.0) == ((first > 0.0) == (second > 0.0)));
        let plane: String = [a, b].iter().map(|axis| LETTERS[*axis]).collect();
        let ([x, y], [p, q], line) = (centre, [to[a], to[b]], stroke.line);
        if let Some(time) = &mut self.time {
            time.arc([a, b], to, centre, ccw == 1, (vel, acc));
        }
        self.put(format_args!("GT_Arc{plane}C(1, {p}, {q}, {x}, {y}, {ccw}, {vel}, {acc}); // {line}\n"));
        self.at = to;
        self.entered();
        true
    }

    /// Lines along an arc.
    fn curve(&mut self, stroke: &Stroke, axes: [usize; 3], arc: &Arc, to: [i64; 3]) {
        let [a, b, across] = axes;
        let parts = arc.parts(self.machine.path.arc_tolerance);
        let rise = to_f64(stroke.to[across] - stroke.from[across]);
        let mut before = [0.0; 3];
        for number in 1..=parts {
            let part = f64::from(number) / f64::from(parts);
            let mut here = [0.0; 3];
            [here[a], here[b]] = arc.at(part);
            here[across] = rise * part;
            let mut next = to;
            if number < parts {
                for (place, scale) in self.scales.iter().enumerate() {
                    let mm = stroke.from[place] + (here[place] * ONE as f64) as i128;
                    next[place] = scale.pulses(mm);
                }
            }
            let way = [0, 1, 2].map(|axis| here[axis] - before[axis]);
            if next != self.at {
                self.straight(stroke, way, next);
                before = here;
            }
        }
    }
}
