//! Facts of the chip on which sources differ, or which no source promises: what the image does
//! where they are otherwise. Where BEAMTICK_H743_IMAGE names it.
use client::{Client, Options};
use h743::engine::Register;
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{Cause, Level, MICROSECOND, MILLISECOND, Machine, Pin, Stop};
use protocol::command::{
    ClrLaserFault, GetAdc, GetEvents, GetFault, GetLaserFault, GetStack, GetTickTime, LaserOn, LaserOutFrq,
    LaserPrfCmd, LaserStatus, Reset, SetAxisMode, SetHSIOOpt, SetTick,
};
use std::sync::{Arc, Mutex};

/// Timers of the lasers, and the inputs that break them.
const BREAKS: [(u8, &str); 3] = [(1, "PE15"), (15, "PE3"), (8, "PG2")];

/// The board after start-up; `before` sets what is otherwise. `None` without an image.
fn started(before: impl FnOnce(&mut Machine)) -> Option<Machine> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    BREAKS.iter().for_each(|(_, name)| machine.drive(Pin::named(name).unwrap(), Some(false)));
    before(&mut machine);
    assert_eq!(machine.run(20 * MILLISECOND), Stop::Time);
    Some(machine)
}

fn linked(machine: Machine) -> (Client, Shared) {
    let shared: Shared = Arc::new(Mutex::new(machine));
    let client = Client::open(Box::new(EmulatedLink::new(shared.clone())), Options::default()).unwrap();
    (client, shared)
}

fn fault(client: &Client) -> (u8, String) {
    let (reply, text) = client.call_items(GetFault {}, &[]).unwrap();
    (reply.kind, text.iter().map(|byte| char::from(byte.value)).collect())
}

fn cause(client: &Client, channel: i16) -> i16 {
    client.call(GetLaserFault { core: 1.into(), channel: channel.into() }).unwrap().value.get()
}

#[test]
fn a_break_that_is_not_its_pins_is_reported_and_there_is_no_light() {
    for (number, name) in BREAKS {
        for open in [false, true] {
            let Some(machine) = started(|machine| {
                machine.chip.bus.timer(number).unwrap().is_odd = true;
                machine.drive(Pin::named(name).unwrap(), Some(open));
            }) else {
                return;
            };
            let (client, shared) = linked(machine);
            let reported = if open {
                format!("TIM{number} does not break although its input {name} is high")
            } else {
                format!("TIM{number} breaks although its input {name} is low")
            };
            assert_eq!(fault(&client), (5, reported));
            // Closing the circuit and clearing does not help.
            BREAKS.iter().for_each(|(_, name)| lock(&shared).drive(Pin::named(name).unwrap(), Some(false)));
            for channel in 0..2 {
                assert_eq!(cause(&client, channel), 1, "TIM{number}, {name} {open}");
                assert!(client.call(LaserOn { core: 1.into(), channel: channel.into() }).is_err());
            }
        }
    }
}

#[test]
fn a_board_that_is_as_it_should_be_says_nothing_of_its_breaks() {
    for open in [false, true] {
        let Some(machine) = started(|machine| {
            BREAKS.iter().for_each(|(_, name)| machine.drive(Pin::named(name).unwrap(), Some(open)));
        }) else {
            return;
        };
        let (client, _shared) = linked(machine);
        assert_eq!(fault(&client), (0, String::new()));
        assert_eq!(cause(&client, 0), i16::from(open));
    }
}

#[test]
fn a_converter_that_is_switched_on_too_early_is_switched_on_again() {
    let Some(mut machine) = started(|machine| machine.chip.bus.adc.withdraws = 3) else { return };
    let at = machine.chip.now;
    // At A2: 0 to 3.3 V stand for −12.5 to 12.5 V.
    machine.chip.bus.adc.apply(1, 0.75 * 3.3, at);
    machine.run(30 * MILLISECOND);
    assert_eq!(machine.chip.bus.adc.withdraws, 0);
    let (client, _shared) = linked(machine);
    let (_, values) = client.call_items(GetAdc { core: 1.into(), adc: 1.into(), count: 1.into() }, &[]).unwrap();
    assert!((values[0].value.get() - 6.25).abs() < 0.01, "{}", values[0].value.get());
}

