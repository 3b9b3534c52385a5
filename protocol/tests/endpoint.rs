//! The link's rules one by one, on two ends joined by hand. Behaviour over a faulty channel is
//! tested in `host-tests/tests/link.rs`.
mod ends;
use ends::*;
use protocol::Ns;
use protocol::frame::{FrameKind, HelloAck, MAX_PAYLOAD, MAX_WIRE};
use protocol::link::{Identity, KEEP_ALIVE_NS, LinkState, RETRY_FIRST_NS, Role, SendError};
use zerocopy::IntoBytes;

#[test]
fn an_end_has_the_memory_it_says() {
    let frames = 2 * MAX_WIRE;
    assert!(size_of::<End>() <= 2 * 4 * (MAX_PAYLOAD + 16) + frames + 400, "{}", size_of::<End>());
}

#[test]
fn another_schema_or_version_is_reported_and_changes_nothing() {
    for theirs in
        [Identity { schema: Identity::OURS.schema ^ 1, ..Identity::OURS }, Identity { version: 2, ..Identity::OURS }]
    {
        let (mut client, _) = ends();
        let mut controller = End::new(Role::Controller, theirs);
        client.open(0, 1);
        pump(0, &mut client, &mut controller);
        assert_eq!(client.state(), LinkState::Mismatch(theirs));
        assert_eq!(controller.state(), LinkState::Closed);
        assert_eq!(controller.refused_client(), Some(Identity::OURS));
        assert_eq!(client.send(b"x"), Err(SendError::NotOpen));
    }
    // An open session continues.
    let (_, mut controller) = opened();
    let session = controller.session();
    let mut stranger = End::new(Role::Client, Identity { schema: 0, ..Identity::OURS });
    stranger.open(0, 9);
    pump(0, &mut stranger, &mut controller);
    assert_eq!(controller.session(), session);
}

#[test]
fn untaken_messages_close_the_window_and_are_not_sent_again() {
    let (mut client, mut controller) = opened();
    let mut sent = 0u8;
    for tick in 0..1_000 {
        let now = tick * 10 * MS;
        if client.can_send() {
            client.send(&[sent]).unwrap();
            sent += 1;
        }
        pump(now, &mut client, &mut controller);
    }
    // Four are held by the receiver, four wait at the sender.
    assert_eq!(sent, 8);
    assert_eq!(client.send(b"x"), Err(SendError::Full));
    assert_eq!(controller.counters().duplicates, 0);
    for expected in 0..sent {
        assert_eq!(controller.message(), Some(&[expected][..]));
        controller.done_with_message();
        pump(10_000 * MS, &mut client, &mut controller);
    }
    assert_eq!(controller.message(), None);
    assert!(client.all_acknowledged());
}

#[test]
fn the_client_keeps_alive_and_the_controller_sees_when_it_stops() {
    let (mut client, mut controller) = opened();
    for ms in 0..1_000 {
        pump(ms * MS, &mut client, &mut controller);
    }
    assert_eq!(controller.last_valid(), Some(900 * MS));
    assert_eq!(client.last_valid(), Some(900 * MS));
    assert_eq!(client.next_deadline(), Some(900 * MS + KEEP_ALIVE_NS));
    assert_eq!(controller.silence(1_500 * MS), Some(600 * MS));
    assert!(out(&mut controller, 5_000 * MS).is_empty(), "a controller does not speak first");
}

#[test]
fn a_late_hello_of_an_old_session_ends_nothing() {
    let (mut client, mut controller) = ends();
    client.open(0, 1);
    let old_hello = out(&mut client, 0);
    controller.feed(0, &old_hello);
    client.feed(0, &out(&mut controller, 0));
    let old_confirmation = out(&mut client, 0);
    controller.feed(0, &old_confirmation);
    pump(0, &mut client, &mut controller);
    client.send(b"old").unwrap();
    let old_message = out(&mut client, 0);
    client.open(1, 2);
    pump(1, &mut client, &mut controller);
    let session = controller.session();
    for late in [&old_hello, &old_confirmation, &old_message] {
        controller.feed(2, late);
        pump(2, &mut client, &mut controller);
    }
    assert_eq!((controller.session(), controller.message()), (session, None));
    assert_eq!(controller.counters().stale_session, 2);
    assert_eq!(client.state(), LinkState::Open);
    client.send(b"new").unwrap();
    pump(3, &mut client, &mut controller);
    assert_eq!(controller.message(), Some(&b"new"[..]));
}

