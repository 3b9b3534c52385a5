//! Random paths with look-ahead on the virtual controller, held by what docs/crd.md says of every
//! plan: there is no second planner here.
//!
//! * every place of a tick is on the path, to 2⁻¹⁶ pulse, and further along it than the one before;
//!   the end is exact
//! * speeds within programmed ones, those of the frame and of each coordinate; rest at BufDelay and
//!   at the end of LnXYG0
//! * within a motion the acceleration of each coordinate is within its limit L, and along the path
//!   within synAcc; while a Stop brakes, within its deceleration if that is more
//! * a corner changes the velocity of a coordinate by L·T at most, and from the middle of a motion
//!   to that of another the mean acceleration is within L
//! * both without what half a pulse explains at each end of both lines
//! * outputs change where the path passes their vertex; motions are counted
//!
//! `REFERENCE_AHEAD` sets how many paths there are, `REFERENCE_SEED` the first one's number.
use super::machine::{Got, Reported, Rig, fixed, got};
use course::{Course, Entry, course};
use host_tests::path_model::Geometry;
use host_tests::reference::{Call, Family, Path, PathCall, Setup};
use std::collections::BTreeMap;

#[path = "ahead/course.rs"]
mod course;

type Position = [f64; 4];

/// Rounding of a set-point.
const ROUNDING_PULSES: f64 = 1.0 / 4_194_304.0;
/// SPEC 11.
const BOUND_PULSES: f64 = 1.0 / 65_536.0;

/// Where on a motion a place is: how far along, and how far from it.
fn project(geometry: &Geometry, position: &Position, least: f64) -> (f64, f64) {
    let length = geometry.length();
    let along = match *geometry {
        Geometry::Line { from, to } => {
            (0..4).map(|axis| (position[axis] - from[axis]) * (to[axis] - from[axis])).sum::<f64>() / length
        }
        Geometry::Arc { from, plane, centre, radius, sweep } => {
            let (first, second) = plane.axes();
            let arm = (from[first] - centre.0, from[second] - centre.1);
            let now = (position[first] - centre.0, position[second] - centre.1);
            let turn = (arm.0 * now.1 - arm.1 * now.0).atan2(arm.0 * now.0 + arm.1 * now.1) * sweep.signum();
            // Not further back than it was: a turn further.
            let turn = if turn * radius < least - 1e-3 { turn + std::f64::consts::TAU } else { turn };
            turn * radius
        }
    };
    let along = along.clamp(0.0, length);
    let near = geometry.at(along);
    (along, (0..4).map(|axis| (near[axis] - position[axis]).powi(2)).sum::<f64>().sqrt())
}

/// Where the path is at a tick.
#[derive(Debug, Clone, Copy)]
struct Spot {
    motion: usize,
    /// From the begin of that motion, and from the begin of the path.
    along: f64,
    travelled: f64,
    /// The next motion goes back over it: it may be there.
    is_double: bool,
}

struct Motion<'a> {
    geometry: &'a Geometry,
    vel: f64,
    acc: f64,
    rests: bool,
    /// Where it begins on the path.
    begin: f64,
    /// A delay stands before it.
    waits: bool,
}

#[allow(clippy::type_complexity, reason = "motions, outputs and delays, taken apart at once")]
fn motions(course: &Course) -> (Vec<Motion<'_>>, Vec<(usize, u8, bool)>, Vec<(usize, f64)>) {
    let (mut motions, mut outputs, mut delays): (Vec<Motion>, Vec<_>, Vec<_>) = Default::default();
    let (mut begin, mut waits) = (0.0, false);
    for entry in &course.entries {
        match entry {
            Entry::Motion(geometry, vel, acc, rests) => {
                motions.push(Motion { geometry, vel: *vel, acc: *acc, rests: *rests, begin, waits });
                (begin, waits) = (begin + geometry.length(), false);
            }
            Entry::Delay(ms) => {
                waits = true;
                delays.push((motions.len(), *ms));
            }
            Entry::Output(bit, level) => outputs.push((motions.len(), *bit, *level)),
        }
    }
    (motions, outputs, delays)
}

