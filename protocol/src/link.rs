//! The reliable link: messages both ways, in order, exactly once, over bytes that may be lost,
//! damaged, doubled or reordered. One state machine for both ends.
//!
//! In: received bytes ([`Endpoint::feed`]), messages to send ([`Endpoint::send`]), the time with
//! every call. Out: bytes to transmit ([`Endpoint::take_tx`]), received messages
//! ([`Endpoint::message`]), a [`LinkState`] and [`FrameCounters`]. Owns `2 * WINDOW` messages and
//! two frames of memory; reads no clock and does no input or output. Fails: a bad frame is counted
//! and ignored.
//!
//! **Opening.** The client sends Hello with a nonce. The controller offers a session id that it has
//! never used with this nonce (HelloAck). The client confirms with a KeepAlive in that session. The
//! controller begins the session and acknowledges; only then is the client [`LinkState::Open`]. A
//! Hello alone changes nothing in the controller, so a late copy of an old one cannot end a
//! session. A late message of an old session never matches the present id.
//!
//! **Flow.** `acknowledgement` is the first message not yet received; `credit` is how many from
//! there on the receiver has room for. A message's slot is free when the user is done with it
//! ([`Endpoint::done_with_message`]). So messages left untaken close the window without being sent
//! again.

#[cfg(test)]
mod exhaustive_delivery;
mod receive;
mod transmit;

use crate::Ns;
use crate::deframe::{self, Deframer};
use crate::frame::{self, Busy, HelloAck, MAX_PAYLOAD, MAX_WIRE, VERSION};
use receive::Receiver;
use transmit::Transmitter;

/// The client repeats Hello, or its confirmation, after this time without an answer.
pub const HELLO_NS: Ns = 100_000_000;
/// The client sends a KeepAlive when it has sent nothing else for this time.
pub const KEEP_ALIVE_NS: Ns = 100_000_000;
/// A session whose last valid frame is younger than this is alive: a client on another wire does
/// not get it.
pub const ALIVE_NS: Ns = 500_000_000;
/// Bounds of the time after which an unacknowledged message is sent again, and its first value.
pub const RETRY_MIN_NS: Ns = 20_000_000;
/// See [`RETRY_MIN_NS`].
pub const RETRY_MAX_NS: Ns = 1_000_000_000;
/// See [`RETRY_MIN_NS`].
pub const RETRY_FIRST_NS: Ns = 200_000_000;

/// Which end this is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Opens sessions and keeps them alive.
    Client,
    /// Answers.
    Controller,
    /// Answers Hellos that ask for a read-only session, and no others ([`crate::viewer`]).
    ReadOnly,
}

/// What both ends must agree on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// Version of the frame and link layers.
    pub version: u8,
    /// Hash of all layouts.
    pub schema: u32,
}

impl Identity {
    /// Of this build.
    pub const OURS: Identity = Identity { version: VERSION, schema: crate::SCHEMA };
}

/// State of the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LinkState {
    /// No session: never opened, or closed by this end.
    Closed,
    /// Client: waiting for the controller's answers.
    Opening,
    /// A session is open.
    Open,
    /// Client: the controller is of another version or schema, which are given (return code 3).
    Mismatch(Identity),
    /// Client: another client has the controller (return code −6).
    Busy(Busy),
    /// Client: it asked for a read-only session, which this wire does not give.
    NoReadOnly,
    /// The other end said Bye.
    Ended,
}

/// Why a message was not taken for sending; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SendError {
    /// No session is open.
    NotOpen,
    /// `WINDOW` messages wait for their acknowledgement already.
    Full,
    /// Longer than [`MAX_PAYLOAD`].
    TooLong,
}

