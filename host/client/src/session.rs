//! The client's end of the session: calls into messages, messages into replies.
//!
//! In: packed calls, received bytes. Out: bytes to send, one [`Reply`] for each call. Owns the
//! link's state machine and the calls that wait for their reply. Fails with −3 when the controller
//! ends the session, 3 when versions differ, −5 when a message is no row of replies.
use crate::call::Call;
use crate::error::{self, Error, Result};
use protocol::command::{SetLinkLoss, opcode};
use protocol::frame::Busy;
use protocol::link::{ALIVE_NS, Endpoint, Identity, KEEP_ALIVE_NS, LinkCounters, LinkState, Role};
use protocol::reason::{Code, Reason, Refusal};
use protocol::record::{BODY_MAX, JOB_RECORD, JobState, Lane, RequestWriter, TRACE_RECORD, replies};
use std::collections::{HashMap, VecDeque};
use zerocopy::{FromBytes, IntoBytes};

/// Unanswered messages at once.
const WINDOW_MESSAGES: usize = 32;
/// Most calls that wait for a reply: tags have 16 bits, and none may be used twice at a time.
pub(crate) const MAX_WAITING_CALLS: usize = 32_768;

/// The reply to one call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Reply {
    /// Return code.
    pub code: i16,
    /// The packed reply, or the refusal.
    pub payload: Vec<u8>,
}

/// A call that is not in a message yet.
struct Outgoing {
    tag: u16,
    lane: Lane,
    opcode: u16,
    payload: Vec<u8>,
}

/// See the module text.
pub(crate) struct Session {
    endpoint: Box<Endpoint<WINDOW_MESSAGES>>,
    name: String,
    ours: Identity,
    outbox: VecDeque<Outgoing>,
    /// Calls that wait (`None`) or whose reply has come.
    waiting: HashMap<u16, Option<Reply>>,
    next_tag: u16,
    frames: u32,
    /// A call changes the controller, or may.
    commanded: bool,
    read_only: bool,
    /// The job that the other end shows.
    job: Option<(JobState, String)>,
    silence: Silence,
    /// When bytes went out last.
    sent_at: u64,
    /// Bytes of a trace that came over the link.
    trace: Vec<u8>,
}

/// How long this end may be silent, ns: a quarter of the link-loss time, where that is short.
struct Silence {
    /// By the time in force.
    set: u64,
    /// By the times of unanswered calls, with the calls: until one is answered, the shortest
    /// counts.
    asked: Vec<(u16, u64)>,
}

impl Silence {
    fn longest(&self) -> u64 {
        self.asked.iter().fold(self.set, |least, (_, silence)| least.min(*silence))
    }

    /// A SetLinkLoss is answered: it is in force, unless it was refused.
    fn answered(&mut self, tag: u16, code: i16) {
        if let Some(place) = self.asked.iter().position(|(waits, _)| *waits == tag) {
            let (_, silence) = self.asked.remove(place);
            if code == 0 {
                self.set = silence;
            }
        }
    }
}

impl Session {
    /// Begins to open a session over the link `name`.
    pub fn open(name: &str, now: u64, nonce: u32, ours: Identity, read_only: bool) -> Self {
        let mut endpoint = Box::new(Endpoint::new(Role::Client, ours));
        match read_only {
            true => endpoint.open_read_only(now, nonce),
            false => endpoint.open(now, nonce),
        }
        Session {
            endpoint,
            name: name.to_owned(),
            ours,
            outbox: VecDeque::new(),
            waiting: HashMap::new(),
            next_tag: 0,
            frames: 0,
            commanded: false,
            read_only,
            job: None,
            silence: Silence { set: KEEP_ALIVE_NS, asked: Vec::new() },
            sent_at: now,
            trace: Vec::new(),
        }
    }

