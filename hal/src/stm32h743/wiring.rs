//! What a board with this chip says of itself: one value, [`Wiring`]. The chip's modules read it,
//! and nothing else of a board.
//!
//! In: nothing. Out: pins, the clock's source, how USB is wired. Owns nothing. Fails: a source from
//! which the clocks cannot be made does not compile.
use servo::output::step_words::AXES;
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
    /// Its name as the link reports it.
    pub name: &'static str,
    /// What feeds the high-speed oscillator (HSE).
    pub source: Source,
    /// Ports of all pins below.
    pub ports: &'static [Gpio],
    /// Directions on pins 0 to 7, steps on 8 to 15: the layout of the words of
    /// [`servo::output::step_words`].
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
    /// Ports of the enables and the general outputs.
    pub out: &'static [Gpio],
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
    /// Its select line.
    pub dac_select: Pin,
    /// USB.
    pub usb: Usb,
    /// Pins that other parts of the board need at a low level.
    pub driven_low: &'static [Pin],
    /// Pins that other parts of the board need at a high level: the chip pulls them up.
    pub pulled_up: &'static [Pin],
    /// A lamp that says alone that the image refuses this chip.
    pub lamp: Option<Pin>,
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
    /// What is reported if the flag differs from a pin that is low, and one that is high.
    pub texts: [&'static str; 2],
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

impl Wiring {
    /// Whether no list is longer than there are axes.
    pub const fn is_sound(&self) -> bool {
        self.enable.len() <= AXES
            && self.limit_positive.len() <= AXES
            && self.limit_negative.len() <= AXES
            && self.home.len() <= AXES
            && self.alarm.len() <= AXES
    }
}
