//! The feed override of a path: a factor on the speeds of its motions, 2⁻²⁰ to 1.
//!
//! In: the bits of the user's double. Out: an admitted [`FeedOverride`]; the motion in force,
//! planned anew with it. Owns nothing: the factor is in [`PathSettings`]. Fails: admission refuses
//! a factor out of range, [`Refused`].
use super::{Path, PathSettings, PathStage};
use crate::math::float::Float;
use crate::path::FifoEnds;
use crate::path::entry::Refused;
use crate::path::pack::float;
use crate::path::store::PathEntries;
use crate::units::{FineNs, Ns};

/// An override, the factor of all speeds of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeedOverride(u64);

impl FeedOverride {
    /// From the bits of a double: 2⁻²⁰ to 1.
    pub fn admit(bits: u64) -> Result<FeedOverride, Refused> {
        const OVERRIDE_MIN_BITS: u64 = (1023 - 20) << 52;
        const OVERRIDE_MAX_BITS: u64 = 1023 << 52;
        match bits {
            OVERRIDE_MIN_BITS..=OVERRIDE_MAX_BITS => Ok(FeedOverride(bits)),
            0..OVERRIDE_MIN_BITS => Err(Refused::TooSmall),
            _ if bits & 0x7ff << 52 == 0x7ff << 52 => Err(Refused::NotFinite),
            _ if bits >> 63 == 1 => Err(Refused::Negative),
            _ => Err(Refused::BeyondRange),
        }
    }

    fn float(self) -> Float {
        float(self.0)
    }
}

impl PathSettings {
    /// Override: the speeds of all motions are multiplied by it. The speeds at their ends are not,
    /// but held to these.
    pub fn set_override(&mut self, rate: FeedOverride) {
        self.rate = rate.float();
    }
}

impl Path {
    /// The motion in force is planned anew from `next` on, because a rule has changed.
    pub fn replan(&mut self, next: Ns, feed: FifoEnds, source: &impl PathEntries) {
        if let PathStage::Move = self.stage {
            self.catch_up((next.0 as FineNs) << 32);
            self.plan_remainder(feed, source);
        } else {
            self.pieces.follows = None;
            self.unplan();
        }
        self.decide_fast_path();
    }
}
