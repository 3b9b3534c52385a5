//! Each model by itself: sequences of register writes, with what RM0433 says must come of them,
//! worked out by hand.
use h743::adc::Adc;
use h743::device::{Device, Signal, Source};
use h743::gpio::{Gpio, Level, Pin};
use h743::timer::{KINDS, Timer};
use h743::usart::Usart;
use h743::watchdog::{LSI, Watchdog};
use h743::{Cause, MICROSECOND, Time};

/// A count of a timer at 240 MHz.
const COUNT: Time = 4;

/// A timer at 240 MHz and what it has sent.
struct Bench {
    timer: Timer,
    now: Time,
    signals: Vec<(Time, Signal)>,
}

impl Bench {
    fn new(number: u8) -> Bench {
        let kind = KINDS.into_iter().find(|kind| kind.number == number).unwrap();
        let mut timer = Timer::new(kind);
        let mut clocks = h743::clocks::Clocks::RESET;
        (clocks.timers1, clocks.timers2) = (COUNT, COUNT);
        timer.clocks(&clocks, 0);
        Bench { timer, now: 1000, signals: Vec::new() }
    }

    fn set(&mut self, offset: u32, value: u32) {
        let mut out = Vec::new();
        assert_eq!(self.timer.write(offset, value, u32::MAX, self.now, &mut out), Some(()), "{offset:#x}");
        self.keep(out, self.now);
    }

    fn get(&mut self, offset: u32) -> u32 {
        self.timer.read(offset, self.now, &mut Vec::new()).unwrap()
    }

    fn keep(&mut self, out: Vec<Signal>, at: Time) {
        self.signals.extend(out.into_iter().map(|signal| (at, signal)));
    }

    /// Lets so many counts pass, event by event.
    fn pass(&mut self, counts: u64) {
        let end = self.now + counts * COUNT;
        while self.timer.next() <= end {
            let at = self.timer.next();
            let mut out = Vec::new();
            self.timer.advance(at, &mut out);
            self.keep(out, at);
        }
        self.now = end;
    }

    /// The edges of an output, in counts since `from`.
    fn edges(&self, channel: u8, complementary: bool, from: Time) -> Vec<(i64, Option<bool>)> {
        let source = Source::Timer(self.timer.kind.number, channel, complementary);
        let of = |&(at, signal): &(Time, Signal)| match signal {
            Signal::Output(from_source, level) if from_source == source => {
                Some(((at as i64 - from as i64) / COUNT as i64, level))
            }
            _ => None,
        };
        self.signals.iter().filter_map(of).collect()
    }

    fn requests(&self, number: u8, from: Time) -> Vec<u64> {
        let of = |&(at, signal): &(Time, Signal)| (signal == Signal::Request(number)).then(|| (at - from) / COUNT);
        self.signals.iter().filter_map(of).collect()
    }
}

const CR1: u32 = 0x00;
const DIER: u32 = 0x0c;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2c;
const RCR: u32 = 0x30;
const CCR1: u32 = 0x34;
const BDTR: u32 = 0x44;

#[test]
fn an_up_counter_overflows_after_its_reload_value() {
    let mut bench = Bench::new(2);
    bench.set(ARR, 11_999);
    bench.set(CR1, 1 << 2);
    bench.set(DIER, 1);
    bench.set(EGR, 1);
    assert_eq!(bench.get(SR), 0, "URS: an update by software is no interrupt");
    bench.set(CR1, 1 << 2 | 1);
    let start = bench.now;
    bench.pass(11_999);
    assert_eq!((bench.get(CNT), bench.get(SR) & 1), (11_999, 0));
    bench.pass(1);
    assert_eq!((bench.get(CNT), bench.get(SR) & 1), (0, 1));
    assert!(bench.signals.contains(&(start + 12_000 * COUNT, Signal::Line(28, true))), "50 µs after the start");
    // Only the flag that is written 0 goes; the compare flags stand (all four channels are at 0).
    bench.set(SR, !1);
    assert_eq!(bench.get(SR), 0x1e);
    assert_eq!(bench.signals.last(), Some(&(bench.now, Signal::Line(28, false))));
    // Without preload a new reload value counts for this round.
    bench.pass(100);
    bench.set(ARR, 200);
    bench.pass(101);
    assert_eq!((bench.get(CNT), bench.get(SR) & 1), (0, 1));
}

