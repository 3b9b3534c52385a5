//! Follow and FollowEx over the wire: settings, slots, admission ahead of time. Bad input is
//! refused with its code, reason and parameter, and changes nothing.
use crate::bench;
use bench::Bench;
use bench::follow::{
    clear, data, data_ex, event, master, memory, mode, prf, prf_ex, reported, space_of, spaces, start, switch,
};
use protocol::command::*;
use protocol::reason::Reason;
use zerocopy::little_endian::I16;

const CORE: i16 = 1;

/// What is read before SetFollowMaster: no axis, and the type and item of one that leaves them out
/// (GXN commands 8, 12).
const NO_MASTER: FollowMasterReply =
    FollowMasterReply { master_index: I16::ZERO, master_type: I16::new(2), master_item: I16::ZERO };

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
    assert_eq!(reported(bench.refused(prf(2, 1))), (1, Reason::DirectionDiffers, 2, 0.0));
    bench.done(prf_ex(3, 1));
    assert_eq!(reported(bench.refused(prf_ex(3, -1))), (1, Reason::DirectionDiffers, 2, 1.0));
    assert_eq!(spaces(&mut bench, 2), [15, 16]);
    // Commands of one mode do not count in the other, nor elsewhere.
    assert_eq!(reported(bench.refused(data_ex(2, 200.0, 50.0, 0, 0, 0))), (1, Reason::WrongMode, 255, 4.0));
    assert_eq!(reported(bench.refused(data(3, 200, 50.0, 0, 0))), (1, Reason::WrongMode, 255, 10.0));
    assert_eq!(reported(bench.refused(data(1, 200, 50.0, 0, 0))), (1, Reason::WrongMode, 255, 0.0));
    // Another mode: data, master and start condition are gone; loops and memory stay.
    bench.done(master(2, 1, 2, 0));
    bench.done(event(2, 2, -1, 77));
    bench.done(memory(2, 1));
    bench.done(data(2, 100, 50.0, 0, 0));
    bench.done(prf_ex(2, -5));
    let (core, profile) = (CORE.into(), 2.into());
    assert_eq!(bench.done(GetFollowMasterEx { core, profile }), NO_MASTER);
    let found = bench.done(GetFollowEventEx { core, profile });
    assert_eq!((found.event.get(), found.pos.get()), (1, 0));
    assert_eq!(bench.done(GetFollowMemoryEx { core, profile }).value.get(), 1);
    assert_eq!(bench.done(FollowSpaceEx { core, profile, fifo: 0.into() }).value.get(), 512);
}

#[test]
fn what_was_set_is_reported() {
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
            assert_eq!(reported(bench.refused(set)), (1, Reason::MasterCycle, 2, 2.0));
            continue;
        }
        bench.done(set);
        let found = bench.done(GetFollowMaster { core, profile });
        let found = (found.master_index.get(), found.master_type.get(), found.master_item.get());
        assert_eq!(found, (index, kind, item));
    }
    let (core, profile) = two(1);
    for (which, direction, pos) in [(2, -1, -50_000), (1, 0, 5), (2, 1, i32::MAX)] {
        bench.done(event(2, which, direction, pos));
        let found = bench.done(GetFollowEvent { core, profile });
        assert_eq!((found.event.get(), found.master_dir.get(), found.pos.get()), (which, direction, pos));
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
        assert_eq!(reported(bench.refused(master(2, 1, kind, 0))), (7, Reason::MasterType, 3, f64::from(kind)));
    }
    for index in [0, 9, -1] {
        assert_eq!(reported(bench.refused(master(2, index, 2, 0))), (7, Reason::Selector, 2, f64::from(index)));
    }
    for kind in [1, 2, 3] {
        assert_eq!(reported(bench.refused(master(2, 2, kind, 0))), (7, Reason::OwnMaster, 2, 2.0));
    }
    let (core, profile) = (CORE.into(), 2.into());
    assert_eq!(bench.done(GetFollowMaster { core, profile }), NO_MASTER, "nothing was taken");
    // 1 follows 2 follows 3; 3 may follow 4, neither 1 nor 2.
    bench.done(master(1, 2, 2, 0));
    bench.done(master(2, 3, 2, 0));
    for (index, by) in [(1, 2.0), (2, 2.0)] {
        let (code, reason, refusal) = bench.refused(master(3, index, 2, 0));
        assert_eq!((code, reason, refusal.axis.get(), refusal.got.get()), (1, Reason::MasterCycle, 3, by));
    }
    bench.done(master(3, 4, 2, 0));
    assert_eq!(reported(bench.refused(master(4, 1, 2, 0))), (1, Reason::MasterCycle, 2, 3.0));
    // An axis that no longer follows is no part of a cycle, and forgets its master.
    bench.done(PrfTrap { core, profile: 2.into() });
    bench.done(master(4, 1, 2, 0));
    bench.done(prf(2, 0));
    assert_eq!(bench.done(GetFollowMaster { core, profile }), NO_MASTER);
    assert_eq!(bench.refused(master(2, 3, 2, 0)).1, Reason::MasterCycle);
}

