//! The C prototypes, derived from the one table of functions (`job::api`) and the layouts of
//! requests and replies (`protocol::command`): header, exports and the handling of arguments all
//! come from here.
//!
//! [`FORMS`] has what the two tables lack: the forms to which API.md gives a type of their own.

use crate::more::{self, MORE};
use job::api::{FUNCTIONS, Function, Param, Pass, Shape, Size, Type};

use protocol::command::{COMMANDS, CommandInfo};

/// The three call families.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `GT_x(…)`: the one card, core 1.
    Gt,
    /// `GTN_x(core, …)`: the one card.
    Gtn,
    /// `GT_x(cardNum, …)` of the header for several cards; core 1.
    Cards,
}

impl Form {
    /// All of them.
    pub const ALL: [Form; 3] = [Form::Gt, Form::Gtn, Form::Cards];

    /// What the symbol of a function begins with.
    pub const fn prefix(self) -> &'static str {
        match self {
            Form::Gt => "GT_",
            Form::Gtn => "GTN_",
            Form::Cards => "GTM_",
        }
    }
}

/// The numbers of the C API.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// 16 bits.
    Short,
    /// 16 bits without a sign.
    UShort,
    /// The platform's `long`.
    Long,
    /// The platform's `unsigned long`.
    ULong,
    /// 64-bit real.
    Double,
}

impl Scalar {
    /// As C writes it.
    pub const fn name(self) -> &'static str {
        match self {
            Scalar::Short => "short",
            Scalar::UShort => "unsigned short",
            Scalar::Long => "long",
            Scalar::ULong => "unsigned long",
            Scalar::Double => "double",
        }
    }

    /// As Rust writes it.
    pub const fn rust(self) -> &'static str {
        match self {
            Scalar::Short => "c_short",
            Scalar::UShort => "c_ushort",
            Scalar::Long => "c_long",
            Scalar::ULong => "c_ulong",
            Scalar::Double => "c_double",
        }
    }

    fn of(of: Type) -> Scalar {
        match of {
            Type::UShort => Scalar::UShort,
            Type::Long => Scalar::Long,
            Type::ULong => Scalar::ULong,
            Type::Double => Scalar::Double,
            _ => Scalar::Short,
        }
    }

    /// What holds a value of this wire type.
    fn of_wire(of: &str) -> Scalar {
        match of {
            "F64" => Scalar::Double,
            "I32" => Scalar::Long,
            "U32" => Scalar::ULong,
            "U16" => Scalar::UShort,
            _ => Scalar::Short,
        }
    }
}

/// What a parameter is to C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A value.
    Value(Scalar),
    /// An array that is read, and how long it is.
    Array(Scalar, Size),
    /// An array of fixed length that is read.
    Fixed(Scalar, usize),
    /// The address of what the reply fills.
    Out(Scalar),
    /// A struct that is read.
    Struct(Type),
    /// A struct that the reply fills.
    OutStruct(Type),
    /// An array of doubles that the manuals' library works in.
    Working,
    /// A text that is read.
    Text,
    /// Room for a text.
    Room,
    /// The parameter for the address of a text.
    TextAddress,
}

/// One parameter of a prototype.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Argument {
    /// Its name in the header.
    pub name: &'static str,
    /// What it is.
    pub kind: Kind,
    /// Its default in C++; of an address, NULL.
    pub default: Option<i32>,
    /// An address that may be NULL.
    pub optional: bool,
}

/// Whether an address may be NULL.
fn optional(param: &Param) -> bool {
    param.default.is_some() || matches!(param.pass, Pass::StructOrNull(_) | Pass::Working)
}

impl Argument {
    const fn short(name: &'static str) -> Self {
        Argument { name, kind: Kind::Value(Scalar::Short), default: None, optional: false }
    }

    /// As C declares it.
    pub fn c(&self) -> String {
        let name = self.name;
        match self.kind {
            Kind::Value(of) => format!("{} {name}", of.name()),
            Kind::Array(of, _) | Kind::Fixed(of, _) | Kind::Out(of) => format!("{} *{name}", of.name()),
            Kind::Struct(of) | Kind::OutStruct(of) => format!("{} *{name}", of.name()),
            Kind::Working if name == "lookAheadBuf" => format!("{} *{name}", Type::CrdData.name()),
            Kind::Working => format!("double *{name}"),
            Kind::Text => format!("const char *{name}"),
            Kind::Room => format!("char *{name}"),
            Kind::TextAddress => format!("char **{name}"),
        }
    }

