//! The answer of a command that was admitted, until it has been executed.
use protocol::command::{PvtContinuousPoint, PvtPercentPoint};
use protocol::record::Full;
use servo::units::{Axis, Crd};

/// Whether a reply was written.
pub type Sent = Result<(), Full>;

/// Most points of a Calculate command, and values of its reply: as many as a message holds.
pub const MAX_POINTS: usize = protocol::record::BODY_MAX / size_of::<PvtPercentPoint>();
const _: () = assert!(size_of::<PvtPercentPoint>() <= size_of::<PvtContinuousPoint>());

/// Most values that a laser command takes.
pub const TAKEN_MAX_VALUES: usize = 4;

/// The answer of an admitted command once it has been executed.
#[derive(Debug, Clone, Copy)]
pub enum Answer {
    /// A reply without fields.
    Done,
    /// A read, to be built from the view and the shadow state of then.
    Read(Query),
    /// The result of a read at admission: free slots of a FIFO that nothing changes meanwhile.
    Space(i16),
    /// PtTaken for `count` segments of this axis and FIFO.
    Taken { axis: Axis, fifo: u8, count: u16 },
    /// CrdTaken for `count` entries of this FIFO of a coordinate system.
    Path { crd: Crd, fifo: u8, count: u16, lasts_ms: u32 },
    /// CrdTaken for `count` calls of a PathMany, and what its lane keeps of their own replies.
    Joined { crd: Crd, fifo: u8, count: u16, lasts_ms: u32, values: u8 },
    /// None: so many calls of a PathMany were executed, and the others follow.
    Part(u16),
    /// A number that only the shadow state has.
    Long(i32),
    /// A refusal: the tick did not take the data of this axis, whose status is given.
    Lost { axis: Axis, status: u32 },
    /// Free slots of a FIFO of Follow, and for FollowDataPercent2Ex the share of the first half,
    /// percent.
    Entered { axis: Axis, fifo: u8, percent1: i16 },
    /// A number that was computed at admission.
    Number(f64),
    /// `count` of the values that the program lane keeps: a Calculate command.
    Values(u8),
    /// The values that a laser command took: `count` of those that its lane keeps, and which of
    /// them were limited.
    Took { count: u8, limited: u8 },
}

impl Answer {
    /// Values that wait in the lane for this answer.
    pub fn waiting(&self) -> u8 {
        match *self {
            Answer::Values(count) | Answer::Took { count, .. } | Answer::Joined { values: count, .. } => count,
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

/// What in the tick refused an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refuser {
    /// Nobody: the entry was late and the program is strict.
    Nobody,
    /// An axis with this status.
    Axis(Axis, u32),
    /// A coordinate system.
    Crd(Crd),
    /// A laser channel that a fault keeps dark.
    Laser(u8),
    /// As many outputs as can keep a level for a time.
    Outputs,
}
