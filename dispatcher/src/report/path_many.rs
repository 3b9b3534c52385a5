//! What a PathMany answers beside the reply to its last call: what its calls did not take as it was
//! given, and the calls before one that is refused.
//!
//! In: the values that a lane keeps. Out: items of the reply. A call keeps a word, which has its
//! number, its `limited_values` and whether two values follow, and then the one or two values.
use crate::bounded_vec::collect;
use crate::report::answer::Sent;
use heapless::Vec;
use protocol::command::{CrdTaken, PathHeld};
use protocol::path_many::HELD_MAX;
use protocol::reason::{Code, Reason, Refusal};
use protocol::record::ReplyWriter;
use zerocopy::IntoBytes;

/// Most values that a call keeps.
pub const MESSAGES_KEPT: usize = 3;
const _: () = assert!(
    2 * HELD_MAX + MESSAGES_KEPT <= crate::capacity::AWAITING_VALUES,
    "a program holds what a PathMany reports"
);

/// The values to keep of a call.
pub fn kept(call: u16, held: u8, values: &[f64]) -> impl Iterator<Item = f64> {
    let two = values.len() > 1;
    let word = u32::from(call) << 9 | u32::from(held) << 1 | u32::from(two);
    core::iter::once(f64::from(word)).chain(values.iter().copied().take(1 + usize::from(two)))
}

/// What calls did not take as it was given, from the values that were kept.
fn limited_values(values: &mut dyn Iterator<Item = f64>) -> Vec<PathHeld, HELD_MAX> {
    collect(core::iter::from_fn(move || {
        let word = values.next()? as u32;
        let (first, second) = (values.next()?, if word & 1 == 1 { values.next()? } else { 0.0 });
        let (call, held) = ((word >> 9) as u16, (word >> 1) as u8);
        Some(PathHeld { call: call.into(), first: first.into(), second: second.into(), held })
    }))
}

/// Writes the reply to calls that were executed. Not inlined, like [`refused`]: its items are a
/// kilobyte on the stack, which callers have no room for while they admit a command.
#[inline(never)]
pub fn done(
    (opcode, tag): (u16, u16),
    taken: CrdTaken,
    kept: &mut dyn Iterator<Item = f64>,
    out: &mut ReplyWriter,
) -> Sent {
    out.push_raw(opcode, tag, 0, &[taken.as_bytes(), limited_values(kept).as_bytes()])
}

/// Writes a refusal, and the reply to the calls before the one that it names.
#[inline(never)]
pub fn refused(
    (opcode, tag): (u16, u16),
    (refusal, taken): (&Refusal, CrdTaken),
    kept: &mut dyn Iterator<Item = f64>,
    out: &mut ReplyWriter,
) -> Sent {
    let held = limited_values(kept);
    let code = Reason::from_number(refusal.reason.get()).map_or(Code::State, Reason::code);
    let before = usize::from(refusal.item.get());
    let held = held.get(..held.partition_point(|held| usize::from(held.call.get()) < before)).unwrap_or(&[]);
    out.push_raw(opcode, tag, code as i16, &[refusal.as_bytes(), taken.as_bytes(), held.as_bytes()])
}
