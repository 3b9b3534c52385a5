//! Lines in pairs: a group code and a value.
use crate::fault::Fault;

/// Largest number of a coordinate.
const COORDINATE_MAX: f64 = 1e9;

/// A code and its value.
#[derive(Debug, Clone, Copy)]
pub struct Group<'a> {
    pub code: i32,
    pub value: &'a str,
    /// Line of the value.
    pub line: u32,
}

pub struct Groups<'a> {
    lines: std::str::Lines<'a>,
    line: u32,
    /// One that was read too early.
    back: Option<Group<'a>>,
}

impl<'a> Groups<'a> {
    pub fn new(text: &'a str) -> Groups<'a> {
        Groups { lines: text.trim_start_matches('\u{feff}').lines(), line: 0, back: None }
    }

    /// The next group.
    ///
    /// # Errors
    /// The file ends (`missing`), or the code is none.
    pub fn expect(&mut self, missing: &str) -> Result<Group<'a>, Fault> {
        if let Some(group) = self.back.take() {
            return Ok(group);
        }
        let end = |line: u32| Fault::at(line.max(1), format!("this is no whole DXF: {missing}"));
        let code = self.lines.next().ok_or_else(|| end(self.line))?.trim();
        self.line += 1;
        let number = code.parse().map_err(|_| {
            let shown: String = code.chars().filter(|letter| !letter.is_control()).take(40).collect();
            Fault::at(self.line, format!("this is no DXF: `{shown}` is no group code"))
        })?;
        let value = self.lines.next().ok_or_else(|| end(self.line))?.trim();
        self.line += 1;
        Ok(Group { code: number, value, line: self.line })
    }

    /// Passes over groups up to the next that begins something.
    pub fn skip_body(&mut self) {
        while let Ok(group) = self.expect("") {
            if group.code == 0 {
                self.back = Some(group);
                return;
            }
        }
    }
}

impl Group<'_> {
    pub fn real(&self) -> Result<f64, Fault> {
        let number = self.value.parse::<f64>().ok().filter(|number| number.abs() <= COORDINATE_MAX);
        number.ok_or_else(|| self.wrong("no number within ±1000000000"))
    }

    pub fn whole(&self) -> Result<i64, Fault> {
        let number = self.value.parse::<i64>().ok().filter(|number| number.unsigned_abs() <= 1 << 32);
        number.ok_or_else(|| self.wrong("no whole number"))
    }

    fn wrong(&self, what: &str) -> Fault {
        let shown: String = self.value.chars().filter(|letter| !letter.is_control()).take(40).collect();
        Fault::at(self.line, format!("`{shown}`, of group {}, is {what}", self.code))
    }
}
