//! Outputs and inputs.
use super::super::call::Call;
use super::super::effect::Effect;
use super::Controller;
use super::answer::{Answer, DONE, range};

/// General outputs of the virtual controller.
const OUTPUTS: i16 = 32;
/// Its analog outputs.
const ANALOG: i16 = 8;

impl Controller {
    pub(super) fn effect(&mut self, index: usize, call: &Call, effect: &Effect) -> Answer {
        match *effect {
            Effect::SetDo { value, .. } => self.levels.general = value.cast_unsigned(),
            Effect::SetDoBit { index, level, .. } => {
                range((1..=OUTPUTS).contains(&index))?;
                self.levels.set(index, level);
            }
            Effect::SetDac { dac, value, .. } => {
                range((1..=ANALOG).contains(&dac))?;
                self.levels.analog[dac as usize - 1] = value;
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
}
