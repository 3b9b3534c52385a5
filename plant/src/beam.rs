//! The output stage of a laser channel.
use crate::pulses::Burst;

/// What an output did. Instants are ns of controller time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The switch output went to this level; true is active.
    Switch {
        /// When.
        at: u64,
        /// To what.
        level: bool,
    },
    /// The energy output went to this level: one edge of a pulse that was cut, or is not over.
    Energy {
        /// When.
        at: u64,
        /// To what.
        level: bool,
    },
    /// Whole pulses of the energy output.
    Pulses(Burst),
    /// The analog output went to this voltage.
    Dac {
        /// When.
        at: u64,
        /// To what.
        microvolts: i32,
    },
}
