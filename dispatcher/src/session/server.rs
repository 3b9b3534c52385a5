//! The server: one end of the host link and all that uses it.
//!
//! In: bytes and the time. Out: bytes, the time of the next poll.
//! Owns: the link's end, the message in hand, the replies being gathered into the next message.
//! Lane 0 goes to the command handler, lane 1 to the program queue.
//! Budget: a poll handles at most a window of messages.
//! Fails: what is not a record is refused with `Length`. A link that falls silent stops Jog axes
//! and drops the rest of a program (SPEC 9).
use super::commands::CommandHandler;
use super::link_loss;
use crate::admit::admission::Admission;
use crate::board::BoardConstants;
use crate::plan::path_queue::PathQueue;
use crate::program::{Poll, Program};
use crate::report::answer::Refuser;
use crate::report::event_log::EventKind;
use crate::report::pending_replies::RecordOutcome;
use protocol::command::opcode;
use protocol::frame::OPENING_WIRE;
use protocol::link::{Endpoint, Identity, Role, TakeOver};
use protocol::record::{Lane, ReplyHead, ReplyWriter, RequestRecord, TRACE_RECORD, requests};
use protocol::viewer::Answered;
use ring::{Consumer, Producer, Reader};
use servo::path::PathStores;
use servo::segment::pt::SegmentStore;
use servo::tables::TableStores;
pub use servo::tick::{EVENTS, IMMEDIATE_ENTRIES, PROGRAM_ENTRIES, SEGMENTS, TRACE_SAMPLES};
use servo::tick_command::{Lane as TickLane, LaneEntry};
use servo::units::Ns;
use servo::view::{Event, Sample, View};
use zerocopy::IntoBytes;

pub use crate::capacity::LINK_WINDOW;
/// Passes of a poll: each moves the program, the message in hand and the replies as far as
/// possible.
const POLL_PASSES: u32 = 16;

/// Rows wait this long for more of them, before a message that is not full carries them.
const TRACE_FLUSH_NS: u64 = 20_000_000;
/// The head of a record of trace.
const TRACE_HEAD_BYTES: usize = size_of::<ReplyHead>();

/// The thread's halves of the queues between thread and tick.
pub struct ThreadHalves<'a, const AXES: usize> {
    /// Tick commands for the next tick.
    pub immediate: Producer<'a, LaneEntry, IMMEDIATE_ENTRIES>,
    /// Timed tick commands of a program.
    pub program: Producer<'a, LaneEntry, PROGRAM_ENTRIES>,
    /// The newest view.
    pub view: Reader<'a, View<AXES>>,
    /// Events.
    pub events: Consumer<'a, Event, EVENTS>,
    /// Trace samples.
    pub samples: Consumer<'a, Sample, TRACE_SAMPLES>,
    /// PT segments of every axis.
    pub stores: &'a [SegmentStore; AXES],
    /// FIFOs of coordinate systems, as the tick has them.
    pub paths: PathStores<'a>,
    /// The look-aheads that feed them, one each.
    pub queues: &'a mut [[PathQueue; 2]],
    /// PVT tables.
    pub tables: TableStores<'a>,
}

servo::state! {
    /// The thread's side of a controller. `AXES` is the capacity of the build.
    pub struct Server<'a, const AXES: usize> {
        link: Endpoint<LINK_WINDOW> = Endpoint::new(Role::Controller, Identity::OURS),
        pub(crate) handler: CommandHandler<'a, AXES> = CommandHandler::new(Admission::new(
                board,
                channels.stores,
                (channels.paths, channels.queues),
                channels.tables,
                channels.immediate,
            )),
        pub(crate) program: Program<'a> = Program::new(channels.program),
        view: Reader<'a, View<AXES>> = channels.view,
        events: Consumer<'a, Event, EVENTS> = channels.events,
        samples: Consumer<'a, Sample, TRACE_SAMPLES> = channels.samples,
        /// The time of the last call that gave it.
        time: Ns = Ns(0),
        session: Option<u32> = None,
        /// When the last valid frame came, of this session or the last one.
        heard: Option<u64> = None,
        /// The link is lost: axes were stopped.
        lost: bool = false,
        /// A session has begun, and the tick does not know yet.
        begins: bool = false,
        /// Records of the message in hand that are done.
        at: usize = 0,
        outbox: [u8; protocol::MAX_PAYLOAD] = [0; protocol::MAX_PAYLOAD],
        outbox_len: usize = 0,
        /// When the link carried trace last.
        traced_at: u64 = 0,
    }
    /// A server at power-on: no session, every axis in its power-on state.
    pub fn new(board: BoardConstants, channels: ThreadHalves<'a, AXES>);
}

