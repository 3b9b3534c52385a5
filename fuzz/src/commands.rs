//! Requests by the table of the protocol: mostly such as a user might send, some with fields of any
//! bits.
//!
//! In: the row of a command, choices. Out: a packed body. What a field is like goes by its name, so
//! that a new command is in without a line here. With [`Range::Some`] nothing names axes 7 and 8 or
//! coordinate system 2, which are the model's.
use crate::source::Source;
use protocol::command::{COMMANDS, CommandInfo, PathMany, Request, fifo_offset};
use protocol::path_many::{HEAD_BYTES, head};
use protocol::record::BODY_MAX;
use zerocopy::FromBytes;

/// What requests may name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Everything that there is, and what there is not.
    All,
    /// Axes 1 to 6, coordinate system 1.
    Some,
}

impl Range {
    fn axes(self) -> i64 {
        if self == Range::All { 8 } else { 6 }
    }
}

/// Times that increase from request to request.
#[derive(Debug, Default)]
pub struct Clocks {
    pt: i64,
    table: f64,
}

/// Fields of which any value is harmless to what is the model's.
const HARMLESS: [&str; 16] = [
    "core",
    "channel",
    "fifo",
    "table",
    "kind",
    "count",
    "first",
    "percent",
    "percent1",
    "mode",
    "method",
    "event",
    "source",
    "coordinate",
    "power",
    "ratio",
];

/// A body for the command, of so many items.
pub fn body(info: &CommandInfo, items: usize, range: Range, clocks: &mut Clocks, from: &mut Source) -> Vec<u8> {
    let mut out = Vec::new();
    clocks.table = 0.0;
    for (name, kind) in info.fields {
        field(info.name, name, kind, items, range, clocks, from, &mut out);
    }
    if info.opcode == PathMany::OPCODE {
        joined(&mut out, items, range, clocks, from);
    } else if !info.items.is_empty() {
        for _ in 0..items {
            for (name, kind) in info.items {
                field(info.name, name, kind, items, range, clocks, from, &mut out);
            }
        }
    }
    out
}

/// Calls of a PathMany, most of them for its FIFO, and mostly as many as it says.
fn joined(out: &mut Vec<u8>, items: usize, range: Range, clocks: &mut Clocks, from: &mut Source) {
    let rows: Vec<&CommandInfo> = COMMANDS.iter().filter(|row| row.class.kind.joins()).collect();
    let own = PathMany::read_from_bytes(out).unwrap_or_default();
    let mut count = 0u16;
    for _ in 0..items {
        let row = rows[from.below(rows.len())];
        let mut request = body(row, from.below(2), range, clocks, from);
        if let Some(offset) = fifo_offset(row.opcode).filter(|_| !from.one_in(20)) {
            for (at, value) in [(0, own.core), (2, own.crd), (offset, own.fifo)] {
                request[at..at + 2].copy_from_slice(&value.to_bytes());
            }
        }
        if out.len() + HEAD_BYTES + request.len() > BODY_MAX {
            break;
        }
        out.extend(head((row.opcode, &request)));
        out.extend(request);
        count += 1;
    }
    if !from.one_in(20) {
        out[6..8].copy_from_slice(&count.to_le_bytes());
    }
}

/// Whether the command has items.
pub fn has_items(info: &CommandInfo) -> bool {
    !info.items.is_empty()
}

#[allow(clippy::too_many_arguments, reason = "a field is its place")]
fn field(
    command: &str,
    name: &str,
    kind: &str,
    items: usize,
    range: Range,
    clocks: &mut Clocks,
    from: &mut Source,
    out: &mut Vec<u8>,
) {
    // "[I16; 8]"
    let (kind, count) = match kind.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')?.split_once("; ")) {
        Some((kind, count)) => (kind, count.parse().unwrap_or(1)),
        None => (kind, 1),
    };
    for index in 0..count {
        let may_be_wild = range == Range::All || HARMLESS.contains(&name);
        let wild = may_be_wild && from.one_in(24);
        match kind {
            "F64" => {
                let value = if wild { from.wild_real() } else { real(name, clocks, from) };
                out.extend_from_slice(&value.to_le_bytes());
            }
            _ => {
                let value =
                    if wild { from.wild_integer() } else { integer(command, name, index, items, range, clocks, from) };
                let size = match kind {
                    "u8" => 1,
                    "I16" | "U16" => 2,
                    "I32" | "U32" => 4,
                    _ => 8,
                };
                out.extend_from_slice(&value.to_le_bytes()[..size]);
            }
        }
    }
}

