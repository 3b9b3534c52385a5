//! Light owner: the one place that decides whether a channel may have light (SPEC 6, "Whose light
//! it is" and "Rest"; SPEC 9).
//!
//! In: a [`LightEvent`] at a time, in the order in which they happen. Out: a [`GateOrder`] to the
//! gate. Owns: who lit the channel, what holds the light dark, and what brings it back. Cannot
//! fail: [`Owner::handle`] is total, and everything else only reports facts to it.
//! `light_owner/tests.rs` enumerates all states that facts can reach.
//!
//! | state | who lit it | what holds it dark | what brings light |
//! | --- | --- | --- | --- |
//! | `Off` | nobody | no on command is in force | an on command of a call or of a path |
//! | `On` | a call, or a path that runs | nothing: it is the only state with light | – |
//! | `Held` | either | the Stop, or the lost link, that shut it off | the CrdStart that goes on, of every path that holds it |
//! | `Waits` | either | the follow's path is at standstill | the next CrdStart of that path |
//!
//! | fact | what it does |
//! | --- | --- |
//! | on command of a call | lights, or waits; changes nothing while a path's light is on |
//! | on entry of a path | lights, or waits; takes over the light of a call. It does nothing for a channel that is not mapped, after an abort until the path has come to standstill, and while the path brakes (for a Stop, an interlock, a lost link) after an immediate off |
//! | off command, off entry | `Off` |
//! | a mapped path rests by a Stop | `Held`, whoever lit it; `Off` if its entries ran out while it braked |
//! | a path's entries run out | `Off` for what they lit, and for what follows its speed |
//! | a path starts | see "what brings light" |
//! | a FIFO is cleared | `Off`, if it held the light |
//! | a Stop that finds its mapped paths at standstill | `Off` |
//! | the follow ends, or another one replaces it | `Waits` becomes `Off` |
//! | a cause of SPEC 9 | `Off`, at once. A lost link: `Held` by the paths that run |
//! | abort, new session, another mode, no connector, power-on state | `Off`, at once |
//!
//! On commands that come while a cause is latched do nothing and are not remembered.
#[cfg(test)]
mod tests;

use crate::capacity::Fifos;
use crate::units::{Crd, CrdMask};

/// A path that runs one of its FIFOs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PathRun {
    pub(crate) crd: Crd,
    pub(crate) fifo: u8,
}

/// Who gave the on command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum LitBy {
    /// An immediate command.
    Call,
    /// An entry of this coordinate system.
    Path(Crd),
}

/// The state of the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Light {
    /// No on command is in force.
    Off,
    /// The gate is commanded on.
    On(LitBy),
    /// Dark until every path that holds it has gone on.
    Held(LitBy, Holders),
    /// Dark until the path whose speed the power follows starts.
    Waits(LitBy),
}

/// Paths whose Stop holds light dark: a bit for each FIFO 0 of a coordinate system, then one for
/// each FIFO 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Holders(Fifos);

/// Bits of one FIFO.
const HALF: u32 = Fifos::BITS / 2;
const _: () = assert!(Crd::MAX <= HALF as usize && HALF.is_power_of_two(), "a bit each");

impl Holders {
    const fn of(run: PathRun) -> Holders {
        let first = Holders::first(run.crd);
        Holders(if run.fifo & 1 == 0 { first } else { first << HALF })
    }

    const fn first(crd: Crd) -> Fifos {
        1 << (crd.index() as u32 & (HALF - 1))
    }

    const fn both(crd: Crd) -> Fifos {
        let first = Holders::first(crd);
        first | first << HALF
    }

    const fn has(self, run: PathRun) -> bool {
        self.0 & Holders::of(run).0 != 0
    }

    /// One more, unless another FIFO of the same coordinate system holds the light already.
    const fn and(self, run: PathRun) -> Holders {
        if self.0 & Holders::both(run.crd) != 0 { self } else { Holders(self.0 | Holders::of(run).0) }
    }

    const fn without(self, run: PathRun) -> Holders {
        Holders(self.0 & !Holders::of(run).0)
    }

    const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The coordinate systems among them.
    const fn crds(self) -> CrdMask {
        let any = self.0 | self.0 >> HALF;
        #[allow(clippy::unnecessary_cast, reason = "with few coordinate systems it is a byte")]
        let crds = (any & Fifos::MAX >> HALF) as u8;
        CrdMask(crds)
    }
}

