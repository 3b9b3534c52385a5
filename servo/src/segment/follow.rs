//! Follow, FollowEx and Gear: the master's displacement takes the place of time (SPEC 5; GXN
//! chapter 3).
//!
//! In: data admitted by integer checks into [`FollowEntry`]s (`entry.rs`), which lie in the axis's
//! PT arena (`store.rs`); the master's motion within a tick (`master_path.rs`). Out: the slave's
//! planned position, and its own motion within the tick for its slaves (`follower.rs`). Owns: a
//! running motion, [`FollowRun`] (`evaluator.rs`), which makes pieces over the master's progress
//! (`curve.rs`), or goes in a ratio (`gear.rs`). Fails: a datum that no axis could run is
//! [`Refused`] before it reaches the store. A wait may time out; a jump may be too far.
//!
//! Held by `tests/follow_exact.rs` (positions ≤ 2⁻¹⁶ pulse, knots exact, ratios ≤ 2⁻¹⁶ of the
//! peak), `follow_tick.rs`, `follow_entries.rs`, `gear_exact.rs`.
mod compact;
mod curve;
mod entry;
mod evaluator;
mod follower;
mod gear;
mod master_path;
mod order;
mod ratio;
mod setup;
mod slave_track;
mod store;
mod velocity;

pub use entry::{ENTRIES, FifoTail, FollowChain, FollowEntry, Input, Refused, SCurvePart, STOPS};
pub use evaluator::{ACTIONS, FollowContext, FollowRun, FollowState, OutputActions, PackedWait, WaitCondition};
pub use follower::Follower;
pub(crate) use follower::{MasterPathKind, MasterSample, share};
pub use gear::{GearRatio, GearRefused};
pub use master_path::{MasterPath, POSITIONS_MAX, PositionTrack, TimedPosition};
pub(crate) use order::SlaveOrder;
pub use setup::Setup;
pub use store::FollowEntries;
pub use velocity::Lead;
pub(crate) use velocity::{compose, of as motion_of, slave_velocity, straight};

use crate::units::Axis;

/// What a slave follows, of any axis of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Master {
    /// The axis, counted over all cores.
    pub axis: Axis,
    /// Which of its positions.
    pub value: MasterPosition,
}

/// The position of the master that counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MasterPosition {
    /// The planned position.
    Planned,
    /// The encoder, linear between its samples.
    Encoder,
    /// The planned position, filtered.
    PlannedFiltered,
    /// The encoder, filtered.
    EncoderFiltered,
}

/// What begins the motion after FollowStart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartEvent {
    /// FollowStart itself (power-on).
    #[default]
    Start,
    /// The master's crossing of a position.
    Pass {
        /// From below to at or above; else from above to at or below.
        up: bool,
        /// The position, pulses.
        pos: i32,
    },
}

/// Which of the master's motion counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// Both: the slave is a function of the progress, forwards and backwards (power-on).
    #[default]
    Both,
    /// The furthest point reached upwards.
    Up,
    /// The furthest point reached downwards.
    Down,
}

/// Where SwitchNow goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The next segment; in the last one it ends the pass.
    Segment,
    /// The other FIFO.
    Table,
}
