//! The idle loop of the thread.
//!
//! QEMU hands a UART one byte at a time and needs some 70 µs of the host's time for each. Asleep,
//! the emulated clock keeps pace with the host's. A megabaud of commands would then arrive at 14
//! kB/s of
//! *emulated* time, and an 8-axis stream would run dry. So while bytes arrive, this loop polls the
//! UART instead of sleeping. A poll takes the host long and the emulated clock 10 ns, which holds
//! the clock back while bytes are on their way. Measured: 0.07 ms of host time and 2.4 µs of
//! emulated time a byte (`docs/numbers.md`). It also polls while the trace waits for the host to
//! take a byte: asleep, rows would be made faster than the host takes them. On silicon the loop
//! would poll once and sleep.
//!
//! In: arrived bytes, levels of the UARTs' flags. Out: the thread's wait. Owns two counts. Fails
//! never.
use super::uart::{Port, has_byte, is_full};

/// Polls of a silent link before sleep: some 20 µs of emulated time, about 1 ms of the host's.
const LINK_POLLS: u32 = 2000;

/// Polls of a trace that the host does not take, before sleep: some seconds of the host's time.
const TRACE_POLLS: u32 = 10_000_000;

/// Waits for something to happen. Any interrupt ends the wait; at the latest the next tick does.
#[derive(Debug, Default)]
pub struct Idle {
    link_polls: u32,
    /// Polls of a trace that waits.
    trace_polls: u32,
}

impl Idle {
    /// Nothing has happened yet.
    pub const fn new() -> Self {
        Idle { link_polls: LINK_POLLS, trace_polls: 0 }
    }

    /// A byte has arrived: more will.
    pub fn wake(&mut self) {
        self.link_polls = 0;
    }

    /// Waits a moment. An interrupt that comes between the caller's last check and the sleep is
    /// served; the caller finds what it brought after the next tick at the latest.
    pub fn wait(&mut self) {
        if self.link_polls < LINK_POLLS {
            self.link_polls += 1;
            core::hint::black_box(has_byte(Port::Link));
        } else if !is_full(Port::Trace) {
            self.trace_polls = 0;
            cortex_m::asm::wfi();
        } else if self.trace_polls < TRACE_POLLS {
            self.trace_polls += 1;
        } else {
            cortex_m::asm::wfi();
        }
    }
}
