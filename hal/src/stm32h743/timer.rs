//! TIM2 makes the servo tick (RM0433 39): 32 bits at 240 MHz. It reloads by itself, so that ticks
//! are evenly spaced, however late one of them is served.
//!
//! In: a tick period. Out: an interrupt a period, and whether the tick took longer. Owns TIM2.
//! Fails never.
use super::clocks::TIMER_MHZ;
use stm32_metapac::timer::vals::{Mms, Urs};
use stm32_metapac::{RCC, TIM2};

/// Nanoseconds of a count of TIM2, times 2¹⁶.
const NS_PER_COUNT_Q16: u64 = (1000 << 16) / TIMER_MHZ as u64;

/// TIM2, which makes the servo tick. It is stopped until [`start`].
#[derive(Debug)]
pub struct TickTimer {
    period_ns: u32,
}

impl TickTimer {
    /// Takes the timer.
    ///
    /// # Safety
    /// At most one may exist.
    pub unsafe fn take() -> Self {
        RCC.apb1lenr().modify(|w| w.set_tim2en(true));
        // Read back, so that the clock is there (RM0433 8.5.8).
        RCC.apb1lenr().read();
        TIM2.psc().write_value(0);
        // The timers of the lasers start with a tick.
        TIM2.cr2().write(|w| w.set_mms(Mms::UPDATE));
        // Only an overflow interrupts.
        TIM2.cr1().write(|w| w.set_urs(Urs::COUNTER_ONLY));
        TIM2.dier().write(|w| w.set_uie(true));
        TickTimer { period_ns: 0 }
    }

    /// Sets the period (whole µs) of the tick that has just begun and of all after it. The running
    /// period changes nothing.
    pub fn run_at(&mut self, period_ns: u32) {
        if period_ns == self.period_ns {
            return;
        }
        self.period_ns = period_ns;
        let last = (period_ns / 1000).max(1) * u32::from(TIMER_MHZ) - 1;
        // Not preloaded: it counts for the interval in progress.
        TIM2.arr().write_value(last);
        if TIM2.cnt().read() > last {
            // The interval is over already: the next tick is due.
            TIM2.cnt().write_value(last);
        }
    }

    /// Acknowledges the tick that begins.
    pub fn begin(&mut self) {
        // Zeros clear, ones leave (RM0433 39.4.5); a write is enough, nothing is read back.
        TIM2.sr().write(|w| {
            w.0 = !0;
            w.set_uif(false);
        });
        cortex_m::asm::dsb();
    }

    /// Whether the next tick is due already, and how long ago the one in progress was due, in ns.
    /// The time begins at the timer's event, so it includes the entry into the handler. In a tick
    /// that has overrun, it is a period and what the tick has taken of the next one.
    pub fn taken(&self) -> (bool, Option<u32>) {
        // The flag first: a wrap between the two reads makes the time too short, never a period too
        // long.
        let overran = TIM2.sr().read().uif();
        let read = TIM2.cnt().read();
        // 240 counts a µs: 25/6 ns each, by a multiplication. Counts of two periods of 1 ms at
        // most.
        let ns = ((u64::from(read) * NS_PER_COUNT_Q16) >> 16) as u32;
        (overran, Some(ns + if overran { self.period_ns } else { 0 }))
    }
}

/// The first tick interval begins; its period has been set.
pub fn start() {
    TIM2.egr().write(|w| w.set_ug(true));
    TIM2.cr1().modify(|w| w.set_cen(true));
}

/// No more ticks.
pub fn stop() {
    TIM2.dier().write(|_| {});
    TIM2.cr1().write(|_| {});
}
