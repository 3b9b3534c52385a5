//! What feeds the timers' DMA burst: PWM cycles queued ahead (docs/decisions/015-pwm-cycles.md).
//!
//! The registers of a timer are preloaded. A circular DMA stream reads a ring of cycle slots and
//! writes each one to the registers by a DMA burst (RM0433 38.3.24, 38.4.19; 15.3: circular
//! streams).
//!
//! In: cycles, as half-words of the timer's registers from `ARR` on. Out: whether DMA reads the
//! ring where it should. Owns the stream. Fails to dark outputs, as [`CycleRing`] does.
use core::sync::atomic::AtomicU16;
use servo::output::{CycleRing, RingSlots};
use stm32_metapac::dma::vals::{Dir, Pl, Size};
use stm32_metapac::dma::{Dma, St};
use stm32_metapac::timer::TimAdv;
use stm32_metapac::timer::vals::Urs;
use stm32_metapac::{DMAMUX1, TIM1, TIM8};

/// TIM15: all of its registers that are used here are those of TIM1 (RM0433 41.5).
// SAFETY: its address.
pub const TIM15: TimAdv = unsafe { TimAdv::from_ptr(stm32_metapac::TIM15.as_ptr()) };

/// Length of the two dark cycles with which a timer starts.
const FIRST_CYCLE_COUNTS: u16 = 168;
/// Instant at which the cycles of the ring begin, in counts.
pub const RING_BEGIN_COUNTS: u64 = 2 * FIRST_CYCLE_COUNTS as u64;
/// ARR among the registers (RM0433 38.4.19): where the burst begins.
const BURST_BEGIN: u8 = 11;

/// A ring in memory that DMA reads, all zero.
pub const fn empty_slots<const SLOTS: usize, const WORDS: usize>() -> RingSlots<SLOTS, WORDS> {
    [const { [const { AtomicU16::new(0) }; WORDS] }; SLOTS]
}

/// A timer with its stream and request.
#[derive(Clone, Copy)]
pub struct TimerDma {
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

impl core::fmt::Debug for TimerDma {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "DMAMUX1 channel {}", self.mux)
    }
}

/// Energy of laser 0.
pub const LASER_0: TimerDma =
    TimerDma { timer: TIM1, dma: stm32_metapac::DMA1, stream: 0, mux: 0, request: 15, priority: Pl::VERY_HIGH };
/// Energy of laser 1.
pub const LASER_1: TimerDma =
    TimerDma { timer: TIM15, dma: stm32_metapac::DMA2, stream: 0, mux: 8, request: 106, priority: Pl::VERY_HIGH };
/// Both switches.
pub const SWITCHES: TimerDma =
    TimerDma { timer: TIM8, dma: stm32_metapac::DMA1, stream: 1, mux: 1, request: 51, priority: Pl::HIGH };

/// A timer, its stream and its ring.
#[derive(Debug)]
pub struct Timer<const SLOTS: usize, const WORDS: usize> {
    timer_dma: TimerDma,
    slots: &'static RingSlots<SLOTS, WORDS>,
    /// Takes the cycles to come.
    pub ring: CycleRing<SLOTS, WORDS>,
}

impl<const SLOTS: usize, const WORDS: usize> Timer<SLOTS, WORDS> {
    /// A stopped timer. `dark` are the half-words of a dark cycle of no length.
    ///
    /// # Safety
    /// At most one for each ring and each stream.
    pub const unsafe fn new(timer_dma: TimerDma, slots: &'static RingSlots<SLOTS, WORDS>, dark: [u16; WORDS]) -> Self {
        Timer { timer_dma, slots, ring: CycleRing::new(slots, dark) }
    }

    fn stream(&self) -> St {
        self.timer_dma.dma.st(self.timer_dma.stream)
    }

    /// A tick begins while the timer runs. False if the ring is not read where it should be.
    #[inline]
    pub fn renew(&mut self) -> bool {
        let left: usize = self.stream().ndtr().read().ndt().into();
        self.ring.renew(CycleRing::<SLOTS, WORDS>::WORDS.wrapping_sub(left))
    }

    /// While nothing runs: makes some more slots dark. True once all are, and the stream has
    /// stopped.
    pub fn clear(&mut self) -> bool {
        self.ring.clear() && !self.stream().cr().read().en()
    }

    /// Prepares two dark cycles, and after them the ring from its first slot on; [`Timer::launch`]
    /// follows once the ring is filled.
    pub fn arm(&mut self) {
        let TimerDma { timer, dma, stream, mux, request, .. } = self.timer_dma;
        self.ring.begin(FIRST_CYCLE_COUNTS);
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
        st.m0ar().write_value(self.slots.as_ptr() as u32);
        st.ndtr().write(|w| w.set_ndt(CycleRing::<SLOTS, WORDS>::WORDS as u16));
        st.fcr().write(|_| {});
        timer.cnt().write(|w| w.set_cnt(0));
        timer.psc().write_value(0);
        timer.rcr().write(|_| {});
        timer.arr().write(|w| w.set_arr(FIRST_CYCLE_COUNTS - 1));
        for (channel, &dark) in self.ring.dark().iter().enumerate() {
            timer.ccr(channel).write(|w| w.set_ccr(dark));
        }
        // Loaded now, and in the preload registers for the second cycle.
        timer.egr().write(|w| w.set_ug(true));
        timer.dcr().write(|w| {
            w.set_dba(BURST_BEGIN);
            w.set_dbl(WORDS as u8 - 1);
        });
    }

    /// Enables the stream: the timer starts with the trigger. DMA reads the first half-word at
    /// once.
    pub fn launch(&mut self) {
        let TimerDma { timer, priority, .. } = self.timer_dma;
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

    /// Stops the stream: no more cycles.
    pub fn stop(&mut self) {
        let timer = self.timer_dma.timer;
        timer.dier().write(|_| {});
        timer.cr1().write(|w| {
            w.set_arpe(true);
            w.set_urs(Urs::COUNTER_ONLY);
        });
        self.stream().cr().modify(|w| w.set_en(false));
        self.ring.stop();
    }
}
