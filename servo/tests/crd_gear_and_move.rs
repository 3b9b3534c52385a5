//! One axis that a path gears to a motion and moves by an entry, one right after the other: it is
//! where exact kinematics want it in every tick, at any tick period, and a slave of it too.
use crate::tick_bench;
use servo::path::{MotionSpeeds, PathEntry};
use servo::segment::follow::MasterPosition;
use servo::status;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{Pos, StepLimit};
use servo::view::StopReason;

use tick_bench::*;

fn speeds(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

/// A path length from rest, with an acceleration of 1 pulse/ms² up to `peak` and down to `end`.
#[derive(Clone, Copy)]
struct Line {
    peak: f64,
    end: f64,
}

impl Line {
    fn of(length: f64, end: f64) -> Line {
        Line { peak: (length + end * end / 2.0).sqrt(), end }
    }

    fn time(self) -> f64 {
        2.0 * self.peak - self.end
    }

    fn at(self, t: f64) -> f64 {
        let t = t.clamp(0.0, self.time());
        if t <= self.peak {
            return t * t / 2.0;
        }
        let left = self.time() - t;
        self.peak * self.peak - self.end * self.end / 2.0 - (self.end * left + left * left / 2.0)
    }
}

/// 70 pulses from rest to rest: acceleration 0.5 pulse/ms², speed 2 pulse/ms.
const MOVE_PULSES: f64 = 70.0;
const MOVE_MS: f64 = 39.0;

fn moved(t: f64) -> f64 {
    let t = t.clamp(0.0, MOVE_MS);
    if t <= 4.0 {
        t * t / 4.0
    } else if t <= 35.0 {
        4.0 + 2.0 * (t - 4.0)
    } else {
        MOVE_PULSES - (MOVE_MS - t) * (MOVE_MS - t) / 4.0
    }
}

fn travel(to: i32, modal: bool) -> PathEntry {
    PathEntry::travel(axis(4), to, (2f64.to_bits(), StepLimit::FULL_SCALE), 0.5f64.to_bits(), modal).unwrap()
}

/// Axis 4 named 0, which slave 6 follows at a ratio of 1; a coordinate system on axes 0 and 1.
fn prepared(period: u32) -> Bench {
    let mut bench = Bench::prepared(period, MotionMode::Trap);
    bench.frame(0, &[0, 1], None);
    bench.now(TickCommand::SetMode { axis: axis(6), mode: MotionMode::Follow });
    bench.follows(6, 4, MasterPosition::Planned);
    bench.tick();
    bench.follow(6, 0, &[Item::Data(100_000.0, 100_000.0, 1, 0)]);
    bench.start_follow(&[6]);
    bench.tick();
    bench
}

/// Runs the entries; in each tick the axis is where `exact` wants it, its time in ms.
fn check(bench: &mut Bench, entries: &[PathEntry], exact: impl Fn(f64) -> f64, what: &str) {
    bench.path(0, 0, entries);
    bench.start_path(&[0]);
    let zero = bench.tick().now.0;
    loop {
        let view = bench.tick();
        let (t, at) = ((view.now.0 - zero) as f64 / 1e6, pulses(view.axes[4].pos));
        assert!((at - exact(t)).abs() < 2e-5, "{what} at {t} ms: {at}, exact {}", exact(t));
        let slave = pulses(view.axes[6].pos);
        assert!((slave - at).abs() < 2e-5, "{what} at {t} ms: slave {slave} of {at}");
        if !view.crds[0].runs && t > 120.0 {
            assert_eq!(view.crds[0].stop, StopReason::Completed, "{what}");
            return;
        }
    }
}

const PERIODS_US: [u32; 5] = [50, 73, 250, 333, 1000];

/// It leaves its gear at the vertex, where its move begins; the path goes on or waits.
#[test]
fn an_axis_that_was_geared_sets_off_at_the_end_of_the_motion() {
    for period in PERIODS_US {
        for (end, modal) in [(3.0, false), (0.0, false), (0.0, true)] {
            let mut bench = prepared(period);
            let line = Line::of(37.0, end);
            let entries = [
                PathEntry::gear(axis(4), 100),
                PathEntry::planar([37, 0], speeds(10.0, 1.0, end)),
                travel(30, modal),
                PathEntry::planar([37, 90], speeds(10.0, 1.0, 0.0)),
            ];
            let exact = |t: f64| 100.0 * line.at(t) / 37.0 - moved(t - line.time());
            check(&mut bench, &entries, exact, &format!("{period} µs, to {end}, modal {modal}"));
        }
    }
}

/// Between them lies a motion, which may be over within a tick.
#[test]
fn an_axis_that_was_geared_sets_off_after_another_motion() {
    for period in PERIODS_US {
        for length in 1..30 {
            let mut bench = prepared(period);
            let line = Line::of(37.0, 3.0);
            // At constant speed.
            let between = f64::from(length) / 3.0;
            let entries = [
                PathEntry::gear(axis(4), 100),
                PathEntry::planar([37, 0], speeds(10.0, 1.0, 3.0)),
                PathEntry::planar([37 + length, 0], speeds(3.0, 1.0, 3.0)),
                travel(30, false),
                PathEntry::planar([37 + length, 90], speeds(10.0, 1.0, 0.0)),
            ];
            let exact = |t: f64| 100.0 * line.at(t) / 37.0 - moved(t - line.time() - between);
            check(&mut bench, &entries, exact, &format!("{period} µs, {length} between"));
        }
    }
}

/// The geared motion begins and ends between two ticks, alone or after another geared one.
#[test]
fn an_axis_that_was_geared_for_less_than_a_tick_sets_off() {
    for period in PERIODS_US {
        for length in 5..30 {
            for (first, second) in [(0, 100), (60, 40)] {
                let mut bench = prepared(period);
                let line = Line::of(f64::from(length), 3.0);
                let v = speeds(3.0, 1.0, 3.0);
                let mut entries = vec![PathEntry::planar([length, 0], speeds(10.0, 1.0, 3.0))];
                if first != 0 {
                    entries.insert(0, PathEntry::gear(axis(4), first));
                }
                entries.extend([PathEntry::gear(axis(4), second), PathEntry::planar([length + 1, 0], v)]);
                entries.extend([travel(30, false), PathEntry::planar([length + 40, 0], v)]);
                let exact = |t: f64| {
                    let (one, two) = (f64::from(first), f64::from(second));
                    let after = t - line.time();
                    one * line.at(t) / f64::from(length) + two * (3.0 * after).clamp(0.0, 1.0)
                        - moved(after - 1.0 / 3.0)
                };
                check(&mut bench, &entries, exact, &format!("{period} µs, {first} over {length}, then {second}"));
            }
        }
    }
}

/// After a move that the path has waited for, the axis is free to be geared.
#[test]
fn an_axis_that_was_waited_for_is_geared_to_the_next_motion() {
    for period in PERIODS_US {
        let mut bench = prepared(period);
        let line = Line::of(37.0, 0.0);
        let entries =
            [travel(70, true), PathEntry::gear(axis(4), -40), PathEntry::planar([37, 0], speeds(10.0, 1.0, 0.0))];
        let exact = |t: f64| moved(t) - 40.0 * line.at(t - MOVE_MS) / 37.0;
        check(&mut bench, &entries, exact, &format!("{period} µs"));
    }
}

/// Gear, move and gear again in a row; user positions have another zero than the machine's.
#[test]
fn gear_move_and_gear_follow_each_other() {
    for period in PERIODS_US {
        let mut bench = prepared(period);
        bench.now(TickCommand::SetPosition { axis: axis(4), pos: Pos::pulses(0) });
        let line = Line::of(37.0, 0.0);
        let v = speeds(10.0, 1.0, 0.0);
        let entries = [
            PathEntry::gear(axis(4), 100),
            PathEntry::planar([37, 0], v),
            travel(30, true),
            PathEntry::gear(axis(4), 55),
            PathEntry::planar([0, 0], v),
        ];
        let time = line.time();
        let exact = |t: f64| 100.0 * line.at(t) / 37.0 - moved(t - time) + 55.0 * line.at(t - time - MOVE_MS) / 37.0;
        check(&mut bench, &entries, exact, &format!("{period} µs"));
    }
}

/// An axis that is geared up by much is as exact as any: a rounded path length is not enough. An
/// abrupt Stop leaves it where it was shown, and it goes on from there.
#[test]
fn an_axis_that_is_geared_up_is_exact() {
    for period in PERIODS_US {
        for (length, pulses_of, stops) in
            [(1, 187, false), (1, 100_000, false), (37, 1_000_000, false), (1, 100_000, true)]
        {
            let mut bench = Bench::prepared(period, MotionMode::Trap);
            bench.frame(0, &[0, 1], None);
            bench.tick();
            let line = Line::of(f64::from(length), 0.0);
            bench.path(
                0,
                0,
                &[PathEntry::gear(axis(4), pulses_of), PathEntry::planar([length, 0], speeds(10.0, 1.0, 0.0))],
            );
            bench.start_path(&[0]);
            let zero = bench.tick().now.0;
            let what = format!("{period} µs, {pulses_of} over {length}");
            let ratio = f64::from(pulses_of) / f64::from(length);
            let mut last = 0.0;
            let view = loop {
                let view = bench.tick();
                let (t, at) = ((view.now.0 - zero) as f64 / 1e6, pulses(view.axes[4].pos));
                assert!((at - ratio * line.at(t)).abs() < 1e-5, "{what} at {t} ms: {at}, exact {}", ratio * line.at(t));
                if !view.crds[0].runs || stops && t > 1.2 {
                    break view;
                }
                last = at;
            };
            if stops {
                let shown = view.axes[4].pos;
                bench.now(TickCommand::stop(all(&[0]), all(&[0])));
                let view = bench.tick();
                assert_eq!((view.crds[0].runs, view.axes[4].pos), (false, shown), "{what}");
                bench.start_path(&[0]);
                bench.tick();
                assert_eq!(pulses(bench.run_to_standstill().axes[4].pos), f64::from(pulses_of));
            } else {
                assert!(last > 0.0);
                assert_eq!(pulses(view.axes[4].pos), f64::from(pulses_of), "{what}");
            }
        }
    }
}

/// A soft limit of a geared axis stops the path before it, as that of its own axes does; without
/// the limit it goes on to its end. The limit lies within the motion, or within its last tick.
#[test]
fn a_soft_limit_of_a_geared_axis_stops_the_path() {
    for period in PERIODS_US {
        for (limit, far) in [(-20, -100), (-99, -100), (-100, -100), (0, -100), (20, 100), (99, 100), (0, 100)] {
            let mut bench = prepared(period);
            let (positive, negative) = if far < 0 { (None, Some(limit)) } else { (Some(limit), None) };
            bench.now(TickCommand::SoftLimit { axis: axis(5), positive, negative });
            let bound = f64::from(limit);
            let along = PathEntry::planar([370, 0], speeds(10.0, 1.0, 0.0));
            let next = PathEntry::planar([370, 40], speeds(10.0, 1.0, 0.0));
            bench.path(0, 0, &[PathEntry::gear(axis(5), far), along, next]);
            bench.start_path(&[0]);
            bench.tick();
            let beyond = |at: f64| if far < 0 { at < bound } else { at > bound };
            let view = loop {
                let view = bench.tick();
                assert!(!beyond(pulses(view.axes[5].pos)), "{period} {bound}: {}", pulses(view.axes[5].pos));
                if !view.crds[0].runs {
                    break view;
                }
            };
            let what = format!("{period} µs, limit {bound}, to {far}");
            let at = pulses(view.axes[5].pos);
            let reached = beyond(f64::from(far));
            if reached {
                let (reason, bit) = if far < 0 {
                    (StopReason::SoftNegative, status::LIMIT_NEGATIVE)
                } else {
                    (StopReason::SoftPositive, status::LIMIT_POSITIVE)
                };
                assert_eq!((view.crds[0].stop, view.axes[5].stop), (reason, reason), "{what}");
                assert!(has(&view.axes[5], bit), "{what}");
                assert!((at - bound).abs() < 0.01, "{what}: {at}");
                assert!((pulses(view.axes[0].pos) / 370.0 - at / f64::from(far)).abs() < 1e-6, "{what}");
            } else {
                assert_eq!(view.crds[0].stop, StopReason::Completed, "{what}");
            }
            bench.now(TickCommand::SoftLimit { axis: axis(5), positive: None, negative: None });
            bench.now(TickCommand::ClearStatus { axes: all(&[5]) });
            bench.tick();
            bench.start_path(&[0]);
            let mut view = bench.ticks(3);
            while view.crds[0].runs {
                view = bench.tick();
            }
            assert_eq!(pulses(view.axes[5].pos), f64::from(far), "{what}");
            assert_eq!((pulses(view.axes[0].pos), pulses(view.axes[1].pos)), (370.0, 40.0), "{what}");
        }
    }
}
