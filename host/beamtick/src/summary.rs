//! The summary: what a job has done, where its axes are and why they stopped, what the link
//! carried.
//!
//! In: a job that has run, reads of the controller. Out: [`Summary`], facts which are the text and
//! the JSON alike (docs/json.md). Owns nothing. Fails where a read fails.
mod text;

use crate::Failure;
use crate::entries::lasers;
use crate::profile;
use crate::record::Recorded;
use crate::report::Report;
use crate::runner::{index_over_cores, states};
use crate::source::Source;
use client::{Client, Error, LinkCounters, Progress, laser_cause};
use job::{Axis, Crd};
use protocol::command::{AxisItem, CrdInfo, CrdState, EventItem, GetEvents, GetPtState, LaserState, LaserStatus};
use protocol::reason::{Reason, Refusal, stop_summary};
use protocol::values::status::{self, RUNNING};
use protocol::values::{event, laser_fault, mode, path_stop, pt_state};
use serde::Serialize;
use std::time::Duration;
pub(crate) use text::{counted, named};
use trace::Millimetres;

/// What a job has done.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Summary {
    /// The job's file.
    job: String,
    /// The board's name.
    board: String,
    profile: String,
    servo_tick_us: u32,
    script_clock_ms: f64,
    /// Entries of the program that were executed.
    entries: u32,
    /// `sim`: seconds of the wall clock.
    simulated_s: Option<f64>,
    late: Late,
    overruns: Overruns,
    /// Calls that failed and were allowed to (`#pragma continue`).
    failures_passed_over: u32,
    axes: Vec<AxisFacts>,
    coordinate_systems: Vec<CrdFacts>,
    lasers: Vec<LaserFacts>,
    pt_streams: Vec<StreamFacts>,
    link: LinkFacts,
    /// What was traced, if anything was.
    trace: Option<TraceFacts>,
}

/// Entries that acted after their tick.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Late {
    count: u32,
    worst_us: u32,
    /// Call and line of the first one.
    first: Option<String>,
}

/// Servo ticks that took too long.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Overruns {
    count: u32,
    /// Call and line after which the first one came.
    first_after: Option<String>,
}

/// An axis that the job used.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct AxisFacts {
    core: i16,
    axis: i16,
    /// Planned position, pulses.
    planned: f64,
    /// Encoder, pulses.
    encoder: f64,
    /// The axis of the machine file.
    letter: Option<char>,
    planned_mm: Option<f64>,
    /// pulse/ms, of a trace.
    peak_velocity: Option<f64>,
    /// How its last motion ended.
    end: String,
    /// Latched bits of its status.
    latched: Vec<&'static str>,
    /// In PT mode.
    pt: Option<PtFacts>,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct PtFacts {
    state: &'static str,
    passes: i32,
    free_slots: u16,
}

/// A coordinate system that the job set up.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CrdFacts {
    core: i16,
    crd: i16,
    segments_done: i64,
    segments_left: i64,
    /// pulse/ms, of a trace.
    peak_speed: Option<f64>,
    /// How its path ended; none if it drives no axis any more.
    end: Option<String>,
}

/// A laser channel.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LaserFacts {
    pub(crate) channel: u8,
    /// Its name in the machine file.
    name: Option<String>,
    mode: &'static str,
    /// Of `output`.
    unit: &'static str,
    light: bool,
    output: f64,
    light_ms: f64,
    width_limited_now: bool,
    /// Why a fault keeps it dark.
    kept_dark: Option<&'static str>,
    /// It was on when the script ended.
    on_at_the_end: bool,
    /// Times that its rate reached the pulse width, in this job.
    width_limited_times: u32,
}

/// Data of a PT stream.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct StreamFacts {
    core: i16,
    axis: i16,
    free_slots: u16,
    ms_to_dry: u32,
    least_ms_to_dry: Option<u32>,
}

/// Messages of the link.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct LinkFacts {
    sent: u32,
    received: u32,
    sent_again: u32,
    came_twice: u32,
    damaged: u32,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct TraceFacts {
    rows: u32,
    /// Ticks from row to row.
    every: u32,
    /// More than was asked for: the link carries no more.
    raised: bool,
}

