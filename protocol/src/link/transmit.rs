//! Sending: numbers messages, keeps them until they are acknowledged, decides what is sent next.
//!
//! Round-trip time and time-outs follow RFC 6298 (messages sent again are not timed). A message is
//! sent again early when the receiver reports a gap twice, and one by one after a loss of several
//! (as RFC 6582).

use super::{Endpoint, LinkState, Opening, RETRY_FIRST_NS, RETRY_MAX_NS, RETRY_MIN_NS, Role};
use crate::Ns;
use crate::frame::{self, Busy, FLAG_GAP, FLAG_READ_ONLY, FrameKind, Header, Hello, MAX_PAYLOAD};
use zerocopy::IntoBytes;

/// One message.
#[derive(Debug, Clone, Copy)]
pub(super) struct SentMessage {
    pub(super) bytes: [u8; MAX_PAYLOAD],
    pub(super) len: usize,
    /// Receiver: it came and is not taken yet.
    pub(super) full: bool,
}

impl SentMessage {
    pub(super) const EMPTY: SentMessage = SentMessage { bytes: [0; MAX_PAYLOAD], len: 0, full: false };

    pub(super) fn message(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }
}

/// Distance from `b` to `a` in sequence numbers, if `a` is not before `b`.
pub(super) fn ahead(a: u16, b: u16) -> Option<u16> {
    let distance = a.wrapping_sub(b);
    (distance < 0x8000).then_some(distance)
}

/// `base <= sent <= next` in sequence numbers, and at most `WINDOW` from `base` to `next`.
#[derive(Debug, Clone)]
pub(super) struct Transmitter<const WINDOW: usize> {
    slots: [SentMessage; WINDOW],
    /// First message not acknowledged.
    base: u16,
    /// First message never sent.
    sent: u16,
    /// Number of the next message.
    next: u16,
    /// First number that the receiver has no room for.
    edge: u16,
    /// `base` is to be sent again.
    resend: bool,
    /// The first number never sent when a loss was detected. Until it is acknowledged, every step
    /// of the acknowledgement shows the next message missing.
    recover: Option<u16>,
    /// Reports of a gap at `base`, and whether they have been acted upon.
    gaps: u8,
    hurried: bool,
    retry: Ns,
    retry_at: Option<Ns>,
    /// Smoothed round trip and its deviation; `None` before the first measurement.
    round_trip: Option<(Ns, Ns)>,
    timed: Option<(u16, Ns)>,
}

impl<const WINDOW: usize> Transmitter<WINDOW> {
    pub(super) const fn new() -> Self {
        Transmitter {
            slots: [SentMessage::EMPTY; WINDOW],
            base: 0,
            sent: 0,
            next: 0,
            edge: 0,
            resend: false,
            recover: None,
            gaps: 0,
            hurried: false,
            retry: RETRY_FIRST_NS,
            retry_at: None,
            round_trip: None,
            timed: None,
        }
    }

    /// Forgets all messages; the receiver has room for `window`.
    pub(super) fn reset(&mut self, window: u16) {
        self.base = 0;
        self.sent = 0;
        self.next = 0;
        self.edge = window.min(64);
        self.resend = false;
        self.recover = None;
        self.gaps = 0;
        self.hurried = false;
        self.retry = RETRY_FIRST_NS;
        self.retry_at = None;
        self.round_trip = None;
        self.timed = None;
    }

    pub(super) fn room(&self) -> usize {
        WINDOW.saturating_sub(usize::from(self.next.wrapping_sub(self.base)))
    }

    pub(super) fn has_room(&self) -> bool {
        self.room() > 0
    }

    pub(super) fn is_idle(&self) -> bool {
        self.base == self.next
    }

    fn slot(&mut self, sequence: u16) -> Option<&mut SentMessage> {
        self.slots.get_mut(usize::from(sequence) & WINDOW.wrapping_sub(1))
    }

    pub(super) fn draft(&mut self) -> Option<&mut [u8; MAX_PAYLOAD]> {
        if !self.has_room() {
            return None;
        }
        self.slot(self.next).map(|slot| &mut slot.bytes)
    }

    /// Takes the draft's first `len` bytes as the next message.
    pub(super) fn queue(&mut self, len: usize) -> bool {
        if !self.has_room() {
            return false;
        }
        let Some(slot) = self.slot(self.next) else { return false };
        slot.len = len;
        self.next = self.next.wrapping_add(1);
        true
    }

    /// Time-out: `true` if it makes `base` be sent again.
    pub(super) fn expire(&mut self, now: Ns) -> bool {
        if self.retry_at.is_none_or(|at| now < at) {
            return false;
        }
        self.resend = true;
        self.recover = Some(self.sent);
        self.retry = self.retry.saturating_mul(2).min(RETRY_MAX_NS);
        self.retry_at = Some(now.saturating_add(self.retry));
        true
    }

