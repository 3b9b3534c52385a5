//! The generated files: `include/gts.h`, `include/gts_cards.h` and `src/exports.rs`, as texts.
//!
//! `cargo test -p beamtick-gts --test generated` compares them with what is checked in;
//! `cargo xtask c-api` writes them.

use crate::about::about;
use crate::prototype::{Form, Prototype, all, members};
use job::api::{CONSTANTS, Type};
use std::fmt::Write;

/// Above each group of functions, by the first function of the group.
const GROUPS: &[(&str, &str)] = &[
    ("Open", "Session"),
    ("AxisOn", "Axes"),
    ("PrfTrap", "Trap and Jog"),
    ("GetDi", "Digital and analog inputs and outputs"),
    ("SetAxisMode", "Laser"),
    ("BufLaserOn", "Buffered laser commands"),
    ("SetLaserDisMode", "Laser power by distance"),
    ("SetCrdPrm", "Coordinate systems"),
    ("PrfPt", "PT"),
    ("PrfPvt", "PVT"),
    ("PrfFollow", "Follow"),
    ("PrfFollowEx", "FollowEx"),
    ("GetDiRaw", "Beyond the manuals: what is kept changes nothing, what is refused returns 1 (docs/api.md)"),
];

/// Structs of the API.
pub const STRUCTS: [Type; 7] =
    [Type::Trap, Type::Jog, Type::Crd, Type::CrdData, Type::Pid, Type::HomePrm, Type::HomeStatus];

/// One declaration; `default` says whether defaults are shown.
pub fn declaration(prototype: &Prototype, symbol: &str) -> String {
    let parameters: Vec<String> = prototype
        .parameters()
        .iter()
        .map(|argument| match argument.default {
            Some(_) if argument.is_address() => format!("{} GT_DEFAULT(NULL)", argument.c()),
            Some(_) if prototype.function.reports_given == Some(argument.name) => {
                format!("{} GT_DEFAULT(GT_NOT_GIVEN)", argument.c())
            }
            Some(default) => format!("{} GT_DEFAULT({default})", argument.c()),
            None => argument.c(),
        })
        .collect();
    let list = if parameters.is_empty() { "void".to_owned() } else { parameters.join(", ") };
    format!("GT_API {symbol}({list});")
}

/// What both headers begin with.
fn preamble(guard: &str, other: &str, text: &str) -> String {
    let mut out = format!(
        "/* {text}\n * Generated from the table of functions by `cargo xtask c-api`: change that, not this.\n \
         * docs/c.md says what the library does; return values are those of the manuals. */\n\
         #ifndef {guard}\n#define {guard}\n\n\
         #ifdef {other}\n#error \"gts.h and gts_cards.h declare the same names: include one of them\"\n#endif\n\n\
         #include <stddef.h>\n\n\
         #ifdef __cplusplus\n#define GT_DEFAULT(value) = value\n#define GT_EXTERN extern \"C\"\n#else\n\
         #define GT_DEFAULT(value)\n#define GT_EXTERN extern\n#endif\n\n\
         #ifdef _WIN32\n#define GT_API GT_EXTERN short __stdcall\n#else\n#define GT_API GT_EXTERN short\n#endif\n\n\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n"
    );
    for of in STRUCTS {
        let _ = writeln!(out, "typedef struct {} {{", of.name());
        for (name, field, count) in members(of) {
            let many = if count == 1 { String::new() } else { format!("[{count}]") };
            let _ = writeln!(out, "    {} {name}{many};", field.name());
        }
        let _ = writeln!(out, "}} {};\n", of.name());
    }
    out += "#ifdef __cplusplus\n}\n#endif\n\n";
    out += "/* A power or a bound that is left out, where that differs from 0. */\n#define GT_NOT_GIVEN (-1.7976931348623157e308)\n\n";
    for (name, value) in CONSTANTS {
        let _ = if *value < 0 {
            writeln!(out, "#define {name} ({value})")
        } else {
            writeln!(out, "#define {name} {value}")
        };
    }
    out
}

/// The short form of SetLaserDisRatio (LSR: no bounds), which C++ distinguishes.
fn overload(prototype: &Prototype, symbol: &str) -> Option<String> {
    let lead = prototype.parameters().first().filter(|_| prototype.leads).map(|argument| argument.name);
    (prototype.function.name == "SetLaserDisRatio").then(|| {
        let (declared, given) =
            lead.map_or((String::new(), String::new()), |lead| (format!("short {lead}, "), format!("{lead}, ")));
        format!(
            "#ifdef __cplusplus\nstatic inline short {symbol}({declared}double *ratio, short channel = 0)\n{{\n    \
             return {symbol}({given}ratio, GT_NOT_GIVEN, GT_NOT_GIVEN, channel);\n}}\n#endif"
        )
    })
}

