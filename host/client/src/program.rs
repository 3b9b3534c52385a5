//! A program: timed calls that run on the controller's own script clock (SPEC 7).
//!
//! In: calls in order, `Sleep` and `WaitStop` among them. Out: one [`Answer`] for each, in order,
//! and a [`Summary`]. The controller's queue is kept as full as it can be while the program runs,
//! so that a host that is not real time can be away for a while; entries that do not fit wait here.
//! Calls for one FIFO of a path travel as one ([`crate::joined`]); each has its own answer.
use crate::call::{Call, refused};
use crate::client::Client;
use crate::client::Inner;
use crate::error;
use crate::error::{Error, Result};
use crate::joined::{Group, Offer, split_program_replies};
use protocol::command::{
    CommandKind, DataStore, ProgramClear, ProgramEnd, ProgramReply, ProgramStart, ProgramStatus, PtTaken, Request,
    class, opcode,
};
use protocol::path_many::{FIXED_BYTES, JOINED_MAX};
use protocol::reason::{Reason, Refusal};
use protocol::record::Lane;
use protocol::values::{program as state, reported};
use std::collections::VecDeque;
use std::time::Duration;
use zerocopy::FromBytes;

/// What became of one entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Number of the entry in its program, from 0.
    pub index: u32,
    /// Its command.
    pub opcode: u16,
    /// Return value of SPEC 3.
    pub code: i16,
    /// Why, if the code is not 0.
    pub error: Option<Error>,
    /// The packed reply, if the code is 0.
    pub reply: Vec<u8>,
}

impl Answer {
    /// The reply's fields and items, if the entry was done and is of this command.
    pub fn reply<R: Request>(&self) -> Option<(R::Reply, Vec<R::ReplyItem>)> {
        if self.code != 0 || self.opcode != R::OPCODE {
            return None;
        }
        crate::call::decode::<R>(&self.reply).ok()
    }

    /// What the controller said against it.
    pub fn refusal(&self) -> Option<&Refusal> {
        self.error.as_ref().and_then(|e| e.refusal.as_ref())
    }

    pub(crate) fn new(index: u32, opcode: u16, code: i16, payload: Vec<u8>) -> Self {
        let error = (code != 0).then(|| refused(opcode, code, &payload));
        Answer { index, opcode, code, error, reply: if code == 0 { payload } else { Vec::new() } }
    }
}

/// How long the data in one axis's PT stream lasts, as the last answer said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dry {
    /// Logical core, from 1.
    pub core: i16,
    /// Axis of the core, from 1.
    pub axis: i16,
    /// Free slots (PtSpace).
    pub space: u16,
    /// Time to dry in ms.
    pub dry_ms: u32,
}

/// Where a program is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Progress {
    /// Entries pushed.
    pub entries: u32,
    /// Entries sent to the controller.
    pub sent: u32,
    /// Entries answered.
    pub answered: u32,
    /// The controller's own account: accepted, executed, free bytes, late entries, state, clock.
    pub queue: ProgramReply,
    /// The entry that was late first.
    pub first_late: Option<u32>,
    /// The last entry that had been executed when a servo tick took too long for the first time.
    pub overran: Option<u32>,
    /// One row for each PT stream that got data, in order of its first data.
    pub streams: Vec<Dry>,
}

impl Progress {
    /// The script clock.
    pub fn clock(&self) -> Duration {
        Duration::from_nanos(self.queue.clock_ns.get())
    }

    /// Whether a laser command was late.
    pub fn is_light_late(&self) -> bool {
        self.queue.reported & reported::LATE_LIGHT != 0
    }

    /// Laser channels whose light a fault took, or kept from coming; bit 0 is channel 0.
    pub fn darkened(&self) -> u8 {
        self.queue.reported >> reported::DARK_SHIFT
    }
}

