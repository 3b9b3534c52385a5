//! Tables of laser channels: powers against velocity, ratios against position.
//!
//! In: chunks of points, each a record of its own; `first` is the index of the chunk's first item.
//! Out: points in the tables' memory, and with the last one the staged tick command that publishes
//! them. Owns: the table that is being sent; a chunk with `first` 0 begins a new one.
//! Fails: as the points do, each named. Nothing of a table is visible before its last chunk. A
//! chunk that is sent again, because it was refused too early, is refused in the same way.
//!
//! Powers wait in scratch memory, since their table may still hold an earlier call's. Ratios go
//! straight into the bank that nothing reads (`servo::laser::PowerTables`).
use super::distance::{ratio, running, stage};
use super::energy::{power, powers};
use super::power_range::{Range, RangeLimiter};
use super::{Context, answer_taken};
use crate::admit::length;
use crate::admit::upload::Upload;
use crate::refuse::{Admitted, Refused, choice, real, within};
use crate::report::answer::Answer;
use crate::shadow::{CAPACITY, DistanceShadow, LaserChange, Shadows};
use protocol::command::{Request, SetLaserDisTable1D, SetLaserDisTable2D, SetLaserFollowTable, opcode};
use protocol::reason::Reason;
use protocol::values::FULL_SCALE;
use servo::laser::{Curve, DISTANCES, NODES, POINTS, POWER_TABLES, Power, PowerTables, Ratios};
use servo::tick_command::TickCommand;
use servo::units::Crd;
use zerocopy::FromBytes;

/// Highest velocity: 2³² pulse/ms.
const SPEED_MAX_PULSES_PER_MS: f64 = FULL_SCALE;
/// Bytes of the longest head.
const HEAD_BYTES: usize = size_of::<SetLaserDisTable1D>();
const _: () = assert!(size_of::<SetLaserDisTable2D>() <= HEAD_BYTES && size_of::<SetLaserFollowTable>() <= HEAD_BYTES);

/// What the chunks of one table have in common: all of the head but `first`, which comes last.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TableKey {
    opcode: u16,
    head: [u8; HEAD_BYTES],
}

impl TableKey {
    fn of<R: Request>(request: &R) -> TableKey {
        let mut head = [0; HEAD_BYTES];
        let bytes = request.as_bytes();
        let kept = bytes.len().saturating_sub(size_of::<u16>());
        for (to, byte) in head.iter_mut().zip(bytes.iter().take(kept)) {
            *to = *byte;
        }
        TableKey { opcode: R::OPCODE, head }
    }
}

/// The table that is being sent; see the module text.
pub struct TableUpload {
    /// The bank of the table that is being sent.
    state: Upload<TableKey, u8>,
    /// Velocity and power.
    points: [(f64, Power); POINTS],
    /// The position before, for the order of the next one.
    last: i32,
}

/// The answer to a chunk; laser channel and follow table that are complete with it.
type Loaded = Admitted<(Answer, Option<(u8, u8)>)>;

/// A chunk being admitted: its items, the index of the first, and how many items the table has.
struct TableChunk<'b, T> {
    key: TableKey,
    first: u16,
    items: &'b [T],
    total: usize,
    /// Field of `first`.
    field: u8,
}

impl<T> TableChunk<'_, T> {
    fn begin(&self) -> (TableKey, u16) {
        (self.key, self.first)
    }
    fn is_last(&self) -> bool {
        usize::from(self.first) + self.items.len() == self.total
    }

    /// The items with their index in the table.
    fn indexed(&self) -> impl Iterator<Item = (usize, &T)> {
        self.items.iter().enumerate().map(|(index, item)| (usize::from(self.first) + index, item))
    }
}

/// The items after a head: at least one, and no more than the table still needs.
fn chunk<'b, R: Request>(
    r: &R,
    rest: &'b [u8],
    first: u16,
    total: usize,
    field: u8,
) -> Admitted<TableChunk<'b, R::Item>> {
    let (head, item) = (size_of::<R>(), size_of::<R::Item>());
    let count = rest.len() / item;
    let wanted = count.clamp(1, total.saturating_sub(first.into()).max(1));
    match <[R::Item]>::ref_from_bytes(rest) {
        Ok(items) if count == wanted => Ok(TableChunk { key: TableKey::of(r), first, items, total, field }),
        _ => Err(length(head + rest.len(), head + wanted * item)),
    }
}

