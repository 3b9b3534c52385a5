//! Drawings in the virtual controller: marks against closed forms, and what is refused.
#[path = "drawing/generator.rs"]
mod generator;
mod judge;

use generator::{Drawing, Mark};
use judge::{Row, beamtick, rows};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// Pulses a mm of X and Y; X counts down.
const STEPS: f64 = 1000.0;
/// `arc_tolerance` of the machine.
const TOLERANCE: f64 = 0.002;
/// Half a pulse in both directions, what 24 bits leave of 300 mm, and a little.
const SLACK: f64 = 0.0012;

fn machine(layers: &str) -> String {
    let mut text = String::new();
    for (letter, number, invert) in [("x", 2, true), ("y", 1, false), ("z", 5, false)] {
        text += &format!(
            "[axes.{letter}]\nnumber = {number}\nsteps_per_mm = {STEPS}\ninvert = {invert}\ntravel = [-400, 400]\n\
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

const CELL: f64 = 0.2;

impl Near {
    fn new() -> Near {
        Near { lines: Vec::new(), cells: HashMap::new() }
    }

    /// A line shorter than a cell, and a power.
    fn add(&mut self, from: [f64; 2], to: [f64; 2], power: f64) {
        let middle = [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])];
        let cell = ((middle[0] / CELL).floor() as i64, (middle[1] / CELL).floor() as i64);
        self.cells.entry(cell).or_default().push(self.lines.len());
        self.lines.push((from, to, power));
    }

    /// The distance of the nearest line of this power.
    fn distance(&self, [x, y]: [f64; 2], power: f64) -> f64 {
        let (column, row) = ((x / CELL).floor() as i64, (y / CELL).floor() as i64);
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
    let mm = |row: &Row| [row.at[0] / -STEPS, row.at[1] / STEPS];
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
            if off > TOLERANCE + SLACK {
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
            if off > TOLERANCE + SLACK + if mark.is_end(*point) { 0.03 } else { 0.0 } {
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

#[test]
fn what_is_wrong_has_a_reason_and_nothing_moves() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let stroke = "stroke=\"#f00\"";
    let entities: String =
        (1..10).map(|k| format!("<!ENTITY a{k} \"{}\">", format!("&a{};", k - 1).repeat(10))).collect();
    let uses: String =
        (1..10).map(|k| format!("<g id=\"u{k}\">{}</g>", format!("<use href=\"#u{}\"/>", k - 1).repeat(10))).collect();
    let whole = page(LINE);
    let cases: Vec<(String, &str)> = vec![
        (whole[..whole.len() - 4].to_owned(), "d.svg:3: this is no whole SVG"),
        (whole[..120].to_owned(), "d.svg:2: this is no whole SVG"),
        (String::new(), "d.svg:1: this is no whole SVG"),
        ("G1 X5\n".to_owned(), "d.svg:1: this is no whole SVG"),
        ("<html/>".to_owned(), "d.svg:1: its root is <html>, not <svg>"),
        (page(&format!("<path d=\"M0 0LNaN 1\" {stroke}/>")), "d.svg:2: <path>: d is `M0 0LNaN 1`: segment 2"),
        (page(&format!("<path d=\"M0 0L1e30 1\" {stroke}/>")), "segment 2: 1000000000000000000000000000000 is beyond"),
        (page(&format!("<path d=\"M0 0L5 5L\" {stroke}/>")), "d.svg:2: <path>: d is `M0 0L5 5L`: segment 3"),
        (page(&format!("<circle r=\"NaN\" {stroke}/>")), "d.svg:2: <circle>: r is `NaN`"),
        (page(&format!("<circle r=\"-5\" {stroke}/>")), "d.svg:2: <circle>: r is `-5`: it is below 0"),
        (page(&format!("<rect width=\"inf\" height=\"5\" {stroke}/>")), "d.svg:2: <rect>: width is `inf`"),
        (page(&format!("<polygon points=\"0,0 5,5 5\" {stroke}/>")), "points is `0,0 5,5 5`: a number is missing"),
        (page(&format!("<g transform=\"rotate(x)\">{LINE}</g>")), "d.svg:2: <g>: transform is `rotate(x)`"),
        (
            page(&format!("<g transform=\"scale(1e6)\"><g transform=\"scale(1e6)\">{LINE}</g></g>")),
            "the path of line 2 goes farther than 1000000 mm",
        ),
        (
            page(&format!("<rect width=\"500\" height=\"5\" id=\"big\" {stroke}/>")),
            "`big` goes to X 500.000 mm in the machine",
        ),
        (
            page(&format!("<circle cx=\"399\" r=\"3\" {stroke}/><path d=\"M0-301V5\" {stroke}/>")),
            "the path of line 2 goes to Y 401.000 mm in the machine; the travel is -400 to 400 mm, --at moves a drawing; 2 shapes leave \
             the travel; the drawing covers X 0.000 to 402.000, Y 95.000 to 401.000 mm",
        ),
        (
            page("<text x=\"5\" y=\"5\">Beam</text>"),
            "d.svg:2: the text cannot be marked: convert text to paths in the drawing program",
        ),
        (
            page(&format!("{LINE}\n<g><text id=\"title\"><tspan>Beam</tspan></text></g>")),
            "d.svg:3: the text `title` cannot be marked: convert text to paths in the drawing program",
        ),
        (page("<image href=\"a.png\" width=\"5\" height=\"5\"/>"), "d.svg:2: an image cannot be marked"),
        (
            page(&format!("{LINE}<path d=\"M0 0L1 1\" {stroke} stroke-dasharray=\"1 two\"/>")),
            "d.svg:2: <path>: stroke-dasharray is `1 two`: ",
        ),
        (
            page(&format!("<g style=\"stroke-dasharray: 1,-2\">{LINE}</g>")),
            "d.svg:2: <g>: stroke-dasharray is `1,-2`: a length is below 0",
        ),
        (
            page(&format!("<path d=\"M0 0L1 1\" {stroke} stroke-dashoffset=\"x\"/>")),
            "d.svg:2: <path>: stroke-dashoffset is `x`: ",
        ),
        (
            page(&format!("{LINE}\n<path d=\"M0 0H50\" {stroke} stroke-dasharray=\"0.0001\"/>")),
            "with the dashes of the path of line 3 there are more than 100000: make them longer",
        ),
        (
            page(&format!("<path id=\"p\" pathLength=\"10\" d=\"M0 0H50\" {stroke} stroke-dasharray=\"1\"/>")),
            "the dashes of `p` have other units by its pathLength, which is not supported: remove that",
        ),
        (
            page(&format!(
                "<defs><path id=\"p\" pathLength=\"10\" d=\"M0 0H50\" {stroke}/></defs><use href=\"#p\" stroke-dasharray=\"1\"/>"
            )),
            "the dashes of a shape in the use of line 2 have other units by its pathLength",
        ),
        (
            page(&format!(
                "<g stroke-dasharray=\"1\"><path style=\"vector-effect:non-scaling-stroke\" d=\"M0 0H50\" {stroke}/></g>"
            )),
            "the dashes of the path of line 2 have other units by its vector-effect",
        ),
        (
            page(
                "<linearGradient id=\"g\"><stop/><stop offset=\"1\" stop-color=\"red\"/></linearGradient><path d=\"M0 0L1 1\" stroke=\"url(#g)\"/>",
            ),
            "the stroke of the path of line 2 is a gradient",
        ),
        (
            page(&format!(
                "<clipPath id=\"c\"><circle r=\"1\"/></clipPath><g id=\"cut\" clip-path=\"url(#c)\">{LINE}</g>"
            )),
            "the group `cut` is cut by a clip path",
        ),
        (page("<path d=\"M0 0L1 1\" stroke=\"#0f0\"/>"), "no layer takes #00ff00 (1 shapes)"),
        (
            page("<rect width=\"5\" height=\"5\"/>"),
            "there is nothing to mark: no shape has a stroke; shapes with a fill and no stroke are not marked (1)",
        ),
        (
            format!("<!DOCTYPE svg [<!ENTITY a0 \"xxxxxxxxxx\">{entities}]>\n{}", page("<g id=\"&a9;\"/>")),
            "entity reference loop",
        ),
        (
            page(&format!("<defs><g id=\"u0\">{LINE}</g>{uses}</defs><use href=\"#u9\"/>")),
            "more than 1,000,000 elements",
        ),
        (page(&format!("{}{LINE}{}", "<g>".repeat(10_000), "</g>".repeat(10_000))), "nested more than 1,000 deep"),
        (
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"0\" height=\"5\"/>".to_owned(),
            "d.svg:1: its width, height or viewBox",
        ),
    ];
    for (svg, says) in &cases {
        let begin = std::time::Instant::now();
        fs::write(folder.path().join("d.svg"), svg).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv"]);
        let shown: String = svg.chars().take(200).collect();
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{shown}: {code} {said}");
        assert!(said.len() < 800 && begin.elapsed().as_secs() < 20, "{shown}: {} bytes", said.len());
        assert!(!folder.path().join("t.csv").exists() && !folder.path().join("t.csv.partial").exists(), "{shown}");
    }
    for (bytes, says) in [
        (&[0xff, 0xd8, 0xff, 0xe0, 0, 1, 2][..], "d.svg:1: this is not UTF-8 text"),
        (&[0x1f, 0x8b, 8, 0], "it is compressed (.svgz)"),
        (&[0; 4096], "d.svg:1: this is no whole SVG"),
    ] {
        fs::write(folder.path().join("d.svg"), bytes).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.svg", "--machine", "m.toml"]);
        assert!(code == 2 && said.contains(says), "{said}");
    }
    fs::create_dir(folder.path().join("folder.svg")).unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    fs::write(folder.path().join("bare.toml"), machine("")).unwrap();
    fs::write(folder.path().join("d.svg"), page(LINE)).unwrap();
    for (words, says) in [
        (&["sim", "folder.svg", "--machine", "m.toml"][..], "folder.svg: the drawing cannot be read: Is a directory"),
        (&["sim", "folder", "--machine", "m.toml"], "folder: the job file cannot be read: Is a directory"),
        (&["sim", "d.svg"], "d.svg: G-code and drawings need --machine FILE"),
        (&["sim", "d.svg", "--machine", "bare.toml"], "the machine file has no [[layers]]"),
        (&["sim", "d.svg", "--machine", "m.toml", "--pass-stops"], "--pass-stops is for G-code"),
        (&["sim", "d.svg", "--machine", "m.toml", "--at", "5"], "it is X,Y in mm"),
        (
            &["sim", "d.svg", "--machine", "m.toml", "--layer", "power=90,speed=5"],
            "power is 90; it is 0 to 80 % (laser.power)",
        ),
        (&["sim", "d.svg", "--machine", "m.toml", "--layer", "powr=9,speed=5"], "the nearest known key is `power`"),
        (&["sim", "d.svg", "--machine", "m.toml", "--layer", "power"], "`power` is not KEY=VALUE"),
        (
            &["sim", "d.svg", "--machine", "m.toml", "--layer", "speed=5"],
            "--layer speed=5: it has no power; a layer needs power and speed",
        ),
        (
            &["sim", "d.svg", "--machine", "m.toml", "--layer", "colour=#f0,power=1,speed=5"],
            "colour is \"#f0\"; a colour is",
        ),
        (&["import", "d.svg", "--machine", "m.toml", "-o", "d.svg"], "would overwrite a file"),
    ] {
        let (said, code) = beamtick(folder.path(), words);
        assert!(code == 2 && said.contains(says), "{words:?}: {said}");
    }
}

/// What the reader of SVG itself complains of without a place, and groups without an id.
#[test]
fn errors_name_the_line_or_the_shape_where_it_can_be_found() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let filter = "<filter id=\"f\"><feGaussianBlur stdDeviation=\"1\"/></filter>";
    let clip =
        "<clipPath id=\"c\"><circle r=\"0.1\"/></clipPath><mask id=\"m\"><rect width=\"9\" height=\"9\"/></mask>";
    let blurred = "<path d=\"M0 0H9\" stroke=\"#f00\" filter=\"url(#f)\"/>";
    let cases: &[(String, &str)] = &[
        (format!("{LINE}\n<g><path d=\"M0 0H9\" stroke=\"foo\"/></g>"), "d.svg:3: <path>: stroke is `foo`"),
        (format!("{LINE}\n<g style=\"stroke: foo\">\n<path d=\"M0 0H9\"/></g>"), "d.svg:3: <g>: stroke is `foo`"),
        (
            format!("<style>.x {{ stroke: foo }}</style>\n<path class=\"x\" d=\"M0 0H9\"/>{LINE}"),
            "d.svg: stroke is `foo`, which cannot be read",
        ),
        (format!("{LINE}\n<g id=\"a\"><use href=\"#a\"/></g>"), "d.svg:3: <use> shows itself"),
        (format!("{LINE}\n<use id=\"u\" href=\"#u\"/>"), "d.svg:3: <use> shows itself"),
        (
            format!("<g id=\"a\">{LINE}\n<use href=\"#b\"/></g><g id=\"b\"><g>\n<use href=\"#a\"/></g></g>"),
            "d.svg:3: <use> shows itself",
        ),
        (
            format!("{LINE}\n<use href=\"other.svg#a\"/>"),
            "d.svg:3: <use> shows `other.svg#a` of another file, which is not read",
        ),
        (format!("{filter}{LINE}\n{blurred}"), "d.svg:3: Filters on zero-sized shapes are not allowed"),
        (
            format!("{filter}{LINE}\n{blurred}\n{blurred}"),
            "d.svg: Filters on zero-sized shapes are not allowed: one of the elements with a filter, of lines 3, 4",
        ),
        (format!("{clip}\n<g clip-path=\"url(#c)\">{LINE}{LINE}</g>"), "the g of line 3 is cut by a clip path"),
        (format!("{clip}\n<g mask=\"url(#m)\">{LINE}{LINE}</g>"), "the g of line 3 has a mask"),
        (format!("{clip}\n<g id=\"own\" mask=\"url(#m)\">{LINE}{LINE}</g>"), "the group `own` has a mask"),
        (
            format!("{clip}\n<path clip-path=\"url(#c)\" d=\"M0 0L1 1\" stroke=\"red\"/>"),
            "the path of line 3 is cut by a clip path",
        ),
        (
            format!("{clip}<defs><g id=\"p\" clip-path=\"url(#c)\">{LINE}</g></defs>\n<use href=\"#p\"/>"),
            "a shape in the use of line 3 is cut by a clip path",
        ),
        (
            format!(
                "<defs>{}</defs>\n<use href=\"#p\"/>",
                LINE.replace("<path", "<path id=\"p\" transform=\"scale(5000)\"")
            ),
            "a shape in the use of line 3 goes to",
        ),
    ];
    for (inside, says) in cases {
        let svg = page(inside);
        fs::write(folder.path().join("d.svg"), &svg).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv"]);
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{svg}: {code} {said}");
        assert!(!said.contains("beamtick:"), "{said}");
        assert!(!folder.path().join("t.csv").exists(), "{svg}");
    }
}

/// What a drawing has and is not marked is said, as what it is.
#[test]
fn what_is_passed_over_is_noted_as_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let other = "<path d=\"M0 0H5\" stroke=\"#f00\"/>";
    let filled = "shapes with a fill and no stroke";
    for (inside, says, not) in [
        ("<use href=\"#missing\"/>", "the use of line 3 shows `#missing`, which does not exist", "(with"),
        ("<use href=\"#a\"/>\n<use href=\"#b\"/>", "shows `#a`, which does not exist (with it 2", "`#b`"),
        ("<use/>", "the use of line 3 shows nothing: it has no href", filled),
        ("<g display=\"none\"><use href=\"#missing\"/></g><use href=\"#d\"/><defs><g id=\"d\"/></defs>", "", "shows"),
        (
            "<path d=\"M9 9H5V5\" stroke=\"context-stroke\"/>",
            "context-stroke and context-fill are no stroke outside of a marker or a `use` (1)",
            filled,
        ),
        (
            "<g style=\"stroke:context-fill\"><path d=\"M9 9H5V5\" fill=\"none\"/></g>",
            "context-stroke and context-fill are no stroke outside of a marker or a `use` (1)",
            filled,
        ),
        (
            "<defs><path id=\"d\" d=\"M0 9V5\" fill=\"none\" stroke=\"context-stroke\"/></defs><use href=\"#d\"/>",
            "",
            "context",
        ),
        (
            "<path d=\"M0 9V5\" stroke=\"red\" visibility=\"hidden\"/>",
            "what is hidden by its visibility is not marked (1)",
            "transparent",
        ),
        (
            "<path d=\"M0 9V5\" stroke=\"red\" stroke-opacity=\"0\"/>",
            "what is fully transparent is not marked (1)",
            "hidden",
        ),
    ] {
        let (said, code) = check(folder.path(), &page(&format!("{other}\n{inside}")));
        assert!(code == 0 && said.contains("marks of 5.000 mm"), "{inside}: {said}");
        assert!(said.contains(says) && !said.contains(not), "{inside}: {said}");
    }
    // The colour of a `use` is that of what it shows.
    let shown =
        "<defs><path id=\"d\" d=\"M0 9V5\" stroke=\"context-stroke\"/></defs><use href=\"#d\" stroke=\"#f00\"/>";
    let (said, code) = check(folder.path(), &page(shown));
    assert!(code == 0 && said.contains("marks of 4.000 mm") && !said.contains("context"), "{said}");
}

/// The note about a page's size says what is done.
#[test]
fn the_note_about_the_size_of_a_page_is_true() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (size, marks, note) in [
        ("width=\"100mm\" viewBox=\"0 0 100 50\"", "marks of 10.000 mm, X 0.000 to 10.000, Y 50.000", ""),
        ("height=\"50mm\" viewBox=\"0 0 100 50\"", "marks of 10.000 mm, X 0.000 to 10.000, Y 50.000", ""),
        ("style=\"width:100mm;height:50mm\" viewBox=\"0 0 100 50\"", "marks of 2.646 mm", "26.458 mm wide"),
        ("width=\"192\" viewBox=\"0 0 100 50\"", "marks of 5.080 mm", "50.800 mm wide and 25.400 mm high"),
        ("viewBox=\"0 0 96 48\"", "marks of 2.646 mm", "25.400 mm wide and 12.700 mm high"),
        ("width=\"96\" height=\"48\"", "marks of 2.646 mm", "25.400 mm wide and 12.700 mm high"),
    ] {
        let line = "<path d=\"M0 0H10\" stroke=\"red\"/>";
        let svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {size}>{line}</svg>");
        let (said, code) = check(folder.path(), &svg);
        assert!(code == 0 && said.contains(marks) && said.contains(note), "{size}: {said}");
        assert_eq!(said.contains("a unit"), !note.is_empty(), "{size}: {said}");
    }
}

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

#[test]
fn a_dxf_whose_shapes_have_heights_says_that_they_are_flat_here() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (to, says) in [("7", true), ("0", false)] {
        let line = format!("0\nLINE\n8\n0\n62\n1\n10\n0\n20\n0\n30\n0\n11\n10\n21\n0\n31\n{to}\n");
        let dxf = format!("0\nSECTION\n2\nENTITIES\n{line}0\nENDSEC\n0\nEOF\n");
        fs::write(folder.path().join("z.dxf"), dxf).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "z.dxf", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("marks of 10.000 mm"), "{said}");
        let note = "z.dxf: note: shapes at several Z are marked in the plane of X and Y (1)";
        assert_eq!(said.contains(note), says, "{said}");
    }
}