/// Counts since power-on (wrapping).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)]
pub struct LinkCounters {
    /// Deframer: good frames and refusals.
    pub deframe: deframe::FrameCounters,
    /// Frames refused by [`crate::frame::Fault`].
    pub short: u32,
    pub checksum: u32,
    pub version: u32,
    pub kind: u32,
    pub length: u32,
    /// Frames of the opening that are not for this role or not for this Hello.
    pub unexpected: u32,
    /// Frames of a session that is not open.
    pub stale_session: u32,
    /// Acknowledgements of messages that were never sent.
    pub bad_acknowledgement: u32,
    /// Messages that came again.
    pub duplicates: u32,
    /// Messages beyond the window that was open.
    pub beyond_window: u32,
    /// Hellos of another version or schema.
    pub mismatches: u32,
    /// Sessions begun.
    pub sessions: u32,
    /// Messages received in order, and messages accepted for sending.
    pub received: u32,
    pub sent: u32,
    /// Messages sent again: after a time-out, or because the receiver reported a gap.
    pub timeouts: u32,
    pub fast_retransmits: u32,
}

/// Progress of a client's opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SessionPhase {
    /// Hello is repeated until a HelloAck comes.
    Asking,
    /// The session is known; this many confirmations have been sent.
    Confirming(u8),
}

/// A session that the controller has offered and no client has confirmed yet.
#[derive(Debug, Clone, Copy)]
struct Offer {
    nonce: u32,
    session: u32,
    window: u16,
}

/// Why the end of a read-only session answers Busy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoSession {
    /// It gives no session that commands.
    ReadsOnly,
    /// It gives no more read-only sessions.
    Full,
}

impl NoSession {
    /// What [`Busy::holder`] says.
    pub const fn text(self) -> &'static str {
        match self {
            NoSession::ReadsOnly => "a port that is only for viewers",
            NoSession::Full => "enough viewers are here",
        }
    }
}

/// The answer to a Hello.
#[derive(Debug, Clone, Copy)]
enum Opening {
    Ack(HelloAck),
    Busy(NoSession),
}

/// Result of [`Endpoint::request_take_over`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeOver {
    /// Nothing: the frame does not belong to the opening of a session.
    Nothing,
    /// So many bytes are to be sent over the wire on which the frame came.
    Answered(usize),
    /// A session has begun: from now on that wire is the link's.
    TakenUp,
}

/// One end of the link. `WINDOW` is a power of two up to 64.
#[derive(Debug, Clone)]
pub struct Endpoint<const WINDOW: usize> {
    role: Role,
    identity: Identity,
    state: LinkState,
    phase: SessionPhase,
    /// Client: it asks for a read-only session.
    read_only: bool,
    /// Client: nonce of the last Hello. Controller: nonce of the open session.
    nonce: u32,
    /// 0: none.
    session: u32,
    offer: Option<Offer>,
    offers_made: u32,
    refused: Option<Identity>,
    deframer: Deframer<MAX_WIRE>,
    transmitter: Transmitter<WINDOW>,
    receiver: Receiver<WINDOW>,
    /// Control frames that are due.
    hello_due: bool,
    answer: Option<(u32, Opening)>,
    bye: Option<u32>,
    keep_alive_due: bool,
    /// Time of the next try to open.
    retry_at: Ns,
    last_sent: Ns,
    last_valid: Option<Ns>,
    /// When the session began.
    began: Ns,
    wire: [u8; MAX_WIRE],
    wire_at: usize,
    wire_len: usize,
    counters: LinkCounters,
}

impl<const WINDOW: usize> Endpoint<WINDOW> {
    const WINDOW_IS_VALID: () = assert!(WINDOW.is_power_of_two() && WINDOW <= 64);

    /// A closed end; `const`, so that it can be a static.
    pub const fn new(role: Role, identity: Identity) -> Self {
        const { Self::WINDOW_IS_VALID };
        Endpoint {
            role,
            identity,
            state: LinkState::Closed,
            phase: SessionPhase::Asking,
            read_only: false,
            nonce: 0,
            session: 0,
            offer: None,
            offers_made: 0,
            refused: None,
            deframer: Deframer::new(),
            transmitter: Transmitter::new(),
            receiver: Receiver::new(),
            hello_due: false,
            answer: None,
            bye: None,
            keep_alive_due: false,
            retry_at: 0,
            last_sent: 0,
            last_valid: None,
            began: 0,
            wire: [0; MAX_WIRE],
            wire_at: 0,
            wire_len: 0,
            counters: LinkCounters {
                deframe: deframe::FrameCounters { frames: 0, too_long: 0, truncated: 0 },
                short: 0,
                checksum: 0,
                version: 0,
                kind: 0,
                length: 0,
                unexpected: 0,
                stale_session: 0,
                bad_acknowledgement: 0,
                duplicates: 0,
                beyond_window: 0,
                mismatches: 0,
                sessions: 0,
                received: 0,
                sent: 0,
                timeouts: 0,
                fast_retransmits: 0,
            },
        }
    }

