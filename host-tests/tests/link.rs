//! The link over a faulty channel, in simulated time: a seeded channel that loses, damages, doubles
//! and reorders a tenth of all frames each way. Every command must be executed exactly once and in
//! order, every reply must come exactly once and in order. The same harness must find fault with
//! links that are broken on purpose, or it would prove nothing.

#[path = "../../servo/tests/chance/mod.rs"]
mod chance;

use chance::Chance;
use protocol::Ns;
use protocol::command::{Nothing, SetPos};
use protocol::deframe::{Deframer, Outcome};
use protocol::frame::{self, FrameKind, Header, MAX_PAYLOAD, MAX_WIRE, OVERHEAD};
use protocol::link::{Endpoint, Identity, LinkState, Role};
use protocol::record::{Lane, ReplyWriter, RequestWriter, replies, requests};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use zerocopy::FromBytes;

const MS: Ns = 1_000_000;
const WINDOW: usize = 8;
type End = Endpoint<WINDOW>;

/// How bad a channel is, in percent of the frames.
#[derive(Clone, Copy)]
struct Faults {
    loss: u64,
    damage: u64,
    doubling: u64,
    reordering: u64,
    /// A late frame is late by up to this.
    late_by: Ns,
}

const TENTH: Faults = Faults { loss: 10, damage: 10, doubling: 10, reordering: 10, late_by: 20 * MS };
const CLEAN: Faults = Faults { loss: 0, damage: 0, doubling: 0, reordering: 0, late_by: 0 };

/// One direction: frames under way, each with the instant of its arrival.
struct Channel {
    random: Chance,
    faults: Faults,
    cut: bool,
    under_way: BinaryHeap<Reverse<(Ns, u64, Vec<u8>)>>,
    count: u64,
    lost: u64,
    damaged: u64,
    doubled: u64,
    reordered: u64,
}

impl Channel {
    fn new(seed: u64, faults: Faults) -> Self {
        let random = Chance::new(seed);
        let under_way = BinaryHeap::new();
        Channel { random, faults, cut: false, under_way, count: 0, lost: 0, damaged: 0, doubled: 0, reordered: 0 }
    }

    fn put(&mut self, now: Ns, bytes: &[u8]) {
        for frame in bytes.split_inclusive(|&byte| byte == 0) {
            self.count += 1;
            if self.cut || self.random.percent(self.faults.loss) {
                self.lost += 1;
                continue;
            }
            let copies = if self.random.percent(self.faults.doubling) { 2 } else { 1 };
            self.doubled += copies - 1;
            for _ in 0..copies {
                let mut frame = frame.to_vec();
                if self.random.percent(self.faults.damage) {
                    self.damaged += 1;
                    for _ in 0..=self.random.below(3) {
                        let at = self.random.below(frame.len() as u64) as usize;
                        frame[at] ^= 1 << self.random.below(8);
                    }
                }
                let mut at = now + MS;
                if self.random.percent(self.faults.reordering) {
                    self.reordered += 1;
                    at += self.random.below(self.faults.late_by);
                }
                self.under_way.push(Reverse((at, self.count, frame)));
            }
        }
    }

    fn next_at(&self) -> Option<Ns> {
        self.under_way.peek().map(|Reverse((at, ..))| *at)
    }

    fn arrived(&mut self, now: Ns) -> Option<Vec<u8>> {
        if self.next_at()? > now {
            return None;
        }
        self.under_way.pop().map(|Reverse((_, _, frame))| frame)
    }
}

/// What stands between the channel and the controller's end: nothing, or something that breaks it.
trait Inlet {
    /// Passes received bytes on. What it returns reaches the controller's user beside the link.
    fn pass(&mut self, end: &mut End, now: Ns, bytes: &[u8]) -> Vec<Vec<u8>>;
}

/// The link as it is.
struct Honest;

