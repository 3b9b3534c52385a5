//! The text of the last failure, for each thread and card: what another thread does wrong hides nothing.

use crate::card::Slot;
use client::Error;
use protocol::reason::{Reason, Refusal, describe};
use std::cell::RefCell;
use std::collections::HashMap;

thread_local! {
    static LAST: RefCell<HashMap<Slot, String>> = RefCell::new(HashMap::new());
}

/// Keeps a text.
pub fn keep(slot: Slot, text: String) {
    LAST.with(|last| last.borrow_mut().insert(slot, text));
}

/// The text kept last; empty if there is none.
pub fn last(slot: Slot) -> String {
    LAST.with(|last| last.borrow().get(&slot).cloned().unwrap_or_default())
}

/// A parameter is wrong: 7, in the words that the controller uses.
pub fn wrong(function: &str, parameter: &str, reason: Reason, got: f64, low: f64, high: f64) -> Error {
    let refusal = Refusal { got: got.into(), low: low.into(), high: high.into(), ..Refusal::new(reason) };
    Error::new(reason.code() as i16, describe(function, parameter, refusal).to_string())
}

/// An address is missing: 7.
pub fn null(function: &str, parameter: &str) -> Error {
    Error::new(7, format!("{function}: {parameter} is NULL; it must be an address"))
}
