//! The doors C and Python for many programs: one player in C, built once from the table of
//! functions, which reads programs and makes each call through the header; and one script for
//! Python. Both tell the controller's tick before each call, which the other doors then keep to.

use crate::program::{Call, Step, Value};
use crate::text::python_value;
use crate::toolchain::{self, Language};
use gts::prototype::{Form, Kind, Prototype, Scalar, members, prototype};
use job::api::{FUNCTIONS, Shape};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A wait for standstill ends after so many ms.
pub const PATIENCE_MS: u32 = 400;

/// A program, and where and as what it runs.
pub struct Programme {
    pub steps: Vec<Step>,
    pub tick_us: u32,
    pub profile: &'static str,
    pub family: &'static str,
    /// Functions have a core.
    pub cores: bool,
    /// PT data may travel in batches.
    pub batches: bool,
    /// Nothing moves: what is full stays full, and a job does not wait for room.
    pub rests: bool,
}

/// What a step gave; a step that is no call gives the tick alone.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reported {
    /// The controller's tick before it.
    pub tick: u32,
    pub code: i32,
    pub values: Vec<f64>,
    pub reason: String,
}

/// Room for arrays, and how a line's words become arguments.
const HEAD: &str = r#"#include "gts.h"
#include <windows.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static char line[1 << 20], *rest, said[1024];
static double room[1 << 17];
static size_t used;
static struct { void *at; char kind; int count; } outs[8];
static int nouts;
static char *word(void)
{
    char *begin = rest + strspn(rest, " \n");
    rest = begin + strcspn(begin, " \n");
    if (*rest) *rest++ = 0;
    return begin;
}
static long long whole(void) { return strtoll(word(), 0, 10); }
static double real(void) { return strtod(word(), 0); }
static void *take(size_t bytes)
{
    void *at = &room[used];
    used += bytes / sizeof(double) + 1;
    if (used > sizeof room / sizeof *room) exit(3);
    memset(at, 0, bytes);
    return at;
}
static void *out(char kind)
{
    char *count = word();
    if (*count != '*') return 0;
    int n = atoi(count + 1);
    outs[nouts].count = n;
    outs[nouts].kind = kind;
    outs[nouts].at = take(sizeof(double) * (n > 4096 ? n : 4096));
    return outs[nouts++].at;
}
"#;

/// How the player reads programs; the core of `GTN_` is its first word.
const TAIL: &str = r#"
static void tick(int step, int gtn)
{
    unsigned long clock = 0, loop = 0;
    short code = gtn ? GTN_GetClock(1, &clock, &loop) : GT_GetClock(&clock, &loop);
    if (code) exit(4);
    printf("%d %lu ", step, loop);
}
static int moving(int gtn, int core, unsigned long axes)
{
    long sts[32] = {0};
    short code = gtn ? GTN_GetSts((short)core, 1, sts, 8, 0) : GT_GetSts(1, sts, 8, 0);
    for (int axis = 0; axis < 8; axis++)
        if (!code && (axes >> axis & 1) && (sts[axis] & 1 << 10)) return 1;
    return 0;
}
int main(void)
{
    int gtn = 0;
    while (fgets(line, sizeof line, stdin)) {
        rest = line;
        char *verb = word();
        if (!strcmp(verb, "set")) {
            char *name = word();
            setenv(name, word(), 1);
        } else if (!strcmp(verb, "open")) {
            gtn = (int)whole();
            if (gtn ? GTN_Open(5, 1) : GT_Open(0, 1)) { GT_GetLastReason(said, sizeof said); puts(said); return 5; }
            long us = (long)whole();
            if (gtn ? GTN_SetTick(1, us) : GT_SetTick(us)) return 6;
        } else if (!strcmp(verb, "close")) {
            if (gtn ? GTN_Close() : GT_Close()) return 7;
            puts("end");
        } else if (!strcmp(verb, "sleep")) {
            tick((int)whole(), gtn);
            puts("0||");
            Sleep((unsigned)whole());
        } else if (!strcmp(verb, "wait")) {
            tick((int)whole(), gtn);
            puts("0||");
            int core = (int)whole(), left = (int)whole();
            unsigned long axes = (unsigned long)whole();
            while (left-- > 0 && moving(gtn, core, axes)) Sleep(1);
        } else if (!strcmp(verb, "call")) {
            int step = (int)whole();
            char *name = word();
            used = 0;
            nouts = 0;
            unsigned n = 0;
            while (strcmp(functions[n].name, name)) if (++n == sizeof functions / sizeof *functions) return 8;
            tick(step, gtn);
            short code = functions[n].call();
            said[0] = 0;
            if (code) GT_GetLastReason(said, sizeof said);
            printf("%d|", code);
            for (int o = 0; code == 0 && o < nouts; o++)
                for (int i = 0; i < outs[o].count; i++) switch (outs[o].kind) {
                    case 's': printf(" %d", ((short *)outs[o].at)[i]); break;
                    case 'u': printf(" %u", ((unsigned short *)outs[o].at)[i]); break;
                    case 'l': printf(" %ld", ((long *)outs[o].at)[i]); break;
                    case 'U': printf(" %lu", ((unsigned long *)outs[o].at)[i]); break;
                    default: printf(" %.17g", ((double *)outs[o].at)[i]);
                }
            printf("|%s\n", said);
        }
    }
    return 0;
}
"#;

