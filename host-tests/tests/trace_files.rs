//! Trace files against what a person can work out by hand.
use servo::piece::Scaled;
use servo::units::Pos;
use std::path::PathBuf;
use trace::{
    AxisName, AxisPoint, CsvWriter, Header, Item, OutputEdge, Plot, PlotOptions, Reader, Row, TraceError, VcdWriter,
};

const PULSE: i64 = 1 << 22;

fn axis(axis: u8) -> AxisName {
    AxisName { core: 1, axis }
}

fn row(index: u32, row_ns: u64, points: &[(i64, Scaled)]) -> Row {
    let axes = points.iter().map(|&(pos, vel)| AxisPoint { pos: Pos(pos), vel }).collect();
    Row { index, t_ns: u64::from(index) * row_ns, axes, lasers: Vec::new() }
}

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn csv_is_what_the_specification_shows() {
    let header = Header {
        axes: vec![axis(1), axis(3), AxisName { core: 2, axis: 1 }],
        lasers: vec![],
        period_ns: 250_000,
        every: 2,
    };
    let mut out = Vec::new();
    let mut csv = CsvWriter::new(&mut out, &header).unwrap();
    let zero = Scaled::default();
    csv.row(&row(0, header.row_ns(), &[(0, zero), (-PULSE, zero), (0, zero)])).unwrap();
    csv.row(&row(
        1,
        header.row_ns(),
        &[
            (PULSE / 4, Scaled { m: 1, e: 1 }),
            (-PULSE - 1, Scaled { m: -3, e: 2 }),
            (4096 * PULSE, Scaled { m: 2, e: 0 }),
        ],
    ))
    .unwrap();
    csv.finish().unwrap();
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "t_ms,axis1_pos,axis1_vel,axis3_pos,axis3_vel,core2_axis1_pos,core2_axis1_vel\n\
         0.000000,0.000000,0.000000,-1.000000,0.000000,0.000000,0.000000\n\
         0.500000,0.250000,0.500000,-1.000000,-0.750000,4096.000000,2.000000\n"
    );
}

/// Changes of one wire: time and value.
fn changes(vcd: &[u8], name: &str) -> Vec<(u64, bool)> {
    let mut parser = vcd::Parser::new(vcd);
    let header = parser.parse_header().unwrap();
    assert_eq!(header.timescale, Some((1, vcd::TimescaleUnit::NS)));
    let code = header.find_var(&["beamtick", name]).unwrap_or_else(|| panic!("no wire {name}")).code;
    let mut now = 0;
    let mut found = Vec::new();
    for command in parser {
        match command.unwrap() {
            vcd::Command::Timestamp(t) => {
                assert!(t >= now, "time goes back from {now} to {t}");
                now = t;
            }
            vcd::Command::ChangeScalar(id, value) if id == code => found.push((now, value == vcd::Value::V1)),
            _ => {}
        }
    }
    found
}

#[test]
fn vcd_shows_every_step_once_and_evenly() {
    let header = Header { axes: vec![axis(1), axis(2)], lasers: vec![], period_ns: 1_000_000, every: 1 };
    let mut out = Vec::new();
    let mut vcd = VcdWriter::new(&mut out, &header, &[(1, true), (4, false)]).unwrap();
    let still = Scaled::default();
    // Axis 1: 4 pulses, then 3 back. Axis 2 stays at 7.4, which is pulse 7.
    let rest = 7 * PULSE + PULSE * 2 / 5;
    for (index, pulses) in [0, 4, 4, 1].into_iter().enumerate() {
        if index == 2 {
            vcd.edge(OutputEdge { t_ns: 1_500_000, output: 1, level: false });
            vcd.edge(OutputEdge { t_ns: 1_500_000, output: 9, level: true });
        }
        vcd.row(&row(index as u32, header.row_ns(), &[(pulses * PULSE, still), (rest, still)])).unwrap();
    }
    vcd.edge(OutputEdge { t_ns: 3_000_000, output: 4, level: true });
    vcd.finish().unwrap();
    let rising = |name| changes(&out, name).into_iter().filter(|c| c.1).map(|c| c.0).collect::<Vec<_>>();
    // 4 pulses in 1 ms, centred: the middle of each quarter is 125, 375, 625, 875 µs; a slot of 1 ns
    // counts from its beginning.
    assert_eq!(rising("axis1_step")[..4], [124_999, 374_999, 624_999, 874_999]);
    assert_eq!(rising("axis1_step")[4..], [2_166_666, 2_499_999, 2_833_333]);
    assert_eq!(changes(&out, "axis1_step").len(), 1 + 2 * 7, "each step rises and falls");
    assert_eq!(changes(&out, "axis1_dir"), [(0, false), (2_000_000, true)]);
    assert_eq!(changes(&out, "axis2_step"), [(0, false)]);
    assert_eq!(changes(&out, "do1"), [(0, true), (1_500_000, false)]);
    assert_eq!(changes(&out, "do4"), [(0, false), (3_000_000, true)]);
}

