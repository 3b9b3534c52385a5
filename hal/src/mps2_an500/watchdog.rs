//! CMSDK APB watchdog (Arm DDI 0479, "APB watchdog"): a 32-bit down counter at the system clock,
//! whose end is the NMI.
//!
//! In: feeding. Out: the NMI when it was not fed for [`SPAN_MS`]. Owns the watchdog's registers.
//! Fails never.
//!
//! Its second end in a row could reset the board by hardware. That is off here: when the host wakes
//! a sleeping emulator late, the emulated clock jumps by more than any time that one would allow,
//! before the core runs an instruction. The handler of the NMI checks whether anything is stuck,
//! and restarts the board itself.
use core::ptr::write_volatile;

/// The NMI comes this long after the last feeding.
pub const SPAN_MS: u32 = 100;

const BASE: usize = 0x4000_8000;
const LOAD: usize = 0x0;
const CTRL: usize = 0x8;
/// Any write ends the interrupt and begins anew.
const CLEAR: usize = 0xc;
const LOCK: usize = 0xc00;
const UNLOCK: u32 = 0x1acc_e551;
const CTRL_INTERRUPT: u32 = 1 << 0;
const COUNTS: u32 = super::timer::CLOCK_HZ / 1000 * SPAN_MS;

/// Starts it; from now on it must be fed.
pub fn start() {
    write(LOCK, UNLOCK);
    write(LOAD, COUNTS);
    write(CTRL, CTRL_INTERRUPT);
    // Any other value locks it until the next feeding.
    feed();
}

/// The time counts from now.
pub fn feed() {
    write(LOCK, UNLOCK);
    write(CLEAR, 1);
    write(LOCK, 0);
}

fn write(register: usize, value: u32) {
    // SAFETY: a register of this board's watchdog, which only this module touches.
    unsafe { write_volatile((BASE + register) as *mut u32, value) };
}
