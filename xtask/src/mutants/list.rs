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
    /// Arguments of the `cargo test` that must fail; names of tests behind `--`.
    pub test: &'static [&'static str],
}

const GATE: &[&str] = &["-p", "beamtick-servo", "--test", "laser_gate"];
const LASER: &[&str] = &["-p", "beamtick-dispatcher", "--test", "laser"];
const LASER_STATE: &[&str] = &["-p", "beamtick-dispatcher", "--test", "laser_state"];
const ENDPOINT: &[&str] = &["-p", "beamtick-protocol", "--test", "endpoint"];
const PROPERTIES: &[&str] = &["-p", "beamtick-protocol", "--test", "properties"];
const LINK: &[&str] = &["-p", "beamtick-host-tests", "--test", "link"];
const RING: &[&str] = &["-p", "beamtick-ring", "--lib"];
const PT: &[&str] = &["-p", "beamtick-servo", "--test", "pt_exact"];
const TICK_PT: &[&str] = &["-p", "beamtick-servo", "--test", "tick_pt"];
const PVT: &[&str] = &["-p", "beamtick-servo", "--test", "pvt_run"];
const GUARDS: &[&str] = &["-p", "beamtick-servo", "--test", "tick_guards"];
const LOOK_AHEAD: &[&str] = &["-p", "beamtick-dispatcher", "--test", "lookahead"];
const PROGRAM_ENDS: &[&str] = &["-p", "beamtick-dispatcher", "--test", "program_ends"];

const SAFETY: &str = "servo/src/laser/safety.rs";
const EDGES: &str = "servo/src/laser/gate.rs";
const TICK: &str = "servo/src/tick.rs";
const RECEIVE: &str = "protocol/src/link/receive.rs";
const TRANSMIT: &str = "protocol/src/link/transmit.rs";
const QUEUE: &str = "ring/src/queue.rs";
const PT_RUN: &str = "servo/src/pt/run.rs";
const AHEAD: &str = "dispatcher/src/lookahead.rs";
const AXIS_GUARD: &str = "servo/src/axis/guard.rs";
const SERVER: &str = "dispatcher/src/server.rs";

const fn mutant(
    name: &'static str,
    file: &'static str,
    text: &'static str,
    broken: &'static str,
    test: &'static [&'static str],
) -> Mutant {
    Mutant { name, file, text, broken, test }
}

