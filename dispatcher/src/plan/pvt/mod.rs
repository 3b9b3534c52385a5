//! PVT tables from the user's points: five descriptions, one kind of table (SPEC 5; GXN 4.2).
//!
//! In: points one by one, in the order of the manual's arrays. Out: a header and points for the
//! tick's stores, or the velocities and times of the two Calculate commands.
//! Owns: [`TableDraft`], the few numbers that the next point needs. The points lie in the caller's
//! [`Scratch`] until the table is complete, so a refused table changes nothing.
//! Fails: [`Refused`] names the point (item), the parameter and the limit.
//!
//! Doubles only, no fused operations; sums (velocities of Percent, times of Continuous) are kept in
//! [`double_double`].
mod complete;
mod continuous;
mod double_double;
mod percent;
mod scale;
mod scratch;

use crate::refuse::{Admitted, Refused, finite, real, within};
use complete::EliminationRow;
use continuous::PointData;
pub use double_double::DoubleDouble;
use protocol::reason::Reason;
use protocol::values::FULL_SCALE;
pub use scale::Sealed;
use scale::{Totals, exact, instant};
pub use scratch::{Scratch, SplineScratch};
use scratch::{TablePoint, check};
use servo::segment::pvt::{SHORTEST_PASS_NS, TABLE_POINTS};
use servo::units::StepLimit;

/// Tables of a core.
pub const CORE_TABLES: usize = 32;
/// The largest time in ms, 2³⁶: about two years.
pub const LATEST_MS: f64 = 68_719_476_736.0;
/// Positions as the user counts them stay within 2⁵² pulses.
const POS_MAX_PULSES: f64 = 4_503_599_627_370_496.0;
const VEL_MAX_PULSES_PER_MS: f64 = FULL_SCALE;
/// Values of a point in the widest description.
pub const POINT_VALUES: usize = 6;

/// The number of a table in its core, from 1, as the user knows it.
pub fn table_number(table: u8) -> i16 {
    i16::from(table % CORE_TABLES as u8) + 1
}

/// A description with the values of the whole table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TableKind {
    /// Time, position, velocity.
    Pvt,
    /// Time, position, velocity at the start and at the end of the segment that follows.
    PvtEx,
    /// Time, position.
    Complete {
        /// Velocity at the first point.
        vel_begin: f64,
        /// Velocity at the last point.
        vel_end: f64,
    },
    /// Time, position, percentage.
    Percent {
        /// Velocity at the first point.
        vel_begin: f64,
    },
    /// Position, velocity, percentage, speed limit, acceleration, deceleration.
    Continuous {
        /// Time of the first point, ms.
        time_begin: f64,
    },
}

impl TableKind {
    /// Values of a point.
    pub const fn values(&self) -> usize {
        match self {
            TableKind::Pvt | TableKind::Percent { .. } => 3,
            TableKind::PvtEx => 4,
            TableKind::Complete { .. } => 2,
            TableKind::Continuous { .. } => POINT_VALUES,
        }
    }
}

/// Indices of the parameters in the request, so that a refusal can name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldIndices {
    /// The count of points.
    pub count: u8,
    /// The first of the values of the whole table.
    pub whole: u8,
    /// The first value of a point.
    pub point: u8,
}

servo::state! {
    /// A table that is being sent.
    #[derive(Debug, Clone, Copy)]
    pub struct TableDraft {
        kind: TableKind = kind,
        fields: FieldIndices = fields,
        /// Step limit of the board, pulse/ms.
        limit: f64 = limit,
        count: u16 = count,
        taken: u16 = 0,
        /// Points go into the scratch memory; false for the Calculate commands.
        load: bool = load,
        /// Time and position of the first point.
        first: (f64, f64) = (0.0, 0.0),
        /// Time and position of the last point taken.
        last: (f64, f64) = (0.0, 0.0),
        /// Its knot.
        knot: TablePoint = TablePoint { time: 0.0, pos: 0.0, vel: 0.0 },
        /// Complete: time and displacement of the segment that ends at the last point.
        segment: (f64, f64) = (0.0, 0.0),
        /// The row of the elimination at the point before the last one.
        row: EliminationRow = EliminationRow::default(),
        /// PvtTableEx: velocity at the end of the segment that the last point began.
        vel_end: f64 = 0.0,
        /// Percentage of the last point.
        percent: f64 = 0.0,
        /// Percent: velocity at the last point. Continuous: its time.
        carried: DoubleDouble = carried,
        /// Continuous: the segment that begins at the last point.
        phase: PointData = PointData::default(),
    }
    fn empty((kind, fields, limit): (TableKind, FieldIndices, f64), count: u16, load: bool, carried: DoubleDouble);
}

