//! The delay line: a plan that waits for one tick, in few words, for a machine that carries plans
//! out a tick later.
//!
//! In: a [`LaserPlan`] a tick. Out: its actions, one tick later; voltages are not among them. Owns
//! the words. Fails: [`DelayLine::put`] returns false, where a plan has more trains than there is
//! room for.
//!
//! An action is a word. After it come the counts of its train that differ from those of the train
//! of its kind before it (of light, and of standby): within a tick few do.
use crate::laser::{Action, Count, LaserPlan, PLAN_ACTIONS, PulseRate, Train};
use crate::path::INSTANTS;
use core::sync::atomic::{AtomicU32, Ordering};

/// Words that hold any plan of the tick: all actions, and the trains. Those that begin the interval
/// are two; paths bring one at each of [`INSTANTS`] for each of two.
pub const WORDS: usize = PLAN_ACTIONS + 8 * (2 + 2 * INSTANTS as usize);

/// Bits of an action's word: its instant, its kind, a level or a cut, and whether counts follow.
const INSTANT_MASK: u32 = (1 << 20) - 1;
const KIND_SHIFT: u32 = 20;
const LEVEL_BIT: u32 = 1 << 22;
const PERIOD_BIT: u32 = 1 << 23;
const WIDTH_BIT: u32 = 1 << 24;

const SWITCH: u32 = 0;
const LIGHT: u32 = 1;
const CHANGE: u32 = 2;
const DARK: u32 = 3;

/// See the module text.
#[derive(Debug)]
pub struct DelayLine {
    words: &'static [AtomicU32],
    len: usize,
    lights: bool,
}

impl DelayLine {
    /// Nothing.
    pub const fn new(words: &'static [AtomicU32]) -> DelayLine {
        DelayLine { words, len: 0, lights: false }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        (self.len, self.lights) = (0, false);
    }

    /// Whether its plan makes any light or standby.
    pub fn makes_light(&self) -> bool {
        self.lights
    }

    /// Whether its plan has no action.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    fn add(&mut self, word: u32) -> bool {
        let Some(slot) = self.words.get(self.len) else { return false };
        slot.store(word, Ordering::Relaxed);
        self.len = self.len.wrapping_add(1);
        true
    }

    fn add_count(&mut self, count: &Count) -> bool {
        let Count { whole, part, of } = *count;
        let free = self.words.get(self.len..).unwrap_or_default();
        let Some(slots) = free.first_chunk::<4>() else { return false };
        for (slot, word) in slots.iter().zip([whole as u32, (whole >> 32) as u32, part, of]) {
            slot.store(word, Ordering::Relaxed);
        }
        self.len = self.len.wrapping_add(4);
        true
    }

    /// Holds a plan instead of the one before. False if it has no room: then it is empty.
    #[inline]
    pub fn put(&mut self, plan: &LaserPlan) -> bool {
        self.clear();
        if plan.actions().is_empty() {
            return true;
        }
        // Of light, of standby.
        let mut trains = [&Train::NONE; 2];
        for (at, action) in plan.actions() {
            let (word, train) = match action {
                Action::Switch(active) => {
                    self.lights |= *active;
                    (SWITCH << KIND_SHIFT | if *active { LEVEL_BIT } else { 0 }, None)
                }
                Action::Light(train) => (LIGHT << KIND_SHIFT, Some(train)),
                Action::Change(train) => (CHANGE << KIND_SHIFT, Some(train)),
                Action::Rate(rate) => {
                    if !self.add_rate(CHANGE << KIND_SHIFT | LEVEL_BIT | at & INSTANT_MASK, rate) {
                        self.clear();
                        return false;
                    }
                    continue;
                }
                Action::Dark { standby, cut } => (DARK << KIND_SHIFT | if *cut { LEVEL_BIT } else { 0 }, Some(standby)),
                Action::Volts(_) => continue,
            };
            if !self.add_action(word | at & INSTANT_MASK, train, &mut trains) {
                self.clear();
                return false;
            }
        }
        true
    }

    /// A word, and all of a rate.
    #[inline(never)]
    fn add_rate(&mut self, word: u32, rate: &PulseRate) -> bool {
        let PulseRate { period, width, scale, shift } = rate;
        self.lights |= !rate.is_pause();
        self.add(word) && self.add_count(period) && self.add_count(&Count { whole: *scale, part: *width, of: *shift })
    }

    /// A word, and the counts of its train that differ.
    fn add_action<'a>(&mut self, word: u32, train: Option<&'a Train>, trains: &mut [&'a Train; 2]) -> bool {
        let Some(train) = train else { return self.add(word) };
        self.lights |= !train.is_silent();
        let [light, standby] = trains;
        let before = if word >> KIND_SHIFT & 3 == DARK { standby } else { light };
        let (period, width) = (before.period != train.period, before.width != train.width);
        *before = train;
        self.add(word | if period { PERIOD_BIT } else { 0 } | if width { WIDTH_BIT } else { 0 })
            && (!period || self.add_count(&train.period))
            && (!width || self.add_count(&train.width))
    }

    /// The actions of the plan: ns from the interval's beginning, and what happens there.
    #[inline]
    pub fn actions(&self) -> impl Iterator<Item = (u32, Action)> {
        let words = self.words.get(..self.len).unwrap_or_default();
        Replay { words, next: 0, periods: [0; 2], widths: [0; 2] }
    }
}

