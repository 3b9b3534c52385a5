//! Where senders connect: TCP, a pseudo-terminal, or from within the program.
//!
//! In: connections. Out: a session, one sender at a time; a second one is told so and closed. A
//! connection that ends, or takes no answers any more, is an abort. Fails: with the link's error.
use crate::entry::{self, Entry};
use crate::feeder::{Feed, Pace};
use crate::session::Session;
use client::{Call, Client, Error};
use gcode::Stream;
use machine::Machine;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::time::{Duration, Instant};

/// Longest wait for bytes while something else may come, and while nothing may.
const BUSY_READ_TIMEOUT: Duration = Duration::from_millis(1);
const IDLE_READ_TIMEOUT: Duration = Duration::from_millis(5);
/// A sender that takes no answers for so long has gone.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// What a second sender reads.
const BUSY: &[u8] = b"[MSG:Busy: another sender is connected]\r\n";
/// So many of them are waited for.
const MAX_REFUSED_SENDERS: usize = 16;
/// Time between two looks for another sender.
const SECOND_SENDER_POLL_PERIOD: Duration = Duration::from_millis(100);
/// Time between two looks for a first one.
const FIRST_SENDER_POLL_PERIOD: Duration = Duration::from_millis(20);

/// Where senders connect.
pub enum Port {
    /// A listener.
    Tcp(TcpListener),
    /// The master's end of a pseudo-terminal.
    #[cfg(unix)]
    Pty(Box<serialport::TTYPort>),
    /// A sender of this program: [`Port::local`].
    Local(Channel),
}

/// The port's end of a sender of this program.
pub struct Channel {
    received: Receiver<Vec<u8>>,
    answers: Sender<Vec<u8>>,
    /// Bytes that were received and not taken.
    rest: Vec<u8>,
}

/// A sender of this program. Dropping it is the end of its connection.
pub struct Local {
    sent: Sender<Vec<u8>>,
    answers: Receiver<Vec<u8>>,
}

impl Local {
    /// Sends bytes; false once the port is closed.
    pub fn send(&self, bytes: &[u8]) -> bool {
        self.sent.send(bytes.to_vec()).is_ok()
    }

    /// Answers that have come; none once the port is closed.
    pub fn answers(&self) -> Option<Vec<u8>> {
        let mut all = Vec::new();
        loop {
            match self.answers.try_recv() {
                Ok(mut bytes) => all.append(&mut bytes),
                Err(TryRecvError::Empty) => return Some(all),
                Err(TryRecvError::Disconnected) => return (!all.is_empty()).then_some(all),
            }
        }
    }
}

impl Port {
    /// A port for one sender of this program.
    pub fn local() -> (Port, Local) {
        let ((sent, received), (answering, answers)) = (channel(), channel());
        (Port::Local(Channel { received, answers: answering, rest: Vec::new() }), Local { sent, answers })
    }

    /// A new pseudo-terminal, and the name that a sender opens.
    ///
    /// # Errors
    /// The operating system has none.
    #[cfg(unix)]
    pub fn pty() -> Result<(Port, String), Error> {
        use serialport::SerialPort;
        let failed = |error: serialport::Error| Error::cannot_open("a pseudo-terminal", error);
        let (master, slave) = serialport::TTYPort::pair().map_err(failed)?;
        let name = slave.name().unwrap_or_default();
        // Its other end is closed here: then the master reports when a sender opens and closes it.
        Ok((Port::Pty(Box::new(master)), name))
    }
}

/// What a port has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Served {
    /// Lines that were answered.
    pub lines: u64,
    /// How often the path started from standstill.
    pub starts: u64,
}

