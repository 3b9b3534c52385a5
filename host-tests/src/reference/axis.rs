//! One axis: its settings, its data, and the motion that it makes.
mod limits;
mod replan;
mod starts;
mod step;

use super::filter::Filter;
use super::follow::Item;
use super::number::Fix;
use super::pt::{Chain, Segment, Timed};
use super::slave::{Begin, Slave};
use limits::Terminals;
pub use limits::{Why, terminal};

/// Profile mode, as GetPrfMode numbers it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    Trap = 0,
    Jog = 1,
    Pt = 2,
    Follow = 4,
    Crd = 5,
    Pvt = 6,
    FollowEx = 10,
}

#[derive(Debug, Clone)]
pub enum Motion {
    /// Trap, Jog, a smooth Stop.
    Ramp(Timed),
    Pt(Timed),
    Pvt(Timed),
    /// A dynamic PT stream, and how many of its segments have run.
    Stream(Timed, usize),
    Slave(Box<Slave>),
}

/// Acceleration and deceleration as they were set; 0 is unset.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rates {
    pub acc: f64,
    pub dec: f64,
}

/// A target of Trap, or a velocity of Jog.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    rates: Rates,
    target: i32,
    speed: f64,
}

#[derive(Debug, Clone)]
pub struct PtData {
    pub dynamic: bool,
    pub memory: i16,
    pub loops: i64,
    pub fifos: [Vec<Segment>; 2],
    /// Dynamic: how many of `fifos[0]` have run.
    pub ran: usize,
    /// Dynamic: segments of a stream that ended in this tick.
    pub over: usize,
    pub running: usize,
    pub passes: i64,
}

/// Whom an axis follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Master {
    pub axis: usize,
    /// 1 its encoder, 2 its planned position, 3 what `item` says.
    pub kind: i16,
    pub item: i16,
}

impl Master {
    /// Its encoder.
    pub fn is_counted(self) -> bool {
        self.kind == 1 || self.kind == 3 && !matches!(self.item, 0 | 2)
    }

    pub fn is_filtered(self) -> bool {
        self.kind == 3 && matches!(self.item, 2 | 3)
    }

    /// Straight between ticks.
    pub fn is_sampled(self) -> bool {
        self.is_counted() || self.is_filtered()
    }
}

