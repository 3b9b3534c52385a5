//! Plans that timers execute as PWM cycles give the edges of the model, to one count of the timer.
//!
//! The timer here is the plainest one: it counts one cycle after the other. The model,
//! [`OutputStage`], has no cycles. Pulses of a steady train may come in another order than the
//! model's within a tick (SPEC 11): the longer periods of [`TOGETHER_PERIODS`] come first.
mod pwm_plans;

use plant::beam::{OutputStage, SignalChange};
use pwm_plans::{BEGIN_COUNTS, MHZ, Random, SCALE, counts, held};
use servo::laser::{Action, Clock, Count, LaserPlan, PLAN_ACTIONS, Power, PulseRate, Standby, Train};
use servo::output::{Cycle, DELAY_LINE_WORDS, DelayLine, GATE_MIN_COUNTS, GateCycles, PWM_MIN_COUNTS, PwmCycles};
use std::sync::atomic::AtomicU32;

/// 100 µs.
const FINISH_COUNTS: u64 = 24_000;
/// Periods that are put in order at once, and how far the first half of them takes a pulse from its
/// place: n/2 of n periods are one count longer, where the mean is half a count.
const TOGETHER_PERIODS: usize = 256;
const SHIFT_COUNTS: u64 = TOGETHER_PERIODS as u64 / 4;

/// Active pulses, begin and end in counts.
type Pulses = Vec<(u64, u64)>;

/// Adds an active pulse, which may touch the one before.
fn note(pulses: &mut Pulses, begin: u64, end: u64) {
    match pulses.last_mut() {
        _ if begin == end => {}
        Some(last) if last.1 == begin => last.1 = end,
        _ => pulses.push((begin, end)),
    }
}

/// Records the changes of the model.
#[derive(Default)]
struct Scope {
    energy: Pulses,
    lit: Option<u64>,
    switch: Pulses,
    switched: Option<u64>,
}

impl Scope {
    fn note(&mut self, change: SignalChange) {
        let (at, level, begun, pulses) = match change {
            SignalChange::Energy { at, level } => (at, level, &mut self.lit, &mut self.energy),
            SignalChange::Switch { at, level } => (at, level, &mut self.switched, &mut self.switch),
            SignalChange::Pulses(burst) => {
                burst.pulses().for_each(|(begin, end)| note(&mut self.energy, begin, end));
                return;
            }
            SignalChange::Dac { .. } => return,
        };
        match begun.take() {
            Some(begin) if !level => note(pulses, begin, at),
            None if level => *begun = Some(at),
            _ => panic!("{at}: {level} twice"),
        }
    }

    /// Ends pulses that are still active.
    fn end(&mut self, at: u64) {
        for (begun, pulses) in [(&mut self.lit, &mut self.energy), (&mut self.switched, &mut self.switch)] {
            if let Some(begin) = begun.take() {
                note(pulses, begin, at);
            }
        }
    }
}

/// What was queued. The next cycle is read at the latest when the second one before it begins.
struct Queued {
    end: u64,
    last: [u32; 2],
    least: u32,
    count: u64,
}

impl Queued {
    fn cycles(&mut self, length: u32, times: u32) {
        assert!((1..=256).contains(&times), "{times} times");
        assert!((self.least..=65_535).contains(&length), "{} counts at {}", length, self.end);
        self.end += u64::from(length * times);
        self.last = [self.last[1], length * times];
        self.count += 1;
    }

    fn read_by(&self) -> u64 {
        self.end - u64::from(self.last[0]) - u64::from(self.last[1])
    }
}

/// A channel's pulses from cycles and from the model.
struct Compared {
    model: Pulses,
    got: Pulses,
    /// The ends of what each tick has queued.
    ends: Vec<u64>,
    /// The latest that a cycle is read, before the end of what is known.
    worst: u64,
    cycles: u64,
}

