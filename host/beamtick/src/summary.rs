//! The summary: what a job has done, where its axes are and why they stopped, what the link
//! carried.
use crate::Failure;
use crate::entries::lasers;
use crate::profile;
use crate::record::Recorded;
use crate::report::Report;
use crate::runner::{place, states};
use crate::source::Source;
use client::{Client, Error, LinkCounters, Progress, laser_cause};
use job::{Axis, Crd};
use protocol::command::{AxisItem, CrdInfo, CrdState, EventItem, GetEvents, GetPtState, LaserState, LaserStatus};
use protocol::reason::{Reason, Refusal};
use protocol::values::status::RUNNING;
use protocol::values::{event, mode, pt_state};
use std::time::Duration;
use trace::Millimetres;

/// A job that has run.
pub struct Run<'a> {
    /// The script.
    pub source: &'a Source,
    /// The controller.
    pub client: &'a Client,
    /// What was observed during the job.
    pub report: &'a Report<'a>,
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

/// Prints it.
pub fn print(run: &Run<'_>) -> Result<(), Failure> {
    let (client, progress) = (run.client, run.progress);
    let version = client.version();
    let clock = progress.clock().as_secs_f64();
    say!(
        "{}: done on {}, profile {}, servo tick {} us",
        run.source.name,
        client.board(),
        profile::shown(version),
        version.tick_us
    );
    say!("  script clock {:.3} ms, {} entries", clock * 1e3, progress.queue.executed);
    if let Some(took) = run.took {
        let seconds = took.as_secs_f64().max(1e-9);
        say!("  simulated in {seconds:.3} s: {:.0} x real time", clock / seconds);
    }
    let at =
        |entry: Option<u32>, of: &str| entry.map_or(String::new(), |entry| format!("{of} {}", run.report.place(entry)));
    match progress.queue.late.get() {
        0 => say!("  no late entries"),
        late => say!(
            "  {late} late entries, the worst by {} us{}: they acted at once (--strict stops instead)",
            progress.queue.worst_late_us,
            at(progress.first_late, ", the first one is")
        ),
    }
    match progress.queue.overruns.get() {
        0 => {}
        overruns => say!(
            "  OVERRUN: {overruns} servo ticks took longer than {} us{}",
            version.tick_us,
            at(progress.overran, ", the first one after")
        ),
    }
    if run.report.warned > 0 {
        say!("  {} calls failed and were passed over (#pragma continue)", run.report.warned);
    }
    for (axis, item) in states(client, &run.source.job)? {
        let peak = peak(run.recorded, &axis);
        let is_it = |mm: &&Millimetres| (i16::from(mm.axis.core), i16::from(mm.axis.axis)) == (axis.core, axis.axis);
        let millimetres = run.source.millimetres.iter().find(is_it).map_or(String::new(), |mm| {
            let place = mm.zero + item.prf_pos.get() / mm.per_mm;
            // Without the sign of what is rounded to 0.
            format!(", {} {:.3} mm", mm.letter, (place * 1000.0).round() / 1000.0 + 0.0)
        });
        say!(
            "  {}: planned {:.6}, encoder {:.6} pulses{millimetres}{peak}; {}",
            name(&axis),
            item.prf_pos.get(),
            item.enc_pos.get(),
            ended(run.report, &axis, &item)
        );
        if item.mode.get() == mode::PT {
            let state = client.call(GetPtState { core: axis.core.into(), profile: axis.axis.into() })?;
            say!("    PT: {}, {} passes, {} slots free", pt_text(state.state), state.loops, state.space0);
        }
    }
    for crd in &run.source.job.crds {
        if place(crd.core, crd.crd, version.cores, version.crds_per_core).is_none() {
            continue;
        }
        let speed = speed(run.recorded, crd);
        match client.call(CrdInfo { core: crd.core.into(), crd: crd.crd.into() }) {
            Ok(state) => say!("  {}: {}{speed}; {}", crd_name(crd), path(&state), path_end(&state)),
            Err(error) if is_without_axes(&error) => say!("  {}: drives no axis any more{speed}", crd_name(crd)),
            Err(error) => return Err(error.into()),
        }
    }
    let mut faults = Vec::new();
    for channel in lasers(&run.source.job, version) {
        let state = client.call(LaserStatus { core: 1.into(), channel: i16::from(channel).into() })?;
        let end = if run.report.lit.contains(&channel) { "; was on when the script ended: shut off" } else { "" };
        say!("  laser {channel}: {}{end}", laser(&state));
        faults.push((channel, state.fault.get()));
    }
    limited(run)?;
    for (dry, least) in &run.report.streams {
        let least = least.map_or(String::new(), |least| format!("; least seen {least} ms"));
        say!(
            "  PT data of {}: at the last data {} slots free, {} ms to dry{least}",
            name(&Axis { core: dry.core, axis: dry.axis }),
            dry.space,
            dry.dry_ms
        );
    }
    say!("  link: {}", link(&client.counters()));
    match run.recorded {
        Some(recorded) => {
            let every = recorded.header.every;
            let raised = if every > run.every { ", raised to what the link carries" } else { "" };
            say!(
                "  trace: {} rows, one every {every} tick{}{raised}",
                recorded.rows,
                if every == 1 { "" } else { "s" }
            );
        }
        None if !run.source.job.axes.is_empty() => {
            say!("  peak velocities are shown with --trace, --vcd, --plot or --xy")
        }
        None => {}
    }
    taken(run, &faults).map_or(Ok(()), |text| Err(Failure::Job(text)))
}

