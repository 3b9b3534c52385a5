//! What happens at a second client, on a wire that the link is not on: the other wire of a board
//! that has two, or a further connection to a served controller. A client may ask there for the
//! session. It gets it once the present session is dead; before that it learns who has it.
//!
//! In: bytes of that wire. Out: answers to a Hello, and that a session was taken over there; then
//! the board exchanges the two. Owns one short frame each way.
//! Fails: frames of any other kind, or too long for the opening, are ignored. Two clients never
//! share a session.
use super::server::Server;
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::OPENING_WIRE;
use protocol::link::TakeOver;
use servo::units::Ns;

servo::state! {
    /// See the module text.
    #[derive(Debug)]
    pub struct SecondaryTransport {
        deframer: Deframer<OPENING_WIRE> = Deframer::new(),
        /// Begins with a delimiter: the wire may have been left in the middle of a frame.
        answer: [u8; 1 + OPENING_WIRE] = [0; 1 + OPENING_WIRE],
        from: usize = 0,
        to: usize = 0,
    }
    /// Nobody has asked.
    pub const fn new();
}

impl SecondaryTransport {
    /// Takes bytes: all of them, or, with true, those up to the end of the frame that took over the
    /// session. The others are for [`Server::feed`]. `holder` names the wire of the link; none if
    /// it is gone.
    pub fn feed<const AXES: usize>(
        &mut self,
        now: Ns,
        server: &mut Server<AXES>,
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
            match server.request_take_over(now, self.deframer.frame(), holder, &mut answer) {
                TakeOver::Nothing => {}
                // An answer that is partly sent goes first; a client asks again.
                TakeOver::Answered(length) if self.from == self.to => {
                    for (slot, byte) in self.answer.iter_mut().skip(1).zip(answer) {
                        *slot = byte;
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

    /// Bytes to be sent over this wire; returns how many were written into `out`.
    pub fn take_tx(&mut self, out: &mut [u8]) -> usize {
        let waiting = self.answer.get(self.from..self.to).unwrap_or(&[]);
        let count = waiting.len().min(out.len());
        for (slot, &byte) in out.iter_mut().zip(waiting) {
            *slot = byte;
        }
        self.from = self.from.saturating_add(count);
        count
    }
}
