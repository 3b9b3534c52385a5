//! `beamtick info`: what a controller is.
//!
//! In: a link. Out: [`Facts`], as text or as JSON (docs/json.md). Owns nothing. Fails where the
//! controller does not answer.
use crate::command_line::{Info, Steps};
use crate::connect::{linked, named, simulated};
use crate::summary::LaserFacts;
use crate::summary::counted;
use crate::{Failure, json, profile};
use client::Client;
use protocol::command::{
    EventItem, GetClock, GetEvents, GetFault, GetLinkLoss, GetStack, GetTickTime, LaserStatus, LinkLossReply,
    StackReply, TickTimeReply,
};
use protocol::reason::{laser_cause, stop_reason};
use protocol::values::{FULL_SCALE, event};
use serde::Serialize;
use std::fmt;

/// What a controller is.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Facts {
    board: String,
    link: String,
    /// Major, minor and patch of the firmware.
    firmware: [u16; 3],
    /// Of the protocol.
    schema_hash: u32,
    profile: String,
    /// `gus` or `lsr`.
    family: &'static str,
    cores: u8,
    axes_of_a_core: u8,
    coordinate_systems_of_a_core: u8,
    laser_channels: u8,
    general_inputs: u8,
    general_outputs: u8,
    servo_tick: TickFacts,
    /// None where that is not measured.
    stack: Option<StackFacts>,
    clock_ms: f64,
    link_loss: LossFacts,
    /// The fault of the last run, or why there is no light.
    fault: Option<FaultFacts>,
    lasers: Vec<LaserFacts>,
    /// Events since power-on.
    event_count: u32,
    /// The last of them.
    events: Vec<EventFacts>,
    /// Fastest step output, pulse/ms; none is full scale, 2³² pulse/ms.
    step_limit: Option<f64>,
    /// Bytes a second that the link carries of a trace; none where it has a stream of its own.
    trace_bytes_a_second: Option<u32>,
}

/// The servo tick, µs.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct TickFacts {
    period_us: f64,
    /// What ticks take; none where that is not measured.
    median_us: Option<f64>,
    worst_us: Option<f64>,
}

/// The firmware's stack, bytes.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct StackFacts {
    size: u32,
    /// Never used since the start.
    unused: u32,
}

/// When the link counts as lost.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct LossFacts {
    /// ms of silence; 0 never.
    after_ms: f64,
    stops_all_motion: bool,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FaultFacts {
    /// `panic`, `core fault`, `interrupt without a handler`, `watchdog` or `no light`.
    kind: &'static str,
    text: String,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct EventFacts {
    time_ms: f64,
    text: String,
}

impl TickFacts {
    fn of(reply: &TickTimeReply) -> TickFacts {
        let us = |ns: u32| f64::from(ns) / 1000.0;
        let measured = |ns: u32| (reply.measured != 0).then(|| us(ns));
        TickFacts {
            period_us: us(reply.period_ns.get()),
            median_us: measured(reply.median_ns.get()),
            worst_us: measured(reply.worst_ns.get()),
        }
    }
}

/// How long the period is, and how much of it ticks take.
impl fmt::Display for TickFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |us: f64| 100.0 * us / self.period_us.max(1e-3);
        match (self.median_us, self.worst_us) {
            (Some(median), Some(worst)) => write!(
                f,
                "{} us; ticks take {median:.2} us ({:.0} %) in the median, {worst:.2} us ({:.0} %) at most since the start",
                self.period_us,
                share(median),
                share(worst)
            ),
            _ => write!(f, "{} us; how long ticks take is not measured on this board", self.period_us),
        }
    }
}

impl StackFacts {
    fn of(reply: &StackReply) -> Option<StackFacts> {
        (reply.measured != 0).then(|| StackFacts { size: reply.size.get(), unused: reply.unused.get() })
    }
}

/// One line of the text.
fn stack_in_words(stack: Option<&StackFacts>) -> String {
    match stack {
        Some(StackFacts { size, unused }) => format!("{unused} of {size} bytes never used since the start"),
        None => "how much of it is used is not measured on this board".to_owned(),
    }
}

impl LossFacts {
    fn of(reply: &LinkLossReply) -> LossFacts {
        LossFacts { after_ms: reply.time_ms.get(), stops_all_motion: reply.stop_all.get() != 0 }
    }
}

