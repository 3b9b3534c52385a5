//! The rig: a virtual controller and a client of frames. In: a program. Out: what was answered and
//! what the outputs did.
use super::program::{Act, Device, Do, Program};
use host_tests::light_judge::{Ns, Recorded};
use plant::beam::SignalChange;
use protocol::command::*;
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::record::{Full, Lane, RequestWriter, replies};
use servo::path::PathStop;
use virtual_board::{Board, Config, Edge};

#[path = "machine/calls.rs"]
mod calls;

use calls::power_mode;

/// The axis beside the paths.
const JOG: i16 = 5;

/// A call that was sent.
#[derive(Debug, Clone, Copy)]
pub struct Sent {
    /// When it was sent; it acts a tick later.
    pub at: Ns,
    pub call: Do,
    /// What was answered, if anything was.
    pub code: Option<i16>,
}

/// What a tick showed, where it differs from the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    pub at: Ns,
    pub runs: [bool; 2],
    pub rest: [PathStop; 2],
    pub fifo: [u8; 2],
    pub status: [u32; 4],
    /// The axis beside the paths moves.
    pub jog: bool,
}

/// What a program did. Instants are ns of controller time.
#[derive(Debug, Default)]
pub struct Reported {
    pub begin: Ns,
    pub end: Ns,
    pub sent: Vec<Sent>,
    pub acts: Vec<(Ns, Act)>,
    pub seen: Vec<Seen>,
    pub edges: Vec<Edge>,
    /// When the link was lost.
    pub losses: Vec<Ns>,
    pub lasers: [Recorded; 2],
}

impl Reported {
    /// What showed at an instant.
    pub fn view(&self, at: Ns) -> Seen {
        let after = self.seen.partition_point(|seen| seen.at <= at);
        self.seen[after.max(1) - 1]
    }
}

/// See the module text.
pub struct Rig {
    board: Board,
    pub tick: Ns,
    is_gus: bool,
    end: Box<Endpoint<8>>,
    nonce: u32,
    tag: u16,
    /// Answers by tag: the calls of the present program begin at `first`.
    waiting: Vec<(u16, usize)>,
    codes: Vec<Option<i16>>,
    fed: u64,
    wire: Vec<u8>,
    /// Level that the next mark of each FIFO makes.
    marks: [bool; 4],
    /// A clear that each FIFO waits for, with the number of its call.
    clears: [Option<usize>; 4],
}

fn full<T>(made: Result<T, Full>) {
    assert!(made.is_ok(), "a message has room");
}

impl Rig {
    pub fn new(is_gus: bool, tick_us: u32) -> Rig {
        let mut rig = Rig {
            board: Board::new(Config { tick_us, ..Config::default() }),
            tick: Ns::from(tick_us) * 1000,
            is_gus,
            end: Box::new(Endpoint::new(Role::Client, Identity::OURS)),
            nonce: 0,
            tag: 0,
            waiting: Vec::new(),
            codes: Vec::new(),
            fed: 0,
            wire: Vec::new(),
            marks: [true; 4],
            clears: [None; 4],
        };
        rig.session();
        let family = u8::from(!is_gus);
        rig.send(|writer, tag| full(writer.push(Lane::Immediate, tag, &Choose { profile: 0, family }, &[])));
        rig.wait("choose");
        rig.board.record_beam(true);
        rig
    }

    fn session(&mut self) {
        self.nonce += 1;
        self.waiting.clear();
        *self.end = Endpoint::new(Role::Client, Identity::OURS);
        self.end.open(self.board.now(), self.nonce);
        for _ in 0..8 {
            self.pump();
        }
        assert_eq!(self.end.state(), LinkState::Open);
    }

    /// Both ends exchange what they have.
    fn pump(&mut self) {
        let now = self.board.now();
        self.wire.clear();
        let mut part = [0; 2048];
        loop {
            let count = self.end.take_tx(now, &mut part);
            if count == 0 {
                break;
            }
            self.wire.extend_from_slice(&part[..count]);
        }
        if !self.wire.is_empty() {
            self.board.feed(&self.wire);
            self.fed = now;
        }
        self.wire.clear();
        self.board.take_tx(&mut self.wire);
        self.receive();
    }

    fn receive(&mut self) {
        if self.wire.is_empty() {
            return;
        }
        self.end.feed(self.board.now(), &self.wire);
        while let Some(message) = self.end.message() {
            for reply in replies(message).flatten() {
                if let Some(at) = self.waiting.iter().position(|(tag, _)| *tag == reply.tag) {
                    let (_, index) = self.waiting.swap_remove(at);
                    self.codes[index] = Some(reply.code);
                }
            }
            self.end.done_with_message();
        }
    }

    /// One call; its number.
    fn send(&mut self, write: impl Fn(&mut RequestWriter, u16)) -> usize {
        self.tag = self.tag.wrapping_add(1);
        let tag = self.tag;
        let index = self.codes.len();
        for _ in 0..2 {
            if let Some(draft) = self.end.draft() {
                let mut writer = RequestWriter::new(draft);
                write(&mut writer, tag);
                let length = writer.len();
                assert!(self.end.send_draft(length).is_ok());
                self.codes.push(None);
                self.waiting.push((tag, index));
                return index;
            }
            self.pump();
        }
        panic!("the window is full")
    }

