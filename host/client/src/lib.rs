#![forbid(unsafe_code)]
//! The Rust client: links, typed calls, programs.
//!
//! ```no_run
//! use client::{Client, Options};
//! use protocol::command::{AxisOn, GetPrfPos};
//! # fn main() -> client::Result<()> {
//! let link = client::link::open("tcp:127.0.0.1:5000")?;
//! let client = Client::open(link, Options::default())?;
//! client.call(AxisOn { core: 1.into(), axis: 1.into() })?;
//! let read = GetPrfPos { core: 1.into(), profile: 1.into(), count: 8.into() };
//! let (_, positions) = client.call_items(read, &[])?;
//! println!("axis 1 is at {}", positions[0].value);
//!
//! // Timed calls: entries of the controller's program queue.
//! let mut program = client.program();
//! program.push(protocol::command::Sleep { ns: 1_000_000.into() });
//! program.push(AxisOn { core: 1.into(), axis: 2.into() });
//! let summary = program.run(false, &mut client::Quiet)?;
//! assert_eq!(summary.failed, None);
//! # Ok(()) }
//! ```
//!
//! Calls may come from several threads at once. Every failure is an [`Error`] with a return code of
//! SPEC 3 and a reason.
pub mod error;
pub mod inputs;
pub mod joined;
pub mod link;
pub mod qemu;
pub mod serial;
pub mod tcp;
pub mod viewers;

mod call;
mod client;
mod options;
mod program;
mod session;

pub use call::{Call, decode, refused};
pub use client::Client;
pub use error::{Error, Result};
pub use link::Link;
pub use options::{Family, Options, ProductProfile};
pub use program::{Answer, Dry, Observer, Program, Progress, Quiet, Summary};
pub use protocol::link::LinkCounters;
pub use protocol::reason::laser_cause;