/// Over so many ticks.
fn energy(random: &mut Random, ticks: usize) -> Compared {
    let (mut cycles, mut held) = (PwmCycles::from(BEGIN_COUNTS, SCALE), held());
    let (mut stage, mut scope) = (OutputStage::counting(FINISH_COUNTS), Scope::default());
    let (mut got, mut ends) = (Pulses::new(), Vec::new());
    let mut queued = Queued { end: BEGIN_COUNTS, last: [168, 168], least: PWM_MIN_COUNTS, count: 0 };
    let mut lasts = 50_000;
    let (mut from, mut worst) = (counts(lasts), 0);
    for tick in 0..ticks {
        if random.below(10) == 0 {
            lasts = (10 + random.below(241) as u32) * 1000;
        }
        let plan = random.plan(lasts);
        if tick > 0 {
            worst = worst.max(from - queued.read_by());
        }
        let to = from + counts(lasts);
        stage.run_to(from, &mut |change| scope.note(change));
        for (at, action) in plan.actions() {
            stage.push(from + counts(*at), *action);
        }
        assert!(held.put(&plan));
        cycles.take(from, to, held.actions(), &mut |length, light, times| {
            assert!(light <= length);
            for begin in (0..times).map(|n| queued.end + u64::from(n * length)) {
                note(&mut got, begin, begin + u64::from(light));
            }
            queued.cycles(length, times);
        });
        assert_eq!(cycles.queued(), queued.end);
        ends.push(queued.end);
        from = to;
    }
    let mut end = LaserPlan::EMPTY;
    end.add(0, Action::Dark { standby: Train::NONE, cut: true });
    stage.push(from, Action::Dark { standby: Train::NONE, cut: true });
    cycles.take(from, from + 60_000, end.actions().iter().copied(), &mut |length, light, times| {
        assert_eq!(times, 1);
        note(&mut got, queued.end, queued.end + u64::from(light));
        queued.cycles(length, times);
    });
    stage.run_to(from + 60_000, &mut |change| scope.note(change));
    scope.end(from + 60_000);
    Compared { model: scope.energy, got, ends, worst, cycles: queued.count }
}

/// Leaves out a pulse when the next one begins less than the shortest cycle after its begin.
fn without_lost(pulses: &[(u64, u64)]) -> Pulses {
    let mut kept = Pulses::new();
    for (n, pulse) in pulses.iter().enumerate() {
        let next = pulses.get(n + 1).map_or(u64::MAX, |next| next.0);
        if next - pulse.0 >= u64::from(PWM_MIN_COUNTS) {
            kept.push(*pulse);
        }
    }
    kept
}

/// The first pulse of `got` that is not that of the model. It may be up to [`SHIFT_COUNTS`] from
/// its place and a count wider or narrower. Within the periods that are put in order, one is at its
/// place again, and all light up to there is the same.
fn differs(model: &[(u64, u64)], got: &[(u64, u64)]) -> Option<usize> {
    let (mut light, mut away) = (0, None);
    for (n, (model, got)) in model.iter().zip(got).enumerate() {
        if model.0 == got.0 && light == 0 {
            away = None;
        }
        let since = *away.get_or_insert(n);
        let widths = (model.1 - model.0).abs_diff(got.1 - got.0);
        if n - since > TOGETHER_PERIODS || model.0.abs_diff(got.0) > SHIFT_COUNTS || widths > 1 {
            return Some(n);
        }
        light += (got.1 - got.0) as i64 - (model.1 - model.0) as i64;
    }
    (model.len() != got.len() || light != 0).then(|| model.len().min(got.len()))
}

/// Light before an instant.
fn light(pulses: &[(u64, u64)], before: u64) -> i64 {
    let over = pulses.iter().take_while(|pulse| pulse.0 < before);
    over.map(|(begin, end)| (*end.min(&before) - begin) as i64).sum()
}

#[test]
fn the_energy_is_the_models_to_a_count() {
    let runs = std::env::var("BEAMTICK_ROUNDS").ok().and_then(|runs| runs.parse().ok()).unwrap_or(400);
    let (mut edges, mut lost, mut worst, mut cycles, mut moved) = (0, 0, 0, 0, 0);
    for seed in 0..runs {
        let mut random = Random { extreme: seed % 4 == 0, ..Random::new(seed) };
        let Compared { model, got, ends, worst: late, cycles: queued } = energy(&mut random, 60);
        let expected = without_lost(&model);
        if random.extreme {
            // What each tick has queued has the light of the model.
            let mut before = 0;
            for end in ends {
                let apart = light(&got, end) - light(&expected, end);
                assert!(apart.abs_diff(before) <= 1, "seed {seed}, queued to {end}: {before}, {apart}");
                before = apart;
            }
        } else if let Some(at) = differs(&expected, &got) {
            let from = at.saturating_sub(2);
            panic!(
                "seed {seed}, pulse {at} of {}:\n{:?}\n{:?}",
                expected.len(),
                expected.iter().skip(from).take(5).collect::<Vec<_>>(),
                got.iter().skip(from).take(5).collect::<Vec<_>>()
            );
        }
        moved += expected.iter().zip(&got).filter(|(model, got)| model != got).count();
        (edges, lost) = (edges + expected.len(), lost + model.len() - expected.len());
        (worst, cycles) = (worst.max(late), cycles + queued);
    }
    println!("{edges} pulses, {moved} in another order, {lost} lost, {cycles} cycles, read {worst} counts before");
    assert!(edges > 1_000 * runs as usize && lost * 100 < edges, "{edges}, {lost}");
    assert!(moved * 10 > edges, "{moved} of {edges}");
    // Seven cycles of the shortest length, and a count of rounding.
    assert!(worst <= 7 * u64::from(PWM_MIN_COUNTS) + 1, "{worst}");
}

