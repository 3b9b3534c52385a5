//! The independent watchdog, IWDG1 (RM0433 44).
//!
//! In: keys, prescaler, reload value. Out: a reset, when it was not fed in time. Owns its
//! registers. Fails never. It runs by LSI, 32 kHz; once started, only a reset stops it. An update
//! of a register takes effect at once here; the status register shows it in progress for a while.
use crate::device::{Cause, Device, Signal};
use crate::time::{NEVER, Time};

const KR: u32 = 0x00;
const PR: u32 = 0x04;
const RLR: u32 = 0x08;
const SR: u32 = 0x0c;
const WINR: u32 = 0x10;

/// A cycle of LSI.
pub const LSI: Time = 30_000;

/// See the module text.
#[derive(Debug, Clone)]
pub struct Watchdog {
    unlocked: bool,
    prescaler: u32,
    reload: u32,
    window: u32,
    bites: Time,
    /// Updates are in progress until then.
    busy: Time,
    /// LSI is so much slower.
    pub slow_percent: Time,
}

impl Default for Watchdog {
    fn default() -> Self {
        Watchdog { unlocked: false, prescaler: 0, reload: 0xfff, window: 0xfff, bites: NEVER, busy: 0, slow_percent: 0 }
    }
}

impl Watchdog {
    /// From a feeding to the bite.
    pub fn time(&self) -> Time {
        let divider = 4 << self.prescaler.min(6);
        LSI * (100 + self.slow_percent) / 100 * divider * (Time::from(self.reload) + 1)
    }

    /// A debugger has frozen it for so long.
    pub fn shift_by_freeze(&mut self, time: Time) {
        if self.is_running() {
            self.bites += time;
        }
    }

    /// Whether it has been started.
    pub fn is_running(&self) -> bool {
        self.bites != NEVER
    }
}

impl Device for Watchdog {
    fn read(&mut self, offset: u32, at: Time, _: &mut Vec<Signal>) -> Option<u32> {
        Some(match offset {
            KR => 0,
            PR => self.prescaler,
            RLR => self.reload,
            SR => u32::from(at < self.busy) * 3,
            WINR => self.window,
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, _: u32, at: Time, _: &mut Vec<Signal>) -> Option<()> {
        match (offset, value) {
            (KR, 0x5555) => self.unlocked = true,
            (KR, 0xaaaa) => {
                self.unlocked = false;
                if self.is_running() {
                    self.bites = at + self.time();
                }
            }
            (KR, 0xcccc) => {
                self.unlocked = false;
                self.bites = at + self.time();
            }
            (KR, _) => self.unlocked = false,
            (PR, _) if self.unlocked => self.prescaler = value & 7,
            (RLR, _) if self.unlocked => self.reload = value & 0xfff,
            (WINR, _) if self.unlocked => self.window = value & 0xfff,
            (PR | RLR | WINR | SR, _) => {}
            _ => return None,
        }
        if matches!(offset, PR | RLR | WINR) {
            // Five cycles of the prescaled clock (RM0433 44.4.4).
            self.busy = at + 5 * 4 * LSI;
        }
        Some(())
    }

    fn next(&self) -> Time {
        self.bites
    }

    fn advance(&mut self, to: Time, out: &mut Vec<Signal>) {
        if self.bites <= to {
            self.bites = NEVER;
            out.push(Signal::Reset(Cause::Watchdog));
        }
    }

    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {
        *self = Watchdog { slow_percent: self.slow_percent, ..Watchdog::default() };
    }
}
