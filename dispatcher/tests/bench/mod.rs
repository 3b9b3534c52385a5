//! A whole controller on a bench: server and tick in one process, a client's end of the link, and a
//! machine whose encoders follow at once.
pub mod crd;
pub mod follow;

use dispatcher::{BoardConstants, Fault, PathQueue, Server, ThreadHalves};
use protocol::command::*;
use protocol::link::{Endpoint, Identity, Role};
use protocol::reason::{Reason, Refusal};
use protocol::record::{Lane, RequestWriter, TRACE_RECORD, replies};
use ring::{Latest, Ring};
use servo::laser::{Clock, LaserPlan};
use servo::output::step_generator;
use servo::path::{EntryStore, PathStores};
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port, WiredInputs};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tables::TableStores;
use servo::tick::{SegmentStore, Tick, TickConfig, TickHalves};
use servo::units::{Axis, AxisMask, Crd, Ns, Pos, StepLimit};
use servo::view::View;
use std::collections::HashMap;
use zerocopy::{FromBytes, IntoBytes};

pub const MS: u64 = 1_000_000;

/// The machine: the encoder is the whole pulse of the last set-point.
pub struct Machine<const AXES: usize> {
    pub inputs: [AxisInputs; AXES],
    pub set_points: [Pos; AXES],
    pub outputs: (u64, u64, GeneralOutputs),
    pub analog_out: [i16; 8],
    pub interlock: bool,
}

impl<const AXES: usize> Port for Machine<AXES> {
    fn inputs(&mut self, axis: Axis) -> AxisInputs {
        self.inputs[axis.index()]
    }
    fn encoder(&mut self, axis: Axis) -> i64 {
        step_generator::whole(self.set_points[axis.index()])
    }
    fn general_inputs(&mut self) -> GeneralInputs {
        0x5a
    }
    fn analog(&mut self, channel: usize) -> i16 {
        // Volts, in 12.5 V / 32768.
        2621 * channel as i16
    }
    fn set_point(&mut self, axis: Axis, pos: Pos) {
        self.set_points[axis.index()] = pos;
    }
    fn outputs(&mut self, _: u32, enable: u64, clear: u64, general: GeneralOutputs) {
        self.outputs = (enable, clear, general);
    }
    fn analog_out(&mut self, _: u32, channel: usize, value: i16) {
        self.analog_out[channel] = value;
    }
    fn interlock(&mut self) -> bool {
        self.interlock
    }
    fn laser(&mut self, _: usize, _: &LaserPlan) {}
}

/// One answer: code and body.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    pub opcode: u16,
    pub code: i16,
    pub body: Vec<u8>,
}

impl Answer {
    /// The refusal of a code other than 0.
    pub fn refusal(&self) -> Refusal {
        assert_ne!(self.code, 0, "command {:#x} was not refused", self.opcode);
        Refusal::read_from_bytes(&self.body).unwrap()
    }
    pub fn reason(&self) -> Reason {
        Reason::from_number(self.refusal().reason.get()).unwrap()
    }
    pub fn reply<R: Request>(&self) -> R::Reply {
        assert_eq!(self.code, 0, "{} refused: {:?}", R::NAME, self.code_text());
        R::Reply::read_from_prefix(&self.body).unwrap().0
    }
    pub fn items<R: Request>(&self) -> Vec<R::ReplyItem> {
        let rest = &self.body[size_of::<R::Reply>()..];
        rest.chunks(size_of::<R::ReplyItem>()).map(|part| R::ReplyItem::read_from_bytes(part).unwrap()).collect()
    }
    fn code_text(&self) -> String {
        let refusal = Refusal::read_from_bytes(&self.body).unwrap();
        format!("{:?} {refusal:?}", Reason::from_number(refusal.reason.get()))
    }
}

fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

