//! PVT tables on the bench: built from points, run tick by tick, and compared with a reference. The
//! reference is computed in 256 fraction bits from the doubles as given, in its own way: phases of
//! constant jerk over real time instead of Hermite pieces over a parameter.
use dispatcher::Refused;
use dispatcher::plan::pvt::{FieldIndices, Scratch, SplineScratch, TableDraft, TableKind};
use num_bigint::{BigInt, Sign};
use num_traits::{Signed, ToPrimitive, Zero};
use servo::segment::generator_state::GeneratorState;
use servo::segment::pvt::{HEADER_WORDS, Header, POINT_WORDS, PointStore, PvtTables};
use servo::units::{Exact, Ns, StepLimit};

pub(crate) use crate::chance;
use crate::drive::{Pvt, Step};

pub const BITS: usize = 256;
pub const FIELDS: FieldIndices = FieldIndices { count: 2, whole: 4, point: 10 };

/// Tables as the tick reads them.
#[derive(Default, Clone)]
pub struct Shelf(pub Vec<([u32; HEADER_WORDS], Vec<[u32; POINT_WORDS]>)>);

impl PvtTables for Shelf {
    fn point(&self, table: u8, index: u32) -> [u32; POINT_WORDS] {
        self.0.get(table as usize).and_then(|t| t.1.get(index as usize)).copied().unwrap_or_default()
    }
    fn header(&self, table: u8) -> [u32; HEADER_WORDS] {
        self.0.get(table as usize).map(|t| t.0).unwrap_or_default()
    }
}

impl Shelf {
    /// Builds a table and adds it to the shelf; returns the answers of the points.
    pub fn add(&mut self, kind: TableKind, points: &[Vec<f64>]) -> Result<Vec<f64>, Refused> {
        let (mut beside, room) = (Box::new(SplineScratch::new()), Box::new(PointStore::new()));
        let mut scratch = Scratch::new(&mut beside, &room);
        let mut draft =
            TableDraft::begin(kind, points.len() as i32, FIELDS, StepLimit::FULL_SCALE, true, &mut scratch)?;
        let mut answers = Vec::new();
        for point in points {
            answers.push(draft.point(point, &mut scratch)?);
        }
        let sealed = draft.finish(&mut scratch).expect("complete")?;
        let places = (0..sealed.points()).map(|i| sealed.point(&scratch, i).expect("every place fits")).collect();
        self.0.push((sealed.header().admit().expect("admitted"), places));
        Ok(answers)
    }

    pub fn header_of(&self, table: usize) -> Header {
        Header::from_words(self.0[table].0)
    }
}

/// A double as a whole number of 2^-BITS; every double used here is one.
pub fn big(x: f64) -> BigInt {
    let raw = x.to_bits();
    let exponent = (raw >> 52 & 0x7ff) as i64;
    let fraction = raw & ((1 << 52) - 1);
    let mantissa = if exponent == 0 { fraction } else { 1 << 52 | fraction };
    let shift = exponent.max(1) - 1075 + BITS as i64;
    let magnitude = BigInt::from_bytes_le(Sign::Plus, &mantissa.to_le_bytes());
    let magnitude = if shift >= 0 {
        magnitude << shift as usize
    } else {
        assert!(mantissa & ((1 << (-shift).min(63)) - 1) == 0, "{x} has bits below the reference's");
        magnitude >> (-shift) as usize
    };
    if x < 0.0 { -magnitude } else { magnitude }
}
pub fn whole(x: i64) -> BigInt {
    BigInt::from(x) << BITS
}
pub fn mul(a: &BigInt, b: &BigInt) -> BigInt {
    (a * b) >> BITS
}
pub fn div(a: &BigInt, b: &BigInt) -> BigInt {
    (a << BITS) / b
}
pub fn root(a: &BigInt) -> BigInt {
    (a << BITS).sqrt()
}
pub fn float(x: &BigInt) -> f64 {
    let keep = x.bits() as i64 - 64;
    if keep <= 0 {
        return x.to_f64().unwrap() * 2f64.powi(-(BITS as i32));
    }
    (x >> keep as usize).to_f64().unwrap() * 2f64.powi(keep as i32 - BITS as i32)
}
/// ns in ms.
pub fn ms(ns: i128) -> BigInt {
    (BigInt::from(ns) << BITS) / BigInt::from(1_000_000)
}