/// A DXF with layers (name, other groups) and entities.
fn dxf(layers: &[(&str, &str)], entities: &str) -> String {
    let rows: String = layers.iter().map(|(name, groups)| format!("0\nLAYER\n2\n{name}\n{groups}")).collect();
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n{rows}0\nENDTAB\n\
         0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
}

/// AutoCAD's names have no case: of layers that are off, frozen or not plotted, of those of the
/// machine file, and of those whose ends meet.
#[test]
fn names_of_layers_have_no_case() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let line =
        |layer: &str, y: u32, to: u32| format!("0\nLINE\n8\n{layer}\n62\n1\n10\n0\n20\n{y}\n11\n{to}\n21\n{y}\n");
    let off = "on a layer that is off or frozen is not marked (1)";
    let unplotted = "what is on a layer that is not plotted is not marked (1)";
    for (layers, layer, says) in [
        (&[("A", "70\n1\n")][..], "a", off),
        (&[("a", "62\n-7\n")], "A", off),
        (&[("\u{c4}u\u{df}en", "70\n1\n")], "\u{e4}u\u{df}EN", off),
        (&[("A", "290\n0\n")], "A", unplotted),
        (&[("A", "290\n0\n")], "a", unplotted),
        // A program whose names have a case.
        (&[("A", ""), ("a", "70\n1\n")], "a", off),
        (&[("Aa", ""), ("aA", "70\n1\n")], "aa", off),
    ] {
        let drawing = dxf(layers, &(line(layer, 5, 9) + &line("B", 0, 3)));
        fs::write(folder.path().join("d.dxf"), drawing).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("marks of 3.000 mm"), "{layers:?} {layer}: {said}");
        assert!(said.contains(says), "{layers:?} {layer}: {said}");
    }
    for (layers, layer) in [(&[("A", "290\n1\n")][..], "a"), (&[("A", "70\n1\n"), ("a", "")], "a")] {
        fs::write(folder.path().join("d.dxf"), dxf(layers, &line(layer, 5, 9))).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("marks of 9.000 mm") && !said.contains("not marked"), "{layers:?}: {said}");
    }
    // Of the machine file, and of ends that meet.
    let corner = "0\nLINE\n8\nCut\n62\n1\n10\n9\n20\n5\n11\n9\n21\n0\n";
    fs::write(folder.path().join("d.dxf"), dxf(&[], &(line("cUT", 5, 9) + corner))).unwrap();
    let only = ["--layer", "layer=CUT,power=5,speed=900"];
    let words = [&["import", "d.dxf", "--machine", "m.toml", "-o", "d.gts"][..], &only].concat();
    let (said, code) = beamtick(folder.path(), &words);
    assert_eq!(code, 0, "{said}");
    let job = fs::read_to_string(folder.path().join("d.gts")).unwrap();
    assert_eq!(job.matches("BufLaserOn").count(), 1, "one shape\n{job}");
    // What is invisible is not on a layer that is off.
    fs::write(folder.path().join("d.dxf"), dxf(&[], &(line("A", 5, 9) + &line("A\n60\n1", 0, 3)))).unwrap();
    let (said, code) = beamtick(folder.path(), &["check", "d.dxf", "--machine", "m.toml"]);
    assert!(code == 0 && said.contains("what is invisible is not marked (1)"), "{said}");
}