impl<'a, const AXES: usize> Server<'a, AXES> {
    /// Takes bytes from the wire; always takes all of them.
    pub fn feed(&mut self, now: Ns, bytes: &[u8]) {
        self.time = now;
        self.link.feed(now.0, bytes);
    }

    /// Takes a decoded frame of a wire that the link is not on: [`Endpoint::request_take_over`].
    pub fn request_take_over(
        &mut self,
        now: Ns,
        frame: &[u8],
        holder: Option<&str>,
        out: &mut [u8; OPENING_WIRE],
    ) -> TakeOver {
        self.time = now;
        self.link.request_take_over(now.0, frame, holder, out)
    }

    /// Does what can be done now: timers, messages, records, waiting program entries, replies. Call
    /// it after `feed`, after every tick, and at [`Server::next_deadline`].
    #[inline(never)] // Tests of the images stop here.
    pub fn poll(&mut self, now: Ns) {
        self.time = now;
        self.link.poll(now.0);
        let view = self.view.read();
        // The events of a view are in their ring before it is published, so none is missed.
        while let Some(event) = self.events.pop() {
            let (lane, seq, refuser) = match event {
                Event::Refused { lane, seq, axis, status } => (lane, seq, Refuser::Axis(axis, status)),
                Event::CrdRefused { lane, seq, crd } => (lane, seq, Refuser::Crd(crd)),
                Event::LaserRefused { lane, seq, channel } => (lane, seq, Refuser::Laser(channel)),
                Event::OutputRefused { lane, seq } => (lane, seq, Refuser::Outputs),
                Event::Stopped { axis, reason, now } => {
                    self.handler.admission.log.stopped(now, EventKind::AxisStopped, axis.index(), reason);
                    continue;
                }
                Event::CrdStopped { crd, reason, now } => {
                    self.handler.admission.log.stopped(now, EventKind::CrdStopped, crd.index(), reason);
                    continue;
                }
            };
            match lane {
                TickLane::Immediate => self.handler.tick_refused((seq, refuser)),
                TickLane::Program => self.program.tick_refused((seq, refuser)),
            }
        }
        self.handler.admission.log.see(view);
        self.handler.update_from(&mut self.program, view);
        if self.link.session() != self.session {
            self.session = self.link.session();
            if self.session.is_some() {
                self.handler.abandon();
                self.program.abandon();
                (self.at, self.outbox_len, self.begins) = (0, 0, true);
            }
        }
        if self.begins {
            self.begins = !self.handler.begin_session(view);
        }
        if let Some(heard) = self.link.last_valid() {
            self.heard = Some(heard);
        }
        link_loss::watch(&mut self.handler.admission, &mut self.program, &mut self.lost, self.heard, now);
        for _ in 0..POLL_PASSES {
            let mut writer = ReplyWriter::new(self.outbox.get_mut(self.outbox_len..).unwrap_or(&mut []));
            let mut progress = self.handler.answer(view, &self.program, &mut writer);
            let mut poll = Poll { admission: &mut self.handler.admission, view, out: &mut writer };
            progress |= self.program.advance(&mut poll);
            self.handler.catch_up(&mut self.program, view);
            let mut over = false;
            // Messages in progress when the link was lost wait until it is back: nothing starts
            // unsupervised.
            if let Some(message) = self.link.message().filter(|_| !self.begins && !self.lost) {
                over = true;
                for record in requests(message).skip(self.at) {
                    let step = match record {
                        Ok(record) if record.lane != Lane::Immediate => {
                            let mut poll = Poll { admission: &mut self.handler.admission, view, out: &mut writer };
                            self.program.offer(&mut poll, &record)
                        }
                        Ok(record) => self.handler.immediate(&mut self.program, view, &record, &mut writer),
                        Err(malformed) => {
                            let (opcode, tag) = malformed.head.unwrap_or((0, 0));
                            RecordOutcome::of(writer.refused(opcode, tag, &malformed.refusal()))
                        }
                    };
                    if step == RecordOutcome::Wait {
                        over = false;
                        break;
                    }
                    self.at += 1;
                    progress = true;
                }
            }
            self.outbox_len += writer.len();
            if over {
                self.link.done_with_message();
                self.at = 0;
            }
            progress |= Self::send(&mut self.link, self.session.is_some(), &self.outbox, &mut self.outbox_len);
            if !progress {
                break;
            }
        }
        self.handler.admission.feed_paths(view);
        self.handler.admission.drain_trace(&mut self.samples, view);
        self.send_trace();
    }

