//! A board whose step outputs are limited (SPEC 5): data known to be faster is refused with its
//! parameter and the limit, and changes nothing. All other data is taken, to the last bit as far as
//! doubles allow.

use crate::{bench, chance};
use bench::crd::*;
use bench::*;
use chance::Chance;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Signed;
use protocol::command::*;
use protocol::reason::describe_opcode;
use servo::units::StepLimit;

/// As the STM32H743 board.
const LIMIT_PULSES_PER_MS: f64 = 1000.0;

/// Boxed: some tests have several, more than a thread's stack holds.
#[inline(never)]
fn limited() -> Box<Bench<8>> {
    let mut bench = Box::new(Bench::on(StepLimit::new(LIMIT_PULSES_PER_MS as u64).unwrap(), None, 0, 250));
    bench.open(1);
    bench
}

/// The double above.
fn above(x: f64) -> f64 {
    f64::from_bits(x.to_bits() + 1)
}

fn rational(x: f64) -> BigRational {
    BigRational::from_float(x).unwrap()
}

/// The text of a refusal, which must be one of code 7.
fn text<R: Request>(bench: &mut Bench<8>, request: R, items: &[R::Item]) -> String {
    let answer = bench.call_items(request, items);
    assert_eq!(answer.code, 7, "{:?}", answer.body);
    describe_opcode(R::OPCODE, answer.refusal()).to_string()
}

#[test]
fn version_tells_it() {
    assert_eq!(limited().done(Version {}).step_limit.get(), LIMIT_PULSES_PER_MS);
    let mut bench = Bench::gus();
    bench.open(1);
    assert_eq!(bench.done(Version {}).step_limit.get(), 4_294_967_296.0);
}

#[test]
fn jog_and_trap_speeds() {
    let mut bench = limited();
    let (core, profile) = (1.into(), 1.into());
    let set = |vel: f64| SetVel { core, profile, vel: vel.into() };
    for vel in [LIMIT_PULSES_PER_MS, -LIMIT_PULSES_PER_MS, 0.0] {
        bench.done(set(vel));
    }
    bench.done(set(-3.5));
    for vel in [above(LIMIT_PULSES_PER_MS), -above(LIMIT_PULSES_PER_MS), 1e9] {
        let reported = text(&mut bench, set(vel), &[]);
        assert_eq!(reported, format!("SetVel: vel is {vel}; it must be from -1000 to 1000"));
    }
    assert_eq!(bench.done(GetVel { core, profile }).value.get(), -3.5);
    let trap = |vel: f64| SetTrapPrm {
        core,
        profile,
        acc: 1.0.into(),
        dec: 1.0.into(),
        vel_start: vel.into(),
        smooth_time_ms: 0.into(),
    };
    bench.done(trap(LIMIT_PULSES_PER_MS));
    let reported = text(&mut bench, trap(above(LIMIT_PULSES_PER_MS)), &[]);
    assert_eq!(reported, "SetTrapPrm: vel_start is 1000.0000000000001; it must be from 0 to 1000");
    assert_eq!(bench.done(GetTrapPrm { core, profile }).vel_start.get(), LIMIT_PULSES_PER_MS);
}

#[test]
fn segments() {
    let mut bench = limited();
    bench.done(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() });
    let space = PtSpace { core: 1.into(), profile: 1.into(), fifo: 0.into() };
    let free = bench.done(space).value.get();
    let even = |pos: f64, time| PtData { kind: 1.into(), ..pt_data(1, pos, time) };
    let reported = text(&mut bench, even(1000.0 + 1.0 / 1_048_576.0, 1), &[]);
    assert_eq!(reported, "PtData: pos: this segment's speed is 1000.0000009536743 pulse/ms; the limit is 1000");
    assert_eq!(bench.done(space).value.get(), free);
    bench.done(even(1000.0, 1));
    bench.done(even(-6000.0, 8));
    let reported = text(&mut bench, even(-7001.0, 9), &[]);
    assert_eq!(reported, "PtData: pos: this segment's speed is -1001 pulse/ms; the limit is 1000");
    assert_eq!(bench.done(space).value.get(), free - 2);
}

