//! A laser channel by SPEC 6: the independent model for `servo::laser`, written without its code.
//!
//! In: a whole job as a list of commands and the instants at which they act. Out: the outputs of
//! the channel, as lists of exact events over the whole job. Owns nothing. Fails never. There are
//! no ticks, no plans and no running state: each output is derived from the list in passes, so that
//! a rule of SPEC 6 is one line here. Where SPEC 6 is silent, the readings of `docs/laser.md` hold
//! ("reading 3").
//!
//! Time is in ns and a timer counts ns, so that edges are whole numbers.
mod settings;

use num_rational::Ratio;
pub use settings::Train;
use settings::{Settings, kind, times, whole};

/// An instant or a duration, ns.
pub type Ns = i64;
/// A number without rounding: power, frequency, period.
pub type Exact = Ratio<i128>;

/// Where the two manuals differ (SPEC 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Gate delays always apply; there is a mode 3.
    Gus,
    /// Gate delays apply where the mode says so; mode 3 is mode 0.
    Lsr,
}

/// How energy is output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Mode 0: carrier with a duty in percent.
    Duty,
    /// Mode 1: pulses of fixed width, rate in kHz.
    Frequency,
    /// Mode 2: a voltage.
    Analog,
    /// Mode 3: as `Duty`; in the GUS family the switch is held at its enabled level.
    Open,
}

/// First-pulse suppression, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fpk {
    /// Length of the suppression pulse.
    pub time1: Ns,
    /// From gate-on to the energy.
    pub time2: Ns,
    /// From gate-off to the end of the energy.
    pub off: Ns,
}

/// What acts on a channel.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "each variant's text names its fields")]
pub enum Command {
    /// SetHSIOOpt.
    Gate(bool),
    /// LaserPowerMode; `delayed` counts in the LSR family.
    PowerMode { mode: Mode, max: Exact, min: Exact, delayed: bool },
    /// LaserPrfCmd, in the mode's unit: %, kHz, V.
    Power(Exact),
    /// LaserOutFrq, kHz.
    Carrier(Exact),
    /// SetPulseWidth, ns.
    Width(Ns),
    /// SetLevelDelay, ns.
    Delays { off: Ns, on: Ns },
    /// EnaFPK, DisFPK.
    Fpk(Option<Fpk>),
    /// SetWaitPulse: kHz and %.
    Standby(Option<(Exact, Exact)>),
    /// SetPreVltg, V.
    PreVoltage(Option<Exact>),
    /// ZeroLaserOnTime.
    ZeroOnTime,
    /// SetAxisMode: whether the connector carries the PWM.
    Connector(bool),
    /// Reset: power-on state.
    Reset,
    /// A cause of section 9 came.
    Fault,
    /// It is gone and was cleared.
    Clear,
}

/// A job: commands in the order in which they act, by instants that never go back.
pub type Job = [(Ns, Command)];

/// What happens to a gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    On,
    Off,
    /// Everything to the safe state at once: another mode, the connector removed, a fault.
    Cut,
}

/// The cancel rule: what is pending at or after the effect of a later command does not happen. A
/// cut acts when it is given, so it is never pending.
fn schedule(events: &mut Vec<(Ns, Event)>, at: Ns, event: Event) {
    events.retain(|&(earlier, what)| earlier < at || what == Event::Cut);
    events.push((at, event));
}

/// Leaves out what changes nothing.
fn changes(events: Vec<(Ns, Event)>) -> Vec<(Ns, Event)> {
    let mut on = false;
    events
        .into_iter()
        .filter(|&(_, event)| {
            let before = on;
            on = event == Event::On;
            event == Event::Cut || before != on
        })
        .collect()
}

/// Time from `begin` to `end` (not included).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// First ns.
    pub begin: Ns,
    /// First ns that does not belong to it.
    pub end: Ns,
}

impl Span {
    fn has(self, at: Ns) -> bool {
        self.begin <= at && at < self.end
    }
}

/// A change of a level.
pub type Edge<T> = (Ns, T);

/// A time without light in which standby stays the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dark {
    /// When.
    pub span: Span,
    /// The pulses that may begin in it.
    pub standby: Option<Train>,
    /// How long a pulse that began before it may go on.
    pub left: Ns,
}

