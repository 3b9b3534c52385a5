//! Every description against exact arithmetic on the doubles as given, over random tables (SPEC
//! 11). Position within 2⁻¹⁶ pulse, or 2⁻⁴⁰ of peak speed × duration if that is more. Velocity
//! within 2⁻¹⁶ of the peak, and in pieces shorter than 2⁻²⁴ of the pass within 2⁻⁴⁰ of the pass
//! over the piece (16 bytes a point hold no finer times, decision 6). Loops do not drift.
use crate::tables_bench as bench;
use dispatcher::plan::pvt::TableKind;
use protocol::reason::Reason;

use bench::chance::Chance;
use bench::{Bench, Reference, Shelf, float, ms, ns};
use servo::units::Exact;

/// How the numbers of a table look.
fn number(style: u64, x: f64) -> f64 {
    match style {
        0 if x.abs() >= 1.0 => x.round(),
        1 => (x * 1000.0).round() / 1000.0,
        _ => x,
    }
}

/// Times and positions: segments of 0.01…10⁷ ms, displacements of 10⁻³…2³¹ pulses.
fn course(chance: &mut Chance, most: u64) -> Vec<(f64, f64)> {
    let n = 2 + chance.below(most - 1);
    let style = chance.below(3);
    // Some tables are even, others hold everything from the shortest to the longest.
    let (short, long) = match chance.below(3) {
        0 => (0.01, 1e7),
        1 => {
            let t = chance.log(0.01, 1e6);
            (t, t * 10.0)
        }
        _ => (0.01, 1.0),
    };
    let (small, large) = if chance.below(2) == 0 { (1e-3, 2147483648.0) } else { (1e-3, 1e4) };
    let mut t = if chance.below(2) == 0 { 0.0 } else { number(style, chance.log(1e-3, 1e5)) };
    let mut p = number(style, chance.unit() * 1e3 * chance.sign());
    let mut course = vec![(t, p)];
    for _ in 1..n {
        let length = chance.log(short, long);
        let before = t;
        t = number(style, t + length);
        if t <= before {
            t = before + length;
        }
        let most = (2e9 * (t - before)).min(large).max(small * 2.0);
        p += chance.sign() * chance.log(small, most);
        p = number(style, p);
        course.push((t, p));
    }
    course
}

struct Tally {
    segments: usize,
    tables: usize,
    refused: usize,
    worst: f64,
    worst_vel: f64,
    /// In pieces shorter than 2⁻²⁴ of the pass, as a share of the tolerance there.
    worst_short: f64,
}

/// Builds, runs and compares until `segments` segments have been run, or as many tables as
/// PVT_TABLES says.
fn campaign(
    seed: u64,
    segments: usize,
    most: u64,
    mut make: impl FnMut(&mut Chance, u64) -> (TableKind, Vec<Vec<f64>>),
) -> Tally {
    // A run of very many tables takes short ones, now and then a long one; PVT_SEED splits it into
    // parts.
    let wanted = |name: &str| std::env::var(name).map_or(0, |n| n.parse().unwrap());
    let (tables, part) = (wanted("PVT_TABLES"), wanted("PVT_SEED"));
    let (segments, often, few) = if tables == 0 { (segments, 4, 20) } else { (0, 2000, 4) };
    let mut chance = Chance::new(seed + 1000 * part);
    let mut tally = Tally { segments: 0, tables: 0, refused: 0, worst: 0.0, worst_vel: 0.0, worst_short: 0.0 };
    while tally.segments < segments || tally.tables < tables as usize {
        let most = if chance.below(often) == 0 { most } else { few };
        let (kind, points) = make(&mut chance, most);
        let mut shelf = Shelf::default();
        if let Err(refused) = shelf.add(kind, &points) {
            // Random numbers may be too fast or too far; no other reason may occur.
            let known = [
                Reason::TooFast,
                Reason::BeyondTravel,
                Reason::TableShort,
                Reason::VelocityUnreachable,
                Reason::NoDisplacement,
            ];
            assert!(known.contains(&refused.reason), "{refused:?}\n{kind:?} {points:?}");
            tally.refused += 1;
            continue;
        }
        let reference = Reference::of(kind, &points);
        let (allowed, peak) = (reference.allowed(), reference.peak());
        let passes = 1 + chance.below(3) as u32;
        let mut bench = Bench::start(&shelf, 0, chance.below(1 << 40), Exact(0), passes);
        let ends: Vec<_> = reference
            .phases
            .iter()
            .skip(1)
            .map(|phase| phase.begin.clone())
            .chain([reference.duration.clone()])
            .collect();
        for pass in 0..passes {
            let before = &reference.delay + &reference.duration * pass;
            for (phase, end) in reference.phases.iter().zip(&ends) {
                let (from, to) = (&before + &phase.begin, &before + end);
                // The first whole ns, one somewhere, and the last; now and then most are skipped.
                if pass > 0 && chance.below(8) != 0 {
                    continue;
                }
                let (first, last) = (ns(&from) + 1, ns(&to));
                if first > last {
                    continue;
                }
                for at in [first, first + chance.next() % (last - first + 1), last] {
                    let (error, slip) = bench.error(&reference, at);
                    let (share, share_vel) = (error / allowed, slip / peak);
                    assert!(
                        share <= 1.0,
                        "position off by {error}, allowed {allowed}, at {at} ns\n{kind:?} {points:?}"
                    );
                    let (bound, plain) = bound(&reference, at);
                    assert!(
                        slip <= bound * peak,
                        "velocity off by {slip}, peak {peak}, bound {bound} of it, at {at}\n{kind:?} {points:?}"
                    );
                    tally.worst = tally.worst.max(share);
                    if plain {
                        tally.worst_vel = tally.worst_vel.max(share_vel);
                    } else {
                        tally.worst_short = tally.worst_short.max(share_vel / bound);
                    }
                }
                tally.segments += 1;
            }
        }
        let end = ns(&(&reference.delay + &reference.duration * passes));
        let (error, slip) = bench.error(&reference, end + 1);
        assert!(error <= 2f64.powi(-22) && slip == 0.0, "the end is off by {error}");
        tally.tables += 1;
    }
    println!(
        "{} segments, {} tables, {} refused; worst position {:.3} of allowed, worst velocity 2^{:.1} of peak, {:.3} of allowed in short pieces",
        tally.segments,
        tally.tables,
        tally.refused,
        tally.worst,
        tally.worst_vel.log2(),
        tally.worst_short
    );
    tally
}

