//! The output stage of a laser channel: what timers and a DAC make of the tick's plans.
//!
//! In: a [`LaserPlan`] a tick, the interlock. Out: every edge, as [`SignalChange`]s to the ns, if
//! the caller takes them. Owns the pulse in progress, the train, switch, DAC, and the actions that
//! are still to come. It goes from action to action in closed form, so that the cost of a train
//! does not depend on its number of pulses. Fails never: it holds the actions of two plans, and
//! more never wait; further ones are dropped.
use crate::pulses::{Burst, Remainder};
use servo::laser::{Action, FINISH_NS, LaserPlan, PLAN_ACTIONS, PulseRate, Train};

/// A change of an output. Instants are ns of the clock of the plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalChange {
    /// The switch output went to this level; true is active.
    Switch {
        /// Instant.
        at: u64,
        /// New level.
        level: bool,
    },
    /// The energy output went to this level: one edge of a pulse that was not over when the first
    /// one was reported.
    Energy {
        /// Instant.
        at: u64,
        /// New level.
        level: bool,
    },
    /// Whole pulses of the energy output.
    Pulses(Burst),
    /// The analog output went to this voltage.
    Dac {
        /// Instant.
        at: u64,
        /// Code: −32768…32767 is −10…10 V.
        code: i16,
    },
}

/// End of a period that does not end.
const NEVER_NS: u64 = u64::MAX;

/// A pulse that has begun.
#[derive(Debug, Clone, Copy)]
struct Pulse {
    begin: u64,
    end: u64,
    /// Its beginning has been reported.
    reported: bool,
}

/// Actions of the interval in force and of the next one.
const WAITING_ACTIONS: usize = 2 * PLAN_ACTIONS;

/// A channel's outputs.
#[derive(Debug, Clone)]
pub struct OutputStage {
    switch: bool,
    dac: i16,
    train: Train,
    /// Beginning and end of the period in progress.
    period: Option<(u64, u64)>,
    /// Without one: the instant at which the train begins.
    begins: u64,
    period_remainder: Remainder,
    width_remainder: Remainder,
    /// Counts of width that exceeded the last period.
    owed: u64,
    /// The last pulse, until it is over.
    pulse: Option<Pulse>,
    /// The interlock holds energy and switch in the safe state, whatever the plans are.
    held: bool,
    waiting: [(u64, Action); WAITING_ACTIONS],
    first: usize,
    end: usize,
    /// A last pulse is finished if it ends within this time.
    finish: u64,
}

impl OutputStage {
    /// In the safe state; a count is a ns.
    pub const fn new() -> OutputStage {
        OutputStage::counting(FINISH_NS as u64)
    }

    /// In the safe state, in counts of another clock; `finish` is [`FINISH_NS`] in them. Instants,
    /// widths and periods are such counts.
    pub const fn counting(finish: u64) -> OutputStage {
        OutputStage {
            switch: false,
            dac: 0,
            train: Train::NONE,
            period: None,
            begins: 0,
            period_remainder: Remainder::NONE,
            width_remainder: Remainder::NONE,
            owed: 0,
            pulse: None,
            held: false,
            waiting: [(0, Action::Switch(false)); WAITING_ACTIONS],
            first: 0,
            end: 0,
            finish,
        }
    }

    /// Takes at `now` a plan for the interval that begins at `next`. `sink` gets the changes before
    /// `now`.
    #[inline]
    pub fn take(&mut self, now: u64, next: u64, plan: &LaserPlan, mut sink: impl FnMut(SignalChange)) {
        if !plan.safe_state && plan.actions().is_empty() {
            return;
        }
        self.run_to(now, &mut sink);
        if plan.safe_state {
            self.safe_state(now, &mut sink);
        }
        for (at, action) in plan.actions() {
            self.push(next.saturating_add(u64::from(*at)), *action);
        }
    }

    /// The safe state at `now`; drops waiting actions. `sink` gets the changes before `now`.
    pub fn safe_state(&mut self, now: u64, sink: &mut impl FnMut(SignalChange)) {
        self.run_to(now, sink);
        (self.first, self.end) = (0, 0);
        self.end_pulses(now, sink);
        self.volts(now, 0, sink);
    }