/// What is wrong, if anything.
fn judge(
    course: &Course,
    reported: &Reported,
    tick_ms: f64,
    tally: &mut BTreeMap<&'static str, u64>,
) -> Result<(), String> {
    for (index, answer) in reported.answers.iter().enumerate() {
        // There may be nothing to go on with.
        let starts = Call::Path(PathCall { core: 1, what: Path::Start { mask: 1, option: 0 } });
        let may_fail = course.calls[index] == starts;
        if answer.code != 0 && !may_fail {
            return Err(format!("call {index}, {:?}, answers {} {:?}", course.calls[index], answer.code, answer.error));
        }
    }
    let (motions, outputs, delays) = motions(course);
    if motions.is_empty() {
        return Ok(());
    }
    let positions: Vec<Position> = reported
        .rows
        .iter()
        .map(|row| {
            let at = |axis: usize| (fixed(row[axis].0) - fixed(reported.begin[axis])).to_f64();
            std::array::from_fn(|axis| if axis < course.dimension { at(axis) } else { 0.0 })
        })
        .collect();
    let spots = spots(&motions, &positions, tick_ms, course)?;
    let last = motions.last().ok_or("no motions")?;
    let end = last.geometry.end();
    let position = positions[positions.len() - 1];
    if (0..4).any(|axis| (position[axis] - end[axis].round()).abs() > ROUNDING_PULSES) {
        return Err(format!("it ends at {position:?}, not at {end:?}"));
    }
    let status = course.calls.len() - 1;
    let counted = reported.answers.get(status).map(|answer| got(&course.calls[status], answer));
    if counted != Some(Got::Two(0, motions.len() as i64)) {
        return Err(format!("{counted:?} motions are counted of {}", motions.len()));
    }
    *tally.entry("paths").or_default() += 1;
    *tally.entry("motions").or_default() += motions.len() as u64;
    speeds(course, &motions, &spots, &positions, tick_ms)?;
    accelerations(course, &motions, &spots, &positions, tick_ms, tally)?;
    rests(course, &motions, &spots, &delays, tick_ms, tally)?;
    edges(course, &motions, &spots, &outputs, reported, tick_ms, tally)
}

/// Every tick's place on the path.
fn spots(motions: &[Motion], positions: &[Position], tick_ms: f64, course: &Course) -> Result<Vec<Spot>, String> {
    let mut at = Spot { motion: 0, along: 0.0, travelled: 0.0, is_double: false };
    let mut spots = Vec::new();
    for (tick, position) in positions.iter().enumerate() {
        let mut index = at.motion;
        let found = loop {
            let Some(motion) = motions.get(index) else { break None };
            let least = if index == at.motion { at.along } else { 0.0 };
            let (along, off) = project(motion.geometry, position, least);
            let travelled = motion.begin + along;
            if travelled > at.travelled + course.speed * tick_ms * 1.001 + 1.0 {
                break None;
            }
            if off <= 2.0 * BOUND_PULSES && travelled >= at.travelled - 2.0 * BOUND_PULSES {
                let next = motions.get(index + 1).map(|next| project(next.geometry, position, 0.0));
                let is_double =
                    next.is_some_and(|(along, off)| off <= 2.0 * BOUND_PULSES && along > 4.0 * BOUND_PULSES);
                break Some(Spot { motion: index, along, travelled: travelled.max(at.travelled), is_double });
            }
            index += 1;
        };
        let Some(found) = found else {
            let near = |index: usize| {
                let motion = motions.get(index)?;
                let (along, off) = project(motion.geometry, position, 0.0);
                Some((index, along, motion.geometry.length(), off))
            };
            let around: Vec<_> = (at.motion..at.motion + 3).filter_map(near).collect();
            let ms = tick as f64 * tick_ms;
            return Err(format!("at {ms} ms {position:?} is not on the path, where it was at {at:?}: {around:?}"));
        };
        at = found;
        spots.push(at);
    }
    Ok(spots)
}

#[allow(clippy::needless_range_loop, reason = "several tables by coordinate")]
fn speeds(
    course: &Course,
    motions: &[Motion],
    spots: &[Spot],
    positions: &[Position],
    tick_ms: f64,
) -> Result<(), String> {
    for (tick, pair) in spots.windows(2).enumerate() {
        if pair.iter().any(|spot| spot.is_double) {
            continue;
        }
        let within = &motions[pair[0].motion..=pair[1].motion];
        let most = within.iter().map(|motion| motion.vel).fold(0.0, f64::max).min(course.speed);
        let speed = (pair[1].travelled - pair[0].travelled) / tick_ms;
        let ms = tick as f64 * tick_ms;
        if speed > most * (1.0 + 1e-9) + 4.0 * BOUND_PULSES / tick_ms {
            let from = tick.saturating_sub(2);
            let around = &spots[from..(tick + 4).min(spots.len())];
            let given: Vec<_> = motions[pair[0].motion..=pair[1].motion].iter().map(|motion| motion.geometry).collect();
            return Err(format!("at {ms} ms its speed is {speed}, {most} is programmed: {around:?} {given:?}"));
        }
        for axis in 0..course.dimension {
            let speed = (positions[tick + 1][axis] - positions[tick][axis]).abs() / tick_ms;
            if speed > course.vel[axis] + 4.0 * ROUNDING_PULSES / tick_ms {
                return Err(format!("at {ms} ms coordinate {axis} has {speed}, its limit is {}", course.vel[axis]));
            }
        }
    }
    Ok(())
}

