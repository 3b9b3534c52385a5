//! For how long a call may act later than it was made.
//!
//! In: what a program did, and one of its calls. Out: ns.
use super::machine::{Reported, Sent};
use super::program::{Act, Do};
use host_tests::light_judge::Ns;

/// What is said together with an abort, a new session or many entries may wait for it: for how
/// long.
pub fn late(reported: &Reported, sent: &Sent, tick: Ns) -> Ns {
    let waits = reported.acts.iter().any(|&(when, act)| {
        (sent.at - 2 * tick..=sent.at).contains(&when)
            && matches!(act, Act::Session | Act::Call(Do::Abort | Do::Entry { .. } | Do::Mode { .. }))
    });
    // What comes with a call that is refused may wait with it.
    let refused = |other: &Sent| other.at == sent.at && other.code != Some(0);
    if waits || reported.sent.iter().any(refused) {
        return 3 * tick;
    }
    // What comes after a map in one tick may wait for the next. So may what comes after a start
    // of what a call of the same instant stops: the start is decided on the executed stop.
    let with = reported.sent.iter().take_while(|other| !std::ptr::eq(*other, sent));
    let mut stopped = 0;
    with.filter(|other| other.at == sent.at).map(|other| Ns::from(waits_for(&other.call, &mut stopped))).sum::<Ns>()
        * tick
}

/// Whether later calls of the same instant may wait a tick for this one. `stopped`: the coordinate
/// systems that calls before it stop.
fn waits_for(call: &Do, stopped: &mut u8) -> bool {
    match *call {
        Do::Map { .. } => return true,
        Do::CrdStart { mask, .. } if mask & *stopped != 0 => {
            *stopped &= !mask;
            return true;
        }
        Do::Stop { crds, .. } | Do::CrdStop { crds, .. } => *stopped |= crds,
        Do::AxisStop { axis } => *stopped |= 1 << (axis / 2),
        _ => {}
    }
    false
}
