#![no_std]
#![no_main]
//! The bring-up image: the reference board measures itself and reports the figures over its link.
//!
//! In: the line `go` from the host, or one of [`clock_loss`]; the jumpers of docs/bring-up.md. Out:
//! lines of figures ([`report`]). Owns the board. It judges nothing: limits and advice are the
//! host's (`host/beamtick/src/bring_up/`). At the first order it resets the chip twice
//! ([`before`]), at the second it locks the core up ([`lock_up`]), and it measures at the third.
//! The host sends one each 0.5 s. It resets the chip after each run, so each begins like a
//! power-on. Fails: a chip that the board's start-up refuses lights LD3 and reports nothing. On
//! another package it drives the link's line alone, and reports what registers show.
//!
//! It has no servo tick, no client and no light of its own will. Outputs move while it measures:
//! no drive and no laser may be connected.
mod analog;
mod before;
mod bench;
mod capture;
mod checksum;
mod chip;
mod clock_loss;
mod core_facts;
mod hsi48;
mod light;
mod lock_up;
mod pause;
mod report;
mod shortest;
mod spi3;
mod stack;
mod turns;
mod wires;

use bench::Bench;
use cortex_m::peripheral::SCB;
use hal::board::{self, machine::Machine, package, settings, timer::TickTimer, uart::Rx, uart::Tx};
use report::Report;

/// Version of the lines.
const FORMAT: i64 = 2;

/// Version of the image.
const VERSION: [i64; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// A decimal number.
const fn number(text: &str) -> i64 {
    let mut value = 0;
    let mut digits = text.as_bytes();
    while let [digit, rest @ ..] = digits {
        value = 10 * value + (*digit - b'0') as i64;
        digits = rest;
    }
    value
}

/// Cycles of a byte of the link.
pub const A_BYTE: u32 = 1600;

/// What the host wants.
enum Order {
    /// A run.
    Measure,
    /// Light until the clock stops.
    Light,
    /// What was found when it stopped.
    Report,
}

/// Waits for a line that ends in an order; anything else is none.
fn await_order(rx: &mut Rx) -> Order {
    let mut last = [0; 4];
    loop {
        let Some(byte) = rx.receive() else {
            pause::cycles(A_BYTE);
            continue;
        };
        last = [last[1], last[2], last[3], byte];
        match &last {
            [_, b'g', b'o', b'\n'] => return Order::Measure,
            b"lit\n" => return Order::Light,
            b"why\n" => return Order::Report,
            _ => {}
        }
    }
}

/// The first lines of each report.
fn begin(tx: Tx) -> Report {
    // It takes a while, and lines shall follow each other.
    let build = checksum::of_image();
    let mut report = Report::to(tx);
    report.line("format", &[FORMAT]);
    report.line("version", &VERSION);
    report.line("build", &[build.into()]);
    report.name("board", board::NAME);
    report
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let before = before::Before::read();
    let at_reset = chip::AtReset::read();
    // The only panic of the start: a second call of this function, which the runtime never makes.
    cortex_m::interrupt::disable();
    let board = board::take_to_measure().expect("the board is taken once");
    let (tx, mut rx) = board.link;
    core_facts::count_cycles();
    let order = await_order(&mut rx);
    if !matches!(order, Order::Measure) {
        // A run after it begins like the first one.
        before::forget();
        let mut report = begin(tx);
        match order {
            Order::Light if !package::is_other() => {
                clock_loss::await_loss(&mut report, board.machine, board.timer, &mut rx)
            }
            _ => clock_loss::report_to(&mut report),
        }
        report.end();
        SCB::sys_reset()
    }
    match &before {
        None => before::leave(),
        Some(before) if before.goes_on() => lock_up::until_reset(board.machine, board.timer),
        Some(_) => {}
    }
    let mut report = begin(tx);
    if let Some(before) = before {
        before.report_to(&mut report);
    }
    at_reset.report_to(&mut report);
    chip::report_to(&mut report);
    core_facts::report_to(&mut report);
    report.line("step-width", &[settings::STEP_WIDTH_NS.into()]);
    spi3::report_to(&mut report);
    if !package::is_other() {
        measure(&mut report, board.machine, board.timer, &mut rx);
    }
    stack::report_to(&mut report);
    report.end();
    before::forget();
    SCB::sys_reset()
}

/// What edges and voltages at the ends of jumpers show.
fn measure(report: &mut Report, machine: Machine, timer: TickTimer, rx: &mut Rx) {
    let has_driver = wires::report_to(report);
    for open in [true, false] {
        wires::open_interlock(open);
        if has_driver || open {
            chip::breaks_now(report);
        }
    }
    chip::five_volts(report);
    turns::report_to(report);
    analog::enable_at_once(report);
    let mut bench = Bench::begin(machine, timer);
    light::start(&mut bench, report);
    // Only a bench has the interlock at a general output: elsewhere nothing lights or moves.
    if has_driver {
        light::first_edges(&mut bench, report, ["first-0", "first-1", "first-switch", "first-steps"]);
        light::load(&mut bench, report);
        light::steps(&mut bench, report);
        shortest::measure(&mut bench, report, rx);
        light::starve(&mut bench, report);
        light::broken_burst(&mut bench, report, ["again-0", "again-1", "again-switch", "again-steps"]);
        light::breaks(&mut bench, report);
    }
    analog::report_to(&mut bench, report);
    hsi48::report_to(report);
}
