//! Calls for one FIFO of a path joined in one PathMany, and its reply apart again.
//!
//! In: calls in order. Out: one call; from its reply the code and the reply of each, as single
//! calls have them. A controller takes one command of data in a tick, so a path whose power changes
//! with each line is entered many times faster.
use crate::call::Call;
use crate::error::{self, Error, Result};
use protocol::command::{
    BufLaserFollowMode, BufLaserFollowRatio, BufLaserFollowTable, BufLaserPrfCmd, BufLaserPrfFollow, CrdTaken,
    LaserBounds, LaserValue, PathHeld, PathMany, Request, class, opcode,
};
use protocol::path_many::{FIXED_BYTES, HEAD_BYTES, HELD_AT_ONCE, JOINED_MAX, head, target};
use protocol::reason::{Code, Reason, Refusal};
use zerocopy::{FromBytes, IntoBytes};

/// What a group makes of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Offer {
    /// It is in.
    Taken,
    /// It would be, but there is no room.
    Full,
    /// It is no call for this FIFO.
    Other,
}

/// Calls that are being joined.
#[derive(Debug, Clone)]
pub struct Group {
    target: [i16; 3],
    count: u16,
    /// Calls that may still be in it and report what they did not take as it was given.
    held: usize,
    payload: Vec<u8>,
}

impl Group {
    /// A group for the FIFO of this call, which is not in it yet, as an entry of a program; none if
    /// the call cannot be joined.
    pub fn of(call: &Call) -> Option<Group> {
        let joins = !call.may_fail && class(call.opcode).is_some_and(|class| class.kind.joins());
        let target = target((call.opcode, &call.payload)).filter(|_| joins)?;
        Some(Group { target, count: 0, held: usize::MAX, payload: vec![0; FIXED_BYTES] })
    }

    /// The same for the immediate lane, which never asks for a part of it again.
    pub fn at_once(call: &Call) -> Option<Group> {
        Group::of(call).map(|group| Group { held: HELD_AT_ONCE, ..group })
    }

    /// Takes a call, if it is for the FIFO and the request then has at most `most` bytes.
    pub fn offer(&mut self, call: &Call, most: usize) -> Offer {
        let joined = (call.opcode, &call.payload[..]);
        if call.may_fail || target(joined) != Some(self.target) {
            return Offer::Other;
        }
        if self.payload.len() + HEAD_BYTES + call.payload.len() > most.min(FIXED_BYTES + JOINED_MAX) {
            return Offer::Full;
        }
        if reports(call.opcode) {
            match self.held.checked_sub(1) {
                Some(left) => self.held = left,
                None => return Offer::Full,
            }
        }
        self.count += 1;
        self.payload.extend(head(joined));
        self.payload.extend_from_slice(&call.payload);
        Offer::Taken
    }

    /// Calls in it.
    pub fn count(&self) -> usize {
        self.count.into()
    }

    /// All of them as one call.
    pub fn call(self) -> Call {
        let Group { target, count, mut payload, .. } = self;
        let [core, crd, fifo] = target.map(Into::into);
        let fixed = PathMany { core, crd, fifo, count: count.into() };
        payload[..FIXED_BYTES].copy_from_slice(fixed.as_bytes());
        Call { opcode: PathMany::OPCODE, payload, may_fail: false }
    }
}

/// What became of each of the joined calls.
#[derive(Debug, Clone, PartialEq)]
pub struct SplitReplies {
    /// Code and payload of each that the controller has dealt with, in order.
    pub replies: Vec<(i16, Vec<u8>)>,
    /// The controller asks for the rest again: it had no room for what they report.
    pub again: bool,
}

