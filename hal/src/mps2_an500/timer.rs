//! CMSDK APB timer (Arm DDI 0479, "APB timer"): a 32-bit down counter at the system clock.
//!
//! In: a tick period. Out: an interrupt a period, and whether the tick took longer. Owns TIMER0 and
//! SysTick. Fails never. TIMER0 reloads by itself, so the ticks are evenly spaced, however late one
//! of them is served.
//!
//! A tick has overrun if it took longer than its period, by the instructions that SysTick counts. A
//! next tick that is due at the end of one is no measure here: when the host wakes a sleeping core
//! late, the emulated clock jumps, and the ticks that were missed follow each other at once.
use core::ptr::write_volatile;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// System clock of the board in Hz (AN500; QEMU's `SYSCLK_FRQ`).
pub const CLOCK_HZ: u32 = 25_000_000;

const NS_PER_COUNT: u32 = 1_000_000_000 / CLOCK_HZ;
const BASE: usize = 0x4000_0000;
const CTRL: usize = 0x0;
const VALUE: usize = 0x4;
const RELOAD: usize = 0x8;
const INT: usize = 0xc;
const CTRL_ENABLE: u32 = 1 << 0;
const CTRL_INTERRUPT: u32 = 1 << 3;

/// TIMER0, which makes the servo tick.
#[derive(Debug)]
pub struct TickTimer {
    period_ns: u32,
    /// SysTick at the beginning of the tick.
    began: u32,
}

/// SysTick counts down from here: 0.67 s, longer than any tick.
const COUNTS_MASK: u32 = 0x00ff_ffff;

impl TickTimer {
    /// Takes the timers; TIMER0 is stopped until the first [`TickTimer::run_at`].
    ///
    /// # Safety
    /// At most one may exist.
    pub unsafe fn take(mut stopwatch: SYST) -> Self {
        stopwatch.set_clock_source(SystClkSource::Core);
        stopwatch.set_reload(COUNTS_MASK);
        stopwatch.clear_current();
        stopwatch.enable_counter();
        TickTimer { period_ns: 0, began: 0 }
    }

    /// Sets the tick period; the running period changes nothing. The period is
    /// rounded down to the timer's 40 ns; boards run whole microseconds, so nothing is lost.
    pub fn run_at(&mut self, period_ns: u32) {
        if period_ns == self.period_ns {
            return;
        }
        self.period_ns = period_ns;
        write(CTRL, 0);
        write(RELOAD, (period_ns / NS_PER_COUNT).max(2) - 1);
        write(VALUE, (period_ns / NS_PER_COUNT).max(2) - 1);
        write(INT, 1);
        write(CTRL, CTRL_ENABLE | CTRL_INTERRUPT);
    }

    /// Acknowledges the tick that begins.
    pub fn begin(&mut self) {
        self.began = SYST::get_current();
        write(INT, 1);
    }

    /// Whether the tick that began has taken longer than a period. Its duration is `None`: an
    /// emulator's time has no meaning for a client.
    pub fn taken(&self) -> (bool, Option<u32>) {
        let counts = self.began.wrapping_sub(SYST::get_current()) & COUNTS_MASK;
        (counts >= self.period_ns / NS_PER_COUNT, None)
    }
}

fn write(register: usize, value: u32) {
    // SAFETY: a register of this board's TIMER0, which only this module touches.
    unsafe { write_volatile((BASE + register) as *mut u32, value) };
}
