//! Atomics and cells: `core`'s in every build, loom's inside the models. There an ordering can also
//! be weakened on purpose, to make the model fail.

#[cfg(not(all(test, loom)))]
mod real {
    pub use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

    /// A cell; the caller states when it may be touched.
    #[repr(transparent)]
    pub struct Cell<T>(core::cell::UnsafeCell<T>);

    impl<T> Cell<T> {
        /// A cell that holds `value`.
        pub const fn new(value: T) -> Self {
            Cell(core::cell::UnsafeCell::new(value))
        }
        /// The address of the value; reading it is the caller's `unsafe`.
        pub fn with<R>(&self, f: impl FnOnce(*const T) -> R) -> R {
            f(self.0.get())
        }
        /// The address of the value, to be changed; doing so is the caller's `unsafe`.
        pub fn with_mut<R>(&self, f: impl FnOnce(*mut T) -> R) -> R {
            f(self.0.get())
        }
    }

    /// What was written before is visible to the context that observes the store.
    pub const fn publish() -> Ordering {
        Ordering::Release
    }
    /// What was written before the observed store is visible from here on.
    pub const fn observe() -> Ordering {
        Ordering::Acquire
    }
    /// Both at once, for an exchange.
    pub const fn exchange() -> Ordering {
        Ordering::AcqRel
    }
}

#[cfg(all(test, loom))]
mod real {
    pub use loom::cell::UnsafeCell as Cell;
    pub use loom::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

    /// Which ordering the model breaks.
    #[derive(Clone, Copy, PartialEq, Eq)]
    pub enum Weak {
        Nothing,
        Publish,
        Observe,
        Exchange,
    }

    std::thread_local! {
        /// Loom runs a model's threads as coroutines of the test's own thread, so all of them read
        /// this.
        pub static WEAK: core::cell::Cell<Weak> = const { core::cell::Cell::new(Weak::Nothing) };
    }

    fn unless(weak: Weak, ordering: Ordering) -> Ordering {
        if WEAK.get() == weak { Ordering::Relaxed } else { ordering }
    }
    pub fn publish() -> Ordering {
        unless(Weak::Publish, Ordering::Release)
    }
    pub fn observe() -> Ordering {
        unless(Weak::Observe, Ordering::Acquire)
    }
    pub fn exchange() -> Ordering {
        unless(Weak::Exchange, Ordering::AcqRel)
    }
}

pub use real::*;
