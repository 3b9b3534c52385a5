//! Several commands or replies in one message.
//!
//! In and out: byte buffers. A message is a sequence of records, each a head and a body of `len`
//! bytes.
//! Fails: a record whose body does not have its command's length is refused by itself. One that
//! reaches beyond the end of the message is reported and ends the message, since nothing after it
//! can be found.
//! Nothing here knows a command: [`Request`](crate::command::Request) names the layouts.

use crate::command::{Request, Wire, wire_structs};
use crate::frame::MAX_PAYLOAD;
use crate::reason::{Code, Reason, Refusal};
use core::marker::PhantomData;
use zerocopy::little_endian::{F64, I16, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

wire_structs! {
    /// Before each request: number, the client's tag (comes back in the reply), length of the body,
    /// lane (0 immediate, 1 program, 2 program, may fail).
    RequestHead { opcode: U16, tag: U16, len: U16, lane: u8 }
    /// Before each reply: number and tag of the request, return code, length of the body.
    ReplyHead { opcode: U16, tag: U16, code: I16, len: U16 }
    /// The job that a program runs which shares its link: entries in all, entries that are done,
    /// time left in ms (0xFFFFFFFF: nobody knows). The job's name follows, in UTF-8.
    JobState { entries: U32, done: U32, left_ms: U32 }
}

/// Longest body of a request: with its head it fills a message.
pub const BODY_MAX: usize = MAX_PAYLOAD - size_of::<RequestHead>();

/// Most bytes of items that a client puts into one request; a controller takes all that a message
/// holds. More items need further requests.
pub const ITEM_BYTES: usize = 960;

/// The lane of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Lane {
    /// At once.
    Immediate = 0,
    /// After the entries of the program queue; a failure there ends the program.
    Program = 1,
    /// The same, but a program goes on after the entry if it is refused.
    ProgramMayFail = 2,
}

/// Number of the records that carry a trace over the link (`Trace` with `way` 1): tag and code are
/// 0, the body is the next part of the trace's byte stream. They answer nothing; the controller
/// sends them by itself.
pub const TRACE_RECORD: u16 = 0x0017;

/// Number of the records in which a program that shares its link says what job it runs: tag and
/// code are 0, the body is a [`JobState`] and the job's name. They answer nothing.
pub const JOB_RECORD: u16 = 0x0018;

/// The buffer has no room for the record; nothing was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full;

/// A record that reaches beyond its message, a remainder too short for a head, or a lane that does
/// not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Malformed {
    /// Index of the record's first byte in the message.
    pub at: usize,
    /// Number and tag, if the head was there.
    pub head: Option<(u16, u16)>,
    /// Body length that the head names (0 without a head).
    pub len: usize,
    /// Bytes that are left for the body (without a head: for the record).
    pub left: usize,
    /// The lane that does not exist, if that is what is wrong.
    pub lane: Option<u8>,
}

impl Malformed {
    /// The refusal that answers it.
    pub fn refusal(&self) -> Refusal {
        match self.lane {
            None => length_refusal(self.left, self.len),
            Some(lane) => Refusal { got: F64::new(lane.into()), high: F64::new(2.0), ..Refusal::new(Reason::Selector) },
        }
    }
}

/// One request as it came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RequestRecord<'a> {
    /// Command number.
    pub opcode: u16,
    /// To be repeated in the reply.
    pub tag: u16,
    /// Its lane.
    pub lane: Lane,
    /// Struct and items.
    pub body: &'a [u8],
}

impl<'a> RequestRecord<'a> {
    /// The body as request `R`.
    ///
    /// # Errors
    /// [`Reason::Length`] if it is shorter, or the rest is not a whole number of items.
    pub fn parse<R: Request>(&self) -> Result<(R, Items<'a, R::Item>), Refusal> {
        split::<R, R::Item>(self.body).ok_or_else(|| length_refusal(self.body.len(), size_of::<R>()))
    }
}

/// One reply as it came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReplyRecord<'a> {
    /// Number of the command that it answers.
    pub opcode: u16,
    /// Tag of the command that it answers.
    pub tag: u16,
    /// Return code.
    pub code: i16,
    /// Reply struct and items, or [`Refusal`] if `code` is not 0.
    pub body: &'a [u8],
}

impl<'a> ReplyRecord<'a> {
    /// The body of a reply to request `R` with code 0, or what the controller refused.
    ///
    /// # Errors
    /// [`ReplyError::Refused`] for a code other than 0, [`ReplyError::Length`] for a body of the
    /// wrong length.
    pub fn parse<R: Request>(&self) -> Result<(R::Reply, Items<'a, R::ReplyItem>), ReplyError> {
        match self.refusal() {
            Some(refusal) => Err(refusal),
            None => split::<R::Reply, R::ReplyItem>(self.body).ok_or(ReplyError::Length),
        }
    }

