//! USB OTG FS as a device (RM0433 57), as far as the image uses it: endpoints with their FIFOs,
//! events of the bus, VBUS.
//!
//! In: registers, transactions of the [`Host`]. Out: handshakes and data, the interrupt's line.
//! Owns the endpoints and their FIFOs. Fails with a NAK or with no answer, as the core does.
//!
//! A packet arrives at once and whole. An OUT endpoint accepts a packet while it is enabled
//! (EPENA), has no NAK and expects a packet (PKTCNT). Its transfer ends with that packet: NAK is
//! set, and EPENA cleared when the transfer is reported complete. Some cores accept packets without
//! EPENA (an STM32L476 does), so the model has that too ([`Core::lenient`]). Not modelled: DMA,
//! isochronous and host operation, transfers of more than a packet.
mod endpoint;

use crate::clocks::Clocks;
use crate::device::{Device, Signal};
use crate::time::{MILLISECOND, Time};
use crate::usb_host::Host;
use endpoint::Endpoint;
use std::collections::VecDeque;

/// Of each direction (RM0433 57).
pub const ENDPOINTS: usize = 9;
/// The interrupt (RM0433 table 148).
const LINE: usize = 101;
/// The core's memory in words.
const WORDS: u32 = 1024;

const GOTGCTL: u32 = 0x00;
const GOTGINT: u32 = 0x04;
const GAHBCFG: u32 = 0x08;
const GUSBCFG: u32 = 0x0c;
const GRSTCTL: u32 = 0x10;
const GINTSTS: u32 = 0x14;
const GINTMSK: u32 = 0x18;
const GRXSTSP: u32 = 0x20;
const GRXFSIZ: u32 = 0x24;
const DIEPTXF0: u32 = 0x28;
const GCCFG: u32 = 0x38;
const DCFG: u32 = 0x800;
const DCTL: u32 = 0x804;
const DSTS: u32 = 0x808;
const DIEPMSK: u32 = 0x810;
const DOEPMSK: u32 = 0x814;
const DAINT: u32 = 0x818;
const DAINTMSK: u32 = 0x81c;
const DIEPEMPMSK: u32 = 0x834;
/// The first IN and OUT endpoint, and the offset after the last.
const INS: u32 = 0x900;
const OUTS: u32 = 0xb00;
const END: u32 = OUTS + 0x20 * ENDPOINTS as u32;
const FIFO: u32 = 0x1000;

/// BVALOEN, BVALOVAL: a session whatever VBUS says.
const BVALO: u32 = 3 << 6;

const OTGINT: u32 = 1 << 2;
const RXFLVL: u32 = 1 << 4;
const USBSUSP: u32 = 1 << 11;
const USBRST: u32 = 1 << 12;
const ENUMDNE: u32 = 1 << 13;
const IEPINT: u32 = 1 << 18;
const OEPINT: u32 = 1 << 19;
const SRQINT: u32 = 1 << 30;
const SEDET: u32 = 1 << 2;

const USBAEP: u32 = 1 << 15;
const NAKSTS: u32 = 1 << 17;
const STALL: u32 = 1 << 21;
const CNAK: u32 = 1 << 26;
const SNAK: u32 = 1 << 27;
const SD0PID: u32 = 1 << 28;
const EPDIS: u32 = 1 << 30;
const EPENA: u32 = 1 << 31;
/// What an endpoint's control register keeps as it is written: MPSIZ, USBAEP, EPTYP, STALL, TXFNUM.
const KEPT: u32 = 0x7ff | USBAEP | 3 << 18 | STALL | 0xf << 22;

/// Of DOEPTSIZ.
const PKTCNT: u32 = 0x3ff << 19;

const XFRC: u32 = 1 << 0;
const EPDISD: u32 = 1 << 1;
const STUP: u32 = 1 << 3;
const TXFE: u32 = 1 << 7;

/// Kinds of packet status in GRXSTSP (RM0433 57).
const OUT_DATA: u32 = 2;
const OUT_DONE: u32 = 3;
const SETUP_DONE: u32 = 4;
const SETUP_DATA: u32 = 6;

/// What a device answers to a transaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handshake {
    /// Taken.
    Ack,
    /// Not now.
    Nak,
    /// Not at all.
    Stall,
    /// Nobody answers.
    Silence,
}

