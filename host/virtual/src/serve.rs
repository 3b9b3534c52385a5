//! The virtual controller in real time behind TCP.
//!
//! In: a listener for the host link, and one for the trace stream if wanted. Out: a running controller
//! until [`Served`] is dropped. One client at a time; the next one is accepted when it has gone. The
//! controller goes on while nobody is connected, as a board does.
use crate::board::{Board, Config};
use crate::link::{Shared, share};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two looks at the sockets.
const TURN: Duration = Duration::from_micros(200);
/// Controller time that is caught up in one turn at most, when this process was held up; what is
/// beyond is dropped: the controller's clock then lags, which a client cannot tell from a slow board.
const CATCH_UP: Duration = Duration::from_millis(20);
/// Trace bytes that wait for their client at most; more are dropped, which the client sees as a gap.
const TRACE_WAITING: usize = 16 << 20;

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

    /// The controller, to set inputs and look at outputs. While it is locked its time stands still.
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
    listener.set_nonblocking(true)?;
    if let Some(trace) = &trace {
        trace.set_nonblocking(true)?;
    }
    let address = listener.local_addr()?;
    let trace_address = trace.as_ref().map(TcpListener::local_addr).transpose()?;
    let board = share(Board::new(config));
    let stop = Arc::new(AtomicBool::new(false));
    let (theirs, ends) = (Arc::clone(&board), Arc::clone(&stop));
    let worker = std::thread::spawn(move || {
        let mut link = Port::new(listener);
        let mut stream = trace.map(Port::new);
        let mut before = Instant::now();
        // Controller time that should have passed: the board goes in whole ticks, this does not.
        let mut due = theirs.lock().unwrap_or_else(PoisonError::into_inner).now();
        while !ends.load(Ordering::Relaxed) {
            let now = Instant::now();
            due += (now - before).min(CATCH_UP).as_nanos() as u64;
            before = now;
            turn(&theirs, due, &mut link, stream.as_mut());
            std::thread::sleep(TURN);
        }
    });
    Ok(Served { address, trace_address, board, stop, worker: Some(worker) })
}

/// Lets the controller go on to `due` and moves bytes.
fn turn(board: &Shared, due: u64, link: &mut Port, stream: Option<&mut Port>) {
    let mut board = board.lock().unwrap_or_else(PoisonError::into_inner);
    let received = link.receive();
    if !received.is_empty() {
        board.feed(&received);
    }
    while board.now() < due {
        let left = due - board.now();
        board.advance(left, &mut link.waiting);
    }
    board.take_tx(&mut link.waiting);
    link.send();
    let mut trace = Vec::new();
    board.take_trace(&mut trace);
    if let Some(stream) = stream {
        stream.receive();
        if stream.waiting.len() < TRACE_WAITING {
            stream.waiting.append(&mut trace);
        }
        stream.send();
    }
}

/// A listener and the one client connected to it.
struct Port {
    listener: TcpListener,
    client: Option<TcpStream>,
    waiting: Vec<u8>,
}

impl Port {
    fn new(listener: TcpListener) -> Self {
        Port { listener, client: None, waiting: Vec::new() }
    }

    /// What came; accepts a client if there is none.
    fn receive(&mut self) -> Vec<u8> {
        if self.client.is_none()
            && let Ok((stream, _)) = self.listener.accept()
        {
            // Bytes for the client before are not for this one.
            self.waiting.clear();
            if stream.set_nonblocking(true).is_ok() && stream.set_nodelay(true).is_ok() {
                self.client = Some(stream);
            }
        }
        let mut all = Vec::new();
        let mut part = [0; 4096];
        while let Some(client) = &mut self.client {
            match client.read(&mut part) {
                Ok(n @ 1..) => all.extend_from_slice(&part[..n]),
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Ok(0) | Err(_) => self.client = None,
            }
        }
        all
    }

    /// Sends what waits, as far as the socket takes it; without a client it is dropped.
    fn send(&mut self) {
        while let Some(client) = &mut self.client
            && !self.waiting.is_empty()
        {
            match client.write(&self.waiting) {
                Ok(n @ 1..) => {
                    self.waiting.drain(..n);
                }
                Err(e) if e.kind() == ErrorKind::WouldBlock => return,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Ok(_) | Err(_) => self.client = None,
            }
        }
        if self.client.is_none() {
            self.waiting.clear();
        }
    }
}
