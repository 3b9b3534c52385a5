//! Changes that entries of a path carry, and the event queue of the coming interval.
//!
//! In: admitted changes; words of an entry; instants. Out: the same changes, in the order of time.
//! Owns: the events within an interval. Fails: words that are none of these mean nothing; a full
//! queue says so.
use super::light_owner::{PathRun, StandstillCause};
use super::power::{Power, PowerBounds};
use super::power_tables::Curve;
use super::velocity_follow::{Ratio, SpeedSource};
use super::{Cause, NEVER};
use crate::path::LASER_WORDS;
use crate::units::{Crd, Ns};

/// A change of a channel that takes effect at the exact instant of its position in a path (SPEC 4,
/// "Buffered laser").
#[allow(missing_docs, reason = "each variant's text names its fields")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Buffered {
    /// BufLaserOn, BufLaserOff: a gate command, with the delay in force then.
    Gate { on: bool },
    /// BufLaserPrfCmd. It ends a velocity follow of the GUS family.
    Direct { power: Power },
    /// BufLaserFollowMode: which speed counts from then on; a start power is the direct power from
    /// then on.
    FollowMode { source: SpeedSource, start: Option<Power> },
    /// BufLaserFollowRatio: the follow begins, with the source chosen before.
    FollowRatio { ratio: Ratio, bounds: PowerBounds },
    /// BufLaserPrfFollow: the follow begins, of the planned speed.
    PrfFollow { ratio: Ratio, bounds: PowerBounds },
    /// BufLaserFollowTable: the follow begins, with the source chosen before and the powers of a
    /// table.
    FollowTable { table: Curve, bounds: PowerBounds },
    /// BufLaserFollowOff.
    FollowOff,
}

mod code {
    pub const OFF: u8 = 1;
    pub const ON: u8 = 2;
    pub const DIRECT: u8 = 3;
    pub const MODE: u8 = 4;
    pub const RATIO: u8 = 5;
    pub const PRF_FOLLOW: u8 = 6;
    pub const TABLE: u8 = 7;
    pub const FOLLOW_OFF: u8 = 8;
}

const NONE: [u32; LASER_WORDS] = [0; LASER_WORDS];

fn split(x: u64) -> [u32; 2] {
    [x as u32, (x >> 32) as u32]
}

fn join(low: u32, high: u32) -> u64 {
    (high as u64) << 32 | low as u64
}

fn power(low: u32, high: u32) -> Power {
    Power::nearest(join(low, high) as i64)
}

impl Buffered {
    /// Whether it begins a velocity follow.
    pub(super) fn begins_follow(self) -> bool {
        matches!(self, Buffered::FollowRatio { .. } | Buffered::PrfFollow { .. } | Buffered::FollowTable { .. })
    }

    /// In the form of an entry of a path: its code and its words (`path::PathEntry::laser`).
    pub fn pack(self) -> (u8, [u32; LASER_WORDS]) {
        let long = |first: u64, bounds: PowerBounds| {
            let ([a, b], [c, d]) = (split(first), split(bounds.min().raw() as u64));
            let [e, f] = split(bounds.max().raw() as u64);
            [a, b, c, d, e, f]
        };
        let short = |low: u64, mark: u32| {
            let [a, b] = split(low);
            [a, b, mark, 0, 0, 0]
        };
        match self {
            Buffered::Gate { on: false } => (code::OFF, NONE),
            Buffered::Gate { on: true } => (code::ON, NONE),
            Buffered::Direct { power } => (code::DIRECT, short(power.raw() as u64, 0)),
            Buffered::FollowMode { source, start } => {
                let marks = (source == SpeedSource::Encoder) as u32 | (start.is_some() as u32) << 1;
                (code::MODE, short(start.map_or(0, Power::raw) as u64, marks))
            }
            Buffered::FollowRatio { ratio, bounds } => (code::RATIO, long(ratio.bits(), bounds)),
            Buffered::PrfFollow { ratio, bounds } => (code::PRF_FOLLOW, long(ratio.bits(), bounds)),
            Buffered::FollowTable { table, bounds } => (code::TABLE, long(table.index() as u64, bounds)),
            Buffered::FollowOff => (code::FOLLOW_OFF, NONE),
        }
    }

