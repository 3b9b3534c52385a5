//! The ring through which PWM cycles go to a timer: half-words in the order of its registers, read
//! by DMA in turn.
//!
//! In: PWM cycles, ticks, how far DMA has read. Out: half-words; whether DMA is where it should be.
//! Owns the order of the slots. Fails: [`CycleRing::renew`] returns false. Every slot that is not
//! queued holds a dark cycle of no length, which stops the timer for good (RM0433 38.3.1). So DMA
//! that reads too early, or after the last tick, makes no light. Slots that are over become dark in
//! the next tick.
use core::sync::atomic::{AtomicU16, Ordering};

/// Slots that are made dark at once before a start.
const DARK_AT_ONCE_SLOTS: usize = 64;

/// A slot: length − 1, repetitions − 1, and compare registers.
type Slot<const WORDS: usize> = [AtomicU16; WORDS];

/// The half-words.
pub type RingSlots<const SLOTS: usize, const WORDS: usize> = [Slot<WORDS>; SLOTS];

/// See the module text.
#[derive(Debug)]
pub struct CycleRing<const SLOTS: usize, const WORDS: usize> {
    slots: &'static RingSlots<SLOTS, WORDS>,
    /// A dark cycle of no length.
    dark: [u16; WORDS],
    /// Slots that are queued next, up to their end.
    free: &'static [Slot<WORDS>],
    end: usize,
    /// The first slot that is not dark again.
    lit: usize,
    /// The first slot that this tick queues: the slots before it are over when the next one begins.
    queued: usize,
    /// The durations of the last two slots: DMA reads one when the second one before it begins, at
    /// the earliest.
    last: [u32; 2],
    /// No slot was left for a cycle.
    is_full: bool,
}

impl<const SLOTS: usize, const WORDS: usize> CycleRing<SLOTS, WORDS> {
    /// Half-words of the ring.
    pub const WORDS: usize = SLOTS * WORDS;

    /// Nothing is dark yet.
    pub const fn new(slots: &'static RingSlots<SLOTS, WORDS>, dark: [u16; WORDS]) -> Self {
        CycleRing { slots, dark, free: &[], end: 0, lit: 0, queued: 0, last: [0; 2], is_full: false }
    }

    #[inline(always)]
    fn darken(slot: &Slot<WORDS>, dark: [u16; WORDS]) {
        for (word, dark) in slot.iter().zip(dark) {
            word.store(dark, Ordering::Relaxed);
        }
    }

    /// Before a start: makes some more slots dark; true once all are.
    pub fn clear(&mut self) -> bool {
        let end = self.lit.wrapping_add(DARK_AT_ONCE_SLOTS).min(SLOTS);
        let slots = self.slots.get(self.lit..end).unwrap_or_default();
        slots.iter().for_each(|slot| Self::darken(slot, self.dark));
        self.lit = end;
        end == SLOTS
    }

    /// A start, with two dark cycles of a length of `first` before the queue.
    pub fn begin(&mut self, first: u16) {
        (self.lit, self.queued, self.last, self.is_full) = (0, 0, [first.into(); 2], false);
        (self.free, self.end) = (&[], 0);
    }

    /// The stream has stopped: no slot is made dark any more.
    pub fn stop(&mut self) {
        self.lit = 0;
    }

    /// Half-words of the compare registers of a dark cycle.
    pub fn dark(&self) -> &[u16] {
        self.dark.get(2..).unwrap_or_default()
    }

    /// More slots that may be queued, up to the ring's end or to a lit slot. One stays free: a full
    /// ring would look like an empty one.
    #[cold]
    fn open(&mut self) {
        let slot = self.slot();
        self.end = match self.lit.checked_sub(1) {
            None => SLOTS.wrapping_sub(1),
            Some(last) if slot < self.lit => last,
            Some(_) => SLOTS,
        };
        self.free = self.slots.get(slot..self.end).unwrap_or_default();
    }

    /// The next slot of the queue.
    #[inline(always)]
    pub(crate) fn slot(&self) -> usize {
        let slot = self.end.wrapping_sub(self.free.len());
        if slot < SLOTS { slot } else { 0 }
    }

    /// Queues some equal cycles: their length in counts, their number, and the half-words of their
    /// compare registers.
    #[inline(always)]
    pub fn put(&mut self, length: u32, times: u32, compare: impl IntoIterator<Item = u32>) {
        if self.free.is_empty() {
            self.open();
        }
        let Some((slot, free)) = self.free.split_first() else {
            self.is_full = true;
            return;
        };
        self.free = free;
        Self::write(slot, length, times, compare);
        self.last = [self.last[1], length.wrapping_mul(times)];
    }

