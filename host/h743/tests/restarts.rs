//! Power-on in every order, resets of every kind under light with a host that continues to send,
//! and a link that is cut anywhere in a job, in the image that BEAMTICK_H743_IMAGE names. The pins
//! are dark, nothing is executed twice, and the next session gets the reason.
//!
//! The order of cases is that of the emulated board's tests
//! (`host-tests/tests/emulated_faults.rs`). Here the pins are checked in every instant: each change
//! of one is recorded.
mod road;

use client::{Client, Options};
use h743::dac8563;
use h743::engine::Register;
use h743::link::{Shared, lock};
use h743::{Cause, Level, MILLISECOND, Machine, Pin, Stop, Time};
use protocol::command::*;
use road::{Road, send_unanswered};
use std::sync::{Arc, Mutex};

/// The image, if there is one.
fn image() -> Option<Vec<u8>> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return None;
    };
    Some(std::fs::read(path).unwrap())
}

fn pin(name: &str) -> Pin {
    Pin::named(name).unwrap()
}

const INTERLOCK: [&str; 3] = ["PE15", "PE3", "PG2"];

/// Outputs (docs/board-h743.md): those of lasers that rest high, and all that rest low.
const REST_HIGH: [&str; 4] = ["PE9", "PE5", "PC7", "PC8"];
const REST_LOW: [&str; 34] = [
    "PE8", "PE4", "PB0", "PB15", "PF0", "PF1", "PF2", "PF3", "PF4", "PF5", "PF6", "PF7", "PF8", "PF9", "PF10", "PF11",
    "PF12", "PF13", "PF14", "PF15", "PG0", "PG1", "PG3", "PG4", "PG5", "PG6", "PG8", "PG9", "PE1", "PB14", "PG10",
    "PG12", "PG14", "PG15",
];
/// The laser's among them.
const LIGHT: [&str; 8] = ["PE9", "PE5", "PC7", "PC8", "PE8", "PE4", "PB0", "PB15"];
/// 0 V after the stage of an analog output.
const ZERO: u16 = 2048;

/// What the analog outputs show, in 4096ths: those of DAC1, or those of an external one.
fn voltages(machine: &Machine) -> Vec<(Time, usize, u16)> {
    let of_chip = machine.chip.bus.dac.changes.iter().filter_map(|&(at, of, value)| Some((at, of, value?)));
    let external = dac8563::shown(&machine.chip, pin("PC11")).into_iter().map(|(at, of, code)| (at, of, code >> 4));
    of_chip.chain(external).collect()
}

/// What left its rest since then, with its instant: outputs by their names, analog outputs by their
/// values.
fn active(machine: &Machine, since: Time, names: &[&str]) -> Vec<(Time, String)> {
    let bus = &machine.chip.bus;
    let mut found = Vec::new();
    for name in names {
        let (of, away) = (pin(name), Level::Driven(!REST_HIGH.contains(name)));
        let changes = bus.gpio.changes.iter().filter(|change| change.pin == of && change.level == away);
        found.extend(changes.filter(|change| change.at >= since).map(|change| (change.at, (*name).to_string())));
        if bus.gpio.level(of) == away {
            found.push((machine.chip.now, format!("{name}, still")));
        }
    }
    let volts = voltages(machine).into_iter().filter(|&(at, _, value)| at >= since && value != ZERO);
    found.extend(volts.map(|(at, of, value)| (at, format!("analog output {of}: {value:?}"))));
    found
}

fn active_outputs(machine: &Machine, since: Time) -> Vec<(Time, String)> {
    active(machine, since, &[&REST_HIGH[..], &REST_LOW].concat())
}

fn interlock(machine: &Shared, open: bool) {
    INTERLOCK.iter().for_each(|name| lock(machine).drive(pin(name), Some(open)));
}

/// A board that has just got its power.
fn powered(elf: &[u8], open: bool) -> Shared {
    let mut machine = Machine::new().unwrap();
    machine.boot(elf).unwrap();
    let machine: Shared = Arc::new(Mutex::new(machine));
    interlock(&machine, open);
    machine
}

fn open(machine: &Shared) -> Client {
    Client::open(Box::new(Road::to(machine)), Options::default()).unwrap()
}

fn pass(machine: &Shared, time: Time) {
    assert_eq!(lock(machine).run(time), Stop::Time);
}

fn state(client: &Client, channel: i16) -> LaserState {
    client.call(LaserStatus { core: 1.into(), channel: channel.into() }).unwrap()
}

