//! DAC1, both channels, 12 bits (RM0433 26).
//!
//! In: registers, triggers by software. Out: what each output shows, with instants
//! ([`Dac::changes`]); the analog pins themselves stay analog. A value without trigger reaches the
//! output a cycle of APB 1 after it is written, one with trigger three after that. Triggers of
//! timers, DMA requests, waves, sample and hold are not modelled, and complaints.
use crate::clocks::Clocks;
use crate::device::{Device, Signal};
use crate::time::{NEVER, Time};

const CR: u32 = 0x00;
const SWTRGR: u32 = 0x04;
const DHR12RD: u32 = 0x20;
const DHR12LD: u32 = 0x24;
const DHR8RD: u32 = 0x28;
const DOR1: u32 = 0x2c;
const DOR2: u32 = 0x30;
const SR: u32 = 0x34;
const CCR: u32 = 0x38;
const MCR: u32 = 0x3c;

/// Bits of CR that are modelled, for one channel: EN and TEN with trigger 0, which is software's.
const EN: u32 = 1 << 0;
const TEN: u32 = 1 << 1;
const OTHER: u32 = 0xfffc;

/// An output changed: when, which (from 0), what it shows in 4096ths of its reference; `None`: it
/// is off.
pub type Change = (Time, usize, Option<u16>);

/// See the module text.
#[derive(Debug, Clone)]
pub struct Dac {
    cr: u32,
    held: [u16; 2],
    published: [Option<u16>; 2],
    output: [u16; 2],
    due: [Time; 2],
    others: [u32; 2],
    cycle: Time,
    /// How much later than it should an output changes, for tests.
    pub lag: Time,
    /// Every change since power-on.
    pub changes: Vec<Change>,
    /// What was set that is not modelled.
    pub complaint: Option<String>,
}

impl Default for Dac {
    fn default() -> Self {
        Dac {
            cr: 0,
            held: [0; 2],
            published: [None; 2],
            output: [0; 2],
            due: [NEVER; 2],
            others: [0; 2],
            cycle: Clocks::RESET.apb1,
            lag: 0,
            changes: Vec::new(),
            complaint: None,
        }
    }
}

impl Dac {
    fn of(&self, n: usize) -> u32 {
        self.cr >> (16 * n) & 0xffff
    }

    /// What an output shows.
    pub fn output(&self, n: usize) -> Option<u16> {
        self.published[n]
    }

    fn hold(&mut self, n: usize, value: u32, at: Time) {
        self.held[n] = (value & 0xfff) as u16;
        if self.of(n) & TEN == 0 {
            self.due[n] = at + self.cycle + self.lag;
        }
    }

    fn publish(&mut self, n: usize, at: Time) {
        let published = (self.of(n) & EN != 0).then_some(self.output[n]);
        if self.published[n] != published {
            self.published[n] = published;
            self.changes.push((at, n, published));
        }
    }
}

impl Device for Dac {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        let [one, two] = self.held.map(u32::from);
        Some(match offset {
            CR => self.cr,
            SWTRGR | SR => 0,
            0x08 => one,
            0x0c => one << 4,
            0x10 => one >> 4,
            0x14 => two,
            0x18 => two << 4,
            0x1c => two >> 4,
            DHR12RD => one | two << 16,
            DHR12LD => one << 4 | two << 20,
            DHR8RD => one >> 4 | two >> 4 << 8,
            DOR1 | DOR2 => self.output[usize::from(offset == DOR2)].into(),
            CCR | MCR => self.others[(offset - CCR) as usize / 4],
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()> {
        let value = self.read(offset, at, out)? & !mask | value & mask;
        match offset {
            CR => {
                self.cr = value;
                if value & (OTHER | OTHER << 16) != 0 {
                    self.complaint.get_or_insert("DAC1 is set to what is not modelled".into());
                }
                (0..2).for_each(|n| self.publish(n, at));
            }
            SWTRGR => {
                for n in 0..2 {
                    if value >> n & 1 != 0 && self.of(n) & (EN | TEN) == EN | TEN {
                        self.due[n] = at + 3 * self.cycle;
                    }
                }
            }
            0x08 => self.hold(0, value, at),
            0x0c => self.hold(0, value >> 4, at),
            0x10 => self.hold(0, value << 4, at),
            0x14 => self.hold(1, value, at),
            0x18 => self.hold(1, value >> 4, at),
            0x1c => self.hold(1, value << 4, at),
            DHR12RD | DHR12LD | DHR8RD => {
                let (one, two) = match offset {
                    DHR12RD => (value, value >> 16),
                    DHR12LD => (value >> 4, value >> 20),
                    _ => (value << 4, value >> 8 << 4),
                };
                // Of eight bits, what lies above is the other channel's.
                self.hold(0, if offset == DHR8RD { one & 0xff0 } else { one }, at);
                self.hold(1, two, at);
            }
            CCR | MCR => {
                self.others[(offset - CCR) as usize / 4] = value;
                if offset == MCR && value & 0x4_0004 != 0 {
                    self.complaint.get_or_insert("DAC1: sample and hold is not modelled".into());
                }
            }
            _ => {}
        }
        Some(())
    }

    fn next(&self) -> Time {
        self.due[0].min(self.due[1])
    }

    fn advance(&mut self, to: Time, _: &mut Vec<Signal>) {
        for n in 0..2 {
            if self.due[n] <= to {
                let at = std::mem::replace(&mut self.due[n], NEVER);
                self.output[n] = self.held[n];
                self.publish(n, at);
            }
        }
    }

    fn reset(&mut self, at: Time, _: &mut Vec<Signal>) {
        let kept = std::mem::take(self);
        *self = Dac {
            published: kept.published,
            cycle: kept.cycle,
            lag: kept.lag,
            changes: kept.changes,
            complaint: kept.complaint,
            ..Dac::default()
        };
        (0..2).for_each(|n| self.publish(n, at));
    }

    fn clocks(&mut self, clocks: &Clocks, _: Time) {
        self.cycle = clocks.apb1;
    }
}
