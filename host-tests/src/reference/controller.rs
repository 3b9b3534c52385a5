//! All axes together: what each call answers in which state, and the ticks.
//!
//! A call made at s acts on the first tick after s. Whether it may act is decided by what the tick
//! before has, with what the calls before it at the same instant have changed; a motion that begins
//! or brakes there has its time zero at that tick.
mod answer;
mod effects;
mod encoders;
mod follow;
mod interlock;
mod life;
mod light;
mod light_tables;
mod path_settings;
mod paths;
mod plain;
mod pt;
mod pvt;
mod reads;
mod session;
mod step;
mod tally;
mod work;

use super::axis::{self, Aim, Axis, Mode, Motion, Why};
use super::call::{Call, Setup, members};
use super::crd::Crd;
use super::effect::Levels;
use super::light::{self as beam, Act, GateEdge, Light};
use super::number::Fix;
use super::path::{Path, PathCall};
use super::pvt::Table;
use answer::EITHER;
use session::Between;
pub use session::Session;
use std::collections::BTreeMap;
use work::Work;

/// What a read gives.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    None,
    Whole(i64),
    Two(i64, i64),
    Three(i64, i64, i64),
    /// Coordinates, and what is added to the bound.
    CrdPosition([f64; 4], f64),
    Position(Fix, Fix),
    Velocity(Fix),
    /// Settings, exactly.
    Reals([f64; 4]),
    /// The first two, the last and the number of values that were computed.
    Computed([f64; 4]),
    /// An analog input, as 16 bits know it.
    Volts(f64),
    /// A share in percent, of which a whole number is known.
    Percent(f64),
    /// PvtStatus: table and time, ms.
    Table(i64, f64),
}

/// What a call answers.
#[derive(Debug, Clone, PartialEq)]
pub enum Reply {
    Done(Value),
    Code(i16),
    /// The contract does not say which.
    Open,
}

/// One axis in one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    pub x: Fix,
    pub status: u32,
    /// Rounding decides whether it runs.
    pub open: bool,
    /// What rounding may have added to the bound of SPEC 11.
    pub slack: Fix,
    /// How far it may go in the tick at most.
    pub most: Fix,
}

