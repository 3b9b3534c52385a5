#![no_std]
#![no_main]
//! Counts the instructions of streaming, from bytes of the host to segments of PT in the ring, and
//! to entries of a path in its store, in QEMU with `-icount shift=6` or more.
//!
//! Out, by semihosting: one line a message, `LANE feed SEGMENTS COUNT` for `Server::feed` of a
//! whole frame and the `Server::poll` that takes it, and `LANE answer SEGMENTS COUNT` for the poll
//! after the next tick, which answers it. COUNT is in periods of the 25 MHz SysTick (40 ns; `xtask`
//! turns them into instructions, of which each takes 2^shift ns).
//!
//! The frames are made by the other end of the same link, in here, and are not counted.
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use dispatcher::{BoardConstants, Server, ThreadHalves};
use hal as _; // the vector table
use probes::clock;
use probes::machine::Sink;
use probes::{AXES, PATHS, QUEUES, STORES, TABLE_STORES};
use protocol::command::{
    CrdClear, InitLookAhead, LnXY, LnXYMany, PathXY, PrfPt, ProgramStart, PtDataMany, PtItem, Request, SetCrdPrm,
    SetPtMemory,
};
use protocol::link::{Endpoint, Identity, Role};
use protocol::record::{Lane, RequestWriter, replies};
use servo::tick::{Tick, TickHalves};
use servo::units::{AxisMask, Ns, StepLimit};
use zerocopy::IntoBytes;

/// Messages counted in each lane.
const MESSAGES: usize = 64;
/// Segments of a message: as many as fit.
const SEGMENTS: usize = 77;
/// The same of lines, in one record and in records of their own.
const LINES: usize = 122;
const SINGLE: usize = 22;

probes::exit_on_panic!();

/// Both ends of a link, and the tick.
struct Bench {
    machine: Sink<AXES>,
    server: Server<'static, AXES>,
    tick: Tick<AXES>,
    lanes: TickHalves<'static, AXES>,
    client: Endpoint<8>,
    tag: u16,
    answered: u16,
    /// Periods that reading the counter twice takes by itself.
    reading: u32,
}

/// Not inlined: the same code as in the image's link task.
#[inline(never)]
fn take(server: &mut Server<'static, AXES>, now: Ns, bytes: &[u8]) {
    server.feed(now, bytes);
    server.poll(now);
}