fn fault(client: &Client, channel: i16) -> i16 {
    client.call(GetLaserFault { core: 1.into(), channel: channel.into() }).unwrap().value.get()
}

/// What ended the last run: the kind and the text.
fn reason(client: &Client) -> (u8, String) {
    let (fault, text) = client.call_items(GetFault {}, &[]).unwrap();
    (fault.kind, text.iter().map(|byte| char::from(byte.value)).collect())
}

/// Both channels shine, the second one by its voltage; an axis is enabled and steps. All of it is
/// seen at the pins.
fn shine(client: &Client, machine: &Shared) {
    let (core, channel) = (1.into(), 0.into());
    client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    client.call(LaserOutFrq { core, frequency: 20.0.into(), channel }).unwrap();
    client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    client.call(LaserOn { core, channel }).unwrap();
    let (channel, max, min) = (1.into(), 10.0.into(), 0.0.into());
    client.call(LaserPowerMode { core, mode: 2.into(), max, min, channel, delay_mode: 0.into() }).unwrap();
    client.call(LaserPrfCmd { core, power: 4.0.into(), channel }).unwrap();
    client.call(LaserOn { core, channel }).unwrap();
    client.call(AxisOn { core, axis: 1.into() }).unwrap();
    client.call(PrfJog { core, profile: 1.into() }).unwrap();
    let (acc, dec, smooth) = (10.0.into(), 10.0.into(), 0.0.into());
    client.call(SetJogPrm { core, profile: 1.into(), acc, dec, smooth }).unwrap();
    client.call(SetVel { core, profile: 1.into(), vel: 20.0.into() }).unwrap();
    client.call(Update { core, mask: 1.into() }).unwrap();
    pass(machine, 4 * MILLISECOND);
    let machine = lock(machine);
    let seen = active_outputs(&machine, machine.chip.now - MILLISECOND);
    for what in ["PE9", "PE8", "PC7", "PB0", "PC8", "PB15", "PF8", "PG0"] {
        assert!(seen.iter().any(|(_, name)| name.starts_with(what)), "{what} is at rest: {seen:?}");
    }
    assert!(voltages(&machine).iter().any(|&(_, of, value)| of == 1 && value > ZERO), "no voltage");
}

/// Each channel, dark for this cause, stays so until it is cleared, and then until it is lit.
fn assert_dark_until_cleared(client: &Client, cause: i16) {
    for channel in 0..2 {
        let now = state(client, channel);
        assert_eq!((now.fault.get(), now.light, now.gate), (cause, 0, 0), "channel {channel}");
        let (core, channel) = (1.into(), channel.into());
        assert!(client.call(LaserOn { core, channel }).is_err(), "an on command is taken");
        client.call(ClrLaserFault { core, channel }).unwrap();
    }
    for channel in 0..2 {
        assert_eq!((fault(client, channel), state(client, channel).light), (0, 0), "light comes back by itself");
    }
}

#[test]
fn power_on_in_every_order_is_dark_and_then_works() {
    let Some(elf) = image() else { return };
    // The host waits for the board already, comes soon, or later than the link-loss time; the
    // interlock's circuit is open or closed.
    for (host_after, opened) in [(0, false), (0, true), (60, false), (60, true), (520, false)] {
        let case = format!("host after {host_after} ms, interlock open: {opened}");
        let machine = powered(&elf, opened);
        pass(&machine, host_after * MILLISECOND);
        let client = open(&machine);
        pass(&machine, 5 * MILLISECOND);
        assert_eq!(active_outputs(&lock(&machine), 0), [], "{case}");
        assert_eq!(reason(&client), (0, String::new()), "{case}");
        if opened {
            assert_eq!((fault(&client, 0), fault(&client, 1)), (1, 1), "{case}");
            let clear = ClrLaserFault { core: 1.into(), channel: 0.into() };
            assert!(client.call(clear).is_err(), "{case}: cleared with its cause there");
            interlock(&machine, false);
            pass(&machine, MILLISECOND);
            assert_dark_until_cleared(&client, 1);
        }
        assert_eq!((fault(&client, 0), fault(&client, 1)), (0, 0), "{case}");
        assert_eq!(active_outputs(&lock(&machine), 0), [], "{case}");
        shine(&client, &machine);
        assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new(), "{case}");
    }
}

