//! Light owner, Abort, sessions, link loss and interlock, over the link (SPEC 6 and 9): refusals
//! with their texts, and defaults that come back.
use crate::bench;
use bench::crd::{clear, line, plane, start_crd};
use bench::{Bench, MS, entry, sleep};
use protocol::command::*;
use protocol::reason::{Reason, describe_opcode, laser_ignored, stop_reason};
use protocol::record::Lane;
use servo::laser::Cause;

const GUS: u8 = 0;
const LSR: u8 = 1;

/// LSR, X and Y on axes 1 and 2, coordinate system 2 on axes 3 and 4, duty mode with 40 % of 10
/// kHz, all dark and at standstill.
fn bench() -> Bench<8> {
    let mut bench = Bench::gus();
    bench.done(Choose { profile: 0, family: LSR });
    plane(&mut bench);
    bench.servo_on(3);
    bench.servo_on(4);
    let mut profile = [0.into(); 8];
    (profile[2], profile[3]) = (1.into(), 2.into());
    bench.done(SetCrdPrm { crd: 2.into(), profile, ..bench::crd::prm() });
    bench.done(LaserOutFrq { core: 1.into(), frequency: 10.0.into(), channel: 0.into() });
    bench.done(LaserPrfCmd { core: 1.into(), power: 40.0.into(), channel: 0.into() });
    bench
}

fn map(map: i16) -> SetLaserCrdMap {
    SetLaserCrdMap { core: 1.into(), channel: 0.into(), map: map.into() }
}

fn mapped(bench: &mut Bench<8>) -> i16 {
    bench.done(GetLaserCrdMap { core: 1.into(), channel: 0.into() }).value.get()
}

fn on() -> LaserOn {
    LaserOn { core: 1.into(), channel: 0.into() }
}

fn off() -> LaserOff {
    LaserOff { core: 1.into(), channel: 0.into() }
}

fn buf_on() -> BufLaserOn {
    BufLaserOn { core: 1.into(), crd: 1.into(), fifo: 0.into(), channel: 0.into() }
}

fn abort() -> Abort {
    Abort { core: 1.into() }
}

fn lit(bench: &mut Bench<8>) -> bool {
    bench.server.view().lasers[0].light
}

/// Stops coordinate system 1 abruptly.
fn stop(bench: &mut Bench<8>) {
    bench.done(CrdStop { core: 1.into(), mask: 1.into(), option: 1.into() });
    bench.run_ms(1);
}

fn runs(bench: &mut Bench<8>, crd: usize) -> bool {
    bench.server.view().crds[crd].runs
}

#[track_caller]
fn text(bench: &mut Bench<8>, request: impl Request) -> (i16, String) {
    fn of<R: Request>(bench: &mut Bench<8>, request: R) -> (i16, String) {
        let answer = bench.call(request);
        (answer.code, describe_opcode(R::OPCODE, answer.refusal()).to_string())
    }
    of(bench, request)
}

const IN_USE: &str = "SetLaserCrdMap: laser channel 0: coordinate system 1 runs, or has light of this channel that would come back; stop it, and switch the light off first";
const ABORTING: &str = "after an abort lasers are switched on once everything has come to rest; wait for that";

/// SPEC 6: a buffered laser entry that names another channel is refused (1).
#[test]
fn entries_for_a_channel_that_is_not_mapped_are_refused() {
    let mut bench = bench();
    bench.done(map(0b10));
    let (core, crd, fifo, channel) = (1.into(), 1.into(), 0.into(), 0.into());
    let before = bench.done(CrdSpace { core, crd, fifo }).value.get();
    let reported = [
        text(&mut bench, buf_on()),
        text(&mut bench, BufLaserOff { core, crd, fifo, channel }),
        text(&mut bench, BufLaserPrfCmd { core, crd, power: 10.0.into(), fifo, channel }),
        text(
            &mut bench,
            BufLaserPrfFollow { core, crd, ratio: 1.0.into(), min: 1.into(), max: 9.into(), fifo, channel },
        ),
        text(
            &mut bench,
            BufLaserFollowMode { core, crd, source: 0.into(), fifo, channel, start_power: 0.0.into(), start_given: 0 },
        ),
        text(
            &mut bench,
            BufLaserFollowRatio { core, crd, ratio: 1.0.into(), min: 1.0.into(), max: 9.0.into(), fifo, channel },
        ),
        text(&mut bench, BufLaserFollowOff { core, crd, fifo, channel }),
    ];
    for (code, reported) in &reported {
        let why = "laser channel 0 is not mapped to coordinate system 1; call SetLaserCrdMap first";
        assert_eq!((*code, reported.split_once(": ").unwrap().1), (1, why), "{reported}");
    }
    assert_eq!(reported[0].1.split_once(':').unwrap().0, "BufLaserOn");
    assert_eq!(bench.done(CrdSpace { core, crd, fifo }).value.get(), before);
    // The other coordinate system may, and the other channel is still mapped.
    bench.done(BufLaserOn { crd: 2.into(), ..buf_on() });
    bench.done(BufLaserOn { channel: 1.into(), ..buf_on() });
    bench.done(map(0b11));
    bench.done(buf_on());
}

