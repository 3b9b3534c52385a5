//! Progress of a table that comes in chunks: of PVT, or of a laser channel.
//!
//! In: the table that a chunk is of, and its first point. Out: what was made of the chunks before
//! it. Owns: that, or why a chunk was refused.
//! Fails: with the parameter and the limit, if a chunk does not begin where the one before ended. A
//! chunk that is sent again, because it was refused too early, is refused in the same way.
use crate::refuse::{Admitted, Refused};

/// `K` tells one table from another; `T` is what was made of its chunks.
#[derive(Debug, Clone, Copy)]
pub enum Upload<K, T> {
    /// No table is being sent.
    Idle,
    /// So many points were taken.
    Open(K, u16, T),
    /// The chunk that begins with this point was refused.
    Refused(K, u16, Refused),
}

impl<K: Copy + PartialEq, T: Copy> Upload<K, T> {
    /// What was made of the chunks before the one that begins with this point (parameter `field`);
    /// for the first chunk, what `fresh` makes.
    pub fn resume(&mut self, (key, first): (K, u16), field: u8, fresh: impl FnOnce() -> Admitted<T>) -> Admitted<T> {
        let next = match *self {
            _ if first == 0 => {
                *self = Upload::Idle;
                return fresh();
            }
            Upload::Open(open, next, made) if open == key && next == first => return Ok(made),
            Upload::Refused(open, at, refused) if open == key && at == first => return Err(refused),
            Upload::Open(open, next, _) if open == key => next,
            _ => 0,
        };
        Err(Refused::range(field, first.into(), 0.0, next.into()))
    }

    /// Notes how that chunk was handled: the point after it and what was made, or none where the
    /// table is complete.
    pub fn note(&mut self, (key, first): (K, u16), handled: Admitted<Option<(u16, T)>>) {
        *self = match handled {
            Ok(None) => Upload::Idle,
            Ok(Some((next, made))) => Upload::Open(key, next, made),
            Err(refused) => Upload::Refused(key, first, refused),
        };
    }
}
