//! Behaviour against a model, and two real threads for Miri.
use crate::{Latest, Ring, Store};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::collections::VecDeque;
use std::thread;

const COUNT: u32 = if cfg!(miri) { 60 } else { 200_000 };

#[test]
fn ring_behaves_as_a_bounded_queue() {
    let mut ring: Ring<u32, 4> = Ring::new();
    let (mut tx, mut rx) = ring.split();
    let mut model: VecDeque<u32> = VecDeque::new();
    // The counts exceed the ring's size many times.
    let mut dice = SplitMix64::seed_from_u64(12345);
    for n in 0..COUNT.min(5_000) {
        match dice.next_u64() >> 60 {
            0..=7 => {
                let pushed = tx.push(n);
                if model.len() < 4 {
                    assert_eq!(pushed, Ok(()));
                    model.push_back(n);
                } else {
                    assert_eq!(pushed, Err(n));
                }
            }
            8..=13 => assert_eq!(rx.pop(), model.pop_front()),
            14 => {
                rx.skip();
                model.pop_front();
            }
            _ => {
                rx.clear();
                model.clear();
            }
        }
        assert_eq!(rx.peek(), model.front());
        assert_eq!((rx.len(), tx.free()), (model.len(), 4 - model.len()));
        assert_eq!((rx.is_empty(), tx.is_empty()), (model.is_empty(), model.is_empty()));
    }
}

#[test]
fn ring_counts_wrap() {
    let mut ring: Ring<u8, 2> = Ring::counted_from(u32::MAX);
    let (mut tx, mut rx) = ring.split();
    assert_eq!((tx.push(1), tx.push(2), tx.push(3)), (Ok(()), Ok(()), Err(3)));
    assert_eq!((rx.pop(), rx.pop(), rx.pop()), (Some(1), Some(2), None));
}

#[test]
fn a_static_is_split_once() {
    static RING: Ring<u8, 2> = Ring::new();
    static LATEST: Latest<u8> = Latest::new(0);
    assert!(RING.split_once().is_some() && LATEST.split_once().is_some());
    assert!(RING.split_once().is_none() && LATEST.split_once().is_none());
}

#[test]
fn ring_between_threads_keeps_order() {
    let mut ring: Ring<[u32; 3], 8> = Ring::new();
    let (mut tx, mut rx) = ring.split();
    thread::scope(|scope| {
        scope.spawn(move || {
            for n in 0..COUNT {
                while tx.push([n, !n, n ^ 5]).is_err() {
                    thread::yield_now();
                }
            }
        });
        for n in 0..COUNT {
            let value = loop {
                if let Some(value) = rx.pop() {
                    break value;
                }
                thread::yield_now();
            };
            assert_eq!(value, [n, !n, n ^ 5]);
        }
    });
}

#[test]
fn latest_gives_the_newest_whole() {
    let mut latest = Latest::new([0u32; 8]);
    let (mut tx, mut rx) = latest.split();
    assert_eq!(rx.read(), &[0; 8]);
    for n in 1..4 {
        *tx.buffer() = [n; 8];
        tx.publish();
    }
    assert!(rx.is_new());
    assert_eq!(rx.read(), &[3; 8]);
    assert!(!rx.is_new());
    assert_eq!(rx.last(), &[3; 8]);
    thread::scope(|scope| {
        scope.spawn(move || {
            for n in 4..COUNT {
                *tx.buffer() = [n; 8];
                tx.publish();
            }
        });
        let mut before = 3;
        while before + 1 < COUNT {
            let value = *rx.read();
            assert!(value.iter().all(|word| *word == value[0]) && value[0] >= before, "{value:?} after {before}");
            before = value[0];
            thread::yield_now();
        }
    });
}

#[test]
fn store_keeps_words_and_masks_slots() {
    static STORE: Store<3, 8> = Store::new();
    for slot in 0..8 {
        STORE.write(slot, [slot, slot + 100, !slot]);
    }
    STORE.write(8 + 3, [7, 7, 7]);
    assert_eq!(STORE.read(3), [7, 7, 7]);
    assert_eq!(STORE.read(u32::MAX), [7, 107, !7]);
    assert_eq!(STORE.read(16), [0, 100, !0]);
}

#[test]
fn a_commit_through_a_ring_shows_the_slots() {
    let store: Store<3, 16> = Store::new();
    let mut ring: Ring<u32, 4> = Ring::new();
    let (mut tx, mut rx) = ring.split();
    thread::scope(|scope| {
        let store = &store;
        scope.spawn(move || {
            for slot in 0..16u32 {
                store.write(slot, [slot + 1, slot + 2, slot + 3]);
                while tx.push(slot + 1).is_err() {
                    thread::yield_now();
                }
            }
        });
        let mut end = 0;
        while end < 16 {
            if let Some(commit) = rx.pop() {
                for slot in end..commit {
                    assert_eq!(store.read(slot), [slot + 1, slot + 2, slot + 3]);
                }
                end = commit;
            }
            thread::yield_now();
        }
    });
}
