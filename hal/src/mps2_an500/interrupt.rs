//! The board's interrupts (Arm AN500, table of interrupts; QEMU's `hw/arm/mps2.c`).
use cortex_m::interrupt::InterruptNumber;

/// Interrupts that the image uses, by the names of the board's manual.
#[allow(non_camel_case_types)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// A byte arrived on UART0.
    UART0_RX = 0,
    /// UART0 can take a byte again.
    UART0_TX = 1,
    /// A byte arrived on UART1.
    UART1_RX = 2,
    /// UART1 can take a byte again.
    UART1_TX = 3,
    /// CMSDK timer 0.
    TIMER0 = 8,
}

// SAFETY: the numbers are the board's and unique.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    fn UART0_RX();
    fn UART0_TX();
    fn UART1_RX();
    fn UART1_TX();
    fn TIMER0();
    fn DefaultHandler();
}

/// One entry of the vector table.
type Vector = unsafe extern "C" fn();

/// The board's part of the vector table; `cortex-m-rt` places it.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [Vector; 32] = {
    let mut table = [DefaultHandler as Vector; 32];
    table[Interrupt::UART0_RX as usize] = UART0_RX;
    table[Interrupt::UART0_TX as usize] = UART0_TX;
    table[Interrupt::UART1_RX as usize] = UART1_RX;
    table[Interrupt::UART1_TX as usize] = UART1_TX;
    table[Interrupt::TIMER0 as usize] = TIMER0;
    table
};
