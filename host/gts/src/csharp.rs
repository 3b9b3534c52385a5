//! Declarations for C# (`host/gts32/gts.cs`) as a text: P/Invoke for every function of `gts.h`, on
//! `libgts32`, and the structs and constants.
//!
//! Names and forms are those of the declarations that C# programs for such controllers use: the
//! class `gts.mc`, `out` for what is filled, `ref` for what is read by its address. With
//! `BEAMTICK_CARDS` it has the family for several cards, as the C header has.

use crate::about::about;
use crate::header::STRUCTS;
use crate::prototype::{Argument, Form, Kind, Prototype, Scalar, all, members};
use job::api::{CONSTANTS, Type};
use std::fmt::Write;

fn name(of: Scalar) -> &'static str {
    match of {
        Scalar::Short => "short",
        Scalar::UShort => "ushort",
        Scalar::Long => "int",
        Scalar::ULong => "uint",
        Scalar::Double => "double",
    }
}

/// Words that C# keeps for itself.
fn spelled(name: &str) -> String {
    if matches!(name, "event" | "params" | "out" | "ref" | "in" | "base" | "lock") {
        format!("@{name}")
    } else {
        name.to_owned()
    }
}

/// The arguments that a default makes optional; of an address it is NULL, which only an array can
/// be.
fn argument(argument: &Argument, prototype: &Prototype) -> String {
    let given = spelled(argument.name);
    let default = |text: &str| match argument.default {
        Some(_) => format!(" = {text}"),
        None => String::new(),
    };
    match argument.kind {
        Kind::Value(of) if prototype.function.reports_given == Some(argument.name) => {
            format!("{} {given}{}", name(of), default("GT_NOT_GIVEN"))
        }
        Kind::Value(of) => {
            format!("{} {given}{}", name(of), default(&argument.default.unwrap_or(0).to_string()))
        }
        // An array may be NULL; a default of a struct or of one number may not.
        Kind::Array(of, _) | Kind::Fixed(of, _) => format!("{}[] {given}{}", name(of), default("null")),
        Kind::Out(of) if argument.optional || several(prototype) => {
            format!("[In, Out] {}[] {given}{}", name(of), default("null"))
        }
        Kind::Out(of) => format!("out {} {given}", name(of)),
        Kind::Struct(of) if argument.optional => format!("IntPtr {given} /* {}, or IntPtr.Zero */", of.name()),
        Kind::Struct(of) => format!("ref {} {given}", of.name()),
        Kind::OutStruct(of) => format!("out {} {given}", of.name()),
        Kind::Working => format!("IntPtr {given}{}", default("default(IntPtr)")),
        Kind::Text => format!("string {given}{}", default("null")),
        Kind::Room => format!("StringBuilder {given}{}", default("null")),
        Kind::TextAddress => format!("out IntPtr {given} /* Marshal.PtrToStringAnsi reads it */"),
    }
}

/// Whether it fills as many values as `count` says, or one for each coordinate or point.
fn several(prototype: &Prototype) -> bool {
    let function = prototype.function.name;
    prototype.arguments.iter().any(|argument| argument.name == "count") || function == "GetCrdPos"
}

/// The attribute of a function, and its name. Those for several cards have symbols of their own.
fn imported(prototype: &Prototype) -> (String, String) {
    let symbol = prototype.symbol();
    match prototype.form {
        Form::Cards => {
            (format!("[DllImport(Library, EntryPoint = \"{symbol}\")]"), format!("GT_{}", prototype.function.name))
        }
        Form::Gt | Form::Gtn => ("[DllImport(Library)]".to_owned(), symbol),
    }
}

