//! Laser commands of a path, follows and their tables: requests, and what is visible after them.
use crate::bench::{Bench, body};
use protocol::command::*;
use protocol::reason::describe_opcode;
use protocol::record::Lane;

pub const GUS: u8 = 0;

pub const LSR: u8 = 1;

/// A controller with coordinate system 1 (X and Y by axes 1 and 2) at standstill, both lasers on
/// their connectors.
pub fn bench(family: u8) -> Bench<8> {
    let mut bench = Bench::gus();
    bench.done(Choose { profile: 0, family });
    for axis in [1, 2] {
        bench.servo_on(axis);
    }
    if family == GUS {
        for axis in [7, 8] {
            bench.done(SetAxisMode { core: 1.into(), axis: axis.into(), mode: 1.into() });
        }
    }
    let mut profile = [0.into(); 8];
    (profile[0], profile[1]) = (1.into(), 2.into());
    bench.done(SetCrdPrm {
        core: 1.into(),
        crd: 1.into(),
        dimension: 2.into(),
        profile,
        syn_vel_max: 500.0.into(),
        syn_acc_max: 10.0.into(),
        even_time_ms: 0.into(),
        set_origin_flag: 1.into(),
        origin_pos: [0.into(); 8],
    });
    bench
}

pub fn buf_on(crd: i16, fifo: i16, channel: i16) -> BufLaserOn {
    BufLaserOn { core: 1.into(), crd: crd.into(), fifo: fifo.into(), channel: channel.into() }
}

pub fn buf_off(crd: i16, fifo: i16, channel: i16) -> BufLaserOff {
    BufLaserOff { core: 1.into(), crd: crd.into(), fifo: fifo.into(), channel: channel.into() }
}

pub fn buf_power(power: f64) -> BufLaserPrfCmd {
    BufLaserPrfCmd { core: 1.into(), crd: 1.into(), power: power.into(), fifo: 0.into(), channel: 0.into() }
}

pub fn follow_off() -> BufLaserFollowOff {
    BufLaserFollowOff { core: 1.into(), crd: 1.into(), fifo: 0.into(), channel: 0.into() }
}

pub fn prf_follow(ratio: f64, min: i32, max: i32) -> BufLaserPrfFollow {
    BufLaserPrfFollow {
        core: 1.into(),
        crd: 1.into(),
        ratio: ratio.into(),
        min: min.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    }
}

pub fn ratio_follow(ratio: f64, min: f64, max: f64) -> BufLaserFollowRatio {
    BufLaserFollowRatio {
        core: 1.into(),
        crd: 1.into(),
        ratio: ratio.into(),
        min: min.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    }
}

pub fn follow_mode(source: i16, start: Option<f64>) -> BufLaserFollowMode {
    BufLaserFollowMode {
        core: 1.into(),
        crd: 1.into(),
        source: source.into(),
        fifo: 0.into(),
        channel: 0.into(),
        start_power: start.unwrap_or(0.0).into(),
        start_given: start.is_some().into(),
    }
}

pub fn table_follow(table: i16, min: f64, max: f64) -> BufLaserFollowTable {
    BufLaserFollowTable {
        core: 1.into(),
        crd: 1.into(),
        table: table.into(),
        min: min.into(),
        max: max.into(),
        fifo: 0.into(),
        channel: 0.into(),
    }
}

pub fn line(x: i32, y: i32, vel: f64) -> LnXY {
    LnXY {
        core: 1.into(),
        crd: 1.into(),
        x: x.into(),
        y: y.into(),
        syn_vel: vel.into(),
        syn_acc: 1.0.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    }
}

pub fn start() -> CrdStart {
    CrdStart { core: 1.into(), mask: 1.into(), option: 0.into() }
}

pub fn table(table: i16, count: i32, channel: i16, first: u16) -> SetLaserFollowTable {
    SetLaserFollowTable {
        core: 1.into(),
        table: table.into(),
        count: count.into(),
        channel: channel.into(),
        first: first.into(),
    }
}

pub fn points(given: &[(f64, f64)]) -> Vec<LaserFollowPoint> {
    given.iter().map(|(vel, power)| LaserFollowPoint { vel: (*vel).into(), power: (*power).into() }).collect()
}

