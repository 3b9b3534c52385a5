//! Drawings in the virtual controller: marks against closed forms, and what is refused.
#[path = "drawing/dxf.rs"]
mod dxf;
#[path = "drawing/generator.rs"]
mod generator;
mod judge;
#[path = "drawing/notes.rs"]
mod notes;
#[path = "drawing/refused.rs"]
mod refused;

use generator::{Drawing, Mark};
use judge::{Row, beamtick, rows};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// Pulses a mm of X and Y; X counts down.
const PULSES_PER_MM: f64 = 1000.0;
/// `arc_tolerance` of the machine.
const ARC_TOLERANCE_MM: f64 = 0.002;
/// Half a pulse in both directions, what 24 bits leave of 300 mm, and a little.
const SLACK_MM: f64 = 0.0012;

fn machine(layers: &str) -> String {
    let mut text = String::new();
    for (letter, number, invert) in [("x", 2, true), ("y", 1, false), ("z", 5, false)] {
        text += &format!(
            "[axes.{letter}]\nnumber = {number}\nsteps_per_mm = {PULSES_PER_MM}\ninvert = {invert}\ntravel = [-400, 400]\n\
             max_rate = 15000\nacceleration = 5000\n"
        );
    }
    text + "[laser]\nchannel = 0\nmode = \"duty\"\ncarrier_khz = 10\npower = [0, 80]\ns_max = 1000\n" + layers
}

const LAYERS: &str = "[[layers]]\ncolour = \"#0000ff\"\npower = 60\nspeed = 6000\nlight = \"constant\"\n\
                      [[layers]]\ncolour = \"#f00\"\npower = 30\nspeed = 4000\nlight = \"constant\"\norder = -1\n";

/// Pieces of lines by the cell they are in, to find what is near.
struct Near {
    lines: Vec<([f64; 2], [f64; 2], f64)>,
    cells: HashMap<(i64, i64), Vec<usize>>,
}

const CELL_MM: f64 = 0.2;

impl Near {
    fn new() -> Near {
        Near { lines: Vec::new(), cells: HashMap::new() }
    }

    /// A line shorter than a cell, and a power.
    fn add(&mut self, from: [f64; 2], to: [f64; 2], power: f64) {
        let middle = [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])];
        let cell = ((middle[0] / CELL_MM).floor() as i64, (middle[1] / CELL_MM).floor() as i64);
        self.cells.entry(cell).or_default().push(self.lines.len());
        self.lines.push((from, to, power));
    }

    /// The distance of the nearest line of this power.
    fn distance(&self, [x, y]: [f64; 2], power: f64) -> f64 {
        let (column, row) = ((x / CELL_MM).floor() as i64, (y / CELL_MM).floor() as i64);
        let cells = (-1..=1).flat_map(|a| (-1..=1).map(move |b| (column + a, row + b)));
        let lines = cells.filter_map(|cell| self.cells.get(&cell)).flatten().map(|line| self.lines[*line]);
        let of = |(from, to, _): ([f64; 2], [f64; 2], f64)| {
            let spatial = |p: [f64; 2]| [p[0], p[1], 0.0];
            judge::off([x, y, 0.0], [spatial(from), spatial(to)])
        };
        lines.filter(|line| line.2 == power).map(of).fold(f64::INFINITY, f64::min)
    }
}

