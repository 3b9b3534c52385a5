//! The core's cycle counter (Armv7-M Architecture Reference Manual, C1.8) and the switch before it.
//!
//! In: DEMCR, DWT_CTRL, DWT_CYCCNT, time. Out: cycles of the core. Owns these registers. An
//! instruction is a cycle here, so a count is that of an ideal core. Fails: other registers are
//! `None`.
use crate::time::Time;

const DEMCR: u32 = 0xe000_edfc;
const CTRL: u32 = 0xe000_1000;
const CYCCNT: u32 = 0xe000_1004;
/// Lock access, and its status: CoreSight's, unlocked here.
const LAR: u32 = 0xe000_1fb0;
const LSR: u32 = 0xe000_1fb4;
const TRCENA: u32 = 1 << 24;
/// Four comparators.
const COMPARATORS: u32 = 4 << 28;

/// See the module text.
#[derive(Debug, Clone, Default)]
pub struct Dwt {
    demcr: u32,
    ctrl: u32,
    /// Count at `since`.
    held: u32,
    since: Time,
}

impl Dwt {
    fn counts(&self) -> bool {
        self.demcr & TRCENA != 0 && self.ctrl & 1 != 0
    }

    fn count(&self, at: Time, cycle: Time) -> u32 {
        let more = if self.counts() { (at - self.since) / cycle.max(1) } else { 0 };
        self.held.wrapping_add(more as u32)
    }

    /// A read; `None` for other registers.
    pub fn read(&self, address: u32, at: Time, cycle: Time) -> Option<u32> {
        Some(match address {
            DEMCR => self.demcr,
            CTRL => COMPARATORS | self.ctrl,
            CYCCNT => self.count(at, cycle),
            LSR => 0,
            _ => return None,
        })
    }

    /// A write; `None` for other registers.
    pub fn write(&mut self, address: u32, value: u32, at: Time, cycle: Time) -> Option<()> {
        (self.held, self.since) = (self.count(at, cycle), at);
        match address {
            DEMCR => self.demcr = value,
            CTRL => self.ctrl = value & 1,
            CYCCNT => self.held = value,
            LAR => {}
            _ => return None,
        }
        Some(())
    }
}
