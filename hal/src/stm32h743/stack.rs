//! How much of the stack the run has never used.
//!
//! In: the region STACK, which start-up has painted. Out: its bytes, and those below everything
//! that was ever written. Owns nothing. It looks at each word that was not used, so only the thread
//! asks, and only on request. Fails never; a frame whose lowest words were not written counts as
//! smaller.

/// What start-up writes to each word of the stack: no address, and no number of a plan.
pub const PAINT: u32 = 0xc5a3_5ac3;

unsafe extern "C" {
    /// The lowest word of the stack (linker script).
    static _stack_end: u32;
    /// The address after its highest word.
    static _stack_start: u32;
}

/// Bytes of the stack, and how many of the lowest ones were never used since the start.
pub fn size_and_unused() -> (u32, u32) {
    let (lowest, end) = (&raw const _stack_end as usize, &raw const _stack_start as usize);
    // SAFETY: words of the stack's memory, below every frame that is in use as far as they are
    // painted.
    let untouched = (lowest..end).step_by(4).take_while(|at| unsafe { (*at as *const u32).read_volatile() } == PAINT);
    ((end - lowest) as u32, 4 * untouched.count() as u32)
}
