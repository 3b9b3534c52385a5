//! Random whole programs of both families beside an independent judge of light: see
//! `host_tests::light_judge`.
//!
//! `LIGHT_PROGRAMS` sets how many programs there are, `LIGHT_SEED` the first one's number.
//! `LIGHT_PLANTED=1` is for a firmware with a planted fault: the test then succeeds only if the
//! judge finds something. `LIGHT_FINDINGS` sets how many programs that differ are reported before
//! it gives up; `LIGHT_STEP=6` and `LIGHT_THREADS=1` run those of one controller in order.
//! `LIGHT_PULSES=1` prints the energy pulses of programs that differ.
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "light_judge/facts.rs"]
mod facts;
#[path = "light_judge/generator.rs"]
mod generator;
#[path = "light_judge/lateness.rs"]
mod lateness;
#[path = "light_judge/machine.rs"]
mod machine;
#[path = "light_judge/program.rs"]
mod program;

use host_tests::light_judge::{Fact, Given, Judge, compare};
use machine::{Reported, Rig, Sent};
use program::{Buf, Do, Program};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

const TICKS_US: [u32; 3] = [250, 500, 1000];

/// What as many programs as run by default, and more, must have needed.
const NEEDED: &[&str] = &[
    "abort",
    "refused call, abort",
    "close",
    "killed client",
    "second session",
    "stop",
    "stop twice",
    "stop, an off while it brakes",
    "interlock",
    "alarm",
    "limit",
    "servo off",
    "overrun",
    "following error",
    "two causes",
    "link loss, client back",
    "end of the entries",
    "cause of SPEC 9",
    "underrun",
    "new session",
    "connector taken away",
    "on entry without a connector",
    "on entry under a fault",
    "on entry ahead of an abort",
    "on entry ahead of a new session",
    "on entry after an off, braking",
    "on in vain, a path's light is on",
    "on instead of kept light",
    "another FIFO in between",
    "entry outside the map",
    "stop shut off light of a call",
    "two hold one light",
    "light waits under a follow",
    "follow ended before its start",
    "map refused for light",
    "map ends a follow",
    "abort while it brakes",
    "abort of a jog axis",
    "other delays",
    "another mode",
    "light came back after a lost link",
    "silence within the time",
    "light came back with a start",
    "stop shut off light",
    "stop at rest shut off light",
    "the end of a path shut off its light",
    "the end of a path shut off light that followed it",
    "lost link took light",
    "start before the lost link was cleared",
    "map done",
    "map refused",
    "on done",
    "on refused",
    "spans of light",
];

/// How often what was needed.
type Tally = BTreeMap<&'static str, u64>;

/// What the judge says of a program that ran.
fn judged(program: &Program, reported: &Reported, facts: &[Fact], tick: i64, tally: &mut Tally) -> Result<(), String> {
    let mut judge = Judge::new(program.settings, tick);
    for fact in facts {
        judge.take(fact);
    }
    let until = reported.end - tick;
    let (verdicts, wrong, used) = judge.finish(until);
    for rule in used.iter().chain(&program.endings) {
        *tally.entry(rule).or_default() += 1;
    }
    if let Some(wrong) = wrong.first() {
        return Err(wrong.clone());
    }
    for (channel, verdict) in verdicts.iter().enumerate() {
        let of = &program.settings.channels[channel];
        let given = Given {
            timing: &of.timing,
            output: of.output,
            switch: program.devices[channel].switch,
            from: reported.begin,
            until,
        };
        let lit = compare(&given, verdict, &reported.lasers[channel])
            .map_err(|reason| format!("channel {channel}: {reason}"))?;
        *tally.entry("spans of light").or_default() += lit as u64;
    }
    Ok(())
}

