#![no_std]
#![no_main]
//! Counts the instructions of a coordinate system's step, in QEMU with `-icount shift=6` or more.
//!
//! Out, by semihosting: one line a step, `CASE MARK COUNT`, as `ticks.rs` prints them. MARK says
//! what the step did: `path-line`, `path-arc` (it stayed in its motion), `path-turn` (it passed a
//! boundary and planned what follows), `path-enter` (the first step within a motion), `path-stop`
//! (the call of a smooth Stop).
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use hal as _; // the vector table
use probes::clock;
use servo::path::{Effects, EntryEffect, EntryStore, FifoEnds, MotionSpeeds, Path, PathEntry, PathStop, Plane, Sweep};
use servo::segment::piece::Scaled;
use servo::test_hooks::Step;
use servo::units::{Axis, FineNs, Ns, Pos};

const PERIOD: Ns = Ns(250_000);
const MOTIONS: u32 = 60;

static STORES: [EntryStore; 2] = [EntryStore::new(), EntryStore::new()];

probes::exit_on_panic!();

/// Takes the effects of a path.
struct Sink;

impl Effects for Sink {
    fn change(&mut self, _: FineNs, _: &EntryEffect) -> FineNs {
        0
    }
    fn standstill(&mut self, _: FineNs, _: PathStop) {}
    fn gear(&mut self, _: Axis, _: Pos, _: Scaled) {}
    fn geared(&mut self, _: u128, _: Axis, _: i32) {}
}

#[inline(never)]
fn step(path: &mut Path, next: Ns, feed: FifoEnds) -> Step {
    path.step(next, PERIOD, feed, &STORES, &mut Sink)
}

#[inline(never)]
fn stop(path: &mut Path, next: Ns, feed: FifoEnds) {
    path.stop(next, false, feed, &STORES, &mut Sink);
}

#[inline(never)]
fn nothing(_: &mut Path, _: Ns, _: FifoEnds) {}

/// Counter periods around a call.
fn count<T>(call: fn(&mut Path, Ns, FifoEnds) -> T, path: &mut Path, next: Ns, feed: FifoEnds) -> (u32, T) {
    let call = black_box(call);
    let before = clock::read();
    let result = call(path, next, feed);
    (before.passed(), result)
}

/// Runs FIFO 0 from standstill to standstill.
fn run(path: &mut Path, mark: &str, begin: Ns, reading: u32) -> Ns {
    let feed = FifoEnds { ends: [MOTIONS, 0] };
    let mut next = begin;
    path.start(next, 0, feed, &STORES);
    let mut entered = true;
    loop {
        let released = path.released(0);
        let (periods, published) = count(step, path, next, feed);
        let turned = path.released(0) != released;
        let what = match (turned, entered) {
            (true, _) => "path-turn",
            (false, true) => "path-enter",
            (false, false) => mark,
        };
        hprintln!("1 {} {}", what, periods.saturating_sub(reading));
        entered = turned;
        next.0 += PERIOD.0;
        if !published.runs {
            return next;
        }
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let speeds = |v: f64, a: f64, e: f64| MotionSpeeds::admit(v.to_bits(), a.to_bits(), e.to_bits());
    let mut path = Path::IDLE;
    let reading = count(nothing, &mut path, Ns(0), FifoEnds::default()).0;
    let mut begin = Ns(1_000_000);
    // Lines in four coordinates, each entered at speed; then arcs of both kinds.
    for arcs in [false, true] {
        path.position([Pos(0); 4]);
        for k in 0..MOTIONS {
            let Ok(along) = speeds(81.3, 3.7, f64::from(k % 7) * 11.7) else { panic!("refused") };
            let (x, y) = (k as i32 + 1, (k as i32 * 37) % 101);
            let sweep = Sweep::admit((0.1 + f64::from(k) / 200.0).to_bits(), k % 3 == 0, k % 2 == 0);
            let Ok(sweep) = sweep else { panic!("refused") };
            let entry = if arcs {
                PathEntry::arc(Plane::Xy, [x * 200, y * 7], sweep, along)
            } else {
                PathEntry::line([x * 307, y * 5, -x * 211, y * 11], along)
            };
            STORES[0].write(k, entry);
        }
        begin = run(&mut path, if arcs { "path-arc" } else { "path-line" }, begin, reading);
        path.clear(0);
    }
    let feed = FifoEnds { ends: [MOTIONS, 0] };
    for k in 0..20u64 {
        path.position([Pos(0); 4]);
        path.start(begin, 0, feed, &STORES);
        for _ in 0..4 + k {
            step(&mut path, begin, feed);
            begin.0 += PERIOD.0;
        }
        let (periods, ()) = count(stop, &mut path, begin, feed);
        hprintln!("1 path-stop {}", periods.saturating_sub(reading));
    }
    probes::exit()
}
