//! The position of a slave, from its tables and the positions of its master, by the rules of SPEC
//! 5: nothing here is the servo's.
//!
//! Positions are those of the machine in 2⁻⁴⁸ pulse, ratios exact fractions. Between two ticks a
//! master may have moved further than at either ([`MasterPath`]). If that is not known exactly, a
//! slave of one direction is in a range; if a pass may have ended or not, nothing is known any
//! more.
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use servo::units::Pos;

const ONE: i128 = 1 << 48;

/// A position.
pub fn fixed(pos: Pos) -> i128 {
    (pos.0 as i128) << (48 - Pos::FRAC_BITS)
}

pub fn pulses(x: i128) -> f64 {
    x as f64 / ONE as f64
}

/// End of a segment, of master and slave in eighths of a pulse from the start of the pass; type;
/// percent.
pub type Datum = (i64, i64, i16, i16);

fn eighths(x: i64) -> BigRational {
    BigRational::new(x.into(), 8.into())
}

fn cut(x: &BigRational) -> i128 {
    (x * BigRational::from_integer(BigInt::from(ONE))).round().to_integer().to_i128().unwrap()
}

struct Segment {
    from: i128,
    to: i128,
    begin: i128,
    path: i128,
    /// The displacement at the ratios at its begin and its end.
    first: i128,
    last: i128,
    percent: i128,
}

/// A FIFO as it runs.
pub struct Table {
    segments: Vec<Segment>,
    /// Progress is the master's position with its sign changed.
    pub down: bool,
    end_ratio: BigRational,
    /// No ratio is larger.
    pub steepest: f64,
}

impl Table {
    /// After a FIFO that ended at the ratio `carried`, per progress of this one.
    pub fn new(data: &[Datum], carried: &BigRational) -> Table {
        let down = data[0].0 < 0;
        let (mut from, mut begin, mut ratio) = (0i64, 0i64, BigRational::zero());
        let mut steepest = 0.0f64;
        let mut segments = Vec::new();
        for (index, &(master, slave, kind, percent)) in data.iter().enumerate() {
            let (master, path) = (master.abs(), slave - begin);
            let length = eighths(master - from);
            let mean = eighths(path) / &length;
            let twice = &mean + &mean;
            if kind == 3 && index == 0 {
                ratio = carried.clone();
            }
            let (first, last) = match kind {
                1 => (mean.clone(), mean),
                2 => (twice, BigRational::zero()),
                _ => (ratio.clone(), twice - ratio),
            };
            for ratio in [&first, &last] {
                steepest = steepest.max(ratio.abs().to_f64().unwrap());
            }
            let whole = |x: i64| i128::from(x) * (ONE / 8);
            segments.push(Segment {
                from: whole(from),
                to: whole(master),
                begin: whole(begin),
                path: whole(path),
                first: cut(&(&first * &length)),
                last: cut(&(&last * &length)),
                percent: percent.into(),
            });
            (from, begin, ratio) = (master, slave, last);
        }
        Table { segments, down, end_ratio: ratio, steepest }
    }

    fn length(&self) -> i128 {
        self.segments.last().unwrap().to
    }

    fn path(&self) -> i128 {
        self.segments.last().map(|last| last.begin + last.path).unwrap()
    }

    /// The slave at this progress.
    fn at(&self, x: i128) -> i128 {
        if x <= 0 {
            return 0;
        }
        let Some(segment) = self.segments.iter().find(|segment| x < segment.to) else { return self.path() };
        let Segment { from, to, begin, path, first, last, percent } = *segment;
        let t = (x - from) * ONE / (to - from);
        let mul = |a: i128, b: i128| a * b / ONE;
        let change = last - first;
        begin
            + if percent == 0 {
                mul(first, t) + mul(mul(change, t), t) / 2
            } else {
                // The ratio changes by a·t²/(2k) up to k, evenly up to 1 − k, and then as at the
                // begin.
                let k = percent * ONE / 200;
                let slope = change * ONE / (ONE - k);
                let cube = |t: i128| mul(mul(mul(slope, t), t), t) * ONE / k / 6;
                if t < k {
                    mul(first, t) + cube(t)
                } else if t < ONE - k {
                    let u = t - k / 2;
                    mul(first, t) + mul(mul(slope, u), u) / 2 + mul(mul(slope, k), k) / 24
                } else {
                    let u = ONE - t;
                    path - mul(last, u) + cube(u)
                }
            }
    }
}

