//! The bell: how interrupts tell a task that there is something to do.
//!
//! In: rings from the link's interrupts and from PendSV. Out: a task that goes on. Owns one flag and
//! one waker. Rings while nobody waits are kept as one. The servo tick never touches it: it pends
//! PendSV, which rings for it.
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
    /// A silent bell.
    pub const fn new() -> Self {
        Bell { rung: AtomicBool::new(false), waker: AtomicWaker::new() }
    }

    /// Something is to be done. Takes a critical section, so not from the tick.
    pub fn ring(&self) {
        // Release: what was done before the ring is seen by the task that it wakes.
        self.rung.store(true, Ordering::Release);
        self.waker.wake();
    }

    /// Waits until the bell has rung since the last wait.
    pub async fn wait(&self) {
        poll_fn(|context| {
            // Registered first: a ring between the look and the registration would be lost.
            self.waker.register(context.waker());
            if self.rung.swap(false, Ordering::Acquire) { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }
}
