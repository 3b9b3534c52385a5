//! Mutants of the rules of light, of aborts and of sessions (SPEC 6, "Whose light it is", "Rest";
//! SPEC 9).

use super::list::Mutant;

const OWNER: &str = "servo/src/laser/light_owner.rs";
const CHANNEL: &str = "servo/src/laser/channel.rs";
const SAFETY: &str = "servo/src/laser/safety.rs";
const EXECUTE: &str = "servo/src/tick/execute.rs";
const TICK: &str = "servo/src/tick.rs";

const STATES: &[&str] = &["-p", "beamtick-servo", "--lib", "--", "owner"];
const BRAKES: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "an_off_holds"];
const MOVES: &[&str] = &["-p", "beamtick-host-tests", "--test", "reference", "--", "moves_that_begin_and_end"];
const ABORT: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "laser_abort::"];
const OWNERS: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "laser_owner::"];

/// The mutants, each with a test that is not the judge of light.
pub const LIGHT: &[Mutant] = &[
    Mutant {
        name: "light: an on command counts while a cause is latched",
        file: OWNER,
        text: "_ if self.is_latched() => GateOrder::Ignored(Ignored::Fault),",
        broken: "_ if self.latch == Latch::Other => GateOrder::Ignored(Ignored::Fault),",
        test: STATES,
    },
    Mutant {
        name: "light: an on entry counts while a cause is latched",
        file: OWNER,
        text: "        if self.is_latched() {\n            return GateOrder::Ignored(Ignored::Fault);\n        }\n        if self.aborting {\n            return GateOrder::Ignored(Ignored::Aborting);",
        broken: "        if self.aborting {\n            return GateOrder::Ignored(Ignored::Aborting);",
        test: STATES,
    },
    Mutant {
        name: "light: an on command is taken during an abort",
        file: OWNER,
        text: "_ if self.aborting => GateOrder::Ignored(Ignored::Aborting),",
        broken: "_ if false => GateOrder::Ignored(Ignored::Aborting),",
        test: STATES,
    },
    Mutant {
        name: "light: on entries live on through an abort",
        file: OWNER,
        text: "self.dead.0 |= self.running.0;",
        broken: "self.dead.0 |= 0;",
        test: ABORT,
    },
    Mutant {
        name: "light: an immediate off does not hold while the path brakes",
        file: OWNER,
        text: " || self.vetoed && self.stopping.has(crd)",
        broken: "",
        test: STATES,
    },
    Mutant {
        name: "light: an immediate off is no veto",
        file: OWNER,
        text: "                self.vetoed = true;\n",
        broken: "",
        test: STATES,
    },
    Mutant {
        name: "light: an on command that meets no output is remembered",
        file: OWNER,
        text: "_ if !self.output => GateOrder::Ignored(Ignored::NoOutput),",
        broken: "_ if false => GateOrder::Ignored(Ignored::NoOutput),",
        test: STATES,
    },
    Mutant {
        name: "light: a redundant on command takes over the light of a path",
        file: OWNER,
        text: "            Light::On(LitBy::Path(_)) => GateOrder::Keep,\n            Light::Off | Light::On(LitBy::Call)",
        broken: "            Light::Off | Light::On(_)",
        test: STATES,
    },
    Mutant {
        name: "light: an entry lights a channel that is not mapped",
        file: OWNER,
        text: "LightEvent::Entry { run, .. } if !self.map.has(run.crd) =>",
        broken: "LightEvent::Entry { run, .. } if self.map.0 == 0 && !self.map.has(run.crd) =>",
        test: ABORT,
    },
    Mutant {
        name: "light: a Stop shuts off the light of its own path only",
        file: OWNER,
        text: "(Light::On(who), StandstillCause::Stopped) if is_mapped => {",
        broken: "(Light::On(who), StandstillCause::Stopped) if is_mapped && who == LitBy::Path(crd) => {",
        test: STATES,
    },
    Mutant {
        name: "light: a Stop that finds it at rest does nothing",
        file: OWNER,
        text: "if mapped == 0 || mapped & self.running.0 != 0 || is_off",
        broken: "if mapped == 0 || mapped & self.running.0 == 0 || is_off",
        test: ABORT,
    },
    Mutant {
        name: "light: one of two paths that hold light brings it back",
        file: OWNER,
        text: "} else if left.is_empty() {",
        broken: "} else if true {",
        test: STATES,
    },
    Mutant {
        name: "light: a start after CrdClear brings back what was held",
        file: OWNER,
        text: "if !resumes || self.latch != Latch::None {",
        broken: "if self.latch != Latch::None {",
        test: STATES,
    },
    Mutant {
        name: "light: a start before the fault is cleared brings back what was held",
        file: OWNER,
        text: "if !resumes || self.latch != Latch::None {",
        broken: "if !resumes {",
        test: STATES,
    },
    Mutant {
        name: "light: entries that run out while the path brakes leave the light of a call",
        file: OWNER,
        text: "if its || was_stopped && is_mapped",
        broken: "if its",
        test: STATES,
    },
    Mutant {
        name: "light: what follows a path outlives its end",
        file: OWNER,
        text: "let its = who == LitBy::Path(crd) || self.follow == Some(crd);",
        broken: "let its = who == LitBy::Path(crd);",
        test: STATES,
    },
    Mutant {
        name: "light: light under a follow at rest does not wait",
        file: OWNER,
        text: "if self.follow.is_some_and(|crd| !self.running.has(crd)) {",
        broken: "if self.follow.is_some_and(|crd| self.stopping.has(crd)) {",
        test: ABORT,
    },
    Mutant {
        name: "light: the end of a follow lets what waited wait on",
        file: OWNER,
        text: "    fn drop_waiting(&mut self) {\n        if let Light::Waits(_) = self.light {",
        broken: "    fn drop_waiting(&mut self) {\n        if let Light::Held(..) = self.light {",
        test: STATES,
    },
    Mutant {
        name: "light: a fault after a lost link lets light come back",
        file: OWNER,
        text: "if link && self.latch != Latch::Other { Latch::LinkLost } else { Latch::Other };",
        broken: "if link || self.latch == Latch::LinkLost { Latch::LinkLost } else { Latch::Other };",
        test: STATES,
    },
    Mutant {
        name: "light: a map that takes a path away leaves what it holds",
        file: OWNER,
        text: "Light::Held(..) => self.owners().0 & !crds.0 == 0,",
        broken: "Light::Held(..) => true,",
        test: STATES,
    },
    Mutant {
        name: "abort: the plan of the tick is carried out",
        file: CHANNEL,
        text: "        self.safety.force_safe_state();\n        (self.energy.muted, self.ends)",
        broken: "        (self.energy.muted, self.ends)",
        test: ABORT,
    },
    Mutant {
        name: "abort: standby, pre-voltage and the held switch go on",
        file: CHANNEL,
        text: "(self.energy.muted, self.ends) = (true, false);",
        broken: "(self.energy.muted, self.ends) = (false, false);",
        test: ABORT,
    },
    Mutant {
        name: "abort: entries of the path that it stops end the quiet",
        file: CHANNEL,
        text: "self.owner.heeds(run.crd) && !self.owner.dead.has(run.crd)",
        broken: "self.owner.heeds(run.crd)",
        test: ABORT,
    },
    Mutant {
        name: "abort: an underrun in its tick puts it off",
        file: SAFETY,
        text: "let within = !self.is_safe();",
        broken: "let within = true;",
        test: ABORT,
    },
    Mutant {
        name: "abort: axes go on",
        file: EXECUTE,
        text: "self.brake(Brake::All, StopReason::Abort, next, hand_overs);",
        broken: "self.brake(Brake::None, StopReason::Abort, next, hand_overs);",
        test: ABORT,
    },
    Mutant {
        name: "abort: on commands are taken before everything is at rest",
        file: EXECUTE,
        text: "                self.aborted = self.running();\n",
        broken: "",
        test: ABORT,
    },
    Mutant {
        name: "abort: it is never over",
        file: EXECUTE,
        text: "            self.lasers.abort_over(next);\n",
        broken: "",
        test: ABORT,
    },
    Mutant {
        name: "interlock: motion goes on",
        file: TICK,
        text: "            self.brake(self.supervision.interlock, StopReason::Interlock, next, &mut HandOvers::of(halves));\n",
        broken: "",
        test: ABORT,
    },
    Mutant {
        name: "interlock: a Reset keeps what the user chose",
        file: "servo/src/tick/workload.rs",
        text: "            self.supervision = Supervision::DEFAULT;\n",
        broken: "",
        test: ABORT,
    },
    Mutant {
        name: "session: a new one inherits light",
        file: EXECUTE,
        text: "self.lasers.new_session(next);",
        broken: "",
        test: ABORT,
    },
    Mutant {
        name: "session: a new one inherits the link-loss time",
        file: "dispatcher/src/session/commands.rs",
        text: "        let watch = Watch::DEFAULT;\n",
        broken: "        let watch = self.admission.admitted.watch;\n",
        test: OWNERS,
    },
    Mutant {
        name: "session: a Reset keeps the link-loss time",
        file: "dispatcher/src/shadow.rs",
        text: "                self.watch = Watch::DEFAULT;\n",
        broken: "",
        test: OWNERS,
    },
    Mutant {
        name: "light: an entry for a channel that is not mapped is admitted",
        file: "dispatcher/src/admit/laser/buffered.rs",
        text: "        if CrdMask(self.laser(channel).map).has(crd) {",
        broken: "        if self.laser(channel).map != 0 || CrdMask(self.laser(channel).map).has(crd) {",
        test: OWNERS,
    },
    Mutant {
        name: "light: a map is changed while light would come back",
        file: "dispatcher/src/admit/laser/mod.rs",
        text: "if ahead || context.crd_may_run(crd) || sampled.owners.has(crd) {",
        broken: "if ahead || context.crd_may_run(crd) {",
        test: OWNERS,
    },
    Mutant {
        name: "abort: on commands are admitted while everything brakes",
        file: "dispatcher/src/shadow.rs",
        text: "        view.aborts || is_in_flight(view, self.aborted)",
        broken: "        is_in_flight(view, self.aborted)",
        test: OWNERS,
    },
    Mutant {
        name: "light: a path that brakes for an interlock lights after an immediate off",
        file: "servo/src/tick/execute.rs",
        text: "        self.lasers.crd_stops(self.crds.running, next);\n",
        broken: "",
        test: BRAKES,
    },
    Mutant {
        name: "move: the first of two moves within a tick is entered before the tick",
        file: "servo/src/axis/crd_member.rs",
        text: "        self.profile.hold_until_next(next, self.published.pos);\n",
        broken: "",
        test: MOVES,
    },
];
