//! Sentences of SPEC 6 and 9 by hand: what happens, and the spans of light that must follow.
use super::fact::{Channel, Fact, Laser, Settings, What, Why};
use super::gate::{Timing, light_spans};
use super::outputs::Output;
use super::{Judge, Ns};

/// No delays, both coordinate systems in the map.
pub fn settings() -> Settings {
    let timing = Timing { on: 0, off: 0, fpk: None };
    let output = Output::Pulses { period: 10, standby: 0 };
    let channel = Channel { map: 3, connector: true, timing, output };
    Settings { is_gus: true, set_up: 3, channels: [channel; 2] }
}

const ON: What = What::On { channel: 0, code: 0, sure: true };
const REFUSED: What = What::On { channel: 0, code: 1, sure: true };
const OFF: What = What::Off { channel: 0 };

fn entry(crd: usize, laser: Laser) -> What {
    What::Entry { crd, channel: 0, laser }
}

fn start(crd: usize) -> What {
    What::Start { crd, fifo: 0 }
}

fn stop(crds: u8) -> What {
    What::Stop { crds, ends_follow: 0 }
}

fn rest(crd: usize, why: Why) -> What {
    What::Rest { crd, why }
}

fn cleared(channels: u8) -> What {
    What::Cleared { channels, gone: true, by_name: true }
}

/// Light of channel 0 until 1000, where nothing is in doubt; and the answers that are wrong.
fn reported(settings: Settings, facts: &[(Ns, What)]) -> (Vec<(Ns, Ns)>, usize) {
    let mut judge = Judge::new(settings, 1);
    for &(at, what) in facts {
        judge.take(&Fact::at(at, what));
    }
    let ([verdict, _], wrong, _) = judge.finish(1000);
    let timing = settings.channels[0].timing;
    let spans = |most| -> Vec<(Ns, Ns)> {
        light_spans(&verdict.gates, &timing, most, 1000).iter().map(|lit| (lit.begin, lit.end)).collect()
    };
    assert_eq!(spans(true), spans(false), "nothing is in doubt: {facts:?}");
    (spans(true), wrong.len())
}

fn is(facts: &[(Ns, What)], light: &[(Ns, Ns)]) {
    assert_eq!(reported(settings(), facts), (light.to_vec(), 0), "{facts:?}");
}

#[test]
fn calls_and_entries() {
    is(&[(10, ON), (50, OFF)], &[(10, 50)]);
    let path = [(10, start(0)), (20, entry(0, Laser::On)), (50, entry(0, Laser::Off)), (60, rest(0, Why::Done))];
    is(&path, &[(20, 50)]);
    // Light of its entries ends with it; light of a call does not.
    is(&[(10, start(0)), (20, entry(0, Laser::On)), (60, rest(0, Why::Done))], &[(20, 60)]);
    is(&[(5, ON), (10, start(0)), (60, rest(0, Why::Done)), (90, OFF)], &[(5, 90)]);
    // An immediate on while a path's light is on changes nothing; an entry takes over light of a
    // call.
    is(&[(10, start(0)), (20, entry(0, Laser::On)), (30, ON), (60, rest(0, Why::Done))], &[(20, 60)]);
    is(&[(5, ON), (10, start(0)), (20, entry(0, Laser::On)), (60, rest(0, Why::Done))], &[(5, 60)]);
}

