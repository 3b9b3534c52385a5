//! Viewers of a served controller, in read-only sessions: what they get, and that they light
//! nothing, keep no light on, and neither end nor take the session of the client that commands.
use client::viewers::VIEWERS;
use client::{Call, Client, Options};
use protocol::command::*;
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::reason::{Reason, Refusal};
use protocol::record::{Lane, RequestWriter, replies};
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use virtual_board::{Config, Served, serve};
use zerocopy::FromBytes;

/// Longest wait for what must come on a machine that is busy otherwise.
const WAIT_MAX: Duration = Duration::from_secs(30);
const MS: u64 = 1_000_000;

fn served() -> Served {
    serve(TcpListener::bind("127.0.0.1:0").unwrap(), None, Config::default()).unwrap()
}

fn opened(served: &Served, read_only: bool) -> client::Result<Client> {
    let link = client::link::open(&format!("tcp:{}", served.address())).unwrap();
    Client::open(link, Options { read_only, ..Options::default() })
}

fn now(served: &Served) -> u64 {
    served.board().lock().unwrap_or_else(PoisonError::into_inner).now()
}

/// Whether channel 0 has light.
fn is_lit(served: &Served) -> bool {
    served.board().lock().unwrap().laser_view(0).light
}

/// Channel 0 is lit by the immediate lane.
fn light() -> Vec<Call> {
    let (core, channel) = (1.into(), 0.into());
    vec![
        Call::of(SetAxisMode { core, axis: 7.into(), mode: 1.into() }),
        Call::of(LaserPowerMode {
            core,
            mode: 0.into(),
            max: 100.0.into(),
            min: 0.0.into(),
            channel,
            ..Default::default()
        }),
        Call::of(LaserOutFrq { core, frequency: 10.0.into(), channel }),
        Call::of(LaserPrfCmd { core, power: 50.0.into(), channel }),
        Call::of(LaserOn { core, channel }),
    ]
}

/// A client's end on a socket, without the rules of the library.
struct Raw {
    stream: TcpStream,
    end: Endpoint<4>,
    began: Instant,
}

impl Raw {
    fn connect(served: &Served) -> Raw {
        let stream = TcpStream::connect(served.address()).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
        Raw { stream, end: Endpoint::new(Role::Client, Identity::OURS), began: Instant::now() }
    }

    fn open(served: &Served, read_only: bool) -> Raw {
        let mut raw = Raw::connect(served);
        match read_only {
            true => raw.end.open_read_only(0, 77),
            false => raw.end.open(0, 77),
        }
        raw.until(|raw| raw.end.state() == LinkState::Open);
        raw
    }

    fn now(&self) -> u64 {
        self.began.elapsed().as_nanos() as u64
    }

    /// False once the other end is gone.
    fn pump(&mut self) -> bool {
        let (now, mut bytes) = (self.now(), [0; 8192]);
        let count = self.end.take_tx(now, &mut bytes);
        if self.stream.write_all(&bytes[..count]).is_err() {
            return false;
        }
        match self.stream.read(&mut bytes) {
            Ok(0) => false,
            Ok(count) => {
                let now = self.now();
                self.end.feed(now, &bytes[..count]);
                true
            }
            Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
        }
    }

    fn until(&mut self, mut is: impl FnMut(&Raw) -> bool) {
        let began = Instant::now();
        while !is(self) {
            let lives = self.pump();
            assert!((lives || is(self)) && began.elapsed() < WAIT_MAX, "{:?}", self.end.state());
        }
    }

    /// Sends a record; its code and reason.
    fn ask(&mut self, call: &Call, lane: Lane) -> (i16, u16) {
        let mut message = [0; protocol::MAX_PAYLOAD];
        let mut writer = RequestWriter::new(&mut message);
        writer.push_raw(call.opcode, lane, 1, &[&call.payload]).unwrap();
        let length = writer.len();
        self.end.send(&message[..length]).unwrap();
        self.until(|raw| raw.end.message().is_some());
        let message = self.end.message().unwrap().to_vec();
        self.end.done_with_message();
        let reply = replies(&message).next().unwrap().unwrap();
        (reply.code, Refusal::read_from_bytes(reply.body).map_or(0, |refusal| refusal.reason.get()))
    }
}

