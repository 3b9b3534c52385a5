//! Light and steps, by the captures at the ends of jumpers.
//!
//! In: a bench with nothing connected but jumpers. Out: lines of counts. Owns nothing. What a
//! missing jumper leaves without edges is a line without numbers.
use crate::bench::{Bench, train};
use crate::capture::{self, Edge};
use crate::chip::{LASERS, TIM15};
use crate::report::Report;
use crate::wires::{self, ENERGY_0, ENERGY_1, End, INTERLOCK, MINUS_0, STEP_1, SWITCH_0};
use servo::laser::{Action, Train};
use stm32_metapac::{DMA1, DMA2, TIM1, TIM8, TIM17};

/// Ticks until the timers of the lasers run: their rings are made dark first.
const START_TICKS: u32 = 24;
/// Instant in a tick at which light begins.
const AT_NS: u32 = 10_000;
/// 200 kHz, a fifth of it light.
const PERIOD_COUNTS: u64 = 1200;
const WIDTH_COUNTS: u64 = 240;

/// Starts the timers of the lasers. A report stops them: no tick is served meanwhile.
pub fn settle(bench: &mut Bench) {
    bench.ticks(START_TICKS);
    bench.late = 0;
}

/// Whether the timers of the lasers have started.
pub fn start(bench: &mut Bench, report: &mut Report) {
    settle(bench);
    report.line("running", &bench.ran.map(i64::from));
}

fn light(bench: &mut Bench, at: u32, train: Train) {
    for channel in 0..2 {
        bench.plan(channel, at, Action::Switch(true));
        bench.plan(channel, at, Action::Light(train));
    }
}

/// Both lasers are shut off.
pub fn dark(bench: &mut Bench) {
    for channel in 0..2 {
        bench.shut_off(channel);
    }
    bench.ticks(4);
}

/// The first edges of light of both channels, of the switch and of a step, in lines of these names.
pub fn first_edges(bench: &mut Bench, report: &mut Report, [energy_0, energy_1, switch, steps]: [&str; 4]) {
    settle(bench);
    wires::connect(&[ENERGY_0, ENERGY_1, SWITCH_0, STEP_1]);
    let energies = [(ENERGY_0, Edge::Any), (ENERGY_1, Edge::Any)];
    capture::begin(&[energies[0], energies[1], (SWITCH_0, Edge::Any), (STEP_1, Edge::Rising)]);
    light(bench, AT_NS, train(PERIOD_COUNTS, WIDTH_COUNTS, 0));
    bench.rate = 1;
    // All edges that are reported, however quick the ticks are.
    bench.ticks(5);
    capture::stop();
    bench.rate = 0;
    dark(bench);
    capture::report_to(report, energy_0, ENERGY_0, 24);
    capture::report_to(report, energy_1, ENERGY_1, 24);
    capture::report_to(report, switch, SWITCH_0, 4);
    capture::report_to(report, steps, STEP_1, 4);
}

/// Both lasers at 2 MHz, every second cycle a count longer in the mean, all axes at 1 MHz.
pub fn load(bench: &mut Bench, report: &mut Report) {
    wires::connect(&[ENERGY_0, ENERGY_1, SWITCH_0, STEP_1]);
    let mut late = 0;
    for (name, end, edge) in
        [("load-0", ENERGY_0, Edge::Falling), ("load-1", ENERGY_1, Edge::Falling), ("load-steps", STEP_1, Edge::Rising)]
    {
        settle(bench);
        light(bench, AT_NS, train(120, 60, 1));
        bench.rate = 50;
        bench.ticks(6);
        capture::begin(&[(end, edge)]);
        bench.ticks(4);
        capture::stop();
        bench.rate = 0;
        bench.ticks(2);
        dark(bench);
        late += bench.late;
        capture::report_to(report, name, end, 100);
    }
    report.line("load-late", &[late]);
}

