//! The energy output of a channel as cycles of a timer that begin with light, or have none.
//!
//! In: the actions of a plan a tick. Out: cycles: length, light from the beginning on, in counts,
//! and repetitions. Owns train, pulse in progress, and the cycles that may still change. Fails
//! never.
//!
//! Each pulse begins with a cycle. A pulse that begins sooner than [`MIN_COUNTS`] after the one
//! before it, with a gap between them, would need its time: that pulse is left out. This happens
//! only if light or standby is cut within 350 ns of a pulse's beginning and the pulse has ended
//! before; carriers never come near.
use super::cycle_ring::CycleRing;
use super::cycles::{CYCLE_MAX_COUNTS, LATE_MIN_CYCLES, Lengths, Scale, long_and_two_short};
use super::delay_line::DelayLine;
use crate::laser::{Action, FINISH_NS, Pattern, PulseRate, Train};

/// The end of a period that is paused.
const NEVER_COUNTS: u64 = u64::MAX;

/// The shortest cycle, in counts: 350 ns at 240 MHz, in which DMA brings three half-words.
pub const MIN_COUNTS: u32 = 84;

state! {
    /// See the module text. Instants are counts of the timer since it began.
    #[derive(Debug, Clone)]
    pub struct PwmCycles {
        scale: Scale = scale,
        /// Where the cycle begins that is not queued yet, and where its light ends.
        begin: u64 = begin,
        until: u64 = begin,
        /// Where the last pulse begins, if it ends that cycle, unless something comes between.
        next: Option<u64> = None,
        train: Train = Train::NONE,
        pattern: Pattern = Pattern::BEGIN,
        /// A period is in progress: it began, it ends.
        runs: bool = false,
        period_begin: u64 = begin,
        period_end: u64 = begin,
        /// Without one: where the train begins.
        begins: u64 = begin,
        /// The last pulse's end.
        pulse_end: u64 = begin,
        /// The end of the known interval.
        known: u64 = begin,
    }
    /// Dark; the first cycle begins at this count.
    pub const fn from(begin: u64, scale: Scale);
}

impl PwmCycles {
    /// The end of the queued cycles.
    pub const fn queued(&self) -> u64 {
        self.begin
    }

    /// The actions of a plan for the interval from `from` to `to`, in counts. `sink` gets the
    /// cycles that are certain by it: length, light, and repetitions. An action beyond the interval
    /// takes place at its end.
    #[inline]
    pub fn take(
        &mut self,
        from: u64,
        to: u64,
        actions: impl Iterator<Item = (u32, Action)>,
        sink: &mut impl FnMut(u32, u32, u32),
    ) {
        self.known = to;
        for (at, action) in actions {
            let at = from.wrapping_add(self.scale.counts(at).into()).min(to);
            match action {
                Action::Light(train) => {
                    self.pulses_to(at, sink);
                    self.enter(at, &train, true);
                }
                Action::Dark { standby, cut } => {
                    self.pulses_to(at, sink);
                    self.enter(at, &standby, cut);
                }
                Action::Change(train) => {
                    self.pulses_to(at, sink);
                    self.change(at, &train);
                }
                Action::Rate(rate) => {
                    self.pulses_to(at, sink);
                    self.take_rate(at, &rate);
                }
                Action::Switch(_) | Action::Volts(_) => {}
            }
        }
        if !(self.is_steady() && self.periods(to, sink)) {
            self.pulses_to(to, sink);
            self.queue_certain(sink);
        }
    }

    /// The cycles of a plan that was delayed, in a ring: those of [`PwmCycles::take`].
    #[inline(always)]
    pub fn queue<const SLOTS: usize>(&mut self, from: u64, to: u64, plan: &DelayLine, ring: &mut CycleRing<SLOTS, 3>) {
        if !(plan.is_empty() && self.stay_dark(to, ring)) {
            self.take(from, to, plan.actions(), &mut |length, light, times| ring.put(length, times, [light]));
        }
    }

