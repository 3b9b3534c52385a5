//! FollowEx through the client and the virtual controller, against exact arithmetic: S-shaped
//! ratios, entries between segments, switches at once. The master jogs at 50 pulse/ms as in the
//! tests of Follow.
mod motion;
use client::Call;
use motion::*;
use protocol::command::*;
use servo::units::Pos;

const BOTH: i32 = 0b11;
const SLAVE: i32 = 0b10;

fn start_ex() -> Call {
    Call::of(FollowStartEx { core: 1.into(), mask: SLAVE.into(), option: 0.into() })
}

fn loops_ex(count: i32) -> Call {
    Call::of(SetFollowLoopEx { core: 1.into(), profile: 2.into(), loop_count: count.into() })
}

fn output(index: i16, value: i16) -> Call {
    let (core, profile, fifo) = (1.into(), 2.into(), 0.into());
    Call::of(FollowDoBitEx { core, profile, do_type: 12.into(), index: index.into(), value: value.into(), fifo })
}

fn delay(cycles: u32) -> Call {
    Call::of(FollowDelayEx { core: 1.into(), profile: 2.into(), delay_cycles: cycles.into(), fifo: 0.into() })
}

fn input(index: i16, value: i16, time_ms: u32) -> Call {
    let (core, profile, fifo) = (1.into(), 2.into(), 0.into());
    let (di_type, time_ms) = (4.into(), time_ms.into());
    Call::of(FollowDiBitEx { core, profile, di_type, index: index.into(), value: value.into(), time_ms, fifo })
}

fn switch_now(method: i16, buffer: i16, fifo: i16) -> Call {
    Call::of(FollowSwitchNowEx {
        core: 1.into(),
        profile: 2.into(),
        method: method.into(),
        buffer: buffer.into(),
        fifo: fifo.into(),
    })
}

fn outputs() -> Call {
    Call::of(GetDo { core: 1.into(), do_type: 12.into() })
}

fn status() -> Call {
    Call::of(AxisStatus { core: 1.into(), axis: 2.into(), count: 1.into() })
}

/// The end: master and slave stop at once.
fn halt() -> [Call; 2] {
    [stop(BOTH, BOTH), wait(BOTH)]
}

#[test]
fn ratios_in_the_shape_of_an_s() {
    // Fractions of pulses on both sides; percentages of every kind; to and fro.
    let data: [Shaped; 6] = [
        (4000.5, 2000.25, 0, 0),
        (9000.75, 7000.125, 0, 100),
        (12000.25, 9000.5, 2, 37),
        (15000.0, 9750.0, 0, 1),
        (20000.0, 9750.0, 0, 99),
        (24000.0, 6000.0, 1, 50),
    ];
    let curve = Curve::new(&data, whole(0));
    for (dir, tick_us) in [(0, 250), (1, 1000), (0, 50)] {
        let mut calls = follow_ex(2, 1, dir);
        calls.extend(shaped_data(2, 0, &data));
        calls.extend([loops_ex(2), start_ex()]);
        calls.extend(jog(1, 50.0, 1.0));
        calls.extend([wait(SLAVE), Call::of(GetFollowLoopEx { core: 1.into(), profile: 2.into() })]);
        calls.extend(halt());
        let run = run(tick_us, 2, calls);
        let master = jogged(50.0, 1.0);
        run.is(1, "the slave", |t| curve.looped(master(t), 2));
        assert_eq!(run.end(1), Pos::pulses(12000));
        assert_eq!(run.replies::<GetFollowLoopEx>()[0].value.get(), 2);
    }
}

