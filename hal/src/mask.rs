//! The one critical section of the image, by BASEPRI.
//!
//! `cortex-m`'s stock implementation masks everything through PRIMASK and would stop the servo
//! tick. This one keeps out only interrupts as urgent as [`CRITICAL`] or less. The tick stays above
//! it, and in return may use nothing that takes a critical section (wakers, defmt, mutexes).
//!
//! Arm's erratum 837070 (a BASEPRI write that raises the priority may take effect late) concerns
//! Cortex-M7 r0p1 only (Arm Cortex-M7 AT610/AT611 errata notice). QEMU has no such delay and the
//! STM32H743 has an r1p1 core; a board with r0p1 would need the write between CPSID and CPSIE.
use crate::priority::CRITICAL;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::register::{basepri, basepri_max};
use critical_section::RawRestoreState;

struct Mask;
critical_section::set_impl!(Mask);

// SAFETY: one core; after `acquire` no context that takes critical sections can run until
// `release`, since all of them (thread, wake signal, link) are no more urgent than `CRITICAL`.
unsafe impl critical_section::Impl for Mask {
    unsafe fn acquire() -> RawRestoreState {
        let before = basepri::read();
        // BASEPRI_MAX never lowers the mask, so sections nest.
        basepri_max::write(CRITICAL);
        // The mask holds before the first access of the section, to the compiler and to the core.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        compiler_fence(Ordering::SeqCst);
        u32::from(before)
    }

    unsafe fn release(before: RawRestoreState) {
        compiler_fence(Ordering::SeqCst);
        // SAFETY: restores the mask that `acquire` of the same section found.
        unsafe { basepri::write(before as u8) };
    }
}
