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

/// A segment as FollowDataPercent2Ex gives it: from one ratio to another, with so much of S-shape
/// at both ends together. Its displacement decides how much of that lies at its beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asymmetric {
    pub master: f64,
    pub slave: f64,
    pub ratios: [f64; 2],
    pub percent: i16,
}

/// What lies in a FIFO.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Item {
    Segment(Datum),
    Asymmetric(Asymmetric),
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
    /// One with the same ends, if it is a segment.
    pub fn segment(&self) -> Option<Datum> {
        match *self {
            Item::Segment(datum) => Some(datum),
            Item::Asymmetric(Asymmetric { master, slave, .. }) => Some(Datum { master, slave, kind: 0, percent: 0 }),
            _ => None,
        }
    }
}

/// Mean of a ratio that goes from `begin` to `end`: its slope rises over the share `x`, and falls
/// over `q` − `x`.
pub fn mean(begin: &Rational, end: &Rational, q: &Rational, x: &Rational) -> Rational {
    let whole = |x: i64| Rational::from_integer(x.into());
    let two = whole(2);
    let by_change = whole(1) / &two - x / &two + q * (&two * x - q) / whole(6);
    begin + (end - begin) * by_change / (whole(1) - q / &two)
}

impl Asymmetric {
    fn shape(&self) -> [Rational; 3] {
        let q = Rational::from_integer(self.percent.into()) / Rational::from_integer(100.into());
        [exact(self.ratios[0]), exact(self.ratios[1]), q]
    }

    /// How much of its S-shape lies at its beginning, after a segment that ends here; none: no
    /// share gives the displacement.
    pub fn first(&self, from: f64, begin: f64) -> Option<Rational> {
        let ([r0, r1, q], zero) = (self.shape(), Rational::zero());
        let wanted = (exact(self.slave) - exact(begin)) / (exact(self.master).abs() - exact(from).abs());
        let (one, other) = (mean(&r0, &r1, &q, &zero), mean(&r0, &r1, &q, &q));
        let (low, high) = if one < other { (&one, &other) } else { (&other, &one) };
        // One outside by the rounding of the user's doubles alone counts as the bound.
        let rounding = (r0.abs() + r1.abs()) * exact(2f64.powi(-49));
        if wanted < low - &rounding || wanted > high + &rounding {
            return None;
        }
        if one == other {
            return Some(q / Rational::from_integer(2.into()));
        }
        let x = &q * (&one - wanted) / (one - other);
        Some(if x < zero {
            zero
        } else if x > q {
            q
        } else {
            x
        })
    }

    /// Lengths of its three parts, as shares of it.
    pub fn parts(&self, from: f64, begin: f64) -> Option<[Rational; 3]> {
        let ([_, _, q], x) = (self.shape(), self.first(from, begin)?);
        Some([x.clone(), Rational::from_integer(1.into()) - &q, q - x])
    }

    /// Appends it to a function of progress.
    fn append(&self, curve: &mut Curve, from: f64, begin: f64) {
        let Some([rise, held, fall]) = self.parts(from, begin) else { return };
        let (whole, [r0, r1, q]) = (|x: i64| Rational::from_integer(x.into()), self.shape());
        let length = exact(self.master).abs() - exact(from).abs();
        let top = (&r1 - &r0) / (&length * (whole(1) - q / whole(2)));
        let [rise, held, fall] = [rise, held, fall].map(|share| share * &length);
        let mut ratio = r0;
        if rise.is_positive() {
            curve.cubic(&rise, &ratio, &Rational::zero(), &(&top / &rise));
            ratio = ratio + &top * &rise / whole(2);
        }
        if held.is_positive() {
            curve.cubic(&held, &ratio, &top, &Rational::zero());
            ratio = ratio + &top * &held;
        }
        if fall.is_positive() {
            curve.cubic(&fall, &ratio, &top, &-(&top / &fall));
        }
    }
}

/// Slots that a FIFO's items take.
pub fn slots(items: &[Item]) -> usize {
    let (mut from, mut begin, mut count) = (0.0, 0.0, 0);
    for item in items {
        count += match item {
            Item::Asymmetric(of) => {
                let length = exact(of.master).abs() - exact(from).abs();
                // One that is too short to be a segment is left out.
                let shortest = Rational::from_integer(1.into()) / Rational::from_integer((1 << 20).into());
                let parts = of
                    .parts(from, begin)
                    .map_or(0, |parts| parts.iter().filter(|share| *share * &length >= shortest).count());
                parts.max(1)
            }
            _ => 1,
        };
        if let Some(Datum { master, slave, .. }) = item.segment() {
            (from, begin) = (master, slave);
        }
    }
    count
}

/// Segments of a FIFO.
pub fn segments(items: &[Item]) -> impl DoubleEndedIterator<Item = Datum> {
    items.iter().filter_map(|item| item.segment())
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
            if let Item::Asymmetric(of) = item {
                is_first = false;
                given.take_if(|(from, _)| *from <= index);
                let last = segments(&items[..index]).next_back();
                let (at, value) = last.map_or((0.0, 0.0), |last| (last.master, last.slave));
                of.append(&mut curve, at, value);
                curve.ends_at(Fix::of(&exact(of.slave)));
                curve.reaches(Fix::of(&exact(of.master).abs()));
                (from, begin, ratio) = (exact(of.master).abs(), exact(of.slave), exact(of.ratios[1]));
            }
            if let Item::Segment(datum) = item {
                let (master, slave) = (exact(datum.master).abs(), exact(datum.slave));
                let (length, displacement) = (&master - &from, &slave - &begin);
                let mean = &displacement / &length;
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
