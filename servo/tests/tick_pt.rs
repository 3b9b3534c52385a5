//! PT through the tick: time zero, exact ends, streams, epochs, all or nothing.
use crate::tick_bench;
use servo::status;
use servo::tick_command::{Lane, MotionMode, TickCommand};
use servo::units::{AxisMask, Ns, Pos};
use servo::view::{Event, StopReason};
use tick_bench::*;

/// Listing 2-1 in closed form: position in pulses at t ms.
fn listing(t: f64) -> f64 {
    match t {
        t if t <= 1024.0 => t * t / 1024.0,
        t if t <= 2048.0 => 1024.0 + 2.0 * (t - 1024.0),
        t if t <= 3072.0 => 4096.0 - (3072.0 - t) * (3072.0 - t) / 1024.0,
        _ => 4096.0,
    }
}

#[test]
fn listing_2_1_is_the_closed_form_at_every_period() {
    let mut at_ms: Vec<Vec<Pos>> = Vec::new();
    for period in [50, 250, 1000] {
        let mut bench = Bench::prepared(period, MotionMode::PtStatic);
        bench.pt(0, 0, &LISTING_2_1);
        bench.start(&[0]);
        let first = bench.tick();
        let zero = first.now.0;
        assert_eq!(first.axes[0].pos, Pos(0), "time zero is the tick that computes the start");
        assert!(has(&first.axes[0], status::RUNNING));
        let mut whole = vec![];
        loop {
            let view = bench.tick();
            let t = view.now.0 - zero;
            let published = &view.axes[0];
            let off = (pulses(published.pos) - listing(t as f64 / MS as f64)).abs();
            assert!(off <= 1.0 / 65536.0, "{off} pulse off at {t} ns");
            if t > 1024 * MS && t < 2048 * MS {
                assert!((real(published.motion.velocity()) - 2.0).abs() < 1e-12);
            }
            if t.is_multiple_of(MS) {
                whole.push(published.pos);
            }
            assert_eq!(has(published, status::RUNNING), t < 3072 * MS, "at {t} ns");
            if t == 3072 * MS {
                assert_eq!(published.pos, Pos::pulses(4096));
                assert_eq!(real(published.motion.velocity()), 0.0);
                assert_eq!((published.stop, published.passes, published.pt_state), (StopReason::Completed, 1, 2));
                assert_eq!(stopped(bench.event()), (0, StopReason::Completed));
                assert!(bench.event().is_none());
                break;
            }
        }
        at_ms.push(whole);
    }
    assert_eq!(at_ms[0], at_ms[1]);
    assert_eq!(at_ms[0], at_ms[2]);
    assert_eq!(at_ms[0].len(), 3072);
}

#[test]
fn loops_continue_where_the_pass_ended_and_can_be_ended_while_running() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.pt(0, 0, &[(10.0, 10, 0), (30.5, 20, 2)]);
    bench.now(TickCommand::PtLoop { axis: axis(0), passes: 0 });
    bench.start(&[0]);
    let zero = bench.tick().now.0;
    let view = bench.until(zero + 20 * 100 * MS);
    assert_eq!(view.axes[0].pos, Pos(100 * 30 * (1 << 22) + 50 * (1 << 22)));
    assert_eq!(view.axes[0].passes, 100);
    bench.now(TickCommand::PtLoop { axis: axis(0), passes: 101 });
    let view = bench.run_to_standstill();
    assert_eq!(view.now.0, zero + 20 * 101 * MS);
    assert_eq!((pulses(view.axes[0].pos), view.axes[0].passes), (30.5 * 101.0, 101));
    // Kept after it has run; FIFO 1 is another store.
    bench.now(TickCommand::PtLoop { axis: axis(0), passes: 1 });
    bench.pt(0, 1, &[(-7.0, 3, 1)]);
    bench.now(TickCommand::PtStart { axes: all(&[0]), fifo1: all(&[0]) });
    assert_eq!(pulses(bench.run_to_standstill().axes[0].pos), 30.5 * 101.0 - 7.0);
    bench.start(&[0]);
    assert_eq!(pulses(bench.run_to_standstill().axes[0].pos), 30.5 * 102.0 - 7.0);
}

#[test]
fn data_added_to_a_running_fifo_belongs_to_the_pass() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.pt(0, 0, &[(10.0, 10, 0)]);
    bench.start(&[0]);
    bench.ticks(20);
    bench.pt(0, 0, &[(20.0, 20, 0)]);
    let view = bench.run_to_standstill();
    assert_eq!((pulses(view.axes[0].pos), view.axes[0].passes), (20.0, 1));
}

