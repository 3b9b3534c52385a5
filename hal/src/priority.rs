//! The interrupt priorities, in one table. Smaller is more urgent; every Cortex-M7 used here
//! implements the top three bits.

/// The servo tick. Nothing masks it: [`CRITICAL`] lies below.
pub const TICK: u8 = 0x20;

/// What a critical section keeps out: this and everything less urgent.
pub const CRITICAL: u8 = 0x40;

/// Bytes of the host link and of the trace.
pub const LINK: u8 = 0x80;

/// PendSV, the wake signal from the tick down to the thread.
pub const WAKE: u8 = 0xe0;

const _: () = assert!(TICK != 0 && TICK < CRITICAL && CRITICAL <= LINK && LINK < WAKE);
