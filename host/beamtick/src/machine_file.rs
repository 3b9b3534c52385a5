//! `beamtick machine`: a machine file from questions, and what one says.
//!
//! In: answers on the standard input or from the command line. Out: a commented file. Fails: a
//! wrong answer is named with its limit and asked again, or ends the program where nobody is asked.
//! Then nothing is written.
use crate::command_line::{MachineAction, MachineFile, NewMachine};
use crate::{Failure, input};
use machine::{Machine, Question};
use std::io::{BufRead, Write};
use std::path::Path;

/// Does what the command line says.
pub fn obey(arguments: &MachineFile) -> Result<(), Failure> {
    match &arguments.action {
        MachineAction::New(new) => write(new),
        MachineAction::Check { file } => {
            say!("{}", machine::show(&open(file)?).trim_end());
            Ok(())
        }
    }
}

/// Reads a machine file.
pub fn open(path: &Path) -> Result<Machine, Failure> {
    let name = path.display().to_string();
    let text = input::read(path)
        .map_err(|error| Failure::Input(format!("{name}: the machine file cannot be read: {error}")))?;
    let text = String::from_utf8(text)
        .map_err(|_| Failure::Input(format!("{name}: the machine file is not UTF-8 text; save it as UTF-8")))?;
    Machine::read(&name, &text).map_err(Failure::Input)
}

fn write(new: &NewMachine) -> Result<(), Failure> {
    let name = new.file.display().to_string();
    if new.file.exists() {
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
        answered.push(question.key.clone());
    }
    if !new.yes {
        ask(&name, &mut questions, &answered)?;
    }
    let (text, machine) = machine::write(&name, &questions).map_err(Failure::Input)?;
    std::fs::File::create_new(&new.file)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| Failure::Input(format!("{name}: cannot be written: {error}")))?;
    say!("{}{name}: written", machine::show(&machine));
    Ok(())
}

/// Asks all that `answered` does not name; an empty line takes the usual answer.
fn ask(name: &str, questions: &mut [Question], answered: &[String]) -> Result<(), Failure> {
    let mut lines = std::io::stdin().lock().lines();
    let mut at = 0;
    while at < questions.len() {
        let question = questions[at].clone();
        if answered.contains(&question.key) {
            at += 1;
            continue;
        }
        let usual = if question.value.is_empty() { "none" } else { &question.value };
        say!("{}: {} [{usual}]", question.key, question.meaning);
        let line = lines.next().transpose().map_err(|error| Failure::Input(format!("no answer: {error}")))?;
        let Some(line) = line else {
            let text =
                format!("{}: the input ended here; --yes takes the usual answers. Nothing was written", question.key);
            return Err(Failure::Input(text));
        };
        if !line.trim().is_empty() {
            questions[at].value = as_toml(&line);
        }
        // Limits may depend on answers that are to come: a fault counts where this answer made it.
        match machine::write(name, questions) {
            Err(error) if error.contains(&format!(" {} ", question.key)) && questions[at] != question => {
                complain!("{error}");
                questions[at] = question;
            }
            _ => at += 1,
        }
    }
    Ok(())
}

/// An answer as TOML: words are quoted, what is TOML already stays.
fn as_toml(answer: &str) -> String {
    let answer = answer.trim();
    let begins = |letter: char| letter.is_ascii_digit() || "+-.[\"'".contains(letter);
    let is_value = answer.is_empty() || answer.starts_with(begins) || ["true", "false"].contains(&answer);
    if is_value { answer.to_owned() } else { format!("\"{}\"", answer.replace(['"', '\\'], "")) }
}
