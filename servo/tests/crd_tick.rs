//! Coordinate systems in the tick: positions of mapped axes, what stops them, what starts.
use crate::tick_bench;
#[path = "crd_tick/limits.rs"]
mod limits;
use servo::path::{FeedOverride, MotionSpeeds, PathEntry, PathStop, Plane, Sweep};
use servo::status;
use servo::tick_command::{DoGroup, Guarded, Guards, Lane, MotionMode, TickCommand};
use servo::units::{AxisMask, CrdMask, Ns, Pos};
use servo::view::{Event, StopReason, View};

use tick_bench::*;

fn speeds(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

fn line(x: i32, y: i32) -> PathEntry {
    PathEntry::planar([x, y], speeds(10.0, 1.0, 0.0))
}

/// A coordinate system on axes 2 and 5 with these entries in FIFO 0.
fn prepared(period_us: u32, entries: &[PathEntry]) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::Trap);
    bench.frame(0, &[2, 5], Some([100, -50, 0, 0]));
    bench.tick();
    bench.path(0, 0, entries);
    bench.tick();
    bench
}

fn place(view: &View<AXES>, axes: [usize; 2]) -> [f64; 2] {
    axes.map(|axis| pulses(view.axes[axis].pos))
}

/// A boundary within a ns after a tick: that tick is still in the motion before.
#[test]
fn a_boundary_just_after_a_tick_is_after_it() {
    // Up to 10 pulse/ms at `acc` in 5/acc ms more than the 4 ms of 40 pulses at that speed: 4.5 ms
    // and half a ns.
    let (vel, acc) = (10.0, 5.0 / 0.500_000_5);
    let along = speeds(vel, acc, vel);
    let entries: Vec<_> = (1..=6).map(|k| PathEntry::planar([40 * k - 100, 50], along)).collect();
    let mut bench = prepared(250, &[]);
    bench.path(0, 0, &entries);
    bench.start_path(&[0]);
    let zero = bench.tick().now.0;
    let travelled = |ms: f64| if ms < vel / acc { acc * ms * ms / 2.0 } else { vel * ms - vel * vel / acc / 2.0 };
    for _ in 0..60 {
        let view = bench.tick();
        let ms = (view.now.0 - zero) as f64 / 1e6;
        // Its zero is at 100 pulses, -50, and its axes are at 0.
        let (x, along) = (pulses(view.crds[0].position[0]) + 100.0, travelled(ms));
        assert!((x - along).abs() < 1e-5, "{ms} ms: {x}, not {along}");
    }
}

/// A path at 10 pulse/ms whose boundaries lie on ticks, or between them: every tick counts the
/// motions completed at it, and the entries that are over. An abrupt Stop goes back to what was
/// published.
#[test]
fn every_tick_counts_what_is_over() {
    for (length, count) in [(40, 12u64), (41, 12), (13, 40), (2, 300)] {
        let along = speeds(10.0, 10.0, 10.0);
        let entries: Vec<_> = (1..=count as i32).map(|k| PathEntry::planar([length * k - 100, 50], along)).collect();
        let mut bench = prepared(250, &[]);
        bench.path(0, 0, &entries);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        // It speeds up for a ms, over 5 pulses.
        let over = |k: u64| if k * length as u64 > 5 { (k * length as u64 + 5) * 100_000 } else { 0 };
        for _ in 0..(count - 3) * length as u64 / 10 * 4 {
            let view = bench.tick();
            let now = view.now.0 - zero;
            if now < 1_500_000 {
                continue;
            }
            let done = (1..count).filter(|k| over(*k) <= now).count() as u32;
            let published = &view.crds[0];
            assert_eq!((published.done[0], published.released[0]), (done, done), "{length} pulses, {now} ns");
        }
    }
}

