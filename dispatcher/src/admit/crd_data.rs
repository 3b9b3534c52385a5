//! Data of the FIFOs of coordinate systems: motions, and entries between them.
//!
//! In: a data command. Out: entries in the look-ahead or the store, and the FIFO's new shadow
//! state.
//! Fails: with the parameter and the limit, and then nothing has changed: all is checked before the
//! first entry is stored.
//!
//! Every command becomes a [`DataCommand`]; [`put`] does the rest. A command of another chapter
//! that goes into a FIFO (a buffered laser change) makes a `DataCommand` of its own, with
//! [`FifoItem::PathEntry`].
mod decode;

use super::context::Context;
use super::many;
use super::written::{Paths, Stored, Written};
use crate::configuration::Configuration;
use crate::plan::geometry;
use crate::plan::geometry::{Geometry, OFF_CENTRE_MAX_PULSES, Position, RADIUS_MAX_PULSES, RADIUS_MIN_PULSES};
use crate::plan::look_ahead::{Limits, SPEED_MIN_PULSES_PER_MS, rounded_down};
use crate::plan::path_queue::{Destination, PathQueue, Queued};
use crate::refuse::{Admitted, FifoOf, Refused, choice, real};
use crate::report::answer::Answer;
use crate::shadow::{CAPACITY, CrdChange, CrdParameters, CrdShadow, PathData, PathShadow, ShadowChange};
pub use decode::{DataCommand, EntryKind, FifoItem, Target};
use decode::{GivenGeometry, GivenSpeeds, decode};
use protocol::command::{LnXYMany, LnXYZMany, opcode};
use protocol::reason::Reason;
use servo::path::{DIMENSIONS, EntryStore, GEARS, MotionSpeeds, PathEntry, Plane};
use servo::units::{Axis, Crd};
use servo::view::CrdView;

/// The speeds of a motion after limitation.
#[derive(Debug, Clone, Copy)]
struct LimitedSpeeds {
    vel: f64,
    acc: f64,
    end: f64,
    along: MotionSpeeds,
}

/// Whether a share of a speed is above a limit. The rounding of doubles is tolerated, unless the
/// share is 1.
fn is_faster(vel: f64, share: f64, limit: f64) -> bool {
    const ROUNDING_SHARE: f64 = 4.0 * f64::EPSILON;
    if share == 1.0 { vel > limit } else { vel * share > limit * (1.0 + ROUNDING_SHARE) }
}

/// A FIFO that is being filled.
struct CrdFifoWrite<'x> {
    crd: Crd,
    fifo: u8,
    number: i16,
    shadow: &'x CrdShadow,
    sampled: &'x CrdView,
    frame: &'x CrdParameters,
    path: &'x PathShadow,
    /// Where the next motion begins; NaN for a coordinate that only the tick knows.
    begin: Position,
    space: u32,
    /// The path may run, and has a look-ahead: what leaves that goes to the tick at once.
    at_once: bool,
    field: u8,
    configuration: &'x Configuration,
    /// The step limit of the board, pulse/ms.
    limit: f64,
}

/// The FIFO, if its content is known and its slots are free.
fn open<'x, const AXES: usize>(context: &Context<'x, AXES>, target: &Target) -> Admitted<CrdFifoWrite<'x>> {
    let crd = context.crd(target.core, target.crd)?;
    let frame = context.frame(crd)?;
    let fifo = super::crd::fifo(target.fifo_field, target.fifo)?;
    let (shadow, sampled) = (context.crd_shadow(crd), context.crd_sampled(crd));
    let path = shadow.path(fifo);
    let in_use = || context.no_crd(Reason::CrdFifoInUse, crd).field(target.fifo_field).got(fifo.into());
    let pending = |seq: Option<u32>| seq.is_some_and(|seq| !crate::shadow::executed(context.view, seq));
    // The slots of entries that are over in the program are free only when the tick has released
    // them.
    if path.is_outgoing(context.view, sampled) {
        return Err(in_use());
    }
    let at_once = path.look.is_some() && context.crd_may_run(crd);
    // The look-ahead of a running path plans no further than the host's data.
    if at_once && !context.due.follows && (!context.due.soon || path.loose || pending(path.last)) {
        return Err(in_use());
    }
    let space = shadow.space(sampled, fifo);
    let mut begin =
        shadow.begin(|| super::crd::position_at_standstill(context, crd), fifo).unwrap_or([f64::NAN; DIMENSIONS]);
    // A coordinate that no axis drives stays 0, whatever is known of the others.
    begin.iter_mut().skip(frame.dimension.into()).for_each(|at| *at = 0.0);
    let number = context.configuration.crd_number(crd);
    let limit = context.board.step_limit.pulses_per_ms() as f64;
    let (configuration, field) = (context.configuration, target.fifo_field);
    Ok(CrdFifoWrite {
        crd,
        fifo,
        number,
        shadow,
        sampled,
        frame,
        path,
        begin,
        space,
        at_once,
        field,
        configuration,
        limit,
    })
}

