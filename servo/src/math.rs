//! Arithmetic without a floating-point unit or a division instruction: wide products and
//! reciprocals, real numbers, sine.
//!
//! In: integers of a stated scale. Out: the same. Owns nothing. Fails never: each function states
//! its range.
pub mod float;
pub(crate) mod sine;
pub mod wide;
