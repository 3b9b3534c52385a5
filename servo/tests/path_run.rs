//! What a path does besides motion: Stops, FIFOs, waits, effects, data that comes late, overrides.
//! Expected figures are closed forms: v²/2a for a braking distance, v/a for its time.
use crate::{chance, paths};
#[path = "path_run/stop.rs"]
mod stop;
use servo::path::{Effects, EntryEffect, FeedOverride, FifoEnds, MotionSpeeds, Path, PathEntry, PathStop, Refused};
use servo::segment::piece::{Motion, Scaled};
use servo::segment::ramp::Accel;
use servo::test_hooks::Step;
use servo::tick_command::DoGroup;
use servo::units::{Axis, FineNs, Ns, Pos, StepLimit};

use chance::Chance;
use paths::{Heard, Script, mark, since, speeds};

const BEGIN_NS: u64 = 1_000_000;

fn speed(motion: &Motion) -> f64 {
    let v = motion.velocity();
    v.m as f64 * 2f64.powi(-v.e as i32)
}
fn pulses(x: Pos) -> f64 {
    x.0 as f64 * 2f64.powi(-22)
}
fn dec(a: f64) -> Accel {
    Accel::admit(a.to_bits()).unwrap()
}

/// A path with its entries and its reports; time goes on tick by tick.
struct Bench {
    path: Path,
    script: Script,
    feed: FifoEnds,
    now: u64,
    period: u64,
    heard: Heard,
}

impl Bench {
    fn new(entries: Vec<PathEntry>, period: u64) -> Bench {
        let feed = FifoEnds { ends: [entries.len() as u32, 0] };
        Bench { path: Path::IDLE, script: Script(entries), feed, now: BEGIN_NS, period, heard: Heard::default() }
    }
    fn start(&mut self, fifo: u8) {
        assert!(!self.path.refuses_start(fifo, self.feed));
        self.path.start(Ns(self.now), fifo, self.feed, &self.script);
    }
    fn stop(&mut self, abrupt: bool) {
        self.path.stop(Ns(self.now), abrupt, self.feed, &self.script, &mut self.heard);
    }
    fn tick(&mut self) -> Step {
        let step = self.path.step(Ns(self.now), Ns(self.period), self.feed, &self.script, &mut self.heard);
        self.now += self.period;
        step
    }
    fn until(&mut self, ns: u64) -> Step {
        let mut step = self.tick();
        while self.now - BEGIN_NS < ns {
            step = self.tick();
        }
        step
    }
    fn finish(&mut self) -> Step {
        loop {
            let step = self.tick();
            if !step.runs {
                return step;
            }
        }
    }
    /// Instants of marks in ms after the start, and their codes.
    fn marks(&self) -> Vec<(f64, u8)> {
        self.heard.marks.iter().map(|(at, code)| (since(*at) / 1e6, *code)).collect()
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + b.abs())
}

/// GUS 4.2: the corner at 2025 ms to the bit; the second line is 100498.756 pulses long.
#[test]
fn the_listing_of_the_manual_changes_power_at_the_corner() {
    for period in [10_000, 250_000, 1_000_000] {
        let s = speeds(50.0, 2.0, 0.0);
        let entries =
            vec![mark(1), PathEntry::planar([100_000, 0], s), mark(2), PathEntry::planar([0, 10_000], s), mark(3)];
        let mut bench = Bench::new(entries, period);
        bench.start(0);
        let middle = bench.until(1_000_000_000);
        assert!(near(speed(&middle.motion), 50.0) && middle.done == 0 && middle.runs);
        let last = bench.finish();
        assert_eq!(
            (last.position, last.done, last.motion),
            ([0, 10_000, 0, 0].map(Pos::pulses), 2, Motion::STANDSTILL)
        );
        let [first, corner, end] = &bench.heard.marks[..] else { panic!() };
        assert_eq!((first.0, corner.0), ((BEGIN_NS as FineNs) << 32, ((BEGIN_NS + 2_025_000_000) as FineNs) << 32));
        assert!(near(since(end.0) / 1e6, 2025.0 + (1e10f64 + 1e8).sqrt() / 50.0 + 25.0));
        assert_eq!(bench.heard.rests, [(end.0, PathStop::Completed)]);
    }
}

