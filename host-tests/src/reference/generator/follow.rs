//! Follow: slaves, chains of them, and masters that are planned again while they brake.
use super::{Does, Making};
use crate::reference::{Call, Datum, Kind};

impl Making<'_> {
    pub(super) fn follow_data(&mut self, axis: usize, fifo: usize, sign: f64) {
        let (master, slave) = self.follow[axis][fifo];
        // Whole pulses, also after entries of FollowEx, which may end between two.
        let length = (master + 1.0 + self.below(400) as f64).floor() - master;
        let ratio = self.pick(&[0.25, 0.5, 1.0, 1.5]) * if self.one_in(4) { -1.0 } else { 1.0 };
        let slave = slave + length * ratio * if self.one_in(2) { 1.0 } else { self.chance.unit() };
        let kind = self.pick(&[0, 0, 0, 1, 2, 3]);
        self.follow[axis][fifo] = (master + length, slave);
        let datum = Datum { master: sign * (master + length), slave, kind, percent: 0 };
        self.calls.push(Call::FollowData { axis, datum, fifo: fifo as i16 });
    }

    /// A slave of a slave, run twice with ZeroPos in between.
    pub(super) fn chain(&mut self, first: usize) {
        let count = self.setup.axes.len();
        let (middle, last) = ((first + 1) % count, (first + 2) % count);
        for axis in [last, middle, first] {
            self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 1 << axis });
            self.calls.push(Call::WaitStop { mask: 1 << axis });
        }
        self.sleep(2);
        for (axis, master) in [(middle, first), (last, middle)] {
            self.follow_master(axis, master);
        }
        for _ in 0..2 {
            for axis in [last, middle] {
                self.calls.push(Call::FollowStart { mask: 1 << axis, option: 0 });
            }
            self.jog(first);
            self.sleep(30);
            if self.one_in(2) {
                self.velocity(first);
                self.sleep(30);
            }
            for axis in [first, middle, last] {
                self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 0 });
                self.calls.push(Call::WaitStop { mask: 1 << axis });
            }
            for axis in [first, middle, last] {
                if self.one_in(2) {
                    self.plain(Kind::ZeroPos, axis);
                }
            }
            self.sleep(2);
        }
    }

    /// A master that is planned again while it brakes.
    pub(super) fn braking(&mut self, master: usize) {
        let slave = (master + 1) % self.setup.axes.len();
        for axis in [slave, master] {
            self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 1 << axis });
            self.calls.push(Call::WaitStop { mask: 1 << axis });
        }
        self.sleep(2);
        self.follow_master(slave, master);
        self.calls.push(Call::FollowStart { mask: 1 << slave, option: 0 });
        match self.below(3) {
            0 => self.trap(master),
            _ => self.jog(master),
        }
        for _ in 0..2 + self.below(3) {
            self.sleep(20);
            self.calls.push(Call::Stop { mask: 1 << master, abrupt: 0 });
            self.sleep(6);
            match self.below(3) {
                0 => {
                    if self.one_in(8) {
                        let smooth = self.rate();
                        self.calls.push(Call::SetStopDec { axis: master, smooth });
                    }
                    self.calls.push(Call::Stop { mask: 1 << master, abrupt: 0 });
                }
                _ => self.during(master),
            }
        }
    }

    pub(super) fn follow_master(&mut self, axis: usize, master: usize) {
        let dir = self.pick(&[0, 0, 1, -1]);
        self.plain(Kind::PrfTrap, axis);
        self.calls.push(Call::PrfFollow { axis, dir });
        self.calls.push(Call::SetFollowMaster { axis, master, kind: 2, item: 0 });
        self.calls.push(Call::SetFollowLoop { axis, loops: 0 });
        self.does[axis] = Does::Follow(dir);
        self.masters[axis] = Some(master);
        self.follow[axis] = Default::default();
        let sign = if dir < 0 { -1.0 } else { 1.0 };
        for _ in 0..1 + self.below(3) {
            self.follow_data(axis, 0, sign);
        }
    }

    pub(super) fn slave(&mut self, axis: usize) {
        let mut master = self.axis();
        // A chain now and then: an axis that follows already.
        if self.one_in(2)
            && let Some(other) =
                (0..self.does.len()).find(|other| matches!(self.does[*other], Does::Follow(_) | Does::FollowEx(_)))
        {
            master = other;
        }
        if master == axis {
            master = (axis + 1) % self.setup.axes.len();
        }
        self.rest(axis);
        let dir = self.pick(&[0, 0, 1, -1]);
        if self.does[axis] != Does::Follow(dir) {
            self.plain(Kind::PrfTrap, axis);
        }
        self.calls.push(Call::PrfFollow { axis, dir });
        let kind = self.pick(&[2, 2, 2, 3]);
        self.calls.push(Call::SetFollowMaster { axis, master, kind, item: 0 });
        self.does[axis] = Does::Follow(dir);
        self.masters[axis] = Some(master);
        if self.one_in(15) {
            self.calls.push(Call::SetFollowMemory { axis, memory: 1 });
        }
        let fifo = self.below(2) as usize;
        let sign = if dir <= 0 && self.one_in(3) { -1.0 } else { 1.0 };
        self.calls.push(Call::FollowClear { axis, fifo: fifo as i16 });
        self.follow[axis][fifo] = (0.0, 0.0);
        let count = if self.one_in(30) { 15 + self.below(3) } else { 1 + self.below(4) };
        for _ in 0..count {
            self.follow_data(axis, fifo, sign);
        }
        if self.one_in(2) {
            let loops = self.pick(&[0, 0, 1, 2, 3]);
            self.calls.push(Call::SetFollowLoop { axis, loops });
        }
        if self.one_in(4) {
            let (pos, up) = (self.below(600) as i32 - 300, self.one_in(2));
            self.calls.push(Call::SetFollowEvent { axis, event: 2, dir: if up { 1 } else { -1 }, pos });
        } else if self.one_in(2) {
            self.calls.push(Call::SetFollowEvent { axis, event: 1, dir: 1, pos: 0 });
        }
        self.calls.push(Call::FollowStart { mask: 1 << axis, option: (fifo as u32) << axis });
        if self.one_in(3) {
            if !self.one_in(8) {
                self.sleep(5);
            }
            let other = fifo ^ 1;
            self.calls.push(Call::FollowClear { axis, fifo: other as i16 });
            self.follow[axis][other] = (0.0, 0.0);
            for _ in 0..1 + self.below(3) {
                self.follow_data(axis, other, sign);
            }
            if self.one_in(2) {
                self.calls.push(Call::FollowSwitch { mask: 1 << axis });
            }
        }
        // Something to follow.
        if self.one_in(2) {
            let root = self.root(master);
            let does = self.does[root];
            match does {
                Does::Jog => self.velocity(root),
                Does::Trap => self.target(root),
                _ if self.one_in(2) => self.jog(root),
                _ => {}
            }
        }
    }

    pub(super) fn root(&self, axis: usize) -> usize {
        let mut root = axis;
        for _ in 0..self.does.len() {
            match (self.does[root], self.masters[root]) {
                (Does::Follow(_) | Does::FollowEx(_), Some(master)) => root = master,
                _ => break,
            }
        }
        root
    }
}
