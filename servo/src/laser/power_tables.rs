//! Tables of laser channels: power against velocity, ratio against position, on a line and over a
//! plane.
//!
//! In: points from the thread, one by one, in order. Out: the value of a table at a position:
//! linear (bilinear) between its points, the border's value outside. Owns: the memory of all
//! tables. Fails: a point that breaks a rule is refused and changes nothing; a table of no points
//! gives 0.
//!
//! A table is written at admission, and nothing may follow it meanwhile: a tick command that names
//! it comes after [`PowerTables::finish`]. Ratios come in two banks a channel, so that one can be
//! written while the other is in force. Each point is stored with its slope to the next one, so
//! that the tick never divides: m·2⁻ˢ with 54 bits of m, which makes an error of 2⁻⁵³ of the step
//! between the two, and half a unit.
use super::fixed_point::{nearest, product, scaled};
use super::power::{Power, Refused};
use super::{CHANNELS, fixed_point};
use crate::math::float::Float;
use crate::math::wide::narrow;
use crate::path::PathSpeed;
use crate::units::Pos;
use ring::Store;

/// Tables of powers of a channel.
pub const POWER_TABLES: usize = 8;
/// Banks of ratios of a channel.
pub const BANKS: usize = 2;
/// Points of a table; lines of a plane in each direction.
pub const POINTS: usize = 32;
/// Nodes of a plane.
pub const NODES: usize = 256;
/// Axes whose distance counts.
pub const DISTANCES: usize = 4;

const CURVES: usize = CHANNELS * (POWER_TABLES + BANKS * DISTANCES);
const WORDS: usize = 6;

/// One table of one variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Curve(u8);

impl Curve {
    /// Power against velocity: table `table` of a channel.
    pub const fn power(channel: u8, table: u8) -> Option<Curve> {
        if (channel as usize) < CHANNELS && (table as usize) < POWER_TABLES {
            Some(Curve(channel * POWER_TABLES as u8 + table))
        } else {
            None
        }
    }

    /// Ratio against the position of one of the four axes, or the lines of a plane (first 0, second
    /// 1).
    pub const fn ratio(channel: u8, bank: u8, axis: u8) -> Option<Curve> {
        if (channel as usize) < CHANNELS && (bank as usize) < BANKS && (axis as usize) < DISTANCES {
            const FIRST: u8 = (CHANNELS * POWER_TABLES) as u8;
            Some(Curve(FIRST + (channel * BANKS as u8 + bank) * DISTANCES as u8 + axis))
        } else {
            None
        }
    }

    /// Its index among all tables.
    pub(super) const fn index(self) -> u8 {
        self.0
    }

    pub(super) const fn from_index(index: u8) -> Option<Curve> {
        if (index as usize) < CURVES { Some(Curve(index)) } else { None }
    }

    fn slot(self, point: usize) -> u32 {
        (self.0 as usize * POINTS + point) as u32
    }
}

/// A point as stored: both in their fixed point, and the slope after it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct CurvePoint {
    x: i64,
    y: i64,
    /// m·2⁸ + s.
    slope: i64,
}

impl CurvePoint {
    fn words(self) -> [u32; WORDS] {
        let split = |x: i64| [x as u32, (x >> 32) as u32];
        let ([a, b], [c, d], [e, f]) = (split(self.x), split(self.y), split(self.slope));
        [a, b, c, d, e, f]
    }

    fn from_words([a, b, c, d, e, f]: [u32; WORDS]) -> CurvePoint {
        let join = |low: u32, high: u32| ((high as u64) << 32 | low as u64) as i64;
        CurvePoint { x: join(a, b), y: join(c, d), slope: join(e, f) }
    }

    /// The slope to the next point.
    fn towards(self, next: CurvePoint) -> CurvePoint {
        let rise = (next.y as i128).wrapping_sub(self.y as i128);
        let run = (next.x as i128).wrapping_sub(self.x as i128).max(1);
        let slope = Float::from_fixed(rise.unsigned_abs(), 0).div(Float::from_fixed(run as u128, 0));
        // Rounded up it may reach a power of two.
        let s = (54 - slope.width()).clamp(1, 126);
        let m = slope.to_fixed(s) as i64;
        let m = if rise < 0 { -m } else { m };
        CurvePoint { slope: m << 8 | s as i64, ..self }
    }

    /// The value at x, of which this is the point before.
    #[inline]
    fn at(self, x: i64) -> i64 {
        let by = scaled(self.slope >> 8, x.wrapping_sub(self.x) as u64);
        self.y.wrapping_add(nearest(by, self.slope as u32 & 0xff))
    }
}

