//! Random paths: the calls, and the entries that they give.
use super::Position;
use host_tests::path_model::{Geometry, Plane};
use host_tests::reference::chance::Chance;
use host_tests::reference::{Call, Cycle, Kind, Path, PathCall, Setup, Speeds};

/// What lies in the FIFO.
#[derive(Debug, Clone)]
pub enum Entry {
    /// Geometry, speed, acceleration, whether it ends at rest.
    Motion(Geometry, f64, f64, bool),
    Delay(f64),
    /// A general output, from 0.
    Output(u8, bool),
}

/// A path and what holds for it.
pub struct Course {
    pub calls: Vec<Call>,
    pub entries: Vec<Entry>,
    pub dimension: usize,
    pub speed: f64,
    /// T, ms.
    pub corner: f64,
    /// Of each coordinate.
    pub vel: Position,
    pub acc: Position,
    /// It is stopped on its way. A new override disturbs no rule.
    pub disturbed: bool,
    /// One of its Stops is abrupt: what was reached in that tick has been done (docs/crd.md).
    pub abrupt: bool,
    pub stop_dec: f64,
}

const MS: i64 = 1_000_000;

struct Making {
    chance: Chance,
    course: Course,
    at: Position,
}

impl Making {
    fn one_in(&mut self, n: u64) -> bool {
        self.chance.below(n) == 0
    }

    fn path(&mut self, what: Path) {
        self.course.calls.push(Call::Path(PathCall { core: 1, what }));
    }

    fn sleep(&mut self, ms: u64) {
        let ns = 1 + self.chance.below(ms * MS as u64) as i64;
        self.course.calls.push(Call::Sleep { ns });
    }

    fn entry(&mut self) {
        match self.chance.below(12) {
            0 => {
                let ms = self.chance.below(6) as u16;
                self.path(Path::Delay { crd: 1, ms, fifo: 0 });
                self.course.entries.push(Entry::Delay(ms.into()));
            }
            1 | 2 => {
                let (bit, level) = (self.chance.below(6) as u8, self.one_in(2));
                self.path(Path::Output { crd: 1, index: i16::from(bit) + 1, level, fifo: 0 });
                self.course.entries.push(Entry::Output(bit, level));
            }
            3 => self.arc(),
            4 if self.course.dimension == 2 && self.one_in(2) => {
                let to = self.target();
                let (vel, acc) = self.speeds();
                self.path(Path::Jump { crd: 1, to: [to[0] as i32, to[1] as i32], vel, acc, fifo: 0 });
                self.line(to, vel, acc, true);
            }
            _ => {
                let to = self.target();
                let (vel, acc) = self.speeds();
                let speeds = Speeds { vel, acc, end: 0.0 };
                let named = to[..self.course.dimension].iter().map(|x| *x as i32).collect();
                self.path(Path::Line { crd: 1, to: named, speeds, fifo: 0 });
                self.line(to, vel, acc, false);
            }
        }
    }

    fn speeds(&mut self) -> (f64, f64) {
        let speed = self.course.speed;
        (speed * self.chance.within(0.2, 1.3), speed / self.chance.log(2.0, 12.0))
    }

    /// A place near or far, mostly straight on.
    fn target(&mut self) -> Position {
        let far = self.chance.log(2.0, 400.0);
        let mut to = self.at;
        for position in &mut to[..self.course.dimension] {
            *position += ((self.chance.unit() - 0.4) * far).round();
        }
        to[0] += 1.0;
        if to == self.at {
            to[1] += 3.0;
        }
        to
    }

    fn line(&mut self, to: Position, vel: f64, acc: f64, rests: bool) {
        self.course.entries.push(Entry::Motion(Geometry::line(self.at, to), vel, acc, rests));
        self.at = to;
    }

