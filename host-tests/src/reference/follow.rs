//! A slave: a function of its master's position. Time means nothing here: a master's way in a tick is a row of legs, on
//! each of which it goes in one direction, and so is the slave's.
use super::curve::Curve;
use super::number::{Fix, Rational, exact};
use num_traits::{Signed, Zero};

/// A segment as FollowData gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Datum {
    pub master: f64,
    pub slave: f64,
    pub kind: i16,
    pub percent: i16,
}

/// A FIFO's function of progress.
#[derive(Debug, Clone)]
pub struct Table {
    pub curve: Curve,
    /// Progress is the master's position with its sign changed.
    pub down: bool,
    pub end_ratio: Rational,
}

impl Table {
    /// After a FIFO that ended at the ratio `carried`, per progress of this one.
    pub fn new(data: &[Datum], carried: &Rational) -> Table {
        let mut curve = Curve::default();
        let (mut from, mut begin, mut ratio) = (Rational::zero(), Rational::zero(), Rational::zero());
        for (index, datum) in data.iter().enumerate() {
            let (master, slave) = (exact(datum.master).abs(), exact(datum.slave));
            let (length, way) = (&master - &from, &slave - &begin);
            let mean = &way / &length;
            let twice = &mean + &mean;
            if datum.kind == 3 && index == 0 {
                ratio = carried.clone();
            }
            let (first, last) = match datum.kind {
                1 => (mean.clone(), mean),
                2 => (twice, Rational::zero()),
                _ => (ratio.clone(), twice - ratio),
            };
            shaped(&mut curve, &length, &first, &last, &Rational::from_integer(datum.percent.into()));
            curve.ends_at(Fix::of(&slave));
            (from, begin, ratio) = (master, slave, last);
        }
        Table { curve, down: data[0].master < 0.0, end_ratio: ratio }
    }
}

/// From one slope to another over a length: the slope's change ramps for percent/200 of it, holds, and ramps down.
pub fn shaped(curve: &mut Curve, length: &Rational, first: &Rational, last: &Rational, percent: &Rational) {
    let whole = |x: i64| Rational::from_integer(x.into());
    let change = last - first;
    if percent.is_zero() || change.is_zero() {
        curve.cubic(length, first, &(change / length), &Rational::zero());
        return;
    }
    let share = percent / whole(200);
    let ramp = length * &share;
    let top = &change / (length * (whole(1) - &share));
    let jerk = &top / &ramp;
    curve.cubic(&ramp, first, &Rational::zero(), &jerk);
    let begin = first + &top * &ramp / whole(2);
    let flat = length - &ramp * whole(2);
    if flat.is_positive() {
        curve.cubic(&flat, &begin, &top, &Rational::zero());
    }
    curve.cubic(&ramp, &(begin + &top * &flat), &top, &-jerk);
}

/// What begins it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begin {
    Start,
    /// Upwards or downwards, and the name of the position.
    Pass {
        up: bool,
        name: i64,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// FollowStart acts at the end of the tick.
    Starts(Begin),
    Waits {
        up: bool,
        place: Fix,
    },
    Runs,
}

/// A slave that has been started.
#[derive(Debug, Clone)]
pub struct Slave {
    pub table: Table,
    pub fifo: usize,
    pub dir: i16,
    pub switching: bool,
    state: State,
    pub pass: i64,
    /// Progress and slave where the pass began.
    began: Fix,
    origin: Fix,
    far: Fix,
    /// The way back ends at the begin of this pass.
    pub floor: i64,
    carried: Rational,
    /// What it is now: progress in the pass, and whether the master's motion moves it.
    place: Fix,
    /// FIFOs that a switch has emptied and nobody has seen to yet.
    pub emptied: Vec<usize>,
    /// Ends of passes lie within rounding of the master's position.
    pub open: bool,
}

/// What a slave needs to know of its master in a tick.
pub struct Lead<'a> {
    /// Positions of the machine, from the tick before to this one.
    pub track: &'a [Fix],
    pub velocity: Fix,
    /// Where the position named 0 is.
    pub zero: Fix,
}

impl Slave {
    pub fn new(data: &[Datum], fifo: usize, dir: i16, begin: Begin, origin: Fix) -> Slave {
        let table = Table::new(data, &Rational::zero());
        Slave {
            table,
            fifo,
            dir,
            switching: false,
            state: State::Starts(begin),
            pass: 0,
            began: Fix::ZERO,
            origin,
            far: Fix::ZERO,
            floor: 0,
            carried: Rational::zero(),
            place: Fix::ZERO,
            emptied: Vec::new(),
            open: false,
        }
    }

    fn sign(&self) -> i32 {
        if if self.dir == 0 { self.table.down } else { self.dir < 0 } { -1 } else { 1 }
    }

    fn along(&self, x: Fix) -> Fix {
        if self.sign() < 0 { -x } else { x }
    }

    /// Data was added to the FIFO that runs.
    pub fn grow(&mut self, data: &[Datum]) {
        self.table = Table::new(data, &self.carried);
        self.floor = self.pass;
    }

