//! What a path makes ahead is the same as what it makes in its tick. Of two paths one makes nothing
//! ahead; the other takes the fast path of a coordinate system where it can. They run through
//! random motions, waits, gears and marks, data that comes late, Stops, overrides, and ticks
//! without time. Every position, speed, instant and gear is the same to the bit.
use crate::{chance, paths};
use servo::path::{Curvature, FeedOverride, FifoEnds, Path, PathEntry, PathReport, Plane, StepReport, Sweep};
use servo::segment::piece::Motion;
use servo::segment::ramp::Accel;
use servo::test_hooks::Step;
use servo::units::{Axis, Ns, Pos};

use chance::Chance;
use paths::{Heard, Script, mark, speeds};

/// A path, what it publishes, what it reported.
struct Seen {
    path: Path,
    step: Step,
    turns: u32,
    heard: Heard,
}

impl Seen {
    fn new(path: Path) -> Seen {
        let (heading, bend, motion) = ([0; 4], Curvature::STRAIGHT, Motion::STANDSTILL);
        let step = Step { position: [Pos(0); 4], heading, bend, motion, runs: false, fifo: 0, done: 0 };
        Seen { path, step, turns: 0, heard: Heard::default() }
    }

    fn tick(&mut self, now: u64, period: u64, feed: FifoEnds, script: &Script, ahead: bool) {
        let Step { position: place, heading, bend, motion, .. } = &mut self.step;
        let mut sight = PathReport { position: place, heading, bend, motion, piece_version: &mut self.turns };
        let StepReport { runs, fifo, done, .. } =
            self.path.advance(Ns(now), Ns(period), feed, script, &mut self.heard, &mut sight, ahead);
        (self.step.runs, self.step.fifo, self.step.done) = (runs, fifo, done);
    }

    /// The same by the fast path that a coordinate system takes where it can; returns the
    /// boundaries that it passed.
    fn fast_step(&mut self, now: u64, period: u64, feed: FifoEnds, script: &Script, ahead: bool) -> u32 {
        let (mut turns, next, period) = (0, Ns(now), Ns(period));
        if self.path.is_due(next) {
            turns += self.path.turn_at::<true>(feed, |_| true).is_some() as u32;
        }
        let fresh = self.path.is_fresh();
        let Step { position: place, heading, bend, motion, .. } = &mut self.step;
        let mut sight = PathReport { position: place, heading, bend, motion, piece_version: &mut self.turns };
        let Some(stepped) = self.path.fast_step(next, feed, &mut sight) else {
            self.tick(now, period.0, feed, script, ahead);
            return turns;
        };
        self.path.pass(stepped);
        if fresh {
            (self.step.fifo, self.step.done) = (self.path.fifo(), self.path.done(self.path.fifo()));
        }
        if !self.path.is_due_before(next, period) {
            if ahead && turns == 0 {
                self.path.prepare(feed, script);
            }
        } else if self.path.turn_at::<true>(feed, |_| true).is_none() || self.path.is_due_before(next, period) {
            self.path.go_through(next, period, feed, script, &mut self.heard);
        } else {
            turns += 1;
        }
        turns
    }
}

fn entry(chance: &mut Chance, k: u8, place: &mut [i32; 4]) -> PathEntry {
    let vel = chance.log(1.0, 60.0);
    let along = speeds(vel, vel / chance.log(0.3, 9.0), vel * chance.unit() * (chance.below(4) > 0) as u8 as f64);
    let mut step = |x: &mut i32| *x += (chance.sign() * chance.log(1.0, 400.0)) as i32;
    match k % 12 {
        0 => mark(k),
        1 => PathEntry::gear(Axis::new(3).unwrap(), 17),
        2 => PathEntry::delay(3),
        3 => {
            let (mut a, mut b) = (place[0] + 3, place[1]);
            step(&mut a);
            step(&mut b);
            (place[0], place[1]) = (a, b);
            let turns = 0.001 + chance.unit() * 0.49;
            let sweep = Sweep::admit(turns.to_bits(), chance.below(2) == 0, chance.below(2) == 0).unwrap();
            PathEntry::arc(Plane::Xy, [place[0], place[1]], sweep, along)
        }
        4 => PathEntry::circle(Plane::Zx, [40 << 30, 7 << 30], k & 1 == 0, along).unwrap(),
        // A line without length.
        5 => PathEntry::line(*place, along),
        6..9 => {
            place.iter_mut().for_each(&mut step);
            PathEntry::line(*place, along)
        }
        _ => {
            place.iter_mut().take(2).for_each(&mut step);
            PathEntry::planar([place[0], place[1]], along)
        }
    }
}

