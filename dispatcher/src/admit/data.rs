//! Data of FIFOs: PT segments, entries of Follow, entries of paths. Admission writes it to its
//! store, after the part that the tick knows. A commit publishes it at its instant.
//!
//! In: a data command. Out: what was [`Written`], and the operation that commits all data of a
//! FIFO.
//! Fails: with a refusal, and then nothing has changed. A commit cannot fail.
use super::admission::{Admission, context};
use super::context::{Context, Due, Effect};
use super::{buffered, crd_data, follow_data, kind, one, pt};
use crate::plan::path_queue::PathQueue;
use crate::refuse::{Admitted, FifoOf};
use crate::report::answer::{Answer, TAKEN_MAX};
use crate::shadow::{CAPACITY, Change, CrdChange, Fifo as Entries, FifoShadow, PathData, Shadows, executed};
use protocol::command::{CommandKind, Fifo, FollowSwitchNowEx, opcode};
use protocol::values::pt_state;
use servo::op::Op;
use servo::path::PathStores;
use servo::segment::pt::SegmentStore;
use servo::units::Crd;
use servo::view::View;

/// What was written, and the end of its FIFO.
pub type Stored = Admitted<(Written, End)>;
/// The memory of PT and Follow, one store for each axis.
pub type Segments<const AXES: usize> = [SegmentStore; AXES];
/// The look-aheads of all coordinate systems, and both FIFOs of each.
pub type Paths<'x> = (&'x mut [[PathQueue; 2]], PathStores<'x>);

/// Data that was written to a store and is not yet visible to the tick.
#[derive(Debug, Clone, Copy)]
pub struct Written {
    /// The owner.
    pub of: FifoOf,
    /// Which FIFO.
    pub fifo: u8,
    /// What to answer.
    pub answer: Answer,
    /// Its commit goes by the immediate lane.
    pub at_once: bool,
    /// The values that the answer waits for: what a buffered laser command took.
    pub took: [f64; TAKEN_MAX],
    /// Laser channel and follow table that an entry of a path names.
    pub named: Option<(u8, u8)>,
}

/// The end of a FIFO after the written data.
#[derive(Debug, Clone, Copy)]
pub enum End {
    /// Of segments of PT.
    Pt(FifoShadow),
    /// Of entries of Follow.
    Follow(Entries),
    /// Of entries of a path.
    Path(PathData),
}

impl Written {
    /// Data of a FIFO whose commit is pushed with the others of its instant.
    pub fn new(of: FifoOf, fifo: u8, answer: Answer) -> Written {
        Written { of, fifo, answer, at_once: false, took: [0.0; TAKEN_MAX], named: None }
    }

    /// The values that its answer waits for.
    pub fn waiting(&self) -> impl Iterator<Item = f64> {
        self.took.into_iter().take(self.answer.waiting().into())
    }
}

/// Whether a command is data.
pub fn is_data(number: u16, body: &[u8]) -> bool {
    match number {
        // A switch that is queued.
        opcode::FollowSwitchNowEx => one::<FollowSwitchNowEx>(body).is_ok_and(|r| r.buffer.get() != 0),
        _ => matches!(kind(number), Some(CommandKind::Data(_))),
    }
}

/// The commit of a FIFO of a coordinate system up to an entry.
pub fn commit_of_path<const AXES: usize>(shadows: &Shadows<AXES>, crd: Crd, fifo: u8, end: u32) -> (Op, Change) {
    let path = shadows.crd(crd).path(fifo);
    let (cleared, data) = (path.cleared, path.data);
    let change = CrdChange::Data { fifo, cleared, data };
    (Op::CrdCommit { crd, fifo, end, cleared }, Change::Crd { crd, change })
}

