//! `beamtick info`: what a controller is.
use crate::Failure;
use crate::command_line::Info;
use crate::connect::{linked, simulated};
use client::Profile;
use protocol::command::GetClock;

/// Prints version, board, profile, counts and limits.
pub fn show(arguments: &Info) -> Result<(), Failure> {
    let client = match &arguments.link {
        Some(link) => linked(link, &arguments.way, &arguments.settings)?,
        None => simulated(&arguments.settings)?.0,
    };
    let clock = client.call(GetClock {})?;
    let version = client.version();
    let profile = Profile::ALL.iter().find(|(profile, _)| *profile as u8 == version.profile).map_or("unknown", |(_, name)| name);
    println!("controller  {} over {}", client.board(), client.name());
    println!("firmware    {}.{}.{}, schema {:#010x}", version.major, version.minor, version.patch, version.schema);
    println!("profile     {profile}, family {}", if version.family == 0 { "gus" } else { "lsr" });
    println!(
        "counts      {} core{} of {} axes and {} coordinate systems; {} lasers",
        version.cores,
        if version.cores == 1 { "" } else { "s" },
        version.axes_per_core,
        version.crds_per_core,
        version.lasers
    );
    println!("servo tick  {} us", version.tick_us);
    println!("clock       {} ms since power-on", clock.clock_ms);
    println!("limits      travel ±2^40 pulses, velocity below 2^32 pulse/ms, PT FIFO 2 x 32 or 2 x 1024 segments");
    println!("trace       {}", if client.has_trace() { "carried by this link" } else { "not carried by this link" });
    Ok(())
}
