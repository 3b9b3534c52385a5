//! How the work of an instant is spread over ticks (SPEC 7).
//!
//! In: the entries of an instant in the program lane, the state that they meet. Out: whether the
//! next one is carried out in this tick. Owns nothing. Fails: never.
//!
//! The weight of an entry is in units of about 128 instructions. Set-up is spread from tick to
//! tick, over a quarter of each. What others can observe (a start, an output, a light) begins in a
//! tick that carries out everything from there to the end of the instant, as far as the ring holds
//! it. So neighbours act together. If that is more than a tick takes, starts are prepared in the
//! ticks before it. A Reset takes as many ticks as it needs, and what follows it waits. Calls of
//! the immediate lane are counted; their weight is taken from the program.
use super::hand_overs::HandOvers;
use crate::tick::{PROGRAM_ENTRIES, Tick};
use crate::tick_command::{LaneEntry, Supervision, TickCommand};
use crate::units::{Axis, AxisMask, Ns};
use crate::view::StopReason;
use ring::Consumer;

/// Units of one axis.
mod weight {
    /// Reset, with its work in the tick after it.
    pub const RESET: u32 = 6;
    /// Another tick command that names the axis in a mask.
    pub const NAMED: u32 = 3;
    /// Another tick command on an axis, with its work in the tick after it.
    pub const SET_UP: u32 = 2;
    /// A start of PT or PVT that is planned in its tick, one of Trap, and one that is prepared.
    pub const START: u32 = 14;
    pub const RAMP: u32 = 23;
    pub const PREPARED_START: u32 = 5;
    /// The same of a slave.
    pub const SLAVE: u32 = 33;
    pub const PREPARED_SLAVE: u32 = 15;
    /// Preparing a start.
    pub const PREPARATION: u32 = 18;
    /// A Stop of one that moves.
    pub const STOP: u32 = 9;
    /// The same three of a coordinate system.
    pub const PATH: u32 = 64;
    pub const PREPARED_PATH: u32 = 28;
    pub const FRAME: u32 = 20;
    /// A change of a laser channel.
    pub const LASER: u32 = 1;
}

/// Units of set-up in the shortest tick. A longer tick has a unit for each 1024 ns, a quarter of
/// its instructions: a changed axis costs as much again in the tick and in the one after it.
const SET_UP_MIN_UNITS: u32 = 8;

/// Starts are prepared for less than 2 to this power ticks; each axis has its turn in that time.
const PREPARE_LOG2_TICKS: u32 = 6;

/// Calls of the immediate lane that act in a tick: this many in the shortest; in a longer one a
/// call for each 512 ns, as far as the larger ring goes. They have no instant and come one by one.
pub(crate) fn calls(period: Ns) -> u32 {
    ((period.0 >> 9) as u32).clamp(64, PROGRAM_ENTRIES as u32)
}

/// The work that a tick still takes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TickBudget {
    /// Units of set-up.
    pub(crate) left: u32,
    whole: u32,
    /// The instant in force acts in this tick, whatever it weighs.
    acting: Option<Ns>,
}

impl TickBudget {
    pub(crate) fn of(period: Ns) -> TickBudget {
        let whole = ((period.0 >> 10) as u32).max(SET_UP_MIN_UNITS);
        TickBudget { left: whole, whole, acting: None }
    }

    /// Whether work of this weight fits; the first of a tick always does.
    pub(crate) fn takes(&self, weight: u32) -> bool {
        weight <= self.left || self.left == self.whole
    }

    pub(crate) fn spend(&mut self, weight: u32) {
        self.left = self.left.saturating_sub(weight);
    }

    /// Units that may act in addition to those spent: with set-up, three quarters of a tick.
    fn room(&self) -> u32 {
        self.left.wrapping_add(self.whole << 1)
    }
}