#[test]
fn a_viewer_reads_what_the_client_that_commands_does() {
    let served = served();
    // Before anybody commands, and beside it.
    let viewer = opened(&served, true).unwrap();
    assert_eq!(viewer.board(), "virtual");
    let commanding = opened(&served, false).unwrap();
    commanding.call_all(&light()).unwrap().into_iter().for_each(|reply| drop(reply.unwrap()));
    commanding.call(SetPrfPos { core: 1.into(), profile: 2.into(), pos: 1234.into() }).unwrap();
    let state = viewer.call(LaserStatus { core: 1.into(), channel: 0.into() }).unwrap();
    assert_eq!((state.light, state.power.get(), state.frequency.get()), (1, 50.0, 10.0));
    let (_, axes) = viewer.call_items(AxisStatus { core: 1.into(), axis: 1.into(), count: 2.into() }, &[]).unwrap();
    assert_eq!(axes.iter().map(|axis| axis.prf_pos.get()).collect::<Vec<_>>(), [0.0, 1234.0]);
    assert_eq!(viewer.call(ProgramStatus {}).unwrap().state, 0);
    // What a read refuses it refuses a viewer too.
    let wrong = viewer.call(LaserStatus { core: 1.into(), channel: 9.into() }).unwrap_err();
    assert_eq!(wrong.code, 7, "{wrong}");
    assert_eq!(viewer.job(), None);
    // A client that only reads does not even send what is no read.
    let refused = viewer.call(LaserOn { core: 1.into(), channel: 0.into() }).unwrap_err();
    assert_eq!(refused.refusal.unwrap().reason.get(), Reason::ReadOnly as u16);
    drop(viewer);
    assert!(is_lit(&served), "a viewer that leaves shuts nothing off");
    commanding.call(GetClock {}).unwrap();
}

#[test]
fn a_viewer_lights_moves_and_changes_nothing() {
    let served = served();
    served.board().lock().unwrap().record_beam(true);
    let commanding = opened(&served, false).unwrap();
    // All but the last, which would light it.
    let mut setup = light();
    setup.pop();
    commanding.call_all(&setup).unwrap().into_iter().for_each(|reply| drop(reply.unwrap()));
    served.board().lock().unwrap().take_beam();
    let mut viewer = Raw::open(&served, true);
    let zeros = COMMANDS.iter().map(|command| Call {
        opcode: command.opcode,
        payload: vec![0; widths(command.fields)],
        may_fail: false,
    });
    let core = 1.into();
    let meant = light().into_iter().chain([
        Call::of(AxisOn { core, axis: 1.into() }),
        Call::of(SetLinkLoss { time_ms: 0.into(), stop_all: 0.into() }),
        Call::of(Abort { core }),
        Call::of(Choose { profile: 1, family: 1 }),
        Call::of(ProgramStart { strict: 0 }),
        Call::of(SetHSIOOpt { core, value: 1.into(), channel: 0.into() }),
        Call::of(Trace { every: 1.into(), axes: 1.into(), over_link: 1, ..Trace::default() }),
    ]);
    let calls: Vec<Call> = zeros.chain(meant).collect();
    for call in &calls {
        for lane in [Lane::Immediate, Lane::Program, Lane::ProgramMayFail] {
            let reads = (call.is_read() || call.opcode == ProgramStatus::OPCODE) && lane == Lane::Immediate;
            let (code, reason) = viewer.ask(call, lane);
            let refused = (code, reason) == (1, Reason::ReadOnly as u16);
            assert_eq!(refused, !reads, "{:#06x} in {lane:?}: {code}, {reason}", call.opcode);
        }
    }
    assert!(served.board().lock().unwrap().take_beam().is_empty(), "light");
    assert_eq!(served.board().lock().unwrap().outputs().enable, 0);
    assert_eq!(commanding.call(ProgramStatus {}).unwrap().accepted.get(), 0);
    assert_eq!(commanding.call(GetLinkLoss {}).unwrap().time_ms.get(), 500.0);
    assert_eq!(commanding.call(Version {}).unwrap(), *commanding.version());
}

