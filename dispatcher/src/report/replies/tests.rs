extern crate std;

use super::took_reply;
use protocol::command::{COMMANDS, widths};
use protocol::record::{ReplyWriter, replies};
use std::vec::Vec;

/// How many values the reply of a row has, an array as its elements.
fn values(fields: &[(&str, &str)]) -> usize {
    fields.iter().filter(|(name, _)| *name != "held").map(|(_, of)| if of.starts_with('[') { 4 } else { 1 }).sum()
}

#[test]
fn what_was_taken_has_the_layout_of_its_row() {
    let mut seen = 0;
    for row in COMMANDS {
        if row.class.kind.reads() || row.reply.last().is_none_or(|(name, _)| *name != "held") {
            continue;
        }
        let count = values(row.reply).max(1);
        let mut buffer = [0; 64];
        let mut out = ReplyWriter::new(&mut buffer);
        took_reply(row.opcode, 7, [1.0, 2.0, 3.0, 4.0].into_iter(), (count as u8, 5), &mut out).unwrap();
        let length = out.len();
        let reply = replies(&buffer[..length]).next().unwrap().unwrap();
        assert_eq!((reply.opcode, reply.tag, reply.body.len()), (row.opcode, 7, widths(row.reply)), "{}", row.name);
        let mut expected = Vec::new();
        for (number, (_, of)) in (1u8..).zip(row.reply) {
            match *of {
                "u8" => expected.push(5),
                "U16" => expected.extend(u16::from(number).to_le_bytes()),
                "U32" => expected.extend(u32::from(number).to_le_bytes()),
                "F64" => expected.extend(f64::from(number).to_le_bytes()),
                _ => expected.extend([1.0f64, 2.0, 3.0, 4.0].map(f64::to_le_bytes).concat()),
            }
        }
        assert_eq!(reply.body, expected, "{}", row.name);
        seen += 1;
    }
    assert_eq!(seen, 19);
}