/// A step publishes its own tick; its reports lie in the interval after it.
#[test]
fn effects_are_reported_for_the_coming_interval_only() {
    let mut bench = Bench::new(vec![PathEntry::planar([1000, 0], speeds(10.0, 1.0, 0.0)), mark(1)], 300_000);
    bench.start(0);
    let end = (BEGIN_NS + 110_000_000) as FineNs;
    loop {
        let (reported, tick) = (bench.heard.marks.len(), bench.now as FineNs);
        let step = bench.tick();
        if bench.heard.marks.len() > reported {
            assert!(tick <= end && end < tick + 300_000);
            assert!(step.runs, "at its own tick it still runs");
            break;
        }
    }
    assert_eq!(bench.heard.marks[0].0, end << 32);
    assert!(!bench.tick().runs);
}

#[test]
fn speed_goes_through_a_corner_and_to_zero_where_nothing_or_a_wait_follows() {
    let fast = speeds(10.0, 1.0, 10.0);
    let entries = vec![
        PathEntry::planar([1000, 0], fast),
        mark(1),
        PathEntry::planar([1000, 1000], fast),
        mark(2),
        PathEntry::delay(5),
        mark(3),
        PathEntry::planar([0, 1000], fast),
        mark(4),
    ];
    let mut bench = Bench::new(entries, 100_000);
    bench.start(0);
    bench.finish();
    // 50 pulses to 10 pulse/ms in 10 ms; 1000 pulses in 105 ms, another in 105 ms, rest, 5 ms, 110
    // ms.
    let times = [105.0, 210.0, 215.0, 325.0];
    for ((at, code), (i, expected)) in bench.marks().iter().zip(times.iter().enumerate()) {
        assert!(*code as usize == i + 1 && near(*at, *expected), "{at} {expected}");
    }
    assert_eq!(bench.heard.rests[0].1, PathStop::Completed);
}

/// A motion too short to brake before a wait: after the start that goes on, the motion after the
/// wait begins at rest, however long there is to make it ahead.
#[test]
fn a_motion_after_a_wait_begins_at_rest() {
    let fast = speeds(10.0, 1.0, 10.0);
    let entries = vec![
        PathEntry::planar([1000, 0], fast),
        PathEntry::planar([1010, 0], fast),
        PathEntry::delay(50),
        mark(1),
        PathEntry::planar([1510, 0], speeds(10.0, 1.0, 0.0)),
        mark(2),
    ];
    let mut bench = Bench::new(entries, 100_000);
    bench.start(0);
    bench.finish();
    bench.start(0);
    bench.finish();
    let [(begin, 1), (end, 2)] = bench.marks()[..] else { panic!() };
    // 500 pulses: 10 ms to 10 pulse/ms, 40 ms, 10 ms.
    assert!(near(end - begin, 60.0), "{begin} {end}");
}

#[test]
fn a_path_too_short_to_brake_ends_in_an_underrun_on_its_target() {
    let entries = vec![
        PathEntry::planar([1000, 0], speeds(10.0, 1.0, 10.0)),
        PathEntry::planar([1010, 0], speeds(10.0, 1.0, 0.0)),
        mark(1),
    ];
    let mut bench = Bench::new(entries, 100_000);
    bench.start(0);
    let last = bench.finish();
    assert_eq!((last.position[0], bench.heard.rests[0].1), (Pos::pulses(1010), PathStop::Underrun));
    // From 10 pulse/ms over 10 pulses at 1 pulse/ms²: sqrt(80), 10 − sqrt(80) ms.
    assert!(near(bench.marks()[0].0, 105.0 + 10.0 - 80f64.sqrt()));
    assert!(!bench.path.runs() && bench.path.refuses_start(0, bench.feed));
}

