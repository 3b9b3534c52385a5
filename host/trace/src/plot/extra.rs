//! Quantities that a trace does not hold: acceleration and following error.
//!
//! In: rows. Out: for each axis the mean acceleration since the row before, in pulse/ms², and
//! planned position less encoder as a read of that tick has it, in pulses. Owns a lag for each
//! axis, that of the boards that have no wires, so their encoders are had to the count as long as
//! no row is left out. Cannot fail.
use crate::decimal::{position_f64, scaled_f64};
use crate::row::Row;
use plant::{Gain, Lag};

/// See the module text.
#[derive(Debug, Clone)]
pub(super) struct Extra {
    lags: Vec<Lag>,
    /// The machine's zero in positions of the user, 2⁻²² pulse.
    zeros: Vec<i64>,
    before: Option<Row>,
    gain: (u64, Gain),
}

impl Extra {
    pub fn new(axes: usize) -> Extra {
        Extra { lags: vec![Lag::STANDSTILL; axes], zeros: vec![0; axes], before: None, gain: (0, Gain::of_period(0)) }
    }

    /// Acceleration and following error of each axis at this row.
    pub fn row(&mut self, row: &Row) -> Vec<(f64, f64)> {
        let ns = self.before.as_ref().map_or(0, |before| row.t_ns.saturating_sub(before.t_ns));
        if ns != self.gain.0 {
            self.gain = (ns, Gain::of_period(ns.min(u64::from(u32::MAX)) as u32));
        }
        let mut found = Vec::with_capacity(row.axes.len());
        for (index, (point, (lag, zero))) in row.axes.iter().zip(self.lags.iter_mut().zip(&mut self.zeros)).enumerate()
        {
            let last = self.before.as_ref().and_then(|before| before.axes.get(index));
            match last {
                None => *zero = point.pos.0,
                // A position that changes at standstill was given another name.
                Some(last) if last.vel.m == 0 && point.vel.m == 0 => {
                    *zero = zero.wrapping_add(point.pos.0.wrapping_sub(last.pos.0));
                }
                Some(_) => {}
            }
            let machine = point.pos.0.wrapping_sub(*zero);
            // A tick samples its encoders before the set-point that it computes is in force.
            let error = position_f64(servo::units::Pos(machine)) - lag.encoder() as f64;
            lag.set_point(machine);
            lag.advance(self.gain.1);
            let change = last.map_or(0.0, |last| scaled_f64(point.vel) - scaled_f64(last.vel));
            found.push((if ns == 0 { 0.0 } else { change / (ns as f64 * 1e-6) }, error));
        }
        self.before = Some(row.clone());
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::AxisPoint;
    use servo::segment::piece::Scaled;
    use servo::units::Pos;

    fn row(index: u32, pos: f64, vel: f64) -> Row {
        let pos = Pos((pos * f64::from(1 << 22)) as i64);
        let vel = Scaled { m: (vel * 1024.0) as i64, e: 10 };
        Row { index, t_ns: u64::from(index) * 250_000, axes: vec![AxisPoint { pos, vel }], ..Row::default() }
    }

    #[test]
    fn a_steady_axis_is_one_time_constant_behind_and_does_not_accelerate() {
        let mut extra = Extra::new(1);
        extra.row(&row(0, 7.0, 0.0));
        assert_eq!(extra.row(&row(1, 7.5, 2.0)), [(8.0, 0.5)]);
        let mut last = Vec::new();
        for k in 2..100 {
            last = extra.row(&row(k, 7.5 + 0.5 * f64::from(k - 1), 2.0));
        }
        // 2 pulse/ms by v·T/(1 − e^(−T/τ)), and a tick for the sample; an encoder of whole pulses.
        let exact = 2.0 * 0.25 / (1.0 - (-0.25f64).exp()) + 2.0 * 0.25;
        assert!(last[0].0 == 0.0 && (last[0].1 - exact).abs() <= 0.5, "{last:?} {exact}");
        // At standstill it arrives, and a new name of the position is no error.
        for k in 100..160 {
            last = extra.row(&row(k, 57.0, 0.0));
        }
        assert_eq!(last, [(0.0, 0.0)]);
        assert_eq!(extra.row(&row(160, 0.0, 0.0)), [(0.0, 0.0)]);
    }
}
