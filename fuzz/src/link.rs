//! Bytes and re-sealed frames into the deframer and both ends of a link.
//!
//! Held: the deframer gives what it gives in any portions, and what the COBS rules give. An end
//! delivers messages of the session in force only, each number once and in order, with the bytes of
//! a frame that came with it. Nothing panics.
use crate::source::Source;
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::{self, FrameKind, Header, MAX_PAYLOAD, MAX_WIRE};
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::record::{replies, requests};
use std::collections::HashMap;

/// See the module text.
pub fn run(data: &[u8]) {
    deframed(data);
    ends(&mut Source::new(data));
}

/// The frames of a stream that is fed in portions of so many bytes.
fn frames(data: &[u8], portion: usize) -> Vec<Vec<u8>> {
    let mut deframer = Deframer::<MAX_WIRE>::new();
    let mut all = Vec::new();
    for part in data.chunks(portion) {
        let mut rest = part;
        while !rest.is_empty() {
            let (used, outcome) = deframer.feed(rest);
            assert!(used > 0 && used <= rest.len(), "{used} of {} bytes taken", rest.len());
            rest = &rest[used..];
            match outcome {
                Outcome::Frame => all.push(deframer.frame().to_vec()),
                Outcome::More => assert!(rest.is_empty(), "bytes are left and nothing came of them"),
                Outcome::Refused(_) => {}
            }
        }
    }
    assert_eq!(deframer.counters().frames as usize, all.len());
    all
}

/// COBS by its rules: a code, that many less one bytes, a zero unless the code was 255 or the data
/// are over.
fn unstuffed(data: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    let mut rest = data;
    while let Some((&code, tail)) = rest.split_first() {
        let (block, tail) = tail.split_at_checked(usize::from(code) - 1)?;
        out.extend_from_slice(block);
        if code != 255 && !tail.is_empty() {
            out.push(0);
        }
        rest = tail;
    }
    Some(out)
}

fn deframed(data: &[u8]) {
    let whole = frames(data, usize::MAX);
    for portion in [1, 3, 7, 64] {
        assert_eq!(frames(data, portion), whole, "in portions of {portion} bytes");
    }
    let ended = &data[..data.iter().rposition(|&byte| byte == 0).map_or(0, |at| at + 1)];
    let ruled: Vec<_> = ended
        .split(|&byte| byte == 0)
        // What is longer than the buffer, whose first byte is kept for alignment, is refused.
        .filter(|part| !part.is_empty() && part.len() < MAX_WIRE)
        .filter_map(unstuffed)
        .collect();
    assert_eq!(whole, ruled, "frames by the rules of COBS");
    for bytes in &whole {
        if let Ok((_, _, payload)) = frame::decode(bytes) {
            for record in requests(payload).flatten() {
                assert!(record.body.len() < payload.len());
            }
            replies(payload).for_each(drop);
        }
    }
}

/// One end and what it was fed in its session.
struct End {
    end: Endpoint<8>,
    /// Takes the same bytes.
    deframer: Deframer<MAX_WIRE>,
    session: Option<u32>,
    /// Payloads of Data frames of this session by number.
    fed: HashMap<u16, Vec<Vec<u8>>>,
    delivered: u16,
}

impl End {
    fn new(role: Role) -> End {
        let end = Endpoint::new(role, Identity::OURS);
        End { end, deframer: Deframer::new(), session: None, fed: HashMap::new(), delivered: 0 }
    }

    fn feed(&mut self, now: u64, bytes: &[u8]) {
        // Frame by frame: one may begin a session, its own too.
        for part in bytes.split_inclusive(|&byte| byte == 0) {
            let whole = self.deframer.feed(part).1 == Outcome::Frame;
            self.end.feed(now, part);
            self.look();
            if whole
                && let Ok((header, FrameKind::Data, payload)) = frame::decode(self.deframer.frame())
                && Some(header.session.get()) == self.session
            {
                self.fed.entry(header.sequence.get()).or_default().push(payload.to_vec());
            }
        }
    }

    fn look(&mut self) {
        if self.end.session() != self.session {
            (self.session, self.delivered) = (self.end.session(), 0);
            self.fed.clear();
        }
    }

    /// Takes what has come.
    fn take(&mut self, most: usize) {
        for _ in 0..most {
            let Some(message) = self.end.message() else { return };
            if self.session.is_some() {
                let fed = self.fed.get(&self.delivered).map(Vec::as_slice).unwrap_or_default();
                assert!(fed.iter().any(|payload| payload == message), "message {} was never sent", self.delivered);
            }
            self.delivered = self.delivered.wrapping_add(1);
            self.end.done_with_message();
        }
    }
}

fn ends(from: &mut Source) {
    let mut now = 0u64;
    let mut ends = [End::new(Role::Client), End::new(Role::Controller)];
    let mut wire = vec![0; 4 * MAX_WIRE];
    let mut before = [const { Vec::new() }; 2];
    while !from.is_empty() {
        let which = from.below(2);
        match from.below(8) {
            0 => ends[0].end.open(now, u32::from(from.word()) | 1),
            1 => now += u64::from(from.word()) * 10_000,
            2 => {
                let count = from.below(64);
                let message = from.bytes(count);
                let _ = ends[which].end.send(message);
            }
            3 => {
                let most = from.below(9);
                ends[which].take(most);
            }
            // Raw bytes.
            4 => {
                let count = from.below(96);
                let bytes = from.bytes(count);
                ends[which].feed(now, bytes);
            }
            // A sealed frame with a header of any numbers, often of the session in force.
            5 => {
                let session = if from.one_in(4) { from.long() as u32 } else { ends[which].end.session().unwrap_or(1) };
                let header = Header {
                    version: if from.one_in(16) { from.byte() } else { protocol::VERSION },
                    kind: from.byte() % 8,
                    flags: from.byte() & 3,
                    credit: from.byte(),
                    session: session.into(),
                    sequence: u16::from(from.byte() % 20).wrapping_sub(4).wrapping_add(ends[which].delivered).into(),
                    acknowledgement: u16::from(from.byte() % 20).wrapping_sub(4).into(),
                    length: 0.into(),
                };
                let count = from.below(MAX_PAYLOAD + 1);
                let payload = from.bytes(count);
                if let Some(length) = frame::encode(header, payload, &mut wire) {
                    let sealed = wire[..length].to_vec();
                    ends[which].feed(now, &sealed);
                }
            }
            // What an end sends reaches the other one, or is lost, or comes twice, or with what was
            // sent before and comes after it.
            _ => {
                let count = ends[which].end.take_tx(now, &mut wire);
                let sent = wire[..count].to_vec();
                let fate = from.byte() % 8;
                if fate != 7 {
                    ends[1 - which].feed(now, &sent);
                }
                match fate {
                    6 => ends[1 - which].feed(now, &sent),
                    5 => ends[1 - which].feed(now, &before[which]),
                    _ => {}
                }
                before[which] = sent;
            }
        }
        for end in &mut ends {
            end.end.poll(now);
            end.look();
            assert_eq!(end.end.session().is_some(), end.end.state() == LinkState::Open);
            assert!(end.end.free_slots() <= 8);
        }
    }
}
