//! Points of tables, and axes of a configuration, in records: a call has all of them, a message
//! holds a few dozen.
//!
//! In: a call. Out: calls that follow each other, each with the index of its first point, or the
//! number of its axes. Calls of other commands stay as they are.
use client::Call;
use protocol::command::{ConfigItem, LoadConfig, Request, info, widths};
use protocol::record::{BODY_MAX, ITEM_BYTES};
use zerocopy::{FromBytes, IntoBytes};

/// Whether a message has room for a request with its items, whichever it is.
pub fn is_record(payload: &[u8]) -> bool {
    payload.len() <= ITEM_BYTES.min(BODY_MAX)
}

/// Head, point, and offset of `first` of a command that carries points: it has such a field.
fn layout(number: u16) -> Option<(usize, usize, usize)> {
    let command = info(number)?;
    let place = command.fields.iter().position(|(name, _)| *name == "first")?;
    Some((widths(command.fields), widths(command.items), widths(command.fields.get(..place)?)))
}

/// A configuration of many axes as several of fewer. Each is refused or loaded as a whole.
fn configurations(call: Call) -> Vec<Call> {
    let Ok((head, items)) = LoadConfig::read_from_prefix(&call.payload) else { return vec![call] };
    let each = ITEM_BYTES / size_of::<ConfigItem>();
    if items.len() <= each * size_of::<ConfigItem>() {
        return vec![call];
    }
    let record = |part: &[u8]| {
        let head = LoadConfig { count: ((part.len() / size_of::<ConfigItem>()) as u16).into(), ..head };
        Call { opcode: call.opcode, payload: [head.as_bytes(), part].concat(), may_fail: call.may_fail }
    };
    items.chunks(each * size_of::<ConfigItem>()).map(record).collect()
}

/// A call whose items go in one message. More than a message holds are more than its count may be:
/// those that fit go along, and the controller refuses the count.
fn whole(mut call: Call) -> Call {
    if let Some(command) = info(call.opcode)
        && let item @ 1.. = widths(command.items)
        && call.payload.len() > BODY_MAX
    {
        let head = widths(command.fields);
        let room = ITEM_BYTES.min(BODY_MAX.saturating_sub(head));
        call.payload.truncate(head + room / item * item);
    }
    call
}