/// What differs between the marks of a drawing and a trace.
fn differs(marks: &[Mark], rows: &[Row]) -> Result<(), String> {
    let mm = |row: &Row| [row.at[0] / -PULSES_PER_MM, row.at[1] / PULSES_PER_MM];
    let power = |red: bool| if red { 30.0 } else { 60.0 };
    let mut drawn = Near::new();
    for mark in marks {
        for pair in mark.points.windows(2) {
            drawn.add(pair[0], pair[1], power(mark.red));
        }
    }
    let mut run = Near::new();
    let mut begun = 0;
    for pair in rows.windows(2) {
        begun += usize::from(!pair[0].lit && pair[1].lit);
        if pair[0].lit && pair[1].lit {
            if pair[0].power != pair[1].power {
                // A layer ends where the next begins.
                continue;
            }
            run.add(mm(&pair[0]), mm(&pair[1]), pair[0].power);
            let off = drawn.distance(mm(&pair[0]), pair[0].power);
            if off > ARC_TOLERANCE_MM + SLACK_MM {
                return Err(format!(
                    "it is lit with {} % at {:?} mm, {off} mm beside all marks",
                    pair[0].power,
                    mm(&pair[0])
                ));
            }
        }
    }
    for mark in marks {
        // Ends fall between two rows.
        for point in &mark.points[1..mark.points.len() - 1] {
            let off = run.distance(*point, power(mark.red));
            if off > ARC_TOLERANCE_MM + SLACK_MM + if mark.is_end(*point) { 0.03 } else { 0.0 } {
                return Err(format!("{} at {point:?} is {off} mm beside the light", mark.what));
            }
        }
    }
    if begun != marks.len() {
        return Err(format!("light began {begun} times for {} marks", marks.len()));
    }
    match rows.last().map(|row| row.at) {
        Some([0.0, 0.0, 0.0]) => Ok(()),
        other => Err(format!("it ends at {other:?}, not at home")),
    }
}

/// Rectangles, circles, ellipses and Bézier curves, turned, scaled and stretched, in pages of
/// several units.
#[test]
fn random_drawings_are_marked_where_they_are_and_nowhere_else() {
    let work = |part: u64| {
        let folder = tempfile::tempdir().unwrap();
        let mut arcs = 0;
        for seed in (part..200).step_by(2) {
            let family = ["gus", "lsr"][seed as usize / 2 % 2];
            let machine = format!("family = \"{family}\"\n{}", machine(LAYERS));
            fs::write(folder.path().join("m.toml"), machine).unwrap();
            let Drawing { text, marks, circles } = generator::drawing(&mut Xoshiro256PlusPlus::seed_from_u64(seed));
            fs::write(folder.path().join("d.svg"), &text).unwrap();
            let (said, code) =
                beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv", "--strict"]);
            assert_eq!(code, 0, "seed {seed}: {said}\n{text}");
            if let Err(why) = differs(&marks, &rows(&folder.path().join("t.csv"))) {
                panic!("seed {seed}: {why}\n{text}");
            }
            let (said, code) = beamtick(folder.path(), &["import", "d.svg", "--machine", "m.toml", "-o", "d.gts"]);
            assert_eq!(code, 0, "{said}");
            let job = fs::read_to_string(folder.path().join("d.gts")).unwrap();
            assert_eq!(job.matches("GT_ArcXYC(").count(), circles, "seed {seed}: circles are arcs\n{text}");
            arcs += circles;
        }
        arcs
    };
    let arcs: usize = std::thread::scope(|scope| {
        let parts = [0, 1].map(|part| scope.spawn(move || work(part)));
        parts.into_iter().map(|part| part.join().unwrap()).sum()
    });
    assert!(arcs > 100, "{arcs} circles");
}

/// Runs `check` of a drawing: what it prints, and its code.
fn check(folder: &Path, svg: &str) -> (String, i32) {
    fs::write(folder.join("d.svg"), svg).unwrap();
    beamtick(folder, &["check", "d.svg", "--machine", "m.toml"])
}

fn page(inside: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100mm\" height=\"100mm\" viewBox=\"0 0 100 100\">\n{inside}\n</svg>"
    )
}

const LINE: &str = "<path d=\"M0 0L1 1\" stroke=\"#f00\"/>";

