//! Outputs and inputs by calls.
use super::Making;
use crate::reference::{Call, Effect};

impl Making<'_> {
    pub(super) fn outputs(&mut self) {
        for _ in 0..1 + self.below(4) {
            let core = self.pick(&[1, self.setup.axes.last().map_or(1, |axis| axis.0)]);
            let index = if self.one_in(12) { self.pick(&[0, 129, -1]) } else { 1 + self.below(6) as i16 };
            let dac = if self.one_in(12) { self.pick(&[0, 9]) } else { 1 + self.below(8) as i16 };
            let effect = match self.below(13) {
                8 => {
                    let volts = if self.one_in(12) { 12.6 } else { (self.below(2501) as f64 - 1250.0) / 100.0 };
                    Effect::SimAdc { core, adc: dac, volts }
                }
                9 => Effect::GetAdc { core, adc: dac },
                10 => Effect::SetDoEx { core, value: self.below(64) as i32 },
                11 => Effect::GetDoEx { core, count: i16::from(!self.one_in(12)) },
                0 => Effect::SetDo { core, value: self.below(64) as i32 },
                1 | 2 => Effect::SetDoBit { core, index, level: self.one_in(2) },
                3 | 4 => Effect::GetDo { core },
                5 => Effect::SetDac { core, dac, value: self.below(65536) as u16 as i16 },
                6 => Effect::GetDac { core, dac },
                _ => Effect::SimInput { core, index, level: self.one_in(2) },
            };
            self.calls.push(Call::Effect(effect));
        }
    }
}
