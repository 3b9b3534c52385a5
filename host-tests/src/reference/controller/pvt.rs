//! PVT: tables, selections, starts.
use super::super::axis::{Axis, Mode, Motion, Why};
use super::super::call::{Call, members};
use super::super::number::Fix;
use super::super::pt::Timed;
use super::answer::{Answer, DONE, EITHER, check, either};
use super::{Controller, Reply, Then};

impl Controller {
    pub(super) fn pvt(&mut self, call: &Call, now: i64) -> Answer {
        match call {
            Call::PvtTable { axis, table, points } => {
                let core = self.cores[*axis];
                let names = |(axis_index, axis): (usize, &Axis)| {
                    self.cores[axis_index] == core
                        && axis.mode == Mode::Pvt
                        && (axis.pvt.1 == *table || axis.table == *table)
                };
                // An axis that brakes runs no table any more.
                let runs = |axis: &Axis| matches!(axis.motion, Some(Motion::Pvt(_)));
                let stops = |axis_index: usize| matches!(self.then[axis_index], Some(Then::Brake(..)));
                let named: Vec<usize> = (0..self.axes.len()).filter(|at| names((*at, &self.axes[*at]))).collect();
                check(!named.iter().any(|at| runs(&self.axes[*at]) && !stops(*at)))?;
                // It waits for a Stop of its instant, and what follows it is late by a tick.
                self.belated |= named.iter().any(|at| runs(&self.axes[*at]) || self.axes[*at].halted);
                self.tables.insert((core, *table), points.table());
            }
            Call::PvtTableSelect { axis: axis_index, table } => {
                let axis = &mut self.axes[*axis_index];
                check(axis.mode == Mode::Pvt)?;
                let Some(found) = self.tables.get(&(self.cores[*axis_index], *table)) else { return Err(EITHER) };
                if let Some(Motion::Pvt(timed)) = &mut axis.motion {
                    if axis.table != *table && axis.pvt.1 != *table {
                        // Which tables are in use until the switch is more than one.
                        timed.pending = Some(found.curve.clone());
                        axis.next_begins = found.begins;
                        axis.pvt.1 = *table;
                    } else {
                        self.open = Some("PvtTableSelect of the table that runs");
                    }
                } else if axis.runs() {
                    self.open = Some("PvtTableSelect while a PVT axis brakes");
                } else {
                    axis.pvt.1 = *table;
                }
            }
            Call::SetPvtLoop { axis, loops } => {
                let axis = &mut self.axes[*axis];
                either(axis.mode == Mode::Pvt, *loops >= 0)?;
                axis.pvt.0 = i64::from(*loops);
            }
            Call::PvtStart { mask } => {
                for axis_index in members(*mask) {
                    let axis = &self.axes[axis_index];
                    check(axis.mode == Mode::Pvt && !axis.runs() && !axis.blocked())?;
                    check(self.tables.contains_key(&(self.cores[axis_index], axis.pvt.1)))?;
                }
                for axis_index in members(*mask) {
                    let axis = &mut self.axes[axis_index];
                    let table = &self.tables[&(self.cores[axis_index], axis.pvt.1)];
                    let timed = Timed::new(table.curve.clone(), Fix::ms(now), axis.x).after(table.begins);
                    (axis.pvt.2, axis.began, axis.table) = (0, true, axis.pvt.1);
                    (axis.table_begins, axis.next_begins) = (table.begins, table.begins);
                    axis.motion = Some(Motion::Pvt(timed));
                    axis.ending = Why::End;
                }
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }
}
