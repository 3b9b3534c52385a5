#![forbid(unsafe_code)]
//! Tests across the seams of the rooms: see `tests/`.
pub mod laser_model;
pub mod light_judge;
pub mod light_model;
pub mod module_graph;
pub mod optimum;
pub mod path_model;
pub mod reference;
