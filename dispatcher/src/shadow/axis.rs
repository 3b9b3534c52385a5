//! Shadow state of one axis.
use super::follow::FollowShadow;
use super::{PROGRAM_FLAG, SOFT_OFF, executed, is_in_flight, is_up_to};
use protocol::command::{JogPrm, TrapPrm};
use protocol::values::pt_state;
use servo::segment::pt::Chain;
use servo::status::{RUNNING, SERVO_ON};
use servo::tick_command::MotionMode;
use servo::units::{Crd, Pos};
use servo::view::{AxisView, View};

/// One FIFO of PT data.
#[derive(Debug, Clone, Copy, Default)]
pub struct FifoShadow {
    /// Segments given since it was cleared.
    pub end: u32,
    /// End position, time and velocity of the last one.
    pub chain: Chain,
}

/// Units of [`AxisShadow::stream_begins`]: 65.5 µs, for 78 hours.
pub const BEGINS_SHIFT: u32 = 16;

/// One axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct AxisShadow {
    /// Profile mode.
    pub mode: MotionMode,
    /// PT memory selector, 0 or 1.
    pub memory: u8,
    /// FIFO of the last PtStart.
    pub fifo: u8,
    /// PT data; dynamic mode uses the first only.
    pub fifos: [FifoShadow; 2],
    /// PT stream number of the view that this state follows.
    pub epoch: u32,
    /// The last start, until the axis is known to be at standstill at this point of its lane.
    pub started: Option<u32>,
    /// An entry of a path may have set it off since a wait for it.
    pub moved_by_entry: bool,
    /// Start of a dynamic stream that runs or will run: its script clock in 2^[`BEGINS_SHIFT`] ns,
    /// rounded down, plus 1. `u32::MAX` is later than that, 0 is no such stream.
    pub stream_begins: u32,
    /// The last start, until a view shows the axis at standstill.
    pub busy: Option<u32>,
    /// The last entry that set the planned position, and to what, until it is executed.
    pub position_set: Option<(u32, Pos)>,
    /// In `MotionMode::Crd`: the coordinate system that drives it.
    pub crd: Crd,
    /// The last AxisOn or AxisOff, until it is executed.
    pub servo: Option<(u32, bool)>,
    /// The last ClrSts or Reset, until it is executed.
    pub cleared: Option<u32>,
    /// The last entry that emptied a FIFO, until it is executed.
    pub emptied: Option<u32>,
    /// FIFOs (a bit each) whose data is being overwritten, though what emptied them is not
    /// executed.
    pub invalid: u8,
    /// The start whose data that entry, or one that emptied a FIFO of Follow, may have dropped,
    /// until a view shows the axis at standstill.
    pub dropped_start: Option<u32>,
    /// Stop decelerations, pulse/ms².
    pub dec: (f64, f64),
    /// In-position band (pulses) and time (250 µs cycles).
    pub band: (i32, i32),
    /// Software limits, pulses.
    pub soft: (i32, i32),
    /// Following-error limit, pulses; `i32::MAX` is off.
    pub pos_err: i32,
    /// Trap parameters.
    pub trap: TrapPrm,
    /// Jog parameters.
    pub jog: JogPrm,
    /// PVT table that was selected, by its index over all cores.
    pub table: Option<u8>,
    /// PVT passes to run, 0 for endless.
    pub table_passes: i32,
    /// Follow, FollowEx and Gear.
    pub follow: FollowShadow,
    /// Target velocity, pulse/ms.
    pub vel: f64,
    /// Target position, pulses.
    pub pos: i32,
}

