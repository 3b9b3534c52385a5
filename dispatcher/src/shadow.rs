//! The shadow state: what the thread knows of axes, coordinate systems and lasers without asking
//! the tick.
//!
//! In: [`ShadowChange`]s, one with every tick command that is pushed into a lane. Out: the values
//! that admissions and reads need. There are two copies. *Admitted* is the state after everything
//! that was admitted, *executed* the state after everything that the tick has executed, but for
//! what a reply that waits keeps back ([`crate::tick_queue::Until`]). If the rest of a program is
//! discarded, *admitted* is set back to *executed*. So what was never executed leaves no trace.
mod axis;
mod channel;
mod crd;
mod crd_space;
mod entry_numbers;
mod follow;
mod path_data;
mod watch;

use crate::product::{LONG_TICK, ProductProfile};
pub use axis::{AxisShadow, BEGINS_SHIFT, FifoShadow};
pub use channel::{DistanceShadow, LaserChange, LaserShadow};
pub use crd::{CrdChange, CrdParameters, CrdShadow, LookAheadSettings, PathShadow};
pub use crd_space::CAPACITY;
pub use entry_numbers::{
    PROGRAM_FLAG, RefreshedNumbers, entries_from, executed, is_in_flight, is_up_to, renew, seq_after, seq_from,
};
pub use follow::FollowFifoShadow;
pub use path_data::PathData;
use protocol::command::{JogPrm, TrapPrm};
use protocol::reason::Reason;
use servo::Fifos;
use servo::laser::CHANNELS;
use servo::segment::pvt::TABLES;
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, Crd, CrdMask, Ns, Pos};
use servo::view::View;
pub use watch::Watch;

/// Software limits at these values are off.
pub const SOFT_OFF: (i32, i32) = (i32::MAX, i32::MIN);

/// What a pushed tick command changes in the shadow state.
#[derive(Debug, Clone, Copy)]
pub enum ShadowChange {
    /// Nothing.
    None,
    /// Power-on state.
    Reset { axes: AxisMask, tables: u64 },
    /// Servo on or off.
    Servo { axis: Axis, on: bool },
    /// The axes, what drives them, and these coordinate systems get a Stop.
    Stopped { axes: AxisMask, crds: CrdMask },
    /// Abort: everything gets a Stop, and on commands are refused until it is at standstill.
    Aborted,
    /// Link loss and interlock.
    Watch(Watch),
    /// The planned positions are set.
    Placed { axes: AxisMask, pos: Pos },
    /// Latched bits are cleared.
    Cleared { axes: AxisMask },
    /// The axes start, at this script clock (ns).
    Started { axes: AxisMask, fifo1: AxisMask, script_ns: u64 },
    /// PVT starts with the tables that are selected.
    PvtStarted { axes: AxisMask },
    /// A PVT table is selected; `pending` if the axis may be running and continue with it.
    Table { axis: Axis, table: u8, pending: bool },
    /// PVT passes.
    TablePasses { axis: Axis, passes: i32 },
    /// A PVT table is complete.
    TableFilled { table: u8 },
    /// They are at standstill for what follows.
    Standstill { axes: AxisMask, crds: CrdMask },
    /// A mode, with empty FIFOs.
    Mode { axis: Axis, mode: MotionMode },
    /// A memory size.
    Memory { axis: Axis, memory: u8 },
    /// A FIFO is emptied (both in dynamic mode).
    Emptied { axis: Axis, fifo: u8 },
    /// A FIFO's data now ends here, if its stream is still that of `epoch`.
    Data { axis: Axis, fifo: u8, epoch: u32, data: FifoShadow },
    /// A master of Follow, and how it was given.
    FollowMaster { axis: Axis, master: Axis, given: [i16; 3] },
    /// A start condition of Follow as it was given.
    FollowEvent { axis: Axis, given: (i16, i16, i32) },
    /// A ratio of Gear as it was given.
    GearRatio { axis: Axis, given: [i32; 3] },
    /// A direction of Follow.
    FollowDirection { axis: Axis, sign: i8 },
    /// A memory size of Follow.
    FollowMemory { axis: Axis, memory: u8 },
    /// A FIFO of Follow is emptied.
    FollowEmptied { axis: Axis, fifo: u8 },
    /// A FIFO of Follow now ends here, if no switch has emptied it meanwhile.
    FollowData { axis: Axis, fifo: u8, cleared: u32, data: FollowFifoShadow },
    /// The axes change to their other FIFO, now or at the end of the pass.
    Switched { axes: AxisMask },
    /// Stop decelerations.
    Dec { axis: Axis, dec: (f64, f64) },
    /// Band.
    Band { axis: Axis, band: (i32, i32) },
    /// Software limits.
    Soft { axis: Axis, soft: (i32, i32) },
    /// Following-error limit.
    PosErr { axis: Axis, pos_err: i32 },
    /// Trap parameters.
    Trap { axis: Axis, prm: TrapPrm },
    /// Jog parameters.
    Jog { axis: Axis, prm: JogPrm },
    /// Target velocity.
    Vel { axis: Axis, vel: f64 },
    /// Target position.
    Pos { axis: Axis, pos: i32 },
    /// A laser channel, from 0.
    Laser { channel: u8, change: LaserChange },
    /// A coordinate system.
    Crd { crd: Crd, change: CrdChange },
    /// Coordinate systems start.
    CrdStarted { crds: CrdMask, fifo1: CrdMask, may_fail: bool },
    /// Resolution of the lasers' frequencies (LSR): high (SetLaserMode 1) or low.
    LaserResolution(bool),
    /// A servo tick.
    Tick { period: Ns },
}

