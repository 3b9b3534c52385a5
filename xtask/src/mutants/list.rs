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
const ENDPOINT: &[&str] =
    &["-p", "beamtick-protocol", "--test", "endpoint", "--", "an_acknowledgement_of", "a_lost_message", "a_frame_with"];
const DELIVERIES: &[&str] = &["-p", "beamtick-protocol", "--lib", "--", "every_delivery"];
const PROPERTIES: &[&str] = &["-p", "beamtick-protocol", "--test", "properties", "--", "frames_of_every_length"];
const LINK: &[&str] = &["-p", "beamtick-host-tests", "--test", "link", "--", "a_restart_in_mid_stream", "every_seed"];
const RING: &[&str] = &["-p", "beamtick-ring", "--lib"];
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

const H743_FIRST_TICK: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "the_first_tick"];
const H743_STUCK: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "a_link_task_that_stands_still"];
const H743_PANIC: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "a_panic_rests"];
const H743_STACK: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "a_stack_that_is_full"];
const H743_BREAKS: &[&str] = &["-p", "beamtick-h743", "--test", "facts", "--", "break"];
const H743_VOLTAGES: &[&str] = &["-p", "beamtick-h743", "--test", "inputs", "--", "voltages"];
const H743_ENCODERS: &[&str] = &["-p", "beamtick-h743", "--test", "inputs", "--", "edges_of_encoders"];
const H743_PT: &[&str] = &["-p", "beamtick-h743", "--test", "jobs", "--", "a_listing_of_pt"];
const H743_LASERS: &[&str] = &["-p", "beamtick-h743", "--test", "jobs", "--", "listings_of_lasers"];

const SAFETY: &str = "servo/src/laser/safety.rs";
const EDGES: &str = "servo/src/laser/edge_queue.rs";
const TICK: &str = "servo/src/tick.rs";
const RECEIVE: &str = "protocol/src/link/receive.rs";
const TRANSMIT: &str = "protocol/src/link/transmit.rs";
const QUEUE: &str = "ring/src/queue.rs";
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