/// What a job does, up to a horizon. Levels are logical: true is active. All begin inactive.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Edges of the gate after its delays.
    pub gate: Vec<Edge<bool>>,
    /// Edges of the switch output.
    pub switch: Vec<Edge<bool>>,
    /// Edges of the energy output (PWM).
    pub energy: Vec<Edge<bool>>,
    /// Volts of the analog output; 0 outside analog mode.
    pub analog: Vec<Edge<Exact>>,
    /// Light, whatever the power is.
    pub light: Vec<Span>,
    /// All the other times, and what the energy output may do in them.
    pub dark: Vec<Dark>,
    /// Faults.
    pub faults: Vec<Ns>,
    /// Times at which the on-time was zeroed.
    zeroed: Vec<Ns>,
    /// Commanded state.
    commanded: Vec<Edge<bool>>,
}

/// The job as settings over time.
struct Story<'a> {
    family: Family,
    job: &'a Job,
    settings: Vec<(Ns, Settings)>,
}

impl Story<'_> {
    fn of(family: Family, job: &Job) -> Story<'_> {
        let mut now = Settings::power_on(family);
        let mut settings = vec![(Ns::MIN, now.clone())];
        for (at, command) in job {
            now.apply(family, command);
            settings.push((*at, now.clone()));
        }
        Story { family, job, settings }
    }

    /// The settings in force: commands of an instant act before its edges.
    fn at(&self, at: Ns) -> &Settings {
        let after = self.settings.partition_point(|&(from, _)| from <= at);
        &self.settings[after - 1].1
    }

    /// The next instant after this one at which a command acts.
    fn next_change(&self, at: Ns) -> Option<Ns> {
        let after = self.settings.partition_point(|&(from, _)| from <= at);
        self.settings.get(after).map(|&(from, _)| from)
    }

    /// The gate after its delays, and the commanded state.
    fn gate(&self) -> (Vec<(Ns, Event)>, Vec<Edge<bool>>) {
        let mut events = Vec::new();
        let mut commanded = Vec::new();
        // The settings before command i are the entry i of the list.
        for ((at, command), (_, before)) in self.job.iter().zip(&self.settings) {
            match *command {
                Command::Gate(_) if before.fault => {}
                // It meets no output: nothing is lit, and nothing remembered.
                Command::Gate(true) if !before.connector && before.mode != Mode::Analog => {}
                Command::Gate(on) => {
                    let delay = match (before.delayed, on) {
                        (false, _) => 0,
                        (true, true) => before.on_delay,
                        (true, false) => before.off_delay,
                    };
                    schedule(&mut events, at + delay, if on { Event::On } else { Event::Off });
                    commanded.push((*at, on));
                }
                Command::PowerMode { mode, .. } if kind(self.family, mode) == before.mode => {}
                // Reading 22.
                Command::Connector(false) if before.mode == Mode::Analog => {}
                Command::PowerMode { .. } | Command::Connector(false) | Command::Fault | Command::Reset => {
                    schedule(&mut events, *at, Event::Cut);
                    commanded.push((*at, false));
                }
                _ => {}
            }
        }
        (changes(events), commanded)
    }

    /// When energy flows: the gate, with FPK shifted under the gate's own rule.
    fn energy_gate(&self, gate: &[(Ns, Event)]) -> Vec<(Ns, Event)> {
        let mut events = Vec::new();
        let mut off = 0;
        for &(at, event) in gate {
            let effect = match event {
                Event::On => {
                    // Reading 3: the settings at the gate's edge count for the mark.
                    let fpk = self.at(at).fpk;
                    off = fpk.map_or(0, |fpk| fpk.off);
                    at + fpk.map_or(0, |fpk| fpk.time2)
                }
                Event::Off => at + off,
                Event::Cut => at,
            };
            schedule(&mut events, effect, event);
        }
        changes(events)
    }

    /// Suppression pulses.
    fn suppression(&self, gate: &[(Ns, Event)]) -> Vec<Span> {
        let mut spans = Vec::new();
        for (index, &(begin, event)) in gate.iter().enumerate() {
            if event == Event::On
                && let Some(fpk) = self.at(begin).fpk
            {
                let disabled = self.job.iter().filter(|(_, command)| *command == Command::Fpk(None)).map(|(at, _)| *at);
                let over = gate[index + 1..].iter().filter(|(_, event)| *event != Event::Off).map(|&(at, _)| at);
                let end = disabled.filter(|&at| at > begin).chain(over).min().unwrap_or(Ns::MAX);
                spans.push(Span { begin, end: end.min(begin + fpk.time1) });
            }
        }
        spans
    }

    fn switch(&self, gate: &[(Ns, Event)]) -> Vec<Edge<bool>> {
        let pulses = self.suppression(gate);
        let on = spans(gate, Ns::MAX);
        let ends = pulses.iter().flat_map(|pulse| [pulse.begin, pulse.end]);
        let instants = gate.iter().map(|&(at, _)| at).chain(ends).chain(self.job.iter().map(|(at, _)| *at));
        levels(instants, |at| {
            let settings = self.at(at);
            if settings.fault {
                false
            } else if settings.mode == Mode::Open {
                true
            } else if settings.fpk.is_some() {
                pulses.iter().any(|pulse| pulse.has(at))
            } else {
                on.iter().any(|(span, _)| span.has(at))
            }
        })
    }

    /// Pulses that begin in a span with the settings that hold there at the beginning of each
    /// period.
    fn pulses(&self, span: Span, train: impl Fn(&Settings) -> Option<Train>) -> Vec<Span> {
        let mut pulses = Vec::new();
        let mut at = span.begin;
        // The train in force, where its pattern began, and its periods since.
        let mut pattern: Option<(Train, Ns, i128)> = None;
        while at < span.end {
            let until = self.next_change(at).unwrap_or(span.end).min(span.end);
            let Some(now) = train(self.at(at)) else {
                pattern = None;
                at = until;
                continue;
            };
            // Reading 20: another setting begins the pattern anew.
            let (first, mut k) = match pattern {
                Some((before, first, k)) if before == now => (first, k),
                _ => (at, 0),
            };
            let mut early = false;
            while at < until {
                let pulse = at + times(now.width, k + 1) - times(now.width, k);
                if pulse > at {
                    pulses.push(Span { begin: at, end: pulse });
                }
                // Reading 12: a shorter period ends the one in progress where it would end itself.
                let mut end = first + times(now.period, k + 1);
                let mut change = until;
                while change < end && change < span.end {
                    if let Some(new) = train(self.at(change)) {
                        let sooner = (at + times(new.period, 1)).max(change).max(pulse);
                        (end, early) = if sooner < end { (sooner, true) } else { (end, early) };
                    }
                    change = self.next_change(change).unwrap_or(span.end);
                }
                (at, k) = (end, k + 1);
            }
            pattern = (!early).then_some((now, first, k));
        }
        pulses
    }

    /// Light whose pulse in progress does not outlast it: what comes at once, the open switch, and
    /// a level, that of the settings before what acts with its end.
    fn is_cut(&self, light: Span, end: Event) -> bool {
        end != Event::Off || self.at(light.begin).mode == Mode::Open || self.at(light.end - 1).is_level()
    }

    /// Pulses of a rate in a span: one where the rate is first above 0, and one wherever its
    /// integral since the last one reaches 1. A pulse has the width of the settings at its
    /// beginning, and ends a ns before the next one at the latest.
    fn rate(&self, span: Span) -> Vec<Span> {
        let mut pulses: Vec<Span> = Vec::new();
        // What is left of the integral until the next pulse; the first one is due at once.
        let mut left = whole(0);
        let mut from = span.begin;
        while from < span.end {
            let until = self.next_change(from).unwrap_or(span.end).min(span.end);
            if let Some(train) = self.at(from).train() {
                let mut next = whole(from.into()) + left * train.period;
                while next.floor() < whole(until.into()) {
                    let begin = next.floor().to_integer() as Ns;
                    pulses.push(Span { begin, end: begin + times(train.width, 1) });
                    next += train.period;
                }
                left = (next - whole(until.into())) / train.period;
            }
            from = until;
        }
        for index in 1..pulses.len() {
            let latest = pulses[index].begin - 1;
            pulses[index - 1].end = pulses[index - 1].end.min(latest);
        }
        pulses
    }

    fn energy(&self, light: &[(Span, Event)], cuts: &[Ns], horizon: Ns) -> Vec<Edge<bool>> {
        let mut pulses = Vec::new();
        let mut dark_from = 0;
        for (index, &(span, end)) in light.iter().enumerate() {
            self.standby(Span { begin: dark_from, end: span.begin }, cuts, &mut pulses);
            let cut = self.is_cut(span, end);
            let next = light.get(index + 1).map_or(Ns::MAX, |(next, _)| next.begin);
            dark_from = span.end;
            let in_phase = self.at(span.begin).mode == Mode::Frequency;
            let train = if in_phase { self.rate(span) } else { self.pulses(span, Settings::train) };
            for pulse in train {
                let finished = !cut && pulse.end <= span.end + 100_000;
                let mut last = if finished { pulse.end } else { pulse.end.min(span.end) };
                last = last.min(next);
                // A command that acts at once also cuts a pulse that is being finished.
                if let Some(&cut) = cuts.iter().find(|&&cut| cut >= span.end) {
                    last = last.min(cut);
                }
                dark_from = dark_from.max(last);
                pulses.push(Span { begin: pulse.begin, end: last });
            }
        }
        self.standby(Span { begin: dark_from, end: horizon }, cuts, &mut pulses);
        let ends: Vec<Ns> = pulses.iter().flat_map(|pulse| [pulse.begin, pulse.end]).collect();
        let mut index = 0;
        // Pulses are in order, and none begins before the one before has ended.
        levels(ends.into_iter(), |at| {
            while pulses.get(index).is_some_and(|pulse| pulse.end <= at) {
                index += 1;
            }
            pulses.get(index).is_some_and(|pulse| pulse.has(at))
        })
    }

    /// Standby pulses of a dark time; what ends them cuts them.
    fn standby(&self, dark: Span, cuts: &[Ns], pulses: &mut Vec<Span>) {
        let mut at = dark.begin;
        while at < dark.end {
            // As long as standby may be output; another mode and a fault break it.
            let mut end = self.next_change(at).unwrap_or(dark.end);
            let allowed = self.at(at).standby_allowed();
            while end < dark.end && self.at(end).standby_allowed() == allowed && !cuts.contains(&end) {
                end = self.next_change(end).unwrap_or(dark.end);
            }
            end = end.min(dark.end);
            if allowed {
                let train = self.pulses(Span { begin: at, end }, Settings::standby_train);
                pulses.extend(train.into_iter().map(|pulse| Span { end: pulse.end.min(end), ..pulse }));
            }
            at = end;
        }
    }

    /// The times between light, split where standby changes.
    fn dark(&self, light: &[(Span, Event)], cuts: &[Ns], horizon: Ns) -> Vec<Dark> {
        let standby = |at: Ns| self.at(at).standby_train().filter(|_| self.at(at).standby_allowed());
        let mut darks = Vec::new();
        let (mut at, mut left) = (0, 0);
        for (next, end) in light.iter().copied().chain([(Span { begin: horizon, end: horizon }, Event::Cut)]) {
            let until = next.begin.min(horizon);
            while at < until {
                let now = standby(at);
                let mut end = self.next_change(at).unwrap_or(until).min(until);
                while end < until && standby(end) == now && !cuts.contains(&end) {
                    end = self.next_change(end).unwrap_or(until).min(until);
                }
                darks.push(Dark { span: Span { begin: at, end }, standby: now, left });
                // A standby pulse continues when its settings change, and ends when standby is not
                // allowed.
                let pulse = now.map_or(0, |train| times(train.width, 1) + 1);
                let cut = cuts.contains(&end) || now.is_some() && !self.at(end).standby_allowed();
                left = if cut { 0 } else { (left - (end - at)).max(0) + pulse };
                at = end;
            }
            (at, left) = (next.end, if self.is_cut(next, end) { 0 } else { 100_000 });
        }
        darks
    }

    fn analog(&self, light: &[(Span, Event)]) -> Vec<Edge<Exact>> {
        let ends = light.iter().flat_map(|(span, _)| [span.begin, span.end]);
        let instants = ends.chain(self.job.iter().map(|(at, _)| *at));
        let mut edges = vec![(Ns::MIN, whole(0))];
        for at in sorted(instants) {
            let settings = self.at(at);
            let volts = if settings.mode != Mode::Analog || settings.fault {
                whole(0)
            } else if light.iter().any(|(span, _)| span.has(at)) {
                settings.bounded()
            } else {
                settings.pre_voltage.unwrap_or(whole(0))
            };
            if edges[edges.len() - 1].1 != volts {
                edges.push((at, volts));
            }
        }
        edges.split_off(1)
    }
}

