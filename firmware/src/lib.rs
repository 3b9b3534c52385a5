#![no_std]
//! The image of a board: it composes the crates and adds no function of its own. A feature chooses
//! the board. The programs in `bin/` are this library with a name and a destination of the log.
//!
//! Start-up reads the report of the last run and splits the queues into their halves. The servo
//! tick and the link's interrupt get theirs, the tasks get the others. Then it enables the
//! interrupts.
mod fault;
mod interrupts;
mod load;
mod statics;
mod supervision;
mod tasks;
#[cfg(feature = "stm32h743")]
mod usb;
mod vectors;
mod wake_signal;
mod wires;

use core::sync::atomic::Ordering;
use dispatcher::{FaultKind, SecondaryTransport, Server, ThreadHalves};
use embassy_executor::raw;
use fault::FaultReport;
use hal::board::{self, AXES, idle::Idle};
use interrupts::{LinkReceiver, Servo};
use servo::tables::TableStores;
use servo::tick::TickHalves;
use statics::{
    BYTES, EDGE_COUNTS, EVENT_QUEUE, EXECUTOR, HEADERS, IMMEDIATE_LANE, LASER_TABLES, PENDED, POINTS, PROGRAM_LANE,
    QUEUES, RECEIVER, RECEIVING, REPORT, SERVER, SERVO, STORES, TICK, TRACE, VIEW, paths,
};
use tasks::LinkParts;
use wires::{Outflow, Wire, Wires};

/// Start-up, then the thread, which does not return.
pub fn main() -> ! {
    let last = fault::last(board::cause()).map(|report| &*REPORT.init(report));
    // The only panic of the start: a second call of this function, which the runtime never makes.
    let parts = start_up(last).expect("the board and every static are taken once");
    let executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    let spawner = executor.spawner();
    spawner.spawn(tasks::announce(last).expect("one announcement"));
    #[cfg(feature = "stm32h743")]
    let (parts, device) = parts;
    #[cfg(feature = "stm32h743")]
    if let Some(device) = device {
        spawner.spawn(usb::answer(device).expect("one USB task"));
    }
    spawner.spawn(tasks::serve(parts).expect("one link task"));
    // SAFETY: `start_up` has given the handlers what they use.
    unsafe { board::listen() };
    let mut idle = Idle::new();
    loop {
        if RECEIVING.swap(false, Ordering::Relaxed) {
            idle.wake();
        }
        if PENDED.swap(false, Ordering::Acquire) {
            // SAFETY: not re-entered: this loop is the only caller.
            unsafe { executor.poll() };
        } else {
            idle.wait();
        }
    }
}

/// What start-up makes: the link's parts, and the device that answers a USB host.
#[cfg(not(feature = "stm32h743"))]
type Parts = LinkParts;
#[cfg(feature = "stm32h743")]
type Parts = (LinkParts, Option<&'static mut usb::Device>);

/// Argument and result of start-up.
struct Start {
    last: Option<&'static FaultReport>,
    parts: Option<Parts>,
}

/// Composes on the board's start-up stack.
fn start_up(last: Option<&'static FaultReport>) -> Option<Parts> {
    extern "C" fn run(start: *mut ()) {
        // SAFETY: the `Start` below, which nothing else refers to.
        let start = unsafe { &mut *start.cast::<Start>() };
        start.parts = compose(start.last);
    }
    let mut start = Start { last, parts: None };
    // SAFETY: nothing has been composed yet that could use anything.
    unsafe { board::start_up((&raw mut start).cast(), run) };
    start.parts
}

/// Called by the executor when a task is woken.
#[unsafe(export_name = "__pender")]
fn pend(_: *mut ()) {
    PENDED.store(true, Ordering::Release);
}

/// Splits the queues and gives every context its half. It makes its values on the stack, which is
/// free again when it returns: so it is never inlined into `main`, which does not return.
#[inline(never)]
fn compose(last: Option<&'static FaultReport>) -> Option<Parts> {
    let board::Board { timer, link: (link, rx), trace, machine, contradiction } = board::take()?;
    let (immediate_in, immediate) = IMMEDIATE_LANE.split_once()?;
    let (program_in, program) = PROGRAM_LANE.split_once()?;
    let (view_in, view) = VIEW.split_once()?;
    let (events_in, events) = EVENT_QUEUE.split_once()?;
    let (samples_in, samples) = TRACE.split_once()?;
    let (bytes_in, bytes) = BYTES.split_once()?;

    let mut servo = Servo {
        timer,
        machine,
        tick: TICK.try_take()?,
        lanes: TickHalves {
            immediate,
            program,
            view: view_in,
            events: events_in,
            samples: samples_in,
            segments: &STORES,
            tables: TableStores { points: &POINTS, headers: &HEADERS, lasers: &LASER_TABLES, edges: &EDGE_COUNTS },
            paths: paths(),
        },
    };
    if last.is_some() {
        // No light before a client has cleared the reason why the last run ended.
        servo.tick.restarted();
    }
    servo.timer.run_at(board::TICK_NS);
    // SAFETY: no interrupt is enabled yet.
    unsafe {
        SERVO.give(servo);
        RECEIVER.give(LinkReceiver { rx, bytes: bytes_in });
    }

    let channels = ThreadHalves {
        immediate: immediate_in,
        program: program_in,
        view,
        events,
        samples,
        stores: &STORES,
        paths: paths(),
        queues: QUEUES.try_take()?,
        tables: TableStores { points: &POINTS, headers: &HEADERS, lasers: &LASER_TABLES, edges: &EDGE_COUNTS },
    };
    let (second, out, answer) = (SecondaryTransport::new(), Outflow::new(), Outflow::new());
    #[cfg(feature = "stm32h743")]
    let (device, usb) = usb::open().unzip();
    let wires = Wires {
        bytes,
        uart: link,
        #[cfg(feature = "stm32h743")]
        usb,
        link: Wire::Uart,
        second,
        out,
        answer,
    };
    let fault = match contradiction {
        Some(text) => Some(dispatcher::Fault { kind: FaultKind::Board, text }),
        None => last.map(|report| dispatcher::Fault { kind: report.kind(), text: report.text() }),
    };
    let parts = LinkParts { server: server(fault, channels), wires, trace };
    #[cfg(feature = "stm32h743")]
    let parts = (parts, device);
    Some(parts)
}

/// The thread's side. A function of its own for the same reason as `compose`.
#[inline(never)]
fn server(
    fault: Option<dispatcher::Fault>,
    channels: ThreadHalves<'static, AXES>,
) -> &'static mut Server<'static, AXES> {
    SERVER.init_with(|| {
        Server::new(
            dispatcher::BoardConstants {
                name: board::NAME,
                profile: dispatcher::largest_that_fits(AXES),
                tick_us: board::TICK_US,
                analog_outputs: board::ANALOG_OUTPUTS,
                analog_inputs: board::ANALOG_INPUTS,
                planned_inputs: board::PLANNED_INPUTS,
                general_inputs: board::GENERAL_INPUTS,
                general_outputs: board::GENERAL_OUTPUTS,
                indexes: board::INDEXES,
                wired: &board::WIRED,
                step_limit: board::STEP_LIMIT,
                fault,
                contradiction: board::contradiction,
                #[cfg(feature = "stm32h743")]
                tick_time: Some(load::tick_time),
                #[cfg(not(feature = "stm32h743"))]
                tick_time: None,
                #[cfg(feature = "stm32h743")]
                stack: Some(load::stack),
                #[cfg(not(feature = "stm32h743"))]
                stack: None,
            },
            channels,
        )
    })
}
