//! Look-ahead against limits.
//!
//! Paths run through servo's own evaluator; limits are checked on its output.
//! `host-tests/tests/look_ahead.rs` compares the time of long ones with an optimum.

mod goes_on;
mod rounding;
mod steps;

use crate::chance;
use chance::Chance;
use dispatcher::plan::geometry::{Geometry, Position};
use dispatcher::plan::look_ahead::{Limits, LookAhead, Planned};
use servo::path::{Effects, EntryEffect, FifoEnds, MotionSpeeds, Path, PathEntries, PathEntry, PathStop, Plane};
use servo::segment::piece::Scaled;
use servo::units::{Axis, FineNs, Ns, Pos};
use std::collections::VecDeque;

pub struct Script(pub Vec<PathEntry>);

impl PathEntries for Script {
    fn entry(&self, _: u8, counter: u32) -> PathEntry {
        self.0[counter as usize]
    }
}

#[derive(Default)]
pub struct Heard {
    pub rests: Vec<(FineNs, PathStop)>,
    pub marks: Vec<FineNs>,
}

impl Effects for Heard {
    fn change(&mut self, at: FineNs, _: &EntryEffect) -> FineNs {
        self.marks.push(at);
        0
    }
    fn standstill(&mut self, at: FineNs, rest: PathStop) {
        self.rests.push((at, rest));
    }
    fn gear(&mut self, _: Axis, _: Pos, _: Scaled) {}
    fn geared(&mut self, _: u128, _: Axis, _: i32) {}
}

/// A look-ahead with the entries that wait, which a queue has in the store of its FIFO.
pub struct Ahead<const N: usize> {
    look: Box<LookAhead<N, N>>,
    waiting: VecDeque<PathEntry>,
    others: u16,
}

/// An entry that has left it, and its time without override, ms.
#[derive(Clone, Copy)]
pub struct Taken {
    pub entry: PathEntry,
    pub ms: f64,
}

impl<const N: usize> Ahead<N> {
    pub fn new(limits: Limits) -> Ahead<N> {
        Ahead { look: Box::new(LookAhead::new(limits)), waiting: VecDeque::new(), others: 0 }
    }

    pub fn push_motion(&mut self, geometry: &Geometry, vel: f64, acc: f64) -> bool {
        let fits = self.look.push_motion(geometry, vel, acc);
        if fits {
            self.waiting.push_back(geometry.entry(MotionSpeeds::NONE).unwrap());
        }
        fits
    }

    pub fn push_other(&mut self, entry: PathEntry) {
        self.look.push_other(&entry);
        self.waiting.push_back(entry);
    }

    pub fn take(&mut self, now: bool) -> Option<Taken> {
        if self.others > 0 {
            self.others -= 1;
            return self.waiting.pop_front().map(|entry| Taken { entry, ms: 0.0 });
        }
        let Planned { along, ms, entries_after } = self.look.take(now)?;
        self.others = entries_after;
        self.waiting.pop_front().map(|entry| Taken { entry: entry.with_speeds(along), ms })
    }

    pub fn is_full(&self) -> bool {
        self.look.is_full()
    }

    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }
}

/// A call: its path geometry, speed and acceleration.
#[derive(Clone, Copy)]
pub struct Call {
    pub geometry: Geometry,
    pub vel: f64,
    pub acc: f64,
}

/// Lines through these points.
pub fn polyline(points: &[[i32; 2]], vel: f64, acc: f64) -> Vec<Call> {
    let mut from: Position = [0.0; 4];
    let mut calls = Vec::new();
    for point in points {
        if let Ok(geometry) = Geometry::planar(&from, *point) {
            from = geometry.end;
            calls.push(Call { geometry, vel, acc });
        }
    }
    calls
}

