//! FollowEx: entries that are no segments, at exact instants; their effects, and how many of them
//! in a tick.
use crate::tick_bench;
use servo::segment::follow::{Direction, Input, MasterPosition, Method};
use servo::status;
use servo::tick_command::{DoGroup, MotionMode, TickCommand};
use servo::units::Pos;
use servo::view::StopReason;
use tick_bench::*;

const GENERAL: DoGroup = DoGroup::General;

/// Axis 0 a master, axis 1 its slave with these entries; both start at the tick returned.
fn running(period_us: u32, items: &[Item], velocity: f64) -> Bench {
    let mut bench = Bench::prepared(period_us, MotionMode::FollowEx);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, items);
    bench.now(TickCommand::FollowLoop { axis: axis(1), passes: 1 });
    bench.start_follow(&[1]);
    bench.pt(0, 0, &[(velocity * 10_000.0, 10_000, 1)]);
    bench.start(&[0]);
    bench.tick();
    bench
}

#[test]
fn an_output_does_not_move_the_slave() {
    for (velocity, period) in [(1.0, 250), (1.3, 1000), (0.37, 50)] {
        let items = [
            Item::Output(GENERAL, 3, true),
            Item::Data(10.1, 20.2, 1, 0),
            Item::Output(GENERAL, 7, true),
            Item::Output(GENERAL, 3, false),
            Item::Output(DoGroup::Clear, 2, true),
            Item::Data(20.0, 40.0, 1, 0),
        ];
        let mut bench = running(period, &items, velocity);
        assert_eq!(bench.machine.outputs.2, 8, "the first is reached at the start");
        for _ in 0..15_000 / period {
            let view = bench.tick();
            let x = pulses(view.axes[0].pos);
            let (general, clear) = if x >= 10.1 { (128, 4) } else { (8, 0) };
            assert_eq!((view.general_outputs, view.clear), (general, clear), "at {x}");
            if x < 20.0 {
                assert!((pulses(view.axes[1].pos) - 2.0 * x).abs() < 2e-5, "{} at {x}", pulses(view.axes[1].pos));
            }
        }
    }
}

#[test]
fn a_delay_ends_at_its_exact_instant_whatever_the_tick() {
    // Reached at 10.1/v ms, held for 7 cycles of 0.25 ms: 1.75 ms.
    for (velocity, period) in [(1.0, 1000), (1.3, 250), (0.37, 50), (13.7, 1000)] {
        let items = [Item::Data(10.1, 20.2, 1, 0), Item::Delay(7), Item::Data(30.0, 60.0, 1, 0)];
        let mut bench = running(period, &items, velocity);
        let (resumes, ends) = (10.1 + 1.75 * velocity, 30.0 + 1.75 * velocity);
        for _ in 0..200_000 / period {
            let view = bench.tick();
            let x = pulses(view.axes[0].pos);
            let s = if x < 10.1 {
                2.0 * x
            } else if x < resumes {
                20.2
            } else {
                20.2 + 2.0 * (x.min(ends) - resumes)
            };
            assert!((pulses(view.axes[1].pos) - s).abs() < 3e-5, "{} for {s} at {x}", pulses(view.axes[1].pos));
            assert_eq!(has(&view.axes[1], status::RUNNING), x < ends, "at {x}");
            if x > 10.2 && x < resumes - 0.1 {
                assert_eq!(real(view.motion(&view.axes[1]).velocity()), 0.0);
            }
        }
    }
}

