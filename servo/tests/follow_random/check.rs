//! A tick of the controller and of the reference, and the comparison of both.
use super::*;

impl Program {
    /// A tick, and whether it is right.
    pub fn tick(&mut self) -> Result<(), String> {
        let before = self.view;
        let counts: [i64; AXES] = std::array::from_fn(|axis| {
            step_generator::whole(self.bench.machine.set_points[axis]) + self.bench.machine.slip[axis]
        });
        let (places, counted) = (self.places, self.counts);
        self.view = self.bench.tick();
        (self.places, self.counts) = (self.bench.machine.set_points, counts);
        let view = &self.view;
        let period = view.period.0 as f64 / 1e6;
        let mut displacements = [None; AXES];
        for link in &mut self.links {
            let Some(slave) = &mut link.slave else { continue };
            // Only an axis that changes its direction moves further than at both ticks. If its
            // velocity jumps, it may do so twice.
            let beyond = |axis: usize| {
                let [v0, v1] = [&before, view].map(|view| real(view.velocity(&view.axes[axis])));
                let [from, to] = [&places, &self.places].map(|places| fixed(places[axis]));
                let (path, mean) = (follow_reference::pulses(to - from), (v0 + v1) / 2.0 * period);
                let pass = |view: &View<AXES>| {
                    let axis = &view.axes[axis];
                    (axis.passes, axis.table, axis.table_zero, axis.fifo)
                };
                let straight = v0 * v1 > 0.0 && (path - mean).abs() < mean.abs() * 0.3 && pass(&before) == pass(view);
                let most = 2.0 * v0.abs().max(v1.abs()) * period;
                (from, to, (!straight).then_some((most * 2f64.powi(48)) as i128))
            };
            let path = if link.value == MasterPosition::Encoder {
                let place = |counts: [i64; AXES]| fixed(Pos::pulses(counts[link.master] as i32));
                MasterPath::within(place(counted), place(counts), 0)
            } else {
                let (from, to, beyond) = beyond(link.master);
                let path: Option<MasterPath> = displacements[link.master];
                path.unwrap_or_else(|| MasterPath::within(from, to, beyond.unwrap_or(0)))
            };
            let MasterPath { from, to, .. } = path;
            link.steepest = link.steepest.max(slave.steepest());
            let axis = &view.axes[link.axis];
            let runs = has(axis, status::RUNNING);
            let (old, place) = (fixed(places[link.axis]), fixed(self.places[link.axis]));
            let reported = link.reported.take();
            if reported == Some(true) {
                link.slave = None;
                if place != old || runs {
                    return Err(format!("axis {} has not stopped: {:?}", link.axis, axis.stop));
                }
                continue;
            }
            let turns = beyond(link.axis).2.is_some();
            let (known, extremes) = slave.step(&path, turns);
            link.steepest = link.steepest.max(slave.steepest());
            let most = path.length() as f64 * link.steepest * 1.0001;
            if let Some((low, high)) = extremes {
                let (low, high) = (low.min(old).min(place), high.max(old).max(place));
                displacements[link.axis] =
                    Some(MasterPath { from: old, to: place, high: (high, high), low: (low, low) });
                self.exact += (low < old.min(place) || high > old.max(place)) as u64;
            } else if turns {
                displacements[link.axis] = Some(MasterPath::within(old, place, most as i128));
            }
            if (place - old).abs() > most as i128 + 2 * CLOSE {
                return Err(format!(
                    "axis {} jumps from {} to {}, its master from {} to {}",
                    link.axis,
                    follow_reference::pulses(old),
                    follow_reference::pulses(place),
                    follow_reference::pulses(from),
                    follow_reference::pulses(to)
                ));
            }
            let speed = |axis: usize| real(view.velocity(&view.axes[axis]));
            let back = link.value == MasterPosition::Planned && speed(link.master) * (link.dir as f64) < 0.0;
            if back && runs && reported.is_none() && speed(link.axis) != 0.0 {
                return Err(format!("axis {} goes at {} where its master goes back", link.axis, speed(link.axis)));
            }
            let (low, high) = match known {
                Known::Runs(low, high) => {
                    if !runs && reported.is_none() {
                        return Err(format!("axis {} has ended: {:?}", link.axis, axis.stop));
                    }
                    (low, high)
                }
                Known::Ended(at) => {
                    if runs || axis.stop != StopReason::Completed {
                        return Err(format!("axis {} has not ended", link.axis));
                    }
                    (at, at)
                }
                Known::Nothing => {
                    link.slave = None;
                    continue;
                }
            };
            self.compared += 1;
            if place < low - CLOSE || place > high + CLOSE {
                return Err(format!(
                    "axis {} is at {}, not from {} to {}; its master went from {} to {}",
                    link.axis,
                    follow_reference::pulses(place),
                    follow_reference::pulses(low),
                    follow_reference::pulses(high),
                    follow_reference::pulses(from),
                    follow_reference::pulses(to)
                ));
            }
            if !runs || reported.is_some() {
                link.slave = None;
            }
        }
        Ok(())
    }
}
