//! MPS2 with the AN500 image, as QEMU's `mps2-an500` emulates it (`docs/board-mps2.md`).
//!
//! In: the tick's set-points and outputs, bytes to send. Out: ticks, encoders, bytes received.
//! Owns the board's timer, UARTs and interrupt controller.
use crate::{guard, priority};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB};
use interrupt::Interrupt;

pub mod idle;
pub mod interrupt;
pub mod machine;
pub mod outputs;
pub mod timer;
pub mod uart;
pub mod watchdog;

/// Name of the board as the link tells it.
pub const NAME: &str = "mps2-an500";

/// Axes that the image for this board holds: every profile of SPEC 2.
pub const AXES: usize = 48;

/// Tick period at power-on: the controllers' own cycle, with which the manuals count.
pub const TICK_NS: u32 = 250_000;

/// Tick periods that the board can run, in µs.
pub const TICK_US: core::ops::RangeInclusive<u32> = 10..=1000;

/// Analog inputs of the board; nothing is wired to them: they read what SimAdc sets, 0 at power-on.
pub const ANALOG_INPUTS: u8 = machine::ANALOG_INPUTS as u8;

/// Rows that a plan of its inputs holds.
pub const PLANNED_INPUTS: u16 = machine::ROWS as u16;
/// The clock in which laser plans are counted: a count is a ns.
pub const LASER_CLOCK: servo::laser::Clock = servo::laser::Clock::GHZ;

/// Analog outputs of the board.
pub const ANALOG_OUTPUTS: u8 = outputs::ANALOG as u8;

/// What the step outputs make of an axis: they are recorded, not made, so nothing is too fast.
pub const STEP_LIMIT: servo::units::StepLimit = servo::units::StepLimit::FULL_SCALE;

/// Where the stack ends: the lowest address of RAM (`memory.x`).
const STACK: u32 = 0x2000_0000;

/// General outputs of the board.
pub const GENERAL_OUTPUTS: u8 = servo::port::GeneralOutputs::BITS as u8;
/// General inputs.
pub const GENERAL_INPUTS: u8 = servo::port::GeneralInputs::BITS as u8;

/// Axes whose encoder's index is captured: none, for encoders read the set-point.
pub const INDEXES: servo::units::AxisMask = servo::units::AxisMask(0);

/// What an NMI says on this board, if it is not the watchdog's.
pub const NMI: Option<&str> = None;

/// Why the board started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The supply came: what RAM holds is chance.
    Power,
    /// A watchdog has reset the board.
    Watchdog,
    /// The image or a debugger.
    Asked,
}

/// Why the board started: it does not tell, and QEMU's RAM holds zeros at power-on.
pub fn cause() -> Cause {
    Cause::Asked
}

/// Everything of the board that is handed out once.
#[derive(Debug)]
pub struct Board {
    /// Makes the ticks; stands still.
    pub timer: timer::TickTimer,
    /// Host link.
    pub link: (uart::Tx, uart::Rx),
    /// Trace.
    pub trace: Option<uart::Tx>,
    /// The machine of the axes, which is told the levels of inputs on the trace's UART.
    pub machine: machine::Machine<AXES>,
    /// Why there shall be no light: never, here.
    pub contradiction: Option<&'static str>,
}

/// Brings the board up: priorities set, UARTs open, all interrupts still off. `None` from the second
/// call on.
pub fn take() -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    guard::below(&mut core.MPU, STACK, 0);
    // SAFETY: before `listen` nothing runs at these priorities, so no critical section is open.
    unsafe {
        core.NVIC.set_priority(Interrupt::TIMER0, priority::TICK);
        for interrupt in [Interrupt::UART0_RX, Interrupt::UART0_TX, Interrupt::UART1_TX] {
            core.NVIC.set_priority(interrupt, priority::LINK);
        }
        core.SCB.set_priority(SystemHandler::PendSV, priority::BELL);
    }
    // SAFETY: this function gets here once, since the core's peripherals are handed out once.
    unsafe {
        let (trace, switchboard) = uart::open(uart::Place::Trace);
        Some(Board {
            timer: timer::TickTimer::take(core.SYST),
            link: uart::open(uart::Place::Link),
            trace: Some(trace),
            machine: machine::Machine::new(TICK_NS, switchboard),
            contradiction: None,
        })
    }
}

/// Runs start-up's `body`, on the one stack there is.
///
/// # Safety
/// None is needed here; other boards ask for some.
pub unsafe fn start_up(context: *mut (), body: extern "C" fn(*mut ())) {
    body(context);
}

/// Lets the interrupts in, and the watchdog go.
///
/// # Safety
/// What the handlers use must be in place.
pub unsafe fn listen() {
    for interrupt in [Interrupt::TIMER0, Interrupt::UART0_RX, Interrupt::UART0_TX, Interrupt::UART1_TX] {
        // SAFETY: the caller's promise.
        unsafe { NVIC::unmask(interrupt) };
    }
    watchdog::start();
}

/// The link's bytes wait in the UART until [`resume_link`]: nobody has room for them.
pub fn hold_link() {
    NVIC::mask(Interrupt::UART0_RX);
}

/// There is room again.
pub fn resume_link() {
    // SAFETY: the handler was let in by `listen` before, and no critical section by NVIC mask exists.
    unsafe { NVIC::unmask(Interrupt::UART0_RX) };
}

/// Rings the bell from the tick down to the thread.
pub fn ring_bell() {
    SCB::set_pendsv();
}

/// Puts every output at rest and stops the ticks and the board's other interrupts: the first thing
/// on the way into a reset.
pub fn rest() {
    // The tick first: it would write the outputs again.
    NVIC::mask(Interrupt::TIMER0);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    outputs::rest();
    // What is left to do is not disturbed by its NMI.
    watchdog::feed();
    for interrupt in [Interrupt::UART0_RX, Interrupt::UART0_TX, Interrupt::UART1_TX] {
        NVIC::mask(interrupt);
    }
}
