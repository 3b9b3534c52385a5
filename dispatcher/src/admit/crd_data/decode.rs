//! A data command of a path, read from its bytes.
//!
//! In: a data command. Out: a [`DataCommand`]: a motion, an entry or a flush, and the FIFO it is
//! for.
//! Fails: with the parameter and the limit.
use crate::admit::context::Context;
use crate::admit::written::TakenValues;
use crate::admit::{crd, io, many, one};
use crate::configuration::ones;
use crate::plan::look_ahead::SPEED_MIN_PULSES_PER_MS;
use crate::refuse::{Admitted, Refused, bits_of, choice, real};
use protocol::command::{
    ArcXYC, ArcXYR, ArcYZC, ArcYZR, ArcZXC, ArcZXR, BufDA, BufDelay, BufDoBit, BufGear, BufIO, BufMove, CrdData,
    CrdPoint, LnXY, LnXYG0, LnXYZ, LnXYZA, Wire, opcode,
};
use protocol::reason::Reason;
use servo::path::{DIMENSIONS, PathEntry, Plane};
use servo::tick_command::MotionMode;
use servo::units::Axis;

/// The FIFO of a command; `fifo_field` is the index of `fifo` among the fields of its request.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    pub core: i16,
    pub crd: i16,
    pub fifo: i16,
    pub fifo_field: u8,
}

/// GivenSpeeds of a motion as they were given; `field` is the index of synVel, which synAcc and
/// velEnd follow.
#[derive(Debug, Clone, Copy)]
pub struct GivenSpeeds {
    pub vel: f64,
    pub acc: f64,
    pub end: f64,
    pub field: u8,
    /// The path stops at its end, also with look-ahead.
    pub stops: bool,
}

/// Path geometry of a motion as given. `field` is the index of the first parameter named.
#[derive(Debug, Clone, Copy)]
pub enum GivenGeometry {
    /// A line to the first `count` coordinates; `planar` keeps all digits of the speeds.
    Line { to: [i32; DIMENSIONS], count: usize, field: u8 },
    /// An arc by its radius (`field` + 2).
    Radius { plane: Plane, to: [i32; 2], radius: f64, dir: i16, field: u8 },
    /// An arc by its centre (`field` + 2 and 3), relative to its start.
    Centre { plane: Plane, to: [i32; 2], centre: [f64; 2], dir: i16, field: u8 },
}

/// What goes into the FIFO.
#[derive(Debug, Clone, Copy)]
pub enum FifoItem {
    /// A motion.
    Motion(GivenGeometry, GivenSpeeds),
    /// Any other entry.
    Entry(PathEntry, EntryKind),
    /// Nothing more follows for now: all of the look-ahead goes to the tick.
    Flush,
}

/// What an entry without a motion does, as far as its admission has to know.
#[derive(Debug, Clone, Copy)]
pub enum EntryKind {
    /// Sets outputs.
    Output,
    /// The path waits so many ms.
    Delay(f64),
    /// An axis sets off to a target.
    Move(Axis),
    /// An axis moves with the next motion, by so many pulses.
    Gear(Axis, u32),
    /// Changes a laser: the channel and follow table that it names, the values to report.
    Laser { named: Option<(u8, u8)>, took: Option<TakenValues> },
}

/// A data command.
pub type DataCommand = (Target, FifoItem);