    /// Client: begins a new session, whatever was before. `nonce` must differ from that of any
    /// session whose bytes may still be in transit: take it at random. A controller ignores the
    /// call.
    pub fn open(&mut self, now: Ns, nonce: u32) {
        self.open_as(now, nonce, false);
    }

    /// Client: the same, for a session that only reads.
    pub fn open_read_only(&mut self, now: Ns, nonce: u32) {
        self.open_as(now, nonce, true);
    }

    fn open_as(&mut self, now: Ns, nonce: u32, read_only: bool) {
        if self.role == Role::Client {
            self.read_only = read_only;
            self.forget(LinkState::Opening);
            self.phase = SessionPhase::Asking;
            self.nonce = nonce;
            self.retry_at = now;
            self.poll(now);
        }
    }

    /// Ends the session; the other end gets one Bye, without waiting for its answer.
    pub fn close(&mut self) {
        let bye = (self.state == LinkState::Open).then_some(self.session);
        self.forget(LinkState::Closed);
        self.bye = bye;
    }

    /// Sends a client's keep-alive with the next bytes, before it is due.
    pub fn keep_alive(&mut self) {
        self.keep_alive_due |= self.role == Role::Client && matches!(self.state, LinkState::Open);
    }

    /// Lets the timers act. [`Self::take_tx`] does it too.
    pub fn poll(&mut self, now: Ns) {
        match self.state {
            LinkState::Opening if now >= self.retry_at => {
                self.retry_at = now.saturating_add(HELLO_NS);
                match self.phase {
                    SessionPhase::Confirming(count) if count < 3 => {
                        self.keep_alive_due = true;
                        self.phase = SessionPhase::Confirming(count.wrapping_add(1));
                    }
                    // Nobody confirms the session: another Hello may have overwritten the offer.
                    // Ask again.
                    SessionPhase::Confirming(_) | SessionPhase::Asking => {
                        self.phase = SessionPhase::Asking;
                        self.hello_due = true;
                    }
                }
            }
            LinkState::Open => {
                if self.transmitter.expire(now) {
                    self.counters.timeouts = self.counters.timeouts.wrapping_add(1);
                }
                let quiet = now.saturating_sub(self.last_sent) >= KEEP_ALIVE_NS;
                if self.role == Role::Client && quiet {
                    self.keep_alive_due = true;
                }
            }
            LinkState::Opening
            | LinkState::Closed
            | LinkState::Mismatch(_)
            | LinkState::Busy(_)
            | LinkState::NoReadOnly
            | LinkState::Ended => {}
        }
    }

    /// When [`Self::poll`] or [`Self::take_tx`] must be called at the latest, without other cause.
    pub fn next_deadline(&self) -> Option<Ns> {
        match self.state {
            LinkState::Opening => Some(self.retry_at),
            LinkState::Open => {
                let keep_alive = (self.role == Role::Client).then(|| self.last_sent.saturating_add(KEEP_ALIVE_NS));
                let retry = self.transmitter.deadline();
                keep_alive.into_iter().chain(retry).min()
            }
            LinkState::Closed
            | LinkState::Mismatch(_)
            | LinkState::Busy(_)
            | LinkState::NoReadOnly
            | LinkState::Ended => None,
        }
    }

    /// Whether [`Self::send`] would take a message.
    pub fn can_send(&self) -> bool {
        self.state == LinkState::Open && self.transmitter.has_room()
    }

    /// Messages that can be sent before the window is full.
    pub fn free_slots(&self) -> usize {
        if self.state == LinkState::Open { self.transmitter.room() } else { 0 }
    }

    /// Takes a message for sending.
    ///
    /// # Errors
    /// [`SendError`]; nothing has changed.
    pub fn send(&mut self, message: &[u8]) -> Result<(), SendError> {
        if message.len() > MAX_PAYLOAD {
            return Err(SendError::TooLong);
        }
        if self.state != LinkState::Open {
            return Err(SendError::NotOpen);
        }
        let draft = self.transmitter.draft().ok_or(SendError::Full)?;
        if let Some(slot) = draft.get_mut(..message.len()) {
            frame::copy(slot, message);
        }
        self.send_draft(message.len())
    }