/// Points of a mark from `from` to `to` along a path, in mm of the machine.
fn dash(red: bool, [from, to]: [f64; 2], at: &dyn Fn(f64) -> [f64; 2]) -> Mark {
    let count = ((to - from) / 0.005).ceil();
    let point = |k: i32| {
        let [x, y] = at(from + (to - from) * f64::from(k) / count);
        [x, 100.0 - y]
    };
    let points = (0..=count as i32).map(point).collect();
    Mark { points, red, what: format!("the dash from {from} to {to}"), corners: Vec::new() }
}

/// Dashes are where their lengths along the path say, in the units of the path.
#[test]
fn dashes_are_marked_and_gaps_are_not() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    // A line; a corner, stretched, with one length and an offset; a square whose last dash goes on
    // as its first one; a circle; a circle that is stretched to an ellipse.
    let svg = page(
        "<g fill=\"none\"><path d=\"M10 10H41\" stroke=\"#f00\" stroke-dasharray=\"5 2.5\"/>\n\
         <path transform=\"translate(5 20) scale(2 3)\" style=\"stroke-dasharray: 3; stroke-dashoffset: 1\" d=\"M0 0H6V9\" \
         stroke=\"#00f\"/>\n\
         <path d=\"M60 10h10v10h-10z\" stroke=\"#f00\" stroke-dasharray=\"6,4\" stroke-dashoffset=\"3\"/>\n\
         <circle cx=\"70\" cy=\"70\" r=\"5\" stroke=\"#00f\" stroke-dasharray=\"4 3.9\"/>\n\
         <circle transform=\"scale(2 1)\" cx=\"15\" cy=\"80\" r=\"4\" stroke=\"#f00\" stroke-dasharray=\"3 20\"/></g>",
    );
    let line = |s: f64| [10.0 + s, 10.0];
    let corner = |s: f64| if s < 6.0 { [5.0 + 2.0 * s, 20.0] } else { [17.0, 20.0 + 3.0 * (s - 6.0)] };
    let square = |s: f64| match s.rem_euclid(40.0) {
        s if s < 10.0 => [60.0 + s, 10.0],
        s if s < 20.0 => [70.0, s],
        s if s < 30.0 => [90.0 - s, 20.0],
        s => [60.0, 50.0 - s],
    };
    let circle = |s: f64| [70.0 + 5.0 * (s / 5.0).cos(), 70.0 + 5.0 * (s / 5.0).sin()];
    let ellipse = |s: f64| [30.0 + 8.0 * (s / 4.0).cos(), 80.0 + 4.0 * (s / 4.0).sin()];
    let mut marks = Vec::new();
    for (red, at, dashes) in [
        (
            true,
            &line as &dyn Fn(f64) -> [f64; 2],
            &[[0.0, 5.0], [7.5, 12.5], [15.0, 20.0], [22.5, 27.5], [30.0, 31.0]][..],
        ),
        (false, &corner, &[[0.0, 2.0], [5.0, 8.0], [11.0, 14.0]]),
        (true, &square, &[[7.0, 13.0], [17.0, 23.0], [27.0, 33.0], [37.0, 43.0]]),
        (false, &circle, &[[0.0, 4.0], [7.9, 11.9], [15.8, 19.8], [23.7, 27.7]]),
        (true, &ellipse, &[[0.0, 3.0], [23.0, 8.0 * std::f64::consts::PI]]),
    ] {
        // The ellipse is open at its begin: its last dash goes on as its first one.
        match dashes {
            [first, last] => marks.push(dash(red, [last[0], last[1] + first[1]], at)),
            dashes => marks.extend(dashes.iter().map(|ends| dash(red, *ends, at))),
        }
    }
    fs::write(folder.path().join("d.svg"), svg).unwrap();
    let (said, code) =
        beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv", "--strict"]);
    assert!(code == 0 && !said.contains("note:"), "{said}");
    if let Err(why) = differs(&marks, &rows(&folder.path().join("t.csv"))) {
        panic!("{why}\n{said}");
    }
    // Dots have no length: that is said. Lengths that are all 0 are no dashes, as SVG says.
    let dots = "<path d=\"M0 0H9\" stroke=\"#f00\" stroke-dasharray=\"0 3 1 3\"/>";
    let (said, code) = check(folder.path(), &page(dots));
    let note = "d.svg: note: shapes with dots, which are dashes of length 0: the dots are not marked (1)";
    assert!(code == 0 && said.contains(note) && said.contains("marks of 1.000 mm"), "{said}");
    // A dash that is as long as a closed shape, or longer, goes once around it and not across.
    for (dash, shape) in [
        (70.0, "circle cx=\"50\" cy=\"50\" r=\"10\""),
        (100.0, "circle cx=\"50\" cy=\"50\" r=\"10\""),
        (62.84, "path d=\"M50 40A10 10 0 0 1 50 60A10 10 0 0 1 50 40Z\""),
    ] {
        let shape = format!("<{shape} fill=\"none\" stroke=\"#f00\" stroke-dasharray=\"{dash} 3\"/>");
        let (said, code) = check(folder.path(), &page(&shape));
        assert!(code == 0 && said.contains("marks of 62.83"), "{shape}: {said}");
    }
    let (said, code) = check(folder.path(), &page(&dots.replace("0 3 1 3", "0 0")));
    assert!(code == 0 && !said.contains("dots") && said.contains("marks of 9.000 mm"), "{said}");
    let (said, code) = check(folder.path(), &page(&dots.replace("0 3 1 3", "0 3")));
    assert!(code == 2 && said.contains("there is nothing to mark"), "{said}");
}

