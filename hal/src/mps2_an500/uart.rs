//! CMSDK APB UART (Arm DDI 0479, "APB UART"): one byte each way, no FIFO.
//!
//! In and out: bytes, one at a time, never waiting. Owns the registers of the UART it is made for.
//! Fails: a byte that nobody fetches holds the sender in QEMU; on silicon the next one would be
//! lost, and the link would ask for it again.
use core::ptr::{read_volatile, write_volatile};

const DATA: usize = 0x0;
const STATE: usize = 0x4;
const CTRL: usize = 0x8;
const INT: usize = 0xc;
const BAUDDIV: usize = 0x10;
const STATE_TX_FULL: u32 = 1 << 0;
const STATE_RX_FULL: u32 = 1 << 1;
const CTRL_TX: u32 = 1 << 0;
const CTRL_RX: u32 = 1 << 1;
const CTRL_TX_INTERRUPT: u32 = 1 << 2;
const CTRL_RX_INTERRUPT: u32 = 1 << 3;
const INT_TX: u32 = 1 << 0;
const INT_RX: u32 = 1 << 1;

/// The smallest divider that the UART takes: 1.5625 Mbaud. QEMU moves bytes as fast as they come.
const FASTEST_DIVISOR: u32 = 16;

/// Which of the board's UARTs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum Port {
    /// The host link.
    Link = 0x4000_4000,
    /// The trace.
    Trace = 0x4000_5000,
}

/// The sending half.
#[derive(Debug)]
pub struct Tx(Port);

/// The receiving half.
#[derive(Debug)]
pub struct Rx(Port);

/// Switches a UART on and gives its halves. Receiving interrupts; sending does when it has to wait.
///
/// # Safety
/// At most once for each UART.
pub unsafe fn open(port: Port) -> (Tx, Rx) {
    write(port, BAUDDIV, FASTEST_DIVISOR);
    write(port, INT, INT_TX | INT_RX);
    write(port, CTRL, CTRL_QUIET);
    (Tx(port), Rx(port))
}

/// Both directions on; an interrupt for a byte received.
const CTRL_QUIET: u32 = CTRL_TX | CTRL_RX | CTRL_RX_INTERRUPT;
/// And one when a byte has been sent.
const CTRL_WAITING: u32 = CTRL_QUIET | CTRL_TX_INTERRUPT;

impl Tx {
    /// Sends a byte if the UART can take it now. If not, the transmit interrupt comes when it can.
    pub fn send(&mut self, byte: u8) -> bool {
        if is_full(self.0) {
            write(self.0, CTRL, CTRL_WAITING);
            // It may have got free before the interrupt was on, and then no interrupt comes.
            if is_full(self.0) {
                return false;
            }
        }
        write(self.0, DATA, u32::from(byte));
        true
    }
}

impl Rx {
    /// The byte that has arrived, if one has.
    pub fn receive(&mut self) -> Option<u8> {
        if read(self.0, STATE) & STATE_RX_FULL == 0 {
            return None;
        }
        // Before the data is fetched: the byte that may follow at once raises the interrupt anew.
        write(self.0, INT, INT_RX);
        Some(read(self.0, DATA) as u8)
    }
}

/// Acknowledges the transmit interrupt, which stays quiet until a sender waits again.
pub fn acknowledge_sent(port: Port) {
    write(port, CTRL, CTRL_QUIET);
    write(port, INT, INT_TX);
}

fn read(port: Port, register: usize) -> u32 {
    // SAFETY: a register of one of this board's UARTs.
    unsafe { read_volatile((port as usize + register) as *const u32) }
}

fn write(port: Port, register: usize, value: u32) {
    // SAFETY: a register of one of this board's UARTs.
    unsafe { write_volatile((port as usize + register) as *mut u32, value) };
}

/// Whether a byte waits to be sent.
pub fn is_full(port: Port) -> bool {
    read(port, STATE) & STATE_TX_FULL != 0
}

/// Whether a byte waits to be fetched.
pub fn has_byte(port: Port) -> bool {
    read(port, STATE) & STATE_RX_FULL != 0
}
