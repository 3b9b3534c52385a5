//! Guards by the core's MPU: a stack overflow faults at once, instead of writing to other memory.
//!
//! Boards may also guard null, code against writes, and memory outside the chip. Memory that other
//! masters of the bus use is kept out of the cache.
//!
//! In: addresses. Out: a fault of the core at a forbidden access. Owns the regions of the MPU
//! (Armv7-M Architecture Reference Manual, B3.5), one or two a function; everything else keeps the
//! default map. Fails never.
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

/// Bytes that are guarded below the stack: no frame is larger.
pub const SPAN_BYTES: u32 = 1 << 20;

/// RASR: a region of 2^`bits` bytes, on.
const fn on(bits: u32) -> u32 {
    1 | (bits - 1) << 1
}
/// No access at all, nothing is executed.
const NO_ACCESS: u32 = 1 << 28;
/// Normal memory, not cached, shared (TEX 001, C 0, B 0, S 1); reads and writes, nothing executed.
const UNCACHED: u32 = 1 << 18 | 1 << 19 | 3 << 24 | 1 << 28;
/// Normal memory (TEX 001, C 0, B 0): reads and execution, no writes.
const CODE: u32 = 1 << 19 | 6 << 24;
/// CTRL: on, the default map for what no region covers.
const ON: u32 = 1 | 1 << 2;

/// Forbids all access to the [`SPAN_BYTES`] below `stack`, which is a multiple of it. The eighths
/// whose bit is set in `without`, lowest first, stay as they are.
pub fn below(mpu: &mut MPU, stack: u32, without: u8) {
    let eighths = (without as u32) << 8;
    // SAFETY: nothing of the program lies there; the region only takes rights away.
    unsafe { set(mpu, 0, stack.wrapping_sub(SPAN_BYTES), on(SPAN_BYTES.ilog2()) | eighths | NO_ACCESS) };
}

/// Forbids all access to the first 512 bytes: null.
pub fn null(mpu: &mut MPU) {
    // SAFETY: as above.
    unsafe { set(mpu, 1, 0, on(9) | NO_ACCESS) };
}

/// Keeps 2^`bits` bytes from `base` on, a multiple of that, out of the cache: other masters of the
/// bus read and write them. The eighths whose bit is set in `without` stay as they are. Call it
/// before the board's caches are on.
pub fn uncached(mpu: &mut MPU, base: u32, bits: u32, without: u8) {
    // SAFETY: every program that runs without a cache runs with one left out.
    unsafe { set(mpu, 2, base, on(bits) | (without as u32) << 8 | UNCACHED) };
}

/// Forbids writes to the 2^`bits` bytes from `base` on, a multiple of that: code that start-up has
/// copied there. `part` is 0 or 1: code whose length is no power of two has two parts.
pub fn code(mpu: &mut MPU, part: u32, base: u32, bits: u32) {
    let region = if part == 0 { 3 } else { 6 };
    // SAFETY: the program writes nothing there any more.
    unsafe { set(mpu, region, base, on(bits) | CODE) };
}

/// Forbids all access to memory outside the chip, for a board with none. The default map has normal
/// memory there, which the core may read speculatively.
pub fn outside(mpu: &mut MPU) {
    for (region, base) in [(4, 0x6000_0000), (5, 0x8000_0000)] {
        // SAFETY: nothing is there; the region only takes rights away.
        unsafe { set(mpu, region, base, on(29) | NO_ACCESS) };
    }
}

/// # Safety
/// The program runs on with the region as it is then.
unsafe fn set(mpu: &mut MPU, region: u32, base: u32, attributes: u32) {
    // SAFETY: the caller's promise; what no region covers is as without an MPU.
    unsafe {
        mpu.rnr.write(region);
        mpu.rbar.write(base);
        mpu.rasr.write(attributes);
        mpu.ctrl.write(ON);
    }
    dsb();
    isb();
}