#[test]
fn a_stop_and_the_start_after_it() {
    let stopped = [(10, start(0)), (20, entry(0, Laser::On)), (30, stop(1)), (40, rest(0, Why::Stopped))];
    let and = |more: &[(Ns, What)]| [&stopped[..], more].concat();
    is(&stopped, &[(20, 40)]);
    is(&and(&[(60, start(0)), (90, rest(0, Why::Done))]), &[(20, 40), (60, 90)]);
    // Whoever lit it.
    is(
        &[(5, ON), (10, start(0)), (30, stop(1)), (40, rest(0, Why::Stopped)), (60, start(0)), (80, OFF)],
        &[(5, 40), (60, 80)],
    );
    // Not after CrdClear, an off, or a Stop at standstill.
    is(&and(&[(50, What::CrdClear { crd: 0, fifo: 0 }), (60, start(0))]), &[(20, 40)]);
    is(&and(&[(50, OFF), (60, start(0))]), &[(20, 40)]);
    is(&and(&[(50, stop(1)), (60, start(0))]), &[(20, 40)]);
    // The other FIFO in between brings nothing back, and takes nothing from a call's light.
    is(&and(&[(50, What::Start { crd: 0, fifo: 1 }), (55, rest(0, Why::Stopped))]), &[(20, 40)]);
    // An on replaces it.
    is(&and(&[(50, ON), (60, start(0)), (70, rest(0, Why::Done)), (80, OFF)]), &[(20, 40), (50, 80)]);
    // Two Stops: when each has gone on.
    let both = [
        (5, ON),
        (10, start(0)),
        (10, start(1)),
        (20, stop(3)),
        (30, rest(0, Why::Stopped)),
        (40, rest(1, Why::Stopped)),
    ];
    let more = [(50, start(1)), (60, start(0)), (70, OFF)];
    is(&[&both[..], &more].concat(), &[(5, 30), (60, 70)]);
    // Its entries run out while it brakes.
    is(&[(5, ON), (10, start(0)), (30, stop(1)), (40, rest(0, Why::Done)), (60, start(0))], &[(5, 40)]);
}

#[test]
fn a_stop_at_rest() {
    is(&[(5, ON), (30, stop(2)), (60, start(1))], &[(5, 30)]);
    // A running one decides for those at standstill.
    is(&[(5, ON), (10, start(0)), (30, stop(3)), (40, rest(0, Why::Stopped))], &[(5, 40)]);
    let mut alone = settings();
    alone.set_up = 1;
    assert_eq!(reported(alone, &[(5, ON), (30, stop(2)), (60, OFF)]), (vec![(5, 60)], 0));
}

#[test]
fn an_off_while_it_brakes() {
    let braking = [(10, start(0)), (30, stop(1)), (32, OFF), (34, entry(0, Laser::On))];
    is(&braking, &[]);
    // Without the off a mark has no gap; with an on after it neither.
    is(&[(10, start(0)), (30, stop(1)), (34, entry(0, Laser::On)), (40, rest(0, Why::Stopped))], &[(34, 40)]);
    let on = [(33, ON), (33, OFF), (34, entry(0, Laser::On))];
    is(&[&braking[..3], &on].concat(), &[]);
    is(&[(2, OFF), (10, start(0)), (20, entry(0, Laser::On)), (60, rest(0, Why::Done))], &[(20, 60)]);
}

#[test]
fn under_a_velocity_follow() {
    let follow = [(10, start(0)), (20, entry(0, Laser::Follow)), (40, rest(0, Why::Done))];
    let and = |more: &[(Ns, What)]| [&follow[..], more].concat();
    // Dark at standstill, lit with the next start.
    is(&and(&[(50, ON), (60, start(0)), (80, rest(0, Why::Done))]), &[(60, 80)]);
    // An end of the follow withdraws it.
    is(&and(&[(50, ON), (55, What::Power { channel: 0 }), (60, start(0))]), &[]);
    is(&and(&[(50, ON), (55, What::Stop { crds: 0, ends_follow: 1 }), (60, start(0))]), &[]);
    is(&and(&[(50, ON), (55, What::Map { channel: 0, map: 2, code: 0, sure: true }), (60, start(0))]), &[]);
    // While it runs, light continues after the follow.
    is(
        &[
            (10, start(0)),
            (20, entry(0, Laser::Follow)),
            (25, ON),
            (30, What::Power { channel: 0 }),
            (40, rest(0, Why::Done)),
        ],
        &[(25, 1000)],
    );
}

#[test]
fn causes() {
    let lit = [
        (10, start(0)),
        (20, entry(0, Laser::On)),
        (30, What::Fault { crds: 1, sure: true }),
        (35, rest(0, Why::Stopped)),
    ];
    let and = |more: &[(Ns, What)]| [&lit[..], more].concat();
    is(&and(&[(50, REFUSED), (60, start(0)), (70, entry(0, Laser::On))]), &[(20, 30)]);
    is(&and(&[(50, cleared(1)), (60, start(0))]), &[(20, 30)]);
    is(&and(&[(50, cleared(1)), (60, ON), (70, OFF)]), &[(20, 30), (60, 70)]);
    is(&[(10, start(0)), (20, entry(0, Laser::On)), (60, rest(0, Why::Underrun)), (70, start(0))], &[(20, 60)]);
    // An on that was done in spite of a fault is a wrong answer.
    assert_eq!(reported(settings(), &and(&[(50, ON)])).1, 1);
}

