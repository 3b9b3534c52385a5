//! Every bad input of coordinate systems: code, reason, the parameter and its limit, and that
//! nothing has changed.

use crate::bench;
use bench::crd::*;
use bench::*;
use protocol::command::*;
use protocol::reason::{Reason, describe_opcode};
use protocol::record::Lane;

type Bad = (u16, Vec<u8>, i16, &'static str);

fn bad<R: Request>(request: R, code: i16, text: &'static str) -> Bad {
    (R::OPCODE, body::<R>(request, &[]), code, text)
}

/// What a client can see of coordinate system 1.
fn state(bench: &mut Bench<8>) -> (Vec<u8>, Vec<u8>, i32) {
    let info = bench.call(CrdInfo { core: 1.into(), crd: 1.into() });
    let prm = bench.call(GetCrdPrm { core: 1.into(), crd: 1.into() });
    (info.body, prm.body, bench.status_word(3))
}

fn check(bench: &mut Bench<8>, table: &[Bad]) {
    for (opcode, body, code, text) in table {
        let before = state(bench);
        let tag = bench.post_raw(*opcode, Lane::Immediate, body);
        let answer = bench.wait(tag);
        assert_ne!(answer.code, 0, "not refused: {text}");
        let reported = describe_opcode(*opcode, answer.refusal()).to_string();
        assert_eq!((answer.code, reported.as_str()), (*code, *text));
        assert_eq!(state(bench), before, "changed something: {text}");
    }
}

fn elements<const N: usize>(given: [i16; N]) -> [zerocopy::little_endian::I16; 8] {
    let mut profile = [0.into(); 8];
    profile.iter_mut().zip(given).for_each(|(place, value)| *place = value.into());
    profile
}

#[test]
fn parameters_of_a_coordinate_system() {
    let mut bench = Bench::gus();
    let p = prm();
    check(
        &mut bench,
        &[
            bad(line(1, 1, 1.0, 1.0), 1, "LnXY: coordinate system 1 drives no axis; call SetCrdPrm first"),
            bad(start_crd(1), 1, "CrdStart: coordinate system 1 drives no axis; call SetCrdPrm first"),
            bad(clear(0), 1, "CrdClear: coordinate system 1 drives no axis; call SetCrdPrm first"),
            bad(SetCrdPrm { crd: 3.into(), ..p }, 7, "SetCrdPrm: crd is 3; allowed are 1 to 2"),
            bad(SetCrdPrm { crd: 0.into(), ..p }, 7, "SetCrdPrm: crd is 0; allowed are 1 to 2"),
            bad(SetCrdPrm { core: 2.into(), ..p }, 7, "SetCrdPrm: core is 2; it must be 1"),
            bad(SetCrdPrm { dimension: 0.into(), ..p }, 7, "SetCrdPrm: dimension is 0; it must be from 1 to 4"),
            bad(SetCrdPrm { dimension: 5.into(), ..p }, 7, "SetCrdPrm: dimension is 5; it must be from 1 to 4"),
            bad(SetCrdPrm { profile: elements([1, 3]), ..p }, 7, "SetCrdPrm: profile[1] is 3; allowed are 0 to 2"),
            bad(SetCrdPrm { profile: elements([1, -1]), ..p }, 7, "SetCrdPrm: profile[1] is -1; allowed are 0 to 2"),
            bad(
                SetCrdPrm { profile: elements([1, 2, 0, 1]), ..p },
                7,
                "SetCrdPrm: profile[3]: two axes drive coordinate 1",
            ),
            bad(
                SetCrdPrm { profile: elements([0, 2]), ..p },
                7,
                "SetCrdPrm: profile: no axis drives coordinate 1; dimension is 2",
            ),
            bad(
                SetCrdPrm { syn_vel_max: 0.0.into(), ..p },
                7,
                "SetCrdPrm: syn_vel_max is 0; it must be above 0 and below 32767",
            ),
            bad(
                SetCrdPrm { syn_vel_max: 32767.0.into(), ..p },
                7,
                "SetCrdPrm: syn_vel_max is 32767; it must be above 0 and below 32767",
            ),
            bad(SetCrdPrm { syn_acc_max: f64::NAN.into(), ..p }, 7, "SetCrdPrm: syn_acc_max is not a finite number"),
            bad(
                SetCrdPrm { syn_acc_max: (-1.0).into(), ..p },
                7,
                "SetCrdPrm: syn_acc_max is -1; it must be above 0 and below 32767",
            ),
            bad(
                SetCrdPrm { even_time_ms: (-1).into(), ..p },
                7,
                "SetCrdPrm: even_time_ms is -1; it must be from 0 to 32766",
            ),
            bad(
                SetCrdPrm { even_time_ms: 32767.into(), ..p },
                7,
                "SetCrdPrm: even_time_ms is 32767; it must be from 0 to 32766",
            ),
            bad(SetCrdPrm { set_origin_flag: 2.into(), ..p }, 7, "SetCrdPrm: set_origin_flag is 2; allowed are 0 to 1"),
        ],
    );
    // Axis 1 belongs to coordinate system 2; a moving axis; a moving coordinate system.
    bench.done(SetCrdPrm { crd: 2.into(), ..p });
    check(&mut bench, &[bad(p, 1, "SetCrdPrm: axis 1 belongs to coordinate system 2")]);
    bench.done(PrfTrap { core: 1.into(), profile: 1.into() });
    bench.done(PrfTrap { core: 1.into(), profile: 2.into() });
    bench.servo_on(1);
    bench.servo_on(2);
    bench.done(PrfJog { core: 1.into(), profile: 2.into() });
    bench.done(SetJogPrm { core: 1.into(), profile: 2.into(), acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() });
    bench.done(SetVel { core: 1.into(), profile: 2.into(), vel: 10.0.into() });
    bench.done(Update { core: 1.into(), mask: 2.into() });
    let answer = bench.call(p);
    assert_eq!((answer.code, answer.reason(), answer.refusal().axis.get()), (1, Reason::Moving, 2));
    bench.done(Stop { core: 1.into(), mask: 2.into(), option: 2.into(), form: 0 });
    bench.done(p);
    bench.done(line(50_000, 0, 50.0, 2.0));
    bench.done(start_crd(1));
    for (number, request, reason) in [
        (opcode::SetCrdPrm, body::<SetCrdPrm>(p, &[]), Reason::CrdRuns),
        (opcode::CrdClear, body::<CrdClear>(clear(0), &[]), Reason::CrdRuns),
        (opcode::CrdClear, body::<CrdClear>(clear(1), &[]), Reason::CrdRuns),
        (opcode::CrdStart, body::<CrdStart>(start_crd(1), &[]), Reason::CrdRuns),
        (opcode::PrfTrap, body::<PrfTrap>(PrfTrap { core: 1.into(), profile: 1.into() }, &[]), Reason::Moving),
        (
            opcode::ZeroPos,
            body::<ZeroPos>(ZeroPos { core: 1.into(), axis: 1.into(), count: 1.into() }, &[]),
            Reason::Moving,
        ),
    ] {
        let tag = bench.post_raw(number, Lane::Immediate, &request);
        let answer = bench.wait(tag);
        assert_eq!((answer.code, answer.reason()), (1, reason));
    }
    assert_eq!(status(&mut bench, 0).0, 1, "it runs on");
}

#[test]
fn motions_and_starts() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let l = line(100, 0, 50.0, 2.0);
    let a = arc(2000, 0, 1000.0, 0.0, 0);
    let r = ArcXYR {
        core: 1.into(),
        crd: 1.into(),
        x: 10.into(),
        y: 0.into(),
        radius: 3.0.into(),
        circle_dir: 0.into(),
        syn_vel: 50.0.into(),
        syn_acc: 2.0.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    };
    let yz = ArcYZR {
        core: 1.into(),
        crd: 1.into(),
        y: 10.into(),
        z: 0.into(),
        radius: 30.0.into(),
        circle_dir: 0.into(),
        syn_vel: 50.0.into(),
        syn_acc: 2.0.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    };
    let xyz = LnXYZ {
        core: 1.into(),
        crd: 1.into(),
        x: 1.into(),
        y: 0.into(),
        z: 4.into(),
        syn_vel: 50.0.into(),
        syn_acc: 2.0.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    };
    check(
        &mut bench,
        &[
            bad(start_crd(1), 1, "CrdStart: coordinate system 1: FIFO 0 holds nothing to do"),
            bad(
                CrdStart { option: 1.into(), ..start_crd(1) },
                1,
                "CrdStart: coordinate system 1: FIFO 1 holds nothing to do",
            ),
            bad(start_crd(4), 7, "CrdStart: mask is 4; it must be from 0 to 3"),
            bad(LnXY { crd: 3.into(), ..l }, 7, "LnXY: crd is 3; allowed are 1 to 2"),
            bad(LnXY { fifo: 2.into(), ..l }, 7, "LnXY: fifo is 2; allowed are 0 to 1"),
            bad(LnXY { fifo: (-1).into(), ..l }, 7, "LnXY: fifo is -1; allowed are 0 to 1"),
            bad(LnXY { x: 0.into(), ..l }, 7, "LnXY: the motion has no length: its target is where it begins"),
            bad(LnXY { vel_end: (-1.0).into(), ..l }, 7, "LnXY: vel_end is -1; it must be 0 or more"),
            bad(LnXY { syn_vel: f64::INFINITY.into(), ..l }, 7, "LnXY: syn_vel is not a finite number"),
            bad(LnXY { syn_acc: f64::NAN.into(), ..l }, 7, "LnXY: syn_acc is not a finite number"),
            bad(LnXY { vel_end: f64::NAN.into(), ..l }, 7, "LnXY: vel_end is not a finite number"),
            bad(xyz, 7, "LnXYZ: z is 4; no axis drives this coordinate, which stays 0"),
            bad(yz, 7, "ArcYZR: z is 0; no axis drives this coordinate, which stays 0"),
            bad(r, 7, "ArcXYR: radius is 3; the target is reached with 5 at least"),
            bad(ArcXYR { radius: 0.0.into(), ..r }, 7, "ArcXYR: radius is 0; the target is reached with 5 at least"),
            bad(ArcXYR { radius: f64::NAN.into(), ..r }, 7, "ArcXYR: radius is not a finite number"),
            bad(ArcXYR { radius: 3e9.into(), ..r }, 7, "ArcXYR: the radius is 3000000000; it must be below 2147483648"),
            bad(ArcXYR { circle_dir: 2.into(), ..r }, 7, "ArcXYR: circle_dir is 2; allowed are 0 to 1"),
            bad(
                ArcXYR { x: 0.into(), radius: 5.0.into(), ..r },
                7,
                "ArcXYR: the motion has no length: its target is where it begins; \
                 a full circle is made by its centre (ArcXYC, ArcYZC, ArcZXC)",
            ),
            bad(
                ArcXYC { x_center: 0.0.into(), ..a },
                7,
                "ArcXYC: x_center: the centre is where the motion begins; it must be at least 0.001953125 pulses away",
            ),
            bad(ArcXYC { y_center: f64::NAN.into(), ..a }, 7, "ArcXYC: y_center is not a finite number"),
            bad(ArcXYC { circle_dir: (-1).into(), ..a }, 7, "ArcXYC: circle_dir is -1; allowed are 0 to 1"),
            bad(
                BufGear { core: 1.into(), crd: 1.into(), axis: 1.into(), pos: 5.into(), fifo: 0.into() },
                1,
                "BufGear: axis 1 belongs to coordinate system 1",
            ),
            bad(
                BufGear { core: 1.into(), crd: 1.into(), axis: 9.into(), pos: 5.into(), fifo: 0.into() },
                7,
                "BufGear: axis is 9; allowed are 1 to 8",
            ),
            bad(
                BufIO {
                    core: 1.into(),
                    crd: 1.into(),
                    do_type: 4.into(),
                    do_mask: 1.into(),
                    do_value: 1.into(),
                    fifo: 0.into(),
                },
                7,
                "BufIO: do_type is 4; allowed are 10 to 12",
            ),
            bad(
                BufDoBit {
                    core: 1.into(),
                    crd: 1.into(),
                    do_type: 12.into(),
                    index: 17.into(),
                    value: 1.into(),
                    fifo: 0.into(),
                },
                7,
                "BufDoBit: index is 17; allowed are 1 to 16",
            ),
            bad(
                BufDA { core: 1.into(), crd: 1.into(), channel: 9.into(), value: 1.into(), fifo: 0.into() },
                7,
                "BufDA: channel is 9; allowed are 1 to 8",
            ),
            bad(
                SetOverride { core: 1.into(), crd: 1.into(), ratio: 1.5.into() },
                7,
                "SetOverride: ratio is 1.5; it must be from 9.537e-7 to 1",
            ),
            bad(
                SetOverride { core: 1.into(), crd: 1.into(), ratio: f64::NAN.into() },
                7,
                "SetOverride: ratio is not a finite number",
            ),
            bad(
                SetCrdStopDec { core: 1.into(), crd: 1.into(), smooth: 0.0.into(), abrupt: 1.0.into() },
                7,
                "SetCrdStopDec: smooth is 0; it must be above 0 and below 32767",
            ),
            bad(ahead(-1.0, 1.0, 100), 7, "InitLookAhead: time_ms is -1; it must be from 0 to 32767"),
            bad(ahead(1.0, 0.0, 100), 7, "InitLookAhead: acc_max is 0; it must be above 0 and below 32767"),
            bad(ahead(1.0, 1.0, -1), 7, "InitLookAhead: count is -1; it must be from 0 to 32766"),
            bad(
                SetCrdLimit {
                    core: 1.into(),
                    crd: 1.into(),
                    coordinate: 3.into(),
                    vel_max: 1.0.into(),
                    acc_max: 1.0.into(),
                },
                7,
                "SetCrdLimit: coordinate is 3; allowed are 1 to 2",
            ),
            bad(
                CrdStop { core: 1.into(), mask: 8.into(), option: 0.into() },
                7,
                "CrdStop: mask is 8; it must be from 0 to 3",
            ),
        ],
    );
    // Speed 0 and below, and a centre that does not match: the limits are numbers without a short
    // form.
    for (request, field) in [
        (LnXY { syn_vel: 0.0.into(), ..l }, 4),
        (LnXY { syn_vel: (-5.0).into(), ..l }, 4),
        (LnXY { syn_acc: 0.0.into(), ..l }, 5),
    ] {
        let before = state(&mut bench);
        let (code, reason, refusal) = bench.refused(request);
        assert_eq!((code, reason, refusal.field), (7, Reason::OutOfRange, field));
        assert_eq!(refusal.low.get(), 1.0 / 1048576.0);
        assert_eq!(state(&mut bench), before);
    }
    let (code, reason, refusal) = bench.refused(ArcXYC { x_center: 1100.0.into(), ..a });
    assert_eq!((code, reason, refusal.field, refusal.high.get()), (7, Reason::CentreOff, 4, 2.0));
    assert!(refusal.got.get() > 90.0);
    // Axes that are not ready.
    bench.done(l);
    bench.done(AxisOff { core: 1.into(), axis: 2.into() });
    check(&mut bench, &[bad(start_crd(1), 1, "CrdStart: axis 2: the servo is off; call AxisOn first")]);
    bench.servo_on(2);
    bench.done(PrfJog { core: 1.into(), profile: 2.into() });
    check(
        &mut bench,
        &[bad(start_crd(1), 1, "CrdStart: axis 2 is not driven by coordinate system 1 any more; call SetCrdPrm again")],
    );
    // Two are started, of which one cannot: neither starts.
    let mut both = prm();
    both.profile = elements([0, 0, 1, 2]);
    bench.done(SetCrdPrm { crd: 2.into(), ..both });
    bench.servo_on(3);
    bench.servo_on(4);
    bench.done(LnXY { crd: 2.into(), ..l });
    check(
        &mut bench,
        &[bad(start_crd(3), 1, "CrdStart: axis 2 is not driven by coordinate system 1 any more; call SetCrdPrm again")],
    );
    let second = bench.done(CrdStatus { core: 1.into(), crd: 2.into(), fifo: 0.into() });
    assert_eq!({ second.run }.get(), 0);
}

