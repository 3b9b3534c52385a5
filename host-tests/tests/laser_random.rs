//! The laser channels of the tick against the model: random jobs over the table of mode × gate
//! delays × FPK × standby × family, every edge to the ns. `LASER_JOBS` sets how many jobs are run
//! (a job is a sequence of commands).
#[path = "laser/bench.rs"]
mod bench;
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "laser/dark.rs"]
mod dark;
#[path = "laser/player.rs"]
mod player;
#[path = "laser/random.rs"]
mod random;

use bench::{Bench, Recorded};
use chance::Chance;
use dark::in_the_dark;
use host_tests::laser_model::{Command, Edge, Exact, Family, Job, Mode, Ns, Outcome, level_at, outcome};
use random::{Setup, job, jobs, table};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Tick periods, ns.
const PERIODS: [Ns; 5] = [10_000, 50_000, 125_000, 250_000, 1_000_000];

/// The DAC's code of a voltage, to half a step: 32767 is 10 V.
fn is_code_of(code: i16, volts: Exact) -> bool {
    let off = Exact::from_integer(code.into()) - volts * Exact::new(32767, 10);
    off * off <= Exact::new(1, 4)
}

/// Why they differ, if they do.
fn difference(model: &Outcome, tick: &Recorded, horizon: Ns, wild: bool) -> Result<(), String> {
    let first = |name: &str, model: &[Edge<bool>], tick: &[Edge<bool>]| {
        let length = model.len().max(tick.len());
        match (0..length).find(|&index| model.get(index) != tick.get(index)) {
            Some(index) => {
                let near = |edges: &[Edge<bool>]| {
                    format!("{:?}", &edges[index.saturating_sub(2).min(edges.len())..(index + 3).min(edges.len())])
                };
                Err(format!("{name}, edge {index}: the model has {}, the tick {}", near(model), near(tick)))
            }
            None => Ok(()),
        }
    };
    if tick.outputs != tick.stage {
        return Err(format!("the boards' output stage makes {:?} of {:?}", tick.stage, tick.outputs));
    }
    first("switch", &model.switch, &tick.outputs.switch)?;
    in_the_dark(model, &tick.outputs.energy, horizon, 0)?;
    // What is dithered is only near the model's exact numbers: see
    // `a_dithered_mark_is_as_near_as_it_must_be`.
    if !wild {
        first("energy", &model.energy, &tick.outputs.energy)?;
    }
    let same = model.analog.len() == tick.outputs.volts.len()
        && model.analog.iter().zip(&tick.outputs.volts).all(|(a, b)| a.0 == b.0 && is_code_of(b.1, a.1));
    if !same {
        return Err(format!("analog: the model has {:?}, the tick {:?}", model.analog, tick.outputs.volts));
    }
    // The tick sees a fault at its instant, and tells of it in the next one.
    let seen = |at: Ns| at < horizon && !model.faults.contains(&at);
    for (at, view) in tick.views.iter().filter(|(at, _)| seen(*at)) {
        let light = model.light.iter().any(|span| span.begin <= *at && *at < span.end);
        let mine = (
            model.commanded_at(*at),
            level_at(&model.gate, *at, false),
            level_at(&model.switch, *at, false),
            light,
            (model.on_time(*at) / 250_000) as u32,
        );
        let theirs = (view.commanded, view.gate, view.switch, view.light, view.on_time);
        if mine != theirs {
            return Err(format!("view at {at} (command, gate, switch, light, on-time): {mine:?}, the tick {theirs:?}"));
        }
    }
    Ok(())
}

fn listed(job: &Job) -> String {
    job.iter().map(|(at, command)| format!("{at:>12} {command:?}\n")).collect::<String>().replace("Ratio ", "")
}

/// Job number so much: reproducible.
fn check(bench: &mut Bench, setups: &[Setup], number: u64) -> usize {
    let chance = &mut Chance::new(number);
    let mut setup = setups[number as usize % setups.len()];
    setup.wild = chance.below(4) == 0;
    let setup = &setup;
    let period = PERIODS[chance.below(PERIODS.len() as u64) as usize];
    let ticks = 4 + chance.below(40) as i64;
    // Light that is still to come is played out, mostly.
    let horizon = (ticks + 2 + chance.below(20) as i64) * period;
    let jobs = jobs(chance, setup, period, ticks);
    let plans = chance.below(2) == 0;
    let done = bench.run(setup.family, [&jobs[0], &jobs[1]], period, horizon, Some(1), plans);
    for (channel, (job, done)) in jobs.iter().zip(&done).enumerate() {
        let model = outcome(setup.family, job, horizon);
        if let Err(reason) = difference(&model, done, horizon, setup.wild) {
            let (job, reason) = shortest(bench, setup, job, period, horizon, plans, reason);
            panic!(
                "found after {} programs: job {number}, channel {channel}, {setup:?}, tick {period} ns, planned ahead {plans}: {reason}\n{}",
                number + 1,
                listed(&job)
            );
        }
    }
    jobs.iter().map(|job| job.len()).sum()
}

