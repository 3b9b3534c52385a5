//! Light in sum and edges in time: on-time of a million marks, and the same edges whatever the tick
//! is.
use crate::{chance, laser_bench};
use chance::Chance;
use laser_bench::*;
use servo::laser::{ChannelChange, Power, PowerMode};

/// Units of 250 µs.
fn units(ns: u64) -> u32 {
    (ns / (250 * US)) as u32
}

#[test]
fn on_time_is_the_sum_of_a_million_marks() {
    let mut chance = Chance::new(1);
    let mut bench = Bench::new(50);
    let (mut lit, mut since) = (0, None);
    for mark in 0..1_000_000u32 {
        let (off, on) = (chance.below(300) as u16, chance.below(100) as u16);
        bench.delays(off, on);
        bench.gate(true);
        bench.tick_unread();
        bench.gate(false);
        for _ in 0..chance.below(4) {
            bench.tick_unread();
        }
        if mark % 1000 != 999 {
            continue;
        }
        // The recorded light, to the ns, against the count: at any instant, also within a mark.
        let view = bench.tick();
        let now = bench.tick.now().0;
        for (at, level) in std::mem::take(&mut bench.machine.outputs[0].switch_until(now)) {
            match (level, since) {
                (true, None) => since = Some(at),
                (false, Some(begin)) => {
                    lit += at - begin;
                    since = None;
                }
                _ => panic!("an edge that is none"),
            }
        }
        let running = since.map_or(0, |begin: u64| now - begin);
        assert_eq!(view.on_time, units(lit + running), "mark {mark}");
    }
    assert!(units(lit) > 300_000, "{lit} ns of light");
}

#[test]
fn on_time_is_that_of_the_light_after_the_first_pulse_killer() {
    // Marks of 3 ms with a shift of 1001 µs and a tail of 1234 µs: 3.233 ms of light each, power or
    // not.
    let mut bench = Bench::new(1000);
    bench.fpk(Some((1500, 1001, 1234)));
    for _ in 0..1000 {
        bench.gate(true);
        bench.tick();
        bench.tick();
        bench.tick();
        bench.gate(false);
        bench.tick();
        bench.tick();
        bench.tick();
    }
    let view = bench.tick();
    assert_eq!(view.on_time, units(1000 * 3233 * US));
    // Zeroing in the light counts from there, and forgets the fraction.
    bench.gate(true);
    bench.tick();
    bench.tick();
    bench.change(ChannelChange::ZeroOnTime);
    assert_eq!(bench.tick().on_time, 0);
    bench.tick();
    assert_eq!(bench.tick().on_time, 8);
}

/// A command of a random job. The tests take it at whole ms.
#[derive(Debug, Clone, Copy)]
enum Call {
    Gate(bool),
    Delays(u16, u16),
    Fpk(Option<(u16, u16, u16)>),
    Mode(PowerMode, bool),
    Direct(f64),
    Carrier(f64),
    Width(u16),
    Standby(Option<(f64, f64)>),
    PreVoltage(Option<f64>),
}

fn any(chance: &mut Chance) -> Call {
    let few = |chance: &mut Chance| chance.below(4000) as u16;
    match chance.below(16) {
        0..=7 => Call::Gate(chance.below(2) == 0),
        8 => Call::Delays(few(chance), few(chance)),
        9 => Call::Fpk((chance.below(2) == 0).then(|| (few(chance) + 1, few(chance), few(chance)))),
        10 => {
            let modes = [PowerMode::Duty, PowerMode::Frequency, PowerMode::Analog, PowerMode::DutyOpen];
            Call::Mode(modes[chance.below(4) as usize], chance.below(4) > 0)
        }
        11 => Call::Direct(chance.unit() * 10.0),
        12 => Call::Carrier(chance.log(0.1, 200.0)),
        13 => Call::Width(chance.below(200) as u16 + 1),
        14 => Call::Standby((chance.below(2) == 0).then(|| (chance.log(0.1, 20.0), chance.unit() * 100.0))),
        _ => Call::PreVoltage((chance.below(2) == 0).then(|| chance.unit())),
    }
}

fn give(bench: &mut Bench, call: Call) {
    match call {
        Call::Gate(on) => bench.gate(on),
        Call::Delays(off, on) => bench.delays(off, on),
        Call::Fpk(times) => bench.fpk(times),
        Call::Mode(mode, delayed) => bench.mode(mode, 10.0, 0.0, delayed),
        Call::Direct(power) => bench.direct(power),
        Call::Carrier(khz) => bench.carrier(khz),
        Call::Width(us) => bench.width(us),
        Call::Standby(pulses) => bench.standby(pulses),
        Call::PreVoltage(volts) => bench.change(ChannelChange::PreVoltage(volts.map(power))),
    }
}

#[test]
fn edges_do_not_know_the_tick() {
    let mut chance = Chance::new(3);
    for round in 0..40 {
        let calls: Vec<(u64, Call)> = (0..120)
            .scan(1, |at, _| {
                *at += chance.below(4);
                Some((*at, any(&mut chance)))
            })
            .collect();
        let run = |period_us: u32| {
            let mut bench = Bench::new(period_us);
            for (at, call) in &calls {
                let before = at * MS - period_us as u64 * US;
                if bench.tick.now().0 < before {
                    bench.until(before);
                }
                give(&mut bench, *call);
            }
            let view = bench.until(500 * MS);
            assert!(view.fault as u8 == 0);
            (bench.pulses(), bench.switch(), bench.volts(), view.on_time, view.power, view.khz)
        };
        let coarse = run(1000);
        assert!(coarse.1.len() > 4, "round {round} does something");
        for period_us in [10, 50, 250] {
            let fixed = run(period_us);
            assert!(coarse == fixed, "round {round}, tick {period_us} µs: {calls:?}");
        }
    }
}

#[test]
fn what_is_shown_is_of_its_tick() {
    let mut bench = Bench::new(250);
    bench.carrier(10.0);
    bench.direct(30.0);
    bench.delays(100, 400);
    bench.gate(true);
    let seen: Vec<(bool, bool, Power)> = (0..4)
        .map(|_| {
            let view = bench.tick();
            (view.commanded, view.switch, view.power)
        })
        .collect();
    let (none, some) = (power(0.0), power(30.0));
    // On from 250 + 400 µs on: published at 750 µs.
    assert_eq!(seen, [(true, false, none), (true, false, none), (true, true, some), (true, true, some)]);
}