/// Serves until `ends` says so. The client's session is set up here, and the axes stand at home.
///
/// # Errors
/// The machine file's, a call of the set-up that is refused, or the link's.
pub fn serve(
    port: Port,
    client: Arc<Client>,
    machine: &Machine,
    pass_stops: bool,
    pace: Pace,
    ends: &dyn Fn() -> bool,
) -> Result<Served, Error> {
    if client.version().family != machine.family as u8 {
        return Err(Error::new(7, "the controller was opened in another family than the machine file says"));
    }
    let mut stream = Stream::new(machine);
    let setup = entry::calls(&stream.setup()).map_err(|why| Error::new(1, why))?;
    let (path, setup): (Vec<Call>, Vec<Call>) =
        setup.into_iter().partition(|call| call.opcode == protocol::command::opcode::BufLaserFollowMode);
    for call in &setup {
        client.call_raw(call)?;
    }
    let axes: Vec<u8> = machine.axes.iter().map(|axis| axis.number).collect();
    let laser = machine.laser().map(|laser| laser.channel);
    let mut feed = Feed::new(client, &axes, laser, pace)?;
    let first = |call| Entry { call, kind: entry::Kind::Power, planned: 100, counts: true };
    feed.queue(path.into_iter().map(first).collect());
    while !feed.idle() {
        if let Some(error) = feed.view().failed {
            return Err(error);
        }
        feed.wait_for_change(IDLE_READ_TIMEOUT);
    }
    let mut session = Session::new(machine, stream, feed, pass_stops);
    let mut place = Listener::new(port)?;
    while let Some(mut wire) = place.next(ends)? {
        session.come()?;
        talk(&mut session, &mut wire, &mut place, ends)?;
        session.go()?;
        while session.settles() {
            session.turn()?;
            std::thread::sleep(BUSY_READ_TIMEOUT);
        }
        place.back(wire);
        if ends() {
            break;
        }
    }
    let (lines, starts) = session.counts();
    Ok(Served { lines, starts })
}

/// A sender, until it goes.
fn talk(
    session: &mut Session<'_>,
    wire: &mut Wire,
    place: &mut Listener,
    ends: &dyn Fn() -> bool,
) -> Result<(), Error> {
    let mut bytes = [0; 4096];
    let mut visits = Instant::now();
    loop {
        session.turn()?;
        let out = session.take_out();
        if !out.is_empty() && !wire.write(&out) {
            return Ok(());
        }
        if ends() {
            return Ok(());
        }
        if visits.elapsed() > SECOND_SENDER_POLL_PERIOD {
            visits = Instant::now();
            place.refuse();
        }
        if !session.takes() {
            std::thread::sleep(BUSY_READ_TIMEOUT);
            continue;
        }
        match wire.read(&mut bytes, if session.busy() { BUSY_READ_TIMEOUT } else { IDLE_READ_TIMEOUT }) {
            Some(0) => {}
            Some(count) => session.receive(bytes.get(..count).unwrap_or_default())?,
            None => return Ok(()),
        }
    }
}

/// Where senders come from.
enum Listener {
    /// With those that are told that they cannot come in, and since when.
    Tcp(TcpListener, Vec<(TcpStream, Instant)>),
    #[cfg(unix)]
    Pty(Option<Box<serialport::TTYPort>>),
    Local(Option<Channel>),
}

/// A sender's connection.
enum Wire {
    Tcp(TcpStream, Option<Duration>),
    #[cfg(unix)]
    Pty(Box<serialport::TTYPort>),
    Local(Channel),
}