#[test]
fn viewers_are_no_life_of_a_client_that_has_gone_silent() {
    let served = served();
    let mut commanding = Raw::open(&served, false);
    let time_ms = 200;
    let loss = Call::of(SetLinkLoss { time_ms: time_ms.into(), stop_all: 0.into() });
    for call in light().iter().chain([&loss]) {
        assert_eq!(commanding.ask(call, Lane::Immediate).0, 0);
    }
    let mut viewers: Vec<Raw> = (0..3).map(|_| Raw::open(&served, true)).collect();
    let on = Call::of(LaserOn { core: 1.into(), channel: 0.into() });
    commanding.ask(&Call::of(GetClock {}), Lane::Immediate);
    assert!(is_lit(&served));
    let silent_since = now(&served);
    let (began, mut dark_at) = (Instant::now(), None);
    while dark_at.is_none() && began.elapsed() < WAIT_MAX {
        // One reads, one asks for light, one only says that it lives.
        let [one, two, three] = &mut viewers[..] else { panic!() };
        one.ask(&Call::of(GetClock {}), Lane::Immediate);
        two.ask(&on, Lane::Immediate);
        three.end.keep_alive();
        three.pump();
        let at = now(&served);
        dark_at = (!is_lit(&served)).then_some(at);
    }
    let dark_at = dark_at.expect("it went dark");
    // A turn of the server catches 20 ms up at most, and one such may lie between two looks.
    let took = dark_at - silent_since;
    assert!(took <= (time_ms as u64 + 60) * MS, "dark after {} ms", took / MS);
    // The viewers look on, and do not bring the link back.
    assert_eq!(viewers[0].ask(&Call::of(GetClock {}), Lane::Immediate).0, 0);
    assert!(!is_lit(&served));
}

#[test]
fn viewers_that_flood_and_break_off_end_nobodys_session() {
    let served = served();
    let commanding = opened(&served, false).unwrap();
    commanding.call_all(&light()).unwrap().into_iter().for_each(|reply| drop(reply.unwrap()));
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for number in 0..VIEWERS {
            let (served, stop) = (&served, &stop);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let mut viewer = Raw::connect(served);
                    viewer.end.open_read_only(0, 77);
                    // Until the flood of the one before is read there may be enough.
                    while viewer.end.state() == LinkState::Opening && viewer.pump() {}
                    if viewer.end.state() != LinkState::Open {
                        continue;
                    }
                    let mut message = [0; protocol::MAX_PAYLOAD];
                    let mut writer = RequestWriter::new(&mut message);
                    while writer.push(Lane::Immediate, 1, &GetClock {}, &[]).is_ok() {}
                    let length = writer.len();
                    let began = Instant::now();
                    while began.elapsed() < Duration::from_millis(40) {
                        match number % 3 {
                            // Whole messages of reads, answers unread.
                            0 => {
                                viewer.end.send(&message[..length]).ok();
                                let (now, mut bytes) = (viewer.now(), [0; 8192]);
                                let count = viewer.end.take_tx(now, &mut bytes);
                                let _ = viewer.stream.write_all(&bytes[..count]);
                            }
                            // Reads, answers read.
                            1 => {
                                viewer.end.send(&message[..length]).ok();
                                viewer.pump();
                                while viewer.end.message().is_some() {
                                    viewer.end.done_with_message();
                                }
                            }
                            // What is no frame at all.
                            _ => drop(viewer.stream.write(&[0x5a; 4096])),
                        }
                    }
                    // It breaks off in the middle of a frame.
                    viewer.end.send(&message[..length]).ok();
                    let (now, mut bytes) = (viewer.now(), [0; 8192]);
                    let count = viewer.end.take_tx(now, &mut bytes);
                    let _ = viewer.stream.write(&bytes[..count / 2]);
                }
            });
        }
        let began = Instant::now();
        let mut calls = 0;
        while began.elapsed() < Duration::from_millis(800) {
            let state =
                commanding.call(LaserStatus { core: 1.into(), channel: 0.into() }).expect("the session goes on");
            assert_eq!(state.light, 1);
            calls += 1;
        }
        stop.store(true, Ordering::Relaxed);
        println!("{calls} calls beside {VIEWERS} viewers that flood");
        assert!(calls > 10, "{calls} calls");
    });
    let (_, events) = commanding.call_items(GetEvents {}, &[]).unwrap();
    assert!(events.iter().all(|event| event.kind != 4), "the link was never lost: {events:?}");
}

