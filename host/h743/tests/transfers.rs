//! DMA, timers and pins together, by register writes at their addresses, with what RM0433 says must
//! come of them, worked out by hand. The clocks are those of reset: every bus and every timer
//! counts in 64ths of a microsecond, 15 units of time.
use h743::bus::Bus;
use h743::dma::{ANSWER, TRANSFER};
use h743::exceptions::Exceptions;
use h743::memory::Memory;
use h743::{Level, Pin, Time};
use std::sync::Arc;

/// A count, and a bus cycle.
const COUNT: Time = 15;

const RCC: u32 = 0x5802_4400;
const TIM1: u32 = 0x4001_0000;
const TIM2: u32 = 0x4000_0000;
const TIM3: u32 = 0x4000_0400;
const TIM8: u32 = 0x4001_0400;
const TIM17: u32 = 0x4001_4800;
const DMA1: u32 = 0x4002_0000;
const DMA2: u32 = 0x4002_0400;
const DMAMUX1: u32 = 0x4002_0800;
const DAC1: u32 = 0x4000_7400;
const SPI3: u32 = 0x4000_3c00;
const RING: u32 = 0x3800_0000;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0c;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const ARR: u32 = 0x2c;
const CCR1: u32 = 0x34;
const CCR2: u32 = 0x38;
const BDTR: u32 = 0x44;
const DCR: u32 = 0x48;
const DMAR: u32 = 0x4c;

/// The peripherals, with every clock on.
struct Bench {
    bus: Bus,
    exceptions: Exceptions,
    memory: Arc<Memory>,
    now: Time,
}

impl Bench {
    fn new() -> Bench {
        let memory = Arc::new(Memory::new());
        let mut bench =
            Bench { bus: Bus::new(memory.clone()), exceptions: Exceptions::default(), memory, now: 1000 * COUNT };
        for enable in [0xd8, 0xdc, 0xe0, 0xe8, 0xf0, 0xf4] {
            bench.set(RCC + enable, u32::MAX);
        }
        bench
    }

    fn set(&mut self, address: u32, value: u32) {
        self.bus.write(address, value, u32::MAX, self.now, &mut self.exceptions).unwrap();
    }

    fn get(&mut self, address: u32) -> u32 {
        self.bus.read(address, self.now, &mut self.exceptions).unwrap()
    }

    fn pass(&mut self, counts: u64) {
        self.now += counts * COUNT;
        self.bus.settle(self.now, &mut self.exceptions);
    }

    /// A pin to its alternate function.
    fn connect(&mut self, name: &str, function: u32) {
        let Pin(port, n) = Pin::named(name).unwrap();
        let (base, n) = (0x5802_0000 + 0x400 * u32::from(port), u32::from(n));
        let half = base + 0x20 + 4 * (n / 8);
        let functions = self.get(half) & !(0xf << (4 * (n % 8)));
        self.set(half, functions | function << (4 * (n % 8)));
        let modes = self.get(base) & !(3 << (2 * n));
        self.set(base, modes | 2 << (2 * n));
    }

    fn words(&self, address: u32, words: &[u32]) {
        for (n, word) in (0..).zip(words) {
            assert!(self.memory.load(address + 4 * n, &word.to_le_bytes()));
        }
    }

    fn halves(&self, address: u32, halves: &[u16]) {
        for (n, half) in (0..).zip(halves) {
            assert!(self.memory.load(address + 2 * n, &half.to_le_bytes()));
        }
    }

    /// A stream (of both controllers) from memory to a register.
    fn stream(&mut self, n: u32, request: u32, register: u32, memory: u32, items: u32, control: u32) {
        self.set(DMAMUX1 + 4 * n, request);
        let stream = DMA1 + 0x400 * (n / 8) + 0x10 + 24 * (n % 8);
        self.set(stream + 0x08, register);
        self.set(stream + 0x0c, memory);
        self.set(stream + 0x04, items);
        self.set(stream, control);
        self.set(stream, control | 1);
    }

    /// A stream that serves `request`, and is asked.
    fn asked_stream(&mut self, request: u8, control: u32) {
        self.stream(0, request.into(), TIM1 + DMAR, RING, 4, control);
        self.bus.dma.request(request, self.now);
        self.pass(1);
        self.set(DMAMUX1, 0);
    }