/// What a person would not see in the result is said: layers that take nothing, shapes beside the
/// page, a speed that is not reached; each with its place in the file.
#[test]
fn notes_name_layer_and_shape() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40mm\" height=\"40mm\" viewBox=\"0 0 40 40\">\n\
               <path d=\"M1 1H9\" stroke=\"#00f\"/>\n<g>\n<rect x=\"30\" y=\"5\" width=\"20\" height=\"9\" \
               fill=\"none\" stroke=\"#00f\"/></g>\n<line id=\"far\" x1=\"-5\" x2=\"2\" stroke=\"#00f\"/>\n\
               <path id=\"\" d=\"M2 2H9\" stroke=\"#00f\"/>\n</svg>\n";
    fs::write(folder.path().join("d.svg"), svg).unwrap();
    let words = ["check", "d.svg", "--machine", "m.toml", "--layer", "colour=#0f0,power=5,speed=600"];
    let (said, code) = beamtick(folder.path(), &words);
    assert_eq!(code, 0, "{said}");
    for note in [
        "d.svg: note: no stroke of the drawing is taken by layer \"layer 1\" (strokes of #00ff00), \"layer 2\" (strokes of #ff0000)",
        "d.svg: note: the rect of line 4 leaves the page, and is marked there too (with it 2 shapes)",
    ] {
        assert!(said.contains(note), "{note}\n{said}");
    }
    let words = ["check", "d.svg", "--machine", "m.toml", "--layer", "colour=#00f,power=5,speed=99999"];
    let (said, code) = beamtick(folder.path(), &words);
    // The shape that is marked first.
    let note =
        "note: layer \"layer 1\", a shape without an id: 99999 mm/min are asked for, and the machine reaches 15000";
    assert!(code == 0 && said.contains(note) && said.matches("asked for").count() == 1, "{said}");
    // Within the page, and every layer used: nothing to say.
    fs::write(folder.path().join("d.svg"), page(&format!("{LINE}<path d=\"M0 0H1\" stroke=\"#00f\"/>"))).unwrap();
    let (said, code) = beamtick(folder.path(), &["check", "d.svg", "--machine", "m.toml"]);
    assert!(code == 0 && !said.contains("note:"), "{said}");
}