/// SPEC 6: an entry that is reached when the map no longer holds its coordinate system does nothing
/// and is an event.
#[test]
fn an_entry_that_is_reached_unmapped_does_nothing_and_is_reported() {
    let mut bench = bench();
    bench.done(buf_on());
    bench.done(line(100, 0, 10.0, 1.0));
    bench.done(map(0b10));
    bench.done(start_crd(1));
    bench.run_ms(5);
    assert!(runs(&mut bench, 0) && !lit(&mut bench));
    let last = bench.call(GetEvents {}).items::<GetEvents>().last().copied().unwrap();
    assert_eq!((last.kind, last.of, laser_ignored(last.reason.get())), (7, 0, laser_ignored(1)));
    assert!(laser_ignored(1).contains("not mapped"));
}

/// SPEC 6: SetLaserCrdMap returns 1 while a crd of the old or the new map runs. It also returns 1
/// while light of this channel that one of them lit is on or would come back with CrdStart.
#[test]
fn the_map_stays_while_its_coordinate_systems_run_or_have_light_to_come_back() {
    let mut bench = bench();
    // In set-up nothing prevents it, and light of a call does not either.
    for given in [0b01, 0b10, 0b00, 0b11] {
        bench.done(map(given));
        assert_eq!(mapped(&mut bench), given);
    }
    bench.done(on());
    bench.done(map(0b01));
    bench.done(off());
    bench.done(buf_on());
    bench.done(line(500, 0, 10.0, 1.0));
    bench.done(start_crd(1));
    bench.run_ms(5);
    assert!(lit(&mut bench));
    // Of the old map, of the new one, of both.
    for given in [0b10, 0b01, 0b11, 0b00] {
        assert_eq!(text(&mut bench, map(given)), (1, IN_USE.into()));
    }
    // Neither of the other channel's maps holds it.
    bench.done(off());
    bench.done(on());
    let other = |map: i16| SetLaserCrdMap { core: 1.into(), channel: 1.into(), map: map.into() };
    assert_eq!(bench.refused(other(0b10)).1, Reason::LaserMapInUse);
    // At standstill by a Stop, with light that would come back.
    bench.done(off());
    bench.run_ms(100);
    assert!(!runs(&mut bench, 0));
    bench.done(other(0b10));
    bench.done(buf_on());
    bench.done(line(0, 0, 10.0, 1.0));
    bench.done(start_crd(1));
    bench.run_ms(5);
    stop(&mut bench);
    assert!(!runs(&mut bench, 0) && !lit(&mut bench));
    assert_eq!(text(&mut bench, map(0b10)), (1, IN_USE.into()));
    assert_eq!(mapped(&mut bench), 0b01);
    // Switched off it does not come back.
    bench.done(off());
    bench.run_ms(1);
    bench.done(map(0b10));
    assert_eq!(mapped(&mut bench), 0b10);
    bench.done(start_crd(1));
    bench.run_ms(5);
    assert!(runs(&mut bench, 0) && !lit(&mut bench));
    // Of the new map only.
    assert_eq!(bench.refused(map(0b01)).1, Reason::LaserMapInUse);
    bench.done(other(0b00));
}

