//! Follow through the client and the virtual controller: the tables of GXN chapter 3 by hand and in
//! exact arithmetic. The master jogs at 50 pulse/ms, which it reaches with 1 pulse/ms² after 50 ms
//! at 1250 pulses, so that it is at p pulses after 25 + p/50 ms.
mod motion;
use client::Call;
use motion::*;
use protocol::command::*;
use servo::units::Pos;

const BOTH: i32 = 0b11;
const SLAVE: i32 = 0b10;

/// When the master is at `pulses`, ms.
fn when(pulses: i32) -> f64 {
    25.0 + f64::from(pulses) / 50.0
}

fn status(axis: i16) -> Call {
    Call::of(GetFollowStatus { core: 1.into(), profile: axis.into() })
}

fn loops_done(axis: i16) -> Call {
    Call::of(GetFollowLoop { core: 1.into(), profile: axis.into() })
}

/// Table 3-2.
const REGION_1: [Datum; 1] = [(5000, 2500.0, 0)];
/// Table 3-3, its first segment going on from region 1.
const REGION_2: [Datum; 5] =
    [(1000, 1000.0, 3), (4000, 3400.0, 0), (6000, 4600.0, 0), (9000, 7000.0, 0), (10000, 8000.0, 0)];

#[test]
fn tables_3_2_and_3_3_flying_shear() {
    for tick_us in [250, 1000] {
        let mut calls = follow(2, 1, 0);
        calls.extend(follow_data(2, 0, &REGION_1));
        calls.extend(follow_data(2, 1, &REGION_2));
        calls.extend([follow_loops(2, 0), follow_start(SLAVE, 0), follow_switch(SLAVE), status(2)]);
        calls.extend(jog(1, 50.0, 1.0));
        calls.extend([sleep(900.0), status(2), loops_done(2), follow_space(2, 0), stop(BOTH, BOTH), wait(BOTH)]);
        let run = run(tick_us, 2, calls);

        // By hand: 2500 at 5000, then 8000 for every 10000, through every point of the table.
        assert_eq!(run.pos(1, when(5000)), Pos::pulses(2500));
        for cut in 0..4 {
            for (master, slave, _) in REGION_2 {
                let at = when(5000 + 10000 * cut + master);
                if at < 900.0 {
                    assert_eq!(run.pos(1, at), Pos::pulses(2500 + 8000 * cut + slave as i32), "cut {cut}, {master}");
                }
            }
        }
        // Ratios 0 to 1; 1; 1 to 0.6; 0.6; 0.6 to 1; 1: as velocities at 50 pulse/ms of the belt,
        // at ends and middles.
        for (master, ratio) in [
            (2500, 0.5),
            (5000, 1.0),
            (5500, 1.0),
            (6000, 1.0),
            (7500, 0.8),
            (9000, 0.6),
            (10000, 0.6),
            (11000, 0.6),
            (12500, 0.8),
            (14000, 1.0),
            (14500, 1.0),
            (15000, 1.0),
            (17500, 0.8),
        ] {
            let found = run.vel(1, when(master)) / 50.0;
            assert!((found - ratio).abs() < 1e-9, "{found} at {master}");
        }
        // And everywhere in exact arithmetic.
        let (belt, first) = (jogged(50.0, 1.0), Curve::plain(&REGION_1, whole(0)));
        assert_eq!(first.end_ratio(), whole(1));
        let second = Curve::plain(&REGION_2, first.end_ratio());
        assert_eq!(second.end_ratio(), whole(1));
        run.is(1, "the knife", |t| {
            let p = belt(t.min(run.before(900)));
            if p < whole(5000) { first.at(p).0 } else { whole(2500) + second.looped(p - whole(5000), 0) }
        });
        let reported: Vec<(i16, i16)> = run
            .replies::<GetFollowStatus>()
            .iter()
            .map(|status| (status.fifo.get(), status.switch_status.get()))
            .collect();
        assert_eq!(reported, [(0, 1), (1, 0)]);
        assert_eq!(run.replies::<GetFollowLoop>()[0].value.get(), 3);
        assert_eq!(run.replies::<FollowSpace>()[0].value.get(), 16, "the FIFO that was left is empty");
    }
}

/// Table 3-4, as positions.
const SINGLE: [Datum; 3] = [(20000, 10000.0, 0), (40000, 30000.0, 0), (60000, 40000.0, 0)];

