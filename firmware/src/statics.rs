//! Every static of the image. All are zero or constant at the start. The sections are those of a
//! board with more than one RAM (its `memory.x`).
use crate::fault::FaultReport;
use crate::interrupts::{HandedOver, LinkReceiver, Servo};
use crate::wake_signal::WakeSignal;
use core::sync::atomic::AtomicBool;
use dispatcher::{PathQueue, Server};
use embassy_executor::raw;
use hal::board::{self, AXES};
use ring::{Latest, Ring};
use servo::laser::PowerTables;
use servo::path::{EntryStore, PathStores};
use servo::segment::pvt::{HeaderStore, PointStore, TABLES};
use servo::tick::{EVENTS, IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, SegmentStore, TRACE_SAMPLES, Tick, TickConfig};
use servo::tick_command::LaneEntry;
use servo::units::Crd;
use servo::view::{Event, Sample, View};
use static_cell::{ConstStaticCell, StaticCell};

/// Bytes from the link that wait for the task. More than that wait in the UART.
pub const RECEIVED_BYTES: usize = if AXES > 8 { 4096 } else { 1024 };

/// Thread to tick: operations for the next tick.
pub static IMMEDIATE_LANE: Ring<LaneEntry, IMMEDIATE_ENTRIES> = Ring::new();
/// Thread to tick: timed operations of a program.
pub static PROGRAM_LANE: Ring<LaneEntry, PROGRAM_ENTRIES> = Ring::new();
/// Tick to thread: the newest view.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state"))]
pub static VIEW: Latest<View<AXES>> = Latest::new(View::POWER_ON);
/// Tick to thread: events.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".backup"))]
pub static EVENT_QUEUE: Ring<Event, EVENTS> = Ring::new();
/// Tick to thread: trace samples.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".backup"))]
pub static TRACE: Ring<Sample, TRACE_SAMPLES> = Ring::new();
/// Thread to tick: PT segments, a store an axis.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".stores"))]
pub static STORES: [SegmentStore; AXES] = [const { SegmentStore::new() }; AXES];
/// Thread to tick: points of PVT tables, a store a table.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".tables"))]
#[cfg_attr(not(feature = "stm32h743"), unsafe(link_section = ".psram"))]
pub static POINTS: [PointStore; TABLES] = [const { PointStore::new() }; TABLES];
/// Thread to tick: their headers.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".dma.headers"))]
pub static HEADERS: HeaderStore = HeaderStore::new();
/// Thread to tick: entries of coordinate systems, a pair of FIFOs each.
#[cfg(not(feature = "stm32h743"))]
#[unsafe(link_section = ".psram")]
pub static PATHS: [[EntryStore; 2]; Crd::MAX] = [const { [const { EntryStore::new() }; 2] }; Crd::MAX];
/// The same in two memories: none has room for both.
#[cfg(feature = "stm32h743")]
#[unsafe(link_section = ".paths_0")]
static PATHS_0: [EntryStore; 2] = [const { EntryStore::new() }; 2];
#[cfg(feature = "stm32h743")]
#[unsafe(link_section = ".paths_1")]
static PATHS_1: [EntryStore; 2] = [const { EntryStore::new() }; 2];

/// Where the FIFOs of coordinate systems lie.
pub const fn paths() -> PathStores<'static> {
    #[cfg(not(feature = "stm32h743"))]
    return PathStores::of(&PATHS);
    #[cfg(feature = "stm32h743")]
    PathStores::new([Some(&PATHS_0), Some(&PATHS_1)])
}
/// Thread to tick: tables of laser channels.
pub static LASER_TABLES: PowerTables = PowerTables::new();
/// Counts of the edges of inputs.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".dma.edges"))]
pub static EDGE_COUNTS: servo::EdgeCounts = servo::EdgeCounts::new();
/// Thread: the queues of the look-ahead before these stores.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".thread"))]
pub static QUEUES: ConstStaticCell<[[PathQueue; 2]; Crd::MAX]> =
    ConstStaticCell::new([const { [const { PathQueue::new() }; 2] }; Crd::MAX]);
/// Link interrupt to task: bytes received.
pub static BYTES: Ring<u8, RECEIVED_BYTES> = Ring::new();

/// The servo tick.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state"))]
pub static TICK: ConstStaticCell<Tick<AXES>> = ConstStaticCell::new(Tick::new(TickConfig {
    period_ns: board::TICK_NS,
    axes: AXES as u8,
    analog_inputs: board::ANALOG_INPUTS,
    laser_clock: board::LASER_CLOCK,
    step_limit: board::STEP_LIMIT,
}));
/// What the tick's interrupt owns.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".state"))]
pub static SERVO: HandedOver<Servo> = HandedOver::nothing();
/// What the link's receive interrupt owns.
pub static RECEIVER: HandedOver<LinkReceiver> = HandedOver::nothing();
/// Wakes the link task.
pub static LINK_WAKE: WakeSignal = WakeSignal::new();
/// A byte has arrived since the idle loop checked.
pub static RECEIVING: AtomicBool = AtomicBool::new(false);
/// A task is to be polled.
pub static PENDED: AtomicBool = AtomicBool::new(false);
/// The report of what ended the last run.
pub static REPORT: StaticCell<FaultReport> = StaticCell::new();
/// The thread's executor.
pub static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
/// The link task's server; too large to be handed over on the stack.
#[cfg_attr(feature = "stm32h743", unsafe(link_section = ".thread"))]
pub static SERVER: StaticCell<Server<'static, AXES>> = StaticCell::new();
