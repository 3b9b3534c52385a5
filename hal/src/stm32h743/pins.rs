//! Pins: which pin is what (docs/board-h743.md), and their levels.
//!
//! In: levels of outputs. Out: levels of inputs. Owns the GPIO ports. Until [`open`] every pin is
//! analog, as the reset has left it; afterwards every pin that is not named here still is. [`rest`]
//! makes the outputs analog again. Fails never.
use super::settings::EXTERNAL_DAC;
use servo::port::{GeneralInputs, GeneralOutputs};
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::vals::{Moder, Ospeedr, Pupdr};
use stm32_metapac::{GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF, GPIOG, RCC};

/// Axes that the board has pins for.
pub const AXES: usize = 8;

/// A pin.
type Pin = (Gpio, usize);

const LIMIT_POSITIVE: [Pin; AXES] =
    [(GPIOE, 0), (GPIOE, 2), (GPIOE, 6), (GPIOE, 7), (GPIOE, 10), (GPIOE, 11), (GPIOE, 12), (GPIOE, 13)];
const LIMIT_NEGATIVE: [Pin; AXES] =
    [(GPIOB, 2), (GPIOB, 3), (GPIOB, 6), (GPIOB, 7), (GPIOB, 8), (GPIOB, 9), (GPIOB, 11), (GPIOB, 12)];
const HOME: [Pin; AXES] =
    [(GPIOD, 0), (GPIOD, 1), (GPIOD, 2), (GPIOD, 3), (GPIOD, 4), (GPIOD, 5), (GPIOD, 6), (GPIOD, 7)];
const ALARM: [Pin; AXES] =
    [(GPIOA, 0), (GPIOA, 3), (GPIOA, 6), (GPIOA, 15), (GPIOC, 0), (GPIOC, 6), (GPIOD, 11), (GPIOD, 15)];
const GENERAL_IN: [Pin; 3] = [(GPIOC, 13), (GPIOE, 14), (GPIOC, 9)];
/// Break inputs of TIM1, TIM15 and TIM8, wired together.
const INTERLOCK: [Pin; 3] = [(GPIOE, 15), (GPIOE, 3), (GPIOG, 2)];
const BREAK_FUNCTION: [u8; 3] = [1, 4, 3];
/// Both lines of laser 0's and laser 1's energy (TIM1, TIM15) and switch (TIM8), and their
/// alternate function.
const LASER: [(Pin, u8); 8] = [
    ((GPIOE, 9), 1),
    ((GPIOE, 8), 1),
    ((GPIOE, 5), 4),
    ((GPIOE, 4), 4),
    ((GPIOC, 7), 3),
    ((GPIOB, 0), 3),
    ((GPIOC, 8), 3),
    ((GPIOB, 15), 3),
];

const ENABLE: [Pin; AXES] =
    [(GPIOG, 0), (GPIOG, 1), (GPIOG, 3), (GPIOG, 4), (GPIOG, 5), (GPIOG, 6), (GPIOG, 8), (GPIOG, 9)];
/// LD2, LD3, and four more.
const GENERAL_OUT: [Pin; 6] = [(GPIOE, 1), (GPIOB, 14), (GPIOG, 10), (GPIOG, 12), (GPIOG, 14), (GPIOG, 15)];

/// General inputs.
pub const GENERAL_INPUTS: usize = GENERAL_IN.len();
/// General outputs.
pub const GENERAL_OUTPUTS: usize = GENERAL_OUT.len();

/// Directions on pins 0 to 7, steps on 8 to 15: the layout of the words of
/// [`servo::output::step_words`].
const STEPS: Gpio = GPIOF;

const LINK: [Pin; 2] = [(GPIOD, 8), (GPIOD, 9)];
/// USART3 on these.
const LINK_FUNCTION: u8 = 7;

