//! A view does not depend on how often it is read: three buffers take turns, and each catches up
//! with the changes since its last turn. And it agrees with the trace of the same tick.
use crate::{chance, tick_bench};
use chance::Chance;
use servo::path::{self, MotionSpeeds};
use servo::segment::follow;
use servo::tick_command::{DoGroup, Guarded, Guards, MotionMode, TickCommand};
use servo::units::AxisMask;
use servo::view::{Traced, View};
use tick_bench::*;

const MODES: [MotionMode; 8] = [
    MotionMode::PtStatic,
    MotionMode::PtDynamic,
    MotionMode::Pvt,
    MotionMode::Jog,
    MotionMode::Trap,
    MotionMode::Trap,
    MotionMode::Follow,
    MotionMode::Pvt,
];

fn begin(period_us: u32) -> Bench {
    let mut bench = Bench::new(period_us);
    bench.now(TickCommand::Output { group: DoGroup::Enable, mask: 0xff, value: 0xff });
    for (table, pos) in [(0, 900), (1, -300), (2, 40_000)] {
        bench.table(table, 2, &[(0, 0, 0), (3, pos, 1 << 16), (4, pos + 2, 0), (9, pos * 2, -(1 << 15)), (11, pos, 0)]);
    }
    for (index, mode) in MODES.into_iter().enumerate() {
        bench.now(TickCommand::SetMode { axis: axis(index), mode });
        bench.now(TickCommand::StopDec { axis: axis(index), smooth: accel(0.7), abrupt: accel(1.0) });
    }
    bench.pt(0, 0, &[(10.5, 3, 0), (-2000.0, 9, 0), (7.0, 11, 2)]);
    bench.follow(6, 0, &[Item::Data(30.0, 11.0, 0, 0), Item::Data(90.0, -400.0, 1, 0), Item::Data(100.0, 0.25, 2, 0)]);
    bench.now(TickCommand::Trace {
        every: 1,
        axes: AxisMask(0xff),
        crds: Default::default(),
        lasers: 0,
        edges: false,
        outputs: false,
    });
    bench.now(TickCommand::ProgramRun);
    bench.tick();
    bench
}

/// One thing to do, the same in every bench that draws the same numbers.
fn act(bench: &mut Bench, chance: &mut Chance, stream: &mut i32) {
    let (index, far) = (chance.below(8) as usize, chance.unit() * 2.0 - 1.0);
    let axis = axis(index);
    let passes = chance.below(6) as u32;
    match chance.below(16) {
        0 => {
            bench.now(TickCommand::stop(AxisMask(chance.next() & 0xff), AxisMask(chance.next() & 0xff)));
        }
        1 => {
            bench.now(TickCommand::SoftLimit {
                axis,
                positive: (far > 0.0).then_some((far * 5000.0) as i32),
                negative: (far < -0.5).then_some((far * 5000.0) as i32),
            });
        }
        2 => bench.machine.inputs[index].limit_positive ^= true,
        3 => bench.machine.slip[index] += 3,
        4 => {
            bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
            bench.machine.inputs[index] = Default::default();
        }
        5 => {
            bench.now(TickCommand::PositionError { axis, limit: (far > 0.0).then_some(20) });
        }
        6 => {
            bench.now(TickCommand::Guard { axis, on: Guards::NONE, low: Guards::set(Guarded::Home, far > 0.0) });
        }
        7 => {
            bench.now(TickCommand::PvtSelect { axis, table: chance.below(3) as u8 });
        }
        8 => {
            bench.now(TickCommand::PvtLoop { axis, passes });
            bench.now(TickCommand::PtLoop { axis, passes });
            bench.now(TickCommand::FollowLoop { axis, passes });
        }
        9 => {
            bench.now(TickCommand::PvtStart { axes: all(&[2]) });
            bench.now(TickCommand::PvtStart { axes: all(&[7]) });
        }
        10 => {
            bench.now(TickCommand::PtStart { axes: all(&[0]), fifo1: AxisMask(0) });
        }
        11 => {
            // Stopped or dry: the stream begins anew.
            bench.forget(1);
            bench.now(TickCommand::PtClear { axis: tick_bench::axis(1), fifo: 0 });
            bench.tick_unread();
            *stream += 1;
            bench.pt(1, 0, &[(far * 100.0, 2, 0), (0.0, 5, 1), (far, 9, 2)]);
            bench.start(&[1]);
        }
        12 | 13 => {
            bench.now(TickCommand::TargetSpeed { axis, speed: speed(far * 50.0) });
            bench.now(TickCommand::JogPrm { axis, acc: accel(3.3), dec: accel(0.9), smooth: (passes * 9000) as u16 });
            bench.now(TickCommand::TrapPrm {
                axis,
                acc: accel(1.7),
                dec: accel(2.2),
                vel_start: speed(0.0),
                smooth: servo::units::Ns(u64::from(passes) * MS),
            });
            bench.now(TickCommand::TargetPosition { axis, pulses: (far * 3000.0) as i32 });
            bench.now(TickCommand::Update { axes: axis.mask() });
        }
        14 => {
            bench.follows(6, if far > 0.0 { 3 } else { 4 }, follow::MasterPosition::Planned);
            bench.start_follow(&[6]);
        }
        _ => {
            bench.now(TickCommand::Servo { axis, on: true });
            if far > 0.8 {
                bench.now(TickCommand::Zero { axes: axis.mask() });
            }
            if far < -0.8 {
                bench.now(TickCommand::Reset { axes: axis.mask() });
                bench.now(TickCommand::Servo { axis, on: true });
                bench.now(TickCommand::SetMode { axis, mode: MODES[index] });
                bench.now(TickCommand::StopDec { axis, smooth: accel(0.7), abrupt: accel(1.0) });
                if index == 0 {
                    bench.now(TickCommand::PtCommit { axis, fifo: 0, end: 3, epoch: 0 });
                }
            }
        }
    }
}