    /// The inverse of [`Buffered::pack`].
    pub(super) fn unpack(code: u8, words: &[u32; LASER_WORDS]) -> Option<Buffered> {
        let [a, b, c, d, e, f] = *words;
        let bounds = || PowerBounds::again(power(e, f), power(c, d));
        let ratio = || Ratio::admit(join(a, b)).ok();
        Some(match code {
            code::OFF => Buffered::Gate { on: false },
            code::ON => Buffered::Gate { on: true },
            code::DIRECT => Buffered::Direct { power: power(a, b) },
            code::MODE => Buffered::FollowMode {
                source: if c & 1 == 1 { SpeedSource::Encoder } else { SpeedSource::Planned },
                start: (c & 2 == 2).then(|| power(a, b)),
            },
            code::RATIO => Buffered::FollowRatio { ratio: ratio()?, bounds: bounds() },
            code::PRF_FOLLOW => Buffered::PrfFollow { ratio: ratio()?, bounds: bounds() },
            code::TABLE => Buffered::FollowTable { table: Curve::from_index(a as u8)?, bounds: bounds() },
            code::FOLLOW_OFF => Buffered::FollowOff,
            _ => return None,
        })
    }

    /// Whether it may begin a follow or choose its speed.
    pub(super) fn follows(&self) -> bool {
        matches!(
            self,
            Buffered::FollowMode { .. }
                | Buffered::FollowRatio { .. }
                | Buffered::PrfFollow { .. }
                | Buffered::FollowTable { .. }
        )
    }
}

/// What happens to a channel at an instant within an interval.
#[derive(Debug, Clone, Copy)]
pub(super) enum ChannelEvent {
    /// An entry of a path takes effect.
    Change(PathRun, Buffered),
    /// A path comes to standstill; if it fails, the channels that are mapped to it go dark for this
    /// cause.
    Standstill(PathRun, StandstillCause, Cause),
}

/// Events that an interval may have: a full vertex of one path and some of the others', and the
/// ends of all paths.
const INTERVAL_EVENTS: usize = 48;
/// Slots reserved for ends of paths.
const STANDSTILLS: usize = 2 * Crd::MAX;
const _: () = assert!(INTERVAL_EVENTS >= crate::path::EFFECTS as usize + STANDSTILLS);

/// The content of an empty slot.
const NO_EVENT: ChannelEvent =
    ChannelEvent::Standstill(PathRun { crd: Crd::FIRST, fifo: 0 }, StandstillCause::RanOut, Cause::None);

/// The events of an interval, in the order of time; those of an instant in the order of their
/// arrival.
#[derive(Debug)]
pub(super) struct EventQueue {
    /// The instant of the first one, or [`NEVER`].
    pub(super) next: Ns,
    first: usize,
    len: usize,
    events: [(Ns, ChannelEvent); INTERVAL_EVENTS],
}

/// No slot left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Full;

impl EventQueue {
    /// Nothing to come.
    pub(super) const EMPTY: EventQueue =
        EventQueue { next: NEVER, first: 0, len: 0, events: [(NEVER, NO_EVENT); INTERVAL_EVENTS] };

    /// Whether there is none.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.first == self.len
    }

    /// Whether one of them may begin a follow or choose its speed.
    pub(super) fn follows(&self) -> bool {
        let mut events = self.events.get(self.first..self.len).unwrap_or_default().iter();
        events.any(|(_, event)| matches!(event, ChannelEvent::Change(_, change) if change.follows()))
    }

    /// Whether there is a slot for an entry of a path.
    #[inline]
    pub(super) fn has_room(&self) -> bool {
        let len = if self.is_empty() { 0 } else { self.len };
        len.wrapping_add(STANDSTILLS) < INTERVAL_EVENTS
    }

    /// One more.
    pub(super) fn put(&mut self, at: Ns, event: ChannelEvent) -> Result<(), Full> {
        if self.first == self.len {
            (self.first, self.len) = (0, 0);
        }
        let mut slot = self.len;
        if slot >= INTERVAL_EVENTS {
            return Err(Full);
        }
        while let Some(before) = slot.checked_sub(1).filter(|before| *before >= self.first)
            && let Some(other) = self.events.get(before).copied().filter(|other| other.0 > at)
        {
            if let Some(to) = self.events.get_mut(slot) {
                *to = other;
            }
            slot = before;
        }
        if let Some(to) = self.events.get_mut(slot) {
            *to = (at, event);
        }
        self.len = self.len.wrapping_add(1);
        self.look();
        Ok(())
    }

    /// The first one, if it is due.
    pub(super) fn take(&mut self, now: Ns) -> Option<ChannelEvent> {
        let (_, event) = self.events.get(self.first).copied().filter(|_| self.next <= now)?;
        self.first = self.first.wrapping_add(1);
        self.look();
        Some(event)
    }

    fn look(&mut self) {
        let pending = self.first < self.len;
        self.next = self.events.get(self.first).map_or(NEVER, |(at, _)| if pending { *at } else { NEVER });
    }
}