/// Whether a cause of SPEC 9 is latched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Latch {
    None,
    LinkLost,
    Other,
}

/// How a path came to standstill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum StandstillCause {
    /// Its entries have run out.
    RanOut,
    /// By a Stop, or another command to brake, from which it can go on.
    Stopped,
    /// By an underrun or a fault.
    Failed,
}

/// A fact that is reported to the owner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum LightEvent {
    /// An immediate on or off command.
    Command { on: bool },
    /// A BufLaserOn or BufLaserOff is reached.
    Entry { on: bool, run: PathRun },
    /// A path starts; `resumes`: its FIFO goes on where it was stopped.
    Starts { run: PathRun, resumes: bool },
    /// A FIFO is cleared while its path is at standstill: it does not go on.
    Clears { run: PathRun },
    /// A path has come to standstill.
    Standstill { run: PathRun, end: StandstillCause },
    /// A Stop, an interlock or a lost link for these, of which each has been set up.
    Stops { crds: CrdMask },
    /// The power follows the speed of this one from now on.
    FollowBegins { crd: Crd },
    /// The velocity follow is over.
    FollowEnds,
    /// SetLaserCrdMap.
    Map { crds: CrdMask },
    /// Whether the energy has an output.
    Output { there: bool },
    /// Another mode, or a connector that is taken away.
    Withdraw,
    /// Reset: no command has been given yet.
    PowerOn,
    /// A cause of SPEC 9 is latched.
    Latched { link: bool },
    /// It is cleared.
    Cleared,
    /// Abort; `refuses`: all motion brakes, and on commands are refused until it has stopped. A new
    /// session: neither.
    Abort { refuses: bool },
    /// Everything that ran at the abort has come to standstill.
    AbortOver,
    /// The gate has been cleared under an on command that holds.
    Relight,
}

/// The effect on the gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GateOrder {
    /// Nothing.
    Keep,
    /// An on command, with its delay.
    On,
    /// An off command, with its delay.
    Off,
    /// Dark at once, without delays; nothing pends.
    Cut,
    /// Nothing; an on command that had been admitted is an event.
    Ignored(Ignored),
}

/// Why an admitted command has no effect; the numbers are those of `EventItem`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Ignored {
    /// None was.
    #[default]
    None = 0,
    /// The channel is not mapped to the coordinate system of the entry.
    NotMapped = 1,
    /// It has no output.
    NoOutput = 2,
    /// An abort is in progress.
    Aborting = 3,
    /// A fault keeps the channel dark.
    Fault = 4,
}

state! {
    /// See the module text.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub(super) struct Owner {
        light: Light = Light::Off,
        latch: Latch = Latch::None,
        /// An immediate off, and no on command since.
        vetoed: bool = false,
        aborting: bool = false,
        /// The energy has an output.
        output: bool = true,
        /// Coordinate systems that the channel is mapped to.
        map: CrdMask = map,
        /// Those that run, those of them that run FIFO 1, and those that brake to go on later.
        running: CrdMask = CrdMask(0),
        fifo1: CrdMask = CrdMask(0),
        stopping: CrdMask = CrdMask(0),
        /// Those whose on entries have no effect: they ran at an abort, and have not come to
        /// standstill.
        pub(super) dead: CrdMask = CrdMask(0),
        /// The coordinate system whose speed the power follows.
        follow: Option<Crd> = None,
    }
    /// Of a channel at power-on.
    pub(super) const fn power_on(map: CrdMask);
}

impl Owner {
    /// Whether an on command is in force, as GetHSIOOpt reports it.
    pub(super) const fn is_commanded(&self) -> bool {
        matches!(self.light, Light::On(_) | Light::Waits(_))
    }

    /// Whether the gate is commanded on.
    pub(super) const fn is_lit(&self) -> bool {
        matches!(self.light, Light::On(_))
    }

    /// Whether a fault keeps the channel dark.
    pub(super) fn is_latched(&self) -> bool {
        self.latch != Latch::None
    }

    /// Whether the Stop of this path, or a lost link, holds the light.
    pub(super) fn is_held_by(&self, run: PathRun) -> bool {
        matches!(self.light, Light::Held(_, by) if by.has(run))
    }

