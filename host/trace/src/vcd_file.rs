//! Rows as a VCD of 1 ns (SPEC 8): `axisN_step`, `axisN_dir`, `doN`, `aoN_mv`, `laserK_energy`,
//! `laserK_switch`, `laserK_dac_mv`.
//!
//! In: rows, and what digital and laser outputs did before each of them. Out: value changes. The
//! whole pulses of the machine between two rows are spread over the time between them as
//! `servo::output::step_generator` says; a step is high for half the distance to the next. A level
//! that lasts for no time is not shown. Owns at most one row's changes.
use crate::row::{AnalogEdge, AxisName, Header, OutputEdge, Row};
use crate::{Result, TraceError};
use plant::beam::SignalChange;
use servo::output::step_generator;
use servo::units::Pos;
use std::io::Write;
use vcd::{IdCode, TimescaleUnit, Value, VarType};

/// What a signal shows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum LastValue {
    Level(bool),
    Number(f64),
}

/// A signal and what it shows now.
struct Signal {
    id: IdCode,
    last_value: LastValue,
}

/// Signals of one axis, by their indices.
struct AxisSignals {
    axis: AxisName,
    step: usize,
    dir: usize,
    backwards: bool,
    /// What the machine's 0 is called, and its set-point.
    zero: Pos,
    set_point: Pos,
}

/// Signals of one laser, by their indices.
struct LaserSignals {
    energy: usize,
    switch: usize,
    dac: usize,
}

/// Writes rows and edges as they come.
pub struct VcdWriter<W: Write> {
    out: vcd::Writer<W>,
    signals: Vec<Signal>,
    axes: Vec<AxisSignals>,
    outputs: Vec<(u8, usize)>,
    analog: Vec<(u8, usize)>,
    lasers: Vec<LaserSignals>,
    /// Instant, signal, and what it shows from then on.
    changes: Vec<(u64, usize, LastValue)>,
    row: Option<(u32, u64)>,
    time: u64,
}

impl<W: Write> VcdWriter<W> {
    /// Declares the signals: two for each axis of the header, and one for each output (its number
    /// from 1, and its level at the start). Each analog output (its number from 1) has one, which
    /// begins at 0. Each laser has three, which begin in the safe state.
    pub fn new(out: W, header: &Header, outputs: &[(u8, bool)], analog: &[u8]) -> Result<Self> {
        let mut out = vcd::Writer::new(out);
        out.timescale(1, TimescaleUnit::NS)?;
        out.add_module("beamtick")?;
        let mut signals = Vec::new();
        let mut declare = |out: &mut vcd::Writer<W>, name: String, last_value: LastValue| -> Result<usize> {
            let id = match last_value {
                LastValue::Level(_) => out.add_wire(1, &name)?,
                LastValue::Number(_) => out.add_var(VarType::Real, 64, &name, None)?,
            };
            signals.push(Signal { id, last_value });
            Ok(signals.len() - 1)
        };
        let low = LastValue::Level(false);
        let mut axes = Vec::new();
        for &axis in &header.axes {
            axes.push(AxisSignals {
                axis,
                step: declare(&mut out, format!("{axis}_step"), low)?,
                dir: declare(&mut out, format!("{axis}_dir"), low)?,
                backwards: false,
                zero: Pos(0),
                set_point: Pos(0),
            });
        }
        let mut places = Vec::new();
        for &(n, level) in outputs {
            places.push((n, declare(&mut out, format!("do{n}"), LastValue::Level(level))?));
        }
        let mut volts = Vec::new();
        for &n in analog {
            volts.push((n, declare(&mut out, format!("ao{n}_mv"), LastValue::Number(0.0))?));
        }
        let mut lasers = Vec::new();
        for laser in &header.lasers {
            lasers.push(LaserSignals {
                energy: declare(&mut out, format!("{laser}_energy"), low)?,
                switch: declare(&mut out, format!("{laser}_switch"), low)?,
                dac: declare(&mut out, format!("{laser}_dac_mv"), LastValue::Number(0.0))?,
            });
        }
        out.upscope()?;
        out.enddefinitions()?;
        out.timestamp(0)?;
        for signal in &signals {
            show(&mut out, signal)?;
        }
        let changes = Vec::new();
        Ok(VcdWriter { out, signals, axes, outputs: places, analog: volts, lasers, changes, row: None, time: 0 })
    }

    /// Takes a general output's edge; it is written with the row after it.
    pub fn edge(&mut self, edge: OutputEdge) {
        if let Some((_, signal)) = self.outputs.iter().find(|(n, _)| *n == edge.output) {
            self.changes.push((edge.t_ns, *signal, LastValue::Level(edge.level)));
        }
    }

    /// Takes what an analog output was set to; it is written with the row after it.
    pub fn analog(&mut self, edge: AnalogEdge) {
        if let Some((_, signal)) = self.analog.iter().find(|(n, _)| *n == edge.output) {
            self.changes.push((edge.t_ns, *signal, LastValue::Number(millivolts(edge.code))));
        }
    }

