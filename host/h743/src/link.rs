//! The client's link to the emulated board: in lockstep, time passes only while the client waits,
//! as with the virtual controller.
use crate::machine::Machine;
use crate::time::{MICROSECOND, Time, from_nanoseconds, nanoseconds};
use client::{Error, Link, error};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A machine that a link and its user share.
pub type Shared = Arc<Mutex<Machine>>;

/// The machine, whoever panicked with it.
pub fn lock(machine: &Shared) -> MutexGuard<'_, Machine> {
    machine.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long the board runs between two looks at what it has sent.
const SLICE: Time = 50 * MICROSECOND;

/// See the module text.
pub struct EmulatedLink {
    machine: Shared,
    /// Over USB, not over the USART.
    usb: bool,
    received: Vec<u8>,
    taken: usize,
    pulled: Plug,
}

/// The plug of a link's cable: once it is pulled, the client reaches no controller, and cannot
/// close its session.
#[derive(Debug, Clone, Default)]
pub struct Plug(Arc<AtomicBool>);

impl Plug {
    /// Pulls it, for good.
    pub fn pull(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn check(&self) -> client::Result<()> {
        if self.0.load(Ordering::Relaxed) {
            return Err(Error::new(error::LINK_SEND, "the cable is pulled"));
        }
        Ok(())
    }
}

impl EmulatedLink {
    /// A link to this board, over its USART.
    pub fn new(machine: Shared) -> Self {
        EmulatedLink { machine, usb: false, received: Vec::new(), taken: 0, pulled: Plug::default() }
    }

    /// What pulls this link's cable.
    pub fn plug(&self) -> Plug {
        self.pulled.clone()
    }

    /// A link to this board, over its USB.
    pub fn over_usb(machine: Shared) -> Self {
        EmulatedLink { usb: true, ..EmulatedLink::new(machine) }
    }
}

impl Link for EmulatedLink {
    fn name(&self) -> &str {
        "h743"
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        self.pulled.check()?;
        let mut machine = lock(&self.machine);
        if self.usb {
            machine.send_usb(bytes)
        } else {
            machine.send(bytes)
        }
        Ok(())
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        self.pulled.check()?;
        if self.taken == self.received.len() {
            self.received.clear();
            self.taken = 0;
            let mut machine = lock(&self.machine);
            let end = machine.chip.now + from_nanoseconds(wait.as_nanos() as u64);
            loop {
                let sent = if self.usb { machine.take_sent_usb() } else { machine.take_sent() };
                self.received.extend(sent.into_iter().map(|(_, byte)| byte));
                let left = end.saturating_sub(machine.chip.now);
                if !self.received.is_empty() || left == 0 {
                    break;
                }
                machine.run(left.min(SLICE));
            }
        }
        let left = &self.received[self.taken..];
        let n = left.len().min(buf.len());
        buf[..n].copy_from_slice(&left[..n]);
        self.taken += n;
        Ok(n)
    }

    fn now(&mut self) -> u64 {
        nanoseconds(lock(&self.machine).chip.now)
    }

    fn is_boards_usb(&mut self) -> bool {
        self.usb
    }

    fn real_time(&self) -> bool {
        false
    }

    fn trace_rate(&self) -> u32 {
        // Half of what the cable carries at ten bits a byte; the other half is for calls and their
        // replies.
        (crate::usart::Usart::HOST_BAUD / 20) as u32
    }
}
