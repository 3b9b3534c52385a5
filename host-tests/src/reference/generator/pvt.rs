//! PVT tables of every kind.
use super::{Does, Making};
use crate::reference::{Call, Kind, Points};

impl Making<'_> {
    /// A new table of any kind for the core of an axis; its number.
    pub(super) fn table(&mut self, axis: usize) -> i16 {
        let count = 2 + self.below(5) as usize;
        let begin = if self.one_in(3) { self.number(8) } else { 0.0 };
        let (mut time, mut pos) = (begin, self.number(50));
        let mut rows = Vec::new();
        for _ in 0..count {
            rows.push((time, pos));
            time += self.number(12) + 1.0;
            pos += (self.number(60) + 1.0) * self.chance.sign();
        }
        let velocity = |making: &mut Self| making.number(10) * making.chance.sign();
        let percents = [0.0, 0.0, 30.0, 60.0, 100.0];
        let points = match self.below(5) {
            0 => Points::Pvt(rows.iter().map(|&(time, pos)| [time, pos, velocity(self)]).collect()),
            1 => Points::Ex(rows.iter().map(|&(time, pos)| [time, pos, velocity(self), velocity(self)]).collect()),
            2 => {
                let ends = if self.one_in(2) { (0.0, 0.0) } else { (velocity(self), velocity(self)) };
                Points::Complete(rows.iter().map(|&(time, pos)| [time, pos]).collect(), ends.0, ends.1)
            }
            3 => {
                let first = if self.one_in(2) { 0.0 } else { velocity(self) };
                Points::Percent(rows.iter().map(|&(time, pos)| [time, pos, self.pick(&percents)]).collect(), first)
            }
            _ => {
                let point = |&(_, pos): &(f64, f64)| {
                    let most = self.speed();
                    [pos, 0.0, self.pick(&percents), most, self.rate(), self.rate()]
                };
                Points::Continuous(rows.iter().map(point).collect(), begin)
            }
        };
        if matches!(points, Points::Percent(..) | Points::Continuous(..)) && self.one_in(3) {
            let core = self.setup.axes[axis].0;
            self.calls.push(Call::PvtCalculate { core, points: points.clone() });
        }
        let table = 1 + self.below(32) as i16;
        self.calls.push(Call::PvtTable { axis, table, points });
        table
    }

    pub(super) fn pvt(&mut self, axis: usize) {
        self.rest(axis);
        self.plain(Kind::PrfPvt, axis);
        self.does[axis] = Does::Pvt;
        let table = self.table(axis);
        self.calls.push(Call::PvtTableSelect { axis, table });
        if self.one_in(2) {
            let loops = self.pick(&[0, 1, 2, 3]);
            self.calls.push(Call::SetPvtLoop { axis, loops });
        }
        self.calls.push(Call::PvtStart { mask: 1 << axis });
    }
}