/// Who watches a program run.
pub trait Observer {
    /// An entry was answered; answers come in the order of the entries.
    fn answered(&mut self, answer: Answer) -> Result<()> {
        let _ = answer;
        Ok(())
    }
    /// At each turn of the link, some ms apart. An error ends the waiting (not the program).
    fn polled(&mut self) -> Result<()> {
        Ok(())
    }
    /// About every 100 ms of the link's time. An error ends the waiting (not the program).
    fn progress(&mut self, progress: &Progress) -> Result<()> {
        let _ = progress;
        Ok(())
    }
}

/// An observer that watches nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quiet;

impl Observer for Quiet {}

/// How a program ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Where it was when it ended.
    pub progress: Progress,
    /// The first entry that was refused, apart from those that may be.
    pub failed: Option<Answer>,
}

/// A program that is being put together or runs. See the module text.
pub struct Program<'c> {
    client: &'c Client,
    calls: Vec<Call>,
}

impl<'c> Program<'c> {
    pub(crate) fn new(client: &'c Client) -> Self {
        Program { client, calls: Vec::new() }
    }

    /// Appends a call; returns its number, from 0.
    pub fn push<R: Request>(&mut self, request: R) -> u32 {
        self.push_call(Call::of(request))
    }

    /// Appends a call with items.
    pub fn push_items<R: Request>(&mut self, request: R, items: &[R::Item]) -> u32 {
        self.push_call(Call::with_items::<R>(request, items))
    }

    /// Appends a packed call.
    pub fn push_call(&mut self, call: Call) -> u32 {
        self.calls.push(call);
        (self.calls.len() - 1) as u32
    }

    /// Sends everything, starts the program as soon as the controller's queue is full or everything
    /// is in it, and waits until it has run. `strict`: a late entry stops it.
    ///
    /// A refused entry is no error here but in the summary.
    pub fn run(self, strict: bool, observer: &mut dyn Observer) -> Result<Summary> {
        self.client.run(self.calls, strict, observer)
    }
}

/// Time between two looks at the controller's queue, on the link's clock.
const POLL_NS: u64 = 100_000_000;
/// The same while entries wait for room, or for the program to be over.
const EAGER_NS: u64 = 2_000_000;
/// Looks without a change after which a held queue is taken to be full.
const STUCK_LOOKS: u32 = 3;
/// Time between two calls of [`Observer::progress`].
const PROGRESS_NS: u64 = 100_000_000;
/// What an entry takes of the queue's free bytes beyond its body, at most.
const ENTRY_OVERHEAD_BYTES: u32 = 8;
/// Entries that are sent and not answered, at most.
const IN_FLIGHT_ENTRIES: usize = 16_384;
/// Calls that wait to be put into a message, at most: about a full window.
const BACKLOG_CALLS: usize = 1024;

/// An entry in transfer, or several that travel as one.
struct Sent {
    tag: u16,
    /// Number of the first.
    index: u32,
    calls: Vec<Call>,
    joined: bool,
}

/// A program in transfer.
struct Run<'a> {
    calls: &'a mut dyn Iterator<Item = Call>,
    /// The next call, taken from the iterator and not sent yet; calls to be sent again come first.
    ahead: VecDeque<(u32, Call)>,
    exhausted: bool,
    flight: VecDeque<Sent>,
    /// Free bytes of the queue that may still be used.
    room: u32,
    /// What is next waits for more of them.
    blocked: bool,
    /// Calls for one FIFO of a path travel together.
    joins: bool,
    /// The pending query of the queue: its tag, and the bytes sent after it.
    query: Option<(u16, u32)>,
    polled_at: u64,
    reported_at: u64,
    started: bool,
    /// Looks in a row at which the held queue had not moved on.
    stuck: u32,
    going_back: bool,
    /// The last entry done that may light or move anything was an Abort.
    settled: bool,
    /// The entry that each tag was given to last.
    tags: Vec<u32>,
    progress: Progress,
    failed: Option<Answer>,
}