    /// Ticks until everything is answered.
    fn wait(&mut self, what: &str) {
        for _ in 0..200 {
            self.pump();
            if self.waiting.is_empty() {
                return;
            }
            self.step();
        }
        panic!("{what}: no answer to {} calls", self.waiting.len());
    }

    fn step(&mut self) {
        self.wire.clear();
        self.board.advance(self.tick as u64, &mut self.wire);
        self.receive();
    }

    /// A call that must be done.
    fn must<R: Request>(&mut self, request: R) {
        self.send(|writer, tag| full(writer.push(Lane::Immediate, tag, &request, &[])));
    }

    /// Everything as at power-on, then the program's settings.
    fn set_up(&mut self, program: &Program) -> Result<(), String> {
        let core = 1.into();
        let inputs = self.board.inputs_mut();
        inputs.interlock = false;
        inputs.axes.iter_mut().for_each(|axis| *axis = Default::default());
        if self.end.state() != LinkState::Open {
            self.session();
        }
        self.session();
        self.codes.clear();
        self.step();
        self.must(Reset { core });
        self.wait("reset");
        if self.codes != [Some(0)] {
            return Err(format!("the reset was answered {:?}", self.codes));
        }
        self.codes.clear();
        for channel in 0..2 {
            let fault = self.board.laser_view(channel).fault;
            if fault != servo::laser::Cause::None {
                return Err(format!("after Reset channel {channel} has the fault {fault:?}"));
            }
        }
        self.must(SetDo { core, do_type: 12.into(), value: 0.into() });
        (self.marks, self.clears) = ([true; 4], [None; 4]);
        for axis in 1..=4i16 {
            self.must(AxisOn { core, axis: axis.into() });
        }
        self.must(AxisOn { core, axis: JOG.into() });
        self.must(PrfJog { core, profile: JOG.into() });
        let (acc, dec) = (5.0.into(), 0.5.into());
        self.must(SetJogPrm { core, profile: JOG.into(), acc, dec, smooth: 0.0.into() });
        for (channel, (of, device)) in program.settings.channels.iter().zip(&program.devices).enumerate() {
            self.device(channel, of, device);
        }
        self.wait("devices");
        for crd in 0..2 {
            self.crd(program, crd);
        }
        self.wait("coordinate systems");
        for call in &program.entries {
            self.call(call);
            if self.waiting.len() > 24 {
                self.pump();
            }
        }
        self.wait("entries");
        match self.codes.iter().position(|code| *code != Some(0)) {
            Some(at) => Err(format!("call {at} of the set-up was answered {:?}", self.codes[at])),
            None => Ok(()),
        }
    }

    fn device(&mut self, channel: usize, of: &host_tests::light_judge::Channel, device: &Device) {
        let core = 1.into();
        let number = (channel as i16).into();
        if self.is_gus && (of.connector && device.mode != 2) {
            self.must(SetAxisMode { core, axis: (7 + channel as i16).into(), mode: 1.into() });
        }
        if !self.is_gus {
            self.must(SetLaserMode { core, mode: 0.into() });
        }
        self.must(power_mode(channel, device.mode));
        self.must(LaserOutFrq { core, frequency: device.khz.into(), channel: number });
        self.must(SetPulseWidth { core, width_us: 25.into(), channel: number });
        let timing = of.timing;
        self.must(SetLevelDelay {
            core,
            off_delay_us: (timing.off as u32 / 1000).into(),
            on_delay_us: (timing.on as u32 / 1000).into(),
            channel: number,
        });
        if let Some(fpk) = timing.fpk {
            self.must(EnaFPK {
                core,
                time1_us: (fpk.time1 as u32 / 1000).into(),
                time2_us: (fpk.time2 as u32 / 1000).into(),
                laser_off_delay_us: (fpk.off as u32 / 1000).into(),
                channel: number,
            });
        }
        if device.waiting {
            let (frequency, duty) = (5.0.into(), 8.0.into());
            if self.is_gus {
                self.must(SetWaitPulse { core, mode: 1.into(), frequency, duty, channel: number });
            } else {
                self.must(SetWaitPulseEx { core, mode: 1.into(), frequency, duty });
            }
            self.must(SetPreVltg { core, mode: 1.into(), voltage: 1.5.into(), channel: number });
        }
        self.must(LaserPrfCmd { core, power: device.power.into(), channel: number });
        self.must(SetLaserCrdMap { core, channel: number, map: i16::from(of.map).into() });
    }

