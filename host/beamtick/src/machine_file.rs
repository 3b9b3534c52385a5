//! `beamtick machine`: a machine file from questions, and what one says.
//!
//! In: answers on the standard input or from the command line. Out: a commented file. Fails: a
//! wrong answer is named with its limit and asked again, or ends the program where nobody is asked.
//! Then nothing is written.
use crate::Failure;
use crate::command_line::{MachineAction, MachineFile, NewMachine};
use crate::input::{self, Role};
use machine::{Machine, Question};
use std::io::{BufRead, ErrorKind, Write};
use std::path::Path;
use trace::{AxisName, Millimetres};

/// Does what the command line says.
pub fn obey(arguments: &MachineFile) -> Result<(), Failure> {
    match &arguments.action {
        MachineAction::New(new) => write(new),
        MachineAction::Check { file } => {
            say!("{}", machine::show(&open(file, None)?).trim_end());
            Ok(())
        }
    }
}

/// Reads a machine file; `laser` is the one that is chosen.
pub fn open(path: &Path, laser: Option<&str>) -> Result<Machine, Failure> {
    let name = path.display().to_string();
    let text = input::read(path, Role::Machine).map_err(|error| {
        let help = match error.kind() {
            ErrorKind::NotFound => format!("; `beamtick machine new {name}` writes one"),
            _ => String::new(),
        };
        Failure::Input(format!("{name}: the machine file cannot be read: {error}{help}"))
    })?;
    let text = String::from_utf8(text)
        .map_err(|_| Failure::Input(format!("{name}: the machine file is not UTF-8 text; save it as UTF-8")))?;
    Machine::read_for(&name, &text, laser).map_err(Failure::Input)
}

/// The axes in mm.
pub fn millimetres(machine: &Machine) -> Vec<Millimetres> {
    let axis = |axis: &machine::Axis| Millimetres {
        axis: AxisName { core: 1, axis: axis.number },
        letter: axis.letter,
        per_mm: if axis.reversed { -axis.steps_per_mm } else { axis.steps_per_mm },
        zero: axis.home,
    };
    machine.axes.iter().map(axis).collect()
}

fn write(new: &NewMachine) -> Result<(), Failure> {
    let name = new.file.display().to_string();
    let is_printed = input::is_standard(&new.file);
    if is_printed && !new.yes {
        let why = "questions and the file would both go to the standard output; add --yes";
        return Err(Failure::Input(format!("machine new -: {why}")));
    }
    if !is_printed && new.file.exists() {
        return Err(Failure::Input(format!("{name}: the file exists; name another one, or remove it")));
    }
    let mut questions = machine::questions(&new.axes, !new.no_laser);
    let mut answered = Vec::new();
    for answer in &new.set {
        let wrong = || Failure::Input(format!("--set {answer}: it is KEY=VALUE, as axes.x.steps_per_mm=160"));
        let (key, value) = answer.split_once('=').ok_or_else(wrong)?;
        let keys: Vec<String> = questions.iter().map(|question| question.key.clone()).collect();
        let Some(question) = questions.iter_mut().find(|question| question.key == key.trim()) else {
            return Err(Failure::Input(format!(
                "--set {answer}: there is no key `{key}`; keys are {}",
                keys.join(", ")
            )));
        };
        question.value = as_toml(value);
        let wrong = |why: String| Failure::Input(format!("--set {answer}: {why}"));
        machine::is_value(&question.value).map_err(wrong)?;
        answered.push(question.key.clone());
    }
    machine::suit_laser(&mut questions, &answered);
    if !new.yes {
        ask(&mut questions, &mut answered)?;
    }
    let (text, machine) =
        machine::write(&questions).map_err(|why| Failure::Input(format!("{why}; nothing was written")))?;
    if is_printed {
        say!("{}", text.trim_end());
        return Ok(());
    }
    std::fs::File::create_new(&new.file)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| Failure::Input(format!("{name}: cannot be written: {error}")))?;
    say!("{}{name}: written", machine::show(&machine));
    Ok(())
}

/// Asks all that `answered` does not name; an empty line takes the usual answer. What a later
/// answer makes wrong is asked again at the end, so that no answer is lost.
fn ask(questions: &mut [Question], answered: &mut Vec<String>) -> Result<(), Failure> {
    let mut lines = std::io::stdin().lock().lines();
    for at in 0..questions.len() {
        if !answered.contains(&questions[at].key) {
            one(questions, at, &mut lines)?;
            answered.push(questions[at].key.clone());
        }
        if questions[at].key == "laser.mode" {
            machine::suit_laser(questions, answered);
        }
    }
    while let Err(error) = machine::write(questions) {
        let named = |question: &Question| {
            let (table, key) = question.key.rsplit_once('.').unwrap_or(("", &question.key));
            // A key that is missing is named after its table.
            let missing = [format!("{table} has no {key};"), format!("{table} cannot be read: missing field `{key}`")];
            error.starts_with(&format!("{} ", question.key)) || missing.iter().any(|text| error.starts_with(text))
        };
        let Some(at) = questions.iter().position(named) else {
            return Err(Failure::Input(format!("{error}; nothing was written")));
        };
        complain!("{error}");
        let before = questions[at].value.clone();
        one(questions, at, &mut lines)?;
        if questions[at].value == before {
            return Err(Failure::Input(format!("{error}; nothing was written")));
        }
    }
    Ok(())
}

/// Asks for one answer until it is a right one, as far as those before it say.
fn one(
    questions: &mut [Question],
    at: usize,
    lines: &mut impl Iterator<Item = std::io::Result<String>>,
) -> Result<(), Failure> {
    loop {
        let question = questions[at].clone();
        let usual = if question.value.is_empty() { "none" } else { &question.value };
        say!("{}: {} [{usual}]", question.key, question.meaning);
        let line = lines.next().transpose().map_err(|error| Failure::Input(format!("no answer: {error}")))?;
        let Some(line) = line else {
            let text =
                format!("{}: the input ended here; --yes takes the usual answers. Nothing was written", question.key);
            return Err(Failure::Input(text));
        };
        if line.trim().is_empty() {
            return Ok(());
        }
        let value = as_toml(&line);
        if let Err(why) = machine::is_value(&value) {
            complain!("{} is `{}`: {why}", question.key, line.trim().chars().take(40).collect::<String>());
            continue;
        }
        questions[at].value = value;
        // Limits may depend on answers that are to come: a fault counts where this answer made it.
        match machine::write(questions) {
            Err(error) if error.starts_with(&format!("{} ", question.key)) && questions[at] != question => {
                complain!("{error}");
                questions[at] = question;
            }
            _ => return Ok(()),
        }
    }
}

/// An answer as TOML: words are quoted, what is TOML already stays, `-` leaves the key out.
fn as_toml(answer: &str) -> String {
    let answer = answer.trim();
    if answer == "-" {
        return String::new();
    }
    let begins = |letter: char| letter.is_ascii_digit() || "+-.[\"'".contains(letter);
    let is_value = answer.is_empty() || answer.starts_with(begins) || ["true", "false"].contains(&answer);
    if is_value { answer.to_owned() } else { format!("\"{}\"", answer.replace(['"', '\\'], "")) }
}
