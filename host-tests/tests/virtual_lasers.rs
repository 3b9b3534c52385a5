//! Lasers of the virtual controller: what its outputs do, what the trace shows of it, and the
//! interlock.
use client::{Call, Client, Options, Quiet};
use plant::beam::{ChannelLevels, SignalChange};
use protocol::command::*;
use std::sync::{Arc, Mutex};
use trace::{Item, Reader};
use virtual_board::{Board, Config, Shared, VirtualLink, share};

const TICK_NS: u64 = 250_000;

fn open() -> (Client, Shared) {
    let board = share(Board::new(Config::default()));
    let client = Client::open(Box::new(VirtualLink::new(board.clone())), Options::default()).unwrap();
    (client, board)
}

/// Changes of a channel: those of each output by themselves, pulses one by one, a level that lasts
/// for no time left out.
#[derive(Debug, Default, PartialEq)]
struct Edges {
    energy: Vec<(u64, bool)>,
    switch: Vec<(u64, bool)>,
    dac: Vec<(u64, i16)>,
}

impl Edges {
    fn add(&mut self, change: &SignalChange, zero: u64) {
        match *change {
            SignalChange::Switch { at, level } => self.switch.push((at - zero, level)),
            SignalChange::Dac { at, code } => self.dac.push((at - zero, code)),
            SignalChange::Energy { at, level } => self.energy(at - zero, level),
            SignalChange::Pulses(burst) => {
                for (begin, end) in burst.pulses() {
                    self.energy(begin - zero, true);
                    self.energy(end - zero, false);
                }
            }
        }
    }

    fn energy(&mut self, at: u64, level: bool) {
        if self.energy.last().is_some_and(|last| last.0 == at) {
            self.energy.pop();
        } else {
            self.energy.push((at, level));
        }
    }
}

/// Both channels with delays, FPK, standby, every mode, and a mark that is cut by a change of mode.
fn marks() -> Vec<Call> {
    let (core, c0, c1) = (1.into(), 0.into(), 1.into());
    let sleep = |us: u64| Call::of(Sleep { ns: (us * 1000).into() });
    let gate = |channel: i16, value: u16| Call::of(SetHSIOOpt { core, value: value.into(), channel: channel.into() });
    let mode = |channel: i16, mode: i16, max: f64| {
        Call::of(LaserPowerMode {
            core,
            mode: mode.into(),
            max: max.into(),
            min: 0.0.into(),
            channel: channel.into(),
            delay_mode: 0.into(),
        })
    };
    let power = |channel: i16, power: f64| Call::of(LaserPrfCmd { core, power: power.into(), channel: channel.into() });
    let duty = |frequency: f64, duty: f64| (frequency.into(), duty.into());
    let (frequency, standby) = duty(3.0, 20.0);
    vec![
        Call::of(SetAxisMode { core, axis: 7.into(), mode: 1.into() }),
        Call::of(SetAxisMode { core, axis: 8.into(), mode: 1.into() }),
        mode(0, 0, 100.0),
        Call::of(LaserOutFrq { core, frequency: 333.333.into(), channel: c0 }),
        power(0, 37.5),
        Call::of(SetLevelDelay { core, off_delay_us: 130.into(), on_delay_us: 77.into(), channel: c0 }),
        Call::of(SetWaitPulse { core, mode: 1.into(), frequency, duty: standby, channel: c0 }),
        mode(1, 1, 1000.0),
        Call::of(SetPulseWidth { core, width_us: 40.into(), channel: c1 }),
        power(1, 7.0),
        Call::of(EnaFPK {
            core,
            time1_us: 55.into(),
            time2_us: 31.into(),
            laser_off_delay_us: 400.into(),
            channel: c1,
        }),
        gate(0, 1),
        gate(1, 1),
        sleep(1_300),
        power(0, 80.0),
        power(1, 11.0),
        sleep(1_300),
        gate(0, 0),
        gate(1, 0),
        sleep(3_000),
        gate(0, 1),
        sleep(600),
        mode(0, 2, 10.0),
        power(0, 5.0),
        gate(0, 1),
        sleep(1_000),
        power(0, 10.0),
        sleep(1_000),
        gate(0, 0),
        sleep(2_000),
    ]
}

