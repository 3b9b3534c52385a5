//! Arcs and circles: on their radius at every tick, as long as they should be, on their target at
//! the end.
//!
//! The truth is the circle through both ends with the sweep, in doubles: on 2³¹ pulses they are
//! good to 10⁻⁶ pulse.
use crate::{chance, paths};
use servo::path::{EntryContent, Path, PathEntry, PathStop, Plane, Refused, Sweep};
use servo::units::Pos;
use std::f64::consts::{PI, TAU};

use chance::Chance;
use paths::{Script, mark, run, since, speeds};

const PLANES: [Plane; 3] = [Plane::Xy, Plane::Yz, Plane::Zx];

fn pulses(x: Pos) -> f64 {
    x.0 as f64 * 2f64.powi(-22)
}

/// Time of a motion from rest to rest, ms.
fn time(length: f64, vel: f64, acc: f64) -> f64 {
    if vel * vel >= acc * length { 2.0 * (length / acc).sqrt() } else { length / vel + vel / acc }
}

#[test]
fn arcs_hold_their_radius_and_their_length() {
    let mut chance = Chance::new(7);
    let (mut worst, mut late) = (0.0f64, 0.0f64);
    for case in 0..4000 {
        let plane = PLANES[case % 3];
        let [i, j] = plane.coordinates();
        let (long, ccw) = (chance.below(2) == 0, chance.below(2) == 0);
        // A chord of any length from a pulse on, a radius of up to 2³¹.
        let from = [(); 4].map(|()| (chance.sign() * chance.log(1.0, 1e9)) as i32);
        let chord = chance.log(1.0, 1e9);
        let angle = chance.unit() * TAU;
        let d = [(chord * angle.cos()).round(), (chord * angle.sin()).round()];
        let chord = d[0].hypot(d[1]);
        if chord == 0.0 {
            continue;
        }
        let radius = (chord / 2.0 * chance.log(1.0, 1e9)).min(2f64.powi(31)).max(chord / 2.0);
        let turns = ((chord / 2.0 / radius).asin() / PI).clamp(2f64.powi(-49), 0.5);
        // The circle that these turns mean.
        let radius = chord / 2.0 / (PI * turns).sin();
        if radius > 2f64.powi(31) {
            continue;
        }
        let sweep = TAU * if long { 1.0 - turns } else { turns };
        let h = chord / 2.0 * (PI * turns).cos() / (PI * turns).sin() * if ccw != long { 1.0 } else { -1.0 };
        let centre = [d[0] / 2.0 - d[1] / chord * h, d[1] / 2.0 + d[0] / chord * h];
        let mut to = from;
        (to[i], to[j]) = (from[i].wrapping_add(d[0] as i32), from[j].wrapping_add(d[1] as i32));
        if (from[i] as f64 + d[0]) != to[i] as f64 || (from[j] as f64 + d[1]) != to[j] as f64 {
            continue;
        }
        let length = radius * sweep;
        let (vel, acc) = (chance.log(1.0, 100.0).max(length * 1e-5).min(30000.0), chance.log(0.5, 20.0));
        let sweep_of = Sweep::admit(turns.to_bits(), long, ccw).unwrap();
        let entries = vec![PathEntry::arc(plane, [to[i], to[j]], sweep_of, speeds(vel, acc, 0.0)), mark(1)];
        let total = time(length, vel, acc);
        let period = ((total * 1e6 / 60.0) as u64).clamp(10_000, 1 << 40) | 1;
        let mut path = Path::IDLE;
        path.position(from.map(Pos::pulses));
        let mut before: Option<f64> = None;
        let mut turned = 0.0;
        let mut last = None;
        let heard = run(&mut path, &Script(entries), period, |_, step| {
            for (k, from) in from.iter().enumerate() {
                assert!(k == i || k == j || step.position[k] == Pos::pulses(*from), "{case}");
            }
            let x = pulses(Pos(step.position[i].0 - Pos::pulses(from[i]).0)) - centre[0];
            let y = pulses(Pos(step.position[j].0 - Pos::pulses(from[j]).0)) - centre[1];
            let error = (x.hypot(y) - radius).abs();
            worst = worst.max(error);
            assert!(error < 1e-3, "{case}: {error:e} off a radius of {radius}");
            if step.heading != [0; 4] {
                // Across the direction from the centre.
                let side = if ccw { 1.0 } else { -1.0 };
                let unit = |k: usize| step.heading[k] as f64 * 2f64.powi(-30);
                let (u, v) = (-y / radius * side, x / radius * side);
                let off = (unit(i) - u).abs().max((unit(j) - v).abs());
                assert!(off < 2f64.powi(-27) + 1e-3 / radius, "{case}: {off:e} off the tangent");
            }
            let at = y.atan2(x);
            if let Some(before) = before {
                turned += (at - before + 5.0 * PI).rem_euclid(TAU) - PI;
            }
            before = Some(at);
            last = Some(step.position);
        });
        assert_eq!(last, Some(to.map(Pos::pulses)), "{case}");
        let signed = if ccw { sweep } else { -sweep };
        assert!((turned - signed).abs() < 1e-6 + 4.0 / radius, "{case}: turned {turned}, not {signed}");
        let error = (since(heard.marks[0].0) - total * 1e6).abs();
        // 5 ns, and the accuracy of doubles; speeds of arcs have 38 and 32 bits.
        let bound = 5.0 + total * 1e6 * 2f64.powi(-33);
        late = late.max(error / bound);
        assert!(error <= bound, "{case}: {error} ns in {total} ms");
    }
    println!("worst radius {worst:e} pulses, worst instant {late} of its bound");
    assert!(worst > 0.0 && late > 0.0);
}