/// The commands of one entry.
pub fn decode<const AXES: usize>(context: &Context<AXES>, number: u16, body: &[u8]) -> Admitted<DataCommand> {
    macro_rules! target {
        ($r:ident, $field:expr) => {
            Target { core: $r.core.get(), crd: $r.crd.get(), fifo: $r.fifo.get(), fifo_field: $field }
        };
    }
    macro_rules! speeds {
        ($r:ident, $field:literal) => {
            GivenSpeeds {
                vel: $r.syn_vel.get(),
                acc: $r.syn_acc.get(),
                end: $r.vel_end.get(),
                field: $field,
                stops: false,
            }
        };
    }
    macro_rules! line {
        ($name:ident, $field:literal, $($axis:ident),*) => {{
            let r = one::<$name>(body)?;
            let given = [$(r.$axis.get()),*];
            let mut to = [0; DIMENSIONS];
            to.iter_mut().zip(given).for_each(|(to, given)| *to = given);
            let shape = GivenGeometry::Line { to, count: given.len(), field: 2 };
            Ok((target!(r, $field + 3), FifoItem::Motion(shape, speeds!(r, $field))))
        }};
    }
    macro_rules! radius {
        ($name:ident, $plane:ident, $a:ident, $b:ident) => {{
            let r = one::<$name>(body)?;
            let (to, radius, dir) = ([r.$a.get(), r.$b.get()], r.radius.get(), r.circle_dir.get());
            let shape = GivenGeometry::Radius { plane: Plane::$plane, to, radius, dir, field: 2 };
            Ok((target!(r, 9), FifoItem::Motion(shape, speeds!(r, 6))))
        }};
    }
    macro_rules! centre {
        ($name:ident, $plane:ident, $a:ident, $b:ident, $ca:ident, $cb:ident) => {{
            let r = one::<$name>(body)?;
            let (to, centre) = ([r.$a.get(), r.$b.get()], [r.$ca.get(), r.$cb.get()]);
            let shape = GivenGeometry::Centre { plane: Plane::$plane, to, centre, dir: r.circle_dir.get(), field: 2 };
            Ok((target!(r, 10), FifoItem::Motion(shape, speeds!(r, 7))))
        }};
    }
    match number {
        opcode::LnXY => line!(LnXY, 4, x, y),
        opcode::LnXYZ => line!(LnXYZ, 5, x, y, z),
        opcode::LnXYZA => line!(LnXYZA, 6, x, y, z, a),
        opcode::LnXYG0 => {
            let r = one::<LnXYG0>(body)?;
            let shape = GivenGeometry::Line { to: [r.x.get(), r.y.get(), 0, 0], count: 2, field: 2 };
            let speeds = GivenSpeeds { vel: r.syn_vel.get(), acc: r.syn_acc.get(), end: 0.0, field: 4, stops: true };
            Ok((target!(r, 6), FifoItem::Motion(shape, speeds)))
        }
        opcode::ArcXYR => radius!(ArcXYR, Xy, x, y),
        opcode::ArcYZR => radius!(ArcYZR, Yz, y, z),
        opcode::ArcZXR => radius!(ArcZXR, Zx, z, x),
        opcode::ArcXYC => centre!(ArcXYC, Xy, x, y, x_center, y_center),
        opcode::ArcYZC => centre!(ArcYZC, Yz, y, z, y_center, z_center),
        opcode::ArcZXC => centre!(ArcZXC, Zx, z, x, z_center, x_center),
        opcode::CrdData => point(body),
        opcode::BufDelay => {
            let r = one::<BufDelay>(body)?;
            let ms = r.delay_ms.get();
            Ok((target!(r, 3), FifoItem::Entry(PathEntry::delay(ms), EntryKind::Delay(ms.into()))))
        }
        opcode::BufIO => {
            let r = one::<BufIO>(body)?;
            let (group, first, count) = context.output_group(r.core.get(), 2, selector(r.do_type.get()))?;
            let mask = bits_of(3, r.do_mask.get().into(), ones(count.min(16)))?;
            let value = u64::from(r.do_value.get()) & mask;
            let entry = PathEntry::output(group, mask << first, value << first);
            Ok((target!(r, 5), FifoItem::Entry(entry, EntryKind::Output)))
        }
        opcode::BufDoBit => {
            let r = one::<BufDoBit>(body)?;
            let output = (selector(r.do_type.get()), selector(r.index.get()), r.value.get());
            let (group, bit, high) = context.output_bit(r.core.get(), 2, output)?;
            let entry = PathEntry::output(group, 1 << bit, u64::from(high) << bit);
            Ok((target!(r, 5), FifoItem::Entry(entry, EntryKind::Output)))
        }
        opcode::BufDA => {
            let r = one::<BufDA>(body)?;
            let channel = io::analog(context, 2, r.channel.get())?;
            Ok((target!(r, 4), FifoItem::Entry(PathEntry::analog(channel, r.value.get()), EntryKind::Output)))
        }
        opcode::BufMove => {
            let r = one::<BufMove>(body)?;
            let axis = beside(context, r.core.get(), r.axis.get())?;
            let (vel, acc) = (r.vel.get(), r.acc.get());
            let limit = context.board.step_limit;
            let most = crd::CRD_SPEED_BOUND.min(limit.pulses_per_ms() as f64);
            real(4, vel, SPEED_MIN_PULSES_PER_MS, most)?;
            real(5, acc, SPEED_MIN_PULSES_PER_MS, crd::CRD_SPEED_BOUND)?;
            let modal = choice(6, r.modal.get(), 0, 1)? == 1;
            let entry = PathEntry::travel(axis, r.pos.get(), (vel.to_bits(), limit), acc.to_bits(), modal)
                .map_err(|_| Refused::range(4, vel, SPEED_MIN_PULSES_PER_MS, most))?;
            Ok((target!(r, 7), FifoItem::Entry(entry, EntryKind::Move(axis))))
        }
        _ => {
            let r = one::<BufGear>(body)?;
            let axis = beside(context, r.core.get(), r.axis.get())?;
            let kind = EntryKind::Gear(axis, r.pos.get().unsigned_abs());
            Ok((target!(r, 4), FifoItem::Entry(PathEntry::gear(axis, r.pos.get()), kind)))
        }
    }
}