/// Delays that end at the end of a tick end there, and not a rounding later, wherever the master
/// is in between and whichever way it moves.
#[test]
fn delays_that_end_with_a_tick_end_in_it() {
    let mut items = Vec::new();
    for bit in 0..5 {
        items.extend([Item::Delay(1), Item::Delay(7), Item::Output(GENERAL, bit, true)]);
    }
    items.push(Item::Data(1000.0, 1000.0, 1, 0));
    for value in [MasterPosition::Planned, MasterPosition::PlannedFiltered, MasterPosition::EncoderFiltered] {
        for direction in [Direction::Both, Direction::Up, Direction::Down] {
            for velocity in (1..60).flat_map(|n| [f64::from(n) * 0.37, f64::from(n) * -0.0113]) {
                // The way back from the start reaches nothing.
                if direction == Direction::Both && velocity < 0.0 {
                    continue;
                }
                let mut bench = Bench::prepared(1000, MotionMode::FollowEx);
                bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
                bench.now(TickCommand::FollowDirection { axis: axis(1), direction });
                bench.follows(1, 0, value);
                bench.follow(1, 0, &items);
                bench.pt(0, 0, &[(velocity * 10_000.0, 10_000, 1)]);
                bench.start(&[0]);
                // The filter has taken up the speed, not to the last bit.
                for _ in 0..7 {
                    bench.tick();
                }
                bench.start_follow(&[1]);
                for ms in 1..=11u32 {
                    let view = bench.tick();
                    let high = (1 << ((ms - 1) / 2)) - 1;
                    assert_eq!(view.general_outputs, high, "{value:?} {direction:?} {velocity}, {ms} ms");
                }
            }
        }
    }
}

/// A loop with a delay, over a master of two speeds whose knots are no whole pulses: rounding of
/// its position where delays begin and end does not add up.
#[test]
fn delays_in_a_loop_do_not_drift() {
    const DELAY_MS: f64 = 0.25;
    let (length, slave) = (2.3, 4.1);
    // At 10/3 and 47/21 pulse/ms, from the tick at which it starts.
    let [(one, one_ms), (both, both_ms)] = [(70.0 / 3.0, 7.0), (70.0 / 3.0 + 94.0 / 3.0, 21.0)];
    let position = |ms: f64| {
        let (pass, ms) = ((ms / both_ms).floor(), ms.rem_euclid(both_ms));
        let within =
            if ms < one_ms { one * ms / one_ms } else { one + (both - one) * (ms - one_ms) / (both_ms - one_ms) };
        pass * both + within
    };
    let instant = |x: f64| {
        let (pass, x) = ((x / both).floor(), x.rem_euclid(both));
        let within = if x < one { x / one * one_ms } else { one_ms + (x - one) / (both - one) * (both_ms - one_ms) };
        pass * both_ms + within
    };
    let mut bench = Bench::prepared(250, MotionMode::FollowEx);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(length, slave, 1, 0), Item::Delay(1)]);
    bench.now(TickCommand::FollowLoop { axis: axis(1), passes: 0 });
    bench.now(TickCommand::PtLoop { axis: axis(0), passes: 0 });
    bench.start_follow(&[1]);
    bench.pt(0, 0, &[(one, 7, 1), (both, 21, 1)]);
    bench.start(&[0]);
    bench.tick();
    let (mut pass, mut began, mut worst) = (0.0, 0.0, 0.0f64);
    for tick in 1..=40_000 {
        let view = bench.tick();
        let x = position(f64::from(tick) * 0.25);
        loop {
            let next = position(instant(began + length) + DELAY_MS);
            if x < next {
                break;
            }
            (pass, began) = (pass + 1.0, next);
        }
        let s = slave * (pass + ((x - began) / length).min(1.0));
        worst = worst.max((pulses(view.axes[1].pos) - s).abs());
    }
    assert!(pass > 5000.0, "{pass} passes");
    // The master's position, where the segment began and where it is, and the slave's own.
    assert!(worst < 2f64.powi(-20), "{worst}");
}

