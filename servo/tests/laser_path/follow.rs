//! Powers that follow the speed of a path or the positions of its axes.
use super::*;

/// A follow begins and ends at the instants of its entries, between two ticks.
#[test]
fn a_follow_begins_and_ends_at_its_entry() {
    let mut bench = prepared(1000);
    bench.delays(0, 0);
    bench.carrier(100.0);
    bench.direct(20.0);
    // 0.4 ms after a tick the speed of 10 pulse/ms has been there for 5.4 ms.
    let entries = [
        light(true),
        line([104, 0], 10.0, 1.0, 10.0),
        follow(3.0, 10.0, 100.0),
        line([131, 0], 10.0, 1.0, 10.0),
        direct(50.0),
        line([500, 0], 10.0, 1.0, 0.0),
    ];
    bench.path(0, &entries);
    let zero = bench.start(1);
    until(&mut bench, zero + 25 * MS);
    for pulse in bench.pulses().iter().filter(|pulse| pulse.0 < zero + 22 * MS) {
        // 20 %, 3·10 + 10 % from 15.4 ms on, 50 % from 18.1 ms on, of 10 µs.
        let at = pulse.0 - zero;
        let width = if at < 15_400_000 {
            2000
        } else if at < 18_100_000 {
            4000
        } else {
            5000
        };
        assert_eq!(pulse.1 - pulse.0, width, "at {at}");
    }
}

