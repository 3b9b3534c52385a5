//! One piece of motion: a cubic in its normalised parameter.

/// 1/length of a piece: mantissa with the top bit set and a shift.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Recip {
    /// Mantissa.
    pub m: u64,
    /// Shift.
    pub shift: u8,
}

/// The place in a piece: enough to derive velocity and acceleration. Default is at rest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Motion {
    /// Coefficients of τ, τ², τ³ in 2^-`frac` pulse.
    pub c: [i64; 3],
    /// Fraction bits of `c`.
    pub frac: u8,
    /// Parameter τ in 2⁻⁶⁴.
    pub tau: u64,
    /// 1/length of the piece in ns.
    pub recip: Recip,
}

/// A real number m·2^-e.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Scaled {
    /// Mantissa.
    pub m: i64,
    /// Negative exponent.
    pub e: i16,
}
