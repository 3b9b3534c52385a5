//! `beamtick sim` and `beamtick run`: a job from file to summary.
//!
//! In: the command line. Out: reads, files, a summary. When a call fails, or the user interrupts,
//! everything that still moves is stopped smoothly before the program ends.
use crate::Failure;
use crate::command_line::{Outputs, Run, Sim};
use crate::connect::{linked, simulated};
use crate::entries::{all_axes, entries};
use crate::record::{Recorded, Recording};
use crate::report::{INTERRUPTED, Report};
use crate::source::Source;
use client::{Call, Client, Progress};
use job::{Action, Axis, Job};
use protocol::command::{AxisItem, AxisStatus, GetPtState, Request, SetDo, SetDoBit, Stop, Trace};
use protocol::reason::Reason;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use virtual_board::Shared;
use zerocopy::FromBytes;

/// Bit 10 of the status word: the profile runs.
const RUNNING: u32 = 1 << 10;
/// Profile mode PT.
const MODE_PT: i16 = 2;
/// General outputs, as SetDo names them.
const GENERAL: i16 = 12;
/// A trace's end comes within this time of the program's, on the link's clock.
const TRACE_END: Duration = Duration::from_secs(10);
/// A smooth stop is awaited no longer than this, on the link's clock.
const STOP_END: Duration = Duration::from_secs(60);

/// A recording that the link's reader writes and the runner closes.
type Tape = Arc<Mutex<Option<Recording>>>;

/// Runs a job in the virtual controller.
pub fn sim(arguments: &Sim) -> Result<(), Failure> {
    let source = Source::open(&arguments.job)?;
    let (client, board) = simulated(&arguments.settings)?;
    execute(&source, &client, Some(board), &arguments.outputs)
}

/// Runs a job on a board.
pub fn run(arguments: &Run) -> Result<(), Failure> {
    let source = Source::open(&arguments.job)?;
    let client = linked(&arguments.link, &arguments.way, &arguments.settings)?;
    execute(&source, &client, None, &arguments.outputs)
}

fn execute(source: &Source, client: &Client, board: Option<Shared>, outputs: &Outputs) -> Result<(), Failure> {
    let simulated = board.is_some();
    let version = *client.version();
    let job = &source.job;
    let interrupt = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&interrupt);
    // Without the handler an interrupt ends the program at once, and link loss stops what it can.
    let _ = ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed));

    let recording = match outputs.traces() {
        true => Some(record(source, client, board, outputs)?),
        false => None,
    };
    let entries = entries(job, &version, recording.is_some());
    let mut report = Report::new(source, &entries, outputs.quiet, interrupt);
    let began = Instant::now();
    let outcome = drive(client, &mut report, &entries, job, outputs.strict);
    let took = began.elapsed();
    report.end();
    let progress = match outcome {
        Ok(progress) => progress,
        Err(failure) => {
            // The job has failed: what it left is stopped, and the first failure is what is told.
            let stopped = stop_all(client, job);
            if recording.is_some() {
                let _ = client.call(Trace::default());
            }
            let note = match stopped {
                Ok(true) => "\nWhat still moved was stopped smoothly.",
                Ok(false) => "\nNothing moves.",
                Err(_) => "\nThe controller could not be told to stop; it stops Jog axes by itself when the link is lost.",
            };
            return Err(match failure {
                Failure::Job(text) => Failure::Job(format!("{}{note}", text.trim_end())),
                other => other,
            });
        }
    };
    let recorded = recording.map(|recording| close(client, &recording)).transpose()?;
    summary(source, client, &report, &progress, recorded.as_ref(), simulated.then_some(took))
}