    /// Whether the session is in force; an error once it can no more be.
    pub fn is_open(&self) -> Result<bool> {
        match self.endpoint.state() {
            LinkState::Open => Ok(true),
            LinkState::Opening => Ok(false),
            LinkState::Mismatch(theirs) => Err(mismatch(&self.name, self.ours, theirs)),
            LinkState::Busy(busy) if self.read_only => {
                let why = String::from_utf8_lossy(busy.holder());
                Err(Error::new(error::CANNOT_OPEN, format!("{}: no read-only session: {why}", self.name)))
            }
            LinkState::Busy(busy) => Err(taken(&self.name, &busy)),
            LinkState::NoReadOnly => Err(Error::new(
                error::CANNOT_OPEN,
                format!(
                    "{}: this end gives no read-only sessions. A board's wire has one session, which commands; the program that \
                     has it can share it (--share)",
                    self.name
                ),
            )),
            LinkState::Ended | LinkState::Closed => {
                Err(Error::new(error::LINK_CLOSED, format!("{}: the controller ended the session", self.name)))
            }
        }
    }

    /// Ends the session; what waits is forgotten.
    pub fn close(&mut self) {
        self.outbox.clear();
        self.waiting.clear();
        self.endpoint.close();
    }

    /// Queues a call; its reply is found under the number returned.
    pub fn post(&mut self, lane: Lane, call: &Call) -> Result<u16> {
        if call.payload.len() > BODY_MAX {
            return Err(Error::new(
                7,
                format!(
                    "{}: {} bytes are too long for a message, which holds {BODY_MAX}",
                    crate::call::name(call.opcode),
                    call.payload.len()
                ),
            ));
        }
        let looks = call.is_read() || call.opcode == opcode::ProgramStatus;
        if self.read_only && !(looks && lane == Lane::Immediate) {
            let refusal = Refusal::new(Reason::ReadOnly);
            return Err(crate::call::refused(call.opcode, Code::State as i16, refusal.as_bytes()));
        }
        if self.waiting.len() >= MAX_WAITING_CALLS {
            return Err(Error::new(1, "too many calls wait for their replies"));
        }
        while self.waiting.contains_key(&self.next_tag) {
            self.next_tag = self.next_tag.wrapping_add(1);
        }
        let tag = self.next_tag;
        self.next_tag = self.next_tag.wrapping_add(1);
        self.waiting.insert(tag, None);
        // An Abort of the immediate lane acts now; one of a program acts if the program reaches it.
        self.commanded = match (lane, call.opcode) {
            (Lane::Immediate, opcode::Abort) => false,
            _ => self.commanded || !call.is_harmless(),
        };
        if call.opcode == opcode::SetLinkLoss
            && let Ok(set) = SetLinkLoss::read_from_bytes(&call.payload)
        {
            let silence = match u64::try_from(set.time_ms.get()) {
                Ok(ms @ 1..) => (ms * 1_000_000 / 4).min(KEEP_ALIVE_NS),
                _ => KEEP_ALIVE_NS,
            };
            self.silence.asked.push((tag, silence));
        }
        self.outbox.push_back(Outgoing { tag, lane, opcode: call.opcode, payload: call.payload.clone() });
        Ok(tag)
    }

    /// The reply to call `tag`, if it has come; it is handed over once.
    pub fn take(&mut self, tag: u16) -> Option<Reply> {
        if !matches!(self.waiting.get(&tag), Some(Some(_))) {
            return None;
        }
        self.waiting.remove(&tag).flatten()
    }

    /// Whether anything but reads was posted since the last Abort.
    pub fn commanded(&self) -> bool {
        self.commanded
    }

    /// A program has ended with an Abort: what was posted so far lights and moves nothing any more.
    pub fn settle(&mut self) {
        self.commanded = false;
    }

    /// Calls that are in no message yet.
    pub fn backlog(&self) -> usize {
        self.outbox.len()
    }

    /// Appends the bytes that are due to `out`.
    pub fn send(&mut self, now: u64, out: &mut Vec<u8>) {
        self.pack();
        self.endpoint.poll(now);
        if now.saturating_sub(self.sent_at) >= self.silence() {
            self.endpoint.keep_alive();
        }
        let before = out.len();
        let mut bytes = [0; 2048];
        loop {
            let n = self.endpoint.take_tx(now, &mut bytes);
            if n == 0 {
                break;
            }
            out.extend_from_slice(&bytes[..n]);
        }
        if out.len() > before {
            self.sent_at = now;
        }
    }

