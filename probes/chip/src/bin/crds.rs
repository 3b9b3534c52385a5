#![no_std]
#![no_main]
//! Counts the instructions of ticks in which coordinate systems run, in QEMU with `-icount shift=6`
//! or more.
//!
//! Out, by semihosting: one line a tick, `CASE MARK COUNT`, as `ticks.rs` prints them. CASE is the
//! number of coordinate systems, on a tick of twelve axes: eight for PVT, two for each. MARK says
//! what the tick did:
//!
//! * `crd-idle`: they are set and at standstill.
//! * `crd-line`, `crd-arc`: each stayed in its motion; the worst prepared the next one.
//! * `crd-turn`: each entered one; `crd-enter`: the tick after that.
//! * `crd-start`; `crd-ready`: a start that was prepared at standstill.
//! * `crd-once`: they are set, get their data and start, all in one tick.
//! * `crd-worst`: the tick of SPEC 11. Eight axes enter segments of their tables, two coordinate
//!   systems enter motions, two lasers follow speed and distance. `crd-worst-inside` is any other
//!   tick of that.
//! * `laser-…`: CASE channels are in light while one coordinate system speeds up. Their power
//!   follows nothing, its speed, positions, tables of both, or speed and positions.
use cortex_m_semihosting::hprintln;
use dispatcher::plan::pvt::{FieldIndices, Scratch, SplineScratch, TableDraft, TableKind};
use hal as _; // the vector table
use probes::clock;
use probes::counted::Counted;
use ring::{Consumer, Latest, Producer, Reader, Ring};
use servo::laser::{
    self, Buffered, Carrier, ChannelChange, Clock, Curve, Distance, POINTS, Power, PowerBounds, PowerTables, Ratio,
    Ratios, SpeedSource,
};
use servo::path::axis_map::AxisMap;
use servo::path::{self, EntryStore, MotionSpeeds, PathStores, Plane, Sweep};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tables::TableStores;
use servo::tick::{
    EVENTS, IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, SegmentStore, TRACE_SAMPLES, Tick, TickConfig, TickHalves,
};
use servo::tick_command::{LaneEntry, MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, Crd, CrdMask, Ns, StepLimit};
use servo::view::{Event, Sample, View};

const AXES: usize = 12;
const PERIOD_NS: u32 = 250_000;
/// Motions of a run, and segments of a pass of a table; each of the steady ones takes 16 ticks.
const MOTIONS: u32 = 60;
const SEGMENTS: u32 = 24;
/// Ticks from the first one of SPEC 11 to the one that `cargo xtask ticks --shares` counts.
const SHOWN_AFTER_TICKS: i32 = 24 * 16;

static IMMEDIATE_LANE: Ring<LaneEntry, IMMEDIATE_ENTRIES> = Ring::new();
static PROGRAM_LANE: Ring<LaneEntry, PROGRAM_ENTRIES> = Ring::new();
static VIEW: Latest<View<AXES>> = Latest::new(View::POWER_ON);
static NEWS: Ring<Event, EVENTS> = Ring::new();
static TRACE: Ring<Sample, TRACE_SAMPLES> = Ring::new();
static STORES: [SegmentStore; AXES] = [const { SegmentStore::new() }; AXES];
static PLACES: [PointStore; TABLES] = [const { PointStore::new() }; TABLES];
static HEADERS: HeaderStore = HeaderStore::new();
static LASERS: PowerTables = PowerTables::new();
static EDGES: servo::EdgeCounts = servo::EdgeCounts::new();
static PATHS: [[EntryStore; 2]; 2] = [const { [const { EntryStore::new() }; 2] }; 2];
const TABLE_STORES: TableStores<'static> =
    TableStores { points: &PLACES, headers: &HEADERS, lasers: &LASERS, edges: &EDGES };

probes::exit_on_panic!();

/// A tick that is counted, and the thread's halves of its hand-overs.
struct Bench {
    tick: Counted<AXES>,
    immediate: Producer<'static, LaneEntry, IMMEDIATE_ENTRIES>,
    view: Reader<'static, View<AXES>>,
    events: Consumer<'static, Event, EVENTS>,
    seq: u32,
    pushed: [u32; 2],
}

