//! Edges and voltages at the chip's pins against those that the virtual controller has written into
//! a VCD.
//!
//! The virtual controller's instants are ns from the first row; the chip's are counts of its timers
//! from power-on. Where the one begins in the other is not known, so the first edge of all says it;
//! every other one must then fall on its count. Lasers and steps say it each for themselves, and
//! must say the same.
use h743::dac8563;
use h743::machine::Chip;
use h743::{Level, MICROSECOND, Pin, Time};
use std::collections::HashMap;

/// A count of the timers.
const COUNT: Time = 4;

/// Pins at which a board shows what a VCD names.
pub struct Pins {
    /// What a VCD calls a signal of a laser, the pin that shows it, and the pin with the
    /// complement. At rest + is high: a low level is the active one.
    lines: [(&'static str, &'static str, &'static str); 4],
    /// General outputs of a VCD, and their pins.
    outputs: &'static [(&'static str, &'static str)],
    /// Step and direction of axis 1.
    step: [&'static str; 2],
}

/// docs/board-h743.md.
pub const NUCLEO: Pins = Pins {
    lines: [
        ("laser0_energy", "PE9", "PE8"),
        ("laser1_energy", "PE5", "PE4"),
        ("laser0_switch", "PC7", "PB0"),
        ("laser1_switch", "PC8", "PB15"),
    ],
    outputs: &[("do1", "PE1"), ("do2", "PB14"), ("do3", "PG10"), ("do4", "PG12"), ("do5", "PG14"), ("do6", "PG15")],
    step: ["PF8", "PF0"],
};

/// docs/board-h743vi.md.
pub const MODULE: Pins = Pins {
    lines: [
        ("laser0_energy", "PA8", "PB13"),
        ("laser1_energy", "PA2", "PA1"),
        ("laser0_switch", "PC7", "PB0"),
        ("laser1_switch", "PC8", "PB1"),
    ],
    outputs: &[("do1", "PD2"), ("do2", "PB3"), ("do3", "PB2")],
    step: ["PE8", "PE0"],
};

/// Instants in ns at which each wire changes, and its level from then on.
type Wires = HashMap<String, Vec<(u64, bool)>>;

fn wires(vcd: &str) -> Wires {
    let (mut names, mut edges) = (HashMap::new(), Wires::new());
    let mut now = 0;
    for line in vcd.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["$var", "wire", "1", id, name, ..] = words[..] {
            names.insert(id, name);
        } else if let Some(time) = line.strip_prefix('#') {
            now = time.parse().unwrap();
        } else if let Some((level @ ("0" | "1"), id)) = line.split_at_checked(1)
            && let Some(name) = names.get(id)
        {
            edges.entry((*name).to_string()).or_default().push((now, level == "1"));
        }
    }
    // What holds at the start is no edge.
    for of in edges.values_mut() {
        let mut level = false;
        of.retain(|&(_, to)| std::mem::replace(&mut level, to) != to);
    }
    edges
}

/// Voltages of a channel's analog output in the VCD: instants in ns and mV, without those that
/// change nothing. The first is what holds at the start.
fn voltages(vcd: &str, channel: usize) -> Vec<(u64, f64)> {
    let wanted = format!("laser{channel}_dac_mv");
    let (mut id, mut now, mut found) = (None, 0, Vec::<(u64, f64)>::new());
    for line in vcd.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["$var", "real", _, of, name, ..] if name == wanted => id = Some(of),
            [value, of] if Some(of) == id && value.starts_with('r') => {
                let volts = value[1..].parse().unwrap();
                if found.last().is_none_or(|(_, before)| *before != volts) {
                    found.push((now, volts));
                }
            }
            _ => now = line.strip_prefix('#').map_or(now, |time| time.parse().unwrap()),
        }
    }
    found
}

