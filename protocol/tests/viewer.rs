//! A viewer: what it gets, and that nothing but a read passes.
mod ends;
use ends::*;
use protocol::command::{
    COMMANDS, Clock, CommandInfo, CommandKind, GetClock, LaserOn, ProgramStart, ProgramStatus, Request, widths,
};
use protocol::frame::{MAX_WIRE, OPENING_WIRE};
use protocol::link::{ALIVE_NS, Identity, LinkState, Role, TakeOver};
use protocol::reason::{Reason, Refusal};
use protocol::record::{JOB_RECORD, JobState, Lane, ReplyWriter, RequestRecord, RequestWriter, replies};
use protocol::viewer::{Answered, NAME_MAX, Viewer};
use zerocopy::{FromBytes, IntoBytes};

fn tx(viewer: &mut Viewer) -> Vec<u8> {
    let mut wire = vec![0; 8 * MAX_WIRE];
    let length = viewer.take_tx(0, &mut wire);
    wire.truncate(length);
    wire
}

fn exchange(
    client: &mut End,
    viewer: &mut Viewer,
    mut reply: impl FnMut(&RequestRecord<'_>, &mut ReplyWriter<'_>) -> Answered,
) {
    loop {
        let up = out(client, 0);
        viewer.feed(0, &up);
        viewer.answer(&mut reply);
        let down = tx(viewer);
        client.feed(0, &down);
        if up.is_empty() && down.is_empty() {
            return;
        }
    }
}

fn opened_viewer() -> (End, Viewer) {
    let (mut client, mut viewer) = (End::new(Role::Client, Identity::OURS), Viewer::new());
    client.open_read_only(0, 7);
    exchange(&mut client, &mut viewer, |_, _| panic!("nothing was asked"));
    assert_eq!((client.state(), viewer.is_open()), (LinkState::Open, true));
    (client, viewer)
}

/// Sends one record of each call; the code and the reason of each reply, in order.
fn ask(client: &mut End, viewer: &mut Viewer, calls: &[(u16, Lane, Vec<u8>)]) -> (Vec<u16>, Vec<(i16, u16)>) {
    let (mut reached, mut answered) = (Vec::new(), Vec::new());
    for (opcode, lane, body) in calls {
        let mut message = [0; protocol::MAX_PAYLOAD];
        let mut writer = RequestWriter::new(&mut message);
        writer.push_raw(*opcode, *lane, 1, &[body]).unwrap();
        let length = writer.len();
        client.send(&message[..length]).unwrap();
        exchange(client, viewer, |record, out| {
            reached.push(record.opcode);
            out.push_raw(record.opcode, record.tag, 0, &[]).into()
        });
        let message = client.message().expect("an answer").to_vec();
        for reply in replies(&message) {
            let reply = reply.unwrap();
            let reason = Refusal::read_from_bytes(reply.body).map_or(0, |refusal| refusal.reason.get());
            answered.push((reply.code, reason));
        }
        client.done_with_message();
    }
    (reached, answered)
}

#[test]
fn only_reads_of_the_immediate_lane_pass() {
    let (mut client, mut viewer) = opened_viewer();
    let lanes = [Lane::Immediate, Lane::Program, Lane::ProgramMayFail];
    let all = COMMANDS.iter().flat_map(|command| lanes.map(|lane| (command, lane)));
    let calls: Vec<(&CommandInfo, Lane)> = all.collect();
    let bytes = |(command, lane): &(&CommandInfo, Lane)| (command.opcode, *lane, vec![0; widths(command.fields)]);
    let sent: Vec<_> = calls.iter().map(bytes).collect();
    let (reached, answered) = ask(&mut client, &mut viewer, &sent);
    let passes = |(command, lane): &&(&CommandInfo, Lane)| {
        let reads = matches!(command.class.kind, CommandKind::Read(_)) || command.opcode == ProgramStatus::OPCODE;
        reads && *lane == Lane::Immediate
    };
    let expected: Vec<u16> = calls.iter().filter(passes).map(|(command, _)| command.opcode).collect();
    assert_eq!(reached, expected);
    assert!(!reached.contains(&LaserOn::OPCODE) && !reached.contains(&ProgramStart::OPCODE));
    assert_eq!(answered.len(), calls.len());
    for (call, (code, reason)) in calls.iter().zip(answered) {
        let wanted = if passes(&call) { (0, 0) } else { (1, Reason::ReadOnly as u16) };
        assert_eq!((code, reason), wanted, "{} in {:?}", call.0.name, call.1);
    }
    let (reached, answered) = ask(&mut client, &mut viewer, &[(0x7777, Lane::Immediate, vec![])]);
    assert_eq!((reached, answered), (vec![], vec![(8, Reason::UnknownCommand as u16)]));
}

