//! SPI3 as a master (RM0433 50): the data to an external DAC.
//!
//! In: registers. Out: words with the instants at which their last bit ends ([`Spi::sent`]). Owns
//! the state of the peripheral. The lines of clock and data have a level only while idle; chip
//! select is a pin like any other. There is no data from the DAC: received words are 0. Fails with
//! complaints: interrupts, DMA and CRC are not modelled.
use crate::clocks::Clocks;
use crate::device::{Device, Signal, Source};
use crate::time::{NEVER, Time};
use std::collections::VecDeque;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const CFG1: u32 = 0x08;
const CFG2: u32 = 0x0c;
const IER: u32 = 0x10;
const SR: u32 = 0x14;
const IFCR: u32 = 0x18;
const TXDR: u32 = 0x20;
const RXDR: u32 = 0x30;

const SPE: u32 = 1 << 0;
const CSTART: u32 = 1 << 9;
const CSUSP: u32 = 1 << 10;
const MASTER: u32 = 1 << 22;
const SIMPLEX_SENDER: u32 = 1 << 17;
const CPHA: u32 = 1 << 24;
const CPOL: u32 = 1 << 25;

const RXP: u32 = 1 << 0;
const TXP: u32 = 1 << 1;
const EOT: u32 = 1 << 3;
const TXTF: u32 = 1 << 4;
const OVR: u32 = 1 << 6;
const SUSP: u32 = 1 << 11;
const TXC: u32 = 1 << 12;

/// Bytes of the FIFO.
const DEPTH: usize = 16;

/// See the module text.
#[derive(Debug, Clone)]
pub struct Spi {
    cr: [u32; 2],
    cfg: [u32; 2],
    latched: u32,
    kernel: Option<Time>,
    waiting: VecDeque<u32>,
    /// Words received and not yet read.
    received: usize,
    shifting: Option<(u32, Time)>,
    /// How much longer than it should the next word takes, for tests.
    pub stall: Time,
    /// Words left of TSIZE, where it counts.
    left: Option<u32>,
    /// Words sent, with the instants at which they are whole.
    pub sent: Vec<(Time, u32)>,
    /// What was set that is not modelled, or written where there is no room.
    pub complaint: Option<String>,
}

impl Default for Spi {
    fn default() -> Self {
        Spi {
            cr: [0; 2],
            cfg: [0x0007_0007, 0],
            latched: 0,
            kernel: None,
            waiting: VecDeque::new(),
            received: 0,
            shifting: None,
            stall: 0,
            left: None,
            sent: Vec::new(),
            complaint: None,
        }
    }
}

impl Spi {
    fn complain(&mut self, what: &str) {
        self.complaint.get_or_insert_with(|| format!("SPI3: {what}"));
    }

    /// Bits of a word.
    fn bits(&self) -> u32 {
        (self.cfg[0] & 0x1f) + 1
    }

    fn divided(&self, kernel: Time) -> Time {
        kernel << ((self.cfg[0] >> 28 & 7) + 1)
    }

    /// Time a bit takes.
    pub fn bit(&self) -> Option<Time> {
        self.kernel.map(|kernel| self.divided(kernel))
    }

    /// SPI mode: CPOL, CPHA.
    pub fn mode(&self) -> (bool, bool) {
        (self.cfg[1] & CPOL != 0, self.cfg[1] & CPHA != 0)
    }

    fn room(&self) -> usize {
        DEPTH / self.bits().div_ceil(8).next_power_of_two() as usize
    }

    /// The next word into the shift register, if one may go.
    fn shift(&mut self, at: Time) {
        if self.shifting.is_some() || self.cr[0] & (SPE | CSTART) != SPE | CSTART || self.left == Some(0) {
            return;
        }
        let Some(word) = self.waiting.pop_front() else { return };
        let Some(kernel) = self.kernel else { return self.complain("it has no kernel clock") };
        let bit = self.divided(kernel);
        self.latched &= !TXC;
        let stall = std::mem::take(&mut self.stall);
        self.shifting = Some((word, at + bit * Time::from(self.bits()) + stall));
    }

