//! What a client chose on opening: product profile and laser family. How users number axes and
//! coordinate systems.
use crate::product::{PROFILES, ProductProfile};
use servo::units::{Axis, AxisMask, Crd, CrdMask};

/// What the client chose on opening.
#[derive(Debug, Clone, Copy)]
pub struct Configuration {
    /// Number of the profile.
    pub number: u8,
    /// Its counts.
    pub profile: ProductProfile,
    /// 0 GUS, 1 LSR.
    pub family: u8,
}

impl Configuration {
    /// The profile with this number, or the first.
    pub fn new(number: u8, family: u8) -> Self {
        let (number, profile) = match PROFILES.get(usize::from(number)) {
            Some(profile) => (number, *profile),
            None => (0, PROFILES[0]),
        };
        Configuration { number, profile, family }
    }
    pub fn per_core(&self) -> usize {
        usize::from(self.profile.axes_per_core)
    }
    /// A coordinate system's number in its core, as the user knows it.
    pub fn crd_number(&self, crd: Crd) -> i16 {
        (crd.index() % usize::from(self.profile.crds_per_core).max(1)) as i16 + 1
    }
    /// The axis's number in its core, as the user knows it.
    pub fn number_of(&self, axis: Axis) -> i16 {
        (axis.index() % self.per_core().max(1)) as i16 + 1
    }
    /// The axis's core, as the user knows it.
    pub fn core_of(&self, axis: Axis) -> i16 {
        (axis.index() / self.per_core().max(1)) as i16 + 1
    }
    /// All axes of the profile.
    pub fn all(&self) -> AxisMask {
        AxisMask(ones(self.profile.axes()))
    }

    /// All coordinate systems of the profile.
    pub fn all_crds(&self) -> CrdMask {
        let count = usize::from(self.profile.cores) * usize::from(self.profile.crds_per_core);
        CrdMask(ones(count.min(Crd::MAX)) as u8)
    }
}

/// The lowest `count` bits.
pub const fn ones(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}