/// A 16-bit unsigned selector, for checks that take a signed one.
fn selector(given: u16) -> i16 {
    i16::try_from(given).unwrap_or(i16::MAX)
}

/// An axis that no coordinate system drives, in Trap mode.
fn beside<const AXES: usize>(context: &Context<AXES>, core: i16, axis: i16) -> Admitted<Axis> {
    let axis = context.axis(core, axis).map_err(|refused| refused.field(2))?;
    let shadow = context.shadow(axis);
    if shadow.mode == MotionMode::Crd {
        return Err(context
            .no(Reason::AxisInCrd, axis)
            .field(2)
            .got(context.configuration.crd_number(shadow.crd).into()));
    }
    context.in_mode(axis, shadow.mode == MotionMode::Trap)?;
    Ok(axis)
}

/// CrdData: a flush without a point, else a motion as TCrdData gives it.
fn point(body: &[u8]) -> Admitted<DataCommand> {
    let items = body.len().saturating_sub(size_of::<CrdData>()) / size_of::<CrdPoint>();
    let (r, points) = many::<CrdData>(body, |_| items as u16)?;
    let target = Target { core: r.core.get(), crd: r.crd.get(), fifo: r.fifo.get(), fifo_field: 2 };
    let Some(point) = points.first().filter(|_| items == 1) else {
        if items > 1 {
            return Err(Refused::new(Reason::TooMany).got(items as f64).limits(0.0, 1.0));
        }
        return Ok((target, FifoItem::Flush));
    };
    // Fields of an item are counted after those of the request.
    const FIRST_ITEM_FIELD: u8 = CrdData::FIELDS.len() as u8;
    let stops = choice(FIRST_ITEM_FIELD + 9, point.vel_end_zero.get(), 0, 1)? == 1;
    let end = if stops { 0.0 } else { point.vel_end.get() };
    let speeds = GivenSpeeds { vel: point.vel.get(), acc: point.acc.get(), end, field: FIRST_ITEM_FIELD + 6, stops };
    let to = point.pos.map(|pos| pos.get());
    if choice(FIRST_ITEM_FIELD, point.motion_type.get(), 0, 1)? == 0 {
        return Ok((
            target,
            FifoItem::Motion(GivenGeometry::Line { to, count: DIMENSIONS, field: FIRST_ITEM_FIELD + 2 }, speeds),
        ));
    }
    let plane = match choice(FIRST_ITEM_FIELD + 1, point.plane.get(), 0, 2)? {
        0 => Plane::Xy,
        1 => Plane::Yz,
        _ => Plane::Zx,
    };
    let [i, j] = plane.coordinates();
    let (to, dir, centre) = ([to[i], to[j]], point.dir.get(), point.center.map(|part| part.get()));
    let shape = if centre == [0.0; 2] {
        GivenGeometry::Radius { plane, to, radius: point.radius.get(), dir, field: FIRST_ITEM_FIELD + 2 }
    } else {
        GivenGeometry::Centre { plane, to, centre, dir, field: FIRST_ITEM_FIELD + 2 }
    };
    Ok((target, FifoItem::Motion(shape, speeds)))
}
