//! Every function of every family: before Open, with parameters that nothing has, and done as it is
//! meant.

mod toolchain;

use gts::more::Class;
use gts::prototype::{Form, Kind, Prototype, all};
use std::fmt::Write;
use toolchain::{Language, build, build_file, output, root};

const FAST: (&str, &str) = ("BEAMTICK_LINK", "virtual:max");
/// Done or answered by the library itself, whatever is open.
const OWN: [&str; 3] = ["Open", "Close", "GetLastReason"];

/// A call with parameters that no controller has: numbers out of range, addresses of something.
fn call(prototype: &Prototype) -> String {
    let arguments = prototype.parameters().into_iter().map(|argument| match argument.kind {
        _ if argument.name == "cardNum" => "2".to_owned(),
        Kind::Value(of) => match of.name() {
            "short" => "(short)-99".to_owned(),
            "unsigned short" => "(unsigned short)60000".to_owned(),
            "long" => "-99L".to_owned(),
            "unsigned long" => "4000000000UL".to_owned(),
            _ => "none".to_owned(),
        },
        Kind::Text => "\"no-such-file\"".to_owned(),
        Kind::Room => "text".to_owned(),
        Kind::TextAddress => "&address".to_owned(),
        Kind::Array(of, _) | Kind::Fixed(of, _) | Kind::Out(of) => format!("({} *)room", of.name()),
        Kind::Struct(of) | Kind::OutStruct(of) => format!("({} *)room", of.name()),
        Kind::Working => "0".to_owned(),
    });
    let list: Vec<String> = arguments.collect();
    format!("{}({})", prototype.symbol().replace("GTM_", "GT_"), list.join(", "))
}

/// A program that makes every call of some families and prints the return values.
fn program(header: &str, forms: &[Form], open: &str) -> String {
    let mut text = format!(
        "#include \"{header}\"\n#include <math.h>\n#include <stdio.h>\n#include <string.h>\nstatic double room[4096];\nstatic char text[300];\n\
         static char *address;\nint main(void)\n{{\n    double none = (double)NAN;\n    short code;\n    (void)address;\n    (void)none;\n    {open}\n"
    );
    for form in forms {
        for prototype in all(*form).filter(|prototype| !OWN.contains(&prototype.function.name)) {
            let reason =
                if *form == Form::Cards { "GT_GetLastReason(2, text, 300)" } else { "GT_GetLastReason(text, 300)" };
            let _ = writeln!(
                text,
                "    memset(room, 0, sizeof room);\n    text[0] = 0;\n    code = {};\n    {reason};\n    printf(\"{} %d %s\\n\", code, code ? text : \"\");",
                call(&prototype),
                prototype.symbol()
            );
        }
    }
    text.push_str("    return 0;\n}\n");
    text
}

fn lines(name: &str, text: &str) -> Option<Vec<(String, i32, String)>> {
    let built = build(Language::C, name, text)?;
    let output = output(&built, &[FAST]);
    let parse = |line: &str| {
        let mut words = line.splitn(3, ' ');
        let symbol = words.next().unwrap().to_owned();
        (symbol, words.next().unwrap().parse().unwrap(), words.next().unwrap_or("").to_owned())
    };
    Some(output.lines().map(parse).collect())
}

#[test]
fn nothing_is_done_before_open() {
    for (header, forms) in [("gts.h", &[Form::Gt, Form::Gtn][..]), ("gts_cards.h", &[Form::Cards][..])] {
        let Some(lines) = lines("closed", &program(header, forms, "")) else { return };
        assert!(lines.len() > 150);
        for (symbol, code, reason) in lines {
            assert_eq!(code, -7, "{symbol}: {reason}");
            assert!(reason.contains("no controller is open"), "{symbol}: {reason}");
        }
    }
}

#[test]
fn what_nothing_has_is_refused_by_every_function() {
    // Nothing of theirs can be wrong, or the bits are all right.
    let harmless = ["Reset", "GetVersion", "GetClock", "GetLinkLoss", "Abort", "LmtSns", "HomeInit"];
    let timed = ["Delay", "DelayHighPrecision", "GetClockHighPrecision"];
    for (header, forms, open) in [
        ("gts.h", &[Form::Gt][..], "GT_Open(0, 1);"),
        ("gts.h", &[Form::Gtn][..], "GTN_Open(5, 1);"),
        ("gts_cards.h", &[Form::Cards][..], "GT_Open(2, 0, 1);"),
    ] {
        let Some(lines) = lines("refused", &program(header, forms, open)) else { return };
        for (symbol, code, reason) in lines {
            let name = symbol.split_once('_').unwrap().1;
            if harmless.contains(&name) || timed.contains(&name) {
                continue;
            }
            // 1: what is not there, whatever its parameters.
            if gts::more::row(name).is_some_and(|more| matches!(more.class, Class::Refused(_) | Class::OnlyZero(_))) {
                assert!(code == 1 || (code == 7 && reason.contains("core is -99")), "{symbol} = {code}: {reason}");
                continue;
            }
            // 8: a call that only the other family has.
            assert!(code == 7 || (code == 8 && reason.contains("family")), "{symbol} = {code}: {reason}");
            assert!(reason.contains(name) || reason.contains("family"), "{symbol}: {reason}");
        }
    }
}

#[test]
fn every_function_has_its_documented_effect() {
    let source = root().join("host/gts/tests/programs/every.cpp");
    let text = std::fs::read_to_string(&source).unwrap();
    for prototype in all(Form::Gt) {
        let symbol = format!("GT_{}(", prototype.function.name);
        assert!(text.contains(&symbol), "{symbol} is not called in every.cpp");
    }
    for family in ["gus", "lsr"] {
        let Some(built) = build_file(Language::Cpp, "every", &source, &["-Wpedantic"]) else { return };
        assert_eq!(output(&built, &[FAST, ("BEAMTICK_FAMILY", family)]), "all checks passed\n", "{family}");
    }
}