#[inline(never)]
fn nothing(_: &mut Server<'static, AXES>, _: Ns, _: &[u8]) {}

impl Bench {
    fn now(&self) -> Ns {
        self.tick.now()
    }

    /// Counter periods of a call.
    fn count(&mut self, call: fn(&mut Server<'static, AXES>, Ns, &[u8]), bytes: &[u8]) -> u32 {
        let (call, now) = (black_box(call), self.now());
        let before = clock::read();
        call(&mut self.server, now, bytes);
        before.passed()
    }

    /// One tick and the reply to the client; nothing is sent. Returns the count of the poll.
    fn step(&mut self) -> u32 {
        self.tick.run(&mut self.machine, &mut self.lanes);
        let taken = self.count(take, &[]).saturating_sub(self.reading);
        let now = self.now();
        let mut bytes = [0; 2048];
        loop {
            let down = self.server.take_tx(&mut bytes);
            if down == 0 {
                break;
            }
            self.client.feed(now.0, bytes.get(..down).unwrap_or(&[]));
        }
        while let Some(message) = self.client.message() {
            for reply in replies(message) {
                let reply = reply.expect("a reply is a record");
                assert!(reply.code == 0, "command {} refused", reply.opcode);
                self.answered += 1;
            }
            self.client.done_with_message();
        }
        taken
    }

    /// Bytes of the client to the controller; returns what they take.
    fn exchange(&mut self) -> u32 {
        let mut bytes = [0; 2048];
        let up = self.client.take_tx(self.now().0, &mut bytes);
        self.count(take, bytes.get(..up).unwrap_or(&[])).saturating_sub(self.reading)
    }

    /// Sends one request as a message; returns what taking it takes.
    fn post<R: Request>(&mut self, lane: Lane, request: R, items: &[R::Item]) -> u32 {
        let mut buffer = [0; protocol::MAX_PAYLOAD];
        let mut writer = RequestWriter::new(&mut buffer);
        self.tag += 1;
        let written = writer.push_raw(R::OPCODE, lane, self.tag, &[request.as_bytes(), items.as_bytes()]);
        assert!(written.is_ok(), "a message holds it");
        let len = writer.len();
        assert!(self.client.send(buffer.get(..len).unwrap_or(&[])).is_ok(), "the window is open");
        self.exchange()
    }

    /// Sends one request and runs until it is answered.
    fn done<R: Request>(&mut self, request: R) {
        self.post(Lane::Immediate, request, &[]);
        while self.answered < self.tag {
            self.step();
            self.exchange();
        }
    }

    /// Sends a message of records; returns what taking it takes.
    fn post_lines(&mut self, lines: &[LnXY]) -> u32 {
        let mut buffer = [0; protocol::MAX_PAYLOAD];
        let mut writer = RequestWriter::new(&mut buffer);
        for line in lines {
            self.tag += 1;
            let written = writer.push_raw(LnXY::OPCODE, Lane::Immediate, self.tag, &[line.as_bytes()]);
            assert!(written.is_ok(), "a message holds them");
        }
        let len = writer.len();
        assert!(self.client.send(buffer.get(..len).unwrap_or(&[])).is_ok(), "the window is open");
        self.exchange()
    }

    /// Lines of coordinate system 1: by single calls, many to a record, and these through the
    /// look-ahead.
    fn lines(&mut self) {
        let mut profile = [0.into(); 8];
        (profile[0], profile[1]) = (1.into(), 2.into());
        let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
        self.done(SetCrdPrm {
            core,
            crd,
            dimension: 2.into(),
            profile,
            syn_vel_max: 500.0.into(),
            syn_acc_max: 10.0.into(),
            ..SetCrdPrm::default()
        });
        let (syn_vel, syn_acc, vel_end) = (80.0.into(), 2.5.into(), 40.0.into());
        // A path that turns a little with each line, as a planner makes it.
        let place = |k: u32| ((k * 91).cast_signed(), (k * k % 1013).cast_signed());
        for name in ["lnxy", "lines", "ahead"] {
            if name == "ahead" {
                // A look-ahead takes over an empty FIFO.
                self.done(CrdClear { core, crd, fifo });
                let (time_ms, acc_max) = (5.0.into(), 2.0.into());
                self.done(InitLookAhead { core, crd, fifo, time_ms, acc_max, count: 256.into() });
            }
            for message in 0..MESSAGES as u32 {
                if message % 8 == 0 {
                    self.done(CrdClear { core, crd, fifo });
                }
                let first = message % 8 * LINES as u32;
                let line = |k: usize| {
                    let (x, y) = place(first + k as u32 + 1);
                    LnXY { core, crd, x: x.into(), y: y.into(), syn_vel, syn_acc, vel_end, fifo }
                };
                let (count, feed) = if name == "lnxy" {
                    let mut lines = [LnXY::default(); SINGLE];
                    lines.iter_mut().enumerate().for_each(|(k, place)| *place = line(k));
                    (SINGLE, self.post_lines(&lines))
                } else {
                    let mut items = [PathXY::default(); LINES];
                    for (k, item) in items.iter_mut().enumerate() {
                        let LnXY { x, y, .. } = line(k);
                        *item = PathXY { x, y };
                    }
                    let count = (LINES as u16).into();
                    let many = LnXYMany { core, crd, fifo, count, syn_vel, syn_acc, vel_end };
                    (LINES, self.post(Lane::Immediate, many, &items))
                };
                let answer = self.step();
                hprintln!("{} feed {} {}", name, count, feed);
                hprintln!("{} answer {} {}", name, count, answer);
                while self.answered < self.tag {
                    self.step();
                    self.exchange();
                }
            }
        }
    }

    fn run(&mut self, name: &str, lane: Lane) {
        for axis in 1..=AXES as i16 {
            self.done(PrfPt { core: 1.into(), profile: axis.into(), mode: 1.into() });
            self.done(SetPtMemory { core: 1.into(), profile: axis.into(), memory: 1.into() });
        }
        if lane == Lane::Program {
            self.done(ProgramStart { strict: 0 });
        }
        for message in 0..MESSAGES {
            let (axis, part) = (message % AXES, message / AXES);
            let mut items = [PtItem::default(); SEGMENTS];
            for (index, item) in items.iter_mut().enumerate() {
                let k = (part * SEGMENTS + index + 1) as u32;
                // Places and times that differ, as a planner gives them: 1 to 4 ms.
                let pos = f64::from(k * (axis as u32 + 3)) * 1.37 + f64::from(k % 5) * 0.11;
                *item = PtItem { pos: pos.into(), time_ms: (k * 3 - k % 3).cast_signed().into(), kind: (k % 2) as u8 };
            }
            let many = PtDataMany {
                core: 1.into(),
                profile: (axis as i16 + 1).into(),
                fifo: 0.into(),
                count: (SEGMENTS as u16).into(),
            };
            let feed = self.post(lane, many, &items);
            let answer = self.step();
            hprintln!("{} feed {} {}", name, SEGMENTS, feed);
            hprintln!("{} answer {} {}", name, SEGMENTS, answer);
            self.exchange();
            assert!(self.answered == self.tag, "message {message} is not answered");
        }
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let (tick, lanes, thread) = probes::bench().expect("once");
    let board = BoardConstants {
        name: "probe",
        profile: dispatcher::largest_that_fits(AXES),
        tick_us: 10..=1000,
        analog_outputs: 8,
        analog_inputs: 8,
        planned_inputs: 0,
        general_inputs: 16,
        general_outputs: 16,
        step_limit: StepLimit::FULL_SCALE,
        indexes: AxisMask(0),
        wired: &servo::port::WiredInputs::ALL,
        fault: None,
        contradiction: || None,
        tick_time: None,
        stack: None,
    };
    let channels = ThreadHalves {
        immediate: thread.immediate,
        program: thread.program,
        view: thread.view,
        events: thread.events,
        samples: thread.samples,
        stores: &STORES,
        paths: PATHS,
        queues: QUEUES.take(),
        tables: TABLE_STORES,
    };
    let mut bench = Bench {
        machine: Sink::POWER_ON,
        server: Server::new(board, channels),
        tick,
        lanes,
        client: Endpoint::new(Role::Client, Identity::OURS),
        tag: 0,
        answered: 0,
        reading: 0,
    };
    bench.reading = bench.count(nothing, &[]);
    bench.client.open(0, 1);
    while bench.client.session().is_none() {
        bench.step();
        bench.exchange();
    }
    bench.lines();
    bench.run("immediate", Lane::Immediate);
    bench.run("program", Lane::Program);
    probes::exit()
}
