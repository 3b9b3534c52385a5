//! What SPEC says of answers that all doors could have wrong together: they are the controller's.
//!
//! In: a program and its answers. Out: the first answer that a rule forbids. A rule looks at calls
//! that follow each other, so that it needs no state of its own.

use crate::player::{Programme, Reported};
use crate::program::{Call, Step};

/// What is wrong with calls that follow each other, in a family.
type Check = fn(&str, &[Made]) -> Option<String>;
/// A call and its answer.
type Made<'a> = (&'a Call, &'a Reported);

fn names(made: &[Made]) -> Vec<&'static str> {
    made.iter().map(|(call, _)| call.function.name).collect()
}

/// The n-th number that was given.
fn given(made: &Made, place: usize) -> f64 {
    match &made.0.values[place] {
        crate::program::Value::Number(text) => text.parse().unwrap(),
        other => panic!("{other:?} is no number"),
    }
}

const LIT: [&str; 6] = ["LaserPowerMode", "LaserOutFrq", "LaserPrfCmd", "LaserOn", "GetLaserFault", "GetLaserPower"];
const STANDBY: [&str; 8] = [
    "LaserPowerMode",
    "LaserPowerMode",
    "LaserPowerMode",
    "LaserOff",
    "LaserOff",
    "SetWaitPulseEx",
    "GetLaserFault",
    "GetLaserPower",
];

/// SPEC 2: in family lsr a minimum outside its range is the range's minimum; the direct power is
/// held between the bounds.
fn lit(family: &str, made: &[Made]) -> Option<String> {
    let (max, min, power) = (given(&made[0], 1), given(&made[0], 2), given(&made[2], 0));
    if given(&made[0], 0) != 0.0 || made.iter().any(|made| channel(made) != 0) || made[4].1.values[0] != 0.0 {
        return None;
    }
    let min = if family == "lsr" && !(0.0..=100.0).contains(&min) { 0.0 } else { min };
    let (expected, reported) = (power.max(min).min(max), made[5].1.values[0]);
    ((expected - reported).abs() > 0.01)
        .then(|| format!("the power is {reported}; direct {power} in {min} to {max} is {expected}"))
}

fn channel(made: &Made) -> i64 {
    made.0.number("channel").unwrap_or(0)
}

/// LSR, command 21: SetWaitPulseEx acts while both channels are PWM.
fn standby(family: &str, made: &[Made]) -> Option<String> {
    let (first, second) = (given(&made[0], 0), given(&made[2], 0));
    if [0, 1, 1, 0, 1].iter().zip(made).any(|(of, made)| channel(made) != *of) || made[6].1.values[0] != 0.0 {
        return None;
    }
    let (mode, reported) = (if channel(&made[7]) == 0 { first } else { second }, made[7].1.values[0]);
    let both = first == 0.0 && second == 0.0;
    let on = given(&made[5], 0) == 1.0 && mode == 0.0 && (both || family == "gus");
    let expected = if on { given(&made[5], 2) } else { 0.0 };
    (reported != expected)
        .then(|| format!("without light the power is {reported}; modes {first} and {second}: {expected}"))
}

/// SPEC 5: as many entries as there is room for at a vertex do not stop the path there. Where it
/// would, it runs 80 ms, not 60.
fn vertex(made: &[(usize, Made)], tick_us: u32) -> Option<(usize, String)> {
    let mut ios = 0;
    for (at, (_, (call, reported))) in made.iter().enumerate() {
        match call.function.name {
            "BufIO" if reported.code == 0 => ios += 1,
            "LnXY" if reported.code == 0 && ios > 8 => {
                let [(_, start), (number, status), ..] = made.get(at + 1..)? else { return None };
                let first = &made[at - ios - 1].1;
                let names = (first.0.function.name, start.0.function.name, status.0.function.name);
                let done = first.1.code == 0 && start.1.code == 0 && status.1.code == 0;
                let whole = |(_, before): &(usize, Made)| {
                    before.0.function.name == "SetOverride" && before.1.code == 0 && given(before, 1) == 1.0
                };
                let lines = given(first, 1) == 400.0 && given(&(call, reported), 1) == 800.0;
                // Its own SetCrdPrm may have been refused, while the other FIFO ran.
                let set_up = |(_, before): &(usize, Made)| before.0.function.name == "SetCrdPrm" && before.1.code == 0;
                let before = (at - ios).checked_sub(4).map(|at| [&made[at], &made[at + 2]]);
                let lines = lines && before.is_some_and(|[set, rate]| set_up(set) && whole(rate));
                let ticks = status.1.tick - start.1.tick;
                if names == ("LnXY", "CrdStart", "CrdStatus")
                    && done
                    && lines
                    && ticks * tick_us < 74_000
                    && status.1.values[0] != 0.0
                {
                    return Some((
                        *number,
                        format!("the path runs after {ticks} ticks, with {ios} entries at its vertex"),
                    ));
                }
                ios = 0;
            }
            _ => ios = 0,
        }
    }
    None
}

/// The first answer that is wrong.
pub fn broken(programme: &Programme, reported: &[Reported]) -> Option<(usize, String)> {
    let calls: Vec<(usize, Made)> = programme
        .steps
        .iter()
        .zip(reported)
        .enumerate()
        .filter_map(|(number, (step, reported))| match step {
            Step::Call(call) => Some((number, (call, reported))),
            _ => None,
        })
        .collect();
    let rules: [(&[&str], Check); 2] = [(&LIT, lit), (&STANDBY, standby)];
    for (rule, check) in rules {
        for (at, window) in calls.windows(rule.len()).enumerate() {
            // In family gus the connector is said to be a laser's just before.
            let connector = |(_, (call, reported)): &(usize, Made)| {
                let laser = (call.number("axis"), call.number("mode")) == (Some(7), Some(1));
                call.function.name == "SetAxisMode" && reported.code == 0 && laser
            };
            if programme.family == "gus" && !calls[at.saturating_sub(2)..at].iter().any(connector) {
                continue;
            }
            // Distance adds to the direct power from then on.
            let distance = |(_, (call, reported)): &(usize, Made)| {
                call.function.name == "SetLaserDisMode" && reported.code == 0 && call.number("mode") != Some(0)
            };
            if calls[..at].iter().any(distance) {
                continue;
            }
            let made: Vec<Made> = window.iter().map(|(_, made)| *made).collect();
            if made.iter().all(|(_, reported)| reported.code == 0)
                && names(&made) == rule
                && let Some(wrong) = check(programme.family, &made)
            {
                return Some((window[rule.len() - 1].0, wrong));
            }
        }
    }
    vertex(&calls, programme.tick_us)
}
