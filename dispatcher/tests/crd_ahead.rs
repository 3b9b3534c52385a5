//! Look-ahead between the host and the tick: held data comes in time, is never late, and never
//! slows the path without need.

use crate::bench;
use crate::lookahead::Ahead;
use crate::path_many::{call, joined, of};
use bench::crd::*;
use bench::*;
use dispatcher::plan::geometry::Geometry;
use dispatcher::plan::look_ahead::Limits;
use protocol::command::*;
use protocol::reason::Reason;

const VEL_PULSES_PER_MS: f64 = 120.0;
const ACC_PULSES_PER_MS2: f64 = 4.0;
const CORNER_MS: f64 = 4.0;

/// A spiral of `count` lines of about 60 pulses.
fn spiral(count: usize) -> Vec<[i32; 2]> {
    let mut angle = 0.0f64;
    (0..count)
        .map(|k| {
            let radius = 2000.0 + 1.5 * k as f64;
            angle += 60.0 / radius;
            [(radius * angle.cos()).round() as i32 - 2000, (radius * angle.sin()).round() as i32]
        })
        .collect()
}

/// The time of a path whose data is all there before its first entry is taken, ms.
fn ideal([x, y]: [i32; 2], points: &[[i32; 2]]) -> f64 {
    let limits = Limits { vel: [f64::INFINITY; 4], acc: [ACC_PULSES_PER_MS2; 4], corner: CORNER_MS };
    let mut look = Ahead::<4096>::new(limits);
    let mut at = [x.into(), y.into(), 0.0, 0.0];
    for to in points {
        let geometry = Geometry::planar(&at, *to).unwrap();
        assert!(look.push_motion(&geometry, VEL_PULSES_PER_MS, ACC_PULSES_PER_MS2));
        at = geometry.end;
    }
    let mut ms = 0.0;
    while let Some(planned) = look.take(true) {
        ms += planned.ms;
    }
    ms
}

fn lines(points: &[[i32; 2]]) -> (LnXYMany, Vec<PathXY>) {
    let head = LnXYMany {
        core: 1.into(),
        crd: 1.into(),
        fifo: 0.into(),
        count: (points.len() as u16).into(),
        syn_vel: VEL_PULSES_PER_MS.into(),
        syn_acc: ACC_PULSES_PER_MS2.into(),
        vel_end: 0.0.into(),
    };
    (head, points.iter().map(|[x, y]| PathXY { x: (*x).into(), y: (*y).into() }).collect())
}

fn give(bench: &mut Bench<8>, points: &[[i32; 2]]) {
    for part in points.chunks(60) {
        let (head, items) = lines(part);
        let taken = bench.call_items(head, &items).reply::<LnXYMany>();
        assert_eq!(usize::from(taken.taken.get()), part.len());
    }
}

/// When a running path came to standstill, ms since `begun`.
fn finish(bench: &mut Bench<8>, begun: u64) -> f64 {
    until_standstill(bench);
    (bench.now().0 - begun) as f64 / 1e6
}

/// No flush is needed: waiting entries come in time and the path stops at its end. A flush says
/// that this is the end, so that the last corners are known: it may be quicker there.
#[test]
fn a_path_needs_no_flush() {
    let points = spiral(200);
    let mut took = Vec::new();
    for flushes in [false, true] {
        let mut bench = Bench::gus();
        plane(&mut bench);
        bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200));
        give(&mut bench, &points);
        assert_eq!(space(&mut bench, 0), 1024 - 200, "places of the look-ahead count");
        if flushes {
            bench.done(flush());
        }
        bench.done(start_crd(1));
        let begun = bench.now().0;
        took.push(finish(&mut bench, begun));
        let [x, y] = points[199].map(f64::from);
        assert_eq!((crd_pos(&mut bench), status(&mut bench, 0)), (vec![x, y], (0, 200)));
        let reported = bench.done(CrdInfo { core: 1.into(), crd: 1.into() });
        assert_eq!(({ reported.path_stop }, { reported.reason }.get()), (1, 1), "completed");
    }
    let ideal = ideal([0, 0], &points);
    assert!((took[0] - ideal).abs() < 1.0, "{took:?} {ideal}");
    assert!(took[1] <= took[0] && took[1] > took[0] - 2.0, "{took:?}");
}

