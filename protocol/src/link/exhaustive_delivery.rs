//! Both ends of the link against every delivery of the first frames.
//!
//! Each of the first frames, of either direction, comes whole, is lost, is damaged, comes twice or
//! comes late: `5^n` patterns of `n` frames. From there on the wire is clean. A user at each end
//! and the time are part of the world; two worlds that will do the same are followed once.
//! What must hold:
//! * Every message of a session is taken once and in order, or the client opened another session
//!   and knows that it has no answer.
//! * No message of an older session is taken once the client is open.
//! * Nobody acknowledges a message that has not come.
//! * The session continues when the wire is clean, in bounded time and with bounded frames.
//!
//! `LINK_FRAMES=12` tries all patterns of twelve frames and prints the counts.

use super::{Endpoint, HELLO_NS, Identity, LinkState, Opening, RETRY_MAX_NS, Role, SessionPhase};
use crate::Ns;
use std::collections::{HashMap, HashSet, VecDeque};
use std::hash::{DefaultHasher, Hasher};
use std::vec::Vec;
use std::{env, println, vec};

const MS_NS: Ns = 1_000_000;
/// Two messages in flight: few frames reach every state of the window.
const WINDOW: usize = 2;
type End = Endpoint<WINDOW>;
/// From one end to the other.
const TRANSIT: Ns = MS_NS;
/// Frames of a run without the variable.
const FRAMES: u8 = 9;
/// After the last frame with a delivery: an unconfirmed session is asked for again after four
/// tries, then a message may wait for its longest time-out, and for the one after it.
const QUIET_NS: Ns = 8 * HELLO_NS + 4 * RETRY_MAX_NS;
/// The most frames in that time; more is a storm.
const STORM: u16 = 400;

/// What a wire does to a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Delivery {
    Whole,
    Lost,
    Damaged,
    Twice,
    Late,
}

const DELIVERIES: [Delivery; 5] = [Delivery::Whole, Delivery::Lost, Delivery::Damaged, Delivery::Twice, Delivery::Late];

/// How a client comes to its second session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Again {
    /// It does not.
    Never,
    /// A new client, without a word.
    Restarted,
    /// It says Bye first.
    Bye,
    /// The controller is switched off and on; its client begins anew.
    PowerCut,
}

/// What the users at the ends do while the wire has faults.
#[derive(Debug, Clone, Copy)]
struct Schedule {
    name: &'static str,
    /// Messages of a session, and those before the first frame that has a delivery; `None`: the
    /// opening has deliveries too.
    messages: u32,
    before: Option<u32>,
    again: Again,
    /// When, after the beginning.
    after: Ns,
    /// The shortest time between two messages that the controller takes.
    slow: Ns,
    /// Delay of a late frame, and of the second one of two.
    late: Ns,
    second: Ns,
}

const ONE_SESSION: Schedule = Schedule {
    name: "one session from its Hello",
    messages: 5,
    before: None,
    again: Again::Never,
    after: 0,
    slow: 0,
    late: 3 * MS_NS + MS_NS / 2,
    second: MS_NS / 4,
};
/// Late frames come when the session after it is open and has the same numbers.
const OLD_SESSION: Schedule = Schedule {
    name: "a client that begins again, with frames of its old session late",
    messages: 4,
    before: Some(2),
    again: Again::Restarted,
    after: MS_NS + MS_NS / 2,
    slow: 0,
    late: 5 * MS_NS + MS_NS / 2,
    second: 6 * MS_NS + MS_NS / 2,
};
const BYE: Schedule = Schedule { name: "a client that says Bye and opens anew", again: Again::Bye, ..OLD_SESSION };
const POWER_CUT: Schedule =
    Schedule { name: "a controller that is switched off and on", again: Again::PowerCut, ..OLD_SESSION };
/// A Hello or its answer comes when the session after it is asked for, and the controller has
/// messages of the one before.
const OPENED_TWICE: Schedule = Schedule {
    name: "a client that begins again after its first messages",
    before: None,
    after: 5 * MS_NS + MS_NS / 2,
    messages: 3,
    ..OLD_SESSION
};
/// Late frames come after more messages than a window, and the numbers begin again in between.
const WRAP: Schedule = Schedule {
    name: "numbers that begin anew, with frames later than a window",
    messages: 65_534 + 9,
    before: Some(65_534),
    again: Again::Never,
    after: 0,
    slow: 0,
    late: 9 * MS_NS + MS_NS / 2,
    second: 6 * MS_NS + MS_NS / 2,
};
/// Room that a lost Ack reports must be reported again.
const FULL_WINDOW: Schedule = Schedule {
    name: "a window that is full",
    messages: 7,
    before: Some(0),
    again: Again::Never,
    after: 0,
    slow: 20 * MS_NS,
    late: 30 * MS_NS + MS_NS / 2,
    second: 3 * MS_NS,
};

