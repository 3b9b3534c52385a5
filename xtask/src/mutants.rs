//! Mutants: the code broken on purpose by one edit, and the test that must find it.
//!
//! In: the lists of [`all`]. Out: a table of the outcome of each and of the tests that found it,
//! also in `target/mutants/report.md`. Owns a copy of the tree under `target/mutants`, so that the
//! checkout stays as it is. Fails: if a mutant survives, does not compile, or if its text is not in
//! its file exactly once.
//!
//! The tests must pass in that copy before any edit, or their failures would prove nothing. Mutants
//! of `firmware/` or `hal/` are found by tests in QEMU, of its image, or by those of the reference
//! board's image in emulation.
mod found;
mod front_ends;
mod light;
mod link;
mod list;
mod planted;
mod reference_board;
mod states;
mod survived;
mod timing;

use crate::board;
use crate::setup::{TARGET, compiler};
use crate::shell::{self, Outcome, cargo, read, root, target};
use front_ends::FRONT_ENDS;
use light::LIGHT;
use link::RING_AND_LINK;
use list::{LIST, Mutant};
use reference_board::REFERENCE_BOARD;
use states::STATES;
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use survived::SURVIVED;

/// A test that takes this many times its usual time hangs, which counts as finding the mutant.
const HANGS_AFTER: (u32, Duration) = (3, Duration::from_secs(60));

/// What became of a mutant.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Fate {
    /// By these tests.
    Caught(Vec<String>),
    Hung,
    Survived,
    Broken,
}

impl fmt::Display for Fate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fate::Caught(tests) => {
                let (shown, rest) = tests.split_at(tests.len().min(3));
                f.write_str(&shown.iter().map(|test| format!("`{test}`")).collect::<Vec<_>>().join(", "))?;
                if rest.is_empty() { Ok(()) } else { write!(f, " and {} more", rest.len()) }
            }
            Fate::Hung => f.write_str("the test does not end"),
            Fate::Survived => f.write_str("SURVIVED"),
            Fate::Broken => f.write_str("DOES NOT COMPILE"),
        }
    }
}

/// Every mutant.
fn all() -> impl Iterator<Item = &'static Mutant> {
    [RING_AND_LINK, LIST, REFERENCE_BOARD, SURVIVED, FRONT_ENDS, LIGHT, STATES].into_iter().flatten()
}

/// Checks that every mutant's text is in its file exactly once.
pub fn check() -> Outcome {
    let count = all().count();
    if count < 20 {
        return Err(format!("{count} mutants; at least 20 are asked for"));
    }
    let wrong = all().filter_map(|mutant| mutated(&root(), mutant).err());
    let wrong: Vec<String> = wrong.chain(planted::check(&root())).collect();
    if wrong.is_empty() {
        println!("{count} mutants, each in its place");
        return Ok(());
    }
    Err(format!("{}\nthe text has changed: bring the lists in xtask/src/mutants up to date", wrong.join("\n")))
}

/// Plants the faults that random programs must find, those whose name holds `only`.
pub fn plant(only: &str) -> Outcome {
    check()?;
    planted::run(only)
}

/// Runs the mutants whose name holds `only`.
pub fn run(only: &str) -> Outcome {
    check()?;
    let chosen: Vec<&Mutant> = all().filter(|mutant| mutant.name.contains(only)).collect();
    if chosen.is_empty() {
        return Err(format!("no mutant is called {only}"));
    }
    let commit = read(shell::program("git").args(["describe", "--always", "--dirty"]))?;
    println!("the tree of {}", commit.trim());
    let tree = copy()?;
    let mut patience = BTreeMap::new();
    let mut rows = Vec::new();
    for mutant in &chosen {
        if !patience.contains_key(mutant.test) {
            let began = Instant::now();
            let (fate, took) = fate(&tree, mutant, Duration::MAX)?;
            if fate != Fate::Survived {
                return Err(format!(
                    "`cargo test {}` does not pass on the code as it is: {fate}",
                    mutant.test.join(" ")
                ));
            }
            let (all, test) = (began.elapsed().as_secs_f64(), took.as_secs_f64());
            println!("passes  {} ({all:.0} s, the test itself {test:.0})", mutant.test.join(" "));
            patience.insert(mutant.test, took.saturating_mul(HANGS_AFTER.0) + HANGS_AFTER.1);
        }
        let (path, began) = (tree.join(mutant.file), Instant::now());
        let text = mutated(&tree, mutant)?;
        let before = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        write(&path, &text)?;
        let fate = fate(&tree, mutant, patience.get(mutant.test).copied().unwrap_or(Duration::MAX));
        write(&path, &before)?;
        let (fate, _) = fate?;
        let row = format!("| {} | `{}` | {fate} |", mutant.name, mutant.file);
        println!("{row} ({:.0} s)", began.elapsed().as_secs_f64());
        rows.push((fate, row));
        let table: Vec<&str> = rows.iter().map(|(_, row)| row.as_str()).collect();
        write(&target().join("mutants").join("report.md"), &(table.join("\n") + "\n"))?;
    }
    println!("\n=== mutants");
    rows.iter().for_each(|(_, row)| println!("{row}"));
    let caught = rows.iter().filter(|(fate, _)| matches!(fate, Fate::Caught(_) | Fate::Hung)).count();
    println!("{caught} of {} caught", rows.len());
    if caught == rows.len() { Ok(()) } else { Err("a mutant survives: a test is missing".into()) }
}

