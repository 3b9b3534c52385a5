//! A controller, its client, and the line between them.
//!
//! In: requests, faults of the line, faults of the machine. Out: an account of every request:
//! answered once and in its lane's order, or of a session that ended. Owns the record of that, and
//! the [`Guard`] that looks at every tick.
use crate::guard::Guard;
use protocol::command::{AxisStatus, CommandInfo, ProgramClear, Request, info};
use protocol::frame::{MAX_PAYLOAD, MAX_WIRE};
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::reason::{Code, Reason, Refusal, describe_opcode};
use protocol::record::{Lane, RequestWriter, TRACE_RECORD, replies};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::collections::VecDeque;
use virtual_board::{Controller, Memory};
use zerocopy::FromBytes;

/// How bad the line is, in percent of the frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line {
    /// Frames lost, damaged, doubled, kept until after the next one: each so often.
    pub noise: u8,
    /// Of the chances.
    pub seed: u64,
}

impl Line {
    /// Everything arrives.
    pub const CLEAN: Line = Line { noise: 0, seed: 0 };
}

/// What the model knows by this request, if it does: lane, and number in it.
pub type Witness = Option<(usize, u32)>;

/// A request that was sent.
#[derive(Debug, Clone)]
pub struct Sent {
    /// Its number.
    pub opcode: u16,
    tag: u16,
    /// Refused, it may be answered before what stands before it in its program.
    may_fail: bool,
    /// See [`Witness`].
    pub witness: Witness,
}

/// What became of a request that the model knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// Answered with 0.
    Done,
    /// Reported as not executed.
    Refused,
    /// The session ended first.
    Unknown,
}

/// Time after which everything sent on a sound line is answered: several of the longest retries.
const PATIENCE_NS: u64 = 8_000_000_000;

/// See the module text.
pub struct Bench<'m> {
    /// The controller.
    pub board: Controller<'m>,
    /// What holds in every tick.
    pub guard: Guard,
    client: Endpoint<8>,
    line: Line,
    /// Nothing gets through.
    pub cut: bool,
    chance: SplitMix64,
    nonce: u32,
    tag: u16,
    /// Records that are not in a message yet, and whether one ends its message.
    outgoing: VecDeque<(Vec<u8>, bool)>,
    /// Requests without an answer: of the immediate lane, of the program lanes, and such as are no
    /// records.
    awaiting: [VecDeque<Sent>; 3],
    /// What became of the model's requests since it looked last.
    pub fates: Vec<(usize, u32, Fate)>,
    /// Frames that come after the next one, each way.
    late: [Option<Vec<u8>>; 2],
    wire: Vec<u8>,
    /// Answers so far, with code 0 and with another.
    pub answers: [u32; 2],
    /// Reason of the refusal that came last.
    pub refusal: Option<Refusal>,
    /// The answer with code 0 that came last.
    pub reply: Vec<u8>,
}

