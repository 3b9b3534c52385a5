//! A client's way to an emulated board, which writes down what goes over it and may be cut.
use client::Link;
use h743::link::{EmulatedLink, Shared};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// See the module text.
pub struct Road {
    link: EmulatedLink,
    /// What has passed.
    pub sent: Arc<Mutex<Vec<u8>>>,
    /// Bytes that still pass, then it is cut both ways.
    pub left: Arc<Mutex<usize>>,
    /// After a cut nobody is waited for: the client's time runs ahead, ns.
    ahead: u64,
}

impl Road {
    /// A way over the board's USART.
    pub fn to(machine: &Shared) -> Road {
        let link = EmulatedLink::new(machine.clone());
        Road { link, sent: Arc::default(), left: Arc::new(Mutex::new(usize::MAX)), ahead: 0 }
    }
}

/// Sends the frame of a call, and cuts the way then: the board has not run since. The call is made
/// once before, and `again` sends a frame of the same length.
pub fn send_unanswered(
    (sent, left): (&Mutex<Vec<u8>>, &Mutex<usize>),
    once: impl FnOnce() -> client::Result<()>,
    again: impl FnOnce() -> client::Result<()>,
) {
    sent.lock().unwrap().clear();
    once().unwrap();
    let length = sent.lock().unwrap().iter().position(|byte| *byte == 0).unwrap() + 1;
    *left.lock().unwrap() = length;
    assert!(again().is_err(), "its answer came");
    assert_eq!(*left.lock().unwrap(), 0);
}

impl Link for Road {
    fn name(&self) -> &str {
        self.link.name()
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        let mut left = self.left.lock().unwrap();
        let passes = &bytes[..bytes.len().min(*left)];
        *left -= passes.len();
        self.sent.lock().unwrap().extend_from_slice(passes);
        self.link.send(passes)
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        if *self.left.lock().unwrap() == 0 {
            self.ahead += 1_000_000_000;
            return Ok(0);
        }
        self.link.receive(buf, wait)
    }

    fn now(&mut self) -> u64 {
        self.link.now() + self.ahead
    }

    fn real_time(&self) -> bool {
        false
    }
}