#[test]
fn pt_batches_are_all_or_none() {
    let mut bench = limited();
    bench.done(PrfPt { core: 1.into(), profile: 1.into(), mode: 0.into() });
    let space = PtSpace { core: 1.into(), profile: 1.into(), fifo: 0.into() };
    let many = PtDataMany { core: 1.into(), profile: 1.into(), fifo: 0.into(), count: 3.into() };
    // Up to 1000, constant, and down from 1000 in a millisecond; the last one begins at 2·501.
    let bad = [pt_item(500.0, 1, 0), pt_item(1500.0, 2, 0), pt_item(2001.0, 3, 2)];
    let reported = text(&mut bench, many, &bad);
    assert_eq!(reported, "PtDataMany: pos: this segment's speed is 1002 pulse/ms; the limit is 1000 (item 3)");
    assert_eq!(bench.done(space).value.get(), 32);
    let good = [pt_item(500.0, 1, 0), pt_item(1500.0, 2, 0), pt_item(2000.0, 3, 2)];
    assert_eq!(bench.call_items(many, &good).code, 0);
    assert_eq!(bench.done(space).value.get(), 29);
}

const CORE: i16 = 1;

fn begin(of: Kind, count: usize) -> Vec<u8> {
    let (core, table, count, first) = (CORE.into(), 1.into(), (count as i32).into(), 0.into());
    match of {
        Kind::Pvt => body(PvtTable { core, table, count, first }, &[]),
        Kind::PvtEx => body(PvtTableEx { core, table, count, first }, &[]),
        Kind::Complete(begin, end) => {
            let (vel_begin, vel_end) = (begin.into(), end.into());
            body(PvtTableComplete { core, table, count, first, vel_begin, vel_end }, &[])
        }
        Kind::Percent(begin) => body(PvtTablePercent { core, table, count, first, vel_begin: begin.into() }, &[]),
        Kind::Continuous => body(PvtTableContinuous { core, table, count, first, time_begin: 0.0.into() }, &[]),
    }
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Pvt,
    PvtEx,
    Complete(f64, f64),
    Percent(f64),
    Continuous,
}

/// Sends a table; the text of its refusal, if it is refused.
fn load(bench: &mut Bench<8>, of: Kind, points: &[&[f64]]) -> Option<String> {
    let number = match of {
        Kind::Pvt => opcode::PvtTable,
        Kind::PvtEx => opcode::PvtTableEx,
        Kind::Complete(..) => opcode::PvtTableComplete,
        Kind::Percent(_) => opcode::PvtTablePercent,
        Kind::Continuous => opcode::PvtTableContinuous,
    };
    let mut sent = begin(of, points.len());
    points.iter().for_each(|point| point.iter().for_each(|x| sent.extend_from_slice(&x.to_le_bytes())));
    let tag = bench.post_raw(number, protocol::record::Lane::Immediate, &sent);
    let answer = bench.wait(tag);
    if answer.code == 0 {
        return None;
    }
    assert_eq!(answer.code, 7);
    Some(describe_opcode(number, answer.refusal()).to_string())
}