#[test]
fn vcd_refuses_what_its_scale_cannot_show() {
    let header = Header { axes: vec![axis(5)], lasers: vec![], period_ns: 10_000, every: 1 };
    let mut vcd = VcdWriter::new(Vec::new(), &header, &[]).unwrap();
    vcd.row(&row(0, 10_000, &[(0, Scaled::default())])).unwrap();
    vcd.row(&row(1, 10_000, &[(5_000 * PULSE, Scaled::default())])).unwrap();
    let error = vcd.row(&row(2, 10_000, &[(-2 * PULSE, Scaled::default())])).unwrap_err();
    assert!(matches!(error, TraceError::TooManySteps { row: 1, steps: 5_002, row_ns: 10_000, .. }), "{error}");
    assert!(error.to_string().contains("axis5"), "{error}");
}

/// Two rows of one axis as stream bytes, with an end that tells `rows` and `lost`.
fn stream(rows: &[u32], sent: u32, lost: u32) -> Vec<u8> {
    use protocol::trace::{AxisId, Encoder, Head, Sample};
    let mut encoder = Encoder::new();
    let mut bytes = Vec::new();
    let mut flush = |encoder: &mut Encoder| {
        let mut part = [0; 4096];
        let n = encoder.take(&mut part);
        bytes.extend_from_slice(&part[..n]);
    };
    let head = Head { schema: protocol::SCHEMA, period_ns: 50_000, every: 4, timer_mhz: 0 };
    encoder.head(&head, &[AxisId { core: 0, axis: 2 }], &[]).unwrap();
    flush(&mut encoder);
    for &row in rows {
        let pos = i64::from(row) * PULSE;
        encoder.row(row, &[Sample { pos: pos.into(), vel_mantissa: 5.into(), vel_exponent: 1.into() }], &[]).unwrap();
        flush(&mut encoder);
    }
    encoder.end(sent, lost).unwrap();
    flush(&mut encoder);
    bytes
}

fn read(bytes: &[u8], portion: usize) -> (Vec<Item>, Result<(), TraceError>) {
    let mut reader = Reader::new();
    let mut items = Vec::new();
    for part in bytes.chunks(portion) {
        let result = reader.feed(part, |item| {
            items.push(item);
            Ok(())
        });
        if result.is_err() {
            return (items, result);
        }
    }
    assert!(reader.ended());
    (items, Ok(()))
}

#[test]
fn stream_gives_header_rows_and_end() {
    let bytes = stream(&[0, 1, 2], 3, 0);
    for portion in [1, 7, bytes.len()] {
        let (items, result) = read(&bytes, portion);
        result.unwrap();
        let vel = Scaled { m: 5, e: 1 };
        assert_eq!(items[0], Item::Header(Header { axes: vec![axis(2)], lasers: vec![], period_ns: 50_000, every: 4 }));
        assert_eq!(items[3], Item::Row(row(2, 200_000, &[(2 * PULSE, vel)])));
        assert_eq!(items[4], Item::End { rows: 3 });
        assert_eq!(items.len(), 5);
    }
}

#[test]
fn missing_rows_and_damage_are_errors() {
    let (items, result) = read(&stream(&[0, 2], 3, 0), 64);
    assert!(matches!(result, Err(TraceError::Gap { expected: 1, came: 2 })), "{result:?}");
    assert_eq!(items.len(), 2, "header and row 0");
    assert!(matches!(read(&stream(&[0], 2, 0), 64).1, Err(TraceError::Gap { expected: 1, came: 2 })));
    assert!(matches!(read(&stream(&[0], 1, 9), 64).1, Err(TraceError::Lost(9))));
    let mut damaged = stream(&[0, 1], 2, 0);
    let middle = damaged.len() / 2;
    damaged[middle] ^= 0x10;
    assert!(matches!(read(&damaged, 64).1, Err(TraceError::Damaged { .. })));
}