    /// Longest silence of ours, ns.
    pub fn silence(&self) -> u64 {
        self.silence.longest()
    }

    /// Packs queued calls into messages, as many as a message and the window hold.
    fn pack(&mut self) {
        while !self.outbox.is_empty() {
            let Some(draft) = self.endpoint.draft() else { return };
            let mut writer = RequestWriter::new(draft);
            while let Some(call) = self.outbox.front() {
                if writer.push_raw(call.opcode, call.lane, call.tag, &[&call.payload]).is_err() {
                    break;
                }
                self.outbox.pop_front();
            }
            let len = writer.len();
            if len == 0 || self.endpoint.send_draft(len).is_err() {
                return;
            }
        }
    }

    /// Takes received bytes; true if a good frame was among them.
    pub fn feed(&mut self, now: u64, bytes: &[u8]) -> Result<bool> {
        self.endpoint.feed(now, bytes);
        let frames = self.endpoint.counters().deframe.frames;
        let heard = frames != self.frames;
        self.frames = frames;
        while let Some(message) = self.endpoint.message() {
            for reply in replies(message) {
                let reply = reply.map_err(|_| {
                    Error::new(error::LINK_PROTOCOL, format!("{}: a message is no row of replies", self.name))
                })?;
                if (reply.opcode, reply.tag) == (TRACE_RECORD, 0) {
                    self.trace.extend_from_slice(reply.body);
                    continue;
                }
                if (reply.opcode, reply.tag) == (JOB_RECORD, 0) {
                    if let Ok((job, name)) = JobState::read_from_prefix(reply.body) {
                        self.job = Some((job, String::from_utf8_lossy(name).into_owned()));
                    }
                    continue;
                }
                self.silence.answered(reply.tag, reply.code);
                // A reply without a waiting call belongs to a program that was given up.
                if let Some(place) = self.waiting.get_mut(&reply.tag) {
                    *place = Some(Reply { code: reply.code, payload: reply.body.to_vec() });
                }
            }
            self.endpoint.done_with_message();
        }
        self.is_open().map(|_| heard)
    }

    /// Moves the bytes of a trace over the link to the end of `out`.
    pub fn take_trace(&mut self, out: &mut Vec<u8>) {
        out.append(&mut self.trace);
    }

    /// The job that the other end shows.
    pub fn job(&self) -> Option<(JobState, String)> {
        self.job.clone()
    }

    /// What this end of the link has counted.
    pub fn counters(&self) -> LinkCounters {
        self.endpoint.counters()
    }

    /// When [`Self::send`] has something to do at the latest.
    pub fn next_deadline(&self) -> u64 {
        let alive = match self.endpoint.state() {
            LinkState::Open => self.sent_at.saturating_add(self.silence()),
            _ => u64::MAX,
        };
        self.endpoint.next_deadline().unwrap_or(u64::MAX).min(alive)
    }
}

fn taken(name: &str, busy: &Busy) -> Error {
    let seconds = |ms: u32| f64::from(ms) / 1e3;
    let alive = ALIVE_NS / 1_000_000;
    Error::new(
        error::CANNOT_OPEN,
        format!(
            "{name}: the controller is open already, by a client at {} since {:.1} s, heard {} ms ago. One client at a time: \
             close that one; one that is gone is forgotten after {alive} ms of silence",
            String::from_utf8_lossy(busy.holder()),
            seconds(busy.held_ms.get()),
            busy.silent_ms
        ),
    )
}

