//! Trace files against what a person can work out by hand.
use servo::segment::piece::Scaled;
use servo::units::Pos;
use std::path::{Path, PathBuf};
use trace::{
    AxisName, AxisPoint, CrdName, CsvWriter, Header, Item, LaserName, LaserPoint, OutputEdge, Plot, PlotOptions,
    PowerUnit, Reader, Row, TraceError, VcdWriter, Xy,
};

const PULSE: i64 = 1 << 22;

fn axis(axis: u8) -> AxisName {
    AxisName { core: 1, axis }
}

fn row(index: u32, row_ns: u64, points: &[(i64, Scaled)]) -> Row {
    let axes = points.iter().map(|&(pos, vel)| AxisPoint { pos: Pos(pos), vel }).collect();
    Row { index, t_ns: u64::from(index) * row_ns, axes, lasers: Vec::new(), crds: Vec::new() }
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
        crds: vec![],
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

#[test]
fn path_speeds_are_the_last_columns() {
    let header = Header {
        axes: vec![axis(2)],
        lasers: vec![LaserName(1)],
        crds: vec![CrdName { core: 1, crd: 2 }, CrdName { core: 2, crd: 1 }],
        period_ns: 1_000_000,
        every: 1,
    };
    let mut out = Vec::new();
    let mut csv = CsvWriter::new(&mut out, &header).unwrap();
    let speeds = vec![Scaled { m: 5, e: 2 }, Scaled { m: 3, e: 0 }];
    let mut row = row(1, header.row_ns(), &[(PULSE, Scaled::default())]);
    (row.lasers, row.crds) = (vec![LaserPoint { gate: true, ..LaserPoint::default() }], speeds);
    csv.row(&row).unwrap();
    csv.finish().unwrap();
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "t_ms,axis2_pos,axis2_vel,laser1_gate,laser1_power,laser1_freq_khz,crd2_vel,core2_crd1_vel\n\
         1.000000,1.000000,0.000000,1,0.000000,0.000000,1.250000,3.000000\n"
    );
}

#[test]
fn a_path_speed_has_its_panel_with_the_power_beside_it() {
    let header = Header {
        lasers: vec![LaserName(0)],
        crds: vec![CrdName { core: 1, crd: 1 }],
        period_ns: 1_000_000,
        every: 1,
        ..Header::default()
    };
    let mut plot = Plot::new(&header, PlotOptions::default()).unwrap();
    for index in 0..=100u32 {
        // Speed 0 to 50 and power 10 to 60 %, each in its own scale.
        let laser = LaserPoint { power: Scaled { m: 20 + i64::from(index), e: 1 }, ..LaserPoint::default() };
        let crds = vec![Scaled { m: index.into(), e: 1 }];
        plot.row(&Row { index, t_ns: u64::from(index) * 1_000_000, axes: vec![], lasers: vec![laser], crds });
    }
    let path = folder("plots").join("speed.svg");
    plot.save(&path).unwrap();
    plot.save(&path.with_extension("png")).unwrap();
    let svg = std::fs::read_to_string(path).unwrap();
    assert!(svg.contains("crd 1 path speed (pulse/ms)") && svg.contains("laser 0 power: duty (%)"));
    // The speed's line, then the power's beside it and that in the power's own panel.
    let (speed, power) = (lines(&svg, "#C8521A"), lines(&svg, "#7B3FA6"));
    assert_eq!((speed.len(), power.len()), (1, 2));
    let ends = |line: &[(i32, i32)]| (line[0], *line.last().unwrap());
    let ((left, speed_low), (right, speed_high)) = ends(&speed[0]);
    let ((power_left, power_low), (power_right, power_high)) = ends(&power[0]);
    assert_eq!((left, right), (power_left, power_right), "one time axis");
    // Both scales have 8 % of air: 0 to 50 and 0 to 60.
    let full = f64::from(speed_low - speed_high);
    let high = |y: i32| f64::from(speed_low - y) / full;
    assert!((high(power_low) - 10.0 / 60.0).abs() < 0.02 && (high(power_high) - 1.0).abs() < 0.02);
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
    let header = Header { axes: vec![axis(1), axis(2)], lasers: vec![], crds: vec![], period_ns: 1_000_000, every: 1 };
    let mut out = Vec::new();
    let mut vcd = VcdWriter::new(&mut out, &header, &[(1, true), (4, false)], &[]).unwrap();
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
    // 4 pulses in 1 ms, centred: the middle of each quarter is 125, 375, 625, 875 µs; a slot of 1
    // ns counts from its beginning.
    assert_eq!(rising("axis1_step")[..4], [124_999, 374_999, 624_999, 874_999]);
    assert_eq!(rising("axis1_step")[4..], [2_166_666, 2_499_999, 2_833_333]);
    assert_eq!(changes(&out, "axis1_step").len(), 1 + 2 * 7, "each step rises and falls");
    assert_eq!(changes(&out, "axis1_dir"), [(0, false), (2_000_000, true)]);
    assert_eq!(changes(&out, "axis2_step"), [(0, false)]);
    assert_eq!(changes(&out, "do1"), [(0, true), (1_500_000, false)]);
    assert_eq!(changes(&out, "do4"), [(0, false), (3_000_000, true)]);
}