/// A wait that the path reaches at speed, because what is before it is too short to brake in: the
/// path stops there, in front of it, and says so. A start goes on with the wait.
#[test]
fn a_wait_that_is_reached_at_speed_is_an_underrun() {
    let speed = (10f64.to_bits(), StepLimit::FULL_SCALE);
    let travel = PathEntry::travel(Axis::FIRST, 100, speed, 1f64.to_bits(), true).unwrap();
    for (wait, ms) in [(PathEntry::delay(5), 5.0), (PathEntry::delay(0), 0.0), (travel, 3.0)] {
        let entries = vec![
            PathEntry::planar([1000, 0], speeds(10.0, 1.0, 10.0)),
            PathEntry::planar([1010, 0], speeds(10.0, 1.0, 10.0)),
            mark(1),
            wait,
            PathEntry::planar([1110, 0], speeds(10.0, 1.0, 0.0)),
            mark(2),
        ];
        let mut bench = Bench::new(entries, 100_000);
        bench.start(0);
        let last = bench.finish();
        // From 10 pulse/ms over 10 pulses at 1 pulse/ms²: sqrt(80), 10 − sqrt(80) ms.
        let end = 105.0 + 10.0 - 80f64.sqrt();
        let [(at, rest)] = bench.heard.rests[..] else { panic!("{:?}", bench.heard.rests) };
        assert_eq!((last.position[0], rest, last.done), (Pos::pulses(1010), PathStop::Underrun, 2), "{wait:?}");
        assert!(near(since(at) / 1e6, end) && near(bench.marks()[0].0, end), "{:?}", bench.marks());
        assert_eq!((bench.marks().len(), bench.path.released(0)), (1, 3));
        let again = (bench.now - BEGIN_NS) as f64 / 1e6;
        bench.start(0);
        bench.finish();
        assert_eq!(bench.heard.rests[1].1, PathStop::Completed);
        assert!(near(bench.marks()[1].0, again + ms + 20.0), "{again} {:?}", bench.marks());
    }
}

/// A planner's speeds are rounded: a motion that misses standstill by less than 2⁻¹⁶ pulse counts
/// as stopped.
#[test]
fn an_end_that_only_rounding_keeps_from_rest_is_no_underrun() {
    let ideal = 140f64.sqrt();
    for (vel, rest) in [
        (ideal.next_up(), PathStop::Completed),
        (ideal + 5e-7, PathStop::Completed),
        (ideal + 1e-5, PathStop::Underrun),
    ] {
        for last in [vec![], vec![PathEntry::delay(1)]] {
            let entries = [
                PathEntry::planar([1000, 0], speeds(20.0, 0.7, vel)),
                PathEntry::planar([1100, 0], speeds(20.0, 0.7, 0.0)),
            ];
            let mut bench = Bench::new([&entries[..], &last].concat(), 100_000);
            bench.start(0);
            bench.finish();
            assert_eq!(bench.heard.rests[0].1, rest, "{vel} {last:?}");
        }
    }
}

/// Data that comes before braking must begin changes nothing; data that comes later speeds it up
/// again.
#[test]
fn data_that_comes_while_it_runs_is_taken_up() {
    let s = speeds(10.0, 1.0, 10.0);
    let lines: Vec<_> = (1..=20).map(|i| PathEntry::planar([100 * i, 0], s)).chain([mark(1)]).collect();
    let mut whole = Bench::new(lines.clone(), 250_000);
    whole.start(0);
    whole.finish();
    let mut bench = Bench::new(lines.clone(), 250_000);
    bench.feed.ends[0] = 3;
    bench.start(0);
    while bench.path.runs() {
        let done = bench.tick().done;
        // Always a line and what it takes to brake ahead.
        bench.feed.ends[0] = (done + 3).min(21);
    }
    assert!(near(bench.marks()[0].0, whole.marks()[0].0) && near(whole.marks()[0].0, 210.0));
    // The second half comes while it brakes for the end of the first: 10 → 4 pulse/ms.
    let mut bench = Bench::new(lines, 250_000);
    bench.feed.ends[0] = 10;
    bench.start(0);
    // 1000 pulses end at 110 ms; at 104 ms it goes 6 pulse/ms and has 18 to go.
    let step = bench.until(104_250_000);
    assert!(near(speed(&step.motion), 6.0), "{}", speed(&step.motion));
    bench.feed.ends[0] = 21;
    bench.finish();
    // The new end is found a tick later, at 5.75 pulse/ms: back to 10 in 4.25 ms and 33.46875
    // pulses.
    let left = 2000.0 - (1000.0 - 5.75 * 5.75 / 2.0) - (100.0 - 5.75 * 5.75) / 2.0 - 50.0;
    let expected = 104.25 + 4.25 + left / 10.0 + 10.0;
    assert!(near(bench.marks()[0].0, expected), "{} {expected}", bench.marks()[0].0);
}

