//! Link-loss time-out (SPEC 9): what happens when no valid frame has come for the link-loss time.
//!
//! In: when the last valid frame came, the time. Out: `TickCommand::Link`, the end of a running
//! program, an event. Owns nothing. Fails: where the lane has no room, nothing is pushed and the
//! next poll tries again.
use crate::admit::admission::Admission;
use crate::program::Program;
use crate::report::event_log::EventKind;
use crate::shadow::ShadowChange;
use protocol::reason::Reason;
use servo::tick_command::TickCommand;
use servo::units::{AxisMask, CrdMask, Ns};

/// Entries of the immediate lane that the loss of the link takes.
const LINK_LOSS_ENTRIES: usize = 2;

/// When a link whose last valid frame came at `heard` (ns) is lost, ns.
pub fn instant(heard: u64, link_loss_ms: u32) -> u64 {
    heard.saturating_add(u64::from(link_loss_ms) * 1_000_000).saturating_add(1)
}

/// Checks the link for silence longer than the link-loss time, once a session was open. If it is
/// lost, the tick shuts off lasers whose light is on or may come. Jog axes and paths brake (all
/// axes, if SetLinkLoss demands it), and the rest of a running program is dropped. Other motion
/// goes on without light.
pub fn watch<const AXES: usize>(
    admission: &mut Admission<AXES>,
    program: &mut Program,
    lost: &mut bool,
    heard: Option<u64>,
    now: Ns,
) {
    let Some(heard) = heard else { return };
    let limit = u64::from(admission.executed.watch.link_loss_ms) * 1_000_000;
    let silent = limit != 0 && now.0.saturating_sub(heard) > limit;
    if silent && !*lost && admission.lane.room() >= LINK_LOSS_ENTRIES {
        // The tick gets this before the program is dropped: a running program is a reason to shut
        // off the lasers.
        *lost = report(admission, true);
        program.stop(admission, Reason::LinkLost);
        admission.log.put(now, EventKind::Link, 0, 1);
    } else if !silent && *lost {
        *lost = !report(admission, false);
        if !*lost {
            admission.log.put(now, EventKind::Link, 0, 0);
        }
    }
}

/// Reports to the tick that the link is lost or back; false if the lane has no room for it now.
fn report<const AXES: usize>(admission: &mut Admission<AXES>, lost: bool) -> bool {
    // On a loss all paths brake.
    let crds = CrdMask(if lost { u8::MAX } else { 0 });
    admission.push(TickCommand::Link { lost }, ShadowChange::Stopped { axes: AxisMask(0), crds })
}
