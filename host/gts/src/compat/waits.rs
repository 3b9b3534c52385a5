//! Waits of a program's threads: for a time, for each other, for events; in the program's time.
//!
//! In: blocked threads with their deadlines, signals. Out: each wakes when what it waits for is
//! there, or at its deadline. Where the controller's time passes in calls and sleeps only
//! (`virtual:max`), sleeps of several threads overlap as they would on a clock: time goes on to the
//! earliest deadline once every thread waits here. A thread that waits elsewhere, in a lock or a
//! `join` of its own, is not known here; after [`OTHERS_TIMEOUT`] of wall-clock time the others go
//! on without it, until it comes here again.

use super::clock::{Source, Virtual, now};
use crate::card::Time;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Waited for threads that do not wait here; then they count as waiting elsewhere.
const OTHERS_TIMEOUT: Duration = Duration::from_millis(100);
/// A call waits so long for threads whose deadline it has passed.
const DEADLINE_TIMEOUT: Duration = Duration::from_millis(5);
/// Between two looks of a thread that waits for others.
const THREAD_POLL_PERIOD: Duration = Duration::from_millis(2);
/// The longest wall-clock wait between two looks.
const POLL_PERIOD: Duration = Duration::from_millis(50);

/// What is waited for, under one lock.
pub struct Inner {
    /// The objects of `objects`.
    pub objects: super::objects::Objects,
    /// Threads known here that do not wait, by their numbers.
    active: BTreeSet<u64>,
    /// Those of them that wait elsewhere, as far as is known.
    away: BTreeSet<u64>,
    /// Threads that were created and have not begun.
    expected: usize,
    /// Grows with every signal: a thread that has not looked since may have something to do.
    signals: u64,
    /// Threads that wait: deadline, and the signals seen at its last look.
    waiting: BTreeMap<u64, (Option<Duration>, u64)>,
    numbers: u64,
}

static INNER: Mutex<Inner> = Mutex::new(Inner {
    objects: super::objects::Objects::new(),
    active: BTreeSet::new(),
    away: BTreeSet::new(),
    expected: 0,
    signals: 0,
    waiting: BTreeMap::new(),
    numbers: 0,
});
static BELL: Condvar = Condvar::new();
/// The earliest deadline in ns of the program's time.
static EARLIEST: AtomicU64 = AtomicU64::new(u64::MAX);

thread_local! {
    static KNOWN: RefCell<Option<Known>> = const { RefCell::new(None) };
}

/// This thread counts as one that runs; its number.
struct Known(u64);

impl Drop for Known {
    fn drop(&mut self) {
        if crate::fork::is_child() {
            return;
        }
        let mut inner = lock();
        inner.active.remove(&self.0);
        inner.away.remove(&self.0);
        BELL.notify_all();
    }
}

/// Takes the lock.
pub fn lock() -> MutexGuard<'static, Inner> {
    INNER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A number of the calling thread.
pub fn me() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    thread_local! {
        static NUMBER: u64 = NEXT.fetch_add(1, Ordering::Relaxed);
    }
    NUMBER.try_with(|number| *number).unwrap_or(0)
}

/// Counts the calling thread among those whose waits are known. `is_expected`: its creator counts
/// it already.
pub fn register(is_expected: bool) {
    // A thread that is ending has no such value any more; it counts no longer.
    let _ = KNOWN.try_with(|known| {
        let mut known = known.borrow_mut();
        if known.is_none() {
            *known = Some(Known(me()));
            let mut inner = lock();
            inner.active.insert(me());
            inner.expected -= usize::from(is_expected);
        }
    });
}

/// A thread is about to start; it counts as one that runs.
pub fn expect_thread() {
    register(false);
    lock().expected += 1;
}

/// It did not start.
pub fn no_thread() {
    lock().expected -= 1;
}

impl Inner {
    fn earliest(&self) -> Option<Duration> {
        self.waiting.values().filter_map(|(deadline, _)| *deadline).min()
    }

    /// Something has changed that others may wait for.
    pub fn signal(&mut self) {
        self.signals += 1;
        BELL.notify_all();
    }

    /// Whether nothing happens any more until a deadline.
    fn is_quiet(&self) -> bool {
        self.expected == 0
            && self.active.is_subset(&self.away)
            && self.waiting.values().all(|(_, seen)| *seen == self.signals)
    }

    fn note_earliest(&self) {
        let ns = self.earliest().map_or(u64::MAX, |time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
        EARLIEST.store(ns, Ordering::Relaxed);
    }
}

/// Until when, and by which clock.
enum End {
    /// An instant of the wall clock.
    Wall(Option<Instant>),
    /// A time of the program's, by a virtual controller.
    Card(Option<Duration>, Virtual),
}

impl End {
    fn after(time: Option<Duration>) -> End {
        let source = Source::current(true);
        let deadline = time.map(|time| now(&source).saturating_add(time));
        match source {
            Source::Wall => End::Wall(time.and_then(|time| Instant::now().checked_add(time))),
            Source::Card(card) => End::Card(deadline, card),
        }
    }

