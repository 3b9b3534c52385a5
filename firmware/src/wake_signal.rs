//! The wake signal: from interrupts to one task.
//!
//! In: signals from the link's interrupts and from PendSV. Out: a task that continues. Owns one
//! flag and one waker. Signals while no task waits are kept as one. The servo tick never touches
//! it: it pends PendSV, which raises the signal for it. Fails never.
use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::Poll;
use embassy_sync::waitqueue::AtomicWaker;

/// One signal for one waiting task.
pub struct WakeSignal {
    raised: AtomicBool,
    waker: AtomicWaker,
}

impl WakeSignal {
    /// A signal that is not raised.
    pub const fn new() -> Self {
        WakeSignal { raised: AtomicBool::new(false), waker: AtomicWaker::new() }
    }

    /// Wakes the task. It takes a critical section, so the tick must not call it.
    pub fn raise(&self) {
        // Release: writes before it are visible to the task that it wakes.
        self.raised.store(true, Ordering::Release);
        self.waker.wake();
    }

    /// Waits until the signal has been raised since the last wait.
    pub async fn wait(&self) {
        poll_fn(|context| {
            // Registered first: a signal between the check and the registration would be lost.
            self.waker.register(context.waker());
            if self.raised.swap(false, Ordering::Acquire) { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }
}
