//! What an external DAC shows where states meet: it keeps its voltage through a reset of the chip,
//! and takes whole frames only. The images that BEAMTICK_H743_DAC_IMAGE and
//! BEAMTICK_H743VI_DAC_IMAGE name.
mod road;

use client::{Client, Options};
use h743::board::{Board, MODULE, NUCLEO};
use h743::bus::BREAKS;
use h743::dac8563::{MID_SCALE, shown};
use h743::link::{Shared, lock};
use h743::{Cause, Level, MICROSECOND, MILLISECOND, Machine, Pin, Stop, Time};
use protocol::command::{GetFault, LaserOn, LaserPowerMode, LaserPrfCmd, SetAxisMode};
use road::{Road, send_unanswered};
use std::sync::{Arc, Mutex};

const BOARDS: [(&str, Board); 2] = [("BEAMTICK_H743_DAC_IMAGE", NUCLEO), ("BEAMTICK_H743VI_DAC_IMAGE", MODULE)];

/// Each board with its image, the interlock's circuit closed, after start-up.
fn boards() -> Vec<Shared> {
    let started = |&(variable, board): &(&str, Board)| {
        let Some(path) = std::env::var_os(variable) else {
            println!("skipped: {variable} names no image");
            return None;
        };
        let mut machine = Machine::on(board).unwrap();
        machine.boot(&std::fs::read(path).unwrap()).unwrap();
        BREAKS.iter().for_each(|(_, name, _)| machine.drive(Pin::named(name).unwrap(), Some(false)));
        assert_eq!(machine.run(20 * MILLISECOND), Stop::Time);
        Some(Arc::new(Mutex::new(machine)))
    };
    BOARDS.iter().filter_map(started).collect()
}

fn select() -> Pin {
    Pin::named("PC11").unwrap()
}

/// Codes of both outputs.
fn codes(machine: &Machine) -> [u16; 2] {
    let shown = shown(&machine.chip, select());
    [0, 1].map(|of| shown.iter().rev().find(|(_, output, _)| *output == of).map_or(MID_SCALE, |(.., code)| *code))
}

/// The code of a voltage: 10 V are full scale.
fn code(volts: f64) -> u16 {
    MID_SCALE + (volts * 3276.7).round() as u16
}

fn assert_volts(machine: &Machine, volts: [f64; 2], what: &str) {
    let codes = codes(machine);
    for (code, of_volts) in codes.into_iter().zip(volts.map(code)) {
        assert!(code.abs_diff(of_volts) <= 1, "{what}: {codes:x?} for {volts:?} V");
    }
}

fn power(client: &Client, channel: i16, volts: f64) -> client::Result<()> {
    client.call(LaserPrfCmd { core: 1.into(), power: volts.into(), channel: channel.into() }).map(|_| ())
}

/// Both lasers shine by their voltages: 4 V and 7 V.
fn shine(client: &Client, machine: &Shared) {
    for (channel, volts) in [(0, 4.0), (1, 7.0)] {
        let (core, axis, of) = (1.into(), (7 + channel).into(), channel.into());
        client.call(SetAxisMode { core, axis, mode: 1.into() }).unwrap();
        let (max, min) = (10.0.into(), 0.0.into());
        client.call(LaserPowerMode { core, mode: 2.into(), max, min, channel: of, delay_mode: 0.into() }).unwrap();
        power(client, channel, volts).unwrap();
        client.call(LaserOn { core, channel: of }).unwrap();
    }
    assert_eq!(lock(machine).run(MILLISECOND), Stop::Time);
    assert_volts(&lock(machine), [4.0, 7.0], "lit");
}

fn client(machine: &Shared) -> Client {
    Client::open(Box::new(Road::to(machine)), Options::default()).unwrap()
}

/// A host finds an external DAC's image in the board's name.
#[test]
fn the_boards_name_says_that_its_dac_is_an_external_one() {
    let names: Vec<String> =
        boards().iter().map(|machine| String::from_utf8_lossy(&client(machine).version().board).into_owned()).collect();
    let named = |&(variable, board): &(&str, Board)| {
        std::env::var_os(variable).map(|_| if board == NUCLEO { "h743zi2-dac8563" } else { "h743vi-dac8563" })
    };
    let expected: Vec<&str> = BOARDS.iter().filter_map(named).collect();
    let names: Vec<&str> = names.iter().map(|name| name.trim_end_matches('\0')).collect();
    assert_eq!(names, expected);
}

