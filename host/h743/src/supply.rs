//! What lets the core run fast: PWR (RM0433 6), SYSCFG's over-drive (12.3.6) and FLASH's wait
//! states (4.9.1).
//!
//! In: register writes. Out: ready flags after their time, and the fastest core that supply and
//! flash allow.
use crate::device::{Device, Signal};
use crate::time::{MICROSECOND, NEVER, Time};

/// CR1: the backup domain is open.
const DBP: u32 = 1 << 8;
/// CR1: the detector of a low supply, and its level.
const PVDE: u32 = 1 << 4;
const PLS: u32 = 5;
/// Its levels, in mV (RM0433 6.8.1); the last is a voltage at a pin.
const LEVELS_MV: [u32; 7] = [1950, 2100, 2250, 2400, 2550, 2700, 2850];
/// CSR1: the supply is below that.
const PVDO: u32 = 1 << 4;
const CSR1: u32 = 0x04;
const CR3: u32 = 0x0c;
const D3CR: u32 = 0x18;
/// CR3: the supply of USB is looked at, and there.
const USB33DEN: u32 = 1 << 24;
const USB33RDY: u32 = 1 << 26;
const VOSRDY: u32 = 1 << 13;
const ACTVOSRDY: u32 = 1 << 13;

/// Time until a new core voltage is stable.
const VOLTAGE: Time = 20 * MICROSECOND;

/// PWR, with the over-drive bit that SYSCFG holds.
#[derive(Debug, Clone)]
pub struct Pwr {
    cr1: u32,
    cr2: u32,
    cr3: u32,
    cpucr: u32,
    d3cr: u32,
    supply_chosen: bool,
    ready: Time,
    /// SYSCFG_PWRCR.ODEN.
    pub overdrive: bool,
    /// The supply, in mV.
    pub supply_mv: u32,
    /// The voltage at PVD_IN is below that of the reference.
    pub pin_is_low: bool,
    /// SYSCFG keeps PVDE and PLS as they are (RM0433 12.3.5, PVDL).
    pub is_locked: bool,
}

impl Default for Pwr {
    fn default() -> Self {
        Pwr {
            cr1: 0xf000_c000,
            cr2: 0,
            cr3: 6,
            cpucr: 0,
            d3cr: 0x4000,
            supply_chosen: false,
            // The voltage may be changed only once CR3 has been written (RM0433 6.8.4).
            ready: NEVER,
            overdrive: false,
            supply_mv: 3300,
            pin_is_low: false,
            is_locked: false,
        }
    }
}

impl Pwr {
    /// The fastest core in time a cycle (RM0433 table 60; data sheet, general operating
    /// conditions).
    pub fn fastest(&self) -> Time {
        let ready = self.d3cr & VOSRDY != 0;
        match self.d3cr >> 14 & 3 {
            3 if self.overdrive && ready => 2,
            // 400 MHz and 300 MHz, rounded up to what can be counted.
            3 if ready => 3,
            2 if ready => 4,
            _ => 5,
        }
    }

    /// The backup domain may be written: DBP. Read too, here.
    pub fn opens_backup(&self) -> bool {
        self.cr1 & DBP != 0
    }

    /// USB's supply is there: USB33DEN.
    pub fn has_usb(&self) -> bool {
        self.cr3 & USB33DEN != 0
    }

    /// The detector is on, and the supply below its level.
    pub fn is_low(&self) -> bool {
        let level = LEVELS_MV.get((self.cr1 >> PLS & 7) as usize);
        self.cr1 & PVDE != 0 && level.map_or(self.pin_is_low, |level| self.supply_mv < *level)
    }

    /// SYSCFG has switched the over-drive.
    pub fn set_overdrive(&mut self, on: bool, at: Time) {
        if on != self.overdrive {
            self.overdrive = on;
            self.d3cr &= !VOSRDY;
            self.ready = at + VOLTAGE;
        }
    }
}

impl Device for Pwr {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            CSR1 => {
                let low = if self.is_low() { PVDO } else { 0 };
                low | self.d3cr & 3 << 14 | if self.supply_chosen { ACTVOSRDY } else { 0 }
            }
            0x08 => self.cr2,
            CR3 if self.has_usb() => self.cr3 | USB33RDY,
            CR3 => self.cr3,
            0x10 => self.cpucr,
            D3CR => self.d3cr,
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, _: &mut Vec<Signal>) -> Option<()> {
        let new = |before: u32| before & !mask | value & mask;
        match offset {
            0x00 => {
                let kept = if self.is_locked { PVDE | 7 << PLS } else { 0 };
                self.cr1 = self.cr1 & kept | new(self.cr1) & !kept;
            }
            0x08 => self.cr2 = new(self.cr2),
            CR3 => {
                // SCUEN, LDOEN, BYPASS are write-once: only what is written first counts (RM0433
                // 6.8.4).
                let chosen = if self.supply_chosen { 7 } else { 0 };
                self.cr3 = (self.cr3 & chosen | new(self.cr3) & !chosen) & !USB33RDY;
                if !self.supply_chosen {
                    self.supply_chosen = true;
                    self.ready = at + VOLTAGE;
                }
            }
            0x10 => self.cpucr = new(self.cpucr),
            D3CR => {
                self.d3cr = new(self.d3cr) & 3 << 14;
                if self.supply_chosen {
                    self.ready = at + VOLTAGE;
                }
            }
            _ => return None,
        }
        Some(())
    }

    fn next(&self) -> Time {
        self.ready
    }

    fn advance(&mut self, to: Time, _: &mut Vec<Signal>) {
        if self.ready <= to {
            self.ready = NEVER;
            self.d3cr |= VOSRDY;
        }
    }

    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {
        *self = Pwr { supply_mv: self.supply_mv, ..Pwr::default() };
    }
}