impl ShadowChange {
    /// Whether its execution may end what keeps a command from an axis, a table or a coordinate
    /// system now: a motion, a latched fault, a use.
    pub fn may_free(&self, reason: Reason) -> bool {
        // All data that was given counts already.
        if reason == Reason::CrdEmpty {
            return matches!(self, ShadowChange::Stopped { .. });
        }
        match self {
            ShadowChange::Reset { .. }
            | ShadowChange::Servo { on: false, .. }
            | ShadowChange::Stopped { .. }
            | ShadowChange::Aborted => true,
            // A switch by segment ends a pass in its last segment.
            ShadowChange::Switched { .. } => true,
            // With these the axes that entries of a path move beside it may stay at standstill.
            ShadowChange::Crd { change: CrdChange::Frame { .. } | CrdChange::Emptied { .. }, .. } => true,
            // Data after it already counts from an empty FIFO: only slots that the tick reads get
            // free.
            ShadowChange::Emptied { .. } | ShadowChange::FollowEmptied { .. } => reason == Reason::FifoInUse,
            // It may end the light of a path that would come back.
            ShadowChange::Laser { .. } => reason == Reason::LaserMapInUse,
            ShadowChange::Cleared { .. } | ShadowChange::Table { .. } | ShadowChange::Crd { .. } => {
                !matches!(reason, Reason::Moving | Reason::OnlyAtStandstill | Reason::CrdRuns)
            }
            _ => false,
        }
    }
}

servo::state! {
    /// One copy of the shadow state.
    #[derive(Debug, Clone, Copy)]
    pub struct Shadows<const AXES: usize> {
        /// The axes.
        pub axes: [AxisShadow; AXES] = [AxisShadow::power_on(); AXES],
        /// The coordinate systems.
        pub crds: [CrdShadow; Crd::MAX] = [CrdShadow::power_on(); Crd::MAX],
        /// The laser channels.
        pub lasers: [LaserShadow; CHANNELS] = [LaserShadow::power_on(true, false); CHANNELS],
        /// Resolution of their frequencies.
        pub high_resolution: bool = true,
        /// Whether the tick period is at least [`LONG_TICK`]; none while it is that of power-on.
        long_tick: Option<bool> = None,
        /// The last Abort.
        aborted: Option<u32> = None,
        /// Link loss and interlock.
        pub watch: Watch = Watch::DEFAULT,
        /// PVT tables that hold data, a bit a table.
        filled: u64 = 0,
        /// The last entry that named a PVT table.
        named: [Option<u32>; TABLES] = [None; TABLES],
    }
    /// The state at power-on.
    pub fn new();
}

