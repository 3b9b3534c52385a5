//! PT against exact arithmetic on the doubles as given (SPEC 11).
//!
//! The mass test compares with big integers in 2⁻³²⁰ (its own error is below 2⁻²⁸⁰, it divides
//! and never approximates); short chains are compared with reduced rationals too.
use crate::{chance, drive};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use servo::segment::generator_state::GeneratorState;
use servo::segment::piece::Scaled;
use servo::segment::pt::{AllowedData, Chain, Refused, Segment, SegmentStore, Segments, SlotRange};
use servo::units::{Exact, Ns, Pos, StepLimit};

use chance::Chance;
use drive::Pt;

const MS: u64 = 1_000_000;
/// Fraction bits of the reference.
const BITS: usize = 320;

struct Store(Vec<Segment>);

/// The content of a slot that was never written.
fn unwritten() -> Segment {
    SegmentStore::new().segment(0)
}

impl Segments for Store {
    fn segment(&self, slot: u32) -> Segment {
        self.0.get(slot as usize).copied().unwrap_or_else(unwritten)
    }
}

#[derive(Clone, Copy, Debug)]
struct Datum {
    pos: f64,
    time: i32,
    kind: i16,
}

/// A double as a whole number of 2^-BITS, exactly (it has no bits below 2⁻¹¹⁰⁰, and none below
/// 2^-BITS for what is used here).
fn big(x: f64) -> BigInt {
    let exact = BigRational::from_float(x).unwrap();
    let scaled = exact * BigRational::from_integer(BigInt::from(1) << BITS);
    assert!(scaled.is_integer());
    scaled.to_integer()
}

fn big_exact(x: Exact) -> BigInt {
    BigInt::from(x.0) << (BITS - 64)
}

fn big_pos(x: Pos) -> BigInt {
    BigInt::from(x.0) << (BITS - 22)
}

fn big_scaled(x: Scaled) -> BigInt {
    let shift = BITS as i64 - x.e as i64;
    assert!(shift >= 0);
    BigInt::from(x.m) << shift as usize
}

fn to_f64(x: &BigInt) -> f64 {
    (x >> (BITS - 120)).to_f64().unwrap() / 2f64.powi(120)
}

/// One segment of the reference: start knot and time, displacement, duration, end velocities.
struct Truth {
    start: BigInt,
    begin: u64,
    p: BigInt,
    t: u64,
    v0: BigInt,
    v1: BigInt,
}

fn truth(data: &[Datum]) -> Vec<Truth> {
    let (mut pos, mut time, mut v) = (BigInt::zero(), 0i32, BigInt::zero());
    data.iter()
        .map(|d| {
            let end = big(d.pos);
            let p = &end - &pos;
            let t = (d.time - time) as u64;
            let mean = &p / t;
            let twice = (&p * 2) / t;
            let (v0, v1) = match d.kind {
                0 => (v.clone(), &twice - &v),
                1 => (mean.clone(), mean),
                _ => (twice, BigInt::zero()),
            };
            let row = Truth { start: pos.clone(), begin: time as u64, p, t, v0, v1: v1.clone() };
            (pos, time, v) = (end, d.time, v1);
            row
        })
        .collect()
}

impl Truth {
    /// Displacement and velocity `ns` after the segment's begin.
    fn at(&self, ns: u64) -> (BigInt, BigInt) {
        let n = BigInt::from(self.t * MS);
        let a = &self.v0 * self.t;
        // NORMAL with v0, EVEN and STOP alike: s = Aτ + (P − A)τ²
        let s = (&a * ns * &n + (&self.p - &a) * ns * ns) / (&n * &n);
        let v = &self.v0 + (&self.v1 - &self.v0) * ns / &n;
        (s, v)
    }
}