/// Head and items of a chunk; the items are whole.
fn split<R: Request>(body: &[u8]) -> Admitted<(R, &[u8])> {
    let (head, rest) = R::read_from_prefix(body).map_err(|_| length(body.len(), size_of::<R>()))?;
    match rest.len() % size_of::<R::Item>() {
        0 => Ok((head, rest)),
        more => Err(length(body.len(), body.len() - more)),
    }
}

impl TableUpload {
    /// Nothing is being sent.
    pub const fn new() -> Self {
        TableUpload { state: Upload::Idle, points: [(0.0, Power::ZERO); POINTS], last: 0 }
    }

    /// A new session: what was begun is dropped.
    pub fn abandon(&mut self) {
        self.state = Upload::Idle;
    }

    /// Admits a chunk. It also returns channel and number of a follow table that was overwritten.
    pub fn chunk<const AXES: usize>(
        &mut self,
        context: &mut Context<AXES>,
        tables: &PowerTables,
        number: u16,
        body: &[u8],
    ) -> Loaded {
        match number {
            opcode::SetLaserFollowTable => self.powers(context, tables, body),
            opcode::SetLaserDisTable1D => self.lines(context, tables, body),
            _ => self.plane(context, tables, body),
        }
    }

    /// Notes how a chunk was handled.
    fn keep<T>(&mut self, chunk: &TableChunk<T>, bank: u8, done: Admitted<()>) -> Admitted<()> {
        let next = chunk.first.saturating_add(chunk.items.len() as u16);
        let open = (!chunk.is_last()).then_some((next, bank));
        self.state.note(chunk.begin(), done.map(|()| open));
        done
    }

    fn powers<const AXES: usize>(&mut self, context: &mut Context<AXES>, tables: &PowerTables, body: &[u8]) -> Loaded {
        let (r, rest) = split::<SetLaserFollowTable>(body)?;
        let channel = context.channel(r.core.get(), 3, r.channel.get())?;
        let table = table(1, r.table.get())?;
        let total = within(2, r.count.get(), 1, POINTS as i32)?.unsigned_abs() as usize;
        let chunk = chunk(&r, rest, r.first.get(), total, 4)?;
        let bank = self.state.resume(chunk.begin(), chunk.field, || Ok(0))?;
        if chunk.is_last() {
            // Checked first: a chunk that has to wait has changed nothing.
            not_in_use(context, channel, table)?;
        }
        let range = powers(context.laser(channel).mode, context.is_lsr(), context.shadows.high_resolution);
        let mut limited = 0;
        let done = chunk.indexed().try_for_each(|(index, item)| {
            let (vel, given) = (item.vel.get(), item.power.get());
            let mut taking = RangeLimiter::new(context.is_lsr());
            let vel = real(5, vel, 0.0, SPEED_MAX_PULSES_PER_MS).map_err(|refused| refused.item(index))?;
            let before = index.checked_sub(1).and_then(|before| self.points.get(before));
            if let Some((before, _)) = before.filter(|(before, _)| vel - *before < STEP_MIN_SHARE) {
                let refused = Refused::new(Reason::PointTime).field(5).item(index).got(vel);
                return Err(refused.limits(*before, SPEED_MAX_PULSES_PER_MS));
            }
            let value = taking.take(6, 0, given, range).map_err(|refused| refused.item(index))?;
            limited += u16::from(taking.limited != 0);
            if let Some(slot) = self.points.get_mut(index) {
                *slot = (vel, power(6, value)?);
            }
            Ok(())
        });
        self.keep(&chunk, bank, done)?;
        if !chunk.is_last() {
            context.stage(TickCommand::Mark);
            return Ok((answer_taken(context, &[limited.into()], 0), None));
        }
        if let Some(curve) = Curve::power(channel, table) {
            for (index, (vel, power)) in self.points.iter().take(total).enumerate() {
                // The checks let nothing through that it refuses.
                let _ = tables.power_point(curve, index, vel.to_bits(), *power);
            }
            tables.finish(curve, total);
        }
        context.enter(channel, LaserChange::TableFilled(table));
        Ok((answer_taken(context, &[limited.into()], 0), Some((channel, table))))
    }