/// TIM3 and TIM4 on these.
const ENCODERS: [Pin; 4] = [(GPIOB, 4), (GPIOB, 5), (GPIOD, 12), (GPIOD, 13)];
/// Their indexes, TIM3_CH4 and TIM4_CH3.
const INDEXES: [Pin; 2] = [(GPIOB, 1), (GPIOD, 14)];
const ENCODER_FUNCTION: u8 = 2;

/// SPI3 on these, for an external DAC, and its select line.
const DAC: [Pin; 2] = [(GPIOC, 10), (GPIOC, 12)];
const DAC_FUNCTION: u8 = 6;
const DAC_SELECT: Pin = (GPIOC, 11);

/// The switch of the USB connector's 5 V (UM2407): a device does not supply the bus.
const USB_POWER: Pin = (GPIOD, 10);

/// D− and D+, and the host's 5 V.
const USB: [Pin; 2] = [(GPIOA, 11), (GPIOA, 12)];
const USB_FUNCTION: u8 = 10;
const USB_VBUS: Pin = (GPIOA, 9);

/// Ports that have outputs of [`set`].
const OUT: [Gpio; 3] = [GPIOB, GPIOE, GPIOG];

/// Configures the inputs, drives the outputs low and assigns the link's pins to USART3.
///
/// # Safety
/// Once, before anything else writes a port.
pub unsafe fn open() {
    RCC.ahb4enr().modify(|w| {
        w.set_gpioaen(true);
        w.set_gpioben(true);
        w.set_gpiocen(true);
        w.set_gpioden(true);
        w.set_gpioeen(true);
        w.set_gpiofen(true);
        w.set_gpiogen(true);
    });
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.ahb4enr().read();
    let low = LIMIT_POSITIVE.iter().chain(&LIMIT_NEGATIVE).chain(&HOME).chain(&ALARM).chain(&GENERAL_IN);
    for pin in low {
        input(*pin, Pupdr::PULL_DOWN);
    }
    for pin in INTERLOCK {
        // A broken wire reads as an active interlock.
        input(pin, Pupdr::PULL_UP);
    }
    set(0, 0);
    for pin in 0..2 * AXES {
        // Low, as the reset has left the port.
        STEPS.ospeedr().modify(|w| w.set_ospeedr(pin, Ospeedr::MEDIUM_SPEED));
        STEPS.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
    }
    let (port, pin) = USB_POWER;
    port.bsrr().write(|w| w.set_br(pin, true));
    for (port, pin) in ENABLE.into_iter().chain(GENERAL_OUT).chain([USB_POWER]) {
        port.ospeedr().modify(|w| w.set_ospeedr(pin, Ospeedr::LOW_SPEED));
        port.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
    }
    for (port, pin) in LINK {
        port.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::PULL_UP));
        assign((port, pin), LINK_FUNCTION, Ospeedr::HIGH_SPEED);
    }
    for (port, pin) in ENCODERS {
        // A line that is not connected does not count.
        port.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::PULL_UP));
        assign((port, pin), ENCODER_FUNCTION, Ospeedr::LOW_SPEED);
    }
    for (port, pin) in INDEXES {
        port.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::PULL_DOWN));
        assign((port, pin), ENCODER_FUNCTION, Ospeedr::LOW_SPEED);
    }
    if EXTERNAL_DAC {
        let (port, pin) = DAC_SELECT;
        // Not selected, then driven.
        port.bsrr().write(|w| w.set_bs(pin, true));
        port.moder().modify(|w| w.set_moder(pin, Moder::OUTPUT));
        DAC.into_iter().for_each(|pin| assign(pin, DAC_FUNCTION, Ospeedr::HIGH_SPEED));
    }
}

/// Lights LD3, the red one, alone: the image refuses this chip.
pub fn show_refusal() {
    RCC.ahb4enr().modify(|w| w.set_gpioben(true));
    RCC.ahb4enr().read();
    GPIOB.bsrr().write(|w| w.set_bs(14, true));
    GPIOB.moder().modify(|w| w.set_moder(14, Moder::OUTPUT));
}

