//! The door without a client: records, written here by the table of docs/protocol.md, in frames of
//! the link's own end.

use crate::player::{Programme, Reported};
use crate::program::{Call, Step, Value};
use crate::text::PAUSE_MS;
use crate::{Answer, Run, Trace};
use gts::prototype::{command, outs};
use job::api::{Pass, Shape};
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::reason::{Refusal, describe_opcode};
use std::path::Path;
use trace::{CsvWriter, Item, Reader};
use virtual_board::{Config, Controller, Memory};
use zerocopy::FromBytes;

/// Bytes of items that this door puts into a message.
const ITEM_BYTES: usize = 960;

struct Wire<'m> {
    board: Controller<'m>,
    end: Endpoint<8>,
    tag: u16,
    rows: Vec<u8>,
    /// Ticks that have passed.
    ticks: u64,
}

impl<'m> Wire<'m> {
    fn open(memory: &'m mut Memory) -> Wire<'m> {
        let (board, end) = (Controller::on(memory), Endpoint::new(Role::Client, Identity::OURS));
        let mut wire = Wire { board, end, tag: 0, rows: Vec::new(), ticks: 0 };
        wire.end.open(wire.board.now(), 77);
        while wire.end.state() != LinkState::Open {
            wire.turn();
        }
        wire
    }

    /// What either end has to say goes across; a tick passes.
    fn turn(&mut self) {
        let mut bytes = [0; 4096];
        let length = self.end.take_tx(self.board.now(), &mut bytes);
        self.board.feed(&bytes[..length]);
        let mut back = Vec::new();
        self.board.take_tx(&mut back);
        let period = self.board.period_ns();
        self.board.advance(period, &mut back);
        self.end.feed(self.board.now(), &back);
        self.board.take_trace(&mut self.rows);
        self.ticks += 1;
    }

    fn sleep(&mut self, ms: u32) {
        let until = self.board.now() + u64::from(ms) * 1_000_000;
        while self.board.now() < until {
            self.turn();
        }
    }

    /// Code and payload of the reply to a record of lane 0.
    fn ask(&mut self, opcode: u16, body: &[u8]) -> (i16, Vec<u8>) {
        self.record(0, opcode, body)
    }

    fn record(&mut self, lane: u8, opcode: u16, body: &[u8]) -> (i16, Vec<u8>) {
        self.records(lane, opcode, &[body.to_vec()]).remove(0)
    }

    /// The replies to records that go as they find room, without waiting for each other's replies.
    fn records(&mut self, lane: u8, opcode: u16, bodies: &[Vec<u8>]) -> Vec<(i16, Vec<u8>)> {
        let first = self.tag.wrapping_add(1);
        let (mut waiting, mut replies) = (bodies.iter(), Vec::new());
        let mut next = waiting.next();
        while replies.len() < bodies.len() {
            while let Some(body) = next {
                let mut record = Vec::new();
                for number in [opcode, self.tag.wrapping_add(1), u16::try_from(body.len()).unwrap()] {
                    record.extend(number.to_le_bytes());
                }
                record.push(lane);
                record.extend(body);
                if self.end.send(&record).is_err() {
                    break;
                }
                self.tag = self.tag.wrapping_add(1);
                next = waiting.next();
            }
            self.turn();
            while let Some(reply) = self.end.message() {
                let (mut rest, mut expected) = (reply, first.wrapping_add(replies.len() as u16));
                // Replies to several records may lie in a message.
                while !rest.is_empty() {
                    let word = |at: usize| u16::from_le_bytes([rest[at], rest[at + 1]]);
                    assert_eq!((word(0), word(2)), (opcode, expected));
                    let length = usize::from(word(6));
                    replies.push((word(4).cast_signed(), rest[8..8 + length].to_vec()));
                    expected = expected.wrapping_add(1);
                    rest = &rest[8 + length..];
                }
                self.end.done_with_message();
            }
        }
        replies
    }

    fn call(&mut self, call: &Call) -> (Answer, Vec<f64>) {
        let requests = match requests(call) {
            Ok(requests) => requests,
            // What has no form on the wire is refused by whoever would have to write it.
            Err(reason) => return (Answer { code: 7, reason, values: Vec::new() }, Vec::new()),
        };
        let table = command(call.function).unwrap();
        let (mut answer, mut all) = (Answer::default(), Vec::new());
        // Of what the call fills: the place in the reply, and the values there.
        let filled = call.function.params.iter().zip(&call.values).filter(|(param, _)| param.pass == Pass::Out);
        let filled = filled.zip(outs(call.function)).filter(|((_, value), _)| **value == Value::Out);
        let mut columns: Vec<(usize, Vec<f64>)> =
            filled.filter_map(|(_, place)| place).map(|place| (place, Vec::new())).collect();
        for (code, reply) in self.records(0, table.opcode, &requests) {
            if code != 0 {
                let refusal = Refusal::read_from_bytes(&reply).unwrap();
                let reason = describe_opcode(table.opcode, refusal).to_string();
                return (Answer { code: code.into(), reason, values: Vec::new() }, Vec::new());
            }
            let mut rest = &reply[..];
            let head = fields(table.reply, &mut rest);
            let rows: Vec<Vec<Vec<f64>>> = match table.reply_items.is_empty() {
                true => vec![head],
                false => {
                    let size: usize = table.reply_items.iter().map(|(_, of)| size(of)).sum();
                    (0..rest.len() / size).map(|_| fields(table.reply_items, &mut rest)).collect()
                }
            };
            for row in rows {
                all.extend(row.iter().flatten());
                columns.iter_mut().for_each(|(place, column)| column.extend(&row[*place]));
            }
        }
        answer.values = columns.into_iter().flat_map(|(_, column)| column).collect();
        (answer, all)
    }
}

/// Runs the steps. The values of each call are those of the parameters that it fills; beside them
/// all those of its reply.
pub fn wire(name: &str, family: &str, steps: &[Step]) -> (Run, Vec<Vec<f64>>) {
    let mut memory = Memory::new(Config::default());
    let mut wire = Wire::open(&mut memory);
    let trace = wire.begin(0, family, 0xFF, [3, 3]);
    let (mut answers, mut all) = (Vec::new(), Vec::new());
    for step in steps {
        let (answer, values) = match step {
            Step::Sleep(ms) => {
                wire.sleep(*ms);
                (Answer::default(), Vec::new())
            }
            Step::Call(call) => {
                let found = wire.call(call);
                wire.sleep(PAUSE_MS);
                found
            }
            Step::Wait { .. } => unreachable!("descriptions have none"),
        };
        answers.push(answer);
        all.push(values);
    }
    wire.finish(trace);
    let path = crate::toolchain::scratch().join(format!("{name}-{family}-wire.csv"));
    write(&wire.rows, &path);
    (Run { answers, trace: Trace::read(&path) }, all)
}

impl Wire<'_> {
    /// Chooses profile and family and begins a trace of these axes, lasers and coordinate systems,
    /// every tick, on a stream of its own.
    fn begin(&mut self, profile: u8, family: &str, axes: u64, [lasers, crds]: [u8; 2]) -> Vec<u8> {
        let chosen = self.ask(protocol::command::opcode::Choose, &[profile, u8::from(family == "lsr")]);
        assert_eq!(chosen.0, 0, "the family is chosen");
        let mut trace = 1u32.to_le_bytes().to_vec();
        trace.extend(axes.to_le_bytes());
        trace.extend([lasers, crds, 0, 0]);
        assert_eq!(self.ask(protocol::command::opcode::Trace, &trace).0, 0, "a trace is asked for");
        // It waits for a program, here of no entries.
        assert_eq!(self.ask(protocol::command::opcode::ProgramStart, &[0]).0, 0, "the trace begins");
        assert_eq!(self.record(1, protocol::command::opcode::ProgramEnd, &[]).0, 0, "the program ends");
        trace
    }