#[test]
fn the_supply_and_a_locked_up_core_break_the_lasers_too() {
    let Some(mut machine) = started(|_| {}) else { return };
    let chip = &mut machine.chip;
    let now = chip.now;
    let cfgr = chip.bus.read(0x5800_0418, now, &mut chip.scs.exceptions);
    assert_eq!(cfgr, Some(1 << 2 | 1 << 6), "PVDL, CM7L");
    let cr1 = chip.bus.read(0x5802_4800, now, &mut chip.scs.exceptions).unwrap();
    assert_eq!((cr1 >> 4 & 1, cr1 >> 5 & 7), (1, 5), "PVDE, PLS");
}

/// Energy + of both lasers, low while lit.
const PLUS: [&str; 2] = ["PE9", "PE5"];

fn is_lit(machine: &Machine) -> [bool; 2] {
    PLUS.map(|name| machine.chip.bus.gpio.level(Pin::named(name).unwrap()) == Level::Driven(false))
}

/// Both lasers, 10 kHz, most of the time light: an instant at which both are lit.
fn lit() -> Option<(Client, Shared)> {
    let (client, shared) = linked(started(|_| {})?);
    for (axis, channel) in [(7, 0), (8, 1)] {
        let (core, channel) = (1.into(), channel.into());
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserOutFrq { core, frequency: 10.0.into(), channel }).unwrap();
        client.call(LaserPrfCmd { core, power: 80.0.into(), channel }).unwrap();
        client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    }
    {
        let mut machine = lock(&shared);
        let end = machine.chip.now + 10 * MILLISECOND;
        while is_lit(&machine) != [true; 2] {
            machine.run(7 * MICROSECOND);
            assert!(machine.chip.now < end, "light that does not begin");
        }
    }
    Some((client, shared))
}

#[test]
fn a_supply_that_falls_ends_light_without_an_instruction_and_it_stays_dark() {
    // Sources differ on the flag that a break of the chip sets.
    for one_flag in [false, true] {
        supply_falls(one_flag);
    }
}

fn supply_falls(one_flag: bool) {
    let Some((client, shared)) = lit() else { return };
    {
        let mut machine = lock(&shared);
        if one_flag {
            machine.plant(Wrong::OneFlag);
        }
        machine.supply(2800);
        assert_eq!(is_lit(&machine), [true; 2], "above 2.7 V");
        let (now, instructions) = (machine.chip.now, machine.chip.instructions);
        machine.supply(2600);
        assert_eq!((machine.chip.now, machine.chip.instructions), (now, instructions));
        assert_eq!(is_lit(&machine), [false; 2]);
        machine.run(2 * MILLISECOND);
        machine.supply(3300);
        let back = machine.chip.now;
        machine.run(5 * MILLISECOND);
        let plus = PLUS.map(|name| Pin::named(name).unwrap());
        let lit = machine
            .chip
            .bus
            .gpio
            .changes
            .iter()
            .any(|change| change.at >= back && plus.contains(&change.pin) && change.level == Level::Driven(false));
        assert!(!lit, "light comes back by itself");
    }
    // The reason is the interlock's, and none of the break inputs is blamed.
    assert_eq!((cause(&client, 0), cause(&client, 1)), (1, 1));
    assert_eq!(fault(&client), (0, String::new()));
    // Once it is cleared, light comes where it is asked for.
    client.call(ClrLaserFault { core: 1.into(), channel: 0.into() }).unwrap();
    client.call(SetHSIOOpt { core: 1.into(), value: 1.into(), channel: 0.into() }).unwrap();
    let mut machine = lock(&shared);
    let end = machine.chip.now + 2 * MILLISECOND;
    while !is_lit(&machine)[0] {
        machine.run(7 * MICROSECOND);
        assert!(machine.chip.now < end, "it stays dark for good");
    }
}