#[derive(Debug, Clone)]
pub struct FollowData {
    pub dir: i16,
    pub master: Option<Master>,
    pub memory: i16,
    pub loops: i64,
    pub begin: Begin,
    pub fifos: [Vec<Item>; 2],
    /// FIFO in force and completed passes, as they are read.
    pub fifo: usize,
    pub passes: i64,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Axis {
    pub servo: bool,
    pub mode: Mode,
    /// Machine position and velocity in force.
    pub x: Fix,
    pub v: Fix,
    /// Machine position of the name 0.
    pub zero: Fix,
    /// By ZeroPos or SetPrfPos.
    pub renamed: bool,
    /// A Stop or an Update acts on the tick that is computed.
    pub replanned: bool,
    /// Rounding decides more than a nanosecond of when the move that a path has sent it on ends.
    pub end_is_doubtful: bool,
    /// Positions from the last tick to this one, and their instants, ms: `Fix::FAR` where they are
    /// unknown.
    pub track: Vec<Fix>,
    pub times: Vec<Fix>,
    /// The motion of the tick, where it has ended or was replaced at its end.
    past: Option<Motion>,
    /// Encoder counts in the tick before and in this one, and the count with the name 0.
    pub encoder: [Fix; 2],
    pub encoder_zero: Fix,
    pub latched: u32,
    /// Limits and an alarm that are there, and those that refuse a start.
    causes: u32,
    blocks: u32,
    pub terminals: Terminals,
    /// The coordinate system whose light its alarm has taken.
    pub alarms: Option<usize>,
    /// Why it came to standstill last, where that is known, and why the motion in force will.
    pub why: Option<Why>,
    pub ending: Why,
    pub motion: Option<Motion>,
    pub stop_dec: f64,
    /// SetAxisBand, SetPosErr.
    pub band: (i32, i32),
    pub pos_err: i32,
    pub soft: (i32, i32),
    pub trap: Rates,
    pub jog: Rates,
    pub target: i32,
    pub speed: f64,
    /// PVT: loops, table selected, completed passes.
    pub pvt: (i64, i16, i64),
    /// The table that runs, until the one selected takes over.
    pub table: i16,
    pub pt: PtData,
    /// Time of its first point.
    pub table_begins: Fix,
    /// The same of the one selected.
    pub next_begins: Fix,
    /// Of the PT data that runs.
    chain: Chain,
    pub follow: FollowData,
    /// What rounding decides in this tick.
    pub open: Option<&'static str>,
    /// What the contract leaves open.
    pub unsaid: Option<&'static str>,
    /// A motion without a length began on the tick that is being prepared, or one ended there at
    /// once.
    pub doubt: bool,
    /// A motion began on the tick that is being prepared.
    pub began: bool,
    /// It came to standstill in the last tick by itself, and no call has waited for it.
    pub ended: bool,
    /// Of a filtered master: where it was and where it is, filtered, and how far behind.
    pub filter: Option<Filter>,
    /// Its coordinate system, whether that runs, and its motion in this tick: instants and
    /// positions.
    pub crd: Option<(i16, i16)>,
    pub driven: bool,
    pub carried: Option<Vec<(Fix, Fix)>>,
    pub bent: bool,
    pub on_path: bool,
    pub path_open: bool,
    pub path_ended: bool,
    pub path_most: Fix,
    /// A Stop named it on the tick that is being prepared.
    pub stopped: bool,
    /// In this tick it has become one of a coordinate system.
    pub joined: bool,
    /// It came to standstill on the tick that is being prepared.
    pub halted: bool,
    /// General outputs that its entries have set in this tick.
    pub outputs: Vec<(i16, bool)>,
    /// Its motion ended because an input did not come.
    pub timed_out: bool,
    /// The deceleration of the smooth Stop that it is in.
    pub braking: Option<f64>,
    /// A limit ended or refused a stream. Data that was taken before does not know that, and no
    /// call has waited since.
    pub broken: bool,
    /// It came to a soft limit in this tick, or within rounding of one.
    pub limited: bool,
    pub brink: bool,
    /// How far it may be from here: see `smooth_stop`.
    pub slack: Fix,
    /// The same of its position with the name 0.
    pub zero_slack: Fix,
    /// The same of the motion in force, which a path began.
    pub late: Fix,
    /// The same of its velocity.
    pub late_velocity: Fix,
    /// How often its motion was planned again, from a rounded position.
    pub replans: i128,
    /// How well the velocity of a slave is known: see `Slave::velocity_rounding`.
    pub velocity_rounding: Fix,
    /// Instants and positions of this tick before the motion that a path began; there was one; it
    /// has no length.
    pub head: Vec<(Fix, Fix)>,
    /// No motion there was faster.
    pub head_most: Fix,
    /// A gear took it along there.
    pub led: bool,
    moved: bool,
    brief: bool,
    /// It is geared to a motion of its coordinate system.
    pub geared: bool,
    /// Ticks in which a Reset may still change its status.
    pub resets: u8,
    /// A Reset has named its encoder while that moved.
    pub is_lost: bool,
    /// No motion of the tick was faster, pulse/ms.
    pub fastest: Fix,
}

/// The nearest whole pulse.
pub fn whole(x: Fix) -> Fix {
    Fix::whole(((x.0 + (1 << 63)) >> 64) as i64)
}

impl Axis {
    /// At power-on, its machine position in 2⁻²² pulse.
    pub fn new(position: i64) -> Axis {
        let x = Fix::of_position(position);
        Axis {
            servo: false,
            mode: Mode::Trap,
            x,
            v: Fix::ZERO,
            zero: x,
            renamed: false,
            replanned: false,
            end_is_doubtful: false,
            track: vec![x, x],
            times: vec![Fix::ZERO; 2],
            past: None,
            encoder: [whole(x); 2],
            encoder_zero: whole(x),
            latched: 0,
            causes: 0,
            blocks: 0,
            terminals: Terminals::default(),
            alarms: None,
            why: None,
            ending: Why::End,
            motion: None,
            stop_dec: 1.0,
            band: (0, 0),
            pos_err: i32::MAX,
            soft: (i32::MAX, i32::MIN),
            trap: Rates::default(),
            jog: Rates::default(),
            target: 0,
            speed: 0.0,
            pvt: (1, 1, 0),
            table: 1,
            pt: PtData {
                dynamic: false,
                memory: 0,
                loops: 1,
                fifos: Default::default(),
                ran: 0,
                over: 0,
                running: 0,
                passes: 0,
            },
            table_begins: Fix::ZERO,
            next_begins: Fix::ZERO,
            chain: Chain::default(),
            follow: FollowData {
                dir: 0,
                master: None,
                memory: 0,
                loops: 1,
                begin: Begin::Start,
                fifos: Default::default(),
                fifo: 0,
                passes: 0,
            },
            open: None,
            unsaid: None,
            doubt: false,
            began: false,
            ended: false,
            filter: None,
            crd: None,
            driven: false,
            carried: None,
            bent: false,
            on_path: false,
            path_open: false,
            path_ended: false,
            path_most: Fix::ZERO,
            stopped: false,
            joined: false,
            halted: false,
            outputs: Vec::new(),
            timed_out: false,
            braking: None,
            broken: false,
            limited: false,
            brink: false,
            slack: Fix::ZERO,
            zero_slack: Fix::ZERO,
            late: Fix::ZERO,
            late_velocity: Fix::ZERO,
            replans: 0,
            velocity_rounding: Fix::ZERO,
            head: Vec::new(),
            head_most: Fix::ZERO,
            led: false,
            moved: false,
            brief: false,
            geared: false,
            resets: 0,
            is_lost: false,
            fastest: Fix::ZERO,
        }
    }

    pub fn runs(&self) -> bool {
        self.motion.is_some() || self.driven
    }

    /// How far the encoder went in this tick.
    pub fn counts(&self) -> Fix {
        (self.encoder[1] - self.encoder[0]).abs()
    }