struct Replay<'a> {
    words: &'a [AtomicU32],
    next: usize,
    /// Index of the counts of the last train of light and of standby; 0, where an action is, for
    /// none.
    periods: [usize; 2],
    widths: [usize; 2],
}

impl Replay<'_> {
    fn word(&self, at: usize) -> Option<u32> {
        self.words.get(at).map(|word| word.load(Ordering::Relaxed))
    }

    /// All of a rate.
    #[inline(never)]
    fn rate(&mut self) -> Action {
        let (period, other) = (self.skip(), self.skip());
        let Count { whole: scale, part: width, of: shift } = self.counts(other);
        Action::Rate(PulseRate { period: self.counts(period), width, scale, shift })
    }

    /// The index of the next counts.
    fn skip(&mut self) -> usize {
        let at = self.next;
        self.next = at.wrapping_add(4);
        at
    }

    fn counts(&self, at: usize) -> Count {
        match self.words.get(at..at.wrapping_add(4)) {
            Some([low, high, part, of]) if at != 0 => {
                let [low, high, part, of] = [low, high, part, of].map(|word| word.load(Ordering::Relaxed));
                Count { whole: (high as u64) << 32 | low as u64, part, of }
            }
            _ => Train::NONE.period,
        }
    }
}

impl Iterator for Replay<'_> {
    type Item = (u32, Action);

    fn next(&mut self) -> Option<(u32, Action)> {
        let word = self.word(self.next)?;
        self.next = self.next.wrapping_add(1);
        let (at, kind, flag) = (word & INSTANT_MASK, word >> KIND_SHIFT & 3, word & LEVEL_BIT != 0);
        if kind == SWITCH {
            return Some((at, Action::Switch(flag)));
        }
        if kind == CHANGE && flag {
            return Some((at, self.rate()));
        }
        let (mut period, mut width) = (0, 0);
        if word & PERIOD_BIT != 0 {
            period = self.skip();
        }
        if word & WIDTH_BIT != 0 {
            width = self.skip();
        }
        let ([of_light, of_standby], [by_light, by_standby]) = (&mut self.periods, &mut self.widths);
        let (periods, widths) = if kind == DARK { (of_standby, by_standby) } else { (of_light, by_light) };
        (*periods, *widths) = (if period == 0 { *periods } else { period }, if width == 0 { *widths } else { width });
        let (period, width) = (*periods, *widths);
        let train = Train { period: self.counts(period), width: self.counts(width) };
        let action = match kind {
            LIGHT => Action::Light(train),
            CHANGE => Action::Change(train),
            _ => Action::Dark { standby: train, cut: flag },
        };
        Some((at, action))
    }
}
