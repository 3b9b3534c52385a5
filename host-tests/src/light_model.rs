//! Effects of a coordinate system and of distances on a laser channel, by SPEC 6: the independent
//! model for the laser's part of the tick, based on [`crate::laser_model`].
//!
//! In: everything that acts on a channel, at instants that never decrease. Out: the gate commands
//! that follow, for [`crate::laser_model::outcome`], and the law of the power at any time. The
//! commands depend on who lit the channel, what a standstill shuts off, and what a start lights
//! again. Powers are doubles in the mode's unit; a comparison with them states its rounding.
use crate::laser_model::{Command, Family, Mode, Ns};

/// Least and most.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Bounds {
    pub min: f64,
    pub max: f64,
}

/// Planned or actual: of a speed, or of positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Source {
    Planned,
    Encoder,
}

/// How power hangs on the path speed.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Law {
    /// % (kHz, V) for a pulse/ms.
    Ratio(f64),
    /// Power at speeds.
    Table(Vec<(f64, f64)>),
}

/// Velocity follow.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Follow {
    /// Whose speed.
    pub crd: u8,
    pub law: Law,
    pub bounds: Bounds,
}

/// A ratio over positions.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Ratios {
    /// The same everywhere, for each axis.
    Fixed([f64; 4]),
    /// Over the position of each axis: positions and ratios.
    Each(Vec<(f64, [f64; 4])>),
    /// Over the positions of axes 1 and 2 (rows of axis 2's positions), the same ratio for both.
    Plane { x: Vec<f64>, y: Vec<f64>, ratios: Vec<Vec<f64>> },
}

/// Distance follow.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Distance {
    pub source: Source,
    pub reference: [f64; 4],
    pub scale: [f64; 4],
    pub ratios: Ratios,
    /// GUS only.
    pub bounds: Option<Bounds>,
}

/// The command of an entry of a path to a channel.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Buffered {
    Gate(bool),
    Power(f64),
    /// BufLaserFollowMode.
    Mode {
        source: Source,
        start: Option<f64>,
    },
    /// BufLaserFollowRatio, BufLaserFollowTable; BufLaserPrfFollow if the source is in it.
    Follow {
        law: Law,
        bounds: Bounds,
        source: Option<Source>,
    },
    FollowOff,
}

/// What acts on a channel.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Act {
    /// A command of its own.
    Own(Command),
    /// An entry of this coordinate system.
    Entry(u8, Buffered),
    /// It starts; whether it continues after a Stop.
    Starts {
        crd: u8,
        resumes: bool,
    },
    /// A Stop for it, before the standstill that it makes.
    Stops {
        crd: u8,
    },
    /// It is at standstill: by a Stop, or at the end.
    Rests {
        crd: u8,
        stopped: bool,
    },
    /// It is at standstill by an underrun or a fault.
    Fails {
        crd: u8,
    },
    /// SetLaserCrdMap, bit k of coordinate system k from 0.
    Map(u8),
    /// Stop bits 10, 11.
    EndFollow {
        crds: u8,
    },
    Distance(Option<Distance>),
}

/// The settings that make the power.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Power {
    pub mode: Mode,
    pub bounds: Bounds,
    pub direct: f64,
    pub source: Source,
    pub follow: Option<Follow>,
    pub distance: Option<Distance>,
}

/// Straight between points, the border value outside.
pub fn between(points: &[(f64, f64)], at: f64) -> f64 {
    let after = points.partition_point(|point| point.0 <= at);
    let (Some(low), Some(high)) = (points[..after].last(), points.get(after)) else {
        return if after == 0 { points[0].1 } else { points[after - 1].1 };
    };
    low.1 + (high.1 - low.1) * (at - low.0) / (high.0 - low.0)
}

/// Held in all of these; if they exclude each other, the lowest of the upper bounds.
fn held(value: f64, bounds: &[Bounds]) -> f64 {
    let most = bounds.iter().map(|bounds| bounds.max).fold(f64::INFINITY, f64::min);
    let least = bounds.iter().map(|bounds| bounds.min).fold(f64::NEG_INFINITY, f64::max);
    value.max(least).min(most)
}

