#![forbid(unsafe_code)]
//! The program `beamtick`: the library's [`beamtick::main`].
use std::process::ExitCode;

fn main() -> ExitCode {
    beamtick::main()
}
