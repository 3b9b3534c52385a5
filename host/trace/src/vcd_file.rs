//! Rows as a VCD of 1 ns: `axisN_step`, `axisN_dir`, `doN`.
//!
//! In: rows, and the digital outputs' edges in the order of time. Out: value changes. The whole
//! pulses between two rows are spread over the time between them as `servo::steps` says; a step is
//! high for half the distance to the next. Owns at most one row's changes.
use crate::row::{AxisName, Header, OutputEdge, Row};
use crate::{Result, TraceError};
use servo::steps;
use servo::units::Pos;
use std::collections::VecDeque;
use std::io::Write;
use vcd::{IdCode, TimescaleUnit, Value};

/// Wires of one axis and what they show now.
struct AxisWires {
    axis: AxisName,
    step: IdCode,
    dir: IdCode,
    backwards: bool,
    pos: Pos,
}

/// Writes rows and edges as they come.
pub struct VcdWriter<W: Write> {
    out: vcd::Writer<W>,
    axes: Vec<AxisWires>,
    outputs: Vec<(u8, IdCode)>,
    row: Option<(u32, u64)>,
    edges: VecDeque<OutputEdge>,
    time: Option<u64>,
}

impl<W: Write> VcdWriter<W> {
    /// Declares the wires: two for each axis of the header, one for each output
    /// (its number from 1, and its level at the start).
    pub fn new(out: W, header: &Header, outputs: &[(u8, bool)]) -> Result<Self> {
        let mut out = vcd::Writer::new(out);
        out.timescale(1, TimescaleUnit::NS)?;
        out.add_module("beamtick")?;
        let mut axes = Vec::new();
        for &axis in &header.axes {
            axes.push(AxisWires {
                axis,
                step: out.add_wire(1, &format!("{axis}_step"))?,
                dir: out.add_wire(1, &format!("{axis}_dir"))?,
                backwards: false,
                pos: Pos(0),
            });
        }
        let mut wires = Vec::new();
        for &(n, level) in outputs {
            wires.push((n, out.add_wire(1, &format!("do{n}"))?, level));
        }
        out.upscope()?;
        out.enddefinitions()?;
        out.timestamp(0)?;
        for id in axes.iter().flat_map(|a| [a.step, a.dir]) {
            out.change_scalar(id, Value::V0)?;
        }
        for (_, id, level) in &wires {
            out.change_scalar(*id, *level)?;
        }
        let outputs = wires.into_iter().map(|(n, id, _)| (n, id)).collect();
        Ok(VcdWriter { out, axes, outputs, row: None, edges: VecDeque::new(), time: Some(0) })
    }

    /// Takes an output's edge; it is written with the row after it.
    pub fn edge(&mut self, edge: OutputEdge) {
        self.edges.push_back(edge);
    }

    /// Takes a row and writes all changes before it.
    pub fn row(&mut self, row: &Row) -> Result<()> {
        let mut changes: Vec<(u64, IdCode, Value)> = Vec::new();
        if let Some((index, start)) = self.row {
            let length = row.t_ns.saturating_sub(start);
            for (wires, point) in self.axes.iter_mut().zip(&row.axes) {
                let steps = steps::between(wires.pos, point.pos);
                wires.pos = point.pos;
                let count = steps.unsigned_abs();
                if count > length / 2 {
                    return Err(TraceError::TooManySteps {
                        axis: wires.axis,
                        row: index,
                        steps: count,
                        row_ns: length,
                    });
                }
                if count > 0 && wires.backwards != (steps < 0) {
                    wires.backwards = steps < 0;
                    changes.push((start, wires.dir, if steps < 0 { Value::V1 } else { Value::V0 }));
                }
                for k in 0..count {
                    let at = step_instant(k, count, length);
                    let high = (length / count / 2).max(1);
                    changes.push((start + at, wires.step, Value::V1));
                    changes.push((start + at + high, wires.step, Value::V0));
                }
            }
        } else {
            for (wires, point) in self.axes.iter_mut().zip(&row.axes) {
                wires.pos = point.pos;
            }
        }
        while self.edges.front().is_some_and(|e| e.t_ns < row.t_ns) {
            let Some(edge) = self.edges.pop_front() else { break };
            self.push_edge(edge, &mut changes);
        }
        self.row = Some((row.index, row.t_ns));
        self.write(changes)
    }

    fn push_edge(&self, edge: OutputEdge, changes: &mut Vec<(u64, IdCode, Value)>) {
        if let Some((_, id)) = self.outputs.iter().find(|(n, _)| *n == edge.output) {
            changes.push((edge.t_ns, *id, if edge.level { Value::V1 } else { Value::V0 }));
        }
    }

    /// Writes changes in the order of time.
    fn write(&mut self, mut changes: Vec<(u64, IdCode, Value)>) -> Result<()> {
        changes.sort_by_key(|c| c.0);
        for (at, id, value) in changes {
            if self.time != Some(at) {
                self.out.timestamp(at)?;
                self.time = Some(at);
            }
            self.out.change_scalar(id, value)?;
        }
        Ok(())
    }

    /// Writes the edges that are left and the end of time.
    pub fn finish(mut self) -> Result<()> {
        let mut changes = Vec::new();
        while let Some(edge) = self.edges.pop_front() {
            self.push_edge(edge, &mut changes);
        }
        self.write(changes)?;
        if let Some((_, end)) = self.row
            && self.time.is_none_or(|t| t < end)
        {
            self.out.timestamp(end)?;
        }
        Ok(self.out.flush()?)
    }
}

/// Instant of pulse `k` of `count` in a row of `length` ns: the closed form of `servo::steps`, with
/// a slot of 1 ns. `count` is at least 1 and at most `length`.
fn step_instant(k: u64, count: u64, length: u64) -> u64 {
    let (k, n, s) = (u128::from(k), u128::from(count), u128::from(length));
    // Below `length`, since k < count.
    (((k + 1) * s - s / 2).div_ceil(n) - 1) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use servo::steps::Slots;

    #[test]
    fn instants_are_those_of_the_slots() {
        for length in [10u32, 999, 50_000] {
            for count in [1, 2, 3, length / 7 + 1, length / 2] {
                let mut slots = Slots::new(count, length).unwrap();
                let at: Vec<u64> = (0..u64::from(length)).filter(|_| slots.advance()).collect();
                let closed: Vec<u64> =
                    (0..u64::from(count)).map(|k| step_instant(k, count.into(), length.into())).collect();
                assert_eq!(at, closed, "{count} in {length}");
            }
        }
    }
}
