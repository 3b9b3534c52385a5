//! Product profiles: how many cores, axes, coordinate systems and lasers a controller shows.
//!
//! In: the number a client chose. Out: the counts. Owns nothing; a build whose capacity is too small
//! for a profile refuses it with code 3. Source: SPEC section 2, GXN manual tables 5-1 to 5-3.

/// The counts of one product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Profile {
    /// Name on the command line.
    pub name: &'static str,
    /// Logical cores.
    pub cores: u8,
    /// Axes of each core.
    pub axes_per_core: u8,
    /// Coordinate systems of each core.
    pub crds_per_core: u8,
    /// Laser channels of the controller.
    pub lasers: u8,
}

impl Profile {
    /// Axes over all cores.
    pub const fn axes(&self) -> usize {
        self.cores as usize * self.axes_per_core as usize
    }
}

const fn row(name: &'static str, cores: u8, axes_per_core: u8, crds_per_core: u8) -> Profile {
    Profile { name, cores, axes_per_core, crds_per_core, lasers: 2 }
}

/// Every profile; its place is its number in `Choose` and `Version`.
pub const PROFILES: &[Profile] = &[
    row("gus", 1, 8, 2),
    row("gtn-016", 2, 8, 2),
    row("gtn-024", 2, 12, 2),
    row("gsn-008-lt", 1, 8, 2),
    row("gsn-024", 2, 12, 2),
    row("gsn-048", 2, 24, 2),
    row("r688c-024", 1, 24, 2),
    row("r688s-016", 1, 16, 4),
    row("r688s-032", 1, 32, 4),
];

/// The families of SPEC 2: 0 is GUS, 1 is LSR.
pub const FAMILIES: u8 = 2;

/// The first profile that `axes` axes can hold.
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