/// A frame, or a part of one, in transit.
#[derive(Debug, Clone)]
struct Flight {
    at: Ns,
    order: u32,
    up: bool,
    bytes: Vec<u8>,
}

/// Both ends, their users, the wire between them and the time.
#[derive(Clone)]
struct World {
    plan: Schedule,
    now: Ns,
    client: End,
    controller: End,
    wire: Vec<Flight>,
    order: u32,
    /// Frames that wait for their delivery, and those that have had it.
    waiting: VecDeque<(bool, Vec<u8>)>,
    judged: u8,
    /// Bytes of an incomplete frame in each end's deframer.
    begun: [Vec<u8>; 2],
    /// The client's session, from 0; messages that it gave to the link, and answers that it has.
    epoch: usize,
    given: u32,
    answered: u32,
    /// When the client begins again, and opens.
    again_at: Option<Ns>,
    open_at: Option<Ns>,
    /// Messages of each of the client's sessions that the controller took, and the session of its
    /// link then.
    taken: [u32; 2],
    session: Option<u32>,
    next_take: Ns,
    /// Once the wire is clean: the latest time for the end of all, and the most frames.
    until: Option<Ns>,
    clean: u16,
}

fn message(epoch: usize, number: u32) -> Vec<u8> {
    let mut bytes = vec![epoch as u8];
    bytes.extend(number.to_le_bytes());
    bytes
}

impl World {
    fn new(plan: Schedule) -> World {
        let mut world = World {
            plan,
            now: 10_000 * MS_NS,
            client: End::new(Role::Client, Identity::OURS),
            controller: End::new(Role::Controller, Identity::OURS),
            wire: Vec::new(),
            order: 0,
            waiting: VecDeque::new(),
            judged: 0,
            begun: [Vec::new(), Vec::new()],
            epoch: 0,
            given: 0,
            answered: 0,
            again_at: None,
            open_at: None,
            taken: [0; 2],
            session: None,
            next_take: 0,
            until: None,
            clean: 0,
        };
        world.client.open(world.now, 1);
        if let Some(before) = plan.before {
            world.plan = Schedule { messages: before, slow: 0, again: Again::Never, ..plan };
            let mut frames = 0;
            while world.next_frame() {
                world.fly(Delivery::Whole);
                frames += 1;
                assert!(frames < 4 * before + 20, "a clean wire takes so many frames: {world:?}");
                if world.over() {
                    break;
                }
            }
            assert_eq!((world.taken, world.answered), ([before, 0], before));
            world.plan = plan;
        }
        world.again_at = (plan.again != Again::Never).then_some(world.now + plan.after);
        world
    }

    /// All that the client wants is done.
    fn over(&self) -> bool {
        self.again_at.is_none()
            && self.open_at.is_none()
            && self.client.state() == LinkState::Open
            && self.answered == self.plan.messages
            && self.client.all_acknowledged()
            && self.controller.all_acknowledged()
    }

    /// Continues until a frame waits for its delivery; `false` when all is over.
    fn next_frame(&mut self) -> bool {
        loop {
            if self.waiting.is_empty() {
                self.act();
                self.transmit();
            }
            if !self.waiting.is_empty() {
                return true;
            }
            if self.until.is_some() && self.over() && self.wire.is_empty() {
                return false;
            }
            let next = self.next_event().expect("nothing will ever happen");
            self.now = self.now.max(next);
            assert!(self.until.is_none_or(|until| self.now <= until), "the session does not go on: {self:?}");
            while let Some(first) = self.arrived() {
                self.deliver(&first);
            }
        }
    }

    fn next_event(&self) -> Option<Ns> {
        let taking = (self.controller.message().is_some() && self.next_take > self.now).then_some(self.next_take);
        let script = [self.again_at, self.open_at, taking];
        let ends = [self.client.next_deadline(), self.controller.next_deadline()];
        script.into_iter().chain(ends).flatten().chain(self.wire.iter().map(|flight| flight.at)).min()
    }

