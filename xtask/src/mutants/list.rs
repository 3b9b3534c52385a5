//! The mutants. A text must stand in its file exactly once; `cargo check-all` sees to that.

/// The code broken in one place.
pub struct Mutant {
    /// What is wrong with it.
    pub name: &'static str,
    /// Which file of the workspace.
    pub file: &'static str,
    /// What stands there.
    pub text: &'static str,
    /// What stands there instead.
    pub broken: &'static str,
    /// Arguments of the `cargo test` that must fail, one program; names of tests after `--`. Of a
    /// mutant in `firmware/` or `hal/` the image is built too, and BEAMTICK_IMAGE names it; for
    /// tests of `beamtick-h743` the reference board's, and BEAMTICK_H743_IMAGE does.
    pub test: &'static [&'static str],
}

const GATE: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "laser_gate::"];
const LASER_PATH: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "laser_path::"];
const LASER: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "laser::"];
const LASER_FAULTS: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "laser_faults::"];
const PT: &[&str] =
    &["-p", "beamtick-servo", "--test", "all", "--", "pt_exact::short_", "pt_exact::loops_do_not_drift"];
const TICK_PT: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "tick_pt::"];
const PVT: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "pvt_run::"];
const GUARDS: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "tick_guards::"];
const CRD_AHEAD: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "crd_ahead::"];
const LOOK_AHEAD: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "lookahead::"];
const PROGRAM_ENDS: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "program_ends::"];
const LIFE_WRAPS: &[&str] = &["-p", "beamtick-host-tests", "--test", "long_life", "--", "counters_wrap"];
const LIFE_COUNTS: &[&str] = &["-p", "beamtick-host-tests", "--test", "long_life", "--", "counts_of_a_path"];
const LIFE_OLD: &[&str] = &["-p", "beamtick-host-tests", "--test", "long_life", "--", "what_was_executed_long_ago"];
const FUZZ_LINK: &[&str] = &["-p", "beamtick-fuzz", "--test", "corpus", "--", "link"];
const FUZZ_MACHINE: &[&str] = &["-p", "beamtick-fuzz", "--test", "corpus", "--", "machine"];
const FUZZ_TABLES: &[&str] = &["-p", "beamtick-fuzz", "--test", "corpus", "--", "tables"];
const LASER_CLEAR: &[&str] =
    &["-p", "beamtick-host-tests", "--test", "laser_random", "--", "a_clear_does_not_hide_the_fault"];
const FOLLOW: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "follow::data_of_follow_ex"];
const FAULTS: &[&str] =
    &["-p", "beamtick-host-tests", "--test", "emulated_faults", "--", "every_fault_of_the_program_ends_dark"];

const SAFETY: &str = "servo/src/laser/safety.rs";
const EDGES: &str = "servo/src/laser/edge_queue.rs";
const TICK: &str = "servo/src/tick.rs";
const RECEIVE: &str = "protocol/src/link/receive.rs";
const PT_RUN: &str = "servo/src/segment/pt/evaluator.rs";
const AHEAD: &str = "dispatcher/src/plan/look_ahead.rs";
const ROUNDING: &str = "dispatcher/src/plan/look_ahead/rounding.rs";
const INPUT_SCAN: &str = "servo/src/axis/input_scan.rs";
const AXIS_LIMITS: &str = "servo/src/axis/soft_limits.rs";
const SERVER: &str = "dispatcher/src/session/server.rs";
const LINK_LOSS: &str = "dispatcher/src/session/link_loss.rs";
const MPS2: &str = "hal/src/mps2_an500/mod.rs";

pub(super) const fn mutant(
    name: &'static str,
    file: &'static str,
    text: &'static str,
    broken: &'static str,
    test: &'static [&'static str],
) -> Mutant {
    Mutant { name, file, text, broken, test }
}

