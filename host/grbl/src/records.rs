//! Entries to records: lines of common speeds travel together, as `beamtick run` sends them.
//!
//! In: entries. Out: calls, each with the entries that it carries. A controller takes one record of
//! data in a tick.
use crate::entry::Entry;
use client::Call;
use protocol::command::{LnXY, LnXYMany, LnXYZ, LnXYZMany, PathXY, PathXYZ, Request};
use zerocopy::{FromBytes, IntoBytes};

/// Lines of a record, at most.
const LINES: usize = 40;

/// What lines of a record have in common, and where one of them leads.
enum Item {
    Flat([u64; 3], PathXY),
    Spatial([u64; 3], PathXYZ),
}

fn item(call: &Call) -> Option<Item> {
    let bits = |speeds: [f64; 3]| speeds.map(f64::to_bits);
    match call.opcode {
        LnXY::OPCODE => {
            let line = LnXY::read_from_bytes(&call.payload).ok()?;
            let speeds = bits([line.syn_vel.get(), line.syn_acc.get(), line.vel_end.get()]);
            Some(Item::Flat(speeds, PathXY { x: line.x, y: line.y }))
        }
        LnXYZ::OPCODE => {
            let line = LnXYZ::read_from_bytes(&call.payload).ok()?;
            let speeds = bits([line.syn_vel.get(), line.syn_acc.get(), line.vel_end.get()]);
            Some(Item::Spatial(speeds, PathXYZ { x: line.x, y: line.y, z: line.z }))
        }
        _ => None,
    }
}

/// The call of several lines.
fn many(entries: &[Entry]) -> Option<Call> {
    let items: Vec<Item> = entries.iter().map(|entry| item(&entry.call)).collect::<Option<_>>()?;
    let count = (entries.len() as u16).into();
    let (core, crd, fifo) = (1.into(), 1.into(), 0.into());
    let [syn_vel, syn_acc, vel_end] = match items.first()? {
        Item::Flat(speeds, _) | Item::Spatial(speeds, _) => speeds.map(|bits| f64::from_bits(bits).into()),
    };
    match items.first()? {
        Item::Flat(..) => {
            let lines: Vec<PathXY> = items
                .into_iter()
                .filter_map(|item| if let Item::Flat(_, to) = item { Some(to) } else { None })
                .collect();
            let mut payload = LnXYMany { core, crd, fifo, count, syn_vel, syn_acc, vel_end }.as_bytes().to_vec();
            payload.extend_from_slice(lines.as_bytes());
            Some(Call { opcode: LnXYMany::OPCODE, payload, may_fail: false })
        }
        Item::Spatial(..) => {
            let lines: Vec<PathXYZ> = items
                .into_iter()
                .filter_map(|item| if let Item::Spatial(_, to) = item { Some(to) } else { None })
                .collect();
            let mut payload = LnXYZMany { core, crd, fifo, count, syn_vel, syn_acc, vel_end }.as_bytes().to_vec();
            payload.extend_from_slice(lines.as_bytes());
            Some(Call { opcode: LnXYZMany::OPCODE, payload, may_fail: false })
        }
    }
}

/// Whether two entries are lines of the same kind and speeds.
fn alike(one: &Entry, other: &Entry) -> bool {
    match (item(&one.call), item(&other.call)) {
        (Some(Item::Flat(one, _)), Some(Item::Flat(other, _))) => one == other,
        (Some(Item::Spatial(one, _)), Some(Item::Spatial(other, _))) => one == other,
        _ => false,
    }
}

/// The records of these entries, in order, with their entries.
pub fn records(entries: Vec<Entry>) -> Vec<(Call, Vec<Entry>)> {
    let mut rows: Vec<Vec<Entry>> = Vec::new();
    for entry in entries {
        match rows.last_mut() {
            Some(row) if row.len() < LINES && alike(&row[0], &entry) => row.push(entry),
            _ => rows.push(vec![entry]),
        }
    }
    let call = |row: &Vec<Entry>| match &row[..] {
        [entry] => entry.call.clone(),
        row => many(row).unwrap_or_else(|| row[0].call.clone()),
    };
    rows.into_iter().map(|row| (call(&row), row)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entry::entries;

    #[test]
    fn lines_of_common_speeds_travel_together() {
        let lines: String = (1..=60).map(|n| format!("GT_LnXY(1, {n}, -{n}, 50, 2);\n")).collect();
        let other = "GT_LnXY(1, 9, 0, 60, 2);\nGT_LnXYZ(1, 1, 2, 3, 50, 2);\nGT_LnXYZ(1, 4, 5, 6, 50, 2);\n\
                     GT_BufLaserOn(1, 0, 0);\n";
        let found = records(entries(&format!("{lines}{other}"), 100).unwrap());
        let sizes: Vec<usize> = found.iter().map(|(_, row)| row.len()).collect();
        assert_eq!(sizes, [40, 20, 1, 2, 1]);
        let (head, items) = LnXYMany::read_from_prefix(&found[1].0.payload).unwrap();
        assert_eq!((head.count.get(), { head.syn_vel }.get(), items.len()), (20, 50.0, 160));
        let item = PathXY::read_from_bytes(&items[..8]).unwrap();
        assert_eq!((item.x.get(), item.y.get()), (41, -41));
        assert_eq!(found[2].0.opcode, LnXY::OPCODE);
        let (head, items) = LnXYZMany::read_from_prefix(&found[3].0.payload).unwrap();
        let item = PathXYZ::read_from_bytes(&items[12..]).unwrap();
        assert_eq!((head.count.get(), item.x.get(), item.z.get()), (2, 4, 6));
    }
}
