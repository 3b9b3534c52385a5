#![no_std]
#![no_main]
//! Counts the instructions with which the reference board tells its timers of carriers of 2 MHz whose duty is dithered, in QEMU as
//! `ticks.rs` does and with the same lines out: `CHANNELS rounds-PERIOD COUNT`.
use core::hint::black_box;
use core::sync::atomic::{AtomicU16, AtomicU32};
use cortex_m_semihosting::hprintln;
use hal as _; // the vector table
use probes::clock;
use servo::laser::{Action, CHANNELS, Count, Plan, Train};
use servo::output::{CycleRing, DELAY_LINE_WORDS, DelayLine, GateCycles, PwmCycles, Scale, Slots};

/// Ticks counted of each kind.
const TICKS: usize = 100;
/// The kind whose power is another one in every tick.
const FOLLOWS: &str = "rounds-follow";
/// As on the reference board.
const ENERGY_PLACES: usize = 1152;
const SWITCH_PLACES: usize = 272;
const MHZ: u16 = 240;
const SCALE: Scale = Scale::of_mhz(MHZ);
const FIRST: u16 = 168;
const BEGIN: u64 = 2 * FIRST as u64;

type Ring<const PLACES: usize, const WORDS: usize> = CycleRing<PLACES, WORDS>;

static ENERGIES: [Slots<ENERGY_PLACES, 3>; CHANNELS] =
    [const { [const { [const { AtomicU16::new(0) }; 3] }; ENERGY_PLACES] }; CHANNELS];
static SWITCHES: Slots<SWITCH_PLACES, 6> = [const { [const { AtomicU16::new(0) }; 6] }; SWITCH_PLACES];

static HELD: [[AtomicU32; DELAY_LINE_WORDS]; CHANNELS] =
    [const { [const { AtomicU32::new(0) }; DELAY_LINE_WORDS] }; CHANNELS];

probes::exit_on_panic!();

/// Both channels, as `hal` holds them.
struct Outputs {
    held: [DelayLine; CHANNELS],
    energies: [PwmCycles; CHANNELS],
    rings: [Ring<ENERGY_PLACES, 3>; CHANNELS],
    switches: GateCycles,
    switch_ring: Ring<SWITCH_PLACES, 6>,
    next: u64,
}

impl Outputs {
    /// What a tick of so many ns does for plans that wait for a tick, without the accesses to registers.
    fn tick(&mut self, ns: u32, plans: &[Plan; CHANNELS], read: [usize; CHANNELS]) -> bool {
        let (from, to) = (self.next, self.next.wrapping_add(SCALE.counts(ns).into()));
        self.next = to;
        self.switch_ring.renew(0);
        let mut right = true;
        let channels = self.energies.iter_mut().zip(&mut self.rings).zip(&self.held).zip(read);
        for (((energy, ring), held), read) in channels {
            right &= ring.renew(read);
            energy.take(from, to, held.actions(), &mut |length, light, times| ring.put(length, times, [light]));
        }
        self.switches.hold(self.held[0].actions());
        let ring = &mut self.switch_ring;
        self.switches.take(from, to, self.held[1].actions(), &mut |round| {
            let ([fall_0, fall_1], [rise_0, rise_1]) = (round.falls, round.rises);
            ring.put(round.length, 1, [rise_0, fall_0, fall_1, rise_1]);
        });
        self.held.iter_mut().zip(plans).fold(right, |right, (held, plan)| held.put(plan) && right)
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let run = black_box(Outputs::tick);
    // A third of 120 counts, nearly, of which few pulses in turn are others; half a count more or less, where no two in turn are equal.
    let train =
        |whole, part| Train { period: Count { whole, part: 0, of: 0 }, width: Count { whole: 39, part, of: 0 } };
    let kinds = [
        (10u32, "rounds-10", train(120, 0xfffe_0000)),
        (20, "rounds-20", train(120, 0xfffe_0000)),
        (50, "rounds-50", train(120, 0xfffe_0000)),
        (250, "rounds-250", train(120, 0xfffe_0000)),
        (10, "rounds-odd-10", train(120, 0x8000_0000)),
        (20, "rounds-odd-20", train(120, 0x8000_0000)),
        (50, "rounds-odd-50", train(120, 0x8000_0000)),
        (10, "rounds-follow-10", train(120, 0xfffe_0000)),
        (20, "rounds-follow-20", train(120, 0xfffe_0000)),
        (50, "rounds-follow-50", train(120, 0xfffe_0000)),
        (10, "rounds-follow-odd-10", train(120, 0x8000_0000)),
        (20, "rounds-follow-odd-20", train(120, 0x8000_0000)),
        (50, "rounds-follow-odd-50", train(120, 0x8000_0000)),
        // 1.2 MHz: periods at the end of a tick are told one by one, as shorter rounds.
        (10, "rounds-cut-10", train(200, 0xfffe_0000)),
    ];
    for (us, mark, train) in kinds {
        for lit in 0..=CHANNELS {
            let mut outputs = Outputs {
                held: HELD.each_ref().map(|words| DelayLine::new(words)),
                energies: [const { PwmCycles::from(BEGIN, SCALE) }; CHANNELS],
                rings: ENERGIES.each_ref().map(|places| Ring::new(places, [0; 3])),
                switches: GateCycles::from(BEGIN, SCALE),
                switch_ring: Ring::new(&SWITCHES, [0, 0, u16::MAX, 0, 0, u16::MAX]),
                next: 0,
            };
            while !outputs.rings.iter_mut().fold(outputs.switch_ring.clear(), |all, ring| ring.clear() && all) {}
            outputs.rings.iter_mut().for_each(|ring| ring.begin(FIRST));
            outputs.switch_ring.begin(FIRST);
            let mut plans = [Plan::EMPTY; CHANNELS];
            // What is told two ticks ahead is read when the tick begins.
            let (mut told, mut read) = ([[0usize; CHANNELS]; 2], [0; CHANNELS]);
            for tick in 0..TICKS {
                if tick == 4 {
                    plans.iter_mut().take(lit).for_each(|plan| plan.add(0, Action::Light(train)));
                }
                let before = clock::read();
                let right = run(&mut outputs, us * 1000, &plans, read);
                let count = before.passed();
                assert!(right, "the rings are read where they should be");
                if tick > 8 {
                    hprintln!("{} {} {}", lit, mark, count);
                }
                plans = [Plan::EMPTY; CHANNELS];
                if mark.starts_with(FOLLOWS) && tick >= 4 {
                    let mut other = train;
                    other.width.part = other.width.part.wrapping_add(tick as u32);
                    plans.iter_mut().take(lit).for_each(|plan| plan.add(0, Action::Change(other)));
                }
                told = [told[1], outputs.rings.each_ref().map(Ring::next_word)];
                read = told[0];
            }
        }
    }
    probes::exit()
}
