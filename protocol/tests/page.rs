//! `docs/protocol.md` and the code agree: the tables are the code's own, and every vector of the
//! page is checked in both directions. Other programs computed the vectors' checksums and COBS
//! forms (Python's `zlib.crc32`), or they are in the papers. So they are independent.

use protocol::command::{COMMANDS, CommandInfo, info};
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::{self, FrameKind, Header, MAX_WIRE};
use protocol::reason::{REASONS, Reason, describe_opcode};
use protocol::record::{Lane, ReplyError, ReplyWriter, RequestWriter, replies, requests};
use protocol::reserved::RESERVED;
use protocol::trace;
use std::fmt::Write;

type Fields = &'static [(&'static str, &'static str)];

fn page() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/protocol.md");
    std::fs::read_to_string(path).expect("docs/protocol.md")
}

/// Lines of all code blocks with this info string; comments and empty lines left out.
fn block(name: &str) -> Vec<String> {
    let fence = format!("```{name}");
    let page = page();
    let mut lines = page.lines();
    let mut found = Vec::new();
    while lines.by_ref().any(|line| line == fence) {
        let body = lines.by_ref().take_while(|line| *line != "```");
        found.extend(body.filter(|line| !line.is_empty() && !line.starts_with('#')).map(String::from));
    }
    assert!(!found.is_empty(), "the page has no block {name}");
    found
}

fn columns<const N: usize>(line: &str) -> [String; N] {
    let parts: Vec<String> = line.split('|').map(|part| part.trim().to_string()).collect();
    parts.try_into().unwrap_or_else(|_| panic!("{N} columns expected: {line}"))
}

/// Bytes in hex; `a..b` stands for a sequence of rising bytes.
fn bytes(text: &str) -> Vec<u8> {
    let byte = |text: &str| u8::from_str_radix(text, 16).unwrap_or_else(|_| panic!("no hex byte: {text}"));
    let each = |word: &str| match word.split_once("..") {
        Some((from, to)) => (byte(from)..=byte(to)).collect(),
        None => vec![byte(word)],
    };
    text.split_whitespace().flat_map(each).collect()
}

fn deframe(wire: &[u8]) -> (Outcome, Vec<u8>) {
    let mut deframer = Deframer::<MAX_WIRE>::new();
    let (used, outcome) = deframer.feed(wire);
    assert_eq!(used, wire.len(), "one frame a vector");
    (outcome, deframer.frame().to_vec())
}

fn section_is(name: &str, expected: &str) {
    let page = page();
    let begin = format!("<!-- {name} -->\n");
    let end = format!("<!-- end of {name} -->");
    let there = page.split_once(&begin).and_then(|(_, rest)| rest.split_once(&end)).map(|(body, _)| body);
    let there = there.unwrap_or_else(|| panic!("the page has no section {name}"));
    assert!(there == expected, "docs/protocol.md is not up to date; paste between the {name} marks:\n{expected}");
}

fn list(fields: Fields) -> String {
    if fields.is_empty() {
        return "–".into();
    }
    let each: Vec<String> = fields.iter().map(|(name, kind)| format!("{name} {kind}")).collect();
    each.join(", ")
}

#[test]
fn the_command_table_is_that_of_the_code() {
    let mut text =
        "| number | command | kind | lanes | request | each item | reply | each reply item |\n|---|---|---|---|---|---|---|---|\n".to_string();
    for CommandInfo { opcode, name, class, fields, items, reply, reply_items } in COMMANDS {
        let (fields, items, reply, reply_items) = (list(fields), list(items), list(reply), list(reply_items));
        let kind = format!("{:?}", class.kind).replace('(', " ").replace(')', "");
        let lanes = class.lanes;
        writeln!(text, "| {opcode:04X} | {name} | {kind} | {lanes:?} | {fields} | {items} | {reply} | {reply_items} |")
            .unwrap();
    }
    section_is("commands", &text);
}

