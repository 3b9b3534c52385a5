//! `beamtick serve`: the virtual controller in real time, for other clients.
use crate::command_line::Serve;
use crate::{Failure, connect, profile, runner};
use client::inputs::Zero;
use client::{Client, Options, ProductProfile};
use std::net::TcpListener;
use virtual_board::{Board, VirtualLink, share};

/// Serves until the process is ended.
pub fn serve(arguments: &Serve) -> Result<(), Failure> {
    let shown = match &arguments.profile {
        Some(name) => profile::named(name)?,
        // A board with room for every profile: clients choose.
        None => ProductProfile::Gsn048,
    };
    let config = connect::config(arguments.tick_us, shown, arguments.steps);
    let inputs = arguments.inputs.inputs.as_deref().map(runner::levels).transpose()?;
    let failed = |error| Failure::Job(format!("{}: cannot listen there: {error}", arguments.listen));
    let listener = TcpListener::bind(&arguments.listen).map_err(failed)?;
    let board = share(Board::new(config));
    if let Some(inputs) = &inputs {
        // A session before the first one: it has no connection, so no client has to wait for its
        // end.
        let client = Client::open(Box::new(VirtualLink::new(board.clone())), Options::default())?;
        inputs.plan(&client, Zero::Now).map_err(|error| Failure::Input(error.reason))?;
    }
    let served = virtual_board::serve_board(listener, None, board).map_err(failed)?;
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
