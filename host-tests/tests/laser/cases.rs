//! The rules of SPEC 6, each as a small job with its outputs worked out by hand. Times are µs.
use host_tests::laser_model::{Command, Exact, Family, Fpk, Mode, Ns};

/// A rule.
pub struct Case {
    pub name: &'static str,
    pub family: Family,
    pub job: Vec<(Ns, Command)>,
    /// Active times of the switch output, µs; those that do not end end at the horizon.
    pub switch: Vec<(i64, i64)>,
    /// Active times of the energy output, µs.
    pub energy: Vec<(i64, i64)>,
    /// Levels of the analog output in mV, from an instant on, µs.
    pub analog: Vec<(i64, i64)>,
    /// Light, µs.
    pub light: Vec<(i64, i64)>,
}

/// End of every case, µs.
pub const CASE_END_US: i64 = 3000;

pub fn number(value: i128) -> Exact {
    Exact::from_integer(value)
}

pub fn mode(mode: Mode, max: i128) -> Command {
    Command::PowerMode { mode, max: number(max), min: number(0), delayed: true }
}
pub fn power(value: i128) -> Command {
    Command::Power(number(value))
}
pub fn carrier(khz: i128) -> Command {
    Command::Carrier(number(khz))
}
pub fn width(us: i64) -> Command {
    Command::Width(us * 1000)
}
pub fn delays(off: i64, on: i64) -> Command {
    Command::Delays { off: off * 1000, on: on * 1000 }
}
pub fn fpk(time1: i64, time2: i64, off: i64) -> Command {
    Command::Fpk(Some(Fpk { time1: time1 * 1000, time2: time2 * 1000, off: off * 1000 }))
}
pub fn standby(khz: i128, percent: i128) -> Command {
    Command::Standby(Some((number(khz), number(percent))))
}
pub const ON: Command = Command::Gate(true);
pub const OFF: Command = Command::Gate(false);

/// A 10 kHz carrier at 25 %.
fn duty(job: &[(i64, Command)]) -> Vec<(Ns, Command)> {
    let set = [(50, mode(Mode::Duty, 100)), (50, carrier(10)), (50, power(25))];
    set.iter().chain(job).map(|(us, command)| (us * 1000, command.clone())).collect()
}

/// Pulses of 25 µs every 100 µs that begin in this time.
fn train(begin: i64, end: i64) -> Vec<(i64, i64)> {
    (begin..end).step_by(100).map(|at| (at, at + 25)).collect()
}

fn joined(parts: &[Vec<(i64, i64)>]) -> Vec<(i64, i64)> {
    parts.concat()
}

fn case(name: &'static str, job: Vec<(Ns, Command)>) -> Case {
    let nothing = Vec::new;
    Case { name, family: Family::Gus, job, switch: nothing(), energy: nothing(), analog: nothing(), light: nothing() }
}

