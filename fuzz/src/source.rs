//! An input as numbers.
//!
//! In: bytes. Out: choices; zeros after the end. Any bytes are an input, and a small change of
//! them is a small change of what is done.
use arbitrary::Unstructured;

/// See the module text.
pub struct Source<'a>(Unstructured<'a>);

/// Numbers that arithmetic gets wrong.
const WILD_REALS: [f64; 16] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    5e-324,
    f64::MIN_POSITIVE,
    4_294_967_296.0,
    -4_294_967_296.0,
    1_099_511_627_776.0,
    -1_099_511_627_776.0,
    9_007_199_254_740_993.0,
    1e-9,
    -0.0,
    0.1,
    65_536.0,
];
const WILD_INTEGERS: [i64; 14] = [
    -1,
    0,
    i16::MAX as i64,
    i16::MIN as i64,
    u16::MAX as i64,
    i32::MAX as i64,
    i32::MIN as i64,
    u32::MAX as i64,
    i64::MAX,
    i64::MIN,
    99,
    256,
    1024,
    1025,
];

impl<'a> Source<'a> {
    /// From these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Source(Unstructured::new(bytes))
    }

    /// Nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// The next two.
    pub fn word(&mut self) -> u16 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// The next eight.
    pub fn long(&mut self) -> u64 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// From 0 to below `end`, by one byte or two.
    pub fn below(&mut self, end: usize) -> usize {
        let raw = if end <= 256 { usize::from(self.byte()) } else { usize::from(self.word()) };
        raw % end.max(1)
    }

    /// One time in `of`, as far as bytes are even.
    pub fn one_in(&mut self, of: u8) -> bool {
        self.byte() % of == of - 1
    }

    /// So many bytes, or what is left.
    pub fn bytes(&mut self, count: usize) -> &'a [u8] {
        let count = count.min(self.0.len());
        self.0.bytes(count).unwrap_or(&[])
    }

    /// A real number of any bits, often one of those that arithmetic gets wrong.
    pub fn wild_real(&mut self) -> f64 {
        match self.byte() {
            n @ 0..128 => WILD_REALS[usize::from(n) % WILD_REALS.len()],
            n @ 128..192 => f64::from(i16::from_le_bytes(self.word().to_le_bytes())) * 2f64.powi(i32::from(n) - 160),
            _ => f64::from_bits(self.long()),
        }
    }

    /// A whole number of any size, often one of those.
    pub fn wild_integer(&mut self) -> i64 {
        match self.byte() {
            n @ 0..192 => WILD_INTEGERS[usize::from(n) % WILD_INTEGERS.len()],
            _ => self.long().cast_signed() >> (self.byte() & 63),
        }
    }
}
