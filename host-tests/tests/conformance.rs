//! One suite that every motion mode passes: knots exact, continuous where promised, ends where
//! reported, loops accumulate, stop and restart. Each mode gets the same curve in its own words;
//! Complete, whose acceleration has no steps, another one through the same knots. A master that
//! moves 1 pulse in 1 ms makes progress the time.
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
    PvtEx,
    PvtComplete,
    PvtPercent,
    PvtContinuous,
    Follow,
    FollowEx,
    /// Direction −1: a master that goes down makes progress.
    FollowDown,
    FollowExDown,
}
use Mode::{
    Follow, FollowDown, FollowEx, FollowExDown, PtDynamic, PtStatic, Pvt, PvtComplete, PvtContinuous, PvtEx, PvtPercent,
};

const ALL: [Mode; 11] = [
    PtStatic,
    PtDynamic,
    Pvt,
    PvtEx,
    PvtComplete,
    PvtPercent,
    PvtContinuous,
    Follow,
    FollowEx,
    FollowDown,
    FollowExDown,
];

/// Velocities at the knots, the first point's before them.
const VELOCITIES: [i64; 5] = [0, 10, 10, -4, 0];

/// A pass: cubics through the knots.
struct Pass {
    /// ms, pulses, pulse/ms.
    knots: Vec<(Rational, Rational, Rational)>,
}

impl Pass {
    /// What a mode makes of its data.
    fn of(mode: Mode) -> Pass {
        let points = std::iter::once((0, 0.0)).chain(KNOTS).map(|(ms, pos)| (whole(ms.into()), of(pos)));
        let (t, p): (Vec<Rational>, Vec<Rational>) = points.unzip();
        let velocities = if mode == PvtComplete { clamped(&t, &p) } else { VELOCITIES.map(whole).to_vec() };
        Pass { knots: t.into_iter().zip(p).zip(velocities).map(|((t, p), v)| (t, p, v)).collect() }
    }

    /// Position, velocity and acceleration at `t` of a pass.
    fn at(&self, t: Rational) -> [Rational; 3] {
        let last = self.knots.len() - 2;
        self.within((0..=last).rev().find(|i| self.knots[*i].0 <= t).unwrap_or(0), t)
    }

    /// The same by the cubic of segment `i`.
    fn within(&self, i: usize, t: Rational) -> [Rational; 3] {
        let ((t0, p0, v0), (t1, p1, v1)) = (self.knots[i], self.knots[i + 1]);
        let (length, x) = (t1 - t0, t - t0);
        let mean = (p1 - p0) / length;
        let c2 = (whole(3) * mean - whole(2) * v0 - v1) / length;
        let c3 = (v0 + v1 - whole(2) * mean) / (length * length);
        [
            p0 + (v0 + (c2 + c3 * x) * x) * x,
            v0 + (whole(2) * c2 + whole(3) * c3 * x) * x,
            whole(2) * c2 + whole(6) * c3 * x,
        ]
    }

    /// Position after `passes` of them at most.
    fn looped(&self, t: Rational, passes: i64) -> Rational {
        let (length, displacement, _) = self.knots[self.knots.len() - 1];
        let done = (t / length).floor();
        if done >= whole(passes) {
            return displacement * whole(passes);
        }
        if t < whole(0) { whole(0) } else { displacement * done + self.at(t - done * length)[0] }
    }

    /// The largest acceleration, which is at a knot.
    fn steepest(&self) -> Rational {
        let segments = 0..self.knots.len() - 1;
        let ends = segments.flat_map(|i| [i, i + 1].map(|end| self.within(i, self.knots[end].0)[2]));
        ends.map(|a| if a < whole(0) { -a } else { a }).max().unwrap()
    }
}

/// Velocities of the cubic spline that begins and ends at rest: v(i−1)/h + 2·(1/h + 1/g)·v(i) +
/// v(i+1)/g = 3·(d/h² + e/g²) for segments of lengths h, g and displacements d, e.
fn clamped(t: &[Rational], p: &[Rational]) -> Vec<Rational> {
    let mut rows = vec![(whole(0), whole(0))];
    for i in 1..t.len() - 1 {
        let (h, g) = (t[i] - t[i - 1], t[i + 1] - t[i]);
        let right = whole(3) * ((p[i] - p[i - 1]) / (h * h) + (p[i + 1] - p[i]) / (g * g));
        let (c, d) = rows[i - 1];
        let pivot = whole(2) * (h.recip() + g.recip()) - c / h;
        rows.push(((g * pivot).recip(), (right - d / h) / pivot));
    }
    let mut v = vec![whole(0)];
    for (c, d) in rows.into_iter().skip(1).rev() {
        v.push(d - c * v[v.len() - 1]);
    }
    v.push(whole(0));
    v.reverse();
    v
}