/// Where a rate that followed something reached the pulse width: how often, and when first after
/// power-on.
fn limited(run: &Run<'_>) -> Result<(), Failure> {
    if run.source.job.lasers == 0 {
        return Ok(());
    }
    let (head, items) = run.client.call_items(GetEvents {}, &[])?;
    let new = head.total.get().wrapping_sub(run.events) as usize;
    let new = &items[items.len().saturating_sub(new)..];
    for channel in lasers(&run.source.job, run.client.version()) {
        let of_it = |item: &&EventItem| (item.kind, item.of) == (event::LIMITED, channel);
        let times: u32 = new.iter().filter(of_it).map(|item| u32::from(item.reason.get())).sum();
        if times != 0 {
            say!(
                "  laser {channel}: WIDTH LIMITED {times} time{}: its rate followed to where the pulse width reaches the period; \
                 pulses there are just under the period",
                if times == 1 { "" } else { "s" }
            );
        }
    }
    Ok(())
}

/// The cause of a tick that took too long.
const OVERRUN: i16 = 3;

/// What took light from the job, if anything did. `faults` are the causes that keep its lasers dark
/// now, by channel.
fn taken(run: &Run<'_>, faults: &[(u8, i16)]) -> Option<String> {
    let (progress, report) = (run.progress, run.report);
    let lost = faults.iter().filter(|(channel, _)| progress.darkened() >> channel & 1 == 1);
    let (overran, other): (Vec<_>, Vec<_>) = lost.partition(|(_, cause)| *cause == OVERRUN);
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
    let place = |entry: Option<u32>| entry.map_or(String::new(), |entry| format!(" after {}", report.place(entry)));
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
            .map_or(String::new(), |entry| format!(", the first late entry is {}", report.place(entry)));
        format!("{}: a laser command came late{first}: light was not where it was asked for", run.source.name)
    })
}

/// Whether a coordinate system has been taken its axes, by a Reset or by another one.
fn is_without_axes(error: &Error) -> bool {
    error.refusal.as_ref().and_then(Refusal::reason) == Some(Reason::CrdNotSet)
}

/// A laser channel in a line: what it does now, how long it gave light, its fault.
pub fn laser(state: &LaserState) -> String {
    let (mode, unit) = match state.mode.get() {
        0 => ("duty", "%"),
        1 => ("frequency", "kHz"),
        2 => ("analog", "V"),
        _ => ("duty with the switch held", "%"),
    };
    let light = if state.light != 0 { "light on" } else { "dark" };
    let mut text = format!(
        "{mode} mode, {light}, output {} {unit}, light of {:.3} ms so far",
        state.power,
        f64::from(state.on_time.get()) / 4.0
    );
    if state.held != 0 {
        text.push_str(", pulse width limited to just under the period");
    }
    if state.fault.get() != 0 {
        text.push_str(&format!("; KEPT DARK: {} (ClrLaserFault)", laser_cause(state.fault.get())));
    }
    text
}

/// What a person calls an axis.
pub fn name(axis: &Axis) -> String {
    if axis.core == 1 { format!("axis {}", axis.axis) } else { format!("core {} axis {}", axis.core, axis.axis) }
}

/// What a person calls a coordinate system.
fn crd_name(crd: &Crd) -> String {
    if crd.core == 1 { format!("crd {}", crd.crd) } else { format!("core {} crd {}", crd.core, crd.crd) }
}