/// What ends a run.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// TIM2 loses its clock: no tick comes any more.
    Watchdog,
    /// An interrupt without a handler comes.
    Fault,
    /// A debugger, by AIRCR.
    Debugger,
    /// The button.
    Button,
    /// The same, and the interlock's circuit opens while the board starts.
    ButtonAndInterlock,
}

/// Provokes it; returns when the board was reset.
fn end(machine: &Shared, how: End) -> Time {
    let mut machine = lock(machine);
    let chip = &mut machine.chip;
    let stop = match how {
        End::Watchdog => {
            let at = chip.now;
            chip.bus.write(0x4000_0000, 0, u32::MAX, at, &mut chip.scs.exceptions).unwrap();
            machine.run(200 * MILLISECOND)
        }
        End::Fault => {
            let exceptions = &mut chip.scs.exceptions;
            exceptions.enabled.set(116, true);
            exceptions.pending.set(116, true);
            machine.run(MILLISECOND)
        }
        End::Debugger => {
            chip.scs.wants_reset = true;
            machine.run(MILLISECOND)
        }
        End::Button | End::ButtonAndInterlock => {
            machine.reset(Cause::Pin);
            Stop::Reset(Cause::Pin)
        }
    };
    assert!(matches!(stop, Stop::Reset(_)), "{how:?}: {stop:?}");
    machine.resets[0].0
}

#[test]
fn no_reset_under_light_and_a_sending_host_lights_or_moves_anything() {
    let Some(elf) = image() else { return };
    // The kind that GetFault reports, the cause that keeps the lasers dark.
    for (how, kind, cause) in [
        (End::Watchdog, 4, 4),
        (End::Fault, 3, 4),
        (End::Debugger, 0, 0),
        (End::Button, 0, 0),
        (End::ButtonAndInterlock, 0, 1),
    ] {
        let machine = powered(&elf, false);
        pass(&machine, 20 * MILLISECOND);
        let road = Road::to(&machine);
        let (sent, left) = (Arc::clone(&road.sent), Arc::clone(&road.left));
        let client = Client::open(Box::new(road), Options::default()).unwrap();
        sent.lock().unwrap().clear();
        shine(&client, &machine);
        *left.lock().unwrap() = 0;
        // All commands of the session, on and on, before the end and after it.
        let stale = std::mem::take(&mut *sent.lock().unwrap());
        drop(client);
        let lasts = if how == End::Watchdog { 140 } else { 40 };
        let times = lasts * BYTES_A_MS / stale.len();
        lock(&machine).send(&stale.repeat(times));
        pass(&machine, 2 * MILLISECOND);
        let reset = end(&machine, how);
        if how == End::ButtonAndInterlock {
            interlock(&machine, true);
        }
        pass(&machine, 60 * MILLISECOND);
        assert_eq!(lock(&machine).chip.bus.usart.in_transit(), 0);
        assert_eq!(active_outputs(&lock(&machine), reset), [], "{how:?}: behind the reset");

        let client = open(&machine);
        let reported = reason(&client);
        assert_eq!(reported.0, kind, "{how:?}: {reported:?}");
        assert_eq!(reported.1.is_empty(), kind == 0, "{how:?}: {reported:?}");
        let place = client.call_items(GetPrfPos { core: 1.into(), profile: 1.into(), count: 1.into() }, &[]).unwrap();
        assert_eq!(place.1[0].value.get(), 0.0, "{how:?}: what came from before the reset was executed");
        if how == End::ButtonAndInterlock {
            interlock(&machine, false);
            pass(&machine, MILLISECOND);
        }
        assert_eq!((fault(&client, 0), fault(&client, 1)), (cause, cause), "{how:?}");
        if cause != 0 {
            assert_dark_until_cleared(&client, cause);
        }
        assert_eq!(active_outputs(&lock(&machine), reset), [], "{how:?}: behind the reset");
        shine(&client, &machine);
        let machine = lock(&machine);
        assert_eq!(machine.resets.len(), 1, "{how:?}");
        assert_eq!(machine.chip.bus.complaints, Vec::<String>::new(), "{how:?}");
    }
}

/// The line at 3 Mbaud.
const BYTES_A_MS: usize = 300;

