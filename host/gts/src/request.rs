//! Numbers to the wire and back: fields of requests with their ranges, fields of replies by the
//! command table.

use crate::boundary::Arg;
use crate::prototype::Scalar;
use crate::reason;
use crate::width::{c_long, c_ulong};
use client::Result;
use protocol::reason::Reason;
use std::ffi::{c_short, c_ushort, c_void};

/// Parameters whose bits count: a `long` may hold all 32 as a positive number.
const BITS: &[&str] = &["mask", "option", "value"];
/// "Off" of a software limit, which is −2³¹ also where `long` has 64 bits (SPEC 3).
const LIMIT_OFF: i64 = 0x8000_0000;

/// A number of a reply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    /// An integer.
    Int(i64),
    /// A real.
    Real(f64),
}

/// Least and greatest value of a wire type.
fn range(wire: &str) -> (i64, i64) {
    match wire {
        "I16" => (i16::MIN.into(), i16::MAX.into()),
        "U16" => (0, u16::MAX.into()),
        "U32" => (0, u32::MAX.into()),
        "u8" => (0, u8::MAX.into()),
        _ => (i32::MIN.into(), i32::MAX.into()),
    }
}

/// Appends a value as the wire type `wire`; 7 if it does not fit.
pub fn put(body: &mut Vec<u8>, wire: &str, value: Arg, function: &str, name: &str) -> Result<()> {
    if wire == "F64" {
        body.extend(value.number().to_le_bytes());
        return Ok(());
    }
    let whole = match value {
        Arg::Int(whole) => whole,
        Arg::Real(real) => real as i64,
        Arg::Address(_) => 0,
    };
    let (low, high) = range(wire);
    let pattern = wire == "I32" && BITS.contains(&name) && (0..=u32::MAX.into()).contains(&whole);
    let off = function == "SetSoftLimit" && whole == LIMIT_OFF;
    if !(low..=high).contains(&whole) && !pattern && !off {
        return Err(reason::wrong(function, name, Reason::OutOfRange, whole as f64, low as f64, high as f64));
    }
    match wire {
        "I16" | "U16" => body.extend((whole as u16).to_le_bytes()),
        "u8" => body.push(whole as u8),
        _ => body.extend((whole as u32).to_le_bytes()),
    }
    Ok(())
}

/// The element and the length of a wire type: `[I16; 8]` is eight `I16`.
pub fn elements(wire: &str) -> (&str, usize) {
    let array = wire.strip_prefix('[').and_then(|wire| wire.strip_suffix(']')).and_then(|wire| wire.split_once("; "));
    array.map_or((wire, 1), |(of, length)| (of, length.parse().unwrap_or(0)))
}

/// Takes the fields of one layout from the front of `bytes`, each with its elements; nothing if it
/// is too short.
pub fn fields(layout: &[(&str, &str)], bytes: &mut &[u8]) -> Option<Vec<Vec<Number>>> {
    let field = |(_, wire): &(&str, &str)| {
        let (of, length) = elements(wire);
        (0..length).map(|_| number(of, bytes)).collect::<Option<Vec<Number>>>()
    };
    layout.iter().map(field).collect()
}

fn number(wire: &str, bytes: &mut &[u8]) -> Option<Number> {
    macro_rules! take {
        ($type:ty, $number:expr) => {{
            let (head, rest) = bytes.split_first_chunk()?;
            *bytes = rest;
            let make: fn($type) -> Number = $number;
            Some(make(<$type>::from_le_bytes(*head)))
        }};
    }
    match wire {
        "F64" => take!(f64, Number::Real),
        "I32" => take!(i32, |value| Number::Int(value.into())),
        "U32" => take!(u32, |value| Number::Int(value.into())),
        "I16" => take!(i16, |value| Number::Int(value.into())),
        "U16" => take!(u16, |value| Number::Int(value.into())),
        "u8" => take!(u8, |value| Number::Int(value.into())),
        _ => None,
    }
}