impl CrdFifoWrite<'_> {
    fn no(&self, reason: Reason) -> Refused {
        Refused::new(reason).axis(self.number)
    }

    /// Its look-ahead, and both FIFOs of its coordinate system.
    fn memory<'p>(&self, (queues, stores): Paths<'p>) -> Admitted<(&'p mut PathQueue, &'p [EntryStore; 2])> {
        let index = self.crd.index();
        let (queues, stores) =
            queues.get_mut(index).zip(stores.get(index)).ok_or_else(|| self.no(Reason::CrdNotOnBoard))?;
        Ok((&mut queues[usize::from(self.fifo & 1)], stores))
    }

    /// Whether so many entries fit.
    fn has_room(&self, count: usize) -> Admitted<()> {
        if count as u64 <= u64::from(self.space) {
            return Ok(());
        }
        let full = self.no(Reason::CrdFull).full(FifoOf::Crd(self.crd), self.fifo);
        Err(full.field(self.field).got(self.space.into()).limits(0.0, CAPACITY.into()))
    }

    /// Refuses for now a motion that needs these coordinates of its start. With look-ahead every
    /// motion needs all.
    fn needs(&self, coordinates: impl IntoIterator<Item = usize>) -> Admitted<()> {
        let dimension = usize::from(self.frame.dimension);
        let unknown = |index: usize| index < dimension && self.begin.get(index).is_some_and(|at| at.is_nan());
        let ahead = self.path.look.is_some() && (0..DIMENSIONS).any(unknown);
        if ahead || coordinates.into_iter().any(unknown) { Err(self.no(Reason::CrdPositionUnknown)) } else { Ok(()) }
    }

    /// A coordinate that no axis drives stays 0.
    fn driven(&self, coordinate: usize, to: i32, field: u8) -> Admitted<()> {
        if to == 0 || coordinate < usize::from(self.frame.dimension) {
            return Ok(());
        }
        Err(self.no(Reason::NoCoordinate).field(field).got(to.into()))
    }

    /// Coordinates that no axis drives, a bit each: they are always known.
    fn undriven(&self) -> u8 {
        0b1111 << self.frame.dimension & 0b1111
    }

    /// Speed, acceleration and end speed after limitation to the maxima.
    fn speeds(&self, given: &GivenSpeeds) -> Admitted<LimitedSpeeds> {
        let GivenSpeeds { vel, acc, end, field, .. } = *given;
        let (vel_max, acc_max) = (self.frame.vel_max, self.frame.acc_max);
        real(field, vel, SPEED_MIN_PULSES_PER_MS, f64::MAX)?;
        real(field + 1, acc, SPEED_MIN_PULSES_PER_MS, f64::MAX)?;
        real(field + 2, end, 0.0, f64::MAX)?;
        let (vel, acc) = (vel.min(vel_max), acc.min(acc_max));
        let end = end.min(vel);
        let along = MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits())
            .map_err(|_| Refused::range(field, vel, SPEED_MIN_PULSES_PER_MS, vel_max))?;
        Ok(LimitedSpeeds { vel, acc, end, along })
    }

    /// The motion from where the FIFO ends.
    fn geometry(&self, shape: &GivenGeometry) -> Admitted<Geometry> {
        let begin = self.begin;
        let ccw = |dir: i16, field: u8| Ok(choice(field, dir, 0, 1)? == 1);
        let plane_of = |plane: Plane, to: [i32; 2], field: u8| {
            // What can never be right is refused at once, whether the start is known or not.
            for ((coordinate, to), field) in plane.coordinates().into_iter().zip(to).zip(field..) {
                self.driven(coordinate, to, field)?;
                if coordinate >= usize::from(self.frame.dimension) {
                    return Err(self.no(Reason::NoCoordinate).field(field).got(to.into()));
                }
            }
            self.needs(plane.coordinates())
        };
        let (geometry, field) = match *shape {
            GivenGeometry::Line { to, count, field } => {
                for ((coordinate, to), field) in to.iter().enumerate().zip(field..) {
                    self.driven(coordinate, *to, if count == DIMENSIONS { field } else { field.min(count as u8 + 1) })?;
                }
                self.needs(if count == 2 { DIMENSIONS } else { count }..DIMENSIONS)?;
                if count == 2 {
                    let [x, y, ..] = to;
                    (Geometry::planar(&begin, [x, y]), field)
                } else {
                    // Coordinates after the named ones stay.
                    let mut target = to;
                    let rest = target.iter_mut().zip(begin).enumerate().skip(count);
                    for (_, (to, begin)) in rest {
                        *to = begin as i32;
                    }
                    (Geometry::line(&begin, target), field)
                }
            }
            GivenGeometry::Radius { plane, to, radius, dir, field } => {
                plane_of(plane, to, field)?;
                (Geometry::arc_radius(&begin, plane, to, radius, ccw(dir, field + 3)?), field)
            }
            GivenGeometry::Centre { plane, to, centre, dir, field } => {
                plane_of(plane, to, field)?;
                (Geometry::arc_centre(&begin, plane, to, centre, ccw(dir, field + 4)?), field)
            }
        };
        geometry.map_err(|refused| explain(refused, shape, field))
    }

    /// Refuses a motion in which an axis would exceed the step limit, at the speed given or at that
    /// with which the motion before may end. `data` is what precedes it.
    fn in_steps(
        &self,
        queue: &PathQueue,
        geometry: &Geometry,
        (vel, field): (f64, u8),
        data: &PathData,
    ) -> Admitted<()> {
        let peak = vel.max(self.enters(data));
        // No coordinate has more than the whole speed.
        if peak <= self.limit && data.gears.0 == 0 {
            return Ok(());
        }
        if geometry.length.is_nan() {
            // Waits until the position is known, unless that changes nothing.
            if peak.max(peak * f64::from(data.gear)) <= self.limit {
                return Ok(());
            }
            self.needs(0..DIMENSIONS)?;
        }
        let peak = match self.path.look {
            Some(look) => queue.limits(self.path.cleared, self.limits(look.corner, look.acc)).speed(geometry, peak),
            None => peak,
        };
        let refuse = |axis: Axis, share: f64| {
            if !is_faster(peak, share, self.limit) {
                return Ok(());
            }
            let refused = Refused::new(Reason::StepLimit).field(field).axis(self.configuration.number_of(axis));
            Err(refused.got(peak * share).limits(0.0, self.limit))
        };
        for (coordinate, axis) in self.frame.axes().into_iter().enumerate() {
            if let Some(axis) = axis {
                refuse(axis, geometry.share(coordinate))?;
            }
        }
        if data.gears.0 == 0 { Ok(()) } else { refuse(data.geared, f64::from(data.gear) / geometry.length) }
    }

    /// Highest speed of the path where the next motion begins.
    fn enters(&self, data: &PathData) -> f64 {
        if data.is_open() && self.path.look.is_none() { data.leaves.into() } else { 0.0 }
    }

    /// Highest speed at the end of a motion of this length: velEnd, or what braking leaves. If
    /// velEnd is above the step limit, only the speed that it can reach.
    fn leaves(&self, data: &PathData, length: f64, acc: f64, end: f64) -> f32 {
        let enters = self.enters(data);
        if self.path.look.is_some() || enters <= end && end <= self.limit {
            return rounded_down(end);
        }
        let (square, change) = (enters * enters, 2.0 * acc * length);
        rounded_down(end.max(libm::sqrt((square - change).max(0.0))).min(libm::sqrt(square + change)))
    }

    fn limits(&self, corner: f64, acc: f64) -> Limits {
        let of = |own: f64, else_: f64| if own > 0.0 { own } else { else_ };
        Limits {
            vel: self.shadow.limits.map(|(vel, _)| of(vel, f64::INFINITY)),
            acc: self.shadow.limits.map(|(_, own)| of(own, acc)),
            corner,
        }
    }

    /// A motion that has been checked, for the queue. One without look-ahead that has no entry of
    /// its own is left out.
    fn motion(&self, geometry: Geometry, stops: bool, speeds: LimitedSpeeds, data: &mut PathData) -> Option<Queued> {
        let LimitedSpeeds { vel, acc, end, along } = speeds;
        let short = is_too_short_to_brake(self.enters(data), acc, geometry.length);
        data.leaves = self.leaves(data, geometry.length, acc, end);
        data.add_motion(geometry.end, geometry.sets() | self.undriven());
        if short {
            data.set_end_too_short();
        }
        if self.path.look.is_some() {
            return Some(Queued::Motion { geometry, vel, acc, stops });
        }
        geometry.entry(along).map(|entry| Queued::Entry(entry, geometry.length / vel))
    }

    /// Gives the queue what was checked. Returns how long the tick's data lasts, ms.
    fn give(
        &self,
        (queue, stores): (&mut PathQueue, &[EntryStore; 2]),
        queued: impl IntoIterator<Item = Queued>,
    ) -> f64 {
        let CrdFifoWrite { sampled, fifo, path: PathShadow { cleared, .. }, .. } = *self;
        let look = self.path.look.map(|look| (self.limits(look.corner, look.acc), look.count));
        queue.put(&Destination { cleared: *cleared, look, stores, sampled, fifo }, queued)
    }

    fn written(&self, count: usize, lasts: f64, data: PathData) -> (Written, ShadowChange) {
        let (crd, fifo) = (self.crd, self.fifo);
        let answer = Answer::Path { crd, fifo, count: count as u16, lasts_ms: lasts as u32 };
        let written = Written { at_once: self.at_once, ..Written::new(FifoOf::Crd(crd), fifo, answer) };
        (written, ShadowChange::Crd { crd, change: CrdChange::Data { fifo, cleared: self.path.cleared, data } })
    }
}

