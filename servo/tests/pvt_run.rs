//! A PVT run: packing, delay, passes, switches, jumps, and that the position at an instant does not
//! depend on the ticks before. Exactness of positions is held by the dispatcher's `tables_exact`,
//! which builds the tables.
use crate::{chance, drive};
use servo::segment::generator_state::GeneratorState;
use servo::segment::pvt::{HEADER_WORDS, Header, POINT_WORDS, Point, PvtTables, TABLE_POINTS};
use servo::units::{Exact, Ns, Pos};

use chance::Chance;
use drive::Pvt;

const MS: u64 = 1_000_000;

#[derive(Default)]
struct Shelf(Vec<([u32; HEADER_WORDS], Vec<[u32; POINT_WORDS]>)>);

impl PvtTables for Shelf {
    fn point(&self, table: u8, index: u32) -> [u32; POINT_WORDS] {
        self.0.get(table as usize).and_then(|t| t.1.get(index as usize)).copied().unwrap_or_default()
    }
    fn header(&self, table: u8) -> [u32; HEADER_WORDS] {
        self.0.get(table as usize).map(|t| t.0).unwrap_or_default()
    }
}

impl Shelf {
    /// Knots in ns, pulses and 2⁻¹⁶ pulse/ms, from the first; `delay` in ns.
    fn add(&mut self, delay: u64, knots: &[(u64, i64, i64)]) {
        let last = knots[knots.len() - 1];
        let time_bits = (44 - (64 - last.0.leading_zeros() as i32)).min(32) as i8;
        let duration = (last.0 as u128) << 64;
        // 20 fraction bits of position, 16 of velocity.
        let header = Header {
            points: knots.len() as u16,
            time_bits,
            pos_bits: 20,
            vel_bits: 16,
            lift: 20,
            delay: (delay as u128) << 64,
            duration,
            displacement: Exact((last.1 as i128) << 64),
            rate: (u128::MAX / duration) as u64,
        };
        let point = |&(time, pos, vel): &(u64, i64, i64)| {
            Point { time: time << time_bits, pos: pos << 20, vel }.admit().unwrap()
        };
        self.0.push((header.admit().unwrap(), knots.iter().map(point).collect()));
    }
}

fn pulses(pos: Pos) -> f64 {
    pos.0 as f64 / 4194304.0
}

#[test]
fn words_hold_what_they_are_given() {
    let mut chance = Chance::new(1);
    for round in 0..200_000u64 {
        let edge = |bits: u32, x: u64| match round % 4 {
            0 => (1i64 << (bits - 1)) - 1,
            1 => -(1i64 << (bits - 1)),
            _ => (x << (64 - bits)) as i64 >> (64 - bits),
        };
        let point = Point {
            time: if round % 5 == 0 { (1 << 44) - 1 } else { chance.next() >> 20 },
            pos: edge(44, chance.next()),
            vel: edge(40, chance.next()),
        };
        assert_eq!(Point::from_words(point.admit().unwrap()), point);
        assert!(Point { time: 1 << 44, ..point }.admit().is_none());
        assert!(
            Point { pos: 1 << 43, ..point }.admit().is_none()
                && Point { pos: -(1 << 43) - 1, ..point }.admit().is_none()
        );
        assert!(
            Point { vel: 1 << 39, ..point }.admit().is_none()
                && Point { vel: -(1 << 39) - 1, ..point }.admit().is_none()
        );
        let wide = |chance: &mut Chance| (chance.next() as u128) << 64 | chance.next() as u128;
        let header = Header {
            points: 2 + chance.below(1023) as u16,
            time_bits: chance.below(46) as i8 - 13,
            pos_bits: 1 + chance.below(62) as i8,
            vel_bits: 6 + chance.below(57) as i8,
            lift: chance.below(64) as u8,
            delay: wide(&mut chance) >> 8,
            duration: wide(&mut chance) >> 8 | 1 << 119,
            displacement: Exact(wide(&mut chance) as i128),
            rate: chance.next(),
        };
        match header.admit() {
            Some(words) => assert_eq!(Header::from_words(words), header),
            None => assert!(!(0..=84).contains(&header.frac())),
        }
        assert!(
            Header { points: 1, ..header }.admit().is_none()
                && Header { points: TABLE_POINTS as u16 + 1, ..header }.admit().is_none()
        );
        assert!(
            Header { duration: 999 << 64, ..header }.admit().is_none()
                && Header { time_bits: 33, ..header }.admit().is_none()
        );
    }
}

