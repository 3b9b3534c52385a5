//! Requests of Follow and FollowEx on core 1.
use super::Bench;
use protocol::command::*;
use protocol::reason::{Reason, Refusal};

const CORE: i16 = 1;

pub fn prf(axis: i16, dir: i16) -> PrfFollow {
    PrfFollow { core: CORE.into(), profile: axis.into(), dir: dir.into() }
}

pub fn prf_ex(axis: i16, dir: i16) -> PrfFollowEx {
    PrfFollowEx { core: CORE.into(), profile: axis.into(), dir: dir.into() }
}

pub fn master(axis: i16, index: i16, kind: i16, item: i16) -> SetFollowMaster {
    SetFollowMaster {
        core: CORE.into(),
        profile: axis.into(),
        master_index: index.into(),
        master_type: kind.into(),
        master_item: item.into(),
    }
}

pub fn data(axis: i16, master: i32, slave: f64, kind: i16, fifo: i16) -> FollowData {
    FollowData {
        core: CORE.into(),
        profile: axis.into(),
        master_segment: master.into(),
        slave_segment: slave.into(),
        kind: kind.into(),
        fifo: fifo.into(),
    }
}

pub fn data_ex(axis: i16, master: f64, slave: f64, kind: i16, percent: i16, fifo: i16) -> FollowDataPercentEx {
    FollowDataPercentEx {
        core: CORE.into(),
        profile: axis.into(),
        master_segment: master.into(),
        slave_segment: slave.into(),
        kind: kind.into(),
        percent: percent.into(),
        fifo: fifo.into(),
    }
}

pub fn start(mask: i32, option: i32) -> FollowStart {
    FollowStart { core: CORE.into(), mask: mask.into(), option: option.into() }
}

pub fn switch(mask: i32) -> FollowSwitch {
    FollowSwitch { core: CORE.into(), mask: mask.into() }
}

pub fn clear(axis: i16, fifo: i16) -> FollowClear {
    FollowClear { core: CORE.into(), profile: axis.into(), fifo: fifo.into() }
}

pub fn loops(axis: i16, count: i32) -> SetFollowLoop {
    SetFollowLoop { core: CORE.into(), profile: axis.into(), loop_count: count.into() }
}

pub fn event(axis: i16, event: i16, direction: i16, pos: i32) -> SetFollowEvent {
    SetFollowEvent {
        core: CORE.into(),
        profile: axis.into(),
        event: event.into(),
        master_dir: direction.into(),
        pos: pos.into(),
    }
}

pub fn memory(axis: i16, memory: i16) -> SetFollowMemory {
    SetFollowMemory { core: CORE.into(), profile: axis.into(), memory: memory.into() }
}

pub fn space_of(axis: i16, fifo: i16) -> FollowSpace {
    FollowSpace { core: CORE.into(), profile: axis.into(), fifo: fifo.into() }
}

pub fn spaces<const AXES: usize>(bench: &mut Bench<AXES>, axis: i16) -> [i16; 2] {
    [0, 1].map(|fifo| bench.done(space_of(axis, fifo)).value.get())
}

pub fn mode<const AXES: usize>(bench: &mut Bench<AXES>, axis: i16) -> i32 {
    bench.call(GetPrfMode { core: CORE.into(), profile: axis.into(), count: 1.into() }).items::<GetPrfMode>()[0]
        .value
        .get()
}

/// The axis jogs at `speed` pulse/ms when it is started with [`jog`].
pub fn jogger<const AXES: usize>(bench: &mut Bench<AXES>, axis: i16, speed: f64) {
    bench.servo_on(axis);
    bench.done(PrfJog { core: CORE.into(), profile: axis.into() });
    let (acc, dec) = (1000.0.into(), 1000.0.into());
    bench.done(SetJogPrm { core: CORE.into(), profile: axis.into(), acc, dec, smooth: 0.0.into() });
    bench.done(SetVel { core: CORE.into(), profile: axis.into(), vel: speed.into() });
}

pub fn jog(axis: i16) -> Update {
    Update { core: CORE.into(), mask: (1 << (axis - 1)).into() }
}

/// Axis 2 follows axis 1, which jogs at 10 pulse/ms.
pub fn pair() -> Bench<8> {
    let mut bench = Bench::gus();
    jogger(&mut bench, 1, 10.0);
    bench.servo_on(2);
    bench.done(prf(2, 0));
    bench.done(master(2, 1, 2, 0));
    bench
}

pub fn reported(refused: (i16, Reason, Refusal)) -> (i16, Reason, u8, f64) {
    (refused.0, refused.1, refused.2.field, refused.2.got.get())
}