/// Every mutant, those of one crate together: it is built once more for each of them.
pub const LIST: &[Mutant] = &[
    // -- ring ----------------------------------------------------------------------------------
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
    // -- link ----------------------------------------------------------------------------------
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
        ENDPOINT,
    ),
    mutant(
        "a full block is followed by a zero",
        "protocol/src/deframe.rs",
        "let full = code == 0xFF;",
        "let full = code == 0x00;",
        PROPERTIES,
    ),
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
        "settled = (settled || step.settled) && sure && end_sure || cap == 0.0;",
        "settled = settled || step.settled || after >= 0.0;",
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
    // -- link, both ends -----------------------------------------------------------------------
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
    // -- every delivery of the first frames of the link ---------------------------------------
    mutant(
        "deliveries: a frame of any session is taken",
        RECEIVE,
        "let known = self.session != 0 && session == self.session;",
        "let known = self.session != 0;",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a message that comes late is another one",
        RECEIVE,
        "let Some(distance) = ahead(sequence, self.take) else { return Accepted::Duplicate };",
        "let distance = ahead(sequence, self.take).unwrap_or(0);",
        DELIVERIES,
    ),
    mutant(
        "deliveries: numbers do not begin anew",
        TRANSMIT,
        "(distance < 0x8000).then_some(distance)",
        "(a >= b).then_some(distance)",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a message that is lost is not sent again",
        TRANSMIT,
        "        self.resend = true;\n        self.recover = Some(self.sent);\n        self.retry =",
        "        self.recover = Some(self.sent);\n        self.retry =",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a KeepAlive is not answered",
        RECEIVE,
        "FrameKind::KeepAlive => self.receiver.ask_acknowledgement(),",
        "FrameKind::KeepAlive => {}",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a new session keeps the messages of the old one",
        "protocol/src/link.rs",
        "        self.transmitter.reset(window);\n        self.receiver.reset();",
        "        self.transmitter.reset(window);",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a client is open before the controller is",
        RECEIVE,
        "        self.phase = SessionPhase::Confirming(1);",
        "        self.phase = SessionPhase::Confirming(1);\n        self.state = LinkState::Open;",
        DELIVERIES,
    ),
    mutant(
        "deliveries: what is missing is acknowledged",
        TRANSMIT,
        "acknowledgement: self.receiver.next().into(),",
        "acknowledgement: self.receiver.next().wrapping_add(u16::from(gap)).into(),",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a client confirms for ever",
        "protocol/src/link.rs",
        "SessionPhase::Confirming(count) if count < 3 =>",
        "SessionPhase::Confirming(count) =>",
        DELIVERIES,
    ),
    mutant(
        "deliveries: an answer to another Hello is taken up",
        RECEIVE,
        "|| self.phase != SessionPhase::Asking || !ours {",
        "|| self.phase != SessionPhase::Asking || !ours && header.session.get() == 0 {",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a checksum is not compared",
        "protocol/src/frame.rs",
        "(checksum(&[body]) == u32::from_le_bytes(*crc)).then_some(body)",
        "(crc.len() == 4).then_some(body)",
        DELIVERIES,
    ),
    mutant(
        "deliveries: the timer of the message after an acknowledged one is not set",
        TRANSMIT,
        "self.retry_at = (self.base != self.sent).then(|| now.saturating_add(self.retry));",
        "self.retry_at = None;",
        DELIVERIES,
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
        "now.wrapping_sub(TASK_RAN_AT.load(Relaxed)) > TURN",
        "now.wrapping_sub(TASK_RAN_AT.load(Relaxed)) > TURN << 12",
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
    // -- the reference board's image, in emulation ---------------------------------------------
    mutant(
        "H743: the tick's timer runs before its interrupt is let in",
        "hal/src/stm32h743/mod.rs",
        "    for interrupt in [Interrupt::TIM2, Interrupt::USART3, Interrupt::OTG_FS] {\n        // SAFETY: the caller's promise.",
        "    timer::start();\n    cortex_m::asm::delay(30_000);\n    for interrupt in [Interrupt::TIM2, Interrupt::USART3, Interrupt::OTG_FS] {\n        \
         // SAFETY: the caller's promise.",
        H743_FIRST_TICK,
    ),
    mutant(
        "H743: the watchdog is fed although the link task stands still",
        "firmware/src/supervision.rs",
        "    if !is_late(now) {",
        "    if !is_late(now) || TICKED.load(Relaxed) == now {",
        H743_STUCK,
    ),
    mutant(
        "H743: a panic leaves the outputs as they are",
        "firmware/src/fault.rs",
        "    board::safe_state();\n    let mut report",
        "    let mut report",
        H743_PANIC,
    ),
    mutant(
        "H743: nothing guards the end of the stack",
        "hal/src/stm32h743/mod.rs",
        "    guard::below(&mut core.MPU, STACK, 1);",
        "",
        H743_STACK,
    ),
    mutant(
        "H743: a break flag is not compared with its pin in ticks",
        "hal/src/stm32h743/laser.rs",
        "            CONTRADICTS.store(1 + 3 * input + text, Relaxed);",
        "",
        H743_BREAKS,
    ),
    mutant(
        "H743: a break of the chip is taken for one of a pin",
        "hal/src/stm32h743/laser.rs",
        "let of_chip = flags == 0b111 || clocks::supply_is_low();",
        "let of_chip = false;",
        &["-p", "beamtick-h743", "--test", "facts", "--", "a_supply"],
    ),
    mutant(
        "H743: a low supply at the start is blamed on the wiring",
        "hal/src/stm32h743/laser.rs",
        "found.filter(|_| !clocks::supply_is_low())",
        "found",
        &["-p", "beamtick-h743", "--test", "facts", "--", "a_supply"],
    ),
    mutant(
        "H743: the interlock's inputs are not compared with each other",
        "hal/src/stm32h743/laser.rs",
        "self.apart >= MAX_TICKS_APART",
        "self.apart == 0 && levels == MAX_TICKS_APART",
        &["-p", "beamtick-h743", "--test", "facts", "--", "an_input"],
    ),
    mutant(
        "H743: a start of light undoes a break that is over",
        "hal/src/stm32h743/laser.rs",
        "let is_dark = || timers.into_iter().any(is_broken);",
        "let is_dark = || false;",
        &["-p", "beamtick-h743", "--test", "restarts", "--", "a_loop"],
    ),
    mutant(
        "H743: outputs are enabled before breaks are read",
        "hal/src/stm32h743/laser.rs",
        "    if is_dark() {\n        return false;\n    }\n    timers",
        "    timers",
        &["-p", "beamtick-h743", "--test", "restarts", "--", "a_loop"],
    ),
    mutant(
        "H743: a reset of the timers drops a break",
        "hal/src/stm32h743/laser.rs",
        "        if was_broken {",
        "        if was_broken && false {",
        H743_BREAKS,
    ),
    mutant(
        "H743: a fault within a frame of an external DAC leaves its voltage",
        "hal/src/stm32h743/analog.rs",
        "    spi::restart();\n    for channel",
        "    for channel",
        &["-p", "beamtick-h743", "--test", "external_dac", "--", "a_fault"],
    ),
    mutant(
        "H743: a late byte shifts the frames of an external DAC",
        "hal/src/stm32h743/analog.rs",
        "                    spi::restart();\n",
        "",
        &["-p", "beamtick-h743", "--test", "external_dac", "--", "a_frame"],
    ),
    mutant(
        "H743: an external DAC keeps its voltage until the clock comes",
        "hal/src/stm32h743/mod.rs",
        "        unsafe { analog::zero_external() };\n        clocks::await_source();",
        "        clocks::await_source();\n        unsafe { analog::zero_external() };",
        &["-p", "beamtick-h743", "--test", "external_dac", "--", "a_reset"],
    ),
    mutant(
        "H743: any revision of the chip is a good one",
        "hal/src/stm32h743/clocks.rs",
        "    code.dev_id() == DEVICE && REVISIONS.contains(&code.rev_id())",
        "    code.dev_id() == DEVICE",
        &["-p", "beamtick-h743", "--test", "facts", "--", "other_chips"],
    ),
    mutant(
        "H743: the switch of USB's 5 V floats",
        "hal/src/stm32h743/boards/nucleo_h743zi2/mod.rs",
        "    driven_low: &[(GPIOD, 10)],",
        "    driven_low: &[],",
        &["-p", "beamtick-h743", "--test", "image", "--", "start_up"],
    ),
    mutant(
        "H743: analog inputs are exchanged",
        "hal/src/stm32h743/adc.rs",
        "const CHANNELS: [usize; INPUTS] = [1, 0];",
        "const CHANNELS: [usize; INPUTS] = [0, 1];",
        H743_VOLTAGES,
    ),
    mutant(
        "H743: encoders count backwards",
        "hal/src/stm32h743/encoders.rs",
        "*count = count.wrapping_add(distance(now, *last));",
        "*count = count.wrapping_sub(distance(now, *last));",
        H743_ENCODERS,
    ),
    mutant(
        "H743: voltages are half of what they shall be",
        "hal/src/stm32h743/analog.rs",
        "w.set_dhr((code as u16 ^ 0x8000) >> 4)",
        "w.set_dhr(((code >> 1) as u16 ^ 0x8000) >> 4)",
        H743_LASERS,
    ),
    mutant(
        "H743: the tick needs 8000 bytes more of the stack",
        "firmware/src/interrupts.rs",
        "    supervision::tick_begins();",
        "    supervision::tick_begins();\n    core::hint::black_box([0u8; 8000]);",
        H743_PT,
    ),
];