#[test]
fn delay_then_motion_then_rest() {
    let mut shelf = Shelf::default();
    shelf.add(7 * MS / 2, &[(0, 0, 0), (4 * MS, 8, 0)]);
    let begin = Ns(1_000);
    let origin = Exact(100 << 64);
    let mut run = Pvt::begin(begin, origin, 0, &shelf);
    for quarter in 1..14u64 {
        let step = run.step(Ns(begin.0 + quarter * MS / 4), 1, &shelf);
        assert_eq!(
            (pulses(step.pos), step.state, step.motion.velocity().m),
            (100.0, GeneratorState::Running, 0),
            "{quarter}"
        );
        assert_eq!(run.time(Ns(begin.0 + quarter * MS / 4)).0, quarter * MS / 4);
    }
    // 3τ² − 2τ³ of 8 pulses.
    for quarter in 14..30u64 {
        let step = run.step(Ns(begin.0 + quarter * MS / 4), 1, &shelf);
        let t = (quarter - 14) as f64 / 16.0;
        assert!(
            (pulses(step.pos) - 100.0 - 8.0 * t * t * (3.0 - 2.0 * t)).abs() < 1e-6
                && step.state == GeneratorState::Running,
            "{quarter}"
        );
    }
    for later in [30u64, 31, 40, 4_000_000] {
        let step = run.step(Ns(begin.0 + later * MS / 4), 1, &shelf);
        assert_eq!(step.state, GeneratorState::Ended { at: Exact(108 << 64) });
        assert_eq!((pulses(step.pos), step.motion.velocity().m, run.passes()), (108.0, 0, 1));
        assert_eq!(run.time(Ns(begin.0 + later * MS / 4)).0, 15 * MS / 2);
    }
}

#[test]
fn a_selected_table_takes_over_at_the_end_of_the_pass() {
    let mut shelf = Shelf::default();
    shelf.add(0, &[(0, 0, 10 << 16), (10 * MS, 100, 10 << 16)]);
    shelf.add(500 * MS, &[(0, 0, -5 * 65536), (4 * MS, -20, -5 * 65536)]);
    for passes in [0, 1, 2] {
        let mut run = Pvt::begin(Ns(0), Exact(0), 0, &shelf);
        assert!((pulses(run.step(Ns(3 * MS), passes, &shelf).pos) - 30.0).abs() < 1e-6);
        run.select(0);
        assert_eq!(run.pending(), None);
        run.select(1);
        assert_eq!((run.pending(), run.table()), (Some(1), 0));
        assert_eq!(pulses(run.step(Ns(10 * MS - 1), passes, &shelf).pos).round(), 100.0);
        assert_eq!(run.table(), 0);
        // At once, without its delay; its time begins at its first point's.
        let step = run.step(Ns(10 * MS), passes, &shelf);
        assert_eq!((pulses(step.pos), step.state, run.table(), run.passes()), (100.0, GeneratorState::Running, 1, 0));
        assert_eq!(run.time(Ns(10 * MS)).0, 500 * MS);
        let step = run.step(Ns(13 * MS), passes, &shelf);
        assert!((pulses(step.pos) - 85.0).abs() < 1e-6 && run.pending().is_none());
        let step = run.step(Ns(14 * MS + MS / 2), passes, &shelf);
        let (pos, going) = match passes {
            1 => (80.0, false),
            _ => (77.5, true),
        };
        assert!(
            (pulses(step.pos) - pos).abs() < 1e-6 && (step.state == GeneratorState::Running) == going,
            "{passes}: {}",
            pulses(step.pos)
        );
    }
    // The table that takes over may itself have run several times within the tick.
    let mut run = Pvt::begin(Ns(0), Exact(0), 0, &shelf);
    run.select(1);
    let step = run.step(Ns(10 * MS + 4 * MS * 1000 + 2 * MS), 0, &shelf);
    assert!((pulses(step.pos) - (100.0 - 20_000.0 - 10.0)).abs() < 1e-6);
    assert_eq!((run.table(), run.passes()), (1, 1000));
    let mut run = Pvt::begin(Ns(0), Exact(0), 0, &shelf);
    run.select(1);
    assert_eq!(run.step(Ns(1000 * MS), 3, &shelf).state, GeneratorState::Ended { at: Exact(40 << 64) });
}

