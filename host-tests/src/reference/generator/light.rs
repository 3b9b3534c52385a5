//! Laser channels: set up, switched by calls and by paths, and asked.
use super::Making;
use crate::reference::{Call, LightCall, LightOf};

impl Making<'_> {
    fn light_call(&mut self, channel: i16, what: LightOf) {
        self.calls.push(Call::Light(LightCall { channel, what }));
    }

    /// Only one profile has lasers beside the axes of the programs.
    pub(super) fn lights(&mut self) {
        if self.site.profile != "gus" {
            return;
        }
        let channel = if self.one_in(30) { self.pick(&[-1, 2]) } else { self.below(2) as i16 };
        if !self.one_in(3) {
            self.light_call(channel, LightOf::Connector);
            self.light_call(channel, LightOf::Carrier(20.0));
            let max = self.pick(&[100.0, 80.0, 101.0]);
            let min = self.pick(&[0.0, 0.0, 10.0]);
            self.light_call(channel, LightOf::Bounds { max, min });
            let power = self.power();
            self.light_call(channel, LightOf::Power(power));
        }
        for _ in 0..1 + self.below(3) {
            self.light(channel);
        }
    }

    fn power(&mut self) -> f64 {
        if self.one_in(20) { self.pick(&[-1.0, 100.5]) } else { self.below(1001) as f64 / 10.0 }
    }

    pub(super) fn light(&mut self, channel: i16) {
        let what = match self.below(12) {
            0..4 => LightOf::Gate(true),
            4 | 5 => LightOf::Gate(false),
            6 => LightOf::Power(self.power()),
            7 => LightOf::Map(self.pick(&[1, 2, 3, 0, 4])),
            8 | 9 => LightOf::GetGate,
            _ => LightOf::GetPower,
        };
        self.light_call(channel, what);
    }

    /// An entry of a path.
    pub(super) fn laser_command(&mut self) -> crate::reference::Command {
        use crate::reference::Command;
        match self.below(5) {
            0 | 1 => Command::Gate(true),
            2 | 3 => Command::Gate(false),
            _ => Command::Power(self.power()),
        }
    }
}
