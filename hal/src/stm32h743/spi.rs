//! SPI3 to an external DAC (RM0433 50): 32 MHz from the HSI, mode 1.
//!
//! In: bytes. Out: the same on SCK and MOSI, with a pin for the chip select. Owns SPI3. It waits
//! for the end of what it sends, some 0.3 µs a byte. Fails: [`Silent`], if the peripheral does not
//! finish; [`restart`] drops what it was at.
use super::boards::BOARD;
use super::clocks::CORE_HZ;
use super::wiring::Pin;
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{Error, ErrorKind, ErrorType, SpiBus};
use stm32_metapac::rcc::vals::Saisel;
use stm32_metapac::spi::vals::{Cpha, Master};
use stm32_metapac::{RCC, SPI3};

/// Polls of a flag before the peripheral is given up: a few microseconds.
const MAX_POLLS: u32 = 100;

/// The peripheral does not finish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Silent;

impl Error for Silent {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// SPI3.
#[derive(Debug)]
pub struct Bus(());

/// The board's pin for it.
#[derive(Debug)]
pub struct Select(());

/// Waits, from when the chip select has the level that was set.
#[derive(Debug)]
pub struct Pause(());

/// The chip select.
const SELECT: Pin = BOARD.dac_select;

/// Switches SPI3 on; its pins are given by [`super::pins`].
///
/// # Safety
/// At most once.
pub unsafe fn open() -> (Bus, Select, Pause) {
    // per_ck is the HSI, 64 MHz, as after reset (RM0433 8.7.19).
    RCC.d2ccip1r().modify(|w| w.set_spi123sel(Saisel::PER));
    RCC.apb1lenr().modify(|w| w.set_spi3en(true));
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.apb1lenr().read();
    set_up();
    again()
}

fn set_up() {
    // Divided by 2; items of 8 bits.
    SPI3.cfg1().write(|w| w.set_dsize(7));
    // SSI before MASTER: else the internal chip select would end the master mode (RM0433 50.4.6).
    SPI3.cr1().write(|w| w.set_ssi(true));
    SPI3.cfg2().write(|w| {
        w.set_ssm(true);
        w.set_cpha(Cpha::SECOND_EDGE);
        // The peripheral keeps the pins between two transfers.
        w.set_afcntr(true);
        w.set_master(Master::MASTER);
    });
    SPI3.cr1().modify(|w| w.set_spe(true));
    SPI3.cr1().modify(|w| w.set_cstart(true));
}

/// The set that start-up has opened; or a second one before a reset, when the owner does not run
/// any more.
pub(super) fn again() -> (Bus, Select, Pause) {
    (Bus(()), Select(()), Pause(()))
}

/// Drops a frame that is under way: the chip select goes high, so the receiver ignores it, and the
/// peripheral begins anew with empty FIFOs. Else a byte of it would be taken for an answer to the
/// next frame's.
#[cold]
#[inline(never)]
pub(super) fn restart() {
    let Ok(()) = Select(()).set_high();
    RCC.apb1lrstr().modify(|w| w.set_spi3rst(true));
    RCC.apb1lrstr().modify(|w| w.set_spi3rst(false));
    RCC.apb1lrstr().read();
    set_up();
    Pause(()).delay_ns(crate::dac8563::BETWEEN_NS);
}

impl Bus {
    /// Sends a byte and receives one.
    fn exchange(&mut self, byte: u8) -> Result<u8, Silent> {
        SPI3.txdr8().write_value(byte);
        for _ in 0..MAX_POLLS {
            if SPI3.sr().read().rxp() {
                return Ok(SPI3.rxdr8().read());
            }
        }
        Err(Silent)
    }
}

impl ErrorType for Bus {
    type Error = Silent;
}

impl SpiBus for Bus {
    fn read(&mut self, words: &mut [u8]) -> Result<(), Silent> {
        words.iter_mut().try_for_each(|word| self.exchange(0).map(|byte| *word = byte))
    }

    fn write(&mut self, words: &[u8]) -> Result<(), Silent> {
        words.iter().try_for_each(|word| self.exchange(*word).map(|_| ()))
    }

    fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), Silent> {
        for index in 0..read.len().max(write.len()) {
            let byte = self.exchange(write.get(index).copied().unwrap_or(0))?;
            if let Some(received) = read.get_mut(index) {
                *received = byte;
            }
        }
        Ok(())
    }

    fn transfer_in_place(&mut self, words: &mut [u8]) -> Result<(), Silent> {
        words.iter_mut().try_for_each(|word| self.exchange(*word).map(|byte| *word = byte))
    }

    fn flush(&mut self) -> Result<(), Silent> {
        // Each byte has been waited for.
        Ok(())
    }
}

impl digital::ErrorType for Select {
    type Error = Infallible;
}

impl OutputPin for Select {
    fn set_low(&mut self) -> Result<(), Infallible> {
        SELECT.0.bsrr().write(|w| w.set_br(SELECT.1, true));
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        SELECT.0.bsrr().write(|w| w.set_bs(SELECT.1, true));
        Ok(())
    }
}

impl DelayNs for Pause {
    fn delay_ns(&mut self, ns: u32) {
        // The read waits until earlier writes are done.
        SELECT.0.odr().read();
        cortex_m::asm::delay(ns.saturating_mul(CORE_HZ / 1_000_000) / 1000 + 1);
    }
}
