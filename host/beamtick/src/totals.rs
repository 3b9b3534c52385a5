//! What a job does as a whole, as far as it is asked before the job runs.
//!
//! In: its steps, once. Out: how many there are, the last one, outputs that any of them sets.
use job::{Action, Call, Step};
use protocol::command::{BufDA, BufDoBit, BufIO, FollowDoBitEx, Request, SetDac, SetDo, SetDoBit, SetDoEx};
use protocol::values::io;
use std::collections::BTreeSet;
use zerocopy::FromBytes;

/// See the module text.
#[derive(Debug, Default)]
pub struct Totals {
    /// Number of steps.
    pub steps: usize,
    /// What the last one does; none if that is a call of a path.
    pub last: Option<Action>,
    /// General outputs that the job sets, bit 0 is output 1.
    pub digital: u64,
    /// Analog outputs that the job sets, from 1.
    pub analog: BTreeSet<u8>,
}

impl Totals {
    /// Of these steps.
    pub fn of(steps: &[Step]) -> Totals {
        let mut totals = Totals::default();
        totals.add(steps);
        totals
    }

    /// More steps.
    pub fn add(&mut self, steps: &[Step]) {
        for step in steps {
            if let Action::Call(call) = &step.action {
                self.digital |=
                    digital(call).filter(|(kind, _)| *kind == i32::from(io::GPO)).map_or(0, |(_, mask)| mask);
                self.analog.extend(analog(call));
            }
        }
        self.steps += steps.len();
        self.last = steps.last().map(|step| step.action.clone()).or(self.last.take());
    }

    /// Calls of a path that set no outputs.
    pub fn add_calls(&mut self, count: usize) {
        self.steps += count;
        self.last = None;
    }
}

/// Analog outputs that a call sets, from 1.
fn analog(call: &Call) -> impl Iterator<Item = u8> {
    let set = match call.opcode {
        SetDac::OPCODE => SetDac::read_from_prefix(&call.body).ok().map(|(set, _)| (set.dac.get(), set.count.get())),
        BufDA::OPCODE => BufDA::read_from_bytes(&call.body).ok().map(|set| (set.channel.get(), 1)),
        _ => None,
    };
    let (first, count) = set.unwrap_or((0, 0));
    (0..count).filter_map(move |k| u8::try_from(i32::from(first) + i32::from(k)).ok())
}

/// The kind of outputs that a call sets, and which.
fn digital(call: &Call) -> Option<(i32, u64)> {
    let bit = |index: i32| u32::try_from(index - 1).ok().and_then(|bit| 1u64.checked_shl(bit)).unwrap_or(0);
    let words = |count: u16| 1u64.checked_shl(32 * u32::from(count)).unwrap_or(0).wrapping_sub(1);
    let body = &call.body[..];
    Some(match call.opcode {
        SetDo::OPCODE => (SetDo::read_from_bytes(body).ok()?.do_type.get().into(), words(1)),
        SetDoEx::OPCODE => {
            let set = SetDoEx::read_from_prefix(body).ok()?.0;
            (set.do_type.get().into(), words(set.count.get()))
        }
        SetDoBit::OPCODE => {
            let set = SetDoBit::read_from_bytes(body).ok()?;
            (set.do_type.get().into(), bit(set.index.get().into()))
        }
        FollowDoBitEx::OPCODE => {
            let set = FollowDoBitEx::read_from_bytes(body).ok()?;
            (set.do_type.get().into(), bit(set.index.get().into()))
        }
        BufDoBit::OPCODE => {
            let set = BufDoBit::read_from_bytes(body).ok()?;
            (set.do_type.get().into(), bit(set.index.get().into()))
        }
        BufIO::OPCODE => {
            let set = BufIO::read_from_bytes(body).ok()?;
            (set.do_type.get().into(), set.do_mask.get().into())
        }
        _ => return None,
    })
}
