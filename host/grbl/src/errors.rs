//! Grbl's numbers for what is wrong with a line.
//!
//! In: the interpreter's reason. Out: the number that Grbl 1.1 gives the same fault. Numbers are
//! those of Grbl's `doc/csv/error_codes_en_US.csv`.

/// A `$` line that means nothing.
pub const BAD_STATEMENT: u8 = 3;
/// A `$` command that waits for standstill.
pub const NOT_IDLE: u8 = 8;
/// G-code while an alarm or a jog is in force.
pub const LOCKED: u8 = 9;
/// More characters than a line may have.
pub const OVERFLOW: u8 = 11;
/// The interlock, or another cause of darkness, is still there.
pub const DOOR: u8 = 13;
/// A jog that leaves the travel.
pub const JOG_TRAVEL: u8 = 15;
/// A jog with other words.
pub const JOG_WORDS: u8 = 16;
/// What is not supported.
pub const UNSUPPORTED: u8 = 20;

/// Part of a reason, and its number; the first that fits counts.
const NUMBERS: &[(&str, u8)] = &[
    ("its travel is", JOG_TRAVEL),
    ("a jog has", JOG_WORDS),
    ("a letter must have", 2),
    ("a number has at most", 2),
    ("is no word: a letter and a number", 1),
    ("is no G-code", 1),
    ("without `(`", 1),
    ("variables and expressions", 1),
    ("is twice in a line", 25),
    ("two words of one modal group", 21),
    ("of this line use its axis words", 24),
    ("take no axis words", 36),
    ("belongs to no word", 36),
    ("belongs to two words", 36),
    ("G53 goes with", 30),
    ("G4 needs P", 28),
    ("G10 needs L and P", 28),
    ("G4 P is 0 to", 4),
    ("is below 0", 4),
    ("number is 0 or above", 4),
    ("has no decimals", 23),
    ("G10 P is 0", 29),
    ("needs an axis word", 26),
    ("no feed rate", 22),
    ("in inverse time", 22),
    ("axis words after G80", 31),
    ("I, J, K and R belong", 36),
    ("need axis words or a centre", 26),
    ("an arc by R needs axis words", 26),
    ("an arc by R needs an axis word of", 32),
    ("an arc by R needs an end", 33),
    ("the radius does not fit: R is", 34),
    ("the radius does not fit: it is", 33),
    ("the centre of the arc is its start", 33),
    ("an arc needs R or a centre", 35),
    ("an arc has either", 36),
    ("is no centre of an arc", 36),
    ("needs both words of its centre", 35),
];

/// The number of a reason. What is none of Grbl's own is not supported.
pub fn number(reason: &str) -> u8 {
    // "an arc by R needs an axis word" has more to say than "needs an axis word".
    let fits = NUMBERS.iter().filter(|(part, _)| reason.contains(part));
    fits.max_by_key(|(part, _)| part.len()).map_or(UNSUPPORTED, |(_, number)| *number)
}

/// Whether a line leaves the travel.
pub fn leaves_travel(reason: &str) -> bool {
    number(reason) == JOG_TRAVEL
}