/// The change of direction between two lines that half a pulse at each of their ends explains.
fn hidden(one: &Geometry, other: &Geometry) -> f64 {
    let is_line = |geometry: &Geometry| matches!(geometry, Geometry::Line { .. });
    if is_line(one) && is_line(other) { 1.0 / one.length() + 1.0 / other.length() } else { 0.0 }
}

/// Within motions, at corners, and from middle to middle.
#[allow(clippy::needless_range_loop, reason = "several tables by coordinate")]
fn accelerations(
    course: &Course,
    motions: &[Motion],
    spots: &[Spot],
    positions: &[Position],
    tick_ms: f64,
    tally: &mut BTreeMap<&'static str, u64>,
) -> Result<(), String> {
    let rounding = 4.0 * ROUNDING_PULSES / (tick_ms * tick_ms);
    let moves = |tick: usize| spots[tick + 1].travelled > spots[tick].travelled;
    for tick in 1..spots.len() - 1 {
        let three = &spots[tick - 1..=tick + 1];
        if three[0].motion != three[2].motion || three.iter().any(|spot| spot.is_double) {
            continue;
        }
        let ms = tick as f64 * tick_ms;
        let motion = &motions[three[0].motion];
        // Within rounding of its end it may be on the next one.
        if three[2].along > motion.geometry.length() - 4.0 * BOUND_PULSES {
            continue;
        }
        let braking = if course.disturbed { course.stop_dec } else { 0.0 };
        // An abrupt Stop takes no time, and the path begins again from standstill.
        if course.disturbed && (!moves(tick - 1) || !moves(tick)) {
            continue;
        }
        let second = three[2].travelled - 2.0 * three[1].travelled + three[0].travelled;
        let along = second.abs() / (tick_ms * tick_ms);
        let room = BOUND_PULSES.min(1e-6 * motion.geometry.length() + 8.0 * ROUNDING_PULSES) / (tick_ms * tick_ms);
        if along > motion.acc.max(braking) * (1.0 + 1e-6) + room {
            let from = tick.saturating_sub(4);
            let travelleds: Vec<(usize, f64)> =
                spots[from..(tick + 5).min(spots.len())].iter().map(|spot| (spot.motion, spot.along)).collect();
            return Err(format!(
                "at {ms} ms the acceleration along the path is {along}, synAcc {}: {travelleds:?} of {:?} after {:?}",
                motion.acc,
                motion.geometry,
                motions[three[0].motion.saturating_sub(1)].geometry
            ));
        }
        for axis in 0..course.dimension {
            let second = positions[tick + 1][axis] - 2.0 * positions[tick][axis] + positions[tick - 1][axis];
            let acc = second.abs() / (tick_ms * tick_ms);
            let limit = course.acc[axis];
            // On an arc the centre takes its part while a Stop brakes.
            let limit = if course.disturbed { limit.max(braking) + limit } else { limit };
            if acc > limit * (1.0 + 1e-6) + rounding {
                return Err(format!("at {ms} ms coordinate {axis} has the acceleration {acc}, its limit is {limit}"));
            }
            *tally.entry("accelerations within motions").or_default() += 1;
        }
    }
    if course.disturbed {
        return Ok(());
    }
    // Mean velocities of the first and the last whole tick of each motion, and the velocity in its
    // middle.
    let mean = |tick: usize, axis: usize| (positions[tick + 1][axis] - positions[tick][axis]) / tick_ms;
    let mut before: Option<(usize, f64, usize)> = None;
    let mut from = 0;
    for (index, motion) in motions.iter().enumerate() {
        let first = from + spots[from..].iter().take_while(|spot| spot.motion < index).count();
        let last = first + spots[first..].iter().take_while(|spot| spot.motion == index).count();
        from = first;
        if last < first + 3 {
            before = None;
            continue;
        }
        let last = last - 1;
        let apart = motion.waits || index > 0 && motions[index - 1].rests;
        let hidden = index.checked_sub(1).map_or(0.0, |before| hidden(motions[before].geometry, motion.geometry));
        let rounded = |from: usize, to: usize| {
            let speed = |tick: usize| (spots[tick + 1].travelled - spots[tick].travelled) / tick_ms;
            hidden * (from..=to).map(speed).fold(0.0, f64::max)
        };
        if let Some((tick, ..)) = before.filter(|_| !apart) {
            for axis in 0..course.dimension {
                let jump = (mean(first, axis) - mean(tick, axis)).abs();
                let limit = course.acc[axis];
                let most = limit * (course.corner + (first + 1 - tick) as f64 * tick_ms);
                if jump > most * (1.0 + 1e-6) + rounded(tick, first) + 4.0 * ROUNDING_PULSES / tick_ms {
                    return Err(format!(
                        "before motion {index} the velocity of coordinate {axis} changes by {jump}, L·T is {}",
                        limit * course.corner
                    ));
                }
                *tally.entry("corners").or_default() += 1;
            }
        }
        // The middle of its length lies in this tick.
        let half = motion.geometry.length() / 2.0;
        let middle = (first..last).find(|tick| spots[*tick].along <= half && spots[tick + 1].along > half);
        let Some(middle) = middle.filter(|middle| *middle > first && middle + 1 < last) else {
            before = Some((last - 1, 0.0, 0));
            continue;
        };
        if let Some((_, ms, other)) = before.filter(|(.., other)| *other != 0 && !apart) {
            let now = middle as f64 * tick_ms;
            for axis in 0..course.dimension {
                let change = (mean(middle, axis) - mean(other, axis)).abs();
                let limit = course.acc[axis];
                // The middles lie within their ticks: up to a tick of acceleration at each end.
                let most = limit * (now - ms + 2.0 * tick_ms) * (1.0 + 1e-3);
                if change > most + rounded(other, middle) + 4.0 * ROUNDING_PULSES / tick_ms {
                    let mean = change / (now - ms);
                    return Err(format!(
                        "from the middle of motion {} to that of {index} coordinate {axis} has {mean}, its limit is {limit}",
                        index - 1
                    ));
                }
                *tally.entry("middles").or_default() += 1;
            }
        }
        before = Some((last - 1, middle as f64 * tick_ms, middle));
    }
    Ok(())
}

