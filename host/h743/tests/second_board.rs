//! The image for a module with an STM32H743VI (docs/board-h743vi.md) in emulation, where
//! BEAMTICK_H743VI_IMAGE names it: start-up from its crystal, the link over USB, its pins, and what
//! ends light. Its jobs are in tests/jobs.rs.
use client::{Client, Options};
use h743::board::{Board, MODULE, NUCLEO};
use h743::link::{EmulatedLink, Plug, Shared, lock};
use h743::{Cause, Level, MICROSECOND, MILLISECOND, Machine, Pin, Stop, Time};
use protocol::command::{
    AlarmOff, AlarmOn, AxisOn, ClrLaserFault, ClrSts, GetCaptureStatus, GetDi, GetEncPos, GetFault, GetLaserFault,
    GetSts, LaserOn, LaserOutFrq, LaserPrfCmd, LmtSns, LmtsOff, LmtsOn, SetAxisMode, SetCaptureMode, SetDoBit,
    SetHSIOOpt,
};
use std::sync::{Arc, Mutex};

/// Lines of both lasers: the + line, which is low while it is active, and the − line.
const LINES: [(&str, &str); 4] = [("PA8", "PB13"), ("PA2", "PA1"), ("PC7", "PB0"), ("PC8", "PB1")];
/// Inputs that break TIM1, TIM15 and TIM8.
const INTERLOCK: [(u8, &str); 3] = [(1, "PB12"), (15, "PA0"), (8, "PA6")];

fn pin(name: &str) -> Pin {
    Pin::named(name).unwrap()
}

fn elf(variable: &str) -> Option<Vec<u8>> {
    let Some(path) = std::env::var_os(variable) else {
        println!("skipped: {variable} names no image");
        return None;
    };
    Some(std::fs::read(path).unwrap())
}

fn interlock(machine: &mut Machine, open: bool) {
    INTERLOCK.iter().for_each(|(_, name)| machine.drive(pin(name), Some(open)));
}

/// The module, supplied: its image starts. `None` without an image.
fn powered() -> Option<Machine> {
    let elf = elf("BEAMTICK_H743VI_IMAGE")?;
    let mut machine = Machine::on(MODULE).unwrap();
    machine.boot(&elf).unwrap();
    Some(machine)
}

/// A client over USB, the interlock closed.
fn linked(mut machine: Machine) -> (Client, Plug, Shared) {
    machine.run(20 * MILLISECOND);
    machine.plug_usb(true);
    for _ in 0..200 {
        if machine.chip.bus.usb.host.is_open {
            break;
        }
        machine.run(MILLISECOND);
    }
    assert!(machine.chip.bus.usb.host.is_open, "no port at USB: {:?}", machine.chip.bus.complaints);
    let machine: Shared = Arc::new(Mutex::new(machine));
    let link = EmulatedLink::over_usb(machine.clone());
    let plug = link.plug();
    (Client::open(Box::new(link), Options::default()).unwrap(), plug, machine)
}

fn ready() -> Option<(Client, Plug, Shared)> {
    let mut machine = powered()?;
    interlock(&mut machine, false);
    Some(linked(machine))
}

fn is_driven_actively(change: &h743::gpio::Change) -> bool {
    let of = |&(plus, minus): &(&str, &str)| {
        change.pin == pin(plus) && change.level == Level::Driven(false)
            || change.pin == pin(minus) && change.level == Level::Driven(true)
    };
    LINES.iter().any(of)
}

