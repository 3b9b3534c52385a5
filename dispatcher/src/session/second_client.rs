//! A wire that the link is not on: the other one of a board that has two, a further connection to a served controller.
//! A client may ask there for the session; it gets it once the one in force is alive no more, and is told whose it is before.
//!
//! In: bytes of that wire. Out: answers to a Hello, and that a session has been taken up there; then
//! the board exchanges the two. Owns one short frame each way. Frames of any other kind, or too long for the opening, are
//! passed over: two clients never share a session.
use crate::Server;
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::OPENING_WIRE;
use protocol::link::TakeOver;
use servo::units::Ns;

/// See the module text.
#[derive(Debug)]
pub struct SecondaryTransport {
    deframer: Deframer<OPENING_WIRE>,
    /// Behind a delimiter: the wire may have been left in the middle of a frame.
    answer: [u8; 1 + OPENING_WIRE],
    from: usize,
    to: usize,
}

impl Default for SecondaryTransport {
    fn default() -> Self {
        Self::new()
    }
}

impl SecondaryTransport {
    /// Nobody has asked.
    pub const fn new() -> Self {
        SecondaryTransport { deframer: Deframer::new(), answer: [0; 1 + OPENING_WIRE], from: 0, to: 0 }
    }

    /// Takes bytes: all of them, or, with true, those up to the end of the frame that has taken up the session. The others are
    /// for [`Server::feed`]. `holder` names the wire that the link is on; none if it is gone.
    pub fn feed<const AXES: usize>(
        &mut self,
        now: Ns,
        server: &mut Server<'_, AXES>,
        holder: Option<&str>,
        bytes: &[u8],
    ) -> (usize, bool) {
        let mut used = 0usize;
        while let Some(remainder) = bytes.get(used..).filter(|remainder| !remainder.is_empty()) {
            let (taken, outcome) = self.deframer.feed(remainder);
            used = used.saturating_add(taken);
            if outcome != Outcome::Frame {
                continue;
            }
            let mut answer = [0; OPENING_WIRE];
            match server.knock(now, self.deframer.frame(), holder, &mut answer) {
                TakeOver::Nothing => {}
                // One that is half out goes first; a client asks again.
                TakeOver::Answered(length) if self.from == self.to => {
                    for (place, byte) in self.answer.iter_mut().skip(1).zip(answer) {
                        *place = byte;
                    }
                    (self.from, self.to) = (0, length.saturating_add(1));
                }
                TakeOver::Answered(_) => {}
                TakeOver::TakenUp => {
                    *self = SecondaryTransport::new();
                    return (used, true);
                }
            }
        }
        (used, false)
    }

    /// Bytes to be sent over this wire; returns how many were put into `out`.
    pub fn take_tx(&mut self, out: &mut [u8]) -> usize {
        let waiting = self.answer.get(self.from..self.to).unwrap_or(&[]);
        let count = waiting.len().min(out.len());
        for (place, &byte) in out.iter_mut().zip(waiting) {
            *place = byte;
        }
        self.from = self.from.saturating_add(count);
        count
    }
}
