//! A new session skips, answers and continues nothing that the one before had in hand, and nothing
//! of the old one keeps its link alive.
//!
//! No tick passes between the last request of one session and the first of the next, so all is
//! still in flight.
use crate::bench;
use bench::{Bench, MS, body, entry, sleep};
use protocol::command::*;
use protocol::frame::{self, FrameKind, Header, MAX_WIRE};
use protocol::reason::Reason;
use protocol::record::Lane;
use servo::units::Ns;

const CORE: i16 = 1;

fn now<R: Request>(request: R) -> (u16, Lane, Vec<u8>) {
    (R::OPCODE, Lane::Immediate, body::<R>(request, &[]))
}

fn set(axis: i16, pos: i32) -> (u16, Lane, Vec<u8>) {
    now(SetPrfPos { core: CORE.into(), profile: axis.into(), pos: pos.into() })
}

fn get(axis: i16) -> (u16, Lane, Vec<u8>) {
    now(GetPrfPos { core: CORE.into(), profile: axis.into(), count: 8.into() })
}

/// Another session at the same instant.
fn reopen(bench: &mut Bench<8>, nonce: u32) {
    let old = bench.client.session();
    bench.client.open(bench.now().0, nonce);
    bench.exchange();
    assert!(bench.client.session().is_some() && bench.client.session() != old);
    assert!(bench.server.is_open());
}

/// The client's bytes reach the server; its answers are lost.
fn one_way(bench: &mut Bench<8>) {
    let (at, mut bytes) = (bench.now(), [0; 4096]);
    for _ in 0..20 {
        let up = bench.client.take_tx(at.0, &mut bytes);
        bench.server.feed(at, &bytes[..up]);
        bench.server.poll(at);
        bench.server.take_tx(&mut bytes);
    }
}

#[test]
fn the_first_record_of_a_session_is_not_taken_for_one_that_was_dealt_with() {
    let mut bench = Bench::gus();
    // The first is done, the second waits for the tick.
    let old = bench.post_all(&[set(1, 100), get(1)]);
    bench.exchange();
    reopen(&mut bench, 77);
    let new = bench.post_all(&[set(2, 200), set(3, 300), get(1)]);
    for tag in &new {
        assert_eq!(bench.wait(*tag).code, 0);
    }
    assert_eq!([1, 2, 3].map(|axis| bench.pos(axis)), [100.0, 200.0, 300.0]);
    assert!(old.iter().all(|tag| !bench.answers.contains_key(tag)));
}

#[test]
fn what_an_old_session_waits_for_is_not_reported_to_the_new_one() {
    let mut bench = Bench::gus();
    // Executed with the next tick, so its answer is due in the next session.
    let old = bench.post_all(&[set(1, 100), set(2, 200)]);
    bench.exchange();
    reopen(&mut bench, 77);
    bench.run_ms(2);
    assert!(old.iter().all(|tag| !bench.answers.contains_key(tag)));
    assert_eq!(bench.answers.len(), 0);
    assert_eq!(bench.pos(2), 200.0);
}

#[test]
fn answers_that_were_gathered_for_an_old_session_are_not_sent_in_the_new_one() {
    let mut bench = Bench::gus();
    bench.run_ms(1);
    // More than the link's window holds, since nobody acknowledges it.
    let reads: Vec<_> = (0..30).map(|_| get(1)).collect();
    for _ in 0..8 {
        if bench.client.can_send() {
            bench.post_all(&reads);
        }
    }
    one_way(&mut bench);
    assert_eq!(bench.answers.len(), 0);
    reopen(&mut bench, 77);
    bench.run_ms(2);
    assert_eq!(bench.answers.len(), 0);
    let tag = bench.post_all(&[get(1)])[0];
    bench.wait(tag);
    assert_eq!(bench.order, [tag]);
}

#[test]
fn numbers_that_an_old_session_gave_are_not_reported_to_the_new_one() {
    let mut bench = Bench::gus();
    bench.run_ms(1);
    let power = |power: f64| now(LaserPrfCmd { core: CORE.into(), power: power.into(), channel: 0.into() });
    bench.post_all(&[power(11.0), power(12.0)]);
    bench.exchange();
    reopen(&mut bench, 77);
    let tag = bench.post_all(&[power(33.0)])[0];
    let reply = bench.wait(tag).reply::<LaserPrfCmd>();
    assert_eq!(reply.value.get(), 33.0);
}

#[test]
fn a_configuration_that_an_old_session_began_is_not_gone_on_with() {
    let mut bench = Bench::gus();
    bench.run_ms(1);
    // The lane is nearly full, so that the configuration waits in its middle.
    for _ in 0..5 {
        bench.post_all(&(0..20).map(|_| set(8, 1)).collect::<Vec<_>>());
        bench.exchange();
    }
    let item = |axis: i16| ConfigItem {
        axis: axis.into(),
        given: 0x1ff.into(),
        soft_positive: 1000.into(),
        soft_negative: (-1000).into(),
        dec_smooth: 2.0.into(),
        dec_abrupt: 3.0.into(),
        pos_err: 40.into(),
        ..ConfigItem::default()
    };
    let items: Vec<_> = (1..=8).map(item).collect();
    bench.post::<LoadConfig>(Lane::Immediate, LoadConfig { core: CORE.into(), count: 8.into() }, &items);
    bench.exchange();
    reopen(&mut bench, 77);
    let tag = bench.post_all(&[set(2, 222)])[0];
    assert_eq!(bench.wait(tag).code, 0);
    assert_eq!(bench.pos(2), 222.0);
    // Items that had not been taken are not done.
    let dec = bench.done(GetStopDec { core: CORE.into(), profile: 8.into() });
    assert_eq!(dec.smooth.get(), 1.0);
}

