extern crate std;
#[path = "../../../servo/tests/chance/mod.rs"]
mod chance;
use super::*;
use chance::Chance;
use servo::laser::Count;
use servo::laser::Pattern;
use std::vec;
use std::vec::Vec;

fn train(period: u64, width: u64) -> Train {
    let count = |whole| Count { whole, part: 0, of: 0 };
    Train { period: count(period), width: count(width) }
}

/// Edges of the energy output in the order of time; a level that lasts for no time is none.
#[derive(Default)]
struct Scope {
    energy: Vec<(u64, bool)>,
    switch: Vec<(u64, bool)>,
    dac: Vec<(u64, i16)>,
}

impl Scope {
    fn note(&mut self, change: SignalChange) {
        match change {
            SignalChange::Switch { at, level } => self.switch.push((at, level)),
            SignalChange::Dac { at, code } => self.dac.push((at, code)),
            SignalChange::Energy { at, level } => self.edge(at, level),
            SignalChange::Pulses(burst) => {
                for (begin, end) in burst.pulses() {
                    self.edge(begin, true);
                    self.edge(end, false);
                }
            }
        }
    }

    fn edge(&mut self, at: u64, level: bool) {
        assert_ne!(self.energy.last().is_some_and(|last| last.1), level, "{at}: {level} twice");
        assert!(self.energy.last().is_none_or(|last| last.0 <= at), "{at}: time goes back");
        if self.energy.last().is_some_and(|last| last.0 == at) {
            self.energy.pop();
        } else {
            self.energy.push((at, level));
        }
    }
}

/// A timer that counts every ns.
#[derive(Default)]
struct Timer {
    train: Train,
    begun: Option<u64>,
    period_left: u64,
    pulse_left: u64,
    begins_in: u64,
    pattern: Pattern,
}

impl Timer {
    fn action(&mut self, at: u64, action: Action) {
        match action {
            Action::Light(train) => {
                (self.pulse_left, self.begins_in) = (0, 0);
                self.enter(train);
            }
            Action::Dark { standby, cut } => {
                if cut || self.pulse_left > 100_000 {
                    self.pulse_left = 0;
                }
                self.begins_in = self.pulse_left;
                self.enter(standby);
            }
            Action::Change(train) => {
                self.train = train;
                if let Some(begun) = self.begun
                    && !train.is_none()
                {
                    let left = train.period.whole.saturating_sub(at - begun).max(self.pulse_left);
                    self.period_left = self.period_left.min(left);
                }
            }
            Action::Rate(_) => unreachable!("tests/pwm_cycles.rs plays rates"),
            Action::Switch(_) | Action::Volts(_) => {}
        }
    }

    fn enter(&mut self, train: Train) {
        (self.train, self.begun, self.pattern) = (train, None, Pattern::BEGIN);
    }

    /// The level in the ns that begins at `at`.
    fn count(&mut self, at: u64) -> bool {
        if self.begun.is_some() && self.period_left == 0 {
            self.begun = None;
        }
        if self.begun.is_none() && self.begins_in == 0 {
            if self.train.is_none() {
                self.pattern = Pattern::BEGIN;
            } else {
                (self.period_left, self.pulse_left) = self.pattern.step(&self.train);
                self.begun = Some(at);
            }
        }
        let level = self.pulse_left > 0;
        for left in [&mut self.pulse_left, &mut self.period_left, &mut self.begins_in] {
            *left = left.saturating_sub(1);
        }
        level
    }
}

struct Random(Chance);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0.below(bound)
    }

    fn train(&mut self, scale: u64) -> Train {
        let period = 1 + self.below(scale);
        match self.below(8) {
            0 => Train::NONE,
            1 => train(period, period),
            2 => train(period, 0),
            _ => {
                let count = |random: &mut Self, whole: u64| {
                    let of = [0, 7, 12, 1 << 31][random.below(4) as usize];
                    let part = random.below(if of == 0 { 1 << 32 } else { u64::from(of) }) as u32;
                    Count { whole, part, of }
                };
                let period = count(self, period);
                // Often just below the period.
                let least = if self.below(3) == 0 { period.whole.saturating_sub(1) } else { 0 };
                let whole = least + self.below(period.whole + 1 - least);
                let width = count(self, whole);
                let share = |count: Count| {
                    f64::from(count.part) / if count.of == 0 { 4_294_967_296.0 } else { f64::from(count.of) }
                };
                let too_long = whole == period.whole && share(width) > share(period);
                let full = self.below(4) == 0;
                Train { period, width: if too_long || full { period } else { width } }
            }
        }
    }
}