/// The interval of a curve that was used last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    point: CurvePoint,
    /// It holds below this.
    end: i64,
}

impl Interval {
    /// None: it holds nowhere.
    pub(super) const NONE: Interval = Interval { point: CurvePoint { x: i64::MAX, y: 0, slope: 0 }, end: i64::MIN };
}

/// The tables of all channels.
pub struct PowerTables {
    points: Store<WORDS, { CURVES * POINTS }>,
    counts: Store<1, CURVES>,
    nodes: Store<2, { CHANNELS * BANKS * NODES }>,
    /// The most that each axis may add or take away, plus 1; 0 is no limit.
    limits: Store<2, { CHANNELS * BANKS * DISTANCES }>,
    /// Analog outputs as SetDac and paths have set them; written by the tick. 0 for one that a
    /// laser has taken.
    analog: Store<1, ANALOG_OUTPUTS>,
}

/// Analog outputs, of which the first are those of the laser channels.
pub(crate) const ANALOG_OUTPUTS: usize = 8;

impl PowerTables {
    /// All tables empty.
    pub const fn new() -> PowerTables {
        let (points, counts, nodes, limits) = (Store::new(), Store::new(), Store::new(), Store::new());
        PowerTables { points, counts, nodes, limits, analog: Store::new() }
    }

    /// The last value of an analog output, from 0, −32768…32767 for −10…10 V.
    pub fn analog(&self, output: usize) -> i16 {
        if output < ANALOG_OUTPUTS { self.analog.word(output as u32, 0) as i16 } else { 0 }
    }

    /// An analog output was set.
    pub(crate) fn set_analog(&self, output: u8, value: i16) {
        if (output as usize) < ANALOG_OUTPUTS {
            self.analog.write(output as u32, [value as u16 as u32]);
        }
    }

    /// Point `index` of a table of powers: a velocity from the bits of a fixed_point, 0 to 2³²
    /// pulse/ms, above that of the point before by 2⁻²⁸ at least.
    pub fn power_point(&self, curve: Curve, index: usize, velocity: u64, power: Power) -> Result<(), Refused> {
        let x = fixed_point::fixed(velocity, PathSpeed::FRAC_BITS as i32, 32)?;
        if x < 0 {
            return Err(Refused::Negative);
        }
        self.point(curve, index, x, power.raw(), 4)
    }

    /// Point `index` of a table of ratios: a position in pulses, above that of the point before,
    /// and the bits of a fixed_point, |ratio| ≤ 2¹⁷.
    pub fn ratio_point(&self, curve: Curve, index: usize, pulses: i32, ratio: u64) -> Result<(), Refused> {
        let y = fixed_point::fixed(ratio, Power::FRAC_BITS as i32, 17)?;
        self.point(curve, index, Pos::pulses(pulses).0, y, 1)
    }

    /// Line `index` of a plane: a position in pulses, above that of the line before.
    pub fn plane_line(&self, curve: Curve, index: usize, pulses: i32) -> Result<(), Refused> {
        // The value of this table is the number of the line.
        self.point(curve, index, Pos::pulses(pulses).0, (index as i64) << Power::FRAC_BITS, 1)
    }

    /// Node `index` of a plane (line of the first direction + their number · line of the second):
    /// the bits of a double,
    /// |ratio| ≤ 2¹⁷.
    pub fn plane_node(&self, channel: u8, bank: u8, index: usize, ratio: u64) -> Result<(), Refused> {
        let y = fixed_point::fixed(ratio, Power::FRAC_BITS as i32, 17)?;
        let slot = node(channel, bank, index).ok_or(Refused::Count)?;
        self.nodes.write(slot, [y as u32, (y >> 32) as u32]);
        Ok(())
    }

    /// The most that the distance of an axis may add to the power, or take away, with the ratios of
    /// this bank.
    pub fn limit(&self, channel: u8, bank: u8, axis: u8, most: Option<Power>) {
        if let Some(slot) = limit(channel, bank, axis) {
            let most = most.map_or(0, |most| most.raw() as u64 + 1);
            self.limits.write(slot, [most as u32, (most >> 32) as u32]);
        }
    }

    /// The same in 2⁻⁴⁴.
    pub(super) fn most(&self, channel: u8, bank: u8, axis: u8) -> Option<u64> {
        let [low, high] = limit(channel, bank, axis).map_or([0; 2], |slot| self.limits.read(slot));
        ((high as u64) << 32 | low as u64).checked_sub(1)
    }

