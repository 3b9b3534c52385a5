//! Running other programs.
//!
//! In: a program and its arguments. Out: success, or a sentence with the program that failed, and
//! why. Everything runs from the root of the workspace, whatever the user's directory is.
use std::env;
use std::io::{self, BufRead, BufReader, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

/// What every step returns: nothing, or why not; the first line of that says most.
pub type Outcome<T = ()> = Result<T, String>;

/// Root of the workspace.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// Where cargo puts what it builds.
pub fn target() -> PathBuf {
    match env::var_os("CARGO_TARGET_DIR") {
        Some(set) => root().join(set),
        None => root().join("target"),
    }
}

/// The cargo that runs us, from the root of the workspace.
pub fn cargo() -> Command {
    program(env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()))
}

/// A program, run from the root of the workspace.
pub fn program(name: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(name);
    command.current_dir(root());
    // Variables that `cargo run` sets for this program are not for the cargo that it starts. But
    // RUSTUP_TOOLCHAIN is: without it a package of the registry with a rust-toolchain file of its
    // own (convert_case 0.10) would be built by that compiler.
    for inherited in ["CARGO_MANIFEST_DIR", "CARGO_PKG_NAME", "CARGO_PKG_VERSION"] {
        command.env_remove(inherited);
    }
    command
}

/// The command as a user would type it.
pub fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// Runs it with our own output.
pub fn run(command: &mut Command) -> Outcome {
    match status(command) {
        Ok((status, _)) if status.success() => Ok(()),
        Ok((status, said)) => Err(format!("`{}` failed ({status}){}", line(command), because(&said))),
        Err(e) => Err(format!("`{}` did not start: {e}", line(command))),
    }
}

/// How it ended, and the text of its error stream, which is copied to ours line by line. On a
/// terminal the program keeps the stream, for its colours, and the user has read it.
fn status(command: &mut Command) -> io::Result<(ExitStatus, String)> {
    if io::stderr().is_terminal() {
        return Ok((command.status()?, String::new()));
    }
    let mut child = command.stderr(Stdio::piped()).spawn()?;
    let mut said = Vec::new();
    if let Some(stderr) = child.stderr.take() {
        let mut stderr = BufReader::new(stderr);
        let mut from = 0;
        while stderr.read_until(b'\n', &mut said)? > 0 {
            let _ = io::stderr().write_all(&said[from..]);
            from = said.len();
        }
    }
    Ok((child.wait()?, String::from_utf8_lossy(&said).into_owned()))
}

/// The line that says most about a failure: the first with the word error, else the last that is
/// not empty.
fn cause(said: &str) -> Option<&str> {
    let is_error = |line: &&str| line.get(..5).is_some_and(|word| word.eq_ignore_ascii_case("error"));
    let last = || said.lines().map(str::trim).rfind(|line| !line.is_empty());
    said.lines().map(str::trim).find(is_error).or_else(last)
}

fn because(said: &str) -> String {
    cause(said).map_or_else(String::new, |cause| format!(": {cause}"))
}

/// Runs it and takes what it prints; its errors go to ours.
pub fn read(command: &mut Command) -> Outcome<String> {
    let output =
        command.stdin(Stdio::null()).output().map_err(|e| format!("`{}` did not start: {e}", line(command)))?;
    let _ = io::stderr().write_all(&output.stderr);
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`{}` failed ({}){}", line(command), output.status, because(&said)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Runs it and shows what it prints only if it fails, with the cause in front.
pub fn quietly(command: &mut Command) -> Outcome {
    let output = command.output().map_err(|e| format!("`{}` did not start: {e}", line(command)))?;
    if output.status.success() {
        return Ok(());
    }
    let (printed, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let cause = cause(&said).unwrap_or("it says nothing");
    Err(format!("{cause}\n`{}` failed ({}):\n{printed}{said}", line(command), output.status))
}

/// Whether it ends well; what it prints is dropped.
pub fn works(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = program("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_failure_says_why() {
        let script = "echo out; echo warning: old >&2; echo 'error -7: the board does not answer' >&2; echo >&2; echo Nothing moves. >&2; exit 3";
        let said = quietly(&mut shell(script)).unwrap_err();
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines.first(), Some(&"error -7: the board does not answer"));
        assert!(lines.contains(&"out") && lines.contains(&"Nothing moves."), "{said}");
        assert!(said.contains("exit status: 3"), "{said}");
        let said = read(&mut shell("echo one >&2; echo two >&2; echo >&2; exit 1")).unwrap_err();
        assert!(said.ends_with("(exit status: 1): two"), "{said}");
        assert_eq!(read(&mut shell("echo one; echo two >&2")).as_deref(), Ok("one\n"));
        assert!(quietly(&mut shell("exit 1")).unwrap_err().starts_with("it says nothing\n"));
    }

    #[test]
    fn the_compiler_of_this_tree_builds_packages_of_the_registry_too() {
        let kept = cargo().get_envs().all(|(name, _)| name != "RUSTUP_TOOLCHAIN");
        assert!(kept, "a package's own rust-toolchain file would choose its compiler");
    }

    #[test]
    fn the_error_stream_is_passed_on_and_kept() {
        // Under a test the error stream is a terminal's or not.
        let (ended, said) = status(&mut shell("echo 'Error: no' >&2; printf rest >&2; exit 1")).unwrap();
        assert!(!ended.success());
        assert!(io::stderr().is_terminal() || said == "Error: no\nrest", "{said}");
        assert_eq!(cause("x\n  Error: no\nrest\n"), Some("Error: no"));
        assert_eq!((cause("x\nrest\n\n"), cause("\n")), (Some("rest"), None));
    }
}