impl<'m> Bench<'m> {
    /// A controller at power-on; the client has not opened yet.
    pub fn new(memory: &'m mut Memory, line: Line) -> Bench<'m> {
        let mut board = Controller::on(memory);
        let guard = Guard::new(&mut board);
        Bench {
            board,
            guard,
            client: Endpoint::new(Role::Client, Identity::OURS),
            line,
            cut: false,
            chance: SplitMix64::seed_from_u64(line.seed),
            nonce: 0,
            tag: 0,
            outgoing: VecDeque::new(),
            awaiting: Default::default(),
            fates: Vec::new(),
            late: [None, None],
            wire: vec![0; 8 * MAX_WIRE],
            answers: [0; 2],
            refusal: None,
            reply: Vec::new(),
        }
    }

    /// Whether a frame meets with this.
    fn happens(&mut self) -> bool {
        self.chance.next_u64() % 100 < u64::from(self.line.noise)
    }

    /// The line is like this from now on.
    pub fn set_noise(&mut self, noise: u8) {
        self.line.noise = noise;
    }

    /// A new session; what the one before has not answered stays unknown.
    pub fn open(&mut self) {
        for sent in self.awaiting.iter_mut().flat_map(|queue| queue.drain(..)) {
            self.fates.extend(sent.witness.map(|(lane, number)| (lane, number, Fate::Unknown)));
            self.guard.answered(sent.opcode);
        }
        self.outgoing.clear();
        self.nonce = self.nonce.wrapping_add(1);
        self.client.open(self.board.now(), self.nonce);
    }

    /// Power goes off and on: another controller, on other memory, found after a fault if `fault`.
    pub fn power_cycle(&mut self, memory: &'m mut Memory, fault: bool) {
        self.board = Controller::on(memory);
        self.guard = Guard::new(&mut self.board);
        if fault {
            self.board.restarted();
            self.guard.cause(&self.awaiting);
        }
        self.late = [None, None];
        self.client = Endpoint::new(Role::Client, Identity::OURS);
        self.open();
    }

    /// A cause to be dark until it is cleared, which the guard holds the controller to.
    pub fn cause(&mut self, act: impl FnOnce(&mut Controller<'m>)) {
        act(&mut self.board);
        self.guard.cause(&self.awaiting);
    }

    /// Sends a request.
    pub fn send(&mut self, opcode: u16, lane: Lane, body: Vec<u8>, witness: Witness) {
        let mut record = vec![0; body.len() + 16];
        let mut writer = RequestWriter::new(&mut record);
        self.tag = self.tag.wrapping_add(1);
        if writer.push_raw(opcode, lane, self.tag, &[&body]).is_err() || writer.len() > MAX_PAYLOAD {
            return;
        }
        let length = writer.len();
        record.truncate(length);
        self.guard.sent(opcode, &body);
        self.outgoing.push_back((record, false));
        let (lane, may_fail) = (usize::from(lane != Lane::Immediate), lane == Lane::ProgramMayFail);
        self.awaiting[lane].push_back(Sent { opcode, tag: self.tag, may_fail, witness });
    }

    /// Sends what is no record: a lane that does not exist, or a body that is not there.
    pub fn send_broken(&mut self, opcode: u16, lane: u8, length: u16, body: &[u8]) {
        self.tag = self.tag.wrapping_add(1);
        let exists = lane <= 2 && usize::from(length) <= body.len();
        if exists || body.len() > 512 {
            return;
        }
        let mut record = Vec::new();
        record.extend_from_slice(&opcode.to_le_bytes());
        record.extend_from_slice(&self.tag.to_le_bytes());
        record.extend_from_slice(&length.to_le_bytes());
        record.push(lane);
        record.extend_from_slice(body);
        if usize::from(length) < body.len() {
            record.truncate(7 + usize::from(length));
        }
        self.outgoing.push_back((record, true));
        self.awaiting[2].push_back(Sent { opcode, tag: self.tag, may_fail: false, witness: None });
    }

    /// Requests without an answer.
    pub fn unanswered(&self) -> usize {
        self.awaiting.iter().map(VecDeque::len).sum()
    }

    /// Ticks, with everything that the line brings meanwhile.
    pub fn ticks(&mut self, count: u32) {
        for _ in 0..count {
            let mut down = Vec::new();
            self.board.advance(1, &mut down);
            self.exchange(down);
            self.guard.look(&mut self.board);
        }
    }

    /// Restores the line, drops what a program still holds, and lets everything be answered.
    pub fn settle(&mut self) {
        self.cut = false;
        self.set_noise(0);
        if matches!(self.client.state(), LinkState::Closed | LinkState::Ended) {
            self.open();
        }
        self.send(ProgramClear::OPCODE, Lane::Immediate, Vec::new(), None);
        let end = self.board.now() + PATIENCE_NS;
        let mut left = 60_000;
        while self.unanswered() > 0 {
            self.ticks(4);
            left -= 4;
            assert!(
                self.board.now() < end || left > 0,
                "{} requests are never answered, first of each lane {:?}, link {:?}",
                self.unanswered(),
                self.awaiting.each_ref().map(VecDeque::front),
                self.client.state()
            );
        }
        // What was answered can be read.
        let body = [1i16.to_le_bytes(), 1i16.to_le_bytes(), 8i16.to_le_bytes()].concat();
        self.send(AxisStatus::OPCODE, Lane::Immediate, body, None);
        while self.unanswered() > 0 {
            self.ticks(1);
            left -= 1;
            assert!(left > -4000, "a read is not answered");
        }
    }

    /// Everything that is due on the line; `down` is what the controller has sent in the tick.
    fn exchange(&mut self, mut down: Vec<u8>) {
        let now = self.board.now();
        while self.client.can_send() && !self.outgoing.is_empty() {
            let mut message = Vec::new();
            while let Some((record, ends)) = self.outgoing.front()
                && message.len() + record.len() <= MAX_PAYLOAD
            {
                let ends = *ends;
                message.extend_from_slice(record);
                self.outgoing.pop_front();
                if ends {
                    break;
                }
            }
            assert_eq!(self.client.send(&message), Ok(()));
        }
        if self.client.state() != LinkState::Closed {
            let mut wire = std::mem::take(&mut self.wire);
            loop {
                let count = self.client.take_tx(now, &mut wire);
                if count == 0 {
                    break;
                }
                for frame in wire[..count].split_inclusive(|&byte| byte == 0) {
                    for frame in self.line(0, frame) {
                        self.board.feed(&frame);
                        self.guard.fed(now);
                    }
                }
            }
            self.wire = wire;
        }
        self.board.take_tx(&mut down);
        for frame in down.split_inclusive(|&byte| byte == 0) {
            for frame in self.line(1, frame) {
                self.client.feed(now, &frame);
            }
            self.hear();
        }
        let mut trace = Vec::new();
        self.board.take_trace(&mut trace);
    }

    /// What becomes of a frame on the line.
    fn line(&mut self, way: usize, frame: &[u8]) -> Vec<Vec<u8>> {
        if self.cut {
            return Vec::new();
        }
        let mut out = Vec::new();
        let held = self.late[way].take();
        if self.line.noise == 0 {
            out.push(frame.to_vec());
        } else if !self.happens() {
            let mut frame = frame.to_vec();
            if self.happens() {
                // The state, not another number: what follows in a kept input stays as it was.
                let place = u64::from_le_bytes(self.chance.state());
                let at = place as usize % frame.len();
                frame[at] ^= 1 << (place >> 32 & 7);
            }
            if self.happens() {
                out.push(frame.clone());
            }
            if self.happens() {
                self.late[way] = Some(frame);
            } else {
                out.push(frame);
            }
        }
        out.extend(held);
        out
    }

    /// Takes the answers that have come.
    fn hear(&mut self) {
        while let Some(message) = self.client.message().map(<[u8]>::to_vec) {
            self.client.done_with_message();
            for reply in replies(&message) {
                let reply = reply.unwrap_or_else(|broken| panic!("a reply that is no record: {broken:?}"));
                if reply.opcode == TRACE_RECORD {
                    continue;
                }
                let of = |sent: &Sent| (sent.opcode, sent.tag) == (reply.opcode, reply.tag);
                // What does not fit into the program queue is reported at once, before what is in
                // it, and so is what may fail.
                let refusal = Refusal::read_from_bytes(reply.body).ok().filter(|_| reply.code != Code::Done as i16);
                let full = refusal.and_then(|refusal| refusal.reason()) == Some(Reason::QueueFull);
                let early = |sent: &Sent| of(sent) && (full || refusal.is_some() && sent.may_fail);
                let mut found = (0..2).find(|&lane| self.awaiting[lane].front().is_some_and(of)).map(|lane| (lane, 0));
                found = found.or_else(|| self.awaiting[1].iter().position(early).map(|at| (1, at)));
                found = found.or_else(|| self.awaiting[2].iter().position(of).map(|at| (2, at)));
                let sent = found.and_then(|(lane, at)| self.awaiting[lane].remove(at));
                let Some(sent) = sent else {
                    panic!(
                        "an answer to {:#06x} {} with code {} comes twice, out of order or to nothing: {:?}; due are {:?}",
                        reply.opcode,
                        reply.tag,
                        reply.code,
                        Refusal::read_from_bytes(reply.body).ok().and_then(|refusal| refusal.reason()),
                        self.awaiting.each_ref().map(|queue| queue.iter().take(12).collect::<Vec<_>>())
                    )
                };
                check(
                    found.is_some_and(|(lane, _)| lane == 2),
                    info(reply.opcode),
                    reply.opcode,
                    reply.code,
                    reply.body,
                );
                let done = reply.code == Code::Done as i16;
                self.answers[usize::from(!done)] += 1;
                self.guard.answered(sent.opcode);
                if done {
                    self.reply = reply.body.to_vec();
                } else {
                    self.refusal = Refusal::read_from_bytes(reply.body).ok();
                }
                let fate = if done { Fate::Done } else { Fate::Refused };
                self.fates.extend(sent.witness.map(|(lane, number)| (lane, number, fate)));
            }
        }
    }
}

/// Every answer has the layout of its command, or a code with its reason.
fn check(broken: bool, info: Option<&CommandInfo>, opcode: u16, code: i16, body: &[u8]) {
    if code == Code::Done as i16 {
        let info = info.filter(|_| !broken).unwrap_or_else(|| panic!("{opcode:#06x} was carried out"));
        let (fixed, item) = (size(info.reply), size(info.reply_items));
        let rest = body.len().checked_sub(fixed);
        assert!(
            rest.is_some_and(|rest| if item == 0 { rest == 0 } else { rest.is_multiple_of(item) }),
            "{}: a reply of {} bytes",
            info.name,
            body.len()
        );
        return;
    }
    let Ok(refusal) = Refusal::read_from_bytes(body) else {
        panic!("{opcode:#06x}: code {code} without a reason, {} bytes", body.len())
    };
    let Some(reason) = refusal.reason() else { panic!("{opcode:#06x}: unknown reason {}", refusal.reason.get()) };
    assert_eq!(reason.code() as i16, code, "{opcode:#06x}: code of {reason:?}");
    if let Some(info) = info {
        let fields = info.fields.len() + info.items.len();
        assert!(
            refusal.field == Refusal::NO_FIELD || usize::from(refusal.field) < fields,
            "{}: {reason:?} names field {}",
            info.name,
            refusal.field
        );
    }
    let text = describe_opcode(opcode, refusal).to_string();
    assert!(!text.trim().is_empty() && !text.contains(['{', '}']), "{opcode:#06x}: {reason:?} reads {text:?}");
}

/// Bytes of a layout.
pub fn size(fields: &[(&str, &str)]) -> usize {
    let of = |kind: &str| match kind {
        "u8" => 1,
        "I16" | "U16" => 2,
        "I32" | "U32" => 4,
        _ => 8,
    };
    let bytes = |kind: &str| match kind.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')?.split_once("; ")) {
        Some((kind, count)) => of(kind) * count.parse::<usize>().unwrap_or(0),
        None => of(kind),
    };
    fields.iter().map(|(_, kind)| bytes(kind)).sum()
}
