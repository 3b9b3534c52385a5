//! Jog, Trap and Stop against closed forms in 256-bit fixed point.
//!
//! The reference knows only the law: ramps (v0, v1, duration, edge) and cruises, with positions
//! from integrating the trapezoid of acceleration. It shares no code with the planner.
use crate::{chance, drive};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use servo::math::float::Float;
use servo::segment::generator_state::GeneratorState;
use servo::segment::piece::Scaled;
use servo::segment::ramp::{Accel, Moving, RampRun, Refused, Speed, Trapezoid};
use servo::units::{Exact, Ns, StepLimit};

use chance::Chance;
use drive::{Ramp, Step};

const MS: u64 = 1_000_000;
const BITS: usize = 256;

/// A number in 2^-BITS.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
struct Fix(BigInt);

/// A ramp of its own.
fn ramp(begin: impl FnOnce(&mut RampRun)) -> RampRun {
    let mut run = RampRun::IDLE;
    begin(&mut run);
    run
}

fn fix(x: f64) -> Fix {
    Fix((BigRational::from_float(x).unwrap() * BigRational::from_integer(BigInt::from(1) << BITS)).to_integer())
}
fn ns(t: u64) -> Fix {
    Fix((BigInt::from(t) << BITS) / MS)
}
impl Fix {
    fn mul(&self, o: &Fix) -> Fix {
        Fix((&self.0 * &o.0) >> BITS)
    }
    fn div(&self, o: &Fix) -> Fix {
        if o.0.is_zero() { Fix(BigInt::zero()) } else { Fix((&self.0 << BITS) / &o.0) }
    }
    fn add(&self, o: &Fix) -> Fix {
        Fix(&self.0 + &o.0)
    }
    fn sub(&self, o: &Fix) -> Fix {
        Fix(&self.0 - &o.0)
    }
    fn half(&self) -> Fix {
        Fix(&self.0 >> 1)
    }
    fn abs(&self) -> Fix {
        Fix(self.0.abs())
    }
    fn f64(&self) -> f64 {
        (&self.0 >> (BITS - 128)).to_f64().unwrap() / 2f64.powi(128)
    }
}

/// A ramp or cruise of the reference.
#[derive(Clone, Debug)]
struct Law {
    v0: Fix,
    v1: Fix,
    len: Fix,
    edge: Fix,
}

impl Law {
    fn ramp(v0: &Fix, v1: &Fix, rate: &Fix, shape: &Shape) -> Law {
        let plain = v1.sub(v0).abs().div(rate);
        let (len, edge) = match shape {
            Shape::Percent(s) => (plain.clone(), plain.mul(s).half()),
            Shape::Average(_) if plain.0.is_zero() => (plain.clone(), plain.clone()),
            Shape::Average(w) => (plain.add(w), if plain < *w { plain } else { w.clone() }),
        };
        Law { v0: v0.clone(), v1: v1.clone(), len, edge }
    }
    fn displacement(&self) -> Fix {
        self.v0.add(&self.v1).mul(&self.len).half()
    }
    /// Displacement and velocity at t from its beginning.
    fn at(&self, t: &Fix) -> (Fix, Fix) {
        let dv = self.v1.sub(&self.v0);
        let top = dv.div(&self.len.sub(&self.edge));
        if self.edge.0.is_zero() {
            let v = self.v0.add(&top.mul(t));
            return (self.v0.add(&v).half().mul(t), v);
        }
        let jerk = top.div(&self.edge);
        let cube = |x: &Fix| Fix(x.mul(x).mul(x).0 / 6);
        if *t < self.edge {
            (self.v0.mul(t).add(&jerk.mul(&cube(t))), self.v0.add(&jerk.mul(t).mul(t).half()))
        } else if *t > self.len.sub(&self.edge) {
            let r = self.len.sub(t);
            let s = self.displacement().sub(&self.v1.mul(&r).sub(&jerk.mul(&cube(&r))));
            (s, self.v1.sub(&jerk.mul(&r).mul(&r).half()))
        } else {
            let r = t.sub(&self.edge);
            let v = self.v0.add(&top.mul(&self.edge).half());
            let s = self.v0.mul(&self.edge).add(&jerk.mul(&cube(&self.edge)));
            let w = v.add(&top.mul(&r));
            (s.add(&v.add(&w).half().mul(&r)), w)
        }
    }
}