/// The long remainder of a period that paused is nothing to a train that begins later.
#[test]
fn a_train_that_begins_after_a_pause_begins_at_once() {
    let count = |whole| Count { whole, part: 0, of: 0 };
    let train = |period, width| Train { period: count(period), width: count(width) };
    let rate = PulseRate { period: count(2_000), width: 9, scale: 1 << 63, shift: 71 };
    let pauses = [Action::Light(train(1_000_000, 9)), Action::Rate(PulseRate::PAUSE)];
    for resumed in [Action::Rate(rate), Action::Change(train(2_000, 9))] {
        let mut plan = LaserPlan::EMPTY;
        let goes_on = [resumed, Action::Change(Train::NONE), Action::Change(train(120, 50))];
        for (at, action) in (0..).zip(pauses.into_iter().chain(goes_on)) {
            plan.add(at * 20_000, action);
        }
        let mut cycles = PwmCycles::from(BEGIN_COUNTS, SCALE);
        let (from, mut queued, mut got) = (counts(50_000), BEGIN_COUNTS, Pulses::new());
        cycles.take(from, from + counts(250_000), plan.actions().iter().copied(), &mut |length, light, times| {
            for _ in 0..times {
                note(&mut got, queued, queued + u64::from(light));
                queued += u64::from(length);
            }
        });
        let begins = from + counts(80_000);
        let of_last = got.iter().filter(|pulse| pulse.1 - pulse.0 == 50);
        let late = of_last.clone().next().map(|pulse| pulse.0 - begins);
        assert!(late.is_some_and(|late| late <= 2_000) && of_last.count() > 300, "{resumed:?}: {late:?} of {got:?}");
    }
}

/// Both switches' edges from cycles and from the models.
fn switches(random: &mut Random, ticks: usize) -> ([Pulses; 2], [Pulses; 2], u64) {
    let (mut cycles, mut held) = (GateCycles::from(BEGIN_COUNTS, SCALE), held());
    let mut stages = [OutputStage::counting(FINISH_COUNTS), OutputStage::counting(FINISH_COUNTS)];
    let mut scopes = [Scope::default(), Scope::default()];
    let mut got = [Pulses::new(), Pulses::new()];
    let mut queued = Queued { end: BEGIN_COUNTS, last: [168, 168], least: GATE_MIN_COUNTS, count: 0 };
    let mut lasts = 50_000;
    let (mut from, mut worst) = (counts(lasts), 0);
    for tick in 0..=ticks {
        if random.below(10) == 0 {
            lasts = (10 + random.below(241) as u32) * 1000;
        }
        if tick > 0 {
            worst = worst.max(from - queued.read_by());
        }
        let to = from + counts(lasts);
        let mut plans = [random.plan(lasts), random.plan(lasts)];
        if tick == ticks {
            plans = [LaserPlan::EMPTY, LaserPlan::EMPTY];
            plans.iter_mut().for_each(|plan| plan.add(0, Action::Switch(false)));
        } else if random.below(4) == 0 {
            // Together, or nearly so.
            let shift = random.below(3) as u32 * 10;
            let mut other = LaserPlan::EMPTY;
            for (at, action) in plans[0].actions() {
                other.add((at + shift).min(lasts - 1), *action);
            }
            plans[1] = other;
        }
        for ((plan, stage), scope) in plans.iter().zip(&mut stages).zip(&mut scopes) {
            stage.run_to(from, &mut |change| scope.note(change));
            for (at, action) in plan.actions() {
                stage.push(from + counts(*at), *action);
            }
        }
        assert!(held.put(&plans[0]));
        cycles.hold(held.actions());
        cycles.take(from, to, plans[1].actions().iter().copied(), &mut |cycle| {
            let Cycle { length, falls, rises } = cycle;
            for ((got, falls), rises) in got.iter_mut().zip(falls).zip(rises) {
                assert!(falls <= rises && falls <= length && rises <= 65_535);
                note(got, queued.end, queued.end + u64::from(falls));
                note(got, queued.end + u64::from(rises.min(length)), queued.end + u64::from(length));
            }
            queued.cycles(length, 1);
        });
        assert_eq!(cycles.queued(), queued.end);
        from = to;
    }
    for (stage, scope) in stages.iter_mut().zip(&mut scopes) {
        stage.run_to(from, &mut |change| scope.note(change));
        scope.end(from);
    }
    (scopes.map(|scope| scope.switch), got, worst)
}

