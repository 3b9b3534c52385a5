//! The model against cases worked out by hand.
use super::*;
use crate::laser_model::Exact;

fn power(family: Family, acts: &[Act], speed: f64, positions: [f64; 4]) -> f64 {
    let acts: Vec<_> = acts.iter().map(|act| (0, act.clone())).collect();
    light(family, &acts).power(0).value(family, |_, _| speed, |_| positions)
}

fn mode(min: i128, max: i128) -> Act {
    let (min, max) = (Exact::from_integer(min), Exact::from_integer(max));
    Act::Own(Command::PowerMode { mode: Mode::Duty, max, min, delayed: true })
}

fn follow(ratio: f64, min: f64, max: f64) -> Act {
    let bounds = Bounds { min, max };
    Act::Entry(0, Buffered::Follow { law: Law::Ratio(ratio), bounds, source: None })
}

fn distance(ratio: f64, bounds: Option<(f64, f64)>) -> Act {
    Act::Distance(Some(Distance {
        source: Source::Planned,
        reference: [100.0, 0.0, 0.0, 0.0],
        scale: [1000.0; 4],
        ratios: Ratios::Fixed([ratio, 0.0, 0.0, 0.0]),
        bounds: bounds.map(|(min, max)| Bounds { min, max }),
    }))
}

/// The manuals' numbers, and the table of bounds, worked out by hand.
#[test]
fn powers() {
    use Family::{Gus, Lsr};
    let direct = Act::Entry(0, Buffered::Power(7.0));
    let listing = [mode(0, 100), direct.clone(), follow(0.1, 10.0, 100.0)];
    // x = 0.1·50 + 10; LSR adds the direct power.
    assert_eq!(power(Gus, &listing, 50.0, [0.0; 4]), 15.0);
    assert_eq!(power(Lsr, &listing, 50.0, [0.0; 4]), 22.0);
    assert_eq!(power(Gus, &listing, 5000.0, [0.0; 4]), 100.0);
    // A direct power ends it in GUS.
    let ended = [follow(0.1, 10.0, 100.0), direct.clone()];
    assert_eq!(power(Gus, &ended, 50.0, [0.0; 4]), 7.0);
    assert_eq!(power(Lsr, &ended, 50.0, [0.0; 4]), 22.0);
    // 10000 pulses away, 0.1 for 1000: 1 more. In GUS the velocity part has its own bounds.
    let both = [mode(0, 100), follow(0.1, 10.0, 14.0), distance(0.1, Some((0.0, 90.0)))];
    assert_eq!(power(Gus, &both, 50.0, [10_100.0, 0.0, 0.0, 0.0]), 15.0);
    assert_eq!(power(Lsr, &both, 50.0, [10_100.0, 0.0, 0.0, 0.0]), 14.0);
    // The sum is held in the distance bounds, then in those of the mode.
    let low = [mode(20, 30), follow(0.1, 10.0, 14.0), distance(0.1, Some((0.0, 12.0)))];
    assert_eq!(power(Gus, &low, 0.0, [0.0; 4]), 12.0, "the lowest of the upper bounds");
    let points = vec![(10.0, 20.0), (20.0, 60.0)];
    let table = |at: f64| between(&points, at);
    assert_eq!([table(0.0), table(10.0), table(12.5), table(20.0), table(99.0)], [20.0, 20.0, 30.0, 60.0, 60.0]);
}

fn entry(crd: u8, on: bool) -> Act {
    Act::Entry(crd, Buffered::Gate(on))
}

fn call(on: bool) -> Act {
    Act::Own(Command::Gate(on))
}

/// A Stop, after which it is at standstill.
fn stop(crd: u8) -> [Act; 2] {
    [Act::Stops { crd }, Act::Rests { crd, stopped: true }]
}

/// Whether there is light after each of these.
#[track_caller]
fn lights(acts: &[Act], expected: &str) {
    let published: String = (1..=acts.len())
        .map(|count| {
            let acts: Vec<_> = acts[..count].iter().cloned().zip(1..).map(|(act, at)| (at, act)).collect();
            let job = light(Family::Gus, &acts).job;
            let edges = crate::laser_model::outcome(Family::Gus, &job, 1000).gate;
            if crate::laser_model::level_at(&edges, 999, false) { '#' } else { '_' }
        })
        .collect();
    assert_eq!(published, expected, "{acts:?}");
}