/// A spiral of chords of about 100 pulses, from the middle out.
pub fn spiral() -> Vec<Call> {
    let mut points = Vec::new();
    let mut angle = 0.0f64;
    for _ in 0..6000 {
        let radius = 300.0 + 400.0 * angle / std::f64::consts::TAU;
        points.push([(radius * angle.cos() - 300.0).round() as i32, (radius * angle.sin()).round() as i32]);
        angle += 100.0 / radius;
    }
    polyline(&points, 200.0, 2.0)
}

/// 10,000 moves of 100 pulses (0.1 mm) whose direction wanders, now and then with a corner.
pub fn wander(corners: bool) -> Vec<Call> {
    let mut chance = Chance::new(11);
    let (mut x, mut y, mut angle, mut bend) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let mut points = Vec::new();
    for i in 0..10_000 {
        bend = 0.97 * bend + 0.004 * (chance.unit() - 0.5);
        angle += bend;
        if corners && i % 500 == 499 {
            angle += 2.0 * (chance.unit() - 0.5) * std::f64::consts::PI;
        }
        x += 100.0 * angle.cos();
        y += 100.0 * angle.sin();
        points.push([x.round() as i32, y.round() as i32]);
    }
    polyline(&points, 150.0, 3.0)
}

pub const LIMITS: Limits = Limits { vel: [120.0, 100.0, 50.0, 50.0], acc: [1.5, 1.0, 0.5, 0.5], corner: 5.0 };

/// All entries, taken as they become final; and how many had to wait for the end.
fn plan<const N: usize>(calls: &[Call]) -> Vec<PathEntry> {
    plan_within::<N>(calls, LIMITS)
}

pub fn plan_within<const N: usize>(calls: &[Call], limits: Limits) -> Vec<PathEntry> {
    let mut ahead = Ahead::<N>::new(limits);
    let mut entries = Vec::new();
    for call in calls {
        while !ahead.push_motion(&call.geometry, call.vel, call.acc) {
            entries.push(ahead.take(true).unwrap().entry);
        }
        while let Some(planned) = ahead.take(false) {
            entries.push(planned.entry);
        }
    }
    while let Some(planned) = ahead.take(true) {
        entries.push(planned.entry);
    }
    assert!(ahead.is_empty());
    entries
}

/// The middle of a motion.
pub struct Middle {
    /// ms.
    pub at: f64,
    /// Of X and Y, pulse/ms.
    pub velocity: [f64; 2],
    pub length: f64,
    /// The highest speed since the middle before.
    pub fastest: f64,
}

/// Runs entries. Returns the middles of the motions, the highest velocities as shares of their
/// limits, and the end in ms.
fn run(calls: &[Call], entries: &[PathEntry]) -> (Vec<Middle>, f64, f64) {
    run_with(calls, entries, |_, _, _, _| {})
}

