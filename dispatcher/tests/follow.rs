//! Follow and FollowEx over the wire: settings, places, admission ahead of time, and bad input, which is refused with
//! its code, reason and parameter and changes nothing.
mod bench;
use bench::{Bench, entry, position, read_pos, sleep, wait_stop};
use protocol::command::*;
use protocol::reason::{Reason, Refusal};
use protocol::record::Lane;

const CORE: i16 = 1;

fn prf(axis: i16, dir: i16) -> PrfFollow {
    PrfFollow { core: CORE.into(), profile: axis.into(), dir: dir.into() }
}

fn prf_ex(axis: i16, dir: i16) -> PrfFollowEx {
    PrfFollowEx { core: CORE.into(), profile: axis.into(), dir: dir.into() }
}

fn master(axis: i16, index: i16, kind: i16, item: i16) -> SetFollowMaster {
    SetFollowMaster {
        core: CORE.into(),
        profile: axis.into(),
        master_index: index.into(),
        master_type: kind.into(),
        master_item: item.into(),
    }
}

fn data(axis: i16, master: i32, slave: f64, kind: i16, fifo: i16) -> FollowData {
    FollowData {
        core: CORE.into(),
        profile: axis.into(),
        master_segment: master.into(),
        slave_segment: slave.into(),
        kind: kind.into(),
        fifo: fifo.into(),
    }
}

