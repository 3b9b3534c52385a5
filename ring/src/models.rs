//! Every interleaving and every reordering that the memory model allows, within loom's bounds. Each
//! model runs as it is, and again with one ordering weakened; then it must fail.
use crate::sync::{WEAK, Weak};
use crate::{Latest, Ring, Store};
use std::boxed::Box;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Runs a model; returns how many executions were explored, or none if one of them failed.
fn explore(weak: Weak, model: fn()) -> Option<u64> {
    let executions = Arc::new(AtomicU64::new(0));
    let count = executions.clone();
    WEAK.set(weak);
    let result = catch_unwind(AssertUnwindSafe(|| {
        loom::model(move || {
            count.fetch_add(1, Relaxed);
            model();
        })
    }));
    WEAK.set(Weak::Nothing);
    result.ok().map(|()| executions.load(Relaxed))
}

/// Three values through two slots, so that a slot is used again; each value also publishes a
/// store's slot.
fn ring() {
    // Leaked so that the halves can go to a thread; a few hundred bytes per execution.
    let ring: &'static Ring<[u32; 2], 2> = Box::leak(Box::new(Ring::new()));
    let store: &'static Store<1, 4> = Box::leak(Box::new(Store::new()));
    let (mut tx, mut rx) = ring.split_once().unwrap();
    let thread = loom::thread::spawn(move || {
        for n in 1..=3 {
            store.write(n, [n * 10]);
            if tx.push([n, n + 7]).is_err() {
                break;
            }
        }
    });
    let mut expected = 1;
    let mut take = || {
        if let Some([n, m]) = rx.pop() {
            assert_eq!((n, m), (expected, expected + 7));
            assert_eq!(store.read(n), [n * 10]);
            expected += 1;
        }
    };
    take();
    take();
    thread.join().unwrap();
    take();
    take();
    take();
    assert!(expected >= 3);
}

/// Three values published while two are read: complete, and never older than the one before.
fn latest() {
    let latest: &'static Latest<[u32; 2]> = Box::leak(Box::new(Latest::new([0; 2])));
    let (mut tx, mut rx) = latest.split_once().unwrap();
    let thread = loom::thread::spawn(move || {
        for n in 1..=3 {
            *tx.buffer() = [n, n];
            tx.publish();
        }
    });
    let mut before = 0;
    for _ in 0..2 {
        let [a, b] = *rx.read();
        assert!(a == b && a >= before);
        before = a;
    }
    thread.join().unwrap();
    assert_eq!(*rx.read(), [3, 3]);
}

/// As the tick takes a lane: it reads values in place, skips them, drops all; later values are
/// complete.
fn lane() {
    let ring: &'static Ring<[u32; 2], 2> = Box::leak(Box::new(Ring::new()));
    let (mut tx, mut rx) = ring.split_once().unwrap();
    let thread = loom::thread::spawn(move || (1..=3).take_while(|&n| tx.push([n, n + 7]).is_ok()).count() as u32);
    let mut before = 0;
    let mut look = |rx: &mut crate::Consumer<'_, [u32; 2], 2>| {
        if let Some(&[n, m]) = rx.peek() {
            assert!(m == n + 7 && n > before);
            before = n;
            rx.skip();
        }
    };
    look(&mut rx);
    rx.clear();
    look(&mut rx);
    let pushed = thread.join().unwrap();
    look(&mut rx);
    look(&mut rx);
    assert!(rx.is_empty() && before <= pushed);
}

/// As the tick reports events: an event, then the view that goes with it. A reader of the view
/// finds the event.
fn events() {
    let ring: &'static Ring<u32, 2> = Box::leak(Box::new(Ring::new()));
    let latest: &'static Latest<u32> = Box::leak(Box::new(Latest::new(0)));
    let ((mut tx, mut rx), (mut view_in, mut view)) = (ring.split_once().unwrap(), latest.split_once().unwrap());
    let thread = loom::thread::spawn(move || {
        for n in 1..=2 {
            tx.push(n).unwrap();
            *view_in.buffer() = n;
            view_in.publish();
        }
    });
    let mut heard = 0;
    for _ in 0..2 {
        let seen = *view.read();
        while let Some(n) = rx.pop() {
            assert_eq!(n, heard + 1);
            heard = n;
        }
        assert!(heard >= seen);
    }
    thread.join().unwrap();
}

#[test]
fn lane_holds_in_every_execution() {
    let executions = explore(Weak::Nothing, lane).expect("the lane's model fails");
    std::println!("lane: {executions} executions");
    assert!(executions > 10, "only {executions} executions");
}

#[test]
fn lane_needs_its_release() {
    assert_eq!(explore(Weak::Publish, lane), None);
}

#[test]
fn changes_hold_in_every_execution() {
    let executions = explore(Weak::Nothing, events).expect("the model of events fails");
    std::println!("events: {executions} executions");
    assert!(executions > 10, "only {executions} executions");
}

#[test]
fn changes_need_the_exchange() {
    assert_eq!(explore(Weak::Exchange, events), None);
}

#[test]
fn ring_holds_in_every_execution() {
    let executions = explore(Weak::Nothing, ring).expect("the ring's model fails");
    std::println!("ring: {executions} executions");
    assert!(executions > 10, "only {executions} executions");
}

#[test]
fn ring_needs_its_release() {
    assert_eq!(explore(Weak::Publish, ring), None);
}

#[test]
fn ring_needs_its_acquire() {
    assert_eq!(explore(Weak::Observe, ring), None);
}

#[test]
fn latest_holds_in_every_execution() {
    let executions = explore(Weak::Nothing, latest).expect("the triple buffer's model fails");
    std::println!("latest: {executions} executions");
    assert!(executions > 10, "only {executions} executions");
}

#[test]
fn latest_needs_its_exchange() {
    assert_eq!(explore(Weak::Exchange, latest), None);
}
