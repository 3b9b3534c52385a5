//! Mutants: the code broken on purpose in one place, and the test that must see it.
//!
//! In: the list of [`LIST`]. Out: a table of what became of each; an error if one survives, does not compile, or if its
//! text is not in its file exactly once. Each is put into a copy of the tree under `target/mutants`, so that the checkout
//! stays as it is. The tests must pass in that copy before anything is broken, or their failures would say nothing.
mod list;

use crate::shell::{self, Outcome, cargo, read, root, target};
use list::{LIST, Mutant};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A test that takes longer hangs, which is one way to see a mutant.
const PATIENCE: Duration = Duration::from_secs(600);

/// What became of a mutant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    Caught,
    Hung,
    Survived,
    Broken,
}

impl Fate {
    fn word(self) -> &'static str {
        match self {
            Fate::Caught => "caught",
            Fate::Hung => "caught (the test hangs)",
            Fate::Survived => "SURVIVED",
            Fate::Broken => "DOES NOT COMPILE",
        }
    }
}

/// Every mutant's text stands in its file exactly once.
pub fn check() -> Outcome {
    if LIST.len() < 20 {
        return Err(format!("{} mutants; at least 20 are asked for", LIST.len()));
    }
    let wrong: Vec<String> = LIST.iter().filter_map(|mutant| mutated(&root(), mutant).err()).collect();
    if wrong.is_empty() {
        println!("{} mutants, each in its place", LIST.len());
        return Ok(());
    }
    Err(format!("{}\nthe text has changed: bring xtask/src/mutants/list.rs up to date", wrong.join("\n")))
}

/// Runs the mutants whose name holds `only`.
pub fn run(only: &str) -> Outcome {
    check()?;
    let chosen: Vec<&Mutant> = LIST.iter().filter(|mutant| mutant.name.contains(only)).collect();
    if chosen.is_empty() {
        return Err(format!("no mutant is called {only}"));
    }
    let tree = copy()?;
    let tests: BTreeSet<&[&str]> = chosen.iter().map(|mutant| mutant.test).collect();
    for test in tests {
        if fate(&tree, test)? != Fate::Survived {
            return Err(format!("`cargo test {}` does not pass on the code as it is", test.join(" ")));
        }
    }
    let mut rows = Vec::new();
    for mutant in &chosen {
        let (path, began) = (tree.join(mutant.file), Instant::now());
        let text = mutated(&tree, mutant)?;
        let before = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        write(&path, &text)?;
        let fate = fate(&tree, mutant.test);
        write(&path, &before)?;
        let fate = fate?;
        let row =
            format!("{:<24} {:<44} {} ({:.0} s)", fate.word(), mutant.name, mutant.file, began.elapsed().as_secs_f64());
        println!("{row}");
        rows.push((fate, row));
    }
    println!("\n=== mutants");
    rows.iter().for_each(|(_, row)| println!("{row}"));
    let caught = rows.iter().filter(|(fate, _)| matches!(fate, Fate::Caught | Fate::Hung)).count();
    println!("{caught} of {} caught", rows.len());
    if caught == rows.len() { Ok(()) } else { Err("a mutant survives: a test is missing".into()) }
}

/// The file's text with the mutant in it.
fn mutated(tree: &Path, mutant: &Mutant) -> Outcome<String> {
    let text = fs::read_to_string(tree.join(mutant.file)).map_err(|e| format!("{}: {e}", mutant.file))?;
    match text.matches(mutant.text).count() {
        1 => Ok(text.replacen(mutant.text, mutant.broken, 1)),
        count => Err(format!("{}: its text is {count} times in {}", mutant.name, mutant.file)),
    }
}

fn write(path: &Path, text: &str) -> Outcome {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// A copy of every file that git knows; a file that is as it was keeps its time, so that cargo does not build it again.
fn copy() -> Outcome<PathBuf> {
    let tree = target().join("mutants").join("tree");
    let files = read(shell::program("git").args(["ls-files", "--cached", "--others", "--exclude-standard"]))?;
    for file in files.lines() {
        let (from, to) = (root().join(file), tree.join(file));
        let Ok(bytes) = fs::read(&from) else { continue };
        if fs::read(&to).is_ok_and(|there| there == bytes) {
            continue;
        }
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        fs::write(&to, bytes).map_err(|e| format!("{}: {e}", to.display()))?;
    }
    Ok(tree)
}

/// What a test says about the tree.
fn fate(tree: &Path, test: &[&str]) -> Outcome<Fate> {
    let (packages, names) = test.split_at(test.iter().position(|word| *word == "--").unwrap_or(test.len()));
    if !shell::works(command(tree).args(["--no-run"]).args(packages)) {
        return Ok(Fate::Broken);
    }
    let mut run = command(tree);
    run.args(packages).args(names).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = run.spawn().map_err(|e| format!("`{}`: {e}", shell::line(&run)))?;
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            return Ok(if status.success() { Fate::Survived } else { Fate::Caught });
        }
        if began.elapsed() > PATIENCE {
            let _ = child.kill();
            let _ = child.wait();
            return Ok(Fate::Hung);
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// `cargo test` in the copy; little optimised, as building takes longer than running.
fn command(tree: &Path) -> Command {
    let mut command = cargo();
    command.current_dir(tree).arg("test").env("CARGO_TARGET_DIR", target().join("mutants").join("build"));
    for profile in ["TEST", "DEV"] {
        command
            .env(format!("CARGO_PROFILE_{profile}_OPT_LEVEL"), "1")
            .env(format!("CARGO_PROFILE_{profile}_DEBUG"), "0");
    }
    command
}
