//! A small USB host at the board's cable: it finds a serial port of class CDC ACM, opens it and
//! moves bytes.
//!
//! In: the cable's state, bytes to send, requests of a test. Out: transactions with the core, one
//! after the other at full speed; bytes received, replies to requests. Owns what it has read from
//! the device's descriptors (USB 2.0 chapter 9). A transaction that is answered NAK is tried again.
//! A packet that is not full, or a full buffer, ends a read, as in drivers. Not modelled: frames of
//! the bus, errors on the cable.
use crate::time::{MICROSECOND, MILLISECOND, NEVER, Time};
use crate::usb::{Core, Handshake};
use std::collections::VecDeque;

/// A bit at 12 Mbit/s.
const BIT: Time = 80;
/// Bits around the data of a transaction: token, head and CRC of the packet, handshake, the gaps
/// between them.
const OVERHEAD: Time = 110;
/// A transaction that was answered NAK is tried again after this time.
const RETRY: Time = 40 * MICROSECOND;
/// Debounce, reset, recovery (USB 2.0 7.1.7.3 has 100, 10 and 10 ms; the first is cut short here).
const SETTLED: Time = 10 * MILLISECOND;
/// A bus on which nothing happens is suspended (USB 2.0 7.1.7.6).
const SUSPENDED: Time = 3 * MILLISECOND;
/// The address that the device is given.
const ADDRESS: u8 = 5;
/// A read of the driver's.
const READ: usize = 4096;
const PACKET: usize = 64;

/// A control transfer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transfer {
    /// bmRequestType, bRequest, wValue, wIndex, wLength.
    pub setup: [u8; 8],
    /// Data to send, or received.
    pub data: Vec<u8>,
    /// The device took it; else it answered STALL.
    pub is_done: bool,
}

impl Transfer {
    fn is_in(&self) -> bool {
        self.setup[0] & 0x80 != 0
    }

    fn length(&self) -> usize {
        u16::from_le_bytes([self.setup[6], self.setup[7]]).into()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// No cable.
    Out,
    /// Nobody pulls the line up.
    Waiting,
    Debouncing,
    Resetting,
    Recovering,
    Running,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Setup,
    /// Bytes that are through, and whether the next packet is DATA1.
    Data(usize),
    Status,
}

/// Where the port's bytes go, as its descriptors say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Pipes {
    to_device: usize,
    from_device: usize,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Host {
    phase: Phase,
    next: Time,
    suspends: Time,
    address: u8,
    /// How many requests of the enumeration have been made.
    asked: usize,
    current: Option<(Transfer, Stage)>,
    requests: VecDeque<Transfer>,
    pipes: Option<Pipes>,
    odd: [bool; 2],
    /// The last transaction was an IN.
    was_in: bool,
    sending: VecDeque<u8>,
    reading: Vec<u8>,
    /// Whether a program reads the port: if not, the device keeps its packet.
    pub reads: bool,
    /// It reads only for the first of these times out of the second.
    pub reads_for: Option<(Time, Time)>,
    /// How often a packet may have waited for that.
    pub unread: u64,
    /// Empty packets, by which the device ends a read that full ones left open.
    pub empty: u64,
    /// Transfers that are over, in order.
    pub transfers: Vec<Transfer>,
    /// The port is open.
    pub is_open: bool,
    /// Bytes received.
    pub received: Vec<(Time, u8)>,
    /// How many OUT packets of the port were answered NAK, and taken.
    pub naks: u64,
    /// See there.
    pub taken: u64,
    /// What a device must not do.
    pub complaint: Option<String>,
}

impl Default for Host {
    fn default() -> Self {
        Host {
            phase: Phase::Out,
            next: NEVER,
            suspends: NEVER,
            address: 0,
            asked: 0,
            current: None,
            requests: VecDeque::new(),
            pipes: None,
            odd: [false; 2],
            was_in: false,
            sending: VecDeque::new(),
            reading: Vec::new(),
            reads: true,
            reads_for: None,
            unread: 0,
            empty: 0,
            transfers: Vec::new(),
            is_open: false,
            received: Vec::new(),
            naks: 0,
            taken: 0,
            complaint: None,
        }
    }
}

/// A request of the standard, the class or a vendor.
pub fn request(kind: u8, request: u8, value: u16, index: u16, data: &[u8], length: u16) -> Transfer {
    let ([v, w], [i, j], [l, m]) = (value.to_le_bytes(), index.to_le_bytes(), length.to_le_bytes());
    Transfer { setup: [kind, request, v, w, i, j, l, m], data: data.to_vec(), is_done: false }
}

fn descriptor(kind: u8, index: u8, language: u16, length: u16) -> Transfer {
    request(0x80, 6, u16::from(kind) << 8 | u16::from(index), language, &[], length)
}

impl Host {
    /// The cable is put in, or pulled out.
    pub fn plug(&mut self, there: bool, at: Time) {
        self.leave(if there { Phase::Waiting } else { Phase::Out }, at);
        self.suspends = if there { NEVER } else { at + SUSPENDED };
    }

