//! The jumpers of docs/bring-up.md, and whether they are there.
//!
//! In: levels at both ends. Out: lines. Owns the pins at which captures end: PA0, PA3, PA15, PB3,
//! PB10, PB11, and PG14, which drives the interlock.
use crate::report::Report;
use hal::stm32h743::boards::BOARD;
use hal::stm32h743::pins::PinLevels;
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Moder, Pupdr};
use stm32_metapac::{GPIOA, GPIOB, GPIOC, GPIOE, GPIOF, GPIOG};

type GpioPin = (Gpio, usize);

/// An end at which TIM2 captures, and the channel, from 0 (alternate function 1).
#[derive(Clone, Copy)]
pub struct End {
    pin: GpioPin,
    /// TIM2's channel.
    pub channel: usize,
}

/// Energy + of laser 0.
pub const ENERGY_0: End = End { pin: (GPIOA, 0), channel: 0 };
/// Energy + of laser 1.
pub const ENERGY_1: End = End { pin: (GPIOB, 3), channel: 1 };
/// Switch + of laser 0.
pub const SWITCH_0: End = End { pin: (GPIOB, 10), channel: 2 };
/// Step of axis 1.
pub const STEP_1: End = End { pin: (GPIOA, 3), channel: 3 };
/// Energy − of laser 0.
pub const MINUS_0: End = End { pin: (GPIOB, 11), channel: 3 };
/// The interlock.
pub const INTERLOCK: End = End { pin: (GPIOA, 15), channel: 0 };

/// Jumpers by their numbers: the pin that is driven, and the end.
const JUMPERS: [(i64, GpioPin, End); 5] = [
    (1, (GPIOE, 9), ENERGY_0),
    (2, (GPIOE, 5), ENERGY_1),
    (3, (GPIOC, 7), SWITCH_0),
    (4, (GPIOF, 8), STEP_1),
    (5, (GPIOE, 8), MINUS_0),
];
/// The sixth is driven by this pin.
const DRIVER: GpioPin = (GPIOG, 14);

fn is_high((port, pin): GpioPin) -> bool {
    // A pull takes some hundred ns to a level.
    cortex_m::asm::delay(4800);
    port.idr().read().idr(pin) == stm32_metapac::gpio::vals::Idr::HIGH
}

fn input((port, pin): GpioPin, pull: Pupdr) {
    port.pupdr().modify(|w| w.set_pupdr(pin, pull));
    port.moder().modify(|w| w.set_moder(pin, Moder::INPUT));
}

/// Opens the interlock, or closes it, where the sixth jumper is.
pub fn open_interlock(open: bool) {
    let (port, pin) = DRIVER;
    port.bsrr().write(|w| if open { w.set_bs(pin, true) } else { w.set_br(pin, true) });
}

/// The ends as captures: alternate function 1, of the two ends of a channel the one that is named.
pub fn connect(ends: &[End]) {
    for all in JUMPERS.map(|(_, _, end)| end).into_iter().chain([INTERLOCK]) {
        let (port, pin) = all.pin;
        let named = ends.iter().any(|end| end.pin == all.pin);
        if named {
            port.afr(pin / 8).modify(|w| w.set_afr(pin % 8, 1));
        }
        port.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::FLOATING));
        port.moder().modify(|w| w.set_moder(pin, if named { Moder::ALTERNATE } else { Moder::ANALOG }));
    }
}

/// Reports the levels of the laser lines at rest, and which jumpers are there; the lasers rest
/// meanwhile. Those of the converters are found by their voltages. True if the sixth is there.
pub fn report_to(report: &mut Report) -> bool {
    report.line("rest", &BOARD.lasers.map(|(pin, _)| is_high(pin).into()));
    for (number, from, end) in JUMPERS {
        // A pull against the level at rest: the end follows only its driver.
        let rests_high = is_high(from);
        input(end.pin, if rests_high { Pupdr::PULL_DOWN } else { Pupdr::PULL_UP });
        report.line("wire", &[number, (is_high(end.pin) == rests_high).into()]);
    }
    input(INTERLOCK.pin, Pupdr::PULL_UP);
    let mut follows = true;
    for open in [true, false] {
        open_interlock(open);
        follows &= is_high(INTERLOCK.pin) == open && PinLevels::read().breaks() == [open; 3];
    }
    report.line("wire", &[6, follows.into()]);
    follows
}
