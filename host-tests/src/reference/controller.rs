//! All axes together: what each call answers in which state, and the ticks.
//!
//! A call made at s acts on the first tick after s. Whether it may act is decided by what the tick before has, with what
//! the calls before it at the same instant have changed; a motion that begins or brakes there has its time zero at that tick.
use super::axis::{Aim, Axis, Mode, Motion, Rates};
use super::call::{Call, Kind, Site, members};
use super::follow::{Begin, Datum, Lead};
use super::number::Fix;
use super::pt::{Segment, Timed};
use super::pvt::Table;
use std::collections::BTreeMap;

/// What a read gives.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    None,
    Whole(i64),
    Two(i64, i64),
    Position(Fix),
    Velocity(Fix),
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
    /// From tick 0 on, a row an axis.
    pub rows: Vec<Vec<Row>>,
    /// The contract leaves open what happens from this tick on, and why.
    pub open: Option<(usize, &'static str)>,
    /// It came to its end in the ticks that it was given.
    pub complete: bool,
    /// How often what happened.
    pub used: BTreeMap<&'static str, u64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Then {
    /// With this deceleration.
    Brake(f64),
    Update(Aim),
}

/// See the module text.
pub struct Controller {
    /// Core of each axis.
    cores: Vec<i16>,
    /// PVT tables by core and number.
    tables: BTreeMap<(i16, i16), Table>,
    tick_ns: i64,
    axes: Vec<Axis>,
    /// What begins where the motion before has come to in this tick.
    then: Vec<Option<Then>>,
    /// Reads that this tick answers.
    reads: Vec<(usize, Call, usize)>,
    open: Option<&'static str>,
    /// Axes that were asked in this tick and the one before for what needs standstill.
    contested: [u32; 2],
    used: BTreeMap<&'static str, u64>,
}

impl Controller {
    /// At power-on, machine positions in 2⁻²² pulse.
    pub fn new(site: &Site, tick_ns: i64, positions: &[i64]) -> Controller {
        let axes: Vec<Axis> = positions.iter().map(|position| Axis::new(*position)).collect();
        let then = vec![None; axes.len()];
        let cores = site.axes.iter().map(|axis| axis.0).collect();
        let tables = BTreeMap::new();
        Controller {
            cores,
            tables,
            tick_ns,
            axes,
            then,
            reads: Vec::new(),
            open: None,
            contested: [0; 2],
            used: BTreeMap::new(),
        }
    }

    /// Runs a program and `tail` ticks more; `most` ticks at most.
    pub fn run(mut self, calls: &[Call], tail: usize, most: usize) -> Program {
        let mut program = Program { replies: vec![Reply::Open; calls.len()], ..Program::default() };
        program.rows.push(self.rows());
        let (mut clock, mut waiting, mut next, mut left) = (0, None, 0, tail);
        let mut first = 0;
        for number in 1..=most {
            let (before, now) = ((number as i64 - 1) * self.tick_ns, number as i64 * self.tick_ns);
            let earlier = std::mem::replace(&mut first, next);
            while waiting.is_none() && next < calls.len() && clock < now {
                match &calls[next] {
                    Call::Sleep { ns } => {
                        clock += ns;
                        program.replies[next] = Reply::Done(Value::None);
                    }
                    Call::WaitStop { mask } => {
                        program.replies[next] = Reply::Done(Value::None);
                        let runs = members(*mask).any(|axis| self.axes[axis].runs() || self.axes[axis].halted);
                        waiting = runs.then_some(*mask);
                        members(*mask).for_each(|axis| self.axes[axis].dried = false);
                    }
                    call => {
                        let reply = self.call(next, call, now);
                        if matches!(reply, Reply::Code(_)) {
                            program.refused.push(next);
                        }
                        if self.open.is_some() {
                            break;
                        }
                        program.replies[next] = reply;
                    }
                }
                next += 1;
            }
            let acts = calls[first..next].iter().any(|call| !matches!(call, Call::Sleep { .. }));
            if acts && let Some(why) = self.axes.iter().find_map(|axis| axis.open) {
                self.open = Some(why);
            }
            self.step(before, now);
            let [asked, before_that] = self.contested;
            self.contested = [0, asked];
            if members(asked | before_that).any(|axis| self.axes[axis].ended) {
                self.open = Some("a call that needs standstill, just before its axis comes to rest");
            }
            self.answer(&mut program);
            program.rows.push(self.rows());
            if let Some(mask) = waiting {
                if let Some(why) = members(mask).find_map(|axis| self.axes[axis].open) {
                    self.open = Some(why);
                }
                if !members(mask).any(|axis| self.axes[axis].runs()) {
                    (clock, waiting) = (now, None);
                    members(mask).for_each(|axis| self.axes[axis].ended = false);
                }
            }
            if let Some(why) = self.open {
                program.replies[earlier..next].fill(Reply::Open);
                program.open = Some((number, why));
                program.complete = true;
                break;
            }
            if next == calls.len() && waiting.is_none() {
                left -= 1;
                if left == 0 {
                    program.complete = true;
                    break;
                }
            }
        }
        program.used = self.used;
        program
    }

