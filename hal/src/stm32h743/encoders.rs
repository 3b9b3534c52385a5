//! Encoders of the first axes: TIM3 and TIM4 count their edges (RM0433 39.3.19).
//!
//! In: lines A and B. Out: counts of 64 bits, four a line of the encoder. Owns TIM3 and TIM4, whose 16 bits are extended at each reading: 32767
//! counts between two, 130 MHz at 250 µs, are beyond what the inputs let through (30 MHz). Fails never; a line that is not
//! there counts nothing.
use super::settings::ENCODERS;
use stm32_metapac::timer::TimGp16;
use stm32_metapac::timer::vals::{CcmrInputCcs, FilterValue, Sms};
use stm32_metapac::{RCC, TIM3, TIM4};

/// Encoders that the timers allow: TIM1, TIM8 and TIM15 make light, TIM2 the ticks, and the inputs of TIM5 lie on pins of the
/// Ethernet PHY.
pub const MOST: usize = 2;

const TIMERS: [TimGp16; MOST] = [TIM3, TIM4];

/// The counters.
#[derive(Debug)]
pub struct Encoders {
    /// What the timers showed last.
    seen: [u16; MOST],
    counts: [i64; MOST],
}

impl Encoders {
    /// Nothing has been counted.
    pub const AT_ZERO: Encoders = Encoders { seen: [0; MOST], counts: [0; MOST] };

    /// Looks at the counters, once a tick.
    pub fn read(&mut self) {
        for ((timer, seen), count) in TIMERS.iter().zip(&mut self.seen).zip(&mut self.counts) {
            let now = timer.cnt().read().cnt();
            // The shorter way round: 16 bits have turned over at most once.
            let way = now.wrapping_sub(*seen) as i16;
            *seen = now;
            *count = count.wrapping_add(way.into());
        }
    }

    /// Counts of an axis since power-on; `None` without an encoder.
    pub fn count(&self, axis: usize) -> Option<i64> {
        ENCODERS.get(axis).filter(|fitted| **fitted)?;
        self.counts.get(axis).copied()
    }
}

/// Lets the timers count.
///
/// # Safety
/// Once, before anybody else uses them.
pub unsafe fn open() {
    RCC.apb1lenr().modify(|w| {
        w.set_tim3en(true);
        w.set_tim4en(true);
    });
    // Read back, so that the clock is there (RM0433 8.5.8).
    RCC.apb1lenr().read();
    for timer in TIMERS {
        timer.ccmr_input(0).write(|w| {
            for input in 0..2 {
                // TI1 and TI2, each to its own channel; a level holds for eight samples, 33 ns.
                w.set_ccs(input, CcmrInputCcs::TI4);
                w.set_icf(input, FilterValue::FCK_INT_N8);
            }
        });
        timer.smcr().write(|w| w.set_sms(Sms::ENCODER_MODE_3));
        timer.arr().write(|w| w.set_arr(u16::MAX));
        timer.cr1().write(|w| w.set_cen(true));
    }
}
