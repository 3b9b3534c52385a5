//! What the thread does when it has nothing to do.
//!
//! QEMU hands a UART one byte at a time and needs some 70 µs of the host's time for each. Asleep, the
//! emulated clock keeps pace with the host's, so a megabaud of commands would arrive at 14 kB/s of
//! *emulated* time and an 8-axis stream would run dry. So while bytes arrive, this loop looks at the
//! UART instead of sleeping: such a look takes the host long and the emulated clock 10 ns, which holds
//! the clock back while bytes are on their way. Measured: 0.07 ms of host time and 2.4 µs of emulated
//! time a byte (`docs/numbers.md`). So it does while the trace waits for the host to take a byte: asleep,
//! rows would be made faster than the host takes them. On silicon the loop is what it says: look, then sleep.
use super::uart::{Place, has_byte, is_full};

/// Looks at a silent link before sleep: some 20 µs of emulated time, about 1 ms of the host's.
const LOOKS: u32 = 2000;

/// Looks at a trace that the host does not take, before sleep: some seconds of the host's time.
const PATIENCE: u32 = 10_000_000;

/// Waits for something to happen. Any interrupt ends the wait; at the latest the next tick does.
#[derive(Debug, Default)]
pub struct Idle {
    looks: u32,
    /// Looks at a trace that waits.
    held: u32,
}

impl Idle {
    /// Nothing has happened yet.
    pub const fn new() -> Self {
        Idle { looks: LOOKS, held: 0 }
    }

    /// A byte has arrived: more will.
    pub fn wake(&mut self) {
        self.looks = 0;
    }

    /// Waits a moment. An interrupt that comes between the caller's last look and the sleep is served,
    /// and its news are seen after the next tick at the latest.
    pub fn wait(&mut self) {
        if self.looks < LOOKS {
            self.looks += 1;
            core::hint::black_box(has_byte(Place::Link));
        } else if !is_full(Place::Trace) {
            self.held = 0;
            cortex_m::asm::wfi();
        } else if self.held < PATIENCE {
            self.held += 1;
        } else {
            cortex_m::asm::wfi();
        }
    }
}