/// The core.
#[derive(Debug, Clone, Default)]
pub struct Core {
    gotgctl: u32,
    gotgint: u32,
    gahbcfg: u32,
    gusbcfg: u32,
    gintsts: u32,
    gintmsk: u32,
    grxfsiz: u32,
    gccfg: u32,
    dcfg: u32,
    /// The address in force: DAD, once the status of SetAddress has gone out (RM0433 57).
    address: u8,
    dctl: u32,
    masks: [u32; 4],
    ins: [Endpoint; ENDPOINTS],
    outs: [Endpoint; ENDPOINTS],
    /// Status words with their data, as they were received.
    received: VecDeque<(u32, Vec<u32>)>,
    /// Data of the status that was fetched last.
    fetched: VecDeque<u32>,
    /// The host's 5 V are on, and the session that VBDEN has detected.
    vbus: bool,
    session: bool,
    /// They do not reach the chip.
    pub lacks_vbus: bool,
    /// GOTGCTL makes no session.
    pub no_session: bool,
    /// D+ is never pulled up.
    pub no_device: bool,
    /// Each fiftieth packet of data arrives damaged, and how many have come.
    pub spoils_packets: bool,
    taken: u32,
    /// Supply and pins; time of a cycle of its clock.
    connected: bool,
    clock: Option<Time>,
    /// OUT endpoints take packets without EPENA and PKTCNT too.
    pub lenient: bool,
    /// What is done against the manual.
    pub complaint: Option<String>,
}

impl Core {
    /// As after a reset (tests/reset_values.rs names the source).
    fn initial() -> Core {
        let (gusbcfg, grxfsiz, dcfg) = (0xa00, 0x200, 0x0220_0000);
        let mut core = Core { gusbcfg, grxfsiz, dcfg, ..Core::default() };
        core.ins[0].place = 0x200;
        core.ins[0].control = USBAEP;
        core.outs[0].control = USBAEP;
        core
    }

    fn complain(&mut self, what: &str) {
        self.complaint.get_or_insert_with(|| what.into());
    }

    /// The pull-up at D+: the session of a B-device by VBUS, or by GOTGCTL instead; supply, pins,
    /// transceiver, no soft disconnect.
    fn pulls_up(&self) -> bool {
        let session = self.session || self.gotgctl & BVALO == BVALO && !self.no_session;
        session && !self.no_device && self.connected && self.gccfg & 1 << 16 != 0 && self.dctl & 1 << 1 == 0
    }

    /// The host sees the pull-up. A clock of 48 MHz is there as well.
    pub fn is_pulled_up(&mut self) -> bool {
        let up = self.pulls_up();
        if up && self.clock != Some(20) {
            self.complain("USB connects without a clock of 48 MHz");
        }
        if up && self.gusbcfg & (1 << 30 | 1 << 6) != 1 << 30 | 1 << 6 {
            self.complain("USB connects before it is a device with the internal transceiver");
        }
        up
    }

    fn look_at_vbus(&mut self) {
        let session = self.vbus && !self.lacks_vbus && self.gccfg & 1 << 21 != 0;
        if session && !self.session {
            self.gintsts |= SRQINT;
        }
        if !session && self.session {
            self.gotgint |= SEDET;
        }
        self.session = session;
    }

    /// The host drives a reset.
    pub fn reset_begins(&mut self) {
        self.gintsts |= USBRST;
        for endpoint in self.ins.iter_mut().chain(&mut self.outs).filter(|endpoint| endpoint.control & 0x7ff != 0) {
            endpoint.control &= !USBAEP;
        }
        self.ins[0].control |= USBAEP;
        self.outs[0].control |= USBAEP;
    }

    /// The reset is over; the speed is known.
    pub fn reset_ends(&mut self) {
        self.gintsts |= ENUMDNE;
    }

    /// Nothing happens on the bus any more.
    pub fn suspends(&mut self) {
        self.gintsts |= USBSUSP;
    }

    fn rx_used(&self) -> usize {
        self.fetched.len() + self.received.iter().map(|(_, words)| 1 + words.len()).sum::<usize>()
    }

