//! The laser channels: SPEC 6 and 9.
//!
//! In: calls and entries of paths in the order of time, starts and standstills of coordinate
//! systems, faults, the speed of the paths. Out: the edges of the switch, the power at every tick,
//! what reads give.
mod call;
mod gate;
mod law;
mod owner;
mod tables;

pub use call::{Family, LightCall, LightOf};
pub use law::{Around, Distance, Law, Mode, Scaled, Standby};
pub use tables::{LightTable, Line, POINTS, Ratio, Ratios, TABLES};

use super::call::members;
use gate::{Fpk, Gate};
use law::{Follow, Rule};
use owner::{End, Order, Owner};

/// What an entry does to a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    Gate(bool),
    Power(f64),
    /// BufLaserFollowMode: whether the encoders' speed counts, and a start power.
    Source {
        encoder: bool,
        start: Option<f64>,
    },
    /// BufLaserFollowRatio: ratio, minimum, maximum.
    Ratio([f64; 3]),
    /// BufLaserPrfFollow: whole bounds.
    Follow(f64, [i32; 2]),
    /// BufLaserFollowTable: table from 1, minimum, maximum.
    Table(i16, [f64; 2]),
    FollowOff,
}

/// What a call sets, in the channel's own units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Setting {
    Power(f64),
    Mode(Mode, [f64; 2], bool),
    Connector(bool),
    Carrier,
    Width,
    /// Off and on delay, ms.
    Delays([f64; 2]),
    Fpk(Option<[f64; 3]>),
    Standby(Option<Standby>),
    PreVoltage(Option<f64>),
    Distance(Option<Distance>),
    Ratios(Scaled, Option<[f64; 2]>),
    /// A table of powers from 0, and where it lies.
    Table(usize, usize),
    Map(u8),
    ZeroOnTime,
    ClearFault,
}

/// What happens to the channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Act {
    /// An on or off command by a call.
    Gate(usize, bool),
    Set(usize, Setting),
    /// An entry that a coordinate system reaches; whether it brakes for a Stop there.
    Entry(usize, usize, Command, bool),
    /// A coordinate system comes to standstill by a Stop, within its FIFO.
    Stopped(usize, usize),
    /// Its entries have run out; whether it braked for a Stop.
    Done(usize, usize, bool),
    /// A Stop names these, and these run, bit 0 is crd 1.
    Stop(u8, u8),
    /// It starts with a FIFO, and goes on with what lies there.
    Starts(usize, usize, bool),
    /// Its FIFO is cleared.
    Cleared(usize, usize),
    /// A cause of SPEC 9 of one of its axes, or of the path itself, as GetLaserFault numbers it.
    Fault(usize, i16),
    /// One that lets it run on: a limit that it moves away from.
    Hit(usize, i16),
    /// One of the whole controller.
    Dark(i16),
    /// ClrSts of one of its axes.
    Clear(usize),
    /// Stop, bits 10 and 11.
    EndFollow(u8),
    /// SetLaserMode: the wide range.
    Resolution(bool),
    Abort,
    /// All that ran at the Abort has come to rest.
    AbortOver,
    /// Power-on state.
    Reset,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Channel {
    pub owner: Owner,
    pub law: Law,
    gate: Gate,
    /// Off and on delay, ms; whether they apply.
    delays: [f64; 2],
    delayed: bool,
    /// After an Abort: nothing is output until the next command.
    muted: bool,
}

impl Channel {
    fn power_on(family: Family) -> Channel {
        let law = Law::power_on(family);
        let owner = Owner::power_on(law.has_output());
        let delayed = family == Family::Gus;
        Channel { owner, law, gate: Gate::default(), delays: [0.0; 2], delayed, muted: false }
    }

    fn order(&mut self, at: f64, order: Order) {
        match order {
            Order::Nothing => {}
            Order::Gate(on) => {
                let delay = if self.delayed { self.delays[usize::from(on)] } else { 0.0 };
                self.gate.command(at + delay, on);
            }
            Order::Cut => self.gate.cut(at),
        }
    }

