//! The fault path: outputs at rest first, then the reason to memory that survives the reset, then
//! the reset.
//!
//! In: a panic, a fault of the core, an interrupt that nobody claims, the watchdog. Out: a board at rest and, after
//! the restart, the [`Report`] of what happened, for the log and for `GetFault` over the link. Owns the record in RAM that start-up does not clear.
//! It must not fail itself: it takes no lock, formats into a fixed buffer and cuts what is longer.
use crate::watch;
use core::cell::UnsafeCell;
use core::fmt::{self, Write};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use dispatcher::{FAULT_TEXT_MAX, FaultKind};
use hal::board::{self, Cause};
use hal::guard::SPAN;

/// Bytes of text kept: as many as the link tells.
const TEXT: usize = FAULT_TEXT_MAX;

/// Marks a record that was written, not found by chance.
const WRITTEN: u32 = 0xfa17_b0a4;

/// What happened before the restart.
#[derive(Clone, Copy)]
pub struct Report {
    mark: u32,
    kind: u32,
    length: u32,
    text: [u8; TEXT],
}

impl Report {
    /// Of which kind it was.
    pub fn kind(&self) -> FaultKind {
        [FaultKind::Core, FaultKind::Interrupt, FaultKind::Watchdog]
            .into_iter()
            .find(|kind| *kind as u32 == self.kind)
            .unwrap_or(FaultKind::Panic)
    }

    /// The reason, readable.
    pub fn text(&self) -> &str {
        let length = (self.length as usize).min(TEXT);
        let bytes = self.text.get(..length).unwrap_or(&[]);
        match core::str::from_utf8(bytes) {
            Ok(text) => text,
            // Cut inside a character: what is whole of it.
            Err(e) => bytes.get(..e.valid_up_to()).and_then(|b| core::str::from_utf8(b).ok()).unwrap_or(""),
        }
    }
}

impl Write for Report {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for &byte in text.as_bytes() {
            let Some(place) = self.text.get_mut(self.length as usize) else { break };
            *place = byte;
            self.length += 1;
        }
        Ok(())
    }
}

/// RAM that the start-up code leaves as it is.
struct Kept(UnsafeCell<MaybeUninit<Report>>);

// SAFETY: read once before interrupts are on, written once on the way into a reset.
unsafe impl Sync for Kept {}

// Where nothing caches it, if the board has a cache: a reset would drop it.
#[cfg_attr(feature = "mps2_an500", unsafe(link_section = ".uninit.fault"))]
#[cfg_attr(not(feature = "mps2_an500"), unsafe(link_section = ".kept.fault"))]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// What ended the last run, once: the record is cleared. After a power-on it is not read at all: RAM with a checksum
/// of its own may refuse what was never written.
pub fn last(cause: Cause) -> Option<Report> {
    let kept = KEPT.0.get().cast::<Report>();
    let report = match cause {
        Cause::Power => None,
        Cause::Watchdog => {
            let mut report = Report { mark: WRITTEN, kind: FaultKind::Watchdog as u32, length: 0, text: [0; TEXT] };
            // Writing into a Report never fails.
            let _ = report.write_str("watchdog: the tick or the thread stood still");
            Some(report)
        }
        // SAFETY: every bit pattern is a Report (integers only), RAM holds one at all times, and this
        // runs before any interrupt; volatile, since the value comes from before the reset.
        Cause::Asked => Some(unsafe { kept.read_volatile() }).filter(|report| report.mark == WRITTEN),
    };
    // SAFETY: as above.
    unsafe { kept.write_volatile(Report { mark: 0, kind: 0, length: 0, text: [0; TEXT] }) };
    report
}

/// Rests the outputs, keeps `reason`, starts over.
fn restart(kind: FaultKind, reason: fmt::Arguments<'_>) -> ! {
    board::rest();
    let mut report = Report { mark: WRITTEN, kind: kind as u32, length: 0, text: [0; TEXT] };
    // Writing into a Report never fails.
    let _ = report.write_fmt(reason);
    // SAFETY: interrupts of the board are off and nothing returns from here.
    unsafe { KEPT.0.get().cast::<Report>().write_volatile(report) };
    // What is written last may stay in front of the memory, if it is less than a word of its ECC, until something else is
    // written, and a reset drops it (RM0433 2.4). So that is what stands there already.
    // SAFETY: as above.
    unsafe { (&raw mut (*KEPT.0.get().cast::<Report>()).mark).write_volatile(WRITTEN) };
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
    /// Behind its highest word.
    static _stack_start: u32;
}

/// A fault of the core. If the stack is what failed, this begins on an empty one: what was on it does not go on.
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "mov r0, sp",
        "ldr r1, ={end}",
        // By how much it is over, less one: nothing else is so close below.
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
        span = const SPAN.ilog2(),
    )
}

/// `stack` is where the core has put its frame, or would have.
extern "C" fn faulted(stack: usize) -> ! {
    // SAFETY: reading status registers of the core.
    let (cfsr, hfsr) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).hfsr.read()) };
    let (end, start) = (&raw const _stack_end as usize, &raw const _stack_start as usize);
    let over = end.wrapping_sub(stack);
    if (1..=SPAN as usize).contains(&over) {
        restart(
            FaultKind::Core,
            format_args!("stack overflow: {over} bytes over {}, CFSR {cfsr:#010x}, HFSR {hfsr:#010x}", start - end),
        )
    }
    // SAFETY: inside the stack, where the core has put it.
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
    restart(FaultKind::Interrupt, format_args!("interrupt {number} that nobody claims"))
}

/// What the board says that it is, else the watchdog was not fed. That comes once without a reason where the emulator's clock has
/// jumped: its time begins anew.
#[exception]
unsafe fn NonMaskableInt() {
    if let Some(reason) = board::NMI {
        restart(FaultKind::Interrupt, format_args!("{reason}"));
    }
    match watch::stuck() {
        Some(what) => restart(FaultKind::Watchdog, format_args!("{what}")),
        None => board::watchdog::feed(),
    }
}