#[test]
fn the_reserved_numbers_are_those_of_the_code() {
    let mut text = "| number | command |\n|---|---|\n".to_string();
    for (number, name) in RESERVED {
        writeln!(text, "| {number:04X} | {name} |").unwrap();
    }
    section_is("reserved", &text);
}

#[test]
fn the_reasons_are_those_of_the_code() {
    let mut text = "| number | code | text |\n|---|---|---|\n".to_string();
    for (reason, code, words) in REASONS {
        writeln!(text, "| {} | {} | {words} |", *reason as u16, *code as i16).unwrap();
    }
    section_is("reasons", &text);
}

#[test]
fn checksums_are_those_of_the_page() {
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    for line in block("crc") {
        let [data, sum] = columns(&line);
        let data = if data.starts_with('"') { data.trim_matches('"').as_bytes().to_vec() } else { bytes(&data) };
        let sum = u32::from_str_radix(&sum, 16).unwrap();
        assert_eq!(crc.checksum(&data), sum, "{line}");
        // And as the frames use it: a frame of trace kind with this body and this sum is whole.
        let mut sealed = data.clone();
        sealed.extend(sum.to_le_bytes());
        let mut wire = vec![0; 64];
        let length = cobs::encode(&sealed, &mut wire);
        wire[length] = 0;
        let mut decoder = trace::Decoder::new();
        decoder.feed(&wire[..=length], |event| assert_eq!(event, Err(trace::TraceError::Unexpected)));
    }
}

#[test]
fn cobs_is_that_of_the_page() {
    for line in block("cobs") {
        let [plain, encoded] = columns(&line);
        let (plain, encoded) = (bytes(&plain), bytes(&encoded));
        let mut wire = encoded.clone();
        wire.push(0);
        assert_eq!(deframe(&wire), (Outcome::Frame, plain.clone()), "{line}");
        let mut ours = vec![0; 300];
        let length = cobs::encode(&plain, &mut ours);
        // After a full last block the crate may add an empty one, which the paper leaves out; both
        // decode alike.
        let shown = if encoded.len() == 255 { 255 } else { length };
        assert_eq!(ours[..shown], encoded, "{line}");
    }
}

fn number(text: &str) -> u32 {
    text.strip_prefix("0x").map_or_else(|| text.parse(), |hex| u32::from_str_radix(hex, 16)).unwrap()
}

fn value<'a>(words: &'a str, key: &str) -> &'a str {
    words
        .split_whitespace()
        .find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
        .unwrap_or_else(|| panic!("{key} is missing in: {words}"))
}

#[test]
fn frames_are_those_of_the_page() {
    for line in block("frame") {
        let [kind, fields, payload, wire] = columns(&line);
        let (payload, wire) = (bytes(&payload), bytes(&wire));
        let kinds = [
            FrameKind::Hello,
            FrameKind::HelloAck,
            FrameKind::Data,
            FrameKind::Ack,
            FrameKind::KeepAlive,
            FrameKind::Bye,
            FrameKind::Busy,
        ];
        let kind = kinds.into_iter().find(|k| format!("{k:?}") == kind).unwrap_or_else(|| panic!("kind {kind}"));
        let field = |key| number(value(&fields, key));
        let header = Header {
            version: field("version") as u8,
            kind: kind as u8,
            flags: field("flags") as u8,
            credit: field("credit") as u8,
            session: field("session").into(),
            sequence: (field("sequence") as u16).into(),
            acknowledgement: (field("acknowledgement") as u16).into(),
            length: (payload.len() as u16).into(),
        };
        let mut ours = [0; MAX_WIRE];
        let length = frame::encode(header, &payload, &mut ours).unwrap();
        assert_eq!(ours[..length], wire, "{line}");
        let (outcome, decoded) = deframe(&wire);
        assert_eq!(outcome, Outcome::Frame);
        assert_eq!(frame::decode(&decoded), Ok((header, kind, &payload[..])), "{line}");
    }
}

