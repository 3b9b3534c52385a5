//! What SPEC says of answers that all doors could have wrong together: they are the controller's.
//!
//! In: a program and its answers. Out: the first answer that a rule forbids. A rule looks at calls that follow each other, so that it
//! needs no state of its own.

use crate::player::{Programme, Told};
use crate::program::{Call, Step};

/// A call and its answer.
type Made<'a> = (&'a Call, &'a Told);

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

/// SPEC 2: in family lsr a minimum outside its range is the range's minimum; the direct power is held between the bounds.
fn lit(family: &str, made: &[Made]) -> Option<String> {
    let (max, min, power) = (given(&made[0], 1), given(&made[0], 2), given(&made[2], 0));
    if given(&made[0], 0) != 0.0 || made.iter().any(|made| channel(made) != 0) || made[4].1.values[0] != 0.0 {
        return None;
    }
    let min = if family == "lsr" && !(0.0..=100.0).contains(&min) { 0.0 } else { min };
    let (expected, told) = (power.max(min).min(max), made[5].1.values[0]);
    ((expected - told).abs() > 1e-6)
        .then(|| format!("the power is {told}; direct {power} in {min} to {max} is {expected}"))
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
    let (mode, told) = (if channel(&made[7]) == 0 { first } else { second }, made[7].1.values[0]);
    let both = first == 0.0 && second == 0.0;
    let on = given(&made[5], 0) == 1.0 && mode == 0.0 && (both || family == "gus");
    let expected = if on { given(&made[5], 2) } else { 0.0 };
    (told != expected).then(|| format!("without light the power is {told}; modes {first} and {second}: {expected}"))
}

/// The first answer that is wrong.
pub fn broken(programme: &Programme, told: &[Told]) -> Option<(usize, String)> {
    let calls: Vec<(usize, Made)> = programme
        .steps
        .iter()
        .zip(told)
        .enumerate()
        .filter_map(|(number, (step, told))| match step {
            Step::Call(call) => Some((number, (call, told))),
            _ => None,
        })
        .collect();
    let rules: [(&[&str], fn(&str, &[Made]) -> Option<String>); 2] = [(&LIT, lit), (&STANDBY, standby)];
    for (rule, check) in rules {
        for window in calls.windows(rule.len()) {
            let made: Vec<Made> = window.iter().map(|(_, made)| *made).collect();
            if made.iter().all(|(_, told)| told.code == 0)
                && names(&made) == rule
                && let Some(wrong) = check(programme.family, &made)
            {
                return Some((window[rule.len() - 1].0, wrong));
            }
        }
    }
    None
}
