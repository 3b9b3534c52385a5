//! An opened controller.
use crate::call::{Call, decode};
use crate::error::{Error, Result};
use crate::link::Link;
use crate::options::Options;
use crate::program::{Observer, Program, Summary};
use crate::session::{Reply, Session};
use protocol::command::{Abort, Choose, Request, VersionReply};
use protocol::link::{Identity, LinkCounters};
use protocol::record::{JobState, Lane};
use std::collections::VecDeque;
use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use zerocopy::little_endian::I16;

/// Longest time that one pump holds the link, so that other threads get their turn.
const PUMP_MAX: Duration = Duration::from_millis(2);
/// The same in virtual time, where no other process waits and a receive returns with the first
/// byte.
const VIRTUAL_PUMP_MAX: Duration = Duration::from_millis(50);
/// Longest time without a pump while no call is under way.
const IDLE_PUMP_PERIOD: Duration = Duration::from_millis(50);
/// The most that one receive without bytes counts as silence. If it takes longer, the machine
/// delayed the client, and perhaps the controller that it emulates: the answer may still be unread
/// or in transfer.
const SILENCE_MAX: Duration = Duration::from_millis(50);

/// One is for the whole controller.
const ABORT: Abort = Abort { core: I16::new(1) };
/// Dropping a client waits for the answer to its Abort for no longer than this, times the link's
/// patience.
const ABORT_TIMEOUT: Duration = Duration::from_millis(400);

/// Where the trace stream's bytes go.
type TraceSink = Box<dyn FnMut(&[u8]) + Send>;

pub(crate) struct Inner {
    /// Longest wait of one pump.
    pub(crate) turn: Duration,
    link: Box<dyn Link>,
    pub(crate) session: Session,
    trace: Option<TraceSink>,
    trace_bytes: Vec<u8>,
    received: Vec<u8>,
    outgoing: Vec<u8>,
    failed: Option<Error>,
    /// Time spent looking for bytes, and how much of it had been spent when the last good frame
    /// came.
    listened: Duration,
    heard: Duration,
    /// When the link was last looked at, and the longest time from look to look.
    polled_at: u64,
    held_up: Duration,
}

impl Inner {
    fn new(mut link: Box<dyn Link>, identity: Identity, read_only: bool) -> Self {
        let (now, name) = (link.now(), link.name().to_owned());
        // In virtual time the same calls must give the same bytes, so nothing is random there. A
        // later client is another one, even if the one before it ended without a message.
        let chance = || RandomState::new().hash_one(std::process::id()) as u32;
        let nonce = if link.real_time() { chance() } else { (now as u32).wrapping_add(1) };
        let turn = if link.real_time() { PUMP_MAX } else { VIRTUAL_PUMP_MAX };
        let session = Session::open(&name, now, nonce, identity, read_only);
        Inner {
            turn,
            link,
            session,
            trace: None,
            trace_bytes: Vec::new(),
            received: vec![0; 8192],
            outgoing: Vec::new(),
            failed: None,
            listened: Duration::ZERO,
            heard: Duration::ZERO,
            polled_at: now,
            held_up: Duration::ZERO,
        }
    }

    pub(crate) fn now(&mut self) -> u64 {
        self.link.now()
    }

    /// Sends what is due, receives for at most `wait`, and takes in what came.
    pub(crate) fn pump(&mut self, wait: Duration) -> Result<()> {
        if let Some(failed) = &self.failed {
            return Err(failed.clone());
        }
        let result = self.pump_once(wait);
        if let Err(e) = &result {
            self.failed = Some(e.clone());
        }
        result
    }