#[test]
fn an_offer_that_was_overwritten_is_asked_for_anew() {
    let (mut client, mut controller) = ends();
    client.open(0, 1);
    controller.feed(0, &out(&mut client, 0));
    client.feed(0, &out(&mut controller, 0));
    let mut other = End::new(Role::Client, Identity::OURS);
    other.open(0, 2);
    controller.feed(0, &out(&mut other, 0));
    for ms in 0..1_000 {
        pump(ms * MS, &mut client, &mut controller);
    }
    assert_eq!(client.state(), LinkState::Open);
}

#[test]
fn a_new_hello_resets_both_ends() {
    let (mut client, mut controller) = opened();
    client.send(b"one").unwrap();
    pump(0, &mut client, &mut controller);
    controller.send(b"answer").unwrap();
    let first = controller.session();
    client.open(10, 5);
    pump(10, &mut client, &mut controller);
    assert_ne!(controller.session(), first);
    assert_eq!((client.message(), controller.message()), (None, None));
    assert_eq!(controller.counters().sessions, 2);
}

#[test]
fn bye_ends_the_session() {
    let (mut client, mut controller) = opened();
    client.close();
    pump(0, &mut client, &mut controller);
    assert_eq!((client.state(), controller.state()), (LinkState::Closed, LinkState::Ended));
    client.open(5, 3);
    pump(5, &mut client, &mut controller);
    assert_eq!((client.state(), controller.state()), (LinkState::Open, LinkState::Open));
}

#[test]
fn a_lost_message_is_sent_again_after_the_time_out_and_twice_as_late_the_next_time() {
    let (mut client, mut controller) = opened();
    client.send(b"lost").unwrap();
    assert!(!out(&mut client, 0).is_empty());
    let repeats: Vec<Ns> = (1..700)
        .filter(|&ms| {
            let before = client.counters().timeouts;
            out(&mut client, ms * MS);
            client.counters().timeouts != before
        })
        .collect();
    let first = RETRY_FIRST_NS / MS;
    assert_eq!(repeats, [first, 3 * first]);
    let again = out(&mut client, 1_400 * MS);
    controller.feed(1_400 * MS, &again);
    assert_eq!(controller.message(), Some(&b"lost"[..]));
}

#[test]
fn a_gap_reported_twice_repeats_at_once() {
    let (mut client, mut controller) = opened();
    for message in [b"a", b"b", b"c"] {
        client.send(message).unwrap();
        let wire = out(&mut client, 0);
        if message != b"a" {
            controller.feed(MS, &wire);
            let report = out(&mut controller, MS);
            client.feed(MS, &report);
        }
    }
    assert_eq!(client.counters().fast_retransmits, 1);
    assert_eq!(controller.message(), None);
    pump(MS, &mut client, &mut controller);
    for message in [b"a", b"b", b"c"] {
        assert_eq!(controller.message(), Some(&message[..]));
        controller.done_with_message();
    }
}

#[test]
fn numbers_wrap() {
    let (mut client, mut controller) = opened();
    for count in 0..200_000u32 {
        client.send(&count.to_le_bytes()).unwrap();
        pump(0, &mut client, &mut controller);
        assert_eq!(controller.message(), Some(&count.to_le_bytes()[..]));
        controller.done_with_message();
    }
    assert_eq!(controller.counters().received, 200_000);
}

#[test]
fn a_message_of_full_length_leaves_in_small_portions() {
    let (mut client, mut controller) = opened();
    let message: Vec<u8> = (0..MAX_PAYLOAD).map(|i| i as u8).collect();
    client.send(&message).unwrap();
    assert_eq!(client.send(&[0; MAX_PAYLOAD + 1]), Err(SendError::TooLong));
    let mut portion = [0; 7];
    loop {
        let length = client.take_tx(0, &mut portion);
        if length == 0 {
            break;
        }
        controller.feed(0, &portion[..length]);
    }
    assert_eq!(controller.message(), Some(&message[..]));
    // The answer is written in place.
    let (came, draft) = controller.message_and_draft().unwrap();
    draft[..4].copy_from_slice(&came[..4]);
    controller.send_draft(4).unwrap();
    controller.done_with_message();
    pump(0, &mut client, &mut controller);
    assert_eq!(client.message(), Some(&message[..4]));
}