/// Called before a tick of SPEC 11: a debugger stops here.
#[inline(never)]
fn worst_tick_comes() {
    core::hint::black_box(());
}

fn axis(index: usize) -> Axis {
    let Some(axis) = Axis::new(index) else { panic!("no axis") };
    axis
}

fn crd(index: usize) -> Crd {
    let Some(crd) = Crd::new(index) else { panic!("no coordinate system") };
    crd
}

fn percent(value: u32) -> Power {
    Power::admit(f64::from(value).to_bits()).unwrap_or_default()
}

fn along(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    let Ok(along) = MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()) else { panic!("refused") };
    along
}

impl Bench {
    fn new() -> Option<Bench> {
        let (immediate, immediate_out) = IMMEDIATE_LANE.split_once()?;
        let (_, program) = PROGRAM_LANE.split_once()?;
        let (view_in, view) = VIEW.split_once()?;
        let (events_in, events) = NEWS.split_once()?;
        let (samples, _) = TRACE.split_once()?;
        let config = TickConfig {
            period_ns: PERIOD_NS,
            axes: AXES as u8,
            analog_inputs: 8,
            laser_clock: Clock::GHZ,
            step_limit: StepLimit::FULL_SCALE,
        };
        Some(Bench {
            tick: Counted::new(
                Tick::new(config),
                TickHalves {
                    immediate: immediate_out,
                    program,
                    view: view_in,
                    events: events_in,
                    samples,
                    segments: &STORES,
                    tables: TABLE_STORES,
                    paths: PathStores::of(&PATHS),
                },
            ),
            immediate,
            view,
            events,
            seq: 0,
            pushed: [0; 2],
        })
    }

    fn push(&mut self, command: TickCommand) {
        self.seq += 1;
        assert!(self.immediate.push(LaneEntry { seq: self.seq, delay: Ns(0), command }).is_ok(), "the lane is full");
    }

    /// A tick that is not counted.
    fn pass(&mut self) {
        self.tick.pass();
        while self.events.pop().is_some() {}
    }

    /// One counted tick; its count.
    fn counted(&mut self) -> u32 {
        let count = self.tick.step();
        while self.events.pop().is_some() {}
        count
    }

    /// Motions that each of the first coordinate systems has completed.
    fn done(&mut self) -> [u32; 2] {
        let view = self.view.read();
        [view.crds[0].released[0], view.crds[1].released[0]]
    }

    fn runs(&mut self) -> bool {
        self.view.read().crds.iter().any(|crd| crd.runs)
    }

    fn put(&mut self, index: usize, entry: path::PathEntry) {
        PATHS[index][0].write(self.pushed[index], entry);
        self.pushed[index] += 1;
    }

    /// `cleared` times more than the view knows of.
    fn commit(&mut self, index: usize, cleared: u32) {
        let cleared = self.view.read().crds[index].cleared[0] + cleared;
        self.push(TickCommand::CrdCommit { crd: crd(index), fifo: 0, end: self.pushed[index], cleared });
    }

    /// Coordinate systems on two axes each, from 8 on, with the next tick.
    fn frames(&mut self, count: usize) -> CrdMask {
        for index in 0..count {
            let mapped = [Some(axis(8 + 2 * index)), Some(axis(9 + 2 * index)), None, None];
            for axis in mapped.into_iter().flatten() {
                self.push(TickCommand::Servo { axis, on: true });
            }
            let Ok(frame) = AxisMap::admit(mapped, Some([0; 4]), 0) else { panic!("refused") };
            self.push(TickCommand::CrdFrame { crd: crd(index), frame });
            self.pushed[index] = 0;
        }
        CrdMask((1 << count) - 1)
    }

    /// The same with a tick.
    fn set(&mut self, count: usize) -> CrdMask {
        let crds = self.frames(count);
        self.pass();
        crds
    }

    fn reset(&mut self) {
        self.push(TickCommand::Reset { axes: AxisMask(0xfff) });
        self.pass();
        self.pass();
    }