/// Whole ns of a time in ms, rounded down.
pub fn ns(ms: &BigInt) -> u64 {
    let whole: BigInt = (ms * 1_000_000) >> BITS;
    whole.to_u64().expect("not negative")
}

/// A phase of constant jerk: from `begin` (ms from the first point) on, the position is c0 + c1·t +
/// c2·t² + c3·t³ of the time since.
#[derive(Clone, Debug)]
pub struct Phase {
    pub begin: BigInt,
    pub c: [BigInt; 4],
}

/// A pass as a function of time.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    pub delay: BigInt,
    pub phases: Vec<Phase>,
    pub duration: BigInt,
    pub displacement: BigInt,
}

impl Reference {
    fn index(&self, t: &BigInt) -> usize {
        self.phases.partition_point(|phase| phase.begin <= *t).max(1) - 1
    }
    pub fn pos(&self, t: &BigInt) -> BigInt {
        let Phase { begin, c } = &self.phases[self.index(t)];
        let t = t - begin;
        &c[0] + mul(&(&c[1] + mul(&(&c[2] + mul(&c[3], &t)), &t)), &t)
    }
    pub fn vel(&self, t: &BigInt) -> BigInt {
        let Phase { begin, c } = &self.phases[self.index(t)];
        let t = t - begin;
        &c[1] + mul(&(&c[2] * 2 + mul(&(&c[3] * 3), &t)), &t)
    }
    /// The largest speed.
    pub fn peak(&self) -> f64 {
        let mut peak = 0f64;
        for (i, phase) in self.phases.iter().enumerate() {
            let end = self.phases.get(i + 1).map_or(&self.duration, |next| &next.begin);
            let length = end - &phase.begin;
            let [_, c1, c2, c3] = &phase.c;
            let at = |t: &BigInt| float(&(c1 + mul(&(c2 * 2 + mul(&(c3 * 3), t)), t))).abs();
            peak = peak.max(at(&BigInt::zero())).max(at(&length));
            if !c3.is_zero() {
                let top = div(&-c2.clone(), &(c3 * 3));
                if top.is_positive() && top < length {
                    peak = peak.max(at(&top));
                }
            }
        }
        peak
    }
    /// The phases present within `unit` of `t`.
    fn near(&self, t: &BigInt, unit: &BigInt) -> std::ops::RangeInclusive<usize> {
        self.index(&(t - unit))..=self.index(&(t + unit))
    }
    fn length(&self, i: usize) -> BigInt {
        self.phases.get(i + 1).map_or(&self.duration, |next| &next.begin) - &self.phases[i].begin
    }
    /// Length of the shortest of them, ms.
    pub fn shortest(&self, t: &BigInt, unit: &BigInt) -> f64 {
        self.near(t, unit).map(|i| float(&self.length(i))).fold(f64::INFINITY, f64::min)
    }
    /// Whether the velocity jumps between two of them.
    pub fn jumps(&self, t: &BigInt, unit: &BigInt) -> bool {
        self.near(t, unit).skip(1).any(|i| {
            let (Phase { c: [_, c1, c2, c3], .. }, length) = (&self.phases[i - 1], self.length(i - 1));
            let end = c1 + mul(&(c2 * 2 + mul(&(c3 * 3), &length)), &length);
            // More than the rounding of the reference.
            (end - &self.phases[i].c[1]).abs() > whole(1) >> 60
        })
    }
    /// The tolerance of SPEC 11, in pulses.
    pub fn allowed(&self) -> f64 {
        let travel = self.peak() * float(&self.duration);
        2f64.powi(-16).max(travel * 2f64.powi(-40))
    }
    fn hermite(&mut self, t0: &BigInt, t1: &BigInt, p0: &BigInt, p1: &BigInt, v0: &BigInt, v1: &BigInt) {
        let l = t1 - t0;
        let slope = div(&(p1 - p0), &l);
        let c2 = div(&(&slope * 3 - v0 * 2 - v1), &l);
        let c3 = div(&div(&(v0 + v1 - &slope * 2), &l), &l);
        self.phases.push(Phase { begin: t0.clone(), c: [p0.clone(), v0.clone(), c2, c3] });
    }
    /// A ramp of duration `t` from v0 to v1 with a percentage; returns its displacement.
    fn ramp(&mut self, begin: &BigInt, p0: &BigInt, t: &BigInt, v0: &BigInt, v1: &BigInt, percent: &BigInt) {
        let h: BigInt = mul(t, percent) / 200;
        let a = div(&(v1 - v0), &(t - &h));
        let hold: BigInt = t - &h * 2;
        let (mut begin, mut p, mut v) = (begin.clone(), p0.clone(), v0.clone());
        if h.is_positive() {
            let jerk = div(&a, &h);
            let c = [p.clone(), v.clone(), BigInt::zero(), &jerk / 6];
            self.phases.push(Phase { begin: begin.clone(), c });
            p += mul(&v, &h) + mul(&a, &mul(&h, &h)) / 6;
            v += mul(&a, &h) / 2;
            begin += &h;
        }
        if hold.is_positive() {
            self.phases.push(Phase { begin: begin.clone(), c: [p.clone(), v.clone(), &a / 2, BigInt::zero()] });
            p += mul(&v, &hold) + mul(&a, &mul(&hold, &hold)) / 2;
            v += mul(&a, &hold);
            begin += &hold;
        }
        if h.is_positive() {
            let jerk = div(&a, &h);
            self.phases.push(Phase { begin, c: [p, v, &a / 2, -jerk / 6] });
        }
    }