/// Admits data until one is refused; a refused datum is drawn again as something slower.
fn draw(chance: &mut Chance, count: usize, longest: f64) -> (Vec<Datum>, Vec<Segment>) {
    let (mut data, mut words) = (Vec::new(), Vec::new());
    let mut chain = Chain::default();
    let (mut pos, mut time) = (0f64, 0i64);
    // Whole chains of one scale, and chains of mixed scales.
    let scale = if chance.below(2) == 0 { Some((chance.log(1e-3, 1e9), chance.log(1.0, longest))) } else { None };
    for _ in 0..count {
        for attempt in 0..20 {
            let (size, length) = match scale {
                Some((size, length)) => {
                    (size * chance.unit() * chance.sign(), (length * (0.5 + chance.unit())).max(1.0))
                }
                None => (chance.log(1e-3, 2f64.powi(40)) * chance.sign(), chance.log(1.0, longest)),
            };
            let target = pos + size;
            let target = if chance.below(4) == 0 { target.round() } else { target };
            let end = time + length as i64;
            if end > i32::MAX as i64 || target.abs() > 2f64.powi(40) {
                continue;
            }
            let kind =
                if attempt > 10 { 1 + chance.below(2) } else { [0, 0, 0, 0, 1, 2][chance.below(6) as usize] } as i16;
            let datum = Datum { pos: target, time: end as i32, kind };
            if let Ok((segment, next)) =
                Segment::admit(target.to_bits(), end as i32, kind, &chain, StepLimit::FULL_SCALE)
            {
                (chain, pos, time) = (next, target, end);
                data.push(datum);
                words.push(segment);
                break;
            }
        }
    }
    (data, words)
}

#[derive(Default, Debug)]
struct Worst {
    inside: f64,
    knot: f64,
    velocity: f64,
    segments: u64,
    normal: u64,
    beyond: u64,
}

fn compare(chance: &mut Chance, count: usize, longest: f64, origin: Exact, dynamic: bool, worst: &mut Worst) {
    let (data, words) = draw(chance, count, longest);
    if data.is_empty() {
        return;
    }
    let rows = truth(&data);
    let peak = rows.iter().flat_map(|r| [r.v0.abs(), r.v1.abs()]).max().unwrap();
    let total = rows.len() as u32;
    let first = if dynamic { chance.next() as u32 } else { 0 };
    let (place, mask, passes) = if dynamic {
        (SlotRange::Dynamic { mask: 2047, first }, 2047, 0)
    } else {
        (SlotRange::Static { base: 1024 }, u32::MAX, 1)
    };
    let mut store = Store(vec![unwritten(); 2048]);
    for (i, w) in words.iter().enumerate() {
        let slot = if dynamic { first.wrapping_add(i as u32) & mask } else { 1024 + i as u32 };
        store.0[slot as usize] = *w;
    }
    let begin = chance.next() >> 2;
    let mut run = Pt::begin(Ns(begin), origin, place);
    let feed = AllowedData { end: first.wrapping_add(total), passes };
    let base = big_exact(origin);
    for row in &rows {
        let from = begin + row.begin * MS;
        // The knot, its neighbours, somewhere inside: in order.
        let mut instants = [0, 1, chance.below(row.t * MS), chance.below(row.t * MS), row.t * MS - 1];
        instants.sort_unstable();
        for ns in instants {
            let step = run.step(Ns(from + ns), feed, &store);
            assert_eq!(step.state, GeneratorState::Running);
            let (s, v) = row.at(ns);
            // Beyond the edge of travel the axis has stopped.
            if to_f64(&(&base + &row.start + &s)).abs() > 2f64.powi(40) {
                worst.beyond += 1;
                continue;
            }
            let error = to_f64(&(big_pos(step.pos) - &base - &row.start - s)).abs();
            if ns == 0 {
                worst.knot = worst.knot.max(error);
            }
            worst.inside = worst.inside.max(error);
            assert!(
                error <= 2f64.powi(-16),
                "{error:e} at {ns} ns of {} ms, P {:e}, v0 {:e}",
                row.t,
                to_f64(&row.p),
                to_f64(&row.v0)
            );
            if !peak.is_zero() {
                let gap = big_scaled(step.motion.velocity()) - v;
                let error = to_f64(&((gap << BITS) / &peak)).abs();
                worst.velocity = worst.velocity.max(error);
                assert!(error <= 2f64.powi(-16), "velocity {error:e} of the peak, T {}", row.t);
            }
        }
        worst.segments += 1;
    }
    worst.normal += data.iter().filter(|d| d.kind == 0).count() as u64;
    let last = rows.last().unwrap();
    let end = big_exact(origin) + &last.start + &last.p;
    let step = run.step(Ns(begin + (last.begin + last.t) * MS), feed, &store);
    // Slack: the part of a quotient below 2^-80 cannot be distinguished from standstill.
    let at = match step.state {
        GeneratorState::Ended { at } => at,
        GeneratorState::Underrun { at } => {
            assert!(dynamic && !last.v1.is_zero());
            at
        }
        GeneratorState::Running => panic!("runs on"),
    };
    if dynamic && to_f64(&last.v1).abs() > 1e-12 {
        assert!(matches!(step.state, GeneratorState::Underrun { .. }));
    }
    assert!(to_f64(&(big_exact(at) - end)).abs() <= 2f64.powi(-64));
}