    /// Whether switch and standby are as they should be.
    fn hold(&mut self, at: f64) {
        let quiet = self.owner.fault != 0 || self.muted;
        self.gate.hold(at, self.law.mode == Mode::Open, quiet);
    }

    fn follows(&mut self, before: Option<Follow>) {
        if before.is_some() && self.law.follow.is_none() {
            self.owner.follows(None);
        }
    }

    fn set(&mut self, at: f64, setting: Setting) {
        let before = self.law.follow;
        match setting {
            Setting::Power(power) => self.law.take_direct(power),
            Setting::Mode(mode, bounds, delayed) => {
                if mode != self.law.mode {
                    let order = self.owner.withdraw();
                    self.order(at, order);
                    (self.law.mode, self.law.direct, self.law.follow) = (mode, 0.0, None);
                    self.owner.output = self.law.has_output();
                }
                (self.law.bounds, self.delayed) = (bounds, delayed);
            }
            Setting::Connector(there) => {
                if !there && self.law.mode != Mode::Analog {
                    let order = self.owner.withdraw();
                    self.order(at, order);
                }
                self.law.connector = there;
                self.owner.output = self.law.has_output();
            }
            Setting::Carrier => self.law.carrier = true,
            Setting::Width => self.law.width = true,
            Setting::Delays(delays) => self.delays = delays,
            Setting::Fpk(times) => {
                self.gate.suppress(at, times.map(|[time1, time2, off]| Fpk { time1, time2, off }));
            }
            Setting::Standby(standby) => self.law.standby = standby,
            Setting::PreVoltage(volts) => self.law.pre_voltage = volts,
            Setting::Distance(distance) => self.law.distance = distance,
            Setting::Ratios(ratio, bounds) => {
                if let Some(distance) = &mut self.law.distance {
                    distance.ratio = ratio;
                    distance.bounds = bounds.or(distance.bounds);
                }
            }
            Setting::Table(table, lies) => self.law.tables[table] = Some(lies),
            Setting::Map(map) => {
                self.owner.map = map;
                if self.law.follow.is_some_and(|follow| map >> follow.crd & 1 == 0) {
                    self.law.follow = None;
                }
            }
            Setting::ZeroOnTime => self.gate.zero(at),
            Setting::ClearFault => self.owner.clear_fault(at),
        }
        // Points of a table are no command of its light.
        self.muted &= matches!(setting, Setting::Table(..));
        self.follows(before);
    }

    /// An entry of a path that the map holds.
    fn entry(&mut self, at: f64, crd: usize, command: Command, brakes: bool) {
        let before = self.law.follow;
        let mut taken = true;
        match command {
            Command::Gate(on) => {
                let order = self.owner.entry(crd, on, brakes);
                taken = order.is_some();
                self.order(at, order.unwrap_or(Order::Nothing));
            }
            Command::Power(power) => self.law.take_direct(power),
            Command::Source { encoder, start } => {
                self.law.encoder = encoder;
                self.law.direct = start.unwrap_or(self.law.direct);
            }
            Command::Ratio([ratio, min, max]) => self.begin(crd, Rule::Ratio(ratio), [min, max]),
            Command::Follow(ratio, bounds) => {
                self.law.encoder = false;
                self.begin(crd, Rule::Ratio(ratio), bounds.map(f64::from));
            }
            Command::Table(table, bounds) => {
                if let Some(table) = self.law.tables[table as usize - 1] {
                    self.begin(crd, Rule::Table(table), bounds);
                }
            }
            Command::FollowOff => self.law.follow = None,
        }
        self.muted &= !taken || self.owner.is_dead(crd);
        self.follows(before);
    }

