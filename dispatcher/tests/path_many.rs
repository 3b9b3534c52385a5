//! PathMany: calls of a path joined in one command are taken, refused and answered as single ones.
use crate::{bench, laser_path};

use bench::crd::*;
use bench::{Answer, Bench, MS, entry, sleep};
use laser_path::{GUS, LSR, buf_power, follow_off};
use protocol::command::*;
use protocol::path_many::{JOINED_MAX, head};
use protocol::reason::{Reason, Refusal};
use protocol::record::Lane;
use zerocopy::{FromBytes, IntoBytes};

/// A call of a path: its number and its request.
type Call = (u16, Vec<u8>);

pub fn of<R: Request>(request: R) -> Call {
    (R::OPCODE, request.as_bytes().to_vec())
}

fn joined_for(target: [i16; 3], calls: &[Call]) -> Vec<u8> {
    let [core, crd, fifo] = target.map(Into::into);
    let count = (calls.len() as u16).into();
    let mut body = PathMany { core, crd, fifo, count }.as_bytes().to_vec();
    for (number, request) in calls {
        body.extend(head((*number, request)));
        body.extend(request);
    }
    body
}

pub fn joined(calls: &[Call]) -> Vec<u8> {
    joined_for([1, 1, 0], calls)
}

pub fn call(bench: &mut Bench<8>, body: &[u8]) -> Answer {
    let tag = bench.post_raw(PathMany::OPCODE, Lane::Immediate, body);
    bench.wait(tag)
}

/// What a PathMany took: how many calls, the refusal of the next, and what was not taken as given.
fn outcome(answer: &Answer) -> (u16, Option<Refusal>, Vec<PathHeld>) {
    let (refusal, rest) = match answer.code {
        0 => (None, &answer.body[..]),
        _ => {
            let (refusal, rest) = Refusal::read_from_prefix(&answer.body).unwrap();
            (Some(refusal), rest)
        }
    };
    if rest.is_empty() {
        return (0, refusal, Vec::new());
    }
    let (taken, rest) = CrdTaken::read_from_prefix(rest).unwrap();
    let held = rest.chunks(size_of::<PathHeld>()).map(|part| PathHeld::read_from_bytes(part).unwrap()).collect();
    (taken.taken.get(), refusal, held)
}

/// The refusal of a single call names no item.
fn alone(refusal: Refusal) -> Refusal {
    Refusal { item: Refusal::NO_ITEM.into(), ..refusal }
}

/// Lines of 60 pulses with a power each.
fn calls(count: usize) -> Vec<Call> {
    let power = |k: usize| buf_power((k % 100) as f64);
    (0..count).flat_map(|k| [of(power(k)), of(line(60 * (k as i32 + 1), 0, 100.0, 4.0))]).collect()
}

fn in_messages(calls: &[Call]) -> Vec<&[Call]> {
    calls.chunks(30).collect()
}

/// Positions and powers tick by tick, after the start of what the FIFO holds.
fn run(bench: &mut Bench<8>) -> Vec<(u64, u64, i64)> {
    bench.done(start_crd(1));
    let begun = bench.now().0;
    let mut rows = Vec::new();
    while bench.server.view().crds[0].runs {
        let view = bench.server.view();
        rows.push((view.now.0 - begun, view.lasers[0].power.raw() as u64, view.axes[0].pos.0));
        bench.step();
    }
    rows
}

#[test]
fn joined_calls_move_and_light_as_single_ones() {
    for looks in [false, true] {
        let mut all = Vec::new();
        for joins in [false, true] {
            let mut bench = laser_path::bench(GUS);
            if looks {
                bench.done(ahead(4.0, 4.0, 200));
            }
            let calls = calls(120);
            if joins {
                for part in in_messages(&calls) {
                    let answer = call(&mut bench, &joined(part));
                    assert_eq!(outcome(&answer), (part.len() as u16, None, Vec::new()));
                }
            } else {
                for (number, request) in &calls {
                    let tag = bench.post_raw(*number, Lane::Immediate, request);
                    assert_eq!(bench.wait(tag).code, 0);
                }
            }
            assert_eq!(space(&mut bench, 0), 1024 - 240);
            all.push(run(&mut bench));
        }
        assert_eq!(all[0], all[1]);
        assert!(all[0].len() > 100);
    }
}