/// Entries after a long motion are kept back until they are needed: data given meanwhile raises its
/// end speed.
#[test]
fn what_comes_late_but_in_time_is_as_fast() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200));
    bench.done(line(20_000, 0, 100.0, 4.0));
    bench.done(line(40_000, 0, 100.0, 4.0));
    bench.done(start_crd(1));
    let begun = bench.now().0;
    bench.run_ms(150);
    // Straight on: no reason to slow down, if it is known in time.
    bench.done(line(60_000, 0, 100.0, 4.0));
    let took = finish(&mut bench, begun);
    assert!((took - 625.0).abs() < 1.0, "{took}");
}

/// What a wait follows is final: it leaves at once, and limits that are set after it hold.
#[test]
fn a_wait_empties_the_look_ahead() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200));
    let wait = || BufDelay { core: 1.into(), crd: 1.into(), delay_ms: 3.into(), fifo: 0.into() };
    bench.done(wait());
    bench.done(line(1000, 0, 100.0, 4.0));
    bench.done(wait());
    bench.run_ms(2);
    assert_eq!(bench.server.view().crds[0].ends[0], 3);
    let [core, crd, coordinate] = [1, 1, 1].map(Into::into);
    bench.done(SetCrdLimit { core, crd, coordinate, vel_max: 10.0.into(), acc_max: 0.0.into() });
    bench.done(line(2000, 0, 100.0, 4.0));
    bench.done(start_crd(1));
    let mut most = 0.0f64;
    while bench.server.view().crds[0].runs {
        bench.step();
        let view = bench.server.view();
        let speed = view.velocity(&view.axes[0]);
        if crd_pos_x(&mut bench) > 1000.0 {
            most = most.max(speed.m as f64 * 2f64.powi(-i32::from(speed.e)));
        }
    }
    assert!(most > 9.99 && most <= 10.0, "{most}");
}

/// Lines of 50 ms each, one given every 50 ms, four to five ahead: the tick never brakes for the
/// end of what it was handed.
#[test]
fn final_motions_are_not_held_back_after_long_ones() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(ahead(CORNER_MS, 0.4, 200));
    let mut given = 0;
    let mut give_one = |bench: &mut Bench<8>| {
        given += 1;
        bench.done(line(given * 5000, 0, 100.0, 0.4));
    };
    (0..10).for_each(|_| give_one(&mut bench));
    bench.done(start_crd(1));
    // 250 ms to come to speed.
    let (mut least, mut next) = (f64::INFINITY, 0.0);
    for _ in 0..40 {
        while crd_pos_x(&mut bench) < next {
            bench.step();
            let view = bench.server.view();
            let speed = view.velocity(&view.axes[0]);
            if next > 15_000.0 {
                least = least.min(speed.m as f64 * 2f64.powi(-i32::from(speed.e)));
            }
        }
        next += 5000.0;
        // The first three are those that the path needs to come to speed.
        if next > 25_000.0 {
            give_one(&mut bench);
        }
    }
    assert!(least > 99.9, "{least}");
}

fn crd_pos_x(bench: &mut Bench<8>) -> f64 {
    let view = bench.server.view();
    view.axes[0].pos.0 as f64 * 2f64.powi(-22)
}

/// A host that stalls for 50 ms now and then.
#[test]
fn a_host_that_stalls_slows_nothing() {
    let points = spiral(3000);
    let ideal = ideal([0, 0], &points);
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200));
    let mut left = &points[..];
    let mut give_some = |bench: &mut Bench<8>| {
        while !left.is_empty() && space(bench, 0) >= 60 {
            let (part, rest) = left.split_at(left.len().min(60));
            give(bench, part);
            left = rest;
        }
        left.is_empty()
    };
    give_some(&mut bench);
    bench.done(start_crd(1));
    let begun = bench.now().0;
    let mut most = 0.0f64;
    while !give_some(&mut bench) {
        for _ in 0..200 {
            bench.step();
            let axis = bench.server.view().axes[0];
            let speed = bench.server.view().velocity(&axis);
            most = most.max((speed.m as f64 * 2f64.powi(-i32::from(speed.e))).abs());
        }
    }
    let took = finish(&mut bench, begun);
    assert!((took - ideal).abs() < 1.0, "{took}, ideal {ideal}");
    assert_eq!(status(&mut bench, 0).1, 3000);
    assert!(most <= VEL_PULSES_PER_MS * (1.0 + 1e-9) && most > 0.8 * VEL_PULSES_PER_MS, "{most}");
}

