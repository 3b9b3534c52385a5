//! Guards of the core's MPU: what outgrows the stack faults at once instead of writing where nothing or something else is, and on
//! boards that call for it so do null and writes to code; memory that others of the bus use is kept out of the cache.
//!
//! In: addresses. Out: a fault of the core where something is forbidden. Owns the regions
//! of the MPU (Armv7-M Architecture Reference Manual, B3.5), each a function's own; everything else keeps the default map.
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

/// What is guarded: no frame is larger.
pub const SPAN: u32 = 1 << 20;

/// RASR: a region of 2^`bits` bytes, on.
const fn on(bits: u32) -> u32 {
    1 | (bits - 1) << 1
}
/// No access for anybody, nothing executed.
const NO_ACCESS: u32 = 1 << 28;
/// Normal memory, not cached, shared (TEX 001, C 0, B 0, S 1), all may read and write, nothing is executed.
const UNCACHED: u32 = 1 << 18 | 1 << 19 | 3 << 24 | 1 << 28;
/// Normal memory (TEX 001, C 0, B 0), all may read and execute, nobody may write.
const CODE: u32 = 1 << 19 | 6 << 24;
/// CTRL: on, the default map for what no region covers.
const ON: u32 = 1 | 1 << 2;

/// Nobody may touch the [`SPAN`] below `stack` any more, which is a multiple of it, but for the eighths whose bit is set in
/// `without`, lowest first.
pub fn below(mpu: &mut MPU, stack: u32, without: u8) {
    let eighths = (without as u32) << 8;
    // SAFETY: nothing of the program lies there; the region only takes rights away.
    unsafe { set(mpu, 0, stack.wrapping_sub(SPAN), on(SPAN.ilog2()) | eighths | NO_ACCESS) };
}

/// Nobody may touch the first 512 bytes any more: null.
pub fn null(mpu: &mut MPU) {
    // SAFETY: as above.
    unsafe { set(mpu, 1, 0, on(9) | NO_ACCESS) };
}

/// What other masters of the bus read and write: the 2^`bits` bytes from `base` on, a multiple of that, without the eighths whose
/// bit is set in `without`. Before the board's caches are on.
pub fn uncached(mpu: &mut MPU, base: u32, bits: u32, without: u8) {
    // SAFETY: every program that runs without a cache runs with one left out.
    unsafe { set(mpu, 2, base, on(bits) | (without as u32) << 8 | UNCACHED) };
}

/// Nobody may write the 2^`bits` bytes from `base` on, a multiple of that: code that start-up has put there. `part` 0 or 1:
/// code whose length is no power of two has two parts.
pub fn code(mpu: &mut MPU, part: u32, base: u32, bits: u32) {
    let region = if part == 0 { 3 } else { 6 };
    // SAFETY: the program writes nothing there any more.
    unsafe { set(mpu, region, base, on(bits) | CODE) };
}

/// Nobody may touch memory outside the chip, nor may the core read there ahead, where the default map has normal memory: a board with none.
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