enum Shape {
    Percent(Fix),
    Average(Fix),
}

/// Position (from the start) and velocity of a sequence of laws at t; at rest after the last.
fn sequence(laws: &[Law], t: &Fix) -> (Fix, Fix) {
    let (mut s, mut rest) = (fix(0.0), t.clone());
    for law in laws {
        if rest < law.len {
            let (x, v) = law.at(&rest);
            return (s.add(&x), v);
        }
        s = s.add(&law.displacement());
        rest = rest.sub(&law.len);
    }
    (s, fix(0.0))
}

fn total(laws: &[Law]) -> Fix {
    laws.iter().fold(fix(0.0), |t, l| t.add(&l.len))
}

fn scaled(x: f64) -> Scaled {
    block(speed(x).real())
}
/// A number of at most 63 bits, exactly.
fn block(x: Float) -> Scaled {
    let e = 63 - x.width();
    Scaled { m: x.to_fixed(e) as i64, e: e as i16 }
}
fn speed(x: f64) -> Speed {
    Speed::admit(x.to_bits(), StepLimit::FULL_SCALE).unwrap()
}
fn accel(x: f64) -> Accel {
    Accel::admit(x.to_bits()).unwrap()
}
fn fixed(x: Scaled) -> Fix {
    let shift = BITS as i64 - x.e as i64;
    Fix(if shift >= 0 { BigInt::from(x.m) << shift as usize } else { BigInt::from(x.m) >> (-shift) as usize })
}
fn origin(pulses: f64) -> Exact {
    Exact((fix(pulses).0 >> (BITS - 64)).to_i128().unwrap())
}
fn position(step: &Step) -> Fix {
    Fix(BigInt::from(step.pos.0) << (BITS - 22))
}

/// Instants to check: random ones, the knots and their neighbours, in order.
fn instants(chance: &mut Chance, laws: &[Law], end: u64) -> Vec<u64> {
    let mut all: Vec<u64> = (0..30).map(|_| chance.below(end.max(1))).collect();
    let mut t = fix(0.0);
    for law in laws {
        for edge in [&law.edge, &law.len.sub(&law.edge), &law.len] {
            let knot = ((t.add(edge).0 * MS) >> BITS).to_u64().unwrap_or(u64::MAX >> 2);
            all.extend([knot.saturating_sub(1), knot, knot + 1]);
        }
        t = t.add(&law.len);
    }
    all.retain(|&x| x <= end);
    all.sort_unstable();
    all
}

#[derive(Default, Debug)]
struct Worst {
    pos: f64,
    velocity: f64,
}

/// Follows a run through the instants; bounds of SPEC 11.
fn follow(run: RampRun, begin: u64, from: Exact, laws: &[Law], times: &[u64], worst: &mut Worst, what: &str) {
    let mut run = Ramp::begin(Ns(begin), run);
    let start = Fix(BigInt::from(from.0) << (BITS - 64));
    let peak = laws.iter().flat_map(|l| [l.v0.abs().f64(), l.v1.abs().f64()]).fold(0.0, f64::max);
    for &t in times {
        let step = run.step(Ns(begin + t));
        let (s, v) = sequence(laws, &ns(t));
        let error = position(&step).sub(&start.add(&s)).f64().abs();
        worst.pos = worst.pos.max(error);
        assert!(error <= 2f64.powi(-16), "{what}: {error:e} pulse at {t} ns, {:?} {laws:?}", step.state);
        // A knot's instant is good to 2^-60 of the time since the start (under 0.001 ns in a week).
        let steepest = laws.iter().map(|l| l.v1.sub(&l.v0).abs().div(&l.len.sub(&l.edge)).f64()).fold(0.0, f64::max);
        let slack = steepest * t as f64 / 1e6 * 2f64.powi(-60);
        let error = (fixed(step.motion.velocity()).sub(&v).f64().abs() - slack).max(0.0) / peak.max(1e-300);
        worst.velocity = worst.velocity.max(error);
        assert!(
            error <= 2f64.powi(-16),
            "{what}: velocity {error:e} of the peak at {t} ns of {}, {:?}",
            total(laws).f64() * 1e6,
            step.state
        );
    }
}