#[test]
fn none_one_and_the_most_are_taken_and_one_more_is_not() {
    let mut bench = laser_path::bench(GUS);
    let answer = call(&mut bench, &joined(&[]));
    assert_eq!(outcome(&answer), (0, None, Vec::new()));
    assert_eq!(answer.reply::<PathMany>().space.get(), 1024);
    assert_eq!(outcome(&call(&mut bench, &joined(&calls(1)[..1]))).0, 1);
    let delay = of(BufDelay { core: 1.into(), crd: 1.into(), delay_ms: 1.into(), fifo: 0.into() });
    let most = JOINED_MAX / (4 + size_of::<BufDelay>());
    assert_eq!(most, 80);
    assert_eq!(outcome(&call(&mut bench, &joined(&vec![delay.clone(); most]))).0, 80);
    assert_eq!(space(&mut bench, 0), 1024 - 81);
    // Fewer and more than it says, a call that is cut, bytes that are no call.
    let mut body = joined(&calls(2));
    for (count, cut) in [(5, 0), (3, 0), (4, 1), (0, 0)] {
        let mut wrong = body[..body.len() - cut].to_vec();
        wrong[6] = count;
        let answer = call(&mut bench, &wrong);
        assert_eq!((answer.code, answer.reason()), (7, Reason::Length), "{count} {cut}");
    }
    body.push(0);
    assert_eq!(call(&mut bench, &body).reason(), Reason::Length);
    assert_eq!(call(&mut bench, &body[..7]).reason(), Reason::Length);
    assert_eq!(space(&mut bench, 0), 1024 - 81, "nothing of these was taken");
    // A FIFO that is not there, of a PathMany without calls, is its own.
    let answer = call(&mut bench, &joined_for([1, 9, 0], &[]));
    assert_eq!((answer.code, answer.refusal().field), (7, 1));
    let answer = call(&mut bench, &joined_for([1, 1, 2], &[]));
    assert_eq!((answer.code, answer.refusal().field), (7, 2));
}

#[test]
fn what_does_not_belong_to_the_fifo_is_refused_before_anything_is_taken() {
    let mut bench = laser_path::bench(GUS);
    let other = |crd: i16, fifo: i16| of(LnXY { crd: crd.into(), fifo: fifo.into(), ..line(60, 0, 50.0, 2.0) });
    let many = LnXYMany { core: 1.into(), crd: 1.into(), ..LnXYMany::default() };
    for foreign in [other(2, 0), other(1, 1), of(GetClock {}), of(start_crd(1)), of(many), of(PathMany::default())] {
        let number = foreign.0;
        let mut calls = calls(2);
        calls.push(foreign);
        let answer = call(&mut bench, &joined(&calls));
        let refusal = answer.refusal();
        assert_eq!((answer.code, answer.reason()), (7, Reason::NotOfPath));
        assert_eq!((refusal.item.get(), refusal.axis.get()), (4, 1));
        assert_eq!(refusal.got.get(), f64::from(number));
        assert_eq!(space(&mut bench, 0), 1024, "nothing was taken");
    }
    let text =
        "PathMany: command number 2062 is no call for FIFO 0 of coordinate system 1, which PathMany joins (item 5)";
    let mut calls = calls(2);
    calls.push(other(2, 0));
    let refusal = call(&mut bench, &joined(&calls)).refusal();
    assert_eq!(protocol::reason::describe_opcode(PathMany::OPCODE, refusal).to_string(), text);
}