#[test]
fn what_is_no_message_is_refused_and_the_session_goes_on() {
    let (mut client, mut viewer) = opened_viewer();
    client.send(&[0x03, 0x00, 0x01]).unwrap();
    exchange(&mut client, &mut viewer, |_, _| panic!("it is no record"));
    let message = client.message().expect("an answer").to_vec();
    assert_eq!(replies(&message).next().unwrap().unwrap().code, 7);
    client.done_with_message();
    let (reached, answered) = ask(&mut client, &mut viewer, &[(GetClock::OPCODE, Lane::Immediate, vec![])]);
    assert_eq!((reached, answered), (vec![GetClock::OPCODE], vec![(0, 0)]));
}

#[test]
fn what_is_answered_later_keeps_its_order() {
    let (mut client, mut viewer) = opened_viewer();
    let mut message = [0; 64];
    let mut writer = RequestWriter::new(&mut message);
    for tag in 1..=3 {
        writer.push(Lane::Immediate, tag, &GetClock {}, &[]).unwrap();
    }
    let length = writer.len();
    client.send(&message[..length]).unwrap();
    let mut tags = Vec::new();
    // One in each turn.
    for turn in 1..=3usize {
        let mut left = 1;
        exchange(&mut client, &mut viewer, |record, out| {
            if left == 0 {
                return Answered::Later;
            }
            left -= 1;
            out.done::<GetClock>(record.tag, &Clock::default(), &[]).into()
        });
        let message = client.message().expect("an answer").to_vec();
        tags.extend(replies(&message).map(|reply| reply.unwrap().tag));
        client.done_with_message();
        assert_eq!(tags.len(), turn);
    }
    assert_eq!(tags, [1, 2, 3]);
}

#[test]
fn a_client_that_commands_is_told_who_is_there() {
    let (mut client, mut viewer) = (End::new(Role::Client, Identity::OURS), Viewer::new());
    client.open(0, 7);
    exchange(&mut client, &mut viewer, |_, _| panic!("nothing was asked"));
    let LinkState::Busy(busy) = client.state() else { panic!("{:?}", client.state()) };
    assert_eq!(busy.holder(), b"a port that is only for viewers");
    assert!(!viewer.is_asked() && !viewer.is_open());
}

#[test]
fn a_viewer_can_be_turned_away() {
    let (mut client, mut viewer) = (End::new(Role::Client, Identity::OURS), Viewer::new());
    client.open_read_only(0, 7);
    viewer.feed(0, &out(&mut client, 0));
    assert!(viewer.is_asked());
    viewer.turn_away();
    client.feed(0, &tx(&mut viewer));
    let LinkState::Busy(busy) = client.state() else { panic!("{:?}", client.state()) };
    assert_eq!(busy.holder(), b"enough viewers are here");
    // The offer is void.
    client.open_read_only(0, 8);
    let _ = out(&mut client, 0);
    assert!(!viewer.is_asked() && !viewer.is_open());
}