fn float(x: Rational) -> f64 {
    *x.numer() as f64 / *x.denom() as f64
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
        let master = |displacement: f64| {
            let profile = MASTER.into();
            vec![
                Call::of(PrfPt { core, profile, mode: 0.into() }),
                Call::of(PtData {
                    core,
                    profile,
                    pos: displacement.into(),
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
                let items: Vec<PvtPoint> = points
                    .zip(VELOCITIES)
                    .map(|((ms, pos), vel)| PvtPoint {
                        time: f64::from(ms).into(),
                        pos: pos.into(),
                        vel: (vel as f64).into(),
                    })
                    .collect();
                let (core, table, count, first) = table;
                vec![
                    Call::of(PrfPvt { core, profile }),
                    Call::with_items(PvtTable { core, table, count, first }, &items),
                ]
            }
            PvtEx => {
                // Each point with the velocities at both ends of the segment that it begins.
                let ends = VELOCITIES.iter().zip(VELOCITIES.iter().skip(1).chain([&0]));
                let items: Vec<PvtExPoint> = points
                    .zip(ends)
                    .map(|((ms, pos), (begin, end))| PvtExPoint {
                        time: f64::from(ms).into(),
                        pos: pos.into(),
                        vel_begin: (*begin as f64).into(),
                        vel_end: (*end as f64).into(),
                    })
                    .collect();
                let (core, table, count, first) = table;
                vec![
                    Call::of(PrfPvt { core, profile }),
                    Call::with_items(PvtTableEx { core, table, count, first }, &items),
                ]
            }
            PvtComplete => {
                let items: Vec<PvtKnot> =
                    points.map(|(ms, pos)| PvtKnot { time: f64::from(ms).into(), pos: pos.into() }).collect();
                let (core, table, count, first) = table;
                let head = PvtTableComplete { core, table, count, first, vel_begin: 0.0.into(), vel_end: 0.0.into() };
                vec![Call::of(PrfPvt { core, profile }), Call::with_items(head, &items)]
            }
            PvtContinuous => {
                // What takes each segment from one velocity to the next with nothing left to
                // cruise, but for the second.
                let rates = [(0.1, 0.1), (0.1, 0.1), (0.14, 0.14), (0.08, 0.08), (0.1, 0.1)];
                let items: Vec<PvtContinuousPoint> = points
                    .zip(VELOCITIES)
                    .zip(rates)
                    .map(|(((_, pos), vel), (acc, dec))| PvtContinuousPoint {
                        pos: pos.into(),
                        vel: (vel as f64).into(),
                        percent: 0.0.into(),
                        vel_max: 10.0.into(),
                        acc: acc.into(),
                        dec: dec.into(),
                    })
                    .collect();
                let (core, table, count, first) = table;
                vec![
                    Call::of(PrfPvt { core, profile }),
                    Call::with_items(PvtTableContinuous { core, table, count, first, time_begin: 0.0.into() }, &items),
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
            Follow | FollowDown => {
                let sign = if self == FollowDown { -1 } else { 1 };
                let data = KNOTS.map(|(ms, pos)| (sign * ms, pos, 0));
                let direction = if self == FollowDown { -1 } else { 0 };
                [follow(AXIS, MASTER, direction), follow_data(AXIS, 0, &data), master(1e6 * f64::from(sign))].concat()
            }
            FollowEx | FollowExDown => {
                let sign = if self == FollowExDown { -1 } else { 1 };
                let data = KNOTS.map(|(ms, pos)| (f64::from(sign * ms), pos, 0, 0));
                [follow_ex(AXIS, MASTER, sign as i16), shaped_data(AXIS, 0, &data), master(1e6 * f64::from(sign))]
                    .concat()
            }
        }
    }

    fn loops(self, count: i32) -> Call {
        let (core, profile, loop_count) = (1.into(), AXIS.into(), count.into());
        match self {
            PtStatic => Call::of(SetPtLoop { core, profile, loop_count }),
            // It says what it has.
            PtDynamic => Call::of(GetPtState { core, profile }),
            Pvt | PvtEx | PvtComplete | PvtPercent | PvtContinuous => {
                Call::of(SetPvtLoop { core, profile, loop_count })
            }
            Follow | FollowDown => Call::of(SetFollowLoop { core, profile, loop_count }),
            FollowEx | FollowExDown => Call::of(SetFollowLoopEx { core, profile, loop_count }),
        }
    }

    fn start(self) -> Call {
        let (core, mask, option) = (1.into(), (1 << (AXIS - 1)).into(), 0.into());
        match self {
            PtStatic | PtDynamic => Call::of(PtStart { core, mask, option }),
            Pvt | PvtEx | PvtComplete | PvtPercent | PvtContinuous => Call::of(PvtStart { core, mask }),
            Follow | FollowDown => Call::of(FollowStart { core, mask, option }),
            FollowEx | FollowExDown => Call::of(FollowStartEx { core, mask, option }),
        }
    }

    /// Passes completed, where the mode counts them.
    fn passes(self, run: &Run) -> Option<i32> {
        match self {
            PtStatic => Some(run.replies::<GetPtLoop>().last()?.value.get()),
            PtDynamic => None,
            Pvt | PvtEx | PvtComplete | PvtPercent | PvtContinuous => {
                Some(run.replies::<GetPvtLoop>().last()?.loop_count.get())
            }
            Follow | FollowDown => Some(run.replies::<GetFollowLoop>().last()?.value.get()),
            FollowEx | FollowExDown => Some(run.replies::<GetFollowLoopEx>().last()?.value.get()),
        }
    }

    fn ask_passes(self) -> Call {
        let (core, profile) = (1.into(), AXIS.into());
        match self {
            PtStatic => Call::of(GetPtLoop { core, profile }),
            PtDynamic => Call::of(GetPtState { core, profile }),
            Pvt | PvtEx | PvtComplete | PvtPercent | PvtContinuous => Call::of(GetPvtLoop { core, profile }),
            Follow | FollowDown => Call::of(GetFollowLoop { core, profile }),
            FollowEx | FollowExDown => Call::of(GetFollowLoopEx { core, profile }),
        }
    }
}

fn running() -> Call {
    Call::of(GetSts { core: 1.into(), axis: AXIS.into(), count: 1.into() })
}

/// Runs it with `then` after the start, and stops the master.
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
            assert_eq!(run.end(0), Pos::pulses(2200 * PASSES), "{mode:?}: it ends at its target");
            assert!(mode.passes(&run).is_none_or(|passes| passes == PASSES), "{mode:?} counts its passes");
            let pass = Pass::of(mode);
            run.is(0, &format!("{mode:?}, {tick_us} µs"), |t| pass.looped(t, PASSES.into()));
            let bits: Vec<i32> = run.items::<GetSts>().iter().map(|status| status.value.get() & 0x400).collect();
            assert_eq!(bits, [0x400, 0], "{mode:?}: running, then not");
        }
    }
}