impl Inlet for Honest {
    fn pass(&mut self, end: &mut End, now: Ns, bytes: &[u8]) -> Vec<Vec<u8>> {
        end.feed(now, bytes);
        Vec::new()
    }
}

/// Frames of a stream with header and payload, whether or not the CRC fits.
fn frames(deframer: &mut Deframer<MAX_WIRE>, bytes: &[u8], mut each: impl FnMut(Header, &[u8], bool)) {
    let mut rest = bytes;
    while !rest.is_empty() {
        let (used, outcome) = deframer.feed(rest);
        rest = &rest[used..];
        if outcome == Outcome::Frame && deframer.frame().len() >= OVERHEAD {
            let frame = deframer.frame();
            let (header, payload) = Header::read_from_prefix(&frame[..frame.len() - 4]).unwrap();
            each(header, payload, frame::decode(frame).is_ok());
        }
    }
}

fn feed_again(end: &mut End, now: Ns, header: Header, payload: &[u8]) {
    let mut wire = [0; MAX_WIRE];
    let length = frame::encode(header, payload, &mut wire).unwrap();
    end.feed(now, &wire[..length]);
}

/// Takes damaged frames as good.
struct NoChecksum(Deframer<MAX_WIRE>);

impl Inlet for NoChecksum {
    fn pass(&mut self, end: &mut End, now: Ns, bytes: &[u8]) -> Vec<Vec<u8>> {
        frames(&mut self.0, bytes, |header, payload, _| feed_again(end, now, header, payload));
        Vec::new()
    }
}

/// Hands a message on as often as it comes.
struct NoDuplicateSuppression(Deframer<MAX_WIRE>);

impl Inlet for NoDuplicateSuppression {
    fn pass(&mut self, end: &mut End, now: Ns, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut again = Vec::new();
        let before = end.counters().received as u16;
        frames(&mut self.0, bytes, |header, payload, good| {
            let old = before.wrapping_sub(header.sequence.get()).wrapping_sub(1) < 100;
            let mine = Some(header.session.get()) == end.session();
            if good && mine && old && header.kind == FrameKind::Data as u8 {
                again.push(payload.to_vec());
            }
        });
        end.feed(now, bytes);
        again
    }
}

/// Takes messages in the order in which they come.
struct NoOrder(Deframer<MAX_WIRE>, u16);

impl Inlet for NoOrder {
    fn pass(&mut self, end: &mut End, now: Ns, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut next = self.1;
        frames(&mut self.0, bytes, |mut header, payload, good| {
            if good && header.kind == FrameKind::Data as u8 && header.sequence.get().wrapping_sub(next) < 100 {
                header.sequence = next.into();
                next = next.wrapping_add(1);
            }
            if good {
                feed_again(end, now, header, payload);
            }
        });
        self.1 = next;
        Vec::new()
    }
}

/// Takes frames of every session for frames of the present one.
struct EverySession(Deframer<MAX_WIRE>);

impl Inlet for EverySession {
    fn pass(&mut self, end: &mut End, now: Ns, bytes: &[u8]) -> Vec<Vec<u8>> {
        frames(&mut self.0, bytes, |mut header, payload, good| {
            if let Some(session) = end.session()
                && header.kind == FrameKind::Data as u8
            {
                header.session = session.into();
            }
            if good {
                feed_again(end, now, header, payload);
            }
        });
        Vec::new()
    }
}

/// What a run is to do.
#[derive(Clone, Copy)]
struct Plan {
    seed: u64,
    commands: u32,
    faults: Faults,
    /// The client begins a new session after every so many replies.
    restart_after: Option<u32>,
    /// The channel is cut from the first instant to the second.
    cut: Option<(Ns, Ns)>,
}

impl Plan {
    fn new(seed: u64, commands: u32) -> Self {
        Plan { seed, commands, faults: TENTH, restart_after: None, cut: None }
    }
}

