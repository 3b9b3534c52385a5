//! A prepared start is the same as a start planned in its tick. Of two paths one makes nothing
//! ahead. They run through random FIFOs, Stops of both kinds, clearing, overrides, other user
//! positions, data that comes while something is being made, and starts with the FIFO that was not
//! expected. Every position, speed, instant and gear is the same to the bit.
use crate::{chance, paths};
use servo::path::{
    Curvature, FeedOverride, FifoEnds, MotionSpeeds, Path, PathEntries, PathEntry, PathReport, Plane, StepReport, Sweep,
};
use servo::segment::piece::Motion;
use servo::segment::ramp::Accel;
use servo::test_hooks::Step;
use servo::units::{Axis, Ns, Pos};

use chance::Chance;
use paths::{Heard, mark, speeds};

#[derive(Default)]
struct Fifos {
    entries: [Vec<PathEntry>; 2],
    ends: [u32; 2],
}

impl PathEntries for Fifos {
    fn entry(&self, fifo: u8, counter: u32) -> PathEntry {
        self.entries[fifo as usize][counter as usize]
    }
}

impl Fifos {
    fn feed(&self) -> FifoEnds {
        FifoEnds { ends: self.ends }
    }
}

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

    fn tick(&mut self, now: u64, period: u64, fifos: &Fifos, ahead: bool) {
        let Step { position: place, heading, bend, motion, .. } = &mut self.step;
        let mut sight = PathReport { position: place, heading, bend, motion, piece_version: &mut self.turns };
        let StepReport { runs, fifo, done, .. } =
            self.path.advance(Ns(now), Ns(period), fifos.feed(), fifos, &mut self.heard, &mut sight, ahead);
        (self.step.runs, self.step.fifo, self.step.done) = (runs, fifo, done);
    }
}

fn along(chance: &mut Chance) -> MotionSpeeds {
    let vel = chance.log(3.0, 60.0);
    speeds(vel, vel / chance.log(0.3, 9.0), vel * chance.unit() * (chance.below(4) > 0) as u8 as f64)
}

fn entry(chance: &mut Chance) -> PathEntry {
    let along = along(chance);
    let [x, y, z, a] = [(); 4].map(|()| (chance.sign() * chance.log(1.0, 400.0)) as i32);
    match chance.below(14) {
        k @ 0..3 => mark(k as u8),
        3 => PathEntry::gear(Axis::new(3).unwrap(), 17),
        4 => PathEntry::delay(chance.below(4) as u16),
        5 | 6 => {
            let turns = 0.01 + chance.unit() * 0.49;
            let sweep = Sweep::admit(turns.to_bits(), chance.below(2) == 0, chance.below(2) == 0).unwrap();
            PathEntry::arc([Plane::Xy, Plane::Yz, Plane::Zx][chance.below(3) as usize], [x, y], sweep, along)
        }
        7 => PathEntry::circle(Plane::Zx, [40 << 30, 7 << 30], chance.below(2) == 0, along).unwrap(),
        8..10 => PathEntry::line([x, y, z, a], along),
        _ => PathEntry::planar([x, y], along),
    }
}

/// What may happen to a path at rest; the first of both prepares a part of a start now and then.
fn rest(both: &mut [Seen; 2], fifos: &mut Fifos, chance: &mut Chance) {
    let likely = chance.below(2) as u8;
    for _ in 0..chance.below(7) {
        let fifo = chance.below(2) as u8;
        match chance.below(8) {
            0 if chance.below(3) == 0 => {
                (fifos.entries[fifo as usize], fifos.ends[fifo as usize]) = (Vec::new(), 0);
                both.iter_mut().for_each(|seen| seen.path.clear(fifo));
            }
            1 => {
                let rate = FeedOverride::admit((1.0 / (1 + chance.below(3)) as f64).to_bits()).unwrap();
                for seen in both.iter_mut() {
                    seen.path.rules.set_override(rate);
                    seen.path.replan(Ns(0), fifos.feed(), fifos);
                }
            }
            2 => {
                let by = [(); 4].map(|()| chance.below(1 << Pos::FRAC_BITS) as i64 >> chance.below(23));
                for seen in both.iter_mut() {
                    let mut here = seen.path.here();
                    here.iter_mut().zip(by).for_each(|(here, by)| here.0 += by);
                    seen.path.rename(here);
                }
            }
            3 if chance.below(9) == 0 => {
                *fifos = Fifos::default();
                both.iter_mut().for_each(|seen| seen.path.position([Pos::pulses(3); 4]));
            }
            _ => {
                fifos.entries[fifo as usize].extend((0..1 + chance.below(6)).map(|_| entry(chance)));
                let (first, end) = (fifos.ends[fifo as usize], fifos.entries[fifo as usize].len() as u32);
                fifos.ends[fifo as usize] = first + chance.below((end - first) as u64 + 1) as u32;
            }
        }
        for _ in 0..chance.below(16) {
            let fifo = if chance.below(20) == 0 { likely ^ 1 } else { likely };
            both[0].path.prepare_start(fifo, fifos.feed(), fifos);
        }
    }
}