/// Segments done and left of a coordinate system.
fn path(state: &CrdState) -> String {
    let (done, left) = (state.segments, state.remainder);
    let done: i64 = done.iter().map(|count| i64::from(count.get())).sum();
    let left: i64 = left.iter().map(|count| i64::from(count.get())).sum();
    if left == 0 { format!("{done} segments") } else { format!("{done} segments, {left} left") }
}

/// How a coordinate system came to standstill.
fn path_end(state: &CrdState) -> String {
    match (state.run, state.path_stop) {
        (0, 0) => "never moved".to_owned(),
        (0, 1) => "its entries ran out".to_owned(),
        (0, 2) => "UNDERRUN: its entries ran out at speed".to_owned(),
        (0, _) => format!("{}; CrdStart continues", reason(state.reason.get())),
        _ => "moving".to_owned(),
    }
}

/// The greatest speed along a path in the trace.
fn speed(recorded: Option<&Recorded>, crd: &Crd) -> String {
    let speed = recorded.and_then(|recorded| {
        let here = |name: &trace::CrdName| (i16::from(name.core), i16::from(name.crd)) == (crd.core, crd.crd);
        recorded.speeds.get(recorded.header.crds.iter().position(here)?)
    });
    speed.map_or(String::new(), |speed| format!(", peak path speed {speed:.6} pulse/ms"))
}

/// The greatest speed in the trace.
fn peak(recorded: Option<&Recorded>, axis: &Axis) -> String {
    let peak = recorded.and_then(|recorded| {
        let here = |name: &trace::AxisName| (i16::from(name.core), i16::from(name.axis)) == (axis.core, axis.axis);
        recorded.peaks.get(recorded.header.axes.iter().position(here)?)
    });
    peak.map_or(String::new(), |peak| format!(", peak velocity {peak:.6} pulse/ms"))
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

/// Why an axis stopped last, by the numbers of `AxisStatus`.
fn reason(number: u16) -> &'static str {
    match number {
        0 => "never moved",
        1 => "motion completed",
        2 => "stopped smoothly by a Stop",
        3 => "stopped abruptly by a Stop",
        4 => "stopped by the positive limit input",
        5 => "stopped by the negative limit input",
        6 => "stopped at the positive software limit",
        7 => "stopped at the negative software limit",
        8 => "stopped by the drive alarm",
        9 => "stopped: following error beyond its limit",
        10 => "UNDERRUN: the data ran out at speed",
        11 => "stopped at the edge of travel, 2^40 pulses",
        12 => "servo switched off",
        13 => "stopped: the host link was lost",
        14 => "reset",
        15 => "stopped: an input that FollowDiBitEx waits for did not come in time",
        16 => "stopped: its master would have taken it beyond the step limit",
        17 => "stopped: another axis could not go along",
        18 => "stopped smoothly by an abort",
        19 => "stopped by the interlock or emergency-stop input",
        20 => "stopped: a new session began",
        _ => "stopped for a reason that this client does not know",
    }
}

/// How an axis came to standstill: by the script's end, by its reason; latched status bits are
/// named.
fn ended(report: &Report<'_>, axis: &Axis, item: &AxisItem) -> String {
    const BITS: [(u32, &str); 6] = [
        (1, "drive alarm"),
        (4, "following error"),
        (5, "positive limit"),
        (6, "negative limit"),
        (7, "smooth stop by input"),
        (8, "abrupt stop by input"),
    ];
    let status = item.status.get();
    let how = if report.left.contains(&(axis.core, axis.axis)) {
        "still moved when the script ended: stopped smoothly"
    } else if status & RUNNING != 0 {
        "moving"
    } else {
        reason(item.reason.get())
    };
    let latched: Vec<&str> = BITS.iter().filter(|(bit, _)| status >> bit & 1 == 1).map(|(_, text)| *text).collect();
    if latched.is_empty() { how.to_owned() } else { format!("{how} (latched: {})", latched.join(", ")) }
}

/// Messages, what was sent again, what was refused.
fn link(counters: &LinkCounters) -> String {
    let again = counters.timeouts.wrapping_add(counters.fast_retransmits);
    let refused = [
        counters.deframe.too_long,
        counters.deframe.truncated,
        counters.short,
        counters.checksum,
        counters.version,
        counters.kind,
        counters.length,
    ];
    let refused = refused.iter().fold(0u32, |sum, count| sum.wrapping_add(*count));
    format!(
        "{} messages sent, {} received; {again} sent again, {} came twice, {refused} damaged frames refused",
        counters.sent, counters.received, counters.duplicates
    )
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
            link(&counters),
            "12 messages sent, 11 received; 5 sent again, 4 came twice, 1111111 damaged frames refused"
        );
    }
}
