//! What ends light on the emulated board: the interlock, a fault, a tick that stands still; where
//! BEAMTICK_H743_IMAGE names the image.
use client::{Client, Options};
use h743::link::{EmulatedLink, Plug, Shared, lock};
use h743::{Cause, Level, MICROSECOND, MILLISECOND, Machine, Pin, Stop, Time};
use protocol::command::{ClrLaserFault, GetFault, GetLaserFault, LaserOutFrq, LaserPrfCmd, SetAxisMode, SetHSIOOpt};
use std::sync::{Arc, Mutex};

/// Energy and switch of laser 0: the + line, which is low while it is active, and the − line.
const LINES: [(&str, &str); 2] = [("PE9", "PE8"), ("PC7", "PB0")];
const INTERLOCK: [&str; 3] = ["PE15", "PE3", "PG2"];

fn pin(name: &str) -> Pin {
    Pin::named(name).unwrap()
}

/// The board with laser 0 on: 10 kHz, half of the time light. `None` without an image.
fn lit() -> Option<(Client, Plug, Shared)> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    INTERLOCK.iter().for_each(|name| machine.drive(pin(name), Some(false)));
    machine.run(20 * MILLISECOND);
    let machine: Shared = Arc::new(Mutex::new(machine));
    let link = EmulatedLink::new(machine.clone());
    let plug = link.plug();
    let client = Client::open(Box::new(link), Options::default()).unwrap();
    let (core, channel) = (1.into(), 0.into());
    client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    client.call(LaserOutFrq { core, frequency: 10.0.into(), channel }).unwrap();
    client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    light(&client, true);
    into_a_pulse(&machine);
    Some((client, plug, machine))
}

fn light(client: &Client, on: bool) {
    client.call(SetHSIOOpt { core: 1.into(), value: u16::from(on).into(), channel: 0.into() }).unwrap();
}

/// Lets time pass until a pulse has lasted for some µs.
fn into_a_pulse(machine: &Shared) {
    let mut machine = lock(machine);
    let active = |machine: &Machine| machine.chip.bus.gpio.level(pin("PE9")) == Level::Driven(false);
    let end = machine.chip.now + 10 * MILLISECOND;
    while active(&machine) {
        machine.run(MICROSECOND);
        assert!(machine.chip.now < end, "light that never ends");
    }
    while !active(&machine) {
        machine.run(MICROSECOND);
        assert!(machine.chip.now < end, "no light");
    }
    machine.run(7 * MICROSECOND);
    assert!(active(&machine), "50 us of light");
}

/// When a line of laser 0 became active last, if it did since.
fn last_light(machine: &Machine, since: Time) -> Option<Time> {
    let is_light = |change: &h743::gpio::Change| {
        let of = |&(plus, minus): &(&str, &str)| {
            change.pin == pin(plus) && change.level == Level::Driven(false)
                || change.pin == pin(minus) && change.level == Level::Driven(true)
        };
        LINES.iter().any(of)
    };
    machine.chip.bus.gpio.changes.iter().rev().find(|change| is_light(change)).map(|c| c.at).filter(|&at| at > since)
}

/// The + lines are at rest.
fn assert_plus_rests(machine: &Machine) {
    for (plus, _) in LINES {
        assert_eq!(machine.chip.bus.gpio.level(pin(plus)), Level::Driven(true), "{plus}");
    }
}

/// A break at this instant, in a pulse, has left the − lines lit for two counts of their timers,
/// and no longer.
fn assert_minus_rested(machine: &Machine, at: Time) {
    const TWO_COUNTS: Time = 8;
    for (_, minus) in LINES {
        let rested = |change: &&h743::gpio::Change| change.pin == pin(minus) && change.level == Level::Driven(false);
        let first = machine.chip.bus.gpio.changes.iter().filter(|change| change.at >= at).find(rested);
        assert_eq!(first.map(|change| change.at), Some(at + TWO_COUNTS), "{minus}");
    }
}

