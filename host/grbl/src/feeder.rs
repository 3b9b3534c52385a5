//! The controller's side: entries of lines into the FIFO of the path, its starts, what it does.
//!
//! In: entries, as the sender's side queues them. Out: a [`View`] of the machine, some hundred
//! times a second. Owns the thread that talks with the controller, and what lies in the FIFO.
//! Fails: with the link's error, which ends the port; what the controller refuses or stops by
//! itself is a fault in the view, and nothing more is entered.
//!
//! **When the path starts.** [`START_MIN_MOTIONS`] motions wait, or nothing new came for
//! [`START_TIMEOUT`], or the sender waits for standstill. What comes while the path runs joins it.
//! A path that ran out of entries is dark; before it starts anew, its light is entered anew.
mod feed;

use crate::entry::{Entry, Kind};
use crate::records::records;
use client::{Call, Client, Error, decode, refused};
use protocol::command::{AxisStatus, BufLaserOn, ClrSts, CrdClear, CrdInfo, CrdStart, LaserStatus, SetOverride};
use protocol::reason::{laser_cause, stop_reason};
use protocol::values::{laser_fault, path_stop, status};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

pub use feed::Feed;

/// Motions that start a path that stands.
const START_MIN_MOTIONS: usize = 8;
/// After this time without a line the path starts with what it has.
const START_TIMEOUT: Duration = Duration::from_millis(5);
/// Entries that travel together at most.
const BATCH_ENTRIES: usize = 400;
/// Time between two looks at the controller while it moves, and while it stands.
const MOTION_POLL_PERIOD: Duration = Duration::from_millis(2);
const STANDSTILL_POLL_PERIOD: Duration = Duration::from_millis(10);
/// Time between two looks at what changes slowly: axes and the laser.
const AXIS_POLL_PERIOD: Duration = Duration::from_millis(20);
/// What passes between two looks in virtual time.
const VIRTUAL_POLL_PERIOD: Duration = Duration::from_millis(4);
/// Reasons of a stop that are limits: those of the switches and of the software.
const LIMIT_REASONS: std::ops::RangeInclusive<u16> = 4..=7;
/// Of the logical core, the coordinate system and its FIFO.
const CORE: i16 = 1;
const CRD: i16 = 1;
const FIFO: i16 = 0;

/// Why an axis has these faults, as a number of a stop reason: `reason`, if it is one of them. An
/// axis that stands, or that a Stop brakes, keeps the reason of that.
fn cause(faults: u32, reason: u16) -> u16 {
    const CAUSES: [(u32, &[u16]); 4] = [
        (status::LIMIT_POSITIVE, &[4, 6]),
        (status::LIMIT_NEGATIVE, &[5, 7]),
        (status::ALARM, &[8]),
        (status::FOLLOWING_ERROR, &[9]),
    ];
    let mut found = CAUSES.into_iter().filter(|(bit, _)| faults & bit != 0).map(|(_, reasons)| reasons);
    let first = found.clone().next().and_then(|reasons| reasons.first()).copied();
    if found.any(|reasons| reasons.contains(&reason)) { reason } else { first.unwrap_or(reason) }
}

/// What the machine does.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// The path runs.
    pub runs: bool,
    /// It stands within its entries, by a hold: in a last dwell all of them have left the FIFO.
    pub goes_on: bool,
    /// Entries and motions that are over or were thrown away.
    pub done: (u64, u64),
    /// X, Y, Z in pulses of the coordinate system.
    pub at: [f64; 3],
    /// Speeds of X, Y, Z, pulse/ms.
    pub speeds: [f64; 3],
    /// The energy that is output now, in the controller's unit; 0 where there is no light.
    pub power: f64,
    /// Entries that were given to the controller, or thrown away.
    pub entered: u64,
    /// What lies in the FIFO lasts so long, ms.
    pub lasts_ms: u32,
    /// How often the FIFO was emptied on request.
    pub emptied: u64,
    /// How often the path started.
    pub starts: u64,
    /// What the controller stopped or refused by itself.
    pub fault: Option<Fault>,
    /// It is of the time after so many releases.
    released: u64,
    /// The link has failed.
    pub failed: Option<Error>,
}