/// Mutants of the rest, those of one crate together: it is built once more for each of them.
pub const LIST: &[Mutant] = &[
    // -- gate ----------------------------------------------------------------------------------
    mutant(
        "an edge at the instant of a command stays",
        EDGES,
        "is_some_and(|last| *last >= at)",
        "is_some_and(|last| *last > at)",
        GATE,
    ),
    mutant("an on command replaces its off", EDGES, "self.len < GATE_EDGES - 1", "self.len < GATE_EDGES", GATE),
    // -- safety, in the tick -------------------------------------------------------------------
    mutant("a dark channel's plan does not rest", SAFETY, "plan.safe_state = true;", "plan.safe_state = false;", GATE),
    mutant(
        "an alarm shuts off nothing that it gates",
        SAFETY,
        "let begins = active && !self.alarm;",
        "let begins = false;",
        LASER_PATH,
    ),
    mutant(
        "a clear does not ask whether the cause lasts",
        SAFETY,
        "if self.was_safe && !self.lasts() {",
        "if self.was_safe {",
        GATE,
    ),
    mutant(
        "a clear hides a cause of its own tick",
        SAFETY,
        "if self.was_safe && !self.lasts() {",
        "if !self.lasts() {",
        GATE,
    ),
    mutant(
        "the interlock does not last",
        SAFETY,
        "self.interlock || self.link_lost || self.alarm",
        "self.link_lost || self.alarm",
        GATE,
    ),
    mutant(
        "the last cause is reported, not the first",
        SAFETY,
        "if !self.is_dark() {\n            (self.dark",
        "if true {\n            (self.dark",
        GATE,
    ),
    mutant("an overrun shuts off no light", TICK, "self.lasers.trip(Cause::Overrun);", "", GATE),
    mutant(
        "a latched fault does not refuse a start",
        INPUT_SCAN,
        "!self.servo_on || self.published.blocked != 0",
        "!self.servo_on",
        GUARDS,
    ),
    mutant("the edge of travel is no barrier", AXIS_LIMITS, "if to > Pos::TRAVEL {", "if to > Pos(i64::MAX) {", GUARDS),
    mutant("a soft limit is no barrier", AXIS_LIMITS, "&& to > soft", "&& to > Pos::TRAVEL", GUARDS),
    // -- evaluators ----------------------------------------------------------------------------
    mutant(
        "PT: the end speed of a segment is its mean",
        PT_RUN,
        "chain.velocity = mean.wrapping_sub(chain.velocity);",
        "chain.velocity = mean;",
        PT,
    ),
    mutant(
        "PT: a pass begins where the one before began",
        PT_RUN,
        "pass.origin = Exact(pass.origin.0.wrapping_add(chain.knot.0));",
        "",
        PT,
    ),
    mutant(
        "PT: a stream that runs dry at speed is no underrun",
        PT_RUN,
        "let at_standstill = velocity.unsigned_abs() << 1 <= *rounded as u128;",
        "let at_standstill = velocity.unsigned_abs() <= u128::MAX - *rounded as u128;",
        TICK_PT,
    ),
    mutant("PT: a loop runs once more", PT_RUN, "pass.passes >= feed.passes", "pass.passes > feed.passes", PT),
    mutant(
        "PVT: the next segment is looked for one too far",
        "servo/src/segment/pvt.rs",
        "knot.next = segment.wrapping_add(1);",
        "knot.next = segment.wrapping_add(2);",
        PVT,
    ),
    // -- safety, in the thread -----------------------------------------------------------------
    mutant(
        "a lost link does not last",
        SAFETY,
        "self.interlock || self.link_lost || self.alarm",
        "self.interlock || self.alarm",
        LASER_FAULTS,
    ),
    mutant("a restart leaves lasers live", TICK, "self.lasers.trip(Cause::Restart);", "", LASER),
    mutant(
        "a silent link is not lost",
        LINK_LOSS,
        "let silent = limit != 0 && now.0.saturating_sub(heard) > limit;",
        "let silent = limit == 1 && now.0.saturating_sub(heard) > limit;",
        LASER_FAULTS,
    ),
    mutant(
        "a lost link leaves the program running",
        LINK_LOSS,
        "        program.stop(admission, Reason::LinkLost);\n",
        "",
        PROGRAM_ENDS,
    ),
    // -- look-ahead ----------------------------------------------------------------------------
    mutant(
        "look-ahead: a corner is taken at any speed",
        "dispatcher/src/plan/look_ahead/junction.rs",
        "junction.cap = junction.cap.min(jump * jump);",
        "junction.cap = junction.cap.min(jump * jump * 1e6);",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: speeds are final at once",
        AHEAD,
        "is_final = (is_final || step.saturated) && decided && end_decided || cap == 0.0;",
        "is_final = is_final || step.saturated || after >= 0.0;",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: rounding explains more than it can",
        ROUNDING,
        "let hidden = if ends { 0.0 } else { (arm * turn).min(2.0) };",
        "let hidden = 4.0 * arm * turn;",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: a turn has one side",
        ROUNDING,
        "either |= left > 0.0 && right > 0.0;",
        "either |= left < 0.0 && right > 0.0;",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: a curve is seen by its shortest arms",
        ROUNDING,
        "arm = next;\n",
        "arm = next * 64.0;\n",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: rounding is decided before the motions have come",
        AHEAD,
        "if !now && length < motion.vel * self.limits.corner &&",
        "if !now && length < 0.0 * self.limits.corner &&",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: a full one speeds up under each plan",
        AHEAD,
        "self.level.unwrap_or_else(|| self.level()).min(high)",
        "self.level.map_or(high, |_| high)",
        CRD_AHEAD,
    ),
    mutant(
        "look-ahead: a step is kept where the junction at its end changes",
        AHEAD,
        "for counter in [counter.wrapping_sub(1), counter] {",
        "for counter in [counter] {",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: a kept step holds beyond the next line",
        "dispatcher/src/plan/look_ahead/reachable.rs",
        "to = to.min(left / steep);",
        "to = to.max(left / steep);",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: speeds leave no acceleration to go on with",
        "dispatcher/src/plan/look_ahead/reachable.rs",
        "const ARC_RESERVE_SHARE: f64 = 1.0 / 16.0;",
        "const ARC_RESERVE_SHARE: f64 = 0.0;",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: an axis's speed is not limited",
        AHEAD,
        "vel = vel.min(most / share);",
        "vel = vel.min(vel / share);",
        LOOK_AHEAD,
    ),
    // -- counters that wrap ----------------------------------------------------------------------
    mutant(
        "entry numbers of a lane are compared as they stand",
        "dispatcher/src/shadow/entry_numbers.rs",
        "(last.wrapping_sub(seq) << 1).cast_signed() >= 0",
        "last >= seq",
        LIFE_WRAPS,
    ),
    mutant(
        "numbers of what was executed long ago stay as they are",
        "dispatcher/src/session/commands.rs",
        "if self.renewed.is_due(view) {",
        "if self.renewed.is_due(view) && view.tick == 0 {",
        LIFE_OLD,
    ),
    mutant(
        "free slots of a path are counted as they stand",
        "dispatcher/src/shadow/crd_space.rs",
        "self.path(fifo).data.given.wrapping_sub(self.released(sampled, fifo))",
        "self.path(fifo).data.given.saturating_sub(self.released(sampled, fifo))",
        LIFE_COUNTS,
    ),
    mutant(
        "on-time stands still at its end",
        "servo/src/laser/on_time.rs",
        "self.units = self.units.wrapping_add(sum / UNIT_NS);",
        "self.units = self.units.saturating_add(sum / UNIT_NS);",
        LIFE_COUNTS,
    ),
    // -- invariants of fuzzing -----------------------------------------------------------------
    mutant(
        "a message that comes again later is another one",
        RECEIVE,
        "let Some(distance) = ahead(sequence, self.take) else { return Accepted::Duplicate };",
        "let distance = ahead(sequence, self.take).unwrap_or(0);",
        FUZZ_LINK,
    ),
    mutant(
        "a channel with a fault does not rest",
        SAFETY,
        "plan.safe_state = true;",
        "plan.safe_state = false;",
        FUZZ_MACHINE,
    ),
    mutant(
        "a lost link leaves the light on",
        LINK_LOSS,
        "*lost = report(admission, true);",
        "*lost = true;",
        FUZZ_MACHINE,
    ),
    mutant(
        "the second record of a message is passed over",
        SERVER,
        "self.at += 1;\n                    progress = true;",
        "self.at += 2;\n                    progress = true;",
        FUZZ_MACHINE,
    ),
    mutant(
        "an entry of a path is stored twice",
        "dispatcher/src/plan/path_queue.rs",
        "self.end = self.end.wrapping_add(1);",
        "store.write(self.end.wrapping_add(1), entry);\n        self.end = self.end.wrapping_add(2);",
        FUZZ_MACHINE,
    ),
    mutant(
        "a refusal has no reason",
        "protocol/src/record.rs",
        "self.push_raw(opcode, tag, code as i16, &[refusal.as_bytes()])",
        "self.push_raw(opcode, tag, code as i16, &[])",
        FUZZ_TABLES,
    ),
    // -- watchdog and faults, in the image -----------------------------------------------------
    mutant(
        "the way into a restart leaves the outputs as they are",
        "firmware/src/fault.rs",
        "    board::safe_state();\n    let mut report",
        "    let mut report",
        FAULTS,
    ),
    mutant(
        "the watchdog is fed although the link task stands still",
        "firmware/src/supervision.rs",
        "now.wrapping_sub(TASK_RAN_AT.load(Relaxed)) > TASK_TURN_UNITS",
        "now.wrapping_sub(TASK_RAN_AT.load(Relaxed)) > TASK_TURN_UNITS << 12",
        FAULTS,
    ),
    mutant("nothing guards the stack", MPS2, "guard::below(&mut core.MPU, STACK, 0);", "", FAULTS),
    mutant("the watchdog is not started", MPS2, "    watchdog::start();\n", "", FAULTS),
    mutant(
        "the emulated laser's registers are nobody's",
        "hal/src/mps2_an500/outputs.rs",
        "#[used]\nstatic LASERS",
        "static LASERS",
        FAULTS,
    ),
    // -- faults that were found (docs/safety.md), with what mended them taken out
    // ------------------
    mutant(
        "found: a start in the tick that loses the link forgets its light",
        "servo/src/laser/light_owner.rs",
        "Light::On(who) if link => (who, Holders(0)),",
        "Light::On(who) if link && self.vetoed => (who, Holders(0)),",
        LASER_PATH,
    ),
    mutant(
        "found: a connector that is taken away leaves the light",
        "servo/src/laser/channel.rs",
        "if !*laser && self.energy.mode != PowerMode::Analog {",
        "if !*laser && self.energy.mode != self.energy.mode {",
        GATE,
    ),
    mutant(
        "found: a clear hides a fault that comes with it",
        SAFETY,
        "if self.was_safe && !self.lasts() {",
        "if !self.lasts() {",
        LASER_CLEAR,
    ),
    mutant(
        "found: a smooth stop begins where a piece has ended",
        "servo/src/segment/profile.rs",
        "        self.other = Other::Begins;\n",
        "",
        GUARDS,
    ),
    mutant(
        "found: a ratio of 2^48 wraps",
        "servo/src/segment/follow/entry.rs",
        "if p.unsigned_abs() >> 44 >= m.unsigned_abs() {",
        "if p.unsigned_abs() >> 127 >= m.unsigned_abs() {",
        FOLLOW,
    ),
    mutant(
        "found: a motion after what begins where only the tick knows is refused",
        "dispatcher/src/shadow/crd.rs",
        "if position.iter().any(|at| at.is_nan())",
        "if position.iter().all(|_| false)",
        CRD_AHEAD,
    ),
];
