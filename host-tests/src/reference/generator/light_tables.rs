//! Tables of laser channels: powers over the speed, ratios over positions.
use super::Making;
use crate::reference::{Call, LightTable};

impl Making<'_> {
    /// The number of a table of powers: few of them, so that they are used.
    pub(super) fn table_number(&mut self) -> i16 {
        if self.one_in(30) { self.pick(&[0, 9, -1]) } else { 1 + self.below(2) as i16 }
    }

    /// One in some has a fault.
    pub(super) fn light_table(&mut self, channel: i16) {
        let of = match self.below(4) {
            0 | 1 => self.powers(channel),
            2 => self.lines(channel),
            _ => self.plane(channel),
        };
        self.calls.push(Call::LightTable(of));
    }

    fn powers(&mut self, channel: i16) -> LightTable {
        let count = if self.one_in(12) { self.pick(&[0, 32, 33]) } else { 1 + self.below(6) as usize };
        let mut vel = if self.one_in(20) { -1.0 } else { self.pick(&[0.0, 0.0, 2.5]) };
        let mut points = Vec::new();
        for _ in 0..count {
            points.push([vel, self.below(1001) as f64 / 10.0]);
            vel += if self.one_in(60) { 0.0 } else { self.number(12) };
        }
        LightTable::Powers { channel, table: self.table_number(), points }
    }

    /// Positions around where axes of the programs are.
    fn positions(&mut self, count: usize) -> Vec<i32> {
        let mut at = -(self.below(400) as i32);
        (0..count)
            .map(|_| {
                at += if self.one_in(60) { 0 } else { 1 + self.below(300) as i32 };
                at
            })
            .collect()
    }

    fn ratio_of_table(&mut self) -> f64 {
        if self.one_in(60) { 200_000.0 } else { (self.below(41) as f64 - 20.0) / 100.0 }
    }

    fn table_bounds(&mut self) -> [f64; 2] {
        self.pick(&[[0.0, 100.0], [0.0, 100.0], [5.0, 10.0], [0.0, 9.0], [1.0, 0.0]])
    }

    fn most_of_axis(&mut self) -> f64 {
        if self.one_in(30) { -1.0 } else { self.pick(&[0.0, 2.0, 50.0]) }
    }

    fn lines(&mut self, channel: i16) -> LightTable {
        let count = if self.one_in(20) { self.pick(&[0, 18]) } else { 1 + self.below(5) as usize };
        let points = [0; 4].map(|_| {
            let positions = self.positions(count);
            positions.into_iter().map(|at| (at, self.ratio_of_table())).collect()
        });
        let bounds = self.table_bounds();
        let limits = self.one_in(2).then(|| [0; 4].map(|_| self.most_of_axis()));
        LightTable::Lines { channel, points, bounds, limits }
    }

    fn plane(&mut self, channel: i16) -> LightTable {
        let axes =
            if self.one_in(20) { self.pick(&[[1, 1], [0, 1], [2, 5]]) } else { self.pick(&[[1, 2], [3, 1], [2, 4]]) };
        let [columns, rows] = [0; 2].map(|_| if self.one_in(40) { 0 } else { 1 + self.below(4) as usize });
        let (x, y) = (self.positions(columns), self.positions(rows));
        let ratios = (0..columns * rows).map(|_| self.ratio_of_table()).collect();
        let bounds = self.table_bounds();
        let limits = self.one_in(2).then(|| [0; 2].map(|_| self.most_of_axis()));
        LightTable::Plane { channel, axes, x, y, ratios, bounds, limits }
    }
}