/// Gears of a motion.
#[test]
fn gears() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    let gear = |axis: i16| BufGear { core: 1.into(), crd: 1.into(), axis: axis.into(), pos: 5.into(), fifo: 0.into() };
    for axis in 3..=6 {
        bench.done(gear(axis));
    }
    check(
        &mut bench,
        &[
            bad(gear(3), 1, "BufGear: axis 3 goes along with the next motion already"),
            bad(gear(7), 1, "BufGear: coordinate system 1: 4 axes go along with the next motion, which is the most"),
        ],
    );
    bench.done(line(100, 0, 50.0, 2.0));
    bench.done(gear(3));
    bench.done(PrfJog { core: 1.into(), profile: 8.into() });
    let travel = BufMove {
        core: 1.into(),
        crd: 1.into(),
        axis: 8.into(),
        pos: 5.into(),
        vel: 1.0.into(),
        acc: 1.0.into(),
        modal: 0.into(),
        fifo: 0.into(),
    };
    check(
        &mut bench,
        &[
            bad(travel, 1, "BufMove: axis 8 is not in the mode that this command is for; its mode is 1"),
            bad(BufMove { axis: 7.into(), modal: 2.into(), ..travel }, 7, "BufMove: modal is 2; allowed are 0 to 1"),
            bad(
                BufMove { axis: 7.into(), vel: 0.0.into(), ..travel },
                7,
                "BufMove: vel is 0; it must be from 9.537e-7 to 32767",
            ),
        ],
    );
}
