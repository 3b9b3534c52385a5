//! A slave that has been started: a function of its master's position, with entries between its
//! segments.
//!
//! A master's way in a tick is a row of legs, on each of which it goes in one direction, and so
//! does the slave. Time means something for FollowDelayEx and for the limit of FollowDiBitEx only.
mod velocity;

use super::follow::{Item, Table, is_down};
use super::number::Fix;
use super::rational::Rational;
pub use velocity::NEAR;
use velocity::near;

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
        position: Fix,
    },
    Runs,
    /// Until an instant, ms.
    Delays {
        until: Fix,
    },
    /// For an input, at most until an instant.
    Listens {
        index: i16,
        level: bool,
        until: Option<Fix>,
    },
}

/// How a tick ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    On,
    Ended,
    TimedOut,
}

/// A slave that has been started.
#[derive(Debug, Clone)]
pub struct Slave {
    items: Vec<Item>,
    pub table: Table,
    pub fifo: usize,
    pub dir: i16,
    down: bool,
    pub switching: bool,
    /// SwitchNow, until the end of the tick.
    pub now: Option<bool>,
    state: State,
    pub pass: i64,
    /// Items before this one are done with in the present pass, where they are no segments.
    next: usize,
    /// Progress and slave where the pass began.
    began: Fix,
    origin: Fix,
    far: Fix,
    /// The way back ends at this item of this pass.
    floor: (i64, usize),
    /// The ratio with which a FIFO that begins with CONTINUE goes on.
    carried: Rational,
    /// The first segment from an item of this pass on begins with a ratio.
    given: Option<(i64, (usize, Rational))>,
    /// An entry holds it, or was the last to hold it and nothing has moved it since.
    held: bool,
    /// When what held it was over, in this tick.
    since: Option<Fix>,
    /// What it is now: progress in the pass.
    position: Fix,
    /// FIFOs that a switch has emptied and nobody has seen to yet.
    pub emptied: Vec<usize>,
    /// General outputs that entries have set in this tick.
    pub outputs: Vec<(i16, bool)>,
    /// What rounding decides in this tick.
    pub open: Option<&'static str>,
    /// What the contract leaves open, or what rounding decides for all that follows.
    pub unsaid: Option<&'static str>,
    /// What instants of entries may add to the bound.
    pub slack: Fix,
    /// Entries done.
    pub done: u64,
    /// An instant within its master's motion has counted in this tick.
    pub timed: bool,
}

/// What a slave needs to know of its master in a tick.
pub struct Lead<'a> {
    /// Positions of the machine, from the tick before to this one.
    pub track: &'a [Fix],
    /// When it was there, ms; `Fix::FAR` where nobody knows.
    pub times: &'a [Fix],
    /// Where it was at an instant.
    pub at: &'a dyn Fn(Fix) -> Option<Fix>,
    pub velocity: Fix,
    /// Where the position named 0 is.
    pub zero: Fix,
}

/// What a slave needs to know besides.
pub struct Around<'a> {
    /// The other FIFO.
    pub other: &'a [Item],
    /// 0: for ever.
    pub loops: i64,
    /// General inputs as they were sampled, bit 0 is the first.
    pub inputs: u32,
}

/// A part of the master's way in one direction.
#[derive(Debug, Clone, Copy)]
struct Leg {
    from: Fix,
    to: Fix,
    /// ms.
    begin: Fix,
    end: Fix,
}

/// More entries than this in a tick, and it stands until the next.
const TICK_ACTIONS: u64 = 8;

impl Slave {
    pub fn new(items: &[Item], fifo: usize, dir: i16, begin: Begin, origin: Fix) -> Slave {
        let table = Table::new(items, &Rational::zero(), None);
        Slave {
            items: items.to_vec(),
            table,
            fifo,
            dir,
            down: is_down(items),
            switching: false,
            now: None,
            state: State::Starts(begin),
            pass: 0,
            next: 0,
            began: Fix::ZERO,
            origin,
            far: Fix::ZERO,
            floor: (0, 0),
            carried: Rational::zero(),
            given: None,
            held: false,
            since: None,
            position: Fix::ZERO,
            emptied: Vec::new(),
            outputs: Vec::new(),
            open: None,
            unsaid: None,
            slack: Fix::ZERO,
            done: 0,
            timed: false,
        }
    }

    fn sign(&self) -> i32 {
        if if self.dir == 0 { self.down } else { self.dir < 0 } { -1 } else { 1 }
    }

    fn along(&self, x: Fix) -> Fix {
        if self.sign() < 0 { -x } else { x }
    }

    /// The function of the present pass.
    fn renew(&mut self) {
        let given = self.given.as_ref().filter(|(pass, _)| *pass == self.pass);
        self.table = Table::new(&self.items, &self.carried, given.map(|(_, given)| given));
    }