#[test]
fn it_reaches_full_speed_from_its_crystal_and_drives_nothing_active() {
    let Some(mut machine) = powered() else { return };
    assert_eq!(machine.run(100 * MILLISECOND), Stop::Time);
    let bus = &machine.chip.bus;
    // No port beyond E either: the package has none.
    assert_eq!(bus.complaints, Vec::<String>::new());
    let clocks = bus.clocks();
    assert_eq!((clocks.core, clocks.bus, clocks.apb1, clocks.timers1, clocks.timers2), (2, 4, 8, 4, 4));
    assert_eq!(clocks.usb, Some(20), "48 MHz");
    // The link's line, and the select line of an external DAC, which rests high.
    let rests_high =
        |of: Pin| [pin("PB10"), pin("PC11")].contains(&of) || LINES.iter().any(|(plus, _)| of == pin(plus));
    let high: Vec<_> =
        bus.gpio.changes.iter().filter(|c| c.level == Level::Driven(true) && !rests_high(c.pin)).collect();
    assert!(high.is_empty(), "{high:?}");
    assert!(!bus.gpio.changes.iter().any(is_driven_actively));
    for (plus, minus) in LINES {
        assert_eq!(
            (bus.gpio.level(pin(plus)), bus.gpio.level(pin(minus))),
            (Level::Driven(true), Level::Driven(false))
        );
    }
    // Memory chips stay unselected; the debug port and the slow crystal keep their pins.
    for name in ["PB6", "PD6"] {
        assert_eq!(bus.gpio.level(pin(name)), Level::Pulled(true), "{name}");
    }
    for name in ["PA13", "PA14", "PC14", "PC15"] {
        assert!(bus.gpio.changes.iter().all(|change| change.pin != pin(name)), "{name}");
    }
    assert!(bus.watchdog.is_running());
    assert_eq!(machine.resets, []);
}

/// Whatever clock the board has: a module may have the Nucleo's 8 MHz.
#[test]
fn an_image_of_the_other_board_drives_no_pin_and_says_why_over_usb() {
    let images = [("BEAMTICK_H743_IMAGE", NUCLEO, MODULE, 144), ("BEAMTICK_H743VI_IMAGE", MODULE, NUCLEO, 100)];
    for (variable, own, other, pins) in images {
        let Some(elf) = elf(variable) else { continue };
        for board in [other, Board { package: other.package, ports: other.ports, ..own }] {
            let mut machine = Machine::on(board).unwrap();
            machine.boot(&elf).unwrap();
            for (_, name) in INTERLOCK.into_iter().chain([(1, "PE15"), (15, "PE3"), (8, "PG2")]) {
                machine.drive(pin(name), Some(false));
            }
            let (client, _, shared) = linked(machine);
            let (fault, text) = client.call_items(GetFault {}, &[]).unwrap();
            let text: String = text.iter().map(|byte| char::from(byte.value)).collect();
            let reason = format!("this image is for a board whose chip has {pins} pins; no pin is driven");
            assert_eq!((fault.kind, text), (5, reason));
            // What a client may order without a laser.
            for axis in 1..=8i16 {
                client.call(AxisOn { core: 1.into(), axis: axis.into() }).unwrap();
            }
            client.call(SetDoBit { core: 1.into(), do_type: 12.into(), index: 1.into(), value: 1.into() }).unwrap();
            assert!(client.call(LaserOn { core: 1.into(), channel: 0.into() }).is_err());
            let mut machine = lock(&shared);
            assert_eq!(machine.run(20 * MILLISECOND), Stop::Time);
            let changes = &machine.chip.bus.gpio.changes;
            assert!(changes.iter().all(|change| !matches!(change.level, Level::Driven(_))), "{changes:?}");
            let dac = &machine.chip.bus.dac;
            assert_eq!((dac.output(0), dac.output(1)), (None, None));
        }
    }
}

#[test]
fn the_client_opens_it_over_usb_and_it_asks_the_host_for_current() {
    let Some((client, _, shared)) = ready() else { return };
    let version = client.version();
    assert!(version.board.starts_with(b"h743vi-module") || version.board.starts_with(b"h743vi-dac8563"), "{version:?}");
    assert_eq!((version.axes_per_core, version.lasers, version.tick_us.get()), (8, 2, 50));
    assert_eq!(client.call_items(GetFault {}, &[]).unwrap().0.kind, 0);
    let machine = lock(&shared);
    let transfers = &machine.chip.bus.usb.host.transfers;
    let configuration = transfers.iter().rev().find(|t| t.setup.starts_with(&[0x80, 6, 0, 2])).unwrap();
    // USB 2.0 table 9-10: bit 7 is always set, bit 6 is for a supply of its own; current in 2 mA.
    assert_eq!((configuration.data[7], configuration.data[8]), (0x80, 250));
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
    assert_eq!(machine.resets, []);
}

/// Both lasers on: 10 kHz, most of the time light, within a pulse of both.
fn lit() -> Option<(Client, Plug, Shared)> {
    let (client, plug, machine) = ready()?;
    for (axis, channel) in [(7, 0), (8, 1)] {
        let (core, channel) = (1.into(), channel.into());
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserOutFrq { core, frequency: 10.0.into(), channel }).unwrap();
        client.call(LaserPrfCmd { core, power: 80.0.into(), channel }).unwrap();
        switch_on(&client, channel.get());
    }
    into_pulses(&machine);
    Some((client, plug, machine))
}

