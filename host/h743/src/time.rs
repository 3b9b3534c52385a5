//! Emulated time: a count from power-on, fine enough that every clock of the board has a whole
//! number of it.

/// Time, or a duration: 960ths of a microsecond. 480 MHz is 2 of them a cycle, 240 MHz 4, 120 MHz
/// 8, 64 MHz 15, 32 kHz 30000.
pub type Time = u64;

/// A microsecond.
pub const MICROSECOND: Time = 960;

/// A millisecond.
pub const MILLISECOND: Time = 1000 * MICROSECOND;

/// Later than everything.
pub const NEVER: Time = Time::MAX;

/// Nanoseconds, rounded down.
pub fn nanoseconds(time: Time) -> u64 {
    (u128::from(time) * 1000 / u128::from(MICROSECOND)) as u64
}

/// The first instant at or after these nanoseconds.
pub fn from_nanoseconds(ns: u64) -> Time {
    (u128::from(ns) * u128::from(MICROSECOND)).div_ceil(1000) as Time
}
