//! Reset and clock control, RCC (RM0433 8): which clock runs how fast, and what has one.
//!
//! In: register writes. Out: [`Clocks`], which peripherals have a clock, why the last reset came.
//! Ready flags follow their switches after a time of the order of the data sheet's. Settings that
//! the manual forbids are refused with a sentence ([`Rcc::complaint`]): a VCO outside of its range,
//! a core faster than the supply allows.
use crate::board::{Board, NUCLEO};
use crate::device::{Cause, Device, Signal};
use crate::time::{MICROSECOND, NEVER, Time};

/// Time that a cycle of each clock takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// The core.
    pub core: Time,
    /// AXI and AHB.
    pub bus: Time,
    /// APB 1.
    pub apb1: Time,
    /// APB 2.
    pub apb2: Time,
    /// Timers on APB 1.
    pub timers1: Time,
    /// Timers on APB 2.
    pub timers2: Time,
    /// Kernel clock of SPI 1 to 3, if what it is taken from runs.
    pub spi: Option<Time>,
    /// Kernel clock of the ADCs, likewise.
    pub adc: Option<Time>,
    /// Kernel clock of USB.
    pub usb: Option<Time>,
    /// 1000 cycles of what MCO1 gives.
    pub mco1: Option<Time>,
}

/// 64 MHz, as the chip starts.
const HSI: Time = 15;
/// Of the chip's own oscillators, in kHz.
const HSI_KHZ: u64 = 64_000;
const CSI_KHZ: u64 = 4_000;
/// A second is so many thousands of units of time.
const UNITS_KHZ: u64 = 960_000;

impl Clocks {
    /// Of a chip that has just started.
    pub const RESET: Clocks = Clocks {
        core: HSI,
        bus: HSI,
        apb1: HSI,
        apb2: HSI,
        timers1: HSI,
        timers2: HSI,
        spi: None,
        adc: None,
        usb: None,
        mco1: None,
    };
}

const CR: u32 = 0x00;
const CFGR: u32 = 0x10;
const D1CFGR: u32 = 0x18;
const D2CFGR: u32 = 0x1c;
const D1CCIPR: u32 = 0x4c;
const D2CCIP1R: u32 = 0x50;
const D2CCIP2R: u32 = 0x54;
const D3CCIPR: u32 = 0x58;
const PLLCKSELR: u32 = 0x28;
const PLLCFGR: u32 = 0x2c;
const PLL1DIVR: u32 = 0x30;
const CIFR: u32 = 0x64;
/// Of the backup domain: no reset of the chip reaches it (RM0433 8.4.5).
const BDCR: u32 = 0x70;
const CSR: u32 = 0x74;
const RSR: u32 = 0xd0;
/// AHB2ENR, where the memories of domain D2 have their clocks.
pub const AHB2ENR: u32 = 0xdc;
/// AHB4ENR: domain D3, among others its backup SRAM.
pub const AHB4ENR: u32 = 0xe0;
/// Enable registers, AHB3 to APB4.
const ENABLES: std::ops::RangeInclusive<u32> = 0xd4..=0xf4;
/// AHB1ENR, of the DMAs.
pub const AHB1ENR: u32 = 0xd8;
/// Reset registers lie this much before the enable registers.
pub const RESET_BEFORE_ENABLE: u32 = 0x58;

const HSI_ON: u32 = 1 << 0;
const HSI_READY: u32 = 1 << 2;
/// The switches of CR and their ready flags, with the time that they take.
const SOURCES: [(u32, u32, Time); 6] = [
    (HSI_ON, HSI_READY, 4 * MICROSECOND),
    (1 << 7, 1 << 8, 4 * MICROSECOND),
    (1 << 12, 1 << 13, 10 * MICROSECOND),
    (1 << 16, 1 << 17, 100 * MICROSECOND),
    (1 << 24, 1 << 25, 100 * MICROSECOND),
    (1 << 26, 1 << 27, 100 * MICROSECOND),
];
const PLL1_READY: u32 = 1 << 25;
const HSI48_READY: u32 = 1 << 13;
/// HSE among [`SOURCES`], its bits, and its guard (CSS).
const HSE_SOURCE: usize = 3;
const HSE_ON: u32 = 1 << 16;
const HSE_READY: u32 = 1 << 17;
const HSE_BYPASS: u32 = 1 << 18;
const HSE_GUARD: u32 = 1 << 19;

