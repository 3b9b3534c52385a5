//! What was written to a FIFO's store, and the commits that publish it to the tick.
//!
//! In: written data, the admitted state. Out: the admitted state with it; the operation that
//! commits all data of a FIFO. Cannot fail.
use crate::report::answer::{Answer, TAKEN_MAX};
use crate::shadow::{Change, CrdChange, Fifo, FifoShadow, PathData, Shadows};
use servo::op::Op;
use servo::units::{Axis, Crd};

/// The owner of a FIFO.
#[derive(Debug, Clone, Copy)]
pub enum FifoOf {
    /// An axis.
    Axis(Axis),
    /// A coordinate system.
    Crd(Crd),
}

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

impl Written {
    /// Data of a FIFO whose commit is pushed with the rest of its instant.
    pub fn new(of: FifoOf, fifo: u8, answer: Answer) -> Written {
        Written { of, fifo, answer, at_once: false, took: [0.0; TAKEN_MAX], named: None }
    }

    /// The values that its answer waits for.
    pub fn waiting(&self) -> impl Iterator<Item = f64> {
        self.took.into_iter().take(self.answer.waiting().into())
    }
}

/// The end of a FIFO after the written data.
#[derive(Debug, Clone, Copy)]
pub enum End {
    /// Of segments of PT.
    Pt(FifoShadow),
    /// Of entries of Follow.
    Follow(Fifo),
    /// Of entries of a path.
    Path(PathData),
}

/// Enters written data into the admitted state before its commit is pushed.
pub fn enter<const AXES: usize>(shadows: &mut Shadows<AXES>, written: &Written, end: End) {
    let fifo = written.fifo;
    let change = match (written.of, end) {
        (FifoOf::Axis(axis), End::Pt(data)) => {
            Change::Data { axis, fifo, epoch: shadows.axis(axis).epoch, shadow: data }
        }
        (FifoOf::Axis(axis), End::Follow(data)) => {
            let cleared = shadows.axis(axis).follow.cleared[usize::from(fifo & 1)];
            Change::FollowData { axis, fifo, cleared, shadow: data }
        }
        (FifoOf::Crd(crd), End::Path(data)) => {
            let cleared = shadows.crd(crd).path(fifo).cleared;
            Change::Crd { crd, change: CrdChange::Data { fifo, cleared, data } }
        }
        // Data has the kind of its FIFO's owner.
        _ => Change::None,
    };
    shadows.enter(&change, 0);
}

/// The commit of all data that this state has in a FIFO of an axis.
pub fn commit<const AXES: usize>(shadows: &Shadows<AXES>, axis: Axis, fifo: u8) -> (Op, Change) {
    let shadow = shadows.axis(axis);
    let index = usize::from(fifo & 1);
    if shadow.is_follow() {
        let (cleared, data) = (shadow.follow.cleared[index], shadow.follow.fifos[index]);
        let op = Op::FollowCommit { axis, fifo, end: data.chain.entries(), cleared, tail: data.chain.tail() };
        (op, Change::FollowData { axis, fifo, cleared, shadow: data })
    } else {
        let (epoch, data) = (shadow.epoch, shadow.fifos[index]);
        (Op::PtCommit { axis, fifo, end: data.end, epoch }, Change::Data { axis, fifo, epoch, shadow: data })
    }
}

/// The commit of a FIFO of a coordinate system up to an entry.
pub fn commit_path<const AXES: usize>(shadows: &Shadows<AXES>, crd: Crd, fifo: u8, end: u32) -> (Op, Change) {
    let path = shadows.crd(crd).path(fifo);
    let (cleared, data) = (path.cleared, path.data);
    let change = CrdChange::Data { fifo, cleared, data };
    (Op::CrdCommit { crd, fifo, end, cleared }, Change::Crd { crd, change })
}
