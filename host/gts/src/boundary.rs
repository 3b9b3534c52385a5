//! The entry from C: each exported function is one line of `exports`, made of these macros.

use crate::card::CardSlot;
use crate::engine::{self, Prepared};
use crate::reason;
use crate::width::{c_long, c_ulong};
use std::ffi::{c_short, c_ushort, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// One argument of a call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Arg {
    /// An integer.
    Int(i64),
    /// A real number.
    Real(f64),
    /// An address.
    Address(*mut c_void),
}

impl Arg {
    /// Its value; 0 of an address.
    pub fn number(self) -> f64 {
        match self {
            Arg::Int(whole) => whole as f64,
            Arg::Real(real) => real,
            Arg::Address(_) => 0.0,
        }
    }
}

impl From<c_short> for Arg {
    fn from(value: c_short) -> Self {
        Arg::Int(value.into())
    }
}
impl From<c_ushort> for Arg {
    fn from(value: c_ushort) -> Self {
        Arg::Int(value.into())
    }
}
impl From<c_long> for Arg {
    #[allow(clippy::useless_conversion)] // It has 32 bits on Windows.
    fn from(value: c_long) -> Self {
        Arg::Int(value.into())
    }
}
impl From<c_ulong> for Arg {
    #[allow(clippy::unnecessary_fallible_conversions)] // It has 32 bits on Windows.
    fn from(value: c_ulong) -> Self {
        Arg::Int(i64::try_from(value).unwrap_or(i64::MAX))
    }
}
impl From<f64> for Arg {
    fn from(value: f64) -> Self {
        Arg::Real(value)
    }
}
impl<T> From<*mut T> for Arg {
    fn from(value: *mut T) -> Self {
        Arg::Address(value.cast())
    }
}
impl<T> From<*const T> for Arg {
    fn from(value: *const T) -> Self {
        Arg::Address(value.cast_mut().cast())
    }
}

/// Does a call, and keeps why it failed. A panic ends here as −5: it must not run into C.
pub fn enter(slot: Option<CardSlot>, prepared: &Prepared, lead: c_short, args: &[Arg]) -> c_short {
    let Some(slot) = slot else {
        reason::keep(CardSlot::ONE, format!("{}: cardNum is {lead}; it must be from 0 to 15", prepared.name()));
        return 7;
    };
    // SAFETY: the addresses are those that the caller of the C function vouches for, see
    // `engine::call`.
    let outcome = catch_unwind(AssertUnwindSafe(|| unsafe { engine::call(slot, prepared, lead, args) }));
    let is_child = crate::fork::is_child();
    if !is_child && crate::log::is_on(slot) && prepared.name() != "GetLastReason" {
        let (code, text) = match &outcome {
            Ok(Ok(note)) => (0, note.as_deref().unwrap_or_default()),
            Ok(Err(error)) => (error.code, error.reason.as_str()),
            Err(_) => (client::error::LINK_PROTOCOL, "an error in the library itself"),
        };
        let now = slot.lock().card("").ok().map(|card| card.client().0.now());
        // SAFETY: as above.
        unsafe { crate::log::write(slot, prepared, (lead, args), code, text, now) };
        if now.is_none() {
            crate::log::end(slot);
        }
    }
    // With `virtual:max` a call takes time: sleepers of other threads may be due.
    crate::compat::waits::time_passed();
    match outcome {
        Ok(Ok(None)) => 0,
        Ok(Ok(Some(note))) => {
            reason::keep(slot, note);
            0
        }
        Ok(Err(error)) => {
            reason::keep(slot, error.reason);
            error.code
        }
        Err(_) => {
            reason::keep(slot, format!("{}: an error in the library itself", prepared.name()));
            client::error::LINK_PROTOCOL
        }
    }
}

macro_rules! function {
    ($symbol:ident $name:literal $form:ident, $slot:expr, $lead:expr, ($($first:ident: $of:ty)?), ($($param:ident: $type:ty),*)) => {
        #[doc = concat!("`", $name, "`, as the header declares it.")]
        ///
        /// # Safety
        /// Addresses are NULL or those of as many values as the function reads and fills.
        #[unsafe(no_mangle)]
        #[allow(non_snake_case, clippy::too_many_arguments)]
        pub unsafe extern "system" fn $symbol($($first: $of,)? $($param: $type),*) -> c_short {
            static PREPARED: std::sync::LazyLock<crate::engine::Prepared> =
                std::sync::LazyLock::new(|| crate::engine::Prepared::new($name, crate::prototype::Form::$form));
            crate::boundary::enter($slot, &PREPARED, $lead, &[$(crate::boundary::Arg::from($param)),*])
        }
    };
}
macro_rules! gt {
    ($symbol:ident $name:literal ($($param:ident: $type:ty),*)) => {
        crate::boundary::function!($symbol $name Gt, Some(crate::card::CardSlot::ONE), 1, (), ($($param: $type),*));
    };
}
macro_rules! gtn {
    ($symbol:ident $name:literal ($($param:ident: $type:ty),*)) => {
        crate::boundary::function!($symbol $name Gtn, Some(crate::card::CardSlot::ONE), core, (core: c_short), ($($param: $type),*));
    };
}
macro_rules! open_gtn {
    ($symbol:ident $name:literal ($($param:ident: $type:ty),*)) => {
        crate::boundary::function!($symbol $name Gtn, Some(crate::card::CardSlot::ONE), 1, (), ($($param: $type),*));
    };
}
macro_rules! cards {
    ($symbol:ident $name:literal ($($param:ident: $type:ty),*)) => {
        crate::boundary::function!($symbol $name Cards, crate::card::CardSlot::card(card), card, (card: c_short), ($($param: $type),*));
    };
}
pub(crate) use {cards, function, gt, gtn, open_gtn};
