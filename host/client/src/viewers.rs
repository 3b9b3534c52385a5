//! Connections of viewers: read-only sessions over TCP.
//!
//! In: connections, and a function that answers a read. Out: answers. Owns the connections and a
//! [`Viewer`] each. A viewer reaches nothing but that function: whatever is no read is refused
//! before it.
//! Budget: [`VIEWERS`] sessions, so many reads in a turn as the owner says, [`PORTION_BYTES`] bytes
//! of each connection, and [`WAITING_BYTES`] bytes that wait for one that does not read. Fails:
//! never; a connection that breaks, falls silent or opens no session is closed.
use protocol::Ns;
use protocol::record::{JobState, ReplyWriter, RequestRecord};
use protocol::viewer::{Answered, Viewer};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Read-only sessions at once.
pub const VIEWERS: usize = 8;
/// Connections at once, with those that are turned away.
const CONNECTIONS: usize = 2 * VIEWERS;
/// A connection that has not opened a session within this time is closed.
const OPENING_TIMEOUT: Duration = Duration::from_secs(2);
/// So is one whose session is silent for so long.
const SILENT_NS: Ns = 2_000_000_000;
/// Bytes that one turn takes from a connection.
const PORTION_BYTES: usize = 1024;
/// Bytes of answers that wait for a connection at most.
const WAITING_BYTES: usize = 16 << 10;

/// See the module text.
pub struct Viewers {
    seats: Vec<Seat>,
    began: Instant,
}

struct Seat {
    stream: TcpStream,
    viewer: Box<Viewer>,
    since: Instant,
    waiting: Vec<u8>,
    /// It has one of the sessions: an open one, or one that is offered. Who is offered one may take
    /// it up at any time.
    holds: bool,
    /// Its session is open.
    open: bool,
}

impl Viewers {
    /// Nobody looks.
    pub fn new() -> Self {
        Viewers { seats: Vec::new(), began: Instant::now() }
    }

    /// Time by which the sessions live.
    pub fn now(&self) -> Ns {
        u64::try_from(self.began.elapsed().as_nanos()).unwrap_or(Ns::MAX)
    }

    /// Read-only sessions that are open.
    pub fn count(&self) -> usize {
        self.seats.iter().filter(|seat| seat.open).count()
    }

    /// Takes a connection, whose first bytes `viewer` may have.
    pub fn add(&mut self, stream: TcpStream, viewer: Box<Viewer>) {
        if stream.set_nonblocking(true).is_err() || stream.set_nodelay(true).is_err() {
            return;
        }
        if self.seats.len() >= CONNECTIONS {
            // There is one without a session.
            let Some(oldest) = self.seats.iter().position(|seat| !seat.holds) else { return };
            self.seats.remove(oldest);
        }
        self.seats.push(Seat { stream, viewer, since: Instant::now(), waiting: Vec::new(), holds: false, open: false });
    }

    /// Moves bytes, and answers at most `reads` reads.
    pub fn turn(&mut self, reads: usize, mut reply: impl FnMut(&RequestRecord<'_>, &mut ReplyWriter<'_>) -> Answered) {
        let now = self.now();
        let mut left = reads;
        let mut limited = |record: &RequestRecord<'_>, out: &mut ReplyWriter<'_>| {
            if left == 0 {
                return Answered::Later;
            }
            left -= 1;
            reply(record, out)
        };
        let mut held = self.seats.iter().filter(|seat| seat.holds).count();
        // Each has its turn to be the first.
        let count = self.seats.len();
        self.seats.rotate_left(count.min(1));
        self.seats.retain_mut(|seat| seat.turn(now, &mut held, &mut limited));
    }

    /// Says to each what job runs.
    pub fn show_job(&mut self, job: &JobState, name: &str) {
        // One that has not read the last one gets no more.
        for seat in self.seats.iter_mut().filter(|seat| seat.open && seat.viewer.is_idle()) {
            seat.viewer.show_job(job, name);
        }
    }
}

impl Default for Viewers {
    fn default() -> Self {
        Viewers::new()
    }
}

impl Seat {
    /// False once it is to be closed.
    fn turn(
        &mut self,
        now: Ns,
        held: &mut usize,
        reply: &mut impl FnMut(&RequestRecord<'_>, &mut ReplyWriter<'_>) -> Answered,
    ) -> bool {
        let mut bytes = [0; PORTION_BYTES];
        match self.stream.read(&mut bytes) {
            Ok(0) => return false,
            Ok(count) => self.viewer.feed(now, bytes.get(..count).unwrap_or_default()),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(_) => return false,
        }
        let wants = self.viewer.is_asked() || self.viewer.is_open();
        if self.holds && !wants {
            self.holds = false;
            *held -= 1;
        } else if !self.holds && wants && *held < VIEWERS {
            self.holds = true;
            *held += 1;
        }
        if wants && !self.holds {
            if self.viewer.is_open() {
                // Nothing was offered here: somebody guessed the session.
                return false;
            }
            self.viewer.turn_away();
        }
        self.open |= self.viewer.is_open();
        self.viewer.answer(reply);
        let lives = match self.open {
            true => self.viewer.silence(now).is_some_and(|silence| silence < SILENT_NS),
            false => self.since.elapsed() < OPENING_TIMEOUT,
        };
        lives && self.send(now)
    }

    fn send(&mut self, now: Ns) -> bool {
        let mut bytes = [0; 2048];
        while self.waiting.len() < WAITING_BYTES {
            match self.viewer.take_tx(now, &mut bytes) {
                0 => break,
                count => self.waiting.extend_from_slice(bytes.get(..count).unwrap_or_default()),
            }
        }
        while !self.waiting.is_empty() {
            match self.stream.write(&self.waiting) {
                Ok(count @ 1..) => drop(self.waiting.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return true,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Ok(_) | Err(_) => return false,
            }
        }
        true
    }
}
