//! A coordinate system: the content of its FIFOs, and its motion along them.
//!
//! Speeds are those of SPEC 5 without look-ahead, by [`crate::path_model`]: doubles, with which a
//! position within these programs is exact to 2⁻³⁰ pulse. Instants are ms of the program.
mod fifo;
mod stop;
mod world;

use super::axis::Why;
use crate::path_model::speed::{Phase, Profile, limits, profile};
use crate::path_model::{Frame, Geometry, Rates};
pub use fifo::{Entry, Fifo, Gear, Move, Set};
use world::Nobody;
pub use world::World;

/// Entries that a FIFO holds.
pub const CAPACITY: usize = 1024;
/// Within this, ms, rounding decides which came first.
const SAME_INSTANT_MS: f64 = 1e-7;

/// How a coordinate system came to standstill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rest {
    Done,
    /// The same at speed.
    Underrun,
    Stopped,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Crd {
    pub set: Option<Set>,
    pub fifos: [Fifo; 2],
    /// Axes that cleared data may have moved, where the program does not know it.
    pub moved: u32,
    /// The FIFO in force.
    pub fifo: usize,
    pub runs: bool,
    /// A call that needs standstill was refused in this tick, and in the one before.
    pub contested: [bool; 2],
    pub brakes: bool,
    pub stop_dec: f64,
    pub rate: f64,
    pub position: [f64; 4],
    pub speed: f64,
    pub(super) now: f64,
    /// The plan of the motion in progress, from where and when, and whether something follows it.
    pub(super) plan: Option<(Profile, f64, bool)>,
    /// The axis that the path waits for, and until when.
    pub waits: Option<(usize, f64)>,
    /// Waits since the start: the end of each is known to 5 ns.
    pub waited: u32,
    /// How fast it was where a Stop found it.
    pub held: f64,
    /// It goes on after an abrupt Stop: up to 2⁻¹⁷ pulse more than SPEC 11 allows, an open finding.
    pub resumed: bool,
    /// An override has changed on the way: doubles know instants to a ns from there.
    pub rated: bool,
    /// What an abrupt Stop makes of the time to the end of its motion, ms.
    pub blur: f64,
    /// It met an axis that must not move.
    pub hindered: bool,
    /// General outputs that were set: when, which bits, their levels.
    pub outputs: Vec<(f64, u32, u32)>,
    /// The same of analog ones: channel from 0, value.
    pub analog: Vec<(f64, usize, i16)>,
    /// Entries of lasers that were reached: when, channel, what, whether it braked for a Stop.
    pub lasers: Vec<(f64, usize, super::light::Command, bool)>,
    /// How far it went in this tick along the path, pulses.
    pub gone: f64,
    /// It came to standstill in this tick: when, and whether it braked for a Stop.
    pub rested: Option<(f64, bool)>,
    /// Places passed in a tick where it may turn, and whether that is all of them.
    pub knots: Vec<(f64, [f64; 4])>,
    pub is_straight: bool,
    /// Rounding decides on which side of a tick something fell.
    pub open: bool,
    pub rest: Option<Rest>,
    /// Why it came to standstill last, where that is known, and why a Stop in progress stops it.
    pub why: Option<Why>,
    pub ending: Option<Why>,
    /// SetLaserFollowFilter, ms, and the speeds of the axes' encoders after it; whether a follow
    /// has asked for them since SetCrdPrm. Until then they are those of the tick.
    pub filter_ms: f64,
    pub counted: [f64; 4],
    pub counts: bool,
    /// When it was started.
    pub began: f64,
    /// It was started on the tick that is being prepared; data came for the end of its FIFO.
    pub started_here: bool,
    /// Data came after that at the same instant.
    pub fed_here: bool,
    pub late: bool,
    /// An interlock has stopped it, and it was started again: a program does not know from where.
    pub hidden: bool,
    /// No Stop has come since it was set up at standstill.
    pub certain: bool,
    /// A Stop has named it since its last start.
    pub stopped: bool,
    /// It was started since it was set up; a program has waited for it since.
    pub ran: bool,
    pub awaited: bool,
    /// The last start went on within the data of its FIFO.
    pub goes_on: bool,
    /// What was there at the tick before has come to its end.
    pub dry: bool,
    pub unsaid: Option<&'static str>,
}