/// The same; `meanwhile` may act on the path before each tick.
pub fn run_with(
    calls: &[Call],
    entries: &[PathEntry],
    mut meanwhile: impl FnMut(&mut Path, Ns, FifoEnds, &Script),
) -> (Vec<Middle>, f64, f64) {
    let with_marks: Vec<PathEntry> = entries.iter().flat_map(|e| [*e, PathEntry::laser(0, 0, [0; 6])]).collect();
    let script = Script(with_marks);
    let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
    let (mut path, mut heard, mut now) = (Box::new(Path::IDLE), Heard::default(), 1_000_000u64);
    path.start(Ns(now), 0, feed, &script);
    let mut places = Vec::new();
    loop {
        meanwhile(&mut path, Ns(now), feed, &script);
        let step = path.step(Ns(now), Ns(TICK_NS as u64), feed, &script, &mut heard);
        places.push([step.position[0], step.position[1]].map(|x| x.0 as f64 * 2f64.powi(-22)));
        if !step.runs {
            break;
        }
        now += TICK_NS as u64;
    }
    let [(at, PathStop::Completed)] = heard.rests[..] else { panic!("{:?}", heard.rests) };
    let ns = |at: FineNs| at as f64 / 2f64.powi(32) - 1e6;
    let mut fastest = 0.0f64;
    let velocity = |k: usize, i: usize| (places[k + 1][i] - places[k][i]) / TICK_NS * 1e6;
    for k in 0..places.len() - 1 {
        for i in 0..2 {
            fastest = fastest.max(velocity(k, i).abs() / LIMITS.vel[i]);
        }
    }
    let mut middles = vec![Middle { at: 0.0, velocity: [0.0; 2], length: 1.0, fastest: 0.0 }];
    let mut passed = 0;
    let mut before = 0.0;
    let mut from = [0.0; 2];
    for (call, at) in calls.iter().zip(&heard.marks) {
        let to = [call.geometry.end[0], call.geometry.end[1]];
        // Ticks within the motion; the speed between two of them is that at half time.
        let (first, last) = ((before / TICK_NS).ceil() as usize, (ns(*at) / TICK_NS) as usize);
        let distance_to = |k: usize| (places[k][0] - from[0]).hypot(places[k][1] - from[1]);
        let half = call.geometry.length / 2.0;
        let k = first + (first..last).take_while(|k| distance_to(*k) < half).count();
        if k >= first + 2 && k + 2 <= last {
            let part = (half - distance_to(k - 1)) / (distance_to(k) - distance_to(k - 1));
            let (low, part) = if part < 0.5 { (k - 2, part + 0.5) } else { (k - 1, part - 0.5) };
            let speed = |i: usize| velocity(low, i) * (1.0 - part) + velocity(low + 1, i) * part;
            let fastest = (passed..k).map(|k| velocity(k, 0).hypot(velocity(k, 1))).fold(0.0, f64::max);
            let (at, length) = ((low as f64 + 0.5 + part) * TICK_NS / 1e6, call.geometry.length);
            middles.push(Middle { at, velocity: [speed(0), speed(1)], length, fastest });
            passed = k;
        }
        (before, from) = (ns(*at), to);
    }
    (middles, fastest, ns(at) / 1e6)
}

/// Positions at every tick.
pub fn positions(entries: Vec<PathEntry>) -> Vec<[f64; 2]> {
    let script = Script(entries);
    let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
    let (mut path, mut heard, mut now) = (Box::new(Path::IDLE), Heard::default(), 1_000_000u64);
    path.start(Ns(now), 0, feed, &script);
    let mut positions = Vec::new();
    loop {
        let step = path.step(Ns(now), Ns(TICK_NS as u64), feed, &script, &mut heard);
        positions.push([step.position[0], step.position[1]].map(|x| x.0 as f64 * 2f64.powi(-22)));
        if !step.runs {
            return positions;
        }
        now += TICK_NS as u64;
    }
}

/// Nanoseconds.
pub const TICK_NS: f64 = 20_000.0;

/// The highest acceleration between the middles of two motions, of neighbours and of those the
/// corner time or more apart. What the rounding of targets explains is left out: half a pulse at
/// each end of both motions.
fn hardest(middles: &[Middle]) -> [f64; 2] {
    [0.0, LIMITS.corner].map(|apart| {
        let mut worst = 0.0f64;
        for (k, one) in middles.iter().enumerate() {
            if let Some(two) = middles[k + 1..].iter().find(|two| two.at - one.at >= apart) {
                let rounded = two.fastest * (1.0 / one.length + 1.0 / two.length);
                for i in 0..2 {
                    let change = (two.velocity[i] - one.velocity[i]).abs() - rounded;
                    worst = worst.max(change / (two.at - one.at) / LIMITS.acc[i]);
                }
            }
        }
        worst
    })
}

