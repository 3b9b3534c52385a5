//! Every code block of README and docs: it is run here, or the table says which test runs it.
//!
//! A page's commands run one after the other in a folder of their own, as a reader runs them.
use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// What becomes of a block.
#[derive(Clone, Copy)]
enum Fate {
    /// Its lines are commands of `beamtick`, which end well.
    Runs,
    /// A file of inputs.
    Inputs,
    /// A configuration file.
    Configuration,
    /// A part of a machine file.
    Layers,
    /// The lasers of a machine file without any, and a layer.
    Lasers,
    /// This test runs it, or all of its page that runs.
    Held(&'static str),
    /// This step of `cargo check-all` or command of xtask does what it says: the text that its
    /// source has.
    Xtask(&'static str, &'static str),
    /// It shows something, and nobody types it.
    Figure,
    /// It needs what no machine of ours has: why.
    Needs(&'static str),
}

use Fate::{Configuration, Figure, Held, Inputs, Lasers, Layers, Needs, Runs, Xtask};

/// Page, how a block of it begins, what becomes of it.
const BLOCKS: &[(&str, &str, Fate)] = &[
    ("README.md", "cargo demo", Xtask("xtask/src/main.rs", "demo")),
    ("README.md", "cargo run --release -p beamtick", Runs),
    ("README.md", "bin/beamtick sim", Runs),
    ("docs/architecture.md", "", Figure),
    ("docs/board-mps2.md", "qemu-system-arm", Held("an_example_runs_on_the_emulated_board")),
    ("docs/c.md", "cargo build --release -p beamtick-gts ", Held("the_gts_page_is_followed")),
    ("docs/c.md", "cargo build --release -p beamtick-gts32", Held("integers_of_32_bits_and_guarded_memory")),
    ("docs/c.md", "rustup target add x86_64-pc-windows-gnu", Needs("Wine and MinGW")),
    ("docs/c.md", "#include <windows.h>", Needs("Wine and MinGW")),
    ("docs/c.md", "cargo xtask wheel", Held("a_wheel_is_all_that_a_new_environment_needs")),
    ("docs/c.md", "from beamtick import", Held("python_of_the_pages_runs")),
    ("docs/decisions/009-corner-speeds.md", "", Figure),
    ("docs/development.md", "cargo test ", Xtask("xtask/src/checks.rs", "host([\"test\"])")),
    ("docs/development.md", "cargo build --profile image", Xtask("xtask/src/checks.rs", "BEAMTICK_H743_IMAGE")),
    ("docs/drawings.md", "beamtick check", Runs),
    ("docs/first-engraving.md", "beamtick machine new", Held("the_first_engraving_works")),
    ("docs/first-engraving.md", "beamtick sim", Held("the_first_engraving_works")),
    ("docs/gallery.md", "beamtick sim examples/NAME.gts", Xtask("xtask/src/traces.rs", "examples")),
    ("docs/gcode.md", "beamtick check", Runs),
    ("docs/grbl.md", "beamtick grbl", Held("a_thousand_programs_that_are_streamed_end_where_their_files_end")),
    ("docs/grbl.md", "service device", Held("meerk40t_asks_and_sends_as_it_does")),
    ("docs/grbl.md", "rect", Held("meerk40t_asks_and_sends_as_it_does")),
    ("docs/grbl.md", "python3 -m venv mk", Held("meerk40t_asks_and_sends_as_it_does")),
    ("docs/guides/add-a-command.md", "0x0150", Figure),
    ("docs/guides/add-a-command.md", "cargo test", Xtask("xtask/src/checks.rs", "host([\"test\"])")),
    ("docs/jobs.md", "t_ms,input,level", Inputs),
    ("docs/jobs.md", "[axis.1-8]", Configuration),
    ("docs/json.md", "beamtick info --json", Runs),
    ("docs/laser.md", "", Figure),
    ("docs/machine.md", "beamtick machine new", Runs),
    ("docs/machine.md", "[lasers.engrave]", Lasers),
    ("docs/machine.md", "[[layers]]", Layers),
    ("docs/monitor.md", "virtual at tcp", Figure),
    ("docs/monitor.md", "beamtick serve", Held("the_block_is_printed_once_beside_the_client_that_commands")),
    ("docs/monitor.md", "beamtick run square.nc", Held("others_look_over_the_link_of_a_job_and_disturb_nothing")),
    ("docs/monitor.md", "beamtick monitor square.nc", Held("a_terminal_that_is_stuck_or_goes_away_leaves_no_light")),
    ("docs/protocol.md", "bytes -> COBS", Figure),
    ("docs/protocol.md", "# Cheshire and Baker", Held("cobs_is_that_of_the_page")),
    ("docs/protocol.md", "\"123456789\"", Held("checksums_are_those_of_the_page")),
    ("docs/protocol.md", "Hello |", Held("frames_are_those_of_the_page")),
    ("docs/protocol.md", "# the delimiter", Held("rejected_frames_are_rejected_for_the_reason_on_the_page")),
    ("docs/protocol.md", "lane=0", Held("requests_are_those_of_the_page")),
    ("docs/protocol.md", "tag=1", Held("replies_are_those_of_the_page")),
    ("docs/protocol.md", "00 01 07", Held("refusals_read_as_on_the_page")),
    ("docs/protocol.md", "00 01 01", Held("malformed_messages_are_reported_as_on_the_page")),
    ("docs/protocol.md", "head |", Held("a_trace_is_that_of_the_page")),
    ("docs/start-gts.md", "", Held("the_gts_page_is_followed")),
    ("docs/start-python.md", "python3 -m venv env", Held("a_wheel_is_all_that_a_new_environment_needs")),
    ("docs/start-python.md", "", Held("python_of_the_pages_runs")),
    ("docs/tour.md", "", Figure),
];

/// All pages that users and developers read.
fn pages() -> Vec<PathBuf> {
    fn below(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension() {
                _ if path.is_dir() => below(&path, found),
                Some(end) if end == "md" => found.push(path),
                _ => {}
            }
        }
    }
    let mut found = vec![Path::new(ROOT).join("README.md"), Path::new(ROOT).join("CONTRIBUTING.md")];
    below(&Path::new(ROOT).join("docs"), &mut found);
    found.sort();
    found
}

/// The code blocks of a page.
fn blocks(text: &str) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), None::<String>);
    for event in Parser::new(text) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(_) | CodeBlockKind::Indented)) => {
                open = Some(String::new())
            }
            Event::End(TagEnd::CodeBlock) => found.extend(open.take()),
            Event::Text(text) => open.iter_mut().for_each(|open| open.push_str(&text)),
            _ => {}
        }
    }
    found
}

