//! Quantities of the tick, one newtype each, so that a pulse cannot be added to a ratio.

/// The unit of bands, filters, delays and on-times, whatever the tick is: 250 µs.
pub const CYCLE_NS: u32 = 250_000;

/// Position in 2⁻²² pulse. An axis travels ±2⁴⁰ pulses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[repr(transparent)]
pub struct Pos(pub i64);

impl Pos {
    /// Fraction bits.
    pub const FRAC_BITS: u32 = 22;
    /// The edge of travel: 2⁴⁰.
    pub const TRAVEL_PULSES: i64 = 1 << 40;
    /// The edge of travel as a position.
    pub const TRAVEL: Pos = Pos(Self::TRAVEL_PULSES << Self::FRAC_BITS);
    /// A whole number of pulses.
    pub const fn pulses(pulses: i32) -> Pos {
        Pos((pulses as i64) << Self::FRAC_BITS)
    }
}

/// The most that the step outputs of a board make of an axis: whole pulse/ms, from 1 to full scale
/// (SPEC 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct StepLimit(u64);

impl StepLimit {
    /// 2³² pulse/ms: what no velocity exceeds anyway.
    pub const FULL_SCALE: StepLimit = StepLimit(1 << 32);
    /// So many pulse/ms.
    pub const fn new(pulses_per_ms: u64) -> Option<StepLimit> {
        if pulses_per_ms == 0 || pulses_per_ms > Self::FULL_SCALE.0 { None } else { Some(StepLimit(pulses_per_ms)) }
    }
    /// Pulse/ms.
    pub const fn pulses_per_ms(self) -> u64 {
        self.0
    }
    /// The bits of the double that it is.
    pub(crate) const fn bits(self) -> u64 {
        let exponent = 63 - (self.0 | 1).leading_zeros();
        ((1023 + exponent) as u64) << 52 | self.0 << (52 - exponent) & ((1 << 52) - 1)
    }
    /// In 2⁻⁸ [`Pos`] a µs, rounded up.
    pub(crate) const fn per_us(self) -> u64 {
        (self.0 << (Pos::FRAC_BITS + 8)).div_ceil(1000)
    }
}

/// Position or displacement in 2⁻⁶⁴ pulse: knots, origins and what passes accumulate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[repr(transparent)]
pub struct Exact(pub i128);

/// Controller time or a duration in ns; 2⁶⁴ ns are 584 years.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[repr(transparent)]
pub struct Ns(pub u64);

/// An instant or a duration in 2⁻³² ns; instants count from power-on.
pub type FineNs = u128;

/// An index over all cores from 0, below `MAX`, and the set of such indices, bit 0 the first.
macro_rules! index {
    ($name:ident, $mask:ident, $each:ident) => {
        impl $name {
            /// The first one.
            pub const FIRST: $name = $name(0);
            /// The one with this index, if there may be one.
            pub const fn new(index: usize) -> Option<$name> {
                if index < Self::MAX { Some($name(index as u8)) } else { None }
            }
            /// Every one, in order.
            #[inline]
            pub fn all() -> impl Iterator<Item = $name> {
                (0..Self::MAX as u8).map($name)
            }
            /// Index from 0.
            pub const fn index(self) -> usize {
                self.0 as usize
            }
            /// Its bit in a set.
            pub const fn mask(self) -> $mask {
                $mask(1 << self.0)
            }
        }

        impl $mask {
            /// What it holds, in order.
            #[inline]
            pub fn $each(self) -> impl Iterator<Item = $name> {
                let mut left = self.0;
                core::iter::from_fn(move || {
                    let one = $name::new(left.trailing_zeros() as usize)?;
                    left &= left.wrapping_sub(1);
                    Some(one)
                })
            }

            /// Whether it holds this one.
            pub const fn has(self, one: $name) -> bool {
                self.0 >> one.0 & 1 == 1
            }
        }
    };
}

/// An axis of the controller, over all cores, from 0: core × axes per core + axis − 1.
/// Its only constructor checks it against the capacity, so an index from it needs no other bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[repr(transparent)]
pub struct Axis(u8);

/// A set of axes over all cores, bit 0 the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(transparent)]
pub struct AxisMask(pub u64);

index!(Axis, AxisMask, axes);

impl Axis {
    /// The largest capacity of any build (gsn-048: 2 cores × 24 axes).
    pub const MAX: usize = 48;
}

/// A coordinate system of the controller, over all cores, from 0: core × those per core + crd − 1.
/// Its only constructor checks it against the capacity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
#[repr(transparent)]
pub struct Crd(u8);

/// A set of coordinate systems over all cores, bit 0 the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[repr(transparent)]
pub struct CrdMask(pub u8);

index!(Crd, CrdMask, crds);

impl Crd {
    /// The largest number of any profile that the build holds, over all cores.
    pub const MAX: usize = crate::capacity::CRDS;
}

/// Digital outputs that `SetDo` addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DoGroup {
    /// Servo enable, a bit an axis (of the core's first axis on).
    Enable,
    /// Alarm clear, a bit an axis.
    Clear,
    /// General outputs.
    General,
}

impl DoGroup {
    /// Its number in entries of a FIFO; any other number is that of the last.
    pub(crate) const fn of(number: u32) -> DoGroup {
        match number {
            0 => DoGroup::Enable,
            1 => DoGroup::Clear,
            _ => DoGroup::General,
        }
    }
}

/// The pulse of the step output for this planned position: the nearest one, halves upwards.
pub const fn whole(pos: Pos) -> i64 {
    const HALF: i64 = 1 << (Pos::FRAC_BITS - 1);
    pos.0.saturating_add(HALF) >> Pos::FRAC_BITS
}
