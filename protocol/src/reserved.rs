//! Numbers kept for commands that have no layout yet.
pub const RESERVED: &[(u16, &str)] = &[];