fn real(name: &str, clocks: &mut Clocks, from: &mut Source) -> f64 {
    let byte = |from: &mut Source| f64::from(from.byte());
    match name {
        "pos" | "slave_segment" | "master_segment" | "x_center" | "y_center" | "z_center" | "center" | "radius" => {
            (f64::from(from.word()) - 32768.0) / 16.0
        }
        "time" => {
            clocks.table += (byte(from) + 1.0) / 4.0;
            clocks.table
        }
        "acc" | "dec" | "syn_acc" | "syn_acc_max" | "acc_max" | "smooth" | "abrupt" => byte(from) / 16.0 + 0.01,
        "vel_end" | "vel_begin" | "ratio" | "vel_begin_ratio" | "vel_end_ratio" => byte(from) / 64.0,
        "frequency" => f64::from(from.word()) / 32.0,
        "percent" | "percent1" | "power" | "max" | "duty" => byte(from) / 2.5,
        "min" => byte(from) / 50.0,
        "scale" => byte(from) * 8.0 + 1.0,
        _ => byte(from) / 4.0,
    }
}

fn integer(
    command: &str,
    name: &str,
    index: usize,
    items: usize,
    range: Range,
    clocks: &mut Clocks,
    from: &mut Source,
) -> i64 {
    let axes = range.axes();
    let byte = |from: &mut Source| i64::from(from.byte());
    let axis = |from: &mut Source| byte(from) % axes + 1;
    match (command, name) {
        ("Choose", "profile") => 0,
        ("SetCrdPrm", "profile") => match byte(from) {
            // Mostly one axis after the other.
            0..224 if (index as i64) < axes => [1, 2, 3, 0, 0, 0, 0, 0][index.min(7)],
            n if (index as i64) < axes => n % 5,
            _ => 0,
        },
        ("SetCrdPrm", "dimension") => byte(from) % 2 + 2,
        ("SetTick", _) => [125, 250, 500, 1000][from.below(4)],
        ("SetInterlock", "motion") => byte(from) % 4,
        ("SetLinkLoss", "time_ms") => byte(from) * 4,
        ("Trace", "over_link") => 0,
        (_, "core") => 1,
        (_, "profile" | "axis" | "encoder" | "control" | "master_index") => axis(from),
        (_, "crd") => byte(from) % if range == Range::All { 2 } else { 1 } + 1,
        (_, "channel" | "fifo" | "family" | "form") => byte(from) & 1,
        (_, "table") => byte(from) % 3 + 1,
        (_, "mask" | "option" | "axes" | "crds") if range == Range::Some => match name {
            // Bit 8 of a Stop is coordinate system 1, bit 0 of a CrdStart too.
            "crds" => byte(from) & 1,
            "mask" if command == "CrdStart" || command == "CrdStop" => byte(from) & 1,
            _ => byte(from) & 0x3f | if command == "Stop" { i64::from(from.byte() & 1) << 8 } else { 0 },
        },
        (_, "mask" | "option" | "axes" | "crds") => i64::from(from.word() & 0x3ff),
        (_, "count") if items > 0 => items as i64,
        (_, "count") if command.starts_with("Get") || command == "AxisStatus" || command == "PvtStatus" => {
            byte(from) % 8 + 1
        }
        ("ClrSts" | "ZeroPos", "count") => 1,
        (_, "count") => byte(from) % 64,
        (_, "first") => 0,
        ("PtData" | "PtDataMany", "time_ms") => {
            clocks.pt += byte(from) % 64 + 1;
            clocks.pt
        }
        (_, "loop_count") => byte(from) % 4,
        (_, "ns") => i64::from(from.word()) * 500,
        (_, "pos" | "x" | "y" | "z" | "a" | "master_segment" | "origin_pos" | "positive" | "negative") => {
            i64::from(from.word()) - 32768
        }
        (_, "delay_ms" | "delay_cycles" | "time_ms" | "smooth_time_ms" | "even_time_ms") => byte(from) % 50,
        (_, "width_us" | "on_delay_us" | "off_delay_us" | "time1_us" | "time2_us" | "laser_off_delay_us") => {
            i64::from(from.word()) % 2000
        }
        (_, "index") => byte(from) % 16 + 1,
        (_, "error" | "band" | "pos_err") => i64::from(from.word()),
        _ => byte(from) % 14,
    }
}