/// Both ways past 65,536 messages of a session; every 37th frame is lost, and lost messages are
/// sent again.
#[test]
fn sequence_numbers_wrap() {
    let (mut client, mut controller) = opened();
    let (mut sent, mut taken, mut answered, mut frames, mut now) = (0u32, 0u32, 0u32, 0u32, 0);
    let mut lossy = |from: &mut End, to: &mut End, now: Ns| {
        for frame in out(from, now).split_inclusive(|&byte| byte == 0) {
            frames += 1;
            if frames % 37 != 0 {
                to.feed(now, frame);
            }
        }
    };
    while answered < 70_000 {
        now += MS;
        while sent < 70_000 && client.can_send() {
            client.send(&sent.to_le_bytes()).unwrap();
            sent += 1;
        }
        client.poll(now);
        controller.poll(now);
        lossy(&mut client, &mut controller, now);
        while controller.can_send()
            && let Some(message) = controller.message()
        {
            assert_eq!(message, taken.to_le_bytes());
            controller.done_with_message();
            controller.send(&taken.to_le_bytes()).unwrap();
            taken += 1;
        }
        lossy(&mut controller, &mut client, now);
        while let Some(message) = client.message() {
            assert_eq!(message, answered.to_le_bytes());
            client.done_with_message();
            answered += 1;
        }
        assert!(now < 10_000_000 * MS, "{sent} sent, {taken} taken, {answered} answered");
    }
    assert_eq!((sent, taken), (70_000, 70_000));
}

/// Frames in another session, or in none, do not end the silence of the link, and count for
/// nothing.
#[test]
fn frames_of_another_session_are_no_life_of_this_one() {
    let (mut client, mut controller) = opened();
    let old = controller.session().unwrap();
    client.open(MS, 2);
    pump(MS, &mut client, &mut controller);
    let session = controller.session().unwrap();
    let heard = controller.last_valid();
    assert!(heard == Some(MS) && session != old);
    client.send(b"waits").unwrap();
    out(&mut client, MS);
    let mut stale = 0;
    for (k, other) in (0..).zip([old, session ^ 1, session.wrapping_add(1), 0]) {
        for kind in [FrameKind::KeepAlive, FrameKind::Ack, FrameKind::Data, FrameKind::Bye] {
            let now = (k + 2) * 100 * MS;
            for end in [&mut controller, &mut client] {
                end.feed(now, &encoded(kind, other, (0, 1), if kind == FrameKind::Data { b"old" } else { b"" }));
                assert_eq!((end.session(), end.last_valid(), end.message()), (Some(session), heard, None));
            }
            stale += 1;
            assert_eq!((controller.counters().stale_session, client.counters().stale_session), (stale, stale));
        }
    }
    assert!(!client.all_acknowledged());
    assert_eq!(controller.silence(900 * MS), Some(899 * MS));
    assert!(out(&mut controller, 900 * MS).is_empty(), "nor is there an answer");
}

/// Neither a damaged frame nor one that asks for another session shows that this one's client is
/// alive.
#[test]
fn damaged_frames_and_hellos_are_no_life_of_a_session() {
    let (client, mut controller) = opened();
    let good = sealed(&client, FrameKind::KeepAlive, 0, b"");
    for bit in 8..8 * (good.len() - 1) {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        controller.feed(MS, &bad);
        // The damage may have made a delimiter.
        controller.feed(MS, &[0]);
        assert_eq!(controller.last_valid(), Some(0), "{bit}");
    }
    let mut stranger = End::new(Role::Client, Identity::OURS);
    stranger.open(MS, 9);
    controller.feed(MS, &out(&mut stranger, MS));
    assert_eq!((controller.session(), controller.last_valid()), (client.session(), Some(0)));
    controller.feed(2 * MS, &good);
    assert_eq!(controller.last_valid(), Some(2 * MS));
}

/// A client accepts an offer to its own Hello only, once, and no session 0.
#[test]
fn a_client_takes_up_the_session_that_it_asked_for() {
    let answer = |schema: u32, session: u32| {
        HelloAck { schema: schema.into(), window: 4.into(), session: session.into() }.as_bytes().to_vec()
    };
    let ours = Identity::OURS.schema;
    let (mut client, _) = ends();
    client.feed(0, &encoded(FrameKind::HelloAck, 7, (0, 0), &answer(ours, 5)));
    assert_eq!((client.state(), client.counters().unexpected), (LinkState::Closed, 1));
    client.open(0, 7);
    out(&mut client, 0);
    for (nonce, session) in [(8, 5), (0, 5), (7, 0)] {
        client.feed(0, &encoded(FrameKind::HelloAck, nonce, (0, 0), &answer(ours, session)));
        assert!(out(&mut client, 0).is_empty(), "{nonce} {session}");
    }
    assert_eq!((client.state(), client.counters().unexpected), (LinkState::Opening, 4));
    client.feed(0, &encoded(FrameKind::HelloAck, 7, (0, 0), &answer(ours, 5)));
    client.feed(0, &encoded(FrameKind::HelloAck, 7, (0, 0), &answer(ours, 6)));
    client.feed(0, &encoded(FrameKind::Ack, 6, (0, 0), b""));
    assert_eq!((client.state(), client.counters().stale_session), (LinkState::Opening, 1));
    client.feed(0, &encoded(FrameKind::Ack, 5, (0, 0), b""));
    client.feed(0, &encoded(FrameKind::HelloAck, 7, (0, 0), &answer(ours, 6)));
    assert_eq!((client.state(), client.session(), client.counters().unexpected), (LinkState::Open, Some(5), 6));
}

