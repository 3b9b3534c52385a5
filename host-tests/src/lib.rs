//! Tests across the seams of the rooms: see `tests/`.