/// Runs the entries; goes on behind an entry that may fail.
fn drive(
    client: &Client, report: &mut Report<'_>, entries: &[crate::entries::Entry], job: &Job, strict: bool,
) -> Result<Progress, Failure> {
    loop {
        let calls: Vec<Call> = entries[report.first..].iter().map(|entry| entry.call.clone()).collect();
        let summary = client.run(calls, strict, report).map_err(|error| match error.code {
            INTERRUPTED => Failure::Job("interrupted".into()),
            _ => error.into(),
        })?;
        let Some(answer) = summary.failed else { return Ok(summary.progress) };
        let text = report.failure(&answer);
        let number = report.first + answer.index as usize;
        let may_fail = entries.get(number).and_then(|entry| entry.step(u16::MAX)).and_then(|step| job.steps.get(step))
            .is_some_and(|step| matches!(&step.action, Action::Call(call) if call.may_fail));
        let discarded = answer.refusal().is_some_and(|refusal| refusal.reason.get() == Reason::Discarded as u16);
        if !may_fail || discarded {
            return Err(Failure::Job(text));
        }
        eprint!("{}", text.replacen("Error", "Warning", 1));
        report.first = number + 1;
    }
}

/// Starts the trace and the files it goes to.
fn record(
    source: &Source, client: &Client, board: Option<Shared>, outputs: &Outputs,
) -> Result<Tape, Failure> {
    if !client.has_trace() {
        return Err(Failure::Input(format!(
            "{} carries no trace stream; --trace, --vcd and --plot need `beamtick sim` or `--link qemu`",
            client.name()
        )));
    }
    let version = client.version();
    let axes = source.job.axes.iter().filter_map(|axis| bit(axis, version.cores, version.axes_per_core)).fold(0u64, |mask, bit| mask | bit);
    if axes == 0 {
        return Err(Failure::Input(format!("{}: the job uses no axis of this profile; there is nothing to trace", source.name)));
    }
    let recording = Recording::new(outputs, &source.name, digital(&source.job), board)?;
    let recording = Arc::new(Mutex::new(Some(recording)));
    let sink = Arc::clone(&recording);
    client.trace_to(move |bytes| {
        if let Some(recording) = sink.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            recording.feed(bytes);
        }
    });
    client.call(Trace { every: outputs.every.into(), axes: axes.into(), lasers: 0, crds: 0 })?;
    Ok(recording)
}

/// Waits for the trace's end and closes the files.
fn close(client: &Client, recording: &Tape) -> Result<Recorded, Failure> {
    let start = client.now();
    let over = || recording.lock().unwrap_or_else(PoisonError::into_inner).as_ref().is_none_or(Recording::is_over);
    while !over() && client.now().saturating_sub(start) < TRACE_END {
        client.sleep(Duration::from_millis(5))?;
    }
    let mut shared = recording.lock().unwrap_or_else(PoisonError::into_inner);
    shared.take().map_or_else(|| Err(Failure::Job("trace: it is closed already".into())), Recording::finish)
}

/// The bit of an axis in masks over all cores.
fn bit(axis: &Axis, cores: u8, per_core: u8) -> Option<u64> {
    let (core, number) = (u8::try_from(axis.core).ok()?, u8::try_from(axis.axis).ok()?);
    let known = (1..=cores).contains(&core) && (1..=per_core).contains(&number);
    known.then(|| 1u64.checked_shl(u32::from(core - 1) * u32::from(per_core) + u32::from(number - 1))).flatten()
}

/// General outputs that the job sets, from 1.
fn digital(job: &Job) -> Vec<u8> {
    let mut outputs = Vec::new();
    for step in &job.steps {
        let Action::Call(call) = &step.action else { continue };
        match call.opcode {
            SetDoBit::OPCODE => {
                if let Ok(set) = SetDoBit::read_from_bytes(&call.body)
                    && set.do_type.get() == GENERAL
                {
                    outputs.extend(u8::try_from(set.index.get()).ok().filter(|index| (1..=32).contains(index)));
                }
            }
            SetDo::OPCODE if SetDo::read_from_bytes(&call.body).is_ok_and(|set| set.do_type.get() == GENERAL) => {
                outputs.extend(1..=16);
            }
            _ => {}
        }
    }
    outputs.sort_unstable();
    outputs.dedup();
    outputs
}