#[test]
fn bad_settings() {
    let mut bench = Bench::gus();
    bench.done(prf(2, 0));
    for which in [0, 3] {
        assert_eq!(reported(bench.refused(event(2, which, 1, 0))), (7, Reason::Selector, 2, f64::from(which)));
    }
    assert_eq!(reported(bench.refused(event(2, 2, 0, 0))), (7, Reason::CrossingDirection, 3, 0.0));
    assert_eq!(reported(bench.refused(event(2, 1, 2, 0))), (7, Reason::Selector, 3, 2.0));
    assert_eq!(reported(bench.refused(memory(2, 2))), (7, Reason::Selector, 2, 2.0));
    for fifo in [-1, 2] {
        assert_eq!(reported(bench.refused(space_of(2, fifo))), (7, Reason::Selector, 2, f64::from(fifo)));
        assert_eq!(reported(bench.refused(clear(2, fifo))), (7, Reason::Selector, 2, f64::from(fifo)));
        assert_eq!(reported(bench.refused(data(2, 1, 1.0, 0, fifo))), (7, Reason::Selector, 5, f64::from(fifo)));
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
    assert_eq!(reported(bench.refused(start(0x100, 0))), (7, Reason::OutOfRange, 1, 256.0));
    // A switch needs a running axis.
    assert_eq!(reported(bench.refused(switch(2))), (1, Reason::NotRunning, 255, 0.0));
}

#[test]
fn data_of_every_kind() {
    let mut bench = Bench::gus();
    bench.done(prf(2, 0));
    bench.done(data(2, 100, 50.0, 0, 0));
    for slave in [f64::NAN, f64::INFINITY] {
        assert_eq!(bench.refused(data(2, 200, slave, 0, 0)).1, Reason::NotFinite);
    }
    assert_eq!(reported(bench.refused(data(2, 200, 1.2e12, 0, 0))), (7, Reason::BeyondTravel, 3, 1.2e12));
    for kind in [-1, 4] {
        assert_eq!(reported(bench.refused(data(2, 200, 1.0, kind, 0))), (7, Reason::Selector, 4, f64::from(kind)));
    }
    for back in [100, 99, 0] {
        let (code, reason, refusal) = bench.refused(data(2, back, 60.0, 0, 0));
        assert_eq!((code, reason, refusal.field, refusal.low.get()), (7, Reason::MasterOrder, 2, 100.0));
    }
    for mixed in [-1, -200] {
        assert_eq!(reported(bench.refused(data(2, mixed, 60.0, 0, 0))), (7, Reason::MixedSigns, 2, f64::from(mixed)));
    }
    assert_eq!(bench.refused(data(2, 0, 1.0, 0, 1)).1, Reason::MasterOrder, "not even the first may be 0");
    assert_eq!(spaces(&mut bench, 2), [15, 16], "nothing of it was taken");
    // A FIFO whose masters are all negative, and its order; the other FIFO is positive.
    bench.done(data(2, -100, 50.0, 0, 1));
    assert_eq!(bench.refused(data(2, -100, 60.0, 0, 1)).1, Reason::MasterOrder);
    assert_eq!(bench.refused(data(2, 100, 60.0, 0, 1)).1, Reason::MixedSigns);
    bench.done(data(2, -300, 50.0, 3, 1));
    bench.done(prf(3, -1));
    bench.done(data(3, -100, 50.0, 0, 0));
    bench.done(data(3, 100, 50.0, 0, 1));
    bench.done(prf(4, 1));
    assert_eq!(reported(bench.refused(data(4, -100, 50.0, 0, 0))), (7, Reason::NegativeProgress, 2, -100.0));
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
        assert_eq!(reported(bench.refused(data_ex(2, 1.0, 1.0, 0, percent, 0))), (7, Reason::OutOfRange, 5, got));
    }
    for at in [f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(bench.refused(data_ex(2, at, 1.0, 0, 0, 0)).2.field, 2);
        assert_eq!(bench.refused(data_ex(2, 1.0, at, 0, 0, 0)).2.field, 3);
    }
    assert_eq!(reported(bench.refused(data_ex(2, 3e9, 1.0, 0, 0, 0))), (7, Reason::OutOfRange, 2, 3e9));
    // A ratio of 10¹⁶; and one of 10⁹ that would last for 10⁴ pulses.
    let (code, reason, refusal) = bench.refused(data_ex(2, 0.0001, 1e12, 1, 0, 0));
    assert_eq!((code, reason, refusal.field), (7, Reason::RatioTooLarge, 3));
    assert!((refusal.got.get() - 1e16).abs() < 10.0 && refusal.high.get() == 17_592_186_044_416.0);
    // 2⁴⁸ exactly, whose quotient in 128 bits would be 0.
    assert_eq!(bench.refused(data_ex(2, 1.0 / 1024.0, 274_877_906_944.0, 1, 0, 0)).1, Reason::RatioTooLarge);
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
    // Symmetric: the mean of both ends. All of the S-curve at one end: by hand 2/3 and 1/3 of the
    // change (the slope's second integral is u²/2·(1 − u/3) of its height 2, and u³/6·2).
    assert_eq!(bench.done(ask(1000.0, 0.5, 1.0, 80.0, 40.0)).value.get(), 750.0);
    assert!((bench.done(ask(3000.0, 0.0, 1.0, 100.0, 0.0)).value.get() - 2000.0).abs() < 1e-9);
    assert!((bench.done(ask(3000.0, 0.0, 1.0, 100.0, 100.0)).value.get() - 1000.0).abs() < 1e-9);
    assert_eq!(bench.done(ask(-20.0, 0.0, 1.0, 0.0, 0.0)).value.get(), -10.0);
    assert_eq!(reported(bench.refused(ask(1.0, 0.0, 1.0, 101.0, 0.0))), (7, Reason::OutOfRange, 4, 101.0));
    assert_eq!(reported(bench.refused(ask(1.0, 0.0, 1.0, 50.0, 51.0))), (7, Reason::OutOfRange, 5, 51.0));
    assert_eq!(bench.refused(ask(f64::NAN, 0.0, 1.0, 50.0, 51.0)).1, Reason::NotFinite);
    assert_eq!(bench.refused(ask(1.0, 0.0, f64::INFINITY, 50.0, 51.0)).2.field, 3);
}

