//! What FIFOs of Follow and FollowEx hold, and the function of progress that it makes.
use super::curve::Curve;
use super::number::{Fix, exact};
use super::rational::Rational;

/// A segment as FollowData gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Datum {
    pub master: f64,
    pub slave: f64,
    pub kind: i16,
    pub percent: i16,
}

/// What lies in a FIFO.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Item {
    Segment(Datum),
    /// FollowDoBitEx of a general output, from 1.
    Output {
        index: i16,
        level: bool,
    },
    /// FollowDelayEx, in units of 250 µs.
    Delay {
        cycles: u32,
    },
    /// FollowDiBitEx of a general input, from 1; 0 ms: for ever.
    Wait {
        index: i16,
        level: bool,
        ms: u32,
    },
    /// FollowSwitchNowEx with `buffer` 1.
    Switch {
        table: bool,
    },
}

impl Item {
    pub fn segment(&self) -> Option<&Datum> {
        if let Item::Segment(datum) = self { Some(datum) } else { None }
    }
}

/// Segments of a FIFO.
pub fn segments(items: &[Item]) -> impl DoubleEndedIterator<Item = &Datum> {
    items.iter().filter_map(Item::segment)
}

/// Whether its master positions are negative.
pub fn is_down(items: &[Item]) -> bool {
    segments(items).next().is_some_and(|first| first.master < 0.0)
}

/// A FIFO's function of progress.
#[derive(Debug, Clone)]
pub struct Table {
    pub curve: Curve,
    /// Where each item begins, and where the last one ends: progress and slave.
    pub knots: Vec<(Fix, Fix)>,
    /// The ratio with which each item ends.
    pub ratios: Vec<Rational>,
}

impl Table {
    /// After a FIFO that ended at the ratio `carried`, per progress of this one. The first segment
    /// from an item on begins with a ratio that is `given`.
    pub fn new(items: &[Item], carried: &Rational, given: Option<&(usize, Rational)>) -> Table {
        let mut curve = Curve::default();
        let (mut from, mut begin, mut ratio) = (Rational::zero(), Rational::zero(), Rational::zero());
        let mut knots = vec![(Fix::ZERO, Fix::ZERO)];
        let mut ratios = Vec::new();
        let mut given = given;
        let mut is_first = true;
        for (index, item) in items.iter().enumerate() {
            if let Item::Segment(datum) = item {
                let (master, slave) = (exact(datum.master).abs(), exact(datum.slave));
                let (length, way) = (&master - &from, &slave - &begin);
                let mean = &way / &length;
                let twice = &mean + &mean;
                if datum.kind == 3 && std::mem::take(&mut is_first) {
                    ratio = carried.clone();
                }
                is_first = false;
                if let Some((_, given)) = given.take_if(|(from, _)| *from <= index) {
                    ratio = given.clone();
                }
                let (first, last) = match datum.kind {
                    1 => (mean.clone(), mean),
                    2 => (twice, Rational::zero()),
                    _ => (ratio.clone(), twice - ratio),
                };
                shaped(&mut curve, &length, &first, &last, &Rational::from_integer(datum.percent.into()));
                curve.ends_at(Fix::of(&slave));
                curve.reaches(Fix::of(&master));
                (from, begin, ratio) = (master, slave, last);
            }
            knots.push((curve.length(), curve.end()));
            ratios.push(ratio.clone());
        }
        Table { curve, knots, ratios }
    }

    /// The ratio before an item, `none` before the first segment.
    pub fn ratio_before(&self, index: usize, none: &Rational) -> Rational {
        index.checked_sub(1).map_or(none, |before| &self.ratios[before]).clone()
    }
}

/// From one slope to another over a length: the slope's change ramps for percent/200 of it, holds,
/// and ramps down.
pub fn shaped(curve: &mut Curve, length: &Rational, first: &Rational, last: &Rational, percent: &Rational) {
    let whole = |x: i64| Rational::from_integer(x.into());
    let change = last - first;
    if percent.is_zero() || change.is_zero() {
        curve.cubic(length, first, &(change / length), &Rational::zero());
        return;
    }
    let share = percent / whole(200);
    let ramp = length * &share;
    let top = &change / (length * (whole(1) - &share));
    let jerk = &top / &ramp;
    curve.cubic(&ramp, first, &Rational::zero(), &jerk);
    let begin = first + &top * &ramp / whole(2);
    let flat = length - &ramp * whole(2);
    if flat.is_positive() {
        curve.cubic(&flat, &begin, &top, &Rational::zero());
    }
    curve.cubic(&ramp, &(begin + &top * &flat), &top, &-jerk);
}
