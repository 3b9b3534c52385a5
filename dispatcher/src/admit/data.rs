//! Data of FIFOs: PT segments, entries of Follow, entries of paths. Admission writes it to its
//! store, after the part that the tick knows. A commit publishes it at its instant.
//!
//! In: a data command. Out: what was [`Written`].
//! Fails: with a refusal, and then nothing has changed.
use super::commit::{End, Written};
use super::context::Context;
use super::{crd_data, follow_data, kind, one, pt};
use crate::plan::path_queue::PathQueue;
use crate::refuse::Admitted;
use protocol::command::{CommandKind, Fifo, FollowSwitchNowEx, opcode};
use servo::path::PathStores;
use servo::segment::pt::SegmentStore;

/// What was written, and the end of its FIFO.
pub type Stored = Admitted<(Written, End)>;
/// The memory of PT and Follow, one store for each axis.
pub type Segments<const AXES: usize> = [SegmentStore; AXES];
/// The look-aheads of all coordinate systems, and both FIFOs of each.
pub type Paths<'x> = (&'x mut [[PathQueue; 2]], PathStores<'x>);

/// Whether a command is data.
pub fn is_data(number: u16, body: &[u8]) -> bool {
    match number {
        // A switch that is queued.
        opcode::FollowSwitchNowEx => one::<FollowSwitchNowEx>(body).is_ok_and(|r| r.buffer.get() != 0),
        _ => matches!(kind(number), Some(CommandKind::Data(_))),
    }
}

/// Admits a data command: all of it, or nothing.
pub fn data<const AXES: usize>(
    context: &Context<AXES>,
    (segments, paths): (&Segments<AXES>, Paths<'_>),
    number: u16,
    body: &[u8],
) -> Stored {
    match kind(number) {
        Some(CommandKind::Data(Fifo::Pt)) => pt::data(context, segments, number, body),
        Some(CommandKind::Data(Fifo::Path)) => crd_data::data(context, paths, number, body),
        Some(CommandKind::Data(Fifo::Light)) => crd_data::light(context, paths, number, body),
        _ => follow_data::data(context, segments, number, body),
    }
}
