//! The work of an instant: spread over ticks, never a start apart from its neighbours.
use crate::tick_bench;
use servo::status::*;
use servo::tick_command::{DoGroup, MotionMode, TickCommand};
use servo::units::{Ns, Pos};
use servo::view::View;
use tick_bench::*;

const US: u64 = 1000;

fn output(bit: u32) -> TickCommand {
    TickCommand::Output { group: DoGroup::General, mask: 1 << bit, value: 1 << bit }
}

fn running(view: &View<AXES>) -> usize {
    view.axes.iter().filter(|axis| has(axis, RUNNING)).count()
}

/// Trap set up, acceleration 1, speed 5, target 1000.
fn trap(bench: &mut Bench, index: usize) {
    bench.then(0, TickCommand::SetMode { axis: axis(index), mode: MotionMode::Trap });
    bench.then(
        0,
        TickCommand::TrapPrm {
            axis: axis(index),
            acc: accel(1.0),
            dec: accel(1.0),
            vel_start: speed(0.0),
            smooth: Ns(0),
        },
    );
    bench.then(0, TickCommand::TargetSpeed { axis: axis(index), speed: speed(5.0) });
    bench.then(0, TickCommand::TargetPosition { axis: axis(index), pulses: 1000 });
}

#[test]
fn a_reset_takes_the_ticks_that_it_needs_and_what_follows_waits_for_it() {
    for (period, ticks) in [(10, 8), (20, 3), (50, 1), (250, 1)] {
        let mut bench = Bench::prepared(period, MotionMode::Jog);
        for index in 0..AXES {
            bench.now(TickCommand::SetPosition { axis: axis(index), pos: Pos::pulses(7) });
        }
        bench.ticks(4);
        let reset = bench.then(0, TickCommand::Reset { axes: all(&[0, 1, 2, 3, 4, 5, 6, 7]) });
        bench.then(0, output(0));
        bench.then(0, output(1));
        bench.now(TickCommand::ProgramRun);
        for tick in 1..=ticks {
            let view = bench.tick();
            assert_eq!(view.enable, 0, "the servos are off from its first tick on");
            let left = view
                .axes
                .iter()
                .filter(|axis| axis.mode == MotionMode::Jog || has(axis, SERVO_ON) || axis.pos != Pos(0));
            let left = left.count();
            assert_eq!(left == 0, tick == ticks, "{period} µs, tick {tick}: {left} axes left");
            assert_eq!(view.done_program >= reset, tick == ticks, "it is reported when it is done");
            assert_eq!(view.general_outputs, if tick == ticks { 3 } else { 0 });
        }
        let view = bench.ticks(3);
        assert_eq!((view.late, view.worst_late, view.first_late), (0, Ns(0), 0), "{period} µs");
    }
}

#[test]
fn a_reset_by_the_immediate_lane_keeps_its_order_too() {
    let mut bench = Bench::prepared(10, MotionMode::Jog);
    let reset = bench.now(TickCommand::Reset { axes: all(&[0, 1, 2, 3, 4, 5, 6, 7]) });
    bench.now(output(0));
    let done: Vec<(bool, u64)> =
        (0..9).map(|_| bench.tick()).map(|view| (view.done_immediate >= reset, view.general_outputs)).collect();
    assert_eq!((&done[..7], &done[7..]), (&[(false, 0); 7][..], &[(true, 1); 2][..]));
}

#[test]
fn a_reset_that_has_begun_is_carried_out_whole_where_its_program_is_dropped() {
    let mut bench = Bench::prepared(10, MotionMode::Jog);
    let reset = bench.then(0, TickCommand::Reset { axes: all(&[0, 1, 2, 3, 4, 5, 6, 7]) });
    bench.then(0, output(0));
    bench.now(TickCommand::ProgramRun);
    assert!(bench.tick().done_program < reset);
    bench.now(TickCommand::ProgramDrop);
    bench.now(output(1));
    let view = bench.ticks(10);
    assert!(view.axes.iter().all(|axis| axis.mode == MotionMode::Trap), "no axis is left out");
    assert_eq!((view.done_program, view.program_runs), (reset, false));
    assert_eq!(view.general_outputs, 2, "what followed was dropped");
}