fn sorted(instants: impl Iterator<Item = Ns>) -> Vec<Ns> {
    let mut instants: Vec<Ns> = instants.filter(|&at| at < Ns::MAX).collect();
    instants.sort_unstable();
    instants.dedup();
    instants
}

/// Edges of a level that changes at some of these instants.
fn levels(instants: impl Iterator<Item = Ns>, mut level: impl FnMut(Ns) -> bool) -> Vec<Edge<bool>> {
    let mut edges = Vec::new();
    let mut last = false;
    for at in sorted(instants) {
        let now = level(at);
        if now != last {
            edges.push((at, now));
            last = now;
        }
    }
    edges
}

/// The times between on and what ends it.
fn spans(events: &[(Ns, Event)], horizon: Ns) -> Vec<(Span, Event)> {
    let mut spans = Vec::new();
    let mut begin = None;
    for &(at, event) in events {
        match (event, begin) {
            (Event::On, _) => begin = Some(at),
            (end, Some(from)) => {
                spans.push((Span { begin: from, end: at }, end));
                begin = None;
            }
            (_, None) => {}
        }
    }
    if let Some(begin) = begin.filter(|&begin| begin < horizon) {
        spans.push((Span { begin, end: horizon }, Event::Cut));
    }
    spans
}

fn instants(job: &Job, what: &Command) -> Vec<Ns> {
    job.iter().filter(|(_, command)| command == what).map(|(at, _)| *at).collect()
}

