//! One suite that every motion mode passes: knots exact, continuous where promised, ends where told, loops
//! accumulate, stop and restart. Each mode is told the same curve in its own words. A master that moves 1 pulse in
//! 1 ms makes progress the time.
mod motion;
use client::Call;
use motion::*;
use protocol::command::*;
use servo::units::Pos;

/// A curve of linear velocity: ends of segments, ms and pulses. The velocities at the knots follow:
/// 0, 10, 10, −4, 0.
const KNOTS: [(i32, f64); 4] = [(100, 500.0), (250, 2000.0), (350, 2300.0), (400, 2200.0)];
/// Passes that are run.
const PASSES: i32 = 3;
/// The axis under test, and the master of those that need one.
const AXIS: i16 = 1;
const MASTER: i16 = 2;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    PtStatic,
    PtDynamic,
    Pvt,
    PvtPercent,
    Follow,
    FollowEx,
}
use Mode::{Follow, FollowEx, PtDynamic, PtStatic, Pvt, PvtPercent};

const ALL: [Mode; 6] = [PtStatic, PtDynamic, Pvt, PvtPercent, Follow, FollowEx];

fn curve() -> Curve {
    Curve::plain(&KNOTS.map(|(ms, pos)| (ms, pos, 0)), whole(0))
}

impl Mode {
    /// The axis in its mode, with the curve in it; a master that moves from now on.
    fn load(self) -> Vec<Call> {
        let (core, profile) = (1.into(), AXIS.into());
        let table = (core, 1.into(), (KNOTS.len() as i32 + 1).into(), 0.into());
        let points = std::iter::once((0, 0.0)).chain(KNOTS);
        let pt = |pass: i32, fifo: i16| {
            KNOTS.map(|(ms, pos)| {
                let (pos, time_ms) = (pos + 2200.0 * f64::from(pass), ms + 400 * pass);
                Call::of(PtData {
                    core,
                    profile,
                    pos: pos.into(),
                    time_ms: time_ms.into(),
                    kind: 0.into(),
                    fifo: fifo.into(),
                })
            })
        };
        let master = || {
            let profile = MASTER.into();
            vec![
                Call::of(PrfPt { core, profile, mode: 0.into() }),
                Call::of(PtData {
                    core,
                    profile,
                    pos: 1e6.into(),
                    time_ms: 1_000_000.into(),
                    kind: 1.into(),
                    fifo: 0.into(),
                }),
                Call::of(PtStart { core, mask: (1 << (MASTER - 1)).into(), option: 0.into() }),
            ]
        };
        match self {
            PtStatic => [vec![Call::of(PrfPt { core, profile, mode: 0.into() })], pt(0, 0).to_vec()].concat(),
            PtDynamic => {
                let mut calls = vec![Call::of(PrfPt { core, profile, mode: 1.into() })];
                // A stream has no loops: its positions go on counting.
                calls.extend((0..PASSES).flat_map(|pass| pt(pass, 0)));
                calls
            }
            Pvt => {
                let velocities = [0.0, 10.0, 10.0, -4.0, 0.0];
                let items: Vec<PvtPoint> = points
                    .zip(velocities)
                    .map(|((ms, pos), vel)| PvtPoint { time: f64::from(ms).into(), pos: pos.into(), vel: vel.into() })
                    .collect();
                let (core, table, count, first) = table;
                vec![
                    Call::of(PrfPvt { core, profile }),
                    Call::with_items(PvtTable { core, table, count, first }, &items),
                ]
            }
            PvtPercent => {
                let items: Vec<PvtPercentPoint> = points
                    .map(|(ms, pos)| PvtPercentPoint {
                        time: f64::from(ms).into(),
                        pos: pos.into(),
                        percent: 0.0.into(),
                    })
                    .collect();
                let (core, table, count, first) = table;
                vec![
                    Call::of(PrfPvt { core, profile }),
                    Call::with_items(PvtTablePercent { core, table, count, first, vel_begin: 0.0.into() }, &items),
                ]
            }
            Follow => {
                let data = KNOTS.map(|(ms, pos)| (ms, pos, 0));
                [follow(AXIS, MASTER, 0), follow_data(AXIS, 0, &data), master()].concat()
            }
            FollowEx => {
                let data = KNOTS.map(|(ms, pos)| (f64::from(ms), pos, 0, 0));
                [follow_ex(AXIS, MASTER, 1), shaped_data(AXIS, 0, &data), master()].concat()
            }
        }
    }