#[test]
fn a_delay_on_a_curve_of_the_master() {
    // The master accelerates: x = t²/4096 pulses, t in ms; reached at t = 64·√10.1.
    let mut bench = Bench::prepared(1000, MotionMode::FollowEx);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(10.1, 10.1, 1, 0), Item::Delay(9), Item::Data(500.0, 499.9, 1, 0)]);
    bench.start_follow(&[1]);
    bench.pt(0, 0, &[(4096.0, 4096, 0)]);
    bench.start(&[0]);
    let mut checked = 0;
    for _ in 0..1200 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        let instant = (10.1f64 * 4096.0).sqrt() + 2.25;
        let origin = instant * instant / 4096.0;
        if x > origin && x < 400.0 {
            let s = 10.1 + (x - origin) * (489.8 / 489.9);
            assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s}", pulses(view.axes[1].pos));
            checked += 1;
        }
    }
    assert!(checked > 900);
}

/// A master comes to rest in a tick in which a piece of its motion begins and ends: where a delay
/// ends after that begin, the path counts as straight up to the tick. It counted as over.
#[test]
fn a_delay_that_ends_while_its_master_brakes_within_the_tick() {
    let mut between = 0;
    for cycles in 13..=20 {
        let mut bench = Bench::prepared(1000, MotionMode::FollowEx);
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Trap });
        bench.follows(1, 0, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Delay(cycles), Item::Data(100.0, 50.0, 1, 0)]);
        let (acc, dec, zero) = (0.775, 4.4, speed(0.0));
        let prm = TickCommand::TrapPrm {
            axis: axis(0),
            acc: accel(acc),
            dec: accel(dec),
            vel_start: zero,
            smooth: servo::units::Ns(0),
        };
        bench.now(prm);
        bench.now(TickCommand::TargetSpeed { axis: axis(0), speed: speed(99.0) });
        bench.now(TickCommand::TargetPosition { axis: axis(0), pulses: 8 });
        bench.start_follow(&[1]);
        bench.now(TickCommand::Update { axes: all(&[0]) });
        let peak = (8.0 / (0.5 / acc + 0.5 / dec)).sqrt();
        let (brakes, rests) = (peak / acc, peak / acc + peak / dec);
        assert!(brakes > 4.0 && rests < 5.0);
        let ends = cycles as f64 / 4.0;
        let master = if ends < brakes {
            acc * ends * ends / 2.0
        } else {
            let at = acc * brakes * brakes / 2.0;
            at + (8.0 - at) * (ends - brakes) / (5.0 - brakes)
        };
        between += u32::from(ends > brakes && ends < 5.0);
        let view = bench.ticks(12);
        assert_eq!(view.axes[0].pos, Pos::pulses(8));
        let (slave, due) = (pulses(view.axes[1].pos), 0.5 * (8.0 - master));
        assert!((slave - due).abs() < 2e-5, "{cycles} cycles: {slave} for {due}");
    }
    assert_eq!(between, 3);
}

#[test]
fn a_wait_goes_on_with_the_sample_that_ends_it() {
    let items = [
        Item::Data(10.0, 10.0, 1, 0),
        Item::Wait(Input::General, 5, true, 0),
        Item::Data(20.1, 20.1, 1, 0),
        Item::Wait(Input::Home, 1, true, 0),
        Item::Data(30.0, 30.0, 1, 0),
    ];
    let mut bench = running(250, &items, 1.0);
    bench.machine.general = 0;
    let view = bench.ticks(4 * 15);
    assert_eq!(view.axes[1].pos, Pos::pulses(10));
    assert!(has(&view.axes[1], status::RUNNING));
    bench.machine.general = 32;
    // Sampled at the tick in force, where the master is at `origin`.
    let origin = pulses(view.axes[0].pos);
    let view = bench.tick();
    assert!((pulses(view.axes[1].pos) - 10.0 - 0.25).abs() < 1e-5);
    let view = bench.ticks(4 * 5);
    let x = pulses(view.axes[0].pos);
    assert!((pulses(view.axes[1].pos) - 10.0 - (x - origin)).abs() < 1e-5);
    // Home is there already when the wait is reached: it holds nothing.
    bench.machine.inputs[1].home = true;
    bench.ticks(4 * 10);
    let view = bench.tick();
    let x = pulses(view.axes[0].pos);
    assert!((pulses(view.axes[1].pos) - 10.0 - (x - origin)).abs() < 1e-5);
}

