//! Expressions of constants: C's operators, casts, `math.h`. Computed as the script is read.
//!
//! Precedence climbing over the operators below; everything else that C has (`?:`, comparisons,
//! logic) needs a value at run time and is refused.

use crate::api;
use crate::diagnostic::quoted;
use crate::read::{Fault, Reader};
use crate::scan::Kind;
use crate::value::{Type, Value, pattern, show};

/// Binary operators and how strongly they bind.
const BINARY: &[(&str, u8)] =
    &[("|", 1), ("^", 2), ("&", 3), ("<<", 4), (">>", 4), ("+", 5), ("-", 5), ("*", 6), ("/", 6), ("%", 6)];

/// Functions of `math.h`.
pub(crate) const MATHEMATICS: &[&str] = &[
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "fabs", "abs", "labs", "exp", "log", "pow", "floor",
    "ceil", "fmod",
];

/// Operators of C that scripts do not have.
const REFUSED: &[&str] = &["?", "==", "!=", "<", ">", "<=", ">=", "&&", "||", "->"];

impl Reader<'_> {
    /// Reads an expression and gives its value.
    pub(crate) fn expression(&mut self) -> Result<Value, Fault> {
        self.binary(0)
    }

    fn binary(&mut self, least: u8) -> Result<Value, Fault> {
        let start = self.here();
        let mut left = self.unary()?;
        loop {
            let operator = self.peek().clone();
            if operator.kind == Kind::Mark && REFUSED.contains(&operator.text.as_str()) {
                return Err(self.fault_here(
                    format!("`{}` is not available in a job script's expressions", operator.text),
                    "scripts compute + - * / % << >> | & ^ ~ ( ) once, before they run; for more, use the C library",
                ));
            }
            let Some(&(text, strength)) = BINARY
                .iter()
                .find(|(text, strength)| operator.kind == Kind::Mark && *text == operator.text && *strength > least)
            else {
                return Ok(left);
            };
            self.advance();
            let right = self.binary(strength)?;
            let span = start.start..self.before().end;
            left = compute(text, &left, &right).map_err(|message| Fault::new(span, message, ""))?;
        }
    }

    fn unary(&mut self) -> Result<Value, Fault> {
        self.nested(|reader| {
            let token = reader.peek().clone();
            match (token.kind, token.text.as_str()) {
                (Kind::Mark, sign @ ("-" | "+" | "~" | "!")) => {
                    reader.advance();
                    let value = reader.unary()?;
                    let span = token.span.start..reader.before().end;
                    sign_of(sign, &value).map_err(|message| Fault::new(span, message, ""))
                }
                (Kind::Mark, "(") => {
                    reader.advance();
                    if let Some(of) = reader.type_words() {
                        reader.expect(")", "after the type of a cast")?;
                        let value = reader.unary()?;
                        let span = token.span.start..reader.before().end;
                        return of.convert(&value).map_err(|message| Fault::new(span, message, ""));
                    }
                    let value = reader.binary(0)?;
                    reader.expect(")", "to close the parenthesis")?;
                    Ok(value)
                }
                (Kind::Number, text) => {
                    reader.advance();
                    number(text).map_err(|message| Fault::new(token.span.clone(), message, ""))
                }
                (Kind::Name, _) => reader.name(),
                _ => {
                    Err(reader
                        .fault_here(format!("a number, a name or ( is expected here, not {}", reader.shown()), ""))
                }
            }
        })
    }

    fn name(&mut self) -> Result<Value, Fault> {
        let token = self.peek().clone();
        let name = token.text.clone();
        if self.peek_after(1).text == "(" && self.peek_after(1).kind == Kind::Mark {
            return self.mathematics();
        }
        if self.variables.contains_key(&name) {
            let (variable, cell, _) = self.place_of_value()?;
            let span = token.span.start..self.before().end;
            let value = self.variables[&variable].cells[cell].clone();
            return self.known(value, &variable, span);
        }
        self.advance();
        if let Some((_, value)) = api::CONSTANTS.iter().find(|(known, _)| *known == name) {
            return Ok(Value::Int(*value));
        }
        match name.as_str() {
            "M_PI" => Ok(Value::Real(std::f64::consts::PI)),
            "M_E" => Ok(Value::Real(std::f64::consts::E)),
            "NAN" => Ok(Value::Real(f64::NAN)),
            "INFINITY" => Ok(Value::Real(f64::INFINITY)),
            "NULL" => Ok(Value::Int(0)),
            _ => {
                let near = misspelt(
                    &name,
                    self.variables.keys().map(String::as_str).chain(api::CONSTANTS.iter().map(|(known, _)| *known)),
                );
                let help = match near[..] {
                    [] => format!("declare it first, as in `double {name} = 0;` or `#define {name} 1`"),
                    _ => format!("did you mean {}?", near.join(" or ")),
                };
                Err(Fault::new(token.span, format!("`{name}` is not declared"), &help))
            }
        }
    }

    fn known(&self, value: Value, name: &str, span: std::ops::Range<usize>) -> Result<Value, Fault> {
        match value {
            Value::Later { call, line } => Err(Fault::new(
                span,
                format!("`{name}` is filled by {call} in line {line} when the job runs; its value is not known before"),
                "a job script is computed before it runs; to decide by what the controller says, use the C library",
            )),
            Value::Unset => Err(Fault::new(span, format!("`{name}` has no value yet"), "assign one first")),
            value => Ok(value),
        }
    }

    fn mathematics(&mut self) -> Result<Value, Fault> {
        let token = self.advance();
        self.advance();
        let mut given = Vec::new();
        while self.peek().text != ")" {
            let value = self.expression()?;
            given.push(value);
            if !self.accept(",") {
                break;
            }
        }
        self.expect(")", "to close the call")?;
        let span = token.span.start..self.before().end;
        if let ("abs" | "labs", [Value::Int(number)]) = (token.text.as_str(), &given[..]) {
            return Ok(Value::Int(number.saturating_abs()));
        }
        let reals: Vec<f64> = given.iter().filter_map(real).collect();
        let result = match (token.text.as_str(), &reals[..]) {
            ("sin", [x]) => x.sin(),
            ("cos", [x]) => x.cos(),
            ("tan", [x]) => x.tan(),
            ("asin", [x]) => x.asin(),
            ("acos", [x]) => x.acos(),
            ("atan", [x]) => x.atan(),
            ("atan2", [y, x]) => y.atan2(*x),
            ("sqrt", [x]) => x.sqrt(),
            ("fabs" | "abs", [x]) => x.abs(),
            ("exp", [x]) => x.exp(),
            ("log", [x]) => x.ln(),
            ("pow", [x, y]) => x.powf(*y),
            ("floor", [x]) => x.floor(),
            ("ceil", [x]) => x.ceil(),
            ("fmod", [x, y]) => x % y,
            (name, _) => {
                let message = if name.starts_with("GT_") || name.starts_with("GTN_") {
                    format!("{name} is not allowed inside an expression")
                } else {
                    format!("`{name}` with {} values is no function that scripts know", given.len())
                };
                let help = "expressions know sin cos tan asin acos atan atan2 sqrt fabs abs exp log pow floor ceil fmod; \
                            calls stand alone or as `rtn = GT_X(...);`";
                return Err(Fault::new(span, message, help));
            }
        };
        Ok(Value::Real(result))
    }
}