impl Distance {
    fn term(&self, positions: [f64; 4]) -> f64 {
        let ratio = |axis: usize| match &self.ratios {
            Ratios::Fixed(ratios) => ratios[axis],
            Ratios::Each(points) => {
                let points: Vec<_> = points.iter().map(|(at, ratios)| (*at, ratios[axis])).collect();
                between(&points, positions[axis])
            }
            Ratios::Plane { .. } if axis > 1 => 0.0,
            Ratios::Plane { x, y, ratios } => {
                let rows = y.iter().zip(ratios).map(|(y, row)| {
                    let row: Vec<_> = x.iter().copied().zip(row.iter().copied()).collect();
                    (*y, between(&row, positions[0]))
                });
                between(&rows.collect::<Vec<_>>(), positions[1])
            }
        };
        (0..4).map(|axis| (positions[axis] - self.reference[axis]) / self.scale[axis] * ratio(axis)).sum()
    }
}

/// The greatest slope between points, in either direction, and the greatest amount.
fn steepest(points: &[(f64, f64)]) -> (f64, f64) {
    let slope = |pair: &[(f64, f64)]| ((pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).abs();
    (points.windows(2).map(slope).fold(0.0, f64::max), points.iter().map(|point| point.1.abs()).fold(0.0, f64::max))
}

impl Distance {
    /// How far the term is off at most, where positions are off by this much.
    pub fn turns(&self, positions: [f64; 4], off: [f64; 4]) -> f64 {
        let each = |axis: usize, change: f64, most: f64| {
            let distance = (positions[axis] - self.reference[axis]).abs() + off[axis];
            (distance * change + most * off[axis]) / self.scale[axis]
        };
        match &self.ratios {
            Ratios::Fixed(ratios) => (0..4).map(|axis| each(axis, 0.0, ratios[axis].abs())).sum(),
            Ratios::Each(points) => (0..4)
                .map(|axis| {
                    let own: Vec<_> = points.iter().map(|(at, ratios)| (*at, ratios[axis])).collect();
                    let (slope, most) = steepest(&own);
                    each(axis, slope * off[axis], most)
                })
                .sum(),
            Ratios::Plane { x, y, ratios } => {
                let rows = ratios.iter().map(|row| x.iter().copied().zip(row.iter().copied()).collect::<Vec<_>>());
                let columns = (0..x.len()).map(|at| y.iter().zip(ratios).map(|(y, row)| (*y, row[at])).collect());
                let most = |(slope, most): (f64, f64), points: Vec<_>| {
                    let own = steepest(&points);
                    (slope.max(own.0), most.max(own.1))
                };
                let (across, highest) = rows.fold((0.0, 0.0), most);
                let (along, _) = columns.fold((0.0, 0.0), most);
                (0..2).map(|axis| each(axis, across * off[0] + along * off[1], highest)).sum()
            }
        }
    }
}

impl Power {
    /// Output while there is light. `speed` gives that of a coordinate system, `positions` those of
    /// axes 1 to 4.
    pub fn value(
        &self,
        family: Family,
        speed: impl Fn(u8, Source) -> f64,
        positions: impl Fn(Source) -> [f64; 4],
    ) -> f64 {
        let followed = self.follow.as_ref().map(|follow| {
            let speed = speed(follow.crd, self.source);
            match &follow.law {
                Law::Ratio(ratio) => ratio * speed + follow.bounds.min,
                Law::Table(points) => between(points, speed),
            }
        });
        let distance = self.distance.as_ref().map_or(0.0, |distance| distance.term(positions(distance.source)));
        let follow_bounds = self.follow.as_ref().map(|follow| follow.bounds);
        match family {
            Family::Gus => {
                let velocity = match (followed, follow_bounds) {
                    (Some(power), Some(bounds)) => held(power, &[bounds]),
                    _ => self.direct,
                };
                let own = self.distance.as_ref().and_then(|distance| distance.bounds);
                let bounds: Vec<_> = own.into_iter().chain([self.bounds]).collect();
                held(velocity + distance, &bounds)
            }
            Family::Lsr => {
                let bounds: Vec<_> = follow_bounds.into_iter().chain([self.bounds]).collect();
                held(self.direct + followed.unwrap_or(0.0) + distance, &bounds)
            }
        }
    }
}

/// A channel's story.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// The job that [`crate::laser_model::outcome`] makes edges of; its powers and bounds mean
    /// nothing.
    pub job: Vec<(Ns, Command)>,
    /// What makes the power, from these instants on.
    pub powers: Vec<(Ns, Power)>,
}

