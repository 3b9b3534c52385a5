//! Random chains of axes, renamed between runs, their masters planned again during them: every
//! slave is, tick by tick, where the positions of its master put it, and never moves further than
//! these do times its ratio.
//!
//! FOLLOW_PROGRAMS asks for more programs than in a daily build, FOLLOW_SEED for others.
use crate::{chance, follow_reference, tick_bench};
#[path = "follow_random/check.rs"]
mod check;
use chance::Chance;
use follow_reference::{Begin, Datum, Known, MasterPath, Slave, fixed};
use servo::output::step_generator;
use servo::path::{FeedOverride, MotionSpeeds, PathEntry};
use servo::segment::follow::{Direction, MasterPosition, StartEvent as Start};
use servo::status;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{AxisMask, Ns, Pos};
use servo::view::{StopReason, View};
use tick_bench::*;

/// Deviations in the servo, of a slave and of all slaves before it, and in the reference.
const CLOSE: i128 = 1 << (48 - 16);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Jog,
    Trap,
    Pt,
    Pvt,
    Crd,
}

/// One link of the chain.
struct Link {
    axis: usize,
    master: usize,
    value: MasterPosition,
    dir: i128,
    data: [Option<Vec<Datum>>; 2],
    passes: u32,
    event: Start,
    /// While it follows.
    slave: Option<Slave>,
    /// It has to stop in the tick to come, or to brake after it.
    reported: Option<bool>,
    steepest: f64,
}

struct Program {
    chance: Chance,
    bench: Bench,
    view: View<AXES>,
    kind: Kind,
    master: usize,
    mode: MotionMode,
    links: Vec<Link>,
    /// Positions of the machine and counts of the encoders at the tick before.
    places: [Pos; AXES],
    counts: [i64; AXES],
    /// End of the data that a PT master has got.
    stream: (f64, i32),
    log: Vec<String>,
    /// Positions that were compared; displacements of slaves that reversed between ticks.
    compared: u64,
    exact: u64,
}

fn named(bench: &Bench, view: &View<AXES>, index: usize) -> i128 {
    fixed(bench.machine.set_points[index]) - fixed(view.axes[index].pos)
}

impl Program {
    fn new(seed: u64) -> Program {
        let mut chance = Chance::new(seed);
        let period = [100, 250, 250, 250, 300, 1000][chance.below(6) as usize];
        let mode = [MotionMode::Follow, MotionMode::FollowEx][chance.below(2) as usize];
        let mut order: Vec<usize> = (0..AXES).collect();
        for i in (1..AXES).rev() {
            order.swap(i, chance.below(i as u64 + 1) as usize);
        }
        let kind =
            [Kind::Jog, Kind::Jog, Kind::Trap, Kind::Trap, Kind::Pt, Kind::Pvt, Kind::Crd][chance.below(7) as usize];
        let mut bench = Bench::prepared(period, mode);
        let depth = 2 + chance.below(3) as usize;
        let links = (1..depth)
            .map(|k| {
                let master = order[if chance.below(4) == 0 { chance.below(k as u64) as usize } else { k - 1 }];
                let value = if chance.below(8) == 0 { MasterPosition::Encoder } else { MasterPosition::Planned };
                let data = [None, None];
                let (dir, passes, reported, slave, steepest) = (0, 1, None, None, 0.0);
                Link {
                    axis: order[k],
                    master,
                    value,
                    dir,
                    data,
                    passes,
                    event: Start::Start,
                    slave,
                    reported,
                    steepest,
                }
            })
            .collect();
        let view = bench.tick();
        let places = bench.machine.set_points;
        let (log, compared, exact) = (vec![format!("{kind:?} {period} us {mode:?} {order:?} {depth}")], 0, 0);
        let (counts, stream, master) = ([0; AXES], (0.0, 0), order[0]);
        Program { chance, bench, view, kind, master, mode, links, places, counts, stream, log, compared, exact }
    }

    fn note(&mut self, text: String) {
        self.log.push(format!("tick {}: {text}", self.view.tick));
    }