pub struct Bench<const AXES: usize> {
    pub server: Server<'static, AXES>,
    pub tick: Tick<AXES>,
    pub lanes: TickHalves<'static, AXES>,
    pub machine: Machine<AXES>,
    pub client: Endpoint<8>,
    /// The wire is cut: no byte passes.
    pub cut: bool,
    /// Ticks between two polls of the server.
    pub poll_every: u32,
    ticks: u32,
    tag: u16,
    pub answers: HashMap<u16, Answer>,
    /// Tags in the order of their answers.
    pub order: Vec<u16>,
    pub trace: Vec<u8>,
    /// Trace that came over the link.
    pub link_trace: Vec<u8>,
}

impl Bench<8> {
    pub fn gus() -> Bench<8> {
        Bench::new(0, 250)
    }
}

impl<const AXES: usize> Bench<AXES> {
    pub fn new(profile: u8, tick_us: u32) -> Self {
        Bench::on(StepLimit::FULL_SCALE, None, profile, tick_us)
    }

    /// A controller whose last run ended with this fault.
    pub fn after(fault: Option<Fault>, profile: u8, tick_us: u32) -> Self {
        Bench::on(StepLimit::FULL_SCALE, fault, profile, tick_us)
    }

    /// On a board whose step outputs are limited.
    pub fn on(step_limit: StepLimit, fault: Option<Fault>, profile: u8, tick_us: u32) -> Self {
        let (immediate, immediate_out) = leak(Ring::new()).split();
        let (program, program_out) = leak(Ring::new()).split();
        let (events_in, events) = leak(Ring::new()).split();
        let (samples_in, samples) = leak(Ring::new()).split();
        let (view_in, view) = leak(Latest::new(View::POWER_ON)).split();
        let stores: Box<[SegmentStore]> = (0..AXES).map(|_| SegmentStore::new()).collect();
        let stores: Box<[SegmentStore; AXES]> = stores.try_into().ok().unwrap();
        let stores: &'static [SegmentStore; AXES] = Box::leak(stores);
        let queues: Vec<[PathQueue; 2]> = (0..Crd::MAX).map(|_| Default::default()).collect();
        let queues: &'static mut [[PathQueue; 2]] = queues.leak();
        let paths = PathStores::of::<{ Crd::MAX }>(leak([const { [const { EntryStore::new() }; 2] }; Crd::MAX]));
        let places: Box<[PointStore]> = (0..TABLES).map(|_| PointStore::new()).collect();
        let places: Box<[PointStore; TABLES]> = places.try_into().ok().unwrap();
        let tables = TableStores {
            points: Box::leak(places),
            headers: leak(HeaderStore::new()),
            lasers: leak(servo::laser::PowerTables::new()),
            edges: leak(servo::EdgeCounts::new()),
        };
        let board = BoardConstants {
            name: "bench",
            profile,
            tick_us: 10..=1000,
            analog_outputs: 8,
            analog_inputs: 8,
            planned_inputs: 0,
            general_inputs: 100,
            general_outputs: if profile == 0 { 16 } else { 64 },
            indexes: AxisMask(0b1),
            step_limit,
            // The last axis of the smallest profile has none.
            wired: &WiredInputs {
                limit_positive: AxisMask(!(1 << 7)),
                limit_negative: AxisMask(!(1 << 7)),
                alarm: AxisMask(!(1 << 7)),
                home: AxisMask(!(1 << 7)),
                arrive: AxisMask(!(1 << 7)),
            },
            fault,
            contradiction: || None,
            tick_time: None,
            stack: None,
        };
        let mut bench = Bench {
            server: Server::new(
                board,
                ThreadHalves { immediate, program, view, events, samples, stores, paths, queues, tables },
            ),
            tick: Tick::new(TickConfig {
                period_ns: tick_us * 1000,
                axes: AXES as u8,
                analog_inputs: 8,
                laser_clock: Clock::GHZ,
                step_limit,
            }),
            lanes: TickHalves {
                immediate: immediate_out,
                program: program_out,
                view: view_in,
                events: events_in,
                samples: samples_in,
                segments: stores,
                tables,
                paths,
            },
            machine: Machine {
                inputs: [AxisInputs::default(); AXES],
                set_points: [Pos(0); AXES],
                outputs: (0, 0, 0),
                analog_out: [0; 8],
                interlock: false,
            },
            client: Endpoint::new(Role::Client, Identity::OURS),
            cut: false,
            poll_every: 1,
            ticks: 0,
            tag: 0,
            answers: HashMap::new(),
            order: Vec::new(),
            trace: Vec::new(),
            link_trace: Vec::new(),
        };
        bench.open(1);
        bench
    }

