//! One session with a host: the link's end, the immediate lane, replies that wait for the tick,
//! link loss, the second client.
//!
//! In: bytes and the time. Out: bytes, tick commands. It calls the program and admission; these
//! never call it.
pub(crate) mod commands;
mod link_loss;
pub(crate) mod second_client;
pub(crate) mod server;
