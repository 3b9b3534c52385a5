//! Carries out a channel's plans as `servo::laser::actions` words them: outputs as lists of events,
//! to the ns.
use super::bench::Outputs;
use host_tests::laser_model::{Edge, Ns, Span};
use servo::laser::{Action, FINISH_NS, LaserPlan, Pattern, PulseRate, Train};

/// A period that has begun.
#[derive(Debug, Clone, Copy)]
struct Period {
    begin: Ns,
    pulse_end: Ns,
    end: Ns,
}

/// Outputs of a channel and their history.
#[derive(Debug, Default)]
pub struct Player {
    train: Train,
    period: Option<Period>,
    /// A train begins here: a pulse is being finished until then.
    begins: Ns,
    /// What was left of the period when the pulses paused.
    paused: Option<u64>,
    pattern: Pattern,
    pulses: Vec<Span>,
    switch: Vec<Edge<bool>>,
    volts: Vec<Edge<i16>>,
    /// Actions to come, by instant.
    queue: Vec<(Ns, Action)>,
}

impl Player {
    /// A plan for the interval that begins at `next`, given at `now`.
    pub fn take(&mut self, now: Ns, next: Ns, plan: &LaserPlan) {
        self.run_to(now);
        if plan.safe_state {
            self.queue.clear();
            self.pulse_to(now);
            self.begin(now, Train::NONE, true);
            self.switch.push((now, false));
            self.volts.push((now, 0));
        }
        self.queue.extend(plan.actions().iter().map(|&(at, action)| (next + Ns::from(at), action)));
    }

    /// Carries out everything before this instant.
    fn run_to(&mut self, now: Ns) {
        let due: Vec<_> = self.queue.extract_if(.., |&mut (at, _)| at <= now).collect();
        for (at, action) in due {
            self.pulse_to(at);
            match action {
                Action::Switch(on) => self.switch.push((at, on)),
                Action::Volts(code) => self.volts.push((at, code)),
                Action::Light(train) => self.begin(at, train, true),
                Action::Dark { standby, cut } => self.begin(at, standby, cut),
                Action::Change(train) => self.change(at, train),
                Action::Rate(rate) => self.rate(at, &rate),
            }
        }
    }

    /// A train begins, or nothing does; the pulse in progress is cut, or finished if it ends soon.
    fn begin(&mut self, at: Ns, train: Train, cut: bool) {
        self.begins = at;
        if let Some(last) = self.pulses.last_mut().filter(|last| last.end > at) {
            if cut || last.end > at + Ns::from(FINISH_NS) {
                last.end = at;
            } else {
                self.begins = last.end;
            }
        }
        (self.train, self.period, self.paused) = (train, None, None);
        self.pattern = Pattern::BEGIN;
    }

    fn change(&mut self, at: Ns, train: Train) {
        if self.train.is_none() && self.period.is_none() {
            self.begins = self.begins.max(at);
        }
        self.train = train;
        if let Some(period) = self.period.as_mut().filter(|_| !train.is_none()) {
            let early = (period.begin + train.period.whole as Ns).max(at).max(period.pulse_end);
            period.end = period.end.min(early);
        }
    }

    fn rate(&mut self, at: Ns, rate: &PulseRate) {
        let left = match (self.paused, self.period) {
            (Some(left), _) => left,
            (None, Some(period)) => (period.end - at) as u64,
            (None, None) => 0,
        };
        self.train = rate.train();
        if rate.is_pause() {
            self.paused = self.period.map(|_| left);
            return;
        }
        self.paused = None;
        let (left, part) = rate.left(left, self.pattern.part());
        let mut next = at + Ns::try_from(left).unwrap_or(Ns::MAX / 2);
        if let Some(last) = self.pulses.last_mut().filter(|last| last.end > at && last.end >= next) {
            next = next.max(at + 1);
            last.end = next - 1;
        }
        match &mut self.period {
            Some(period) => period.end = next,
            None => self.begins = next,
        }
        self.pattern = Pattern::of_rate(part);
    }

    /// Periods that begin before this instant.
    fn pulse_to(&mut self, at: Ns) {
        if self.paused.is_some() {
            return;
        }
        loop {
            let begin = match self.period {
                Some(period) => period.end,
                None => self.begins,
            };
            if begin >= at {
                return;
            }
            if self.train.is_none() {
                (self.period, self.begins) = (None, at);
                self.pattern = Pattern::BEGIN;
                return;
            }
            let (period, width) = self.pattern.step(&self.train);
            let (pulse_end, end) = (begin + width as Ns, begin + period as Ns);
            if pulse_end > begin {
                self.pulses.push(Span { begin, end: pulse_end });
            }
            self.period = Some(Period { begin, pulse_end, end });
        }
    }

    /// The edges before this instant.
    pub fn finish(mut self, horizon: Ns) -> Outputs {
        self.run_to(horizon);
        self.pulse_to(horizon);
        let mut energy = Vec::new();
        for pulse in self.pulses.iter().filter(|pulse| pulse.end > pulse.begin) {
            match energy.last_mut() {
                Some((end, false)) if *end >= pulse.begin => *end = pulse.end.max(*end),
                _ => energy.extend([(pulse.begin, true), (pulse.end, false)]),
            }
        }
        energy.retain(|&(at, _)| at < horizon);
        let mut switch = settled(self.switch, false);
        switch.retain(|&(at, _)| at < horizon);
        let mut volts = settled(self.volts, 0);
        volts.retain(|&(at, _)| at < horizon);
        Outputs { energy, switch, volts }
    }
}

/// What remains of a list of levels: the last of an instant, and only where it differs from what
/// was.
pub fn settled<T: Copy + PartialEq>(edges: Vec<Edge<T>>, before: T) -> Vec<Edge<T>> {
    let mut left: Vec<Edge<T>> = Vec::new();
    for (at, level) in edges {
        left.pop_if(|last| last.0 == at);
        let last = left.last().map_or(before, |&(_, level)| level);
        if last != level {
            left.push((at, level));
        }
    }
    left
}
