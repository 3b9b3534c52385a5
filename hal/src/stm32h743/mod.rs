//! NUCLEO-H743ZI2 (`docs/board-h743.md`; sections are those of RM0433, the chip's reference manual).
//!
//! In: the tick's set-points and outputs, bytes to send. Out: ticks, levels of inputs, bytes received.
//! Owns the chip's clocks, watchdog, timer, UART and interrupt controller.
use crate::{guard, priority, spare};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB};
use stm32_metapac::Interrupt;

pub mod adc;
pub mod analog;
pub mod clocks;
pub mod encoders;
pub mod idle;
pub mod laser;
pub mod machine;
pub mod pins;
mod rounds;
pub mod settings;
pub mod spi;
mod start;
pub mod steps;
pub mod timer;
pub mod uart;
pub mod usb;
pub mod watchdog;

pub use watchdog::{Cause, cause};

/// Name of the board as the link tells it.
pub const NAME: &str = "nucleo-h743zi2";

/// Axes that the image for this board holds.
pub const AXES: usize = pins::AXES;

/// Tick period at power-on.
pub const TICK_NS: u32 = 50_000;

/// Tick periods that the board can run, in µs.
pub const TICK_US: core::ops::RangeInclusive<u32> = 10..=250;

/// Analog inputs of the board.
pub const ANALOG_INPUTS: u8 = adc::INPUTS as u8;

/// Rows that a plan of its inputs holds: its inputs are wired.
pub const PLANNED_INPUTS: u16 = 0;

/// The clock in which laser plans are counted: that of the timers.
pub const LASER_CLOCK: servo::laser::Clock = match servo::laser::Clock::from_mhz(clocks::TIMER_MHZ) {
    Some(clock) => clock,
    None => panic!("within the range of a laser clock"),
};

/// What the step outputs make of an axis at every tick period.
pub const STEP_LIMIT: servo::units::StepLimit = match servo::units::StepLimit::new(steps::most_a_ms(TICK_US)) {
    Some(limit) => limit,
    None => panic!("a step pulse that is longer than the shortest tick"),
};

/// Analog outputs of the board.
pub const ANALOG_OUTPUTS: u8 = analog::OUTPUTS as u8;

/// Axes whose encoder's index is captured: those that have one.
pub const INDEXES: servo::units::AxisMask = servo::units::AxisMask(encoders::FITTED);

/// General outputs of the board.
pub const GENERAL_OUTPUTS: u8 = pins::GENERAL_OUTPUTS as u8;
/// General inputs.
pub const GENERAL_INPUTS: u8 = pins::GENERAL_INPUTS as u8;

/// Everything of the board that is handed out once.
#[derive(Debug)]
pub struct Board {
    /// Makes the ticks; stands still.
    pub timer: timer::TickTimer,
    /// Host link.
    pub link: (uart::Tx, uart::Rx),
    /// The trace goes over the link.
    pub trace: Option<uart::Tx>,
    /// The machine of the axes.
    pub machine: machine::Machine,
    /// Why there shall be no light: what the board measures of itself contradicts what it is built for.
    pub contradiction: Option<&'static str>,
}

/// What an NMI says on this board, if it is not the watchdog's.
pub const NMI: Option<&str> = Some(clocks::CLOCK_LOST);

/// Brings the board up: the clock's source, watchdog, guards, caches, clocks, pins, priorities, UART; all interrupts still off. `None` from
/// the second call on.
pub fn take() -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    clocks::await_source();
    if clocks::is_too_old() {
        // Nothing of this image runs on it as it is meant to: all pins stay as the reset left them, but for a lamp.
        pins::show_refusal();
        loop {
            cortex_m::asm::wfi();
        }
    }
    clocks::spare_debuggers();
    watchdog::start();
    // The first eighth is the chip's system memory, which holds its unique number (RM0433 61.1).
    guard::below(&mut core.MPU, STACK, 1);
    guard::null(&mut core.MPU);
    guard::outside(&mut core.MPU);
    for (region, (base, bits)) in CODE.into_iter().enumerate() {
        guard::code(&mut core.MPU, region as u32, base, bits);
    }
    let (base, bits, without) = DMA_MEMORY;
    guard::uncached(&mut core.MPU, base, bits, without);
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
    clocks::raise();
    // SAFETY: before `listen` nothing runs at these priorities, so no critical section is open.
    unsafe {
        core.NVIC.set_priority(Interrupt::TIM2, priority::TICK);
        core.NVIC.set_priority(Interrupt::USART3, priority::LINK);
        core.NVIC.set_priority(Interrupt::OTG_FS, priority::LINK);
        core.SCB.set_priority(SystemHandler::PendSV, priority::BELL);
    }
    // SAFETY: this function gets here once, since the core's peripherals are handed out once.
    unsafe {
        pins::open();
        let lasers = laser::open();
        clocks::break_with_the_chip();
        // Their outputs are at rest before a pin shows them.
        pins::open_lasers();
        let contradiction = laser::contradiction(pins::Levels::read().breaks());
        encoders::open();
        Some(Board {
            contradiction,
            timer: timer::TickTimer::take(),
            link: uart::open(),
            trace: None,
            machine: machine::Machine::new(lasers, analog::Analog::open(), adc::Adc::open(), contradiction.is_some()),
        })
    }
}

/// The regions STACK and CODE of `memory.x`: where the one begins, and all of the other, 1 KiB and 16.
const STACK: u32 = 0x2000_0000;
const CODE: [(u32, u32); 2] = [(0xbc00, 10), (0xc000, 14)];

/// The regions DMA and KEPT of `memory.x`: SRAM 3 without its first two eighths, 24 KiB.
const DMA_MEMORY: (u32, u32, u8) = (0x3004_0000, 15, 0b11);

/// Behind the last byte of AXI SRAM.
const TABLES_END: usize = 0x2408_0000;

/// Runs start-up's `body` where the PVT tables will lie: it takes more stack than there is later. What a table without
/// a header holds does not matter.
///
/// # Safety
/// Before anybody uses the tables.
pub unsafe fn start_up(context: *mut (), body: extern "C" fn(*mut ())) {
    // SAFETY: the caller's promise; 512 KiB are more than enough.
    unsafe { spare::run_on(context, body, TABLES_END) };
}

/// Lets the interrupts in.
///
/// # Safety
/// What the handlers use must be in place.
pub unsafe fn listen() {
    for interrupt in [Interrupt::TIM2, Interrupt::USART3, Interrupt::OTG_FS] {
        // SAFETY: the caller's promise.
        unsafe { NVIC::unmask(interrupt) };
    }
    // Not before: the first tick would be late.
    timer::start();
}

/// The link's bytes wait in the UART's ring, as far as it holds them, until [`resume_link`]: nobody has room for them.
pub fn hold_link() {
    uart::listen(false);
}

/// There is room again.
pub fn resume_link() {
    uart::listen(true);
    if uart::has_byte() {
        // What it would have told of while it was held, it does not tell again.
        NVIC::pend(Interrupt::USART3);
    }
}

/// Rings the bell from the tick down to the thread.
pub fn ring_bell() {
    uart::tell();
    SCB::set_pendsv();
}

/// Puts every output at rest and stops the ticks and the board's other interrupts: the first thing
/// on the way into a reset.
pub fn rest() {
    // The tick first: it would write the outputs again.
    NVIC::mask(Interrupt::TIM2);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    laser::rest();
    analog::rest();
    pins::rest();
    steps::stop();
    timer::stop();
    NVIC::mask(Interrupt::USART3);
    NVIC::mask(Interrupt::OTG_FS);
}