    fn arc(&mut self) {
        let radius = self.chance.log(8.0, 300.0).round();
        let turn = self.chance.unit() * std::f64::consts::TAU;
        let (vel, acc) = self.speeds();
        let speeds = Speeds { vel, acc, end: 0.0 };
        let ccw = self.one_in(2);
        let (geometry, round) = if self.one_in(3) {
            let offset = ((radius * turn.cos()).round(), (radius * turn.sin()).round());
            let end = (self.at[0], self.at[1]);
            (Geometry::arc_by_centre(self.at, Plane::XY, end, offset, ccw), Cycle::Centre(offset.0, offset.1))
        } else {
            let end = (self.at[0] + (radius * turn.cos()).round(), self.at[1] + (radius * turn.sin()).round());
            let radius = radius * if self.one_in(4) { -1.1 } else { 1.1 };
            (Geometry::arc_by_radius(self.at, Plane::XY, end, radius, ccw), Cycle::Radius(radius))
        };
        let Some(geometry) = geometry else { return };
        let end = geometry.end();
        let to = [end[0].round(), end[1].round(), self.at[2], self.at[3]];
        let named = [to[0] as i32, to[1] as i32];
        self.path(Path::Arc { crd: 1, plane: Plane::XY, to: named, round, ccw, speeds, fifo: 0 });
        self.course.entries.push(Entry::Motion(geometry, vel, acc, false));
        self.at = to;
    }

    /// On the way: a Stop and on again, another override, more data, reads.
    fn during(&mut self) {
        self.sleep(12);
        match self.chance.below(6) {
            0 | 1 => {
                self.course.disturbed = true;
                let abrupt = i32::from(self.one_in(4));
                self.course.abrupt |= abrupt == 1;
                self.path(Path::Stop { mask: 1, option: abrupt });
                self.path(Path::Wait { mask: 1 });
                self.course.calls.push(Call::Sleep { ns: 4 * MS });
                self.path(Path::Start { mask: 1, option: 0 });
            }
            2 => {
                let ratio = [1.0, 0.5, 0.25, 0.8][self.chance.below(4) as usize];
                self.path(Path::Override { crd: 1, ratio });
            }
            3 => self.path(Path::Status { crd: 1, fifo: 0 }),
            _ => {}
        }
    }
}

/// The path of a number.
pub fn course(seed: u64, setup: &Setup) -> Course {
    let mut chance = Chance::new(seed);
    let dimension = 2 + chance.below(3) as usize;
    let speed = chance.log(4.0, 120.0);
    let acc_max = speed / chance.log(1.0, 10.0);
    let corner = chance.log(0.5, 8.0);
    let course = Course {
        calls: Vec::new(),
        entries: Vec::new(),
        dimension,
        speed: speed * 1.1,
        corner,
        vel: [f64::INFINITY; 4],
        acc: [acc_max; 4],
        disturbed: false,
        abrupt: false,
        stop_dec: speed / 2.0,
    };
    let mut making = Making { chance, course, at: [0.0; 4] };
    let axes: Vec<usize> = (0..dimension).collect();
    for axis in 0..setup.axes.len() {
        making.course.calls.push(Call::Axis { kind: Kind::AxisOn, axis });
    }
    let set = Path::Set { crd: 1, axes, vel: speed * 1.1, acc: speed, even_ms: 0, origin: None };
    making.path(set);
    let count = [200, 32, 8, 3][making.chance.below(4) as usize];
    for coordinate in 0..dimension {
        if making.one_in(3) {
            let (vel, acc) = (speed * making.chance.within(0.2, 1.0), acc_max * making.chance.within(0.2, 1.0));
            making.path(Path::Limit { crd: 1, coordinate: coordinate as i16 + 1, vel, acc });
            (making.course.vel[coordinate], making.course.acc[coordinate]) = (vel, acc);
        }
    }
    making.path(Path::LookAhead { crd: 1, fifo: 0, time: corner, acc: acc_max, count });
    let smooth = making.course.stop_dec;
    making.path(Path::StopDec { crd: 1, smooth });
    for _ in 0..3 + making.chance.below(40) {
        making.entry();
    }
    if making.one_in(2) {
        making.path(Path::Flush { crd: 1, fifo: 0 });
    }
    making.course.calls.push(Call::Sleep { ns: 3 * MS });
    making.path(Path::Start { mask: 1, option: 0 });
    for _ in 0..making.chance.below(4) {
        making.during();
        if making.one_in(3) {
            for _ in 0..1 + making.chance.below(10) {
                making.entry();
            }
        }
    }
    making.path(Path::Flush { crd: 1, fifo: 0 });
    making.path(Path::Wait { mask: 1 });
    making.course.calls.push(Call::Sleep { ns: 4 * MS });
    // Data that came after its end.
    making.path(Path::Start { mask: 1, option: 0 });
    making.path(Path::Wait { mask: 1 });
    making.course.calls.push(Call::Sleep { ns: 6 * MS });
    making.path(Path::Status { crd: 1, fifo: 0 });
    making.course
}