/// Runs calls as a program; see [`Program::run`].
pub(crate) fn run(
    client: &Client,
    calls: &mut dyn Iterator<Item = Call>,
    strict: bool,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    let mut run = Run {
        calls,
        ahead: VecDeque::new(),
        exhausted: false,
        flight: VecDeque::new(),
        room: 0,
        blocked: false,
        joins: client.joins(),
        query: None,
        polled_at: 0,
        reported_at: client.lock().now(),
        started: false,
        stuck: 0,
        going_back: false,
        settled: false,
        tags: vec![0; 1 << 16],
        progress: Progress::default(),
        failed: None,
    };
    run.progress.queue = client.call(ProgramStatus {})?;
    if matches!(run.progress.queue.state, state::FAILED | state::STOPPED) {
        run.progress.queue = client.call(ProgramClear {})?;
    }
    run.room = run.progress.queue.space_bytes.get();
    loop {
        let answers = {
            let mut inner = client.lock();
            // What a look brings is used before the next wait: that may be a long one.
            run.ask(&mut inner)?;
            run.fill(&mut inner)?;
            let wait = inner.turn.min(run.until_poll(inner.now()));
            inner.pump(wait)?;
            client.check_heard(&mut inner, || "while a program runs".to_owned())?;
            run.collect(&mut inner)?
        };
        for answer in answers {
            observer.answered(answer)?;
        }
        observer.polled()?;
        if run.ready_to_start() {
            run.progress.queue = client.call(ProgramStart { strict: strict.into() })?;
            run.started = true;
        }
        let now = client.lock().now();
        if now.saturating_sub(run.reported_at) >= PROGRESS_NS {
            run.reported_at = now;
            observer.progress(&run.progress)?;
        }
        if run.is_over() {
            break;
        }
    }
    if strict && run.failed.is_some() {
        // Which entry was late stands in the queue's report; the looks so far may be older.
        run.progress.queue = client.call(ProgramStatus {})?;
        run.note();
    }
    if run.failed.is_some() || run.progress.queue.state != state::EMPTY {
        let last = run.progress.queue;
        client.call(ProgramClear {})?;
        run.progress.queue = last;
    }
    if run.settled && run.failed.is_none() {
        client.lock().session.settle();
    }
    observer.progress(&run.progress)?;
    Ok(Summary { progress: run.progress, failed: run.failed })
}

