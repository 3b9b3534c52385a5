//! `beamtick info`: what a controller is.
use crate::Failure;
use crate::command_line::Info;
use crate::connect::{linked, simulated};
use crate::profile;
use crate::summary::laser;
use protocol::command::{GetClock, GetFault, LaserStatus};

/// Prints version, board, profile, counts and limits.
pub fn show(arguments: &Info) -> Result<(), Failure> {
    let client = match &arguments.link {
        Some(link) => linked(link, &arguments.way, &arguments.settings, None)?,
        None => simulated(&arguments.settings, None)?,
    };
    let clock = client.call(GetClock {})?;
    let version = client.version();
    say!("controller  {} over {}", client.board(), client.name());
    say!("firmware    {}.{}.{}, schema {:#010x}", version.major, version.minor, version.patch, version.schema);
    say!("profile     {}, family {}", profile::shown(version), if version.family == 0 { "gus" } else { "lsr" });
    say!(
        "counts      {} core{} of {} axes and {} coordinate systems; {} lasers",
        version.cores,
        if version.cores == 1 { "" } else { "s" },
        version.axes_per_core,
        version.crds_per_core,
        version.lasers
    );
    say!("servo tick  {} us", version.tick_us);
    say!("clock       {} ms since power-on", clock.clock_ms);
    let (fault, text) = client.call_items(GetFault {}, &[])?;
    let text: Vec<u8> = text.iter().map(|byte| byte.value).collect();
    let text = String::from_utf8_lossy(&text);
    match fault.kind {
        0 => say!("last fault  none"),
        1 => say!("last fault  panic: {text}"),
        2 => say!("last fault  core fault: {text}"),
        3 => say!("last fault  interrupt that nobody serves: {text}"),
        _ => say!("last fault  watchdog: {text}"),
    }
    for channel in 0..version.lasers {
        let state = client.call(LaserStatus { core: 1.into(), channel: i16::from(channel).into() })?;
        say!("laser {channel}     {}", laser(&state));
    }
    say!("limits      travel ±2^40 pulses, velocity below 2^32 pulse/ms, PT FIFO 2 x 32 or 2 x 1024 segments");
    say!(
        "trace       {}",
        match client.trace_rate() {
            None => "has a stream of its own".to_owned(),
            Some(rate) => format!("goes over the link, which carries {rate} bytes a second beside calls"),
        }
    );
    Ok(())
}