    /// The deadline in the program's time, where a controller has it.
    fn deadline(&self) -> Option<Duration> {
        match self {
            End::Wall(_) => None,
            End::Card(deadline, _) => *deadline,
        }
    }

    /// How much is left, in the program's time; nothing without a deadline.
    fn left(&self) -> Option<Duration> {
        match self {
            End::Wall(end) => end.map(|end| end.saturating_duration_since(Instant::now())),
            End::Card(deadline, card) => {
                let source = Source::Card(card.clone());
                deadline.map(|deadline| deadline.saturating_sub(now(&source)))
            }
        }
    }

    /// Another thread has closed the controller: what is left passes on the wall clock, as fast as
    /// it would have there.
    fn follow_close(&mut self, left: Option<Duration>) {
        if let End::Card(_, card) = self
            && card.is_closed()
        {
            let wall = match &card.time {
                Time::Paced(pace) => left.map(|left| pace.wall(left.as_nanos() as u64)),
                _ => left.map(|_| Duration::ZERO),
            };
            *self = End::Wall(wall.and_then(|wall| Instant::now().checked_add(wall)));
        }
    }
}

/// Waits until `ready` gives something, for at most `time` of the program's; nothing if that has
/// passed.
pub fn wait<T>(time: Option<Duration>, mut ready: impl FnMut(&mut Inner) -> Option<T>) -> Option<T> {
    if crate::fork::is_child() {
        std::thread::sleep(time.unwrap_or_default());
        return None;
    }
    let mut end = End::after(time);
    register(false);
    let mut inner = lock();
    inner.numbers += 1;
    let number = inner.numbers;
    inner.active.remove(&me());
    inner.away.remove(&me());
    inner.waiting.insert(number, (end.deadline(), 0));
    inner.note_earliest();
    BELL.notify_all();
    // Since when nothing has moved, as far as is known here.
    let mut calm = (0, Duration::MAX, Instant::now());
    let found = loop {
        let signals = inner.signals;
        if let Some((_, seen)) = inner.waiting.get_mut(&number) {
            *seen = signals;
        }
        let found = ready(&mut inner);
        let left = end.left();
        if found.is_some() || left == Some(Duration::ZERO) {
            break found;
        }
        end.follow_close(left);
        let nap = match &end {
            End::Wall(_) => left.unwrap_or(POLL_PERIOD).min(POLL_PERIOD),
            End::Card(_, Virtual { time: Time::Paced(pace), .. }) => {
                left.map_or(POLL_PERIOD, |left| pace.wall(left.as_nanos() as u64)).min(POLL_PERIOD)
            }
            End::Card(deadline, Virtual { client, homes, .. }) => {
                let left = left.unwrap_or(Duration::MAX);
                if (calm.0, calm.1) != (signals, left) {
                    calm = (signals, left, Instant::now());
                }
                if calm.2.elapsed() >= OTHERS_TIMEOUT {
                    inner.away = inner.active.clone();
                }
                let is_first = deadline.is_some() && inner.earliest() == *deadline;
                let goes_on = inner.is_quiet() || calm.2.elapsed() >= OTHERS_TIMEOUT;
                // An axis on its way home is looked at in between.
                let portion = homes.step(client).map_or(left, |look| left.min(look));
                if is_first && goes_on && client.sleep(portion).is_ok() {
                    // Others may have the same deadline.
                    BELL.notify_all();
                    continue;
                }
                THREAD_POLL_PERIOD
            }
        };
        inner = BELL.wait_timeout(inner, nap).unwrap_or_else(PoisonError::into_inner).0;
    };
    inner.waiting.remove(&number);
    inner.active.insert(me());
    inner.note_earliest();
    found
}

/// Time has passed in a call: threads whose deadline has come go on before its caller does.
pub fn time_passed() {
    let earliest = EARLIEST.load(Ordering::Relaxed);
    if earliest == u64::MAX || crate::fork::is_child() {
        return;
    }
    let source = Source::current(false);
    let due = |inner: &Inner| inner.earliest().is_some_and(|first| first <= now(&source));
    let end = Instant::now() + DEADLINE_TIMEOUT;
    let mut inner = lock();
    while due(&inner) && Instant::now() < end {
        BELL.notify_all();
        inner = BELL.wait_timeout(inner, Duration::from_micros(200)).unwrap_or_else(PoisonError::into_inner).0;
    }
}