/// Every description: the velocity of a point, the peak between points, the speed of a cruise.
#[test]
fn pvt_tables() {
    let mut bench = limited();
    let up = above(LIMIT_PULSES_PER_MS);
    let mut is = |of: Kind, points: &[&[f64]], reported: &str| {
        let found = load(&mut bench, of, points).unwrap_or_default();
        assert_eq!(found, reported, "{of:?} {points:?}");
    };
    // Points at the limit, and a double above it.
    is(Kind::Pvt, &[&[0.0, 0.0, LIMIT_PULSES_PER_MS], &[1.0, 1000.0, LIMIT_PULSES_PER_MS]], "");
    let fast = "vel: this segment's speed is 1000.0000000000001 pulse/ms; the limit is 1000 (item 2)";
    is(Kind::Pvt, &[&[0.0, 0.0, 0.0], &[1.0, 500.0, up]], &format!("PvtTable: {fast}"));
    is(Kind::PvtEx, &[&[0.0, 0.0, LIMIT_PULSES_PER_MS, -LIMIT_PULSES_PER_MS], &[9.0, 1000.0, 0.0, 0.0]], "");
    let ex = "this segment's speed is -1000.0000000000001 pulse/ms; the limit is 1000 (item 1)";
    is(Kind::PvtEx, &[&[0.0, 0.0, 0.0, -up], &[9.0, 1000.0, 0.0, 0.0]], &format!("PvtTableEx: vel_end: {ex}"));
    // Inside: 3/2·p/T from rest to rest.
    is(Kind::Pvt, &[&[0.0, 0.0, 0.0], &[3.0, 2000.0, 0.0]], "");
    let inside = "pos: this segment's speed is 1000.5 pulse/ms; the limit is 1000 (item 2)";
    is(Kind::Pvt, &[&[0.0, 0.0, 0.0], &[3.0, 2001.0, 0.0]], &format!("PvtTable: {inside}"));
    is(Kind::PvtEx, &[&[0.0, 0.0, 0.0, 0.0], &[3.0, -2000.0, 0.0, 0.0]], "");
    is(Kind::PvtEx, &[&[0.0, 0.0, 0.0, 0.0], &[3.0, 2001.0, 0.0, 0.0]], &format!("PvtTableEx: {inside}"));
    is(Kind::Complete(0.0, 0.0), &[&[0.0, 0.0], &[3.0, 2000.0]], "");
    is(
        Kind::Complete(0.0, 0.0),
        &[&[0.0, 0.0], &[3.0, 2001.0]],
        &format!("PvtTableComplete: {}", inside.replace("item 2", "item 1")),
    );
    is(Kind::Complete(LIMIT_PULSES_PER_MS, LIMIT_PULSES_PER_MS), &[&[0.0, 0.0], &[1.0, 1000.0]], "");
    let whole = "PvtTableComplete: vel_end: this segment's speed is 1000.0000000000001 pulse/ms; the limit is 1000";
    is(Kind::Complete(0.0, up), &[&[0.0, 0.0], &[1.0, 1000.0]], whole);
    // Percent: 2·p/T − v, whatever the percentage is.
    for percent in [0.0, 50.0, 100.0] {
        is(Kind::Percent(0.0), &[&[0.0, 0.0, percent], &[2.0, 1000.0, 0.0]], "");
        let reported =
            "PvtTablePercent: pos: this segment's speed is 1000.0000000000001 pulse/ms; the limit is 1000 (item 2)";
        is(Kind::Percent(0.0), &[&[0.0, 0.0, percent], &[2.0, up, 0.0]], reported);
    }
    let whole = "PvtTablePercent: vel_begin: this segment's speed is 1000.0000000000001 pulse/ms; the limit is 1000";
    is(Kind::Percent(up), &[&[0.0, 0.0, 0.0], &[2.0, 1000.0, 0.0]], whole);
    // Continuous: a cruise at velMax, which may be above the limit if it is not reached.
    let point = |pos: f64, vel_max: f64| [pos, 0.0, 50.0, vel_max, 1.0, 1.0];
    is(Kind::Continuous, &[&point(0.0, LIMIT_PULSES_PER_MS), &point(3e6, 1.0)], "");
    let reported =
        "PvtTableContinuous: vel_max: this segment's speed is 1000.0000000000001 pulse/ms; the limit is 1000 (item 1)";
    is(Kind::Continuous, &[&point(0.0, up), &point(3e6, 1.0)], reported);
    is(Kind::Continuous, &[&point(0.0, 1e6), &point(1e6, 1.0)], "");
    let reported = load(&mut bench, Kind::Continuous, &[&point(0.0, 1e6), &point(1.0001e6, 1.0)]).unwrap();
    assert!(
        reported.contains("this segment's speed is 1000.04") && reported.contains("the limit is 1000"),
        "{reported}"
    );
}