#[test]
fn the_closed_form_is_a_timer_that_counts_every_nanosecond() {
    let mut random = Random(Chance::new(11));
    let mut edges = 0;
    for run in 0..100 {
        let scale = [5, 40, 2_000, 300_000][run % 4];
        let end = scale * 40;
        let mut actions: Vec<(u64, Action)> = (0..30)
            .map(|_| {
                let train = random.train(scale);
                let action = match random.below(4) {
                    0 => Action::Light(train),
                    1 => Action::Dark { standby: train, cut: random.below(2) == 0 },
                    _ => Action::Change(train),
                };
                (random.below(end), action)
            })
            .collect();
        actions.sort_by_key(|(at, _)| *at);
        let (mut stage, mut scope, mut timer) = (OutputStage::new(), Scope::default(), Timer::default());
        let (mut expected, mut level) = (Vec::new(), false);
        let mut left = actions.iter().peekable();
        for at in 0..end {
            while let Some((_, action)) = left.next_if(|(due, _)| *due == at) {
                timer.action(at, *action);
                stage.push(at, *action);
            }
            let now = timer.count(at);
            if now != level {
                expected.push((at, now));
                level = now;
            }
            // Followed now and then, and sometimes for long not at all.
            if random.below(scale) == 0 && run % 3 != 0 {
                stage.run_to(at, &mut |change| scope.note(change));
            }
        }
        stage.run_to(end, &mut |change| scope.note(change));
        scope.energy.pop_if(|last| last.0 == end);
        let differs = scope.energy.iter().zip(&expected).position(|(a, b)| a != b);
        let from = differs.unwrap_or(0).saturating_sub(3);
        let near = |edges: &[(u64, bool)]| edges.iter().skip(from).take(7).copied().collect::<Vec<_>>();
        let instant = near(&expected).first().map_or(0, |edge| edge.0);
        let near_actions: Vec<_> =
            actions.iter().filter(|a| a.0 + scale >= instant && a.0 < instant + 4 * scale).collect();
        assert!(
            scope.energy == expected,
            "run {run}:\n{:?}\n{:?}\n{near_actions:?}",
            near(&scope.energy),
            near(&expected)
        );
        edges += expected.len();
    }
    assert!(edges > 3_000, "{edges}");
}

fn played(actions: &[(u64, Action)], end: u64) -> Scope {
    let (mut stage, mut scope) = (OutputStage::new(), Scope::default());
    for &(at, action) in actions {
        stage.push(at, action);
    }
    stage.run_to(end, &mut |change| scope.note(change));
    scope
}

fn highs(scope: &Scope) -> Vec<(u64, u64)> {
    scope.energy.chunks(2).map(|pair| (pair[0].0, pair.get(1).map_or(u64::MAX, |edge| edge.0))).collect()
}

#[test]
fn a_full_train_has_no_gap_whatever_is_left_over() {
    let count = |whole, part, of| Count { whole, part, of };
    let full = Train { period: count(300, 1, 3), width: count(300, 1, 3) };
    for (part, of) in [(1, 3), (2, 3), (1, 7), (1 << 31, 0)] {
        for periods in 0..6 {
            for whole in [100, 299, 300] {
                let before = Train { period: count(300, 2, 3), width: count(whole, part, of) };
                let from = periods * 300 + 10;
                let actions = [(0, Action::Light(before)), (from, Action::Change(full))];
                let level = *highs(&played(&actions, 400_000)).last().unwrap();
                assert!(level.0 < from + 301 && level.1 >= 400_000, "{before:?}, {periods}: {level:?}");
            }
        }
    }
}