impl<const AXES: usize> Admission<'_, AXES> {
    /// Admits data and commits it through the immediate lane; the caller has checked that there is
    /// room. None if the command is no data.
    pub fn publish(&mut self, view: &View<AXES>, due: Due, number: u16, body: &[u8]) -> Option<Admitted<Written>> {
        is_data(number, body).then(|| {
            let written = self.admit_data(view, due, number, body)?;
            self.commit_now(written.of, written.fifo);
            Ok(written)
        })
    }

    /// Admits a data command, all of it or nothing: writes it to the store and enters it into the
    /// admitted state. Its commit follows.
    pub fn admit_data(&mut self, view: &View<AXES>, due: Due, number: u16, body: &[u8]) -> Admitted<Written> {
        let context = context!(self, view, due, self.staged);
        let paths = (&mut *self.queues, self.entries);
        let (written, end) = match kind(number) {
            Some(CommandKind::Data(Fifo::Pt)) => pt::data(&context, self.stores, number, body)?,
            Some(CommandKind::Data(Fifo::Path)) => crd_data::data(&context, paths, number, body)?,
            Some(CommandKind::Data(Fifo::Light)) => buffered::data(&context, paths, number, body)?,
            _ => follow_data::data(&context, self.stores, number, body)?,
        };
        if let FifoOf::Axis(axis) = written.of
            && self.admitted.overwrites(view, axis, written.fifo)
        {
            let (now, ahead) = (self.executed.axis(axis), self.admitted.axis(axis));
            let all = now.mode != ahead.mode || ahead.is_dynamic();
            self.executed.invalidate_fifos(axis, if all { 3 } else { 1 << (written.fifo & 1) });
        }
        self.enter(&written, end);
        if let (FifoOf::Crd(crd), Some((channel, table))) = (written.of, written.named) {
            // Also if the program is dropped before its commit: the table counts as named until the
            // FIFO is empty.
            for shadows in [&mut self.executed, &mut self.admitted] {
                shadows.name_follow_table(channel, table, crd, written.fifo);
            }
        }
        Ok(written)
    }

    /// Whether the motion of a FIFO makes room in it: it runs, or will when all is executed.
    pub fn drains(&self, view: &View<AXES>, (of, fifo): (FifoOf, u8)) -> bool {
        match of {
            FifoOf::Axis(axis) => {
                let runs = view.axes.get(axis.index()).is_some_and(|sampled| sampled.pt_state == pt_state::RUNNING);
                let shadow = self.admitted.axis(axis);
                shadow.is_dynamic() && shadow.started.is_some_and(|start| runs || !executed(view, start))
            }
            FifoOf::Crd(crd) => {
                let shadow = self.admitted.crd(crd);
                shadow.fifo == fifo && view.crds.get(crd.index()).is_some_and(|sampled| shadow.may_run(view, sampled))
            }
        }
    }

    /// How many quarters of a FIFO are free.
    pub fn free_quarters(&self, view: &View<AXES>, (of, fifo): (FifoOf, u8)) -> u32 {
        let (space, capacity) = match of {
            FifoOf::Axis(axis) => {
                let (shadow, sampled) = (self.admitted.axis(axis), view.axes.get(axis.index()));
                let space = sampled.map_or(0, |sampled| shadow.space(view, sampled, fifo.into()));
                (space, shadow.capacity())
            }
            FifoOf::Crd(crd) => {
                let sampled = view.crds.get(crd.index());
                (sampled.map_or(0, |sampled| self.admitted.crd(crd).space(sampled, fifo)), CAPACITY)
            }
        };
        space.saturating_mul(4) / capacity.max(1)
    }

    /// Enters written data into the admitted state.
    fn enter(&mut self, &Written { of, fifo, .. }: &Written, end: End) {
        let change = match (of, end) {
            (FifoOf::Axis(axis), End::Pt(shadow)) => {
                Change::Data { axis, fifo, epoch: self.admitted.axis(axis).epoch, shadow }
            }
            (FifoOf::Axis(axis), End::Follow(shadow)) => {
                let cleared = self.admitted.axis(axis).follow.cleared[usize::from(fifo & 1)];
                Change::FollowData { axis, fifo, cleared, shadow }
            }
            (FifoOf::Crd(crd), End::Path(data)) => {
                let cleared = self.admitted.crd(crd).path(fifo).cleared;
                Change::Crd { crd, change: CrdChange::Data { fifo, cleared, data } }
            }
            // Data has the kind of its FIFO's owner.
            _ => Change::None,
        };
        self.admitted.enter(&change, 0);
    }

    /// The commit of all admitted data of a FIFO; of a path, what has left its look-ahead or never
    /// went there.
    pub fn commit(&mut self, of: FifoOf, fifo: u8) -> (Op, Change) {
        let index = usize::from(fifo & 1);
        match of {
            FifoOf::Crd(crd) => {
                let queues = self.queues.get_mut(crd.index()).zip(self.entries.get(crd.index()));
                let end = queues.map_or(0, |(queues, stores)| queues[index].settle(&stores[index]));
                commit_of_path(&self.admitted, crd, fifo, end)
            }
            FifoOf::Axis(axis) => {
                let shadow = self.admitted.axis(axis);
                if shadow.is_follow() {
                    let (cleared, data) = (shadow.follow.cleared[index], shadow.follow.fifos[index]);
                    let (end, tail) = (data.chain.entries(), data.chain.tail());
                    let op = Op::FollowCommit { axis, fifo, end, cleared, tail };
                    (op, Change::FollowData { axis, fifo, cleared, shadow: data })
                } else {
                    let (epoch, data) = (shadow.epoch, shadow.fifos[index]);
                    (
                        Op::PtCommit { axis, fifo, end: data.end, epoch },
                        Change::Data { axis, fifo, epoch, shadow: data },
                    )
                }
            }
        }
    }

    /// Pushes that commit into the immediate lane; the caller has checked that there is room.
    pub fn commit_now(&mut self, of: FifoOf, fifo: u8) {
        let (op, change) = self.commit(of, fifo);
        self.lane.push(op, change, 0, &mut self.admitted);
    }
}