fn switch_on(client: &Client, channel: i16) {
    client.call(SetHSIOOpt { core: 1.into(), value: 1.into(), channel: channel.into() }).unwrap();
}

/// Which + lines are lit: energy of both lasers, switch of both.
fn lit_lines(machine: &Machine) -> [bool; 4] {
    LINES.map(|(plus, _)| machine.chip.bus.gpio.level(pin(plus)) == Level::Driven(false))
}

fn into_pulses(machine: &Shared) {
    let mut machine = lock(machine);
    let end = machine.chip.now + 10 * MILLISECOND;
    while lit_lines(&machine) != [true; 4] {
        machine.run(7 * MICROSECOND);
        assert!(machine.chip.now < end, "light that does not begin: {:?}", lit_lines(&machine));
    }
}

fn last_light(machine: &Machine, since: Time) -> Option<Time> {
    let is_active = |change: &&h743::gpio::Change| is_driven_actively(change);
    machine.chip.bus.gpio.changes.iter().rev().find(is_active).map(|change| change.at).filter(|&at| at > since)
}

#[test]
fn each_break_input_ends_light_without_an_instruction() {
    let Some((client, _, shared)) = lit() else { return };
    let core = 1.into();
    for (number, name) in INTERLOCK {
        into_pulses(&shared);
        let mut machine = lock(&shared);
        let (now, instructions) = (machine.chip.now, machine.chip.instructions);
        machine.drive(pin(name), Some(true));
        assert_eq!((machine.chip.now, machine.chip.instructions), (now, instructions));
        // Energy of laser 0 is TIM1's, that of laser 1 TIM15's, both switches are TIM8's.
        let of_timer = match number {
            1 => [false, true, true, true],
            15 => [true, false, true, true],
            _ => [true, true, false, false],
        };
        assert_eq!(lit_lines(&machine), of_timer, "TIM{number}");
        // The others follow in the tick that reads the interlock.
        machine.run(60 * MICROSECOND);
        let dark = machine.chip.now;
        machine.run(500 * MICROSECOND);
        assert_eq!(last_light(&machine, dark), None, "TIM{number}");
        // The others open too: an input that stays apart is a fault of the wiring. Their breaks
        // show at − lines for two counts.
        interlock(&mut machine, true);
        machine.run(MICROSECOND);
        let dark = machine.chip.now;
        machine.run(20 * MILLISECOND);
        assert_eq!(last_light(&machine, dark), None, "TIM{number}");
        interlock(&mut machine, false);
        machine.run(20 * MILLISECOND);
        assert_eq!(last_light(&machine, dark), None, "TIM{number}: light comes back by itself");
        drop(machine);
        for channel in 0..2i16 {
            let fault = client.call(GetLaserFault { core, channel: channel.into() }).unwrap();
            assert_eq!(fault.value.get(), 1, "TIM{number}");
            client.call(ClrLaserFault { core, channel: channel.into() }).unwrap();
            switch_on(&client, channel);
        }
    }
    into_pulses(&shared);
    assert_eq!(lock(&shared).chip.bus.complaints, Vec::<String>::new());
}

#[test]
fn a_break_that_is_not_its_pins_is_reported_with_this_boards_pin() {
    for (number, name) in INTERLOCK {
        let Some(mut machine) = powered() else { return };
        interlock(&mut machine, false);
        machine.chip.bus.timer(number).unwrap().is_odd = true;
        let (client, ..) = linked(machine);
        let (fault, text) = client.call_items(GetFault {}, &[]).unwrap();
        let text: String = text.iter().map(|byte| char::from(byte.value)).collect();
        assert_eq!((fault.kind, text), (5, format!("TIM{number} breaks although its input {name} is low")));
        assert_eq!(client.call(GetLaserFault { core: 1.into(), channel: 0.into() }).unwrap().value.get(), 1);
    }
}

