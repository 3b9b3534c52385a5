//! The points of a PVT table from bytes to the stores.
//!
//! In: chunks of points, each a record of its own; `first` is the index of the chunk's first point.
//! Out: points and a header in the stores when the last point has come, or the values of the
//! Calculate commands. Owns: the table that is being sent, in scratch memory and in the point
//! memory of an empty table. A chunk with `first` 0 begins a new one.
//! Fails: as the points do. Nothing of a table is visible before its last chunk. A chunk that is
//! sent again, because it was refused too early, is refused in the same way.
use super::context::Context;
use super::pvt::{not_in_use, table};
use super::upload::Upload;
use crate::plan::pvt::{FieldIndices, POINT_VALUES, Scratch, SplineScratch, TableDraft, TableKind};
use crate::refuse::{Admitted, Refused};
use crate::report::answer::MAX_POINTS;
use heapless::Vec;
use protocol::command::{
    PvtContinuousCalculate, PvtPercentCalculate, PvtTable, PvtTableComplete, PvtTableContinuous, PvtTableEx,
    PvtTablePercent, Wire, opcode,
};
use protocol::reason::Reason;
use servo::segment::pvt::{HEADER_WORDS, PointStore, PvtTables, TABLES};
use servo::tables::TableStores;
use servo::units::StepLimit;

/// What the chunks of one table have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PvtTableKey {
    opcode: u16,
    core: i16,
    /// 0 for the Calculate commands.
    table: i16,
    count: i32,
    kind: TableKind,
}

/// A chunk as it came.
struct PvtChunk<'b> {
    key: PvtTableKey,
    first: u16,
    fields: FieldIndices,
    points: &'b [u8],
    /// Length of the body.
    len: usize,
}

impl<'b> PvtChunk<'b> {
    fn read(number: u16, body: &'b [u8]) -> Admitted<Self> {
        fn head<R: Wire>(body: &[u8]) -> Admitted<(R, &[u8])> {
            R::read_from_prefix(body).map_err(|_| super::length(body.len(), size_of::<R>()))
        }
        /// Each command: how its points are to be taken, its table, and the indices of `count`, of
        /// what belongs to all points and of a point.
        macro_rules! chunks {
            ($($name:ident, |$r:ident| $kind:expr, $table:expr, [$count:literal, $whole:literal, $point:literal];)*) => {
                match number {
                    $(opcode::$name => {
                        let ($r, points) = head::<$name>(body)?;
                        let (core, count) = ($r.core.get(), $r.count.get());
                        let key = PvtTableKey { opcode: number, core, table: $table, count, kind: $kind };
                        let fields = FieldIndices { count: $count, whole: $whole, point: $point };
                        PvtChunk { key, first: $r.first.get(), fields, points, len: body.len() }
                    })*
                    other => return Err(super::unknown(other)),
                }
            };
        }
        let chunk = chunks! {
            PvtTable, |r| TableKind::Pvt, r.table.get(), [2, 4, 4];
            PvtTableEx, |r| TableKind::PvtEx, r.table.get(), [2, 4, 4];
            PvtTableComplete, |r| TableKind::Complete { vel_begin: r.vel_begin.get(), vel_end: r.vel_end.get() },
                r.table.get(), [2, 4, 6];
            PvtTablePercent, |r| TableKind::Percent { vel_begin: r.vel_begin.get() }, r.table.get(), [2, 4, 5];
            PvtTableContinuous, |r| TableKind::Continuous { time_begin: r.time_begin.get() }, r.table.get(), [2, 4, 5];
            PvtPercentCalculate, |r| TableKind::Percent { vel_begin: r.vel_begin.get() }, 0, [1, 3, 4];
            PvtContinuousCalculate, |r| TableKind::Continuous { time_begin: 0.0 }, 0, [1, 3, 3];
        };
        let width = chunk.key.kind.values() * size_of::<f64>();
        if chunk.points.len() % width != 0 {
            return Err(super::length(chunk.len, chunk.len - chunk.points.len() % width));
        }
        Ok(chunk)
    }

    /// The points, if there are any.
    fn points(&self) -> Admitted<impl Iterator<Item = ([f64; POINT_VALUES], usize)> + 'b> {
        let values = self.key.kind.values();
        let width = values * size_of::<f64>();
        if self.points.is_empty() {
            return Err(super::length(self.len, self.len + width));
        }
        Ok(self.points.chunks_exact(width).map(move |point| {
            let mut numbers = [0.0; POINT_VALUES];
            for (number, bytes) in numbers.iter_mut().zip(point.as_chunks().0) {
                *number = f64::from_le_bytes(*bytes);
            }
            (numbers, values)
        }))
    }

    /// The index after its last point.
    fn end(&self) -> i32 {
        i32::from(self.first) + (self.points.len() / (self.key.kind.values() * size_of::<f64>())) as i32
    }
}

servo::state! {
    /// The table that is being sent; see the module text.
    pub struct PvtUpload {
        beside: SplineScratch = SplineScratch::new(),
        /// The table in whose point memory the points wait.
        room: u8 = 0,
        emptied: Option<u8> = None,
        table: Upload<PvtTableKey, TableDraft> = Upload::Idle,
        /// The Calculate commands of the two lanes, which leave no table.
        calculate: [Upload<PvtTableKey, TableDraft>; 2] = [Upload::Idle; 2],
    }
    /// Nothing is being sent.
    pub const fn new();
}

