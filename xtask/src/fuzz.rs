//! libFuzzer over the targets of `fuzz/`.
//!
//! In: minutes, a target or all. Out: what libFuzzer finds, kept in `fuzz/artifacts`, and how many
//! inputs it tried; what it learns is in `target/fuzz/corpus`, and the kept corpus in `fuzz/corpus`
//! is only read (`--merge` brings what is new over). The pinned toolchain builds it: coverage is
//! asked for by compiler flags that are stable; `cargo fuzz` works as well. It takes a C++
//! compiler, for libFuzzer itself.
use crate::shell::{self, Outcome, cargo, program, root, target};
use std::path::PathBuf;
use std::process::Command;

/// Coverage as libFuzzer wants it, and every check that a test has.
const FLAGS: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1 -Coverflow-checks=yes -Cdebug-assertions=yes";
/// Targets of `fuzz/Cargo.toml`.
const TARGETS: [&str; 5] = ["link", "machine", "jobs", "config", "tables"];
/// An input takes this long at most, in seconds, before it counts as one that hangs.
const TIMEOUT_S: u32 = 60;

/// `fuzz --minutes N [--target T] [--merge]`.
pub fn run(words: &[&str]) -> Outcome {
    let (mut minutes, mut chosen, mut merge) = (None, TARGETS.to_vec(), false);
    let mut rest = words.iter();
    while let Some(word) = rest.next() {
        match (*word, rest.clone().next()) {
            ("--minutes", Some(number)) => {
                minutes = Some(number.parse::<f64>().map_err(|_| format!("--minutes {number} is no number"))?);
                rest.next();
            }
            ("--target", Some(name)) if TARGETS.contains(name) => {
                chosen = vec![name];
                rest.next();
            }
            ("--target", _) => return Err(format!("targets are {}", TARGETS.join(", "))),
            ("--merge", _) => merge = true,
            (other, _) => return Err(format!("fuzz --minutes N [--target T] [--merge]: what is {other}?")),
        }
    }
    let Some(minutes) = minutes else { return Err("fuzz --minutes N [--target T] [--merge]".into()) };
    let build = build()?;
    for name in chosen {
        fuzz(&build, name, minutes)?;
        if merge {
            let learnt = learnt(name)?;
            let mut command = Command::new(build.join(name));
            shell::run(command.args(["-merge=1", "-max_len=1200"]).arg(kept(name)).arg(learnt))?;
        }
    }
    Ok(())
}

fn kept(name: &str) -> PathBuf {
    root().join("fuzz").join("corpus").join(name)
}

fn learnt(name: &str) -> Outcome<PathBuf> {
    let folder = target().join("fuzz").join("corpus").join(name);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(folder)
}

/// Builds all targets; where they are.
fn build() -> Outcome<PathBuf> {
    if !["c++", "g++", "clang++"].iter().any(|name| shell::works(program(name).arg("--version"))) {
        return Err("libFuzzer needs a C++ compiler: install g++ or clang (Debian: apt install g++)".into());
    }
    let triple = host()?;
    let folder = target().join("fuzz");
    // With a target named, build scripts and procedural macros are built without these flags.
    let mut command = cargo();
    command
        .args(["build", "--release", "-p", "beamtick-fuzz", "--features", "libfuzzer", "--bins", "--target", &triple])
        .env("RUSTFLAGS", FLAGS)
        .env("CARGO_TARGET_DIR", &folder);
    shell::run(&mut command)?;
    Ok(folder.join(triple).join("release"))
}

/// The triple of this machine.
fn host() -> Outcome<String> {
    let text = shell::read(program("rustc").arg("-vV"))?;
    let triple = text.lines().find_map(|line| line.strip_prefix("host: "));
    triple.map(str::to_owned).ok_or_else(|| "rustc does not tell its host".into())
}

fn fuzz(build: &std::path::Path, name: &str, minutes: f64) -> Outcome {
    println!("\n=== {name}, {minutes} min");
    let artifacts = root().join("fuzz").join("artifacts").join(name);
    std::fs::create_dir_all(&artifacts).map_err(|e| format!("{}: {e}", artifacts.display()))?;
    let seconds = (minutes * 60.0).max(1.0) as u64;
    let mut command = Command::new(build.join(name));
    command
        .args(["-print_final_stats=1", "-use_value_profile=0", "-max_len=1200", "-rss_limit_mb=2048"])
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-timeout={TIMEOUT_S}"))
        .arg(format!("-artifact_prefix={}/", artifacts.display()))
        .arg(learnt(name)?)
        .arg(kept(name));
    shell::run(&mut command)
}
