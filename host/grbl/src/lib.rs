#![forbid(unsafe_code)]
//! A Grbl 1.1 controller in front of Beamtick: G-code senders as they are.
//!
//! In: bytes of a sender, a client of the controller, the machine. Out: what Grbl 1.1 would answer.
//! Owns the client's session: positions are known as long as the port is open. Fails: when the link
//! to the controller does. `docs/grbl.md` is the user's page.
//!
//! `wire` is for connections; `session` makes lines and real-time commands of bytes. `dollar` is
//! for the lines that begin with `$`, `report` for what `?` answers, `settings` for what `$$`
//! lists. `errors` has Grbl's numbers. `entry` makes entries of the path of lines, `records` joins
//! what travels together, `feeder` sends entries to the controller.
mod dollar;
mod entry;
mod errors;
mod feeder;
mod records;
mod report;
mod session;
mod settings;
mod wire;

pub use feeder::Pace;
pub use wire::{Channel, Local, Port, Served, serve};