/// Where braking takes more motions than the look-ahead holds, the path keeps the speed that its
/// window allows, v² = 2·a·l·n. It does not brake under each plan. Entries between the motions take
/// nothing of the window.
#[test]
fn a_full_look_ahead_keeps_its_speed() {
    const LENGTH_PULSES: i32 = 30;
    let bit = |value: i16| {
        let [core, crd, fifo] = [1, 1, 0].map(Into::into);
        BufDoBit { core, crd, do_type: 12.into(), index: 1.into(), value: value.into(), fifo }
    };
    const SLOW_PULSES_PER_MS: f64 = 0.5;
    for (count, batch) in [(64, 2), (192, 6)] {
        for marks in [false, true] {
            let mut bench = Bench::gus();
            plane(&mut bench);
            bench.done(ahead(CORNER_MS, SLOW_PULSES_PER_MS, count));
            let mut given = 0;
            let mut give_some = |bench: &mut Bench<8>| {
                while given < 3000 && space(bench, 0) >= 30 {
                    let calls = (given..given + 15).flat_map(|k| {
                        let mark = marks.then(|| of(bit(k as i16 & 1)));
                        mark.into_iter().chain([of(line((k + 1) * LENGTH_PULSES, 0, 80.0, SLOW_PULSES_PER_MS))])
                    });
                    assert_eq!(call(bench, &joined(&calls.collect::<Vec<_>>())).code, 0);
                    given += 15;
                }
                given == 3000
            };
            give_some(&mut bench);
            bench.done(start_crd(1));
            let begun = bench.now().0;
            let square = |motions: i16| 2.0 * SLOW_PULSES_PER_MS * f64::from(LENGTH_PULSES) * f64::from(motions);
            // It takes v/a to come to speed.
            let ramp_ns = (1.1e6 * square(count).sqrt() / SLOW_PULSES_PER_MS) as u64;
            let mut cruise = Vec::new();
            while !give_some(&mut bench) {
                for _ in 0..8 {
                    bench.step();
                    let axis = bench.server.view().axes[0];
                    let speed = bench.server.view().velocity(&axis);
                    if bench.now().0 > begun + ramp_ns {
                        cruise.push(speed.m as f64 * 2f64.powi(-i32::from(speed.e)));
                    }
                }
            }
            let [low, high] = [f64::min, f64::max].map(|of| cruise.iter().copied().reduce(of).unwrap());
            let found = format!("{count} motions, entries between: {marks}: from {low} to {high}");
            assert!(cruise.len() > 100 && high - low < 0.006 * high, "{found}");
            // The motion that comes next and those that leave with it are not in the window. The
            // last ones may still turn out to be rounding: 80 pulse/ms for T.
            let open = (80.0 * CORNER_MS) as i16 / LENGTH_PULSES as i16 + 1;
            assert!(low * low >= square(count - batch - 1 - open) && high * high <= square(count), "{found}");
        }
    }
}

/// A host that is too late: the path stops at the end of its data, without an underrun, and
/// continues.
#[test]
fn a_host_that_is_too_late_ends_no_path_at_speed() {
    let points = spiral(300);
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200));
    give(&mut bench, &points[..150]);
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!(bench.done(CrdInfo { core: 1.into(), crd: 1.into() }).path_stop, 1);
    assert_eq!(status(&mut bench, 0).1, 150);
    give(&mut bench, &points[150..]);
    bench.done(start_crd(1));
    until_standstill(&mut bench);
    assert_eq!((status(&mut bench, 0).1, crd_pos(&mut bench)), (300, points[299].map(f64::from).to_vec()));
}