#[test]
fn a_spiral_and_a_polyline_keep_their_limits() {
    for (name, calls) in [("spiral", spiral()), ("wander", wander(false)), ("corners", wander(true))] {
        let entries = plan::<256>(&calls);
        assert_eq!(entries.len(), calls.len());
        let (middles, vel, time) = run(&calls, &entries);
        let [acc, apart] = hardest(&middles);
        println!("{name}: {time:.1} ms; velocity {vel:.4}, acceleration {acc:.4}, {apart:.4} over the corner time");
        assert!(vel <= 1.0 + 1e-6, "{name}: velocity {vel}");
        assert!(acc <= 1.0 && apart <= 1.0, "{name}: acceleration {acc} {apart}");
        assert!(acc > 0.9, "{name}: nothing was asked of it");
    }
}

/// More data only raises speeds, and final entries stay: a short queue gives the same entries,
/// until it is too short to brake in.
#[test]
fn what_is_handed_over_is_final() {
    let calls = wander(true);
    let whole = plan::<2048>(&calls);
    assert!(plan::<256>(&calls) == whole);
    let short = plan::<16>(&calls);
    assert!(short != whole);
    let (middles, vel, time) = run(&calls, &short);
    let [acc, _] = hardest(&middles);
    assert!(acc <= 1.0 && vel <= 1.0 + 1e-6, "{acc} {vel}");
    assert!(time > 1.1 * run(&calls, &whole).2, "sixteen motions are too few at this speed");
}

/// Sizes that a board has to find room for.
#[test]
fn sizes() {
    assert!(size_of::<LookAhead<256, 0>>() <= 40 << 10, "{}", size_of::<LookAhead<256, 0>>());
    // It holds the next motion, with its plan and first piece, beside the running one.
    assert!(size_of::<Path>() <= 3 << 10, "{}", size_of::<Path>());
    assert_eq!(size_of::<PathEntry>(), 32);
}

/// The corner of a long L, by hand: Δ = 1 in X and in Y, so v = acc·T of the slower one; a reversal
/// stops.
#[test]
fn corners_of_long_lines_are_taken_at_the_change_of_speed_that_the_corner_time_allows() {
    let corner = polyline(&[[100_000, 0], [100_000, 100_000], [100_000, 0]], 60.0, 0.8);
    let mut ahead = Ahead::<16>::new(LIMITS);
    for call in &corner {
        assert!(ahead.push_motion(&call.geometry, call.vel, call.acc));
    }
    let first = ahead.take(false).unwrap();
    let second = ahead.take(true).unwrap();
    let third = ahead.take(true).unwrap();
    assert!(ahead.take(true).is_none());
    let entries = [first, second, third].map(|p| p.entry);
    let (_, vel, time) = run(&corner, &entries);
    assert!(vel <= 1.0);
    // 1.0 pulse/ms² · 5 ms; 60 pulse/ms on all lines, 0.8 pulse/ms² but for the part that the
    // corner uses.
    let planned = first.ms + second.ms + third.ms;
    assert!((planned - time).abs() < 1e-6 * time, "{planned} {time}");
    let ideal = |a: f64, b: f64, acc: f64| {
        let ramps = (2.0 * 60.0 * 60.0 - a * a - b * b) / 2.0 / acc;
        (120.0 - a - b) / acc + (100_000.0 - ramps) / 60.0
    };
    let reversal = 1.0 * 5.0 / 2.0;
    let expected = ideal(0.0, 5.0, 0.8) + ideal(5.0, reversal, 0.8) + ideal(reversal, 0.0, 0.8);
    assert!((time - expected).abs() < 0.01 * expected, "{time} {expected}");
    assert!(time > expected * (1.0 - 1e-6));
}

