//! The lines that the host reads.
//!
//! In: a name and whole numbers. Out: `NAME NUMBER…*XX`, where XX is the exclusive or of all bytes
//! before the star, in hex digits (as in NMEA 0183). A person reads them in any terminal. Lines
//! that begin with `#` are for people alone. Owns the sending half of the link. It waits until the
//! link takes a byte. Fails never.
use crate::{A_BYTE, pause};
use core::fmt::{self, Write};
use core::panic::PanicInfo;
use hal::board::{self, uart::Tx, watchdog};
use stm32_metapac::USART3;

/// The lines of a run.
pub struct Report {
    tx: Tx,
    lines: i64,
    sum: u8,
}

impl Report {
    /// A run over this link.
    pub fn to(tx: Tx) -> Report {
        Report { tx, lines: 0, sum: 0 }
    }

    /// Sends a line.
    pub fn line(&mut self, name: &str, numbers: &[i64]) {
        self.list(name, numbers.iter().copied());
    }

    /// Sends a line of numbers that are nowhere together.
    pub fn list(&mut self, name: &str, numbers: impl Iterator<Item = i64>) {
        self.lines += 1;
        self.sum = 0;
        // Writing to the link never fails.
        let _ = self.write_str(name);
        for number in numbers {
            let _ = write!(self, " {number}");
        }
        let sum = self.sum;
        let _ = write!(self, "*{sum:02X}\r\n");
    }

    /// Sends a line with the bytes of a text.
    pub fn name(&mut self, name: &str, text: &str) {
        let mut bytes = [0; 16];
        let count = text.len().min(bytes.len());
        bytes.iter_mut().zip(text.bytes()).for_each(|(to, from)| *to = from.into());
        self.line(name, &bytes[..count]);
    }

    /// The last line: how many came before it. Returns once all has left the chip.
    pub fn end(&mut self) {
        self.end_at_once();
        self.flush();
    }

    /// The same; the UART's FIFO takes the line, once all others have left the chip.
    pub fn end_at_once(&mut self) {
        self.line("end", &[self.lines]);
    }

    /// Returns once all has left the chip.
    pub fn flush(&mut self) {
        while !USART3.isr().read().tc() {
            pause::cycles(A_BYTE / 8);
        }
    }

    /// Sends a line for people, and returns once it has left the chip.
    pub fn remark(&mut self, text: &str) {
        // Writing to the link never fails.
        let _ = write!(self, "# {text}\r\n");
        self.flush();
    }

    /// Sends bytes for nobody, in a line for people.
    pub fn fill(&mut self, bytes: usize) {
        for n in 0..bytes {
            let byte = match n {
                0 => b'#',
                n if n + 1 == bytes => b'\n',
                _ => b'.',
            };
            self.send(byte);
        }
    }

    fn send(&mut self, byte: u8) {
        while !self.tx.send(byte) {
            // Half of the FIFO.
            pause::cycles(8 * A_BYTE);
        }
    }
}

impl Write for Report {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.sum ^= byte;
            self.send(byte);
        }
        Ok(())
    }
}

/// Says why a run ended early. It bypasses the link's halves, which somebody else may hold.
struct Last;

impl Write for Last {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            while !USART3.isr().read().txe() {}
            USART3.tdr().write(|w| w.set_dr(byte.into()));
        }
        Ok(())
    }
}

/// Ends the run: the outputs are in the safe state, and the watchdog resets the chip.
pub fn stop(reason: fmt::Arguments<'_>) -> ! {
    board::safe_state();
    watchdog::feed();
    // The next run begins like the first one.
    crate::before::forget();
    // Before start-up the UART has no clock, and nobody could read it.
    if stm32_metapac::RCC.apb1lenr().read().usart3en() {
        // Writing to the link never fails.
        let _ = write!(Last, "\r\n# {reason}\r\n");
    }
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panicked(info: &PanicInfo<'_>) -> ! {
    stop(format_args!("{info}"))
}

#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    stop(format_args!("hard fault at {:#010x}", frame.pc()))
}

#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) {
    stop(format_args!("interrupt {number} without a handler"))
}