/// A smooth Stop in the very tick at which the last pass ends: data, or a pass, that comes after it
/// in the same instant does not lengthen the motion.
#[test]
fn what_comes_after_a_stop_at_the_end_moves_nothing() {
    for longer in [false, true] {
        let mut bench = Bench::prepared(250, MotionMode::PtStatic);
        bench.pt(0, 0, &[(10.0, 10, 0)]);
        bench.now(TickCommand::PtLoop { axis: axis(0), passes: 2 });
        bench.start(&[0]);
        let zero = bench.tick().now.0;
        let view = bench.until(zero + 20 * MS - 250_000);
        assert!(has(&view.axes[0], status::RUNNING));
        bench.now(TickCommand::stop(all(&[0]), all(&[])));
        if longer {
            bench.pt(0, 0, &[(40.0, 20, 0)]);
        } else {
            bench.now(TickCommand::PtLoop { axis: axis(0), passes: 5 });
        }
        let view = bench.tick();
        let published = view.axes[0];
        assert_eq!((pulses(published.pos), published.passes, published.stop), (20.0, 2, StopReason::Completed));
        assert!(!has(&published, status::RUNNING), "longer: {longer}");
        assert_eq!(stopped(bench.event()), (0, StopReason::Completed));
        assert!(bench.event().is_none());
        let view = bench.ticks(100);
        assert_eq!((pulses(view.axes[0].pos), has(&view.axes[0], status::RUNNING)), (20.0, false));
        // What was given counts for the next start.
        bench.start(&[0]);
        let end = if longer { 20.0 + 2.0 * 40.0 } else { 20.0 + 5.0 * 10.0 };
        assert_eq!(pulses(bench.run_to_standstill().axes[0].pos), end);
    }
}

/// The last tick of a Trap: a smooth Stop leaves it to end at its target; an abrupt Stop beside it
/// counts, and leaves the axis where it was.
#[test]
fn an_abrupt_stop_counts_beside_a_smooth_one_at_the_end() {
    let moves = || {
        let mut bench = Bench::prepared(250, MotionMode::Trap);
        let (axis, one) = (axis(0), accel(1.0));
        bench.now(TickCommand::TrapPrm { axis, acc: one, dec: one, vel_start: speed(0.0), smooth: Ns(0) });
        bench.now(TickCommand::TargetSpeed { axis, speed: speed(5.0) });
        bench.now(TickCommand::TargetPosition { axis, pulses: 101 });
        bench.now(TickCommand::Update { axes: all(&[0]) });
        bench.tick();
        bench
    };
    let end = moves().run_to_standstill().now.0;
    for abrupt in [false, true] {
        let mut bench = moves();
        let before = bench.until(end - 250_000).axes[0].pos;
        assert!((100.9..101.0).contains(&pulses(before)));
        bench.now(TickCommand::stop(all(&[0]), all(&[])));
        if abrupt {
            bench.now(TickCommand::stop(all(&[0]), all(&[0])));
        }
        let (pos, reason) =
            if abrupt { (pulses(before), StopReason::StopAbrupt) } else { (101.0, StopReason::Completed) };
        let now = bench.tick().axes[0];
        assert_eq!((pulses(now.pos), now.stop, has(&now, status::RUNNING)), (pos, reason, false));
        assert_eq!(stopped(bench.event()), (0, reason));
        assert_eq!(pulses(bench.ticks(10).axes[0].pos), pos);
    }
}

#[test]
fn a_stream_that_runs_dry_at_speed_is_an_underrun_and_a_new_epoch() {
    let mut bench = Bench::prepared(250, MotionMode::PtDynamic);
    bench.pt(0, 0, &[(10.0, 10, 0), (30.0, 20, 0)]);
    bench.start(&[0]);
    let zero = bench.tick().now.0;
    let view = bench.until(zero + 15 * MS);
    assert_eq!(view.axes[0].released, 1, "the first segment's place is free");
    assert!((5..=6).contains(&view.axes[0].dry_ms), "5 ms before the end, reported at most 8 ticks ago");
    let view = bench.until(zero + 20 * MS);
    let published = view.axes[0];
    assert_eq!((pulses(published.pos), published.stop, published.pt_state), (30.0, StopReason::Underrun, 3));
    assert_eq!((published.epoch, published.released), (1, 0));
    assert!(!has(&published, status::RUNNING));
    assert_eq!(stopped(bench.event()), (0, StopReason::Underrun));
    // A commit in flight for the stream that ended is refused; it starts nothing.
    let void = bench.now(TickCommand::PtCommit { axis: axis(0), fifo: 0, end: 3, epoch: 0 });
    let seq = bench.start(&[0]);
    bench.tick();
    assert!(matches!(bench.event(), Some(Event::Refused { seq: s, lane: Lane::Immediate, .. }) if s == void));
    assert!(matches!(bench.event(), Some(Event::Refused { seq: s, lane: Lane::Immediate, .. }) if s == seq));
    // The next stream counts from 0, and needs no ClearStatus.
    bench.forget(0);
    bench.pt(0, 0, &[(5.0, 10, 0), (10.0, 20, 0)]);
    bench.start(&[0]);
    let view = bench.run_to_standstill();
    assert_eq!((pulses(view.axes[0].pos), view.axes[0].pt_state, view.axes[0].epoch), (40.0, 2, 2));
}