fn is_wait(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

impl Listener {
    fn new(port: Port) -> Result<Listener, Error> {
        match port {
            Port::Tcp(listener) => {
                listener.set_nonblocking(true).map_err(|error| Error::cannot_open("the port", error))?;
                Ok(Listener::Tcp(listener, Vec::new()))
            }
            #[cfg(unix)]
            Port::Pty(master) => Ok(Listener::Pty(Some(master))),
            Port::Local(channel) => Ok(Listener::Local(Some(channel))),
        }
    }

    /// The next sender; none at the end.
    fn next(&mut self, ends: &dyn Fn() -> bool) -> Result<Option<Wire>, Error> {
        while !ends() {
            match self {
                Listener::Tcp(listener, _) => {
                    if let Ok((stream, _)) = listener.accept()
                        && stream.set_nonblocking(false).is_ok()
                        && stream.set_nodelay(true).is_ok()
                        && stream.set_write_timeout(Some(WRITE_TIMEOUT)).is_ok()
                    {
                        return Ok(Some(Wire::Tcp(stream, None)));
                    }
                }
                Listener::Local(channel) => {
                    if let Some(channel) = channel.take() {
                        return Ok(Some(Wire::Local(channel)));
                    }
                }
                #[cfg(unix)]
                Listener::Pty(kept) => {
                    if let Some(master) = kept.take() {
                        let mut wire = Wire::Pty(master);
                        // While nobody has the other end open, a read fails at once.
                        if wire.read(&mut [], BUSY_READ_TIMEOUT).is_some() {
                            return Ok(Some(wire));
                        }
                        self.back(wire);
                    }
                }
            }
            std::thread::sleep(FIRST_SENDER_POLL_PERIOD);
        }
        Ok(None)
    }

    /// A sender has gone.
    fn back(&mut self, wire: Wire) {
        match (self, wire) {
            #[cfg(unix)]
            (Listener::Pty(kept), Wire::Pty(master)) => *kept = Some(master),
            (_, _) => {}
        }
    }

    /// Others that come meanwhile are told so. What they send is taken until they have gone: a
    /// connection that is closed before would take the message with it.
    fn refuse(&mut self) {
        let Listener::Tcp(listener, refused) = self else { return };
        while let Ok((mut stream, _)) = listener.accept() {
            let told = stream.set_nonblocking(true).and_then(|()| stream.write_all(BUSY));
            if told.and_then(|()| stream.shutdown(Shutdown::Write)).is_ok() && refused.len() < MAX_REFUSED_SENDERS {
                refused.push((stream, Instant::now()));
            }
        }
        refused.retain_mut(|(stream, since)| {
            let mut sent = [0; 4096];
            let stays = match stream.read(&mut sent) {
                Ok(count) => count > 0,
                Err(error) => is_wait(&error),
            };
            stays && since.elapsed() < WRITE_TIMEOUT
        });
    }
}

impl Wire {
    /// Bytes that came, 0 for none yet; none where the sender has gone.
    fn read(&mut self, bytes: &mut [u8], wait: Duration) -> Option<usize> {
        match self {
            Wire::Tcp(stream, set) => {
                if *set != Some(wait) {
                    stream.set_read_timeout(Some(wait)).ok()?;
                    *set = Some(wait);
                }
                match stream.read(bytes) {
                    Ok(0) => None,
                    Ok(count) => Some(count),
                    Err(error) if is_wait(&error) => Some(0),
                    Err(_) => None,
                }
            }
            Wire::Local(channel) => {
                if channel.rest.is_empty() {
                    match channel.received.recv_timeout(wait) {
                        Ok(bytes) => channel.rest = bytes,
                        Err(RecvTimeoutError::Timeout) => return Some(0),
                        Err(RecvTimeoutError::Disconnected) => return None,
                    }
                }
                let count = channel.rest.len().min(bytes.len());
                let taken = channel.rest.drain(..count);
                bytes.iter_mut().zip(taken).for_each(|(slot, byte)| *slot = byte);
                Some(count)
            }
            #[cfg(unix)]
            Wire::Pty(master) => {
                use serialport::SerialPort;
                master.set_timeout(wait).ok()?;
                if bytes.is_empty() {
                    return master.bytes_to_read().ok().map(|_| 0);
                }
                match master.read(bytes) {
                    Ok(count) => Some(count),
                    Err(error) if is_wait(&error) => Some(0),
                    Err(_) => None,
                }
            }
        }
    }

    /// Whether the sender took it.
    fn write(&mut self, bytes: &[u8]) -> bool {
        match self {
            Wire::Tcp(stream, _) => stream.write_all(bytes).is_ok(),
            Wire::Local(channel) => channel.answers.send(bytes.to_vec()).is_ok(),
            #[cfg(unix)]
            Wire::Pty(master) => {
                use serialport::SerialPort;
                master.set_timeout(WRITE_TIMEOUT).is_ok() && master.write_all(bytes).is_ok()
            }
        }
    }
}