    fn begin(&mut self, crd: usize, rule: Rule, bounds: [f64; 2]) {
        // LSR takes bounds in the mode's range.
        let most = self.law.most();
        let bounds = if self.law.family == Family::Lsr { bounds.map(|x| x.clamp(0.0, most)) } else { bounds };
        self.law.follow = Some(Follow { crd, rule, bounds });
        self.owner.follows(Some(crd));
    }

    /// One thing that happens to channel `number`.
    pub fn take(&mut self, number: usize, at: f64, act: &Act) {
        let order = match *act {
            Act::Gate(channel, on) if channel == number => {
                let order = self.owner.call(on);
                // One that is ignored leaves standby and pre-voltage as they were.
                self.muted &= order.is_none();
                order.unwrap_or(Order::Nothing)
            }
            Act::Set(channel, setting) if channel == number => {
                self.set(at, setting);
                Order::Nothing
            }
            Act::Entry(crd, channel, command, brakes) if channel == number && self.owner.maps(crd) => {
                self.entry(at, crd, command, brakes);
                Order::Nothing
            }
            Act::Gate(..) | Act::Set(..) | Act::Entry(..) => return,
            Act::Stopped(crd, fifo) => self.owner.rest((crd, fifo), End::Stopped),
            Act::Done(crd, fifo, braked) => self.owner.rest((crd, fifo), End::Done { braked }),
            Act::Stop(named, running) => self.owner.stop(named, running),
            Act::Starts(crd, fifo, goes_on) => self.owner.start((crd, fifo), goes_on),
            Act::Cleared(crd, fifo) => {
                self.owner.empty((crd, fifo));
                Order::Nothing
            }
            Act::Fault(crd, cause) => self.owner.fail(crd, cause, at),
            Act::Hit(crd, cause) => self.owner.hit(crd, cause, at),
            Act::Dark(cause) => self.owner.darken(cause, at),
            Act::Clear(crd) => {
                if self.owner.maps(crd) {
                    self.owner.clear_fault(at);
                }
                Order::Nothing
            }
            Act::EndFollow(crds) => {
                if self.law.follow.is_some_and(|follow| crds >> follow.crd & 1 == 1) {
                    self.law.follow = None;
                    self.owner.follows(None);
                }
                Order::Nothing
            }
            Act::Resolution(is_wide) => {
                self.law.set_resolution(is_wide);
                Order::Nothing
            }
            Act::Abort => {
                self.muted = true;
                self.owner.aborting = true;
                self.owner.abort()
            }
            Act::AbortOver => {
                self.owner.aborting = false;
                Order::Nothing
            }
            Act::Reset => {
                self.gate.cut(at);
                let gate = std::mem::take(&mut self.gate);
                *self = Channel::power_on(self.law.family);
                self.gate = gate;
                self.gate.suppress(at, None);
                self.gate.zero(at);
                Order::Nothing
            }
        };
        self.order(at, order);
        self.hold(at);
    }

    /// What is output, and how well that is known.
    fn power(&self, around: &Around) -> [f64; 2] {
        if self.owner.fault != 0 || self.muted {
            [0.0; 2]
        } else if self.gate.is_light() {
            self.law.in_light(around)
        } else {
            [self.law.in_dark(around), 0.0]
        }
    }

    /// On-time in units of 250 µs; None where rounding decides.
    fn on_time(&self, now: f64) -> Option<i64> {
        let (ms, slack) = self.gate.on_time(now);
        let [low, high] = [ms - slack, ms + slack].map(|ms| (ms * 4.0).floor().max(0.0));
        (low == high).then_some(low as i64)
    }
}

/// Causes, as GetLaserFault numbers them (docs/laser.md).
pub const INTERLOCK: i16 = 1;
pub const ALARM: i16 = 6;
pub const SERVO_OFF: i16 = 7;
pub const LIMIT: i16 = 8;
pub const UNDERRUN: i16 = 9;
pub const OTHER: i16 = 10;

/// An edge of a switch: when, ms, channel, level.
pub type GateEdge = (f64, usize, bool);