    fn now(&mut self, command: TickCommand) {
        self.note(format!("{command:?}"));
        self.bench.now(command);
    }

    fn below(&mut self, n: u64) -> u64 {
        self.chance.below(n)
    }

    fn real(&mut self, low: f64, high: f64) -> f64 {
        low + self.chance.unit() * (high - low)
    }

    /// Positions get other user values.
    fn rename(&mut self, index: usize) {
        let axis = axis(index);
        let pulses = self.below(2001) as i64 - 1000;
        match self.below(4) {
            0 => self.now(TickCommand::Zero { axes: axis.mask() }),
            1 => self.now(TickCommand::SetEncoder { axis, pulses }),
            _ => self.now(TickCommand::SetPosition { axis, pos: Pos::pulses(pulses as i32) }),
        }
    }

    /// Data whose ratios stay below 2.
    fn data(&mut self, dir: i128) -> Vec<Datum> {
        let (mut master, mut slave, mut ratio) = (0i64, 0i64, 0.0f64);
        let down = dir != 1 && self.below(3) == 0;
        let count = 1 + self.below(5);
        let first = if self.below(3) == 0 { 3 } else { 0 };
        let mut data = Vec::new();
        for k in 0..count {
            let length = 300 + self.below(1500) as i64;
            // A displacement for which the end ratio is one that was chosen; the first ones may go
            // on from another.
            let end = self.real(-1.5, 2.0);
            let kind = if k == 0 && first == 3 { 3 } else { [0, 0, 1, 2][self.below(4) as usize] };
            let mean = match kind {
                1 => end,
                2 => end / 2.0,
                _ => (ratio + end) / 2.0,
            };
            let path = (mean * length as f64) as i64;
            let mean = path as f64 / length as f64;
            ratio = match kind {
                1 => mean,
                2 => 0.0,
                _ => 2.0 * mean - ratio,
            };
            (master, slave) = (master + length, slave + path);
            let percent = if self.mode == MotionMode::FollowEx && kind != 1 { self.below(101) as i16 } else { 0 };
            data.push((if down { -master } else { master }, slave, kind, percent));
        }
        data
    }

    /// Three tables for a master that runs them, at rest.
    fn tables(&mut self) {
        for table in 0..3 {
            let mut at = 0;
            let knots: Vec<(u64, i64, i64)> = (0..2 + self.below(5))
                .map(|k| {
                    at += if k == 0 { 0 } else { 2 + self.below(30) };
                    let place = if k == 0 { 0 } else { self.below(60) as i64 - 30 };
                    (at, place, self.below(6 << 16) as i64 - (3 << 16))
                })
                .collect();
            self.note(format!("table {table} {knots:?}"));
            let delay = self.below(5);
            self.bench.table(table, delay, &knots);
        }
    }

    fn configure(&mut self, k: usize) {
        let axis = axis(self.links[k].axis);
        let index = axis.index();
        self.now(TickCommand::SetMode { axis, mode: MotionMode::Trap });
        self.now(TickCommand::SetMode { axis, mode: self.mode });
        let dir = [0, 1, -1][self.below(3) as usize];
        let direction = [Direction::Down, Direction::Both, Direction::Up][(dir + 1) as usize];
        self.now(TickCommand::FollowDirection { axis, direction });
        let (master, value) = (self.links[k].master, self.links[k].value);
        self.bench.follows(index, master, value);
        let mut all = [None, None];
        for fifo in 0..1 + self.below(2) as u8 {
            self.bench.emptied(index, fifo);
            let mut data = self.data(dir);
            // A FIFO downwards means no direction of its own.
            if dir == -1 {
                data.iter_mut().for_each(|datum| datum.0 = datum.0.abs());
            }
            let items: Vec<Item> =
                data.iter().map(|&(m, s, kind, c)| Item::Data(m as f64 / 8.0, s as f64 / 8.0, kind, c)).collect();
            self.bench.follow_in(index, fifo, direction, &items);
            self.note(format!("data {index} {fifo} {data:?}"));
            all[fifo as usize] = Some(data);
        }
        let passes = self.below(4) as u32;
        self.now(TickCommand::FollowLoop { axis, passes });
        let link = &mut self.links[k];
        (link.dir, link.data, link.passes) = (dir, all, passes);
    }