    fn pump_once(&mut self, wait: Duration) -> Result<()> {
        let now = self.link.now();
        self.outgoing.clear();
        self.session.send(now, &mut self.outgoing);
        if !self.outgoing.is_empty() {
            self.link.send(&self.outgoing)?;
        }
        let wait = wait.min(Duration::from_nanos(self.session.next_deadline().saturating_sub(now)));
        let n = self.link.receive(&mut self.received, wait)?;
        let (began, now) = (now, self.link.now());
        self.listened += Duration::from_nanos(now.saturating_sub(began)).min(SILENCE_MAX);
        self.held_up = self.held_up.max(Duration::from_nanos(now.saturating_sub(self.polled_at)));
        self.polled_at = now;
        if let Some(bytes) = self.received.get(..n)
            && self.session.feed(now, bytes)?
        {
            self.heard = self.listened;
        }
        if self.link.has_trace() {
            self.link.take_trace(&mut self.trace_bytes)?;
        }
        self.session.take_trace(&mut self.trace_bytes);
        if let Some(sink) = &mut self.trace
            && !self.trace_bytes.is_empty()
        {
            sink(&self.trace_bytes);
        }
        self.trace_bytes.clear();
        Ok(())
    }
}

/// What the client and its keep-alive thread share.
struct Shared {
    inner: Mutex<Inner>,
    stop: Mutex<bool>,
    wake: Condvar,
}

/// An opened controller. Calls may come from several threads at once.
///
/// On a link in real time a thread of its own keeps the link alive between calls. Where anything
/// was commanded, dropping it ends with [`Client::abort`]; one that has only read changes nothing.
pub struct Client {
    shared: Arc<Shared>,
    keeper: Option<JoinHandle<()>>,
    name: String,
    version: VersionReply,
    timeout: Duration,
    joins: bool,
}

impl Client {
    /// Opens the session on a link, compares versions and chooses profile, family and tick.
    ///
    /// # Errors
    /// −7 if nothing answers; 3 if client and firmware do not match, or the board cannot hold the
    /// profile; 7 if the tick period is out of its range. −6 if the controller is open already, or
    /// gives no read-only session.
    pub fn open(link: Box<dyn Link>, options: Options) -> Result<Client> {
        let name = link.name().to_owned();
        let mut inner = Inner::new(link, options.identity, options.read_only);
        let patience = inner.link.patience();
        let limit = options.open_timeout * patience;
        while !inner.session.is_open()? {
            let turn = inner.turn;
            inner.pump(turn)?;
            if inner.listened > limit {
                return Err(Error::no_answer(&name, limit, "opening"));
            }
        }
        let shared = Arc::new(Shared { inner: Mutex::new(inner), stop: Mutex::new(false), wake: Condvar::new() });
        let mut client = Client {
            shared,
            keeper: None,
            name,
            version: VersionReply::default(),
            timeout: options.timeout * patience,
            joins: options.joins,
        };
        client.version = client.call(protocol::command::Version {})?;
        if options.read_only {
            client.keep();
            return Ok(client);
        }
        let family = options.family.map_or(client.version.family, |family| family as u8);
        if options.profile.is_some() || family != client.version.family {
            let profile = options.profile.map_or(client.version.profile, |p| p as u8);
            client.version = client.call(Choose { profile, family })?;
        }
        if let Some(tick_us) = options.tick_us
            && client.version.tick_us.get() != tick_us
        {
            let tick_us = i32::try_from(tick_us).unwrap_or(i32::MAX);
            client.call(protocol::command::SetTick { tick_us: tick_us.into() })?;
            client.version = client.call(protocol::command::Version {})?;
        }
        client.keep();
        Ok(client)
    }

    /// Begins to keep the link alive between calls, where time passes by itself.
    fn keep(&mut self) {
        if self.lock().link.real_time() {
            let shared = Arc::clone(&self.shared);
            self.keeper = Some(std::thread::spawn(move || keep_alive(&shared)));
        }
    }

    /// The job of the program that shares its link with this read-only session, and its name; none
    /// where nobody has said so.
    pub fn job(&self) -> Option<(JobState, String)> {
        self.lock().session.job()
    }

    /// Whether calls of a program for one FIFO of a path travel together.
    pub(crate) fn joins(&self) -> bool {
        self.joins
    }

    /// The link's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the controller is.
    pub fn version(&self) -> &VersionReply {
        &self.version
    }

