//! The tables of GXN chapter 4 as golden tests. Every expected number is worked out by hand, in
//! the comment beside it, or from a closed form.
use crate::tables_bench as bench;
use dispatcher::plan::pvt::TableKind;
use servo::units::Exact;

use bench::{Bench, Shelf};

const PULSE: f64 = 1.0 / 4194304.0;

fn rows(rows: &[&[f64]]) -> Vec<Vec<f64>> {
    rows.iter().map(|row| row.to_vec()).collect()
}

fn shelf(kind: TableKind, points: &[&[f64]]) -> (Shelf, Vec<f64>) {
    let mut shelf = Shelf::default();
    let answers = shelf.add(kind, &rows(points)).expect("the manual's own data");
    (shelf, answers)
}

/// Runs table 0 and checks (ms, pulse, pulse/ms); positions to the unit, velocities to 1e-9.
#[track_caller]
fn follows<'a>(shelf: &'a Shelf, passes: u32, expected: &[(f64, f64, f64)]) -> Bench<'a> {
    let mut bench = Bench::start(shelf, 0, 7_000_000, Exact(0), passes);
    for &(t, p, v) in expected {
        let (pos, vel, _) = bench.at_ms(t);
        assert!((pos - p).abs() <= PULSE, "at {t} ms: {pos}, expected {p}");
        assert!((vel - v).abs() <= 1e-9, "at {t} ms: velocity {vel}, expected {v}");
    }
    bench
}

/// Whether the motion ends at `t` ms: it runs one ns before and has ended at `p` then.
#[track_caller]
fn ends(bench: &mut Bench, t: f64, p: f64) {
    let ns = (t * 1e6).round() as u64;
    let before = bench.step(ns - 1);
    assert_eq!(before.state, servo::segment::generator_state::GeneratorState::Running);
    let (pos, vel, running) = bench.at_ms(t);
    assert!(!running && vel == 0.0 && (pos - p).abs() <= PULSE, "{pos} {vel} {running}");
    let (pos, _, running) = bench.at_ms(t + 1000.0);
    assert!(!running && (pos - p).abs() <= PULSE, "it must stay at {p}: {pos}");
}

/// Table 4-2: 1000 ms of delay, then 3000 ms a pass; the time returns to 1000, not to 0.
#[test]
fn table_4_2_waits_and_loops() {
    let (shelf, _) = shelf(
        TableKind::Pvt,
        &[&[1000.0, 0.0, 0.0], &[2000.0, 5000.0, 10.0], &[3000.0, 15000.0, 10.0], &[4000.0, 20000.0, 0.0]],
    );
    let mut bench = follows(
        &shelf,
        0,
        &[
            (0.05, 0.0, 0.0),
            (999.9, 0.0, 0.0),
            (1000.0, 0.0, 0.0),
            // p = 5000, v0 = 0, v1 = 10 over 1 s: τ² · 5000
            (1500.0, 1250.0, 5.0),
            (2000.0, 5000.0, 10.0),
            (2500.0, 10000.0, 10.0),
            (3000.0, 15000.0, 10.0),
            (3500.0, 18750.0, 5.0),
            (4000.0, 20000.0, 0.0),
            (4500.0, 21250.0, 5.0),
            (5000.0, 25000.0, 10.0),
        ],
    );
    assert_eq!(bench.run.passes(), 1);
    assert_eq!(bench.run.time(servo::units::Ns(7_000_000 + 5_000_000_000)).0, 2_000_000_000);
    let (pos, vel, running) = bench.at_ms(1000.0 + 3000.0 * 1000.0 + 500.0);
    assert!(running && (pos - 20_001_250.0).abs() <= PULSE && (vel - 5.0).abs() < 1e-9);
    assert_eq!(bench.run.passes(), 1000);
}

