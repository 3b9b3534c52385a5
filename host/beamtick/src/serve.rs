//! `beamtick serve`: the virtual controller in real time, for other clients.
use crate::Failure;
use crate::command_line::Serve;
use crate::connect;
use crate::profile;
use client::Profile;
use std::net::TcpListener;

/// Serves until the process is ended.
pub fn serve(arguments: &Serve) -> Result<(), Failure> {
    let shown = match &arguments.profile {
        Some(name) => profile::named(name)?,
        // A board with room for every profile: clients choose.
        None => Profile::Gsn048,
    };
    let config = connect::config(arguments.tick_us, shown, arguments.steps);
    let failed = |error| Failure::Job(format!("{}: cannot listen there: {error}", arguments.listen));
    let listener = TcpListener::bind(&arguments.listen).map_err(failed)?;
    let served = virtual_board::serve(listener, None, config).map_err(failed)?;
    say!(
        "virtual controller at tcp:{}, profile {}, servo tick {} us; one client at a time; Ctrl-C ends it",
        served.address(),
        shown.name(),
        config.tick_us
    );
    if !served.address().ip().is_loopback() {
        complain!("WARNING: there is no authentication: whoever reaches tcp:{} commands the machine", served.address());
    }
    served.wait();
    Ok(())
}