/// A path of a million lines is read, put in order and written in time and memory that grow with
/// it.
#[test]
fn a_million_segments_are_read_in_proportion() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let mut took = Vec::new();
    for count in [100_000u32, 1_000_000] {
        let mut d = "M0 0".to_owned();
        for k in 1..=count {
            d += &format!("L{} {}", f64::from(k % 1000) / 10.0, f64::from(k / 1000) / 20.0);
        }
        fs::write(folder.path().join("d.svg"), page(&format!("<path d=\"{d}\" fill=\"none\" stroke=\"#f00\"/>")))
            .unwrap();
        let begin = std::time::Instant::now();
        let (said, code) = beamtick(folder.path(), &["import", "d.svg", "--machine", "m.toml", "-o", "d.gts"]);
        took.push(begin.elapsed().as_secs_f64());
        assert_eq!(code, 0, "{said}");
        let lines = fs::read_to_string(folder.path().join("d.gts")).unwrap().matches("GT_LnXYZ").count();
        // To its start, along it, and home.
        assert_eq!(lines, count as usize + 2, "{said}");
    }
    assert!(took[1] < 40.0 * took[0].max(0.1), "{took:?} s");
}

/// Ten thousand squares in one another, and as many beside one another: each runs before the one
/// around it.
#[test]
fn inner_shapes_run_before_outer_ones() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let square = |x: f64, y: f64, size: f64| format!("M{x} {y}h{size}v{size}h-{size}z");
    let nested: String =
        (0..10_000).map(|k| square(f64::from(k) / 250.0, f64::from(k) / 250.0, 90.0 - f64::from(k) / 125.0)).collect();
    fs::write(folder.path().join("d.svg"), page(&format!("<path d=\"{nested}\" fill=\"none\" stroke=\"#f00\"/>")))
        .unwrap();
    let (said, code) = beamtick(folder.path(), &["import", "d.svg", "--machine", "m.toml", "-o", "d.gts"]);
    assert_eq!(code, 0, "{said}");
    let job = fs::read_to_string(folder.path().join("d.gts")).unwrap();
    let mut last = 0;
    let mut found = 0;
    // Four lines after a BufLaserOn are a square.
    let mut lines = job.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("GT_BufLaserOn") {
            let xs: Vec<i64> =
                (0..4).map(|_| lines.next().unwrap().split(',').nth(1).unwrap().trim().parse().unwrap()).collect();
            let size = xs.iter().max().unwrap() - xs.iter().min().unwrap();
            assert!(size >= last, "{size} after {last}");
            (last, found) = (size, found + 1);
        }
    }
    assert_eq!(found, 10_000);
    // Rows of squares whose file order is at random: the way between them is short.
    let mut order: Vec<u32> = (0..2500).collect();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    for k in (1..order.len()).rev() {
        order.swap(k, generator::below(&mut random, k as u64 + 1) as usize);
    }
    let beside: String = order.iter().map(|k| square(f64::from(k % 50) * 2.0, f64::from(k / 50) * 2.0, 1.0)).collect();
    let outer = square(-1.0, -1.0, 101.0);
    let svg = page(&format!("<path d=\"{outer}{beside}\" fill=\"none\" stroke=\"#f00\"/>"));
    let (said, code) = check(folder.path(), &svg);
    assert_eq!(code, 0, "{said}");
    let length = |after: &str| -> f64 { said.split(after).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap() };
    let travel = length("path of ") - length("marks of ");
    // 2,500 ways of a mm at least; in the order of the file it would be some 130 m.
    assert!((2500.0..6000.0).contains(&travel), "{travel} mm of travel");
}

