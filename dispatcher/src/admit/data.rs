//! Data of FIFOs: PT segments, and entries of Follow. It is written to the axis's store at admission, behind what
//! the tick knows of, and becomes visible by a commit at its instant.
//!
//! In: a data command. Out: what was [`Written`]; then, once it is entered into the *ahead* books, the commit that
//! shows all that an axis has in a FIFO. Fails: with a refusal, and then nothing has changed.
use super::{follow_data, one, pt};
use crate::books::{Books, Change, Fifo, FifoBook};
use crate::case::{Answer, Case};
use crate::refuse::Admitted;
use protocol::command::{FollowSwitchNowEx, opcode};
use servo::op::Op;
use servo::pt::SegmentStore;
use servo::units::Axis;

/// Data that was written to a store and is not yet visible to the tick.
#[derive(Debug, Clone, Copy)]
pub struct Written {
    /// Whose.
    pub axis: Axis,
    /// Which FIFO.
    pub fifo: u8,
    /// What to answer.
    pub answer: Answer,
}

/// Where a FIFO ends with what was written.
#[derive(Debug, Clone, Copy)]
pub enum End {
    /// Of segments of PT.
    Pt(FifoBook),
    /// Of entries of Follow.
    Follow(Fifo),
}

/// Whether a command is data.
pub fn is_data(number: u16, body: &[u8]) -> bool {
    match number {
        opcode::PtData
        | opcode::PtDataMany
        | opcode::FollowData
        | opcode::FollowDataPercentEx
        | opcode::FollowDataPercent2Ex
        | opcode::FollowDoBitEx
        | opcode::FollowDelayEx
        | opcode::FollowDiBitEx => true,
        // A switch that is queued.
        opcode::FollowSwitchNowEx => one::<FollowSwitchNowEx>(body).is_ok_and(|r| r.buffer.get() != 0),
        _ => false,
    }
}

/// Admits a data command: all of it, or nothing.
pub fn data<const AXES: usize>(
    case: &Case<AXES>,
    stores: &[SegmentStore; AXES],
    number: u16,
    body: &[u8],
) -> Admitted<(Written, End)> {
    if matches!(number, opcode::PtData | opcode::PtDataMany) {
        pt::data(case, stores, number, body)
    } else {
        follow_data::data(case, stores, number, body)
    }
}

/// Enters written data into the *ahead* books before its commit is pushed.
pub fn enter<const AXES: usize>(books: &mut Books<AXES>, written: &Written, end: End) {
    let Written { axis, fifo, .. } = *written;
    let book = books.axis(axis);
    let change = match end {
        End::Pt(data) => Change::Data { axis, fifo, epoch: book.epoch, book: data },
        End::Follow(data) => {
            Change::FollowData { axis, fifo, cleared: book.follow.cleared[usize::from(fifo & 1)], book: data }
        }
    };
    books.enter(&change, 0);
}

/// The commit of what these books have in a FIFO.
pub fn commit<const AXES: usize>(books: &Books<AXES>, axis: Axis, fifo: u8) -> (Op, Change) {
    let book = books.axis(axis);
    let place = usize::from(fifo & 1);
    if book.is_follow() {
        let (cleared, data) = (book.follow.cleared[place], book.follow.fifos[place]);
        let op = Op::FollowCommit { axis, fifo, end: data.chain.entries(), cleared, tail: data.chain.tail() };
        (op, Change::FollowData { axis, fifo, cleared, book: data })
    } else {
        let (epoch, data) = (book.epoch, book.fifos[place]);
        (Op::PtCommit { axis, fifo, end: data.end, epoch }, Change::Data { axis, fifo, epoch, book: data })
    }
}