/// The same in a program whose set-up is admitted ahead: all of one instant.
#[test]
fn a_program_may_map_in_its_set_up() {
    let mut bench = bench();
    let program = [
        entry(bench::crd::prm()),
        entry(clear(0)),
        entry(map(0b01)),
        entry(buf_on()),
        entry(line(20, 0, 10.0, 1.0)),
        entry(start_crd(1)),
        entry(sleep(20)),
        entry(map(0b11)),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&program);
    bench.done(ProgramStart { strict: 1 });
    let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
    assert_eq!(codes, [0; 9]);
    assert_eq!(mapped(&mut bench), 0b11);
}

/// A path of coordinate system 1 at 10 pulse/ms, which brakes within 10 ms.
fn path(bench: &mut Bench<8>) {
    bench.done(SetCrdStopDec { core: 1.into(), crd: 1.into(), smooth: 1.0.into(), abrupt: 1000.0.into() });
    bench.done(buf_on());
    bench.done(line(1000, 0, 10.0, 1.0));
    bench.done(start_crd(1));
    bench.run_ms(20);
    assert!(lit(bench) && runs(bench, 0));
}

/// SPEC 9: every channel is dark at once. On commands are refused (1) until everything is at
/// standstill. Entries in the FIFOs stay and can be started; nothing lights without a new on
/// command.
#[test]
fn on_commands_are_refused_while_an_abort_brakes_and_taken_after() {
    let mut bench = bench();
    path(&mut bench);
    bench.done(abort());
    bench.run_ms(1);
    assert!(!lit(&mut bench) && runs(&mut bench, 0), "dark while it brakes");
    assert_eq!(text(&mut bench, on()), (1, format!("LaserOn: {ABORTING}")));
    let switch = |value: u16| SetHSIOOpt { core: 1.into(), value: value.into(), channel: 0.into() };
    assert_eq!(text(&mut bench, switch(1)), (1, format!("SetHSIOOpt: {ABORTING}")));
    bench.done(switch(0));
    bench.run_ms(15);
    assert!(!runs(&mut bench, 0));
    assert_eq!(bench.server.view().lasers[0].fault, Cause::None, "an abort is no fault");
    bench.done(start_crd(1));
    bench.run_ms(5);
    assert!(runs(&mut bench, 0) && !lit(&mut bench), "its FIFO goes on in the dark");
    bench.done(on());
    bench.run_ms(1);
    assert!(lit(&mut bench));
    let events = bench.call(GetEvents {}).items::<GetEvents>();
    let of = |kind: u8| events.iter().filter(|e| e.kind == kind).map(|e| (e.of, e.reason.get())).collect::<Vec<_>>();
    assert_eq!((of(8), of(3)), (vec![(0, 1)], vec![]), "the abort, and no fault");
    assert_eq!(of(2).iter().map(|e| (e.0, stop_reason(e.1))).collect::<Vec<_>>(), [(1, "an abort")]);
    // After an abort, at standstill, an on command is taken at once.
    bench.run_ms(200);
    bench.done(abort());
    bench.done(on());
    bench.run_ms(1);
    assert!(lit(&mut bench));
}

/// SPEC 9: pending commands are withdrawn.
#[test]
fn an_abort_beside_a_running_program_discards_its_rest() {
    let mut bench = bench();
    let program = [entry(on()), entry(sleep(1000)), entry(off()), entry(sleep(1)), entry(on()), entry(ProgramEnd {})];
    let tags = bench.post_all(&program);
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(5);
    assert!(lit(&mut bench));
    bench.done(abort());
    bench.run_ms(1);
    assert!(!lit(&mut bench));
    assert_eq!(bench.wait(tags[0]).code, 0);
    for &tag in &tags[2..] {
        assert_eq!(bench.wait(tag).reason(), Reason::Discarded);
    }
    assert_eq!(bench.done(ProgramStatus {}).state, 4, "stopped");
    bench.run_ms(1100);
    assert!(!lit(&mut bench));
    bench.done(ProgramClear {});
    bench.done(on());
}