impl<const AXES: usize> Shadows<AXES> {
    /// The state of one axis; the last one for an axis beyond the capacity, which no admission lets
    /// through.
    pub fn axis(&self, axis: Axis) -> &AxisShadow {
        &self.axes[axis.index().min(AXES - 1)]
    }

    /// Whether a start is in flight that the tick may refuse, as far as the view shows.
    pub fn may_not_start(&self, view: &View<AXES>) -> bool {
        self.axes.iter().zip(&view.axes).any(|(shadow, sampled)| shadow.may_not_start(view, sampled))
            || self.crds.iter().any(|crd| crd.may_start_elsewhere(view))
    }

    /// Whether a PVT table holds data.
    pub fn is_filled(&self, table: u8) -> bool {
        self.filled.checked_shr(table.into()).unwrap_or(0) & 1 == 1
    }

    /// A PVT table is being overwritten. Until the entry of its new data has been executed, its
    /// content belongs to nothing executed.
    pub fn invalidate(&mut self, table: u8) {
        self.filled &= !1u64.checked_shl(table.into()).unwrap_or(0);
    }

    /// The same for a follow table of a laser channel.
    pub fn invalidate_follow_table(&mut self, channel: u8, table: u8) {
        if let Some(laser) = self.lasers.get_mut(usize::from(channel)) {
            laser.invalidate(table);
        }
    }

    /// A FIFO of a coordinate system was given an entry that names a follow table.
    pub fn name_follow_table(&mut self, channel: u8, table: u8, crd: Crd, fifo: u8) {
        let laser = self.lasers.get_mut(usize::from(channel));
        if let Some(named) = laser.and_then(|laser| laser.named.get_mut(usize::from(table))) {
            *named |= 1 << (2 * crd.index() + usize::from(fifo & 1));
        }
    }

    /// FIFOs that may hold an entry that names a follow table: bit 2·crd + FIFO.
    pub fn naming(&self) -> Fifos {
        self.lasers.iter().flat_map(|laser| laser.named).fold(0, |all, named| all | named)
    }

    /// What empties FIFOs of a coordinate system has been admitted: no entry of them names a follow
    /// table any more. For the executed state that is so once they are empty.
    pub fn forget_emptied(&mut self, change: &ShadowChange) {
        match *change {
            ShadowChange::Crd { crd, change: CrdChange::Frame { .. } } => {
                (0..2).for_each(|fifo| self.forget_follow_tables(crd, fifo));
            }
            ShadowChange::Crd { crd, change: CrdChange::Emptied { fifo, .. } } => self.forget_follow_tables(crd, fifo),
            _ => {}
        }
    }

    /// A FIFO that holds nothing names no follow table.
    pub fn forget_follow_tables(&mut self, crd: Crd, fifo: u8) {
        let bit = 1 << (2 * crd.index() + usize::from(fifo & 1));
        self.lasers.iter_mut().flat_map(|laser| &mut laser.named).for_each(|named| *named &= !bit);
    }

    /// Whether data written to a FIFO now overwrites slots that the tick has not emptied yet.
    pub fn overwrites(&self, view: &View<AXES>, axis: Axis, fifo: u8) -> bool {
        let shadow = self.axis(axis);
        is_in_flight(view, shadow.emptied) || shadow.is_follow() && shadow.follow.is_invalid(view, fifo)
    }

    /// FIFOs (a bit each) are being overwritten. If what emptied them is never executed, they have
    /// to be emptied then.
    pub fn invalidate_fifos(&mut self, axis: Axis, fifos: u8) {
        if let Some(shadow) = self.axes.get_mut(axis.index()) {
            shadow.invalid |= fifos & (u8::from(shadow.holds(0)) | u8::from(shadow.holds(1)) << 1);
        }
    }

