//! The judge must be able to fail: wrong light of every kind, and it says so.
use super::fact::{Fact, What};
use super::gate::{Fpk, Timing};
use super::outputs::{Given, Output, Recorded, Switch, compare};
use super::{Judge, Ns, Verdict};

const MS: Ns = 1_000_000;
const TIMING: Timing = Timing { on: 0, off: 0, fpk: None };

/// Light from 1 to 2 ms, then a cut by an abort at 3 to 4 ms, within the light of another on.
fn verdict() -> Verdict {
    let mut judge = Judge::new(super::cases::settings(), 1000);
    let on = What::On { channel: 0, code: 0, sure: true };
    for (at, what) in [(MS, on), (2 * MS, What::Off { channel: 0 }), (3 * MS, on), (4 * MS, What::Abort)] {
        judge.take(&Fact::at(at, what));
    }
    let ([verdict, _], wrong, _) = judge.finish(6 * MS);
    assert!(wrong.is_empty());
    verdict
}

fn given<'a>(timing: &'a Timing, output: Output, switch: Switch) -> Given<'a> {
    Given { timing, output, switch, from: 0, until: 6 * MS }
}

/// Pulses of 30 in 50 µs between these ms.
fn pulses(spans: &[(f64, f64)]) -> Vec<(Ns, Ns)> {
    let ns = |ms: f64| (ms * 1e6) as Ns;
    let of = |&(from, to): &(f64, f64)| (0..).map(move |k| ns(from) + k * 50_000).take_while(move |at| *at < ns(to));
    spans.iter().flat_map(of).map(|at| (at, at + 30_000)).collect()
}

fn switch(spans: &[(f64, f64)]) -> Vec<(Ns, bool)> {
    spans.iter().flat_map(|(from, to)| [((from * 1e6) as Ns, true), ((to * 1e6) as Ns, false)]).collect()
}

fn pulsed(light: &[(f64, f64)], gate: &[(f64, f64)], extra: &[(Ns, Ns)]) -> Result<usize, String> {
    let mut all = pulses(light);
    all.extend(extra);
    all.sort_unstable();
    let recorded = Recorded { pulses: all, switch: switch(gate), volts: vec![] };
    let output = Output::Pulses { period: 50_000, standby: 16_000 };
    compare(&given(&TIMING, output, Switch::Gate), &verdict(), &recorded)
}

const RIGHT: [(f64, f64); 2] = [(1.0, 2.0), (3.0, 4.0)];

#[test]
fn right_light_is_right() {
    assert_eq!(pulsed(&RIGHT, &RIGHT, &[]), Ok(2));
    // A standby pulse in the dark, and a last pulse that is finished.
    let last = (2 * MS - 1000, 2 * MS + 29_000);
    assert_eq!(pulsed(&RIGHT, &RIGHT, &[(MS / 2, MS / 2 + 16_000)]), Ok(2));
    let mut short = pulses(&[(1.0, 1.99), (3.0, 4.0)]);
    short.push(last);
    short.sort_unstable();
    let recorded = Recorded { pulses: short, switch: switch(&RIGHT), volts: vec![] };
    let output = Output::Pulses { period: 50_000, standby: 16_000 };
    assert_eq!(compare(&given(&TIMING, output, Switch::Gate), &verdict(), &recorded), Ok(2));
}

#[test]
fn wrong_pulses_are_found() {
    let wrong = |light: &[(f64, f64)], extra: &[(Ns, Ns)]| pulsed(light, &RIGHT, extra).is_err();
    assert!(wrong(&[(1.0, 2.0)], &[]), "light that is missing");
    assert!(wrong(&[(1.0, 2.1), (3.0, 4.0)], &[]), "light that goes on");
    assert!(wrong(&[(0.9, 2.0), (3.0, 4.0)], &[]), "light that begins early");
    assert!(wrong(&[(1.2, 2.0), (3.0, 4.0)], &[]), "light that begins late");
    assert!(wrong(&[(1.0, 1.4), (1.6, 2.0), (3.0, 4.0)], &[]), "a gap");
    assert!(wrong(&RIGHT, &[(5 * MS, 5 * MS + 30_000)]), "a pulse after the abort");
    assert!(wrong(&RIGHT, &[(5 * MS, 5 * MS + 16_000)]), "standby after the abort");
    assert!(wrong(&RIGHT, &[(2_500_000, 2_530_000)]), "a pulse in the dark");
    assert!(wrong(&RIGHT, &[(1_999_000, 2_150_000)]), "a last pulse that is too long");
    assert!(wrong(&RIGHT, &[(3_990_000, 4_020_000)]), "a last pulse that an abort does not cut");
}

#[test]
fn a_wrong_switch_is_found() {
    assert!(pulsed(&RIGHT, &[(1.0, 2.0), (3.0, 4.001)], &[]).is_err());
    assert!(pulsed(&RIGHT, &[(1.0, 1.999), (3.0, 4.0)], &[]).is_err());
    assert!(pulsed(&RIGHT, &[(1.0, 2.0)], &[]).is_err());
    let output = Output::Pulses { period: 50_000, standby: 0 };
    let held = |gate: &[(f64, f64)]| {
        let mut edges = vec![(0, true)];
        edges.extend(switch(gate).into_iter().map(|(at, level)| (at, !level)));
        let recorded = Recorded { pulses: pulses(&RIGHT), switch: edges, volts: vec![] };
        compare(&given(&TIMING, output, Switch::Held), &verdict(), &recorded)
    };
    assert_eq!(held(&[(4.0, 6.0)]), Ok(2), "in mode 3 an abort takes the switch too");
    assert!(held(&[(4.5, 6.0)]).is_err());
}

#[test]
fn a_wrong_fpk_pulse_is_found() {
    let fpk = Fpk { time1: 40_000, time2: 0, off: 0 };
    let timing = Timing { fpk: Some(fpk), ..TIMING };
    let output = Output::Pulses { period: 50_000, standby: 0 };
    let with = |gate: &[(f64, f64)]| {
        let recorded = Recorded { pulses: pulses(&RIGHT), switch: switch(gate), volts: vec![] };
        compare(&given(&timing, output, Switch::Gate), &verdict(), &recorded)
    };
    assert_eq!(with(&[(1.0, 1.04), (3.0, 3.04)]), Ok(2));
    assert!(with(&[(2.5, 2.54)]).is_err());
    assert!(with(&[(5.0, 5.04)]).is_err());
}

#[test]
fn wrong_volts_are_found() {
    let output = Output::Volts { waiting: 4915, least: 9800 };
    let with = |volts: &[(f64, i16)]| {
        let volts = volts.iter().map(|(ms, code)| ((ms * 1e6) as Ns, *code)).collect();
        let recorded = Recorded { pulses: vec![], switch: switch(&RIGHT), volts };
        compare(&given(&TIMING, output, Switch::Gate), &verdict(), &recorded)
    };
    let right = [(0.0, 4915), (1.0, 9830), (2.0, 4915), (3.0, 12000), (4.0, 0)];
    assert_eq!(with(&right), Ok(2));
    assert!(with(&[(0.0, 4915), (1.0, 9830), (2.1, 4915), (3.0, 12000), (4.0, 0)]).is_err());
    assert!(with(&[(0.0, 4915), (1.0, 9830), (2.0, 4915), (3.1, 12000), (4.0, 0)]).is_err());
    assert!(with(&[(0.0, 4915), (1.0, 9830), (2.0, 4915), (3.0, 12000), (4.0, 4915)]).is_err());
    assert!(with(&[(1.0, 4915)]).is_err());
}