#[test]
fn table_3_4_single_fifo_after_a_crossing() {
    // The second crossing lies between two ticks: 50007 pulses after 1025.14 ms.
    for (tick_us, crossing) in [(250, 50_000), (1000, 50_000), (250, 50_007)] {
        let mut calls = jog(1, 50.0, 1.0);
        calls.extend(follow(2, 1, 0));
        calls.extend(follow_data(2, 0, &SINGLE));
        calls.extend([follow_loops(2, 0), follow_event(2, 2, 1, crossing), follow_start(SLAVE, 0)]);
        calls.extend([sleep(1000.0), Call::of(GetSts { core: 1.into(), axis: 2.into(), count: 1.into() })]);
        calls.extend([sleep(2600.0), loops_done(2), stop(BOTH, BOTH), wait(BOTH)]);
        let run = run(tick_us, 2, calls);
        if crossing == 50_000 {
            let at = |master: i32| run.pos(1, when(50_000 + master));
            assert_eq!(at(0), Pos(0));
            for pass in 0..2 {
                for (master, slave, _) in SINGLE {
                    assert_eq!(at(60_000 * pass + master), Pos::pulses(40_000 * pass + slave as i32));
                }
            }
            // 0 to 1, 1, 1 to 0.
            for (master, ratio) in [(0, 0.0), (10_000, 0.5), (20_000, 1.0), (30_000, 1.0), (50_000, 0.5)] {
                let found = run.vel(1, when(50_000 + master)) / 50.0;
                assert!((found - ratio).abs() < 1e-9, "{found} at {master}");
            }
        }
        let (master, curve) = (jogged(50.0, 1.0), Curve::plain(&SINGLE, whole(0)));
        run.is(1, "the slave", |t| curve.looped(master(t.min(run.before(3600))) - whole(crossing.into()), 0));
        assert_eq!(run.replies::<GetFollowLoop>()[0].value.get(), 2);
        // While it waits for the crossing it counts as running.
        assert_eq!(run.items::<GetSts>()[0].value.get() & 0x400, 0x400);
    }
}

/// Tables 3-6 and 3-7.
const TRANSITION: [Datum; 3] = [(20000, 10000.0, 3), (40000, 30000.0, 0), (60000, 46000.0, 0)];
const AFTER: [Datum; 3] = [(20000, 16000.0, 3), (40000, 36000.0, 0), (60000, 52000.0, 0)];

#[test]
fn tables_3_5_to_3_7_two_fifos() {
    for tick_us in [250, 1000] {
        let mut calls = jog(1, 50.0, 1.0);
        calls.extend(follow(2, 1, 0));
        let clear = |fifo: i16| Call::of(FollowClear { core: 1.into(), profile: 2.into(), fifo: fifo.into() });
        calls.extend([clear(0), clear(1), follow_space(2, 0)]);
        calls.extend(follow_data(2, 0, &SINGLE)); // table 3-5 is the same as 3-4
        calls.extend([follow_loops(2, 0), follow_event(2, 1, 1, 0), follow_start(SLAVE, 0), sleep(1800.0), clear(1)]);
        calls.extend(follow_data(2, 1, &TRANSITION));
        calls.extend([follow_switch(SLAVE), follow_space(2, 0), sleep(1000.0), follow_space(2, 0)]);
        calls.extend(follow_data(2, 0, &AFTER));
        calls.extend([follow_switch(SLAVE), sleep(1000.0), follow_space(2, 1), sleep(1400.0)]);
        calls.extend([loops_done(2), stop(BOTH, BOTH), wait(BOTH)]);
        let run = run(tick_us, 2, calls);
        let spaces: Vec<i16> = run.replies::<FollowSpace>().iter().map(|space| space.value.get()).collect();
        assert_eq!(spaces, [16, 13, 16, 16]);
        assert_eq!(run.replies::<GetFollowLoop>()[0].value.get(), 1, "passes of the new curve");

        // By hand: two passes of 40000, one of 46000, then 52000 each; where they meet the ratios
        // are equal.
        let at = |master: i32| run.pos(1, when(master));
        assert_eq!([at(60_000), at(120_000)], [40_000, 80_000].map(Pos::pulses));
        assert_eq!([at(140_000), at(160_000), at(180_000)], [90_000, 110_000, 126_000].map(Pos::pulses));
        assert_eq!([at(200_000), at(220_000), at(240_000)], [142_000, 162_000, 178_000].map(Pos::pulses));
        for (master, ratio) in [
            (120_000, 0.0),
            (140_000, 1.0),
            (170_000, 0.8),
            (180_000, 0.6),
            (200_000, 1.0),
            (240_000, 0.6),
            (250_000, 0.8),
        ] {
            let found = run.vel(1, when(master)) / 50.0;
            assert!((found - ratio).abs() < 1e-9, "{found} at {master}");
        }
        let master = jogged(50.0, 1.0);
        let old = Curve::plain(&SINGLE, whole(0));
        let transition = Curve::plain(&TRANSITION, old.end_ratio());
        let after = Curve::plain(&AFTER, transition.end_ratio());
        assert_eq!((transition.end_ratio(), after.end_ratio()), (Rational::new(3, 5), Rational::new(3, 5)));
        run.is(1, "the slave", |t| {
            let p = master(t.min(run.before(5200)));
            if p < whole(120_000) {
                old.looped(p, 0)
            } else if p < whole(180_000) {
                whole(80_000) + transition.at(p - whole(120_000)).0
            } else {
                whole(126_000) + after.looped(p - whole(180_000), 0)
            }
        });
    }
}

