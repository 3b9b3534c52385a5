//! The log of events that no command caused, for the host: when, to what, why.
//!
//! In: events of the tick, its views, the link's state. Out: the last [`EVENTS_KEPT`] of them, and
//! how many there were. Owns those. Fails: never; new events replace the oldest. A stop has its
//! tick's time. Any other event has the time of the first view that showed it, which is the same
//! unless the link task was late.
use heapless::Deque;
use protocol::command::EventItem;
use protocol::values::event;
use servo::laser::{CHANNELS, Ignored};
use servo::units::Ns;
use servo::view::{StopReason, View};

/// Events that are kept.
pub const EVENTS_KEPT: usize = 32;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// An axis came to standstill, for a `StopReason`.
    AxisStopped = event::AXIS_STOPPED as isize,
    /// A coordinate system came to standstill.
    CrdStopped = event::CRD_STOPPED as isize,
    /// A laser channel went dark, for a `Cause`, or was cleared: no cause.
    Laser = event::LASER as isize,
    /// The host link is lost (1), or is back (0).
    Link = event::LINK as isize,
    /// So many ticks took too long.
    Overrun = event::OVERRUN as isize,
    /// So many events of the tick were lost.
    Lost = event::LOST as isize,
    /// A command that had been admitted did nothing to a laser channel, for a reason of
    /// `servo::laser::Ignored`.
    Ignored = event::IGNORED as isize,
    /// The lasers were shut off, for a [`ShutOff`].
    ShutOff = event::SHUT_OFF as isize,
    /// The rate of a laser's light reached the width of its pulses, which is limited since then
    /// (SPEC 6); how often.
    Limited = event::LIMITED as isize,
}

/// Why the lasers were shut off without a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShutOff {
    /// An abort.
    Abort = 1,
    /// A new session began.
    NewSession = 2,
}

/// The log.
#[derive(Default)]
pub struct Log {
    items: Deque<EventItem, EVENTS_KEPT>,
    pub total: u32,
    faults: [u16; CHANNELS],
    ignored: [u8; CHANNELS],
    limits: [u8; CHANNELS],
    overruns: u32,
    lost: u32,
}

impl Log {
    /// Adds an event.
    pub fn put(&mut self, at: Ns, kind: EventKind, of: u8, reason: u16) {
        if self.items.is_full() {
            self.items.pop_front();
        }
        let item = EventItem { time_ns: at.0.into(), kind: kind as u8, of, reason: reason.into() };
        if self.items.push_back(item).is_ok() {
            self.total = self.total.wrapping_add(1);
        }
    }

    /// Something came to standstill; an end as planned is no event.
    pub fn stopped(&mut self, at: Ns, kind: EventKind, index: usize, reason: StopReason) {
        if reason != StopReason::Completed {
            self.put(at, kind, (index as u8).saturating_add(1), reason as u16);
        }
    }

    /// Takes the events that the newest view shows.
    pub fn see<const AXES: usize>(&mut self, view: &View<AXES>) {
        for (channel, laser) in (0..).zip(&view.lasers) {
            let fault = laser.fault as u16;
            if let Some(before) = self.faults.get_mut(usize::from(channel))
                && *before != fault
            {
                *before = fault;
                self.put(view.now, EventKind::Laser, channel, fault);
            }
        }
        for (channel, laser) in (0..).zip(&view.lasers) {
            if let Some(before) = self.ignored.get_mut(usize::from(channel))
                && core::mem::replace(before, laser.ignored_count) != laser.ignored_count
                // The fault is an event.
                && laser.ignored != Ignored::Fault
            {
                self.put(view.now, EventKind::Ignored, channel, laser.ignored as u16);
            }
        }
        for (channel, laser) in (0..).zip(&view.lasers) {
            if let Some(before) = self.limits.get_mut(usize::from(channel)) {
                // Every second change is a beginning.
                let begun = |count: u8| count.wrapping_add(1) >> 1;
                let times = begun(laser.limits).wrapping_sub(begun(core::mem::replace(before, laser.limits))) & 127;
                if times != 0 {
                    self.limited(view.now, channel, times.into());
                }
            }
        }
        let more = |now: u32, before: &mut u32| now.wrapping_sub(core::mem::replace(before, now)).min(0xffff) as u16;
        let (overruns, lost) = (more(view.overruns, &mut self.overruns), more(view.events_lost, &mut self.lost));
        if overruns != 0 {
            self.put(view.now, EventKind::Overrun, 0, overruns);
        }
        if lost != 0 {
            self.put(view.now, EventKind::Lost, 0, lost);
        }
    }

    /// Limited once more: one event counts all in a row.
    fn limited(&mut self, at: Ns, channel: u8, times: u16) {
        match self.items.back_mut() {
            Some(newest) if (newest.kind, newest.of) == (EventKind::Limited as u8, channel) => {
                newest.reason = newest.reason.get().saturating_add(times).into();
            }
            _ => self.put(at, EventKind::Limited, channel, times),
        }
    }

    /// Those that are kept, the oldest first.
    pub fn items(&self) -> impl Iterator<Item = &EventItem> {
        self.items.iter()
    }
}