#[test]
fn what_is_made_ahead_is_what_would_have_been_made() {
    let mut chance = Chance::new(31);
    let cases = std::env::var("BEAMTICK_PATHS_AHEAD").map_or(300, |text| text.parse().unwrap());
    let (mut ticks, mut stops, mut turns) = (0u64, 0, 0);
    for case in 0..cases {
        let mut place = [0; 4];
        let count = 4 + chance.below(24);
        let script = Script(
            (0..count)
                .map(|_| {
                    let k = chance.below(240) as u8;
                    entry(&mut chance, k, &mut place)
                })
                .collect(),
        );
        let mut end = if chance.below(2) == 0 { count } else { 1 + chance.below(count) } as u32;
        let period = [10_000, 50_000, 250_000, 1_000_000][chance.below(4) as usize];
        // How often there is time to make something ahead.
        let often = chance.below(4);
        let mut path = Path::IDLE;
        path.rules.set_even(if chance.below(3) == 0 { chance.below(4) as u16 } else { 0 });
        path.rules.set_stop(Accel::admit(chance.log(0.3, 30.0).to_bits()).unwrap());
        let mut both = [Seen::new(path), Seen::new(path), Seen::new(path)];
        let mut now = 1_000_000;
        for both in &mut both {
            both.path.start(Ns(now), 0, FifoEnds { ends: [end, 0] }, &script);
        }
        let mut left = 3;
        loop {
            let feed = FifoEnds { ends: [end, 0] };
            let act = chance.below(400_000_000 / period);
            for seen in &mut both {
                match act {
                    0 if left > 0 => seen.path.stop(Ns(now), false, feed, &script, &mut seen.heard),
                    1 if left > 0 => {
                        let rate = FeedOverride::admit((1.0 / (1 + now / period % 3) as f64).to_bits()).unwrap();
                        seen.path.rules.set_override(rate);
                        seen.path.replan(Ns(now), feed, &script);
                    }
                    _ => {}
                }
            }
            stops += (act == 0 && left > 0) as u32;
            left -= (act < 2 && left > 0) as u32;
            if act > 2 && act < 40 && end < count as u32 {
                end += 1;
            }
            let feed = FifoEnds { ends: [end, 0] };
            let ahead = chance.below(4) >= often;
            let [with, without, quick] = &mut both;
            with.tick(now, period, feed, &script, ahead);
            turns += quick.fast_step(now, period, feed, &script, ahead);
            without.tick(now, period, feed, &script, false);
            assert_eq!(with.step, without.step, "case {case} at {now}");
            assert_eq!(quick.step, without.step, "case {case} at {now}, by the fast path");
            let mean = |seen: &Seen| seen.path.mean(&seen.step.motion, Ns(now), Ns(period));
            assert_eq!(mean(quick), mean(without), "case {case} at {now}");
            ticks += 1;
            now += period;
            if !with.step.runs {
                if with.path.refuses_start(0, feed) && end == count as u32 {
                    break;
                }
                end = count as u32;
                let feed = FifoEnds { ends: [end, 0] };
                if with.path.refuses_start(0, feed) {
                    break;
                }
                for seen in &mut both {
                    seen.path.start(Ns(now), 0, feed, &script);
                }
            }
            assert!(now < 1 << 40, "case {case} does not end");
        }
        let [with, without, quick] = both;
        for seen in [with, quick] {
            assert_eq!(seen.heard.marks, without.heard.marks, "case {case}");
            assert_eq!(seen.heard.rests, without.heard.rests, "case {case}");
            let gears = |seen: &Seen| (seen.heard.gears.clone(), seen.heard.geared.clone());
            assert_eq!(gears(&seen), gears(&without), "case {case}");
        }
    }
    println!("{ticks} ticks, {stops} Stops, {turns} turns by the fast path");
    assert!(ticks > 20 * cases && stops > 0 && u64::from(turns) > cases);
}
