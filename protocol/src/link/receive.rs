//! Receiving: checks frames, advances the opening, puts messages in order and drops duplicates.

use super::transmit::{SentMessage, ahead};
use super::{
    ALIVE_NS, Endpoint, HELLO_NS, Identity, LinkState, NoSession, Offer, Opening, Role, SessionPhase, TakeOver,
};
use crate::Ns;
use crate::deframe::Outcome;
use crate::frame::{self, Busy, FLAG_READ_ONLY, Fault, FrameKind, Header, Hello, HelloAck, OPENING_WIRE};
use zerocopy::{FromBytes, IntoBytes};

/// `take <= next` in sequence numbers; slots hold messages from `take` on, with holes from `next`
/// on.
#[derive(Debug, Clone)]
pub(super) struct Receiver<const WINDOW: usize> {
    slots: [SentMessage; WINDOW],
    /// The message that the user gets next.
    take: u16,
    /// First message not received.
    next: u16,
    /// Full slots.
    held: u16,
    /// First number that the last announcement had no room for.
    announced: u16,
    due: bool,
}

/// How a message was handled.
enum Accepted {
    New(u16),
    Duplicate,
    Beyond,
}

impl<const WINDOW: usize> Receiver<WINDOW> {
    pub(super) const fn new() -> Self {
        Receiver {
            slots: [SentMessage::EMPTY; WINDOW],
            take: 0,
            next: 0,
            held: 0,
            announced: WINDOW as u16,
            due: false,
        }
    }

    pub(super) fn reset(&mut self) {
        for slot in &mut self.slots {
            slot.full = false;
        }
        self.take = 0;
        self.next = 0;
        self.held = 0;
        self.announced = WINDOW as u16;
        self.due = false;
    }

    pub(super) fn next(&self) -> u16 {
        self.next
    }

    fn edge(&self) -> u16 {
        self.take.wrapping_add(WINDOW as u16)
    }

    /// Room from `next` on; `WINDOW` is at most 64.
    pub(super) fn credit(&self) -> u8 {
        self.edge().wrapping_sub(self.next) as u8
    }

    pub(super) fn has_gap(&self) -> bool {
        self.held > self.next.wrapping_sub(self.take)
    }

    pub(super) fn acknowledge_due(&self) -> bool {
        self.due
    }

    /// An acknowledgement is sent soon, whether or not something is new.
    fn ask_acknowledgement(&mut self) {
        self.due = true;
    }

    /// Acknowledgement and credit were sent.
    pub(super) fn acknowledged(&mut self) {
        self.due = false;
        self.announced = self.edge();
    }

    pub(super) fn message(&self) -> Option<&[u8]> {
        if self.take == self.next {
            return None;
        }
        self.slots.get(usize::from(self.take) & WINDOW.wrapping_sub(1)).map(SentMessage::message)
    }

    pub(super) fn done(&mut self) {
        if self.take == self.next {
            return;
        }
        if let Some(slot) = self.slots.get_mut(usize::from(self.take) & WINDOW.wrapping_sub(1)) {
            slot.full = false;
        }
        self.take = self.take.wrapping_add(1);
        self.held = self.held.wrapping_sub(1);
        // Announce room to a sender that may be waiting for it, but not every single slot.
        let freed = usize::from(self.edge().wrapping_sub(self.announced));
        if self.announced == self.next || freed >= WINDOW.div_ceil(2) {
            self.due = true;
        }
    }

    fn accept(&mut self, sequence: u16, message: &[u8]) -> Accepted {
        self.due = true;
        let Some(distance) = ahead(sequence, self.take) else { return Accepted::Duplicate };
        if usize::from(distance) >= WINDOW {
            return Accepted::Beyond;
        }
        let Some(slot) = self.slots.get_mut(usize::from(sequence) & WINDOW.wrapping_sub(1)) else {
            return Accepted::Beyond;
        };
        if slot.full {
            return Accepted::Duplicate;
        }
        let Some(bytes) = slot.bytes.get_mut(..message.len()) else { return Accepted::Beyond };
        frame::copy(bytes, message);
        slot.len = message.len();
        slot.full = true;
        self.held = self.held.wrapping_add(1);
        let before = self.next;
        while self.next != self.edge()
            && self.slots.get(usize::from(self.next) & WINDOW.wrapping_sub(1)).is_some_and(|slot| slot.full)
        {
            self.next = self.next.wrapping_add(1);
        }
        Accepted::New(self.next.wrapping_sub(before))
    }
}

/// For `exhaustive_delivery.rs`.
#[cfg(test)]
impl<const WINDOW: usize> Receiver<WINDOW> {
    /// Everything that decides the further course of the receiver.
    pub(super) fn state(&self, into: &mut std::vec::Vec<u8>) {
        for number in [self.take, self.next, self.held, self.announced, self.due.into()] {
            into.extend(number.to_le_bytes());
        }
        for slot in &self.slots {
            into.push(slot.full.into());
            into.extend(if slot.full { slot.message() } else { &[] });
        }
    }
}