/// What the controller stopped or refused by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// A limit, and no other fault.
    pub limit: bool,
    /// What a person reads.
    pub reason: String,
}

/// What waits for the feeder.
#[derive(Default)]
struct Inbox {
    entries: VecDeque<Entry>,
    /// When the last line came.
    newest: Option<Instant>,
    /// Somebody waits for standstill.
    hurry: bool,
    /// Throw everything away once the path stands.
    empty: bool,
    /// How often lines could come again: what was wrong before is over.
    released: u64,
    /// Entries and motions that came so far.
    queued: (u64, u64),
    /// F is run at so much, %.
    feed: u8,
    ends: bool,
}

/// Who may start the path. Whoever stops it holds this, so that no start comes after.
#[derive(Default)]
struct Gate {
    /// By `!`: it goes on.
    held: bool,
    /// By a reset or a fault: it does not go on.
    stopped: bool,
    /// A standstill that comes is that of `!`.
    asked: bool,
    /// A Stop was sent after the last start. One that finds the path at standstill would take the
    /// light that comes back (SPEC 6): there is no second one.
    halts: bool,
}

struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    gate: Mutex<Gate>,
    view: Mutex<View>,
    fresh: Condvar,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How time passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// By itself.
    Real,
    /// As the client waits: tests run as fast as they can.
    Virtual,
}

/// What the laser is at a boundary of the path, as its entries say.
#[derive(Default)]
struct Light {
    on: bool,
    /// The entries that set its power, the last ones of a row.
    power: Vec<Entry>,
    /// The entry before was one of them.
    row: bool,
}

impl Light {
    fn pass(&mut self, entry: &Entry) {
        match entry.kind {
            Kind::Power => {
                if !self.row {
                    self.power.clear();
                }
                self.power.push(entry.clone());
            }
            Kind::On => self.on = true,
            Kind::Off => self.on = false,
            Kind::Motion | Kind::Output => {}
        }
        self.row = entry.kind == Kind::Power;
    }
}

struct Feeder {
    client: Arc<Client>,
    shared: Arc<Shared>,
    pace: Pace,
    axes: Vec<i16>,
    laser: Option<i16>,
    /// Entries that the FIFO holds.
    room: usize,
    /// What lies in it.
    sent: VecDeque<Entry>,
    /// Motions of those.
    motions: usize,
    /// Where the path is.
    light: Light,
    /// It was started, and its end was not sampled yet.
    started: bool,
    /// Entries in it that were planned for more than F.
    fast: usize,
    /// The factor in force.
    feed: f64,
    /// When the last motion was entered, and how many ms the FIFO lasted then.
    lasted: (Duration, u32),
    /// When axes and laser were read.
    slow: Option<Instant>,
    /// Limits of X, Y, Z that were known when lines could come again, as bits of the status: an
    /// axis may move off its switch.
    known_limits: [u32; 3],
    /// Why the laser is kept dark.
    dark: i16,
    view: View,
}

impl Feeder {
    fn begin(&mut self) -> Result<(), Error> {
        let info = self.client.call(CrdInfo { core: CORE.into(), crd: CRD.into() })?;
        self.room = usize::try_from(info.space[0].get()).unwrap_or(0);
        Ok(())
    }

    fn run(mut self) {
        loop {
            let busy = match self.cycle() {
                Ok(busy) => busy,
                Err(error) => {
                    self.view.failed = Some(error);
                    self.publish();
                    return;
                }
            };
            let inbox = locked(&self.shared.inbox);
            if inbox.ends {
                return;
            }
            let wait =
                if self.view.runs || !self.sent.is_empty() { MOTION_POLL_PERIOD } else { STANDSTILL_POLL_PERIOD };
            if busy {
                continue;
            }
            match self.pace {
                Pace::Real => drop(self.shared.wake.wait_timeout(inbox, wait)),
                Pace::Virtual => {
                    drop(inbox);
                    if let Err(error) = self.client.sleep(VIRTUAL_POLL_PERIOD) {
                        self.view.failed = Some(error);
                    }
                    std::thread::yield_now();
                }
            }
        }
    }

    fn publish(&mut self) {
        *locked(&self.shared.view) = self.view.clone();
        self.shared.fresh.notify_all();
    }

