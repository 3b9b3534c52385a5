//! A timer that carries out rounds told ahead (docs/decisions/015-tiles.md): preloaded registers, and a ring that DMA brings to
//! them (RM0433 38.3.24, 38.4.19: DMA burst; 15.3: circular streams).
//!
//! In: rounds, as half-words of the timer's registers from `ARR` on. Out: nothing; whether the ring is read as it should be.
//! Owns the ring and the stream. Fails by standing still in the dark: every place of the ring that is not told is dark.
use core::cell::UnsafeCell;
use stm32_metapac::dma::vals::{Dir, Pl, Size};
use stm32_metapac::dma::{Dma, St};
use stm32_metapac::timer::TimAdv;
use stm32_metapac::timer::vals::Urs;
use stm32_metapac::{DMAMUX1, TIM1, TIM8};

/// TIM15: all of its registers that are used here are those of TIM1 (RM0433 41.5).
// SAFETY: its address.
pub const TIM15: TimAdv = unsafe { TimAdv::from_ptr(stm32_metapac::TIM15.as_ptr()) };

/// Length of the two dark rounds with which a timer starts.
const FIRST: u16 = 168;
/// Where the rounds of the ring begin.
pub const BEGIN: u64 = 2 * FIRST as u64;
/// ARR among the registers (RM0433 38.4.19): where the burst begins.
const BURST_BEGIN: u8 = 11;
/// Places that are made dark a tick before a start.
const AT_ONCE: usize = 64;

/// Rounds of `WORDS` half-words, read by DMA.
#[repr(C, align(4))]
pub struct Ring<const PLACES: usize, const WORDS: usize>(UnsafeCell<[[u16; WORDS]; PLACES]>);

// SAFETY: written by one [`Timer`] only, which the tick owns.
unsafe impl<const PLACES: usize, const WORDS: usize> Sync for Ring<PLACES, WORDS> {}

impl<const PLACES: usize, const WORDS: usize> Ring<PLACES, WORDS> {
    /// Of no rounds.
    pub const EMPTY: Self = Ring(UnsafeCell::new([[0; WORDS]; PLACES]));
}

impl<const PLACES: usize, const WORDS: usize> core::fmt::Debug for Ring<PLACES, WORDS> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Ring")
    }
}

/// What belongs to a timer.
#[derive(Clone, Copy)]
pub struct Wiring {
    /// The timer.
    pub timer: TimAdv,
    /// Its stream.
    pub dma: Dma,
    /// Number of the stream, 0 to 3.
    pub stream: usize,
    /// Channel of DMAMUX1.
    pub mux: usize,
    /// The timer's update request there (RM0433 table 121).
    pub request: u8,
    /// Priority of the stream.
    pub priority: Pl,
}

impl core::fmt::Debug for Wiring {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "DMAMUX1 channel {}", self.mux)
    }
}

/// Energy of laser 0.
pub const LASER_0: Wiring =
    Wiring { timer: TIM1, dma: stm32_metapac::DMA1, stream: 0, mux: 0, request: 15, priority: Pl::VERY_HIGH };
/// Energy of laser 1.
pub const LASER_1: Wiring =
    Wiring { timer: TIM15, dma: stm32_metapac::DMA2, stream: 0, mux: 8, request: 106, priority: Pl::VERY_HIGH };
/// Both switches.
pub const SWITCHES: Wiring =
    Wiring { timer: TIM8, dma: stm32_metapac::DMA1, stream: 1, mux: 1, request: 51, priority: Pl::HIGH };

/// A timer, its stream and its ring.
#[derive(Debug)]
pub struct Timer<const PLACES: usize, const WORDS: usize> {
    wiring: Wiring,
    ring: &'static Ring<PLACES, WORDS>,
    /// The half-words of a round; those behind `ARR` and `RCR` make it dark.
    dark: [u16; WORDS],
    /// The next place that is told.
    place: usize,
    /// The first one that is not dark again.
    lit: usize,
    /// The first place that the last tick told: what lies before it is over when the next one begins.
    told: usize,
    /// Lengths of the last two rounds: DMA reads a round when the second one before it begins, at the earliest.
    last: [u32; 2],
    /// No place was left for a round.
    is_full: bool,
}

impl<const PLACES: usize, const WORDS: usize> Timer<PLACES, WORDS> {
    /// Stands still.
    ///
    /// # Safety
    /// One a ring.
    pub const unsafe fn new(wiring: Wiring, ring: &'static Ring<PLACES, WORDS>, dark: [u16; WORDS]) -> Self {
        Timer { wiring, ring, dark, place: 0, lit: 0, told: 0, last: [0; 2], is_full: false }
    }

    fn stream(&self) -> St {
        self.wiring.dma.st(self.wiring.stream)
    }

    /// Writes a half-word of a place.
    #[inline(always)]
    fn write(&mut self, place: usize, word: usize, value: u16) {
        if place < PLACES && word < WORDS {
            // SAFETY: inside the ring, which this writes alone; DMA may read at any time, hence volatile.
            unsafe { self.ring.0.get().cast::<u16>().add(place * WORDS + word).write_volatile(value) };
        }
    }

