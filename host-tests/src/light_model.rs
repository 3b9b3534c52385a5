//! What a coordinate system and distances do to a laser channel, as SPEC 6 tells it: the second opinion to the laser's
//! part of the tick, on top of [`crate::laser_model`].
//!
//! In: everything that acts on a channel, at instants that never go back. Out: the gate commands that follow from it
//! (who lit, what rest takes and what a start brings back), for [`crate::laser_model::outcome`], and the law of the
//! power at any time. Powers are doubles in the mode's unit; what is compared with them states its rounding.
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
    /// Over the position of each axis: places and ratios.
    Each(Vec<(f64, [f64; 4])>),
    /// Over the positions of axes 1 and 2 (rows of axis 2's places), the same ratio for both.
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

/// What an entry of a path tells a channel.
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
    /// BufLaserFollowRatio, BufLaserFollowTable; BufLaserPrfFollow where the source comes along.
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
    /// It starts; whether it goes on after a Stop.
    Starts {
        crd: u8,
        resumes: bool,
    },
    /// It rests: by a Stop, or at the end.
    Rests {
        crd: u8,
        stopped: bool,
    },
    /// It rests by an underrun or a fault.
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

/// The greatest slope between points, either way, and the greatest amount.
fn steepest(points: &[(f64, f64)]) -> (f64, f64) {
    let slope = |pair: &[(f64, f64)]| ((pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).abs();
    (points.windows(2).map(slope).fold(0.0, f64::max), points.iter().map(|point| point.1.abs()).fold(0.0, f64::max))
}

impl Distance {
    /// How far the term is off at most, where positions are off by this much.
    pub fn turns(&self, positions: [f64; 4], off: [f64; 4]) -> f64 {
        let each = |axis: usize, change: f64, most: f64| {
            let way = (positions[axis] - self.reference[axis]).abs() + off[axis];
            (way * change + most * off[axis]) / self.scale[axis]
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
    /// What is put out where there is light. `speed` tells that of a coordinate system, `positions` those of axes 1 to 4.
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
    /// The job that [`crate::laser_model::outcome`] makes edges of; its powers and bounds mean nothing.
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

/// Who lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Owner {
    Nobody,
    Command,
    Crd(u8),
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
    let mut owner = Owner::Nobody;
    // Light that a Stop of this coordinate system took and that its next start brings back.
    let mut kept: Option<u8> = None;
    let mut map = 0b11;
    for (at, act) in acts {
        let gate = |on: bool| (*at, Command::Gate(on));
        let before = power.follow.clone();
        match act {
            Act::Own(command) => {
                match command {
                    Command::Gate(on) => (owner, kept) = (if *on { Owner::Command } else { Owner::Nobody }, None),
                    Command::PowerMode { mode, max, min, .. } => {
                        let mode = kind(family, *mode);
                        if mode != power.mode {
                            (owner, kept) = (Owner::Nobody, None);
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
                    Command::Fault | Command::Reset => (owner, kept) = (Owner::Nobody, None),
                    Command::Connector(false) if power.mode != Mode::Analog => (owner, kept) = (Owner::Nobody, None),
                    _ => {}
                }
                made.job.push((*at, command.clone()));
            }
            Act::Entry(crd, Buffered::Gate(on)) => {
                (owner, kept) = (if *on { Owner::Crd(*crd) } else { Owner::Nobody }, None);
                made.job.push(gate(*on));
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
                if kept == Some(*crd) {
                    kept = None;
                    if *resumes {
                        owner = Owner::Crd(*crd);
                        made.job.push(gate(true));
                    }
                }
            }
            Act::Rests { crd, stopped } => {
                if owner == Owner::Crd(*crd) && map >> crd & 1 == 1 {
                    owner = Owner::Nobody;
                    kept = stopped.then_some(*crd);
                    made.job.push(gate(false));
                }
            }
            Act::Fails { crd } => {
                if map >> crd & 1 == 1 {
                    (owner, kept) = (Owner::Nobody, None);
                    made.job.push((*at, Command::Fault));
                }
            }
            Act::Map(crds) => map = *crds,
            Act::EndFollow { crds } => {
                power.follow.take_if(|follow| crds >> follow.crd & 1 == 1);
            }
            Act::Distance(distance) => power.distance = distance.clone(),
        }
        if before.is_some() && before != power.follow {
            // Light that rest kept dark counts as switched off.
            kept = None;
        }
        made.powers.push((*at, power.clone()));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laser_model::Exact;

    fn power(family: Family, acts: &[Act], speed: f64, positions: [f64; 4]) -> f64 {
        let acts: Vec<_> = acts.iter().map(|act| (0, act.clone())).collect();
        light(family, &acts).power(0).value(family, |_, _| speed, |_| positions)
    }

    fn mode(min: i128, max: i128) -> Act {
        let (min, max) = (Exact::from_integer(min), Exact::from_integer(max));
        Act::Own(Command::PowerMode { mode: Mode::Duty, max, min, delayed: true })
    }

    fn follow(ratio: f64, min: f64, max: f64) -> Act {
        let bounds = Bounds { min, max };
        Act::Entry(0, Buffered::Follow { law: Law::Ratio(ratio), bounds, source: None })
    }

    fn distance(ratio: f64, bounds: Option<(f64, f64)>) -> Act {
        Act::Distance(Some(Distance {
            source: Source::Planned,
            reference: [100.0, 0.0, 0.0, 0.0],
            scale: [1000.0; 4],
            ratios: Ratios::Fixed([ratio, 0.0, 0.0, 0.0]),
            bounds: bounds.map(|(min, max)| Bounds { min, max }),
        }))
    }

    /// The manuals' numbers, and the table of bounds, worked out by hand.
    #[test]
    fn powers() {
        use Family::{Gus, Lsr};
        let direct = Act::Entry(0, Buffered::Power(7.0));
        let listing = [mode(0, 100), direct.clone(), follow(0.1, 10.0, 100.0)];
        // x = 0.1·50 + 10; LSR adds the direct power.
        assert_eq!(power(Gus, &listing, 50.0, [0.0; 4]), 15.0);
        assert_eq!(power(Lsr, &listing, 50.0, [0.0; 4]), 22.0);
        assert_eq!(power(Gus, &listing, 5000.0, [0.0; 4]), 100.0);
        // A direct power ends it in GUS.
        let ended = [follow(0.1, 10.0, 100.0), direct.clone()];
        assert_eq!(power(Gus, &ended, 50.0, [0.0; 4]), 7.0);
        assert_eq!(power(Lsr, &ended, 50.0, [0.0; 4]), 22.0);
        // 10000 pulses away, 0.1 for 1000: 1 more. In GUS the velocity part has its own bounds.
        let both = [mode(0, 100), follow(0.1, 10.0, 14.0), distance(0.1, Some((0.0, 90.0)))];
        assert_eq!(power(Gus, &both, 50.0, [10_100.0, 0.0, 0.0, 0.0]), 15.0);
        assert_eq!(power(Lsr, &both, 50.0, [10_100.0, 0.0, 0.0, 0.0]), 14.0);
        // The sum is held in the distance bounds, then in those of the mode.
        let low = [mode(20, 30), follow(0.1, 10.0, 14.0), distance(0.1, Some((0.0, 12.0)))];
        assert_eq!(power(Gus, &low, 0.0, [0.0; 4]), 12.0, "the lowest of the upper bounds");
        let points = vec![(10.0, 20.0), (20.0, 60.0)];
        let table = |at: f64| between(&points, at);
        assert_eq!([table(0.0), table(10.0), table(12.5), table(20.0), table(99.0)], [20.0, 20.0, 30.0, 60.0, 60.0]);
    }

    /// Whose light it is: SPEC 6 "Rest".
    #[test]
    fn rest_takes_what_entries_lit() {
        let gates = |acts: &[Act]| -> Vec<bool> {
            let acts: Vec<_> = acts.iter().cloned().map(|act| (0, act)).collect();
            let job = light(Family::Gus, &acts).job;
            job.iter().map(|(_, command)| *command == Command::Gate(true)).collect()
        };
        let (on, off) = (Act::Entry(0, Buffered::Gate(true)), Act::Entry(0, Buffered::Gate(false)));
        let stop = Act::Rests { crd: 0, stopped: true };
        let (again, anew) = (Act::Starts { crd: 0, resumes: true }, Act::Starts { crd: 0, resumes: false });
        let command = Act::Own(Command::Gate(true));
        let end = Act::Rests { crd: 0, stopped: false };
        assert_eq!(gates(&[on.clone(), stop.clone(), again.clone()]), [true, false, true]);
        assert_eq!(gates(&[on.clone(), stop.clone(), anew]), [true, false]);
        assert_eq!(gates(&[on.clone(), end, again.clone()]), [true, false]);
        assert_eq!(gates(&[command.clone(), stop.clone(), again.clone()]), [true]);
        assert_eq!(gates(&[on.clone(), command, stop.clone()]), [true, true]);
        assert_eq!(gates(&[Act::Map(0b10), on.clone(), stop.clone()]), [true]);
        assert_eq!(gates(&[on.clone(), stop.clone(), off, again.clone()]), [true, false, false]);
        let other = Act::Rests { crd: 1, stopped: true };
        assert_eq!(gates(&[on.clone(), other]), [true]);
        let ended = [follow(1.0, 0.0, 1.0), on, stop, Act::EndFollow { crds: 1 }, again];
        assert_eq!(gates(&ended), [true, false]);
    }
}