/// Delays, and rest at the end of LnXYG0.
fn rests(
    course: &Course,
    motions: &[Motion],
    spots: &[Spot],
    delays: &[(usize, f64)],
    tick_ms: f64,
    tally: &mut BTreeMap<&'static str, u64>,
) -> Result<(), String> {
    for (index, motion) in motions.iter().enumerate() {
        let stands = motion.waits || index > 0 && motions[index - 1].rests;
        if index == 0 || !stands {
            continue;
        }
        let vertex = motion.begin;
        let tick = spots.partition_point(|spot| spot.travelled < vertex - BOUND_PULSES).max(1);
        let ms: f64 = delays.iter().filter(|(at, _)| *at == index).map(|(_, ms)| ms).sum();
        let after = spots.partition_point(|spot| spot.travelled <= vertex + BOUND_PULSES);
        if spots[tick - 1..=after.min(spots.len() - 1)].iter().any(|spot| spot.is_double) {
            continue;
        }
        // Rest at an instant within a tick: not further from it than its acceleration takes it.
        let around = &motions[spots[tick - 1].motion..=spots[after.min(spots.len() - 1)].motion];
        let braking = if course.disturbed { course.stop_dec } else { 0.0 };
        let most = around.iter().map(|motion| motion.acc).fold(braking, f64::max);
        let (came, went) = (vertex - spots[tick - 1].travelled, spots[after.min(spots.len() - 1)].travelled - vertex);
        // A tick that is within rounding of the place of rest counts as there.
        let within = tick_ms + (8.0 * BOUND_PULSES / most).sqrt();
        let room = most * within * within / 2.0 * (1.0 + 1e-6) + 2.0 * BOUND_PULSES;
        if came > room || went > room {
            let around = &spots[tick.saturating_sub(3)..(after + 3).min(spots.len())];
            return Err(format!(
                "it does not rest before motion {index} at {vertex}: {came} and {went} pulses in a tick at {most}: {around:?}"
            ));
        }
        let stood = (after - tick + 1) as f64 * tick_ms;
        if stood < ms - 1e-9 {
            return Err(format!("it rests for {stood} ms at most before motion {index}, not {ms}"));
        }
        *tally.entry("rests").or_default() += 1;
    }
    Ok(())
}

