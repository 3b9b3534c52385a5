//! Evaluators of axes: PT, PVT, ramps (Jog, Trap, Stop) and Follow. Each one makes a sequence of
//! pieces.
//!
//! In: segments, tables, masters. Out: for each tick the set-point and the motion of an axis.
//! [`profile`] holds the sequence, [`piece`] is one cubic of it.
pub mod follow;
pub mod generator_state;
pub mod piece;
pub mod profile;
pub mod pt;
pub mod pvt;
pub mod ramp;