/// Bytes of a number in memory.
pub const fn size(of: Scalar) -> usize {
    match of {
        Scalar::Short | Scalar::UShort => size_of::<c_short>(),
        Scalar::Long | Scalar::ULong => size_of::<c_long>(),
        Scalar::Double => size_of::<f64>(),
    }
}

/// Reads the value at `address`.
///
/// # Safety
/// There is a value of this type there.
pub unsafe fn load(address: *const c_void, of: Scalar) -> Arg {
    // SAFETY: the caller says that there is one; its alignment does not matter.
    unsafe {
        match of {
            Scalar::Short => Arg::from(address.cast::<c_short>().read_unaligned()),
            Scalar::UShort => Arg::from(address.cast::<c_ushort>().read_unaligned()),
            Scalar::Long => Arg::from(address.cast::<c_long>().read_unaligned()),
            Scalar::ULong => Arg::from(address.cast::<c_ulong>().read_unaligned()),
            Scalar::Double => Arg::from(address.cast::<f64>().read_unaligned()),
        }
    }
}

/// Writes a value to `address`.
///
/// # Safety
/// There is room for a value of this type there.
pub unsafe fn store(address: *mut c_void, of: Scalar, number: Number) {
    let (whole, real) = match number {
        Number::Int(whole) => (whole, whole as f64),
        Number::Real(real) => (real as i64, real),
    };
    // SAFETY: the caller says that there is room; its alignment does not matter.
    unsafe {
        match of {
            Scalar::Short => address.cast::<c_short>().write_unaligned(whole as c_short),
            Scalar::UShort => address.cast::<c_ushort>().write_unaligned(whole as c_ushort),
            Scalar::Long => address.cast::<c_long>().write_unaligned(whole as c_long),
            Scalar::ULong => address.cast::<c_ulong>().write_unaligned(whole as c_ulong),
            Scalar::Double => address.cast::<f64>().write_unaligned(real),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wire(wire: &str, value: i64, function: &str, name: &str) -> std::result::Result<Vec<u8>, String> {
        let mut body = Vec::new();
        put(&mut body, wire, Arg::Int(value), function, name).map(|()| body).map_err(|error| error.reason)
    }

    #[test]
    fn a_long_of_64_bits_is_held_to_32() {
        assert_eq!(wire("I32", -5, "SetPos", "pos").unwrap(), (-5i32).to_le_bytes());
        for beyond in [1 << 31, -(1i64 << 31) - 1, i64::MAX] {
            let reason = wire("I32", beyond, "SetPos", "pos").unwrap_err();
            assert!(reason.starts_with("SetPos: pos is ") && reason.contains("2147483647"), "{reason}");
        }
        assert_eq!(wire("I32", 0xffff_ffff, "Update", "mask").unwrap(), [0xff; 4]);
        assert!(wire("I32", 0x1_0000_0000, "Update", "mask").is_err());
        assert_eq!(wire("I32", 0x8000_0000, "SetSoftLimit", "negative").unwrap(), i32::MIN.to_le_bytes());
        assert!(wire("I32", 0x8000_0001, "SetSoftLimit", "negative").is_err());
        assert!(wire("U32", -1, "FollowDelayEx", "delayTime").is_err());
        assert!(wire("U16", -1, "SetDac", "count").is_err());
    }

    #[test]
    fn replies_that_are_too_short_have_no_fields() {
        let layout = [("a", "I16"), ("b", "F64")];
        let mut bytes = &[1, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f][..];
        assert_eq!(fields(&layout, &mut bytes).unwrap(), [[Number::Int(1)], [Number::Real(1.0)]]);
        assert!(fields(&layout, &mut &[1, 0, 0][..]).is_none());
        let found = fields(&[("a", "[u8; 3]"), ("b", "u8")], &mut &[1, 2, 3, 4][..]).unwrap();
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1]);
    }
}