#[test]
fn a_preloaded_reload_value_and_prescaler_wait_for_the_update() {
    let mut bench = Bench::new(3);
    bench.set(PSC, 1);
    bench.set(ARR, 9);
    bench.set(EGR, 1);
    bench.set(CR1, 1 << 7 | 1);
    bench.pass(4);
    assert_eq!(bench.get(CNT), 2, "divided by two");
    bench.set(ARR, 4);
    bench.set(PSC, 0);
    bench.pass(15);
    assert_eq!(bench.get(CNT), 9, "the old round goes to its end");
    bench.pass(1 + 4);
    assert_eq!(bench.get(CNT), 4);
    bench.pass(1);
    assert_eq!(bench.get(CNT), 0, "the new one is five counts long");
}

#[test]
fn a_counter_past_its_reload_value_wraps_at_its_width() {
    let mut bench = Bench::new(3);
    bench.set(ARR, 1000);
    bench.set(EGR, 1);
    bench.set(CR1, 1);
    bench.pass(500);
    bench.set(ARR, 100);
    bench.pass(65_535 - 500);
    assert_eq!(bench.get(CNT), 65_535);
    bench.pass(1);
    assert_eq!(bench.get(CNT), 0);
    bench.pass(101);
    assert_eq!(bench.get(CNT), 0);
}

#[test]
fn pwm_1_is_active_below_the_compare_value_and_its_complement_above() {
    let mut bench = Bench::new(1);
    bench.set(ARR, 99);
    bench.set(CCR1, 30);
    // OC1M 110, OC1PE.
    bench.set(CCMR1, 6 << 4 | 1 << 3);
    bench.set(EGR, 1);
    bench.set(CCER, 0b101);
    assert_eq!(bench.edges(1, false, 0), [], "without MOE the timer drives nothing");
    bench.set(BDTR, 1 << 15);
    bench.set(CR1, 1);
    let start = bench.now;
    bench.pass(150);
    // Preloaded: it counts from the next round on.
    bench.set(CCR1, 0);
    bench.pass(140);
    bench.set(CCR1, 100);
    bench.pass(260);
    let levels = [(0, true), (30, false), (100, true), (130, false), (300, true)];
    assert_eq!(bench.edges(1, false, start), levels.map(|(at, level)| (at, Some(level))));
    assert_eq!(bench.edges(1, true, start), levels.map(|(at, level)| (at, Some(!level))));
}

#[test]
fn pwm_2_is_the_reverse_and_polarity_turns_each_output_by_itself() {
    let mut bench = Bench::new(8);
    bench.set(ARR, 9);
    bench.set(CCR1, 4);
    bench.set(CCMR1, 7 << 4);
    bench.set(CCER, 0b0111);
    bench.set(BDTR, 1 << 15);
    bench.set(EGR, 1);
    bench.set(CR1, 1);
    let start = bench.now;
    bench.pass(15);
    // OC1 is inverted: high while the reference is low. OC1N is the reference's complement.
    let later = |edges: Vec<(i64, Option<bool>)>| edges.into_iter().filter(|edge| edge.0 > 0).collect::<Vec<_>>();
    let expected = [(4, false), (10, true), (14, false)].map(|(at, level)| (at, Some(level)));
    assert_eq!(later(bench.edges(1, false, start)), expected);
    assert_eq!(later(bench.edges(1, true, start)), expected);
}

#[test]
fn compare_modes_set_clear_and_toggle_at_the_match_only() {
    for (mode, expected) in [(1, vec![(25, true)]), (3, vec![(25, true), (75, false), (125, true)])] {
        let mut bench = Bench::new(1);
        bench.set(ARR, 49);
        bench.set(CCR1, 25);
        bench.set(CCMR1, mode << 4);
        bench.set(CCER, 1);
        bench.set(BDTR, 1 << 15);
        bench.set(EGR, 1);
        bench.set(CR1, 1);
        let start = bench.now;
        bench.pass(130);
        let mut edges: Vec<_> = bench.edges(1, false, start).into_iter().filter(|edge| edge.0 > 0).collect();
        let expected: Vec<_> = expected.into_iter().map(|(at, level)| (at, Some(level))).collect();
        assert_eq!(edges, expected, "mode {mode}");
        // Forced: at once, whatever the counter says.
        bench.set(CCMR1, 4 << 4);
        bench.set(CCMR1, 5 << 4);
        edges = bench.edges(1, false, start);
        assert_eq!(edges[edges.len() - 2..], [(130, Some(false)), (130, Some(true))]);
    }
}