#[test]
fn rejected_frames_are_rejected_for_the_reason_on_the_page() {
    let mut seen = Vec::new();
    for line in block("rejected") {
        let [reason, wire] = columns(&line);
        let (outcome, decoded) = deframe(&bytes(&wire));
        let got = match outcome {
            Outcome::More => panic!("no delimiter: {line}"),
            Outcome::Refused(fault) => format!("{fault:?}"),
            Outcome::Frame => format!("{:?}", frame::decode(&decoded).map(|_| ()).unwrap_err()),
        };
        assert_eq!(got, reason, "{line}");
        seen.push(reason);
    }
    for reason in ["Truncated", "TooLong", "Short", "Checksum", "Version", "Kind", "Length"] {
        assert!(seen.iter().any(|s| s == reason), "no example of {reason}");
    }
}

/// A struct from `name=value` words, by its table row alone.
fn build(fields: Fields, words: &str) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, kind) in fields {
        let text = value(words, name);
        match *kind {
            "u8" => body.push(text.parse::<u8>().unwrap()),
            "U16" => body.extend(text.parse::<u16>().unwrap().to_le_bytes()),
            "I16" => body.extend(text.parse::<i16>().unwrap().to_le_bytes()),
            "U32" => body.extend(text.parse::<u32>().unwrap().to_le_bytes()),
            "I32" => body.extend(text.parse::<i32>().unwrap().to_le_bytes()),
            "U64" => body.extend(text.parse::<u64>().unwrap().to_le_bytes()),
            "F64" => body.extend(text.parse::<f64>().unwrap().to_le_bytes()),
            other => panic!("type {other} of {name}"),
        }
    }
    body
}

/// The other way.
fn show(fields: Fields, body: &mut &[u8]) -> String {
    fn take<const N: usize>(body: &mut &[u8]) -> [u8; N] {
        let (value, rest) = body.split_first_chunk::<N>().expect("length");
        *body = rest;
        *value
    }
    let mut words = Vec::new();
    for (name, kind) in fields {
        let text = match *kind {
            "u8" => take::<1>(body)[0].to_string(),
            "U16" => u16::from_le_bytes(take(body)).to_string(),
            "I16" => i16::from_le_bytes(take(body)).to_string(),
            "U32" => u32::from_le_bytes(take(body)).to_string(),
            "I32" => i32::from_le_bytes(take(body)).to_string(),
            "U64" => u64::from_le_bytes(take(body)).to_string(),
            "F64" => f64::from_le_bytes(take(body)).to_string(),
            other => panic!("type {other} of {name}"),
        };
        words.push(format!("{name}={text}"));
    }
    words.join(" ")
}

/// Command name, its struct and its items, from `Name a=1 b=2; c=3; c=4`.
fn parts(text: &str) -> (&'static CommandInfo, String, Vec<String>) {
    let mut pieces = text.split(';').map(|piece| piece.trim().to_string());
    let head = pieces.next().unwrap();
    let name = head.split_whitespace().next().unwrap();
    let command = COMMANDS.iter().find(|command| command.name == name).unwrap_or_else(|| panic!("command {name}"));
    (command, head.strip_prefix(name).unwrap().trim().to_string(), pieces.collect())
}

fn show_all(command: &CommandInfo, fields: Fields, items: Fields, mut body: &[u8]) -> String {
    let mut text = format!("{} {}", command.name, show(fields, &mut body)).trim().to_string();
    while !body.is_empty() {
        write!(text, "; {}", show(items, &mut body)).unwrap();
    }
    text
}

