//! Inputs of axes: limit switches, alarms, home; what they do to motion, and what reads tell of it.
use super::{MS, Making};
use crate::reference::{Call, Effect, Kind, LightCall, LightOf, terminal};

impl Making<'_> {
    pub(super) fn switches(&mut self, axis: usize) {
        if self.one_in(8) {
            return self.interlock(axis);
        }
        if self.one_in(8) {
            self.sense(axis);
        }
        match self.below(6) {
            0..3 => {
                let kind = self.pick(&[terminal::POSITIVE, terminal::NEGATIVE]);
                let which = self.pick(&[-1, -1, kind]);
                self.calls.push(Call::Guard { axis, kind: which, on: true });
                self.trip(axis, kind);
                if !self.one_in(4) {
                    self.calls.push(Call::Guard { axis, kind: -1, on: false });
                }
            }
            3 => {
                if self.one_in(4) {
                    let on = self.one_in(2);
                    self.calls.push(Call::Guard { axis, kind: terminal::ALARM, on });
                }
                self.trip(axis, terminal::ALARM);
            }
            4 => self.capture(axis),
            _ => {
                let kind = self.pick(&[terminal::POSITIVE, terminal::HOME, terminal::ARRIVE]);
                let level = self.one_in(2);
                self.calls.push(Call::Terminal { axis, kind, level });
                self.levels(axis);
            }
        }
    }

    fn levels(&mut self, axis: usize) {
        let core = self.setup.axes[axis].0;
        let kind = if self.one_in(12) { self.pick(&[-1, 6, 12]) } else { self.below(6) as i16 };
        let effect = match self.below(3) {
            0 => Effect::GetDiEx { core, kind, count: i16::from(!self.one_in(12)) },
            _ => Effect::GetDi { core, kind },
        };
        self.calls.push(Call::Effect(effect));
    }

    /// Switches that are active low. A set-up as a machine has it, mostly.
    fn sense(&mut self, axis: usize) {
        let core = self.setup.axes[axis].0;
        let low = if self.one_in(3) { 0 } else { 3 << (2 * self.below(8)) };
        let sense = if self.one_in(4) { self.below(1 << 16) as u16 } else { low };
        self.calls.push(Call::Sense { core, sense });
        if self.one_in(2) {
            let kind = self.pick(&[terminal::POSITIVE, terminal::NEGATIVE]);
            let level = self.one_in(2);
            self.calls.push(Call::Terminal { axis, kind, level });
            self.sleep(3);
            self.plain(Kind::ClrSts, axis);
        }
    }

    /// The interlock opens during motion, and closes.
    fn interlock(&mut self, axis: usize) {
        if self.one_in(3) {
            let motion = if self.one_in(8) { self.pick(&[-1, 3]) } else { self.below(3) as i16 };
            self.calls.push(Call::Effect(Effect::SetInterlock { motion }));
        }
        match self.below(6) {
            0 => {}
            1 => self.jog(axis),
            2 | 3 => self.marks(axis),
            4 => self.paths(axis),
            _ => self.start(axis),
        }
        self.sleep(6);
        let core = self.setup.axes[axis].0;
        self.calls.push(Call::Effect(Effect::Interlock { core, open: true }));
        if self.one_in(3) {
            self.sleep(3);
            self.start(axis);
        }
        let ms = 2 + self.below(8) as i64;
        self.calls.push(Call::Sleep { ns: ms * MS });
        self.why(axis);
        self.lights();
        if !self.one_in(12) {
            self.calls.push(Call::Effect(Effect::Interlock { core, open: false }));
            if self.one_in(12) {
                self.sleep(4);
            } else {
                // Three ticks, so that it is known to be closed.
                self.calls.push(Call::Sleep { ns: 4 * MS });
            }
        }
        self.cleared();
        self.start(axis);
    }

    /// The lasers after a fault.
    fn cleared(&mut self) {
        if self.setup.profile != "gus" {
            return;
        }
        for channel in 0..2 {
            for what in [LightOf::GetFault, LightOf::ClearFault, LightOf::GetFault] {
                self.calls.push(Call::Light(LightCall { channel, what }));
            }
        }
    }

    fn why(&mut self, axis: usize) {
        let kind = self.pick(&[Kind::GetSts, Kind::GetStopReason, Kind::GetStopReason, Kind::GetPrfVel]);
        self.plain(kind, axis);
    }

    /// An input becomes active on the way, and the user finds out.
    fn trip(&mut self, axis: usize, kind: i16) {
        match self.below(8) {
            0 => {}
            1 | 2 => self.start(axis),
            _ => self.jog(axis),
        }
        self.sleep(8);
        self.calls.push(Call::Terminal { axis, kind, level: true });
        // Either way.
        let both = kind != terminal::ALARM && self.one_in(2);
        if both {
            self.calls.push(Call::Terminal { axis, kind: 1 - kind, level: true });
        }
        self.sleep(5);
        self.why(axis);
        self.why(axis);
        if self.one_in(2) {
            self.start(axis);
            self.sleep(4);
        }
        if self.one_in(2) {
            self.plain(Kind::ClrSts, axis);
            self.sleep(3);
            // Away from it, or towards it.
            self.start(axis);
            self.sleep(6);
            self.why(axis);
        }
        if !self.one_in(8) {
            self.calls.push(Call::Terminal { axis, kind, level: false });
            if both {
                self.calls.push(Call::Terminal { axis, kind: 1 - kind, level: false });
            }
            self.sleep(4);
            self.plain(Kind::ClrSts, axis);
        }
        self.start(axis);
    }

    fn capture(&mut self, axis: usize) {
        let mode = if self.one_in(8) { self.pick(&[0, 3]) } else { self.pick(&[1, 1, 1, 2]) };
        self.calls.push(Call::SetCapture { axis, mode });
        self.start(axis);
        self.sleep(12);
        self.calls.push(Call::Terminal { axis, kind: terminal::HOME, level: true });
        self.sleep(4);
        self.plain(Kind::GetCaptureStatus, axis);
        self.levels(axis);
        self.calls.push(Call::Terminal { axis, kind: terminal::HOME, level: false });
        self.sleep(3);
        self.plain(Kind::GetCaptureStatus, axis);
    }
}