#[test]
fn a_supply_that_is_low_at_the_start_blames_no_wiring_and_hides_no_crash() {
    for one_flag in [false, true] {
        let Some(mut machine) = started(|machine| {
            if one_flag {
                machine.plant(Wrong::OneFlag);
            }
        }) else {
            return;
        };
        // A crash, and a supply that has not recovered as the board starts again.
        let exceptions = &mut machine.chip.scs.exceptions;
        exceptions.enabled.set(116, true);
        exceptions.pending.set(116, true);
        assert_eq!(machine.run(MILLISECOND), Stop::Reset(Cause::Software));
        machine.supply(2600);
        assert_eq!(machine.run(20 * MILLISECOND), Stop::Time);
        let (client, shared) = linked(machine);
        assert_eq!(fault(&client).0, 3, "{:?}", fault(&client));
        assert_ne!((cause(&client, 0), cause(&client, 1)), (0, 0));
        let clear = |channel: i16| client.call(ClrLaserFault { core: 1.into(), channel: channel.into() }).is_ok();
        assert!(!clear(0) && !clear(1), "cleared while the supply is low");
        lock(&shared).supply(3300);
        lock(&shared).run(MILLISECOND);
        assert!(clear(0) && clear(1));
        assert_eq!(fault(&client).0, 3);
    }
}

#[test]
fn a_core_that_is_locked_up_ends_light_without_an_instruction() {
    // The client waits for the machine meanwhile; at its end it would abort what runs.
    let Some((_client, shared)) = lit() else { return };
    let mut machine = lock(&shared);
    let end = machine.chip.now + 10 * MILLISECOND;
    while machine.running() != 0 || machine.waits() || is_lit(&machine) != [true; 2] {
        machine.run(1);
        assert!(machine.chip.now < end);
    }
    // At the priority of a HardFault an undefined instruction (UDF) has no handler.
    const SCRATCH_ADDRESS: u32 = 0x2400_0000;
    assert!(machine.chip.memory.load(SCRATCH_ADDRESS, &0xde00_de00u32.to_le_bytes()));
    machine.set_register(Register::Faultmask, 1);
    machine.set_register(Register::Pc, SCRATCH_ADDRESS | 1);
    assert_eq!(machine.run(MICROSECOND), Stop::Lockup);
    assert_eq!(is_lit(&machine), [false; 2]);
    let (instructions, locked) = (machine.chip.instructions, machine.chip.now);
    assert_eq!(machine.run(200 * MILLISECOND), Stop::Reset(Cause::Watchdog));
    assert_eq!(machine.chip.instructions, instructions);
    let plus = PLUS.map(|name| Pin::named(name).unwrap());
    let lit = machine
        .chip
        .bus
        .gpio
        .changes
        .iter()
        .any(|change| change.at > locked && plus.contains(&change.pin) && change.level == Level::Driven(false));
    assert!(!lit, "two ticks of light were queued");
}

/// Its loop was closed at the start, so that nothing contradicted it then.
#[test]
fn a_break_input_without_connection_is_found_when_the_loop_opens() {
    for (number, name) in BREAKS {
        let Some(machine) = started(|machine| machine.plant(Wrong::Unconnected(number))) else { return };
        let (client, shared) = linked(machine);
        assert_eq!(fault(&client), (0, String::new()));
        for (_, name) in BREAKS {
            lock(&shared).drive(Pin::named(name).unwrap(), Some(true));
        }
        lock(&shared).run(MILLISECOND);
        let reported = format!("TIM{number} does not break although its input {name} is high");
        assert_eq!(fault(&client), (5, reported.clone()));
        // Closing the circuit and clearing does not help.
        for (_, name) in BREAKS {
            lock(&shared).drive(Pin::named(name).unwrap(), Some(false));
        }
        lock(&shared).run(MILLISECOND);
        for channel in 0..2i16 {
            assert!(client.call(ClrLaserFault { core: 1.into(), channel: channel.into() }).is_err());
            assert!(client.call(LaserOn { core: 1.into(), channel: channel.into() }).is_err(), "TIM{number}");
            assert_eq!(cause(&client, channel), 1);
        }
        assert_eq!(fault(&client), (5, reported));
    }
}

