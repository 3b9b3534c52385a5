//! Overrides and coolant: real-time commands that change a running job.
//!
//! In: the byte of an override, M7, M8 and their toggles. Out: factors for lines to come and for
//! the path; general outputs. Fails: with the link's error.
use super::Session;
use client::Error;
use protocol::command::SetDoBit;
use protocol::values::io;

impl Session<'_> {
    pub(super) fn override_by(&mut self, byte: u8) {
        let [mut feed, mut rapid, mut power] = self.overrides;
        let step = |of: u8, first: u8| match byte - first {
            0 => 100,
            1 => of.saturating_add(10),
            2 => of.saturating_sub(10),
            3 => of.saturating_add(1),
            _ => of.saturating_sub(1),
        };
        match byte {
            0x90..=0x94 => feed = step(feed, 0x90),
            0x95..=0x97 => rapid = [100, 50, 25][usize::from(byte - 0x95)],
            0x99..=0x9d => power = step(power, 0x99),
            _ => {}
        }
        self.set_overrides([feed.clamp(10, 200), rapid, power.clamp(10, 200)]);
    }

    pub(super) fn set_overrides(&mut self, overrides: [u8; 3]) {
        self.overrides = overrides;
        let [feed, rapid, power] = overrides.map(|percent| f64::from(percent) / 100.0);
        // A path can be slowed down at any time; faster than F is planned so.
        self.stream.overrides(feed.max(1.0), rapid, power);
        self.feed.feed(overrides[0]);
    }

    /// M7 (0) or M8 (1) the other way, at once.
    pub(super) fn toggle(&mut self, which: usize) -> Result<(), Error> {
        if self.alarm.is_some() || self.sleeps || self.settles.is_some() {
            return Ok(());
        }
        self.coolant[which] = !self.coolant[which];
        self.switch(which)
    }

    pub(super) fn coolant_off(&mut self) -> Result<(), Error> {
        for which in 0..2 {
            if std::mem::take(&mut self.coolant[which]) {
                self.switch(which)?;
            }
        }
        Ok(())
    }

    fn switch(&mut self, which: usize) -> Result<(), Error> {
        let outputs = self.machine.outputs;
        let Some(output) = [outputs.mist, outputs.flood][which] else { return Ok(()) };
        let value = i16::from(self.coolant[which]);
        let set =
            SetDoBit { core: 1.into(), do_type: io::GPO.into(), index: i16::from(output).into(), value: value.into() };
        self.feed.client().call(set).map(drop)
    }
}