#[test]
fn entries_hold_the_slave_and_what_follows_begins_where_the_master_is() {
    // Ends at 5000.5 after 125.01 ms; the delay of 401 cycles (100.25 ms) makes 5012.5 pulses of
    // the master.
    let first: [Shaped; 2] = [(2500.0, 1250.0, 0, 60), (5000.5, 2500.0, 2, 60)];
    let then: [Shaped; 2] = [(7500.5, 3750.0, 0, 60), (10000.5, 5000.0, 2, 60)];
    for tick_us in [250, 1000] {
        let mut calls = follow_ex(2, 1, 1);
        calls.extend(shaped_data(2, 0, &first));
        calls.extend([output(3, 1), output(4, 1), delay(401), output(3, 0)]);
        // The input is low, as asked for: nothing to wait for.
        calls.push(input(1, 0, 1));
        calls.extend(shaped_data(2, 0, &then));
        calls.extend([start_ex(), outputs()]);
        calls.extend(jog(1, 50.0, 1.0));
        calls.extend([sleep(120.0), outputs(), sleep(10.0), outputs(), sleep(110.0), outputs(), wait(SLAVE)]);
        calls.extend(halt());
        let run = run(tick_us, 2, calls);
        let (one, two) =
            (Curve::new(&first, whole(0)), Curve::new(&[(2500.0, 1250.0, 0, 60), (5000.0, 2500.0, 2, 60)], whole(0)));
        let master = jogged(50.0, 1.0);
        let held = of(5000.5) + Rational::new(401 * 50, 4);
        run.is(1, "the slave", |t| {
            let p = master(t);
            if p < of(5000.5) { one.at(p).0 } else { whole(2500) + two.looped(p - held, 1) }
        });
        assert_eq!(run.end(1), Pos::pulses(5000));
        let levels: Vec<i32> = run.replies::<GetDo>().iter().map(|reply| reply.value.get()).collect();
        assert_eq!(levels, [0, 0, 0b1100, 0b1000]);
    }
}

#[test]
fn a_wait_that_times_out_ends_the_motion_and_says_so() {
    let first: [Shaped; 1] = [(5000.0, 2500.0, 0, 100)];
    let mut calls = follow_ex(2, 1, 0);
    calls.extend(shaped_data(2, 0, &first));
    calls.push(input(32, 1, 40));
    calls.extend(shaped_data(2, 0, &[(9000.0, 9000.0, 0, 0)]));
    calls.extend([loops_ex(0), start_ex()]);
    calls.extend(jog(1, 50.0, 1.0));
    calls.extend([sleep(160.0), status(), sleep(20.0), status()]);
    calls.extend(halt());
    let run = run(250, 2, calls);
    let states: Vec<(u32, u16)> =
        run.items::<AxisStatus>().iter().map(|item| (item.status.get() & 0x400, item.reason.get())).collect();
    assert_eq!(states, [(0x400, 0), (0, servo::view::StopReason::WaitTimeout as u16)]);
    assert_eq!(run.end(1), Pos::pulses(2500));
}

#[test]
fn a_switch_to_the_next_segment_goes_on_at_the_ratio_of_its_instant() {
    // Ratio 0.5 for a long way; the next segment would begin at 0.5, too, and goes to 1.
    let data: [Shaped; 3] =
        [(1_000_000.0, 500_000.0, 1, 0), (1_004_000.0, 503_000.0, 0, 50), (2_004_000.0, 1_503_000.0, 1, 0)];
    let mut calls = follow_ex(2, 1, 0);
    calls.extend(shaped_data(2, 0, &data));
    calls.push(start_ex());
    calls.extend(jog(1, 50.0, 1.0));
    calls.extend([sleep(300.0), switch_now(1, 0, 0), sleep(300.0), switch_now(1, 0, 0), sleep(10.0), status()]);
    calls.extend(halt());
    let run = run(250, 2, calls);
    let master = jogged(50.0, 1.0);
    // The tick on which the call acts has the position of 300 ms.
    let (at, origin) = (master(whole(300)), master(whole(300)) / whole(2));
    let next = Curve::new(&[(4000.0, 3000.0, 3, 50)], Rational::new(1, 2));
    assert_eq!(next.end_ratio(), whole(1));
    let stopped = run.before(610);
    run.is(1, "the slave", |t| {
        let p = master(t.min(stopped));
        if p < at {
            p / whole(2)
        } else if p - at < whole(4000) {
            origin + next.at(p - at).0
        } else {
            // Even, until the second call ends the pass: it is the last segment, and one pass was
            // reported.
            let end = master(whole(600)).min(p);
            origin + whole(3000) + (end - at - whole(4000))
        }
    });
    assert_eq!(run.items::<AxisStatus>()[0].status.get() & 0x400, 0, "in the last segment it ends the pass");
}