    /// Coordinate systems that a core has at the tick period of this state.
    pub fn crds_per_core(&self, profile: &ProductProfile, view: &View<AXES>) -> u8 {
        match self.long_tick {
            Some(true) => profile.crds_per_core,
            Some(false) => profile.crds_in_short_ticks,
            None => profile.crds_at(view.period),
        }
    }

    /// The state of one coordinate system.
    pub fn crd(&self, crd: Crd) -> &CrdShadow {
        let [first, ..] = &self.crds;
        self.crds.get(crd.index()).unwrap_or(first)
    }

    /// The content of a FIFO of a coordinate system is not what was executed: the FIFO is to be
    /// emptied.
    pub fn invalidate_path(&mut self, crd: Crd, fifo: u8) {
        if let Some(path) = self.crds.get_mut(crd.index()).and_then(|shadow| shadow.fifos.get_mut(usize::from(fifo))) {
            path.invalid = true;
        }
    }

    /// The coordinate systems that drive one of these axes.
    pub fn drivers(&self, axes: AxisMask) -> CrdMask {
        let drives = |crd: &Crd| self.crd(*crd).frame.is_some_and(|frame| frame.mask().0 & axes.0 != 0);
        CrdMask(Crd::all().filter(drives).fold(0, |mask, crd| mask | crd.mask().0))
    }

    fn with_crds(&mut self, crds: CrdMask, change: &CrdChange, seq: u32) {
        for crd in crds.crds() {
            if let Some(shadow) = self.crds.get_mut(crd.index()) {
                shadow.enter(change, seq);
            }
        }
    }

    /// The tick command that empties one of the overwritten FIFOs: of the first coordinate system
    /// or axis that has some.
    pub fn revalidate(&self) -> Option<(TickCommand, ShadowChange)> {
        for crd in Crd::all() {
            if let Some(fifo) = (0..2u8).find(|fifo| self.crd(crd).path(*fifo).invalid) {
                let change = CrdChange::Emptied { fifo, here: None };
                return Some((TickCommand::CrdClear { crd, fifo }, ShadowChange::Crd { crd, change }));
            }
        }
        let (index, shadow) = self.axes.iter().enumerate().find(|(_, shadow)| shadow.invalid != 0)?;
        let (axis, fifo) = (Axis::new(index)?, shadow.invalid.trailing_zeros() as u8);
        Some(if shadow.is_follow() {
            (TickCommand::FollowClear { axis, fifo }, ShadowChange::FollowEmptied { axis, fifo })
        } else {
            (TickCommand::PtClear { axis, fifo }, ShadowChange::Emptied { axis, fifo })
        })
    }

    /// The commit of all admitted data of a FIFO of an axis.
    pub fn commit_of_axis(&self, axis: Axis, fifo: u8) -> (TickCommand, ShadowChange) {
        let (shadow, index) = (self.axis(axis), usize::from(fifo & 1));
        if shadow.is_follow() {
            let (cleared, data) = (shadow.follow.cleared[index], shadow.follow.fifos[index]);
            let command =
                TickCommand::FollowCommit { axis, fifo, end: data.chain.entries(), cleared, tail: data.chain.tail() };
            return (command, ShadowChange::FollowData { axis, fifo, cleared, data });
        }
        let (epoch, data) = (shadow.epoch, shadow.fifos[index]);
        (TickCommand::PtCommit { axis, fifo, end: data.end, epoch }, ShadowChange::Data { axis, fifo, epoch, data })
    }

    /// The commit of a FIFO of a coordinate system up to an entry.
    pub fn commit_of_path(&self, crd: Crd, fifo: u8, end: u32) -> (TickCommand, ShadowChange) {
        let PathShadow { cleared, data, .. } = *self.crd(crd).path(fifo);
        let change = CrdChange::Data { fifo, cleared, data };
        (TickCommand::CrdCommit { crd, fifo, end, cleared }, ShadowChange::Crd { crd, change })
    }