const BEGINS: Act = Act::Starts { crd: 0, resumes: false };
const GOES_ON: Act = Act::Starts { crd: 0, resumes: true };
const RUNS_OUT: Act = Act::Rests { crd: 0, stopped: false };

fn all(parts: &[&[Act]]) -> Vec<Act> {
    parts.concat()
}

/// SPEC 6 "Whose light it is".
#[test]
fn a_map_decides_who_may_light() {
    lights(&[Act::Map(0b10), BEGINS, entry(0, true)], "___");
    // Off entries, powers and follows neither.
    lights(&[Act::Map(0b10), BEGINS, call(true), entry(0, false), follow(1.0, 0.0, 1.0), RUNS_OUT], "__####");
    // A buffered on takes over light of a call, and not the reverse.
    lights(&[BEGINS, call(true), RUNS_OUT], "_##");
    lights(&[BEGINS, call(true), entry(0, true), RUNS_OUT], "_##_");
    lights(&[BEGINS, entry(0, true), call(true), RUNS_OUT], "_##_");
    lights(&[Act::Own(Command::Fault), call(true), Act::Own(Command::Clear)], "___");
    lights(&[Act::Own(Command::Connector(false)), call(true), Act::Own(Command::Connector(true))], "___");
}

/// SPEC 6 "Rest".
#[test]
fn a_stop_shuts_off_whoever_lit_and_the_start_that_goes_on_brings_back() {
    for on in [entry(0, true), call(true), entry(1, true)] {
        let lit = all(&[&[BEGINS, Act::Starts { crd: 1, resumes: false }, on.clone()], &stop(0)]);
        let then = |acts: &[Act], expected: &str| lights(&all(&[&lit, acts]), &("__##_".to_owned() + expected));
        then(&[GOES_ON], "#");
        then(&[BEGINS, GOES_ON], "__");
        then(&[call(false), GOES_ON], "__");
        then(&[call(true), GOES_ON], "##");
        // A Stop at standstill.
        then(&[Act::Stops { crd: 0 }, GOES_ON], "__");
        then(&[Act::Own(Command::Fault), Act::Own(Command::Clear), GOES_ON], "___");
        // Reading: each of two Stops has shut it off.
        then(&all(&[&stop(1), &[GOES_ON, Act::Starts { crd: 1, resumes: true }]]), "___#");
    }
    // Entries that run out while it brakes.
    lights(&[BEGINS, call(true), Act::Stops { crd: 0 }, RUNS_OUT], "_##_");
    lights(&[call(true), Act::Stops { crd: 0 }, BEGINS], "#__");
    lights(&all(&[&[Act::Map(0b10), call(true), BEGINS], &stop(0)]), "_####");
    // What it passes as it brakes.
    lights(&[BEGINS, entry(0, true), Act::Stops { crd: 0 }, entry(0, false), entry(0, true)], "_##_#");
    let off = [call(false), entry(0, false), entry(0, true)];
    lights(&all(&[&[BEGINS, entry(0, true), Act::Stops { crd: 0 }], &off]), "_##___");
    lights(&[BEGINS, call(false), Act::Stops { crd: 0 }, entry(0, true), call(true), entry(0, true)], "____##");
    lights(&[BEGINS, call(false), entry(0, true), entry(0, false), Act::Stops { crd: 0 }, entry(0, true)], "__#__#");
}

/// SPEC 6 "Rest": light under a velocity follow.
#[test]
fn under_a_follow_at_rest_light_waits() {
    let followed = [BEGINS, follow(1.0, 0.0, 1.0)];
    lights(&all(&[&followed, &[call(true), RUNS_OUT, BEGINS]]), "__#__");
    let dark = all(&[&followed, &[RUNS_OUT, call(true)]]);
    let then = |acts: &[Act], expected: &str| lights(&all(&[&dark, acts]), &("____".to_owned() + expected));
    then(&[BEGINS], "#");
    then(&[call(false), BEGINS], "__");
    then(&[Act::EndFollow { crds: 1 }, BEGINS], "__");
    then(&[Act::Own(Command::Power(Exact::from_integer(1))), BEGINS], "__");
    // Light that a Stop shut off still returns.
    let end = [Act::EndFollow { crds: 1 }, GOES_ON];
    lights(&all(&[&followed, &[call(true)], &stop(0), &end]), "__##__#");
    lights(&all(&[&followed, &[call(true)], &stop(0), &[call(true)], &end]), "__##____");
}
