//! The context of an admission, and the checks that all commands share.
//!
//! In: the newest view, the admitted state, the counts of the profile. Out: checked axes, spans and
//! masks, staged tick commands. An admission changes nothing itself: it stages. Its caller pushes
//! when the whole command is known to be right.
use super::staged::Staged;
use crate::board::BoardConstants;
use crate::configuration::{Configuration, ones};
use crate::refuse::{Admitted, Refused, bits_of, choice, latched};
use crate::report::answer::{Answer, TAKEN_MAX_VALUES};
use crate::report::replies::mode_number;
use crate::report::trace::TraceColumns;
use crate::shadow::{AxisShadow, CrdParameters, CrdShadow, ShadowChange, Shadows, executed, is_in_flight};
use protocol::reason::Reason;
use servo::status::{RUNNING, SERVO_ON};
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::{Axis, AxisMask, Crd, CrdMask, Pos};
use servo::view::{AxisView, CrdView, View};

servo::state! {
    /// What is known of the instant at which a command acts.
    #[derive(Debug, Clone, Copy)]
    pub struct DueInstant {
        /// The view shows the state in which the command acts: everything admitted before it has
        /// been executed, and its instant has come.
        pub decided: bool = decided,
        /// Its instant is near: a look-ahead may take what is given to a path that runs.
        pub soon: bool = true,
        /// From the view to the instant, ns; `u64::MAX` if it is not known.
        pub until_ns: u64 = 0,
        /// It acts on the first tick of a program that is held: axes at standstill stay so.
        pub first: bool = false,
        /// Script clock of the instant, ns, if no WaitStop takes time before it.
        pub script_ns: u64 = 0,
        /// The last WaitStop before it.
        pub wait: Option<u32> = None,
        /// What follows it in a program acts also where the tick refuses it.
        pub may_fail: bool = false,
        /// The calls before it in its PathMany were admitted just now: one commit is for all.
        pub follows: bool = false,
    }
    /// At once; `decided` if nothing before it is in flight.
    pub const fn at_once(decided: bool);
}

impl DueInstant {
    /// Not known, for a command to which it does not matter.
    pub const UNKNOWN: DueInstant =
        DueInstant { soon: false, until_ns: u64::MAX, script_ns: u64::MAX, ..DueInstant::at_once(false) };
}

/// One admission.
pub struct Context<'x, const AXES: usize> {
    /// The newest view.
    pub view: &'x View<AXES>,
    /// State after everything that was admitted.
    pub shadows: &'x Shadows<AXES>,
    /// Counts.
    pub configuration: &'x Configuration,
    /// Constants of the board.
    pub board: &'x BoardConstants,
    /// State after everything that was executed.
    pub executed: &'x Shadows<AXES>,
    /// When it acts.
    pub due: DueInstant,
    /// Coordinate systems that the board holds.
    pub crds: usize,
    /// Takes the tick commands.
    pub staged: &'x mut Staged,
    /// What else happens when the command is taken.
    pub effect: Effect,
}

/// Positions of PT and of slaves lie within ± this many pulses.
pub const TRAVEL_PULSES: f64 = Pos::TRAVEL_PULSES as f64;

/// What a command does in the thread besides its tick commands.
#[derive(Debug, Clone, Copy)]
pub enum Effect {
    /// Nothing.
    None,
    /// The controller has these counts from now on.
    Choose(Configuration),
    /// A trace of these axes, in a stream of its own or over the link.
    Trace { every: u32, columns: TraceColumns, over_link: bool },
    /// The values of [`Answer::Took`] that its lane keeps until then.
    Took([f64; TAKEN_MAX_VALUES]),
    /// The items of this LoadConfig are pushed one by one.
    Config,
}

impl<'x, const AXES: usize> Context<'x, AXES> {
    /// Stages a tick command that changes no shadow state.
    pub fn stage(&mut self, command: TickCommand) {
        self.staged.add(command, ShadowChange::None);
    }
    /// Stages a tick command and its change.
    pub fn stage_with(&mut self, command: TickCommand, change: ShadowChange) {
        self.staged.add(command, change);
    }