    fn event(&mut self, k: usize) {
        let axis = axis(self.links[k].axis);
        let near = self.view.axes[self.links[k].master].pos.0 >> Pos::FRAC_BITS;
        let event = if self.below(4) == 0 {
            Start::Pass { up: self.below(2) == 0, pos: near as i32 + self.below(101) as i32 - 50 }
        } else {
            Start::Start
        };
        self.now(TickCommand::FollowEvent { axis, event });
        self.links[k].event = event;
    }

    /// FollowStart of some links.
    fn start(&mut self, links: &[usize]) {
        let axes: Vec<usize> = links.iter().map(|k| self.links[*k].axis).collect();
        self.now(TickCommand::FollowStart { axes: all(&axes), fifo1: AxisMask(0) });
        for &k in links {
            let Link { axis, master, value, dir, passes, event, .. } = self.links[k];
            let begin = match event {
                Start::Start => Begin::Start,
                Start::Pass { up, pos } => {
                    let zero = match value {
                        MasterPosition::Planned => named(&self.bench, &self.view, master),
                        _ => {
                            let shift = self.view.axes[master].encoder - self.counts[master];
                            -fixed(Pos::pulses(shift as i32))
                        }
                    };
                    Begin::Pass(up, fixed(Pos::pulses(pos)) + zero)
                }
            };
            let origin = fixed(self.bench.machine.set_points[axis]);
            let data = self.links[k].data.clone();
            let slave = Slave::new(data, dir, passes, begin, origin);
            (self.links[k].slave, self.links[k].reported) = (Some(slave), None);
        }
    }

    /// The master starts, or moves elsewhere.
    fn drive(&mut self) {
        let axis = axis(self.master);
        match self.kind {
            Kind::Jog => {
                let (velocity, acc, dec) = (self.real(-6.0, 6.0), self.real(0.02, 2.0), self.real(0.02, 2.0));
                let velocity = if self.below(4) == 0 { 0.0 } else { velocity };
                let smooth = if self.below(3) == 0 { self.below(65536) as u16 } else { 0 };
                self.now(TickCommand::JogPrm { axis, acc: accel(acc), dec: accel(dec), smooth });
                self.now(TickCommand::TargetSpeed { axis, speed: speed(velocity) });
                self.now(TickCommand::Update { axes: axis.mask() });
            }
            Kind::Trap => {
                let (velocity, acc, dec) = (self.real(0.5, 6.0), self.real(0.02, 2.0), self.real(0.02, 2.0));
                let smooth = Ns(if self.below(3) == 0 { self.below(20) * MS } else { 0 });
                self.now(TickCommand::TrapPrm {
                    axis,
                    acc: accel(acc),
                    dec: accel(dec),
                    vel_start: speed(0.0),
                    smooth,
                });
                self.now(TickCommand::TargetSpeed { axis, speed: speed(velocity) });
                let near = (self.view.axes[self.master].pos.0 >> Pos::FRAC_BITS) as i32;
                let path = self.below(801) as i32 - 400;
                self.now(TickCommand::TargetPosition { axis, pulses: near + path });
                self.now(TickCommand::Update { axes: axis.mask() });
            }
            Kind::Pt => {
                // Data that comes while it runs is appended.
                let runs = has(&self.view.axes[self.master], status::RUNNING);
                if !runs {
                    self.bench.forget(self.master);
                    self.now(TickCommand::PtClear { axis, fifo: 0 });
                    self.stream = (0.0, 0);
                }
                let segments: Vec<(f64, i32, i16)> = (0..1 + self.below(6))
                    .map(|_| {
                        let path = 1 + self.below(30) as i32;
                        let mean = self.real(-2.0, 2.0);
                        let (pos, time) = &mut self.stream;
                        (*pos, *time) = (*pos + mean * f64::from(path), *time + path);
                        let (pos, time) = self.stream;
                        (pos, time, [0, 1, 1, 2][self.below(4) as usize])
                    })
                    .collect();
                self.note(format!("pt {segments:?}"));
                self.bench.pt(self.master, 0, &segments);
                let passes = self.below(3) as u32;
                self.now(TickCommand::PtLoop { axis, passes });
                if !runs {
                    self.now(TickCommand::PtStart { axes: axis.mask(), fifo1: AxisMask(0) });
                }
            }
            Kind::Pvt => {
                let (table, passes) = (self.below(3) as u8, self.below(3) as u32);
                self.now(TickCommand::PvtSelect { axis, table });
                self.now(TickCommand::PvtLoop { axis, passes });
                self.now(TickCommand::PvtStart { axes: axis.mask() });
            }
            Kind::Crd => {
                let entries: Vec<PathEntry> = (0..3 + self.below(10))
                    .map(|_| {
                        let to = [self.below(101) as i32 - 50, self.below(101) as i32 - 50];
                        let (vel, acc, end) = (self.real(0.5, 6.0), self.real(0.02, 2.0), self.real(0.0, 6.0));
                        let along = MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap();
                        if self.below(8) == 0 {
                            PathEntry::delay(self.below(9) as u16)
                        } else {
                            PathEntry::planar(to, along)
                        }
                    })
                    .collect();
                self.note(format!("path {entries:?}"));
                self.bench.path(0, 0, &entries);
                self.bench.start_path(&[0]);
            }
        }
    }