/// The job without the commands that are not needed to show a difference.
fn shortest(
    bench: &mut Bench,
    setup: &Setup,
    job: &Job,
    period: Ns,
    horizon: Ns,
    plans: bool,
    mut reason: String,
) -> (Vec<(Ns, Command)>, String) {
    let mut job = job.to_vec();
    let mut index = job.len();
    while index > 0 {
        index -= 1;
        let mut less = job.clone();
        less.remove(index);
        let done = bench.run(setup.family, [&less, &[]], period, horizon, Some(1), plans);
        if let Err(other) = difference(&outcome(setup.family, &less, horizon), &done[0], horizon, setup.wild) {
            (job, reason) = (less, other);
        }
    }
    (job, reason)
}

#[test]
fn every_edge_is_the_models_to_the_ns() {
    let jobs = std::env::var("LASER_JOBS").map_or(4_000, |text| text.parse().expect("a number"));
    let setups: Vec<Setup> = table().collect();
    let next = AtomicU64::new(0);
    let commands = AtomicU64::new(0);
    let begun = std::time::Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let mut bench = Bench::new();
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    if number >= jobs {
                        break;
                    }
                    commands.fetch_add(check(&mut bench, &setups, number) as u64, Relaxed);
                }
            });
        }
    });
    println!("{} jobs on two channels, {commands:?} commands, {:?}", jobs, begun.elapsed());
    assert!(commands.into_inner() >= jobs * 10);
}

/// Commands at whole ms act at the same instants whatever the tick is.
#[test]
fn the_tick_period_moves_no_edge() {
    let mut bench = Bench::new();
    let setups: Vec<Setup> = table().collect();
    for number in 0..60 {
        let chance = &mut Chance::new(1 << 40 | number);
        let setup = &setups[chance.below(setups.len() as u64) as usize];
        let job = job(chance, setup, 1_000_000, 12);
        let model = outcome(setup.family, &job, 20_000_000);
        for us in [10, 20, 25, 40, 50, 100, 125, 200, 250, 500, 1000] {
            let [done, _] = bench.run(setup.family, [&job, &[]], us * 1000, 20_000_000, Some(1), number % 2 == 0);
            if let Err(reason) = difference(&model, &done, 20_000_000, false) {
                panic!("job {number} at {us} µs, {setup:?}: {reason}\n{}", listed(&job));
            }
        }
    }
}

/// The manual's hazard: delays, and a power that changes on every tick. After the gate's off edge
/// there is the last pulse at most, in every mode.
#[test]
fn no_light_after_off_while_the_power_changes_on_every_tick() {
    let mut bench = Bench::new();
    for setup in table().filter(|setup| !setup.waiting) {
        for period in [10_000, 50_000, 1_000_000] {
            let chance = &mut Chance::new(setup.delays.0 as u64);
            let mut at = period;
            let setting =
                job(chance, &setup, period, 1).into_iter().filter(|(_, command)| !matches!(command, Command::Gate(_)));
            let mut job: Vec<(Ns, Command)> = setting.collect();
            job.retain(|(at, command)| {
                *at == period && !matches!(command, Command::Fault | Command::Clear | Command::Standby(_))
            });
            let delayed = Command::Delays { off: setup.delays.0 * 1000, on: setup.delays.1 * 1000 };
            job.extend([(at, delayed), (at, Command::Carrier(Exact::from_integer(20))), (at, Command::Width(20_000))]);
            let off = 20 * period + 70_000_000 / period * period;
            let horizon = off + 10 * period + 140_000_000;
            while at < horizon - period {
                at += period;
                if at == 2 * period {
                    job.push((at, Command::Gate(true)));
                }
                let near = |instant: Ns| (at - instant).abs() < 40 * period || (at - instant) / period % 64 == 0;
                if near(off) || near(off + setup.delays.0 * 1000) {
                    job.push((
                        at,
                        Command::Power(Exact::from_integer([1, 2, 4, 5, 8, 10][(at / period % 6) as usize])),
                    ));
                }
                if at == off {
                    job.push((at, Command::Gate(false)));
                }
            }
            let [done, _] = bench.run(setup.family, [&job, &[]], period, horizon, None, false);
            let model = outcome(setup.family, &job, horizon);
            let dark = model.light.last().expect("no light").end;
            assert!(dark < horizon, "it goes dark");
            let late = done.outputs.energy.iter().filter(|(at, _)| *at > dark + 100_000).count();
            assert_eq!(late, 0, "{setup:?} tick {period}: energy after {dark}: {:?}", done.outputs.energy.last());
            assert!(!done.outputs.energy.last().is_some_and(|(_, level)| *level));
            assert!(
                done.outputs.volts.last().is_none_or(|(at, code)| *at == dark && *code == 0),
                "{:?}",
                done.outputs.volts.last()
            );
            if let Err(reason) = difference(&model, &done, horizon, setup.wild) {
                panic!("{setup:?}, tick {period}: {reason}");
            }
        }
    }
}