    /// The bus is reset and the device found anew, as after trouble.
    pub fn reset(&mut self, at: Time) {
        self.leave(Phase::Debouncing, at);
    }

    fn leave(&mut self, phase: Phase, at: Time) {
        let kept = (std::mem::take(&mut self.transfers), std::mem::take(&mut self.received), self.reads);
        let counts = (self.naks, self.taken, self.complaint.take());
        *self = Host { phase, next: if phase == Phase::Out { NEVER } else { at }, ..Host::default() };
        (self.transfers, self.received, self.reads) = kept;
        (self.naks, self.taken, self.complaint) = counts;
    }

    /// Sends bytes to the port; they are lost if it is not open.
    pub fn send(&mut self, bytes: &[u8]) {
        if self.is_open {
            self.sending.extend(bytes);
        }
    }

    /// What it is about, for a message.
    pub fn state(&self) -> String {
        match &self.current {
            Some((transfer, stage)) => {
                format!("{:?}, {stage:?} of request {:x?} under way", self.phase, transfer.setup)
            }
            None => format!("{:?}, {} requests through", self.phase, self.transfers.len()),
        }
    }

    /// Bytes that the device has not taken.
    pub fn waiting(&self) -> usize {
        self.sending.len()
    }

    /// Makes a request of a test, after those in progress.
    pub fn ask(&mut self, transfer: Transfer) {
        self.requests.push_back(transfer);
    }

    /// When something happens next.
    pub fn next(&self) -> Time {
        self.next.min(self.suspends)
    }

    fn complain(&mut self, what: String) {
        self.complaint.get_or_insert(what);
    }

    /// Does what is due first.
    pub fn step(&mut self, core: &mut Core) {
        if self.suspends <= self.next {
            self.suspends = NEVER;
            return core.suspends();
        }
        let at = self.next;
        if !matches!(self.phase, Phase::Out | Phase::Waiting) && !core.is_pulled_up() {
            self.leave(Phase::Waiting, at);
        }
        self.next = at + SETTLED;
        match self.phase {
            Phase::Out => self.next = NEVER,
            Phase::Waiting => {
                if core.is_pulled_up() {
                    self.phase = Phase::Debouncing;
                } else {
                    self.next = at + MILLISECOND;
                }
            }
            Phase::Debouncing => {
                core.reset_begins();
                self.phase = Phase::Resetting;
            }
            Phase::Resetting => {
                core.reset_ends();
                self.phase = Phase::Recovering;
            }
            Phase::Recovering => {
                self.phase = Phase::Running;
                self.next = at;
            }
            Phase::Running => self.next = at + self.transact(core, at),
        }
    }

    /// One transaction; returns how long until the next one.
    fn transact(&mut self, core: &mut Core, at: Time) -> Time {
        if self.current.is_none() {
            let next = self.enumeration().or_else(|| self.requests.pop_front());
            self.current = next.map(|transfer| (transfer, Stage::Setup));
        }
        if let Some((transfer, stage)) = self.current.take() {
            return self.control(core, transfer, stage);
        }
        let Some(pipes) = self.pipes.filter(|_| self.is_open) else { return RETRY };
        // In turn; a NAK gives the turn to the other.
        let order = [!self.was_in, self.was_in];
        for is_in in order {
            let moved = if is_in { self.receive(core, pipes, at) } else { self.transmit(core, pipes) };
            if let Some(bytes) = moved {
                self.was_in = is_in;
                return (OVERHEAD + 8 * bytes as Time) * BIT;
            }
        }
        RETRY
    }

    fn receive(&mut self, core: &mut Core, pipes: Pipes, at: Time) -> Option<usize> {
        if !self.reads || self.reads_for.is_some_and(|(open, of)| at % of >= open) {
            self.unread += 1;
            return None;
        }
        let (handshake, odd, bytes) = core.give(self.address, pipes.from_device);
        match handshake {
            Handshake::Nak => return None,
            Handshake::Ack => {}
            other => {
                self.complain(format!("the endpoint from the device answers {other:?}"));
                return None;
            }
        }
        if odd != self.odd[1] || bytes.len() > PACKET {
            self.complain("a packet from the device is not the one that is due".into());
        }
        self.odd[1] = !odd;
        self.reading.extend(&bytes);
        self.empty += u64::from(bytes.is_empty());
        if bytes.len() < PACKET || self.reading.len() >= READ {
            self.received.extend(self.reading.drain(..).map(|byte| (at, byte)));
        }
        Some(bytes.len())
    }

