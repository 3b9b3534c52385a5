//! Waits of a program's threads: for a time, for each other, for events; in the program's time.
//!
//! In: blocked threads with their deadlines, signals. Out: each wakes when what it waits for is
//! there, or at its deadline. Where the controller's time passes in calls and sleeps only
//! (`virtual:max`), sleeps of several threads overlap as they would on a clock: time goes on to the
//! earliest deadline once every thread waits here. A thread that waits elsewhere, in a lock or a
//! `join` of its own, is not known here; after [`GRACE`] of wall-clock time the others go on
//! without it.

use super::clock::{Source, Virtual, now};
use crate::card::Time;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Waited for a thread that does not wait here.
const GRACE: Duration = Duration::from_millis(5);
/// The longest wall-clock wait between two looks.
const LOOK: Duration = Duration::from_millis(50);

/// What is waited for, under one lock.
pub struct Inner {
    /// The objects of `objects`.
    pub objects: super::objects::Objects,
    /// Threads known here that do not wait.
    active: usize,
    /// Grows with every signal: a thread that has not looked since may have something to do.
    signals: u64,
    /// Threads that wait: deadline, and the signals seen at its last look.
    waiting: BTreeMap<u64, (Option<Duration>, u64)>,
    numbers: u64,
}

static INNER: Mutex<Inner> = Mutex::new(Inner {
    objects: super::objects::Objects::new(),
    active: 0,
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

/// This thread counts as one that runs.
struct Known;

impl Drop for Known {
    fn drop(&mut self) {
        lock().active -= 1;
        BELL.notify_all();
    }
}

/// Takes the lock.
pub fn lock() -> MutexGuard<'static, Inner> {
    INNER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Counts the calling thread among those whose waits are known. `counted`: its creator has done so.
pub fn register(counted: bool) {
    // A thread that is ending has no such value any more; it counts no longer.
    let _ = KNOWN.try_with(|known| {
        let mut known = known.borrow_mut();
        if known.is_none() {
            *known = Some(Known);
            if !counted {
                lock().active += 1;
            }
        }
    });
}

/// A thread that is about to start counts as one that runs.
pub fn expect_thread() {
    register(false);
    lock().active += 1;
}

/// It did not start.
pub fn no_thread() {
    lock().active -= 1;
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
        self.active == 0 && self.waiting.values().all(|(_, seen)| *seen == self.signals)
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
    let mut end = End::after(time);
    register(false);
    let mut inner = lock();
    inner.numbers += 1;
    let number = inner.numbers;
    inner.active -= 1;
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
            End::Wall(_) => left.unwrap_or(LOOK).min(LOOK),
            End::Card(_, Virtual { time: Time::Paced(pace), .. }) => {
                left.map_or(LOOK, |left| pace.wall(left.as_nanos() as u64)).min(LOOK)
            }
            End::Card(deadline, Virtual { client, .. }) => {
                let left = left.unwrap_or(Duration::MAX);
                if (calm.0, calm.1) != (signals, left) {
                    calm = (signals, left, Instant::now());
                }
                let is_first = deadline.is_some() && inner.earliest() == *deadline;
                if is_first && (inner.is_quiet() || calm.2.elapsed() >= GRACE) && client.sleep(left).is_ok() {
                    // Others may have the same deadline.
                    BELL.notify_all();
                    continue;
                }
                GRACE
            }
        };
        inner = BELL.wait_timeout(inner, nap).unwrap_or_else(PoisonError::into_inner).0;
    };
    inner.waiting.remove(&number);
    inner.active += 1;
    inner.note_earliest();
    found
}

/// Time has passed in a call: threads whose deadline has come go on before its caller does.
pub fn time_passed() {
    let earliest = EARLIEST.load(Ordering::Relaxed);
    if earliest == u64::MAX {
        return;
    }
    let source = Source::current(false);
    let due = |inner: &Inner| inner.earliest().is_some_and(|first| first <= now(&source));
    let end = Instant::now() + GRACE;
    let mut inner = lock();
    while due(&inner) && Instant::now() < end {
        BELL.notify_all();
        inner = BELL.wait_timeout(inner, Duration::from_micros(200)).unwrap_or_else(PoisonError::into_inner).0;
    }
}