fn mass(seed: u64, segments: u64, chain: u64, longest: f64) -> Worst {
    let mut chance = Chance::new(seed);
    let mut worst = Worst::default();
    let mut round = 0;
    while worst.segments < segments {
        round += 1;
        let origin = match round % 4 {
            0 => Exact(1 << (39 + 64)),
            1 => Exact(-1 << (39 + 64)),
            2 => Exact(0),
            _ => Exact((chance.next() as i64 as i128) << 30),
        };
        let count = 1 + chance.below(chain) as usize;
        compare(&mut chance, count, longest, origin, round % 3 == 0, &mut worst);
    }
    println!("{worst:?}");
    worst
}

fn hold(worst: Worst) {
    assert!(worst.knot <= 2f64.powi(-23), "at a knot only rounding remains: {:e}", worst.knot);
    assert!(worst.normal > worst.segments / 10 && worst.beyond < worst.segments / 2);
}

#[test]
fn short_segments() {
    hold(mass(11, 500_000, 1000, 100.0));
}

#[test]
fn segments_of_any_length() {
    hold(mass(12, 300_000, 40, 1e7));
}

#[test]
fn very_long_segments() {
    hold(mass(13, 200_000, 4, 2147483647.0));
}

/// Reduced rationals, without any rounding in the reference.
#[test]
fn short_chains_against_rationals() {
    let mut chance = Chance::new(14);
    for _ in 0..2000 {
        let (data, words) = draw(&mut chance, 6, 1e6);
        let store = Store(words);
        let mut run = Pt::begin(Ns(0), Exact(0), SlotRange::Static { base: 0 });
        let feed = AllowedData { end: data.len() as u32, passes: 1 };
        let whole = |x: u64| BigRational::from_integer(BigInt::from(x));
        let (mut pos, mut time, mut v) = (BigRational::zero(), 0u64, BigRational::zero());
        for d in &data {
            let end = BigRational::from_float(d.pos).unwrap();
            let t = whole(d.time as u64 - time);
            let p = &end - &pos;
            let two = whole(2);
            let v0 = match d.kind {
                0 => v.clone(),
                1 => &p / &t,
                _ => &p * &two / &t,
            };
            let v1 = &p * &two / &t - &v0;
            let ns = chance.below((d.time as u64 - time) * MS);
            let tau = whole(ns) / (&t * whole(MS));
            let s = &pos + &v0 * &t * &tau + (&v1 - &v0) * &t * &tau * &tau / &two;
            let step = run.step(Ns(time * MS + ns), feed, &store);
            let got = BigRational::new(BigInt::from(step.pos.0), BigInt::from(1 << 22));
            assert!((got - s).abs() <= BigRational::new(BigInt::from(1), BigInt::from(1 << 16)));
            (pos, time, v) = (end, d.time as u64, v1);
        }
    }
}

fn admit_all(data: &[(f64, i32, i16)]) -> Store {
    let mut chain = Chain::default();
    Store(
        data.iter()
            .map(|&(pos, time, kind)| {
                let (segment, next) = Segment::admit(pos.to_bits(), time, kind, &chain, StepLimit::FULL_SCALE).unwrap();
                chain = next;
                segment
            })
            .collect(),
    )
}

