//! How to open a controller: profile, family, tick, waiting times.
use protocol::link::Identity;
use std::time::Duration;

/// Product profiles of SPEC 2, by their numbers on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs)]
pub enum ProductProfile {
    Gus = 0,
    Gtn016 = 1,
    Gtn024 = 2,
    Gsn008Lt = 3,
    Gsn024 = 4,
    Gsn048 = 5,
    R688c024 = 6,
    R688s016 = 7,
    R688s032 = 8,
}

impl ProductProfile {
    /// All profiles with their names on the command line.
    pub const ALL: [(ProductProfile, &'static str); 9] = [
        (ProductProfile::Gus, "gus"),
        (ProductProfile::Gtn016, "gtn-016"),
        (ProductProfile::Gtn024, "gtn-024"),
        (ProductProfile::Gsn008Lt, "gsn-008-lt"),
        (ProductProfile::Gsn024, "gsn-024"),
        (ProductProfile::Gsn048, "gsn-048"),
        (ProductProfile::R688c024, "r688c-024"),
        (ProductProfile::R688s016, "r688s-016"),
        (ProductProfile::R688s032, "r688s-032"),
    ];

    /// The profile of this name.
    pub fn named(name: &str) -> Option<ProductProfile> {
        Self::ALL.iter().find(|(_, n)| n.eq_ignore_ascii_case(name)).map(|(p, _)| *p)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The profile of this number on the wire.
    pub fn numbered(number: u8) -> Option<ProductProfile> {
        Self::ALL.get(usize::from(number)).map(|(profile, _)| *profile)
    }

    /// Logical cores, and axes of each (GXN tables 5-1 to 5-3).
    pub const fn counts(self) -> (u8, u8) {
        match self {
            ProductProfile::Gus | ProductProfile::Gsn008Lt => (1, 8),
            ProductProfile::Gtn016 => (2, 8),
            ProductProfile::Gtn024 | ProductProfile::Gsn024 => (2, 12),
            ProductProfile::Gsn048 => (2, 24),
            ProductProfile::R688c024 => (1, 24),
            ProductProfile::R688s016 => (1, 16),
            ProductProfile::R688s032 => (1, 32),
        }
    }

    /// Whether it has this axis of this core, both from 1; axis 0 means the core alone.
    pub fn holds(self, core: i16, axis: i16) -> bool {
        let (cores, axes) = self.counts();
        (1..=i16::from(cores)).contains(&core) && (0..=i16::from(axes)).contains(&axis)
    }

    /// The first profile in the order of the table that holds all of these axes (core, axis). What
    /// no profile holds does not count: the controller refuses it by name.
    pub fn for_axes(axes: &[(i16, i16)]) -> ProductProfile {
        let known = |axis: &&(i16, i16)| Self::ALL.iter().any(|(profile, _)| profile.holds(axis.0, axis.1));
        let known: Vec<_> = axes.iter().filter(known).collect();
        let fits = |profile: &&(ProductProfile, &str)| known.iter().all(|axis| profile.0.holds(axis.0, axis.1));
        // Core 1 with 32 axes and a second core are in no one profile; then the controller refuses
        // some.
        Self::ALL.iter().find(fits).map_or(ProductProfile::Gsn048, |(profile, _)| *profile)
    }
}

/// Families of SPEC 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Family {
    /// The GUS laser manual.
    #[default]
    Gus = 0,
    /// The earlier series' laser manual.
    Lsr = 1,
}

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> Option<Family> {
        match name.to_ascii_lowercase().as_str() {
            "gus" => Some(Family::Gus),
            "lsr" => Some(Family::Lsr),
            _ => None,
        }
    }
}

/// How to open a controller.
#[derive(Debug, Clone)]
pub struct Options {
    /// Product profile to choose; `None` keeps what the controller shows.
    pub profile: Option<ProductProfile>,
    /// Family to choose; `None` keeps what the controller shows. Another one puts its lasers to
    /// power-on state.
    pub family: Option<Family>,
    /// Servo tick in µs; `None` keeps the controller's.
    pub tick_us: Option<u32>,
    /// A call fails with −7 if nothing arrives from the controller for this long. Time for which
    /// the host delayed the client does not count; an emulated board may take five times as long.
    pub timeout: Duration,
    /// Opening fails with −7 after this time without an answer; likewise.
    pub open_timeout: Duration,
    /// Calls of a program for one FIFO of a path travel together; without it each travels alone. No
    /// result depends on it.
    pub joins: bool,
    /// The session only reads (docs/protocol.md): profile, family and tick stay as they are, and
    /// the client that commands notices nothing.
    pub read_only: bool,
    /// Version and schema that the client shows; anything but the build's own is for tests.
    pub identity: Identity,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            profile: None,
            family: None,
            tick_us: None,
            timeout: Duration::from_secs(2),
            open_timeout: Duration::from_secs(3),
            joins: true,
            read_only: false,
            identity: Identity::OURS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_agree() {
        for (number, (profile, name)) in ProductProfile::ALL.into_iter().enumerate() {
            assert_eq!(profile as usize, number);
            assert_eq!(ProductProfile::named(&name.to_uppercase()), Some(profile));
            assert_eq!(ProductProfile::numbered(number as u8), Some(profile));
            assert_eq!(profile.name(), name);
        }
        assert_eq!((ProductProfile::named("gtx"), ProductProfile::numbered(9)), (None, None));
    }

    #[test]
    fn a_job_gets_the_first_profile_that_holds_it() {
        for (axes, profile) in [
            (&[][..], ProductProfile::Gus),
            (&[(1, 0), (1, 8)], ProductProfile::Gus),
            (&[(1, 9)], ProductProfile::Gtn024),
            (&[(2, 1)], ProductProfile::Gtn016),
            (&[(1, 1), (2, 12)], ProductProfile::Gtn024),
            (&[(1, 13)], ProductProfile::Gsn048),
            (&[(1, 25)], ProductProfile::R688s032),
            // Nobody has these: they are for the controller to refuse.
            (&[(1, 99), (3, 1), (0, 1), (1, -1)], ProductProfile::Gus),
            (&[(2, 1), (1, 99)], ProductProfile::Gtn016),
            (&[(2, 1), (1, 32)], ProductProfile::Gsn048),
        ] {
            assert_eq!(ProductProfile::for_axes(axes), profile, "{axes:?}");
        }
    }
}
