#![forbid(unsafe_code)]
//! Hostile input: every target is a function of bytes that panics where a promise of SPEC 9 or 10
//! is broken.
//!
//! In: bytes, from libFuzzer (`cargo xtask fuzz`), from the kept corpus or from a seeded generator
//! (`tests/corpus.rs`, part of every test run). Out: nothing, or a panic that says what was seen.
//!
//! * [`link`]: bytes and re-sealed frames into a link's end.
//! * [`machine`]: commands, cuts, resets and faults into a running virtual controller, with a model
//!   of what was executed.
//! * [`tables`]: PVT, Follow, look-ahead and laser tables of any numbers, and the motion that they
//!   make.
//! * [`jobs`]: job scripts, compiled and run.
//! * [`config`]: configuration files, read and loaded.
//!
//! [`model`] is what `machine` knows of what must have been executed. [`bench`] is the controller
//! with its client and the line between them, [`guard`] is what holds in every tick. [`commands`]
//! makes requests by the table of the protocol, [`source`] gives the bytes as numbers.
pub mod bench;
pub mod commands;
pub mod config;
pub mod guard;
pub mod jobs;
pub mod link;
pub mod machine;
pub mod model;
pub mod scenes;
pub mod source;
pub mod tables;

/// A target: its name, and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: [Target; 5] = [
    ("link", link::run),
    ("machine", machine::run),
    ("jobs", jobs::run),
    ("config", config::run),
    ("tables", tables::run),
];