#[test]
fn repetition_spares_updates_and_their_dma_requests() {
    let mut bench = Bench::new(1);
    bench.set(ARR, 9);
    bench.set(RCR, 2);
    bench.set(EGR, 1);
    bench.set(DIER, 1 << 8);
    bench.set(CR1, 1);
    let start = bench.now;
    bench.pass(100);
    // An update every third round; TIM1_UP is request 15.
    assert_eq!(bench.requests(15, start), [30, 60, 90]);
    // TIM15 counts 256 at most.
    let mut bench = Bench::new(15);
    bench.set(RCR, 0x1ff);
    assert_eq!(bench.get(RCR), 0xff);
}

#[test]
fn compare_requests_come_at_the_match() {
    let mut bench = Bench::new(1);
    bench.set(ARR, 9);
    bench.set(CCR1, 7);
    bench.set(EGR, 1);
    bench.set(DIER, 1 << 9);
    bench.set(CR1, 1);
    let start = bench.now;
    bench.pass(25);
    assert_eq!(bench.requests(11, start), [7, 17]);
}

#[test]
fn one_pulse_mode_stops_at_the_update() {
    let mut bench = Bench::new(5);
    bench.set(ARR, 49);
    bench.set(EGR, 1);
    bench.set(CR1, 1 << 3 | 1);
    bench.pass(200);
    assert_eq!((bench.get(CR1) & 1, bench.get(CNT)), (0, 0));
    assert_eq!(bench.timer.next(), Time::MAX);
}

#[test]
fn a_reload_value_of_0_blocks_the_counter_dark_until_an_update_by_software() {
    let mut bench = Bench::new(1);
    bench.set(ARR, 99);
    bench.set(CCR1, 30);
    bench.set(CCMR1, 6 << 4 | 1 << 3);
    bench.set(EGR, 1);
    bench.set(CCER, 1);
    bench.set(BDTR, 1 << 15);
    bench.set(DIER, 1 << 8);
    bench.set(CR1, 1 << 7 | 1);
    let start = bench.now;
    bench.pass(50);
    bench.set(ARR, 0);
    bench.set(CCR1, 0);
    bench.pass(100_000);
    let round = [(0, Some(true)), (30, Some(false))];
    assert_eq!(bench.edges(1, false, start), round, "the round to its end, and nothing behind it");
    assert_eq!(bench.requests(15, start), [100], "the update that blocks it asks DMA for the last time");
    assert_eq!((bench.get(CNT), bench.timer.next()), (0, Time::MAX));
    bench.set(ARR, 9);
    bench.pass(100);
    assert_eq!(bench.get(CNT), 0, "preloaded: not in force");
    bench.set(EGR, 1);
    bench.pass(13);
    assert_eq!(bench.get(CNT), 3);
}