    fn store(&mut self, endpoint: usize, kinds: (u32, u32), bytes: &[u8]) -> bool {
        let words: Vec<u32> = bytes
            .chunks(4)
            .map(|chunk| {
                let mut word = [0; 4];
                word[..chunk.len()].copy_from_slice(chunk);
                u32::from_le_bytes(word)
            })
            .collect();
        if self.rx_used() + words.len() + 2 > (self.grxfsiz & 0xffff) as usize {
            return false;
        }
        let status = |kind: u32, count: usize| kind << 17 | (count as u32) << 4 | endpoint as u32;
        self.received.push_back((status(kinds.0, bytes.len()), words));
        self.received.push_back((status(kinds.1, 0), Vec::new()));
        true
    }

    fn reported_address(&self) -> u8 {
        (self.dcfg >> 4 & 0x7f) as u8
    }

    fn is_addressed(&self, address: u8) -> bool {
        self.address == address
    }

    /// A SETUP transaction, which is always taken.
    pub fn setup(&mut self, address: u8, packet: [u8; 8]) -> Handshake {
        if !self.is_addressed(address) || !self.store(0, (SETUP_DATA, SETUP_DONE), &packet) {
            return Handshake::Silence;
        }
        for endpoint in [&mut self.ins[0], &mut self.outs[0]] {
            endpoint.nak = true;
            endpoint.control &= !STALL;
        }
        Handshake::Ack
    }

    /// An OUT transaction.
    pub fn take(&mut self, address: u8, number: usize, odd: bool, packet: &[u8]) -> Handshake {
        let endpoint = &self.outs[number];
        if !self.is_addressed(address) || endpoint.control & USBAEP == 0 {
            return Handshake::Silence;
        }
        if endpoint.control & STALL != 0 {
            return Handshake::Stall;
        }
        let enabled = endpoint.enabled && endpoint.size & PKTCNT != 0 || self.lenient;
        let mut packet = packet.to_vec();
        if self.spoils_packets && number != 0 && self.taken % 50 == 49 {
            packet.iter_mut().take(1).for_each(|byte| *byte ^= 0x55);
        }
        if endpoint.nak || !enabled || !self.store(number, (OUT_DATA, OUT_DONE), &packet) {
            return Handshake::Nak;
        }
        if number != 0 && self.outs[number].odd != odd {
            self.complain("the host and the core do not agree about DATA0 and DATA1 of what the host sends");
        }
        self.taken += u32::from(number != 0);
        let endpoint = &mut self.outs[number];
        endpoint.nak = true;
        endpoint.size &= !PKTCNT;
        endpoint.odd = !odd;
        Handshake::Ack
    }

    /// An IN transaction: with Ack, the packet, and whether it is DATA1.
    pub fn give(&mut self, address: u8, number: usize) -> (Handshake, bool, Vec<u8>) {
        let is_addressed = self.is_addressed(address);
        let endpoint = &mut self.ins[number];
        let nothing = |handshake| (handshake, false, Vec::new());
        if !is_addressed || endpoint.control & USBAEP == 0 {
            return nothing(Handshake::Silence);
        }
        if endpoint.control & STALL != 0 {
            return nothing(Handshake::Stall);
        }
        let count = (endpoint.size & 0x7_ffff) as usize;
        let words = count.div_ceil(4);
        if !endpoint.enabled || endpoint.nak || endpoint.fifo.len() < words {
            return nothing(Handshake::Nak);
        }
        let bytes: Vec<u8> = endpoint.fifo.drain(..words).flat_map(u32::to_le_bytes).take(count).collect();
        let odd = endpoint.odd;
        endpoint.odd = !odd;
        endpoint.enabled = false;
        endpoint.size = 0;
        endpoint.flags |= XFRC;
        if number == 0 && count == 0 {
            self.address = self.reported_address();
        }
        (Handshake::Ack, odd, bytes)
    }

    fn daint(&self) -> u32 {
        let [ins, outs, _, empty] = self.masks;
        let mut bits = 0;
        for (n, endpoint) in self.ins.iter().enumerate() {
            let emptied = endpoint.fifo.is_empty() && empty >> n & 1 != 0;
            bits |= u32::from(endpoint.flags & ins != 0 || emptied) << n;
        }
        for (n, endpoint) in self.outs.iter().enumerate() {
            bits |= u32::from(endpoint.flags & outs != 0) << (16 + n);
        }
        bits
    }

