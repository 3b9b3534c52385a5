//! Stops of a path: smooth, gentle and abrupt ones, and how it goes on after them.
use super::*;
use servo::units::FineNs;

#[test]
fn a_smooth_stop_brakes_through_what_follows_and_goes_on_from_there() {
    let s = speeds(10.0, 1.0, 10.0);
    let entries = vec![
        PathEntry::planar([100, 0], s),
        mark(1),
        PathEntry::planar([100, 20], s),
        mark(2),
        PathEntry::planar([120, 20], s),
        mark(3),
        PathEntry::planar([1000, 20], s),
        mark(4),
    ];
    let mut bench = Bench::new(entries, 250_000);
    bench.path.rules.set_stop(dec(1.0));
    bench.start(0);
    // At 14.75 ms it has done 97.5 pulses at 10 pulse/ms; 50 more pulses in 10 ms.
    bench.until(14_750_000);
    bench.stop(false);
    let step = bench.finish();
    let stop = (1.0, (bench.now - BEGIN_NS) as f64);
    assert!(stop.1 > 0.0);
    assert_eq!(bench.heard.rests.len(), 1);
    let (at, rest) = bench.heard.rests[0];
    assert!(near(since(at) / 1e6, 24.75) && rest == PathStop::Stopped);
    // 2.5 + 20 + 20 pulses, then 7.5 of the last line.
    assert!((pulses(step.position[0]) - 127.5).abs() < 1e-6 && (pulses(step.position[1]) - 20.0).abs() < 1e-6);
    assert_eq!(bench.marks().iter().map(|m| m.1).collect::<Vec<_>>(), [1, 2, 3]);
    assert_eq!((step.done, bench.path.released(0)), (3, 6));
    // 872.5 pulses from rest to rest: 87.25 + 10 ms.
    let again = (bench.now - BEGIN_NS) as f64 / 1e6;
    bench.start(0);
    let last = bench.finish();
    assert_eq!((last.position, last.done), ([1000, 20, 0, 0].map(Pos::pulses), 4));
    assert!(near(bench.marks()[3].0, again + 97.25));
}

/// A gentle Stop does not take a corner faster than the corner allows, and is over where it must
/// halt.
#[test]
fn a_gentle_stop_still_brakes_for_corners() {
    let entries = vec![
        PathEntry::planar([1000, 0], speeds(10.0, 1.0, 2.0)),
        mark(1),
        PathEntry::planar([1000, 1000], speeds(10.0, 1.0, 0.0)),
        mark(2),
    ];
    let mut bench = Bench::new(entries, 250_000);
    bench.path.rules.set_stop(dec(0.01));
    bench.start(0);
    bench.until(50_000_000);
    bench.stop(false);
    let mut fastest = 0.0f64;
    while bench.path.runs() {
        let step = bench.tick();
        if step.done == 1 {
            fastest = fastest.max(speed(&step.motion));
        }
    }
    assert!(fastest <= 2.0 + 1e-9, "{fastest}");
    // From 2 pulse/ms at 0.01 pulse/ms²: 200 pulses after the corner.
    let step = bench.tick();
    assert!((pulses(step.position[1]) - 200.0).abs() < 1e-6, "{:?}", step.position);
    // A corner at 0 ends the Stop.
    let entries = vec![
        PathEntry::planar([100, 0], speeds(10.0, 1.0, 0.0)),
        mark(1),
        PathEntry::planar([200, 0], speeds(10.0, 1.0, 0.0)),
    ];
    let mut bench = Bench::new(entries, 250_000);
    bench.path.rules.set_stop(dec(0.01));
    bench.start(0);
    bench.until(5_000_000);
    bench.stop(false);
    let step = bench.finish();
    assert_eq!((step.position[0], bench.heard.rests[0].1), (Pos::pulses(100), PathStop::Stopped));
    assert!(bench.heard.marks.is_empty(), "what stands behind the corner waits for the start");
    bench.start(0);
    bench.finish();
    assert_eq!(bench.heard.marks.len(), 1);
}

/// A motion entered above its speed brakes to it at its own acceleration, also while a gentle Stop
/// is in force. From there on it brakes with that of the Stop, and harder again only where the
/// motion itself brakes for its end.
#[test]
fn a_gentle_stop_does_not_stay_above_the_speed_of_a_motion() {
    let cases = [
        (0.01, 1000, 4.0),
        // It comes to the end of the second, and stops in the third.
        (0.005, 1000, 4.0),
        // The second brakes for its end, from 4 to 1 in 7.5 pulses.
        (0.01, 160, 1.0),
        // The second is too short to come down to its speed.
        (0.01, 120, 4.0),
    ];
    for (stop, second, end) in cases {
        let entries = vec![
            PathEntry::planar([100, 0], speeds(10.0, 1.0, 10.0)),
            PathEntry::planar([second, 0], speeds(4.0, 1.0, end)),
            PathEntry::planar([4000, 0], speeds(4.0, 1.0, 0.0)),
        ];
        let mut bench = Bench::new(entries, 250_000);
        bench.path.rules.set_stop(dec(stop));
        bench.start(0);
        bench.until(14_000_000);
        let travelled = 50.0 + 10.0 * ((bench.now - BEGIN_NS) as f64 / 1e6 - 10.0);
        bench.stop(false);
        let step = bench.finish();
        let corner = 100.0 - 2.0 * stop * (100.0 - travelled);
        // To 4 at 1 pulse/ms², wherever boundaries are.
        let slow = 100.0 + (corner - 16.0) / 2.0;
        let rest = if end < 4.0 { f64::from(second) + end * end / (2.0 * stop) } else { slow + 16.0 / (2.0 * stop) };
        let at = pulses(step.position[0]);
        assert!((at - rest).abs() < 1e-3, "{stop} {second} {end}: {at}, not {rest}");
    }
}

