//! A prepared start is the same as one planned in its tick. Two machines run the same commands; on
//! one of them every axis is changed in every tick, so that nothing is ever prepared.

use crate::{chance, tick_bench};
use chance::Chance;
use servo::segment::follow;
use servo::status;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{AxisMask, Crd, Ns, Pos};
use servo::view::AxisView;
use tick_bench::*;

const MODES: [MotionMode; 7] = [
    MotionMode::PtStatic,
    MotionMode::PtDynamic,
    MotionMode::Pvt,
    MotionMode::Trap,
    MotionMode::Jog,
    MotionMode::Follow,
    MotionMode::FollowEx,
];

/// Two machines under the same commands. The second one never has a prepared start.
struct Both([Bench; 2]);

/// An axis as its reader sees it, but for the counters of internal changes.
fn as_read(axis: &AxisView) -> AxisView {
    AxisView { version: 0, piece_version: 0, progress_version: 0, state_version: 0, ..*axis }
}

impl Both {
    fn new(period_us: u32) -> Both {
        let mut both = Both([(); 2].map(|_| Bench::new(period_us)));
        both.each(|bench| {
            for index in 0..AXES {
                bench.now(TickCommand::Servo { axis: axis(index), on: true });
            }
        });
        both.ticks(2);
        both
    }

    fn each(&mut self, mut act: impl FnMut(&mut Bench)) {
        self.0.iter_mut().for_each(&mut act);
    }

    fn now(&mut self, command: TickCommand) {
        self.each(|bench| {
            bench.now(command);
        });
    }

    fn ticks(&mut self, count: u64) {
        for _ in 0..count {
            for index in 0..AXES {
                self.0[1].now(TickCommand::Servo { axis: axis(index), on: true });
            }
            let [a, b] = [0, 1].map(|k| self.0[k].tick());
            for index in 0..AXES {
                let (a, b) = (as_read(&a.axes[index]), as_read(&b.axes[index]));
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "axis {index}");
            }
        }
    }

    fn running(&mut self) -> u64 {
        let view = self.0[0].tick();
        self.0[1].tick();
        (0..AXES).filter(|index| has(&view.axes[*index], status::RUNNING)).map(|index| 1 << index).sum()
    }
}

/// A pass of segments that ends at standstill, and one table of the same kind.
fn segments(chance: &mut Chance) -> Vec<(f64, i32, i16)> {
    let (mut time, count) = (0, 1 + chance.below(4));
    let mut data: Vec<_> = (0..count)
        .map(|_| {
            time += 1 + chance.below(9) as i32;
            (chance.sign() * chance.log(1e-3, 300.0), time, chance.below(3) as i16)
        })
        .collect();
    data.push((data[data.len() - 1].0 + 1.0, time + 5, 2));
    data
}

fn knots(chance: &mut Chance) -> Vec<(u64, i64, i64)> {
    let vel = |chance: &mut Chance| chance.below(1 << 18) as i64 - (1 << 17);
    let mut knots = vec![(0, 0, vel(chance))];
    for k in 1..2 + chance.below(3) {
        knots.push((k * (1 + chance.below(4)) + 4 * k, chance.below(400) as i64 - 200, vel(chance)));
    }
    knots.sort();
    knots.dedup_by_key(|knot| knot.0);
    knots
}

