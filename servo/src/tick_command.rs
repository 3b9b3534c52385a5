//! Admitted tick commands: what the thread hands to the tick.
//!
//! An [`TickCommand`] has passed every check, so the tick can only carry it out or, where the
//! machine's state changed meanwhile (a limit, an alarm), refuse it with a
//! [`follow::StartEvent`]. Two lanes lead in: the immediate lane acts on the next tick; the
//! program lane is timed (SPEC 7): an entry's instant is that of the entry before plus `delay`, and
//! it acts on the first tick after that instant.
use crate::path;
use crate::path::axis_map::AxisMap;
use crate::port::Simulated;
use crate::segment::follow;
use crate::segment::ramp::{Accel, Speed};
pub use crate::units::DoGroup;
use crate::units::{Axis, AxisMask, Crd, CrdMask, Ns, Pos};

/// A tick command with its instant on the script clock, and the number under which its execution is
/// reported.
#[derive(Debug, Clone, Copy)]
pub struct LaneEntry {
    /// Counts up by one per entry and lane; the view reports the last one executed.
    pub seq: u32,
    /// Program lane only: time since the instant of the entry before.
    pub delay: Ns,
    /// What to do.
    pub command: TickCommand,
}

/// The lane an entry came by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Acts on the next tick.
    Immediate,
    /// Timed by the script clock.
    Program,
}

/// Per-axis inputs that can be switched off and inverted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guarded {
    /// Positive limit switch.
    LimitPositive,
    /// Negative limit switch.
    LimitNegative,
    /// Drive alarm.
    Alarm,
    /// Home switch (sense only).
    Home,
}

impl Guarded {
    /// Its bit in [`Guards`].
    pub(crate) const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// New values for some guarded inputs; the others stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Guards {
    of: u8,
    to: u8,
}

impl Guards {
    /// All of them stay.
    pub const NONE: Guards = Guards { of: 0, to: 0 };

    /// Sets one.
    pub const fn set(input: Guarded, to: bool) -> Guards {
        Guards::NONE.and(input, to)
    }

    /// Sets one more.
    pub const fn and(self, input: Guarded, to: bool) -> Guards {
        let bit = input.bit();
        Guards { of: self.of | bit, to: if to { self.to | bit } else { self.to & !bit } }
    }

    /// Bits as they are afterwards.
    pub(crate) const fn applied(self, before: u8) -> u8 {
        before & !self.of | self.to
    }
}

/// What an axis runs when it is started (GetPrfMode; SPEC 3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(i8)]
pub enum MotionMode {
    /// Point to point (power-on).
    #[default]
    Trap = 0,
    /// Constant velocity.
    Jog = 1,
    /// Position and time, segments kept and repeatable.
    PtStatic = 2,
    /// Position and time, segments streamed.
    PtDynamic = 3,
    /// Position, velocity and time, from a table.
    Pvt = 4,
    /// A master's displacement instead of time.
    Follow = 5,
    /// The same with shaped ratios and entries that are no segments.
    FollowEx = 6,
    /// A master's displacement in a ratio, without end.
    Gear = 8,
    /// Driven by the coordinate system that it is mapped to. Only [`TickCommand::CrdFrame`] sets
    /// this mode, and any other mode, at standstill, ends it.
    Crd = 7,
}

impl TickCommand {
    /// A Stop of coordinate systems alone.
    pub const fn stop_crds(crds: CrdMask, abrupt: CrdMask) -> TickCommand {
        TickCommand::Stop { axes: AxisMask(0), abrupt: AxisMask(0), crds, crds_abrupt: abrupt }
    }
}

/// Which motion brakes when something happens that no command asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Brake {
    /// None: it goes on in the dark.
    None,
    /// Jog axes and coordinate systems brake; PT, PVT and Follow run out.
    JogAndPaths,
    /// Everything brakes.
    All,
    /// Everything stops abruptly.
    AbruptAll,
}

/// What brakes for which cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Supervision {
    /// The host link is lost.
    pub link: Brake,
    /// The interlock opens.
    pub interlock: Brake,
}

impl Supervision {
    /// At power-on, after a Reset and for a new session.
    pub const DEFAULT: Supervision = Supervision { link: Brake::JogAndPaths, interlock: Brake::JogAndPaths };
}