    fn lines<const AXES: usize>(&mut self, context: &mut Context<AXES>, tables: &PowerTables, body: &[u8]) -> Loaded {
        let (r, rest) = split::<SetLaserDisTable1D>(body)?;
        let channel = context.channel(r.core.get(), 5, r.channel.get())?;
        let count = within(1, r.count.get(), 1, POINTS as i16)?.unsigned_abs() as usize;
        let mut shadow = running(context, channel)?;
        let total = DISTANCES * count;
        let limits = (4, &r.limit[..], r.limits_given != 0);
        let (limits, limited) = context.own_limits(channel, &mut shadow, (2, r.min.get(), r.max.get()), limits)?;
        let chunk = chunk(&r, rest, r.first.get(), total, 7)?;
        let bank = self.state.resume(chunk.begin(), chunk.field, || free_bank(context, channel))?;
        let done = chunk.indexed().try_for_each(|(index, item)| {
            let axis = index.checked_div(count).unwrap_or(0);
            let point = index - axis * count;
            let value = ratio(8, point, item.ratio.get()).map_err(|refused| refused.axis(axis as i16 + 1))?;
            let pos = item.pos.get();
            if point > 0 && pos <= self.last {
                let refused = Refused::new(Reason::PointOfAxis).field(9).item(point).axis(axis as i16 + 1);
                return Err(refused.got(pos.into()).limits(self.last.into(), i32::MAX.into()));
            }
            self.last = pos;
            if let Some(curve) = Curve::ratio(channel, bank, axis as u8) {
                let _ = tables.ratio_point(curve, point, pos, value.to_bits());
            }
            Ok(())
        });
        self.keep(&chunk, bank, done)?;
        if chunk.is_last() {
            for (axis, limit) in limits.into_iter().enumerate() {
                tables.limit(channel, bank, axis as u8, limit);
                if let Some(curve) = Curve::ratio(channel, bank, axis as u8) {
                    tables.finish(curve, count);
                }
            }
            shadow.from = Ratios::Lines { bank };
            stage(context, channel, shadow)?;
        } else {
            context.stage(TickCommand::Mark);
        }
        Ok((context.distance_bounds_reply(channel, &shadow, limited), None))
    }

    fn plane<const AXES: usize>(&mut self, context: &mut Context<AXES>, tables: &PowerTables, body: &[u8]) -> Loaded {
        let (r, rest) = split::<SetLaserDisTable2D>(body)?;
        let channel = context.channel(r.core.get(), 6, r.channel.get())?;
        let [x, y] = r.axis.map(|axis| axis.get());
        for (index, axis) in [x, y].into_iter().enumerate() {
            choice(1, axis, 1, DISTANCES as i16).map_err(|refused| refused.item(index))?;
        }
        if x == y {
            return Err(Refused::new(Reason::PlaneAxis).field(1).got(x.into()));
        }
        let axes = [x, y].map(|axis| axis as u8 - 1);
        let mut counts = [0; 2];
        for (index, (to, given)) in counts.iter_mut().zip(r.count).enumerate() {
            let count = within(2, given.get(), 1, POINTS as i16).map_err(|refused| refused.item(index))?;
            *to = usize::from(count.unsigned_abs());
        }
        let [columns, rows] = counts;
        if columns * rows > NODES {
            let refused = Refused::new(Reason::TooMany).field(2).got((columns * rows) as f64);
            return Err(refused.limits(1.0, NODES as f64));
        }
        let mut shadow = running(context, channel)?;
        let limits = (5, &r.limit[..], r.limits_given != 0);
        let (limits, limited) = context.own_limits(channel, &mut shadow, (3, r.min.get(), r.max.get()), limits)?;
        let total = columns + rows + columns * rows;
        let chunk = chunk(&r, rest, r.first.get(), total, 8)?;
        let bank = self.state.resume(chunk.begin(), chunk.field, || free_bank(context, channel))?;
        let done = chunk.indexed().try_for_each(|(index, item)| {
            let value = item.value.get();
            if let Some(node) = index.checked_sub(columns + rows) {
                let value = ratio(9, node, value)?;
                let _ = tables.plane_node(channel, bank, node, value.to_bits());
                return Ok(());
            }
            let (direction, line, reason) =
                if index < columns { (0, index, Reason::PlaneX) } else { (1, index - columns, Reason::PlaneY) };
            let whole = value as i32;
            if f64::from(whole) != value || line > 0 && whole <= self.last {
                let low = if line > 0 { self.last } else { i32::MIN };
                return Err(Refused::new(reason).field(9).item(line).got(value).limits(low.into(), i32::MAX.into()));
            }
            self.last = whole;
            if let Some(curve) = Curve::ratio(channel, bank, direction) {
                let _ = tables.plane_line(curve, line, whole);
            }
            Ok(())
        });
        self.keep(&chunk, bank, done)?;
        if chunk.is_last() {
            for (direction, count) in (0..).zip(counts) {
                if let Some(curve) = Curve::ratio(channel, bank, direction) {
                    tables.finish(curve, count);
                }
            }
            for axis in 0..DISTANCES as u8 {
                let limit = axes.iter().position(|of| *of == axis).and_then(|index| *limits.get(index)?);
                tables.limit(channel, bank, axis, limit);
            }
            shadow.from = Ratios::Plane { bank, axes };
            stage(context, channel, shadow)?;
        } else {
            context.stage(TickCommand::Mark);
        }
        Ok((context.distance_bounds_reply(channel, &shadow, limited), None))
    }
}

