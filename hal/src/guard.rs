//! The guard below the stack: what outgrows the stack faults at once instead of writing where nothing or something
//! else is.
//!
//! In: the lowest address of the stack. Out: a fault of the core on any access to the mebibyte below. Owns the regions
//! of the MPU (Armv7-M Architecture Reference Manual, B3.5): the first ones, and one that a cache must not hold where a board
//! has DMA; everything else keeps the default map.
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

/// What is guarded: no frame is larger.
pub const SPAN: u32 = 1 << 20;

/// RASR: region on, of 2^`bits` bytes, no access for anybody, nothing executed.
const fn no_access(bits: u32) -> u32 {
    1 | (bits - 1) << 1 | 1 << 28
}
/// RASR: region on, of 2^`bits` bytes without the eighths of `without`; normal memory, not cached, shared (TEX 001, C 0, B 0, S 1),
/// all may read and write, nothing is executed.
const fn uncached_access(bits: u32, without: u8) -> u32 {
    1 | (bits - 1) << 1 | (without as u32) << 8 | 1 << 18 | 1 << 19 | 3 << 24 | 1 << 28
}
/// CTRL: on, the default map for what no region covers.
const ON: u32 = 1 | 1 << 2;

/// Nobody may touch the [`SPAN`] below `stack` any more, which is a multiple of it.
pub fn below(mpu: &mut MPU, stack: u32) {
    forbid(mpu, &[(stack.wrapping_sub(SPAN), SPAN.ilog2())]);
}

/// Nobody may touch the first KiB any more, nor the [`SPAN`] below it, where addresses turn over: null, and a stack that
/// begins behind that KiB.
pub fn null(mpu: &mut MPU) {
    forbid(mpu, &[(0, 10), (0u32.wrapping_sub(SPAN), SPAN.ilog2())]);
}

/// What other masters of the bus read and write: the 2^`bits` bytes from `base` on, a multiple of that, without the eighths whose
/// bit is set in `without`. For a board with [`null`], before its caches are on.
pub fn uncached(mpu: &mut MPU, base: u32, bits: u32, without: u8) {
    // SAFETY: every program that runs without a cache runs with one left out; the regions before it stay.
    unsafe {
        mpu.rnr.write(2);
        mpu.rbar.write(base);
        mpu.rasr.write(uncached_access(bits, without));
    }
    dsb();
    isb();
}

/// Nobody may touch these spans of 2^n bytes, n at least 5, at multiples of their size.
fn forbid(mpu: &mut MPU, spans: &[(u32, u32)]) {
    for (region, &(base, bits)) in (0..).zip(spans) {
        // SAFETY: nothing of the program lies there; the region only takes rights away.
        unsafe {
            mpu.rnr.write(region);
            mpu.rbar.write(base);
            mpu.rasr.write(no_access(bits));
        }
    }
    // SAFETY: as above; what no region covers is as without an MPU.
    unsafe { mpu.ctrl.write(ON) };
    dsb();
    isb();
}