    /// A new session.
    pub fn open(&mut self, nonce: u32) {
        self.client.open(self.now().0, nonce);
        self.step();
        for _ in 0..100 {
            if self.client.session().is_some() {
                return;
            }
            self.step();
        }
        panic!("no session");
    }

    pub fn now(&self) -> Ns {
        self.tick.now()
    }

    /// Exchanges bytes both ways, and polls the server.
    pub fn exchange(&mut self) {
        let now = self.now();
        let mut bytes = [0; 4096];
        loop {
            let up = self.client.take_tx(now.0, &mut bytes);
            if up > 0 && !self.cut {
                self.server.feed(now, &bytes[..up]);
            }
            self.server.poll(now);
            let down = self.server.take_tx(&mut bytes);
            if down > 0 && !self.cut {
                self.client.feed(now.0, &bytes[..down]);
            }
            while let Some(message) = self.client.message() {
                for reply in replies(message) {
                    let reply = reply.unwrap();
                    if reply.opcode == TRACE_RECORD {
                        assert_eq!((reply.tag, reply.code), (0, 0));
                        self.link_trace.extend_from_slice(reply.body);
                        continue;
                    }
                    let answer = Answer { opcode: reply.opcode, code: reply.code, body: reply.body.to_vec() };
                    assert!(self.answers.insert(reply.tag, answer).is_none(), "tag {} answered twice", reply.tag);
                    self.order.push(reply.tag);
                }
                self.client.done_with_message();
            }
            if up == 0 && down == 0 {
                break;
            }
        }
        loop {
            let count = self.server.take_trace(&mut bytes);
            self.trace.extend_from_slice(&bytes[..count]);
            if count == 0 {
                break;
            }
        }
    }

    /// The machine reports that the last tick took too long.
    pub fn overrun(&mut self) {
        self.tick.overrun();
    }

    /// One tick, and the thread if its turn has come.
    pub fn step(&mut self) {
        self.tick.run(&mut self.machine, &mut self.lanes);
        self.ticks += 1;
        if self.ticks.is_multiple_of(self.poll_every) {
            self.exchange();
        }
    }

    pub fn run_ms(&mut self, ms: u64) {
        let end = self.now().0 + ms * MS;
        while self.now().0 < end {
            self.step();
        }
    }

    pub fn next_tag(&mut self) -> u16 {
        self.tag = self.tag.wrapping_add(1);
        self.tag
    }

    /// Posts requests as one message, each as (opcode, lane, body); returns their tags.
    pub fn post_all(&mut self, requests: &[(u16, Lane, Vec<u8>)]) -> Vec<u16> {
        let mut buffer = [0; 1024];
        let mut writer = RequestWriter::new(&mut buffer);
        let mut tags = Vec::new();
        for (opcode, lane, body) in requests {
            let tag = self.next_tag();
            writer.push_raw(*opcode, *lane, tag, &[body]).unwrap();
            tags.push(tag);
        }
        let len = writer.len();
        for _ in 0..1000 {
            if self.client.can_send() {
                break;
            }
            self.step();
        }
        self.client.send(&buffer[..len]).unwrap();
        tags
    }

    pub fn post_raw(&mut self, opcode: u16, lane: Lane, body: &[u8]) -> u16 {
        self.post_all(&[(opcode, lane, body.to_vec())])[0]
    }

    pub fn post<R: Request>(&mut self, lane: Lane, request: R, items: &[R::Item]) -> u16 {
        self.post_raw(R::OPCODE, lane, &body::<R>(request, items))
    }

    /// Runs until this answer has come.
    pub fn wait(&mut self, tag: u16) -> Answer {
        for _ in 0..200_000 {
            if let Some(answer) = self.answers.get(&tag) {
                return answer.clone();
            }
            self.step();
        }
        panic!("no answer to tag {tag}");
    }