    /// Whether it was a slave in this tick.
    pub fn follow_moves(&self) -> bool {
        matches!(self.past.as_ref().or(self.motion.as_ref()), Some(Motion::Slave(_)))
    }

    /// Its acceleration from an instant on, where it is a function of time that does not change
    /// there.
    pub fn acceleration(&self, at: Fix) -> Option<Fix> {
        if self.driven || self.mode == Mode::Crd || self.is_moved() {
            return None;
        }
        match &self.motion {
            None => Some(Fix::ZERO),
            Some(Motion::Ramp(timed) | Motion::Pt(timed) | Motion::Pvt(timed) | Motion::Stream(timed, _)) => {
                // Where it has just begun, that of the motion before may be read.
                timed.curve.curvature(timed.position(at)).filter(|_| timed.start != at)
            }
            Some(Motion::Slave(_)) => None,
        }
    }

    /// Whether a PVT table is in force.
    pub fn is_in_table(&self) -> bool {
        matches!(self.motion, Some(Motion::Pvt(_))) && !self.began
    }

    /// Its time in the table.
    pub fn table_time(&self, at: Fix) -> Fix {
        let Some(Motion::Pvt(timed)) = &self.motion else { return Fix::ZERO };
        timed.position(at) + self.table_begins
    }

    /// Follow or FollowEx.
    pub fn is_follow(&self) -> bool {
        matches!(self.mode, Mode::Follow | Mode::FollowEx)
    }

    pub fn name(&self) -> Fix {
        self.x - self.zero
    }

    /// This position has another name from now on.
    pub fn rename(&mut self, name: Fix) {
        self.zero = self.x - name;
        (self.renamed, self.zero_slack) = (true, self.slack + self.late);
    }

    /// Bits 5, 6, 9 and 10 of the status word.
    pub fn status(&self) -> u32 {
        self.latched | u32::from(self.servo) << 9 | u32::from(self.runs()) << 10
    }

    /// Whether a start is refused by the servo or by what is latched.
    pub fn blocked(&self) -> bool {
        !self.servo || self.blocks != 0
    }

    /// The coordinate system of core 1 that it belongs to, from 0: its faults take that one's
    /// light.
    pub fn light_crd(&self) -> Option<usize> {
        let (core, crd) = self.crd.filter(|_| self.mode == Mode::Crd)?;
        (core == 1).then_some(crd as usize - 1)
    }

    /// The one of core 1 that takes it along beside its path, from 0.
    pub fn geared_crd(&self) -> Option<usize> {
        let (core, crd) = self.crd.filter(|_| self.geared && self.driven)?;
        (core == 1).then_some(crd as usize - 1)
    }

    /// Another mode: data of PT and Follow is gone.
    pub fn set_mode(&mut self, mode: Mode) {
        if self.mode == mode {
            return;
        }
        self.mode = mode;
        self.pt.fifos = Default::default();
        self.pt.ran = 0;
        self.pt.dynamic = false;
        self.follow.fifos = Default::default();
        self.follow.master = None;
        (self.follow.passes, self.follow.fifo, self.pt.passes, self.pvt.2) = (0, 0, 0, 0);
        self.follow.begin = Begin::Start;
    }

    pub fn pt_capacity(&self) -> usize {
        let one = if self.pt.memory == 0 { 32 } else { 1024 };
        if self.pt.dynamic { 2 * one } else { one }
    }

    pub fn follow_capacity(&self) -> usize {
        if self.follow.memory == 0 { 16 } else { 512 }
    }

    /// Whether a part of its motion begins at an instant.
    pub fn is_at_knot(&self, at: Fix) -> bool {
        match &self.motion {
            Some(Motion::Ramp(timed) | Motion::Pt(timed) | Motion::Pvt(timed) | Motion::Stream(timed, _)) => {
                timed.is_at_knot(at)
            }
            Some(Motion::Slave(_)) | None => false,
        }
    }

    /// Whether a path moves it, at instants that are known to 5 ns.
    pub fn is_moved(&self) -> bool {
        self.moved || self.late != Fix::ZERO
    }

    /// The same so far from where it is known to be that it decides more than the bound of a slave.
    pub fn is_astray(&self) -> bool {
        self.moved || self.late > Fix(1 << 48)
    }

    /// When its present motion ends, if it is one of Trap.
    pub fn goes_until(&self) -> Option<Fix> {
        let Some(Motion::Ramp(timed)) = &self.motion else { return None };
        Some(timed.start + timed.curve.length())
    }

    /// Where it was at an instant of the tick, ms.
    pub fn at(&self, ms: Fix) -> Option<Fix> {
        if self.limited || self.moved {
            return None;
        }
        match self.past.as_ref().or(self.motion.as_ref()) {
            None if self.on_path => None,
            None => Some(self.x),
            Some(Motion::Ramp(timed) | Motion::Pt(timed) | Motion::Pvt(timed) | Motion::Stream(timed, _)) => {
                timed.at(ms)
            }
            Some(Motion::Slave(_)) => None,
        }
    }
}