#[test]
fn an_abort_beside_a_held_program_discards_it() {
    let mut bench = bench();
    let tags = bench.post_all(&[entry(on()), entry(sleep(1)), entry(ProgramEnd {})]);
    bench.run_ms(2);
    bench.done(abort());
    for &tag in &tags {
        assert_eq!(bench.wait(tag).reason(), Reason::Discarded);
    }
    bench.call(ProgramStart { strict: 1 });
    bench.run_ms(5);
    assert!(!lit(&mut bench));
    bench.done(ProgramClear {});
    let tags = bench.post_all(&[entry(on()), entry(sleep(1)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(bench.wait(tags[2]).code, 0);
    assert!(lit(&mut bench));
}

/// SPEC 9: at the end of a script it acts as a call there would.
#[test]
fn an_abort_in_a_program_acts_at_its_instant() {
    let mut bench = bench();
    let program = [
        entry(on()),
        entry(sleep(20)),
        entry(abort()),
        entry(sleep(10)),
        entry(on()),
        entry(sleep(5)),
        entry(abort()),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&program);
    bench.done(ProgramStart { strict: 1 });
    let zero = bench.server.view().script_zero.0;
    assert!(lit(&mut bench));
    let mut edges = Vec::new();
    while !bench.answers.contains_key(&tags[7]) {
        let before = lit(&mut bench);
        bench.step();
        if lit(&mut bench) != before {
            edges.push((bench.now().0 - zero) / MS);
        }
    }
    assert_eq!(edges, [20, 30, 35]);
    let codes: Vec<i16> = tags.iter().map(|&tag| bench.wait(tag).code).collect();
    assert_eq!(codes, [0; 8], "nothing after it is discarded");
}

/// While it brakes, an on entry of the program does not wait: it is refused at its instant.
#[test]
fn an_on_entry_while_an_abort_of_the_program_brakes_is_refused() {
    let mut bench = bench();
    path(&mut bench);
    let tags = bench.post_all(&[entry(abort()), entry(sleep(2)), entry(on()), entry(sleep(1)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 1 });
    let answer = bench.wait(tags[2]);
    assert_eq!((answer.code, answer.reason()), (1, Reason::Aborting));
    assert_eq!(bench.wait(tags[3]).reason(), Reason::Discarded);
    bench.run_ms(50);
    assert!(!lit(&mut bench));
}

fn link_loss(bench: &mut Bench<8>) -> (f64, i16) {
    let reported = bench.done(GetLinkLoss {});
    (reported.time_ms.get(), reported.stop_all.get())
}

/// SPEC 9: the link-loss time lasts for the session; a Reset sets the default; GetLinkLoss reads
/// it.
#[test]
fn the_link_loss_time_lasts_for_the_session() {
    let mut bench = bench();
    let set = |time_ms: i32, stop_all: i16| SetLinkLoss { time_ms: time_ms.into(), stop_all: stop_all.into() };
    assert_eq!(link_loss(&mut bench), (500.0, 0));
    bench.done(set(200, 1));
    assert_eq!(link_loss(&mut bench), (200.0, 1));
    // Another family is no new user.
    bench.done(Choose { profile: 0, family: GUS });
    assert_eq!(link_loss(&mut bench), (200.0, 1));
    bench.done(Reset { core: 1.into() });
    assert_eq!(link_loss(&mut bench), (500.0, 0));
    // Its value off does not outlast the session either.
    bench.done(set(0, 0));
    assert_eq!(link_loss(&mut bench), (0.0, 0));
    bench.open(2);
    assert_eq!(link_loss(&mut bench), (500.0, 0));
    assert_eq!(bench.refused(set(-1, 0)).0, 7);
    assert_eq!(link_loss(&mut bench), (500.0, 0));
    // It is read beside a program.
    bench.post_all(&[entry(sleep(50)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 1 });
    assert_eq!(link_loss(&mut bench), (500.0, 0));
}

/// Effect of the interlock input on a jog at 10 pulse/ms: its speed 3 ms later.
fn interlocked(bench: &mut Bench<8>) -> f64 {
    let (core, profile) = (1.into(), 5.into());
    bench.servo_on(5);
    bench.done(PrfJog { core, profile });
    bench.done(SetJogPrm { core, profile, acc: 10.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
    bench.done(SetVel { core, profile, vel: 10.0.into() });
    bench.done(Update { core, mask: 16.into() });
    bench.run_ms(5);
    bench.machine.interlock = true;
    bench.run_ms(3);
    let vel = bench.call(GetPrfVel { core, profile, count: 1.into() }).items::<GetPrfVel>()[0].value.get();
    bench.machine.interlock = false;
    bench.done(Stop { core, mask: 16.into(), option: 16.into(), form: 1 });
    bench.run_ms(2);
    bench.done(ClrSts { core, axis: 1.into(), count: 8.into() });
    bench.run_ms(2);
    vel
}

/// SPEC 9: 0 goes on without light, 1 as at link loss (the default), 2 everything stops abruptly.
#[test]
fn what_the_interlock_does_to_motion_is_the_users() {
    let mut bench = bench();
    let set = |motion: i16| SetInterlock { motion: motion.into() };
    for (motion, text) in [(-1, "motion is -1; allowed are 0 to 2"), (3, "motion is 3; allowed are 0 to 2")] {
        assert_eq!(self::text(&mut bench, set(motion)), (7, format!("SetInterlock: {text}")));
    }
    let brakes = |vel: f64| 0.0 < vel && vel < 10.0;
    let vel = interlocked(&mut bench);
    assert!(brakes(vel), "{vel}");
    for (motion, expected) in [(0, 10.0), (2, 0.0)] {
        bench.done(set(motion));
        assert_eq!(interlocked(&mut bench), expected);
    }
    // Choosing a family changes nothing of it, a Reset and a new session do.
    bench.done(Choose { profile: 0, family: GUS });
    assert_eq!(interlocked(&mut bench), 0.0);
    bench.done(Reset { core: 1.into() });
    let vel = interlocked(&mut bench);
    assert!(brakes(vel), "{vel}");
    bench.done(set(0));
    assert_eq!(interlocked(&mut bench), 10.0);
    bench.open(2);
    let vel = interlocked(&mut bench);
    assert!(brakes(vel), "{vel}");
}

/// SPEC 9: a new session begins dark: light of an earlier one is shut off, without a fault.
#[test]
fn a_new_session_begins_dark() {
    let mut bench = bench();
    path(&mut bench);
    bench.open(2);
    bench.run_ms(1);
    assert!(!lit(&mut bench) && runs(&mut bench, 0), "motion goes on");
    let seen = bench.server.view().lasers[0];
    assert_eq!((seen.fault, seen.commanded), (Cause::None, false));
    let events = bench.call(GetEvents {}).items::<GetEvents>();
    assert_eq!(events.iter().map(|e| (e.kind, e.of, e.reason.get())).next_back(), Some((8, 0, 2)));
    // Its own on command is taken at once.
    bench.done(on());
    bench.run_ms(1);
    assert!(lit(&mut bench));
}

/// Pending entries of an earlier session light nothing, in whichever tick the new one begins.
#[test]
fn entries_of_an_earlier_session_do_not_light() {
    for steps in 0..24 {
        let mut bench = bench();
        // An on entry for every tick.
        let mut program = Vec::new();
        for _ in 0..6 {
            program.extend([entry(on()), entry(sleep(1)), entry(off()), entry(Sleep { ns: 250_000.into() })]);
        }
        program.extend([entry(on()), entry(sleep(10_000)), entry(ProgramEnd {})]);
        bench.post_all(&program);
        let tag = bench.post(Lane::Immediate, ProgramStart { strict: 0 }, &[]);
        bench.wait(tag);
        for _ in 0..steps {
            bench.step();
        }
        bench.open(2);
        bench.run_ms(1);
        for _ in 0..100 {
            assert!(!lit(&mut bench), "{steps}");
            bench.step();
        }
        assert_eq!(bench.done(ProgramStatus {}).state, 0);
        assert_eq!(bench.server.view().lasers[0].fault, Cause::None);
    }
}

/// In a program they act at their instant on the script clock, and not when they are admitted.
#[test]
fn what_binds_safety_to_a_user_changes_at_its_instant_in_a_program() {
    let mut bench = bench();
    let off = SetLinkLoss { time_ms: 0.into(), stop_all: 0.into() };
    bench.post_all(&[entry(sleep(50)), entry(off), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(40);
    assert_eq!(bench.done(GetLinkLoss {}).time_ms.get(), 500.0, "not before its instant");
    bench.run_ms(20);
    assert_eq!(bench.done(GetLinkLoss {}).time_ms.get(), 0.0);
}
