//! Laser channels in the tick.
//!
//! In: admitted changes ([`ChannelChange`]) that act at an exact instant, causes of a fault. Out:
//! for each tick and channel a [`LaserPlan`] of exact instants, and what the thread reads
//! ([`LaserView`]). Owns the channels. Fails: towards the dark, with a [`Cause`] that is latched.
//!
//! | file | what it is |
//! | --- | --- |
//! | `channel` | one channel: what changes it |
//! | `channel/interval` | its plan of a tick |
//! | `channel/gate_delays` | on and off delay of the gate |
//! | `channel/first_pulse_killer` | the pulse before the energy |
//! | `edge_queue` | pending edges under the cancel rule |
//! | `light_owner` | decides whether a channel may have light |
//! | `safety` | the state machine through which every plan passes last |
//! | `buffered` | changes that entries of a path carry, and the event queue |
//! | `power` | powers and bounds |
//! | `power_law` | direct power and both follows |
//! | `velocity_follow`, `encoder_speed` | speeds of paths, and the power that they give |
//! | `distance_follow` | the power that positions of axes add |
//! | `power_tables` | powers against velocity, ratios against position |
//! | `energy` | pulses or voltage of a power in each mode |
//! | `dither` | frequencies and duties in counts of a timer |
//! | `fixed_point` | doubles by their bits, products of fixed point |
//! | `on_time` | the time that light was on |
//! | `published` | what the tick publishes of a channel |
//! | `actions` | the plan of a tick, which timers carry out |
mod actions;
mod buffered;
mod channel;
mod distance_follow;
mod dither;
mod edge_queue;
mod encoder_speed;
mod energy;
mod fixed_point;
mod light_owner;
mod on_time;
mod power;
mod power_law;
mod power_tables;
mod published;
mod safety;
#[cfg(test)]
mod tests;
mod velocity_follow;

pub use crate::path::PathSpeed;
pub use actions::{Action, Count, FINISH_NS, LaserPlan, PLAN_ACTIONS, PulseRate, Train};
pub use buffered::Buffered;
pub use distance_follow::{Distance, Ratios};
pub use dither::{Carrier, Clock, DUTY_STEPS, FixedTrain, PPM, Pattern, Standby};
pub(crate) use encoder_speed::EncoderSpeed;
pub use encoder_speed::FilterRate;
pub use energy::counts as dac_counts;
pub use light_owner::Ignored;
pub(crate) use light_owner::PathRun;
pub use power::{Power, PowerBounds, Refused};
pub use power_law::Family;
pub(crate) use power_tables::ANALOG_OUTPUTS;
pub use power_tables::{BANKS, Curve, DISTANCES, NODES, POINTS, POWER_TABLES, PowerTables};
pub use published::LaserView;
pub use safety::Cause;
pub use velocity_follow::{Ratio, SpeedSource};

use crate::path::{LASER_WORDS, PathStop};
use crate::units::{Axis, Crd, CrdMask, Ns, Pos};
use buffered::ChannelEvent;
use channel::Channel;
pub use channel::{Delays, Fpk};
use core::num::NonZeroU16;
use distance_follow::Displacements;
use light_owner::{LightEvent, StandstillCause};
use power_law::PathSpeeds;

/// Later than any instant.
const NEVER: Ns = Ns(u64::MAX);

/// Laser channels of a controller.
pub const CHANNELS: usize = 2;

/// What the energy output does with the power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum PowerMode {
    /// Power is the duty of the carrier, in % (LaserPowerMode 0, LSR also 3).
    #[default]
    Duty = 0,
    /// Power is the rate of pulses of a fixed width, in kHz (1).
    Frequency = 1,
    /// Power is a voltage, in V (2).
    Analog = 2,
    /// As `Duty`; the switch is held active, light is made by the energy alone (GUS 3).
    DutyOpen = 3,
}

impl PowerMode {
    /// The greatest power of the mode, in both families: 100 %, 2000 kHz, 10 V.
    pub const fn full_scale(self) -> Power {
        match self {
            PowerMode::Duty | PowerMode::DutyOpen => Power::whole(100),
            PowerMode::Frequency => Power::MAX,
            PowerMode::Analog => Power::whole(10),
        }
    }

    /// Whether standby pulses are output while there is no light: not in analog mode, and not where
    /// an open switch would let them out.
    pub const fn has_standby(self) -> bool {
        matches!(self, PowerMode::Duty | PowerMode::Frequency)
    }
}