/// Data that comes during the motion before counts for the next one, though that was planned to
/// stop.
#[test]
fn data_that_comes_before_a_motion_is_entered_is_taken_up() {
    let s = speeds(10.0, 1.0, 10.0);
    let lines: Vec<_> = (1..=10).map(|i| PathEntry::planar([200 * i, 0], s)).chain([mark(1)]).collect();
    let mut bench = Bench::new(lines, 250_000);
    bench.feed.ends[0] = 2;
    bench.start(0);
    let mut done = 0;
    while bench.path.runs() {
        let step = bench.tick();
        // One more, ten ticks after a motion has begun: before it the next one ends the path.
        if step.done == done && step.position[0].0 > Pos::pulses(200 * done as i32 + 50).0 {
            done += 1;
            bench.feed.ends[0] = (done + 2).min(11);
        }
    }
    // 2000 pulses at 10 pulse/ms, 10 ms more for both ramps.
    assert!(near(bench.marks()[0].0, 210.0), "{:?}", bench.marks());
}

/// FIFO 1 interrupts FIFO 0 between pulses and comes back to exactly that position.
#[test]
fn fifo_1_interrupts_fifo_0_and_returns() {
    struct Two(Vec<PathEntry>, Vec<PathEntry>);
    impl servo::path::PathEntries for Two {
        fn entry(&self, fifo: u8, counter: u32) -> PathEntry {
            if fifo == 0 { self.0[counter as usize] } else { self.1[counter as usize] }
        }
    }
    let s = speeds(10.0, 1.0, 0.0);
    let mut source = Two(vec![PathEntry::planar([1000, 300], s), mark(1)], vec![]);
    let mut feed = FifoEnds { ends: [2, 0] };
    let (mut path, mut heard, mut now) = (Path::IDLE, Heard::default(), BEGIN_NS);
    let mut tick = |path: &mut Path, source: &Two, feed: FifoEnds, heard: &mut Heard| {
        now += 250_000;
        (path.step(Ns(now), Ns(250_000), feed, source, heard), now + 250_000)
    };
    path.start(Ns(BEGIN_NS + 250_000), 0, feed, &source);
    let mut next = 0;
    for _ in 0..100 {
        next = tick(&mut path, &source, feed, &mut heard).1;
    }
    path.stop(Ns(next), false, feed, &source, &mut heard);
    let left = loop {
        let (step, _) = tick(&mut path, &source, feed, &mut heard);
        if !step.runs {
            break step.position;
        }
    };
    let whole = left.map(|x| servo::output::step_generator::whole(x) as i32);
    assert_ne!(left, whole.map(Pos::pulses), "it stands between pulses");
    // Away in FIFO 1: FIFO 0 cannot go on from there.
    source.1 = vec![PathEntry::planar([0, 0], s), mark(2)];
    feed.ends[1] = 2;
    assert!(!path.refuses_start(1, feed));
    path.start(Ns(next + 100 * 250_000), 1, feed, &source);
    for _ in 0..800 {
        next = tick(&mut path, &source, feed, &mut heard).1;
    }
    assert!(!path.runs() && path.refuses_start(0, feed) && path.refuses_start(1, feed));
    // Back: a line to the nearest pulse ends between pulses, at exactly that position.
    source.1.push(PathEntry::line(whole, s));
    feed.ends[1] = 3;
    path.start(Ns(next), 1, feed, &source);
    let back = loop {
        let (step, after) = tick(&mut path, &source, feed, &mut heard);
        next = after;
        if !step.runs {
            break step;
        }
    };
    assert_eq!((back.position, back.fifo, back.done), (left, 1, 2));
    assert!(!path.refuses_start(0, feed));
    path.start(Ns(next), 0, feed, &source);
    loop {
        let (step, _) = tick(&mut path, &source, feed, &mut heard);
        if !step.runs {
            assert_eq!((step.position, step.fifo, step.done), ([1000, 300, 0, 0].map(Pos::pulses), 0, 1));
            break;
        }
    }
    assert_eq!(heard.marks.iter().map(|m| m.1).collect::<Vec<_>>(), [2, 1]);
    // Cleared, it needs nothing.
    path.clear(0);
    assert_eq!((path.done(0), path.released(0)), (0, 0));
}

