//! A prepared start of a path is the same as one planned in its tick. Two machines run the same
//! commands; on one of them every coordinate system is changed in every tick, so that nothing is
//! ever prepared.
use crate::{chance, tick_bench};
use servo::path::{FeedOverride, MotionSpeeds, PathEntry, Plane, Sweep};
use servo::tick_command::{DoGroup, MotionMode, TickCommand};
use servo::units::{CrdMask, Pos};
use servo::view::{AxisView, CrdView};

use chance::Chance;
use tick_bench::*;

/// Two machines under the same commands. The second one never has a prepared start.
struct Both([Bench; 2]);

/// As readers see them, but for the counters of internal changes.
fn as_read(axis: &AxisView) -> AxisView {
    AxisView { version: 0, piece_version: 0, progress_version: 0, state_version: 0, ..*axis }
}

fn published(crd: &CrdView) -> CrdView {
    CrdView { version: 0, piece_version: 0, state_version: 0, ..*crd }
}

impl Both {
    fn now(&mut self, command: TickCommand) {
        self.each(|bench| {
            bench.now(command);
        });
    }

    fn each(&mut self, mut act: impl FnMut(&mut Bench)) {
        self.0.iter_mut().for_each(&mut act);
    }

    /// Whether one of them still runs.
    fn ticks(&mut self, count: u64) -> bool {
        let mut runs = false;
        for _ in 0..count {
            for index in 0..2 {
                // A command that changes nothing.
                self.0[1].now(TickCommand::CrdStopDec { crd: crd(index), dec: accel(1.0) });
            }
            let [a, b] = [0, 1].map(|k| self.0[k].tick());
            for index in 0..AXES {
                let (a, b) = (as_read(&a.axes[index]), as_read(&b.axes[index]));
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "axis {index}");
            }
            for (index, (one, other)) in a.crds.iter().zip(&b.crds).enumerate() {
                assert_eq!(
                    format!("{:?}", published(one)),
                    format!("{:?}", published(other)),
                    "coordinate system {index}"
                );
            }
            let events = [0, 1].map(|k| {
                let reported: Vec<String> =
                    core::iter::from_fn(|| self.0[k].event()).map(|e| format!("{e:?}")).collect();
                reported
            });
            assert_eq!(events[0].len(), events[1].len(), "{events:?}");
            runs = a.crds.iter().any(|crd| crd.runs);
        }
        runs
    }
}

fn entry(chance: &mut Chance) -> PathEntry {
    let vel = chance.log(6.0, 60.0);
    let end = vel * chance.unit() * (chance.below(3) > 0) as u8 as f64;
    let along = MotionSpeeds::admit(vel.to_bits(), (vel / chance.log(0.5, 9.0)).to_bits(), end.to_bits()).unwrap();
    let [x, y] = [(); 2].map(|()| (chance.sign() * chance.log(1.0, 400.0)) as i32);
    match chance.below(9) {
        0 => PathEntry::output(DoGroup::General, 7, chance.below(8)),
        1 => PathEntry::delay(chance.below(3) as u16),
        2 => PathEntry::gear(axis(0), 23),
        3 | 4 => {
            let sweep = Sweep::admit((0.05 + 0.4 * chance.unit()).to_bits(), false, chance.below(2) == 0).unwrap();
            PathEntry::arc(Plane::Xy, [x, y], sweep, along)
        }
        _ => PathEntry::planar([x, y], along),
    }
}

/// One thing that a user may do to a coordinate system at rest.
fn act(both: &mut Both, chance: &mut Chance, index: usize) {
    let fifo = chance.below(2) as u8;
    match chance.below(9) {
        0 => {
            let origin = (chance.below(2) == 0).then(|| [chance.below(50) as i32, -7, 0, 0]);
            both.each(|bench| bench.frame(index, &[1 + 2 * index, 2 + 2 * index], origin));
            both.ticks(1);
        }
        1 => {
            both.each(|bench| bench.clear_path(index, fifo));
            both.ticks(1);
        }
        2 => {
            let pos = Pos::pulses(chance.below(300) as i32);
            both.now(TickCommand::SetPosition { axis: axis(1 + 2 * index), pos });
        }
        3 => {
            let rate = FeedOverride::admit((1.0 / (1 + chance.below(3)) as f64).to_bits()).unwrap();
            both.now(TickCommand::CrdOverride { crd: crd(index), rate });
        }
        _ => {
            let entries: Vec<_> = (0..1 + chance.below(5)).map(|_| entry(chance)).collect();
            both.each(|bench| bench.path(index, fifo, &entries));
        }
    }
    both.ticks(chance.below(24));
}

#[test]
fn a_ready_start_is_the_one_that_would_have_been_planned() {
    let (mut chance, mut ran) = (Chance::new(5), 0);
    for _ in 0..25 {
        let period = [10, 50, 250, 1000][chance.below(4) as usize];
        let mut both = Both([(); 2].map(|_| Bench::prepared(period, MotionMode::Trap)));
        for index in 0..2 {
            both.each(|bench| bench.frame(index, &[1 + 2 * index, 2 + 2 * index], None));
        }
        both.ticks(2);
        for _ in 0..6 {
            for _ in 0..1 + chance.below(4) {
                let index = chance.below(2) as usize;
                act(&mut both, &mut chance, index);
            }
            let crds = [CrdMask(1), CrdMask(2), CrdMask(3)][chance.below(3) as usize];
            both.now(TickCommand::CrdStart { crds, fifo1: CrdMask(chance.below(4) as u8) });
            if !both.ticks(1) {
                continue;
            }
            ran += 1;
            both.ticks(chance.below(2 * 20_000 / period as u64 + 1));
            if chance.below(2) == 0 {
                both.now(TickCommand::stop_crds(CrdMask(3), CrdMask(chance.below(4) as u8)));
            }
            for _ in 0..40 {
                if !both.ticks(50) {
                    break;
                }
            }
            both.now(TickCommand::stop_crds(CrdMask(3), CrdMask(3)));
            assert!(!both.ticks(2), "it still runs");
        }
    }
    assert!(ran > 25, "{ran}");
}