impl Light {
    /// What makes the power at an instant.
    pub fn power(&self, at: Ns) -> &Power {
        let after = self.powers.partition_point(|&(from, _)| from <= at);
        &self.powers[after - 1].1
    }
}

/// Who gave the on command in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    Call,
    Crd(u8),
}

/// Whose light it is, and what keeps it dark: SPEC 6 "Whose light it is", "Rest".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Gate {
    /// The on command in force.
    on: Option<By>,
    /// Coordinate systems whose Stop has shut it off, by bits.
    shut: u8,
    /// For the CrdStart of the coordinate system whose speed the power follows.
    waits: bool,
    /// An immediate off was the last command that was no off entry.
    vetoed: bool,
    fault: bool,
    connector: bool,
    /// Which coordinate systems run, by bits.
    run: u8,
    /// Which of them brake for a Stop.
    brake: u8,
}

impl Gate {
    const OFF: Gate =
        Gate { on: None, shut: 0, waits: false, vetoed: false, fault: false, connector: true, run: 0, brake: 0 };

    /// No on command is in force, and nothing brings light back.
    fn forget(&mut self) {
        (self.on, self.shut, self.waits) = (None, 0, false);
    }

    fn is_lit(&self) -> bool {
        self.on.is_some() && self.shut == 0 && !self.waits
    }

    /// An on command that counts: it replaces the last one, and waits under a follow at standstill.
    fn light(&mut self, by: By, power: &Power) {
        (self.on, self.shut, self.vetoed) = (Some(by), 0, false);
        self.waits = self.is_at_rest(power);
    }

    /// The power follows the speed of a coordinate system that does not run.
    fn is_at_rest(&self, power: &Power) -> bool {
        power.follow.as_ref().is_some_and(|follow| self.run >> follow.crd & 1 == 0)
    }

    /// An on command would meet no output, or a fault.
    fn is_dead(&self, power: &Power) -> bool {
        self.fault || !self.connector && power.mode != Mode::Analog
    }
}

fn real(value: crate::laser_model::Exact) -> f64 {
    *value.numer() as f64 / *value.denom() as f64
}

/// LSR has no mode 3 of its own.
fn kind(family: Family, mode: Mode) -> Mode {
    if family == Family::Lsr && mode == Mode::Open { Mode::Duty } else { mode }
}

