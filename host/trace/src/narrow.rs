//! Trace files of everything, without what a program did not use.
//!
//! In: a CSV or a VCD that this crate wrote, and whom to keep: `axis1`, `laser0`, `crd1`, as the
//! columns begin. Out: the same with fewer columns or signals. Fails as its files do, or where the
//! file is none of these.
use crate::Result;
use crate::csv_file::as_io;
use std::collections::BTreeSet;
use std::io::{BufRead, Write};
use vcd::{Command, IdCode};

/// Whom a column or a signal belongs to: `axis1` of `axis1_pos`.
fn owner(name: &str) -> &str {
    ["_freq_khz", "_dac_mv", "_mv"]
        .iter()
        .find_map(|end| name.strip_suffix(end))
        .or_else(|| name.rsplit_once('_').map(|(owner, _)| owner))
        .unwrap_or(name)
}

/// Writes a CSV with its times and the columns of those in `kept`.
pub fn narrow_csv(from: impl BufRead, to: impl Write, kept: &BTreeSet<String>) -> Result<()> {
    let mut rows = csv::ReaderBuilder::new().has_headers(false).from_reader(from);
    let mut out = csv::WriterBuilder::new().buffer_capacity(1 << 16).from_writer(to);
    let mut columns: Option<Vec<bool>> = None;
    let mut row = csv::ByteRecord::new();
    while rows.read_byte_record(&mut row).map_err(as_io)? {
        let is_kept = columns.get_or_insert_with(|| {
            let of = |name: &[u8]| kept.contains(owner(&String::from_utf8_lossy(name)));
            row.iter().enumerate().map(|(column, name)| column == 0 || of(name)).collect()
        });
        out.write_record(row.iter().zip(&*is_kept).filter(|(_, kept)| **kept).map(|(field, _)| field))
            .map_err(as_io)?;
    }
    Ok(out.flush()?)
}

/// General and analog outputs of a VCD that change after its start.
pub fn outputs_that_change(from: impl BufRead) -> Result<BTreeSet<String>> {
    let mut signals: Vec<(IdCode, String)> = Vec::new();
    let mut changed = BTreeSet::new();
    let mut begun = false;
    for command in vcd::Parser::new(from) {
        match command? {
            Command::VarDef(_, _, id, name, _) if ["do", "ao"].iter().any(|kind| name.starts_with(kind)) => {
                signals.push((id, owner(&name).to_owned()));
            }
            Command::Timestamp(at) => begun = at > 0,
            Command::ChangeScalar(id, _) | Command::ChangeReal(id, _) if begun => {
                if let Some((_, name)) = signals.iter().find(|(signal, _)| *signal == id) {
                    changed.insert(name.clone());
                }
            }
            _ => {}
        }
    }
    Ok(changed)
}

/// Writes a VCD with the signals of those in `kept`.
pub fn narrow_vcd(from: impl BufRead, to: impl Write, kept: &BTreeSet<String>) -> Result<()> {
    let mut out = vcd::Writer::new(to);
    let mut dropped: BTreeSet<IdCode> = BTreeSet::new();
    // Times at which nothing else happens are left out, but for the last one.
    let mut time = None;
    for command in vcd::Parser::new(from) {
        let command = command?;
        let is_dropped = match &command {
            Command::VarDef(_, _, id, name, _) if !kept.contains(owner(name)) => dropped.insert(*id),
            Command::ChangeScalar(id, _) | Command::ChangeReal(id, _) => dropped.contains(id),
            _ => false,
        };
        match command {
            Command::Timestamp(_) => time = Some(command),
            _ if is_dropped => {}
            _ => {
                if let Some(time) = time.take() {
                    out.command(&time)?;
                }
                out.command(&command)?;
            }
        }
    }
    if let Some(time) = time {
        out.command(&time)?;
    }
    Ok(out.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn owners_are_what_columns_and_signals_begin_with() {
        let names = ["axis1_pos", "core2_axis10_vel", "laser0_freq_khz", "laser1_dac_mv", "crd1_vel", "do3", "ao2_mv"];
        let owners = names.map(owner);
        assert_eq!(owners, ["axis1", "core2_axis10", "laser0", "laser1", "crd1", "do3", "ao2"]);
    }
}