/// The commands of a job, whatever becomes of each: a way of so many pulses, and light. True if the
/// on command was answered.
fn job(client: &Client) -> bool {
    let (core, channel, profile) = (1.into(), 0.into(), 1.into());
    // If any of this is executed a second time, there is light again, or another way.
    let _ = client.call(ClrLaserFault { core, channel });
    let _ = client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() });
    let _ = client.call(AxisOn { core, axis: 1.into() });
    let _ = client.call(PrfPt { core, profile, mode: 0.into() });
    let (pos, kind, fifo) = (f64::from(WAY).into(), 0.into(), 0.into());
    let _ = client.call(PtData { core, profile, pos, time_ms: WAY_MS.into(), kind, fifo });
    let _ = client.call(PtStart { core, mask: 1.into(), option: 0.into() });
    let _ = client.call(LaserOutFrq { core, frequency: 20.0.into(), channel });
    let _ = client.call(LaserPrfCmd { core, power: 50.0.into(), channel });
    let lit = client.call(LaserOn { core, channel }).is_ok();
    let _ = client.call(LaserPrfCmd { core, power: 60.0.into(), channel });
    lit
}

const WAY: i32 = 100;
const WAY_MS: i32 = 4;
/// The link-loss time of the cuts.
const LOSS_MS: i32 = 10;

/// Steps forwards of axis 1 since then.
fn steps(machine: &Machine, since: Time) -> i32 {
    let step = pin("PF8");
    let high = machine.chip.bus.gpio.changes.iter().rev().take_while(|change| change.at > since);
    high.filter(|change| change.pin == step && change.level == Level::Driven(true)).count() as i32
}

/// Opens a session over a road that is cut after so many bytes of the job; returns what went over
/// it.
fn cut_job(machine: &Shared, bytes: usize) -> (bool, Vec<u8>) {
    let road = Road::to(machine);
    let (sent, left) = (Arc::clone(&road.sent), Arc::clone(&road.left));
    let client = Client::open(Box::new(road), Options::default()).unwrap();
    client.call(SetLinkLoss { time_ms: LOSS_MS.into(), stop_all: 0.into() }).unwrap();
    sent.lock().unwrap().clear();
    *left.lock().unwrap() = bytes;
    let lit = job(&client);
    drop(client);
    let sent = sent.lock().unwrap().clone();
    (lit, sent)
}

/// Causes that keep a laser dark, and kinds of events (docs/laser.md, docs/protocol.md).
const LINK_LOST: i16 = 2;
const LASER_EVENT: u8 = 3;
const LINK_EVENT: u8 = 4;

/// A frame ends with a zero. Cut within some frames and after them; with BEAMTICK_EVERY_BYTE set,
/// after every byte.
#[test]
fn a_link_that_is_cut_anywhere_in_a_job_ends_dark_and_nothing_is_done_twice() {
    let Some(elf) = image() else { return };
    let machine = powered(&elf, false);
    pass(&machine, 20 * MILLISECOND);
    let (lit, sent) = cut_job(&machine, usize::MAX);
    assert!(lit);
    let ends: Vec<usize> = (1..=sent.len()).filter(|&n| sent[n - 1] == 0).collect();
    assert!(ends.len() >= 10, "a frame a command: {sent:?}");
    let cuts: Vec<usize> = if std::env::var_os("BEAMTICK_EVERY_BYTE").is_some() {
        (0..=sent.len()).collect()
    } else {
        // The last frame tells nothing more than the one before.
        ends.iter().enumerate().map(|(n, &end)| if n % 2 == 0 { end - 3 } else { end }).rev().skip(1).collect()
    };
    let (mut dark, mut never, mut ways) = (0, 0, 0);
    for &cut in &cuts {
        let client = open(&machine);
        client.call(Reset { core: 1.into() }).unwrap();
        pass(&machine, MILLISECOND);
        assert_eq!((fault(&client, 0), state(&client, 0).light), (0, 0));
        let seen = client.call_items(GetEvents {}, &[]).unwrap().0.total.get();
        drop(client);
        let begin = lock(&machine).chip.now;
        let (answered, passed) = cut_job(&machine, cut);
        pass(&machine, (LOSS_MS as Time + 2) * MILLISECOND);
        let late = lock(&machine).chip.now;
        pass(&machine, 2 * MILLISECOND);
        assert_eq!(active(&lock(&machine), late, &LIGHT), [], "cut after {cut} bytes: light without a link");
        let was_lit = !active(&lock(&machine), begin, &LIGHT).is_empty();
        let way = steps(&lock(&machine), begin);
        // The same bytes again, as a line may repeat them: they belong to the same session.
        lock(&machine).send(&passed);
        pass(&machine, (WAY_MS as Time + 2) * MILLISECOND);
        assert_eq!(active(&lock(&machine), late, &LIGHT), [], "cut after {cut} bytes: commands are executed twice");
        assert!(way == 0 || way == WAY, "cut after {cut} bytes: {way} steps");
        assert_eq!(steps(&lock(&machine), begin), way, "cut after {cut} bytes: commands are executed twice");
        ways += i32::from(way == WAY);

        let client = open(&machine);
        let now = state(&client, 0);
        assert_eq!((now.light, now.gate), (0, 0), "cut after {cut} bytes");
        let place = client.call_items(GetPrfPos { core: 1.into(), profile: 1.into(), count: 1.into() }, &[]).unwrap();
        assert_eq!(place.1[0].value.get(), f64::from(way), "cut after {cut} bytes");
        let (total, events) = client.call_items(GetEvents {}, &[]).unwrap();
        let new = events.len().min((total.total.get() - seen) as usize);
        let new: Vec<_> = events[events.len() - new..].iter().map(|event| (event.kind, event.reason.get())).collect();
        assert!(new.contains(&(LINK_EVENT, 1)), "cut after {cut} bytes: the link was lost: {new:?}");
        match now.fault.get() {
            // The on command came through, and the lost link shut off its light.
            LINK_LOST => {
                assert!(was_lit && new.contains(&(LASER_EVENT, LINK_LOST as u16)), "cut after {cut} bytes: {new:?}");
                dark += 1;
            }
            // It did not, and nobody reported that it did.
            0 => {
                assert!(!was_lit && !answered && now.commanded == 0, "cut after {cut} bytes");
                never += 1;
            }
            other => panic!("cut after {cut} bytes: cause {other}"),
        }
        assert_eq!(reason(&client).0, 0, "cut after {cut} bytes: it started over");
    }
    println!(
        "{} cuts in {} bytes: {dark} shut light off, {never} before light, {ways} after the start",
        cuts.len(),
        sent.len()
    );
    assert!(dark > 0 && never > 0 && ways > 0 && ways < cuts.len() as i32);
    let machine = lock(&machine);
    assert_eq!((machine.resets.len(), &machine.chip.bus.complaints), (0, &Vec::<String>::new()));
}

