//! A CSV of SPEC 8 back to a header and rows, for pictures.
//!
//! In: a file that [`crate::CsvWriter`] wrote, or part of one. Out: rows; six decimals of them.
//! What the file does not say is inferred: a laser whose power is its rate in every row is in
//! frequency mode, one with power and no rate in analog mode. Fails with the line and the column.

use crate::row::{AxisName, AxisPoint, CrdName, Header, LaserName, LaserPoint, PowerUnit, Row};
use crate::{Result, TraceError};
use servo::segment::piece::Scaled;
use servo::units::Pos;
use std::io::Read;

/// Fraction bits of a velocity or a power that was read: finer than six decimals.
const FRACTION_BITS: i16 = 24;

/// What a column holds, and of which axis, laser or path of the header.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    Time,
    Position(usize),
    Velocity(usize),
    Gate(usize),
    Power(usize),
    Rate(usize),
    Speed(usize),
}

fn wrong(line: u64, what: String) -> TraceError {
    TraceError::Csv { line, what }
}

/// The place of `name` among `known`; new ones are added.
fn index_of<T: PartialEq>(known: &mut Vec<T>, name: T) -> usize {
    known.iter().position(|other| *other == name).unwrap_or_else(|| {
        known.push(name);
        known.len() - 1
    })
}

fn column(name: &str, header: &mut Header) -> Option<Column> {
    if name == "t_ms" {
        return Some(Column::Time);
    }
    let (core, rest) = match name.strip_prefix("core") {
        Some(rest) => rest.split_once('_').and_then(|(core, rest)| Some((core.parse().ok()?, rest)))?,
        None => (1u8, name),
    };
    let (what, kind) = rest.split_once('_')?;
    let number = |prefix: &str| what.strip_prefix(prefix).and_then(|digits| digits.parse::<u8>().ok());
    if let Some(axis) = number("axis").filter(|axis| *axis > 0) {
        let axis = index_of(&mut header.axes, AxisName { core, axis });
        return match kind {
            "pos" => Some(Column::Position(axis)),
            "vel" => Some(Column::Velocity(axis)),
            _ => None,
        };
    }
    if let Some(laser) = number("laser") {
        let laser = index_of(&mut header.lasers, LaserName(laser));
        return match kind {
            "gate" => Some(Column::Gate(laser)),
            "power" => Some(Column::Power(laser)),
            "freq_khz" => Some(Column::Rate(laser)),
            _ => None,
        };
    }
    let crd = index_of(&mut header.crds, CrdName { core, crd: number("crd").filter(|crd| *crd > 0)? });
    (kind == "vel").then_some(Column::Speed(crd))
}

fn scaled(value: f64) -> Scaled {
    Scaled { m: (value * f64::from(1u32 << FRACTION_BITS)).round() as i64, e: FRACTION_BITS }
}

/// The header and all rows of a file. A last line that was cut off is left out.
///
/// # Errors
/// A column or a number that no trace has, with its line.
pub fn read_csv(file: impl Read) -> Result<(Header, Vec<Row>)> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(file);
    let failed = |error: csv::Error| {
        let line = error.position().map_or(0, csv::Position::line);
        if error.is_io_error() { TraceError::Unreadable(error.into()) } else { wrong(line, error.to_string()) }
    };
    let mut header = Header { every: 1, ..Header::default() };
    let names = reader.headers().map_err(failed)?.clone();
    let columns = names.iter().map(|name| {
        let found = column(name, &mut header);
        found
            .ok_or_else(|| wrong(1, format!("`{}` is no column of a trace", name.chars().take(40).collect::<String>())))
    });
    let columns = columns.collect::<Result<Vec<Column>>>()?;
    if columns.first() != Some(&Column::Time) {
        return Err(wrong(1, "the first column is not t_ms".to_owned()));
    }
    let mut rows = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(failed)? {
        let line = record.position().map_or(0, csv::Position::line);
        let row = if record.len() == columns.len() {
            row(&record, &columns, &header, rows.len(), line)
        } else {
            Err(wrong(line, format!("{} values, and the trace has {} columns", record.len(), columns.len())))
        };
        // Too few values, or the last one is the beginning of a number.
        let is_cut = record.len() < columns.len() || matches!(record.iter().next_back(), Some("" | "-"));
        match row {
            Ok(row) => rows.push(row),
            // The end of a file that was cut off.
            Err(_) if is_cut && !reader.read_record(&mut record).map_err(failed)? => break,
            Err(error) => return Err(error),
        }
    }
    infer_units(&header, &mut rows);
    header.period_ns = rows.get(1).map_or(0, |second: &Row| second.t_ns.saturating_sub(rows[0].t_ns));
    Ok((header, rows))
}