    pub(super) fn deadline(&self) -> Option<Ns> {
        self.retry_at
    }

    /// Handles an acknowledgement. `Err`: of a message never sent.
    pub(super) fn acknowledge(&mut self, now: Ns, header: &Header) -> Result<bool, ()> {
        let acknowledged = header.acknowledgement.get();
        let outstanding = self.sent.wrapping_sub(self.base);
        let Some(step) = ahead(acknowledged, self.base) else { return Ok(false) };
        if step > outstanding {
            return Err(());
        }
        let edge = acknowledged.wrapping_add(u16::from(header.credit.min(64)));
        if ahead(edge, self.edge).is_some() {
            self.edge = edge;
        }
        if step == 0 {
            return Ok(outstanding > 0 && header.flags & FLAG_GAP != 0 && self.hurry());
        }
        if let Some((sequence, at)) = self.timed
            && sequence.wrapping_sub(self.base) < step
        {
            self.measure(now.saturating_sub(at));
            self.timed = None;
        }
        self.base = acknowledged;
        self.gaps = 0;
        self.hurried = false;
        self.retry = self.retry_from_round_trip();
        self.recover = self.recover.filter(|&end| end != acknowledged && ahead(end, acknowledged).is_some());
        self.resend = self.recover.is_some();
        self.retry_at = (self.base != self.sent).then(|| now.saturating_add(self.retry));
        Ok(false)
    }

    /// The receiver reports `base` missing. The first report may be mere reordering; at the second
    /// `base` is sent again.
    fn hurry(&mut self) -> bool {
        self.gaps = self.gaps.saturating_add(1);
        if self.gaps < 2 || self.hurried {
            return false;
        }
        self.hurried = true;
        self.resend = true;
        self.recover = Some(self.sent);
        true
    }

    fn measure(&mut self, sample: Ns) {
        let (mean, deviation) = match self.round_trip {
            None => (sample, sample / 2),
            Some((mean, deviation)) => {
                let error = mean.abs_diff(sample);
                (mean - mean / 8 + sample / 8, deviation - deviation / 4 + error / 4)
            }
        };
        self.round_trip = Some((mean, deviation));
    }

    fn retry_from_round_trip(&self) -> Ns {
        match self.round_trip {
            None => RETRY_FIRST_NS,
            Some((mean, deviation)) => {
                mean.saturating_add(deviation.saturating_mul(4)).clamp(RETRY_MIN_NS, RETRY_MAX_NS)
            }
        }
    }

    /// Number of the next message to send, if there is one.
    fn pick(&mut self, now: Ns) -> Option<u16> {
        let sequence = if self.resend && self.base != self.sent {
            self.resend = false;
            self.timed = self.timed.filter(|&(timed, _)| timed != self.base);
            self.retry_at = Some(now.saturating_add(self.retry));
            self.base
        } else if self.sent != self.next && ahead(self.edge, self.sent).is_some_and(|room| room > 0) {
            let sequence = self.sent;
            self.sent = sequence.wrapping_add(1);
            self.timed = self.timed.or(Some((sequence, now)));
            self.retry_at = self.retry_at.or(Some(now.saturating_add(self.retry)));
            sequence
        } else {
            return None;
        };
        Some(sequence)
    }
}

/// For `exhaustive_delivery.rs`.
#[cfg(test)]
impl<const WINDOW: usize> Transmitter<WINDOW> {
    /// Everything that decides the further course of the transmitter; instants count from `now`.
    pub(super) fn state(&self, now: Ns, into: &mut std::vec::Vec<u8>) {
        for number in [self.base, self.sent, self.next, self.edge] {
            into.extend(number.to_le_bytes());
        }
        into.extend([self.resend.into(), self.recover.is_some().into(), self.gaps, self.hurried.into()]);
        into.extend(self.recover.unwrap_or(0).to_le_bytes());
        let at = |at: Ns| at.wrapping_sub(now);
        let (timed, since) = self.timed.unwrap_or((0, now));
        let (mean, deviation) = self.round_trip.unwrap_or((Ns::MAX, 0));
        into.extend([u8::from(self.timed.is_some()), self.retry_at.is_some().into()]);
        into.extend(timed.to_le_bytes());
        for time in [self.retry, self.retry_at.map_or(0, at), at(since), mean, deviation] {
            into.extend(time.to_le_bytes());
        }
        for ahead in 0..self.next.wrapping_sub(self.base) {
            let sequence = self.base.wrapping_add(ahead);
            into.extend(
                self.slots.get(usize::from(sequence) & WINDOW.wrapping_sub(1)).map_or(&[][..], SentMessage::message),
            );
        }
    }