/// Units, viewBox and where the page lies; layers of the command line; what is passed over is said.
#[test]
fn pages_lie_with_their_lower_left_corner_at_zero() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (attributes, line, says) in [
        (
            "width=\"100mm\" height=\"50mm\" viewBox=\"0 0 200 100\"",
            "M20 100V80",
            "marks of 10.000 mm, X 10.000 to 10.000, Y 0.000 to 10.000",
        ),
        ("width=\"4in\" height=\"2in\"", "M96 192V96", "marks of 25.400 mm, X 25.400 to 25.400, Y 0.000 to 25.400"),
        ("width=\"96\" height=\"96\"", "M0 96V0", "marks of 25.400 mm, X 0.000 to 0.000, Y 0.000 to 25.400"),
        ("viewBox=\"-10 -10 106 106\"", "M-10 96V0", "marks of 25.400 mm, X 0.000 to 0.000, Y 0.000 to 25.400"),
        (
            "width=\"10cm\" height=\"5cm\" viewBox=\"0 0 50 50\"",
            "M0 0H50",
            "marks of 50.000 mm, X 25.000 to 75.000, Y 50.000",
        ),
    ] {
        let svg =
            format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {attributes}><path d=\"{line}\" stroke=\"red\"/></svg>");
        let (said, code) = check(folder.path(), &svg);
        assert!(code == 0 && said.contains(says), "{attributes}: {said}");
    }
    let svg = page(
        "<path d=\"M0 100h10\" stroke=\"lime\"/><rect width=\"5\" height=\"5\"/>\
         <path d=\"M0 100h7\" style=\"stroke:#00F\" transform=\"rotate(-90 0 100)\"/><defs><text>none</text></defs>",
    );
    fs::write(folder.path().join("d.svg"), svg).unwrap();
    let words = [
        "check",
        "d.svg",
        "--machine",
        "m.toml",
        "--at",
        "-20,5.5",
        "--layer",
        "colour=#0f0,power=10,speed=100,passes=3",
    ];
    let (said, code) = beamtick(folder.path(), &words);
    assert!(code == 0 && said.contains("marks of 37.000 mm, X -20.000 to -10.000, Y 5.500 to 12.500"), "{said}");
    assert!(said.contains("d.svg: note: shapes with a fill and no stroke are not marked (1)"), "{said}");
    assert!(!said.contains("a unit") && !said.contains("stroke-width"), "{said}");
    let words = ["check", "d.svg", "--machine", "m.toml", "--layer", "colour=#0f0,skip=true"];
    let (said, code) = beamtick(folder.path(), &words);
    assert!(code == 0 && said.contains("marks of 7.000 mm, X 0.000 to 0.000, Y 0.000 to 7.000"), "{said}");
    // Nothing that a file names is read: /dev/zero has no end.
    let svg = page(&format!(
        "<pattern id=\"p\" width=\"5\" height=\"5\"><image href=\"/dev/zero\" width=\"5\" height=\"5\"/></pattern>\
         <rect width=\"9\" height=\"9\" fill=\"url(#p)\"/>{LINE}"
    ));
    let (said, code) = check(folder.path(), &svg);
    assert!(code == 0 && said.contains("marks of 1.414 mm"), "{said}");
    // What a reader of the file cannot see in it is said.
    let hairs = "<g stroke-width=\"0\"><path d=\"M0 0h9\" stroke=\"red\"/></g>\
         <path d=\"M0 0h9\" style=\"stroke:red; stroke-width:0mm\"/>";
    let (said, code) = check(folder.path(), &page(&format!("{hairs}{LINE}")));
    assert!(
        code == 0 && said.contains("a stroke-width of 0 is no stroke, and is not marked: give it a width (2)"),
        "{said}"
    );
    for size in ["", "width=\"100%\" height=\"100%\"", "width=\"10mm\" height=\"40\""] {
        let svg = page(LINE).replace("width=\"100mm\" height=\"100mm\"", size);
        let (said, code) = check(folder.path(), &svg);
        assert!(code == 0 && said.contains("no width and height with a unit"), "{size}: {said}");
    }
    // A page's own clip path cuts nothing.
    let svg = page(&format!(
        "<clipPath id=\"c\"><path d=\"M0 0H100V100H0z\"/></clipPath><g clip-path=\"url(#c)\">{LINE}</g>"
    ));
    let (said, code) = check(folder.path(), &svg);
    assert_eq!(code, 0, "{said}");
}
