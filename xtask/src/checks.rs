//! Everything that must pass before a change is accepted; `.ci/run` runs exactly this.
//!
//! In: the checkout. Out: every step with its time, a summary, and as the last line how many tests
//! and checks passed and failed. A step that fails does not hide those after it.
use crate::setup::{self, compiler};
use crate::shell::{self, Outcome, cargo, line, target};
use crate::{board, comments, explained, image, lines, mutants, pages, probes, proofs, supply, ticks, traces};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Packages that only the Cortex-M7 can run.
const CHIP: [&str; 4] = ["beamtick-firmware", "beamtick-hal", "beamtick-probes", "beamtick-probes-h743"];

/// Needs the emulator's library to link, which has a step of its own.
const EMULATION: &str = "beamtick-h743";

/// Its tests that the images for an external DAC pass too.
const FOR_DACS: [&str; 8] = ["facts", "image", "inputs", "light", "restarts", "second_board", "steps", "usb"];

/// For the reference board alone: the packages above are linted for another board.
const BRING_UP: &str = "beamtick-bring-up";

/// How many tests a step ran, beyond itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Count {
    passed: u32,
    failed: u32,
}

/// A step: its name, and what it does.
type Step = (&'static str, fn() -> (Count, Outcome));

const STEPS: [Step; 17] = [
    ("set-up", || alone(setup::run())),
    ("format", || alone(shell::run(cargo().args(["fmt", "--all", "--check"])))),
    ("clippy, host", || alone(shell::run(host(["clippy"]).args(["--all-targets", "--", "-D", "warnings"])))),
    ("clippy, Cortex-M7", || alone(clippy_chip())),
    ("planted edits still apply", || alone(mutants::check())),
    ("links and sentences of the documentation", || {
        alone(pages::check().and_then(|()| lines::check()).and_then(|()| explained::check()))
    }),
    ("width of comments, length of files", || alone(comments::check())),
    ("bounds of rounding (Gappa)", || alone(proofs::where_gappa_is())),
    ("tests", || tests(host(["test"]).arg("--no-fail-fast"))),
    ("orderings of the rings, every interleaving (loom)", || tests(&mut loom())),
    ("undefined behaviour in the rings (Miri)", miri),
    ("what it is made of (cargo-deny)", || alone(supply::check())),
    ("image and probes", || {
        alone(image::report().and_then(|()| board::image().map(drop)).and_then(|()| probes::cannot_panic()))
    }),
    ("instructions per tick", || alone(ticks::check())),
    ("traces of image and virtual controller", || alone(traces::run(&[]))),
    ("inputs and faults of the emulated board", emulated),
    ("the STM32H743 in emulation", h743),
];

/// Runs all steps.
pub fn run() -> Outcome {
    let began = Instant::now();
    let mut total = Count::default();
    let mut report = Vec::new();
    for (name, step) in STEPS {
        println!("\n=== {name}");
        let began = Instant::now();
        let (count, outcome) = step();
        total.passed += count.passed;
        total.failed += count.failed;
        let seconds = began.elapsed().as_secs_f64();
        let tests = if count == Count::default() { String::new() } else { format!(", {} tests", count.passed) };
        match outcome {
            Ok(()) => {
                total.passed += 1;
                report.push(format!("passed  {name}{tests} ({seconds:.0} s)"));
            }
            Err(reason) => {
                eprintln!("error: {reason}");
                total.failed += 1;
                report.push(format!("FAILED  {name}{tests} ({seconds:.0} s): {}", reason.lines().next().unwrap_or("")));
            }
        }
    }
    println!("\n=== summary, {:.0} s", began.elapsed().as_secs_f64());
    for line in report {
        println!("{line}");
    }
    println!("{} passed, {} failed", total.passed, total.failed);
    if total.failed == 0 { Ok(()) } else { Err("not everything passed".into()) }
}

fn alone(outcome: Outcome) -> (Count, Outcome) {
    (Count::default(), outcome)
}

/// A cargo command for everything that runs on this machine.
fn host<const N: usize>(words: [&str; N]) -> Command {
    let mut command = cargo();
    command.args(words).arg("--workspace");
    for package in CHIP.iter().chain(&[EMULATION, BRING_UP]) {
        command.args(["--exclude", package]);
    }
    command
}

fn clippy_chip() -> Outcome {
    let compiler = compiler()?;
    let mut command = compiler.cargo();
    command.args(["clippy", "--profile", "image"]).args(compiler.arguments());
    for package in CHIP {
        command.args(["--package", package]);
    }
    shell::run(command.args(["--", "-D", "warnings"]))?;
    for variant in board::VARIANTS {
        let mut command = compiler.cargo();
        command.args(["clippy", "--profile", "image", "--package", "beamtick-firmware"]).args(variant.features);
        shell::run(command.args(compiler.arguments()).args(["--", "-D", "warnings"]))?;
    }
    let mut command = compiler.cargo();
    command.args(["clippy", "--profile", "image", "--package", BRING_UP]).args(compiler.arguments());
    shell::run(command.args(["--", "-D", "warnings"]))
}

/// The models of the STM32H743's peripherals, its core by a program that tries it, and the board's
/// image.
fn h743() -> (Count, Outcome) {
    let lint = ["clippy", "--package", EMULATION, "--all-targets", "--", "-D", "warnings"];
    let ready = setup::unicorn().and_then(|()| shell::run(cargo().args(lint)));
    let built = || {
        Ok((
            image::build_bin("beamtick-probes-h743", "h743-core")?,
            [
                ("BEAMTICK_H743_DOUBLES", image::build_bin("beamtick-probes-h743", "h743-doubles")?),
                ("BEAMTICK_MPS2_DOUBLES", image::build_bin("beamtick-probes", "doubles")?),
            ],
            board::build_bring_up()?,
            board::MODULE_DAC.build()?,
            board::MODULE.build()?,
            board::REFERENCE_DAC.build()?,
            board::build()?,
        ))
    };
    match ready.and_then(|()| built()) {
        Ok((probe, doubles, bring_up, module_for_dac, module, for_dac, image)) => {
            let mut command = cargo();
            command.args(["test", "--no-fail-fast", "--package", EMULATION]);
            command.env("BEAMTICK_H743_PROBE", probe).envs(doubles).env("BEAMTICK_H743_DAC_IMAGE", &for_dac);
            command.env("BEAMTICK_H743_BRING_UP", bring_up).env("BEAMTICK_H743VI_DAC_IMAGE", &module_for_dac);
            command.env("BEAMTICK_H743VI_IMAGE", &module).env("BEAMTICK_H743_IMAGE", &image);
            // The boards' tests again, with the images for an external DAC.
            let mut for_dacs = cargo();
            for_dacs.args(["test", "--no-fail-fast", "--package", EMULATION]);
            for test in FOR_DACS {
                for_dacs.args(["--test", test]);
            }
            for_dacs.env("BEAMTICK_H743_IMAGE", &for_dac).env("BEAMTICK_H743VI_IMAGE", &module_for_dac);
            for_dacs.env("BEAMTICK_H743_DAC_IMAGE", &for_dac);
            // ST's data of another chip take the place of the first one's.
            let of = |chip: &str, plain: (&str, &Path), for_dac: (&str, &Path)| {
                let mut command = cargo();
                command.args(["test", "--package", EMULATION, "--no-default-features", "--features", chip]);
                command.args(["--test", "authorities", "--test", "reset_values"]);
                command.env(plain.0, plain.1).env(for_dac.0, for_dac.1);
                command
            };
            let [plain, external] = ["BEAMTICK_H743VI_IMAGE", "BEAMTICK_H743VI_DAC_IMAGE"];
            let module = of("stm32h743vi", (plain, &module), (external, &module_for_dac));
            // The chip of the NUCLEO-H753ZI, where the same image runs.
            let [plain, external] = ["BEAMTICK_H743_IMAGE", "BEAMTICK_H743_DAC_IMAGE"];
            let sibling = of("stm32h753zi", (plain, &image), (external, &for_dac));
            let mut count = Count::default();
            for mut command in [command, for_dacs, module, sibling] {
                let (more, outcome) = tests(&mut command);
                count.passed += more.passed;
                count.failed += more.failed;
                if outcome.is_err() {
                    return (count, outcome);
                }
            }
            (count, Ok(()))
        }
        Err(reason) => alone(Err(reason)),
    }
}

/// Tests that need the image in QEMU; without it they say that they are skipped.
fn emulated() -> (Count, Outcome) {
    match image::build() {
        Ok(image) => {
            let packages = ["--package", "beamtick-host-tests", "--package", "beamtick-gts", "--package", "beamtick"];
            let words = ["test"].iter().chain(&packages).chain(&[
                "--test",
                "emulated_board",
                "--test",
                "emulated_faults",
                "--test",
                "emulated_inputs",
                "--test",
                "emulated_signals",
            ]);
            tests(cargo().args(words).env("BEAMTICK_IMAGE", image))
        }
        Err(reason) => alone(Err(reason)),
    }
}

/// In a folder of its own: other flags would rebuild everything.
fn loom() -> Command {
    let mut command = cargo();
    command
        .args(["test", "--release", "--package", "beamtick-ring", "--lib"])
        .env("RUSTFLAGS", "--cfg loom")
        .env("CARGO_TARGET_DIR", target().join("loom"));
    command
}

/// In a folder of its own too. It needs a nightly compiler with Miri, which may be missing.
fn miri() -> (Count, Outcome) {
    let nightly = |words: &[&str]| {
        let mut command = shell::program("rustup");
        command.args(["run", "nightly", "cargo", "miri"]).args(words);
        command.env("CARGO_TARGET_DIR", target().join("miri")).stdin(Stdio::null());
        command
    };
    if !shell::works(&mut nightly(&["setup"])) {
        println!(
            "left out: there is no nightly compiler with Miri (`rustup toolchain install nightly -c miri,rust-src`)"
        );
        return alone(Ok(()));
    }
    tests(&mut nightly(&["test", "--package", "beamtick-ring", "--lib"]))
}

/// Runs a test command, shows what it prints, and counts.
fn tests(command: &mut Command) -> (Count, Outcome) {
    let mut count = Count::default();
    let outcome = watch(command, &mut count);
    if outcome.is_ok() && count.passed == 0 {
        return (count, Err(format!("`{}` ran no test", line(command))));
    }
    (count, outcome)
}

fn watch(command: &mut Command, count: &mut Count) -> Outcome {
    let failed = |e: std::io::Error, command: &Command| format!("`{}`: {e}", line(command));
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(|e| failed(e, command))?;
    let mut names = Vec::new();
    if let Some(stdout) = child.stdout.take() {
        for text in BufReader::new(stdout).lines() {
            let text = text.map_err(|e| failed(e, command))?;
            if let Some(found) = counted(&text) {
                count.passed += found.passed;
                count.failed += found.failed;
            }
            names.extend(failed_test(&text).map(str::to_owned));
            // A closed terminal is no reason to stop testing.
            let _ = writeln!(std::io::stdout(), "{text}");
        }
    }
    let status = child.wait().map_err(|e| failed(e, command))?;
    match (status.success(), names.is_empty()) {
        (true, _) => Ok(()),
        (false, true) => Err(format!("`{}` failed ({status})", line(command))),
        (false, false) => Err(format!("{}\n`{}` failed ({status})", names.join(", "), line(command))),
    }
}

/// The name of a test that failed.
fn failed_test(text: &str) -> Option<&str> {
    text.strip_prefix("test ")?.strip_suffix(" ... FAILED")
}

/// The counts of a `test result:` line.
fn counted(text: &str) -> Option<Count> {
    let rest = text.strip_prefix("test result: ")?;
    let number = |word: &str| {
        let before = rest.split_once(word)?.0;
        before.rsplit([' ', '.', ';']).find(|part| !part.is_empty())?.parse().ok()
    };
    Some(Count { passed: number(" passed")?, failed: number(" failed")? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn result_lines_are_counted() {
        let line = "test result: FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out";
        assert_eq!(counted(line), Some(Count { passed: 12, failed: 3 }));
        let line = "test result: ok. 7 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out";
        assert_eq!(counted(line), Some(Count { passed: 7, failed: 0 }));
        assert_eq!(counted("test a ... ok"), None);
        assert_eq!(failed_test("test a::b ... FAILED"), Some("a::b"));
        assert_eq!((failed_test("test a::b ... ok"), failed_test(line)), (None, None));
    }
}