#[test]
fn starts_without_data_or_while_it_runs_are_refused() {
    let mut bench = Bench::new(vec![PathEntry::planar([1000, 0], speeds(10.0, 1.0, 0.0))], 250_000);
    assert!(bench.path.refuses_start(1, bench.feed));
    assert!(bench.path.refuses_start(0, FifoEnds::default()));
    bench.start(0);
    assert!(bench.path.refuses_start(0, bench.feed));
    bench.finish();
    assert!(bench.path.refuses_start(0, bench.feed), "it has run out");
}

/// 32 effects a tick; the 33rd waits for the next one, and before so many the path comes to rest.
#[test]
fn at_most_32_effects_run_in_a_tick() {
    let s = speeds(10.0, 1.0, 10.0);
    let mut entries = vec![PathEntry::planar([100, 0], s)];
    entries.extend((0..80).map(mark));
    entries.push(PathEntry::planar([200, 0], s));
    let mut bench = Bench::new(entries, 250_000);
    bench.start(0);
    bench.finish();
    // 100 pulses from rest to rest take 20 ms; that is a tick, whose step reports the boundary.
    let at: Vec<u64> = bench.marks().iter().map(|m| (m.0 * 1e6).round() as u64).collect();
    let expected: Vec<u64> = (0..80).map(|i| 20_000_000 + i / 32 * 250_000).collect();
    assert_eq!(at, expected);
    // 8, 9 and 32 are passed at speed.
    for count in [8, 9, 32] {
        let mut entries = vec![PathEntry::planar([100, 0], s)];
        entries.extend((0..count).map(mark));
        entries.push(PathEntry::planar([200, 0], s));
        let mut bench = Bench::new(entries, 250_000);
        bench.start(0);
        bench.finish();
        assert_eq!(bench.marks().len(), count as usize);
        assert!(bench.marks().iter().all(|m| near(m.0, 15.0)), "{:?}", bench.marks());
    }
}

/// At eight instants of a tick there may be effects; at the ninth the path holds until the next
/// tick, as before.
#[test]
fn effects_of_a_tick_lie_at_eight_instants_at_most() {
    let s = speeds(1000.0, 1000.0, 1000.0);
    // At 1000 pulse/ms a motion of 10 pulses takes 10 µs.
    let mut entries = vec![PathEntry::planar([1000, 0], s)];
    for k in 0..12 {
        entries.extend([mark(2 * k), mark(2 * k + 1)]);
        entries.push(PathEntry::planar([1010 + 10 * k as i32, 0], s));
    }
    entries.push(PathEntry::planar([9000, 0], s));
    let mut bench = Bench::new(entries, 250_000);
    bench.start(0);
    bench.finish();
    let mut ticks = std::collections::BTreeMap::new();
    for mark in bench.marks() {
        let at = (mark.0 * 1e6).round() as u64;
        let instants: &mut std::collections::BTreeSet<u64> = ticks.entry((at - 1) / 250_000).or_default();
        instants.insert(at);
    }
    let most = ticks.values().map(|instants| instants.len()).max().unwrap();
    assert_eq!((most, ticks.values().map(|instants| instants.len()).sum::<usize>()), (8, 12), "{ticks:?}");
}

