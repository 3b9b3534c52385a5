//! `beamtick sim` and `beamtick run`: a job from file to summary.
//!
//! In: the command line. Out: reads, files, a summary. Every job ends with Abort: as the script's
//! last entry, or at once when a call fails or a signal comes. No job ends with light on.
use crate::Failure;
use crate::command_line::{InputFile, Outputs, PanelName, Run, Sim};
use crate::connect::{linked, named, real_time, simulated};
use crate::entries::lasers;
use crate::input::{self, Role};
use crate::interrupt::{self, Held};
use crate::ledger::Ledger;
use crate::monitor::Live;
use crate::output::Kept;
use crate::record::{Recorded, Recording};
use crate::report::{INTERRUPTED, Report};
use crate::share::{self, Share};
use crate::source::Source;
use crate::waits::{ENDLESS, Knowledge, Watch};
use crate::{import, json, output, profile, summary};
use client::inputs::{Inputs, Zero};
use client::{Call as Packed, Client, Link, Progress, decode};
use job::{Axis, Job, Severity};
use protocol::command::{Abort, AxisItem, AxisStatus, GetEvents, LaserStatus, Trace, VersionReply};
use protocol::reason::{Reason, Refusal};
use protocol::values::status::RUNNING;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use trace::AxisName;

/// Boards whose encoders are those of the crate `plant`.
const WITHOUT_WIRES: [&str; 2] = ["virtual", "mps2-an500"];
/// A parameter is out of range.
const RANGE: i16 = 7;
/// The firmware does not know a command.
const UNKNOWN: i16 = 8;
/// A trace ends within this time after the program, on the link's clock.
const TRACE_END_TIMEOUT: Duration = Duration::from_secs(10);
/// Of a job that has failed, within this, on this machine's clock.
const FAILED_TRACE_END_TIMEOUT: Duration = Duration::from_millis(400);
/// From this time without a look at the link on, the machine is named where a controller took its
/// client for lost.
const HELD_UP_AFTER: Duration = Duration::from_millis(250);
/// The end of an aborted motion is awaited no longer than this, on the link's clock.
const STANDSTILL_TIMEOUT: Duration = Duration::from_secs(60);
/// The same after a signal, on this machine's clock.
const STANDSTILL_TIMEOUT_AFTER_SIGNAL: Duration = Duration::from_millis(300);

/// A recording that the link's reader writes and the runner closes.
type Tape = Arc<Mutex<Option<Recording>>>;

/// Runs a job in the virtual controller.
pub fn sim(arguments: &Sim) -> Result<(), Failure> {
    let mut source = Source::open(&arguments.job, &arguments.drawing, false)?;
    let settings = source.settings(&arguments.settings)?;
    let inputs = inputs(&mut source, &arguments.inputs)?;
    output::check(&source.files, &arguments.outputs.files())?;
    let client = Arc::new(simulated(&settings, arguments.steps, Some(profile::of_job(&source.job)))?);
    let knowledge = Knowledge { all_known: true, virtual_time: true, inputs: inputs.as_ref() };
    execute(&source, &client, knowledge, &arguments.outputs, None)
}

/// Runs a job on a board: over `link`, or over the one that the command line names.
pub fn run(arguments: &Run, link: Option<Box<dyn Link>>) -> Result<(), Failure> {
    let mut source = Source::open(&arguments.job, &arguments.drawing, true)?;
    let settings = source.settings(&arguments.settings)?;
    let inputs = inputs(&mut source, &arguments.inputs)?;
    output::check(&source.files, &arguments.outputs.files())?;
    let profile = profile::of_job(&source.job);
    // Nobody else reaches the inputs of a board that this process starts.
    let name = import::link(arguments.link.as_deref(), &arguments.drawing)?;
    let all_known = link.is_none() && ["qemu", "virtual"].contains(&name.as_str());
    let shared = arguments.share.share.as_deref().map(share::listen).transpose()?;
    let (served, link) = match link {
        Some(link) => (None, link),
        None if name == "virtual" => {
            let profile = settings.profile.as_deref().map_or(Ok(profile), profile::named)?;
            let (served, link) = real_time(settings.tick_us, profile)?;
            (Some(served), link)
        }
        None => (None, named(&name, &arguments.link_options)?),
    };
    let client = Arc::new(linked(link, &settings, Some(profile), profile::reason(&source.job).as_deref())?);
    let knowledge = Knowledge { all_known, virtual_time: false, inputs: inputs.as_ref() };
    let shared = shared.map(|listener| Share::start(listener, Arc::clone(&client))).transpose()?;
    let live = Live::new(&source, shared.as_ref());
    let done = execute(&source, &client, knowledge, &arguments.outputs, Some(live));
    // Nobody looks any more when the session ends.
    drop(shared);
    drop(client);
    drop(served);
    done
}

