//! The pins of the board ([`BOARD`]) and their levels.
//!
//! In: levels of outputs. Out: levels of inputs. Owns the GPIO ports. Until [`open`] every pin is
//! analog, as the reset has left it; afterwards every pin that the board does not name still is.
//! [`safe_state`] makes the outputs analog again. Fails never.
use super::boards::BOARD;
use super::wiring::{Assigned, Pin, number_of};
use servo::output::step_generator;
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs};
use stm32_metapac::RCC;
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Moder, Ospeedr, Pupdr};

/// Axes: as many as have a step output.
pub const AXES: usize = step_generator::AXES;

/// General inputs.
pub const GENERAL_INPUTS: usize = BOARD.general_in.len();
/// General outputs.
pub const GENERAL_OUTPUTS: usize = BOARD.general_out.len();

/// Ports of all pins, and of those that ticks drive.
const PORTS: [Gpio; BOARD.uses().count()] = BOARD.uses().ports();
const OUT: [Gpio; BOARD.driven_in_ticks().count()] = BOARD.driven_in_ticks().ports();
/// The inputs of axes, a bit each, of every port.
const OF_AXES: [u16; PORTS.len()] = BOARD.axis_inputs().of(&PORTS);

/// Gives a port its clock.
fn clock(port: Gpio) {
    // The ports lie in the order of their bits (RM0433 8.7.44).
    RCC.ahb4enr().modify(|w| w.0 |= 1 << number_of(port));
}

/// Gives all ports of the board their clock.
pub fn give_clocks() {
    PORTS.iter().for_each(|port| clock(*port));
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.ahb4enr().read();
}

/// Configures the inputs, drives the outputs low and assigns the link's pins to USART3.
///
/// # Safety
/// Once, after [`give_clocks`], before anything else writes a port.
pub unsafe fn open() {
    let of_axes = [BOARD.limit_positive, BOARD.limit_negative, BOARD.home, BOARD.alarm];
    for pin in of_axes.into_iter().flatten().chain(BOARD.general_in) {
        input(*pin, Pupdr::PULL_DOWN);
    }
    for pin in BOARD.breaks.iter().map(|input| input.pin.0).chain(BOARD.pulled_up.iter().copied()) {
        // A broken wire reads as an active interlock.
        input(pin, Pupdr::PULL_UP);
    }
    set(0, 0);
    for pin in 0..2 * AXES {
        // Low, as the reset has left the port.
        BOARD.steps.ospeedr().modify(|w| w.set_ospeedr(pin, Ospeedr::MEDIUM_SPEED));
        BOARD.steps.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
    }
    BOARD.driven_low.iter().for_each(|(port, pin)| port.bsrr().write(|w| w.set_br(*pin, true)));
    for &(port, pin) in BOARD.enable.iter().chain(BOARD.general_out).chain(BOARD.driven_low) {
        port.ospeedr().modify(|w| w.set_ospeedr(pin, Ospeedr::LOW_SPEED));
        port.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
    }
    // SAFETY: the caller's promise.
    unsafe { open_link() };
    // A line that is not connected does not count.
    pulled(&BOARD.encoders, Pupdr::PULL_UP, Ospeedr::LOW_SPEED);
    pulled(&BOARD.indexes, Pupdr::PULL_DOWN, Ospeedr::LOW_SPEED);
}

/// Assigns the link's pins to USART3.
///
/// # Safety
/// Once, after [`give_clocks`], before anything else writes their ports.
pub unsafe fn open_link() {
    pulled(&BOARD.link, Pupdr::PULL_UP, Ospeedr::HIGH_SPEED);
}

/// Gives the pins of an external DAC to SPI3; it is not selected.
///
/// # Safety
/// Once, before anything else writes their ports.
pub unsafe fn open_dac() {
    let (port, pin) = BOARD.dac_select;
    BOARD.dac.iter().map(|((port, _), _)| *port).chain([port]).for_each(clock);
    RCC.ahb4enr().read();
    // Not selected, then driven.
    port.bsrr().write(|w| w.set_bs(pin, true));
    port.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
    BOARD.dac.into_iter().for_each(|pin| assign(pin, Ospeedr::HIGH_SPEED));
}

/// Lights the board's LED, if it has one, and nothing else: the image refuses this chip. The LED
/// may be a general output too, so nothing may be connected to that.
pub fn show_refusal() {
    let Some((port, pin)) = BOARD.led else { return };
    clock(port);
    RCC.ahb4enr().read();
    port.bsrr().write(|w| w.set_bs(pin, true));
    port.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
}

/// Assigns pins with a pull to their peripherals.
fn pulled(pins: &[Assigned], pull: Pupdr, speed: Ospeedr) {
    for &((port, pin), function) in pins {
        port.pupdr().modify(|w| w.set_pupdr(pin, pull));
        assign(((port, pin), function), speed);
    }
}

/// Assigns a pin to a peripheral.
fn assign(((port, pin), function): Assigned, speed: Ospeedr) {
    port.afr(pin / 8).modify(|w| w.set_afr(pin % 8, function));
    port.ospeedr().modify(|w| w.set_ospeedr(pin, speed));
    port.moder().modify(|w| w.set_moder(pin, Moder::ALTERNATE));
}

