//! Settings of the board at build time: times that the drives need, and which DAC is fitted.

/// Width of a step pulse, and the least time between two; in whole slots of
/// [`super::steps::SLOT_NS`], so 500 ns are the shortest. The shortest period of steps is twice the
/// width: at 500 ns an axis makes 1 MHz. Faster data is refused ([`super::STEP_LIMIT`]).
pub const STEP_WIDTH_NS: u32 = 500;

/// Time from a change of direction to the rising edge of the step after it.
pub const DIRECTION_SET_UP_NS: u32 = 2_000;

/// Axes from the first on that have an encoder. The others, and one whose entry is false, read the
/// pulse that their step output has reached.
pub const ENCODERS: [bool; super::encoders::ENCODERS_MAX] = [true; super::encoders::ENCODERS_MAX];

/// The analog outputs are those of a DAC8563 on SPI3 instead of the chip's own: the feature
/// `external_dac` of hal and firmware.
pub const EXTERNAL_DAC: bool = cfg!(feature = "external_dac");