fn declare(out: &mut String, prototype: &Prototype) {
    let (attribute, symbol) = imported(prototype);
    let list: Vec<String> = prototype.parameters().iter().map(|given| argument(given, prototype)).collect();
    let _ = writeln!(out, "        /// <summary>{}</summary>", about(prototype.function.name));
    let _ = writeln!(out, "        {attribute}");
    let _ = writeln!(out, "        public static extern short {symbol}({});", list.join(", "));
    // One value of many, as programs write it for one axis; and all that an address may leave out.
    let single = prototype.arguments.iter().any(|argument| argument.name == "count" && argument.default == Some(1));
    let one_of_many =
        |argument: &Argument| matches!(argument.kind, Kind::Out(_) | Kind::Array(..)) && argument.name != "clock";
    let moves = prototype.arguments.iter().any(one_of_many);
    let left_out = |argument: &Argument| matches!(argument.kind, Kind::Out(_)) && argument.optional;
    if single && moves || !several(prototype) && prototype.arguments.iter().any(left_out) {
        let list: Vec<String> = prototype
            .parameters()
            .iter()
            .map(|given| match given.kind {
                Kind::Out(of) => format!("out {} {}", name(of), spelled(given.name)),
                Kind::Array(of, _) if single => format!("ref {} {}", name(of), spelled(given.name)),
                Kind::Value(of) => format!("{} {}", name(of), spelled(given.name)),
                _ => argument(given, prototype),
            })
            .collect();
        let count = if single { " For a count of 1." } else { "" };
        let _ = writeln!(out, "        /// <summary>{}{count}</summary>", about(prototype.function.name));
        let _ = writeln!(out, "        {attribute}");
        let _ = writeln!(out, "        public static extern short {symbol}({});", list.join(", "));
    }
}

fn structs(out: &mut String) {
    for of in STRUCTS {
        let _ = writeln!(out, "        [StructLayout(LayoutKind.Sequential)]");
        let _ = writeln!(out, "        public struct {}\n        {{", of.name());
        for (field, scalar, count) in members(of) {
            match count {
                1 => {
                    let _ = writeln!(out, "            public {} {field};", name(scalar));
                }
                count => {
                    let _ = writeln!(out, "            [MarshalAs(UnmanagedType.ByValArray, SizeConst = {count})]");
                    let _ = writeln!(out, "            public {}[] {field};", name(scalar));
                }
            }
        }
        // Bytes as Marshal.SizeOf counts them; a program may compare.
        let _ = writeln!(out, "            public const int Size = {};", size(of));
        let _ = writeln!(out, "        }}\n");
    }
}

/// Bytes of a struct where a `long` has 32 bits.
pub fn size(of: Type) -> usize {
    let bytes = |scalar: Scalar| match scalar {
        Scalar::Short | Scalar::UShort => 2usize,
        Scalar::Long | Scalar::ULong => 4,
        Scalar::Double => 8,
    };
    let mut end = 0usize;
    for (_, scalar, count) in members(of) {
        end = end.next_multiple_of(bytes(scalar)) + count * bytes(scalar);
    }
    end.next_multiple_of(8)
}

/// The text of the file.
pub fn declarations() -> String {
    let mut out = String::from(
        "// gts.cs: the functions of libgts32 for C#. Generated by `cargo xtask c-api`: change the tables of functions, not this.\n\
         // libgts32 has a long of 32 bits everywhere. libgts has the platform's: on Linux 64\n\
         // bits, which overwrites memory here.\n\
         // BEAMTICK_CARDS: the functions for several cards, GT_x(cardNum, ...).\n\
         using System;\nusing System.Runtime.InteropServices;\nusing System.Text;\n\nnamespace gts\n{\n    public static class mc\n    {\n        \
         const string Library = \"gts32\";\n\n        \
         // A power or a bound that is left out, where that differs from 0.\n        \
         public const double GT_NOT_GIVEN = double.MinValue;\n",
    );
    for (name, value) in CONSTANTS {
        let _ = writeln!(out, "        public const short {name} = {value};");
    }
    out.push('\n');
    structs(&mut out);
    let families = [("#if !BEAMTICK_CARDS\n", &[Form::Gt, Form::Gtn][..]), ("#else\n", &[Form::Cards])];
    for (condition, forms) in families {
        out += condition;
        for prototype in forms.iter().flat_map(|form| all(*form)) {
            declare(&mut out, &prototype);
        }
    }
    out += "#endif\n    }\n}\n";
    out
}