    /// Something happens to the master, or to a slave.
    fn disturb(&mut self) {
        let axis = axis(self.master);
        let soft = matches!(self.kind, Kind::Jog | Kind::Trap);
        match self.below(16) {
            0..=5 if soft => self.drive(),
            0..=2 if self.kind == Kind::Crd => {
                let rate = FeedOverride::admit(self.real(0.1, 1.0).to_bits()).unwrap();
                self.now(TickCommand::CrdOverride { crd: crd(0), rate });
            }
            0..=2 if self.kind == Kind::Pvt => {
                let table = self.below(3) as u8;
                self.now(TickCommand::PvtSelect { axis, table });
            }
            3 if !soft => self.drive(),
            6 | 7 => self.now(TickCommand::stop(axis.mask(), AxisMask(0))),
            8 => {
                self.now(TickCommand::stop(axis.mask(), axis.mask()));
                self.rename(self.master);
            }
            9 => {
                self.now(TickCommand::Servo { axis, on: false });
                self.now(TickCommand::Servo { axis, on: true });
            }
            10 => {
                let index = self.below(AXES as u64) as usize;
                let running = has(&self.view.axes[index], status::RUNNING);
                // An axis at rest may start in this tick: then its user position is in force from
                // the start on, here as there.
                if running || self.links.iter().all(|link| link.axis != index) && index != self.master {
                    self.rename(index);
                }
            }
            11 => self.now(TickCommand::Link { lost: true }),
            12 | 13 => {
                let k = self.below(self.links.len() as u64) as usize;
                let axis = self.links[k].axis;
                if self.links[k].slave.as_ref().is_some_and(Slave::may_switch)
                    && has(&self.view.axes[axis], status::RUNNING)
                {
                    self.now(TickCommand::FollowSwitch { axes: all(&[axis]) });
                    self.links[k].slave.as_mut().unwrap().switching = true;
                }
            }
            14 => {
                let (k, passes) = (self.below(self.links.len() as u64) as usize, self.below(4) as u32);
                let axis = tick_bench::axis(self.links[k].axis);
                self.now(TickCommand::FollowLoop { axis, passes });
                self.links[k].passes = passes;
                if let Some(slave) = &mut self.links[k].slave {
                    slave.passes = passes;
                }
            }
            _ => {
                let (k, abrupt) = (self.below(self.links.len() as u64) as usize, self.below(2) == 0);
                let mask = all(&[self.links[k].axis]);
                self.now(TickCommand::stop(mask, if abrupt { mask } else { AxisMask(0) }));
                self.links[k].reported = Some(abrupt);
            }
        }
    }