    /// Takes the changes of a laser's outputs (its index in the header); they are written with the
    /// row after them.
    pub fn change(&mut self, laser: usize, change: &SignalChange) {
        let Some(LaserSignals { energy, switch, dac }) = self.lasers.get(laser) else { return };
        let changes = &mut self.changes;
        match *change {
            SignalChange::Switch { at, level } => changes.push((at, *switch, LastValue::Level(level))),
            SignalChange::Energy { at, level } => changes.push((at, *energy, LastValue::Level(level))),
            SignalChange::Pulses(burst) => {
                for (from, to) in burst.pulses() {
                    changes.push((from, *energy, LastValue::Level(true)));
                    changes.push((to, *energy, LastValue::Level(false)));
                }
            }
            SignalChange::Dac { at, code } => changes.push((at, *dac, LastValue::Number(millivolts(code)))),
        }
    }

    /// The position of an axis (its index in the header) is called so much more from the next row
    /// on: no step.
    pub fn zero(&mut self, axis: usize, by: Pos) {
        if let Some(AxisSignals { zero, .. }) = self.axes.get_mut(axis) {
            *zero = Pos(zero.0.wrapping_add(by.0));
        }
    }

    /// Takes a row and writes all changes before it.
    pub fn row(&mut self, row: &Row) -> Result<()> {
        for (signals, point) in self.axes.iter_mut().zip(&row.axes) {
            let set_point = Pos(point.pos.0.wrapping_sub(signals.zero.0));
            let before = std::mem::replace(&mut signals.set_point, set_point);
            let Some((index, start)) = self.row else { continue };
            let length = row.t_ns.saturating_sub(start);
            let steps = step_generator::between(before, set_point);
            let count = steps.unsigned_abs();
            if count > length / 2 {
                return Err(TraceError::TooManySteps { axis: signals.axis, row: index, steps: count, row_ns: length });
            }
            if count > 0 && signals.backwards != (steps < 0) {
                signals.backwards = steps < 0;
                self.changes.push((start, signals.dir, LastValue::Level(steps < 0)));
            }
            for k in 0..count {
                let at = step_instant(k, count, length);
                let high = (length / count / 2).max(1);
                self.changes.push((start + at, signals.step, LastValue::Level(true)));
                self.changes.push((start + at + high, signals.step, LastValue::Level(false)));
            }
        }
        self.row = Some((row.index, row.t_ns));
        self.write(row.t_ns)
    }

    /// Writes the changes before `end` in the order of time.
    fn write(&mut self, end: u64) -> Result<()> {
        self.changes.sort_by_key(|(at, signal, _)| (*at, *signal));
        let due = self.changes.partition_point(|(at, ..)| *at < end);
        let mut due = self.changes.drain(..due).peekable();
        while let Some((at, place, last_value)) = due.next() {
            // Of several at one instant, the last one holds.
            if due.peek().is_some_and(|next| (next.0, next.1) == (at, place)) {
                continue;
            }
            let Some(signal) = self.signals.get_mut(place).filter(|signal| signal.last_value != last_value) else {
                continue;
            };
            signal.last_value = last_value;
            if self.time != at {
                self.out.timestamp(at)?;
                self.time = at;
            }
            show(&mut self.out, signal)?;
        }
        Ok(())
    }

    /// Writes the edges that are left and the end of time.
    pub fn finish(mut self) -> Result<()> {
        self.write(u64::MAX)?;
        if let Some((_, end)) = self.row
            && self.time < end
        {
            self.out.timestamp(end)?;
        }
        Ok(self.out.flush()?)
    }
}

/// What a DAC outputs, to the µV: 32767 is 10 V.
fn millivolts(code: i16) -> f64 {
    let microvolts = (f64::from(code) * 1e7 / 32_767.0).round();
    microvolts / 1e3
}

fn show<W: Write>(out: &mut vcd::Writer<W>, signal: &Signal) -> Result<()> {
    match signal.last_value {
        LastValue::Level(level) => out.change_scalar(signal.id, if level { Value::V1 } else { Value::V0 })?,
        LastValue::Number(number) => out.change_real(signal.id, number)?,
    }
    Ok(())
}

/// Instant of pulse `k` of `count` in a row of `length` ns: the closed form of
/// `servo::output::step_generator`, with a slot of 1 ns. `count` is at least 1 and at most
/// `length`.
fn step_instant(k: u64, count: u64, length: u64) -> u64 {
    let (k, n, s) = (u128::from(k), u128::from(count), u128::from(length));
    // Below `length`, since k < count.
    (((k + 1) * s - s / 2).div_ceil(n) - 1) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_those_of_the_slots() {
        for length in [10u32, 999, 50_000] {
            for count in [1, 2, 3, length / 7 + 1, length / 2] {
                // The steps counted up slot by slot, from half a tick.
                let steps_before = |slot: u64| (u64::from(length) / 2 + slot * u64::from(count)) / u64::from(length);
                let at: Vec<u64> =
                    (0..u64::from(length)).filter(|slot| steps_before(slot + 1) > steps_before(*slot)).collect();
                let closed: Vec<u64> =
                    (0..u64::from(count)).map(|k| step_instant(k, count.into(), length.into())).collect();
                assert_eq!(at, closed, "{count} in {length}");
            }
        }
    }
}