#[test]
fn requests_are_those_of_the_page() {
    for line in block("request") {
        let [head, text, wire] = columns(&line);
        let wire = bytes(&wire);
        let (command, words, items) = parts(&text);
        let mut body = build(command.fields, &words);
        items.iter().for_each(|item| body.extend(build(command.items, item)));
        let lane = match value(&head, "lane") {
            "0" => Lane::Immediate,
            "1" => Lane::Program,
            _ => Lane::ProgramMayFail,
        };
        let tag = number(value(&head, "tag")) as u16;
        let mut ours = [0; 256];
        let mut writer = RequestWriter::new(&mut ours);
        writer.push_raw(command.opcode, lane, tag, &[&body]).unwrap();
        let length = writer.len();
        assert_eq!(ours[..length], wire, "{line}");
        let record = requests(&wire).next().unwrap().unwrap();
        assert_eq!((record.opcode, record.tag, record.lane), (command.opcode, tag, lane), "{line}");
        assert_eq!(show_all(command, command.fields, command.items, record.body), text, "{line}");
    }
}

#[test]
fn replies_are_those_of_the_page() {
    for line in block("reply") {
        let [head, text, wire] = columns(&line);
        let wire = bytes(&wire);
        let (command, words, items) = parts(&text);
        let mut body = build(command.reply, &words);
        items.iter().for_each(|item| body.extend(build(command.reply_items, item)));
        let tag = number(value(&head, "tag")) as u16;
        let mut ours = [0; 256];
        let mut writer = ReplyWriter::new(&mut ours);
        writer.push_raw(command.opcode, tag, 0, &[&body]).unwrap();
        let length = writer.len();
        assert_eq!(ours[..length], wire, "{line}");
        let record = replies(&wire).next().unwrap().unwrap();
        assert_eq!((record.opcode, record.tag, record.code), (command.opcode, tag, 0), "{line}");
        assert_eq!(show_all(command, command.reply, command.reply_items, record.body), text, "{line}");
    }
}

#[test]
fn refusals_read_as_on_the_page() {
    for line in block("refusal") {
        let [wire, text] = columns(&line);
        let wire = bytes(&wire);
        let record = replies(&wire).next().unwrap().unwrap();
        let Some(ReplyError::Refused(code, refusal)) = record.refusal() else { panic!("{line}") };
        assert_eq!(Reason::from_number(refusal.reason.get()).map(|reason| reason.code() as i16), Some(code));
        assert!(info(record.opcode).is_some());
        assert_eq!(describe_opcode(record.opcode, refusal).to_string(), text);
        let mut ours = [0; 256];
        let mut writer = ReplyWriter::new(&mut ours);
        writer.refused(record.opcode, record.tag, &refusal).unwrap();
        let length = writer.len();
        assert_eq!(ours[..length], wire, "{line}");
    }
}

#[test]
fn malformed_messages_are_reported_as_on_the_page() {
    for line in block("malformed") {
        let [wire, text] = columns(&line);
        let shown: Vec<String> = requests(&bytes(&wire))
            .map(|record| match record {
                Ok(record) => match info(record.opcode) {
                    Some(command) => format!("{} of {} bytes", command.name, record.body.len()),
                    None => format!("unknown {:04X} of {} bytes", record.opcode, record.body.len()),
                },
                Err(bad) if bad.lane.is_some() => format!("no lane at {}", bad.at),
                Err(bad) => format!("cut at {}", bad.at),
            })
            .collect();
        assert_eq!(shown.join(", "), text);
    }
}