/// What a program gives.
#[derive(Debug, Clone, Default)]
pub struct Program {
    pub replies: Vec<Reply>,
    /// Calls that were refused, or may have been.
    pub refused: Vec<usize>,
    /// Those after which some time was made to pass: see `apart`.
    pub spread: Vec<usize>,
    /// From tick 0 on, a row an axis.
    pub rows: Vec<Vec<Row>>,
    /// Instants of the rows, ns.
    pub times: Vec<i64>,
    /// General and analog outputs in force, from tick 0 on.
    pub outputs: Vec<Levels>,
    /// Changes of general outputs.
    pub edges: Vec<Edge>,
    /// Gates of the lasers, and their powers from tick 0 on, each with how well it is known.
    pub gates: Vec<GateEdge>,
    pub powers: Vec<[[f64; 2]; 2]>,
    /// An encoder that is not where the machine must have it: tick, axis, how far.
    pub astray: Option<(usize, usize, f64)>,
    /// The contract leaves open what happens from this tick on, and why.
    pub open: Option<(usize, &'static str)>,
    /// It came to its end in the ticks that it was given.
    pub complete: bool,
    /// How often what happened.
    pub used: BTreeMap<&'static str, u64>,
}

/// A general output changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    pub ms: f64,
    /// From 0.
    pub bit: u8,
    pub level: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Then {
    /// With this deceleration, and why.
    Brake(f64, Why),
    Update(Aim),
}

/// So many WaitStops that find everything at rest take no time; what follows more of them is late
/// by a tick: an open finding.
const FREE_WAITS: usize = 2;

/// When a path has been at rest for so long, ns, where it is is known (docs/crd.md).
const STANDSTILL_KNOWN_NS: i64 = 3_000_000;

/// See the module text.
pub struct Controller {
    setup: Setup,
    /// Core of each axis.
    cores: Vec<i16>,
    /// PVT tables by core and number.
    tables: BTreeMap<(i16, i16), Table>,
    tick_ns: i64,
    /// Its SetTicks, as they went.
    sessions: Vec<Session>,
    /// Lies where the axis that steps is taken out.
    spare: Option<Box<Axis>>,
    #[allow(clippy::vec_box, reason = "axes change places in every tick, and are long")]
    axes: Vec<Box<Axis>>,
    /// What begins where the motion before has come to in this tick.
    then: Vec<Option<Then>>,
    /// Reads that this tick answers.
    reads: Vec<(usize, Call, usize)>,
    open: Option<&'static str>,
    levels: Levels,
    interlock: interlock::Interlock,
    light: Light,
    /// Axes that ran at an Abort and have not come to rest; ticks since the last one has.
    aborted: u32,
    rested: u8,
    /// Paths that a Reset has taken in their last tick: crd from 0, how far they go, their limit.
    leaving: Vec<(usize, f64, f64)>,
    /// The last call was refused, with a code that the contract leaves open.
    may_be_refused: bool,
    /// Data in this tick takes slots that a Stop before it frees: it waits for that, and what
    /// follows it is late (docs/architecture.md, Follow).
    belated: bool,
    /// Some time passes after each call that is refused; nothing is recorded.
    spreads: bool,
    /// Changes of general outputs in this tick: when, ms, which bits, their levels.
    changes: Vec<(f64, u32, u32)>,
    edges: Vec<Edge>,
    /// The same of analog outputs: channel from 0, value.
    analog: Vec<(f64, usize, i16)>,
    /// Axes that a path has set going in this tick.
    early: Vec<usize>,
    crds: BTreeMap<paths::Name, Crd>,
    path_then: Vec<(paths::Name, paths::PathThen)>,
    /// Where an arc begins may be known a tick late (docs/crd.md): 2 after a Stop, 1 after the
    /// WaitStop that follows it, until some time has passed.
    unsettled: u8,
    /// An AxisOff has acted as a Stop, and so much less than `STANDSTILL_KNOWN_NS` has passed
    /// since, ns.
    switched_off_ns: i64,
    /// No path has run, no Stop and no WaitStop has acted for so long, ns.
    still_ns: i64,
    machine: encoders::Machine,
    /// WaitStops that have acted on the tick that is being prepared.
    waits: usize,
    /// Axes that were asked in this tick and the one before for what needs standstill.
    contested: [u32; 2],
    used: BTreeMap<&'static str, u64>,
}

impl Controller {
    /// At power-on, machine positions in 2⁻²² pulse.
    pub fn new(setup: &Setup, tick_ns: i64, positions: &[i64]) -> Controller {
        let axes: Vec<Box<Axis>> = positions.iter().map(|position| Box::new(Axis::new(*position))).collect();
        let then = vec![None; axes.len()];
        let cores = setup.axes.iter().map(|axis| axis.0).collect();
        let tables = BTreeMap::new();
        let machine = encoders::Machine::new(&axes);
        Controller {
            setup: setup.clone(),
            machine,
            waits: 0,
            levels: Levels::default(),
            interlock: interlock::Interlock::default(),
            light: Light::new(setup.family),
            aborted: 0,
            rested: 0,
            leaving: Vec::new(),
            may_be_refused: false,
            belated: false,
            spreads: false,
            changes: Vec::new(),
            edges: Vec::new(),
            analog: Vec::new(),
            early: Vec::new(),
            crds: BTreeMap::new(),
            path_then: Vec::new(),
            unsettled: 0,
            switched_off_ns: 0,
            still_ns: 0,
            cores,
            tables,
            tick_ns,
            sessions: Vec::new(),
            axes,
            spare: None,
            then,
            reads: Vec::new(),
            open: None,
            contested: [0; 2],
            used: BTreeMap::new(),
        }
    }

    /// With encoder counts as they were recorded, an axis each, from tick 0 on. Without them they
    /// are those of a machine that lags as the contract says.
    pub fn with_encoders(mut self, recorded: Vec<Vec<i64>>) -> Controller {
        self.machine.recorded = recorded;
        self
    }

