//! Compiles C and C++ programs against the library of this build and runs them.
#![allow(dead_code)] // Each test binary uses a part of it.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Which compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// `cc`, C99.
    C,
    /// `c++`.
    Cpp,
}

/// The checkout.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Where cargo put the library of this build: beside the test's own binary.
pub fn libraries() -> PathBuf {
    let folder = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    assert!(folder.join("libgts.so").is_file(), "{}: no libgts.so", folder.display());
    folder
}

/// A folder for what is built.
pub fn scratch() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).to_owned();
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Says that a test did not run. Not println!, which is kept back where a test passes.
pub fn skip(why: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {why}");
}

/// Builds a program of this text without a warning; nothing where there is no compiler.
pub fn build(language: Language, name: &str, text: &str) -> Option<PathBuf> {
    let source = scratch().join(format!("{name}.{}", if language == Language::C { "c" } else { "cpp" }));
    std::fs::write(&source, text).unwrap();
    build_file(language, name, &source, &["-Wpedantic"])
}

/// The same of a file.
pub fn build_file(language: Language, name: &str, source: &Path, more: &[&str]) -> Option<PathBuf> {
    // Tests of one process build the same program at once.
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let program = scratch().join(format!("{name}-{}", NUMBER.fetch_add(1, Ordering::Relaxed)));
    let host = root().join("host/gts");
    let libraries = libraries();
    let mut compiler = Command::new(if language == Language::C { "cc" } else { "c++" });
    if language == Language::C {
        compiler.arg("-std=c99");
    }
    compiler
        .args(["-Wall", "-Wextra", "-Werror", "-Wno-cast-function-type", "-g"])
        .args(more)
        .arg("-I")
        .arg(host.join("include"))
        .arg("-I")
        .arg(host.join("compat"))
        .arg(source)
        .arg("-o")
        .arg(&program)
        .arg("-L")
        .arg(&libraries)
        .args(["-lgts", "-lm"])
        .arg(format!("-Wl,-rpath,{}", libraries.display()));
    let built = match compiler.output() {
        Ok(built) => built,
        Err(error) => {
            skip(&format!("there is no C compiler: {error}"));
            return None;
        }
    };
    assert!(built.status.success(), "{}:\n{}", source.display(), String::from_utf8_lossy(&built.stderr));
    Some(program)
}

/// A command for a built program, in the folder of the examples, with no variable of the library
/// set but these.
pub fn command(program: &Path, variables: &[(&str, &str)]) -> Command {
    let mut command = Command::new(program);
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("BEAMTICK_")) {
        command.env_remove(name);
    }
    // Cargo's path may lead to the library of an older build; the program knows its own.
    command.env_remove("LD_LIBRARY_PATH");
    command.envs(variables.iter().copied()).current_dir(root().join("examples")).stdin(std::process::Stdio::null());
    command
}

/// What it prints; it must end well.
pub fn output(program: &Path, variables: &[(&str, &str)]) -> String {
    output_of(&mut command(program, variables))
}

/// What a command prints; it must end well, and within five minutes (the emulated board on a busy
/// machine is slow).
pub fn output_of(command: &mut Command) -> String {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut pipes = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let errors = std::thread::spawn(move || read(&mut pipes.1));
    let text = std::thread::spawn(move || read(&mut pipes.0));
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if began.elapsed() > RUN_TIMEOUT {
            child.kill().unwrap();
            let (text, errors) = (text.join().unwrap(), errors.join().unwrap());
            panic!("{command:?} does not end: {text}{errors}");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let (text, errors) = (text.join().unwrap(), errors.join().unwrap());
    assert!(status.success(), "{command:?}: {status:?}\n{text}{errors}");
    text
}

/// The longest time of a program.
const RUN_TIMEOUT: Duration = Duration::from_secs(300);

fn read(pipe: &mut impl Read) -> String {
    let mut bytes = Vec::new();
    pipe.read_to_end(&mut bytes).unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}
