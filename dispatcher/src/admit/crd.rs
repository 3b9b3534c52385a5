//! Coordinate systems: their parameters, start and stop, what is read of them. Data of paths is in `crd_data`.
use super::one;
use crate::books::{Change, CrdChange, Frame, Look, executed, place_of};
use crate::case::{Answer, Case, Query};
use crate::figure::Place;
use crate::path_queue::PathQueue;
use crate::refuse::{Admitted, Refused, choice, real, within};
use protocol::command::{
    CrdClear, CrdInfo, CrdSpace, CrdStart, CrdStatus, CrdStop, GetCrdLimit, GetCrdPos, GetCrdPrm, GetCrdVel,
    GetLaserFollowFilter, GetRemainderSegNum, InitLookAhead, SetCrdLimit, SetCrdPrm, SetCrdStopDec,
    SetLaserFollowFilter, SetOverride, opcode,
};
use protocol::reason::Reason;
use servo::crd;
use servo::laser::Lag;
use servo::op::{Mode, Op};
use servo::path::{DIMENSIONS, PathStores, Rate};
use servo::ramp::Accel;
use servo::units::{AxisMask, Crd, Pos};

/// Time constants of the filter of encoder speeds, ms; and 2⁶⁴.
const LAG_MS: (f64, f64) = (0.01, 1000.0);
const NS_64: f64 = 18_446_744_073_709_551_616.0;

/// Speeds, accelerations and times of a coordinate system are below this.
pub const MOST: f64 = 32767.0;
/// The lowest override and acceleration.
const LEAST: f64 = 1.0 / 1048576.0;

/// A number above 0 and below 32767.
fn between(field: u8, got: f64) -> Admitted<f64> {
    if !got.is_finite() {
        return Err(Refused::new(Reason::NotFinite).field(field).got(got));
    }
    if got > 0.0 && got < MOST {
        return Ok(got);
    }
    Err(Refused::new(Reason::Between).field(field).got(got).limits(0.0, MOST))
}

fn accel(field: u8, got: f64) -> Admitted<Accel> {
    Accel::admit(got.to_bits()).map_err(|_| Refused::new(Reason::OutOfRange).field(field).got(got).limits(LEAST, MOST))
}

/// Fields of SetCrdPrm behind core and crd.
mod field {
    pub const DIMENSION: u8 = 2;
    pub const PROFILE: u8 = 3;
    pub const VEL_MAX: u8 = 4;
    pub const ACC_MAX: u8 = 5;
    pub const EVEN_TIME: u8 = 6;
    pub const SET_ORIGIN: u8 = 7;
}

/// Every coordinate up to the dimension is driven by one axis; elements of `profile` for axes that the core does not
/// have must be 0.
fn frame<const AXES: usize>(case: &Case<AXES>, r: &SetCrdPrm) -> Admitted<Frame> {
    let dimension = within(field::DIMENSION, r.dimension.get(), 1, DIMENSIONS as i16)?;
    let axes = usize::from(case.site.profile.axes_per_core);
    let mut profile = [0; 8];
    for (index, (place, given)) in profile.iter_mut().zip(r.profile).enumerate() {
        let most = if index < axes { dimension } else { 0 };
        let coordinate = choice(field::PROFILE, given.get(), 0, most).map_err(|refused| refused.item(index))?;
        *place = coordinate as u8;
        let twice = coordinate != 0 && r.profile.iter().take(index).any(|before| before.get() == coordinate);
        if twice {
            let refused = Refused::new(Reason::CoordinateTwice).field(field::PROFILE).item(index);
            return Err(refused.got(coordinate.into()));
        }
    }
    for coordinate in 1..=dimension {
        if !profile.iter().any(|of| i16::from(*of) == coordinate) {
            let refused = Refused::new(Reason::CoordinateMissing).field(field::PROFILE);
            return Err(refused.got(coordinate.into()).limits(1.0, dimension.into()));
        }
    }
    let vel_max = between(field::VEL_MAX, r.syn_vel_max.get())?;
    let acc_max = between(field::ACC_MAX, r.syn_acc_max.get())?;
    real(field::VEL_MAX, vel_max, LEAST, MOST)?;
    real(field::ACC_MAX, acc_max, LEAST, MOST)?;
    let even_ms = within(field::EVEN_TIME, r.even_time_ms.get(), 0, i16::MAX - 1)?.unsigned_abs();
    let set_origin = choice(field::SET_ORIGIN, r.set_origin_flag.get(), 0, 1)? == 1;
    let first = case.core(r.core.get())? * axes;
    let origin = r.origin_pos.map(|pos| pos.get());
    Ok(Frame { dimension: dimension as u8, profile, first: first as u8, vel_max, acc_max, even_ms, set_origin, origin })
}

