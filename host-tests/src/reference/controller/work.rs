//! The work of an instant is weighed and spread (docs/decisions/018): where the calls of a tick are
//! more than it takes, some of them act in the next one. What a program shows is then not decided
//! by its instants alone.
use super::super::call::{Call, Kind};
use super::super::path::{Path, PathCall};

/// Units that a tick still takes: one for each 1,024 ns.
pub struct Work {
    left: i64,
    whole: i64,
}

impl Work {
    pub fn of(tick_ns: i64) -> Work {
        Work { left: tick_ns >> 10, whole: tick_ns >> 10 }
    }

    /// Whether all of a call is carried out in this tick.
    pub fn takes(&mut self, call: &Call) -> bool {
        let (weight, starts) = weight(call);
        let room = if starts { self.left + 2 * self.whole } else { self.left };
        self.left = (self.left - weight).max(0);
        weight <= room
    }
}

/// Units of a call at most, and whether it starts or stops something.
fn weight(call: &Call) -> (i64, bool) {
    let each = |mask: u32, weight: i64| i64::from(mask.count_ones()) * weight;
    match call {
        Call::Sleep { .. } | Call::WaitStop { .. } | Call::SetTick { .. } => (0, false),
        Call::Ex(call) => weight(call),
        Call::Update { mask } => (each(*mask, 23), true),
        Call::PtStart { mask, .. } | Call::PvtStart { mask } => (each(*mask, 14), true),
        Call::FollowStart { mask, .. } => (each(*mask, 33), true),
        Call::Stop { mask, .. } => (each(*mask, 9) + 1, true),
        Call::Path(PathCall { what: Path::Start { mask, .. }, .. }) => (each(u32::from(*mask as u16), 64), true),
        Call::Path(PathCall { what: Path::Stop { .. }, .. }) => (19, true),
        Call::Path(PathCall { what: Path::Set { .. }, .. }) => (20, false),
        // Of what each of its ticks does.
        Call::Reset { .. } => (60, false),
        Call::Axis { kind: Kind::ZeroPos | Kind::ClrSts, .. } => (3, false),
        Call::SynchAxisPos { .. } => (0, false),
        _ => (2, false),
    }
}
