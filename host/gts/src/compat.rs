//! Functions for the headers of `compat/` on Linux, in the controller's time: `Sleep`, clocks,
//! `kbhit` and `getch` here, a program's clock in `clock`, threads and what they wait for in
//! `objects` and `waits`.
//!
//! A sleep lasts for so many milliseconds of controller time, so that a program does the same at
//! any speed of the virtual controller. Keys: the header itself reads those of a terminal. Without
//! a terminal they are pressed at the controller times (ms from Open) that `BEAMTICK_KEYS` lists
//! (`1500,4000A`: a letter, or else a line end). After the last of them, or without the variable, a
//! key is down once motion was started and nothing moves any more.

mod clock;
mod objects;
pub mod waits;

use crate::card::Card;
use crate::engine::any_card;
use std::collections::VecDeque;
use std::ffi::{c_int, c_ulong};
use std::time::Duration;

/// Times at which keys are pressed.
#[derive(Debug, Clone, Default)]
pub struct Keys {
    times: VecDeque<(Duration, u8)>,
}

impl Keys {
    /// From the environment; `now` is the controller's time at Open.
    pub fn read(now: Duration) -> Keys {
        let text = std::env::var("BEAMTICK_KEYS").unwrap_or_default();
        let key = |word: &str| {
            let digits = word.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
            let letter = word.as_bytes().get(digits.len()).copied().unwrap_or(b'\n');
            Some((now + Duration::from_millis(digits.parse().ok()?), letter))
        };
        Keys { times: text.split(',').filter_map(|word| key(word.trim())).collect() }
    }
}

/// Waits for so many milliseconds of the open controller's time; of the wall clock's, if none is
/// open.
///
/// With `virtual:max` time passes here and in calls only, exactly as long as asked; sleeps of
/// several threads overlap (`waits`). When another thread closes the controller meanwhile, the
/// remainder lasts as long on the wall clock as it would have with the controller.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_sleep(milliseconds: c_ulong) {
    #[allow(clippy::useless_conversion)] // It has 32 bits on Windows.
    let time = Duration::from_millis(milliseconds.into());
    waits::wait(Some(time), |_| None::<()>);
}

/// The program's time in ns: the virtual controller's while one is open, else the wall clock's.
/// With `virtual:max` a reading lasts for a servo tick, so that a loop which waits for a time
/// reaches it.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_now() -> u64 {
    if let Some(slot) = any_card()
        && let Ok(card) = slot.lock().card("")
    {
        let _ = card.passed(true);
    }
    waits::time_passed();
    u64::try_from(clock::now(&clock::Source::current(false)).as_nanos()).unwrap_or(u64::MAX)
}

/// Whether a key is down; see the module text.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_kbhit() -> c_int {
    let Some(slot) = any_card() else { return 1 };
    let mut state = slot.lock();
    let Ok(card) = state.card("kbhit") else { return 1 };
    // A loop that only asks for keys must end too.
    if card.passed(true).is_err() {
        return 1;
    }
    c_int::from(is_pressed(card))
}

fn is_pressed(card: &mut Card) -> bool {
    match card.keys.times.front() {
        Some((time, _)) => card.client().0.now() >= *time,
        None => card.started && !card.is_moving().unwrap_or(false),
    }
}

/// Takes the key that is down, or waits for the next one that `BEAMTICK_KEYS` lists.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_getch() -> c_int {
    let Some(slot) = any_card() else { return c_int::from(b'\n') };
    let next = {
        let mut state = slot.lock();
        let Ok(card) = state.card("getch") else { return c_int::from(b'\n') };
        let now = card.client().0.now();
        card.keys.times.pop_front().map(|(time, key)| (time.saturating_sub(now), key))
    };
    let Some((wait, key)) = next else { return c_int::from(b'\n') };
    if !wait.is_zero() {
        beamtick_sleep(wait.as_millis() as c_ulong);
    }
    c_int::from(key)
}