/// A job that has run.
pub struct Run<'a, 's> {
    /// The script.
    pub source: &'a Source,
    /// The controller.
    pub client: &'a Client,
    /// What was observed during the job.
    pub report: &'a Report<'a, 's>,
    /// Where the program was at its end.
    pub progress: &'a Progress,
    /// Events that there were before, of a job that uses a laser.
    pub events: u32,
    /// What a trace showed.
    pub recorded: Option<&'a Recorded>,
    /// Ticks from row to row that were asked for.
    pub every: u32,
    /// In virtual time: the wall-clock time that the job took.
    pub took: Option<Duration>,
}

/// The facts, and what took light from the job, if anything did.
pub fn facts(run: &Run<'_, '_>) -> Result<(Summary, Option<String>), Failure> {
    let (client, progress) = (run.client, run.progress);
    let version = client.version();
    let at = |entry: Option<u32>| entry.map(|entry| run.report.location(entry));
    let axes = states(client, &run.source.job)?.into_iter().map(|(axis, item)| axis_facts(run, axis, &item));
    let axes = axes.collect::<Result<Vec<_>, Failure>>()?;
    let mut coordinate_systems = Vec::new();
    for crd in &run.source.job.crds {
        if index_over_cores(crd.core, crd.crd, version.cores, version.crds_per_core).is_none() {
            continue;
        }
        let (core, number, peak_speed) = (crd.core, crd.crd, speed(run.recorded, crd));
        let (segments_done, segments_left, end) = match client.call(CrdInfo { core: core.into(), crd: number.into() }) {
            Ok(state) => {
                let [done, left] = path(&state);
                (done, left, Some(path_end(&state)))
            }
            Err(error) if is_without_axes(&error) => (0, 0, None),
            Err(error) => return Err(error.into()),
        };
        coordinate_systems.push(CrdFacts { core, crd: number, segments_done, segments_left, peak_speed, end });
    }
    let (mut lasers_found, mut faults) = (Vec::new(), Vec::new());
    let events = new_events(run)?;
    for channel in lasers(&run.source.job, version) {
        let state = client.call(LaserStatus { core: 1.into(), channel: i16::from(channel).into() })?;
        let of_it = |item: &&EventItem| (item.kind, item.of) == (event::LIMITED, channel);
        lasers_found.push(LaserFacts {
            name: run.source.lasers.iter().find(|named| named.0 == channel).map(|named| named.1.clone()),
            on_at_the_end: run.report.lit.contains(&channel),
            width_limited_times: events.iter().filter(of_it).map(|item| u32::from(item.reason.get())).sum(),
            ..LaserFacts::of(channel, &state)
        });
        faults.push((channel, state.fault.get()));
    }
    let pt_streams = run.report.streams.iter().map(|(dry, least)| StreamFacts {
        core: dry.core,
        axis: dry.axis,
        free_slots: dry.space,
        ms_to_dry: dry.dry_ms,
        least_ms_to_dry: *least,
    });
    let trace = run.recorded.map(|recorded| TraceFacts {
        rows: recorded.rows,
        every: recorded.header.every,
        raised: recorded.header.every > run.every,
    });
    let summary = Summary {
        job: run.source.name.clone(),
        board: client.board().to_string(),
        profile: profile::shown(version).to_owned(),
        servo_tick_us: version.tick_us.get(),
        script_clock_ms: progress.clock().as_secs_f64() * 1e3,
        entries: progress.queue.executed.get(),
        simulated_s: run.took.map(|took| took.as_secs_f64()),
        late: Late {
            count: progress.queue.late.get(),
            worst_us: progress.queue.worst_late_us.get(),
            first: at(progress.first_late),
        },
        overruns: Overruns { count: progress.queue.overruns.get(), first_after: at(progress.overran) },
        failures_passed_over: run.report.warned,
        axes,
        coordinate_systems,
        lasers: lasers_found,
        pt_streams: pt_streams.collect(),
        link: LinkFacts::of(&client.counters()),
        trace,
    };
    Ok((summary, taken(run, &faults)))
}