/// The axes are at rest and in no other coordinate system that drives them; they are in Crd mode from then on.
pub fn set<const AXES: usize>(case: &mut Case<AXES>, r: &SetCrdPrm) -> Admitted<Answer> {
    let crd = case.crd(r.core.get(), r.crd.get())?;
    let frame = frame(case, r)?;
    case.crd_at_rest(crd)?;
    let axes = frame.axes();
    for axis in axes.into_iter().flatten() {
        case.nth(axis.index())?;
        let book = case.book(axis);
        if book.mode == Mode::Crd && book.crd != crd && case.books.driven(book.crd).has(axis) {
            return Err(case.no(Reason::AxisInCrd, axis).got(case.site.crd_number(book.crd).into()));
        }
        case.at_rest(axis)?;
    }
    let mut origin = [0; DIMENSIONS];
    let mut here: Option<Place> = Some([0.0; DIMENSIONS]);
    for ((coordinate, axis), start) in axes.iter().enumerate().zip(&mut origin) {
        let Some(axis) = *axis else { continue };
        let number = axis.index() - usize::from(frame.first);
        *start = frame.origin.get(number).copied().unwrap_or(0);
        if frame.set_origin {
            let pos = case.book(axis).position(case.view, case.seen(axis));
            here = here.zip(pos).map(|(mut place, pos)| {
                let [at, ..] = place_of(&[Pos(pos.0.wrapping_sub(Pos::pulses(*start).0)); DIMENSIONS]);
                place.iter_mut().skip(coordinate).take(1).for_each(|place| *place = at);
                place
            });
        }
    }
    let admitted = crd::Frame::admit(axes, frame.set_origin.then_some(origin), frame.even_ms);
    let admitted = admitted.map_err(|refused| match refused {
        crd::Refused::NoAxis => Refused::new(Reason::CoordinateMissing).field(field::PROFILE).got(1.0),
        crd::Refused::Twice(axis) => case.no(Reason::CoordinateTwice, axis).field(field::PROFILE),
    })?;
    let dec = accel(field::ACC_MAX, frame.acc_max)?;
    let change = CrdChange::Frame { frame, here };
    case.stage_with(Op::CrdFrame { crd, frame: admitted }, Change::Crd { crd, change });
    case.stage(Op::CrdStopDec { crd, dec });
    Ok(Answer::Done)
}

/// The FIFO's number.
pub fn fifo(field: u8, fifo: i16) -> Admitted<u8> {
    Ok(choice(field, fifo, 0, 1)? as u8)
}

/// The coordinate system, if SetCrdPrm has been called for it.
fn known<const AXES: usize>(case: &Case<AXES>, core: i16, crd: i16) -> Admitted<Crd> {
    let crd = case.crd(core, crd)?;
    case.frame(crd)?;
    Ok(crd)
}

/// Where the coordinate system rests for what follows; none while only the tick knows.
///
/// Entries in flight that move nothing do not hide it: its axes are at rest, and where they are, less the zero, is its place.
pub fn place_at_rest<const AXES: usize>(case: &Case<AXES>, crd: Crd) -> Option<Place> {
    let (book, seen) = (case.crd_book(crd), case.crd_seen(crd));
    if let Some(here) = book.place_at_rest(case.view, seen) {
        return Some(here);
    }
    let frame = book.frame.as_ref().filter(|_| !book.is_busy(case.view, seen))?;
    let mut place = [0.0; DIMENSIONS];
    for ((axis, seen_zero), place) in frame.axes().into_iter().zip(seen.origin).zip(&mut place) {
        let Some(axis) = axis else { continue };
        let of = case.book(axis);
        let pos = of.position(case.view, case.seen(axis))?;
        let zero = if frame.set_origin {
            Pos::pulses(frame.origin.get(axis.index() - usize::from(frame.first)).copied().unwrap_or(0))
        } else if of.placed.is_none_or(|(seq, _)| executed(case.view, seq)) {
            // A SetCrdPrm before what made the place unknown has been executed, too.
            seen_zero
        } else {
            return None;
        };
        [*place, ..] = place_of(&[Pos(pos.0.wrapping_sub(zero.0)); DIMENSIONS]);
    }
    Some(place)
}

