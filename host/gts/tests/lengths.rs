//! Calls with arrays, of every length at and beyond the limits, through the C library.

#[path = "../../job/tests/lengths/mod.rs"]
mod lengths;
mod toolchain;

use lengths::Length;
use std::fmt::Write;
use toolchain::{Language, build, output};

fn program(all: &[&Length]) -> String {
    let mut text = String::from(
        "#include \"gts.h\"\n#include <windows.h>\n#include <stdio.h>\nstatic char text[300];\n\
         static void report(const char *name, short code)\n{\n    text[0] = 0;\n    if (code) GT_GetLastReason(text, 300);\n    \
         printf(\"%s|%d|%s\\n\", name, code, text);\n}\n",
    );
    for (number, Length { name, data, before, call, after, .. }) in all.iter().enumerate() {
        let before = before.replace("GTN_", "if (!code) code = GTN_");
        let _ = write!(
            text,
            "static void call{number}(void)\n{{\nshort code = 0;\n{data}{before}if (code) report(\"before {name}\", code);\n\
             code = {call};\nreport(\"{name}\", code);\n{after}}}\n"
        );
    }
    text += "int main(void)\n{\nif (GTN_Open(5, 1)) return 1;\n";
    for number in 0..all.len() {
        let _ = writeln!(text, "call{number}();");
    }
    text + "return GTN_Close();\n}\n"
}

#[test]
fn every_length_is_taken_or_refused() {
    let functions = lengths::all();
    let all: Vec<&Length> = functions.iter().flatten().collect();
    let Some(built) = build(Language::C, "lengths", &program(&all)) else { return };
    let said = output(&built, &[("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_FAMILY", "gus")]);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), all.len(), "{said}");
    let mut wrong = Vec::new();
    for (Length { name, code, .. }, line) in all.iter().zip(&lines) {
        let refusal_names_the_limit = *code == 0 || line.contains("count is ");
        if !line.starts_with(&format!("{name}|{code}|")) || !refusal_names_the_limit || line.contains("bytes") {
            wrong.push(format!("{line}: not {code}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
