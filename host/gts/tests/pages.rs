//! The pages for people with a program or a script, followed from top to bottom.
//!
//! A page is run in a folder that looks like the root of the project; what cargo builds is that of
//! this test.

mod toolchain;

use std::path::{Path, PathBuf};
use std::process::Command;
use toolchain::{command, libraries, output_of, root, scratch, skip};

/// The fenced blocks of a page in a language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join("docs").join(page)).unwrap();
    let mut found = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line == format!("```{language}") {
            let block: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
            found.push(block.join("\n"));
        }
    }
    found
}

/// A folder with the sources, the examples, and the libraries where a release build puts them.
fn workplace(name: &str) -> PathBuf {
    let folder = scratch().join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("target")).unwrap();
    std::fs::create_dir_all(folder.join("examples")).unwrap();
    let link = |from: PathBuf, to: &str| std::os::unix::fs::symlink(from, folder.join(to)).unwrap();
    link(root().join("host"), "host");
    link(libraries(), "target/release");
    link(root().join("examples/c"), "examples/c");
    std::fs::copy(root().join("examples/test.cfg"), folder.join("examples/test.cfg")).unwrap();
    folder
}

fn has(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|done| done.status.success())
}

#[test]
fn the_gts_page_is_followed() {
    if !has("g++") {
        return skip("there is no g++");
    }
    let folder = workplace("page_gts");
    let mut script = "set -e\n".to_owned();
    for block in blocks("start-gts.md", "sh") {
        // Cargo has built the library for this test.
        let lines = block.lines().filter(|line| !line.starts_with("cargo build"));
        lines.for_each(|line| script += &format!("{line}\n"));
    }
    let mut shell = command(Path::new("sh"), &[]);
    let said = output_of(shell.args(["-c", &script]).current_dir(&folder));
    assert!(said.lines().filter(|line| line.contains("_PtData(")).count() == 3, "{said}");
    let picture = std::fs::read(folder.join("pt_static.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000, "{}", picture.len());
    let log = std::fs::read_to_string(folder.join("pt_static.log")).unwrap();
    assert!(log.contains("PtStart") && log.contains("Close"), "{log}");
    // The same build as the C page names it.
    let build = blocks("c.md", "sh").remove(0);
    let build = build.lines().find(|line| line.starts_with("g++")).unwrap();
    let build = format!("cp examples/c/pt_static.cpp program.cpp; cp examples/c/example.h .; {build}");
    output_of(command(Path::new("sh"), &[]).args(["-e", "-c", &build]).current_dir(&folder));
    // A page that can be enlarged.
    let variables = [("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_PLOT", "../t.html")];
    output_of(command(&folder.join("pt_static"), &variables).current_dir(folder.join("examples")));
    let page = std::fs::read_to_string(folder.join("t.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("axis 1 position (pulse)"), "{}", page.len());
}

#[test]
fn python_of_the_pages_runs() {
    if !has("python3") {
        return skip("there is no python3");
    }
    let folder = workplace("page_python");
    for page in ["start-python.md", "c.md"] {
        let script = blocks(page, "python").join("\n");
        let library = libraries().join("libgts.so").to_string_lossy().into_owned();
        let package = root().join("host/python").to_string_lossy().into_owned();
        let variables =
            [("BEAMTICK_LIBRARY", library.as_str()), ("PYTHONPATH", &package), ("PYTHONDONTWRITEBYTECODE", "1")];
        let said = output_of(command(Path::new("python3"), &variables).args(["-c", &script]).current_dir(&folder));
        if page == "start-python.md" {
            assert!(said.starts_with("20000.0\n") && said.contains("7 AxisOn: axis is 99"), "{said}");
            assert!(folder.join("first.png").is_file());
        } else {
            assert!(folder.join("t.png").is_file());
        }
    }
}
