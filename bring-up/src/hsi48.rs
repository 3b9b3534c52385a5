//! HSI48 against the timers' clock, which comes from the board's source.
//!
//! In: nothing. Out: a line: cycles of HSI48, and the counts of 240 MHz that they took. Owns TIM17
//! from then on: no steps any more. MCO1 leads HSI48 to the timer inside of the chip (RM0433 8.5.8,
//! 41.5.22), so no pin and no jumper takes part. Fails: edges that do not come are a line of zeros.
use crate::pause;
use crate::report::Report;
use stm32_metapac::rcc::vals::{Mco1sel, Mcopre};
use stm32_metapac::timer::vals::CcmrInputCcs;
use stm32_metapac::{RCC, TIM17};

/// TISEL.TI1SEL: MCO1.
const MCO1: u8 = 3;
/// MCO1 gives HSI48 divided by so much; each eighth edge is captured.
const DIVIDER: u8 = 15;
const CAPTURED: u8 = 8;
/// Edges that are counted: 1 ms.
const EDGES: i64 = 400;
/// Longest wait for an edge, in cycles of the core: 600 counts would be right.
const PATIENCE: u32 = 1_000_000;

/// Counts of the timer at the next captured edge.
fn edge() -> Option<u16> {
    for _ in 0..PATIENCE / 8 {
        if TIM17.sr().read().ccif(0) {
            return Some(TIM17.ccr(0).read().ccr());
        }
    }
    None
}

/// See the module text.
pub fn report_to(report: &mut Report) {
    RCC.cr().modify(|w| w.set_hsi48on(true));
    // Its start takes some microseconds (data sheet).
    pause::cycles(48_000);
    RCC.cfgr().modify(|w| {
        w.set_mco1sel(Mco1sel::HSI48);
        w.set_mco1pre(Mcopre::from_bits(DIVIDER));
    });
    RCC.apb2rstr().modify(|w| w.set_tim17rst(true));
    RCC.apb2rstr().modify(|w| w.set_tim17rst(false));
    RCC.apb2enr().modify(|w| w.set_tim17en(true));
    RCC.apb2enr().read();
    TIM17.tisel().write(|w| w.set_tisel(0, MCO1));
    TIM17.ccmr_input(0).write(|w| {
        w.set_ccs(0, CcmrInputCcs::TI4);
        w.set_icpsc(0, 3);
    });
    TIM17.ccer().write(|w| w.set_cce(0, true));
    TIM17.cr1().write(|w| w.set_cen(true));
    // The first one may have waited.
    edge();
    let counts = (|| {
        let (mut last, mut counts) = (edge()?, 0);
        for _ in 0..EDGES {
            let next = edge()?;
            counts += i64::from(next.wrapping_sub(last));
            last = next;
        }
        Some(counts)
    })();
    let cycles = if counts.is_some() { EDGES * i64::from(DIVIDER) * i64::from(CAPTURED) } else { 0 };
    report.line("hsi48", &[cycles, counts.unwrap_or(0)]);
}