fn data_ex(axis: i16, master: f64, slave: f64, kind: i16, percent: i16, fifo: i16) -> FollowDataPercentEx {
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

fn start(mask: i32, option: i32) -> FollowStart {
    FollowStart { core: CORE.into(), mask: mask.into(), option: option.into() }
}

fn switch(mask: i32) -> FollowSwitch {
    FollowSwitch { core: CORE.into(), mask: mask.into() }
}

fn clear(axis: i16, fifo: i16) -> FollowClear {
    FollowClear { core: CORE.into(), profile: axis.into(), fifo: fifo.into() }
}

fn loops(axis: i16, count: i32) -> SetFollowLoop {
    SetFollowLoop { core: CORE.into(), profile: axis.into(), loop_count: count.into() }
}

fn event(axis: i16, event: i16, way: i16, pos: i32) -> SetFollowEvent {
    SetFollowEvent {
        core: CORE.into(),
        profile: axis.into(),
        event: event.into(),
        master_dir: way.into(),
        pos: pos.into(),
    }
}

fn memory(axis: i16, memory: i16) -> SetFollowMemory {
    SetFollowMemory { core: CORE.into(), profile: axis.into(), memory: memory.into() }
}

fn space_of(axis: i16, fifo: i16) -> FollowSpace {
    FollowSpace { core: CORE.into(), profile: axis.into(), fifo: fifo.into() }
}

fn spaces<const AXES: usize>(bench: &mut Bench<AXES>, axis: i16) -> [i16; 2] {
    [0, 1].map(|fifo| bench.done(space_of(axis, fifo)).value.get())
}

fn mode<const AXES: usize>(bench: &mut Bench<AXES>, axis: i16) -> i32 {
    bench.call(GetPrfMode { core: CORE.into(), profile: axis.into(), count: 1.into() }).items::<GetPrfMode>()[0]
        .value
        .get()
}

/// Axis 1 jogs at `speed` pulse/ms when it is started with [`jog`].
fn jogger<const AXES: usize>(bench: &mut Bench<AXES>, axis: i16, speed: f64) {
    bench.servo_on(axis);
    bench.done(PrfJog { core: CORE.into(), profile: axis.into() });
    let (acc, dec) = (1000.0.into(), 1000.0.into());
    bench.done(SetJogPrm { core: CORE.into(), profile: axis.into(), acc, dec, smooth: 0.0.into() });
    bench.done(SetVel { core: CORE.into(), profile: axis.into(), vel: speed.into() });
}

fn jog(axis: i16) -> Update {
    Update { core: CORE.into(), mask: (1 << (axis - 1)).into() }
}

/// Axis 2 follows axis 1, which jogs at 10 pulse/ms.
fn pair() -> Bench<8> {
    let mut bench = Bench::gus();
    jogger(&mut bench, 1, 10.0);
    bench.servo_on(2);
    bench.done(prf(2, 0));
    bench.done(master(2, 1, 2, 0));
    bench
}

fn told(refused: (i16, Reason, Refusal)) -> (i16, Reason, u8, f64) {
    (refused.0, refused.1, refused.2.field, refused.2.got.get())
}

#[test]
fn modes_and_directions() {
    let mut bench = Bench::gus();
    bench.done(prf(2, 0));
    assert_eq!(mode(&mut bench, 2), 4);
    bench.done(prf_ex(3, 7));
    assert_eq!(mode(&mut bench, 3), 10);
    // The same mode again keeps the data, in the same direction only; any sign is its unit.
    bench.done(data(2, 100, 50.0, 0, 0));
    bench.done(prf(2, 0));
    assert_eq!(spaces(&mut bench, 2), [15, 16]);
    assert_eq!(told(bench.refused(prf(2, 1))), (1, Reason::DirectionDiffers, 2, 0.0));
    bench.done(prf_ex(3, 1));
    assert_eq!(told(bench.refused(prf_ex(3, -1))), (1, Reason::DirectionDiffers, 2, 1.0));
    assert_eq!(spaces(&mut bench, 2), [15, 16]);
    // Commands of one mode do not count in the other, nor elsewhere.
    assert_eq!(told(bench.refused(data_ex(2, 200.0, 50.0, 0, 0, 0))), (1, Reason::WrongMode, 255, 4.0));
    assert_eq!(told(bench.refused(data(3, 200, 50.0, 0, 0))), (1, Reason::WrongMode, 255, 10.0));
    assert_eq!(told(bench.refused(data(1, 200, 50.0, 0, 0))), (1, Reason::WrongMode, 255, 0.0));
    // Another mode: data, master and start condition are gone; loops and memory stay.
    bench.done(master(2, 1, 2, 0));
    bench.done(event(2, 2, -1, 77));
    bench.done(memory(2, 1));
    bench.done(data(2, 100, 50.0, 0, 0));
    bench.done(prf_ex(2, -5));
    let (core, profile) = (CORE.into(), 2.into());
    assert_eq!(bench.refused(GetFollowMasterEx { core, profile }).1, Reason::NoMaster);
    let found = bench.done(GetFollowEventEx { core, profile });
    assert_eq!((found.event.get(), found.pos.get()), (1, 0));
    assert_eq!(bench.done(GetFollowMemoryEx { core, profile }).value.get(), 1);
    assert_eq!(bench.done(FollowSpaceEx { core, profile, fifo: 0.into() }).value.get(), 512);
}

#[test]
fn what_was_set_is_told() {
    let mut bench = Bench::<16>::new(1, 250); // gtn-016: two cores of eight axes
    let two = |core: i16| (core.into(), 2.into());
    for core in [1, 2] {
        let (core, profile) = two(core);
        bench.done(PrfFollow { core, profile, dir: 0.into() });
    }
    for (core, index, kind, item) in [(1, 1, 2, 0), (1, 8, 3, 2), (2, 1, 101, 0), (2, 2, 103, 3), (1, 2, 103, 9)] {
        let (core, profile) = two(core);
        let set = SetFollowMaster {
            core,
            profile,
            master_index: index.into(),
            master_type: kind.into(),
            master_item: item.into(),
        };
        if (index, kind) == (2, 103) && core.get() == 1 {
            // Axis 2 of core 2 follows axis 2 of core 1 already.
            assert_eq!(told(bench.refused(set)), (1, Reason::MasterCycle, 2, 2.0));
            continue;
        }
        bench.done(set);
        let found = bench.done(GetFollowMaster { core, profile });
        let found = (found.master_index.get(), found.master_type.get(), found.master_item.get());
        assert_eq!(found, (index, kind, item));
    }
    let (core, profile) = two(1);
    for (which, way, pos) in [(2, -1, -50_000), (1, 0, 5), (2, 1, i32::MAX)] {
        bench.done(event(2, which, way, pos));
        let found = bench.done(GetFollowEvent { core, profile });
        assert_eq!((found.event.get(), found.master_dir.get(), found.pos.get()), (which, way, pos));
    }
    bench.done(memory(2, 1));
    assert_eq!(bench.done(GetFollowMemory { core, profile }).value.get(), 1);
    assert_eq!(bench.done(GetFollowLoop { core, profile }).value.get(), 0);
    let status = bench.done(GetFollowStatus { core, profile });
    assert_eq!((status.fifo.get(), status.switch_status.get()), (0, 0));
}

#[test]
fn masters_that_cannot_be() {
    let mut bench = Bench::gus();
    for axis in 1..=4 {
        bench.done(prf(axis, 0));
    }
    for kind in [0, 4, 5, 100, 101, 103, -1] {
        assert_eq!(told(bench.refused(master(2, 1, kind, 0))), (7, Reason::MasterType, 3, f64::from(kind)));
    }
    for index in [0, 9, -1] {
        assert_eq!(told(bench.refused(master(2, index, 2, 0))), (7, Reason::Selector, 2, f64::from(index)));
    }
    for kind in [1, 2, 3] {
        assert_eq!(told(bench.refused(master(2, 2, kind, 0))), (7, Reason::OwnMaster, 2, 2.0));
    }
    let (core, profile) = (CORE.into(), 2.into());
    assert_eq!(bench.refused(GetFollowMaster { core, profile }).1, Reason::NoMaster, "nothing was taken");
    // 1 follows 2 follows 3; 3 may follow 4, neither 1 nor 2.
    bench.done(master(1, 2, 2, 0));
    bench.done(master(2, 3, 2, 0));
    for (index, by) in [(1, 2.0), (2, 2.0)] {
        let (code, reason, refusal) = bench.refused(master(3, index, 2, 0));
        assert_eq!((code, reason, refusal.axis.get(), refusal.got.get()), (1, Reason::MasterCycle, 3, by));
    }
    bench.done(master(3, 4, 2, 0));
    assert_eq!(told(bench.refused(master(4, 1, 2, 0))), (1, Reason::MasterCycle, 2, 3.0));
    // An axis that follows no more is no part of a cycle, and does not remember its master.
    bench.done(PrfTrap { core, profile: 2.into() });
    bench.done(master(4, 1, 2, 0));
    bench.done(prf(2, 0));
    assert_eq!(bench.refused(GetFollowMaster { core, profile }).1, Reason::NoMaster);
    assert_eq!(bench.refused(master(2, 3, 2, 0)).1, Reason::MasterCycle);
}

#[test]
fn bad_settings() {
    let mut bench = Bench::gus();
    bench.done(prf(2, 0));
    for which in [0, 3] {
        assert_eq!(told(bench.refused(event(2, which, 1, 0))), (7, Reason::Selector, 2, f64::from(which)));
    }
    assert_eq!(told(bench.refused(event(2, 2, 0, 0))), (7, Reason::Selector, 3, 0.0));
    assert_eq!(told(bench.refused(event(2, 1, 2, 0))), (7, Reason::Selector, 3, 2.0));
    assert_eq!(told(bench.refused(memory(2, 2))), (7, Reason::Selector, 2, 2.0));
    for fifo in [-1, 2] {
        assert_eq!(told(bench.refused(space_of(2, fifo))), (7, Reason::Selector, 2, f64::from(fifo)));
        assert_eq!(told(bench.refused(clear(2, fifo))), (7, Reason::Selector, 2, f64::from(fifo)));
        assert_eq!(told(bench.refused(data(2, 1, 1.0, 0, fifo))), (7, Reason::Selector, 5, f64::from(fifo)));
    }
    // Starts: no master, no data, servo off, axes that are not in the mode, and a mask of 0.
    bench.done(start(0, 0));
    bench.done(switch(0));
    assert_eq!(bench.refused(start(2, 0)).1, Reason::NoMaster);
    bench.done(master(2, 1, 2, 0));
    bench.done(data(2, 100, 1.0, 0, 1));
    assert_eq!(bench.refused(start(2, 0)).1, Reason::FifoEmpty);
    assert_eq!(bench.refused(start(2, 2)).1, Reason::ServoOff);
    assert_eq!(bench.refused(start(3, 2)).1, Reason::WrongMode);
    assert_eq!(told(bench.refused(start(0x100, 0))), (7, Reason::OutOfRange, 1, 256.0));
    // A switch is for an axis that runs.
    assert_eq!(told(bench.refused(switch(2))), (1, Reason::NotRunning, 255, 0.0));
}

#[test]
fn data_of_every_kind() {
    let mut bench = Bench::gus();
    bench.done(prf(2, 0));
    bench.done(data(2, 100, 50.0, 0, 0));
    for slave in [f64::NAN, f64::INFINITY] {
        assert_eq!(bench.refused(data(2, 200, slave, 0, 0)).1, Reason::NotFinite);
    }
    assert_eq!(told(bench.refused(data(2, 200, 1.2e12, 0, 0))), (7, Reason::BeyondTravel, 3, 1.2e12));
    for kind in [-1, 4] {
        assert_eq!(told(bench.refused(data(2, 200, 1.0, kind, 0))), (7, Reason::Selector, 4, f64::from(kind)));
    }
    for back in [100, 99, 0] {
        let (code, reason, refusal) = bench.refused(data(2, back, 60.0, 0, 0));
        assert_eq!((code, reason, refusal.field, refusal.low.get()), (7, Reason::MasterOrder, 2, 100.0));
    }
    for mixed in [-1, -200] {
        assert_eq!(told(bench.refused(data(2, mixed, 60.0, 0, 0))), (7, Reason::MixedSigns, 2, f64::from(mixed)));
    }
    assert_eq!(bench.refused(data(2, 0, 1.0, 0, 1)).1, Reason::MasterOrder, "not even the first may be 0");
    assert_eq!(spaces(&mut bench, 2), [15, 16], "nothing of it was taken");
    // A FIFO whose masters are all negative, and its order; the other FIFO goes upwards.
    bench.done(data(2, -100, 50.0, 0, 1));
    assert_eq!(bench.refused(data(2, -100, 60.0, 0, 1)).1, Reason::MasterOrder);
    assert_eq!(bench.refused(data(2, 100, 60.0, 0, 1)).1, Reason::MixedSigns);
    bench.done(data(2, -300, 50.0, 3, 1));
    bench.done(prf(3, -1));
    bench.done(data(3, -100, 50.0, 0, 0));
    bench.done(data(3, 100, 50.0, 0, 1));
    bench.done(prf(4, 1));
    assert_eq!(told(bench.refused(data(4, -100, 50.0, 0, 0))), (7, Reason::NegativeProgress, 2, -100.0));
    // Sixteen, then none; with the large memory 512. Setting a size clears both FIFOs.
    for place in 1..16 {
        let taken = bench.done(data(2, 100 + place, 50.0, 1, 0));
        assert_eq!(i32::from(taken.space.get()), 15 - place);
    }
    let (code, reason, refusal) = bench.refused(data(2, 1000, 60.0, 0, 0));
    assert_eq!((code, reason, refusal.axis.get(), refusal.high.get()), (1, Reason::FifoFull, 2, 16.0));
    bench.done(memory(2, 1));
    assert_eq!(spaces(&mut bench, 2), [512, 512]);
    for place in 0..512 {
        bench.done(data(2, 1 + place, f64::from(place), 0, 1));
    }
    assert_eq!(bench.refused(data(2, 1000, 60.0, 0, 1)).2.high.get(), 512.0);
    assert_eq!(spaces(&mut bench, 2), [512, 0]);
    bench.done(clear(2, 1));
    assert_eq!(spaces(&mut bench, 2), [512, 512]);
}

#[test]
fn data_of_follow_ex() {
    let mut bench = Bench::gus();
    bench.done(prf_ex(2, 0));
    for percent in [-1, 101] {
        let got = f64::from(percent);
        assert_eq!(told(bench.refused(data_ex(2, 1.0, 1.0, 0, percent, 0))), (7, Reason::OutOfRange, 5, got));
    }
    for at in [f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(bench.refused(data_ex(2, at, 1.0, 0, 0, 0)).2.field, 2);
        assert_eq!(bench.refused(data_ex(2, 1.0, at, 0, 0, 0)).2.field, 3);
    }
    assert_eq!(told(bench.refused(data_ex(2, 3e9, 1.0, 0, 0, 0))), (7, Reason::OutOfRange, 2, 3e9));
    // A ratio of 10¹⁶; and one of 10⁹ that would go on for 10⁴ pulses.
    let (code, reason, refusal) = bench.refused(data_ex(2, 0.0001, 1e12, 1, 0, 0));
    assert_eq!((code, reason, refusal.field), (7, Reason::RatioTooLarge, 3));
    assert!((refusal.got.get() - 1e16).abs() < 10.0 && refusal.high.get() == 17_592_186_044_416.0);
    bench.done(data_ex(2, 0.0001, 1e5, 1, 0, 1));
    let (code, reason, refusal) = bench.refused(data_ex(2, 10_000.0, 0.0, 0, 0, 1));
    assert_eq!((code, reason, refusal.field), (7, Reason::RatioTooLarge, 3));
    bench.done(FollowClearEx { core: CORE.into(), profile: 2.into(), fifo: 1.into() });
    bench.done(data_ex(2, 0.25, 0.125, 0, 100, 0));
    let (core, profile, fifo) = (CORE.into(), 2.into(), 0.into());
    let bit = |kind: i16, index: i16, value: i16| FollowDoBitEx {
        core,
        profile,
        do_type: kind.into(),
        index: index.into(),
        value: value.into(),
        fifo,
    };
    for (kind, index, value, field) in
        [(9, 1, 1, 2), (13, 1, 1, 2), (12, 0, 1, 3), (12, 17, 1, 3), (10, 9, 1, 3), (12, 1, 2, 4)]
    {
        let (code, reason, refusal) = bench.refused(bit(kind, index, value));
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, field), "{kind} {index} {value}");
    }
    let wait = |kind: i16, index: i16, value: i16| FollowDiBitEx {
        core,
        profile,
        di_type: kind.into(),
        index: index.into(),
        value: value.into(),
        time_ms: 5.into(),
        fifo,
    };
    for (kind, index, value, field) in
        [(-1, 1, 1, 2), (6, 1, 1, 2), (4, 0, 1, 3), (4, 33, 1, 3), (0, 9, 1, 3), (4, 1, -1, 4)]
    {
        let (code, reason, refusal) = bench.refused(wait(kind, index, value));
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, field), "{kind} {index} {value}");
    }
    let now = |method: i16, buffer: i16, fifo: i16| FollowSwitchNowEx {
        core,
        profile,
        method: method.into(),
        buffer: buffer.into(),
        fifo: fifo.into(),
    };
    for (method, buffer, fifo, field) in
        [(0, 1, 0, 2), (3, 0, 0, 2), (1, 2, 0, 3), (1, -1, 0, 3), (1, 1, 2, 4), (1, 0, 2, 4)]
    {
        let (code, reason, refusal) = bench.refused(now(method, buffer, fifo));
        assert_eq!((code, reason, refusal.field), (7, Reason::Selector, field), "{method} {buffer} {fifo}");
    }
    assert_eq!(bench.refused(now(1, 0, 0)).1, Reason::NotRunning);
    assert_eq!(bench.refused(now(2, 0, 0)).1, Reason::NotRunning);
    let space = FollowSpaceEx { core, profile, fifo };
    assert_eq!(bench.done(space).value.get(), 15, "nothing of it was taken");
    // Sixteen of them, one more is refused though there is room.
    bench.done(SetFollowMemoryEx { core, profile, memory: 1.into() });
    for k in 0..4 {
        bench.done(bit(12, 1 + k, 1));
        bench.done(wait(4, 32, 0));
        bench.done(FollowDelayEx { core, profile, delay_cycles: u32::MAX.into(), fifo });
        assert_eq!(bench.done(now(2, 1, 0)).space.get(), 508 - 4 * k as u16);
    }
    let (code, reason, refusal) = bench.refused(bit(12, 1, 1));
    assert_eq!((code, reason, refusal.high.get()), (1, Reason::QueueEntries, 16.0));
    bench.done(data_ex(2, 0.25, 0.125, 0, 100, 0));
    bench.done(FollowDelayEx { core, profile, delay_cycles: 1.into(), fifo: 1.into() });
    assert_eq!(bench.done(space).value.get(), 495);
}

