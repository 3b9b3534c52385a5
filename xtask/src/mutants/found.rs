//! The faults that programs from outside found where states meet, one edit each that undoes its
//! mend, and which random programs must find it.
use super::planted::{By, Planted};

/// Listed by the findings' numbers.
pub const FOUND: &[Planted] = &[
    Planted {
        name: "found 1: a slave of a renamed slave jumps",
        by: By::Reference,
        places: &[(
            "servo/src/segment/follow/follower.rs",
            "MasterPath::of(now, along, shift)",
            "MasterPath::of(now, along, shift & 0)",
        )],
    },
    Planted {
        name: "found 2: a slave of a master that is planned again while it brakes jumps",
        by: By::Reference,
        places: &[(
            "servo/src/segment/follow/master_path.rs",
            "let (t, part) = if t > last { (last, u32::MAX) } else { (t, at as u32) };",
            "if t >= piece.span {\n        return Piece::END;\n    }\n    let (t, part) = (t.min(last), at as u32);",
        )],
    },
    Planted {
        name: "found 3: a message of a table has 42 points at most",
        by: By::Doors,
        places: &[(
            "dispatcher/src/admit/pvt_table.rs",
            "if self.points.is_empty() {",
            "if self.points.is_empty() || self.points.len() / width > 42 {",
        )],
    },
    Planted {
        name: "found 4: GetDac tells what SetDac set, not what BufDA did",
        by: By::Doors,
        places: &[(
            "servo/src/tick.rs",
            "                tables.set_analog(channel, value);\n                trace.record_analog",
            "                let _ = tables;\n                trace.record_analog",
        )],
    },
    Planted {
        name: "found 5: a trace keeps the times of its first tick period",
        by: By::Doors,
        places: &[(
            "servo/src/trace.rs",
            "        if self.every != 0 {\n            self.put(Sample { row: self.tick, of: Traced::Period",
            "        if self.every == 0 {\n            self.put(Sample { row: self.tick, of: Traced::Period",
        )],
    },
    Planted {
        name: "found 8: a minimum outside its range is the nearest bound",
        by: By::Doors,
        places: &[(
            "dispatcher/src/admit/laser/power_range.rs",
            "Ok(if taken == got { taken } else { range.low })",
            "Ok(if taken == got { taken } else { taken.max(range.low) })",
        )],
    },
    Planted {
        name: "found 8: SetWaitPulseEx pulses beside an analog channel",
        by: By::Doors,
        places: &[(
            "dispatcher/src/admit/laser/energy.rs",
            "let output = pulses.filter(|_| !paired || are_pwm(self, None));",
            "let output = pulses.filter(|_| !paired || are_pwm(self, None) || paired);",
        )],
    },
    Planted {
        name: "found 8: neighbouring pulses of a rate merge",
        by: By::Lasers,
        places: &[(
            "servo/src/output/pwm_cycles.rs",
            "if self.pulse_end > at && self.pulse_end >= next {",
            "if self.pulse_end > at && self.pulse_end >= next && self.pulse_end == 0 {",
        )],
    },
    Planted {
        name: "found 8: a change of the rate begins with a pulse",
        by: By::Lasers,
        places: &[(
            "servo/src/laser/channel/interval.rs",
            "Action::Rate(Clock::rate(before, self.power,",
            "let _ = before;\n        Action::Rate(Clock::rate(crate::laser::Power::ZERO, self.power,",
        )],
    },
    Planted {
        name: "found 8: light of full duty outlasts the gate",
        by: By::Lasers,
        places: &[(
            "servo/src/laser/channel/interval.rs",
            "let is_level = self.energy.mode == PowerMode::DutyOpen || self.out.train.is_level();",
            "let is_level = self.energy.mode == PowerMode::DutyOpen;",
        )],
    },
    Planted {
        name: "found 9: a one-way slave shows a speed while its master goes back",
        by: By::Reference,
        places: &[(
            "servo/src/segment/follow/velocity.rs",
            "lead.one_way && !speed.is_zero()",
            "lead.one_way && speed.is_zero() && !speed.is_zero()",
        )],
    },
    Planted {
        name: "found 9: a job that ends in Reset asks for a path that is no more",
        by: By::Doors,
        places: &[(
            "host/beamtick/src/summary.rs",
            "Err(error) if is_without_axes(&error) =>",
            "Err(error) if is_without_axes(&error) && crd.crd < 0 =>",
        )],
    },
    Planted {
        name: "found 9: more than 8 entries at a vertex stop the path",
        by: By::Doors,
        places: &[("servo/src/path/evaluator.rs", "EFFECTS: u32 = 32;", "EFFECTS: u32 = 8;")],
    },
    Planted {
        name: "found 9: a call that is refused for a parameter delays those of its instant",
        by: By::Reference,
        places: &[(
            "dispatcher/src/program/end.rs",
            "            Cure::None => true,",
            "            Cure::None => self.is_past(view),",
        )],
    },
    Planted {
        name: "found 12: starts of one instant act on different ticks",
        by: By::Reference,
        places: &[(
            "servo/src/tick/workload.rs",
            "if !self.is_observable(&entry.command) {\n            return budget",
            "if !self.is_observable(&entry.command) || instant.0 != u64::MAX {\n            return budget",
        )],
    },
];
