//! Threads, events, mutexes and semaphores of `compat/windows.h`, as waits see them.
//!
//! In: handles, numbers from 1. Out: signalled or not; a wait takes what an object gives. The
//! header makes the threads themselves (POSIX threads); here is what others may wait for. A handle
//! that is not known fails the call, as there.

use super::waits::{self, Inner, expect_thread, lock, me, no_thread, register};
use std::collections::BTreeMap;
use std::ffi::{c_int, c_uint, c_ulong};
use std::time::Duration;

/// Without end.
const INFINITE: c_ulong = 0xffff_ffff;
/// What a wait returns: an object's index, or one of these.
const TIMEOUT: c_ulong = 0x102;
const FAILED: c_ulong = 0xffff_ffff;
/// Of a thread that runs.
const STILL_ACTIVE: c_ulong = 259;
/// Most objects of one wait.
const OBJECTS_MAX: usize = 64;

/// What an object is.
enum ObjectKind {
    /// A thread: its code once it has ended, how often it is suspended before it starts, whether it
    /// is to end.
    Thread { code: Option<c_ulong>, suspended: u32, ends: bool },
    /// An event; one that is not manual is taken by the wait that it ends.
    Event { manual: bool, set: bool },
    /// A mutex or a critical section: its thread, and how often that has it.
    Mutex { owner: u64, depth: u32 },
    /// A semaphore.
    Semaphore { count: i64, most: i64 },
}

/// An object, and how many handles it has: a running thread holds one of its own.
struct Object {
    kind: ObjectKind,
    handles: u32,
}

/// All of them.
pub struct Objects {
    all: BTreeMap<c_ulong, Object>,
    last: c_ulong,
}

impl Objects {
    /// None.
    pub const fn new() -> Objects {
        Objects { all: BTreeMap::new(), last: 0 }
    }

    fn add(&mut self, kind: ObjectKind, handles: u32) -> c_ulong {
        self.last += 1;
        self.all.insert(self.last, Object { kind, handles });
        self.last
    }

    fn release(&mut self, handle: c_ulong) -> bool {
        let Some(object) = self.all.get_mut(&handle) else { return false };
        object.handles -= 1;
        if object.handles == 0 {
            self.all.remove(&handle);
        }
        true
    }

    /// Whether a wait of thread `me` ends with this object.
    fn is_ready(&self, handle: c_ulong, me: u64) -> bool {
        self.all.get(&handle).is_some_and(|object| match object.kind {
            ObjectKind::Thread { code, .. } => code.is_some(),
            ObjectKind::Event { set, .. } => set,
            ObjectKind::Mutex { owner, depth } => depth == 0 || owner == me,
            ObjectKind::Semaphore { count, .. } => count > 0,
        })
    }

    /// Takes what it gives.
    fn take(&mut self, handle: c_ulong, me: u64) {
        match self.all.get_mut(&handle).map(|object| &mut object.kind) {
            Some(ObjectKind::Event { manual: false, set }) => *set = false,
            Some(ObjectKind::Mutex { owner, depth }) => {
                *owner = me;
                *depth += 1;
            }
            Some(ObjectKind::Semaphore { count, .. }) => *count -= 1,
            _ => {}
        }
    }
}

/// A thread is about to be created; it has two handles, one its own. The creator counts it as
/// running.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_new(suspended: c_int) -> c_ulong {
    expect_thread();
    let kind = ObjectKind::Thread { code: None, suspended: u32::from(suspended != 0), ends: false };
    lock().objects.add(kind, 2)
}

/// It could not be created.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_failed(thread: c_ulong) {
    no_thread();
    let mut inner = lock();
    inner.objects.all.remove(&thread);
    inner.signal();
}

/// The thread has begun: it goes on once it is not suspended.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_begin(thread: c_ulong) {
    register(true);
    let runs = |inner: &mut Inner| match inner.objects.all.get(&thread).map(|object| &object.kind) {
        Some(ObjectKind::Thread { suspended: 1.., .. }) => None,
        _ => Some(()),
    };
    waits::wait(None, runs);
}