/// Up to three of `known` that look most like `name`.
pub fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Vec<&'n str> {
    let mut close: Vec<(f64, &str)> = known
        .map(|other| (strsim::jaro_winkler(&name.to_lowercase(), &other.to_lowercase()), other))
        .filter(|(likeness, _)| *likeness > 0.85)
        .collect();
    close.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    close.into_iter().map(|(_, other)| other).take(3).collect()
}

/// The names of values that `name` may be meant for. One that only begins alike is another thing:
/// `axis` is no AXIS_LASER. So at most a third of the letters differ.
pub(crate) fn misspelt<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Vec<&'n str> {
    let is_near = |other: &&str| {
        let longest = name.chars().count().max(other.chars().count());
        3 * strsim::damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase()) <= longest
    };
    nearest(name, known.filter(is_near))
}

fn real(value: &Value) -> Option<f64> {
    match *value {
        Value::Int(number) => Some(number as f64),
        Value::Real(number) => Some(number),
        _ => None,
    }
}

fn number(text: &str) -> Result<Value, String> {
    let wrong = || format!("{} is not a number that scripts know", quoted(text));
    let lower = text.to_lowercase();
    if let Some(digits) = lower.strip_prefix("0x") {
        let digits = digits.trim_end_matches(['u', 'l']);
        return i64::from_str_radix(digits, 16).map(|bits| Value::Int(pattern(bits))).map_err(|_| wrong());
    }
    let digits = lower.trim_end_matches(['u', 'l']);
    if digits.bytes().all(|digit| digit.is_ascii_digit()) {
        // C reads a number with a leading 0 as octal.
        let (digits, base) = if digits.len() > 1 && digits.starts_with('0') { (&digits[1..], 8) } else { (digits, 10) };
        return i64::from_str_radix(digits, base).map(Value::Int).map_err(|_| wrong());
    }
    let digits = lower.trim_end_matches(['f', 'l']);
    digits.parse().map(Value::Real).map_err(|_| wrong())
}