#[test]
fn the_last_pulse_is_finished_or_cut() {
    let dark = |cut| Action::Dark { standby: Train::NONE, cut };
    // 150 µs of pulse: 100 µs left are finished, 1 ns more is cut.
    let mark =
        |off, cut| highs(&played(&[(1_000, Action::Light(train(200_000, 150_000))), (off, dark(cut))], 1_000_000));
    assert_eq!(mark(51_000, false), [(1_000, 151_000)]);
    assert_eq!(mark(50_999, false), [(1_000, 50_999)]);
    assert_eq!(mark(51_000, true), [(1_000, 51_000)]);
    assert_eq!(mark(151_000, false), [(1_000, 151_000)]);
    assert_eq!(mark(201_000, false), [(1_000, 151_000)], "no pulse begins at the end of the light");
}

#[test]
fn standby_begins_where_the_last_pulse_ends_and_light_cuts_it() {
    let actions = [
        (1_000, Action::Light(train(1_000, 600))),
        (2_100, Action::Dark { standby: train(500, 100), cut: false }),
        (3_150, Action::Light(train(1_000, 600))),
    ];
    let expected = vec![(1_000, 1_600), (2_000, 2_700), (3_100, 3_750)];
    // The standby pulses of 2600 and 3100 touch the light before and after.
    assert_eq!(highs(&played(&actions, 4_000)), expected);
}

#[test]
fn everything_rests_at_once_and_what_waits_is_void() {
    let (mut stage, mut scope) = (OutputStage::new(), Scope::default());
    for (at, action) in [
        (10, Action::Switch(true)),
        (10, Action::Light(train(1_000, 800))),
        (20, Action::Volts(8_192)),
        (1_500, Action::Switch(false)),
        (1_600, Action::Volts(9_000)),
    ] {
        stage.push(at, action);
    }
    stage.run_to(1_400, &mut |change| scope.note(change));
    assert_eq!(stage.levels(), ChannelLevels { switch: true, energy: true, dac: 8_192 });
    stage.safe_state(1_400, &mut |change| scope.note(change));
    assert_eq!(stage.levels(), ChannelLevels::default());
    stage.run_to(1_000_000, &mut |change| scope.note(change));
    assert_eq!(highs(&scope), [(10, 810), (1_010, 1_400)]);
    assert_eq!(scope.switch, [(10, true), (1_400, false)]);
    assert_eq!(scope.dac, [(20, 8_192), (1_400, 0)]);
}

#[test]
fn the_interlock_holds_pulses_and_switch_and_leaves_the_dac() {
    let (mut stage, mut scope) = (OutputStage::new(), Scope::default());
    let mut sink = |change| scope.note(change);
    stage.push(0, Action::Switch(true));
    stage.push(0, Action::Light(train(1_000, 800)));
    stage.push(0, Action::Volts(100));
    stage.push(550, Action::Switch(false));
    stage.push(550, Action::Volts(150));
    stage.push(560, Action::Light(train(10, 10)));
    stage.interlock(500, true, &mut sink);
    stage.push(600, Action::Light(train(1_000, 800)));
    stage.push(600, Action::Switch(true));
    stage.push(700, Action::Volts(200));
    stage.interlock(5_000, false, &mut sink);
    stage.push(6_000, Action::Switch(true));
    stage.run_to(10_000, &mut sink);
    assert_eq!(highs(&scope), [(0, 500)]);
    assert_eq!(scope.switch, [(0, true), (500, false), (6_000, true)]);
    assert_eq!(scope.dac, [(0, 100), (550, 150), (700, 200)]);
}

#[test]
fn an_hour_of_two_megahertz_is_one_burst() {
    let mut bursts = Vec::new();
    let mut stage = OutputStage::new();
    stage.push(0, Action::Light(train(500, 200)));
    stage.run_to(3_600_000_000_000, &mut |change| bursts.push(change));
    let whole = SignalChange::Pulses(Burst::new(0, 7_200_000_000 - 1, train(500, 200)));
    assert_eq!(bursts, [whole, SignalChange::Pulses(Burst::single(3_599_999_999_500, 200))]);
}
