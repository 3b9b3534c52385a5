//! The time that a path takes.
//!
//! In: the motions of a path in pulses, with speed and acceleration, and dwells. Out: ms. It is the
//! controller's own look-ahead that plans the speeds. Owns the motions that it has not planned yet.
//! Fails never: a motion that a controller refuses takes no time here.
use dispatcher::plan::geometry::{Geometry, Position};
use dispatcher::plan::look_ahead::{Limits, LookAhead};
use machine::Machine;
use servo::path::Plane;

/// Motions that are planned together, as many as in the virtual controller.
const LOOK_AHEAD_MOTIONS: usize = 512;

pub struct Estimate {
    ahead: Box<LookAhead<LOOK_AHEAD_MOTIONS, LOOK_AHEAD_MOTIONS>>,
    at: Position,
    ms: f64,
}

/// A position in all coordinates of a path.
fn position(pulses: [i64; 3]) -> [i32; 4] {
    let [x, y, z] = pulses.map(|pulse| pulse.clamp(i32::MIN.into(), i32::MAX.into()) as i32);
    [x, y, z, 0]
}

impl Estimate {
    /// From standstill at `at`, with the corner time in ms.
    pub fn new(machine: &Machine, at: [i64; 3], corner: f64) -> Estimate {
        let mut limits = Limits { vel: [f64::INFINITY; 4], acc: [f64::INFINITY; 4], corner };
        for (place, axis) in machine.axes.iter().enumerate() {
            (limits.vel[place], limits.acc[place]) = (axis.rate(), axis.pulse_acceleration());
        }
        Estimate { ahead: Box::new(LookAhead::new(limits)), at: position(at).map(f64::from), ms: 0.0 }
    }

    /// A line, in pulse/ms and pulse/ms².
    pub fn line(&mut self, to: [i64; 3], vel: f64, acc: f64) {
        self.push(Geometry::line(&self.at, position(to)).ok(), vel, acc);
    }

    /// An arc about a centre that is given from its start.
    pub fn arc(&mut self, plane: [usize; 2], to: [i64; 3], centre: [f64; 2], ccw: bool, (vel, acc): (f64, f64)) {
        let name = match plane {
            [0, 1] => Plane::Xy,
            [1, 2] => Plane::Yz,
            _ => Plane::Zx,
        };
        let to = position(to);
        let geometry = Geometry::arc_centre(&self.at, name, plane.map(|axis| to[axis]), centre, ccw);
        self.push(geometry.ok(), vel, acc);
    }

    fn push(&mut self, geometry: Option<Geometry>, vel: f64, acc: f64) {
        let Some(geometry) = geometry else { return };
        while !self.ahead.push_motion(&geometry, vel, acc) {
            // As the controller does: what is final, and if that is nothing, a few at a level.
            while let Some(planned) = self.ahead.take(false) {
                self.ms += planned.ms;
            }
            if self.ahead.is_full() {
                for _ in 0..self.ahead.hold_level() {
                    self.ms += self.ahead.take(true).map_or(0.0, |planned| planned.ms);
                }
                self.ahead.release_level();
            }
        }
        self.at = geometry.end;
    }

    /// A standstill of so many ms.
    pub fn dwell(&mut self, ms: f64) {
        self.ms = self.total() + ms;
        self.ahead.clear();
    }

    /// The time up to standstill at the end.
    pub fn total(&mut self) -> f64 {
        while let Some(planned) = self.ahead.take(true) {
            self.ms += planned.ms;
        }
        self.ms
    }
}