    /// Whether an entry that was not executed names a PVT table.
    pub fn is_named(&self, view: &View<AXES>, table: u8) -> bool {
        is_in_flight(view, self.named.get(usize::from(table)).copied().flatten())
    }

    fn name(&mut self, table: Option<u8>, seq: u32) {
        if let Some(named) = table.and_then(|table| self.named.get_mut(usize::from(table))) {
            *named = Some(seq);
        }
    }

    /// Whether an abort is in progress or in flight.
    pub fn aborts(&self, view: &View<AXES>) -> bool {
        view.aborts || is_in_flight(view, self.aborted)
    }

    /// Follows the tick: axes and paths that came to standstill, streams that ended.
    pub fn update_from(&mut self, view: &View<AXES>) {
        self.axes.iter_mut().zip(&view.axes).for_each(|(shadow, sampled)| shadow.update_from(view, sampled));
        self.crds.iter_mut().zip(&view.crds).for_each(|(shadow, sampled)| shadow.update_from(view, sampled));
    }

    /// Renews the numbers of executed entries, before they are old enough to look like entries to
    /// come.
    pub fn renew(&mut self, view: &View<AXES>) {
        let mut young = |seq: &mut u32| renew(view, seq);
        self.axes.iter_mut().for_each(|shadow| shadow.renew(&mut young));
        self.crds.iter_mut().for_each(|shadow| shadow.renew_numbers(&mut young));
        self.lasers.iter_mut().for_each(|shadow| shadow.renew(&mut young));
        self.named.iter_mut().chain([&mut self.aborted]).flatten().for_each(young);
    }

    /// The axes of a coordinate system.
    pub fn driven(&self, crd: Crd) -> AxisMask {
        self.crd(crd).frame.map_or(AxisMask(0), |frame| frame.mask())
    }

    fn with(&mut self, axes: AxisMask, change: impl Fn(Axis, &mut AxisShadow)) {
        for axis in axes.axes() {
            if let Some(shadow) = self.axes.get_mut(axis.index()) {
                change(axis, shadow);
            }
        }
    }

