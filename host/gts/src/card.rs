//! An opened controller, and the slots for seventeen of them: the one of `GT_`/`GTN_`, and cards 0
//! to 15.
//!
//! Owns the client, the queue of PT data, the files of a trace, and a thread where time has to be
//! driven or a queue sent. A slot is locked for the whole of a call: calls of several threads
//! follow each other. An Abort, a Close and the end of the process have priority.

use crate::board_memory::{Virtual, retire};
use crate::boundary::Arg;
use crate::home::Homes;
use crate::recorder::{Claim, Recorder};
use crate::settings::{LinkChoice, Settings};
use crate::stream::Stream;
use client::error::{CANNOT_OPEN, NO_ANSWER};
use client::inputs::{Inputs, Zero};
use client::{Call, Client, Error, Options, ProductProfile, Result};
use job::Used;
use job::api::Function;
use protocol::command::{GetSts, Trace, opcode};
use protocol::values::status::RUNNING;
use std::ffi::{CString, c_char, c_short};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, Once, PoisonError, TryLockError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use virtual_board::{Config, Pace, PacedLink, VirtualLink};

/// Servo tick of the virtual controller: the compatible value of SPEC 1.
const TICK_US: u32 = 250;
/// Time between two looks of the thread.
const POLL_PERIOD: Duration = Duration::from_millis(1);
/// At the end of the process, calls of other threads are waited for no longer than this.
const EXIT_TIMEOUT: Duration = Duration::from_secs(1);
/// Between two looks of a call that lets another one go first.
const YIELD_PERIOD: Duration = Duration::from_micros(100);

/// A slot for a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CardSlot(usize);

/// Cards that the family for several has, and the one of the other two.
const SLOTS: usize = 17;
static STATES: [Mutex<State>; SLOTS] = [const { Mutex::new(State { card: None, version: None }) }; SLOTS];

/// Calls with priority over others, for each slot.
static FIRST: [AtomicUsize; SLOTS] = [const { AtomicUsize::new(0) }; SLOTS];

/// All slots.
pub fn all() -> impl Iterator<Item = CardSlot> {
    (0..SLOTS).map(CardSlot)
}

impl CardSlot {
    /// How many there are.
    pub const COUNT: usize = SLOTS;

    /// Its place among all, from 0.
    pub fn index(self) -> usize {
        self.0
    }

    /// The one card of `GT_` and `GTN_`.
    pub const ONE: CardSlot = CardSlot(0);

    /// A card of several.
    pub fn card(number: c_short) -> Option<CardSlot> {
        usize::try_from(number).ok().map(|number| CardSlot(number + 1)).filter(|slot| slot.0 < SLOTS)
    }

    /// Its number among several.
    pub fn number(self) -> Option<usize> {
        self.0.checked_sub(1)
    }