    /// Its type as Rust writes it.
    pub fn rust(&self) -> String {
        match self.kind {
            Kind::Value(of) => of.rust().to_owned(),
            Kind::Array(of, _) | Kind::Fixed(of, _) | Kind::Out(of) => format!("*mut {}", of.rust()),
            Kind::Struct(_) | Kind::OutStruct(_) => "*mut c_void".to_owned(),
            Kind::Working => "*mut c_void".to_owned(),
            Kind::Text => "*const c_char".to_owned(),
            Kind::Room => "*mut c_char".to_owned(),
            Kind::TextAddress => "*mut *const c_char".to_owned(),
        }
    }

    /// Whether it is an address.
    pub const fn is_address(&self) -> bool {
        !matches!(self.kind, Kind::Value(_))
    }
}

/// The members of a struct as C has them: name, type, number of elements. TCrdData has what the
/// manuals' library keeps there for itself, too.
pub fn members(of: Type) -> Vec<(&'static str, Scalar, usize)> {
    if of == Type::CrdData {
        return vec![
            ("motionType", Scalar::Short, 1),
            ("circlePlat", Scalar::Short, 1),
            ("pos", Scalar::Long, 8),
            ("radius", Scalar::Double, 1),
            ("circleDir", Scalar::Short, 1),
            ("center", Scalar::Double, 3),
            ("vel", Scalar::Double, 1),
            ("acc", Scalar::Double, 1),
            ("velEndZero", Scalar::Short, 1),
            ("operation", Scalar::Short, 7),
            ("cos", Scalar::Double, 8),
            ("velEnd", Scalar::Double, 1),
            ("velEndAdjust", Scalar::Double, 1),
            ("r", Scalar::Double, 1),
        ];
    }
    of.fields().iter().map(|(name, field, count)| (*name, Scalar::of(*field), *count)).collect()
}

/// A function of one family.
#[derive(Debug, Clone)]
pub struct Prototype {
    /// The row of the table.
    pub function: &'static Function,
    /// The family.
    pub form: Form,
    /// Whether `core` or `cardNum` comes first.
    pub leads: bool,
    /// The parameters after it.
    pub arguments: Vec<Argument>,
}

/// Where a form has a parameter of its own type: function, parameter, its type in `GT_`, and in
/// `GTN_`.
const FORMS: &[(&str, &str, Scalar, Scalar)] = &[
    ("SetPulseWidth", "width", Scalar::ULong, Scalar::UShort),
    ("SetLevelDelay", "offDelay", Scalar::UShort, Scalar::ULong),
    ("SetLevelDelay", "onDelay", Scalar::UShort, Scalar::ULong),
    ("EnaFPK", "time1", Scalar::UShort, Scalar::UShort),
    ("EnaFPK", "time2", Scalar::UShort, Scalar::UShort),
    ("EnaFPK", "laserOffDelay", Scalar::UShort, Scalar::UShort),
    ("GetHSIOOpt", "value", Scalar::UShort, Scalar::UShort),
    ("GetStopReason", "reason", Scalar::Short, Scalar::Short),
    ("GetCrdStopReason", "reason", Scalar::Short, Scalar::Short),
];

/// Parameters that only scripts may leave out; in C++ an overload has none of them.
const NO_DEFAULT: &[(&str, &str)] = &[("SetLaserDisRatio", "minPower"), ("SetLaserDisRatio", "maxPower")];

/// Parameters that the `GTN_` form has not.
const NOT_IN_GTN: &[(&str, &str)] = &[("LaserPowerMode", "delaymode")];

/// `GTN_` functions that are for the whole controller and take no core.
const WITHOUT_CORE: &[&str] = &["Open", "Close"];

/// The row of the command table that belongs to a function.
pub fn command(function: &Function) -> Option<&'static CommandInfo> {
    COMMANDS.iter().find(|command| command.opcode == function.opcode && function.shape != Shape::Host)
}

/// The fields that the `Out` parameters take their values from: of the reply's items, if it has
/// some.
pub fn reply_fields(function: &Function) -> &'static [(&'static str, &'static str)] {
    let Some(command) = command(function) else { return &[] };
    if command.reply_items.is_empty() { command.reply } else { command.reply_items }
}