    /// The program with 3 ms after every call that is refused, where less passes before the next
    /// one. None: it has no end.
    pub fn apart(mut self, calls: &[Call], tail: usize, most: usize) -> Option<Vec<Call>> {
        self.spreads = true;
        let program = self.run(calls, tail, most);
        let mut apart = Vec::with_capacity(calls.len() + program.spread.len());
        let mut after = program.spread.iter().peekable();
        for (index, call) in calls.iter().enumerate() {
            apart.push(call.clone());
            if after.next_if_eq(&&index).is_some() {
                apart.push(Call::Sleep { ns: STANDSTILL_KNOWN_NS });
            }
        }
        program.complete.then_some(apart)
    }

    /// Whether less passes after a call before the next one.
    pub fn is_near(calls: &[Call], index: usize) -> bool {
        calls.get(index + 1).is_some_and(|next| !matches!(next, Call::Sleep { ns } if *ns >= STANDSTILL_KNOWN_NS))
    }

    /// With the instants of its SetTicks as they were recorded, in their order.
    pub fn with_sessions(mut self, recorded: Vec<Session>) -> Controller {
        self.sessions = recorded;
        self
    }

    /// With output levels as they are before the program.
    pub fn with_outputs(mut self, levels: Levels) -> Controller {
        self.levels = levels;
        self
    }

