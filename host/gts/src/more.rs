//! Calls beyond the manuals that public programs make (API.md), apart from those of the controller.
//!
//! In: a call. Out: *kept* ones are range-checked and read back, and change nothing, because no
//! loop is closed here; *refused* ones return 1 with what is missing; times are the controller's.
//! Values that are kept belong to the open card, and a Reset puts them back.

mod rows;

use crate::boundary::Arg;
use crate::engine::Prepared;
use crate::home::HomeCall;
use crate::prototype::Scalar;
use crate::reason;
use client::{Error, Result};
use job::api::Function;
use protocol::reason::Reason;
use std::collections::HashMap;

pub use rows::{MORE, NOT_THERE};

/// A range, or all axes of the core.
#[derive(Debug, Clone, Copy)]
pub enum Range {
    /// From 1 to the core's axes.
    Axes,
    /// Both bounds belong to it.
    From(f64, f64),
    /// As `From`, without 0.
    Not0(f64, f64),
}

/// What a function does.
#[derive(Debug, Clone, Copy)]
pub enum Class {
    /// It is the controller's, under another name.
    Real,
    /// Done by the library in controller time.
    Timed,
    /// Keeps what it is given.
    Keeps {
        /// The name under which it is kept.
        under: &'static str,
        /// Ranges of the numbers that name the item.
        names: &'static [Range],
        /// Ranges of the values.
        values: &'static [Range],
    },
    /// Returns what is kept.
    Recalls {
        /// The name under which it is kept.
        under: &'static str,
        /// Ranges of the numbers that name the item.
        names: &'static [Range],
        /// The values before any are set.
        unset: &'static [f64],
    },
    /// Automatic homing, by the library with the controller's captures.
    Homes(HomeCall),
    /// What it asks for is so: nothing to do. Its argument names an item of this range.
    IsSo(Range, &'static str),
    /// Only 0 is taken; anything else is refused for this reason.
    OnlyZero(&'static str),
    /// Refused for this reason.
    Refused(&'static str),
}

/// A row.
#[derive(Debug, Clone, Copy)]
pub struct More {
    /// Name and parameters.
    pub function: Function,
    /// Types of its `Out` parameters, in order.
    pub outs: &'static [Scalar],
    /// What it does.
    pub class: Class,
    /// A sentence for the headers.
    pub about: &'static str,
}

/// The row of a function.
pub fn row(name: &str) -> Option<&'static More> {
    MORE.iter().find(|more| more.function.name == name)
}

/// What is kept: by name, core and item.
#[derive(Debug, Default)]
pub struct Kept(HashMap<(&'static str, i16, Vec<i64>), Vec<f64>>);

impl Kept {
    /// As after power-on.
    pub fn reset(&mut self, core: i16) {
        self.0.retain(|(_, of, _), _| *of != core);
    }
}

/// What the library does with a call that is no request.
pub enum Done {
    /// Done.
    Yes,
    /// These values go to the caller.
    Values(Vec<f64>),
}

fn number(arg: &Arg) -> f64 {
    match arg {
        Arg::Int(whole) => *whole as f64,
        Arg::Real(real) => *real,
        Arg::Address(_) => 0.0,
    }
}

/// 7 unless a value is in its range.
fn check(function: &str, name: &str, got: f64, range: Range, axes: u8) -> Result<()> {
    let (low, high, zero) = match range {
        Range::Axes => (1.0, f64::from(axes), true),
        Range::From(low, high) => (low, high, true),
        Range::Not0(low, high) => (low, high, false),
    };
    if !(low..=high).contains(&got) {
        return Err(reason::wrong(function, name, Reason::OutOfRange, got, low, high));
    }
    match zero || got != 0.0 {
        true => Ok(()),
        false => Err(Error::new(7, format!("{function}: {name} is 0; it must not be"))),
    }
}

/// Does a call that the library answers. `given` are the values of its parameters, a struct's one
/// by one, with their names.
pub fn call(
    prepared: &Prepared,
    more: &More,
    kept: &mut Kept,
    (core, axes): (i16, u8),
    given: &[(&'static str, Arg)],
) -> Result<Done> {
    let function = prepared.name();
    let check_all = |ranges: &[Range], given: &[(&'static str, Arg)]| {
        given.iter().zip(ranges).try_for_each(|((name, arg), range)| check(function, name, number(arg), *range, axes))
    };
    let item = |names: &[Range]| given.iter().take(names.len()).map(|(_, arg)| number(arg) as i64).collect::<Vec<_>>();
    match more.class {
        Class::Keeps { under, names, values } => {
            let ranges = [names, values].concat();
            check_all(&ranges, given)?;
            let values = given.iter().skip(names.len()).map(|(_, arg)| number(arg)).collect();
            kept.0.insert((under, core, item(names)), values);
            Ok(Done::Yes)
        }
        Class::Recalls { under, names, unset } => {
            check_all(names, given)?;
            let found = kept.0.get(&(under, core, item(names))).cloned();
            Ok(Done::Values(found.unwrap_or_else(|| unset.to_vec())))
        }
        Class::IsSo(range, _) => check_all(&[range], given).map(|()| Done::Yes),
        Class::OnlyZero(why) => match given.first() {
            Some((name, arg)) if number(arg) != 0.0 => {
                Err(Error::new(1, format!("{function}: {name} is {}: {why}", number(arg))))
            }
            _ => Ok(Done::Yes),
        },
        Class::Refused(why) => Err(Error::new(1, format!("{function}: {why}"))),
        Class::Real | Class::Timed | Class::Homes(_) => Ok(Done::Yes),
    }
}