    /// Code and refusal, if it is one.
    pub fn refusal(&self) -> Option<ReplyError> {
        if self.code == Code::Done as i16 {
            return None;
        }
        Some(match Refusal::read_from_bytes(self.body) {
            Ok(refusal) => ReplyError::Refused(self.code, refusal),
            Err(_) => ReplyError::Length,
        })
    }
}

/// Why a reply has no result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReplyError {
    /// The controller refused the command: code and reason.
    Refused(i16, Refusal),
    /// The body's length is not that of the reply.
    Length,
}

/// Items after a struct.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Items<'a, T> {
    bytes: &'a [u8],
    kind: PhantomData<T>,
}

impl<'a, T: Wire> Items<'a, T> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.bytes.len().checked_div(size_of::<T>()).unwrap_or(0)
    }

    /// None at all.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// One after another.
    pub fn iter(&self) -> impl Iterator<Item = T> + use<'a, T> {
        // A layout of no bytes has no items, and chunks of no bytes do not exist.
        self.bytes.chunks_exact(size_of::<T>().max(1)).filter_map(|bytes| T::read_from_bytes(bytes).ok())
    }
}

fn split<S: Wire, T: Wire>(body: &[u8]) -> Option<(S, Items<'_, T>)> {
    let (fixed, rest) = S::read_from_prefix(body).ok()?;
    let whole = match size_of::<T>() {
        0 => rest.is_empty(),
        size => rest.len().is_multiple_of(size),
    };
    whole.then_some((fixed, Items { bytes: rest, kind: PhantomData }))
}

fn length_refusal(got: usize, expected: usize) -> Refusal {
    Refusal {
        got: F64::new(got as f64),
        low: F64::new(expected as f64),
        high: F64::new(expected as f64),
        ..Refusal::new(Reason::Length)
    }
}

/// Requests of one message, in order.
#[derive(Debug, Clone)]
pub struct Requests<'a> {
    cursor: RecordReader<'a>,
}

/// The requests in a message.
pub fn requests(message: &[u8]) -> Requests<'_> {
    Requests { cursor: RecordReader { message, at: 0 } }
}

impl<'a> Iterator for Requests<'a> {
    type Item = Result<RequestRecord<'a>, Malformed>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.cursor.next(|head: &RequestHead| (head.opcode.get(), head.tag.get(), head.len.get()))?;
        Some(next.and_then(|(at, head, body)| {
            let (opcode, tag) = (head.opcode.get(), head.tag.get());
            let lane = match head.lane {
                0 => Lane::Immediate,
                1 => Lane::Program,
                2 => Lane::ProgramMayFail,
                lane => {
                    let (len, head) = (body.len(), Some((opcode, tag)));
                    return Err(Malformed { at, head, len, left: len, lane: Some(lane) });
                }
            };
            Ok(RequestRecord { opcode, tag, lane, body })
        }))
    }
}

/// Replies of one message, in order.
#[derive(Debug, Clone)]
pub struct Replies<'a> {
    cursor: RecordReader<'a>,
}

/// The replies in a message.
pub fn replies(message: &[u8]) -> Replies<'_> {
    Replies { cursor: RecordReader { message, at: 0 } }
}

impl<'a> Iterator for Replies<'a> {
    type Item = Result<ReplyRecord<'a>, Malformed>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.cursor.next(|head: &ReplyHead| (head.opcode.get(), head.tag.get(), head.len.get()))?;
        Some(next.map(|(_, head, body)| ReplyRecord {
            opcode: head.opcode.get(),
            tag: head.tag.get(),
            code: head.code.get(),
            body,
        }))
    }
}

/// A record's index, head and body.
type Found<'a, H> = Result<(usize, H, &'a [u8]), Malformed>;

#[derive(Debug, Clone)]
struct RecordReader<'a> {
    message: &'a [u8],
    at: usize,
}

impl<'a> RecordReader<'a> {
    fn next<H: Wire>(&mut self, read: fn(&H) -> (u16, u16, u16)) -> Option<Found<'a, H>> {
        let at = self.at;
        let rest = self.message.get(at..).unwrap_or(&[]);
        if rest.is_empty() {
            return None;
        }
        let Ok((head, bodies)) = H::read_from_prefix(rest) else {
            self.at = self.message.len();
            return Some(Err(Malformed { at, head: None, len: 0, left: rest.len(), lane: None }));
        };
        let (opcode, tag, len) = read(&head);
        let len = usize::from(len);
        match bodies.get(..len) {
            Some(body) => {
                self.at = at.saturating_add(size_of::<H>()).saturating_add(len);
                Some(Ok((at, head, body)))
            }
            None => {
                self.at = self.message.len();
                Some(Err(Malformed { at, head: Some((opcode, tag)), len, left: bodies.len(), lane: None }))
            }
        }
    }
}