    /// Name of the controller's board.
    pub fn board(&self) -> String {
        let bytes: Vec<u8> = self.version.board.iter().copied().take_while(|b| *b != 0).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// Makes a call and waits for its reply.
    pub fn call<R: Request>(&self, request: R) -> Result<R::Reply> {
        self.call_items(request, &[]).map(|(reply, _)| reply)
    }

    /// Makes a call with items and waits for its reply and the reply's items.
    pub fn call_items<R: Request>(&self, request: R, items: &[R::Item]) -> Result<(R::Reply, Vec<R::ReplyItem>)> {
        decode::<R>(&self.call_raw(&Call::with_items::<R>(request, items))?)
    }

    /// Makes a packed call and waits for its packed reply.
    pub fn call_raw(&self, call: &Call) -> Result<Vec<u8>> {
        let tag = self.lock().session.post(Lane::Immediate, call)?;
        loop {
            let mut inner = self.lock();
            if let Some(Reply { code, payload, .. }) = inner.session.take(tag) {
                return if code == 0 { Ok(payload) } else { Err(crate::call::refused(call.opcode, code, &payload)) };
            }
            let turn = inner.turn;
            inner.pump(turn)?;
            self.check_heard(&mut inner, || format!("in {}", crate::call::name(call.opcode)))?;
        }
    }

    /// Makes packed calls in one go: they travel together and are executed in their order, each
    /// whatever became of those before it.
    pub fn call_all(&self, calls: &[Call]) -> Result<Vec<Result<Vec<u8>>>> {
        let replies = self.exchange(calls)?.into_iter().zip(calls);
        let result = |((code, payload), call): ((i16, Vec<u8>), &Call)| match code {
            0 => Ok(payload),
            _ => Err(crate::call::refused(call.opcode, code, &payload)),
        };
        Ok(replies.map(result).collect())
    }

    /// As [`Self::call_all`]: the code and the packed reply or refusal of each.
    pub fn exchange(&self, calls: &[Call]) -> Result<Vec<(i16, Vec<u8>)>> {
        let mut tags = VecDeque::with_capacity(calls.len());
        let mut inner = self.lock();
        for call in calls {
            tags.push_back((inner.session.post(Lane::Immediate, call)?, call.opcode));
        }
        let mut replies = Vec::with_capacity(calls.len());
        loop {
            while let Some(&(tag, _)) = tags.front()
                && let Some(Reply { code, payload, .. }) = inner.session.take(tag)
            {
                tags.pop_front();
                replies.push((code, payload));
            }
            let Some(&(_, opcode)) = tags.front() else { return Ok(replies) };
            let turn = inner.turn;
            inner.pump(turn)?;
            self.check_heard(&mut inner, || format!("in {}", crate::call::name(opcode)))?;
            drop(inner);
            inner = self.lock();
        }
    }

    /// Shuts off every laser at once and stops all motion smoothly (`GT_Abort`). Axes may still
    /// brake when this returns.
    ///
    /// # Errors
    /// 8 if the firmware is older than the command, and those of the link. The controller then
    /// shuts off its lasers by itself when the link is lost.
    pub fn abort(&self) -> Result<()> {
        self.call(ABORT).map(drop)
    }

    /// Aborts if any call but a read was made, as dropping the client does, and reports the
    /// outcome. Over a link that has failed, which was reported then, it does nothing.
    ///
    /// # Errors
    /// Those of [`Self::abort`].
    pub fn end(&self) -> Result<()> {
        let inner = self.lock();
        if inner.failed.is_some() || !inner.session.commanded() {
            return Ok(());
        }
        drop(inner);
        self.abort()
    }

    /// The calls of [`Self::abort`], for [`Self::call_all`] with others before and after them.
    pub fn aborts(&self) -> Vec<Call> {
        (1..=i16::from(self.version.cores)).map(|core| Call::of(Abort { core: core.into() })).collect()
    }

    /// Fails with −7 if nothing came for the time limit.
    pub(crate) fn check_heard(&self, inner: &mut Inner, doing: impl FnOnce() -> String) -> Result<()> {
        let silent = inner.listened.saturating_sub(inner.heard);
        if silent > self.timeout {
            let e = Error::no_answer(&self.name, silent, &doing());
            inner.failed = Some(e.clone());
            return Err(e);
        }
        Ok(())
    }

    /// Lets `time` pass on the link's own clock, keeping the link alive.
    pub fn sleep(&self, time: Duration) -> Result<()> {
        let end = self.lock().now().saturating_add(nanoseconds(time));
        loop {
            let mut inner = self.lock();
            let left = end.saturating_sub(inner.now());
            if left == 0 {
                return Ok(());
            }
            let turn = inner.turn.min(Duration::from_nanos(left));
            inner.pump(turn)?;
        }
    }

    /// Time on the link's own clock, from anywhere.
    pub fn now(&self) -> Duration {
        Duration::from_nanos(self.lock().now())
    }

    /// The longest time so far between two looks at the link, on its own clock: for longer than
    /// some 50 ms it is the machine that held the client up.
    pub fn held_up(&self) -> Duration {
        self.lock().held_up
    }

    /// Whether the link has a stream of its own for a trace.
    pub fn has_trace(&self) -> bool {
        self.lock().link.has_trace()
    }

    /// Bytes a second that a trace may have when it uses the link itself (`Trace` with `way` 1);
    /// none when it has a stream of its own.
    pub fn trace_rate(&self) -> Option<u32> {
        let inner = self.lock();
        (!inner.link.has_trace()).then(|| inner.link.trace_rate())
    }

    /// What this end of the link has counted since it was opened.
    pub fn counters(&self) -> LinkCounters {
        self.lock().session.counters()
    }

    /// Sends the trace stream's bytes to `sink` from now on, as they come.
    pub fn trace_to(&self, sink: impl FnMut(&[u8]) + Send + 'static) {
        self.lock().trace = Some(Box::new(sink));
    }

    /// An empty program for this controller.
    pub fn program(&self) -> Program<'_> {
        Program::new(self)
    }