#[test]
fn loops_do_not_drift() {
    const PASSES: u32 = 100_000;
    for origin in [0i128, 1 << 103, -(1 << 103), 0x1234_5678_9abc_def0] {
        let store = admit_all(&[(0.1, 1, 0), (0.3, 3, 0), (0.7, 4, 1), (0.1 + 0.2, 5, 2)]);
        let mut run = Pt::begin(Ns(17), Exact(origin), SlotRange::Static { base: 0 });
        let feed = AllowedData { end: 4, passes: PASSES };
        let whole = |x: f64| (big(x) >> (BITS - 64)).to_i128().unwrap();
        let (travelled, part) = (whole(0.1 + 0.2), whole(0.1));
        for pass in 0..PASSES as i128 {
            let begin = Ns(17 + pass as u64 * 5 * MS);
            let step = run.step(begin, feed, &store);
            assert_eq!(step.pos, Exact(origin + pass * travelled).round(), "pass {pass}");
            let step = run.step(Ns(begin.0 + MS), feed, &store);
            assert_eq!(step.pos, Exact(origin + pass * travelled + part).round(), "pass {pass}");
            for ms in 2..5 {
                run.step(Ns(begin.0 + ms * MS), feed, &store);
            }
            assert_eq!(run.passes(), pass as u32);
        }
        let step = run.step(Ns(17 + PASSES as u64 * 5 * MS), feed, &store);
        assert_eq!(step.state, GeneratorState::Ended { at: Exact(origin + PASSES as i128 * travelled) });
        assert_eq!(run.passes(), PASSES);
    }
}

/// GXN listing 2-1, and the same with thirds: both end at rest exactly, so a dry ring is an end.
#[test]
fn a_chain_that_comes_to_rest_is_no_underrun() {
    let listing = [(1024.0, 1024, 0), (3072.0, 2048, 0), (4096.0, 3072, 0)];
    // 1 in 3 ms, 3 in 4 ms at speed up and down: v = 2/3, 2/3, 0.
    let thirds = [(1.0, 3, 0), (3.0, 6, 0), (4.0, 9, 0)];
    // Ends at 2·(1/3)/1 off rest by the last bit of a double: that is speed, however little.
    let off = [(1.0, 3, 0), (3.0, 6, 0), (4.0 + 1e-15, 9, 0)];
    for (data, rest) in [(listing, true), (thirds, true), (off, false)] {
        let store = admit_all(&data);
        let mut run = Pt::begin(Ns(0), Exact(0), SlotRange::Dynamic { mask: 63, first: 0 });
        let feed = AllowedData { end: 3, passes: 0 };
        let last = data[2].1 as u64 * MS;
        let mut now = 0;
        while now < last {
            let step = run.step(Ns(now), feed, &store);
            assert_eq!(step.state, GeneratorState::Running);
            now += MS;
        }
        let end = run.step(Ns(last), feed, &store);
        assert_eq!(matches!(end.state, GeneratorState::Ended { .. }), rest, "{data:?} {end:?}");
        assert_eq!(end.pos, Pos::pulses(4).max(Exact((big(data[2].0) >> (BITS - 64)).to_i128().unwrap()).round()));
    }
}

#[test]
fn velocity_of_the_listing() {
    let store = admit_all(&[(1024.0, 1024, 0), (3072.0, 2048, 0), (4096.0, 3072, 0)]);
    let mut run = Pt::begin(Ns(0), Exact(0), SlotRange::Static { base: 0 });
    let feed = AllowedData { end: 3, passes: 1 };
    let float = |s: Scaled| s.m as f64 / 2f64.powi(s.e as i32);
    assert!((float(run.step(Ns(512 * MS), feed, &store).motion.velocity()) - 1.0).abs() < 1e-15);
    let step = run.step(Ns(1500 * MS + 7), feed, &store);
    assert_eq!(float(step.motion.velocity()), 2.0);
    assert_eq!(float(step.motion.acceleration()), 0.0);
    let step = run.step(Ns(2048 * MS + 512 * MS), feed, &store);
    assert!((float(step.motion.acceleration()) + 2.0 / 1024.0).abs() < 1e-17);
}