    fn rows(&self) -> Vec<Row> {
        let row = |axis: &Axis| Row {
            x: axis.x,
            status: axis.status(),
            open: axis.open.is_some(),
            slack: axis.slack,
            most: axis.fastest,
        };
        self.axes.iter().map(row).collect()
    }

    /// Masters before their slaves.
    fn order(&self) -> Vec<usize> {
        let mut order = Vec::new();
        while order.len() < self.axes.len() {
            for axis in 0..self.axes.len() {
                let master = self.axes[axis].follow.master.filter(|_| self.axes[axis].mode == Mode::Follow);
                if !order.contains(&axis) && master.is_none_or(|master| order.contains(&master)) {
                    order.push(axis);
                }
            }
        }
        order
    }

    fn step(&mut self, before: i64, now: i64) {
        for index in self.order() {
            let mut axis = std::mem::replace(&mut self.axes[index], Axis::new(0));
            let (ran, was_slave) = (axis.runs(), matches!(axis.motion, Some(Motion::Slave(_))));
            let began = axis.began;
            let master = axis.follow.master.map(|master| &self.axes[master]);
            let lead = master.map(|master| Lead { track: &master.track, velocity: master.v, zero: master.zero });
            // A controller has few places for a master's way in a tick: between the first and the last of several knots it
            // goes straight for those that follow it.
            let follows = was_slave && !began;
            if follows && lead.as_ref().is_some_and(|lead| lead.track.len() > 4 && turns(lead.track)) {
                self.open = Some("a master that turns between several knots in a tick");
            }
            axis.step(before, now, lead.as_ref());
            if let Some(lead) = &lead
                && was_slave
            {
                // A slave goes as far as its steepest ratio takes its master's way.
                let way = lead.track.windows(2).fold(Fix::ZERO, |sum, leg| sum + (leg[1] - leg[0]).abs());
                axis.fastest = axis.fastest * way;
            } else {
                axis.fastest = axis.fastest * Fix::ms(self.tick_ns);
            }
            match self.then[index].take() {
                Some(Then::Brake(dec)) => {
                    if let (Some(Motion::Slave(slave)), Some(lead)) = (&axis.motion, &lead)
                        && slave.is_near_knot(lead)
                    {
                        self.open = Some("a Stop where a slave's ratio jumps");
                    }
                    if axis.runs() {
                        if axis.v.abs() < Fix(1 << 44) && axis.v != Fix::ZERO || axis.v == Fix::ZERO && !was_slave {
                            axis.open = Some("a Stop within rounding of standstill");
                        }
                        // Of a motion that began at this instant nobody says whether it was seen to run.
                        if began {
                            self.open = Some("a Stop at the instant of a start");
                        }
                        axis.smooth_stop(now, dec);
                    }
                }
                Some(Then::Update(aim)) => {
                    axis.update(now, aim);
                    if axis.doubt {
                        axis.open = Some("an Update without a way");
                    }
                }
                None => {}
            }
            self.count(&axis, was_slave);
            if ran && !axis.runs() {
                *self.used.entry("motions ended").or_default() += 1;
            }
            self.axes[index] = axis;
        }
    }

