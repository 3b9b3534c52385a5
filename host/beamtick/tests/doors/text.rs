//! The doors that take a text: a job, a program in C, a program in Python.

use crate::player::Programme;
use crate::program::{Call, Step, Value, format_of};
use crate::toolchain::{self, Language};
use crate::{Answer, Run, Trace};
use gts::prototype::{Form, Kind, prototype};
use job::api::{Param, Pass};
use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Between two calls, ms: a call that is done has acted.
pub const PAUSE_MS: u32 = 2;

/// Runs a job with `beamtick sim`.
pub fn job(name: &str, family: &str, steps: &[Step]) -> Run {
    let mut text = String::from("#pragma continue\nshort rtn;\n");
    let mut lines = HashMap::new();
    for (number, step) in steps.iter().enumerate() {
        match step {
            Step::Sleep(ms) => _ = writeln!(text, "Sleep({ms});"),
            Step::Wait { .. } => unreachable!("descriptions have none"),
            Step::Call(call) => {
                let given = job_values(number, call, &mut text);
                lines.insert(text.lines().count() + 1, number);
                let _ = writeln!(text, "rtn = GT_{}({});\nSleep({PAUSE_MS});", call.function.name, given.join(", "));
            }
        }
    }
    let file = root().join("examples").join(format!("doors-{name}-{family}.gts"));
    let trace = toolchain::scratch().join(format!("{name}-{family}-job.csv"));
    // Beside the configuration files that it names; gone before anybody looks.
    let file = Temporary::new(file, &text);
    let mut command = Command::new(env!("CARGO_BIN_EXE_beamtick"));
    command.arg("sim").arg(&file.0).args(["--profile", "gus", "--family", family, "--trace"]).arg(&trace);
    let output = command.output().unwrap();
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let failure = errors.find("\nerror").or_else(|| errors.find("Error: ")).unwrap_or(0);
    assert!(output.status.success(), "{name}: {}", &errors[failure..]);
    let answers = job_answers(steps.len(), &lines, &said, &errors);
    Run { answers, trace: Trace::read(&trace) }
}

/// Runs a program as a job that makes each call at the tick at which another door made it: `ticks`,
/// and one for the end. Calls of `left_out` are not made.
pub fn scheduled_job(
    name: &str,
    programme: &Programme,
    ticks: &[u32],
    left_out: &[usize],
    trace: &Path,
) -> Result<Vec<Answer>, String> {
    let mut text = format!("#pragma continue\n#pragma tick {}\nshort rtn;\n", programme.tick_us);
    let mut lines = HashMap::new();
    // Halves of ticks, so that no call stands on a boundary.
    let tick_us = f64::from(programme.tick_us);
    let (mut clock, mut count) = (0u64, 3);
    for (number, (step, tick)) in programme.steps.iter().map(Some).chain([None]).zip(ticks).enumerate() {
        let reads = matches!(step, Some(Step::Call(call)) if call.function.reads());
        let due = 2 * u64::from(tick - ticks[0]) + LEAD - 2 * u64::from(reads);
        let _ = writeln!(text, "Sleep({});", (due - clock) as f64 * tick_us / 2000.0);
        (clock, count) = (due, count + 1);
        if let Some(Step::Call(call)) = step
            && !left_out.contains(&number)
        {
            let before = text.len();
            let given = job_values(number, call, &mut text).join(", ");
            count += text[before..].lines().count() + 1;
            lines.insert(count, number);
            let name = call.function.name;
            let _ = match call.core {
                None => writeln!(text, "rtn = GT_{name}({given});"),
                Some(core) if given.is_empty() => writeln!(text, "rtn = GTN_{name}({core});"),
                Some(core) => writeln!(text, "rtn = GTN_{name}({core}, {given});"),
            };
        }
    }
    let file = Temporary::new(root().join("examples").join(format!("doors-{name}.gts")), &text);
    let mut command = Command::new(env!("CARGO_BIN_EXE_beamtick"));
    command.arg("sim").arg(&file.0).args(["--profile", programme.profile, "--family", programme.family, "--trace"]);
    let output = command.arg(trace).output().unwrap();
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let kept = toolchain::scratch().join(format!("doors-{name}.gts"));
    std::fs::write(&kept, &text).unwrap();
    // A job that is late makes its calls at other ticks than the other doors. But for a long table,
    // which is there when all of its messages are, and after which there is a pause.
    let table = |line: &str| line.contains("  1 late entry,") && line.contains("_Pvt");
    let late = |line: &&str| line.contains(", the worst by ") && !table(line) || line.contains(" overruns");
    let about = said.lines().find(late);
    // Light that a fault took is none of success, and the same through every door.
    let is_dark = output.status.code() == Some(1) && errors.contains("and light that the job asks for is missing");
    if !(output.status.success() || is_dark) || about.is_some() {
        let about = about.unwrap_or_default();
        return Err(format!("{}: {about}{errors}", kept.display()));
    }
    Ok(job_answers(programme.steps.len(), &lines, &said, &errors))
}

