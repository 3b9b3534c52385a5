//! The fault path: outputs to the safe state first, then the reason to memory that survives the
//! reset, then the reset.
//!
//! In: a panic, a fault of the core, an interrupt without a handler, the watchdog. Out: a board in
//! its safe state and, after the restart, the [`FaultReport`], for the log and for `GetFault` over
//! the link. Owns the record in RAM that start-up does not clear. It must not fail itself: it takes
//! no lock, formats into a fixed buffer, and truncates longer text.
use crate::supervision;
use core::cell::UnsafeCell;
use core::fmt::{self, Write};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use dispatcher::{FAULT_TEXT_MAX, FaultKind};
use hal::board::{self, ResetCause};
use hal::guard::SPAN_BYTES;

/// Bytes of text kept: as many as the link carries.
const TEXT_BYTES: usize = FAULT_TEXT_MAX;

/// Marks a record that was written, apart from random contents of RAM.
const WRITTEN: u32 = 0xfa17_b0a4;

/// What happened before the restart.
#[derive(Clone, Copy)]
pub struct FaultReport {
    mark: u32,
    kind: u32,
    length: u32,
    text: [u8; TEXT_BYTES],
}

impl FaultReport {
    /// Of which kind it was.
    pub fn kind(&self) -> FaultKind {
        [FaultKind::Core, FaultKind::Interrupt, FaultKind::Watchdog]
            .into_iter()
            .find(|kind| *kind as u32 == self.kind)
            .unwrap_or(FaultKind::Panic)
    }

    /// The reason, readable.
    pub fn text(&self) -> &str {
        let length = (self.length as usize).min(TEXT_BYTES);
        let bytes = self.text.get(..length).unwrap_or(&[]);
        match core::str::from_utf8(bytes) {
            Ok(text) => text,
            // Truncated inside a character: the whole characters.
            Err(e) => bytes.get(..e.valid_up_to()).and_then(|b| core::str::from_utf8(b).ok()).unwrap_or(""),
        }
    }
}

impl Write for FaultReport {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for &byte in text.as_bytes() {
            let Some(target) = self.text.get_mut(self.length as usize) else { break };
            *target = byte;
            self.length += 1;
        }
        Ok(())
    }
}

/// RAM that the start-up code leaves as it is.
struct Kept(UnsafeCell<MaybeUninit<FaultReport>>);

// SAFETY: read once before interrupts are on, written once before a reset.
unsafe impl Sync for Kept {}

// In memory that is not cached, if the board has a cache: a reset drops the cache.
#[cfg_attr(feature = "mps2_an500", unsafe(link_section = ".uninit.fault"))]
#[cfg_attr(not(feature = "mps2_an500"), unsafe(link_section = ".kept.fault"))]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// The report of what ended the last run. It is cleared, so the second call has none. After a
/// power-on it is not read at all: RAM with ECC may fault on words that were never written.
pub fn last(cause: ResetCause) -> Option<FaultReport> {
    let kept = KEPT.0.get().cast::<FaultReport>();
    let report = match cause {
        ResetCause::Power => None,
        ResetCause::Watchdog => {
            let mut report =
                FaultReport { mark: WRITTEN, kind: FaultKind::Watchdog as u32, length: 0, text: [0; TEXT_BYTES] };
            // Writing into a Report never fails.
            let _ = report.write_str("watchdog: the tick or the thread stood still");
            Some(report)
        }
        // SAFETY: every bit pattern is a Report (integers only), RAM holds one at all times, and
        // this runs before any interrupt; volatile, since the value comes from before the reset.
        ResetCause::Asked => Some(unsafe { kept.read_volatile() }).filter(|report| report.mark == WRITTEN),
    };
    // SAFETY: as above.
    unsafe { kept.write_volatile(FaultReport { mark: 0, kind: 0, length: 0, text: [0; TEXT_BYTES] }) };
    report
}

/// Sets the outputs to their safe state, stores `reason`, resets the board.
fn restart(kind: FaultKind, reason: fmt::Arguments<'_>) -> ! {
    board::safe_state();
    let mut report = FaultReport { mark: WRITTEN, kind: kind as u32, length: 0, text: [0; TEXT_BYTES] };
    // Writing into a Report never fails.
    let _ = report.write_fmt(reason);
    // SAFETY: interrupts of the board are off and nothing returns from here.
    unsafe { KEPT.0.get().cast::<FaultReport>().write_volatile(report) };
    // The memory may buffer a last write of less than an ECC word until the next write, and a reset
    // drops it (RM0433 2.4). So the last write repeats a value that is in memory already. SAFETY:
    // as above.
    unsafe { (&raw mut (*KEPT.0.get().cast::<FaultReport>()).mark).write_volatile(WRITTEN) };
    compiler_fence(Ordering::SeqCst);
    SCB::sys_reset()
}

#[panic_handler]
fn panicked(info: &PanicInfo<'_>) -> ! {
    restart(FaultKind::Panic, format_args!("{info}"))
}

unsafe extern "C" {
    /// The lowest word of the stack (linker script).
    static _stack_end: u32;
    /// The address after its highest word.
    static _stack_start: u32;
}

/// A fault of the core. After a stack overflow it begins on an empty stack: the interrupted code
/// does not continue.
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "mov r0, sp",
        "ldr r1, ={end}",
        // Bytes of the overflow, less one: nothing else lies so close below the stack.
        "subs r1, r1, r0",
        "subs r1, #1",
        "lsrs r1, r1, #{span}",
        "bne 1f",
        "ldr r1, ={start}",
        "mov sp, r1",
        "1: b {body}",
        end = sym _stack_end,
        start = sym _stack_start,
        body = sym faulted,
        span = const SPAN_BYTES.ilog2(),
    )
}

/// `stack` is the address of the core's frame, or the one that it would have.
extern "C" fn faulted(stack: usize) -> ! {
    // SAFETY: reading status registers of the core.
    let (cfsr, hfsr) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).hfsr.read()) };
    let (end, start) = (&raw const _stack_end as usize, &raw const _stack_start as usize);
    let over = end.wrapping_sub(stack);
    if (1..=SPAN_BYTES as usize).contains(&over) {
        restart(
            FaultKind::Core,
            format_args!("stack overflow: {over} bytes over {}, CFSR {cfsr:#010x}, HFSR {hfsr:#010x}", start - end),
        )
    }
    // SAFETY: the core has written the frame there, inside the stack.
    let frame = unsafe { &*(stack as *const ExceptionFrame) };
    restart(
        FaultKind::Core,
        format_args!(
            "hard fault at {:#010x}, called from {:#010x}, CFSR {cfsr:#010x}, HFSR {hfsr:#010x}",
            frame.pc(),
            frame.lr()
        ),
    )
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    restart(FaultKind::Interrupt, format_args!("interrupt {number} without a handler"))
}

/// The board's own reason, if it has one; else the watchdog was not fed. When the emulator's clock
/// has jumped, nothing is stuck at the first NMI: the watchdog's time begins anew.
#[exception]
unsafe fn NonMaskableInt() {
    if let Some(reason) = board::NMI {
        restart(FaultKind::Interrupt, format_args!("{reason}"));
    }
    match supervision::stuck() {
        Some(what) => restart(FaultKind::Watchdog, format_args!("{what}")),
        None => board::watchdog::feed(),
    }
}