    /// The interlock, in hardware: energy and switch in the safe state from `now` on, as long as it
    /// is active. The DAC continues with its plan.
    pub fn interlock(&mut self, now: u64, active: bool, sink: &mut impl FnMut(SignalChange)) {
        self.held = active;
        if active {
            self.run_to(now, sink);
            self.keep_volts();
            self.end_pulses(now, sink);
        }
    }

    /// Drops waiting actions, except those of the DAC.
    fn keep_volts(&mut self) {
        let waiting = self.first..self.end;
        (self.first, self.end) = (0, 0);
        for from in waiting {
            if let Some(&volts @ (_, Action::Volts(_))) = self.waiting.get(from)
                && let Some(place) = self.waiting.get_mut(self.end)
            {
                *place = volts;
                self.end = self.end.wrapping_add(1);
            }
        }
    }

    fn end_pulses(&mut self, now: u64, sink: &mut impl FnMut(SignalChange)) {
        self.begin(now, Train::NONE, true);
        self.pulses_to(now, sink);
        self.switch(now, false, sink);
    }

    /// Adds an action at `at`, which is not before the last one.
    pub fn push(&mut self, at: u64, action: Action) {
        if self.end == self.waiting.len() {
            self.waiting.copy_within(self.first.., 0);
            self.end = self.end.saturating_sub(self.first);
            self.first = 0;
        }
        let held = self.held && !matches!(action, Action::Volts(_));
        if let Some(place) = self.waiting.get_mut(self.end).filter(|_| !held) {
            *place = (at, action);
            self.end = self.end.wrapping_add(1);
        }
    }

    /// Runs to `to`, which never decreases. `sink` gets the changes before `to`, and a pulse's end
    /// at `to`, in the order of time for each output.
    pub fn run_to(&mut self, to: u64, sink: &mut impl FnMut(SignalChange)) {
        while let Some(&(at, action)) = self.waiting.get(self.first..self.end).and_then(|left| left.first())
            && at < to
        {
            self.first = self.first.wrapping_add(1);
            self.pulses_to(at, sink);
            match action {
                Action::Switch(level) => self.switch(at, level, sink),
                Action::Volts(code) => self.volts(at, code, sink),
                Action::Light(train) => self.begin(at, train, true),
                Action::Dark { standby, cut } => self.begin(at, standby, cut),
                Action::Change(train) => self.change(at, train),
                Action::Rate(rate) => self.rate(at, &rate),
            }
        }
        if self.first == self.end {
            (self.first, self.end) = (0, 0);
        }
        self.pulses_to(to, sink);
    }

    fn switch(&mut self, at: u64, level: bool, sink: &mut impl FnMut(SignalChange)) {
        if self.switch != level {
            self.switch = level;
            sink(SignalChange::Switch { at, level });
        }
    }

    fn volts(&mut self, at: u64, code: i16, sink: &mut impl FnMut(SignalChange)) {
        if self.dac != code {
            self.dac = code;
            sink(SignalChange::Dac { at, code });
        }
    }

    /// A train begins. Before it, the pulse in progress is cut, or finished if it ends soon.
    fn begin(&mut self, at: u64, train: Train, cut: bool) {
        self.begins = at;
        if let Some(pulse) = self.pulse.as_mut().filter(|pulse| pulse.end > at) {
            if cut || pulse.end.wrapping_sub(at) > self.finish {
                pulse.end = at;
            } else {
                self.begins = pulse.end;
            }
        }
        (self.train, self.period) = (train, None);
        self.begin_pattern();
    }

    fn begin_pattern(&mut self) {
        (self.period_remainder, self.width_remainder, self.owed) = (Remainder::NONE, Remainder::NONE, 0);
    }

    /// The train continues as another one.
    fn change(&mut self, at: u64, train: Train) {
        if self.train.is_none() && self.period.is_none() {
            self.begins = self.begins.max(at);
        }
        self.train = train;
        if train.is_none() {
            return;
        }
        let pulse_end = self.pulse.map_or(0, |pulse| pulse.end);
        if let Some((begin, end)) = &mut self.period {
            *end = (*end).min(begin.saturating_add(train.period.whole).max(at).max(pulse_end));
        }
    }