    /// Enters what fits, reads, starts; true where more waits and fits.
    fn cycle(&mut self) -> Result<bool, Error> {
        let released = locked(&self.shared.inbox).released;
        if self.view.released != released {
            (self.view.fault, self.view.released) = (None, released);
            // Known are those that are active now: they are read at once.
            (self.known_limits, self.dark) = ([status::LIMITS; 3], 0);
            self.slow = None;
        }
        let stands = {
            let gate = locked(&self.shared.gate);
            gate.held || gate.stopped || self.view.fault.is_some()
        };
        let free = self.room.saturating_sub(self.sent.len());
        let (mut batch, mut more) = (Vec::new(), false);
        let (empties, feed) = {
            let mut inbox = locked(&self.shared.inbox);
            if !stands && !inbox.empty {
                let count = inbox.entries.len().min(free).min(BATCH_ENTRIES);
                batch.extend(inbox.entries.drain(..count));
                more = !inbox.entries.is_empty() && count == BATCH_ENTRIES;
            }
            (inbox.empty, inbox.feed)
        };
        let info = self.exchange(batch, false)?;
        self.take_in(&info);
        // What the path or an axis says of a cause says more.
        if self.dark != 0 {
            let is_limit = self.dark == laser_fault::LIMIT;
            self.fault(is_limit, format!("the laser is dark: {}", laser_cause(self.dark)));
        }
        if self.known_limits != [0; 3] && !self.view.runs && self.view.fault.is_none() {
            // A switch that is not active any more counts anew.
            let _ = self.client.call(ClrSts { core: CORE.into(), axis: 1.into(), count: 8.into() });
        }
        if empties && !self.view.runs {
            self.throw_away()?;
        } else if !stands {
            self.override_feed(feed)?;
            self.start()?;
        }
        self.publish();
        Ok(more)
    }

    /// Sends entries, for the first time or `again`, and reads the state after them.
    fn exchange(&mut self, batch: Vec<Entry>, again: bool) -> Result<protocol::command::CrdState, Error> {
        let records = records(batch);
        let mut calls: Vec<Call> = records.iter().map(|record| record.call.clone()).collect();
        calls.push(Call::of(CrdInfo { core: CORE.into(), crd: CRD.into() }));
        let slow = self.slow.is_none_or(|at| at.elapsed() >= AXIS_POLL_PERIOD);
        let (first, last) = (self.axes.iter().min().copied(), self.axes.iter().max().copied());
        let axes = first.zip(last).map(|(first, last)| (first, last - first + 1));
        if slow {
            self.slow = Some(Instant::now());
            if let Some((axis, count)) = axes {
                calls.push(Call::of(AxisStatus { core: CORE.into(), axis: axis.into(), count: count.into() }));
            }
            if let Some(channel) = self.laser {
                calls.push(Call::of(LaserStatus { core: CORE.into(), channel: channel.into() }));
            }
        }
        let mut replies = self.client.exchange(&calls)?.into_iter().zip(calls.iter());
        for record in records {
            let Some(((code, payload), _)) = replies.next() else { break };
            let found = record.replies(code, payload)?;
            let whole = (!record.joined).then_some(record.call.opcode);
            for (entry, (code, reply)) in record.entries.into_iter().zip(found) {
                if code != 0 {
                    self.fault(false, refused(whole.unwrap_or(entry.call.opcode), code, &reply).reason);
                    break;
                }
                self.take_entry(entry, &reply, again);
            }
            if self.view.fault.is_some() {
                break;
            }
        }
        let result = |((code, payload), call): ((i16, Vec<u8>), &Call)| match code {
            0 => Ok(payload),
            _ => Err(refused(call.opcode, code, &payload)),
        };
        let mut rest: Vec<Result<Vec<u8>, Error>> = replies.map(result).collect();
        let extra = if slow { usize::from(axes.is_some()) + usize::from(self.laser.is_some()) } else { 0 };
        let mut reads = rest.split_off(rest.len().saturating_sub(extra + 1)).into_iter();
        let info = match reads.next() {
            Some(reply) => decode::<CrdInfo>(&reply?)?.0,
            None => return Err(Error::new(client::error::LINK_PROTOCOL, "a reply is missing")),
        };
        if slow {
            if axes.is_some()
                && let Some(reply) = reads.next()
            {
                self.take_axes(&reply?)?;
            }
            if let Some(reply) = reads.next() {
                let laser = decode::<LaserStatus>(&reply?)?.0;
                self.view.power = if laser.light != 0 { laser.power.get() } else { 0.0 };
                self.dark = laser.fault.get();
            }
        }
        Ok(info)
    }