/// All of them; every name is unique and is what docs/laser.md cites.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![
        Case {
            switch: vec![(100, 400)],
            light: vec![(100, 400)],
            energy: train(100, 400),
            ..case("pulses_begin_with_the_gate", duty(&[(100, ON), (400, OFF)]))
        },
        Case {
            switch: vec![(130, 480)],
            light: vec![(130, 480)],
            energy: train(130, 480),
            ..case("delays_shift_the_edges", duty(&[(50, delays(80, 30)), (100, ON), (400, OFF)]))
        },
        case(
            "a_mark_shorter_than_the_delay_difference_makes_no_light",
            duty(&[(50, delays(20, 100)), (100, ON), (150, OFF)]),
        ),
        Case {
            switch: vec![(110, 150)],
            light: vec![(110, 150)],
            energy: vec![(110, 135)],
            ..case(
                "with_the_off_delay_longer_a_mark_of_no_length_makes_light",
                duty(&[(50, delays(50, 10)), (100, ON), (100, OFF)]),
            )
        },
        Case {
            switch: vec![(100, 900)],
            light: vec![(100, 900)],
            energy: train(100, 900),
            ..case(
                "an_on_cancels_a_pending_off",
                duty(&[(50, delays(100, 0)), (100, ON), (400, OFF), (450, ON), (800, OFF)]),
            )
        },
        Case {
            switch: vec![(200, 400)],
            light: vec![(200, 400)],
            energy: train(200, 400),
            ..case(
                "the_delays_in_force_at_the_command_count",
                duty(&[(50, delays(0, 100)), (100, ON), (150, delays(0, 0)), (400, OFF)]),
            )
        },
        Case {
            switch: vec![(150, 400)],
            light: vec![(150, 400)],
            energy: train(150, 400),
            ..case(
                "a_later_command_with_an_earlier_effect_wins",
                duty(&[(50, delays(0, 900)), (100, ON), (150, delays(0, 0)), (150, ON), (400, OFF)]),
            )
        },
        Case {
            switch: vec![(100, 310)],
            light: vec![(100, 310)],
            energy: train(100, 310),
            ..case("the_last_pulse_is_finished", duty(&[(50, delays(10, 0)), (100, ON), (300, OFF)]))
        },
        Case {
            family: Family::Lsr,
            switch: vec![(100, 400)],
            light: vec![(100, 400)],
            energy: train(100, 400),
            ..case("lsr_has_no_delays_unless_asked", {
                let mut job = duty(&[(50, delays(70, 30)), (100, ON), (400, OFF)]);
                job[0].1 = Command::PowerMode { mode: Mode::Duty, max: number(100), min: number(0), delayed: false };
                job
            })
        },
        Case {
            family: Family::Lsr,
            switch: vec![(130, 470)],
            light: vec![(130, 470)],
            energy: train(130, 470),
            ..case("lsr_has_delays_where_asked", duty(&[(50, delays(70, 30)), (100, ON), (400, OFF)]))
        },
        Case {
            switch: vec![(100, 300), (500, 700)],
            energy: train(100, 300),
            light: vec![(100, 300), (500, 700)],
            ..case("power_0_is_light_without_pulses", {
                duty(&[(100, ON), (300, OFF), (400, power(0)), (500, ON), (700, OFF)])
            })
        },
        Case {
            switch: vec![(100, 300)],
            light: vec![(100, 300)],
            energy: vec![(100, 110), (200, 210)],
            ..case("the_lower_bound_holds_the_power_up", {
                let low = Command::PowerMode { mode: Mode::Duty, max: number(100), min: number(10), delayed: true };
                duty(&[(50, low), (50, power(0)), (100, ON), (300, OFF)])
            })
        },
        Case {
            switch: vec![(100, 500)],
            light: vec![(100, 500)],
            energy: vec![(100, 125), (200, 225), (300, 350), (400, 450)],
            ..case("power_changes_at_a_period_of_the_carrier", duty(&[(100, ON), (250, power(50)), (500, OFF)]))
        },
        Case {
            switch: vec![(100, 500)],
            light: vec![(100, 500)],
            // The period that began at 200 ends at 250, where 50 kHz is asked for: 20 µs would have
            // ended before.
            energy: joined(&[train(100, 300), (250..500).step_by(20).map(|at| (at, at + 5)).collect()]),
            ..case(
                "a_quicker_carrier_does_not_wait_for_a_slow_period",
                duty(&[(100, ON), (250, carrier(50)), (500, OFF)]),
            )
        },
        Case {
            switch: vec![(100, 900)],
            light: vec![(100, 900)],
            energy: vec![(100, 125), (200, 225), (300, 350), (500, 550), (700, 750)],
            ..case("a_slower_carrier_begins_at_the_next_period", duty(&[(100, ON), (250, carrier(5)), (900, OFF)]))
        },
    ];
    cases.extend(last_pulse());
    cases.extend(first_pulse_killer());
    cases.extend(standby_and_modes());
    cases
}

/// 1 kHz and 50 %: pulses of 500 µs.
fn slow(off: i64) -> Vec<(Ns, Command)> {
    duty(&[(50, carrier(1)), (50, power(50)), (100, ON), (off, OFF)])
}