    fn finish(&mut self, mut trace: Vec<u8>) {
        trace[..4].fill(0);
        assert_eq!(self.ask(protocol::command::opcode::Trace, &trace).0, 0, "the trace ends");
        self.sleep(20);
    }
}

/// Runs a program whose calls were made at these ticks through another door.
pub fn scheduled(programme: &Programme, ticks: &[u32], path: &Path) -> Vec<(Reported, Vec<f64>)> {
    let (number, axes, profile) = match programme.profile {
        "gus" => (0, 0xFF, 0),
        _ => (1, 0xFFFF, 1),
    };
    let mut memory = Memory::new(Config { profile, ..Config::default() });
    let mut wire = Wire::open(&mut memory);
    let trace = wire.begin(number, programme.family, axes, if number == 0 { [3, 3] } else { [3, 15] });
    let us = i32::try_from(programme.tick_us).unwrap().to_le_bytes();
    assert_eq!(wire.ask(protocol::command::opcode::SetTick, &us).0, 0, "the tick is set");
    wire.sleep(5);
    let begin = wire.ticks;
    let mut found = Vec::new();
    for (step, tick) in programme.steps.iter().zip(ticks) {
        let due = begin + u64::from(tick - ticks[0]);
        while wire.ticks < due {
            wire.turn();
        }
        let now = wire.ticks;
        let (answer, all) = match step {
            Step::Call(call) => wire.call(call),
            _ => Default::default(),
        };
        if let Step::Call(call) = step
            && let Some(wrong) = wire.is_output(call, &answer)
        {
            panic!("{wrong}");
        }
        let reported = Reported {
            tick: ticks[0] + u32::try_from(now - begin).unwrap(),
            code: answer.code,
            values: answer.values,
            reason: answer.reason,
        };
        found.push((reported, all));
    }
    let end = begin + u64::from(ticks[ticks.len() - 1] - ticks[0]);
    while wire.ticks < end {
        wire.turn();
    }
    wire.finish(trace);
    write(&wire.rows, path);
    found
}