/// Bulges of a rounding, and of arcs so flat that their centres are kilometres away.
#[test]
fn flat_arcs_of_a_dxf_are_marked_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    for (bulge, chord, sagitta) in [
        ("1e-7", 10.0, 0.0),
        ("-1e-7", 10.0, 0.0),
        ("5e-324", 10.0, 0.0),
        ("1e-5", 10.0, 0.0),
        ("4e-4", 200.0, 0.04),
        ("-5e-5", 350.0, -0.00875),
    ] {
        let entities = format!("0\nLWPOLYLINE\n62\n1\n90\n2\n70\n0\n10\n0\n20\n1\n42\n{bulge}\n10\n{chord}\n20\n1\n");
        fs::write(folder.path().join("d.dxf"), dxf(&[], &entities)).unwrap();
        let words = ["sim", "d.dxf", "--machine", "m.toml", "--tick-us", "100", "--trace", "t.csv", "--strict"];
        let (said, code) = beamtick(folder.path(), &words);
        assert_eq!(code, 0, "{bulge}: {said}");
        let count = 4000;
        let points = (0..=count).map(|k| {
            let t = f64::from(k) / f64::from(count);
            [chord * t, 1.0 - 4.0 * sagitta * t * (1.0 - t)]
        });
        let what = format!("the bulge {bulge}");
        let mark = Mark { points: points.collect(), red: true, what, corners: Vec::new() };
        differs(&[mark], &rows(&folder.path().join("t.csv"))).unwrap_or_else(|why| panic!("{bulge}: {why}"));
    }
}