/// Every tick command. Its size counts: entries are copied through the ring.
#[allow(missing_docs, reason = "each variant's text names its fields")]
#[derive(Debug, Clone, Copy)]
pub enum TickCommand {
    /// Nothing; only its execution is reported.
    Mark,
    /// Immediate lane: the held program begins; the script clock is zero at the tick in force now.
    ProgramRun,
    /// Immediate lane: the program's remaining entries are dropped and the lane is held again.
    ProgramDrop,
    /// Program lane: the program is over; the lane is held until the next `ProgramRun`.
    ProgramEnd,
    /// Program lane: the script clock waits until none of these runs.
    WaitStandstill { axes: AxisMask, crds: CrdMask },
    /// All axes of the mask, and the supervision, to power-on state: stopped, servo off, Trap mode,
    /// latches cleared. A coordinate system that is mapped to one of them has no frame then.
    Reset { axes: AxisMask },
    /// Clears latched status bits whose cause is gone.
    ClearStatus { axes: AxisMask },
    /// Servo on or off; off while moving stops abruptly.
    Servo { axis: Axis, on: bool },
    /// Stops: axes in `abrupt` at once, the others with their stop deceleration; coordinate systems
    /// along their paths, those in `crds_abrupt` at once. An axis that a coordinate system drives
    /// stops that, abruptly if one of its axes is in `abrupt`.
    Stop { axes: AxisMask, abrupt: AxisMask, crds: CrdMask, crds_abrupt: CrdMask },
    /// Dark at once, and all motion stops smoothly (SPEC 9, "Abort").
    Abort,
    /// A new session: dark at once, and entries of the running paths light nothing. Motion goes on.
    NewSession,
    /// What brakes where the link is lost, and where the interlock opens.
    Supervision(Supervision),
    /// Sets planned positions at standstill (ZeroPos also zeroes the encoders of `axes`).
    Zero { axes: AxisMask },
    /// Sets the planned position at standstill.
    SetPosition { axis: Axis, pos: Pos },
    /// Sets the encoder's reading.
    SetEncoder { axis: Axis, pulses: i64 },
    /// Mode at standstill, any but `MotionMode::Crd`. A change of mode or of the use of the FIFO
    /// clears the PT data.
    SetMode { axis: Axis, mode: MotionMode },
    /// Stop decelerations.
    StopDec { axis: Axis, smooth: Accel, abrupt: Accel },
    /// In-position band and time.
    Band { axis: Axis, band: u32, time: Ns },
    /// Soft limits; `None` is off.
    SoftLimit { axis: Axis, positive: Option<i32>, negative: Option<i32> },
    /// Switches guarded inputs on or off, and says which are active low.
    Guard { axis: Axis, on: Guards, low: Guards },
    /// Following-error limit in pulses; `None` is off.
    PositionError { axis: Axis, limit: Option<u32> },
    /// Arms home or index capture.
    Capture { axis: Axis, mode: u8 },
    /// Sets the masked bits of a group.
    Output { group: DoGroup, mask: u64, value: u64 },
    /// Sets an output, and sets it back `time` after the tick from which it is in force.
    OutputFor { group: DoGroup, bit: u8, high: bool, time: Ns },
    /// The count of edges of an input goes on from `count`. `index` is an axis over all cores or a
    /// general input, from 0.
    EdgeCount { input: follow::Input, index: u8, count: u32 },
    /// Sets an input of a machine that has no wires.
    Simulate(Simulated),
    /// The same later, as row `row` of a plan; `after` counts from the tick that executes this, or
    /// from the zero of the next program's script clock.
    Plan { row: u16, after: Ns, of_script: bool, input: Simulated },
    /// Analog output.
    Analog { channel: u8, value: i16 },
    /// Jog parameters, effective with the next Update.
    JogPrm { axis: Axis, acc: Accel, dec: Accel, smooth: u16 },
    /// Trap parameters, effective with the next Update.
    TrapPrm { axis: Axis, acc: Accel, dec: Accel, vel_start: Speed, smooth: Ns },
    /// Target velocity of Jog and Trap.
    TargetSpeed { axis: Axis, speed: Speed },
    /// Target position of Trap.
    TargetPosition { axis: Axis, pulses: i32 },
    /// Jog and Trap of these axes begin, or change, with the present targets.
    Update { axes: AxisMask },
    /// The FIFO's data now ends at this count of segments pushed since it was cleared. In dynamic
    /// mode it counts only if `epoch` is that of the axis: data for a stream that has ended is
    /// refused.
    PtCommit { axis: Axis, fifo: u8, end: u32, epoch: u32 },
    /// Empties a FIFO that is not running (both in dynamic mode, at standstill); its count begins
    /// at 0 again.
    PtClear { axis: Axis, fifo: u8 },
    /// Passes; 0 is for ever.
    PtLoop { axis: Axis, passes: u32 },
    /// PT of these axes begins; bits of `fifo1` take FIFO 1.
    PtStart { axes: AxisMask, fifo1: AxisMask },
    /// The PVT table (from 0 over all cores) that the axis runs: from rest with the next start;
    /// while it runs when the present pass ends. Its points and header are in their stores.
    PvtSelect { axis: Axis, table: u8 },
    /// PVT passes; 0 is for ever.
    PvtLoop { axis: Axis, passes: u32 },
    /// PVT of these axes begins with their selected tables.
    PvtStart { axes: AxisMask },
    /// Which direction of the master's motion counts, of an axis at standstill. A change clears its
    /// FIFOs.
    FollowDirection { axis: Axis, direction: follow::Direction },
    /// The master that the axis follows from the next start on; no cycle, also through others.
    FollowMaster { axis: Axis, master: follow::Master },
    /// What begins the motion after the next start.
    FollowEvent { axis: Axis, event: follow::StartEvent },
    /// Follow passes; 0 is for ever.
    FollowLoop { axis: Axis, passes: u32 },
    /// The FIFO now ends at this count of entries; `tail` is that of the chain after the last one.
    /// It counts only if `cleared` is what the view has for this FIFO: data for a FIFO that a
    /// switch has emptied meanwhile is void.
    FollowCommit { axis: Axis, fifo: u8, end: u32, cleared: u32, tail: follow::FifoTail },
    /// Empties a FIFO that is not running.
    FollowClear { axis: Axis, fifo: u8 },
    /// The ratio of an axis in Gear, from the next start on.
    GearRatio { axis: Axis, ratio: follow::GearRatio },
    /// Follow, FollowEx or Gear of these axes begins; bits of `fifo1` take FIFO 1. One that is in
    /// gear already goes over to the ratio that is set.
    FollowStart { axes: AxisMask, fifo1: AxisMask },
    /// The other FIFO takes over when the present pass ends.
    FollowSwitch { axes: AxisMask },
    /// The next segment, or the other FIFO, takes over at once.
    FollowSwitchNow { axis: Axis, method: follow::Method },
    /// Period of the tick (10 µs to 1 ms) from the next tick on, at standstill.
    TickPeriod { ns: u32 },
    /// Begins (`every` ≥ 1) or ends (0) a trace. While the program lane is held it is only armed
    /// and begins with `ProgramRun`; else it begins at once. Row 0 is the tick in force then.
    /// `edges`: with the plans of the laser channels between the rows; `outputs`: with the general
    /// outputs when they change.
    Trace { every: u32, axes: AxisMask, crds: CrdMask, lasers: u8, edges: bool, outputs: bool },
    /// SetCrdPrm, at standstill: which axes it drives and where its zero is; these are in
    /// `MotionMode::Crd` from now on. Both FIFOs are empty; stop deceleration and override have
    /// their power-on values (1 pulse/ms², 1).
    CrdFrame { crd: Crd, frame: AxisMap },
    /// The FIFO now ends at this count of entries pushed since it was cleared. It counts only if
    /// `cleared` is what the view has for this FIFO.
    CrdCommit { crd: Crd, fifo: u8, end: u32, cleared: u32 },
    /// Empties a FIFO, at standstill.
    CrdClear { crd: Crd, fifo: u8 },
    /// These begin or go on; bits of `fifo1` take FIFO 1.
    CrdStart { crds: CrdMask, fifo1: CrdMask },
    /// Stop deceleration.
    CrdStopDec { crd: Crd, dec: Accel },
    /// Override.
    CrdOverride { crd: Crd, rate: path::FeedOverride },
    /// The filter of its encoders' speed.
    CrdLag { crd: Crd, lag: crate::laser::FilterRate },
    /// A laser channel (from 0) changes.
    Laser { channel: u8, change: crate::laser::ChannelChange },
    /// Ends the velocity follows that entries of these coordinate systems began (Stop, bits 10 and
    /// 11).
    FollowEnd { crds: CrdMask },
    /// The host link is lost, or is there again. Its loss shuts off a channel whose light is on or
    /// may come, and every channel while a program runs; motion brakes as `Supervision` says.
    Link { lost: bool },
}
