//! `beamtick monitor`: what a controller does, live; with `--command` also by keys.
//!
//! In: the command line, keys. Out: the block on the terminal, or once as text or JSON. Owns the
//! terminal while it shows, and with `--command` the session. Fails: with the link's error; then
//! the terminal is as it was.
//! Without `--command` the session only reads: nothing that this view does reaches the machine.
mod block;
mod panel;
mod screen;
mod state;

pub use state::State;

use crate::command_line::{FamilyName, LinkOptions, Monitor, Settings};
use crate::interrupt::{self, Held};
use crate::report::Report;
use crate::share::{Known, Share};
use crate::source::Source;
use crate::{Failure, connect, json, machine_file};
use client::{Client, Link, Options, ProductProfile, Progress};
use machine::{Family, Machine};
use panel::Panel;
use protocol::record::JobState;
use screen::{Key, Screen};
use state::{JobNow, UNKNOWN_MS};
use std::io::IsTerminal;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trace::Millimetres;

/// Where `beamtick serve` listens, if nothing is said.
const SERVED: &str = "tcp:127.0.0.1:5000";
/// Time between two reads of the controller.
const REFRESH_PERIOD: Duration = Duration::from_millis(200);
/// The same below a progress bar.
const PROGRESS_REFRESH_PERIOD: Duration = Duration::from_millis(250);
/// Longest wait for a key.
const KEY_TIMEOUT: Duration = Duration::from_millis(50);
/// What a view that only looks says to other keys.
const LOOKS: &str = "this view only looks; --command with --machine FILE takes the controller";

/// See the module text.
pub fn monitor(arguments: &Monitor) -> Result<(), Failure> {
    let machine =
        arguments.machine.as_deref().map(|file| machine_file::open(file, arguments.laser.as_deref())).transpose()?;
    let once = arguments.once || arguments.json;
    let terminal = std::io::stdout().is_terminal() && std::io::stdin().is_terminal();
    if !(once || terminal) {
        return Err(Failure::Input(
            "monitor: this is no terminal; --once prints the block, --json an object".to_owned(),
        ));
    }
    match &machine {
        Some(machine) if arguments.command => command(arguments, machine),
        machine => watch(arguments, machine.as_ref(), once),
    }
}

/// The link of this name, for a view that only looks.
fn viewed(name: &str, options: &LinkOptions) -> Result<Box<dyn Link>, Failure> {
    if name == "qemu" || name == "virtual" {
        return Err(Failure::Input(format!(
            "--link {name}: this controller is started anew, so there is nothing to look at; `beamtick serve`, or --share of \
             `beamtick run`, has an address to look at"
        )));
    }
    connect::named(name, options)
}

fn watch(arguments: &Monitor, machine: Option<&Machine>, once: bool) -> Result<(), Failure> {
    let name = arguments.link.as_deref().unwrap_or(SERVED);
    let options = Options { read_only: true, ..Options::default() };
    let client = Client::open(viewed(name, &arguments.link_options)?, options)?;
    let millimetres = machine.map_or_else(Vec::new, machine_file::millimetres);
    if once {
        let state = State::read(&client, &millimetres, None)?;
        let text: Vec<String> = block::lines(&state, ", read-only").into_iter().map(|line| line.text).collect();
        if !json::result(json::Facts::Monitor(Box::new(state))) {
            say!("{}", text.join("\n"));
        }
        return Ok(());
    }
    show(&client, &millimetres, None)
}