/// One mark of settings that need dither: as many edges as the model has, each within a count of
/// its ideal instant and 1 ppm of the time since the mark began.
#[test]
fn a_dithered_mark_is_as_near_as_it_must_be() {
    let mut bench = Bench::new();
    let chance = &mut Chance::new(6);
    for number in 0..2000 {
        let duty = number % 2 == 0;
        let khz = Exact::new(10_000 + chance.below(990_000) as i128, 1000);
        let percent = Exact::new(5_000 + chance.below(90_000) as i128, 1000);
        let mode = if duty { Mode::Duty } else { Mode::Frequency };
        let zero = Exact::from_integer(0);
        let max = Exact::from_integer(if duty { 100 } else { 2000 });
        let job = [
            (50_000, Command::PowerMode { mode, max, min: zero, delayed: true }),
            (50_000, Command::Carrier(khz)),
            (50_000, Command::Width(1000)),
            (50_000, Command::Power(if duty { percent } else { khz.min(Exact::from_integer(900)) })),
            (50_000, Command::Gate(true)),
        ];
        let horizon = 1_000_000;
        let [done, _] = bench.run(Family::Gus, [&job, &[]], 50_000, horizon, None, number % 4 < 2);
        let model = outcome(Family::Gus, &job, horizon + 300_000);
        assert!(done.outputs == done.stage);
        let count = model.energy.iter().filter(|(at, _)| *at < horizon).count();
        assert!(done.outputs.energy.len().abs_diff(count) <= 1, "an edge at the horizon");
        for (at, level) in &done.outputs.energy {
            // Beginnings against beginnings, ends against ends.
            let place = model.energy.partition_point(|(ideal, _)| ideal < at);
            let near = model.energy[place.saturating_sub(3)..(place + 3).min(model.energy.len())].iter();
            let off = near.filter(|(_, of)| of == level).map(|(ideal, _)| (ideal - at).abs()).min().unwrap_or(0);
            assert!(off <= 2, "{khz} kHz {percent} %: {at} is {off} ns off");
        }
    }
}

/// A clear that acts on the tick that sees a fault cannot have meant it: everything goes to rest,
/// and stays so.
#[test]
fn a_clear_does_not_hide_the_fault_that_comes_with_it() {
    let mut bench = Bench::new();
    let period = 10_000;
    // What passes by itself: an overrun, a restart.
    for at in [100_000, 110_000].map(|at| at - at % 30_000).into_iter().flat_map(|at| [at + 10_000, at + 20_000]) {
        let job = [
            (period, Command::Gate(true)),
            (at, Command::Fault),
            (at + period, Command::Clear),
            (at + 2 * period, Command::Gate(true)),
            (at + 3 * period, Command::Clear),
            (at + 4 * period, Command::Gate(true)),
        ];
        let [done, _] = bench.run(Family::Gus, [&job, &[]], period, at + 10 * period, Some(1), false);
        assert_eq!(done.outputs.switch, [(period, true), (at, false), (at + 4 * period, true)]);
        let fault = |at: Ns| done.views[(at / period - 1) as usize].1.fault;
        assert_eq!([fault(at + 3 * period) as u8, fault(at + 2 * period) as u8], [0, fault(at + period) as u8]);
    }
}

/// Light as the switch output shows it, summed over a million marks of all kinds of lengths.
#[test]
fn the_on_time_is_the_sum_of_a_million_marks() {
    let mut bench = Bench::new();
    let chance = &mut Chance::new(4);
    let period = 10_000;
    let mut job = vec![];
    let mut at = period;
    for _ in 0..1_000_000 {
        let (off, on) = (chance.below(9) as Ns * 1000, chance.below(9) as Ns * 1000);
        job.push((at, Command::Delays { off, on }));
        job.push((at, Command::Gate(true)));
        at += period * (1 + chance.below(2) as Ns);
        job.push((at, Command::Gate(false)));
        at += period * (1 + chance.below(2) as Ns);
    }
    let horizon = at + period;
    let [done, _] = bench.run(Family::Gus, [&job, &[]], period, horizon, Some(100_000), false);
    assert!(done.outputs.switch.len() == 2_000_000, "{} edges", done.outputs.switch.len());
    let light: Ns = done.outputs.switch.chunks(2).map(|pair| pair[1].0 - pair[0].0).sum();
    assert!(done.views.len() > 20);
    let (_, last) = done.views.last().unwrap();
    let until = done.views.last().unwrap().0;
    let seen: Ns = done
        .outputs
        .switch
        .chunks(2)
        .filter(|pair| pair[0].0 < until)
        .map(|pair| pair[1].0.min(until) - pair[0].0)
        .sum();
    assert_eq!(Ns::from(last.on_time), seen / 250_000);
    assert!(light - seen < 100_000 * period);
}
