//! What the world does to the board, and what it gets from it.
//!
//! In: bytes of the host, levels at pins, the supply. Out: bytes of the board. Owns nothing. Fails
//! never.
use crate::gpio::Pin;
use crate::machine::Machine;
use crate::time::Time;

impl Machine {
    /// The host sends bytes over the link.
    pub fn send(&mut self, bytes: &[u8]) {
        let chip = &mut self.chip;
        chip.bus.usart.host_sends(bytes, chip.now);
        chip.bus.stir(chip.now, &mut chip.scs.exceptions);
    }

    /// Takes the bytes that the board has sent, with their instants.
    pub fn take_sent(&mut self) -> Vec<(Time, u8)> {
        std::mem::take(&mut self.chip.bus.usart.sent)
    }

    /// The cable of USB is put in, or pulled out.
    pub fn plug_usb(&mut self, there: bool) {
        let chip = &mut self.chip;
        chip.bus.usb.plug(there, chip.now);
        chip.bus.stir(chip.now, &mut chip.scs.exceptions);
    }

    /// The host sends bytes to the port that it has found at USB.
    pub fn send_usb(&mut self, bytes: &[u8]) {
        self.chip.bus.usb.host.send(bytes);
    }

    /// Takes the bytes that the host has received over USB, with their instants.
    pub fn take_sent_usb(&mut self) -> Vec<(Time, u8)> {
        std::mem::take(&mut self.chip.bus.usb.host.received)
    }

    /// The supply has this voltage from now on.
    pub fn supply(&mut self, supply_mv: u32) {
        let chip = &mut self.chip;
        chip.bus.supply(supply_mv, chip.now, &mut chip.scs.exceptions);
    }

    /// The world drives a pin, or lets it go.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>) {
        let chip = &mut self.chip;
        chip.bus.drive(pin, level, chip.now, &mut chip.scs.exceptions);
    }
}