/// Half ticks before the first call of a scheduled job.
const LEAD: u64 = 41;

/// What a job said of the calls in these lines.
fn job_answers(steps: usize, lines: &HashMap<usize, usize>, said: &str, errors: &str) -> Vec<Answer> {
    let mut answers: Vec<Answer> = (0..steps).map(|_| Answer::default()).collect();
    let line_of = |place: &str| -> Option<usize> {
        let (_, rest) = place.split_once(".gts:")?;
        rest.split(':').next()?.trim().parse().ok()
    };
    for line in said.lines() {
        if let Some(step) = line_of(line).and_then(|line| lines.get(&line))
            && let Some((_, values)) = line.split_once(" = ")
        {
            answers[*step].values = numbers(values);
        }
    }
    let mut code = None;
    for line in errors.lines() {
        if let Some((_, rest)) = line.split_once(" returned ")
            && line.starts_with("Warning: GT")
        {
            let (number, reason) = rest.split_once(": ").unwrap();
            code = Some((number.parse().unwrap(), reason.to_owned()));
        } else if line.contains("╭─[")
            && let Some(step) = line_of(line).and_then(|line| lines.get(&line))
            && let Some((code, reason)) = code.take()
        {
            (answers[*step].code, answers[*step].reason) = (code, reason);
        }
    }
    answers
}

/// A file that is removed at the end.
struct Temporary(PathBuf);