/// What a run has shown.
#[derive(Debug)]
struct Shown {
    took: Ns,
    executed: u32,
    longest_silence: Ns,
    sessions: u32,
    counters: protocol::link::LinkCounters,
    channel: [u64; 4],
}

/// Client and controller with their users. A command is a SetPos whose `profile` is the session's
/// number (from 1) and whose `pos` counts from 0; the reply carries the same count.
struct Bench<I> {
    plan: Plan,
    random: Chance,
    client: End,
    controller: End,
    inlet: I,
    up: Channel,
    down: Channel,
    now: Ns,
    /// Present session's number, next command to send, next reply to come.
    run: i16,
    sent: u32,
    replied: u32,
    /// Controller: session's number and next command expected in it.
    at_run: i16,
    expected: u32,
    executed: u32,
    /// The controller's user takes nothing before this instant.
    busy_until: Ns,
    longest_silence: Ns,
}

impl<I: Inlet> Bench<I> {
    fn new(plan: Plan, inlet: I) -> Self {
        Bench {
            plan,
            random: Chance::new(plan.seed),
            client: End::new(Role::Client, Identity::OURS),
            controller: End::new(Role::Controller, Identity::OURS),
            inlet,
            up: Channel::new(plan.seed ^ 1, plan.faults),
            down: Channel::new(plan.seed ^ 2, plan.faults),
            now: 0,
            run: 0,
            sent: 0,
            replied: 0,
            at_run: 0,
            expected: 0,
            executed: 0,
            busy_until: 0,
            longest_silence: 0,
        }
    }

    fn open(&mut self) {
        self.run += 1;
        self.sent = 0;
        self.replied = 0;
        let nonce = self.random.next() as u32;
        self.client.open(self.now, nonce);
    }

    fn go(mut self) -> Result<Shown, String> {
        self.open();
        let limit = 3_600_000 * MS;
        let mut done = 0;
        while done + self.replied < self.plan.commands {
            self.step()?;
            if self.plan.restart_after.is_some_and(|after| self.replied >= after) {
                done += self.replied;
                self.open();
            }
            if self.now > limit {
                return Err(format!("stuck: {} of {} replies after an hour", self.replied, self.plan.commands));
            }
        }
        // Whatever is still under way must not do anything any more.
        let executed = self.executed;
        let end = self.now + 2_000 * MS;
        while self.now < end {
            self.step()?;
        }
        if self.plan.restart_after.is_none() && (self.executed != executed || executed != self.plan.commands) {
            return Err(format!("{} commands, {executed} executed, {} at last", self.plan.commands, self.executed));
        }
        Ok(Shown {
            took: self.now,
            executed: self.executed,
            longest_silence: self.longest_silence,
            sessions: self.controller.counters().sessions,
            counters: self.controller.counters(),
            channel: [self.up.lost, self.up.damaged, self.up.doubled, self.up.reordered],
        })
    }

    /// Goes to the next instant at which something happens.
    fn step(&mut self) -> Result<(), String> {
        let wake = (self.busy_until > self.now).then_some(self.busy_until);
        let next = [
            self.up.next_at(),
            self.down.next_at(),
            self.client.next_deadline(),
            self.controller.next_deadline(),
            wake,
        ];
        // A state that is due stays due until it is transmitted, which happens below.
        let next = next.into_iter().flatten().min().unwrap_or(self.now + MS);
        self.now = next.max(self.now + 1_000);
        let cut = self.plan.cut.is_some_and(|(from, to)| (from..to).contains(&self.now));
        self.up.cut = cut;
        self.down.cut = cut;
        if let Some(silence) = self.controller.silence(self.now) {
            self.longest_silence = self.longest_silence.max(silence);
        }
        while let Some(bytes) = self.up.arrived(self.now) {
            // In portions, as a transport would hand them over.
            let at = self.random.below(bytes.len() as u64 + 1) as usize;
            for part in [&bytes[..at], &bytes[at..]] {
                for message in self.inlet.pass(&mut self.controller, self.now, part) {
                    let mut nowhere = [0; MAX_PAYLOAD];
                    self.execute(&message, &mut nowhere)?;
                }
            }
        }
        while let Some(bytes) = self.down.arrived(self.now) {
            self.client.feed(self.now, &bytes);
        }
        self.serve()?;
        self.use_client()?;
        let mut wire = [0; 4 * MAX_WIRE];
        loop {
            let count = self.client.take_tx(self.now, &mut wire);
            self.up.put(self.now, &wire[..count]);
            if count < wire.len() {
                break;
            }
        }
        loop {
            let count = self.controller.take_tx(self.now, &mut wire);
            self.down.put(self.now, &wire[..count]);
            if count < wire.len() {
                break;
            }
        }
        Ok(())
    }