#[test]
fn the_switches_are_the_models_to_a_count() {
    let runs = std::env::var("BEAMTICK_ROUNDS").ok().and_then(|runs| runs.parse().ok()).unwrap_or(400);
    let (mut edges, mut missing, mut worst) = (0, 0, 0);
    for seed in 0..runs {
        let (model, got, late) = switches(&mut Random::new(seed), 60);
        for (model, got) in model.iter().zip(&got) {
            let lost: Vec<_> = model.iter().filter(|pulse| !got.contains(pulse)).collect();
            // What differs is missing, and short.
            assert!(
                lost.iter().all(|(begin, end)| end - begin < u64::from(GATE_MIN_COUNTS)),
                "seed {seed}: {lost:?} of {model:?}\n{got:?}"
            );
            assert_eq!(got.len() + lost.len(), model.len(), "seed {seed}");
            (edges, missing) = (edges + model.len(), missing + lost.len());
        }
        worst = worst.max(late);
    }
    println!("{edges} pulses, {missing} missing, read {worst} counts before the end of what is known");
    assert!(edges > 20 * runs as usize, "{edges}");
    assert!(missing > 0 && missing * 4 < edges, "{missing} of {edges}");
    assert!(worst <= 7 * u64::from(GATE_MIN_COUNTS) + 1, "{worst}");
}

/// The pulses of a train, in counts from the beginning of the first one, and the ends of what each
/// tick has queued; for as many counts at least.
fn carried_out(train: Train, whole: u64) -> (Pulses, Vec<u64>) {
    let lasts = 250_000;
    let mut cycles = PwmCycles::from(BEGIN_COUNTS, SCALE);
    let (mut from, mut queued) = (counts(lasts), BEGIN_COUNTS);
    let begin = from;
    let (mut pulses, mut ends) = (Pulses::new(), Vec::new());
    let mut plan = LaserPlan::EMPTY;
    plan.add(0, Action::Light(train));
    while queued < begin + whole {
        let to = from + counts(lasts);
        cycles.take(from, to, plan.actions().iter().copied(), &mut |length, on, times| {
            for _ in 0..times {
                if let Some(at) = queued.checked_sub(begin) {
                    note(&mut pulses, at, at + u64::from(on));
                }
                queued += u64::from(length);
            }
        });
        ends.extend(queued.checked_sub(begin).filter(|end| *end > 0));
        plan = LaserPlan::EMPTY;
        from = to;
    }
    (pulses, ends)
}