    fn arrived(&mut self) -> Option<Flight> {
        let first = (0..self.wire.len()).min_by_key(|&i| (self.wire[i].at, self.wire[i].order))?;
        (self.wire[first].at <= self.now).then(|| self.wire.remove(first))
    }

    fn deliver(&mut self, flight: &Flight) {
        let begun = &mut self.begun[usize::from(flight.up)];
        match flight.bytes.iter().rposition(|&byte| byte == 0) {
            Some(end) => *begun = flight.bytes[end + 1..].to_vec(),
            None => begun.extend(&flight.bytes),
        }
        let end = if flight.up { &mut self.controller } else { &mut self.client };
        end.feed(self.now, &flight.bytes);
        self.see_acknowledgements();
        self.act();
    }

    /// No end has an acknowledgement for a message that the other end has not got.
    fn see_acknowledgements(&self) {
        if self.client.session != 0 && self.client.session == self.controller.session {
            for (sender, receiver) in [(&self.client, &self.controller), (&self.controller, &self.client)] {
                let (base, next) = (sender.transmitter.base(), receiver.receiver.next());
                assert!(
                    super::transmit::ahead(next, base).is_some(),
                    "{base} acknowledged, {next} have come: {self:?}"
                );
            }
        }
    }

    /// The users at both ends, and restarts.
    fn act(&mut self) {
        if self.again_at.is_some_and(|at| at <= self.now) {
            self.again_at = None;
            let wait = match self.plan.again {
                Again::Bye => {
                    self.client.close();
                    MS_NS / 2
                }
                Again::PowerCut => {
                    self.controller = End::new(Role::Controller, Identity::OURS);
                    self.begun[1].clear();
                    self.session = None;
                    2 * MS_NS
                }
                Again::Restarted | Again::Never => 0,
            };
            self.open_at = Some(self.now + wait);
        }
        if self.open_at.is_some_and(|at| at <= self.now) {
            // The client knows which messages of the last session have no answer.
            assert!(self.answered <= self.taken[0] && self.taken[0] <= self.given);
            (self.open_at, self.epoch, self.given, self.answered) = (None, 1, 0, 0);
            if self.plan.again == Again::Restarted {
                self.client = End::new(Role::Client, Identity::OURS);
                self.begun[0].clear();
            }
            self.client.open(self.now, 2);
        }
        self.take();
        while self.given < self.plan.messages && self.client.can_send() {
            self.client.send(&message(self.epoch, self.given)).expect("it can be sent");
            self.given += 1;
        }
        while let Some(answer) = self.client.message() {
            assert_eq!(answer, message(self.epoch, self.answered), "the answer to another message: {self:?}");
            self.client.done_with_message();
            self.answered += 1;
            assert!(self.answered <= self.taken[self.epoch], "an answer to what was not taken: {self:?}");
        }
    }

    /// The controller's user takes a message and answers it.
    fn take(&mut self) {
        if self.controller.session() != self.session {
            self.session = self.controller.session();
            self.next_take = self.now;
        }
        while self.now >= self.next_take
            && let Some((came, draft)) = self.controller.message_and_draft()
        {
            let epoch = usize::from(came[0]);
            let expected = message(epoch, self.taken[epoch]);
            assert_eq!(came, expected, "a message twice, out of order or not whole");
            let length = came.len();
            draft[..length].copy_from_slice(came);
            self.controller.send_draft(length).expect("there was a draft");
            self.controller.done_with_message();
            self.taken[epoch] += 1;
            let open = self.client.state() == LinkState::Open && self.open_at.is_none();
            assert!(!open || epoch == self.epoch, "a message of an old session: {self:?}");
            self.next_take = self.now + self.plan.slow;
        }
    }

    /// Frames leave one by one.
    fn transmit(&mut self) {
        for up in [true, false] {
            let mut bytes = [0; 512];
            let end = if up { &mut self.client } else { &mut self.controller };
            let length = end.take_tx(self.now, &mut bytes);
            self.waiting.extend(bytes[..length].split_inclusive(|&byte| byte == 0).map(|frame| (up, frame.to_vec())));
        }
    }