    fn status(&self) -> u32 {
        let asked = self.daint() & self.masks[2];
        let bit = |on: bool, bit: u32| if on { bit } else { 0 };
        self.gintsts
            | bit(self.gotgint != 0, OTGINT)
            | bit(!self.received.is_empty(), RXFLVL)
            | bit(asked & 0xffff != 0, IEPINT)
            | bit(asked >> 16 != 0, OEPINT)
    }

    fn line(&self) -> bool {
        self.gahbcfg & 1 != 0 && self.status() & self.gintmsk != 0
    }

    fn pop_status(&mut self) -> u32 {
        if !self.fetched.is_empty() {
            self.complain("data of a USB packet were left in the FIFO");
            self.fetched.clear();
        }
        let Some((status, words)) = self.received.pop_front() else { return 0 };
        self.fetched.extend(words);
        let endpoint = (status & 0xf) as usize;
        match status >> 17 & 0xf {
            SETUP_DONE => {
                self.outs[endpoint].flags |= STUP;
                self.outs[endpoint].enabled = false;
            }
            OUT_DONE => {
                self.outs[endpoint].flags |= XFRC;
                self.outs[endpoint].enabled = false;
            }
            _ => {}
        }
        status
    }

    fn flush(&mut self, value: u32) {
        if value & 1 << 5 != 0 {
            let number = (value >> 6 & 0x1f) as usize;
            for (n, endpoint) in self.ins.iter_mut().enumerate() {
                if number == 16 || number == n {
                    endpoint.fifo.clear();
                }
            }
        }
        if value & 1 << 4 != 0 {
            self.received.clear();
            self.fetched.clear();
        }
    }

    fn endpoint(&mut self, offset: u32) -> Option<(&mut Endpoint, u32)> {
        let (all, first) = if offset < OUTS { (&mut self.ins, INS) } else { (&mut self.outs, OUTS) };
        Some((all.get_mut((offset - first) as usize / 0x20)?, offset & 0x1f))
    }

    fn check_memory(&mut self) {
        let used = self.ins.iter().map(|endpoint| endpoint.place >> 16).sum::<u32>() + (self.grxfsiz & 0xffff);
        if used > WORDS {
            self.complain("USB's FIFOs are larger than the core's memory");
        }
    }

