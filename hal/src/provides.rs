//! What a board provides: the one list. A board whose module lacks an item, or has it with another
//! type, does not compile.
//!
//! In: the module of the board that a feature has chosen. Out: nothing. Owns nothing. What each
//! item means stands where the boards define it; docs/guides/add-a-board.md says in which order to
//! add them.
use crate::board::{self, Board, Machine, ResetCause, idle, timer, uart, watchdog};
use core::ops::RangeInclusive;
use servo::laser::Clock;
use servo::port::{Port, WiredInputs};
use servo::units::{AxisMask, StepLimit};

/// What it is, and how much of everything it has.
const _: () = {
    let _: &str = board::NAME;
    let _: usize = board::AXES;
    let _: u32 = board::TICK_NS;
    let _: RangeInclusive<u32> = board::TICK_US;
    let _: Clock = board::LASER_CLOCK;
    let _: StepLimit = board::STEP_LIMIT;
    let _: u8 = board::ANALOG_INPUTS;
    let _: u8 = board::ANALOG_OUTPUTS;
    let _: u16 = board::PLANNED_INPUTS;
    let _: u8 = board::GENERAL_INPUTS;
    let _: u8 = board::GENERAL_OUTPUTS;
    let _: AxisMask = board::INDEXES;
    let _: WiredInputs = board::WIRED;
    let _: Option<&str> = board::NMI;
    let _: fn() -> Option<&'static str> = board::contradiction;
};

/// Start-up, and the end of a run.
const _: () = {
    let _: fn() -> ResetCause = board::cause;
    let _ = [ResetCause::Power, ResetCause::Watchdog, ResetCause::Asked];
    let _: fn() -> Option<Board> = board::take;
    let _: unsafe fn(*mut (), extern "C" fn(*mut ())) = board::start_up;
    let _: unsafe fn() = board::listen;
    let _: fn() = board::safe_state;
    let _: fn() = watchdog::feed;
};

/// What [`board::take`] hands out.
#[allow(dead_code)]
fn parts(board: Board) -> (timer::TickTimer, (uart::Tx, uart::Rx), Option<uart::Tx>, Machine, Option<&'static str>) {
    let Board { timer, link, trace, machine, contradiction } = board;
    (timer, link, trace, machine, contradiction)
}

/// The tick: its timer, its machine, and the wake-up of the thread.
const _: () = {
    let _: fn(&mut timer::TickTimer, u32) = timer::TickTimer::run_at;
    let _: fn(&mut timer::TickTimer) = timer::TickTimer::begin;
    let _: fn(&timer::TickTimer) -> (bool, Option<u32>) = timer::TickTimer::taken;
    let _: fn(&mut Machine, u32) = Machine::advance;
    let _: fn(&mut Machine) -> bool = Machine::emit;
    const fn is_port<T: Port>() {}
    is_port::<Machine>();
    let _: fn() = board::wake_thread;
};

/// The link, and the thread's wait.
const _: () = {
    let _: fn(&mut uart::Tx, u8) -> bool = uart::Tx::send;
    let _: fn(&mut uart::Rx) -> Option<u8> = uart::Rx::receive;
    let _: fn() = board::hold_link;
    let _: fn() = board::resume_link;
    let _: fn() -> idle::Idle = idle::Idle::new;
    let _: fn(&mut idle::Idle) = idle::Idle::wake;
    let _: fn(&mut idle::Idle) = idle::Idle::wait;
};