    /// Data was added to the FIFO that runs.
    pub fn grow(&mut self, items: &[Item]) {
        self.items = items.to_vec();
        self.renew();
        if self.floor.0 != self.pass {
            self.floor = (self.pass, 0);
        }
    }

    /// Where the way back ends in the present pass.
    fn lowest(&self) -> Fix {
        if self.floor.0 == self.pass { self.table.knots[self.floor.1].0 } else { Fix::ZERO }
    }

    fn start(&mut self, at: Fix) {
        self.state = State::Runs;
        self.began = self.along(at);
        self.far = self.began;
        self.position = Fix::ZERO;
    }

    /// What held it is over with the master here: the next item begins.
    fn resume(&mut self, at: Fix, since: Option<Fix>) {
        (self.state, self.since) = (State::Runs, since);
        self.position = self.table.knots[self.next].0;
        self.began = self.along(at) - self.position;
        self.far = self.along(at);
    }

    /// Where it goes in a tick.
    pub fn step(&mut self, lead: &Lead, around: &Around, out: &mut Vec<Fix>) -> Outcome {
        let (Some(&first), Some(&last)) = (lead.track.first(), lead.track.last()) else { return Outcome::On };
        (self.done, self.slack, self.timed, self.since) = (0, Fix::ZERO, false, None);
        if let State::Listens { index, level, until } = self.state {
            let left = until.map(|until| until - lead.times[lead.times.len() - 1]);
            if (around.inputs >> (index - 1) & 1 == 1) == level {
                self.resume(first, Some(lead.times[0]));
            } else if let Some(left) = left {
                if left != Fix::ZERO && left.abs() < Fix(1 << 44) {
                    self.open = Some("a wait that times out with a tick");
                }
                if left <= Fix::ZERO {
                    return Outcome::TimedOut;
                }
            }
        }
        for index in 1..lead.track.len() {
            let leg = Leg {
                from: lead.track[index - 1],
                to: lead.track[index],
                begin: lead.times[index - 1],
                end: lead.times[index],
            };
            let outcome = self.leg(&leg, lead, around, out);
            if outcome != Outcome::On {
                return outcome;
            }
        }
        let now = lead.times[lead.times.len() - 1];
        let still = Leg { from: last, to: last, begin: now, end: now };
        if let State::Starts(begin) = self.state {
            match begin {
                Begin::Start => {
                    self.start(last);
                    return self.leg(&still, lead, around, out);
                }
                Begin::Pass { up, name } => self.state = State::Waits { up, position: Fix::whole(name) + lead.zero },
            }
        }
        if let Some(table) = self.now.take()
            && self.switch_now(table, last, around, out)
        {
            return self.leg(&still, lead, around, out);
        }
        Outcome::On
    }

    fn leg(&mut self, leg: &Leg, lead: &Lead, around: &Around, out: &mut Vec<Fix>) -> Outcome {
        let Leg { mut from, to, .. } = *leg;
        match self.state {
            State::Waits { up, position } => {
                let crosses = if up { from < position && to >= position } else { from > position && to <= position };
                if near(to - position) || near(from - position) {
                    self.open = Some("the end of a pass");
                }
                if !crosses {
                    return Outcome::On;
                }
                self.start(position);
                from = position;
            }
            State::Delays { until } => match self.released(leg, until, lead) {
                Some(at) => from = at,
                None => return Outcome::On,
            },
            State::Starts(_) | State::Listens { .. } => return Outcome::On,
            State::Runs => {}
        }
        loop {
            let (a, b) = (self.along(from), self.along(to));
            let entry = (self.next..self.items.len()).find(|index| self.items[*index].segment().is_none());
            let stop = entry.map_or(self.table.curve.length(), |entry| self.table.knots[entry].0);
            // What comes next begins here, though the master stands.
            let at_entry = self.position == stop;
            if self.dir != 0 && b <= self.far && !at_entry {
                return Outcome::On;
            }
            let (a, b) = if self.dir == 0 { (a, b) } else { (self.far, b.max(self.far)) };
            if b < a && !at_entry {
                self.back(a, b, out);
                return Outcome::On;
            }
            let end = self.began + stop;
            if near(b - end) {
                self.open = Some("the end of a pass");
                let counts = |entry: usize| match self.items[entry] {
                    Item::Delay { .. } => b != end,
                    Item::Output { .. } => true,
                    _ => false,
                };
                if self.now.is_some() || entry.is_some_and(counts) {
                    self.doubt("an entry that a master reaches within rounding of a tick");
                }
            }
            if b < end {
                self.go(a, b, out);
                return Outcome::On;
            }
            if a < end {
                self.go(a, end, out);
            }
            from = self.along(end);
            let outcome = match entry {
                Some(entry) => self.act(entry, &mut from, leg, lead, around),
                None => self.end_pass(end, around),
            };
            if let Some(outcome) = outcome {
                return outcome;
            }
        }
    }