impl Default for Crd {
    fn default() -> Crd {
        Crd {
            set: None,
            fifos: Default::default(),
            moved: 0,
            hidden: false,
            fifo: 0,
            runs: false,
            contested: [false; 2],
            brakes: false,
            stop_dec: 0.0,
            rate: 1.0,
            position: [0.0; 4],
            speed: 0.0,
            now: 0.0,
            plan: None,
            waits: None,
            waited: 0,
            held: 0.0,
            resumed: false,
            rated: false,
            blur: 0.0,
            hindered: false,
            outputs: Vec::new(),
            analog: Vec::new(),
            lasers: Vec::new(),
            gone: 0.0,
            rested: None,
            knots: Vec::new(),
            is_straight: true,
            open: false,
            rest: None,
            why: None,
            ending: None,
            filter_ms: 1.0,
            counted: [0.0; 4],
            counts: false,
            began: 0.0,
            started_here: false,
            fed_here: false,
            late: false,
            certain: false,
            stopped: false,
            ran: false,
            awaited: false,
            goes_on: false,
            dry: false,
            unsaid: None,
        }
    }
}

/// A smooth Stop in a motion: its deceleration, but never faster than the motion would have been,
/// which may brake harder to its speed at first, and to its end at last.
fn braked(speed: f64, left: f64, limits: &Rates, dec: f64) -> Profile {
    let whole = profile(speed, left, limits, 0.0);
    let [to_speed, _, to_end] = whole.phases;
    let none = Phase { acc: 0.0, ms: 0.0 };
    let first = if to_speed.acc < -dec { to_speed } else { none };
    let from = speed + first.acc * first.ms;
    let left = left - (speed + from) / 2.0 * first.ms;
    let square = from * from;
    if to_end.acc < -dec {
        let acc = -to_end.acc;
        // Pulses before the end at which both have one speed.
        let meet = ((square - whole.end * whole.end - 2.0 * dec * left) / (2.0 * (acc - dec))).min(left);
        let there = square - 2.0 * dec * (left - meet);
        if meet > 0.0 && there > 0.0 {
            let there = there.sqrt();
            let brakes = Phase { acc: -dec, ms: ((from - there) / dec).max(0.0) };
            let last = Phase { acc: -acc, ms: ((there - whole.end) / acc).max(0.0) };
            return Profile { phases: [first, brakes, last], end: whole.end };
        }
    }
    let end = (square - 2.0 * dec * left).max(0.0).sqrt();
    Profile { phases: [first, Phase { acc: -dec, ms: (from - end) / dec }, none], end }
}

impl Crd {
    /// The axes that its entries move.
    pub fn moves(&self) -> u32 {
        self.fifos.iter().fold(0, |mask, fifo| mask | fifo.moves())
    }

    /// Begin of the next data. A coordinate without a target stays where the path is.
    pub fn begin(&self, fifo: usize) -> Option<[f64; 4]> {
        let of = &self.fifos[fifo];
        let waiting = &of.entries[of.next.min(of.entries.len())..];
        let target = |coordinate: usize| {
            waiting.iter().rev().find_map(|entry| match entry {
                Entry::Motion(.., to, sets) if sets >> coordinate & 1 == 1 => Some(to[coordinate]),
                _ => None,
            })
        };
        let axes = self.set.as_ref().map_or([None; 4], |set| set.axes);
        let stays = |coordinate: usize| !self.runs || self.fifo == fifo || axes[coordinate].is_none();
        let mut begin = self.position;
        for (coordinate, at) in begin.iter_mut().enumerate() {
            *at = target(coordinate).or(stays(coordinate).then_some(*at))?;
        }
        Some(begin)
    }

    pub fn start(&mut self, fifo: usize, at: f64) {
        // Where a Stop has held it is known as well as the way to there.
        let waited = if self.rest == Some(Rest::Stopped) { self.waited } else { 0 };
        (self.runs, self.brakes, self.fifo, self.now, self.speed) = (true, false, fifo, at, 0.0);
        (self.plan, self.rest, self.started_here, self.stopped) = (None, None, true, false);
        (self.ran, self.awaited) = (true, false);
        (self.ending, self.began) = (None, at);
        self.counted = [0.0; 4];
        (self.waits, self.waited, self.hindered) = (None, waited, false);
        let other = &mut self.fifos[1 - fifo];
        self.hidden |= self.why == Some(Why::Interlock);
        other.lost |= self.why == Some(Why::Interlock) && other.begins().is_some();
        let of = &mut self.fifos[fifo];
        of.lost = false;
        self.goes_on = of.left.is_some();
        (of.left, of.seen) = (None, of.entries.len());
    }

