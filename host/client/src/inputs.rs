//! A file of inputs: levels of the virtual and the emulated board's inputs, and their times (SPEC
//! 7, `--inputs`).
//!
//! In: CSV with the columns `t_ms,input,level`. Out: rows in order of time, which [`Inputs::plan`]
//! sends to the controller. Fails with file, line and column, and the limit that was exceeded; a
//! refusal of the controller names the line.
use crate::call::Call;
use crate::client::Client;
use crate::error::{Error, Result};
use protocol::command::SimPlan;
use protocol::reason::{Reason, describe};
use protocol::values::{ANALOG_INPUT_VOLTS as VOLTS, io};
use std::fmt::Display;
use std::path::Path;

/// The columns.
const COLUMNS: [&str; 3] = ["t_ms", "input", "level"];
/// Rows of a file.
const MAX_ROWS: usize = u16::MAX as usize;
/// The latest time, ms: a year.
const LATEST_MS: f64 = 365.0 * 86_400_000.0;
/// Rows that are sent together.
const BATCH_ROWS: usize = 256;
/// Names of inputs: the text before the number, the type of SimInput, the highest number that any
/// board has.
const NAMES: [(&str, i16, i16); 7] = [
    ("limit_positive", io::LIMIT_POSITIVE, 32),
    ("limit_negative", io::LIMIT_NEGATIVE, 32),
    ("alarm", io::ALARM, 32),
    ("home", io::HOME, 32),
    ("gpi", io::GPI, 100),
    ("arrive", io::ARRIVE, 32),
    ("adc", io::ADC, 8),
];
/// Characters of a file that a message quotes at most.
const QUOTED_CHARACTERS: usize = 40;

/// From when the rows count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zero {
    /// From now on.
    Now,
    /// From the zero of the script clock of the next program.
    Program,
}

/// An input by its name in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Name {
    /// Logical core, from 1.
    pub core: i16,
    /// Type of SimInput, or 24 (MC_ADC).
    pub di_type: i16,
    /// Number, from 1.
    pub index: i16,
}

impl Name {
    /// `gpi3`, `home1`, `core2_home1`, `interlock` and the like.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(text: &str) -> std::result::Result<Name, String> {
        let (core, name) = match text.strip_prefix("core").and_then(|rest| rest.split_once('_')) {
            Some((core, name)) => (number(core, 2).ok_or_else(|| unknown(text))?, name),
            None => (1, text),
        };
        if name == "interlock" {
            return Ok(Name { core, di_type: io::INTERLOCK, index: 1 });
        }
        let digits = name.trim_start_matches(|letter: char| !letter.is_ascii_digit());
        let kind = &name[..name.len() - digits.len()];
        let Some((kind, di_type, most)) = NAMES.into_iter().find(|(known, ..)| *known == kind) else {
            return Err(unknown(text));
        };
        match number(digits, most) {
            Some(index) => Ok(Name { core, di_type, index }),
            None => Err(format!("`{}` is no number of {kind}; it is from 1 to {most}", quoted(digits))),
        }
    }
}

/// What an input is called: `gpi3`, `home1`, `core2_home1`.
pub fn name(core: i16, di_type: i16, index: i16) -> String {
    let kind = NAMES.iter().find(|(_, known, _)| *known == di_type).map(|(kind, ..)| *kind);
    let name = kind.map_or_else(|| "interlock".to_owned(), |kind| format!("{kind}{index}"));
    if core == 1 || matches!(di_type, io::GPI | io::ADC | io::INTERLOCK) { name } else { format!("core{core}_{name}") }
}

/// A number from 1 to `most`.
fn number(text: &str, most: i16) -> Option<i16> {
    text.parse().ok().filter(|number| (1..=most).contains(number))
}

fn unknown(text: &str) -> String {
    format!(
        "`{}` is no input; known are gpi1, home1, limit_positive1, limit_negative1, alarm1, arrive1, adc1 with their numbers, \
         interlock, and core2_home1 for another core",
        quoted(text)
    )
}

fn quoted(text: &str) -> String {
    text.chars().take(QUOTED_CHARACTERS).collect()
}

/// A row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Its line in the file, from 1.
    pub line: u64,
    /// When, in ns.
    pub at_ns: u64,
    /// Which.
    pub input: Name,
    /// Level 0 or 1 at the terminal; of an analog input volts.
    pub value: f64,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    name: String,
    rows: Vec<Row>,
}