/// Calls that are refused for every kind of reason, with the code of each.
fn wrong() -> Vec<(Call, i16)> {
    vec![
        (of(line(60, 0, 100.0, 4.0)), 7),
        (of(line(200, 0, f64::NAN, 4.0)), 7),
        (of(buf_power(150.0)), 7),
        (of(BufLaserPrfCmd { channel: 5.into(), ..buf_power(5.0) }), 7),
        (of(arc(200, 0, 3.0, 0.0, 0)), 7),
        (of(BufGear { core: 1.into(), crd: 1.into(), axis: 1.into(), pos: 1.into(), fifo: 0.into() }), 1),
        (of(BufDelay { core: 1.into(), crd: 1.into(), delay_ms: 1.into(), fifo: 0.into() }), 0),
        ((LnXY::OPCODE, vec![1, 0, 1, 0, 0]), 7),
        ((BufDelay::OPCODE, vec![1, 0, 1, 0, 0, 0, 0, 0, 0]), 7),
    ]
}

#[test]
fn a_call_that_is_refused_is_named_and_those_before_it_are_taken() {
    for (wrong, code) in wrong() {
        for lane in [Lane::Immediate, Lane::Program, Lane::ProgramMayFail] {
            let mut single = laser_path::bench(GUS);
            for (number, request) in &calls(1) {
                let tag = single.post_raw(*number, Lane::Immediate, request);
                assert_eq!(single.wait(tag).code, 0);
            }
            let tag = single.post_raw(wrong.0, Lane::Immediate, &wrong.1);
            let expected = single.wait(tag);
            assert_eq!(expected.code, code);
            let mut bench = laser_path::bench(GUS);
            let mut calls = calls(1);
            calls.push(wrong.clone());
            calls.push(of(line(500, 0, 100.0, 4.0)));
            let tag = bench.post_raw(PathMany::OPCODE, lane, &joined(&calls));
            if lane != Lane::Immediate {
                bench.exchange();
                bench.done(ProgramStart { strict: 0 });
            }
            let answer = bench.wait(tag);
            let (taken, refusal, _) = outcome(&answer);
            if code == 0 {
                assert_eq!((taken, refusal), (4, None));
                continue;
            }
            assert_eq!((answer.code, taken), (code, 2), "{lane:?}");
            let refusal = refusal.unwrap();
            assert_eq!((alone(refusal), refusal.item.get()), (expected.refusal(), 2), "{lane:?}");
            assert_eq!(space(&mut bench, 0), 1022, "{lane:?}");
        }
    }
    // The first one.
    let mut bench = laser_path::bench(GUS);
    let answer = call(&mut bench, &joined(&[of(buf_power(150.0)), of(line(500, 0, 100.0, 4.0))]));
    assert_eq!((outcome(&answer).0, answer.refusal().item.get()), (0, 0));
    assert_eq!(space(&mut bench, 0), 1024);
}

#[test]
fn a_full_fifo_takes_what_fits() {
    let mut bench = laser_path::bench(GUS);
    for part in calls(505).chunks(30) {
        assert_eq!(call(&mut bench, &joined(part)).code, 0);
    }
    let more: Vec<Call> = (0..20).map(|k| of(line(40_000 + 60 * k, 0, 100.0, 4.0))).collect();
    let answer = call(&mut bench, &joined(&more));
    let (taken, refusal, _) = outcome(&answer);
    assert_eq!((answer.code, taken, refusal.unwrap().reason()), (1, 14, Some(Reason::CrdFull)));
    assert_eq!(space(&mut bench, 0), 0);
}

