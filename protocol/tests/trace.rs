//! The trace stream: what is sent comes back, and what is missing is reported.

use protocol::trace::{AxisId, Decoder, Encoder, Event, Full, Head, MAX_AXES, Sample, TraceError};

fn sample(row: u32, axis: usize) -> Sample {
    let value = i64::from(row) * 1_000 - axis as i64;
    Sample { pos: value.into(), vel_mantissa: (-value << 30).into(), vel_exponent: (axis as i16).into() }
}

/// A trace of some rows of some axes, frame by frame.
fn frames(rows: u32, axes: usize, lost: u32) -> Vec<Vec<u8>> {
    let ids: Vec<AxisId> =
        (0..axes).map(|axis| AxisId { core: (axis / 32) as u8, axis: (axis % 32 + 1) as u8 }).collect();
    let mut encoder = Encoder::new();
    let mut wire = Vec::new();
    let mut out = [0; 100];
    encoder.head(&Head { schema: 5, period_ns: 50_000, every: 2 }, &ids).unwrap();
    let mut drain = |encoder: &mut Encoder| {
        while !encoder.is_empty() {
            let length = encoder.take(&mut out);
            wire.extend(&out[..length]);
        }
    };
    for row in 0..rows {
        let samples: Vec<Sample> = (0..axes).map(|axis| sample(row, axis)).collect();
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
    let mut decoder = Decoder::new();
    let (mut rows, mut errors) = (0, Vec::new());
    for part in wire.chunks(13) {
        decoder.feed(part, |event| match event {
            Ok(Event::Row(row, samples)) => {
                assert!(samples.iter().eq((0..axes).map(|axis| sample(row, axis))));
                rows += 1;
            }
            Ok(Event::Head(head, list)) => {
                assert_eq!((head, list.len()), (Head { schema: 5, period_ns: 50_000, every: 2 }, axes));
            }
            Ok(Event::End { .. }) => {}
            Err(error) => errors.push(error),
        });
    }
    (rows, errors, decoder.ended())
}

#[test]
fn rows_come_back_for_any_number_of_axes() {
    for axes in [0, 1, 8, 63, MAX_AXES] {
        assert_eq!(read(&frames(500, axes, 0).concat(), axes), (500, vec![], true), "{axes} axes");
    }
}

#[test]
fn several_rows_share_a_frame() {
    // 22 bytes a row, 1280 a body: 58 rows; head and end.
    assert_eq!(frames(580, 1, 0).len(), 12);
}

#[test]
fn a_missing_frame_is_an_error() {
    let mut all = frames(580, 1, 0);
    all.remove(3);
    assert_eq!(read(&all.concat(), 1), (522, vec![TraceError::Missing { expected: 116, came: 174 }], true));
    // The last rows are missed at the end.
    let mut all = frames(580, 1, 0);
    all.remove(10);
    assert_eq!(read(&all.concat(), 1), (522, vec![TraceError::Missing { expected: 522, came: 580 }], true));
}

#[test]
fn a_damaged_frame_is_an_error() {
    let mut all = frames(580, 1, 0);
    all[3][20] ^= 0x40;
    let (rows, errors, ended) = read(&all.concat(), 1);
    assert_eq!((rows, ended), (522, true));
    assert_eq!(errors, [TraceError::BadFrame, TraceError::Missing { expected: 116, came: 174 }]);
}

#[test]
fn lost_rows_a_missing_head_and_a_missing_end_are_seen() {
    assert_eq!(read(&frames(10, 2, 3).concat(), 2), (10, vec![TraceError::Lost(3)], true));
    let all = frames(10, 2, 0);
    assert_eq!(read(&all[1..].concat(), 2), (0, vec![TraceError::Unexpected; 2], false));
    assert_eq!(read(&all[..2].concat(), 2), (10, vec![], false));
}
