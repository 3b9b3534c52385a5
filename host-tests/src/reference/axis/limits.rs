//! What holds an axis: soft limits, limit switches, the drive's alarm. And why it came to
//! standstill.
use super::super::number::Fix;
use super::super::slave::NEAR;
use super::{Axis, Mode, Motion};

pub const ALARM: u32 = 1 << 1;
pub const POSITIVE: u32 = 1 << 5;
pub const NEGATIVE: u32 = 1 << 6;

/// Types of inputs of an axis, as SimInput and GetDi number them.
pub mod terminal {
    pub const POSITIVE: i16 = 0;
    pub const NEGATIVE: i16 = 1;
    pub const ALARM: i16 = 2;
    pub const HOME: i16 = 3;
    pub const ARRIVE: i16 = 5;
}

/// Why an axis came to standstill, as GetStopReason numbers it (docs/c.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    Nothing = 0,
    End = 1,
    Smooth = 2,
    Abrupt = 3,
    Positive = 4,
    Negative = 5,
    SoftPositive = 6,
    SoftNegative = 7,
    Alarm = 8,
    Underrun = 10,
    ServoOff = 12,
    Reset = 14,
    TimedOut = 15,
    Abort = 18,
    Interlock = 19,
}

/// Inputs of an axis. All of them are active high at power-on.
#[derive(Debug, Clone, Copy)]
pub struct Terminals {
    /// Bit k is the level of the input of type k.
    pub levels: u8,
    /// Limit switches and alarm that count, likewise.
    pub on: u8,
    /// LmtSns: limit switches that are active low, likewise.
    pub sense: u8,
    /// Status bits of those that are active, as the tick sees them.
    pub active: u32,
    /// Home as the tick sees it.
    home: bool,
    pub armed: bool,
    /// It waits for an index edge, and was asked for one in this tick.
    pub index: [bool; 2],
    /// The encoder's reading at the edge of home or of the index.
    pub captured: Option<Fix>,
}

impl Default for Terminals {
    /// At power-on: low, and all of them count.
    fn default() -> Terminals {
        Terminals {
            levels: 0,
            on: 7,
            sense: 0,
            active: 0,
            home: false,
            armed: false,
            index: [false; 2],
            captured: None,
        }
    }
}

/// Counts from one index edge to the next.
const INDEX_COUNTS: i64 = 10_000;

/// The last count of an index edge that is not `before` itself, on the way from it to `now`.
fn index_edge(before: i64, now: i64) -> Option<i64> {
    let edges = before.min(now) / INDEX_COUNTS - 1..=before.max(now) / INDEX_COUNTS + 1;
    let passed = |edge: &i64| *edge != before && (before.min(now)..=before.max(now)).contains(edge);
    edges.map(|edge| edge * INDEX_COUNTS).filter(passed).min_by_key(|edge| (now - edge).abs())
}

impl Axis {
    pub fn is_alarmed(&self) -> bool {
        self.terminals.active & ALARM != 0
    }

    /// An alarm stops it on the tick, wherever it goes.
    pub(super) fn alarm(&mut self) {
        if self.driven {
            self.unsaid = Some("an alarm of an axis on a path");
            return;
        }
        self.head.clear();
        self.halt(Why::Alarm);
        self.doubt = false;
    }

    /// The inputs of a tick.
    fn watch(&mut self) {
        let of = &mut self.terminals;
        let active = (of.levels ^ of.sense) & of.on;
        let bit = |kind: i16, bit: u32| if active >> kind & 1 == 1 { bit } else { 0 };
        of.active = bit(terminal::POSITIVE, POSITIVE) | bit(terminal::NEGATIVE, NEGATIVE) | bit(terminal::ALARM, ALARM);
        let home = of.levels >> terminal::HOME & 1 == 1;
        if home && !of.home && of.armed {
            of.armed = false;
            of.captured = Some(self.encoder[1] - self.encoder_zero);
        }
        of.home = home;
        let [awaited, asked] = of.index;
        let [before, now] = self.encoder.map(|count| count.to_f64() as i64);
        if awaited
            && asked
            && let Some(edge) = index_edge(before, now)
        {
            of.index[0] = false;
            of.captured = Some(Fix::whole(edge) - self.encoder_zero);
        }
        of.index[1] = awaited;
    }