    /// Queues three cycles of these lengths, with the half-words of their compare registers. False,
    /// and queues none, if there are no three slots in a row.
    #[inline(always)]
    pub fn put_three<const N: usize>(&mut self, lengths: [u32; 3], compare: impl Fn(u32) -> [u32; N]) -> bool {
        let Some((slots, free)) = self.free.split_first_chunk::<3>() else { return false };
        for (slot, length) in slots.iter().zip(lengths) {
            Self::write(slot, length, 1, compare(length));
        }
        let [_, last @ ..] = lengths;
        (self.free, self.last) = (free, last);
        true
    }

    #[inline(always)]
    fn write(slot: &Slot<WORDS>, length: u32, times: u32, compare: impl IntoIterator<Item = u32>) {
        let [to_length, to_times, to @ ..] = slot.as_slice() else { return };
        to_length.store(length.wrapping_sub(1) as u16, Ordering::Relaxed);
        to_times.store(times.wrapping_sub(1) as u16, Ordering::Relaxed);
        for (to, value) in to.iter().zip(compare) {
            to.store(value as u16, Ordering::Relaxed);
        }
    }

    /// How long before the end of the queue the next cycle is read at the earliest, in counts.
    #[inline(always)]
    pub fn ahead(&self) -> u32 {
        self.last[0].wrapping_add(self.last[1])
    }

    /// A tick begins while the timer runs; DMA has read this many half-words of this turn. Slots
    /// that are over become dark again. False if DMA is not where it should be, between what was
    /// over then and the end of the queue, or if a cycle had no slot.
    #[inline(never)]
    pub fn renew(&mut self, read: usize) -> bool {
        let over = self.queued;
        // Both are below the number of slots.
        while let Some(slot) = self.slots.get(self.lit).filter(|_| self.lit != over) {
            Self::darken(slot, self.dark);
            let next = self.lit.wrapping_add(1);
            self.lit = if next < SLOTS { next } else { 0 };
        }
        self.queued = self.slot();
        let begin = over.wrapping_mul(WORDS);
        let from = |at: usize| if at < begin { at.wrapping_add(Self::WORDS) } else { at }.wrapping_sub(begin);
        !self.is_full && from(read) <= from(self.queued.wrapping_mul(WORDS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static SLOTS: RingSlots<8, 3> = [const { [const { AtomicU16::new(7) }; 3] }; 8];

    /// A slot that DMA reads without its being queued, in this tick or the one before, stops its
    /// timer in the dark.
    #[test]
    fn what_is_not_reported_has_no_length_and_no_light() {
        let mut ring = CycleRing::new(&SLOTS, [0, 0, 0]);
        while !ring.clear() {}
        ring.begin(168);
        let mut queued = 0usize;
        let mut read = 0usize;
        for tick in 0..100usize {
            assert!(ring.renew(read), "tick {tick}");
            let over = queued;
            for _ in 0..tick % 4 {
                ring.put(100, tick as u32 % 5 + 1, [40]);
                queued += 1;
            }
            read = queued * 3 % (8 * 3);
            let words = |slot: usize| SLOTS[slot % 8].each_ref().map(|word| word.load(Ordering::Relaxed));
            for slot in over..queued {
                assert_eq!(words(slot), [99, tick as u16 % 5, 40], "tick {tick}");
            }
            let before = over.saturating_sub((tick + 3) % 4);
            for slot in queued..before + 8 {
                assert_eq!(words(slot), [0; 3], "tick {tick}, {} slots after it", slot - queued);
            }
        }
        // DMA beyond the queue.
        assert!(!ring.renew((queued + 1) * 3 % (8 * 3)));
    }

    static FULL: RingSlots<8, 3> = [const { [const { AtomicU16::new(7) }; 3] }; 8];

    /// Wherever the ring is: no slot of this tick or the one before is overwritten, and the next
    /// tick says so.
    #[test]
    fn a_cycle_without_a_slot_is_not_reported() {
        for before in 0..24usize {
            let mut ring = CycleRing::new(&FULL, [0, 0, 0]);
            while !ring.clear() {}
            ring.begin(168);
            let mut queued = 0;
            for _ in 0..before {
                assert!(ring.renew(queued * 3 % (8 * 3)));
                ring.put(100, 1, [40]);
                queued += 1;
            }
            assert!(ring.renew(queued * 3 % (8 * 3)));
            let kept = before.min(1);
            for more in 0..7 - kept {
                ring.put(200 + more as u32, 1, [80]);
            }
            let words = || FULL.each_ref().map(|slot| slot.each_ref().map(|word| word.load(Ordering::Relaxed)));
            let full = words();
            assert_eq!(full.iter().filter(|slot| slot[0] >= 199).count(), 7 - kept, "after {before}: {full:?}");
            assert_eq!(
                full[queued.wrapping_sub(1) % 8][0],
                if before > 0 { 99 } else { 0 },
                "after {before}: {full:?}"
            );
            ring.put(300, 1, [80]);
            assert_eq!(words(), full, "after {before}");
            assert!(!ring.renew(queued * 3 % (8 * 3)), "after {before}");
        }
    }
}