#[test]
fn an_asymmetric_segment_takes_a_slot_for_each_part() {
    let mut bench = Bench::gus();
    bench.done(prf_ex(2, 0));
    let send = |master: f64, slave: f64, begin: f64, end: f64, percent: i16| FollowDataPercent2Ex {
        core: CORE.into(),
        profile: 2.into(),
        master_segment: master.into(),
        slave_segment: slave.into(),
        vel_begin_ratio: begin.into(),
        vel_end_ratio: end.into(),
        percent: percent.into(),
        fifo: 0.into(),
    };
    let took = |bench: &mut Bench<8>, request: FollowDataPercent2Ex| {
        let reply = bench.done(request);
        (reply.space.get(), reply.percent1.get())
    };
    // The displacement decides the share of the first half: 1/2 of a symmetric one; by hand a mean
    // of 4/9 with 60 % in all: 0.7·4/9 = 0.44 − x·0.3, so x = 0.43.
    assert_eq!(took(&mut bench, send(1000.0, 500.0, 0.0, 1.0, 60)), (13, 30));
    assert_eq!(took(&mut bench, send(1900.0, 900.0, 0.0, 1.0, 60)), (10, 43));
    // Only one part: no S-curve at all; all of it at one end.
    assert_eq!(took(&mut bench, send(2000.0, 1000.0, 1.0, 1.0, 0)), (9, 0));
    assert_eq!(took(&mut bench, send(2300.0, 1200.0, 0.0, 1.0, 100)), (8, 0));
    assert_eq!(took(&mut bench, send(2600.0, 1300.0, 0.0, 1.0, 100)), (7, 100));
    // A displacement that these ratios cannot make: the limits are reported.
    let (code, reason, refusal) = bench.refused(send(2900.0, 1800.0, 0.0, 1.0, 100));
    assert_eq!((code, reason, refusal.field, refusal.got.get()), (7, Reason::OutOfRange, 3, 1800.0));
    assert!((refusal.low.get() - 1400.0).abs() < 1e-9 && (refusal.high.get() - 1500.0).abs() < 1e-9);
    assert_eq!(bench.refused(send(2600.0, 1400.0, 0.0, 1.0, 100)).1, Reason::MasterOrder);
    assert_eq!(bench.refused(send(-2700.0, 1400.0, 0.0, 1.0, 100)).1, Reason::MixedSigns);
    assert_eq!(bench.refused(send(2700.0, 1400.0, 0.0, 1.0, 101)).2.field, 6);
    assert_eq!(bench.refused(send(2700.0, 1400.0, f64::NAN, 1.0, 50)).2.field, 4);
    assert_eq!(bench.refused(send(2700.0, 1400.0, 0.0, 1e14, 50)).2.field, 5);
    // If two of three parts fit, none is taken.
    assert_eq!(took(&mut bench, send(3600.0, 1800.0, 0.0, 1.0, 50)), (4, 25));
    assert_eq!(took(&mut bench, send(4600.0, 2300.0, 0.0, 1.0, 50)), (1, 25));
    assert_eq!(bench.refused(send(5600.0, 2800.0, 0.0, 1.0, 50)).1, Reason::FifoFull);
    let space = FollowSpaceEx { core: CORE.into(), profile: 2.into(), fifo: 0.into() };
    assert_eq!(bench.done(space).value.get(), 1);
    bench.done(data_ex(2, 4700.0, 2301.0, 0, 0, 0));
}