/// A program that is held, and one that runs: replies sent in its session count, the others are not
/// sent in the next one.
#[test]
fn nothing_of_an_old_program_is_reported_to_the_new_session() {
    for runs in [false, true] {
        let mut bench = Bench::gus();
        let pos = |axis: i16| entry(SetPrfPos { core: CORE.into(), profile: axis.into(), pos: 5.into() });
        let mut old =
            bench.post_all(&[pos(1), entry(sleep(5)), pos(2), entry(sleep(50)), pos(3), entry(ProgramEnd {})]);
        bench.exchange();
        if runs {
            old.push(bench.post::<ProgramStart>(Lane::Immediate, ProgramStart { strict: 0 }, &[]));
        }
        bench.run_ms(2);
        let reported = bench.answers.len();
        reopen(&mut bench, 77);
        bench.run_ms(100);
        assert_eq!(bench.answers.len(), reported);
        assert_eq!((bench.pos(3), bench.done(ProgramStatus {}).state), (0.0, 0));
        // Nor does anything of it prevent another one.
        let new = bench.post_all(&[pos(4), entry(sleep(1)), entry(ProgramEnd {})]);
        bench.done(ProgramStart { strict: 1 });
        assert!(new.iter().all(|tag| bench.wait(*tag).code == 0));
        assert_eq!([2, 3, 4].map(|axis| bench.pos(axis)), [0.0, 0.0, 5.0]);
        assert!(old.iter().filter(|tag| bench.answers.contains_key(tag)).count() <= reported);
    }
}

#[test]
fn numbers_that_an_old_program_gave_are_not_reported_to_the_new_session() {
    let mut bench = Bench::gus();
    let power = |power: f64| entry(LaserPrfCmd { core: CORE.into(), power: power.into(), channel: 0.into() });
    bench.post_all(&[entry(sleep(30)), power(11.0), power(12.0), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 0 });
    bench.run_ms(5);
    reopen(&mut bench, 77);
    bench.run_ms(5);
    let tags = bench.post_all(&[power(33.0), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 0 });
    assert_eq!(bench.wait(tags[0]).reply::<LaserPrfCmd>().value.get(), 33.0);
}

#[test]
fn a_queue_that_an_old_session_filled_is_empty() {
    let mut bench = Bench::gus();
    let full = |bench: &Bench<8>| {
        bench.answers.values().any(|answer| answer.code != 0 && answer.reason() == Reason::QueueFull)
    };
    for _ in 0..100 {
        let one = entry(SetPrfPos { core: CORE.into(), profile: 1.into(), pos: 5.into() });
        bench.post_all(&vec![one; 40]);
        bench.run_ms(1);
        if full(&bench) {
            break;
        }
    }
    assert!(full(&bench));
    let reported = bench.answers.len();
    reopen(&mut bench, 77);
    bench.run_ms(5);
    assert_eq!(bench.answers.len(), reported, "what waited in it is not reported");
    let tags = bench.post_all(&[entry(sleep(1)), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 0 });
    assert!(tags.iter().all(|tag| bench.wait(*tag).code == 0));
}

/// A caller that waits for the server's deadline does not miss that the link is lost.
#[test]
fn the_server_asks_to_be_woken_when_the_link_is_lost() {
    let mut bench = Bench::gus();
    bench.run_ms(50);
    bench.cut = true;
    let Some(due) = bench.server.next_deadline() else { panic!("it would sleep for ever") };
    let silence = due.0 - bench.now().0;
    assert!((400 * MS..=500 * MS + 1).contains(&silence), "{silence}");
}

/// A frame as an end of another session would send it.
fn stray(kind: FrameKind, session: u32) -> Vec<u8> {
    let header = Header {
        version: protocol::VERSION,
        kind: kind as u8,
        flags: 0,
        credit: 4,
        session: session.into(),
        sequence: 0.into(),
        acknowledgement: 0.into(),
        length: 0.into(),
    };
    let mut wire = vec![0; MAX_WIRE];
    let length = frame::encode(header, b"", &mut wire).unwrap();
    wire.truncate(length);
    wire
}

/// A client of an old session that goes on sending does not hide that this one's is gone.
#[test]
fn frames_of_an_old_session_do_not_keep_a_jog_alive() {
    let mut bench = Bench::gus();
    let old = bench.client.session().unwrap();
    bench.open(77);
    let (core, profile) = (CORE.into(), 1.into());
    bench.servo_on(1);
    bench.done(PrfJog { core, profile });
    bench.done(SetJogPrm { core, profile, acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
    bench.done(SetVel { core, profile, vel: 1.0.into() });
    bench.done(Update { core, mask: 1.into() });
    bench.run_ms(100);
    bench.cut = true;
    let runs = |bench: &mut Bench<8>| bench.server.view().axes[0].status & 1 << 10 != 0;
    let begin = bench.now().0;
    while bench.now().0 < begin + 520 * MS {
        if (bench.now().0 - begin).is_multiple_of(50 * MS) {
            assert!(runs(&mut bench) || bench.now().0 > begin + 380 * MS);
            for kind in [FrameKind::KeepAlive, FrameKind::Ack, FrameKind::Data] {
                bench.server.feed(Ns(bench.now().0), &stray(kind, old));
            }
        }
        bench.step();
    }
    assert!(!runs(&mut bench));
}