    /// Sends the trace in messages, if it goes over the link. Replies come first, so one slot of
    /// the window stays free. Rows are sent when a message is full, or after a while.
    fn send_trace(&mut self) {
        let waited = self.time.0.saturating_sub(self.traced_at) >= TRACE_FLUSH_NS;
        if !(self.handler.admission.trace.is_due() || waited && self.handler.admission.trace.has_link_bytes()) {
            return;
        }
        while self.outbox_len == 0 && self.link.free_slots() > 1 {
            let Some((head, body)) = self.link.draft().and_then(|draft| draft.split_at_mut_checked(TRACE_HEAD_BYTES))
            else {
                return;
            };
            let mut count = 0;
            loop {
                let part = self.handler.admission.trace.link_bytes(body.get_mut(count..).unwrap_or(&mut []));
                count += part;
                self.handler.admission.drain_trace(&mut self.samples, self.view.last());
                if part == 0 || count >= body.len() {
                    break;
                }
            }
            if count == 0 {
                return;
            }
            let record =
                ReplyHead { opcode: TRACE_RECORD.into(), tag: 0.into(), code: 0.into(), len: (count as u16).into() };
            if record.write_to(head).is_err() || self.link.send_draft(TRACE_HEAD_BYTES + count).is_err() {
                return;
            }
            self.traced_at = self.time.0;
            if TRACE_HEAD_BYTES + count < protocol::MAX_PAYLOAD {
                return;
            }
        }
    }

    /// Hands the gathered replies to the link, if it has a slot. True if they were sent.
    fn send(link: &mut Endpoint<LINK_WINDOW>, open: bool, outbox: &[u8], len: &mut usize) -> bool {
        if !open {
            // Nobody reads them.
            *len = 0;
            return false;
        }
        let message = outbox.get(..*len).unwrap_or(&[]);
        let gone = !message.is_empty() && link.send(message).is_ok();
        if gone {
            *len = 0;
        }
        gone
    }

    /// Answers a read of a viewer, who has no session here. It cannot change anything, and counts
    /// for nothing: neither for the session nor for the link-loss time.
    pub fn answer_viewer(&self, record: &RequestRecord, out: &mut ReplyWriter) -> Answered {
        let view = self.view.last();
        match record.opcode {
            opcode::ProgramStatus => self.program.status(view, record.opcode, record.tag, out),
            _ => self.handler.admission.answer_viewer(view, record, out),
        }
        .into()
    }

    /// Bytes for the wire; returns how many were written into `out`.
    pub fn take_tx(&mut self, out: &mut [u8]) -> usize {
        self.link.take_tx(self.time.0, out)
    }

    /// Bytes of the trace stream; returns how many were written into `out`.
    pub fn take_trace(&mut self, out: &mut [u8]) -> usize {
        let mut written = 0;
        loop {
            let count = self.handler.admission.trace.bytes(out.get_mut(written..).unwrap_or(&mut []));
            written += count;
            if count == 0 || written >= out.len() {
                return written;
            }
            // The encoder has room again.
            self.handler.admission.drain_trace(&mut self.samples, self.view.last());
        }
    }

    /// The latest time for the next `poll`, if no bytes come and the tick executes nothing. While a
    /// program entry waits for the machine it is at once: after the next tick.
    pub fn next_deadline(&self) -> Option<Ns> {
        let link_loss_ms = self.handler.admission.executed.watch.link_loss_ms;
        let loss = self.heard.filter(|_| !self.lost && link_loss_ms != 0);
        let loss = loss.map(|heard| link_loss::instant(heard, link_loss_ms));
        let next_tick = self.program.urgent.then(|| self.time.0.saturating_add(1));
        let flush = self.program.flush_due(self.view.last()).map(|due| due.0);
        let feed = self.handler.admission.feed_due;
        let due = [self.link.next_deadline(), loss, next_tick, flush].into_iter().flatten().fold(feed, u64::min);
        (due != u64::MAX).then_some(Ns(due))
    }

    /// The newest view, for displays and tests.
    pub fn view(&mut self) -> &View<AXES> {
        self.view.read()
    }

    /// What the board is.
    pub fn board(&self) -> &BoardConstants {
        &self.handler.admission.board
    }

    /// Whether a session is open.
    pub fn is_open(&self) -> bool {
        self.link.session().is_some()
    }

    /// Whether a trace is announced or runs.
    pub fn traces(&self) -> bool {
        self.handler.admission.trace.is_on()
    }
}