/// The least step of velocity from point to point: 2⁻²⁸ pulse/ms, with a margin for rounding.
const STEP_MIN_SHARE: f64 = 1.5 / 268_435_456.0;

/// A table of powers, from 1.
pub fn table(field: u8, got: i16) -> Admitted<u8> {
    Ok(choice(field, got, 1, POWER_TABLES as i16)? as u8 - 1)
}

/// A bank that can be written.
fn free_bank<const AXES: usize>(context: &Context<AXES>, channel: u8) -> Admitted<u8> {
    let read = context.view.lasers.get(usize::from(channel)).and_then(|sampled| sampled.bank);
    let busy = || Refused::new(Reason::RatiosBusy).got(channel.into());
    context.laser(channel).free_bank(context.view, read).ok_or_else(busy)
}

/// A follow table may not be replaced while an entry of a path names it or a follow reads it. An
/// entry that a command in flight takes away is there until then, for a path that may still run,
/// also where the entry itself is in flight.
fn not_in_use<const AXES: usize>(context: &Context<AXES>, channel: u8, table: u8) -> Admitted<()> {
    let reads = context.view.lasers.get(usize::from(channel)).and_then(|sampled| sampled.table);
    let naming = |shadows: &Shadows<AXES>, crd: Crd| {
        let laser = shadows.lasers.get(usize::from(channel));
        let named = laser.and_then(|laser| laser.named.get(usize::from(table))).copied().unwrap_or(0);
        (0..2).filter(move |fifo| named >> (2 * crd.index() as u8 + fifo) & 1 == 1)
    };
    let names = |crd: Crd| {
        let holds = |fifo: u8| context.shadows.crd(crd).space(context.crd_sampled(crd), fifo) != CAPACITY;
        naming(context.shadows, crd).any(holds)
    };
    let may_run =
        |crd: Crd| !context.due.decided && context.crd_shadow(crd).is_busy(context.view, context.crd_sampled(crd));
    let named = |crd: Crd| naming(context.executed, crd).next().is_some();
    let holds = Crd::all().any(|crd| names(crd) || may_run(crd) && named(crd));
    if holds || reads.is_some() && reads == Curve::power(channel, table) {
        let refused = Refused::new(Reason::FollowTableInUse).got(f64::from(table) + 1.0);
        return Err(refused.limits(channel.into(), 0.0));
    }
    Ok(())
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Bounds of the follow's own, and the largest change by each axis; which of them were limited.
    fn own_limits(
        &self,
        channel: u8,
        shadow: &mut DistanceShadow,
        (field, min, max): (u8, f64, f64),
        (limits_field, given, are_given): (u8, &[zerocopy::little_endian::F64], bool),
    ) -> Admitted<([Option<Power>; DISTANCES], u8)> {
        let mut taking = RangeLimiter::new(self.is_lsr());
        shadow.bounds = self.distance_bounds(channel, &mut taking, field, (min, max))?;
        let mode = self.laser(channel).mode;
        let range = Range::new(0.0, crate::report::replies::units(mode.full_scale()));
        let mut limits = [None; DISTANCES];
        if are_given {
            for (index, (to, given)) in limits.iter_mut().zip(given).enumerate() {
                let most = taking.take(limits_field, 2, given.get(), range).map_err(|refused| refused.item(index))?;
                *to = Some(power(limits_field, most)?);
            }
        }
        Ok((limits, taking.limited))
    }
}
