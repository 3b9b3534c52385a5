//! Bad points: each is refused with its code, a reason and the point's number, and nothing panics.
use crate::tables_bench as bench;
use dispatcher::Refused;
use dispatcher::plan::pvt::{CORE_TABLES, Scratch, SplineScratch, TableDraft, TableKind};
use protocol::reason::{Code, Reason};
use servo::segment::pvt::PointStore;
use servo::units::StepLimit;

use bench::chance::Chance;
use bench::{FIELDS, Shelf};

fn refused(kind: TableKind, points: &[&[f64]]) -> Refused {
    let points: Vec<Vec<f64>> = points.iter().map(|p| p.to_vec()).collect();
    Shelf::default().add(kind, &points).expect_err("must be refused")
}

#[track_caller]
fn is(refused: Refused, reason: Reason, item: u16, field: u8) {
    assert_eq!((refused.reason, refused.wire.item.get(), refused.wire.field), (reason, item, field), "{refused:?}");
    assert_eq!(refused.reason.code(), Code::Range);
}

const CONTINUOUS: TableKind = TableKind::Continuous { time_begin: 0.0 };
const PERCENT: TableKind = TableKind::Percent { vel_begin: 0.0 };
const COMPLETE: TableKind = TableKind::Complete { vel_begin: 0.0, vel_end: 0.0 };
const NONE: u8 = 255;

#[test]
fn counts() {
    let (mut beside, room) = (Box::new(SplineScratch::new()), Box::new(PointStore::new()));
    let mut scratch = Scratch::new(&mut beside, &room);
    for kind in [TableKind::Pvt, TableKind::PvtEx, COMPLETE, PERCENT, CONTINUOUS] {
        for count in [-1, 0, 1, 1025, i32::MAX, i32::MIN] {
            let refused =
                TableDraft::begin(kind, count, FIELDS, StepLimit::FULL_SCALE, true, &mut scratch).unwrap_err();
            is(refused, Reason::OutOfRange, 65535, FIELDS.count);
        }
        assert!(TableDraft::begin(kind, 1024, FIELDS, StepLimit::FULL_SCALE, true, &mut scratch).is_ok());
    }
    assert_eq!(CORE_TABLES, 32);
    let full: Vec<Vec<f64>> = (0..1024).map(|i| vec![i as f64, i as f64, 1.0]).collect();
    let mut shelf = Shelf::default();
    shelf.add(TableKind::Pvt, &full).unwrap();
    assert_eq!(shelf.header_of(0).points, 1024);
}

#[test]
fn more_slots_than_fit() {
    let points: Vec<Vec<f64>> = (0..400).map(|i| vec![i as f64, if i % 2 == 0 { 0.0 } else { 10.0 }, 50.0]).collect();
    let refused = Shelf::default().add(PERCENT, &points).unwrap_err();
    // One point of the store for the first point, three for each one after it: point 342 (from 1)
    // is the first too many.
    is(refused, Reason::TableFull, 342, NONE);
    // The Calculate command has no such limit.
    let (mut beside, room) = (Box::new(SplineScratch::new()), Box::new(PointStore::new()));
    let mut scratch = Scratch::new(&mut beside, &room);
    let mut draft = TableDraft::begin(PERCENT, 400, FIELDS, StepLimit::FULL_SCALE, false, &mut scratch).unwrap();
    for point in &points {
        draft.point(point, &mut scratch).unwrap();
    }
    assert!(scratch.used() == 0 && draft.finish(&mut scratch).is_none());
}

