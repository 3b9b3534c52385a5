//! A core that is locked up: when light ends, and when the watchdog resets the chip.
//!
//! In: the board, jumpers 1, 2 and 6. Out: a reset by the watchdog; after it, lines. Owns TIM5,
//! stream 7 of DMA1 and the kept words. No instruction runs meanwhile, so DMA writes what happens:
//! edges of light, and at each tick the count of TIM5. The memory is not cached, and start-up
//! leaves it as it is. Fails: words that are lost are no lines.
use crate::bench::{Bench, TICK_NS, train};
use crate::capture::{self, Edge};
use crate::core_facts;
use crate::report::Report;
use crate::wires::{self, ENERGY_0, ENERGY_1, End};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use hal::board::{machine::Machine, package, timer, timer::TickTimer, watchdog};
use servo::laser::Action;
use stm32_metapac::dma::vals::{Dir, Pl, Size};
use stm32_metapac::{DMA1, DMAMUX1, TIM2, TIM5};

/// Edges that are kept of each laser.
const EDGES: usize = 8;
const LASERS: [End; 2] = [ENERGY_0, ENERGY_1];
/// What the mark says: all of it was written.
const MARK: u32 = 0x10cc_ed00;
/// Ticks until there is light.
const START_TICKS: u32 = 24;
/// Light: 100 kHz, half of it. A tick has ten edges, and begins with one to light.
const PERIOD_COUNTS: u64 = 2400;
/// Counts in a period: captures begin here, in the dark.
const CAPTURES: core::ops::Range<u32> = 1600..2000;
/// The core is locked up here: each laser is lit, and its edge to that is in the memory.
const LIT: core::ops::Range<u32> = 200..400;
/// The stream, and its channel of DMAMUX1; the request of TIM2's update (RM0433 17.3.2).
const STREAM: usize = 7;
const TIM2_UP: u8 = 22;

/// Edges, in counts of TIM2.
#[unsafe(link_section = ".kept.edges")]
static KEPT_EDGES: [[AtomicU32; EDGES]; 2] = [const { [const { AtomicU32::new(0) }; EDGES] }; 2];
/// The mark, the count of TIM2 at the lock-up, edges before it, TIM5 at the last feeding.
#[unsafe(link_section = ".kept.locked")]
static LOCKED: [AtomicU32; 5] = [const { AtomicU32::new(0) }; 5];
/// TIM5 at the last tick before the reset.
#[unsafe(link_section = ".kept.last_tick")]
static LAST_TICK: AtomicU32 = AtomicU32::new(0);

/// No edge has this count.
const NONE: u32 = u32::MAX;

/// Lights both lasers, where the board is the image's and on its bench, and locks the core up.
pub fn until_reset(machine: Machine, mut timer: TickTimer) -> ! {
    // What a run before has left says nothing of this one.
    LOCKED.iter().for_each(|word| word.store(0, Relaxed));
    KEPT_EDGES.iter().flatten().for_each(|edge| edge.store(NONE, Relaxed));
    core_facts::second_clock();
    if package::is_other() || !wires::has_driver() {
        timer.run_at(TICK_NS);
        timer::start();
        clock_ticks();
    } else {
        wires::open_interlock(false);
        let mut bench = Bench::begin(machine, timer);
        clock_ticks();
        light(&mut bench);
    }
    // No edge comes here for 5 us.
    let before = LASERS.map(|end| (EDGES - capture::left(end)) as u32);
    let tick_count = TIM2.cnt().read();
    watchdog::feed();
    let fed = TIM5.cnt().read();
    let words = [MARK, tick_count, before[0], before[1], fed];
    LOCKED.iter().zip(words).for_each(|(word, value)| word.store(value, Relaxed));
    // All has left the core.
    cortex_m::asm::dsb();
    // SAFETY: at the priority of a HardFault an undefined instruction has no handler (Armv7-M
    // B1.5.15). The core stops for good, and every register and variable is lost.
    unsafe { core::arch::asm!("cpsid f", "udf #0", options(noreturn)) }
}

/// Both lasers pulse, and their edges go to the kept words from a dark moment on, until the next
/// pulse has begun.
fn light(bench: &mut Bench) {
    bench.ticks(START_TICKS);
    wires::connect(&LASERS);
    for channel in 0..2 {
        bench.plan(channel, 0, Action::Light(train(PERIOD_COUNTS, PERIOD_COUNTS / 2, 0)));
    }
    bench.ticks(4);
    await_counts(CAPTURES);
    let edges = KEPT_EDGES.iter().map(|edges| edges.as_slice());
    LASERS.into_iter().zip(edges).for_each(|(end, edges)| capture::begin_into(end, Edge::Any, edges));
    await_counts(LIT);
}

/// Waits for these counts of a period of light. TIM2 runs, so they come.
fn await_counts(counts: core::ops::Range<u32>) {
    while !counts.contains(&(TIM2.cnt().read() % PERIOD_COUNTS as u32)) {}
}

/// Each tick writes the count of TIM5.
fn clock_ticks() {
    let stream = DMA1.st(STREAM);
    DMAMUX1.ccr(STREAM).write(|w| w.set_dmareq_id(TIM2_UP));
    stream.par().write_value(TIM5.cnt().as_ptr() as u32);
    stream.m0ar().write_value(LAST_TICK.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(1));
    stream.cr().write(|w| {
        w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
        w.set_circ(true);
        w.set_psize(Size::BITS32);
        w.set_msize(Size::BITS32);
        w.set_pl(Pl::LOW);
        w.set_en(true);
    });
    TIM2.dier().modify(|w| w.set_ude(true));
}

/// What was kept. A word that no start has written since power-on may fault, so call it only once
/// the steps of [`crate::before`] say that this one has.
pub fn report_to(report: &mut Report) {
    let [mark, tick_count, before_0, before_1, fed] =
        [0, 1, 2, 3, 4].map(|n: usize| LOCKED.get(n).map_or(0, |word| word.load(Relaxed)));
    if mark != MARK {
        return;
    }
    report.line("watchdog", &[LAST_TICK.load(Relaxed).wrapping_sub(fed).into()]);
    for ((name, before), kept) in [("lock-up-0", before_0), ("lock-up-1", before_1)].into_iter().zip(&KEPT_EDGES) {
        let mut numbers = [0; 2 + EDGES];
        let edges = kept.iter().map(|edge| edge.load(Relaxed)).take_while(|count| *count != NONE);
        let all = [tick_count, before].into_iter().chain(edges);
        let count = numbers.iter_mut().zip(all).map(|(to, from)| *to = from.into()).count();
        report.line(name, &numbers[..count]);
    }
}