/// The bound of the velocity at `ns` as a share of the peak, and whether it is SPEC 11's. Times are
/// stored in units of 2⁻⁴³ of the pass at most. So a piece within one unit of the instant counts as
/// present, and next to a jump either side may hold.
fn bound(reference: &Reference, ns: u64) -> (f64, bool) {
    let since = ms(ns as i128) - &reference.delay;
    let local = &since - (&since / &reference.duration) * &reference.duration;
    let pass = float(&reference.duration);
    let unit = &reference.duration >> 43;
    if reference.jumps(&local, &unit) {
        return (f64::INFINITY, false);
    }
    let share = reference.shortest(&local, &unit) / pass;
    (2f64.powi(-16).max(2f64.powi(-40) / share), share >= 2f64.powi(-24))
}

#[test]
fn pvt_is_exact() {
    let tally = campaign(11, 450_000, 1023, |chance, most| {
        let course = course(chance, most);
        let mut points: Vec<Vec<f64>> = Vec::new();
        for (i, (t, p)) in course.iter().enumerate() {
            let slope = if i == 0 { 0.0 } else { (p - course[i - 1].1) / (t - course[i - 1].0) };
            points.push(vec![*t, *p, slope * (chance.unit() * 3.0 - 0.5)]);
        }
        (TableKind::Pvt, points)
    });
    assert!(tally.refused * 4 < tally.tables);
}

#[test]
fn pvt_ex_is_exact() {
    campaign(12, 150_000, 500, |chance, most| {
        let course = course(chance, most);
        let slopes: Vec<f64> = course.windows(2).map(|w| (w[1].1 - w[0].1) / (w[1].0 - w[0].0)).chain([0.0]).collect();
        let points = course
            .iter()
            .zip(slopes)
            .map(|((t, p), slope)| vec![*t, *p, slope * (chance.unit() * 3.0 - 0.5), slope * chance.unit()]);
        (TableKind::PvtEx, points.collect())
    });
}

#[test]
fn complete_is_exact() {
    campaign(13, 150_000, 1023, |chance, most| {
        let course = course(chance, most);
        let points = course.iter().map(|(t, p)| vec![*t, *p]).collect();
        (TableKind::Complete { vel_begin: chance.unit(), vel_end: -chance.unit() }, points)
    });
}

/// 0.012 ms after 17 s and before 22 minutes: a lost part of its length has effect far after it.
#[test]
fn a_short_segment_beside_a_long_one_is_exact() {
    let points = [
        [13488.707837237967, 356.37202085879204],
        [30692.68066303523, 87.20247727634649],
        [30692.692561532862, 2479.463096230068],
        [30856.87243154056, 2464.4505715980927],
        [1354369.3067079354, 644.5129423643286],
        [1354859.746239303, 620.6915316952518],
    ];
    let points: Vec<Vec<f64>> = points.iter().map(|point| point.to_vec()).collect();
    let tally = campaign(16, 600, 6, |_, _| {
        (TableKind::Complete { vel_begin: 0.5880118899538811, vel_end: -0.21804996439963487 }, points.clone())
    });
    assert_eq!(tally.refused, 0);
}

