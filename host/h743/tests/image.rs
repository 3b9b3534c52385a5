//! The released image for the NUCLEO-H743ZI2 in emulation, where BEAMTICK_H743_IMAGE names it
//! (`cargo xtask check-all` does).
mod images;

use client::{Client, Options};
use h743::board::{Board, MODULE, NUCLEO};
use h743::engine::Register;
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{Cause, Level, MICROSECOND, MILLISECOND, Machine, Pin, Stop};
use protocol::command::{AxisOn, GetFault, LaserStatus};
use std::sync::{Arc, Mutex};

/// The image, if there is one.
fn image() -> Option<Vec<u8>> {
    images::named("BEAMTICK_H743_IMAGE")
}

fn booted(elf: &[u8]) -> Machine {
    let mut machine = Machine::new().unwrap();
    machine.boot(elf).unwrap();
    machine
}

/// Pins of lasers and axes (docs/board-h743.md), which only a configured board may drive.
const GUARDED: [&str; 23] = [
    "PE8", "PE4", "PB0", "PB15", "PA4", "PA5", "PD0", "PD1", "PD2", "PD3", "PD4", "PD5", "PD6", "PD7", "PF0", "PF1",
    "PF2", "PF3", "PF4", "PF5", "PF6", "PF7", "PG0",
];

/// Whether a pin is one of an external DAC's, which start-up sets to 0 V before all else
/// (tests/external_dac.rs). The plain image drives none of them.
fn is_of_dac(pin: Pin) -> bool {
    let (_, is_for_dac) = images::reference();
    is_for_dac && ["PC10", "PC11", "PC12"].into_iter().any(|name| Pin::named(name) == Some(pin))
}

/// The + lines of energy and switch, which rest high.
const REST_HIGH: [&str; 4] = ["PE9", "PE5", "PC7", "PC8"];

#[test]
fn start_up_reaches_full_speed_and_drives_nothing_active() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    let mut started = None;
    for _ in 0..100 {
        assert_eq!(machine.run(MILLISECOND), Stop::Time);
        if started.is_none() && machine.chip.bus.clocks().core == 2 {
            started = Some(machine.chip.now);
        }
    }
    let bus = &machine.chip.bus;
    assert_eq!(bus.complaints, Vec::<String>::new());
    let clocks = bus.clocks();
    println!("480 MHz after {:?} µs, {} instructions", started.map(|at| at / MICROSECOND), machine.chip.instructions);
    assert_eq!((clocks.core, clocks.bus, clocks.apb1, clocks.timers1, clocks.timers2), (2, 4, 8, 4, 4));
    // Every change of a pin since power-on, so also between any two instructions. Nothing was ever
    // driven high but the link's line, those of an external DAC, and the + lines of the lasers.
    // These rest high and were never driven low.
    let plus = REST_HIGH.map(|name| Pin::named(name).unwrap());
    let rests_high = |pin: Pin| pin == link_pin() || is_of_dac(pin) || plus.contains(&pin);
    let high: Vec<_> =
        bus.gpio.changes.iter().filter(|c| c.level == Level::Driven(true) && !rests_high(c.pin)).collect();
    assert!(high.is_empty(), "{high:?}");
    for pin in plus {
        let of: Vec<_> =
            bus.gpio.changes.iter().filter(|change| change.pin == pin).map(|change| change.level).collect();
        assert!(of.contains(&Level::Driven(true)) && !of.contains(&Level::Driven(false)), "{pin:?}: {of:?}");
    }
    for name in GUARDED {
        let pin = Pin::named(name).unwrap();
        let changed =
            bus.gpio.changes.iter().any(|change| change.pin == pin && matches!(change.level, Level::Driven(true)));
        assert!(!changed, "{name}");
    }
    // The switch of USB's 5 V is off, and no longer left to float.
    let of: Vec<Level> = bus.gpio.changes.iter().filter(|change| change.pin == Pin(3, 10)).map(|c| c.level).collect();
    assert_eq!(of, [Level::Driven(false)]);
    assert!(bus.watchdog.is_running());
    assert_eq!(machine.resets, []);
}

/// Each image and what it runs on.
const IMAGES: [(&str, Board); 5] = [
    ("BEAMTICK_H743_IMAGE", NUCLEO),
    ("BEAMTICK_H743_DAC_IMAGE", NUCLEO),
    ("BEAMTICK_H743VI_IMAGE", MODULE),
    ("BEAMTICK_H743VI_DAC_IMAGE", MODULE),
    ("BEAMTICK_H743_BRING_UP", NUCLEO),
];