/// What an analog output shows in mV after its stage: its changes since it was switched on, the
/// first of them the voltage it had then.
fn published(chip: &Chip, channel: usize, external: bool) -> Result<Vec<(Time, f64)>, String> {
    let millivolts = |value: u16, least: i32| (i32::from(value) * least - 32768) as f64 * 10_000.0 / 32768.0;
    let mut published: Vec<(Time, f64)> = if external {
        let of = |(at, _, code): (Time, usize, u16)| (at, millivolts(code, 1));
        let writes = dac8563::writes(chip, Pin::named("PC11").unwrap())?;
        let writes = writes.into_iter().filter(|write| write.1 == channel).map(of);
        std::iter::once((0, millivolts(dac8563::MID_SCALE, 1))).chain(writes).collect()
    } else {
        let of = |&(at, of, value): &h743::dac::Change| (of == channel).then_some((at, millivolts(value?, 16)));
        chip.bus.dac.changes.iter().filter_map(of).collect()
    };
    published.dedup_by(|later, before| later.1 == before.1);
    Ok(published)
}

/// The voltages of both channels against the plan, to a code of the converter and a tick;
/// `external` is the DAC8563. Returns how many changes were compared. Where the plan begins is
/// reported by the first edge of all lasers, as in [`compare`].
pub fn compare_voltages(pins: &Pins, vcd: &str, tick_us: u64, external: bool, chip: &Chip) -> Result<usize, String> {
    // A code of 12 bits is 4.88 mV, one of 16 bits 0.31 mV; the VCD has its own rounding.
    let code = if external { 0.32 } else { 4.9 };
    let wires = wires(vcd);
    let first = pins.lines.iter().filter_map(|(wire, ..)| Some(wires.get(*wire)?.first()?.0)).min();
    let first_seen = pins.lines.iter().filter_map(|(_, plus, _)| Some(pin(chip, plus, false).first()?.0)).min();
    let mut compared = 0;
    for channel in 0..2 {
        let (planned, published) = (voltages(vcd, channel), published(chip, channel, external)?);
        if published.first().is_none_or(|(_, volts)| *volts != 0.0) {
            return Err(format!("output {channel} does not begin at 0 V: {:?}", published.first()));
        }
        let changes = planned.iter().skip(1).zip(published.iter().skip(1));
        for (&(ns, wanted), &(at, volts)) in changes {
            let (Some(first), Some(first_seen)) = (first, first_seen) else {
                return Err("voltages without an edge that says when".into());
            };
            let off = at as i64 - first_seen as i64 - (ns as i64 - first as i64) * 960 / 1000;
            // Within a tick, and what the tick itself takes to say it.
            if (volts - wanted).abs() > code || off.unsigned_abs() > (tick_us + 5) * h743::MICROSECOND {
                return Err(format!(
                    "output {channel}: {wanted} mV are planned at {ns} ns, it shows {volts} mV {off} units off"
                ));
            }
            compared += 1;
        }
        if planned.len().max(1) != published.len() {
            return Err(format!(
                "output {channel} shall change {} times and does {}: {planned:?}, {published:?}",
                planned.len().max(1) - 1,
                published.len() - 1
            ));
        }
    }
    Ok(compared)
}

/// What a pin did while it was driven; an active level is true.
fn pin(chip: &Chip, name: &str, active: bool) -> Vec<(Time, bool)> {
    let pin = Pin::named(name).unwrap();
    let mut level = false;
    let of = |change: &h743::gpio::Change| match change.level {
        Level::Driven(high) if change.pin == pin => Some((change.at, high == active)),
        _ => None,
    };
    let mut edges: Vec<_> = chip.bus.gpio.changes.iter().filter_map(of).collect();
    edges.retain(|&(_, to)| std::mem::replace(&mut level, to) != to);
    edges
}

/// A slot of the step output: 0.5 µs (docs/board-h743.md).
const SLOT: Time = 120 * COUNT;