#[test]
fn a_break_takes_the_outputs_to_their_idle_levels_without_an_instruction() {
    for (bits, idle, expected) in [
        // OSSI 0: not driven any more.
        (0, 0, [None, None]),
        // OSSI 1: the idle states of CR2; here the + line high, the - line low.
        (1 << 10, 1 << 8, [Some(true), Some(false)]),
    ] {
        let mut bench = Bench::new(1);
        bench.set(0x04, idle);
        bench.set(ARR, 99);
        bench.set(CCR1, 60);
        bench.set(CCMR1, 6 << 4);
        bench.set(CCER, 0b101);
        // BKINE; BKE, BKP (active high), MOE.
        bench.set(0x60, 1);
        bench.set(BDTR, bits | 1 << 12 | 1 << 13 | 1 << 15);
        bench.set(EGR, 1);
        bench.set(DIER, 1 << 7);
        bench.set(CR1, 1);
        bench.pass(70);
        let mut out = Vec::new();
        bench.timer.break_input(true, &mut out, bench.now);
        bench.keep(out, bench.now);
        assert!(bench.signals.contains(&(bench.now, Signal::Line(24, true))));
        // Inactive for two counts, then idle.
        bench.pass(3);
        let last = |bench: &Bench, n| bench.edges(1, n, 0).last().unwrap().1;
        assert_eq!([last(&bench, false), last(&bench, true)], expected);
        assert_eq!(bench.get(BDTR) & 1 << 15, 0, "MOE");
        assert_eq!(bench.get(SR) & 1 << 7, 1 << 7, "BIF");
        // Nothing brings them back while the input is active, and nothing but software after it.
        bench.set(BDTR, bits | 1 << 12 | 1 << 13 | 1 << 15);
        assert_eq!(bench.get(BDTR) & 1 << 15, 0);
        bench.timer.break_input(false, &mut Vec::new(), bench.now);
        bench.pass(300);
        assert_eq!(bench.get(BDTR) & 1 << 15, 0);
        bench.set(BDTR, bits | 1 << 12 | 1 << 13 | 1 << 15);
        assert_ne!(bench.get(BDTR) & 1 << 15, 0);
    }
}

#[test]
fn an_encoder_counts_modulo_its_reload_value() {
    let mut bench = Bench::new(4);
    bench.set(0x08, 3);
    bench.set(ARR, 0xffff);
    bench.set(CR1, 1);
    bench.timer.turn(-3);
    assert_eq!(bench.get(CNT), 0xfffd);
    bench.timer.turn(10);
    bench.pass(1000);
    assert_eq!(bench.get(CNT), 7);
}

#[test]
fn a_channel_captures_the_edges_that_it_is_set_to_and_asks_dma_for_each() {
    // CCER of the second channel: CC2E, CC2P, CC2NP; then the edges that it takes.
    for (enables, taken) in [(0x10, [true, false]), (0x30, [false, true]), (0xb0, [true, true])] {
        let mut bench = Bench::new(2);
        bench.set(ARR, 999);
        bench.set(CCMR1, 1 << 8);
        bench.set(CCER, enables);
        bench.set(DIER, 1 << 10);
        bench.set(CR1, 1);
        for (level, count, is_taken) in [(true, 300, taken[0]), (false, 650, taken[1])] {
            let here = u64::from(bench.get(CNT));
            bench.pass(count - here);
            let (before, mut out) = (bench.requests(19, 0).len(), Vec::new());
            bench.timer.inputs([false, level, false, false], bench.now, &mut out);
            bench.keep(out, bench.now);
            assert_eq!(bench.requests(19, 0).len() - before, usize::from(is_taken), "{enables:#x} {level}");
            if is_taken {
                assert_ne!(bench.get(SR) & 1 << 2, 0);
                assert_eq!(bench.get(0x38), count as u32, "{enables:#x} {level}");
                assert_eq!(bench.get(SR) & 1 << 2, 0, "reading takes the flag away");
            }
        }
    }
}

#[test]
fn what_is_not_modelled_is_reported() {
    for (offset, value) in [(CR1, 1 << 4), (BDTR, 5), (CCMR1, 8 << 13), (0x04, 4 << 4), (0x08, 4)] {
        let mut bench = Bench::new(1);
        bench.set(offset, value);
        assert!(bench.timer.complaint.is_some(), "{offset:#x} {value:#x}");
    }
    let mut bench = Bench::new(1);
    bench.set(CCMR1, 1);
    assert_eq!(bench.timer.complaint, None);
    bench.set(CCER, 1);
    assert_eq!(bench.timer.complaint.as_deref(), Some("TIM1: such a capture is not modelled"));
    assert_eq!(Bench::new(1).timer.read(0x3fc, 0, &mut Vec::new()), None);
}

