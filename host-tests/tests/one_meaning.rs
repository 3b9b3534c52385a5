//! A type's name has one meaning: in the crates of the controller together, in each crate for a
//! board, and in each crate of the host.
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The crates of the controller that every board has.
const CONTROLLER: [&str; 5] = ["protocol", "ring", "servo", "plant", "dispatcher"];

/// Names that several of their files use, and why.
const SHARED: &[(&str, &str)] = &[
    ("Fault", "why a frame was refused, of each of two layers; what ended the last run"),
    ("Full", "a queue has no room, always beside that queue"),
    ("Lane", "immediate or program, of a record and of an entry of the tick"),
    ("Ns", "time in ns: a bare number on the link, a quantity in the tick"),
    ("Refused", "why data was refused, always beside its check: `pt::segment::Refused`"),
];

/// Names that several files of one crate use, and why.
const SHARED_IN: &[(&str, &[(&str, &str)])] = &[
    (
        "hal",
        &[
            ("Board", "the parts of each of two machines, of which an image has one"),
            ("Bus", "what each of two controllers of a wire shares: SPI, USB"),
            ("Idle", "of each machine"),
            ("Machine", "of each machine"),
            ("ResetCause", "of each machine"),
            ("Rx", "of each machine"),
            ("TickTimer", "of each machine"),
            ("Tx", "of each machine"),
            ("Usb", "the controller, and what of it a board has wired"),
        ],
    ),
    ("firmware", &[("Parts", "what the entry point hands over, with USB and without")]),
    (
        "host/beamtick",
        &[
            ("Check", "a subcommand, and a check of its rows in `bring-up`"),
            ("Facts", "what a command prints, a struct for each command and the enum of them"),
            ("Known", "of a job for viewers, and of ticks in `bring-up`"),
            ("Report", "of a job, of `--json`, of `bring-up`: each in its module"),
            ("Run", "the arguments of `run`, and a job that has run"),
            ("Steps", "the option `--steps`, and the steps of a job"),
            ("Terminal", "of the error stream, and of a person's answers in `bring-up`"),
        ],
    ),
    ("host/drawing", &[("Map", "an affine map, of each format with the arithmetic that its library needs")]),
    ("host/gts", &[("Virtual", "an open virtual controller, with its memory and with its clock")]),
    ("host/h743", &[("Change", "of an output: of the DAC, of a pin")]),
];

/// Files of production code below a folder.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            files(&path, found);
        } else if name.ends_with(".rs") && !["tests.rs", "test_hooks.rs", "exhaustive_delivery.rs"].contains(&name) {
            found.push(path);
        }
    }
}

/// The types that a text declares; aliases inside an `impl` are not its own.
fn declared(text: &str) -> impl Iterator<Item = &str> {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
    text.lines().filter_map(|line| {
        let bare = line.trim_start();
        let is_indented = bare.len() < line.len();
        let bare = bare.strip_prefix("pub").map_or(bare, |rest| {
            let rest = rest.strip_prefix('(').and_then(|rest| rest.split_once(')')).map_or(rest, |(_, rest)| rest);
            rest.trim_start()
        });
        let (keyword, rest) = bare.split_once(' ')?;
        let counts = matches!(keyword, "struct" | "enum" | "union" | "trait") || keyword == "type" && !is_indented;
        let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
        (counts && name.starts_with(char::is_uppercase)).then_some(name)
    })
}

fn repeated<'a>(texts: impl Iterator<Item = &'a str>) -> (usize, Vec<&'a str>) {
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    texts.flat_map(declared).for_each(|name| *names.entry(name).or_default() += 1);
    (names.len(), names.into_iter().filter(|(_, count)| *count > 1).map(|(name, _)| name).collect())
}

/// How many types the files of folders declare, and the names that several declare.
fn of_crates(crates: &[&str]) -> (usize, Vec<String>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    crates.iter().for_each(|name| files(&root.join(name).join("src"), &mut found));
    let texts: Vec<String> = found.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let (types, repeated) = repeated(texts.iter().map(String::as_str));
    (types, repeated.into_iter().map(str::to_owned).collect())
}

fn names(shared: &[(&'static str, &'static str)]) -> Vec<&'static str> {
    shared.iter().map(|(name, _)| *name).collect()
}

#[test]
fn a_type_has_one_meaning() {
    let (types, repeated) = of_crates(&CONTROLLER);
    assert!(types > 300, "{types} types");
    assert_eq!(repeated, names(SHARED), "a name has two meanings: find another one, or say why in `SHARED`");
}

#[test]
fn a_type_has_one_meaning_in_each_crate_for_a_board_and_of_the_host() {
    let host = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host");
    let folders = std::fs::read_dir(host).unwrap().map(|entry| entry.unwrap().path());
    let crates = folders.filter(|path| path.join("src").is_dir());
    let mut crates: Vec<String> =
        crates.map(|path| format!("host/{}", path.file_name().unwrap().to_str().unwrap())).collect();
    crates.extend(["hal", "firmware"].map(str::to_owned));
    assert!(SHARED_IN.iter().all(|(name, _)| crates.iter().any(|known| known == name)));
    let mut wrong = Vec::new();
    for name in &crates {
        let shared = SHARED_IN.iter().find(|(of, _)| of == name).map_or(&[][..], |(_, shared)| shared);
        let (_, repeated) = of_crates(&[name]);
        if repeated != names(shared) {
            wrong.push(format!("{name}: {repeated:?}, of which {:?} are known", names(shared)));
        }
    }
    assert!(
        wrong.is_empty(),
        "a name has two meanings: find another one, or say why in `SHARED_IN`:\n{}",
        wrong.join("\n")
    );
}

#[test]
fn a_second_meaning_is_found() {
    let texts = ["pub(super) struct Row;\nimpl X {\n    type Item = u8;\n}", "    enum Row {", "pub type Item = u8;"];
    assert_eq!(repeated(texts.into_iter()), (2, vec!["Row"]));
}
