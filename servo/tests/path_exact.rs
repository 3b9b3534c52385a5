//! Paths against the law of SPEC 5 in 256-bit fixed point, from the doubles as the user gave them.
//!
//! The reference knows speeds, lengths and squares; it shares no code with the planner, and takes
//! no packed number.
use crate::{chance, paths};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use servo::path::{MotionSpeeds, Path, PathEntry, PathStop};
use servo::segment::piece::Motion;
use servo::units::Pos;

use chance::Chance;
use paths::{Script, mark, run, since};

const BITS: usize = 256;

/// A number in 2^-BITS.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
struct Fix(BigInt);

fn fix(x: f64) -> Fix {
    Fix((BigRational::from_float(x).unwrap() * BigRational::from_integer(BigInt::from(1) << BITS)).to_integer())
}
fn whole(x: i64) -> Fix {
    Fix(BigInt::from(x) << BITS)
}
impl Fix {
    fn mul(&self, o: &Fix) -> Fix {
        Fix((&self.0 * &o.0) >> BITS)
    }
    fn div(&self, o: &Fix) -> Fix {
        if o.0.is_zero() { whole(0) } else { Fix((&self.0 << BITS) / &o.0) }
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
    fn twice(&self) -> Fix {
        Fix(&self.0 << 1)
    }
    fn root(&self) -> Fix {
        if self.0.is_negative() { whole(0) } else { Fix((&self.0 << BITS).sqrt()) }
    }
    fn square(&self) -> Fix {
        self.mul(self)
    }
    fn min(&self, o: &Fix) -> Fix {
        if self < o { self.clone() } else { o.clone() }
    }
    fn max(&self, o: &Fix) -> Fix {
        if self > o { self.clone() } else { o.clone() }
    }
    fn f64(&self) -> f64 {
        (&self.0 >> (BITS - 160)).to_f64().unwrap() / 2f64.powi(160)
    }
    /// From ms to ns.
    fn ns(&self) -> f64 {
        Fix(&self.0 * 1_000_000).f64()
    }
}

/// An interval of constant acceleration of the reference.
#[derive(Clone, Debug)]
struct Phase {
    v0: Fix,
    v1: Fix,
    time: Fix,
}

impl Phase {
    fn ramp(v0: &Fix, v1: &Fix, acc: &Fix) -> Phase {
        let change = Fix(v1.sub(v0).0.abs());
        Phase { v0: v0.clone(), v1: v1.clone(), time: change.div(acc) }
    }
    fn travelled(&self) -> Fix {
        self.v0.add(&self.v1).half().mul(&self.time)
    }
    /// Length after t.
    fn at(&self, t: &Fix) -> Fix {
        let acc = self.v1.sub(&self.v0).div(&self.time);
        t.mul(&self.v0.add(&acc.mul(t).half()))
    }
}

/// The limits of a motion, as the user gave them.
#[derive(Clone, Copy, Debug)]
struct Speeds {
    vel: f64,
    acc: f64,
    end: f64,
}

/// The law: intervals of a motion over `length` entered at `v0`, which is to end at `end`.
fn law(v0: &Fix, length: &Fix, vel: &Fix, acc: &Fix, end: &Fix, even: &Fix) -> Vec<Phase> {
    let swing = acc.mul(length).twice();
    let (slowest, fastest) = (v0.square().sub(&swing).root(), v0.square().add(&swing).root());
    let exit = end.min(vel).max(&slowest).min(&fastest);
    let ramps = |peak: &Fix| [Phase::ramp(v0, peak, acc), Phase::ramp(peak, &exit, acc)];
    let left = |peak: &Fix| {
        let [a, b] = ramps(peak);
        length.sub(&a.travelled()).sub(&b.travelled())
    };
    let mut peak = if v0 > vel {
        vel.max(&exit)
    } else {
        // v0² + 2·acc·s = exit² + 2·acc·(length − s)
        v0.square().add(&exit.square()).add(&swing).half().root().min(vel).max(&v0.max(&exit))
    };
    if v0 <= vel && !even.0.is_zero() {
        // By bisection: the highest peak with enough time at it.
        let short = |peak: &Fix| left(peak) < peak.mul(even);
        if short(&peak) {
            let mut low = v0.max(&exit);
            let mut high = peak;
            for _ in 0..200 {
                let middle = low.add(&high).half();
                if short(&middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            peak = low;
        }
    }
    let [first, last] = ramps(&peak);
    let rest = left(&peak);
    let cruise = Phase { v0: peak.clone(), v1: peak.clone(), time: rest.max(&whole(0)).div(&peak) };
    vec![first, cruise, last]
}

fn along(s: Speeds) -> MotionSpeeds {
    paths::speeds(s.vel, s.acc, s.end)
}
fn line(to: [i32; 4], s: Speeds) -> PathEntry {
    PathEntry::line(to, along(s))
}
fn distance(a: &[i32; 4], b: &[i32; 4]) -> Fix {
    let sum: BigInt = a.iter().zip(b).map(|(a, b)| (BigInt::from(*a) - *b).pow(2)).sum();
    Fix((sum << (2 * BITS)).sqrt())
}

/// Random lines with a mark at each boundary, now and then a wait: every boundary's instant,
/// whatever the tick.
#[test]
fn boundaries_of_random_paths_come_at_their_exact_instants() {
    let mut chance = Chance::new(5);
    let (mut worst, mut early) = (0.0f64, 0);
    for case in 0..100_000 {
        let even = if chance.below(3) == 0 { chance.below(3) as u16 } else { 0 };
        let count = 1 + chance.below(4);
        let (mut entries, mut motions) = (vec![mark(0)], Vec::new());
        let mut place = [0i32; 4];
        let mut places = vec![place];
        for i in 0..count {
            let vel = chance.log(0.5, 400.0);
            let acc = vel / chance.log(0.1, 4.0);
            let reach = (vel * chance.log(0.02, 3.0)).max(2.0);
            let dimensions = 2 + chance.below(3) as usize;
            let before = place;
            for x in place.iter_mut().take(dimensions) {
                *x += (chance.sign() * chance.unit() * reach) as i32;
            }
            place[0] += (place == before) as i32;
            places.push(place);
            let end = if chance.below(4) == 0 { 0.0 } else { chance.unit() * vel * 1.2 };
            let speeds = Speeds { vel, acc, end };
            let wait = chance.below(8) == 0;
            let flat = dimensions == 2 && chance.below(2) == 0;
            let entry = if flat { PathEntry::planar([place[0], place[1]], along(speeds)) } else { line(place, speeds) };
            entries.extend([entry, mark(i as u8 + 1)]);
            if wait {
                entries.push(PathEntry::delay(2));
            }
            motions.push((distance(&before, &place), speeds, wait));
        }
        // The reference.
        let (mut time, mut v, mut expected) = (whole(0), whole(0), vec![whole(0)]);
        let mut underrun = false;
        for (i, (length, s, wait)) in motions.iter().enumerate() {
            let end = if *wait || i + 1 == motions.len() { whole(0) } else { fix(s.end) };
            let stretches = law(&v, length, &fix(s.vel), &fix(s.acc), &end, &whole(even as i64));
            time = stretches.iter().fold(time, |t, s| t.add(&s.time));
            v = stretches[2].v1.clone();
            expected.push(time.clone());
            underrun = v.f64() > 1e-12;
            if underrun && *wait {
                // It stops in front of the wait.
                break;
            }
            if *wait {
                (time, v) = (time.add(&whole(2)), whole(0));
            }
        }
        let passed = expected.len() as u32 - 1;
        let waits = motions.iter().take(passed as usize).filter(|(.., wait)| *wait).count() as u32;
        let stops_before_wait = underrun && motions[passed as usize - 1].2;
        early += usize::from(stops_before_wait);
        let released = 1 + 2 * passed + waits - u32::from(stops_before_wait);
        let script = Script(entries);
        let mut last = Vec::new();
        for period in [1_000_000, 10_000] {
            let mut path = Path::IDLE;
            path.rules.set_even(even);
            let mut end = None;
            let heard = run(&mut path, &script, period, |_, step| end = Some(*step));
            assert_eq!(end.unwrap().position, places[passed as usize].map(Pos::pulses), "{case}");
            assert_eq!((end.unwrap().done, path.released(0)), (passed, released));
            assert!(stops_before_wait || passed == count as u32 && released == script.0.len() as u32);
            let rest = if underrun { PathStop::Underrun } else { PathStop::Completed };
            assert_eq!(heard.rests.iter().map(|r| r.1).collect::<Vec<_>>(), [rest], "{case}");
            assert_eq!(heard.marks.len(), expected.len());
            for (n, ((at, code), expected)) in heard.marks.iter().zip(&expected).enumerate() {
                assert_eq!(*code as usize, n);
                let error = (since(*at) - expected.ns()).abs();
                worst = worst.max(error);
                assert!(error < 5.0, "case {case}, boundary {n}: {} against {}", since(*at), expected.ns());
            }
            if period == 10_000 {
                assert_eq!(last, heard.marks, "{case}: the tick's period shows");
            }
            last = heard.marks;
        }
    }
    println!("worst boundary {worst:e} ns");
    assert!(worst > 0.0 && worst < 0.01);
    assert!(early > 1_000, "{early} waits are reached at speed");
}

/// Positions on a line are those of the law at every tick, in all coordinates.
#[test]
fn positions_on_lines_follow_the_law() {
    let mut chance = Chance::new(6);
    let mut worst = [0.0f64; 2];
    for case in 0..400 {
        let (far, flat) = (case % 3 == 0, case % 2 == 0);
        let reach = if far { 2f64.powi(31) - 1.0 } else { 5000.0 };
        let from = [(); 4].map(|()| (chance.sign() * chance.unit() * reach) as i32);
        let mut to = [(); 4].map(|()| (chance.sign() * chance.unit() * reach) as i32);
        if flat {
            (to[2], to[3]) = (from[2], from[3]);
        }
        let vel = if far { 16000.0 } else { chance.log(1.0, 500.0) };
        let speeds = Speeds { vel, acc: vel / chance.log(0.5, 50.0), end: 0.0 };
        let length = distance(&from, &to);
        let law = law(&whole(0), &length, &fix(speeds.vel), &fix(speeds.acc), &whole(0), &whole(0));
        let period = if far { 997_000_003 } else { 333_331 };
        let mut path = Path::IDLE;
        path.position(from.map(Pos::pulses));
        let entry = if flat { PathEntry::planar([to[0], to[1]], along(speeds)) } else { line(to, speeds) };
        // Numbers of 32 bits cost that much of the length of a ramp, and of the peak; ends of
        // phases are exact to 2⁻²¹ ns.
        let packed = if flat { 0.0 } else { 2f64.powi(-32) };
        let ramp = law[0].travelled().f64();
        run(&mut path, &Script(vec![entry]), period, |t, step| {
            let mut left = Fix((BigInt::from(t) << BITS) / 1_000_000);
            let (mut travelled, mut v) = (whole(0), whole(0));
            for s in &law {
                if left.0.is_positive() {
                    let t = left.min(&s.time);
                    travelled = travelled.add(&s.at(&t));
                    v = s.v0.add(&s.v1.sub(&s.v0).mul(&t).div(&s.time));
                    left = left.sub(&s.time);
                }
            }
            if left.0.is_positive() {
                (travelled, v) = (length.clone(), whole(0));
            }
            for i in 0..4 {
                let ideal =
                    whole(from[i] as i64).add(&whole(to[i] as i64 - from[i] as i64).mul(&travelled).div(&length));
                let ideal = Fix(ideal.0 << 22).f64();
                if step.runs && step.motion != Motion::STANDSTILL {
                    let share = whole(to[i] as i64 - from[i] as i64).div(&length).f64();
                    assert!((step.heading[i] as f64 * 2f64.powi(-30) - share).abs() < 2f64.powi(-29), "{case}");
                }
                let error = (step.position[i].0 as f64 - ideal).abs() * 2f64.powi(-22);
                let bound = 2f64.powi(-21) + packed * (ramp + length.f64() * 2f64.powi(-7));
                assert!(error <= bound, "{case}: {error:e}, bound {bound:e}");
                let worst = &mut worst[flat as usize];
                *worst = worst.max(error);
            }
            let got = step.motion.velocity();
            let got = got.m as f64 * 2f64.powi(-got.e as i32);
            assert!(
                (got - v.f64()).abs() <= vel * (2f64.powi(-44) + 256.0 * packed) + speeds.acc * 2e-12,
                "{case}: {got} against {}",
                v.f64()
            );
        });
    }
    println!("worst position {worst:?}");
    assert!(worst[1] > 0.0 && worst[0] < 0.5);
}
