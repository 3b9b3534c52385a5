//! A call from its arguments to its return value.
//!
//! In: a function's row, `core`, the arguments. Out: one request or several, sent; the reply's
//! fields stored where the arguments point. Nothing is sent before every address and every range
//! that C can get wrong is checked; what the controller refuses is refused by it, in its words.

mod beyond;
mod config;
mod replies;

use crate::boundary::Arg;
use crate::card::{self, CardSlot, Opening};
use crate::more::{self, Class, More};
use crate::prototype::{self, Form, Kind, Prototype, Scalar};
use crate::reason;
use crate::request::{self, put, size};
use client::{Call, Error, Result};
use job::api::{Pass, Shape, Size, Type, counts};
use protocol::command::{CommandInfo, CommandKind, ConfigItem, widths};
use protocol::reason::Reason;
use protocol::record::{BODY_MAX, ITEM_BYTES};
use servo::laser::NODES;
use std::ffi::{c_char, c_short, c_void};

/// Axes of a configuration in a message, with room for one more.
const CONFIG_ITEMS: usize = ITEM_BYTES / size_of::<ConfigItem>() - 1;
/// The value for a parameter that was left out (`GT_NOT_GIVEN` of the header).
const NOT_GIVEN: f64 = f64::MIN;

/// A function prepared for calls.
pub struct Prepared {
    prototype: Prototype,
    command: Option<&'static CommandInfo>,
    /// Where the reply's items or fixed part hold each `Out` argument: argument, its type, index of
    /// the field.
    outs: Vec<(usize, Scalar, usize)>,
    /// The argument that gets the reply's clock.
    clock: Option<usize>,
    /// The argument `count`.
    count: Option<usize>,
    more: Option<&'static More>,
}

