//! Steps that a look-ahead keeps from plan to plan change nothing.
use crate::chance::Chance;
use dispatcher::plan::geometry::{Geometry, Position};
use dispatcher::plan::look_ahead::{Limits, LookAhead, Planned};
use servo::path::Plane;
use std::f64::consts::TAU;

const MOTIONS: usize = 64;

/// The same look-ahead with its steps and without.
struct Both {
    kept: Box<LookAhead<MOTIONS, MOTIONS>>,
    plain: Box<LookAhead<MOTIONS, 0>>,
    compared: usize,
}

impl Both {
    fn take(&mut self, now: bool, seed: u64) -> Option<Planned> {
        let [kept, plain] = [self.kept.take(now), self.plain.take(now)];
        let bits = |planned: Option<Planned>| {
            planned.map(|planned| (planned.along, planned.ms.to_bits(), planned.entries_after))
        };
        assert_eq!(bits(kept), bits(plain), "path {seed}, motion {}", self.compared);
        self.compared += usize::from(kept.is_some());
        kept
    }
}

/// A motion from here: along a curve in whole pulses, in any direction, on with the last one, or an
/// arc.
fn next(chance: &mut Chance, here: &mut Position, course: &mut f64, kind: u64) -> Option<Geometry> {
    let length = [3.0, 8.0, 8.0, 40.0, 2000.0][chance.below(5) as usize];
    match kind {
        0 => *course += length / 8_000.0,
        1 => *course = chance.below(1000) as f64 * TAU / 1000.0,
        2 => {}
        _ => *course += (chance.below(200) as f64 - 100.0) / 200.0,
    }
    let to = [here[0] + length * course.cos(), here[1] + length * course.sin(), here[2], 0.0].map(|x| x.round() as i32);
    let geometry = if kind == 3 && length > 8.0 {
        Geometry::arc_radius(here, Plane::Xy, [to[0], to[1]], length * 0.8, chance.below(2) == 0)
    } else {
        Geometry::line(here, to)
    };
    let geometry = geometry.ok()?;
    *here = geometry.end;
    Some(geometry)
}

/// On paths of all kinds of motions, stops and powers between them, with motions taken one by one,
/// at a level, when final and at once, in any order.
#[test]
fn kept_steps_change_nothing() {
    let mut compared = 0;
    for seed in 0..400 {
        let mut chance = Chance::new(seed);
        let acc = [1.0, 4.0, 11.0][chance.below(3) as usize];
        let own = [1.0, 0.7, 1.0 + chance.below(4) as f64];
        let limits = Limits {
            vel: [200.0, 200.0 * own[1], 90.0, 200.0],
            acc: [acc, acc * own[2], acc, acc],
            corner: [0.5, 2.4, 9.0][chance.below(3) as usize],
        };
        let (kept, plain) = (Box::new(LookAhead::new(limits)), Box::new(LookAhead::new(limits)));
        let mut both = Both { kept, plain, compared: 0 };
        let (mut here, mut course, kind) = ([0.0; 4], 0.0, chance.below(5));
        for _ in 0..600 {
            match chance.below(40) {
                0 => {
                    both.kept.stop();
                    both.plain.stop();
                }
                1 => while both.take(false, seed).is_some() {},
                2 => {
                    let batch = both.kept.hold_level();
                    assert_eq!(batch, both.plain.hold_level());
                    for _ in 0..batch {
                        both.take(true, seed);
                    }
                    both.kept.release_level();
                    both.plain.release_level();
                }
                3 => _ = both.take(true, seed),
                4 if chance.below(8) == 0 => {
                    both.kept.clear();
                    both.plain.clear();
                }
                _ => {
                    let kind = if kind == 4 { chance.below(5) } else { kind };
                    let vel = if chance.below(9) == 0 { 60.0 } else { 200.0 };
                    let Some(geometry) = next(&mut chance, &mut here, &mut course, kind) else { continue };
                    while both.kept.is_full() {
                        both.take(true, seed);
                    }
                    assert!(both.kept.push_motion(&geometry, vel, acc));
                    assert!(both.plain.push_motion(&geometry, vel, acc));
                }
            }
        }
        while both.take(true, seed).is_some() {}
        compared += both.compared;
    }
    println!("{compared} motions compared");
    assert!(compared > 150_000, "{compared}");
}