fn jog_laws(v: f64, target: f64, acc: f64, dec: f64, smooth: f64) -> Vec<Law> {
    let shape = Shape::Percent(fix(smooth));
    let zero = fix(0.0);
    let mut laws = vec![];
    let mut now = fix(v);
    if v != 0.0 && v * target <= 0.0 {
        laws.push(Law::ramp(&now, &zero, &fix(dec), &shape));
        now = zero;
    }
    let faster = now.abs() < fix(target).abs();
    laws.push(Law::ramp(&now, &fix(target), &fix(if faster { acc } else { dec }), &shape));
    laws
}

#[test]
fn jog_follows_its_closed_form_and_cruises_for_ever() {
    let mut chance = Chance::new(21);
    let mut worst = Worst::default();
    for round in 0..4000 {
        let (v, target) = (chance.log(1e-3, 1e6) * chance.sign(), chance.log(1e-3, 1e6) * chance.sign());
        let v = if round % 3 == 0 { 0.0 } else { v };
        let target = if round % 7 == 6 { 0.0 } else { target };
        let (acc, dec) = (chance.log(1e-2, 1e6), chance.log(1e-2, 1e6));
        let smooth = if round % 2 == 0 { 0 } else { chance.next() as u16 };
        let mut laws = jog_laws(v, target, acc, dec, smooth as f64 / 65536.0);
        let begin = chance.next() >> 4;
        let from = origin((chance.unit() - 0.5) * 2f64.powi(39));
        let ramps = total(&laws).f64();
        // On and on: a day of cruise, or as far as the edge of travel.
        let cruise = (8.64e7f64).min(2f64.powi(38) / (v.abs() + target.abs()));
        if ramps * v.abs().max(target.abs()) > 2f64.powi(38) {
            continue;
        }
        let mut times = instants(&mut chance, &laws, (ramps * 1e6) as u64 + 2);
        if target != 0.0 {
            laws.push(Law { v0: fix(target), v1: fix(target), len: fix(1e12), edge: fix(0.0) });
            times.extend([0.001, 0.01, 0.1, 0.5, 1.0].map(|x| ((ramps + x * cruise) * 1e6) as u64));
            times.sort_unstable();
        }
        let moving = Moving { pos: from, velocity: scaled(v) };
        let run = ramp(|run| run.begin_jog(Ns(begin), moving, speed(target), accel(acc), accel(dec), smooth));
        // Chunks of a cruise are walked, 16 a call: go on in steps.
        let mut walked = vec![];
        let mut last = 0;
        for t in times {
            while t > last && t - last > 10 * MS {
                last += ((t - last) / 2).max(5 * MS);
                if walked.len() > 4000 {
                    break;
                }
                walked.push(last.min(t));
            }
            last = t;
            walked.push(t);
        }
        walked.dedup();
        follow(run, begin, from, &laws, &walked, &mut worst, "jog");
    }
    println!("jog {worst:?}");
}

#[test]
fn jog_dec_of_zero_means_acc() {
    let from = Moving { pos: Exact(0), velocity: scaled(10.0) };
    let mut run =
        Ramp::begin(Ns(0), ramp(|run| run.begin_jog(Ns(0), from, speed(5.0), accel(0.5), Accel::default(), 0)));
    assert_eq!(
        run.step(Ns(10 * MS)).motion.velocity().m as f64 / 2f64.powi(run.step(Ns(10 * MS)).motion.velocity().e as i32),
        5.0
    );
    assert!((fixed(run.step(Ns(5 * MS)).motion.velocity()).f64()) <= 10.0);
}

