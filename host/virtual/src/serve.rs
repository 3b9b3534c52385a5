//! The virtual controller in real time over TCP.
//!
//! In: a listener for the host link, and one for the trace stream if wanted. Out: a running
//! controller until [`Served`] is dropped. It serves one client at a time. A second client gets the
//! name of the first one, and gets the controller when that connection has gone or its session is
//! silent. Others may look meanwhile, in read-only sessions ([`client::viewers`]). A connection
//! without a session is closed after a while and delays nothing. Without a connection the
//! controller continues, as a board does. Fails: with the operating system's error,
//! when a listener cannot be used.
use crate::board::{Board, Config};
use crate::link::{Shared, share};
use client::viewers::Viewers;
use dispatcher::SecondaryTransport;
use protocol::frame::OPENING_WIRE;
use protocol::viewer::Viewer;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two looks at the sockets.
const POLL_PERIOD: Duration = Duration::from_micros(200);
/// Controller time that one pass catches up at most, when this process was delayed. Time beyond it
/// is dropped: the controller's clock then lags, which a client cannot tell from a slow board.
const CATCH_UP_MAX: Duration = Duration::from_millis(20);
/// Trace bytes that wait for their client at most; more are dropped, which the client sees as a
/// gap.
const TRACE_WAITING_BYTES: usize = 16 << 20;

/// A connection that has not opened a session within this time is closed.
const OPENING_TIMEOUT: Duration = Duration::from_secs(2);
/// Connections without a session at most; one more, and the oldest is closed.
const VISITORS: usize = 64;
/// Bytes that one pass takes from a connection, so that a flood delays no other connection.
const PORTION_BYTES: usize = 1 << 16;
/// Reads of viewers that one pass answers at most.
const READS_PER_PASS: usize = 32;
/// Bytes of answers that wait for one of them at most.
const WAITING_ANSWER_BYTES: usize = 1024;

/// A controller being served; it ends when this is dropped.
pub struct Served {
    address: SocketAddr,
    trace_address: Option<SocketAddr>,
    board: Shared,
    stop: Arc<AtomicBool>,
    worker: Option<JoinHandle<()>>,
}

impl Served {
    /// Where the host link is.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Where the trace stream is.
    pub fn trace_address(&self) -> Option<SocketAddr> {
        self.trace_address
    }

    /// The controller, to set inputs and read outputs. While it is locked its time is stopped.
    pub fn board(&self) -> &Shared {
        &self.board
    }

    /// Serves until the process ends.
    pub fn wait(mut self) {
        if let Some(worker) = self.worker.take() {
            let _ = worker.join();
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(worker) = self.worker.take() {
            let _ = worker.join();
        }
    }
}

/// Serves a virtual controller on `listener`, its trace stream on `trace`.
pub fn serve(listener: TcpListener, trace: Option<TcpListener>, config: Config) -> io::Result<Served> {
    serve_board(listener, trace, share(Board::new(config)))
}

/// The same for a controller that is there already; from now on its time is the wall clock's.
pub fn serve_board(listener: TcpListener, trace: Option<TcpListener>, board: Shared) -> io::Result<Served> {
    listener.set_nonblocking(true)?;
    if let Some(trace) = &trace {
        trace.set_nonblocking(true)?;
    }
    let address = listener.local_addr()?;
    let trace_address = trace.as_ref().map(TcpListener::local_addr).transpose()?;
    let stop = Arc::new(AtomicBool::new(false));
    let (theirs, ends) = (Arc::clone(&board), Arc::clone(&stop));
    let worker = std::thread::spawn(move || {
        let mut link = Wires::new(listener);
        let mut stream = trace.map(Port::new);
        let mut before = Instant::now();
        // Controller time that should have passed: the board moves in whole ticks, this does not.
        let mut due = theirs.lock().unwrap_or_else(PoisonError::into_inner).now();
        while !ends.load(Ordering::Relaxed) {
            let now = Instant::now();
            due += (now - before).min(CATCH_UP_MAX).as_nanos() as u64;
            before = now;
            turn(&theirs, due, &mut link, stream.as_mut());
            std::thread::sleep(POLL_PERIOD);
        }
    });
    Ok(Served { address, trace_address, board, stop, worker: Some(worker) })
}

/// Lets the controller go on to `due` and moves bytes.
fn turn(board: &Shared, due: u64, link: &mut Wires, stream: Option<&mut Port>) {
    let mut board = board.lock().unwrap_or_else(PoisonError::into_inner);
    link.receive(&mut board);
    while board.now() < due {
        let left = due - board.now();
        board.advance(left, &mut link.waiting);
    }
    board.take_tx(&mut link.waiting);
    link.send();
    link.viewers.turn(READS_PER_PASS, |record, out| board.answer_viewer(record, out));
    let mut trace = Vec::new();
    board.take_trace(&mut trace);
    if let Some(stream) = stream {
        stream.receive();
        if stream.waiting.len() < TRACE_WAITING_BYTES {
            stream.waiting.append(&mut trace);
        }
        stream.send();
    }
}

/// The connections of the host link: the one whose session is in force, and those that ask for one.
struct Wires {
    listener: TcpListener,
    link: Option<Connection>,
    waiting: Vec<u8>,
    visitors: Vec<Visitor>,
    viewers: Viewers,
}

/// A client's socket, and where the client is.
struct Connection {
    stream: TcpStream,
    peer: String,
}

/// A connection that has no session yet.
struct Visitor {
    connection: Connection,
    since: Instant,
    wire: SecondaryTransport,
    /// If it asks for a read-only session, it gets that one.
    viewer: Box<Viewer>,
    waiting: Vec<u8>,
}

impl Wires {
    fn new(listener: TcpListener) -> Self {
        Wires { listener, link: None, waiting: Vec::new(), visitors: Vec::new(), viewers: Viewers::new() }
    }