fn last_pulse() -> Vec<Case> {
    let light = |off| vec![(100, off)];
    vec![
        Case {
            switch: light(450),
            light: light(450),
            energy: vec![(100, 450)],
            ..case("a_last_pulse_of_more_than_100_us_more_is_cut", slow(450))
        },
        Case {
            switch: light(500),
            light: light(500),
            energy: vec![(100, 600)],
            ..case("a_last_pulse_of_100_us_more_is_finished", slow(500))
        },
        Case {
            switch: vec![(100, 500), (550, 650)],
            light: vec![(100, 500), (550, 650)],
            energy: vec![(100, 650)],
            ..case("light_that_begins_ends_the_pulse_before", {
                let mut job = slow(500);
                job.extend([(550_000, ON), (600_000, delays(50, 0)), (600_000, power(10)), (600_000, OFF)]);
                job
            })
        },
        Case {
            switch: vec![(50, CASE_END_US)],
            light: vec![(100, 500)],
            energy: vec![(100, 500)],
            ..case("mode_3_cuts_the_last_pulse_and_holds_the_switch", {
                let mut job = slow(500);
                job[0].1 = mode(Mode::Open, 100);
                job.insert(1, (50_000, carrier(10)));
                job.insert(2, (50_000, power(25)));
                job
            })
        },
        Case {
            family: Family::Lsr,
            switch: light(500),
            light: light(500),
            energy: vec![(100, 600)],
            ..case("mode_3_of_lsr_is_mode_0", {
                let mut job = slow(500);
                job[0].1 = mode(Mode::Open, 100);
                job
            })
        },
        Case {
            switch: light(400),
            light: light(400),
            energy: vec![(100, 110), (150, 160), (200, 210), (250, 260), (300, 310), (350, 360)],
            ..case("frequency_mode_has_a_fixed_width", {
                duty(&[(50, mode(Mode::Frequency, 1000)), (50, width(10)), (50, power(20)), (100, ON), (400, OFF)])
            })
        },
        // 20 kHz for 30 µs are 0.6 of a pulse: at 10 kHz the rest takes 40 µs.
        Case {
            switch: light(400),
            light: light(400),
            energy: vec![(100, 110), (170, 180), (270, 280), (370, 380)],
            ..case("a_slower_rate_keeps_its_phase", {
                let set = [(50, mode(Mode::Frequency, 1000)), (50, width(10)), (50, power(20)), (100, ON)];
                duty(&[&set[..], &[(130, power(10)), (400, OFF)]].concat())
            })
        },
        // 10 kHz for 30 µs are 0.3 of a pulse: at 50 kHz the rest takes 14 µs.
        Case {
            switch: light(200),
            light: light(200),
            energy: vec![(100, 105), (144, 149), (164, 169), (184, 189)],
            ..case("a_quicker_rate_keeps_its_phase", {
                let set = [(50, mode(Mode::Frequency, 1000)), (50, width(5)), (50, power(10)), (100, ON)];
                duty(&[&set[..], &[(130, power(50)), (200, OFF)]].concat())
            })
        },
        // 0.3 of a pulse, then nothing for 200 µs, then 0.7 at 20 kHz: 35 µs.
        Case {
            switch: light(430),
            light: light(430),
            energy: vec![(100, 110), (365, 375), (415, 425)],
            ..case("a_rate_of_0_holds_the_phase", {
                let set = [(50, mode(Mode::Frequency, 1000)), (50, width(10)), (50, power(10)), (100, ON)];
                duty(&[&set[..], &[(130, power(0)), (330, power(20)), (430, OFF)]].concat())
            })
        },
        // The first pulse comes with the first rate.
        Case {
            switch: light(400),
            light: light(400),
            energy: vec![(250, 260), (300, 310), (350, 360)],
            ..case("the_first_pulse_begins_with_the_first_rate", {
                let set = [(50, mode(Mode::Frequency, 1000)), (50, width(10)), (100, ON)];
                duty(&[&set[..], &[(250, power(20)), (400, OFF)]].concat())
            })
        },
        // A level is no pulse that could be finished.
        Case {
            switch: light(250),
            light: light(250),
            energy: light(250),
            ..case("full_duty_ends_with_the_gate", duty(&[(60, power(100)), (100, ON), (250, OFF)]))
        },
        Case {
            switch: light(250),
            light: light(250),
            energy: light(250),
            ..case("full_duty_ends_with_the_gate_that_ends_with_its_power", {
                duty(&[(60, power(100)), (100, ON), (250, power(0)), (250, OFF)])
            })
        },
        Case {
            switch: vec![(100, CASE_END_US)],
            light: vec![(100, CASE_END_US)],
            ..case("frequency_0_is_no_pulses", {
                duty(&[(50, mode(Mode::Frequency, 1000)), (50, width(10)), (100, ON)])
            })
        },
    ]
}