/// Waits and effects keep their order. A wait stops the path; effects do not, unless more than 32
/// stand together.
#[test]
fn what_stands_between_motions_keeps_its_position() {
    let line = |x: i32, from: i32| Geometry::planar(&[from as f64, 0.0, 0.0, 0.0], [x, 0]).unwrap();
    let mark = |code| PathEntry::laser(0, code, [0; 6]);
    let time = |others: &[PathEntry]| {
        let mut ahead = Ahead::<64>::new(LIMITS);
        assert!(ahead.push_motion(&line(1000, 0), 50.0, 1.0));
        for other in others {
            ahead.push_other(*other);
        }
        assert!(ahead.push_motion(&line(2000, 1000), 50.0, 1.0));
        let (mut entries, mut ms) = (Vec::new(), 0.0);
        while let Some(planned) = ahead.take(true) {
            entries.push(planned.entry);
            ms += planned.ms;
        }
        assert_eq!(entries[1..entries.len() - 1], *others);
        let script = Script(entries);
        let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
        let (mut path, mut heard, mut now) = (Box::new(Path::IDLE), Heard::default(), 1_000_000);
        path.start(Ns(now), 0, feed, &script);
        while path.step(Ns(now), Ns(250_000), feed, &script, &mut heard).runs {
            now += 250_000;
        }
        let time = (heard.rests[0].0 as f64 / 2f64.powi(32) - 1e6) / 1e6;
        // But for waits, and for a thirty-third effect, which waits for the next tick.
        assert!(time - ms > -1e-6 && time - ms < 7.01, "{ms} planned, {time} taken");
        (time, time - ms)
    };
    let through = 2.0 * (2000.0f64 / 1.0).sqrt();
    let halts = 4.0 * (1000.0f64 / 1.0).sqrt();
    let near = |a: f64, b: f64| (a - b).abs() < 0.01 * b;
    let (plain, late) = time(&[]);
    assert!(near(plain, through) && late < 1e-6, "{plain} {late}");
    assert!(time(&[mark(1); 32]) == (plain, late));
    let (more, late) = time(&[mark(1); 33]);
    assert!(more > halts && late < 0.251, "{more} {late}");
    let (wait, late) = time(&[mark(1), PathEntry::delay(7), mark(2)]);
    assert!(near(wait, halts + 7.0) && (late - 7.0).abs() < 1e-6, "{wait} {late}");
}

/// An entry that was handed over relies on a stop at the end of the next motion. A sharp corner
/// found there later may not make that motion brake harder: then it stops, as planned.
#[test]
fn a_corner_that_comes_late_does_not_brake_harder() {
    let calls = polyline(&[[10_000, 0], [10_100, 0], [10_100, -100], [10_200, -100]], 100.0, 3.0);
    let mut ahead = Ahead::<4>::new(LIMITS);
    let mut entries = Vec::new();
    for call in &calls[..2] {
        assert!(ahead.push_motion(&call.geometry, call.vel, call.acc));
    }
    entries.push(ahead.take(true).unwrap().entry);
    for call in &calls[2..] {
        assert!(ahead.push_motion(&call.geometry, call.vel, call.acc));
    }
    while let Some(planned) = ahead.take(true) {
        entries.push(planned.entry);
    }
    let script = Script(entries);
    let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
    let (mut path, mut heard, mut now) = (Box::new(Path::IDLE), Heard::default(), 1_000_000);
    path.start(Ns(now), 0, feed, &script);
    let mut hardest = 0.0f64;
    loop {
        let step = path.step(Ns(now), Ns(50_000), feed, &script, &mut heard);
        if !step.runs {
            break;
        }
        now += 50_000;
        if step.done < 2 {
            let a = step.motion.acceleration();
            hardest = hardest.max((a.m as f64 * 2f64.powi(-a.e as i32)).abs() / LIMITS.acc[0]);
        }
    }
    assert!(hardest <= 1.0 && hardest > 0.99, "{hardest}");
}