#[test]
fn a_switch_to_the_other_fifo_at_once_or_when_it_is_reached() {
    for queued in [false, true] {
        let mut calls = follow_ex(2, 1, 0);
        if queued {
            calls.extend(shaped_data(2, 0, &[(13_750.0, 6875.0, 1, 0)]));
            calls.push(switch_now(2, 1, 0));
        }
        calls.extend(shaped_data(2, 0, &[(90_000.0, 45_000.0, 1, 0)]));
        // From 0.5 to 0 in an S, then on at −0.25.
        let other: [Shaped; 2] = [(4000.0, 1000.0, 3, 100), (8000.0, 0.0, 1, 0)];
        calls.extend(shaped_data(2, 1, &other));
        let space = |fifo: i16| Call::of(FollowSpaceEx { core: 1.into(), profile: 2.into(), fifo: fifo.into() });
        let state = || Call::of(GetFollowStatusEx { core: 1.into(), profile: 2.into() });
        calls.extend([start_ex(), state()]);
        calls.extend(jog(1, 50.0, 1.0));
        calls.push(sleep(300.0));
        if !queued {
            // The master is at 13750 then.
            calls.push(switch_now(2, 0, 0));
        }
        calls.extend([sleep(1.0), state(), space(0), space(1), wait(SLAVE)]);
        calls.extend(halt());
        let run = run(250, 2, calls);
        let master = jogged(50.0, 1.0);
        let then = Curve::new(&other, Rational::new(1, 2));
        run.is(1, if queued { "queued" } else { "at once" }, |t| {
            let p = master(t);
            if p < whole(13_750) { p / whole(2) } else { whole(6875) + then.looped(p - whole(13_750), 1) }
        });
        let states: Vec<i16> = run.replies::<GetFollowStatusEx>().iter().map(|state| state.fifo.get()).collect();
        let spaces: Vec<i16> = run.replies::<FollowSpaceEx>().iter().map(|space| space.value.get()).collect();
        assert_eq!((states, spaces), (vec![0, 1], vec![16, 14]), "the FIFO that was left is empty");
        assert_eq!(run.end(1), Pos::pulses(6875));
    }
}

#[test]
fn the_asymmetric_s() {
    // Ratio 0 to 1 with 60 % of S in all: a mean of 4/9 needs x = (1/2 − q²/6 − f(1 − q/2))/(1/2 −
    // q/3) = 58/135 of it at its beginning. Then back to 0 with all of the S at the end, a mean of
    // 2/3.
    let piece = |master: f64, slave: f64, begin: f64, end: f64, percent: i16| {
        Call::of(FollowDataPercent2Ex {
            core: 1.into(),
            profile: 2.into(),
            master_segment: master.into(),
            slave_segment: slave.into(),
            vel_begin_ratio: begin.into(),
            vel_end_ratio: end.into(),
            percent: percent.into(),
            fifo: 0.into(),
        })
    };
    let mut calls = follow_ex(2, 1, 0);
    calls.extend([piece(9000.0, 4000.0, 0.0, 1.0, 60), piece(12_000.0, 6000.0, 1.0, 0.0, 100), start_ex()]);
    calls.extend(jog(1, 50.0, 1.0));
    calls.push(wait(SLAVE));
    calls.extend(halt());
    let run = run(250, 2, calls);
    let reported: Vec<(u16, i16)> =
        run.replies::<FollowDataPercent2Ex>().iter().map(|reply| (reply.space.get(), reply.percent1.get())).collect();
    // Both were entered at the same instant.
    assert_eq!(reported, [(12, 43), (12, 100)]);
    let (q, x) = (Rational::new(3, 5), Rational::new(58, 135));
    let slope = whole(1) / (whole(1) - q / whole(2));
    // The slope's second integral, part by part.
    let first = |u: Rational| {
        let y = q - x;
        let rise = |u: Rational| slope * u * u * u / (whole(6) * x);
        let held = |u: Rational| rise(x) + slope * x / whole(2) * (u - x) + slope * (u - x) * (u - x) / whole(2);
        let corner = whole(1) - y;
        if u < x {
            rise(u)
        } else if u < corner {
            held(u)
        } else {
            let w = u - corner;
            let ratio = slope * (corner - x / whole(2));
            held(corner) + ratio * w + slope * w * w / whole(2) - slope * w * w * w / (whole(6) * y)
        }
    };
    assert_eq!(first(whole(1)), Rational::new(4, 9));
    // The slope grows from 0 to −2 all the way: 1 − u².
    let second = |u: Rational| u - u * u * u / whole(3);
    let master = jogged(50.0, 1.0);
    run.is(1, "the slave", |t| {
        let p = master(t);
        if p < whole(9000) {
            first(p / whole(9000)) * whole(9000)
        } else {
            whole(4000) + second(((p - whole(9000)) / whole(3000)).min(whole(1))) * whole(3000)
        }
    });
    assert_eq!(run.end(1), Pos::pulses(6000));
}