fn row(record: &csv::StringRecord, columns: &[Column], header: &Header, index: usize, line: u64) -> Result<Row> {
    let mut row = Row {
        index: u32::try_from(index).unwrap_or(u32::MAX),
        axes: vec![AxisPoint::default(); header.axes.len()],
        lasers: vec![LaserPoint::default(); header.lasers.len()],
        crds: vec![Scaled::default(); header.crds.len()],
        ..Row::default()
    };
    for (field, column) in record.iter().zip(columns) {
        let value: f64 = field
            .trim()
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| wrong(line, format!("`{}` is no number", field.chars().take(40).collect::<String>())))?;
        match *column {
            Column::Time => row.t_ns = (value * 1e6).round() as u64,
            Column::Position(axis) => {
                row.axes[axis].pos = Pos((value * f64::from(1u32 << Pos::FRAC_BITS)).round() as i64)
            }
            Column::Velocity(axis) => row.axes[axis].vel = scaled(value),
            Column::Gate(laser) => row.lasers[laser].gate = value != 0.0,
            Column::Power(laser) => row.lasers[laser].power = scaled(value),
            Column::Rate(laser) => row.lasers[laser].frequency = scaled(value),
            Column::Speed(crd) => row.crds[crd] = scaled(value),
        }
    }
    Ok(row)
}

fn infer_units(header: &Header, rows: &mut [Row]) {
    for laser in 0..header.lasers.len() {
        let lit: Vec<LaserPoint> =
            rows.iter().map(|row| row.lasers[laser]).filter(|point| point.power.m != 0).collect();
        let unit = match lit.first() {
            None => PowerUnit::Percent,
            Some(first) if first.frequency.m == 0 => PowerUnit::Volt,
            Some(_) if lit.iter().all(|point| point.frequency == point.power) => PowerUnit::Kilohertz,
            Some(_) => PowerUnit::Percent,
        };
        rows.iter_mut().for_each(|row| row.lasers[laser].unit = unit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "t_ms,axis1_pos,axis1_vel,core2_axis3_pos,core2_axis3_vel,laser0_gate,laser0_power,laser0_freq_khz,crd1_vel\n\
                        0.000000,0.000000,0.000000,-1.500000,0.250000,0,0.000000,0.000000,0.000000\n\
                        0.250000,0.125000,1.000000,-1.250000,0.250000,1,20.000000,20.000000,3.000000\n";

    #[test]
    fn a_file_that_is_read_is_written_again() {
        let (header, rows) = read_csv(FILE.as_bytes()).unwrap();
        assert_eq!((header.axes.len(), header.lasers.len(), header.crds.len(), rows.len()), (2, 1, 1, 2));
        assert_eq!(rows[1].lasers[0].unit, PowerUnit::Kilohertz);
        let mut out = Vec::new();
        let mut writer = crate::CsvWriter::new(&mut out, &header).unwrap();
        rows.iter().for_each(|row| writer.row(row).unwrap());
        writer.finish().unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), FILE);
    }

    #[test]
    fn what_is_no_trace_is_named_with_its_line() {
        for (text, line, part) in [
            ("t_ms,axis1_speed\n", 1, "axis1_speed"),
            ("axis1_pos,t_ms\n0,0\n", 1, "t_ms"),
            ("t_ms,axis1_pos\n0,0\n1,x\n", 3, "`x`"),
            ("t_ms,axis1_pos\n0,0\n1\n2,0\n", 3, "1 values"),
        ] {
            match read_csv(text.as_bytes()).unwrap_err() {
                TraceError::Csv { line: found, what } => {
                    assert!(found == line && what.contains(part), "{found}: {what}")
                }
                other => panic!("{other}"),
            }
        }
        // Cut off in its last line.
        for end in ["1", "1,", "1,-"] {
            assert_eq!(read_csv(format!("t_ms,axis1_pos\n0,0\n{end}").as_bytes()).unwrap().1.len(), 1, "{end}");
        }
    }
}