    /// The motion that the points define.
    pub fn of(kind: TableKind, points: &[Vec<f64>]) -> Reference {
        let b: Vec<Vec<BigInt>> = points.iter().map(|p| p.iter().map(|x| big(*x)).collect()).collect();
        let mut r = Reference::default();
        let last = b.len() - 1;
        if let TableKind::Continuous { time_begin } = kind {
            r.continuous(&b);
            r.delay = big(time_begin);
            r.displacement = &b[last][0] - &b[0][0];
            return r;
        }
        r.delay = b[0][0].clone();
        r.duration = &b[last][0] - &b[0][0];
        r.displacement = &b[last][1] - &b[0][1];
        let t: Vec<BigInt> = b.iter().map(|p| &p[0] - &b[0][0]).collect();
        let p: Vec<BigInt> = b.iter().map(|q| &q[1] - &b[0][1]).collect();
        let slope = |i: usize| div(&(&p[i + 1] - &p[i]), &(&t[i + 1] - &t[i]));
        match kind {
            TableKind::Pvt => {
                (0..last).for_each(|i| r.hermite(&t[i], &t[i + 1], &p[i], &p[i + 1], &b[i][2], &b[i + 1][2]))
            }
            TableKind::PvtEx => {
                (0..last).for_each(|i| r.hermite(&t[i], &t[i + 1], &p[i], &p[i + 1], &b[i][2], &b[i][3]))
            }
            TableKind::Complete { vel_begin, vel_end } => {
                let v = spline(&t, &p, big(vel_begin), big(vel_end));
                (0..last).for_each(|i| r.hermite(&t[i], &t[i + 1], &p[i], &p[i + 1], &v[i], &v[i + 1]));
            }
            TableKind::Percent { vel_begin } => {
                let mut v = big(vel_begin);
                for i in 0..last {
                    let next = slope(i) * 2 - &v;
                    r.ramp(&t[i], &p[i], &(&t[i + 1] - &t[i]), &v, &next, &b[i][2]);
                    v = next;
                }
            }
            TableKind::Continuous { .. } => unreachable!(),
        }
        r
    }

    fn continuous(&mut self, b: &[Vec<BigInt>]) {
        let mut time = BigInt::zero();
        for i in 0..b.len() - 1 {
            let displacement = &b[i + 1][0] - &b[i][0];
            let sign = if displacement.is_negative() { -1 } else { 1 };
            let (l, u0, u1) = (displacement * sign, &b[i][1] * sign, &b[i + 1][1] * sign);
            let (percent, top, a, d) = (&b[i][2], &b[i][3], &b[i][4], &b[i][5]);
            let square = |x: &BigInt| mul(x, x);
            let peak2 = div(&(mul(&mul(a, d), &l) * 2 + mul(d, &square(&u0)) + mul(a, &square(&u1))), &(a + d));
            let peak = if peak2 > square(top) { top.clone() } else { root(&peak2) };
            // A ramp that only the rounding of the doubles makes is none.
            let nothing = whole(1) >> 100;
            let (t0, t2) = (div(&(&peak - &u0), a), div(&(&peak - &u1), d));
            let (s0, s2) =
                (div(&(square(&peak) - square(&u0)), &(a * 2)), div(&(square(&peak) - square(&u1)), &(d * 2)));
            let rest = &l - &s0 - &s2;
            let t1 = div(&rest, &peak);
            let mut p = &b[i][0] - &b[0][0];
            for (t, s, from, to) in [(t0, s0, &u0, &peak), (t1, rest, &peak, &peak), (t2, s2, &peak, &u1)] {
                if t > nothing {
                    self.ramp(&time, &p, &t, &(from * sign), &(to * sign), percent);
                    time += t;
                    p += s * sign;
                }
            }
        }
        self.duration = time;
    }
}