    /// The slot of the next message to send, to be written in place; then [`Self::send_draft`].
    /// `None` when nothing can be sent.
    pub fn draft(&mut self) -> Option<&mut [u8; MAX_PAYLOAD]> {
        if self.state == LinkState::Open { self.transmitter.draft() } else { None }
    }

    /// Takes the first `len` bytes of the draft as a message for sending.
    ///
    /// # Errors
    /// [`SendError`]; nothing has changed.
    pub fn send_draft(&mut self, len: usize) -> Result<(), SendError> {
        if len > MAX_PAYLOAD {
            return Err(SendError::TooLong);
        }
        if self.state != LinkState::Open {
            return Err(SendError::NotOpen);
        }
        if !self.transmitter.queue(len) {
            return Err(SendError::Full);
        }
        self.counters.sent = self.counters.sent.wrapping_add(1);
        Ok(())
    }

    /// The next received message in order. The same until [`Self::done_with_message`].
    pub fn message(&self) -> Option<&[u8]> {
        self.receiver.message()
    }

    /// The next received message together with the draft of an answer.
    pub fn message_and_draft(&mut self) -> Option<(&[u8], &mut [u8; MAX_PAYLOAD])> {
        if self.state != LinkState::Open {
            return None;
        }
        Some((self.receiver.message()?, self.transmitter.draft()?))
    }

    /// Frees the message's slot: the sender may send another one.
    pub fn done_with_message(&mut self) {
        self.receiver.done();
    }

    /// State of the link.
    pub fn state(&self) -> LinkState {
        self.state
    }

    /// Id of the open session. Another id means that all state of the one before is void.
    pub fn session(&self) -> Option<u32> {
        (self.state == LinkState::Open).then_some(self.session)
    }

    /// When the last valid frame of the open session came; for link-loss time-outs.
    pub fn last_valid(&self) -> Option<Ns> {
        if self.state == LinkState::Open { self.last_valid } else { None }
    }

    /// Time since the last valid frame of the open session.
    pub fn silence(&self, now: Ns) -> Option<Ns> {
        self.last_valid().map(|at| now.saturating_sub(at))
    }

    /// Whether everything sent has been received by the other end.
    pub fn all_acknowledged(&self) -> bool {
        self.transmitter.is_idle()
    }

    /// Read-only controller: a Hello for such a session has come, and the session is not open yet.
    pub fn is_asked(&self) -> bool {
        self.role == Role::ReadOnly && self.offer.is_some()
    }

    /// Read-only controller: answers that Hello with Busy instead.
    pub fn turn_away(&mut self) {
        if let Some(offer) = self.offer.take() {
            self.answer = Some((offer.nonce, Opening::Busy(NoSession::Full)));
        }
    }

    /// Controller: version and schema of the last client that was refused for them.
    pub fn refused_client(&self) -> Option<Identity> {
        self.refused
    }

    /// The counts so far.
    pub fn counters(&self) -> LinkCounters {
        LinkCounters { deframe: self.deframer.counters(), ..self.counters }
    }

    /// Drops the session and all messages. The remaining bytes of a partly sent frame stay, so that
    /// the stream keeps its frame boundaries.
    fn forget(&mut self, state: LinkState) {
        self.state = state;
        self.session = 0;
        self.offer = None;
        self.hello_due = false;
        self.keep_alive_due = false;
        self.answer = None;
        self.bye = None;
        self.last_valid = None;
        self.transmitter.reset(0);
        self.receiver.reset();
    }

    /// Begins a session.
    fn begin(&mut self, now: Ns, nonce: u32, session: u32, window: u16) {
        self.offer = None;
        self.nonce = nonce;
        self.session = session;
        self.transmitter.reset(window);
        self.receiver.reset();
        self.last_valid = Some(now);
        self.began = now;
        self.last_sent = now;
        self.counters.sessions = self.counters.sessions.wrapping_add(1);
    }
}
