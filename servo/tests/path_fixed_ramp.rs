//! Lines whose plan needs their acceleration all along, entered slower than planned. Expected
//! speeds and times are closed forms of their rule.
//!
//! Let u be the present square of the speed as a part of the planned one, ±A the planned
//! acceleration. The acceleration is within u·(±A) ± (1 − u)·A, and as near to the override as that
//! allows. A ramp down keeps u, at least; below ¼ it speeds up until u is ¼.
use crate::paths::{Script, mark, run, since, speeds};
use servo::path::{EntryContent, FeedOverride, FixedRamp, Path, PathEntry, PathStop};

/// A line at 1 pulse/ms² that is planned to end at `planned`, between lines that are as fast as can
/// be: how long it takes, ms, if it begins at `begin`.
fn time(ramp: FixedRamp, length: i32, [begin, planned, vel, rate]: [f64; 4]) -> f64 {
    let entries = vec![
        PathEntry::planar([1_000, 0], speeds(40.0, 1.0, begin)),
        mark(1),
        PathEntry::planar([1_000 + length, 0], speeds(vel, 1.0, planned).with_ramp(ramp)),
        mark(2),
        PathEntry::planar([3_000, 0], speeds(100.0, 1.0, 0.0)),
    ];
    let mut path = Path::IDLE;
    path.rules.set_override(FeedOverride::admit(rate.to_bits()).unwrap());
    let heard = run(&mut path, &Script(entries), 250_000, |_, _| {});
    let [(begun, 1), (ended, 2)] = heard.marks[..] else { panic!("{:?}", heard.marks) };
    assert_eq!(heard.rests[0].1, PathStop::Completed);
    (since(ended) - since(begun)) / 1e6
}

/// The speed at the end of one of 22 pulses that takes one phase: 22 = ms·(begin + end)/2.
fn end(ramp: FixedRamp, figures: [f64; 4]) -> f64 {
    44.0 / time(ramp, 22, figures) - figures[0]
}

#[test]
fn a_fixed_ramp_leaves_its_corners_what_they_take() {
    // Up from 10 to 12 pulse/ms, 100 + 44 = 144; down from 12 to 10.
    let up = |begin, vel, rate| end(FixedRamp::Up, [begin, 12.0, vel, rate]);
    let down = |begin, vel, rate| end(FixedRamp::Down, [begin, 10.0, vel, rate]);
    for (name, speed, square) in [
        ("up as planned", up(10.0, 20.0, 1.0), 144.0),
        ("down as planned", down(12.0, 20.0, 1.0), 100.0),
        // u = ¼: from −A/2 to A.
        ("up", up(5.0, 20.0, 1.0), 25.0 + 44.0),
        ("up, to the override", up(5.0, 14.0, 0.5), 49.0),
        ("up, braking", up(5.0, 2.0, 0.5), 25.0 - 22.0),
        // u = 0.81: from 0.62·A on, the override would have it slower.
        ("up in spite of the override", up(9.0, 18.0, 0.5), 81.0 + 0.62 * 44.0),
        // u = 1: as planned, whatever the override.
        ("up as planned", up(10.0, 20.0, 0.5), 144.0),
        // It keeps u, or brakes with A.
        ("down with u = 0.81", down(10.8, 20.0, 1.0), 81.0),
        ("down with u = ¼", down(6.0, 20.0, 1.0), 25.0),
        ("down, braking", down(10.8, 10.0, 0.5), 116.64 - 44.0),
        ("down, braking to the override", down(10.8, 18.0, 0.5), 81.0),
    ] {
        assert!((speed * speed - square).abs() < 1e-4, "{name}: {} and not {square}", speed * speed);
    }
}

/// With u below ¼ a ramp down speeds up with A/2 until u is ¼, and brakes with A/4 then. So a path
/// that was stopped does not creep.
#[test]
fn a_fixed_ramp_down_speeds_up_again() {
    let down = |length, figures| time(FixedRamp::Down, length, figures);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-5 * b, "{a} and not {b}");
    // 200 pulses down to 10: 500 to 100. From 5: 25 + d = (500 − 2·d)/4, d = 200/3; to 25.
    let top = (25.0f64 + 200.0 / 3.0).sqrt();
    near(down(200, [5.0, 10.0, 40.0, 1.0]), (top - 5.0) / 0.5 + (top - 5.0) / 0.25);
    // Down to standstill, from standstill: d = 400/6 of 200.
    let top = (200.0f64 / 3.0).sqrt();
    near(down(200, [0.0, 0.0, 40.0, 1.0]), top / 0.5 + top / 0.25);
    // 22 pulses are too few for that: 36 of 144·¼ to 0 + 22.
    near(down(22, [0.0, 10.0, 40.0, 1.0]), 22f64.sqrt() / 0.5);
    // An override of 8: d = 64, cruise up to 4·64 = 100 + 2·78, down to 5.
    near(down(200, [0.0, 10.0, 16.0, 0.5]), 8.0 / 0.5 + (200.0 - 64.0 - 78.0) / 8.0 + 3.0 / 0.25);
    // One of 2, from 4: 6 pulses down, then 194 at 2.
    near(down(200, [4.0, 10.0, 4.0, 0.5]), 2.0 + 194.0 / 2.0);
    // It is too short to brake to 2.
    near(down(5, [4.0, 10.0, 4.0, 0.5]), 4.0 - 6f64.sqrt());
}

/// An entry keeps the ramp of a line; arcs have none.
#[test]
fn entries_of_lines_keep_their_ramp() {
    for ramp in [FixedRamp::None, FixedRamp::Up, FixedRamp::Down] {
        for end in [0.0, 0.25, 3.0] {
            let along = speeds(3.0, 0.5, end).with_ramp(ramp);
            for entry in [PathEntry::planar([7, -7], along), PathEntry::line([1, 2, 3, 4], along)] {
                let EntryContent::Line { along: kept, .. } = entry.item() else { panic!("{entry:?}") };
                assert_eq!(kept, along);
                assert!(entry.is_motion() && !entry.is_wait());
            }
        }
    }
}
