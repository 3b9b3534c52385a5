//! The guard below the stack: what outgrows the stack faults at once instead of writing where nothing or something
//! else is.
//!
//! In: the lowest address of the stack. Out: a fault of the core on any access to the mebibyte below. Owns region 0 of
//! the MPU (Armv7-M Architecture Reference Manual, B3.5); everything else keeps the default map.
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

/// What is guarded: no frame is larger.
pub const SPAN: u32 = 1 << 20;

/// RASR: region on, its size 2^(19 + 1), no access for anybody, nothing executed.
const NO_ACCESS: u32 = 1 | 19 << 1 | 1 << 28;
/// CTRL: on, the default map for what no region covers.
const ON: u32 = 1 | 1 << 2;

/// Nobody may touch the [`SPAN`] below `stack` any more, which is a multiple of it.
pub fn below(mpu: &mut MPU, stack: u32) {
    // SAFETY: nothing of the program lies there; the region only takes rights away.
    unsafe {
        mpu.rnr.write(0);
        mpu.rbar.write(stack.wrapping_sub(SPAN));
        mpu.rasr.write(NO_ACCESS);
        mpu.ctrl.write(ON);
    }
    dsb();
    isb();
}
