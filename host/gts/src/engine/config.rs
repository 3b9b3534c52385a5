//! LoadConfig: a file as one configuration, taken whole or not at all.
use super::CONFIG_ITEMS;
use crate::boundary::Arg;
use crate::card::Card;
use client::{Call, Error, Result};
use protocol::command::{ConfigItem, LoadConfig, opcode};
use protocol::reason::describe_opcode;
use std::ffi::{CStr, c_char, c_short};

/// # Safety
/// The file's name ends with a 0.
pub(super) unsafe fn load_config(card: &mut Card, core: c_short, args: &[Arg]) -> Result<Option<String>> {
    let Some(Arg::Address(text)) = args.first() else { return Ok(None) };
    // SAFETY: as the caller says.
    let path = unsafe { CStr::from_ptr(text.cast::<c_char>()) }.to_string_lossy().into_owned();
    let bytes = std::fs::read(path.replace('\\', std::path::MAIN_SEPARATOR_STR));
    let bytes = bytes.map_err(|error| Error::new(7, format!("LoadConfig: {path} cannot be read: {error}")))?;
    let found = job::config::read(&path, &String::from_utf8_lossy(&bytes))
        .map_err(|error| Error::new(7, format!("LoadConfig: {error}")))?;
    let parts = found.items.chunks(CONFIG_ITEMS);
    if parts.len() > 1 {
        // A message is refused whole, a file of several would not be. A last item that every
        // controller refuses has the others looked at and nothing done.
        for (part, items) in parts.clone().enumerate() {
            let Err(error) = configure(card, core, &[items, &[ConfigItem::default()]].concat()) else {
                return Err(Error::new(client::error::LINK_PROTOCOL, "LoadConfig: the controller took an axis 0"));
            };
            if error.refusal.is_none_or(|refusal| usize::from(refusal.item.get()) != items.len()) {
                return Err(of_file(error, &path, &found.items, part * CONFIG_ITEMS));
            }
        }
    }
    for (part, items) in parts.enumerate() {
        configure(card, core, items).map_err(|error| of_file(error, &path, &found.items, part * CONFIG_ITEMS))?;
    }
    card.passed(false)?;
    Ok((!found.warnings.is_empty()).then(|| format!("LoadConfig: {}", found.warnings.join("; "))))
}

fn configure(card: &mut Card, core: c_short, items: &[ConfigItem]) -> Result<()> {
    let request = LoadConfig { core: core.into(), count: (items.len() as u16).into() };
    card.send(false, &[Call::with_items(request, items)]).map(drop)
}

/// A refusal of an item, counted and named as in the whole file; `before` items went before its
/// message.
fn of_file(mut error: Error, path: &str, items: &[ConfigItem], before: usize) -> Error {
    if let Some(refusal) = &mut error.refusal
        && let Some(item) = items.get(before + usize::from(refusal.item.get()))
    {
        refusal.item = ((before as u16) + refusal.item.get()).into();
        error.reason = format!("{}: axis {} in {path}", describe_opcode(opcode::LoadConfig, *refusal), item.axis);
    }
    error
}
