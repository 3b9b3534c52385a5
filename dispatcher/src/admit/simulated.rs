//! Simulated inputs, for a board that has no wires: the virtual and the emulated one (SPEC 7).
//!
//! In: a level or a voltage at a terminal, before sense. Out: a tick command. Owns
//! nothing.
//! Fails: always on a board with wires, with a reason.
use super::context::Context;
use crate::refuse::{Admitted, Refused, choice, real, within};
use crate::report::answer::Answer;
use crate::shadow::ShadowChange;
use protocol::command::{SimAdc, SimInput, SimPlan};
use protocol::reason::Reason;
use protocol::values::{ANALOG_INPUT_VOLTS, io as kind};
use servo::port::Simulated;
use servo::tick_command::TickCommand;
use servo::units::Ns;

/// The latest row of a plan: a year, in ns.
const LATEST_NS: u64 = 365 * 86_400 * 1_000_000_000;

pub fn input<const AXES: usize>(context: &mut Context<AXES>, r: &SimInput) -> Admitted<Answer> {
    context.unwired_rows()?;
    let input = context.simulated_level(r.core.get(), 1, (r.di_type.get(), r.index.get(), r.level.get()))?;
    context.only(TickCommand::Simulate(input), ShadowChange::None)
}

pub fn analog<const AXES: usize>(context: &mut Context<AXES>, r: &SimAdc) -> Admitted<Answer> {
    context.unwired_rows()?;
    let input = context.simulated_voltage(r.core.get(), (1, 2), r.adc.get(), r.volts.get())?;
    context.only(TickCommand::Simulate(input), ShadowChange::None)
}

/// A row of a plan: rows come in order of time, row 0 begins another plan.
pub fn plan<const AXES: usize>(context: &mut Context<AXES>, r: &SimPlan) -> Admitted<Answer> {
    let rows = context.unwired_rows()?;
    let row = within(1, r.row.get(), 0, rows - 1)?;
    let of_script = within(2, r.from, 0, 1)? == 1;
    let after = r.at_ns.get();
    if after > LATEST_NS {
        return Err(Refused::range(3, after as f64, 0.0, LATEST_NS as f64));
    }
    let (core, value) = (r.core.get(), r.value.get());
    let input = if r.di_type.get() == kind::ADC {
        context.simulated_voltage(core, (5, 6), r.index.get(), value)?
    } else {
        let level = real(6, value, 0.0, 1.0)?;
        if level != 0.0 && level != 1.0 {
            return Err(Refused::new(Reason::Selector).field(6).got(level).limits(0.0, 1.0));
        }
        context.simulated_level(core, 4, (r.di_type.get(), r.index.get(), level as i16))?
    };
    context.only(TickCommand::Plan { row, after: Ns(after), of_script, input }, ShadowChange::None)
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Refuses on a board whose inputs are wired.
    fn unwired_rows(&self) -> Admitted<u16> {
        match self.board.planned_inputs {
            0 => Err(Refused::new(Reason::InputsWired)),
            rows => Ok(rows),
        }
    }

    /// A digital input; type, number and level are fields from `field` on.
    fn simulated_level(&self, core: i16, field: u8, (which, index, level): (i16, i16, i16)) -> Admitted<Simulated> {
        match which {
            kind::INTERLOCK => {
                self.core(core)?;
                choice(field + 1, index, 1, 1)?;
                Ok(Simulated::Interlock(choice(field + 2, level, 0, 1)? == 1))
            }
            kind::LIMIT_POSITIVE..=kind::ARRIVE => {
                let (input, index, high) = self.input_bit(core, field, (which, index, level))?;
                Ok(Simulated::Level { input, index, high })
            }
            _ => {
                self.core(core)?;
                let limits = (kind::LIMIT_POSITIVE.into(), kind::ARRIVE.into());
                Err(Refused::new(Reason::InputType).field(field).got(which.into()).limits(limits.0, limits.1))
            }
        }
    }

    /// An analog input: its number and its voltage, which are these fields.
    fn simulated_voltage(&self, core: i16, fields: (u8, u8), adc: i16, volts: f64) -> Admitted<Simulated> {
        self.core(core)?;
        let channel = choice(fields.0, adc, 1, i16::from(self.board.analog_inputs.min(8)))? as u8 - 1;
        let volts = real(fields.1, volts, -ANALOG_INPUT_VOLTS, ANALOG_INPUT_VOLTS)?;
        // To the nearest code, as a converter does; the upper end is limited to the highest code.
        let code = libm::round(volts * (32768.0 / ANALOG_INPUT_VOLTS)).min(32767.0) as i16;
        Ok(Simulated::Analog { channel, code })
    }
}