/// Lines, arcs, circles, polylines with bulges, an ellipse, splines and a block, written by another
/// program, which also evaluated their points (ezdxf; those of circles by sine and cosine).
#[test]
fn a_dxf_is_marked_where_another_program_says() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    fs::write(folder.path().join("plate.dxf"), include_str!("drawing/plate.dxf")).unwrap();
    let mut marks: Vec<Mark> = Vec::new();
    for line in include_str!("drawing/plate.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (number, point) = (cells[0] as usize, [cells[2], cells[3]]);
        if number == marks.len() {
            let what = format!("mark {number}");
            marks.push(Mark { points: vec![point], red: cells[1] == 1.0, what, corners: Vec::new() });
            continue;
        }
        let points = &mut marks[number].points;
        let from = points[points.len() - 1];
        let count = ((point[0] - from[0]).hypot(point[1] - from[1]) / 0.02).ceil().max(1.0) as u32;
        let on = |k: u32| [0, 1].map(|axis| from[axis] + (point[axis] - from[axis]) * f64::from(k) / f64::from(count));
        points.extend((1..=count).map(on));
    }
    let words = ["sim", "plate.dxf", "--machine", "m.toml", "--tick-us", "100", "--trace", "t.csv", "--strict"];
    let (said, code) = beamtick(folder.path(), &words);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("on a layer that is off or frozen is not marked (1)"), "{said}");
    differs(&marks, &rows(&folder.path().join("t.csv"))).unwrap();
    // Units, and layers by name and by number.
    let inches = include_str!("drawing/plate.dxf").replace("$INSUNITS\n 70\n4\n", "$INSUNITS\n 70\n1\n");
    fs::write(folder.path().join("inch.dxf"), inches).unwrap();
    let only = ["--layer", "layer=CUT,colour=1,power=5,speed=900", "--layer", "skip=true", "--at", "-300,-300"];
    let (said, code) = beamtick(folder.path(), &[&["check", "inch.dxf", "--machine", "m.toml"][..], &only].concat());
    assert!(code == 2 && said.contains("goes to Y 886.4"), "{said}");
    let (said, code) = beamtick(folder.path(), &[&["check", "plate.dxf", "--machine", "m.toml"][..], &only].concat());
    assert!(code == 0 && said.contains("X -300.000 to -200.000, Y -300.000 to -240.000"), "{said}");
}

