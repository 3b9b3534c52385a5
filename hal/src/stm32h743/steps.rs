//! Steps and directions of all axes: TIM17 requests a word from DMA every slot, and DMA writes it
//! to the set/reset register of the steps' port (RM0433 11.4.7, 15, 17, 41).
//!
//! In: the target pulses of the axes. Out: edges, one tick after the plan: what lies between two
//! set-points is known when the second one is. Owns TIM17, DMA2 streams 1 and 2, and the ring.
//!
//! Fails without losing a step: a tick whose words would come too late for DMA stays empty, and its
//! steps come in the next one. DMA itself clears a slot after it was played, so that missing ticks
//! repeat nothing.
use super::boards::BOARD;
use super::clocks::TIMER_MHZ;
use super::settings::{DIRECTION_SET_UP_NS, STEP_WIDTH_NS};
use core::sync::atomic::{AtomicU32, Ordering};
use servo::output::step_generator::{AXES, RING_SLOTS, StepOutput};
use stm32_metapac::dma::vals::{Dir, Pl, Size};
use stm32_metapac::{DMA2, DMAMUX1, RCC, TIM2, TIM17};

/// A slot: the grid of all edges.
pub const SLOT_NS: u32 = 500;

const SLOT_COUNTS: u32 = SLOT_NS * TIMER_MHZ as u32 / 1000;
const WIDTH_SLOTS: usize = STEP_WIDTH_NS.div_ceil(SLOT_NS) as usize;
const SET_UP_SLOTS: u32 = DIRECTION_SET_UP_NS.div_ceil(SLOT_NS);

/// Least number of slots before a tick begins in which it is still filled: the time to write its
/// first word.
const MARGIN_SLOTS: usize = 4;

/// The stream that plays the ring, the one that clears played slots, and their requests (RM0433
/// 17.3.2).
const PLAY: usize = 1;
const CLEAR: usize = 2;
const TIM17_UP: u8 = 112;
const TIM17_CH1: u8 = 111;
/// First channel of DMAMUX1 for DMA2's streams.
const DMA2_CHANNELS: usize = 8;

#[unsafe(link_section = ".dma.steps")]
static WORDS: [AtomicU32; RING_SLOTS] = [const { AtomicU32::new(0) }; RING_SLOTS];

/// The step outputs.
#[derive(Debug)]
pub struct Steps {
    output: StepOutput<WIDTH_SLOTS>,
    runs: bool,
    /// Slots of a tick.
    slots: usize,
    /// First slot in the ring of the tick in force, and of the tick that is filled next.
    begin: usize,
    next: usize,
    /// Something was written for the tick in force.
    is_filled: bool,
}

/// Steps that an axis makes in a ms, in the tick period with the fewest. A tick has whole steps, so
/// with wide pulses some slots at its end stay empty.
pub const fn most_a_ms(periods_us: core::ops::RangeInclusive<u32>) -> u64 {
    let (mut us, mut most) = (*periods_us.start(), u64::MAX);
    while us <= *periods_us.end() {
        let steps = us * 1000 / SLOT_NS / (2 * WIDTH_SLOTS as u32);
        let a_ms = steps as u64 * 1000 / us as u64;
        if a_ms < most {
            most = a_ms;
        }
        us += 1;
    }
    most
}

/// Slots from `from` to `to` in the ring; negative if `to` lies before `from`.
const fn distance(from: usize, to: usize) -> isize {
    let forward = to.wrapping_sub(from) & (RING_SLOTS - 1);
    if forward < RING_SLOTS / 2 { forward as isize } else { forward as isize - RING_SLOTS as isize }
}

impl Steps {
    /// At standstill at zero; nothing runs.
    pub const AT_REST: Steps =
        Steps { output: StepOutput::new(SET_UP_SLOTS), runs: false, slots: 0, begin: 0, next: 0, is_filled: false };

    /// The pulse that an axis has reached at the end of the tick in force.
    pub fn reached(&self, axis: usize) -> i64 {
        self.output.stands(axis)
    }

    /// A tick of so many ns has just begun.
    pub fn begin(&mut self, period_ns: u32) {
        let before = core::mem::replace(&mut self.slots, (period_ns / SLOT_NS) as usize);
        if self.runs {
            self.begin = self.begin.wrapping_add(before) & (RING_SLOTS - 1);
            let begin = found();
            // Else ticks were lost, or this one is not at its time.
            self.locate(begin, (-2..=2).contains(&distance(self.begin, begin)));
        }
    }

    /// Sets where the tick in force and the next one begin: by counting, if that is right, else by
    /// the slot that was found.
    fn locate(&mut self, found: usize, is_right: bool) {
        if !is_right {
            self.begin = found;
        }
        let next = self.begin.wrapping_add(self.slots) & (RING_SLOTS - 1);
        // Backwards only where nothing in between was filled: a tick may have become shorter.
        if !is_right || !self.is_filled || distance(self.next, next) > 0 {
            self.next = next;
        }
    }