/// Both FIFOs are cleared at rest only.
pub fn clear<const AXES: usize>(case: &mut Case<AXES>, r: &CrdClear) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    case.crd_at_rest(crd)?;
    // Nothing moves by it.
    let here = place_at_rest(case, crd);
    case.stage_with(Op::CrdClear { crd, fifo }, Change::Crd { crd, change: CrdChange::Emptied { fifo, here } });
    Ok(Answer::Done)
}

/// Whether a coordinate system can start with a FIFO.
fn startable<const AXES: usize>(case: &Case<AXES>, crd: Crd, fifo: u8) -> Admitted<()> {
    let frame = case.frame(crd)?;
    case.crd_at_rest(crd)?;
    for axis in case.each(frame.mask()) {
        let book = case.book(axis);
        if book.mode != Mode::Crd || book.crd != crd {
            return Err(case.no(Reason::AxisLeftCrd, axis).got(case.site.crd_number(crd).into()));
        }
        case.at_rest(axis)?;
    }
    if !case.crd_book(crd).path(fifo).data.open {
        return Err(case.no_crd(Reason::CrdEmpty, crd).field(2).got(fifo.into()));
    }
    super::axis::all_startable(case, frame.mask())
}

/// Starts all coordinate systems of the mask on one tick, or none. Of what waits in a look-ahead the first of it goes
/// to the tick; the rest follows in time, or at the flush.
pub fn start<const AXES: usize>(
    case: &mut Case<AXES>,
    queues: &mut [[PathQueue; 2]],
    stores: PathStores<'_>,
    r: &CrdStart,
) -> Admitted<Answer> {
    let crds = case.crd_mask(r.core.get(), r.mask.get().into(), 1)?;
    if crds.0 == 0 {
        return Ok(Answer::Done);
    }
    // Option bits of others mean nothing.
    let fifo1 = case.crd_mask(r.core.get(), (r.option.get() & r.mask.get()).into(), 2)?;
    for crd in crds.crds() {
        startable(case, crd, fifo1.has(crd).into())?;
    }
    for crd in crds.crds() {
        let fifo = u8::from(fifo1.has(crd));
        let index = crd.index();
        if let (Some(queues), Some(stores)) = (queues.get_mut(index), stores.get(index)) {
            let queue = &mut queues[usize::from(fifo)];
            queue.follow(case.crd_book(crd).path(fifo).cleared);
            if queue.held() > 0 {
                queue.settle(&stores[usize::from(fifo)]);
                queue.begin(stores, case.crd_seen(crd), fifo);
                let (op, change) = super::data::commit_path(case.books, crd, fifo, queue.end());
                case.stage_with(op, change);
            }
        }
    }
    case.stage_with(Op::CrdStart { crds, fifo1 }, Change::CrdStarted { crds, fifo1 });
    Ok(Answer::Done)
}

/// Bits that the core does not have must be 0.
pub fn stop<const AXES: usize>(case: &mut Case<AXES>, r: &CrdStop) -> Admitted<Answer> {
    let crds = case.crd_mask(r.core.get(), r.mask.get(), 1)?;
    let abrupt = case.crd_mask(r.core.get(), r.option.get() & r.mask.get(), 2)?;
    if crds.0 != 0 {
        case.stage_with(Op::stop_crds(crds, abrupt), Change::Stopped { axes: AxisMask(0), crds });
    }
    Ok(Answer::Done)
}

/// An abrupt stop takes no time (SPEC 4), so its deceleration is kept, and has no effect.
pub fn stop_dec<const AXES: usize>(case: &mut Case<AXES>, r: &SetCrdStopDec) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let (smooth, abrupt) = (between(2, r.smooth.get())?, between(3, r.abrupt.get())?);
    let dec = accel(2, smooth)?;
    case.stage_with(Op::CrdStopDec { crd, dec }, Change::Crd { crd, change: CrdChange::Dec((smooth, abrupt)) });
    Ok(Answer::Done)
}

pub fn set_override<const AXES: usize>(case: &mut Case<AXES>, r: &SetOverride) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let ratio = real(2, r.ratio.get(), LEAST, 1.0)?;
    let rate = Rate::admit(ratio.to_bits())
        .map_err(|_| Refused::new(Reason::OutOfRange).field(2).got(ratio).limits(LEAST, 1.0))?;
    case.stage_with(Op::CrdRate { crd, rate }, Change::Crd { crd, change: CrdChange::Rate(ratio) });
    Ok(Answer::Done)
}