#[test]
fn an_abrupt_stop_stands_still_on_its_tick() {
    let mut bench = Bench::new(vec![PathEntry::planar([1000, 0], speeds(10.0, 1.0, 0.0)), mark(1)], 250_000);
    bench.start(0);
    bench.until(20_000_000);
    let now = (bench.now - BEGIN_NS) as f64 / 1e6;
    bench.stop(true);
    let step = bench.tick();
    assert!(!step.runs && step.motion == Motion::STANDSTILL);
    assert!(near(pulses(step.position[0]), 50.0 + (now - 10.0) * 10.0));
    assert_eq!(bench.heard.rests, [(((BEGIN_NS as f64 + now * 1e6) as FineNs) << 32, PathStop::Stopped)]);
    bench.start(0);
    assert_eq!(bench.finish().position[0], Pos::pulses(1000));
}

/// Random paths with a Stop at any tick, at any deceleration: never off the path, never faster than
/// set, ends met.
#[test]
fn random_stops_stay_on_the_path_and_within_its_speeds() {
    let mut chance = Chance::new(9);
    for case in 0..2000 {
        let count = 2 + chance.below(6) as i32;
        let (mut entries, mut corner) = (Vec::new(), 0);
        let mut ends = Vec::new();
        let acc = chance.log(0.2, 5.0);
        for _ in 0..count {
            corner += 1 + chance.below(200) as i32;
            let (vel, end) = (chance.log(1.0, 30.0), chance.unit() * 20.0);
            entries.push(PathEntry::planar([corner, 0], speeds(vel, acc, end)));
            ends.push((corner as f64, end.min(vel), vel));
        }
        let stop = chance.log(0.02, 50.0);
        let mut bench = Bench::new(entries, 50_000 + chance.below(500_000));
        bench.path.rules.set_stop(dec(stop));
        bench.start(0);
        let mut before: Option<Step> = None;
        // Three Stops, each after at most 20 ms.
        for _ in 0..3 {
            let when = bench.now - BEGIN_NS + chance.below(20_000_000);
            while bench.path.runs() && bench.now - BEGIN_NS < when {
                bench.tick();
            }
            if bench.path.runs() {
                bench.stop(false);
                let step = bench.finish();
                let (_, rest) = *bench.heard.rests.last().unwrap();
                if rest == PathStop::Stopped {
                    assert!(!bench.path.refuses_start(0, bench.feed), "{case}");
                    bench.start(0);
                }
                before = Some(step);
            }
        }
        let mut last = before;
        while bench.path.runs() {
            let step = bench.tick();
            if let Some(last) = last {
                // But for the rounding of positions.
                assert!(step.position[0].0 >= last.position[0].0 - 3, "{case}: back from {last:?} to {step:?}");
            }
            last = Some(step);
        }
        bench.now += bench.period;
        let step = bench.tick();
        assert_eq!((step.position[0], step.done), (Pos::pulses(corner), count as u32), "{case}");
        let completed = bench.heard.rests.last().unwrap().1;
        assert!(matches!(completed, PathStop::Completed | PathStop::Underrun), "{case}");
    }
}

#[test]
fn a_wait_that_is_stopped_goes_on_with_what_is_left() {
    let s = speeds(10.0, 1.0, 0.0);
    let entries = vec![PathEntry::delay(20), mark(1), PathEntry::planar([100, 0], s), mark(2)];
    let mut bench = Bench::new(entries, 250_000);
    bench.start(0);
    bench.until(7_000_000);
    let stopped = bench.now - BEGIN_NS;
    bench.stop(false);
    assert_eq!(bench.heard.rests, [(((BEGIN_NS + stopped) as FineNs) << 32, PathStop::Stopped)]);
    bench.until(50_000_000);
    let again = bench.now - BEGIN_NS;
    bench.start(0);
    bench.finish();
    assert_eq!(bench.heard.marks[0].0, ((BEGIN_NS + again + 20_000_000 - stopped) as FineNs) << 32);
    assert_eq!(bench.path.done(0), 1);
}