#[test]
fn what_was_not_taken_as_it_was_given_is_reported_for_its_call() {
    let mut bench = laser_path::bench(LSR);
    let ratio = |max: f64| BufLaserFollowRatio {
        core: 1.into(),
        crd: 1.into(),
        ratio: 1.0.into(),
        min: 0.0.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    };
    let calls =
        [of(buf_power(50.0)), of(buf_power(150.0)), of(ratio(180.0)), of(line(60, 0, 100.0, 4.0)), of(buf_power(-1.0))];
    let single = |call: &Call| {
        let mut bench = laser_path::bench(LSR);
        let tag = bench.post_raw(call.0, Lane::Immediate, &call.1);
        bench.wait(tag).body
    };
    let values: Vec<LaserValue> =
        [&calls[1], &calls[4]].map(|call| LaserValue::read_from_bytes(&single(call)).unwrap()).to_vec();
    let bounds = LaserBounds::read_from_bytes(&single(&calls[2])).unwrap();
    let expected = [
        PathHeld { call: 1.into(), first: values[0].value, second: 0.0.into(), held: values[0].held },
        PathHeld { call: 2.into(), first: bounds.max, second: bounds.min, held: bounds.held },
        PathHeld { call: 4.into(), first: values[1].value, second: 0.0.into(), held: values[1].held },
    ];
    assert!(expected.iter().all(|held| held.held != 0));
    let answer = call(&mut bench, &joined(&calls));
    assert_eq!(outcome(&answer), (5, None, expected.to_vec()));
    // Before one that is refused, too.
    let mut refused = calls.to_vec();
    refused.push(of(line(60, 0, 100.0, 4.0)));
    let answer = call(&mut bench, &joined(&refused));
    assert_eq!((outcome(&answer).0, outcome(&answer).2), (3, expected[..2].to_vec()));
    // More than the lane keeps: the rest is to be sent again.
    let many = vec![of(buf_power(150.0)); 48];
    let (taken, refusal, held) = outcome(&call(&mut bench, &joined(&many)));
    assert_eq!((refusal.unwrap().reason(), usize::from(taken)), (Some(Reason::RingFull), held.len()));
    assert!(taken > 20, "{taken}");
    // A program keeps all.
    let tag = bench.post_raw(PathMany::OPCODE, Lane::Program, &joined(&many));
    bench.exchange();
    bench.done(ProgramStart { strict: 0 });
    let (taken, refusal, held) = outcome(&bench.wait(tag));
    assert_eq!((taken, refusal, held.len()), (48, None, 48));
}

/// Entries of a program that streams more than the FIFO holds, and its tags.
fn stream(bench: &mut Bench<8>, calls: &[Call], looks: bool) -> Vec<u16> {
    let mut tags = Vec::new();
    let mut entries = vec![];
    if looks {
        entries.push(entry(ahead(4.0, 4.0, 200)));
    }
    let parts: Vec<(u16, Lane, Vec<u8>)> =
        in_messages(calls).into_iter().map(|part| (PathMany::OPCODE, Lane::Program, joined(part))).collect();
    entries.extend(parts[..10].iter().cloned());
    entries.push(entry(start_crd(1)));
    entries.extend(parts[10..].iter().cloned());
    let mut started = false;
    for request in &entries {
        while (bench.done(ProgramStatus {}).space_bytes.get() as usize) < request.2.len() + 16 {
            if !started {
                started = true;
                bench.done(ProgramStart { strict: 0 });
            }
            bench.run_ms(1);
        }
        tags.extend(bench.post_all(std::slice::from_ref(request)));
    }
    tags
}

#[test]
fn a_program_waits_for_room_in_the_middle() {
    for looks in [false, true] {
        let mut bench = laser_path::bench(GUS);
        let tags = stream(&mut bench, &calls(1500), looks);
        bench.wait(tags[tags.len() - 1]);
        for (index, tag) in tags.iter().enumerate() {
            let answer = &bench.answers[tag];
            assert_eq!(answer.code, 0, "entry {index}: {answer:?}");
        }
        until_standstill(&mut bench);
        assert_eq!(status(&mut bench, 0), (0, 1500));
        assert_eq!(crd_pos(&mut bench), [90_000.0, 0.0]);
        let status = bench.done(ProgramStatus {});
        assert_eq!(status.late.get(), 0);
    }
}