/// The filter of the encoder speed that lasers follow: 0 is none.
pub fn set_follow_filter<const AXES: usize>(case: &mut Case<AXES>, r: &SetLaserFollowFilter) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let ms = real(2, r.time_ms.get(), 0.0, LAG_MS.1)?;
    if ms != 0.0 && ms < LAG_MS.0 {
        return Err(Refused::new(Reason::OutOfRange).field(2).got(ms).limits(LAG_MS.0, LAG_MS.1));
    }
    let lag = if ms == 0.0 { Lag::NONE } else { Lag::of_inverse((NS_64 / (ms * 1e6)) as u64) };
    case.stage_with(Op::CrdLag { crd, lag }, Change::Crd { crd, change: CrdChange::Lag(ms) });
    Ok(Answer::Done)
}

/// `count` 0 switches the look-ahead off; more than the board holds are taken as that many. The FIFO is empty, or all
/// of it has run.
pub fn look_ahead<const AXES: usize>(case: &mut Case<AXES>, r: &InitLookAhead) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    let count = within(5, r.count.get(), 0, i16::MAX - 1)?.unsigned_abs();
    let look = if count == 0 {
        None
    } else {
        let corner = real(3, r.time_ms.get(), 0.0, MOST)?;
        Some(Look { corner, acc: between(4, r.acc_max.get())?, count })
    };
    if case.crd_book(crd).path(fifo).data.open {
        return Err(case.no_crd(Reason::CrdHolds, crd).field(2).got(fifo.into()));
    }
    case.stage_with(Op::Mark, Change::Crd { crd, change: CrdChange::Look { fifo, look } });
    Ok(Answer::Done)
}

/// Limits of one coordinate for look-ahead; 0 takes the limit away. They hold for motions given from now on to a
/// look-ahead that is empty.
pub fn limit<const AXES: usize>(case: &mut Case<AXES>, r: &SetCrdLimit) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let dimension = i16::from(case.frame(crd)?.dimension);
    let coordinate = choice(2, r.coordinate.get(), 1, dimension)? as u8 - 1;
    let number = |field, got: f64| if got == 0.0 { Ok(0.0) } else { between(field, got) };
    let limit = (number(3, r.vel_max.get())?, number(4, r.acc_max.get())?);
    case.stage_with(Op::Mark, Change::Crd { crd, change: CrdChange::Limit { coordinate, limit } });
    Ok(Answer::Done)
}

fn query(opcode: u16, crd: Crd, which: u8) -> Answer {
    Answer::Read(Query { opcode, first: crd.index() as u8, count: 1, which })
}

/// At rest the books alone say it; while it runs the tick does.
pub fn space<const AXES: usize>(case: &mut Case<AXES>, r: &CrdSpace) -> Admitted<Answer> {
    let crd = known(case, r.core.get(), r.crd.get())?;
    let fifo = fifo(2, r.fifo.get())?;
    if case.crd_may_run(crd) {
        return Ok(query(opcode::CrdSpace, crd, fifo));
    }
    Ok(Answer::Long(case.crd_book(crd).space_ahead(case.crd_seen(crd), fifo).cast_signed()))
}

/// Reads that need no more than a coordinate system and a FIFO.
pub fn read<const AXES: usize>(case: &mut Case<AXES>, number: u16, body: &[u8]) -> Admitted<Answer> {
    let (core, crd, which) = match number {
        opcode::GetCrdPrm => one::<GetCrdPrm>(body).map(|r| (r.core, r.crd, 0))?,
        opcode::GetCrdPos => one::<GetCrdPos>(body).map(|r| (r.core, r.crd, 0))?,
        opcode::GetCrdVel => one::<GetCrdVel>(body).map(|r| (r.core, r.crd, 0))?,
        opcode::CrdInfo => one::<CrdInfo>(body).map(|r| (r.core, r.crd, 0))?,
        opcode::GetLaserFollowFilter => one::<GetLaserFollowFilter>(body).map(|r| (r.core, r.crd, 0))?,
        opcode::CrdStatus => one::<CrdStatus>(body).and_then(|r| Ok((r.core, r.crd, fifo(2, r.fifo.get())?)))?,
        opcode::GetRemainderSegNum => {
            one::<GetRemainderSegNum>(body).and_then(|r| Ok((r.core, r.crd, fifo(2, r.fifo.get())?)))?
        }
        _ => {
            let r = one::<GetCrdLimit>(body)?;
            let crd = known(case, r.core.get(), r.crd.get())?;
            let dimension = i16::from(case.frame(crd)?.dimension);
            let coordinate = choice(2, r.coordinate.get(), 1, dimension)? as u8 - 1;
            return Ok(query(number, crd, coordinate));
        }
    };
    Ok(query(number, known(case, core.get(), crd.get())?, which))
}
