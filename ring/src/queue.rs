//! A queue between one producer and one consumer.
//!
//! In: values pushed in one context. Out: the same values, in order, popped in the other. Owns: `N`
//! slots.
//! Fails: `push` into a full ring gives the value back. Budget: one load of each index and one
//! store per call, no loop.
use crate::sync::{AtomicBool, AtomicU32, Cell, Ordering, observe, publish};
use core::mem::MaybeUninit;

/// `N` slots (a power of two) for `T`. All bytes are zero or undefined until used, so a static
/// takes no room in the image.
pub struct Ring<T: Copy, const N: usize> {
    /// Values pushed so far, modulo 2³²; written by the producer only.
    pushed: AtomicU32,
    /// Values popped so far, modulo 2³²; written by the consumer only.
    popped: AtomicU32,
    /// Whether `split_once` has been called.
    taken: AtomicBool,
    slots: [Cell<MaybeUninit<T>>; N],
}

// SAFETY: the two halves are handed out once (or under `&mut`). The producer touches a slot only
// while it is free, the consumer only while it is filled. The indices pass a slot on with Release
// and Acquire. Values move to the other context, hence `T: Send`.
unsafe impl<T: Copy + Send, const N: usize> Sync for Ring<T, N> {}

impl<T: Copy, const N: usize> Ring<T, N> {
    const MASK: u32 = {
        assert!(N.is_power_of_two() && N <= 1 << 31, "a ring's size is a power of two");
        (N - 1) as u32
    };

    /// An empty ring.
    #[cfg(not(all(test, loom)))]
    pub const fn new() -> Self {
        Ring {
            pushed: AtomicU32::new(0),
            popped: AtomicU32::new(0),
            taken: AtomicBool::new(false),
            slots: [const { Cell::new(MaybeUninit::uninit()) }; N],
        }
    }

    /// An empty ring, with loom's parts, which have no const constructor.
    #[cfg(all(test, loom))]
    pub fn new() -> Self {
        Ring {
            pushed: AtomicU32::new(0),
            popped: AtomicU32::new(0),
            taken: AtomicBool::new(false),
            slots: core::array::from_fn(|_| Cell::new(MaybeUninit::uninit())),
        }
    }

    /// An empty ring whose counts are about to wrap.
    #[cfg(all(test, not(loom)))]
    pub(crate) fn counted_from(count: u32) -> Self {
        let ring = Self::new();
        ring.pushed.store(count, Ordering::Relaxed);
        ring.popped.store(count, Ordering::Relaxed);
        ring
    }

    /// The two ends, for as long as the ring is borrowed.
    pub fn split(&mut self) -> (Producer<'_, T, N>, Consumer<'_, T, N>) {
        self.halves()
    }

    /// The two ends of a shared (usually `static`) ring; `None` from the second call on.
    pub fn split_once(&self) -> Option<(Producer<'_, T, N>, Consumer<'_, T, N>)> {
        // Relaxed: the flag only makes one caller the winner; it publishes no data.
        if self.taken.swap(true, Ordering::Relaxed) { None } else { Some(self.halves()) }
    }

    fn halves(&self) -> (Producer<'_, T, N>, Consumer<'_, T, N>) {
        // Relaxed: halves from before, if there were any, ended under `&mut`.
        let pushed = self.pushed.load(Ordering::Relaxed);
        let popped = self.popped.load(Ordering::Relaxed);
        (Producer { ring: self, pushed }, Consumer { ring: self, popped })
    }

    fn slot(&self, count: u32) -> &Cell<MaybeUninit<T>> {
        // The mask is N − 1, so the index is below N and the check folds away.
        &self.slots[(count & Self::MASK) as usize]
    }
}

impl<T: Copy, const N: usize> Default for Ring<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// The end that pushes.
pub struct Producer<'a, T: Copy, const N: usize> {
    ring: &'a Ring<T, N>,
    /// The value of `ring.pushed`; only this end changes it.
    pushed: u32,
}

/// The end that pops.
pub struct Consumer<'a, T: Copy, const N: usize> {
    ring: &'a Ring<T, N>,
    /// The value of `ring.popped`; only this end changes it.
    popped: u32,
}

impl<T: Copy, const N: usize> Producer<'_, T, N> {
    /// Appends `value`, or gives it back if the ring is full.
    pub fn push(&mut self, value: T) -> Result<(), T> {
        // Acquire: the consumer has read the slot before it is written again.
        let popped = self.ring.popped.load(observe());
        if self.pushed.wrapping_sub(popped) >= N as u32 {
            return Err(value);
        }
        self.ring.slot(self.pushed).with_mut(|slot| {
            // SAFETY: fewer than N values are in the ring, so the consumer does not read this slot
            // before `pushed` passes it. There is one producer, and it is borrowed mutably.
            unsafe { (*slot).write(value) };
        });
        self.pushed = self.pushed.wrapping_add(1);
        // Release: the value is in its slot before the consumer can read the count.
        self.ring.pushed.store(self.pushed, publish());
        Ok(())
    }

    /// Free slots at least; the consumer may free more meanwhile.
    pub fn free(&self) -> usize {
        N.saturating_sub(self.len())
    }

    /// Values not yet popped, at most.
    pub fn len(&self) -> usize {
        // Relaxed: the number is advice, `push` checks for itself.
        self.pushed.wrapping_sub(self.ring.popped.load(Ordering::Relaxed)) as usize
    }

    /// Whether everything pushed has been popped.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<T: Copy, const N: usize> Consumer<'_, T, N> {
    /// The oldest value, left in its slot.
    pub fn peek(&self) -> Option<&T> {
        self.peek_at(0)
    }

    /// The value after the `before` oldest ones, left in its slot.
    pub fn peek_at(&self, before: u32) -> Option<&T> {
        // Acquire: makes the values visible that were written before the count.
        if self.ring.pushed.load(observe()).wrapping_sub(self.popped) <= before {
            return None;
        }
        // SAFETY: `pushed` is past this slot, so it holds a value. The producer leaves it alone
        // until `popped` passes it, which needs `&mut self` and so ends this borrow.
        Some(self.ring.slot(self.popped.wrapping_add(before)).with(|slot| unsafe { (*slot).assume_init_ref() }))
    }

    /// Takes the oldest value.
    pub fn pop(&mut self) -> Option<T> {
        let value = *self.peek()?;
        self.free_to(self.popped.wrapping_add(1));
        Some(value)
    }

    /// Drops the oldest value, if there is one; after a `peek` this saves `pop`'s copy.
    pub fn skip(&mut self) {
        if !self.is_empty() {
            self.free_to(self.popped.wrapping_add(1));
        }
    }

    /// Drops everything that is in the ring now.
    pub fn clear(&mut self) {
        // Relaxed: nothing of the values is read here.
        self.free_to(self.ring.pushed.load(Ordering::Relaxed));
    }

    fn free_to(&mut self, popped: u32) {
        self.popped = popped;
        // Release: the values have been read before the producer can find their slots free.
        self.ring.popped.store(popped, publish());
    }

    /// Values in the ring at least; the producer may add more meanwhile.
    pub fn len(&self) -> usize {
        // Relaxed: advice only.
        self.ring.pushed.load(Ordering::Relaxed).wrapping_sub(self.popped) as usize
    }

    /// Whether there is nothing to pop.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