#[test]
fn the_trace_reports_every_edge_of_the_outputs() {
    for every in [1u32, 7] {
        let (client, board) = open();
        board.lock().unwrap().record_beam(true);
        let reported: Arc<Mutex<([Edges; 2], bool, u64)>> = Arc::default();
        let (theirs, mut reader) = (Arc::clone(&reported), Reader::new());
        client.trace_to(move |bytes| {
            let mut reported = theirs.lock().unwrap();
            reader
                .feed(bytes, |item| {
                    match item {
                        Item::Header(header) => assert_eq!(header.lasers.len(), 2),
                        Item::Light { .. } | Item::Output(_) | Item::Analog(_) | Item::Zero { .. } => {}
                        Item::Laser { laser, change } => reported.0[laser].add(&change, 0),
                        Item::Row(row) => reported.2 = row.t_ns,
                        Item::End { .. } => reported.1 = true,
                    }
                    Ok(())
                })
                .unwrap();
        });
        let begin = Trace { every: every.into(), axes: 0.into(), lasers: 3, crds: 0, over_link: 0, edges: 1 };
        client.call(begin).unwrap();
        let mut calls = marks();
        calls.push(Call::of(Trace::default()));
        assert!(client.run(calls, true, &mut Quiet).unwrap().failed.is_none());
        client.sleep(std::time::Duration::from_millis(20)).unwrap();
        let mut board = board.lock().unwrap();
        let zero = board.program_zero_ns();
        let mut outputs: [Edges; 2] = Default::default();
        for beam in board.take_beam() {
            outputs[usize::from(beam.channel)].add(&beam.change, zero);
        }
        let (mut edges, ended, end) = std::mem::take(&mut *reported.lock().unwrap());
        assert!(ended);
        for (traced, output) in edges.iter_mut().zip(&mut outputs) {
            // After the last row nothing is reported; its own instant may be.
            for edges in [traced, output] {
                edges.energy.retain(|(at, _)| *at < end);
                edges.switch.retain(|(at, _)| *at < end);
                edges.dac.retain(|(at, _)| *at < end);
            }
        }
        assert_eq!(edges, outputs, "a row every {every} ticks");
        let [first, second] = edges;
        // By hand: on at the first tick, 77 µs later the first pulse of 37.5 % of 3.000003 µs; off
        // 130 µs late.
        assert_eq!(first.switch[..2], [(TICK_NS + 77_000, true), (2_750_000 + 130_000, false)]);
        let light = first.energy.iter().position(|edge| *edge == (TICK_NS + 77_000, true)).unwrap();
        assert_eq!(
            first.energy[light + 1..light + 3],
            [(TICK_NS + 77_000 + 1_125, false), (TICK_NS + 77_000 + 3_000, true)]
        );
        // Another mode at 6.25 ms ends everything, and 5 V are output 77 µs later.
        assert!(first.energy.last().unwrap().0 <= 6_250_000);
        assert_eq!(first.dac[..2], [(6_250_000 + 77_000, 16_384), (7_250_000, 32_767)]);
        // FPK: 55 µs on the switch, pulses from 31 µs on, 40 µs each.
        assert_eq!(second.switch, [(TICK_NS, true), (TICK_NS + 55_000, false)]);
        assert_eq!(second.energy[..2], [(TICK_NS + 31_000, true), (TICK_NS + 71_000, false)]);
        assert!(
            first.energy.len() > 1_500 && second.energy.len() > 30,
            "{} {}",
            first.energy.len(),
            second.energy.len()
        );
    }
}

#[test]
fn a_trace_begins_with_what_the_outputs_carry() {
    let (client, board) = open();
    let mut calls = marks();
    // Standby of channel 0 goes on, channel 1 is dark.
    calls.truncate(20);
    calls.extend([Call::of(Sleep { ns: 2_000_000.into() })]);
    assert!(client.run(calls, true, &mut Quiet).unwrap().failed.is_none());
    board.lock().unwrap().record_beam(true);
    let reported: Arc<Mutex<Edges>> = Arc::default();
    let (theirs, mut reader) = (Arc::clone(&reported), Reader::new());
    client.trace_to(move |bytes| {
        let mut reported = theirs.lock().unwrap();
        let taken = reader.feed(bytes, |item| {
            if let Item::Laser { laser: 0, change } = item {
                reported.add(&change, 0);
            }
            Ok(())
        });
        taken.unwrap();
    });
    client.call(Trace { every: 1.into(), axes: 0.into(), lasers: 1, crds: 0, over_link: 0, edges: 1 }).unwrap();
    let calls = [Call::of(Sleep { ns: 5_000_000.into() }), Call::of(Trace::default())];
    assert!(client.run(calls, true, &mut Quiet).unwrap().failed.is_none());
    client.sleep(std::time::Duration::from_millis(20)).unwrap();
    let reported = reported.lock().unwrap();
    // 3 kHz for 5 ms, in a phase of its own: 15 pulses, of 66.666 µs.
    let begins = reported.energy.iter().filter(|edge| edge.1).count();
    assert!((15..=16).contains(&begins), "{:?}", reported.energy);
    assert_eq!(reported.energy[1].0 - reported.energy[0].0, 66_666);
}

