//! PT: static FIFOs and streams.
use super::{Does, Making};
use crate::reference::Call;

impl Making<'_> {
    pub(super) fn pt_data(&mut self, axis: usize, fifo: usize) {
        let (time, pos) = self.pt[axis][fifo];
        let length = 1 + self.below(12) as i32;
        let step = self.number(60) * self.chance.sign() * f64::from(length).sqrt();
        let pos = if self.one_in(3) { (pos + step).round() } else { pos + step };
        let kind = self.pick(&[0, 0, 0, 1, 2]);
        self.pt[axis][fifo] = (time + length, pos);
        self.calls.push(Call::PtData { axis, pos, time_ms: time + length, kind, fifo: fifo as i16 });
    }

    pub(super) fn pt_static(&mut self, axis: usize) {
        self.rest(axis);
        self.calls.push(Call::PrfPt { axis, mode: 0 });
        self.does[axis] = Does::Pt;
        if self.one_in(12) {
            let memory = self.below(2) as i16;
            self.calls.push(Call::SetPtMemory { axis, memory });
            self.pt[axis] = Default::default();
        }
        let fifo = self.below(2) as usize;
        if !self.one_in(4) {
            self.calls.push(Call::PtClear { axis, fifo: fifo as i16 });
            self.pt[axis][fifo] = (0, 0.0);
        }
        let exactly_full = self.one_in(25);
        let count = if exactly_full { 31 + self.below(3) } else { 1 + self.below(5) };
        for _ in 0..count {
            self.pt_data(axis, fifo);
        }
        if self.one_in(3) {
            self.calls.push(Call::PtSpace { axis, fifo: fifo as i16 });
        }
        if self.one_in(2) {
            let loops = self.pick(&[0, 1, 2, 3, 7]);
            self.calls.push(Call::SetPtLoop { axis, loops });
        }
        self.calls.push(Call::PtStart { mask: 1 << axis, option: (fifo as u32) << axis });
    }

    pub(super) fn pt_stream(&mut self, axis: usize) {
        self.rest(axis);
        self.calls.push(Call::PrfPt { axis, mode: 1 });
        self.does[axis] = Does::Stream;
        self.calls.push(Call::PtClear { axis, fifo: 0 });
        self.pt[axis][0] = (0, 0.0);
        for _ in 0..2 + self.below(4) {
            self.pt_data(axis, 0);
        }
        self.calls.push(Call::PtStart { mask: 1 << axis, option: 0 });
        for _ in 0..self.below(4) {
            self.sleep(6);
            if self.one_in(2) {
                self.calls.push(Call::PtSpace { axis, fifo: 0 });
            }
            self.pt_data(axis, 0);
        }
    }
}