/// The file of inputs, which no output may overwrite.
fn inputs(source: &mut Source, file: &InputFile) -> Result<Option<Inputs>, Failure> {
    let Some(path) = &file.inputs else { return Ok(None) };
    if !input::is_standard(path) {
        source.files.push(path.clone());
    }
    self::levels(path).map(Some)
}

/// Reads a file of inputs.
pub fn levels(path: &Path) -> Result<Inputs, Failure> {
    let name = path.display().to_string();
    let bytes = input::read(path, Role::Inputs)
        .map_err(|error| Failure::Input(format!("{name}: the inputs cannot be read: {error}")))?;
    Inputs::read(&name, &bytes).map_err(Failure::Input)
}

fn execute(
    source: &Source,
    client: &Client,
    knowledge: Knowledge<'_>,
    outputs: &Outputs,
    live: Option<Live<'_>>,
) -> Result<(), Failure> {
    if let Some(inputs) = knowledge.inputs {
        inputs.plan(client, Zero::Program).map_err(|error| match error.code {
            RANGE => Failure::Input(error.reason),
            _ => error.into(),
        })?;
    }
    let simulated = knowledge.virtual_time;
    let version = *client.version();
    let job = &source.job;
    let recording = match outputs.traces() {
        true => Some(record(source, client, outputs)?),
        false => None,
    };
    let ledger = Ledger::new(source, version, recording.is_some());
    if live.is_some() {
        // Counting takes a while: not while the job runs.
        ledger.total();
    }
    let mut report = Report::new(source, &ledger, version, outputs.quiet);
    let events = if job.lasers == 0 { 0 } else { client.call(GetEvents {})?.total.get() };
    let began = Instant::now();
    let held = Held::new();
    let watch = Watch::new(&mut report, source, &ledger, client, knowledge).with(live);
    let outcome = drive(client, watch, &ledger, outputs.strict);
    let took = began.elapsed();
    report.end();
    let progress = match outcome {
        Ok(progress) => progress,
        Err(failure) => {
            let stopped = stop_all(client, job);
            drop(held);
            let note = match stopped {
                Ok(stopped) => stopped.text(),
                Err(error) if error.code == UNKNOWN => format!(
                    "Nothing was stopped: this firmware is older than Abort ({error}). When the link is lost it shuts off lasers by itself; \
                     load the firmware of this version."
                ),
                Err(error) => format!(
                    "The controller could not be stopped ({error}). When the link is lost it shuts off lasers, and stops Jog axes and \
                     coordinate systems, by itself."
                ),
            };
            // What a signal is answered by is said before files are looked after: there is a second
            // for all.
            let failure = match failure {
                Failure::Job(text) => Failure::Job(format!("{}\n{note}", text.trim_end())),
                Failure::Interrupted(signal, text) => {
                    complain!("{text}\n{note}");
                    Failure::Interrupted(signal, String::new())
                }
                Failure::Input(text) => Failure::Input(text),
            };
            let kept = recording.map_or_else(Vec::new, |recording| cut_off(client, &recording));
            let kept: String = kept.iter().map(Kept::to_string).collect();
            return Err(match failure {
                Failure::Job(text) => Failure::Job(text + &kept),
                Failure::Interrupted(signal, _) => Failure::Interrupted(signal, kept.trim_start().to_owned()),
                Failure::Input(text) => Failure::Input(text),
            });
        }
    };
    // Dark and at standstill: a signal may end the program from here on.
    drop(held);
    let (recorded, unrecorded) = match recording.map(|recording| close(client, &recording)) {
        None => (None, None),
        Some(closed) => closed?,
    };
    let (facts, lost) = summary::facts(&summary::Run {
        source,
        client,
        report: &report,
        progress: &progress,
        events,
        recorded: recorded.as_ref(),
        every: outputs.every,
        took: simulated.then_some(took),
    })?;
    let text = facts.to_string();
    if !json::result(json::Facts::Summary(Box::new(facts))) {
        say!("{}", text.trim_end());
    }
    match (lost, unrecorded) {
        (None, None) => Ok(()),
        (None, Some(failure)) => Err(failure),
        (Some(lost), None) => Err(Failure::Job(lost)),
        (Some(lost), Some(failure)) => {
            complain!("{lost}");
            Err(failure)
        }
    }
}