    /// The next frame meets its delivery.
    fn fly(&mut self, delivery: Delivery) {
        let Some((up, mut bytes)) = self.waiting.pop_front() else { return };
        let mut arrive = |late: Ns, bytes: Vec<u8>| {
            self.wire.push(Flight { at: self.now + TRANSIT + late, order: self.order, up, bytes });
            self.order += 1;
        };
        match delivery {
            Delivery::Whole => arrive(0, bytes),
            Delivery::Lost => {}
            Delivery::Damaged => {
                // A bit is turned, the delimiter is missing, or there is one more.
                let middle = bytes.len() / 2;
                match self.judged % 3 {
                    0 => bytes[middle] ^= 0x40,
                    1 => bytes.truncate(bytes.len() - 1),
                    _ => bytes[middle] = 0,
                }
                arrive(0, bytes);
            }
            Delivery::Twice => {
                arrive(0, bytes.clone());
                arrive(self.plan.second, bytes);
            }
            Delivery::Late => arrive(self.plan.late, bytes),
        }
        if let Some(until) = self.until {
            self.clean += 1;
            assert!(self.clean < STORM, "a storm of frames until {until}: {self:?}");
        }
    }

    /// To the end over a clean wire.
    fn finish(&mut self) {
        self.until = Some(self.now + QUIET_NS);
        while self.next_frame() {
            self.fly(Delivery::Whole);
        }
        let last = usize::from(self.plan.again != Again::Never);
        assert_eq!(self.taken[last], self.plan.messages, "not all messages were taken: {self:?}");
        assert_eq!(self.client.session(), self.controller.session(), "two sessions: {self:?}");
    }

    /// Everything that decides the further course.
    fn state(&self) -> u128 {
        let mut bytes = Vec::with_capacity(600);
        let at = |at: Option<Ns>| at.map_or(Ns::MAX, |at| at.saturating_sub(self.now));
        bytes.push(self.judged);
        for (end, begun) in [(&self.client, &self.begun[0]), (&self.controller, &self.begun[1])] {
            end_state(end, self.now, &mut bytes);
            bytes.push(begun.len() as u8);
            bytes.extend(begun);
        }
        let mut wire: Vec<&Flight> = self.wire.iter().collect();
        wire.sort_by_key(|flight| (flight.at, flight.order));
        let waiting = self.waiting.iter().map(|(up, frame)| (0, *up, frame));
        let flights = wire.into_iter().map(|flight| (flight.at - self.now, flight.up, &flight.bytes));
        for (at, up, frame) in flights.chain(waiting) {
            bytes.extend(at.to_le_bytes());
            bytes.extend([up.into(), frame.len() as u8]);
            bytes.extend(frame);
        }
        let numbers = [self.given, self.answered, self.taken[0], self.taken[1], self.epoch as u32];
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let times = [at(self.again_at), at(self.open_at), self.next_take.saturating_sub(self.now)];
        bytes.extend(times.iter().flat_map(|time| time.to_le_bytes()));
        bytes.push((self.session == self.controller.session()).into());
        let half = |seed: u8| {
            let mut hasher = DefaultHasher::new();
            hasher.write_u8(seed);
            hasher.write(&bytes);
            u128::from(hasher.finish())
        };
        half(0) << 64 | half(1)
    }
}

/// An end without its counters, and with instants that count from `now`.
fn end_state(end: &End, now: Ns, into: &mut Vec<u8>) {
    let opening = end.state == LinkState::Opening;
    let (state, tries) = match (&end.state, end.phase) {
        (LinkState::Closed, _) => (0, 0),
        (LinkState::Opening, SessionPhase::Asking) => (1, 0),
        (LinkState::Opening, SessionPhase::Confirming(tries)) => (2, tries),
        (LinkState::Open, _) => (3, 0),
        (LinkState::Ended, _) => (4, 0),
        (LinkState::Mismatch(_) | LinkState::Busy(_) | LinkState::NoReadOnly, _) => panic!("no other client is there"),
    };
    into.extend([state, tries, end.hello_due.into(), end.keep_alive_due.into(), (end.wire_at < end.wire_len).into()]);
    let offer = end.offer.map_or([0; 3], |offer| [offer.nonce, offer.session, offer.window.into()]);
    let answer = end.answer.map_or(0, |(nonce, answer)| match answer {
        Opening::Ack(ack) => nonce ^ ack.session.get(),
        Opening::Busy(_) => nonce,
    });
    let numbers = [end.nonce, end.session, end.offers_made, answer, end.bye.unwrap_or(0)];
    into.extend(offer.iter().chain(&numbers).flat_map(|number| number.to_le_bytes()));
    let times = [if opening { end.retry_at } else { now }, end.last_sent];
    into.extend(times.iter().flat_map(|time| time.wrapping_sub(now).to_le_bytes()));
    end.transmitter.state(now, into);
    end.receiver.state(into);
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "at {} us, session {} of the client: given {}, answered {}, taken {:?}, states {:?} {:?}, sessions {} {}, {} under way",
            self.now / 1_000,
            self.epoch,
            self.given,
            self.answered,
            self.taken,
            self.client.state(),
            self.controller.state(),
            self.client.session,
            self.controller.session,
            self.wire.len()
        )
    }
}

