//! USART3 to the ST-LINK's virtual port (RM0433 48): it sends through a FIFO of 16 bytes and
//! receives by DMA into a ring.
//!
//! In and out: bytes, one at a time, never waiting. Owns USART3, DMA1 stream 2 and the ring. DMA
//! fetches what arrives, however long a tick lasts. Interrupts come when the line falls silent,
//! when a tick ends with bytes waiting ([`pend_if_waiting`]), and when half the sending FIFO is
//! empty while a sender waits. Fails: bytes that wait longer than a ring's time, 1.7 ms, are lost.
//! The link, whose checksum also finds damaged bytes, asks for them again.
use super::clocks::BUS_HZ;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering, fence};
use cortex_m::peripheral::NVIC;
use critical_section::with;
use stm32_metapac::dma::vals::{Dir, Pl, Size};
use stm32_metapac::{DMA1, DMAMUX1, Interrupt, RCC, USART3};

/// Baud rate of the link. ST-LINK/V3 and the common hosts know it, and PCLK1 divides by it.
pub const BAUD: u32 = 3_000_000;

/// Half of a FIFO (TXFTCFG).
const HALF: u8 = 0b010;

/// Bytes of the ring: a power of two.
const RING_BYTES: usize = 512;

/// The stream that receives, which is also its channel of DMAMUX1, and its request (RM0433 17.3.2:
/// USART3_RX).
const RECEIVE: usize = 2;
const USART3_RX: u8 = 45;

#[unsafe(link_section = ".dma.link")]
static BYTES: [AtomicU8; RING_BYTES] = [const { AtomicU8::new(0) }; RING_BYTES];

/// Index in the ring of the byte that is read next.
#[unsafe(link_section = ".state.words")]
static TAKEN: AtomicU32 = AtomicU32::new(0);
/// Whether [`pend_if_waiting`] makes an interrupt.
#[unsafe(link_section = ".state.words")]
static LISTENS: AtomicBool = AtomicBool::new(false);

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
    RCC.ahb1enr().modify(|w| w.set_dma1en(true));
    // Read back, so that the clocks are on (RM0433 8.5.8).
    RCC.apb1lenr().read();
    RCC.ahb1enr().read();
    DMAMUX1.ccr(RECEIVE).write(|w| w.set_dmareq_id(USART3_RX));
    let stream = DMA1.st(RECEIVE);
    stream.par().write_value(USART3.rdr().as_ptr() as u32);
    stream.m0ar().write_value(BYTES.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(RING_BYTES as u16));
    stream.cr().write(|w| {
        w.set_dir(Dir::PERIPHERAL_TO_MEMORY);
        w.set_circ(true);
        w.set_minc(true);
        w.set_psize(Size::BITS8);
        w.set_msize(Size::BITS8);
        w.set_pl(Pl::LOW);
        // Without it a stream that serves a UART may stop for ever while others are busy (RM0433
        // 15.5.5; ES0392).
        w.set_trbuff(true);
        w.set_en(true);
    });
    USART3.brr().write(|w| w.set_brr((BUS_HZ / BAUD) as u16));
    USART3.cr3().write(|w| {
        w.set_dmar(true);
        w.set_txftcfg(HALF);
    });
    USART3.cr1().write(|w| {
        w.set_fifoen(true);
        w.set_te(true);
        w.set_re(true);
        w.set_idleie(true);
    });
    USART3.cr1().modify(|w| w.set_ue(true));
    LISTENS.store(true, Ordering::Relaxed);
    (Tx(()), Rx(()))
}

impl Tx {
    /// Sends a byte if the FIFO can take it now. If not, an interrupt comes when it can.
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
        let index = TAKEN.load(Ordering::Relaxed);
        if index == written() {
            return None;
        }
        // The byte is read after the count that includes it.
        fence(Ordering::SeqCst);
        let byte = BYTES.get(index as usize)?.load(Ordering::Relaxed);
        TAKEN.store((index + 1) % RING_BYTES as u32, Ordering::Relaxed);
        Some(byte)
    }
}

/// In the interrupt: acknowledges its flags. True if a sender may continue.
pub fn acknowledge() -> bool {
    USART3.icr().write(|w| {
        w.set_idle(true);
        w.set_ore(true);
        w.set_ne(true);
        w.set_fe(true);
        w.set_pe(true);
    });
    let may_send = USART3.cr3().read().txftie() && USART3.isr().read().txft();
    if may_send {
        USART3.cr3().modify(|w| w.set_txftie(false));
    }
    may_send
}

/// Index in the ring of the byte that DMA writes next.
fn written() -> u32 {
    let left = u32::from(DMA1.st(RECEIVE).ndtr().read().ndt());
    (RING_BYTES as u32).wrapping_sub(left) % RING_BYTES as u32
}

/// Whether a byte waits to be fetched.
pub fn has_byte() -> bool {
    TAKEN.load(Ordering::Relaxed) != written()
}

/// At the end of a tick: makes the interrupt if bytes have arrived since the line was last silent.
pub fn pend_if_waiting() {
    if LISTENS.load(Ordering::Relaxed) && has_byte() {
        NVIC::pend(Interrupt::USART3);
    }
}

/// Whether the receiving side interrupts.
pub fn listen(listens: bool) {
    LISTENS.store(listens, Ordering::Relaxed);
    with(|_| USART3.cr1().modify(|w| w.set_idleie(listens)));
}