#[test]
fn a_controllers_own_wire_gives_no_read_only_session_and_nothing_changes_there() {
    let (mut commanding, mut controller) = opened();
    let session = controller.session();
    let heard = controller.last_valid();
    // On the wire of the session.
    let mut viewer = End::new(Role::Client, Identity::OURS);
    viewer.open_read_only(ALIVE_NS, 2);
    controller.feed(ALIVE_NS, &out(&mut viewer, ALIVE_NS));
    viewer.feed(ALIVE_NS, &out(&mut controller, ALIVE_NS));
    assert_eq!(viewer.state(), LinkState::NoReadOnly);
    // Nor is it life of the session.
    assert_eq!((controller.session(), controller.last_valid()), (session, heard));
    // On the other wire of a board, whether its session is alive or not.
    for (now, nonce) in [(0, 3), (2 * ALIVE_NS, 4)] {
        viewer.open_read_only(now, nonce);
        let hello = out(&mut viewer, now);
        let mut deframer = protocol::deframe::Deframer::<MAX_WIRE>::new();
        deframer.feed(&hello);
        let mut answer = [0; OPENING_WIRE];
        let TakeOver::Answered(length) = controller.request_take_over(now, deframer.frame(), Some("here"), &mut answer)
        else {
            panic!("no answer")
        };
        viewer.feed(now, &answer[..length]);
        assert_eq!(viewer.state(), LinkState::NoReadOnly);
        // No session was offered that a KeepAlive could begin.
        assert_eq!((controller.session(), controller.last_valid()), (session, heard));
    }
    commanding.send(b"x").unwrap();
    pump(0, &mut commanding, &mut controller);
    assert_eq!(controller.message(), Some(&b"x"[..]));
}

#[test]
fn a_client_that_commands_takes_no_read_only_session_for_one() {
    let mut viewer = End::new(Role::ReadOnly, Identity::OURS);
    let mut asks = End::new(Role::Client, Identity::OURS);
    asks.open_read_only(0, 5);
    viewer.feed(0, &out(&mut asks, 0));
    let offer = out(&mut viewer, 0);
    let mut client = End::new(Role::Client, Identity::OURS);
    client.open(0, 5);
    let _ = out(&mut client, 0);
    client.feed(0, &offer);
    assert_eq!((client.state(), client.counters().unexpected), (LinkState::Opening, 1));
}

#[test]
fn the_job_is_shown_and_its_name_is_cut_between_letters() {
    let (mut client, mut viewer) = opened_viewer();
    let job = JobState { entries: 9.into(), done: 4.into(), left_ms: 1500.into() };
    let name = "ü".repeat(NAME_MAX);
    viewer.show_job(&job, &name);
    client.feed(0, &tx(&mut viewer));
    let message = client.message().expect("a record").to_vec();
    let record = replies(&message).next().unwrap().unwrap();
    assert_eq!((record.opcode, record.tag, record.code), (JOB_RECORD, 0, 0));
    let (head, text) = JobState::read_from_prefix(record.body).unwrap();
    assert_eq!((head.as_bytes(), text.len()), (job.as_bytes(), NAME_MAX - NAME_MAX % 2));
    assert_eq!(std::str::from_utf8(text).unwrap(), &name[..text.len()]);
}

#[test]
fn a_session_ends_with_bye_and_another_begins_on_the_same_connection() {
    let (mut client, mut viewer) = opened_viewer();
    // A message that is half answered when the session ends is not gone on with in the next one.
    let mut message = [0; 64];
    let mut writer = RequestWriter::new(&mut message);
    for tag in 1..=2 {
        writer.push(Lane::Immediate, tag, &GetClock {}, &[]).unwrap();
    }
    let length = writer.len();
    client.send(&message[..length]).unwrap();
    let mut once = 1;
    exchange(&mut client, &mut viewer, |record, out| {
        if std::mem::take(&mut once) == 0 {
            return Answered::Later;
        }
        out.done::<GetClock>(record.tag, &Clock::default(), &[]).into()
    });
    client.close();
    viewer.feed(0, &out(&mut client, 0));
    assert!(viewer.has_ended() && !viewer.is_open());
    client.open_read_only(0, 11);
    exchange(&mut client, &mut viewer, |_, _| panic!("nothing was asked"));
    let (reached, _) = ask(&mut client, &mut viewer, &[(GetClock::OPCODE, Lane::Immediate, vec![])]);
    assert_eq!(reached, [GetClock::OPCODE]);
}
