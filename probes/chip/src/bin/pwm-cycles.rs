#![no_std]
#![no_main]
//! Counts the instructions with which the reference board queues the PWM cycles of its laser
//! timers.
//!
//! The carriers have 2 MHz and a dithered duty. It runs in QEMU as `ticks.rs` does, and prints
//! lines of the same form: `CHANNELS cycles-PERIOD COUNT`.
use core::hint::black_box;
use core::sync::atomic::{AtomicU16, AtomicU32};
use cortex_m_semihosting::hprintln;
use hal as _; // the vector table
use probes::clock;
use servo::laser::{Action, CHANNELS, Count, LaserPlan, Train};
use servo::output::{CycleRing, DELAY_LINE_WORDS, DelayLine, GateCycles, PwmCycles, RingSlots, Scale};

/// Ticks counted of each kind.
const TICKS: usize = 100;
/// The kind whose power changes in every tick.
const FOLLOWS: &str = "cycles-follow";
/// As on the reference board.
const ENERGY_SLOTS: usize = 1152;
const SWITCH_SLOTS: usize = 272;
const MHZ: u16 = 240;
const SCALE: Scale = Scale::of_mhz(MHZ);
const FIRST_CYCLE_COUNTS: u16 = 168;
const RING_BEGIN_COUNTS: u64 = 2 * FIRST_CYCLE_COUNTS as u64;

type Ring<const SLOTS: usize, const WORDS: usize> = CycleRing<SLOTS, WORDS>;

static ENERGIES: [RingSlots<ENERGY_SLOTS, 3>; CHANNELS] =
    [const { [const { [const { AtomicU16::new(0) }; 3] }; ENERGY_SLOTS] }; CHANNELS];
static SWITCHES: RingSlots<SWITCH_SLOTS, 6> = [const { [const { AtomicU16::new(0) }; 6] }; SWITCH_SLOTS];

static DELAY_LINES: [[AtomicU32; DELAY_LINE_WORDS]; CHANNELS] =
    [const { [const { AtomicU32::new(0) }; DELAY_LINE_WORDS] }; CHANNELS];

probes::exit_on_panic!();

/// Both channels, as `hal` holds them.
struct Outputs {
    delay_lines: [DelayLine; CHANNELS],
    energies: [PwmCycles; CHANNELS],
    rings: [Ring<ENERGY_SLOTS, 3>; CHANNELS],
    switches: GateCycles,
    switch_ring: Ring<SWITCH_SLOTS, 6>,
    next: u64,
}

impl Outputs {
    /// Work of a tick of `ns` for the plans of the tick before, without the accesses to registers.
    fn tick(&mut self, ns: u32, plans: &[LaserPlan; CHANNELS], read: [usize; CHANNELS]) -> bool {
        let (from, to) = (self.next, self.next.wrapping_add(SCALE.counts(ns).into()));
        self.next = to;
        self.switch_ring.renew(0);
        let mut right = true;
        let channels = self.energies.iter_mut().zip(&mut self.rings).zip(&self.delay_lines).zip(read);
        for (((energy, ring), delayed), read) in channels {
            right &= ring.renew(read);
            energy.queue(from, to, delayed, ring);
        }
        self.switches.hold(self.delay_lines[0].actions());
        self.switches.queue(from, to, &self.delay_lines[1], &mut self.switch_ring);
        self.delay_lines.iter_mut().zip(plans).fold(right, |right, (delayed, plan)| delayed.put(plan) && right)
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let run = black_box(Outputs::tick);
    // Nearly a third of 120 counts: few successive pulses differ. With half a count: no two are
    // equal.
    let train =
        |whole, part| Train { period: Count { whole, part: 0, of: 0 }, width: Count { whole: 39, part, of: 0 } };
    let kinds = [
        (10u32, "cycles-10", train(120, 0xfffe_0000)),
        (20, "cycles-20", train(120, 0xfffe_0000)),
        (50, "cycles-50", train(120, 0xfffe_0000)),
        (250, "cycles-250", train(120, 0xfffe_0000)),
        (10, "cycles-odd-10", train(120, 0x8000_0000)),
        (20, "cycles-odd-20", train(120, 0x8000_0000)),
        (50, "cycles-odd-50", train(120, 0x8000_0000)),
        (10, "cycles-follow-10", train(120, 0xfffe_0000)),
        (20, "cycles-follow-20", train(120, 0xfffe_0000)),
        (50, "cycles-follow-50", train(120, 0xfffe_0000)),
        (10, "cycles-follow-odd-10", train(120, 0x8000_0000)),
        (20, "cycles-follow-odd-20", train(120, 0x8000_0000)),
        (50, "cycles-follow-odd-50", train(120, 0x8000_0000)),
        // 1.2 MHz: periods at the end of a tick are queued one by one, as shorter cycles.
        (10, "cycles-cut-10", train(200, 0xfffe_0000)),
    ];
    for (us, mark, train) in kinds {
        for lit in 0..=CHANNELS {
            let mut outputs = Outputs {
                delay_lines: DELAY_LINES.each_ref().map(|words| DelayLine::new(words)),
                energies: [const { PwmCycles::from(RING_BEGIN_COUNTS, SCALE) }; CHANNELS],
                rings: ENERGIES.each_ref().map(|slots| Ring::new(slots, [0; 3])),
                switches: GateCycles::from(RING_BEGIN_COUNTS, SCALE),
                switch_ring: Ring::new(&SWITCHES, [0, 0, u16::MAX, 0, 0, u16::MAX]),
                next: 0,
            };
            while !outputs.rings.iter_mut().fold(outputs.switch_ring.clear(), |all, ring| ring.clear() && all) {}
            outputs.rings.iter_mut().for_each(|ring| ring.begin(FIRST_CYCLE_COUNTS));
            outputs.switch_ring.begin(FIRST_CYCLE_COUNTS);
            let mut plans = [LaserPlan::EMPTY; CHANNELS];
            // DMA reads at the start of a tick what was queued two ticks ahead.
            let (mut queued, mut read) = ([[0usize; CHANNELS]; 2], [0; CHANNELS]);
            for tick in 0..TICKS {
                if tick == 4 {
                    plans.iter_mut().take(lit).for_each(|plan| plan.add(0, Action::Light(train)));
                }
                let before = clock::read();
                let right = run(&mut outputs, us * 1000, &plans, read);
                let count = before.passed();
                assert!(right, "DMA reads the rings where it should");
                if tick > 8 {
                    hprintln!("{} {} {}", lit, mark, count);
                }
                plans = [LaserPlan::EMPTY; CHANNELS];
                if mark.starts_with(FOLLOWS) && tick >= 4 {
                    let mut other = train;
                    other.width.part = other.width.part.wrapping_add(tick as u32);
                    plans.iter_mut().take(lit).for_each(|plan| plan.add(0, Action::Change(other)));
                }
                queued = [queued[1], outputs.rings.each_ref().map(Ring::next_word)];
                read = queued[0];
            }
        }
    }
    probes::exit()
}
