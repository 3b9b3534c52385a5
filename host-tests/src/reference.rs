//! A reference controller: the motion API of SPEC 4 and 5, plain and slow, in exact arithmetic.
//!
//! In: the calls of a program at their instants, and encoder samples. Out: return codes, values of
//! reads, and for every tick the machine position and the status of every axis. It is written from
//! the contract and the manuals and shares no code with the servo: a motion is a function of time,
//! and a slave is a function of its master's position.
//!
//! Plans are exact: velocities and ratios are rational numbers. A value at an instant is rounded
//! once, to 2⁻⁶⁴ pulse ([`Fix`]). What the contract leaves open is named by [`Reply::Open`], not
//! guessed.
#![allow(missing_docs, reason = "fields and variants have the manuals' names")]
mod axis;
mod call;
#[allow(clippy::should_implement_trait, reason = "numbers without an end are no iterator here")]
#[path = "../../servo/tests/chance/mod.rs"]
pub mod chance;
mod controller;
mod crd;
mod curve;
mod effect;
mod filter;
mod follow;
pub mod generator;
mod light;
mod number;
mod path;
mod pt;
mod pvt;
mod ramp;
mod rational;
mod slave;
#[cfg(test)]
mod tests;

pub use axis::{Axis, Mode, terminal};
pub use call::{Call, Kind, Setup};
pub use controller::{Controller, Edge, Program, Reply, Row, Session, Value};
pub use curve::Curve;
pub use effect::{Effect, Levels};
pub use follow::{Asymmetric, Datum, Item, mean};
pub use light::{Command, Family, GateEdge, LightCall, LightOf, LightTable};
pub use number::{Fix, exact};
pub use path::{Cycle, Path, PathCall, Speeds};
pub use pvt::Points;
pub use rational::Rational;
