//! Numbers, variables and structs as C has them: `short` and `long` truncate, `double` does not.
//!
//! Integers are computed in 64 bits; bit patterns (hexadecimal literals, shifts, `| & ^ ~`) that
//! have their 32nd bit set become negative, as they do in a `long` of 32 bits, so that masks may
//! use all 32.

use std::collections::HashMap;

/// A value while a script is compiled.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// An integer.
    Int(i64),
    /// A real number.
    Real(f64),
    /// Filled by a call when the job runs; `call` and `line` say by which.
    Later {
        /// The function.
        call: String,
        /// Its line.
        line: u32,
    },
    /// Declared, but nothing was put into it.
    Unset,
}

/// The types of variables and parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// 16 bits with a sign.
    Short,
    /// 16 bits without.
    UShort,
    /// 32 bits with a sign (`int` too).
    Long,
    /// 32 bits without.
    ULong,
    /// 64-bit real (`float` too).
    Double,
    /// Text.
    Char,
    /// TTrapPrm.
    Trap,
    /// TJogPrm.
    Jog,
    /// TCrdPrm.
    Crd,
    /// TCrdData.
    CrdData,
    /// TPid (in the C library alone, as the next two).
    Pid,
    /// THomePrm.
    HomePrm,
    /// THomeStatus.
    HomeStatus,
}

/// Fields of a struct: name, type, number of elements.
type Fields = &'static [(&'static str, Type, usize)];

impl Type {
    /// The type named `word`, if it is one that needs no other word.
    pub fn of(word: &str) -> Option<Type> {
        Some(match word {
            "short" => Type::Short,
            "long" | "int" => Type::Long,
            "double" | "float" => Type::Double,
            "char" => Type::Char,
            "TTrapPrm" => Type::Trap,
            "TJogPrm" => Type::Jog,
            "TCrdPrm" => Type::Crd,
            "TCrdData" => Type::CrdData,
            _ => return None,
        })
    }

    /// Fields of a struct, in order; a plain type has one without a name.
    pub fn fields(self) -> Fields {
        match self {
            Type::Trap => &[
                ("acc", Type::Double, 1),
                ("dec", Type::Double, 1),
                ("velStart", Type::Double, 1),
                ("smoothTime", Type::Short, 1),
            ],
            Type::Jog => &[("acc", Type::Double, 1), ("dec", Type::Double, 1), ("smooth", Type::Double, 1)],
            Type::Crd => &[
                ("dimension", Type::Short, 1),
                ("profile", Type::Short, 8),
                ("synVelMax", Type::Double, 1),
                ("synAccMax", Type::Double, 1),
                ("evenTime", Type::Short, 1),
                ("setOriginFlag", Type::Short, 1),
                ("originPos", Type::Long, 8),
            ],
            // Without what the manuals' library keeps there for itself.
            Type::CrdData => &[
                ("motionType", Type::Short, 1),
                ("circlePlat", Type::Short, 1),
                ("pos", Type::Long, 8),
                ("radius", Type::Double, 1),
                ("circleDir", Type::Short, 1),
                ("center", Type::Double, 3),
                ("vel", Type::Double, 1),
                ("acc", Type::Double, 1),
                ("velEnd", Type::Double, 1),
                ("velEndZero", Type::Short, 1),
            ],
            Type::Pid => &[
                ("kp", Type::Double, 1),
                ("ki", Type::Double, 1),
                ("kd", Type::Double, 1),
                ("kvff", Type::Double, 1),
                ("kaff", Type::Double, 1),
                ("integralLimit", Type::Long, 1),
                ("derivativeLimit", Type::Long, 1),
                ("limit", Type::Short, 1),
            ],
            Type::HomePrm => &[
                ("mode", Type::Short, 1),
                ("moveDir", Type::Short, 1),
                ("indexDir", Type::Short, 1),
                ("edge", Type::Short, 1),
                ("triggerIndex", Type::Short, 1),
                ("pad1", Type::Short, 3),
                ("velHigh", Type::Double, 1),
                ("velLow", Type::Double, 1),
                ("acc", Type::Double, 1),
                ("dec", Type::Double, 1),
                ("smoothTime", Type::Short, 1),
                ("pad2", Type::Short, 3),
                ("homeOffset", Type::Long, 1),
                ("searchHomeDistance", Type::Long, 1),
                ("searchIndexDistance", Type::Long, 1),
                ("escapeStep", Type::Long, 1),
                ("pad3", Type::Long, 2),
            ],
            Type::HomeStatus => &[
                ("run", Type::Short, 1),
                ("stage", Type::Short, 1),
                ("error", Type::Short, 1),
                ("pad1", Type::Short, 1),
                ("capturePos", Type::Long, 1),
                ("targetPos", Type::Long, 1),
            ],
            Type::Short => &[("", Type::Short, 1)],
            Type::UShort => &[("", Type::UShort, 1)],
            Type::Long => &[("", Type::Long, 1)],
            Type::ULong => &[("", Type::ULong, 1)],
            Type::Double => &[("", Type::Double, 1)],
            Type::Char => &[("", Type::Char, 1)],
        }
    }

