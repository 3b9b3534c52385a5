//! What stops a path at once: its tick keeps the set-points of the tick before (SPEC 4), wherever
//! boundaries lie, and CrdStart goes on from there: outputs and gears are not made again.
use crate::{chance, tick_bench};
use servo::path::{MotionSpeeds, PathEntry};
use servo::tick_command::{Brake, DoGroup, Guarded, Guards, MotionMode, Supervision, TickCommand};
use servo::units::{AxisMask, CrdMask, Pos, StepLimit};
use servo::view::{StopReason, View};

use chance::Chance;
use tick_bench::*;

fn speeds(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

fn output(value: u64) -> PathEntry {
    PathEntry::output(DoGroup::General, 0xff, value)
}

/// Coordinate system 0 on axes 0 and 1, 100 pulses from its zero.
fn prepared(period_us: u32, entries: &[PathEntry]) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::Trap);
    bench.frame(0, &[0, 1], Some([100, -50, 0, 0]));
    bench.now(TickCommand::Guard { axis: axis(1), on: Guards::set(Guarded::Alarm, true), low: Guards::NONE });
    bench.now(TickCommand::Supervision(Supervision { interlock: Brake::AbruptAll, ..Supervision::DEFAULT }));
    bench.tick();
    bench.path(0, 0, entries);
    bench.start_path(&[0]);
    bench.machine.edges.clear();
    bench
}

fn at(view: &View<AXES>) -> [Pos; 2] {
    [view.axes[0].pos, view.axes[1].pos]
}

/// What stops it, and what lets it go on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cause {
    Stop,
    OneAxis,
    Servo,
    Alarm,
    Interlock,
}

const CAUSES: [(Cause, StopReason); 5] = [
    (Cause::Stop, StopReason::StopAbrupt),
    (Cause::OneAxis, StopReason::StopAbrupt),
    (Cause::Servo, StopReason::ServoOff),
    (Cause::Alarm, StopReason::Alarm),
    (Cause::Interlock, StopReason::Interlock),
];

fn stop(bench: &mut Bench, cause: Cause) -> View<AXES> {
    match cause {
        Cause::Stop => _ = bench.now(TickCommand::stop_crds(CrdMask(1), CrdMask(1))),
        Cause::OneAxis => _ = bench.now(TickCommand::stop(all(&[1]), all(&[1]))),
        Cause::Servo => _ = bench.now(TickCommand::Servo { axis: axis(1), on: false }),
        Cause::Alarm => bench.machine.inputs[1].alarm = true,
        Cause::Interlock => bench.machine.interlock = true,
    }
    bench.tick()
}

fn let_go(bench: &mut Bench, cause: Cause) {
    match cause {
        Cause::Stop | Cause::OneAxis => {}
        Cause::Servo => _ = bench.now(TickCommand::Servo { axis: axis(1), on: true }),
        Cause::Alarm => bench.machine.inputs[1].alarm = false,
        Cause::Interlock => bench.machine.interlock = false,
    }
    bench.tick();
    bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
    bench.tick();
}

/// Random paths of lines as long as some ticks or shorter, with outputs and delays between them;
/// levels count up.
fn entries(chance: &mut Chance) -> (Vec<PathEntry>, [i32; 2], u64) {
    let (mut entries, mut to, mut level) = (Vec::new(), [-100, 50], 0);
    let most = [4, 40, 400][chance.below(3) as usize];
    for _ in 0..20 + chance.below(60) {
        let vel = chance.log(5.0, 60.0);
        let end = if chance.below(5) == 0 { 0.0 } else { vel * chance.unit() };
        to[0] += 1 + chance.below(most) as i32;
        to[1] += chance.below(most) as i32 - most as i32 / 2;
        entries.push(PathEntry::planar(to, speeds(vel, chance.log(1.0, 60.0), end)));
        if chance.below(2) == 0 {
            level += 1;
            entries.push(output(level));
        }
        if chance.below(12) == 0 {
            entries.push(PathEntry::delay(chance.below(3) as u16));
        }
    }
    if entries.last().is_some_and(PathEntry::is_motion) {
        level += 1;
        entries.push(output(level));
    }
    (entries, to, level)
}