/// A change of a channel. It acts at the instant of the tick that is being computed when it is
/// executed: the first one after its instant on the script clock.
#[allow(missing_docs, reason = "each variant's text names its fields")]
#[derive(Debug, Clone, Copy)]
pub enum ChannelChange {
    /// On or off command; its edge comes after the delay in force now. On does nothing while the
    /// channel is dark.
    Gate { on: bool },
    /// Mode and bounds. Another mode ends the light at once, withdraws the on command and sets the
    /// direct power to 0; the same one takes the bounds and `delayed` only. `delayed`: the gate's
    /// delays apply (GUS: always).
    Mode { mode: PowerMode, bounds: PowerBounds, delayed: bool, fixed: Option<FixedTrain> },
    /// Direct power.
    Direct { power: Power, fixed: Option<FixedTrain> },
    /// Carrier of the duty modes.
    Carrier { carrier: Carrier, fixed: Option<FixedTrain> },
    /// Pulse width of the frequency mode, µs.
    PulseWidth { us: NonZeroU16 },
    /// Gate delays.
    Delays(Delays),
    /// First-pulse killer; `None` is off.
    Fpk(Option<Fpk>),
    /// Standby pulses; `None` is off.
    Standby(Option<Standby>),
    /// The same, by a command of the other channel: standby stays off after an abort or a new
    /// session.
    PairedStandby(Option<Standby>),
    /// Pre-voltage, 0 to 10 V; `None` is off.
    PreVoltage(Option<Power>),
    /// On-time counts from 0 again.
    ZeroOnTime,
    /// A fault whose cause is gone is over.
    ClearFault,
    /// The same for a Reset, which is done also while the cause lasts.
    ResetFault,
    /// The coordinate systems that the channel is mapped to, bit 0 is crd 1.
    CrdMap { map: u8 },
    /// Whether the connector of the energy output carries it (SetAxisMode); else PWM energy stays
    /// in its safe state. Taking it away ends the light at once and withdraws the on command, as
    /// another mode does; analog mode does not use it.
    Connector { laser: bool },
    /// Distance follow (SetLaserDisMode, SetLaserDisRatio and the tables of ratios, as a whole);
    /// `None` is off.
    Distance(Option<Distance>),
    /// Power-on state of a family. It clears no fault: choosing a family must not hide one.
    Reset { family: Family },
}

/// An axis whose position the power of a channel may follow.
pub(crate) trait Positions: Copy {
    /// Its planned position.
    fn planned(&self) -> Pos;
    /// Its last encoder sample, whole pulses.
    fn encoder(&self) -> i64;
}

/// The values that the power of a channel may follow, at the tick that is computed.
#[derive(Clone, Copy)]
pub(crate) struct FollowInputs<'a, A> {
    clock: Clock,
    speeds: &'a PathSpeeds,
    tables: &'a PowerTables,
    axes: &'a [A],
    /// Of the axes that the channel follows by fixed ratios, if it does.
    displacements: &'a Displacements,
}

impl<A: Positions> FollowInputs<'_, A> {
    /// One of the speeds of paths, [`PathSpeeds::index`].
    #[inline(always)]
    fn speed(&self, index: usize) -> PathSpeed {
        if self.speeds.fed >> (index & power_law::INDEX_MASK) & 1 == 0 {
            return PathSpeed::STANDSTILL;
        }
        self.speeds.of.get(index).copied().unwrap_or_default()
    }

    /// The planned position of an axis, or its last encoder sample.
    #[inline]
    fn position(&self, axis: Axis, source: SpeedSource) -> Pos {
        self.axes.get(axis.index()).map_or(Pos(0), |axis| match source {
            SpeedSource::Planned => axis.planned(),
            SpeedSource::Encoder => Pos(axis.encoder() << Pos::FRAC_BITS),
        })
    }
}

/// The coordinate systems whose speeds are followed, or may be from within the coming interval on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FollowedSpeeds {
    pub(crate) planned: CrdMask,
    pub(crate) encoder: CrdMask,
}

state! {
    /// All channels of a controller, and their common state.
    ///
    /// In each tick, in this order: changes, link, starts and Stops of paths; events of paths
    /// ([`Lasers::buffered`], [`Lasers::crd_is_at_standstill`]) at any instants of the coming
    /// interval; their speeds ([`Lasers::feed_planned`]); [`Lasers::run`].
    #[derive(Debug)]
    pub(crate) struct Lasers {
        pub(crate) clock: Clock = clock,
        /// The interlock is open.
        pub(crate) interlock: bool = false,
        plan: LaserPlan = LaserPlan::EMPTY,
        speeds: PathSpeeds = PathSpeeds::STANDSTILL,
        displacements: [Displacements; CHANNELS] = [Displacements::begin(0), Displacements::begin(1)],
        pub(crate) channels: [Channel; CHANNELS] = [Channel::power_on(0), Channel::power_on(1)],
    }
    pub(crate) const fn new(clock: Clock);
}

impl Lasers {
    /// The published views of the channels.
    pub(crate) fn published(&self) -> impl Iterator<Item = &LaserView> {
        self.channels.iter().map(|channel| &channel.published)
    }