#[test]
fn a_line_moves_both_axes_by_their_share() {
    let mut bench = prepared(250, &[]);
    let view = bench.tick();
    // Its zero is at 100, -50; the axes are at 0.
    assert_eq!(view.crds[0].position[..2], [Pos::pulses(-100), Pos::pulses(50)]);
    assert_eq!(
        (view.axes[2].mode, view.axes[5].mode, view.axes[0].mode),
        (MotionMode::Crd, MotionMode::Crd, MotionMode::Trap)
    );
    bench.path(0, 0, &[line(200, 450)]);
    bench.start_path(&[0]);
    let begin = bench.tick();
    assert!(begin.crds[0].runs && has(&begin.axes[2], status::RUNNING) && has(&begin.axes[5], status::RUNNING));
    assert_eq!(place(&begin, [2, 5]), [0.0, 0.0]);
    // 300 and 400 pulses: 500 along, 10 ms up to 10 pulse/ms in 50 pulses, 60 ms in all.
    let (zero, t) = (begin.now.0, |ms: f64| (ms * 1e6) as u64);
    for (ms, travelled) in [(5.0, 12.5), (10.0, 50.0), (30.0, 250.0), (50.0, 450.0), (55.0, 487.5)] {
        let view = bench.until(zero + t(ms));
        let [x, y] = place(&view, [2, 5]);
        assert!((x - 0.6 * travelled).abs() < 1e-6 && (y - 0.8 * travelled).abs() < 1e-6, "{ms}: {x} {y}");
        let v = if ms < 10.0 {
            ms
        } else if ms > 50.0 {
            60.0 - ms
        } else {
            10.0
        };
        let a = if ms < 10.0 {
            1.0
        } else if ms >= 50.0 {
            -1.0
        } else {
            0.0
        };
        for (axis, share) in [(2, 0.6), (5, 0.8)] {
            let motion = view.motion(&view.axes[axis]);
            assert!((real(motion.velocity()) - share * v).abs() < 1e-8, "{ms} {}", real(motion.velocity()));
            if ms != 10.0 {
                assert!((real(motion.acceleration()) - share * a).abs() < 1e-8, "{ms}");
            }
        }
    }
    let end = bench.until(zero + t(60.0) + 250_000);
    assert_eq!(place(&end, [2, 5]), [300.0, 400.0]);
    assert!(!end.crds[0].runs && end.axes[2].status & status::RUNNING == 0);
    let later = bench.ticks(3);
    assert!(has(&later.axes[2], status::IN_POSITION) && later.axes[2].encoder == 300);
    assert!(begin.axes[2].status & status::IN_POSITION == 0 && later.axes[2].stop == StopReason::Completed);
    assert_eq!(
        (end.crds[0].stop, end.crds[0].path_stop, end.crds[0].done),
        (StopReason::Completed, PathStop::Completed, [1, 0])
    );
    assert!(
        matches!(bench.event(), Some(Event::CrdStopped { crd: of, reason: StopReason::Completed, .. }) if of == crd(0))
    );
    assert!(bench.event().is_none());
}

/// Ticks until the path rests.
fn finish(bench: &mut Bench, index: usize) -> View<AXES> {
    loop {
        let view = bench.tick();
        if !view.crds[index].runs {
            return view;
        }
        assert!(view.now.0 < 60_000 * MS, "it does not come to rest");
    }
}

fn stopped_crd(event: Option<Event>) -> (usize, StopReason) {
    match event {
        Some(Event::CrdStopped { crd, reason, .. }) => (crd.index(), reason),
        other => panic!("no stop but {other:?}"),
    }
}

fn stop(bench: &mut Bench, axes: &[usize], abrupt: &[usize]) {
    bench.now(TickCommand::stop(all(axes), all(abrupt)));
}

