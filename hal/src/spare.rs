//! A stack for start-up, which puts together more than the stack of the run holds.
//!
//! In: a function, and the end of a memory that nobody uses yet. Out: that it has run on it. Owns nothing.

/// Runs `body` with `context` on the stack that ends at `top`.
///
/// # Safety
/// Nothing else uses the memory below `top`, as far as `body` needs it, and `top` is a multiple of 8.
#[unsafe(naked)]
pub unsafe extern "C" fn run_on(context: *mut (), body: extern "C" fn(*mut ()), top: usize) {
    core::arch::naked_asm!("push {{r4, lr}}", "mov r4, sp", "mov sp, r2", "blx r1", "mov sp, r4", "pop {{r4, pc}}")
}
