//! One frame: header, payload, CRC-32.
//!
//! In: decoded bytes from [`crate::deframe`]; out: a checked [`Header`] and its payload, or a
//! [`Fault`]. The other way [`encode`] writes a frame as it goes over the wire: COBS, delimiter.
//!
//! ```text
//!  0        1     2      3       4        8         10               12      14       14+length
//! +--------+-----+------+-------+--------+---------+----------------+-------+---------+--------+
//! | version| kind| flags| credit| session| sequence| acknowledgement| length| payload | CRC-32 |
//! +--------+-----+------+-------+--------+---------+----------------+-------+---------+--------+
//! ```

use crate::command::{Wire, wire_structs};
use cobs::CobsEncoder;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use zerocopy::little_endian::{U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Version of the frame and link layers. A change of commands only changes [`crate::SCHEMA`].
pub const VERSION: u8 = 1;
/// Longest payload of one frame, that is, longest message.
pub const MAX_PAYLOAD: usize = 1024;
/// Bytes around the payload: header and CRC.
pub const OVERHEAD: usize = HEADER_BYTES + CRC_BYTES;
/// Longest decoded frame.
pub const MAX_FRAME: usize = MAX_PAYLOAD + OVERHEAD;
/// Longest frame on the wire: COBS and the delimiter.
pub const MAX_WIRE: usize = wire_length(MAX_FRAME);
/// Longest frame on the wire of those that open a session.
pub const OPENING_WIRE: usize = wire_length(OVERHEAD + size_of::<Busy>());
/// Bytes of [`Busy::holder`].
pub const HOLDER_BYTES: usize = 32;

const HEADER_BYTES: usize = size_of::<Header>();
pub(crate) const CRC_BYTES: usize = 4;

/// Wire bytes that `decoded` bytes may need: COBS overhead and the delimiter.
pub const fn wire_length(decoded: usize) -> usize {
    cobs::max_encoding_length(decoded) + 1
}

/// The CRC of every frame: polynomial 0x04C11DB7 reflected, start and final value 0xFFFFFFFF.
const CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// The first four of the crate's tables: 4 KiB of flash.
static TABLES: [[u32; 256]; 4] = {
    let all = CRC;
    let table = all.table();
    [table[0], table[1], table[2], table[3]]
};

/// Continues a CRC over more bytes, four at a time by the crate's tables: 4 instructions a byte on
/// the Cortex-M7 instead of 7 by the crate's own loop.
fn crc_update(mut crc: u32, bytes: &[u8]) -> u32 {
    let [t0, t1, t2, t3] = &TABLES;
    let (words, rest) = bytes.as_chunks::<4>();
    for word in words {
        let [a, b, c, d] = (crc ^ u32::from_le_bytes(*word)).to_le_bytes();
        crc = t3[usize::from(a)] ^ t2[usize::from(b)] ^ t1[usize::from(c)] ^ t0[usize::from(d)];
    }
    for &byte in rest {
        crc = t0[usize::from(crc as u8 ^ byte)] ^ (crc >> 8);
    }
    crc
}

/// The CRC of several parts.
fn checksum(parts: &[&[u8]]) -> u32 {
    !parts.iter().fold(!0, |crc, part| crc_update(crc, part))
}

/// Copies as many bytes as both can hold, word by word: the compiler's `memcpy` goes byte by byte
/// if the two are not aligned alike.
pub(crate) fn copy(to: &mut [u8], from: &[u8]) {
    let length = to.len().min(from.len());
    let (to, from) = (to.get_mut(..length).unwrap_or(&mut []), from.get(..length).unwrap_or(&[]));
    let (to_words, to_rest) = to.as_chunks_mut::<4>();
    let (from_words, from_rest) = from.as_chunks::<4>();
    for (slot, word) in to_words.iter_mut().zip(from_words) {
        *slot = u32::from_le_bytes(*word).to_le_bytes();
    }
    for (slot, byte) in to_rest.iter_mut().zip(from_rest) {
        *slot = *byte;
    }
}

wire_structs! {
    /// The first 14 bytes of a frame. Version, kind, session and length have the same offsets in
    /// every version, and [`Hello`] and [`HelloAck`] the same layouts. So any two versions can tell
    /// each other apart.
    Header {
        version: u8, kind: u8, flags: u8, credit: u8, session: U32, sequence: U16, acknowledgement: U16,
        length: U16,
    }
    /// Payload of kind Hello; the header's session is the client's nonce.
    Hello { schema: U32, window: U16 }
    /// Payload of kind HelloAck; the header's session is the nonce of the Hello it answers.
    /// `session` is the session's id, 0 if versions or schemas differ.
    HelloAck { schema: U32, window: U16, session: U32 }
    /// Payload of kind Busy; the header's session is the nonce of the Hello it answers. Another
    /// client has had the session for `held_ms`; its last frame came `silent_ms` ago. `holder` is
    /// its address, in UTF-8, filled up with zeros.
    Busy { held_ms: U32, silent_ms: U32, holder: [u8; 32] }
}

/// In `flags`: the sender of the frame holds messages beyond `acknowledgement`, so that one is
/// missing.
pub const FLAG_GAP: u8 = 1;
/// In `flags` of a Hello: the client asks for a read-only session. In those of a HelloAck: it is
/// one.
pub const FLAG_READ_ONLY: u8 = 2;

/// What a frame is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum FrameKind {
    /// Client: opens a session.
    Hello = 1,
    /// Controller: answers a Hello.
    HelloAck = 2,
    /// A message, numbered by `sequence`.
    Data = 3,
    /// Only acknowledgement and credit.
    Ack = 4,
    /// As Ack, and asks for an Ack.
    KeepAlive = 5,
    /// Ends the session.
    Bye = 6,
    /// Controller: answers a Hello while another client has the session.
    Busy = 7,
}

