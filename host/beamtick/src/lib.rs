#![forbid(unsafe_code)]
//! `beamtick`: runs job scripts in the virtual controller or on a board; serves the virtual
//! controller.
//!
//! In: the command line, job files, configuration files. Out: what the job read, a summary, trace
//! files; errors on the error stream with file, line and reason. Exit codes: 0 done, 1 the job or
//! the link failed, 2 the command line or the job file is wrong, 130, 143 and 129 after INT, TERM
//! and HUP. A library, so that tests run jobs over links of their own.

/// A line on the standard output, whenever that is read.
macro_rules! say {
    ($($part:tt)*) => {
        crate::printer::say(crate::printer::Stream::Out, format!($($part)*) + "\n")
    };
}

/// A line on the error stream, whenever that is read.
macro_rules! complain {
    ($($part:tt)*) => {
        crate::printer::say(crate::printer::Stream::Error, format!($($part)*) + "\n")
    };
}

mod bring_up;
mod command_line;
mod connect;
mod entries;
mod grbl_port;
mod import;
mod imported;
mod info;
mod input;
mod interrupt;
mod json;
mod ledger;
mod listing;
mod machine_file;
mod monitor;
mod output;
mod pages;
mod parts;
mod plot;
mod points;
mod printer;
mod profile;
mod record;
mod reply;
mod report;
mod runner;
mod script;
mod serve;
mod share;
mod source;
mod spool;
mod summary;
mod totals;
mod waits;

use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use client::Link;
use command_line::{Command, CommandLine};
use interrupt::Signal;
use std::io::{self, Write};
use std::process::ExitCode;

/// Why the program ends with an error.
#[derive(Debug)]
pub enum Failure {
    /// The job or the link: exit code 1.
    Job(String),
    /// The command line or the job file: exit code 2.
    Input(String),
    /// A signal: exit code 128 + its number.
    Interrupted(Signal, String),
}

impl Failure {
    /// With more at the end of its text.
    fn with(self, more: &str) -> Failure {
        match self {
            Failure::Job(text) => Failure::Job(text + more),
            Failure::Input(text) => Failure::Input(text + more),
            Failure::Interrupted(signal, text) => Failure::Interrupted(signal, text + more),
        }
    }
}

impl From<client::Error> for Failure {
    fn from(error: client::Error) -> Self {
        Failure::Job(format!("error {}: {error}", error.code))
    }
}

impl From<trace::TraceError> for Failure {
    fn from(error: trace::TraceError) -> Self {
        Failure::Job(format!("trace: {error}"))
    }
}

/// The program: does what the command line says.
pub fn main() -> ExitCode {
    interrupt::watch();
    let outcome = match CommandLine::try_parse() {
        Ok(line) => obey(&line),
        Err(shown) => return help(with_tip(shown)),
    };
    let done = outcome.is_ok();
    let code = ended(outcome);
    // Nothing of ours is lit or moving any more: a reader may take its time, unless a signal asks
    // to end.
    let finish = || printer::finish(interrupt::came().map(|_| interrupt::LAST_MESSAGE_TIMEOUT));
    finish();
    match printer::failed() {
        Some(error) if done => {
            let text =
                format!("the standard output cannot be written: {error}; what is missing there was done all the same");
            let code = ended(Err(Failure::Job(text)));
            finish();
            code
        }
        _ => code,
    }
}

