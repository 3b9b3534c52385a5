//! The STM32H743 on each of its [`boards`]: `docs/board-h743-registers.md`. Sections in comments
//! are those of RM0433, the chip's reference manual.
//!
//! In: the tick's set-points and outputs, bytes to send. Out: ticks, levels of inputs, bytes
//! received. Owns the chip's clocks, watchdog, timer, UART and interrupt controller. Fails: another
//! chip or revision is refused; a clock that does not start is left to the watchdog.
use crate::{guard, priority, startup_stack};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB};
use stm32_metapac::Interrupt;

pub mod adc;
pub mod analog;
pub mod boards;
pub mod clocks;
pub mod encoders;
pub mod idle;
pub mod laser;
pub mod machine;
pub mod package;
pub mod pins;
mod pwm_dma;
pub mod settings;
pub mod spi;
pub mod stack;
mod start;
pub mod steps;
pub mod timer;
pub mod uart;
pub mod usb;
pub mod watchdog;
pub mod wiring;

pub use machine::Machine;
pub use watchdog::{ResetCause, cause};

/// Name of the board as the link reports it.
pub const NAME: &str = boards::BOARD.names[settings::EXTERNAL_DAC as usize];

/// Axes that the image for this board holds.
pub const AXES: usize = pins::AXES;

/// Tick period at power-on.
pub const TICK_NS: u32 = 50_000;

/// Tick periods that the board can run, in µs.
pub const TICK_US: core::ops::RangeInclusive<u32> = 10..=250;

/// Analog inputs of the board.
pub const ANALOG_INPUTS: u8 = adc::INPUTS as u8;

/// Rows that a plan of its inputs holds: none, since its inputs are wired.
pub const PLANNED_INPUTS: u16 = 0;

/// The clock in which laser plans are counted: that of the timers.
pub const LASER_CLOCK: servo::laser::Clock = match servo::laser::Clock::from_mhz(clocks::TIMER_MHZ) {
    Some(clock) => clock,
    None => panic!("within the range of a laser clock"),
};

/// Fastest axis that the step outputs can follow at every tick period.
pub const STEP_LIMIT: servo::units::StepLimit = match servo::units::StepLimit::new(steps::most_a_ms(TICK_US)) {
    Some(limit) => limit,
    None => panic!("a step pulse that is longer than the shortest tick"),
};

/// Analog outputs of the board.
pub const ANALOG_OUTPUTS: u8 = analog::OUTPUTS as u8;

/// Axes whose encoder's index is captured: those with an encoder.
pub const INDEXES: servo::units::AxisMask = servo::units::AxisMask(encoders::FITTED);

/// General outputs of the board.
pub const GENERAL_OUTPUTS: u8 = pins::GENERAL_OUTPUTS as u8;
/// General inputs.
pub const GENERAL_INPUTS: u8 = pins::GENERAL_INPUTS as u8;

/// Everything of the board that is handed out once.
#[derive(Debug)]
pub struct Board {
    /// Makes the ticks; stopped.
    pub timer: timer::TickTimer,
    /// Host link.
    pub link: (uart::Tx, uart::Rx),
    /// The trace goes over the link.
    pub trace: Option<uart::Tx>,
    /// The machine of the axes.
    pub machine: machine::Machine,
    /// Reason why the board must not make light: its own measurement contradicts its wiring.
    pub contradiction: Option<&'static str>,
}

/// What the ticks have found about the break inputs.
pub fn contradiction() -> Option<&'static str> {
    laser::found()
}

/// Axes that have inputs of their own; the others' are never active.
pub const WIRED: servo::port::WiredInputs = servo::port::WiredInputs {
    limit_positive: first(boards::BOARD.limit_positive),
    limit_negative: first(boards::BOARD.limit_negative),
    alarm: first(boards::BOARD.alarm),
    home: first(boards::BOARD.home),
    arrive: first(&[]),
};

/// As many axes as there are pins.
const fn first(pins: wiring::OfAxes) -> servo::units::AxisMask {
    servo::units::AxisMask((1 << pins.len()) - 1)
}

/// Reason of an NMI of this board that is not the watchdog's.
pub const NMI: Option<&str> = Some(clocks::CLOCK_LOST);

/// Brings the board up: an external DAC to 0 V, the clock's source, watchdog, guards, caches,
/// clocks, pins, priorities, UART. All interrupts are still off. `None` from the second call on.
///
/// On another package than the board's it drives no pin, and the board says why
/// ([`Board::contradiction`]).
pub fn take() -> Option<Board> {
    bring_up(Purpose::Control)
}

