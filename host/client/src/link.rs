//! Roads for bytes: the [`Link`] trait, and [`open`] which builds one from its name.
//!
//! In: bytes to send, a waiting time. Out: bytes received, trace bytes. A link owns its port and
//! closes it when dropped. Failures are [`Error`]s with the codes −1, −2, −3 and −6.
use crate::error::{Error, Result};
use crate::{qemu, serial, tcp};
use std::time::Duration;

/// Bytes of trace a second that a network or USB link can carry in addition to calls. An Ethernet
/// of 100 Mbit/s carries ten times as much; the controller's window and the round trip limit it.
pub const TRACE_RATE: u32 = 1_000_000;

/// A road for bytes to one controller.
pub trait Link: Send {
    /// What a person calls it: `tcp:127.0.0.1:5000`.
    fn name(&self) -> &str;
    /// Sends all bytes.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;
    /// Receives what is there, waiting at most `wait` for the first byte. 0: nothing came.
    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> Result<usize>;
    /// The time by which this link's answers are awaited, in ns from anywhere: wall-clock time, or
    /// the virtual controller's own.
    fn now(&mut self) -> u64;
    /// Whether time passes by itself. A link in virtual time answers false: its time passes in
    /// [`Link::receive`] only, and no thread may pump it in the background.
    fn real_time(&self) -> bool {
        true
    }
    /// Whether this is the port of a board's own USB, and no adapter's: its product says so.
    fn is_boards_usb(&mut self) -> bool {
        false
    }
    /// How many times longer than a board's its answers may take: an emulated board waits for its
    /// host.
    fn patience(&self) -> u32 {
        1
    }
    /// Whether this link carries a trace stream.
    fn has_trace(&self) -> bool {
        false
    }
    /// Bytes of trace a second that the link carries beside calls, where it has no stream for them.
    fn trace_rate(&self) -> u32 {
        TRACE_RATE
    }
    /// Moves the trace bytes received since the last call to the end of `out`.
    fn take_trace(&mut self, out: &mut Vec<u8>) -> Result<()> {
        let _ = out;
        Ok(())
    }
}

/// Opens a link by its name: `tcp:HOST:PORT`, `serial:PATH[:BAUD]`, `qemu:IMAGE`.
///
/// The virtual controller's link is made by `virtual_board::VirtualLink`.
pub fn open(name: &str) -> Result<Box<dyn Link>> {
    match name.split_once(':') {
        Some(("tcp", address)) => Ok(Box::new(tcp::TcpLink::connect(address)?)),
        Some(("serial", port)) => Ok(Box::new(serial::SerialLink::open(port)?)),
        Some(("qemu", image)) => Ok(Box::new(qemu::QemuLink::start(&qemu::Machine::new(image))?)),
        _ => Err(Error::cannot_open(name, "a link is tcp:HOST:PORT, serial:PATH[:BAUD] or qemu:IMAGE")),
    }
}

/// What is wrong with the rate of a serial port's name, if anything is.
pub fn wrong_rate(name: &str) -> Option<String> {
    serial::parts(name.strip_prefix("serial:")?).err()
}

/// Whether a link is a serial port that this computer does not have.
pub fn is_missing(name: &str) -> bool {
    name.strip_prefix("serial:").is_some_and(serial::is_missing)
}