/// Steps of ten ticks: each is played once.
pub fn steps(bench: &mut Bench, report: &mut Report) {
    settle(bench);
    wires::connect(&[STEP_1]);
    capture::begin(&[(STEP_1, Edge::Rising)]);
    bench.rate = 10;
    bench.ticks(10);
    bench.rate = 0;
    bench.ticks(3);
    capture::stop();
    let captured = capture::count(STEP_1) as i64;
    // A stream whose timer is stopped keeps its position.
    let place = || i64::from(DMA2.st(1).ndtr().read().ndt());
    let running = place();
    TIM17.cr1().modify(|w| w.set_cen(false));
    cortex_m::asm::delay(480);
    let stopped = place();
    cortex_m::asm::delay(24_000);
    let later = place();
    TIM17.cr1().modify(|w| w.set_cen(true));
    cortex_m::asm::delay(2_400);
    let resumed = place();
    report.line("steps", &[100, captured]);
    report.line("stream", &[running, stopped, later, resumed]);
}

/// Nobody fills the rings while there is light.
pub fn starve(bench: &mut Bench, report: &mut Report) {
    const ENDS: [End; 3] = [ENERGY_0, ENERGY_1, SWITCH_0];
    let captures = ENDS.map(|end| (end, Edge::Any));
    let edges = || ENDS.map(|end| capture::count(end) as i64);
    settle(bench);
    wires::connect(&ENDS);
    capture::begin(&captures);
    light(bench, AT_NS, train(PERIOD_COUNTS, WIDTH_COUNTS, 0));
    bench.ticks(4);
    capture::stop();
    let lit = edges();
    // What was queued is over after two ticks.
    bench.miss(3);
    capture::begin(&captures);
    let places = || [DMA1.st(0), DMA2.st(0), DMA1.st(1)].map(|stream| i64::from(stream.ndtr().read().ndt()));
    let before = places();
    bench.miss(2);
    let after = places();
    capture::stop();
    let starved = edges();
    let levels = ENDS.map(|end| i64::from(wires::is_high(end)));
    settle(bench);
    dark(bench);
    for (n, (number, _)) in LASERS.into_iter().enumerate() {
        report.line("starved", &[number, lit[n], before[n], after[n], starved[n], levels[n]]);
    }
}

/// Bursts of all lasers' timers are broken off after their first half-word; the timers start anew,
/// and light is as before.
pub fn broken_burst(bench: &mut Bench, report: &mut Report, names: [&str; 4]) {
    settle(bench);
    for (stream, timer) in [(DMA1.st(0), TIM1), (DMA2.st(0), TIM15), (DMA1.st(1), TIM8)] {
        stream.cr().modify(|w| w.set_en(false));
        while stream.cr().read().en() {}
        // The first register of a burst, with what it holds.
        timer.dmar().write(|w| *w = timer.arr().read().0);
    }
    first_edges(bench, report, names);
}

/// The interlock opens within a pulse; then the safe state comes by software within one.
pub fn breaks(bench: &mut Bench, report: &mut Report) {
    let pulse = train(48_000, 24_000, 0);
    settle(bench);
    wires::connect(&[INTERLOCK, ENERGY_1, MINUS_0]);
    light(bench, 0, pulse);
    // The pulse begins with the third of these and lasts for two ticks.
    bench.ticks(3);
    capture::begin(&[(INTERLOCK, Edge::Rising), (ENERGY_1, Edge::Rising), (MINUS_0, Edge::Falling)]);
    cortex_m::asm::delay(4_800);
    wires::open_interlock(true);
    cortex_m::asm::delay(4_800);
    capture::stop();
    let enabled = LASERS.map(|(_, timer)| timer.bdtr().read().moe().into());
    report.line("break-left", &enabled);
    capture::report_to(report, "break-input", INTERLOCK, 4);
    capture::report_to(report, "break-plus", ENERGY_1, 4);
    capture::report_to(report, "break-minus", MINUS_0, 4);
    wires::open_interlock(false);
    hal::board::laser::was_broken();
    dark(bench);
    settle(bench);
    wires::connect(&[ENERGY_0, MINUS_0]);
    light(bench, 0, pulse);
    bench.ticks(3);
    capture::begin(&[(ENERGY_0, Edge::Rising), (MINUS_0, Edge::Falling)]);
    bench.shut_off(0);
    bench.tick();
    cortex_m::asm::delay(480);
    capture::stop();
    dark(bench);
    capture::report_to(report, "off-plus", ENERGY_0, 4);
    capture::report_to(report, "off-minus", MINUS_0, 4);
}