fn axis_facts(run: &Run<'_, '_>, axis: Axis, item: &AxisItem) -> Result<AxisFacts, Failure> {
    let is_it = |mm: &&Millimetres| (i16::from(mm.axis.core), i16::from(mm.axis.axis)) == (axis.core, axis.axis);
    let mm = run.source.millimetres.iter().find(is_it);
    let pt = match item.mode.get() == mode::PT {
        true => {
            let state = run.client.call(GetPtState { core: axis.core.into(), profile: axis.axis.into() })?;
            let (passes, free_slots) = (state.loops.get(), state.space0.get());
            Some(PtFacts { state: pt_text(state.state), passes, free_slots })
        }
        false => None,
    };
    let (end, latched) = ended(run.report, &axis, item);
    Ok(AxisFacts {
        core: axis.core,
        axis: axis.axis,
        planned: item.prf_pos.get(),
        encoder: item.enc_pos.get(),
        letter: mm.map(|mm| mm.letter),
        // Without the sign of what is rounded to 0.
        planned_mm: mm.map(|mm| ((mm.zero + item.prf_pos.get() / mm.per_mm) * 1000.0).round() / 1000.0 + 0.0),
        peak_velocity: peak(run.recorded, &axis),
        end: end.to_owned(),
        latched,
        pt,
    })
}

/// Events of a job that uses a laser, of its own time.
fn new_events(run: &Run<'_, '_>) -> Result<Vec<EventItem>, Failure> {
    if run.source.job.lasers == 0 {
        return Ok(Vec::new());
    }
    let (head, mut items) = run.client.call_items(GetEvents {}, &[])?;
    let new = head.total.get().wrapping_sub(run.events) as usize;
    items.drain(..items.len().saturating_sub(new));
    Ok(items)
}

/// What took light from the job, if anything did. `faults` are the causes that keep its lasers dark
/// now, by channel.
fn taken(run: &Run<'_, '_>, faults: &[(u8, i16)]) -> Option<String> {
    let (progress, report) = (run.progress, run.report);
    let lost = faults.iter().filter(|(channel, _)| progress.darkened() >> channel & 1 == 1);
    let (overran, other): (Vec<_>, Vec<_>) = lost.partition(|(_, cause)| *cause == laser_fault::OVERRUN);
    if let Some((channel, cause)) = other.first() {
        let cause = match cause {
            0 => "a fault, which was cleared since",
            cause => laser_cause(*cause),
        };
        return Some(format!(
            "{}: {cause}: laser {channel} was kept dark, and light that the job asks for is missing",
            run.source.name
        ));
    }
    let dark: Vec<String> = overran.iter().map(|(channel, _)| channel.to_string()).collect();
    let place = |entry: Option<u32>| entry.map_or(String::new(), |entry| format!(" after {}", report.location(entry)));
    // One at the end, which is dark anyway, takes nothing.
    let during = progress.overran.is_some_and(|entry| report.is_scripted(entry));
    if !dark.is_empty() && during {
        return Some(format!(
            "{}: a servo tick took too long{}, and laser {} was kept dark: what was to be lit from there on was not. \
             A longer tick (--tick-us), or fewer calls at one instant, helps.",
            run.source.name,
            place(progress.overran),
            dark.join(", ")
        ));
    }
    (progress.is_light_late() && run.source.job.lasers != 0).then(|| {
        let first = progress
            .first_late
            .map_or(String::new(), |entry| format!(", the first late entry is {}", report.location(entry)));
        format!("{}: a laser command came late{first}: light was not where it was asked for", run.source.name)
    })
}

/// Whether a coordinate system has been taken its axes, by a Reset or by another one.
fn is_without_axes(error: &Error) -> bool {
    error.refusal.as_ref().and_then(Refusal::reason) == Some(Reason::CrdNotSet)
}

impl LaserFacts {
    /// Of a channel's state.
    pub fn of(channel: u8, state: &LaserState) -> LaserFacts {
        let (mode, unit) = match state.mode.get() {
            0 => ("duty", "%"),
            1 => ("frequency", "kHz"),
            2 => ("analog", "V"),
            _ => ("duty with the switch held", "%"),
        };
        LaserFacts {
            channel,
            name: None,
            mode,
            unit,
            light: state.light != 0,
            output: state.power.get(),
            light_ms: f64::from(state.on_time.get()) / 4.0,
            width_limited_now: state.held != 0,
            kept_dark: (state.fault.get() != 0).then(|| laser_cause(state.fault.get())),
            on_at_the_end: false,
            width_limited_times: 0,
        }
    }
}