fn first_pulse_killer() -> Vec<Case> {
    vec![
        Case {
            switch: vec![(100, 140)],
            light: vec![(160, 470)],
            energy: train(160, 470),
            ..case("fpk_pulse_then_energy", duty(&[(50, fpk(40, 60, 70)), (100, ON), (400, OFF)]))
        },
        Case {
            switch: vec![(100, 140)],
            ..case("fpk_of_a_mark_shorter_than_its_shift_makes_no_light", {
                duty(&[(50, fpk(40, 60, 5)), (100, ON), (150, OFF)])
            })
        },
        Case {
            switch: vec![(100, 340)],
            light: vec![(160, 505)],
            energy: train(160, 505),
            ..case("a_gate_on_during_an_fpk_pulse_begins_a_new_one", {
                duty(&[(50, fpk(190, 60, 105)), (100, ON), (120, OFF), (150, ON), (400, OFF)])
            })
        },
        Case {
            switch: vec![(100, 200), (400, 440)],
            light: vec![(100, 300), (460, 530)],
            energy: joined(&[train(100, 300), train(460, 530)]),
            ..case("ena_fpk_while_on_touches_the_switch_only", {
                duty(&[(100, ON), (200, fpk(40, 60, 30)), (300, OFF), (400, ON), (500, OFF)])
            })
        },
        Case {
            switch: vec![(100, 140), (200, 300)],
            light: vec![(160, 330)],
            energy: train(160, 330),
            ..case("dis_fpk_while_on_touches_the_switch_only", {
                duty(&[(50, fpk(40, 60, 30)), (100, ON), (200, Command::Fpk(None)), (300, OFF)])
            })
        },
        Case {
            switch: vec![(130, 170)],
            light: vec![(190, 550)],
            energy: train(190, 550),
            ..case("fpk_comes_after_the_gate_delays", {
                duty(&[(50, delays(80, 30)), (50, fpk(40, 60, 70)), (100, ON), (400, OFF)])
            })
        },
        Case {
            switch: vec![(100, 140), (300, 340)],
            light: vec![(100, 600)],
            energy: train(100, 600),
            ..case("energy_that_has_not_ended_goes_on", {
                duty(&[(50, fpk(40, 0, 200)), (100, ON), (250, OFF), (300, ON), (400, OFF)])
            })
        },
    ]
}