    fn point(&self, curve: Curve, index: usize, x: i64, y: i64, gap: i64) -> Result<(), Refused> {
        if index >= POINTS {
            return Err(Refused::Count);
        }
        let point = CurvePoint { x, y, slope: 0 };
        if let Some(before) = index.checked_sub(1) {
            let last = self.read(curve, before);
            if x < last.x.saturating_add(gap) {
                return Err(Refused::NotIncreasing);
            }
            self.points.write(curve.slot(before), last.towards(point).words());
        }
        self.points.write(curve.slot(index), point.words());
        Ok(())
    }

    /// The table has this many points now.
    pub fn finish(&self, curve: Curve, count: usize) {
        self.counts.write(curve.0 as u32, [count.min(POINTS) as u32]);
    }

    /// Points of a table.
    pub fn count(&self, curve: Curve) -> usize {
        let [count] = self.counts.read(curve.0 as u32);
        count as usize
    }

    fn read(&self, curve: Curve, point: usize) -> CurvePoint {
        CurvePoint::from_words(self.points.read(curve.slot(point)))
    }

    /// The value of a table at x.
    #[inline]
    pub(super) fn at(&self, curve: Curve, x: i64, last: &mut Interval) -> i64 {
        if x < last.point.x || x >= last.end {
            *last = self.interval(curve, x);
        }
        last.point.at(x)
    }

    /// The interval of a table that holds x: found in six reads.
    #[inline(never)]
    fn interval(&self, curve: Curve, x: i64) -> Interval {
        let count = self.count(curve).min(POINTS);
        let (mut below, mut step) = (0usize, POINTS);
        // `below` points are at or before x.
        while step > 0 {
            let there = below.wrapping_add(step);
            if there <= count && self.read(curve, there.wrapping_sub(1)).x <= x {
                below = there;
            }
            step >>= 1;
        }
        let first = self.read(curve, 0);
        match below.checked_sub(1) {
            _ if count == 0 => Interval { point: CurvePoint { x: i64::MIN, ..CurvePoint::default() }, end: i64::MAX },
            None => Interval { point: CurvePoint { x: i64::MIN, y: first.y, slope: 0 }, end: first.x },
            Some(last) if below == count => {
                Interval { point: CurvePoint { slope: 0, ..self.read(curve, last) }, end: i64::MAX }
            }
            Some(last) => Interval { point: self.read(curve, last), end: self.read(curve, below).x },
        }
    }

    /// The ratio of a plane between its nodes; u and v count lines in 2⁻⁴⁴.
    pub(super) fn plane(&self, channel: u8, bank: u8, lines: usize, u: i64, v: i64) -> i64 {
        const PART_MASK: i64 = (1 << Power::FRAC_BITS) - 1;
        let (iu, iv) = ((u >> Power::FRAC_BITS) as usize, (v >> Power::FRAC_BITS) as usize);
        let value = |iu: usize, iv: usize| {
            let [low, high] = node(channel, bank, iu.wrapping_add(iv.wrapping_mul(lines)))
                .map_or([0; 2], |slot| self.nodes.read(slot));
            ((high as u64) << 32 | low as u64) as i64
        };
        let mix = |a: i64, b: i64, part: i64| {
            let by = product(b.wrapping_sub(a), part);
            a.wrapping_add(narrow(by, Power::FRAC_BITS as i32))
        };
        let (fu, fv) = (u & PART_MASK, v & PART_MASK);
        let row = |iv: usize| {
            let a = value(iu, iv);
            if fu == 0 { a } else { mix(a, value(iu.wrapping_add(1), iv), fu) }
        };
        let a = row(iv);
        if fv == 0 { a } else { mix(a, row(iv.wrapping_add(1)), fv) }
    }
}

/// Slot of an axis's limit.
fn limit(channel: u8, bank: u8, axis: u8) -> Option<u32> {
    let fits = (channel as usize) < CHANNELS && (bank as usize) < BANKS && (axis as usize) < DISTANCES;
    fits.then(|| ((channel as usize * BANKS + bank as usize) * DISTANCES + axis as usize) as u32)
}

/// Slot of a node.
fn node(channel: u8, bank: u8, index: usize) -> Option<u32> {
    let fits = (channel as usize) < CHANNELS && (bank as usize) < BANKS && index < NODES;
    fits.then(|| ((channel as usize * BANKS + bank as usize) * NODES + index) as u32)
}