/// Full circles and arcs one after another: |a| along them and v²/R together stay below the lower
/// limit of their plane.
#[test]
fn arcs_keep_the_acceleration_of_their_plane() {
    let mut calls = Vec::new();
    let mut from: Position = [0.0; 4];
    for (to, radius, ccw) in [([2000, 0], 1000.0, true), ([4000, 0], 1000.0, false), ([4600, 600], 600.0, true)] {
        let geometry = Geometry::arc_radius(&from, Plane::Xy, to, radius, ccw).unwrap();
        from = geometry.end;
        calls.push(Call { geometry, vel: 100.0, acc: 5.0 });
    }
    let geometry = Geometry::arc_centre(&from, Plane::Xy, [4600, 600], [0.0, 300.0], true).unwrap();
    calls.push(Call { geometry, vel: 100.0, acc: 5.0 });
    let entries = plan::<16>(&calls);
    let script = Script(entries);
    let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
    let (mut path, mut heard, mut now) = (Box::new(Path::IDLE), Heard::default(), 1_000_000);
    path.start(Ns(now), 0, feed, &script);
    let radii = [1000.0, 1000.0, 600.0, 300.0];
    let (mut worst, mut fastest) = (0.0f64, 0.0f64);
    loop {
        let step = path.step(Ns(now), Ns(100_000), feed, &script, &mut heard);
        if !step.runs {
            break;
        }
        now += 100_000;
        let real = |x: servo::segment::piece::Scaled| x.m as f64 * 2f64.powi(-x.e as i32);
        let (v, a) = (real(step.motion.velocity()), real(step.motion.acceleration()));
        worst = worst.max((v * v / radii[step.done as usize]).hypot(a));
        fastest = fastest.max(v);
    }
    assert!(worst <= 1.0 && worst > 0.95, "{worst}");
    assert!(fastest > 0.85 * 1000f64.sqrt(), "{fastest}");
}

/// A host that stalls for 50 ms now and then: the controller's FIFO and the queue bridge it. If
/// data stays away, the rest is handed over in time, and the path ends at standstill.
#[test]
fn stalls_of_the_host_do_not_slow_it_down() {
    let calls = wander(false);
    let calls = &calls[..3000];
    let time = |stall: bool, end: usize| {
        let mut ahead = Ahead::<256>::new(LIMITS);
        let (mut path, mut heard) = (Box::new(Path::IDLE), Heard::default());
        let mut script = Script(Vec::new());
        let (mut came, mut planned, mut begun) = (0, vec![], None);
        let mut now = 1_000_000u64;
        loop {
            let ms = (now - 1_000_000) / 1_000_000;
            // 10 motions a ms while the host does not stall; none without a slot in the queue.
            if !(stall && ms % 300 >= 250) {
                for _ in 0..10 {
                    if came < end && ahead.push_motion(&calls[came].geometry, calls[came].vel, calls[came].acc) {
                        came += 1;
                    }
                }
            }
            // Entries to the FIFO of 1024, as they become final; all of them if it lasts less than
            // 30 ms.
            loop {
                let done = path.released(0) as usize;
                let lasts: f64 = planned[done.min(planned.len())..].iter().sum();
                if script.0.len() - done >= 1024 {
                    break;
                }
                let Some(next) = ahead.take(ahead.is_full() || begun.is_some() && lasts < 30.0) else { break };
                script.0.push(next.entry);
                planned.push(next.ms);
            }
            let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
            if begun.is_none() && script.0.len() >= 200 {
                begun = Some(now);
                path.start(Ns(now), 0, feed, &script);
            }
            let step = path.step(Ns(now), Ns(1_000_000), feed, &script, &mut heard);
            if begun.is_some() && !step.runs {
                break;
            }
            now += 1_000_000;
        }
        assert_eq!(path.done(0) as usize, end);
        let [(at, PathStop::Completed)] = heard.rests[..] else { panic!("{:?}", heard.rests) };
        at as f64 / 2f64.powi(32) - begun.unwrap() as f64
    };
    let steady = time(false, calls.len());
    assert_eq!(time(true, calls.len()), steady);
    // 1000 motions, and then nothing: Completed, not an underrun.
    assert!(time(false, 1000) < steady);
}