/// Closer instants, ms, are one.
const SAME_INSTANT_MS: f64 = 1e-9;
/// How well instants of paths are known: SPEC 11.
const INSTANT_ERROR_MS: f64 = 5e-6;

/// Both channels.
#[derive(Debug, Clone)]
pub struct Light {
    pub channels: [Channel; 2],
    /// What happens at the tick that is being prepared, in the order of calls; and in the interval
    /// before it.
    pub calls: Vec<Act>,
    pub between: Vec<(f64, Act)>,
    /// Paths that the Stops of this instant bring to standstill at once, and their FIFOs.
    pub halted: Vec<(usize, usize)>,
    pub edges: Vec<GateEdge>,
    /// Powers at the ticks, and how well they are known.
    pub powers: Vec<[[f64; 2]; 2]>,
    pub around: Around,
    /// Coordinate systems that run up to the tick that is being prepared, bit 0 is crd 1.
    running: u8,
    pub open: Option<&'static str>,
}

impl Light {
    pub fn new(family: Family) -> Light {
        Light {
            channels: [0, 1].map(|_| Channel::power_on(family)),
            calls: Vec::new(),
            between: Vec::new(),
            halted: Vec::new(),
            edges: Vec::new(),
            powers: Vec::new(),
            around: Around { is_pwm: true, ..Around::default() },
            running: 0,
            open: None,
        }
    }

    /// No path runs, but for those of which is said otherwise.
    pub fn standstill(&mut self) {
        (self.running, self.around.speed) = (0, [0.0; 2]);
    }

    /// A path of core 1 went so fast, at most as fast as its limit.
    pub fn follows(&mut self, crd: usize, mean: f64, most: f64, runs: bool) {
        self.running = self.running & !(1 << crd) | u8::from(runs) << crd;
        (self.around.speed[crd], self.around.most[crd]) = (mean, most);
    }

    /// A channel as the calls of this instant leave it.
    pub fn after_calls(&self, channel: usize) -> Channel {
        let mut of = self.channels[channel].clone();
        self.calls.iter().for_each(|act| of.take(channel, f64::INFINITY, act));
        of
    }

    /// From the tick before to this one. What a tick sees as a fault takes light at once; so does
    /// an Abort.
    pub fn step(&mut self, before: f64, now: f64) {
        let mut between = std::mem::take(&mut self.between);
        between.sort_by(|a, b| a.0.total_cmp(&b.0));
        let counts = |(at, act): &(f64, Act)| {
            matches!(act, Act::Entry(_, _, Command::Source { encoder: true, .. }, _))
                && [before, now].iter().any(|tick| (SAME_INSTANT_MS..INSTANT_ERROR_MS).contains(&(at - tick).abs()))
        };
        if between.iter().any(counts) {
            // The filter of their speed begins with the tick.
            self.open = Some("encoders that a laser comes to follow within rounding of a tick");
        }
        let first = between.partition_point(|(at, _)| *at <= before + SAME_INSTANT_MS);
        let (calls, running) = (std::mem::take(&mut self.calls), self.running);
        let mut halted = std::mem::take(&mut self.halted);
        let later = between.split_off(first);
        between.iter().for_each(|(at, act)| self.take(*at, act, now - before));
        self.show(before);
        let at_once = |act: &&Act| matches!(act, Act::Fault(..) | Act::Hit(..) | Act::Dark(_) | Act::Abort);
        calls.iter().filter(at_once).for_each(|act| self.take(before, act, now - before));
        later.iter().for_each(|(at, act)| self.take(*at, act, now - before));
        // Once more in its place among the calls: those before it count for nothing.
        for act in calls {
            let named = match act {
                Act::Stop(named, _) => named,
                Act::Abort => u8::MAX,
                _ => 0,
            };
            for (crd, fifo) in halted.extract_if(.., |(crd, _)| named >> *crd & 1 == 1) {
                self.take(now, &Act::Stopped(crd, fifo), now - before);
            }
            let act = if let Act::Stop(named, _) = act { Act::Stop(named, running) } else { act };
            self.take(now, &act, now - before);
        }
        // What an interlock brings to standstill is named by none of them.
        for (crd, fifo) in halted {
            self.take(now, &Act::Stopped(crd, fifo), now - before);
        }
        self.around.is_pwm = self.channels.iter().all(|channel| channel.law.mode != Mode::Analog);
        for (number, channel) in self.channels.iter_mut().enumerate() {
            channel.gate.advance(now, false);
            if channel.gate.tie() {
                self.open = Some("two edges of a laser within rounding of each other");
            }
            self.edges.extend(channel.gate.edges.drain(..).map(|(at, level)| (at, number, level)));
        }
    }