#[test]
fn what_stops_at_once_shows_the_set_points_of_the_tick_before_and_goes_on() {
    let mut chance = Chance::new(4);
    let (mut stops, mut within, mut back, mut early) = (0, 0, 0, 0);
    for case in 0..400 {
        let period = [25, 50, 250, 1000][case % 4];
        let (entries, end, last) = entries(&mut chance);
        let mut bench = prepared(period, &entries);
        let mut before = bench.tick();
        let (mut view, mut wait) = (before, 1 + chance.below(60));
        let (mut last_done, mut ended) = (0, false);
        for _ in 0..400_000 {
            if wait == 0 {
                wait = if chance.below(4) == 0 { 1 } else { 1 + chance.below(400) };
                let (cause, reason) = CAUSES[chance.below(5) as usize];
                let reported = !bench.machine.edges.is_empty();
                before = view;
                view = stop(&mut bench, cause);
                let published = &view.crds[0];
                assert!(!published.runs, "{case}: {cause:?}");
                let ran_out = matches!(published.stop, StopReason::Completed | StopReason::Underrun);
                let over = ran_out && published.released[0] == entries.len() as u32;
                if ran_out && !over {
                    // It had stopped in front of a delay before that tick.
                    (before, early) = (view, early + 1);
                } else if over {
                    // It had come to its end before that tick.
                    assert_eq!(at(&view).map(pulses), [f64::from(end[0]) + 100.0, f64::from(end[1]) - 50.0]);
                } else {
                    assert_eq!(published.stop, reason, "{case}");
                    assert_eq!((at(&view), published.done), (at(&before), before.crds[0].done), "{case}: {cause:?}");
                    assert_eq!(published.motion, servo::segment::piece::Motion::STANDSTILL);
                    stops += 1;
                    within += (before.crds[0].motion != servo::segment::piece::Motion::STANDSTILL) as u32;
                    // An output of the part that is repeated has been reported.
                    back += reported as u32;
                }
                let_go(&mut bench, cause);
                if over {
                    ended = true;
                    break;
                }
                bench.start_path(&[0]);
                bench.machine.edges.clear();
                let begun = bench.tick();
                assert!(begun.crds[0].runs, "{case}: {cause:?}");
                assert_eq!(at(&begun), at(&before), "{case}");
                view = begun;
                continue;
            }
            wait -= 1;
            before = view;
            bench.machine.edges.clear();
            view = bench.tick();
            let gone = [0, 1].map(|k| pulses(at(&view)[k]) - pulses(at(&before)[k]));
            let most = 60.0 * f64::from(period) / 1000.0 + 1e-6;
            assert!(gone[0].hypot(gone[1]) <= most, "{case}: {gone:?}");
            assert!(view.crds[0].done[0] >= last_done, "{case}");
            last_done = view.crds[0].done[0];
            let (runs, released) = (view.crds[0].runs, view.crds[0].released);
            if !runs && released[0] == entries.len() as u32 {
                ended = true;
                break;
            }
            if !runs {
                assert_eq!(view.crds[0].stop, StopReason::Underrun, "{case}");
                bench.start_path(&[0]);
                early += 1;
            }
        }
        assert!(ended, "{case}");
        let motions = entries.iter().filter(|entry| entry.is_motion()).count() as u32;
        let published = &bench.tick().crds[0];
        assert_eq!((published.done[0], published.released[0]), (motions, entries.len() as u32), "{case}");
        assert_eq!(published.position[..2], end.map(Pos::pulses), "{case}");
        // Each once, in order.
        assert_eq!(bench.machine.levels, (0..=last).collect::<Vec<_>>(), "{case}");
    }
    assert!(stops > 2000 && within > 1000 && back > 50 && early > 20, "{stops} {within} {back} {early}");
}

/// Motions shorter than a tick with axes geared to them, stopped in any tick: each axis ends where
/// its gears add up to. What was geared to a motion that had ended was made twice.
#[test]
fn what_is_geared_goes_along_once() {
    let mut chance = Chance::new(9);
    for case in 0..200 {
        let period = [50, 250, 1000][case % 3];
        let (mut entries, mut x, mut sums) = (Vec::new(), -100, [0, 0]);
        for _ in 0..60 {
            x += 1 + chance.below([3, 12][case % 2]) as i32;
            if chance.below(2) == 0 {
                let (which, by) = (chance.below(2) as usize, chance.below(40) as i32 - 20);
                entries.push(PathEntry::gear(axis(4 + which), by));
                sums[which] += by;
            }
            entries.push(PathEntry::planar([x, 50], speeds(20.0, 4.0, 20.0 * chance.unit())));
        }
        let mut bench = prepared(period, &entries);
        let mut view = bench.tick();
        while view.crds[0].runs {
            view = bench.ticks(1 + chance.below(6) as u32);
            if view.crds[0].runs {
                let stopped = stop(&mut bench, Cause::Stop);
                if stopped.crds[0].stop == StopReason::StopAbrupt {
                    bench.start_path(&[0]);
                    bench.ticks(2 + chance.below(20) as u32);
                }
                view = bench.tick();
            }
        }
        let end = bench.run_to_standstill();
        assert_eq!(pulses(at(&end)[0]), f64::from(x) + 100.0, "{case}");
        assert_eq!([4, 5].map(|axis| pulses(end.axes[axis].pos)), sums.map(f64::from), "{case}");
    }
}

/// A move that the path waits for has begun between both ticks: the start that goes on waits for it
/// again. One that it did not wait for has been made.
#[test]
fn moves_between_both_ticks_are_not_lost_nor_made_twice() {
    let moves = |modal| {
        PathEntry::travel(axis(4), 60, (20f64.to_bits(), StepLimit::FULL_SCALE), 10f64.to_bits(), modal).unwrap()
    };
    for modal in [true, false] {
        // 40 pulses with 10 pulse/ms² from rest to rest: 4 ms, and 2 ticks more for the start.
        let lines = [[-60, 50], [-20, 50]].map(|to| PathEntry::planar(to, speeds(30.0, 10.0, 0.0)));
        let mut bench = prepared(250, &[]);
        let entries = [lines[0], moves(modal), output(1), lines[1]];
        bench.path(0, 0, &entries);
        bench.start_path(&[0]);
        // The corner lies in the interval after this one.
        let mut view = bench.tick();
        while view.axes[4].status & servo::status::RUNNING == 0 {
            view = bench.tick();
        }
        let moved = view;
        for _ in 0..3 {
            let before = view;
            let published = stop(&mut bench, Cause::Stop);
            assert_eq!(at(&published), at(&before), "{modal}");
            let_go(&mut bench, Cause::Stop);
            bench.start_path(&[0]);
            view = bench.ticks(3);
        }
        let end = bench.run_to_standstill();
        assert_eq!(at(&end).map(pulses), [80.0, 0.0]);
        assert_eq!((pulses(end.axes[4].pos), end.general_outputs), (60.0, 1), "{modal}");
        assert_eq!(end.crds[0].stop, StopReason::Completed);
        assert!(moved.crds[0].runs);
    }
}
