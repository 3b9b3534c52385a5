//! Raw program records before admission: a bounded queue of bytes.
//!
//! In: records as they came. Out: the same, in order, each in one piece. A record takes its body
//! and [`RECORD_BYTES`]; what does not fit is not taken.

use zerocopy::little_endian::U16;
use zerocopy::{FromBytes, Immutable, IntoBytes, Unaligned, transmute};

pub use crate::capacity::QUEUE_BYTES;
/// What a record takes besides its body: as much as its head in a message.
pub const RECORD_BYTES: usize = size_of::<QueuedHead>();
/// Longest body.
pub const BODY_MAX: usize = protocol::MAX_PAYLOAD;

/// The record in hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordHead {
    /// Command number.
    pub opcode: u16,
    /// The client's tag.
    pub tag: u16,
    /// The program goes on after it if it is refused.
    pub may_fail: bool,
}

/// A head in the queue; `len` bytes of body follow it.
#[derive(FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct QueuedHead {
    opcode: U16,
    tag: U16,
    len: U16,
    may_fail: u8,
}

/// The queue and the record in hand.
pub struct Records {
    ring: [u8; QUEUE_BYTES],
    first: usize,
    used: usize,
    head: Option<(RecordHead, usize)>,
    body: [u8; BODY_MAX],
}

impl Records {
    /// An empty queue.
    pub fn new() -> Self {
        Records { ring: [0; QUEUE_BYTES], first: 0, used: 0, head: None, body: [0; BODY_MAX] }
    }
    /// Bytes free: a record fits if its body and [`RECORD_BYTES`] do.
    pub fn space(&self) -> usize {
        QUEUE_BYTES - self.used
    }
    /// Whether nothing waits, in hand or in the queue.
    pub fn is_empty(&self) -> bool {
        self.used == 0 && self.head.is_none()
    }
    /// Drops everything.
    pub fn clear(&mut self) {
        self.used = 0;
        self.head = None;
    }
    /// Appends a record; false if it does not fit.
    pub fn push(&mut self, head: RecordHead, body: &[u8]) -> bool {
        let Ok(len) = u16::try_from(body.len()) else { return false };
        if body.len() > BODY_MAX || body.len() + RECORD_BYTES > self.space() {
            return false;
        }
        let RecordHead { opcode, tag, may_fail } = head;
        let head = QueuedHead { opcode: opcode.into(), tag: tag.into(), len: len.into(), may_fail: may_fail.into() };
        self.write(head.as_bytes());
        self.write(body);
        true
    }
    fn write(&mut self, bytes: &[u8]) {
        let at = (self.first + self.used) % QUEUE_BYTES;
        let (now, remainder) = bytes.split_at(bytes.len().min(QUEUE_BYTES - at));
        self.ring[at..at + now.len()].copy_from_slice(now);
        self.ring[..remainder.len()].copy_from_slice(remainder);
        self.used += bytes.len();
    }
    fn read(ring: &[u8; QUEUE_BYTES], first: usize, out: &mut [u8]) {
        let (now, remainder) = out.split_at_mut(out.len().min(QUEUE_BYTES.saturating_sub(first)));
        let head = ring.get(first..).and_then(|ring| ring.get(..now.len()));
        if let (Some(head), Some(tail)) = (head, ring.get(..remainder.len())) {
            now.copy_from_slice(head);
            remainder.copy_from_slice(tail);
        }
    }
    fn skip(&mut self, count: usize) {
        self.first = (self.first + count) % QUEUE_BYTES;
        self.used -= count;
    }
    /// The record in hand, taken from the queue if there is none.
    pub fn front(&mut self) -> Option<(RecordHead, &[u8])> {
        if self.head.is_none() && self.used >= RECORD_BYTES {
            let mut head = [0; RECORD_BYTES];
            Self::read(&self.ring, self.first, &mut head);
            let QueuedHead { opcode, tag, len, may_fail } = transmute!(head);
            let len = usize::from(len.get());
            self.skip(RECORD_BYTES);
            // A record that was taken fits.
            Self::read(&self.ring, self.first, self.body.get_mut(..len).unwrap_or_default());
            self.skip(len);
            self.head = Some((RecordHead { opcode: opcode.get(), tag: tag.get(), may_fail: may_fail != 0 }, len));
        }
        self.head.map(|(head, len)| (head, self.body.get(..len).unwrap_or_default()))
    }
    /// The record in hand is done.
    pub fn pop(&mut self) {
        self.head = None;
    }
}
