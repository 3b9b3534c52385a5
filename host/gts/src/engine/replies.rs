//! From a reply to what the caller gets: values at its addresses, a text, a note of what was
//! limited.
use super::{Kind, Prepared, scalar_member};
use crate::boundary::Arg;
use crate::prototype::Scalar;
use crate::reason;
use crate::request::{self, Number, fields, size};
use client::{Error, Result};
use protocol::reason::{Reason, stop_reason};

impl Prepared {
    /// Stores what one reply brings; `before` values of arrays came with replies before it.
    ///
    /// # Safety
    /// As for [`call`].
    pub(super) unsafe fn store(&self, args: &[Arg], mut reply: &[u8], before: usize) -> Result<usize> {
        let Some(command) = self.command else { return Ok(0) };
        let short = || Error::new(client::error::LINK_PROTOCOL, format!("{}: the reply is too short", self.name()));
        let fixed = fields(command.reply, &mut reply).ok_or_else(short)?;
        let put = |argument: usize, of: Scalar, index: usize, number: Option<&Number>| {
            if let (Some(Arg::Address(address)), Some(number)) = (args.get(argument), number)
                && !address.is_null()
            {
                // SAFETY: the caller's address is that of as many values as it asked for.
                unsafe { request::store(address.byte_add(index * size(of)), of, *number) };
            }
        };
        if let Some(clock) = self.clock {
            let place = command.reply.iter().position(|(name, _)| *name == "clock_ms");
            put(clock, Scalar::ULong, 0, place.and_then(|place| fixed.get(place)?.first()));
        }
        if command.reply_items.is_empty() {
            for (argument, of, place) in &self.outs {
                put(*argument, *of, 0, fixed.get(*place).and_then(|field| field.first()));
            }
            for (argument, arg) in self.prototype.arguments.iter().zip(args) {
                if let (Kind::OutStruct(of), Arg::Address(address)) = (argument.kind, arg) {
                    for ((name, ..), numbers) in of.fields().iter().zip(&fixed) {
                        let (scalar, offset) = scalar_member(of, name);
                        for (n, number) in numbers.iter().enumerate() {
                            // SAFETY: the caller's struct has this member.
                            unsafe { request::store(address.byte_add(offset + n * size(scalar)), scalar, *number) };
                        }
                    }
                }
            }
            return Ok(0);
        }
        let most = match self.count.and_then(|count| args.get(count)) {
            Some(Arg::Int(count)) => usize::try_from(*count).unwrap_or(0),
            // One for each coordinate.
            _ => usize::MAX,
        };
        let mut index = before;
        while !reply.is_empty() && index < most {
            let item = fields(command.reply_items, &mut reply).ok_or_else(short)?;
            for (argument, of, place) in &self.outs {
                // The clock of a reply that has one in each item is that of the first.
                let clock = self.prototype.arguments.get(*argument).is_some_and(|argument| argument.name == "clock");
                if !clock || index == 0 {
                    put(*argument, *of, index, item.get(*place).and_then(|field| field.first()));
                }
            }
            index += 1;
        }
        Ok(index)
    }
}

impl Prepared {
    /// Stores zeros for what `count` asks for and no reply brought: it lies past the last axis (GXN
    /// table 5-1, note 2).
    ///
    /// # Safety
    /// As for [`call`].
    pub(super) unsafe fn store_rest(&self, args: &[Arg], stored: usize) {
        let items = self.command.is_some_and(|command| !command.reply_items.is_empty());
        let Some(Arg::Int(count)) = self.count.filter(|_| items).and_then(|count| args.get(count)) else { return };
        for index in stored..usize::try_from(*count).unwrap_or(0) {
            for (argument, of, _) in &self.outs {
                let clock = self.prototype.arguments.get(*argument).is_some_and(|argument| argument.name == "clock");
                if let Some(Arg::Address(address)) = args.get(*argument).filter(|_| !clock)
                    && !address.is_null()
                {
                    // SAFETY: the caller's address is that of as many values as it asked for.
                    unsafe { request::store(address.byte_add(index * size(*of)), *of, Number::Int(0)) };
                }
            }
        }
    }
}

