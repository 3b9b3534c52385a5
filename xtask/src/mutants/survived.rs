//! Mutants that were found because the tests nearest to them passed, and their kin: each has its
//! test now (docs/mutants.md).
use super::list::{Mutant, mutant};

const CAUSES: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "laser_causes::"];
const CRD_GUARDS: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "crd_guards::"];
const GUARDS: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "tick_guards::"];
const PVT: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "pvt_run::passes_end"];
const STALE: &[&str] =
    &["-p", "beamtick-protocol", "--test", "endpoint", "--", "frames_of_another_session", "a_message_after_the_window"];
const LIFE: &[&str] = &[
    "-p",
    "beamtick-protocol",
    "--test",
    "endpoint",
    "--",
    "damaged_frames",
    "a_client_takes_up",
    "a_message_is_kept",
];
const SESSIONS: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "sessions::"];
const LIMITS: &[&str] = &["-p", "beamtick-dispatcher", "--test", "all", "--", "refusals::inputs::limits_are_switched"];

const DRIVE: &str = "servo/src/tick/crd/drive.rs";
const ORDERS: &str = "servo/src/tick/crd/commands.rs";
const INPUT_SCAN: &str = "servo/src/axis/input_scan.rs";
const AXIS_LIMITS: &str = "servo/src/axis/soft_limits.rs";
const DRIVEN: &str = "servo/src/axis/crd_member.rs";
const MOTION: &str = "servo/src/axis/motion.rs";
const INPUTS: &str = "servo/src/axis/inputs.rs";
const FOLLOWING_ERROR: &str = "servo/src/axis/following_error.rs";
const IN_POSITION: &str = "servo/src/axis/in_position.rs";
const SAFETY: &str = "servo/src/laser/safety.rs";
const RECEIVE: &str = "protocol/src/link/receive.rs";
const SERVER: &str = "dispatcher/src/session/server.rs";
const PROGRAM_END: &str = "dispatcher/src/program/end.rs";
const COMMAND_HANDLER: &str = "dispatcher/src/session/commands.rs";

