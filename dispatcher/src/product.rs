//! Product profiles: how many cores, axes, coordinate systems and lasers a controller has.
//!
//! In: the number that a client chose. Out: the counts. Owns nothing.
//! Fails: a build whose capacity is too small for a profile refuses it with code 3.
//! Source: SPEC section 2, GXN manual tables 5-1 to 5-3.

use servo::units::Ns;

servo::state! {
    /// The counts of one product.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct ProductProfile {
        /// Name on the command line.
        pub name: &'static str = name,
        /// Logical cores.
        pub cores: u8 = cores,
        /// Axes of each core.
        pub axes_per_core: u8 = axes_per_core,
        /// Coordinate systems of each core that exist at every tick period of at least
        /// [`LONG_TICK`].
        pub crds_per_core: u8 = crds.1,
        /// Coordinate systems of each core at a shorter period (GXN table 5-1: GSN).
        pub crds_in_short_ticks: u8 = crds.0,
        /// General inputs of the controller. They belong to all cores, and so do the outputs.
        pub general_inputs: u8 = general.0,
        /// Its general outputs.
        pub general_outputs: u8 = general.1,
        /// Laser channels of the controller.
        pub lasers: u8 = 2,
    }
    /// `crds`: at periods below [`LONG_TICK`], and from there on. `general`: inputs and outputs.
    const fn row(name: &'static str, (cores, axes_per_core): (u8, u8), crds: (u8, u8), general: (u8, u8));
}

impl ProductProfile {
    /// Axes over all cores.
    pub const fn axes(&self) -> usize {
        self.cores as usize * self.axes_per_core as usize
    }

    /// Coordinate systems of a core at this tick period.
    pub const fn crds_at(&self, period: Ns) -> u8 {
        if period.0 < LONG_TICK.0 { self.crds_in_short_ticks } else { self.crds_per_core }
    }
}

/// From this tick period on, GSN has all its coordinate systems (GXN table 5-1).
pub const LONG_TICK: Ns = Ns(500_000);

/// Every profile; its index is its number in `Choose` and `Version`. No manual counts the inputs
/// and outputs of GUS: one word each.
pub const PROFILES: &[ProductProfile] = &[
    ProductProfile::row("gus", (1, 8), (2, 2), (32, 32)),
    ProductProfile::row("gtn-016", (2, 8), (2, 2), (44, 20)),
    ProductProfile::row("gtn-024", (2, 12), (2, 2), (66, 30)),
    ProductProfile::row("gsn-008-lt", (1, 8), (2, 4), (100, 40)),
    ProductProfile::row("gsn-024", (2, 12), (2, 4), (100, 40)),
    ProductProfile::row("gsn-048", (2, 24), (2, 4), (100, 40)),
    ProductProfile::row("r688c-024", (1, 24), (2, 2), (100, 64)),
    ProductProfile::row("r688s-016", (1, 16), (4, 4), (64, 64)),
    ProductProfile::row("r688s-032", (1, 32), (4, 4), (64, 64)),
];

/// The families of SPEC 2: 0 is GUS, 1 is LSR.
pub const FAMILIES: u8 = 2;

/// The first profile that fits into `axes` axes.
pub const fn largest_that_fits(axes: usize) -> u8 {
    let mut best = 0;
    let mut index = 0;
    while index < PROFILES.len() {
        if PROFILES[index].axes() <= axes && PROFILES[index].axes() > PROFILES[best].axes() {
            best = index;
        }
        index += 1;
    }
    best as u8
}