impl AxisShadow {
    /// At power-on (SPEC 5); its default is all zero.
    pub fn power_on() -> Self {
        let (dec, follow) = ((1.0, 1000.0), FollowShadow::power_on());
        AxisShadow { dec, soft: SOFT_OFF, pos_err: i32::MAX, table_passes: 1, follow, ..AxisShadow::default() }
    }
    /// Whether PT data of this axis forms one ring.
    pub fn is_dynamic(&self) -> bool {
        self.mode == MotionMode::PtDynamic
    }
    /// Whether the axis is in a PT mode.
    pub fn is_pt(&self) -> bool {
        matches!(self.mode, MotionMode::PtStatic | MotionMode::PtDynamic)
    }
    /// Whether the axis is in Follow, FollowEx or Gear mode.
    pub fn is_follow(&self) -> bool {
        matches!(self.mode, MotionMode::Follow | MotionMode::FollowEx | MotionMode::Gear)
    }
    /// The FIFO of Follow that runs when the next entry acts, if the axis does and does not switch.
    pub fn running_fifo<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> u8 {
        if is_in_flight(view, self.busy) { self.fifo } else { axis.fifo }
    }
    /// Whether a switch to the other FIFO is pending when the next entry acts.
    pub fn is_switching<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        axis.switching || self.follow.is_to_switch(view)
    }
    /// Whether the motion that runs when the next entry acts uses the other FIFO, and stays there
    /// in the tick.
    pub fn leaves_alone<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView, fifo: u8) -> bool {
        if self.is_follow() {
            let switches = self.is_switching(view, axis) || self.follow.has_switches();
            self.running_fifo(view, axis) != fifo && !switches
        } else {
            self.mode == MotionMode::PtStatic && self.fifo != fifo
        }
    }
    /// Whether a command's effect on the FIFOs of Follow is known only at its instant.
    pub fn may_switch<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        self.is_busy(view, axis) && (self.is_switching(view, axis) || self.follow.has_switches())
    }
    /// As [`AxisShadow::is_outgoing`], of a FIFO of Follow.
    pub fn is_follow_outgoing<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView, fifo: u8) -> bool {
        // A start of its lane after what empties the FIFO reads the new data.
        let in_order = |(emptied, start): (u32, u32)| (emptied ^ start) & PROGRAM_FLAG == 0;
        let before =
            if self.follow.emptied(fifo).zip(self.busy).is_some_and(in_order) { self.dropped_start } else { self.busy };
        let busy = axis.status & RUNNING != 0 || is_in_flight(view, before);
        // The tick is known to run the other FIFO. With a start in flight, one before it may be in
        // flight, too.
        let idle = self.busy.is_none_or(|seq| executed(view, seq)) && axis.fifo != fifo && !self.may_switch(view, axis);
        self.is_outgoing(view, axis) || busy && !idle && self.follow.is_invalid(view, fifo)
    }
    /// Whether a start is in flight that the tick refuses as far as the view shows: its servo is
    /// off or a fault is latched, and nothing before the start changes that.
    pub fn may_not_start<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        let Some(start) = self.started.filter(|&seq| !executed(view, seq)) else { return false };
        let before = |seq: u32| (seq ^ start) & PROGRAM_FLAG == 0 && is_up_to(seq, start) && !executed(view, seq);
        let on = match self.servo {
            Some((seq, on)) if before(seq) => on,
            _ => axis.status & SERVO_ON != 0,
        };
        !on || axis.blocked != 0 && !self.cleared.is_some_and(before)
    }
    /// Whether a PT or ramp motion may be running when the next entry acts.
    pub fn may_run<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        self.started.is_some_and(|seq| !executed(view, seq) || axis.status & RUNNING != 0)
    }
    /// The planned position at which the next entry finds the axis; none while only the tick knows.
    pub fn position<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> Option<Pos> {
        match self.position_set {
            _ if self.is_busy(view, axis) => None,
            Some((seq, pos)) if !executed(view, seq) => Some(pos),
            _ => Some(axis.pos),
        }
    }
    /// Whether the tick itself may still be working through data of an earlier start.
    pub fn is_busy<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        axis.status & RUNNING != 0 || is_in_flight(view, self.busy)
    }
    /// Whether the data of a FIFO is over at this point of the lane while the tick may still read
    /// it: a stream that a WaitStop waits for, or a FIFO that will be emptied.
    pub fn is_outgoing<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        let runs = axis.status & RUNNING != 0;
        let emptied = is_in_flight(view, self.emptied) && (runs || is_in_flight(view, self.dropped_start));
        // A stream that a Stop has ended is over while its axis still brakes.
        let streams = axis.pt_state == pt_state::RUNNING || is_in_flight(view, self.busy);
        let ended = self.is_dynamic() && self.started.is_none() && streams;
        emptied || ended
    }
    /// Segments that one FIFO (in dynamic mode, the ring) holds.
    pub fn capacity(&self) -> u32 {
        match (self.is_dynamic(), self.memory) {
            (false, 0) => 32,
            (false, _) => 1024,
            (true, 0) => 64,
            (true, _) => 2048,
        }
    }
    /// Free slots of a FIFO, as far as the view shows.
    pub fn space<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView, fifo: usize) -> u32 {
        if self.is_dynamic() && self.is_outgoing(view, axis) {
            return self.capacity();
        }
        let end = self.fifos.get(fifo).map_or(0, |fifo| fifo.end);
        // A ring that will be emptied has released nothing of what follows.
        let emptied = is_in_flight(view, self.emptied);
        let released = if self.is_dynamic() && !emptied { axis.released } else { 0 };
        self.capacity().saturating_sub(end.wrapping_sub(released))
    }
    /// Entry `seq` empties the FIFOs of these bits.
    pub(super) fn empty(&mut self, seq: u32, fifos: u8) {
        self.emptied = Some(seq);
        self.dropped_start = self.busy;
        self.invalid &= !fifos;
    }
    /// Entry `seq` starts it.
    pub(super) fn start(&mut self, seq: u32) {
        (self.started, self.busy) = (Some(seq), Some(seq));
    }
    /// Entry `seq` empties its FIFOs of PT.
    pub(super) fn empty_all(&mut self, seq: u32) {
        self.fifos = [FifoShadow::default(); 2];
        self.empty(seq, 3);
    }
    /// Entry `seq` stops it: a stream that runs then is over, and so is its data.
    pub(super) fn stop(&mut self, seq: u32) {
        if core::mem::take(&mut self.stream_begins) != 0 {
            self.empty(seq, 0);
        }
    }
    /// Whether a FIFO holds data, in the present mode.
    pub(super) fn holds(&self, fifo: u8) -> bool {
        if self.is_follow() {
            !self.follow.fifo(fifo).is_empty()
        } else {
            self.fifos
                .iter()
                .enumerate()
                .any(|(index, data)| data.end != 0 && (self.is_dynamic() || index == usize::from(fifo)))
        }
    }
    /// Calls `young` with every entry number.
    pub(super) fn renew(&mut self, young: &mut impl FnMut(&mut u32)) {
        let AxisShadow { started, busy, position_set, servo, cleared, emptied, dropped_start, follow, .. } = self;
        [started, busy, cleared, emptied, dropped_start].into_iter().flatten().for_each(&mut *young);
        position_set.iter_mut().for_each(|(seq, _)| young(seq));
        servo.iter_mut().for_each(|(seq, _)| young(seq));
        follow.renew(young);
    }
    /// Follows the tick: an ended stream is cleared, an axis at standstill is taken as such.
    pub fn update_from<const AXES: usize>(&mut self, view: &View<AXES>, axis: &AxisView) {
        if self.epoch != axis.epoch {
            self.epoch = axis.epoch;
            if self.started.is_none_or(|seq| executed(view, seq)) {
                self.stream_begins = 0;
            }
            if self.is_dynamic() {
                self.fifos = [FifoShadow::default(); 2];
            }
        }
        self.follow.update_from(axis);
        let over = |start: Option<u32>| start.filter(|&seq| !executed(view, seq) || axis.status & RUNNING != 0);
        self.started = over(self.started);
        self.busy = over(self.busy);
        self.dropped_start = over(self.dropped_start);
    }
}
