//! The jumpers of docs/bring-up.md, and whether they are there.
//!
//! In: levels at the ends while one pin is driven. Out: lines. Owns the pins at which captures end:
//! PA0, PA3, PA15, PB3, PB10, PB11; and PG14, which drives the interlock.
use crate::report::Report;
use hal::stm32h743::boards::BOARD;
use hal::stm32h743::pins::PinLevels;
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Idr, Moder, Pupdr};
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

/// Jumpers, from the first: the pin that drives, and the end.
const JUMPERS: [(GpioPin, End); 6] = [
    ((GPIOE, 9), ENERGY_0),
    ((GPIOE, 5), ENERGY_1),
    ((GPIOC, 7), SWITCH_0),
    ((GPIOF, 8), STEP_1),
    ((GPIOE, 8), MINUS_0),
    (DRIVER, INTERLOCK),
];
/// The sixth is driven by this pin.
const DRIVER: GpioPin = (GPIOG, 14);

fn reads_high((port, pin): GpioPin) -> bool {
    port.idr().read().idr(pin) == Idr::HIGH
}

fn settle() {
    // A pull takes some hundred ns to a level.
    cortex_m::asm::delay(4800);
}

/// The level at an end.
pub fn is_high(end: End) -> bool {
    reads_high(end.pin)
}

fn drive((port, pin): GpioPin, high: bool) {
    port.bsrr().write(|w| if high { w.set_bs(pin, true) } else { w.set_br(pin, true) });
}

fn input((port, pin): GpioPin, pull: Pupdr) {
    port.pupdr().modify(|w| w.set_pupdr(pin, pull));
    port.moder().modify(|w| w.set_moder(pin, Moder::INPUT));
}

/// Opens the interlock, or closes it, where the sixth jumper is.
pub fn open_interlock(open: bool) {
    drive(DRIVER, open);
}

/// The ends as captures: alternate function 1, of the two ends of a channel the one that is named.
pub fn connect(ends: &[End]) {
    for (_, all) in JUMPERS {
        let (port, pin) = all.pin;
        let named = ends.iter().any(|end| end.pin == all.pin);
        if named {
            port.afr(pin / 8).modify(|w| w.set_afr(pin % 8, 1));
        }
        port.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::FLOATING));
        port.moder().modify(|w| w.set_moder(pin, if named { Moder::ALTERNATE } else { Moder::ANALOG }));
    }
}

/// The ends, a bit each, that follow a pin which is driven to the other level than its own and
/// back. An end that nobody drives stays at the level of its pull.
fn following(from: GpioPin) -> u32 {
    let (port, pin) = from;
    let (mode, own) = (port.moder().read().moder(pin), reads_high(from));
    let mut follow = (1 << JUMPERS.len()) - 1;
    // The interlock's contacts take part in its jumper alone.
    let mut breaks_follow = true;
    drive(from, own);
    port.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
    for level in [own, !own, own] {
        drive(from, level);
        settle();
        for (n, (_, end)) in JUMPERS.into_iter().enumerate() {
            follow &= !(u32::from(is_high(end) != level) << n);
        }
        breaks_follow &= PinLevels::read().breaks() == [level; 3];
    }
    port.moder().modify(|w| w.set_moder(pin, mode));
    let interlock = 1 << (JUMPERS.len() - 1);
    if breaks_follow { follow } else { follow & !interlock }
}

/// Reports the levels of the laser lines at rest, and where each jumper ends: the bits of the ends
/// that follow its pin. The lasers rest meanwhile, and a pin of theirs is driven for some µs: only
/// on a bench, so where the sixth jumper is not as it should be, no other one is looked for. The
/// jumpers of the converters are found by their voltages. True if the sixth is as it should be.
pub fn report_to(report: &mut Report) -> bool {
    settle();
    report.line("rest", &BOARD.lasers.map(|(pin, _)| reads_high(pin).into()));
    listen();
    let of_driver = following(DRIVER);
    let is_bench = is_driven(of_driver);
    for (number, (from, _)) in (1..).zip(JUMPERS) {
        let ends = match from {
            DRIVER => of_driver,
            from if is_bench => following(from),
            _ => 0,
        };
        report.line("wire", &[number, ends.into()]);
    }
    is_bench
}

/// Whether the sixth jumper is as it should be: no machine has its interlock at a general output.
/// The lasers rest meanwhile.
pub fn has_driver() -> bool {
    listen();
    let ends = following(DRIVER);
    // The interlock was open for some microseconds.
    hal::board::laser::was_broken();
    is_driven(ends)
}

/// The ends become inputs, each with the pull that says what it is without a jumper.
fn listen() {
    for (_, end) in JUMPERS {
        input(end.pin, if end.pin == INTERLOCK.pin { Pupdr::PULL_UP } else { Pupdr::PULL_DOWN });
    }
    settle();
}

/// Whether the interlock, and nothing else, follows.
fn is_driven(ends: u32) -> bool {
    ends == 1 << (JUMPERS.len() - 1)
}
