//! The clock's guard: are the lasers' timers broken before an instruction runs?
//!
//! In: the order `lit`; then somebody holds the ST-LINK in reset, so that its clock stops. Out: a
//! line `lit` with MOE of each timer; after a reset and the order `why`, a line `clock-lost` with
//! MOE of each before, and in the NMI's first instructions. Owns the kept words and the NMI. The
//! image waits for the clock at its start, so the second order is heard once the ST-LINK is back.
//! Fails: a chip that lost its supply meanwhile has no such line; nor has one whose light a byte
//! has ended.
//!
//! A byte that comes under light ends it, whatever it is: a key, noise, a port that is opened. The
//! host repeats its order until the first line arrives, so for [`CROSSING_TICKS`] all is dark and
//! what comes counts for nothing. In the first 3 ms of light a byte waits in the link's ring.
use crate::bench::{Bench, train};
use crate::chip::LASERS;
use crate::report::{self, Report};
use crate::wires;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use hal::board::{self, machine::Machine, timer::TickTimer, uart::Rx};
use servo::laser::Action;
use stm32_metapac::RCC;

/// The mark, MOE before, MOE in the NMI: a bit for each of [`LASERS`]. The first is written again
/// at the end, since less than an ECC word may be lost.
#[unsafe(link_section = ".kept.clock_lost")]
static KEPT: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];
/// What the mark says: the NMI came.
const MARK: u32 = 0xc10c_1057;
/// The clock may stop now.
static AWAITS: AtomicBool = AtomicBool::new(false);
/// MOE at the last tick.
static LIT: AtomicU32 = AtomicU32::new(0);

/// Ticks in the dark, 100 ms: an order that was repeated has arrived by then.
const CROSSING_TICKS: u32 = 2000;
/// Ticks until there is light.
const START_TICKS: u32 = 24;
/// For so long the clock may stop: five minutes.
const AWAITED_TICKS: u32 = 6_000_000;

/// MOE of each timer, a bit each.
fn enabled() -> u32 {
    let bits = LASERS.into_iter().enumerate().map(|(n, (_, timer))| u32::from(timer.bdtr().read().moe()) << n);
    bits.fold(0, |all, bit| all | bit)
}

fn numbers(mask: u32) -> [i64; 3] {
    core::array::from_fn(|n| (mask >> n & 1).into())
}

fn light(bench: &mut Bench) {
    bench.ticks(START_TICKS);
    for channel in 0..2 {
        bench.plan(channel, 0, Action::Switch(true));
        bench.plan(channel, 0, Action::Light(train(1200, 240, 0)));
    }
    bench.ticks(4);
}

/// Lights both lasers until the clock stops or a byte comes.
pub fn await_loss(report: &mut Report, machine: Machine, timer: TickTimer, rx: &mut Rx) -> ! {
    KEPT.iter().for_each(|word| word.store(0, Relaxed));
    // From now on RCC_RSR says whether the supply was lost.
    RCC.rsr().modify(|w| w.set_rmvf(true));
    if !wires::has_driver() {
        // Not on its bench: nothing lights.
        report.line("lit", &[0; 3]);
        report.end_at_once();
        SCB::sys_reset()
    }
    // The host shall have the first line.
    report.flush();
    let mut bench = Bench::begin(machine, timer);
    bench.ticks(CROSSING_TICKS);
    while rx.receive().is_some() {}
    light(&mut bench);
    report.line("lit", &numbers(enabled()));
    report.flush();
    // The report has stopped the timers.
    light(&mut bench);
    LIT.store(enabled(), Relaxed);
    AWAITS.store(true, Relaxed);
    report.end_at_once();
    for _ in 0..AWAITED_TICKS {
        bench.tick();
        if rx.receive().is_some() {
            end_light(report);
        }
    }
    SCB::sys_reset()
}

/// Dark at once, by the timers' MOE; then the chip is reset. The NMI shall not take that for the
/// guard's work.
fn end_light(report: &mut Report) -> ! {
    AWAITS.store(false, Relaxed);
    board::safe_state();
    report.remark("a byte has ended the light");
    SCB::sys_reset()
}

#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() {
    let enabled = enabled();
    if !AWAITS.load(Relaxed) {
        report::stop(format_args!("the ST-LINK's clock has stopped"));
    }
    let words = [MARK, LIT.load(Relaxed), enabled];
    KEPT.iter().zip(words).for_each(|(word, value)| word.store(value, Relaxed));
    KEPT[0].store(MARK, Relaxed);
    cortex_m::asm::dsb();
    SCB::sys_reset()
}

/// What the NMI found, if one came. Memory with ECC may fault where nobody has written since
/// power-on, so it is not read then.
pub fn report_to(report: &mut Report) {
    if RCC.rsr().read().porrstf() {
        return;
    }
    let [mark, lit, enabled] = [&KEPT[0], &KEPT[1], &KEPT[2]].map(|word| word.load(Relaxed));
    if mark == MARK {
        let ([a, b, c], [d, e, f]) = (numbers(lit), numbers(enabled));
        report.line("clock-lost", &[a, b, c, d, e, f]);
    }
}
