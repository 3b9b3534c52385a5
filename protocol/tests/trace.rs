//! The trace stream: what is sent comes back, and what is missing is reported.

use protocol::trace::{
    Action, AxisId, Columns, Count, CrdId, CrdSample, Decoder, Encoder, Full, Ids, LaserId, LaserSample, MAX_AXES,
    MAX_CRDS, MAX_LASERS, Outputs, Sample, Samples, TraceError, TraceEvent, TraceHead, kind,
};

const HEAD: TraceHead = TraceHead { schema: 5, period_ns: 50_000, every: 2, timer_mhz: 1000 };

fn sample(row: u32, axis: usize) -> Sample {
    let value = i64::from(row) * 1_000 - axis as i64;
    Sample { pos: value.into(), vel_mantissa: (-value << 30).into(), vel_exponent: (axis as i16).into() }
}

fn laser_sample(row: u32, laser: usize) -> LaserSample {
    LaserSample { mode: laser as u8 & 3, gate: row as u8 & 1, power: i64::from(row).into(), khz: (1 << 40).into() }
}

fn crd_sample(row: u32, crd: usize) -> CrdSample {
    CrdSample { vel_mantissa: (i64::from(row) << 40).into(), vel_exponent: (crd as i16).into() }
}

fn levels(row: u32) -> Outputs {
    Outputs { tick: (2 * row).into(), at: 12.into(), levels: (!u64::from(row)).into() }
}

fn laser_action(row: u32) -> Action {
    let count = |whole: u64| Count { whole: whole.into(), part: 1.into(), of: 3.into() };
    Action {
        tick: (2 * row).into(),
        at: 77.into(),
        channel: 1,
        kind: kind::LIGHT,
        value: (-5).into(),
        period: count(row.into()),
        width: count(0),
    }
}

/// A trace of some rows of some axes, frame by frame.
fn frames(rows: u32, axes: usize, lost: u32) -> Vec<Vec<u8>> {
    frames_of(rows, (axes, 0, 0), false, lost)
}

/// The same with lasers and coordinate systems; `between`: an action and levels before each row.
fn frames_of(rows: u32, (axes, lasers, crds): (usize, usize, usize), between: bool, lost: u32) -> Vec<Vec<u8>> {
    let systems: Vec<CrdId> = (0..crds).map(|crd| CrdId { core: (crd / 2) as u8, crd: (crd % 2 + 1) as u8 }).collect();
    let channels: Vec<LaserId> = (0..lasers).map(|channel| LaserId { channel: channel as u8 }).collect();
    let ids: Vec<AxisId> =
        (0..axes).map(|axis| AxisId { core: (axis / 32) as u8, axis: (axis % 32 + 1) as u8 }).collect();
    let mut encoder = Encoder::new();
    let mut wire = Vec::new();
    let mut out = [0; 100];
    encoder.head(&HEAD, &Ids { axes: &ids, lasers: &channels, crds: &systems }).unwrap();
    let mut drain = |encoder: &mut Encoder| {
        while !encoder.is_empty() {
            let length = encoder.take(&mut out);
            wire.extend(&out[..length]);
        }
    };
    for row in 0..rows {
        let samples: Vec<Sample> = (0..axes).map(|axis| sample(row, axis)).collect();
        let lasers: Vec<LaserSample> = (0..lasers).map(|laser| laser_sample(row, laser)).collect();
        let crds: Vec<CrdSample> = (0..crds).map(|crd| crd_sample(row, crd)).collect();
        if between && encoder.action(&laser_action(row)) == Err(Full) {
            drain(&mut encoder);
            encoder.action(&laser_action(row)).unwrap();
        }
        if between && encoder.outputs(&levels(row)) == Err(Full) {
            drain(&mut encoder);
            encoder.outputs(&levels(row)).unwrap();
        }
        let samples = Samples { axes: &samples, lasers: &lasers, crds: &crds };
        if encoder.row(row, &samples) == Err(Full) {
            drain(&mut encoder);
            encoder.row(row, &samples).unwrap();
        }
    }
    while encoder.end(rows, lost) == Err(Full) {
        drain(&mut encoder);
    }
    drain(&mut encoder);
    wire.split_inclusive(|&byte| byte == 0).map(<[u8]>::to_vec).collect()
}