/// States that were visited.
#[derive(Default)]
struct Seen {
    states: HashSet<u128>,
    ends: u64,
    /// Fates that led to the present state, for the reader of a failure.
    deliveries: Vec<Delivery>,
}

fn follow(world: &mut World, frames: u8, seen: &mut Seen) {
    assert!(world.next_frame(), "a client that is open is not silent for ever");
    if !seen.states.insert(world.state()) {
        return;
    }
    if world.judged == frames {
        seen.ends += 1;
        return world.finish();
    }
    for delivery in DELIVERIES {
        let mut world = world.clone();
        seen.deliveries.push(delivery);
        world.fly(delivery);
        world.judged += 1;
        follow(&mut world, frames, seen);
        seen.deliveries.pop();
    }
}

/// Names the pattern when a world fails.
impl Drop for Seen {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("the deliveries were {:?}", self.deliveries);
        }
    }
}

fn every_delivery(plan: Schedule) {
    let frames = env::var("LINK_FRAMES").map_or(FRAMES, |frames| frames.parse().expect("LINK_FRAMES is a number"));
    let mut seen = Seen::default();
    follow(&mut World::new(plan), frames, &mut seen);
    let patterns = 5u64.pow(frames.into());
    println!("{}: {patterns} patterns of {frames} frames, {} states, {} ends", plan.name, seen.states.len(), seen.ends);
    assert!(seen.ends > u64::from(frames), "the deliveries made no difference");
}

#[test]
fn every_delivery_of_the_frames_of_one_session() {
    every_delivery(ONE_SESSION);
}

#[test]
fn every_delivery_where_an_old_session_is_late() {
    every_delivery(OLD_SESSION);
}

#[test]
fn every_delivery_of_two_openings() {
    every_delivery(OPENED_TWICE);
}

#[test]
fn every_delivery_around_a_bye() {
    every_delivery(BYE);
}

#[test]
fn every_delivery_around_a_power_cut() {
    every_delivery(POWER_CUT);
}

#[test]
fn every_delivery_where_numbers_begin_anew() {
    every_delivery(WRAP);
}

#[test]
fn every_delivery_of_a_full_window() {
    every_delivery(FULL_WINDOW);
}

/// Worlds are followed once because those of one state do the same: here each pattern is followed
/// by itself.
#[test]
fn worlds_of_one_state_do_the_same() {
    const FIRST: u8 = 5;
    for plan in [ONE_SESSION, OLD_SESSION, OPENED_TWICE, BYE, POWER_CUT, WRAP, FULL_WINDOW] {
        let mut world = World::new(plan);
        assert!(world.next_frame());
        let (mut worlds, mut known) = (vec![world], HashMap::new());
        for _ in 0..FIRST {
            let mut next = Vec::with_capacity(worlds.len() * DELIVERIES.len());
            for (world, delivery) in worlds.iter().flat_map(|world| DELIVERIES.map(|delivery| (world, delivery))) {
                let mut world = world.clone();
                world.fly(delivery);
                world.judged += 1;
                assert!(world.next_frame());
                next.push(world);
            }
            worlds = next;
        }
        let patterns = worlds.len();
        for mut world in worlds {
            let (state, from) = (world.state(), world.now);
            world.finish();
            let end = (world.now - from, world.clean, world.taken);
            assert_eq!(*known.entry(state).or_insert(end), end, "{}", plan.name);
        }
        assert!(known.len() < patterns, "{}: nothing was followed twice", plan.name);
    }
}
