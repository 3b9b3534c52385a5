#![no_std]
#![no_main]
//! The bring-up image: the reference board measures itself and reports the figures over its link.
//!
//! In: the line `go` from the host, the jumpers of docs/bring-up.md. Out: lines of figures
//! ([`report`]). Owns the board. It judges nothing: limits and advice are the host's
//! (`host/beamtick/src/bring_up/`). It resets the chip after each run, so each begins like a
//! power-on. Fails: a chip that the board's start-up refuses lights LD3 and reports nothing.
//!
//! It has no servo tick, no client and no light of its own will. Outputs move while it measures:
//! no drive and no laser may be connected.
mod chip;
mod core_facts;
mod pause;
mod report;
mod stack;

use cortex_m::peripheral::SCB;
use hal::board::{self, uart::Rx};
use report::Report;

/// Version of the lines.
const FORMAT: i64 = 1;

/// Cycles of a byte of the link.
pub const A_BYTE: u32 = 1600;

/// Waits for a line that ends in `go`; anything else is no order.
fn await_order(rx: &mut Rx) {
    let mut last = [0; 3];
    loop {
        if let Some(byte) = rx.receive() {
            last = [last[1], last[2], byte];
            if last == *b"go\n" {
                return;
            }
        } else {
            pause::cycles(A_BYTE);
        }
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let at_reset = chip::AtReset::read();
    // The only panic of the start: a second call of this function, which the runtime never makes.
    let board = board::take().expect("the board is taken once");
    let (tx, mut rx) = board.link;
    core_facts::count_cycles();
    await_order(&mut rx);
    let mut report = Report::to(tx);
    report.line("format", &[FORMAT]);
    at_reset.tell(&mut report);
    chip::tell(&mut report);
    core_facts::tell(&mut report);
    stack::tell(&mut report);
    report.end();
    SCB::sys_reset()
}
