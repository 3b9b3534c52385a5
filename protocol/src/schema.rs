//! The schema hash: a CRC-32 over every name, number, field and type that client and firmware must
//! agree on, computed by the compiler. Any change of a layout changes it.

use crate::command::{COMMANDS, Wire};
use crate::frame::{CRC_BYTES, Header, Hello, HelloAck, MAX_PAYLOAD, VERSION};
use crate::reason::{REASONS, Refusal};
use crate::record::{ReplyHead, RequestHead};
use crate::trace;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

type Fields = &'static [(&'static str, &'static str)];

const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// The hash that both ends show in the opening and in `Version`.
pub const SCHEMA: u32 = schema();

const fn schema() -> u32 {
    let mut digest = CRC.digest();
    digest.update(&[VERSION, CRC_BYTES as u8]);
    digest.update(&(MAX_PAYLOAD as u32).to_le_bytes());
    let layouts: &[(&str, Fields)] = &[
        ("Header", Header::FIELDS),
        ("Hello", Hello::FIELDS),
        ("HelloAck", HelloAck::FIELDS),
        ("RequestHead", RequestHead::FIELDS),
        ("ReplyHead", ReplyHead::FIELDS),
        ("Refusal", Refusal::FIELDS),
        ("TraceHead", trace::HeadLayout::FIELDS),
        ("TraceAxis", trace::AxisId::FIELDS),
        ("TraceRow", trace::RowLayout::FIELDS),
        ("TraceSample", trace::Sample::FIELDS),
        ("TraceEnd", trace::EndLayout::FIELDS),
    ];
    let mut i = 0;
    while i < layouts.len() {
        word(&mut digest, layouts[i].0);
        fields(&mut digest, layouts[i].1);
        i += 1;
    }
    let mut i = 0;
    while i < COMMANDS.len() {
        let command = &COMMANDS[i];
        digest.update(&command.opcode.to_le_bytes());
        word(&mut digest, command.name);
        fields(&mut digest, command.fields);
        fields(&mut digest, command.items);
        fields(&mut digest, command.reply);
        fields(&mut digest, command.reply_items);
        i += 1;
    }
    let mut i = 0;
    while i < REASONS.len() {
        let (reason, code, text) = REASONS[i];
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