/// Lower case without underscores, and without the unit at the end.
fn plain(name: &str) -> String {
    let name = ["_ms", "_us", "_cycles"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name);
    name.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase()
}

/// The index in [`reply_fields`] of each `Out` parameter, in their order; `clock` of a reply with
/// items has none.
///
/// A parameter takes the field of its name, else the first that no parameter has.
pub fn outs(function: &Function) -> Vec<Option<usize>> {
    let fields = reply_fields(function);
    let params: Vec<&Param> = function.params.iter().filter(|param| param.pass == Pass::Out).collect();
    let named: Vec<Option<usize>> =
        params.iter().map(|param| fields.iter().position(|(field, _)| plain(field) == plain(param.name))).collect();
    let mut free = (0..fields.len()).filter(|place| !named.contains(&Some(*place)));
    params
        .iter()
        .zip(&named)
        .map(|(param, place)| place.or_else(|| if param.name == "clock" { None } else { free.next() }))
        .collect()
}

/// The prototype of a function in a family.
pub fn prototype(function: &'static Function, form: Form) -> Prototype {
    let mut places = outs(function).into_iter();
    let fields = reply_fields(function);
    let more = more::row(function.name);
    let mut own_outs = more.into_iter().flat_map(|more| more.outs.iter().copied());
    let mut arguments = Vec::new();
    for param in function.params {
        let kind = match param.pass {
            Pass::In(of) => Kind::Value(Scalar::of(of)),
            Pass::Many(of, size) => Kind::Array(Scalar::of(of), size),
            Pass::Fixed(of, length) => Kind::Fixed(Scalar::of(of), length),
            Pass::Struct(of) | Pass::StructOrNull(of) => Kind::Struct(of),
            Pass::OutStruct(of) => Kind::OutStruct(of),
            Pass::Working => Kind::Working,
            Pass::Text => Kind::Text,
            Pass::Out => {
                let field = places.next().flatten().and_then(|place| fields.get(place));
                match function.name {
                    "GetVersion" => Kind::TextAddress,
                    _ if param.name == "text" => Kind::Room,
                    _ if more.is_some() => Kind::Out(own_outs.next().unwrap_or(Scalar::ULong)),
                    _ => Kind::Out(field.map_or(Scalar::ULong, |(_, of)| Scalar::of_wire(of))),
                }
            }
        };
        let default = match param.pass {
            Pass::StructOrNull(_) => None,
            _ if NO_DEFAULT.contains(&(function.name, param.name)) => None,
            _ => param.default,
        };
        if form == Form::Gtn && NOT_IN_GTN.contains(&(function.name, param.name)) {
            continue;
        }
        let own = FORMS.iter().find(|(name, of, ..)| (*name, *of) == (function.name, param.name));
        let kind = match (own, kind) {
            (Some((_, _, gt, gtn)), Kind::Value(_)) => Kind::Value(if form == Form::Gtn { *gtn } else { *gt }),
            (Some((_, _, gt, gtn)), Kind::Out(_)) => Kind::Out(if form == Form::Gtn { *gtn } else { *gt }),
            (_, kind) => kind,
        };
        arguments.push(Argument { name: param.name, kind, default, optional: optional(param) });
    }
    let leads = match form {
        Form::Gt => false,
        Form::Gtn => !WITHOUT_CORE.contains(&function.name),
        Form::Cards => true,
    };
    Prototype { function, form, leads, arguments }
}

impl Prototype {
    /// The symbol.
    pub fn symbol(&self) -> String {
        format!("{}{}", self.form.prefix(), self.function.name)
    }

    /// All parameters, with `core` or `cardNum`.
    pub fn parameters(&self) -> Vec<Argument> {
        let first = match (self.leads, self.form) {
            (false, _) => None,
            (true, Form::Gtn) => Some(Argument::short("core")),
            (true, _) => Some(Argument::short("cardNum")),
        };
        first.into_iter().chain(self.arguments.iter().copied()).collect()
    }
}

/// Every function: of the controller's table, then those beyond it.
pub fn functions() -> impl Iterator<Item = &'static Function> {
    FUNCTIONS.iter().chain(MORE.iter().map(|more| &more.function))
}

/// Every prototype of a family, in the order of the tables.
pub fn all(form: Form) -> impl Iterator<Item = Prototype> {
    functions().map(move |function| prototype(function, form))
}