#[test]
fn data_appended_while_running_belongs_to_the_pass() {
    let store = admit_all(&[(1.0, 10, 1), (3.0, 20, 1), (4.0, 30, 1)]);
    let mut run = Pt::begin(Ns(0), Exact(0), SlotRange::Static { base: 0 });
    let feed = |end, passes| AllowedData { end, passes };
    assert_eq!(run.step(Ns(5 * MS), feed(1, 2), &store).pos, Pos(1 << 21));
    assert_eq!(run.step(Ns(15 * MS), feed(3, 2), &store).pos, Pos::pulses(2));
    assert_eq!(run.step(Ns(25 * MS), feed(3, 2), &store).pos, Pos(7 << 21));
    // The second pass has all three and starts where the first ended; then the loop ends early.
    assert_eq!(run.step(Ns(40 * MS), feed(3, 2), &store).pos, Pos::pulses(5));
    assert_eq!(run.step(Ns(55 * MS), feed(3, 1), &store).state, GeneratorState::Running);
    assert_eq!(run.step(Ns(60 * MS), feed(3, 1), &store).state, GeneratorState::Ended { at: Exact(8 << 64) });
    assert_eq!(run.passes(), 2);
}

#[test]
fn a_stream_frees_slots_and_reports_when_it_runs_dry() {
    let store = admit_all(&[(1.0, 10, 1), (3.0, 20, 1), (4.0, 30, 2)]);
    let mut run = Pt::begin(Ns(100), Exact(0), SlotRange::Dynamic { mask: 63, first: 0 });
    let feed = AllowedData { end: 3, passes: 0 };
    assert_eq!((run.released(true), run.dry_ms(Ns(100), feed, &store)), (0, 30));
    run.step(Ns(100 + MS), feed, &store);
    assert_eq!((run.released(true), run.dry_ms(Ns(100 + MS), feed, &store)), (0, 29));
    assert_eq!(run.dry_ms(Ns(100 + MS + 1), feed, &store), 28);
    run.step(Ns(100 + 10 * MS), feed, &store);
    assert_eq!(run.released(true), 1);
    run.step(Ns(100 + 20 * MS), feed, &store);
    assert_eq!(run.released(true), 2);
    let end = run.step(Ns(100 + 30 * MS), feed, &store);
    assert_eq!(end.state, GeneratorState::Ended { at: Exact(4 << 64) });
    assert_eq!((run.released(false), run.dry_ms(Ns(100 + 30 * MS), feed, &store)), (3, 0));
}

#[test]
fn bad_data_is_refused_and_named() {
    let zero = Chain::default();
    let admit =
        |pos: f64, time, kind, before: &Chain| Segment::admit(pos.to_bits(), time, kind, before, StepLimit::FULL_SCALE);
    assert_eq!(admit(f64::NAN, 1, 0, &zero), Err(Refused::NotFinite));
    assert_eq!(admit(f64::NEG_INFINITY, 1, 0, &zero), Err(Refused::NotFinite));
    assert_eq!(admit(2f64.powi(40) * (1.0 + f64::EPSILON), i32::MAX, 1, &zero), Err(Refused::BeyondTravel));
    assert_eq!(admit(1e300, 1, 0, &zero), Err(Refused::BeyondTravel));
    assert!(admit(-(2f64.powi(40)), i32::MAX, 1, &zero).is_ok());
    assert_eq!(admit(1.0, 0, 0, &zero), Err(Refused::NotIncreasing { before: 0 }));
    assert_eq!(admit(1.0, -5, 0, &zero), Err(Refused::NotIncreasing { before: 0 }));
    for kind in [-1, 3, i16::MAX] {
        assert_eq!(admit(1.0, 1, kind, &zero), Err(Refused::Kind));
    }
    let (_, chain) = admit(1.0, 7, 0, &zero).unwrap();
    assert_eq!(admit(1.0, 7, 0, &chain), Err(Refused::NotIncreasing { before: 7 }));
    // Full scale 2^32 pulse/ms: at it yes, above it no; NORMAL and STOP count their end speeds.
    let full = 2f64.powi(32);
    assert!(admit(full, 1, 1, &zero).is_ok());
    assert!(admit(full / 2.0, 1, 0, &zero).is_ok() && admit(-full / 2.0, 1, 2, &zero).is_ok());
    assert!(matches!(admit(full + 2.0, 1, 1, &zero), Err(Refused::TooFast { .. })));
    assert!(matches!(admit(full / 2.0 + 2.0, 1, 0, &zero), Err(Refused::TooFast { .. })));
    assert_eq!(admit(-full, 1, 2, &zero), Err(Refused::TooFast { speed: -(1 << 53) }));
    let (_, fast) = admit(full, 1, 1, &zero).unwrap();
    // v1 = 2P/T − v0: back to the start in the same time means −v0 − 2v0.
    assert!(matches!(admit(0.0, 2, 0, &fast), Err(Refused::TooFast { .. })));
    assert_eq!(admit(full, i32::MAX, 0, &fast), Err(Refused::BeyondTravel));
}