/// Runs the entries.
fn drive(
    client: &Client,
    mut watch: Watch<'_, '_, '_>,
    ledger: &Ledger<'_>,
    strict: bool,
) -> Result<Progress, Failure> {
    let summary = client.run(std::iter::from_fn(|| ledger.next_call()), strict, &mut watch);
    let report = watch.report();
    let summary = summary.map_err(|error| match error.code {
        INTERRUPTED => interrupted(report.job()),
        ENDLESS => Failure::Job(error.reason),
        _ => error.into(),
    })?;
    match summary.failed {
        None => match ledger.broken() {
            Some(why) => Err(Failure::Job(format!("{}: {why}; what comes after it was not run", report.job()))),
            None => Ok(summary.progress),
        },
        Some(answer) => {
            let mut text = report.failure(&answer, Severity::Error);
            let late = answer.refusal().and_then(Refusal::reason) == Some(Reason::Late);
            if let Some(first) = summary.progress.first_late.filter(|_| late) {
                let worst = summary.progress.queue.worst_late_us;
                text.push_str(&format!(
                    "The first late entry is {}; the worst came {worst} us late.\n",
                    report.location(first)
                ));
            }
            let lost = answer.refusal().and_then(Refusal::reason) == Some(Reason::LinkLost);
            if lost && client.held_up() >= HELD_UP_AFTER {
                text.push_str(&format!("This machine held the program up for {} ms.\n", client.held_up().as_millis()));
            }
            Err(Failure::Job(text))
        }
    }
}

/// Starts the trace and its files.
fn record(source: &Source, client: &Client, outputs: &Outputs) -> Result<Tape, Failure> {
    let version = client.version();
    let axes = source
        .job
        .axes
        .iter()
        .filter_map(|axis| bit(axis, version.cores, version.axes_per_core))
        .fold(0u64, |mask, bit| mask | bit);
    let lasers = source.job.lasers & channels(version.lasers);
    let crds = source
        .job
        .crds
        .iter()
        .filter_map(|crd| index_over_cores(crd.core, crd.crd, version.cores, version.crds_per_core))
        .fold(0u8, |mask, place| mask | 1u8.checked_shl(place).unwrap_or(0));
    if axes == 0 && lasers == 0 {
        return Err(Failure::Input(format!(
            "{}: the job uses no axis and no laser of this profile; there is nothing to trace",
            source.name
        )));
    }
    if outputs.xy.is_some() || outputs.xy_axes.is_some() {
        check_xy(source, outputs.xy_axes)?;
    }
    if outputs.panels.contains(&PanelName::Error) && !WITHOUT_WIRES.contains(&client.board().as_str()) {
        return Err(Failure::Input(format!(
            "--panels error: the board {} has encoders of its own, which a trace does not hold; it is for {}",
            client.board(),
            WITHOUT_WIRES.join(" and ")
        )));
    }
    let family = match (source.job.lasers, version.family) {
        (0, _) => "",
        (_, 0) => ", family gus",
        _ => ", family lsr",
    };
    let subtitle =
        format!("{}, profile {}{family}, servo tick {} us", client.board(), profile::shown(version), version.tick_us);
    let digital = digital(source, version);
    let analog: Vec<u8> = source.totals.analog.iter().copied().collect();
    let shows_outputs = !(digital.is_empty() && analog.is_empty()) && outputs.vcd.is_some();
    let recording = Recording::new(outputs, (&source.name, subtitle), (digital, analog), source.millimetres.clone())?;
    let recording = Arc::new(Mutex::new(Some(recording)));
    let sink = Arc::clone(&recording);
    client.trace_to(move |bytes| {
        if let Some(recording) = sink.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            recording.feed(bytes);
        }
    });
    let (over_link, every) = match client.trace_rate() {
        None => (0, outputs.every),
        Some(rate) => {
            let row = row_bytes(axes.count_ones(), lasers.count_ones(), crds.count_ones());
            (1, outputs.every.max(least_every(rate, row, version.tick_us.get())))
        }
    };
    // What lasers do between rows is for pictures and signals only; general and analog outputs are
    // signals.
    let edges = u8::from(lasers != 0 && outputs.shows_edges()) | u8::from(shows_outputs) << 1;
    if every > outputs.every {
        complain!("{}: the trace has a row every {every} ticks: this link does not carry more", client.name());
    }
    client.call(Trace { every: every.into(), axes: axes.into(), lasers, crds, over_link, edges })?;
    Ok(recording)
}

