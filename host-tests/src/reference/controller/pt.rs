//! PT: data, FIFOs, starts.
use super::super::axis::{Axis, Mode};
use super::super::call::{Call, members};
use super::super::pt::Segment;
use super::answer::{Answer, DONE, check, either};
use super::{Controller, Reply, Then};

impl Controller {
    pub(super) fn pt_start(&mut self, mask: u32, option: u32, now: i64) -> Answer {
        let fifo = |axis_index: usize| (option >> axis_index & 1) as usize;
        for axis_index in members(mask) {
            let axis = &mut self.axes[axis_index];
            axis.broken |= axis.pt.dynamic && axis.blocked();
        }
        for axis_index in members(mask) {
            let axis = &self.axes[axis_index];
            check(axis.mode == Mode::Pt && !axis.runs() && !axis.blocked())?;
            check(!axis.pt.fifos[if axis.pt.dynamic { 0 } else { fifo(axis_index) }].is_empty())?;
        }
        for axis_index in members(mask) {
            self.axes[axis_index].start_pt(fifo(axis_index), now);
        }
        DONE
    }

    pub(super) fn pt(&mut self, index: usize, call: &Call) -> Answer {
        match *call {
            Call::PrfPt { axis, mode } => {
                let axis = &mut self.axes[axis];
                either(!axis.runs(), (0..2).contains(&mode))?;
                let dynamic = mode == 1;
                if axis.mode == Mode::Pt && axis.pt.dynamic != dynamic {
                    axis.pt.fifos = Default::default();
                    axis.pt.ran = 0;
                }
                axis.set_mode(Mode::Pt);
                axis.pt.dynamic = dynamic;
            }
            Call::PtData { axis, pos, time_ms, kind, fifo } => return self.pt_data(axis, pos, time_ms, kind, fifo),
            Call::PtClear { axis, fifo } => {
                let axis = &mut self.axes[axis];
                let fifo = axis.pt_fifo(fifo)?;
                check(!axis.runs() || !axis.pt.dynamic && axis.pt.running != fifo)?;
                axis.pt.fifos[fifo].clear();
            }
            Call::PtSpace { axis, fifo } => {
                if matches!(self.then[axis], Some(Then::Brake(..))) {
                    // The Stop of this instant comes before it.
                    self.axes[axis].end_stream();
                }
                let axis = &self.axes[axis];
                let fifo = axis.pt_fifo(fifo)?;
                if axis.broken && axis.pt.dynamic {
                    self.open = Some("data after a stream that a limit or an interlock ended");
                    return Ok(Reply::Open);
                }
                let free = axis.pt_capacity().wrapping_sub(axis.pt.fifos[fifo].len());
                return Ok(self.read(index, call, free));
            }
            Call::SetPtLoop { axis, loops } => {
                let axis = &mut self.axes[axis];
                check(axis.mode == Mode::Pt && !axis.pt.dynamic)?;
                axis.pt.loops = loops.into();
            }
            Call::SetPtMemory { axis, memory } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Pt && !axis.runs(), (0..2).contains(&memory))?;
                axis.pt.memory = memory;
                axis.pt.fifos = Default::default();
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    pub(super) fn pt_data(&mut self, axis_index: usize, pos: f64, time_ms: i32, kind: i16, fifo: i16) -> Answer {
        if matches!(self.then[axis_index], Some(Then::Brake(..))) {
            // The Stop of this instant comes before it.
            self.belated |= self.axes[axis_index].pt.dynamic && self.axes[axis_index].runs();
            self.axes[axis_index].end_stream();
        }
        let axis = &self.axes[axis_index];
        if axis.broken && axis.pt.dynamic {
            self.open = Some("data after a stream that a limit or an interlock ended");
        }
        let in_mode = axis.mode == Mode::Pt;
        let dynamic = axis.pt.dynamic;
        let bounds = (0..3).contains(&kind) && (dynamic || (0..2).contains(&fifo));
        either(in_mode, bounds)?;
        let fifo = if dynamic { 0 } else { fifo as usize };
        let held = axis.pt.fifos[fifo].len() - if dynamic && axis.runs() { axis.pt.ran } else { 0 };
        let last = axis.pt.fifos[fifo].last().map_or(0, |segment| segment.time_ms);
        if dynamic && axis.runs() && held >= axis.pt_capacity() {
            // It waits for room, which moves the clock (SPEC 7).
            self.open = Some("data that waits for room");
            return DONE;
        }
        either(held < axis.pt_capacity(), i64::from(time_ms) > last)?;
        let stops = matches!(self.then[axis_index], Some(Then::Brake(..)));
        let axis = &mut self.axes[axis_index];
        axis.pt.fifos[fifo].push(Segment { pos, time_ms: time_ms.into(), kind });
        if !stops {
            axis.pt_grew(fifo);
        }
        DONE
    }
}

impl Axis {
    fn pt_fifo(&self, fifo: i16) -> Result<usize, i16> {
        either(self.mode == Mode::Pt, self.pt.dynamic || (0..2).contains(&fifo))?;
        Ok(if self.pt.dynamic { 0 } else { fifo as usize })
    }
}