/// Table 4-3, four groups: the middle of each segment is (p0 + p1)/2 + (v0 − v1)·T/8, its velocity
/// 1.5·(p1 − p0)/T − (v0 + v1)/4.
#[test]
fn table_4_3_groups() {
    let (first, _) = shelf(
        TableKind::Pvt,
        &[&[0.0, 0.0, 0.0], &[1000.0, 5000.0, 10.0], &[2000.0, 15000.0, 10.0], &[3000.0, 20000.0, 0.0]],
    );
    let mut bench = follows(
        &first,
        1,
        &[(500.0, 1250.0, 5.0), (1000.0, 5000.0, 10.0), (1500.0, 10000.0, 10.0), (2500.0, 18750.0, 5.0)],
    );
    ends(&mut bench, 3000.0, 20000.0);
    let (second, _) = shelf(
        TableKind::Pvt,
        &[&[0.0, 0.0, 0.0], &[1000.0, 5000.0, 9.0], &[2000.0, 15000.0, 9.0], &[3000.0, 20000.0, 0.0]],
    );
    let mut bench = follows(
        &second,
        1,
        &[
            (500.0, 2500.0 - 9000.0 / 8.0, 7.5 - 2.25),
            (1000.0, 5000.0, 9.0),
            (1500.0, 10000.0, 15.0 - 4.5),
            (2500.0, 17500.0 + 9000.0 / 8.0, 5.25),
        ],
    );
    ends(&mut bench, 3000.0, 20000.0);
    let (third, _) = shelf(
        TableKind::Pvt,
        &[&[0.0, 0.0, 0.0], &[1000.0, 5000.0, 7.5], &[2333.0, 15000.0, 7.5], &[3333.0, 20000.0, 0.0]],
    );
    let mut bench = follows(
        &third,
        1,
        &[
            (500.0, 2500.0 - 7500.0 / 8.0, 7.5 - 1.875),
            (1000.0, 5000.0, 7.5),
            (1666.5, 10000.0, 15000.0 / 1333.0 - 3.75),
            (2333.0, 15000.0, 7.5),
        ],
    );
    ends(&mut bench, 3333.0, 20000.0);
    let (fourth, _) = shelf(
        TableKind::Pvt,
        &[&[0.0, 0.0, 0.0], &[750.0, 1667.0, 6.6669], &[2250.0, 18333.0, 6.6669], &[3000.0, 20000.0, 0.0]],
    );
    let mut bench = follows(
        &fourth,
        1,
        &[
            (375.0, 833.5 - 6.6669 * 750.0 / 8.0, 1.5 * 1667.0 / 750.0 - 6.6669 / 4.0),
            (1500.0, 10000.0, 1.5 * 16666.0 / 1500.0 - 6.6669 / 2.0),
        ],
    );
    ends(&mut bench, 3000.0, 20000.0);
}

/// Table 4-4: knots are kept whatever the curve between them.
#[test]
fn table_4_4_groups() {
    for v in [15.0, 5.0] {
        let (shelf, _) = shelf(
            TableKind::Pvt,
            &[&[0.0, 0.0, 0.0], &[1000.0, 5000.0, v], &[2000.0, 15000.0, v], &[3000.0, 20000.0, 0.0]],
        );
        let mut bench = follows(
            &shelf,
            1,
            &[
                (500.0, 2500.0 - v * 125.0, 7.5 - v / 4.0),
                (1000.0, 5000.0, v),
                (1500.0, 10000.0, 15.0 - v / 2.0),
                (2000.0, 15000.0, v),
            ],
        );
        ends(&mut bench, 3000.0, 20000.0);
    }
}

/// Table 4-5: with equal steps v(i−1) + 4·v(i) + v(i+1) = 3·(p(i+1) − p(i−1))/h, so
/// 4·a + b = 45 and a + 4·b = 45: both inner velocities are 9.
#[test]
fn table_4_5_spline() {
    let (shelf, _) = shelf(
        TableKind::Complete { vel_begin: 0.0, vel_end: 0.0 },
        &[&[0.0, 0.0], &[1000.0, 5000.0], &[2000.0, 15000.0], &[3000.0, 20000.0]],
    );
    let mut bench = follows(
        &shelf,
        1,
        &[(500.0, 1375.0, 5.25), (1000.0, 5000.0, 9.0), (1500.0, 10000.0, 10.5), (2000.0, 15000.0, 9.0)],
    );
    ends(&mut bench, 3000.0, 20000.0);
    // Acceleration is continuous: from both sides (6·ΔP/T² − 2·v0/T − 4·v1/T) = 6e-3 at 1000 ms.
    for ns in [1_000_000_000 - 1000, 1_000_000_000 + 1000] {
        let mut bench = Bench::start(&shelf, 0, 0, Exact(0), 1);
        let acc = bench.step(ns).motion.acceleration();
        let acc = acc.m as f64 * 2f64.powi(-acc.e as i32);
        assert!((acc - 0.006).abs() < 1e-7, "{acc}");
    }
}

