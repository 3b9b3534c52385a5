//! Mutants of hand-overs between motions, axes and paths: the faults that random programs found.
use super::list::Mutant;

const MOVED: &[&str] = &["-p", "beamtick-host-tests", "--test", "reference", "--", "an_arc_of_an_axis_that_another"];
const SPEEDS: &[&str] = &["-p", "beamtick-host-tests", "--test", "reference", "--", "a_speed_of_another_path"];
const GAPS: &[&str] = &["-p", "beamtick-host-tests", "--test", "reference", "--", "delays_and_waits_follow"];
const SWITCH: &[&str] = &["-p", "beamtick-host-tests", "--test", "reference", "--", "a_switch_after_a_delay"];
const REST: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "a_delay_that_ends_while_its_master"];
const TICKS: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "delays_that_end_with_a_tick"];
const STOPPED: &[&str] = &["-p", "beamtick", "--test", "refused_starts", "--", "a_switch_after_a_stop"];
const CLEARED: &[&str] =
    &["-p", "beamtick-dispatcher", "--test", "all", "--", "data_after_a_start_of_what_was_cleared"];
const DRIFT: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "delays_in_a_loop_do_not_drift"];

/// In the order of the list of programs in docs/evidence.md.
pub const STATES: &[Mutant] = &[
    Mutant {
        name: "switch: after a delay and a segment of its tick it begins at the ratio 0",
        file: "servo/src/segment/follow/evaluator.rs",
        text: "if self.held && self.comes_after_segment(index, context) {",
        broken: "if false && self.comes_after_segment(index, context) {",
        test: SWITCH,
    },
    Mutant {
        name: "arc: an axis is where it was before another path moved it",
        file: "dispatcher/src/admit/context.rs",
        text: "if Crd::all().any(may) { None }",
        broken: "if false && Crd::all().any(may) { None }",
        test: MOVED,
    },
    Mutant {
        name: "follow: a speed of a path before this one is 0 for a tick",
        file: "servo/src/tick/crd/drive.rs",
        text: "if now != wants {",
        broken: "if false && now != wants {",
        test: SPEEDS,
    },
    Mutant {
        name: "slave: a master that brakes within the tick is at its end where it begins to",
        file: "servo/src/segment/follow/master_path.rs",
        text: "left == entered || rests && before.ends_at(piece.start);",
        broken: "left == entered || rests;",
        test: REST,
    },
    Mutant {
        name: "slave: a delay after a delay begins a hair late",
        file: "servo/src/segment/follow/master_path.rs",
        text: "        if self.to.pos == self.from.pos || left(begin) < REMAINDER {\n            return begin;\n        }\n",
        broken: "",
        test: GAPS,
    },
    Mutant {
        name: "slave: after a delay a straight master goes on from a rounded position",
        file: "servo/src/segment/follow/master_path.rs",
        text: "        self.from = TimedPosition { after, pos: at.round().clamp(low, high) };\n",
        broken: "        self.from = TimedPosition { after, pos: at.round().clamp(low, high) };\n        self.line = self.from;\n",
        test: TICKS,
    },
    Mutant {
        name: "slave: a switch at the instant of a Stop is taken",
        file: "servo/src/axis/slave.rs",
        text: "follower.braking.is_some() || table",
        broken: "table",
        test: STOPPED,
    },
    Mutant {
        name: "follow: data after a start of a FIFO that was cleared waits for the start",
        file: "dispatcher/src/shadow.rs",
        text: "shadow.follow.empty(fifo, seq);\n                shadow.dropped_start = shadow.busy;",
        broken: "shadow.follow.empty(fifo, seq);\n                shadow.dropped_start = Some(seq.wrapping_add(1));",
        test: CLEARED,
    },
    Mutant {
        name: "slave: a delay in a loop counts from a rounded position",
        file: "servo/src/segment/follow/evaluator.rs",
        text: ">> REMAINDER_DOWN) as i32;",
        broken: ">> REMAINDER_DOWN) as i32 & 0;",
        test: DRIFT,
    },
    Mutant {
        name: "slave: the pieces of its master begin at rounded positions",
        file: "servo/src/segment/piece.rs",
        text: "fast.start_remainder = start_remainder;",
        broken: "fast.start_remainder = start_remainder & 0;",
        test: DRIFT,
    },
];
