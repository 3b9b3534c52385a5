//! A stack for start-up, whose frames are larger than the stack of the running program.
//!
//! In: a function, and the end of a memory that nothing uses yet. Out: the function has run with
//! its stack in that memory. Owns nothing. Fails never.

/// Runs `body` with `context` on the stack that ends at `top`.
///
/// # Safety
/// `top` is a multiple of 8. Nothing else uses the memory below it, as far down as `body` needs it.
#[unsafe(naked)]
pub unsafe extern "C" fn run_on(context: *mut (), body: extern "C" fn(*mut ()), top: usize) {
    core::arch::naked_asm!("push {{r4, lr}}", "mov r4, sp", "mov sp, r2", "blx r1", "mov sp, r4", "pop {{r4, pc}}")
}