    fn loops(self, count: i32) -> Call {
        let (core, profile, loop_count) = (1.into(), AXIS.into(), count.into());
        match self {
            PtStatic => Call::of(SetPtLoop { core, profile, loop_count }),
            // It says what it has.
            PtDynamic => Call::of(GetPtState { core, profile }),
            Pvt | PvtPercent => Call::of(SetPvtLoop { core, profile, loop_count }),
            Follow => Call::of(SetFollowLoop { core, profile, loop_count }),
            FollowEx => Call::of(SetFollowLoopEx { core, profile, loop_count }),
        }
    }

    fn start(self) -> Call {
        let (core, mask, option) = (1.into(), (1 << (AXIS - 1)).into(), 0.into());
        match self {
            PtStatic | PtDynamic => Call::of(PtStart { core, mask, option }),
            Pvt | PvtPercent => Call::of(PvtStart { core, mask }),
            Follow => Call::of(FollowStart { core, mask, option }),
            FollowEx => Call::of(FollowStartEx { core, mask, option }),
        }
    }

    /// Passes completed, where the mode counts them.
    fn passes(self, run: &Run) -> Option<i32> {
        match self {
            PtStatic => Some(run.replies::<GetPtLoop>().last()?.value.get()),
            PtDynamic => None,
            Pvt | PvtPercent => Some(run.replies::<GetPvtLoop>().last()?.loop_count.get()),
            Follow => Some(run.replies::<GetFollowLoop>().last()?.value.get()),
            FollowEx => Some(run.replies::<GetFollowLoopEx>().last()?.value.get()),
        }
    }

    fn ask_passes(self) -> Call {
        let (core, profile) = (1.into(), AXIS.into());
        match self {
            PtStatic => Call::of(GetPtLoop { core, profile }),
            PtDynamic => Call::of(GetPtState { core, profile }),
            Pvt | PvtPercent => Call::of(GetPvtLoop { core, profile }),
            Follow => Call::of(GetFollowLoop { core, profile }),
            FollowEx => Call::of(GetFollowLoopEx { core, profile }),
        }
    }
}

fn running() -> Call {
    Call::of(GetSts { core: 1.into(), axis: AXIS.into(), count: 1.into() })
}

/// Runs it with `then` behind the start, and stops the master.
fn under_test(mode: Mode, tick_us: u32, passes: i32, then: Vec<Call>) -> Run {
    let mut calls = mode.load();
    calls.extend([mode.loops(passes), mode.start()]);
    calls.extend(then);
    calls.extend([mode.ask_passes(), running(), stop(3, 3), wait(3)]);
    run(tick_us, 2, calls)
}

#[test]
fn knots_passes_and_the_end() {
    for mode in ALL {
        for tick_us in [50, 250, 1000] {
            let run = under_test(mode, tick_us, PASSES, vec![sleep(1.0), running(), wait(1)]);
            for pass in 0..PASSES {
                for (ms, pos) in KNOTS {
                    let at = f64::from(ms + 400 * pass);
                    let knot = Pos::pulses(pos as i32 + 2200 * pass);
                    assert_eq!(run.pos(0, at), knot, "{mode:?}, {tick_us} µs, knot at {at} ms");
                }
            }
            assert_eq!(run.end(0), Pos::pulses(2200 * PASSES), "{mode:?}: it ends where told");
            assert!(mode.passes(&run).is_none_or(|passes| passes == PASSES), "{mode:?} counts its passes");
            let curve = curve();
            run.is(0, &format!("{mode:?}, {tick_us} µs"), |t| curve.looped(t, PASSES.into()));
            let bits: Vec<i32> = run.items::<GetSts>().iter().map(|status| status.value.get() & 0x400).collect();
            assert_eq!(bits, [0x400, 0], "{mode:?}: running, then not");
        }
    }
}