fn standby_and_modes() -> Vec<Case> {
    // 20 kHz at 10 %: 5 µs every 50 µs.
    let waiting = |begin: i64, end: i64| (begin..end).step_by(50).map(|at| (at, at + 5)).collect::<Vec<_>>();
    vec![
        Case {
            switch: vec![(102, 302)],
            light: vec![(102, 302)],
            energy: joined(&[
                waiting(50, 100),
                vec![(100, 102 + 25), (202, 227)],
                vec![(302, 307), (352, 357), (402, 407), (452, 457)],
            ]),
            ..case("standby_fills_the_dark", {
                duty(&[(50, standby(20, 10)), (50, delays(2, 2)), (100, ON), (300, OFF), (500, Command::Standby(None))])
            })
        },
        Case {
            switch: vec![(50, CASE_END_US)],
            light: vec![(100, 300)],
            energy: train(100, 300),
            ..case("no_standby_after_an_open_switch", {
                let mut job = duty(&[(50, standby(20, 10)), (100, ON), (300, OFF)]);
                job[0].1 = mode(Mode::Open, 100);
                job
            })
        },
        Case {
            switch: vec![(100, 210)],
            light: vec![(100, 210)],
            energy: joined(&[train(100, 200), vec![(200, 225)], vec![(225, 230), (275, 280)]]),
            ..case("standby_begins_after_a_pulse_that_is_finished", {
                duty(&[
                    (50, delays(10, 0)),
                    (100, ON),
                    (200, standby(20, 10)),
                    (200, OFF),
                    (300, Command::Standby(None)),
                ])
            })
        },
        Case {
            switch: vec![(100, 200)],
            light: vec![(100, 200)],
            energy: vec![(100, 125)],
            analog: vec![],
            ..case("another_mode_ends_the_light_at_once", {
                duty(&[
                    (50, delays(500, 0)),
                    (100, ON),
                    (200, mode(Mode::Frequency, 100)),
                    (400, power(10)),
                    (400, width(10)),
                ])
            })
        },
        Case {
            switch: vec![(100, 510)],
            light: vec![(100, 510)],
            energy: vec![(100, 550)],
            ..case("another_mode_cuts_a_last_pulse_that_is_being_finished", {
                let mut job = slow(500);
                job.insert(0, (50_000, delays(10, 0)));
                job.push((550_000, mode(Mode::Analog, 10)));
                job
            })
        },
        case(
            "another_mode_withdraws_a_pending_on",
            duty(&[(50, delays(0, 500)), (100, ON), (200, mode(Mode::Frequency, 100))]),
        ),
        Case {
            switch: vec![(100, 310)],
            light: vec![(100, 310)],
            energy: vec![(100, 125), (200, 225), (300, 310)],
            ..case("a_connector_taken_away_takes_the_light_at_once", {
                let (away, back) = (Command::Connector(false), Command::Connector(true));
                duty(&[(50, delays(1000, 0)), (100, ON), (310, away), (600, back)])
            })
        },
        Case {
            switch: vec![(100, 400)],
            light: vec![(100, 400)],
            analog: vec![(100, 2000), (400, 0)],
            ..case("analog_light_needs_no_connector", {
                let away = Command::Connector(false);
                duty(&[(50, mode(Mode::Analog, 10)), (50, power(2)), (100, ON), (200, away), (400, OFF)])
            })
        },
        Case {
            switch: vec![(100, 300)],
            light: vec![(100, 300)],
            energy: vec![(100, 125), (200, 220)],
            ..case("the_same_mode_again_changes_only_bounds", {
                duty(&[(100, ON), (150, mode(Mode::Duty, 20)), (300, OFF)])
            })
        },
        Case {
            switch: vec![(113, 417)],
            light: vec![(113, 417)],
            analog: vec![(50, 1000), (113, 2500), (200, 4000), (417, 1000)],
            ..case("analog_with_pre_voltage", {
                duty(&[
                    (50, mode(Mode::Analog, 4)),
                    (50, Command::Power(Exact::new(5, 2))),
                    (50, Command::PreVoltage(Some(number(1)))),
                    (50, delays(17, 13)),
                    (100, ON),
                    (200, power(5)),
                    (400, OFF),
                ])
            })
        },
        Case {
            switch: vec![(100, 200), (400, 500)],
            light: vec![(100, 200), (400, 500)],
            energy: vec![(100, 125), (400, 425)],
            ..case("a_fault_is_dark_until_cleared_and_then_until_the_next_on", {
                duty(&[
                    (50, delays(100, 0)),
                    (100, ON),
                    (200, Command::Fault),
                    (250, ON),
                    (300, Command::Clear),
                    (400, ON),
                    (400, OFF),
                ])
            })
        },
    ]
}
