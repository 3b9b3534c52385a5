#![no_std]
#![no_main]
//! Must link. The panic handler calls a function that does not exist. So this program links only if
//! the optimiser has proved that nothing in it can panic: the tick with all it calls, the emulated
//! board's machine, and the path of a coordinate system. Its twin `panics` shows that the probe can
//! fail.
use core::hint::black_box;
use core::panic::PanicInfo;
use hal::mps2_an500::machine::Machine;
use probes::AXES;
use servo::path::{Effects, EntryEffect, EntryStore, FifoEnds, Path, PathStop};
use servo::segment::piece::Scaled;
use servo::tick::{Tick, TickHalves};
use servo::units::{Axis, FineNs, Ns, Pos};

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
fn tick(
    tick: &mut Tick<AXES>,
    machine: &mut Machine<{ hal::mps2_an500::AXES }>,
    lanes: &mut TickHalves<'static, AXES>,
) {
    machine.advance(tick.period().0 as u32);
    tick.run(machine, lanes);
    tick.overrun();
}

/// Entries of which the optimiser knows nothing.
static ENTRIES: [EntryStore; 2] = [EntryStore::new(), EntryStore::new()];

/// Takes what a path does.
struct Sink;

impl Effects for Sink {
    fn change(&mut self, at: FineNs, _: &EntryEffect) -> FineNs {
        at
    }
    fn standstill(&mut self, _: FineNs, _: PathStop) {}
    fn gear(&mut self, _: Axis, _: Pos, _: Scaled) {}
    fn geared(&mut self, _: u128, _: Axis, _: i32) {}
}

/// All that a path is asked for.
#[inline(never)]
fn path(path: &mut Path, next: Ns, feed: FifoEnds, fifo: u8) {
    let refused = path.refuses_start(fifo, feed);
    path.start(next, fifo, feed, &ENTRIES);
    path.stop(next, refused, feed, &ENTRIES, &mut Sink);
    path.replan(next, feed, &ENTRIES);
    black_box(path.step(next, next, feed, &ENTRIES, &mut Sink));
    black_box((path.released(fifo), path.done(fifo)));
    path.clear(fifo);
    path.position([Pos(0); 4]);
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let (Some((mut state, mut lanes, thread)), Some(board)) = (probes::bench(), hal::mps2_an500::take()) {
        let mut machine = board.machine;
        black_box(&thread);
        let mut crd = Path::IDLE;
        loop {
            path(black_box(&mut crd), black_box(Ns(0)), black_box(FifoEnds::default()), black_box(0));
            tick(black_box(&mut state), black_box(&mut machine), black_box(&mut lanes));
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}
