//! Mutants of what users look at and send to: pictures of signals, programs that go on after a
//! refusal, the Grbl port.
use super::list::{Mutant, mutant};

const VCD: &[&str] = &["-p", "beamtick", "--test", "vcd_names"];
const REMEDY: &[&str] = &["-p", "beamtick", "--test", "refused_starts", "--", "the_remedy"];
const INSTANT: &[&str] = &["-p", "beamtick", "--test", "refused_starts", "--", "calls_after"];
const DWELL: &[&str] = &["-p", "beamtick-grbl", "--test", "stops", "--", "a_last_dwell"];
const SWITCH: &[&str] = &["-p", "beamtick-grbl", "--test", "stops", "--", "off_its_limit_switch"];
const DOOR: &[&str] = &["-p", "beamtick-grbl", "--test", "stops", "--", "a_door_in_a_jog"];
const JOG: &[&str] = &["-p", "beamtick-grbl", "--test", "stops", "--", "comes_with_its_end"];
const NAMED: &[&str] = &["-p", "beamtick-grbl", "--test", "stops", "--", "names_the_switch"];
const OUTPUTS: &[&str] = &["-p", "beamtick-grbl", "--test", "protocol", "--", "outputs_alone"];

const PROGRAM_END: &str = "dispatcher/src/program/end.rs";
const FEEDER: &str = "host/grbl/src/feeder.rs";

/// Those of one crate together.
pub const FRONT_ENDS: &[Mutant] = &[
    mutant(
        "found: another name of a position is shown as steps",
        "servo/src/trace.rs",
        "if by.0 != 0 && self.every != 0 && self.chosen.axes.has(axis) {",
        "if by.0 != by.0 {",
        VCD,
    ),
    mutant(
        "found: a start that the tick refuses refuses what follows it",
        PROGRAM_END,
        "let settled = self.is_settled(view, refused.reason) && !poll.admission.admitted.may_not_start(view);",
        "let settled = self.is_settled(view, refused.reason);",
        REMEDY,
    ),
    mutant(
        "found: a start without entries delays its instant",
        PROGRAM_END,
        "Cure::State if !matches!(refused.reason, Reason::CrdEmpty | Reason::LaserMapInUse)",
        "Cure::State if !matches!(refused.reason, Reason::LaserMapInUse)",
        INSTANT,
    ),
    mutant(
        "found: a hold in a last dwell ends it",
        FEEDER,
        "self.view.goes_on = info.path_stop == path_stop::STOPPED;",
        "self.view.goes_on = info.path_stop == path_stop::STOPPED && !self.sent.is_empty();",
        DWELL,
    ),
    mutant(
        "found: outputs at standstill take the light of what follows",
        FEEDER,
        "            entries.push(self.on());\n            self.light.on = false;\n        }",
        "            entries.push(self.on());\n        }\n        self.light.on = false;",
        OUTPUTS,
    ),
    mutant(
        "found: an axis on its limit switch cannot move off it",
        FEEDER,
        "(self.known_limits, self.dark) = ([status::LIMITS; 3], 0);",
        "self.dark = 0;",
        SWITCH,
    ),
    mutant(
        "found: a door in a jog is lost",
        "host/grbl/src/session.rs",
        "self.held = self.door;",
        "self.held = false;",
        DOOR,
    ),
    mutant(
        "found: a jog that comes with its end is run",
        "host/grbl/src/session/jogs.rs",
        "let waited = self.drop_jogs();",
        "let waited = false;",
        JOG,
    ),
    mutant(
        "found: an alarm at an axis that stands names no switch",
        FEEDER,
        "stop_reason(cause(faults, item.reason.get()))",
        "stop_reason(item.reason.get())",
        NAMED,
    ),
];