/// x = 0.1·v + 10, held in 10 to 14, along a trapezoid: each tick has the speed in the middle of
/// its interval.
#[test]
fn the_power_follows_the_middle_of_the_interval() {
    for period in [50, 250, 1000] {
        let mut bench = prepared(period);
        bench.path(0, &[follow(0.1, 10.0, 14.0), light(true), line([4000, 0], 50.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        // 1250 pulses up in 50 ms, 1500 in 30 ms, 50 ms down.
        let mut ticks = 0;
        while bench.tick.now().0 < zero + 129 * MS {
            let published = bench.tick();
            let at = (bench.tick.now().0 - zero) as f64 / 1e6 + f64::from(period) / 2e3;
            let v = at.min(50.0).min(130.0 - at);
            let want = (0.1 * v + 10.0).clamp(10.0, 14.0);
            assert!(
                (number(published.power) - want).abs() < 1e-7,
                "{period} at {at}: {} {want}",
                number(published.power)
            );
            ticks += 1;
        }
        assert!(ticks > 100);
    }
}

/// With a minimum of 0 the energy of every part of the path is the ratio times its length, at 1:100
/// of speeds.
#[test]
fn energy_per_distance_is_the_ratio() {
    for period in [10, 50, 250, 1000] {
        let mut bench = prepared(period);
        bench.carrier(1000.0);
        bench.path(0, &[follow(2.0, 0.0, 100.0), light(true), line([4000, 0], 50.0, 1.0, 0.0)]);
        let zero = bench.start(1);
        let mut stretches = vec![];
        let (mut from, mut energy) = (0.0, 0u64);
        until(&mut bench, zero);
        bench.forget();
        while bench.tick.now().0 < zero + 130 * MS {
            bench.tick();
            energy += bench.pulses().iter().map(|(begin, end)| end - begin).sum::<u64>();
            bench.forget();
            let x = bench.view().axes[0].pos.0 as f64 / (1 << 22) as f64;
            // A part is a tenth of the length so far, and 100 pulses at most.
            if x - from >= (0.1 * from).clamp(0.125, 100.0) {
                let per_pulse = energy as f64 / 1e6 * 100.0 / (x - from);
                stretches.push((x, per_pulse));
                (from, energy) = (x, 0);
            }
        }
        let seen = stretches.iter().filter(|(x, _)| *x < 3999.5);
        for (x, per_pulse) in seen.clone() {
            // 0.5 pulse/ms is reached at 0.125 pulse.
            assert!((per_pulse / 2.0 - 1.0).abs() < 1e-3, "{period} at {x}: {per_pulse}");
        }
        assert!(seen.count() > 30, "{period}");
    }
}

/// At a corner and in a BufDelay the speed is 0: the minimum, not darkness.
#[test]
fn speed_0_is_the_minimum() {
    let mut bench = prepared(250);
    let entries = [
        follow(1.0, 5.0, 100.0),
        light(true),
        line([100, 0], 10.0, 1.0, 0.0),
        PathEntry::delay(7),
        line([200, 0], 10.0, 1.0, 0.0),
    ];
    bench.path(0, &entries);
    let zero = bench.start(1);
    // 10 ms up, 10 ms down, 7 ms of standstill.
    until(&mut bench, zero + 23 * MS);
    let published = bench.view().lasers[0];
    assert_eq!((published.light, number(published.power)), (true, 5.0));
    until(&mut bench, zero + 32 * MS);
    assert!((number(bench.view().lasers[0].power) - 10.125).abs() < 1e-7);
    until(&mut bench, zero + 60 * MS);
    // The entries have run out 47 ms after the start: off, without a BufLaserOff.
    assert_eq!(edges(&mut bench, zero), [(0, true), (47_000_000, false)]);
}

/// Light that begins while a path speeds up begins with the power of its interval.
#[test]
fn light_begins_with_the_power_that_follows() {
    let mut bench = prepared(250);
    bench.delays(30, 130);
    bench.path(0, &[follow(2.0, 0.0, 100.0), line([4000, 0], 50.0, 1.0, 0.0)]);
    let zero = bench.start(1);
    let mut lit = 0;
    until(&mut bench, zero);
    while bench.tick.now().0 < zero + 40 * MS {
        let tick = (bench.tick.now().0 - zero) / 250_000;
        // Off and on within the ticks.
        bench.gate(!tick.is_multiple_of(3));
        let published = bench.tick();
        let v = (bench.tick.now().0 - zero) as f64 / 1e6 + 0.125;
        if published.light {
            lit += 1;
            assert!((number(published.power) - 2.0 * v).abs() < 1e-7, "at {v}: {}", number(published.power));
        }
    }
    assert!((40..140).contains(&lit), "{lit}");
    // Each pulse of 100 µs has the power of the tick in which it begins.
    for (begin, end) in bench.pulses() {
        let tick = (begin - zero) / 250_000;
        let most = 2.0 * (0.25 * tick as f64 + 0.125) * 1000.0;
        assert!((end - begin) as f64 <= most + 1.0, "{begin}: {} {most}", end - begin);
    }
}

/// Power 0 means no pulses, also in between, and is published so; then the carrier is there again.
#[test]
fn a_follow_passes_0() {
    let mut bench = prepared(250);
    let entries = [
        follow(2.0, 0.0, 100.0),
        light(true),
        line([100, 0], 10.0, 1.0, 0.0),
        PathEntry::delay(5),
        line([200, 0], 10.0, 1.0, 0.0),
    ];
    bench.path(0, &entries);
    let zero = bench.start(1);
    let published = |bench: &mut Bench, ms: u64| {
        until(bench, zero + ms * MS);
        let published = bench.view().lasers[0];
        (number(published.power), number(published.khz), published.train.is_none())
    };
    assert_eq!(published(&mut bench, 8), (16.25, 10.0, false));
    assert_eq!(published(&mut bench, 22), (0.0, 0.0, true));
    assert_eq!(published(&mut bench, 33), (16.25, 10.0, false));
    let dark = (zero + 20 * MS + 100 * US)..(zero + 25 * MS);
    assert!(bench.pulses().iter().all(|pulse| !dark.contains(&pulse.0)));
}

/// Direct power, velocity and distance follow together, by the laws of both families.
#[test]
fn both_follows_add_up() {
    for family in [Family::Gus, Family::Lsr] {
        let mut bench = prepared(1000);
        if family == Family::Lsr {
            lsr(&mut bench);
        }
        let bounds = Some(PowerBounds::admit(PowerMode::Duty, power(60.0), power(0.0)).unwrap());
        let (scales, ratios) = ([1000.0f64; 4].map(f64::to_bits), [50.0, 0.0, 0.0, 0.0f64].map(f64::to_bits));
        let axes = [0, 1, 2, 3].map(axis);
        let source = SpeedSource::Planned;
        let distance = Distance::admit(source, axes, [100, 0, 0, 0], scales, ratios, Ratios::Fixed, bounds).unwrap();
        bench.change(ChannelChange::Distance(Some(distance)));
        // A line at 10 pulse/ms: 10 to 800 pulses after 10.5 ms to 89 ms.
        bench.path(
            0,
            &[
                follow(2.0, 5.0, 22.0),
                direct(7.0),
                follow(2.0, 5.0, 22.0),
                light(true),
                line([2000, 0], 10.0, 1.0, 0.0),
            ],
        );
        let zero = bench.start(1);
        bench.until(zero + 30 * MS);
        // At 250 pulses: 0.05·150 = 7.5; the velocity part 25 → 22 in GUS; in LSR 25 + 7 + 7.5 held
        // in 5 to 22.
        let want = if family == Family::Gus { 29.5 } else { 22.0 };
        let published = bench.view().lasers[0];
        assert_eq!((number(published.power), published.light), (want, true), "{family:?}");
        // At 1250 pulses, GUS: 22 + 57.5, held in the distance's 60.
        bench.until(zero + 130 * MS);
        let want = if family == Family::Gus { 60.0 } else { 22.0 };
        assert_eq!(number(bench.view().lasers[0].power), want);
        // A direct power ends the follow in GUS: 1 + 57.5 at 1250.1 pulses.
        bench.direct(1.0);
        bench.tick();
        let want = if family == Family::Gus { 1.0 + 0.05 * 1160.0 } else { 22.0 };
        assert!((number(bench.view().lasers[0].power) - want).abs() < 1e-9);
        assert_eq!(bench.view().lasers[0].follows.is_some(), family == Family::Lsr);
    }
}

/// Axes settle after their path: its light goes on for the off delay, with the power of speed 0.
#[test]
fn a_path_at_rest_has_no_speed_while_its_encoders_settle() {
    let mut bench = prepared(1000);
    bench.delays(5000, 0);
    bench.command(TickCommand::CrdLag { crd: Crd::FIRST, lag: FilterRate::NONE });
    let mode = Buffered::FollowMode { source: SpeedSource::Encoder, start: None };
    let bounds = PowerBounds::admit_follow(PowerMode::Duty, power(100.0), power(1.0)).unwrap();
    let ratio = Ratio::admit(2f64.to_bits()).unwrap();
    let follow = buffered(Buffered::FollowRatio { ratio, bounds });
    // 10 pulses at 1 pulse/ms²: half of them in 3.2 ms, at rest after 6.3 ms.
    bench.path(0, &[buffered(mode), follow, light(true), line([10, 0], 10.0, 1.0, 0.0)]);
    bench.start(1);
    for k in 0..12 {
        bench.machine.encoders = [3 * k, 0, 0, 0];
        bench.tick();
        let published = bench.view().lasers[0];
        let runs = bench.view().crds[0].runs;
        let want = if runs && k > 0 { 2.0 * 3.0 + 1.0 } else { 1.0 };
        assert_eq!((number(published.power), published.light), (want, true), "{k}: {runs}");
    }
}

/// The encoders' path speed, of the interval before, without a filter and with that of power-on: 1
/// ms.
#[test]
fn the_encoders_of_a_path_may_be_followed() {
    for filtered in [false, true] {
        encoders_are_followed(filtered);
    }
}

fn encoders_are_followed(filtered: bool) {
    let mut bench = prepared(1000);
    if !filtered {
        bench.command(TickCommand::CrdLag { crd: Crd::FIRST, lag: FilterRate::NONE });
    }
    let mode = Buffered::FollowMode { source: SpeedSource::Encoder, start: None };
    let bounds = PowerBounds::admit_follow(PowerMode::Duty, power(100.0), power(1.0)).unwrap();
    let ratio = Ratio::admit(2f64.to_bits()).unwrap();
    bench.path(
        0,
        &[
            buffered(mode),
            buffered(Buffered::FollowRatio { ratio, bounds }),
            light(true),
            line([900, 0], 10.0, 1.0, 0.0),
        ],
    );
    bench.start(1);
    for k in 0..20 {
        bench.machine.encoders = [3 * k, -4 * k, 77 * k, 0];
        bench.tick();
        let found = number(bench.view().lasers[0].power);
        let gone = (k - 1).max(0) as f64 + f64::from(k > 0);
        if filtered {
            let want = 2.0 * 5.0 * -(-gone).exp_m1() + 1.0;
            assert!((found - want).abs() < 1e-6, "{k}: {found}, not {want}");
        } else {
            assert_eq!(found, if k < 1 { 1.0 } else { 2.0 * 5.0 + 1.0 }, "{k}");
        }
    }
}