/// One input is held at a level by a fault of the wiring: its timer does not see the loop.
#[test]
fn an_input_that_does_not_follow_the_loop_is_reported() {
    for (number, name) in BREAKS {
        for held in [false, true] {
            let Some(machine) = started(|_| {}) else { return };
            let (client, shared) = linked(machine);
            let levels = |of_others: bool| {
                let mut machine = lock(&shared);
                BREAKS.iter().for_each(|(_, name)| machine.drive(Pin::named(name).unwrap(), Some(of_others)));
                machine.drive(Pin::named(name).unwrap(), Some(held));
            };
            // As long as a contact bounces.
            levels(!held);
            lock(&shared).run(700 * MICROSECOND);
            BREAKS.iter().for_each(|(_, name)| lock(&shared).drive(Pin::named(name).unwrap(), Some(false)));
            lock(&shared).run(MILLISECOND);
            assert_eq!(fault(&client), (0, String::new()), "{name} {held}");
            levels(!held);
            lock(&shared).run(MILLISECOND);
            let reported = format!(
                "the interlock's input {name} of TIM{number} differs from the two others: wire all three together"
            );
            assert_eq!(fault(&client), (5, reported), "{name} {held}");
            // Closing the circuit and clearing does not help.
            BREAKS.iter().for_each(|(_, name)| lock(&shared).drive(Pin::named(name).unwrap(), Some(false)));
            lock(&shared).run(MILLISECOND);
            for channel in 0..2i16 {
                assert!(client.call(ClrLaserFault { core: 1.into(), channel: channel.into() }).is_err());
                assert_eq!(cause(&client, channel), 1);
            }
        }
    }
}

#[test]
fn a_break_without_its_pin_is_found_in_ticks_and_one_that_is_over_is_not() {
    for (number, name) in BREAKS {
        let Some(machine) = started(|_| {}) else { return };
        let (client, shared) = linked(machine);
        // A loop that bounces: each pulse ends before a tick reads it.
        for _ in 0..20 {
            let mut machine = lock(&shared);
            for open in [true, false] {
                BREAKS.iter().for_each(|(_, name)| machine.drive(Pin::named(name).unwrap(), Some(open)));
                machine.run(MICROSECOND);
            }
            machine.run(50 * MICROSECOND);
        }
        assert_eq!((fault(&client), cause(&client, 0)), ((0, String::new()), 1));
        // Its input is inverted from now on.
        lock(&shared).chip.bus.timer(number).unwrap().is_odd = true;
        lock(&shared).drive(Pin::named(name).unwrap(), Some(false));
        lock(&shared).run(MILLISECOND);
        assert_eq!(fault(&client), (5, format!("TIM{number} breaks although its input {name} is low")));
    }
}

const TIM1_DMAR: u32 = 0x4001_004c;
/// SR of TIM1, TIM15, TIM8.
const TIMERS_SR: [u32; 3] = [0x4001_0010, 0x4001_4010, 0x4001_0410];
const DMA1_S0CR: u32 = 0x4002_0010;
/// A kind of event: ticks that overran.
const OVERRUN: u8 = 5;

