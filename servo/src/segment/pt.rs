//! PT: positions and times (SPEC 5; GXN chapter 2).
//!
//! In: the user's doubles, admitted by integer checks into [`Segment`]s (`segment.rs`), which lie
//! in a store that the thread fills and the tick reads (`store.rs`); instants. Out: pieces of
//! motion. Owns: the state of one running pass or stream, [`PtRun`] (`evaluator.rs`). Fails: a
//! datum that no axis could run is [`Refused`] before it reaches the store.
//!
//! The chain of velocities v1 = 2P/T − v0 neither decays nor may drift. So it is carried in
//! 2⁻⁸⁰ pulse/ms with every quotient to the nearest. After n segments it is within n·2⁻⁸¹ of the
//! rational number that the doubles define. That is 2⁻²⁶ pulse after 10⁷ segments of 2³¹ ms.
mod evaluator;
mod segment;
mod store;

pub use evaluator::{AllowedData, PtRun, SlotRange};
pub use segment::{Chain, Refused, Segment, SegmentKind};
pub use store::{SEGMENTS, SegmentStore, Segments};