/// Every coordinate drives the axis that it is mapped to, from the origin, in lines, arcs and
/// circles of each plane.
#[test]
fn any_axes_in_any_order_with_any_origin() {
    for (axes, origin) in [
        ([0, 1, 2, 3], Some([0; 4])),
        ([7, 3, 5, 1], Some([1000, -2000, 60_000, 4])),
        ([3, 2, 1, 0], None),
        ([6, 0, 7, 4], Some([-1, 1, -1, 1])),
    ] {
        let mut bench = Bench::prepared(1000, MotionMode::Trap);
        for (k, index) in axes.into_iter().enumerate() {
            bench.now(TickCommand::SetPosition { axis: axis(index), pos: Pos::pulses(10 * k as i32 + 5) });
        }
        bench.frame(1, &axes, origin);
        let view = bench.tick();
        let zero = origin.unwrap_or([5, 15, 25, 35]);
        assert_eq!(view.crds[1].origin, zero.map(Pos::pulses));
        let along = speeds(1000.0, 100.0, 0.0);
        let sweep = Sweep::admit(0.25f64.to_bits(), false, true).unwrap();
        let entries = [
            (PathEntry::line([10, 20, 30, 40], along), [10, 20, 30, 40]),
            (PathEntry::arc(Plane::Yz, [0, 50], sweep, along), [10, 0, 50, 40]),
            (PathEntry::circle(Plane::Zx, [100 << 30, 50 << 30], false, along).unwrap(), [10, 0, 50, 40]),
            (PathEntry::planar([-300, 300], along), [-300, 300, 50, 40]),
        ];
        for (entry, expected) in entries {
            bench.path(1, 0, &[entry]);
            bench.start_path(&[1]);
            let view = finish(&mut bench, 1);
            assert_eq!(view.crds[1].position, expected.map(Pos::pulses));
            for ((index, at), zero) in axes.into_iter().zip(expected).zip(zero) {
                let pos = (i64::from(at) + i64::from(zero)) << Pos::FRAC_BITS;
                assert_eq!((view.axes[index].pos, view.axes[index].mode), (Pos(pos), MotionMode::Crd));
            }
        }
    }
}

/// Velocity and acceleration of an axis on an arc: R·ω·sin and R·ω²·cos, and what the path's own
/// acceleration adds.
#[test]
fn axes_on_an_arc_have_their_own_velocity_and_acceleration() {
    let (r, v, a) = (500.0, 20.0, 0.5);
    let centre = [500i64 << 30, 0];
    for ccw in [false, true] {
        let mut bench = prepared(250, &[]);
        bench.frame(0, &[2, 5], None);
        bench.tick();
        bench.path(0, 0, &[PathEntry::circle(Plane::Xy, centre, ccw, speeds(v, a, 0.0)).unwrap()]);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        for ms in [3u64, 25, 60, 100, 140] {
            let view = bench.until(zero + ms * MS);
            let t = ms as f64;
            // It speeds up for 40 ms, 400 pulses; 3141.59 in all.
            let (s, speed, acc) = if t < 40.0 { (a * t * t / 2.0, a * t, a) } else { (400.0 + v * (t - 40.0), v, 0.0) };
            let side = if ccw { -1.0 } else { 1.0 };
            let angle = s / r;
            // From the left of the centre; clockwise is up first.
            let expected = [
                (r - r * angle.cos(), speed * angle.sin(), acc * angle.sin() + speed * speed / r * angle.cos()),
                (r * angle.sin(), speed * angle.cos(), acc * angle.cos() - speed * speed / r * angle.sin()),
            ];
            for (index, (pos, vel, acc), side) in [(2, expected[0], 1.0), (5, expected[1], side)] {
                let motion = view.motion(&view.axes[index]);
                assert!((pulses(view.axes[index].pos) - side * pos).abs() < 1e-3);
                assert!((real(motion.velocity()) - side * vel).abs() < 1e-5, "{index} {ms}");
                assert!((real(motion.acceleration()) - side * acc).abs() < 1e-5, "{index} {ms}");
            }
        }
    }
}