#[test]
fn timers_that_stopped_within_a_burst_begin_with_its_first_register() {
    let Some(machine) = started(|_| {}) else { return };
    let (client, shared) = linked(machine);
    let (core, channel) = (1.into(), 0.into());
    client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    client.call(LaserOutFrq { core, frequency: 10.0.into(), channel }).unwrap();
    client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    lock(&shared).run(5 * MILLISECOND);
    // The stream ends, with one transfer of a burst done; a tick finds that out.
    {
        let mut machine = lock(&shared);
        let chip = &mut machine.chip;
        for (register, bits) in [(DMA1_S0CR, 1), (TIM1_DMAR, u32::MAX)] {
            let at = chip.now;
            chip.bus.write(register, 0, bits, at, &mut chip.scs.exceptions).unwrap();
        }
        machine.run(5 * MILLISECOND);
    }
    let state = client.call(LaserStatus { core, channel }).unwrap();
    assert_eq!((state.light, state.fault.get()), (0, 3), "an overrun");
    let (_, events) = client.call_items(GetEvents {}, &[]).unwrap();
    let overruns: Vec<u16> =
        events.iter().filter(|event| event.kind == OVERRUN).map(|event| event.reason.get()).collect();
    assert_eq!(overruns, [1], "they began anew once, and were read as they should be");
    client.call(ClrLaserFault { core, channel }).unwrap();
    client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    let mut machine = lock(&shared);
    machine.run(5 * MILLISECOND);
    let begin = machine.chip.now;
    machine.run(2 * MILLISECOND);
    let plus = Pin::named("PE9").unwrap();
    let edges: Vec<_> = machine.chip.bus.gpio.changes.iter().filter(|c| c.pin == plus && c.at >= begin).collect();
    assert!(edges.len() >= 38, "{} edges in 2 ms of 10 kHz", edges.len());
    for pair in edges.windows(2) {
        let lasts = pair[1].at - pair[0].at;
        assert!((lasts as i64 - 48_000).abs() <= 4, "{lasts} units of light or dark");
    }
}

/// Timers are reset before they start anew, in the tick before it reads the interlock.
#[test]
fn a_break_that_no_tick_has_read_outlives_the_reset_of_the_timers() {
    let Some(mut machine) = started(|_| {}) else { return };
    let elf = std::fs::read(std::env::var_os("BEAMTICK_H743_IMAGE").unwrap()).unwrap();
    let reset = h743::image::symbol(&elf, "laser5reset").unwrap() & !1;
    let now = machine.chip.now;
    machine.chip.bus.write(DMA1_S0CR, 0, 1, now, &mut machine.chip.scs.exceptions).unwrap();
    let end = now + 20 * MILLISECOND;
    while machine.register(Register::Pc) & !1 != reset {
        machine.run(1);
        assert!(machine.chip.now < end, "the timers are not reset");
    }
    for open in [true, false] {
        BREAKS.iter().for_each(|(_, name)| machine.drive(Pin::named(name).unwrap(), Some(open)));
    }
    let flags = |machine: &mut Machine| {
        let (now, chip) = (machine.chip.now, &mut machine.chip);
        TIMERS_SR.map(|register| chip.bus.read(register, now, &mut chip.scs.exceptions).unwrap() >> 7 & 1)
    };
    assert_eq!(flags(&mut machine), [1; 3]);
    for expected in [[0; 3], [1; 3]] {
        let end = machine.chip.now + 5 * MICROSECOND;
        while flags(&mut machine) != expected {
            machine.run(1);
            assert!(machine.chip.now < end, "flags are {:?}, not {expected:?}", flags(&mut machine));
        }
    }
    let (client, _shared) = linked(machine);
    assert_ne!((cause(&client, 0), cause(&client, 1)), (0, 0));
}