#[test]
fn full_circles_come_back_to_their_start() {
    let mut chance = Chance::new(8);
    let mut worst = 0.0f64;
    for case in 0..600 {
        let plane = PLANES[case % 3];
        let [i, j] = plane.coordinates();
        let ccw = chance.below(2) == 0;
        let (radius, angle) = (chance.log(0.01, 1.5e9), chance.unit() * TAU);
        let unit = 2f64.powi(30);
        let centre = [(radius * angle.cos() * unit) as i64, (radius * angle.sin() * unit) as i64];
        let c = centre.map(|x| x as f64 / unit);
        let radius = c[0].hypot(c[1]);
        let (vel, acc) = (chance.log(1.0, 100.0).max(radius * 1e-4).min(30000.0), chance.log(0.5, 20.0));
        let total = time(radius * TAU, vel, acc);
        let period = ((total * 1e6 / 80.0) as u64).max(1000) | 1;
        let circle = PathEntry::circle(plane, centre, ccw, speeds(vel, acc, 0.0)).unwrap();
        let mut path = Path::IDLE;
        let from = [5, -7, 1000, 3].map(Pos::pulses);
        path.position(from);
        let (mut last, mut quarter) = (None, None);
        let heard = run(&mut path, &Script(vec![circle, mark(1)]), period, |t, step| {
            let x = pulses(Pos(step.position[i].0 - from[i].0)) - c[0];
            let y = pulses(Pos(step.position[j].0 - from[j].0)) - c[1];
            worst = worst.max((x.hypot(y) - radius).abs());
            if t as f64 > total * 1e6 * 0.2 && quarter.is_none() {
                quarter = Some(x * -c[1] - y * -c[0]);
            }
            last = Some(step.position);
        });
        assert_eq!(last, Some(from));
        // A fifth of the time on, a counterclockwise circle lies left of the direction from the
        // centre to the start.
        assert_eq!(quarter.unwrap() < 0.0, ccw, "{case}");
        assert!((since(heard.marks[0].0) - total * 1e6).abs() <= 5.0 + total * 1e6 * 2f64.powi(-33), "{case}");
    }
    println!("worst radius {worst:e} pulses");
    assert!(worst > 0.0 && worst < 1e-3, "{worst:e}");
}

/// Coordinates that a line or an arc does not name stay; the plane decides the sense of rotation.
#[test]
fn planes_turn_as_seen_from_their_third_axis() {
    for (plane, towards) in PLANES.into_iter().zip([[0, 1], [1, 2], [2, 0]]) {
        assert_eq!(plane.coordinates(), towards);
        // A counterclockwise quarter around the origin from the first axis of the plane to the
        // second.
        let mut from = [0; 4];
        from[towards[0]] = 1000;
        let sweep = Sweep::admit(0.25f64.to_bits(), false, true).unwrap();
        let entries = vec![PathEntry::arc(plane, [0, 1000], sweep, speeds(10.0, 1.0, 0.0))];
        let mut path = Path::IDLE;
        path.position(from.map(Pos::pulses));
        let mut middle = [0.0; 4];
        let total = time(500.0 * PI, 10.0, 1.0) * 1e6;
        let heard = run(&mut path, &Script(entries), 500_000, |t, step| {
            if t as f64 <= total / 2.0 {
                middle = step.position.map(pulses);
            }
        });
        assert_eq!(heard.rests[0].1, PathStop::Completed);
        for k in towards {
            assert!((middle[k] - 500f64.sqrt() * 1000f64.sqrt()).abs() < 5.0, "{middle:?}");
        }
    }
}

/// An entry has 38 bits of a speed and 32 of the one at the end: where they are the same they stay
/// it.
#[test]
fn an_arc_that_ends_at_its_speed_does() {
    let sweep = Sweep::admit(0.1f64.to_bits(), false, true).unwrap();
    let mut chance = Chance::new(3);
    for _ in 0..1000 {
        let vel = f64::from_bits(chance.log(1e-3, 1e4).to_bits() >> 14 << 14);
        for (end, ends) in [(vel, vel), (0.0, 0.0), (0.25, 0.25)] {
            let entry = PathEntry::arc(Plane::Xy, [10, 20], sweep, speeds(vel, 4.0, end));
            let EntryContent::Arc { along, .. } = entry.item() else { panic!("no arc") };
            assert_eq!(along, speeds(vel, 4.0, ends), "{vel}");
        }
    }
}

#[test]
fn bad_arcs_are_refused() {
    let sweep = |turns: f64| Sweep::admit(turns.to_bits(), false, true).map(|_| ());
    for turns in [0.0, -0.25, 0.5f64.next_up(), 1.0, f64::NAN, f64::INFINITY, 2f64.powi(-51)] {
        assert_eq!(sweep(turns), Err(Refused::Sweep), "{turns}");
    }
    assert_eq!(sweep(0.5), Ok(()));
    assert_eq!(sweep(2f64.powi(-50)), Ok(()));
    let circle = |a: i64, b: i64| PathEntry::circle(Plane::Xy, [a, b], true, speeds(1.0, 1.0, 0.0)).map(|_| ());
    assert_eq!(circle(0, 0), Err(Refused::Centre));
    assert_eq!(circle((1 << 20) - 1, 5), Err(Refused::Centre));
    assert_eq!(circle(1 << 61, 0), Err(Refused::Centre));
    assert_eq!(circle(0, i64::MIN), Err(Refused::Centre));
    assert_eq!(circle(0, -(1 << 20)), Ok(()));
}