    /// An immediate call.
    pub fn call<R: Request>(&mut self, request: R) -> Answer {
        self.call_items(request, &[])
    }

    pub fn call_items<R: Request>(&mut self, request: R, items: &[R::Item]) -> Answer {
        let tag = self.post(Lane::Immediate, request, items);
        self.wait(tag)
    }

    /// An immediate call that must be done.
    pub fn done<R: Request>(&mut self, request: R) -> R::Reply {
        self.call(request).reply::<R>()
    }

    /// An immediate call that must be refused.
    pub fn refused<R: Request>(&mut self, request: R) -> (i16, Reason, Refusal) {
        let answer = self.call(request);
        (answer.code, answer.reason(), answer.refusal())
    }

    /// Planned position of an axis of core 1, as a client reads it.
    pub fn pos(&mut self, axis: i16) -> f64 {
        self.call(GetPrfPos { core: 1.into(), profile: axis.into(), count: 1.into() }).items::<GetPrfPos>()[0]
            .value
            .get()
    }

    pub fn status_word(&mut self, axis: i16) -> i32 {
        self.call(GetSts { core: 1.into(), axis: axis.into(), count: 1.into() }).items::<GetSts>()[0].value.get()
    }

    pub fn servo_on(&mut self, axis: i16) {
        self.done(AxisOn { core: 1.into(), axis: axis.into() });
    }
}

pub fn body<R: Request>(request: R, items: &[R::Item]) -> Vec<u8> {
    [request.as_bytes(), items.as_bytes()].concat()
}

/// A program entry for [`Bench::post_all`].
pub fn entry<R: Request>(request: R) -> (u16, Lane, Vec<u8>) {
    (R::OPCODE, Lane::Program, body::<R>(request, &[]))
}

pub fn pt_item(pos: f64, time_ms: i32, kind: u8) -> PtItem {
    PtItem { pos: pos.into(), time_ms: time_ms.into(), kind }
}

pub fn pt_data(axis: i16, pos: f64, time_ms: i32) -> PtData {
    PtData {
        core: 1.into(),
        profile: axis.into(),
        pos: pos.into(),
        time_ms: time_ms.into(),
        kind: 0.into(),
        fifo: 0.into(),
    }
}

const CORE: i16 = 1;

pub fn sleep(ms: u64) -> Sleep {
    Sleep { ns: (ms * MS).into() }
}

pub fn wait_stop(axes: i32) -> WaitStop {
    WaitStop { core: CORE.into(), axes: axes.into(), crds: 0.into() }
}

pub fn read_pos(axis: i16) -> GetPrfPos {
    GetPrfPos { core: CORE.into(), profile: axis.into(), count: 1.into() }
}

pub fn start(mask: i32) -> PtStart {
    PtStart { core: CORE.into(), mask: mask.into(), option: 0.into() }
}

pub fn position(answer: &Answer) -> f64 {
    answer.items::<GetPrfPos>()[0].value.get()
}

/// Listing 2-1 of the GXN manual as a program: acceleration, constant speed, deceleration; 4096
/// pulses in 3072 ms.
pub fn listing_2_1() -> Vec<(u16, Lane, Vec<u8>)> {
    let (core, axis) = (CORE.into(), 1.into());
    vec![
        entry(AxisOn { core, axis }),
        entry(ZeroPos { core, axis, count: 1.into() }),
        entry(PrfPt { core, profile: axis, mode: 0.into() }),
        entry(PtClear { core, profile: axis, fifo: 0.into() }),
        entry(PtSpace { core, profile: axis, fifo: 0.into() }),
        entry(pt_data(1, 1024.0, 1024)),
        entry(PtSpace { core, profile: axis, fifo: 0.into() }),
        entry(pt_data(1, 3072.0, 2048)),
        entry(pt_data(1, 4096.0, 3072)),
        entry(PtSpace { core, profile: axis, fifo: 0.into() }),
        entry(start(1)),
        entry(sleep(1536)),
        entry(GetPrfVel { core, profile: axis, count: 1.into() }),
        entry(wait_stop(1)),
        entry(read_pos(1)),
        entry(ProgramEnd {}),
    ]
}
