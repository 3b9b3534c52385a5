#![no_std]
//! What the programs share: embassy-stm32 with the clocks of the image.
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk, VoltageScale,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals};
use hal as _; // critical sections, start-up

/// `init`, with what `hal::board::clocks` sets.
#[inline(never)]
pub fn init() -> Peripherals {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass });
    rcc.hsi48 = None;
    rcc.pll1 = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV1,
        mul: PllMul::MUL120,
        fracn: None,
        divp: Some(PllDiv::DIV2),
        divq: Some(PllDiv::DIV20),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.d1c_pre = AHBPrescaler::DIV1;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    (rcc.apb1_pre, rcc.apb2_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
    (rcc.apb3_pre, rcc.apb4_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
    rcc.voltage_scale = VoltageScale::Scale0;
    // per_ck, HSI: the reset value is PLL2, which is off.
    rcc.mux.adcsel = embassy_stm32::rcc::mux::Adcsel::PER;
    embassy_stm32::init(config)
}

/// The clocks of the image, by its own code.
#[inline(never)]
pub fn raise() {
    hal::board::clocks::await_source();
    hal::board::clocks::raise(false);
}

/// What a link has read: 65536 for each byte, and the bytes' sum. A test reads it.
#[unsafe(no_mangle)]
static LINK_HAS_READ: AtomicU32 = AtomicU32::new(0);

/// A link has read this byte.
#[inline(always)]
pub fn take(byte: u8) {
    let before = LINK_HAS_READ.load(Ordering::Relaxed);
    LINK_HAS_READ.store(before.wrapping_add(0x1_0000 + u32::from(byte)), Ordering::Relaxed);
}

/// The end of a program.
pub fn rest() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    rest()
}