    /// Name and type of each value of a struct, in order: an array has one for each element.
    pub fn cells(self) -> impl Iterator<Item = (&'static str, Type)> {
        self.fields().iter().flat_map(|field| std::iter::repeat_n((field.0, field.1), field.2))
    }

    /// The script's name of each value of a struct: a field, or an element of one.
    pub fn value_names(self) -> impl Iterator<Item = String> {
        self.fields().iter().flat_map(|&(name, _, count)| {
            (0..count).map(move |place| if count > 1 { format!("{name}[{place}]") } else { name.to_owned() })
        })
    }

    /// How C writes it.
    pub fn name(self) -> &'static str {
        match self {
            Type::Short => "short",
            Type::UShort => "unsigned short",
            Type::Long => "long",
            Type::ULong => "unsigned long",
            Type::Double => "double",
            Type::Char => "char",
            Type::Trap => "TTrapPrm",
            Type::Jog => "TJogPrm",
            Type::Crd => "TCrdPrm",
            Type::CrdData => "TCrdData",
            Type::Pid => "TPid",
            Type::HomePrm => "THomePrm",
            Type::HomeStatus => "THomeStatus",
        }
    }

    /// It has fields.
    pub fn is_struct(self) -> bool {
        matches!(self, Type::Trap | Type::Jog | Type::Crd | Type::CrdData)
    }

    /// Least and greatest integer, for integer types.
    pub fn range(self) -> Option<(i64, i64)> {
        match self {
            Type::Short => Some((i64::from(i16::MIN), i64::from(i16::MAX))),
            Type::UShort => Some((0, i64::from(u16::MAX))),
            Type::Long => Some((i64::from(i32::MIN), i64::from(i32::MAX))),
            Type::ULong => Some((0, i64::from(u32::MAX))),
            Type::Char => Some((i64::from(i8::MIN), i64::from(u8::MAX))),
            _ => None,
        }
    }

    /// `value` as this type holds it: what C's conversion does, or a text that says why it does not
    /// fit.
    pub fn convert(self, value: &Value) -> Result<Value, String> {
        let Some((low, high)) = self.range() else {
            return Ok(match *value {
                Value::Int(number) => Value::Real(number as f64),
                ref other => other.clone(),
            });
        };
        let whole = match *value {
            Value::Int(number) => number,
            Value::Real(number) if number.is_nan() => {
                return Err(format!("not a number does not fit a {}", self.name()));
            }
            // Truncation towards zero, as a cast does; what is beyond i64 saturates and is refused
            // below.
            Value::Real(number) => number as i64,
            ref other => return Ok(other.clone()),
        };
        // 0x80000000 and other patterns of 32 bits reach an unsigned as they were written.
        let whole =
            if self == Type::ULong && (i64::from(i32::MIN)..0).contains(&whole) { whole + (1 << 32) } else { whole };
        if (low..=high).contains(&whole) {
            Ok(Value::Int(whole))
        } else {
            Err(format!("{} does not fit a {}, which holds {low} to {high}", show(value), self.name()))
        }
    }
}

/// A value as a person reads it.
pub fn show(value: &Value) -> String {
    match value {
        Value::Int(number) => number.to_string(),
        Value::Real(number) => number.to_string(),
        Value::Later { call, line } => format!("what {call} of line {line} reads"),
        Value::Unset => "nothing".into(),
    }
}

/// A bit pattern: with the 32nd bit set it is negative, as in a `long` of 32 bits.
pub fn pattern(bits: i64) -> i64 {
    match u32::try_from(bits) {
        Ok(bits) => i64::from(bits.cast_signed()),
        Err(_) => bits,
    }
}

/// A variable: one element, an array, or a struct.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Type of each element.
    pub of: Type,
    /// Number of elements, if it is an array.
    pub length: Option<usize>,
    /// All values: element by element, in each field by field.
    pub cells: Vec<Value>,
    /// The text of a `char` array or pointer.
    pub text: Option<String>,
}

