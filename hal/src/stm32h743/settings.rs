//! What of the board is set here, before it is built: times that the drives ask for, and which DAC there is.

/// Width of a step pulse, and the least time between two; in whole slots of [`super::steps::SLOT_NS`], so 500 ns are the shortest.
/// At 500 ns an axis makes 1 MHz; twice the width is the shortest period of steps. Data that
/// is faster is refused ([`super::STEP_LIMIT`]).
pub const STEP_WIDTH_NS: u32 = 500;

/// Time from a change of direction to the rising edge of the step behind it.
pub const DIRECTION_SET_UP_NS: u32 = 2_000;

/// Axes from the first on that have an encoder. The others, and one whose entry is false, take the pulse at which their step output stands.
pub const ENCODERS: [bool; super::encoders::MOST] = [true; super::encoders::MOST];

/// The analog outputs are those of a DAC8563 on SPI3 instead of the chip's own: the feature `external_dac` of hal and firmware.
pub const EXTERNAL_DAC: bool = cfg!(feature = "external_dac");