/// The program is ended while a PathMany waits for room: what was executed of it is said.
#[test]
fn an_end_in_the_middle_says_what_was_executed() {
    for ends in [true, false] {
        let mut bench = laser_path::bench(GUS);
        // 1010 entries, then 20, of which 14 fit.
        let mut entries: Vec<(u16, Lane, Vec<u8>)> = calls(505).chunks(30).map(joined).map(joins).collect();
        let more: Vec<Call> = (0..20).map(|k| of(line(40_000 + 60 * k, 0, 100.0, 4.0))).collect();
        entries.push(entry(sleep(5)));
        entries.push(joins(joined(&more)));
        entries.push(entry(follow_off()));
        let mut tags = Vec::new();
        let mut started = false;
        for request in &entries {
            while (bench.done(ProgramStatus {}).space_bytes.get() as usize) < request.2.len() + 16 {
                if !started {
                    started = true;
                    bench.done(ProgramStart { strict: 0 });
                }
                bench.step();
            }
            tags.extend(bench.post_all(std::slice::from_ref(request)));
        }
        if !started {
            bench.done(ProgramStart { strict: 0 });
        }
        if ends {
            bench.done(Abort { core: 1.into() });
        }
        let [.., of, after] = tags[..] else { panic!() };
        let answer = bench.wait(of);
        let (taken, refusal, _) = outcome(&answer);
        if !ends {
            // Nothing runs that would make room.
            assert_eq!((taken, refusal.unwrap().reason()), (14, Some(Reason::CrdFull)));
        } else {
            let reason = refusal.unwrap().reason();
            assert_eq!(reason, Some(Reason::Discarded));
            assert!(taken == 0 || taken == 14);
        }
        assert_eq!(bench.wait(after).reason(), Reason::Discarded);
        assert!(bench.now().0 > 5 * MS);
    }
}

/// The program is dropped while a PathMany waits for room beside a path that runs.
#[test]
fn a_drop_in_the_middle_says_what_was_executed() {
    for cuts in [false, true] {
        let mut bench = laser_path::bench(GUS);
        let mut entries = vec![entry(line(-100_000, 0, 10.0, 4.0))];
        entries.extend(calls(505).chunks(30).map(joined).map(joins));
        entries.push(entry(start_crd(1)));
        // 1011 places are taken.
        let more: Vec<Call> = (0..20).map(|k| of(line(40_000 + 60 * k, 0, 100.0, 4.0))).collect();
        entries.push(joins(joined(&more)));
        entries.push(entry(follow_off()));
        let (mut tags, mut started) = (Vec::new(), false);
        for request in &entries {
            while (bench.done(ProgramStatus {}).space_bytes.get() as usize) < request.2.len() + 16 {
                if !started {
                    started = true;
                    bench.done(ProgramStart { strict: 0 });
                }
                bench.step();
            }
            tags.extend(bench.post_all(std::slice::from_ref(request)));
        }
        bench.exchange();
        if !started {
            bench.done(ProgramStart { strict: 0 });
        }
        bench.run_ms(50);
        let [.., of, after] = tags[..] else { panic!() };
        assert!(!bench.answers.contains_key(&of), "it waits for room");
        if cuts {
            bench.cut = true;
            bench.run_ms(600);
            bench.cut = false;
        } else {
            bench.done(Abort { core: 1.into() });
        }
        let (taken, refusal, _) = outcome(&bench.wait(of));
        let refusal = refusal.unwrap();
        let expected = if cuts { Reason::LinkLost } else { Reason::Discarded };
        assert_eq!((taken, refusal.item.get(), refusal.reason()), (13, 13, Some(expected)));
        assert_eq!(bench.wait(after).reason(), expected);
    }
}

fn joins(body: Vec<u8>) -> (u16, Lane, Vec<u8>) {
    (PathMany::OPCODE, Lane::Program, body)
}

/// A session that ends in the middle leaves nothing for the next one.
#[test]
fn a_new_session_begins_anew() {
    let mut bench = laser_path::bench(GUS);
    for part in calls(505).chunks(30) {
        assert_eq!(call(&mut bench, &joined(part)).code, 0);
    }
    let more: Vec<Call> = (0..20).map(|k| of(line(40_000 + 60 * k, 0, 100.0, 4.0))).collect();
    bench.post_raw(PathMany::OPCODE, Lane::Immediate, &joined(&more));
    bench.exchange();
    bench.open(77);
    bench.done(clear(0));
    let answer = call(&mut bench, &joined(&calls(3)));
    assert_eq!(outcome(&answer), (6, None, Vec::new()));
    assert_eq!(space(&mut bench, 0), 1018);
}
