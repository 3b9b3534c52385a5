//! A call beyond the manuals that the library answers (`more`): its arguments, its results, and
//! waits.

use super::{Kind, Prepared, member, scalar_member};
use crate::boundary::Arg;
use crate::card::CardSlot;
use crate::compat::waits;
use crate::home::HomeCall;
use crate::more::{self, Class, Done, More};
use crate::request::{self, Number, size};
use client::{Error, Result};
use protocol::command::GetClock;
use std::ffi::c_short;
use std::time::Duration;

/// Units of DelayHighPrecision, and of GetClockHighPrecision, in us.
const DELAY_UNIT_US: u64 = 250;
const CLOCK_UNIT_US: u64 = 125;

/// Does it.
///
/// # Safety
/// As for [`super::call`].
pub(super) unsafe fn call(
    slot: CardSlot,
    prepared: &Prepared,
    more: &More,
    core: c_short,
    args: &[Arg],
) -> Result<Option<String>> {
    let mut state = slot.lock();
    let card = state.card(prepared.name())?;
    prepared.check_addresses(args)?;
    // SAFETY: as the caller says.
    let given = unsafe { given(prepared, args) };
    if let Class::Timed = more.class {
        let time = match (prepared.name(), given.first()) {
            ("Delay", Some((_, Arg::Int(ms)))) => Duration::from_millis(u64::try_from(*ms).unwrap_or(0)),
            (_, Some((_, Arg::Int(units)))) => {
                Duration::from_micros(u64::try_from(*units).unwrap_or(0) * DELAY_UNIT_US)
            }
            _ => {
                let clock = card.client().0.call(GetClock {})?;
                // Ticks since power-on give the fraction of a ms, unless SetTick has changed their
                // length meanwhile.
                let ticks = u64::from(clock.ticks.get()) * u64::from(card.client().0.version().tick_us.get());
                let ms = u64::from(clock.clock_ms.get());
                let units = if ticks / 1000 == ms { ticks / CLOCK_UNIT_US } else { ms * (1000 / CLOCK_UNIT_US) };
                // SAFETY: as the caller says.
                unsafe { store(prepared, args, &[f64::from(units as u32)]) };
                return card.passed(true).map(|()| None);
            }
        };
        drop(state);
        waits::wait(Some(time), |_| None::<()>);
        return Ok(None);
    }
    let (client, _) = card.client();
    let version = client.version();
    if !(1..=i16::from(version.cores)).contains(&core) {
        let reason = format!("{}: core is {core}; it must be from 1 to {}", prepared.name(), version.cores);
        return Err(Error::new(7, reason));
    }
    if let Class::Homes(what) = more.class {
        let homes = card.homes();
        let values = homes.call(&client, what, (prepared.name(), core), &given)?;
        if what == HomeCall::Go {
            card.started = true;
            card.note(prepared.prototype.function, core, given.iter().copied());
        }
        card.wake();
        // SAFETY: as the caller says.
        unsafe { store(prepared, args, &values) };
        return card.passed(what != HomeCall::Go).map(|()| None);
    }
    if let Done::Values(values) = more::call(prepared, more, &mut card.kept, (core, version.axes_per_core), &given)? {
        // SAFETY: as the caller says.
        unsafe { store(prepared, args, &values) };
    }
    card.passed(prepared.reads()).map(|()| None)
}

/// The values that go in, a struct's one by one.
///
/// # Safety
/// As for [`super::call`].
unsafe fn given(prepared: &Prepared, args: &[Arg]) -> Vec<(&'static str, Arg)> {
    let mut given = Vec::new();
    for (argument, arg) in prepared.prototype.arguments.iter().zip(args) {
        match (argument.kind, arg) {
            (Kind::Value(_), arg) => given.push((argument.name, *arg)),
            (Kind::Struct(of), Arg::Address(address)) => {
                for (name, ..) in of.fields() {
                    // SAFETY: the caller's struct has these members.
                    given.extend(unsafe { member(*address, of, name) }.into_iter().map(|value| (*name, value)));
                }
            }
            _ => {}
        }
    }
    given
}

/// Stores values where the arguments point, in order.
///
/// # Safety
/// As for [`super::call`].
unsafe fn store(prepared: &Prepared, args: &[Arg], values: &[f64]) {
    let mut values = values.iter().map(|value| Number::Real(*value));
    for (argument, arg) in prepared.prototype.arguments.iter().zip(args) {
        match (argument.kind, arg) {
            (Kind::Out(of), Arg::Address(address)) => {
                if let Some(value) = values.next().filter(|_| !address.is_null()) {
                    // SAFETY: the caller's address is that of a value.
                    unsafe { request::store(*address, of, value) };
                }
            }
            (Kind::OutStruct(of), Arg::Address(address)) => {
                for (name, _, count) in of.fields() {
                    let (scalar, offset) = scalar_member(of, name);
                    for n in 0..*count {
                        if let Some(value) = values.next() {
                            // SAFETY: the caller's struct has this member.
                            unsafe { request::store(address.byte_add(offset + n * size(scalar)), scalar, value) };
                        }
                    }
                }
            }
            _ => {}
        }
    }
}
