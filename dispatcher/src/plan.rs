//! What is computed ahead of the tick in doubles: geometry and look-ahead of paths, PVT tables, the
//! asymmetric S-curve of FollowEx.
//!
//! In: what users give. Out: entries and table points in the tick's units.
pub mod asymmetric_s;
pub mod geometry;
pub mod look_ahead;
pub(crate) mod path_queue;
pub mod pvt;