impl Wire<'_> {
    /// What GetDac and GetDo report is what the machine outputs (SPEC 4).
    fn is_output(&self, call: &Call, answer: &Answer) -> Option<String> {
        let outputs = self.board.outputs();
        let expected: Vec<f64> = match (call.function.name, call.number("dac"), call.number("doType")) {
            ("GetDac", Some(dac @ 1..), _) => {
                outputs.analog.iter().skip(dac as usize - 1).map(|value| f64::from(*value)).collect()
            }
            ("GetDo", _, Some(12)) => vec![f64::from(outputs.general as u32)],
            _ => return None,
        };
        let differs =
            answer.code == 0 && answer.values.iter().zip(&expected).any(|(reported, output)| reported != output);
        differs.then(|| {
            format!(
                "{:?} {:?}: {:?} is reported, {expected:?} is output",
                call.function.name, call.values, answer.values
            )
        })
    }
}

fn write(rows: &[u8], path: &Path) {
    let mut reader = Reader::new();
    let mut csv = None;
    reader
        .feed(rows, |item| {
            match (item, &mut csv) {
                (Item::Header(header), csv) => {
                    *csv = Some(CsvWriter::new(std::io::BufWriter::new(std::fs::File::create(path)?), &header)?);
                }
                (Item::Row(row), Some(csv)) => csv.row(&row)?,
                _ => {}
            }
            Ok(())
        })
        .unwrap();
    csv.expect("a head").finish().unwrap();
}

/// Bytes of a field.
fn size(of: &str) -> usize {
    match of {
        "u8" => 1,
        "I16" | "U16" => 2,
        "I32" | "U32" => 4,
        "F64" | "U64" => 8,
        array => {
            let (of, count) = array.trim_matches(['[', ']']).split_once("; ").unwrap();
            size(of) * count.parse::<usize>().unwrap()
        }
    }
}

fn element(of: &str) -> (&str, usize) {
    match of.strip_prefix('[') {
        Some(array) => {
            let (of, count) = array.trim_end_matches(']').split_once("; ").unwrap();
            (of, count.parse().unwrap())
        }
        None => (of, 1),
    }
}

fn fields(layout: &[(&str, &str)], bytes: &mut &[u8]) -> Vec<Vec<f64>> {
    let mut number = |of: &str| {
        let (head, rest) = bytes.split_at(size(of));
        *bytes = rest;
        let mut wide = [0; 8];
        wide[..head.len()].copy_from_slice(head);
        let whole = u64::from_le_bytes(wide);
        match of {
            "F64" => f64::from_bits(whole),
            "I16" => f64::from(whole as i16),
            "I32" => f64::from(whole as i32),
            _ => whole as f64,
        }
    };
    layout.iter().map(|(_, of)| (0..element(of).1).map(|_| number(element(of).0)).collect()).collect()
}

fn put(body: &mut Vec<u8>, of: &str, text: &str) {
    let number: f64 = text.parse().unwrap_or_else(|_| panic!("{text} is no number"));
    let whole = number as i64;
    match size(of) {
        8 => body.extend(number.to_le_bytes()),
        length => body.extend(&whole.to_le_bytes()[..length]),
    }
}

