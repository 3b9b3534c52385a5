//! The step outputs of the image in emulation, where BEAMTICK_H743_IMAGE names it: every planned
//! pulse is an edge at its pin, evenly spaced, with its direction set before.
use client::{Client, Options};
use h743::link::{EmulatedLink, Shared, lock};
use h743::time::nanoseconds;
use h743::{Level, MILLISECOND, Machine, Pin};
use protocol::command::{AxisOn, GetPrfPos, PrfPt, PtData, PtStart, SetTick};
use std::sync::{Arc, Mutex};

/// Direction and step output of an axis, from 1.
fn pins(axis: i16) -> (Pin, Pin) {
    (Pin::named(&format!("PF{}", axis - 1)).unwrap(), Pin::named(&format!("PF{}", axis + 7)).unwrap())
}

/// What an axis has done: the instants of its steps in ns with their signs, after its directions
/// and widths were checked.
fn steps(machine: &Machine, axis: i16) -> Vec<(u64, i64)> {
    let (direction, step) = pins(axis);
    let (mut back, mut turned, mut high) = (false, None, None);
    let mut found = Vec::new();
    for change in &machine.chip.bus.gpio.changes {
        let at = nanoseconds(change.at);
        let level = change.level == Level::Driven(true);
        if change.pin == direction && level != back {
            assert_eq!(high, None, "axis {axis} turns within a step at {at}");
            (back, turned) = (level, Some(at));
        } else if change.pin == step && level {
            // What DMA needs to answer may differ by some of its cycles.
            assert!(turned.is_none_or(|turned| at - turned >= 2_000 - 100), "axis {axis} steps at {at}");
            high = Some(at);
            found.push((at, if back { -1 } else { 1 }));
        } else if let Some(rose) = high.take_if(|_| change.pin == step) {
            assert!((400..=600).contains(&(at - rose)), "axis {axis}: {} ns high", at - rose);
        }
    }
    assert_eq!(high, None);
    found
}

/// Moves all axes forwards and back at `tops` pulses a ms, and looks at their pins.
fn run(elf: &[u8], tick_us: i32, tops: [i64; 8]) {
    let mut machine = Machine::new().unwrap();
    machine.boot(elf).unwrap();
    machine.run(20 * MILLISECOND);
    let machine: Shared = Arc::new(Mutex::new(machine));
    let client = Client::open(Box::new(EmulatedLink::new(machine.clone())), Options::default()).unwrap();
    client.call(SetTick { tick_us: tick_us.into() }).unwrap();
    for (axis, top) in (1..).zip(tops) {
        let (core, profile) = (1.into(), axis);
        client.call(AxisOn { core, axis: axis.into() }).unwrap();
        client.call(PrfPt { core, profile: profile.into(), mode: 0.into() }).unwrap();
        // Even to 2 ms, at rest until 3 ms, back to half of it at 4 ms, ramps from there to 7 ms.
        let places = [(2, 2 * top, 1), (3, 2 * top, 1), (4, top, 1), (6, 0, 0), (7, top / 4, 2)];
        for (time_ms, pos, kind) in places {
            let (pos, fifo) = ((pos as f64).into(), 0.into());
            let data =
                PtData { core, profile: profile.into(), pos, time_ms: time_ms.into(), kind: i16::into(kind), fifo };
            client.call(data).unwrap();
        }
        // A pulse a millisecond more than the step outputs make is refused, and the data stays what
        // it was.
        let pos = ((top / 4 + 1001) as f64).into();
        let (profile, time_ms, kind, fifo) = (profile.into(), 8.into(), 1.into(), 0.into());
        let refused = client.call(PtData { core, profile, pos, time_ms, kind, fifo }).unwrap_err();
        assert_eq!(refused.code, 7, "{refused}");
        assert!(refused.to_string().contains("speed is 1001 pulse/ms; the limit is 1000"), "{refused}");
    }
    client.call(PtStart { core: 1.into(), mask: 0xff.into(), option: 0.into() }).unwrap();
    lock(&machine).run(20 * MILLISECOND);
    for (axis, top) in (1..).zip(tops) {
        let planned = client.call_items(GetPrfPos { core: 1.into(), profile: i16::into(axis), count: 1.into() }, &[]);
        let end = top / 4;
        assert_eq!(planned.unwrap().1[0].value.get(), end as f64);
        let found = steps(&lock(&machine), axis);
        assert_eq!(found.iter().map(|(_, sign)| sign).sum::<i64>(), end, "axis {axis}");
        let gaps: Vec<u64> = found.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        assert!(gaps.iter().all(|gap| *gap >= 1000 - 100), "axis {axis}: {:?} ns", gaps.iter().min());
        // While it goes evenly, a tick holds one of two whole numbers of steps, spread over it to a
        // slot. What the set-up of the direction has taken of the first tick at full speed, two
        // steps, comes after.
        let (tick, speed) = (tick_us.unsigned_abs() as u64 * 1000, top.unsigned_abs());
        let (ideal, few) = (1_000_000 / speed, tick * speed / 1_000_000);
        let (least, most) = match few {
            0 => (ideal.saturating_sub(tick), ideal + tick),
            few => (tick / (tick * speed).div_ceil(1_000_000), tick / few),
        };
        let behind = if top == -1000 { 2 } else { 0 };
        for gap in gaps.iter().take(2 * speed as usize - 1 - behind) {
            assert!(*gap + 600 >= least && *gap <= most + 600, "axis {axis} at {top}/ms: {gap} ns instead of {ideal}");
        }
        println!("axis {axis}: {} steps, the closest {:?} ns apart", found.len(), gaps.iter().min());
    }
    let machine = lock(&machine);
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
    assert_eq!(machine.resets, []);
}

#[test]
fn planned_pulses_are_edges_at_the_pins() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        return println!("skipped: BEAMTICK_H743_IMAGE names no image");
    };
    let elf = std::fs::read(path).unwrap();
    run(&elf, 50, [1000, -1000, 640, -500, 72, 36, -100, 4]);
    run(&elf, 250, [-1000, 1000, 996, 12, -72, 100, 500, 200]);
}