/// Whether the job uses the axes that are to be drawn one over the other.
fn check_xy(source: &Source, axes: Option<(AxisName, AxisName)>) -> Result<(), Failure> {
    let name = |axis: &Axis| AxisName { core: axis.core as u8, axis: axis.axis as u8 };
    let used: Vec<AxisName> = source.job.axes.iter().map(name).collect();
    let missing = axes.and_then(|(x, y)| [x, y].into_iter().find(|axis| !used.contains(axis)));
    let names: Vec<String> = used.iter().map(AxisName::to_string).collect();
    let uses = match &names[..] {
        [] => "no axis".to_owned(),
        [one] => format!("{one} only"),
        _ => names.join(", "),
    };
    let name = &source.name;
    Err(Failure::Input(match missing {
        Some(axis) => format!("--xy-axes: {name} does not use {axis}; it uses {uses}"),
        None if axes.is_none() && used.len() < 2 => {
            format!("--xy draws one axis over another, and {name} uses {uses}; --plot draws it over time")
        }
        None => return Ok(()),
    }))
}

/// Bits of the laser channels that a controller has.
fn channels(lasers: u8) -> u8 {
    1u8.checked_shl(lasers.into()).unwrap_or(0).wrapping_sub(1)
}

/// Bytes of a row (docs/protocol.md section 7).
fn row_bytes(axes: u32, lasers: u32, crds: u32) -> u32 {
    5 + 18 * axes + 18 * lasers + 10 * crds
}

/// Ticks from row to row that a link of `rate` bytes a second carries.
fn least_every(rate: u32, row: u32, tick_us: u32) -> u32 {
    // Frames and records add less than a tenth.
    let row = u64::from(row) * 11 / 10 + 1;
    let per_tick = row * 1_000_000;
    u32::try_from(per_tick.div_ceil(u64::from(rate.max(1)) * u64::from(tick_us.max(1)))).unwrap_or(u32::MAX).max(1)
}

/// Waits for the trace's end and closes the files: what was recorded, and which file failed.
fn close(client: &Client, recording: &Tape) -> client::Result<(Option<Recorded>, Option<Failure>)> {
    let start = client.now();
    while !is_over(recording) && client.now().saturating_sub(start) < TRACE_END_TIMEOUT {
        client.sleep(Duration::from_millis(5))?;
    }
    Ok(take(recording).map_or((None, None), Recording::finish))
}

/// Ends the trace of a job that has failed; the files that hold what there is of it.
fn cut_off(client: &Client, recording: &Tape) -> Vec<Kept> {
    let began = Instant::now();
    if client.call(Trace::default()).is_ok() {
        while !is_over(recording)
            && began.elapsed() < FAILED_TRACE_END_TIMEOUT
            && client.sleep(Duration::from_millis(5)).is_ok()
        {}
    }
    take(recording).map_or_else(Vec::new, Recording::cut_off)
}

fn is_over(recording: &Tape) -> bool {
    recording.lock().unwrap_or_else(PoisonError::into_inner).as_ref().is_none_or(Recording::is_over)
}

