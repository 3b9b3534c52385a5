//! The probes: programs that must link, must not link, must not compile.
use crate::setup::compiler;
use crate::shell::{self, Outcome, cargo, line};
use std::process::Stdio;

/// The name that a panic path would have to resolve.
const WITNESS: &str = "undefined symbol: something_reached_a_panic";

/// Runs all of them.
pub fn run() -> Outcome {
    cannot_panic()?;
    shell::run(cargo().args(["test", "--package", "beamtick-rules"]))
}

/// Tick, protocol and server link without a panic path, and the tick's twin with one does not.
pub fn cannot_panic() -> Outcome {
    link("no-panic")?.map_err(|errors| format!("the tick can reach a panic:\n{errors}"))?;
    link("wire")?.map_err(|errors| format!("what comes over the wire can reach a panic:\n{errors}"))?;
    link("server")?.map_err(|errors| format!("what the thread does can reach a panic:\n{errors}"))?;
    match link("panics")? {
        Ok(()) => Err("the twin that panics links, so the probe proves nothing".into()),
        Err(errors) if errors.contains(WITNESS) => {
            println!("tick, protocol and server link without a panic path; the tick's twin with one does not link");
            Ok(())
        }
        Err(errors) => Err(format!("the twin fails for another reason:\n{errors}")),
    }
}

/// Links a probe; what the compiler says if it does not.
fn link(bin: &str) -> Outcome<Result<(), String>> {
    let compiler = compiler()?;
    let mut cargo = compiler.cargo();
    cargo
        .args(["build", "--package", "beamtick-probes", "--bin", bin, "--profile", "image"])
        .args(compiler.arguments())
        .stdin(Stdio::null());
    let output = cargo.output().map_err(|e| format!("`{}` did not start: {e}", line(&cargo)))?;
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    Ok(if output.status.success() { Ok(()) } else { Err(errors) })
}
