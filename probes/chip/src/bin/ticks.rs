#![no_std]
#![no_main]
//! Counts the instructions of ticks, in QEMU with `-icount shift=6` or more.
//!
//! Out, by semihosting: one line a tick, `CASE MARK COUNT`. COUNT is in periods of the 25 MHz
//! SysTick (40 ns), without the cost of the reading itself; `xtask` turns it into instructions, of
//! which each takes 2^shift ns. MARK says what the tick did:
//!
//! * `start`: it executed the commands; `change`: every running axis entered another segment;
//!   `inside`: none did; `idle`.
//! * `pvt-…`, `follow-…`, `shaped-…`: the same in PVT, Follow and FollowEx. In case 8 of Follow and
//!   FollowEx seven axes follow the eighth.
//! * `…-ready`: a start after ticks that could prepare it.
//! * `trap` and `smooth`: Traps start; `…-inside`: they run; `stop`: they begin to stop;
//!   `stop-ramp`: the tick after that.
//!
//! The machine under the tick only stores its set-points and outputs: the counts are of the tick
//! alone.
use cortex_m_semihosting::hprintln;
use dispatcher::plan::pvt::{FieldIndices, Scratch, SplineScratch, TableDraft, TableKind};
use hal as _; // the vector table
use probes::clock;
use probes::counted::Counted;
use probes::{AXES, STORES, TABLE_STORES, Thread};
use servo::laser::{self, Carrier, ChannelChange, Clock, Delays, Family, FixedTrain, Power};
use servo::segment::follow;
use servo::segment::pt::{Chain, Segment};
use servo::segment::pvt::TABLES;
use servo::segment::ramp::{Accel, Speed};
use servo::tick_command::{LaneEntry, MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, Ns, StepLimit};
use servo::view::StopReason;

/// Ticks counted in each case.
const TICKS: usize = 400;
/// Segments of a pass, over and over.
const SEGMENTS: u32 = 24;
/// Duration of each, ms: 16 ticks.
const SEGMENT_MS: i32 = 4;

probes::exit_on_panic!();

/// A tick that is counted, and the thread's halves of its hand-overs.
struct Bench {
    tick: Counted<AXES>,
    thread: Thread,
    seq: u32,
}

impl Bench {
    fn push(&mut self, command: TickCommand) {
        self.seq += 1;
        assert!(
            self.thread.immediate.push(LaneEntry { seq: self.seq, delay: Ns(0), command }).is_ok(),
            "the lane is full"
        );
    }

    /// One counted tick, printed.
    fn step(&mut self, case: &str, mark: Option<&str>) {
        self.step_of(case, mark, ["change", "inside"]);
    }

    fn step_of(&mut self, case: &str, mark: Option<&str>, [change, inside]: [&str; 2]) {
        let before = *self.thread.view.read();
        let count = self.tick.step();
        let after = self.thread.view.read();
        let changed = before.axes[0].motion.c != after.axes[0].motion.c;
        let mark = mark.unwrap_or(if changed { change } else { inside });
        hprintln!("{} {} {}", case, mark, count);
        while self.thread.events.pop().is_some() {}
    }

    /// Gives an axis its pass: positions that differ from axis to axis and come back to 0.
    fn load(&mut self, axis: Axis) {
        let mut chain = Chain::default();
        for k in 1..=SEGMENTS {
            let place = if k == SEGMENTS { 0 } else { (k * 37 + axis.index() as u32 * 11) * (k % 5 + 1) };
            let kind = if k == SEGMENTS { 2 } else { (k % 3) as i16 };
            let position = f64::from(place) + 0.37;
            let admitted =
                Segment::admit(position.to_bits(), k as i32 * SEGMENT_MS, kind, &chain, StepLimit::FULL_SCALE);
            let Ok((segment, next)) = admitted else { panic!("segment {k} is refused: {admitted:?}") };
            STORES[axis.index()].write(k - 1, segment);
            chain = next;
        }
    }