/// A start does nothing at all where one of its coordinate systems must not start.
#[test]
fn a_start_is_all_or_nothing() {
    let entries = [line(200, 450)];
    type Break = fn(&mut Bench);
    let breaks: [(&str, Break); 7] = [
        ("servo off", |bench| {
            bench.now(TickCommand::Servo { axis: axis(5), on: false });
        }),
        ("alarm", |bench| bench.machine.inputs[2].alarm = true),
        ("limit", |bench| bench.machine.inputs[2].limit_positive = true),
        ("nothing in it", |bench| bench.clear_path(0, 0)),
        ("another mode", |bench| {
            bench.now(TickCommand::SetMode { axis: axis(2), mode: MotionMode::Trap });
        }),
        ("another crd's", |bench| bench.frame(2, &[2], None)),
        ("no frame", |bench| {
            bench.now(TickCommand::Reset { axes: all(&[5]) });
            bench.now(TickCommand::Servo { axis: axis(5), on: true });
        }),
    ];
    for (what, act) in breaks {
        let mut bench = prepared(250, &entries);
        bench.frame(1, &[0, 1], None);
        bench.tick();
        bench.path(1, 0, &entries);
        act(&mut bench);
        bench.ticks(2);
        while bench.event().is_some() {}
        let before = bench.tick();
        let seq = bench.now(TickCommand::CrdStart { crds: crd_mask(&[0, 1]), fifo1: CrdMask(0) });
        let after = bench.ticks(40);
        for (crd, other) in before.crds.iter().zip(&after.crds) {
            assert_eq!((crd.position, crd.runs, crd.version), (other.position, other.runs, other.version), "{what}");
        }
        assert!(after.axes.iter().all(|axis| axis.status & status::RUNNING == 0), "{what}");
        match bench.event() {
            Some(Event::Refused { lane: Lane::Immediate, seq: of, axis, .. }) => {
                assert!(of == seq && matches!(what, "servo off" | "alarm" | "limit"), "{what}");
                assert_eq!(axis.index(), if what == "servo off" { 5 } else { 2 });
            }
            Some(Event::CrdRefused { lane: Lane::Immediate, seq: of, crd }) => {
                assert!(of == seq && crd.index() == 0 && !matches!(what, "servo off" | "alarm" | "limit"), "{what}");
            }
            other => panic!("{what}: {other:?}"),
        }
        assert!(bench.event().is_none());
    }
    // One that runs refuses too, and runs on.
    let mut bench = prepared(250, &entries);
    bench.start_path(&[0]);
    bench.ticks(10);
    bench.start_path(&[0]);
    assert!(bench.tick().crds[0].runs);
    assert!(matches!(bench.event(), Some(Event::CrdRefused { .. })));
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0]);
}

/// A smooth stop by an axis bit brakes along the path; a start goes on from there to the same end.
#[test]
fn a_stop_brakes_along_the_path_and_a_start_goes_on() {
    for period in [10, 250, 1000] {
        let mut bench = prepared(period, &[line(200, 450)]);
        bench.now(TickCommand::CrdStopDec { crd: crd(0), dec: accel(2.0) });
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        bench.until(zero + 20 * MS - period as u64 * 1000);
        stop(&mut bench, &[5], &[]);
        let view = finish(&mut bench, 0);
        // 150 pulses in 20 ms, 25 of braking.
        let [x, y] = place(&view, [2, 5]);
        assert!((x - 105.0).abs() < 1e-6 && (y - 140.0).abs() < 1e-6, "{x} {y}");
        assert_eq!(view.now.0 - zero, 25 * MS);
        let published = view.crds[0];
        assert_eq!(
            (published.stop, published.path_stop, published.done),
            (StopReason::StopSmooth, PathStop::Stopped, [0, 0])
        );
        assert_eq!((view.axes[2].stop, view.axes[5].stop), (StopReason::StopSmooth, StopReason::StopSmooth));
        assert_eq!(stopped_crd(bench.event()), (0, StopReason::StopSmooth));
        bench.start_path(&[0]);
        assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0]);
        assert_eq!(stopped_crd(bench.event()), (0, StopReason::Completed));
        assert!(bench.event().is_none());
    }
}