/// What a job does from power-on until `horizon`, which no event after it influences.
pub fn outcome(family: Family, job: &Job, horizon: Ns) -> Outcome {
    let story = Story::of(family, job);
    let (gate, commanded) = story.gate();
    let energy_gate = story.energy_gate(&gate);
    let light = spans(&energy_gate, horizon);
    let cuts: Vec<Ns> = energy_gate.iter().filter(|(_, event)| *event == Event::Cut).map(|&(at, _)| at).collect();
    let mut switch = story.switch(&gate);
    let mut energy = story.energy(&light, &cuts, horizon);
    let mut analog = story.analog(&light);
    let dark = story.dark(&light, &cuts, horizon);
    switch.retain(|&(at, _)| at < horizon);
    energy.retain(|&(at, _)| at < horizon);
    analog.retain(|&(at, _)| at < horizon);
    let on = spans(&gate, Ns::MAX);
    Outcome {
        gate: levels(gate.iter().map(|&(at, _)| at), |at| on.iter().any(|(span, _)| span.has(at))),
        switch,
        energy,
        analog,
        light: light.into_iter().map(|(span, _)| span).filter(|span| span.begin < span.end).collect(),
        dark,
        faults: instants(job, &Command::Fault),
        zeroed: [instants(job, &Command::ZeroOnTime), instants(job, &Command::Reset)].concat(),
        commanded,
    }
}

/// The level that a list of edges gives at an instant.
pub fn level_at<T: Clone>(edges: &[Edge<T>], at: Ns, before: T) -> T {
    let after = edges.partition_point(|&(edge, _)| edge <= at);
    if after == 0 { before } else { edges[after - 1].1.clone() }
}

impl Outcome {
    /// Light of any kind up to this instant since the counter was zeroed, ns.
    pub fn on_time(&self, at: Ns) -> Ns {
        let zeroed = self.zeroed.iter().copied().filter(|&zeroed| zeroed <= at).max().unwrap_or(0);
        self.light.iter().map(|span| (span.end.min(at) - span.begin.max(zeroed)).max(0)).sum()
    }

    /// The state that the last command asked for.
    pub fn commanded_at(&self, at: Ns) -> bool {
        level_at(&self.commanded, at, false)
    }
}