#[test]
fn a_wait_that_times_out_ends_the_motion() {
    let items = [Item::Data(10.0, 10.0, 1, 0), Item::Wait(Input::General, 7, true, 5), Item::Data(20.0, 20.0, 1, 0)];
    let mut bench = running(250, &items, 1.0);
    bench.machine.general = 0;
    loop {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        assert_eq!(has(&view.axes[1], status::RUNNING), x < 15.0, "at {x}");
        if x >= 15.0 {
            assert_eq!((view.axes[1].stop, view.axes[1].pos), (StopReason::WaitTimeout, Pos::pulses(10)));
            assert_eq!(stopped(bench.event()), (1, StopReason::WaitTimeout));
            break;
        }
    }
}

#[test]
fn eight_entries_a_tick_then_it_holds() {
    let mut items = vec![Item::Data(10.0, 10.0, 1, 0)];
    items.extend((0..16).map(|bit| Item::Output(GENERAL, bit, true)));
    items.push(Item::Data(20.0, 20.0, 1, 0));
    let mut bench = running(1000, &items, 4.0);
    let mut held = 0;
    for _ in 0..4 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        if x < 10.0 {
            assert_eq!(view.general_outputs, 0);
        } else if view.general_outputs == 0xff {
            // Four outputs a ms would have been 12; the slave is held at the knot.
            assert_eq!((x, pulses(view.axes[1].pos)), (12.0, 10.0));
            held += 1;
        } else {
            assert_eq!(view.general_outputs, 0xffff);
            assert!((pulses(view.axes[1].pos) - x).abs() < 1e-5);
        }
    }
    assert_eq!(held, 1);
}

#[test]
fn a_queued_switch_goes_to_the_other_fifo() {
    let items = [Item::Data(10.0, 5.0, 0, 0), Item::Switch(Method::Table), Item::Data(20.0, 1000.0, 0, 0)];
    let mut bench = running(250, &items, 1.0);
    bench.follow(1, 1, &[Item::Switch(Method::Segment), Item::Data(10.0, 5.0, 0, 100), Item::Data(20.0, 20.0, 0, 0)]);
    for _ in 0..4 * 30 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        let s = if x < 10.0 {
            x * x / 20.0
        } else if x < 20.0 {
            // Ratio 1 to 0 as a pure S: position a·τ + top·τ³/(6k), top = 2(P − a)·2, k = 1/2.
            let tau = (x - 10.0) / 10.0;
            let (a, top) = (10.0, -20.0);
            let first = |tau: f64| a * tau + top * tau * tau * tau / 3.0;
            // Point symmetric: the ratio ends at 0, so from the end it is the fall of the same
            // slope.
            5.0 + if tau < 0.5 { first(tau) } else { 5.0 + top * (1.0 - tau).powi(3) / 3.0 }
        } else {
            10.0 + 15.0 * (x - 20.0) * (x - 20.0) / 100.0
        };
        if x < 30.0 {
            assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s} at {x}", pulses(view.axes[1].pos));
        }
        assert_eq!(view.axes[1].fifo, (x >= 10.0) as u8);
        assert_eq!(view.axes[1].cleared, [(x >= 10.0) as u32, 0]);
    }
    assert_eq!(bench.tick().axes[1].stop, StopReason::Completed);
}

#[test]
fn after_a_delay_the_ratio_of_the_instant_is_0() {
    for (cycles, ratio) in [(0, 2.0), (4, 0.0)] {
        let mut bench =
            running(250, &[Item::Data(10.0, 20.0, 1, 0), Item::Delay(cycles), Item::Switch(Method::Table)], 1.0);
        bench.follow(1, 1, &[Item::Data(10.0, 30.0, 0, 0)]);
        let origin = 10.0 + cycles as f64 / 4.0;
        let view = bench.ticks(4 * 16);
        let tau = (pulses(view.axes[0].pos) - origin) / 10.0;
        let s = 20.0 + ratio * 10.0 * tau + (30.0 - ratio * 10.0) * tau * tau;
        assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s}", pulses(view.axes[1].pos));
    }
}