/// A position that gets another name is no motion, also where the set-point is no whole pulse.
#[test]
fn vcd_shows_no_step_of_a_name() {
    let header = Header { axes: vec![axis(1), axis(2)], lasers: vec![], crds: vec![], period_ns: 1_000_000, every: 1 };
    let mut out = Vec::new();
    let mut vcd = VcdWriter::new(&mut out, &header, &[], &[]).unwrap();
    let still = Scaled::default();
    // Axis 1 stands at 4.4 pulses of the machine, called 104.4: then it is called -1000, and goes
    // 0.2 pulses on, which is a step. Axis 2 moves 3 pulses while axis 1 is renamed.
    let part = PULSE * 2 / 5;
    vcd.zero(0, Pos(100 * PULSE));
    for (index, positions) in
        [[104 * PULSE + part, 0], [-1000 * PULSE, 3 * PULSE], [-1000 * PULSE + PULSE / 5, 3 * PULSE]]
            .into_iter()
            .enumerate()
    {
        if index == 1 {
            vcd.zero(0, Pos(-1104 * PULSE - part));
        }
        vcd.row(&row(index as u32, header.row_ns(), &positions.map(|at| (at, still)))).unwrap();
    }
    vcd.finish().unwrap();
    let rising = |name| changes(&out, name).into_iter().filter(|c| c.1).map(|c| c.0).collect::<Vec<_>>();
    assert_eq!(rising("axis1_step"), [1_499_999]);
    assert_eq!(rising("axis2_step").len(), 3);
    assert_eq!(changes(&out, "axis1_dir"), [(0, false)]);
}

#[test]
fn vcd_refuses_what_its_scale_cannot_show() {
    let header = Header { axes: vec![axis(5)], lasers: vec![], crds: vec![], period_ns: 10_000, every: 1 };
    let mut vcd = VcdWriter::new(Vec::new(), &header, &[], &[]).unwrap();
    vcd.row(&row(0, 10_000, &[(0, Scaled::default())])).unwrap();
    vcd.row(&row(1, 10_000, &[(5_000 * PULSE, Scaled::default())])).unwrap();
    let error = vcd.row(&row(2, 10_000, &[(-2 * PULSE, Scaled::default())])).unwrap_err();
    assert!(matches!(error, TraceError::TooManySteps { row: 1, steps: 5_002, row_ns: 10_000, .. }), "{error}");
    assert!(error.to_string().contains("axis5"), "{error}");
}