    /// The levels of a channel's outputs at the end of the interval that was planned last, as
    /// actions that bring outputs there from the safe state.
    pub(crate) fn carried(&self, channel: u8) -> [Action; 3] {
        let dark = Action::Dark { standby: Train::NONE, cut: true };
        let rest = [Action::Switch(false), dark, Action::Volts(0)];
        self.channels.get(channel as usize).map_or(rest, Channel::carried)
    }

    /// Whether outputs show a change of this channel at once: it has light or standby, or is about
    /// to.
    pub(crate) fn shows(&self, channel: u8, change: &ChannelChange) -> bool {
        let begins = matches!(
            change,
            ChannelChange::Gate { .. }
                | ChannelChange::Standby(Some(_))
                | ChannelChange::PairedStandby(Some(_))
                | ChannelChange::PreVoltage(Some(_))
        );
        begins
            || self.channels.get(channel as usize).is_some_and(|channel| {
                let LaserView { commanded, gate, light, power, .. } = channel.published;
                commanded || gate || light || power != Power::ZERO
            })
    }

    /// Carries out a change at an instant of the interval that is planned next. Returns whether it
    /// is an on command that a fault forbids.
    #[inline(never)]
    pub(crate) fn change(&mut self, channel: u8, at: Ns, change: &ChannelChange) -> bool {
        self.channels.get_mut(channel as usize).is_some_and(|channel| channel.change(at, change))
    }

    /// An entry of a path takes effect at an instant of the interval that is planned next: that of
    /// `path::EntryEffect::Laser`, its fraction of a ns cut off.
    pub(crate) fn buffered(&mut self, run: PathRun, channel: u8, at: Ns, code: u8, words: &[u32; LASER_WORDS]) {
        if let (Some(channel), Some(change)) = (self.channels.get_mut(channel as usize), Buffered::unpack(code, words))
        {
            channel.queue_event(at, ChannelEvent::Change(run, change));
        }
    }

    /// Whether an analog output is that of a channel in analog mode.
    pub(crate) fn drives(&self, output: u8) -> bool {
        self.channels.get(output as usize).is_some_and(Channel::is_analog)
    }

    /// Whether every channel has a slot for one more entry of a path.
    pub(crate) fn has_room(&self) -> bool {
        self.channels.iter().all(Channel::has_room)
    }

    /// A path comes to standstill at an instant of the interval that is planned next.
    pub(crate) fn crd_is_at_standstill(&mut self, run: PathRun, at: Ns, rest: PathStop) {
        let (end, cause) = match rest {
            PathStop::Underrun => (StandstillCause::Failed, Cause::Underrun),
            PathStop::Obstructed => (StandstillCause::Failed, Cause::Limit),
            PathStop::Never | PathStop::Completed => (StandstillCause::RanOut, Cause::None),
            PathStop::Stopped => (StandstillCause::Stopped, Cause::None),
        };
        self.channels.iter_mut().for_each(|channel| channel.queue_event(at, ChannelEvent::Standstill(run, end, cause)));
    }

    /// A path starts at the instant of the tick computed; `resumes`: its FIFO goes on where it was
    /// interrupted.
    pub(crate) fn crd_starts(&mut self, run: PathRun, at: Ns, resumes: bool) {
        self.handle(at, LightEvent::Starts { run, resumes });
    }

    /// A FIFO of a path at standstill is cleared.
    pub(crate) fn fifo_cleared(&mut self, run: PathRun, at: Ns) {
        for channel in &mut self.channels {
            channel.fifo_cleared(at, run);
        }
    }

    /// These, of which each has been set up, brake for a Stop, an interlock or a lost link; or a
    /// Stop finds them at standstill.
    pub(crate) fn crd_stops(&mut self, crds: CrdMask, at: Ns) {
        if crds.0 != 0 {
            self.handle(at, LightEvent::Stops { crds });
        }
    }

    /// Every channel takes a fact.
    fn handle(&mut self, at: Ns, fact: LightEvent) {
        for channel in &mut self.channels {
            channel.attend(at);
            channel.report(at, fact);
        }
    }

    /// Reset: every channel is dark at the call, and its fault is over, if the cause is gone.
    pub(crate) fn reset(&mut self, at: Ns) {
        self.channels.iter_mut().for_each(|channel| channel.reset_latch(at));
    }

    /// Abort: every channel is dark at the call, and pending edges are withdrawn. Nothing lights
    /// without a new on command, which is refused until [`Lasers::abort_over`].
    pub(crate) fn abort(&mut self, at: Ns) {
        self.channels.iter_mut().for_each(|channel| channel.abort(at, true));
    }

    /// A new session: the same, but on commands are taken, and the follows of the session before
    /// end.
    pub(crate) fn new_session(&mut self, at: Ns) {
        self.end_follow(CrdMask(u8::MAX), at);
        self.channels.iter_mut().for_each(|channel| channel.abort(at, false));
    }