impl Inputs {
    /// Reads a file.
    ///
    /// # Errors
    /// A sentence with file, line and column.
    pub fn open(path: &Path) -> std::result::Result<Inputs, String> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| format!("{name}: the inputs cannot be read: {error}"))?;
        Inputs::read(&name, &bytes)
    }

    /// Reads the text of the file `name`.
    ///
    /// # Errors
    /// A sentence with file, line and column.
    pub fn read(name: &str, text: &[u8]) -> std::result::Result<Inputs, String> {
        let mut reader = csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(text);
        let columns = reader.headers().map_err(|error| broken(name, &error))?;
        if columns.iter().ne(COLUMNS) {
            let found: Vec<String> = columns.iter().map(quoted).collect();
            let found = quoted(&found.join(","));
            return Err(format!("{name}:1: the columns are `{found}`; they are {}", COLUMNS.join(",")));
        }
        let mut rows: Vec<Row> = Vec::new();
        let (mut line, mut counted) = (1, 0);
        for record in reader.records() {
            let record = record.map_err(|error| broken(name, &error))?;
            // The reader's own count is off in the middle of a CR LF, and before empty lines.
            let start = record.position().map_or(0, |position| position.byte() as usize);
            while counted < start || matches!(text.get(counted), Some(b'\r' | b'\n')) {
                line += u64::from(text.get(counted) == Some(&b'\n'));
                counted += 1;
            }
            let wrong = |column: &str, what: &dyn Display| Err(format!("{name}:{line}: {column}: {what}"));
            let [t_ms, input, level] = [record.get(0), record.get(1), record.get(2)].map(Option::unwrap_or_default);
            if record.len() != COLUMNS.len() {
                return wrong(COLUMNS[record.len().min(2)], &format!("the row has {} values; it has 3", record.len()));
            }
            let at_ns = match t_ms.parse::<f64>() {
                Ok(ms) if (0.0..=LATEST_MS).contains(&ms) => (ms * 1e6).round() as u64,
                Ok(_) => return wrong("t_ms", &format!("{} ms; it must be from 0 to {LATEST_MS}", quoted(t_ms))),
                Err(_) => return wrong("t_ms", &format!("`{}` is no number", quoted(t_ms))),
            };
            if let Some(before) = rows.last().filter(|before| at_ns < before.at_ns) {
                return wrong(
                    "t_ms",
                    &format!(
                        "{} ms is before the {} ms of line {}",
                        quoted(t_ms),
                        before.at_ns as f64 / 1e6,
                        before.line
                    ),
                );
            }
            let input = match Name::read(input) {
                Ok(input) => input,
                Err(what) => return wrong("input", &what),
            };
            let value = match (level.parse::<f64>(), input.di_type) {
                (Ok(volts), io::ADC) if (-VOLTS..=VOLTS).contains(&volts) => volts,
                (Ok(_), io::ADC) => {
                    return wrong("level", &format!("{} V; it must be from -{VOLTS} to {VOLTS}", quoted(level)));
                }
                (Ok(value), _) if value == 0.0 || value == 1.0 => value,
                (Ok(_), _) => return wrong("level", &format!("{}; it is 0 (low) or 1 (high)", quoted(level))),
                (Err(_), _) => return wrong("level", &format!("`{}` is no number", quoted(level))),
            };
            if rows.len() == MAX_ROWS {
                return wrong("t_ms", &format!("the file has more than {MAX_ROWS} rows"));
            }
            rows.push(Row { line, at_ns, input, value });
        }
        Ok(Inputs { name: name.to_owned(), rows })
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its rows, in order of time.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Sends the rows to the controller; they replace those that it had.
    ///
    /// # Errors
    /// The controller's refusal of a row, with file and line; 1 from a board whose inputs are
    /// wired. Then no row of a plan that counts from a program acts.
    pub fn plan(&self, client: &Client, zero: Zero) -> Result<()> {
        let calls: Vec<Call> = (0u16..)
            .zip(&self.rows)
            .map(|(number, row)| {
                Call::of(SimPlan {
                    core: row.input.core.into(),
                    row: number.into(),
                    from: u8::from(zero == Zero::Program),
                    at_ns: row.at_ns.into(),
                    di_type: row.input.di_type.into(),
                    index: row.input.index.into(),
                    value: row.value.into(),
                })
            })
            .collect();
        for (rows, calls) in self.rows.chunks(BATCH_ROWS).zip(calls.chunks(BATCH_ROWS)) {
            for (row, reply) in rows.iter().zip(client.call_all(calls)?) {
                reply.map_err(|error| self.of_line(row, error))?;
            }
        }
        Ok(())
    }

    /// A refusal, with the line that it is of.
    fn of_line(&self, row: &Row, error: Error) -> Error {
        let Some(refusal) = error.refusal else { return error };
        let column = match refusal.field {
            0 | 4 | 5 => "input",
            6 => "level",
            _ => "t_ms",
        };
        let what = match refusal.reason() {
            Some(Reason::OutOfRange) if refusal.field == 1 => {
                format!("this board holds {} rows of inputs", refusal.high.get() + 1.0)
            }
            Some(Reason::InputsWired) => {
                return Error { reason: format!("{}: {}", self.name, describe("", "", refusal)), ..error };
            }
            _ => describe("", if refusal.field == 0 { "the core" } else { "the number" }, refusal).to_string(),
        };
        Error { reason: format!("{}:{}: {column}: {what}", self.name, row.line), ..error }
    }
}