#[test]
fn what_is_wrong_in_a_dxf_has_line_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(LAYERS)).unwrap();
    let with = |entities: &str| format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
    let line = "0\nLINE\n62\n1\n10\n0\n20\n0\n11\n5\n21\n5\n";
    let blocks = |inner: &str, entities: &str| format!("0\nSECTION\n2\nBLOCKS\n{inner}0\nENDSEC\n{}", with(entities));
    let bomb: String = (0..12)
        .map(|k| {
            let inner =
                if k == 0 { line.to_owned() } else { format!("0\nINSERT\n2\nB{}\n10\n0\n20\n0\n", k - 1).repeat(10) };
            format!("0\nBLOCK\n2\nB{k}\n10\n0\n20\n0\n{inner}0\nENDBLK\n8\n0\n")
        })
        .collect();
    let spline = |degree: u32, knots: &str| {
        let points: String = (0..4).map(|k| format!("10\n{k}\n20\n{}\n", k * k)).collect();
        let knots: String = knots.split(' ').map(|knot| format!("40\n{knot}\n")).collect();
        with(&format!("0\nSPLINE\n62\n1\n71\n{degree}\n{knots}{points}"))
    };
    let cases: Vec<(String, &str)> = vec![
        (with(line).replace("EOF\n", ""), "this is no whole DXF: the file ends before its EOF"),
        (with(line)[..60].to_owned(), "d.dxf:18: this is no whole DXF: the file ends among its entities"),
        (String::new(), "d.dxf:1: this is no whole DXF"),
        ("G1 X5\nG1 X6\n".to_owned(), "d.dxf:1: this is no DXF: `G1 X5` is no group code"),
        (with(&line.replace("11\n5", "11\nnan")), "d.dxf:14: `nan`, of group 11, is no number within"),
        (with(&line.replace("11\n5", "11\n1e300")), "`1e300`, of group 11, is no number within"),
        (with(&line.replace("11\n5\n", "")), "a LINE has no group 11"),
        (with(&line.replace("62\n1", "62\n3")), "takes colour 3 (#00ff00) on layer `0` (1 shapes)"),
        (with(&line.replace("11\n5", "11\n5000")), "the LINE of line 6 goes to X 5000.000 mm"),
        (with("0\nCIRCLE\n62\n1\n10\n0\n20\n0\n40\n0\n"), "d.dxf:6: the radius of a CIRCLE is 0; it is above 0"),
        (with("0\nTEXT\n1\nhello\n"), "d.dxf:6: TEXT is not supported: make lines"),
        (with("0\nHATCH\n"), "HATCH is not supported"),
        (with("0\nARC\n10\n0\n20\n0\n40\n5\n50\n0\n51\n9\n210\n1\n220\n0\n230\n0\n"), "is not in the plane of X and Y"),
        (with("0\nINSERT\n2\nNONE\n10\n0\n20\n0\n"), "the block `NONE` does not exist, or is in itself"),
        (blocks(&bomb, "0\nINSERT\n2\nB11\n10\n0\n20\n0\n"), "blocks make more than 1000000 shapes"),
        (spline(5, "0 0"), "a SPLINE has the degree 5; 1 to 3"),
        (spline(3, "0 0 0 0 1 1 1"), "a SPLINE has 7 knots for 4 control points; they are 8"),
        (spline(3, "0 0 0 0 1 1 0 1"), "and never fall"),
        (with(""), "there is nothing to mark"),
        ("AutoCAD Binary DXF\r\n\u{1a}\u{0}".to_owned(), "it is a binary DXF; save it as ASCII"),
        ("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n3\n0\nENDSEC\n".to_owned() + &with(line), "its unit ($INSUNITS 3)"),
    ];
    for (dxf, says) in &cases {
        fs::write(folder.path().join("d.dxf"), dxf).unwrap();
        let begin = std::time::Instant::now();
        let (said, code) = beamtick(folder.path(), &["sim", "d.dxf", "--machine", "m.toml", "--trace", "t.csv"]);
        let shown: String = dxf.chars().take(200).collect();
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{shown}: {code} {said}");
        assert!(said.len() < 900 && begin.elapsed().as_secs() < 20, "{shown}: {} bytes", said.len());
        assert!(!folder.path().join("t.csv").exists(), "{shown}");
    }
}
