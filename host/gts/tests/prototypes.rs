//! The headers against the specification's own list (`prototypes.txt`), and both against what the
//! library exports.

mod toolchain;

use std::collections::BTreeMap;
use std::fmt::Write;
use toolchain::{Language, build, output, root};

/// A parameter's type, and whether it has a default.
type Parameter = (String, bool);

/// Symbol to parameters, as a header declares them.
fn declared(header: &str) -> BTreeMap<String, Vec<Parameter>> {
    let mut found = BTreeMap::new();
    for line in header.lines().filter_map(|line| line.strip_prefix("GT_API GT")) {
        let (name, rest) = line.split_once('(').unwrap();
        let list = rest.strip_suffix(");").unwrap();
        let parameters = list.split(", ").filter(|text| *text != "void").map(|text| {
            let (declaration, default) = text.split_once(" GT_DEFAULT").map_or((text, false), |(text, _)| (text, true));
            let (of, name) = declaration.rsplit_once(' ').unwrap();
            let star = if name.starts_with("**") {
                "**"
            } else if name.starts_with('*') {
                "*"
            } else {
                ""
            };
            (format!("{of}{star}"), default)
        });
        found.insert(format!("GT{name}"), parameters.collect());
    }
    found
}

/// A word of the list as C has it.
fn spelled(word: &str) -> Parameter {
    let default = word.ends_with('=');
    let word = word.trim_end_matches('=');
    let (plain, star) = if word.starts_with("char") {
        (word, "")
    } else {
        word.strip_suffix('*').map_or((word, ""), |word| (word, "*"))
    };
    let of = match plain {
        "s" => "short",
        "us" => "unsigned short",
        "l" => "long",
        "ul" => "unsigned long",
        "d" => "double",
        "text" => "const char*",
        other => other,
    };
    (format!("{of}{star}"), default)
}

/// Symbol to parameters, and the commands that the manuals document, as the list has them.
fn specified() -> (BTreeMap<String, Vec<Parameter>>, Vec<String>) {
    let (mut found, mut documented) = (BTreeMap::new(), Vec::new());
    let lines: Vec<&str> =
        include_str!("prototypes.txt").lines().filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    for line in &lines {
        let mut words = line.split_whitespace().peekable();
        let name = words.next().unwrap();
        if words.next_if_eq(&"!").is_some() {
            documented.push(name.to_owned());
        }
        let parameters: Vec<Parameter> = words.map(spelled).collect();
        if name.starts_with("GTN_") {
            found.insert(name.to_owned(), parameters);
        } else {
            let own = lines.iter().any(|line| line.split_whitespace().next() == Some(&format!("GTN_{name}")));
            if !own {
                let core = std::iter::once(("short".to_owned(), false)).chain(parameters.iter().cloned());
                found.insert(format!("GTN_{name}"), core.collect());
            }
            found.insert(format!("GT_{name}"), parameters);
        }
    }
    (found, documented)
}

/// The same types, and every default that is wanted; more of them harm no program.
fn agree(found: Option<&Vec<Parameter>>, wanted: &[Parameter]) -> bool {
    found.is_some_and(|found| {
        found.len() == wanted.len()
            && found.iter().zip(wanted).all(|(found, wanted)| found.0 == wanted.0 && (found.1 || !wanted.1))
    })
}

#[test]
fn every_function_of_the_specification_is_declared_with_its_prototype() {
    let (wanted, documented) = specified();
    assert_eq!(documented.len(), 80, "the manuals document 80 commands");
    let one = declared(&gts::header::gts());
    let several = declared(&gts::header::cards());
    for (symbol, parameters) in &wanted {
        let found = one.get(symbol);
        assert!(agree(found, parameters), "{symbol} in gts.h: {found:?}, wanted {parameters:?}");
        if let Some(bare) = symbol.strip_prefix("GT_") {
            let with_card: Vec<Parameter> =
                std::iter::once(("short".to_owned(), false)).chain(parameters.iter().cloned()).collect();
            let found = several.get(symbol);
            assert!(agree(found, &with_card), "GT_{bare} in gts_cards.h: {found:?}, wanted {with_card:?}");
        }
    }
    for name in &documented {
        assert!(wanted.contains_key(&format!("GT_{name}")) && wanted.contains_key(&format!("GTN_{name}")), "{name}");
    }
}

#[test]
fn every_command_of_the_protocol_is_a_function() {
    // What the library does by itself, or puts into other words.
    let own = [
        "Version",
        "KeepAlive",
        "Choose",
        "GetFault",
        "GetEvents",
        "GetTickTime",
        "GetStack",
        "Sleep",
        "WaitStop",
        "ProgramStart",
        "ProgramClear",
        "ProgramStatus",
        "ProgramEnd",
        "Trace",
        "AxisStatus",
        "PtDataMany",
        "GetPtState",
        "LaserStatus",
        "LnXYMany",
        "LnXYZMany",
        "PathMany",
        "SimPlan",
        "GetWait",
        "CrdInfo",
    ];
    let one = declared(&gts::header::gts());
    for command in protocol::command::COMMANDS {
        let declared = one.contains_key(&format!("GTN_{}", command.name));
        assert!(declared != own.contains(&command.name), "{}", command.name);
    }
}

