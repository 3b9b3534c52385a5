//! Evaluators of axes: PT, PVT, ramps (Jog, Trap, Stop) and Follow, each of them a sequence of pieces.
//!
//! In: segments, tables, masters. Out: for each tick the set-point and the motion of an axis. [`profile`] is the sequence in force,
//! [`piece`] one cubic of it.
pub mod follow;
pub mod piece;
pub mod profile;
pub mod pt;
pub mod pvt;
pub mod ramp;
