//! Coordinate systems: set up, filled, started, stopped, gone on with, and what is asked of them on
//! the way.
use super::{Does, Making};
use crate::path_model::Plane;
use crate::reference::{Call, Cycle, Kind, Path, PathCall, Speeds};

/// A coordinate system as it was set up.
#[derive(Debug, Clone)]
pub struct Made {
    core: i16,
    crd: i16,
    axes: Vec<usize>,
    /// Speeds about this, and accelerations.
    speed: f64,
    acc: f64,
    /// Where each FIFO ends.
    ends: [Vec<i32>; 2],
}

impl Making<'_> {
    pub(super) fn path_name(&self, index: usize) -> (i16, i16) {
        (self.crds[index].core, self.crds[index].crd)
    }

    pub(super) fn forget_paths(&mut self, core: i16) {
        self.crds.retain(|made| made.core != core);
    }

    pub(super) fn start_path(&mut self, index: usize, fifo: usize) {
        let (core, crd) = self.path_name(index);
        let (mask, option) = (1 << (crd - 1), (fifo as i16) << (crd - 1));
        self.path(core, Path::Start { mask, option });
    }

    pub(super) fn path(&mut self, core: i16, what: Path) {
        self.calls.push(Call::Path(PathCall { core, what }));
    }

    fn speeds(&mut self, made: &Made) -> Speeds {
        let vel = made.speed * (0.3 + 1.2 * self.chance.unit());
        let end = if self.one_in(3) { 0.0 } else { made.speed * 1.3 * self.chance.unit() };
        Speeds { vel, acc: made.acc * (0.5 + 1.5 * self.chance.unit()), end }
    }

    /// Another set-up, of axes at rest.
    pub(super) fn set_up_path(&mut self, axis: usize) -> usize {
        let core = self.setup.axes[axis].0;
        let own: Vec<usize> = (0..self.setup.axes.len()).filter(|axis| self.setup.axes[*axis].0 == core).collect();
        let count = (2 + self.below(3) as usize).min(own.len());
        let first = self.below((own.len() - count + 1) as u64) as usize;
        let mut axes: Vec<usize> = own[first..first + count].to_vec();
        if self.one_in(3) {
            axes.reverse();
        }
        let crd = 1 + self.below(2) as i16;
        for &axis in &axes {
            self.rest(axis);
            if self.one_in(8) {
                self.plain(Kind::ZeroPos, axis);
            }
            if self.one_in(3) || self.does[axis] == Does::Path {
                self.plain(Kind::PrfTrap, axis);
            }
        }
        // An arc needs to know where it begins (docs/crd.md).
        self.calls.push(Call::Sleep { ns: 4_000_000 });
        let speed = self.chance.log(2.0, 100.0);
        let acc = speed / self.chance.log(0.7, 9.0);
        let even_ms = if self.one_in(6) { 1 + self.below(3) as i16 } else { 0 };
        // A path begins where the axes are: only then does the generator know where that is.
        let origin = self.one_in(12).then(|| axes.iter().map(|_| self.below(200) as i32 - 100).collect());
        let set = Path::Set { crd, axes: axes.clone(), vel: speed * 1.5, acc: acc * 1.5, even_ms, origin };
        self.path(core, set);
        for &axis in &axes {
            self.does[axis] = Does::Path;
        }
        let ends = [vec![0; count], vec![0; count]];
        self.crds.retain(|made| (made.core, made.crd) != (core, crd));
        self.crds.push(Made { core, crd, axes, speed, acc, ends });
        if self.one_in(2) {
            let smooth = acc * (0.5 + self.chance.unit());
            self.path(core, Path::StopDec { crd, smooth });
        }
        self.crds.len() - 1
    }

    pub(super) fn one_motion(&mut self, index: usize, fifo: usize) {
        let made = self.crds[index].clone();
        let (core, crd) = (made.core, made.crd);
        let speeds = self.speeds(&made);
        let length = (made.speed * self.chance.log(0.3, 8.0)).max(3.0);
        let mut to = made.ends[fifo].clone();
        if self.one_in(4) {
            let planes = [Plane::XY, Plane::YZ, Plane::ZX];
            let plane = if to.len() == 2 { Plane::XY } else { self.pick(&planes) };
            let (first, second) = plane.axes();
            let (radius, turn) = (length.max(8.0), self.chance.unit() * std::f64::consts::TAU);
            let (round, ccw) = if self.one_in(2) {
                let (x, y) = ((radius * turn.cos()).round(), (radius * turn.sin()).round());
                if self.one_in(3) {
                    // Not a full circle: an end that is as far from the centre, to a pulse, and so
                    // far from the begin that a pulse is little of it.
                    let share = (1.0 + self.chance.unit() * 4.0) / 6.0;
                    let end = (-y).atan2(-x) + share * std::f64::consts::TAU;
                    let radius = x.hypot(y);
                    to[first] += (x + radius * end.cos()).round() as i32;
                    to[second] += (y + radius * end.sin()).round() as i32;
                }
                (Cycle::Centre(x, y), self.one_in(2))
            } else {
                to[first] += (radius * turn.cos()) as i32;
                to[second] += (radius * turn.sin()) as i32;
                (Cycle::Radius(if self.one_in(3) { -radius } else { radius }), self.one_in(2))
            };
            let target = [to[first], to[second]];
            let fifo_of = fifo as i16;
            self.path(core, Path::Arc { crd, plane, to: target, round, ccw, speeds, fifo: fifo_of });
        } else {
            for position in &mut to {
                *position += ((self.chance.unit() - 0.5) * 2.0 * length).round() as i32;
            }
            to[0] += 1;
            if to.len() == 2 && self.one_in(6) {
                let (vel, acc) = (speeds.vel, speeds.acc);
                self.path(core, Path::Jump { crd, to: [to[0], to[1]], vel, acc, fifo: fifo as i16 });
            } else {
                self.path(core, Path::Line { crd, to: to.clone(), speeds, fifo: fifo as i16 });
            }
        }
        self.crds[index].ends[fifo] = to;
    }

    pub(super) fn fill_path(&mut self, index: usize, fifo: usize) {
        let (core, crd) = (self.crds[index].core, self.crds[index].crd);
        for _ in 0..1 + self.below(7) {
            match self.below(9) {
                0 => {
                    let ms = self.below(8) as u16;
                    self.path(core, Path::Delay { crd, ms, fifo: fifo as i16 });
                }
                1 if self.one_in(2) => {
                    let index = if self.one_in(12) { self.pick(&[0, 33, -1]) } else { 1 + self.below(6) as i16 };
                    let level = self.one_in(2);
                    self.path(core, Path::Output { crd, index, level, fifo: fifo as i16 });
                }
                1 | 2 => {
                    let mask = 1 << self.below(6);
                    let value = if self.one_in(2) { mask } else { 0 };
                    self.path(core, Path::Outputs { crd, mask, value, fifo: fifo as i16 });
                }
                _ if self.one_in(4) => self.beside(index, fifo),
                _ if self.one_in(6) && self.setup.profile == "gus" => {
                    let (channel, command) = (self.below(2) as i16, self.laser_command());
                    self.path(core, Path::Laser { crd, channel, command, fifo: fifo as i16 });
                }
                _ => self.one_motion(index, fifo),
            }
        }
    }

    /// An entry for what is no coordinate: an analog output, an axis that moves or goes along.
    fn beside(&mut self, index: usize, fifo: usize) {
        let made = self.crds[index].clone();
        let (core, crd, fifo_of) = (made.core, made.crd, fifo as i16);
        if self.one_in(2) {
            let dac = if self.one_in(12) { self.pick(&[0, 9]) } else { 1 + self.below(8) as i16 };
            let value = self.below(65536) as u16 as i16;
            return self.path(core, Path::Analog { crd, dac, value, fifo: fifo_of });
        }
        let free: Vec<usize> = (0..self.setup.axes.len())
            .filter(|axis| self.setup.axes[*axis].0 == core && !made.axes.contains(axis))
            .filter(|axis| self.does[*axis] == Does::Trap)
            .collect();
        if free.is_empty() && !self.one_in(10) {
            return;
        }
        let axis = if free.is_empty() { made.axes[0] } else { self.pick(&free) };
        if self.one_in(2) {
            self.send(index, fifo, axis);
        } else {
            let pulses = (self.below(300) as i32 + 1) * self.chance.sign() as i32;
            self.path(core, Path::Gear { crd, axis, pulses, fifo: fifo_of });
            self.one_motion(index, fifo);
        }
    }

    fn send(&mut self, index: usize, fifo: usize, axis: usize) {
        let Made { core, crd, .. } = self.crds[index];
        let to = (self.below(400) as i32 + 1) * self.chance.sign() as i32;
        let (vel, acc) = (self.speed(), self.rate());
        let modal = if self.one_in(30) { 2 } else { self.below(2) as i16 };
        self.path(core, Path::Move { crd, axis, to, vel, acc, modal, fifo: fifo as i16 });
    }

    /// An axis beside those of a path, in Trap mode and at rest.
    fn spare(&mut self, made: &Made) -> Option<usize> {
        let core = made.core;
        let spare =
            (0..self.setup.axes.len()).find(|axis| self.setup.axes[*axis].0 == core && !made.axes.contains(axis));
        if let Some(axis) = spare {
            let mask = 1 << axis;
            self.calls.push(Call::Stop { mask, abrupt: mask });
            self.calls.push(Call::WaitStop { mask });
            self.sleep(3);
            self.plain(Kind::PrfTrap, axis);
            self.does[axis] = Does::Trap;
        }
        spare
    }

    pub(super) fn paths(&mut self, axis: usize) {
        let index = self.set_up_path(axis);
        let (core, crd) = (self.crds[index].core, self.crds[index].crd);
        let made = self.crds[index].clone();
        let spare = if self.one_in(2) { self.spare(&made) } else { None };
        let fifo = if self.one_in(4) { 1 } else { 0 };
        self.fill_path(index, fifo);
        if let Some(axis) = spare {
            self.send(index, fifo, axis);
            self.fill_path(index, fifo);
        }
        if self.one_in(4) {
            self.path(core, Path::Space { crd, fifo: fifo as i16 });
        }
        if self.one_in(10) {
            self.plain(Kind::ZeroPos, axis);
        }
        self.start_path(index, fifo);
        for _ in 0..self.below(4) {
            self.sleep(15);
            self.during_path(index, fifo);
        }
    }

    pub(super) fn during_path(&mut self, index: usize, fifo: usize) {
        if self.one_in(6) && self.setup.profile == "gus" {
            let channel = self.below(2) as i16;
            return self.light(channel);
        }
        let made = self.crds[index].clone();
        let (core, crd) = (made.core, made.crd);
        let (mask, option) = (1 << (crd - 1), (fifo as i16) << (crd - 1));
        match self.below(12) {
            0 | 1 => {
                let abrupt = if self.one_in(3) { i32::from(mask) } else { 0 };
                self.path(core, Path::Stop { mask: mask.into(), option: abrupt });
                self.path(core, Path::Wait { mask: 1 << (crd - 1) });
                if !self.one_in(3) {
                    self.settle();
                    self.path(core, Path::Why { crd });
                }
                self.path(core, Path::Start { mask, option });
            }
            2 => {
                let mask = made.axes.iter().fold(0, |mask, axis| mask | 1 << axis);
                let abrupt = if self.one_in(3) { mask } else { 0 };
                self.calls.push(Call::Stop { mask, abrupt });
            }
            3 => {
                let ratio = self.pick(&[1.0, 0.5, 0.25, 0.8, 1.5, 0.0]);
                self.path(core, Path::Override { crd, ratio });
            }
            4 | 5 => self.fill_path(index, fifo),
            6 => self.path(core, Path::Status { crd, fifo: fifo as i16 }),
            7 => self.path(core, Path::Remainder { crd, fifo: fifo as i16 }),
            8 => {
                let fifo = self.pick(&[0, 1, 2]);
                self.path(core, Path::Space { crd, fifo });
            }
            9 => self.path(core, Path::Pos { crd }),
            10 => match self.below(6) {
                0 => self.path(core, Path::GetPrm { crd }),
                1 | 2 => self.path(core, Path::Why { crd }),
                3 => {
                    let ms =
                        if self.one_in(8) { self.pick(&[-1.0, 0.001, 1001.0]) } else { self.pick(&[0.0, 1.0, 4.5]) };
                    self.path(core, Path::Filter { crd, ms });
                    self.path(core, Path::GetFilter { crd });
                }
                _ => self.path(core, Path::Vel { crd }),
            },
            _ => self.path(core, Path::Start { mask, option }),
        }
    }

    /// Of a coordinate system that was set up.
    pub(super) fn during_paths(&mut self, axis: usize) {
        let core = self.setup.axes[axis].0;
        let Some(index) = self.crds.iter().position(|made| made.core == core && made.axes.contains(&axis)) else {
            return;
        };
        if self.crds[index].axes.iter().any(|axis| self.does[*axis] != Does::Path) {
            return;
        }
        let (crd, fifo) = (self.crds[index].crd, self.below(2) as usize);
        match self.below(4) {
            0 => {
                self.path(core, Path::Clear { crd, fifo: fifo as i16 });
            }
            1 => {
                self.path(core, Path::Wait { mask: 1 << (crd - 1) });
                self.calls.push(Call::Sleep { ns: 4_000_000 });
                self.fill_path(index, fifo);
                self.path(core, Path::Start { mask: 1 << (crd - 1), option: (fifo as i16) << (crd - 1) });
            }
            _ => self.during_path(index, fifo),
        }
    }
}