    fn read(&mut self, offset: u32, at: Time) -> Option<u32> {
        Some(match offset {
            // The ID pin says B-device; BSVLD.
            GOTGCTL => 1 << 16 | u32::from(self.session) << 19 | self.gotgctl,
            GOTGINT => self.gotgint,
            GAHBCFG => self.gahbcfg,
            GUSBCFG => self.gusbcfg,
            // AHBIDL; flushes are over at once.
            GRSTCTL => 1 << 31,
            GINTSTS => self.status(),
            GINTMSK => self.gintmsk,
            GRXSTSP => self.pop_status(),
            GRXFSIZ => self.grxfsiz,
            DIEPTXF0 => self.ins[0].place,
            0x104..=0x120 => self.ins[(offset as usize - 0x100) / 4].place,
            GCCFG => self.gccfg,
            DCFG => self.dcfg,
            DCTL => self.dctl,
            // Full speed; the number of the frame.
            DSTS => 3 << 1 | ((at / MILLISECOND) as u32 & 0x3fff) << 8,
            DIEPMSK => self.masks[0],
            DOEPMSK => self.masks[1],
            DAINT => self.daint(),
            DAINTMSK => self.masks[2],
            DIEPEMPMSK => self.masks[3],
            INS..END => {
                let is_in = offset < OUTS;
                let (endpoint, register) = self.endpoint(offset)?;
                match register {
                    0x00 => endpoint.read(),
                    0x08 if is_in && endpoint.fifo.is_empty() => endpoint.flags | TXFE,
                    0x08 => endpoint.flags,
                    0x10 => endpoint.size,
                    0x18 if is_in => endpoint.room(),
                    _ => return None,
                }
            }
            FIFO..=0x1_ffff => match self.fetched.pop_front() {
                Some(word) => word,
                None => {
                    self.complain("an empty FIFO of USB is read");
                    0
                }
            },
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            GOTGCTL => self.gotgctl = value & BVALO,
            GOTGINT => self.gotgint &= !value,
            GAHBCFG => self.gahbcfg = value,
            GUSBCFG => self.gusbcfg = value,
            GRSTCTL => self.flush(value),
            GINTSTS => self.gintsts &= !value,
            GINTMSK => self.gintmsk = value,
            GRXFSIZ => self.grxfsiz = value,
            DIEPTXF0 => self.ins[0].place = value,
            0x104..=0x120 => self.ins[(offset as usize - 0x100) / 4].place = value,
            GCCFG => {
                self.gccfg = value;
                self.look_at_vbus();
            }
            DCFG => {
                self.dcfg = value;
                if self.reported_address() == 0 {
                    self.address = 0;
                }
            }
            DCTL => self.dctl = value,
            DIEPMSK => self.masks[0] = value,
            DOEPMSK => self.masks[1] = value,
            DAINTMSK => self.masks[2] = value,
            DIEPEMPMSK => self.masks[3] = value,
            INS..END => {
                let is_in = offset < OUTS;
                let (endpoint, register) = self.endpoint(offset)?;
                match register {
                    0x00 => {
                        endpoint.write(value);
                        if value & CNAK != 0 && value & SNAK != 0 {
                            self.complain("an endpoint of USB shall both answer NAK and not");
                        }
                        self.ins[0].control |= USBAEP;
                        self.outs[0].control |= USBAEP;
                    }
                    0x08 => endpoint.flags &= !value,
                    0x10 => {
                        endpoint.size = value;
                        if !is_in && value & PKTCNT > 1 << 19 {
                            self.complain("an OUT transfer of more than a packet is not modelled");
                        }
                    }
                    _ => return None,
                }
            }
            FIFO..=0x9fff => {
                let endpoint = &mut self.ins[(offset / FIFO - 1) as usize];
                if endpoint.room() == 0 || !endpoint.enabled {
                    self.complain("a word is written into a FIFO of USB that has no room or is not enabled");
                } else {
                    endpoint.fifo.push_back(value);
                }
            }
            _ => return None,
        }
        if matches!(offset, GRXFSIZ | DIEPTXF0 | 0x104..=0x120) {
            self.check_memory();
        }
        Some(())
    }
}

/// The core with the host at its cable.
#[derive(Debug, Clone)]
pub struct Usb {
    /// The core.
    pub core: Core,
    /// The other end.
    pub host: Host,
}

impl Default for Usb {
    fn default() -> Self {
        Usb { core: Core::initial(), host: Host::default() }
    }
}

impl Usb {
    /// Whether supply and pins of the transceiver are there.
    pub fn connect(&mut self, connected: bool) {
        self.core.connected = connected;
    }

    /// The cable is put in, or pulled out.
    pub fn plug(&mut self, there: bool, at: Time) {
        self.core.vbus = there;
        self.core.look_at_vbus();
        if !there && self.core.pulls_up() {
            self.core.complain("D+ is pulled up without the host's 5 V (USB 2.0 7.1.5)");
        }
        self.host.plug(there, at);
    }

    fn report(&self, out: &mut Vec<Signal>) {
        out.push(Signal::Line(LINE, self.core.line()));
    }

    /// What the line is, after something outside of the core has changed it.
    pub fn stir(&self, out: &mut Vec<Signal>) {
        self.report(out);
    }
}

impl Device for Usb {
    fn read(&mut self, offset: u32, at: Time, out: &mut Vec<Signal>) -> Option<u32> {
        let value = self.core.read(offset, at);
        self.report(out);
        value
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, _: Time, out: &mut Vec<Signal>) -> Option<()> {
        // The core has words only (RM0433 57).
        let done = if mask == u32::MAX { self.core.write(offset, value) } else { None };
        self.report(out);
        done
    }

    fn next(&self) -> Time {
        self.host.next()
    }

    fn advance(&mut self, to: Time, out: &mut Vec<Signal>) {
        while self.host.next() <= to {
            self.host.step(&mut self.core);
        }
        self.report(out);
    }

    fn reset(&mut self, _: Time, out: &mut Vec<Signal>) {
        let before = std::mem::take(&mut self.core);
        let Core { vbus, lacks_vbus, connected, lenient, complaint, .. } = before;
        let Core { no_session, no_device, spoils_packets, .. } = before;
        let kept = Core { no_session, no_device, spoils_packets, ..Core::initial() };
        self.core = Core { vbus, lacks_vbus, connected, lenient, complaint, ..kept };
        self.report(out);
    }

    fn clocks(&mut self, clocks: &Clocks, _: Time) {
        self.core.clock = clocks.usb;
    }
}
