//! A laser channel in duty mode without delays: SPEC 6, "Whose light it is" and "Rest", and SPEC 9.
//!
//! In: calls and entries of paths in the order of time, starts and standstills of coordinate
//! systems, faults. Out: the gate's edges and the power. There is no follow, no delay and no FPK in
//! it.
use super::call::members;

/// Who lit it. Coordinate systems are those of core 1, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Owner {
    Call,
    Path(usize),
}

/// What a call or an entry does to a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    Gate(bool),
    Power(f64),
}

/// What happens to the channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Act {
    /// A call.
    Own(usize, Command),
    /// An entry that a coordinate system reaches; whether it brakes for a Stop there.
    Entry(usize, usize, Command, bool),
    /// A coordinate system comes to standstill by a Stop, within its FIFO.
    Stopped(usize, usize),
    /// Its entries have run out; whether it braked for a Stop.
    Done(usize, bool),
    /// A Stop names these, bit 0 is crd 1.
    Stop(u8),
    /// It starts with a FIFO, and goes on with what lies there.
    Starts(usize, usize, bool),
    /// Its FIFO is cleared.
    Cleared(usize, usize),
    /// A cause of SPEC 9 of one of its axes, or of the path itself.
    Fault(usize),
    /// ClrSts of one of its axes.
    Clear(usize),
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Channel {
    pub connector: bool,
    /// Coordinate systems that may light it, bit 0 is crd 1.
    pub map: u8,
    pub carrier: bool,
    pub bounds: [f64; 2],
    direct: f64,
    lit: Option<Owner>,
    /// A Stop of this coordinate system and FIFO keeps it dark.
    held: Option<((usize, usize), Owner)>,
    /// An off by a call, and no on command since.
    off: bool,
    pub fault: bool,
}

impl Default for Channel {
    fn default() -> Channel {
        Channel {
            connector: false,
            map: 3,
            carrier: false,
            bounds: [0.0, 100.0],
            direct: 0.0,
            lit: None,
            held: None,
            off: false,
            fault: false,
        }
    }
}

impl Channel {
    pub fn is_on(&self) -> bool {
        self.lit.is_some()
    }

    /// What is output, %.
    pub fn power(&self) -> f64 {
        let [min, max] = self.bounds;
        if self.is_on() && self.carrier { self.direct.max(min).min(max) } else { 0.0 }
    }

    /// Whether light of a path is on, or would come back.
    pub fn is_of_path(&self, crds: u8) -> bool {
        let of = |owner: Owner| matches!(owner, Owner::Path(crd) if crds >> crd & 1 == 1);
        self.lit.is_some_and(of) || self.held.is_some_and(|(_, owner)| of(owner))
    }

    fn maps(&self, crd: usize) -> bool {
        self.map >> crd & 1 == 1
    }

    fn shut(&mut self) {
        (self.lit, self.held) = (None, None);
    }

    /// One thing that happens to channel `number`.
    pub fn take(&mut self, number: usize, act: &Act) {
        match *act {
            Act::Own(channel, command) if channel == number => match command {
                Command::Power(power) => self.direct = power,
                Command::Gate(false) => {
                    self.shut();
                    self.off = true;
                }
                Command::Gate(true) => {
                    self.off = false;
                    self.held = None;
                    self.lit = self.lit.or(Some(Owner::Call));
                }
            },
            Act::Entry(crd, channel, command, brakes) if channel == number && self.maps(crd) => match command {
                Command::Power(power) => self.direct = power,
                Command::Gate(false) => self.shut(),
                Command::Gate(true) => {
                    let dead = self.fault || !self.connector || brakes && self.off;
                    if !dead {
                        (self.lit, self.held, self.off) = (Some(Owner::Path(crd)), None, false);
                    }
                }
            },
            Act::Own(..) | Act::Entry(..) => {}
            Act::Stopped(crd, fifo) => {
                if self.maps(crd)
                    && let Some(owner) = self.lit.take()
                {
                    self.held = Some(((crd, fifo), owner));
                }
            }
            Act::Done(crd, braked) => {
                if self.lit == Some(Owner::Path(crd)) || braked && self.maps(crd) {
                    self.shut();
                }
            }
            Act::Stop(resting) => {
                if resting & self.map != 0 {
                    self.shut();
                }
            }
            Act::Starts(crd, fifo, goes_on) => {
                if let Some((by, owner)) = self.held.filter(|(by, _)| *by == (crd, fifo)) {
                    self.held = None;
                    if goes_on && by.0 == crd {
                        self.lit = Some(owner);
                    }
                }
            }
            Act::Cleared(crd, fifo) => {
                if self.held.is_some_and(|(by, _)| by == (crd, fifo)) {
                    self.held = None;
                }
            }
            Act::Fault(crd) => {
                if self.maps(crd) {
                    self.shut();
                    self.fault = true;
                }
            }
            Act::Clear(crd) => {
                if self.maps(crd) {
                    self.fault = false;
                }
            }
        }
    }
}

/// An edge of a gate: when, ms, channel, level.
pub type GateEdge = (f64, usize, bool);

/// Both channels.
#[derive(Debug, Clone, Default)]
pub struct Light {
    pub channels: [Channel; 2],
    /// What happens at the tick that is being prepared, in the order of calls; and in the interval
    /// before it.
    pub calls: Vec<Act>,
    pub between: Vec<(f64, Act)>,
    pub edges: Vec<GateEdge>,
    /// Coordinate systems that run up to the tick that is being prepared, bit 0 is crd 1.
    pub running: u8,
}

impl Light {
    /// A channel as the calls of this instant leave it.
    pub fn after_calls(&self, channel: usize) -> Channel {
        let mut of = self.channels[channel].clone();
        self.calls.iter().for_each(|act| of.take(channel, act));
        of
    }

    /// From the tick before to this one. What a tick sees as a fault takes light at once.
    pub fn step(&mut self, before: f64, now: f64) {
        let mut all = std::mem::take(&mut self.between);
        let calls = std::mem::take(&mut self.calls);
        all.extend(calls.iter().filter(|act| matches!(act, Act::Fault(_))).map(|act| (before, *act)));
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        for act in calls {
            match act {
                Act::Fault(_) => {}
                // Those that run come to rest later.
                Act::Stop(named) => all.push((now, Act::Stop(named & !self.running))),
                act => all.push((now, act)),
            }
        }
        for (at, act) in all {
            for (number, channel) in self.channels.iter_mut().enumerate() {
                let was = channel.is_on();
                channel.take(number, &act);
                if was != channel.is_on() {
                    self.edges.push((at, number, !was));
                }
            }
        }
    }

    pub fn powers(&self) -> [f64; 2] {
        [0, 1].map(|channel| self.channels[channel].power())
    }
}

/// Coordinate systems of a mask.
pub fn crds(mask: u32) -> impl Iterator<Item = usize> {
    members(mask)
}