/// The loop opens and closes between the tick's reading of it and a start of light: from when light
/// is about to be enabled, after so many steps of the core.
#[test]
fn a_loop_that_opens_and_closes_as_light_starts_keeps_it_dark() {
    let Some(elf) = image() else { return };
    let revive = h743::image::symbol(&elf, "laser6revive").unwrap() & !1;
    let (mut early, mut lit) = (0, 0);
    for after in (0..40).step_by(4) {
        let machine = powered(&elf, false);
        pass(&machine, 20 * MILLISECOND);
        let road = Road::to(&machine);
        let (sent, left) = (Arc::clone(&road.sent), Arc::clone(&road.left));
        let client = Client::open(Box::new(road), Options::default()).unwrap();
        let (core, channel) = (1.into(), 0.into());
        client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
        client.call(LaserOutFrq { core, frequency: 20.0.into(), channel }).unwrap();
        client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
        let switch = |on: u16| client.call(SetHSIOOpt { core, value: on.into(), channel }).map(|_| ());
        send_unanswered((&sent, &left), || switch(0), || switch(1));
        let begin = lock(&machine).chip.now;
        {
            let mut machine = lock(&machine);
            while machine.register(Register::Pc) & !1 != revive {
                assert_eq!(machine.run(1), Stop::Time);
                assert!(machine.chip.now < begin + MILLISECOND, "light is never enabled");
            }
            for _ in 0..after {
                assert_eq!(machine.run(2), Stop::Time);
            }
            lit += u32::from(machine.chip.bus.timer(1).unwrap().is_enabled());
        }
        interlock(&machine, true);
        interlock(&machine, false);
        pass(&machine, 5 * MILLISECOND);
        assert_eq!(active(&lock(&machine), begin, &REST_HIGH), [], "after {after} steps");
        // A break before the flags are read: nothing is enabled at all. What is disabled again
        // shows for two counts at − lines.
        if after == 0 {
            assert_eq!(active(&lock(&machine), begin, &LIGHT), [], "the outputs were enabled for an instant");
        }
        drop(client);
        let client = open(&machine);
        assert_eq!((fault(&client, 0), fault(&client, 1)), (1, 1), "after {after} steps");
        early += 1;
    }
    // Some before the timers are enabled, some after.
    assert!(lit > 0 && lit < early, "{lit} of {early}");
}