/// Two rows of one axis as stream bytes, with an end that reports `rows` and `lost`.
fn stream(rows: &[u32], sent: u32, lost: u32) -> Vec<u8> {
    use protocol::trace::{AxisId, Encoder, Ids, Sample, Samples, TraceHead};
    let mut encoder = Encoder::new();
    let mut bytes = Vec::new();
    let mut flush = |encoder: &mut Encoder| {
        let mut part = [0; 4096];
        let n = encoder.take(&mut part);
        bytes.extend_from_slice(&part[..n]);
    };
    let head = TraceHead { schema: protocol::SCHEMA, period_ns: 50_000, every: 4, timer_mhz: 0 };
    encoder.head(&head, &Ids { axes: &[AxisId { core: 0, axis: 2 }], ..Ids::default() }).unwrap();
    flush(&mut encoder);
    for &row in rows {
        let pos = i64::from(row) * PULSE;
        let sample = Sample { pos: pos.into(), vel_mantissa: 5.into(), vel_exponent: 1.into() };
        encoder.row(row, &Samples { axes: &[sample], ..Samples::default() }).unwrap();
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
        assert_eq!(
            items[0],
            Item::Header(Header { axes: vec![axis(2)], lasers: vec![], crds: vec![], period_ns: 50_000, every: 4 })
        );
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
    let header =
        Header { axes: (1..=axes).map(axis).collect(), lasers: vec![], crds: vec![], period_ns: 250_000, every: 1 };
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

/// Twice around a rectangle of 2000 by 1000 pulses in 600 ms, a row each ms. From its second side
/// on there is light of 100 %, from the fourth on of 50 %. From the middle of the second pass's
/// first side on there is none.
fn xy_of_rectangle(options: PlotOptions) -> Xy {
    let header = Header {
        axes: vec![axis(1), axis(2)],
        lasers: vec![LaserName(0)],
        crds: vec![],
        period_ns: 1_000_000,
        every: 1,
    };
    let mut xy = Xy::new(&header, (axis(1), axis(2)), options).unwrap();
    for index in 0..=600u32 {
        let t = index % 300;
        let (x, y) = match t {
            0..100 => (20 * t, 0),
            100..150 => (2000, 20 * (t - 100)),
            150..250 => (20 * (250 - t), 1000),
            _ => (0, 20 * (300 - t)),
        };
        // On and off between rows.
        for (at, on) in [(100_000_000, true), (350_500_000, false)] {
            if (at / 1_000_000 + 1) as u32 == index {
                xy.light(0, at, on);
            }
        }
        let power = if index < 250 { 100 } else { 50 };
        let at = |pulses: u32| AxisPoint { pos: Pos(i64::from(pulses) * PULSE), vel: Scaled::default() };
        let laser = LaserPoint { power: Scaled { m: power, e: 0 }, unit: PowerUnit::Percent, ..LaserPoint::default() };
        xy.row(&Row {
            index,
            t_ns: u64::from(index) * 1_000_000,
            axes: vec![at(x), at(y)],
            lasers: vec![laser],
            crds: vec![],
        });
    }
    xy
}

/// Lines of a colour in an SVG, as points.
fn lines(svg: &str, colour: &str) -> Vec<Vec<(i32, i32)>> {
    let of_colour = svg.lines().filter(|line| line.starts_with("<polyline") && line.contains(colour));
    let points = of_colour.map(|line| line.split_once("points=\"").unwrap().1.split_once('"').unwrap().0);
    points
        .map(|points| {
            let pair = |p: &str| p.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).unwrap();
            points.split_whitespace().map(pair).collect()
        })
        .collect()
}

#[test]
fn a_path_is_drawn_to_scale_and_lit_where_light_was() {
    let folder = folder("xy");
    let xy = xy_of_rectangle(PlotOptions { title: "twice round".into(), ..PlotOptions::default() });
    for extension in ["svg", "png"] {
        xy.save(&folder.join(format!("xy.{extension}"))).unwrap();
    }
    let svg = std::fs::read_to_string(folder.join("xy.svg")).unwrap();
    for part in ["twice round", "axis 1 position", "axis 2 position", "light of laser 0, duty (%)", "100", "250 ms"] {
        assert!(svg.contains(part), "no {part:?}");
    }
    // Dark: from the start to the second side, and the second round from the middle of its first
    // side on.
    let mut dark = lines(&svg, "#9AA4AE");
    // The legend's.
    dark.remove(0);
    let (first, second) = (&dark[0], &dark[1]);
    let (left, bottom) = first[0];
    let (right, _) = *first.last().unwrap();
    let top = second.iter().map(|point| point.1).min().unwrap();
    assert!(((right - left) - 2 * (bottom - top)).abs() <= 2, "{left}..{right}, {bottom}..{top}");
    let lies = |point: (i32, i32), x: f64, y: f64| {
        let per_pulse = f64::from(right - left) / 2000.0;
        let off = (f64::from(point.0 - left) - x * per_pulse, f64::from(bottom - point.1) - y * per_pulse);
        assert!(off.0.abs() < 1.5 && off.1.abs() < 1.5, "{point:?} is not ({x}, {y})");
    };
    lies(second[0], 1010.0, 0.0);
    // Full power has the last colour of the bar: sides two and three. Half of it the one in the
    // middle.
    let full = lines(&svg, "#F2A900");
    lies(full[0][0], 2000.0, 0.0);
    lies(*full.last().unwrap().last().unwrap(), 0.0, 1000.0);
    let half = lines(&svg, "#C53069");
    lies(half[0][0], 0.0, 1000.0);
    lies(*half.last().unwrap().last().unwrap(), 1010.0, 0.0);
    // A window shows its own part only.
    let part = xy_of_rectangle(PlotOptions { from_ms: Some(110.25), to_ms: Some(140.5), ..PlotOptions::default() });
    part.save(&folder.join("part.svg")).unwrap();
    let svg = std::fs::read_to_string(folder.join("part.svg")).unwrap();
    assert!(lines(&svg, "#9AA4AE").is_empty(), "all of it is lit");
    assert!(svg.contains("110.25 ms") && svg.contains("140.5 ms") && !svg.contains("250 ms"));
    // What cannot be drawn.
    assert!(matches!(xy.save(&folder.join("xy.gif")), Err(TraceError::Plot(_))));
    let late = xy_of_rectangle(PlotOptions { from_ms: Some(601.0), ..PlotOptions::default() });
    assert!(matches!(late.save(&folder.join("late.svg")), Err(TraceError::Window(_))));
    let header = Header { axes: vec![axis(1)], ..Header::default() };
    let missing = Xy::new(&header, (axis(1), axis(2)), PlotOptions::default());
    assert!(missing.is_err_and(|error| error.to_string().contains("axis 2 is not in the trace")));
}

#[test]
fn a_path_of_any_length_is_drawn() {
    let header = Header { axes: vec![axis(1), axis(2)], period_ns: 50_000, every: 1, ..Header::default() };
    let mut xy = Xy::new(&header, (axis(2), axis(1)), PlotOptions::default()).unwrap();
    for index in 0..400_000u32 {
        let angle = f64::from(index) * 1e-3;
        let point = |v: f64| ((v * 1000.0 * PULSE as f64) as i64, Scaled::default());
        xy.row(&row(index, 50_000, &[point(angle.sin()), point(angle.cos())]));
    }
    let path = folder("xy").join("long.svg");
    xy.save(&path).unwrap();
    let svg = std::fs::read_to_string(path).unwrap();
    let drawn_path = lines(&svg, "#1F6FB4");
    let points: Vec<_> = drawn_path.into_iter().flatten().collect();
    assert!((2_000..140_000).contains(&points.len()), "{} points", points.len());
    let (least, most) = (points.iter().map(|p| p.0).min().unwrap(), points.iter().map(|p| p.0).max().unwrap());
    let middle = (least + most) / 2;
    let low = points.iter().map(|p| p.1).min().unwrap();
    for (x, y) in points {
        let radius = f64::from(x - middle).hypot(f64::from(y - low) - f64::from(most - least) / 2.0);
        assert!((radius - f64::from(most - least) / 2.0).abs() < 2.5, "({x}, {y}) is not on the circle");
    }
}

/// Red, green and blue of a bitmap's pixels, and its width.
fn pixels(path: &Path) -> (Vec<u8>, usize) {
    let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    (pixels, reader.info().width as usize)
}

/// The bitmap fills a line as an area: what it covers twice must not become empty.
#[test]
fn a_path_travelled_twice_is_drawn_all_along() {
    let header = Header { axes: vec![axis(1), axis(2)], period_ns: 250_000, every: 1, ..Header::default() };
    let mut xy = Xy::new(&header, (axis(1), axis(2)), PlotOptions::default()).unwrap();
    for index in 0..=5000u32 {
        let angle = f64::from(index) * 4.0 * std::f64::consts::PI / 5000.0;
        let point = |v: f64| ((v * 5000.0 * PULSE as f64) as i64, Scaled::default());
        xy.row(&row(index, 250_000, &[point(angle.cos()), point(angle.sin())]));
    }
    let file = |extension: &str| folder("xy").join(format!("twice.{extension}"));
    xy.save(&file("svg")).unwrap();
    xy.save(&file("png")).unwrap();
    let drawn_path = lines(&std::fs::read_to_string(file("svg")).unwrap(), "#1F6FB4");
    let (pixels, width) = pixels(&file("png"));
    let drawn = |x: i32, y: i32| {
        let at = (y as usize * width + x as usize) * 3;
        let [red, _, blue] = pixels[at..at + 3] else { panic!() };
        // The way, or a sign on it.
        i32::from(blue) - i32::from(red) > 60 || blue < 110
    };
    let points: Vec<_> = drawn_path.into_iter().flatten().collect();
    assert!(points.len() > 1000, "{} points", points.len());
    for (x, y) in points {
        assert!((-1..=1).any(|dx| (-1..=1).any(|dy| drawn(x + dx, y + dy))), "nothing at {x}, {y}");
    }
}

/// A bitmap's line never leaves its panel: a triangle wave that falls to 0 in one row at its end.
#[test]
fn a_sharp_corner_leaves_no_line_behind() {
    let header = Header { axes: vec![axis(1)], lasers: vec![], crds: vec![], period_ns: 250_000, every: 1 };
    let mut plot = Plot::new(&header, PlotOptions::default()).unwrap();
    for index in 0..14_402u32 {
        let v = if index < 14_400 { f64::from(index % 2400) * 0.02 } else { 0.0 };
        plot.row(&row(index, 250_000, &[(0, scaled(v))]));
    }
    let path = folder("plots").join("sharp.png");
    plot.save(&path).unwrap();
    let (pixels, _) = pixels(&path);
    let (width, height) = plot.size();
    // Below the last panel's axis there are grey letters only.
    let foot = &pixels[((height - 54) * width * 3) as usize..];
    let coloured = foot.chunks(3).filter(|p| p.iter().max().unwrap() - p.iter().min().unwrap() > 40).count();
    assert_eq!(coloured, 0, "the line runs below the axis");
}