/// One thing that a user may do to an axis at rest, and to all of its data.
fn act(both: &mut Both, chance: &mut Chance, index: usize, mode: &mut MotionMode) {
    let axis = axis(index);
    match chance.below(9) {
        0 => {
            *mode = MODES[chance.below(MODES.len() as u64) as usize];
            both.now(TickCommand::SetMode { axis, mode: *mode });
            both.each(|bench| bench.forget(index));
        }
        1 => both.now(TickCommand::SetPosition { axis, pos: Pos::pulses(chance.below(2000) as i32 - 1000) }),
        2 => {
            let (crd, mapped) = (Crd::new(0).unwrap(), [Some(axis), None, None, None]);
            let frame = servo::path::axis_map::AxisMap::admit(mapped, None, 0).unwrap();
            both.now(TickCommand::CrdFrame { crd, frame });
            both.ticks(chance.below(20));
            *mode = MotionMode::PtStatic;
            both.now(TickCommand::SetMode { axis, mode: *mode });
            both.each(|bench| bench.forget(index));
        }
        _ => {}
    }
    match mode {
        MotionMode::PtStatic | MotionMode::PtDynamic => {
            let fifo = if *mode == MotionMode::PtStatic { chance.below(2) as u8 } else { 0 };
            both.now(TickCommand::PtClear { axis, fifo });
            if *mode == MotionMode::PtStatic {
                both.now(TickCommand::PtClear { axis, fifo: fifo ^ 1 });
            }
            both.each(|bench| bench.forget(index));
            both.now(TickCommand::PtLoop { axis, passes: 1 + chance.below(3) as u32 });
            let data = segments(chance);
            both.each(|bench| bench.pt(index, fifo, &data));
        }
        MotionMode::Pvt => {
            // Tables are written without a command to the axis, which may have prepared from the
            // one before.
            let (table, delay, knots) = (chance.below(3) as u8, chance.below(3) * 2, knots(chance));
            both.each(|bench| bench.table(table, delay, &knots));
            if chance.below(2) == 0 {
                both.now(TickCommand::PvtSelect { axis, table: chance.below(3) as u8 });
                both.now(TickCommand::PvtLoop { axis, passes: 1 + chance.below(3) as u32 });
            }
        }
        MotionMode::Follow | MotionMode::FollowEx => {
            let (master, other) = (AXES - 1, index == AXES - 1);
            if other {
                return;
            }
            let fifo = chance.below(2) as u8;
            for fifo in 0..2 {
                both.now(TickCommand::FollowClear { axis, fifo });
                both.each(|bench| bench.emptied(index, fifo));
            }
            let (mut to, count) = (0.0, 1 + chance.below(4));
            let mut items: Vec<_> = (0..count)
                .map(|k| {
                    to += chance.log(1e-3, 40.0);
                    let percent = if *mode == MotionMode::FollowEx { chance.below(101) as i16 } else { 0 };
                    match chance.below(8) {
                        0 => Item::Delay(chance.below(9) as u32),
                        _ => Item::Data(to, chance.sign() * chance.log(1e-3, 50.0), (k % 3) as i16, percent),
                    }
                })
                .collect();
            items.push(Item::Data(to + 5.0, 1.0, 2, 0));
            both.each(|bench| bench.follow(index, fifo, &items));
            both.now(TickCommand::FollowLoop { axis, passes: 1 + chance.below(3) as u32 });
            let pass = follow::StartEvent::Pass { up: true, pos: chance.below(100) as i32 };
            both.now(TickCommand::FollowEvent {
                axis,
                event: if chance.below(4) == 0 { pass } else { follow::StartEvent::Start },
            });
            let value =
                if chance.below(3) == 0 { follow::MasterPosition::Encoder } else { follow::MasterPosition::Planned };
            both.now(TickCommand::FollowMaster {
                axis,
                master: follow::Master { axis: tick_bench::axis(master), value },
            });
        }
        _ => {
            let (acc, dec) = (accel(chance.log(1e-3, 30.0)), accel(chance.log(1e-3, 30.0)));
            let smooth = if chance.below(2) == 0 { Ns(chance.below(9) * MS) } else { Ns(0) };
            let vel_start = speed(chance.unit());
            both.now(TickCommand::TrapPrm { axis, acc, dec, vel_start, smooth });
            both.now(TickCommand::JogPrm { axis, acc, dec, smooth: chance.below(1 << 16) as u16 });
            both.now(TickCommand::TargetSpeed { axis, speed: speed(chance.log(0.01, 20.0)) });
            both.now(TickCommand::TargetPosition { axis, pulses: chance.below(300) as i32 - 150 });
        }
    }
}

#[test]
fn a_start_made_ready_is_the_start() {
    let mut chance = Chance::new(20);
    let mut started = 0;
    for round in 0..15u32 {
        let mut both = Both::new([50, 250, 1000][round as usize % 3]);
        let mut modes = [MotionMode::PtStatic; AXES];
        for index in 0..AXES {
            both.now(TickCommand::SetMode { axis: axis(index), mode: MotionMode::PtStatic });
        }
        both.ticks(1);
        for _ in 0..12 {
            let busy = both.running();
            let free: Vec<usize> = (0..AXES).filter(|index| busy >> index & 1 == 0).collect();
            for &index in &free {
                if chance.below(3) != 0 {
                    act(&mut both, &mut chance, index, &mut modes[index]);
                    both.ticks(1);
                }
            }
            both.ticks(chance.below(40));
            for &index in &free {
                let (axes, fifo1) = (all(&[index]), if chance.below(2) == 0 { all(&[index]) } else { AxisMask(0) });
                both.now(match modes[index] {
                    MotionMode::PtStatic | MotionMode::PtDynamic => TickCommand::PtStart { axes, fifo1 },
                    MotionMode::Pvt => TickCommand::PvtStart { axes },
                    MotionMode::Follow | MotionMode::FollowEx => TickCommand::FollowStart { axes, fifo1 },
                    _ => TickCommand::Update { axes },
                });
            }
            both.ticks(1);
            started += both.running().count_ones();
            both.ticks(chance.below(60));
            if chance.below(2) == 0 {
                both.now(TickCommand::stop(AxisMask(0xff), AxisMask(chance.below(256))));
            }
            both.ticks(60);
        }
    }
    assert!(started > 300, "only {started} starts");
}
