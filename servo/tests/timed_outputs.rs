//! Outputs that keep a level for a time, and counts of the edges of inputs.
use crate::tick_bench;
use servo::output::TIMED_OUTPUTS;
use servo::segment::follow::Input;
use servo::tick_command::{DoGroup, TickCommand};
use servo::units::Ns;
use servo::view::Event;
use tick_bench::*;

fn for_a_time(bit: u8, high: bool, time: u64) -> TickCommand {
    TickCommand::OutputFor { group: DoGroup::General, bit, high, time: Ns(time) }
}

/// From the tick at which the level is in force, to the nanosecond, also inside a tick.
#[test]
fn an_output_goes_back_after_its_time() {
    for (period_us, time, ticks, inside) in [
        (250, 250_000, 1, 0),
        (250, 1_000_000, 4, 0),
        (50, 250_000, 5, 0),
        (300, 250_000, 0, 250_000),
        (400, 1_000_000, 2, 200_000),
    ] {
        let mut bench = Bench::new(period_us);
        bench.tick();
        for high in [true, false] {
            bench.now(for_a_time(3, high, time));
            bench.machine.edges.clear();
            let mut lasted = 0;
            loop {
                bench.tick();
                let level = bench.machine.outputs.2 >> 3 & 1 == 1;
                let edge = bench.machine.edges.pop();
                if let Some((at, _, _, levels)) = edge {
                    assert_eq!((lasted, at, levels >> 3 & 1 == 1), (ticks, inside, !high), "{period_us} {time}");
                    break;
                }
                if level != high {
                    assert_eq!((lasted, 0), (ticks, inside), "{period_us} {time}");
                    break;
                }
                lasted += 1;
            }
        }
    }
}

/// No time is no pulse: it has the other level at once. What is set otherwise stays, and what gets
/// another time has that one.
#[test]
fn a_later_command_takes_its_place() {
    let mut bench = Bench::new(250);
    bench.tick();
    bench.now(for_a_time(0, true, 0));
    bench.tick();
    assert_eq!(bench.machine.outputs.2, 0);
    bench.now(for_a_time(0, true, 500_000));
    bench.now(for_a_time(1, true, 500_000));
    bench.now(for_a_time(2, true, 500_000));
    bench.tick();
    bench.now(TickCommand::Output { group: DoGroup::General, mask: 1, value: 1 });
    bench.now(for_a_time(1, true, 500_000));
    assert_eq!(bench.tick().general_outputs, 0b111);
    assert_eq!(bench.tick().general_outputs, 0b011);
    assert_eq!(bench.tick().general_outputs, 0b001);
    assert_eq!(bench.ticks(50).general_outputs, 0b001);
}

/// Servo and alarm-clear outputs too; a servo that goes off so stops its axis.
#[test]
fn other_groups_have_times_too() {
    let mut bench = Bench::new(250);
    bench.tick();
    bench.now(TickCommand::OutputFor { group: DoGroup::Enable, bit: 2, high: true, time: Ns(500_000) });
    bench.now(TickCommand::OutputFor { group: DoGroup::Clear, bit: 1, high: true, time: Ns(250_000) });
    let view = bench.tick();
    assert_eq!((view.enable, view.clear), (4, 2));
    let view = bench.tick();
    assert_eq!((view.enable, view.clear), (4, 0));
    let view = bench.tick();
    assert_eq!((view.enable, view.axes[2].status & servo::status::SERVO_ON), (0, 0));
}

#[test]
fn one_more_than_fit_is_refused_and_reported() {
    let mut bench = Bench::new(250);
    bench.tick();
    for bit in 0..TIMED_OUTPUTS as u8 {
        bench.now(for_a_time(bit, true, 100_000_000));
        bench.tick();
    }
    let seq = bench.now(for_a_time(TIMED_OUTPUTS as u8, true, 250_000));
    let before = bench.machine.outputs.2;
    bench.tick();
    assert!(matches!(bench.event(), Some(Event::OutputRefused { seq: of, .. }) if of == seq));
    assert_eq!(bench.machine.outputs.2, before);
    // One that waits gets another time all the same.
    bench.now(for_a_time(3, true, 250_000));
    bench.ticks(3);
    assert_eq!(bench.machine.outputs.2, before & !8);
    assert!(bench.event().is_none());
}

/// Both directions count, of every kind and number, and levels found at power-on do not.
#[test]
fn edges_of_inputs_are_counted() {
    let mut bench = Bench::new(250);
    bench.machine.inputs[1].home = true;
    bench.machine.general = 0b1010;
    bench.ticks(3);
    let all = [Input::LimitPositive, Input::LimitNegative, Input::Alarm, Input::Home, Input::Arrive, Input::General];
    for input in all {
        assert!((0..8).all(|index| bench.edges(input, index) == 0), "{input:?} at power-on");
    }
    for n in 1..=5u32 {
        let high = n % 2 == 1;
        for index in 0..8 {
            let inputs = &mut bench.machine.inputs[index];
            inputs.limit_positive = high;
            inputs.arrive = high;
        }
        bench.machine.inputs[1].home = !high;
        bench.machine.general ^= 1 << 31 | 1;
        bench.ticks(2);
        for index in 0..8 {
            let counts = all.map(|input| bench.edges(input, index));
            let home = if index == 1 { n } else { 0 };
            assert_eq!(counts, [n, 0, 0, home, n, if index == 0 { n } else { 0 }], "axis {index}");
        }
        assert_eq!(bench.edges(Input::General, 31), n);
    }
    // A count goes on from where it is set, also over 2³².
    bench.now(TickCommand::EdgeCount { input: Input::Home, index: 1, count: u32::MAX });
    bench.machine.inputs[1].home = !bench.machine.inputs[1].home;
    bench.ticks(2);
    assert_eq!(bench.edges(Input::Home, 1), u32::MAX, "the edge was sampled before the command");
    bench.machine.inputs[1].home = !bench.machine.inputs[1].home;
    bench.ticks(2);
    assert_eq!(bench.edges(Input::Home, 1), 0);
}
