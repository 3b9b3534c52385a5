//! `beamtick info`: what a controller is.
use crate::Failure;
use crate::command_line::{Info, Steps};
use crate::connect::{linked, named, simulated};
use crate::profile;
use crate::summary::laser;
use protocol::command::{
    EventItem, GetClock, GetEvents, GetFault, GetLinkLoss, GetTickTime, LaserStatus, LinkLossReply, TickTimeReply,
};
use protocol::reason::{laser_cause, stop_reason};
use protocol::values::event;

/// Prints version, board, profile, counts and limits.
pub fn show(arguments: &Info) -> Result<(), Failure> {
    let client = match &arguments.link {
        Some(link) => linked(named(link, &arguments.way)?, &arguments.settings, None)?,
        None => simulated(&arguments.settings, Steps::default(), None)?,
    };
    let clock = client.call(GetClock {})?;
    let version = client.version();
    say!("controller  {} over {}", client.board(), client.name());
    say!("firmware    {}.{}.{}, schema {:#010x}", version.major, version.minor, version.patch, version.schema);
    say!("profile     {}, family {}", profile::shown(version), if version.family == 0 { "gus" } else { "lsr" });
    say!(
        "counts      {} core{} of {} axes and {} coordinate systems; {} lasers; {} general inputs and {} outputs",
        version.cores,
        if version.cores == 1 { "" } else { "s" },
        version.axes_per_core,
        version.crds_per_core,
        version.lasers,
        version.general_inputs,
        version.general_outputs
    );
    say!("servo tick  {}", tick_time(&client.call(GetTickTime {})?));
    say!("clock       {} ms since power-on", clock.clock_ms);
    say!("link loss   {}", link_loss(&client.call(GetLinkLoss {})?));
    let (fault, text) = client.call_items(GetFault {}, &[])?;
    let text: Vec<u8> = text.iter().map(|byte| byte.value).collect();
    let text = String::from_utf8_lossy(&text);
    match fault.kind {
        0 => say!("last fault  none"),
        1 => say!("last fault  panic: {text}"),
        2 => say!("last fault  core fault: {text}"),
        3 => say!("last fault  interrupt without a handler: {text}"),
        5 => say!("no light    {text}"),
        _ => say!("last fault  watchdog: {text}"),
    }
    for channel in 0..version.lasers {
        let state = client.call(LaserStatus { core: 1.into(), channel: i16::from(channel).into() })?;
        say!("laser {channel}     {}", laser(&state));
    }
    let (events, items) = client.call_items(GetEvents {}, &[])?;
    match (events.total.get(), items.len()) {
        (0, _) => say!("events      none"),
        (total, shown) => say!("events      {total} since power-on, the last {shown}:"),
    }
    for item in &items {
        say!("  {:>12.3} ms  {}", item.time_ns.get() as f64 / 1e6, event(item));
    }
    let steps = match version.step_limit.get() {
        limit if limit < 4294967296.0 => format!("{limit} pulse/ms (steps)"),
        _ => "2^32 pulse/ms".to_owned(),
    };
    say!("limits      travel ±2^40 pulses, velocity up to {steps}, PT FIFO 2 x 32 or 2 x 1024 segments");
    say!(
        "trace       {}",
        match client.trace_rate() {
            None => "has a stream of its own".to_owned(),
            Some(rate) => format!("goes over the link, which carries {rate} bytes a second beside calls"),
        }
    );
    Ok(())
}

/// How long the period is, and how much of it ticks take.
fn tick_time(reply: &TickTimeReply) -> String {
    let us = |ns: u32| f64::from(ns) / 1000.0;
    let period = reply.period_ns.get();
    let share = |ns: u32| 100.0 * f64::from(ns) / f64::from(period.max(1));
    let (median, worst) = (reply.median_ns.get(), reply.worst_ns.get());
    match reply.measured {
        0 => format!("{} us; how long ticks take is not measured on this board", us(period)),
        _ => format!(
            "{} us; ticks take {:.2} us ({:.0} %) in the median, {:.2} us ({:.0} %) at most since the start",
            us(period),
            us(median),
            share(median),
            us(worst),
            share(worst)
        ),
    }
}

/// When the link counts as lost, and what happens then.
fn link_loss(reply: &LinkLossReply) -> String {
    let motion = match reply.stop_all.get() {
        0 => "Jog axes and coordinate systems stop",
        _ => "all motion stops",
    };
    match reply.time_ms.get() {
        0.0 => "OFF: a lost link shuts off no laser and stops nothing (SetLinkLoss)".to_owned(),
        time => format!("after {time} ms of silence lasers are shut off, {motion}"),
    }
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
        (event::OVERRUN, _) => format!("{reason} servo ticks took longer than a period"),
        _ => format!("{reason} events were lost"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_that_is_not_watched_is_named_loudly() {
        let text = |time: f64, stop: i16| link_loss(&LinkLossReply { time_ms: time.into(), stop_all: stop.into() });
        assert!(text(0.0, 0).starts_with("OFF: "));
        assert_eq!(text(500.0, 0), "after 500 ms of silence lasers are shut off, Jog axes and coordinate systems stop");
        assert_eq!(text(800.0, 1), "after 800 ms of silence lasers are shut off, all motion stops");
    }

    #[test]
    fn the_load_of_ticks_is_reported_in_time_and_percent() {
        let text = |measured| {
            let (period_ns, median_ns, worst_ns) = (50_000.into(), 5_250.into(), 12_500.into());
            tick_time(&TickTimeReply { period_ns, median_ns, worst_ns, measured })
        };
        assert_eq!(text(0), "50 us; how long ticks take is not measured on this board");
        assert_eq!(text(1), "50 us; ticks take 5.25 us (10 %) in the median, 12.50 us (25 %) at most since the start");
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