/// The reply of a PathMany, for each of its calls. After one that is refused there is no reply, but
/// where the program or the session has ended: then that is the reply of all that follow.
///
/// # Errors
/// A reply that is none.
pub fn split_replies(calls: &[Call], code: i16, payload: &[u8]) -> Result<SplitReplies> {
    let wrong = || {
        let text = format!("the reply to PathMany of {} calls has {} bytes, which is none", calls.len(), payload.len());
        Error::new(error::LINK_PROTOCOL, text)
    };
    let (refusal, done, rest) = match code {
        0 => (None, calls.len(), payload),
        _ => {
            let (refusal, rest) = Refusal::read_from_prefix(payload).map_err(|_| wrong())?;
            let reason = refusal.reason();
            // Of the command as a whole.
            let whole = matches!(reason, Some(Reason::NotOfPath)) || refusal.item.get() == Refusal::NO_ITEM;
            let done = if whole { 0 } else { usize::from(refusal.item.get()) };
            (Some(refusal), done, rest)
        }
    };
    if done > calls.len() || refusal.is_some() && done == calls.len() {
        return Err(wrong());
    }
    let (taken, held) = match CrdTaken::read_from_prefix(rest) {
        Ok((taken, rest)) => (taken, <[PathHeld]>::ref_from_bytes(rest).map_err(|_| wrong())?),
        Err(_) if done == 0 => (CrdTaken::default(), &[][..]),
        Err(_) => return Err(wrong()),
    };
    if usize::from(taken.taken.get()) != done {
        return Err(wrong());
    }
    let single = CrdTaken { taken: 1.into(), ..taken };
    let mut held = held.iter().peekable();
    let mut replies = Vec::with_capacity(calls.len());
    for (index, call) in calls[..done].iter().enumerate() {
        let own = held.next_if(|held| usize::from(held.call.get()) == index);
        replies.push((0, reply(call, own, &single)));
    }
    let mut again = false;
    if let Some(refusal) = refusal {
        let reason = refusal.reason();
        let single = Refusal { item: Refusal::NO_ITEM.into(), ..refusal };
        again = reason == Some(Reason::RingFull) && refusal.item.get() != Refusal::NO_ITEM;
        let ends =
            refusal.item.get() == Refusal::NO_ITEM || matches!(reason, Some(Reason::Discarded | Reason::LinkLost));
        let count = if ends { calls.len() - done } else { usize::from(!again) };
        replies.extend(std::iter::repeat_n((code, single.as_bytes().to_vec()), count));
    }
    Ok(SplitReplies { replies, again })
}

/// The replies of all calls in a program, in which nothing follows one that is refused.
///
/// # Errors
/// As [`split_replies`].
pub fn split_program_replies(calls: &[Call], code: i16, payload: &[u8]) -> Result<Vec<(i16, Vec<u8>)>> {
    let mut replies = split_replies(calls, code, payload)?.replies;
    let discarded = Refusal::new(Reason::Discarded);
    replies.resize_with(calls.len(), || (Code::State as i16, discarded.as_bytes().to_vec()));
    Ok(replies)
}

/// The reply of one call that was taken; `held` if not as it was given.
fn reply(call: &Call, held: Option<&PathHeld>, taken: &CrdTaken) -> Vec<u8> {
    match (held, given(call)) {
        (_, Given::Nothing) => taken.as_bytes().to_vec(),
        (Some(held), Given::Value(_)) => LaserValue { value: held.first, held: held.held }.as_bytes().to_vec(),
        (None, Given::Value(value)) => LaserValue { value: value.into(), held: 0 }.as_bytes().to_vec(),
        (Some(held), Given::Bounds { .. }) => {
            LaserBounds { max: held.first, min: held.second, held: held.held }.as_bytes().to_vec()
        }
        (None, Given::Bounds { max, min }) => {
            LaserBounds { max: max.into(), min: min.into(), held: 0 }.as_bytes().to_vec()
        }
    }
}

/// Whether a call reports what it did not take as it was given.
fn reports(number: u16) -> bool {
    matches!(
        number,
        opcode::BufLaserPrfCmd
            | opcode::BufLaserFollowMode
            | opcode::BufLaserPrfFollow
            | opcode::BufLaserFollowRatio
            | opcode::BufLaserFollowTable
    )
}

