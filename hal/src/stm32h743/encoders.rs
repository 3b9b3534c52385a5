//! Encoders of the first axes: TIM3 and TIM4 count their edges and latch the count at their index
//! (RM0433 39.3.19, 39.3.5).
//!
//! In: lines A, B and Z. Out: counts of 64 bits, four a line of the encoder, and the count at the
//! last rising edge of Z. Owns TIM3 and TIM4. Their 16 bits are extended at each reading: the limit
//! of 32767 counts between two readings, 130 MHz at 250 µs, is beyond what the inputs pass (30
//! MHz). Fails never; a line that is not connected counts nothing.
use super::settings::ENCODERS;
use stm32_metapac::timer::TimGp16;
use stm32_metapac::timer::vals::{CcmrInputCcs, FilterValue, Sms};
use stm32_metapac::{RCC, TIM3, TIM4};

/// Encoders that the timers allow: TIM1, TIM8 and TIM15 make light, TIM2 the ticks. The inputs of
/// TIM5 lie on pins of the Nucleo's Ethernet PHY, and of the module's lasers.
pub const ENCODERS_MAX: usize = 2;

const TIMERS: [TimGp16; ENCODERS_MAX] = [TIM3, TIM4];

/// The channel, from 0, at whose input each index is: TIM3_CH4, TIM4_CH3.
const INDEX_CHANNELS: [usize; ENCODERS_MAX] = [3, 2];

/// Axes that have one, a bit each.
pub const FITTED: u64 = {
    let [first, second] = ENCODERS;
    first as u64 | (second as u64) << 1
};

/// The counters.
#[derive(Debug)]
pub struct Encoders {
    /// Counts of the timers at the last reading.
    last: [u16; ENCODERS_MAX],
    counts: [i64; ENCODERS_MAX],
    /// Counts at the index edges since the last reading but one.
    indexes: [Option<i64>; ENCODERS_MAX],
}

impl Encoders {
    /// Nothing has been counted.
    pub const AT_ZERO: Encoders =
        Encoders { last: [0; ENCODERS_MAX], counts: [0; ENCODERS_MAX], indexes: [None; ENCODERS_MAX] };

    /// Reads the counters, once a tick.
    pub fn read(&mut self) {
        let axes = self.last.iter_mut().zip(&mut self.counts).zip(&mut self.indexes);
        for ((timer, channel), ((last, count), index)) in TIMERS.iter().zip(INDEX_CHANNELS).zip(axes) {
            let now = timer.cnt().read().cnt();
            // The shorter of the two distances modulo 2¹⁶: the count has wrapped at most once.
            let distance = |to: u16, from: u16| i64::from(to.wrapping_sub(from) as i16);
            *count = count.wrapping_add(distance(now, *last));
            *last = now;
            // Reading the latched count clears its flag (RM0433 39.4.5).
            let latched = timer.sr().read().ccif(channel).then(|| timer.ccr(channel).read().ccr());
            *index = latched.map(|latched| count.wrapping_add(distance(latched, now)));
        }
    }

    /// Counts of an axis since power-on; `None` without an encoder.
    pub fn count(&self, axis: usize) -> Option<i64> {
        ENCODERS.get(axis).filter(|fitted| **fitted)?;
        self.counts.get(axis).copied()
    }

    /// The count at the last index edge of an axis between the last two readings.
    pub fn index(&self, axis: usize) -> Option<i64> {
        ENCODERS.get(axis).filter(|fitted| **fitted)?;
        self.indexes.get(axis).copied()?
    }
}

/// Starts the counters.
///
/// # Safety
/// Once, before anything else uses the timers.
pub unsafe fn open() {
    RCC.apb1lenr().modify(|w| {
        w.set_tim3en(true);
        w.set_tim4en(true);
    });
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.apb1lenr().read();
    for (timer, index) in TIMERS.into_iter().zip(INDEX_CHANNELS) {
        // Each input to its own channel, filtered over eight samples, 33 ns: all three have the
        // same delay.
        timer.ccmr_input(0).write(|w| {
            for input in 0..2 {
                w.set_ccs(input, CcmrInputCcs::TI4);
                w.set_icf(input, FilterValue::FCK_INT_N8);
            }
        });
        timer.ccmr_input(index / 2).write(|w| {
            w.set_ccs(index % 2, CcmrInputCcs::TI4);
            w.set_icf(index % 2, FilterValue::FCK_INT_N8);
        });
        // Rising edges.
        timer.ccer().write(|w| w.set_cce(index, true));
        timer.smcr().write(|w| w.set_sms(Sms::ENCODER_MODE_3));
        timer.arr().write(|w| w.set_arr(u16::MAX));
        timer.cr1().write(|w| w.set_cen(true));
    }
}