/// A clear that acts late may come before a cause or after it; one that does not, comes before.
#[test]
fn a_clear_about_a_cause() {
    let wrong = |until: Ns, answer: What| {
        let mut judge = Judge::new(settings(), 1);
        let cause = Fact { lo: 52, hi: 54, what: What::FaultOfAll };
        for fact in [Fact { lo: 50, hi: until, what: cleared(1) }, cause, Fact::at(70, answer)] {
            judge.take(&fact);
        }
        judge.finish(1000).1.len()
    };
    assert_eq!((wrong(50, REFUSED), wrong(50, ON)), (0, 1));
    assert_eq!((wrong(56, REFUSED), wrong(56, ON)), (0, 0));
    assert_eq!((wrong(52, REFUSED), wrong(52, ON)), (0, 1));
}

#[test]
fn a_lost_link() {
    let lost = [
        (10, start(0)),
        (20, entry(0, Laser::On)),
        (30, What::LinkLoss),
        (32, entry(0, Laser::On)),
        (35, rest(0, Why::Stopped)),
    ];
    let and = |more: &[(Ns, What)]| [&lost[..], more].concat();
    is(&and(&[(50, cleared(1)), (60, start(0)), (80, rest(0, Why::Done))]), &[(20, 30), (60, 80)]);
    is(&and(&[(50, start(0)), (60, cleared(1))]), &[(20, 30)]);
    is(&and(&[(50, cleared(1)), (55, What::CrdClear { crd: 0, fifo: 0 }), (60, start(0))]), &[(20, 30)]);
}

#[test]
fn an_abort_and_a_new_session() {
    for end in [What::Abort, What::Session] {
        let ended = [
            (10, start(0)),
            (20, entry(0, Laser::On)),
            (30, end),
            (32, entry(0, Laser::On)),
            (35, rest(0, Why::Stopped)),
        ];
        let and = |more: &[(Ns, What)]| [&ended[..], more].concat();
        is(&and(&[(60, start(0)), (70, entry(0, Laser::On)), (80, rest(0, Why::Done))]), &[(20, 30), (70, 80)]);
        is(&and(&[(50, ON), (70, OFF)]), &[(20, 30), (50, 70)]);
    }
    let early = [(10, start(0)), (20, What::Abort), (30, ON), (40, rest(0, Why::Stopped))];
    assert_eq!(reported(settings(), &early).1, 1, "an on before everything rests is refused");
}

#[test]
fn maps_and_connectors() {
    let map = |map, code| What::Map { channel: 0, map, code, sure: true };
    let wrong = |facts: &[(Ns, What)]| reported(settings(), facts).1;
    assert_eq!(wrong(&[(10, start(0)), (20, map(2, 0))]), 1);
    assert_eq!(wrong(&[(10, start(0)), (20, map(2, 1))]), 0);
    assert_eq!(wrong(&[(20, map(2, 1))]), 1);
    let kept = [(10, start(0)), (20, entry(0, Laser::On)), (30, stop(1)), (40, rest(0, Why::Stopped))];
    assert_eq!(wrong(&[&kept[..], &[(50, map(0, 0))]].concat()), 1);
    is(&[(5, map(2, 0)), (10, start(0)), (20, entry(0, Laser::On))], &[]);
    let gone = What::Connector { channel: 0, there: false };
    let back = What::Connector { channel: 0, there: true };
    is(&[(5, ON), (20, gone), (30, back), (40, ON), (50, OFF)], &[(5, 20), (40, 50)]);
}

#[test]
fn doubt_asks_for_nothing_and_ends() {
    let mut judge = Judge::new(settings(), 1);
    for (at, what) in [(5, ON), (10, What::Doubt { crds: 1, follows: 0 }), (20, ON), (30, OFF)] {
        judge.take(&Fact::at(at, what));
    }
    let ([verdict, _], ..) = judge.finish(100);
    let timing = settings().channels[0].timing;
    let spans = |most| {
        light_spans(&verdict.gates, &timing, most, 100).iter().map(|lit| (lit.begin, lit.end)).collect::<Vec<_>>()
    };
    assert_eq!((spans(true), spans(false)), (vec![(5, 30)], vec![(5, 10), (20, 30)]));
}