/// Rows that came whole, errors, and whether the end came.
fn read(wire: &[u8], axes: usize) -> (u32, Vec<TraceError>, bool) {
    let (rows, between, errors, ended) = read_of(wire, (axes, 0, 0));
    assert_eq!(between, 0);
    (rows, errors, ended)
}

/// The same with lasers and coordinate systems, and the actions and levels that came.
fn read_of(wire: &[u8], (axes, lasers, crds): (usize, usize, usize)) -> (u32, u32, Vec<TraceError>, bool) {
    let mut decoder = Decoder::new();
    let (mut rows, mut between, mut errors) = (0, 0, Vec::new());
    for part in wire.chunks(13) {
        decoder.feed(part, |event| match event {
            Ok(TraceEvent::Row(row, samples)) => {
                assert!(samples.axes.iter().eq((0..axes).map(|axis| sample(row, axis))));
                assert!(samples.lasers.iter().eq((0..lasers).map(|laser| laser_sample(row, laser))));
                assert!(samples.crds.iter().eq((0..crds).map(|crd| crd_sample(row, crd))));
                rows += 1;
            }
            Ok(TraceEvent::Action(action)) => {
                assert_eq!(action, laser_action(between / 2));
                between += 1;
            }
            Ok(TraceEvent::Outputs(outputs)) => {
                assert_eq!(outputs, levels(between / 2));
                between += 1;
            }
            Ok(TraceEvent::Head(head, Columns { axes: list, lasers: channels, crds: systems })) => {
                assert_eq!((head, list.len(), systems.len()), (HEAD, axes, crds));
                assert!(channels.iter().map(|id| id.channel).eq(0..lasers as u8));
                assert!(
                    systems.iter().enumerate().all(|(n, id)| usize::from(id.core) * 2 + usize::from(id.crd) == n + 1)
                );
            }
            Ok(TraceEvent::Period(_)) => panic!("the tick did not change"),
            Ok(TraceEvent::Zero(_)) => panic!("nothing was renamed"),
            Ok(TraceEvent::End { .. }) => {}
            Err(error) => errors.push(error),
        });
    }
    (rows, between, errors, decoder.ended())
}

#[test]
fn rows_come_back_for_any_number_of_axes() {
    for axes in [0, 1, 8, 63, MAX_AXES] {
        assert_eq!(read(&frames(500, axes, 0).concat(), axes), (500, vec![], true), "{axes} axes");
    }
}

#[test]
fn lasers_and_paths_come_after_the_axes_and_what_is_reported_before_its_row() {
    for columns in [(0, 1, 0), (8, 2, 4), (0, 0, 1), (MAX_AXES, MAX_LASERS, MAX_CRDS)] {
        let wire = frames_of(100, columns, true, 0).concat();
        assert_eq!(read_of(&wire, columns), (100, 200, vec![], true), "{columns:?}");
    }
}

#[test]
fn several_rows_share_a_frame() {
    // 23 bytes a row, 1383 a body after its kind: 60 rows; head and end.
    assert_eq!(frames(600, 1, 0).len(), 12);
}

#[test]
fn a_missing_frame_is_an_error() {
    let mut all = frames(600, 1, 0);
    all.remove(3);
    assert_eq!(read(&all.concat(), 1), (540, vec![TraceError::Missing { expected: 120, came: 180 }], true));
    // The last rows are missed at the end.
    let mut all = frames(600, 1, 0);
    all.remove(10);
    assert_eq!(read(&all.concat(), 1), (540, vec![TraceError::Missing { expected: 540, came: 600 }], true));
}

#[test]
fn a_damaged_frame_is_an_error() {
    let mut all = frames(600, 1, 0);
    all[3][20] ^= 0x40;
    let (rows, errors, ended) = read(&all.concat(), 1);
    assert_eq!((rows, ended), (540, true));
    assert_eq!(errors, [TraceError::BadFrame, TraceError::Missing { expected: 120, came: 180 }]);
}

#[test]
fn lost_rows_a_missing_head_and_a_missing_end_are_seen() {
    assert_eq!(read(&frames(10, 2, 3).concat(), 2), (10, vec![TraceError::Lost(3)], true));
    let all = frames(10, 2, 0);
    assert_eq!(read(&all[1..].concat(), 2), (0, vec![TraceError::Unexpected; 2], false));
    assert_eq!(read(&all[..2].concat(), 2), (10, vec![], false));
}