    /// The edges of a pin since `from`, in counts.
    fn edges(&self, name: &str, from: Time) -> Vec<(u64, bool)> {
        let pin = Pin::named(name).unwrap();
        let of = |change: &h743::gpio::Change| match change.level {
            Level::Driven(level) if change.pin == pin && change.at >= from => Some(((change.at - from) / COUNT, level)),
            _ => None,
        };
        self.bus.gpio.changes.iter().filter_map(of).collect()
    }

    fn complaints(&self) -> String {
        self.bus.complaints.join("\n")
    }
}

/// MINC, CIRC, to a peripheral; words or half-words on both sides.
const WORDS: u32 = 2 << 11 | 2 << 13 | 1 << 10 | 1 << 8 | 1 << 6;
const HALVES: u32 = 1 << 11 | 1 << 13 | 1 << 10 | 1 << 8 | 1 << 6;

/// Slots of 120 counts: TIM17's update (request 112) to GPIOF_BSRR by DMA2 stream 0.
fn slots(ring: &[u32]) -> Bench {
    let mut bench = Bench::new();
    // PF8 is an output, low.
    bench.set(0x5802_1400, !(3 << 16) | 1 << 16);
    bench.words(RING, ring);
    bench.stream(8, 112, 0x5802_1418, RING, ring.len() as u32, WORDS);
    bench.set(TIM17 + ARR, 119);
    bench.set(TIM17 + CR1, 1 << 2);
    bench.set(TIM17 + EGR, 1);
    bench.set(TIM17 + DIER, 1 << 8);
    bench.pass(1);
    bench.set(TIM17 + CR1, 1 << 2 | 1);
    bench
}

#[test]
fn each_update_sends_one_word_of_the_ring_to_a_port() {
    let (rise, fall) = (1 << 8, 1 << 24);
    let mut bench = slots(&[rise, 0, fall, 0]);
    let start = bench.now;
    bench.pass(120 * 8 + 50);
    let expected = [(120, true), (360, false), (600, true), (840, false)].map(|(at, level)| (at + ANSWER, level));
    assert_eq!(bench.edges("PF8", start), expected);
    // Eight words: the ring is at its begin again. Half and end of a round have been reported.
    assert_eq!(bench.get(DMA2 + 0x14), 4);
    assert_eq!(bench.get(DMA2) & 0x3f, 1 << 5 | 1 << 4);
    bench.set(DMA2 + 0x08, 0x3f);
    assert_eq!(bench.get(DMA2) & 0x3f, 0);
    assert_eq!(bench.complaints(), "");
}

#[test]
fn the_next_word_is_read_before_it_is_asked_for() {
    let (rise, fall) = (1 << 8, 1 << 24);
    let mut bench = slots(&[0, 0, 0, 0]);
    let start = bench.now;
    // Word 0 is read already, word 1 is not.
    bench.words(RING, &[rise, 0, 0, 0]);
    bench.pass(120 + 50);
    assert_eq!(bench.edges("PF8", start), []);
    bench.words(RING + 8, &[rise, fall]);
    bench.pass(360);
    assert_eq!(bench.edges("PF8", start), [(360 + ANSWER, true), (480 + ANSWER, false)]);
    assert_eq!(bench.complaints(), "");
}

#[test]
fn with_the_fifo_sixteen_bytes_are_read_ahead() {
    let mut bench = Bench::new();
    bench.set(0x5802_1400, !(3 << 16) | 1 << 16);
    bench.words(RING, &[0; 8]);
    bench.set(DMA2 + 0x24, 1 << 2 | 3);
    bench.stream(8, 112, 0x5802_1418, RING, 8, WORDS);
    bench.words(RING, &[1 << 8, 1 << 8, 1 << 8, 1 << 8, 1 << 8]);
    bench.set(TIM17 + ARR, 119);
    bench.set(TIM17 + EGR, 1);
    bench.set(TIM17 + 0x10, 0);
    bench.set(TIM17 + DIER, 1 << 8);
    bench.pass(1);
    let start = bench.now;
    bench.set(TIM17 + CR1, 1);
    bench.pass(120 * 6);
    assert_eq!(bench.edges("PF8", start), [(600 + ANSWER, true)], "four words were too late, the fifth was not");
}

