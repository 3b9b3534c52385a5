//! A port with a virtual controller, and a sender of its own.
#![allow(dead_code)]
use client::{Client, Family, Link, Options};
use grbl::{Pace, Port, Served};
use machine::Machine;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};
use virtual_board::{Board, Config, PacedLink, Shared, VirtualLink, share};

/// X and Y, 100 pulses a mm, 0 to 300 mm, a laser.
pub const MACHINE: &str = "
[axes.x]
number = 1
steps_per_mm = 100
travel = [0, 300]
max_rate = 12000
acceleration = 1000
[axes.y]
number = 2
steps_per_mm = 100
invert = true
travel = [0, 300]
max_rate = 12000
acceleration = 1000
[laser]
channel = 0
mode = \"duty\"
carrier_khz = 10
power = [0, 80]
s_max = 1000
[outputs]
mist = 1
flood = 2
";

/// Whether a position is this one, as far as a report shows it: half a pulse, and half a µm.
pub fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 0.0051
}

/// How long anything may take here.
const WAIT_MAX: Duration = Duration::from_secs(60);

pub struct Rig {
    pub board: Shared,
    pub address: SocketAddr,
    client: Arc<Client>,
    ends: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<Result<Served, client::Error>>>,
}

impl Rig {
    /// Its time passes at ten times the wall clock's, so that a motion can be met in its middle.
    pub fn new(machine: &str, pass_stops: bool) -> Rig {
        let board = share(Board::new(Config::default()));
        let (link, _) = PacedLink::new(board.clone(), 10.0);
        Rig::with(Box::new(link), board, machine, pass_stops)
    }

    /// Its time passes as fast as it can.
    pub fn quick(machine: &str, pass_stops: bool) -> Rig {
        let board = share(Board::new(Config::default()));
        Rig::with(Box::new(VirtualLink::new(board.clone())), board, machine, pass_stops)
    }

    /// As [`Rig::new`], for a machine whose laser is chosen.
    pub fn of(machine: Machine) -> Rig {
        let board = share(Board::new(Config::default()));
        let (link, _) = PacedLink::new(board.clone(), 10.0);
        let client = Client::open(Box::new(link), Options { family: Some(Family::Gus), ..Options::default() }).unwrap();
        Rig::serving(board, client, machine, false, Pace::Virtual)
    }

    fn with(link: Box<dyn Link>, board: Shared, machine: &str, pass_stops: bool) -> Rig {
        let family = if machine.contains("family = \"lsr\"") { Family::Lsr } else { Family::Gus };
        let options = Options { family: Some(family), ..Options::default() };
        let client = Client::open(link, options).unwrap();
        Rig::over(board, client, machine, pass_stops, Pace::Virtual)
    }

    pub fn over(board: Shared, client: Client, machine: &str, pass_stops: bool, pace: Pace) -> Rig {
        Rig::serving(board, client, Machine::read("m.toml", machine).unwrap(), pass_stops, pace)
    }

