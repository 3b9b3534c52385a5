//! PVT tables of every kind, as functions of the time since their first point.
use super::curve::Curve;
use super::follow::shaped;
use super::number::{Fix, exact, root};
use super::rational::Rational;

/// Points as the calls give them, all of one kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Points {
    /// Time, position, velocity.
    Pvt(Vec<[f64; 3]>),
    /// Time, position, velocities at the begin and at the end of the segment that follows.
    Ex(Vec<[f64; 4]>),
    /// Time and position; velocities at the first and the last point.
    Complete(Vec<[f64; 2]>, f64, f64),
    /// Time, position, percent; the first velocity.
    Percent(Vec<[f64; 3]>, f64),
    /// Position, velocity, percent, greatest velocity, acceleration, deceleration; time of the
    /// first point.
    Continuous(Vec<[f64; 6]>, f64),
}

/// A table: when it begins, and what it does from there.
#[derive(Debug, Clone)]
pub struct Table {
    pub begins: Fix,
    pub curve: Curve,
}

fn whole(x: i64) -> Rational {
    Rational::from_integer(x.into())
}

/// The cubic through two points with velocities at both.
fn hermite(curve: &mut Curve, length: &Rational, displacement: &Rational, first: &Rational, last: &Rational) {
    let mean = displacement / length;
    let bend = (whole(3) * &mean - whole(2) * first - last) / length;
    let third = (first + last - whole(2) * &mean) / (length * length);
    curve.cubic(length, first, &(bend * whole(2)), &(third * whole(6)));
}

impl Points {
    pub fn count(&self) -> usize {
        match self {
            Points::Pvt(points) | Points::Percent(points, _) => points.len(),
            Points::Ex(points) => points.len(),
            Points::Complete(points, ..) => points.len(),
            Points::Continuous(points, _) => points.len(),
        }
    }

    /// What PvtPercentCalculate or PvtContinuousCalculate gives: velocities, or times from 0.
    pub fn calculated(&self) -> Vec<f64> {
        let mut values = Vec::new();
        match self {
            Points::Percent(points, begin) => {
                let mut v = exact(*begin);
                values.push(*begin);
                for pair in points.windows(2) {
                    let ([t, p, _], [u, q, _]) = (pair[0].map(exact), pair[1].map(exact));
                    v = whole(2) * (q - p) / (u - t) - v;
                    values.push(Fix::of(&v).to_f64());
                }
            }
            Points::Continuous(points, _) => {
                let mut time = Rational::zero();
                values.push(0.0);
                for pair in points.windows(2) {
                    let Ramps { up, cruise, down, .. } = Ramps::of(&pair[0], &pair[1]);
                    time = time + up + cruise + down;
                    values.push(Fix::of(&time).to_f64());
                }
            }
            _ => {}
        }
        values
    }

    /// Times, positions and velocities of tables that are cubic between their points.
    fn cubics(&self) -> Vec<[Rational; 4]> {
        match self {
            Points::Pvt(points) => {
                let next = |index: usize| points.get(index + 1).map_or(0.0, |point| point[2]);
                let each = points.iter().enumerate();
                each.map(|(index, point)| [point[0], point[1], point[2], next(index)].map(exact)).collect()
            }
            Points::Ex(points) => points.iter().map(|point| point.map(exact)).collect(),
            Points::Complete(points, begin, end) => {
                let points: Vec<[Rational; 2]> = points.iter().map(|point| point.map(exact)).collect();
                let velocities = clamped(&points, &exact(*begin), &exact(*end));
                let next = |index: usize| velocities.get(index + 1).cloned().unwrap_or_else(Rational::zero);
                let each = points.iter().enumerate();
                each.map(|(index, [t, p])| [t.clone(), p.clone(), velocities[index].clone(), next(index)]).collect()
            }
            Points::Percent(..) | Points::Continuous(..) => Vec::new(),
        }
    }

    pub fn table(&self) -> Table {
        match self {
            Points::Percent(points, begin) => percent(points, *begin),
            Points::Continuous(points, begin) => continuous(points, *begin),
            _ => {
                let rows = self.cubics();
                let mut curve = Curve::default();
                for pair in rows.windows(2) {
                    let ([t, p, v, w], [u, q, ..]) = (&pair[0], &pair[1]);
                    hermite(&mut curve, &(u - t), &(q - p), v, w);
                    curve.ends_at(Fix::of(&(q - &rows[0][1])));
                }
                Table { begins: Fix::of(&rows[0][0]), curve }
            }
        }
    }
}