/// Those of one crate together.
pub const SURVIVED: &[Mutant] = &[
    // -- light that a path is to lose ------------------------------------------------------------
    mutant(
        "an edge of travel is no fault of its path",
        DRIVE,
        "StopReason::Travel | StopReason::OtherAxis => lasers",
        "StopReason::OtherAxis => lasers",
        CAUSES,
    ),
    mutant(
        "another axis is no fault of a path",
        DRIVE,
        "StopReason::Travel | StopReason::OtherAxis => lasers",
        "StopReason::Travel => lasers",
        CAUSES,
    ),
    mutant(
        "found: what an axis cannot do is reported as a limit",
        DRIVE,
        "            self.lasers.crd_fault(crd, Cause::Fault);\n            self.stop_crds",
        "            self.stop_crds",
        CAUSES,
    ),
    mutant(
        "a limit of a path waits for the coming tick",
        DRIVE,
        "            | StopReason::SoftNegative => lasers.crd_fault(crd, Cause::Limit),",
        "            | StopReason::SoftNegative => {}",
        CAUSES,
    ),
    mutant("an axis that goes along is not looked at", DRIVE, "if others().any(", "if false && others().any(", CAUSES),
    mutant("plans keep their grace for another cause", SAFETY, "        self.grace = 0;\n", "", CAUSES),
    mutant("three plans have grace", SAFETY, "self.grace = 2;", "self.grace = 3;", CAUSES),
    mutant(
        "a limit is reported before an alarm",
        ORDERS,
        "        _ if fresh & status::ALARM != 0 => Some(Cause::Alarm),\n        _ if fresh & status::LIMITS != 0 => Some(Cause::Limit),",
        "        _ if fresh & status::LIMITS != 0 => Some(Cause::Limit),\n        _ if fresh & status::ALARM != 0 => Some(Cause::Alarm),",
        CAUSES,
    ),
    mutant(
        "an axis that has left still shuts off light",
        ORDERS,
        ".filter(|axis| axis.is_mapped(crd)) else { continue };",
        ".filter(|axis| axis.is_mapped(crd) || axis.crd.is_none() || !axis.runs()) else { continue };",
        CAUSES,
    ),
    mutant(
        "a servo that is off is switched off",
        ORDERS,
        "axis.crd.filter(|crd| axis.servo_on && axis.is_mapped(*crd))",
        "axis.crd.filter(|crd| axis.is_mapped(*crd))",
        CAUSES,
    ),
    mutant(
        "what was before an axis was mapped counts",
        DRIVEN,
        "(self.crd, self.causes.fresh) = (Some(crd), 0);",
        "self.crd = Some(crd);",
        CAUSES,
    ),
    // -- what a path must not begin, pass or take along ------------------------------------------
    mutant(
        "a frame is set while its path runs",
        ORDERS,
        "if !known || self.crds.running.has(crd) || moving(axes) {",
        "if !known || moving(axes) {",
        CRD_GUARDS,
    ),
    mutant(
        "a frame takes axes that move",
        ORDERS,
        "if !known || self.crds.running.has(crd) || moving(axes) {",
        "if !known || self.crds.running.has(crd) {",
        CRD_GUARDS,
    ),
    mutant(
        "a path goes on without what went along",
        ORDERS,
        "if axis_state.refuses_gear() {",
        "if axis_state.refuses_gear() && axis_state.runs() {",
        CRD_GUARDS,
    ),
    mutant("a path begins anywhere", ORDERS, "if far || paths.refuses_start", "if paths.refuses_start", CRD_GUARDS),
    mutant(
        "a path brakes for the last order",
        ORDERS,
        "if halt == Halt::Smooth && path.stops() {",
        "if halt == Halt::Smooth && path.stops() && reason != StopReason::StopSmooth {",
        CRD_GUARDS,
    ),
    mutant(
        "a path waits for who has come",
        DRIVE,
        "awaited.filter(|(_, until)| state.path.waits_until() == Some(*until));",
        "awaited;",
        CRD_GUARDS,
    ),
    mutant(
        "the free range of a motion is that of the one before",
        DRIVE,
        "            self.clearance = [next, Clearance::Unknown];\n",
        "            let _ = next;\n",
        CRD_GUARDS,
    ),
    mutant(
        "the free range of a motion stays over what is done at its end",
        DRIVE,
        "        state.clearance = [Clearance::Unknown; 2];\n        published.version",
        "        published.version",
        CRD_GUARDS,
    ),
    mutant(
        "an axis of another path goes along",
        DRIVEN,
        "self.refuses_start() || self.published.mode == MotionMode::Crd",
        "self.refuses_start()",
        CRD_GUARDS,
    ),
    mutant(
        "an axis that goes along is sent away",
        DRIVEN,
        "            || self.state == MotionState::Driven && !geared\n",
        "",
        CRD_GUARDS,
    ),
    mutant(
        "an axis that goes along takes an Update",
        MOTION,
        "            || self.state == MotionState::Driven\n",
        "",
        CRD_GUARDS,
    ),
    // -- what guards an axis ---------------------------------------------------------------------
    mutant(
        "a soft limit that an axis has passed pulls it back",
        AXIS_LIMITS,
        "return Some((from.max(soft), StopReason::SoftPositive));",
        "return Some((soft, StopReason::SoftPositive));",
        GUARDS,
    ),
    mutant(
        "the same, downwards",
        AXIS_LIMITS,
        "return Some((from.min(soft), StopReason::SoftNegative));",
        "return Some((soft, StopReason::SoftNegative));",
        GUARDS,
    ),
    mutant(
        "a soft limit is no barrier between two ticks",
        MOTION,
        "if let Some(reason) = self.stopped_at_barrier(next, at.round()) {",
        "if false && let Some(reason) = self.stopped_at_barrier(next, at.round()) {",
        GUARDS,
    ),
    mutant(
        "at rest beyond a soft limit is nothing",
        INPUT_SCAN,
        "            causes |= self.inputs.beyond(self.published.pos);\n",
        "",
        GUARDS,
    ),
    mutant(
        "at rest below a soft limit is nothing",
        AXIS_LIMITS,
        "|limit| pos < Pos::pulses(limit))",
        "|limit| pos < Pos::pulses(limit) && limit == 0)",
        GUARDS,
    ),
    mutant(
        "a cleared fault that lasts lets go for a tick",
        INPUT_SCAN,
        "self.block(self.causes.present & status::FAULTS);",
        "self.block(0);",
        GUARDS,
    ),
    mutant(
        "an encoder that turns while the servo is off is an error",
        INPUT_SCAN,
        "        if self.servo_on {\n",
        "        if true {\n",
        GUARDS,
    ),
    mutant(
        "an error that is the limit is beyond it",
        FOLLOWING_ERROR,
        "Some(limit) if error(pos, encoder) > (limit",
        "Some(limit) if error(pos, encoder) >= (limit",
        GUARDS,
    ),
    mutant(
        "home ignores its sense",
        INPUTS,
        "let home = (levels ^ self.low) & Guarded::Home.bit() != 0;",
        "let home = levels & Guarded::Home.bit() != 0;",
        GUARDS,
    ),
    mutant(
        "home captures again and again",
        INPUTS,
        "            self.capture = 0;\n            return",
        "            return",
        GUARDS,
    ),
    mutant(
        "an error does not end the time in the band",
        IN_POSITION,
        "            self.inside = None;\n            return (false, false);",
        "            return (false, false);",
        GUARDS,
    ),
    mutant(
        "a motion does not end the time in the band",
        IN_POSITION,
        "pub(crate) fn leave_position(&mut self) {\n        self.inside = None;",
        "pub(crate) fn leave_position(&mut self) {",
        GUARDS,
    ),
    mutant(
        "a new band goes on with the time of the old one",
        IN_POSITION,
        "(self.band, self.band_time, self.inside) = (band, time, None);",
        "(self.band, self.band_time) = (band, time);",
        GUARDS,
    ),
    mutant(
        "a Reset leaves servos on",
        "servo/src/tick/workload.rs",
        "            self.enable &= !axes.0;\n            self.halt",
        "            self.halt",
        GUARDS,
    ),
    mutant(
        "PVT: passes are counted past the loop",
        "servo/src/segment/pvt.rs",
        "track.passes = track.passes.saturating_add(left);",
        "track.passes = track.passes.saturating_add(many);",
        PVT,
    ),
    // -- link and session ------------------------------------------------------------------------
    mutant(
        "frames of another session keep the link alive",
        RECEIVE,
        "            _ => return count(&mut self.counters.stale_session),",
        "            _ => {\n                self.last_valid = Some(now);\n                return count(&mut self.counters.stale_session);\n            }",
        STALE,
    ),
    mutant(
        "the window is one too wide",
        RECEIVE,
        "if usize::from(distance) >= WINDOW {",
        "if usize::from(distance) > WINDOW {",
        STALE,
    ),
    mutant(
        "the record counter of an old session is kept",
        SERVER,
        "(self.at, self.outbox_len, self.begins) = (0, 0, true);",
        "(self.outbox_len, self.begins) = (0, true);",
        SESSIONS,
    ),
    mutant(
        "answers that were gathered are sent in the next session",
        SERVER,
        "(self.at, self.outbox_len, self.begins) = (0, 0, true);",
        "(self.at, self.begins) = (0, true);",
        SESSIONS,
    ),
    mutant(
        "answers that are awaited are sent in the next session",
        COMMAND_HANDLER,
        "        self.replies.abandon();\n        self.admission.loading",
        "        self.admission.loading",
        SESSIONS,
    ),
    mutant(
        "numbers of answers that are given up are reported in the next session",
        "dispatcher/src/report/pending_replies.rs",
        "        self.items.clear();\n        self.values.clear();",
        "        self.items.clear();",
        SESSIONS,
    ),
    mutant(
        "a configuration goes on in the next session",
        COMMAND_HANDLER,
        "        self.config = None;\n        self.joined = PathManyProgress::default();",
        "        self.joined = PathManyProgress::default();",
        SESSIONS,
    ),
    mutant(
        "both limits are the positive one",
        "dispatcher/src/admit/axis.rs",
        "_ => positive.and(Guarded::LimitNegative, on),",
        "_ => positive,",
        LIMITS,
    ),
    mutant(
        "a damaged frame keeps the link alive",
        RECEIVE,
        "            Err(fault) => {\n                return",
        "            Err(fault) => {\n                self.last_valid = Some(now);\n                return",
        LIFE,
    ),
    mutant(
        "a Hello keeps the link alive",
        RECEIVE,
        "                    self.answer_hello(&header, hello);\n                }\n            }",
        "                    self.answer_hello(&header, hello);\n                    self.last_valid = Some(now);\n                }\n            }",
        LIFE,
    ),
    mutant(
        "an answer to another Hello is taken up",
        RECEIVE,
        "|| self.phase != SessionPhase::Asking || !ours {",
        "|| self.phase != SessionPhase::Asking || !ours && header.session.get() == 0 {",
        LIFE,
    ),
    mutant(
        "no session is taken up as one",
        RECEIVE,
        "        if session == 0 {\n            return",
        "        if session == 0 && self.nonce == 0 {\n            return",
        LIFE,
    ),
    mutant(
        "what comes again under a number replaces it",
        RECEIVE,
        "        if slot.full {\n",
        "        if slot.full && sequence == u16::MAX {\n",
        LIFE,
    ),
    mutant(
        "a message is taken that has not come",
        RECEIVE,
        "    pub(super) fn done(&mut self) {\n        if self.take == self.next {\n            return;\n        }\n",
        "    pub(super) fn done(&mut self) {\n",
        LIFE,
    ),
    mutant(
        "nobody is woken when the link is lost",
        SERVER,
        ".filter(|_| !self.lost && link_loss_ms != 0)",
        ".filter(|_| self.lost && link_loss_ms != 0)",
        SESSIONS,
    ),
    mutant(
        "answers of an old program are sent in the next session",
        PROGRAM_END,
        "        self.records.clear();\n        self.replies.abandon();",
        "        self.records.clear();",
        SESSIONS,
    ),
    mutant(
        "records of an old program wait in the next session",
        PROGRAM_END,
        "        self.records.clear();\n        self.replies.abandon();",
        "        self.replies.abandon();",
        SESSIONS,
    ),
];