/// Writes requests one after another.
#[derive(Debug)]
pub struct RequestWriter<'a> {
    row: Row<'a>,
}

impl<'a> RequestWriter<'a> {
    /// Writes from the beginning of `buffer`.
    pub fn new(buffer: &'a mut [u8]) -> Self {
        RequestWriter { row: Row { buffer, at: 0 } }
    }

    /// Appends a request with its items.
    ///
    /// # Errors
    /// [`Full`]: there is no room for all of it.
    pub fn push<R: Request>(&mut self, lane: Lane, tag: u16, request: &R, items: &[R::Item]) -> Result<(), Full> {
        self.push_raw(R::OPCODE, lane, tag, &[request.as_bytes(), items.as_bytes()])
    }

    /// Appends a request of any number, its body in parts.
    ///
    /// # Errors
    /// [`Full`]: there is no room for all of it.
    pub fn push_raw(&mut self, opcode: u16, lane: Lane, tag: u16, body: &[&[u8]]) -> Result<(), Full> {
        let head = RequestHead { opcode: opcode.into(), tag: tag.into(), len: length(body)?, lane: lane as u8 };
        self.row.append(head.as_bytes(), body)
    }

    /// Bytes written so far.
    pub fn len(&self) -> usize {
        self.row.at
    }

    /// Nothing written yet.
    pub fn is_empty(&self) -> bool {
        self.row.at == 0
    }
}

/// Writes replies one after another.
#[derive(Debug)]
pub struct ReplyWriter<'a> {
    row: Row<'a>,
}

impl<'a> ReplyWriter<'a> {
    /// Writes from the beginning of `buffer`.
    pub fn new(buffer: &'a mut [u8]) -> Self {
        ReplyWriter { row: Row { buffer, at: 0 } }
    }

    /// Appends the reply to `R` that was done.
    ///
    /// # Errors
    /// [`Full`]: there is no room for all of it.
    pub fn done<R: Request>(&mut self, tag: u16, reply: &R::Reply, items: &[R::ReplyItem]) -> Result<(), Full> {
        self.push_raw(R::OPCODE, tag, Code::Done as i16, &[reply.as_bytes(), items.as_bytes()])
    }

    /// Appends a refusal; the code is that of its reason.
    ///
    /// # Errors
    /// [`Full`]: there is no room for all of it.
    pub fn refused(&mut self, opcode: u16, tag: u16, refusal: &Refusal) -> Result<(), Full> {
        let code = Reason::from_number(refusal.reason.get()).map_or(Code::State, Reason::code);
        self.push_raw(opcode, tag, code as i16, &[refusal.as_bytes()])
    }

    /// Appends a reply of any number and code, its body in parts.
    ///
    /// # Errors
    /// [`Full`]: there is no room for all of it.
    pub fn push_raw(&mut self, opcode: u16, tag: u16, code: i16, body: &[&[u8]]) -> Result<(), Full> {
        let head = ReplyHead { opcode: opcode.into(), tag: tag.into(), code: code.into(), len: length(body)? };
        self.row.append(head.as_bytes(), body)
    }

    /// Bytes written so far.
    pub fn len(&self) -> usize {
        self.row.at
    }

    /// Nothing written yet.
    pub fn is_empty(&self) -> bool {
        self.row.at == 0
    }

    /// Bytes that are still free.
    pub fn room(&self) -> usize {
        self.row.buffer.len().saturating_sub(self.row.at)
    }
}

fn length(parts: &[&[u8]]) -> Result<U16, Full> {
    let sum = parts.iter().fold(0usize, |sum, part| sum.saturating_add(part.len()));
    u16::try_from(sum).map(U16::new).map_err(|_| Full)
}

#[derive(Debug)]
struct Row<'a> {
    buffer: &'a mut [u8],
    at: usize,
}

impl Row<'_> {
    fn append(&mut self, head: &[u8], parts: &[&[u8]]) -> Result<(), Full> {
        let size = parts.iter().fold(head.len(), |sum, part| sum.saturating_add(part.len()));
        let end = self.at.checked_add(size).ok_or(Full)?;
        let mut room = self.buffer.get_mut(self.at..end).ok_or(Full)?;
        for part in core::iter::once(&head).chain(parts) {
            let (here, rest) = room.split_at_mut_checked(part.len()).ok_or(Full)?;
            here.copy_from_slice(part);
            room = rest;
        }
        self.at = end;
        Ok(())
    }
}