/// See the module text.
#[derive(Debug, Clone)]
pub struct Rcc {
    registers: [u32; 0x60],
    /// When each source becomes ready.
    ready: [Time; SOURCES.len()],
    lsi_ready: Time,
    clocks: Clocks,
    /// What is at the oscillator's pins, and whether it runs.
    board: Board,
    source: bool,
    /// By how much HSI48 is slow.
    pub hsi48_slow_percent: Time,
    /// Timers of APB 1 count half as fast.
    pub halves_timers: bool,
    /// The kernel of SPI 1 to 3 has half its clock.
    pub halves_spi: bool,
    /// The fastest core that the supply allows, as time a cycle; set by the machine from PWR.
    pub fastest: Time,
    /// What was set against the manual.
    pub complaint: Option<String>,
}

impl Default for Rcc {
    fn default() -> Self {
        let mut rcc = Rcc {
            registers: [0; 0x60],
            ready: [NEVER; SOURCES.len()],
            lsi_ready: NEVER,
            clocks: Clocks::RESET,
            board: NUCLEO,
            source: true,
            hsi48_slow_percent: 0,
            halves_timers: false,
            halves_spi: false,
            fastest: 0,
            complaint: None,
        };
        rcc.initial();
        rcc.restarted(Cause::Power);
        rcc
    }
}

impl Rcc {
    fn initial(&mut self) {
        let kept = [RSR, BDCR].map(|offset| (offset, self.at(offset)));
        self.registers = [0; 0x60];
        kept.into_iter().for_each(|(offset, value)| *self.place(offset) = value);
        *self.place(CR) = HSI_ON | HSI_READY;
        // HSICFGR, CSICFGR, PLLCKSELR, PLLCFGR and the dividers (RM0433 8.7).
        *self.place(0x04) = 0x4000_0000;
        *self.place(0x0c) = 0x2000_0000;
        *self.place(PLLCKSELR) = 0x0202_0200;
        *self.place(PLLCFGR) = 0x01ff_0000;
        for divider in [PLL1DIVR, 0x38, 0x40] {
            *self.place(divider) = 0x0101_0280;
        }
        *self.place(0xd4) = 0;
        self.ready = [NEVER; SOURCES.len()];
        self.lsi_ready = NEVER;
        self.clocks = Clocks::RESET;
    }

    /// The chip is on this board from now on.
    pub fn mount(&mut self, board: Board) {
        self.board = board;
    }

    /// Whether the oscillator is set to what is at its pins, and that runs.
    fn has_source(&self) -> bool {
        self.source && self.board.has_crystal == (self.at(CR) & HSE_BYPASS == 0)
    }

    /// Frequency of a source of the PLLs, or of the system: HSI, CSI, HSE.
    fn khz(&self, source: u32) -> Option<u64> {
        [HSI_KHZ >> (self.at(CR) >> 3 & 3), CSI_KHZ, self.board.source_khz].get(source as usize).copied()
    }

    /// Notes a reset (RM0433 table 55).
    pub fn restarted(&mut self, cause: Cause) {
        // CPURST and PINRST come with each of them.
        let flags = match cause {
            Cause::Power => 0x00fa_0000,
            Cause::Pin => 1 << 22 | 1 << 17,
            Cause::Software => 1 << 24 | 1 << 22 | 1 << 17,
            Cause::Watchdog => 1 << 26 | 1 << 22 | 1 << 17,
        };
        *self.place(RSR) |= flags;
    }

