//! The frames of the external DAC's driver, on a bus that writes down what it gets.
#[path = "../../hal/src/dac8563.rs"]
mod dac8563;
use dac8563::Dac8563;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, SpiBus};
use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

#[derive(Debug, Clone, PartialEq)]
enum Seen {
    Select(bool),
    Bytes(Vec<u8>),
    Flush,
    Pause(u32),
}

#[derive(Clone, Default)]
struct Wire(Rc<RefCell<Vec<Seen>>>);

impl Wire {
    fn see(&self, what: Seen) {
        self.0.borrow_mut().push(what);
    }
}

impl spi::ErrorType for Wire {
    type Error = Infallible;
}

impl SpiBus for Wire {
    fn read(&mut self, _: &mut [u8]) -> Result<(), Infallible> {
        unreachable!("it is only written to")
    }
    fn write(&mut self, words: &[u8]) -> Result<(), Infallible> {
        self.see(Seen::Bytes(words.to_vec()));
        Ok(())
    }
    fn transfer(&mut self, _: &mut [u8], _: &[u8]) -> Result<(), Infallible> {
        unreachable!("it is only written to")
    }
    fn transfer_in_place(&mut self, _: &mut [u8]) -> Result<(), Infallible> {
        unreachable!("it is only written to")
    }
    fn flush(&mut self) -> Result<(), Infallible> {
        self.see(Seen::Flush);
        Ok(())
    }
}

impl digital::ErrorType for Wire {
    type Error = Infallible;
}

impl OutputPin for Wire {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.see(Seen::Select(false));
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.see(Seen::Select(true));
        Ok(())
    }
}

impl DelayNs for Wire {
    fn delay_ns(&mut self, ns: u32) {
        self.see(Seen::Pause(ns));
    }
}

#[test]
fn a_code_is_one_frame_of_straight_binary() {
    let wire = Wire::default();
    let mut dac = Dac8563 { bus: wire.clone(), select: wire.clone(), pause: wire.clone() };
    // Command 011, write and update; addresses 000 and 001.
    let cases = [
        (0, 0, [0x18, 0x80, 0x00]),
        (1, 0, [0x19, 0x80, 0x00]),
        (0, i16::MIN, [0x18, 0x00, 0x00]),
        (1, i16::MAX, [0x19, 0xff, 0xff]),
        (0, -1, [0x18, 0x7f, 0xff]),
        (0, 0x1234, [0x18, 0x92, 0x34]),
    ];
    for (channel, code, frame) in cases {
        wire.0.borrow_mut().clear();
        dac.write(channel, code).unwrap();
        // 80 ns without the part before the next frame.
        let bytes = Seen::Bytes(frame.to_vec());
        let expected = [Seen::Select(false), bytes, Seen::Flush, Seen::Select(true), Seen::Pause(80)];
        assert_eq!(*wire.0.borrow(), expected, "{code} on {channel}");
    }
}
