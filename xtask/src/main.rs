#![forbid(unsafe_code)]
//! The project's own commands: `cargo xtask COMMAND`, with `cargo demo` and `cargo check-all` for
//! short.
//!
//! In: a command's name. Out: what it builds, runs and finds, as text; exit code 0 only if all of
//! it went well. Owns no state: everything is done anew by cargo, QEMU and the system's package
//! manager.
mod board;
mod checks;
mod comments;
mod demo;
mod dist;
mod doors;
mod embassy;
mod explained;
mod floats;
mod fuzz;
mod image;
mod lines;
mod mutants;
mod names;
mod pages;
mod probes;
mod proofs;
mod setup;
mod shares;
mod shell;
mod supply;
mod ticks;
mod traces;
mod wheel;

use shell::Outcome;
use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND

  setup           installs what is missing: the compiler's Cortex-M7 target and QEMU
  image           builds the images; shows their size, writes a bill of materials; the reference board's as ELF, BIN and HEX in out/
  size            how much of each memory of the chip the reference board's image uses
  flash-board [external-dac]
                  builds that image, or the one for a DAC8563, and writes it to the board (cargo flash-board; needs probe-rs)
  bring-up [LINK] builds the image by which the board measures itself into out/, flashes it if probe-rs is there; with LINK
                  (serial:/dev/ttyACM0:3000000) it measures and writes out/bring-up.md (cargo bring-up; docs/bring-up.md)
  bring-up LINK loads
                  the same page: how long ticks of the board's own image take under loads
  bring-up … --no-flash
                  the same with the image that the board has: probe-rs flashes nothing
  demo            builds the image, boots it, runs the examples, writes traces and plots to out/
  ticks           counts the instructions of a servo tick and writes the table of docs/numbers.md
  ticks --check   counts them and compares with the table
  ticks --shares  which part of the tick takes how many instructions in the worst tick of SPEC 11
  probes          the programs that must link, must not link, must not compile
  traces [NAME…]  example jobs in the virtual controller and in the image: equal, byte for byte
  supply          licences, duplicates, sources and advisories of the dependencies (deny.toml)
  fuzz --minutes N [--target T] [--merge]
                  libFuzzer over the targets of fuzz/, N minutes each
  long-run [TICKS]
                  mixed work for 10^9 ticks, or as many as are given, in the virtual controller (about 15 minutes)
  mutants [NAME]  breaks the code on purpose, one edit at a time, and checks that the tests fail
  mutants --check checks that every edit still applies
  planted [NAME]  plants faults that were found, and counts how many random programs find each
  doors           runs 1,000 random programs through every door and writes the table of docs/doors.md
  doors --page    writes the table from the counts of the last run
  pages           checks links, sentences and names of code in the documentation, the width of comments and the length of files
  proofs          proves the bounds of rounding from the code's own numbers (proofs/, by Gappa)
  embassy         what parts of embassy-stm32 would take in place of hal's (docs/decisions/024-embassy-stm32.md)
  lines           counts the lines of production code of servo and dispatcher
  c-api           writes the headers and exports of the C library from the table of functions
  wheel           builds the Python wheel with the library inside, into out/
  dist            makes the archive of a release in out/, and tries it: programs, libraries, headers, wheel, images, pages
  check-all       everything that must pass before a change is accepted
";

/// The test of a plain run, for longer.
fn long_run(ticks: &str) -> Outcome {
    let words = ["test", "--release", "-p", "beamtick-host-tests", "--test", "long_run", "--", "--nocapture"];
    shell::run(shell::cargo().args(words).env("LONG_RUN_TICKS", ticks))
}

/// What `cargo bring-up` is to do: over which link, with which image, and whether it flashes that.
/// `--no-flash` stands anywhere.
type BringUp<'a> = (Option<&'a str>, bool, bool);

fn bring_up_words<'a>(words: &[&'a str]) -> Outcome<BringUp<'a>> {
    let (options, others): (Vec<&str>, Vec<&str>) = words.iter().partition(|word| word.starts_with('-'));
    let flashes = options.is_empty();
    let refused = || Err(format!("bring-up takes [LINK [loads]] [--no-flash], and got {}", words.join(" ")));
    if !matches!(options[..], [] | ["--no-flash"]) {
        return refused();
    }
    match others[..] {
        [] => Ok((None, false, flashes)),
        [link] => Ok((Some(link), false, flashes)),
        [link, "loads"] => Ok((Some(link), true, flashes)),
        _ => refused(),
    }
}

fn bring_up(words: &[&str]) -> Outcome {
    match bring_up_words(words)? {
        (Some(link), true, flashes) => board::loads(link, flashes),
        (link, _, flashes) => board::bring_up(link, flashes),
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome: Outcome = match words.as_slice() {
        ["setup"] => setup::run(),
        ["image"] => setup::run().and_then(|()| image::report()).and_then(|()| board::image()).map(drop),
        ["size"] => board::size(),
        ["flash-board"] => board::flash(board::REFERENCE),
        ["flash-board", "external-dac"] => board::flash(board::REFERENCE_DAC),
        ["bring-up", words @ ..] => bring_up(words),
        ["demo"] => demo::run(),
        ["ticks"] => ticks::write(),
        ["ticks", "--check"] => ticks::check(),
        ["ticks", "--shares"] => ticks::shares(),
        ["probes"] => probes::run(),
        ["traces", names @ ..] => traces::run(names),
        ["supply"] => supply::check(),
        ["fuzz", rest @ ..] => fuzz::run(rest),
        ["long-run"] => long_run("1000000000"),
        ["long-run", ticks] => long_run(ticks),
        ["mutants"] => mutants::run(""),
        ["planted"] => mutants::plant(""),
        ["planted", name] => mutants::plant(name),
        ["mutants", "--check"] => mutants::check(),
        ["mutants", name] => mutants::run(name),
        ["doors"] => doors::write(),
        ["doors", "--page"] => doors::page(),
        ["pages"] => pages::check()
            .and_then(|()| comments::check())
            .and_then(|()| lines::check())
            .and_then(|()| explained::check()),
        ["proofs"] => proofs::run(),
        ["embassy"] => embassy::report(),
        ["lines"] => lines::report(),
        ["c-api"] => shell::run(shell::cargo().env("BEAMTICK_WRITE", "1").args([
            "test",
            "-p",
            "beamtick-gts",
            "--test",
            "generated",
        ])),
        ["wheel"] => wheel::make(),
        ["dist"] => setup::run().and_then(|()| dist::make()),
        ["check-all"] => checks::run(),
        ["help" | "--help"] => {
            print!("{HELP}");
            Ok(())
        }
        _ => Err(format!("no such command: {}\n\n{HELP}", words.join(" "))),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("error: {reason}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bring_up_flashes_unless_it_gets_its_option() {
        let link = "serial:COM5:3000000";
        for (words, expected) in [
            (&[][..], (None, false, true)),
            (&["--no-flash"], (None, false, false)),
            (&[link], (Some(link), false, true)),
            (&["--no-flash", link], (Some(link), false, false)),
            (&[link, "loads"], (Some(link), true, true)),
            (&[link, "--no-flash", "loads"], (Some(link), true, false)),
        ] {
            assert_eq!(bring_up_words(words), Ok(expected), "{words:?}");
        }
        for words in [&["--flash"][..], &[link, "load"], &["--no-flash", "--no-flash"], &[link, "loads", "now"]] {
            let why = bring_up_words(words).unwrap_err();
            assert_eq!(why, format!("bring-up takes [LINK [loads]] [--no-flash], and got {}", words.join(" ")));
        }
    }
}
