//! CMSDK APB timer (Arm DDI 0479, "APB timer"): a 32-bit down counter at the system clock.
//!
//! In: a tick period. Out: an interrupt a period. Owns TIMER0. The counter reloads by itself, so
//! the ticks are evenly spaced however late one of them is served.
use core::ptr::{read_volatile, write_volatile};

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
}

impl TickTimer {
    /// Takes the timer; it stands still until the first [`TickTimer::run_at`].
    ///
    /// # Safety
    /// At most one may exist.
    pub const unsafe fn take() -> Self {
        TickTimer { period_ns: 0 }
    }

    /// Ticks come with this period from now on; at the running period nothing is touched. The period is
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

    /// Acknowledges the tick that began.
    pub fn acknowledge(&mut self) {
        write(INT, 1);
    }

    /// Another tick has begun since the last [`TickTimer::acknowledge`].
    pub fn is_due(&self) -> bool {
        // SAFETY: a register of this board's TIMER0; reading has no effect.
        unsafe { read_volatile((BASE + INT) as *const u32) & 1 == 1 }
    }
}

fn write(register: usize, value: u32) {
    // SAFETY: a register of this board's TIMER0, which only this module touches.
    unsafe { write_volatile((BASE + register) as *mut u32, value) };
}