#[test]
fn stop_ends_at_rest_after_v_squared_over_2d() {
    let mut chance = Chance::new(22);
    let mut worst = Worst::default();
    for _ in 0..3000 {
        let (v, dec) = (chance.log(1e-4, 4e9) * chance.sign(), chance.log(1e-1, 4e9));
        let displacement = v * v / 2.0 / dec;
        if displacement.abs() > 2f64.powi(38) {
            continue;
        }
        let from = origin((chance.unit() - 0.5) * 2f64.powi(39));
        let laws = [Law::ramp(&fix(v), &fix(0.0), &fix(dec), &Shape::Average(fix(0.0)))];
        let begin = chance.next() >> 4;
        let end = (v.abs() / dec * 1e6) as u64 + 2;
        let run = ramp(|run| run.begin_stop(Ns(begin), Moving { pos: from, velocity: scaled(v) }, accel(dec)));
        let times = instants(&mut chance, &laws, end);
        // Fast long stops are cut into pieces: 16 a call are walked.
        follow(run, begin, from, &laws, &times, &mut worst, "stop");
        let mut run = Ramp::begin(Ns(begin), run);
        for k in 1..=64 {
            run.step(Ns(begin + end / 64 * k));
        }
        let GeneratorState::Ended { at } = run.step(Ns(begin + end)).state else { panic!("runs on") };
        let error = Fix(BigInt::from(at.0 - from.0) << (BITS - 64)).sub(&laws[0].displacement()).f64().abs();
        assert!(error <= 2f64.powi(-20), "{error:e}");
    }
    println!("stop {worst:?}");
}

struct Job {
    v: f64,
    displacement: i32,
    speed: f64,
    acc: f64,
    dec: f64,
    start: f64,
    wait_us: u64,
}

/// The law of a Trap, in magnitudes along its distance.
fn trap_laws(job: &Job) -> Vec<Law> {
    let w = Fix((BigInt::from(job.wait_us) << BITS) / 1000);
    let (acc, dec, top, zero) = (fix(job.acc), fix(job.dec), fix(job.speed), fix(0.0));
    let shape = Shape::Average(w.clone());
    let stop = |u: &Fix| Law::ramp(u, &zero, &dec, &shape);
    let mut displacement = fix(job.displacement as f64);
    let mut laws = vec![];
    let mut v = fix(job.v);
    if !v.0.is_zero() {
        let brake = stop(&v);
        if displacement.0.is_zero()
            || (displacement.0.sign() != v.0.sign())
            || displacement.abs() < brake.displacement().abs()
        {
            displacement = displacement.sub(&brake.displacement());
            laws.push(brake);
            v = zero.clone();
        }
    }
    let turn = displacement.0.is_negative();
    let length = displacement.abs();
    let mut u = v.abs();
    if u.0.is_zero() {
        let jump = if job.start < job.speed { fix(job.start) } else { top.clone() };
        if stop(&jump).displacement() <= length {
            u = jump;
        }
    }
    let rate = if u < top { &acc } else { &dec };
    let full = Law::ramp(&u, &top, rate, &shape).displacement().add(&stop(&top).displacement());
    let peak = if full <= length {
        top.clone()
    } else if u < top {
        // Bisection of the length of the triangle: no formula of the planner's.
        let (mut low, mut high) = (u.clone(), top.clone());
        for _ in 0..240 {
            let p = low.add(&high).half();
            if Law::ramp(&u, &p, &acc, &shape).displacement().add(&stop(&p).displacement()) <= length {
                low = p
            } else {
                high = p
            }
        }
        if Law::ramp(&u, &low, &acc, &shape).displacement().add(&stop(&low).displacement()) > length {
            u.clone()
        } else {
            low
        }
    } else {
        u.clone()
    };
    // Held where no further smoothed ramp fits.
    let up = Law::ramp(&u, &peak, rate, &shape);
    let down = stop(&peak);
    let cruise = length.sub(&up.displacement()).sub(&down.displacement());
    let hold = Law { v0: peak.clone(), v1: peak.clone(), len: cruise.div(&peak), edge: fix(0.0) };
    let mut rest = vec![up, hold, down];
    if turn {
        for law in &mut rest {
            law.v0 = Fix(-&law.v0.0);
            law.v1 = Fix(-&law.v1.0);
        }
    }
    laws.extend(rest);
    laws
}

