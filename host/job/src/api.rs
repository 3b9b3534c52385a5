//! The table of the manuals' names: functions, parameters with defaults, constants, and the request
//! that each function becomes. Only here a script's names are mapped to the protocol's.
//!
//! Source: API.md (prototypes, constants). Parameters have the order of the request's fields; where
//! the two differ, [`Shape`] says how. A function whose request has no layout is listed by its name
//! alone, so that a script that calls it gets a clear error.

mod functions;
mod names;

pub use crate::value::Type;
pub use functions::FUNCTIONS;
pub use names::{CONSTANTS, MISREAD, SKIPPED};
use protocol::command::class;

/// What a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// A value.
    In(Type),
    /// The address of a variable, or of the first of `count`, that the reply fills.
    Out,
    /// The first of as many values as the size says, which become items.
    Many(Type, Size),
    /// The first of so many values, which go into the request one by one. With a default it may be
    /// NULL: zeros.
    Fixed(Type, usize),
    /// The address of a struct whose values the request takes.
    Struct(Type),
    /// The same, or NULL.
    StructOrNull(Type),
    /// The address of a struct that the reply fills.
    OutStruct(Type),
    /// An array that the manuals' library works in; nothing travels.
    Working,
    /// A text.
    Text,
}

/// How many values an array has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// `count`.
    Count,
    /// `count` for each of so many axes.
    Each(usize),
    /// The first value of the array `count`.
    Columns,
    /// Its second.
    Rows,
    /// Their product.
    Grid,
}

/// One parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Param {
    /// Name, as the manuals have it without its Hungarian letter.
    pub name: &'static str,
    /// What it is.
    pub pass: Pass,
    /// Its value where a script leaves it out. An `Out` with a default is NULL then.
    pub default: Option<i32>,
}

/// How parameters become a request. Fields of a request that no parameter fills: `core`, `form` (0
/// `GTN_`, 1 `GT_`), `first` (0) and `…_given` (see [`Function::reports_given`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The request's other fields are the parameters that go in, in order; a `count` that no
    /// parameter fills is 1.
    Plain,
    /// As `Plain` without the arrays; the items, a value of each array in turn, follow the request.
    Points,
    /// As `Plain` without the struct, of which an item follows the request unless it is NULL.
    Point,
    /// As `Points`, but the arrays follow one after the other, the first one last.
    Grid,
    /// The configuration file's items.
    Config,
    /// Done by the host (opening, closing, the last reason): nothing is sent.
    Host,
    /// Two arrays of axes and options become the masks of `PtStart`.
    StartList,
}

/// A function that scripts may call.
#[derive(Debug, Clone, Copy)]
pub struct Function {
    /// Name without `GT_` or `GTN_`.
    pub name: &'static str,
    /// Number of its request; 0 for `Shape::Host`.
    pub opcode: u16,
    /// Parameters without `core`.
    pub params: &'static [Param],
    /// How they travel.
    pub shape: Shape,
    /// The parameter for which the request says whether it was given.
    pub reports_given: Option<&'static str>,
}

impl Function {
    /// Whether a parameter fills this field of the request.
    pub fn has(&self, field: &str) -> bool {
        self.params.iter().any(|param| param.name == field)
    }

    /// It changes nothing: allowed in `while(!kbhit())`.
    pub fn reads(&self) -> bool {
        self.shape == Shape::Host || class(self.opcode).is_some_and(|class| class.kind.reads())
    }

    /// It reports why motion has stopped: a number, and the host's text of it.
    pub fn reports_stop(&self) -> bool {
        matches!(self.name, "GetStopReason" | "GetCrdStopReason")
    }
}

/// How many values the arrays of a function hold, at least and at most; of a plane, in each
/// direction. A controller may have room for fewer.
pub fn counts(name: &str) -> Option<(i64, i64)> {
    match name {
        "SetDac" | "PtStartPro" => Some((1, 32)),
        "SetDoEx" => Some((1, 4)),
        "SetDiReverseCount" => Some((1, 8)),
        "SetLaserFollowTable" | "SetLaserDisTable1D" | "SetLaserDisTable2D" => Some((1, 32)),
        name if name.starts_with("Pvt") => Some((2, 1024)),
        _ => None,
    }
}

/// The function named `name` without its prefix.
pub fn function(name: &str) -> Option<&'static Function> {
    FUNCTIONS.iter().find(|function| function.name == name)
}