/// The thread ends with this code.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_end(thread: c_ulong, result: c_ulong) {
    let mut inner = lock();
    if let Some(Object { kind: ObjectKind::Thread { code, .. }, .. }) = inner.objects.all.get_mut(&thread) {
        *code = Some(result);
    }
    inner.objects.release(thread);
    inner.signal();
}

/// Lets a suspended thread go; how often it was suspended before, or −1.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_resume(thread: c_ulong) -> c_int {
    let mut inner = lock();
    let Some(Object { kind: ObjectKind::Thread { suspended, .. }, .. }) = inner.objects.all.get_mut(&thread) else {
        return -1;
    };
    let before = *suspended;
    *suspended = before.saturating_sub(1);
    inner.signal();
    before as c_int
}

/// Asks a thread to end: at its next wait here. 0 if there is none.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_stop(thread: c_ulong) -> c_int {
    let mut inner = lock();
    let Some(Object { kind: ObjectKind::Thread { ends, .. }, .. }) = inner.objects.all.get_mut(&thread) else {
        return 0;
    };
    *ends = true;
    inner.signal();
    1
}

/// Whether a thread was asked to end.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_is_stopped(thread: c_ulong) -> c_int {
    let inner = lock();
    c_int::from(matches!(
        inner.objects.all.get(&thread),
        Some(Object { kind: ObjectKind::Thread { ends: true, .. }, .. })
    ))
}

/// The code of a thread: 259 while it runs. 0 if there is none.
///
/// # Safety
/// `code` is an address for the code.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn beamtick_thread_code(thread: c_ulong, code: *mut c_ulong) -> c_int {
    match lock().objects.all.get(&thread) {
        Some(Object { kind: ObjectKind::Thread { code: found, .. }, .. }) => {
            // SAFETY: the caller's.
            unsafe { code.write(found.unwrap_or(STILL_ACTIVE)) };
            1
        }
        _ => 0,
    }
}

/// An event.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_event_new(manual: c_int, set: c_int) -> c_ulong {
    lock().objects.add(ObjectKind::Event { manual: manual != 0, set: set != 0 }, 1)
}

/// Sets or clears an event; 0 if there is none.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_event_set(event: c_ulong, to: c_int) -> c_int {
    let mut inner = lock();
    let Some(Object { kind: ObjectKind::Event { set, .. }, .. }) = inner.objects.all.get_mut(&event) else { return 0 };
    *set = to != 0;
    inner.signal();
    1
}

/// A mutex; `owned`: the calling thread has it.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_mutex_new(owned: c_int) -> c_ulong {
    let owner = me();
    lock().objects.add(ObjectKind::Mutex { owner, depth: u32::from(owned != 0) }, 1)
}

/// Gives a mutex back; 0 if the calling thread has not got it.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_mutex_release(mutex: c_ulong) -> c_int {
    let me = me();
    let mut inner = lock();
    match inner.objects.all.get_mut(&mutex) {
        Some(Object { kind: ObjectKind::Mutex { owner, depth: depth @ 1.. }, .. }) if *owner == me => {
            *depth -= 1;
            if *depth == 0 {
                inner.signal();
            }
            1
        }
        _ => 0,
    }
}

/// A semaphore; 0 if its numbers make none.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_semaphore_new(count: c_int, most: c_int) -> c_ulong {
    if most <= 0 || !(0..=most).contains(&count) {
        return 0;
    }
    lock().objects.add(ObjectKind::Semaphore { count: count.into(), most: most.into() }, 1)
}

/// Adds to a semaphore; what it had, or −1.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_semaphore_release(semaphore: c_ulong, more: c_int) -> c_int {
    let mut inner = lock();
    match inner.objects.all.get_mut(&semaphore) {
        Some(Object { kind: ObjectKind::Semaphore { count, most }, .. })
            if more > 0 && *count + i64::from(more) <= *most =>
        {
            let before = *count;
            *count += i64::from(more);
            inner.signal();
            before as c_int
        }
        _ => -1,
    }
}

/// Ends a handle; 0 if it is none.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_handle_close(handle: c_ulong) -> c_int {
    c_int::from(lock().objects.release(handle))
}