/// The state of each axis that the job used and the controller has.
fn states(client: &Client, job: &Job) -> client::Result<Vec<(Axis, AxisItem)>> {
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

/// Stops everything smoothly on the cores that the job used and waits; true if something moved.
fn stop_all(client: &Client, job: &Job) -> client::Result<bool> {
    let moves = |states: &[(Axis, AxisItem)]| states.iter().any(|(_, item)| item.status.get() & RUNNING != 0);
    let moved = moves(&states(client, job)?);
    for core in 1..=i16::from(client.version().cores) {
        let mask = all_axes(client.version()).cast_signed();
        client.call(Stop { core: core.into(), mask: mask.into(), option: 0.into(), form: 0 })?;
    }
    let start = client.now();
    while moves(&states(client, job)?) && client.now().saturating_sub(start) < STOP_END {
        client.sleep(Duration::from_millis(20))?;
    }
    Ok(moved)
}

fn summary(
    source: &Source, client: &Client, report: &Report<'_>, progress: &Progress, recorded: Option<&Recorded>, took: Option<Duration>,
) -> Result<(), Failure> {
    let version = client.version();
    let clock = progress.clock().as_secs_f64();
    println!("{}: done on {}, servo tick {} us", source.name, client.board(), version.tick_us);
    println!("  script clock {:.3} ms, {} entries", clock * 1e3, progress.queue.executed);
    if let Some(took) = took {
        let seconds = took.as_secs_f64().max(1e-9);
        println!("  simulated in {seconds:.3} s: {:.0} x real time", clock / seconds);
    }
    let late = progress.queue.late.get();
    if late > 0 {
        println!("  {late} late entries, the worst by {} us: they acted at once (--strict stops instead)", progress.queue.worst_late_us);
    } else {
        println!("  no late entries");
    }
    for (axis, item) in states(client, &source.job)? {
        let peak = recorded.and_then(|recorded| {
            let place = recorded.header.axes.iter().position(|name| (i16::from(name.core), i16::from(name.axis)) == (axis.core, axis.axis))?;
            recorded.peaks.get(place)
        });
        let peak = peak.map_or(String::new(), |peak| format!(", peak velocity {peak:.6} pulse/ms"));
        println!(
            "  {}: planned {:.6}, encoder {:.6} pulses{peak}, {}",
            name(&axis), item.prf_pos.get(), item.enc_pos.get(), ended(report, &axis, &item)
        );
        if item.mode.get() == MODE_PT {
            let state = client.call(GetPtState { core: axis.core.into(), profile: axis.axis.into() })?;
            let how = match state.state {
                0 => "never started",
                1 => "running",
                2 => "ran to its end",
                3 => "UNDERRUN: the data ran out at speed",
                _ => "ended by a Stop or a fault",
            };
            println!("    PT: {how}, {} passes, {} places free", state.loops, state.space0);
        }
    }
    for (dry, least) in &report.streams {
        println!(
            "  PT data of {}: at the last data {} places free, {} ms to dry; least seen {least} ms",
            name(&Axis { core: dry.core, axis: dry.axis }), dry.space, dry.dry_ms
        );
    }
    if let Some(recorded) = recorded {
        println!("  trace: {} rows, one every {} tick{}", recorded.rows, recorded.header.every, if recorded.header.every == 1 { "" } else { "s" });
    }
    Ok(())
}

fn name(axis: &Axis) -> String {
    if axis.core == 1 { format!("axis {}", axis.axis) } else { format!("core {} axis {}", axis.core, axis.axis) }
}

/// How an axis came to rest, as far as its status tells.
fn ended(report: &Report<'_>, axis: &Axis, item: &AxisItem) -> String {
    const BITS: [(u32, &str); 6] = [
        (1, "drive alarm"), (4, "following error"), (5, "positive limit"), (6, "negative limit"),
        (7, "smooth stop by input"), (8, "abrupt stop by input"),
    ];
    let status = item.status.get();
    let faults: Vec<&str> = BITS.iter().filter(|(bit, _)| status >> bit & 1 == 1).map(|(_, text)| *text).collect();
    if report.left.contains(&(axis.core, axis.axis)) {
        return format!("still moved when the script ended: stopped smoothly{}", if faults.is_empty() { "" } else { ", with faults" });
    }
    match (faults.is_empty(), status & RUNNING != 0) {
        (false, _) => format!("stopped: {}", faults.join(", ")),
        (true, true) => "moving".into(),
        (true, false) => "at rest".into(),
    }
}
