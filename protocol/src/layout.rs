//! Layouts of the structs that travel: fields in order, by name and type.

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A struct of one fixed little-endian layout.
pub trait Wire: FromBytes + IntoBytes + KnownLayout + Immutable + Unaligned + Copy {
    /// Fields in wire order: name and type as the protocol page prints them.
    const FIELDS: &'static [(&'static str, &'static str)];
}

/// The bytes before the field `fifo`. A layout without it does not compile where this is used.
pub(crate) const fn offset_of_fifo(fields: &[(&str, &str)]) -> usize {
    let (mut index, mut offset) = (0, 0);
    loop {
        let (name, of) = fields[index];
        if let b"fifo" = name.as_bytes() {
            return offset;
        }
        offset += match of.as_bytes() {
            b"F64" => 8,
            b"I32" => 4,
            b"I16" | b"U16" => 2,
            b"u8" => 1,
            _ => panic!("a type that no call of a path has"),
        };
        index += 1;
    }
}
