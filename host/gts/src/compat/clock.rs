//! A program's clock: the controller's time while a card is open, else the wall clock's.
//!
//! Out: a time that never goes back, however cards are opened and closed. A virtual controller's
//! time is the program's, so that a program which measures its own waits sees what it waited for.
//! With a board, time is the wall clock's.

use crate::card::Time;
use crate::engine::any_card;
use crate::home::Homes;
use client::Client;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// An open virtual controller.
#[derive(Clone)]
pub struct Virtual {
    /// Its time.
    pub client: Arc<Client>,
    /// How that passes.
    pub time: Time,
    /// Its axes on their way home.
    pub homes: Arc<Homes>,
    /// It has been closed.
    pub closed: Arc<AtomicBool>,
    /// Its number among those opened.
    serial: u64,
}

impl Virtual {
    /// Whether it has been closed.
    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Relaxed)
    }
}

/// What the time is taken from.
pub enum Source {
    /// The wall clock.
    Wall,
    /// A virtual controller.
    Card(Virtual),
}

impl Source {
    /// The open virtual controller, if there is one. `flush` sends what its calls have queued.
    pub fn current(flush: bool) -> Source {
        let card = any_card().and_then(|slot| {
            let mut state = slot.lock();
            let card = state.card("").ok()?;
            if flush {
                // The data of a loop that ends with a wait is to be there.
                card.flush_later();
            }
            let (client, time) = card.client();
            Some(Virtual { client, time, homes: card.homes(), closed: card.closed(), serial: card.serial })
        });
        card.filter(|card| !matches!(card.time, Time::Own)).map_or(Source::Wall, Source::Card)
    }

    /// A number for each controller; the wall clock's is 0.
    fn identity(&self) -> u64 {
        match self {
            Source::Card(card) if !card.is_closed() => card.serial,
            _ => 0,
        }
    }

    /// Its own time.
    fn time(&self) -> Duration {
        static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
        match self {
            Source::Card(card) if !card.is_closed() => match &card.time {
                Time::Paced(pace) => Duration::from_nanos(pace.due(card.client.now().as_nanos() as u64)),
                _ => card.client.now(),
            },
            _ => START.elapsed(),
        }
    }
}

/// The last reading: the program's time, and which source had which time then.
static LAST: Mutex<(Duration, u64, Duration)> = Mutex::new((Duration::ZERO, 0, Duration::ZERO));

/// The program's time by this source. A change of the source takes no time.
pub fn now(source: &Source) -> Duration {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let (identity, time) = (source.identity(), source.time());
    let (before, by, at) = *last;
    let passed = if by == identity { time.saturating_sub(at) } else { Duration::ZERO };
    let now = before + passed;
    *last = (now, identity, time.max(if by == identity { at } else { Duration::ZERO }));
    now
}