#[test]
fn the_way_back_ends_at_an_entry() {
    let items = [Item::Data(10.0, 10.0, 1, 0), Item::Output(GENERAL, 0, true), Item::Data(20.0, 20.0, 1, 0)];
    let mut bench = Bench::prepared(250, MotionMode::FollowEx);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &items);
    bench.start_follow(&[1]);
    bench.pt(0, 0, &[(15.0, 15, 1), (-5.0, 35, 1), (15.0, 55, 1), (15.5, 56, 1)]);
    bench.start(&[0]);
    let mut switched = 0;
    for tick in 0..4 * 55 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        let expected = if tick > 45 { x.max(10.0) } else { x };
        assert!((pulses(view.axes[1].pos) - expected).abs() < 1e-5, "{} at {x}", pulses(view.axes[1].pos));
        switched += (view.general_outputs == 1) as u32;
        if tick == 100 {
            bench.now(TickCommand::Output { group: GENERAL, mask: 1, value: 0 });
        }
    }
    // Not again on the second way up.
    assert!(switched < 70, "{switched}");
}

#[test]
fn every_pass_executes_its_entries() {
    let items = [
        Item::Data(3.3, 1.0, 0, 0),
        Item::Output(GENERAL, 0, true),
        Item::Data(6.6, 2.0, 2, 0),
        Item::Output(GENERAL, 0, false),
        Item::Delay(3),
    ];
    let mut bench = running(50, &items, 1.0);
    bench.now(TickCommand::FollowLoop { axis: axis(1), passes: 0 });
    let (mut rises, mut before) = (0, 0);
    for _ in 0..20 * 100 {
        let view = bench.tick();
        rises += (view.general_outputs > before) as u32;
        before = view.general_outputs;
    }
    // A pass takes 6.6 + 0.75 ms: the rise of pass n is at 7.35·n + 3.3.
    let view = bench.tick();
    assert_eq!(rises, 1 + ((100.0 - 3.3) / 7.35) as u32);
    assert_eq!(view.axes[1].passes, (100.05 / 7.35) as u32);
}

#[test]
fn a_servo_switched_by_an_entry_stops_its_axis() {
    let items = [Item::Data(10.0, 10.0, 1, 0), Item::Output(DoGroup::Enable, 2, false), Item::Data(20.0, 20.0, 1, 0)];
    let mut bench = running(250, &items, 1.0);
    bench.now(TickCommand::SetMode { axis: axis(2), mode: MotionMode::Jog });
    bench.jog(2, 1.0, 1000.0);
    let view = bench.ticks(4 * 12);
    assert_eq!((view.axes[2].stop, view.enable), (StopReason::ServoOff, 0xff & !4));
    assert!(!has(&view.axes[2], status::SERVO_ON) && has(&view.axes[1], status::RUNNING));
}

#[test]
fn added_data_belongs_to_the_present_pass() {
    let mut bench = Bench::prepared(250, MotionMode::FollowEx);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::Jog });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 1, 0)]);
    bench.now(TickCommand::FollowLoop { axis: axis(1), passes: 3 });
    bench.start_follow(&[1]);
    bench.jog(0, 1.0, 1000.0);
    bench.ticks(4 * 15);
    // In the second pass, which ended at 20 and now ends at 25.
    bench.follow(1, 0, &[Item::Data(15.0, 20.0, 1, 0)]);
    for _ in 0..4 * 25 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        let s = if x < 20.0 {
            x
        } else if x < 25.0 {
            20.0 + 2.0 * (x - 20.0)
        } else if x < 35.0 {
            x + 5.0
        } else {
            (40.0 + 2.0 * (x - 35.0)).min(50.0)
        };
        assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s} at {x}", pulses(view.axes[1].pos));
    }
    let view = bench.ticks(2);
    assert_eq!((view.axes[1].stop, view.axes[1].passes), (StopReason::Completed, 3));
}