/// Some loaders of ST-LINKs refuse an image whose first word, the stack, lies elsewhere.
#[test]
fn the_first_word_of_each_image_is_a_stack_in_dtcm() {
    for (variable, board) in IMAGES {
        let Some(elf) = images::named(variable) else { continue };
        let mut machine = Machine::on(board).unwrap();
        machine.boot(&elf).unwrap();
        let stack = machine.chip.memory.word(0x0800_0000).unwrap();
        assert!((0x2000_0001..=0x2002_0000).contains(&stack), "{variable}: {stack:#x} is not in DTCM");
    }
}

/// Only an STM32H743 of revision X or V runs an image. Revision Y, 0x1003, reaches neither VOS0 nor
/// 480 MHz.
#[test]
fn each_image_refuses_other_chips_and_revisions() {
    let others =
        [0x1001, 0x1003, 0x2002, 0x3003].map(Wrong::Revision).into_iter().chain([0x480, 0x483].map(Wrong::Chip));
    let others: Vec<Wrong> = others.collect();
    for (variable, board) in IMAGES {
        let Some(elf) = images::named(variable) else { continue };
        // The bring-up image lights LD3; on a machine that is an output.
        let led = Pin::named("PB14").filter(|_| variable == "BEAMTICK_H743_BRING_UP");
        for other in &others {
            let mut machine = Machine::on(board).unwrap();
            machine.boot(&elf).unwrap();
            machine.plant(*other);
            // Longer than a watchdog takes.
            assert_eq!(machine.run(150 * MILLISECOND), Stop::Time);
            let bus = &machine.chip.bus;
            let drives = |change: &&h743::gpio::Change| matches!(change.level, Level::Driven(_));
            let driven: Vec<_> =
                bus.gpio.changes.iter().filter(drives).map(|change| (change.pin, change.level)).collect();
            let lit: Vec<_> = led.into_iter().map(|led| (led, Level::Driven(true))).collect();
            assert_eq!(driven, lit, "{variable}, {other:?}");
            assert_eq!((machine.resets.len(), bus.watchdog.is_running()), (0, false), "{variable}, {other:?}");
        }
    }
}

/// It is powered later than the chip, or slower.
#[test]
fn a_clock_that_comes_late_is_waited_for_in_the_dark_and_is_no_fault() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    machine.give_clock(false);
    assert_eq!(machine.run(300 * MILLISECOND), Stop::Time);
    let pins = &machine.chip.bus.gpio.changes;
    assert!(pins.iter().all(|c| is_of_dac(c.pin) || !matches!(c.level, Level::Driven(_))), "{pins:?}");
    machine.give_clock(true);
    assert_eq!(machine.run(100 * MILLISECOND), Stop::Time);
    assert_eq!((machine.chip.bus.clocks().core, &*machine.resets), (2, &[][..]));
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
    assert_eq!(last_fault(machine), (0, String::new()));
}

/// The interrupt of TIM2, as an exception.
const TICK: usize = 16 + 28;

#[test]
fn the_first_tick_begins_in_time() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    while !machine.chip.scs.exceptions.active[TICK] {
        assert_eq!(machine.run(MICROSECOND), Stop::Time);
        assert!(machine.chip.now < 100 * MILLISECOND, "no tick");
    }
    let now = machine.chip.now;
    let late = machine.chip.bus.timer(2).unwrap().count(now);
    assert!(late < 2 * 240, "the tick begins {late} counts late: the timer ran before interrupts were let in");
}

fn linked(elf: &[u8]) -> (Client, Shared) {
    let machine: Shared = Arc::new(Mutex::new(booted(elf)));
    for pin in ["PE15", "PE3", "PG2"] {
        lock(&machine).drive(Pin::named(pin).unwrap(), Some(false));
    }
    lock(&machine).run(20 * MILLISECOND);
    let client = Client::open(Box::new(EmulatedLink::new(machine.clone())), Options::default()).unwrap();
    (client, machine)
}

#[test]
fn the_client_opens_the_board_over_its_usart() {
    let Some(elf) = image() else { return };
    let (client, machine) = linked(&elf);
    let version = client.version();
    assert!(version.board.starts_with(images::reference().0), "{version:?}");
    assert_eq!((version.axes_per_core, version.lasers, version.tick_us.get()), (8, 2, 50));
    // No tick was late, the circuit of the interlock is closed: nothing keeps a laser dark.
    let state = client.call(LaserStatus { core: 1.into(), channel: 0.into() }).unwrap();
    assert_eq!(state.fault.get(), 0);
    let machine = lock(&machine);
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
    assert_eq!(machine.chip.bus.usart.lost, 0);
    assert_eq!(machine.resets, Vec::<(h743::Time, Cause)>::new());
}

