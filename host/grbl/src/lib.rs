#![forbid(unsafe_code)]
//! A Grbl 1.1 controller in front of Beamtick: G-code senders as they are.
//!
//! In: bytes of a sender, a client of the controller, the machine. Out: what Grbl 1.1 would answer.
//! Owns the client's session: positions are known as long as the port is open. Fails: when the link
//! to the controller does. `docs/grbl.md` is the user's page.
//!
//! `wire` connections, `session` bytes to lines and real-time commands, `dollar` the lines that
//! begin with `$`, `report` what `?` answers, `settings` what `$$` lists, `errors` Grbl's numbers,
//! `entry` lines as entries of the path, `records` what travels together, `feeder` entries into the
//! controller.
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
pub use wire::{Port, Served, serve};
