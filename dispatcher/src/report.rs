//! What the controller reports to its host: replies, the event log, the trace.
//!
//! In: one view of the tick and the shadow state. Out: replies, events and rows for the wire.
//! Changes nothing.
pub(crate) mod answer;
pub(crate) mod event_log;
pub(crate) mod path_many;
pub(crate) mod pending_replies;
pub(crate) mod replies;
pub(crate) mod trace;