/// An axis as a view has it, and its inputs.
fn described(view: &View<AXES>, index: usize) -> String {
    format!("{:?} {:?}", view.axes[index], view.inputs[index])
}

#[test]
fn a_view_reports_the_same_however_often_it_is_read() {
    for (seed, period_us) in [(1, 250), (2, 1000), (3, 50)] {
        let (mut eager, mut lazy) = (begin(period_us), begin(period_us));
        let (mut one, mut other, mut reads) = (Chance::new(seed), Chance::new(seed), Chance::new(seed + 9));
        let (mut streams, mut moved) = ((0, 0), 0u64);
        let mut unread = 0;
        for round in 0..12_000 {
            if one.below(12) == 0 {
                act(&mut eager, &mut one, &mut streams.0);
            }
            if other.below(12) == 0 {
                act(&mut lazy, &mut other, &mut streams.1);
            }
            let view = eager.tick();
            if unread > 0 {
                unread -= 1;
                lazy.tick_unread();
            } else {
                unread = reads.below(9);
                let late = lazy.tick();
                for index in 0..AXES {
                    assert_eq!(
                        described(&late, index),
                        described(&view, index),
                        "axis {index}, seed {seed}, round {round}"
                    );
                }
            }
            while eager.event().is_some() || lazy.event().is_some() || lazy.sample().is_some() {}
            let mut last = [None; AXES];
            while let Some(sample) = eager.sample() {
                if let Traced::Axis { axis, pos, motion } = sample.of {
                    last[axis.index()] = Some((pos, motion));
                }
            }
            for (index, sample) in last.into_iter().enumerate() {
                let (pos, motion) = sample.unwrap();
                let published = &view.axes[index];
                let described = (pos, motion.velocity());
                assert_eq!((published.pos, view.velocity(published)), described, "axis {index}, round {round}");
                // The one with the acceleration is rounded with it.
                let (alone, whole) = (real(described.1), view.motion(published));
                let room = (alone.abs() + real(whole.acceleration()).abs()) * 2f64.powi(-48);
                assert!(
                    (alone - real(whole.velocity())).abs() <= room,
                    "axis {index}, round {round}: {described:?} {whole:?}"
                );
                moved += u64::from(published.status & servo::status::RUNNING != 0);
            }
        }
        assert!(moved > 12_000 && streams.0 > 10, "{moved} axes and ticks, {streams:?}");
    }
}

/// The same for axes that a coordinate system drives, releases and drives again.
#[test]
fn a_view_of_driven_axes_does_not_depend_on_who_reads_it() {
    let make = || {
        let mut bench = Bench::prepared(250, MotionMode::Trap);
        bench.frame(0, &[2, 5], Some([100, -50, 0, 0]));
        bench.tick();
        bench
    };
    let (mut eager, mut lazy, mut chance) = (make(), make(), Chance::new(5));
    let (mut unread, mut drove) = (0, 0);
    let line = |x, y| {
        let along = MotionSpeeds::admit(10f64.to_bits(), 1f64.to_bits(), 0f64.to_bits()).unwrap();
        path::PathEntry::planar([x, y], along)
    };
    for round in 0..6000 {
        let (draw, x, y) = (chance.below(60), chance.below(300) as i32, chance.below(300) as i32);
        for bench in [&mut eager, &mut lazy] {
            match draw {
                0 | 1 => bench.path(0, 0, &[line(x, y)]),
                2 | 3 => {
                    bench.start_path(&[0]);
                }
                4 => {
                    bench.now(TickCommand::stop(all(&[2]), AxisMask(x as u64 & 4)));
                }
                5 => bench.machine.slip[5] += 1,
                6 => {
                    bench.now(TickCommand::ClearStatus { axes: AxisMask(0xff) });
                }
                _ => {}
            }
        }
        let view = eager.tick();
        drove += u32::from(view.axes[5].drive.is_some());
        if unread > 0 {
            unread -= 1;
            lazy.tick_unread();
        } else {
            unread = chance.below(9);
            let late = lazy.tick();
            for index in 0..AXES {
                assert_eq!(described(&late, index), described(&view, index), "axis {index}, round {round}");
            }
        }
        while eager.event().is_some() || lazy.event().is_some() {}
    }
    assert!(drove > 1000, "driven in {drove} ticks");
}