/// What a person calls an axis.
pub fn name(axis: &Axis) -> String {
    named("axis", axis.core, axis.axis)
}

/// Segments done and left of a coordinate system.
fn path(state: &CrdState) -> [i64; 2] {
    let done = state.segments.iter().map(|count| i64::from(count.get())).sum();
    let left = state.remainder.iter().map(|count| i64::from(count.get())).sum();
    [done, left]
}

/// How a coordinate system came to standstill.
fn path_end(state: &CrdState) -> String {
    match (state.run, state.path_stop) {
        (0, path_stop::NEVER) => "never moved".to_owned(),
        (0, path_stop::COMPLETED) => "path completed".to_owned(),
        (0, path_stop::UNDERRUN) => "UNDERRUN: its entries ran out at speed".to_owned(),
        (0, _) => format!("{}; CrdStart continues", stop_summary(state.reason.get())),
        _ => "moving".to_owned(),
    }
}

/// The greatest speed along a path in the trace.
fn speed(recorded: Option<&Recorded>, crd: &Crd) -> Option<f64> {
    recorded.and_then(|recorded| {
        let here = |name: &trace::CrdName| (i16::from(name.core), i16::from(name.crd)) == (crd.core, crd.crd);
        recorded.speeds.get(recorded.header.crds.iter().position(here)?).copied()
    })
}

/// The greatest speed in the trace.
fn peak(recorded: Option<&Recorded>, axis: &Axis) -> Option<f64> {
    recorded.and_then(|recorded| {
        let here = |name: &trace::AxisName| (i16::from(name.core), i16::from(name.axis)) == (axis.core, axis.axis);
        recorded.peaks.get(recorded.header.axes.iter().position(here)?).copied()
    })
}

fn pt_text(state: u8) -> &'static str {
    match state {
        0 => "never started",
        pt_state::RUNNING => "running",
        pt_state::ENDED => "ran to its end",
        pt_state::UNDERRUN => "UNDERRUN: the data ran out at speed",
        _ => "ended by a Stop or a fault",
    }
}

/// How an axis came to standstill, by the script's end or by its reason; its latched status bits.
fn ended(report: &Report<'_, '_>, axis: &Axis, item: &AxisItem) -> (&'static str, Vec<&'static str>) {
    let word = item.status.get();
    let how = if report.left.contains(&(axis.core, axis.axis)) {
        "still moved when the script ended: stopped smoothly"
    } else if word & RUNNING != 0 {
        "moving"
    } else {
        stop_summary(item.reason.get())
    };
    (how, status::faults(word).collect())
}

impl LinkFacts {
    /// Messages, what was sent again, what was refused.
    fn of(counters: &LinkCounters) -> LinkFacts {
        let damaged = [
            counters.deframe.too_long,
            counters.deframe.truncated,
            counters.short,
            counters.checksum,
            counters.version,
            counters.kind,
            counters.length,
        ];
        LinkFacts {
            sent: counters.sent,
            received: counters.received,
            sent_again: counters.timeouts.wrapping_add(counters.fast_retransmits),
            came_twice: counters.duplicates,
            damaged: damaged.iter().fold(0u32, |sum, count| sum.wrapping_add(*count)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn link_statistics_count_every_refusal_once() {
        let mut counters = LinkCounters {
            sent: 12,
            received: 11,
            timeouts: 2,
            fast_retransmits: 3,
            duplicates: 4,
            ..LinkCounters::default()
        };
        (counters.short, counters.checksum, counters.version, counters.kind, counters.length) =
            (1, 10, 100, 1000, 10_000);
        (counters.deframe.too_long, counters.deframe.truncated) = (100_000, 1_000_000);
        assert_eq!(
            LinkFacts::of(&counters).to_string(),
            "12 messages sent, 11 received; 5 sent again, 4 came twice, 1111111 damaged frames refused"
        );
    }
}