    /// The controller has taken an entry.
    fn take_entry(&mut self, entry: Entry, reply: &[u8], again: bool) {
        self.fast += usize::from(entry.planned > 100);
        self.motions += usize::from(entry.kind == Kind::Motion);
        // CrdTaken: taken, space, lasts.
        if entry.kind == Kind::Motion
            && let Some(Ok(lasts)) = reply.get(4..8).map(<[u8; 4]>::try_from)
        {
            self.view.lasts_ms = u32::from_le_bytes(lasts);
            self.lasted = (self.client.now(), self.view.lasts_ms);
        }
        self.view.entered += u64::from(entry.counts && !again);
        self.sent.push_back(entry);
    }

    fn take_axes(&mut self, reply: &[u8]) -> Result<(), Error> {
        let items = decode::<AxisStatus>(reply)?.1;
        let least = self.axes.iter().min().copied().unwrap_or(1);
        for (place, axis) in self.axes.clone().into_iter().enumerate() {
            let Some(item) = items.get((axis - least) as usize) else { continue };
            if let Some(speed) = self.view.speeds.get_mut(place) {
                *speed = item.prf_vel.get();
            }
            let bits = item.status.get();
            let known = self.known_limits.get_mut(place).map_or(0, |known| {
                *known &= bits;
                *known
            });
            let faults = bits & status::FAULTS & !known;
            if faults != 0 {
                let reason = format!("axis {axis} stopped: {}", stop_reason(cause(faults, item.reason.get())));
                self.fault(faults & status::LIMITS != 0, reason);
            }
        }
        Ok(())
    }

    /// The first fault counts.
    fn fault(&mut self, limit: bool, reason: String) {
        if self.view.fault.is_none() {
            locked(&self.shared.gate).stopped = true;
            self.view.fault = Some(Fault { limit, reason });
        }
    }

    /// What the path has done since the last time.
    fn take_in(&mut self, info: &protocol::command::CrdState) {
        let used = self.room.saturating_sub(usize::try_from(info.space[0].get()).unwrap_or(0));
        while self.sent.len() > used {
            if let Some(entry) = self.sent.pop_front() {
                self.pass(&entry);
            }
        }
        self.view.runs = info.run != 0;
        let pos = info.pos;
        self.view.at = [pos[0].get(), pos[1].get(), pos[2].get()];
        let (at, ms) = self.lasted;
        if self.view.runs {
            let since = self.client.now().saturating_sub(at).as_millis();
            self.view.lasts_ms = ms.saturating_sub(u32::try_from(since).unwrap_or(u32::MAX));
            return;
        }
        // At standstill no time of it passes.
        self.view.lasts_ms = if self.sent.is_empty() { 0 } else { self.view.lasts_ms };
        self.lasted = (self.client.now(), self.view.lasts_ms);
        (self.view.speeds, self.view.power) = ([0.0; 3], 0.0);
        if std::mem::take(&mut self.started) {
            let asked = {
                let mut gate = locked(&self.shared.gate);
                std::mem::take(&mut gate.asked) || gate.stopped
            };
            self.view.goes_on = info.path_stop == path_stop::STOPPED;
            if info.path_stop >= path_stop::UNDERRUN && !asked {
                let reason = info.reason.get();
                self.fault(LIMIT_REASONS.contains(&reason), format!("the path stopped: {}", stop_reason(reason)));
            }
        }
    }

    /// An entry is over.
    fn pass(&mut self, entry: &Entry) {
        self.light.pass(entry);
        self.view.done.0 += u64::from(entry.counts);
        self.fast -= usize::from(entry.planned > 100);
        if entry.kind == Kind::Motion {
            self.view.done.1 += 1;
            self.motions -= 1;
        }
    }