/// SPEC 5: a point where the velocity jumps takes two of the 1024 points of the store, so 513
/// points fit if it jumps at every inner one.
#[test]
fn a_jump_of_the_velocity_takes_a_second_point() {
    let steps = |count: usize| -> Vec<Vec<f64>> {
        (0..count).map(|i| vec![i as f64, 10.0 * i as f64, 5.0 + (i % 7) as f64, 12.0 + (i % 5) as f64]).collect()
    };
    let mut shelf = Shelf::default();
    shelf.add(TableKind::PvtEx, &steps(513)).unwrap();
    assert_eq!(shelf.header_of(0).points, 1024);
    // Point 1024 of the store is the first one of the 513th point, which jumps here.
    is(Shelf::default().add(TableKind::PvtEx, &steps(514)).unwrap_err(), Reason::TableFull, 512, NONE);
    // Without jumps the manual's 1024 points are held.
    let smooth: Vec<Vec<f64>> = (0..1024).map(|i| vec![i as f64, 10.0 * i as f64, 10.0, 10.0]).collect();
    let mut shelf = Shelf::default();
    shelf.add(TableKind::PvtEx, &smooth).unwrap();
    assert_eq!(shelf.header_of(0).points, 1024);
}

#[test]
fn times() {
    for kind in [TableKind::Pvt, TableKind::PvtEx, COMPLETE, PERCENT] {
        is(
            refused(kind, &[&[0.0, 0.0, 0.0, 0.0], &[1.0, 1.0, 0.0, 0.0], &[1.0, 2.0, 0.0, 0.0]]),
            Reason::PointTime,
            2,
            10,
        );
        is(
            refused(kind, &[&[0.0, 0.0, 0.0, 0.0], &[2.0, 1.0, 0.0, 0.0], &[1.0, 2.0, 0.0, 0.0]]),
            Reason::PointTime,
            2,
            10,
        );
        is(refused(kind, &[&[0.0, 0.0, 0.0, 0.0], &[f64::NAN, 1.0, 0.0, 0.0]]), Reason::NotFinite, 1, 10);
        is(refused(kind, &[&[0.0, 0.0, 0.0, 0.0], &[f64::INFINITY, 1.0, 0.0, 0.0]]), Reason::NotFinite, 1, 10);
        is(refused(kind, &[&[-1.0, 0.0, 0.0, 0.0], &[1.0, 1.0, 0.0, 0.0]]), Reason::OutOfRange, 0, 10);
        is(refused(kind, &[&[0.0, 0.0, 0.0, 0.0], &[1e11, 1.0, 0.0, 0.0]]), Reason::OutOfRange, 1, 10);
        assert_eq!(refused(kind, &[&[0.0, 0.0, 0.0, 0.0], &[1e-4, 0.0, 0.0, 0.0]]).reason, Reason::TableShort);
    }
    let late = TableKind::Continuous { time_begin: -1.0 };
    is(refused(late, &[&[0.0; 6], &[1.0; 6]]), Reason::OutOfRange, 65535, 4);
    is(refused(TableKind::Continuous { time_begin: f64::NAN }, &[&[0.0; 6], &[1.0; 6]]), Reason::NotFinite, 65535, 4);
}

#[test]
fn positions_and_velocities() {
    is(refused(TableKind::Pvt, &[&[0.0, 0.0, 0.0], &[1.0, f64::NAN, 0.0]]), Reason::NotFinite, 1, 11);
    is(refused(TableKind::Pvt, &[&[0.0, 0.0, 0.0], &[1.0, 0.0, f64::NEG_INFINITY]]), Reason::NotFinite, 1, 12);
    is(refused(TableKind::Pvt, &[&[0.0, 1e300, 0.0], &[1.0, 0.0, 0.0]]), Reason::OutOfRange, 0, 11);
    is(refused(TableKind::Pvt, &[&[0.0, 0.0, 0.0], &[1e4, 2.3e12, 0.0]]), Reason::BeyondTravel, 1, 11);
    // Full scale is allowed, more is not, at a point or inside a segment.
    let full = 4294967296.0;
    assert!(Shelf::default().add(TableKind::Pvt, &[vec![0.0, 0.0, full], vec![1.0, full, full]]).is_ok());
    is(refused(TableKind::Pvt, &[&[0.0, 0.0, 0.0], &[1.0, 1.0, full * 1.000001]]), Reason::TooFast, 1, 12);
    is(refused(TableKind::Pvt, &[&[0.0, 0.0, 0.0], &[1.0, full, 0.0]]), Reason::TooFast, 1, 11);
    is(refused(PERCENT, &[&[0.0, 0.0, 0.0], &[1.0, full, 0.0]]), Reason::TooFast, 1, 11);
    is(refused(COMPLETE, &[&[0.0, 0.0], &[1.0, 0.0], &[2.0, full], &[3.0, 0.0]]), Reason::TooFast, 1, 11);
    let fast = TableKind::Complete { vel_begin: 0.0, vel_end: 1e10 };
    is(refused(fast, &[&[0.0, 0.0], &[1.0, 0.0]]), Reason::TooFast, 65535, 5);
    is(refused(TableKind::Percent { vel_begin: f64::NAN }, &[&[0.0, 0.0], &[1.0, 0.0]]), Reason::NotFinite, 65535, 4);
    // The points are near, the positions between them are not.
    is(refused(TableKind::Pvt, &[&[0.0, 0.0, 4e9], &[1e5, 0.0, 0.0]]), Reason::BeyondTravel, 1, 11);
}