    /// Whether data of FIFO 1 ends on the pulse nearest to where FIFO 0 was left, which is no whole
    /// one: docs/crd.md.
    pub fn comes_back(&self, fifo: usize) -> bool {
        let Some(left) = self.fifos[0].left.filter(|left| fifo == 1 && left.iter().any(|x| x.fract() != 0.0)) else {
            return false;
        };
        let of = &self.fifos[1];
        let begins_elsewhere = |line: &Geometry| line.at(0.0).iter().zip(left).any(|(a, b)| (a - b).abs() > 1e-6);
        of.entries[of.next..].iter().any(|entry| match entry {
            Entry::Motion(line, _, to, _) => *to == left.map(f64::round) && begins_elsewhere(line),
            _ => false,
        })
    }

    /// SetOverride, at the instant up to which it has run.
    pub fn change_rate(&mut self, rate: f64) {
        self.rate = rate;
        self.rated |= self.plan.is_some();
        self.plan_again();
    }

    /// What was planned holds no longer.
    pub fn plan_again(&mut self) {
        if let Some(set) = &self.set
            && set.frame.even_ms > 0.0
            && self.plan.is_some()
        {
            self.unsaid = Some("the least time at constant speed, planned again during motion");
        }
        self.plan = None;
    }

    /// Of each coordinate, pulse/ms, from now on; and of the axes that go along.
    pub fn velocities(&self) -> ([f64; 4], Vec<(usize, f64)>) {
        let of = &self.fifos[self.fifo];
        let Some(Entry::Motion(geometry, ..)) = of.entries.get(of.next).filter(|_| self.runs) else {
            return Default::default();
        };
        let geared = of.gears.iter().filter(|gear| gear.is_engaged());
        let share = self.speed / geometry.length();
        let geared = geared.map(|gear| (gear.axis, f64::from(gear.pulses) * share)).collect();
        (geometry.direction(of.done).map(|x| x * self.speed), geared)
    }

    /// How far it would go until an instant; None: it would come to rest, or reach entries that act
    /// on others.
    pub fn distance_to(&self, until: f64) -> Option<f64> {
        let mut ahead = self.clone();
        ahead.run(until, &mut Nobody);
        let acts = ahead.outputs.len() + ahead.analog.len() + ahead.lasers.len() != 0;
        let moves = ahead.fifos[self.fifo].next != self.fifos[self.fifo].next && ahead.fifos[self.fifo].moves() != 0;
        (ahead.runs && !acts && !moves).then_some(ahead.gone)
    }

    /// Whether an entry ends by an instant, or one that is no motion is in progress.
    pub fn changes_by(&self, until: f64) -> bool {
        let mut ahead = self.clone();
        ahead.run(until, &mut Nobody);
        let fifo = &self.fifos[self.fifo];
        let waits = matches!(fifo.entries.get(fifo.next), Some(Entry::Delay(_) | Entry::Move(_)));
        waits || ahead.fifos[self.fifo].next != fifo.next || ahead.runs != self.runs
    }

    fn come_to_standstill(&mut self, rest: Rest) {
        self.rested = Some((self.now, self.brakes));
        self.why = match rest {
            // Where its data ends while it brakes is an end, or a Stop.
            Rest::Done if self.brakes => None,
            Rest::Done => Some(Why::End),
            Rest::Underrun => Some(Why::Underrun),
            Rest::Stopped => self.ending.filter(|_| !self.hindered),
        };
        (self.runs, self.brakes, self.speed, self.plan) = (false, false, 0.0, None);
        self.rest = Some(rest);
        let waited = self.waits.take().is_some();
        let position = self.position;
        let of = &mut self.fifos[self.fifo];
        of.waited = waited;
        of.gears.iter_mut().for_each(|gear| gear.base = None);
        of.left = (of.waiting() > 0).then_some(position);
    }

    fn goes_on(&self) -> bool {
        let of = &self.fifos[self.fifo];
        let next = of.entries[of.next + 1..of.seen].iter().find(|entry| !entry.takes_no_time());
        matches!(next, Some(Entry::Motion(..)))
    }

