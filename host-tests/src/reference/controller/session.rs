//! SetTick: between two programs, while everything is at standstill.
//!
//! A client sends it when the program before it is over, and the next program begins when it has
//! been answered. How long that takes is the client's matter, and recorded. A motion is a function
//! of time, so nothing else changes.
use super::super::axis::Axis;
use super::{Reply, Value};

/// Periods that a controller takes, µs.
const PERIODS_US: std::ops::RangeInclusive<i32> = 10..=1000;
/// Ticks before it was asked for from which everything must be at standstill, or move, so that the
/// answer is known.
const AHEAD_TICKS: i64 = 2;
/// Ticks that it takes where none was recorded, until it acts and until the next program begins.
const TAKES_TICKS: [i64; 2] = [2, 6];

/// A SetTick as it went: instants in ns from the first program's zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Session {
    /// It was sent and answered.
    pub asked: i64,
    pub answered: i64,
    /// The tick from which the period is another, if one has been.
    pub acted: Option<i64>,
    /// Zero of the next program's clock.
    pub zero: i64,
}

/// The time between two programs.
pub struct Between {
    us: i32,
    session: Session,
    from: i64,
    /// Ticks with and without motion that have been looked at.
    moved: bool,
    rested: bool,
    done: bool,
}

impl Between {
    /// `runs`: something moves where it is made, up to the tick `now`.
    pub fn new(us: i32, session: Option<Session>, (now, runs): (i64, bool), tick_ns: i64) -> Between {
        let nominal = || {
            let acted = now + TAKES_TICKS[0] * tick_ns;
            let period = if PERIODS_US.contains(&us) { i64::from(us) * 1000 } else { tick_ns };
            Session { asked: now, answered: acted, acted: Some(acted), zero: acted + TAKES_TICKS[1] * period }
        };
        let session = session.unwrap_or_else(nominal);
        // After another one its answer may be there before.
        let is_over = session.answered < now;
        let (moved, rested) = (is_over && runs, is_over && !runs);
        Between { us, session, from: session.asked - AHEAD_TICKS * tick_ns, moved, rested, done: false }
    }

    /// The period from this tick on, µs, if it becomes another.
    pub fn change(&mut self, tick: i64) -> Option<i64> {
        let acts = self.session.acted == Some(tick) && PERIODS_US.contains(&self.us) && !self.moved;
        self.done |= acts;
        acts.then_some(self.us.into())
    }

    /// Takes note of a tick, and says what is open.
    pub fn look(&mut self, axes: &[Box<Axis>], now: i64) -> Option<&'static str> {
        if now < self.from || now > self.session.answered || self.done {
            return None;
        }
        let moves = axes.iter().any(|axis| axis.runs());
        self.moved |= moves;
        self.rested |= !moves;
        let unknown = self.moved && self.rested || axes.iter().any(|axis| axis.open.is_some());
        unknown.then_some("a SetTick while an axis comes to rest")
    }

    /// What it answers, when the next program begins.
    pub fn reply(&self, now: i64) -> Option<Reply> {
        let code = match () {
            () if !PERIODS_US.contains(&self.us) => 7,
            () if self.moved => 1,
            () => 0,
        };
        let reply = if code == 0 { Reply::Done(Value::None) } else { Reply::Code(code) };
        // The next program may begin on the very tick on which it acts.
        let is_over = self.session.acted.is_none_or(|acted| now > acted || now == acted && self.session.zero == acted);
        (now >= self.session.zero && is_over).then_some(reply)
    }

    pub fn zero(&self) -> i64 {
        self.session.zero
    }

    pub fn tally(&self) -> &'static str {
        match () {
            () if !PERIODS_US.contains(&self.us) => "tick periods out of range",
            () if self.moved => "tick periods refused in motion",
            () => "tick periods set between programs",
        }
    }
}