    /// First message not acknowledged.
    pub(super) fn base(&self) -> u16 {
        self.base
    }
}

impl<const WINDOW: usize> Endpoint<WINDOW> {
    /// Writes the bytes to be sent now into `out`, as many frames as there are and fit. A frame may
    /// be cut; the next call continues it. Returns the bytes written; 0 when there is nothing to
    /// send.
    pub fn take_tx(&mut self, now: Ns, out: &mut [u8]) -> usize {
        let mut written = 0usize;
        self.poll(now);
        loop {
            let waiting = self.wire.get(self.wire_at..self.wire_len).unwrap_or(&[]);
            let room = out.get_mut(written..).unwrap_or(&mut []);
            let count = waiting.len().min(room.len());
            for (slot, &byte) in room.iter_mut().zip(waiting) {
                *slot = byte;
            }
            self.wire_at = self.wire_at.saturating_add(count);
            written = written.saturating_add(count);
            if self.wire_at < self.wire_len || !self.build(now) {
                return written;
            }
        }
    }

    /// Builds the next frame that is due: opening and Bye first, then messages, which carry
    /// acknowledgements, then a bare acknowledgement.
    fn build(&mut self, now: Ns) -> bool {
        self.wire_at = 0;
        self.wire_len = 0;
        if self.hello_due {
            self.hello_due = false;
            let hello = Hello { schema: self.identity.schema.into(), window: (WINDOW as u16).into() };
            return self.stage(FrameKind::Hello, self.nonce, hello.as_bytes());
        }
        if let Some((nonce, answer)) = self.answer.take() {
            return match answer {
                Opening::Ack(ack) => self.stage(FrameKind::HelloAck, nonce, ack.as_bytes()),
                Opening::Busy(why) => self.stage(FrameKind::Busy, nonce, Busy::new(0, 0, why.text()).as_bytes()),
            };
        }
        if let Some(session) = self.bye.take() {
            return self.stage(FrameKind::Bye, session, &[]);
        }
        match self.state {
            LinkState::Open => self.build_in_session(now),
            LinkState::Opening if self.keep_alive_due => {
                self.keep_alive_due = false;
                self.last_sent = now;
                self.stage(FrameKind::KeepAlive, self.session, &[])
            }
            LinkState::Opening
            | LinkState::Closed
            | LinkState::Mismatch(_)
            | LinkState::Busy(_)
            | LinkState::NoReadOnly
            | LinkState::Ended => false,
        }
    }

    fn build_in_session(&mut self, now: Ns) -> bool {
        let keep_alive = self.keep_alive_due && self.role == Role::Client;
        if let Some(sequence) = self.transmitter.pick(now) {
            let mut header = self.header(FrameKind::Data, self.session);
            header.sequence = sequence.into();
            self.note_sent(now);
            let Some(slot) = self.transmitter.slot(sequence) else { return false };
            self.wire_len = frame::encode(header, slot.message(), &mut self.wire).unwrap_or(0);
            return self.wire_len > 0;
        }
        if keep_alive || self.receiver.acknowledge_due() {
            let kind = if keep_alive { FrameKind::KeepAlive } else { FrameKind::Ack };
            let staged = self.stage(kind, self.session, &[]);
            self.note_sent(now);
            return staged;
        }
        false
    }

    /// A frame of the session is sent: it carries acknowledgement and credit, and keeps alive.
    fn note_sent(&mut self, now: Ns) {
        self.receiver.acknowledged();
        self.keep_alive_due = false;
        self.last_sent = now;
    }

    pub(super) fn header(&self, kind: FrameKind, session: u32) -> Header {
        let gap = if self.receiver.has_gap() { FLAG_GAP } else { 0 };
        let reads = match kind {
            FrameKind::Hello => self.read_only,
            FrameKind::HelloAck => self.role == Role::ReadOnly,
            _ => false,
        };
        Header {
            version: self.identity.version,
            kind: kind as u8,
            flags: gap | if reads { FLAG_READ_ONLY } else { 0 },
            credit: self.receiver.credit(),
            session: session.into(),
            sequence: 0.into(),
            acknowledgement: self.receiver.next().into(),
            length: 0.into(),
        }
    }

    fn stage(&mut self, kind: FrameKind, session: u32, payload: &[u8]) -> bool {
        let header = self.header(kind, session);
        self.wire_len = frame::encode(header, payload, &mut self.wire).unwrap_or(0);
        self.wire_len > 0
    }
}
