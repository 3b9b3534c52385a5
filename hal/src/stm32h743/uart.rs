//! USART3 to the ST-LINK's virtual port (RM0433 48): bytes each way through FIFOs of 16.
//!
//! In and out: bytes, one at a time, never waiting. Owns USART3. Interrupts come when half the receiving FIFO is full or
//! the line falls silent, and when half the sending FIFO is empty while somebody waits. What is received while nobody
//! fetches is lost and asked for again by the link; damaged bytes come as they are, the link's checksum finds them.
use super::clocks::BUS_HZ;
use critical_section::with;
use stm32_metapac::{RCC, USART3};

/// Of the link. ST-LINK/V3 and the common hosts know it, and PCLK1 divides by it.
pub const BAUD: u32 = 3_000_000;

/// Half of a FIFO (RXFTCFG, TXFTCFG).
const HALF: u8 = 0b010;

/// The sending half.
#[derive(Debug)]
pub struct Tx(());

/// The receiving half.
#[derive(Debug)]
pub struct Rx(());

/// Switches the UART on and gives its halves.
///
/// # Safety
/// At most once.
pub unsafe fn open() -> (Tx, Rx) {
    RCC.apb1lenr().modify(|w| w.set_usart3en(true));
    // Read back, so that the clock is there (RM0433 8.5.8).
    RCC.apb1lenr().read();
    USART3.brr().write(|w| w.set_brr((BUS_HZ / BAUD) as u16));
    USART3.cr3().write(|w| {
        w.set_rxftcfg(HALF);
        w.set_rxftie(true);
        w.set_txftcfg(HALF);
    });
    USART3.cr1().write(|w| {
        w.set_fifoen(true);
        w.set_te(true);
        w.set_re(true);
        w.set_idleie(true);
    });
    USART3.cr1().modify(|w| w.set_ue(true));
    (Tx(()), Rx(()))
}

impl Tx {
    /// Sends a byte if the FIFO can take it now. If not, an interrupt will tell when it can.
    pub fn send(&mut self, byte: u8) -> bool {
        if !USART3.isr().read().txe() {
            // In a section: the interrupt changes the same register.
            with(|_| USART3.cr3().modify(|w| w.set_txftie(true)));
            return false;
        }
        USART3.tdr().write(|w| w.set_dr(byte.into()));
        true
    }
}

impl Rx {
    /// The oldest byte that has arrived, if one has.
    pub fn receive(&mut self) -> Option<u8> {
        USART3.isr().read().rxne().then(|| USART3.rdr().read().dr() as u8)
    }
}

/// In the interrupt: acknowledges what it told of. True if a sender may go on.
pub fn acknowledge() -> bool {
    USART3.icr().write(|w| {
        w.set_idle(true);
        w.set_ore(true);
        w.set_ne(true);
        w.set_fe(true);
        w.set_pe(true);
    });
    let goes_on = USART3.cr3().read().txftie() && USART3.isr().read().txft();
    if goes_on {
        USART3.cr3().modify(|w| w.set_txftie(false));
    }
    goes_on
}

/// Whether a byte waits to be fetched.
pub fn has_byte() -> bool {
    USART3.isr().read().rxne()
}

/// Whether the receiving side interrupts.
pub fn listen(listens: bool) {
    with(|_| {
        USART3.cr3().modify(|w| w.set_rxftie(listens));
        USART3.cr1().modify(|w| w.set_idleie(listens));
    });
}
