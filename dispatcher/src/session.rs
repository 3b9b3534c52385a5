//! One session with a host: the link's end, the immediate lane, replies that wait for the tick, the second client.
//!
//! In: bytes and the time. Out: bytes, operations. Calls the program and admission, never the other way round.
pub(crate) mod commands;
mod link_loss;
pub(crate) mod second_client;
pub(crate) mod server;