    /// What the programs tried.
    fn count(&mut self, axis: &Axis, was_slave: bool) {
        let moves = axis.track.iter().any(|at| *at != axis.track[0]);
        let Some(master) = axis.follow.master.filter(|_| was_slave && moves) else { return };
        let master = &self.axes[master];
        let mut used = |what| *self.used.entry(what).or_default() += 1;
        used("ticks in which a slave moves");
        if matches!(master.motion, Some(Motion::Slave(_))) {
            used("ticks in which a slave of a slave moves");
            if master.renamed {
                used("ticks in which a slave of a slave moves that was renamed");
            }
        }
        if axis.follow.dir < 0 {
            used("ticks in which a slave of direction -1 moves");
        }
    }

    fn answer(&mut self, program: &mut Program) {
        for (index, call, free) in std::mem::take(&mut self.reads) {
            let value = match call {
                Call::Axis { kind, axis } => {
                    let axis = &self.axes[axis];
                    match kind {
                        Kind::GetPtLoop => Value::Whole(axis.pt.passes),
                        Kind::GetPvtLoop => Value::Two(axis.pvt.2, axis.pvt.0),
                        Kind::GetFollowLoop => Value::Whole(axis.follow.passes),
                        Kind::GetFollowStatus => {
                            let pending = matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.switching);
                            Value::Two(axis.follow.fifo as i64, pending.into())
                        }
                        Kind::GetSts => Value::Whole(axis.status().into()),
                        Kind::GetPrfPos => Value::Position(axis.name()),
                        Kind::GetPrfVel => Value::Velocity(axis.v),
                        _ => Value::Whole(axis.mode as i64),
                    }
                }
                Call::PtSpace { axis, .. } => {
                    // At rest in the order of calls; while it runs, as it is at the tick.
                    let axis = &self.axes[axis];
                    let held = axis.pt.fifos[0].len() - axis.pt.ran;
                    Value::Whole(if free == usize::MAX { axis.pt_capacity() - held } else { free } as i64)
                }
                _ => Value::Whole(free as i64),
            };
            let open = match call {
                Call::Axis { kind, axis } => {
                    let axis_of = &self.axes[axis];
                    let master = axis_of.follow.master.map(|master| &self.axes[master]);
                    let lead = master.map(|of| Lead { track: &of.track, velocity: of.v, zero: of.zero });
                    let knot = match (&axis_of.motion, &lead) {
                        (Some(Motion::Slave(slave)), Some(lead)) => slave.is_near_knot(lead),
                        _ => false,
                    };
                    match kind {
                        Kind::GetPrfPos | Kind::GetPrfMode => false,
                        Kind::GetFollowStatus if !axis_of.follow.started => true,
                        Kind::GetPrfVel => knot || self.axes[axis].open.is_some(),
                        _ => self.axes[axis].open.is_some(),
                    }
                }
                _ => false,
            };
            program.replies[index] = if open { Reply::Open } else { Reply::Done(value) };
        }
    }

    fn read(&mut self, index: usize, call: &Call, free: usize) -> Reply {
        self.reads.push((index, call.clone(), free));
        Reply::Open
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
            Call::FollowStart { mask, option } => self.follow_start(*mask, *option),
            Call::FollowSwitch { mask } => self.follow_switch(*mask),
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
            | Call::SetFollowMemory { .. } => self.follow(index, call),
            Call::PvtTable { .. } | Call::PvtTableSelect { .. } | Call::SetPvtLoop { .. } | Call::PvtStart { .. } => {
                self.pvt(call, now)
            }
            _ => self.setting(call),
        };
        reply.unwrap_or_else(|code| if code == EITHER { Reply::Open } else { Reply::Code(code) })
    }

    fn plain(&mut self, index: usize, call: &Call, kind: Kind, place: usize) -> Answer {
        let axis = &mut self.axes[place];
        match kind {
            Kind::AxisOn => axis.servo = true,
            Kind::AxisOff => {
                axis.servo = false;
                axis.halt();
                self.then[place] = None;
            }
            Kind::ZeroPos => {
                check(!axis.runs())?;
                axis.zero = axis.x;
                axis.renamed = true;
            }
            Kind::ClrSts => axis.latched = 0,
            Kind::PrfTrap | Kind::PrfJog | Kind::PrfPvt => {
                check(!axis.runs())?;
                axis.set_mode(match kind {
                    Kind::PrfJog => Mode::Jog,
                    Kind::PrfPvt => Mode::Pvt,
                    _ => Mode::Trap,
                });
            }
            Kind::GetPtLoop => {
                check(axis.mode == Mode::Pt && !axis.pt.dynamic)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetPvtLoop => {
                check(axis.mode == Mode::Pvt)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetFollowLoop | Kind::GetFollowStatus => {
                check(axis.mode == Mode::Follow)?;
                return Ok(self.read(index, call, 0));
            }
            _ => return Ok(self.read(index, call, 0)),
        }
        DONE
    }

    fn setting(&mut self, call: &Call) -> Answer {
        match *call {
            Call::SetPrfPos { axis, pos } => {
                let axis = &mut self.axes[axis];
                check(!axis.runs())?;
                axis.zero = axis.x - Fix::whole(pos.into());
                axis.renamed = true;
            }
            Call::SetStopDec { axis, smooth } => {
                range(smooth > 0.0)?;
                self.axes[axis].stop_dec = smooth;
            }
            Call::SetSoftLimit { axis, positive, negative } => self.axes[axis].soft = (positive, negative),
            Call::SetTrapPrm { axis, acc, dec } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Trap, acc >= 0.0 && dec >= 0.0)?;
                axis.trap = Rates { acc, dec };
            }
            Call::SetJogPrm { axis, acc, dec } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Jog, acc >= 0.0 && dec >= 0.0)?;
                axis.jog = Rates { acc, dec };
            }
            Call::SetPos { axis, pos } => {
                let axis = &mut self.axes[axis];
                check(axis.mode == Mode::Trap)?;
                axis.target = pos;
            }
            Call::SetVel { axis, vel } => {
                let axis = &mut self.axes[axis];
                check(matches!(axis.mode, Mode::Trap | Mode::Jog))?;
                axis.speed = vel;
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    fn stop(&mut self, mask: u32, abrupt: u32) -> Answer {
        for place in members(mask) {
            let axis = &mut self.axes[place];
            if !axis.runs() {
                continue;
            }
            if abrupt >> place & 1 == 1 {
                axis.halt();
                self.then[place] = None;
            } else {
                let dec = axis.stop_dec;
                let pending = match self.then[place] {
                    Some(Then::Brake(dec)) => Some(dec),
                    Some(Then::Update(_)) => None,
                    None => axis.braking,
                };
                if pending.is_some_and(|pending| pending != dec) {
                    self.open = Some("a Stop with another deceleration while it brakes");
                }
                self.then[place] = Some(Then::Brake(dec));
            }
        }
        DONE
    }

    fn update(&mut self, mask: u32, now: i64) -> Answer {
        for place in members(mask) {
            let axis = &self.axes[place];
            check(match axis.mode {
                Mode::Trap => axis.trap.acc > 0.0 && axis.trap.dec > 0.0,
                Mode::Jog => axis.jog.acc > 0.0,
                _ => false,
            })?;
            check(!axis.blocked())?;
        }
        for place in members(mask) {
            if self.axes[place].speed == 0.0 {
                self.open = Some("an Update to velocity 0");
                continue;
            }
            let aim = self.axes[place].aim();
            if self.axes[place].runs() {
                self.then[place] = Some(Then::Update(aim));
            } else {
                self.axes[place].update(now, aim);
            }
        }
        DONE
    }

    fn pt_start(&mut self, mask: u32, option: u32, now: i64) -> Answer {
        let fifo = |place: usize| (option >> place & 1) as usize;
        for place in members(mask) {
            let axis = &self.axes[place];
            check(axis.mode == Mode::Pt && !axis.runs() && !axis.blocked())?;
            check(!axis.pt.fifos[if axis.pt.dynamic { 0 } else { fifo(place) }].is_empty())?;
        }
        for place in members(mask) {
            self.axes[place].start_pt(fifo(place), now);
        }
        DONE
    }

    fn pt(&mut self, index: usize, call: &Call) -> Answer {
        match *call {
            Call::PrfPt { axis, mode } => {
                let axis = &mut self.axes[axis];
                either(!axis.runs(), (0..2).contains(&mode))?;
                let dynamic = mode == 1;
                if axis.mode == Mode::Pt && axis.pt.dynamic != dynamic {
                    axis.pt.fifos = Default::default();
                    axis.pt.ran = 0;
                }
                axis.set_mode(Mode::Pt);
                axis.pt.dynamic = dynamic;
            }
            Call::PtData { axis, pos, time_ms, kind, fifo } => return self.pt_data(axis, pos, time_ms, kind, fifo),
            Call::PtClear { axis, fifo } => {
                let axis = &mut self.axes[axis];
                let fifo = axis.pt_fifo(fifo)?;
                check(!axis.runs() || !axis.pt.dynamic && axis.pt.running != fifo)?;
                axis.pt.fifos[fifo].clear();
            }
            Call::PtSpace { axis, fifo } => {
                let axis = &self.axes[axis];
                let fifo = axis.pt_fifo(fifo)?;
                let runs = axis.runs() && axis.pt.dynamic;
                let free = if runs { usize::MAX } else { axis.pt_capacity() - axis.pt.fifos[fifo].len() };
                return Ok(self.read(index, call, free));
            }
            Call::SetPtLoop { axis, loops } => {
                let axis = &mut self.axes[axis];
                check(axis.mode == Mode::Pt && !axis.pt.dynamic)?;
                axis.pt.loops = loops.into();
            }
            Call::SetPtMemory { axis, memory } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Pt && !axis.runs(), (0..2).contains(&memory))?;
                axis.pt.memory = memory;
                axis.pt.fifos = Default::default();
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    fn pt_data(&mut self, place: usize, pos: f64, time_ms: i32, kind: i16, fifo: i16) -> Answer {
        let near = Fix::ms(self.tick_ns);
        let axis = &self.axes[place];
        let in_mode = axis.mode == Mode::Pt;
        let dynamic = axis.pt.dynamic;
        let bounds = (0..3).contains(&kind) && (dynamic || (0..2).contains(&fifo));
        either(in_mode, bounds)?;
        let fifo = if dynamic { 0 } else { fifo as usize };
        if let Some(Motion::Stream(timed, _)) = &axis.motion
            && timed.curve.length() - timed.place_of_last() <= near
        {
            self.open = Some("data in the tick in which a stream ends");
        }
        if let Some(Motion::Pt(timed)) = &axis.motion
            && axis.pt.running == fifo
            && timed.curve.length() - timed.place_of_last() <= near
        {
            self.open = Some("data in the tick in which a pass ends");
        }
        let held = axis.pt.fifos[fifo].len() - if dynamic && axis.runs() { axis.pt.ran } else { 0 };
        let last = axis.pt.fifos[fifo].last().map_or(0, |segment| segment.time_ms);
        either(held < axis.pt_capacity(), i64::from(time_ms) > last)?;
        if dynamic && axis.dried {
            self.open = Some("data after a stream that ran dry");
        }
        let axis = &mut self.axes[place];
        axis.pt.fifos[fifo].push(Segment { pos, time_ms: time_ms.into(), kind });
        axis.pt_grew(fifo);
        DONE
    }

    fn pvt(&mut self, call: &Call, now: i64) -> Answer {
        match call {
            Call::PvtTable { axis, table, points } => {
                let core = self.cores[*axis];
                let uses = |(place, axis): (usize, &Axis)| {
                    self.cores[place] == core && axis.mode == Mode::Pvt && axis.runs() && axis.pvt.1 == *table
                };
                check(!self.axes.iter().enumerate().any(uses))?;
                self.tables.insert((core, *table), points.table());
            }
            Call::PvtTableSelect { axis: place, table } => {
                let axis = &mut self.axes[*place];
                check(axis.mode == Mode::Pvt)?;
                let Some(found) = self.tables.get(&(self.cores[*place], *table)) else { return Err(EITHER) };
                if let Some(Motion::Pvt(timed)) = &mut axis.motion {
                    if axis.pvt.1 != *table {
                        // Which tables are in use until the switch is more than one.
                        timed.pending = Some(found.curve.clone());
                        axis.pvt.1 = *table;
                    } else {
                        self.open = Some("PvtTableSelect of the table that runs");
                    }
                } else if axis.runs() {
                    self.open = Some("PvtTableSelect while a PVT axis brakes");
                } else {
                    axis.pvt.1 = *table;
                }
            }
            Call::SetPvtLoop { axis, loops } => {
                let axis = &mut self.axes[*axis];
                either(axis.mode == Mode::Pvt, *loops >= 0)?;
                axis.pvt.0 = i64::from(*loops);
            }
            Call::PvtStart { mask } => {
                for place in members(*mask) {
                    let axis = &self.axes[place];
                    check(axis.mode == Mode::Pvt && !axis.runs() && !axis.blocked())?;
                    check(self.tables.contains_key(&(self.cores[place], axis.pvt.1)))?;
                }
                for place in members(*mask) {
                    let axis = &mut self.axes[place];
                    let table = &self.tables[&(self.cores[place], axis.pvt.1)];
                    let timed = Timed::new(table.curve.clone(), now, axis.x).after(table.begins);
                    (axis.pvt.2, axis.began) = (0, true);
                    axis.motion = Some(Motion::Pvt(timed));
                }
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    fn follow_start(&mut self, mask: u32, option: u32) -> Answer {
        let fifo = |place: usize| (option >> place & 1) as usize;
        for place in members(mask) {
            let axis = &self.axes[place];
            check(axis.mode == Mode::Follow && !axis.runs() && !axis.blocked() && axis.follow.master.is_some())?;
            check(!axis.follow.fifos[fifo(place)].is_empty())?;
        }
        for place in members(mask) {
            self.axes[place].start_follow(fifo(place));
        }
        DONE
    }

    fn follow_switch(&mut self, mask: u32) -> Answer {
        for place in members(mask) {
            let axis = &self.axes[place];
            check(axis.mode == Mode::Follow)?;
            let Some(Motion::Slave(slave)) = &axis.motion else { return Err(1) };
            if axis.began {
                self.open = Some("FollowSwitch at the instant of FollowStart");
            }
            check(!axis.follow.fifos[slave.fifo ^ 1].is_empty() && self.then[place].is_none())?;
        }
        for place in members(mask) {
            if let Some(Motion::Slave(slave)) = &mut self.axes[place].motion {
                slave.switching = true;
            }
        }
        DONE
    }

    fn follow(&mut self, index: usize, call: &Call) -> Answer {
        match *call {
            Call::PrfFollow { axis, dir } => {
                let axis = &mut self.axes[axis];
                check(!axis.runs())?;
                check(axis.mode != Mode::Follow || axis.follow.dir == dir.signum())?;
                axis.set_mode(Mode::Follow);
                axis.follow.dir = dir.signum();
            }
            Call::SetFollowMaster { axis: place, master, .. } => {
                let axis = &self.axes[place];
                either(axis.mode == Mode::Follow && !axis.runs(), place != master)?;
                let mut above = Some(master);
                while let Some(index) = above {
                    check(index != place)?;
                    above = self.axes[index].follow.master.filter(|_| self.axes[index].mode == Mode::Follow);
                }
                self.axes[place].follow.master = Some(master);
            }
            Call::SetFollowLoop { axis, loops } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow, loops >= 0)?;
                axis.follow.loops = loops.into();
            }
            Call::SetFollowEvent { axis, event, dir, pos } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow, (1..3).contains(&event))?;
                let begin = Begin::Pass { up: dir > 0, name: pos.into() };
                axis.follow.begin = if event == 1 { Begin::Start } else { begin };
            }
            Call::FollowData { axis, datum, fifo } => return self.follow_data(axis, datum, fifo),
            Call::FollowClear { axis, fifo } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow, (0..2).contains(&fifo))?;
                if axis.began {
                    self.open = Some("FollowClear at the instant of FollowStart");
                }
                if let Some(Motion::Slave(slave)) = &axis.motion {
                    check(!slave.switching && slave.fifo != fifo as usize)?;
                } else if axis.runs() {
                    check(axis.follow.fifo != fifo as usize)?;
                }
                axis.follow.fifos[fifo as usize].clear();
            }
            Call::FollowSpace { axis, fifo } => {
                let axis = &self.axes[axis];
                either(axis.mode == Mode::Follow, (0..2).contains(&fifo))?;
                if axis.began {
                    self.open = Some("FollowSpace at the instant of FollowStart");
                }
                let free = axis.follow_capacity() - axis.follow.fifos[fifo as usize].len();
                return Ok(self.read(index, call, free));
            }
            Call::SetFollowMemory { axis, memory } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow && !axis.runs(), (0..2).contains(&memory))?;
                axis.follow.memory = memory;
                axis.follow.fifos = Default::default();
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    fn follow_data(&mut self, place: usize, datum: Datum, fifo: i16) -> Answer {
        let axis = &mut self.axes[place];
        either(axis.mode == Mode::Follow, (0..2).contains(&fifo) && (0..4).contains(&datum.kind))?;
        let fifo = fifo as usize;
        let data = &axis.follow.fifos[fifo];
        let down = data.first().map_or(datum.master < 0.0, |first| first.master < 0.0);
        let last = data.last().map_or(0.0, |last| last.master);
        let good = if down { datum.master < last } else { datum.master > last };
        // What follows it at the same instant is a tick late at times, against docs/follow.md.
        if matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.switching) {
            self.open = Some("FollowData under a pending switch");
        }
        either(data.len() < axis.follow_capacity(), good && !(datum.master < 0.0 && axis.follow.dir > 0))?;
        axis.follow.fifos[fifo].push(datum);
        if let Some(Motion::Slave(slave)) = &mut axis.motion
            && slave.fifo == fifo
        {
            slave.grow(&axis.follow.fifos[fifo]);
        }
        DONE
    }
}

