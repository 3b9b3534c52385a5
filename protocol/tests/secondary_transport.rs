//! A client at the second wire: the answers that it gets, and when it takes the session over.
mod ends;
use ends::*;
use protocol::Ns;
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::{MAX_WIRE, OPENING_WIRE};
use protocol::link::{ALIVE_NS, Identity, KEEP_ALIVE_NS, LinkState, Role, TakeOver};

/// Frames of the wire's bytes at the controller's second wire, and its answers there.
fn take_overs(controller: &mut End, now: Ns, holder: Option<&str>, bytes: &[u8]) -> (Vec<u8>, Vec<TakeOver>) {
    let mut deframer = Deframer::<MAX_WIRE>::new();
    let (mut rest, mut answers, mut outcomes) = (bytes, Vec::new(), Vec::new());
    while !rest.is_empty() {
        let (used, outcome) = deframer.feed(rest);
        rest = &rest[used..];
        if outcome == Outcome::Frame {
            let mut answer = [0; OPENING_WIRE];
            let take_over = controller.request_take_over(now, deframer.frame(), holder, &mut answer);
            if let TakeOver::Answered(length) = take_over {
                answers.extend(&answer[..length]);
            }
            outcomes.push(take_over);
        }
    }
    (answers, outcomes)
}

#[test]
fn a_session_is_taken_up_on_the_secondary_transport_and_only_then_is_the_link_there() {
    let (mut first, mut controller) = opened();
    let session = controller.session();
    first.send(b"before").unwrap();
    let mut second = End::new(Role::Client, Identity::OURS);
    second.open(0, 2);
    let hello = out(&mut second, 0);
    let (answer, outcomes) = take_overs(&mut controller, 0, None, &hello);
    assert_eq!(outcomes, [TakeOver::Answered(answer.len())]);
    // A Hello ends nothing, and its answer does not go to the first wire.
    assert_eq!(controller.session(), session);
    pump(0, &mut first, &mut controller);
    assert_eq!(controller.message(), Some(&b"before"[..]));
    second.feed(0, &answer);
    let confirmation = out(&mut second, 0);
    // Half of a frame of the first wire has come and half of one is sent when the session changes;
    // neither harms the next.
    first.send(b"half").unwrap();
    let half = out(&mut first, 0);
    controller.feed(0, &half[..half.len() / 2]);
    controller.send(b"lost").unwrap();
    assert_eq!(controller.take_tx(0, &mut [0; 5]), 5);
    assert_eq!(take_overs(&mut controller, 0, None, &confirmation).1, [TakeOver::TakenUp]);
    assert_ne!(controller.session(), session);
    assert_eq!(controller.message(), None);
    pump(0, &mut second, &mut controller);
    // No remainder of a partly sent frame comes over this wire.
    let seen = second.counters();
    assert_eq!(
        [seen.checksum, seen.length, seen.short, seen.stale_session, seen.deframe.truncated],
        [0; 5],
        "{seen:?}"
    );
    assert_eq!((second.state(), second.session()), (LinkState::Open, controller.session()));
    second.send(b"after").unwrap();
    pump(0, &mut second, &mut controller);
    assert_eq!(controller.message(), Some(&b"after"[..]));
    // From now on the first client is at the second wire: frames in its session are ignored.
    first.poll(KEEP_ALIVE_NS);
    let (answer, outcomes) = take_overs(&mut controller, KEEP_ALIVE_NS, None, &out(&mut first, KEEP_ALIVE_NS));
    assert!(
        answer.is_empty() && !outcomes.is_empty() && outcomes.iter().all(|take_over| *take_over == TakeOver::Nothing)
    );
    assert_eq!(controller.session(), second.session());
}

#[test]
fn a_session_that_was_not_offered_takes_nothing_up_on_the_secondary_transport() {
    let (mut first, mut controller) = opened();
    let session = controller.session();
    let mut second = End::new(Role::Client, Identity::OURS);
    second.open(0, 2);
    for (n, offered) in [(1, false), (2, true)] {
        if offered {
            take_overs(&mut controller, 0, None, &out(&mut second, 0));
        }
        // A keep-alive of the open session, which is on the other wire.
        let now = n * KEEP_ALIVE_NS;
        first.poll(now);
        let (answer, outcomes) = take_overs(&mut controller, now, None, &out(&mut first, now));
        assert_eq!((answer, outcomes), (vec![], vec![TakeOver::Nothing]), "another session offered: {offered}");
        assert_eq!(controller.session(), session);
    }
}

