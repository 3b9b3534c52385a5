//! Properties of the byte layers: nothing panics on any bytes, also with a good checksum. The
//! deframer agrees with the `cobs` crate, in any portions, and recovers after garbage.

use proptest::prelude::*;
use protocol::command::{COMMANDS, PtData, PtDataMany, PtItem, SetCrdPrm, Wire, widths};
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::{self, Header, MAX_PAYLOAD, MAX_WIRE};
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::record::{BODY_MAX, ITEM_BYTES, Lane, RequestWriter, replies, requests};
use protocol::{reason, trace};
use zerocopy::{FromBytes, IntoBytes};

/// All results of the bytes, fed in portions of the given length.
fn deframe(bytes: &[u8], portion: usize) -> Vec<Result<Vec<u8>, Outcome>> {
    let mut deframer = Deframer::<203>::new();
    let mut out = Vec::new();
    for mut part in bytes.chunks(portion) {
        while !part.is_empty() {
            let (used, outcome) = deframer.feed(part);
            part = &part[used..];
            match outcome {
                Outcome::More => assert!(part.is_empty()),
                Outcome::Frame => out.push(Ok(deframer.frame().to_vec())),
                refused => out.push(Err(refused)),
            }
        }
    }
    out
}

/// Bytes with many zeros, ones and full blocks.
fn plain() -> impl Strategy<Value = Vec<u8>> {
    proptest::collection::vec(prop_oneof![2 => Just(0u8), 1 => Just(255u8), 1 => Just(1u8), 6 => any::<u8>()], 0..200)
}

fn encode(plain: &[u8]) -> Vec<u8> {
    let mut wire = vec![0; cobs::max_encoding_length(plain.len()) + 1];
    let length = cobs::encode(plain, &mut wire);
    wire.truncate(length);
    wire.push(0);
    wire
}

/// Frames of a live session with hostile fields and a good checksum.
fn hostile() -> impl Strategy<Value = (u8, u8, u8, u8, bool, u16, u16, Vec<u8>)> {
    let payload = proptest::collection::vec(any::<u8>(), 0..40);
    let version = prop_oneof![9 => Just(1u8), 1 => any::<u8>()];
    (version, 0u8..9, any::<u8>(), any::<u8>(), prop::bool::weighted(0.9), any::<u16>(), any::<u16>(), payload)
}

fn pump(now: u64, from: &mut Endpoint<4>, to: &mut Endpoint<4>) {
    let mut wire = [0; MAX_WIRE];
    let length = from.take_tx(now, &mut wire);
    to.feed(now, &wire[..length]);
}