    /// Enters the change that goes with entry `seq`.
    pub fn enter(&mut self, change: &ShadowChange, seq: u32) {
        let mut one = |axis: Axis, change: &dyn Fn(&mut AxisShadow)| {
            if let Some(shadow) = self.axes.get_mut(axis.index()) {
                change(shadow);
            }
        };
        match *change {
            ShadowChange::None => {}
            ShadowChange::Reset { axes, tables } => {
                self.watch = Watch::DEFAULT;
                self.filled &= !tables;
                for crd in self.drivers(axes).crds() {
                    let driven = self.driven(crd);
                    self.with(driven, |_, shadow| shadow.mode = MotionMode::Trap);
                    if let Some(shadow) = self.crds.get_mut(crd.index()) {
                        shadow.renew(None, None, seq);
                    }
                }
                self.with(axes, |_, shadow| {
                    // The start is kept: the axis runs until the Reset has been executed.
                    let AxisShadow { epoch, started, busy, mut follow, .. } = *shadow;
                    follow.reset(seq);
                    *shadow = AxisShadow {
                        epoch,
                        started,
                        busy,
                        follow,
                        cleared: Some(seq),
                        servo: Some((seq, false)),
                        position_set: Some((seq, Pos(0))),
                        ..AxisShadow::power_on()
                    };
                    shadow.empty(seq, 3);
                });
            }
            ShadowChange::Servo { axis, on } => {
                one(axis, &|shadow| shadow.servo = Some((seq, on)));
                if !on {
                    one(axis, &|shadow| shadow.stop(seq));
                    let crds = self.drivers(axis.mask());
                    self.with_crds(crds, &CrdChange::Stopped, seq);
                }
            }
            ShadowChange::Stopped { axes, crds } => {
                self.with(axes, |_, shadow| shadow.stop(seq));
                let crds = CrdMask(self.drivers(axes).0 | crds.0);
                self.with_crds(crds, &CrdChange::Stopped, seq);
            }
            ShadowChange::Aborted => {
                self.aborted = Some(seq);
                self.with(AxisMask(u64::MAX), |_, shadow| shadow.stop(seq));
                self.with_crds(CrdMask(u8::MAX), &CrdChange::Stopped, seq);
            }
            ShadowChange::Watch(watch) => self.watch = watch,
            ShadowChange::Tick { period } => self.long_tick = Some(period >= LONG_TICK),
            ShadowChange::Placed { axes, pos } => {
                self.with(axes, |_, shadow| shadow.position_set = Some((seq, pos)));
                let crds = self.drivers(axes);
                self.with_crds(crds, &CrdChange::Placed, seq);
            }
            ShadowChange::Cleared { axes } => self.with(axes, |_, shadow| shadow.cleared = Some(seq)),
            ShadowChange::Started { axes, fifo1, script_ns } => self.with(axes, |axis, shadow| {
                shadow.start(seq);
                let begins = u32::try_from(script_ns >> BEGINS_SHIFT).unwrap_or(u32::MAX).saturating_add(1);
                shadow.stream_begins = if shadow.is_dynamic() { begins } else { 0 };
                shadow.fifo = u8::from(fifo1.has(axis));
            }),
            ShadowChange::PvtStarted { axes } => {
                axes.axes().for_each(|axis| self.name(self.axis(axis).table, seq));
                self.with(axes, |_, shadow| shadow.start(seq));
            }
            ShadowChange::Table { axis, table, pending } => {
                one(axis, &|shadow| shadow.table = Some(table));
                self.name(Some(table).filter(|_| pending), seq);
            }
            ShadowChange::TablePasses { axis, passes } => one(axis, &|shadow| shadow.table_passes = passes),
            ShadowChange::TableFilled { table } => self.filled |= 1u64.checked_shl(table.into()).unwrap_or(0),
            ShadowChange::Standstill { axes, crds } => {
                let crds = CrdMask(crds.0 | self.drivers(axes).0);
                let driven = crds.crds().fold(0, |mask, crd| mask | self.driven(crd).0);
                // What still runs may set an axis off after the wait for it.
                let others = Crd::all().filter(|crd| !crds.has(*crd) && self.crd(*crd).started.is_some());
                let aside = AxisMask(others.fold(0, |mask, crd| mask | self.crd(crd).extra_axes.0));
                self.with(axes, |axis, shadow| {
                    shadow.started = None;
                    shadow.moved_by_entry &= aside.has(axis);
                });
                // A wait for a coordinate system does not wait for an axis that has left it.
                let rests = |shadow: &AxisShadow| shadow.mode == MotionMode::Crd && crds.has(shadow.crd);
                self.with(AxisMask(driven), |_, shadow| {
                    if rests(shadow) {
                        shadow.started = None;
                    }
                });
                self.with_crds(crds, &CrdChange::Standstill, seq);
            }
            ShadowChange::Mode { axis, mode } => one(axis, &|shadow| {
                shadow.mode = mode;
                shadow.follow.forget(seq);
                shadow.empty_all(seq);
            }),
            ShadowChange::Memory { axis, memory } => one(axis, &|shadow| {
                shadow.memory = memory;
                shadow.empty_all(seq);
            }),
            ShadowChange::Emptied { axis, fifo } => one(axis, &|shadow| {
                if let Some(fifo) = shadow.fifos.get_mut(usize::from(fifo)) {
                    *fifo = FifoShadow::default();
                }
                shadow.empty(seq, if shadow.is_dynamic() { 3 } else { 1 << (fifo & 1) });
            }),
            ShadowChange::Data { axis, fifo, epoch, data } => one(axis, &|shadow| {
                if shadow.is_dynamic() && shadow.epoch != epoch {
                    return;
                }
                if let Some(fifo) = shadow.fifos.get_mut(usize::from(fifo)) {
                    *fifo = data;
                }
            }),
            ShadowChange::FollowMaster { axis, master, given } => {
                one(axis, &|shadow| shadow.follow.master = Some((master, given)));
            }
            ShadowChange::FollowEvent { axis, given } => one(axis, &|shadow| shadow.follow.event = given),
            ShadowChange::GearRatio { axis, given } => one(axis, &|shadow| shadow.follow.ratio = Some(given)),
            ShadowChange::FollowDirection { axis, sign } => one(axis, &|shadow| shadow.follow.direction = sign),
            ShadowChange::FollowMemory { axis, memory } => one(axis, &|shadow| {
                shadow.follow.memory = memory;
                shadow.follow.empty_both(seq);
                shadow.dropped_start = shadow.busy;
                shadow.invalid = 0;
            }),
            ShadowChange::FollowEmptied { axis, fifo } => one(axis, &|shadow| {
                shadow.follow.empty(fifo, seq);
                shadow.dropped_start = shadow.busy;
                shadow.invalid &= !(1 << (fifo & 1));
            }),
            ShadowChange::FollowData { axis, fifo, cleared, data } => one(axis, &|shadow| {
                let position = usize::from(fifo & 1);
                if shadow.follow.cleared[position] == cleared {
                    shadow.follow.fifos[position] = data;
                }
            }),
            ShadowChange::Switched { axes } => self.with(axes, |_, shadow| shadow.follow.switched(seq)),
            ShadowChange::Dec { axis, dec } => one(axis, &|shadow| shadow.dec = dec),
            ShadowChange::Band { axis, band } => one(axis, &|shadow| shadow.band = band),
            ShadowChange::Soft { axis, soft } => one(axis, &|shadow| shadow.soft = soft),
            ShadowChange::PosErr { axis, pos_err } => one(axis, &|shadow| shadow.pos_err = pos_err),
            ShadowChange::Trap { axis, prm } => one(axis, &|shadow| shadow.trap = prm),
            ShadowChange::Jog { axis, prm } => one(axis, &|shadow| shadow.jog = prm),
            ShadowChange::Vel { axis, vel } => one(axis, &|shadow| shadow.vel = vel),
            ShadowChange::Pos { axis, pos } => one(axis, &|shadow| shadow.pos = pos),
            ShadowChange::Laser { channel, change } => {
                if let Some(laser) = self.lasers.get_mut(usize::from(channel)) {
                    laser.enter(change, seq);
                }
            }
            ShadowChange::Crd { crd, change } => {
                let is_frame = matches!(change, CrdChange::Frame { .. });
                let before = if is_frame { self.driven(crd) } else { AxisMask(0) };
                self.with_crds(crd.mask(), &change, seq);
                if let CrdChange::Data { .. } = change
                    && self.crd(crd).started.is_some()
                {
                    self.with(self.crd(crd).extra_axes, |_, shadow| shadow.moved_by_entry = true);
                }
                if is_frame {
                    self.with(before, |_, shadow| {
                        if shadow.mode == MotionMode::Crd && shadow.crd == crd {
                            shadow.mode = MotionMode::Trap;
                        }
                    });
                    let axes = self.driven(crd);
                    self.with(axes, |_, shadow| {
                        (shadow.mode, shadow.crd) = (MotionMode::Crd, crd);
                        shadow.follow.forget(seq);
                        shadow.empty_all(seq);
                    });
                }
            }
            ShadowChange::CrdStarted { crds, fifo1, may_fail } => {
                self.with_crds(CrdMask(crds.0 & !fifo1.0), &CrdChange::Started { fifo: 0, may_fail }, seq);
                self.with_crds(fifo1, &CrdChange::Started { fifo: 1, may_fail }, seq);
                let axes = crds.crds().fold(0, |mask, crd| mask | self.driven(crd).0);
                crds.crds()
                    .for_each(|crd| self.with(self.crd(crd).extra_axes, |_, shadow| shadow.moved_by_entry = true));
                self.with(AxisMask(axes), |_, shadow| shadow.start(seq));
            }
            ShadowChange::LaserResolution(high) => self.high_resolution = high,
        }
    }
}