fn declarations(form: Form, prefix: &str) -> String {
    let mut out = String::new();
    for prototype in all(form) {
        let name = prototype.function.name;
        if let Some((_, group)) = GROUPS.iter().find(|(first, _)| *first == name) {
            let _ = writeln!(out, "\n/* {group} */");
        }
        let symbol = format!("{prefix}{name}");
        let _ = writeln!(out, "/* {} */\n{}", about(name), declaration(&prototype, &symbol));
        if let Some(text) = overload(&prototype, &symbol) {
            let _ = writeln!(out, "{text}");
        }
    }
    out
}

/// The text of `gts.h`.
pub fn gts() -> String {
    let mut out = preamble(
        "BEAMTICK_GTS_H",
        "BEAMTICK_GTS_CARDS_H",
        "gts.h: one card, as GT_x(...) for its first core and GTN_x(core, ...).",
    );
    out += "\n/* ---- GT_: the first core of the card ------------------------------------------------------ */\n";
    out += &declarations(Form::Gt, Form::Gt.prefix());
    out += "\n/* ---- GTN_: the core comes first ----------------------------------------------------------- */\n";
    out += &declarations(Form::Gtn, Form::Gtn.prefix());
    out += "\n#endif\n";
    out
}

/// The text of `gts32.h`: `gts.h` with a `long` of 32 bits.
pub fn gts32() -> String {
    gts()
        .replace("BEAMTICK_GTS_H", "BEAMTICK_GTS32_H")
        .replace("gts.h: one card", "gts32.h, for libgts32, whose long has 32 bits everywhere: one card")
        .lines()
        .map(|line| {
            let code = line.starts_with("GT_API") || (line.starts_with("    ") && line.ends_with(';'));
            format!("{}\n", if code { line.replace("long ", "int ") } else { line.to_owned() })
        })
        .collect()
}

/// The text of `gts_cards.h`.
pub fn cards() -> String {
    let mut out = preamble(
        "BEAMTICK_GTS_CARDS_H",
        "BEAMTICK_GTS_H",
        "gts_cards.h: several cards, as GT_x(cardNum, ...) for the first core of each.",
    );
    out += "\n/* The functions have symbols of their own, so that one library serves both headers. */\n";
    for prototype in all(Form::Cards) {
        let name = prototype.function.name;
        let _ = writeln!(out, "#define GT_{name} {}", prototype.symbol());
    }
    out += &declarations(Form::Cards, Form::Gt.prefix());
    out += "\n#endif\n";
    out
}

/// The text of `src/exports.rs`.
pub fn exports() -> String {
    let mut out = String::from(
        "//! The exported functions, three for each row of the table. Generated by `cargo xtask c-api`:\n\
         //! change the table (`job::api`), not this.\n\n\
         use crate::boundary::{cards, gt, gtn, open_gtn};\n\
         use crate::width::{c_long, c_ulong};\n\
         use std::ffi::{c_char, c_double, c_short, c_ushort, c_void};\n\n",
    );
    for form in Form::ALL {
        for prototype in all(form) {
            let call = match (form, prototype.leads) {
                (Form::Gt, _) => "gt",
                (Form::Gtn, true) => "gtn",
                (Form::Gtn, false) => "open_gtn",
                (Form::Cards, _) => "cards",
            };
            let parameters: Vec<String> = prototype
                .arguments
                .iter()
                .map(|argument| format!("{}: {}", rust_name(argument.name), argument.rust()))
                .collect();
            let _ = writeln!(
                out,
                "{call}!({} {:?} ({}));",
                prototype.symbol(),
                prototype.function.name,
                parameters.join(", ")
            );
        }
        out.push('\n');
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    out
}

fn rust_name(name: &str) -> String {
    match name {
        "type" | "loop" => format!("r#{name}"),
        name => name.to_owned(),
    }
}

/// Whether a C++ compiler accepts the defaults: none comes before a parameter without one.
pub fn defaults_close(prototype: &Prototype) -> bool {
    let first = prototype.arguments.iter().position(|argument| argument.default.is_some());
    first.is_none_or(|first| prototype.arguments.iter().skip(first).all(|argument| argument.default.is_some()))
}
