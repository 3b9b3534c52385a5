//! A process that was forked while a controller was open: in the child every call returns −7.
//!
//! The child has neither the threads that drive the link nor the right to speak on it, and a lock
//! may be held by a thread that it has not. So nothing is locked there, and nothing is closed at
//! its end: the controller stays the parent's.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

static IS_CHILD: AtomicBool = AtomicBool::new(false);
static OPEN: AtomicUsize = AtomicUsize::new(0);

/// Whether this process is such a child.
pub fn is_child() -> bool {
    IS_CHILD.load(Ordering::Relaxed)
}

/// A controller is open from now on.
pub fn opened() {
    OPEN.fetch_add(1, Ordering::Relaxed);
    #[cfg(unix)]
    {
        static WATCHED: std::sync::Once = std::sync::Once::new();
        WATCHED.call_once(watch);
    }
}

/// One is closed.
pub fn closed() {
    OPEN.fetch_sub(1, Ordering::Relaxed);
}

#[cfg(unix)]
fn watch() {
    unsafe extern "C" {
        fn pthread_atfork(
            prepare: Option<extern "C" fn()>,
            parent: Option<extern "C" fn()>,
            child: Option<extern "C" fn()>,
        ) -> std::ffi::c_int;
    }
    extern "C" fn child() {
        if OPEN.load(Ordering::Relaxed) > 0 {
            IS_CHILD.store(true, Ordering::Relaxed);
        }
    }
    // SAFETY: `child` takes no lock and allocates nothing.
    unsafe { pthread_atfork(None, None, Some(child)) };
}