/// The trapezoid of GXN listing 2-1: 1024 ms each of acceleration, 2 pulse/ms, deceleration.
fn trapezoid(t_ms: f64) -> (f64, f64) {
    match t_ms {
        ..1024.0 => (t_ms * t_ms / 1024.0, t_ms / 512.0),
        ..2048.0 => (1024.0 + 2.0 * (t_ms - 1024.0), 2.0),
        ..3072.0 => (4096.0 - (3072.0 - t_ms).powi(2) / 1024.0, (3072.0 - t_ms) / 512.0),
        _ => (4096.0, 0.0),
    }
}

fn scaled(v: f64) -> Scaled {
    Scaled { m: (v * 65536.0) as i64, e: 16 }
}

fn plot_of(axes: u8, options: PlotOptions) -> Plot {
    let header = Header { axes: (1..=axes).map(axis).collect(), lasers: vec![], period_ns: 250_000, every: 1 };
    let mut plot = Plot::new(&header, options).unwrap();
    for index in 0..13_000u32 {
        let t_ms = f64::from(index) * 0.25;
        let point = |n: u8| match n {
            1 => trapezoid(t_ms),
            n => {
                let w = std::f64::consts::TAU * f64::from(n) / 3250.0;
                (500.0 * f64::from(n) * (w * t_ms).sin(), 500.0 * f64::from(n) * w * (w * t_ms).cos())
            }
        };
        let points: Vec<_> = (1..=axes).map(|n| ((point(n).0 * PULSE as f64) as i64, scaled(point(n).1))).collect();
        plot.row(&row(index, 250_000, &points));
    }
    plot
}

/// Width and height from a PNG's header.
fn png_size(bytes: &[u8]) -> (u32, u32) {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (word(16), word(20))
}

#[test]
fn plots_have_the_expected_size_and_content() {
    let folder = folder("plots");
    let mut sizes = Vec::new();
    for axes in [1, 2, 8] {
        let options = PlotOptions {
            title: "Listing 2-1: static PT, trapezoid".into(),
            subtitle: "virtual, servo tick 250 µs, 13000 rows".into(),
            ..PlotOptions::default()
        };
        let plot = plot_of(axes, options);
        for extension in ["png", "svg"] {
            let path = folder.join(format!("axes{axes}.{extension}"));
            plot.save(&path).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            if extension == "png" {
                assert_eq!(png_size(&bytes), plot.size());
                assert!(bytes.len() > 20_000, "{axes} axes: {} bytes", bytes.len());
                sizes.push(bytes.len());
            } else {
                let text = String::from_utf8(bytes).unwrap();
                for part in ["Listing 2-1", "axis 1 position", "axis 1 velocity", "(pulse/ms)", "time (ms)", "4000"] {
                    assert!(text.contains(part), "{axes} axes: no {part:?} in the SVG");
                }
                assert!(text.contains(&format!("axis {axes} velocity")));
            }
        }
    }
    assert!(sizes[0] < sizes[2], "eight axes show more than one: {sizes:?}");
}

#[test]
fn a_zoomed_plot_shows_only_its_time() {
    let folder = folder("zoom");
    let options = PlotOptions { from_ms: Some(1000.0), to_ms: Some(1100.0), ..PlotOptions::default() };
    let plot = plot_of(1, options);
    plot.save(&folder.join("zoom.svg")).unwrap();
    plot.save(&folder.join("zoom.png")).unwrap();
    let text = std::fs::read_to_string(folder.join("zoom.svg")).unwrap();
    assert!(text.contains("1050") && !text.contains("3000"), "time axis from 1000 to 1100 ms");
    let nothing = plot_of(1, PlotOptions { from_ms: Some(1e9), ..PlotOptions::default() });
    assert!(matches!(nothing.save(&folder.join("nothing.png")), Err(TraceError::Window(_))));
    assert!(matches!(plot.save(&folder.join("zoom.gif")), Err(TraceError::Plot(_))));
}