impl fmt::Display for LossFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let motion = if self.stops_all_motion { "all motion stops" } else { "Jog axes and coordinate systems stop" };
        match self.after_ms {
            0.0 => write!(f, "OFF: a lost link shuts off no laser and stops nothing (SetLinkLoss)"),
            time => write!(f, "after {time} ms of silence lasers are shut off, {motion}"),
        }
    }
}

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [major, minor, patch] = self.firmware;
        writeln!(f, "controller  {} over {}", self.board, self.link)?;
        writeln!(f, "firmware    {major}.{minor}.{patch}, schema {:#010x}", self.schema_hash)?;
        writeln!(f, "profile     {}, family {}", self.profile, self.family)?;
        writeln!(
            f,
            "counts      {} core{} of {} axes and {} coordinate systems; {} lasers; {} general inputs and {} outputs",
            self.cores,
            if self.cores == 1 { "" } else { "s" },
            self.axes_of_a_core,
            self.coordinate_systems_of_a_core,
            self.laser_channels,
            self.general_inputs,
            self.general_outputs
        )?;
        writeln!(f, "servo tick  {}", self.servo_tick)?;
        writeln!(f, "stack       {}", stack_in_words(self.stack.as_ref()))?;
        writeln!(f, "clock       {} ms since power-on", self.clock_ms)?;
        writeln!(f, "link loss   {}", self.link_loss)?;
        match &self.fault {
            None => writeln!(f, "last fault  none")?,
            Some(fault) if fault.kind == "no light" => writeln!(f, "no light    {}", fault.text)?,
            Some(fault) => writeln!(f, "last fault  {}: {}", fault.kind, fault.text)?,
        }
        for laser in &self.lasers {
            writeln!(f, "laser {}     {laser}", laser.channel)?;
        }
        match (self.event_count, self.events.len()) {
            (0, _) => writeln!(f, "events      none")?,
            (total, shown) => writeln!(f, "events      {total} since power-on, the last {shown}:")?,
        }
        for item in &self.events {
            writeln!(f, "  {:>12.3} ms  {}", item.time_ms, item.text)?;
        }
        let steps = self.step_limit.map_or("2^32 pulse/ms".to_owned(), |limit| format!("{limit} pulse/ms (steps)"));
        writeln!(f, "limits      travel ±2^40 pulses, velocity up to {steps}, PT FIFO 2 x 32 or 2 x 1024 segments")?;
        match self.trace_bytes_a_second {
            None => write!(f, "trace       has a stream of its own"),
            Some(rate) => {
                write!(f, "trace       goes over the link, which carries {rate} bytes a second beside calls")
            }
        }
    }
}

/// Prints version, board, profile, counts and limits.
pub fn show(arguments: &Info) -> Result<(), Failure> {
    let client = match &arguments.link {
        Some(link) if link != "virtual" => {
            linked(named(link, &arguments.link_options)?, &arguments.settings, None, None)?
        }
        _ => simulated(&arguments.settings, Steps::default(), None)?,
    };
    let facts = facts(&client)?;
    let text = facts.to_string();
    if !json::result(json::Facts::Info(Box::new(facts))) {
        say!("{text}");
    }
    Ok(())
}

fn facts(client: &Client) -> client::Result<Facts> {
    let clock = client.call(GetClock {})?;
    let version = client.version();
    let tick = client.call(GetTickTime {})?;
    let stack = client.call(GetStack {})?;
    let loss = client.call(GetLinkLoss {})?;
    let (fault, text) = client.call_items(GetFault {}, &[])?;
    let text: Vec<u8> = text.iter().map(|byte| byte.value).collect();
    let kind = match fault.kind {
        0 => None,
        1 => Some("panic"),
        2 => Some("core fault"),
        3 => Some("interrupt without a handler"),
        5 => Some("no light"),
        _ => Some("watchdog"),
    };
    let mut lasers = Vec::new();
    for channel in 0..version.lasers {
        let state = client.call(LaserStatus { core: 1.into(), channel: i16::from(channel).into() })?;
        lasers.push(LaserFacts::of(channel, &state));
    }
    let (events, items) = client.call_items(GetEvents {}, &[])?;
    let shown = items.iter().map(|item| EventFacts { time_ms: item.time_ns.get() as f64 / 1e6, text: event(item) });
    Ok(Facts {
        board: client.board(),
        link: client.name().to_owned(),
        firmware: [version.major, version.minor, version.patch].map(Into::into),
        schema_hash: version.schema.get(),
        profile: profile::shown(version).to_owned(),
        family: if version.family == 0 { "gus" } else { "lsr" },
        cores: version.cores,
        axes_of_a_core: version.axes_per_core,
        coordinate_systems_of_a_core: version.crds_per_core,
        laser_channels: version.lasers,
        general_inputs: version.general_inputs,
        general_outputs: version.general_outputs,
        servo_tick: TickFacts::of(&tick),
        stack: StackFacts::of(&stack),
        clock_ms: clock.clock_ms.get().into(),
        link_loss: LossFacts::of(&loss),
        fault: kind.map(|kind| FaultFacts { kind, text: String::from_utf8_lossy(&text).into_owned() }),
        lasers,
        event_count: events.total.get(),
        events: shown.collect(),
        step_limit: Some(version.step_limit.get()).filter(|limit| *limit < FULL_SCALE),
        trace_bytes_a_second: client.trace_rate(),
    })
}