fn kind_of(of: Scalar) -> char {
    match of {
        Scalar::Short => 's',
        Scalar::UShort => 'u',
        Scalar::Long => 'l',
        Scalar::ULong => 'U',
        Scalar::Double => 'd',
    }
}

fn number_of(of: Scalar) -> String {
    match of {
        Scalar::Double => "real()".to_owned(),
        of => format!("({})whole()", of.name()),
    }
}

/// The function of the player that makes a call.
fn stub(prototype: &Prototype) -> String {
    let mut text = format!("static short call_{}(void)\n{{\n", prototype.symbol());
    let mut names = Vec::new();
    if prototype.leads {
        text.push_str("    short core = (short)whole();\n");
        names.push("core".to_owned());
    }
    for (place, argument) in prototype.arguments.iter().enumerate() {
        let name = format!("v{place}");
        let _ = match argument.kind {
            Kind::Value(of) => writeln!(text, "    {} {name} = {};", of.name(), number_of(of)),
            Kind::Array(of, _) | Kind::Fixed(of, _) => writeln!(
                text,
                "    {of} *{name} = 0;\n    {{\n        char *count = word();\n        int n = atoi(count + 1);\n        \
                 if (*count == '[') {name} = take(sizeof({of}) * (n + 1));\n        \
                 for (int i = 0; *count == '[' && i < n; i++) {name}[i] = {};\n    }}",
                number_of(of),
                of = of.name()
            ),
            Kind::Struct(of) => {
                let _ = writeln!(
                    text,
                    "    {of} room_{name}, *{name} = 0;\n    memset(&room_{name}, 0, sizeof room_{name});\n    \
                     if (*word() == '{{') {{\n        {name} = &room_{name};",
                    of = of.name()
                );
                for (member, _, count) in of.fields() {
                    let scalar = members(of).iter().find(|(own, ..)| own == member).unwrap().1;
                    let index = if *count > 1 { "[i]" } else { "" };
                    let _ = writeln!(
                        text,
                        "        for (int i = 0; i < {count}; i++) {name}->{member}{index} = {};",
                        number_of(scalar)
                    );
                }
                writeln!(text, "    }}")
            }
            Kind::OutStruct(of) => {
                writeln!(text, "    {of} room_{name}, *{name} = &room_{name};\n    word();", of = of.name())
            }
            Kind::Out(of) => writeln!(text, "    {} *{name} = out('{}');", of.name(), kind_of(of)),
            Kind::Working if argument.name == "lookAheadBuf" => {
                writeln!(text, "    TCrdData *{name} = 0;\n    word();")
            }
            Kind::Working => writeln!(text, "    double *{name} = take(sizeof(double) * 1025);\n    word();"),
            Kind::Text => writeln!(text, "    const char *{name} = word();"),
            Kind::Room => writeln!(text, "    char *{name} = 0;\n    word();"),
            Kind::TextAddress => {
                writeln!(text, "    char *address_{name} = 0, **{name} = &address_{name};\n    word();")
            }
        };
        names.push(name);
    }
    let _ = writeln!(text, "    return {}({});\n}}", prototype.symbol(), names.join(", "));
    text
}