fn draw(chance: &mut Chance, round: u32) -> Job {
    let speed = chance.log(1e-2, 1e5);
    Job {
        v: if round.is_multiple_of(2) { 0.0 } else { chance.log(1e-2, 1e5) * chance.sign() },
        displacement: (chance.log(1.0, 2e9) * chance.sign()) as i32,
        speed,
        acc: chance.log(1e-2, 1e5),
        dec: chance.log(1e-2, 1e5),
        start: if round.is_multiple_of(3) { speed * chance.unit() * 1.2 } else { 0.0 },
        wait_us: if round % 5 < 2 { 0 } else { 1000 * (1 + chance.below(50)) },
    }
}

fn begin_trap(job: &Job, begin: u64) -> (RampRun, Exact) {
    let base = 12345 - job.displacement / 2;
    let from = Exact((base as i128) << 64);
    let to = Trapezoid {
        target: base + job.displacement,
        speed: speed(job.speed),
        acc: accel(job.acc),
        dec: accel(job.dec),
        vel_start: speed(job.start),
        smooth: Ns(job.wait_us * 1000),
    };
    (ramp(|run| run.begin_trap(Ns(begin), Moving { pos: from, velocity: scaled(job.v) }, &to)), from)
}

#[test]
fn trap_follows_its_closed_form_and_ends_on_its_target() {
    let mut chance = Chance::new(23);
    let mut worst = Worst::default();
    let mut shapes = [0; 3];
    for round in 0..6000 {
        let job = draw(&mut chance, round);
        if job.v * job.v / job.dec > 1e10 {
            continue;
        }
        let laws = trap_laws(&job);
        if total(&laws).f64() > 1e9 {
            continue; // more pieces of cruise between two instants of this test than a step walks
        }
        let end = (total(&laws).f64() * 1e6) as u64 + 2;
        let begin = chance.next() >> 4;
        let (run, from) = begin_trap(&job, begin);
        let times = instants(&mut chance, &laws, end);
        follow(run, begin, from, &laws, &times, &mut worst, "trap");
        let mut run = Ramp::begin(Ns(begin), run);
        for t in times {
            run.step(Ns(begin + t));
        }
        // `end` is a double: allow for its rounding, and for the pieces of a long distance.
        let after = end + (end >> 50);
        let mut step = run.step(Ns(begin + after));
        for _ in 0..50 {
            step = run.step(Ns(begin + after));
        }
        let target = Exact(from.0 + ((job.displacement as i128) << 64));
        assert_eq!(step.state, GeneratorState::Ended { at: target });
        assert_eq!(step.pos, target.round());
        shapes[0] += (laws.len() == 4) as u32;
        shapes[1] += (laws[laws.len() - 2].len.f64() < 1e-9) as u32;
        shapes[2] += (laws[laws.len() - 2].len.f64() > 1.0) as u32;
    }
    println!("trap {worst:?}, turning {}, triangles {}, cruising {}", shapes[0], shapes[1], shapes[2]);
    assert!(shapes.iter().all(|&n| n > 300), "{shapes:?}");
}

