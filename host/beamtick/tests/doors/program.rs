//! One description of a program, from which each door gets its own form.
//!
//! A line is a call without its prefix and core, `sleep MS`, or a comment after `#`. Values stand
//! in the order of the table of functions: numbers, `[1 2 3]` arrays, `{acc=1 pos=[0 5]}` structs,
//! `"text"`, `*` for what the call fills, `_` for NULL.

use gts::prototype::Scalar;
use job::api::{Function, Pass, Size, Type, function};

/// What stands for a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Number(String),
    List(Vec<String>),
    Fields(Vec<(String, Vec<String>)>),
    Text(String),
    Out,
    Null,
}

/// A call of a function of the table.
#[derive(Debug, Clone)]
pub struct Call {
    pub function: &'static Function,
    /// The core of `GTN_`; nothing: it is called as `GT_`.
    pub core: Option<i16>,
    pub values: Vec<Value>,
}

#[derive(Debug, Clone)]
pub enum Step {
    Call(Call),
    Sleep(u32),
    /// Until these axes of a core are at rest, or for so long as [`crate::player::PATIENCE_MS`]
    /// says.
    Wait {
        core: i16,
        axes: u32,
    },
}

impl Call {
    /// The number given for a parameter.
    pub fn number(&self, name: &str) -> Option<i64> {
        let place = self.function.params.iter().position(|param| param.name == name)?;
        match self.values.get(place)? {
            Value::Number(text) => text.parse().ok(),
            _ => None,
        }
    }

    /// Elements of the array that a call fills.
    pub fn filled(&self) -> usize {
        match (self.function.name, self.number("count")) {
            ("GetCrdPos", _) => 4,
            (_, Some(count)) => usize::try_from(count).unwrap_or(0),
            (_, None) => 1,
        }
    }

    /// The same call with another value.
    pub fn with(&self, place: usize, value: Value) -> Call {
        let mut call = self.clone();
        call.values[place] = value;
        call
    }

    /// The same call with arrays of this length.
    pub fn of_length(&self, length: usize) -> Call {
        let mut call = self.clone();
        for (param, value) in self.function.params.iter().zip(&mut call.values) {
            match param.pass {
                Pass::In(_) if param.name == "count" => *value = Value::Number(length.to_string()),
                Pass::Fixed(_, 2) if param.name == "count" => *value = Value::List(vec![length.to_string(); 2]),
                Pass::Many(of, size) => {
                    let values = match size {
                        Size::Count | Size::Columns | Size::Rows => length,
                        Size::Each(times) => times * length,
                        Size::Grid => length * length,
                    };
                    let element = |n: usize| element(self.function.name, param.name, of, n % length.max(1));
                    *value = Value::List((0..values).map(element).collect());
                }
                _ => {}
            }
        }
        call
    }
}

/// The n-th value of an array that its function takes.
fn element(function: &str, name: &str, of: Type, n: usize) -> String {
    let continuous = function.contains("Continuous");
    match name {
        "time" => (10 * n).to_string(),
        "pos" if function.contains("Percent") => (5 * n).to_string(),
        "pos" | "xPos" | "yPos" => (10 * n).to_string(),
        "vel" if function == "SetLaserFollowTable" => n.to_string(),
        "vel" | "velBegin" | "velEnd" if continuous => "0".to_owned(),
        "vel" | "velBegin" | "velEnd" => "1".to_owned(),
        "velMax" => "2".to_owned(),
        "acc" | "dec" => "0.5".to_owned(),
        "axis" => (n + 1).to_string(),
        "power" => "10".to_owned(),
        "value" if of == Type::Short => (n % 100).to_string(),
        _ => "0".to_owned(),
    }
}

/// The steps of a description.
pub fn read(text: &str) -> Vec<Step> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or("").trim()).filter(|line| !line.is_empty());
    lines.map(step).collect()
}

fn step(line: &str) -> Step {
    let (name, rest) = line.split_once(' ').unwrap_or((line, ""));
    if name == "sleep" {
        return Step::Sleep(rest.trim().parse().unwrap());
    }
    let function = function(name).unwrap_or_else(|| panic!("{name} is no function"));
    let mut values = Vec::new();
    let mut rest = rest.trim();
    while !rest.is_empty() {
        let end = match rest.as_bytes()[0] {
            b'[' => rest.find(']').unwrap() + 1,
            b'{' => rest.find('}').unwrap() + 1,
            _ => rest.find(' ').unwrap_or(rest.len()),
        };
        values.push(value(&rest[..end]));
        rest = rest[end..].trim_start();
    }
    assert_eq!(values.len(), function.params.len(), "{line}: every parameter of the table has a value");
    Step::Call(Call { function, core: None, values })
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

fn value(text: &str) -> Value {
    match text.as_bytes()[0] {
        b'*' => Value::Out,
        b'_' => Value::Null,
        b'"' => Value::Text(text.trim_matches('"').to_owned()),
        b'[' => Value::List(words(text.trim_matches(['[', ']']))),
        b'{' => {
            // A field's array is joined by commas.
            let field = |word: String| {
                let (name, values) = word.split_once('=').unwrap();
                (name.to_owned(), values.split(',').map(str::to_owned).collect())
            };
            Value::Fields(words(text.trim_matches(['{', '}'])).into_iter().map(field).collect())
        }
        _ => Value::Number(text.to_owned()),
    }
}

/// Whether the values of a call are the same whenever it is made.
pub fn is_timeless(function: &Function) -> bool {
    !["GetClock", "GetVersion", "GetLaserOnTime", "GetEncVel"].contains(&function.name)
}

/// The format in which C prints a value.
pub fn format_of(of: Scalar) -> (&'static str, &'static str) {
    match of {
        Scalar::Short | Scalar::UShort => ("%d", "int"),
        Scalar::Long => ("%ld", "long"),
        Scalar::ULong => ("%lu", "unsigned long"),
        Scalar::Double => ("%.17g", "double"),
    }
}