    #[inline(always)]
    fn darken(&mut self, place: usize) {
        for word in 2..WORDS {
            let value = self.dark.get(word).copied().unwrap_or(0);
            self.write(place, word, value);
        }
    }

    #[inline(always)]
    fn behind(place: usize) -> usize {
        if place + 1 < PLACES { place + 1 } else { 0 }
    }

    /// One round more: its length in counts, and the half-words of its compare registers.
    #[inline(always)]
    pub fn put(&mut self, length: u32, compare: impl IntoIterator<Item = u32>) {
        let behind = Self::behind(self.place);
        if behind == self.lit {
            self.is_full = true;
            return;
        }
        self.write(self.place, 0, length.wrapping_sub(1) as u16);
        self.write(self.place, 1, 0);
        for (word, value) in (2..WORDS).zip(compare) {
            self.write(self.place, word, value as u16);
        }
        self.last = [self.last[1], length];
        self.place = behind;
    }

    /// How long before the end of what is told the next round is read at the earliest, in counts.
    #[inline(always)]
    pub fn ahead(&self) -> u32 {
        self.last[0].wrapping_add(self.last[1])
    }

    /// A tick begins while the timer runs: what is over is dark again. False if the ring is not read where it should be.
    #[inline]
    pub fn renew(&mut self) -> bool {
        let over = core::mem::replace(&mut self.told, self.place);
        while self.lit != over {
            self.darken(self.lit);
            self.lit = Self::behind(self.lit);
        }
        // Behind what was over at this tick, and not beyond what was told.
        let words = PLACES * WORDS;
        let read = words.wrapping_sub(self.stream().ndtr().read().ndt().into());
        let from = |place: usize| {
            let at = place.wrapping_sub(over * WORDS);
            if place < over * WORDS { at.wrapping_add(words) } else { at }
        };
        !self.is_full && from(read) <= from(self.place * WORDS)
    }

    /// While nothing runs: some more places dark; true once all are, and the stream stands.
    pub fn clear(&mut self) -> bool {
        for _ in 0..AT_ONCE {
            if self.lit < PLACES {
                // A length of nothing would stop the timer.
                self.write(self.lit, 0, FIRST - 1);
                self.darken(self.lit);
                self.lit += 1;
            }
        }
        self.lit == PLACES && !self.stream().cr().read().en()
    }

    /// Two dark rounds, then the ring from its first place on, once that is told and [`Timer::launch`]ed.
    pub fn arm(&mut self) {
        let Wiring { timer, dma, stream, mux, request, .. } = self.wiring;
        (self.place, self.lit, self.told, self.last) = (0, 0, 0, [FIRST.into(); 2]);
        // Nothing to clear between `lit` and `place`: all of it is dark.
        DMAMUX1.ccr(mux).write(|w| w.set_dmareq_id(request));
        dma.ifcr(stream / 4).write(|w| {
            w.set_tcif(stream % 4, true);
            w.set_htif(stream % 4, true);
            w.set_teif(stream % 4, true);
            w.set_dmeif(stream % 4, true);
            w.set_feif(stream % 4, true);
        });
        let st = self.stream();
        st.par().write_value(timer.dmar().as_ptr() as u32);
        st.m0ar().write_value(self.ring.0.get() as u32);
        st.ndtr().write(|w| w.set_ndt((PLACES * WORDS) as u16));
        st.fcr().write(|_| {});
        timer.cnt().write(|w| w.set_cnt(0));
        timer.psc().write_value(0);
        timer.rcr().write(|_| {});
        timer.arr().write(|w| w.set_arr(FIRST - 1));
        for channel in 0..4 {
            // CCR1 is the third half-word of a round.
            if let Some(&dark) = self.dark.get(2 + channel) {
                timer.ccr(channel).write(|w| w.set_ccr(dark));
            }
        }
        // In force now, and once more.
        timer.egr().write(|w| w.set_ug(true));
        timer.dcr().write(|w| {
            w.set_dba(BURST_BEGIN);
            w.set_dbl(WORDS as u8 - 1);
        });
        self.is_full = false;
    }

    /// Ready to start with the trigger. DMA reads the first half-word at once.
    pub fn launch(&mut self) {
        let Wiring { timer, priority, .. } = self.wiring;
        timer.dier().write(|w| w.set_ude(true));
        self.stream().cr().write(|w| {
            w.set_dir(Dir::MEMORY_TO_PERIPHERAL);
            w.set_minc(true);
            w.set_circ(true);
            w.set_psize(Size::BITS16);
            w.set_msize(Size::BITS16);
            w.set_pl(priority);
            w.set_en(true);
        });
    }

    /// No round more.
    pub fn stop(&mut self) {
        let timer = self.wiring.timer;
        timer.dier().write(|_| {});
        timer.cr1().write(|w| {
            w.set_arpe(true);
            w.set_urs(Urs::COUNTER_ONLY);
        });
        self.stream().cr().modify(|w| w.set_en(false));
        self.lit = 0;
    }
}