/// Every frequency from 1 Hz to 2 MHz and every duty (SPEC 11). The train's own numbers are within
/// 1 ppm and 0.001 %. In every tick the sums of its periods and of its light are right to a count.
/// Between, a pulse is at most [`SHIFT_COUNTS`] counts late: 0.3 ppm of a second.
#[test]
fn frequencies_and_duties_are_exact_in_the_mean() {
    let clock = Clock::from_mhz(MHZ).unwrap();
    let mut random = Random::new(3);
    // mHz: a grid over the magnitudes, cycle ones, and any.
    let mut frequencies: Vec<u64> = (0..=240).map(|n| (1000.0 * 10f64.powf(f64::from(n) / 38.087)) as u64).collect();
    frequencies.extend([1, 2, 5, 10, 24, 96, 100, 1000, 1999, 2000].map(|khz| khz * 1_000_000));
    frequencies.extend([1_999_999_999, 1_999_999_000, 1_904_761_905, 333_333_333, 1_000, 1_001, 1_500]);
    frequencies.extend((0..200).map(|_| random.magnitude(1_000, 2_000_000_000)));
    frequencies.extend((0..200).map(|_| 1_000_000_000 + random.below(1_000_000_000)));
    let (mut pulses_seen, mut late) = (0, 0);
    for mhz in frequencies.into_iter().map(|mhz| mhz.min(2_000_000_000)) {
        for duty in [0, 1, 100_000, 50_000, 99_999, random.below(100_001), random.below(100_001)] {
            let power = |value: f64| Power::admit(value.to_bits()).unwrap();
            let train = *Standby::admit(power(mhz as f64 / 1e6), power(duty as f64 / 1e3), clock).unwrap().train();
            let Train { period, width } = train;
            let periods = u64::from(period.of);
            // Counts of the first n periods, and of their light.
            let sum = |count: Count, n: u64| {
                ((u128::from(count.whole) * u128::from(count.of) + u128::from(count.part)) * u128::from(n)
                    / u128::from(count.of)) as u64
            };
            let whole = sum(period, periods);
            let name = format!("{mhz} mHz, {duty}/1000 %: {train:?}");
            let (got, exact) = (u128::from(whole) * u128::from(mhz), u128::from(periods) * 240_000_000_000);
            assert!(got.abs_diff(exact) * 1_000_000 <= got, "{name}");
            let on = u128::from(sum(width, periods)).min(whole.into()) * 100_000;
            assert!(on.abs_diff(u128::from(duty) * u128::from(whole)) <= u128::from(whole), "{name}");
            let (pulses, ends) = carried_out(train, whole);
            if train.is_full() {
                assert!(pulses.len() == 1 && pulses[0].1 >= whole, "{name}: {pulses:?}");
            } else if width.whole == 0 || width.whole + 1 >= period.whole {
                // Which pulses exist, or touch the next one, depends on their order.
                for end in ends {
                    let n = (u128::from(end) * u128::from(periods)).div_ceil(whole.into()) as u64;
                    // The last period may be in progress; what is queued of it has light first.
                    let gone = end - sum(period, n - 1).min(end);
                    let wanted = sum(width, n - 1) + gone.min(width.whole);
                    let apart = light(&pulses, end) - wanted as i64;
                    assert!((-1..=1).contains(&apart), "{name}: {apart} counts of light more up to {end}");
                }
            } else {
                let (mut lit, mut placed) = (0, 0);
                // The last one is in progress.
                for (n, &(begin, end)) in (0..).zip(pulses.iter().rev().skip(1).rev()) {
                    let apart = begin.checked_sub(sum(period, n)).expect("a pulse before its place");
                    late = late.max(apart);
                    assert!(apart <= SHIFT_COUNTS && (end - begin).abs_diff(width.whole) <= 1, "{name}: pulse {n}");
                    assert!(sum(width, n).abs_diff(lit) <= SHIFT_COUNTS, "{name}: {lit} of light before pulse {n}");
                    let (exact, queues) = (apart == 0 && sum(width, n) == lit, ends.get(placed));
                    // The first pulse that no tick before has queued is at its place.
                    if queues.is_some_and(|queued| begin >= *queued) {
                        assert!(exact, "{name}: {n} is {apart} late, after {lit} of light");
                        placed += ends[placed..].iter().take_while(|queued| **queued <= begin).count();
                    }
                    lit += end - begin;
                }
                pulses_seen += pulses.len();
            }
        }
    }
    println!("{pulses_seen} pulses, at most {late} counts late");
    assert!(pulses_seen > 200_000 && late > SHIFT_COUNTS / 2, "{pulses_seen}, {late}");
}

#[test]
fn a_plan_is_held_as_it_was_or_not_at_all() {
    let mut held = DelayLine::new((0..DELAY_LINE_WORDS).map(|_| AtomicU32::new(0)).collect::<Vec<_>>().leak());
    let (mut whole, mut refused) = (0, 0);
    for seed in 0..2_000 {
        let mut random = Random::new(seed);
        let plan = random.plan(250_000);
        let wanted: Vec<(u32, Action)> = plan.actions().to_vec();
        if held.put(&plan) {
            whole += 1;
            assert_eq!(held.actions().collect::<Vec<_>>(), wanted, "seed {seed}");
            let shows = |action: &Action| match action {
                Action::Light(train) | Action::Change(train) | Action::Dark { standby: train, .. } => {
                    !train.is_silent()
                }
                Action::Switch(active) => *active,
                Action::Rate(rate) => !rate.is_pause(),
                Action::Volts(_) => false,
            };
            assert_eq!(held.makes_light(), wanted.iter().any(|(_, action)| shows(action)), "seed {seed}");
        } else {
            refused += 1;
            assert!(wanted.len() > DELAY_LINE_WORDS / 9, "seed {seed}: {} actions", wanted.len());
            assert_eq!((held.actions().count(), held.makes_light()), (0, false));
        }
    }
    assert!(whole > 1_000 && refused > 10, "{whole}, {refused}");
    // What a tick plans at most: 64 actions, of which 18 have a train of their own.
    let mut plan = LaserPlan::EMPTY;
    for n in 0..PLAN_ACTIONS as u32 {
        let train = Train {
            period: Count { whole: 5_000_000_000, part: n.min(17), of: 0 },
            width: Count { whole: 7, part: n.min(17), of: 0 },
        };
        plan.add(249_936 + n, Action::Change(train));
    }
    plan.add(249_999, Action::Volts(3));
    assert!(held.put(&plan));
    assert_eq!(held.actions().collect::<Vec<_>>(), plan.actions());
}