    /// Lines, or arcs, that all coordinate systems enter on the same ticks.
    fn run(&mut self, case: &str, count: usize, arcs: bool) {
        let crds = self.set(count);
        for _ in 0..8 {
            hprintln!("{} crd-idle {}", case, self.counted());
        }
        self.fill(count, arcs);
        (0..count).for_each(|index| self.commit(index, 0));
        self.pass();
        self.push(TickCommand::CrdStart { crds, fifo1: CrdMask(0) });
        hprintln!("{} crd-start {}", case, self.counted());
        assert!(self.runs(), "it does not run");
        self.see_them_run(case, arcs);
        self.reset();
    }

    /// The first tick of a start that was prepared, and of one with all that it needs in the same
    /// tick.
    fn run_starts(&mut self, case: &str, count: usize, arcs: bool) {
        for once in [false, true] {
            // What was done to the axes before is over.
            (0..16).for_each(|_| self.pass());
            let crds = if once { self.frames(count) } else { self.set(count) };
            self.fill(count, arcs);
            (0..count).for_each(|index| self.commit(index, once as u32));
            if !once {
                (0..40).for_each(|_| self.pass());
            }
            self.push(TickCommand::CrdStart { crds, fifo1: CrdMask(0) });
            hprintln!("{} {} {}", case, if once { "crd-once" } else { "crd-ready" }, self.counted());
            assert!(self.runs(), "it does not run");
            self.reset();
        }
    }

    /// Motions for all coordinate systems.
    fn fill(&mut self, count: usize, arcs: bool) {
        for index in 0..count {
            for k in 1..=MOTIONS {
                let v = if k == MOTIONS { 0.0 } else { 7.1 };
                let sweep = Sweep::admit((0.1 + f64::from(k) / 200.0).to_bits(), k % 3 == 0, k % 2 == 0);
                let Ok(sweep) = sweep else { panic!("refused") };
                let (x, y) = (k as i32 * 37, (k as i32 * 37) % 23);
                self.put(
                    index,
                    if arcs {
                        path::PathEntry::arc(Plane::Xy, [x, y], sweep, along(7.1, 3.7, v))
                    } else {
                        path::PathEntry::planar([x, y], along(7.1, 3.7, v))
                    },
                );
            }
        }
    }

    fn see_them_run(&mut self, case: &str, arcs: bool) {
        let (mut entered, mut last) = (true, None);
        while self.runs() {
            let before = self.done();
            let count = self.counted();
            // A boundary within a tick is reported by the next one.
            let turned = self.done() != before;
            if let Some(count) = last {
                let mark = match (turned, entered) {
                    (true, _) => "crd-turn",
                    (false, true) => "crd-enter",
                    _ if arcs => "crd-arc",
                    _ => "crd-line",
                };
                hprintln!("{} {} {}", case, mark, count);
                entered = turned;
            }
            last = Some(count);
        }
    }

    /// A table of segments of 16 ticks for an axis.
    fn load_table(&mut self, axis: Axis, scratch: &mut Scratch<'_>) {
        let (table, fields) = (axis.index() as u8, FieldIndices { count: 0, whole: 0, point: 0 });
        let draft =
            TableDraft::begin(TableKind::Pvt, SEGMENTS as i32 + 1, fields, StepLimit::FULL_SCALE, true, scratch);
        let Ok(mut draft) = draft else { panic!("the table is refused") };
        for k in 0..=SEGMENTS {
            let place = if k == SEGMENTS { 0 } else { (k * 37 + axis.index() as u32 * 11) * (k % 5 + 1) };
            let point = [f64::from(k * 4), f64::from(place) + 0.37, f64::from(k % 7) - 3.1];
            assert!(draft.point(&point, scratch).is_ok(), "point {k} is refused");
        }
        let Some(Ok(sealed)) = draft.finish(scratch) else { panic!("the table is refused") };
        for index in 0..sealed.points() {
            TABLE_STORES.write_point(table, index, sealed.point(scratch, index).unwrap_or_default());
        }
        TABLE_STORES.write_header(table, sealed.header().admit().unwrap_or_default());
    }