#[test]
fn percentages() {
    for percent in [101.0, -1.0, 100.0000001] {
        is(refused(PERCENT, &[&[0.0, 0.0, 0.0], &[1.0, 1.0, percent]]), Reason::OutOfRange, 1, 12);
        is(refused(CONTINUOUS, &[&[0.0, 0.0, percent, 1.0, 1.0, 1.0], &[1.0; 6]]), Reason::OutOfRange, 0, 12);
    }
    is(refused(PERCENT, &[&[0.0, 0.0, f64::NAN], &[1.0, 1.0, 0.0]]), Reason::NotFinite, 0, 12);
}

#[test]
fn continuous_data() {
    let rest: &[f64] = &[1000.0, 0.0, 0.0, 10.0, 0.01, 0.01];
    for (value, field) in [(3, 13), (4, 14), (5, 15)] {
        for wrong in [-0.01, 0.0, 1e31] {
            let mut first = [0.0, 0.0, 0.0, 10.0, 0.01, 0.01];
            first[value] = wrong;
            is(refused(CONTINUOUS, &[&first, rest]), Reason::OutOfRange, 0, field);
        }
    }
    // 10 → 0 at 0.01 needs 5000, only 1000 are there; 0 → 10 likewise.
    let fast: &[f64] = &[0.0, 10.0, 0.0, 10.0, 0.01, 0.01];
    let wire = refused(CONTINUOUS, &[fast, rest]);
    is(wire, Reason::VelocityUnreachable, 0, NONE);
    assert!((wire.wire.low.get() - 5000.0).abs() < 1e-9 && wire.wire.got.get() == 1000.0);
    let standing: &[f64] = &[0.0, 0.0, 0.0, 10.0, 0.01, 0.01];
    let arrives: &[f64] = &[1000.0, 10.0, 0.0, 10.0, 0.01, 0.01];
    is(refused(CONTINUOUS, &[standing, arrives]), Reason::VelocityUnreachable, 0, NONE);
    is(refused(CONTINUOUS, &[standing, rest, arrives]), Reason::NoDisplacement, 1, NONE);
    // Above the limit in the direction of travel; against it a larger one is allowed.
    is(
        refused(CONTINUOUS, &[&[0.0, 11.0, 0.0, 10.0, 0.01, 0.01], &[1e6, 0.0, 0.0, 10.0, 0.01, 0.01]]),
        Reason::AboveVelMax,
        0,
        NONE,
    );
    is(
        refused(CONTINUOUS, &[&[0.0, -11.0, 0.0, 10.0, 0.01, 0.01], &[-1e6, 0.0, 0.0, 10.0, 0.01, 0.01]]),
        Reason::AboveVelMax,
        0,
        NONE,
    );
    assert!(Shelf::default().add(CONTINUOUS, &[vec![0.0, -11.0, 0.0, 10.0, 0.01, 0.01], rest.to_vec()]).is_ok());
    // Exactly enough, in decimal numbers: one ramp, no refusal for a last bit.
    for acc in [0.01, 0.02, 0.03, 0.07, 0.1, 0.3] {
        let length = 100.0 / 2.0 / acc;
        let mut shelf = Shelf::default();
        let times = shelf
            .add(CONTINUOUS, &[vec![0.0, 10.0, 0.0, 10.0, acc, acc], vec![length, 0.0, 0.0, 10.0, acc, acc]])
            .unwrap();
        assert!((times[1] - 10.0 / acc).abs() < 1e-6 && shelf.header_of(0).points <= 3, "{acc} {times:?}");
    }
    // The last point's limits are not used.
    assert!(Shelf::default().add(CONTINUOUS, &[standing.to_vec(), vec![1000.0, 0.0, 0.0, 0.0, 0.0, 0.0]]).is_ok());
}