#[test]
fn a_crystal_that_stops_ends_a_pulse_without_an_instruction_and_is_reported() {
    let Some((client, plug, shared)) = lit() else { return };
    plug.pull();
    drop(client);
    let mut machine = Arc::into_inner(shared).unwrap().into_inner().unwrap();
    let (now, instructions) = (machine.chip.now, machine.chip.instructions);
    machine.give_clock(false);
    assert_eq!((machine.chip.now, machine.chip.instructions), (now, instructions));
    assert_eq!(lit_lines(&machine), [false; 4]);
    machine.plug_usb(false);
    assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
    assert_eq!(machine.run(300 * MILLISECOND), Stop::Time);
    machine.give_clock(true);
    let (client, _, shared) = linked(machine);
    let (fault, text) = client.call_items(GetFault {}, &[]).unwrap();
    let text: String = text.iter().map(|byte| char::from(byte.value)).collect();
    assert_eq!((fault.kind, &*text), (3, "the crystal has stopped"));
    assert_eq!(last_light(&lock(&shared), now), None);
}

#[test]
fn light_does_not_outlive_the_tick_and_the_watchdog_resets() {
    let Some((client, plug, shared)) = lit() else { return };
    plug.pull();
    drop(client);
    let mut machine = lock(&shared);
    let chip = &mut machine.chip;
    let at = chip.now;
    // TIM2 stands still: no tick comes any more.
    chip.bus.write(0x4000_0000, 0, u32::MAX, at, &mut chip.scs.exceptions).unwrap();
    assert_eq!(machine.run(200 * MILLISECOND), Stop::Reset(Cause::Watchdog));
    let last = last_light(&machine, at).unwrap_or(at);
    // Two ticks of 50 us are queued, and a third may have begun.
    assert!(last - at <= 150 * MICROSECOND, "{} us", (last - at) / MICROSECOND);
    let reset = machine.resets[0].0;
    machine.run(200 * MILLISECOND);
    assert_eq!(last_light(&machine, reset), None);
}

/// What GetSts shows of an axis.
const ALARM: i32 = 1 << 1;
const LIMIT_POSITIVE: i32 = 1 << 5;
const LIMIT_NEGATIVE: i32 = 1 << 6;

#[test]
fn inputs_and_outputs_are_where_the_table_of_pins_has_them() {
    let Some((client, _, machine)) = ready() else { return };
    let core = 1.into();
    let run = || lock(&machine).run(200 * MICROSECOND);
    let status = || -> Vec<i32> {
        client.call(ClrSts { core, axis: 1.into(), count: 8.into() }).unwrap();
        run();
        let read = GetSts { core, axis: 1.into(), count: 8.into() };
        client.call_items(read, &[]).unwrap().1.iter().map(|item| item.value.get()).collect()
    };
    let inputs = [
        (LIMIT_POSITIVE, ["PB7", "PB8", "PB9", "PB14"]),
        (LIMIT_NEGATIVE, ["PA3", "PA7", "PA10", "PA15"]),
        (ALARM, ["PB15", "PC6", "PD15", "PD7"]),
    ];
    for (bit, pins) in inputs {
        for (axis, name) in pins.into_iter().enumerate() {
            lock(&machine).drive(pin(name), Some(true));
            run();
            let active: Vec<bool> = status().iter().map(|status| status & bit != 0).collect();
            assert_eq!(active, (0..8).map(|other| other == axis).collect::<Vec<bool>>(), "{name}");
            lock(&machine).drive(pin(name), None);
            run();
        }
    }
    // General inputs (type 4) and outputs (type 12), from bit 0 and number 1 on.
    let general = || client.call(GetDi { core, di_type: 4.into() }).unwrap().value.get();
    for (bit, name) in ["PC13", "PD4"].into_iter().enumerate() {
        let before = general();
        lock(&machine).drive(pin(name), Some(true));
        run();
        assert_eq!(general() ^ before, 1 << bit, "{name}");
        lock(&machine).drive(pin(name), None);
        run();
    }
    for (index, name) in (1i16..).zip(["PD2", "PB3", "PB2"]) {
        let level = |value: i16| {
            client.call(SetDoBit { core, do_type: 12.into(), index: index.into(), value: value.into() }).unwrap();
            run();
            lock(&machine).chip.bus.gpio.level(pin(name))
        };
        assert_ne!(level(0), level(1), "{name}");
    }
    let beyond = SetDoBit { core, do_type: 12.into(), index: 4.into(), value: 1.into() };
    assert_eq!(client.call(beyond).unwrap_err().code, 7);
    for (axis, name) in (1i16..).zip(["PD0", "PD1", "PD3", "PD5", "PD8", "PD9", "PD10", "PD11"]) {
        client.call(AxisOn { core, axis: axis.into() }).unwrap();
        run();
        assert_eq!(lock(&machine).chip.bus.gpio.level(pin(name)), Level::Driven(true), "{name}");
    }
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}