    /// It stays dark up to `to`. False, and nothing has changed, if something lights, or if that
    /// takes other cycles than a long one and two short ones.
    #[inline(always)]
    fn stay_dark<const SLOTS: usize>(&mut self, to: u64, ring: &mut CycleRing<SLOTS, 3>) -> bool {
        let counts = (to.saturating_sub(self.begin) as u32).saturating_sub(MIN_COUNTS);
        let is_dark = self.train.is_none() && !self.runs && self.next.is_none() && self.until <= self.begin;
        let Some(lengths) = long_and_two_short(counts, MIN_COUNTS).filter(|_| is_dark) else { return false };
        if !ring.put_three(lengths, |_| [0]) {
            return false;
        }
        (self.begin, self.known) = (self.begin.wrapping_add(counts.into()), to);
        true
    }

    /// Nothing that is not queued yet has light.
    pub fn shut_off(&mut self) {
        (self.train, self.runs, self.next) = (Train::NONE, false, None);
        (self.until, self.pulse_end, self.begins) = (self.begin, self.begin, self.begin);
        self.pattern = Pattern::BEGIN;
    }

    /// A train begins; the pulse in progress is cut, or finished if it ends soon, before it.
    fn enter(&mut self, at: u64, train: &Train, cut: bool) {
        self.begins = at;
        if self.pulse_end > at {
            if cut || self.pulse_end.wrapping_sub(at) > self.scale.counts(FINISH_NS).into() {
                self.cut(at);
            } else {
                self.begins = self.pulse_end;
            }
        }
        (self.train, self.runs, self.pattern) = (*train, false, Pattern::BEGIN);
    }

    /// The train goes on as another one.
    fn change(&mut self, at: u64, train: &Train) {
        if self.train.is_none() && !self.runs {
            self.begins = self.begins.max(at);
        }
        self.train = *train;
        if self.runs && !train.is_none() {
            if self.period_end == NEVER_COUNTS {
                // The remainder of a pause is not where another train begins.
                self.begins = at;
            }
            let end = self.period_begin.saturating_add(train.period.whole).max(at).max(self.pulse_end);
            self.period_end = self.period_end.min(end);
        }
    }

    /// Pulses go on at another rate, in phase, or pause.
    #[inline(never)]
    fn take_rate(&mut self, at: u64, rate: &PulseRate) {
        let is_paused = self.runs && self.period_end == NEVER_COUNTS;
        let left = match (self.runs, is_paused) {
            (false, _) => 0,
            // The remainder of a paused period is stored where none begins.
            (true, true) => self.begins,
            (true, false) => self.period_end.saturating_sub(at),
        };
        self.train = rate.train();
        if rate.is_pause() {
            if self.runs {
                (self.begins, self.period_end) = (left, NEVER_COUNTS);
            }
            return;
        }
        let (left, part) = rate.left(left, self.pattern.part());
        let mut next = at.saturating_add(left);
        if self.pulse_end > at && self.pulse_end >= next {
            next = next.max(at.wrapping_add(1));
            self.cut(next.wrapping_sub(1));
        }
        // The remainder of a pause is not where another train begins.
        self.begins = if self.runs { at } else { next };
        if self.runs {
            self.period_end = next
        }
        self.pattern = Pattern::of_rate(part);
    }

    /// Follows the train to `to`, not included.
    #[inline]
    fn pulses_to(&mut self, to: u64, sink: &mut impl FnMut(u32, u32, u32)) {
        // A period has at least one count, and the known interval some 10⁵.
        loop {
            if self.is_steady() {
                self.periods(to, sink);
            }
            let at = if self.runs { self.period_end } else { self.begins };
            if at >= to {
                break;
            }
            if self.train.is_none() {
                if self.runs {
                    (self.runs, self.pattern) = (false, Pattern::BEGIN);
                }
                break;
            }
            let (period, width) = self.pattern.step(&self.train);
            (self.runs, self.period_begin, self.period_end) = (true, at, at.saturating_add(period.max(1)));
            if width > 0 {
                self.pulse(at, at.saturating_add(width), sink);
            }
        }
    }

    /// Whether each period of the train can be a cycle, and the one in progress is the cycle that
    /// is not queued yet, or the next.
    #[inline(always)]
    fn is_steady(&self) -> bool {
        let periods = MIN_COUNTS as u64..(CYCLE_MAX_COUNTS as u64).wrapping_sub(1);
        self.runs
            && periods.contains(&self.train.period.whole)
            && self.next.unwrap_or(self.begin) == self.period_begin
            && periods.contains(&self.period_end.wrapping_sub(self.period_begin))
            // Its pulse was cut, or its end comes from another train: the pulse's end decides its
            // cycles.
            && self.pulse_end <= self.period_end
    }