/// Random cubics near the limit against their exact peaks.
#[test]
fn random_cubics_against_rationals() {
    let mut bench = limited();
    let mut chance = Chance::new(72);
    let (mut taken, mut refused) = (0, 0);
    let whole = |x: i64| BigRational::from_integer(BigInt::from(x));
    for _ in 0..3_000 {
        let t = (1.0 + chance.below(1000) as f64) / 8.0;
        let vel =
            |chance: &mut Chance| chance.sign() * LIMIT_PULSES_PER_MS * [0.0, 0.3, 0.9, 1.0][chance.below(4) as usize];
        let (v0, v1) = (vel(&mut chance), vel(&mut chance));
        // The displacement for which the peak is about the limit, found by doubles; then near it.
        let peak = |p: f64| {
            let (w0, w1) = (v0 * t, v1 * t);
            let (c2, c3) = (3.0 * p - 2.0 * w0 - w1, w0 + w1 - 2.0 * p);
            let top = -c2 / (3.0 * c3);
            let inner = if top > 0.0 && top < 1.0 { (w0 + c2 * top) / t } else { 0.0 };
            inner.abs().max(v0.abs()).max(v1.abs())
        };
        let (mut low, mut high) = (0.0, 10.0 * LIMIT_PULSES_PER_MS * t);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if peak(middle) <= LIMIT_PULSES_PER_MS { low = middle } else { high = middle }
        }
        let p = low * [1.0, 1.0 + 1e-6, 1.0 - 1e-6, 1.0 + 1e-8, 1.01, 0.7][chance.below(6) as usize];
        let exact = {
            let (t, p) = (rational(t), rational(p));
            let (w0, w1) = (rational(v0) * &t, rational(v1) * &t);
            let c2 = &p * whole(3) - &w0 * whole(2) - &w1;
            let c3 = &w0 + &w1 - &p * whole(2);
            let mut most = rational(v0).abs().max(rational(v1).abs());
            if c3 != whole(0) {
                let top = -&c2 / (&c3 * whole(3));
                if top > whole(0) && top < whole(1) {
                    most = most.max(((&w0 + &c2 * &top) / &t).abs());
                }
            }
            most
        };
        match load(&mut bench, Kind::Pvt, &[&[0.0, 0.0, v0], &[t, p, v1]]) {
            None => {
                assert!(exact <= rational(LIMIT_PULSES_PER_MS * (1.0 + 2e-9)), "{exact} for {v0} {v1} {p} {t}");
                taken += 1;
            }
            Some(reported) => {
                assert!(
                    reported.contains("the limit is 1000") && exact > rational(LIMIT_PULSES_PER_MS),
                    "{reported}: {exact}"
                );
                refused += 1;
            }
        }
    }
    assert!(taken > 1000 && refused > 500, "{taken} {refused}");
}

fn many(items: &[(i32, i32)], vel: f64, end: f64) -> (LnXYMany, Vec<PathXY>) {
    let head = LnXYMany {
        core: 1.into(),
        crd: 1.into(),
        fifo: 0.into(),
        count: (items.len() as u16).into(),
        syn_vel: vel.into(),
        syn_acc: 10.0.into(),
        vel_end: end.into(),
    };
    (head, items.iter().map(|(x, y)| PathXY { x: (*x).into(), y: (*y).into() }).collect())
}

/// Axes 1 and 2 as X and Y, with no other limit than that of the steps.
fn prepared() -> Box<Bench<8>> {
    let mut bench = limited();
    bench.servo_on(1);
    bench.servo_on(2);
    bench.done(SetCrdPrm { syn_vel_max: 30000.0.into(), syn_acc_max: 1000.0.into(), ..prm() });
    bench
}

