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

/// The machine of its axes.
pub type Machine = machine::Machine<AXES>;

/// Name of the board as the link reports it.
pub const NAME: &str = "mps2-an500";

/// Axes that the image for this board holds: every profile of SPEC 2.
pub const AXES: usize = 48;

/// Tick period at power-on: the controllers' own cycle, with which the manuals count.
pub const TICK_NS: u32 = 250_000;

/// Tick periods that the board can run, in µs.
pub const TICK_US: core::ops::RangeInclusive<u32> = servo::tick::PERIOD_US;

/// Analog inputs of the board; nothing is wired to them: they read what SimAdc sets, 0 at power-on.
pub const ANALOG_INPUTS: u8 = machine::ANALOG_INPUTS as u8;

/// Rows that a plan of its inputs holds.
pub const PLANNED_INPUTS: u16 = machine::ROWS as u16;
/// The clock in which laser plans are counted: a count is a ns.
pub const LASER_CLOCK: servo::laser::Clock = servo::laser::Clock::GHZ;

/// Analog outputs of the board.
pub const ANALOG_OUTPUTS: u8 = outputs::ANALOG_OUTPUTS as u8;

/// Fastest axis that the step outputs can follow: they are only recorded, so nothing is too fast.
pub const STEP_LIMIT: servo::units::StepLimit = servo::units::StepLimit::FULL_SCALE;

/// Where the stack ends: the lowest address of RAM (`memory.x`).
const STACK: u32 = 0x2000_0000;

/// General outputs of the board.
pub const GENERAL_OUTPUTS: u8 = servo::port::GeneralOutputs::BITS as u8;
/// General inputs.
pub const GENERAL_INPUTS: u8 = servo::port::GeneralInputs::BITS as u8;

/// Axes whose encoder's index is captured: none, since encoders follow the set-point.
pub const INDEXES: servo::units::AxisMask = servo::units::AxisMask(0);

/// All inputs of axes are there.
pub const WIRED: servo::port::WiredInputs = servo::port::WiredInputs::ALL;

/// There are no break inputs that could contradict their pins.
pub fn contradiction() -> Option<&'static str> {
    None
}

/// Reason of an NMI of this board that is not the watchdog's.
pub const NMI: Option<&str> = None;

/// Why the board started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetCause {
    /// Power-on: the contents of RAM are undefined.
    Power,
    /// A watchdog has reset the board.
    Watchdog,
    /// The image or a debugger.
    Asked,
}

/// Why the board started: the hardware does not report it, and QEMU's RAM holds zeros at power-on.
pub fn cause() -> ResetCause {
    ResetCause::Asked
}

/// Everything of the board that is handed out once.
#[derive(Debug)]
pub struct Board {
    /// Makes the ticks; stopped.
    pub timer: timer::TickTimer,
    /// Host link.
    pub link: (uart::Tx, uart::Rx),
    /// Trace.
    pub trace: Option<uart::Tx>,
    /// The machine of the axes, which receives the interlock on the trace's UART.
    pub machine: machine::Machine<AXES>,
    /// Reason why the board must not make light: never, here.
    pub contradiction: Option<&'static str>,
}

/// Brings the board up: priorities set, UARTs open, all interrupts still off. `None` from the
/// second call on.
pub fn take() -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    guard::below(&mut core.MPU, STACK, 0);
    // SAFETY: before `listen` nothing runs at these priorities, so no critical section is open.
    unsafe {
        core.NVIC.set_priority(Interrupt::TIMER0, priority::TICK);
        for interrupt in [Interrupt::UART0_RX, Interrupt::UART0_TX, Interrupt::UART1_TX] {
            core.NVIC.set_priority(interrupt, priority::LINK);
        }
        core.SCB.set_priority(SystemHandler::PendSV, priority::WAKE);
    }
    // SAFETY: this function gets here once, since the core's peripherals are handed out once.
    unsafe {
        let (trace, switchboard) = uart::open(uart::Port::Trace);
        Some(Board {
            timer: timer::TickTimer::take(core.SYST),
            link: uart::open(uart::Port::Link),
            trace: Some(trace),
            machine: machine::Machine::new(TICK_NS, switchboard),
            contradiction: None,
        })
    }
}

/// Runs start-up's `body` on the program's stack.
///
/// # Safety
/// No condition here; other boards have some.
pub unsafe fn start_up(context: *mut (), body: extern "C" fn(*mut ())) {
    body(context);
}

/// Enables the interrupts and starts the watchdog.
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

/// The link's bytes wait in the UART until [`resume_link`]: the queue to the task is full.
pub fn hold_link() {
    NVIC::mask(Interrupt::UART0_RX);
}

/// There is room again.
pub fn resume_link() {
    // SAFETY: the handler was let in by `listen` before, and no critical section by NVIC mask
    // exists.
    unsafe { NVIC::unmask(Interrupt::UART0_RX) };
}

/// Wakes the thread from the tick: raises the wake signal.
pub fn wake_thread() {
    SCB::set_pendsv();
}

/// Sets every output to its safe state and stops the ticks and the board's other interrupts: the
/// first step of a reset.
pub fn safe_state() {
    // The tick first: it would write the outputs again.
    NVIC::mask(Interrupt::TIMER0);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    outputs::safe_state();
    // Its NMI does not disturb what is left to do.
    watchdog::feed();
    for interrupt in [Interrupt::UART0_RX, Interrupt::UART0_TX, Interrupt::UART1_TX] {
        NVIC::mask(interrupt);
    }
}
