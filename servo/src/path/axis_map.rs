//! The axes that a coordinate system drives, and where its zero is.
//!
//! In: SetCrdPrm. Out: an admitted [`AxisMap`]. Fails: with the rule that is broken, [`Refused`].
use super::DIMENSIONS;
use crate::units::{Axis, AxisMask};

/// An admitted frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisMap {
    /// The axes of X, Y, Z, A.
    pub axes: [Option<Axis>; DIMENSIONS],
    /// The requested origin.
    pub(crate) origin: Option<[i32; DIMENSIONS]>,
    /// Least time at constant speed in a motion, ms.
    pub(crate) even_ms: u16,
    /// The indices of the axes.
    pub(crate) axis_indices: AxisIndices,
}

/// Indices of the axes, [`NONE`] where there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AxisIndices([u8; DIMENSIONS]);

/// No axis has this index.
const NONE: u8 = u8::MAX;

/// Why a frame is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// It drives no axis.
    NoAxis,
    /// It drives this axis by two coordinates.
    Twice(Axis),
}

impl AxisMap {
    /// `axes` of X, Y, Z, A, none twice. `origin` is their planned positions at zero, in pulses;
    /// None takes their positions when the frame is set. `even_ms` is the least time at constant
    /// speed in a motion.
    pub fn admit(
        axes: [Option<Axis>; DIMENSIONS],
        origin: Option<[i32; DIMENSIONS]>,
        even_ms: u16,
    ) -> Result<AxisMap, Refused> {
        let mut sampled = AxisMask(0);
        for axis in axes.into_iter().flatten() {
            if sampled.has(axis) {
                return Err(Refused::Twice(axis));
            }
            sampled.0 |= axis.mask().0;
        }
        if sampled.0 == 0 {
            return Err(Refused::NoAxis);
        }
        let axis_indices = axes.map(|axis| axis.map_or(NONE, |axis| axis.index() as u8));
        Ok(AxisMap { axes, origin, even_ms, axis_indices: AxisIndices(axis_indices) })
    }

    /// The axes as a set.
    pub fn mask(&self) -> AxisMask {
        AxisMask(self.axes.iter().flatten().fold(0, |mask, axis| mask | axis.mask().0))
    }
}

impl AxisIndices {
    /// No axis.
    pub(crate) const NONE: AxisIndices = AxisIndices([NONE; DIMENSIONS]);

    /// Whether this holds for every coordinate and the index of its axis; an unused coordinate has
    /// an index that no axis has. Unrolled, as a loop costs as much as its body.
    #[inline(always)]
    pub(crate) fn all(&self, mut holds: impl FnMut(usize, usize) -> bool) -> bool {
        let [x, y, z, a] = &self.0;
        holds(0, *x as usize)
            && holds(1, *y as usize)
            && (*z & *a == NONE || holds(2, *z as usize) && holds(3, *a as usize))
    }
}