/// Acceleration within its bound and velocity without jumps, measured from outside.
#[test]
fn trap_keeps_its_acceleration() {
    let mut chance = Chance::new(24);
    for round in 0..600 {
        let mut job = draw(&mut chance, round);
        (job.start, job.displacement, job.speed) = (0.0, job.displacement % 100_000, job.speed % 500.0 + 1.0);
        job.v %= 100.0;
        let laws = trap_laws(&job);
        let end = total(&laws).f64() * 1e6;
        if end > 2e10 {
            continue;
        }
        let mut run = Ramp::begin(Ns(0), begin_trap(&job, 0).0);
        let bound = job.acc.max(job.dec) * (1.0 + 1e-9);
        let float = |s: Scaled| s.m as f64 / 2f64.powi(s.e as i32);
        let mut before = job.v;
        const STEPS: u64 = 400;
        for k in 1..=STEPS {
            let t = (end as u64 + 2) * k / STEPS;
            let gap = (t - (end as u64 + 2) * (k - 1) / STEPS) as f64 / 1e6;
            let motion = run.step(Ns(t)).motion;
            assert!(float(motion.acceleration()).abs() <= bound);
            let v = float(motion.velocity());
            assert!((v - before).abs() <= bound * gap + 1e-6, "{before} {v} in {gap} ms, bound {bound}");
            before = v;
        }
        assert_eq!(before, 0.0);
    }
}

/// The same positions, bit for bit, at common instants of ticks of 10, 50, 250 and 1000 µs.
#[test]
fn positions_do_not_depend_on_the_tick() {
    let mut chance = Chance::new(25);
    for round in 0..60 {
        let mut job = draw(&mut chance, round);
        (job.displacement, job.speed) = (job.displacement % 10_000, 1.0 + job.speed % 300.0);
        (job.acc, job.dec, job.v) = (job.acc + 0.1, job.dec + 0.1, job.v % 30.0);
        let trap = begin_trap(&job, 777).0;
        let jog = ramp(|run| {
            run.begin_jog(
                Ns(777),
                Moving { pos: Exact(5), velocity: scaled(job.v) },
                speed(-job.speed * 1e5),
                accel(job.acc),
                accel(job.dec),
                30000,
            )
        });
        let stop =
            ramp(|run| run.begin_stop(Ns(777), Moving { pos: Exact(5), velocity: scaled(job.v) }, accel(job.dec)));
        for run in [trap, jog, stop] {
            let sampled = |period: u64| -> Vec<Step> {
                let mut run = Ramp::begin(Ns(777), run);
                (1..=200 * MS / period)
                    .map(|k| {
                        // Pieces that are made ahead are the same.
                        if period > 10_000 && k % 3 != 0 {
                            run.prepare();
                        }
                        (k * period, run.step(Ns(777 + k * period)))
                    })
                    .filter(|(t, _)| t % MS == 0)
                    .map(|x| x.1)
                    .collect()
            };
            let fixed = sampled(10_000);
            for period in [50_000, 250_000, 1_000_000] {
                assert!(sampled(period) == fixed, "round {round}, tick {period} ns");
            }
        }
    }
}

#[test]
fn rates_are_admitted_or_refused_by_name() {
    assert_eq!(Speed::admit(f64::NAN.to_bits(), StepLimit::FULL_SCALE), Err(Refused::NotFinite));
    assert_eq!(Speed::admit(4294967297f64.to_bits(), StepLimit::FULL_SCALE), Err(Refused::BeyondLimit));
    assert!(Speed::admit((-4294967296f64).to_bits(), StepLimit::FULL_SCALE).is_ok());
    assert_eq!(Accel::admit(0f64.to_bits()), Err(Refused::NotPositive));
    assert_eq!(Accel::admit((-1f64).to_bits()), Err(Refused::NotPositive));
    assert_eq!(Accel::admit(f64::INFINITY.to_bits()), Err(Refused::NotFinite));
    let mut chance = Chance::new(26);
    for _ in 0..10_000 {
        let x = chance.log(1e-9, 4e9);
        let a = accel(x);
        assert_eq!(fixed(block(a.magnitude())), fix(x));
        let error = fixed(block(a.reciprocal())).mul(&fix(x)).sub(&fix(1.0)).f64().abs();
        assert!(error <= 2f64.powi(-60), "1/{x}: {error:e}");
    }
}
