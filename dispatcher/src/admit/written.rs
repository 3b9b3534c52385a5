//! Data that was written to a store and is not yet visible to the tick; the memory that it is
//! written to.
use crate::plan::path_queue::PathQueue;
use crate::refuse::{Admitted, FifoOf};
use crate::report::answer::{Answer, TAKEN_MAX_VALUES};
use crate::shadow::ShadowChange;
use servo::path::PathStores;
use servo::segment::pt::SegmentStore;

/// What was written, and the new end of its FIFO for the shadow state.
pub type Stored = Admitted<(Written, ShadowChange)>;
/// The memory of PT and Follow, one store for each axis.
pub type SegmentStores<const AXES: usize> = [SegmentStore; AXES];
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
    pub took: [f64; TAKEN_MAX_VALUES],
    /// Laser channel and follow table that an entry of a path names.
    pub named: Option<(u8, u8)>,
}

impl Written {
    /// Data of a FIFO whose commit is pushed with the others of its instant.
    pub fn new(of: FifoOf, fifo: u8, answer: Answer) -> Written {
        Written { of, fifo, answer, at_once: false, took: [0.0; TAKEN_MAX_VALUES], named: None }
    }

    /// The values that its answer waits for.
    pub fn waiting(&self) -> impl Iterator<Item = f64> {
        self.took.into_iter().take(self.answer.waiting().into())
    }
}

/// Values that were taken, how many, which of them were limited.
pub type TakenValues = ([f64; TAKEN_MAX_VALUES], u8, u8);

/// Values for the reply, with their number.
pub fn taken_values(values: &[f64], limited: u8) -> TakenValues {
    let mut all = [0.0; TAKEN_MAX_VALUES];
    for (slot, value) in all.iter_mut().zip(values) {
        *slot = *value;
    }
    (all, values.len() as u8, limited)
}