    /// Accepts connections. Bytes of the link go to the board; those of other connections may open
    /// a session.
    fn receive(&mut self, board: &mut Board) {
        while let Ok((stream, peer)) = self.listener.accept() {
            if stream.set_nonblocking(true).is_err() || stream.set_nodelay(true).is_err() {
                continue;
            }
            if self.visitors.len() >= VISITORS {
                self.visitors.remove(0);
            }
            let connection = Connection { stream, peer: peer.to_string() };
            let (since, wire) = (Instant::now(), SecondaryTransport::new());
            let viewer = Box::new(Viewer::new());
            self.visitors.push(Visitor { connection, since, wire, viewer, waiting: Vec::new() });
        }
        let mut received = Vec::new();
        if let Some(link) = &mut self.link
            && !read(&mut link.stream, &mut received)
        {
            self.link = None;
        }
        if !received.is_empty() {
            board.feed(&received);
        }
        for mut visitor in std::mem::take(&mut self.visitors) {
            received.clear();
            let stays =
                read(&mut visitor.connection.stream, &mut received) && visitor.since.elapsed() < OPENING_TIMEOUT;
            visitor.viewer.feed(self.viewers.now(), &received);
            if visitor.viewer.is_asked() {
                self.viewers.add(visitor.connection.stream, visitor.viewer);
                continue;
            }
            let holder = self.link.as_ref().map(|link| link.peer.as_str());
            let (used, taken_up) = match received.is_empty() {
                true => (0, false),
                false => board.visit(&mut visitor.wire, holder, &received),
            };
            if taken_up {
                // Bytes for the client before are not for this one.
                self.waiting.clear();
                self.link = Some(visitor.connection);
                board.feed(&received[used..]);
            } else if stays {
                self.visitors.push(visitor);
            }
        }
    }

    /// Sends what waits, as far as the sockets take it; without a client it is dropped.
    fn send(&mut self) {
        if let Some(link) = &mut self.link
            && !write(&mut link.stream, &mut self.waiting)
        {
            self.link = None;
        }
        if self.link.is_none() {
            self.waiting.clear();
        }
        self.visitors.retain_mut(|visitor| {
            let mut answer = [0; OPENING_WIRE + 1];
            let count = visitor.wire.take_tx(&mut answer);
            visitor.waiting.extend_from_slice(&answer[..count]);
            // Who does not read is not written to for ever.
            visitor.waiting.len() <= WAITING_ANSWER_BYTES && write(&mut visitor.connection.stream, &mut visitor.waiting)
        });
    }
}

/// Reads what is there, as much as one turn takes; false once nothing more will come.
fn read(stream: &mut TcpStream, all: &mut Vec<u8>) -> bool {
    let mut part = [0; 4096];
    while all.len() < PORTION_BYTES {
        match stream.read(&mut part) {
            Ok(n @ 1..) => all.extend_from_slice(&part[..n]),
            Err(e) if e.kind() == ErrorKind::WouldBlock => return true,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => return false,
        }
    }
    true
}

/// Writes what the socket takes; false once it takes nothing more.
fn write(stream: &mut TcpStream, waiting: &mut Vec<u8>) -> bool {
    while !waiting.is_empty() {
        match stream.write(waiting) {
            Ok(n @ 1..) => {
                waiting.drain(..n);
            }
            Err(e) if e.kind() == ErrorKind::WouldBlock => return true,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Ok(_) | Err(_) => return false,
        }
    }
    true
}

/// The trace's listener and the one client connected to it.
struct Port {
    listener: TcpListener,
    client: Option<TcpStream>,
    waiting: Vec<u8>,
}

impl Port {
    fn new(listener: TcpListener) -> Self {
        Port { listener, client: None, waiting: Vec::new() }
    }

    /// Accepts a client if there is none; what it sends is passed over.
    fn receive(&mut self) {
        if self.client.is_none()
            && let Ok((stream, _)) = self.listener.accept()
            && stream.set_nonblocking(true).is_ok()
            && stream.set_nodelay(true).is_ok()
        {
            // Bytes for the client before are not for this one.
            self.waiting.clear();
            self.client = Some(stream);
        }
        if self.client.as_mut().is_some_and(|client| !read(client, &mut Vec::new())) {
            self.client = None;
        }
    }

    /// Sends what waits, as far as the socket takes it; without a client it is dropped.
    fn send(&mut self) {
        if self.client.as_mut().is_some_and(|client| !write(client, &mut self.waiting)) {
            self.client = None;
        }
        if self.client.is_none() {
            self.waiting.clear();
        }
    }
}
