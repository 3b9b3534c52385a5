//! What leaves the tick as signals in time: steps, PWM and gate cycles of timers, outputs that
//! change within a tick.
//!
//! In: set-points and actions of lasers at exact instants. Out: words and cycles in the form in
//! which hardware takes them. Owns the remainders that cycles carry on. Fails towards the safe
//! state: what comes too late is left out.
pub(crate) mod cycle_ring;
pub(crate) mod cycles;
pub(crate) mod delay_line;
pub(crate) mod gate_cycles;
pub(crate) mod general_outputs;
pub(crate) mod pwm_cycles;
pub mod step_generator;
pub(crate) mod timed_outputs;

pub use cycle_ring::{CycleRing, RingSlots};
pub use cycles::Scale;
pub use delay_line::{DelayLine, WORDS as DELAY_LINE_WORDS};
pub use gate_cycles::{Cycle, GateCycles, MIN_COUNTS as GATE_MIN_COUNTS};
pub use pwm_cycles::{MIN_COUNTS as PWM_MIN_COUNTS, PwmCycles};
pub use timed_outputs::TIMED_OUTPUTS;