    /// Writes the steps with which the axes reach `targets` at the end of the next tick. False if
    /// that is too late: the tick after it makes up for them. The stream starts with the first
    /// step.
    pub fn fill(&mut self, targets: &[i64; AXES]) -> bool {
        if !self.runs {
            if (0..AXES).zip(targets).all(|(axis, target)| self.output.stands(axis) == *target) {
                return true;
            }
            self.start();
            self.locate(found(), false);
        }
        let in_time = distance(played(), self.next) >= MARGIN_SLOTS as isize;
        self.is_filled = in_time && self.output.fill(targets, self.slots as u32, &WORDS, self.next);
        if in_time {
            self.next = self.next.wrapping_add(self.slots) & (RING_SLOTS - 1);
        }
        in_time
    }

    /// Starts the streams. The first slot comes within the next [`SLOT_NS`].
    #[cold]
    #[inline(never)]
    fn start(&mut self) {
        RCC.ahb1enr().modify(|w| w.set_dma2en(true));
        RCC.apb2enr().modify(|w| w.set_tim17en(true));
        // Read back, so that the clocks are on (RM0433 8.5.8).
        RCC.ahb1enr().read();
        RCC.apb2enr().read();
        // The prescaler is always 0: the stream that clears reads it.
        stream(PLAY, TIM17_UP, Dir::MEMORY_TO_PERIPHERAL, Pl::HIGH, BOARD.steps.bsrr().as_ptr() as u32);
        stream(CLEAR, TIM17_CH1, Dir::PERIPHERAL_TO_MEMORY, Pl::MEDIUM, TIM17.psc().as_ptr() as u32);
        TIM17.psc().write_value(0);
        TIM17.arr().write(|w| w.set_arr(SLOT_COUNTS as u16 - 1));
        // An update comes in the middle between two multiples of a slot of TIM2. A slot is cleared
        // a quarter of its time after its update.
        TIM17.ccr(0).write(|w| w.set_ccr(SLOT_COUNTS as u16 / 4));
        TIM17.egr().write(|w| w.set_ug(true));
        TIM17.sr().write(|_| {});
        // It begins in the second half of a slot, so that an update comes before anything is
        // cleared. The wait is shorter than a slot.
        let mut count = 0;
        for _ in 0..SLOT_COUNTS {
            count = (TIM2.cnt().read() + SLOT_COUNTS / 2) % SLOT_COUNTS;
            if (SLOT_COUNTS / 2..SLOT_COUNTS * 3 / 4).contains(&count) {
                break;
            }
        }
        TIM17.cnt().write(|w| w.set_cnt(count as u16));
        TIM17.dier().write(|w| {
            w.set_ude(true);
            w.set_ccde(0, true);
        });
        TIM17.cr1().write(|w| w.set_cen(true));
        self.runs = true;
    }
}

/// Slots that DMA has played, modulo the ring.
fn played() -> usize {
    (RING_SLOTS - usize::from(DMA2.st(PLAY).ndtr().read().ndt())) & (RING_SLOTS - 1)
}

/// The slot with which the tick in force begins. An update comes in the middle between two instants
/// at which a tick may begin, so this is exact, unless the next tick is due.
fn found() -> usize {
    let since = (TIM2.cnt().read() + SLOT_COUNTS / 2) / SLOT_COUNTS;
    played().wrapping_sub(since as usize) & (RING_SLOTS - 1)
}

/// A circular stream of words between a fixed address and the ring, in direct mode (RM0433 15.3.10,
/// 15.3.13).
fn stream(number: usize, request: u8, dir: Dir, priority: Pl, fixed: u32) {
    DMAMUX1.ccr(DMA2_CHANNELS + number).write(|w| w.set_dmareq_id(request));
    let stream = DMA2.st(number);
    stream.par().write_value(fixed);
    stream.m0ar().write_value(WORDS.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(RING_SLOTS as u16));
    stream.cr().write(|w| {
        w.set_dir(dir);
        w.set_minc(true);
        w.set_circ(true);
        w.set_psize(Size::BITS32);
        w.set_msize(Size::BITS32);
        w.set_pl(priority);
    });
    // What start-up has written to the ring reaches memory before DMA reads it.
    core::sync::atomic::fence(Ordering::SeqCst);
    stream.cr().modify(|w| w.set_en(true));
}

/// Stops the slots. A step output that is high stays high until its pin is released.
pub fn stop() {
    if RCC.apb2enr().read().tim17en() {
        TIM17.cr1().write(|_| {});
    }
}
