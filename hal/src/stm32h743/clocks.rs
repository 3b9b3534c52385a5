//! Clocks: 480 MHz from the board's source (RM0433 6.6, 8.5; docs/board-h743-registers.md,
//! "Clocks").
//!
//! In: the chip on its own 64 MHz. Out: [`CORE_HZ`] and the clocks derived from it. Owns PWR, the
//! flash's wait states and RCC's clock tree. Fails: a flag that does not come in time is left to
//! the watchdog, which runs by then and resets. When the source stops later, the hardware
//! breaks the laser outputs, and the NMI ends in the fault path ([`CLOCK_LOST`]).
use super::boards::BOARD;
use super::wiring::{Source, VCO_MHZ};
use stm32_metapac::rcc::vals::{Hpre, Plldiv, Pllm, Plln, Pllrge, Pllsrc, Pllvcosel, Ppre, Sw, Usbsel};
use stm32_metapac::{DBGMCU, FLASH, PWR, RCC, SYSCFG, pwr};

/// The core.
pub const CORE_HZ: u32 = 480_000_000;
/// APB 1 to 4.
pub const BUS_HZ: u32 = CORE_HZ / 4;
/// Timers on APB 1 and 2.
pub const TIMER_MHZ: u16 = 240;

/// Reason of the NMI: nothing else makes one (RM0433 8.5.3).
pub const CLOCK_LOST: &str = BOARD.source.lost;

/// Waits without limit; the watchdog resets the chip if that takes too long.
fn wait(mut is_ready: impl FnMut() -> bool) {
    while !is_ready() {}
}

/// Waits for the source without limit: a clock from elsewhere may be powered, or start, later than
/// the chip. No output is driven yet, so this needs no watchdog.
pub fn await_source() {
    RCC.cr().modify(|w| w.set_hsebyp(!BOARD.source.is_crystal));
    RCC.cr().modify(|w| w.set_hseon(true));
    wait(|| RCC.cr().read().hserdy());
}

/// STM32H742, H743, H753 and H750 (RM0433 60.5.8); the H745 and the H747 have it too.
const DEVICE: u16 = 0x450;
/// X and V. The first ones, Z and Y, reach neither VOS0 nor [`CORE_HZ`] (RM0433 60.5.8, ES0392).
const REVISIONS: [u16; 2] = [0x2001, 0x2003];

/// Whether the image may run on this chip.
pub fn is_fit() -> bool {
    let code = DBGMCU.idc().read();
    code.dev_id() == DEVICE && REVISIONS.contains(&code.rev_id())
}

/// Stops the watchdog while a debugger halts the core, which cannot feed it then. DMA still plays
/// what is queued, two ticks at most.
pub fn freeze_watchdog_in_debug() {
    DBGMCU.apb4fzr1().modify(|w| w.set_iwdg1(true));
}

/// SYSCFG_CFGR (RM0433 12.3.6), which the metadata leaves out.
const BREAKS: usize = 0x18;
/// PVDL, CM7L: low supply and a locked-up core break the timers. Only a reset clears the bits.
const SUPPLY_AND_LOCKUP: u32 = 1 << 2 | 1 << 6;
/// 2.7 V, falling (RM0433 6.8.1, PLS).
const SUPPLY_MIN_LEVEL: u8 = 0b101;

/// The hardware shuts the lasers off when the supply falls below 2.7 V, or when the core is locked
/// up. Call it once the supply has its level.
pub fn break_with_the_chip() {
    PWR.cr1().modify(|w| {
        w.set_pls(SUPPLY_MIN_LEVEL);
        w.set_pvde(true);
    });
    // SAFETY: the register is there, and only this function writes it.
    unsafe { SYSCFG.as_ptr().cast::<u8>().add(BREAKS).cast::<u32>().write_volatile(SUPPLY_AND_LOCKUP) };
}

/// Whether the supply is below that level now.
pub fn supply_is_low() -> bool {
    PWR.csr1().read().pvdo()
}