#[test]
fn pins_are_analog_from_reset_on_and_change_by_registers_only() {
    let mut gpio = Gpio::default();
    let pin = Pin::named("PE9").unwrap();
    let mut out = Vec::new();
    let port = 4 * 0x400;
    assert_eq!(gpio.read(port, 0, &mut out), Some(0xffff_ffff));
    assert_eq!(gpio.level(pin), Level::Floating);
    assert_eq!(gpio.level(Pin::named("PA15").unwrap()), Level::Pulled(true), "the debug port's pull");
    // Its output register first, then its mode: nothing is driven in between.
    gpio.write(port + 0x18, 1 << 9, u32::MAX, 5, &mut out).unwrap();
    assert_eq!(gpio.level(pin), Level::Floating);
    gpio.write(port, !(3 << 18) | 1 << 18, u32::MAX, 6, &mut out).unwrap();
    assert_eq!(gpio.level(pin), Level::Driven(true));
    // Both halves of BSRR: setting wins; a bit of the upper half alone resets.
    gpio.write(port + 0x18, 1 << 9 | 1 << 25, u32::MAX, 7, &mut out).unwrap();
    assert_eq!(gpio.level(pin), Level::Driven(true));
    gpio.write(port + 0x18, 1 << 25, u32::MAX, 8, &mut out).unwrap();
    // An alternate function that no peripheral drives is not driven; one that a timer drives shows
    // it.
    gpio.write(port + 0x24, 1 << 4, u32::MAX, 9, &mut out).unwrap();
    gpio.write(port, !(3 << 18) | 2 << 18, u32::MAX, 10, &mut out).unwrap();
    assert_eq!(gpio.level(pin), Level::Floating);
    gpio.publish(Source::Timer(1, 1, false), Some(true), 11);
    gpio.publish(Source::Timer(1, 1, false), None, 12);
    let changes: Vec<_> = gpio.changes.iter().map(|change| (change.at, change.pin == pin, change.level)).collect();
    let expected = [
        (6, true, Level::Driven(true)),
        (8, true, Level::Driven(false)),
        (10, true, Level::Floating),
        (11, true, Level::Driven(true)),
        (12, true, Level::Floating),
    ];
    assert_eq!(changes, expected);
}

#[test]
fn inputs_read_what_the_world_drives_else_their_pulls() {
    let mut gpio = Gpio::default();
    let mut out = Vec::new();
    let (port, pin) = (2 * 0x400, Pin::named("PC13").unwrap());
    gpio.drive(pin, Some(true));
    assert_eq!(gpio.read(port + 0x10, 0, &mut out), Some(0), "analog pins read 0");
    gpio.write(port, !(3 << 26), u32::MAX, 0, &mut out).unwrap();
    assert_eq!(gpio.read(port + 0x10, 0, &mut out), Some(1 << 13));
    gpio.drive(pin, None);
    assert_eq!(gpio.read(port + 0x10, 0, &mut out), Some(0));
    gpio.write(port + 0x0c, 1 << 26, u32::MAX, 0, &mut out).unwrap();
    assert_eq!(gpio.read(port + 0x10, 0, &mut out), Some(1 << 13));
}

/// A USART at 120 MHz, 3 Mbaud: a byte takes 3200 units.
fn usart(cr1: u32, cr3: u32) -> Usart {
    let mut usart = Usart::new(39);
    let mut clocks = h743::clocks::Clocks::RESET;
    clocks.apb1 = 8;
    usart.clocks(&clocks, 0);
    let mut out = Vec::new();
    for (offset, value) in [(0x0c, 40), (0x08, cr3), (0x00, cr1), (0x00, cr1 | 1)] {
        usart.write(offset, value, u32::MAX, 0, &mut out).unwrap();
    }
    usart
}

const BYTE: Time = 3200;

fn let_pass(usart: &mut Usart, to: Time) -> Option<bool> {
    let mut out = Vec::new();
    while usart.next() <= to {
        let at = usart.next();
        usart.advance(at, &mut out);
    }
    out.into_iter().rev().find_map(|signal| match signal {
        Signal::Line(39, high) => Some(high),
        _ => None,
    })
}

