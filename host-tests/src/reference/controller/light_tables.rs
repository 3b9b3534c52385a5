//! Tables of power against speed and of ratios, and what both channels share.
use super::super::crd::Entry;
use super::super::light::{
    Act, Command, Family, LightOf, LightTable, Line, POINTS, Ratio, Ratios, Scaled, Setting, TABLES,
};
use super::Controller;
use super::answer::{Answer, DONE, either, range};
use super::light::{DISTANCE_RATIO_MAX, take, take_bounds, take_power};

/// Points of a plane of ratios.
const PLANE_NODES: usize = 256;
const CHANNELS: i16 = 2;

/// What a limit of an axis may be in frequency mode, in both families.
const FREQUENCY_LIMIT_MAX_KHZ: f64 = 2000.0;

impl Controller {
    /// Whether a table of powers, from 1, is in use; None: a path may just have left it.
    fn is_in_use(&self, channel: usize, table: i16) -> Option<bool> {
        let of = |command: &Command| matches!(command, Command::Table(of, _) if *of == table);
        let named = |entry: &Entry| matches!(entry, Entry::Laser(on, command) if *on == channel && of(command));
        let (mut waits, mut left, mut filled) = (false, false, false);
        for crd in self.crds.iter().filter(|(name, _)| name.0 == 1).map(|(_, crd)| crd) {
            for fifo in &crd.fifos {
                waits |= fifo.entries[fifo.next..].iter().any(named);
                let passed = fifo.entries[..fifo.next].iter().any(named);
                left |= passed;
                // It names its table until its FIFO is seen empty, and data comes ahead of time.
                filled |= passed && fifo.next < fifo.entries.len();
            }
        }
        let before = self.light.channels[channel].law.reads(table);
        let after = self.light.after_calls(channel).law.reads(table);
        match (waits, before, after) {
            // What ends it at this instant has not acted yet.
            (_, true, false) => None,
            (true, ..) | (_, true, true) => Some(true),
            // Where a path has passed the entry a while ago it is known.
            (false, ..) if filled || left && !self.crds.values().all(|crd| !crd.runs) => None,
            (false, ..) => Some(false),
        }
    }

    pub(super) fn light_table(&mut self, of: &LightTable) -> Answer {
        range((0..CHANNELS).contains(&of.channel()))?;
        let number = of.channel() as usize;
        self.is_settled_for_light();
        let setting = match of {
            LightTable::Powers { table, points, .. } => self.powers(number, *table, points)?,
            LightTable::Lines { points, bounds, limits, .. } => {
                let line = |points: &Vec<(i32, f64)>| {
                    Line(points.iter().map(|(at, ratio)| [f64::from(*at), *ratio]).collect())
                };
                let lines = points.each_ref().map(line);
                let good = lines.iter().all(|line| (1..=POINTS).contains(&line.0.len()) && is_line(line));
                self.ratios(number, Ratios::Lines(lines), *bounds, *limits, good)?
            }
            LightTable::Plane { axes, x, y, ratios, bounds, limits, .. } => {
                let row = |ratios: &[f64]| Line(x.iter().zip(ratios).map(|(at, of)| [f64::from(*at), *of]).collect());
                let rows: Vec<Line> = ratios.chunks(x.len().max(1)).map(row).collect();
                let names = axes[0] != axes[1] && axes.iter().all(|axis| (1..=4).contains(axis));
                let counts = [x.len(), y.len()].iter().all(|count| (1..=POINTS).contains(count));
                let good = names
                    && counts
                    && x.len() * y.len() <= PLANE_NODES
                    && y.windows(2).all(|pair| pair[0] < pair[1])
                    && rows.iter().all(is_line);
                let axes = if names { axes.map(|axis| axis as usize - 1) } else { [0, 1] };
                let limits = limits.map(|limits| {
                    let mut all = [0.0; 4];
                    axes.iter().zip(limits).for_each(|(axis, limit)| all[*axis] = limit);
                    all
                });
                let y = y.iter().map(|at| f64::from(*at)).collect();
                self.ratios(number, Ratios::Plane { axes, y, rows }, *bounds, limits, good)?
            }
        };
        self.light.calls.push(Act::Set(number, setting));
        *self.used.entry("tables of lasers set").or_default() += 1;
        DONE
    }

    fn powers(&mut self, number: usize, table: i16, points: &[[f64; 2]]) -> Result<Setting, i16> {
        let after = self.light.after_calls(number);
        range((1..=TABLES).contains(&table))?;
        let taken = || -> Result<Line, i16> {
            range((1..=POINTS).contains(&points.len()) && points[0][0] >= 0.0)?;
            let taken = |point: &[f64; 2]| Ok([point[0], take_power(&after, point[1])?]);
            let line = Line(points.iter().map(taken).collect::<Result<_, i16>>()?);
            range(line.increases())?;
            Ok(line)
        };
        let taken = taken();
        let in_use = self.is_in_use(number, table);
        if in_use.is_none() {
            self.open = Some("a table of powers that a path may just have left");
        }
        either(in_use != Some(true), taken.is_ok())?;
        self.light.around.powers.push(taken?);
        Ok(Setting::Table(table as usize - 1, self.light.around.powers.len() - 1))
    }

    fn ratios(
        &mut self,
        number: usize,
        ratios: Ratios,
        bounds: [f64; 2],
        limits: Option<[f64; 4]>,
        good: bool,
    ) -> Result<Setting, i16> {
        let after = self.light.after_calls(number);
        let bounds = match after.law.family {
            Family::Gus => take_bounds(&after.law, after.law.mode, bounds).map(Some),
            Family::Lsr => Ok(None),
        };
        let limit = |limit: f64| take(after.law.family, limit, [0.0, after.law.mode.most(FREQUENCY_LIMIT_MAX_KHZ)]);
        let taken = limits.map(|limits| limits.map(limit));
        let good = good && taken.is_none_or(|limits| limits.iter().all(Result::is_ok));
        either(after.law.distance.is_some(), good && bounds.is_ok())?;
        let limits = taken.map(|limits| limits.map(|limit| limit.unwrap_or(0.0)));
        self.light.around.ratios.push(Ratio { ratios, limits: limits.unwrap_or([f64::INFINITY; 4]) });
        Ok(Setting::Ratios(Scaled::Table(self.light.around.ratios.len() - 1), bounds?))
    }

    /// SetWaitPulseEx and SetLaserMode.
    pub(super) fn both_lasers(&mut self, what: LightOf) -> Answer {
        self.is_settled_for_light();
        if let LightOf::Resolution(mode) = what {
            range((0..2).contains(&mode))?;
            self.light.calls.push(Act::Resolution(mode == 0));
        } else {
            for channel in 0..CHANNELS {
                let after = self.light.after_calls(channel as usize);
                let setting = self.setting_of(what, &after, channel)?;
                self.light.calls.push(Act::Set(channel as usize, setting));
            }
        }
        *self.used.entry("settings of both lasers").or_default() += 1;
        DONE
    }
}

fn is_line(line: &Line) -> bool {
    line.increases() && line.0.iter().all(|point| point[1].abs() <= DISTANCE_RATIO_MAX)
}