#[test]
fn lines_by_the_share_of_each_axis() {
    let mut bench = prepared();
    let free = space(&mut bench, 0);
    let reported = text(&mut bench, line(1000, 0, above(LIMIT_PULSES_PER_MS), 1.0), &[]);
    assert_eq!(
        reported,
        "LnXY: syn_vel: axis 1 would go at 1000.0000000000001 pulse/ms; the board's steps are limited to 1000"
    );
    let reported = text(&mut bench, line(0, -7, above(LIMIT_PULSES_PER_MS), 1.0), &[]);
    assert!(reported.starts_with("LnXY: syn_vel: axis 2 would go at 1000.0000000000001 pulse/ms"), "{reported}");
    // 3-4-5: Y has 0.8 of the speed.
    let reported = text(&mut bench, line(3000, 4000, 1250.001, 1.0), &[]);
    assert!(
        reported.starts_with("LnXY: syn_vel: axis 2 would go at 1000.000") && reported.ends_with("limited to 1000"),
        "{reported}"
    );
    assert_eq!(space(&mut bench, 0), free);
    bench.done(line(3000, 4000, 1250.0, 1.0));
    bench.done(line(4000, 4000, LIMIT_PULSES_PER_MS, 1.0));
    assert_eq!(space(&mut bench, 0), free - 2);
    // A speed limited by synVelMax is not faster.
    let mut bench = limited();
    bench.servo_on(1);
    bench.servo_on(2);
    bench.done(SetCrdPrm { syn_vel_max: LIMIT_PULSES_PER_MS.into(), syn_acc_max: 1000.0.into(), ..prm() });
    bench.done(line(1000, 0, 20000.0, 1.0));
}

#[test]
fn many_lines_are_all_or_none() {
    let mut bench = prepared();
    let free = space(&mut bench, 0);
    let (head, items) = many(&[(1000, 1000), (2000, 2000), (3000, 2000)], 1400.0, 0.0);
    let reported = text(&mut bench, head, &items);
    assert_eq!(
        reported,
        "LnXYMany: syn_vel: axis 1 would go at 1400 pulse/ms; the board's steps are limited to 1000 (item 3)"
    );
    assert_eq!(space(&mut bench, 0), free);
    assert_eq!(bench.call_items(head, &items[..2]).code, 7, "a length that is not the count's");
    let (head, items) = many(&[(1000, 1000), (2000, 2000)], 1400.0, 0.0);
    assert_eq!(bench.call_items(head, &items).code, 0);
    assert_eq!(space(&mut bench, 0), free - 2);
}

/// Without look-ahead a motion begins at the speed at which the one before ends.
#[test]
fn a_motion_is_entered_as_fast_as_the_one_before_ends() {
    let diagonal = |end: f64, x: i32| LnXY { vel_end: end.into(), ..line(x, x, 1400.0, 100.0) };
    let mut bench = prepared();
    // 1400²/2/100 = 9800 pulses to get there; along X alone then.
    bench.done(diagonal(1400.0, 20_000));
    let reported = text(&mut bench, line(40_000, 20_000, 500.0, 100.0), &[]);
    assert_eq!(reported, "LnXY: syn_vel: axis 1 would go at 1400 pulse/ms; the board's steps are limited to 1000");
    let (head, items) = many(&[(40_000, 20_000)], 500.0, 0.0);
    let reported = text(&mut bench, head, &items);
    assert!(reported.contains("axis 1 would go at 1400 pulse/ms"), "{reported}");
    // At standstill in between.
    let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
    bench.done(BufDelay { core, crd, delay_ms: 1.into(), fifo });
    bench.done(line(40_000, 20_000, 500.0, 100.0));
    // Too short to be that fast at its end: 1000² = 2·100·5000.
    let mut bench = prepared();
    bench.done(LnXY { vel_end: 1400.0.into(), ..line(3000, 4000, 1240.0, 100.0) });
    bench.done(line(40_000, 4000, 500.0, 100.0));
    let mut bench = prepared();
    bench.done(LnXY { vel_end: 1400.0.into(), ..line(3006, 4008, 1240.0, 100.0) });
    let reported = text(&mut bench, line(40_000, 4008, 500.0, 100.0), &[]);
    assert!(reported.contains("axis 1 would go at 1000.99"), "{reported}");
    // The next one brakes, the one after it is slow enough.
    let mut bench = prepared();
    bench.done(diagonal(1400.0, 20_000));
    bench.done(LnXY { syn_vel: 500.0.into(), ..diagonal(500.0, 40_000) });
    bench.done(line(60_000, 40_000, 500.0, 100.0));
}