#[test]
fn nothing_is_output_from_power_on() {
    let (client, board) = open();
    board.lock().unwrap().record_beam(true);
    client.sleep(std::time::Duration::from_millis(50)).unwrap();
    let mut board = board.lock().unwrap();
    assert_eq!([board.laser(0), board.laser(1)], [ChannelLevels::default(); 2]);
    assert_eq!(board.take_beam(), []);
}

#[test]
fn the_interlock_rests_everything_until_it_is_cleared() {
    let (client, board) = open();
    board.lock().unwrap().record_beam(true);
    let mut calls = marks();
    calls.truncate(13);
    // The script ends with light on; nothing switches it off.
    assert!(client.run(calls, true, &mut Quiet).unwrap().failed.is_none());
    let status =
        |channel: i16| client.call(GetLaserFault { core: 1.into(), channel: channel.into() }).unwrap().value.get();
    client.sleep(std::time::Duration::from_millis(2)).unwrap();
    assert_eq!([status(0), status(1)], [0, 0]);
    let stop = {
        let mut board = board.lock().unwrap();
        assert!(board.laser(0).switch, "light is on");
        board.inputs_mut().interlock = true;
        board.now()
    };
    client.sleep(std::time::Duration::from_millis(10)).unwrap();
    assert_eq!([status(0), status(1)], [1, 1]);
    let mut edges: [Edges; 2] = Default::default();
    for beam in board.lock().unwrap().take_beam() {
        edges[usize::from(beam.channel)].add(&beam.change, 0);
    }
    for (channel, edges) in edges.iter().enumerate() {
        assert!(
            edges.energy.last().is_some_and(|last| last.0 <= stop && !last.1),
            "{channel}: {:?}",
            edges.energy.last()
        );
        assert!(edges.switch.last().is_some_and(|last| last.0 <= stop && !last.1), "{channel}: {:?}", edges.switch);
    }
    assert_eq!(edges[0].switch.last(), Some(&(stop, false)), "the switch goes off at that instant");
    // It cannot be cleared while the input is active; standby does not come back either.
    let clear = |channel: i16| client.call(ClrLaserFault { core: 1.into(), channel: channel.into() });
    assert_eq!(clear(0).unwrap_err().code, 1);
    client.sleep(std::time::Duration::from_millis(5)).unwrap();
    assert_eq!(board.lock().unwrap().take_beam(), []);
    board.lock().unwrap().inputs_mut().interlock = false;
    client.sleep(std::time::Duration::from_millis(1)).unwrap();
    assert_eq!(board.lock().unwrap().take_beam(), [], "the latch holds");
    clear(0).unwrap();
    client.sleep(std::time::Duration::from_millis(2)).unwrap();
    assert_eq!(status(0), 0);
    let back = board.lock().unwrap().take_beam();
    assert!(!back.is_empty() && back.iter().all(|beam| beam.channel == 0), "standby is back, on the cleared channel");
    assert!(!board.lock().unwrap().laser(0).switch, "light is not");
}

/// What both channels do in the first calls of [`marks`] and 5 ms after them, with the interlock
/// raised that long after the last tick of the calls; and the instant of that tick.
fn stopped_after(calls: usize, ns: Option<u64>) -> ([Edges; 2], u64) {
    let (client, board) = open();
    board.lock().unwrap().record_beam(true);
    let calls = marks().into_iter().take(calls);
    assert!(client.run(calls, true, &mut Quiet).unwrap().failed.is_none());
    let tick = board.lock().unwrap().now();
    if let Some(ns) = ns {
        board.lock().unwrap().raise_interlock(tick + ns);
    }
    client.sleep(std::time::Duration::from_millis(5)).unwrap();
    assert_eq!(board.lock().unwrap().inputs_mut().interlock, ns.is_some());
    let mut edges: [Edges; 2] = Default::default();
    for beam in board.lock().unwrap().take_beam() {
        edges[usize::from(beam.channel)].add(&beam.change, 0);
    }
    (edges, tick)
}