impl TableDraft {
    /// A table of `count` points. With `load`, `scratch` is emptied and takes the points; without,
    /// only the answers of [`TableDraft::point`] are wanted.
    pub fn begin(
        kind: TableKind,
        count: i32,
        fields: FieldIndices,
        limit: StepLimit,
        load: bool,
        scratch: &mut Scratch<'_>,
    ) -> Admitted<TableDraft> {
        let limit = limit.pulses_per_ms() as f64;
        if !(2..=TABLE_POINTS as i32).contains(&count) {
            let (low, high) = (2.0, TABLE_POINTS as f64);
            return Err(Refused::range(fields.count, count.into(), low, high));
        }
        let mut carried = DoubleDouble::default();
        match kind {
            TableKind::Complete { vel_begin, vel_end } => {
                speed(vel_begin, fields.whole, limit)?;
                speed(vel_end, fields.whole + 1, limit)?;
            }
            TableKind::Percent { vel_begin } => carried = speed(vel_begin, fields.whole, limit)?.into(),
            TableKind::Continuous { time_begin } => {
                carried = real(fields.whole, time_begin, 0.0, LATEST_MS)?.into();
            }
            TableKind::Pvt | TableKind::PvtEx => {}
        }
        if load {
            scratch.clear();
        }
        Ok(TableDraft::empty((kind, fields, limit), count as u16, load, carried))
    }

    /// Points taken.
    pub fn taken(&self) -> u16 {
        self.taken
    }

    /// Takes the next point. Returns its velocity (Percent) or its time (Continuous), 0 for the
    /// other descriptions. After a refusal the draft is of no further use.
    pub fn point(&mut self, values: &[f64], scratch: &mut Scratch<'_>) -> Admitted<f64> {
        let item = self.taken as usize;
        let admitted = self.admit(values, scratch);
        admitted
            .map_err(|refused| refused.item(if self.names_before(&refused) { item.saturating_sub(1) } else { item }))
    }

    /// Whether the refusal is about the segment to this point, which the point before it described.
    fn names_before(&self, refused: &Refused) -> bool {
        let distance = [Reason::NoDisplacement, Reason::VelocityUnreachable, Reason::AboveVelMax];
        // Of a point's own values only velMax can be too fast, and only on the segment after it.
        let vel_max = matches!(self.kind, TableKind::Continuous { .. }) && refused.wire.field == self.fields.point + 3;
        let cruises = refused.reason == Reason::TooFast && vel_max;
        self.taken > 0 && (cruises || distance.contains(&refused.reason))
    }