/// Velocities of the clamped spline, by elimination in big numbers.
pub fn spline(t: &[BigInt], p: &[BigInt], v0: BigInt, v1: BigInt) -> Vec<BigInt> {
    let n = t.len();
    // Row i: v(i−1)/h0 + 2·(1/h0 + 1/h1)·v(i) + v(i+1)/h1 = 3·(Δ0/h0² + Δ1/h1²).
    let mut rows: Vec<(BigInt, BigInt)> = vec![(BigInt::zero(), v0)];
    for i in 1..n - 1 {
        let (h0, h1) = (div(&whole(1), &(&t[i] - &t[i - 1])), div(&whole(1), &(&t[i + 1] - &t[i])));
        let right = (mul(&mul(&(&p[i] - &p[i - 1]), &h0), &h0) + mul(&mul(&(&p[i + 1] - &p[i]), &h1), &h1)) * 3;
        let (c, d) = &rows[i - 1];
        let pivot = (&h0 + &h1) * 2 - mul(&h0, c);
        rows.push((div(&h1, &pivot), div(&(right - mul(&h0, d)), &pivot)));
    }
    let mut v = vec![v1];
    for (c, d) in rows.into_iter().rev() {
        let next = d - mul(&c, v.last().unwrap());
        v.push(next);
    }
    v.reverse();
    v
}

/// One axis that runs a table.
pub struct Bench<'a> {
    pub shelf: &'a Shelf,
    pub run: Pvt,
    pub start: u64,
    pub passes: u32,
}

impl<'a> Bench<'a> {
    pub fn start(shelf: &'a Shelf, table: u8, start: u64, origin: Exact, passes: u32) -> Bench<'a> {
        Bench { shelf, run: Pvt::begin(Ns(start), origin, table, shelf), start, passes }
    }
    /// ns since the start.
    pub fn step(&mut self, ns: u64) -> Step {
        self.run.step(Ns(self.start + ns), self.passes, self.shelf)
    }
    /// Position in pulses, velocity in pulse/ms, whether it runs.
    pub fn at_ms(&mut self, time: f64) -> (f64, f64, bool) {
        let step = self.step((time * 1e6).round() as u64);
        let v = step.motion.velocity();
        (step.pos.0 as f64 / 4194304.0, v.m as f64 * 2f64.powi(-v.e as i32), step.state == GeneratorState::Running)
    }
    /// The distance from the reference in pulses and in pulse/ms; `time` is ns since the start.
    pub fn error(&mut self, reference: &Reference, ns: u64) -> (f64, f64) {
        let step = self.step(ns);
        let since = ms(ns as i128) - &reference.delay;
        let (mut pos, mut vel) = (BigInt::zero(), BigInt::zero());
        if !since.is_negative() {
            let pass = &since / &reference.duration;
            let passes = BigInt::from(self.passes);
            if self.passes != 0 && pass >= passes {
                pos = &reference.displacement * passes;
            } else {
                let local = since - &pass * &reference.duration;
                pos = &reference.displacement * pass + reference.pos(&local);
                vel = reference.vel(&local);
            }
        }
        let v = step.motion.velocity();
        let shift = BITS as i64 - v.e as i64;
        let v = if shift >= 0 { BigInt::from(v.m) << shift as usize } else { BigInt::from(v.m) >> (-shift) as usize };
        let p = BigInt::from(step.pos.0) << (BITS - 22);
        (float(&(p - pos).abs()), float(&(v - vel).abs()))
    }
}
