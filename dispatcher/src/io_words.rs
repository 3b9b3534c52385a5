//! Words of levels.

/// Bits of a word of levels.
pub const WORD: usize = 32;
/// Words of a read or a call of levels: enough for every type of every product.
pub const WORDS: usize = 4;

/// Counts of edges that one command reads at most.
pub const EDGES_READ_MAX: u8 = 32;