    fn admit(&mut self, values: &[f64], scratch: &mut Scratch<'_>) -> Admitted<f64> {
        let (field, limit) = (self.fields.point, self.limit);
        let at = |index: usize| values.get(index).copied().unwrap_or(f64::NAN);
        if self.taken >= self.count {
            return Err(Refused::new(Reason::TooMany)
                .field(self.fields.count)
                .got(self.taken as f64 + 1.0)
                .limits(0.0, self.count as f64));
        }
        for (index, value) in values.iter().take(self.kind.values()).enumerate() {
            finite(field + index as u8, *value)?;
        }
        if let TableKind::Continuous { .. } = self.kind {
            let phase = PointData { vel: at(1), percent: at(2), vel_max: at(3), acc: at(4), dec: at(5) };
            return self.continuous(at(0), phase, scratch);
        }
        let (time, pos) = (at(0), at(1));
        if self.taken > 0 && time <= self.last.0 {
            return Err(Refused::new(Reason::PointTime).field(field).got(time).limits(self.last.0, LATEST_MS));
        }
        within(field, time, 0.0, LATEST_MS)?;
        within(field + 1, pos, -POS_MAX_PULSES, POS_MAX_PULSES)?;
        let begins = self.taken == 0;
        if begins {
            self.first = (time, pos);
        }
        let mut knot = TablePoint { time: time - self.first.0, pos: pos - self.first.1, vel: 0.0 };
        match self.kind {
            TableKind::Pvt => {
                knot.vel = speed(at(2), field + 2, limit)?;
                self.push(knot, scratch)?;
            }
            TableKind::PvtEx => {
                let (vel, end) = (speed(at(2), field + 2, limit)?, speed(at(3), field + 3, limit)?);
                if !begins {
                    knot.vel = self.vel_end;
                    self.push(knot, scratch)?;
                }
                // The last point begins no segment.
                let jump = vel != self.vel_end && self.taken + 1 < self.count;
                if begins || jump {
                    knot.vel = vel;
                    self.jump(knot, scratch)?;
                }
                self.vel_end = end;
            }
            TableKind::Complete { vel_begin, vel_end } => {
                // The user's own numbers, until the velocities are known.
                if begins {
                    self.row = EliminationRow { d: vel_begin, c: 0.0 };
                    scratch.push(TablePoint { time, pos, vel: vel_begin })?;
                } else {
                    let following = (time - self.last.0, pos - self.last.1);
                    let index = usize::from(self.taken).wrapping_sub(1);
                    if index > 0
                        && let Some(mut knot) = scratch.knot(index)
                    {
                        self.row = complete::eliminate(self.row, self.segment, following);
                        knot.vel = self.row.d;
                        scratch.set(index, knot);
                    }
                    scratch.keep(index, self.row.c);
                    self.segment = following;
                    scratch.push(TablePoint { time, pos, vel: vel_end })?;
                }
            }
            TableKind::Percent { .. } => {
                let percent = within(field + 2, at(2), 0.0, 100.0)?;
                if !begins {
                    let span = DoubleDouble::between(time, self.last.0);
                    self.carried = DoubleDouble::between(pos, self.last.1).times(2.0).over(span).minus(self.carried);
                    knot.vel = speed(self.carried.high, field + 1, limit)?;
                    for inner in percent::inner(self.knot, knot, self.percent) {
                        self.push(inner, scratch)?;
                    }
                } else {
                    knot.vel = self.carried.high;
                }
                self.push(knot, scratch)?;
                self.percent = percent;
            }
            TableKind::Continuous { .. } => {}
        }
        self.last = (time, pos);
        self.taken += 1;
        Ok(knot.vel)
    }

    fn continuous(&mut self, pos: f64, phase: PointData, scratch: &mut Scratch<'_>) -> Admitted<f64> {
        let field = self.fields.point;
        within(field, pos, -POS_MAX_PULSES, POS_MAX_PULSES)?;
        speed(phase.vel, field + 1, self.limit)?;
        within(field + 2, phase.percent, 0.0, 100.0)?;
        // The last point begins no segment; its limits are not used.
        if self.taken + 1 < self.count {
            for (value, field) in [(phase.vel_max, field + 3), (phase.acc, field + 4), (phase.dec, field + 5)] {
                let allowed = 1e-30..=if field == self.fields.point + 3 { VEL_MAX_PULSES_PER_MS } else { 1e30 };
                if !allowed.contains(&value) {
                    let (low, high) = (*allowed.start(), *allowed.end());
                    return Err(Refused::range(field, value, low, high));
                }
            }
        }
        if self.taken == 0 {
            self.first = (self.carried.high, pos);
            self.push(TablePoint { time: 0.0, pos: 0.0, vel: phase.vel }, scratch)?;
        } else {
            let distance = DoubleDouble::between(pos, self.last.1);
            let split = continuous::split(&self.phase, distance, phase.vel)?;
            if split.has(1) {
                speed(split.peak, field + 3, self.limit)?;
            }
            let begin = TableKind::time_begin(self.kind);
            let since = |time: DoubleDouble| time.minus(begin).high;
            let start = self.carried;
            let end = start.plus(split.duration());
            if end.high.is_nan() || end.high > LATEST_MS {
                return Err(Refused::range(field + 4, end.high, 0.0, LATEST_MS));
            }
            let to = TablePoint { time: since(end), pos: pos - self.first.1, vel: phase.vel };
            let risen = TablePoint {
                time: since(start.plus(split.times[0])),
                pos: self.knot.pos + split.rise,
                vel: split.peak,
            };
            let falls =
                TablePoint { time: since(end.minus(split.times[2])), pos: to.pos - split.fall, vel: split.peak };
            let percent = self.phase.percent;
            let (rises, cruises, brakes) = (split.has(0), split.has(1), split.has(2));
            if rises {
                let top = if cruises || brakes { risen } else { to };
                self.ramp(top, percent, scratch)?;
            }
            if cruises {
                self.push(if brakes { falls } else { to }, scratch)?;
            }
            if brakes {
                self.ramp(to, percent, scratch)?;
            }
            self.carried = end;
        }
        self.phase = phase;
        self.last = (self.carried.high, pos);
        self.taken += 1;
        Ok(self.carried.high)
    }

