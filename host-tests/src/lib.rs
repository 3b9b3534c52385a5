//! Tests across the seams of the rooms: see `tests/`.
pub mod laser_model;