    /// Up to an instant.
    pub fn run(&mut self, until: f64, world: &mut impl World) {
        self.knots.clear();
        (self.is_straight, self.open, self.gone) = (true, false, 0.0);
        let mut effects = 0;
        while self.runs && self.now < until {
            let of = &mut self.fifos[self.fifo];
            let entry = of.entries[..of.seen].get(of.next);
            // Where it should be at standstill.
            let at_speed = self.speed > 1e-3;
            let ends = matches!(entry, None | Some(Entry::Delay(_) | Entry::Move(Move { waits: true, .. })));
            if ends && !at_speed && self.speed > 1e-9 {
                self.unsaid = Some("a path that ends hardly at speed");
            }
            match entry {
                None if at_speed => self.come_to_standstill(Rest::Underrun),
                None => self.come_to_standstill(Rest::Done),
                Some(&Entry::Move(Move { waits: true, axis, .. })) if self.brakes => {
                    world.may_move(axis);
                    self.unsaid = Some("a Stop that comes to a move that the path waits for");
                    self.come_to_standstill(Rest::Stopped);
                }
                Some(Entry::Move(Move { waits: true, .. })) if at_speed => {
                    self.come_to_standstill(Rest::Underrun);
                }
                Some(Entry::Move(to)) => {
                    let to = *to;
                    effects += 4;
                    self.move_axis(&to, until, world);
                }
                Some(entry) if entry.takes_no_time() => {
                    let entry = entry.clone();
                    if of.next >= of.reported {
                        match entry {
                            Entry::Outputs(mask, value) => self.outputs.push((self.now, mask, value)),
                            Entry::Analog(channel, value) => self.analog.push((self.now, channel, value)),
                            Entry::Laser(channel, command) => {
                                self.lasers.push((self.now, channel, command, self.brakes));
                            }
                            _ => {}
                        }
                    }
                    if let Entry::Gear(axis, pulses) = entry {
                        of.gears.push(Gear { axis, pulses, base: None });
                    }
                    of.next += 1;
                    effects += 1;
                }
                // A Stop that came to it at speed.
                Some(Entry::Delay(_)) if self.brakes => {
                    // Whether a delay of 0 alone is left to do is nowhere said.
                    self.open |= of.takes_no_time(of.entries.len());
                    self.come_to_standstill(Rest::Stopped);
                }
                // What is before a wait was too short to brake in.
                Some(Entry::Delay(_)) if at_speed => self.come_to_standstill(Rest::Underrun),
                Some(Entry::Delay(ms)) => {
                    let left = ms - of.done;
                    self.open |= (left - (until - self.now)).abs() < SAME_INSTANT_MS;
                    self.speed = 0.0;
                    if left > until - self.now {
                        of.done += until - self.now;
                        self.now = until;
                    } else {
                        self.now += left;
                        (of.next, of.done) = (of.next + 1, 0.0);
                        self.mark(until);
                    }
                }
                Some(_) => self.motion(until, world),
            }
            if effects > 24 {
                self.unsaid = Some("more entries than a tick carries out");
            }
        }
        let of = &mut self.fifos[self.fifo];
        self.dry = of.takes_no_time(of.seen);
        of.seen = of.entries.len();
        if self.runs && self.now >= until {
            // What comes at the instant of a tick is reached there.
            let of = &self.fifos[self.fifo];
            self.open |= of.takes_no_time(of.entries.len());
        }
    }

    /// BufMove, and the wait for it.
    fn move_axis(&mut self, to: &Move, until: f64, world: &mut impl World) {
        let of = &mut self.fifos[self.fifo];
        let ends = match self.waits {
            Some((_, ends)) => ends,
            None if of.next < of.reported => {
                of.next += 1;
                return;
            }
            None => {
                let Some(ends) = world.travel(self.now, to) else {
                    // The path stops before it.
                    self.hindered = true;
                    return self.come_to_standstill(Rest::Stopped);
                };
                if !to.waits {
                    of.next += 1;
                    return;
                }
                (self.waits, self.speed) = (Some((to.axis, ends)), 0.0);
                self.waited += 1;
                ends
            }
        };
        self.open |= (ends - until).abs() < SAME_INSTANT_MS;
        if ends > until {
            self.now = until;
        } else {
            (self.now, self.waits) = (ends.max(self.now), None);
            of.next += 1;
            self.mark(until);
        }
    }

