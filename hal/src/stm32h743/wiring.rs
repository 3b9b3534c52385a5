//! What a board with this chip says of itself: one value, [`Wiring`]. The chip's modules read it,
//! and nothing else of a board.
//!
//! In: nothing. Out: pins, the clock's source, how USB is wired. Owns nothing. Fails: a source from
//! which the clocks cannot be made does not compile.
use servo::output::step_generator::AXES;
use stm32_metapac::gpio::Gpio;

/// PLL1's VCO, of which the core and USB take their clocks.
pub const VCO_MHZ: u32 = 960;

/// A pin: its port and its number there.
pub type Pin = (Gpio, usize);

/// A pin that a peripheral has, and the alternate function by which it has it.
pub type Assigned = (Pin, u8);

/// A list of pins, one an axis from the first one on. An axis beyond its end has no such pin: its
/// input is never active.
pub type OfAxes = &'static [Pin];

/// A board.
#[derive(Clone, Copy)]
pub struct Wiring {
    /// Its names as the link reports them: with the chip's own DAC, and with an external one;
    /// 16 bytes at most.
    pub names: [&'static str; 2],
    /// The chip's package.
    pub package: Package,
    /// What feeds the high-speed oscillator (HSE).
    pub source: Source,
    /// Directions on pins 0 to 7, steps on 8 to 15: the layout of the words of
    /// [`servo::output::step_generator`].
    pub steps: Gpio,
    /// Servo enables, high is on.
    pub enable: OfAxes,
    /// Positive limits.
    pub limit_positive: OfAxes,
    /// Negative limits.
    pub limit_negative: OfAxes,
    /// Home switches.
    pub home: OfAxes,
    /// Alarms of drives.
    pub alarm: OfAxes,
    /// General inputs.
    pub general_in: &'static [Pin],
    /// General outputs.
    pub general_out: &'static [Pin],
    /// Energy + and − of laser 0 (TIM1_CH1, CH1N) and of laser 1 (TIM15_CH1, CH1N), switch + and −
    /// of laser 0 (TIM8_CH2, CH2N) and of laser 1 (TIM8_CH3, CH3N).
    pub lasers: [Assigned; 8],
    /// Break inputs of TIM1, TIM15 and TIM8, wired together: the interlock.
    pub breaks: [Break; 3],
    /// USART3_TX and USART3_RX.
    pub link: [Assigned; 2],
    /// TIM3_CH1, TIM3_CH2, TIM4_CH1, TIM4_CH2.
    pub encoders: [Assigned; 4],
    /// Their indexes: TIM3_CH4, TIM4_CH3.
    pub indexes: [Assigned; 2],
    /// SPI3_SCK and SPI3_MOSI, for an external DAC.
    pub dac: [Assigned; 2],
    /// Its chip select.
    pub dac_select: Pin,
    /// USB.
    pub usb: Usb,
    /// Pins that other parts of the board need at a low level.
    pub driven_low: &'static [Pin],
    /// Pins that other parts of the board need at a high level: the chip pulls them up.
    pub pulled_up: &'static [Pin],
    /// An LED that says alone that the image refuses this chip.
    pub led: Option<Pin>,
}

/// A package of the chip.
#[derive(Debug, Clone, Copy)]
pub struct Package {
    /// SYSCFG_PKGR.PKG.
    pub code: u8,
    /// What is reported where the chip is in another one.
    pub other: &'static str,
}

impl Package {
    /// 100 pins.
    pub const LQFP100: Package =
        Package { code: 0, other: "this image is for a board whose chip has 100 pins; no pin is driven" };
    /// 144 pins.
    pub const LQFP144: Package =
        Package { code: 2, other: "this image is for a board whose chip has 144 pins; no pin is driven" };
}

/// What feeds the high-speed oscillator.
#[derive(Debug, Clone, Copy)]
pub struct Source {
    /// A crystal; otherwise a clock from elsewhere.
    pub is_crystal: bool,
    /// Its frequency.
    pub mhz: u32,
    /// The reason that is reported when it has stopped.
    pub lost: &'static str,
}

/// A break input.
#[derive(Clone, Copy)]
pub struct Break {
    /// Its pin.
    pub pin: Assigned,
    /// What is reported if the flag differs from a pin that is low, from one that is high, and if
    /// the pin differs from those of the other inputs.
    pub texts: [&'static str; 3],
}

/// How USB is wired.
#[derive(Clone, Copy)]
pub struct Usb {
    /// D− and D+.
    pub lines: [Assigned; 2],
    /// The host's 5 V, as far as the board leads them to the chip. Without, the board takes a host
    /// for connected at all times.
    pub vbus: Option<Pin>,
    /// The current that the board takes from the host at most; 0 if it has a supply of its own.
    pub milliamperes: u16,
}

/// The texts of a [`Break`]: of a timer and of the pin of its input.
macro_rules! contradictions {
    ($timer:literal, $pin:literal) => {
        [
            concat!($timer, " breaks although its input ", $pin, " is low"),
            concat!($timer, " does not break although its input ", $pin, " is high"),
            concat!(
                "the interlock's input ",
                $pin,
                " of ",
                $timer,
                " differs from the two others: wire all three together"
            ),
        ]
    };
}
pub(super) use contradictions;

impl Source {
    /// By what PLL1 divides the source: the least divisor that leaves whole MHz, of 16 at most, and
    /// of which [`VCO_MHZ`] is a multiple.
    pub const fn divider(&self) -> u32 {
        let mut divider = 1;
        while divider < 64 {
            let reference = self.mhz / divider;
            if self.mhz.is_multiple_of(divider) && reference <= 16 && VCO_MHZ.is_multiple_of(reference) {
                return divider;
            }
            divider += 1;
        }
        panic!("PLL1 makes no clock of 960 MHz from this source")
    }
}

/// Ports A to K.
pub const PORTS: usize = 11;
/// The first one, and the bytes of its registers (RM0433 2.3.2).
const FIRST_PORT: usize = 0x5802_0000;
const PORT_SPAN_BYTES: usize = 0x400;
/// Pins of every board: PA4 and PA5 of DAC1, PA13 and PA14 of the debug port, PC2_C and PC3_C of
/// ADC3.
const FIXED: [(usize, u16); 2] = [(0, 1 << 4 | 1 << 5 | 1 << 13 | 1 << 14), (2, 1 << 2 | 1 << 3)];

/// A port's number, from A on.
pub const fn number_of(port: Gpio) -> usize {
    union Address {
        port: Gpio,
        address: usize,
    }
    // SAFETY: a port is its address, as a pointer that was made of a number.
    (unsafe { Address { port }.address } - FIRST_PORT) / PORT_SPAN_BYTES
}

/// The port of a number.
const fn port_of(number: usize) -> Gpio {
    // SAFETY: its address.
    unsafe { Gpio::from_ptr((FIRST_PORT + number * PORT_SPAN_BYTES) as *mut ()) }
}

/// Which pins are used, a bit each; and whether one is used twice.
#[derive(Clone, Copy)]
pub struct Uses {
    pins: [u16; PORTS],
    twice: bool,
}

impl Uses {
    const NONE: Uses = Uses { pins: [0; PORTS], twice: false };