/// The edges of an output before an instant, and that it is at rest from then on.
fn rests_at<T: Copy + PartialEq + Default>(edges: &[(u64, T)], at: u64) -> Vec<(u64, T)> {
    let mut until: Vec<_> = edges.iter().copied().filter(|edge| edge.0 < at).collect();
    if until.last().is_some_and(|last| last.1 != T::default()) {
        until.push((at, T::default()));
    }
    until
}

#[test]
fn the_interlock_acts_between_two_ticks() {
    let mut cut = [[0; 3]; 2];
    // Light in a duty and in frequency mode; standby; light in analog mode.
    for calls in [13, 20, 28] {
        let (free, tick) = stopped_after(calls, None);
        // Over two ticks, the first and last ns of one, and a tick itself.
        let sweep = (1..40).map(|step| step * 12_547);
        for ns in sweep.chain([1, TICK_NS - 1, TICK_NS, TICK_NS + 1]) {
            let (edges, again) = stopped_after(calls, Some(ns));
            assert_eq!(tick, again, "the runs are the same until then");
            let at = tick + ns;
            for (channel, (edges, free)) in edges.iter().zip(&free).enumerate() {
                let expected = Edges {
                    energy: rests_at(&free.energy, at),
                    switch: rests_at(&free.switch, at),
                    dac: rests_at(&free.dac, at.next_multiple_of(TICK_NS)),
                };
                assert_eq!(*edges, expected, "{calls} calls, channel {channel}, {ns} ns behind the tick");
                let [energy, switch, dac] = &mut cut[channel];
                *energy += u32::from(!at.is_multiple_of(TICK_NS) && expected.energy.last() == Some(&(at, false)));
                *switch += u32::from(!at.is_multiple_of(TICK_NS) && expected.switch.last() == Some(&(at, false)));
                *dac += u32::from(expected.dac.last() == Some(&(at.next_multiple_of(TICK_NS), 0)));
            }
        }
    }
    assert!(cut[0].iter().all(|cut| *cut > 10) && cut[1][0] > 5, "{cut:?}");
}

#[test]
fn the_trace_reports_that_everything_rests() {
    let (client, board) = open();
    board.lock().unwrap().record_beam(true);
    let reported: Arc<Mutex<([Edges; 2], u64)>> = Arc::default();
    let (theirs, mut reader) = (Arc::clone(&reported), Reader::new());
    client.trace_to(move |bytes| {
        let mut reported = theirs.lock().unwrap();
        let taken = reader.feed(bytes, |item| {
            match item {
                Item::Laser { laser, change } => reported.0[laser].add(&change, 0),
                Item::Row(row) => reported.1 = row.t_ns,
                Item::Header(_)
                | Item::Light { .. }
                | Item::Output(_)
                | Item::Analog(_)
                | Item::Zero { .. }
                | Item::End { .. } => {}
            }
            Ok(())
        });
        taken.unwrap();
    });
    client.call(Trace { every: 3.into(), axes: 0.into(), lasers: 3, crds: 0, over_link: 0, edges: 1 }).unwrap();
    let mut calls = marks();
    calls.truncate(13);
    calls.push(Call::of(Sleep { ns: 3_100_000.into() }));
    assert!(client.run(calls, true, &mut Quiet).unwrap().failed.is_none());
    board.lock().unwrap().inputs_mut().interlock = true;
    client.sleep(std::time::Duration::from_millis(4)).unwrap();
    client.call(Trace::default()).unwrap();
    client.sleep(std::time::Duration::from_millis(4)).unwrap();
    let mut board = board.lock().unwrap();
    let zero = board.program_zero_ns();
    let mut outputs: [Edges; 2] = Default::default();
    for beam in board.take_beam() {
        outputs[usize::from(beam.channel)].add(&beam.change, zero);
    }
    let reported = reported.lock().unwrap();
    assert_eq!(reported.0, outputs);
    let last = reported.0[0].switch.last().copied();
    assert!(last.is_some_and(|(at, level)| !level && at % TICK_NS == 0 && at < reported.1), "{last:?}");
    assert!(reported.0[0].energy.last().is_some_and(|edge| !edge.1 && edge.0 <= last.map_or(0, |last| last.0)));
}
