//! Types of inputs and outputs as calls number them, and words of levels.

/// I/O types of the manuals (SPEC 3).
pub mod kind {
    pub const LIMIT_POSITIVE: i16 = 0;
    pub const LIMIT_NEGATIVE: i16 = 1;
    pub const ALARM: i16 = 2;
    pub const HOME: i16 = 3;
    pub const GPI: i16 = 4;
    pub const ARRIVE: i16 = 5;
    pub const ENABLE: i16 = 10;
    pub const CLEAR: i16 = 11;
    pub const GPO: i16 = 12;
}

/// An analog input counts 2⁻¹⁵ of this many volts.
pub const ANALOG_INPUT_VOLTS: f64 = 12.5;

/// Bits of a word of levels.
pub const WORD: usize = 32;
/// Words of a read or a call of levels: enough for every type of every product.
pub const WORDS: usize = 4;