#[test]
fn percent_is_exact() {
    let mut refused = 0;
    let tally = campaign(14, 200_000, 300, |chance, most| {
        // The recursion must stay in reach: random displacements with its own velocities.
        let style = chance.below(3);
        let (mut t, mut p, mut v) = (number(style, chance.unit() * 100.0), 0.0, chance.unit() - 0.5);
        let vel_begin = v;
        let speed = chance.log(1e-3, 1e4);
        let long = chance.log(0.02, 1e6);
        let mut points = Vec::new();
        for _ in 0..2 + chance.below(most - 1) {
            let percent = match chance.below(5) {
                0 => 0.0,
                1 => 100.0,
                2 => 60.0,
                _ => chance.unit() * 100.0,
            };
            points.push(vec![t, p, percent]);
            let length = number(style, chance.log(0.01, long)).max(0.01);
            let next = (chance.unit() * 2.0 - 1.0) * speed;
            p = number(style, p + (v + next) / 2.0 * length);
            t += length;
            let n = points.len() - 1;
            v = 2.0 * (p - points[n][1]) / (t - points[n][0]) - v;
        }
        refused += 1;
        (TableKind::Percent { vel_begin }, points)
    });
    assert!(tally.refused * 4 < tally.tables && refused > 0);
}

#[test]
fn continuous_is_exact() {
    campaign(15, 200_000, 140, |chance, most| {
        let style = chance.below(3);
        let top = number(style, chance.log(0.01, 1e5));
        let (a, d) = (chance.log(top * 1e-5, top * 10.0), chance.log(top * 1e-5, top * 10.0));
        let mut p = 0.0;
        let mut points: Vec<Vec<f64>> = Vec::new();
        let n = 2 + chance.below(most - 1);
        let mut direction = chance.sign();
        for i in 0..n {
            // A velocity that suits the segments before and after.
            let next = if chance.below(3) == 0 { -direction } else { direction };
            let vel = if i == 0 || i == n - 1 || next != direction || chance.below(3) == 0 {
                0.0
            } else {
                next * top * chance.unit() * 0.7
            };
            let percent = match chance.below(4) {
                0 => 0.0,
                1 => 100.0,
                _ => chance.unit() * 100.0,
            };
            points.push(vec![p, vel, percent, top, number(2, a), number(2, d)]);
            let least = top * top / a.min(d) / 2.0;
            direction = next;
            let length =
                if chance.below(3) == 0 { chance.log(least, least * 100.0) } else { least * (0.5 + chance.unit()) };
            p = number(style, p + direction * length.max(1e-3));
        }
        (TableKind::Continuous { time_begin: number(style, chance.unit() * 500.0) }, points)
    });
}

/// 0.1 pulse in 333.3 ms: neither has a short binary form. Far ahead in one step, then tick by
/// tick.
#[test]
fn a_million_loops_do_not_drift() {
    let points = [vec![0.0, 0.0, 0.001], vec![111.1, 0.07, -0.0003], vec![333.3, 0.1, 0.001]];
    let percent: Vec<Vec<f64>> = [[1.7, 5.0, 60.0], [100.3, 5.3, 30.0], [335.0, 5.1, 0.0]].map(|p| p.to_vec()).to_vec();
    let continuous = [[0.0, 0.0, 60.0, 0.7, 0.01, 0.02], [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]].map(|p| p.to_vec()).to_vec();
    let complete: Vec<Vec<f64>> = [[0.0, 0.0], [3.3, 1e-3], [7.7, 0.1]].map(|p| p.to_vec()).to_vec();
    let all = [
        (TableKind::Pvt, points.to_vec()),
        (TableKind::Percent { vel_begin: 0.01 }, percent),
        (TableKind::Continuous { time_begin: 0.3 }, continuous),
        (TableKind::Complete { vel_begin: 0.1, vel_end: 0.1 }, complete),
    ];
    for (kind, points) in all {
        let mut shelf = Shelf::default();
        shelf.add(kind, &points).unwrap();
        let reference = Reference::of(kind, &points);
        for loops in [1_000u64, 999_999, 1_000_000, 50_000_000] {
            let mut bench = Bench::start(&shelf, 0, 12345, Exact(0), 0);
            let begin = ns(&(&reference.delay + &reference.duration * loops));
            let mut at = begin - 3_000_000;
            while at < begin + 5_000_000 {
                let (error, _) = bench.error(&reference, at);
                assert!(error <= 2f64.powi(-16), "{kind:?} {loops}: {error}");
                at += 50_000;
            }
            assert_eq!(bench.run.passes() as u64, loops);
        }
    }
    // And the same by single ticks: a hundred thousand passes of a tenth of a tick to two ticks.
    for length in [0.0101, 0.0333, 0.2] {
        let mut shelf = Shelf::default();
        let points = [vec![0.0, 0.0, 1.0], vec![length / 3.0, 0.01, 2.0], vec![length, 0.1, 1.0]];
        shelf.add(TableKind::Pvt, &points).unwrap();
        let reference = Reference::of(TableKind::Pvt, &points);
        let mut bench = Bench::start(&shelf, 0, 0, Exact(0), 0);
        for tick in 1..20_000u64 {
            let (error, _) = bench.error(&reference, tick * 100_000);
            assert!(error <= 2f64.powi(-16), "{length} {tick}: {error}");
        }
    }
}