/// The records of a call.
pub fn records(call: Call) -> Vec<Call> {
    if is_record(&call.payload) {
        return vec![call];
    }
    if call.opcode == LoadConfig::OPCODE {
        return configurations(call);
    }
    let Some((head, point, first)) = layout(call.opcode) else { return vec![whole(call)] };
    let Some((head, points)) = call.payload.split_at_checked(head) else { return vec![call] };
    // What a long head leaves of a message.
    let room = ITEM_BYTES.min(BODY_MAX.saturating_sub(head.len()));
    if points.len() <= room {
        return vec![call];
    }
    let each = room / point;
    let record = |(number, part): (usize, &[u8])| {
        let mut payload = [head, part].concat();
        let index = u16::try_from(number * each).unwrap_or(u16::MAX);
        payload[first..first + 2].copy_from_slice(&index.to_le_bytes());
        Call { opcode: call.opcode, payload, may_fail: call.may_fail }
    };
    points.chunks(each * point).enumerate().map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::{
        LaserDisValue, PvtContinuousCalculate, PvtContinuousPoint, PvtPoint, PvtTable, Request, SetDac,
        SetLaserDisTable2D, Short,
    };
    use zerocopy::FromBytes;

    #[test]
    fn every_layout_is_that_of_its_structs() {
        let continuous = (size_of::<PvtContinuousCalculate>(), size_of::<PvtContinuousPoint>(), 6);
        assert_eq!(layout(PvtContinuousCalculate::OPCODE), Some(continuous));
        let plane = (size_of::<SetLaserDisTable2D>(), size_of::<LaserDisValue>(), 45);
        assert_eq!(layout(SetLaserDisTable2D::OPCODE), Some(plane));
    }

    #[test]
    fn a_record_of_any_table_fits_in_a_message() {
        let mut tables = 0;
        for command in protocol::command::COMMANDS {
            let Some((head, point, _)) = layout(command.opcode) else { continue };
            tables += 1;
            for points in [1, ITEM_BYTES / point, ITEM_BYTES / point + 1, 300] {
                let payload = vec![0; head + points * point];
                let found = records(Call { opcode: command.opcode, payload, may_fail: false });
                let carried: usize = found.iter().map(|call| (call.payload.len() - head) / point).sum();
                assert_eq!(carried, points, "{}", command.name);
                for call in found {
                    assert!(call.payload.len() <= BODY_MAX, "{}: {} bytes", command.name, call.payload.len());
                }
            }
        }
        assert_eq!(tables, 10);
    }

    #[test]
    fn items_of_one_message_are_those_that_fit() {
        let values = vec![Short { value: 7.into() }; 1024];
        let head = |count: u16| SetDac { core: 1.into(), dac: 1.into(), count: count.into() };
        let long = Call::with_items(head(1024), &values);
        let found = records(long);
        assert_eq!(found.len(), 1);
        assert!(found[0].payload.len() <= BODY_MAX, "{} bytes", found[0].payload.len());
        let (sent, rest) = SetDac::read_from_prefix(&found[0].payload).unwrap();
        assert_eq!((sent.count.get(), rest.len() % size_of::<Short>()), (1024, 0));
        let short = Call::with_items(head(8), &values[..8]);
        assert_eq!(records(short.clone()), [short]);
    }

    #[test]
    fn a_configuration_of_many_axes_travels_in_pieces() {
        let items: Vec<ConfigItem> =
            (1..=24).map(|axis: i16| ConfigItem { axis: axis.into(), ..ConfigItem::default() }).collect();
        let whole = Call::with_items(LoadConfig { core: 2.into(), count: 24.into() }, &items);
        assert!(whole.payload.len() > 1000, "it would fit: {}", whole.payload.len());
        let mut axes = Vec::new();
        for call in records(whole) {
            assert!(call.payload.len() <= 1000, "a record fits in a message");
            let (head, rest) = LoadConfig::read_from_prefix(&call.payload).unwrap();
            let part = <[ConfigItem]>::ref_from_bytes(rest).unwrap();
            assert_eq!((head.core.get(), usize::from(head.count.get())), (2, part.len()));
            axes.extend(part.iter().map(|item| item.axis.get()));
        }
        assert_eq!(axes, (1..=24).collect::<Vec<i16>>());
        let few = Call::with_items(LoadConfig { core: 1.into(), count: 8.into() }, &items[..8]);
        assert_eq!(records(few.clone()), [few]);
    }

    #[test]
    fn a_long_table_travels_in_records_that_begin_where_the_one_before_ended() {
        let head = PvtTable { core: 1.into(), table: 3.into(), count: 100.into(), first: 0.into() };
        let points: Vec<PvtPoint> =
            (0..100u16).map(|n| PvtPoint { time: f64::from(n).into(), pos: 2.0.into(), vel: 3.0.into() }).collect();
        let found = records(Call::with_items(head, &points));
        let mut next = 0;
        for call in &found {
            assert!(call.payload.len() <= 1017, "a record fits in a message");
            let (head, rest) = PvtTable::read_from_prefix(&call.payload).unwrap();
            assert_eq!((head.table.get(), head.count.get(), usize::from(head.first.get())), (3, 100, next));
            let points = <[PvtPoint]>::ref_from_bytes(rest).unwrap();
            assert_eq!(points[0].time.get(), next as f64);
            next += points.len();
        }
        assert_eq!((next, found.len()), (100, 3));
        let short = Call::with_items(head, &points[..2]);
        assert_eq!(records(short.clone()), [short]);
    }
}
