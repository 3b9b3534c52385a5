//! Jog, Trap and Stop as sequences of pieces.
use crate::piece::Scaled;

/// A velocity in pulse/ms.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Speed(pub Scaled);

/// An acceleration in pulse/ms² with its reciprocal, so that the tick never divides.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Accel {
    /// The magnitude.
    pub value: Scaled,
    /// 1/magnitude.
    pub recip: Scaled,
}
