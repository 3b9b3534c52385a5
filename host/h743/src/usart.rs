//! USART3 with its FIFOs (RM0433 48), and the wire on both sides of it.
//!
//! In: registers, bytes that the host sends. Out: bytes with the time at which their stop bit ends,
//! the interrupt's line. The host's end runs at [`Usart::HOST_BAUD`]; a divider that does not fit
//! it is a complaint, since every byte would be damaged. DMA fetches what is received; parity, half
//! duplex and sending by DMA are not modelled: their bits are complaints too.
use crate::clocks::Clocks;
use crate::device::{Device, Signal, Source};
use crate::time::{NEVER, Time};
use std::collections::VecDeque;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const CR3: u32 = 0x08;
const BRR: u32 = 0x0c;
const RTOR: u32 = 0x14;
const RQR: u32 = 0x18;
const ISR: u32 = 0x1c;
const ICR: u32 = 0x20;
const RDR: u32 = 0x24;
const TDR: u32 = 0x28;
const PRESC: u32 = 0x2c;

const UE: u32 = 1 << 0;
const RE: u32 = 1 << 2;
const TE: u32 = 1 << 3;
const OVER8: u32 = 1 << 15;
const FIFOEN: u32 = 1 << 29;
/// M1, PCE, M0: no 8N1; half duplex and its kind in CR3; DMA.
const CR1_OTHER: u32 = 1 << 28 | 1 << 12 | 1 << 10;
const CR3_OTHER: u32 = 1 << 7 | 1 << 5 | 1 << 3 | 1 << 1 | 1 << 9 | 1 << 8;

const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXNF: u32 = 1 << 7;
const RTOF: u32 = 1 << 11;
const TXFE: u32 = 1 << 23;
const RXFF: u32 = 1 << 24;
const RXFT: u32 = 1 << 26;
const TXFT: u32 = 1 << 27;

const DMAR: u32 = 1 << 6;
/// USART3_RX at DMAMUX 1 (RM0433 table 121).
const RX_REQUEST: u8 = 45;

/// Places of each FIFO.
const DEPTH: usize = 16;
/// Bits of a byte on the wire: start, eight, stop.
const BITS: Time = 10;

/// See the module text.
#[derive(Debug, Clone)]
pub struct Usart {
    interrupt: usize,
    cr: [u32; 3],
    brr: u32,
    rtor: u32,
    presc: u32,
    /// Flags that stay until they are cleared.
    latched: u32,
    kernel: Time,
    received: VecDeque<u8>,
    sending: VecDeque<u8>,
    /// DMA has been asked for the first byte received.
    asked: bool,
    /// The byte in the shift register and when its stop bit ends.
    shifting: Option<(u8, Time)>,
    /// Bytes that the host has still to send, with the end of their stop bits.
    arriving: VecDeque<(Time, u8)>,
    /// When the host's last byte ends.
    host_free: Time,
    /// When the line will have been silent for RTOR, or for a byte.
    silence: Time,
    idle: Time,
    /// Bytes sent, with the instants at which they are whole.
    pub sent: Vec<(Time, u8)>,
    /// Bytes that came while there was no room.
    pub lost: u64,
    /// By how much its clock is slow.
    pub slow_percent: Time,
    /// Each 500th byte that is read is damaged, and how many were read.
    pub spoils: bool,
    read: u64,
    /// What is set against the model's or the wire's limits.
    pub complaint: Option<String>,
}

impl Usart {
    /// What the ST-LINK's side is set to.
    pub const HOST_BAUD: u64 = 3_000_000;
    /// A bit of the host's.
    const HOST_BIT: Time = 960_000_000 / Self::HOST_BAUD;

    /// With this interrupt.
    pub fn new(interrupt: usize) -> Usart {
        Usart {
            interrupt,
            cr: [0; 3],
            brr: 0,
            rtor: 0,
            presc: 0,
            latched: TC,
            kernel: 15,
            received: VecDeque::new(),
            sending: VecDeque::new(),
            asked: false,
            shifting: None,
            arriving: VecDeque::new(),
            host_free: 0,
            silence: NEVER,
            idle: NEVER,
            sent: Vec::new(),
            lost: 0,
            slow_percent: 0,
            spoils: false,
            read: 0,
            complaint: None,
        }
    }