    /// Runs a program and `tail` ticks more; `most` ticks at most.
    pub fn run(mut self, calls: &[Call], tail: usize, most: usize) -> Program {
        let mut program = Program { replies: vec![Reply::Open; calls.len()], ..Program::default() };
        program.rows.push(self.rows());
        program.times.push(0);
        program.outputs.push(self.levels.clone());
        self.encoders(0, self.tick_ns);
        // Every run switches the limit switches off first.
        self.axes.iter_mut().for_each(|axis| axis.terminals.on = 1 << axis::terminal::ALARM);
        self.axes.iter_mut().for_each(|axis| axis.encoder_zero = axis.encoder[1]);
        let (mut clock, mut waiting, mut waited, mut next, mut left) = (0, None, 0, 0, tail);
        let mut first = 0;
        let (mut now, mut ticks_set) = (0, 0);
        let mut between: Option<Between> = None;
        for number in 1..=most {
            let before = now;
            if let Some(Call::SetTick { us }) = calls.get(next).filter(|_| between.is_none())
                && let Some(session) = self.sessions.get(ticks_set).filter(|of| of.acted == Some(before))
            {
                // Right after another one.
                let runs = self.axes.iter().any(|axis| axis.runs());
                between = Some(Between::new(*us, Some(*session), (now, runs), self.tick_ns));
                ticks_set += 1;
            }
            if let Some(us) = between.as_mut().and_then(|between| between.change(before)) {
                self.tick_ns = us * 1000;
            }
            now = before + self.tick_ns;
            let earlier = std::mem::replace(&mut first, next);
            self.waits = 0;
            self.encoders(number, now - before);
            for axis in &mut self.axes {
                let fresh = axis.sample();
                if let Some(crd) = axis.light_crd().filter(|_| fresh != 0 && !axis.is_alarmed()) {
                    self.light.calls.push(Act::Hit(crd, beam::LIMIT));
                }
                let crd = axis.light_crd().filter(|_| axis.is_alarmed());
                if let Some(crd) = crd.filter(|_| crd != axis.alarms) {
                    self.light.calls.push(Act::Fault(crd, beam::ALARM));
                    axis.alarms = Some(crd);
                }
                if fresh != 0 && axis.geared {
                    self.open = Some("a limit or an alarm of a geared axis");
                }
            }
            self.sample_interlock();
            let mut work = Work::of(self.tick_ns);
            while waiting.is_none() && between.is_none() && next < calls.len() && clock < now {
                if !work.takes(&calls[next]) {
                    self.open = Some("more work than a tick takes");
                    break;
                }
                match &calls[next] {
                    Call::SetTick { us } => {
                        let (session, runs) =
                            (self.sessions.get(ticks_set).copied(), self.axes.iter().any(|axis| axis.runs()));
                        between = Some(Between::new(*us, session, (now, runs), self.tick_ns));
                        ticks_set += 1;
                        break;
                    }
                    Call::Sleep { ns } => {
                        clock += ns;
                        if *ns >= STANDSTILL_KNOWN_NS && self.unsettled == 1 && self.crds.values().all(|of| !of.runs) {
                            self.unsettled = 0;
                        }
                        program.replies[next] = Reply::Done(Value::None);
                    }
                    Call::WaitStop { mask } => {
                        (self.unsettled, self.still_ns) = (1, 0);
                        program.replies[next] = Reply::Done(Value::None);
                        let runs = members(*mask).any(|axis| self.axes[axis].runs() || self.axes[axis].halted);
                        self.await_paths(*mask);
                        waiting = runs.then_some(*mask);
                        members(*mask).for_each(|axis| self.axes[axis].broken = false);
                        self.waits += 1;
                    }
                    Call::Path(PathCall { core, what: Path::Wait { mask } }) => {
                        (self.unsettled, self.still_ns) = (1, 0);
                        program.replies[next] = Reply::Done(Value::None);
                        let axes = self.path_axes(*core, *mask);
                        self.await_paths(axes);
                        self.waits += 1;
                        waiting = self.paths_run(*core, *mask).then_some(axes);
                    }
                    call => {
                        if self.waits > FREE_WAITS {
                            self.open = Some("more WaitStops of an instant than are known ahead");
                            break;
                        }
                        if self.belated {
                            self.open = Some("a call after data that waits for a Stop of its tick");
                            break;
                        }
                        let reply = self.call(next, call, now);
                        if matches!(reply, Reply::Code(1)) || std::mem::take(&mut self.may_be_refused) {
                            program.refused.push(next);
                            if self.spreads && Controller::is_near(calls, next) {
                                program.spread.push(next);
                                (clock, self.unsettled) = (clock + STANDSTILL_KNOWN_NS, self.unsettled & 2);
                            }
                        }
                        if self.open.is_some() {
                            break;
                        }
                        program.replies[next] = reply;
                    }
                }
                next += 1;
            }
            for axis in &mut self.axes {
                // Also where its coordinate system or a map comes to name it.
                let crd = axis.light_crd().filter(|_| axis.is_alarmed());
                if let Some(crd) = crd.filter(|_| crd != axis.alarms) {
                    self.light.calls.push(Act::Fault(crd, beam::ALARM));
                }
                axis.alarms = crd;
            }
            let acts = calls[first..next].iter().any(|call| !matches!(call, Call::Sleep { .. } | Call::SetTick { .. }));
            if acts && let Some(why) = self.axes.iter().find_map(|axis| axis.open) {
                self.open = Some(why);
            }
            self.step(before, now);
            self.belated = false;
            self.finish_abort();
            // The same where every path has been at rest for as long.
            self.still_ns = if self.crds.values().any(|of| of.runs) { 0 } else { self.still_ns + now - before };
            self.switched_off_ns = (self.switched_off_ns - now + before).max(0);
            if self.still_ns >= STANDSTILL_KNOWN_NS {
                self.unsettled = 0;
            }
            for axis in std::mem::take(&mut self.early) {
                // A path is ahead of the tick: its axis is reported to move a tick before.
                if let Some(row) = program.rows.get_mut(number - 1) {
                    row[axis].open = true;
                }
                let named = |call: &Call| call.axes() >> axis & 1 == 1 || matches!(call, Call::Abort { .. });
                // Also a WaitStop that found it at standstill there.
                if calls[earlier..next].iter().any(named) || waited >> axis & 1 == 1 {
                    self.open = Some("a call to an axis in the tick in which a path moves it");
                }
            }
            let [asked, before_that] = self.contested;
            self.contested = [0, asked];
            // A Stop or a WaitStop of its instant makes a call that fails a tick late.
            let late = calls[earlier..next].iter().any(Call::is_stop_or_wait);
            let rests = |axis: &Axis| axis.ended || late && !axis.runs();
            if members(asked | before_that).any(|axis| rests(&self.axes[axis])) {
                self.open = Some("a call that needs standstill, just before its axis comes to rest");
            }
            self.open = self.open.or_else(|| members(asked).find_map(|axis| self.axes[axis].open));
            self.answer(&mut program, now);
            if let Some(of) = &mut between {
                self.open = self.open.or(of.look(&self.axes, now));
                if let Some(reply) = of.reply(now) {
                    *self.used.entry(of.tally()).or_default() += 1;
                    program.replies[next] = reply;
                    if let Some(us) = of.change(now) {
                        self.tick_ns = us * 1000;
                    }
                    (clock, between, next) = (of.zero(), None, next + 1);
                }
            }
            if !self.spreads {
                program.times.push(now);
                program.rows.push(self.rows());
                program.outputs.push(self.levels.clone());
            }
            waited = 0;
            if let Some(mask) = waiting {
                if let Some(why) = members(mask).find_map(|axis| self.axes[axis].open) {
                    self.open = Some(why);
                }
                if !members(mask).any(|axis| self.axes[axis].runs()) {
                    (clock, waiting, waited) = (now, None, mask);
                    members(mask).for_each(|axis| self.axes[axis].ended = false);
                }
            }
            if let Some(why) = self.open {
                // With the call at which it became open.
                program.replies[earlier..(next + 1).min(calls.len())].fill(Reply::Open);
                program.open = Some((number, why));
                program.complete = true;
                break;
            }
            // A Sleep at its end is part of it.
            if next == calls.len() && waiting.is_none() && clock < now {
                left -= 1;
                if left == 0 {
                    program.complete = true;
                    // What a path does in the tick after may show already.
                    self.step(now, now + self.tick_ns);
                    if members(self.contested[1]).any(|axis| self.axes[axis].ended) {
                        self.open = Some("a call that needs standstill, just before its axis comes to rest");
                        program.replies[earlier..next].fill(Reply::Open);
                    }
                    program.open = self.open.map(|why| (number, why));
                    for axis in std::mem::take(&mut self.early) {
                        if let Some(row) = program.rows.get_mut(number) {
                            row[axis].open = true;
                        }
                    }
                    program.outputs.push(self.levels.clone());
                    break;
                }
            }
        }
        program.used = self.used;
        program.edges = self.edges;
        program.gates = self.light.edges;
        program.powers = self.light.powers;
        program.astray = self.machine.astray;
        program
    }