fn command(arguments: &Monitor, machine: &Machine) -> Result<(), Failure> {
    let program = arguments.program.as_deref().map(|path| panel::Program::open(path, arguments)).transpose()?;
    let name = arguments.link.as_deref().or(machine.link.as_deref()).unwrap_or("virtual");
    let (served, link) = match name {
        "virtual" => {
            let (served, link) = connect::real_time(None, ProductProfile::Gus)?;
            (Some(served), link)
        }
        name => (None, connect::named(name, &arguments.link_options)?),
    };
    let family = match machine.family {
        Family::Gus => FamilyName::Gus,
        Family::Lsr => FamilyName::Lsr,
    };
    let settings = Settings { tick_us: None, family: Some(family), profile: None };
    let client = Arc::new(connect::linked(link, &settings, Some(ProductProfile::Gus), None)?);
    let mut panel = Panel::new(Arc::clone(&client), machine, program);
    let shown = show(&client, &machine_file::millimetres(machine), Some(&mut panel));
    // Dark at once, everything comes to rest; then the client's session ends with an Abort.
    let ended = panel.end();
    drop(client);
    drop(served);
    shown.and(ended.map_err(Failure::from))
}

/// Shows until a key, a signal or the link ends it.
fn show(client: &Client, millimetres: &[Millimetres], mut panel: Option<&mut Panel>) -> Result<(), Failure> {
    let held = Held::new();
    let mut screen = Screen::open()?;
    let mut note = String::new();
    let (mut read_at, mut state) = (Instant::now(), State::read(client, millimetres, None)?);
    loop {
        if let Some(panel) = panel.as_deref_mut() {
            panel.turn()?;
            state.job = panel.job();
        }
        screen.draw(&state, panel.as_deref(), &note)?;
        if interrupt::came().is_some() {
            break;
        }
        let key = screen.key(KEY_TIMEOUT)?;
        match (key, panel.as_deref_mut()) {
            (None, _) => {}
            (Some(Key::Quit), _) => break,
            (Some(Key::Unknown), _) => note.clear(),
            (Some(_), None) => LOOKS.clone_into(&mut note),
            (Some(key), Some(panel)) => note = panel.press(key),
        }
        if read_at.elapsed() >= REFRESH_PERIOD {
            read_at = Instant::now();
            state = State::read(client, millimetres, None)?;
        }
    }
    drop(screen);
    drop(held);
    match interrupt::came() {
        Some(signal) => Err(Failure::Interrupted(signal, String::new())),
        None => Ok(()),
    }
}

/// What `beamtick run` shows of the machine below its bar, and tells viewers.
pub struct Live<'a> {
    source: &'a Source,
    share: Option<&'a Share>,
    shown: Option<Instant>,
}

impl<'a> Live<'a> {
    /// Of a job.
    pub fn new(source: &'a Source, share: Option<&'a Share>) -> Self {
        Live { source, share, shown: None }
    }

    /// The job has come to here.
    pub fn follow(&mut self, client: &Client, report: &mut Report<'_, '_>, progress: &Progress) -> client::Result<()> {
        let due = self.shown.is_none_or(|at| at.elapsed() >= PROGRESS_REFRESH_PERIOD);
        if !due {
            return Ok(());
        }
        self.shown = Some(Instant::now());
        let entries = report.total();
        let done = progress.queue.executed.get().min(entries);
        let planned = self.source.extent.as_ref().and_then(|extent| extent.seconds);
        let left_ms = left_ms(progress.clock().as_secs_f64(), planned);
        let job = JobState { entries: entries.into(), done: done.into(), left_ms: left_ms.into() };
        let job = (job, self.source.name.clone());
        if report.is_visible() {
            let mut state = State::read(client, &self.source.millimetres, Some(&progress.queue))?;
            state.job = Some(JobNow::of(&job));
            let lines: Vec<String> = block::machine(&state).into_iter().map(|line| line.text).collect();
            report.show(lines.join("\n"));
        }
        if let Some(share) = self.share {
            share.publish(Known { program: progress.queue, job: Some(job) });
        }
        Ok(())
    }
}

/// Time left of a job, ms: what the look-ahead has planned for its path less the script clock `at`
/// (s). Without a plan nobody knows it.
fn left_ms(at: f64, planned: Option<f64>) -> u32 {
    planned.map_or(UNKNOWN_MS, |all| ((all - at).max(0.0) * 1e3).min(f64::from(UNKNOWN_MS - 1)) as u32)
}

#[cfg(test)]
mod tests;
