//! What registers alone show: as the reset left them, and as start-up has set them.
//!
//! In: registers. Out: lines. Owns the registers of the timers before start-up does, and leaves
//! them as a reset would.
use crate::report::Report;
use hal::stm32h743::pins::PinLevels;
use stm32_metapac::gpio::vals::{Idr, Moder, Pupdr};
use stm32_metapac::timer::TimAdv;
use stm32_metapac::{
    DBGMCU, DMA1, GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF, GPIOG, PWR, RCC, SYSCFG, TIM1, TIM2, TIM8,
};

/// TIM15: its registers that are used here are those of TIM1 (RM0433 41.5).
// SAFETY: its address.
pub const TIM15: TimAdv = unsafe { TimAdv::from_ptr(stm32_metapac::TIM15.as_ptr()) };
/// The lasers' timers with their numbers, in the order of the interlock's pins.
pub const LASERS: [(i64, TimAdv); 3] = [(1, TIM1), (15, TIM15), (8, TIM8)];
/// The chip's unique number (RM0433 61.1).
const UNIQUE: *const u32 = 0x1ff1_e800 as *const u32;
/// The stream of DMA1 that receives from the link.
const RECEIVING: usize = 2;
/// Offset of SYSCFG_CFGR, which the metadata leaves out.
pub const SYSCFG_CFGR: usize = 0x18;

/// What only the first instructions can read.
pub struct AtReset {
    modes: [u32; 7],
    pulls: [u32; 7],
    af1: [u32; 3],
    widths: [[u32; 3]; 3],
    tick: u32,
}

impl AtReset {
    /// Reads it, before start-up.
    pub fn read() -> AtReset {
        RCC.ahb4enr().modify(|w| {
            w.set_gpioaen(true);
            w.set_gpioben(true);
            w.set_gpiocen(true);
            w.set_gpioden(true);
            w.set_gpioeen(true);
            w.set_gpiofen(true);
            w.set_gpiogen(true);
        });
        RCC.apb2enr().modify(|w| {
            w.set_tim1en(true);
            w.set_tim8en(true);
            w.set_tim15en(true);
        });
        RCC.apb1lenr().modify(|w| w.set_tim2en(true));
        // Read back, so that the clocks are on (RM0433 8.5.8).
        RCC.ahb4enr().read();
        RCC.apb2enr().read();
        RCC.apb1lenr().read();
        let ports = [GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF, GPIOG];
        let af1 = LASERS.map(|(_, timer)| timer.af1().read().0);
        let widths = LASERS.map(|(_, timer)| {
            timer.arr().write(|w| w.0 = u32::MAX);
            timer.rcr().write(|w| w.0 = u32::MAX);
            timer.ccr(0).write(|w| w.0 = u32::MAX);
            [timer.arr().read().0, timer.rcr().read().0, timer.ccr(0).read().0]
        });
        TIM2.arr().write_value(u32::MAX);
        let tick = TIM2.arr().read();
        reset_timers();
        AtReset {
            modes: ports.map(|port| port.moder().read().0),
            pulls: ports.map(|port| port.pupdr().read().0),
            af1,
            widths,
            tick,
        }
    }

    /// Reports it.
    pub fn report_to(&self, report: &mut Report) {
        report.line("modes-at-reset", &self.modes.map(i64::from));
        report.line("pulls-at-reset", &self.pulls.map(i64::from));
        for (((number, _), af1), widths) in LASERS.into_iter().zip(self.af1).zip(self.widths) {
            report.line("af1-at-reset", &[number, af1.into()]);
            let [arr, rcr, ccr] = widths.map(i64::from);
            report.line("widths", &[number, arr, rcr, ccr]);
        }
        report.line("tick-width", &[self.tick.into()]);
    }
}

fn reset_timers() {
    for on in [true, false] {
        RCC.apb2rstr().modify(|w| {
            w.set_tim1rst(on);
            w.set_tim8rst(on);
            w.set_tim15rst(on);
        });
        RCC.apb1lrstr().modify(|w| w.set_tim2rst(on));
    }
    RCC.apb1lrstr().read();
}

/// After start-up.
pub fn report_to(report: &mut Report) {
    // SAFETY: system memory, which is always there.
    let unique = [0, 1, 2].map(|n| i64::from(unsafe { UNIQUE.add(n).read_volatile() }));
    report.line("unique", &unique);
    let idc = DBGMCU.idc().read();
    report.line("idc", &[idc.dev_id().into(), idc.rev_id().into()]);
    report.line("package", &[SYSCFG.pkgr().read().pkg().into()]);
    let stream = DMA1.st(RECEIVING).cr().read();
    report.line("receiving", &[stream.en().into(), stream.trbuff().into()]);
    report.line("frozen", &[DBGMCU.apb4fzr1().read().iwdg1().into()]);
    // SAFETY: the register is there; the databases lack it.
    let breaks = unsafe { SYSCFG.as_ptr().cast::<u8>().add(SYSCFG_CFGR).cast::<u32>().read_volatile() };
    report.line("break-sources", &[breaks.into()]);
    let supply = PWR.cr1().read();
    report.line("supply", &[supply.pvde().into(), supply.pls().into(), PWR.csr1().read().pvdo().into()]);
    for (number, timer) in LASERS {
        report.line("af1", &[number, timer.af1().read().0.into()]);
        report.line("bdtr", &[number, timer.bdtr().read().0.into()]);
    }
}

/// The level of VBUS at the connector of USB, while PD10 keeps its switch off.
pub fn five_volts(report: &mut Report) {
    const VBUS: usize = 9;
    // No pull: the line may have 5 V.
    GPIOA.pupdr().modify(|w| w.set_pupdr(VBUS, Pupdr::FLOATING));
    GPIOA.moder().modify(|w| w.set_moder(VBUS, Moder::INPUT));
    cortex_m::asm::delay(4_800);
    report.line("vbus", &[(GPIOA.idr().read().idr(VBUS) == Idr::HIGH).into()]);
}

/// Level of each break input, its flag once it was cleared, and whether the main output can be
/// enabled. No channel has light then, so the lines stay dark.
pub fn breaks_now(report: &mut Report) {
    let levels = PinLevels::read().breaks();
    for ((number, timer), level) in LASERS.into_iter().zip(levels) {
        timer.sr().write(|w| {
            w.0 = !0;
            w.set_bif(0, false);
            // That of a break of the chip keeps MOE at 0 (RM0433 38.4.5).
            w.set_sbif(false);
        });
        // The input passes a synchronizer.
        cortex_m::asm::delay(64);
        let flag = timer.sr().read().bif(0);
        timer.bdtr().modify(|w| w.set_moe(true));
        cortex_m::asm::delay(64);
        let enabled = timer.bdtr().read().moe();
        timer.bdtr().modify(|w| w.set_moe(false));
        report.line("break", &[number, level.into(), flag.into(), enabled.into()]);
    }
}