#[test]
fn a_point_too_many() {
    let (mut beside, room) = (Box::new(SplineScratch::new()), Box::new(PointStore::new()));
    let mut scratch = Scratch::new(&mut beside, &room);
    let mut draft = TableDraft::begin(TableKind::Pvt, 2, FIELDS, StepLimit::FULL_SCALE, true, &mut scratch).unwrap();
    draft.point(&[0.0, 0.0, 0.0], &mut scratch).unwrap();
    assert!(draft.finish(&mut scratch).is_none());
    draft.point(&[1.0, 0.0, 0.0], &mut scratch).unwrap();
    assert!(draft.point(&[2.0, 0.0, 0.0], &mut scratch).is_err());
    assert!(draft.finish(&mut scratch).is_some());
    // Too few values are no numbers.
    let mut draft = TableDraft::begin(TableKind::Pvt, 2, FIELDS, StepLimit::FULL_SCALE, true, &mut scratch).unwrap();
    assert!(draft.point(&[0.0, 0.0], &mut scratch).is_err());
}

/// Any bits as points: a table or a refusal, and every table that is taken runs within reach.
#[test]
fn arbitrary_bits() {
    let mut chance = Chance::new(99);
    let mut taken = 0;
    for round in 0..60_000 {
        let value = |chance: &mut Chance| match chance.below(6) {
            0 => f64::from_bits(chance.next()),
            1 => [f64::NAN, f64::INFINITY, 0.0, -0.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, 4294967296.0]
                [chance.below(8) as usize],
            2 => chance.sign() * chance.log(1e-300, 1e300),
            3 => chance.below(200) as f64,
            _ => chance.sign() * chance.log(1e-6, 1e6),
        };
        let kind = match round % 5 {
            0 => TableKind::Pvt,
            1 => TableKind::PvtEx,
            2 => TableKind::Complete { vel_begin: value(&mut chance), vel_end: value(&mut chance) },
            3 => TableKind::Percent { vel_begin: value(&mut chance) },
            _ => TableKind::Continuous { time_begin: value(&mut chance) },
        };
        let count = 2 + chance.below(3);
        let mut points: Vec<Vec<f64>> = (0..count).map(|_| (0..6).map(|_| value(&mut chance)).collect()).collect();
        if chance.below(4) > 0 && round % 5 < 4 {
            points.iter_mut().enumerate().for_each(|(i, p)| p[0] = i as f64 + p[0].abs().min(0.9));
        }
        let mut shelf = Shelf::default();
        if shelf.add(kind, &points).is_ok() {
            taken += 1;
            let mut bench = bench::Bench::start(&shelf, 0, 5, servo::units::Exact(0), 1);
            let end = bench.shelf.header_of(0);
            let ns = ((end.delay + end.duration) >> 64) as u64;
            for k in 0..8u64 {
                let (pos, _, _) = bench.at_ms((ns / 8 * k) as f64 / 1e6);
                assert!(pos.abs() <= 2f64.powi(41), "{kind:?} {points:?}");
            }
        }
    }
    assert!(taken > 1000, "{taken}");
}