#[test]
fn a_missing_host_is_no_reason_to_bite_and_a_stopped_tick_is() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    assert_eq!(machine.run(400 * MILLISECOND), Stop::Time, "no host for eight times the watchdog's patience");
    // TIM2 loses its clock: no tick any more, whatever the thread does.
    let chip = &mut machine.chip;
    let at = chip.now;
    chip.bus.write(0x4000_0000, 0, u32::MAX, at, &mut chip.scs.exceptions).unwrap();
    assert_eq!(machine.run(200 * MILLISECOND), Stop::Reset(Cause::Watchdog));
    let waited = machine.resets[0].0 - at;
    println!("the watchdog bites {} ms after the last tick", waited / MILLISECOND);
    // It starts again, and goes on.
    assert_eq!(machine.run(300 * MILLISECOND), Stop::Time);
    assert_eq!(machine.resets.len(), 1);
}

/// The bell from the tick, without which the task of the link never comes round.
const PEND_SV: usize = 14;

#[test]
fn a_link_task_that_stands_still_lets_the_watchdog_bite() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    assert_eq!(machine.run(100 * MILLISECOND), Stop::Time);
    machine.chip.scs.exceptions.enabled.set(PEND_SV, false);
    let at = machine.chip.now;
    assert_eq!(machine.run(1000 * MILLISECOND), Stop::Reset(Cause::Watchdog));
    let waited = (machine.resets[0].0 - at) / MILLISECOND;
    // Half a second of patience with the task, then the watchdog's own 100 ms.
    assert!((500..=620).contains(&waited), "{waited} ms");
    machine.run(100 * MILLISECOND);
    let (fault, text) = last_fault(machine);
    assert_eq!((fault, &*text), (4, "watchdog: the tick or the thread stood still"));
}

/// What the board reports of the end of its last run.
fn last_fault(machine: Machine) -> (u8, String) {
    let link = EmulatedLink::new(Arc::new(Mutex::new(machine)));
    let client = Client::open(Box::new(link), Options::default()).unwrap();
    let (fault, text) = client.call_items(GetFault {}, &[]).unwrap();
    (fault.kind, text.iter().map(|byte| char::from(byte.value)).collect())
}

/// Memory that nobody uses here: of tables that are not sent.
const SCRATCH_ADDRESS: u32 = 0x2400_0000;

#[test]
fn a_panic_rests_the_outputs_and_its_reason_is_read_after_the_reset() {
    let Some(elf) = image() else { return };
    let (client, shared) = linked(&elf);
    client.call(AxisOn { core: 1.into(), axis: 1.into() }).unwrap();
    drop(client);
    let mut machine = Arc::into_inner(shared).unwrap().into_inner().unwrap();
    machine.run(MILLISECOND);
    let enable = Pin::named("PG0").unwrap();
    assert_eq!(machine.chip.bus.gpio.level(enable), Level::Driven(true));
    // The thread calls `core::panicking::panic("the reason", &Location)`, with what both point to
    // in memory that is spare.
    let (message, file) = (b"the reason", b"some/file.rs");
    let memory = &machine.chip.memory;
    assert!(memory.load(SCRATCH_ADDRESS + 0x40, message) && memory.load(SCRATCH_ADDRESS + 0x80, file));
    let location = [SCRATCH_ADDRESS + 0x80, file.len() as u32, 12, 34];
    assert!((0..).zip(location).all(|(n, word)| memory.load(SCRATCH_ADDRESS + 4 * n, &u32::to_le_bytes(word))));
    while machine.running() != 0 {
        machine.run(1);
    }
    let panic = h743::image::symbol(&elf, "9panicking5panic").unwrap();
    let arguments = [SCRATCH_ADDRESS + 0x40, message.len() as u32, SCRATCH_ADDRESS];
    for (n, value) in (0..).zip(arguments) {
        machine.set_register(Register::R(n), value);
    }
    machine.set_register(Register::Pc, panic | 1);
    machine.chip.scs.exceptions.pending.set(TICK, true);
    let before = machine.chip.now;
    assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
    let rest = *machine.chip.bus.gpio.changes.iter().rev().find(|change| change.pin == enable).unwrap();
    assert_eq!(rest.level, Level::Floating);
    assert!(rest.at > before && rest.at < machine.resets[0].0, "{rest:?}, {:?}", machine.resets);
    machine.run(100 * MILLISECOND);
    let high = machine.chip.bus.gpio.changes.iter().filter(|change| change.at > rest.at && change.pin != link_pin());
    assert_eq!(high.filter(|change| change.level == Level::Driven(true) && is_active_high(change.pin)).count(), 0);
    let (fault, text) = last_fault(machine);
    assert_eq!(fault, 1);
    assert!(text.contains("some/file.rs:12:34") && text.contains("the reason"), "{text}");
}