/// Assigns a pin to a peripheral.
fn assign((port, pin): Pin, function: u8, speed: Ospeedr) {
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
    let inputs = INTERLOCK.into_iter().zip(BREAK_FUNCTION);
    for ((port, pin), function) in inputs.chain(LASER) {
        port.afr(pin / 8).modify(|w| w.set_afr(pin % 8, function));
        port.ospeedr().modify(|w| w.set_ospeedr(pin, Ospeedr::HIGH_SPEED));
        port.moder().modify(|w| w.set_moder(pin, Moder::ALTERNATE));
    }
}

/// Assigns USB's lines to the core.
///
/// # Safety
/// Once, after [`open`].
pub unsafe fn open_usb() {
    input(USB_VBUS, Pupdr::FLOATING);
    USB.into_iter().for_each(|pin| assign(pin, USB_FUNCTION, Ospeedr::VERY_HIGH_SPEED));
}

fn input((port, pin): Pin, pull: Pupdr) {
    port.pupdr().modify(|w| w.set_pupdr(pin, pull));
    port.moder().modify(|w| w.set_moder(pin, Moder::INPUT));
}

/// Every output high-impedance again.
pub fn safe_state() {
    STEPS.moder().write(|w| (0..2 * AXES).for_each(|pin| w.set_moder(pin, Moder::ANALOG)));
    for port in OUT {
        for (owner, pin) in ENABLE.into_iter().chain(GENERAL_OUT) {
            if owner == port {
                port.moder().modify(|w| w.set_moder(pin, Moder::ANALOG));
            }
        }
    }
}

/// Servo-enable lines, a bit an axis, and general outputs; all of a port change at once.
pub fn set(enable: u64, general: GeneralOutputs) {
    for port in OUT {
        let mut word = 0;
        let outputs = ENABLE.iter().zip(0..).map(|(pin, bit)| (pin, enable >> bit & 1 == 1));
        let general = GENERAL_OUT.iter().zip(0..).map(|(pin, bit)| (pin, general >> bit & 1 == 1));
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
    ports: [u16; 7],
}

impl PinLevels {
    /// Nothing is high.
    pub const LOW: PinLevels = PinLevels { ports: [0; 7] };

    /// As they are now.
    pub fn read() -> PinLevels {
        PinLevels { ports: [GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF, GPIOG].map(|port| port.idr().read().0 as u16) }
    }

    fn at(&self, (port, pin): Pin) -> bool {
        const PORTS: [Gpio; 7] = [GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF, GPIOG];
        PORTS.iter().zip(self.ports).any(|(owner, levels)| *owner == port && levels >> pin & 1 == 1)
    }

    fn of<const N: usize>(&self, pins: &[Pin; N], index: usize) -> bool {
        pins.get(index).is_some_and(|pin| self.at(*pin))
    }

    /// Positive limit of an axis, from 0.
    pub fn limit_positive(&self, axis: usize) -> bool {
        self.of(&LIMIT_POSITIVE, axis)
    }

    /// Negative limit of an axis, from 0.
    pub fn limit_negative(&self, axis: usize) -> bool {
        self.of(&LIMIT_NEGATIVE, axis)
    }

    /// Home switch of an axis, from 0.
    pub fn home(&self, axis: usize) -> bool {
        self.of(&HOME, axis)
    }

    /// Drive alarm of an axis, from 0.
    pub fn alarm(&self, axis: usize) -> bool {
        self.of(&ALARM, axis)
    }

    /// General inputs, bit 0 the first.
    pub fn general(&self) -> GeneralInputs {
        GENERAL_IN.iter().zip(0..).fold(0, |bits, (pin, bit)| bits | GeneralInputs::from(self.at(*pin)) << bit)
    }

    /// The interlock's inputs: those of TIM1, TIM15 and TIM8.
    pub fn breaks(&self) -> [bool; 3] {
        INTERLOCK.map(|pin| self.at(pin))
    }

    /// Whether any of the interlock's inputs is high.
    pub fn interlock(&self) -> bool {
        INTERLOCK.iter().any(|pin| self.at(*pin))
    }
}
