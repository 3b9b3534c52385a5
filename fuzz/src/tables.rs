//! Tables of any numbers: PT, PVT of every kind, Follow, look-ahead paths, laser tables; and what
//! they make of the motion.
//!
//! In: which kind, points of any bits. Held: a table is taken or refused with a reason that names
//! what is wrong; what was taken runs within what [`crate::guard`] holds; nothing panics, nothing
//! wraps.
use crate::bench::{Bench, Line, size};
use crate::commands::{Clocks, Range, body};
use crate::scenes::scene;
use crate::source::Source;
use protocol::command::{COMMANDS, CommandInfo, opcode};
use protocol::record::Lane;
use virtual_board::{Config, Memory};

/// What carries tables.
const KINDS: [u16; 18] = [
    opcode::PtDataMany,
    opcode::PvtTable,
    opcode::PvtTableEx,
    opcode::PvtTableComplete,
    opcode::PvtTablePercent,
    opcode::PvtPercentCalculate,
    opcode::PvtTableContinuous,
    opcode::PvtContinuousCalculate,
    opcode::FollowData,
    opcode::FollowDataPercentEx,
    opcode::FollowDataPercent2Ex,
    opcode::GetFollowDataPercent2Ex,
    opcode::SetLaserFollowTable,
    opcode::SetLaserDisTable1D,
    opcode::SetLaserDisTable2D,
    opcode::LnXYMany,
    opcode::LnXYZMany,
    opcode::CrdData,
];

/// Ticks of an input at most.
const FUEL: u32 = 3000;

/// See the module text.
pub fn run(data: &[u8]) {
    let mut from = Source::new(data);
    let mut memory = Memory::new(Config { tick_us: [250, 50, 1000, 125][from.below(4)], ..Config::default() });
    let mut bench = Bench::new(&mut memory, Line::CLEAN);
    bench.open();
    for (number, body) in crate::scenes::ready() {
        bench.send(*number, Lane::Immediate, body.clone(), None);
    }
    bench.settle();
    let mut clocks = Clocks::default();
    let mut left = FUEL;
    while !from.is_empty() && left > 0 {
        match from.below(12) {
            0..5 => {
                let number = KINDS[from.below(KINDS.len())];
                let info = row(number);
                let items = from.below(40);
                let body = if from.one_in(2) {
                    body(info, items, Range::All, &mut clocks, &mut from)
                } else {
                    wild(info, items, &mut clocks, &mut from)
                };
                let lane = if from.one_in(6) { Lane::Program } else { Lane::Immediate };
                bench.send(number, lane, body, None);
            }
            5..8 => {
                for (number, body) in crate::scenes::starts(from.below(8)) {
                    bench.send(*number, Lane::Immediate, body.clone(), None);
                }
            }
            8 => {
                for (number, body) in scene(from.below(8)) {
                    bench.send(*number, Lane::Immediate, body.clone(), None);
                }
            }
            9 => bench.settle(),
            _ => {
                let count = (from.below(300) as u32).min(left);
                left -= count;
                bench.ticks(count);
            }
        }
    }
    bench.ticks(100);
    bench.settle();
}

fn row(number: u16) -> &'static CommandInfo {
    let row = COMMANDS.iter().find(|info| info.opcode == number);
    row.unwrap_or_else(|| panic!("{number:#06x} is a command"))
}

/// A body whose points are of any bits; what it is for is mostly right, so that they are looked at.
fn wild(info: &CommandInfo, items: usize, clocks: &mut Clocks, from: &mut Source) -> Vec<u8> {
    let mut bytes = body(info, items, Range::Some, clocks, from);
    let (fields, mut at) = if info.items.is_empty() { (info.fields, 0) } else { (info.items, size(info.fields)) };
    for _ in 0..if info.items.is_empty() { 1 } else { items } {
        for (_, kind) in fields {
            if (kind.contains("F64") || kind.contains("I32")) && !from.one_in(3) {
                point(&mut bytes, at, kind, from);
            }
            at += size(&[("", kind)]);
        }
    }
    bytes
}

fn point(bytes: &mut [u8], at: usize, kind: &str, from: &mut Source) {
    let real = kind.contains("F64");
    let place = bytes.get_mut(at..at + size(&[("", kind)])).unwrap_or_default();
    for place in place.chunks_mut(if real { 8 } else { 4 }) {
        let value = if real { from.wild_real().to_le_bytes() } else { from.wild_integer().to_le_bytes() };
        place.copy_from_slice(&value[..place.len()]);
    }
}
