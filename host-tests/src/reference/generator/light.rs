//! Laser channels: set up, switched by calls and by paths, and asked.
use super::Making;
use crate::reference::{Call, Command, LightCall, LightOf};

impl Making<'_> {
    fn light_call(&mut self, channel: i16, what: LightOf) {
        self.calls.push(Call::Light(LightCall { channel, what }));
    }

    /// Only one profile has lasers beside the axes of the programs.
    pub(super) fn lights(&mut self) {
        if self.setup.profile != "gus" {
            return;
        }
        let channel = if self.one_in(30) { self.pick(&[-1, 2]) } else { self.below(2) as i16 };
        if !self.one_in(3) {
            self.set_up_light(channel);
        }
        if self.one_in(3) {
            self.light_table(channel);
        }
        for _ in 0..1 + self.below(3) {
            self.light(channel);
        }
    }

    /// A channel as users set it up: connector, mode, carrier, delays, power.
    pub(super) fn set_up_light(&mut self, channel: i16) {
        self.light_call(channel, LightOf::Connector(true));
        if self.one_in(3) {
            self.light_mode(channel);
        } else {
            let max = self.pick(&[100.0, 80.0, 101.0]);
            let min = self.pick(&[0.0, 0.0, 10.0]);
            self.light_call(channel, LightOf::Mode { mode: 0, max, min, delayed: true });
        }
        self.light_call(channel, LightOf::Carrier(20.0));
        if self.one_in(2) {
            self.delays(channel);
        }
        if self.one_in(6) {
            self.suppression(channel);
        }
        let power = self.power();
        self.light_call(channel, LightOf::Power(power));
    }

    fn light_mode(&mut self, channel: i16) {
        let mode = if self.one_in(20) { self.pick(&[-1, 4]) } else { self.pick(&[0, 1, 2, 3]) };
        let most = match mode {
            1 => self.pick(&[50.0, 24.0, 2000.0]),
            2 => 10.0,
            _ => 100.0,
        };
        let max = if self.one_in(12) { -1.0 } else { most * self.pick(&[1.0, 1.0, 0.5]) };
        let min = if self.one_in(3) { most * self.pick(&[0.1, 0.6, 1.1]) } else { 0.0 };
        let delayed = !self.one_in(3);
        self.light_call(channel, LightOf::Mode { mode, max, min, delayed });
        if mode == 1 {
            let width = if self.one_in(12) { self.pick(&[0, 70_000]) } else { 1 + self.below(20) as u32 };
            self.light_call(channel, LightOf::Width(width));
        }
        match self.below(6) {
            0 => {
                let (on, khz) = (!self.one_in(4), self.pick(&[1.0, 5.0, 30.0]));
                let duty = self.pick(&[2.0, 10.0, 0.0]);
                self.light_call(channel, LightOf::Standby { on, khz, duty });
            }
            1 => {
                let (on, volts) = (!self.one_in(4), self.pick(&[0.5, 1.0, 12.0]));
                self.light_call(channel, LightOf::PreVoltage { on, volts });
            }
            _ => {}
        }
    }

    /// µs: below a tick, about one, and several.
    fn delays(&mut self, channel: i16) {
        let most = self.pick(&[20, 300, 3000]);
        let (off, on) = (self.below(most) as u32, self.below(most) as u32);
        let off = if self.one_in(30) { 70_000 } else { off };
        self.light_call(channel, LightOf::Delays { off, on });
    }

    fn suppression(&mut self, channel: i16) {
        if self.one_in(4) {
            return self.light_call(channel, LightOf::NoFpk);
        }
        let most = self.pick(&[30, 400]);
        let times = [self.below(most) as u32, self.below(most) as u32, self.below(most) as u32];
        self.light_call(channel, LightOf::Fpk(times));
    }

    fn power(&mut self) -> f64 {
        if self.one_in(20) { self.pick(&[-1.0, 100.5]) } else { self.below(1001) as f64 / 10.0 }
    }

    pub(super) fn light(&mut self, channel: i16) {
        let what = match self.below(16) {
            0..3 => LightOf::Gate(true),
            3 | 4 => LightOf::Gate(false),
            5 if self.one_in(8) => LightOf::Switch(2),
            5 => LightOf::Switch(u16::from(self.one_in(2))),
            6 => LightOf::Power(self.power()),
            7 => LightOf::Map(self.pick(&[1, 2, 3, 0, 4])),
            8 => self.pick(&[LightOf::GetGate, LightOf::GetSwitched, LightOf::GetMap]),
            9 => LightOf::GetPower,
            10 => return self.delays(channel),
            11 if self.one_in(3) => return self.suppression(channel),
            11 if self.one_in(2) => return self.both_lasers(),
            11 => return self.light_mode(channel),
            12 => self.pick(&[LightOf::GetOnTime, LightOf::ZeroOnTime]),
            13 => self.pick(&[LightOf::GetFault, LightOf::ClearFault]),
            14 if self.one_in(6) => LightOf::Connector(false),
            14 => LightOf::EndFollow(1 + self.below(3) as i32),
            _ => return self.distance(channel),
        };
        self.light_call(channel, what);
    }

    pub(super) fn distance(&mut self, channel: i16) {
        if self.one_in(3) {
            return self.light_call(channel, LightOf::Distance(None));
        }
        let source = if self.one_in(30) { 2 } else { self.pick(&[0, 0, 1]) };
        let from = [0, 1, 2, 3].map(|_| self.below(200) as i32 - 100);
        let scale = if self.one_in(30) { 0.0 } else { self.pick(&[1.0, 10.0, 2.5]) };
        self.light_call(channel, LightOf::Distance(Some((source, from, [scale; 4]))));
        let ratio = [0, 1, 2].map(|_| (self.below(41) as f64 - 20.0) / 100.0);
        let bounds = self.pick(&[[0.0, 100.0], [5.0, 10.0], [0.0, 9.0], [1.0, 0.0]]);
        self.light_call(channel, LightOf::Ratios([ratio[0], ratio[1], ratio[2], 0.0], bounds));
    }

    /// What both channels share.
    fn both_lasers(&mut self) {
        let what = match self.below(3) {
            0 => LightOf::Resolution(self.pick(&[0, 1, 0, 1, 2])),
            _ => {
                let (on, khz) = (!self.one_in(4), self.pick(&[1.0, 5.0, 30.0, 90.0]));
                LightOf::StandbyBoth { on, khz, duty: self.pick(&[2.0, 10.0, 0.0]) }
            }
        };
        self.light_call(0, what);
    }

    /// An entry of a path.
    pub(super) fn laser_command(&mut self) -> Command {
        match self.below(8) {
            0 | 1 => Command::Gate(true),
            2 | 3 => Command::Gate(false),
            4 => Command::Power(self.power()),
            5 => self.follow_entry(),
            6 => Command::Source { encoder: self.one_in(2), start: self.one_in(2).then(|| self.below(100) as f64) },
            _ => Command::FollowOff,
        }
    }

    /// BufLaserFollowRatio or BufLaserPrfFollow.
    pub(super) fn follow_entry(&mut self) -> Command {
        let ratio = if self.one_in(30) { 0.0 } else { self.chance.log(0.02, 5.0) };
        let (min, max) = (self.pick(&[0, 5, 20]), self.pick(&[100, 60, 10]));
        if self.one_in(3) {
            return Command::Table(self.table_number(), [min.into(), max.into()]);
        }
        if self.one_in(2) {
            Command::Follow(ratio, [min, max])
        } else {
            Command::Ratio([ratio, min.into(), max.into()])
        }
    }
}