/// The file's text with the mutant in it.
fn mutated(tree: &Path, mutant: &Mutant) -> Outcome<String> {
    replaced(tree, mutant.name, mutant.file, (mutant.text, mutant.broken))
}

/// The file's text with `broken` instead of `text`, which it has once.
fn replaced(tree: &Path, name: &str, file: &str, (text, broken): (&str, &str)) -> Outcome<String> {
    let whole = fs::read_to_string(tree.join(file)).map_err(|e| format!("{file}: {e}"))?;
    match whole.matches(text).count() {
        1 => Ok(whole.replacen(text, broken, 1)),
        count => Err(format!("{name}: its text is {count} times in {file}")),
    }
}

fn write(path: &Path, text: &str) -> Outcome {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// A copy of every file that git knows; a file that is as it was keeps its time, so that cargo does
/// not build it again.
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

/// What a test says about the tree, and how long the test itself took.
fn fate(tree: &Path, mutant: &Mutant, patience: Duration) -> Outcome<(Fate, Duration)> {
    let test = mutant.test;
    let (packages, names) = test.split_at(test.iter().position(|word| *word == "--").unwrap_or(test.len()));
    let image = image_of(mutant);
    if let Some((bin, features, _)) = image
        && !shell::works(&mut image_command(tree, bin, features)?)
    {
        return Ok((Fate::Broken, Duration::ZERO));
    }
    let mut build = command(tree);
    build.args(["--no-run", "--message-format=json"]).args(packages).stdin(Stdio::null());
    let built = build.output().map_err(|e| format!("`{}`: {e}", shell::line(&build)))?;
    let built = (built.status.success(), String::from_utf8_lossy(&built.stdout).into_owned());
    // The test itself, not cargo before it, so that one that hangs can be ended.
    let program =
        built.1.lines().filter_map(|line| line.split_once("\"executable\":\"")?.1.split('"').next()).next_back();
    let (true, Some(program)) = (built.0, program) else { return Ok((Fate::Broken, Duration::ZERO)) };
    let said = target().join("mutants").join("said.txt");
    let out = fs::File::create(&said).map_err(|e| format!("{}: {e}", said.display()))?;
    let mut run = Command::new(program);
    run.current_dir(tree)
        .args(names.get(1..).unwrap_or_default())
        .stdin(Stdio::null())
        .stdout(out)
        .stderr(Stdio::null());
    if let Some((bin, _, variable)) = image {
        run.env(variable, folder().join(TARGET).join("image").join(bin));
    }
    let mut child = run.spawn().map_err(|e| format!("`{}`: {e}", shell::line(&run)))?;
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            let text = fs::read_to_string(&said).map_err(|e| format!("{}: {e}", said.display()))?;
            if status.success() && text.contains("test result: ok. 0 passed") {
                return Err(format!("`cargo test {}` runs no test", test.join(" ")));
            }
            let failed = text.lines().filter_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"));
            let fate =
                if status.success() { Fate::Survived } else { Fate::Caught(failed.map(str::to_owned).collect()) };
            return Ok((fate, began.elapsed()));
        }
        if began.elapsed() > patience {
            let _ = child.kill();
            let _ = child.wait();
            return Ok((Fate::Hung, began.elapsed()));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn folder() -> PathBuf {
    target().join("mutants").join("build")
}

/// `cargo test` in the copy; little optimised, as building takes longer than running.
fn command(tree: &Path) -> Command {
    let mut command = cargo();
    command.current_dir(tree).arg("test").env("CARGO_TARGET_DIR", folder());
    // Each mutant is a small change.
    command.env("CARGO_INCREMENTAL", "1");
    for profile in ["TEST", "DEV"] {
        command
            .env(format!("CARGO_PROFILE_{profile}_OPT_LEVEL"), "1")
            .env(format!("CARGO_PROFILE_{profile}_DEBUG"), "0");
    }
    command
}

/// The image of a mutant that tests find in an image: its program, its features, and the variable
/// that gives the tests its path.
fn image_of(mutant: &Mutant) -> Option<(&'static str, &'static [&'static str], &'static str)> {
    if mutant.test.contains(&"external_dac") {
        Some((board::BIN, &board::REFERENCE_DAC.features, "BEAMTICK_H743_DAC_IMAGE"))
    } else if mutant.test.contains(&"beamtick-h743") {
        Some((board::BIN, &board::FEATURES, "BEAMTICK_H743_IMAGE"))
    } else {
        ["firmware/", "hal/"].iter().any(|of| mutant.file.starts_with(of)).then_some((
            "beamtick-mps2",
            &[],
            "BEAMTICK_IMAGE",
        ))
    }
}

/// What builds an image in the copy.
fn image_command(tree: &Path, bin: &str, features: &[&str]) -> Outcome<Command> {
    let compiler = compiler()?;
    let mut command = compiler.cargo();
    command.current_dir(tree).env("CARGO_TARGET_DIR", folder());
    command.args(["build", "--package", "beamtick-firmware", "--bin", bin, "--profile", "image"]).args(features);
    command.args(compiler.arguments());
    Ok(command)
}