/// What begins it.
pub enum Begin {
    Start,
    /// Upwards or downwards, and where among the master's positions.
    Pass(bool, i128),
}

/// The motion of a master from a tick to the next.
#[derive(Clone, Copy, Debug)]
pub struct MasterPath {
    pub from: i128,
    pub to: i128,
    /// Its highest position is between these, its lowest, too.
    pub high: (i128, i128),
    pub low: (i128, i128),
}

impl MasterPath {
    /// Beyond both ends by this much at most.
    pub fn within(from: i128, to: i128, beyond: i128) -> MasterPath {
        let (low, high) = (from.min(to), from.max(to));
        MasterPath { from, to, high: (high, high + beyond), low: (low - beyond, low) }
    }

    /// Its length in all, at most.
    pub fn length(&self) -> i128 {
        (self.from - self.to).abs()
            + 2 * (self.high.1 - self.high.0 + self.low.1 - self.low.0)
            + 2 * (self.high.0 - self.from.max(self.to) + self.from.min(self.to) - self.low.1)
    }

    /// Along progress that is the position or its opposite.
    fn along(&self, sign: i128) -> MasterPath {
        if sign > 0 {
            return *self;
        }
        let turned = |(a, b): (i128, i128)| (-b, -a);
        MasterPath { from: -self.from, to: -self.to, high: turned(self.low), low: turned(self.high) }
    }
}

/// What is known of a slave after a tick.
pub enum Known {
    /// It runs, between these positions.
    Runs(i128, i128),
    /// It has ended there.
    Ended(i128),
    /// Nothing any more.
    Nothing,
}

enum State {
    Starting(Begin),
    Waits(bool, i128),
    Runs,
    Ended(i128),
    Lost,
}

pub struct Slave {
    /// Data of both FIFOs, if any.
    data: [Option<Vec<Datum>>; 2],
    table: Table,
    fifo: usize,
    /// 1 and −1 follow the furthest position in that direction.
    dir: i128,
    pub passes: u32,
    pub switching: bool,
    state: State,
    pass: u32,
    /// Progress and slave at the begin of the pass.
    began: i128,
    origin: i128,
    /// The furthest progress, at least and at most.
    far: (i128, i128),
    pub switches: u32,
}

impl Slave {
    /// With the slave at `origin`; FIFO 0 runs.
    pub fn new(data: [Option<Vec<Datum>>; 2], dir: i128, passes: u32, begin: Begin, origin: i128) -> Slave {
        let table = Table::new(data[0].as_ref().unwrap(), &BigRational::zero());
        let state = State::Starting(begin);
        let (pass, began, far) = (0, 0, (0, 0));
        Slave { data, table, fifo: 0, dir, passes, switching: false, state, pass, began, origin, far, switches: 0 }
    }

    pub fn steepest(&self) -> f64 {
        self.table.steepest
    }

    /// Whether a switch has somewhere to go.
    pub fn may_switch(&self) -> bool {
        self.data[self.fifo ^ 1].is_some() && !matches!(self.state, State::Ended(_) | State::Lost)
    }

    fn sign(&self) -> i128 {
        if if self.dir == 0 { self.table.down } else { self.dir < 0 } { -1 } else { 1 }
    }

    fn start(&mut self, at: i128) {
        self.state = State::Runs;
        self.began = self.sign() * at;
        self.far = (self.began, self.began);
    }

    /// Its positions from a progress to another of the pass in force, at most and at least, to 2⁻²⁰
    /// pulse.
    fn extremes(&self, from: i128, to: i128, all: &mut Vec<i128>) {
        let knots = self.table.segments.iter().map(|segment| segment.to);
        let inside = knots.filter(|knot| (from.min(to)..from.max(to)).contains(knot));
        let steps = (0..=100).map(|k| from + (to - from) * k / 100);
        all.extend(inside.chain(steps).map(|x| self.origin + self.table.at(x)));
    }