    /// Geared axes where a share of the motion is done.
    fn carry(&mut self, share: f64, ends: bool, world: &mut impl World) {
        let (now, of) = (self.now, &mut self.fifos[self.fifo]);
        for gear in &of.gears {
            if let Some(x) = gear.at(share) {
                world.carry(now, gear.axis, x, ends);
            }
        }
        if ends {
            of.gears.clear();
        }
    }

    /// Something fell on an instant.
    fn mark(&mut self, until: f64) {
        self.open |= (until - self.now).abs() < SAME_INSTANT_MS;
        self.knots.push((self.now, self.position));
    }

    fn motion(&mut self, until: f64, world: &mut impl World) {
        let follows = self.goes_on();
        let Some(set) = &self.set else { return };
        let of = &mut self.fifos[self.fifo];
        let Entry::Motion(geometry, rates, to, _) = of.entries[of.next].clone() else { return };
        for gear in of.gears.iter_mut().filter(|gear| gear.base.is_none()) {
            let gone = super::Fix::of_f64(f64::from(gear.pulses) * (of.done / geometry.length()));
            let ratio = f64::from(gear.pulses).abs() / geometry.length();
            gear.base = world.engage(gear.axis, ratio, self.waited).map(|x| x - gone);
            if gear.base.is_none() {
                self.unsaid = Some("a gear of an axis that must not move");
            }
        }
        self.is_straight &= matches!(geometry, Geometry::Line { .. });
        let left = (geometry.length() - of.done).max(0.0);
        let plan = match &self.plan {
            Some((profile, left_of, same)) if *same == follows => (*profile, *left_of, *same),
            _ => {
                let mut limits = limits(&set.frame, &rates, self.rate);
                if !follows {
                    limits.end = 0.0;
                }
                let even = set.frame.even_ms;
                let planned = if self.brakes {
                    braked(self.speed, left, &limits, self.stop_dec)
                } else {
                    profile(self.speed, left, &limits, even)
                };
                // docs/crd.md: within 2⁻¹⁶ pulse of a stop it is one.
                if limits.end == 0.0 && planned.end > 0.0 && planned.end.powi(2) < limits.acc * 0.0000306 {
                    self.unsaid = Some("a path that ends hardly at speed");
                }
                if self.plan.is_some() && even > 0.0 {
                    self.unsaid = Some("the least time at constant speed, planned again during motion");
                }
                (planned, 0.0, follows)
            }
        };
        let (profile, mut gone, _) = plan;
        let total: f64 = profile.phases.iter().map(|phase| phase.ms).sum();
        let step = (until - self.now).min(total - gone);
        // What is left of each phase.
        let mut left_of_step = step;
        let mut before = gone;
        for phase in profile.phases {
            let rest = (phase.ms - before).max(0.0);
            before = (before - phase.ms).max(0.0);
            let ms = rest.min(left_of_step);
            if ms > 0.0 {
                let travelled = self.speed * ms + phase.acc * ms * ms / 2.0;
                of.done += travelled;
                self.gone += travelled;
                self.speed += phase.acc * ms;
                left_of_step -= ms;
            }
        }
        gone += step;
        self.now += step;
        let length = geometry.length();
        self.open |= (total - gone).abs() < SAME_INSTANT_MS && (until - self.now).abs() < SAME_INSTANT_MS;
        if total - gone > 1e-12 {
            let done = of.done;
            self.position = geometry.at(done.clamp(0.0, length));
            self.plan = Some((profile, gone, follows));
            self.carry((done / length).clamp(0.0, 1.0), false, world);
            return;
        }
        self.plan = None;
        self.speed = profile.end;
        if self.brakes && length - of.done > 1e-9 * length {
            self.position = geometry.at(of.done.clamp(0.0, length));
            self.open |= (until - self.now).abs() < SAME_INSTANT_MS;
            if length - of.done < 1e-5 {
                self.unsaid = Some("a Stop that rests where a motion ends");
            }
            let done = of.done;
            self.carry(done / length, false, world);
            self.come_to_standstill(Rest::Stopped);
            return;
        }
        self.position = to;
        (of.next, of.done) = (of.next + 1, 0.0);
        self.carry(1.0, true, world);
        self.mark(until);
        if self.brakes && self.speed < 1e-5 {
            // It rests before what stands after the motion, or a little before its end.
            self.unsaid = Some("a Stop that rests where a motion ends");
            self.come_to_standstill(Rest::Stopped);
        }
    }
}