    /// One thing that happens.
    fn take(&mut self, at: f64, act: &Act, tick: f64) {
        for (number, channel) in self.channels.iter_mut().enumerate() {
            channel.gate.advance(at, false);
            let clears = matches!(act, Act::Clear(_) | Act::Set(_, Setting::ClearFault));
            if clears && channel.owner.fault != 0 && at - channel.owner.failed_at < 3.5 * tick {
                self.open = Some("a clear just after the fault of a laser");
            }
            let settles =
                matches!(act, Act::Set(..) | Act::Abort | Act::Reset | Act::Fault(..) | Act::Hit(..) | Act::Dark(_));
            if settles && channel.gate.is_near(at) {
                self.open = Some("an edge of a laser within rounding of a setting");
            }
            channel.take(number, at, act);
        }
    }

    /// The powers at the tick before.
    fn show(&mut self, before: f64) {
        let around = &self.around;
        let powers = self.channels.each_mut().map(|channel| {
            channel.gate.advance(before, true);
            channel.power(around)
        });
        self.powers.push(powers);
        if self.channels.iter().any(|channel| channel.gate.is_light() && channel.law.is_unsaid()) {
            self.open = Some("bounds of a follow and of a power mode that exclude each other beside a distance");
        }
    }

    /// What a read gives at a tick; None where rounding decides.
    pub fn read(&self, channel: usize, what: LightOf, [now, tick]: [f64; 2]) -> Option<f64> {
        let of = &self.channels[channel];
        match what {
            LightOf::GetGate | LightOf::GetSwitched => Some(f64::from(u8::from(of.owner.is_commanded()))),
            // A path's end is known a tick before it comes: which of two causes of one tick is
            // reported is open.
            LightOf::GetFault if of.owner.other_at - of.owner.failed_at <= tick => None,
            LightOf::GetFault => Some(of.owner.fault.into()),
            LightOf::GetOnTime => of.on_time(now).map(|units| units as f64),
            _ => Some(of.power(&self.around)[0]),
        }
    }

    /// All that ran at an Abort has come to rest.
    pub fn abort_over(&mut self) {
        self.channels.iter_mut().for_each(|channel| channel.owner.aborting = false);
    }

    /// Analog outputs that a laser drives, bit 0 is output 1.
    pub fn analog(&self) -> u8 {
        let of = |channel: usize| u8::from(self.channels[channel].law.mode == Mode::Analog) << channel;
        of(0) | of(1)
    }

    /// Whether calls of this instant light.
    pub fn lights_now(&self) -> bool {
        self.calls.iter().any(|act| matches!(act, Act::Gate(_, true)))
    }

    /// Whether a coordinate system may have light.
    pub fn is_lit(&self, crd: usize) -> bool {
        self.channels.iter().any(|channel| channel.owner.maps(crd) && channel.owner.is_commanded())
    }

    /// Whether an edge is pending: what is output at a tick may differ from what it is just before.
    pub fn is_busy(&self, channel: usize) -> bool {
        self.channels[channel].gate.is_busy()
    }
}

/// Coordinate systems of a mask.
pub fn crds(mask: u32) -> impl Iterator<Item = usize> {
    members(mask)
}