fn broken(name: &str, error: &csv::Error) -> String {
    let line = error.position().map_or(1, csv::Position::line);
    format!("{name}:{line}: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        Inputs::read("f.csv", text.as_bytes()).unwrap_err()
    }

    #[test]
    fn every_kind_is_read_by_its_name() {
        let text = "t_ms,input,level\n0,gpi3,1\n0.25,home1,0\r\n1,limit_positive2,1\n1, limit_negative2 ,1\n2,alarm1,1\n\
                    2.000001,arrive8,1\n3,interlock,1\n3.5,adc8,-12.5\n4,core2_home12,1\n";
        let inputs = Inputs::read("f.csv", text.as_bytes()).unwrap();
        let rows: Vec<_> = inputs
            .rows()
            .iter()
            .map(|row| (row.line, row.at_ns, row.input.core, row.input.di_type, row.input.index, row.value))
            .collect();
        assert_eq!(
            rows,
            [
                (2, 0, 1, 4, 3, 1.0),
                (3, 250_000, 1, 3, 1, 0.0),
                (4, 1_000_000, 1, 0, 2, 1.0),
                (5, 1_000_000, 1, 1, 2, 1.0),
                (6, 2_000_000, 1, 2, 1, 1.0),
                (7, 2_000_001, 1, 5, 8, 1.0),
                (8, 3_000_000, 1, 90, 1, 1.0),
                (9, 3_500_000, 1, 24, 8, -12.5),
                (10, 4_000_000, 2, 3, 12, 1.0),
            ]
        );
        for row in inputs.rows() {
            let Name { core, di_type, index } = row.input;
            assert_eq!(Name::read(&name(core, di_type, index)), Ok(row.input));
        }
    }

    #[test]
    fn what_is_wrong_is_reported_with_line_and_column_and_limit() {
        let head = "t_ms,input,level\n0,gpi1,1\n";
        for (text, expected) in [
            ("", "f.csv:1: the columns are ``; they are t_ms,input,level"),
            ("time,input,level\n", "f.csv:1: the columns are `time,input,level`; they are t_ms,input,level"),
            ("0,gpi1,1\n", "f.csv:1: the columns are `0,gpi1,1`; they are t_ms,input,level"),
        ] {
            assert_eq!(error(text), expected);
        }
        for (row, expected) in [
            ("x,gpi1,1", "f.csv:3: t_ms: `x` is no number"),
            ("nan,gpi1,1", "f.csv:3: t_ms: nan ms; it must be from 0 to 31536000000"),
            ("-1,gpi1,1", "f.csv:3: t_ms: -1 ms; it must be from 0 to 31536000000"),
            ("1,gpi101,1", "f.csv:3: input: `101` is no number of gpi; it is from 1 to 100"),
            ("1,home0,1", "f.csv:3: input: `0` is no number of home; it is from 1 to 32"),
            ("1,home,1", "f.csv:3: input: `` is no number of home; it is from 1 to 32"),
            ("1,adc9,1", "f.csv:3: input: `9` is no number of adc; it is from 1 to 8"),
            ("1,gpi1,2", "f.csv:3: level: 2; it is 0 (low) or 1 (high)"),
            ("1,gpi1,high", "f.csv:3: level: `high` is no number"),
            ("1,adc1,12.6", "f.csv:3: level: 12.6 V; it must be from -12.5 to 12.5"),
            ("1,gpi1", "f.csv:3: level: the row has 2 values; it has 3"),
            ("1,gpi1,1,1", "f.csv:3: level: the row has 4 values; it has 3"),
            ("2,gpi1,1\n1,gpi1,0", "f.csv:4: t_ms: 1 ms is before the 2 ms of line 3"),
        ] {
            assert_eq!(error(&format!("{head}{row}\n")), expected);
        }
        for name in ["button1", "gpi-1", "home1x", "core0_home1", "core3_home1", "interlock1", "GPI1", "é"] {
            let found = error(&format!("{head}1,{name},1\n"));
            assert!(found.starts_with("f.csv:3: input: `"), "{found}");
        }
        assert!(error(&format!("{head}1,{},1\n", "x".repeat(100_000))).len() < 400);
        assert!(error(&"x".repeat(100_000)).len() < 400);
        let long = format!("1{}", "0".repeat(10_000));
        for row in
            [format!("{long},gpi1,1"), format!("1,gpi1,{long}"), format!("1,adc1,{long}"), format!("1,gpi{long},1")]
        {
            assert!(error(&format!("{head}{row}\n")).len() < 200);
        }
        assert!(error("t_ms,input,level\n1,gpi1,\u{fe}1\n").len() < 400);
        assert!(Inputs::read("f.csv", b"t_ms,input,level\n1,\xff,1\n").unwrap_err().starts_with("f.csv:2: "));
    }

    #[test]
    fn more_rows_than_a_plan_has_are_refused() {
        let text = |rows: usize| format!("t_ms,input,level\n{}", "1,gpi1,1\n".repeat(rows));
        assert_eq!(Inputs::read("f.csv", text(MAX_ROWS).as_bytes()).unwrap().rows().len(), 65535);
        assert_eq!(error(&text(MAX_ROWS + 1)), "f.csv:65537: t_ms: the file has more than 65535 rows");
    }
}