/// The greatest share that each coordinate has in the direction of an arc.
#[test]
fn arcs_by_what_they_pass() {
    // From (0, 0) about (0, r): counterclockwise the direction turns from +X to +Y in a quarter.
    let quarter = |vel: f64, x: i32, y: i32, dir| ArcXYC { syn_vel: vel.into(), ..arc(x, y, 0.0, 5000.0, dir) };
    let mut bench = prepared();
    let reported = text(&mut bench, quarter(above(LIMIT_PULSES_PER_MS), 5000, 5000, 1), &[]);
    assert!(reported.starts_with("ArcXYC: syn_vel: axis 1 would go at 1000.0000000000001 pulse/ms"), "{reported}");
    bench.done(quarter(LIMIT_PULSES_PER_MS, 5000, 5000, 1));
    // From a third point of the circle, (4000, 2000) about its middle, to (5000, 5000): 0.8 of X at
    // most, Y all of it.
    let part = |vel: f64, x: i32, y: i32| ArcXYC {
        syn_vel: vel.into(),
        x_center: (-4000.0).into(),
        y_center: 3000.0.into(),
        ..arc(x, y, 0.0, 0.0, 1)
    };
    let from = || {
        let mut bench = prepared();
        bench.done(line(4000, 2000, 100.0, 1.0));
        bench
    };
    // To (4800, 3600): directions from (0.6, 0.8) to (0.28, 0.96).
    let mut bench = from();
    bench.done(part(1041.0, 4800, 3600));
    let reported = text(&mut from(), part(1042.0, 4800, 3600), &[]);
    assert!(reported.starts_with("ArcXYC: syn_vel: axis 2 would go at 1000.3"), "{reported}");
    // Past (5000, 5000), where Y has all of the speed, to (4800, 6400).
    let reported = text(&mut from(), part(1020.0, 4800, 6400), &[]);
    assert!(reported.starts_with("ArcXYC: syn_vel: axis 2 would go at 1020"), "{reported}");
    // Clockwise instead it passes all four.
    let reported = text(&mut from(), ArcXYC { circle_dir: 0.into(), ..part(1020.0, 4800, 3600) }, &[]);
    assert!(reported.starts_with("ArcXYC: syn_vel: axis 1 would go at 1020"), "{reported}");
    // A full circle.
    let reported = text(&mut from(), part(1001.0, 4000, 2000), &[]);
    assert!(reported.starts_with("ArcXYC: syn_vel: axis 1 would go at 1001"), "{reported}");
    from().done(part(LIMIT_PULSES_PER_MS, 4000, 2000));
}

/// The share of a coordinate of random arcs, against their directions one by one.
#[test]
fn shares_of_random_arcs() {
    use dispatcher::plan::geometry::Geometry;
    use servo::path::Plane;
    let mut chance = Chance::new(73);
    for _ in 0..2000 {
        let mut at = || (chance.next() % 2001) as i32 - 1000;
        let (to, from) = ([at(), at()], [f64::from(at()), f64::from(at()), 0.0, 0.0]);
        let (ccw, sign) = (at() & 1 == 0, if at() & 1 == 0 { 1.0 } else { -1.0 });
        let chord = [f64::from(to[0]) - from[0], f64::from(to[1]) - from[1]];
        let radius = sign * (1.0 + f64::from(at().abs()) / 300.0) * chord[0].hypot(chord[1]) / 2.0;
        let Ok(geometry) = Geometry::arc_radius(&from, Plane::Xy, to, radius, ccw) else { continue };
        let [start, _] = geometry.tangents;
        let whole = geometry.length / radius.abs() * if ccw { 1.0 } else { -1.0 };
        let mut most = [0.0f64; 2];
        for step in 0..=4000 {
            let (sin, cos) = (whole * f64::from(step) / 4000.0).sin_cos();
            most[0] = most[0].max((start[0] * cos - start[1] * sin).abs());
            most[1] = most[1].max((start[0] * sin + start[1] * cos).abs());
        }
        for (coordinate, most) in most.into_iter().enumerate() {
            let share = geometry.share(coordinate);
            assert!(share <= most + 2e-6 && share >= most - 1e-9, "{coordinate}: {share} {most} {geometry:?}");
        }
        assert_eq!((geometry.share(2), geometry.share(3)), (0.0, 0.0));
    }
}

