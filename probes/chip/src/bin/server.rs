#![no_std]
#![no_main]
//! Must link, as `no-panic` must: nothing that the thread does between the link and the tick meets
//! a panic. The server with its command handler, its programs, look-aheads and tables, on bytes and
//! views of which the optimiser knows nothing.
use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m as _;
use dispatcher::{BoardConstants, Server, ThreadHalves};
use hal as _;
use probes::{AXES, PATHS, QUEUES, STORES, TABLE_STORES};
use servo::units::{AxisMask, Ns, StepLimit};
use static_cell::ConstStaticCell;

unsafe extern "C" {
    fn something_reached_a_panic() -> !;
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    // SAFETY: there is no such function; the linker says so if this is reachable.
    unsafe { something_reached_a_panic() }
}

static SERVER: ConstStaticCell<Option<Server<'static, AXES>>> = ConstStaticCell::new(None);

/// All that the link task asks of it.
#[inline(never)]
fn serve(server: &mut Server<'static, AXES>, now: Ns, bytes: &[u8], out: &mut [u8]) {
    server.feed(now, bytes);
    server.poll(now);
    black_box((server.take_tx(out), server.take_trace(out), server.next_deadline()));
    black_box((server.view().tick, server.is_open(), server.traces()));
}

fn start() -> Option<&'static mut Server<'static, AXES>> {
    let (_, _, thread) = probes::bench()?;
    let board = BoardConstants {
        name: "probe",
        profile: 0,
        tick_us: 50..=1000,
        analog_outputs: 8,
        analog_inputs: 8,
        planned_inputs: 0,
        general_inputs: 16,
        general_outputs: 16,
        indexes: AxisMask(0),
        step_limit: StepLimit::FULL_SCALE,
        wired: &servo::port::WiredInputs::ALL,
        fault: None,
        contradiction: || None,
        tick_time: None,
        stack: None,
    };
    let channels = ThreadHalves {
        immediate: thread.immediate,
        program: thread.program,
        view: thread.view,
        events: thread.events,
        samples: thread.samples,
        stores: &STORES,
        paths: PATHS,
        queues: QUEUES.try_take()?,
        tables: TABLE_STORES,
    };
    Some(SERVER.try_take()?.insert(Server::new(board, channels)))
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let (bytes, mut out) = ([0; 64], [0; 512]);
    if let Some(server) = start() {
        loop {
            serve(black_box(server), black_box(Ns(0)), black_box(&bytes), black_box(&mut out));
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}