/// A program that takes the address of every function of a header.
fn program(header: &str, text: &str, skipped: &str) -> String {
    let names: Vec<String> = declared(text).into_keys().filter(|name| name != skipped).collect();
    let mut out = format!("#include \"{header}\"\n#include <stdio.h>\ntypedef void (*any)(void);\nany all[] = {{\n");
    for name in &names {
        let _ = writeln!(out, "    (any){name},");
    }
    let _ = write!(
        out,
        "}};\nint main(void)\n{{\n    unsigned n, found = 0;\n    for (n = 0; n < sizeof all / sizeof *all; n++) {{\n        \
         found += all[n] != 0;\n    }}\n    printf(\"%u of {}\\n\", found);\n    return 0;\n}}\n",
        names.len()
    );
    out
}

#[test]
fn every_declared_function_is_exported() {
    for (header, text) in [("gts.h", gts::header::gts()), ("gts_cards.h", gts::header::cards())] {
        let declared = declared(&text).len();
        let source = program(header, &text, "");
        let Some(built) = build(Language::C, &format!("exported_{}", header.trim_end_matches(".h")), &source) else {
            return;
        };
        assert_eq!(output(&built, &[]), format!("{declared} of {declared}\n"));
    }
}

#[test]
fn structs_and_defaults_are_those_of_the_manuals() {
    // Offsets of the known layout where `long` has 32 bits; with 64 only what stands after one
    // moves.
    let source = r#"
#include "gts.h"
#include <stdio.h>
#include <float.h>
int main(void)
{
    static double table[4] = {0, 0, 0, 0};
    printf("%d %d %d %d\n", (int)sizeof(TTrapPrm), (int)offsetof(TTrapPrm, smoothTime), (int)sizeof(TJogPrm),
        (int)offsetof(TJogPrm, smooth));
    printf("%d %d %d %d %d %d\n", (int)offsetof(TCrdPrm, profile), (int)offsetof(TCrdPrm, synVelMax),
        (int)offsetof(TCrdPrm, evenTime), (int)offsetof(TCrdPrm, setOriginFlag),
        (int)((offsetof(TCrdPrm, originPos) - 44) % sizeof(long)), (int)(sizeof(((TCrdPrm *)0)->originPos) / sizeof(long)));
    printf("%d\n", sizeof(long) == 4 ? (int)sizeof(TCrdData) : 200);
    printf("%d\n", GT_NOT_GIVEN == -DBL_MAX);
    /* Both manuals' numbers of parameters. */
    printf("%d %d %d %d\n", GT_LaserPowerMode(0, 100, 10, 0), GT_LaserPowerMode(0, 100, 10, 0, 0),
        GT_SetLaserDisRatio(table, 0), GT_SetLaserDisRatio(table, 10, 100, 0));
    printf("%d %d %d\n", GTN_PtData(1, 1, 10.0, 10), GT_BufLaserFollowMode(1), GT_GetPrfPos(1, table));
    return 0;
}
"#;
    let Some(built) = build(Language::Cpp, "structs", source) else { return };
    let closed = "-7 -7 -7 -7\n-7 -7 -7\n";
    let text = output(&built, &[]);
    let layout = "32 24 24 16\n2 24 40 42 4 8\n200\n1\n";
    assert_eq!(text, format!("{layout}{closed}"));
}

/// A member of a struct and where it begins.
type Offset = (&'static str, usize);

#[test]
fn a_long_of_32_bits_gives_the_manuals_layouts() {
    // The structs of the header, with int where this machine's long has 64 bits.
    let header = std::fs::read_to_string(root().join("host/gts/include/gts.h")).unwrap();
    let (begin, end) = (header.find("typedef struct TTrapPrm").unwrap(), header.find("} TCrdData;").unwrap());
    let structs = header[begin..end].replace(" long ", " int ");
    let mut source = format!("#include <stddef.h>\n#include <stdio.h>\n{structs}}} TCrdData;\nint main(void)\n{{\n");
    // By hand, after the manuals' header: size, then offsets in the order of the members.
    let layouts: [(&str, usize, &[Offset]); 4] = [
        ("TTrapPrm", 32, &[("acc", 0), ("dec", 8), ("velStart", 16), ("smoothTime", 24)]),
        ("TJogPrm", 24, &[("acc", 0), ("dec", 8), ("smooth", 16)]),
        (
            "TCrdPrm",
            80,
            &[
                ("dimension", 0),
                ("profile", 2),
                ("synVelMax", 24),
                ("synAccMax", 32),
                ("evenTime", 40),
                ("setOriginFlag", 42),
                ("originPos", 44),
            ],
        ),
        (
            "TCrdData",
            200,
            &[
                ("motionType", 0),
                ("circlePlat", 2),
                ("pos", 4),
                ("radius", 40),
                ("circleDir", 48),
                ("center", 56),
                ("vel", 80),
                ("acc", 88),
                ("velEndZero", 96),
                ("operation", 98),
                ("cos", 112),
                ("velEnd", 176),
                ("velEndAdjust", 184),
                ("r", 192),
            ],
        ),
    ];
    let mut wanted = String::new();
    for (name, size, members) in layouts {
        let _ = writeln!(source, "    printf(\"{name} %d\\n\", (int)sizeof({name}));");
        let _ = writeln!(wanted, "{name} {size}");
        for (member, offset) in members {
            let _ = writeln!(source, "    printf(\"{name}.{member} %d\\n\", (int)offsetof({name}, {member}));");
            let _ = writeln!(wanted, "{name}.{member} {offset}");
        }
    }
    source += "    return 0;\n}\n";
    let Some(built) = build(Language::C, "layouts", &source) else { return };
    assert_eq!(output(&built, &[]), wanted);
}