#[test]
fn other_effects_carry_their_numbers() {
    #[derive(Default)]
    struct All(Vec<EntryEffect>);
    impl Effects for All {
        fn change(&mut self, _: FineNs, change: &EntryEffect) -> FineNs {
            self.0.push(*change);
            0
        }
        fn standstill(&mut self, _: FineNs, _: PathStop) {}
        fn gear(&mut self, _: Axis, _: Pos, _: Scaled) {}
        fn geared(&mut self, _: u128, _: Axis, _: i32) {}
    }
    let axis = Axis::new(9).unwrap();
    let (v, a) = (123.456f64, 7.89f64);
    let script = Script(vec![
        PathEntry::output(DoGroup::General, 0xfff0, 0x1230),
        PathEntry::output(DoGroup::Enable, 3, 1),
        PathEntry::analog(7, -32768),
        PathEntry::travel(axis, -5, (v.to_bits(), StepLimit::FULL_SCALE), a.to_bits(), false).unwrap(),
        PathEntry::laser(1, 77, [1, 2, 3, 4, 5, u32::MAX]),
    ]);
    let feed = FifoEnds { ends: [5, 0] };
    let (mut path, mut all) = (Path::IDLE, All::default());
    path.start(Ns(BEGIN_NS), 0, feed, &script);
    path.step(Ns(BEGIN_NS), Ns(250_000), feed, &script, &mut all);
    let (speed, acc) = (servo::segment::ramp::Speed::admit(v.to_bits(), StepLimit::FULL_SCALE).unwrap(), dec(a));
    let expected = [
        EntryEffect::Output { group: DoGroup::General, mask: 0xfff0, value: 0x1230 },
        EntryEffect::Output { group: DoGroup::Enable, mask: 3, value: 1 },
        EntryEffect::Analog { channel: 7, value: -32768 },
        EntryEffect::Move { axis, target: -5, speed, acc, modal: false },
        EntryEffect::Laser { channel: 1, code: 77, words: [1, 2, 3, 4, 5, u32::MAX] },
    ];
    assert_eq!(all.0, expected);
    assert!(PathEntry::travel(axis, 0, (v.to_bits(), StepLimit::FULL_SCALE), 0, false).is_err());
}

#[test]
fn a_modal_move_makes_the_path_wait() {
    let s = speeds(10.0, 1.0, 10.0);
    let wait =
        PathEntry::travel(Axis::new(5).unwrap(), 100, (1f64.to_bits(), StepLimit::FULL_SCALE), 1f64.to_bits(), true)
            .unwrap();
    let entries = vec![PathEntry::planar([100, 0], s), wait, mark(1), PathEntry::planar([200, 0], s), mark(2)];
    let mut bench = Bench::new(entries, 250_000);
    bench.start(0);
    bench.finish();
    // The test's host says 3 ms. Before it the path comes to rest.
    assert!(near(bench.marks()[0].0, 23.0) && near(bench.marks()[1].0, 43.0), "{:?}", bench.marks());
}

/// A geared axis has its share of the displacement, and all of it at the end.
#[test]
fn gears_go_along_with_one_motion() {
    let axis = |n| Axis::new(n).unwrap();
    let s = speeds(10.0, 1.0, 0.0);
    let entries = vec![
        PathEntry::gear(axis(4), -250),
        PathEntry::gear(axis(5), 1_000_000),
        PathEntry::planar([1000, 0], s),
        PathEntry::planar([2000, 0], s),
    ];
    let mut bench = Bench::new(entries, 250_000);
    bench.start(0);
    loop {
        bench.heard.gears.clear();
        let step = bench.tick();
        if step.done == 1 {
            assert!(bench.heard.gears.is_empty());
            break;
        }
        let travelled = pulses(step.position[0]) / 1000.0;
        let [(first, a), (second, b)] = bench.heard.gears[..] else { panic!() };
        assert_eq!((first, second), (axis(4), axis(5)));
        assert!((pulses(a) + 250.0 * travelled).abs() < 1e-6 && (pulses(b) - 1e6 * travelled).abs() < 1e-3);
        if step.position[0] > Pos::pulses(500) && bench.heard.rests.is_empty() {
            bench.stop(true);
            bench.tick();
            bench.start(0);
        }
    }
    assert_eq!(bench.heard.geared, [(axis(4), -250), (axis(5), 1_000_000)]);
    bench.finish();
    assert_eq!(bench.heard.geared.len(), 2);
}

