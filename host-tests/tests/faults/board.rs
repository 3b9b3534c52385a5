//! A board in QEMU whose link outlives a client: sessions come and go over it, and may be cut.
use crate::debugger::Socket;
use client::link::Link;
use client::qemu::{Machine, QemuLink, Switchboard};
use client::{Client, Error, Options, Result, error};
use protocol::command::*;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// The image that BEAMTICK_IMAGE names (`cargo xtask check-all` does); without it the tests say
/// that they are skipped.
pub fn image() -> Option<PathBuf> {
    let image = std::env::var_os("BEAMTICK_IMAGE").map(PathBuf::from);
    if image.is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
    }
    image
}

pub struct Board {
    link: Arc<Mutex<QemuLink>>,
    /// Roads opened; only the newest leads to the board.
    clients: Arc<AtomicU32>,
    pub socket: Socket,
}

impl Board {
    /// Starts QEMU; `held`: the board is not powered before a debugger detaches.
    pub fn start(image: PathBuf, held: bool) -> Board {
        let socket = Socket::new();
        let mut machine = Machine::new(image);
        machine.extra = socket.arguments();
        if held {
            machine.extra.push("-S".into());
        }
        Board { link: Arc::new(Mutex::new(QemuLink::start(&machine).unwrap())), clients: Arc::default(), socket }
    }

    pub fn switchboard(&self) -> Switchboard {
        self.link.lock().unwrap().switchboard().unwrap()
    }

    pub fn client_link(&self) -> ClientLink {
        let number = self.clients.fetch_add(1, Ordering::Relaxed) + 1;
        let (link, clients) = (Arc::clone(&self.link), Arc::clone(&self.clients));
        ClientLink { link, clients, number, left: None, sent: Arc::default(), ahead: 0 }
    }

    pub fn open(&self) -> Client {
        self.open_over(self.client_link())
    }

    /// Patient with a host that is busy.
    pub fn open_over(&self, client_link: ClientLink) -> Client {
        let patient = Duration::from_secs(20);
        let options = Options { open_timeout: patient, timeout: patient, ..Options::default() };
        Client::open(Box::new(client_link), options).unwrap()
    }
}

/// The link of one client to the board.
pub struct ClientLink {
    link: Arc<Mutex<QemuLink>>,
    clients: Arc<AtomicU32>,
    number: u32,
    /// Bytes that still pass, then it is cut both ways; and whether it is cut at all.
    pub left: Option<Arc<Mutex<usize>>>,
    /// Bytes sent.
    pub sent: Arc<Mutex<Vec<u8>>>,
    /// After a cut nobody is waited for: the client's time runs ahead, ns.
    ahead: u64,
}

impl ClientLink {
    fn link(&self) -> Result<MutexGuard<'_, QemuLink>> {
        if self.clients.load(Ordering::Relaxed) != self.number {
            return Err(Error::new(error::LINK_SEND, "another client has the board"));
        }
        Ok(self.link.lock().unwrap())
    }
}

impl Link for ClientLink {
    fn name(&self) -> &str {
        "qemu"
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut passes = bytes.len();
        if let Some(left) = &self.left {
            let mut left = left.lock().unwrap();
            passes = passes.min(*left);
            *left -= passes;
        }
        self.sent.lock().unwrap().extend_from_slice(&bytes[..passes]);
        self.link()?.send(&bytes[..passes])
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> Result<usize> {
        if self.left.as_ref().is_some_and(|left| *left.lock().unwrap() == 0) {
            self.ahead += 1_000_000_000;
            return Ok(0);
        }
        self.link()?.receive(buf, wait)
    }

    fn now(&mut self) -> u64 {
        self.link.lock().unwrap().now() + self.ahead
    }

    /// A link that may be cut sends nothing by itself.
    fn real_time(&self) -> bool {
        self.left.is_none()
    }
}

/// Both channels shine, the second one in analog mode with the switch open.
pub fn shine(client: &Client) {
    let (core, channel) = (1.into(), 0.into());
    client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    client.call(LaserOutFrq { core, frequency: 20.0.into(), channel }).unwrap();
    client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    client.call(LaserOn { core, channel }).unwrap();
    let channel = 1.into();
    let (max, min) = (10.0.into(), 0.0.into());
    client.call(LaserPowerMode { core, mode: 2.into(), max, min, channel, delay_mode: 0.into() }).unwrap();
    client.call(LaserPrfCmd { core, power: 4.0.into(), channel }).unwrap();
    client.call(LaserOn { core, channel }).unwrap();
    wait_until("light on both channels", || state(client, 0).light == 1 && state(client, 1).light == 1);
}

pub fn state(client: &Client, channel: i16) -> LaserState {
    client.call(LaserStatus { core: 1.into(), channel: channel.into() }).unwrap()
}

pub fn fault(client: &Client, channel: i16) -> i16 {
    client.call(GetLaserFault { core: 1.into(), channel: channel.into() }).unwrap().value.get()
}

/// What ended the last run: the kind and the text.
pub fn reason(client: &Client) -> (u8, String) {
    let (reply, text) = client.call_items(GetFault {}, &[]).unwrap();
    (reply.kind, String::from_utf8_lossy(&text.iter().map(|byte| byte.value).collect::<Vec<_>>()).into_owned())
}

/// Both channels are dark for `cause` and stay so until they are cleared, each for itself; then
/// they shine again.
pub fn assert_dark_until_cleared(client: &Client, cause: i16) {
    for channel in 0..2 {
        let now = state(client, channel);
        assert_eq!((now.fault.get(), now.light, now.gate, now.power.get()), (cause, 0, 0, 0.0), "channel {channel}");
        assert!(client.call(LaserOn { core: 1.into(), channel: channel.into() }).is_err(), "an on command is refused");
        client.call(ClrLaserFault { core: 1.into(), channel: channel.into() }).unwrap();
        wait_until("the fault is over", || fault(client, channel) == 0);
        assert_eq!(state(client, channel).light, 0, "light does not come back by itself");
    }
    shine(client);
}

/// Asks until it is so, for at most twenty seconds.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < Duration::from_secs(20), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