/// Table 4-6 and figure 4-6: 50000·sin²(πt/2000) through 5, 10 and 50 points. The clamped spline is
/// of fourth order: |error| ≤ 5/384·h⁴·max|f⁗|, f⁗ = 25000·(π/1000)⁴, and not far below it.
#[test]
fn table_4_6_errors_shrink() {
    let f = |t: f64| 25000.0 * (1.0 - (core::f64::consts::PI * t / 1000.0).cos());
    let mut worst = Vec::new();
    for n in [5usize, 10, 50] {
        let h = 2000.0 / (n - 1) as f64;
        let points: Vec<Vec<f64>> = (0..n).map(|i| vec![h * i as f64, f(h * i as f64)]).collect();
        let mut shelf = Shelf::default();
        shelf.add(TableKind::Complete { vel_begin: 0.0, vel_end: 0.0 }, &points).unwrap();
        let mut bench = Bench::start(&shelf, 0, 0, Exact(0), 1);
        let error = (1..20000).map(|i| (bench.at_ms(i as f64 / 10.0).0 - f(i as f64 / 10.0)).abs()).fold(0.0, f64::max);
        let bound = 5.0 / 384.0 * h.powi(4) * 25000.0 * (core::f64::consts::PI / 1000.0).powi(4);
        assert!(error <= bound && error >= bound / 8.0, "{n} points: {error}, bound {bound}");
        worst.push(error);
    }
    assert!(worst[0] / worst[1] > 10.0 && worst[1] / worst[2] > 300.0, "{worst:?}");
}

/// Table 4-7: velocities 0, 10, 10, 0 by the recursion; 60 % in the first, pure S in the last
/// segment.
#[test]
fn table_4_7_percent() {
    let (shelf, answers) = shelf(
        TableKind::Percent { vel_begin: 0.0 },
        &[&[0.0, 0.0, 60.0], &[1000.0, 5000.0, 0.0], &[2000.0, 15000.0, 100.0], &[3000.0, 20000.0, 0.0]],
    );
    assert_eq!(answers, [0.0, 10.0, 10.0, 0.0]);
    // 3 + 1 + 2 pieces.
    assert_eq!(shelf.header_of(0).points, 7);
    // First: ramps of 300 ms; peak A = 10/700; at 300 ms v = A·150, p = A·300²/6.
    // Last: ramps of 500 ms; A = −10/500; in the middle v = 5, p = 15000 + 10·500 − 0.02·500²/6.
    let a = 10.0 / 700.0;
    let mut bench = follows(
        &shelf,
        1,
        &[
            (300.0, a * 15000.0, a * 150.0),
            (500.0, a * 15000.0 + a * 150.0 * 200.0 + a * 20000.0, 5.0),
            (700.0, 5000.0 - (10.0 * 300.0 - a * 15000.0), 10.0 - a * 150.0),
            (1000.0, 5000.0, 10.0),
            (1500.0, 10000.0, 10.0),
            (2000.0, 15000.0, 10.0),
            (2500.0, 20000.0 - 5000.0 / 6.0, 5.0),
        ],
    );
    ends(&mut bench, 3000.0, 20000.0);
}

/// Table 4-8. First: 0 → 10 in 1000 ms over 5000, cruise 10000 in 1000 ms, back in 1000 ms. Second:
/// from standstill at 0.01 and braking at 0.01 to 2 within 19800. t0 = 1000 (5000), brake (10 −
/// 2)/0.01 = 800 ms over 4800, cruise 10000 in 1000 ms: 2800 ms. Then 2000 at 2 with a brake of 100
/// ms over 100: 950 ms + 100 ms.
#[test]
fn table_4_8_continuous() {
    let kind = TableKind::Continuous { time_begin: 0.0 };
    let (first, times) = shelf(kind, &[&[0.0, 0.0, 60.0, 10.0, 0.01, 0.01], &[20000.0, 0.0, 0.0, 10.0, 0.01, 0.01]]);
    assert!(times[0] == 0.0 && (times[1] - 3000.0).abs() < 1e-9, "{times:?}");
    assert_eq!(first.header_of(0).points, 8);
    let a = 10.0 / 700.0;
    let mut bench = follows(
        &first,
        1,
        &[
            (300.0, a * 15000.0, a * 150.0),
            (500.0, a * 15000.0 + a * 150.0 * 200.0 + a * 20000.0, 5.0),
            (1500.0, 10000.0, 10.0),
            (2500.0, 20000.0 - (a * 15000.0 + a * 150.0 * 200.0 + a * 20000.0), 5.0),
        ],
    );
    let (pos, vel, running) = bench.at_ms(3000.001);
    assert!(!running && vel == 0.0 && (pos - 20000.0).abs() <= PULSE);
    let (second, times) = shelf(
        kind,
        &[
            &[0.0, 0.0, 60.0, 10.0, 0.01, 0.01],
            &[19800.0, 2.0, 0.0, 2.0, 0.02, 0.02],
            &[21800.0, 0.0, 0.0, 2.0, 0.02, 0.02],
        ],
    );
    assert!((times[1] - 2800.0).abs() < 1e-9 && (times[2] - 3850.0).abs() < 1e-9, "{times:?}");
    // 3 + 1 + 3 pieces, then cruise and one ramp.
    assert_eq!(second.header_of(0).points, 10);
    let mut bench = Bench::start(&second, 0, 0, Exact(0), 1);
    for (t, p, v) in [
        (1500.0, 10000.0, 10.0),
        (2800.0, 19800.0, 2.0),
        (3300.0, 20800.0, 2.0),
        (3750.0, 21700.0, 2.0),
        (3800.0, 21775.0, 1.0),
    ] {
        let (pos, vel, _) = bench.at_ms(t);
        assert!((pos - p).abs() <= 1e-6 && (vel - v).abs() < 1e-9, "{t}: {pos} {vel}");
    }
}

