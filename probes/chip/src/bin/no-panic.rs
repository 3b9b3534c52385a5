#![no_std]
#![no_main]
//! Must link. The panic handler calls a function that does not exist, so that this program links only
//! if the optimiser has proved that nothing in it can panic: the tick with all it calls, and the
//! emulated board's machine. Its twin `panics` shows that the probe can fail.
use core::hint::black_box;
use core::panic::PanicInfo;
use hal::mps2_an500::machine::Machine;
use probes::{AXES, PERIOD_NS};
use servo::tick::{Lanes, Tick};

unsafe extern "C" {
    fn something_reached_a_panic() -> !;
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    // SAFETY: there is no such function; the linker says so if this is reachable.
    unsafe { something_reached_a_panic() }
}

/// What the timer's interrupt does, on arguments of which the optimiser knows nothing.
#[inline(never)]
fn tick(tick: &mut Tick<AXES>, machine: &mut Machine<AXES>, lanes: &mut Lanes<'static, AXES>) {
    machine.advance(tick.period().0 as u32);
    tick.run(machine, lanes);
    tick.overrun();
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let (Some((mut state, mut lanes, thread)), Some(board)) = (probes::bench(), hal::mps2_an500::take()) {
        let mut machine = Machine::new(PERIOD_NS, board.switchboard);
        black_box(&thread);
        loop {
            tick(black_box(&mut state), black_box(&mut machine), black_box(&mut lanes));
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}