/// Builds the player; nothing where there is no compiler.
pub fn build() -> Option<PathBuf> {
    let mut text = HEAD.to_owned();
    let mut table = String::from("static const struct { const char *name; short (*call)(void); } functions[] = {\n");
    for function in FUNCTIONS.iter().filter(|function| function.shape != Shape::Host) {
        for form in [Form::Gt, Form::Gtn] {
            let prototype = prototype(function, form);
            text += &stub(&prototype);
            let _ = writeln!(table, "    {{\"{symbol}\", call_{symbol}}},", symbol = prototype.symbol());
        }
    }
    text += &table;
    text += "};\n";
    text += TAIL;
    let source = toolchain::scratch().join("player.c");
    std::fs::write(&source, &text).unwrap();
    // setenv is not of C99.
    let more = ["-D_POSIX_C_SOURCE=200809L", "-Wno-unused-function", "-O1"];
    toolchain::build_file(Language::C, "player", &source, &more)
}

/// The words of a call, in the order of its prototype's arguments.
fn words(call: &Call) -> String {
    let form = if call.core.is_some() { Form::Gtn } else { Form::Gt };
    let prototype = prototype(call.function, form);
    let mut text = prototype.symbol();
    if let Some(core) = call.core {
        let _ = write!(text, " {core}");
    }
    for argument in &prototype.arguments {
        let place = call.function.params.iter().position(|param| param.name == argument.name).unwrap();
        let _ = match (argument.kind, &call.values[place]) {
            (_, Value::Number(number)) => write!(text, " {number}"),
            (_, Value::List(list)) => write!(text, " [{} {}", list.len(), list.join(" ")),
            (Kind::Struct(of), Value::Fields(fields)) => {
                text.push_str(" {");
                for (member, _, count) in of.fields() {
                    let given = fields.iter().find(|(own, _)| own == member).map_or(&[][..], |(_, values)| values);
                    (0..*count).for_each(|n| _ = write!(text, " {}", given.get(n).map_or("0", String::as_str)));
                }
                Ok(())
            }
            (_, Value::Text(name)) => write!(text, " {name}"),
            (_, Value::Out) => write!(text, " *{}", call.filled()),
            _ => write!(text, " _"),
        };
    }
    text
}