impl<const AXES: usize> Tick<AXES> {
    /// The weight of a tick command in the present state. A Reset is weighed axis by axis.
    pub(crate) fn weigh(&self, command: &TickCommand) -> u32 {
        use weight::*;
        let sum = |axes: AxisMask, prepared: u32, unprepared: u32| {
            let of = |axis: Axis| {
                self.axes
                    .get(axis.index())
                    .map_or(0, |state| if state.starts_at_once() { prepared } else { unprepared })
            };
            self.in_use(axes).axes().fold(0u32, |sum, axis| sum.wrapping_add(of(axis)))
        };
        let many = |axes: AxisMask| self.in_use(axes).0.count_ones().wrapping_mul(NAMED);
        match *command {
            TickCommand::Update { axes } => sum(axes, PREPARED_START, RAMP),
            TickCommand::PtStart { axes, .. } | TickCommand::PvtStart { axes } => sum(axes, PREPARED_START, START),
            TickCommand::FollowStart { axes, .. } => sum(axes, PREPARED_SLAVE, SLAVE),
            TickCommand::CrdStart { crds, .. } => {
                let unprepared = (crds.0 & self.crds.unprepared.0).count_ones();
                crds.0
                    .count_ones()
                    .wrapping_sub(unprepared)
                    .wrapping_mul(PREPARED_PATH)
                    .wrapping_add(unprepared.wrapping_mul(PATH))
            }
            TickCommand::Stop { axes, crds, .. } => {
                let moving = self.moving(axes);
                moving.wrapping_add((crds.0 & self.crds.running.0).count_ones()).wrapping_mul(STOP).wrapping_add(1)
            }
            TickCommand::Abort => self.moving(AxisMask(u64::MAX)).wrapping_mul(STOP).wrapping_add(STOP),
            TickCommand::Zero { axes } | TickCommand::ClearStatus { axes } => many(axes),
            TickCommand::CrdFrame { .. } => FRAME,
            TickCommand::Laser { .. } => LASER,
            TickCommand::ProgramRun => 0,
            TickCommand::Mark
            | TickCommand::ProgramEnd
            | TickCommand::WaitStandstill { .. }
            | TickCommand::Output { .. }
            | TickCommand::OutputFor { .. }
            | TickCommand::EdgeCount { .. }
            | TickCommand::Analog { .. } => 1,
            _ => SET_UP,
        }
    }

    fn moving(&self, axes: AxisMask) -> u32 {
        let runs = |axis: &Axis| self.axes.get(axis.index()).is_some_and(|state| state.runs());
        self.in_use(axes).axes().filter(runs).count() as u32
    }

    /// Whether a tick command changes light, or the outputs of a laser without light.
    pub(crate) fn changes_light(&self, command: &TickCommand) -> bool {
        matches!(command, TickCommand::Laser { .. }) && self.is_observable(command)
    }

    /// Whether others can observe a tick command at once, so that its neighbours must act in the
    /// same tick.
    fn is_observable(&self, command: &TickCommand) -> bool {
        match *command {
            TickCommand::Update { .. }
            | TickCommand::PtStart { .. }
            | TickCommand::PvtStart { .. }
            | TickCommand::FollowStart { .. }
            | TickCommand::FollowSwitch { .. }
            | TickCommand::FollowSwitchNow { .. }
            | TickCommand::FollowEnd { .. }
            | TickCommand::CrdStart { .. }
            | TickCommand::CrdOverride { .. }
            | TickCommand::Stop { .. }
            | TickCommand::Abort
            | TickCommand::Servo { on: false, .. }
            | TickCommand::Output { .. }
            | TickCommand::OutputFor { .. }
            | TickCommand::Analog { .. } => true,
            TickCommand::Laser { channel, change } => self.lasers.shows(channel, &change),
            _ => false,
        }
    }