/// An option that is given twice: what to do instead.
fn with_tip(mut error: clap::Error) -> clap::Error {
    if error.kind() == ErrorKind::ArgumentConflict && error.to_string().contains("multiple times") {
        let draws = ["--plot", "--html", "--xy"].iter().any(|option| error.to_string().contains(option));
        let more = if draws { "; `beamtick plot` draws any number of pictures of a --trace" } else { "" };
        let tip = format!("give it once{more}");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Prints the help, the version, or what is wrong with the command line.
fn help(shown: clap::Error) -> ExitCode {
    match shown.print().and_then(|()| io::stdout().flush()) {
        // Its reader may have seen enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            complain!("the standard output cannot be written: {error}");
            printer::finish(None);
            ExitCode::from(1)
        }
        _ => ExitCode::from(u8::try_from(shown.exit_code()).unwrap_or(2)),
    }
}

fn ended(outcome: Result<(), Failure>) -> ExitCode {
    let (code, kind, text) = match outcome {
        Ok(()) => (0, None, String::new()),
        Err(Failure::Job(text)) => (1, Some("job"), text),
        Err(Failure::Input(text)) => (2, Some("input"), text),
        Err(Failure::Interrupted(signal, text)) => (signal.exit_code(), Some("signal"), text),
    };
    // A signal's own line was printed when it came.
    let signal = interrupt::came().filter(|_| kind == Some("signal")).map_or("", Signal::name);
    let told = format!("{signal}\n{text}");
    let object = json::end(code, kind.map(|kind| (kind, told.trim())));
    if !text.is_empty() {
        complain!("{}", text.trim_end());
    }
    if let Some(object) = object {
        say!("{}", object.trim_end());
    }
    ExitCode::from(code)
}

fn obey(line: &CommandLine) -> Result<(), Failure> {
    match &line.command {
        Command::Sim(arguments) => json::begin("sim", arguments.outputs.json),
        Command::Run(arguments) => json::begin("run", arguments.outputs.json),
        Command::Check(arguments) => json::begin("check", arguments.json),
        Command::Info(arguments) => json::begin("info", arguments.json),
        Command::Monitor(arguments) => json::begin_line("monitor", arguments.json),
        _ => {}
    }
    match &line.command {
        Command::Sim(arguments) => runner::sim(arguments),
        Command::Run(arguments) => runner::run(arguments, None),
        Command::Check(arguments) => listing::check(arguments),
        Command::Serve(arguments) => serve::serve(arguments),
        Command::Info(arguments) => info::show(arguments),
        Command::BringUp(arguments) => bring_up::run(arguments),
        Command::Import(arguments) => import::import(arguments),
        Command::Grbl(arguments) => grbl_port::serve(arguments),
        Command::Monitor(arguments) => monitor::monitor(arguments),
        Command::Machine(arguments) => machine_file::obey(arguments),
        Command::Plot(arguments) => plot::draw(arguments),
        Command::Completions { shell } => pages::completions(*shell),
        Command::Man { folder } => pages::manual(folder),
    }
}

fn parsed(words: &[&str]) -> Result<CommandLine, Failure> {
    CommandLine::try_parse_from(words).map_err(|error| Failure::Input(error.to_string()))
}

/// `beamtick` with these arguments.
pub fn call(words: &[&str]) -> Result<(), Failure> {
    obey(&parsed(&[&["beamtick"], words].concat())?)
}

/// `beamtick bring-up` with these arguments, over `link`.
pub fn bring_up_over(link: Box<dyn Link>, words: &[&str]) -> Result<(), Failure> {
    let name = link.name().to_owned();
    match parsed(&[&["beamtick", "bring-up", "--link", &name], words].concat())?.command {
        Command::BringUp(arguments) => bring_up::over(link, &arguments),
        _ => Err(Failure::Input("it is no bring-up".to_owned())),
    }
}

pub use bring_up::Hands;

/// `beamtick bring-up --hands` with these arguments, by these hands.
pub fn bring_up_by_hand(hands: &mut dyn Hands, words: &[&str]) -> Result<(), Failure> {
    match parsed(&[&["beamtick", "bring-up", "--link", "by-hand"], words].concat())?.command {
        Command::BringUp(arguments) => bring_up::by_hand(hands, &arguments),
        _ => Err(Failure::Input("it is no bring-up".to_owned())),
    }
}

/// `beamtick run` with these arguments, over `link`.
pub fn run_over(link: Box<dyn Link>, words: &[&str]) -> Result<(), Failure> {
    let name = link.name().to_owned();
    match parsed(&[&["beamtick", "run", "--link", &name], words].concat())?.command {
        Command::Run(arguments) => runner::run(&arguments, Some(link)),
        _ => Err(Failure::Input("it is no job to run".to_owned())),
    }
}