    /// The master has moved like this. Returns the lowest and the highest position of the slave, if
    /// they are `wanted` and known.
    pub fn step(&mut self, path: &MasterPath, wanted: bool) -> (Known, Option<(i128, i128)>) {
        let was = (self.far, self.began, self.origin, self.switches, self.pass);
        let running = matches!(self.state, State::Runs);
        let known = self.go(path);
        let sign = self.sign();
        let exact = |path: MasterPath| path.high.0 == path.high.1 && path.low.0 == path.low.1;
        let straight = |path: MasterPath| {
            exact(path) && path.high.0 == path.from.max(path.to) && path.low.0 == path.from.min(path.to)
        };
        let path = path.along(sign);
        if !wanted || !running || !straight(path) || was.0.0 != was.0.1 || self.switches != was.3 {
            return (known, None);
        }
        let (from, to) = if self.dir == 0 { (path.from, path.to) } else { (was.0.0, self.far.0) };
        let mut all = Vec::new();
        let now = (self.began, self.origin);
        if self.pass == was.4 && !matches!(known, Known::Ended(_)) {
            self.extremes(from - self.began, to - self.began, &mut all);
        } else {
            // One end of a pass lies between.
            let knot = was.1.max(now.0);
            if was.4.abs_diff(self.pass) != 1 {
                return (known, None);
            }
            (self.began, self.origin) = (was.1, was.2);
            self.extremes(from - self.began, knot - self.began, &mut all);
            (self.began, self.origin) = now;
            if !matches!(known, Known::Ended(_)) {
                self.extremes(knot - self.began, to - self.began, &mut all);
            }
        }
        (known, all.iter().min().copied().zip(all.iter().max().copied()))
    }

    fn go(&mut self, path: &MasterPath) -> Known {
        let mut begun = None;
        match self.state {
            State::Ended(at) => return Known::Ended(at),
            State::Lost => return Known::Nothing,
            // It begins at the end of the tick of FollowStart.
            State::Starting(Begin::Start) => {
                self.start(path.to);
                return Known::Runs(self.origin, self.origin);
            }
            State::Starting(Begin::Pass(up, at)) => {
                self.state = State::Waits(up, at);
                return Known::Runs(self.origin, self.origin);
            }
            State::Waits(up, place) => {
                let sign = if up { 1 } else { -1 };
                let (path, at) = (path.along(sign), sign * place);
                if path.from < at && path.high.0 >= at {
                    self.start(place);
                    begun = Some(sign);
                } else if path.from < at && path.high.1 >= at || path.from >= at && path.to >= at && path.low.0 < at {
                    self.state = State::Lost;
                    return Known::Nothing;
                } else {
                    return Known::Runs(self.origin, self.origin);
                }
            }
            State::Runs => {}
        }
        let along = path.along(self.sign());
        let (mut least, mut most) = along.high;
        if begun.is_some_and(|sign| sign != self.sign()) {
            // It came from there; the motion before the crossing does not count.
            let further = most > along.from.max(along.to);
            least = self.began.max(along.to);
            most = if further { least.max(most) } else { least };
        }
        if self.dir != 0 {
            self.far = (self.far.0.max(least), self.far.1.max(most));
            (least, most) = self.far;
        } else {
            self.far = (0, 0);
        }
        let mut now = if self.dir == 0 { (along.to, along.to) } else { self.far };
        loop {
            let end = self.began + self.table.length();
            if least < end && most >= end {
                self.state = State::Lost;
                return Known::Nothing;
            }
            if least < end {
                break;
            }
            self.origin += self.table.path();
            if self.switching && self.data[self.fifo ^ 1].is_some() {
                self.data[self.fifo] = None;
                self.fifo ^= 1;
                (self.pass, self.switching, self.began) = (0, false, end);
                self.switches += 1;
                let carried = self.table.end_ratio.clone();
                let data = self.data[self.fifo].as_ref().unwrap();
                let turns = self.dir == 0 && (data[0].0 < 0) != self.table.down;
                self.table = Table::new(data, &if turns { -carried } else { carried });
                if turns {
                    // Progress has the other sign from here; the master came here before.
                    self.began = -end;
                    let along = path.along(self.sign());
                    (now, least) = ((along.to, along.to), along.to.max(-end));
                    most = least + (along.high.1 - along.high.0);
                }
                continue;
            }
            (self.pass, self.began) = (self.pass + 1, end);
            if self.passes != 0 && self.pass >= self.passes {
                self.state = State::Ended(self.origin);
                return Known::Ended(self.origin);
            }
        }
        while self.dir == 0 && now.0 < self.began && self.pass > 0 {
            self.began -= self.table.length();
            self.origin -= self.table.path();
            self.pass -= 1;
        }
        let (a, b) = (self.table.at(now.0 - self.began), self.table.at(now.1 - self.began));
        let spread = ((now.1 - now.0) as f64 * self.table.steepest) as i128;
        Known::Runs(self.origin + a.min(b) - spread, self.origin + a.max(b) + spread)
    }
}