/// Axes 5 to 8 have no inputs of their own here.
#[test]
fn inputs_that_this_board_lacks_are_refused_by_name() {
    let Some((client, ..)) = ready() else { return };
    let core = 1.into();
    let reason = |refused: client::Result<()>| {
        let error = refused.unwrap_err();
        assert_eq!(error.code, 7, "{error}");
        error.reason
    };
    let no_limit = |call: &str, field: &str, got: i32, axis: i16| {
        format!("{call}: {field} is {got}; this board has no such limit input for axis {axis}")
    };
    for axis in 1..=8i16 {
        let number = axis.into();
        for limit_type in [-1i16, 0, 1] {
            let limits = client.call(LmtsOn { core, axis: number, limit_type: limit_type.into() }).map(|_| ());
            match axis {
                1..=4 => assert_eq!(limits, Ok(()), "axis {axis}"),
                _ => assert_eq!(reason(limits), no_limit("LmtsOn", "limit_type", limit_type.into(), axis)),
            }
            client.call(LmtsOff { core, axis: number, limit_type: limit_type.into() }).unwrap();
        }
        let alarm = client.call(AlarmOn { core, axis: number }).map(|_| ());
        let home = client.call(SetCaptureMode { core, encoder: number, mode: 1.into() }).map(|_| ());
        // Two bits an axis.
        let sense = 1u16 << (2 * (axis - 1));
        let limits = client.call(LmtSns { core, sense: sense.into() }).map(|_| ());
        if axis <= 4 {
            assert_eq!((alarm, home, limits), (Ok(()), Ok(()), Ok(())), "axis {axis}");
        } else {
            assert_eq!(
                reason(alarm),
                format!("AlarmOn: axis is {axis}; this board has no alarm input for axis {axis}")
            );
            assert_eq!(
                reason(home),
                format!("SetCaptureMode: mode is 1; this board has no home input for axis {axis}")
            );
            assert_eq!(reason(limits), no_limit("LmtSns", "sense", sense.into(), axis));
        }
        client.call(AlarmOff { core, axis: number }).unwrap();
    }
}

#[test]
fn encoders_are_counted_and_captured_at_this_boards_pins() {
    let Some((client, _, machine)) = ready() else { return };
    let core = 1.into();
    let read = |encoder: i16| {
        let read = GetEncPos { core, encoder: encoder.into(), count: 1.into() };
        client.call_items(read, &[]).unwrap().1[0].value.get()
    };
    let captured = |encoder: i16| {
        let read = GetCaptureStatus { core, encoder: encoder.into(), count: 1.into() };
        let (_, items) = client.call_items(read, &[]).unwrap();
        (items[0].status.get(), items[0].value.get())
    };
    for (number, [one, two], index, home) in [(1, ["PB4", "PB5"], "PC9", "PC0"), (2, ["PD12", "PD13"], "PD14", "PC1")] {
        let turn = |counts: u32, index_at: Option<u32>| {
            let mut machine = lock(&machine);
            for n in 1..=counts {
                // A leads B forwards (RM0433 table 337).
                let (a, b) = [(true, true), (false, true), (false, false), (true, false)][n as usize % 4];
                machine.drive(pin(one), Some(a));
                machine.drive(pin(two), Some(b));
                machine.drive(pin(index), Some(Some(n) == index_at));
                machine.run(MICROSECOND / 2);
            }
            machine.run(200 * MICROSECOND);
        };
        turn(100, None);
        assert_eq!(read(number), 100.0, "encoder {number}");
        client.call(SetCaptureMode { core, encoder: number.into(), mode: 2.into() }).unwrap();
        turn(100, Some(37));
        assert_eq!((read(number), captured(number)), (200.0, (1, 137)), "encoder {number}");
        client.call(SetCaptureMode { core, encoder: number.into(), mode: 1.into() }).unwrap();
        lock(&machine).drive(pin(home), Some(true));
        turn(100, None);
        assert_eq!(captured(number).0, 1, "home of axis {number}");
    }
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}