fn one(rig: &mut Rig, seed: u64, is_gus: bool, tally: &mut Tally) -> Result<(), String> {
    let program = generator::program(seed, is_gus, rig.tick);
    let tick_us = (rig.tick / 1000) as u32;
    let reported =
        rig.run(&program).map_err(|reason| format!("program {seed}: {reason}\n{}", program.reported(tick_us)))?;
    if reported.sent.iter().any(|sent| sent.code.is_none() && sent.call.sets()) {
        // Nobody knows what is set.
        return Ok(());
    }
    let refused = |sent: &Sent| sent.code != Some(0) && matches!(sent.call, Do::Entry { buf: Buf::Line { .. }, .. });
    if reported.sent.iter().any(refused) {
        // Two marks without a motion between them change nothing that could be seen.
        return Ok(());
    }
    let facts = facts::facts(&program, &reported, rig.tick);
    judged(&program, &reported, &facts, rig.tick, tally).map_err(|reason| {
        let mut text = format!("program {seed}, tick {tick_us} µs, from {}: {reason}\n", reported.begin);
        text += &program.reported(tick_us);
        text += "answers:\n";
        for sent in &reported.sent {
            text += &format!(
                "     {:>10.6} ms {:?} -> {:?}\n",
                (sent.at - reported.begin) as f64 / 1e6,
                sent.call,
                sent.code
            );
        }
        text += &outputs(&reported);
        text += "facts:\n";
        for fact in &facts {
            let ms = |at: i64| (at - reported.begin) as f64 / 1e6;
            text += &format!("     {:>10.6} {:>10.6} ms {:?}\n", ms(fact.lo), ms(fact.hi), fact.what);
        }
        text
    })
}

/// What the slow outputs did, ms.
fn outputs(reported: &Reported) -> String {
    let ms = |at: i64| (at - reported.begin) as f64 / 1e6;
    let mut text = String::new();
    for (channel, of) in reported.lasers.iter().enumerate() {
        let switch: Vec<_> = of.switch.iter().map(|edge| (ms(edge.0), edge.1)).collect();
        let volts: Vec<_> = of.volts.iter().map(|edge| (ms(edge.0), edge.1)).collect();
        text += &format!("outputs of channel {channel}: switch {switch:?}, volts {volts:?}\n");
        if std::env::var("LIGHT_PULSES").is_ok() {
            let pulses: Vec<_> = of.pulses.iter().map(|pulse| (ms(pulse.0), ms(pulse.1))).collect();
            text += &format!("  pulses {pulses:?}\n");
        }
    }
    text
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn light_only_where_it_was_asked_for() {
    let (count, first) = (number("LIGHT_PROGRAMS", 4000), number("LIGHT_SEED", 1));
    let planted = number("LIGHT_PLANTED", 0) == 1;
    let most = if planted { 1 } else { number("LIGHT_FINDINGS", 1) };
    let step = number("LIGHT_STEP", 1);
    let threads = number("LIGHT_THREADS", std::thread::available_parallelism().map_or(1, |count| count.get() as u64));
    let (next, found) = (AtomicU64::new(0), AtomicU64::new(0));
    let (tallies, reports) = (Mutex::new(Tally::new()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut rigs: Vec<Rig> =
                    TICKS_US.iter().flat_map(|us| [true, false].map(|is_gus| Rig::new(is_gus, *us))).collect();
                let (mut tally, mut last) = (Tally::new(), [0; 6]);
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    if number >= count || found.load(Relaxed) >= most {
                        break;
                    }
                    let seed = first + number * step;
                    let kind = (seed % 6) as usize;
                    let before = std::mem::replace(&mut last[kind], seed);
                    if let Err(report) = one(&mut rigs[kind], seed, kind.is_multiple_of(2), &mut tally) {
                        found.fetch_add(1, Relaxed);
                        let report = format!("{report}before it on the same controller: program {before}\n");
                        reports.lock().unwrap().push((number + 1, report));
                    }
                }
                let mut all = tallies.lock().unwrap();
                for (rule, count) in tally {
                    *all.entry(rule).or_default() += count;
                }
            });
        }
    });
    let (tally, mut reports) = (tallies.into_inner().unwrap(), reports.into_inner().unwrap());
    reports.sort();
    let done = next.load(Relaxed).min(count);
    println!("{done} programs, {} differ", reports.len());
    for (rule, count) in &tally {
        println!("{count:>9} {rule}");
    }
    if planted {
        assert!(!reports.is_empty(), "{done} programs did not find the planted fault");
        println!("found after {} programs:\n{}", reports[0].0, reports[0].1);
        return;
    }
    if reports.is_empty() && done >= 4000 {
        // So that the generator cannot rot unseen.
        for name in NEEDED {
            assert!(tally.get(name).is_some_and(|count| *count >= 2), "{name}: {:?} times", tally.get(name));
        }
    }
    let reported: String = reports.iter().map(|(_, report)| format!("{report}\n")).collect();
    assert!(reports.is_empty(), "{} of {done} programs differ:\n{reported}", reports.len());
}