    /// Periods of a steady train, each as a cycle, while they are certain. Returns whether the
    /// interval needs no other: they are short, and the one in progress is the cycle that is not
    /// queued yet.
    #[inline(never)]
    fn periods(&mut self, to: u64, sink: &mut impl FnMut(u32, u32, u32)) -> bool {
        // The known interval is far below 2³² counts.
        let length = self.period_end.wrapping_sub(self.period_begin) as u32;
        let whole = self.train.period.whole as u32;
        // Short cycles come after long ones.
        let is_short = length.max(whole) < 2 * MIN_COUNTS - 1;
        // The last two slots hold a period each, where they would not be short otherwise.
        let (margin, alone) = if is_short {
            (MIN_COUNTS, whole.wrapping_add(1).wrapping_mul(2))
        } else {
            (LATE_MIN_CYCLES * MIN_COUNTS, 0)
        };
        let left = (to.saturating_sub(self.period_begin) as u32).saturating_sub(margin);
        if length <= left {
            if self.next.is_some() {
                self.close(self.period_begin, sink);
            }
            // The first one may be of another train.
            sink(length, self.until.saturating_sub(self.begin) as u32, 1);
            let remainder = left.wrapping_sub(length);
            let (remainder, (length, light)) = self.pattern.queue(&self.train, remainder, alone, sink);
            let begin = self.begin.wrapping_add(left.wrapping_sub(remainder).into());
            // A cycle begins here even without light: its period is steady.
            (self.begin, self.until) = (begin, begin.wrapping_add(light.into()));
            (self.period_begin, self.period_end) = (begin, begin.wrapping_add(length.into()));
            if light > 0 {
                self.pulse_end = self.until;
            }
        }
        is_short && self.next.is_none()
    }

    /// Light from `at` to `until`: the last pulse.
    #[inline]
    fn pulse(&mut self, at: u64, until: u64, sink: &mut impl FnMut(u32, u32, u32)) {
        // What is queued already, after a restart, is dark.
        let at = at.max(self.begin);
        if let Some(next) = self.next {
            if at.wrapping_sub(next) < MIN_COUNTS.into() {
                if self.pulse_end < at {
                    self.next = Some(at);
                }
                self.pulse_end = until;
                return;
            }
            self.close(next, sink);
        }
        if self.until >= at && self.until > self.begin {
            self.until = until;
        } else if at == self.begin {
            self.until = until.max(at);
        } else {
            self.next = Some(at);
        }
        self.pulse_end = until;
    }

    /// The last pulse ends at `at`.
    fn cut(&mut self, at: u64) {
        self.pulse_end = at;
        if self.next.is_none() {
            self.until = self.until.min(at);
        }
    }

    /// Queues everything up to `at`, where a cycle begins: with the next pulse, if there is one.
    #[inline(never)]
    fn close(&mut self, at: u64, sink: &mut impl FnMut(u32, u32, u32)) {
        // The part that is not queued yet is far below 2³² counts.
        let counts = at.wrapping_sub(self.begin) as u32;
        let mut light = self.until.saturating_sub(self.begin).min(counts.into()) as u32;
        let is_late = counts.wrapping_add(LATE_MIN_CYCLES * MIN_COUNTS) > self.known.wrapping_sub(self.begin) as u32;
        for length in Lengths::of(counts, MIN_COUNTS, is_late) {
            sink(length, light.min(length), 1);
            light = light.saturating_sub(length);
        }
        self.begin = at;
        if self.next == Some(at) {
            (self.until, self.next) = (self.pulse_end, None);
        }
    }

    /// Queues what nothing unknown can change.
    #[inline]
    fn queue_certain(&mut self, sink: &mut impl FnMut(u32, u32, u32)) {
        if let Some(next) = self.next
            && next.wrapping_add(MIN_COUNTS.into()) <= self.known
        {
            self.close(next, sink);
        }
        let end = self.next.unwrap_or(self.known);
        if end.saturating_sub(self.begin) as u32 >= 2 * MIN_COUNTS {
            self.close(end.wrapping_sub(MIN_COUNTS.into()), sink);
        }
    }
}