/// The rising edges of axis 1's step output against the plan. The `k`-th pulse of a tick of S slots
/// comes in the slot of `servo::output::step_generator`, `ceil(((k + 1)·S − floor(S/2)) / n) − 1`.
/// It is counted here in whole numbers from the positions of the trace. All instants are those of
/// the plan but for one shift, which the first edge gives. Returns how many were compared, and the
/// instant of the first row on the chip, as it would be if pulses of a tick came in the tick before
/// its row.
pub fn compare_steps(pins: &Pins, csv: &str, tick_us: u64, chip: &Chip) -> Result<(usize, Option<i128>), String> {
    let slots = tick_us * 2;
    let mut planned = Vec::new();
    let mut stands = 0i64;
    for (tick, line) in csv.lines().skip(1).enumerate() {
        let position = line.split(',').nth(1).ok_or("a row has no position")?;
        let goes_to = whole(position).ok_or_else(|| format!("{position} is no position"))?;
        let count = goes_to.abs_diff(stands);
        for k in 0..count {
            let slot = ((k + 1) * slots - slots / 2).div_ceil(count) - 1;
            planned.push((tick as u64 * slots + slot, goes_to > stands));
        }
        stands = goes_to;
    }
    let [step, direction] = pins.step.map(|name| Pin::named(name).unwrap());
    let mut backwards = false;
    let mut seen = Vec::new();
    for change in &chip.bus.gpio.changes {
        match change.level {
            Level::Driven(high) if change.pin == direction => backwards = high,
            Level::Driven(true) if change.pin == step => seen.push((change.at, !backwards)),
            _ => {}
        }
    }
    if planned.len() != seen.len() {
        return Err(format!("{} steps are planned, {step} shows {}", planned.len(), seen.len()));
    }
    let (Some(first), Some(begin)) = (planned.first(), seen.first()) else { return Ok((0, None)) };
    let origin = i128::from(begin.0) - i128::from(first.0 * SLOT) + i128::from(slots * SLOT);
    for (n, (planned, seen)) in planned.iter().zip(&seen).enumerate() {
        let wanted = begin.0 + (planned.0 - first.0) * SLOT;
        if planned.1 != seen.1 || wanted.abs_diff(seen.0) > COUNT {
            return Err(format!("step {n}: planned {planned:?}, seen {seen:?}, wanted at {wanted}"));
        }
    }
    Ok((planned.len(), Some(origin)))
}

/// General outputs against the plan: a change comes with the first tick that is not before it.
/// `origin` is the instant on the chip of what is planned for the first row. Returns how many were
/// compared.
pub fn compare_outputs(pins: &Pins, vcd: &str, tick_us: u64, origin: i128, chip: &Chip) -> Result<usize, String> {
    let wires = wires(vcd);
    let (tick, mut compared) = (tick_us * 1000, 0);
    for &(wire, name) in pins.outputs {
        let planned = wires.get(wire).map_or(&[][..], Vec::as_slice);
        let seen = pin(chip, name, true);
        if planned.len() != seen.len() {
            return Err(format!("{wire}: {} edges are planned, {name} shows {}", planned.len(), seen.len()));
        }
        for (&(ns, to), &(at, level)) in planned.iter().zip(&seen) {
            let begins = origin + i128::from(ns.div_ceil(tick) * tick * 960 / 1000);
            // The tick's handler sets it.
            let late = i128::from(at) - begins;
            if to != level || !(0..i128::from(5 * MICROSECOND)).contains(&late) {
                return Err(format!(
                    "{wire}: planned {to} at {ns} ns, {name} shows {level}, {late} units behind its tick"
                ));
            }
            compared += 1;
        }
    }
    Ok(compared)
}

/// The pulse nearest to a position of six decimals, halves upwards.
fn whole(position: &str) -> Option<i64> {
    let (sign, digits) = position.strip_prefix('-').map_or((1, position), |digits| (-1, digits));
    let (whole, part) = digits.split_once('.')?;
    let millionths = sign * (whole.parse::<i64>().ok()? * 1_000_000 + part.parse::<i64>().ok()?);
    Some((millionths + 500_000).div_euclid(1_000_000))
}

