//! Faults of laser timing, follows, Abort and Reset that the reference's programs must find alone.
use super::planted::{By, Planted};

pub const TIMING: &[Planted] = &[
    Planted {
        name: "timing: a gate goes off with its on delay",
        by: By::Reference,
        places: &[(
            "servo/src/laser/channel/gate_delays.rs",
            "(true, false) => self.delays.off,",
            "(true, false) => self.delays.on,",
        )],
    },
    Planted {
        name: "timing: no laserOffDelay after a mark",
        by: By::Reference,
        places: &[(
            "servo/src/laser/channel/first_pulse_killer.rs",
            "self.light.command(later(now, self.tail), false)",
            "self.light.command(later(now, 0), false)",
        )],
    },
    Planted {
        name: "timing: a direct power adds nothing to a follow of LSR",
        by: By::Reference,
        places: &[("servo/src/laser/power_law.rs", "base = base.wrapping_add(direct);", "let _ = direct;")],
    },
    Planted {
        name: "timing: an Abort brakes Jog axes and paths only",
        by: By::Reference,
        places: &[(
            "servo/src/tick/execute.rs",
            "self.brake(Brake::All, StopReason::Abort,",
            "self.brake(Brake::JogAndPaths, StopReason::Abort,",
        )],
    },
    Planted {
        name: "timing: a Reset keeps the gate delays",
        by: By::Reference,
        places: &[(
            "servo/src/laser/channel.rs",
            "(self.delays, self.delayed, self.fpk) = (Delays::default(), true, None);",
            "(self.delayed, self.fpk) = (true, None);",
        )],
    },
    Planted {
        name: "timing: a path at standstill has the speed of its encoders for a tick",
        by: By::Reference,
        places: &[(
            "servo/src/tick/crd/drive.rs",
            "self.feed_lasers(crd, next, wants, measures && runs);",
            "self.feed_lasers(crd, next, wants, measures);",
        )],
    },
];