    fn ramp(&mut self, to: TablePoint, percent: f64, scratch: &mut Scratch<'_>) -> Admitted<()> {
        for inner in percent::inner(self.knot, to, percent) {
            self.push(inner, scratch)?;
        }
        self.push(to, scratch)
    }

    /// The field of a point's position.
    fn position(&self) -> u8 {
        let index = if let TableKind::Continuous { .. } = self.kind { 0 } else { 1 };
        self.fields.point + index
    }

    /// Adds the next point, after a segment that an axis can run.
    fn push(&mut self, knot: TablePoint, scratch: &mut Scratch<'_>) -> Admitted<()> {
        if self.taken > 0 {
            check(&self.knot, &knot, self.limit).map_err(|refused| refused.field(self.position()))?;
        }
        self.jump(knot, scratch)
    }

    /// Adds the next point, at the time of the one before, or the first.
    fn jump(&mut self, knot: TablePoint, scratch: &mut Scratch<'_>) -> Admitted<()> {
        self.knot = knot;
        if self.load { scratch.push(knot) } else { Ok(()) }
    }

    /// All points have come: the table as the tick will read it; `None` if a point is missing.
    pub fn finish(&self, scratch: &mut Scratch<'_>) -> Option<Admitted<Sealed>> {
        (self.taken == self.count && self.load).then(|| self.seal(scratch))
    }

    fn seal(&self, scratch: &mut Scratch<'_>) -> Admitted<Sealed> {
        if let TableKind::Complete { .. } = self.kind {
            complete::substitute(scratch);
            let mut before = None;
            for index in 0..scratch.used() {
                let Some(mut knot) = scratch.knot(index) else { break };
                knot.time -= self.first.0;
                knot.pos -= self.first.1;
                scratch.set(index, knot);
                if let Some(before) = before.replace(knot) {
                    let checked = check(&before, &knot, self.limit);
                    checked.map_err(|refused| refused.field(self.position()).item(index - 1))?;
                }
            }
        }
        let (delay, duration) = match self.kind {
            TableKind::Continuous { time_begin } => {
                let whole = self.carried.minus(time_begin);
                (instant(time_begin), instant(whole.high) + instant(whole.low))
            }
            _ => (instant(self.first.0), instant(self.last.0) - instant(self.first.0)),
        };
        if duration < (SHORTEST_PASS_NS as i128) << 64 {
            let low = SHORTEST_PASS_NS as f64 / 1e6;
            let (got, field) = (duration as f64 / 1.8446744073709552e25, self.fields.point);
            return Err(Refused::new(Reason::TableShort).field(field).got(got).limits(low, LATEST_MS));
        }
        let displacement = exact(self.last.1) - exact(self.first.1);
        Sealed::of(scratch, Totals { delay, duration, displacement })
    }
}

impl TableKind {
    fn time_begin(self) -> f64 {
        if let TableKind::Continuous { time_begin } = self { time_begin } else { 0.0 }
    }
}

fn speed(vel: f64, field: u8, limit: f64) -> Admitted<f64> {
    if finite(field, vel)?.abs() > limit {
        return Err(Refused::new(Reason::TooFast).field(field).got(vel).limits(-limit, limit));
    }
    Ok(vel)
}