    fn at(&self, offset: u32) -> u32 {
        self.registers.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn place(&mut self, offset: u32) -> &mut u32 {
        &mut self.registers[offset as usize / 4]
    }

    /// The source starts or stops. True if the clock security system has noticed a stop
    /// (RM0433 8.5.3): then the chip runs on its own clock, without HSE and the PLL that it fed.
    pub fn give(&mut self, source: bool, at: Time) -> bool {
        let was = std::mem::replace(&mut self.source, source);
        let cr = self.at(CR);
        if source {
            if !was && cr & HSE_ON != 0 && self.has_source() {
                self.ready[HSE_SOURCE] = at + SOURCES[HSE_SOURCE].2;
            }
            return false;
        }
        self.ready[HSE_SOURCE] = NEVER;
        if cr & HSE_GUARD == 0 || cr & HSE_READY == 0 {
            *self.place(CR) &= !HSE_READY;
            if cr & HSE_READY != 0 {
                self.complain("the core's clock stops, and nothing guards it".into());
            }
            return false;
        }
        *self.place(CR) &= !(HSE_ON | HSE_READY | 1 << 24 | PLL1_READY);
        *self.place(CFGR) &= !0x3f;
        *self.place(CIFR) |= 1 << 10;
        self.derive();
        true
    }

    /// The clocks in force.
    pub fn now(&self) -> Clocks {
        self.clocks
    }

    /// Whether the bit of an enable register is set.
    pub fn is_on(&self, enable: u32, bit: u32) -> bool {
        self.at(enable) & 1 << bit != 0
    }

    /// Whether the bit of the matching reset register is set.
    pub fn is_reset(&self, enable: u32, bit: u32) -> bool {
        self.at(enable - RESET_BEFORE_ENABLE) & 1 << bit != 0
    }

    fn complain(&mut self, what: String) {
        self.complaint.get_or_insert(what);
    }

    /// Bits of PLLCKSELR that hardware does not let change: DIVMx of a PLL that is on, PLLSRC while
    /// one is (RM0433 8.7.11).
    fn held_by_plls(&self) -> u32 {
        let of = |pll: u32| if self.at(CR) & 3 << (24 + 2 * pll) == 0 { 0 } else { 0x3f << (4 + 8 * pll) | 3 };
        of(0) | of(1) | of(2)
    }

    /// Time a cycle of PLL1's P output takes.
    fn pll1(&mut self) -> Option<Time> {
        let (source, configuration, dividers) = (self.at(PLLCKSELR), self.at(PLLCFGR), self.at(PLL1DIVR));
        let input_khz = self.khz(source & 3)?;
        let m = u64::from(source >> 4 & 0x3f);
        let n = u64::from(dividers & 0x1ff) + 1;
        let p = u64::from(dividers >> 9 & 0x7f) + 1;
        // In kHz: reference and VCO, and the ranges that are set for them.
        let reference_khz = input_khz.checked_div(m)?;
        let vco_khz = reference_khz * n;
        let range =
            [1_000..=2_000, 2_000..=4_000, 4_000..=8_000, 8_000..=16_000][(configuration >> 2 & 3) as usize].clone();
        if !range.contains(&reference_khz) {
            self.complain(format!("PLL1's reference of {reference_khz} kHz is outside of PLL1RGE ({range:?} kHz)"));
        }
        let vco = if configuration & 2 == 0 { 192_000..=960_000 } else { 150_000..=420_000 };
        if !vco.contains(&vco_khz) {
            self.complain(format!("PLL1's VCO would run at {vco_khz} kHz, outside of {vco:?}"));
        }
        if configuration & 1 << 16 == 0 {
            self.complain("the core takes PLL1 P, which is off (DIVP1EN)".into());
        }
        let (top, speed) = (UNITS_KHZ * m * p, input_khz * n);
        let cycle = top / speed;
        if cycle * speed != top {
            self.complain(format!("{vco_khz} kHz / {p} is no clock that the emulation can count"));
        }
        Some(cycle.max(1))
    }

    /// PLL1's Q output, if it runs.
    fn pll1_q(&self) -> Option<Time> {
        if self.at(CR) & PLL1_READY == 0 || self.at(PLLCFGR) & 1 << 17 == 0 {
            return None;
        }
        let input_khz = self.khz(self.at(PLLCKSELR) & 3)?;
        let (dividers, m) = (self.at(PLL1DIVR), u64::from(self.at(PLLCKSELR) >> 4 & 0x3f));
        let (n, q) = (u64::from(dividers & 0x1ff) + 1, u64::from(dividers >> 16 & 0x7f) + 1);
        Some(UNITS_KHZ * m * q / (input_khz * n)).filter(|&cycle| cycle > 0)
    }

    /// Kernel clock of USB (D2CCIP2R.USBSEL): PLL1's Q output, or HSI48; PLL3 is not modelled.
    fn usb(&self) -> Option<Time> {
        match self.at(D2CCIP2R) >> 20 & 3 {
            1 => self.pll1_q(),
            3 => (self.at(CR) & HSI48_READY != 0).then_some(20),
            _ => None,
        }
    }

    /// MCO1 (CFGR.MCO1SEL, MCO1PRE): HSI48 only; none of the others is modelled.
    fn mco1(&self) -> Option<Time> {
        const HSI48: u32 = 4;
        let (source, divider) = (self.at(CFGR) >> 22 & 7, Time::from(self.at(CFGR) >> 18 & 0xf));
        let runs = source == HSI48 && divider > 0 && self.at(CR) & HSI48_READY != 0;
        runs.then(|| divider * (20_000 + 200 * self.hsi48_slow_percent))
    }

    /// Kernel clock of SPI 1 to 3 (D2CCIP1R.SPI123SEL): PLL1's Q output, or per_ck.
    fn spi(&self) -> Option<Time> {
        let source = match self.at(D2CCIP1R) >> 12 & 7 {
            0 => self.pll1_q(),
            4 => self.per(),
            _ => None,
        };
        source.map(|period| period << u32::from(self.halves_spi))
    }

    /// per_ck (D1CCIPR.CKPERSEL).
    fn per(&self) -> Option<Time> {
        self.khz(self.at(D1CCIPR) >> 28 & 3).map(|khz| UNITS_KHZ / khz)
    }

    /// Kernel clock of the ADCs (D3CCIPR.ADCSEL): per_ck only; PLL2 and PLL3 are not modelled.
    fn adc(&self) -> Option<Time> {
        if self.at(D3CCIPR) >> 16 & 3 == 2 { self.per() } else { None }
    }

    /// Works out the clocks anew. Sources that do not run leave them as they were.
    fn derive(&mut self) {
        let system = match self.at(CFGR) & 7 {
            source @ 0..=2 => self.khz(source).map(|khz| UNITS_KHZ / khz),
            3 if self.at(CR) & PLL1_READY != 0 => self.pll1(),
            _ => None,
        };
        let Some(system) = system else {
            self.complain("the core was switched to a clock that is not ready".into());
            return;
        };
        let (d1, d2) = (self.at(D1CFGR), self.at(D2CFGR));
        let core = system * prescaler(d1 >> 8);
        let bus = core * prescaler(d1);
        let apb = |field: u32| if field & 4 == 0 { 1 } else { 2 << (field & 3) };
        let (apb1, apb2) = (apb(d2 >> 4), apb(d2 >> 8));
        // RM0433 table 56: up to /2, timers run at the bus; slower buses give half of it, or a
        // quarter with TIMPRE.
        let timpre = self.at(CFGR) & 1 << 15 != 0;
        let timers = |divider: u64| bus * if timpre { (divider / 4).max(1) } else { (divider / 2).max(1) };
        let (timers1, timers2) = (timers(apb1) << u32::from(self.halves_timers), timers(apb2));
        let (spi, adc, usb, mco1) = (self.spi(), self.adc(), self.usb(), self.mco1());
        self.clocks = Clocks { core, bus, apb1: bus * apb1, apb2: bus * apb2, timers1, timers2, spi, adc, usb, mco1 };
        if core < self.fastest {
            self.complain(format!("the core runs at {} MHz, which its supply does not allow", 960 / core));
        }
        if bus < 4 || self.clocks.apb1 < 8 || self.clocks.apb2 < 8 {
            self.complain("a bus runs faster than 240 MHz, or a peripheral bus faster than 120 MHz".into());
        }
    }
}

/// D1CPRE and HPRE.
fn prescaler(field: u32) -> u64 {
    match field & 0xf {
        low if low < 8 => 1,
        field @ 8..=11 => 2 << (field - 8),
        field => 64 << (field - 12),
    }
}

impl Device for Rcc {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        // The second set, RCC_C1, shows the same registers.
        let offset = if offset >= 0x130 { offset - 0x60 } else { offset };
        (offset < 0x180).then(|| self.at(offset))
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, _: &mut Vec<Signal>) -> Option<()> {
        let offset = if offset >= 0x130 { offset - 0x60 } else { offset };
        if offset >= 0x180 {
            return None;
        }
        let before = self.at(offset);
        let value = before & !mask | value & mask;
        match offset {
            CR => {
                let mut flags = before;
                for (n, (on, ready, time)) in SOURCES.into_iter().enumerate() {
                    flags = flags & !on | value & on;
                    if value & on == 0 {
                        flags &= !ready;
                        self.ready[n] = NEVER;
                    } else if before & on == 0 {
                        self.ready[n] = at + time;
                    }
                }
                let flagged = SOURCES.iter().fold(0, |all, (on, ready, _)| all | on | ready);
                // HSI's divider: its flag says at once that it is there.
                *self.place(CR) = flags & flagged | value & !flagged | 1 << 5;
                if !self.has_source() {
                    self.ready[HSE_SOURCE] = NEVER;
                }
                self.derive();
            }
            CFGR => {
                *self.place(CFGR) = value & !(7 << 3) | (value & 7) << 3;
                self.derive();
            }
            D1CFGR | D2CFGR | D1CCIPR | D2CCIP1R | D2CCIP2R | D3CCIPR => {
                *self.place(offset) = value;
                self.derive();
            }
            PLLCKSELR | PLLCFGR | PLL1DIVR => {
                if self.at(CR) & 1 << 24 != 0 && value != before && offset != PLLCFGR {
                    self.complain("PLL1 was changed while it runs".into());
                }
                let held = if offset == PLLCKSELR { self.held_by_plls() } else { 0 };
                *self.place(offset) = before & held | value & !held;
            }
            CSR => {
                self.lsi_ready = if value & 1 == 0 { NEVER } else { at + 80 * MICROSECOND };
                *self.place(CSR) = value & 1;
            }
            RSR => {
                if value & 1 << 16 != 0 {
                    *self.place(RSR) = 0;
                }
            }
            offset if ENABLES.contains(&offset) => *self.place(offset) = value,
            _ => *self.place(offset) = value,
        }
        Some(())
    }

    fn next(&self) -> Time {
        self.ready.iter().copied().min().unwrap_or(NEVER).min(self.lsi_ready)
    }

    fn advance(&mut self, to: Time, _: &mut Vec<Signal>) {
        for (n, (_, ready, _)) in SOURCES.into_iter().enumerate() {
            if self.ready[n] <= to {
                self.ready[n] = NEVER;
                *self.place(CR) |= ready;
                (self.clocks.spi, self.clocks.usb) = (self.spi(), self.usb());
            }
        }
        if self.lsi_ready <= to {
            self.lsi_ready = NEVER;
            *self.place(CSR) |= 1 << 1;
        }
    }

    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {
        self.initial();
    }
}