impl Temporary {
    fn new(path: PathBuf, text: &str) -> Temporary {
        std::fs::write(&path, text).unwrap();
        Temporary(path)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Numbers of a line; names of fields and marks between them are passed over.
pub fn numbers(text: &str) -> Vec<f64> {
    let number = |word: &str| match word.strip_prefix("0x") {
        Some(hex) => u32::from_str_radix(hex, 16).ok().map(f64::from),
        None => word.parse().ok(),
    };
    text.split([' ', '/', ',']).filter_map(number).collect()
}

pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// What stands between the parentheses; what must be declared goes into `text` before it.
pub fn job_values(step: usize, call: &Call, text: &mut String) -> Vec<String> {
    let mut given = Vec::new();
    for (place, (param, value)) in call.function.params.iter().zip(&call.values).enumerate() {
        let name = format!("v{step}_{place}");
        given.push(match (param.pass, value) {
            (Pass::Many(of, _) | Pass::Fixed(of, _), Value::List(values)) => {
                // An array of no elements cannot be declared.
                let values = if values.is_empty() { "0".to_owned() } else { values.join(", ") };
                let length = values.split(',').count();
                let _ = writeln!(text, "{} {name}[{length}] = {{{values}}};", of.name());
                name
            }
            (Pass::Struct(of) | Pass::StructOrNull(of), Value::Fields(fields)) => {
                let _ = writeln!(text, "{} {name};", of.name());
                // A job has no memset: every member is set.
                for (field, _, count) in of.fields() {
                    let values = fields.iter().find(|(of, _)| of == field).map_or(&[][..], |(_, values)| values);
                    for n in 0..*count {
                        let index = if *count > 1 { format!("[{n}]") } else { String::new() };
                        let value = values.get(n).map_or("0", String::as_str);
                        let _ = writeln!(text, "{name}.{field}{index} = {value};");
                    }
                }
                format!("&{name}")
            }
            (Pass::OutStruct(of), _) => {
                let _ = writeln!(text, "{} {name};", of.name());
                format!("&{name}")
            }
            (_, Value::Number(number)) => number.clone(),
            (_, Value::Text(text)) => format!("\"{text}\""),
            (_, Value::Out) => {
                let _ = writeln!(text, "double {name}[{}];", call.filled().max(1));
                name
            }
            // What comes last is left out.
            (_, Value::Null) if is_last(call, place) => continue,
            _ => "NULL".to_owned(),
        });
    }
    given
}

fn is_last(call: &Call, place: usize) -> bool {
    call.values[place..].iter().all(|value| *value == Value::Null)
        && call.function.params[place].default.is_some()
        && !matches!(call.function.params[place].pass, Pass::Fixed(..))
}

/// Builds and runs a program in C; nothing where there is no compiler.
pub fn c(name: &str, family: &str, steps: &[Step]) -> Option<Run> {
    let mut text = String::from(
        "#include \"gts.h\"\n#include <windows.h>\n#include <stdio.h>\n#include <string.h>\nstatic char said[1024];\n\
         static void show(int step, short code)\n{\n    said[0] = 0;\n    if (code) GT_GetLastReason(said, sizeof said);\n    \
         printf(\"\\n%d %d %s|\", step, code, said);\n}\nint main(void)\n{\n    show(-1, GT_Open(0, 1));\n",
    );
    for (number, step) in steps.iter().enumerate() {
        match step {
            Step::Sleep(ms) => _ = writeln!(text, "    Sleep({ms});"),
            Step::Wait { .. } => unreachable!("descriptions have none"),
            Step::Call(call) => c_call(number, call, &mut text),
        }
    }
    text.push_str("    GT_Close();\n    return 0;\n}\n");
    let source = toolchain::scratch().join(format!("{name}-{family}.c"));
    std::fs::write(&source, &text).unwrap();
    let built = toolchain::build_file(Language::C, &format!("{name}-{family}"), &source, &["-Wno-unused-variable"])?;
    let trace = toolchain::scratch().join(format!("{name}-{family}-c.csv"));
    let said = run(toolchain::command(&built, &[]), family, &trace);
    Some(Run { answers: answers(&said, steps.len()), trace: Trace::read(&trace) })
}

fn run(mut command: Command, family: &str, trace: &Path) -> String {
    command.env("BEAMTICK_LINK", "virtual:max").env("BEAMTICK_FAMILY", family).env("BEAMTICK_TRACE", trace);
    toolchain::output_of(&mut command)
}

/// Lines `step code reason|values`.
fn answers(said: &str, steps: usize) -> Vec<Answer> {
    let mut answers: Vec<Answer> = (0..steps).map(|_| Answer::default()).collect();
    for line in said.lines().filter(|line| !line.is_empty()) {
        let (head, values) = line.split_once('|').unwrap_or_else(|| panic!("{line}"));
        let mut words = head.splitn(3, ' ');
        let (step, code): (i64, i32) = (words.next().unwrap().parse().unwrap(), words.next().unwrap().parse().unwrap());
        let reason = words.next().unwrap_or("").to_owned();
        match usize::try_from(step) {
            Ok(step) => answers[step] = Answer { code, reason, values: numbers(values) },
            Err(_) => assert_eq!(code, 0, "it cannot be opened: {reason}"),
        }
    }
    answers
}

fn c_call(step: usize, call: &Call, text: &mut String) {
    let prototype = prototype(call.function, Form::Gt);
    assert_eq!(prototype.arguments.len(), call.values.len(), "GT_{} has every parameter", call.function.name);
    let (mut given, mut shown) = (Vec::new(), String::new());
    text.push_str("    {\n");
    for (place, (argument, value)) in prototype.arguments.iter().zip(&call.values).enumerate() {
        let name = format!("v{place}");
        given.push(match (argument.kind, value) {
            (Kind::Value(_), Value::Number(number)) => number.clone(),
            (Kind::Array(of, _) | Kind::Fixed(of, _), Value::List(values)) => {
                let values = if values.is_empty() { "0".to_owned() } else { values.join(", ") };
                let _ = writeln!(text, "    static {} {name}[] = {{{values}}};", of.name());
                name
            }
            (Kind::Struct(of), Value::Fields(fields)) => {
                let _ = writeln!(text, "    {} {name};\n    memset(&{name}, 0, sizeof {name});", of.name());
                for (field, values) in fields {
                    let array = of.fields().iter().any(|(of, _, count)| of == field && *count > 1);
                    for (n, value) in values.iter().enumerate() {
                        let index = if array { format!("[{n}]") } else { String::new() };
                        let _ = writeln!(text, "    {name}.{field}{index} = {value};");
                    }
                }
                format!("&{name}")
            }
            (Kind::OutStruct(of), _) => {
                let _ = writeln!(text, "    {} {name};\n    memset(&{name}, 0, sizeof {name});", of.name());
                format!("&{name}")
            }
            (Kind::Out(of), Value::Out) => {
                let length = call.filled();
                let _ = writeln!(text, "    static {} {name}[{}];", of.name(), length.max(4096));
                let (format, kind) = format_of(of);
                let _ = writeln!(
                    shown,
                    "    for (int n = 0; code == 0 && n < {length}; n++) printf(\" {format}\", ({kind}){name}[n]);"
                );
                name
            }
            (Kind::TextAddress, _) => {
                let _ = writeln!(text, "    char *{name} = 0;");
                format!("&{name}")
            }
            (_, Value::Text(text)) => format!("\"{text}\""),
            (Kind::Working, _) if argument.name != "lookAheadBuf" => {
                let _ = writeln!(text, "    static double {name}[4096];");
                name
            }
            _ => "0".to_owned(),
        });
    }
    let list = given.join(", ");
    let _ = writeln!(
        text,
        "    short code = GT_{}({list});\n    show({step}, code);\n{shown}    Sleep({PAUSE_MS});\n    }}",
        call.function.name
    );
}

/// Runs a program in Python; nothing where there is none.
pub fn python(name: &str, family: &str, steps: &[Step]) -> Option<Run> {
    if Command::new("python3").arg("--version").output().is_err() {
        toolchain::skip("there is no python3");
        return None;
    }
    let mut text = String::from(
        "import beamtick as gts\n\ndef flat(value):\n    if value is None or isinstance(value, str):\n        return []\n    \
         if isinstance(value, (list, tuple)):\n        return [number for part in value for number in flat(part)]\n    \
         return [repr(value)] if isinstance(value, (int, float)) else []\n\n\
         def call(step, function, *values):\n    try:\n        found = function(*values)\n        \
         print(step, ' 0 |', ' '.join(flat(found)), sep='')\n    except gts.GtsError as error:\n        \
         print(step, ' ', error.code, ' ', error.reason, '|', sep='')\n    gts.sleep(PAUSE)\n\ngts.GT_Open()\n",
    )
    .replace("PAUSE", &PAUSE_MS.to_string());
    for (number, step) in steps.iter().enumerate() {
        match step {
            Step::Sleep(ms) => _ = writeln!(text, "gts.sleep({ms})"),
            Step::Wait { .. } => unreachable!("descriptions have none"),
            Step::Call(call) => {
                let given: Vec<String> =
                    call.function.params.iter().zip(&call.values).filter_map(python_value).collect();
                let given: String = given.iter().map(|value| format!(", {value}")).collect();
                let _ = writeln!(text, "call({number}, gts.GT_{}{given})", call.function.name);
            }
        }
    }
    text.push_str("gts.GT_Close()\n");
    let source = toolchain::scratch().join(format!("{name}-{family}.py"));
    std::fs::write(&source, &text).unwrap();
    let trace = toolchain::scratch().join(format!("{name}-{family}-python.csv"));
    let mut command = toolchain::command(Path::new("python3"), &[]);
    command.env("BEAMTICK_LIBRARY", toolchain::libraries().join("libgts.so"));
    command.env("PYTHONPATH", root().join("host/python")).env("PYTHONDONTWRITEBYTECODE", "1").arg(&source);
    let said = run(command, family, &trace);
    Some(Run { answers: answers(&said, steps.len()), trace: Trace::read(&trace) })
}

/// What Python has in this place; what a call fills, and what the library works in, it has not.
pub fn python_value((param, value): (&Param, &Value)) -> Option<String> {
    if matches!(param.pass, Pass::Out | Pass::OutStruct(_) | Pass::Working) {
        return None;
    }
    Some(match value {
        Value::Number(number) => number.clone(),
        Value::List(values) => format!("[{}]", values.join(", ")),
        Value::Fields(fields) => {
            let of = match param.pass {
                Pass::Struct(of) | Pass::StructOrNull(of) => of,
                _ => panic!("{} is no struct", param.name),
            };
            let field = |(name, values): &(String, Vec<String>)| {
                let array = of.fields().iter().any(|(of, _, count)| of == name && *count > 1);
                let values = values.join(", ");
                if array { format!("\"{name}\": [{values}]") } else { format!("\"{name}\": {values}") }
            };
            format!("{{{}}}", fields.iter().map(field).collect::<Vec<_>>().join(", "))
        }
        Value::Text(text) => format!("\"{text}\""),
        Value::Out | Value::Null => "None".to_owned(),
    })
}