#[test]
fn a_stop_clears_the_stream_and_keeps_static_data() {
    for (mode, epoch, again) in [(MotionMode::PtDynamic, 1, false), (MotionMode::PtStatic, 0, true)] {
        let mut bench = Bench::prepared(250, mode);
        bench.pt(0, 0, &LISTING_2_1);
        bench.start(&[0]);
        bench.ticks(100);
        bench.now(TickCommand::stop(all(&[0]), all(&[0])));
        let view = bench.tick();
        assert_eq!((view.axes[0].pt_state, view.axes[0].epoch), (4, epoch));
        bench.start(&[0]);
        assert_eq!(has(&bench.tick().axes[0], status::RUNNING), again);
    }
}

#[test]
fn a_long_stream_wraps_its_ring() {
    let mut bench = Bench::prepared(1000, MotionMode::PtDynamic);
    let segment = |n: i32| ((n % 7) as f64 * 3.0, n, 2i16);
    let first: Vec<_> = (1..=2000).map(segment).collect();
    bench.pt(0, 0, &first);
    bench.start(&[0]);
    let zero = bench.tick().now.0;
    let mut pushed = 2000;
    for ms in 1..=6000 {
        let view = bench.until(zero + ms * MS);
        assert_eq!(pulses(view.axes[0].pos), ((ms as i32 % 7) * 3) as f64, "at {ms} ms");
        assert!(ms == 6000 || view.axes[0].released as u64 >= ms - 1);
        if pushed < 6000 {
            pushed += 1;
            // Beyond slot 2047 the store masks; fifo 0's base is 0.
            bench.pt(0, 0, &[segment(pushed)]);
        }
    }
    assert_eq!(bench.tick().axes[0].pt_state, 2);
}

#[test]
fn a_start_is_all_or_nothing() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    for index in [0, 1, 2] {
        bench.pt(index, 0, &LISTING_2_1);
    }
    bench.now(TickCommand::Servo { axis: axis(1), on: false });
    let seq = bench.start(&[0, 1, 2]);
    let view = bench.tick();
    assert!(view.axes.iter().all(|axis| !has(axis, status::RUNNING)));
    match bench.event() {
        Some(Event::Refused { lane: Lane::Immediate, seq: s, axis, status }) => {
            assert_eq!((s, axis.index(), status & status::SERVO_ON), (seq, 1, 0))
        }
        other => panic!("{other:?}"),
    }
    bench.now(TickCommand::Servo { axis: axis(1), on: true });
    bench.start(&[0, 1, 2]);
    let view = bench.tick();
    assert!(view.axes[..3].iter().all(|axis| has(axis, status::RUNNING) && axis.pos == Pos(0)));
    let view = bench.tick();
    assert_eq!(view.axes[0].pos, view.axes[2].pos);
    assert!(view.axes[0].pos > Pos(0));
    // One that runs, or has no data, refuses for all.
    bench.pt(3, 0, &LISTING_2_1);
    bench.start(&[3, 0]);
    assert!(!has(&bench.tick().axes[3], status::RUNNING));
    bench.start(&[3, 4]);
    assert!(!has(&bench.tick().axes[3], status::RUNNING));
    bench.now(TickCommand::PtStart { axes: AxisMask(0), fifo1: AxisMask(0) });
    bench.start(&[3]);
    assert!(has(&bench.tick().axes[3], status::RUNNING));
}

#[test]
fn a_mode_that_is_set_again_keeps_its_data() {
    let mut bench = Bench::prepared(250, MotionMode::PtStatic);
    bench.pt(0, 0, &LISTING_2_1);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.start(&[0]);
    assert!(has(&bench.tick().axes[0], status::RUNNING));
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    assert_eq!(bench.tick().axes[0].mode, MotionMode::PtStatic, "only at rest");
    bench.run_to_standstill();
    for mode in [MotionMode::PtDynamic, MotionMode::PtStatic] {
        bench.now(TickCommand::SetMode { axis: axis(0), mode });
    }
    bench.start(&[0]);
    assert!(!has(&bench.tick().axes[0], status::RUNNING), "another FIFO use clears the data");
}

/// Fast-path pieces are distinguished by 32 bits of time. After a piece that lasts longer than
/// these hold, such a piece is not entered before its time.
#[test]
fn a_long_segment_lasts_to_its_end() {
    for (first, second) in [(6000, 2000), (9000, 4000), (5000, 50)] {
        let mut bench = Bench::prepared(250, MotionMode::PtStatic);
        bench.pt(0, 0, &[(f64::from(first), first, 1), (f64::from(first), first + second, 1)]);
        bench.start(&[0]);
        bench.tick();
        for tick in 0..(first + second) as u32 * 4 {
            let pos = pulses(bench.tick().axes[0].pos);
            let due = (f64::from(tick + 1) / 4.0).min(f64::from(first));
            assert!((pos - due).abs() < 1e-4, "{pos} instead of {due} in tick {tick}");
        }
    }
}