/// Content of a field of the request: its name and its elements.
type Given = (&'static str, Vec<Arg>);

impl Prepared {
    /// The function `name` of a family; every exported name is in the table.
    pub fn new(name: &str, form: Form) -> Prepared {
        let Some(function) = prototype::functions().find(|function| function.name == name) else {
            unreachable!("exports come from the tables")
        };
        let prototype = prototype::prototype(function, form);
        let mut places = prototype::outs(function).into_iter();
        let (mut outs, mut clock) = (Vec::new(), None);
        for (index, argument) in prototype.arguments.iter().enumerate() {
            if let Kind::Out(of) = argument.kind {
                match places.next().flatten() {
                    Some(place) => outs.push((index, of, place)),
                    None => clock = Some(index),
                }
            }
        }
        let count = prototype.arguments.iter().position(|argument| argument.name == "count");
        Prepared { command: prototype::command(function), prototype, outs, clock, count, more: more::row(name) }
    }

    /// Its name without a prefix, as reasons have it.
    pub fn name(&self) -> &'static str {
        self.prototype.function.name
    }

    /// As a program calls it.
    pub fn symbol(&self) -> String {
        self.prototype.symbol().replace("GTM_", "GT_")
    }

    /// Whether a core or a card comes first.
    pub fn has_leading_argument(&self) -> bool {
        self.prototype.leads
    }

    /// The name of an argument.
    pub fn argument(&self, place: usize) -> &'static str {
        self.prototype.arguments.get(place).map_or("", |argument| argument.name)
    }

    /// What is at the address of an argument: a struct that is read and, of a call that is `done`,
    /// what it has filled, eight values at most.
    ///
    /// # Safety
    /// As for [`call`].
    pub unsafe fn content(&self, place: usize, args: &[Arg], done: bool) -> Option<String> {
        let Some(Arg::Address(address)) =
            args.get(place).filter(|arg| !matches!(arg, Arg::Address(at) if at.is_null()))
        else {
            return None;
        };
        let argument = self.prototype.arguments.get(place)?;
        // SAFETY: the caller says that so many are there.
        let load = |offset: usize, of: Scalar, count: usize| unsafe {
            let one = |n| request::load(address.byte_add(offset + n * size(of)), of).to_string();
            list((0..count).map(one).collect())
        };
        match argument.kind {
            Kind::Out(of) if done => {
                let given = self.count.filter(|_| Some(place) != self.clock).and_then(|count| args.get(count));
                let count = if let Some(Arg::Int(count)) = given { usize::try_from(*count).unwrap_or(0) } else { 1 };
                Some(load(0, of, count.clamp(1, 8)))
            }
            Kind::OutStruct(_) if !done => None,
            Kind::Struct(of) | Kind::OutStruct(of) => {
                let members = prototype::members(of).into_iter();
                let all: Vec<String> =
                    members.map(|(name, scalar, count)| load(self::scalar_member(of, name).1, scalar, count)).collect();
                Some(format!("{{{}}}", all.join(", ")))
            }
            _ => None,
        }
    }

    /// Its row among the calls beyond the manuals, unless it is the controller's.
    fn more(&self) -> Option<&'static More> {
        self.more.filter(|more| !matches!(more.class, Class::Real))
    }

    /// A refusal of a command whose name is not this function's.
    fn under_its_name(&self, mut error: Error) -> Error {
        if let Some(command) = self.command
            && command.name != self.name()
            && let Some(rest) = error.reason.strip_prefix(command.name)
        {
            error.reason = format!("{}{rest}", self.name());
        }
        error
    }

    /// Whether it changes nothing.
    pub fn reads(&self) -> bool {
        self.prototype.function.reads()
    }

    fn within(&self, got: i64, (low, high): (i64, i64)) -> Result<usize> {
        match usize::try_from(got) {
            Ok(count) if (low..=high).contains(&got) => Ok(count),
            _ => Err(reason::wrong(self.name(), "count", Reason::OutOfRange, got as f64, low as f64, high as f64)),
        }
    }

    /// How many values an array holds. A count that no controller takes is refused here, before
    /// anything is read.
    fn array_length(&self, args: &[Arg], lasts: Size, values: &[Given]) -> Result<usize> {
        let bounds = self.bounds();
        let count = || match self.count.and_then(|count| args.get(count)) {
            Some(Arg::Int(count)) => self.within(*count, bounds),
            _ => self.within(1, bounds),
        };
        let nth = |n: usize| {
            let counts = values.iter().find(|(name, _)| *name == "count");
            match counts.and_then(|(_, counts)| counts.get(n)) {
                Some(Arg::Int(count)) => self.within(*count, bounds),
                _ => self.within(0, bounds),
            }
        };
        match lasts {
            Size::Count => count(),
            Size::Each(times) => Ok(count()? * times),
            Size::Columns => nth(0),
            Size::Rows => nth(1),
            Size::Grid => match nth(0)? * nth(1)? {
                nodes @ 0..=NODES => Ok(nodes),
                more => Err(reason::wrong(self.name(), "count", Reason::TooMany, more as f64, 1.0, NODES as f64)),
            },
        }
    }

    /// The range of `count` of a function that reads arrays. One that is not known here reads
    /// nothing; a test looks at all.
    fn bounds(&self) -> (i64, i64) {
        counts(self.name()).unwrap_or((0, 0))
    }

    /// The first address that must be there and is not.
    fn check_addresses(&self, args: &[Arg]) -> Result<()> {
        for (argument, arg) in self.prototype.arguments.iter().zip(args) {
            if let Arg::Address(address) = arg
                && address.is_null()
                && !argument.optional
            {
                return Err(reason::null(self.name(), argument.name));
            }
        }
        Ok(())
    }

    /// The values of the request, in order, and those of each array.
    ///
    /// # Safety
    /// As for [`call`].
    unsafe fn given(&self, args: &[Arg]) -> Result<(Vec<Given>, Vec<Given>)> {
        let (mut values, mut lists) = (Vec::new(), Vec::new());
        for (argument, arg) in self.prototype.arguments.iter().zip(args) {
            match (argument.kind, arg) {
                (Kind::Value(_), arg) => values.push((argument.name, vec![*arg])),
                (Kind::Fixed(of, length), Arg::Address(address)) => {
                    let element = |n: usize| match address.is_null() {
                        true => Arg::Int(0),
                        // SAFETY: the caller's array holds as many values.
                        false => unsafe { request::load(address.byte_add(n * size(of)), of) },
                    };
                    values.push((argument.name, (0..length).map(element).collect()));
                }
                (Kind::Array(of, lasts), Arg::Address(address)) => {
                    let length = self.array_length(args, lasts, &values)?;
                    // SAFETY: the caller's array holds `count` values.
                    let list = (0..length).map(|n| unsafe { request::load(address.byte_add(n * size(of)), of) });
                    lists.push((argument.name, list.collect()));
                }
                (Kind::Struct(of), Arg::Address(address)) if !address.is_null() => {
                    // SAFETY: the caller's struct has these members.
                    let members = of.fields().iter().map(|(name, ..)| (*name, unsafe { member(*address, of, name) }));
                    let point = self.prototype.function.shape == Shape::Point;
                    if point { &mut lists } else { &mut values }.extend(members);
                }
                _ => {}
            }
        }
        // A parameter that this form lacks gets its default.
        for (place, param) in self.prototype.function.params.iter().enumerate() {
            if let (Pass::In(_), Some(default)) = (param.pass, param.default)
                && !self.prototype.arguments.iter().any(|argument| argument.name == param.name)
            {
                values.insert(place.min(values.len()), (param.name, vec![Arg::Int(default.into())]));
            }
        }
        Ok((values, lists))
    }

    /// Appends a field with all of its elements.
    fn put_field(&self, body: &mut Vec<u8>, wire: &str, (name, elements): &Given) -> Result<()> {
        let (of, length) = request::elements(wire);
        elements.iter().take(length).try_for_each(|value| put(body, of, *value, self.name(), name))
    }

    /// The request's bytes with its first items; the remaining items in requests of their own.
    fn pack(&self, core: c_short, is_given: bool, values: &[Given], items: &[u8], item: usize) -> Result<Vec<Call>> {
        let Some(command) = self.command else { return Ok(Vec::new()) };
        // What a long head leaves of a message.
        let room = ITEM_BYTES.min(BODY_MAX.saturating_sub(widths(command.fields)));
        let each = room.checked_div(item).unwrap_or(1).max(1);
        let parts: Vec<&[u8]> = if items.is_empty() { vec![&[]] } else { items.chunks(each * item).collect() };
        let mut calls = Vec::with_capacity(parts.len());
        for (part, bytes) in parts.into_iter().enumerate() {
            let mut payload = Vec::with_capacity(64 + bytes.len());
            let mut values = values.iter();
            for (field, wire) in command.fields {
                match *field {
                    "core" => put(&mut payload, wire, Arg::Int(core.into()), self.name(), "core")?,
                    "form" => put(
                        &mut payload,
                        wire,
                        Arg::Int((self.prototype.form != Form::Gtn).into()),
                        self.name(),
                        "form",
                    )?,
                    "first" => put(&mut payload, wire, Arg::Int((part * each) as i64), self.name(), "first")?,
                    "count" if self.prototype.function.reports_stop() => {
                        put(&mut payload, wire, Arg::Int(1), self.name(), "count")?;
                    }
                    name if name.ends_with("_given") => payload.push(is_given.into()),
                    _ => {
                        if let Some(given) = values.next() {
                            self.put_field(&mut payload, wire, given)?;
                        }
                    }
                }
            }
            payload.extend_from_slice(bytes);
            calls.push(Call { opcode: command.opcode, payload, may_fail: false });
        }
        Ok(calls)
    }

    /// Whether the parameter that the request reports was given; the value for one left out becomes
    /// 0.
    fn take_given(&self, args: &[Arg], values: &mut [Given]) -> bool {
        let Some(name) = self.prototype.function.reports_given else { return false };
        for (_, elements) in values.iter_mut() {
            for element in elements.iter_mut().filter(|element| **element == Arg::Real(NOT_GIVEN)) {
                *element = Arg::Real(0.0);
            }
        }
        let mut arguments = self.prototype.arguments.iter().zip(args);
        arguments.any(|(argument, arg)| {
            argument.name == name
                && match arg {
                    Arg::Real(value) => *value != NOT_GIVEN,
                    Arg::Address(address) => !address.is_null(),
                    Arg::Int(_) => true,
                }
        })
    }

    /// The requests of a call.
    fn requests(
        &self,
        core: c_short,
        args: &[Arg],
        (mut values, lists): (Vec<Given>, Vec<Given>),
    ) -> Result<Vec<Call>> {
        let is_given = self.take_given(args, &mut values);
        let mut items = Vec::new();
        let mut item = 0;
        let layout = self.command.map_or(&[][..], |command| command.items);
        match self.prototype.function.shape {
            Shape::StartList => values = masks(self.name(), &lists)?,
            Shape::Grid => {
                // The values at the points come after the points.
                for (name, list) in lists.iter().skip(1).chain(lists.first()) {
                    for value in list {
                        put(&mut items, layout.first().map_or("F64", |(_, wire)| wire), *value, self.name(), name)?;
                    }
                }
                item = size_of::<f64>();
            }
            Shape::Point => {
                for (given, (_, wire)) in lists.iter().zip(layout) {
                    self.put_field(&mut items, wire, given)?;
                }
                item = items.len();
            }
            _ => {
                for n in 0..lists.first().map_or(0, |(_, list)| list.len()) {
                    for ((name, list), (_, wire)) in lists.iter().zip(layout) {
                        if let Some(value) = list.get(n) {
                            put(&mut items, wire, *value, self.name(), name)?;
                        }
                    }
                    item = items.len() / (n + 1);
                }
            }
        }
        self.pack(core, is_given, &values, &items, item)
    }
}

