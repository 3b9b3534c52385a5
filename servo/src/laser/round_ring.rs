//! The ring through which rounds go to a timer: half-words in the order of its registers, read by DMA again and again.
//!
//! In: rounds, ticks, how far DMA has read. Out: half-words; whether they are read where they should be. Owns the order of the places.
//! Fails by [`RoundRing::renew`] being false. Every place that is not told is a dark round of no length, which stops the timer for
//! good (RM0433 38.3.1): what is read too early, or when no tick comes any more, is no light. What is over becomes so in the next tick.
use core::sync::atomic::{AtomicU16, Ordering};

/// Places that are made dark at once before a start.
const AT_ONCE: usize = 64;

/// The half-words: length − 1, how often − 1, and compare registers.
pub type Places<const PLACES: usize, const WORDS: usize> = [[AtomicU16; WORDS]; PLACES];

/// See the module text.
#[derive(Debug)]
pub struct RoundRing<const PLACES: usize, const WORDS: usize> {
    places: &'static Places<PLACES, WORDS>,
    /// A dark round of no length.
    dark: [u16; WORDS],
    /// The next place that is told.
    place: usize,
    /// The first one that is not dark again.
    lit: usize,
    /// The first place that the last tick told: what lies before it is over when the next one begins.
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
        RoundRing { places, dark, place: 0, lit: 0, told: 0, last: [0; 2], is_full: false }
    }

    #[inline(always)]
    fn behind(place: usize) -> usize {
        if place.wrapping_add(1) < PLACES { place.wrapping_add(1) } else { 0 }
    }

    #[inline(always)]
    fn darken(&self, place: &[AtomicU16; WORDS]) {
        for (word, dark) in place.iter().zip(self.dark) {
            word.store(dark, Ordering::Relaxed);
        }
    }

    /// Before a start: some more places dark; true once all are.
    pub fn clear(&mut self) -> bool {
        for _ in 0..AT_ONCE {
            if let Some(place) = self.places.get(self.lit) {
                self.darken(place);
                self.lit = self.lit.wrapping_add(1);
            }
        }
        self.lit >= PLACES
    }

    /// A start, with two dark rounds of a length of `first` before what is told.
    pub fn begin(&mut self, first: u16) {
        (self.place, self.lit, self.told, self.last, self.is_full) = (0, 0, 0, [first.into(); 2], false);
    }

    /// The stream stands: nothing is taken for dark any more.
    pub fn stop(&mut self) {
        self.lit = 0;
    }

    /// Half-words of the compare registers of a dark round.
    pub fn dark(&self) -> &[u16] {
        self.dark.get(2..).unwrap_or_default()
    }

    /// Some equal rounds more: their length in counts, how many they are, and the half-words of their compare registers.
    #[inline(always)]
    pub fn put(&mut self, length: u32, times: u32, compare: impl IntoIterator<Item = u32>) {
        let behind = Self::behind(self.place);
        let Some([to_length, to_times, to @ ..]) = self.places.get(self.place).map(|place| place.as_slice()) else {
            return;
        };
        if behind == self.lit {
            self.is_full = true;
            return;
        }
        to_length.store(length.wrapping_sub(1) as u16, Ordering::Relaxed);
        to_times.store(times.wrapping_sub(1) as u16, Ordering::Relaxed);
        for (to, value) in to.iter().zip(compare) {
            to.store(value as u16, Ordering::Relaxed);
        }
        self.last = [self.last[1], length.wrapping_mul(times)];
        self.place = behind;
    }

    /// The half-word that is told next.
    pub fn next_word(&self) -> usize {
        self.place.wrapping_mul(WORDS)
    }

    /// How long before the end of what is told the next round is read at the earliest, in counts.
    #[inline(always)]
    pub fn ahead(&self) -> u32 {
        self.last[0].wrapping_add(self.last[1])
    }

    /// A tick begins while the timer runs; DMA has read so many half-words of this turn. What is over is dark again. False if
    /// DMA is not where it should be, between what was over then and what was told, or a round had no place.
    #[inline]
    pub fn renew(&mut self, read: usize) -> bool {
        let over = core::mem::replace(&mut self.told, self.place);
        let (first, second) = if self.lit <= over { (self.lit..over, 0..0) } else { (self.lit..PLACES, 0..over) };
        for places in [first, second] {
            for place in self.places.get(places).unwrap_or_default() {
                self.darken(place);
            }
        }
        self.lit = over;
        let begin = over.wrapping_mul(WORDS);
        let from = |at: usize| if at < begin { at.wrapping_add(Self::WORDS) } else { at }.wrapping_sub(begin);
        !self.is_full && from(read) <= from(self.place.wrapping_mul(WORDS))
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
}
