//! The interrupt bodies, and what each of them owns. Which interrupt runs which body is in
//! `vectors.rs`.
//!
//! In: interrupts of the board. Out: ticks, bytes for the task, wake signals. Owns what
//! start-up has given to each handler. Budget: `cargo xtask ticks` holds the tick's; the others
//! move a byte or a flag. Fails: a handler that was given nothing does nothing.
use crate::load;
use crate::statics::{LINK_WAKE, RECEIVED_BYTES, RECEIVER, RECEIVING, SERVO};
use crate::supervision;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m_rt::exception;
use hal::board::timer::TickTimer;
use hal::board::uart::Rx;
use hal::board::{AXES, Machine};
use hal::board::{hold_link, wake_thread};
use ring::Producer;
use servo::tick::{Tick, TickHalves};

/// What the servo tick owns.
pub struct Servo {
    /// Makes the ticks.
    pub timer: TickTimer,
    /// The axes' machine.
    pub machine: Machine,
    /// The tick itself.
    pub tick: &'static mut Tick<AXES>,
    /// Its halves of the hand-overs.
    pub lanes: TickHalves<'static, AXES>,
}

/// What the link's receive interrupt owns.
pub struct LinkReceiver {
    /// The UART.
    pub rx: Rx,
    /// Where its bytes go.
    pub bytes: Producer<'static, u8, RECEIVED_BYTES>,
}

/// A value that start-up gives to one interrupt handler for good. All zero at start.
pub struct HandedOver<T> {
    given: AtomicBool,
    value: UnsafeCell<MaybeUninit<T>>,
}

// SAFETY: `give` runs before the handler can, `taken` only in the handler, which does not nest.
unsafe impl<T: Send> Sync for HandedOver<T> {}

impl<T> HandedOver<T> {
    /// No value yet.
    pub const fn nothing() -> Self {
        HandedOver { given: AtomicBool::new(false), value: UnsafeCell::new(MaybeUninit::uninit()) }
    }

    /// Hands the value over.
    ///
    /// # Safety
    /// Before the interrupt that uses it is enabled.
    pub unsafe fn give(&self, value: T) {
        // SAFETY: no handler reads it yet.
        unsafe { (*self.value.get()).write(value) };
        // Release: the value is written before the flag.
        self.given.store(true, Ordering::Release);
    }

    /// The value, in its handler; `None` if there is none.
    ///
    /// # Safety
    /// Only in the one handler that owns it, once a run.
    #[allow(clippy::mut_from_ref)]
    unsafe fn taken(&self) -> Option<&mut T> {
        if !self.given.load(Ordering::Acquire) {
            return None;
        }
        // SAFETY: `give` has written it, and the handler does not nest, so this is the only
        // reference.
        Some(unsafe { (*self.value.get()).assume_init_mut() })
    }
}

/// The servo tick.
#[inline(always)]
pub fn tick() {
    supervision::tick_begins();
    // SAFETY: the tick's handler.
    let Some(servo) = (unsafe { SERVO.taken() }) else { return };
    // Whole microseconds up to 1 ms, so it fits.
    let period_ns = servo.tick.period().0 as u32;
    servo.timer.run_at(period_ns);
    // The plant takes the place of a machine: its time does not count as the tick's.
    servo.machine.advance(period_ns);
    servo.timer.begin();
    servo.tick.run(&mut servo.machine, &mut servo.lanes);
    let in_time = servo.machine.emit();
    let (overran, took) = servo.timer.taken();
    if !in_time || overran {
        servo.tick.overrun();
    }
    if let Some(ns) = took {
        load::tick_took(ns);
    }
    wake_thread();
    supervision::tick_ends(servo.tick.now());
}

/// A byte of the link may have arrived; true if it had. It wakes the task at the end of a frame, or
/// when half the queue is used. When the queue is full, it holds the sender.
#[inline(always)]
pub fn received() -> bool {
    // SAFETY: the receive interrupt's handler.
    let Some(receiver) = (unsafe { RECEIVER.taken() }) else { return false };
    if receiver.bytes.free() == 0 {
        hold_link();
        LINK_WAKE.raise();
        return false;
    }
    let Some(byte) = receiver.rx.receive() else { return false };
    RECEIVING.store(true, Ordering::Relaxed);
    // There is room: the consumer only frees more.
    let _ = receiver.bytes.push(byte);
    const FRAME_END: u8 = 0;
    if byte == FRAME_END || receiver.bytes.free() < RECEIVED_BYTES / 2 {
        LINK_WAKE.raise();
    }
    true
}

/// The link or the trace can take bytes again.
pub fn sent() {
    LINK_WAKE.raise();
}

/// The wake-up from the tick: PendSV may raise the task's wake signal, the tick may not.
#[exception]
fn PendSV() {
    LINK_WAKE.raise();
}