/// Whether a way goes beyond its ends.
fn turns(track: &[Fix]) -> bool {
    let (Some(first), Some(last)) = (track.first(), track.last()) else { return false };
    track.iter().any(|at| at < first.min(last) || at > first.max(last))
}

type Answer = Result<Reply, i16>;
const DONE: Answer = Ok(Reply::Done(Value::None));

/// The state allows it, or 1.
fn check(good: bool) -> Result<(), i16> {
    if good { Ok(()) } else { Err(1) }
}

/// The parameter is in its range, or 7.
fn range(good: bool) -> Result<(), i16> {
    if good { Ok(()) } else { Err(7) }
}

/// Both; where neither holds the contract does not say which code comes first.
fn either(state: bool, parameter: bool) -> Result<(), i16> {
    match (state, parameter) {
        (true, true) => Ok(()),
        (false, true) => Err(1),
        (true, false) => Err(7),
        (false, false) => Err(EITHER),
    }
}

/// 1 or 7.
const EITHER: i16 = i16::MIN;

impl Axis {
    fn pt_fifo(&self, fifo: i16) -> Result<usize, i16> {
        either(self.mode == Mode::Pt, self.pt.dynamic || (0..2).contains(&fifo))?;
        Ok(if self.pt.dynamic { 0 } else { fifo as usize })
    }
}
