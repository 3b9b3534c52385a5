//! Buffered laser commands: changes that entries of a path carry (GUS chapter 4, LSR chapter 3;
//! SPEC 4 and 6).
//!
//! In: requests with the user's doubles, the shadow state of the channel. Out: the FIFO, the entry,
//! the values to report. The FIFO's own checks are those of every entry of a path
//! (`admit::crd_data`).
//! Fails: as every laser command does. Ranges are those of the power mode at the call; the tick
//! limits to what a later mode allows.
use super::Context;
use super::distance::source;
use super::energy::{direct_powers, limited, own_bounds, power, powers};
use super::power_range::RangeLimiter;
use super::tables::table;
use crate::admit::crd_data::{self, DataCommand, EntryKind, FifoItem, Target};
use crate::admit::one;
use crate::admit::written::{Paths, Stored, TakenValues, taken_values};
use crate::refuse::{Admitted, Refused, finite};
use crate::report::answer::TAKEN_MAX_VALUES;
use protocol::command::{
    BufLaserFollowMode, BufLaserFollowOff, BufLaserFollowRatio, BufLaserFollowTable, BufLaserOff, BufLaserOn,
    BufLaserPrfCmd, BufLaserPrfFollow, opcode,
};
use protocol::reason::Reason;
use protocol::values::FULL_SCALE;
use servo::laser::{Buffered, Curve, Power, PowerBounds, Ratio};
use servo::path::PathEntry;
use servo::units::CrdMask;

/// Velocity ratios may be this large: 2³².
const VELOCITY_RATIO_MAX: f64 = FULL_SCALE;

/// Admits a buffered laser command and puts its entry into the FIFO. The reply reports the values
/// taken, if there are any, else the free slots.
/// A function of its own, as `follow_data`.
#[inline(never)]
pub fn data<const AXES: usize>(context: &Context<AXES>, paths: Paths, number: u16, body: &[u8]) -> Stored {
    crd_data::put(context, paths, &context.laser_entry(number, body)?)
}

/// Power per speed: above 0 in both families.
fn ratio(field: u8, got: f64) -> Admitted<Ratio> {
    finite(field, got)?;
    let refused = Refused::new(Reason::AboveLow).field(field).got(got).limits(0.0, VELOCITY_RATIO_MAX);
    Ratio::admit(got.to_bits()).map_err(|_| refused)
}

