//! Jobs of a laser: a channel set up, marks and jumps of a path, and what happens meanwhile.
use super::Making;
use crate::reference::{Call, Command, Kind, Path};

impl Making<'_> {
    /// Set-up, marks, start, and calls during motion.
    pub(super) fn marks(&mut self, axis: usize) {
        if self.setup.profile != "gus" {
            return;
        }
        let channel = self.below(2) as i16;
        self.set_up_light(channel);
        if self.one_in(6) {
            self.distance(channel);
        }
        if self.one_in(2) {
            self.light_table(channel);
        }
        let index = self.set_up_path(axis);
        let fifo = usize::from(self.one_in(4));
        for _ in 0..1 + self.below(3) {
            self.mark(index, fifo, channel);
        }
        self.start_path(index, fifo);
        for _ in 0..self.below(6) {
            self.sleep(12);
            match self.below(4) {
                0 => self.light(channel),
                1 if self.one_in(4) => return self.abort_or_reset(),
                1 if self.one_in(6) => self.plain(Kind::AxisOff, axis),
                _ => self.during_path(index, fifo),
            }
        }
    }

    /// On, motions, off, and a jump to the next one.
    fn mark(&mut self, index: usize, fifo: usize, channel: i16) {
        if self.one_in(2) {
            let follow = self.follow_entry();
            self.laser_entry(index, fifo, channel, follow);
        }
        self.laser_entry(index, fifo, channel, Command::Gate(true));
        for _ in 0..1 + self.below(3) {
            if self.one_in(5) {
                let command = self.laser_command();
                self.laser_entry(index, fifo, channel, command);
            }
            self.one_motion(index, fifo);
        }
        if !self.one_in(6) {
            self.laser_entry(index, fifo, channel, Command::Gate(false));
        }
        if !self.one_in(3) {
            self.fill_path(index, fifo);
        }
    }

    fn laser_entry(&mut self, index: usize, fifo: usize, channel: i16, command: Command) {
        let (core, crd) = self.path_name(index);
        self.path(core, Path::Laser { crd, channel, command, fifo: fifo as i16 });
    }

    /// Everything stops, and goes on: with what lies in the FIFOs after an Abort, from power-on
    /// after a Reset.
    pub(super) fn abort_or_reset(&mut self) {
        let core = self.setup.axes[self.below(self.setup.axes.len() as u64) as usize].0;
        if !self.one_in(3) {
            self.calls.push(Call::Abort { core });
            if !self.one_in(3) {
                self.sleep(12);
            }
            return;
        }
        self.calls.push(Call::Reset { core });
        // It takes as many ticks as it needs.
        self.calls.push(Call::Sleep { ns: 4_000_000 });
        let axes: Vec<usize> = (0..self.setup.axes.len()).filter(|axis| self.setup.axes[*axis].0 == core).collect();
        for axis in axes {
            if !self.one_in(20) {
                self.plain(Kind::AxisOn, axis);
            }
            self.forget(axis);
        }
    }
}
