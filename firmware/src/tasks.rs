//! What the thread does: it serves the link, and it writes the log.
//!
//! In: rings of the bell, bytes of the link. Out: bytes to the link and the trace, lines of the log.
//! Owns the dispatcher's server and the sending halves of the UARTs. A UART that is full holds back
//! its own bytes only; the other stream and the commands go on.
use crate::fault::Report;
use crate::statics::{LINK_BELL, RECEIVED};
use crate::watch;
use dispatcher::Server;
use hal::board::uart::Tx;
use hal::board::{AXES, NAME, resume_link};
use ring::Consumer;

/// Trace bytes sent before the link is looked at again.
const TRACE_AT_ONCE: usize = 1024;

/// Bytes on their way out of a UART.
struct Outflow<const N: usize> {
    tx: Tx,
    bytes: [u8; N],
    from: usize,
    to: usize,
}

impl<const N: usize> Outflow<N> {
    fn new(tx: Tx) -> Self {
        Outflow { tx, bytes: [0; N], from: 0, to: 0 }
    }

    /// Sends what the UART takes, at most `limit` bytes; `more` refills. True if the limit ended it.
    fn pump(&mut self, limit: usize, mut more: impl FnMut(&mut [u8]) -> usize) -> bool {
        let mut left = limit;
        loop {
            if self.from >= self.to {
                self.from = 0;
                self.to = more(&mut self.bytes).min(N);
                if self.to == 0 {
                    return false;
                }
            }
            while let Some(&byte) = self.bytes.get(self.from..self.to).and_then(|rest| rest.first()) {
                if left == 0 {
                    return true;
                }
                if !self.tx.send(byte) {
                    return false;
                }
                self.from += 1;
                left -= 1;
            }
        }
    }
}

/// What the link task is given.
pub struct LinkParts {
    /// The dispatcher.
    pub server: &'static mut Server<'static, AXES>,
    /// Bytes received.
    pub bytes: Consumer<'static, u8, RECEIVED>,
    /// To the host.
    pub link: Tx,
    /// The trace, where it has a stream of its own.
    pub trace: Option<Tx>,
}

/// Serves the link and the trace.
#[embassy_executor::task]
pub async fn serve(parts: LinkParts) {
    let LinkParts { server, mut bytes, link, trace } = parts;
    let mut link = Outflow::<512>::new(link);
    let mut trace = trace.map(Outflow::<1024>::new);
    let mut overruns = 0;
    loop {
        LINK_BELL.wait().await;
        watch::turn();
        let view = server.view();
        let now = view.now;
        if view.overruns != overruns {
            overruns = view.overruns;
            defmt::warn!("{=u32} ticks took longer than a period", overruns);
        }
        loop {
            let mut chunk = [0; 256];
            let mut length = 0;
            while let Some(place) = chunk.get_mut(length) {
                let Some(byte) = bytes.pop() else { break };
                *place = byte;
                length += 1;
            }
            if length == 0 {
                break;
            }
            server.feed(now, chunk.get(..length).unwrap_or(&[]));
        }
        resume_link();
        server.poll(now);
        link.pump(usize::MAX, |out| server.take_tx(out));
        if let Some(trace) = &mut trace
            && trace.pump(TRACE_AT_ONCE, |out| server.take_trace(out))
        {
            LINK_BELL.ring();
        }
    }
}

/// Writes what the last run left, then the board's name. By semihosting it stops
/// the core while the host writes: only here, in a task, and seldom.
#[embassy_executor::task]
pub async fn announce(last: Option<&'static Report>) {
    defmt::info!("Beamtick on {=str}, {=usize} axes", NAME, AXES);
    if let Some(report) = last {
        defmt::error!("the last run ended: {=str}", report.text());
    }
}