/// Table 4-9 and listing 4-1: begins and ends at speed 1; middles as in table 4-3.
#[test]
fn table_4_9_begins_at_speed() {
    let points: [&[f64]; 6] = [
        &[0.0, 0.0, 1.0],
        &[1200.0, 9750.0, 15.25],
        &[2000.0, 24483.0, 20.0],
        &[3000.0, 44483.0, 20.0],
        &[3800.0, 59216.0, 15.25],
        &[5000.0, 68966.0, 1.0],
    ];
    let (shelf, _) = shelf(TableKind::Pvt, &points);
    let mut expected = Vec::new();
    for pair in points.windows(2) {
        let ([t0, p0, v0], [t1, p1, v1]) =
            (<[f64; 3]>::try_from(pair[0]).unwrap(), <[f64; 3]>::try_from(pair[1]).unwrap());
        let t = t1 - t0;
        if t0 > 0.0 {
            expected.push((t0, p0, v0));
        }
        expected.push(((t0 + t1) / 2.0, (p0 + p1) / 2.0 + (v0 - v1) * t / 8.0, 1.5 * (p1 - p0) / t - (v0 + v1) / 4.0));
    }
    let mut bench = follows(&shelf, 1, &expected);
    // Constant acceleration 14.25/1200 in the first segment: 1 + 14.25/3 at a third of it.
    ends(&mut bench, 5000.0, 68966.0);
    let mut bench = Bench::start(&shelf, 0, 0, Exact(0), 1);
    assert!((bench.at_ms(400.0).1 - 5.75).abs() < 1e-9);
}

/// Tables 4-10 to 4-13, listing 4-3, figure 4-14: X moves there and back twice. Y starts 2000 ms
/// later and runs three passes. Y moves while X turns and stands still while X cruises.
#[test]
fn tables_4_10_to_4_13_draw_the_meander() {
    let kind = TableKind::Percent { vel_begin: 0.0 };
    let mut both = Shelf::default();
    let x = both
        .add(
            kind,
            &rows(&[
                &[0.0, 0.0, 60.0],
                &[1000.0, 5000.0, 0.0],
                &[2000.0, 15000.0, 60.0],
                &[3000.0, 20000.0, 60.0],
                &[4000.0, 15000.0, 0.0],
                &[5000.0, 5000.0, 60.0],
                &[6000.0, 0.0, 0.0],
            ]),
        )
        .unwrap();
    let y = both
        .add(
            kind,
            &rows(&[
                &[2000.0, 0.0, 60.0],
                &[2500.0, 2500.0, 0.0],
                &[3500.0, 12500.0, 60.0],
                &[4000.0, 15000.0, 0.0],
                &[5000.0, 15000.0, 0.0],
            ]),
        )
        .unwrap();
    assert_eq!(x, [0.0, 10.0, 10.0, 0.0, -10.0, -10.0, 0.0]);
    assert_eq!(y, [0.0, 10.0, 10.0, 0.0, 0.0]);
    let mut x = Bench::start(&both, 0, 0, Exact(0), 2);
    let mut y = Bench::start(&both, 1, 0, Exact(0), 3);
    let corners = [
        (1000.0, 5000.0, 0.0),
        (2000.0, 15000.0, 0.0),
        (3000.0, 20000.0, 7500.0),
        (4000.0, 15000.0, 15000.0),
        (5000.0, 5000.0, 15000.0),
        (6000.0, 0.0, 22500.0),
        (7000.0, 5000.0, 30000.0),
        (8000.0, 15000.0, 30000.0),
        (9000.0, 20000.0, 37500.0),
        (10000.0, 15000.0, 45000.0),
        (11000.0, 5000.0, 45000.0),
        (12000.0, 0.0, 45000.0),
    ];
    for (t, px, py) in corners {
        let ((gx, _, _), (gy, _, _)) = (x.at_ms(t), y.at_ms(t));
        assert!((gx - px).abs() <= PULSE && (gy - py).abs() <= PULSE, "{t}: {gx} {gy}, expected {px} {py}");
        if (t / 1000.0) as u32 % 3 == 1 {
            // X cruises for the next second: Y stands still.
            let (gy, vy, _) = y.at_ms(t + 500.0);
            assert!((gy - py).abs() <= PULSE && vy.abs() < 1e-12, "{t}: {gy} {vy}");
        }
    }
    assert!(!x.at_ms(12000.0).2 && !y.at_ms(12000.0).2);
}