fn take(recording: &Tape) -> Option<Recording> {
    recording.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// The bit of an axis in masks over all cores.
fn bit(axis: &Axis, cores: u8, per_core: u8) -> Option<u64> {
    1u64.checked_shl(index_over_cores(axis.core, axis.axis, cores, per_core)?)
}

/// Where an axis or a coordinate system is, counted over all cores, if the controller has it.
pub fn index_over_cores(core: i16, number: i16, cores: u8, per_core: u8) -> Option<u32> {
    let (core, number) = (u8::try_from(core).ok()?, u8::try_from(number).ok()?);
    let known = (1..=cores).contains(&core) && (1..=per_core).contains(&number);
    known.then(|| u32::from(core - 1) * u32::from(per_core) + u32::from(number - 1))
}

/// General outputs that the job sets, from 1.
fn digital(source: &Source, version: &VersionReply) -> Vec<u8> {
    (1..=version.general_outputs.min(64)).filter(|output| source.totals.digital >> (output - 1) & 1 == 1).collect()
}

/// The state of each axis that the job used and the controller has.
pub fn states(client: &Client, job: &Job) -> client::Result<Vec<(Axis, AxisItem)>> {
    let version = client.version();
    let mut states = Vec::new();
    for axis in &job.axes {
        if bit(axis, version.cores, version.axes_per_core).is_some() {
            let request = AxisStatus { core: axis.core.into(), axis: axis.axis.into(), count: 1.into() };
            let (_, items) = client.call_items(request, &[])?;
            states.extend(items.first().map(|item| (*axis, *item)));
        }
    }
    Ok(states)
}

/// The failure of a job that a signal ended.
fn interrupted(name: &str) -> Failure {
    match interrupt::came() {
        Some(signal) => Failure::Interrupted(signal, format!("{name}: interrupted by {}", signal.name())),
        None => Failure::Job(format!("{name}: interrupted")),
    }
}

/// What an Abort found, and what it left.
struct Stopped {
    /// Axes of the job that moved when it came.
    moved: Vec<Axis>,
    /// Those that brake still.
    braking: Vec<Axis>,
    /// Laser channels of the job with light all the same.
    lit: Vec<u8>,
}

impl Stopped {
    fn text(&self) -> String {
        let names = |axes: &[Axis]| axes.iter().map(summary::name).collect::<Vec<_>>().join(", ");
        let light = match self.lit[..] {
            [] => "Light is off.".to_owned(),
            ref lit => format!("LIGHT IS STILL ON: laser {lit:?}."),
        };
        let motion = match (&self.moved[..], &self.braking[..]) {
            ([], []) => "Nothing moves.".to_owned(),
            (moved, []) => format!("What still moved ({}) was stopped smoothly.", names(moved)),
            (_, braking) => format!("Still braking to a smooth stop: {}.", names(braking)),
        };
        format!("{light} {motion}")
    }
}

/// Aborts, and waits until all axes are at standstill.
fn stop_all(client: &Client, job: &Job) -> client::Result<Stopped> {
    let version = client.version();
    let used = |axis: &&Axis| bit(axis, version.cores, version.axes_per_core).is_some();
    let axes: Vec<Axis> = job.axes.iter().filter(used).copied().collect();
    let status = |axis: &Axis| AxisStatus { core: axis.core.into(), axis: axis.axis.into(), count: 1.into() };
    // What moves is read in the message that aborts: no time passes for it.
    let calls: Vec<Packed> =
        axes.iter().map(|axis| Packed::of(status(axis))).chain([Packed::of(Abort { core: 1.into() })]).collect();
    let replies = client.call_all(&calls)?.into_iter().collect::<client::Result<Vec<_>>>()?;
    let mut moved = Vec::new();
    for (axis, reply) in axes.iter().zip(&replies) {
        let (_, items) = decode::<AxisStatus>(reply)?;
        moved.extend(items.iter().any(runs).then_some(*axis));
    }
    let (start, began) = (client.now(), Instant::now());
    let braking = loop {
        let braking: Vec<Axis> =
            states(client, job)?.into_iter().filter(|(_, item)| runs(item)).map(|(axis, _)| axis).collect();
        let over = interrupt::came().is_some() && began.elapsed() > STANDSTILL_TIMEOUT_AFTER_SIGNAL;
        if braking.is_empty() || over || client.now().saturating_sub(start) > STANDSTILL_TIMEOUT {
            break braking;
        }
        client.sleep(Duration::from_millis(5))?;
    };
    let mut lit = Vec::new();
    for channel in lasers(job, version) {
        let state = client.call(LaserStatus { core: 1.into(), channel: i16::from(channel).into() })?;
        lit.extend((state.light != 0).then_some(channel));
    }
    Ok(Stopped { moved, braking, lit })
}

fn runs(item: &AxisItem) -> bool {
    item.status.get() & RUNNING != 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_as_many_as_the_link_carries() {
        // 8 axes at 250 us are 149 bytes a row, 596 kB/s and what frames add.
        assert_eq!(least_every(1_000_000, row_bytes(8, 0, 0), 250), 1);
        assert_eq!(least_every(61_440, row_bytes(8, 0, 0), 250), 11);
        assert_eq!(least_every(61_440, row_bytes(8, 2, 0), 250), 14);
        assert_eq!(least_every(61_440, row_bytes(1, 0, 0), 250), 2);
        assert_eq!(least_every(7_680, row_bytes(48, 0, 0), 10), 12_448);
        for (rate, axes, lasers, tick_us) in [(61_440, 8, 2, 250), (7_680, 1, 0, 50), (1_000_000, 48, 2, 50)] {
            let every = least_every(rate, row_bytes(axes, lasers, 2), tick_us);
            let bytes_a_second = f64::from(25 + 18 * (axes + lasers)) * 1e6 / f64::from(tick_us * every);
            assert!(bytes_a_second * 1.1 <= f64::from(rate), "{rate} {axes} {tick_us}: {every}");
        }
    }

    #[test]
    fn channels_are_those_of_the_controller() {
        assert_eq!([channels(0), channels(1), channels(2), channels(8)], [0, 1, 3, 0xff]);
    }
}
