//! Abort and Reset within a program: SPEC 9, and what each leaves (docs/safety.md).
use super::super::axis::{Axis, Why};
use super::super::call::members;
use super::super::light::Act;
use super::Controller;
use super::answer::{Answer, DONE, range};
use super::interlock::Interlock;

/// Ticks in which a Reset may put axes to power-on state: as many as it needs (SPEC 7).
pub(super) const RESET_TICKS: u8 = 4;

impl Controller {
    fn is_core(&self, core: i16) -> Result<(), i16> {
        range(self.cores.contains(&core))
    }

    /// Acts on the whole controller: dark at once, and all motion brakes.
    pub(super) fn abort(&mut self, core: i16) -> Answer {
        self.is_core(core)?;
        self.unsettle(u8::MAX);
        self.light.calls.push(Act::Abort);
        for axis_index in 0..self.axes.len() {
            self.stop_axis(axis_index, false, Why::Abort);
        }
        let running = self.crds.iter().filter(|(_, crd)| crd.runs).map(|(name, _)| *name).collect::<Vec<_>>();
        running.iter().for_each(|name| self.stop_path(*name, false, Why::Abort));
        let runs = |axis: &usize| self.axes[*axis].runs();
        self.aborted = (0..self.axes.len()).filter(runs).fold(0, |mask, axis| mask | 1 << axis);
        if self.aborted == 0 {
            self.light.calls.push(Act::AbortOver);
        }
        *self.used.entry("aborts").or_default() += 1;
        if self.aborted != 0 {
            *self.used.entry("aborts of motion").or_default() += 1;
        }
        DONE
    }

    /// What ran at an Abort and has come to rest no longer counts.
    pub(super) fn finish_abort(&mut self) {
        if self.aborted == 0 {
            return;
        }
        for (axis_index, axis) in self.axes.iter().enumerate() {
            if !axis.runs() {
                self.aborted &= !(1 << axis_index);
            }
        }
        if self.aborted == 0 {
            self.light.abort_over();
            self.rested = 2;
        }
    }

    /// Axes, tables and coordinate systems of the core, and the lasers, are as at power-on.
    /// Positions of the machine and outputs stay; where an axis is, is its new name 0.
    pub(super) fn reset(&mut self, core: i16, now: i64) -> Answer {
        self.is_core(core)?;
        if self.light.calls.iter().any(|act| !matches!(act, Act::Cleared(..))) {
            // A Reset may take more ticks than one: light is as what came before it asks.
            self.open = Some("light that is asked for at the instant of a Reset");
        }
        if self.interlock.is_cause() {
            self.open = Some("a Reset while the interlock is open");
        }
        // SPEC 9: what binds safety to a user falls back, whichever core it is.
        self.interlock.motion = Interlock::default().motion;
        for axis_index in (0..self.axes.len()).filter(|axis_index| self.cores[*axis_index] == core) {
            let axis = &mut self.axes[axis_index];
            if axis.runs() {
                *self.used.entry("resets of motion").or_default() += 1;
            }
            let (runs, x, encoder) = (axis.runs(), axis.x, axis.encoder);
            let slack = axis.slack + axis.late;
            let levels = axis.terminals.levels;
            **axis = Axis::new(0);
            axis.terminals.levels = levels;
            axis.why = if runs { Some(Why::Reset) } else { None };
            (axis.x, axis.zero, axis.track) = (x, x, vec![x; 2]);
            (axis.encoder, axis.encoder_zero) = (encoder, encoder[1]);
            (axis.slack, axis.zero_slack, axis.renamed, axis.halted) = (slack, slack, true, runs);
            (axis.resets, axis.is_lost) = (RESET_TICKS, runs || encoder[0] != encoder[1]);
            self.then[axis_index] = None;
        }
        self.tables.retain(|(of, _), _| *of != core);
        for (name, crd) in self.crds.iter().filter(|(name, crd)| name.0 == core && crd.runs) {
            let travelled = crd.distance_to(now as f64 / 1e6);
            // A path is ahead of the tick: those that it takes along anew are reported to run.
            let of = &crd.fifos[crd.fifo];
            self.early.extend(of.gears.iter().filter(|gear| !gear.is_engaged()).map(|gear| gear.axis));
            if travelled.is_none() {
                self.open = Some("a Reset in a tick in which a path ends or acts on others");
                self.early.extend(members(crd.fifos[crd.fifo].moves()));
            }
            if core == 1 {
                let most = crd.set.as_ref().map_or(0.0, |set| set.frame.speed);
                self.leaving.push((name.1 as usize - 1, travelled.unwrap_or(0.0), most));
            }
        }
        self.crds.retain(|(of, _), _| *of != core);
        self.path_then.retain(|((of, _), _)| *of != core);
        self.light.calls.push(Act::Reset);
        *self.used.entry("resets").or_default() += 1;
        DONE
    }
}
