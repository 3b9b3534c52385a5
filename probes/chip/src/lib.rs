#![no_std]
#![deny(unsafe_code)]
//! What the probes share: a tick of 8 axes with its hand-overs, all static, and what counts
//! instructions.
//!
//! In: nothing. Out: both halves of everything, once. Owns the statics. Fails with `None` when
//! asked twice.
#[allow(unsafe_code, reason = "registers of a timer")]
pub mod clock;
pub mod counted;
pub mod machine;

use cortex_m_semihosting::debug;
use dispatcher::PathQueue;
use ring::{Consumer, Latest, Producer, Reader, Ring};
use servo::laser::{Clock, PowerTables};
use servo::path::{EntryStore, PathStores};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tables::TableStores;
use servo::tick::{
    EVENTS, IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, SegmentStore, TRACE_SAMPLES, Tick, TickConfig, TickHalves,
};
use servo::tick_command::LaneEntry;
use servo::units::StepLimit;
use servo::view::{Event, Sample, View};
use static_cell::ConstStaticCell;

/// Axes of the probes: what SPEC 11 counts with.
pub const AXES: usize = 8;

/// Tick period of the probes: 250 µs.
pub const PERIOD_NS: u32 = 250_000;

static IMMEDIATE_LANE: Ring<LaneEntry, IMMEDIATE_ENTRIES> = Ring::new();
static PROGRAM_LANE: Ring<LaneEntry, PROGRAM_ENTRIES> = Ring::new();
static VIEW: Latest<View<AXES>> = Latest::new(View::POWER_ON);
static NEWS: Ring<Event, EVENTS> = Ring::new();
static TRACE: Ring<Sample, TRACE_SAMPLES> = Ring::new();
/// PT segments of the axes.
pub static STORES: [SegmentStore; AXES] = [const { SegmentStore::new() }; AXES];
/// Places of PVT tables.
pub static PLACES: [PointStore; TABLES] = [const { PointStore::new() }; TABLES];
/// Headers of PVT tables.
pub static HEADERS: HeaderStore = HeaderStore::new();
/// Entries of coordinate systems.
static ENTRIES: [[EntryStore; 2]; 2] = [const { [const { EntryStore::new() }; 2] }; 2];
/// The same, as everybody is given them.
pub const PATHS: PathStores<'static> = PathStores::of(&ENTRIES);
/// What leads to them.
pub static QUEUES: ConstStaticCell<[[PathQueue; 2]; 2]> =
    ConstStaticCell::new([const { [const { PathQueue::new() }; 2] }; 2]);
/// Tables of laser channels.
pub static LASER_TABLES: PowerTables = PowerTables::new();
/// Counts of the edges of inputs.
pub static EDGE_COUNTS: servo::EdgeCounts = servo::EdgeCounts::new();
/// All of them.
pub const TABLE_STORES: TableStores<'static> =
    TableStores { points: &PLACES, headers: &HEADERS, lasers: &LASER_TABLES, edges: &EDGE_COUNTS };

/// The thread's halves.
pub struct Thread {
    /// Tick commands for the next tick.
    pub immediate: Producer<'static, LaneEntry, IMMEDIATE_ENTRIES>,
    /// Timed tick commands.
    pub program: Producer<'static, LaneEntry, PROGRAM_ENTRIES>,
    /// The newest view.
    pub view: Reader<'static, View<AXES>>,
    /// News.
    pub events: Consumer<'static, Event, EVENTS>,
    /// Trace samples.
    pub samples: Consumer<'static, Sample, TRACE_SAMPLES>,
}

/// A tick at power-on with its halves, and the thread's.
pub fn bench() -> Option<(Tick<AXES>, TickHalves<'static, AXES>, Thread)> {
    let (immediate_in, immediate) = IMMEDIATE_LANE.split_once()?;
    let (program_in, program) = PROGRAM_LANE.split_once()?;
    let (view_in, view) = VIEW.split_once()?;
    let (events_in, events) = NEWS.split_once()?;
    let (samples_in, samples) = TRACE.split_once()?;
    let tick = Tick::new(TickConfig {
        period_ns: PERIOD_NS,
        axes: AXES as u8,
        analog_inputs: 8,
        laser_clock: Clock::GHZ,
        step_limit: StepLimit::FULL_SCALE,
    });
    let lanes = TickHalves {
        immediate,
        program,
        view: view_in,
        events: events_in,
        samples: samples_in,
        segments: &STORES,
        tables: TABLE_STORES,
        paths: PATHS,
    };
    Some((tick, lanes, Thread { immediate: immediate_in, program: program_in, view, events, samples }))
}

/// Ends the run: the probe is through.
pub fn exit() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    idle()
}

/// Ends the run: the probe failed.
pub fn fail() -> ! {
    debug::exit(debug::EXIT_FAILURE);
    idle()
}

fn idle() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

/// The panic handler of a probe that runs: it says why and ends the run. Those that must link, or
/// must not, have their own.
#[macro_export]
macro_rules! exit_on_panic {
    () => {
        #[panic_handler]
        fn panicked(info: &core::panic::PanicInfo<'_>) -> ! {
            cortex_m_semihosting::hprintln!("{}", info);
            $crate::fail()
        }
    };
}