    fn serving(board: Shared, client: Client, machine: Machine, pass_stops: bool, pace: Pace) -> Rig {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let ends = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&ends);
        let client = Arc::new(client);
        let theirs = Arc::clone(&client);
        let thread = std::thread::spawn(move || {
            let ends = || end.load(Ordering::SeqCst);
            grbl::serve(Port::Tcp(listener), theirs, &machine, pass_stops, pace, &ends)
        });
        Rig { board, address, client, ends, thread: Some(thread) }
    }

    pub fn sender(&self) -> Sender {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
        // The port is set up once it says something. A machine that holds this process up for long
        // is no link that is lost, where its time is ten times as fast.
        while stream.peek(&mut [0]).is_err() {}
        let long = protocol::command::SetLinkLoss { time_ms: 60_000.into(), stop_all: 0.into() };
        self.client.call(long).unwrap();
        Sender { stream, read: Vec::new(), dropped: Vec::new() }
    }

    /// Ends it: what it has done.
    pub fn end(mut self) -> Served {
        self.ends.store(true, Ordering::SeqCst);
        self.thread.take().unwrap().join().unwrap().unwrap()
    }

    /// The controller's time.
    pub fn now(&self) -> Duration {
        self.client.now()
    }

    /// Set-points of axes 1 and 2, in pulses.
    pub fn at(&self) -> [f64; 2] {
        let board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
        [0, 1].map(|axis| board.set_point(axis) as f64 / f64::from(1 << 22))
    }

    /// Set-points of all eight axes.
    pub fn at_all(&self) -> [f64; 8] {
        let board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
        std::array::from_fn(|axis| board.set_point(axis) as f64 / f64::from(1 << 22))
    }

    /// The laser's switch.
    pub fn lit(&self) -> bool {
        self.switches()[0]
    }

    /// The switches of both lasers.
    pub fn switches(&self) -> [bool; 2] {
        let mut board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
        [0, 1].map(|channel| board.laser(channel).switch)
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

pub struct Sender {
    pub stream: TcpStream,
    read: Vec<u8>,
    dropped: Vec<String>,
}

impl Sender {
    pub fn send(&mut self, bytes: impl AsRef<[u8]>) {
        self.stream.write_all(bytes.as_ref()).unwrap();
    }

    /// The next line, without its end.
    pub fn line(&mut self) -> String {
        let began = Instant::now();
        loop {
            if let Some(end) = self.read.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.read.drain(..=end).collect();
                return String::from_utf8(line).unwrap().trim().to_owned();
            }
            assert!(began.elapsed() < WAIT_MAX, "no answer; there is {:?}", self.read);
            let mut bytes = [0; 4096];
            match self.stream.read(&mut bytes) {
                Ok(0) => panic!("the port closed the connection"),
                Ok(count) => self.read.extend_from_slice(&bytes[..count]),
                Err(_) => {}
            }
        }
    }

    /// Lines up to the banner.
    pub fn banner(&mut self) -> Vec<String> {
        let mut lines = Vec::new();
        loop {
            let line = self.line();
            if line.starts_with("Grbl 1.1") {
                assert_eq!(line, "Grbl 1.1h ['$' for help]");
                return lines;
            }
            if !line.is_empty() {
                lines.push(line);
            }
        }
    }

    /// Lines up to `ok` or `error`, which is the last.
    pub fn answer(&mut self) -> Vec<String> {
        let mut lines = Vec::new();
        loop {
            let line = self.line();
            let last = line == "ok" || line.starts_with("error:");
            lines.push(line);
            if last {
                return lines;
            }
        }
    }

    /// A line, and its answer.
    pub fn ask(&mut self, line: &str) -> Vec<String> {
        self.send(format!("{line}\n"));
        self.answer()
    }

    /// A line that is `ok`.
    pub fn ok(&mut self, line: &str) -> Vec<String> {
        let mut lines = self.ask(line);
        assert_eq!(lines.pop().unwrap(), "ok", "{line}: {lines:?}");
        lines
    }

    /// A line that is refused, after a message that says why.
    pub fn error(&mut self, line: &str) -> u8 {
        let lines = self.ask(line);
        let [.., reason, last] = lines.as_slice() else { panic!("{line}: no reason: {lines:?}") };
        assert!(reason.starts_with("[MSG:"), "{line}: {lines:?}");
        last.strip_prefix("error:").unwrap_or_else(|| panic!("{line}: {lines:?}")).parse().unwrap()
    }

    /// What `?` answers; what comes before it is dropped.
    pub fn status(&mut self) -> Status {
        self.send("?");
        loop {
            let line = self.line();
            if let Some(text) = line.strip_prefix('<') {
                return Status::of(text.strip_suffix('>').unwrap());
            }
            self.dropped.push(line);
        }
    }

    /// Waits for a status.
    pub fn until(&mut self, fits: impl Fn(&Status) -> bool) -> Status {
        let began = Instant::now();
        loop {
            let status = self.status();
            if fits(&status) {
                return status;
            }
            assert!(began.elapsed() < WAIT_MAX, "{status:?} {:?}", self.dropped);
        }
    }

    /// Waits until it stands.
    pub fn idle(&mut self) -> Status {
        self.until(|status| status.state == "Idle")
    }
}

#[derive(Debug, Clone)]
pub struct Status {
    pub state: String,
    pub at: [f64; 3],
    pub fields: Vec<(String, String)>,
}

impl Status {
    fn of(text: &str) -> Status {
        let mut parts = text.split('|');
        let state = parts.next().unwrap().to_owned();
        let fields: Vec<(String, String)> =
            parts.map(|part| part.split_once(':').unwrap()).map(|(a, b)| (a.to_owned(), b.to_owned())).collect();
        let at = fields.iter().find(|(name, _)| name == "MPos" || name == "WPos").unwrap();
        let numbers: Vec<f64> = at.1.split(',').map(|number| number.parse().unwrap()).collect();
        Status { state, at: numbers.try_into().unwrap(), fields }
    }

    pub fn field(&self, name: &str) -> Option<&str> {
        self.fields.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
    }

    /// mm/min and S.
    pub fn speeds(&self) -> (f64, f64) {
        let (feed, power) = self.field("FS").unwrap().split_once(',').unwrap();
        (feed.parse().unwrap(), power.parse().unwrap())
    }
}