#[test]
fn velocity_is_continuous_inside_a_pass_and_reported_as_it_is() {
    for mode in ALL {
        let run = under_test(mode, 250, PASSES, vec![wait(1)]);
        // No step of velocity is larger than the steepest slope allows in a tick; a pass ends at
        // rest.
        let pass = Pass::of(mode);
        let most = float(pass.steepest()) * 0.25 + 1e-6;
        for ms in 0..4800 {
            let (now, next) = (run.vel(0, f64::from(ms) / 4.0), run.vel(0, f64::from(ms + 1) / 4.0));
            assert!((next - now).abs() <= most, "{mode:?} at {} ms: {now} to {next}", f64::from(ms) / 4.0);
        }
        for ms in [50, 100, 175, 300, 350, 375] {
            let (found, vel) = (run.vel(0, f64::from(ms + 400)), float(pass.at(whole(ms.into()))[1]));
            assert!(
                (found - vel).abs() <= 10.0 / 65536.0,
                "{mode:?} at {ms} ms of the second pass: {found}, not {vel}"
            );
        }
    }
}

#[test]
fn stop_and_restart() {
    for mode in ALL {
        // In the middle of the second pass: half of v²/1 pulses further, v ms later; that is 10 ms,
        // or less than 12.
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
        let speed = Pass::of(mode).at(whole(175))[1];
        let off = stopped - speed * speed / whole(2);
        assert!(off * off < whole(4), "{mode:?}: braked over {stopped} pulses");
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
    // A tenth of a pulse in 333.3 ms (a master of 3.333 pulse/ms for a Follow of whole pulses: 1111
    // in 333.3 ms).
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