pub fn distance(mode: i16, source: i16, scale: [f64; 4]) -> SetLaserDisMode {
    SetLaserDisMode {
        core: 1.into(),
        mode: mode.into(),
        source: source.into(),
        pos: [0.into(); 4],
        scale: scale.map(Into::into),
        channel: 0.into(),
    }
}

pub fn ratios(ratio: [f64; 4], bounds: Option<(f64, f64)>) -> SetLaserDisRatio {
    let (min, max) = bounds.unwrap_or((0.0, 0.0));
    SetLaserDisRatio {
        core: 1.into(),
        ratio: ratio.map(Into::into),
        min: min.into(),
        max: max.into(),
        channel: 0.into(),
        bounds_given: bounds.is_some().into(),
    }
}

pub fn lines(count: i16, limit: Option<[f64; 4]>, first: u16) -> SetLaserDisTable1D {
    SetLaserDisTable1D {
        core: 1.into(),
        count: count.into(),
        min: 0.0.into(),
        max: 100.0.into(),
        limit: limit.unwrap_or([0.0; 4]).map(Into::into),
        channel: 0.into(),
        limits_given: limit.is_some().into(),
        first: first.into(),
    }
}

pub fn on_lines(given: &[(f64, i32)]) -> Vec<LaserDisPoint> {
    given.iter().map(|(ratio, pos)| LaserDisPoint { ratio: (*ratio).into(), pos: (*pos).into() }).collect()
}

pub fn plane(axis: [i16; 2], count: [i16; 2], first: u16) -> SetLaserDisTable2D {
    SetLaserDisTable2D {
        core: 1.into(),
        axis: axis.map(Into::into),
        count: count.map(Into::into),
        min: 0.0.into(),
        max: 100.0.into(),
        limit: [0.0.into(); 2],
        channel: 0.into(),
        limits_given: 0,
        first: first.into(),
    }
}

pub fn in_plane(given: &[f64]) -> Vec<LaserDisValue> {
    given.iter().map(|value| LaserDisValue { value: (*value).into() }).collect()
}

/// All visible state of lasers and coordinate systems, and the number of the last entry: a refused
/// command pushes none.
pub fn state(bench: &mut Bench<8>) -> String {
    let mut spaces = Vec::new();
    for crd in [1, 2] {
        for fifo in [0, 1] {
            let space = bench.call(CrdSpace { core: 1.into(), crd: crd.into(), fifo: fifo.into() });
            spaces.push((space.code, space.body));
        }
    }
    let view = bench.server.view();
    let mut lasers = view.lasers;
    lasers.iter_mut().for_each(|laser| (laser.on_time, laser.version) = (0, 0));
    format!("{spaces:?} {} {lasers:?}", view.done_immediate)
}

/// Refused with this code and text, and nothing has changed.
#[track_caller]
pub fn refused<R: Request>(bench: &mut Bench<8>, request: R, items: &[R::Item], code: i16, text: &str) {
    let before = state(bench);
    let tag = bench.post_raw(R::OPCODE, Lane::Immediate, &body::<R>(request, items));
    let answer = bench.wait(tag);
    assert_ne!(answer.code, 0, "not refused; {text}");
    assert_eq!(describe_opcode(R::OPCODE, answer.refusal()).to_string(), text);
    assert_eq!(answer.code, code, "{text}");
    bench.run_ms(1);
    assert_eq!(state(bench), before, "{text}");
}

pub fn duty() -> LaserPowerMode {
    LaserPowerMode {
        core: 1.into(),
        mode: 0.into(),
        max: 100.0.into(),
        min: 0.0.into(),
        channel: 0.into(),
        delay_mode: 0.into(),
    }
}

/// As `refused`, during motion.
#[track_caller]
pub fn refused_running<R: Request>(bench: &mut Bench<8>, request: R, items: &[R::Item], text: &str) {
    let answer = bench.call_items(request, items);
    assert_eq!(answer.code, 1, "{text}");
    assert_eq!(describe_opcode(R::OPCODE, answer.refusal()).to_string(), text);
}

#[track_caller]
pub fn refused_running_code<R: Request>(bench: &mut Bench<8>, request: R, code: i16, text: &str) {
    let answer = bench.call(request);
    assert_eq!(answer.code, code, "{text}");
    assert_eq!(describe_opcode(R::OPCODE, answer.refusal()).to_string(), text);
}
