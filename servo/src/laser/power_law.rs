//! The power law of a channel: direct power, velocity follow, distance follow and their bounds.
//!
//! In: settings, the speeds of paths and the positions of axes at a tick. Out: the power from that
//! tick on. Owns the settings. Cannot fail: a power beyond a bound is held there.
//!
//! | family | power |
//! | --- | --- |
//! | GUS | direct, or ratio·v + min held in the follow's bounds; + distance; held in the bounds of the distance and of the mode |
//! | LSR | direct (+ ratio·v + min) + distance, held in the bounds of the follow and of the mode |
//!
//! Each part is held at ±2¹⁷ of the power's unit. Of several bounds the lower ones act first: where
//! they exclude each other the lowest upper one is output.
use super::buffered::Buffered;
use super::distance_follow::{Distance, FixedRatioSum};
use super::power::{Power, PowerBounds};
use super::power_tables::{Curve, DISTANCES, Interval};
use super::velocity_follow::{Ratio, SpeedGain, SpeedSource};
use super::{FollowInputs, Positions, PowerMode};
use crate::path::PathSpeed;
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
enum SpeedLaw {
    Ratio(Ratio),
    Table(Curve),
}

/// A velocity follow.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Follow {
    crd: Crd,
    of: SpeedLaw,
    bounds: PowerBounds,
}

/// The part of a velocity follow, in the form for the tick.
#[derive(Debug, Clone, Copy)]
enum SpeedPart {
    None,
    Ratio(SpeedGain),
    Table(Curve),
}

/// The part of a distance follow, in the form for the tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Added {
    Nothing,
    FixedRatioSum,
    Tables,
}

state! {
    /// The settings as one sum, prepared for the tick.
    #[derive(Debug, Clone, Copy)]
    struct PowerSum {
        /// The constant part, 2⁻⁴⁴.
        base: i64 = 0,
        /// Bounds of all.
        low: i64 = 0,
        high: i64 = PowerBounds::full(PowerMode::Duty).max().raw(),
        part: SpeedPart = SpeedPart::None,
        /// Index of the speed: [`PathSpeeds::index`].
        speed: usize = 0,
        added: Added = Added::Nothing,
        /// The power may change in each tick.
        moves: bool = false,
        /// Bounds of the part that follows the speed, where the distance is added after them.
        held: Option<(i64, i64)> = None,
    }
    const POWER_ON;
}

state! {
    /// The law of a channel.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct PowerLaw {
        /// Always derived from the settings below: every change of these ends with
        /// [`PowerLaw::renew`].
        mix: PowerSum = PowerSum::POWER_ON,
        terms: FixedRatioSum = FixedRatioSum::NONE,
        /// The coordinate systems whose planned speed it follows, and those whose encoders' speed.
        pub(super) planned: CrdMask = CrdMask(0),
        pub(super) encoder: CrdMask = CrdMask(0),
        pub(super) channel: u8 = channel,
        family: Family = family,
        pub(super) direct: Power = Power::ZERO,
        pub(super) bounds: PowerBounds = PowerBounds::full(PowerMode::Duty),
        pub(super) source: SpeedSource = SpeedSource::Planned,
        follow: Option<Follow> = None,
        distance: Option<Distance> = None,
        interval: Interval = Interval::NONE,
        intervals: [Interval; DISTANCES] = [Interval::NONE; DISTANCES],
    }
    pub(super) const fn power_on(channel: u8, family: Family);
}

impl PowerLaw {
    /// The bank of ratios that the distance follow reads.
    pub(super) fn bank(&self) -> Option<u8> {
        self.distance.and_then(|distance| distance.ratios.bank())
    }

    /// The table of powers that the velocity follow reads.
    pub(super) fn table(&self) -> Option<Curve> {
        match self.follow?.of {
            SpeedLaw::Table(curve) => Some(curve),
            SpeedLaw::Ratio(_) => None,
        }
    }

    /// Sets the bounds.
    pub(super) fn set_bounds(&mut self, bounds: PowerBounds) {
        self.bounds = bounds;
        self.renew();
    }

    /// Direct power by a command.
    pub(super) fn set_direct(&mut self, power: Power) {
        self.direct = power;
        if self.family == Family::Gus {
            self.follow = None;
        }
        self.renew();
    }

    /// Another mode: no direct power, no velocity follow.
    pub(super) fn leave_mode(&mut self) {
        (self.direct, self.follow) = (Power::ZERO, None);
        self.renew();
    }

    /// A distance follow begins, changes or ends.
    pub(super) fn set_distance(&mut self, distance: Option<Distance>) {
        self.distance = distance;
        self.intervals = [Interval::NONE; DISTANCES];
        self.terms = distance.map_or(FixedRatioSum::NONE, |distance| distance.terms());
        self.renew();
    }

    /// The change of the power that an entry of a path makes.
    pub(super) fn change(&mut self, crd: Crd, change: &Buffered) {
        self.take(crd, change);
        self.renew();
    }

