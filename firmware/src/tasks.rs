//! The tasks of the thread: one serves the link, one writes the log.
//!
//! In: wake signals, bytes of the link. Out: bytes to the link and the trace, lines of the
//! log. Owns the dispatcher's server and the sending halves of the UARTs. Fails never: a UART that
//! is full holds back its own bytes only; the other stream and the commands continue.
use crate::fault::FaultReport;
use crate::statics::LINK_WAKE;
use crate::supervision;
use crate::wires::{Outflow, Wires};
use dispatcher::Server;
use hal::board::uart::Tx;
use hal::board::{AXES, NAME, resume_link};

/// Trace bytes sent before the link is served again.
const TRACE_AT_ONCE_BYTES: usize = 1024;

/// Buffer of the trace stream, which only one of the boards has.
const TRACE_BUFFER_BYTES: usize = if cfg!(feature = "stm32h743") { 0 } else { TRACE_AT_ONCE_BYTES };

/// Argument of the link task.
pub struct LinkParts {
    /// The dispatcher.
    pub server: &'static mut Server<'static, AXES>,
    /// Bytes from and to the host.
    pub wires: Wires,
    /// The trace, where it has a stream of its own.
    pub trace: Option<Tx>,
}

/// Serves the link and the trace.
#[embassy_executor::task]
pub async fn serve(parts: LinkParts) {
    let LinkParts { server, mut wires, mut trace } = parts;
    let mut rows = Outflow::<TRACE_BUFFER_BYTES>::new();
    let mut overruns = 0;
    loop {
        LINK_WAKE.wait().await;
        supervision::turn();
        let view = server.view();
        let now = view.now;
        if view.overruns != overruns {
            overruns = view.overruns;
            defmt::warn!("{=u32} ticks took longer than a period", overruns);
        }
        wires.receive(now, server);
        resume_link();
        server.poll(now);
        wires.send(server);
        if let Some(tx) = &mut trace
            && rows.pump(tx, TRACE_AT_ONCE_BYTES, |out| server.take_trace(out))
        {
            LINK_WAKE.raise();
        }
    }
}

/// Logs the board's name, then the report of the last run. By semihosting this stops the core while
/// the host writes: so only here, in a task, once a start.
#[embassy_executor::task]
pub async fn announce(last: Option<&'static FaultReport>) {
    defmt::info!("Beamtick on {=str}, {=usize} axes", NAME, AXES);
    if let Some(report) = last {
        defmt::error!("the last run ended: {=str}", report.text());
    }
}