    /// The coordinate systems whose light is on, or would come back with their CrdStart.
    pub(super) fn owners(&self) -> CrdMask {
        match self.light {
            Light::Off | Light::On(LitBy::Call) | Light::Waits(LitBy::Call) => CrdMask(0),
            Light::On(LitBy::Path(crd)) | Light::Waits(LitBy::Path(crd)) => crd.mask(),
            Light::Held(who, by) => {
                let own = if let LitBy::Path(crd) = who { crd.mask().0 } else { 0 };
                CrdMask(by.crds().0 | own)
            }
        }
    }

    /// Whether entries of this coordinate system have an effect on the channel.
    pub(super) fn heeds(&self, crd: Crd) -> bool {
        self.map.has(crd)
    }

    /// Takes a fact; see the module text.
    pub(super) fn handle(&mut self, fact: LightEvent) -> GateOrder {
        match fact {
            LightEvent::Command { on: true } => self.command_on(),
            LightEvent::Command { on: false } => {
                self.vetoed = true;
                self.off()
            }
            LightEvent::Entry { run, .. } if !self.map.has(run.crd) => GateOrder::Ignored(Ignored::NotMapped),
            LightEvent::Entry { on: true, run } => self.entry_on(run.crd),
            LightEvent::Entry { on: false, .. } => self.off(),
            LightEvent::Starts { run, resumes } => self.start(run, resumes),
            LightEvent::Clears { run } => {
                if self.is_held_by(run) {
                    self.light = Light::Off;
                }
                GateOrder::Keep
            }
            LightEvent::Standstill { run, end } => self.standstill(run, end),
            LightEvent::Stops { crds } => {
                self.stopping.0 |= crds.0 & self.running.0;
                let (mapped, is_off) = (crds.0 & self.map.0, self.light == Light::Off);
                if mapped == 0 || mapped & self.running.0 != 0 || is_off { GateOrder::Keep } else { self.off() }
            }
            LightEvent::FollowBegins { crd } => {
                self.drop_waiting();
                self.follow = Some(crd);
                GateOrder::Keep
            }
            LightEvent::FollowEnds => {
                self.drop_waiting();
                self.follow = None;
                GateOrder::Keep
            }
            LightEvent::Map { crds } => self.take_map(crds),
            LightEvent::Output { there } => {
                self.output = there;
                GateOrder::Keep
            }
            LightEvent::Withdraw => self.cut(),
            LightEvent::PowerOn => {
                self.vetoed = false;
                self.cut()
            }
            LightEvent::Latched { link } => self.latch(link),
            LightEvent::Cleared => {
                self.latch = Latch::None;
                GateOrder::Keep
            }
            LightEvent::Abort { refuses } => {
                self.dead.0 |= self.running.0;
                if refuses {
                    // All motion brakes.
                    (self.aborting, self.stopping) = (true, self.running);
                }
                self.cut()
            }
            LightEvent::AbortOver => {
                self.aborting = false;
                GateOrder::Keep
            }
            LightEvent::Relight if self.is_lit() => GateOrder::On,
            LightEvent::Relight => GateOrder::Keep,
        }
    }

    fn off(&mut self) -> GateOrder {
        self.light = Light::Off;
        GateOrder::Off
    }

    fn cut(&mut self) -> GateOrder {
        self.light = Light::Off;
        GateOrder::Cut
    }

    /// Switches light on, if the follow allows it.
    fn light(&mut self, who: LitBy) -> GateOrder {
        if self.follow.is_some_and(|crd| !self.running.has(crd)) {
            self.light = Light::Waits(who);
            return GateOrder::Keep;
        }
        self.light = Light::On(who);
        GateOrder::On
    }

    fn command_on(&mut self) -> GateOrder {
        match self.light {
            _ if self.is_latched() => GateOrder::Ignored(Ignored::Fault),
            _ if self.aborting => GateOrder::Ignored(Ignored::Aborting),
            _ if !self.output => GateOrder::Ignored(Ignored::NoOutput),
            Light::On(LitBy::Path(_)) => GateOrder::Keep,
            Light::Off | Light::On(LitBy::Call) | Light::Held(..) | Light::Waits(_) => {
                self.vetoed = false;
                self.light(LitBy::Call)
            }
        }
    }