    /// Light of both channels that follows the speed of a path each, and the distance of four axes.
    fn set_lasers(&mut self) {
        let Ok(carrier) = Carrier::admit(percent(333), Clock::GHZ) else { panic!("the carrier is refused") };
        for channel in 0..2 {
            self.push(TickCommand::Laser { channel, change: ChannelChange::Carrier { carrier, fixed: None } });
            self.push(TickCommand::Laser { channel, change: ChannelChange::CrdMap { map: 1 << channel } });
            let half = [0.001f64; 4].map(f64::to_bits);
            let distance = Distance::admit(
                SpeedSource::Planned,
                [0, 1, 2, 3].map(axis),
                [0; 4],
                [1000f64; 4].map(f64::to_bits),
                half,
                Ratios::Fixed,
                None,
            );
            let Ok(distance) = distance else { panic!("refused") };
            self.push(TickCommand::Laser { channel, change: ChannelChange::Distance(Some(distance)) });
        }
        self.pass();
    }

    /// A distance follow of the first mapped axes; with `lines` by tables of ratios.
    fn distance(&mut self, channels: u8, ratios: Ratios) {
        let near = [0.001f64; 4].map(f64::to_bits);
        let axes = [8, 9, 8, 9].map(axis);
        let scales = [1000f64; 4].map(f64::to_bits);
        let distance = Distance::admit(SpeedSource::Planned, axes, [0; 4], scales, near, ratios, None);
        let Ok(distance) = distance else { panic!("refused") };
        for channel in 0..channels {
            self.push(TickCommand::Laser { channel, change: ChannelChange::Distance(Some(distance)) });
        }
    }

    /// Light whose power follows something, or nothing.
    fn run_follow(&mut self, case: &str, channels: u8, mark: &str, follow: Option<Buffered>, ratios: Option<Ratios>) {
        let crds = self.set(1);
        let Ok(carrier) = Carrier::admit(percent(333), Clock::GHZ) else { panic!("the carrier is refused") };
        for channel in 0..channels {
            self.push(TickCommand::Laser { channel, change: ChannelChange::Carrier { carrier, fixed: None } });
        }
        if let Some(ratios) = ratios {
            self.distance(channels, ratios);
        }
        for channel in 0..channels {
            for change in follow.into_iter().chain([Buffered::Gate { on: true }]) {
                let (code, words) = change.pack();
                self.put(0, path::PathEntry::laser(channel, code, words));
            }
        }
        self.put(0, path::PathEntry::planar([30_000, 20_000], along(200.0, 1.0, 0.0)));
        self.commit(0, 0);
        self.pass();
        self.push(TickCommand::CrdStart { crds, fifo1: CrdMask(0) });
        for _ in 0..8 {
            self.pass();
        }
        for _ in 0..100 {
            hprintln!("{} {} {}", case, mark, self.counted());
        }
        assert!(self.view.read().lasers[0].light, "no light");
        for channel in 0..channels {
            self.push(TickCommand::Laser { channel, change: ChannelChange::Reset { family: laser::Family::Gus } });
        }
        self.reset();
    }

    fn run_follows(&mut self, case: &str, channels: u8) {
        let bounds = PowerBounds::admit(laser::PowerMode::Duty, percent(100), percent(0));
        let (Ok(ratio), Ok(bounds)) = (Ratio::admit(0.37f64.to_bits()), bounds) else { panic!("refused") };
        let Some(table) = Curve::power(0, 0) else { panic!("no table") };
        for k in 0..POINTS {
            let put = LASERS.power_point(table, k, (k as f64 * 8.0).to_bits(), percent(k as u32));
            assert!(put.is_ok(), "point {k} is refused");
            for (channel, axis) in (0..channels).flat_map(|channel| (0..4).map(move |axis| (channel, axis))) {
                let Some(line) = Curve::ratio(channel, 0, axis) else { panic!("no table") };
                let put = LASERS.ratio_point(line, k, k as i32 * 1000, (k as f64 / 1000.0).to_bits());
                assert!(put.is_ok(), "point {k} is refused");
                LASERS.finish(line, k + 1);
            }
        }
        LASERS.finish(table, POINTS);
        let (by_ratio, by_table) = (Buffered::PrfFollow { ratio, bounds }, Buffered::FollowTable { table, bounds });
        self.run_follow(case, channels, "laser-alone", None, None);
        self.run_follow(case, channels, "laser-speed", Some(by_ratio), None);
        self.run_follow(case, channels, "laser-place", None, Some(Ratios::Fixed));
        self.run_follow(case, channels, "laser-tables", Some(by_table), Some(Ratios::Lines { bank: 0 }));
        self.run_follow(case, channels, "laser-both", Some(by_ratio), Some(Ratios::Fixed));
    }

