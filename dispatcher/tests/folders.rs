//! The folders of the crate use each other one way only: a session calls the program and admission,
//! and nothing calls back.
use std::fs;
use std::path::{Path, PathBuf};

/// Folders and single files, lowest first. Each may use those before it, a folder also itself.
const ORDER: [&str; 15] = [
    "bounded_vec",
    "capacity",
    "refuse",
    "io_words",
    "board",
    "product",
    "configuration",
    "plan",
    "shadow",
    "tick_queue",
    "report",
    "admit",
    "program",
    "session",
    "test_hooks",
];

fn rank(module: &str) -> usize {
    ORDER.iter().position(|known| *known == module).unwrap_or_else(|| panic!("{module} has no rank"))
}

/// Files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn folders_use_each_other_one_way() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut uses = 0;
    for file in files(&source) {
        let own = file.strip_prefix(&source).unwrap().with_extension("");
        let own = own.iter().next().unwrap().to_str().unwrap();
        if own == "lib" {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        for part in code.flat_map(|line| line.split("crate::").skip(1)) {
            let used = part.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
            assert!(rank(used) <= rank(own), "{}: crate::{used}", file.display());
            uses += 1;
        }
    }
    assert!(uses > 100, "{uses}");
}

/// `all.rs` names each file of this folder, or its tests would not run.
#[test]
fn every_file_is_run() {
    let all = include_str!("all.rs");
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let files = fs::read_dir(tests).unwrap().map(|entry| entry.unwrap().path());
    for file in files.filter(|path| path.extension().is_some_and(|end| end == "rs") && !path.ends_with("all.rs")) {
        let name = file.file_stem().unwrap().to_str().unwrap();
        assert!(all.lines().any(|line| line == format!("mod {name};")), "all.rs has no `mod {name};`");
    }
}