    /// Stages the one tick command of a command, which is answered when the tick has executed it.
    pub fn only(&mut self, command: TickCommand, change: ShadowChange) -> Admitted<Answer> {
        self.staged.add(command, change);
        Ok(Answer::Done)
    }
    /// The same of a command that names axes: without any it does nothing.
    pub fn for_axes(&mut self, axes: AxisMask, command: TickCommand, change: ShadowChange) -> Admitted<Answer> {
        if axes.0 != 0 {
            self.stage_with(command, change);
        }
        Ok(Answer::Done)
    }
    /// The same of a start: all of the axes, or none.
    pub fn start(&mut self, axes: AxisMask, command: TickCommand, change: ShadowChange) -> Admitted<Answer> {
        self.all_startable(axes)?;
        self.for_axes(axes, command, change)
    }
    /// The axis's part of the view; the last one for an axis beyond the capacity.
    pub fn sampled(&self, axis: Axis) -> &'x AxisView {
        &self.view.axes[axis.index().min(AXES - 1)]
    }
    /// Whether the view shows the axis as the command will find it: the axis makes no step in
    /// between.
    pub fn is_due(&self, axis: Axis) -> bool {
        let rests = self.sampled(axis).status & RUNNING == 0;
        self.due.until_ns < self.view.period.0 || self.due.first && rests
    }
    /// Whether the tick may still read the slots of a FIFO of PT or Follow, though its data is over
    /// in the lane.
    pub fn is_outgoing(&self, axis: Axis, fifo: u8) -> bool {
        let (shadow, sampled) = (self.shadow(axis), self.sampled(axis));
        // Without a step in between, the tick reads only the FIFO that runs.
        if self.is_due(axis) && shadow.leaves_alone(self.view, sampled, fifo) {
            return false;
        }
        if shadow.is_follow() {
            shadow.is_follow_outgoing(self.view, sampled, fifo)
        } else {
            shadow.is_outgoing(self.view, sampled)
        }
    }
    /// The shadow state of the axis.
    pub fn shadow(&self, axis: Axis) -> &'x AxisShadow {
        self.shadows.axis(axis)
    }
    /// Index of a core. The core is the first field of every command that has one.
    pub fn core(&self, core: i16) -> Admitted<usize> {
        Ok(choice(0, core, 1, i16::from(self.configuration.profile.cores))?.unsigned_abs() as usize - 1)
    }
    /// An axis of a core.
    pub fn axis(&self, core: i16, axis: i16) -> Admitted<Axis> {
        let core = self.core(core)?;
        let index =
            choice(1, axis, 1, i16::from(self.configuration.profile.axes_per_core))?.unsigned_abs() as usize - 1;
        self.nth(core * self.configuration.per_core() + index)
    }
    /// An axis of a core, if it is in this mode.
    pub fn axis_in(&self, mode: MotionMode, core: i16, axis: i16) -> Admitted<Axis> {
        let axis = self.axis(core, axis)?;
        self.in_mode(axis, self.shadow(axis).mode == mode)?;
        Ok(axis)
    }
    /// An axis by its index; the build's capacity holds every profile that could be chosen.
    pub fn nth(&self, index: usize) -> Admitted<Axis> {
        Axis::new(index)
            .filter(|axis| axis.index() < AXES)
            .ok_or_else(|| Refused::new(Reason::NotInitialised).axis(index as i16 + 1))
    }
    /// The first of `count` axes of a core (fields 0, 1, 2) and how many of them exist: a read may
    /// reach past the last one (GXN table 5-1, note 2).
    pub fn span(&self, core: i16, axis: i16, count: i16) -> Admitted<(Axis, u8)> {
        let first = self.axis(core, axis)?;
        let left = i16::from(self.configuration.profile.axes_per_core) - axis + 1;
        Ok((first, choice(2, count, 1, i16::MAX)?.min(left) as u8))
    }
    /// `count` axes of a core as a set. All of them exist.
    pub fn span_mask(&self, core: i16, axis: i16, count: i16) -> Admitted<AxisMask> {
        let (first, have) = self.span(core, axis, count)?;
        choice(2, count, 1, i16::from(have))?;
        Ok(AxisMask(ones(usize::from(have)) << first.index()))
    }
    /// The axes of a core that the bits name.
    pub fn mask(&self, core: i16, bits: i32, field: u8) -> Admitted<AxisMask> {
        let core = self.core(core)?;
        let bits = bits_of(field, bits.cast_unsigned().into(), ones(self.configuration.per_core()))?;
        Ok(AxisMask(bits << (core * self.configuration.per_core())))
    }
    /// All axes of a core.
    pub fn core_mask(&self, core: i16) -> Admitted<AxisMask> {
        let core = self.core(core)?;
        Ok(AxisMask(ones(self.configuration.per_core()) << (core * self.configuration.per_core())))
    }
    /// The axes of a set, one by one.
    pub fn each(&self, axes: AxisMask) -> impl Iterator<Item = Axis> + use<AXES> {
        (0..AXES).filter_map(Axis::new).filter(move |&axis| axes.has(axis))
    }
    /// A coordinate system of a core.
    pub fn crd(&self, core: i16, crd: i16) -> Admitted<Crd> {
        let core = self.core(core)?;
        let per_core = usize::from(self.configuration.profile.crds_per_core);
        let most = self.crds_per_core();
        let index = self.of_tick(choice(1, crd, 1, most.into()), most)?.unsigned_abs() as usize - 1;
        Crd::new(core * per_core + index)
            .filter(|crd| crd.index() < self.crds)
            .ok_or_else(|| Refused::new(Reason::CrdNotOnBoard).axis(crd).limits(0.0, self.crds as f64))
    }
    /// How many coordinate systems a core has at the tick period at which the command acts.
    pub fn crds_per_core(&self) -> u8 {
        self.shadows.crds_per_core(&self.configuration.profile, self.view)
    }
    /// Makes the refusal of a coordinate system that exists only at longer tick periods say so.
    fn of_tick<T>(&self, checked: Admitted<T>, most: u8) -> Admitted<T> {
        let fewer = most < self.configuration.profile.crds_per_core;
        checked.map_err(|refused| match refused.reason {
            Reason::Selector | Reason::OutOfRange if fewer && refused.wire.field != 0 => {
                refused.reason(Reason::CrdOfTick)
            }
            _ => refused,
        })
    }
    /// The coordinate systems of a core that the bits name.
    pub fn crd_mask(&self, core: i16, bits: i32, field: u8) -> Admitted<CrdMask> {
        let most = self.crds_per_core();
        self.of_tick(self.crds_among(core, bits, field, most), most)
    }
    /// The same for a wait: those that exist only at longer tick periods are at standstill.
    pub fn crds_waited_for(&self, core: i16, bits: i32, field: u8) -> Admitted<CrdMask> {
        self.crds_among(core, bits, field, self.configuration.profile.crds_per_core)
    }
    fn crds_among(&self, core: i16, bits: i32, field: u8, most: u8) -> Admitted<CrdMask> {
        let core = self.core(core)?;
        let bits = bits_of(field, bits.cast_unsigned().into(), ones(most.into()))?;
        let mask = bits << (core * usize::from(self.configuration.profile.crds_per_core));
        if mask >> self.crds != 0 {
            return Err(Refused::new(Reason::CrdNotOnBoard).limits(0.0, self.crds as f64));
        }
        Ok(CrdMask(mask as u8))
    }
    /// A refusal that names this coordinate system.
    pub fn no_crd(&self, reason: Reason, crd: Crd) -> Refused {
        Refused::new(reason).axis(self.configuration.crd_number(crd))
    }
    /// Its part of the view.
    pub fn crd_sampled(&self, crd: Crd) -> &'x CrdView {
        &self.view.crds[crd.index().min(Crd::MAX - 1)]
    }
    /// Its shadow state.
    pub fn crd_shadow(&self, crd: Crd) -> &'x CrdShadow {
        self.shadows.crd(crd)
    }
    /// Its parameters.
    pub fn frame(&self, crd: Crd) -> Admitted<&'x CrdParameters> {
        self.crd_shadow(crd).frame.as_ref().ok_or_else(|| self.no_crd(Reason::CrdNotSet, crd))
    }
    /// Whether it may be running when this command acts.
    pub fn crd_may_run(&self, crd: Crd) -> bool {
        self.crd_shadow(crd).may_run(self.view, self.crd_sampled(crd))
    }
    /// Refuses if it may be running.
    pub fn crd_at_standstill(&self, crd: Crd) -> Admitted<()> {
        if self.crd_may_run(crd) { Err(self.no_crd(Reason::CrdRuns, crd)) } else { Ok(()) }
    }
    /// A refusal that names this axis.
    pub fn no(&self, reason: Reason, axis: Axis) -> Refused {
        Refused::new(reason).axis(self.configuration.number_of(axis))
    }
    /// Whether the axis may be moving when this command acts.
    pub fn may_run(&self, axis: Axis) -> bool {
        let sampled = self.sampled(axis);
        self.shadow(axis).may_run(self.view, sampled) || self.may_set_off(axis, sampled.status & RUNNING != 0)
    }
    /// Whether the FIFOs of an axis hold what was admitted: it does not run when this command acts,
    /// and the tick is not at work for an earlier start.
    pub fn knows_fifos(&self, axis: Axis) -> bool {
        !self.may_run(axis) && !self.shadow(axis).is_busy(self.view, self.sampled(axis))
    }
    /// Whether an entry of a path that runs may set the axis off before this command acts.
    fn may_set_off(&self, axis: Axis, runs: bool) -> bool {
        let aside = self.shadow(axis).moved_by_entry;
        let may = |crd: Crd| {
            let (shadow, sampled) = (self.crd_shadow(crd), self.crd_sampled(crd));
            shadow.extra_axes.has(axis) && (self.crd_may_run(crd) || aside && shadow.is_busy(self.view, sampled))
        };
        let is_next = self.due.until_ns < self.view.period.0;
        if is_next { runs && (aside || Crd::all().any(may)) } else { runs && aside || Crd::all().any(may) }
    }
    /// The planned position at which this command finds an axis that is at standstill then. None
    /// while only the tick knows it: also while a path is at work that may set the axis off before.
    pub fn position(&self, axis: Axis) -> Option<Pos> {
        let may = |crd: Crd| {
            let shadow = self.crd_shadow(crd);
            shadow.extra_axes.has(axis) && shadow.is_busy(self.view, self.crd_sampled(crd))
        };
        if Crd::all().any(may) { None } else { self.shadow(axis).position(self.view, self.sampled(axis)) }
    }
    /// Refuses if the axis may be moving.
    pub fn at_standstill(&self, axis: Axis) -> Admitted<()> {
        if self.may_run(axis) { Err(self.no(Reason::Moving, axis)) } else { Ok(()) }
    }
    /// Refuses if any of these axes may be moving.
    pub fn all_at_standstill(&self, axes: AxisMask, reason: Reason) -> Admitted<()> {
        match self.each(axes).find(|&axis| self.may_run(axis)) {
            Some(axis) => Err(self.no(reason, axis)),
            None => Ok(()),
        }
    }
    /// Refuses if the axis is in a mode that is not wanted.
    pub fn in_mode(&self, axis: Axis, wanted: bool) -> Admitted<()> {
        let mode = mode_number(self.shadow(axis).mode);
        if wanted { Ok(()) } else { Err(self.no(Reason::WrongMode, axis).got(mode.into())) }
    }
    /// Refuses a start of axes of which one cannot start.
    pub fn all_startable(&self, axes: AxisMask) -> Admitted<()> {
        self.each(axes).try_for_each(|axis| self.startable(axis))
    }
    /// Refuses a start of an axis whose servo will be off or that has a latched fault.
    fn startable(&self, axis: Axis) -> Admitted<()> {
        let (shadow, sampled) = (self.shadow(axis), self.sampled(axis));
        let on = match shadow.servo {
            Some((seq, on)) if !executed(self.view, seq) => on,
            _ => sampled.status & SERVO_ON != 0,
        };
        if !on {
            return Err(self.no(Reason::ServoOff, axis));
        }
        // With a ClrSts in flight only the tick can know.
        let clearing = is_in_flight(self.view, shadow.cleared);
        if sampled.blocked != 0 && !clearing {
            return Err(self.no(latched(sampled.blocked), axis).got(sampled.status.into()));
        }
        Ok(())
    }
}