/// The first message under a number stays, and nothing is taken if nothing came.
#[test]
fn a_message_is_kept_as_it_came_and_none_is_taken_before_it() {
    let (client, mut controller) = opened();
    let session = client.session().unwrap();
    let message = |sequence: u16, text: &[u8]| encoded(FrameKind::Data, session, (sequence, 0), text);
    controller.done_with_message();
    for (sequence, text) in [(1, b"one"), (1, b"eno"), (0, b"nul"), (0, b"lun")] {
        controller.feed(0, &message(sequence, text));
    }
    assert_eq!(controller.counters().duplicates, 2);
    for text in [b"nul", b"one"] {
        assert_eq!(controller.message(), Some(&text[..]));
        controller.done_with_message();
    }
    controller.done_with_message();
    controller.feed(0, &message(2, b"two"));
    assert_eq!(controller.message(), Some(&b"two"[..]));
}

/// The message just after the window is not kept, not even if the first one's slot is free.
#[test]
fn a_message_after_the_window_is_not_kept() {
    let (client, mut controller) = opened();
    let session = client.session().unwrap();
    let message = |sequence: u16, text: &[u8]| encoded(FrameKind::Data, session, (sequence, 0), text);
    // The first is lost, what follows fills the window of four: 1, 2, 3; 4 is one too far.
    for (sequence, text) in [(1, b"one"), (2, b"two"), (3, b"thr"), (4, b"for"), (5, b"fiv"), (0x7fff, b"far")] {
        controller.feed(0, &message(sequence, text));
    }
    assert_eq!((controller.message(), controller.counters().beyond_window), (None, 3));
    controller.feed(0, &message(0, b"nul"));
    for text in [b"nul", b"one", b"two", b"thr"] {
        assert_eq!(controller.message(), Some(&text[..]));
        controller.done_with_message();
    }
    assert_eq!(controller.message(), None);
    // With one slot free again, exactly one fits.
    for (sequence, text) in [(4, b"for"), (8, b"nin"), (7, b"eig"), (5, b"fiv"), (6, b"six")] {
        controller.feed(0, &message(sequence, text));
    }
    assert_eq!(controller.counters().beyond_window, 4);
    for text in [b"for", b"fiv", b"six", b"eig"] {
        assert_eq!(controller.message(), Some(&text[..]));
        controller.done_with_message();
    }
    assert_eq!(controller.message(), None);
}

#[test]
fn an_acknowledgement_of_what_was_never_sent_changes_nothing() {
    let (mut client, mut controller) = opened();
    client.send(b"one").unwrap();
    out(&mut client, 0);
    // That was lost; and this is no acknowledgement of it.
    client.feed(0, &sealed(&client, FrameKind::Ack, 3, &[]));
    assert_eq!((client.counters().bad_acknowledgement, client.all_acknowledged()), (1, false));
    client.poll(RETRY_FIRST_NS);
    pump(RETRY_FIRST_NS, &mut client, &mut controller);
    assert_eq!(controller.message(), Some(&b"one"[..]));
    assert!(client.all_acknowledged());
}

#[test]
fn a_frame_with_any_bit_damaged_is_none() {
    let (_, mut controller) = opened();
    let good = sealed(&controller, FrameKind::Data, 0, b"\0what the frame \0\0 carries");
    for bit in 0..8 * good.len() {
        let mut damaged = good.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        controller.feed(0, &damaged);
        controller.feed(0, &[0]);
        assert_eq!(controller.message(), None, "bit {bit}");
    }
    controller.feed(0, &good);
    assert_eq!(controller.message(), Some(&b"\0what the frame \0\0 carries"[..]));
}