fn beamtick(folder: &Path, words: &[&str]) -> (String, Option<i32>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_beamtick"))
        .args(words)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The usual answers, where it asks.
    let _ = child.stdin.take().unwrap().write_all("\n".repeat(60).as_bytes());
    let out = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    (said, out.status.code())
}

/// A folder with the examples in it, as the root of the project and of a release has them.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("examples")).unwrap();
    for entry in fs::read_dir(Path::new(ROOT).join("examples")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, folder.path().join("examples").join(path.file_name().unwrap())).unwrap();
        }
    }
    folder
}

/// Runs the lines of a block.
fn run(page: &str, block: &str, folder: &Path) {
    let mut ran = 0;
    for line in block.lines().filter(|line| !line.trim().is_empty()) {
        let command = ["cargo run --release -p beamtick -- ", "bin/beamtick ", "beamtick "];
        let command = command.iter().find_map(|begin| line.strip_prefix(begin));
        let Some(command) = command else { panic!("{page}: `{line}` is no command of beamtick") };
        let words: Vec<&str> = command.split(" #").next().unwrap().split_whitespace().collect();
        if words.contains(&"qemu") {
            // Needs an image; `cargo xtask traces` runs jobs there.
            continue;
        }
        let (said, code) = beamtick(folder, &words);
        assert_eq!(code, Some(0), "{page}: {line}: {said}");
        ran += 1;
    }
    assert!(ran > 0, "{page}: nothing of it runs: {block}");
}

/// The names of all tests, in Rust and in Python.
fn tests() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut folders = vec![PathBuf::from(ROOT)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && !["target", "out"].contains(&name.as_str()) && !name.starts_with('.') {
                folders.push(path);
            } else if name.ends_with(".rs") {
                let text = fs::read_to_string(&path).unwrap();
                let functions = text.lines().filter_map(|line| line.trim_start().strip_prefix("fn "));
                names.extend(functions.filter_map(|line| Some(line.split_once('(')?.0.to_owned())));
            }
        }
    }
    names
}