    fn entry_on(&mut self, crd: Crd) -> GateOrder {
        if self.dead.has(crd) || self.vetoed && self.stopping.has(crd) {
            return GateOrder::Keep;
        }
        if self.is_latched() {
            return GateOrder::Ignored(Ignored::Fault);
        }
        if self.aborting {
            return GateOrder::Ignored(Ignored::Aborting);
        }
        if !self.output {
            return GateOrder::Ignored(Ignored::NoOutput);
        }
        self.vetoed = false;
        self.light(LitBy::Path(crd))
    }

    fn start(&mut self, run: PathRun, resumes: bool) -> GateOrder {
        let mask = run.crd.mask().0;
        self.running.0 |= mask;
        self.stopping.0 &= !mask;
        self.fifo1.0 = if run.fifo & 1 == 1 { self.fifo1.0 | mask } else { self.fifo1.0 & !mask };
        match self.light {
            Light::Held(who, by) if by.has(run) => {
                let left = by.without(run);
                if !resumes || self.latch != Latch::None {
                    self.light = Light::Off;
                } else if left.is_empty() {
                    return self.light(who);
                } else {
                    self.light = Light::Held(who, left);
                }
                GateOrder::Keep
            }
            Light::Waits(who) if self.follow == Some(run.crd) => self.light(who),
            Light::Off | Light::On(_) | Light::Held(..) | Light::Waits(_) => GateOrder::Keep,
        }
    }

    fn standstill(&mut self, run: PathRun, end: StandstillCause) -> GateOrder {
        let crd = run.crd;
        let was_stopped = self.stopping.has(crd);
        for of in [&mut self.running, &mut self.stopping, &mut self.fifo1, &mut self.dead] {
            of.0 &= !crd.mask().0;
        }
        let is_mapped = self.map.has(crd);
        match (self.light, end) {
            (Light::Off, _) => GateOrder::Keep,
            (_, StandstillCause::Failed) if is_mapped => self.cut(),
            (Light::On(who), StandstillCause::Stopped) if is_mapped => {
                self.light = Light::Held(who, Holders::of(run));
                GateOrder::Off
            }
            (Light::Waits(who), StandstillCause::Stopped) if is_mapped => {
                self.light = Light::Held(who, Holders::of(run));
                GateOrder::Keep
            }
            (Light::Held(who, by), StandstillCause::Stopped) if is_mapped => {
                self.light = Light::Held(who, by.and(run));
                GateOrder::Keep
            }
            // What another FIFO of it holds waits for that one.
            (Light::Held(_, by), _) if by.0 & Holders::both(crd) & !Holders::of(run).0 != 0 => GateOrder::Keep,
            (Light::On(who) | Light::Held(who, _) | Light::Waits(who), _) => {
                let its = who == LitBy::Path(crd) || self.follow == Some(crd);
                if its || was_stopped && is_mapped { self.off() } else { GateOrder::Keep }
            }
        }
    }

    fn take_map(&mut self, crds: CrdMask) -> GateOrder {
        self.map = crds;
        let kept = match self.light {
            Light::Off | Light::On(LitBy::Call) | Light::Waits(LitBy::Call) => true,
            Light::On(LitBy::Path(crd)) | Light::Waits(LitBy::Path(crd)) => crds.has(crd),
            Light::Held(..) => self.owners().0 & !crds.0 == 0,
        };
        if kept { GateOrder::Keep } else { self.off() }
    }

    fn latch(&mut self, link: bool) -> GateOrder {
        self.latch = if link && self.latch != Latch::Other { Latch::LinkLost } else { Latch::Other };
        let runs = CrdMask(self.running.0 & self.map.0);
        let (who, by) = match self.light {
            Light::On(who) if link => (who, Holders(0)),
            Light::Held(who, by) if link => (who, by),
            Light::Off | Light::On(_) | Light::Held(..) | Light::Waits(_) => return self.cut(),
        };
        let run = |crd: Crd| PathRun { crd, fifo: self.fifo1.has(crd) as u8 };
        let by = runs.crds().fold(by, |by, crd| by.and(run(crd)));
        self.light = if by.is_empty() { Light::Off } else { Light::Held(who, by) };
        GateOrder::Cut
    }

    fn drop_waiting(&mut self) {
        if let Light::Waits(_) = self.light {
            self.light = Light::Off;
        }
    }
}