/// Tiles of TIM1 (ARR, RCR, CCR1) by bursts; the first is set by hand, the second lies in the
/// preloads.
fn cycles(cycles: &[[u16; 3]]) -> (Bench, Time) {
    let mut bench = Bench::new();
    bench.connect("PE9", 1);
    bench.connect("PE8", 1);
    bench.set(TIM1 + CCMR1, 6 << 4 | 1 << 3);
    bench.set(TIM1 + DCR, 2 << 8 | 11);
    bench.set(TIM1 + CR1, 1 << 7 | 1 << 2);
    let load = |bench: &mut Bench, cycle: &[u16; 3]| {
        bench.set(TIM1 + ARR, cycle[0].into());
        bench.set(TIM1 + CCR1, cycle[2].into());
    };
    load(&mut bench, &cycles[0]);
    bench.set(TIM1 + EGR, 1);
    load(&mut bench, &cycles[1]);
    bench.halves(RING, cycles[2..].as_flattened());
    bench.stream(0, 15, TIM1 + DMAR, RING, 3 * (cycles.len() as u32 - 2), HALVES);
    bench.set(TIM1 + CCER, 0b101);
    bench.set(TIM1 + BDTR, 1 << 15);
    bench.set(TIM1 + DIER, 1 << 8);
    let start = bench.now;
    bench.set(TIM1 + CR1, 1 << 7 | 1 << 2 | 1);
    (bench, start)
}

#[test]
fn a_burst_brings_the_slot_after_the_next() {
    // Rounds of 200, 300, 240, 100, 150 counts; light of 50, 0, 240 (all of it), 10, 149 counts.
    let (mut bench, start) =
        cycles(&[[199, 0, 50], [299, 0, 0], [239, 0, 240], [99, 0, 10], [149, 0, 149], [199, 0, 0], [199, 0, 0]]);
    bench.pass(200 + 300 + 240 + 100 + 150 + 200 + 3 * ANSWER);
    let edges = [(0, true), (50, false), (500, true), (750, false), (840, true), (989, false)];
    assert_eq!(bench.edges("PE9", start), edges);
    assert_eq!(bench.edges("PE8", start), edges.map(|(at, level)| (at, !level)));
    assert_eq!(bench.complaints(), "");
    assert_eq!(bench.bus.dma.passed, 3 * 6, "a burst for each of six updates");
}

#[test]
fn a_cycle_shorter_than_a_burst_is_reported() {
    // A burst takes three times the answer; a transfer is over before the next one is asked for.
    const { assert!(TRANSFER <= ANSWER) };
    let least = 3 * ANSWER as u16;
    let tiny = |counts: u16| [counts - 1, 0, 5];
    let (mut bench, _) = cycles(&[tiny(200), tiny(least + 1), tiny(200), tiny(200), tiny(200), tiny(200)]);
    bench.pass(1000);
    assert_eq!((bench.complaints(), bench.bus.dma.lost), (String::new(), 0));
    let (mut bench, _) = cycles(&[tiny(200), tiny(least - 1), tiny(200), tiny(200), tiny(200), tiny(200)]);
    bench.pass(1000);
    assert_eq!(bench.complaints(), "DMA1 stream 0: a request came while the one before still waited");
}

#[test]
fn the_more_urgent_stream_goes_first_and_the_other_waits_a_transfer() {
    let mut bench = Bench::new();
    for port in [0x5802_1400, 0x5802_1800] {
        bench.set(port, !3 | 1);
    }
    bench.words(RING, &[1]);
    // Both hear TIM17's update: stream 1 is more urgent (PL), stream 0 has the lower number.
    bench.stream(8, 112, 0x5802_1418, RING, 1, WORDS);
    bench.stream(9, 112, 0x5802_1818, RING, 1, WORDS | 3 << 16);
    bench.set(TIM17 + DIER, 1 << 8);
    bench.pass(1);
    let start = bench.now;
    bench.set(TIM17 + EGR, 1);
    bench.pass(100);
    assert_eq!(bench.edges("PG0", start), [(ANSWER, true)]);
    assert_eq!(bench.edges("PF0", start), [(ANSWER + TRANSFER, true)]);
}