fn sign_of(sign: &str, value: &Value) -> Result<Value, String> {
    Ok(match (sign, value) {
        ("-", Value::Int(number)) => Value::Int(number.checked_neg().ok_or("this number is too large")?),
        ("-", Value::Real(number)) => Value::Real(-number),
        ("~", Value::Int(number)) => Value::Int(pattern(!number)),
        ("!", Value::Int(number)) => Value::Int(i64::from(*number == 0)),
        ("+", value) => value.clone(),
        (sign, value) => return Err(format!("`{sign}` needs an integer, not {}", show(value))),
    })
}

/// `left operator right` as C computes it.
pub(crate) fn compute(operator: &str, left: &Value, right: &Value) -> Result<Value, String> {
    if let (Value::Int(a), Value::Int(b)) = (left, right) {
        return integers(operator, *a, *b).map(Value::Int);
    }
    let (Some(a), Some(b)) = (real(left), real(right)) else {
        return Err("this value is not known before the job runs".into());
    };
    Ok(Value::Real(match operator {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" => a / b,
        other => return Err(format!("`{other}` needs integers, not {} and {}", show(left), show(right))),
    }))
}

fn integers(operator: &str, a: i64, b: i64) -> Result<i64, String> {
    let shift = || u32::try_from(b).ok().filter(|by| *by < 32).ok_or(format!("a shift by {b} is outside 0 to 31"));
    let result = match operator {
        "+" => a.checked_add(b),
        "-" => a.checked_sub(b),
        "*" => a.checked_mul(b),
        "/" | "%" if b == 0 => return Err("division by zero".into()),
        "/" => a.checked_div(b),
        "%" => a.checked_rem(b),
        "<<" => a.checked_mul(1 << shift()?).map(pattern),
        ">>" => Some(a >> shift()?),
        "|" => Some(pattern(a | b)),
        "&" => Some(pattern(a & b)),
        _ => Some(pattern(a ^ b)),
    };
    result.ok_or_else(|| format!("{a} {operator} {b} is too large for an integer"))
}

impl Reader<'_> {
    /// Reads the words of a type, if they come next.
    pub(crate) fn type_words(&mut self) -> Option<Type> {
        let start = self.at();
        let (mut unsigned, mut of, mut any) = (false, None, false);
        while self.peek().kind == Kind::Name {
            match self.peek().text.as_str() {
                "const" | "static" | "volatile" | "signed" | "struct" | "register" => {}
                "unsigned" => (unsigned, any) = (true, true),
                word => match (Type::of(word), of) {
                    (Some(found), None) => (of, any) = (Some(found), true),
                    // `long int`, `short int`, `long double`.
                    (Some(Type::Long), Some(_)) => {}
                    (Some(Type::Double), Some(Type::Long)) => of = Some(Type::Double),
                    _ => break,
                },
            }
            self.advance();
        }
        if !any {
            self.rewind(start);
            return None;
        }
        Some(match (unsigned, of) {
            (true, Some(Type::Short)) => Type::UShort,
            (true, Some(Type::Long) | None) => Type::ULong,
            (_, of) => of.unwrap_or(Type::ULong),
        })
    }
}