/// Two lists of axes and FIFOs as the masks of PtStart.
fn masks(function: &str, lists: &[Given]) -> Result<Vec<Given>> {
    let [(_, axes), (_, options)] = lists else { return Ok(Vec::new()) };
    let (mut mask, mut option) = (0u32, 0u32);
    for (axis, fifo) in axes.iter().zip(options) {
        match (axis, fifo) {
            (Arg::Int(axis @ 1..=32), Arg::Int(fifo @ 0..=1)) => {
                let (bit, fifo) = (1 << (axis - 1), (*fifo as u32) << (axis - 1));
                if mask & bit != 0 && option & bit != fifo {
                    let reason = format!("{function}: axis {axis} is listed twice, with different FIFOs");
                    return Err(Error::new(7, reason));
                }
                mask |= bit;
                option |= fifo;
            }
            (Arg::Int(axis), Arg::Int(0..=1)) => {
                return Err(reason::wrong(function, "axis", Reason::OutOfRange, *axis as f64, 1.0, 32.0));
            }
            (_, Arg::Int(fifo)) => {
                return Err(reason::wrong(function, "option", Reason::OutOfRange, *fifo as f64, 0.0, 1.0));
            }
            _ => {}
        }
    }
    Ok(vec![("mask", vec![Arg::Int(mask.into())]), ("option", vec![Arg::Int(option.into())])])
}

