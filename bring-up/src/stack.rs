//! How much stack the run has taken so far.
//!
//! In: the painted stack ([`hal::board::stack`]). Out: a line. Owns nothing.
use crate::report::Report;
use hal::board::stack;

/// Bytes of the stack, and bytes used.
pub fn report_to(report: &mut Report) {
    let (size, unused) = stack::size_and_unused();
    report.line("stack", &[size.into(), (size - unused).into()]);
}