    /// Runs the calls of `calls` as a program; see [`Program::run`]. The calls are taken from the
    /// iterator as the controller's queue takes them.
    pub fn run(
        &self,
        calls: impl IntoIterator<Item = Call>,
        strict: bool,
        observer: &mut dyn Observer,
    ) -> Result<Summary> {
        crate::program::run(self, &mut calls.into_iter(), strict, observer)
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, Inner> {
        self.shared.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        *self.shared.stop.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.shared.wake.notify_all();
        if let Some(keeper) = self.keeper.take() {
            let _ = keeper.join();
        }
        let mut inner = self.lock();
        if inner.failed.is_some() {
            return;
        }
        if inner.session.commanded()
            && let Ok(tag) = inner.session.post(Lane::Immediate, &Call::of(ABORT))
        {
            let end = inner.listened + ABORT_TIMEOUT * inner.link.patience();
            let turn = inner.turn;
            while inner.session.take(tag).is_none() && inner.listened < end && inner.pump(turn).is_ok() {}
        }
        if inner.failed.is_none() {
            inner.session.close();
            let _ = inner.pump(Duration::ZERO);
        }
    }
}

/// Pumps the link between calls.
fn keep_alive(shared: &Shared) {
    let mut stop = shared.stop.lock().unwrap_or_else(PoisonError::into_inner);
    let mut idle = IDLE_PUMP_PERIOD;
    while !*stop {
        drop(stop);
        if let Ok(mut inner) = shared.inner.try_lock() {
            // The next call reports a failure.
            let _ = inner.pump(Duration::from_micros(100));
            idle = IDLE_PUMP_PERIOD.min(Duration::from_nanos(inner.session.silence() / 2));
        }
        stop = shared.stop.lock().unwrap_or_else(PoisonError::into_inner);
        stop = shared.wake.wait_timeout_while(stop, idle, |s| !*s).unwrap_or_else(PoisonError::into_inner).0;
    }
}

pub(crate) fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}