#[test]
fn starts_and_outputs_of_one_instant_begin_in_one_tick() {
    for period in [10, 20, 25, 50, 100, 250] {
        let mut bench = Bench::new(period);
        bench.now(TickCommand::Output { group: DoGroup::Enable, mask: 0xff, value: 0xff });
        bench.tick();
        for index in 0..AXES {
            trap(&mut bench, index);
        }
        for n in 0..63 {
            bench.then(0, output(n % 31));
        }
        bench.then(0, TickCommand::Update { axes: all(&[0]) });
        bench.then(0, TickCommand::Update { axes: all(&[1, 3, 4, 5, 6, 7]) });
        let last = bench.then(0, output(31));
        bench.now(TickCommand::ProgramRun);
        let view = loop {
            let view = bench.tick();
            assert!(view.tick < 64, "{period} µs: it never begins");
            if view.done_program >= last || view.general_outputs != 0 || running(&view) != 0 {
                break view;
            }
        };
        assert_eq!((view.general_outputs, running(&view), view.done_program), (0xffff_ffff, 7, last), "{period} µs");
        assert_eq!((bench.tick().late, view.first_late), (0, 0), "{period} µs: what was spread is not late");
        // All are as far, to the bit, tick after tick.
        for _ in 0..50 {
            let view = bench.tick();
            let of = |index: usize| view.axes[index].pos;
            assert!(of(0) > Pos(0));
            for index in [1, 3, 4, 5, 6, 7] {
                assert_eq!(of(index), of(0), "{period} µs");
            }
        }
    }
}

#[test]
fn set_up_that_fits_does_not_put_off_its_start() {
    // Eight axes at 100 µs: all of it is the work of the first tick.
    let mut bench = Bench::new(100);
    bench.now(TickCommand::Output { group: DoGroup::Enable, mask: 0xff, value: 0xff });
    bench.tick();
    for index in 0..AXES {
        trap(&mut bench, index);
    }
    bench.then(0, TickCommand::Update { axes: all(&[0, 1, 2, 3, 4, 5, 6, 7]) });
    bench.now(TickCommand::ProgramRun);
    assert_eq!(running(&bench.tick()), 8);
}

#[test]
fn an_instant_that_another_keeps_waiting_is_late_by_its_own_account() {
    let mut bench = Bench::prepared(10, MotionMode::Trap);
    for _ in 0..60 {
        bench.then(0, TickCommand::Mark);
    }
    bench.then(US, output(0));
    let next = bench.then(12 * US, output(1));
    bench.now(TickCommand::ProgramRun);
    let mut acted = vec![];
    let view = loop {
        let view = bench.tick();
        acted.push(view.general_outputs);
        if view.done_program == next {
            break view;
        }
    };
    // 60 marks are seven ticks; the instants 1 and 13 µs would have been those of the first and the
    // second.
    assert_eq!(acted, [0, 0, 0, 0, 0, 0, 3]);
    assert_eq!((view.late, view.first_late, view.worst_late), (2, 61, Ns(59 * US)));
}

#[test]
fn the_entry_after_which_a_tick_took_too_long_is_named_once_for_each_program() {
    let mut bench = Bench::prepared(250, MotionMode::Trap);
    bench.tick.overrun();
    assert_eq!(bench.tick().overran, 0, "no program ran");
    bench.then(0, output(0));
    let second = bench.then(MS, output(1));
    bench.then(MS, output(2));
    bench.now(TickCommand::ProgramRun);
    let zero = bench.tick().script_zero.0;
    bench.until(zero + MS + 250 * US);
    bench.tick.overrun();
    bench.until(zero + 3 * MS);
    bench.tick.overrun();
    let view = bench.tick();
    assert_eq!((view.overran, view.overruns), (second, 3));
    bench.now(TickCommand::ProgramDrop);
    bench.now(TickCommand::ProgramRun);
    assert_eq!(bench.tick().overran, 0);
}

#[test]
fn a_late_command_of_a_laser_is_kept_apart() {
    use servo::laser::ChannelChange;
    for light in [false, true] {
        let mut bench = Bench::prepared(250, MotionMode::Trap);
        bench.now(TickCommand::ProgramRun);
        bench.ticks(9);
        let command =
            if light { TickCommand::Laser { channel: 0, change: ChannelChange::Gate { on: true } } } else { output(0) };
        let first = bench.then(MS, command);
        bench.then(0, output(1));
        let view = bench.tick();
        assert_eq!((view.late, view.first_late, view.late_light), (2, first, light));
    }
}
