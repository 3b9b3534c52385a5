//! From how many lines of flash a tick of the image takes its instructions, where
//! BEAMTICK_H743_IMAGE names the image. Each is a line of 32 bytes of the I-cache, which the thread
//! may have pushed out since; what runs from ITCM has none
//! (docs/decisions/016-hot-code-in-itcm.md).
use client::{Client, Options};
use h743::engine::Register;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MILLISECOND, Machine, Pin};
use protocol::command::{
    AxisOn, LaserOutFrq, LaserPrfCmd, PrfPvt, PvtPoint, PvtStart, PvtTable, PvtTableSelect, SetAxisMode, SetHSIOOpt,
    SetPvtLoop,
};
use std::collections::HashSet;
use std::sync::{Arc, Mutex};

/// The interrupt of TIM2, as an exception.
const TICK: usize = 16 + 28;

/// What a tick took its instructions from.
#[derive(Debug, Clone, Copy)]
struct Code {
    /// Lines of flash.
    lines: usize,
    /// Instructions from ITCM.
    hot: usize,
}

/// The next tick, from its first instruction to its last.
fn tick(machine: &mut Machine) -> Code {
    let mut lines = HashSet::new();
    let mut hot = 0;
    while machine.chip.scs.exceptions.active[TICK] {
        machine.run(1);
    }
    while !machine.chip.scs.exceptions.active[TICK] {
        machine.run(1);
    }
    while machine.chip.scs.exceptions.active[TICK] {
        let at = machine.register(Register::Pc);
        if at < 0x1_0000 {
            hot += 1;
        } else {
            lines.insert(at / 32);
        }
        machine.run(1);
    }
    Code { lines: lines.len(), hot }
}

/// The most that any of `count` ticks takes.
fn worst(what: &str, machine: &mut Machine, count: usize) -> Code {
    let ticks: Vec<Code> = (0..count).map(|_| tick(machine)).collect();
    let worst = *ticks.iter().max_by_key(|code| code.lines).unwrap();
    println!("{what}: {worst:?}");
    worst
}

/// The board, its interlock's circuit closed, and a client that keeps the session. `None` without
/// an image.
fn board() -> Option<(Client, Shared)> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    for pin in ["PE15", "PE3", "PG2"] {
        machine.drive(Pin::named(pin).unwrap(), Some(false));
    }
    machine.run(20 * MILLISECOND);
    let machine: Shared = Arc::new(Mutex::new(machine));
    let client = Client::open(Box::new(EmulatedLink::new(machine.clone())), Options::default()).unwrap();
    Some((client, machine))
}

#[test]
fn a_tick_in_which_nothing_runs_takes_hardly_a_line() {
    let Some((_client, shared)) = board() else { return };
    let code = worst("nothing runs", &mut lock(&shared), 16);
    assert!(code.lines <= 4 && code.hot > 1_000, "{code:?}");
}

#[test]
fn a_tick_with_light_takes_hardly_a_line() {
    light_at(10.0);
}

#[test]
fn a_tick_with_carriers_of_2_mhz_takes_hardly_a_line() {
    light_at(2000.0);
}

/// Both lasers at one power; kHz.
fn light_at(frequency: f64) {
    let Some((client, shared)) = board() else { return };
    for (axis, channel) in [(7, 0), (8, 1)] {
        let (core, channel) = (1.into(), channel.into());
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserOutFrq { core, frequency: frequency.into(), channel }).unwrap();
        client.call(LaserPrfCmd { core, power: 33.3.into(), channel }).unwrap();
        client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    }
    // The client waits for the machine meanwhile; at its end it would abort what runs.
    let mut machine = lock(&shared);
    machine.run(5 * MILLISECOND);
    let code = worst(&format!("light of two lasers at {frequency} kHz"), &mut machine, 64);
    assert!(code.lines <= 4 && code.hot > 1_000, "{code:?}");
}

#[test]
fn eight_axes_in_pvt_take_lines_where_segments_begin() {
    let Some((client, shared)) = board() else { return };
    let (core, table) = (1.into(), 1.into());
    let points: Vec<PvtPoint> = [(0.0, 0.0, 0.0), (2.0, 100.0, 100.0), (4.0, 400.0, 50.0), (6.0, 450.0, 0.0)]
        .map(|(time, pos, vel): (f64, f64, f64)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
        .to_vec();
    client.call_items(PvtTable { core, table, count: 4.into(), first: 0.into() }, &points).unwrap();
    for axis in 1..=8i16 {
        let profile = axis.into();
        client.call(AxisOn { core, axis: profile }).unwrap();
        client.call(PrfPvt { core, profile }).unwrap();
        client.call(SetPvtLoop { core, profile, loop_count: 0.into() }).unwrap();
        client.call(PvtTableSelect { core, profile, table }).unwrap();
    }
    client.call(PvtStart { core, mask: 0xff.into() }).unwrap();
    // The client waits for the machine meanwhile; at its end it would abort what runs.
    let mut machine = lock(&shared);
    machine.run(MILLISECOND);
    let ticks: Vec<Code> = (0..120).map(|_| tick(&mut machine)).collect();
    let mut lines: Vec<usize> = ticks.iter().map(|code| code.lines).collect();
    lines.sort_unstable();
    let (middle, most) = (lines[lines.len() / 2], lines[lines.len() - 1]);
    println!("eight axes in PVT: {middle} lines in the middle, {most} at most; {:?}", ticks[0]);
    assert!(middle <= 8 && most <= 200, "{middle} lines in the middle, {most} at most");
}