/// Velocities with which the acceleration is continuous: v(i−1)/h + 2·(1/h + 1/g)·v(i) + v(i+1)/g =
/// 3·(d/h² + e/g²) for segments of lengths h, g and ways d, e.
fn clamped(points: &[[Rational; 2]], begin: &Rational, end: &Rational) -> Vec<Rational> {
    let mut rows = vec![(Rational::zero(), begin.clone())];
    for three in points.windows(3) {
        let [[t, p], [u, q], [w, r]] = three else { continue };
        let (h, g) = (u - t, w - u);
        let right = whole(3) * ((q - p) / (&h * &h) + (r - q) / (&g * &g));
        let (c, d) = &rows[rows.len() - 1];
        let pivot = whole(2) * (h.recip() + g.recip()) - c / &h;
        rows.push(((&g * &pivot).recip(), (right - d / &h) / pivot));
    }
    let mut velocities = vec![end.clone()];
    for (c, d) in rows.into_iter().skip(1).rev() {
        velocities.push(d - c * &velocities[velocities.len() - 1]);
    }
    velocities.push(begin.clone());
    velocities.reverse();
    velocities
}

fn percent(points: &[[f64; 3]], begin: f64) -> Table {
    let mut curve = Curve::default();
    let mut v = exact(begin);
    for pair in points.windows(2) {
        let ([t, p, percent], [u, q, _]) = (pair[0].map(exact), pair[1].map(exact));
        let length = &u - t;
        let last = whole(2) * (&q - p) / &length - &v;
        shaped(&mut curve, &length, &v, &last, &percent);
        curve.reaches(Fix::of(&(u - exact(points[0][0]))));
        curve.ends_at(Fix::of(&(q - exact(points[0][1]))));
        v = last;
    }
    Table { begins: Fix::of_f64(points[0][0]), curve }
}

/// A segment of PvtTableContinuous: how long its ramps and its cruise last, and how fast that is.
struct Ramps {
    up: Rational,
    cruise: Rational,
    down: Rational,
    peak: Rational,
    sign: Rational,
}

impl Ramps {
    fn of(begin: &[f64; 6], end: &[f64; 6]) -> Ramps {
        let ([p, v, _, most, acc, dec], [q, w, ..]) = (begin.map(exact), end.map(exact));
        let displacement = q - p;
        let sign = if displacement.is_negative() { whole(-1) } else { whole(1) };
        let (from, to, length) = (v * &sign, w * &sign, displacement * &sign);
        let square = (whole(2) * &acc * &dec * &length + &dec * &from * &from + &acc * &to * &to) / (&acc + &dec);
        let peak = root(&square).rational().min(most);
        let (up, down) = ((&peak - &from) / &acc, (&peak - &to) / &dec);
        let ramps = (&from + &peak) / whole(2) * &up + (&peak + &to) / whole(2) * &down;
        let cruise = (&length - ramps) / &peak;
        Ramps { up, cruise, down, peak, sign }
    }
}

fn continuous(points: &[[f64; 6]], begin: f64) -> Table {
    let mut curve = Curve::default();
    for pair in points.windows(2) {
        let Ramps { up, cruise, down, peak, sign } = Ramps::of(&pair[0], &pair[1]);
        let [v, percent] = [pair[0][1], pair[0][2]].map(exact);
        let (q, w) = (exact(pair[1][0]), exact(pair[1][1]));
        if up.is_positive() {
            shaped(&mut curve, &up, &v, &(&peak * &sign), &percent);
        }
        if cruise > Rational::dyadic(1.into(), -50) {
            curve.cubic(&cruise, &(&peak * &sign), &Rational::zero(), &Rational::zero());
        }
        if down.is_positive() {
            shaped(&mut curve, &down, &(&peak * &sign), &w, &percent);
        }
        curve.ends_at(Fix::of(&(q - exact(points[0][0]))));
    }
    Table { begins: Fix::of_f64(begin), curve }
}
