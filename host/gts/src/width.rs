//! The `long` of the C API: the platform's in `libgts`, 32 bits in `libgts32`.

#[cfg(not(feature = "long32"))]
pub use std::ffi::{c_long, c_ulong};

/// 32 bits, as on Windows.
#[cfg(feature = "long32")]
#[allow(non_camel_case_types)]
pub type c_long = i32;
/// 32 bits, as on Windows.
#[cfg(feature = "long32")]
#[allow(non_camel_case_types)]
pub type c_ulong = u32;

/// Its bits.
pub const BITS: u32 = c_long::BITS;
