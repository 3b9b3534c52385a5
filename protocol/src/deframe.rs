//! Frames from a byte stream.
//!
//! In: bytes as they come, in any portions. Out: decoded frames, one at a time, and named refusals.
//! Owns one frame's bytes and its counters.
//! A frame is COBS data ended by one zero byte. After any error the next zero ends the frame, and
//! the one after starts clean. No checksum here: see [`crate::frame`].
//!
//! Bytes are copied and searched for the delimiter four at a time. A complete frame is then decoded
//! in place, from code to code, so the cost is per zero byte and not per byte. The `cobs` crate's
//! decoders process byte by byte, which costs several times the instructions that a PT segment may
//! have. The tests compare this decoder with that crate.

/// Result of feeding bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// All bytes are consumed and no frame is complete.
    More,
    /// A frame is complete: read it with [`Deframer::frame`] before the next feed.
    Frame,
    /// A delimiter ended something that is no frame.
    Refused(Fault),
}

/// Why a frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Longer than the buffer.
    TooLong,
    /// The delimiter came inside a COBS block.
    Truncated,
}

/// Counts since power-on (wrapping).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameCounters {
    /// Frames handed out.
    pub frames: u32,
    /// Frames longer than the buffer.
    pub too_long: u32,
    /// Frames whose delimiter came inside a block.
    pub truncated: u32,
}

/// Index of the first encoded byte in the buffer. So a link frame's payload, after the first code
/// and 14 bytes of header, lies on a word boundary and is copied by words.
const FIRST_BYTE: usize = 1;

#[derive(Debug, Clone)]
#[repr(align(4))]
struct AlignedBytes<const N: usize>([u8; N]);

/// The incremental decoder, for frames of up to `N` bytes on the wire with the delimiter.
#[derive(Debug, Clone)]
pub struct Deframer<const N: usize> {
    bytes: AlignedBytes<N>,
    /// End of the encoded bytes collected.
    len: usize,
    /// End of the last complete frame; it begins after the first code.
    done: usize,
    overflow: bool,
    counters: FrameCounters,
}

impl<const N: usize> Default for Deframer<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Deframer<N> {
    /// An empty deframer.
    pub const fn new() -> Self {
        Deframer {
            bytes: AlignedBytes([0; N]),
            len: FIRST_BYTE,
            done: 0,
            overflow: false,
            counters: FrameCounters { frames: 0, too_long: 0, truncated: 0 },
        }
    }

    /// Takes bytes up to and including the next delimiter; returns how many it took and the result.
    /// With [`Outcome::More`] all of them.
    pub fn feed(&mut self, input: &[u8]) -> (usize, Outcome) {
        let mut rest = input;
        loop {
            let kept = self.keep(rest);
            rest = rest.get(kept..).unwrap_or(&[]);
            // The remainder begins with a delimiter, or does not fit.
            let Some(at) = rest.iter().position(|&byte| byte == 0) else {
                self.overflow |= !rest.is_empty();
                return (input.len(), Outcome::More);
            };
            self.overflow |= at > 0;
            rest = rest.get(at.saturating_add(1)..).unwrap_or(&[]);
            if let Some(outcome) = self.finish() {
                return (input.len().saturating_sub(rest.len()), outcome);
            }
        }
    }

    /// The frame that the last [`Outcome::Frame`] announced.
    pub fn frame(&self) -> &[u8] {
        self.bytes.0.get(FIRST_BYTE + 1..self.done).unwrap_or(&[])
    }

    /// The counts so far.
    pub fn counters(&self) -> FrameCounters {
        self.counters
    }

    /// Forgets a partly read frame, as after reopening a transport.
    pub fn reset(&mut self) {
        self.len = FIRST_BYTE;
        self.overflow = false;
    }

    /// Copies bytes up to a delimiter or the end of the buffer; returns how many.
    fn keep(&mut self, input: &[u8]) -> usize {
        let room = self.bytes.0.get_mut(self.len..).unwrap_or(&mut []);
        let mut kept = 0usize;
        for (slot, word) in room.chunks_exact_mut(4).zip(input.chunks_exact(4)) {
            let &[a, b, c, d] = word else { break };
            let value = u32::from_le_bytes([a, b, c, d]);
            // A borrow into a top bit that was clear: one of the four bytes is zero.
            if value.wrapping_sub(0x0101_0101) & !value & 0x8080_8080 != 0 {
                break;
            }
            slot.copy_from_slice(&[a, b, c, d]);
            kept = kept.wrapping_add(4);
        }
        let room = room.get_mut(kept..).unwrap_or(&mut []);
        for (slot, &byte) in room.iter_mut().zip(input.get(kept..).unwrap_or(&[])) {
            if byte == 0 {
                break;
            }
            *slot = byte;
            kept = kept.wrapping_add(1);
        }
        self.len = self.len.saturating_add(kept);
        kept
    }

    /// A delimiter: the result of the bytes before it, or none after another delimiter.
    fn finish(&mut self) -> Option<Outcome> {
        let (len, overflow) = (self.len, self.overflow);
        self.reset();
        if overflow {
            self.counters.too_long = self.counters.too_long.wrapping_add(1);
            return Some(Outcome::Refused(Fault::TooLong));
        }
        if len == FIRST_BYTE {
            return None;
        }
        match self.bytes.0.get_mut(FIRST_BYTE..len).and_then(decode) {
            Some(length) => {
                self.done = length.saturating_add(FIRST_BYTE);
                self.counters.frames = self.counters.frames.wrapping_add(1);
                Some(Outcome::Frame)
            }
            None => {
                self.counters.truncated = self.counters.truncated.wrapping_add(1);
                Some(Outcome::Refused(Fault::Truncated))
            }
        }
    }
}

/// Decodes COBS data without zeros in place: each code but the first is replaced by the zero that
/// it stands for. A full block (code 255) has no zero after it, so there the rest moves up by one;
/// a frame has few of those. Returns the end of the data, which begin at 1; `None` if the last
/// block is cut short.
fn decode(bytes: &mut [u8]) -> Option<usize> {
    let mut end = bytes.len();
    let mut at = 0usize;
    let mut code = *bytes.first()?;
    loop {
        let next = at.wrapping_add(usize::from(code));
        if next >= end {
            return (next == end).then_some(end);
        }
        let full = code == 0xFF;
        let slot = bytes.get_mut(next)?;
        code = *slot;
        *slot = 0;
        at = next;
        if full {
            at = next.wrapping_sub(1);
            for i in next..end.wrapping_sub(1) {
                let byte = *bytes.get(i.wrapping_add(1))?;
                *bytes.get_mut(i)? = byte;
            }
            end = end.wrapping_sub(1);
        }
    }
}