/// A read says how long the data lasts as the data itself does, at rest, in motion and when it is
/// over.
#[test]
fn a_read_says_how_long_a_fifo_lasts() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let info = |bench: &mut Bench<8>| bench.done(CrdInfo { core: 1.into(), crd: 1.into() }).lasts_ms.map(|ms| ms.get());
    assert_eq!(info(&mut bench), [0, 0]);
    let mut given = 0;
    for x in [20_000, 40_000, 60_000] {
        given = bench.done(line(x, 0, 100.0, 4.0)).lasts_ms.get();
        assert_eq!(info(&mut bench), [given, 0]);
    }
    assert!(given >= 600, "{given}");
    bench.done(start_crd(1));
    let mut before = given;
    for _ in 0..4 {
        bench.run_ms(100);
        let [lasts, other] = info(&mut bench);
        // It is the least time, and the path brakes between its lines.
        assert!(other == 0 && lasts < before && lasts + 25 >= before.saturating_sub(100), "{before} to {lasts}");
        before = lasts;
    }
    until_standstill(&mut bench);
    assert_eq!(info(&mut bench), [0, 0]);
    // What is cleared lasts no more.
    bench.done(line(0, 0, 100.0, 4.0));
    assert_ne!(info(&mut bench), [0, 0]);
    bench.done(CrdClear { core: 1.into(), crd: 1.into(), fifo: 0.into() });
    assert_eq!(info(&mut bench), [0, 0]);
}

/// A program that streams: data after the start, in time by its clock.
#[test]
fn a_program_streams_through_the_look_ahead() {
    let points = spiral(2400);
    let ideal = ideal([0, 0], &points);
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.servo_on(2);
    let many = |part: &[[i32; 2]]| {
        let (head, items) = lines(part);
        (LnXYMany::OPCODE, protocol::record::Lane::Program, body::<LnXYMany>(head, &items))
    };
    let mut entries = vec![entry(prm()), entry(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200))];
    entries.extend(points[..600].chunks(60).map(many));
    entries.push(entry(start_crd(1)));
    for (round, part) in points[600..].chunks(300).enumerate() {
        entries.push(entry(sleep(if round == 0 { 100 } else { 150 })));
        entries.extend(part.chunks(60).map(many));
    }
    entries.push(entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 1.into() }));
    entries.push(entry(GetCrdPos { core: 1.into(), crd: 1.into() }));
    entries.push(entry(ProgramEnd {}));
    let mut tags = Vec::new();
    let mut started = false;
    for request in &entries {
        // As a client does: no more than the queue takes.
        loop {
            let queue = bench.done(ProgramStatus {});
            if queue.space_bytes.get() as usize > request.2.len() + 16 {
                break;
            }
            if !started {
                started = true;
                bench.done(ProgramStart { strict: 1 });
            }
            bench.run_ms(1);
        }
        tags.extend(bench.post_all(std::slice::from_ref(request)));
    }
    if !started {
        bench.done(ProgramStart { strict: 1 });
    }
    bench.wait(tags[tags.len() - 1]);
    for (index, tag) in tags.iter().enumerate() {
        let answer = &bench.answers[tag];
        assert_eq!(answer.code, 0, "entry {index}: {:?} {:?}", answer.reason(), answer.refusal());
    }
    let pos: Vec<f64> =
        bench.answers[&tags[tags.len() - 2]].items::<GetCrdPos>().iter().map(|item| item.value.get()).collect();
    assert_eq!(pos, points[2399].map(f64::from));
    let status = bench.done(ProgramStatus {});
    let clock = status.clock_ns.get() as f64 / 1e6;
    assert!((clock - ideal).abs() < 1.5, "{clock}, ideal {ideal}");
    assert_eq!((status.late.get(), status.worst_late_us.get()), (0, 0));
}

/// A WaitStop ends the data: the next run of the program begins at standstill, with its own data.
#[test]
fn a_wait_closes_the_look_ahead() {
    let points = spiral(100);
    let mut bench = Bench::gus();
    bench.servo_on(1);
    bench.servo_on(2);
    let many = |part: &[[i32; 2]]| {
        let (head, items) = lines(part);
        (LnXYMany::OPCODE, protocol::record::Lane::Program, body::<LnXYMany>(head, &items))
    };
    let mut entries = vec![entry(prm()), entry(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200))];
    for part in points.chunks(50) {
        entries.push(many(part));
        entries.push(entry(start_crd(1)));
        entries.push(entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 1.into() }));
        entries.push(entry(GetCrdPos { core: 1.into(), crd: 1.into() }));
    }
    entries.push(entry(ProgramEnd {}));
    let tags: Vec<u16> = entries.iter().flat_map(|request| bench.post_all(std::slice::from_ref(request))).collect();
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(bench.wait(tags[10]).code, 0);
    for (tag, point) in [(tags[5], points[49]), (tags[9], points[99])] {
        let pos: Vec<f64> = bench.answers[&tag].items::<GetCrdPos>().iter().map(|item| item.value.get()).collect();
        assert_eq!(pos, point.map(f64::from));
    }
    let clock = bench.done(ProgramStatus {}).clock_ns.get() as f64 / 1e6;
    let apart = ideal([0, 0], &points[..50]) + ideal(points[49], &points[50..]);
    assert!((clock - apart).abs() < 2.0, "{clock} {apart}");
}