/// One value as itself, several in braces.
fn list(values: Vec<String>) -> String {
    if values.len() == 1 { values.concat() } else { format!("{{{}}}", values.join(", ")) }
}

/// Type and offset of a member of a struct, as this platform's C lays it out.
fn scalar_member(of: Type, wanted: &str) -> (Scalar, usize) {
    let mut end = 0usize;
    for (name, scalar, count) in prototype::members(of) {
        let offset = end.next_multiple_of(size(scalar));
        if name == wanted {
            return (scalar, offset);
        }
        end = offset + count * size(scalar);
    }
    (Scalar::Short, 0)
}

/// The elements of a member.
///
/// # Safety
/// There is a struct of this type at `address`.
unsafe fn member(address: *mut c_void, of: Type, name: &str) -> Vec<Arg> {
    let (scalar, offset) = scalar_member(of, name);
    let count = of.fields().iter().find(|(field, ..)| *field == name).map_or(0, |(.., count)| *count);
    // SAFETY: the struct has this member.
    (0..count).map(|n| unsafe { request::load(address.byte_add(offset + n * size(scalar)), scalar) }).collect()
}

/// Does a call. On success there may be a note for `GT_GetLastReason`.
///
/// # Safety
/// The addresses among `args` are NULL or those of as many values as the function reads and fills,
/// which for readers of several axes is `count`.
pub unsafe fn call(slot: CardSlot, prepared: &Prepared, lead: c_short, args: &[Arg]) -> Result<Option<String>> {
    let core = if prepared.prototype.form == Form::Gtn { lead } else { 1 };
    if prepared.name() == "GetLastReason" {
        prepared.check_addresses(args)?;
        prepared.check_room(args)?;
        // SAFETY: the caller's text has `size` bytes.
        unsafe { prepared.store_text(args, &reason::last(slot)) };
        return Ok(None);
    }
    if crate::fork::is_child() {
        let what = "this process was forked from one whose controller is open; only that one can use it";
        return Err(Error::new(client::error::NO_ANSWER, format!("{}: {what}", prepared.name())));
    }
    if let Some(more) = prepared.more() {
        // SAFETY: as the caller says.
        return unsafe { beyond::call(slot, prepared, more, core, args) };
    }
    let goes_first = matches!(prepared.name(), "Abort" | "Close");
    let mut state = if goes_first { slot.lock_first() } else { slot.lock() };
    if prepared.prototype.function.shape == Shape::Host {
        return match prepared.name() {
            "Open" => {
                let param = match args.get(1) {
                    Some(Arg::Int(param)) => *param,
                    _ => 1,
                };
                let gtn = prepared.prototype.form == Form::Gtn;
                state.open(Opening { slot, gtn, param }).map(|()| None)
            }
            _ => state.close().map(|()| None),
        };
    }
    let version = state.version();
    let card = state.card(prepared.name())?;
    card.step_homes();
    prepared.check_addresses(args)?;
    let note = match prepared.name() {
        "LoadConfig" => {
            // SAFETY: the caller's text ends with a 0.
            return unsafe { config::load_config(card, core, args) };
        }
        "GetVersion" => {
            if let Some(Arg::Address(address)) = args.first() {
                // SAFETY: the caller's address is that of an address.
                unsafe { address.cast::<*const c_char>().write_unaligned(version) };
            }
            return card.passed(true).map(|()| None);
        }
        _ => {
            if prepared.prototype.function.reports_stop() {
                prepared.check_room(args)?;
            }
            // SAFETY: as the caller says.
            let given = unsafe { prepared.given(args)? };
            let each = given.0.iter().flat_map(|(name, elements)| elements.iter().map(|element| (*name, *element)));
            card.note(prepared.prototype.function, core, each);
            let calls = prepared.requests(core, args, given)?;
            let replies = card.send(prepared.reads(), &calls).map_err(|error| prepared.under_its_name(error));
            let Some(replies) = replies? else {
                return Ok(None);
            };
            let mut before = 0;
            for reply in &replies {
                // SAFETY: as the caller says.
                before = unsafe { prepared.store(args, reply, before)? };
            }
            // SAFETY: as the caller says.
            unsafe { prepared.store_rest(args, before) };
            if let Some(reply) = replies.first().filter(|_| prepared.prototype.function.reports_stop()) {
                // SAFETY: as the caller says.
                unsafe { prepared.store_stop(args, reply) };
            }
            if prepared.name() == "Reset" {
                card.kept.reset(core);
                card.homes().reset(core);
            }
            if is_start(prepared) {
                card.started = true;
            }
            replies.iter().find_map(|reply| replies::limited(prepared, reply))
        }
    };
    card.passed(prepared.reads())?;
    Ok(note)
}

/// Whether the call sets axes in motion.
fn is_start(prepared: &Prepared) -> bool {
    prepared.command.is_some_and(|command| command.class.kind == CommandKind::Start)
}

/// The card that a compat function is for: the single one, else the first that is open.
pub fn any_card() -> Option<CardSlot> {
    if crate::fork::is_child() {
        return None;
    }
    card::all().find(|slot| slot.lock().is_open())
}

#[cfg(test)]
mod tests;
