//! Entries to records: long runs of lines of common speeds travel together, and so does whatever
//! else comes in a row, as `beamtick run` sends them.
//!
//! In: entries. Out: calls, each with the entries that it carries; from the reply of one those of
//! its entries. A controller takes one record of data in a tick.
use crate::entry::Entry;
use client::joined::{Group, Offer, split_replies};
use client::{Call, Error};
use protocol::command::{LnXY, LnXYMany, LnXYZ, LnXYZMany, PathXY, PathXYZ, Request};
use zerocopy::{FromBytes, IntoBytes};

/// Lines of a record of common speeds, at most and at least. So few are no shorter than single
/// calls that are joined.
const JOINED_MAX_LINES: usize = 80;
const JOINED_MIN_LINES: usize = 24;

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

/// A record: what is sent, and the entries that it carries.
pub struct Record {
    /// What is sent.
    pub call: Call,
    /// What it carries.
    pub entries: Vec<Entry>,
    /// They are joined: each has a reply of its own.
    pub joined: bool,
}

impl Record {
    /// The replies of its entries, in order, up to the first refusal. Lines of common speeds have
    /// one reply together.
    ///
    /// # Errors
    /// A reply that is none.
    pub fn replies(&self, code: i16, payload: Vec<u8>) -> Result<Vec<(i16, Vec<u8>)>, Error> {
        if !self.joined {
            return Ok(vec![(code, payload); if code == 0 { self.entries.len() } else { 1 }]);
        }
        let calls: Vec<Call> = self.entries.iter().map(|entry| entry.call.clone()).collect();
        split_replies(&calls, code, &payload).map(|apart| apart.replies)
    }
}

/// The records of these entries, in order.
pub fn records(entries: Vec<Entry>) -> Vec<Record> {
    let mut records = Vec::new();
    let mut rest = entries;
    while let Some(first) = rest.first() {
        let run = rest.iter().take(JOINED_MAX_LINES).take_while(|entry| alike(first, entry)).count();
        let group = (run < JOINED_MIN_LINES).then(|| Group::at_once(&first.call)).flatten();
        let (call, count) = match group {
            Some(mut group) => {
                while let Some(entry) = rest.get(group.count())
                    && group.offer(&entry.call, usize::MAX) == Offer::Taken
                {}
                let count = group.count();
                (if count > 1 { Some(group.call()) } else { None }, count.max(1))
            }
            None if run > 1 => (many(&rest[..run]), run),
            None => (None, 1),
        };
        let after = rest.split_off(count);
        let entries = std::mem::replace(&mut rest, after);
        let joined = count > 1 && run < JOINED_MIN_LINES;
        let call = call.unwrap_or_else(|| entries[0].call.clone());
        records.push(Record { call, entries, joined });
    }
    records
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entry::entries;
    use protocol::command::{BufLaserOn, PathMany};

    #[test]
    fn lines_of_common_speeds_travel_together() {
        let lines: String = (1..=104).map(|n| format!("GT_LnXY(1, {n}, -{n}, 50, 2);\n")).collect();
        let spatial: String = (1..=30).map(|n| format!("GT_LnXYZ(1, {n}, 2, {n}, 50, 2);\n")).collect();
        let found = records(entries(&format!("{lines}{spatial}GT_BufLaserOn(1, 0, 0);\n"), 100).unwrap());
        let sizes: Vec<usize> = found.iter().map(|record| record.entries.len()).collect();
        assert_eq!(sizes, [80, 24, 30, 1]);
        let (head, items) = LnXYMany::read_from_prefix(&found[1].call.payload).unwrap();
        assert_eq!((head.count.get(), { head.syn_vel }.get(), items.len()), (24, 50.0, 192));
        let item = PathXY::read_from_bytes(&items[..8]).unwrap();
        assert_eq!((item.x.get(), item.y.get()), (81, -81));
        let (head, items) = LnXYZMany::read_from_prefix(&found[2].call.payload).unwrap();
        let item = PathXYZ::read_from_bytes(&items[12..24]).unwrap();
        assert_eq!((head.count.get(), item.x.get(), item.z.get()), (30, 2, 2));
        assert_eq!(found[3].call.opcode, BufLaserOn::OPCODE);
        assert_eq!(found[1].replies(0, vec![1]).unwrap(), vec![(0, vec![1]); 24]);
        assert_eq!(found[1].replies(7, vec![1]).unwrap(), vec![(7, vec![1])]);
    }

    #[test]
    fn lines_with_powers_of_their_own_travel_together() {
        let lines: String =
            (1..=50).map(|n| format!("GT_BufLaserPrfCmd(1, {n}, 0, 0);\nGT_LnXY(1, {n}, -{n}, 50, 2);\n")).collect();
        let text = format!("{lines}GT_LnXY(1, 60, 0, 50, 2);\nGT_BufDelay(1, 20);\nGT_BufLaserOff(1, 0, 0);\n");
        let all = entries(&text, 100).unwrap();
        let found = records(all.clone());
        let sizes: Vec<usize> = found.iter().map(|record| record.entries.len()).collect();
        // With its head a power has 20 bytes, a line 42; 960 are joined. A record that begins with
        // a line has no room for the sixteenth.
        assert_eq!(sizes, [31, 30, 30, 12]);
        assert!(found.iter().all(|record| record.call.opcode == PathMany::OPCODE));
        let sent: Vec<Call> = found.iter().flat_map(|record| &record.entries).map(|entry| entry.call.clone()).collect();
        assert_eq!(sent, all.into_iter().map(|entry| entry.call).collect::<Vec<_>>());
        let (head, _) = PathMany::read_from_prefix(&found[3].call.payload).unwrap();
        assert_eq!(head.count.get(), 12);
    }
}