#[test]
fn an_abrupt_stop_has_no_velocity_on_its_tick() {
    for by_crd in [false, true] {
        let mut bench = prepared(250, &[line(200, 450)]);
        bench.start_path(&[0]);
        let zero = bench.tick().now.0;
        bench.until(zero + 20 * MS - 250_000);
        if by_crd {
            bench.now(TickCommand::stop_crds(CrdMask(1), CrdMask(1)));
        } else {
            stop(&mut bench, &[2, 5], &[5]);
        }
        let view = bench.tick();
        assert!(!view.crds[0].runs && view.crds[0].stop == StopReason::StopAbrupt);
        let [x, y] = place(&view, [2, 5]);
        // 147.5 pulses along, where it was at the tick before.
        assert!((x - 88.5).abs() < 1e-6 && (y - 118.0).abs() < 1e-6, "{x} {y}");
        assert_eq!(real(view.motion(&view.axes[2]).velocity()), 0.0);
        bench.start_path(&[0]);
        assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0]);
    }
}

#[test]
fn running_out_at_speed_is_an_underrun_and_needs_no_clearing() {
    let mut bench = prepared(250, &[PathEntry::planar([-95, 50], speeds(10.0, 1.0, 0.0)), line(-92, 50)]);
    // 5 pulses are too short to come to rest from what the first may end with.
    bench.clear_path(0, 0);
    bench.tick();
    let fast = speeds(10.0, 1.0, 10.0);
    bench.path(0, 0, &[PathEntry::planar([0, 50], fast), PathEntry::planar([5, 50], fast)]);
    bench.start_path(&[0]);
    let view = finish(&mut bench, 0);
    assert_eq!((view.crds[0].stop, view.crds[0].path_stop), (StopReason::Underrun, PathStop::Underrun));
    assert_eq!(place(&view, [2, 5]), [105.0, 0.0]);
    bench.path(0, 0, &[line(0, 0)]);
    bench.start_path(&[0]);
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [100.0, -50.0]);
}

#[test]
fn fifo_1_interrupts_fifo_0_and_returns() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.path(0, 1, &[line(0, 0)]);
    bench.start_path(&[0]);
    bench.ticks(100);
    bench.now(TickCommand::stop_crds(CrdMask(1), CrdMask(0)));
    let left = finish(&mut bench, 0);
    bench.now(TickCommand::CrdStart { crds: CrdMask(1), fifo1: CrdMask(1) });
    let there = finish(&mut bench, 0);
    assert_eq!((place(&there, [2, 5]), there.crds[0].fifo), ([100.0, -50.0], 1));
    // Not where FIFO 0 was interrupted.
    bench.start_path(&[0]);
    bench.tick();
    while !matches!(bench.event().unwrap(), Event::CrdRefused { .. }) {}
    let [x, y] = left.crds[0].position.map(pulses)[..2].try_into().unwrap();
    bench.path(0, 1, &[line(x.round() as i32, y.round() as i32)]);
    bench.now(TickCommand::CrdStart { crds: CrdMask(1), fifo1: CrdMask(1) });
    assert_eq!(finish(&mut bench, 0).crds[0].position, left.crds[0].position);
    bench.start_path(&[0]);
    let end = finish(&mut bench, 0);
    assert_eq!((place(&end, [2, 5]), end.crds[0].done, end.crds[0].released), ([300.0, 400.0], [1, 2], [1, 2]));
}

/// A motion made ahead is made anew if data, an override or a Stop has changed it: it is the same
/// as without preparation, in every tick.
#[test]
fn what_is_made_ahead_does_not_outlive_a_change() {
    let v = speeds(10.0, 1.0, 10.0);
    let first = [PathEntry::planar([200, 50], v), PathEntry::planar([400, 50], v)];
    let more = [PathEntry::planar([400, 250], v), PathEntry::planar([0, 0], speeds(10.0, 1.0, 0.0))];
    for period in [250, 1000] {
        // Data that comes at once, or after so many ticks, until the second motion has begun to
        // brake.
        let mut seen: Vec<Vec<[Pos; 2]>> = Vec::new();
        for late in [0u64, 3, 20, 28] {
            let mut bench = prepared(period, &first);
            bench.start_path(&[0]);
            let mut places = Vec::new();
            let ticks = late * 1000 / u64::from(period);
            for tick in 0.. {
                if tick == ticks {
                    bench.path(0, 0, &more);
                }
                let view = bench.tick();
                places.push([2, 5].map(|axis: usize| view.axes[axis].pos));
                if !view.crds[0].runs {
                    break;
                }
            }
            seen.push(places);
        }
        for (k, places) in seen.iter().enumerate() {
            assert!(places == &seen[0], "{period} {k}: {} and {} ticks", places.len(), seen[0].len());
        }
    }
}