#[test]
fn every_code_block_of_the_pages_is_run() {
    let tests = tests();
    let mut used = BTreeSet::new();
    for path in pages() {
        let name = path.strip_prefix(ROOT).unwrap().to_string_lossy().into_owned();
        let folder = workplace();
        for block in blocks(&fs::read_to_string(&path).unwrap()) {
            let row =
                BLOCKS.iter().position(|(page, begins, _)| *page == name && block.trim_start().starts_with(begins));
            let Some(row) = row else { panic!("{name}: a code block is not in the table of this test:\n{block}") };
            used.insert(row);
            match BLOCKS[row].2 {
                Runs => run(&name, &block, folder.path()),
                Held(test) => assert!(tests.contains(test), "{name}: there is no test {test}"),
                Xtask(file, text) => {
                    let source = fs::read_to_string(Path::new(ROOT).join(file)).unwrap();
                    assert!(source.contains(text), "{name}: {file} has no `{text}`");
                }
                Inputs => {
                    fs::write(folder.path().join("in.csv"), &block).unwrap();
                    fs::write(folder.path().join("j.gts"), "GTN_AxisOn(2, 4);\nSleep(500);\n").unwrap();
                    let (said, code) = beamtick(folder.path(), &["sim", "j.gts", "--inputs", "in.csv"]);
                    assert_eq!(code, Some(0), "{name}: {said}");
                }
                Configuration => {
                    fs::write(folder.path().join("axes.toml"), &block).unwrap();
                    fs::write(folder.path().join("j.gts"), "GT_LoadConfig(\"axes.toml\");\nSleep(1);\n").unwrap();
                    let (said, code) = beamtick(folder.path(), &["sim", "j.gts"]);
                    assert_eq!(code, Some(0), "{name}: {said}");
                }
                Layers => {
                    let machine = fs::read_to_string(folder.path().join("machine.toml")).unwrap();
                    fs::write(folder.path().join("layers.toml"), machine + &block).unwrap();
                    let (said, code) = beamtick(folder.path(), &["machine", "check", "layers.toml"]);
                    assert!(code == Some(0) && said.contains("layer \"cut\""), "{name}: {said}");
                }
                Lasers => {
                    let machine = fs::read_to_string(folder.path().join("plotter.toml")).unwrap();
                    fs::write(folder.path().join("lasers.toml"), machine + &block).unwrap();
                    let (said, code) = beamtick(folder.path(), &["machine", "check", "lasers.toml"]);
                    assert!(code == Some(0) && said.contains("laser \"cut\", 8 V at 600 mm/min"), "{name}: {said}");
                }
                Needs(what) => assert!(!what.is_empty()),
                Figure => {}
            }
        }
    }
    let unused: Vec<&str> = (0..BLOCKS.len()).filter(|row| !used.contains(row)).map(|row| BLOCKS[row].1).collect();
    assert!(unused.is_empty(), "rows that no block needs: {unused:?}");
}

/// The first run on motors (docs/first-machine.md, step 5): the page gives the figures of that job.
#[test]
fn the_first_motion_is_small_and_has_the_figures_of_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(Path::new(ROOT).join("docs/first-machine.md")).unwrap();
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let step = page.split(" 5. Motors uncoupled").nth(1).unwrap().split(" 6. ").next().unwrap();
    let jobs: BTreeSet<&str> = step
        .split('`')
        .filter_map(|code| code.strip_prefix("beamtick "))
        .flat_map(str::split_whitespace)
        .filter(|word| word.ends_with(".gts"))
        .collect();
    assert_eq!(jobs.len(), 1, "one job is drawn and run: {jobs:?}");
    let job = Path::new(ROOT).join(jobs.first().unwrap());
    let (said, code) = beamtick(folder.path(), &["sim", job.to_str().unwrap(), "--trace", "t.csv"]);
    assert!(code == Some(0) && said.matches("planned 0.000000").count() == 2, "{said}");
    let trace = fs::read_to_string(folder.path().join("t.csv")).unwrap();
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("t_ms,axis1_pos,axis1_vel,axis2_pos,axis2_vel"));
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    for at in [1, 3] {
        let least = rows.iter().map(|row| row[at]).fold(f64::INFINITY, f64::min);
        let most = rows.iter().map(|row| row[at]).fold(f64::NEG_INFINITY, f64::max);
        let speed = rows.iter().map(|row| row[at + 1].abs()).fold(0.0, f64::max);
        assert_eq!((least, most, speed), (0.0, 400.0, 1.0), "column {at}");
    }
    assert!(rows.iter().all(|row| row[1] == 0.0 || row[3] == 0.0), "one axis at a time");
    assert!((rows.last().unwrap()[0] - 3500.0).abs() < 50.0);
    for figure in ["to 400 pulses and back to 0", "Neither goes below 0", "1 pulse/ms", "lasts 3.5 s"] {
        assert!(step.contains(figure), "{figure}: {step}");
    }
}