#[test]
fn a_usart_sends_back_to_back_and_reports_when_its_fifo_is_half_empty() {
    // FIFOEN, TE, RE; TXFTCFG one half, TXFTIE.
    let mut usart = usart(1 << 29 | 1 << 3 | 1 << 2, 2 << 29 | 1 << 23);
    let mut out = Vec::new();
    for byte in 0..17 {
        assert_ne!(usart.read(0x1c, 0, &mut out).unwrap() & 1 << 7, 0, "there is room for byte {byte}");
        usart.write(0x28, byte, u32::MAX, 0, &mut out).unwrap();
    }
    // One is on the wire, sixteen wait.
    assert_eq!(usart.read(0x1c, 0, &mut out).unwrap() & 1 << 7, 0);
    assert_eq!(out.last(), Some(&Signal::Line(39, false)));
    assert_eq!(let_pass(&mut usart, 7 * BYTE), Some(false));
    assert_eq!(let_pass(&mut usart, 8 * BYTE), Some(true), "eight places are free");
    let_pass(&mut usart, 17 * BYTE);
    assert_eq!(usart.sent, (0..17).map(|n| ((n + 1) * BYTE, n as u8)).collect::<Vec<_>>());
    assert_ne!(usart.read(0x1c, 0, &mut out).unwrap() & 1 << 6, 0, "TC");
    assert_eq!(usart.complaint, None);
}

#[test]
fn a_usart_receives_into_its_fifo_reports_at_its_threshold_and_of_silence_and_loses_what_has_no_room() {
    // RXFTCFG one half, RXFTIE; IDLEIE.
    let mut usart = usart(1 << 29 | 1 << 2 | 1 << 4, 2 << 25 | 1 << 28);
    let bytes: Vec<u8> = (0..20).collect();
    usart.host_sends(&bytes, 0);
    assert_eq!(let_pass(&mut usart, 7 * BYTE), Some(false));
    assert_eq!(let_pass(&mut usart, 8 * BYTE), Some(true));
    let_pass(&mut usart, 20 * BYTE);
    let mut out = Vec::new();
    assert_eq!(usart.read(0x1c, 0, &mut out).unwrap() & 0x18, 1 << 3, "ORE; the line is not silent for long enough");
    assert_eq!(usart.lost, 4);
    let_pass(&mut usart, 21 * BYTE);
    assert_eq!(usart.read(0x1c, 0, &mut out).unwrap() & 0x18, 3 << 3, "IDLE, a byte's time later");
    let received: Vec<u32> = (0..16).map(|_| usart.read(0x24, 0, &mut out).unwrap()).collect();
    assert_eq!(received, (0..16).collect::<Vec<_>>());
    assert_eq!(out.last(), Some(&Signal::Line(39, true)), "IDLE holds the line");
    usart.write(0x20, 3 << 3, u32::MAX, 0, &mut out).unwrap();
    assert_eq!(out.last(), Some(&Signal::Line(39, false)));
    assert_eq!(usart.read(0x1c, 0, &mut out).unwrap() & 1 << 5, 0);
}

#[test]
fn a_wrong_baud_rate_is_reported() {
    let mut usart = usart(1 << 3, 0);
    let mut out = Vec::new();
    usart.write(0x0c, 60, u32::MAX, 0, &mut out).unwrap();
    usart.write(0x28, 1, u32::MAX, 0, &mut out).unwrap();
    assert_eq!(usart.complaint.as_deref(), Some("the USART runs at 2000000 baud, the host at 3000000"));
}

/// Receiving with DMA: a request a byte, withdrawn when somebody else takes it.
#[test]
fn a_usart_asks_dma_for_each_byte_that_waits() {
    let (rdr, request) = (0x24, Signal::Request(45));
    let mut usart = usart(1 << 29 | 1 << 2, 1 << 6);
    usart.host_sends(&[1, 2], 0);
    let mut out = Vec::new();
    usart.advance(2 * 10 * 320, &mut out);
    assert_eq!(out.iter().filter(|signal| **signal == request).count(), 1, "{out:?}");
    for (byte, asks) in [(1, 1), (2, 0)] {
        out.clear();
        assert_eq!(usart.read(rdr, 2 * 10 * 320, &mut out), Some(byte));
        assert_eq!(out.iter().filter(|signal| **signal == request).count(), asks, "{out:?}");
    }
}