impl PvtUpload {
    /// A new session: what was begun is dropped.
    pub fn abandon(&mut self) {
        (self.table, self.calculate) = (Upload::Idle, [Upload::Idle; 2]);
    }

    /// Finds room for the points of a table where nothing is lost: in an empty table. If no table
    /// is empty, the one that is replaced makes room as soon as it is not in use. It is empty from
    /// then on.
    fn make_room<const AXES: usize>(&mut self, context: &Context<AXES>, stores: TableStores, slot: u8) -> Admitted<()> {
        let is_free = |table: u8| {
            let filled = context.executed.is_filled(table) || context.shadows.is_filled(table);
            !filled && not_in_use(context, table).is_ok()
        };
        self.room = match core::iter::once(slot).chain(0..TABLES as u8).find(|table| is_free(*table)) {
            Some(room) => room,
            None => {
                not_in_use(context, slot)?;
                self.emptied = Some(slot);
                slot
            }
        };
        if !stores.is_empty(self.room) {
            // Nobody starts it any more; a prepared first piece of it finds another version.
            stores.write_header(self.room, [0; HEADER_WORDS]);
        }
        Ok(())
    }

    /// A table that had to make room for its own replacement, once.
    pub fn emptied(&mut self) -> Option<u8> {
        self.emptied.take()
    }

    /// Admits a chunk of a table. The last one fills the stores, and returns which table is
    /// complete now. `now` is the executed state.
    pub fn table<const AXES: usize>(
        &mut self,
        context: &Context<AXES>,
        stores: TableStores,
        number: u16,
        body: &[u8],
    ) -> Admitted<Option<u8>> {
        let chunk = PvtChunk::read(number, body)?;
        let slot = table(context, chunk.key.core, 1, chunk.key.table)?;
        if chunk.end() >= chunk.key.count {
            // Checked first: a chunk that has to wait has changed nothing.
            not_in_use(context, slot)?;
        }
        if chunk.first == 0 {
            self.make_room(context, stores, slot)?;
        }
        let Some(room) = stores.points.get(usize::from(self.room)) else { return Ok(None) };
        let scratch = &mut Scratch::new(&mut self.beside, room);
        let draft = take(&mut self.table, scratch, (&chunk, context.board.step_limit), true, |_| {})?;
        let Some(sealed) = draft.finish(scratch) else { return Ok(None) };
        let written = sealed.and_then(|sealed| {
            let words = sealed.header().admit().ok_or_else(|| Refused::new(Reason::TableRange))?;
            for index in 0..sealed.points() {
                // Its own room may be the table's: a point is read before it is written.
                let words = sealed.point(scratch, index).ok_or_else(|| Refused::new(Reason::TableRange))?;
                stores.write_point(slot, index, words);
            }
            stores.write_header(slot, words);
            Ok(slot)
        });
        self.table.note((chunk.key, chunk.first), written.map(|_| None));
        written.map(Some)
    }

    /// Answers a chunk of a Calculate command of `lane` (0 or 1); returns how many values. `sent`
    /// states whether they were sent; if not, the chunk may be sent again.
    pub fn calculate<const AXES: usize>(
        &mut self,
        context: &Context<AXES>,
        points: &[PointStore],
        lane: usize,
        number: u16,
        body: &[u8],
        sent: impl FnOnce(&[f64]) -> bool,
    ) -> Admitted<bool> {
        let chunk = PvtChunk::read(number, body)?;
        context.core(chunk.key.core)?;
        let mut values = Vec::<_, MAX_POINTS>::new();
        // No room is used: these leave no table.
        let (Some(state), Some(room)) = (self.calculate.get_mut(lane), points.first()) else { return Ok(false) };
        let before = *state;
        take(state, &mut Scratch::new(&mut self.beside, room), (&chunk, context.board.step_limit), false, |value| {
            values.push(value).ok();
        })?;
        let sent = sent(&values);
        if !sent {
            *state = before;
        }
        Ok(sent)
    }
}

/// Takes the points of a chunk; returns the draft with them.
fn take(
    state: &mut Upload<PvtTableKey, TableDraft>,
    scratch: &mut Scratch,
    (chunk, limit): (&PvtChunk, StepLimit),
    load: bool,
    mut answer: impl FnMut(f64),
) -> Admitted<TableDraft> {
    let key = chunk.key;
    let begin = || TableDraft::begin(key.kind, key.count, chunk.fields, limit, load, scratch);
    let mut draft = state.resume((key, chunk.first), chunk.fields.count + 1, begin)?;
    let taken = chunk.points().and_then(|mut points| {
        points.try_for_each(|(numbers, values)| {
            draft.point(numbers.get(..values).unwrap_or(&[]), scratch).map(&mut answer)
        })
    });
    state.note((key, chunk.first), taken.map(|()| Some((draft.taken(), draft))));
    taken.map(|()| draft)
}
