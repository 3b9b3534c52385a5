//! The newest value of a context that never waits, for another that never waits either.
//!
//! In: a value filled in place by the writer, then published. Out: the newest published value, by
//! reference.
//! Owns: three buffers. One is the writer's, one the reader's; the third lies between them and
//! changes owner by one exchange.
//! Fails: never; a value that is replaced before it is read is lost.
use crate::sync::{AtomicBool, AtomicU8, Cell, Ordering, exchange};

/// Set in `between` while the buffer there has not been read.
const NEW: u8 = 4;

/// Three buffers of `T`.
pub struct Latest<T: Copy> {
    /// Which buffer (0…2) lies between writer and reader, with `NEW`.
    between: AtomicU8,
    taken: AtomicBool,
    buffers: [Cell<T>; 3],
}

// SAFETY: the writer's, the reader's and the middle buffer are always three different ones. A
// buffer changes owner only by the exchange of `between`, which orders all accesses before and
// after it.
unsafe impl<T: Copy + Send> Sync for Latest<T> {}

impl<T: Copy> Latest<T> {
    /// Every buffer holds `first`, which the reader gets until something is published.
    #[cfg(not(all(test, loom)))]
    pub const fn new(first: T) -> Self {
        Latest {
            between: AtomicU8::new(0),
            taken: AtomicBool::new(false),
            buffers: [Cell::new(first), Cell::new(first), Cell::new(first)],
        }
    }

    /// As above, with loom's parts, which have no const constructor.
    #[cfg(all(test, loom))]
    pub fn new(first: T) -> Self {
        Latest {
            between: AtomicU8::new(0),
            taken: AtomicBool::new(false),
            buffers: [Cell::new(first), Cell::new(first), Cell::new(first)],
        }
    }

    /// Writer and reader, for as long as the value is borrowed.
    pub fn split(&mut self) -> (Writer<'_, T>, Reader<'_, T>) {
        self.halves()
    }

    /// Writer and reader of a shared (usually `static`) value; `None` from the second call on.
    pub fn split_once(&self) -> Option<(Writer<'_, T>, Reader<'_, T>)> {
        // Relaxed: the flag only makes one caller the winner; it publishes no data.
        if self.taken.swap(true, Ordering::Relaxed) { None } else { Some(self.halves()) }
    }

    fn halves(&self) -> (Writer<'_, T>, Reader<'_, T>) {
        // Relaxed: halves from before, if there were any, ended under `&mut`.
        self.between.store(0, Ordering::Relaxed);
        (Writer { latest: self, own: 1 }, Reader { latest: self, own: 2 })
    }

    fn buffer(&self, which: u8) -> &Cell<T> {
        let [a, b, c] = &self.buffers;
        // A total match instead of an index, so that nothing can be out of bounds.
        match which & 3 {
            0 => a,
            1 => b,
            _ => c,
        }
    }
}

/// The half that fills and publishes.
pub struct Writer<'a, T: Copy> {
    latest: &'a Latest<T>,
    own: u8,
}

/// The half that takes the newest value.
pub struct Reader<'a, T: Copy> {
    latest: &'a Latest<T>,
    own: u8,
}

impl<T: Copy> Writer<'_, T> {
    /// The buffer to fill. What it holds now is some older value.
    pub fn buffer(&mut self) -> &mut T {
        // SAFETY: `own` is this half's alone until `publish`, which needs `&mut self` and so ends
        // this borrow.
        self.latest.buffer(self.own).with_mut(|value| unsafe { &mut *value })
    }

    /// Makes the filled buffer the newest. One exchange: on a single core the thread can delay it
    /// only if the thread is the writer. The tick, which nothing interrupts, does it at once.
    pub fn publish(&mut self) {
        // Release half: the reader that takes this buffer gets it filled. Acquire half: the reader
        // has finished with the buffer that comes back before it is written again.
        self.own = self.latest.between.swap(self.own | NEW, exchange()) & 3;
    }
}

impl<T: Copy> Reader<'_, T> {
    /// Whether something newer than the last `read` has been published.
    pub fn is_new(&self) -> bool {
        // Relaxed: advice only; `read` exchanges with the ordering it needs.
        self.latest.between.load(Ordering::Relaxed) & NEW != 0
    }

    /// The newest value. It stays unchanged while the reference lives.
    pub fn read(&mut self) -> &T {
        if self.is_new() {
            // Acquire half: the buffer is read as it was filled. Release half: this half's reads of
            // the buffer it gives back are over before the writer gets it.
            self.own = self.latest.between.swap(self.own, exchange()) & 3;
        }
        self.last()
    }

    /// The value of the last `read`.
    pub fn last(&self) -> &T {
        // SAFETY: `own` is this half's alone until the exchange in `read`, which needs `&mut self`.
        self.latest.buffer(self.own).with(|value| unsafe { &*value })
    }
}
