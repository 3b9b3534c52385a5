//! Running other programs.
//!
//! In: a program and its arguments. Out: that it ended well, or a sentence that says which did not.
//! Everything runs from the root of the workspace, whatever directory the user stands in.
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What every step returns: nothing, or why not.
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
    // What `cargo run` sets for us is not meant for the cargo we start.
    for inherited in ["CARGO_MANIFEST_DIR", "CARGO_PKG_NAME", "CARGO_PKG_VERSION", "RUSTUP_TOOLCHAIN"] {
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
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{}` failed ({status})", line(command))),
        Err(e) => Err(format!("`{}` did not start: {e}", line(command))),
    }
}

/// Runs it and takes what it prints; its errors go to ours.
pub fn read(command: &mut Command) -> Outcome<String> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("`{}` did not start: {e}", line(command)))?;
    if !output.status.success() {
        return Err(format!("`{}` failed ({})", line(command), output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Runs it and shows what it prints only if it fails.
pub fn quietly(command: &mut Command) -> Outcome {
    let output = command.output().map_err(|e| format!("`{}` did not start: {e}", line(command)))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    Err(format!("`{}` failed ({}):\n{said}", line(command), output.status))
}

/// Whether it ends well; what it prints is dropped.
pub fn works(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}