    fn doubt(&mut self, why: &'static str) {
        self.unsaid = Some(why);
    }

    /// Carries out the item `index`, with the master at `from`. None: it goes on.
    fn act(&mut self, index: usize, from: &mut Fix, leg: &Leg, lead: &Lead, around: &Around) -> Option<Outcome> {
        self.next = index + 1;
        self.position = self.table.knots[self.next].0;
        self.floor = (self.pass, self.next);
        self.done += 1;
        if self.done > TICK_ACTIONS {
            self.doubt("more entries than a tick carries out");
        }
        match self.items[index] {
            Item::Segment(_) | Item::Asymmetric(_) | Item::Switch { table: false } | Item::Delay { cycles: 0 } => None,
            Item::Output { index, level } => {
                self.outputs.push((index, level));
                None
            }
            Item::Delay { cycles } => {
                let until = self.when(*from, leg, lead) + Fix::ms(i64::from(cycles) * 250_000);
                (self.state, self.held) = (State::Delays { until }, true);
                match self.released(leg, until, lead) {
                    Some(at) => {
                        *from = at;
                        None
                    }
                    None => Some(Outcome::On),
                }
            }
            Item::Wait { index, level, ms } => {
                if (around.inputs >> (index - 1) & 1 == 1) == level {
                    return None;
                }
                let until = (ms != 0).then(|| self.when(*from, leg, lead) + Fix::whole(ms.into()));
                (self.state, self.held) = (State::Listens { index, level, until }, true);
                Some(Outcome::On)
            }
            Item::Switch { table: true } => {
                if !around.other.is_empty() && self.emptied.is_empty() {
                    let ratio =
                        if self.held { Rational::zero() } else { self.table.ratio_before(index, &self.carried) };
                    self.origin += self.table.knots[index].1;
                    self.switch(around.other, self.began + self.table.knots[index].0, ratio, true);
                }
                None
            }
        }
    }

    /// When the master was here on a leg, ms.
    fn when(&mut self, at: Fix, leg: &Leg, lead: &Lead) -> Fix {
        if let Some(since) = self.since.filter(|_| self.held) {
            return since;
        }
        if leg.begin != Fix::FAR && at == leg.from {
            return leg.begin;
        }
        if leg.end != Fix::FAR && (leg.begin == leg.end || at == leg.to) {
            return leg.end;
        }
        self.timed = true;
        if leg.begin == Fix::FAR || leg.end == Fix::FAR {
            self.doubt("an instant on the way of a slave");
            return leg.end;
        }
        let (mut low, mut high) = (leg.begin, leg.end);
        let up = leg.to > leg.from;
        while high - low > Fix(4) {
            let middle = low + (high - low).half();
            let Some(x) = (lead.at)(middle) else {
                self.doubt("an instant on the way of a slave");
                return leg.end;
            };
            if if up { x < at } else { x > at } { low = middle } else { high = middle }
        }
        // The instant is as good as the position, by the speed there.
        let apart = Fix(1 << 50);
        let around = [low - apart, low + apart].map(lead.at);
        let speed = match around {
            [Some(before), Some(after)] => (after - before).abs().over(apart + apart),
            _ => Fix::ZERO,
        };
        if speed < Fix(1 << 60) {
            self.doubt("an entry reached slowly");
        }
        low
    }

    /// Where the master is when a delay ends, if that is on this leg.
    fn released(&mut self, leg: &Leg, until: Fix, lead: &Lead) -> Option<Fix> {
        let apart = leg.end - until;
        if apart.abs() < Fix(1 << 44) && apart.abs() > Fix(1 << 10) {
            self.doubt("a delay that ends with a tick");
        }
        if until > leg.end || until > lead.times[lead.times.len() - 1] {
            return None;
        }
        self.timed = true;
        let at = if until == leg.end { Some(leg.to) } else { (lead.at)(until) };
        let Some(at) = at else {
            self.doubt("an instant on the way of a slave");
            return None;
        };
        self.resume(at, Some(until));
        // 2⁻³⁴ ms of the master's way: delays add up to no more.
        self.slack += Fix(1 << 30) * self.table.curve.steepest * lead.velocity.abs();
        Some(at)
    }

    fn end_pass(&mut self, end: Fix, around: &Around) -> Option<Outcome> {
        self.origin += self.table.curve.end();
        if self.switching && !around.other.is_empty() && self.emptied.is_empty() {
            let now = self.given.take().filter(|(pass, _)| *pass == self.pass + 1);
            let ratio = match &now {
                Some((_, (_, ratio))) => ratio.clone(),
                None => self.table.ratio_before(self.items.len(), &self.carried),
            };
            self.switch(around.other, end, ratio, now.is_some());
            return None;
        }
        self.pass += 1;
        self.began = end;
        (self.position, self.next) = (Fix::ZERO, 0);
        if self.table.curve.length() == Fix::ZERO {
            self.doubt("a pass without segments");
        }
        if around.loops > 0 && self.pass >= around.loops {
            return Some(Outcome::Ended);
        }
        if self.table.curve.length() == Fix::ZERO {
            return Some(Outcome::On);
        }
        if self.given.is_some() {
            self.renew();
        }
        None
    }

