//! Outputs and inputs.
use super::super::axis::Axis;
use super::super::call::{Call, members};
use super::super::effect::Effect;
use super::super::light::Mode;
use super::answer::{Answer, DONE, check, range};
use super::{Controller, Edge};

/// General outputs of the virtual controller.
const GENERAL_OUTPUTS: i16 = 32;
/// Its analog outputs, and inputs.
const ANALOG_OUTPUTS: i16 = 8;
/// The most of an analog input, V.
const ANALOG_INPUT_VOLTS: f64 = 12.5;

impl Controller {
    pub(super) fn effect(&mut self, index: usize, call: &Call, effect: &Effect, now: i64) -> Answer {
        match *effect {
            Effect::SetDo { value, .. } | Effect::SetDoEx { value, .. } => {
                self.changes.push((now as f64 / 1e6, u32::MAX, value.cast_unsigned()));
            }
            Effect::SetDoBit { index, level, .. } => {
                range((1..=GENERAL_OUTPUTS).contains(&index))?;
                let bit = 1 << (index - 1);
                self.changes.push((now as f64 / 1e6, bit, if level { bit } else { 0 }));
            }
            Effect::SetDac { dac, value, .. } => {
                range((1..=ANALOG_OUTPUTS).contains(&dac))?;
                check(!self.is_of_laser(dac))?;
                self.analog.push((now as f64 / 1e6, dac as usize - 1, value));
            }
            Effect::GetDac { dac, .. } => {
                range((1..=ANALOG_OUTPUTS).contains(&dac))?;
                return Ok(self.read(index, call, 0));
            }
            Effect::GetDo { .. } => return Ok(self.read(index, call, 0)),
            Effect::GetDoEx { count, .. } => {
                range(count > 0)?;
                return Ok(self.read(index, call, 0));
            }
            Effect::GetDiEx { kind, count, .. } => {
                range(matches!(kind, 0..=5) && count > 0)?;
                return Ok(self.read(index, call, 0));
            }
            Effect::GetDi { kind, .. } => {
                range(matches!(kind, 0..=5))?;
                return Ok(self.read(index, call, 0));
            }
            Effect::Interlock { open, .. } => self.interlock.open = open,
            Effect::SetInterlock { motion } => {
                range((0..3).contains(&motion))?;
                self.interlock.motion = motion;
            }
            Effect::SimAdc { adc, volts, .. } => {
                range((1..=ANALOG_OUTPUTS).contains(&adc) && volts.abs() <= ANALOG_INPUT_VOLTS)?;
                self.levels.volts[adc as usize - 1] = volts;
            }
            Effect::GetAdc { adc, .. } => {
                range((1..=ANALOG_OUTPUTS).contains(&adc))?;
                return Ok(self.read(index, call, 0));
            }
            Effect::SimInput { index, level, .. } => {
                range((1..=32).contains(&index))?;
                self.levels.input(index, level);
            }
        }
        DONE
    }

    /// Levels of the inputs of a type, as GetDi has them. General ones belong to all cores.
    pub(super) fn inputs_of(&self, core: i16, kind: i16) -> i64 {
        if kind == 4 {
            return self.levels.inputs.cast_signed().into();
        }
        let bit = |(axis_index, axis): (usize, &Axis)| {
            let (of, number) = self.setup.axes[axis_index];
            if of == core { i64::from(axis.terminals.levels >> kind & 1) << (number - 1) } else { 0 }
        };
        self.axes.iter().map(Box::as_ref).enumerate().map(bit).sum()
    }

    /// A level, an input that counts or does not, a capture.
    pub(super) fn terminal(&mut self, call: &Call) -> Answer {
        match *call {
            Call::Terminal { axis, kind, level } => {
                range(matches!(kind, 0..=3 | 5))?;
                let of = &mut self.axes[axis].terminals;
                of.levels = if level { of.levels | 1 << kind } else { of.levels & !(1 << kind) };
            }
            Call::Guard { axis, kind, on } => {
                range(matches!(kind, -1..=2))?;
                self.open = self.open.or(self.start_beside_guard());
                let bits = if kind < 0 { 3 } else { 1 << kind };
                let of = &mut self.axes[axis].terminals;
                of.on = if on { of.on | bits } else { of.on & !bits };
            }
            Call::Sense { core, sense } => {
                range(self.cores.contains(&core))?;
                self.open = self.open.or(self.start_beside_guard());
                for (axis_index, axis) in self.axes.iter_mut().enumerate() {
                    let (of, number) = self.setup.axes[axis_index];
                    if of == core && number <= 8 {
                        axis.terminals.sense = (sense >> (2 * (number - 1)) & 3) as u8;
                    }
                }
            }
            Call::SetCapture { axis, mode } => {
                range(matches!(mode, 1 | 2))?;
                let of = &mut self.axes[axis].terminals;
                (of.armed, of.index[0], of.captured) = (mode == 1, mode == 2, None);
            }
            _ => {}
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
        self.levels.passed = analog.iter().map(|&(_, channel, value)| (channel, value)).collect();
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

impl Controller {
    /// Whether a limit that changes at the instant of a CrdStart stops that path is not said.
    fn start_beside_guard(&self) -> Option<&'static str> {
        let starts = self.crds.values().any(|crd| crd.started_here);
        starts.then_some("a limit that changes at the instant at which a path starts")
    }
}