#[test]
fn a_stranger_at_the_secondary_transport_learns_so_and_nothing_changes() {
    let (mut first, mut controller) = opened();
    let session = controller.session();
    let mut stranger = End::new(Role::Client, Identity { schema: 0, ..Identity::OURS });
    stranger.open(0, 9);
    let (answer, _) = take_overs(&mut controller, 0, None, &out(&mut stranger, 0));
    stranger.feed(0, &answer);
    assert_eq!(stranger.state(), LinkState::Mismatch(Identity::OURS));
    assert_eq!(controller.session(), session);
    first.send(b"x").unwrap();
    pump(0, &mut first, &mut controller);
    assert_eq!(controller.message(), Some(&b"x"[..]));
    // An answer that the first wire waits for is not taken by the second one.
    let mut other = End::new(Role::Client, Identity::OURS);
    other.open(0, 3);
    controller.feed(0, &out(&mut other, 0));
    stranger.open(0, 10);
    assert_eq!(take_overs(&mut controller, 0, None, &out(&mut stranger, 0)).1.len(), 1);
    pump(0, &mut other, &mut controller);
    assert_eq!((other.state(), other.session()), (LinkState::Open, controller.session()));
}

#[test]
fn a_second_client_learns_who_is_there_and_gets_the_session_when_that_one_is_silent() {
    let (mut first, mut controller) = opened();
    let session = controller.session();
    let holder = Some("127.0.0.1:4711");
    let mut second = End::new(Role::Client, Identity::OURS);
    let last = ALIVE_NS - 1;
    second.open(last, 2);
    let (answer, outcomes) = take_overs(&mut controller, last, holder, &out(&mut second, last));
    assert_eq!(outcomes, [TakeOver::Answered(answer.len())]);
    second.feed(last, &answer);
    let LinkState::Busy(busy) = second.state() else { panic!("{:?}", second.state()) };
    assert_eq!((busy.held_ms.get(), busy.silent_ms.get(), busy.holder()), (499, 499, &b"127.0.0.1:4711"[..]));
    assert_eq!((controller.session(), second.next_deadline()), (session, None));
    first.send(b"on").unwrap();
    pump(last, &mut first, &mut controller);
    assert_eq!(controller.message(), Some(&b"on"[..]));

    // An answer to another nonce is ignored by this client.
    second.open(last, 3);
    second.feed(last, &answer);
    assert_eq!(second.state(), LinkState::Opening);

    // Offered while the first one was silent. It sends again before the session is confirmed: no
    // session begins.
    let now = last + ALIVE_NS;
    let (answer, _) = take_overs(&mut controller, now, holder, &out(&mut second, now));
    second.feed(now, &answer);
    let confirmation = out(&mut second, now);
    first.poll(now);
    pump(now, &mut first, &mut controller);
    assert_eq!(take_overs(&mut controller, now, holder, &confirmation).1, [TakeOver::Nothing]);
    assert_eq!(controller.session(), session);

    // It is silent, or its wire is gone: the session is the second one's.
    for (now, holder) in [(now + ALIVE_NS, holder), (now + ALIVE_NS, None)] {
        let mut second = End::new(Role::Client, Identity::OURS);
        let nonce = if holder.is_some() { 4 } else { 5 };
        second.open(now, nonce);
        let (answer, _) = take_overs(&mut controller, now, holder, &out(&mut second, now));
        second.feed(now, &answer);
        assert_eq!(take_overs(&mut controller, now, holder, &out(&mut second, now)).1, [TakeOver::TakenUp]);
        pump(now, &mut second, &mut controller);
        assert_eq!(second.state(), LinkState::Open);
    }

    // A client of another protocol gets that answer, whoever has the session.
    let mut stranger = End::new(Role::Client, Identity { schema: 0, ..Identity::OURS });
    stranger.open(now, 9);
    let (answer, _) = take_overs(&mut controller, now, holder, &out(&mut stranger, now));
    stranger.feed(now, &answer);
    assert_eq!(stranger.state(), LinkState::Mismatch(Identity::OURS));
}
