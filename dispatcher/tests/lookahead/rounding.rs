//! Rounding to whole pulses is no turn; what it does not explain keeps the limits.
use super::{Ahead, LIMITS, TICK_NS, hardest, plan, polyline, positions, run, spiral};
use crate::chance::Chance;
use dispatcher::plan::look_ahead::Limits;
use std::f64::consts::TAU;

/// Points of a curve, in whole pulses, from t = 0 to 1 in so many lines.
fn curve(lines: usize, at: impl Fn(f64) -> [f64; 2]) -> Vec<[i32; 2]> {
    let [x0, y0] = at(0.0).map(f64::round);
    let point = |n| at(n as f64 / lines as f64).map(f64::round);
    (1..=lines).map(point).map(|[x, y]| [(x - x0) as i32, (y - y0) as i32]).collect()
}

fn circle(radius: f64, turns: f64, lines: usize) -> Vec<[i32; 2]> {
    curve(lines, |t| [(t * turns * TAU).cos(), (t * turns * TAU).sin()].map(|x| radius * x))
}

/// How long these points take, ms, at speeds up to 200 pulse/ms and with all limits so many times
/// higher.
fn time_of(points: &[[i32; 2]], scale: f64, limits: Limits) -> f64 {
    let Limits { vel, acc, corner } = limits;
    let [vel, acc] = [vel, acc].map(|all| all.map(|limit| limit * scale));
    let mut ahead = Ahead::<256>::new(Limits { vel, acc, corner });
    let mut ms = 0.0;
    for call in polyline(points, vel[0], acc[0]) {
        while !ahead.push_motion(&call.geometry, call.vel, call.acc) {
            ms += ahead.take(true).unwrap().ms;
        }
        while let Some(planned) = ahead.take(false) {
            ms += planned.ms;
        }
    }
    while let Some(planned) = ahead.take(true) {
        ms += planned.ms;
    }
    ms
}

/// What rounding to whole pulses makes of a curve does not slow it. A circle in 3,600 lines takes
/// as long as one in 360; without this rule it took 2,171 ms. A spiral takes as long as with pulses
/// 64 times finer.
#[test]
fn rounding_is_no_turn() {
    let limits = |acc: f64, corner: f64| Limits { vel: [200.0; 4], acc: [acc; 4], corner };
    let circle_time = |lines| time_of(&circle(20_000.0, 1.0, lines), 1.0, limits(4.0, 2.0));
    // From standstill to standstill at 200 pulse/ms.
    let fastest = TAU * 20_000.0 / 200.0 + 50.0;
    let [coarse, fine] = [360, 3_600].map(circle_time);
    println!("circle: {coarse:.1} and {fine:.1} ms, {fastest:.1} at least");
    assert!((fastest..fastest + 2.0).contains(&coarse) && (fastest..fastest + 8.0).contains(&fine), "{coarse} {fine}");
    let quarter = time_of(&circle(100_000.0, 0.25, 1_570), 1.0, limits(1.0, 5.0));
    let fastest = TAU * 25_000.0 / 200.0 + 200.0;
    println!("quarter circle: {quarter:.1} ms, {fastest:.1} at least");
    assert!((fastest..1.01 * fastest).contains(&quarter), "{quarter}");
    let spiral = |scale: f64| {
        let at = |t: f64| {
            let radius = scale * (1_000.0 + 19_000.0 * t);
            [radius * (t * 16.0 * TAU).cos(), radius * (t * 16.0 * TAU).sin()]
        };
        time_of(&curve(10_000, at), scale, limits(4.0, 2.0))
    };
    let [pulses, fine] = [1.0, 64.0].map(spiral);
    println!("spiral: {pulses:.1} ms, {fine:.1} ms with pulses 64 times finer");
    assert!((pulses / fine - 1.0).abs() < 0.01, "{pulses} {fine}");
}

/// On curves the second difference of a coordinate over the corner time T is at most L·T² and the
/// two pulses of rounding; over twice that time it is within 1 % of that.
#[test]
fn a_curve_keeps_its_limits_over_the_corner_time() {
    let curves = [
        ("spiral of 100 pulses", spiral()),
        ("circle of 35 pulses", polyline(&circle(20_000.0, 1.0, 3_600), 200.0, 1.0)),
        ("circle of 31 pulses", polyline(&circle(5_000.0, 2.0, 2_000), 200.0, 1.0)),
        ("circle of 4 pulses", polyline(&circle(200.0, 4.0, 1_200), 200.0, 1.0)),
    ];
    for (name, calls) in curves {
        let positions = positions(plan::<256>(&calls));
        for (ms, part) in [(LIMITS.corner, 1.0), (2.0 * LIMITS.corner, 1.01)] {
            let half = (ms * 1e6 / TICK_NS) as usize;
            let windows = positions.windows(2 * half + 1);
            let worst = windows.fold([0.0f64; 2], |worst, window| {
                let second = |i: usize| (window[2 * half][i] - 2.0 * window[half][i] + window[0][i]).abs();
                [0, 1].map(|i| worst[i].max((second(i) - 2.0) / (ms * ms) / LIMITS.acc[i]))
            });
            println!("{name}: over {ms} ms {worst:.4?} of the limits");
            assert!(worst.iter().all(|worst| *worst <= part), "{name} over {ms} ms: {worst:?}");
        }
    }
}

/// Random paths of short and long lines: zigzags, steps, loops, corners, of whatever size beside a
/// pulse. What rounding cannot explain keeps the rule.
#[test]
fn turns_that_rounding_does_not_explain_keep_their_limits() {
    let mut chance = Chance::new(29);
    // Over the corner time the plan leaves out two pulses, and so does the trace.
    let four_pulses = 4.0 / (LIMITS.corner * LIMITS.corner);
    let (mut worst, mut largest, mut seen) = (0.0f64, 0.0f64, 0);
    for _ in 0..60 {
        let (mut angle, mut x, mut y) = (0.0f64, 0.0f64, 0.0f64);
        let mut points = Vec::new();
        for _ in 0..6 {
            let length = 2.0 * 100f64.powf(chance.unit());
            let (kind, turn) = ((chance.unit() * 4.0) as u32, chance.unit() * 2.0 * 0.3f64.powf(4.0 * chance.unit()));
            for n in 0..40 {
                angle += match kind {
                    0 => turn * if n % 2 == 0 { 1.0 } else { -1.0 },
                    1 => turn,
                    2 => turn * (chance.unit() - 0.5),
                    _ if n == 20 => 2.0 * turn,
                    _ => 0.0,
                };
                let own = length * (0.5 + chance.unit());
                (x, y) = (x + own * angle.cos(), y + own * angle.sin());
                points.push([x.round() as i32, y.round() as i32]);
            }
        }
        let calls = polyline(&points, 150.0, 3.0);
        let entries = plan::<256>(&calls);
        assert!(entries == plan::<1024>(&calls));
        let (middles, vel, _) = run(&calls, &entries);
        let [acc, apart] = hardest(&middles);
        (worst, seen) = (worst.max(acc), seen + middles.len());
        assert!(vel <= 1.0 + 1e-6 && acc <= 1.0 && apart <= 1.0 + four_pulses, "{vel} {acc} {apart} {points:?}");
        largest = largest.max(apart);
    }
    println!("{seen} middles, {worst:.4} of the limits, {largest:.4} over the corner time");
    assert!(worst > 0.95 && seen > 5_000, "{worst} {seen}");
}
