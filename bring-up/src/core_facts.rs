//! The core: revision, floating point, cycles, caches, the speed of the link.
//!
//! In: registers of the core, TIM5 as a second clock. Out: lines. Owns DWT's counter and TIM5.
use crate::report::Report;
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::Peripherals;
use cortex_m::peripheral::{DWT, SCB};
use cortex_m::register::control::{self, Fpca};
use stm32_metapac::{FLASH, RCC, TIM5};

/// FPCCR, which `cortex-m` has in a block of its own.
const FPCCR: *const u32 = 0xe000_ef34 as *const u32;
/// CPUID.
const CPUID: *const u32 = 0xe000_ed00 as *const u32;

/// Counts of TIM5 in which cycles are counted: 0.1 ms.
const SPAN_COUNTS: u32 = 24_000;
/// Bytes by which the link is timed.
const FILLING_BYTES: usize = 600;

/// Starts DWT's counter.
pub fn count_cycles() {
    // SAFETY: nobody else uses DCB and DWT.
    let mut core = unsafe { Peripherals::steal() };
    core.DCB.enable_trace();
    DWT::unlock();
    core.DWT.enable_cycle_counter();
}

/// Cycles that something takes, with the two reads of the counter.
pub fn cycles_of<T>(what: impl FnOnce() -> T) -> (u32, T) {
    let began = DWT::cycle_count();
    let result = what();
    (DWT::cycle_count().wrapping_sub(began), result)
}

/// TIM5 counts at 240 MHz, 32 bits, from now on.
pub fn second_clock() {
    RCC.apb1lenr().modify(|w| w.set_tim5en(true));
    // Read back, so that the clock is there (RM0433 8.5.8).
    RCC.apb1lenr().read();
    TIM5.cr1().write(|_| {});
    TIM5.psc().write_value(0);
    TIM5.arr().write_value(u32::MAX);
    TIM5.egr().write(|w| w.set_ug(true));
    TIM5.cr1().write(|w| w.set_cen(true));
}

/// Some code of flash, about 2 KiB: a run of different instructions that the compiler keeps.
#[inline(never)]
fn walk(seed: u32) -> u32 {
    let mut sum = seed;
    macro_rules! steps {
        ($($n:literal)*) => { $(
            sum = black_box(sum).rotate_left($n % 31 + 1) ^ 0x9e37_79b9u32.wrapping_mul($n);
        )* };
    }
    steps!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32);
    steps!(33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60);
    steps!(61 62 63 64 65 66 67 68 69 70 71 72 73 74 75 76 77 78 79 80 81 82 83 84 85 86 87 88);
    sum
}

/// Cycles from a pended exception to its handler, in the middle of which it is taken.
static ENTERED: AtomicU32 = AtomicU32::new(0);

#[cortex_m_rt::exception]
fn PendSV() {
    ENTERED.store(DWT::cycle_count(), Ordering::Relaxed);
}

/// Cycles until PendSV's handler has begun, from code that uses floating-point registers or not.
#[inline(never)]
fn entry(floating: Fpca) -> u32 {
    let mut state = control::read();
    state.set_fpca(floating);
    // SAFETY: the bit says what an exception stacks, and no more.
    unsafe { control::write(state) };
    let began = DWT::cycle_count();
    SCB::set_pendsv();
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    ENTERED.load(Ordering::Relaxed).wrapping_sub(began)
}

/// Both, once their code is in the cache. Nothing else can interrupt: all other interrupts are off.
fn entries() -> [u32; 2] {
    // SAFETY: nothing depends on the mask.
    unsafe { cortex_m::interrupt::enable() };
    entry(Fpca::NotActive);
    let entries = [entry(Fpca::NotActive), entry(Fpca::Active)];
    cortex_m::interrupt::disable();
    entries
}

/// All of them.
pub fn report_to(report: &mut Report) {
    // SAFETY: reading registers of the core.
    let (cpuid, fpccr) = unsafe { (CPUID.read_volatile(), FPCCR.read_volatile()) };
    report.line("cpuid", &[cpuid.into()]);
    report.line("fpccr", &[fpccr.into()]);
    report.line("entry", &entries().map(i64::from));
    let acr = FLASH.acr().read();
    report.line("flash", &[acr.latency().into(), acr.wrhighfreq().into()]);
    report.line("caches", &[SCB::icache_enabled().into(), SCB::dcache_enabled().into()]);

    second_clock();
    let (counts, cycles) = (TIM5.cnt().read(), DWT::cycle_count());
    while TIM5.cnt().read().wrapping_sub(counts) < SPAN_COUNTS {}
    let (counts, cycles) = (TIM5.cnt().read().wrapping_sub(counts), DWT::cycle_count().wrapping_sub(cycles));
    report.line("clocks", &[counts.into(), cycles.into()]);

    // SAFETY: nobody else uses the caches' registers.
    let mut core = unsafe { Peripherals::steal() };
    core.SCB.invalidate_icache();
    let (cold, _) = cycles_of(|| walk(1));
    let (warm, _) = cycles_of(|| walk(2));
    report.line("fetch", &[cold.into(), warm.into()]);

    report.flush();
    let began = TIM5.cnt().read();
    report.fill(FILLING_BYTES);
    report.flush();
    let took = TIM5.cnt().read().wrapping_sub(began);
    report.line("link", &[FILLING_BYTES as i64, took.into()]);
}
