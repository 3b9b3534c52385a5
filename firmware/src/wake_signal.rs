//! The bell: a wake-up signal from interrupts to one task.
//!
//! In: rings from the link's interrupts and from PendSV. Out: a task that continues. Owns one flag
//! and one waker. Rings while no task waits are kept as one. The servo tick never touches it: it
//! pends PendSV, which rings the bell for it. Fails never.
use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::Poll;
use embassy_sync::waitqueue::AtomicWaker;

/// One bell for one waiting task.
pub struct Bell {
    rung: AtomicBool,
    waker: AtomicWaker,
}

impl Bell {
    /// A bell that has not rung.
    pub const fn new() -> Self {
        Bell { rung: AtomicBool::new(false), waker: AtomicWaker::new() }
    }

    /// Wakes the task. It takes a critical section, so the tick must not call it.
    pub fn ring(&self) {
        // Release: writes before the ring are visible to the task that it wakes.
        self.rung.store(true, Ordering::Release);
        self.waker.wake();
    }

    /// Waits until the bell has rung since the last wait.
    pub async fn wait(&self) {
        poll_fn(|context| {
            // Registered first: a ring between the check and the registration would be lost.
            self.waker.register(context.waker());
            if self.rung.swap(false, Ordering::Acquire) { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }
}