#[test]
fn the_loop_count_may_change_while_running() {
    let mut shelf = Shelf::default();
    shelf.add(0, &[(0, 0, 0), (10 * MS, 100, 0)]);
    let mut run = Pvt::begin(Ns(0), Exact(0), 0, &shelf);
    assert_eq!(run.step(Ns(35 * MS), 0, &shelf).state, GeneratorState::Running);
    assert_eq!(run.passes(), 3);
    // Fewer than have run: the present pass is the last.
    assert_eq!(run.step(Ns(39 * MS), 2, &shelf).state, GeneratorState::Running);
    assert_eq!(run.step(Ns(41 * MS), 2, &shelf).state, GeneratorState::Ended { at: Exact(400 << 64) });
    assert_eq!(run.passes(), 4);
    let mut run = Pvt::begin(Ns(0), Exact(0), 0, &shelf);
    assert_eq!(run.step(Ns(5 * MS), 1, &shelf).state, GeneratorState::Running);
    assert_eq!(run.step(Ns(15 * MS), 2, &shelf).state, GeneratorState::Running);
    assert_eq!(run.step(Ns(1_000 * MS), 2, &shelf).state, GeneratorState::Ended { at: Exact(200 << 64) });
}

/// However late after its end it is sampled, and how often, a motion has run its passes and no
/// more, and stays where they end.
#[test]
fn passes_end_with_the_loop() {
    let mut shelf = Shelf::default();
    shelf.add(2 * MS, &[(0, 0, 0), (MS / 2, 30, 0), (MS, 100, 0)]);
    for passes in [1, 2, 3, 7, 1000] {
        for first in [0, 1, passes - 1].into_iter().filter(|first| *first < passes) {
            for late in [0, 1, 5, 1_000_000] {
                let mut run = Pvt::begin(Ns(0), Exact(0), 0, &shelf);
                let at = Ns((2 + u64::from(first)) * MS + MS / 4);
                assert_eq!((run.step(at, passes, &shelf).state, run.passes()), (GeneratorState::Running, first));
                // Once, and again.
                for after in [late, late + 3] {
                    let step = run.step(Ns((2 + u64::from(passes) + after) * MS), passes, &shelf);
                    assert_eq!(step.state, GeneratorState::Ended { at: Exact((i128::from(passes) * 100) << 64) });
                    assert_eq!((run.passes(), run.made_passes()), (passes, passes), "{first}: {after} ms late");
                }
            }
        }
    }
}