fn mismatch(name: &str, ours: Identity, theirs: Identity) -> Error {
    Error::new(
        error::MISMATCH,
        format!(
            "{name}: client and firmware do not match: the client speaks protocol version {} (schema {:08x}), \
             the firmware version {} (schema {:08x}); build both from the same source",
            ours.version, ours.schema, theirs.version, theirs.schema
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::reason::{Reason, Refusal};
    use protocol::record::{ReplyWriter, requests};

    const MS: u64 = 1_000_000;

    /// Both ends, and a time that passes in quarters of a ms.
    struct Wire {
        session: Session,
        controller: Endpoint<8>,
        now: u64,
        /// Whether the controller answers at all.
        answers: bool,
        refuses: bool,
    }

    impl Wire {
        fn open() -> Wire {
            let session = Session::open("test", 0, 1, Identity::OURS, false);
            let controller = Endpoint::new(Role::Controller, Identity::OURS);
            let mut wire = Wire { session, controller, now: 0, answers: true, refuses: false };
            wire.longest_silence(5);
            assert_eq!(wire.session.is_open(), Ok(true));
            wire
        }

        /// The longest time between two sendings of the client within so many ms.
        fn longest_silence(&mut self, ms: u64) -> u64 {
            let (end, mut sent, mut longest) = (self.now + ms * MS, self.now, 0);
            let mut bytes = [0; 2048];
            while self.now < end {
                self.now += MS / 4;
                let mut out = Vec::new();
                self.session.send(self.now, &mut out);
                longest = longest.max(self.now - sent);
                sent = if out.is_empty() { sent } else { self.now };
                self.controller.feed(self.now, &out);
                self.controller.poll(self.now);
                self.answer();
                let count = self.controller.take_tx(self.now, &mut bytes);
                self.session.feed(self.now, &bytes[..count]).unwrap();
            }
            longest
        }

        fn answer(&mut self) {
            if !self.answers || !self.controller.can_send() {
                return;
            }
            let Some(message) = self.controller.message() else { return };
            let calls: Vec<(u16, u16)> =
                requests(message).map(|call| call.unwrap()).map(|call| (call.opcode, call.tag)).collect();
            self.controller.done_with_message();
            let mut buffer = [0; 512];
            let mut writer = ReplyWriter::new(&mut buffer);
            for (opcode, tag) in calls {
                let refusal = Refusal::new(Reason::OutOfRange);
                match self.refuses {
                    true => writer.refused(opcode, tag, &refusal).unwrap(),
                    false => writer.push_raw(opcode, tag, 0, &[]).unwrap(),
                }
            }
            let len = writer.len();
            self.controller.send(&buffer[..len]).unwrap();
        }

        fn set(&mut self, ms: i32) {
            let call = Call::of(SetLinkLoss { time_ms: ms.into(), stop_all: 0.into() });
            self.session.post(Lane::Immediate, &call).unwrap();
        }
    }

    /// A session that says nothing speaks often enough for a short link-loss time: four times in
    /// it.
    #[test]
    fn a_short_link_loss_time_is_kept_alive() {
        let mut wire = Wire::open();
        assert_eq!(wire.longest_silence(1000), 100 * MS, "by itself");
        for (ms, quarter) in [(40, 10), (4, 1), (1000, 100), (400, 100), (100, 25)] {
            wire.set(ms);
            wire.longest_silence(200);
            assert_eq!(wire.longest_silence(1000), quarter * MS, "{ms} ms");
        }
        // Without supervision there is no hurry.
        wire.set(0);
        wire.longest_silence(200);
        assert_eq!(wire.longest_silence(1000), 100 * MS);
    }

    /// A longer time counts once the controller has taken it, a shorter one from the call on; one
    /// that is refused never.
    #[test]
    fn a_link_loss_time_counts_as_the_controller_takes_it() {
        let mut wire = Wire::open();
        wire.set(40);
        wire.longest_silence(50);
        (wire.refuses, wire.answers) = (true, true);
        wire.set(-1);
        wire.longest_silence(50);
        assert_eq!(wire.longest_silence(500), 10 * MS, "the refused one changes nothing");
        wire.answers = false;
        wire.set(20);
        wire.set(1000);
        assert_eq!(wire.longest_silence(300).max(MS), 5 * MS, "neither is answered: the shorter one counts");
        (wire.refuses, wire.answers) = (false, true);
        wire.longest_silence(50);
        assert_eq!(wire.longest_silence(500), 100 * MS);
    }
}