    /// The controller's user: takes messages when it can answer them, and is busy now and then, so
    /// that the window closes.
    fn serve(&mut self) -> Result<(), String> {
        while self.now >= self.busy_until && self.controller.can_send() {
            let Some(message) = self.controller.message().map(<[u8]>::to_vec) else { break };
            let mut answer = [0; MAX_PAYLOAD];
            let length = self.execute(&message, &mut answer)?;
            self.controller.done_with_message();
            self.controller.send(&answer[..length]).map_err(|error| format!("{error:?}"))?;
            if self.random.below(200) == 0 {
                self.busy_until = self.now + 300 * MS;
            }
        }
        Ok(())
    }

    fn execute(&mut self, message: &[u8], answer: &mut [u8]) -> Result<usize, String> {
        let mut writer = ReplyWriter::new(answer);
        for record in requests(message) {
            let record = record.map_err(|error| format!("{error:?}"))?;
            let (command, _) = record.parse::<SetPos>().map_err(|refusal| format!("{refusal:?}"))?;
            let (run, count) = (command.profile.get(), command.pos.get() as u32);
            if run != self.at_run {
                if run < self.at_run {
                    return Err(format!("command {count} of session {run} executed in session {}", self.at_run));
                }
                self.at_run = run;
                self.expected = 0;
            }
            if self.client.state() == LinkState::Open && run != self.run {
                return Err(format!("command {count} of session {run} executed when {} was open", self.run));
            }
            if count != self.expected || command.core.get() != check(run, count) || record.tag != count as u16 {
                return Err(format!("command {count} executed when {} was due", self.expected));
            }
            self.expected += 1;
            self.executed += 1;
            writer.done::<SetPos>(record.tag, &Nothing {}, &[]).map_err(|error| format!("{error:?}"))?;
        }
        Ok(writer.len())
    }

    /// The client's user: sends as much as it may, and checks the replies.
    fn use_client(&mut self) -> Result<(), String> {
        while let Some(message) = self.client.message() {
            for reply in replies(message) {
                let reply = reply.map_err(|error| format!("{error:?}"))?;
                reply.parse::<SetPos>().map_err(|error| format!("{error:?}"))?;
                if reply.tag != self.replied as u16 {
                    return Err(format!("reply {} came when {} was due", reply.tag, self.replied));
                }
                self.replied += 1;
            }
            self.client.done_with_message();
        }
        while self.sent < self.plan.commands && self.client.can_send() {
            let mut message = [0; MAX_PAYLOAD];
            let mut writer = RequestWriter::new(&mut message);
            for _ in 0..=self.random.below(30) {
                if self.sent == self.plan.commands {
                    break;
                }
                let (run, count) = (self.run, self.sent);
                let command =
                    SetPos { core: check(run, count).into(), profile: run.into(), pos: (count as i32).into() };
                writer.push(Lane::Immediate, count as u16, &command, &[]).map_err(|error| format!("{error:?}"))?;
                self.sent += 1;
            }
            let length = writer.len();
            self.client.send(&message[..length]).map_err(|error| format!("{error:?}"))?;
        }
        Ok(())
    }
}