/// Everything at full speed, from the chip's own 64 MHz if `own`; otherwise from the board's
/// source, after [`await_source`].
pub fn raise(own: bool) {
    supply();
    multiply(if own { &OWN } else { &SOURCE });
    // Wait states before the clock that needs them (RM0433 4.3.8, table 17: VOS0, up to 240 MHz on
    // AXI).
    FLASH.acr().write(|w| {
        w.set_latency(4);
        w.set_wrhighfreq(2);
    });
    wait(|| FLASH.acr().read().latency() == 4);
    // The dividers of the buses are set before the core's clock exceeds their limit.
    RCC.d1cfgr().write(|w| {
        w.set_d1cpre(Hpre::DIV1);
        w.set_hpre(Hpre::DIV2);
        w.set_d1ppre(Ppre::DIV2);
    });
    RCC.d2cfgr().write(|w| {
        w.set_d2ppre1(Ppre::DIV2);
        w.set_d2ppre2(Ppre::DIV2);
    });
    RCC.d3cfgr().write(|w| w.set_d3ppre(Ppre::DIV2));
    RCC.cfgr().modify(|w| w.set_sw(Sw::PLL1_P));
    wait(|| RCC.cfgr().read().sws() == Sw::PLL1_P);
    // If the source stops, the clock security system breaks the lasers' timers, switches to the
    // chip's own clock and makes an NMI (RM0433 8.5.3).
    if !own {
        RCC.cr().modify(|w| w.set_hsecsson(true));
    }
}

/// LDO, and VOS0 through VOS1 (RM0433 6.6.2).
fn supply() {
    PWR.cr3().modify(|w| {
        w.set_bypass(false);
        w.set_ldoen(true);
        w.set_scuen(false);
    });
    wait(|| PWR.csr1().read().actvosrdy());
    PWR.d3cr().modify(|w| w.set_vos(pwr::vals::Vos::SCALE1));
    wait(|| PWR.d3cr().read().vosrdy());
    RCC.apb4enr().modify(|w| w.set_syscfgen(true));
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.apb4enr().read();
    SYSCFG.pwrcr().write(|w| w.set_oden(1));
    wait(|| PWR.d3cr().read().vosrdy());
}

/// 48 MHz for USB, as exact as the source (RM0433 8.5): PLL1 Q. Without the board's source it is
/// the chip's own oscillator for USB, which takes PLL1 Q's place.
pub fn give_usb() {
    if RCC.pllckselr().read().pllsrc() == Pllsrc::HSI {
        RCC.cr().modify(|w| w.set_hsi48on(true));
        wait(|| RCC.cr().read().hsi48rdy());
        RCC.d2ccip2r().modify(|w| w.set_usbsel(Usbsel::HSI48));
    } else {
        RCC.d2ccip2r().modify(|w| w.set_usbsel(Usbsel::PLL1_Q));
    }
}

/// What PLL1 multiplies.
struct PllInput {
    source: Pllsrc,
    /// By what PLL1 divides it.
    divider: u32,
    /// What is left of it.
    reference_mhz: u32,
}

impl PllInput {
    const fn of(source: Pllsrc, from: Source) -> PllInput {
        let divider = from.divider();
        PllInput { source, divider, reference_mhz: from.mhz / divider }
    }

    /// The range of PLL1's reference (RM0433 8.7.13).
    fn range(&self) -> Pllrge {
        match self.reference_mhz {
            8..=16 => Pllrge::RANGE8,
            4..=7 => Pllrge::RANGE4,
            2..=3 => Pllrge::RANGE2,
            _ => Pllrge::RANGE1,
        }
    }
}

/// The board's source, and the chip's own clock.
const SOURCE: PllInput = PllInput::of(Pllsrc::HSE, BOARD.source);
const OWN: PllInput = PllInput::of(Pllsrc::HSI, Source { mhz: 64, ..BOARD.source });

/// PLL1: 960 MHz; / 2 for the core, / 20 for USB.
fn multiply(input: &PllInput) {
    RCC.pllckselr().modify(|w| {
        w.set_pllsrc(input.source);
        w.set_divm(0, Pllm::from_bits(input.divider as u8));
    });
    RCC.pllcfgr().modify(|w| {
        w.set_pllrge(0, input.range());
        w.set_pllvcosel(0, Pllvcosel::WIDE_VCO);
        w.set_pllfracen(0, false);
        w.set_divpen(0, true);
        w.set_divqen(0, true);
        w.set_divren(0, false);
    });
    RCC.plldivr(0).write(|w| {
        w.set_plln(Plln::from_bits((VCO_MHZ / input.reference_mhz - 1) as u16));
        w.set_pllp(Plldiv::DIV2);
        w.set_pllq(Plldiv::DIV20);
        w.set_pllr(Plldiv::DIV2);
    });
    RCC.cr().modify(|w| w.set_pllon(0, true));
    wait(|| RCC.cr().read().pllrdy(0));
}