/// The instant at which both outputs are at 0 V for good.
fn dark_from(machine: &Machine) -> Time {
    assert_eq!(codes(machine), [MID_SCALE; 2]);
    let shown = shown(&machine.chip, select());
    // The first write of 0 V after which no output gets anything else.
    let last =
        |of: usize| shown.iter().filter(move |write| write.1 == of).rev().take_while(|write| write.2 == MID_SCALE);
    [0, 1].into_iter().map(|of| last(of).last().unwrap().0).max().unwrap()
}

/// Until start-up has cleared the RAMs nothing is written: 8 ms, as docs/safety.md says.
const START_UP: Time = 9 * MILLISECOND;

#[test]
fn a_reset_under_voltage_ends_it_though_the_clock_does_not_come() {
    for machine in boards() {
        let client = client(&machine);
        shine(&client, &machine);
        let mut machine = lock(&machine);
        let at = machine.chip.now;
        machine.reset(Cause::Pin);
        machine.give_clock(false);
        assert_eq!(machine.run(200 * MILLISECOND), Stop::Time);
        let took = dark_from(&machine) - at;
        println!("0 V {} us after the reset", took / MICROSECOND);
        assert!(took < START_UP, "{took}");
        machine.give_clock(true);
        machine.run(50 * MILLISECOND);
        assert_eq!(codes(&machine), [MID_SCALE; 2]);
    }
}

/// The frame of a new power, stopped after so many steps: within each of its bytes, and in between.
#[test]
fn a_fault_within_a_frame_ends_the_voltage() {
    for (n, machine) in
        (0..).flat_map(|n| boards().into_iter().map(move |machine| (n, machine))).take_while(|(n, _)| *n < 10)
    {
        let road = Road::to(&machine);
        let (sent, left) = (Arc::clone(&road.sent), Arc::clone(&road.left));
        let client = Client::open(Box::new(road), Options::default()).unwrap();
        shine(&client, &machine);
        send_unanswered((&sent, &left), || power(&client, 1, 7.0), || power(&client, 1, 9.0));
        let at = {
            let mut machine = lock(&machine);
            let end = machine.chip.now + MILLISECOND;
            while machine.chip.bus.gpio.level(select()) != Level::Driven(false) {
                machine.run(1);
                assert!(machine.chip.now < end, "no frame");
            }
            machine.run(n * MICROSECOND / 10);
            // The clock's guard makes an NMI.
            let at = machine.chip.now;
            machine.give_clock(false);
            assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
            let took = dark_from(&machine) - at;
            println!("0 V {} ns after the fault", took * 1000 / MICROSECOND);
            assert!(took < 20 * MICROSECOND, "{n}: {took}");
            machine.give_clock(true);
            machine.run(50 * MILLISECOND);
            at
        };
        drop(client);
        assert_eq!(reason_kind(&machine), 3, "an interrupt");
        assert!(dark_from(&lock(&machine)) - at < 20 * MICROSECOND, "{n}: it came back");
    }
}

fn reason_kind(machine: &Shared) -> u8 {
    client(machine).call_items(GetFault {}, &[]).unwrap().0.kind
}

/// A byte takes so long that the tick gives its frame up.
#[test]
fn a_frame_that_does_not_end_is_sent_again_and_later_ones_are_right() {
    for machine in boards() {
        let client = client(&machine);
        shine(&client, &machine);
        for (stall, volts) in [(30 * MICROSECOND, 5.0), (MILLISECOND, 6.0), (45 * MICROSECOND, 2.0)] {
            lock(&machine).chip.bus.spi.stall = stall;
            power(&client, 1, volts).unwrap();
            lock(&machine).run(MILLISECOND);
            assert_volts(&lock(&machine), [4.0, volts], "after a frame that was given up");
            power(&client, 0, volts).unwrap();
            lock(&machine).run(MILLISECOND);
            assert_volts(&lock(&machine), [volts, volts], "the next frame");
            power(&client, 0, 4.0).unwrap();
        }
        assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
    }
}