    /// The other FIFO takes over with the progress at `end`, where this one had a ratio.
    fn switch(&mut self, other: &[Item], end: Fix, ratio: Rational, at_once: bool) {
        self.emptied.push(self.fifo);
        self.fifo ^= 1;
        (self.pass, self.next, self.floor, self.switching) = (0, 0, (0, 0), false);
        let machine = self.along(end);
        let before = self.sign();
        self.items = other.to_vec();
        self.down = is_down(other);
        let turned = self.sign() != before;
        self.carried = if turned { -ratio } else { ratio };
        self.given = at_once.then(|| (0, (0, self.carried.clone())));
        self.renew();
        self.began = self.along(machine);
        self.position = Fix::ZERO;
        if turned {
            self.far = self.began;
        }
    }

    /// At the end of a tick; whether what follows begins there.
    fn switch_now(&mut self, table: bool, at: Fix, around: &Around, out: &mut Vec<Fix>) -> bool {
        // After a switch of this tick the other FIFO is the one that it has emptied.
        if table && (around.other.is_empty() || !self.emptied.is_empty()) {
            return false;
        }
        if matches!(self.state, State::Waits { .. } | State::Starts(_)) {
            if table {
                let state = self.state;
                self.switch(around.other, Fix::ZERO, Rational::zero(), true);
                self.state = state;
            }
            return false;
        }
        let mut was_held = self.state != State::Runs;
        let here = self.along(at) - self.began;
        if self.dir == 0 && self.pass == self.floor.0 && here < self.lowest() {
            // What it rests before is the next segment, also where it has come back through passes.
            self.next = self.floor.1;
            was_held = true;
        }
        if was_held {
            self.resume(at, None);
        } else {
            // What held it last was over before this instant.
            self.held = false;
        }
        let ratio = if was_held { Rational::zero() } else { self.table.curve.slope(self.position, true).rational() };
        if !was_held && self.position != Fix::ZERO {
            let slope = |u: Fix| self.table.curve.slope(u, true);
            let apart = |by: Fix| (slope(self.position + by) - slope(self.position - by)).abs();
            if self.table.curve.jump_near(self.position, NEAR) > Fix(1 << 48) {
                self.doubt("a SwitchNow where a slave's ratio jumps");
            } else {
                self.slack += apart(Fix(1 << 43)) * self.table.curve.length();
            }
        }
        let value = self.table.curve.at(self.position);
        let progress = if self.dir == 0 { self.along(at) } else { self.far };
        out.push(self.origin + value);
        if table {
            self.origin += value;
            self.switch(around.other, progress, ratio, true);
            return true;
        }
        if !was_held {
            // The item after the segment in force.
            let after = |index: &usize| self.table.knots[index + 1].0 > self.position;
            let in_force = (0..self.items.len()).find(|index| self.items[*index].segment().is_some() && after(index));
            self.next = in_force.map_or(self.items.len(), |index| index + 1);
        }
        let (knot, end) = self.table.knots[self.next];
        self.began = progress - knot;
        self.origin += value - end;
        self.position = knot;
        self.floor = (self.pass, self.next);
        self.given = Some(if self.next < self.items.len() {
            (self.pass, (self.next, ratio))
        } else {
            (self.pass + 1, (0, ratio))
        });
        self.renew();
        true
    }

    fn back(&mut self, a: Fix, b: Fix, out: &mut Vec<Fix>) {
        let mut a = a;
        while b < self.began && self.pass > self.floor.0 {
            self.go(a, self.began, out);
            a = self.began;
            self.pass -= 1;
            if self.given.is_some() {
                self.renew();
            }
            self.next = self.items.len();
            self.began -= self.table.curve.length();
            self.origin -= self.table.curve.end();
        }
        self.go(a, b, out);
    }

    /// Inside a pass, not before its lowest place.
    fn go(&mut self, a: Fix, b: Fix, out: &mut Vec<Fix>) {
        let first = out.len();
        let lowest = self.lowest();
        let (u, w) = ((a - self.began).max(lowest), (b - self.began).max(lowest));
        let mut points = Vec::new();
        self.table.curve.between(u, w, &mut points);
        out.extend(points.into_iter().map(|(_, value)| value));
        self.held &= u == w;
        self.position = w;
        out.push(self.table.curve.at(w));
        for point in &mut out[first..] {
            *point += self.origin;
        }
        self.far = self.far.max(b);
    }
}
