//! The ring through which rounds go to a timer: half-words in the order of its registers, read by DMA again and again.
//!
//! In: rounds, ticks, how far DMA has read. Out: half-words; whether they are read where they should be. Owns the order of the places.
//! Fails by [`RoundRing::renew`] being false. Every place that is not told is a dark round of no length, which stops the timer for
//! good (RM0433 38.3.1): what is read too early, or when no tick comes any more, is no light. What is over becomes so in the next tick.
use core::sync::atomic::{AtomicU16, Ordering};

/// Places that are made dark at once before a start.
const AT_ONCE: usize = 64;

/// A place: length − 1, how often − 1, and compare registers.
type Place<const WORDS: usize> = [AtomicU16; WORDS];

/// The half-words.
pub type Places<const PLACES: usize, const WORDS: usize> = [Place<WORDS>; PLACES];

/// See the module text.
#[derive(Debug)]
pub struct RoundRing<const PLACES: usize, const WORDS: usize> {
    places: &'static Places<PLACES, WORDS>,
    /// A dark round of no length.
    dark: [u16; WORDS],
    /// Places that are told next, and where they end.
    free: &'static [Place<WORDS>],
    end: usize,
    /// The first place that is not dark again.
    lit: usize,
    /// The first place that this tick tells: what lies before it is over when the next one begins.
    told: usize,
    /// What the last two places last: DMA reads one when the second one before it begins, at the earliest.
    last: [u32; 2],
    /// No place was left for a round.
    is_full: bool,
}

impl<const PLACES: usize, const WORDS: usize> RoundRing<PLACES, WORDS> {
    /// Half-words of the ring.
    pub const WORDS: usize = PLACES * WORDS;

    /// Nothing is dark yet.
    pub const fn new(places: &'static Places<PLACES, WORDS>, dark: [u16; WORDS]) -> Self {
        RoundRing { places, dark, free: &[], end: 0, lit: 0, told: 0, last: [0; 2], is_full: false }
    }

    #[inline(always)]
    fn darken(places: Option<&[Place<WORDS>]>, dark: [u16; WORDS]) {
        for place in places.unwrap_or_default() {
            for (word, dark) in place.iter().zip(dark) {
                word.store(dark, Ordering::Relaxed);
            }
        }
    }

    /// Before a start: some more places dark; true once all are.
    pub fn clear(&mut self) -> bool {
        let behind = self.lit.wrapping_add(AT_ONCE).min(PLACES);
        Self::darken(self.places.get(self.lit..behind), self.dark);
        self.lit = behind;
        behind == PLACES
    }

    /// A start, with two dark rounds of a length of `first` before what is told.
    pub fn begin(&mut self, first: u16) {
        (self.lit, self.told, self.last, self.is_full) = (0, 0, [first.into(); 2], false);
        (self.free, self.end) = (&[], 0);
    }

    /// The stream stands: nothing is taken for dark any more.
    pub fn stop(&mut self) {
        self.lit = 0;
    }

    /// Half-words of the compare registers of a dark round.
    pub fn dark(&self) -> &[u16] {
        self.dark.get(2..).unwrap_or_default()
    }

    /// More places that may be told, up to the ring's end or to what is lit; one is not: a ring that is told as a whole looks like one of
    /// which nothing is.
    #[cold]
    fn open(&mut self) {
        let place = self.place();
        self.end = match self.lit.checked_sub(1) {
            None => PLACES.wrapping_sub(1),
            Some(last) if place < self.lit => last,
            Some(_) => PLACES,
        };
        self.free = self.places.get(place..self.end).unwrap_or_default();
    }

    /// The next place that is told.
    #[inline(always)]
    fn place(&self) -> usize {
        let place = self.end.wrapping_sub(self.free.len());
        if place < PLACES { place } else { 0 }
    }

    /// Some equal rounds more: their length in counts, how many they are, and the half-words of their compare registers.
    #[inline(always)]
    pub fn put(&mut self, length: u32, times: u32, compare: impl IntoIterator<Item = u32>) {
        if self.free.is_empty() {
            self.open();
        }
        let Some((place, free)) = self.free.split_first() else {
            self.is_full = true;
            return;
        };
        self.free = free;
        let [to_length, to_times, to @ ..] = place.as_slice() else { return };
        to_length.store(length.wrapping_sub(1) as u16, Ordering::Relaxed);
        to_times.store(times.wrapping_sub(1) as u16, Ordering::Relaxed);
        for (to, value) in to.iter().zip(compare) {
            to.store(value as u16, Ordering::Relaxed);
        }
        self.last = [self.last[1], length.wrapping_mul(times)];
    }