    /// Whether this entry of the program lane, the first one in it, is carried out in this tick. If
    /// not, its instant goes on in the next tick; in this one a start or two may be prepared.
    pub(crate) fn admits(
        &mut self,
        program: &Consumer<LaneEntry, PROGRAM_ENTRIES>,
        entry: &LaneEntry,
        instant: Ns,
        budget: &mut TickBudget,
        hand_overs: &HandOvers<AXES>,
    ) -> bool {
        if budget.acting == Some(instant) {
            return true;
        }
        if !self.is_observable(&entry.command) {
            return budget.takes(self.weigh(&entry.command));
        }
        let weight = neighbours(program).fold(0u32, |sum, entry| sum.saturating_add(self.weigh(&entry.command)));
        let fits = weight <= budget.room();
        let waited = self.now.0.saturating_sub(self.script.zero.0.saturating_add(instant.0));
        if !fits && waited < self.period.0 << PREPARE_LOG2_TICKS && self.prepare(program, budget, hand_overs) {
            return false;
        }
        // A tick of its own is the most that it can have.
        let acts = fits || budget.left == budget.whole || self.script.was_put_off(instant);
        if acts {
            budget.acting = Some(instant);
        }
        acts
    }

    /// Prepares starts of the instant in force, as many as the tick takes. Returns whether there
    /// were any.
    #[inline(never)]
    fn prepare(
        &mut self,
        program: &Consumer<LaneEntry, PROGRAM_ENTRIES>,
        budget: &mut TickBudget,
        hand_overs: &HandOvers<AXES>,
    ) -> bool {
        let mut prepared = false;
        for entry in neighbours(program) {
            let (TickCommand::Update { axes }
            | TickCommand::PtStart { axes, .. }
            | TickCommand::PvtStart { axes }
            | TickCommand::FollowStart { axes, .. }) = entry.command
            else {
                continue;
            };
            for axis in self.in_use(axes).axes() {
                let Some(state) = self.axes.get_mut(axis.index()) else { continue };
                if state.runs() || !state.is_unprepared() {
                    continue;
                }
                if !budget.takes(weight::PREPARATION) {
                    return true;
                }
                if let Some(source) = hand_overs.source(axis)
                    && state.prepare_start_now(&source)
                {
                    budget.spend(weight::PREPARATION);
                    prepared = true;
                }
            }
        }
        prepared
    }

    /// Goes on with a Reset. Everything stops and is dark in its first tick; then each axis gets
    /// its power-on state. Returns whether it is done.
    pub(crate) fn reset(
        &mut self,
        axes: AxisMask,
        next: Ns,
        budget: &mut TickBudget,
        hand_overs: &mut HandOvers<AXES>,
    ) -> bool {
        if self.resetting == 0 {
            self.supervision = Supervision::DEFAULT;
            self.clear &= !axes.0;
            self.enable &= !axes.0;
            self.halt(axes, StopReason::Reset, next, hand_overs);
            self.end_crds_at_standstill(next, hand_overs);
            self.drop_frames(axes);
            self.forget_alarms();
            self.lasers.reset(next);
            self.resetting = 1;
        }
        let done = (1u64 << (self.resetting.wrapping_sub(1) & 63)).wrapping_sub(1);
        for axis in self.in_use(AxisMask(axes.0 & !done)).axes() {
            if !budget.takes(weight::RESET) {
                self.resetting = (axis.index() as u8).wrapping_add(1);
                return false;
            }
            budget.spend(weight::RESET);
            self.reset_axis(axis, hand_overs.samples);
        }
        self.resetting = 0;
        true
    }
}

/// The entries of the instant in force, from the first one in the ring on.
fn neighbours<'p>(program: &'p Consumer<LaneEntry, PROGRAM_ENTRIES>) -> impl Iterator<Item = &'p LaneEntry> {
    let entries = (0..PROGRAM_ENTRIES as u32).map_while(|before| Some((before, program.peek_at(before)?)));
    let of_it = |(before, entry): &(u32, &LaneEntry)| {
        *before == 0
            || entry.delay.0 == 0
                && !matches!(entry.command, TickCommand::WaitStandstill { .. } | TickCommand::Reset { .. })
    };
    entries.take_while(of_it).map(|(_, entry)| entry)
}
