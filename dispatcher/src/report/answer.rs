//! What is to be answered when a command has been executed.
use protocol::command::{PvtContinuousPoint, PvtPercentPoint};
use servo::units::{Axis, Crd};

/// Most points of a Calculate command, and values of its reply: what a message holds of them.
pub const POINTS_MAX: usize = protocol::record::BODY_MAX / size_of::<PvtPercentPoint>();
const _: () = assert!(size_of::<PvtPercentPoint>() <= size_of::<PvtContinuousPoint>());

/// What is to be answered when an admitted command has been executed.
#[derive(Debug, Clone, Copy)]
pub enum Answer {
    /// A reply without fields.
    Done,
    /// A read, to be built from the view and the books of then.
    Read(Query),
    /// What a read gave at admission: places free in a FIFO that nothing changes meanwhile.
    Space(i16),
    /// PtTaken for so many segments of this axis and FIFO.
    Taken { axis: Axis, fifo: u8, count: u16 },
    /// CrdTaken for so many entries of this FIFO of a coordinate system.
    Path { crd: Crd, fifo: u8, count: u16, lasts_ms: u32 },
    /// A number that only the books have.
    Long(i32),
    /// A refusal: the tick did not take the data of this axis, whose status is that.
    Lost { axis: Axis, status: u32 },
    /// Places free in a FIFO of Follow, and for FollowDataPercent2Ex the share of the first half, percent.
    Entered { axis: Axis, fifo: u8, percent1: i16 },
    /// A number that was computed at admission.
    Number(f64),
    /// So many values of those that the program lane keeps: a Calculate command.
    Values(u8),
    /// What a laser command took: so many numbers of those that its lane keeps, and which of them were held.
    Took { count: u8, held: u8 },
}

impl Answer {
    /// Numbers that wait in the lane for this answer.
    pub fn waiting(&self) -> u8 {
        match *self {
            Answer::Values(count) | Answer::Took { count, .. } => count,
            _ => 0,
        }
    }
}

/// A checked read.
#[derive(Debug, Clone, Copy)]
pub struct Query {
    /// Which command.
    pub opcode: u16,
    /// Index of the first axis over all cores, or of the channel.
    pub first: u8,
    /// How many.
    pub count: u8,
    /// FIFO or type, where the command has one.
    pub which: u8,
}