#[test]
fn the_asymmetric_segment_is_computed() {
    let mut bench = Bench::gus();
    let ask = |master: f64, begin: f64, end: f64, percent: f64, percent1: f64| GetFollowDataPercent2Ex {
        core: CORE.into(),
        master_pos: master.into(),
        vel_begin_ratio: begin.into(),
        vel_end_ratio: end.into(),
        percent: percent.into(),
        percent1: percent1.into(),
    };
    // Symmetric: the mean of both ends. All of the S at one end: by hand 2/3 and 1/3 of the change (the slope's
    // second integral is u²/2·(1 − u/3) of its height 2, and u³/6·2).
    assert_eq!(bench.done(ask(1000.0, 0.5, 1.0, 80.0, 40.0)).value.get(), 750.0);
    assert!((bench.done(ask(3000.0, 0.0, 1.0, 100.0, 0.0)).value.get() - 2000.0).abs() < 1e-9);
    assert!((bench.done(ask(3000.0, 0.0, 1.0, 100.0, 100.0)).value.get() - 1000.0).abs() < 1e-9);
    assert_eq!(bench.done(ask(-20.0, 0.0, 1.0, 0.0, 0.0)).value.get(), -10.0);
    assert_eq!(told(bench.refused(ask(1.0, 0.0, 1.0, 101.0, 0.0))), (7, Reason::OutOfRange, 4, 101.0));
    assert_eq!(told(bench.refused(ask(1.0, 0.0, 1.0, 50.0, 51.0))), (7, Reason::OutOfRange, 5, 51.0));
    assert_eq!(bench.refused(ask(f64::NAN, 0.0, 1.0, 50.0, 51.0)).1, Reason::NotFinite);
    assert_eq!(bench.refused(ask(1.0, 0.0, f64::INFINITY, 50.0, 51.0)).2.field, 3);
}