#[test]
fn velocity_is_continuous_inside_a_pass_and_told_as_it_is() {
    for mode in ALL {
        let run = under_test(mode, 250, PASSES, vec![wait(1)]);
        // No step of velocity is larger than the steepest slope, 14/100, allows in a tick; a pass ends at rest.
        for ms in 0..4800 {
            let (now, next) = (run.vel(0, f64::from(ms) / 4.0), run.vel(0, f64::from(ms + 1) / 4.0));
            assert!(
                (next - now).abs() <= 0.14 * 0.25 + 1e-6,
                "{mode:?} at {} ms: {now} to {next}",
                f64::from(ms) / 4.0
            );
        }
        for (ms, vel) in [(50, 5.0), (100, 10.0), (175, 10.0), (300, 3.0), (350, -4.0), (375, -2.0)] {
            let found = run.vel(0, f64::from(ms + 400));
            assert!((found - vel).abs() <= 10.0 / 65536.0, "{mode:?} at {ms} ms of the second pass: {found}");
        }
    }
}

#[test]
fn stop_and_restart() {
    for mode in ALL {
        // In the middle of the second pass, at 10 pulse/ms: half of 10²/1 pulses further, 10 ms later.
        let then = vec![sleep(575.0), stop(1, 0), wait(1), running(), sleep(3.0), mode.start(), wait(1)];
        let run = if mode == PtDynamic {
            // What is left of a stream is cleared, and the next one counts from 0.
            let (core, profile) = (1.into(), AXIS.into());
            let data = KNOTS.map(|(ms, pos)| {
                Call::of(PtData { core, profile, pos: pos.into(), time_ms: ms.into(), kind: 0.into(), fifo: 0.into() })
            });
            let mut then = then;
            then.splice(5..5, data);
            under_test(mode, 250, PASSES, then)
        } else {
            let mut then = then;
            then.insert(5, mode.loops(1));
            under_test(mode, 250, PASSES, then)
        };
        let rest = run.pos(0, 587.0);
        let stopped = exact(rest) - exact(run.pos(0, 575.0));
        assert!((stopped - whole(50)) * (stopped - whole(50)) < whole(4), "{mode:?}: braked over {stopped} pulses");
        let from = run.rows.iter().rposition(|row| row.axes[0].pos == rest).unwrap();
        assert!(from > 587 * 4, "{mode:?}");
        // The whole curve once more, from where the axis stood.
        assert_eq!(run.end(0).0 - rest.0, Pos::pulses(2200).0, "{mode:?}");
        for (ms, pos) in KNOTS {
            let found = run.rows[from + 4 * ms as usize].axes[0].pos;
            assert_eq!(found.0 - rest.0, Pos::pulses(pos as i32).0, "{mode:?}: knot at {ms} ms after the restart");
        }
    }
}

#[test]
fn loops_do_not_drift() {
    // A tenth of a pulse in 333.3 ms (a master of 3.333 pulse/ms for a Follow of whole pulses: 1111 in 333.3 ms).
    for mode in [Pvt, FollowEx] {
        let (core, profile) = (1.into(), AXIS.into());
        let passes = 3000;
        let calls = match mode {
            Pvt => {
                let items = [(0.0, 0.0), (333.3, 0.1)].map(|(time, pos): (f64, f64)| PvtPercentPoint {
                    time: time.into(),
                    pos: pos.into(),
                    percent: 0.0.into(),
                });
                let head = PvtTablePercent {
                    core,
                    table: 1.into(),
                    count: 2.into(),
                    first: 0.into(),
                    vel_begin: 0.0003.into(),
                };
                vec![Call::of(PrfPvt { core, profile }), Call::with_items(head, &items)]
            }
            _ => {
                let mut calls = FollowEx.load();
                calls.splice(2..6, shaped_data(AXIS, 0, &[(333.3, 0.1, 1, 0)]));
                calls
            }
        };
        let mut all = calls;
        all.extend([mode.loops(passes), mode.start(), wait(1), mode.ask_passes(), stop(3, 3), wait(3)]);
        let run = run(1000, 2, all);
        assert_eq!(mode.passes(&run), Some(passes));
        // 3000 times the double 0.1 is 300 to far less than the last bit.
        assert_eq!(run.end(0).0, rounded(of(0.1) * whole(3000)), "{mode:?}");
    }
}