    /// Pulses continue at another rate, in phase, or pause. In a pause the period has no end, and
    /// its remainder is kept.
    fn rate(&mut self, at: u64, rate: &PulseRate) {
        let left = match self.period {
            None => 0,
            Some((_, NEVER_NS)) => self.begins,
            Some((_, end)) => end.saturating_sub(at),
        };
        self.train = rate.train();
        if rate.is_pause() {
            if let Some((_, end)) = &mut self.period {
                (self.begins, *end) = (left, NEVER_NS);
            }
            return;
        }
        let (left, part) = rate.left(left, self.period_remainder.part());
        let mut next = at.saturating_add(left);
        if let Some(pulse) = self.pulse.as_mut().filter(|pulse| pulse.end > at && pulse.end >= next) {
            next = next.max(at.wrapping_add(1));
            pulse.end = next.wrapping_sub(1);
        }
        match &mut self.period {
            Some((_, end)) => *end = next,
            None => self.begins = next,
        }
        self.begin_pattern();
        self.period_remainder = Remainder::of_rate(part);
    }

    /// Follows the train to `to`, not included.
    fn pulses_to(&mut self, to: u64, sink: &mut impl FnMut(SignalChange)) {
        loop {
            let at = self.period.map_or(self.begins, |(_, end)| end);
            if at >= to {
                break;
            }
            if self.train.is_none() {
                (self.period, self.begins) = (None, to);
                self.begin_pattern();
                break;
            }
            self.finish_pulse(at, sink);
            self.periods(at, to, sink);
        }
        self.finish_pulse(to, sink);
    }

    /// One period from `at` on, or all that begin before `to`: the last pulse is in progress then.
    fn periods(&mut self, at: u64, to: u64, sink: &mut impl FnMut(SignalChange)) {
        let train = self.train;
        let Train { period, width } = train;
        let is_full = train.is_full();
        if !self.width_remainder.goes_on(width) {
            self.owed = 0;
        }
        let (period_remainder, width_remainder) = (self.period_remainder, self.width_remainder);
        let mut last = Burst { at, count: u64::MAX, train, period_remainder, width_remainder };
        // A width just below the period may be too long for one: those go one by one.
        if self.owed == 0 && (width.whole < period.whole || is_full) {
            // All but the last one are over.
            let whole = last.first_from(to).saturating_sub(1);
            if whole > 0 && !train.is_silent() {
                sink(SignalChange::Pulses(Burst { count: whole, ..last }));
            }
            last = last.skip(whole);
        }
        let end = last.start(1);
        let length = end.wrapping_sub(last.at);
        let wanted = if is_full { length } else { last.width_remainder.sum(width, 1).saturating_add(self.owed) };
        let pulse = wanted.min(length);
        self.owed = wanted.wrapping_sub(pulse);
        self.pulse =
            (pulse > 0).then_some(Pulse { begin: last.at, end: last.at.saturating_add(pulse), reported: false });
        self.period = Some((last.at, end));
        let after = last.skip(1);
        (self.period_remainder, self.width_remainder) = (after.period_remainder, after.width_remainder);
    }

    /// Reports of the pulse in progress what is certain at `to`.
    fn finish_pulse(&mut self, to: u64, sink: &mut impl FnMut(SignalChange)) {
        let Some(pulse) = &mut self.pulse else { return };
        let Pulse { begin, end, reported } = *pulse;
        match (end <= to, reported) {
            (true, true) => sink(SignalChange::Energy { at: end, level: false }),
            (true, false) if end > begin => sink(SignalChange::Pulses(Burst::single(begin, end.wrapping_sub(begin)))),
            (true, false) => {}
            (false, false) if begin < to => {
                pulse.reported = true;
                sink(SignalChange::Energy { at: begin, level: true });
            }
            (false, _) => {}
        }
        if end <= to {
            self.pulse = None;
        }
    }

    /// Levels at the instant to which it has run.
    pub fn levels(&self) -> ChannelLevels {
        ChannelLevels { switch: self.switch, energy: self.pulse.is_some_and(|pulse| pulse.reported), dac: self.dac }
    }
}

impl Default for OutputStage {
    fn default() -> Self {
        Self::new()
    }
}

/// Levels of a channel's outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ChannelLevels {
    /// The switch output is active.
    pub switch: bool,
    /// The energy output is active.
    pub energy: bool,
    /// The analog output: −32768…32767 is −10…10 V.
    pub dac: i16,
}

#[cfg(test)]
mod tests;