/// Waits for one of some objects, or for all: the index of the first that ended it, 258 after
/// `milliseconds` of the program's time, or 0xffffffff for a handle that is none. `thread` is the
/// calling thread's own handle or 0: it wakes too when it is asked to end.
///
/// # Safety
/// `handles` is the address of `count` handles.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn beamtick_wait(
    thread: c_ulong,
    handles: *const c_ulong,
    count: c_uint,
    all: c_int,
    milliseconds: c_ulong,
) -> c_ulong {
    let count = count as usize;
    if handles.is_null() || !(1..=OBJECTS_MAX).contains(&count) {
        return FAILED;
    }
    // SAFETY: the caller's.
    let handles: Vec<c_ulong> = (0..count).map(|n| unsafe { handles.add(n).read() }).collect();
    let me = me();
    let ready = |inner: &mut Inner| {
        let objects = &mut inner.objects;
        if handles.iter().any(|handle| !objects.all.contains_key(handle)) {
            return Some(FAILED);
        }
        if let Some(Object { kind: ObjectKind::Thread { ends: true, .. }, .. }) = objects.all.get(&thread) {
            return Some(TIMEOUT);
        }
        if all != 0 {
            let found = handles.iter().all(|handle| objects.is_ready(*handle, me));
            return found.then(|| {
                handles.iter().for_each(|handle| objects.take(*handle, me));
                0
            });
        }
        let index = handles.iter().position(|handle| objects.is_ready(*handle, me))?;
        objects.take(*handles.get(index)?, me);
        Some(index as c_ulong)
    };
    #[allow(clippy::useless_conversion)] // It has 32 bits on Windows.
    let time = (milliseconds & INFINITE != INFINITE).then(|| Duration::from_millis(milliseconds.into()));
    waits::wait(time, ready).unwrap_or(TIMEOUT)
}

/// Waits for so many milliseconds of the program's time, or until the thread is asked to end.
#[unsafe(no_mangle)]
pub extern "system" fn beamtick_thread_sleep(thread: c_ulong, milliseconds: c_ulong) {
    let stopped = |inner: &mut Inner| match inner.objects.all.get(&thread) {
        Some(Object { kind: ObjectKind::Thread { ends: true, .. }, .. }) => Some(()),
        _ => None,
    };
    #[allow(clippy::useless_conversion)] // It has 32 bits on Windows.
    waits::wait(Some(Duration::from_millis(milliseconds.into())), stopped);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_wakes_one_or_all() {
        let (one, all) = (beamtick_event_new(0, 1), beamtick_event_new(1, 1));
        // SAFETY: one handle each.
        let wait = |handle: c_ulong| unsafe { beamtick_wait(0, &handle, 1, 0, 0) };
        assert_eq!([wait(one), wait(one), wait(all), wait(all)], [0, TIMEOUT, 0, 0]);
        assert_eq!([beamtick_handle_close(one), beamtick_handle_close(one)], [1, 0]);
        assert_eq!(wait(one), FAILED);
    }

    #[test]
    fn a_mutex_is_its_threads_until_given_back_as_often() {
        let mutex = beamtick_mutex_new(1);
        // SAFETY: one handle.
        let wait = move || unsafe { beamtick_wait(0, &mutex, 1, 0, 1) };
        assert_eq!(wait(), 0);
        let other = move || std::thread::spawn(wait).join().unwrap();
        assert_eq!([other(), beamtick_mutex_release(mutex) as c_ulong, other()], [TIMEOUT, 1, TIMEOUT]);
        assert_eq!([beamtick_mutex_release(mutex) as c_ulong, other()], [1, 0]);
        assert_eq!(beamtick_mutex_release(mutex), 0, "another thread has it");
    }

    #[test]
    fn a_semaphore_counts() {
        let semaphore = beamtick_semaphore_new(1, 2);
        assert_eq!(beamtick_semaphore_new(3, 2), 0);
        assert_eq!([beamtick_semaphore_release(semaphore, 1), beamtick_semaphore_release(semaphore, 1)], [1, -1]);
        // SAFETY: two handles.
        let both = unsafe { beamtick_wait(0, [semaphore, beamtick_event_new(1, 1)].as_ptr(), 2, 1, 0) };
        assert_eq!(both, 0);
        assert_eq!(beamtick_semaphore_release(semaphore, 1), 1);
    }
}
