//! Calls of laser channels, and Stops as they see them.
use super::super::call::{Call, members};
use super::super::effect::{LightCall, LightOf};
use super::super::light::{Act, Command, crds};
use super::answer::{Answer, DONE, check, either, range};
use super::{Controller, Reply};

/// kHz, of the GUS family.
const CARRIER: std::ops::RangeInclusive<f64> = 0.001..=2000.0;
/// %.
const DUTY: std::ops::RangeInclusive<f64> = 0.0..=100.0;

impl Controller {
    fn path_runs(&self, crds_of: u8) -> bool {
        crds(crds_of.into()).any(|crd| self.crds.get(&(1, crd as i16 + 1)).is_some_and(|of| of.runs))
    }

    /// A call needs these to be at standstill.
    fn contest(&mut self, crds_of: u8) {
        let axes = self.path_axes(1, crds_of.into());
        if members(axes).any(|axis| self.axes[axis].ended) {
            self.open = Some("a call that needs standstill, right after its axis came to rest");
        }
        self.contested[0] |=
            members(axes).filter(|axis| self.axes[*axis].driven).fold(0, |mask, axis| mask | 1 << axis);
    }

    pub(super) fn light(&mut self, index: usize, call: &Call, of: &LightCall) -> Answer {
        range((0..2).contains(&of.channel))?;
        let number = of.channel as usize;
        let after = self.light.after_calls(number);
        let channel = &mut self.light.channels[number];
        match of.what {
            LightOf::Connector => channel.connector = true,
            LightOf::Bounds { max, min } => {
                let good = DUTY.contains(&max) && DUTY.contains(&min) && min <= max;
                self.contest(3);
                either(!self.path_runs(3), good)?;
                self.light.channels[number].bounds = [min, max];
            }
            LightOf::Carrier(khz) => {
                range(khz == 0.0 || CARRIER.contains(&khz))?;
                channel.carrier = khz != 0.0;
            }
            LightOf::Gate(on) => {
                check(!on || after.connector && !after.fault)?;
                self.light.calls.push(Act::Own(number, Command::Gate(on)));
                *self.used.entry("lasers switched by calls").or_default() += 1;
            }
            LightOf::Power(power) => {
                range(DUTY.contains(&power))?;
                self.light.calls.push(Act::Own(number, Command::Power(power)));
            }
            LightOf::Map(map) => {
                range((0..4).contains(&map))?;
                let both = map as u8 | after.map;
                self.contest(both);
                check(!self.path_runs(both) && !after.is_of_path(both))?;
                self.light.channels[number].map = map as u8;
            }
            LightOf::GetGate | LightOf::GetPower => {
                if self.path_runs(3) {
                    return Ok(Reply::Open);
                }
                return Ok(self.read(index, call, 0));
            }
        }
        DONE
    }

    /// A Stop names these coordinate systems of core 1, bit 0 is crd 1.
    pub(super) fn stop_light(&mut self, named: u8) {
        if named == 0 {
            return;
        }
        let runs = crds(named.into()).filter(|crd| self.path_runs(1 << crd)).fold(0, |mask, crd| mask | 1 << crd);
        if runs != 0
            && self.light.channels.iter().any(|channel| channel.map & !runs != 0 && channel.map & runs != 0)
            && runs != named
        {
            self.open = Some("a Stop of one of two coordinate systems that gate a laser");
        }
        let set =
            crds(named.into()).filter(|crd| self.crds.get(&(1, *crd as i16 + 1)).is_some_and(|of| of.set.is_some()));
        let known = set.fold(0, |mask, crd| mask | 1 << crd);
        self.light.calls.push(Act::Stop(known));
    }
}