    /// The half-word that is told next.
    pub fn next_word(&self) -> usize {
        self.place().wrapping_mul(WORDS)
    }

    /// How long before the end of what is told the next round is read at the earliest, in counts.
    #[inline(always)]
    pub fn ahead(&self) -> u32 {
        self.last[0].wrapping_add(self.last[1])
    }

    /// A tick begins while the timer runs; DMA has read so many half-words of this turn. What is over is dark again. False if
    /// DMA is not where it should be, between what was over then and what was told, or a round had no place.
    #[inline(never)]
    pub fn renew(&mut self, read: usize) -> bool {
        let over = self.told;
        let turns_over = over < self.lit;
        let mut places = self.places.get(self.lit..if turns_over { PLACES } else { over });
        let mut first = turns_over.then_some(over);
        // A loop of two turns at most, so that what makes places dark is there once: it runs from memory that is scarce.
        loop {
            Self::darken(places, self.dark);
            let Some(behind) = first.take() else { break };
            places = self.places.get(..behind);
        }
        (self.lit, self.told) = (over, self.place());
        let begin = over.wrapping_mul(WORDS);
        let from = |at: usize| if at < begin { at.wrapping_add(Self::WORDS) } else { at }.wrapping_sub(begin);
        !self.is_full && from(read) <= from(self.told.wrapping_mul(WORDS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static PLACES: Places<8, 3> = [const { [const { AtomicU16::new(7) }; 3] }; 8];

    /// Whatever DMA reads that is not told, of this tick or the one before, stops its timer in the dark.
    #[test]
    fn what_is_not_told_has_no_length_and_no_light() {
        let mut ring = RoundRing::new(&PLACES, [0, 0, 0]);
        while !ring.clear() {}
        ring.begin(168);
        let mut told = 0usize;
        let mut read = 0usize;
        for tick in 0..100usize {
            assert!(ring.renew(read), "tick {tick}");
            let over = told;
            for _ in 0..tick % 4 {
                ring.put(100, tick as u32 % 5 + 1, [40]);
                told += 1;
            }
            read = told * 3 % (8 * 3);
            let words = |place: usize| PLACES[place % 8].each_ref().map(|word| word.load(Ordering::Relaxed));
            for place in over..told {
                assert_eq!(words(place), [99, tick as u16 % 5, 40], "tick {tick}");
            }
            let before = over.saturating_sub((tick + 3) % 4);
            for place in told..before + 8 {
                assert_eq!(words(place), [0; 3], "tick {tick}, {} places behind", place - told);
            }
        }
        // DMA beyond what is told.
        assert!(!ring.renew((told + 1) * 3 % (8 * 3)));
    }

    static FULL: Places<8, 3> = [const { [const { AtomicU16::new(7) }; 3] }; 8];

    /// Wherever the ring stands: no place of this tick or the one before is told anew, and the tick behind says so.
    #[test]
    fn a_round_without_a_place_is_not_told() {
        for before in 0..24usize {
            let mut ring = RoundRing::new(&FULL, [0, 0, 0]);
            while !ring.clear() {}
            ring.begin(168);
            let mut told = 0;
            for _ in 0..before {
                assert!(ring.renew(told * 3 % (8 * 3)));
                ring.put(100, 1, [40]);
                told += 1;
            }
            assert!(ring.renew(told * 3 % (8 * 3)));
            let kept = before.min(1);
            for more in 0..7 - kept {
                ring.put(200 + more as u32, 1, [80]);
            }
            let words = || FULL.each_ref().map(|place| place.each_ref().map(|word| word.load(Ordering::Relaxed)));
            let full = words();
            assert_eq!(full.iter().filter(|place| place[0] >= 199).count(), 7 - kept, "after {before}: {full:?}");
            assert_eq!(full[told.wrapping_sub(1) % 8][0], if before > 0 { 99 } else { 0 }, "after {before}: {full:?}");
            ring.put(300, 1, [80]);
            assert_eq!(words(), full, "after {before}");
            assert!(!ring.renew(told * 3 % (8 * 3)), "after {before}");
        }
    }
}