#[test]
fn a_viewer_does_not_get_the_session_that_commands() {
    let served = served();
    let commanding = Raw::open(&served, false);
    // It asks for it on its own connection, also once nobody is there.
    let mut viewer = Raw::open(&served, true);
    drop(commanding);
    std::thread::sleep(Duration::from_millis(20));
    let now = viewer.now();
    viewer.end.open(now, 78);
    viewer.until(|viewer| matches!(viewer.end.state(), LinkState::Busy(_)));
    let now = viewer.now();
    viewer.end.open_read_only(now, 79);
    viewer.until(|viewer| viewer.end.state() == LinkState::Open);
    // Another connection does get it.
    opened(&served, false).unwrap().call(GetClock {}).unwrap();
}

/// All ask before anybody has confirmed a session: that is decided where a session is offered.
#[test]
fn one_more_that_comes_at_once_is_told_why() {
    let served = served();
    let mut viewers: Vec<Raw> = (0..=VIEWERS).map(|_| Raw::connect(&served)).collect();
    {
        // The controller takes no turn until all have asked.
        let _held = served.board().lock().unwrap_or_else(PoisonError::into_inner);
        for (viewer, nonce) in viewers.iter_mut().zip(70..) {
            let now = viewer.now();
            viewer.end.open_read_only(now, nonce);
            assert!(viewer.pump());
        }
    }
    let began = Instant::now();
    while viewers.iter().any(|viewer| viewer.end.state() == LinkState::Opening) {
        for (number, viewer) in viewers.iter_mut().enumerate() {
            assert!(viewer.pump(), "connection {number} was closed in {:?}", viewer.end.state());
        }
        assert!(began.elapsed() < WAIT_MAX);
    }
    let open = viewers.iter().filter(|viewer| viewer.end.state() == LinkState::Open).count();
    let told = viewers.iter().filter(|viewer| match viewer.end.state() {
        LinkState::Busy(busy) => busy.holder() == b"enough viewers are here",
        _ => false,
    });
    assert_eq!((open, told.count()), (VIEWERS, 1));
    // A session that is offered and never taken up is free again after a while.
    drop(viewers);
    let mut asked: Vec<Raw> = (0..VIEWERS).map(|_| Raw::connect(&served)).collect();
    for (viewer, nonce) in asked.iter_mut().zip(170..) {
        let now = viewer.now();
        viewer.end.open_read_only(now, nonce);
        assert!(viewer.pump());
    }
    let began = Instant::now();
    while let Err(error) = opened(&served, true) {
        assert!(began.elapsed() < WAIT_MAX, "{error}");
    }
}

#[test]
fn so_many_viewers_and_no_more() {
    let served = served();
    let mut viewers: Vec<Client> = (0..VIEWERS).map(|_| opened(&served, true).unwrap()).collect();
    let error = opened(&served, true).err().expect("there are enough");
    assert_eq!(error.code, client::error::CANNOT_OPEN);
    assert!(error.reason.contains("no read-only session: enough viewers are here"), "{error}");
    viewers.pop();
    let began = Instant::now();
    // The end of a connection is noticed in one of the next turns.
    while let Err(error) = opened(&served, true) {
        assert!(began.elapsed() < WAIT_MAX, "{error}");
    }
    // Connections that ask for nothing take nobody's place for long, and no session.
    let idle: Vec<TcpStream> = (0..100).map(|_| TcpStream::connect(served.address()).unwrap()).collect();
    opened(&served, false).unwrap().call(GetClock {}).unwrap();
    viewers[0].call(GetClock {}).unwrap();
    drop(idle);
}

#[test]
fn a_controller_that_gives_none_is_named() {
    // A controller's own wire, as that of a board.
    let board = virtual_board::share(virtual_board::Board::new(Config::default()));
    let link = Box::new(virtual_board::VirtualLink::new(board));
    let error = Client::open(link, Options { read_only: true, ..Options::default() }).err().expect("it gives none");
    assert_eq!(error.code, client::error::CANNOT_OPEN);
    assert!(error.reason.contains("gives no read-only sessions") && error.reason.contains("--share"), "{error}");
}