    fn transmit(&mut self, core: &mut Core, pipes: Pipes) -> Option<usize> {
        let packet: Vec<u8> = self.sending.iter().take(PACKET).copied().collect();
        if packet.is_empty() {
            return None;
        }
        match core.take(self.address, pipes.to_device, self.odd[0], &packet) {
            Handshake::Ack => {
                self.odd[0] = !self.odd[0];
                self.sending.drain(..packet.len());
                self.taken += 1;
                Some(packet.len())
            }
            Handshake::Nak => {
                self.naks += 1;
                None
            }
            other => {
                self.complain(format!("the endpoint to the device answers {other:?}"));
                None
            }
        }
    }

    /// A transaction of a control transfer.
    fn control(&mut self, core: &mut Core, mut transfer: Transfer, stage: Stage) -> Time {
        let time = |bytes: usize| (OVERHEAD + 8 * bytes as Time) * BIT;
        let (handshake, taken, next) = match stage {
            Stage::Setup => {
                let handshake = core.setup(self.address, transfer.setup);
                (handshake, 8, if transfer.length() > 0 { Stage::Data(0) } else { Stage::Status })
            }
            Stage::Data(_) if transfer.is_in() => {
                let (handshake, _, bytes) = core.give(self.address, 0);
                transfer.data.extend(&bytes);
                let ended = bytes.len() < PACKET || transfer.data.len() >= transfer.length();
                (handshake, bytes.len(), if ended { Stage::Status } else { Stage::Data(transfer.data.len()) })
            }
            Stage::Data(through) => {
                let packet = transfer.data[through..].iter().take(PACKET).copied().collect::<Vec<_>>();
                let handshake = core.take(self.address, 0, true, &packet);
                let through = through + packet.len();
                (
                    handshake,
                    packet.len(),
                    if through < transfer.data.len() { Stage::Data(through) } else { Stage::Status },
                )
            }
            Stage::Status if transfer.is_in() && transfer.length() > 0 => {
                (core.take(self.address, 0, true, &[]), 0, stage)
            }
            Stage::Status => (core.give(self.address, 0).0, 0, stage),
        };
        match handshake {
            Handshake::Ack if stage != Stage::Status => self.current = Some((transfer, next)),
            Handshake::Ack => {
                transfer.is_done = true;
                self.finish(transfer);
            }
            Handshake::Stall => self.finish(transfer),
            Handshake::Nak => {
                self.current = Some((transfer, stage));
                return RETRY;
            }
            Handshake::Silence => {
                self.current = Some((transfer, stage));
                self.complain("the device does not answer a control transfer".into());
                return MILLISECOND;
            }
        }
        time(taken)
    }

    fn finish(&mut self, transfer: Transfer) {
        match (transfer.is_done, transfer.setup) {
            (true, [0x00, 5, address, ..]) => self.address = address,
            (true, [0x00, 9, ..]) => self.odd = [false; 2],
            (true, [0x21, 0x22, lines, ..]) => self.is_open = lines & 1 != 0,
            _ => {}
        }
        self.transfers.push(transfer);
    }

    /// What was answered to the last request.
    fn answer(&self) -> &[u8] {
        self.transfers.last().map_or(&[], |transfer| &transfer.data)
    }

    /// The next request of the enumeration and of opening the port.
    fn enumeration(&mut self) -> Option<Transfer> {
        let language = 0x0409;
        self.asked += 1;
        Some(match self.asked {
            1 => descriptor(1, 0, 0, 64),
            2 => request(0x00, 5, ADDRESS.into(), 0, &[], 0),
            3 => descriptor(1, 0, 0, 18),
            4 => descriptor(2, 0, 0, 9),
            5 => {
                let total = u16::from_le_bytes([*self.answer().get(2)?, *self.answer().get(3)?]);
                descriptor(2, 0, 0, total)
            }
            6 => {
                self.pipes = pipes(self.answer());
                descriptor(3, 0, 0, 255)
            }
            7 => descriptor(3, 1, language, 255),
            8 => descriptor(3, 2, language, 255),
            9 => descriptor(3, 3, language, 255),
            10 => request(0x00, 9, 1, 0, &[], 0),
            // 115200 8N1.
            11 => request(0x21, 0x20, 0, 0, &[0x00, 0xc2, 0x01, 0x00, 0, 0, 8], 7),
            12 => request(0xa1, 0x21, 0, 0, &[], 7),
            // DTR and RTS.
            13 => request(0x21, 0x22, 3, 0, &[], 0),
            _ => return None,
        })
    }
}

/// The first bulk endpoint of each direction.
fn pipes(configuration: &[u8]) -> Option<Pipes> {
    let mut rest = configuration;
    let (mut to_device, mut from_device) = (None, None);
    while let Some(&length) = rest.first().filter(|&&length| length >= 2) {
        if let [7, 5, address, 2, ..] = *rest {
            let place = if address & 0x80 == 0 { &mut to_device } else { &mut from_device };
            place.get_or_insert(usize::from(address & 0xf));
        }
        rest = rest.get(length.into()..)?;
    }
    Some(Pipes { to_device: to_device?, from_device: from_device? })
}
