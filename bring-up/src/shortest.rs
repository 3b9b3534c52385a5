//! The shortest cycles that the firmware makes, one after the other, with all streams busy.
//!
//! In: a bench whose lasers' timers run, jumpers 1 to 4; bytes of the host, which sends 4096 at the
//! line `listens`, so that the link's stream is busy too. Out: lines of counts. Owns the rings of
//! the lasers' timers and of the steps meanwhile, and writes them itself: no tick is served. Cycles
//! of the energies last 84 or 90 counts, those of the switches 120 or 126 (`MIN_COUNTS` of
//! servo/src/output/pwm_cycles.rs and gate_cycles.rs, and six more), and each pulse is of another
//! width than the one before it. A burst that comes late leaves a length or a width of another
//! cycle. Each ring holds a whole number of [`PATTERN`]s, so it goes round without a seam. The
//! timers are started here too: the firmware's own rings have shortest cycles, with which a burst
//! that is too slow would end light before anything is captured. Fails never.
use crate::A_BYTE;
use crate::bench::Bench;
use crate::capture::{self, EDGES, Edge};
use crate::chip::TIM15;
use crate::light;
use crate::pause;
use crate::report::Report;
use crate::wires::{self, ENERGY_0, ENERGY_1, End, STEP_1, SWITCH_0};
use core::sync::atomic::{AtomicU16, AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::DWT;
use hal::board::{laser, uart::Rx, watchdog};
use servo::output::step_generator::RING_SLOTS as STEP_SLOTS;
use servo::output::{GATE_MIN_COUNTS, PWM_MIN_COUNTS};
use stm32_metapac::dma::St;
use stm32_metapac::timer::TimAdv;
use stm32_metapac::timer::vals::OcmGp;
use stm32_metapac::{DMA1, DMA2, TIM1, TIM8};

/// Which cycles of 16 in turn are longer: each four of them in a row are so nowhere else.
const PATTERN: u16 = 0b1111_0101_1001_0000;
/// Counts by which they are longer.
const MORE: u16 = 6;
/// Widths of pulses in turn, in counts.
const WIDTHS: [u16; 2] = [24, 44];
/// A compare value that no cycle reaches.
const NEVER: u16 = u16::MAX;
/// Cycles at which bursts have all time.
const SLOW: u16 = 1200;
/// In this time a burst is over, in cycles of the core.
const BURST: u32 = 500;
/// Two ticks.
const TICKS: u32 = 48_000;
/// 120 edges of the slowest line.
const CAPTURED: u32 = 60_000;
/// Edges that are reported of a capture, and captures of a line.
const REPORTED: usize = 100;
const PASSES: usize = 4;
/// Steps of all axes begin, and end (RM0433 11.4.7: the port's pins 8 to 15).
const STEPS: [u32; 2] = [0xff00, 0xff00_0000];
/// Slots of steps between what is played and what is written.
const AHEAD: usize = 8;

const LINES: [(&str, End, Edge); 7] = [
    ("short-0-begins", ENERGY_0, Edge::Falling),
    ("short-0-ends", ENERGY_0, Edge::Rising),
    ("short-1-begins", ENERGY_1, Edge::Falling),
    ("short-1-ends", ENERGY_1, Edge::Rising),
    ("short-switch-begins", SWITCH_0, Edge::Falling),
    ("short-switch-ends", SWITCH_0, Edge::Rising),
    ("short-steps", STEP_1, Edge::Rising),
];

/// Edges of all captures, and how many there are: a report would take too long in between.
static CAPTURES: [[[AtomicU16; REPORTED]; PASSES]; LINES.len()] =
    [const { [const { [const { AtomicU16::new(0) }; REPORTED] }; PASSES] }; LINES.len()];
static COUNTS: [[AtomicU16; PASSES]; LINES.len()] = [const { [const { AtomicU16::new(0) }; PASSES] }; LINES.len()];

/// A timer of the lasers, its stream, and its ring: slots, half-words of each.
struct Ring {
    timer: TimAdv,
    stream: St,
    slots: usize,
    words: usize,
    /// Its shortest cycle.
    least: u16,
}

fn rings() -> [Ring; 3] {
    let energy =
        |timer, stream| Ring { timer, stream, slots: laser::ENERGY_SLOTS, words: 3, least: PWM_MIN_COUNTS as u16 };
    let switches =
        Ring { timer: TIM8, stream: DMA1.st(1), slots: laser::SWITCH_SLOTS, words: 6, least: GATE_MIN_COUNTS as u16 };
    [energy(TIM1, DMA1.st(0)), energy(TIM15, DMA2.st(0)), switches]
}

impl Ring {
    /// Writes all slots: single cycles, of the pattern or of this length.
    fn fill(&self, length: Option<u16>) {
        // SAFETY: the address of the ring that its stream reads, which the image never moves: a
        // static of so many half-words, all of them atomic.
        let words = unsafe {
            core::slice::from_raw_parts(self.stream.m0ar().read() as *const AtomicU16, self.slots * self.words)
        };
        for (n, slot) in words.chunks_exact(self.words).enumerate() {
            let length = length.unwrap_or(self.least + MORE * (PATTERN >> (n % 16) & 1));
            let width = WIDTHS[n % 2];
            // ARR, RCR; CCR1, or CCR1 to CCR4: rise of switch 0, fall of both, rise of switch 1.
            let values = if self.words == 3 { [width, 0, 0, 0] } else { [NEVER, width, width, NEVER] };
            for (to, value) in slot.iter().zip([length - 1, 0].into_iter().chain(values)) {
                to.store(value, Relaxed);
            }
        }
    }

    /// Stops timer and stream.
    fn stop(&self) {
        self.timer.dier().write(|_| {});
        self.timer.cr1().modify(|w| w.set_cen(false));
        self.stream.cr().modify(|w| w.set_en(false));
        while self.stream.cr().read().en() {}
    }

    /// Starts the timer, which was reset, with two slow cycles, and the stream with its first slot.
    /// The stream's other settings are those of the firmware's start.
    fn start(&self) {
        let Ring { timer, stream, slots, words, .. } = *self;
        timer.arr().write(|w| w.set_arr(SLOW - 1));
        // Loaded now, and in the preload registers for the second cycle.
        timer.egr().write(|w| w.set_ug(true));
        timer.dcr().write(|w| {
            // From ARR on (RM0433 38.4.19).
            w.set_dba(11);
            w.set_dbl(words as u8 - 1);
        });
        stream.ndtr().write(|w| w.set_ndt((slots * words) as u16));
        timer.dier().write(|w| w.set_ude(true));
        stream.cr().modify(|w| w.set_en(true));
        timer.bdtr().modify(|w| w.set_moe(true));
        timer.cr1().modify(|w| w.set_cen(true));
    }

    fn was_updated(&self) -> bool {
        self.timer.sr().read().uif()
    }

    fn forget_update(&self) {
        self.timer.sr().write(|w| {
            w.0 = !0;
            w.set_uif(false);
        });
    }
}

/// Ends the bursts of all timers after a whole one, where that can be.
fn hold(rings: &[Ring; 3]) {
    let began = DWT::cycle_count();
    let mut updated = [None; 3];
    let mut holds = [false; 3];
    rings.iter().for_each(Ring::forget_update);
    while holds.contains(&false) {
        let now = DWT::cycle_count();
        if now.wrapping_sub(began) > TICKS {
            return;
        }
        for ((ring, updated), holds) in rings.iter().zip(&mut updated).zip(&mut holds) {
            if ring.was_updated() {
                ring.forget_update();
                *updated = Some(now);
            } else if !*holds && updated.is_some_and(|at| now.wrapping_sub(at) > BURST) {
                ring.timer.dier().write(|_| {});
                *holds = true;
            }
        }
    }
}

/// Steps of all axes at 1 MHz.
struct Steps {
    next: usize,
}

impl Steps {
    fn played() -> usize {
        (STEP_SLOTS - usize::from(DMA2.st(1).ndtr().read().ndt())) % STEP_SLOTS
    }

    /// They begin after what is played now, with a slot in which they rise.
    fn begin() -> Steps {
        Steps { next: (Self::played() + AHEAD) & !1 }
    }

    /// Writes slots as far as there are some that were played.
    fn fill(&mut self) {
        // SAFETY: the address of the ring that its stream reads: a static of so many words, all of
        // them atomic.
        let words = unsafe { core::slice::from_raw_parts(DMA2.st(1).m0ar().read() as *const AtomicU32, STEP_SLOTS) };
        let played = Self::played();
        while (self.next + STEP_SLOTS - played) % STEP_SLOTS < STEP_SLOTS - 2 * AHEAD {
            for word in STEPS {
                words[self.next % STEP_SLOTS].store(word, Relaxed);
                self.next = (self.next + 1) % STEP_SLOTS;
            }
        }
    }
}

/// Captures edges of all lines while all streams are busy.
fn capture_all() {
    let mut steps = Steps::begin();
    for ((line, counts), (_, end, edge)) in CAPTURES.iter().zip(&COUNTS).zip(LINES) {
        for (pass, count) in line.iter().zip(counts) {
            watchdog::feed();
            let began = DWT::cycle_count();
            capture::begin(&[(end, edge)]);
            while DWT::cycle_count().wrapping_sub(began) < CAPTURED {
                steps.fill();
            }
            capture::stop();
            let kept = capture::count(end).min(REPORTED).min(EDGES);
            count.store(kept as u16, Relaxed);
            for (to, from) in pass.iter().zip(capture::counts(end)) {
                to.store(from.load(Relaxed) as u16, Relaxed);
            }
        }
    }
}

/// The host has this long to send bytes, in cycles: 0.2 s.
const PATIENCE: u32 = 96_000_000;

/// Asks the host for bytes; whether some have come.
fn await_bytes(report: &mut Report, rx: &mut Rx) -> bool {
    while rx.receive().is_some() {}
    report.line("listens", &[]);
    report.flush();
    (0..PATIENCE / A_BYTE).any(|_| {
        pause::cycles(A_BYTE);
        rx.receive().is_some()
    })
}

/// Whether bytes still come: some in 0.1 ms.
fn still_come(rx: &mut Rx) -> bool {
    while rx.receive().is_some() {}
    cortex_m::asm::delay(TICKS);
    rx.receive().is_some()
}

/// See the module text.
pub fn measure(bench: &mut Bench, report: &mut Report, rx: &mut Rx) {
    let began = await_bytes(report, rx);
    let rings = rings();
    // The streams get their settings, and steps run.
    light::settle(bench);
    bench.rate = 1;
    bench.ticks(4);
    bench.rate = 0;
    bench.ticks(2);
    wires::connect(&[ENERGY_0, ENERGY_1, SWITCH_0, STEP_1]);
    rings.iter().for_each(Ring::stop);
    laser::reset();
    clear_flags();
    // The switch of laser 0 follows its timer.
    TIM8.ccmr_output(0).modify(|w| w.set_ocm(1, OcmGp::COMBINED_PWM_MODE_1));
    rings.iter().for_each(|ring| ring.fill(None));
    cortex_m::asm::dsb();
    rings.iter().for_each(Ring::start);
    capture_all();
    let is_filled = began && still_come(rx);
    rings.iter().for_each(|ring| ring.fill(Some(SLOW)));
    cortex_m::asm::dsb();
    // What was read before.
    cortex_m::asm::delay(TICKS);
    hold(&rings);
    // The next ticks find streams that do not go on: everything begins anew.
    rings.iter().for_each(Ring::stop);
    // The steps that are left are played.
    bench.miss(12);
    light::settle(bench);
    light::dark(bench);
    report.line("short-link", &[is_filled.into()]);
    report.line("short-least", &[PWM_MIN_COUNTS.into(), GATE_MIN_COUNTS.into()]);
    report_to(report);
}

/// Flags of streams that were stopped (RM0433 15.5.3): the first two of DMA1, and the first of
/// DMA2.
fn clear_flags() {
    for (dma, streams) in [(DMA1, 0..2), (DMA2, 0..1)] {
        dma.ifcr(0).write(|w| {
            for stream in streams {
                w.set_tcif(stream, true);
                w.set_htif(stream, true);
                w.set_teif(stream, true);
                w.set_dmeif(stream, true);
                w.set_feif(stream, true);
            }
        });
    }
}

fn report_to(report: &mut Report) {
    for ((line, counts), (name, ..)) in CAPTURES.iter().zip(&COUNTS).zip(LINES) {
        for (pass, count) in line.iter().zip(counts) {
            let count = count.load(Relaxed).into();
            report.list(name, pass.iter().take(count).map(|edge| edge.load(Relaxed).into()));
        }
    }
}