fn settings(programme: &Programme, trace: &Path) -> [(&'static str, String); 5] {
    [
        ("BEAMTICK_LINK", "virtual:max".to_owned()),
        ("BEAMTICK_PROFILE", programme.profile.to_owned()),
        ("BEAMTICK_FAMILY", programme.family.to_owned()),
        ("BEAMTICK_BATCHES", if programme.batches { "on" } else { "off" }.to_owned()),
        ("BEAMTICK_TRACE", trace.display().to_string()),
    ]
}

/// Runs programs one after the other in one process; each has its trace in `traces`.
pub fn c(player: &Path, name: &str, programmes: &[Programme], traces: &[PathBuf]) -> Vec<Vec<Reported>> {
    let mut text = String::new();
    for (programme, trace) in programmes.iter().zip(traces) {
        settings(programme, trace).iter().for_each(|(name, value)| _ = writeln!(text, "set {name} {value}"));
        let _ = writeln!(text, "open {} {}", u8::from(programme.cores), programme.tick_us);
        for (number, step) in programme.steps.iter().enumerate() {
            let _ = match step {
                Step::Sleep(ms) => writeln!(text, "sleep {number} {ms}"),
                Step::Wait { core, axes } => writeln!(text, "wait {number} {core} {PATIENCE_MS} {axes}"),
                Step::Call(call) => writeln!(text, "call {number} {}", words(call)),
            };
        }
        // The tick at the end.
        let _ = writeln!(text, "sleep {} 0\nclose", programme.steps.len());
    }
    let input = toolchain::scratch().join(format!("{name}.calls"));
    std::fs::write(&input, text).unwrap();
    let mut command = toolchain::command(player, &[]);
    command.stdin(std::fs::File::open(&input).unwrap());
    let reported = reported(&toolchain::output_of(&mut command), programmes);
    let _ = std::fs::remove_file(&input);
    reported
}

/// The same in Python; nothing where there is none.
pub fn python(name: &str, programmes: &[Programme], traces: &[PathBuf]) -> Option<Vec<Vec<Reported>>> {
    if Command::new("python3").arg("--version").output().is_err() {
        toolchain::skip("there is no python3");
        return None;
    }
    let mut text = include_str!("player.py").to_owned();
    for (programme, trace) in programmes.iter().zip(traces) {
        for (name, value) in settings(programme, trace) {
            let _ = writeln!(text, "os.environ[{name:?}] = {value:?}");
        }
        let _ = writeln!(text, "begin({}, {})", if programme.cores { "True" } else { "False" }, programme.tick_us);
        for (number, step) in programme.steps.iter().enumerate() {
            match step {
                Step::Sleep(ms) => _ = writeln!(text, "sleep({number}, {ms})"),
                Step::Wait { core, axes } => _ = writeln!(text, "wait({number}, {core}, {PATIENCE_MS}, {axes})"),
                Step::Call(call) => {
                    let form = if call.core.is_some() { Form::Gtn } else { Form::Gt };
                    let prototype = prototype(call.function, form);
                    let given = call.function.params.iter().zip(&call.values);
                    // What this form has not is left out.
                    let given = given.filter(|(param, _)| prototype.arguments.iter().any(|own| own.name == param.name));
                    let core = call.core.map(|core| core.to_string());
                    let given: Vec<String> = core.into_iter().chain(given.filter_map(python_value)).collect();
                    let given: String = given.iter().map(|value| format!(", {value}")).collect();
                    let _ = writeln!(text, "call({number}, gts.{}{given})", prototype.symbol());
                }
            }
        }
        let _ = writeln!(text, "sleep({}, 0)\nend()", programme.steps.len());
    }
    let source = toolchain::scratch().join(format!("{name}.py"));
    std::fs::write(&source, &text).unwrap();
    let mut command = toolchain::command(Path::new("python3"), &[]);
    command.env("BEAMTICK_LIBRARY", toolchain::libraries().join("libgts.so"));
    command.env("PYTHONPATH", crate::text::root().join("host/python")).env("PYTHONDONTWRITEBYTECODE", "1").arg(&source);
    let reported = reported(&toolchain::output_of(&mut command), programmes);
    let _ = std::fs::remove_file(&source);
    Some(reported)
}

/// Lines `step tick code|values|reason`, and `end` after each program.
fn reported(said: &str, programmes: &[Programme]) -> Vec<Vec<Reported>> {
    let mut all = Vec::new();
    let mut steps = Vec::new();
    for line in said.lines() {
        if line == "end" {
            all.push(std::mem::take(&mut steps));
            continue;
        }
        let mut parts = line.splitn(3, '|');
        let mut next = || parts.next().unwrap_or_else(|| panic!("no answer: {line}"));
        let head: Vec<i64> = next().split_whitespace().map(|word| word.parse().unwrap()).collect();
        let values = crate::text::numbers(next());
        steps.push(Reported { tick: head[1] as u32, code: head[2] as i32, values, reason: next().to_owned() });
    }
    assert_eq!(all.len(), programmes.len(), "{said}");
    all
}