#[test]
fn a_stream_ends_at_its_count_takes_turns_and_reports_it() {
    let mut bench = Bench::new();
    bench.set(0x5802_1400, !3 | 1);
    bench.words(RING, &[1, 1 << 16]);
    // Not circular, TCIE: off after two words.
    bench.stream(8, 112, 0x5802_1418, RING, 2, WORDS & !(1 << 8) | 1 << 4);
    bench.set(TIM17 + DIER, 1 << 8);
    for updates in 1..=3 {
        bench.set(TIM17 + EGR, 1);
        bench.pass(50);
        assert_eq!(bench.get(DMA2 + 0x10) & 1, u32::from(updates < 2));
        assert_eq!(bench.exceptions.pending[16 + 56], updates >= 2);
    }
    // Two buffers: the target changes with each round, and what is not in use may be changed.
    bench.set(DMA2 + 0x08, 0x3f);
    bench.words(RING + 0x100, &[1]);
    bench.set(DMA2 + 0x20, RING + 0x104);
    bench.set(TIM17 + DIER, 0);
    bench.stream(8, 112, 0x5802_1418, RING + 0x100, 1, WORDS & !(1 << 8) | 1 << 18);
    bench.set(TIM17 + DIER, 1 << 8);
    let turns: Vec<u32> = (0..4)
        .map(|_| {
            bench.set(TIM17 + EGR, 1);
            bench.pass(50);
            bench.get(DMA2 + 0x10) >> 19 & 1
        })
        .collect();
    assert_eq!(turns, [1, 0, 1, 0]);
    bench.set(DMA2 + 0x20, RING + 0x108);
    assert_eq!(bench.complaints(), "");
    bench.set(DMA2 + 0x1c, RING);
    assert_eq!(bench.complaints(), "DMA2 stream 0: its settings are written while it is on");
}

#[test]
fn a_request_stands_until_a_stream_hears_it_or_it_is_withdrawn() {
    for (withdrawn, expected) in [(false, 1), (true, 0)] {
        let mut bench = Bench::new();
        bench.set(TIM17 + DIER, 1 << 8);
        bench.set(TIM17 + EGR, 1);
        if withdrawn {
            bench.set(TIM17 + DIER, 0);
        }
        bench.words(RING, &[1; 4]);
        bench.stream(8, 112, 0x5802_1418, RING, 4, WORDS);
        bench.pass(100);
        assert_eq!(bench.bus.dma.passed, expected);
    }
}

#[test]
fn from_a_register_to_memory() {
    let mut bench = Bench::new();
    bench.set(TIM2 + CNT, 0x1234_5678);
    bench.stream(8, 112, TIM2 + CNT, RING, 2, WORDS & !(1 << 6));
    bench.set(TIM17 + DIER, 1 << 8);
    bench.set(TIM17 + EGR, 1);
    bench.pass(50);
    bench.set(TIM2 + CNT, 7);
    bench.set(TIM17 + EGR, 1);
    bench.pass(50);
    assert_eq!([0, 4].map(|n| bench.memory.word(RING + n)), [Some(0x1234_5678), Some(7)]);
}