    /// The paths whose on entries light no channel until they have come to standstill.
    pub(crate) fn dead(&self) -> CrdMask {
        CrdMask(self.channels.iter().fold(u8::MAX, |mask, channel| mask & channel.dead().0))
    }

    /// Everything that ran at the abort is at standstill.
    pub(crate) fn abort_over(&mut self, at: Ns) {
        self.handle(at, LightEvent::AbortOver);
    }

    /// A fault of a coordinate system (SPEC 9), which is over as soon as it is reported: every
    /// channel whose map holds it goes dark at the call.
    pub(crate) fn crd_fault(&mut self, crd: Crd, cause: Cause) {
        self.channels.iter_mut().filter(|channel| channel.is_mapped(crd)).for_each(|channel| channel.trip(cause));
    }

    /// The coordinate systems with an axis whose alarm input is active, in each tick in which that
    /// changes: the fault of a channel whose map holds one cannot be cleared.
    pub(crate) fn crd_alarms(&mut self, crds: CrdMask) {
        self.channels.iter_mut().for_each(|channel| channel.alarms(crds));
    }

    /// ClrSts of an axis of these: the faults of channels whose map holds one are cleared, if their
    /// causes are gone.
    pub(crate) fn crd_cleared(&mut self, crds: CrdMask, at: Ns) {
        self.channels.iter_mut().for_each(|channel| channel.clear(at, crds));
    }

    /// Ends the velocity follows that these began (Stop, bits 10 and 11).
    pub(crate) fn end_follow(&mut self, crds: CrdMask, at: Ns) {
        self.channels.iter_mut().for_each(|channel| channel.end_follow(at, crds));
    }

    /// The speeds of paths that are to be fed, each once its path has taken its step.
    #[inline]
    pub(crate) fn wants(&self) -> FollowedSpeeds {
        let (mut planned, mut encoder) = (0, 0);
        for channel in &self.channels {
            let (of, too) = channel.wants();
            (planned, encoder) = (planned | of.0, encoder | too.0);
        }
        FollowedSpeeds { planned: CrdMask(planned), encoder: CrdMask(encoder) }
    }

    /// Whether a channel follows the encoders of a path.
    pub(crate) fn follows_encoders(&self, crd: Crd) -> bool {
        self.channels.iter().any(|channel| channel.follows_encoders(crd))
    }

    /// The speed of a path in the interval that is planned next ([`crate::path::Path::mean`]). A
    /// speed that is not fed is 0.
    pub(crate) fn feed_planned(&mut self, crd: Crd, speed: PathSpeed) {
        self.speeds.put(PathSpeeds::index(crd, false), speed);
    }

    /// The speed of its encoders in the last interval ([`PathSpeed::measured`]).
    pub(crate) fn feed_measured(&mut self, crd: Crd, speed: PathSpeed) {
        self.speeds.put(PathSpeeds::index(crd, true), speed);
    }

    /// A cause that is over as soon as it is reported.
    pub(crate) fn trip(&mut self, cause: Cause) {
        self.channels.iter_mut().for_each(|channel| channel.trip(cause));
    }

    /// The host link; `runs`: a program or a path runs, which may switch light on.
    pub(crate) fn link(&mut self, lost: bool, runs: bool) {
        self.channels.iter_mut().for_each(|channel| channel.link(lost, runs));
    }

    /// Plans the interval of `period` from `next` on and outputs it.
    /// `axes` have their state of the tick at `next`.
    #[inline]
    pub(crate) fn run(
        &mut self,
        next: Ns,
        period: Ns,
        tables: &PowerTables,
        axes: &[impl Positions],
        mut output: impl FnMut(u8, &LaserPlan),
    ) {
        let interlock = self.interlock;
        let mut around = FollowInputs {
            clock: self.clock,
            speeds: &self.speeds,
            tables,
            axes,
            displacements: &Displacements::OF_NOBODY,
        };
        self.plan.lasts = period.0 as u32;
        for (index, (channel, displacements)) in (0..).zip(self.channels.iter_mut().zip(&mut self.displacements)) {
            // If channels follow the same positions, one sample is enough.
            if let Some(key) = channel.followed_axes().filter(|key| !around.displacements.are_of(*key)) {
                displacements.look(key, axes);
                around.displacements = displacements;
            }
            channel.step(next, period, interlock, &around, &mut self.plan);
            output(index, &self.plan);
        }
        self.speeds.fed = 0;
    }

    /// Brings the published views up to date.
    #[inline]
    pub(crate) fn publish(&self, published: &mut [LaserView; CHANNELS]) {
        for (to, channel) in published.iter_mut().zip(&self.channels) {
            to.copy_changed(&channel.published);
        }
    }
}