/// Assigns the break inputs and the laser outputs to their timers; levels of the inputs are read as
/// before.
///
/// # Safety
/// Once, after [`open`], while the timers hold their outputs in the safe state.
pub unsafe fn open_lasers() {
    for ((port, pin), function) in BOARD.breaks.iter().map(|input| input.pin).chain(BOARD.lasers) {
        port.afr(pin / 8).modify(|w| w.set_afr(pin % 8, function));
        port.ospeedr().modify(|w| w.set_ospeedr(pin, Ospeedr::HIGH_SPEED));
        port.moder().modify(|w| w.set_moder(pin, Moder::ALTERNATE));
    }
}

/// Assigns USB's lines to the core, and the host's 5 V where the board leads them to the chip and
/// `senses_vbus`.
///
/// # Safety
/// Once, after [`open`].
pub unsafe fn open_usb(senses_vbus: bool) {
    if let Some(pin) = BOARD.usb.vbus.filter(|_| senses_vbus) {
        input(pin, Pupdr::FLOATING);
    }
    BOARD.usb.lines.into_iter().for_each(|pin| assign(pin, Ospeedr::VERY_HIGH_SPEED));
}

fn input((port, pin): Pin, pull: Pupdr) {
    port.pupdr().modify(|w| w.set_pupdr(pin, pull));
    port.moder().modify(|w| w.set_moder(pin, Moder::INPUT));
}

/// Every output high-impedance again.
pub fn safe_state() {
    BOARD.steps.moder().write(|w| (0..2 * AXES).for_each(|pin| w.set_moder(pin, Moder::ANALOG)));
    for &port in &OUT {
        for &(owner, pin) in BOARD.enable.iter().chain(BOARD.general_out) {
            if owner == port {
                port.moder().modify(|w| w.set_moder(pin, Moder::ANALOG));
            }
        }
    }
}

/// Servo-enable lines, a bit an axis, and general outputs; all of a port change at once.
pub fn set(enable: u64, general: GeneralOutputs) {
    for &port in &OUT {
        let mut word = 0;
        let outputs = BOARD.enable.iter().zip(0..).map(|(pin, bit)| (pin, enable >> bit & 1 == 1));
        let general = BOARD.general_out.iter().zip(0..).map(|(pin, bit)| (pin, general >> bit & 1 == 1));
        for (&(owner, pin), level) in outputs.chain(general) {
            if owner == port {
                word |= 1u32 << (pin + if level { 0 } else { 16 });
            }
        }
        port.bsrr().write(|w| w.0 = word);
    }
}

/// Levels of all inputs of one tick; the ports are read one after the other.
#[derive(Debug, Clone, Copy, Default)]
pub struct PinLevels {
    ports: [u16; PORTS.len()],
}

impl PinLevels {
    /// Nothing is high.
    pub const LOW: PinLevels = PinLevels { ports: [0; PORTS.len()] };

    /// As they are now.
    pub fn read() -> PinLevels {
        let mut levels = PinLevels::LOW;
        for (level, port) in levels.ports.iter_mut().zip(&PORTS) {
            *level = port.idr().read().0 as u16;
        }
        levels
    }

    /// A pin whose port the board does not list reads as high: an open interlock, an active limit.
    fn at(&self, (port, pin): Pin) -> bool {
        let found = PORTS.iter().zip(self.ports).find(|(owner, _)| **owner == port);
        found.is_none_or(|(_, levels)| levels >> pin & 1 == 1)
    }

    fn of(&self, pins: &[Pin], index: usize) -> bool {
        pins.get(index).is_some_and(|pin| self.at(*pin))
    }

    /// The inputs of all axes, as [`AxisInputs::bits`].
    pub fn axes(&self) -> [u8; AXES] {
        core::array::from_fn(|axis| {
            let of = |pins: &[Pin]| self.of(pins, axis);
            let [limit_positive, limit_negative] = [of(BOARD.limit_positive), of(BOARD.limit_negative)];
            let [alarm, home] = [of(BOARD.alarm), of(BOARD.home)];
            AxisInputs { limit_positive, limit_negative, alarm, home, arrive: false }.bits()
        })
    }

    /// Whether an input of an axis differs.
    #[inline]
    pub fn differ(&self, before: &PinLevels) -> bool {
        let ports = self.ports.iter().zip(&before.ports).zip(OF_AXES);
        ports.fold(0, |differ, ((now, before), of_axes)| differ | (now ^ before) & of_axes) != 0
    }

    /// General inputs, bit 0 the first.
    pub fn general(&self) -> GeneralInputs {
        BOARD.general_in.iter().zip(0..).fold(0, |bits, (pin, bit)| bits | GeneralInputs::from(self.at(*pin)) << bit)
    }

    /// The interlock's inputs: those of TIM1, TIM15 and TIM8.
    pub fn breaks(&self) -> [bool; 3] {
        BOARD.breaks.map(|input| self.at(input.pin.0))
    }

    /// The same, a bit each.
    pub fn interlock(&self) -> u8 {
        self.breaks().into_iter().zip(0..).fold(0, |bits, (level, bit)| bits | u8::from(level) << bit)
    }
}