fn asks_read_only(header: &Header) -> bool {
    header.flags & FLAG_READ_ONLY != 0
}

fn count(counter: &mut u32) {
    *counter = counter.wrapping_add(1);
}

impl<const WINDOW: usize> Endpoint<WINDOW> {
    /// Takes received bytes, in any portions.
    pub fn feed(&mut self, now: Ns, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let (used, outcome) = self.deframer.feed(rest);
            rest = rest.get(used..).unwrap_or(&[]);
            if outcome == Outcome::Frame {
                self.receive(now);
            }
        }
    }

    /// For a controller with more than one wire: takes a decoded frame that came over a wire which
    /// the link is not on. A Hello is answered there, with the bytes written into `out`. A
    /// KeepAlive in the offered session begins it. From then on bytes of the other wire are not the
    /// link's, and a partly sent frame on it stays incomplete. Every other frame is ignored.
    ///
    /// `holder` names the link's own wire, or is `None` if nobody is there any more. While its
    /// session is alive ([`ALIVE_NS`]), a Hello is answered with Busy and no session begins.
    pub fn request_take_over(
        &mut self,
        now: Ns,
        frame: &[u8],
        holder: Option<&str>,
        out: &mut [u8; OPENING_WIRE],
    ) -> TakeOver {
        if self.role != Role::Controller {
            return TakeOver::Nothing;
        }
        let busy = holder.and_then(|holder| self.busy(now, holder));
        match frame::decode(frame) {
            Ok((header, FrameKind::Hello, payload)) => {
                let Ok(hello) = Hello::read_from_bytes(payload) else { return TakeOver::Nothing };
                let same = Identity { version: header.version, schema: hello.schema.get() } == self.identity;
                if let Some(busy) = busy.filter(|_| same && !asks_read_only(&header)) {
                    let header = self.header(FrameKind::Busy, header.session.get());
                    return frame::encode(header, busy.as_bytes(), out).map_or(TakeOver::Nothing, TakeOver::Answered);
                }
                // An answer for the link's own wire stays.
                let own = self.answer.take();
                self.answer_hello(&header, hello);
                let answer = core::mem::replace(&mut self.answer, own);
                let Some((nonce, Opening::Ack(answer))) = answer else { return TakeOver::Nothing };
                let header = self.header(FrameKind::HelloAck, nonce);
                frame::encode(header, answer.as_bytes(), out).map_or(TakeOver::Nothing, TakeOver::Answered)
            }
            Ok((header, FrameKind::KeepAlive, _))
                if busy.is_none() && self.offer.is_some_and(|offer| offer.session == header.session.get()) =>
            {
                self.deframer.reset();
                (self.wire_at, self.wire_len) = (0, 0);
                self.receive_in_session(now, &header, FrameKind::KeepAlive);
                TakeOver::TakenUp
            }
            _ => TakeOver::Nothing,
        }
    }

    /// The answer to a second client while the session of the one at `holder` is alive.
    fn busy(&self, now: Ns, holder: &str) -> Option<Busy> {
        let ms = |ns: Ns| u32::try_from(ns / 1_000_000).unwrap_or(u32::MAX);
        let silence = self.silence(now).filter(|silence| *silence < ALIVE_NS)?;
        Some(Busy::new(ms(now.saturating_sub(self.began)), ms(silence), holder))
    }

    fn receive(&mut self, now: Ns) {
        let (header, kind, payload) = match frame::decode(self.deframer.frame()) {
            Ok(parts) => parts,
            Err(fault) => {
                return count(match fault {
                    Fault::Short => &mut self.counters.short,
                    Fault::Checksum => &mut self.counters.checksum,
                    Fault::Version => &mut self.counters.version,
                    Fault::Kind => &mut self.counters.kind,
                    Fault::Length => &mut self.counters.length,
                });
            }
        };
        match (kind, self.role) {
            (FrameKind::Hello, Role::Controller | Role::ReadOnly) => {
                if let Ok(hello) = Hello::read_from_bytes(payload) {
                    self.answer_hello(&header, hello);
                }
            }
            (FrameKind::HelloAck, Role::Client) => {
                if let Ok(answer) = HelloAck::read_from_bytes(payload) {
                    self.take_offer(now, &header, answer);
                }
            }
            (FrameKind::Busy, Role::Client)
                if self.state == LinkState::Opening && header.session.get() == self.nonce =>
            {
                if let Ok(busy) = Busy::read_from_bytes(payload) {
                    self.forget(LinkState::Busy(busy));
                }
            }
            (FrameKind::Hello | FrameKind::HelloAck | FrameKind::Busy, _) => count(&mut self.counters.unexpected),
            (FrameKind::Data | FrameKind::Ack | FrameKind::KeepAlive | FrameKind::Bye, _) => {
                self.receive_in_session(now, &header, kind)
            }
        }
    }

    /// Controller: offers a session. Nothing else changes before the client confirms it.
    fn answer_hello(&mut self, header: &Header, hello: Hello) {
        let theirs = Identity { version: header.version, schema: hello.schema.get() };
        let nonce = header.session.get();
        let fits = asks_read_only(header) == (self.role == Role::ReadOnly);
        let session = if theirs != self.identity {
            count(&mut self.counters.mismatches);
            self.refused = Some(theirs);
            0
        } else if !fits && self.role == Role::ReadOnly {
            self.answer = Some((nonce, Opening::Busy(NoSession::ReadsOnly)));
            return;
        } else if !fits {
            0
        } else if self.state == LinkState::Open && nonce == self.nonce {
            self.session
        } else {
            let offer = match self.offer {
                Some(offer) if offer.nonce == nonce => offer,
                _ => self.new_offer(nonce, hello.window.get()),
            };
            self.offer = Some(offer);
            offer.session
        };
        let answer =
            HelloAck { schema: self.identity.schema.into(), window: (WINDOW as u16).into(), session: session.into() };
        self.answer = Some((nonce, Opening::Ack(answer)));
    }

    /// Every offer has its own id, also for a repeated nonce: bytes of an old session with the same
    /// nonce do not fit it.
    fn new_offer(&mut self, nonce: u32, window: u16) -> Offer {
        self.offers_made = self.offers_made.wrapping_add(1);
        let mixed = nonce.wrapping_mul(0x9E37_79B1) ^ self.offers_made.wrapping_mul(0x85EB_CA6B);
        let session = match mixed {
            0 => 1,
            id if id == self.session => id.wrapping_add(2).max(1),
            id => id,
        };
        Offer { nonce, session, window }
    }

    /// Client: begins the offered session, or learns that there will be none.
    fn take_offer(&mut self, now: Ns, header: &Header, answer: HelloAck) {
        let ours = header.session.get() == self.nonce;
        if self.state != LinkState::Opening || self.phase != SessionPhase::Asking || !ours {
            return count(&mut self.counters.unexpected);
        }
        let theirs = Identity { version: header.version, schema: answer.schema.get() };
        let session = answer.session.get();
        let reads = header.flags & FLAG_READ_ONLY != 0;
        if theirs != self.identity {
            count(&mut self.counters.mismatches);
            return self.forget(LinkState::Mismatch(theirs));
        }
        if self.read_only && (!reads || session == 0) {
            return self.forget(LinkState::NoReadOnly);
        }
        if reads && !self.read_only {
            return count(&mut self.counters.unexpected);
        }
        if session == 0 {
            return count(&mut self.counters.unexpected);
        }
        self.begin(now, self.nonce, session, answer.window.get());
        self.hello_due = false;
        self.phase = SessionPhase::Confirming(1);
        self.keep_alive_due = true;
        self.retry_at = now.saturating_add(HELLO_NS);
    }

    fn receive_in_session(&mut self, now: Ns, header: &Header, kind: FrameKind) {
        let session = header.session.get();
        let known = self.session != 0 && session == self.session;
        match (self.state, self.offer) {
            (LinkState::Open, _) if known => {}
            (LinkState::Opening, _) if known => self.state = LinkState::Open,
            (_, Some(offer)) if self.role != Role::Client && offer.session == session => {
                self.begin(now, offer.nonce, offer.session, offer.window);
                self.state = LinkState::Open;
            }
            _ => return count(&mut self.counters.stale_session),
        }
        self.last_valid = Some(now);
        match self.transmitter.acknowledge(now, header) {
            Ok(true) => count(&mut self.counters.fast_retransmits),
            Ok(false) => {}
            Err(()) => count(&mut self.counters.bad_acknowledgement),
        }
        match kind {
            FrameKind::Data => {
                let message = frame::payload(self.deframer.frame());
                match self.receiver.accept(header.sequence.get(), message) {
                    Accepted::New(more) => self.counters.received = self.counters.received.wrapping_add(more.into()),
                    Accepted::Duplicate => count(&mut self.counters.duplicates),
                    Accepted::Beyond => count(&mut self.counters.beyond_window),
                }
            }
            FrameKind::KeepAlive => self.receiver.ask_acknowledgement(),
            FrameKind::Bye => self.forget(LinkState::Ended),
            FrameKind::Ack | FrameKind::Hello | FrameKind::HelloAck | FrameKind::Busy => {}
        }
    }
}