/// FLASH, as far as wait states go.
#[derive(Debug, Clone)]
pub struct Flash {
    acr: u32,
}

impl Default for Flash {
    fn default() -> Self {
        Flash { acr: 0x37 }
    }
}

impl Flash {
    /// Wait states (LATENCY).
    pub fn wait_states(&self) -> u32 {
        self.acr & 0xf
    }

    /// The fastest AXI clock that the wait states allow at the voltage of VOS0 and VOS1 (RM0433
    /// table 17), as time a cycle.
    pub fn fastest_bus(&self) -> Time {
        match (self.wait_states(), self.acr >> 4 & 3) {
            (0, _) => 14,
            (1, _) => 7,
            (2, _) => 6,
            (3, delay) if delay >= 2 => 5,
            (4.., delay) if delay >= 2 => 4,
            _ => 6,
        }
    }
}

impl Device for Flash {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        (offset == 0).then_some(self.acr)
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, _: Time, _: &mut Vec<Signal>) -> Option<()> {
        (offset == 0).then(|| self.acr = self.acr & !mask | value & mask & 0x3f)
    }

    fn next(&self) -> Time {
        NEVER
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Signal>) {}

    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {
        *self = Flash::default();
    }
}

/// Sources of breaks: a low supply, a locked-up core.
const CFGR: u32 = 0x18;
const PVDL: u32 = 1 << 2;
const CM7L: u32 = 1 << 6;
/// The package (RM0433 12.3.13).
const PKGR: u32 = 0x124;

/// SYSCFG: the over-drive and the I/O compensation cell.
#[derive(Debug, Clone, Default)]
pub struct Syscfg {
    /// PWRCR.
    pub pwrcr: u32,
    /// CFGR lies elsewhere.
    pub lacks_cfgr: bool,
    /// A core that is locked up breaks nothing.
    pub lacks_lock_up: bool,
    /// PKGR.
    pub package: u32,
    others: [u32; 12],
}

impl Syscfg {
    /// Whether the detector of a low supply cannot be changed any more.
    pub fn locks_detector(&self) -> bool {
        self.others[CFGR as usize / 4] & PVDL != 0
    }

    /// Whether the timers break: these states of the chip, as far as CFGR leads them there.
    pub fn breaks(&self, supply_is_low: bool, is_locked_up: bool) -> bool {
        let led = self.others[CFGR as usize / 4];
        supply_is_low && led & PVDL != 0 || is_locked_up && led & CM7L != 0 && !self.lacks_lock_up
    }
}

impl Device for Syscfg {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        match offset {
            0x2c => Some(self.pwrcr),
            PKGR => Some(self.package),
            // CCCSR: the cell is ready where it is on.
            0x20 => Some(self.others[8] & 0x101 | (self.others[8] & 1) << 8),
            _ => self.others.get(offset as usize / 4).copied(),
        }
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, _: Time, _: &mut Vec<Signal>) -> Option<()> {
        if offset == CFGR && self.lacks_cfgr {
            return Some(());
        }
        let place = if offset == 0x2c { &mut self.pwrcr } else { self.others.get_mut(offset as usize / 4)? };
        *place = *place & !mask | value & mask;
        Some(())
    }

    fn next(&self) -> Time {
        NEVER
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Signal>) {}

    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {
        let Syscfg { lacks_cfgr, lacks_lock_up, package, .. } = *self;
        *self = Syscfg { lacks_cfgr, lacks_lock_up, package, ..Syscfg::default() };
    }
}

/// Which chip it is (RM0433 60.5.8), and what a debugger stops.
#[derive(Debug, Clone)]
pub struct Dbgmcu {
    /// The chip: 0x450 is the STM32H743.
    pub device: u16,
    /// Revision: 0x2003 is V.
    pub revision: u16,
    /// The watchdog goes on under a debugger.
    pub never_freezes: bool,
    others: [u32; 24],
}

impl Default for Dbgmcu {
    fn default() -> Self {
        Dbgmcu { device: 0x450, revision: 0x2003, never_freezes: false, others: [0; 24] }
    }
}

impl Dbgmcu {
    /// Whether the watchdog stands while a debugger halts the core: APB4FZ1.WDGLSD1 (RM0433
    /// 60.5.8).
    pub fn freezes_watchdog(&self) -> bool {
        const APB4FZ1: usize = 0x54;
        self.others[APB4FZ1 / 4] & 1 << 18 != 0 && !self.never_freezes
    }
}

impl Device for Dbgmcu {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        match offset {
            0 => Some(u32::from(self.revision) << 16 | u32::from(self.device)),
            _ => self.others.get(offset as usize / 4).copied(),
        }
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, _: Time, _: &mut Vec<Signal>) -> Option<()> {
        let place = self.others.get_mut(offset as usize / 4).filter(|_| offset != 0)?;
        *place = *place & !mask | value & mask;
        Some(())
    }

    fn next(&self) -> Time {
        NEVER
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Signal>) {}

    /// Only power-on resets it (RM0433 60.5.8).
    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {}
}