/// The values of a call that its reply repeats.
enum Given {
    Nothing,
    Value(f64),
    Bounds { max: f64, min: f64 },
}

fn given(call: &Call) -> Given {
    /// The request, which was taken, so it has its length.
    fn of<R: Request>(call: &Call) -> Option<R> {
        R::read_from_bytes(&call.payload).ok()
    }
    let found = match call.opcode {
        opcode::BufLaserPrfCmd => of::<BufLaserPrfCmd>(call).map(|r| Given::Value(r.power.get())),
        opcode::BufLaserFollowMode => of::<BufLaserFollowMode>(call)
            .map(|r| Given::Value(if r.start_given == 0 { 0.0 } else { r.start_power.get() })),
        opcode::BufLaserPrfFollow => {
            of::<BufLaserPrfFollow>(call).map(|r| Given::Bounds { max: r.max.get().into(), min: r.min.get().into() })
        }
        opcode::BufLaserFollowRatio => {
            of::<BufLaserFollowRatio>(call).map(|r| Given::Bounds { max: r.max.get(), min: r.min.get() })
        }
        opcode::BufLaserFollowTable => {
            of::<BufLaserFollowTable>(call).map(|r| Given::Bounds { max: r.max.get(), min: r.min.get() })
        }
        _ => None,
    };
    found.unwrap_or(Given::Nothing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::{BufDelay, COMMANDS, GetClock, LnXY};

    fn line(x: i32) -> Call {
        Call::of(LnXY { core: 1.into(), crd: 1.into(), x: x.into(), ..LnXY::default() })
    }

    fn power(power: f64) -> Call {
        Call::of(BufLaserPrfCmd { core: 1.into(), crd: 1.into(), power: power.into(), ..BufLaserPrfCmd::default() })
    }

    #[test]
    fn calls_of_one_fifo_are_joined_as_far_as_they_fit() {
        let mut group = Group::of(&line(1)).unwrap();
        assert_eq!(group.offer(&line(1), usize::MAX), Offer::Taken);
        assert_eq!(group.offer(&power(1.0), usize::MAX), Offer::Taken);
        let other = Call::of(LnXY { core: 1.into(), crd: 2.into(), ..LnXY::default() });
        let may_fail = Call { may_fail: true, ..line(2) };
        for call in [other, may_fail.clone(), Call::of(GetClock {}), Call::of(PathMany::default())] {
            assert_eq!(group.offer(&call, usize::MAX), Offer::Other);
        }
        assert!(Group::of(&may_fail).is_none() && Group::of(&Call::of(GetClock {})).is_none());
        assert_eq!(group.offer(&line(2), 8 + 4 + 38 + 4 + 16 + 4 + 37), Offer::Full);
        assert_eq!(group.offer(&line(2), 8 + 4 + 38 + 4 + 16 + 4 + 38), Offer::Taken);
        while group.offer(&line(3), usize::MAX) == Offer::Taken {}
        let (count, call) = (group.count(), group.call());
        assert!(call.payload.len() <= FIXED_BYTES + JOINED_MAX && call.payload.len() > FIXED_BYTES + JOINED_MAX - 42);
        let (head, bytes) = PathMany::read_from_prefix(&call.payload).unwrap();
        assert_eq!((usize::from(head.count.get()), { head.crd }.get()), (count, 1));
        let mut powers = Group::at_once(&power(1.0)).unwrap();
        while powers.offer(&power(2.0), usize::MAX) == Offer::Taken {}
        assert_eq!((powers.count(), powers.offer(&line(1), usize::MAX)), (HELD_AT_ONCE, Offer::Taken));
        let found: Vec<_> = protocol::path_many::calls(bytes).collect();
        assert_eq!((found.len(), found[1]), (count, (BufLaserPrfCmd::OPCODE, &power(1.0).payload[..])));
    }

    fn taken(count: u16) -> Vec<u8> {
        CrdTaken { taken: count.into(), space: 7.into(), lasts_ms: 9.into() }.as_bytes().to_vec()
    }

    fn refusal(reason: Reason, item: u16) -> Vec<u8> {
        Refusal { item: item.into(), ..Refusal::new(reason) }.as_bytes().to_vec()
    }

    #[test]
    fn replies_are_those_of_single_calls() {
        let calls = [power(20.0), line(1), power(150.0)];
        let held = PathHeld { call: 2.into(), first: 100.0.into(), second: 0.0.into(), held: 1 };
        let payload = [taken(3), held.as_bytes().to_vec()].concat();
        let expected = vec![
            (0, LaserValue { value: 20.0.into(), held: 0 }.as_bytes().to_vec()),
            (0, taken(1)),
            (0, LaserValue { value: 100.0.into(), held: 1 }.as_bytes().to_vec()),
        ];
        assert_eq!(split_replies(&calls, 0, &payload), Ok(SplitReplies { replies: expected.clone(), again: false }));
        // The second is refused.
        let payload = [refusal(Reason::NoLength, 1), taken(1)].concat();
        let alone = (7, refusal(Reason::NoLength, Refusal::NO_ITEM));
        let two = vec![expected[0].clone(), alone.clone()];
        assert_eq!(split_replies(&calls, 7, &payload), Ok(SplitReplies { replies: two.clone(), again: false }));
        let discarded = (1, refusal(Reason::Discarded, Refusal::NO_ITEM));
        assert_eq!(split_program_replies(&calls, 7, &payload), Ok([two, vec![discarded.clone()]].concat()));
        // The first.
        let none = split_replies(&calls, 7, &refusal(Reason::NoLength, 0)).unwrap();
        assert_eq!(none.replies, vec![alone]);
        // The whole, and after one call.
        let whole = split_replies(&calls, 1, &refusal(Reason::Discarded, Refusal::NO_ITEM)).unwrap();
        assert_eq!(whole.replies, vec![discarded.clone(); 3]);
        let late = split_replies(&calls, 1, &[refusal(Reason::Discarded, 1), taken(1)].concat()).unwrap();
        assert_eq!(late.replies, vec![expected[0].clone(), discarded.clone(), discarded]);
        // The rest is to be sent again.
        let busy = split_replies(&calls, 1, &[refusal(Reason::RingFull, 2), taken(2)].concat()).unwrap();
        assert_eq!(busy, SplitReplies { replies: expected[..2].to_vec(), again: true });
    }

    #[test]
    fn a_reply_that_is_none_is_an_error() {
        let calls = [power(20.0), line(1)];
        for (code, payload) in [
            (0, taken(1)),
            (0, taken(3)),
            (0, vec![1, 2]),
            (0, [taken(2), vec![0; 5]].concat()),
            (7, vec![1, 2]),
            (7, refusal(Reason::NoLength, 1)),
            (7, [refusal(Reason::NoLength, 2), taken(2)].concat()),
            (7, [refusal(Reason::NoLength, 1), taken(2)].concat()),
        ] {
            assert_eq!(
                split_replies(&calls, code, &payload).unwrap_err().code,
                error::LINK_PROTOCOL,
                "{code} {payload:?}"
            );
        }
    }

    /// What a call repeats of its request is known here for every call that can be joined.
    #[test]
    fn the_reply_of_every_call_has_its_length() {
        for command in COMMANDS.iter().filter(|command| command.class.kind.joins()) {
            let payload = vec![0; protocol::command::widths(command.fields)];
            let call = Call { opcode: command.opcode, payload, may_fail: false };
            let reply = reply(&call, None, &CrdTaken::default());
            assert_eq!(reply.len(), protocol::command::widths(command.reply), "{}", command.name);
            assert_eq!(
                reports(command.opcode),
                command.reply.iter().any(|(name, _)| *name == "held"),
                "{}",
                command.name
            );
        }
        let delay = Call::of(BufDelay::default());
        assert_eq!(reply(&delay, None, &CrdTaken::default()).len(), size_of::<CrdTaken>());
    }
}