    /// The path is emptied: it stands, dark.
    fn throw_away(&mut self) -> Result<(), Error> {
        self.client.call(CrdClear { core: CORE.into(), crd: CRD.into(), fifo: FIFO.into() })?;
        self.forget();
        let mut inbox = locked(&self.shared.inbox);
        (inbox.empty, inbox.newest) = (false, None);
        (self.view.done, self.view.entered) = (inbox.queued, inbox.queued.0);
        drop(inbox);
        self.view.emptied += 1;
        Ok(())
    }

    fn forget(&mut self) {
        self.sent.clear();
        (self.motions, self.fast) = (0, 0);
        self.light = Light::default();
        (self.started, self.view.goes_on) = (false, false);
        self.view.lasts_ms = 0;
    }

    /// Nothing is faster than asked for: lines that were planned for a higher factor run at less.
    fn override_feed(&mut self, asked: u8) -> Result<(), Error> {
        let planned = match self.fast {
            0 => 100,
            _ => self.sent.iter().map(|entry| entry.planned).max().unwrap_or(100),
        };
        let ratio = (f64::from(asked) / f64::from(planned)).min(1.0);
        if ratio != self.feed {
            self.client.call(SetOverride { core: CORE.into(), crd: CRD.into(), ratio: ratio.into() })?;
            self.feed = ratio;
        }
        Ok(())
    }

    /// Starts a path that stands and has something to do.
    fn start(&mut self) -> Result<(), Error> {
        let goes_on = self.view.goes_on;
        if self.view.runs || (self.sent.is_empty() && !goes_on) || self.view.fault.is_some() {
            return Ok(());
        }
        let quiet = {
            let inbox = locked(&self.shared.inbox);
            let quiet = inbox.newest.is_none_or(|at| at.elapsed() >= START_TIMEOUT);
            quiet || (inbox.hurry && inbox.entries.is_empty())
        };
        if !goes_on && self.motions < START_MIN_MOTIONS && !quiet {
            return Ok(());
        }
        if !goes_on {
            self.enter_light()?;
            if self.sent.is_empty() {
                return Ok(());
            }
        }
        let mut gate = locked(&self.shared.gate);
        if gate.held || gate.stopped {
            return Ok(());
        }
        (gate.asked, gate.halts) = (false, false);
        let started = self.client.call(CrdStart { core: CORE.into(), mask: 1.into(), option: 0.into() });
        drop(gate);
        match started {
            Ok(_) => {}
            Err(error) if error.code > 0 => {
                self.fault(false, error.reason);
                return Ok(());
            }
            Err(error) => return Err(error),
        }
        (self.started, self.view.goes_on, self.view.runs) = (true, false, true);
        self.view.starts += 1;
        Ok(())
    }

    /// Where a path ran out, its light went out with it, and counts as switched off. What follows
    /// says so only where it changes: the entries that hold at its first motion are entered anew.
    /// Without a motion they wait for the next start.
    fn enter_light(&mut self) -> Result<(), Error> {
        if !self.light.on {
            return Ok(());
        }
        self.client.call(CrdClear { core: CORE.into(), crd: CRD.into(), fifo: FIFO.into() })?;
        let mut entries = Vec::new();
        while let Some(entry) = self.sent.front() {
            match entry.kind {
                Kind::Motion => break,
                Kind::Output => entries.extend(self.sent.pop_front()),
                Kind::Power | Kind::On | Kind::Off => {
                    if let Some(entry) = self.sent.pop_front() {
                        self.pass(&entry);
                    }
                }
            }
        }
        if self.light.on && !self.sent.is_empty() {
            // These were counted when they were passed.
            let power = self.light.power.iter().cloned();
            entries.extend(power.map(|entry| Entry { counts: false, planned: 100, ..entry }));
            entries.push(self.on());
            self.light.on = false;
        }
        entries.extend(std::mem::take(&mut self.sent));
        (self.motions, self.fast) = (0, 0);
        while !entries.is_empty() {
            let rest = entries.split_off(entries.len().min(BATCH_ENTRIES));
            self.exchange(entries, true)?;
            entries = rest;
        }
        Ok(())
    }

    fn on(&self) -> Entry {
        let channel = self.laser.unwrap_or(0);
        let on = BufLaserOn { core: CORE.into(), crd: CRD.into(), fifo: FIFO.into(), channel: channel.into() };
        Entry { call: Call::of(on), kind: Kind::On, planned: 100, counts: false }
    }
}