    /// Locks the slot for this thread, once no call with priority waits.
    pub fn lock(self) -> MutexGuard<'static, State> {
        loop {
            while self.is_asked_for() {
                std::thread::sleep(YIELD_PERIOD);
            }
            let state = self.wait();
            // A lock is not given in the order in which it was asked for.
            if !self.is_asked_for() {
                return state;
            }
        }
    }

    /// Locks the slot for this thread, before all calls that have not begun.
    pub fn lock_first(self) -> MutexGuard<'static, State> {
        FIRST[self.0].fetch_add(1, Ordering::SeqCst);
        let state = self.wait();
        FIRST[self.0].fetch_sub(1, Ordering::SeqCst);
        state
    }

    /// The same, if that takes no longer than until `end`.
    fn lock_first_until(self, end: Instant) -> Option<MutexGuard<'static, State>> {
        FIRST[self.0].fetch_add(1, Ordering::SeqCst);
        let state = loop {
            match self.try_lock() {
                None if Instant::now() < end => std::thread::sleep(YIELD_PERIOD),
                state => break state,
            }
        };
        FIRST[self.0].fetch_sub(1, Ordering::SeqCst);
        state
    }

    fn is_asked_for(self) -> bool {
        FIRST[self.0].load(Ordering::SeqCst) != 0
    }

    fn wait(self) -> MutexGuard<'static, State> {
        STATES[self.0].lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn try_lock(self) -> Option<MutexGuard<'static, State>> {
        match STATES[self.0].try_lock() {
            Ok(state) => Some(state),
            Err(TryLockError::Poisoned(state)) => Some(state.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

/// What is to be opened.
#[derive(Debug, Clone, Copy)]
pub struct Opening {
    /// Where.
    pub slot: CardSlot,
    /// It was GTN_Open.
    pub gtn: bool,
    /// Its second argument: 2 is a GSN controller, 1 any other.
    pub param: i64,
}

/// A slot.
pub struct State {
    card: Option<Card>,
    /// What GetVersion shows; it stays until the next Open.
    version: Option<CString>,
}

impl State {
    /// Whether a controller is open here.
    pub fn is_open(&self) -> bool {
        self.card.is_some()
    }

    /// The controller; −7 if none is open.
    pub fn card(&mut self, function: &str) -> Result<&mut Card> {
        self.card.as_mut().ok_or_else(|| {
            Error::new(NO_ANSWER, format!("{function}: no controller is open; call GT_Open or GTN_Open first"))
        })
    }

    /// The text of GetVersion.
    pub fn version(&self) -> *const c_char {
        self.version.as_ref().map_or(std::ptr::null(), |text| text.as_ptr())
    }

    /// Opens a controller; −6 if one is open here.
    pub fn open(&mut self, opening: Opening) -> Result<()> {
        if self.is_open() {
            return Err(Error::new(CANNOT_OPEN, "Open: the controller is open already; call Close first"));
        }
        let settings = Settings::read(opening.slot, |name| std::env::var(name).ok())?;
        if let Some(path) = &settings.log {
            crate::log::begin(opening.slot, path)?;
        }
        let card = Card::open(opening, settings)?;
        let text = card.describe();
        self.version = CString::new(text).ok();
        self.card = Some(card);
        crate::fork::opened();
        static AT_EXIT: Once = Once::new();
        AT_EXIT.call_once(|| crate::at_exit::run(finish));
        Ok(())
    }

    /// Closes it; nothing to do if none is open.
    pub fn close(&mut self) -> Result<()> {
        self.card.take().map_or(Ok(()), |card| {
            crate::fork::closed();
            card.close()
        })
    }
}

/// At the end of the process: what programs leave open is closed, so that nothing stays lit and
/// traces are complete.
extern "C" fn finish() {
    if crate::fork::is_child() {
        return;
    }
    let _ = std::panic::catch_unwind(|| {
        let end = Instant::now() + EXIT_TIMEOUT;
        for slot in all() {
            // Another thread may be in a call that does not end.
            if let Some(mut state) = slot.lock_first_until(end) {
                let _ = state.close();
                crate::log::end(slot);
            }
        }
    });
}

/// How the controller's time passes.
#[derive(Clone)]
pub enum Time {
    /// By itself.
    Own,
    /// With the wall clock, by this library.
    Paced(Pace),
    /// In calls and sleeps only.
    Calls,
}

/// See the module text.
pub struct Card {
    client: Arc<Client>,
    time: Time,
    stream: Stream,
    recorder: Option<Arc<Mutex<Recorder>>>,
    _files: Claim,
    keeper: Option<Keeper>,
    /// Dropped after the client, which refers to it.
    _memory: Retired,
    /// Close has been called: the time is not driven any more.
    closed: Arc<AtomicBool>,
    /// Its number among all that this process has opened, from 1.
    pub serial: u64,
    /// Something was set in motion.
    pub started: bool,
    /// What the program has used, for the trace.
    used: Used,
    /// Axes on their way home.
    homes: Arc<Homes>,
    /// Settings that change nothing (`more`).
    pub kept: crate::more::Kept,
    /// Keys of `compat`.
    pub keys: crate::compat::Keys,
}

/// The memory of a virtual controller; freed when this is dropped, or later.
struct Retired(Option<Virtual>);

impl Drop for Retired {
    fn drop(&mut self) {
        retire(self.0.take());
    }
}

impl Card {
    fn open(opening: Opening, settings: Settings) -> Result<Card> {
        let wrong =
            |error: Error| Error { code: CANNOT_OPEN, reason: format!("BEAMTICK_INPUTS: {}", error.reason), ..error };
        let inputs = settings.inputs.as_deref().map(Inputs::open).transpose();
        let inputs = inputs.map_err(|reason| wrong(Error::new(CANNOT_OPEN, reason)))?;
        let files = Claim::of(opening.slot, &settings)?;
        let mut options = Options { profile: settings.profile, family: settings.family, ..Options::default() };
        // Freed last, and if Open fails too.
        let mut memory = Retired(None);
        let (client, time) = match &settings.road {
            LinkChoice::Virtual(factor) => {
                let profile = *options.profile.get_or_insert(match opening {
                    Opening { gtn: false, .. } => ProductProfile::Gus,
                    Opening { param: 2, .. } => ProductProfile::Gsn024,
                    Opening { .. } => ProductProfile::Gtn016,
                });
                options.family.get_or_insert_default();
                let own = Virtual::new(Config { tick_us: TICK_US, profile: profile as u8, ..Config::default() });
                let Some(shared) = own.shared() else { unreachable!("it was just made") };
                memory.0 = Some(own);
                match factor {
                    Some(factor) => {
                        let (link, pace) = PacedLink::new(shared, *factor);
                        (Client::open(Box::new(link), options)?, Time::Paced(pace))
                    }
                    None => (Client::open(Box::new(VirtualLink::new(shared)), options)?, Time::Calls),
                }
            }
            LinkChoice::Qemu => {
                let image = client::qemu::image(None)?;
                let link = client::link::open(&format!("qemu:{}", image.display()))?;
                (Client::open(link, options)?, Time::Own)
            }
            LinkChoice::Link(name) => (Client::open(client::link::open(name)?, options)?, Time::Own),
        };
        let recorder = match memory.0.is_some() && settings.is_traced() {
            true => Some(Recorder::start(&client, &settings)?),
            false => None,
        };
        if let Some(inputs) = inputs {
            inputs.plan(&client, Zero::Now).map_err(wrong)?;
        }
        let client = Arc::new(client);
        let homes: Arc<Homes> = Arc::default();
        let keeper = match &time {
            Time::Calls => None,
            time => Some(Keeper::start(opening.slot, (Arc::clone(&client), Arc::clone(&homes)), time.clone())),
        };
        let keys = crate::compat::Keys::read(client.now());
        let stream = Stream::new(settings.batches, client.version().step_limit.get());
        let closed = Arc::default();
        static OPENED: AtomicU64 = AtomicU64::new(1);
        let serial = OPENED.fetch_add(1, Ordering::Relaxed);
        Ok(Card {
            client,
            time,
            stream,
            recorder,
            _files: files,
            keeper,
            closed,
            _memory: memory,
            serial,
            started: false,
            used: Used::default(),
            homes,
            kept: Default::default(),
            keys,
        })
    }

    fn close(mut self) -> Result<()> {
        self.closed.store(true, Ordering::Relaxed);
        drop(self.keeper.take());
        let flushed = self.flush();
        // Before the trace ends, so that it shows it.
        let aborted = self.client.end();
        let recorded = match self.recorder.take() {
            Some(recorder) => crate::recorder::finish(&self.client, &recorder, &self.used),
            None => Ok(()),
        };
        flushed.and(aborted).and(recorded)
    }

    fn describe(&self) -> String {
        let version = self.client.version();
        let profile = ProductProfile::numbered(version.profile).map_or("unknown", ProductProfile::name);
        let family = if version.family == 0 { "gus" } else { "lsr" };
        format!(
            "Beamtick {}.{}.{}, board {}, profile {profile}, family {family}, long of {} bits",
            version.major,
            version.minor,
            version.patch,
            self.client.board(),
            crate::width::BITS
        )
    }

    /// Takes note of what a call uses, for the trace.
    pub fn note(
        &mut self,
        function: &Function,
        core: c_short,
        values: impl Iterator<Item = (&'static str, Arg)> + Clone,
    ) {
        if self.recorder.is_some() {
            self.used.note(function, core, values.map(|(name, value)| (name, value.number())));
        }
    }

    /// Its axes on their way home.
    pub fn homes(&self) -> Arc<Homes> {
        Arc::clone(&self.homes)
    }

    /// Takes them on, where no thread does.
    pub fn step_homes(&self) {
        if let Time::Calls = self.time {
            self.homes.step(&self.client);
        }
    }

    /// There is something to do for the thread.
    pub fn wake(&self) {
        if let Some(keeper) = &self.keeper {
            keeper.wake();
        }
    }

    /// The client, for what needs no order among calls.
    pub fn client(&self) -> (Arc<Client>, Time) {
        (Arc::clone(&self.client), self.time.clone())
    }

    /// Whether it has been closed; threads that wait meanwhile are notified.
    pub fn closed(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.closed)
    }

    /// Sends the calls of one function together, after what is queued; the first refusal is the
    /// function's. PT data that was queued gives no reply.
    pub fn send(&mut self, reads: bool, calls: &[Call]) -> Result<Option<Vec<Vec<u8>>>> {
        if let Some(error) = self.stream.failed() {
            return Err(error);
        }
        let [call] = calls else {
            self.flush()?;
            self.stream.forget();
            return self.client.call_all(calls)?.into_iter().collect::<Result<_>>().map(Some);
        };
        if let Some(answer) = self.stream.answer(call) {
            return Ok(Some(vec![answer]));
        }
        if self.stream.take(call) {
            if self.stream.is_full() {
                self.flush()?;
            } else if let Some(keeper) = &self.keeper {
                keeper.wake();
            }
            return Ok(None);
        }
        let replies = match self.stream.batch() {
            // A read travels with the data before it.
            Some(batch) if reads => {
                let mut replies = self.client.call_all(&[batch, call.clone()])?;
                let read = replies.pop();
                if let Some(Err(error)) = replies.pop() {
                    self.stream.forget();
                    return Err(late(error));
                }
                read.into_iter().collect::<Result<_>>()?
            }
            Some(batch) => {
                self.settle(&batch)?;
                vec![self.client.call_raw(call)?]
            }
            None => {
                let reply = self.client.call_raw(call);
                if reply.is_err() && call.opcode == opcode::PtData {
                    self.stream.forget();
                }
                vec![reply?]
            }
        };
        if let Some(reply) = replies.first() {
            self.stream.note(call, reads, reply);
        }
        Ok(Some(replies))
    }

    /// Sends queued PT data.
    pub fn flush(&mut self) -> Result<()> {
        self.stream.batch().map_or(Ok(()), |batch| self.settle(&batch))
    }

    fn settle(&mut self, batch: &Call) -> Result<()> {
        match self.client.call_raw(batch) {
            Ok(reply) => {
                self.stream.settled(&reply);
                Ok(())
            }
            Err(error) => {
                self.stream.forget();
                Err(late(error))
            }
        }
    }

    /// A call is done; where time passes in calls only, a read lasts for a tick, so that loops of
    /// reads end.
    pub fn passed(&mut self, reads: bool) -> Result<()> {
        match self.time {
            Time::Calls if reads => {
                self.client.sleep(Duration::from_micros(self.client.version().tick_us.get().into()))
            }
            _ => Ok(()),
        }
    }

    /// Whether any axis moves.
    pub fn is_moving(&self) -> Result<bool> {
        let version = self.client.version();
        for core in 1..=i16::from(version.cores) {
            let all = GetSts { core: core.into(), axis: 1.into(), count: i16::from(version.axes_per_core).into() };
            let (_, status) = self.client.call_items(all, &[])?;
            if status.iter().any(|axis| axis.value.get().cast_unsigned() & RUNNING != 0) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// An error of data that an earlier call had queued.
fn late(error: Error) -> Error {
    Error { reason: format!("of PtData called before this: {}", error.reason), ..error }
}

/// Sends the queue of a card and drives its time.
struct Keeper {
    shared: Arc<(Mutex<bool>, Condvar, AtomicBool)>,
    thread: Option<JoinHandle<()>>,
}

impl Keeper {
    fn start(slot: CardSlot, (client, homes): (Arc<Client>, Arc<Homes>), time: Time) -> Keeper {
        let shared = Arc::new((Mutex::new(false), Condvar::new(), AtomicBool::new(false)));
        let theirs = Arc::clone(&shared);
        let thread = std::thread::spawn(move || {
            let (ends, bell, queued) = &*theirs;
            loop {
                let end = ends.lock().unwrap_or_else(PoisonError::into_inner);
                let has_work = || queued.load(Ordering::Relaxed) || homes.run();
                let idle = matches!(time, Time::Own) && !has_work();
                let end = if idle {
                    bell.wait_while(end, |end| !*end && !has_work()).unwrap_or_else(PoisonError::into_inner)
                } else {
                    bell.wait_timeout_while(end, POLL_PERIOD, |end| !*end).unwrap_or_else(PoisonError::into_inner).0
                };
                if *end {
                    return;
                }
                drop(end);
                if let Time::Paced(pace) = &time {
                    let now = || client.now().as_nanos() as u64;
                    // The next call reports a failure.
                    pace.catch_up(now, |ns| drop(client.sleep(Duration::from_nanos(ns))));
                }
                homes.step(&client);
                if queued.load(Ordering::Relaxed)
                    && let Some(mut state) = slot.try_lock()
                    && let Ok(card) = state.card("")
                {
                    queued.store(false, Ordering::Relaxed);
                    card.flush_later();
                }
            }
        });
        Keeper { shared, thread: Some(thread) }
    }

    /// There is something in the queue.
    fn wake(&self) {
        if !self.shared.2.swap(true, Ordering::Relaxed) {
            let _end = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
            self.shared.1.notify_all();
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        *self.shared.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.shared.1.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Card {
    /// Sends queued data in the background; the next call reports a failure.
    pub fn flush_later(&mut self) {
        if let Err(error) = self.flush() {
            self.stream.fail(error);
        }
    }
}

/// What a trace records: everything that the profile has.
pub fn everything(client: &Client) -> Trace {
    let version = client.version();
    let axes = u32::from(version.cores) * u32::from(version.axes_per_core);
    let crds = u32::from(version.cores) * u32::from(version.crds_per_core);
    Trace {
        every: 1.into(),
        axes: 1u64.checked_shl(axes).unwrap_or(0).wrapping_sub(1).into(),
        lasers: 1u8.checked_shl(version.lasers.into()).unwrap_or(0).wrapping_sub(1),
        crds: 1u8.checked_shl(crds).unwrap_or(0).wrapping_sub(1),
        over_link: 0,
        edges: 3,
    }
}