/// What follows from everything that acts.
pub fn light(family: Family, acts: &[(Ns, Act)]) -> Light {
    let full = Bounds { min: 0.0, max: 100.0 };
    let mut power =
        Power { mode: Mode::Duty, bounds: full, direct: 0.0, source: Source::Planned, follow: None, distance: None };
    let mut made = Light { job: Vec::new(), powers: vec![(Ns::MIN, power.clone())] };
    let mut gate = Gate::OFF;
    let mut map = 0b11;
    for (at, act) in acts {
        let follow = power.follow.clone();
        let lit = gate.is_lit();
        let mapped = |crd: u8| map >> crd & 1 == 1;
        // The channel's own commands, and those that act at once; the gate's other commands come
        // below.
        let mut reported = None;
        match act {
            Act::Own(command) => {
                reported = Some(command.clone());
                match command {
                    // Nothing is lit, and nothing remembered.
                    Command::Gate(true) if gate.is_dead(&power) => reported = None,
                    // It changes nothing while the light of a coordinate system is on.
                    Command::Gate(true) if lit && matches!(gate.on, Some(By::Crd(_))) => reported = None,
                    Command::Gate(true) => {
                        gate.light(By::Call, &power);
                        reported = reported.filter(|_| gate.is_lit());
                    }
                    Command::Gate(false) => {
                        gate.forget();
                        gate.vetoed = true;
                    }
                    Command::PowerMode { mode, max, min, .. } => {
                        let mode = kind(family, *mode);
                        if mode != power.mode {
                            gate.forget();
                            (power.direct, power.follow) = (0.0, None);
                        }
                        (power.mode, power.bounds) = (mode, Bounds { min: real(*min), max: real(*max) });
                    }
                    Command::Power(value) => {
                        power.direct = real(*value);
                        if family == Family::Gus {
                            power.follow = None;
                        }
                    }
                    Command::Fault => {
                        gate.forget();
                        gate.fault = true;
                    }
                    Command::Clear => gate.fault = false,
                    Command::Reset => gate = Gate { run: gate.run, brake: gate.brake, ..Gate::OFF },
                    Command::Connector(carries) => {
                        gate.connector = *carries;
                        if !carries && power.mode != Mode::Analog {
                            gate.forget();
                        }
                    }
                    _ => {}
                }
            }
            // One that is reached when the map does not hold its coordinate system.
            Act::Entry(crd, _) if !mapped(*crd) => {}
            Act::Entry(_, Buffered::Gate(true)) if gate.is_dead(&power) => {}
            // After an immediate off nothing that is passed in braking lights.
            Act::Entry(crd, Buffered::Gate(true)) if gate.vetoed && gate.brake >> crd & 1 == 1 => {}
            Act::Entry(crd, Buffered::Gate(true)) => {
                gate.light(By::Crd(*crd), &power);
                reported = gate.is_lit().then_some(Command::Gate(true));
            }
            Act::Entry(_, Buffered::Gate(false)) => {
                gate.forget();
                reported = Some(Command::Gate(false));
            }
            Act::Entry(_, Buffered::Power(value)) => {
                power.direct = *value;
                if family == Family::Gus {
                    power.follow = None;
                }
            }
            Act::Entry(_, Buffered::Mode { source, start }) => {
                power.source = *source;
                power.direct = start.unwrap_or(power.direct);
            }
            Act::Entry(crd, Buffered::Follow { law, bounds, source }) => {
                power.source = source.unwrap_or(power.source);
                power.follow = Some(Follow { crd: *crd, law: law.clone(), bounds: *bounds });
            }
            Act::Entry(_, Buffered::FollowOff) => power.follow = None,
            Act::Starts { crd, resumes } => {
                let bit = 1 << crd;
                (gate.run, gate.brake) = (gate.run | bit, gate.brake & !bit);
                if gate.shut & bit != 0 {
                    gate.shut &= !bit;
                    if !resumes {
                        gate.forget();
                    }
                }
                gate.waits = gate.on.is_some() && gate.is_at_rest(&power);
            }
            // A Stop at standstill shuts off light that no start returns.
            Act::Stops { crd } if gate.run >> crd & 1 == 0 => {
                if mapped(*crd) {
                    gate.forget();
                }
            }
            Act::Stops { crd } => gate.brake |= 1 << crd,
            Act::Rests { crd, stopped } => {
                let bit = 1 << crd;
                let braked = gate.brake & bit != 0;
                (gate.run, gate.brake) = (gate.run & !bit, gate.brake & !bit);
                let follows = power.follow.as_ref().is_some_and(|follow| follow.crd == *crd);
                if *stopped {
                    // Whoever lit it.
                    gate.shut |= if mapped(*crd) && gate.on.is_some() { bit } else { 0 };
                } else if gate.on == Some(By::Crd(*crd)) || follows || braked && mapped(*crd) {
                    // The entries have run out; also those that a Stop interrupted.
                    gate.forget();
                }
            }
            Act::Fails { crd } => {
                let bit = 1 << crd;
                (gate.run, gate.brake) = (gate.run & !bit, gate.brake & !bit);
                if mapped(*crd) {
                    gate.forget();
                    gate.fault = true;
                    reported = Some(Command::Fault);
                }
            }
            Act::Map(crds) => {
                map = *crds;
                power.follow.take_if(|follow| crds >> follow.crd & 1 == 0);
            }
            Act::EndFollow { crds } => {
                power.follow.take_if(|follow| crds >> follow.crd & 1 == 1);
            }
            Act::Distance(distance) => power.distance = distance.clone(),
        }
        if follow.is_some() && follow != power.follow && gate.waits {
            // What waits for the start of a coordinate system ends with its follow; what a Stop
            // shut off does not.
            gate.forget();
        }
        let ends_or_begins = reported.is_none() && gate.is_lit() != lit;
        made.job
            .extend(reported.or(ends_or_begins.then_some(Command::Gate(gate.is_lit()))).map(|command| (*at, command)));
        made.powers.push((*at, power.clone()));
    }
    made
}

#[cfg(test)]
mod tests;