    /// The check of a tick before its calls. A limit or an alarm that appears latches its bit
    /// and refuses starts from then on until ClrSts. Returns those that are new.
    pub fn sample(&mut self) -> u32 {
        self.watch();
        let causes = self.terminals.active | if self.runs() { 0 } else { self.beyond() };
        let fresh = causes & !self.causes;
        // An alarm refuses starts as long as it is there.
        self.blocks |= fresh | causes & ALARM;
        self.causes = causes;
        self.latched |= causes;
        fresh
    }

    /// Limits beyond which it is.
    pub fn beyond(&self) -> u32 {
        let (top, bottom) = self.limits();
        let above = if top.is_some_and(|top| self.x > top) { POSITIVE } else { 0 };
        let below = if bottom.is_some_and(|bottom| self.x < bottom) { NEGATIVE } else { 0 };
        above | below
    }

    /// Whether a position lies beyond a soft limit.
    pub fn is_beyond(&self, x: Fix) -> bool {
        let (top, bottom) = self.limits();
        top.is_some_and(|top| x > top) || bottom.is_some_and(|bottom| x < bottom)
    }

    /// ClrSts.
    pub fn clear(&mut self) {
        (self.latched, self.blocks) = (self.causes, self.causes & ALARM);
    }

    /// Places of the soft limits, upper and lower, as machine positions.
    fn limits(&self) -> (Option<Fix>, Option<Fix>) {
        let limit = |pulses: i32, off: i32| (pulses != off).then(|| Fix::whole(pulses.into()) + self.zero);
        (limit(self.soft.0, i32::MAX), limit(self.soft.1, i32::MIN))
    }

    /// No planned position of a tick is further beyond a soft limit.
    pub(super) fn hold(&mut self) {
        let (top, bottom) = self.limits();
        let (start, at) = (self.track[0], self.x);
        let brink = |limit: Option<Fix>| limit.is_some_and(|limit| at != limit && (at - limit).abs() < NEAR);
        self.brink = at != start && (brink(top) || brink(bottom));
        let over = match (top, bottom) {
            _ if self.terminals.active & POSITIVE != 0 && at > start => Some((start, POSITIVE, Why::Positive)),
            _ if self.terminals.active & NEGATIVE != 0 && at < start => Some((start, NEGATIVE, Why::Negative)),
            (Some(top), _) if at > top && at > start => Some((top.max(start), POSITIVE, Why::SoftPositive)),
            (_, Some(bottom)) if at < bottom && at < start => Some((bottom.min(start), NEGATIVE, Why::SoftNegative)),
            _ => None,
        };
        self.brink |= over.is_some() && (at - start).abs() < NEAR;
        // A path may come to a limit between two ticks, at a corner.
        let beyond = |x: Fix| {
            x > start && (top.is_some_and(|top| x > top) || self.terminals.active & POSITIVE != 0)
                || x < start && (bottom.is_some_and(|bottom| x < bottom) || self.terminals.active & NEGATIVE != 0)
        };
        self.limited = over.is_some() || self.on_path && self.track.iter().any(|x| beyond(*x));
        if let Some((at, bit, why)) = over {
            self.track = vec![start, at];
            self.times = vec![self.times[0], self.times[self.times.len() - 1]];
            self.past = self.motion.clone().or(self.past.take());
            self.x = at;
            self.latched |= bit;
            self.blocks |= bit;
            self.broken |= matches!(self.motion, Some(Motion::Stream(..)));
            self.halt(why);
            self.why = Some(why);
            // By itself, and not by a call of this instant.
            (self.ended, self.halted, self.doubt) = (true, false, false);
        }
    }

    /// Whether an Update moves towards a limit that the axis has reached.
    pub fn obstructed(&self) -> bool {
        let up = match self.mode {
            Mode::Jog => Fix::of_f64(self.speed),
            _ => Fix::whole(self.target.into()) - self.name(),
        };
        let (top, bottom) = self.limits();
        let is_active = |switch: u32| self.terminals.active & switch != 0;
        up > Fix::ZERO && (top.is_some_and(|top| self.x >= top) || is_active(POSITIVE))
            || up < Fix::ZERO && (bottom.is_some_and(|bottom| self.x <= bottom) || is_active(NEGATIVE))
    }
}