impl FrameKind {
    const fn from_number(number: u8) -> Option<FrameKind> {
        match number {
            1 => Some(FrameKind::Hello),
            2 => Some(FrameKind::HelloAck),
            3 => Some(FrameKind::Data),
            4 => Some(FrameKind::Ack),
            5 => Some(FrameKind::KeepAlive),
            6 => Some(FrameKind::Bye),
            7 => Some(FrameKind::Busy),
            _ => None,
        }
    }

    /// The payload length that this kind must have; `None` if any will do.
    const fn fixed_length(self) -> Option<usize> {
        match self {
            FrameKind::Hello => Some(size_of::<Hello>()),
            FrameKind::HelloAck => Some(size_of::<HelloAck>()),
            FrameKind::Data => None,
            FrameKind::Ack | FrameKind::KeepAlive | FrameKind::Bye => Some(0),
            FrameKind::Busy => Some(size_of::<Busy>()),
        }
    }
}

impl Busy {
    /// What is reported of the client at `holder`: as many bytes as fit.
    pub fn new(held_ms: u32, silent_ms: u32, holder: &str) -> Busy {
        let mut bytes = [0; HOLDER_BYTES];
        copy(&mut bytes, holder.as_bytes());
        Busy { held_ms: held_ms.into(), silent_ms: silent_ms.into(), holder: bytes }
    }

    /// The address of the other client.
    pub fn holder(&self) -> &[u8] {
        self.holder.split(|byte| *byte == 0).next().unwrap_or(&[])
    }
}

const _: () = assert!(size_of::<Busy>() >= size_of::<HelloAck>());

/// Why a frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Shorter than header and CRC.
    Short,
    /// The CRC does not fit the bytes.
    Checksum,
    /// Another protocol version, in a frame that is not part of the opening.
    Version,
    /// No such kind.
    Kind,
    /// `length` is not the payload's, or not the kind's.
    Length,
}

/// Checks a decoded frame and takes it apart.
///
/// # Errors
/// The first [`Fault`] in the order of the enum.
pub fn decode(bytes: &[u8]) -> Result<(Header, FrameKind, &[u8]), Fault> {
    if bytes.len() < OVERHEAD {
        return Err(Fault::Short);
    }
    let body = unseal(bytes).ok_or(Fault::Checksum)?;
    let (header, payload) = Header::read_from_prefix(body).map_err(|_| Fault::Short)?;
    let kind = FrameKind::from_number(header.kind);
    let opening = matches!(kind, Some(FrameKind::Hello | FrameKind::HelloAck));
    if header.version != VERSION && !opening {
        return Err(Fault::Version);
    }
    let kind = kind.ok_or(Fault::Kind)?;
    let fits = kind.fixed_length().is_none_or(|length| length == payload.len());
    if usize::from(header.length.get()) != payload.len() || payload.len() > MAX_PAYLOAD || !fits {
        return Err(Fault::Length);
    }
    Ok((header, kind, payload))
}

/// The payload of a frame that [`decode`] has accepted.
pub(crate) fn payload(bytes: &[u8]) -> &[u8] {
    bytes.get(HEADER_BYTES..bytes.len().saturating_sub(CRC_BYTES)).unwrap_or(&[])
}

/// Writes a frame as it goes over the wire. `header.length` is set here.
/// `None` if the payload is longer than [`MAX_PAYLOAD`] or `wire` may be too short.
pub fn encode(mut header: Header, payload: &[u8], wire: &mut [u8]) -> Option<usize> {
    if payload.len() > MAX_PAYLOAD {
        return None;
    }
    header.length = U16::new(payload.len() as u16);
    seal(&[header.as_bytes(), payload], wire)
}

/// Parts, their CRC, COBS, delimiter.
pub(crate) fn seal(parts: &[&[u8]], wire: &mut [u8]) -> Option<usize> {
    let length = parts.iter().fold(CRC_BYTES, |sum, part| sum.saturating_add(part.len()));
    if wire.len() < wire_length(length) {
        return None;
    }
    let mut encoder = CobsEncoder::new(wire);
    for part in parts {
        encoder.push(part).ok()?;
    }
    encoder.push(&checksum(parts).to_le_bytes()).ok()?;
    let end = encoder.finalize();
    *wire.get_mut(end)? = 0;
    end.checked_add(1)
}

/// The bytes before the CRC, if it fits.
pub(crate) fn unseal(bytes: &[u8]) -> Option<&[u8]> {
    let (body, crc) = bytes.split_last_chunk::<CRC_BYTES>()?;
    (checksum(&[body]) == u32::from_le_bytes(*crc)).then_some(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn the_loop_agrees_with_the_crate_for_every_length_and_cut() {
        let bytes: Vec<u8> = (0..300u32).map(|i| ((i * i) >> 3) as u8).collect();
        for length in 0..bytes.len() {
            let (all, cut) = (&bytes[..length], length / 3);
            assert_eq!(checksum(&[all]), CRC.checksum(all));
            assert_eq!(checksum(&[&all[..cut], &all[cut..]]), CRC.checksum(all));
            let mut copied = [0; 200];
            copy(&mut copied, all);
            let fits = length.min(200);
            assert_eq!(copied[..fits], all[..fits]);
        }
    }
}
