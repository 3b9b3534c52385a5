//! The calls that a PathMany joins: entries of one FIFO of a coordinate system, in order, each with
//! its number and its whole request.
//!
//! In and out: the bytes after the fixed part of the request. Which calls may be among them says
//! the table ([`CommandKind::joins`](crate::command::CommandKind::joins)). Both sides read and
//! write them here.

use crate::command::{PathCall, PathMany, fifo_offset};
use crate::record::{BODY_MAX, ITEM_BYTES};
use zerocopy::{FromBytes, IntoBytes};

/// Most bytes of calls that a client joins, with their heads.
pub const JOINED_MAX: usize = ITEM_BYTES;
/// Bytes before the calls: the fixed part of the request.
pub const FIXED_BYTES: usize = size_of::<PathMany>();
/// Bytes before each call.
pub const HEAD_BYTES: usize = size_of::<PathCall>();
/// Most calls of a message that report what they did not take as it was given. The shortest of them
/// is a power.
pub const HELD_MAX: usize = (BODY_MAX - FIXED_BYTES) / (HEAD_BYTES + size_of::<crate::command::BufLaserPrfCmd>());

/// So many calls that report what they did not take as it was given are taken in one PathMany of
/// the immediate lane, whatever they report.
pub const HELD_AT_ONCE: usize = 20;

/// A call: its number and its request.
pub type Joined<'a> = (u16, &'a [u8]);

/// The call that begins at this byte; none at the end, or where the rest holds no whole call.
pub fn call_at(calls: &[u8], at: usize) -> Option<Joined<'_>> {
    let (head, rest) = PathCall::read_from_prefix(calls.get(at..)?).ok()?;
    Some((head.opcode.get(), rest.get(..usize::from(head.length.get()))?))
}

/// The byte at which the next call begins.
pub const fn after(at: usize, call: Joined<'_>) -> usize {
    at.saturating_add(HEAD_BYTES).saturating_add(call.1.len())
}

/// The calls in order, up to the first that is not whole.
pub fn calls(calls: &[u8]) -> impl Iterator<Item = Joined<'_>> {
    let mut at = 0;
    core::iter::from_fn(move || {
        let call = call_at(calls, at)?;
        at = after(at, call);
        Some(call)
    })
}

/// The bytes of that many calls; none if they are fewer.
pub fn length(bytes: &[u8], count: u16) -> Option<usize> {
    let mut found = 0;
    let length = calls(bytes).take(count.into()).fold(0, |at, call| {
        found += 1;
        after(at, call)
    });
    (found == usize::from(count)).then_some(length)
}

/// Core, coordinate system and FIFO that a call names; none if it cannot be joined. Of a request
/// that is too short, what is missing counts as 0: its own admission refuses it.
pub fn target(call: Joined<'_>) -> Option<[i16; 3]> {
    let offset = fifo_offset(call.0)?;
    let short = |at: usize| {
        let bytes = call.1.get(at..).and_then(|rest| rest.first_chunk());
        bytes.map(|bytes| i16::from_le_bytes(*bytes))
    };
    Some([short(0).unwrap_or(0), short(2).unwrap_or(0), short(offset).unwrap_or(0)])
}

/// Whether a request is too short to name its FIFO.
pub fn is_short(call: Joined<'_>) -> bool {
    fifo_offset(call.0).is_some_and(|offset| call.1.len() < offset.saturating_add(2))
}

/// The head of a call, for whoever writes it.
pub fn head(call: Joined<'_>) -> [u8; HEAD_BYTES] {
    let head = PathCall { opcode: call.0.into(), length: (call.1.len() as u16).into() };
    let mut bytes = [0; HEAD_BYTES];
    bytes.copy_from_slice(head.as_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{BufLaserPrfCmd, LnXY, Request};
    use std::vec::Vec;

    #[test]
    fn calls_are_read_as_they_were_written() {
        let line = LnXY { core: 1.into(), crd: 2.into(), fifo: 1.into(), ..LnXY::default() };
        let power = BufLaserPrfCmd { core: 1.into(), crd: 2.into(), fifo: 1.into(), ..BufLaserPrfCmd::default() };
        let mut bytes = Vec::new();
        for call in [(LnXY::OPCODE, line.as_bytes()), (BufLaserPrfCmd::OPCODE, power.as_bytes())] {
            bytes.extend(head(call));
            bytes.extend(call.1);
            assert_eq!(target(call), Some([1, 2, 1]));
            assert!(!is_short(call) && is_short((call.0, &call.1[..5])));
        }
        let found: Vec<Joined<'_>> = calls(&bytes).collect();
        assert_eq!(found, [(LnXY::OPCODE, line.as_bytes()), (BufLaserPrfCmd::OPCODE, power.as_bytes())]);
        assert_eq!((length(&bytes, 2), length(&bytes, 3), length(&bytes, 0)), (Some(bytes.len()), None, Some(0)));
        assert_eq!(length(&bytes[..bytes.len() - 1], 2), None);
        assert_eq!(target((PathMany::OPCODE, &bytes)), None);
    }
}