/// The requests of a call, several where its items are more than a message holds.
fn requests(call: &Call) -> Result<Vec<Vec<u8>>, String> {
    let table = command(call.function).unwrap();
    let (mut values, mut lists, mut point) = (Vec::new(), Vec::new(), None);
    for (param, value) in call.function.params.iter().zip(&call.values) {
        match (param.pass, value) {
            (Pass::In(_), Value::Number(number)) => values.push(vec![number.clone()]),
            (Pass::Fixed(_, length), Value::List(list)) => values.push(list[..length].to_vec()),
            (Pass::Fixed(_, length), _) => values.push(vec!["0".to_owned(); length]),
            (Pass::Many(..), Value::List(list)) => lists.push(list.clone()),
            (Pass::Struct(of) | Pass::StructOrNull(of), Value::Fields(given)) => {
                let members: Vec<Vec<String>> = of
                    .fields()
                    .iter()
                    .map(|(name, _, count)| {
                        let mut elements = given
                            .iter()
                            .find(|(of, _)| of == name)
                            .map(|(_, values)| values.clone())
                            .unwrap_or_default();
                        elements.resize(*count, "0".to_owned());
                        elements
                    })
                    .collect();
                if call.function.shape == Shape::Point { point = Some(members) } else { values.extend(members) }
            }
            _ => {}
        }
    }
    let mut items = Vec::new();
    match call.function.shape {
        Shape::Points => {
            let count = lists.iter().map(Vec::len).min().unwrap_or(0);
            for n in 0..count {
                lists.iter().zip(table.items).for_each(|(list, (_, of))| put(&mut items, of, &list[n]));
            }
        }
        Shape::Grid => {
            lists.iter().skip(1).chain(&lists[..1]).flatten().for_each(|value| put(&mut items, "F64", value))
        }
        Shape::Point => {
            for (members, (_, of)) in point.iter().flatten().zip(table.items) {
                let (of, count) = element(of);
                members.iter().take(count).for_each(|value| put(&mut items, of, value));
            }
        }
        Shape::StartList => values = masks(&lists)?,
        Shape::Config => {
            let Some(Value::Text(file)) = call.values.first() else { panic!("a file is named") };
            let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples")).join(file);
            let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
            let found = job::config::read(file, &text).map_err(|error| error.to_string())?;
            values = vec![vec![found.items.len().to_string()]];
            items = zerocopy::IntoBytes::as_bytes(&found.items[..]).to_vec();
        }
        Shape::Plain | Shape::Host => {}
    }
    let each: usize = table.items.iter().map(|(_, of)| size(of)).sum();
    // A message is as long as every command takes it.
    let part = if call.function.shape == Shape::Config { usize::MAX } else { (ITEM_BYTES / each.max(1)).min(40) };
    let parts: Vec<&[u8]> =
        if items.is_empty() { vec![&[]] } else { items.chunks(each.saturating_mul(part)).collect() };
    let bodies = parts.iter().enumerate().map(|(number, items)| {
        let (mut body, mut values) = (Vec::new(), values.iter());
        for (name, of) in table.fields {
            match *name {
                "core" => put(&mut body, of, &call.core.unwrap_or(1).to_string()),
                "form" => put(&mut body, of, if call.core.is_some() { "0" } else { "1" }),
                "first" => put(&mut body, of, &(number * part).to_string()),
                "count" if call.function.reports_stop() => put(&mut body, of, "1"),
                name if name.ends_with("_given") => {
                    let reported =
                        call.function.params.iter().position(|param| Some(param.name) == call.function.reports_given);
                    let given = reported.is_some_and(|place| call.values[place] != Value::Null);
                    put(&mut body, of, if given { "1" } else { "0" });
                }
                _ => {
                    let (of, count) = element(of);
                    let values = values.next().unwrap_or_else(|| panic!("{}: {name}", call.function.name));
                    values.iter().take(count).for_each(|value| put(&mut body, of, value));
                }
            }
        }
        body.extend(*items);
        body
    });
    Ok(bodies.collect())
}

/// Axes and FIFOs as masks (SPEC 4).
fn masks(lists: &[Vec<String>]) -> Result<Vec<Vec<String>>, String> {
    let (mut mask, mut option) = (0i64, 0i64);
    for (axis, fifo) in lists[0].iter().zip(&lists[1]) {
        let (axis, fifo): (i64, i64) = (axis.parse().unwrap(), fifo.parse().unwrap());
        if !(1..=32).contains(&axis) || !(0..=1).contains(&fifo) {
            return Err(format!("axis {axis} with FIFO {fifo}"));
        }
        mask |= 1 << (axis - 1);
        option |= fifo << (axis - 1);
    }
    if lists[0].is_empty() {
        return Err("no axis".to_owned());
    }
    Ok(vec![vec![mask.to_string()], vec![option.to_string()]])
}