/// From knot to knot, or over many at once, or over many passes: the same instant gives the same
/// bits.
#[test]
fn the_way_to_an_instant_does_not_matter() {
    let mut chance = Chance::new(7);
    for _ in 0..3_000 {
        let most = if chance.below(8) == 0 { 1022 } else { 12 };
        let n = 2 + chance.below(most);
        let mut knots = vec![(0, 0, chance.below(1 << 17) as i64 - (1 << 16))];
        for i in 1..n {
            let (time, pos, _) = knots[knots.len() - 1];
            // Jumps of the velocity, but a pass lasts some time.
            let length = if chance.below(4) == 0 && i > 1 { 0 } else { chance.log(1e4, 2e6) as u64 };
            let step = if length == 0 { 0 } else { chance.below(2001) as i64 - 1000 };
            knots.push((time + length, pos + step, chance.below(1 << 17) as i64 - (1 << 16)));
        }
        let mut shelf = Shelf::default();
        let delay = chance.below(3 * MS);
        shelf.add(delay, &knots);
        let pass = knots[knots.len() - 1].0;
        let mut run = Pvt::begin(Ns(55), Exact(3 << 60), 0, &shelf);
        let mut now = 55;
        for _ in 0..40 {
            now += match chance.below(4) {
                0 => 1 + chance.below(20_000),
                1 => chance.below(pass) + 1,
                2 => chance.below(20 * pass) + 1,
                _ => 50_000,
            };
            if chance.below(2) == 0 {
                run.prepare(0, &shelf);
            }
            let step = run.step(Ns(now), 0, &shelf);
            let fresh = Pvt::begin(Ns(55), Exact(3 << 60), 0, &shelf).step(Ns(now), 0, &shelf);
            assert_eq!(step, fresh, "{now} {knots:?}");
            let since = (now - 55).saturating_sub(delay);
            assert_eq!(run.passes() as u64, if now - 55 < delay { 0 } else { since / pass });
            // At a knot, its position; at a jump, the velocity after it.
            let at = since / pass * pass;
            let knot = chance.below(n - 1) as usize;
            let base = (at / pass) as i64 * knots[knots.len() - 1].1;
            let instant = 55 + delay + at + knots[knot].0;
            let there = Pvt::begin(Ns(55), Exact(3 << 60), 0, &shelf).step(Ns(instant), 0, &shelf);
            assert_eq!(there.pos, Pos(((base + knots[knot].1) << 22) + (3 << 18)));
            let held = knots.iter().rposition(|k| k.0 <= knots[knot].0).unwrap();
            let v = there.motion.velocity();
            let v = v.m as f64 * 2f64.powi(-v.e as i32) * 65536.0;
            assert!(held == knots.len() - 1 || (v - knots[held].2 as f64).abs() < 1.0, "{v} {knots:?}");
        }
    }
}

/// Pieces made ahead, the first of the next pass too, are the same as those made in time. That also
/// holds where a table is selected or the number of passes changes after they were made.
#[test]
fn what_was_made_ahead_is_taken_back_when_orders_change() {
    let mut chance = Chance::new(8);
    let (mut ahead_of_a_pass, mut ended) = (0, 0);
    for _ in 0..2_000 {
        let mut shelf = Shelf::default();
        for table in 0..3 {
            let knots = [(0, 0, 0), (MS + table * 77, 7, 1 << 16), (2 * MS + table * 1001, 11 + table as i64, 0)];
            shelf.add(chance.below(2) * chance.below(MS), &knots);
        }
        let mut plain = Pvt::begin(Ns(9), Exact(1 << 62), 0, &shelf);
        let mut ahead = plain;
        let (mut now, mut passes) = (9, 4);
        for _ in 0..200 {
            now += 1 + chance.below(MS / 2);
            if chance.below(3) > 0 {
                let before = ahead.passes();
                ahead.prepare(passes, &shelf);
                ahead_of_a_pass += (ahead.0.is_ahead() && before != ahead.made_passes()) as u32;
            }
            match chance.below(40) {
                0 => {
                    let table = chance.below(3) as u8;
                    plain.select(table);
                    ahead.select(table);
                }
                1 => {
                    passes = 1 + chance.below(5) as u32;
                    ahead.0.invalidate_prepared();
                }
                _ => {}
            }
            let step = plain.step(Ns(now), passes, &shelf);
            assert_eq!(ahead.step(Ns(now), passes, &shelf), step);
            let published = |run: &Pvt| (run.passes(), run.table(), run.pending(), run.time(Ns(now)));
            assert_eq!(published(&ahead), published(&plain));
            if step.state != GeneratorState::Running {
                ended += 1;
                break;
            }
        }
    }
    assert!(ahead_of_a_pass > 1000 && ended > 1000, "{ahead_of_a_pass} {ended}");
}

#[test]
fn a_missing_table_is_harmless() {
    let shelf = Shelf::default();
    let mut run = Pvt::begin(Ns(5), Exact(1 << 64), 9, &shelf);
    for now in [5, 6, 1000, u64::MAX] {
        assert_eq!(pulses(run.step(Ns(now), 1, &shelf).pos), 1.0);
    }
}
