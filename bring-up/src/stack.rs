//! How much stack the run has taken so far.
//!
//! Start-up writes zeros to all memory, so what no frame has reached is zero still. In: the memory
//! STACK. Out: a line. Owns nothing. A frame whose lowest words are zero counts as smaller.
use crate::report::Report;

unsafe extern "C" {
    /// The lowest word of the stack (linker script).
    static _stack_end: u32;
    /// The address after its highest word.
    static _stack_start: u32;
}

/// Bytes of the stack, and bytes used.
pub fn report_to(report: &mut Report) {
    let (lowest, end) = (&raw const _stack_end as usize, &raw const _stack_start as usize);
    // SAFETY: words of the stack's memory, below every frame that is in use as far as they are
    // zero.
    let untouched = (lowest..end).step_by(4).take_while(|at| unsafe { (*at as *const u32).read_volatile() } == 0);
    let reserve = 4 * untouched.count();
    report.line("stack", &[(end - lowest) as i64, (end - lowest - reserve) as i64]);
}
