//! DAC8563: two channels of 16 bits on SPI, at mid-scale from power-on (data sheet SLAS719, "Serial
//! interface").
//!
//! In: codes, −32768…32767. Out: frames of 24 bits: command, channel, straight binary. Owns the bus
//! and the chip select. Fails as the bus does.
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiBus;

/// The command that writes a channel and updates its output.
const WRITE: u8 = 0b011 << 3;

/// Least time for which the chip select is high between two frames (data sheet, "minimum SYNC high
/// time"); after less, the second frame is ignored.
pub const BETWEEN_NS: u32 = 80;

/// The part, on a bus in SPI mode 1, 50 MHz at most.
#[derive(Debug)]
pub struct Dac8563<BUS, SELECT, PAUSE> {
    /// Its bus.
    pub bus: BUS,
    /// Low during a frame.
    pub select: SELECT,
    /// Waits, once the chip select has the level that was written.
    pub pause: PAUSE,
}

impl<BUS: SpiBus, SELECT: OutputPin, PAUSE: DelayNs> Dac8563<BUS, SELECT, PAUSE> {
    /// Outputs a code on channel 0 or 1; 0 is mid-scale.
    pub fn write(&mut self, channel: u8, code: i16) -> Result<(), BUS::Error> {
        let [high, low] = (code as u16 ^ 0x8000).to_be_bytes();
        // A line of a port cannot fail.
        let _ = self.select.set_low();
        let done = self.bus.write(&[WRITE | channel & 1, high, low]).and_then(|()| self.bus.flush());
        let _ = self.select.set_high();
        self.pause.delay_ns(BETWEEN_NS);
        done
    }
}