#[test]
fn the_way_back_ends_where_data_was_added() {
    let mut bench = Bench::prepared(250, MotionMode::FollowEx);
    bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
    bench.follows(1, 0, MasterPosition::Planned);
    bench.follow(1, 0, &[Item::Data(10.0, 10.0, 1, 0)]);
    bench.now(TickCommand::FollowLoop { axis: axis(1), passes: 0 });
    bench.start_follow(&[1]);
    bench.pt(0, 0, &[(24.0, 24, 1), (2.0, 46, 1)]);
    bench.start(&[0]);
    bench.ticks(4 * 15);
    bench.follow(1, 0, &[Item::Data(15.0, 20.0, 1, 0)]);
    let mut lowest = 100.0f64;
    for tick in 0..4 * 29 {
        let view = bench.tick();
        let x = pulses(view.axes[0].pos);
        let s = if x < 20.0 { x.max(10.0) } else { 20.0 + 2.0 * (x - 20.0) };
        assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s} at {x}", pulses(view.axes[1].pos));
        if tick > 40 {
            lowest = lowest.min(x);
        }
    }
    assert!(lowest < 5.0);
}

#[test]
fn down_counts_downwards_and_up_does_not() {
    for (direction, sign) in [(Direction::Down, 1.0), (Direction::Both, -1.0), (Direction::Down, -1.0)] {
        let mut bench = Bench::prepared(250, MotionMode::FollowEx);
        bench.now(TickCommand::FollowDirection { axis: axis(1), direction });
        bench.now(TickCommand::SetMode { axis: axis(0), mode: MotionMode::PtStatic });
        bench.follows(1, 0, MasterPosition::Planned);
        bench.follow(1, 0, &[Item::Data(sign * 10.0, 20.0, 1, 0), Item::Data(sign * 20.0, 50.0, 1, 0)]);
        bench.start_follow(&[1]);
        bench.pt(0, 0, &[(5.0, 5, 1), (-12.0, 22, 1), (-8.0, 26, 1), (-25.0, 43, 1)]);
        bench.start(&[0]);
        let mut furthest = 0.0f64;
        for _ in 0..4 * 40 {
            let view = bench.tick();
            let progress = -pulses(view.axes[0].pos);
            furthest = furthest.max(progress);
            let x = if direction == Direction::Both { progress.max(0.0) } else { furthest };
            let s = if x < 10.0 { 2.0 * x } else { (20.0 + 3.0 * (x - 10.0)).min(50.0) };
            assert!((pulses(view.axes[1].pos) - s).abs() < 2e-5, "{} for {s} at {x}", pulses(view.axes[1].pos));
            if progress == x && s > 0.0 && s < 50.0 && x != 12.0 {
                let ratio = real(view.motion(&view.axes[1]).velocity()) / real(view.motion(&view.axes[0]).velocity());
                let expected = if x < 10.0 { -2.0 } else { -3.0 };
                assert!((ratio - expected).abs() < 1e-9, "{ratio} at {x}");
            }
        }
    }
}

#[test]
fn switch_now_breaks_a_wait() {
    let items = [Item::Data(10.0, 10.0, 1, 0), Item::Wait(Input::General, 7, true, 0), Item::Data(20.0, 20.0, 1, 0)];
    let mut bench = running(250, &items, 1.0);
    bench.machine.general = 0;
    bench.ticks(4 * 15);
    bench.now(TickCommand::FollowSwitchNow { axis: axis(1), method: Method::Segment });
    let view = bench.tick();
    let origin = pulses(view.axes[0].pos);
    let view = bench.ticks(4 * 4);
    let x = pulses(view.axes[0].pos);
    assert!((pulses(view.axes[1].pos) - 10.0 - (x - origin)).abs() < 1e-5);
}
