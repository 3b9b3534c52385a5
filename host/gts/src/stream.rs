//! PT data in batches, transparent to the program.
//!
//! `PtData` of a FIFO may return 0 before its segment is sent, when it is certain that the
//! controller takes it. Two conditions make it certain. The last reply to data of the same FIFO
//! reported enough free slots for what is queued since. And the segment passes the controller's own
//! check (`servo::segment::pt::Segment::admit`) after the one before it.
//!
//! A segment that is not certain is sent at once and its reply awaited. So every refusal comes from
//! the controller and belongs to its call. Queued segments travel as one `PtDataMany`: when there
//! are 32, before any other call, and after a millisecond.
//!
//! Free slots never become fewer by themselves. So an answer of `PtSpace` from here is exact at
//! standstill, and at most [`SLOTS_VALID_FOR`] old while the axis runs. Only the link can still
//! refuse queued data; then the next call fails.

use client::{Call, Error};
use protocol::command::{PtClear, PtData, PtDataMany, PtItem, PtSpace, PtTaken, Short, opcode};
use servo::segment::pt::{Chain, Segment};
use servo::units::StepLimit;
use std::collections::HashMap;
use std::time::{Duration, Instant};
use zerocopy::{FromBytes, IntoBytes};

/// Segments that travel together.
const BATCH_SEGMENTS: usize = 32;
/// How long reported free slots are used as an answer.
const SLOTS_VALID_FOR: Duration = Duration::from_millis(10);

/// A FIFO: core, profile, number.
type Fifo = (i16, i16, i16);

/// Free slots of the FIFO that was written last.
#[derive(Debug, Clone, Copy)]
struct Lease {
    fifo: Fifo,
    free: usize,
    reported: Instant,
}

/// See the module text.
#[derive(Default)]
pub struct Stream {
    /// Nothing is queued.
    off: bool,
    /// The fastest axis of the controller's step outputs; none if the report makes no sense.
    limit: Option<StepLimit>,
    /// Ends of FIFOs that are known.
    chains: HashMap<Fifo, Chain>,
    lease: Option<Lease>,
    queue: Vec<PtItem>,
    failed: Option<Error>,
}

impl Stream {
    /// Nothing is known yet but the controller's step limit, pulse/ms. Without batches everything
    /// is sent at once.
    pub fn new(batches: bool, step_limit: f64) -> Stream {
        let limit = StepLimit::new(step_limit as u64);
        Stream { off: !batches || limit.is_none(), limit, ..Stream::default() }
    }

    /// Queues PT data if the controller is certain to take it.
    pub fn take(&mut self, call: &Call) -> bool {
        let Some(data) = data(call) else { return false };
        let fifo = (data.core.get(), data.profile.get(), data.fifo.get());
        let Some(lease) = self.lease.filter(|lease| lease.fifo == fifo && self.queue.len() < lease.free) else {
            return false;
        };
        let Some(next) = self.chains.get(&lease.fifo).and_then(|chain| follows(&data, chain, self.limit?)) else {
            return false;
        };
        self.chains.insert(fifo, next);
        self.queue.push(PtItem { pos: data.pos, time_ms: data.time_ms, kind: data.kind.get() as u8 });
        true
    }

    /// The answer to PtSpace, if it is known.
    pub fn answer(&self, call: &Call) -> Option<Vec<u8>> {
        let asked = (call.opcode == opcode::PtSpace).then(|| PtSpace::read_from_bytes(&call.payload).ok())??;
        let fifo = (asked.core.get(), asked.profile.get(), asked.fifo.get());
        let lease = self.lease.filter(|lease| lease.fifo == fifo && lease.reported.elapsed() < SLOTS_VALID_FOR)?;
        let free = lease.free.checked_sub(self.queue.len()).filter(|free| *free > 0)?;
        Some(Short { value: (free as i16).into() }.as_bytes().to_vec())
    }

    /// Whether a batch is complete.
    pub fn is_full(&self) -> bool {
        self.queue.len() >= BATCH_SEGMENTS
    }

    /// The queue as one call.
    pub fn batch(&mut self) -> Option<Call> {
        let lease = self.lease.as_mut()?;
        if self.queue.is_empty() {
            return None;
        }
        let (core, profile, fifo) = lease.fifo;
        let count = self.queue.len();
        lease.free -= count.min(lease.free);
        let head =
            PtDataMany { core: core.into(), profile: profile.into(), fifo: fifo.into(), count: (count as u16).into() };
        let call = Call::with_items(head, &self.queue);
        self.queue.clear();
        Some(call)
    }

    /// The reply to a batch.
    pub fn settled(&mut self, reply: &[u8]) {
        if let (Some(lease), Ok(taken)) = (&mut self.lease, PtTaken::read_from_bytes(reply)) {
            lease.free = taken.space.get().into();
            lease.reported = Instant::now();
        }
    }

    /// A call was done that was not queued.
    pub fn note(&mut self, call: &Call, reads: bool, reply: &[u8]) {
        match call.opcode {
            opcode::PtData => self.note_data(call, reply),
            opcode::PtClear => {
                self.lease = None;
                if let Ok(cleared) = PtClear::read_from_bytes(&call.payload) {
                    let fifo = (cleared.core.get(), cleared.profile.get(), cleared.fifo.get());
                    self.chains.insert(fifo, Chain::default());
                }
            }
            // A start leaves the data where it is.
            opcode::PtStart => {}
            _ if reads => {}
            _ => self.forget(),
        }
    }

    fn note_data(&mut self, call: &Call, reply: &[u8]) {
        self.lease = None;
        let (Some(data), Ok(taken)) = (data(call), PtTaken::read_from_bytes(reply)) else { return };
        let fifo = (data.core.get(), data.profile.get(), data.fifo.get());
        // In dynamic mode both numbers mean the same FIFO: what is known of the other one may be
        // wrong.
        self.chains.remove(&(fifo.0, fifo.1, 1 - fifo.2.clamp(0, 1)));
        match self.chains.get(&fifo).and_then(|chain| follows(&data, chain, self.limit?)) {
            Some(next) if !self.off => {
                self.chains.insert(fifo, next);
                self.lease = Some(Lease { fifo, free: taken.space.get().into(), reported: Instant::now() });
            }
            _ => {
                self.chains.remove(&fifo);
            }
        }
    }

    /// Nothing is known any more.
    pub fn forget(&mut self) {
        self.chains.clear();
        self.lease = None;
    }

    /// Queued data failed in the background.
    pub fn fail(&mut self, error: Error) {
        self.failed = Some(error);
    }

    /// What failed in the background, once.
    pub fn failed(&mut self) -> Option<Error> {
        self.failed.take()
    }
}

fn data(call: &Call) -> Option<PtData> {
    (call.opcode == opcode::PtData).then(|| PtData::read_from_bytes(&call.payload).ok())?
}

/// The end of a FIFO after this segment, if the controller takes it there.
fn follows(data: &PtData, chain: &Chain, limit: StepLimit) -> Option<Chain> {
    let bits = u64::from_le_bytes(data.pos.to_bytes());
    Segment::admit(bits, data.time_ms.get(), data.kind.get(), chain, limit).ok().map(|(_, next)| next)
}