/// The same for an image that measures the board, with nothing connected to it: the link's pins
/// work on another package too, and an LED says that the chip is refused.
pub fn take_to_measure() -> Option<Board> {
    bring_up(Purpose::Measure)
}

/// What the image does with the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Control,
    Measure,
}

fn bring_up(purpose: Purpose) -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    let is_other = package::is_other();
    if !clocks::is_fit() {
        // The image needs another chip: all other pins stay as the reset left them. An LED is an
        // output of the board, too, so it is lit only where nothing is connected to that.
        if purpose == Purpose::Measure && !is_other {
            pins::show_refusal();
        }
        loop {
            cortex_m::asm::wfi();
        }
    }
    if !is_other {
        // SAFETY: this function gets here once, and nothing has driven a pin yet.
        unsafe { analog::zero_external() };
        clocks::await_source();
    }
    clocks::freeze_watchdog_in_debug();
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
    clocks::raise(is_other);
    // SAFETY: before `listen` nothing runs at these priorities, so no critical section is open.
    unsafe {
        core.NVIC.set_priority(Interrupt::TIM2, priority::TICK);
        core.NVIC.set_priority(Interrupt::USART3, priority::LINK);
        core.NVIC.set_priority(Interrupt::OTG_FS, priority::LINK);
        core.SCB.set_priority(SystemHandler::PendSV, priority::WAKE);
    }
    // SAFETY: this function gets here once, since the core's peripherals are handed out once.
    unsafe {
        pins::give_clocks();
        if !is_other {
            pins::open();
        } else if purpose == Purpose::Measure {
            pins::open_link();
        }
        let lasers = laser::open();
        clocks::break_with_the_chip();
        let contradiction = if is_other {
            Some(package::OTHER)
        } else {
            // The timers hold the safe state before a pin outputs it.
            pins::open_lasers();
            laser::contradiction(pins::PinLevels::read().breaks())
        };
        encoders::open();
        Some(Board {
            contradiction,
            timer: timer::TickTimer::take(),
            link: uart::open(),
            trace: None,
            machine: machine::Machine::new(
                lasers,
                analog::Analog::open(!is_other),
                adc::Adc::open(),
                contradiction.is_some(),
            ),
        })
    }
}

/// Regions of `memory.x`: where STACK begins, and CODE in two parts, of 2^10 and 2^14 bytes.
const STACK: u32 = 0x2000_0000;
const CODE: [(u32, u32); 2] = [(0xbc00, 10), (0xc000, 14)];

/// The regions DMA and KEPT of `memory.x`: SRAM 3 without its first two eighths, 24 KiB.
const DMA_MEMORY: (u32, u32, u8) = (0x3004_0000, 15, 0b11);

/// Address after the last byte of AXI SRAM.
const TABLES_END: usize = 0x2408_0000;

/// Runs start-up's `body` with its stack in the memory of the PVT tables: it needs more stack than
/// the running program has. The contents of a table without a header do not matter.
///
/// # Safety
/// Before anything uses the tables.
pub unsafe fn start_up(context: *mut (), body: extern "C" fn(*mut ())) {
    // SAFETY: the caller's promise; 512 KiB are more than enough.
    unsafe { startup_stack::run_on(context, body, TABLES_END) };
}

/// Enables the interrupts, then starts the ticks.
///
/// # Safety
/// What the handlers use must be in place.
pub unsafe fn listen() {
    for interrupt in [Interrupt::TIM2, Interrupt::USART3, Interrupt::OTG_FS] {
        // SAFETY: the caller's promise.
        unsafe { NVIC::unmask(interrupt) };
    }
    // Only now: else the first tick would be late.
    timer::start();
}

/// The link's bytes wait in the UART's ring, as far as it holds them, until [`resume_link`]: the
/// queue to the task is full.
pub fn hold_link() {
    uart::listen(false);
}

/// There is room again.
pub fn resume_link() {
    uart::listen(true);
    if uart::has_byte() {
        // Its interrupts while it was held do not come again.
        NVIC::pend(Interrupt::USART3);
    }
}

/// Wakes the thread from the tick: raises the wake signal.
pub fn wake_thread() {
    uart::pend_if_waiting();
    SCB::set_pendsv();
}

/// Sets every output to its safe state and stops the ticks and the board's other interrupts: the
/// first step of a reset.
pub fn safe_state() {
    // The tick first: it would write the outputs again.
    NVIC::mask(Interrupt::TIM2);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    laser::safe_state();
    analog::safe_state();
    pins::safe_state();
    steps::stop();
    timer::stop();
    NVIC::mask(Interrupt::USART3);
    NVIC::mask(Interrupt::OTG_FS);
}