/// Outputs at their vertices.
fn edges(
    course: &Course,
    motions: &[Motion],
    spots: &[Spot],
    outputs: &[(usize, u8, bool)],
    reported: &Reported,
    tick_ms: f64,
    tally: &mut BTreeMap<&'static str, u64>,
) -> Result<(), String> {
    let mut levels = reported.more[0].general;
    let mut expected = Vec::new();
    for &(index, bit, level) in outputs {
        if (levels >> bit & 1 == 1) != level {
            levels ^= 1 << bit;
            expected.push((index, bit, level));
        }
    }
    // One that is taken back at its vertex is none.
    let mut kept: Vec<(usize, u8, bool)> = Vec::new();
    for edge in expected {
        match kept.iter().rposition(|last| last.1 == edge.1).filter(|at| kept[*at].0 == edge.0) {
            Some(at) => drop(kept.remove(at)),
            _ => kept.push(edge),
        }
    }
    let mut theirs: Vec<(i64, u8, bool)> = Vec::new();
    for edge in &reported.edges {
        match theirs.iter().rposition(|last| last.1 == edge.1).filter(|at| edge.0 - theirs[*at].0 < 2) {
            Some(at) => drop(theirs.remove(at)),
            _ => theirs.push(*edge),
        }
    }
    // Entries before and after a delay have one vertex and two instants.
    if course.abrupt || motions.iter().any(|motion| motion.waits) {
        return Ok(());
    }
    let order = |edges: &mut Vec<(usize, u8, bool)>| edges.sort_by_key(|edge| (edge.1, edge.0));
    order(&mut kept);
    theirs.sort_by_key(|edge| (edge.1, edge.0));
    if kept.len() != theirs.len() {
        return Err(format!("outputs change {theirs:?}, the path has {kept:?}"));
    }
    for (mine, edge) in kept.iter().zip(&theirs) {
        if (mine.1, mine.2) != (edge.1, edge.2) {
            return Err(format!("an output changes {edge:?}, the path has {mine:?}"));
        }
        let vertex = motions.get(mine.0).map_or_else(
            || motions.last().map_or(0.0, |last| last.begin + last.geometry.length()),
            |motion| motion.begin,
        );
        let at = edge.0 as f64 / 1e6 / tick_ms;
        let tick = (at.floor() as usize).min(spots.len() - 2);
        if spots[tick].is_double || spots[tick + 1].is_double {
            continue;
        }
        let (before, after) = (spots[tick].travelled, spots[tick + 1].travelled);
        let travelled = before + (after - before) * (at - tick as f64);
        // Between two ticks the path is off a straight one by its acceleration.
        let most = motions.iter().map(|motion| motion.acc).fold(course.stop_dec, f64::max);
        let speed = (after - before) / tick_ms;
        let room = most * tick_ms * tick_ms / 4.0 + 6e-6 * speed + 2.0 * BOUND_PULSES;
        let stood = |tick: usize| (spots[tick].travelled - vertex).abs() <= 2.0 * BOUND_PULSES;
        if (travelled - vertex).abs() > room && !(stood(tick) || stood(tick + 1)) {
            return Err(format!(
                "output {edge:?} changes {} pulses from its vertex, {room} at most",
                travelled - vertex
            ));
        }
        *tally.entry("outputs at vertices").or_default() += 1;
    }
    Ok(())
}

/// Random paths; how many, and what was tried.
pub fn run(first: u64, count: u64) -> BTreeMap<&'static str, u64> {
    let mut tally = BTreeMap::new();
    let axes = vec![(1, 1), (1, 2), (1, 3), (1, 6)];
    let setup = Setup { profile: "gus", axes, family: Family::Gus };
    let mut rigs: Vec<(u32, Option<Rig>)> = [250, 100, 1000, 500].map(|tick_us| (tick_us, None)).into();
    let mut reports = Vec::new();
    for seed in first..first + count {
        let (tick_us, rig) = &mut rigs[(seed % 4) as usize];
        let course = course(seed, &setup);
        let mine = rig.get_or_insert_with(|| Rig::new(setup.clone(), *tick_us));
        let reported = mine.run(&course.calls);
        if reported.is_err() {
            *rig = None;
        }
        let judged = reported.and_then(|reported| judge(&course, &reported, f64::from(*tick_us) / 1000.0, &mut tally));
        if let Err(reason) = judged {
            reports.push(format!(
                "path {seed}, tick {tick_us} µs: {reason}\n{}",
                setup.job(*tick_us, course.calls.iter())
            ));
            if reports.len() >= 5 {
                break;
            }
        }
    }
    assert!(reports.is_empty(), "{}", reports.join("\n"));
    tally
}