#[test]
fn the_interlock_ends_a_pulse_without_an_instruction() {
    let Some((client, _, shared)) = lit() else { return };
    let fault = || client.call(GetLaserFault { core: 1.into(), channel: 0.into() }).unwrap().value.get();
    assert_eq!(fault(), 0);
    into_a_pulse(&shared);
    let at = {
        let mut machine = lock(&shared);
        let (now, instructions) = (machine.chip.now, machine.chip.instructions);
        INTERLOCK.iter().for_each(|name| machine.drive(pin(name), Some(true)));
        assert_eq!((machine.chip.now, machine.chip.instructions), (now, instructions));
        assert_plus_rests(&machine);
        machine.run(20 * MILLISECOND);
        assert_minus_rested(&machine, now);
        assert_eq!(last_light(&machine, now), None);
        now
    };
    assert_eq!(fault(), 1);
    INTERLOCK.iter().for_each(|name| lock(&shared).drive(pin(name), Some(false)));
    lock(&shared).run(20 * MILLISECOND);
    assert_eq!(last_light(&lock(&shared), at), None, "light comes back by itself");
    client.call(ClrLaserFault { core: 1.into(), channel: 0.into() }).unwrap();
    light(&client, true);
    into_a_pulse(&shared);
    assert_eq!(lock(&shared).chip.bus.complaints, Vec::<String>::new());
}

#[test]
fn a_clock_that_stops_ends_a_pulse_without_an_instruction_and_is_reported() {
    let Some((client, plug, shared)) = lit() else { return };
    plug.pull();
    drop(client);
    let now = {
        let mut machine = lock(&shared);
        let (now, instructions) = (machine.chip.now, machine.chip.instructions);
        machine.give_clock(false);
        assert_eq!((machine.chip.now, machine.chip.instructions), (now, instructions));
        assert_plus_rests(&machine);
        assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
        assert_minus_rested(&machine, now);
        assert_eq!(machine.run(300 * MILLISECOND), Stop::Time);
        machine.give_clock(true);
        assert_eq!(machine.run(50 * MILLISECOND), Stop::Time);
        now
    };
    let client = Client::open(Box::new(EmulatedLink::new(shared.clone())), Options::default()).unwrap();
    let (fault, text) = client.call_items(GetFault {}, &[]).unwrap();
    let text: String = text.iter().map(|byte| char::from(byte.value)).collect();
    assert_eq!((fault.kind, &*text), (3, "the ST-LINK's clock has stopped"));
    assert_eq!(last_light(&lock(&shared), now), None);
    assert_eq!(lock(&shared).chip.bus.complaints, Vec::<String>::new());
}

#[test]
fn a_fault_shuts_off_the_light_at_once() {
    let Some((client, plug, shared)) = lit() else { return };
    plug.pull();
    drop(client);
    let mut machine = lock(&shared);
    // An interrupt without a handler.
    let exceptions = &mut machine.chip.scs.exceptions;
    exceptions.enabled.set(116, true);
    exceptions.pending.set(116, true);
    let at = machine.chip.now;
    assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
    let energy = pin("PE9");
    let end = machine.chip.bus.gpio.changes.iter().find(|c| c.at > at && c.pin == energy).unwrap();
    assert_ne!(end.level, Level::Driven(false));
    assert!(end.at - at < 10 * MICROSECOND, "the pulse goes on for {} units", end.at - at);
    let at = end.at;
    machine.run(200 * MILLISECOND);
    assert_eq!(last_light(&machine, at), None);
}

#[test]
fn light_does_not_outlive_the_tick() {
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
    println!("the last pulse begins {} us behind the last tick", (last - at) / MICROSECOND);
    assert!(last - at <= LAST, "{} us", (last - at) / MICROSECOND);
    let reset = machine.resets[0].0;
    machine.run(200 * MILLISECOND);
    assert_eq!(last_light(&machine, reset), None);
}

/// Two ticks of 50 us are reported, and a third may have begun.
const LAST: Time = 150 * MICROSECOND;
