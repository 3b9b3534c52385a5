//! The text of the last failure, for each thread and card: what another thread does wrong hides
//! nothing.

use crate::card::CardSlot;
use client::Error;
use protocol::reason::{Reason, Refusal, describe};
use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::{c_char, c_short};

thread_local! {
    static LAST: RefCell<HashMap<CardSlot, String>> = RefCell::new(HashMap::new());
    static LAST_OF_ANY: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keeps a text.
pub fn keep(slot: CardSlot, text: String) {
    LAST_OF_ANY.with(|last| last.borrow_mut().clone_from(&text));
    LAST.with(|last| last.borrow_mut().insert(slot, text));
}

/// The text kept last; empty if there is none.
pub fn last(slot: CardSlot) -> String {
    LAST.with(|last| last.borrow().get(&slot).cloned().unwrap_or_default())
}

/// Writes a text and its final 0 into so many bytes, cut where it is too long.
///
/// # Safety
/// `text` is the address of `room` bytes, at least one.
pub unsafe fn write(last: &str, text: *mut c_char, room: usize) {
    let mut length = last.len().min(room.saturating_sub(1));
    while !last.is_char_boundary(length) {
        length -= 1;
    }
    // SAFETY: `length` + 1 bytes are within those that the caller vouches for.
    unsafe {
        std::ptr::copy_nonoverlapping(last.as_ptr(), text.cast::<u8>(), length);
        text.add(length).write(0);
    }
}

/// The text of the calling thread's last failure on any card, for `commandhandler` of
/// `compat/stdafx.h`: that gets a return value, and not the card.
///
/// # Safety
/// `text` is NULL or the address of `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn beamtick_last_reason(text: *mut c_char, size: c_short) {
    if let Ok(room @ 1..) = usize::try_from(size)
        && !text.is_null()
    {
        // SAFETY: the caller's.
        LAST_OF_ANY.with(|last| unsafe { write(&last.borrow(), text, room) });
    }
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