    fn start(&mut self, at: Fix) {
        self.state = State::Runs;
        self.began = self.along(at);
        self.far = self.began;
        self.place = Fix::ZERO;
    }

    /// Where it goes in a tick. `other` is the other FIFO's data, `loops` 0: for ever. Answers whether it has ended.
    pub fn step(&mut self, lead: &Lead, other: &[Datum], loops: i64, out: &mut Vec<Fix>) -> bool {
        let (Some(first), Some(last)) = (lead.track.first(), lead.track.last()) else { return false };
        if let State::Starts(begin) = self.state {
            match begin {
                Begin::Start => self.start(*last),
                Begin::Pass { up, name } => self.state = State::Waits { up, place: Fix::whole(name) + lead.zero },
            }
            return false;
        }
        let mut from = *first;
        for &to in &lead.track[1..] {
            if self.leg(from, to, other, loops, out) {
                return true;
            }
            from = to;
        }
        false
    }

    fn leg(&mut self, from: Fix, to: Fix, other: &[Datum], loops: i64, out: &mut Vec<Fix>) -> bool {
        let mut from = from;
        if let State::Waits { up, place } = self.state {
            let crosses = if up { from < place && to >= place } else { from > place && to <= place };
            self.open |= near(to - place) || near(from - place);
            if !crosses {
                return false;
            }
            self.start(place);
            from = place;
        }
        if self.state != State::Runs {
            return false;
        }
        loop {
            let (a, b) = (self.along(from), self.along(to));
            if self.dir != 0 && b <= self.far {
                return false;
            }
            let a = if self.dir == 0 { a } else { self.far };
            if b < a {
                return self.back(a, b, out);
            }
            let end = self.began + self.table.curve.length();
            self.open |= near(b - end);
            if b < end {
                self.go(a, b, out);
                return false;
            }
            self.go(a, end, out);
            from = self.along(end);
            self.origin += self.table.curve.end();
            self.pass += 1;
            self.began = end;
            self.place = Fix::ZERO;
            if self.switching && !other.is_empty() && self.emptied.is_empty() {
                self.switch(other, end);
            } else if loops > 0 && self.pass >= loops {
                return true;
            }
        }
    }

    /// The other FIFO takes over where the pass ended.
    fn switch(&mut self, other: &[Datum], end: Fix) {
        self.emptied.push(self.fifo);
        self.fifo ^= 1;
        (self.pass, self.floor, self.switching) = (0, 0, false);
        let machine = self.along(end);
        let before = self.sign();
        let carried = self.table.end_ratio.clone();
        let turned = self.dir == 0 && (other[0].master < 0.0) != self.table.down;
        self.carried = if turned { -carried } else { carried };
        self.table = Table::new(other, &self.carried);
        self.began = self.along(machine);
        if self.sign() != before {
            self.far = self.began;
        }
    }

    fn back(&mut self, a: Fix, b: Fix, out: &mut Vec<Fix>) -> bool {
        let mut a = a;
        while b < self.began && self.pass > self.floor {
            self.go(a, self.began, out);
            a = self.began;
            self.pass -= 1;
            self.began -= self.table.curve.length();
            self.origin -= self.table.curve.end();
        }
        self.go(a, b, out);
        false
    }

    fn go(&mut self, a: Fix, b: Fix, out: &mut Vec<Fix>) {
        let first = out.len();
        self.table.curve.between(a - self.began, b - self.began, out);
        self.place = b - self.began;
        out.push(self.table.curve.at(self.place));
        for point in &mut out[first..] {
            *point += self.origin;
        }
        self.far = self.far.max(b);
    }

    /// Its velocity from this instant on.
    pub fn velocity(&self, lead: &Lead) -> Fix {
        let Some(&at) = lead.track.last() else { return Fix::ZERO };
        let along = self.along(lead.velocity);
        if self.state != State::Runs || self.dir != 0 && (along <= Fix::ZERO || self.along(at) < self.far) {
            return Fix::ZERO;
        }
        let slope = self.table.curve.slope(self.place, along > Fix::ZERO);
        if self.place == Fix::ZERO && along < Fix::ZERO && self.pass == self.floor {
            return Fix::ZERO;
        }
        slope * along
    }

    /// A knot or an end of a pass so near that its velocity may be that of either side.
    pub fn is_near_knot(&self, lead: &Lead) -> bool {
        let along = self.along(lead.velocity);
        let moves = if self.dir == 0 { along != Fix::ZERO } else { along > Fix::ZERO };
        let slope = |u: Fix| self.table.curve.slope(u, true);
        let jump = (slope(self.place + NEAR) - slope(self.place - NEAR)).abs();
        moves && self.state == State::Runs && self.place != Fix::ZERO && jump > Fix(1 << 44)
    }
}

/// What rounding of a master's fixed-point position may decide: 2⁻¹⁴ pulse.
pub const NEAR: Fix = Fix(1 << 50);

fn near(apart: Fix) -> bool {
    apart != Fix::ZERO && apart.abs() < NEAR
}