/// Functions that fill a text.
impl Prepared {
    /// Address for the text, and its size in bytes; nothing if no text is wanted.
    fn room(&self, args: &[Arg]) -> Option<(*mut u8, i64)> {
        let place = |wanted: &str| self.prototype.arguments.iter().position(|argument| argument.name == wanted);
        match (args.get(place("text")?), args.get(place("size")?)) {
            (Some(Arg::Address(text)), Some(Arg::Int(size))) if !text.is_null() => Some((text.cast(), *size)),
            _ => None,
        }
    }

    /// A text that is wanted needs room for its end.
    pub(super) fn check_room(&self, args: &[Arg]) -> Result<()> {
        match self.room(args) {
            Some((_, size @ ..=0)) => {
                Err(reason::wrong(self.name(), "size", Reason::OutOfRange, size as f64, 1.0, f64::from(i16::MAX)))
            }
            _ => Ok(()),
        }
    }

    /// Writes a text into its room, cut to it.
    ///
    /// # Safety
    /// The text has `size` bytes.
    pub(super) unsafe fn store_text(&self, args: &[Arg], message: &str) {
        let Some((text, size)) = self.room(args) else { return };
        let Some(most) = usize::try_from(size).ok().and_then(|size| size.checked_sub(1)) else { return };
        let mut end = message.len().min(most);
        while !message.is_char_boundary(end) {
            end -= 1;
        }
        // SAFETY: `end` is less than `size`.
        unsafe {
            text.copy_from_nonoverlapping(message.as_ptr(), end);
            text.add(end).write(0);
        }
    }

    /// The text of the reason in a reply.
    ///
    /// # Safety
    /// As for [`call`].
    pub(super) unsafe fn store_stop(&self, args: &[Arg], mut reply: &[u8]) {
        let Some(command) = self.command else { return };
        let layout = [command.reply, command.reply_items].concat();
        let values = fields(&layout, &mut reply).unwrap_or_default();
        let number = layout.iter().zip(&values).find(|((name, _), _)| *name == "reason");
        if let Some([Number::Int(number)]) = number.map(|(_, values)| values.as_slice()) {
            // SAFETY: as the caller says.
            unsafe { self.store_text(args, stop_reason(*number as u16)) };
        }
    }
}

/// What a laser command did not take as it was given (LSR: the nearest bound), from its reply's
/// `limited`.
pub(super) fn limited(prepared: &Prepared, mut reply: &[u8]) -> Option<String> {
    let command = prepared.command?;
    if command.reply.last().is_none_or(|(name, _)| *name != "held") || prepared.reads() {
        return None;
    }
    let values = fields(command.reply, &mut reply)?;
    let Some([Number::Int(bits @ 1..)]) = values.last().map(Vec::as_slice) else { return None };
    if let [(_, "U16")] = command.reply {
        return Some(format!("{}: {bits} values are out of range; the nearest bounds are taken", prepared.name()));
    }
    let mut texts = Vec::new();
    for (place, ((name, _), value)) in command.reply.iter().zip(&values).enumerate() {
        let name = if *name == "value" { "the value" } else { name };
        match value.first() {
            Some(Number::Int(taken)) if bits >> place & 1 == 1 => {
                texts.push(format!("{name} is out of range; {taken} is taken"));
            }
            Some(Number::Real(taken)) if bits >> place & 1 == 1 => {
                texts.push(format!("{name} is out of range; {taken} is taken"));
            }
            _ => {}
        }
    }
    if bits >> 7 & 1 == 1 {
        texts.push(
            "the pulse width reaches the period at the highest rate; there it is limited to just under it".to_owned(),
        );
    }
    Some(format!("{}: {}", prepared.name(), texts.join("; ")))
}