/// Whether a motion entered at this speed is too short to brake in.
fn is_too_short_to_brake(enters: f64, acc: f64, length: f64) -> bool {
    enters * enters > 2.0 * acc * length
}

#[cold]
fn explain(refused: geometry::Refused, shape: &GivenGeometry, field: u8) -> Refused {
    let (radius, centre) = match *shape {
        GivenGeometry::Radius { radius, .. } => (radius, [0.0; 2]),
        GivenGeometry::Centre { centre, .. } => (libm::hypot(centre[0], centre[1]), centre),
        GivenGeometry::Line { .. } => (0.0, [0.0; 2]),
    };
    let (reason, got, low, high) = match refused {
        geometry::Refused::NotFinite => {
            let second = centre[0].is_finite() && !centre[1].is_finite();
            return Refused::new(Reason::NotFinite).field(field + 2 + u8::from(second)).got(radius);
        }
        geometry::Refused::NoLength => return Refused::new(Reason::NoLength).field(field),
        geometry::Refused::RadiusTooSmall { least } => (Reason::RadiusTooSmall, radius, least, RADIUS_MAX_PULSES),
        geometry::Refused::CentreOff { by } => (Reason::CentreOff, by, 0.0, OFF_CENTRE_MAX_PULSES),
        geometry::Refused::CentreOnStart => (Reason::CentreOnStart, radius, RADIUS_MIN_PULSES, RADIUS_MAX_PULSES),
        geometry::Refused::RadiusTooLarge => (Reason::RadiusTooLarge, radius, 0.0, RADIUS_MAX_PULSES),
    };
    Refused::new(reason).field(field + 2).got(got).limits(low, high)
}

