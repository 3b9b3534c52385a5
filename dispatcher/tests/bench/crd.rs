//! Calls of coordinate systems, for tests: coordinate system 1 of core 1.
use super::*;

/// TCrdPrm of X, Y on axes 1, 2 with the origin where they are.
pub fn prm() -> SetCrdPrm {
    let mut profile = [0; 8];
    (profile[0], profile[1]) = (1, 2);
    SetCrdPrm {
        core: 1.into(),
        crd: 1.into(),
        dimension: 2.into(),
        profile: profile.map(|coordinate| i16::from(coordinate as u8).into()),
        syn_vel_max: 500.0.into(),
        syn_acc_max: 10.0.into(),
        even_time_ms: 0.into(),
        set_origin_flag: 0.into(),
        origin_pos: [0.into(); 8],
    }
}

/// Axes 1 and 2 with their servos on, as X and Y.
pub fn plane<const AXES: usize>(bench: &mut Bench<AXES>) {
    bench.servo_on(1);
    bench.servo_on(2);
    bench.done(prm());
}

pub fn line(x: i32, y: i32, vel: f64, acc: f64) -> LnXY {
    LnXY {
        core: 1.into(),
        crd: 1.into(),
        x: x.into(),
        y: y.into(),
        syn_vel: vel.into(),
        syn_acc: acc.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    }
}

pub fn start_crd(mask: i16) -> CrdStart {
    CrdStart { core: 1.into(), mask: mask.into(), option: 0.into() }
}

/// CrdStatus: run, segment.
pub fn status<const AXES: usize>(bench: &mut Bench<AXES>, fifo: i16) -> (i16, i32) {
    let reply = bench.done(CrdStatus { core: 1.into(), crd: 1.into(), fifo: fifo.into() });
    (reply.run.get(), reply.segment.get())
}

pub fn space<const AXES: usize>(bench: &mut Bench<AXES>, fifo: i16) -> i32 {
    bench.done(CrdSpace { core: 1.into(), crd: 1.into(), fifo: fifo.into() }).value.get()
}

pub fn remainder<const AXES: usize>(bench: &mut Bench<AXES>, fifo: i16) -> i32 {
    bench.done(GetRemainderSegNum { core: 1.into(), crd: 1.into(), fifo: fifo.into() }).value.get()
}

pub fn crd_pos<const AXES: usize>(bench: &mut Bench<AXES>) -> Vec<f64> {
    let answer = bench.call(GetCrdPos { core: 1.into(), crd: 1.into() });
    answer.items::<GetCrdPos>().iter().map(|item| item.value.get()).collect()
}

/// Runs until the coordinate system is at standstill; returns its greatest speed.
pub fn until_standstill<const AXES: usize>(bench: &mut Bench<AXES>) -> f64 {
    let mut most = 0.0f64;
    for _ in 0..4_000_000 {
        let seen = bench.server.view().crds[0];
        if !seen.runs {
            return most;
        }
        let speed = seen.motion.velocity();
        most = most.max(speed.m as f64 * 2f64.powi(-i32::from(speed.e)));
        bench.step();
    }
    panic!("it runs for ever");
}

pub fn clear(fifo: i16) -> CrdClear {
    CrdClear { core: 1.into(), crd: 1.into(), fifo: fifo.into() }
}

/// An arc in XY by its centre relative to its start, at 50 pulse/ms and 2 pulse/ms².
pub fn arc(x: i32, y: i32, x_center: f64, y_center: f64, dir: i16) -> ArcXYC {
    ArcXYC {
        core: 1.into(),
        crd: 1.into(),
        x: x.into(),
        y: y.into(),
        x_center: x_center.into(),
        y_center: y_center.into(),
        circle_dir: dir.into(),
        syn_vel: 50.0.into(),
        syn_acc: 2.0.into(),
        vel_end: 0.0.into(),
        fifo: 0.into(),
    }
}

/// Look-ahead of FIFO 0.
pub fn ahead(time_ms: f64, acc: f64, count: i16) -> InitLookAhead {
    InitLookAhead {
        core: 1.into(),
        crd: 1.into(),
        fifo: 0.into(),
        time_ms: time_ms.into(),
        acc_max: acc.into(),
        count: count.into(),
    }
}

pub fn flush() -> CrdData {
    CrdData { core: 1.into(), crd: 1.into(), fifo: 0.into() }
}
