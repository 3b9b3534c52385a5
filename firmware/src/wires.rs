//! The transports of the host link: the UART, and USB where the board has it.
//!
//! In and out: bytes of either, never waiting. Owns both. The link uses the transport over which
//! the session in force was opened. A client may open a session anew over the other one, and then
//! the link uses that. Fails never: a transport that takes nothing keeps its own bytes waiting.
use crate::statics::RECEIVED_BYTES;
#[cfg(feature = "stm32h743")]
use crate::usb::Port;
use dispatcher::{SecondaryTransport, Server};
use hal::board::AXES;
use hal::board::uart::Tx;
use ring::Consumer;
use servo::units::Ns;

/// A destination of bytes.
pub trait Sink {
    /// Takes as many of these as it can, from the first on, and returns how many.
    fn send(&mut self, bytes: &[u8]) -> usize;
    /// No more bytes follow for now.
    fn end(&mut self) {}
}

impl Sink for Tx {
    fn send(&mut self, bytes: &[u8]) -> usize {
        bytes.iter().take_while(|byte| Tx::send(self, **byte)).count()
    }
}

#[cfg(feature = "stm32h743")]
impl Sink for Port {
    fn send(&mut self, bytes: &[u8]) -> usize {
        Port::send(self, bytes)
    }

    fn end(&mut self) {
        Port::end(self);
    }
}

/// A buffer of bytes to send.
pub struct Outflow<const N: usize> {
    bytes: [u8; N],
    from: usize,
    to: usize,
}

impl<const N: usize> Outflow<N> {
    /// Empty.
    pub const fn new() -> Self {
        Outflow { bytes: [0; N], from: 0, to: 0 }
    }

    /// Sends until the sink takes no more, at most `limit` bytes; `more` refills the buffer. True
    /// if the limit ended it.
    pub fn pump(&mut self, sink: &mut dyn Sink, limit: usize, mut more: impl FnMut(&mut [u8]) -> usize) -> bool {
        let mut left = limit;
        loop {
            if self.from >= self.to {
                self.from = 0;
                self.to = more(&mut self.bytes).min(N);
                if self.to == 0 {
                    sink.end();
                    return false;
                }
            }
            if left == 0 {
                return true;
            }
            let waiting = self.bytes.get(self.from..self.to).unwrap_or(&[]);
            let taken = sink.send(waiting.get(..left).unwrap_or(waiting));
            if taken == 0 {
                return false;
            }
            self.from += taken;
            left -= taken;
        }
    }
}

/// A transport.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wire {
    /// The UART.
    Uart,
    /// USB.
    #[cfg(feature = "stm32h743")]
    Usb,
}

impl Wire {
    /// The name that a client on the other transport gets.
    const fn name(self) -> &'static str {
        match self {
            Wire::Uart => "the UART",
            #[cfg(feature = "stm32h743")]
            Wire::Usb => "USB",
        }
    }
}

/// See the module text.
pub struct Wires {
    /// Bytes that the UART has received.
    pub bytes: Consumer<'static, u8, RECEIVED_BYTES>,
    /// The UART's sending half.
    pub uart: Tx,
    /// USB.
    #[cfg(feature = "stm32h743")]
    pub usb: Option<Port>,
    /// The transport of the link.
    pub link: Wire,
    /// The session take-over on the other transport.
    pub second: SecondaryTransport,
    /// Bytes to send over the link.
    pub out: Outflow<512>,
    /// Bytes to send over the other transport.
    pub answer: Outflow<32>,
}

impl Wires {
    /// Passes all that has arrived to the server.
    pub fn receive(&mut self, now: Ns, server: &mut Server<'static, AXES>) {
        loop {
            let mut chunk = [0; 256];
            let mut length = 0;
            while let Some(target) = chunk.get_mut(length) {
                let Some(byte) = self.bytes.pop() else { break };
                *target = byte;
                length += 1;
            }
            if length == 0 {
                break;
            }
            self.take(Wire::Uart, now, server, chunk.get(..length).unwrap_or(&[]));
        }
        #[cfg(feature = "stm32h743")]
        // At most as much as the UART's queue holds: the link's timers are served in between.
        for _ in 0..RECEIVED_BYTES / hal::board::usb::PACKET_BYTES {
            let mut packet = [0; hal::board::usb::PACKET_BYTES];
            let length = self.usb.as_mut().map_or(0, |port| port.receive(&mut packet));
            if length == 0 {
                break;
            }
            self.take(Wire::Usb, now, server, packet.get(..length).unwrap_or(&[]));
        }
    }

    fn take(&mut self, from: Wire, now: Ns, server: &mut Server<'static, AXES>, bytes: &[u8]) {
        let mut unread = bytes;
        if from != self.link {
            let (used, taken_up) = self.second.feed(now, server, Some(self.link.name()), unread);
            unread = unread.get(used..).unwrap_or(&[]);
            if taken_up {
                self.link = from;
                (self.out, self.answer) = (Outflow::new(), Outflow::new());
            }
        }
        if from == self.link {
            server.feed(now, unread);
        }
    }

    /// Sends what the server has to send.
    pub fn send(&mut self, server: &mut Server<'static, AXES>) {
        #[cfg(feature = "stm32h743")]
        if let Some(port) = &mut self.usb {
            let (link, second): (&mut dyn Sink, &mut dyn Sink) = match self.link {
                Wire::Uart => (&mut self.uart, port),
                Wire::Usb => (port, &mut self.uart),
            };
            self.answer.pump(second, usize::MAX, |out| self.second.take_tx(out));
            self.out.pump(link, usize::MAX, |out| server.take_tx(out));
            return;
        }
        self.out.pump(&mut self.uart, usize::MAX, |out| server.take_tx(out));
    }
}