    fn status(&self) -> u32 {
        let threshold = (self.cfg[0] >> 5 & 0xf) as usize + 1;
        let mut flags = self.latched;
        if self.cr[0] & SPE != 0 && self.room() - self.waiting.len() >= threshold {
            flags |= TXP;
        }
        if self.received >= threshold {
            flags |= RXP;
        }
        if self.shifting.is_none() && self.waiting.is_empty() {
            flags |= TXC;
        }
        flags
    }

    fn publish(&self, out: &mut Vec<Signal>) {
        // AFCNTR keeps the lines also while the peripheral is off.
        let on = self.cfg[1] & MASTER != 0 && (self.cr[0] & SPE != 0 || self.cfg[1] & 1 << 31 != 0);
        let idle = self.cfg[1] & CPOL != 0;
        out.push(Signal::Output(Source::SpiClock(3), on.then_some(idle)));
        out.push(Signal::Output(Source::SpiData(3), on.then_some(false)));
    }
}

impl Device for Spi {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        if offset == RXDR {
            self.received = self.received.saturating_sub(1);
        }
        Some(match offset {
            CR1 | CR2 => self.cr[offset as usize / 4],
            CFG1 | CFG2 => self.cfg[(offset - CFG1) as usize / 4],
            IER | IFCR | TXDR | RXDR => 0,
            SR => self.status(),
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()> {
        let before = if offset == RXDR { 0 } else { self.read(offset, at, &mut Vec::new())? };
        let new = before & !mask | value & mask;
        let on = self.cr[0] & SPE != 0;
        match offset {
            CR1 => {
                let started = new & CSTART != 0 && before & CSTART == 0;
                self.cr[0] = new & !CSUSP;
                if new & SPE == 0 {
                    if self.shifting.is_some() || !self.waiting.is_empty() {
                        self.complain("it is switched off with words on their way");
                    }
                    (self.shifting, self.latched, self.cr[0]) = (None, 0, self.cr[0] & !CSTART);
                    self.received = 0;
                    self.waiting.clear();
                } else if !on && (self.cfg[1] & (MASTER | 2 << 17) != MASTER || self.cfg[0] & 3 << 14 != 0) {
                    self.complain("it is set to what is not modelled: only a master that sends is");
                }
                if started {
                    self.left = Some(self.cr[1] & 0xffff).filter(|&size| size != 0);
                }
                if new & CSUSP != 0 {
                    self.cr[0] &= !CSTART;
                    self.latched |= SUSP;
                }
            }
            CR2 => self.cr[1] = new,
            CFG1 | CFG2 if on => self.complain("its settings are written while it is on"),
            CFG1 | CFG2 => self.cfg[(offset - CFG1) as usize / 4] = new,
            IER if new != 0 => self.complain("interrupts are not modelled"),
            IFCR => self.latched &= !(value & mask & (EOT | TXTF | SUSP | 0x3e0)),
            TXDR => {
                if !on {
                    self.complain("a word is written while it is off");
                } else if self.waiting.len() >= self.room() {
                    self.complain("a word is written into a full FIFO");
                } else {
                    let bits = self.bits();
                    self.waiting.push_back(if bits < 32 { value & ((1 << bits) - 1) } else { value });
                }
            }
            _ => {}
        }
        self.shift(at);
        self.publish(out);
        Some(())
    }

    fn next(&self) -> Time {
        self.shifting.map_or(NEVER, |(_, end)| end)
    }

    fn advance(&mut self, to: Time, _: &mut Vec<Signal>) {
        while let Some((word, end)) = self.shifting.filter(|&(_, end)| end <= to) {
            self.sent.push((end, word));
            self.shifting = None;
            if self.cfg[1] & SIMPLEX_SENDER == 0 {
                if self.received < self.room() {
                    self.received += 1;
                } else {
                    self.latched |= OVR;
                    self.complain("what it receives overruns");
                }
            }
            if let Some(left) = &mut self.left {
                *left -= 1;
                if *left == 0 {
                    self.latched |= EOT | TXTF | TXC;
                    self.cr[0] &= !CSTART;
                }
            }
            self.shift(end);
        }
    }

    fn reset(&mut self, _: Time, out: &mut Vec<Signal>) {
        let kept = std::mem::take(self);
        *self = Spi { kernel: kept.kernel, sent: kept.sent, complaint: kept.complaint, ..Spi::default() };
        self.publish(out);
    }

    fn clocks(&mut self, clocks: &Clocks, _: Time) {
        self.kernel = clocks.spi;
    }
}