    /// Gives an axis a table of its own: as many segments, of the same length.
    fn load_table(&mut self, axis: Axis, scratch: &mut Scratch<'_>) {
        let (table, fields) = (axis.index() as u8, FieldIndices { count: 0, whole: 0, point: 0 });
        let draft =
            TableDraft::begin(TableKind::Pvt, SEGMENTS as i32 + 1, fields, StepLimit::FULL_SCALE, true, scratch);
        let Ok(mut draft) = draft else { panic!("the table is refused") };
        for k in 0..=SEGMENTS {
            let place = if k == SEGMENTS { 0 } else { (k * 37 + axis.index() as u32 * 11) * (k % 5 + 1) };
            let vel = f64::from(k % 7) - 3.1;
            let point = [f64::from(k * SEGMENT_MS as u32), f64::from(place) + 0.37, vel];
            assert!(draft.point(&point, scratch).is_ok(), "point {k} is refused");
        }
        let Some(Ok(sealed)) = draft.finish(scratch) else { panic!("the table is refused") };
        for index in 0..sealed.points() {
            TABLE_STORES.write_point(table, index, sealed.point(scratch, index).unwrap_or_default());
        }
        TABLE_STORES.write_header(table, sealed.header().admit().unwrap_or_default());
    }

    /// Ticks in which the next start of every axis is prepared; `first` is the mark of a start
    /// without them.
    fn prepare_start(&mut self, case: &str, ready: bool, [first, then]: [&'static str; 2]) -> &'static str {
        if !ready {
            return first;
        }
        for _ in 0..2 * AXES {
            self.step(case, Some("getting-ready"));
        }
        then
    }

    fn run_tables(&mut self, case: &str, running: usize, ready: bool, scratch: &mut Scratch<'_>) {
        let mut axes = AxisMask(0);
        for axis in (0..running).filter_map(Axis::new) {
            self.load_table(axis, scratch);
            axes.0 |= axis.mask().0;
            self.push(TickCommand::Servo { axis, on: true });
            self.push(TickCommand::SetMode { axis, mode: MotionMode::Pvt });
            self.push(TickCommand::PvtLoop { axis, passes: 0 });
            self.push(TickCommand::PvtSelect { axis, table: axis.index() as u8 });
        }
        self.step(case, Some("pvt-set"));
        let mark = self.prepare_start(case, ready, ["pvt-start", "pvt-ready"]);
        self.push(TickCommand::PvtStart { axes });
        self.step(case, Some(mark));
        let now = *self.thread.view.read();
        assert!(now.axes.iter().take(running).all(|a| a.table_until.0 == u64::MAX), "an axis does not run");
        for _ in 0..if ready { 0 } else { TICKS } {
            self.step_of(case, None, ["pvt-change", "pvt-inside"]);
        }
        self.push(TickCommand::Reset { axes });
        self.step(case, Some("reset"));
    }

    /// Axes follow the last one, which jogs: a pass of segments each, all entered on the same
    /// ticks.
    fn run_follow(
        &mut self,
        case: &str,
        running: usize,
        (shaped, ready): (bool, bool),
        [start, change, inside]: [&'static str; 3],
    ) {
        let Some(master) = Axis::new(AXES - 1) else { panic!("no axis") };
        let mode = if shaped { MotionMode::FollowEx } else { MotionMode::Follow };
        let mut axes = AxisMask(0);
        self.push(TickCommand::Servo { axis: master, on: true });
        self.push(TickCommand::SetMode { axis: master, mode: MotionMode::Jog });
        let acc = Accel::admit(1000f64.to_bits()).unwrap_or_default();
        self.push(TickCommand::JogPrm { axis: master, acc, dec: acc, smooth: 0 });
        self.push(TickCommand::TargetSpeed {
            axis: master,
            speed: Speed::admit(5f64.to_bits(), StepLimit::FULL_SCALE).unwrap_or_default(),
        });
        for axis in (0..running).filter_map(Axis::new).filter(|axis| *axis != master) {
            let mut chain = follow::FollowChain::default();
            for k in 1..=SEGMENTS {
                let place = if k == SEGMENTS { 0 } else { (k * 37 + axis.index() as u32 * 11) * (k % 5 + 1) };
                let (to, slave) = (f64::from(k * 5 * SEGMENT_MS as u32), f64::from(place) + 0.37);
                let percent = if shaped { 37 } else { 0 };
                let direction = follow::Direction::Both;
                let kind = (k % 3) as i16;
                let admitted =
                    follow::FollowEntry::segment(to.to_bits(), slave.to_bits(), kind, percent, direction, &chain);
                let Ok((entry, next)) = admitted else { panic!("segment {k} is refused: {admitted:?}") };
                STORES[axis.index()].write_entry(0, k - 1, entry);
                chain = next;
            }
            axes.0 |= axis.mask().0;
            self.push(TickCommand::Servo { axis, on: true });
            self.push(TickCommand::SetMode { axis, mode });
            self.push(TickCommand::FollowMaster {
                axis,
                master: follow::Master { axis: master, value: follow::MasterPosition::Planned },
            });
            self.push(TickCommand::FollowLoop { axis, passes: 0 });
            let tail = chain.tail();
            self.push(TickCommand::FollowCommit { axis, fifo: 0, end: SEGMENTS, cleared: 0, tail });
        }
        self.push(TickCommand::Update { axes: master.mask() });
        self.step(case, Some("follow-set"));
        self.step(case, Some("follow-set"));
        let start = self.prepare_start(case, ready, [start; 2]);
        self.push(TickCommand::FollowStart { axes, fifo1: AxisMask(0) });
        self.step(case, Some(start));
        // The master's ramp is over before what is counted.
        for _ in 0..SEGMENTS {
            self.step(case, Some("follow-set"));
        }
        for _ in 0..if ready { 0 } else { TICKS } {
            self.step_of(case, None, [change, inside]);
        }
        let now = *self.thread.view.read();
        assert!(
            now.axes.iter().zip(0..running).all(|(a, _)| a.lead.is_some() || a.mode == MotionMode::Jog),
            "it stands"
        );
        self.push(TickCommand::Reset { axes: AxisMask(axes.0 | master.mask().0) });
        self.step(case, Some("reset"));
    }

    /// A Trap of every axis, smoothed or not, begun on one tick and stopped smoothly on another.
    fn run_ramps(&mut self, case: &str, running: usize, smooth: Ns, ready: bool, [start, inside]: [&'static str; 2]) {
        let rate = |x: f64| Accel::admit(x.to_bits()).unwrap_or_default();
        let speed = |x: f64| Speed::admit(x.to_bits(), StepLimit::FULL_SCALE).unwrap_or_default();
        let mut axes = AxisMask(0);
        for axis in (0..running).filter_map(Axis::new) {
            let k = f64::from(axis.index() as u32);
            axes.0 |= axis.mask().0;
            self.push(TickCommand::Servo { axis, on: true });
            self.push(TickCommand::SetMode { axis, mode: MotionMode::Trap });
            let (acc, dec) = (rate(0.31 + k / 17.0), rate(0.77 + k / 13.0));
            self.push(TickCommand::TrapPrm { axis, acc, dec, vel_start: speed(0.0), smooth });
            self.push(TickCommand::TargetSpeed { axis, speed: speed(7.3 + k) });
            self.push(TickCommand::TargetPosition { axis, pulses: 100_000 });
            self.push(TickCommand::StopDec { axis, smooth: rate(0.9 + k / 11.0), abrupt: rate(1000.0) });
        }
        self.step(case, Some("set-ramp"));
        let mark = self.prepare_start(case, ready, [start; 2]);
        self.push(TickCommand::Update { axes });
        self.step(case, Some(mark));
        for _ in 0..TICKS {
            self.step(case, Some(inside));
        }
        self.push(TickCommand::stop(axes, AxisMask(0)));
        let marks = if smooth.0 == 0 && !ready { ["stop", "stop-ramp"] } else { ["stopped"; 2] };
        for mark in marks {
            self.step(case, Some(mark));
        }
        for _ in 1..TICKS {
            self.step(case, Some("stopping"));
        }
        let now = *self.thread.view.read();
        assert!(now.axes.iter().take(running).all(|a| a.stop == StopReason::StopSmooth), "an axis did not stop");
        self.push(TickCommand::Reset { axes });
        self.step(case, Some("reset"));
    }

    /// Light of some channels: on and off with delays, in steady power, and with one that changes.
    fn run_lasers(&mut self, case: &str, channels: u8) {
        let clock = Clock::GHZ;
        let percent = |value: u32| Power::admit(f64::from(value).to_bits()).unwrap_or_default();
        let all = |bench: &mut Bench, change: ChannelChange| {
            for channel in 0..channels {
                bench.push(TickCommand::Laser { channel, change });
            }
        };
        let Ok(carrier) = Carrier::admit(percent(333), clock) else { panic!("the carrier is refused") };
        let fixed = FixedTrain::plan(laser::PowerMode::Duty, percent(37), Some(&carrier), clock);
        all(self, ChannelChange::Delays(Delays { off: 300, on: 300 }));
        all(self, ChannelChange::Carrier { carrier, fixed });
        self.step(case, Some("laser-set"));
        for round in 0..TICKS as u32 / 8 {
            for (on, mark) in [(true, "laser-on"), (false, "laser-off")] {
                all(self, ChannelChange::Gate { on });
                self.step(case, Some("laser-command"));
                // The edge falls into the interval that this tick plans.
                self.step(case, Some(mark));
                for _ in 0..3 {
                    self.step(case, Some(if on { "laser-steady" } else { "laser-dark" }));
                }
                let view = *self.thread.view.read();
                assert!(view.lasers.iter().take(channels.into()).all(|laser| laser.light == on), "no light");
                if on {
                    all(self, ChannelChange::Direct { power: percent(37), fixed });
                    self.step(case, Some("laser-power"));
                    all(self, ChannelChange::Direct { power: percent(round % 100), fixed: None });
                    self.step(case, Some("laser-unplanned"));
                }
            }
        }
        all(self, ChannelChange::Reset { family: Family::Gus });
        self.step(case, Some("reset"));
    }

    fn run(&mut self, case: &str, running: usize, ready: bool) {
        for _ in 0..8 {
            self.step(case, Some("idle"));
        }
        let mut axes = AxisMask(0);
        for axis in (0..running).filter_map(Axis::new) {
            self.load(axis);
            axes.0 |= axis.mask().0;
            self.push(TickCommand::Servo { axis, on: true });
            self.push(TickCommand::SetMode { axis, mode: MotionMode::PtStatic });
            self.push(TickCommand::PtLoop { axis, passes: 0 });
            self.push(TickCommand::PtCommit { axis, fifo: 0, end: SEGMENTS, epoch: 0 });
        }
        self.step(case, Some("set"));
        if running > 0 {
            let mark = self.prepare_start(case, ready, ["start", "start-ready"]);
            self.push(TickCommand::PtStart { axes, fifo1: AxisMask(0) });
            self.step(case, Some(mark));
            let now = *self.thread.view.read();
            assert!(now.axes.iter().take(running).all(|a| a.pt_state == 1), "an axis does not run");
        }
        for _ in 0..if ready { 0 } else { TICKS } {
            self.step(case, if running == 0 { Some("idle") } else { None });
        }
        self.push(TickCommand::Reset { axes });
        self.step(case, Some("reset"));
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let (tick, lanes, thread) = probes::bench().expect("once");
    let mut bench = Bench { tick: Counted::new(tick, lanes), thread, seq: 0 };
    for (case, running) in [("0", 0), ("1", 1), ("8", 8)] {
        bench.run(case, running, false);
    }
    bench.run("1", 1, true);
    bench.run("8", 8, true);
    let mut beside = SplineScratch::new();
    // No axis has the last table.
    let mut scratch = Scratch::new(&mut beside, &TABLE_STORES.points[TABLES - 1]);
    for (case, running) in [("1", 1), ("8", 8)] {
        bench.run_tables(case, running, false, &mut scratch);
        bench.run_tables(case, running, true, &mut scratch);
    }
    for (case, running) in [("1", 1), ("8", 8)] {
        bench.run_ramps(case, running, Ns(0), false, ["trap", "trap-inside"]);
        bench.run_ramps(case, running, Ns(12_000_000), false, ["smooth", "smooth-inside"]);
        bench.run_ramps(case, running, Ns(0), true, ["trap-ready", "trap-after"]);
        bench.run_ramps(case, running, Ns(12_000_000), true, ["smooth-ready", "smooth-after"]);
    }
    for (case, channels) in [("1", 1), ("2", 2)] {
        bench.run_lasers(case, channels);
    }
    for (case, running) in [("1", 1), ("8", 8)] {
        bench.run_follow(case, running, (false, false), ["follow-start", "follow-change", "follow-inside"]);
        bench.run_follow(case, running, (true, false), ["shaped-start", "shaped-change", "shaped-inside"]);
        bench.run_follow(case, running, (false, true), ["follow-ready", "", ""]);
        bench.run_follow(case, running, (true, true), ["shaped-ready", "", ""]);
    }
    probes::exit()
}