/// Admits a data command of a path.
pub fn data<const AXES: usize>(context: &Context<AXES>, paths: Paths, number: u16, body: &[u8]) -> Stored {
    match number {
        opcode::LnXYMany => lines::<LnXYMany, 2, AXES>(context, paths, body),
        opcode::LnXYZMany => lines::<LnXYZMany, 3, AXES>(context, paths, body),
        _ => put(context, paths, &decode(context, number, body)?),
    }
}

/// Puts one item into a FIFO, in the order of the calls, through the look-ahead if there is one.
pub fn put<const AXES: usize>(context: &Context<AXES>, paths: Paths, (target, what): &DataCommand) -> Stored {
    let filling = open(context, target)?;
    let (queue, stores) = filling.memory(paths)?;
    let mut data = filling.path.data;
    let (queued, count) = match what {
        FifoItem::Motion(shape, given) => {
            let speeds = filling.speeds(given)?;
            let geometry = filling.geometry(shape)?;
            filling.in_steps(queue, &geometry, (speeds.vel, given.field), &data)?;
            filling.has_room(1)?;
            (filling.motion(geometry, given.stops, speeds, &mut data), 1)
        }
        FifoItem::Entry(entry, kind) => {
            if let EntryKind::Gear(axis, pulses) = *kind {
                if data.gears.has(axis) {
                    return Err(context.no(Reason::AxisGoesAlong, axis));
                }
                if data.gears.0.count_ones() >= GEARS as u32 {
                    return Err(filling.no(Reason::GearsFull).limits(0.0, GEARS as f64));
                }
                data.gears.0 |= axis.mask().0;
                if pulses > data.gear {
                    (data.geared, data.gear) = (axis, pulses);
                }
            }
            if let EntryKind::Gear(axis, _) | EntryKind::Move(axis) = *kind {
                data.extra_axes.0 |= axis.mask().0;
            }
            let ms = if let EntryKind::Delay(ms) = *kind { ms } else { 0.0 };
            filling.has_room(1)?;
            data.add_entry(filling.begin, entry.is_wait());
            (Some(Queued::Entry(*entry, ms)), 1)
        }
        FifoItem::Flush => (Some(Queued::Flush), 0),
    };
    let lasts = filling.give((queue, stores), queued);
    let (mut written, change) = filling.written(count, lasts, data);
    if let FifoItem::Entry(_, EntryKind::Laser { named, took }) = *what {
        written.named = named;
        if let Some((took, count, limited)) = took {
            (written.took, written.answer) = (took, Answer::Took { count, limited });
        }
    }
    Ok((written, change))
}

