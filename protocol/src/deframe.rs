//! Frames out of a byte stream.
//!
//! In: bytes as they come, in any portions. Out: decoded frames, one at a time, and named refusals.
//! Owns one frame's bytes and its counters. A frame is COBS data ended by one zero byte; whatever is
//! wrong with it, the next zero ends it and the one after starts clean. No checksum here: see [`crate::frame`].
//!
//! Decoding is done while copying into the buffer, in one pass: the `cobs` crate decodes either byte by
//! byte through a state enum or in place in a second pass, which costs twice the instructions that a PT
//! segment may have. The tests hold this decoder to that crate.

/// What became of the bytes fed.
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

/// What a deframer has seen since power-on (wrapping).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Frames handed out.
    pub frames: u32,
    /// Frames longer than the buffer.
    pub too_long: u32,
    /// Frames whose delimiter came inside a block.
    pub truncated: u32,
}

/// The incremental decoder, for frames of up to `N` decoded bytes.
#[derive(Debug, Clone)]
pub struct Deframer<const N: usize> {
    bytes: [u8; N],
    len: usize,
    /// Length of the frame handed out last.
    done: usize,
    /// Data bytes left in the present block.
    run: u8,
    /// A zero stands before the next block.
    zero_due: bool,
    /// Something came since the last delimiter.
    started: bool,
    overflow: bool,
    counters: Counters,
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
            bytes: [0; N],
            len: 0,
            done: 0,
            run: 0,
            zero_due: false,
            started: false,
            overflow: false,
            counters: Counters { frames: 0, too_long: 0, truncated: 0 },
        }
    }

    /// Takes bytes up to and including the next delimiter; says how many it took and what came of it.
    /// With [`Outcome::More`] all of them.
    pub fn feed(&mut self, input: &[u8]) -> (usize, Outcome) {
        let mut rest = input;
        loop {
            if self.run > 0 {
                rest = self.copy_run(rest);
            }
            let Some((&byte, after)) = rest.split_first() else { return (input.len(), Outcome::More) };
            rest = after;
            if byte == 0 {
                let outcome = self.finish();
                if let Some(outcome) = outcome {
                    return (input.len().wrapping_sub(rest.len()), outcome);
                }
                continue;
            }
            // Not a delimiter, so the run is over and this is the next block's code.
            if self.zero_due {
                match self.bytes.get_mut(self.len) {
                    Some(place) => {
                        *place = 0;
                        self.len = self.len.wrapping_add(1);
                    }
                    None => self.overflow = true,
                }
            }
            self.started = true;
            self.run = byte.wrapping_sub(1);
            self.zero_due = byte != 0xFF;
        }
    }

    /// The frame that the last [`Outcome::Frame`] announced.
    pub fn frame(&self) -> &[u8] {
        self.bytes.get(..self.done).unwrap_or(&[])
    }

    /// What has been seen so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Forgets a half-read frame, as after reopening a transport.
    pub fn reset(&mut self) {
        self.len = 0;
        self.run = 0;
        self.zero_due = false;
        self.started = false;
        self.overflow = false;
    }

    /// Copies the present block's bytes; stops before a delimiter (the block is then cut short) and
    /// returns what is left, which begins with that delimiter or with the next block's code.
    fn copy_run<'a>(&mut self, input: &'a [u8]) -> &'a [u8] {
        let want = usize::from(self.run).min(input.len());
        let (block, _) = input.split_at_checked(want).unwrap_or((input, &[]));
        let room = self.bytes.get_mut(self.len..).unwrap_or(&mut []);
        let mut copied = 0usize;
        for (place, &byte) in room.iter_mut().zip(block) {
            if byte == 0 {
                break;
            }
            *place = byte;
            copied = copied.wrapping_add(1);
        }
        self.len = self.len.wrapping_add(copied);
        // Stopped by a delimiter or by the end of the buffer: in the latter case run on without keeping.
        for &byte in block.get(copied..).unwrap_or(&[]) {
            if byte == 0 {
                break;
            }
            self.overflow = true;
            copied = copied.wrapping_add(1);
        }
        // copied <= want <= run, so both fit.
        self.run = self.run.wrapping_sub(copied as u8);
        input.get(copied..).unwrap_or(&[])
    }

    /// A delimiter: what was before it, or nothing for a delimiter after a delimiter.
    fn finish(&mut self) -> Option<Outcome> {
        let (started, cut, overflow, len) = (self.started, self.run > 0, self.overflow, self.len);
        self.reset();
        if !started {
            return None;
        }
        if overflow {
            self.counters.too_long = self.counters.too_long.wrapping_add(1);
            return Some(Outcome::Refused(Fault::TooLong));
        }
        if cut {
            self.counters.truncated = self.counters.truncated.wrapping_add(1);
            return Some(Outcome::Refused(Fault::Truncated));
        }
        self.done = len;
        self.counters.frames = self.counters.frames.wrapping_add(1);
        Some(Outcome::Frame)
    }
}