/// Listing 4-4: X over 30000 takes 1000 + 2000 + 1000 ms, Y over 20000 1000 less; started that much
/// later, both arrive at 4000 ms.
#[test]
fn listing_4_4_arrives_together() {
    let to = |length: f64| rows(&[&[0.0, 0.0, 100.0, 10.0, 0.01, 0.01], &[length, 0.0, 100.0, 10.0, 0.01, 0.01]]);
    let mut both = Shelf::default();
    let kind = |time_begin| TableKind::Continuous { time_begin };
    let tx = both.add(kind(0.0), &to(30000.0)).unwrap()[1];
    let ty = Shelf::default().add(kind(0.0), &to(20000.0)).unwrap()[1];
    assert!((tx - 4000.0).abs() < 1e-9 && (ty - 3000.0).abs() < 1e-9);
    both.add(kind(tx - ty), &to(20000.0)).unwrap();
    let mut x = Bench::start(&both, 0, 0, Exact(0), 1);
    let mut y = Bench::start(&both, 1, 0, Exact(0), 1);
    assert!(y.at_ms(999.9).0 == 0.0);
    // Pure S over 500 + 500 ms: A = 0.02, at 500 ms v = 5, p = 0.02·500²/6.
    let (p, v, _) = x.at_ms(500.0);
    assert!((p - 5000.0 / 6.0).abs() <= 1e-6 && (v - 5.0).abs() < 1e-9, "{p} {v}");
    let (p, v, _) = y.at_ms(1500.0);
    assert!((p - 5000.0 / 6.0).abs() <= 1e-6 && (v - 5.0).abs() < 1e-9, "{p} {v}");
    assert!(x.at_ms(3999.9).2 && y.at_ms(3999.9).2);
    let ((px, _, rx), (py, _, ry)) = (x.at_ms(4000.001), y.at_ms(4000.001));
    assert!(!rx && !ry && (px - 30000.0).abs() <= PULSE && (py - 20000.0).abs() <= PULSE);
}

/// PvtTableEx: velocity jumps at inner points take two points of the store; at the jump the new
/// velocity holds.
#[test]
fn pvt_ex_jumps() {
    // 10 throughout, then 20 throughout, then back at −30 to 0.
    let (shelf, _) = shelf(
        TableKind::PvtEx,
        &[&[5.0, 100.0, 10.0, 10.0], &[15.0, 200.0, 20.0, 20.0], &[25.0, 400.0, -30.0, 0.0], &[35.0, 250.0, 0.0, 0.0]],
    );
    assert_eq!(shelf.header_of(0).points, 6);
    let mut bench = follows(
        &shelf,
        2,
        &[
            (5.0, 0.0, 10.0),
            (10.0, 50.0, 10.0),
            (15.0, 100.0, 20.0),
            (20.0, 200.0, 20.0),
            (25.0, 300.0, -30.0),
            // v falls linearly from −30 to 0 over 10 ms: 300 − 112.5 in the middle
            (30.0, 187.5, -15.0),
            (35.0, 150.0, 10.0),
            (45.0, 250.0, 20.0),
        ],
    );
    ends(&mut bench, 65.0, 300.0);
    // Without a jump a point takes one point of the store.
    let (smooth, _) =
        self::shelf(TableKind::PvtEx, &[&[0.0, 0.0, 0.0, 10.0], &[10.0, 50.0, 10.0, 0.0], &[20.0, 100.0, 3.0, 4.0]]);
    assert_eq!(smooth.header_of(0).points, 3);
}