/// What happened, to whom, why.
fn event(item: &EventItem) -> String {
    let (of, reason) = (item.of, item.reason.get());
    match (item.kind, reason) {
        (event::AXIS_STOPPED, _) => format!("axis {of} stopped: {}", stop_reason(reason)),
        (event::CRD_STOPPED, _) => format!("coordinate system {of} stopped: {}", stop_reason(reason)),
        (event::LASER, 0) => format!("laser {of} cleared"),
        (event::LASER, _) => format!("laser {of} dark: {}", laser_cause(reason as i16)),
        (event::LINK, 0) => "the host link is there again".to_owned(),
        (event::LINK, _) => "the host link was lost".to_owned(),
        (event::IGNORED, 1) => {
            format!("laser {of}: an entry of a path did nothing: SetLaserCrdMap excludes its coordinate system")
        }
        (event::IGNORED, 2) => format!("laser {of}: an on command did nothing: the channel has no output"),
        (event::IGNORED, 3) => format!("laser {of}: an on command did nothing: an abort was in progress"),
        (event::IGNORED, _) => format!("laser {of}: a command did nothing"),
        (event::LIMITED, 1) => {
            format!("laser {of}: its pulse width reached the period and was limited to just under it")
        }
        (event::LIMITED, _) => {
            format!("laser {of}: its pulse width reached the period and was limited to just under it, {reason} times")
        }
        (event::SHUT_OFF, 1) => "every laser shut off: an abort".to_owned(),
        (event::SHUT_OFF, 2) => "every laser shut off: a new session began".to_owned(),
        (event::OVERRUN, _) => format!("{} took longer than a period", counted(reason, "servo tick", "servo ticks")),
        _ => format!("{} lost", counted(reason, "event was", "events were")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_that_is_not_watched_is_named_loudly() {
        let text = |time: f64, stop: i16| {
            LossFacts::of(&LinkLossReply { time_ms: time.into(), stop_all: stop.into() }).to_string()
        };
        assert!(text(0.0, 0).starts_with("OFF: "));
        assert_eq!(text(500.0, 0), "after 500 ms of silence lasers are shut off, Jog axes and coordinate systems stop");
        assert_eq!(text(800.0, 1), "after 800 ms of silence lasers are shut off, all motion stops");
    }

    #[test]
    fn the_load_of_ticks_is_reported_in_time_and_percent() {
        let text = |measured| {
            let (period_ns, median_ns, worst_ns) = (50_000.into(), 5_250.into(), 12_500.into());
            TickFacts::of(&TickTimeReply { period_ns, median_ns, worst_ns, measured, ..Default::default() }).to_string()
        };
        assert_eq!(text(0), "50 us; how long ticks take is not measured on this board");
        assert_eq!(text(1), "50 us; ticks take 5.25 us (10 %) in the median, 12.50 us (25 %) at most since the start");
    }

    #[test]
    fn a_stack_is_reported_where_it_is_measured() {
        let text = |measured| {
            let reply = StackReply { size: 16_352.into(), unused: 1_920.into(), measured };
            stack_in_words(StackFacts::of(&reply).as_ref())
        };
        assert_eq!(text(0), "how much of it is used is not measured on this board");
        assert_eq!(text(1), "1920 of 16352 bytes never used since the start");
    }

    #[test]
    fn events_are_reported_in_words() {
        let text = |kind, of, reason: u16| event(&EventItem { time_ns: 0.into(), kind, of, reason: reason.into() });
        assert_eq!(text(1, 3, 10), "axis 3 stopped: an underrun");
        assert_eq!(text(3, 1, 3), format!("laser 1 dark: {}", laser_cause(3)));
        assert_eq!(text(3, 0, 0), "laser 0 cleared");
        assert_eq!(text(4, 0, 1), "the host link was lost");
        assert_eq!(text(8, 0, 1), "every laser shut off: an abort");
        assert!(
            text(9, 1, 1).ends_with("laser 1: its pulse width reached the period and was limited to just under it")
        );
        assert!(text(9, 0, 7).ends_with("just under it, 7 times"));
    }
}
