//! What the controller tells its host: replies to reads, the event log, the trace.
//!
//! In: one view of the tick and the shadow state. Out: rows and reports of the wire. Changes nothing.
pub(crate) mod answer;
pub(crate) mod event_log;
pub(crate) mod pending_replies;
pub(crate) mod replies;
pub(crate) mod trace;