#[test]
fn a_trace_is_that_of_the_page() {
    assert!(page().contains(&format!("| version is {} |", trace::VERSION)));
    let lines = block("trace");
    let wire: Vec<u8> = lines.iter().flat_map(|line| bytes(&columns::<2>(line)[1])).collect();
    let mut encoder = trace::Encoder::new();
    let axes = [trace::AxisId { core: 0, axis: 1 }, trace::AxisId { core: 1, axis: 3 }];
    let sample = |pos: i64, vel_mantissa: i64, vel_exponent: i16| trace::Sample {
        pos: pos.into(),
        vel_mantissa: vel_mantissa.into(),
        vel_exponent: vel_exponent.into(),
    };
    let rows = [[sample(0, 0, 0), sample(-4194304, 3, 1)], [sample(4194304, 1 << 40, 39), sample(-1, -3, 1)]];
    let laser =
        |mode: u8, gate: u8, power: i64| trace::LaserSample { mode, gate, power: power.into(), khz: power.into() };
    let lasers = [[laser(0, 0, 0)], [laser(1, 1, 30 << 44)]];
    let speed = |m: i64| trace::CrdSample { vel_mantissa: m.into(), vel_exponent: 2.into() };
    let crds = [[speed(0)], [speed(7)]];
    let samples = |row: usize| trace::Samples { axes: &rows[row], lasers: &lasers[row], crds: &crds[row] };
    let outputs = trace::Outputs { tick: 1.into(), at: 125_000.into(), levels: 5.into() };
    let count = |whole: u64, of: u32| trace::Count { whole: whole.into(), part: 1.into(), of: of.into() };
    let action = trace::Action {
        tick: 1.into(),
        at: 1_500.into(),
        channel: 0,
        kind: trace::kind::LIGHT,
        value: 0.into(),
        period: count(33_333, 3),
        width: count(8_333, 0),
    };
    let head = trace::TraceHead { schema: 0x1234_5678, period_ns: 250_000, every: 1, timer_mhz: 1000 };
    let mut ours: Vec<u8> = Vec::new();
    let mut out = [0; 2000];
    let (lasers_of, crds_of) = ([trace::LaserId { channel: 0 }], [trace::CrdId { core: 1, crd: 2 }]);
    encoder.head(&head, &trace::Ids { axes: &axes, lasers: &lasers_of, crds: &crds_of }).unwrap();
    let mut drain = |encoder: &mut trace::Encoder| {
        let length = encoder.take(&mut out);
        ours.extend(&out[..length]);
    };
    drain(&mut encoder);
    encoder.row(0, &samples(0)).unwrap();
    let period = trace::Period { tick: 0.into(), period_ns: 50_000.into() };
    encoder.period(&period).unwrap();
    let zero = trace::Zero { tick: 1.into(), column: 0, by: (-5 << 22).into() };
    encoder.zero(&zero).unwrap();
    encoder.action(&action).unwrap();
    encoder.outputs(&outputs).unwrap();
    encoder.row(1, &samples(1)).unwrap();
    drain(&mut encoder);
    encoder.end(2, 0).unwrap();
    drain(&mut encoder);
    assert!(encoder.is_empty());
    assert_eq!(ours, wire, "{ours:02X?}");
    let mut decoder = trace::Decoder::new();
    let mut came = 0;
    for byte in wire {
        decoder.feed(&[byte], |event| {
            match event.unwrap() {
                trace::TraceEvent::Head(got, ids) => {
                    assert_eq!((got, ids.lasers.len()), (head, 1));
                    assert!(ids.axes.iter().eq(axes) && ids.crds.iter().eq(crds_of));
                }
                trace::TraceEvent::Row(row, samples) => {
                    assert!(samples.axes.iter().eq(rows[row as usize]));
                    assert!(samples.lasers.iter().eq(lasers[row as usize]));
                    assert!(samples.crds.iter().eq(crds[row as usize]));
                }
                trace::TraceEvent::Action(got) => assert_eq!(got, action),
                trace::TraceEvent::Outputs(got) => assert_eq!(got, outputs),
                trace::TraceEvent::Period(got) => assert_eq!(got, period),
                trace::TraceEvent::Zero(got) => assert_eq!(got, zero),
                trace::TraceEvent::End { rows, lost } => assert_eq!((rows, lost), (2, 0)),
            }
            came += 1;
        });
    }
    assert_eq!(came, 8);
    assert!(decoder.ended());
}

/// The numbers of records that answer nothing are no command's.
#[test]
fn no_command_has_the_number_of_a_record() {
    for record in [protocol::record::TRACE_RECORD, protocol::record::JOB_RECORD] {
        let command = COMMANDS.iter().find(|command| command.opcode == record);
        assert_eq!(command.map(|command| command.name), None, "{record:#06x}");
    }
}
