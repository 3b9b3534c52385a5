//! The power law of a channel: direct power, velocity follow, distance follow and their bounds.
//!
//! In: settings, the speeds of paths and the places of axes at a tick. Out: the power from that tick on. Owns the
//! settings. Cannot fail: what is beyond a bound is held there.
//!
//! | family | power |
//! | --- | --- |
//! | GUS | direct, or ratio·v + min held in the follow's bounds; + distance; held in the bounds of the distance and of the mode |
//! | LSR | direct (+ ratio·v + min) + distance, held in the bounds of the follow and of the mode |
//!
//! Each part is held at ±2¹⁷ of the power's unit. Of several bounds the lower ones act first: where they exclude each other the lowest upper one is put out.
use super::buffered::Buffered;
use super::distance::Distance;
use super::follow::{PathSpeed, Ratio, Source};
use super::power::{Bounds, Power};
use super::tables::{Curve, DISTANCES, Stretch};
use super::{Mode, Surroundings};
use crate::units::{Crd, CrdMask};

/// Which of the two laser manuals holds where they differ (SPEC 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Family {
    /// GUS: direct power ends a follow.
    #[default]
    Gus,
    /// LSR: direct power adds to a follow.
    Lsr,
}

/// Power as a function of the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Of {
    Ratio(Ratio),
    Table(Curve),
}

/// A velocity follow.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Follow {
    crd: Crd,
    of: Of,
    bounds: Bounds,
}

/// The law of a channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Law {
    channel: u8,
    family: Family,
    /// Direct power.
    pub(super) direct: Power,
    /// Bounds of the power mode.
    pub(super) bounds: Bounds,
    source: Source,
    follow: Option<Follow>,
    distance: Option<Distance>,
    stretch: Stretch,
    stretches: [Stretch; DISTANCES],
}

impl Law {
    pub(super) const fn power_on(channel: u8, family: Family) -> Law {
        Law {
            channel,
            family,
            direct: Power::ZERO,
            bounds: Bounds::full(Mode::Duty),
            source: Source::Planned,
            follow: None,
            distance: None,
            stretch: Stretch::NONE,
            stretches: [Stretch::NONE; DISTANCES],
        }
    }

    /// Which channel's it is.
    pub(super) fn channel(&self) -> u8 {
        self.channel
    }

    /// The bank of ratios that the distance follow reads.
    pub(super) fn bank(&self) -> Option<u8> {
        self.distance.and_then(|distance| distance.bank())
    }

    /// The table of powers that the velocity follow reads.
    pub(super) fn table(&self) -> Option<Curve> {
        match self.follow?.of {
            Of::Table(curve) => Some(curve),
            Of::Ratio(_) => None,
        }
    }

    /// Direct power by a command.
    pub(super) fn set_direct(&mut self, power: Power) {
        self.direct = power;
        if self.family == Family::Gus {
            self.follow = None;
        }
    }

    /// Another mode: no direct power, no velocity follow.
    pub(super) fn leave_mode(&mut self) {
        (self.direct, self.follow) = (Power::ZERO, None);
    }

    /// A distance follow begins, changes or ends.
    pub(super) fn set_distance(&mut self, distance: Option<Distance>) {
        self.distance = distance;
        self.stretches = [Stretch::NONE; DISTANCES];
    }

    /// What an entry of a path says about the power.
    pub(super) fn change(&mut self, crd: Crd, change: &Buffered) {
        let (of, bounds) = match *change {
            Buffered::Gate { .. } => return,
            Buffered::Direct { power } => return self.set_direct(power),
            Buffered::FollowMode { source, start } => {
                self.source = source;
                self.direct = start.unwrap_or(self.direct);
                return;
            }
            Buffered::FollowOff => {
                self.follow = None;
                return;
            }
            Buffered::FollowRatio { ratio, bounds } => (Of::Ratio(ratio), bounds),
            Buffered::PrfFollow { ratio, bounds } => {
                self.source = Source::Planned;
                (Of::Ratio(ratio), bounds)
            }
            Buffered::FollowTable { table, bounds } => (Of::Table(table), bounds),
        };
        self.stretch = Stretch::NONE;
        self.follow = Some(Follow { crd, of, bounds });
    }

    /// Ends a follow that one of these began (Stop, bits 10 and 11).
    pub(super) fn end_follow(&mut self, crds: CrdMask) {
        if self.follow.is_some_and(|follow| crds.has(follow.crd)) {
            self.follow = None;
        }
    }

    /// Whose path it follows.
    pub(super) fn follows(&self) -> Option<Crd> {
        self.follow.as_ref().map(|follow| follow.crd)
    }

    /// Which speed a follow follows.
    pub(super) fn source(&self) -> Source {
        self.source
    }

    /// Whether the power may be another one in each tick.
    #[inline]
    pub(super) fn moves(&self) -> bool {
        self.follow.is_some() || self.distance.is_some()
    }

    /// The power in force from the tick that is computed.
    #[inline]
    pub(super) fn power(&mut self, around: &Surroundings<'_>) -> Power {
        let direct = self.direct.raw();
        let (mut low, mut high) = (self.bounds.min().raw(), self.bounds.max().raw());
        let mut sum = direct;
        if let Some(Follow { crd, of, bounds }) = &self.follow {
            let speed = around.speed(*crd, self.source);
            let (min, max) = (bounds.min().raw(), bounds.max().raw());
            let part = match of {
                Of::Ratio(ratio) => ratio.power(speed).wrapping_add(min),
                Of::Table(curve) => {
                    let x = speed.raw().min(i64::MAX as u64) as i64;
                    around.tables.at(*curve, x, &mut self.stretch)
                }
            };
            match (self.family, &self.distance) {
                (Family::Gus, Some(_)) => sum = part.max(min).min(max),
                (family, _) => {
                    sum = if family == Family::Gus { part } else { part.wrapping_add(direct) };
                    (low, high) = (low.max(min), high.min(max));
                }
            }
        }
        if let Some(distance) = &self.distance {
            let place = |axis, source| around.place(axis, source);
            sum = sum.wrapping_add(distance.power(self.channel, place, around.tables, &mut self.stretches));
            if let Some(bounds) = &distance.bounds
                && self.family == Family::Gus
            {
                (low, high) = (low.max(bounds.min().raw()), high.min(bounds.max().raw()));
            }
        }
        Power::nearest(sum.max(low).min(high))
    }
}

/// Speeds of all paths, for all channels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Speeds {
    pub(super) planned: [PathSpeed; Crd::MAX],
    pub(super) encoder: [PathSpeed; Crd::MAX],
}

impl Speeds {
    pub(super) const REST: Speeds =
        Speeds { planned: [PathSpeed::REST; Crd::MAX], encoder: [PathSpeed::REST; Crd::MAX] };
}
