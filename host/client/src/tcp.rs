//! A link over TCP, to a served virtual controller or an emulated board.
use crate::error::{self, Error, Result};
use crate::link::Link;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// How long a connection may take.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// A TCP connection as a link.
pub struct TcpLink {
    name: String,
    stream: TcpStream,
    wait: Option<Duration>,
    since: Instant,
}

impl TcpLink {
    /// Connects to `host:port`.
    pub fn connect(address: &str) -> Result<Self> {
        let name = format!("tcp:{address}");
        let mut cause = String::from("the name has no address");
        for candidate in address.to_socket_addrs().map_err(|e| Error::cannot_open(&name, e))? {
            match TcpStream::connect_timeout(&candidate, CONNECT_TIMEOUT) {
                Ok(stream) => return Self::over(stream, name),
                Err(e) if e.kind() == ErrorKind::ConnectionRefused => {
                    cause = format!(
                        "{e}: nothing listens there. A virtual controller does once `beamtick serve --listen {address}` runs; without --listen \
                         it is at 127.0.0.1:5000"
                    );
                }
                Err(e) => cause = e.to_string(),
            }
        }
        Err(Error::cannot_open(&name, cause))
    }

    /// Takes an open connection.
    pub fn over(stream: TcpStream, name: String) -> Result<Self> {
        stream.set_nodelay(true).map_err(|e| Error::cannot_open(&name, e))?;
        Ok(TcpLink { name, stream, wait: None, since: Instant::now() })
    }
}

/// Reads once with a time limit; a zero limit means one that is as short as the system allows.
pub(crate) fn read_within(
    stream: &mut TcpStream,
    set: &mut Option<Duration>,
    buf: &mut [u8],
    wait: Duration,
    name: &str,
) -> Result<usize> {
    let wait = wait.max(Duration::from_micros(1));
    if *set != Some(wait) {
        stream.set_read_timeout(Some(wait)).map_err(|e| Error::new(error::LINK_RECEIVE, format!("{name}: {e}")))?;
        *set = Some(wait);
    }
    match stream.read(buf) {
        Ok(0) => Err(Error::new(error::LINK_CLOSED, format!("{name}: the other end closed the link"))),
        Ok(n) => Ok(n),
        Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) => Ok(0),
        Err(e) if matches!(e.kind(), ErrorKind::ConnectionReset | ErrorKind::BrokenPipe) => {
            Err(Error::new(error::LINK_CLOSED, format!("{name}: the other end closed the link ({e})")))
        }
        Err(e) => Err(Error::new(error::LINK_RECEIVE, format!("{name}: receiving failed: {e}"))),
    }
}

impl Link for TcpLink {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.stream
            .write_all(bytes)
            .map_err(|e| Error::new(error::LINK_SEND, format!("{}: sending failed: {e}", self.name)))
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> Result<usize> {
        read_within(&mut self.stream, &mut self.wait, buf, wait, &self.name)
    }

    fn now(&mut self) -> u64 {
        u64::try_from(self.since.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }
}
