//! `beamtick grbl`: a Grbl 1.1 controller for senders, in front of a virtual controller or a board.
//!
//! In: a machine file, a link. Out: a port until a signal comes. Then everything is shut off and
//! comes to rest, as when a sender goes.
use crate::command_line::{FamilyName, Grbl, Settings};
use crate::interrupt::{self, Held};
use crate::share::{self, Share};
use crate::summary::counted;
use crate::{Failure, connect, machine_file};
use client::ProductProfile;
use grbl::{Pace, Port};
use machine::Family;
use std::net::TcpListener;
use std::sync::Arc;

/// Serves until a signal comes.
pub fn serve(arguments: &Grbl) -> Result<(), Failure> {
    let machine = machine_file::open(&arguments.machine, arguments.laser.as_deref())?;
    let name = arguments.link.as_deref().or(machine.link.as_deref()).unwrap_or("virtual");
    // Before anything is opened: a port that cannot be used is the command line's fault.
    let (port, place) = port(arguments)?;
    let shared = arguments.share.share.as_deref().map(share::listen).transpose()?;
    let (board, link) = match name {
        "virtual" => {
            let (board, link) = connect::real_time(arguments.tick_us, ProductProfile::Gus)?;
            (Some(board), link)
        }
        name => (None, connect::named(name, &arguments.link_options)?),
    };
    let family = match machine.family {
        Family::Gus => FamilyName::Gus,
        Family::Lsr => FamilyName::Lsr,
    };
    let settings = Settings { tick_us: arguments.tick_us, family: Some(family), profile: None };
    let client = Arc::new(connect::linked(link, &settings, Some(ProductProfile::Gus), None)?);
    let shared = shared.map(|listener| Share::start(listener, Arc::clone(&client))).transpose()?;
    let of = match &board {
        Some(board) => format!("the virtual controller at tcp:{}", board.address()),
        None => format!("the controller at {}", client.name()),
    };
    say!("Grbl 1.1 at {place}, in front of {of}; one sender at a time; Ctrl-C ends it");
    let held = Held::new();
    let ends = || interrupt::came().is_some();
    let done = grbl::serve(port, Arc::clone(&client), &machine, arguments.pass_stops, Pace::Real, &ends);
    drop(shared);
    // What a client has commanded ends with an Abort.
    drop(client);
    drop(board);
    drop(held);
    let served = done?;
    let text = format!("{} answered", counted(served.lines as i64, "line of senders was", "lines of senders were"));
    match interrupt::came() {
        Some(signal) => Err(Failure::Interrupted(signal, text)),
        None => {
            say!("{text}");
            Ok(())
        }
    }
}

/// The port, and what a sender opens.
fn port(arguments: &Grbl) -> Result<(Port, String), Failure> {
    if arguments.pty {
        #[cfg(unix)]
        return Ok(Port::pty()?);
        #[cfg(not(unix))]
        return Err(Failure::Input("--pty: this system has no pseudo-terminals; use --listen".to_owned()));
    }
    let failed = |error| Failure::Job(format!("{}: cannot listen there: {error}", arguments.listen));
    let listener = TcpListener::bind(&arguments.listen).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    if !address.ip().is_loopback() {
        complain!("WARNING: there is no authentication: whoever reaches tcp:{address} commands the machine");
    }
    Ok((Port::Tcp(listener), format!("tcp:{address}")))
}
