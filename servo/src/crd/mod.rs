//! Coordinate systems in the tick: axes that a [`Path`](crate::path::Path) drives.
//!
//! In: a [`Frame`] each, entries in two FIFOs, operations, the axes as they stand. Out: set-points of the axes, what
//! entries do, with exact instants; what the thread sees ([`crate::view::CrdView`]). Owns the paths. Fails: never; a
//! path that must not go on stops, with a reason.
mod frame;

pub use frame::{Frame, Refused};
