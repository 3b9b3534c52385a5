//! A type's name has one meaning in the crates of the controller.
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Names that several files use, and why.
const SHARED: &[(&str, &str)] = &[
    ("Fault", "why a frame was refused, of each of two layers; what ended the last run"),
    ("Full", "a queue has no room, always beside that queue"),
    ("Lane", "immediate or program, of a record and of an entry of the tick"),
    ("Ns", "time in ns: a bare number on the link, a quantity in the tick"),
    ("Refused", "why data was refused, always beside its check: `pt::segment::Refused`"),
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

#[test]
fn a_type_has_one_meaning() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    for name in ["protocol", "ring", "servo", "plant", "dispatcher"] {
        files(&root.join(name).join("src"), &mut found);
    }
    let texts: Vec<String> = found.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let (types, repeated) = repeated(texts.iter().map(String::as_str));
    assert!(types > 300, "{types} types");
    let shared: Vec<&str> = SHARED.iter().map(|(name, _)| *name).collect();
    assert_eq!(repeated, shared, "a name has two meanings: find another one, or say why in `SHARED`");
}

#[test]
fn a_second_meaning_is_found() {
    let texts = ["pub(super) struct Row;\nimpl X {\n    type Item = u8;\n}", "    enum Row {", "pub type Item = u8;"];
    assert_eq!(repeated(texts.into_iter()), (2, vec!["Row"]));
}