/// Prepared starts that began with a motion, and those that went on within one.
#[derive(Default)]
struct Count {
    starts: u32,
    prepared: u32,
    resumed: u32,
    stops: u32,
}

fn case(chance: &mut Chance, case: u64, count: &mut Count) {
    let period = [10_000, 50_000, 250_000, 1_000_000][chance.below(4) as usize];
    let mut path = Path::IDLE;
    path.rules.set_even(if chance.below(3) == 0 { chance.below(4) as u16 } else { 0 });
    path.rules.set_stop(Accel::admit(chance.log(0.3, 30.0).to_bits()).unwrap());
    let (mut both, mut fifos) = ([Seen::new(path), Seen::new(path)], Fifos::default());
    let mut now = 1_000_000;
    for round in 0..12 {
        rest(&mut both, &mut fifos, chance);
        let (fifo, feed) = (chance.below(2) as u8, fifos.feed());
        let refused = both[0].path.refuses_start(fifo, feed);
        assert_eq!(refused, both[1].path.refuses_start(fifo, feed), "case {case}, round {round}");
        if refused {
            continue;
        }
        // All that there is to make is made.
        let prepared = chance.below(2) == 0;
        let mut made = 0;
        while prepared && both[0].path.prepare_start(fifo, feed, &fifos) {
            made += 1;
            assert!(made < 20, "it is never ready");
        }
        count.starts += 1;
        count.prepared += (made > 0) as u32;
        count.resumed += (made > 0 && both[0].path.continues(fifo)) as u32;
        both.iter_mut().for_each(|seen| seen.path.start(Ns(now), fifo, feed, &fifos));
        let mut stop = Some(chance.below(60_000_000 / period)).filter(|_| chance.below(3) > 0);
        let (abrupt, often) = (chance.below(2) == 0, chance.below(4));
        for tick in 0u64.. {
            // A long path is not followed to its end.
            let abrupt = abrupt || tick > 3000;
            if stop == Some(tick) || tick == 4000 {
                (stop, count.stops) = (None, count.stops + 1);
                both.iter_mut().for_each(|seen| seen.path.stop(Ns(now), abrupt, fifos.feed(), &fifos, &mut seen.heard));
            }
            if chance.below(100) == 0 {
                fifos.ends = [0, 1].map(|fifo| fifos.entries[fifo].len() as u32);
            }
            let ahead = chance.below(4) >= often;
            both[0].tick(now, period, &fifos, ahead);
            both[1].tick(now, period, &fifos, false);
            assert_eq!(both[0].step, both[1].step, "case {case}, round {round}, tick {tick}");
            now += period;
            if !both[0].step.runs {
                break;
            }
            assert!(tick < 4000, "case {case} does not end");
        }
    }
    let [with, without] = both;
    assert_eq!(with.heard.marks, without.heard.marks, "case {case}");
    assert_eq!(with.heard.rests, without.heard.rests, "case {case}");
    assert_eq!((with.heard.gears, with.heard.geared), (without.heard.gears, without.heard.geared), "case {case}");
}

#[test]
fn a_ready_start_is_the_start_that_would_have_been_made() {
    let (mut chance, mut count) = (Chance::new(57), Count::default());
    let cases = std::env::var("BEAMTICK_PATHS_READY").map_or(300, |text| text.parse().unwrap());
    for number in 0..cases {
        case(&mut chance, number, &mut count);
    }
    let Count { starts, prepared, resumed, stops } = count;
    println!("{starts} starts, {prepared} ready, {resumed} of these resumed, {stops} Stops");
    assert!(
        prepared as u64 > cases && resumed as u64 * 4 > cases && stops as u64 > cases,
        "{prepared}, {resumed}, {stops}"
    );
}