#[test]
fn an_override_scales_speeds_and_may_change_during_motion() {
    let rate = |x: f64| FeedOverride::admit(x.to_bits());
    let entries = || vec![PathEntry::planar([1000, 0], speeds(10.0, 1.0, 0.0)), mark(1)];
    let mut bench = Bench::new(entries(), 250_000);
    bench.path.rules.set_override(rate(0.5).unwrap());
    bench.start(0);
    bench.finish();
    assert!(near(bench.marks()[0].0, 205.0));
    let mut bench = Bench::new(entries(), 250_000);
    bench.start(0);
    bench.until(20_000_000);
    bench.path.rules.set_override(rate(0.5).unwrap());
    bench.path.replan(Ns(bench.now), bench.feed, &bench.script);
    let at = (bench.now - BEGIN_NS) as f64 / 1e6;
    assert!(near(at, 20.0));
    bench.finish();
    // 150 pulses done; 37.5 in 5 ms to 5 pulse/ms, 12.5 in 5 ms at the end, 800 between.
    assert!(near(bench.marks()[0].0, 20.0 + 5.0 + 160.0 + 5.0), "{:?}", bench.marks());
    for (bad, why) in [
        (0.0, Refused::TooSmall),
        (-0.5, Refused::Negative),
        (1.0f64.next_up(), Refused::BeyondRange),
        (f64::NAN, Refused::NotFinite),
    ] {
        assert_eq!(rate(bad), Err(why));
    }
}

#[test]
fn lines_without_length_are_passed_at_speed() {
    let s = speeds(10.0, 1.0, 10.0);
    let entries = vec![
        PathEntry::planar([100, 0], s),
        PathEntry::planar([100, 0], s),
        mark(1),
        PathEntry::line([200, 0, 0, 0], s),
    ];
    let mut bench = Bench::new(entries, 250_000);
    bench.start(0);
    let last = bench.finish();
    assert!(near(bench.marks()[0].0, 15.0));
    assert_eq!(last.done, 3);
}

#[test]
fn bad_speeds_are_refused() {
    let admit = |v: f64, a: f64, e: f64| MotionSpeeds::admit(v.to_bits(), a.to_bits(), e.to_bits()).map(|_| ());
    assert_eq!(admit(50.0, 2.0, 0.0), Ok(()));
    assert_eq!(admit(32768.0, 32768.0, 32768.0), Ok(()));
    assert_eq!(admit(2f64.powi(-20), 2f64.powi(-20), 1e-300), Ok(()));
    assert_eq!(admit(0.0, 2.0, 0.0), Err(Refused::TooSmall));
    assert_eq!(admit(-0.0, 2.0, 0.0), Err(Refused::TooSmall));
    assert_eq!(admit(1.0, 2f64.powi(-20).next_down(), 0.0), Err(Refused::TooSmall));
    assert_eq!(admit(-1.0, 2.0, 0.0), Err(Refused::Negative));
    assert_eq!(admit(1.0, 2.0, -1e-9), Err(Refused::Negative));
    assert_eq!(admit(32768.0f64.next_up(), 2.0, 0.0), Err(Refused::BeyondRange));
    assert_eq!(admit(1.0, f64::INFINITY, 0.0), Err(Refused::NotFinite));
    assert_eq!(admit(1.0, 1.0, f64::NAN), Err(Refused::NotFinite));
}