#[test]
fn an_adc_shows_what_was_there_at_the_end_of_sampling_and_wants_its_calibration() {
    const CYCLE: Time = 60;
    let [cr, cfgr, smpr, pcsel, sqr, dr, jsqr, jdr, ccr] = [0x08, 0x0c, 0x14, 0x1c, 0x30, 0x40, 0x4c, 0x80, 0x308];
    let mut clocks = h743::clocks::Clocks::RESET;
    // 64 MHz, by 2 and by 2: 16 MHz.
    clocks.adc = Some(15);
    let (regulator, calibration) = (10 * MICROSECOND, (165_010 + 1_280) * CYCLE);
    for calibrates in [true, false] {
        let mut adc = Adc::default();
        adc.clocks(&clocks, 0);
        let set = |adc: &mut Adc, offset: u32, value: u32, at: Time| {
            assert_eq!(adc.write(offset, value, u32::MAX, at, &mut Vec::new()), Some(()), "{offset:#x}");
        };
        let get = |adc: &mut Adc, offset: u32, at: Time| adc.read(offset, at, &mut Vec::new()).unwrap();
        set(&mut adc, ccr, 1 << 18, 0);
        set(&mut adc, cr, 1 << 28 | 2 << 8, 0);
        let mut now = regulator;
        if calibrates {
            set(&mut adc, cr, 1 << 31 | 1 << 28 | 1 << 16 | 2 << 8, now);
            assert_eq!(get(&mut adc, cr, now + calibration - 1) >> 31, 1);
            now += calibration;
            assert_eq!(get(&mut adc, cr, now) >> 31, 0);
        }
        for (offset, value) in
            [(cfgr, 1 << 31 | 1 << 25 | 1 << 13 | 1 << 12), (smpr, 0o55), (pcsel, 3), (sqr, 1 << 6), (jsqr, 0)]
        {
            set(&mut adc, offset, value, now);
        }
        set(&mut adc, cr, 1 << 28 | 2 << 8 | 1, now);
        now += 10 * MICROSECOND;
        assert_eq!(get(&mut adc, 0, now) & 1, 1);
        set(&mut adc, cr, 1 << 28 | 2 << 8 | 1 << 2, now);
        assert_eq!(adc.complaint.is_none(), calibrates, "{:?}", adc.complaint);
        // Sampling ends 64.5 cycles after the start, the conversion 8.5 later; the other channel's
        // takes as long.
        let (sampled, whole) = (now + CYCLE * 129 / 2, now + CYCLE * 73);
        adc.apply(1, 1.0, 0);
        adc.apply(1, 2.0, sampled + 1);
        assert_eq!(get(&mut adc, dr, whole - 1), 0);
        assert_eq!(get(&mut adc, dr, whole), 19_859);
        assert_eq!(get(&mut adc, dr, whole + 2 * CYCLE * 73 - 1), 19_859);
        assert_eq!(get(&mut adc, dr, whole + 2 * CYCLE * 73), 39_718);
        assert_eq!(get(&mut adc, jdr, whole + 2 * CYCLE * 73), 0);
    }
}

#[test]
fn a_watchdog_bites_when_it_is_not_fed() {
    let mut dog = Watchdog::default();
    let mut out = Vec::new();
    let mut key = |dog: &mut Watchdog, offset, value, at| dog.write(offset, value, u32::MAX, at, &mut out).unwrap();
    // Locked: nothing changes.
    key(&mut dog, 0x08, 1, 0);
    key(&mut dog, 0x00, 0xcccc, 0);
    assert_eq!(dog.next(), 4096 * 4 * LSI, "512 ms from reset's values");
    key(&mut dog, 0x00, 0x5555, 0);
    key(&mut dog, 0x08, 399, 0);
    key(&mut dog, 0x00, 0xaaaa, 10);
    assert_eq!(dog.next(), 10 + 50_000 * MICROSECOND);
    key(&mut dog, 0x00, 0xaaaa, 40_000 * MICROSECOND);
    assert_eq!(dog.next(), 90_000 * MICROSECOND);
    let mut reported = Vec::new();
    dog.advance(90_000 * MICROSECOND - 1, &mut reported);
    assert_eq!(reported, []);
    dog.advance(90_000 * MICROSECOND, &mut reported);
    assert_eq!(reported, [Signal::Reset(Cause::Watchdog)]);
}