#[test]
fn figure_3_1_one_synchronous_region() {
    // Begins when the master passes 1000; at 1500 the slave has gone 250 at ratio 1; then
    // synchronous until 2250.
    let data: [Datum; 3] = [(500, 250.0, 0), (1250, 1000.0, 0), (1750, 1250.0, 0)];
    let mut calls = jog(1, 50.0, 1.0);
    calls.extend(follow(2, 1, 1));
    calls.extend(follow_data(2, 0, &data));
    calls.extend([follow_event(2, 2, 1, 1000), follow_start(SLAVE, 0), wait(SLAVE), loops_done(2)]);
    calls.extend([Call::of(GetSts { core: 1.into(), axis: 2.into(), count: 1.into() }), stop(1, 1), wait(BOTH)]);
    let run = run(250, 2, calls);
    // The master is still on its ramp: p = t²/2.
    let curve = Curve::plain(&data, whole(0));
    let master = jogged(50.0, 1.0);
    run.is(1, "the slave", |t| curve.looped(master(t) - whole(1000), 1));
    assert_eq!(run.end(1), Pos::pulses(1250), "one pass: the power-on value of the loop count");
    assert_eq!(run.replies::<GetFollowLoop>()[0].value.get(), 1);
    assert_eq!(run.items::<GetSts>()[0].value.get() & 0x400, 0);
}

#[test]
fn a_chain_of_eight_in_reverse_order_has_no_lag() {
    // Axis 8 jogs, 7 follows it, 6 follows 7 and so on: all at ratio 1, so all are in the same
    // place in every tick.
    let mut calls = Vec::new();
    for axis in (1..8).rev() {
        calls.extend(follow(axis, axis + 1, if axis % 2 == 0 { 0 } else { 1 }));
        calls.extend(follow_data(axis, 0, &[(1_000_000, 1_000_000.0, 1)]));
    }
    calls.push(follow_start(0x7f, 0));
    calls.extend(jog(8, 50.0, 1.0));
    calls.extend([sleep(100.0), stop(0x80, 0), wait(0x80), stop(0x7f, 0x7f), wait(0x7f)]);
    let run = run(250, 8, calls);
    assert_eq!(run.end(7), Pos::pulses(5000));
    for row in &run.rows {
        assert!(row.axes.iter().all(|axis| axis.pos == row.axes[7].pos), "at {} ns", row.t_ns);
    }
}

#[test]
fn an_encoder_and_an_axis_of_the_other_core_are_followed() {
    // The encoder of the virtual machine lags behind its axis and ends on the whole pulse where
    // that rests; there a slave of ratio 2 is at twice that. The axis of core 2 follows the planned
    // position without a lag.
    let mut calls = Vec::new();
    let slave = |core: i16, axis: i16, kind: i16| {
        let (core, profile) = (core.into(), axis.into());
        [
            Call::of(AxisOn { core, axis: axis.into() }),
            Call::of(LmtsOff { core, axis: axis.into(), limit_type: (-1).into() }),
            Call::of(PrfFollow { core, profile, dir: 0.into() }),
            Call::of(SetFollowMaster {
                core,
                profile,
                master_index: 1.into(),
                master_type: kind.into(),
                master_item: 0.into(),
            }),
            Call::of(FollowData {
                core,
                profile,
                master_segment: 100_000.into(),
                slave_segment: 200_000.0.into(),
                kind: 1.into(),
                fifo: 0.into(),
            }),
            Call::of(FollowStart { core, mask: (1 << (axis - 1)).into(), option: 0.into() }),
        ]
    };
    calls.extend(slave(1, 2, 1));
    calls.extend(slave(2, 3, 103));
    calls.extend(slave(2, 4, 101));
    calls.extend(jog(1, 50.0, 1.0));
    calls.extend([sleep(100.0), stop(1, 0), wait(1), sleep(50.0)]);
    let at = |core: i16, axis: i16| Call::of(GetPrfPos { core: core.into(), profile: axis.into(), count: 1.into() });
    calls.extend([at(1, 1), at(1, 2), at(2, 3), at(2, 4), stop(2, 2)]);
    calls.push(Call::of(Stop { core: 2.into(), mask: 12.into(), option: 12.into(), form: 0 }));
    calls.push(wait(2));
    let run = run_on(1, 250, 2, calls);
    let found: Vec<f64> = run.items::<GetPrfPos>().iter().map(|item| item.value.get()).collect();
    assert_eq!(found[0], 5000.0, "2500 on its way, 1250 on each ramp");
    assert_eq!(found[1..], [10_000.0; 3]);
    // The slave of the encoder is behind while the master moves.
    let middle = &run.rows[300].axes;
    assert!(middle[1].pos.0 < 2 * middle[0].pos.0 && middle[1].pos.0 > middle[0].pos.0);
}
