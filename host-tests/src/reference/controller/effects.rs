//! Outputs and inputs.
use super::super::call::{Call, members};
use super::super::effect::Effect;
use super::super::light::Mode;
use super::answer::{Answer, DONE, check, range};
use super::{Controller, Edge};

/// General outputs of the virtual controller.
const OUTPUTS: i16 = 32;
/// Its analog outputs.
const ANALOG: i16 = 8;

impl Controller {
    pub(super) fn effect(&mut self, index: usize, call: &Call, effect: &Effect, now: i64) -> Answer {
        match *effect {
            Effect::SetDo { value, .. } => self.changes.push((now as f64 / 1e6, u32::MAX, value.cast_unsigned())),
            Effect::SetDoBit { index, level, .. } => {
                range((1..=OUTPUTS).contains(&index))?;
                let bit = 1 << (index - 1);
                self.changes.push((now as f64 / 1e6, bit, if level { bit } else { 0 }));
            }
            Effect::SetDac { dac, value, .. } => {
                range((1..=ANALOG).contains(&dac))?;
                check(!self.is_of_laser(dac))?;
                self.analog.push((now as f64 / 1e6, dac as usize - 1, value));
            }
            Effect::GetDac { dac, .. } => {
                range((1..=ANALOG).contains(&dac))?;
                return Ok(self.read(index, call, 0));
            }
            Effect::GetDo { .. } => return Ok(self.read(index, call, 0)),
            Effect::SimInput { index, level, .. } => {
                range((1..=32).contains(&index))?;
                self.levels.input(index, level);
            }
        }
        DONE
    }

    /// Whether an analog output, from 1, is that of a laser after the calls of this instant.
    pub(super) fn is_of_laser(&self, dac: i16) -> bool {
        let of = |channel: usize| self.light.after_calls(channel).law.mode == Mode::Analog;
        (1..=2).contains(&dac) && of(dac as usize - 1)
    }

    /// Outputs, in the order of time.
    pub(super) fn change_outputs(&mut self) {
        let mut analog = std::mem::take(&mut self.analog);
        analog.sort_by(|a, b| a.0.total_cmp(&b.0));
        let driven = self.light.analog();
        analog.into_iter().for_each(|(_, channel, value)| self.levels.analog[channel] = value);
        // It leaves its output at 0 V.
        members(driven.into()).for_each(|channel| self.levels.analog[channel] = 0);
        self.levels.driven = driven;
        let mut changes = std::mem::take(&mut self.changes);
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (ms, mask, value) in changes {
            let after = self.levels.general & !mask | value & mask;
            for bit in members(after ^ self.levels.general) {
                self.edges.push(Edge { ms, bit: bit as u8, level: after >> bit & 1 == 1 });
            }
            self.levels.general = after;
        }
    }
}
