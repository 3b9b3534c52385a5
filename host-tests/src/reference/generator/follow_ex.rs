//! FollowEx: segments with entries between them, switches at once, loops, FIFOs exactly full; and
//! encoders as masters.
use super::{Does, Making};
use crate::reference::{Call, Datum, Effect, Item};

/// Programs set these inputs and outputs only.
const PLACES: u64 = 6;

impl Making<'_> {
    pub(super) fn ex(&mut self, of: Call) {
        self.calls.push(Call::Ex(Box::new(of)));
    }

    fn item(&mut self, axis: usize, fifo: usize, item: Item) {
        self.calls.push(Call::FollowEntry { axis, item, fifo: fifo as i16 });
    }

    fn segment_ex(&mut self, axis: usize, fifo: usize, sign: f64) {
        let (master, slave) = self.follow[axis][fifo];
        let length = match self.below(4) {
            0 => self.chance.log(3.0, 400.0),
            _ => 1.0 + self.below(400) as f64,
        };
        let ratio = self.pick(&[0.25, 0.5, 1.0, 1.5]) * if self.one_in(4) { -1.0 } else { 1.0 };
        let slave = slave + length * ratio * if self.one_in(2) { 1.0 } else { self.chance.unit() };
        let (kind, percent) = (self.pick(&[0, 0, 0, 1, 2, 3]), self.pick(&[0, 0, 20, 50, 99, 100]));
        self.follow[axis][fifo] = (master + length, slave);
        let datum = Datum { master: sign * (master + length), slave, kind, percent };
        self.item(axis, fifo, Item::Segment(datum));
    }

    /// An entry that is no segment.
    fn entry(&mut self, axis: usize, fifo: usize) {
        let (index, level) = (1 + self.below(PLACES) as i16, self.one_in(2));
        let item = match self.below(10) {
            0..4 => Item::Output { index, level },
            4..7 => Item::Delay { cycles: self.pick(&[0, 1, 3, 4, 7, 40]) },
            7 | 8 => Item::Wait { index, level, ms: self.pick(&[0, 3, 20, 60]) },
            _ => Item::Switch { table: self.one_in(2) },
        };
        self.item(axis, fifo, item);
    }

    /// Segments and entries.
    fn fill_ex(&mut self, axis: usize, fifo: usize, sign: f64) {
        if self.one_in(25) {
            // Exactly as many entries as there are places for, and one more at times.
            for _ in 0..15 + self.below(3) {
                let index = 1 + self.below(PLACES) as i16;
                self.item(axis, fifo, Item::Output { index, level: true });
            }
            return;
        }
        let count = if self.one_in(25) { 15 + self.below(3) } else { 1 + self.below(5) };
        for _ in 0..count {
            if self.one_in(12) {
                self.entry(axis, fifo);
            }
            self.segment_ex(axis, fifo, sign);
            while self.one_in(3) {
                self.entry(axis, fifo);
            }
        }
    }

    pub(super) fn slave_ex(&mut self, axis: usize) {
        let mut master = self.axis();
        if master == axis {
            master = (axis + 1) % self.setup.axes.len();
        }
        self.rest(axis);
        let dir = self.pick(&[0, 0, 1, -1]);
        if self.does[axis] != Does::FollowEx(dir) {
            self.plain(crate::reference::Kind::PrfTrap, axis);
        }
        let (kind, item) = self.pick(&[(2, 0), (2, 0), (2, 0), (2, 0), (3, 0), (1, 0), (3, 1), (3, 2), (3, 3)]);
        self.counted[axis] = kind == 1 || item != 0;
        self.ex(Call::PrfFollow { axis, dir });
        self.ex(Call::SetFollowMaster { axis, master, kind, item });
        self.does[axis] = Does::FollowEx(dir);
        self.masters[axis] = Some(master);
        if self.one_in(15) {
            let memory = self.below(2) as i16;
            self.ex(Call::SetFollowMemory { axis, memory });
            self.follow[axis] = Default::default();
        }
        let fifo = self.below(2) as usize;
        let sign = if dir < 0 && self.one_in(2) || dir == 0 && self.one_in(4) { -1.0 } else { 1.0 };
        self.ex(Call::FollowClear { axis, fifo: fifo as i16 });
        self.follow[axis][fifo] = (0.0, 0.0);
        self.fill_ex(axis, fifo, sign);
        if self.one_in(3) {
            self.ex(Call::FollowSpace { axis, fifo: fifo as i16 });
        }
        if self.one_in(2) {
            let loops = self.pick(&[0, 0, 1, 2, 3]);
            self.ex(Call::SetFollowLoop { axis, loops });
        }
        if self.one_in(5) {
            let (pos, up) = (self.below(600) as i32 - 300, self.one_in(2));
            self.ex(Call::SetFollowEvent { axis, event: 2, dir: if up { 1 } else { -1 }, pos });
        } else if self.one_in(2) {
            self.ex(Call::SetFollowEvent { axis, event: 1, dir: 1, pos: 0 });
        }
        let has_other = self.one_in(3);
        let other = fifo ^ 1;
        if has_other {
            self.ex(Call::FollowClear { axis, fifo: other as i16 });
            self.follow[axis][other] = (0.0, 0.0);
            self.fill_ex(axis, other, sign);
        }
        self.ex(Call::FollowStart { mask: 1 << axis, option: (fifo as u32) << axis });
        if self.one_in(2) {
            match self.does[self.root(master)] {
                Does::Jog => self.velocity(self.root(master)),
                Does::Trap => self.target(self.root(master)),
                _ => {}
            }
        }
        if has_other && self.one_in(2) {
            self.sleep(12);
            self.during_ex(axis);
        }
    }

    pub(super) fn during_ex(&mut self, axis: usize) {
        let mask = 1 << axis;
        match self.below(6) {
            0 => self.ex(Call::FollowSwitch { mask }),
            1 | 2 => {
                let table = self.one_in(2);
                self.calls.push(Call::FollowSwitchNow { axis, table });
            }
            3 => {
                let fifo = self.below(2) as usize;
                self.segment_ex(axis, fifo, 1.0);
            }
            4 => self.input(),
            _ => {
                let root = self.root(axis);
                self.start(root);
            }
        }
    }

    fn input(&mut self) {
        let (index, level) = (1 + self.below(PLACES) as i16, self.one_in(2));
        self.calls.push(Call::Effect(Effect::SimInput { core: 1, index, level }));
    }

    /// A slave with waits for inputs, under a jog.
    pub(super) fn entries(&mut self, axis: usize) {
        let master = (axis + 1) % self.setup.axes.len();
        for axis in [axis, master] {
            self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 1 << axis });
            self.calls.push(Call::WaitStop { mask: 1 << axis });
        }
        self.sleep(2);
        self.plain(crate::reference::Kind::PrfTrap, axis);
        let dir = self.pick(&[0, 1, -1]);
        self.ex(Call::PrfFollow { axis, dir });
        self.ex(Call::SetFollowMaster { axis, master, kind: 2, item: 0 });
        let loops = self.pick(&[0, 1, 3]);
        self.ex(Call::SetFollowLoop { axis, loops });
        self.does[axis] = Does::FollowEx(dir);
        self.masters[axis] = Some(master);
        self.follow[axis] = Default::default();
        let sign = if dir < 0 { -1.0 } else { 1.0 };
        for _ in 0..2 + self.below(3) {
            self.segment_ex(axis, 0, sign);
            self.entry(axis, 0);
        }
        self.ex(Call::FollowStart { mask: 1 << axis, option: 0 });
        self.jog(master);
        for _ in 0..2 + self.below(4) {
            self.sleep(15);
            if self.one_in(4) {
                self.calls.push(Call::FollowSwitchNow { axis, table: false });
            } else {
                self.input();
            }
        }
    }

    /// A slave of an encoder, or of a filtered position.
    pub(super) fn by_encoder(&mut self, axis: usize) {
        let master = (axis + 1) % self.setup.axes.len();
        self.rest(axis);
        let dir = self.pick(&[0, 1, -1]);
        self.plain(crate::reference::Kind::PrfTrap, axis);
        self.calls.push(Call::PrfFollow { axis, dir });
        let (kind, item) = self.pick(&[(1, 0), (1, 0), (3, 1), (3, 2), (3, 2), (3, 3), (3, -1)]);
        self.calls.push(Call::SetFollowMaster { axis, master, kind, item });
        self.counted[axis] = true;
        self.does[axis] = Does::Follow(dir);
        self.masters[axis] = Some(master);
        self.follow[axis] = Default::default();
        let sign = if dir < 0 && self.one_in(2) { -1.0 } else { 1.0 };
        for _ in 0..1 + self.below(3) {
            self.follow_data(axis, 0, sign);
        }
        let loops = self.pick(&[0, 0, 1, 2]);
        self.calls.push(Call::SetFollowLoop { axis, loops });
        if self.one_in(3) {
            let (pos, up) = (self.below(600) as i32 - 300, self.one_in(2));
            self.calls.push(Call::SetFollowEvent { axis, event: 2, dir: if up { 1 } else { -1 }, pos });
        }
        self.calls.push(Call::FollowStart { mask: 1 << axis, option: 0 });
        let root = self.root(master);
        match self.does[root] {
            Does::Trap => self.target(root),
            _ => self.jog(root),
        }
    }
}