#[test]
fn axes_that_go_along_or_aside() {
    let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
    let gear = |axis: i16, pos: i32| BufGear { core, crd, axis: axis.into(), pos: pos.into(), fifo };
    let mut bench = prepared();
    bench.done(gear(3, -500));
    bench.done(gear(4, 2000));
    // Axis 4 moves twice as far as the path.
    let reported = text(&mut bench, line(1000, 0, 501.0, 1.0), &[]);
    assert_eq!(reported, "LnXY: syn_vel: axis 4 would go at 1002 pulse/ms; the board's steps are limited to 1000");
    let reported = text(&mut bench, line(1000, 0, 500.0000001, 1.0), &[]);
    assert!(reported.contains("axis 4 would go at 1000.0000002"), "{reported}");
    bench.done(line(1000, 0, 500.0, 1.0));
    // The next one has no gear.
    bench.done(line(2000, 0, LIMIT_PULSES_PER_MS, 1.0));
    let aside = |vel: f64| BufMove {
        core,
        crd,
        axis: 3.into(),
        pos: 1000.into(),
        vel: vel.into(),
        acc: 1.0.into(),
        modal: 1.into(),
        fifo,
    };
    bench.done(aside(LIMIT_PULSES_PER_MS));
    let reported = text(&mut bench, aside(above(LIMIT_PULSES_PER_MS)), &[]);
    assert!(
        reported.starts_with("BufMove: vel is 1000.0000000000001; it must be from ") && reported.ends_with("to 1000"),
        "{reported}"
    );
}

/// With look-ahead the limits of coordinates limit a motion first.
#[test]
fn look_ahead() {
    let mut bench = prepared();
    bench.done(ahead(1.0, 10.0, 50));
    let free = space(&mut bench, 0);
    let reported = text(&mut bench, line(1000, 0, 1001.0, 1.0), &[]);
    assert_eq!(reported, "LnXY: syn_vel: axis 1 would go at 1001 pulse/ms; the board's steps are limited to 1000");
    assert_eq!(space(&mut bench, 0), free);
    let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
    let limit = |vel: f64| SetCrdLimit { core, crd, coordinate: 1.into(), vel_max: vel.into(), acc_max: 0.0.into() };
    bench.done(limit(LIMIT_PULSES_PER_MS));
    bench.done(line(1000, 0, 1001.0, 1.0));
    // Waiting motions keep their limits, and so do those after them.
    bench.done(limit(0.0));
    bench.done(line(2000, 0, 1001.0, 1.0));
    bench.done(flush());
    let reported = text(&mut bench, line(3000, 0, 1001.0, 1.0), &[]);
    assert!(reported.contains("axis 1 would go at 1001"), "{reported}");
    // A gear by the speed that the limits leave.
    bench.done(limit(100.0));
    bench.done(BufGear { core, crd, axis: 3.into(), pos: 10_000.into(), fifo });
    bench.done(line(3000, 0, 1001.0, 1.0));
}

/// An axis at the limit keeps it, and no tick of it is longer.
#[test]
fn what_is_taken_keeps_it() {
    let mut bench = prepared();
    bench.done(LnXY { vel_end: 1200.0.into(), ..line(30_000, 40_000, 1250.0, 100.0) });
    bench.done(LnXY { vel_end: 900.0.into(), ..line(60_000, 80_000, 1250.0, 100.0) });
    bench.done(line(100_000, 80_000, LIMIT_PULSES_PER_MS, 100.0));
    assert_eq!(bench.call(start_crd(1)).code, 0);
    let mut before = *bench.server.view();
    let mut most = 0;
    while bench.server.view().crds[0].runs || before.crds[0].runs {
        before = *bench.server.view();
        bench.step();
        for (now, then) in bench.server.view().axes.iter().zip(&before.axes) {
            most = most.max(now.pos.0.abs_diff(then.pos.0));
        }
    }
    // A quarter of a millisecond, and the rounding of two positions.
    assert!((249 << 22..=(250 << 22) + 1).contains(&most), "{most}");
}