impl Run<'_> {
    /// The call to send after so many others; after the last one, the program's end.
    fn next(&mut self, after: usize) -> Option<&(u32, Call)> {
        while self.ahead.len() <= after && !self.exhausted {
            let call = self.calls.next();
            let index = self.progress.entries;
            match call {
                Some(call) => {
                    self.progress.entries += 1;
                    self.ahead.push_back((index, call));
                }
                None => {
                    self.exhausted = true;
                    self.ahead.push_back((index, Call::of(ProgramEnd {})));
                }
            }
        }
        self.ahead.get(after)
    }

    /// What travels next: the entry in front alone, or with those after it in one call. None where
    /// there is none, or no room for it.
    fn unit(&mut self) -> Option<(Call, usize)> {
        let room = self.room.saturating_sub(ENTRY_OVERHEAD_BYTES) as usize;
        let front = self.next(0).map(|(_, call)| call.clone())?;
        self.blocked = front.payload.len() > room;
        if self.blocked {
            return None;
        }
        let Some(mut group) = Group::of(&front).filter(|_| self.joins) else { return Some((front, 1)) };
        let offered = loop {
            let count = group.count();
            let Some((_, call)) = self.next(count) else { break Offer::Other };
            match group.offer(call, room) {
                Offer::Taken => {}
                other => break other,
            }
        };
        let count = group.count();
        // A running program takes a command in a tick: a part of a message would cost as much as
        // all of it.
        self.blocked = self.started && offered == Offer::Full && room < FIXED_BYTES + JOINED_MAX;
        if self.blocked {
            return None;
        }
        if count < 2 { Some((front, 1)) } else { Some((group.call(), count)) }
    }

    /// Sends entries as far as the controller's queue and the window have room.
    fn fill(&mut self, inner: &mut Inner) -> Result<()> {
        while self.failed.is_none()
            && !self.going_back
            && self.flight.len() < IN_FLIGHT_ENTRIES
            && inner.session.backlog() < BACKLOG_CALLS
        {
            let Some((call, count)) = self.unit() else { break };
            let Some(index) = self.ahead.front().map(|(index, _)| *index) else { break };
            let cost = cost(&call);
            self.room = self.room.saturating_sub(cost);
            if let Some((_, behind)) = &mut self.query {
                *behind += cost;
            }
            let tag = inner.session.post(if call.may_fail { Lane::ProgramMayFail } else { Lane::Program }, &call)?;
            if let Some(entry) = self.tags.get_mut(usize::from(tag)) {
                *entry = index;
            }
            self.progress.sent = self.progress.sent.max((index + count as u32).min(self.progress.entries));
            let calls: Vec<Call> = self.ahead.drain(..count).map(|(_, call)| call).collect();
            self.flight.push_back(Sent { tag, index, calls, joined: count > 1 });
        }
        Ok(())
    }

    /// Looks at the controller's queue when entries wait for room, and now and then anyway.
    fn ask(&mut self, inner: &mut Inner) -> Result<()> {
        let now = inner.now();
        if let Some((tag, behind)) = self.query
            && let Some(reply) = inner.session.take(tag)
        {
            self.query = None;
            if let Ok(queue) = ProgramReply::read_from_bytes(&reply.payload) {
                let before = self.progress.queue;
                let moved = { before.space_bytes } != queue.space_bytes || { before.accepted } != queue.accepted;
                self.stuck = if moved { 0 } else { self.stuck + 1 };
                self.room = queue.space_bytes.get().saturating_sub(behind);
                self.progress.queue = queue;
                self.note();
            }
        }
        if self.query.is_none() && now >= self.next_poll() {
            self.polled_at = now;
            self.query = Some((inner.session.post(Lane::Immediate, &Call::of(ProgramStatus {}))?, 0));
        }
        Ok(())
    }

    /// Which entries a reply reports.
    fn note(&mut self) {
        let queue = self.progress.queue;
        let entry =
            |bit: u8, tag: u16| (queue.reported & bit != 0).then(|| self.tags.get(usize::from(tag)).copied()).flatten();
        let (late, overran) =
            (entry(reported::LATE, queue.late_tag.get()), entry(reported::OVERRAN, queue.overran_tag.get()));
        // Tags are used again: the first query that reports one has it.
        self.progress.first_late = self.progress.first_late.or(late);
        self.progress.overran = self.progress.overran.or(overran);
    }

    /// When the next look is due.
    fn next_poll(&self) -> u64 {
        let blocked = self.blocked;
        let at_the_end = self.exhausted && self.ahead.is_empty() && self.flight.is_empty();
        self.polled_at + if blocked || at_the_end || !self.started { EAGER_NS } else { POLL_NS }
    }

    /// Time from `now` to the next look, or to an answer that a look brings.
    fn until_poll(&self, now: u64) -> Duration {
        if self.query.is_some() {
            return Duration::MAX;
        }
        Duration::from_nanos(self.next_poll().saturating_sub(now))
    }

    /// Takes the answers that have come, in the order of the entries.
    fn collect(&mut self, inner: &mut Inner) -> Result<Vec<Answer>> {
        let mut answers = Vec::new();
        while let Some(sent) = self.flight.front() {
            let Some(reply) = inner.session.take(sent.tag) else { break };
            let Some(sent) = self.flight.pop_front() else { break };
            let Sent { index, calls, joined, .. } = sent;
            let replies = match joined {
                true => split_program_replies(&calls, reply.code, &reply.payload)?,
                false => vec![(reply.code, reply.payload)],
            };
            for ((index, call), (code, payload)) in (index..).zip(calls).zip(replies) {
                answers.extend(self.answered(index, call, code, payload)?);
            }
        }
        if self.going_back && self.flight.is_empty() {
            self.going_back = false;
            self.room = 0;
        }
        Ok(answers)
    }

    /// Takes the reply to one entry; none if the entry is sent again, or is the program's end.
    fn answered(&mut self, index: u32, call: Call, code: i16, payload: Vec<u8>) -> Result<Option<Answer>> {
        let answer = Answer::new(index, call.opcode, code, payload);
        let reason = answer.refusal().and_then(Refusal::reason);
        if reason == Some(Reason::QueueFull) {
            // This entry and all after it are sent again, once the controller has answered them
            // all.
            self.going_back = true;
            let place = self.ahead.partition_point(|(ahead, _)| *ahead < index);
            self.ahead.insert(place, (index, call));
            return Ok(None);
        }
        if self.going_back && answer.code == 0 {
            return Err(Error::new(
                error::LINK_PROTOCOL,
                "the controller took an entry after one that its queue had no room for",
            ));
        }
        self.note_stream(&call, &answer);
        if call.opcode == opcode::Abort || !call.is_harmless() {
            self.settled = call.opcode == opcode::Abort && answer.code == 0;
        }
        let ended = matches!(reason, Some(Reason::Discarded | Reason::LinkLost | Reason::Late));
        let passed = call.may_fail && !ended;
        if answer.code != 0 && !passed && self.failed.is_none() {
            self.failed = Some(answer.clone());
        }
        if index >= self.progress.entries {
            return Ok(None);
        }
        self.progress.answered += 1;
        Ok(Some(answer))
    }

    /// Keeps what a reply to PT data says of its stream.
    fn note_stream(&mut self, call: &Call, answer: &Answer) {
        if answer.code != 0 || class(answer.opcode).is_none_or(|class| class.kind != CommandKind::Data(DataStore::Pt)) {
            return;
        }
        let (Some(core), Some(axis)) = (i16_at(&call.payload, 0), i16_at(&call.payload, 2)) else { return };
        let Ok(taken) = PtTaken::read_from_bytes(&answer.reply) else { return };
        let dry = Dry { core, axis, space: taken.space.get(), dry_ms: taken.dry_ms.get() };
        match self.progress.streams.iter_mut().find(|d| d.core == core && d.axis == axis) {
            Some(place) => *place = dry,
            None => self.progress.streams.push(dry),
        }
    }

    /// Everything is there, or as much as fits.
    fn ready_to_start(&mut self) -> bool {
        // A queue that is full for a moment is being emptied into the axes' stores: what is
        // admitted before the start is not late.
        let full = self.stuck >= STUCK_LOOKS && self.blocked;
        !self.started
            && self.failed.is_none()
            && self.progress.queue.state == state::HELD
            && self.query.is_none()
            && (full || self.exhausted && self.ahead.is_empty())
    }

    /// Nothing is left to do or to wait for.
    fn is_over(&self) -> bool {
        let queue = self.progress.queue;
        if self.failed.is_some() {
            return self.flight.is_empty();
        }
        let ended = matches!(queue.state, state::EMPTY | state::FAILED | state::STOPPED);
        self.started && self.exhausted && self.ahead.is_empty() && self.flight.is_empty() && ended
    }
}

/// Bytes of the controller's queue that a call takes, at most.
fn cost(call: &Call) -> u32 {
    call.payload.len() as u32 + ENTRY_OVERHEAD_BYTES
}

/// The little-endian `i16` at `at`.
fn i16_at(bytes: &[u8], at: usize) -> Option<i16> {
    bytes.get(at..at + 2).and_then(|b| b.try_into().ok()).map(i16::from_le_bytes)
}