#[test]
fn words_hold_the_double() {
    let mut chance = Chance::new(15);
    let mut cases =
        vec![0.0, -0.0, f64::MIN_POSITIVE, 2f64.powi(-64), 2f64.powi(-65), 2f64.powi(-12), -(2f64.powi(40))];
    cases.push(f64::from_bits(2f64.powi(-12).to_bits() - 1));
    cases.extend((0..200_000).map(|_| chance.log(1e-25, 1e12) * chance.sign()));
    for pos in cases.into_iter().filter(|x| x.abs() <= 2f64.powi(40)) {
        let time = 1 + (chance.next() >> 33) as i32;
        let time = if pos.abs() > 1e9 { i32::MAX } else { time.max(10_000) };
        let (segment, chain) =
            Segment::admit(pos.to_bits(), time, 1, &Chain::default(), StepLimit::FULL_SCALE).unwrap();
        assert_eq!((segment.time_ms() as i32, chain.time_ms()), (time, time));
        let exact = BigRational::from_float(pos).unwrap() * BigRational::from_integer(BigInt::from(1) << 64usize);
        let gap = BigRational::from_integer(BigInt::from(segment.position().0)) - exact;
        let half = BigRational::new(BigInt::from(1), BigInt::from(2));
        assert!(gap.abs() <= half && (pos.abs() < 2f64.powi(-12) || gap.is_zero()), "{pos:e}");
    }
}

/// What the tick prepares ahead is the same as what it computes in time: positions, counts, looks
/// ahead and ends are the same whenever it prepares.
#[test]
fn prepared_segments_are_the_same() {
    let mut chance = Chance::new(16);
    let mut prepared = 0;
    for round in 0..300 {
        let (data, words) = draw(&mut chance, 1 + round % 40, if round % 3 == 0 { 2.0 } else { 30.0 });
        let store = Store(words);
        let (place, passes) = match round % 2 {
            0 => (SlotRange::Static { base: 0 }, 3),
            _ => (SlotRange::Dynamic { mask: 63, first: 0 }, 1),
        };
        let mut plain = Pt::begin(Ns(77), Exact(1 << 60), place);
        let mut ahead = plain;
        let mut end = if round % 2 == 0 { data.len() as u32 } else { 1 };
        let (mut now, longest) = (77, if round % 5 == 0 { 5 * MS } else { MS });
        loop {
            now += 1 + chance.below(longest);
            let more = (end + chance.below(2) as u32).min(data.len() as u32);
            if more != end {
                end = more;
                ahead.0.invalidate_prepared();
            }
            let feed = AllowedData { end, passes };
            if chance.below(3) > 0 {
                prepared += ahead.prepare(feed, &store) as u32;
            }
            let step = plain.step(Ns(now), feed, &store);
            assert_eq!(ahead.step(Ns(now), feed, &store), step, "round {round}");
            let running = step.state == GeneratorState::Running;
            assert_eq!(ahead.released(running), plain.released(running));
            assert_eq!(ahead.passes(), plain.passes());
            assert_eq!(ahead.dry_ms(Ns(now), feed, &store), plain.dry_ms(Ns(now), feed, &store));
            if !running {
                break;
            }
        }
    }
    assert!(prepared > 1000, "{prepared}");
}