    fn ticks(&mut self, count: u64) -> Result<(), String> {
        (0..count).try_for_each(|_| self.tick())
    }

    /// Until nothing moves.
    fn rest(&mut self, smooth: bool) -> Result<(), String> {
        let every = AxisMask(0xff);
        self.now(TickCommand::stop(every, if smooth { AxisMask(0) } else { every }));
        for link in &mut self.links {
            link.reported = Some(!smooth);
        }
        self.tick()?;
        for _ in 0..100_000 {
            if self.view.axes.iter().all(|axis| !has(axis, status::RUNNING)) {
                self.ticks(2)?;
                for index in 0..AXES {
                    self.bench.now(TickCommand::ClearStatus { axes: all(&[index]) });
                }
                return self.tick();
            }
            self.tick()?;
        }
        Err("no rest".into())
    }

    fn run(&mut self) -> Result<(), String> {
        let mode = match self.kind {
            Kind::Jog => MotionMode::Jog,
            Kind::Trap | Kind::Crd => MotionMode::Trap,
            Kind::Pt => MotionMode::PtStatic,
            Kind::Pvt => MotionMode::Pvt,
        };
        self.now(TickCommand::SetMode { axis: axis(self.master), mode });
        if self.kind == Kind::Crd {
            let other =
                (0..AXES).find(|index| *index != self.master && self.links.iter().all(|link| link.axis != *index));
            self.bench.frame(0, &[self.master, other.unwrap()], None);
        }
        self.tick()?;
        for run in 0..2 + self.below(2) {
            for index in 0..AXES {
                if self.below(2) == 0 {
                    self.rename(index);
                }
            }
            if self.kind == Kind::Crd {
                self.bench.clear_path(0, 0);
            }
            self.tick()?;
            if self.kind == Kind::Pvt {
                self.tables();
            }
            for k in 0..self.links.len() {
                if run == 0 || self.below(2) == 0 || self.view.axes[self.links[k].axis].cleared != [0; 2] {
                    self.configure(k);
                }
                self.event(k);
            }
            let wait = self.below(20);
            self.ticks(1 + wait)?;
            let every: Vec<usize> = (0..self.links.len()).collect();
            if self.below(3) == 0 {
                self.drive();
                let wait = self.below(60);
                self.ticks(1 + wait)?;
            }
            if self.below(2) == 0 {
                self.start(&every);
            } else {
                for k in every.into_iter().rev() {
                    self.start(&[k]);
                    let wait = self.below(10);
                    self.ticks(1 + wait)?;
                }
            }
            self.drive();
            // The user position that counts for a crossing is that at the end of the tick of
            // FollowStart.
            self.tick()?;
            let often = 10 + self.below(100);
            for _ in 0..100 + self.below(400) {
                if self.below(often) == 0 {
                    self.disturb();
                }
                self.tick()?;
            }
            let smooth = self.below(2) == 0;
            self.rest(smooth)?;
        }
        Ok(())
    }
}

#[test]
fn slaves_are_where_their_masters_put_them() {
    let number = |name: &str, other| std::env::var(name).map_or(other, |n| n.parse().unwrap());
    let (first, count): (u64, u64) = (number("FOLLOW_SEED", 1), number("FOLLOW_PROGRAMS", 400));
    let keep_on = std::env::var("FOLLOW_COUNT").is_ok();
    let (mut compared, mut exact, mut wrong) = (0, 0, 0);
    for seed in first..first + count {
        let mut program = Program::new(seed);
        if let Err(what) = program.run() {
            wrong += 1;
            if !keep_on {
                let log = program.log.join("\n");
                panic!("program {seed} ({} of them): {what} at tick {}\n{log}", seed - first + 1, program.view.tick);
            }
            println!("program {seed}: {what}");
        }
        (compared, exact) = (compared + program.compared, exact + program.exact);
    }
    println!("{count} programs, {compared} places, {exact} turns of slaves, {wrong} wrong");
    assert_eq!(wrong, 0);
    assert!(compared > 500 * count);
}