/// A clearing makes the FIFO empty, its counts 0, and earlier commits void.
#[test]
fn clearing_is_counted_and_old_commits_are_void() {
    let mut bench = prepared(250, &[line(200, 450), line(0, 0)]);
    let old = bench.path_data(0, 0, &[line(5, 5)]);
    bench.start_path(&[0]);
    bench.ticks(300);
    bench.now(TickCommand::CrdClear { crd: crd(0), fifo: 0 });
    let running = bench.tick();
    assert!(running.crds[0].runs && running.crds[0].cleared == [1, 1], "it runs on");
    let end = finish(&mut bench, 0);
    assert_eq!((end.crds[0].done, end.crds[0].released, end.crds[0].ends), ([2, 0], [2, 0], [2, 0]));
    bench.clear_path(0, 0);
    bench.now(old);
    let clear = bench.tick();
    assert_eq!((clear.crds[0].done, clear.crds[0].released, clear.crds[0].ends), ([0; 2], [0; 2], [0; 2]));
    assert_eq!(clear.crds[0].cleared, [2, 1]);
    bench.path(0, 0, &[line(10, 10)]);
    bench.start_path(&[0]);
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [110.0, -40.0]);
}

#[test]
fn an_override_acts_during_motion() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.now(TickCommand::CrdOverride { crd: crd(0), rate: FeedOverride::admit(0.5f64.to_bits()).unwrap() });
    bench.start_path(&[0]);
    let zero = bench.tick().now.0;
    let speed = |view: &View<AXES>| real(view.crds[0].motion.velocity());
    assert!((speed(&bench.until(zero + 20 * MS)) - 5.0).abs() < 1e-9);
    bench.now(TickCommand::CrdOverride { crd: crd(0), rate: FeedOverride::admit(1.0f64.to_bits()).unwrap() });
    assert!((speed(&bench.until(zero + 22 * MS + 250_000)) - 7.0).abs() < 1e-9);
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0]);
}

/// SetPrfPos and ZeroPos give the position of the path another value; a path that was interrupted
/// there cannot go on.
#[test]
fn naming_a_position_moves_the_coordinates_with_it() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.now(TickCommand::SetPosition { axis: axis(2), pos: Pos::pulses(350) });
    let set_point = bench.machine.set_points[2];
    let view = bench.tick();
    assert_eq!((view.crds[0].position[0], bench.machine.set_points[2]), (Pos::pulses(250), set_point));
    bench.start_path(&[0]);
    bench.ticks(50);
    stop(&mut bench, &[2], &[]);
    finish(&mut bench, 0);
    bench.now(TickCommand::Zero { axes: all(&[2, 5]) });
    let view = bench.tick();
    assert_eq!(view.crds[0].position[..2], [Pos::pulses(-100), Pos::pulses(50)]);
    while bench.event().is_some() {}
    bench.start_path(&[0]);
    bench.tick();
    assert!(matches!(bench.event(), Some(Event::CrdRefused { .. })));
    bench.clear_path(0, 0);
    bench.tick();
    bench.path(0, 0, &[line(0, 0)]);
    bench.start_path(&[0]);
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [100.0, -50.0]);
}

/// An axis that goes into another mode leaves its coordinate system; setting that again takes it
/// back.
#[test]
fn an_axis_may_leave_and_come_back() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.now(TickCommand::SetMode { axis: axis(2), mode: MotionMode::Jog });
    bench.jog(2, 5.0, 1.0);
    bench.ticks(100);
    stop(&mut bench, &[2], &[]);
    let view = bench.run_to_standstill();
    assert!(view.axes[2].mode == MotionMode::Jog && pulses(view.axes[2].pos) > 20.0);
    bench.frame(0, &[2, 5], Some([0; 4]));
    let view = bench.tick();
    assert_eq!((view.axes[2].mode, view.crds[0].position[0]), (MotionMode::Crd, view.axes[2].pos));
    bench.path(0, 0, &[line(-7, 9)]);
    bench.start_path(&[0]);
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [-7.0, 9.0]);
    // Other axes: the old ones are in Trap mode again.
    bench.frame(0, &[1, 2], Some([0; 4]));
    let view = bench.tick();
    assert_eq!(
        [1, 2, 5].map(|index: usize| view.axes[index].mode),
        [MotionMode::Crd, MotionMode::Crd, MotionMode::Trap]
    );
}