    fn crd(&mut self, program: &Program, crd: usize) {
        if program.settings.set_up >> crd & 1 == 0 {
            return;
        }
        let core = 1.into();
        let mut profile = [0.into(); 8];
        (profile[2 * crd], profile[2 * crd + 1]) = (1.into(), 2.into());
        let number = (crd as i16 + 1).into();
        self.must(SetCrdPrm {
            core,
            crd: number,
            dimension: 2.into(),
            profile,
            syn_vel_max: 1000.0.into(),
            syn_acc_max: 100.0.into(),
            even_time_ms: 0.into(),
            set_origin_flag: 1.into(),
            origin_pos: [0.into(); 8],
        });
        self.must(SetCrdStopDec { core, crd: number, smooth: program.braking.into(), abrupt: 1000.0.into() });
        for fifo in 0..2i16 {
            self.must(CrdClear { core, crd: number, fifo: fifo.into() });
        }
        if program.look_ahead >> crd & 1 == 1 {
            self.must(InitLookAhead {
                core,
                crd: number,
                fifo: 0.into(),
                time_ms: 5.0.into(),
                acc_max: 20.0.into(),
                count: 50.into(),
            });
        }
    }

    fn view(&mut self) -> Seen {
        let crds = [0, 1].map(|crd| {
            let view = self.board.crd(crd);
            (view.runs, view.path_stop, view.fifo)
        });
        Seen {
            at: self.board.now() as Ns,
            runs: crds.map(|crd| crd.0),
            rest: crds.map(|crd| crd.1),
            fifo: crds.map(|crd| crd.2),
            status: [0, 1, 2, 3].map(|axis| self.board.axis(axis).status),
            jog: self.board.axis(JOG as usize - 1).status >> 10 & 1 == 1,
        }
    }

    /// Runs a program.
    pub fn run(&mut self, program: &Program) -> Result<Reported, String> {
        self.set_up(program)?;
        self.board.take_beam();
        self.board.take_edges();
        let mut reported = Reported { begin: self.board.now() as Ns, ..Reported::default() };
        self.codes.clear();
        reported.seen.push(self.view());
        let (mut acts, mut silent, mut limit) = (program.acts.iter().peekable(), false, 500_000_000);
        let (mut lost, mut closed) = (false, false);
        for tick in 0..program.length {
            let now = self.board.now() as Ns;
            while let Some((_, act)) = acts.next_if(|(at, _)| *at <= tick) {
                reported.acts.push((now, *act));
                match *act {
                    // Nobody is there who would call.
                    Act::Call(_) if closed || silent => {}
                    Act::Call(call) => {
                        if let Do::LinkLoss { ms } = call {
                            limit = if ms == 0 { u64::MAX / 2 } else { u64::from(ms.unsigned_abs()) * 1_000_000 };
                        }
                        self.call(&call);
                        reported.sent.push(Sent { at: now, call, code: None });
                    }
                    Act::Alarm { axis, level } => self.board.inputs_mut().axes[axis].alarm = level,
                    Act::Limit { axis, positive: true, level } => {
                        self.board.inputs_mut().axes[axis].limit_positive = level;
                    }
                    Act::Limit { axis, level, .. } => self.board.inputs_mut().axes[axis].limit_negative = level,
                    Act::Interlock { after } => self.board.raise_interlock(now as u64 + after),
                    Act::InterlockGone => self.board.inputs_mut().interlock = false,
                    Act::Overrun => self.board.overrun(),
                    Act::Silence => {
                        self.pump();
                        silent = true;
                    }
                    Act::Speaks => (silent, lost) = (false, false),
                    Act::Session => {
                        self.session();
                        (silent, lost, closed, limit) = (false, false, false, 500_000_000);
                    }
                    Act::Close => {
                        self.pump();
                        self.end.close();
                        closed = true;
                    }
                }
            }
            if !silent {
                self.pump();
            }
            self.step();
            if !lost && self.board.now() > self.fed + limit {
                lost = true;
                reported.losses.push((self.fed + limit) as Ns);
            }
            let seen = self.view();
            let last = &reported.seen[reported.seen.len() - 1];
            if (Seen { at: last.at, ..seen }) != *last {
                reported.seen.push(seen);
            }
        }
        self.pump();
        for (sent, code) in reported.sent.iter_mut().zip(&self.codes) {
            sent.code = *code;
        }
        reported.end = self.board.now() as Ns;
        reported.edges = self.board.take_edges();
        for beam in self.board.take_beam() {
            record(&mut reported.lasers[usize::from(beam.channel)], beam.change);
        }
        Ok(reported)
    }
}

fn record(of: &mut Recorded, change: SignalChange) {
    match change {
        SignalChange::Switch { at, level } => of.switch.push((at as Ns, level)),
        SignalChange::Dac { at, code } => of.volts.push((at as Ns, code)),
        SignalChange::Energy { at, level: true } => of.pulses.push((at as Ns, Ns::MAX)),
        SignalChange::Energy { at, level: false } => match of.pulses.last_mut() {
            Some(open) if open.1 == Ns::MAX => open.1 = at as Ns,
            _ => {}
        },
        SignalChange::Pulses(burst) => {
            let pulses = burst.pulses().filter(|(begin, end)| begin < end);
            of.pulses.extend(pulses.map(|(begin, end)| (begin as Ns, end as Ns)));
        }
    }
}