    const fn and(mut self, (port, pin): Pin) -> Uses {
        let (number, bit) = (number_of(port), 1 << pin);
        self.twice |= self.pins[number] & bit != 0;
        self.pins[number] |= bit;
        self
    }

    const fn and_all(mut self, pins: &[Pin]) -> Uses {
        let mut n = 0;
        while n < pins.len() {
            self = self.and(pins[n]);
            n += 1;
        }
        self
    }

    const fn and_assigned(mut self, pins: &[Assigned]) -> Uses {
        let mut n = 0;
        while n < pins.len() {
            self = self.and(pins[n].0);
            n += 1;
        }
        self
    }

    /// How many ports have one.
    pub const fn count(&self) -> usize {
        let (mut count, mut number) = (0, 0);
        while number < PORTS {
            count += (self.pins[number] != 0) as usize;
            number += 1;
        }
        count
    }

    /// The pins of these ports, a bit each.
    pub const fn of<const N: usize>(&self, ports: &[Gpio; N]) -> [u16; N] {
        let (mut pins, mut n) = ([0; N], 0);
        while n < N {
            pins[n] = self.pins[number_of(ports[n])];
            n += 1;
        }
        pins
    }

    /// These ports, in order; `N` is [`Uses::count`].
    pub const fn ports<const N: usize>(&self) -> [Gpio; N] {
        let mut ports = [port_of(0); N];
        let (mut n, mut number) = (0, 0);
        while number < PORTS {
            if self.pins[number] != 0 {
                ports[n] = port_of(number);
                n += 1;
            }
            number += 1;
        }
        ports
    }
}

impl Wiring {
    /// Pins of enables and general outputs.
    pub const fn driven_in_ticks(&self) -> Uses {
        Uses::NONE.and_all(self.enable).and_all(self.general_out)
    }

    /// Pins of limits, home switches and alarms.
    pub const fn axis_inputs(&self) -> Uses {
        Uses::NONE.and_all(self.limit_positive).and_all(self.limit_negative).and_all(self.home).and_all(self.alarm)
    }

    /// All pins. An LED may be one of the outputs.
    pub const fn uses(&self) -> Uses {
        let mut uses = self
            .driven_in_ticks()
            .and_all(self.limit_positive)
            .and_all(self.limit_negative)
            .and_all(self.home)
            .and_all(self.alarm)
            .and_all(self.general_in)
            .and_assigned(&self.lasers)
            .and_assigned(&self.link)
            .and_assigned(&self.encoders)
            .and_assigned(&self.indexes)
            .and_assigned(&self.dac)
            .and(self.dac_select)
            .and_assigned(&self.usb.lines)
            .and_all(self.driven_low)
            .and_all(self.pulled_up);
        let mut pin = 0;
        while pin < 2 * AXES {
            uses = uses.and((self.steps, pin));
            pin += 1;
        }
        let mut input = 0;
        while input < self.breaks.len() {
            uses = uses.and(self.breaks[input].pin.0);
            input += 1;
        }
        if let Some(vbus) = self.usb.vbus {
            uses = uses.and(vbus);
        }
        let mut n = 0;
        while n < FIXED.len() {
            let (port, pins) = FIXED[n];
            uses.twice |= uses.pins[port] & pins != 0;
            n += 1;
        }
        uses
    }

    /// Whether a pin has two uses, or one that every board has for something else.
    pub const fn uses_a_pin_twice(&self) -> bool {
        self.uses().twice
    }

    /// Whether no list is longer than there are axes.
    pub const fn is_sound(&self) -> bool {
        self.enable.len() <= AXES
            && self.limit_positive.len() <= AXES
            && self.limit_negative.len() <= AXES
            && self.home.len() <= AXES
            && self.alarm.len() <= AXES
    }
}