/// LnXYMany and LnXYZMany: all lines or none.
fn lines<R: Lines<N>, const N: usize, const AXES: usize>(context: &Context<AXES>, paths: Paths, body: &[u8]) -> Stored {
    let (r, items) = many::<R>(body, |r| r.head().1)?;
    let (target, _, speeds) = r.head();
    let filling = open(context, &target)?;
    let (queue, stores) = filling.memory(paths)?;
    let admitted = filling.speeds(&speeds)?;
    // The first one that does not fit.
    filling.has_room(items.len()).map_err(|refused| refused.item(filling.space as usize))?;
    let fields = R::FIELDS.len() as u8;
    filling.needs(if N == 2 { DIMENSIONS } else { N }..DIMENSIONS)?;
    let (mut before, mut ends) = (filling.begin, filling.path.data);
    if !ends.is_open() {
        ends.leaves = 0.0;
    }
    let mut short = false;
    let (leaves, looks) = (rounded_down(admitted.end), filling.path.look.is_some());
    let is_slow = admitted.vel <= filling.limit && admitted.end <= filling.limit;
    for (index, item) in items.iter().enumerate() {
        let to = R::to(item);
        for ((coordinate, to), field) in to.iter().enumerate().zip(fields..) {
            filling.driven(coordinate, *to, field).map_err(|refused| refused.item(index))?;
        }
        let to = to.map(f64::from);
        if before.iter().zip(&to).all(|(before, to)| before == to) {
            return Err(Refused::new(Reason::NoLength).field(fields).item(index));
        }
        let begin = before;
        before.iter_mut().zip(to).for_each(|(before, to)| *before = to);
        if index + 1 == items.len() && !looks {
            let square = begin.iter().zip(before).fold(0.0, |sum, (from, to)| sum + (to - from) * (to - from));
            short = is_too_short_to_brake(ends.leaves.into(), admitted.acc, libm::sqrt(square));
        }
        // Most lines are known to be slow enough without their length.
        if is_slow && ends.gears.0 == 0 && (looks || ends.leaves <= leaves) {
            ends.leaves = leaves;
            continue;
        }
        let mut geometry = Geometry::line(&begin, before.map(|position| position as i32));
        if let Ok(geometry) = &mut geometry {
            filling
                .in_steps(queue, geometry, (admitted.vel, speeds.field), &ends)
                .map_err(|refused| refused.item(index))?;
            ends.leaves = filling.leaves(&ends, geometry.length, admitted.acc, admitted.end);
            (ends.gears.0, ends.gear) = (0, 0);
        }
    }
    let mut data = filling.path.data;
    let mut at = filling.begin;
    let sets = filling.undriven() | if N == 2 { 0b11 } else { 0b1111 };
    let queued = items.iter().filter_map(|item| {
        let to = R::to(item);
        let mut target = at.map(|position| position as i32);
        target.iter_mut().zip(to).for_each(|(target, to)| *target = to);
        let [x, y, ..] = target;
        if filling.path.look.is_none() {
            // Nobody reads its directions.
            let LimitedSpeeds { vel, along, .. } = admitted;
            let entry = if N == 2 { PathEntry::planar([x, y], along) } else { PathEntry::line(target, along) };
            let shape = at.iter().zip(target).take(N).fold(0.0f32, |sum, (at, to)| {
                let part = (f64::from(to) - at) as f32;
                sum + part * part
            });
            at.iter_mut().zip(to).for_each(|(at, to)| *at = to.into());
            data.add_motion(at, sets);
            return Some(Queued::Entry(entry, f64::from(libm::sqrtf(shape) / vel as f32)));
        }
        // It has a length: that was checked above.
        let geometry = if N == 2 { Geometry::planar(&at, [x, y]) } else { Geometry::line(&at, target) }.ok()?;
        at = geometry.end;
        filling.motion(geometry, false, admitted, &mut data)
    });
    let lasts = filling.give((queue, stores), queued);
    data.leaves = ends.leaves;
    if short {
        data.set_end_too_short();
    }
    Ok(filling.written(items.len(), lasts, data))
}

/// A command with many lines of common speeds.
trait Lines<const N: usize>: protocol::command::Request {
    /// Its FIFO, the number of its items, their speeds.
    fn head(&self) -> (Target, u16, GivenSpeeds);
    /// A target.
    fn to(item: &Self::Item) -> [i32; N];
}

macro_rules! many_lines {
    ($name:ident, $n:literal, $($axis:ident),*) => {
        impl Lines<$n> for $name {
            fn head(&self) -> (Target, u16, GivenSpeeds) {
                let (core, crd, fifo) = (self.core.get(), self.crd.get(), self.fifo.get());
                let (vel, acc, end) = (self.syn_vel.get(), self.syn_acc.get(), self.vel_end.get());
                let target = Target { core, crd, fifo, fifo_field: 2 };
                (target, self.count.get(), GivenSpeeds { vel, acc, end, field: 4, stops: false })
            }
            fn to(item: &Self::Item) -> [i32; $n] {
                [$(item.$axis.get()),*]
            }
        }
    };
}
many_lines!(LnXYMany, 2, x, y);
many_lines!(LnXYZMany, 3, x, y, z);
