//! Encoders: what TIM3 and TIM4 count and latch, through jumpers 10 to 12.
//!
//! In: the lines A, B and index of both, driven by outputs. Out: lines `encoder TIMER ENDS FORWARD
//! BACK`, and `index TIMER STANDING BEFORE AFTER BACK-BEFORE BACK-AFTER`. Owns the outputs PG0, PG1
//! and PG3, and the counters before ticks begin. Fails: an index that is not latched is
//! [`NOT_LATCHED`].
use crate::report::Report;
use hal::stm32h743::boards::BOARD;
use stm32_metapac::gpio::vals::{Idr, Ospeedr};
use stm32_metapac::timer::TimGp16;
use stm32_metapac::{GPIOG, TIM3, TIM4};

/// Outputs that drive A, B and the index. One port, so that one write changes all.
const DRIVERS: [usize; 3] = [0, 1, 3];
const A: u32 = 1 << DRIVERS[0];
const B: u32 = 1 << DRIVERS[1];
const INDEX: u32 = 1 << DRIVERS[2];
const ALL: u32 = A | B | INDEX;
/// Lines of an encoder that are counted, to and fro.
const LINES: u32 = 10;
/// The levels of A and B in a line, forwards.
const FORWARD: [u32; 4] = [A, A | B, B, 0];
/// What is reported where nothing was latched.
const NOT_LATCHED: i64 = 9999;

/// Each counter, the channel of its index, and its ends: A, B, index.
const COUNTERS: [(i64, TimGp16, usize, [End; 3]); 2] = [
    (3, TIM3, 3, [BOARD.encoders[0].0, BOARD.encoders[1].0, BOARD.indexes[0].0]),
    (4, TIM4, 2, [BOARD.encoders[2].0, BOARD.encoders[3].0, BOARD.indexes[1].0]),
];

type End = hal::stm32h743::wiring::Pin;

/// Levels of the three lines.
fn put(high: u32) {
    GPIOG.bsrr().write(|w| w.0 = high | (ALL & !high) << 16);
}

fn settle() {
    // A filter of 33 ns, and a pull of 40 kOhm where there is no jumper.
    cortex_m::asm::delay(2_400);
}

fn reads_high((port, pin): End) -> bool {
    port.idr().read().idr(pin) == Idr::HIGH
}

/// The count of a counter.
fn count(timer: TimGp16) -> u16 {
    timer.cnt().read().cnt()
}

/// From a count to another, at most half of all.
fn distance(from: u16, to: u16) -> i64 {
    i64::from(to.wrapping_sub(from) as i16)
}

/// Which ends follow the outputs, a bit each.
fn following(ends: &[End; 3]) -> i64 {
    let mut follow = 0b111;
    for high in [0, ALL, 0] {
        put(high);
        settle();
        for (n, end) in ends.iter().enumerate() {
            follow &= !(i64::from(reads_high(*end) != (high != 0)) << n);
        }
    }
    follow
}

/// What is latched by an index that comes alone, from the count before it.
fn latched(timer: TimGp16, channel: usize, from: u16) -> i64 {
    settle();
    let is_new = timer.sr().read().ccif(channel);
    // Reading it takes the flag away.
    let at = timer.ccr(channel).read().ccr();
    if is_new { distance(from, at) } else { NOT_LATCHED }
}

/// The index comes before an edge of A, or after it, by more than a sample of a filter (4.2 ns) and
/// less than its delay (33 ns). The 10 to 30 ns that the instructions and the bus should take are a
/// guess, and the row on the page says so.
#[inline(never)]
fn index_beside(timer: TimGp16, channel: usize, [first, second]: [u32; 2]) -> i64 {
    let from = count(timer);
    timer.ccr(channel).read();
    // Both in a register before the first write.
    let words = [first, second].map(|high| high | (ALL & !high) << 16);
    GPIOG.bsrr().write(|w| w.0 = words[0]);
    // The bus adds some of its own.
    (0..6).for_each(|_| cortex_m::asm::nop());
    GPIOG.bsrr().write(|w| w.0 = words[1]);
    latched(timer, channel, from)
}

/// What each counter says.
pub fn report_to(report: &mut Report) {
    DRIVERS.iter().for_each(|pin| GPIOG.ospeedr().modify(|w| w.set_ospeedr(*pin, Ospeedr::HIGH_SPEED)));
    for (number, timer, channel, ends) in COUNTERS {
        let follow = following(&ends);
        put(0);
        settle();
        let turn = |levels: &[u32]| {
            let from = count(timer);
            for _ in 0..LINES {
                for high in levels {
                    put(*high);
                    settle();
                }
            }
            distance(from, count(timer))
        };
        let forward = turn(&FORWARD);
        let back = turn(&[B, A | B, A, 0]);
        report.line("encoder", &[number, follow, forward, back]);

        timer.ccr(channel).read();
        let from = count(timer);
        put(INDEX);
        let standing = latched(timer, channel, from);
        put(0);
        settle();
        let before = index_beside(timer, channel, [INDEX, INDEX | A]);
        put(A);
        settle();
        // Back over the same edge.
        let back_before = index_beside(timer, channel, [A | INDEX, INDEX]);
        put(0);
        settle();
        let after = index_beside(timer, channel, [A, A | INDEX]);
        put(A);
        settle();
        let back_after = index_beside(timer, channel, [0, INDEX]);
        put(0);
        settle();
        report.line("index", &[number, standing, before, after, back_before, back_after]);
    }
    DRIVERS.iter().for_each(|pin| GPIOG.ospeedr().modify(|w| w.set_ospeedr(*pin, Ospeedr::LOW_SPEED)));
}