/// An instruction is a cycle here, so what is reported is what the handler's instructions take at
/// 480 MHz: 1,800 to 2,400, of which a tick of the session takes more.
#[test]
fn how_long_ticks_take_is_measured() {
    let Some(machine) = started(|_| {}) else { return };
    let (client, shared) = linked(machine);
    let reported = |ms: u64| {
        lock(&shared).run(ms * MILLISECOND);
        let reply = client.call(GetTickTime {}).unwrap();
        (reply.measured, reply.period_ns.get(), reply.median_ns.get(), reply.worst_ns.get())
    };
    let (measured, period, median, worst) = reported(100);
    assert_eq!((measured, period), (1, 50_000));
    // The longest were those in which the session began.
    assert!((3_500..5_000).contains(&median), "{median} ns");
    assert!((2 * median..period).contains(&worst), "{worst} ns at most");
    // The histogram counts each tick once: 2,000 in 0.1 s, and those of the calls.
    let counts = || {
        let (reply, counts) = client.call_items(GetTickTime {}, &[]).unwrap();
        assert_eq!((reply.count.get(), counts.len(), reply.bucket_ns.get()), (32, 32, 2048));
        counts.iter().map(|count| count.value.get()).collect::<Vec<u32>>()
    };
    let before = counts();
    lock(&shared).run(100 * MILLISECOND);
    let gained: Vec<u32> = counts().iter().zip(&before).map(|(after, before)| after - before).collect();
    let total: u32 = gained.iter().sum();
    assert!((2_000..2_100).contains(&total), "{gained:?}");
    assert!(gained[median as usize / 2048] > total / 2, "{median} ns: {gained:?}");
    assert_eq!(gained[period as usize / 2048..].iter().sum::<u32>(), 0, "{gained:?}");
    // Much set-up in one tick leaves the median where it is.
    client.call(Reset { core: 1.into() }).unwrap();
    let (_, _, still, longest) = reported(100);
    assert!(still.abs_diff(median) < 200 && longest >= worst, "{median} {still} {worst} {longest}");
    // The longest since the call before: a call alone takes less than a Reset, whose tick that of
    // the start stays the longest after.
    let recent = || {
        let reply = client.call(GetTickTime {}).unwrap();
        assert_eq!(reply.worst_ns.get(), longest);
        reply.recent_ns.get()
    };
    recent();
    lock(&shared).run(10 * MILLISECOND);
    let idle = recent();
    client.call(Reset { core: 1.into() }).unwrap();
    let set_up = recent();
    assert!((median..2 * median).contains(&idle) && (idle + median / 2..=longest).contains(&set_up), "{idle} {set_up}");
    client.call(SetTick { tick_us: 250.into() }).unwrap();
    assert_eq!(reported(10).1, 250_000);
}

/// Start-up paints the stack; the lowest word that is no longer so ends what was never used.
#[test]
fn what_of_the_stack_was_never_used_is_measured() {
    let Some(machine) = started(|_| {}) else { return };
    let elf = std::fs::read(std::env::var_os("BEAMTICK_H743_IMAGE").unwrap()).unwrap();
    let [lowest, end] = ["_stack_end", "_stack_start"].map(|name| h743::image::symbol(&elf, name).unwrap());
    let (client, shared) = linked(machine);
    let reported = || {
        let reply = client.call(GetStack {}).unwrap();
        assert_eq!((reply.measured, reply.size.get()), (1, end - lowest));
        reply.unused.get()
    };
    // Start-up, a session and its ticks take most of 16 KiB; a look-ahead would take more.
    let unused = reported();
    assert!((4_000..8_000).contains(&unused), "{unused} bytes");
    {
        let machine = lock(&shared);
        let word = |at| machine.chip.memory.word(at).unwrap();
        let paint = word(lowest);
        let used = (lowest..end).step_by(4).find(|at| word(*at) != paint).unwrap();
        // The call itself may have gone on to some words more.
        assert!(used - lowest <= unused && unused - (used - lowest) < 512, "{} {unused}", used - lowest);
        assert!(paint != 0 && paint != u32::MAX);
        // A frame of zeros counts.
        assert!(machine.chip.memory.load(lowest + 1000, &[0; 4]));
    }
    assert_eq!(reported(), 1000);
}