    /// The host sends; the bytes follow each other on the wire.
    pub fn host_sends(&mut self, bytes: &[u8], at: Time) {
        self.host_free = self.host_free.max(at);
        for &byte in bytes {
            self.host_free += BITS * Self::HOST_BIT;
            self.arriving.push_back((self.host_free, byte));
        }
    }

    /// Bytes of the host that are not on the board yet.
    pub fn in_transit(&self) -> usize {
        self.arriving.len()
    }

    /// A bit's time, by BRR and OVER8 (RM0433 48.5.7).
    fn bit(&self) -> Time {
        const PRESCALERS: [Time; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
        let clock = self.kernel * PRESCALERS[(self.presc & 0xf).min(11) as usize];
        let brr = Time::from(self.brr);
        let bit = if self.cr[0] & OVER8 == 0 { brr * clock } else { (brr & 0xfff0 | (brr & 7) << 1) * clock / 2 };
        bit + bit * self.slow_percent / 100
    }

    fn is_on(&self, what: u32) -> bool {
        self.cr[0] & UE != 0 && self.cr[0] & what != 0
    }

    fn depth(&self) -> usize {
        if self.cr[0] & FIFOEN == 0 { 1 } else { DEPTH }
    }

    fn status(&self) -> u32 {
        let fifo = self.cr[0] & FIFOEN != 0;
        let mut flags = self.latched;
        let mut set = |flag: u32, on: bool| flags |= if on { flag } else { 0 };
        set(RXNE, !self.received.is_empty());
        set(TXNF, self.sending.len() < self.depth());
        set(1 << 21, self.is_on(TE));
        set(1 << 22, self.is_on(RE));
        if fifo {
            set(TXFE, self.sending.is_empty());
            set(RXFF, self.received.len() >= DEPTH);
            set(RXFT, self.received.len() >= threshold(self.cr[2] >> 25));
            set(TXFT, DEPTH - self.sending.len() >= threshold(self.cr[2] >> 29));
        }
        flags
    }

    /// The interrupt's line: an enabled flag is set (RM0433 table 397).
    fn line(&self) -> bool {
        let [cr1, _, cr3] = self.cr;
        let status = self.status();
        let by = |enable: bool, flags: u32| enable && status & flags != 0;
        let bit = |register: u32, n: u32| register & 1 << n != 0;
        by(bit(cr1, 4), IDLE)
            || by(bit(cr1, 5), RXNE | ORE)
            || by(bit(cr1, 6), TC)
            || by(bit(cr1, 7), TXNF)
            || by(bit(cr1, 26), RTOF)
            || by(bit(cr1, 30), TXFE)
            || by(bit(cr1, 31), RXFF)
            || by(bit(cr3, 28), RXFT)
            || by(bit(cr3, 23), TXFT)
            || by(bit(cr3, 0), ORE)
    }

    fn report(&self, out: &mut Vec<Signal>) {
        out.push(Signal::Line(self.interrupt, self.line()));
    }

    /// One request a byte that waits: the next one once the one before is answered.
    fn ask(&mut self, out: &mut Vec<Signal>) {
        let asks = self.cr[2] & DMAR != 0 && !self.received.is_empty();
        if asks && !self.asked {
            out.push(Signal::Request(RX_REQUEST));
        } else if self.asked && !asks {
            out.push(Signal::Withdraw(RX_REQUEST));
        }
        self.asked = asks;
    }

    /// Takes the next byte into the shift register, if there is one and it is free.
    fn shift(&mut self, at: Time) {
        if self.shifting.is_some() || !self.is_on(TE) {
            return;
        }
        if let Some(byte) = self.sending.pop_front() {
            self.check();
            self.latched &= !TC;
            self.shifting = Some((byte, at + BITS * self.bit()));
        }
    }

    /// Both ends of the wire agree within 2 %.
    fn check(&mut self) {
        let bit = self.bit();
        if bit.abs_diff(Self::HOST_BIT) * 50 > Self::HOST_BIT {
            let baud = 960_000_000 / bit.max(1);
            self.complaint.get_or_insert(format!("the USART runs at {baud} baud, the host at {}", Self::HOST_BAUD));
        }
    }

    fn receive(&mut self, byte: u8, at: Time) {
        if !self.is_on(RE) {
            return;
        }
        self.check();
        if self.received.len() < self.depth() {
            self.received.push_back(byte);
        } else {
            self.latched |= ORE;
            self.lost += 1;
        }
        let bit = self.bit();
        self.idle = at + BITS * bit;
        if self.cr[1] & 1 << 23 != 0 {
            self.silence = at + Time::from(self.rtor & 0xff_ffff) * bit;
        }
    }
}

/// Number of bytes, or free slots, that RXFTCFG and TXFTCFG mean.
fn threshold(field: u32) -> usize {
    [2, 4, 8, 12, 14, 16, 16, 16][(field & 7) as usize]
}

impl Device for Usart {
    fn read(&mut self, offset: u32, _: Time, out: &mut Vec<Signal>) -> Option<u32> {
        Some(match offset {
            CR1 | CR2 | CR3 => self.cr[offset as usize / 4],
            BRR => self.brr,
            RTOR => self.rtor,
            RQR | ICR | TDR => 0,
            ISR => self.status(),
            RDR => {
                let mut byte = self.received.pop_front().unwrap_or(0);
                self.read += 1;
                if self.spoils && self.read.is_multiple_of(500) {
                    byte ^= 0x55;
                }
                self.asked = false;
                self.ask(out);
                self.report(out);
                byte.into()
            }
            PRESC => self.presc,
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()> {
        let new = |before: u32| before & !mask | value & mask;
        match offset {
            CR1 | CR2 | CR3 => {
                let register = &mut self.cr[offset as usize / 4];
                *register = new(*register);
                if self.cr[0] & CR1_OTHER != 0 || self.cr[2] & CR3_OTHER != 0 {
                    self.complaint.get_or_insert("the USART is set to what is not modelled".into());
                }
                if self.cr[0] & UE == 0 {
                    self.received.clear();
                    self.sending.clear();
                    self.latched = TC;
                }
                out.push(Signal::Output(Source::UsartTx(3), self.is_on(TE).then_some(true)));
            }
            BRR => self.brr = new(self.brr),
            RTOR => self.rtor = new(self.rtor),
            PRESC => self.presc = new(self.presc),
            RQR => {
                if value & 1 << 3 != 0 {
                    self.received.clear();
                }
                if value & 1 << 4 != 0 {
                    self.sending.clear();
                }
            }
            ICR => self.latched &= !(value & mask & (0xf | IDLE | TC | RTOF)),
            TDR => {
                // A full FIFO drops what is written (RM0433 48.5.5).
                if self.sending.len() < self.depth() {
                    self.sending.push_back(value as u8);
                } else {
                    self.complaint.get_or_insert("a byte was written into a full transmit FIFO".into());
                }
                self.shift(at);
            }
            ISR | RDR => {}
            _ => return None,
        }
        self.shift(at);
        self.ask(out);
        self.report(out);
        Some(())
    }

    fn next(&self) -> Time {
        let shifted = self.shifting.map_or(NEVER, |(_, end)| end);
        let arrives = self.arriving.front().map_or(NEVER, |&(end, _)| end);
        shifted.min(arrives).min(self.silence).min(self.idle)
    }

    fn advance(&mut self, to: Time, out: &mut Vec<Signal>) {
        while let Some(&(end, byte)) = self.arriving.front().filter(|&&(end, _)| end <= to) {
            self.arriving.pop_front();
            self.receive(byte, end);
        }
        while let Some((byte, end)) = self.shifting.filter(|&(_, end)| end <= to) {
            self.sent.push((end, byte));
            self.shifting = None;
            self.shift(end);
            if self.shifting.is_none() {
                self.latched |= TC;
            }
        }
        if self.silence <= to {
            self.silence = NEVER;
            self.latched |= RTOF;
        }
        if self.idle <= to {
            self.idle = NEVER;
            self.latched |= IDLE;
        }
        self.ask(out);
        self.report(out);
    }

    fn reset(&mut self, _: Time, out: &mut Vec<Signal>) {
        let wire = (std::mem::take(&mut self.arriving), std::mem::take(&mut self.sent), self.host_free, self.lost);
        let complaint = self.complaint.take();
        *self = Usart { slow_percent: self.slow_percent, spoils: self.spoils, ..Usart::new(self.interrupt) };
        (self.arriving, self.sent, self.host_free, self.lost) = wire;
        self.complaint = complaint;
        out.push(Signal::Output(Source::UsartTx(3), None));
        self.report(out);
    }

    fn clocks(&mut self, clocks: &Clocks, _: Time) {
        self.kernel = clocks.apb1;
    }
}