impl Variable {
    /// A variable nothing was put into.
    pub fn new(of: Type, length: Option<usize>) -> Self {
        let cells = vec![Value::Unset; length.unwrap_or(1).saturating_mul(Self::width(of))];
        Variable { of, length, cells, text: None }
    }

    /// Values in one element.
    pub fn width(of: Type) -> usize {
        of.fields().iter().map(|field| field.2).sum()
    }

    /// Index in `cells` and type of an element's field; the message says what is wrong.
    pub fn cell(&self, index: Option<i64>, field: Option<(&str, Option<i64>)>) -> Result<(usize, Type), String> {
        let element = match (self.length, index) {
            (None, None) => 0,
            (Some(length), Some(index)) => {
                usize::try_from(index).ok().filter(|index| *index < length).ok_or_else(|| {
                    format!("index {index} is outside the array, which has the elements 0 to {}", length as i64 - 1)
                })?
            }
            (Some(_), None) => return Err("this is an array; name one element, as in x[0]".into()),
            (None, Some(_)) => return Err("this is not an array".into()),
        };
        let mut at = element * Self::width(self.of);
        let (wanted, inner) = match field {
            Some((name, inner)) => (name, inner),
            None if self.of.is_struct() => return Err(format!("this is a {}; name one field", self.of.name())),
            None => ("", None),
        };
        for (name, of, count) in self.of.fields() {
            if *name == wanted {
                let inner = match (inner, *count) {
                    (None, 1) => 0,
                    (Some(inner), count) if count > 1 => {
                        usize::try_from(inner).ok().filter(|inner| *inner < count).ok_or_else(|| {
                            format!("index {inner} is outside {name}, which has the elements 0 to {}", count - 1)
                        })?
                    }
                    (None, _) => return Err(format!("{name} is an array; name one element")),
                    (Some(_), _) => return Err(format!("{name} is not an array")),
                };
                return Ok((at + inner, *of));
            }
            at += count;
        }
        let known: Vec<&str> = self.of.fields().iter().map(|field| field.0).filter(|name| !name.is_empty()).collect();
        Err(if known.is_empty() {
            format!("a {} has no fields", self.of.name())
        } else {
            format!("{} has no field {wanted}; it has {}", self.of.name(), known.join(", "))
        })
    }
}

/// Variables by name.
pub type Variables = HashMap<String, Variable>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_are_those_of_c() {
        assert_eq!(Type::Long.convert(&Value::Real(15.999)), Ok(Value::Int(15)));
        assert_eq!(Type::Long.convert(&Value::Real(-15.999)), Ok(Value::Int(-15)));
        assert_eq!(Type::Double.convert(&Value::Int(3)), Ok(Value::Real(3.0)));
        assert_eq!(Type::Short.convert(&Value::Int(-32768)), Ok(Value::Int(-32768)));
        assert!(Type::Short.convert(&Value::Int(32768)).is_err());
        assert!(Type::Long.convert(&Value::Real(f64::NAN)).is_err());
        assert!(Type::Long.convert(&Value::Real(3e9)).is_err());
        assert!(Type::Long.convert(&Value::Real(1e300)).is_err());
    }

    #[test]
    fn patterns_of_32_bits_are_negative_in_a_long() {
        assert_eq!(pattern(0x8000_0000), i64::from(i32::MIN));
        assert_eq!(pattern(0x7fff_ffff), 0x7fff_ffff);
        assert_eq!(pattern(0x1_0000_0000), 0x1_0000_0000);
        assert_eq!(Type::ULong.convert(&Value::Int(-1)), Ok(Value::Int(0xffff_ffff)));
    }

    #[test]
    fn cells_of_structs_and_arrays() {
        let crd = Variable::new(Type::Crd, None);
        assert_eq!(crd.cells.len(), 21);
        assert_eq!(crd.cell(None, Some(("profile", Some(7)))), Ok((8, Type::Short)));
        assert_eq!(crd.cell(None, Some(("synVelMax", None))), Ok((9, Type::Double)));
        assert!(crd.cell(None, Some(("profile", Some(8)))).is_err());
        assert!(crd.cell(None, Some(("velMax", None))).unwrap_err().contains("synVelMax"));
        let row = Variable::new(Type::Double, Some(8));
        assert_eq!(row.cell(Some(7), None), Ok((7, Type::Double)));
        assert!(row.cell(Some(8), None).is_err());
        assert!(row.cell(Some(-1), None).is_err());
        assert!(row.cell(None, None).is_err());
    }
}