    /// SPEC 11: eight axes in PVT, two coordinate systems, two lasers with both follows; segments
    /// and motions of all of them begin together, every 16 ticks.
    fn run_worst(&mut self, scratch: &mut Scratch<'_>) {
        self.set_lasers();
        let crds = self.set(2);
        let mut axes = AxisMask(0);
        for axis in (0..8).map(axis) {
            self.load_table(axis, scratch);
            axes.0 |= axis.mask().0;
            self.push(TickCommand::Servo { axis, on: true });
            self.push(TickCommand::SetMode { axis, mode: MotionMode::Pvt });
            self.push(TickCommand::PvtLoop { axis, passes: 0 });
            self.push(TickCommand::PvtSelect { axis, table: axis.index() as u8 });
        }
        self.pass();
        let bounds = PowerBounds::admit(laser::PowerMode::Duty, percent(100), percent(0));
        let (Ok(ratio), Ok(bounds)) = (Ratio::admit(3.7f64.to_bits()), bounds) else { panic!("refused") };
        for index in 0..2 {
            for change in [Buffered::PrfFollow { ratio, bounds }, Buffered::Gate { on: true }] {
                let (code, words) = change.pack();
                self.put(index, path::PathEntry::laser(index as u8, code, words));
            }
            for k in 1..=MOTIONS as i32 {
                // 1 ms to reach 10 pulse/ms, 4 ms a motion; speeds a little apart, as look-ahead
                // plans them.
                let (x, y) = (40 * k - 5, 0);
                let end = if k as u32 == MOTIONS { 0.0 } else { 10.0 };
                let to = if index == 0 { [x, y] } else { [y, x] };
                self.put(index, path::PathEntry::planar(to, along(10.0, 10.0, end)));
            }
            self.commit(index, 0);
        }
        self.pass();
        self.push(TickCommand::PvtStart { axes });
        self.push(TickCommand::CrdStart { crds, fifo1: CrdMask(0) });
        self.pass();
        let mut seen = self.done();
        let mut published = None;
        for k in 1..50 * 16 {
            if published == Some(k) {
                worst_tick_comes();
            }
            let before = self.view.read().axes[0].motion.c;
            let count = self.counted();
            let (after, done) = (self.view.read().axes[0].motion.c, self.done());
            // The path is a period ahead: it has entered a motion in the tick before that of the
            // segments, or on it.
            let mark = match (before != after, seen != done) {
                (true, true) => "crd-worst",
                (false, true) => "crd-worst-motions",
                (true, false) => "crd-worst-segments",
                (false, false) => "crd-worst-inside",
            };
            assert!(published != Some(k) || mark == "crd-worst", "another tick was shown");
            if k > 20 && mark == "crd-worst" && published.is_none() {
                published = Some(k + SHOWN_AFTER_TICKS);
            }
            if k > 20 {
                hprintln!("2 {} {}", mark, count);
            }
            seen = done;
        }
        let view = self.view.read();
        assert!(view.crds[0].runs && view.crds[1].runs, "they do not run");
        assert!(view.lasers.iter().all(|laser: &servo::view::LaserView| laser.gate), "no light");
        self.reset();
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let Some(mut bench) = Bench::new() else { panic!("once") };
    for (case, count) in [("1", 1), ("2", 2)] {
        for arcs in [false, true] {
            bench.run(case, count, arcs);
            bench.run_starts(case, count, arcs);
        }
    }
    for (case, channels) in [("1", 1), ("2", 2)] {
        bench.run_follows(case, channels);
    }
    let mut beside = SplineScratch::new();
    // No axis has the last table.
    let mut scratch = Scratch::new(&mut beside, &TABLE_STORES.points[TABLES - 1]);
    bench.run_worst(&mut scratch);
    probes::exit()
}
