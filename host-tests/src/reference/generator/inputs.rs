//! Inputs of axes: limit switches, alarms, home; what they do to motion, and what reads tell of it.
use super::Making;
use crate::reference::{Call, Effect, Kind, terminal};

impl Making<'_> {
    pub(super) fn switches(&mut self, axis: usize) {
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
        let core = self.site.axes[axis].0;
        let kind = if self.one_in(12) { self.pick(&[-1, 6, 12]) } else { self.below(6) as i16 };
        self.calls.push(Call::Effect(Effect::GetDi { core, kind }));
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
        let mode = if self.one_in(8) { self.pick(&[0, 3]) } else { 1 };
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