#[test]
fn a_stack_that_is_full_is_a_fault() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    machine.run(50 * MILLISECOND);
    while machine.running() != 0 {
        machine.run(1);
    }
    // The thread's stack reaches down to its end, and the next interrupt finds no room: at once,
    // before the thread itself reaches further.
    let end = h743::image::symbol(&elf, "_stack_end").unwrap();
    machine.set_register(Register::Sp, end + 16);
    machine.chip.scs.exceptions.pending.set(TICK, true);
    assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
    machine.run(100 * MILLISECOND);
    let (fault, text) = last_fault(machine);
    assert_eq!(fault, 2);
    // The MPU forbids it (MSTKERR), so that it does not depend on what the bus makes of an address
    // without memory.
    assert!(text.contains("stack overflow") && text.contains("CFSR 0x00000010"), "{text}");
}

/// The MPU's regions as they stand while the image runs; the model enforces those that nobody may
/// touch, and no others.
#[test]
fn the_code_of_the_tick_is_read_only_and_null_is_nobodys() {
    let Some(elf) = image() else { return };
    let mut machine = booted(&elf);
    machine.run(50 * MILLISECOND);
    assert_eq!(machine.chip.scs.mpu_control, 0b101);
    let regions = machine.chip.scs.mpu;
    // 1 and 16 KiB of ITCM: AP 110, XN 0, no eighth left out (Armv7-M B3.5.9).
    for (base, bits) in [(0xbc00, 10), (0xc000, 14)] {
        let code = regions.iter().find(|region| region.base == base).unwrap();
        let (execute_never, access, eighths, size) =
            (code.attributes >> 28 & 1, code.attributes >> 24 & 7, code.attributes >> 8 & 0xff, code.attributes & 0x3f);
        assert_eq!((execute_never, access, eighths, size), (0, 0b110, 0, (bits - 1) << 1 | 1), "{base:#x}");
    }
    // 512 MiB each outside the chip, AP 000, XN 1.
    for base in [0x6000_0000, 0x8000_0000] {
        let outside = regions.iter().find(|region| region.base == base).unwrap();
        assert_eq!(outside.attributes, 1 << 28 | 28 << 1 | 1, "{base:#x}");
    }
    let tick = h743::image::symbol(&elf, "TIM2").unwrap();
    assert!((0xbc00..0x1_0000).contains(&tick), "{tick:#x}");
    while machine.running() != 0 {
        machine.run(1);
    }
    // `ldr r0, [r1]`, and `b .` after it.
    assert!(machine.chip.memory.load(SCRATCH_ADDRESS, &0xe7fe_6808u32.to_le_bytes()));
    machine.set_register(Register::R(1), 0x1fc);
    machine.set_register(Register::Pc, SCRATCH_ADDRESS | 1);
    assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
    machine.run(100 * MILLISECOND);
    let (fault, text) = last_fault(machine);
    assert!(fault == 2 && text.contains("hard fault at 0x24000000"), "{text}");
}

fn link_pin() -> Pin {
    Pin::named("PD8").unwrap()
}

fn is_active_high(pin: Pin) -> bool {
    !is_of_dac(pin) && !REST_HIGH.into_iter().any(|name| Pin::named(name) == Some(pin))
}

#[test]
fn a_fault_rests_the_outputs_first_and_keeps_its_reason() {
    let Some(elf) = image() else { return };
    let (client, machine) = linked(&elf);
    client.call(AxisOn { core: 1.into(), axis: 1.into() }).unwrap();
    let enable = Pin::named("PG0").unwrap();
    let mut machine = lock(&machine);
    machine.run(MILLISECOND);
    assert_eq!(machine.chip.bus.gpio.level(enable), Level::Driven(true));
    // An interrupt without a handler (100) ends as every panic and fault does.
    let exceptions = &mut machine.chip.scs.exceptions;
    exceptions.enabled.set(116, true);
    exceptions.pending.set(116, true);
    let before = machine.chip.now;
    assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
    let rest = machine.chip.bus.gpio.changes.iter().rev().find(|change| change.pin == enable).unwrap();
    assert_eq!(rest.level, Level::Floating);
    assert!(rest.at < machine.resets[0].0 && rest.at - before < 10 * MICROSECOND, "{rest:?}, {:?}", machine.resets);
    let kept = h743::image::symbol(&elf, "KEPT").unwrap();
    let kept = machine.chip.memory.bytes(kept, 172).unwrap();
    assert!(String::from_utf8_lossy(&kept).contains("interrupt 100 without a handler"));
    // After the restart it is low.
    machine.run(100 * MILLISECOND);
    assert_eq!(machine.chip.bus.gpio.level(enable), Level::Driven(false));
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}