    fn rows(&self) -> Vec<Row> {
        let row = |axis: &Axis| Row {
            x: axis.x,
            status: axis.status(),
            open: axis.open.is_some() || axis.resets > 0,
            slack: axis.slack + axis.late + self.rounding(axis),
            most: axis.fastest,
        };
        self.axes.iter().map(|axis| row(axis)).collect()
    }

    /// What rounding of its master's position to 2⁻²² makes of a slave's: where it began and where
    /// it is, and where the master was planned again on the way.
    pub(super) fn rounding(&self, axis: &Axis) -> Fix {
        let Some(Motion::Slave(slave)) = &axis.motion else { return Fix::ZERO };
        slave.table.curve.steepest * (Fix(1 << 42) + self.rounding_of_master(axis))
    }

    /// How well the position of an axis's master is known, but for its own 2⁻²².
    pub(super) fn rounding_of_master(&self, axis: &Axis) -> Fix {
        let master = axis.follow.master.filter(|master| !master.is_counted()).map(|master| &self.axes[master.axis]);
        master.map_or(Fix::ZERO, |master| {
            master.slack + master.late + master.late + Fix(master.replans << 41) + self.rounding(master)
        })
    }

    fn call(&mut self, index: usize, call: &Call, now: i64) -> Reply {
        if call.needs_rest() {
            // A table is in use by any axis.
            let all = (1 << self.axes.len()) - 1;
            let named = if matches!(call, Call::PvtTable { .. }) { all } else { call.axes() };
            if named == all && self.axes.iter().any(|axis| axis.mode == Mode::Pvt && axis.ended) {
                self.open = Some("a call that needs standstill, right after its axis came to rest");
            }
            let axes = members(named).filter(|axis| self.axes[*axis].runs());
            self.contested[0] |= axes.map(|axis| 1 << axis).sum::<u32>();
        }
        if call.needs_rest() && self.unsettled != 0 && self.may_set_off(call.axes()) {
            // Whether it moves is known only at its instant: docs/crd.md.
            self.open =
                Some("a call that needs standstill of an axis that a path may move, after a Stop or a WaitStop");
        }
        if call.needs_rest() && members(call.axes()).any(|axis| self.axes[axis].ended) {
            self.open = Some("a call that needs standstill, right after its axis came to rest");
        }
        if !matches!(call, Call::Stop { .. }) && members(call.axes()).any(|axis| self.axes[axis].doubt) {
            self.open = Some("a call at the instant at which its axis came to rest");
        }
        let reply = match call {
            Call::Axis { kind, axis } => self.plain(index, call, *kind, *axis),
            Call::Stop { mask, abrupt } => self.stop(*mask, *abrupt),
            Call::PtStart { mask, option } => self.pt_start(*mask, *option, now),
            Call::FollowStart { mask, option } => self.follow_start(*mask, *option, Mode::Follow),
            Call::FollowSwitch { mask } => self.follow_switch(*mask, Mode::Follow),
            Call::Update { mask } => self.update(*mask, now),
            Call::PrfPt { .. }
            | Call::PtData { .. }
            | Call::PtClear { .. }
            | Call::PtSpace { .. }
            | Call::SetPtLoop { .. }
            | Call::SetPtMemory { .. } => self.pt(index, call),
            Call::PrfFollow { .. }
            | Call::SetFollowMaster { .. }
            | Call::SetFollowLoop { .. }
            | Call::SetFollowEvent { .. }
            | Call::FollowData { .. }
            | Call::FollowClear { .. }
            | Call::FollowSpace { .. }
            | Call::SetFollowMemory { .. } => self.follow(index, call, Mode::Follow),
            Call::Ex(of) => match &**of {
                Call::FollowStart { mask, option } => self.follow_start(*mask, *option, Mode::FollowEx),
                Call::FollowSwitch { mask } => self.follow_switch(*mask, Mode::FollowEx),
                of => self.follow(index, of, Mode::FollowEx),
            },
            Call::FollowEntry { axis, item, fifo } => self.follow_item(*axis, *item, *fifo, Mode::FollowEx),
            Call::FollowSwitchNow { axis, table } => self.follow_switch_now(*axis, *table),
            Call::Terminal { .. } | Call::Guard { .. } | Call::Sense { .. } | Call::SetCapture { .. } => {
                self.terminal(call)
            }
            Call::Effect(effect) => self.effect(index, call, effect, now),
            Call::Light(of) => self.light(index, call, of, now),
            Call::LightTable(of) => self.light_table(of),
            Call::PvtCalculate { points, .. } => {
                let of = points.calculated();
                Ok(Reply::Done(Value::Computed([of[0], of[1], of[of.len() - 1], of.len() as f64])))
            }
            Call::AsymmetricWay { master, ratios, shares, .. } => Self::asymmetric_way(*master, *ratios, *shares),
            Call::Abort { core } => self.abort(*core),
            Call::Reset { core } => self.reset(*core, now),
            Call::Path(of) => self.path(index, call, of, now),
            Call::PvtTable { .. } | Call::PvtTableSelect { .. } | Call::SetPvtLoop { .. } | Call::PvtStart { .. } => {
                self.pvt(call, now)
            }
            _ => self.setting(call),
        };
        self.may_be_refused = matches!(reply, Err(EITHER));
        reply.unwrap_or_else(|code| if code == EITHER { Reply::Open } else { Reply::Code(code) })
    }
}