/// Entries other than motions may come first in a program, before it is known where the path
/// stands.
#[test]
fn a_motion_may_come_after_what_begins_where_only_the_tick_knows() {
    for look in [0, 200] {
        let mut bench = Bench::gus();
        plane(&mut bench);
        bench.done(line(100, 50, 4.0, 1.0));
        bench.done(start_crd(1));
        until_standstill(&mut bench);
        let wait = BufDelay { core: 1.into(), crd: 1.into(), delay_ms: 3.into(), fifo: 0.into() };
        let entries = [
            entry(ahead(CORNER_MS, ACC_PULSES_PER_MS2, look)),
            entry(CrdClear { core: 1.into(), crd: 1.into(), fifo: 0.into() }),
            entry(wait),
            entry(line(300, 50, 4.0, 1.0)),
            entry(start_crd(1)),
            entry(WaitStop { core: 1.into(), axes: 0.into(), crds: 1.into() }),
            entry(ProgramEnd {}),
        ];
        let tags = bench.post_all(&entries);
        bench.done(ProgramStart { strict: 0 });
        for (index, tag) in tags.iter().enumerate() {
            let answer = bench.wait(*tag);
            assert_eq!(answer.code, 0, "look-ahead {look}, entry {index}: {:?}", answer.reason());
        }
        assert_eq!(crd_pos(&mut bench), [300.0, 50.0], "look-ahead {look}");
    }
}

/// LnXYG0 stops at its end, a limit of one coordinate holds, a look-ahead is set up on an empty
/// FIFO.
#[test]
fn rests_limits_and_set_up() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 200));
    let limit = |coordinate: i16, vel: f64| SetCrdLimit {
        core: 1.into(),
        crd: 1.into(),
        coordinate: coordinate.into(),
        vel_max: vel.into(),
        acc_max: 0.0.into(),
    };
    bench.done(limit(2, 30.0));
    let reported = bench.done(GetCrdLimit { core: 1.into(), crd: 1.into(), coordinate: 2.into() });
    assert_eq!(({ reported.vel_max }.get(), { reported.acc_max }.get()), (30.0, 0.0));
    // 3 in X to 4 in Y: Y has 0.8 of the path's speed.
    bench.done(line(6000, 8000, 100.0, 4.0));
    assert_eq!(bench.refused(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 100)).1, Reason::CrdHolds);
    bench.done(start_crd(1));
    let most = until_standstill(&mut bench);
    assert!((most - 37.5).abs() < 1e-6, "{most}");
    // All of it has run: now it may be set up again, or switched off.
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 0));
    bench.done(line(6000, 0, 100.0, 4.0));
    bench.done(start_crd(1));
    let most = until_standstill(&mut bench);
    assert!((most - 100.0).abs() < 1e-6, "without look-ahead a limit has no effect: {most}");
    bench.done(ahead(CORNER_MS, ACC_PULSES_PER_MS2, 10));
    let g0 = LnXYG0 {
        core: 1.into(),
        crd: 1.into(),
        x: 5000.into(),
        y: 0.into(),
        syn_vel: 100.0.into(),
        syn_acc: 4.0.into(),
        fifo: 0.into(),
    };
    bench.done(limit(2, 0.0));
    bench.done(g0);
    bench.done(line(4000, 0, 100.0, 4.0));
    bench.done(line(3000, 0, 100.0, 4.0));
    bench.done(flush());
    bench.done(start_crd(1));
    let begun = bench.now().0;
    let took = finish(&mut bench, begun);
    // 1000 pulses from standstill to standstill: 2·√(1000/4) = 31.62 ms; then 2000: 44.72 ms, no
    // stop between them.
    assert!((took - 76.34).abs() < 0.6, "{took}");
}