    fn take(&mut self, crd: Crd, change: &Buffered) {
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
            Buffered::FollowRatio { ratio, bounds } => (SpeedLaw::Ratio(ratio), bounds),
            Buffered::PrfFollow { ratio, bounds } => {
                self.source = SpeedSource::Planned;
                (SpeedLaw::Ratio(ratio), bounds)
            }
            Buffered::FollowTable { table, bounds } => (SpeedLaw::Table(table), bounds),
        };
        self.interval = Interval::NONE;
        self.follow = Some(Follow { crd, of, bounds });
    }

    /// Ends a follow that one of these began (Stop, bits 10 and 11).
    pub(super) fn end_follow(&mut self, crds: CrdMask) {
        if self.follow.is_some_and(|follow| crds.has(follow.crd)) {
            self.follow = None;
            self.renew();
        }
    }

    /// The coordinate system whose speed it follows.
    pub(super) fn follows(&self) -> Option<Crd> {
        self.follow.as_ref().map(|follow| follow.crd)
    }

    /// Whether the power may change in each tick.
    #[inline]
    pub(super) fn moves(&self) -> bool {
        self.mix.moves
    }

    /// Derives the form for the tick from the settings.
    #[inline(never)]
    fn renew(&mut self) {
        let direct = self.direct.raw();
        let (mut low, mut high) = (self.bounds.min().raw(), self.bounds.max().raw());
        let (mut base, mut part, mut held) = (direct, SpeedPart::None, None);
        (self.planned, self.encoder) = (CrdMask(0), CrdMask(0));
        if let Some(Follow { crd, of, bounds }) = self.follow {
            let (min, max) = (bounds.min().raw(), bounds.max().raw());
            (part, base) = match of {
                SpeedLaw::Ratio(ratio) => (SpeedPart::Ratio(ratio.gain()), min),
                SpeedLaw::Table(curve) => (SpeedPart::Table(curve), 0),
            };
            match (self.family, &self.distance) {
                (Family::Gus, Some(_)) => held = Some((min, max)),
                (Family::Gus, None) => (low, high) = (low.max(min), high.min(max)),
                (Family::Lsr, _) => {
                    base = base.wrapping_add(direct);
                    (low, high) = (low.max(min), high.min(max));
                }
            }
            *if self.source == SpeedSource::Planned { &mut self.planned } else { &mut self.encoder } = crd.mask();
        }
        let added = match &self.distance {
            None => Added::Nothing,
            Some(distance) if distance.ratios.bank().is_none() => Added::FixedRatioSum,
            Some(_) => Added::Tables,
        };
        if let Some(bounds) = self.distance.as_ref().and_then(|distance| distance.bounds)
            && self.family == Family::Gus
        {
            (low, high) = (low.max(bounds.min().raw()), high.min(bounds.max().raw()));
        }
        let speed = self.follow.map_or(0, |follow| PathSpeeds::index(follow.crd, self.encoder.0 != 0));
        let moves = self.follow.is_some() || self.distance.is_some();
        self.mix = PowerSum { base, low, high, part, speed, added, moves, held };
    }

    /// The axes whose positions count by fixed ratios, if any do.
    #[inline(always)]
    pub(super) fn followed_axes(&self) -> Option<u32> {
        (self.mix.added == Added::FixedRatioSum).then_some(self.terms.key)
    }

    /// The power is not needed in this tick: next time all of it is to be computed.
    #[inline(always)]
    pub(super) fn skip(&mut self) {
        self.terms.skip();
    }

    /// The power in force from the tick that is computed.
    #[inline(always)]
    pub(super) fn power(&mut self, around: &FollowInputs<impl Positions>) -> Power {
        let PowerSum { base, low, high, part, speed, added, held, .. } = &self.mix;
        if *added == Added::FixedRatioSum {
            self.terms.advance(around.displacements, &self.distance);
        }
        let mut sum = *base;
        let speed = || around.speed(*speed);
        match part {
            SpeedPart::None => {}
            SpeedPart::Ratio(gain) => sum = sum.wrapping_add(gain.power(speed())),
            SpeedPart::Table(curve) => {
                let x = speed().raw().min(i64::MAX as u64) as i64;
                sum = sum.wrapping_add(around.tables.at(*curve, x, &mut self.interval));
            }
        }
        if let Some((min, max)) = held {
            sum = sum.max(*min).min(*max);
        }
        let added = match added {
            Added::Nothing => 0,
            Added::FixedRatioSum => self.terms.power,
            Added::Tables => match &self.distance {
                Some(distance) => {
                    let position = |axis, source| around.position(axis, source);
                    distance.tabled(self.channel, position, around.tables, &mut self.intervals)
                }
                None => 0,
            },
        };
        Power::bounded(sum.wrapping_add(added).max(*low).min(*high))
    }
}

/// Speeds of all paths, for all channels; a path that is not fed has speed 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathSpeeds {
    /// Which of them are fed, a bit each.
    pub(super) fed: u32,
    /// Planned ones, then those of encoders.
    pub(super) of: [PathSpeed; 2 * Crd::MAX],
}

impl PathSpeeds {
    pub(super) const STANDSTILL: PathSpeeds = PathSpeeds { fed: 0, of: [PathSpeed::STANDSTILL; 2 * Crd::MAX] };

    /// The index of the speed of a path.
    #[inline(always)]
    pub(super) fn index(crd: Crd, encoder: bool) -> usize {
        if encoder { Crd::MAX.wrapping_add(crd.index()) } else { crd.index() }
    }

    /// Feeds one.
    #[inline(always)]
    pub(super) fn put(&mut self, index: usize, speed: PathSpeed) {
        if let Some(to) = self.of.get_mut(index) {
            *to = speed;
            self.fed |= 1 << (index & INDEX_MASK);
        }
    }
}

/// The bits of an index.
pub(super) const INDEX_MASK: usize = 2 * Crd::MAX - 1;
const _: () = assert!(2 * Crd::MAX <= 32 && INDEX_MASK & (2 * Crd::MAX) == 0, "a bit of a word each");
