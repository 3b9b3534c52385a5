//! A client's link to a virtual controller: in lockstep, time passes only while the client waits.
use crate::board::Board;
use client::Link;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A board that a link and its user share.
pub type Shared = Arc<Mutex<Board>>;

/// Makes a board sharable.
pub fn share(board: Board) -> Shared {
    Arc::new(Mutex::new(board))
}

/// See the module text.
pub struct VirtualLink {
    board: Shared,
    received: Vec<u8>,
    taken: usize,
}

impl VirtualLink {
    /// A link to this board.
    pub fn new(board: Shared) -> Self {
        VirtualLink { board, received: Vec::new(), taken: 0 }
    }

    /// Advances the controller by `time`; keeps the bytes that arrive meanwhile.
    pub fn run(&mut self, time: Duration) {
        let mut board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
        let end = board.now().saturating_add(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
        while board.now() < end {
            let left = end - board.now();
            board.advance(left, &mut self.received);
        }
    }
}

impl Link for VirtualLink {
    fn name(&self) -> &str {
        "virtual"
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner).feed(bytes);
        Ok(())
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        if self.taken == self.received.len() {
            self.received.clear();
            self.taken = 0;
            let mut board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
            board.take_tx(&mut self.received);
            if self.received.is_empty() {
                let ns = u64::try_from(wait.as_nanos()).unwrap_or(u64::MAX);
                board.advance(ns, &mut self.received);
            }
        }
        let left = &self.received[self.taken..];
        let n = left.len().min(buf.len());
        buf[..n].copy_from_slice(&left[..n]);
        self.taken += n;
        Ok(n)
    }

    fn now(&mut self) -> u64 {
        self.board.lock().unwrap_or_else(PoisonError::into_inner).now()
    }

    fn real_time(&self) -> bool {
        false
    }

    fn has_trace(&self) -> bool {
        true
    }

    fn take_trace(&mut self, out: &mut Vec<u8>) -> client::Result<()> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner).take_trace(out);
        Ok(())
    }
}