/// Something of a command that a damaged one has not.
fn check(run: i16, count: u32) -> i16 {
    (Chance::new((run as u64) << 32 | u64::from(count)).next() >> 48) as i16
}

#[test]
fn a_hundred_thousand_commands_arrive_exactly_once_and_in_order() {
    let published = Bench::new(Plan::new(0x5EED, 100_000), Honest).go().unwrap();
    assert_eq!(published.executed, 100_000);
    // The channel did what it was asked to, and the link met all of it.
    assert!(published.channel.iter().all(|&count| count > 500), "{published:?}");
    let seen = published.counters;
    assert!(
        seen.checksum > 100 && seen.duplicates > 100 && seen.timeouts > 10 && seen.fast_retransmits > 10,
        "{seen:?}"
    );
    println!("{published:#?}");
}

#[test]
fn every_seed_passes() {
    for seed in 0..50 {
        let published = Bench::new(Plan::new(seed, 1_000), Honest).go();
        assert!(published.is_ok(), "seed {seed}: {published:?}");
    }
}

#[test]
fn a_clean_channel_repeats_nothing() {
    let published = Bench::new(Plan { faults: CLEAN, ..Plan::new(7, 20_000) }, Honest).go().unwrap();
    assert_eq!(published.counters.duplicates, 0, "{published:?}");
    assert_eq!(published.counters.timeouts, 0, "{published:?}");
    assert_eq!(published.counters.beyond_window, 0, "{published:?}");
}

#[test]
fn a_link_without_checksum_is_caught() {
    let published = Bench::new(Plan::new(1, 100_000), NoChecksum(Deframer::new())).go();
    assert!(published.is_err(), "{published:?}");
}

#[test]
fn a_link_without_duplicate_suppression_is_caught() {
    let published = Bench::new(Plan::new(1, 100_000), NoDuplicateSuppression(Deframer::new())).go();
    assert!(published.as_ref().is_err_and(|error| error.contains("was due")), "{published:?}");
}

#[test]
fn a_link_without_order_is_caught() {
    let published = Bench::new(Plan::new(1, 100_000), NoOrder(Deframer::new(), 0)).go();
    assert!(published.as_ref().is_err_and(|error| error.contains("was due")), "{published:?}");
}

/// Restarts in mid-stream, with old frames coming in for half a second afterwards.
fn restarts(seed: u64) -> Plan {
    let faults = Faults { late_by: 500 * MS, ..TENTH };
    Plan { faults, restart_after: Some(150), ..Plan::new(seed, 20_000) }
}

#[test]
fn a_restart_in_mid_stream_never_executes_what_is_stale() {
    let published = Bench::new(restarts(3), Honest).go().unwrap();
    assert!(published.sessions > 50, "{published:?}");
    assert!(published.counters.stale_session > 100, "old frames must have come: {published:?}");
}

#[test]
fn a_link_that_takes_every_session_is_caught() {
    let published = Bench::new(restarts(3), EverySession(Deframer::new())).go();
    assert!(published.is_err(), "{published:?}");
}

#[test]
fn a_cut_of_five_seconds_is_seen_and_survived() {
    let plan = Plan { cut: Some((500 * MS, 5_500 * MS)), ..Plan::new(11, 20_000) };
    let published = Bench::new(plan, Honest).go().unwrap();
    assert_eq!(published.executed, 20_000);
    assert!(published.longest_silence > 4_000 * MS, "{published:?}");
    let uncut = Bench::new(Plan { cut: None, ..plan }, Honest).go().unwrap();
    // A tenth lost and a tenth damaged, five keep-alives in a row may fail; a cut of seconds stands
    // out.
    assert!(uncut.longest_silence < 1_000 * MS, "{uncut:?}");
    assert!(published.took > uncut.took + 3_000 * MS, "the cut must cost its time: {published:?} {uncut:?}");
}
