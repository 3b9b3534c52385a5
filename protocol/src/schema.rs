//! The schema hash: a CRC-32 over every name, number, field and type that client and firmware must
//! agree on, computed by the compiler. Any change of a layout changes it.

use crate::command::{COMMANDS, CommandInfo, Wire};
use crate::frame::{Busy, CRC_BYTES, FLAG_READ_ONLY, Header, Hello, HelloAck, MAX_PAYLOAD, VERSION};
use crate::reason::{Code, REASONS, Reason, Refusal};
use crate::record::{JOB_RECORD, JobState, Lane, ReplyHead, RequestHead, TRACE_RECORD};
use crate::trace;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

type Fields = &'static [(&'static str, &'static str)];

const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// The hash that both ends send in the opening and in `Version`.
pub const SCHEMA: u32 = schema(LAYOUTS, COMMANDS, REASONS);

const LAYOUTS: &[(&str, Fields)] = &[
    ("Header", Header::FIELDS),
    ("Hello", Hello::FIELDS),
    ("HelloAck", HelloAck::FIELDS),
    ("Busy", Busy::FIELDS),
    ("RequestHead", RequestHead::FIELDS),
    ("ReplyHead", ReplyHead::FIELDS),
    ("Refusal", Refusal::FIELDS),
    ("JobState", JobState::FIELDS),
    ("TraceHead", trace::HeadLayout::FIELDS),
    ("TraceAxis", trace::AxisId::FIELDS),
    ("TraceLaser", trace::LaserId::FIELDS),
    ("TraceCrd", trace::CrdId::FIELDS),
    ("TraceRow", trace::RowLayout::FIELDS),
    ("TraceSample", trace::Sample::FIELDS),
    ("TraceLaserSample", trace::LaserSample::FIELDS),
    ("TraceCrdSample", trace::CrdSample::FIELDS),
    ("TraceAction", trace::Action::FIELDS),
    ("TraceOutputs", trace::Outputs::FIELDS),
    ("TracePeriod", trace::Period::FIELDS),
    ("TraceEnd", trace::EndLayout::FIELDS),
];

const fn schema(layouts: &[(&str, Fields)], commands: &[CommandInfo], reasons: &[(Reason, Code, &str)]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(&[VERSION, CRC_BYTES as u8]);
    digest.update(&(MAX_PAYLOAD as u32).to_le_bytes());
    digest.update(&TRACE_RECORD.to_le_bytes());
    digest.update(&JOB_RECORD.to_le_bytes());
    digest.update(&[FLAG_READ_ONLY]);
    digest.update(&[Lane::ProgramMayFail as u8]);
    let mut i = 0;
    while i < layouts.len() {
        word(&mut digest, layouts[i].0);
        fields(&mut digest, layouts[i].1);
        i += 1;
    }
    let mut i = 0;
    while i < commands.len() {
        let command = &commands[i];
        digest.update(&command.opcode.to_le_bytes());
        word(&mut digest, command.name);
        fields(&mut digest, command.fields);
        fields(&mut digest, command.items);
        fields(&mut digest, command.reply);
        fields(&mut digest, command.reply_items);
        i += 1;
    }
    let mut i = 0;
    while i < reasons.len() {
        let (reason, code, text) = reasons[i];
        digest.update(&(reason as u16).to_le_bytes());
        digest.update(&(code as i16).to_le_bytes());
        word(&mut digest, text);
        i += 1;
    }
    digest.finalize()
}

/// A text and its end.
const fn word(digest: &mut Digest<'_, u32, Table<1>>, text: &str) {
    digest.update(text.as_bytes());
    digest.update(&[0]);
}

const fn fields(digest: &mut Digest<'_, u32, Table<1>>, fields: Fields) {
    let mut i = 0;
    while i < fields.len() {
        word(digest, fields[i].0);
        word(digest, fields[i].1);
        i += 1;
    }
    digest.update(&[0]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn every_change_of_a_layout_changes_the_hash() {
        let mut seen = std::collections::BTreeSet::from([SCHEMA]);
        let mut changed = |layouts: &[(&str, Fields)], commands: &[CommandInfo], reasons: &[(Reason, Code, &str)]| {
            assert!(seen.insert(schema(layouts, commands, reasons)));
        };
        for i in 0..LAYOUTS.len() {
            let mut layouts = LAYOUTS.to_vec();
            layouts[i].1 = &[("another", "u8")];
            changed(&layouts, COMMANDS, REASONS);
        }
        let fields = |change: fn(&mut CommandInfo, Fields)| -> Vec<CommandInfo> {
            let mut commands = COMMANDS.to_vec();
            change(&mut commands[30], &[("another", "u8")]);
            commands
        };
        changed(LAYOUTS, &fields(|command, fields| command.fields = fields), REASONS);
        changed(LAYOUTS, &fields(|command, fields| command.items = fields), REASONS);
        changed(LAYOUTS, &fields(|command, fields| command.reply = fields), REASONS);
        changed(LAYOUTS, &fields(|command, fields| command.reply_items = fields), REASONS);
        changed(LAYOUTS, &fields(|command, _| command.opcode += 1), REASONS);
        changed(LAYOUTS, &fields(|command, _| command.name = "Another"), REASONS);
        changed(LAYOUTS, &COMMANDS[1..], REASONS);
        changed(LAYOUTS, COMMANDS, &REASONS[1..]);
        let mut reasons = REASONS.to_vec();
        reasons[0].1 = Code::State;
        changed(LAYOUTS, COMMANDS, &reasons);
    }
}