/// Every mutant.
pub const LIST: &[Mutant] = &[
    // -- safety ---------------------------------------------------------------------------------
    mutant("a dark channel's plan does not rest", SAFETY, "plan.rest = true;", "plan.rest = false;", GATE),
    mutant("a dark channel's plan keeps its actions", SAFETY, "            plan.clear();\n", "", GATE),
    mutant(
        "a clear does not ask whether the cause lasts",
        SAFETY,
        "if self.rested && !self.lasts() {",
        "if self.rested {",
        GATE,
    ),
    mutant(
        "a clear hides a cause of its own tick",
        SAFETY,
        "if self.rested && !self.lasts() {",
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
        "a lost link does not last",
        SAFETY,
        "self.interlock || self.link_lost || self.alarm",
        "self.interlock || self.alarm",
        LASER_STATE,
    ),
    mutant(
        "the last cause is told, not the first",
        SAFETY,
        "if !self.is_dark() {\n            (self.dark",
        "if true {\n            (self.dark",
        GATE,
    ),
    mutant("an overrun puts out no light", TICK, "self.lasers.trip(Cause::Overrun);", "", GATE),
    mutant("a restart leaves lasers live", TICK, "self.lasers.trip(Cause::Restart);", "", LASER),
    mutant(
        "a silent link is not lost",
        SERVER,
        "let silent = limit != 0 && now.0.saturating_sub(heard) > limit;",
        "let silent = limit == 1 && now.0.saturating_sub(heard) > limit;",
        LASER_STATE,
    ),
    mutant(
        "a lost link leaves the program running",
        SERVER,
        "            program.stop(desk);\n            desk.stop_for_link_loss(view);",
        "            desk.stop_for_link_loss(view);",
        PROGRAM_ENDS,
    ),
    mutant(
        "a latched fault does not refuse a start",
        AXIS_GUARD,
        "!self.servo_on || self.shown.blocked != 0",
        "!self.servo_on",
        GUARDS,
    ),
    mutant("the edge of travel is no barrier", AXIS_GUARD, "if to > Pos::TRAVEL {", "if to > Pos(i64::MAX) {", GUARDS),
    mutant("a soft limit is no barrier", AXIS_GUARD, "&& to > soft", "&& to > Pos::TRAVEL", GUARDS),
    // -- gate -----------------------------------------------------------------------------------
    mutant(
        "an edge at the instant of a command stays",
        EDGES,
        "is_some_and(|last| *last >= at)",
        "is_some_and(|last| *last > at)",
        GATE,
    ),
    mutant("an on command takes the place of its off", EDGES, "self.len < EDGES - 1", "self.len < EDGES", GATE),
    // -- link -----------------------------------------------------------------------------------
    mutant(
        "a message that comes twice is taken twice",
        RECEIVE,
        "let Some(distance) = ahead(sequence, self.take) else { return Accepted::Duplicate };",
        "let distance = ahead(sequence, self.take).unwrap_or(0);",
        LINK,
    ),
    mutant(
        "a message of any session is taken",
        RECEIVE,
        "let known = self.session != 0 && session == self.session;",
        "let known = self.session != 0;",
        LINK,
    ),
    mutant(
        "an acknowledgement of what was never sent is taken",
        TRANSMIT,
        "if step > outstanding {",
        "if step > u16::MAX - 1 {",
        ENDPOINT,
    ),
    mutant(
        "a message that is lost is not sent again",
        TRANSMIT,
        "        self.resend = true;\n        self.recover = Some(self.sent);\n        self.retry =",
        "        self.recover = Some(self.sent);\n        self.retry =",
        ENDPOINT,
    ),
    mutant(
        "a checksum is not compared",
        "protocol/src/frame.rs",
        "(checksum(&[body]) == u32::from_le_bytes(*crc)).then_some(body)",
        "(crc.len() == 4).then_some(body)",
        PROPERTIES,
    ),
    mutant(
        "a full block is followed by a zero",
        "protocol/src/deframe.rs",
        "let full = code == 0xFF;",
        "let full = code == 0x00;",
        PROPERTIES,
    ),
    // -- ring -----------------------------------------------------------------------------------
    mutant(
        "a full ring takes one more",
        QUEUE,
        "if self.pushed.wrapping_sub(popped) >= N as u32 {",
        "if self.pushed.wrapping_sub(popped) > N as u32 {",
        RING,
    ),
    mutant(
        "a cleared ring is not empty",
        QUEUE,
        "self.free_to(self.ring.pushed.load(Ordering::Relaxed));",
        "self.free_to(self.popped);",
        RING,
    ),
    mutant(
        "a reader does not take the newest",
        "ring/src/latest.rs",
        "        if self.is_new() {",
        "        if !self.is_new() {",
        RING,
    ),
    // -- evaluators -----------------------------------------------------------------------------
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
        "let at_rest = velocity.unsigned_abs() << 1 <= *rounded as u128;",
        "let at_rest = velocity.unsigned_abs() <= u128::MAX - *rounded as u128;",
        TICK_PT,
    ),
    mutant("PT: a loop runs once more", PT_RUN, "pass.passes >= feed.passes", "pass.passes > feed.passes", PT),
    mutant(
        "PVT: the next segment is looked for one too far",
        "servo/src/pvt.rs",
        "knot.next = segment.wrapping_add(1);",
        "knot.next = segment.wrapping_add(2);",
        PVT,
    ),
    // -- look-ahead -----------------------------------------------------------------------------
    mutant(
        "look-ahead: a corner is taken at any speed",
        AHEAD,
        "motion.cap = motion.cap.min(jump * jump).min(curve);",
        "motion.cap = motion.cap.min(curve);",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: speeds are final at once",
        AHEAD,
        "settled |= high >= motion.cap;",
        "settled |= high >= 0.0;",
        LOOK_AHEAD,
    ),
    mutant(
        "look-ahead: an axis's speed is not limited",
        AHEAD,
        "vel = vel.min(most[i] / share);",
        "vel = vel.min(vel / share);",
        LOOK_AHEAD,
    ),
];