fn opened() -> (Endpoint<4>, Endpoint<4>) {
    let mut client = Endpoint::new(Role::Client, Identity::OURS);
    let mut controller = Endpoint::new(Role::Controller, Identity::OURS);
    client.open(0, 77);
    for _ in 0..2 {
        pump(0, &mut client, &mut controller);
        pump(0, &mut controller, &mut client);
    }
    assert_eq!((client.state(), controller.state()), (LinkState::Open, LinkState::Open));
    (client, controller)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_deframer_agrees_with_the_cobs_crate(plain in plain(), portion in 1usize..300) {
        prop_assert_eq!(deframe(&encode(&plain), portion), vec![Ok(plain)]);
    }

    #[test]
    fn garbage_costs_no_frame_after_the_next_delimiter(
        garbage in proptest::collection::vec(any::<u8>(), 0..600), plain in plain(), portion in 1usize..300,
    ) {
        let mut bytes = garbage.clone();
        bytes.push(0);
        bytes.extend(encode(&plain));
        prop_assert_eq!(deframe(&bytes, portion).pop(), Some(Ok(plain)));
        // The portions make no difference, and what the crate takes for a frame is one here.
        let found = deframe(&bytes, portion);
        prop_assert_eq!(&found, &deframe(&bytes, bytes.len()));
        let models = bytes.split(|&byte| byte == 0).filter(|part| !part.is_empty());
        for (found, part) in found.iter().zip(models) {
            let mut place = vec![0; 2_000];
            let model = cobs::decode(part, &mut place).ok().map(|report| place[..report.frame_size()].to_vec());
            match found {
                Ok(frame) => prop_assert_eq!(Some(frame), model.as_ref()),
                Err(Outcome::Refused(protocol::deframe::Fault::TooLong)) => prop_assert!(part.len() > 200),
                Err(_) => prop_assert_eq!(model, None),
            }
        }
    }

    #[test]
    fn any_bytes_are_safe_everywhere(bytes in proptest::collection::vec(any::<u8>(), 0..3_000)) {
        for role in [Role::Client, Role::Controller] {
            let mut end = Endpoint::<4>::new(role, Identity::OURS);
            end.open(0, 1);
            end.feed(5, &bytes);
            prop_assert_eq!(end.message(), None);
        }
        let _ = frame::decode(&bytes);
        for record in requests(&bytes).flatten() {
            let _ = record.parse::<PtData>();
            let items = record.parse::<PtDataMany>().map(|(_, items)| items.iter().count());
            prop_assert!(items.is_err() || items.is_ok());
        }
        // Records never overlap and never reach beyond the message.
        let sum: usize = replies(&bytes).flatten().map(|record| record.body.len() + 8).sum();
        prop_assert!(sum <= bytes.len());
        let mut decoder = trace::Decoder::new();
        decoder.feed(&bytes, |event| assert!(event.is_err()));
    }

    #[test]
    fn hostile_frames_after_a_good_checksum_are_safe(frames in proptest::collection::vec(hostile(), 1..60)) {
        let (mut client, mut controller) = opened();
        let session = controller.session().unwrap();
        let mut now = 0;
        for (version, kind, flags, credit, mine, sequence, acknowledgement, payload) in frames {
            let header = Header {
                version, kind, flags, credit,
                session: (if mine { session } else { session ^ 1 }).into(),
                sequence: (sequence % 12).into(),
                acknowledgement: (acknowledgement % 6).into(),
                length: 0.into(),
            };
            let mut wire = [0; MAX_WIRE];
            let length = frame::encode(header, &payload, &mut wire).unwrap();
            now += 50_000_000;
            for end in [&mut client, &mut controller] {
                end.feed(now, &wire[..length]);
                let _ = end.send(b"x");
                end.done_with_message();
                let mut out = [0; 100];
                while end.take_tx(now, &mut out) == out.len() {}
                prop_assert!(end.free_slots() <= 4);
            }
        }
    }

    #[test]
    fn a_trace_body_of_anything_is_safe(body in proptest::collection::vec(any::<u8>(), 0..100), kind in 0x80u8..0x85) {
        let mut body = body;
        body.insert(0, kind);
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&body);
        body.extend(crc.to_le_bytes());
        let mut decoder = trace::Decoder::new();
        let mut head = trace::Encoder::new();
        let described = trace::TraceHead { schema: 0, period_ns: 1, every: 1, timer_mhz: 1 };
        let (axes, lasers) = (&[trace::AxisId { core: 0, axis: 1 }][..], &[trace::LaserId { channel: 0 }][..]);
        head.head(&described, &trace::Ids { axes, lasers, crds: &[trace::CrdId { core: 0, crd: 1 }] }).unwrap();
        let mut wire = [0; 100];
        let length = head.take(&mut wire);
        decoder.feed(&wire[..length], |event| assert!(event.is_ok()));
        decoder.feed(&encode(&body), |_| {});
    }

    #[test]
    fn any_refusal_can_be_described(bytes in any::<[u8; 31]>(), row in 0..COMMANDS.len()) {
        let mut bytes = bytes;
        bytes[1] = 0;
        bytes[0] %= 50;
        let refusal = reason::Refusal::read_from_bytes(&bytes).unwrap();
        let text = reason::describe_opcode(COMMANDS[row].opcode, refusal).to_string();
        prop_assert!(text.starts_with(COMMANDS[row].name));
        prop_assert!(!text.contains('{'), "{}", text);
    }

    #[test]
    fn pt_items_come_back_as_they_went(
        data in proptest::collection::vec((any::<u64>(), any::<i32>(), any::<u8>()), 0..70),
    ) {
        let items: Vec<PtItem> = data
            .iter()
            .map(|&(pos, time, kind)| PtItem { pos: f64::from_bits(pos).into(), time_ms: time.into(), kind })
            .collect();
        let request = PtDataMany { core: 1.into(), profile: 2.into(), fifo: 0.into(), count: (items.len() as u16).into() };
        let mut message = [0; MAX_PAYLOAD];
        let mut writer = RequestWriter::new(&mut message);
        writer.push(Lane::Program, 7, &request, &items).unwrap();
        let length = writer.len();
        let record = requests(&message[..length]).next().unwrap().unwrap();
        let (back, came) = record.parse::<PtDataMany>().unwrap();
        prop_assert_eq!(back, request);
        let came: Vec<PtItem> = came.iter().collect();
        prop_assert_eq!(came.as_bytes(), items.as_bytes());
    }
}

#[test]
fn frames_of_every_length_survive() {
    let mut deframer = Deframer::<MAX_WIRE>::new();
    for length in 0..=MAX_PAYLOAD {
        let payload: Vec<u8> = (0..length).map(|i| (i * 7 % 256) as u8).collect();
        let header = Header { version: 1, kind: 3, ..Header::default() };
        let mut wire = [0; MAX_WIRE];
        let count = frame::encode(header, &payload, &mut wire).unwrap();
        assert_eq!(deframer.feed(&wire[..count]), (count, Outcome::Frame));
        assert_eq!(frame::decode(deframer.frame()).unwrap().2, &payload[..]);
    }
    assert_eq!(frame::encode(Header::default(), &[0; MAX_PAYLOAD + 1], &mut [0; 2 * MAX_WIRE]), None);
    assert_eq!(frame::encode(Header::default(), &[], &mut [0; 4]), None);
}

/// A message holds the items that a client packs into one request, whatever the command.
#[test]
fn items_fit_after_every_head() {
    let mut carriers = 0;
    for command in COMMANDS.iter().filter(|command| !command.items.is_empty()) {
        let (head, item) = (widths(command.fields), widths(command.items));
        assert!(head + ITEM_BYTES / item * item <= BODY_MAX, "{}: {head} bytes, items of {item}", command.name);
        let body = vec![0; BODY_MAX];
        let mut message = [0; MAX_PAYLOAD];
        RequestWriter::new(&mut message).push_raw(command.opcode, Lane::Program, 1, &[&body]).unwrap();
        assert_eq!(requests(&message).next().unwrap().unwrap().body.len(), BODY_MAX);
        carriers += 1;
    }
    assert!(carriers > 10, "{carriers}");
    assert_eq!(widths(<PtDataMany as Wire>::FIELDS), size_of::<PtDataMany>());
    assert_eq!(widths(<SetCrdPrm as Wire>::FIELDS), size_of::<SetCrdPrm>());
}
