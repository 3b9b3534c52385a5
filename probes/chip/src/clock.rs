//! The clock that counts: a timer of the emulated board, which in QEMU advances with the
//! instructions.
//!
//! In: the board. Out: periods of 40 ns (25 MHz) between two readings. Owns TIMER1 (a CMSDK timer;
//! Arm DDI 0479, 4.4). Cannot fail. It has 32 bits, so 172 s pass before it turns over: SysTick,
//! with 24 bits, turned over within one batch of lines, and a count of them came out too small
//! without a word.

/// TIMER1 of the MPS2 boards.
const TIMER: usize = 0x4000_1000;
const CTRL: *mut u32 = TIMER as *mut u32;
const VALUE: *mut u32 = (TIMER + 4) as *mut u32;
const RELOAD: *mut u32 = (TIMER + 8) as *mut u32;
/// CTRL: on, without an interrupt.
const ON: u32 = 1;

/// A reading.
#[derive(Clone, Copy)]
pub struct Reading(u32);

/// Lets the clock run. Once, before anything is counted.
pub fn start() {
    // SAFETY: registers of a timer that nothing else uses.
    unsafe {
        RELOAD.write_volatile(u32::MAX);
        VALUE.write_volatile(u32::MAX);
        CTRL.write_volatile(ON);
    }
}

#[inline(always)]
fn value() -> u32 {
    // SAFETY: reading it changes nothing.
    unsafe { VALUE.read_volatile() }
}

/// The clock now.
#[inline(always)]
#[must_use]
pub fn read() -> Reading {
    Reading(value())
}

impl Reading {
    /// Periods since this reading. The counter counts down.
    #[inline(always)]
    #[must_use]
    pub fn passed(self) -> u32 {
        self.0.wrapping_sub(value())
    }
}