#[test]
fn a_reset_of_one_axis_leaves_no_frame() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.start_path(&[0]);
    bench.ticks(100);
    let set_points = bench.machine.set_points;
    bench.now(TickCommand::Reset { axes: all(&[5]) });
    let view = bench.tick();
    assert!(view.crds[0].frame.is_none() && !view.crds[0].runs && view.crds[0].ends == [0; 2]);
    assert_eq!((view.axes[2].mode, view.axes[5].mode, view.axes[5].pos), (MotionMode::Trap, MotionMode::Trap, Pos(0)));
    assert!(view.axes[2].status & status::RUNNING == 0 && view.axes[2].stop == StopReason::Reset);
    let after = bench.machine.set_points;
    assert!((after[5].0 - set_points[5].0).abs() < 3 << Pos::FRAC_BITS);
    bench.ticks(10);
    assert_eq!(bench.machine.set_points, after);
}

#[test]
fn a_lost_link_stops_paths_smoothly_and_they_go_on() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.start_path(&[0]);
    let zero = bench.tick().now.0;
    bench.until(zero + 20 * MS - 250_000);
    bench.now(TickCommand::Link { lost: true });
    let view = finish(&mut bench, 0);
    assert_eq!((view.crds[0].stop, view.crds[0].path_stop), (StopReason::LinkLoss, PathStop::Stopped));
    // 1 pulse/ms² from 10 pulse/ms.
    assert_eq!(view.now.0 - zero, 30 * MS);
    bench.now(TickCommand::Link { lost: false });
    bench.start_path(&[0]);
    assert_eq!(place(&finish(&mut bench, 0), [2, 5]), [300.0, 400.0]);
}

/// A program waits for a path, and its trace has the path's speed.
#[test]
fn a_program_waits_for_a_path_and_traces_it() {
    let mut bench = prepared(250, &[line(200, 450)]);
    bench.now(TickCommand::Trace {
        every: 4,
        axes: all(&[5]),
        crds: CrdMask(1),
        lasers: 0,
        edges: false,
        outputs: false,
    });
    bench.now(TickCommand::ProgramRun);
    bench.then(0, TickCommand::CrdStart { crds: CrdMask(1), fifo1: CrdMask(0) });
    bench.then(0, TickCommand::WaitStandstill { axes: AxisMask(0), crds: CrdMask(1) });
    bench.then(0, TickCommand::Output { group: DoGroup::General, mask: 1, value: 1 });
    bench.then(0, TickCommand::ProgramEnd);
    let zero = bench.tick().now.0 - 250_000;
    while bench.tick().general_outputs & 1 == 0 {}
    // It begins with row 1's tick, is at rest 60 ms later; the output is on with the tick after.
    let Ns(now) = bench.tick().now;
    assert_eq!(now - 250_000, zero + 250_000 + 60 * MS + 250_000);
    let mut rows = 0;
    while let Some(sample) = bench.sample() {
        match sample.of {
            servo::view::Traced::Axis { axis, .. } => assert!(axis.index() == 5 && sample.row == rows),
            servo::view::Traced::Crd { crd, motion } => {
                assert!(crd.index() == 0 && sample.row == rows);
                let t = f64::from(rows) - 0.25;
                let v = if t < 10.0 {
                    t.max(0.0)
                } else if t > 50.0 {
                    (60.0 - t).max(0.0)
                } else {
                    10.0
                };
                assert!((real(motion.velocity()) - v).abs() < 1e-9, "row {rows}");
                rows += 1;
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(rows > 55);
}