/// Where + and − part but as a safe state has it: it leaves − lit for two counts while + is dark
/// (docs/board-h743.md, "Laser outputs").
fn parted(plus: &[(Time, bool)], minus: &[(Time, bool)], end: Time) -> Option<Time> {
    let edges = |edges: &[(Time, bool)], of: usize| edges.iter().map(|&(at, lit)| (at, of, lit)).collect::<Vec<_>>();
    let mut all = [edges(plus, 0), edges(minus, 1)].concat();
    all.sort_unstable_by_key(|&(at, ..)| at);
    let (mut lit, mut since) = ([false; 2], 0);
    for (at, of, level) in all.into_iter().chain([(end, 0, false)]) {
        if lit[0] != lit[1] && at > since && (lit[0] || at - since > 2 * COUNT) {
            return Some(since);
        }
        (lit[of], since) = (level, at);
    }
    None
}

#[test]
fn lines_that_part_are_found() {
    let plus = [(100, true), (200, false), (300, true), (400, false)];
    assert_eq!(parted(&plus, &plus, 1000), None);
    // − rests two counts later; then it is lit for two counts alone.
    let minus = [(100, true), (208, false), (300, true), (400, false), (500, true), (508, false)];
    assert_eq!(parted(&plus, &minus, 1000), None);
    assert_eq!(parted(&plus, &[(100, true), (212, false), (300, true), (400, false)], 1000), Some(200));
    assert_eq!(parted(&plus, &[(100, true), (199, false), (300, true), (400, false)], 1000), Some(199));
    assert_eq!(parted(&plus, &[(104, true), (200, false), (300, true), (400, false)], 1000), Some(100));
    assert_eq!(parted(&plus, &[(100, true), (200, false), (300, true)], 1000), Some(400));
}

/// How many edges were compared and where the first row is on the chip, or where the first one
/// differs.
pub fn compare(pins: &Pins, vcd: &str, chip: &Chip) -> Result<(usize, Option<i128>), String> {
    let wires = wires(vcd);
    let none = Vec::new();
    let planned: Vec<(&str, &Vec<(u64, bool)>)> =
        pins.lines.iter().map(|(wire, ..)| (*wire, wires.get(*wire).unwrap_or(&none))).collect();
    let seen: Vec<Vec<(Time, bool)>> = pins.lines.iter().map(|(_, plus, _)| pin(chip, plus, false)).collect();
    let first = planned.iter().filter_map(|(_, edges)| edges.first()).map(|&(ns, _)| ns).min();
    let first_seen = seen.iter().filter_map(|edges| edges.first()).map(|&(at, _)| at).min();
    let (Some(first), Some(first_seen)) = (first, first_seen) else {
        return match (first, first_seen) {
            (None, None) => Ok((0, None)),
            _ => Err(format!("the first edge is planned at {first:?} ns and seen at {first_seen:?}")),
        };
    };
    let mut compared = 0;
    for (((wire, planned), seen), (_, plus, minus)) in planned.iter().zip(&seen).zip(pins.lines) {
        if planned.len() != seen.len() {
            return Err(format!("{wire}: {} edges are planned, {plus} shows {}", planned.len(), seen.len()));
        }
        if let Some(at) = parted(seen, &pin(chip, minus, true), chip.now) {
            return Err(format!("{wire}: {minus} is not the complement of {plus} at {at}"));
        }
        for (n, (&(ns, to), &(at, level))) in planned.iter().zip(seen).enumerate() {
            let wanted = ((ns - first) * 960) as f64 / 1000.0;
            let off = (at - first_seen) as f64 - wanted;
            if to != level || off.abs() > COUNT as f64 + 0.96 {
                return Err(format!(
                    "{wire}, edge {n}: planned {to} at {ns} ns, {plus} shows {level}, {off} units off"
                ));
            }
            compared += 1;
        }
    }
    Ok((compared, Some(i128::from(first_seen) - i128::from(first * 960 / 1000))))
}