#[test]
fn what_a_stream_cannot_do_is_reported() {
    type Case = (fn(&mut Bench), &'static str);
    let cases: [Case; 7] = [
        (|b| b.stream(0, 15, TIM1 + DMAR, 0x2000_0000, 4, WORDS), "DMA1 stream 0: it reaches no memory at its address"),
        (|b| b.stream(0, 15, TIM1 + DMAR, RING, 0, WORDS), "DMA1 stream 0: it is switched on without items"),
        (
            |b| b.stream(0, 15, TIM1 + DMAR, RING + 2, 4, WORDS),
            "DMA1 stream 0: its addresses are no multiples of its items' sizes",
        ),
        (|b| b.stream(8, 0, RING, RING, 4, 2 << 6), "DMA2 stream 0: it is set to what is not modelled"),
        (|b| b.set(DMAMUX1, 1 << 16 | 5), "DMA1 stream 0: synchronised requests are not modelled"),
        // A UART's stream may stop for ever without its bit (ES0392).
        (|b| b.asked_stream(45, WORDS), "DMA1 stream 0: TRBUFF is for UARTs, and for them alone"),
        (|b| b.asked_stream(15, WORDS | 1 << 20), "DMA1 stream 0: TRBUFF is for UARTs, and for them alone"),
    ];
    for (case, expected) in cases {
        let mut bench = Bench::new();
        case(&mut bench);
        assert_eq!(bench.complaints(), expected);
    }
    // Switched off by software, a stream reports its end; it must be cleared first.
    let mut bench = Bench::new();
    bench.stream(0, 15, TIM1 + DMAR, RING, 4, WORDS);
    bench.set(DMA1 + 0x10, WORDS);
    bench.set(DMA1 + 0x10, WORDS | 1);
    assert_eq!(bench.complaints(), "DMA1 stream 0: it is switched on with flags that were not cleared");
}

#[test]
fn a_trigger_starts_timers_together() {
    let mut bench = Bench::new();
    // TIM2's update starts TIM1 and TIM8 (ITR1); TIM1's start is TRGO for TIM15 (ITR0).
    let tim15 = 0x4001_4000;
    for (timer, trigger) in [(TIM1, 1), (TIM8, 1), (tim15, 0)] {
        bench.set(timer + SMCR, 6 | trigger << 4);
        bench.set(timer + ARR, 0xffff);
    }
    bench.set(TIM1 + CR2, 1 << 4);
    bench.set(TIM2 + CR2, 2 << 4);
    bench.set(TIM2 + ARR, 99);
    bench.set(TIM2 + CR1, 1);
    bench.pass(99);
    assert_eq!([TIM1, TIM8, tim15].map(|timer| bench.get(timer + CR1) & 1), [0; 3]);
    bench.pass(1 + 42);
    assert_eq!([TIM1, TIM8, tim15].map(|timer| bench.get(timer + CNT)), [42; 3]);
    // Further triggers change nothing.
    bench.pass(100);
    assert_eq!([TIM1, TIM8, tim15].map(|timer| bench.get(timer + CNT)), [142; 3]);
    assert_eq!(bench.complaints(), "");
}

#[test]
fn combined_channels_give_light_at_both_ends_of_a_round() {
    let mut bench = Bench::new();
    bench.connect("PC7", 3);
    bench.connect("PB0", 3);
    bench.set(TIM8 + ARR, 99);
    bench.set(TIM8 + CCR1, 80);
    bench.set(TIM8 + CCR2, 30);
    // Channel 1 in PWM mode 2, channel 2 in combined PWM mode 1 (1100): below 30 or from 80 on.
    bench.set(TIM8 + CCMR1, 7 << 4 | 4 << 12 | 1 << 24);
    bench.set(TIM8 + EGR, 1);
    // CC2E, CC2P, CC2NE, CC2NP: at rest + is high.
    bench.set(TIM8 + CCER, 0xf0);
    bench.set(TIM8 + BDTR, 1 << 15);
    let start = bench.now;
    bench.set(TIM8 + CR1, 1);
    bench.pass(215);
    let edges = [(0, false), (30, true), (80, false), (130, true), (180, false)];
    assert_eq!(bench.edges("PC7", start), edges);
    assert_eq!(bench.edges("PB0", start), edges.map(|(at, level)| (at, !level)));
    assert_eq!(bench.complaints(), "");
}

#[test]
fn a_break_at_the_pin_ends_a_pulse_at_that_instant() {
    let (mut bench, start) = cycles(&[[199, 0, 150], [199, 0, 150], [199, 0, 150], [199, 0, 150]]);
    let pin = Pin::named("PE15").unwrap();
    bench.bus.drive(pin, Some(false), bench.now, &mut bench.exceptions);
    bench.connect("PE15", 1);
    // BKINE; OSSI, BKE, BKP; both lines rest low.
    bench.set(TIM1 + 0x60, 1);
    bench.set(TIM1 + BDTR, 1 << 15 | 1 << 13 | 1 << 12 | 1 << 10);
    bench.pass(230);
    let at = bench.now;
    bench.bus.drive(pin, Some(true), at, &mut bench.exceptions);
    let edges = [(0, true), (150, false), (200, true), (230, false)];
    assert_eq!(bench.edges("PE9", start), edges);
    bench.bus.drive(pin, Some(false), at, &mut bench.exceptions);
    bench.pass(1000);
    let levels = ["PE9", "PE8"].map(|name| bench.bus.gpio.level(Pin::named(name).unwrap()));
    assert_eq!(levels, [Level::Driven(false); 2]);
    assert_eq!(bench.edges("PE9", start), edges, "nothing comes after it");
    assert_eq!(bench.complaints(), "");
}

#[test]
fn an_encoder_counts_the_edges_at_its_pins() {
    let mut bench = Bench::new();
    let pins = ["PB4", "PB5"].map(|name| Pin::named(name).unwrap());
    // PB4 has a pull-up from reset on.
    bench.bus.drive(pins[0], Some(false), bench.now, &mut bench.exceptions);
    bench.connect("PB4", 2);
    bench.connect("PB5", 2);
    bench.set(TIM3 + CCMR1, 1 | 1 << 8);
    bench.set(TIM3 + SMCR, 3);
    bench.set(TIM3 + ARR, 0xffff);
    bench.set(TIM3 + CR1, 1);
    let turn = |bench: &mut Bench, a: bool, b: bool| {
        for (pin, level) in pins.into_iter().zip([a, b]) {
            bench.bus.drive(pin, Some(level), bench.now, &mut bench.exceptions);
        }
        bench.get(TIM3 + CNT)
    };
    // A first: up, four counts a line.
    let up = [(true, false), (true, true), (false, true), (false, false), (true, false)];
    assert_eq!(up.map(|(a, b)| turn(&mut bench, a, b)), [1, 2, 3, 4, 5]);
    let down = [(false, false), (false, true), (true, true), (true, false), (false, false), (false, true)];
    assert_eq!(down.map(|(a, b)| turn(&mut bench, a, b)), [4, 3, 2, 1, 0, 0xffff]);
    assert_eq!(bench.complaints(), "");
}

#[test]
fn the_dac_shows_what_it_gets_a_bus_cycle_later() {
    let mut bench = Bench::new();
    bench.set(DAC1, 1 | 1 << 16);
    let start = bench.now;
    bench.set(DAC1 + 0x20, 0x0fff_0123);
    bench.pass(5);
    bench.set(DAC1 + 0x0c, 0x7fff);
    bench.pass(5);
    assert_eq!(bench.get(DAC1 + 0x2c), 0x7ff);
    // With a trigger by software it waits for that.
    bench.set(DAC1, 1 << 16);
    bench.set(DAC1, 3 | 1 << 16);
    bench.set(DAC1 + 0x08, 5);
    bench.pass(5);
    assert_eq!(bench.bus.dac.output(0), Some(0x7ff));
    bench.set(DAC1 + 0x04, 1);
    bench.pass(5);
    let changes: Vec<_> =
        bench.bus.dac.changes.iter().filter(|c| c.0 > start).map(|c| ((c.0 - start) / COUNT, c.1, c.2)).collect();
    let expected = [(1, 0, Some(0x123)), (1, 1, Some(0xfff)), (6, 0, Some(0x7ff)), (10, 0, None), (10, 0, Some(0x7ff))];
    assert_eq!(changes, [&expected[..], &[(18, 0, Some(5))]].concat());
    assert_eq!(bench.complaints(), "");
    bench.set(DAC1, 1 << 12);
    assert_eq!(bench.complaints(), "DAC1 is set to what is not modelled");
}

#[test]
fn the_spi_sends_words_bit_by_bit_at_its_kernel_clock() {
    let mut bench = Bench::new();
    // per_ck, which is HSI at 64 MHz; divided by 4: 62.5 ns a bit.
    bench.set(RCC + 0x50, 4 << 12);
    bench.set(SPI3 + 0x08, 1 << 28 | 15);
    bench.set(SPI3 + 0x0c, 1 << 22 | 1 << 17);
    bench.set(SPI3, 1);
    let start = bench.now;
    bench.set(SPI3, 1 | 1 << 9);
    for word in [0xabcd_1234, 0x8000] {
        assert_ne!(bench.get(SPI3 + 0x14) & 2, 0, "TXP");
        bench.set(SPI3 + 0x20, word);
    }
    assert_eq!(bench.get(SPI3 + 0x14) & 1 << 12, 0, "TXC");
    bench.pass(128);
    assert_ne!(bench.get(SPI3 + 0x14) & 1 << 12, 0, "TXC");
    assert_eq!(bench.bus.spi.sent, [(start + 64 * COUNT, 0x1234), (start + 128 * COUNT, 0x8000)]);
    assert_eq!(bench.complaints(), "");
    // TSIZE: it ends by itself, and starts again only by a command.
    bench.set(SPI3, 0);
    bench.set(SPI3 + 0x04, 1);
    bench.set(SPI3, 1);
    bench.set(SPI3, 1 | 1 << 9);
    bench.set(SPI3 + 0x20, 1);
    bench.set(SPI3 + 0x20, 2);
    bench.pass(500);
    assert_eq!((bench.bus.spi.sent.len(), bench.get(SPI3) >> 9 & 1, bench.get(SPI3 + 0x14) >> 3 & 1), (3, 0, 1));
    bench.set(SPI3, 0);
    assert_eq!(bench.complaints(), "SPI3: it is switched off with words on their way");
    let mut bench = Bench::new();
    bench.set(SPI3 + 0x0c, 1 << 22 | 1 << 17);
    bench.set(SPI3, 1);
    bench.set(SPI3, 1 | 1 << 9);
    bench.set(SPI3 + 0x20, 1);
    assert_eq!(bench.complaints(), "SPI3: it has no kernel clock", "PLL1 does not run");
}