impl<const AXES: usize> Context<'_, AXES> {
    /// The entry of a buffered laser command.
    fn laser_entry(&self, number: u16, body: &[u8]) -> Admitted<DataCommand> {
        let mut named = None;
        /// `$fifo` and `$channel` are fields.
        macro_rules! to {
            ($name:ident, $fifo:literal, $channel:literal, |$r:ident, $of:ident| $change:expr) => {{
                let $r = &one::<$name>(body)?;
                let $of = self.channel($r.core.get(), $channel, $r.channel.get())?;
                self.mapped($r.core.get(), $r.crd.get(), $of)?;
                let (change, took): (Buffered, Option<TakenValues>) = $change;
                let (code, words) = change.pack();
                let target = Target { core: $r.core.get(), crd: $r.crd.get(), fifo: $r.fifo.get(), fifo_field: $fifo };
                (target, FifoItem::Entry(PathEntry::laser($of, code, words), EntryKind::Laser { named, took }))
            }};
        }
        Ok(match number {
            opcode::BufLaserOn => to!(BufLaserOn, 2, 3, |r, channel| {
                self.connected(channel)?;
                (Buffered::Gate { on: true }, None)
            }),
            opcode::BufLaserOff => to!(BufLaserOff, 2, 3, |r, _channel| (Buffered::Gate { on: false }, None)),
            opcode::BufLaserPrfCmd => to!(BufLaserPrfCmd, 3, 4, |r, channel| {
                let (power, took) = self.direct_power(channel, (2, r.power.get()))?;
                (Buffered::Direct { power }, Some(took))
            }),
            opcode::BufLaserPrfFollow => to!(BufLaserPrfFollow, 5, 6, |r, channel| {
                let ratio = ratio(2, r.ratio.get())?;
                let (bounds, took) = self.follow_bounds(channel, (3, r.min.get().into()), (4, r.max.get().into()))?;
                (Buffered::PrfFollow { ratio, bounds }, Some(took))
            }),
            opcode::BufLaserFollowMode => to!(BufLaserFollowMode, 3, 4, |r, channel| {
                let source = source(2, r.source.get())?;
                let given = r.start_given != 0;
                let start = given.then(|| self.direct_power(channel, (5, r.start_power.get()))).transpose()?;
                let took = start.map_or(([0.0; TAKEN_MAX_VALUES], 1, 0), |(_, took)| took);
                (Buffered::FollowMode { source, start: start.map(|(power, _)| power) }, Some(took))
            }),
            opcode::BufLaserFollowRatio => to!(BufLaserFollowRatio, 5, 6, |r, channel| {
                let ratio = ratio(2, r.ratio.get())?;
                let (bounds, took) = self.follow_bounds(channel, (3, r.min.get()), (4, r.max.get()))?;
                (Buffered::FollowRatio { ratio, bounds }, Some(took))
            }),
            opcode::BufLaserFollowTable => to!(BufLaserFollowTable, 5, 6, |r, channel| {
                let table = table(2, r.table.get())?;
                let (bounds, took) = self.follow_bounds(channel, (3, r.min.get()), (4, r.max.get()))?;
                let empty = Refused::new(Reason::FollowTableEmpty).got(r.table.get().into());
                let empty = empty.limits(channel.into(), 0.0);
                let curve = Curve::power(channel, table).filter(|_| self.laser(channel).is_filled(table));
                named = Some((channel, table));
                (Buffered::FollowTable { table: curve.ok_or(empty)?, bounds }, Some(took))
            }),
            _ => to!(BufLaserFollowOff, 2, 3, |r, _channel| (Buffered::FollowOff, None)),
        })
    }

    /// A coordinate system lights only channels whose map holds it.
    fn mapped(&self, core: i16, crd: i16, channel: u8) -> Admitted<()> {
        let crd = self.crd(core, crd)?;
        if CrdMask(self.laser(channel).map).has(crd) {
            return Ok(());
        }
        Err(self.no_crd(Reason::LaserNotMapped, crd).got(channel.into()))
    }

    /// A direct power, with its field.
    fn direct_power(&self, channel: u8, (field, got): (u8, f64)) -> Admitted<(Power, TakenValues)> {
        let shadow = self.laser(channel);
        let range = direct_powers(shadow.mode, self.is_lsr(), self.shadows.high_resolution);
        let mut taking = RangeLimiter::new(self.is_lsr());
        let value = taking.take(field, 0, got, range)?;
        let power = power(field, value)?;
        let limited = limited(shadow.mode, shadow.width_us, shadow.bounds.hold(power));
        Ok((power, taken_values(&[value], taking.limited | limited)))
    }

    /// Bounds of a velocity follow: the maximum is above the minimum (LSR, BufLaserFollowRatio), as
    /// given. Values that LSR limits may become equal.
    fn follow_bounds(&self, channel: u8, min: (u8, f64), max: (u8, f64)) -> Admitted<(PowerBounds, TakenValues)> {
        let shadow = self.laser(channel);
        let mode = shadow.mode;
        let range = powers(mode, self.is_lsr(), self.shadows.high_resolution);
        if max.1 <= min.1 {
            return Err(Refused::new(Reason::NotAboveMinimum)
                .field(max.0)
                .got(max.1)
                .limits(min.1, range.nearest(f64::MAX)));
        }
        let mut taking = RangeLimiter::new(self.is_lsr());
        let (low, high) = (taking.take(min.0, 1, min.1, range)?, taking.take(max.0, 0, max.1, range)?);
        let bounds = own_bounds(mode, (min.0, low), (max.0, high))?;
        // The highest power of the follow.
        let limited = limited(mode, shadow.width_us, shadow.bounds.hold(bounds.max()));
        Ok((bounds, taken_values(&[high, low], taking.limited | limited)))
    }
}
